//! Stability charts on all cores: rows are dealt out to threads as they come, and put together in order.

use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use librate::chart::{Border, Chart, Place};
use librate::model::{ModelError, Range};
use librate::{Error, report};

use super::args;
use super::output::write_file;
use super::progress::Counter;
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
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let threads = args.threads.unwrap_or(cores);
    let count = chart.len()[0];
    let rows: Vec<Vec<Place>> = on_all_cores(threads, count, "charting", || {
        let mut worker = chart.worker();
        move |row| worker.row(row)
    });
    if let Some(path) = &args.borders {
        let borders: Vec<Vec<Border>> = on_all_cores(threads, count, "finding the borders", || {
            let mut worker = chart.worker();
            let rows = &rows;
            move |row: usize| {
                let pair = [row, row + 1].map(|at| rows.get(at).map(Vec::as_slice));
                worker.borders(row, pair)
            }
        });
        let text = report::borders_csv(&chart, &borders.concat());
        write_file(path, &text, &mut source)?;
    }
    if let Some(path) = &args.svg {
        write_file(path, &report::chart_svg(&chart, &rows), &mut source)?;
    }
    Ok(Answer::new(report::chart_csv(&chart, &rows), Some((source, Vec::new()))))
}

/// Results by number, each made by one of the threads. Each thread makes its worker itself.
fn on_all_cores<T: Send, W: FnMut(usize) -> T>(
    threads: usize,
    count: usize,
    what: &'static str,
    worker: impl Fn() -> W + Sync,
) -> Vec<T> {
    let counter = Counter::start(what, count);
    let next = AtomicUsize::new(0);
    let done = Mutex::new(Vec::with_capacity(count));
    let work = || {
        let mut work = worker();
        loop {
            let at = next.fetch_add(1, Ordering::Relaxed);
            if at >= count {
                return;
            }
            let result = work(at);
            counter.step();
            if let Ok(mut done) = done.lock() {
                done.push((at, result));
            }
        }
    };
    std::thread::scope(|scope| {
        for _ in 1..threads.min(count) {
            scope.spawn(work);
        }
        work();
    });
    drop(counter);
    let mut done = done.into_inner().unwrap_or_default();
    done.sort_by_key(|(at, _)| *at);
    done.into_iter().map(|(_, result)| result).collect()
}
