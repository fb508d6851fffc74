//! Stability charts on all cores, row by row.

use librate::chart::{Border, Chart, Place};
use librate::model::{ModelError, Range};
use librate::{Error, report};

use super::args;
use super::output::write_file;
use super::threads::in_order;
use super::{Answer, Failure, Parsed, input, parsed, wrong_request};

fn wrong_map(message: String) -> Failure {
    let help = "write `--map NAME=a..b:count NAME=c..d:count`, for example `--map a=0..10:100 q=0..5:100`";
    wrong_request(message, help)
}

fn range(text: &str) -> Result<Range, Failure> {
    Range::parse(text).map_err(|error| wrong_map(error.to_string()))
}

/// `librate floquet --map`
pub(super) fn run(args: &args::Floquet, first: &str, second: &str) -> Result<Answer, Failure> {
    let ranges = [range(first)?, range(second)?];
    let Parsed { mut source, file, tables, settings } = parsed(&args.model, input::read_model(&args.model.file)?)?;
    let chart = match Chart::new(&file, &tables, &settings, ranges) {
        Ok(chart) => chart,
        Err(Error::Model(errors)) if matches!(errors.as_slice(), [ModelError::BadSetting { .. }]) => {
            let told: Vec<String> = errors.iter().map(ToString::to_string).collect();
            return Err(wrong_map(told.join("; ")));
        }
        Err(error) => return Err(Failure::Model(source, error.diagnostics())),
    };
    let count = chart.len()[0];
    let mut rows: Vec<Vec<Place>> = Vec::with_capacity(count);
    let worker = || {
        let mut worker = chart.worker();
        move |row| worker.row(row)
    };
    in_order(args.threads, count, "charting", worker, |row| {
        rows.push(row);
        Ok(())
    })?;
    if let Some(path) = &args.borders {
        let mut borders: Vec<Border> = Vec::new();
        let worker = || {
            let mut worker = chart.worker();
            let rows = &rows;
            move |row: usize| {
                let pair = [row, row + 1].map(|at| rows.get(at).map(Vec::as_slice));
                worker.borders(row, pair)
            }
        };
        in_order(args.threads, count, "finding the borders", worker, |own| {
            borders.extend(own);
            Ok(())
        })?;
        let text = report::borders_csv(&chart, &borders);
        write_file(path, &text, &mut source)?;
    }
    let text = if args.model.drawn { report::chart_svg(&chart, &rows) } else { report::chart_csv(&chart, &rows) };
    Ok(Answer::new(text, Some((source, Vec::new()))))
}
