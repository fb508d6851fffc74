//! Stability charts on all cores, row by row.

use librate::chart::{Chart, Place};
use librate::model::ModelError;
use librate::{Error, report};

use super::output::write_file;
use super::threads::all;
use super::{Answer, Failure, args, input, parsed, range, wrong_request};

const HELP: &str = "write `--map NAME=a..b:count NAME=c..d:count`, for example `--map a=0..10:100 q=0..5:100`";

/// `librate floquet --map`
pub(super) fn run(args: &args::Floquet, first: &str, second: &str) -> Result<Answer, Failure> {
    let ranges = [range(first, HELP)?, range(second, HELP)?];
    let (mut source, made) = parsed(&args.model, input::read_model(&args.model.file)?)?;
    let chart = Chart::new(&made, ranges).map_err(|error| match &error {
        Error::Model(errors) if matches!(errors[..], [ModelError::BadSetting { .. }]) => {
            wrong_request(errors[0].to_string(), HELP)
        }
        _ => Failure::Model(source.clone(), error.diagnostics()),
    })?;
    let count = chart.len()[0];
    let worker = || {
        let mut worker = chart.worker();
        move |row| worker.row(row)
    };
    let rows: Vec<Vec<Place>> = all(args.threads, count, "charting", worker, || Ok(()))?;
    if let Some(path) = &args.borders {
        let worker = || {
            let mut worker = chart.worker();
            let rows = &rows;
            move |row: usize| {
                let pair = [row, row + 1].map(|at| rows.get(at).map(Vec::as_slice));
                worker.borders(row, pair)
            }
        };
        let borders = all(args.threads, count, "finding the borders", worker, || Ok(()))?.concat();
        write_file(path, &report::borders_csv(&chart, &borders), &mut source)?;
    }
    let text =
        if args.model.drawn { report::chart_svg(&chart, &rows) } else { report::chart_csv(&chart, &rows, args.digits) };
    Ok(Answer::new(text, Some((source, Vec::new()))))
}
