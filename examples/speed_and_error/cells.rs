//! Cells and tables of the document.

use super::judge::Judged;
use super::run::{Measured, PATHS, PathInfo, Report, Verdict};

/// A number with one digit, as errors are told.
pub(crate) fn error(value: f64) -> String {
    if value == 0.0 {
        "0".to_owned()
    } else if (0.001..1000.0).contains(&value) {
        format!("{}", format!("{value:.0e}").parse().unwrap_or(value))
    } else {
        format!("{value:.0e}")
    }
}

/// A ratio with two digits, a very large one with one.
pub(crate) fn ratio(value: f64) -> String {
    if value >= 1e5 {
        return error(value);
    }
    let rounded: f64 = format!("{value:.1e}").parse().unwrap_or(value);
    format!("{rounded}")
}

pub(crate) fn table(header: &[String], rows: impl IntoIterator<Item = Vec<String>>) -> String {
    let line = |cells: &[String]| format!("| {} |\n", cells.join(" | "));
    let rule = (0..header.len()).map(|at| if at == 0 { "---" } else { "---:" });
    let rule = line(&rule.map(str::to_owned).collect::<Vec<_>>());
    [line(header), rule].into_iter().chain(rows.into_iter().map(|row| line(&row))).collect()
}

/// A row of a table.
pub(crate) fn cells(first: Vec<String>, rest: impl Iterator<Item = String>) -> Vec<String> {
    first.into_iter().chain(rest).collect()
}

pub(crate) fn header(first: &[&str], rest: &[&PathInfo]) -> Vec<String> {
    first.iter().copied().chain(rest.iter().map(|path| path.label)).map(str::to_owned).collect()
}

/// The paths that gave anything on some of the problems.
pub(crate) fn present<'a>(
    measured: impl Iterator<Item = &'a Measured> + Clone,
    keep: impl Fn(&PathInfo) -> bool,
) -> Vec<&'static PathInfo> {
    let some = |path: &PathInfo| measured.clone().any(|m| !matches!(verdict(m, path), Verdict::Absent));
    PATHS.iter().filter(|path| keep(path) && some(path)).collect()
}

pub(crate) fn verdict<'a>(measured: &'a Measured, path: &PathInfo) -> &'a Verdict {
    measured.verdict(path.label).unwrap_or(&Verdict::Absent)
}

pub(crate) fn error_cell(measured: &Measured, path: &PathInfo) -> String {
    cell(measured, path, |judged| match error(judged.error) {
        text if judged.wrong_signs > 0 => format!("**{text}** (±{})", judged.wrong_signs),
        text if judged.error > 1e-9 => format!("**{text}**"),
        text => text,
    })
}

pub(crate) fn time_cell(report: &Report, measured: &Measured, path: &PathInfo) -> String {
    cell(measured, path, |_| report.ratio(measured, path.label).map_or("?".to_owned(), ratio))
}

pub(crate) fn time_and_error_cell(report: &Report, measured: &Measured, path: &PathInfo) -> String {
    cell(measured, path, |_| format!("{} × ({})", time_cell(report, measured, path), error_cell(measured, path)))
}

/// What a path gave, or why it gave nothing.
fn cell(measured: &Measured, path: &PathInfo, done: impl Fn(&Judged) -> String) -> String {
    match verdict(measured, path) {
        Verdict::Done(outcome) => done(&outcome.judged),
        Verdict::Failed(_) => "gives up".to_owned(),
        Verdict::Absent => String::new(),
        Verdict::TooLong => "too long".to_owned(),
    }
}
