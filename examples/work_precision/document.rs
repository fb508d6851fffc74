//! `work-precision.md`: every number in it comes from the run that writes it.

use std::error::Error;
use std::fmt::Write as _;
use std::path::Path;

use super::machine::{filled, locked, machine, said};
use super::picture::picture;
use super::run::{DOP853, FULL, HEYOKA, Line, MODEL, QUICK, Report, Trip, UNTIL};

/// Errors that methods are compared at.
const LEVELS: [f64; 4] = [1e-4, 1e-6, 1e-8, 1e-10];

/// Writes the document into a folder, and its picture into one beside it.
///
/// # Errors
/// Where a file can't be written.
pub(crate) fn write(report: &Report, out: &Path) -> Result<(), Box<dyn Error>> {
    let folder = out.join("work-precision");
    std::fs::create_dir_all(&folder)?;
    std::fs::write(folder.join("double-pendulum.svg"), picture(report)?)?;
    std::fs::write(out.join("work-precision.md"), text(report))?;
    Ok(())
}

/// The text that is in `document.txt`, with what was measured for the names in braces.
fn text(report: &Report) -> String {
    let text = filled(include_str!("document.txt"), |name| match name {
        "until" => UNTIL.to_string(),
        "model" => MODEL.to_owned(),
        "left out" => left_out(report),
        "levels" => levels(report),
        "preparation" => preparation(report),
        "trips" => trips(report),
        "machine" => machine(),
        "rust" => said("rustc", "--version").unwrap_or_else(|| "rustc".to_owned()),
        library => locked(library).to_owned(),
    });
    text.replace("\n\n\n", "\n\n")
}

/// Seconds, as one writes them.
fn time(seconds: f64) -> String {
    match seconds {
        s if s < 1e-3 => format!("{:.0} µs", s * 1e6),
        s if s < 1e-2 => format!("{:.1} ms", s * 1e3),
        s if s < 1.0 => format!("{:.0} ms", s * 1e3),
        s => format!("{s:.1} s"),
    }
}

fn left_out(report: &Report) -> String {
    let mut out = String::new();
    for line in &report.lines {
        if let (true, Some(remark)) = (line.trips.is_empty(), &line.remark) {
            let _ = writeln!(out, "Left out in this run: {} ({remark}).\n", line.name);
        }
    }
    out
}

/// Times at the same error.
fn levels(report: &Report) -> String {
    let mut out = String::new();
    let lines: Vec<&Line> = report.lines.iter().filter(|line| line.name != FULL && !line.trips.is_empty()).collect();
    for line in &lines {
        let _ = write!(out, " {} |", line.name);
    }
    let _ = writeln!(out, "\n|{}", " --- |".repeat(lines.len() + 1));
    for level in LEVELS {
        let _ = write!(out, "| {level:e} |");
        let own = report.line(QUICK).and_then(|own| own.time_at(level));
        for line in &lines {
            let cell = match (line.time_at(level), own) {
                (None, _) => "–".to_owned(),
                (Some(seconds), Some(own)) if line.name != QUICK => {
                    format!("{}, × {}", time(seconds), ratio(seconds / own))
                }
                (Some(seconds), _) => time(seconds),
            };
            let _ = write!(out, " {cell} |");
        }
        out.push('\n');
    }
    out.push('\n');
    let compare = |name: &str| {
        let (own, other) = (report.line(QUICK)?, report.line(name)?);
        let ratios = LEVELS.iter().filter_map(|level| Some(other.time_at(*level)? / own.time_at(*level)?));
        Some(extremes(ratios)).filter(|(_, most)| *most > 0.0)
    };
    if let Some((least, most)) = compare(DOP853) {
        let _ = writeln!(
            out,
            "SciPy's DOP853, with the equations written by hand in Python, takes {} to {} times as long as librate.\n",
            ratio(least),
            ratio(most)
        );
    }
    if let Some((least, most)) = compare(HEYOKA) {
        let (verb, from, to) =
            if most < 1.0 { ("wins: it is", 1.0 / most, 1.0 / least) } else { ("takes", least, most) };
        let tail = if most < 1.0 { "times as fast as librate" } else { "times as long as librate" };
        let _ = writeln!(
            out,
            "heyoka, which compiles the same Taylor method to machine code for these very equations, {verb} {} to {} {tail}, once it \
             has compiled.\n",
            ratio(from),
            ratio(to)
        );
    }
    if let Some(full) = report.line(FULL).and_then(|line| line.trips.first()) {
        let _ = writeln!(
            out,
            "Without a tolerance librate takes {} and is off by {:.0e}: it runs in double-double, and in doubles beside it to tell which digits \
             stand. Of the others the best that was reached is {}.\n",
            time(full.seconds),
            full.error,
            best(report)
        );
    }
    out
}

/// The least and the largest of positive numbers.
fn extremes(values: impl Iterator<Item = f64>) -> (f64, f64) {
    values.fold((f64::INFINITY, 0.0), |(least, most), value| (least.min(value), f64::max(most, value)))
}

fn best(report: &Report) -> String {
    let others = report.lines.iter().filter(|line| !line.trips.is_empty());
    let others = others.filter(|line| line.name != FULL);
    let best = others.min_by(|a, b| a.best().total_cmp(&b.best()));
    best.map_or_else(|| "none".to_owned(), |line| format!("{:.0e} ({})", line.best(), line.name))
}

fn ratio(value: f64) -> String {
    match value {
        v if v < 0.095 => format!("{v:.2}"),
        v if v < 9.95 => format!("{v:.1}"),
        v => format!("{v:.0}"),
    }
}

/// What comes before the first step.
fn preparation(report: &Report) -> String {
    let mut out = String::new();
    let spent = |name: &str| {
        let trips = report.line(name)?.trips.iter();
        Some(extremes(trips.map(|trip| trip.prepared)))
    };
    if let Some((own, _)) = spent(QUICK) {
        let _ = writeln!(out, "librate derives the equations of motion from T and V in {}.", time(own));
    }
    if let Some((least, most)) = spent(HEYOKA) {
        let _ = writeln!(
            out,
            "heyoka is given them by hand and compiles them for a tolerance in {} to {}, the less the more of it was there before.",
            time(least),
            time(most)
        );
    }
    out
}

fn trips(report: &Report) -> String {
    let mut out = String::new();
    for line in &report.lines {
        for Trip { tolerance, seconds, error, .. } in &line.trips {
            let asked = tolerance.map_or_else(|| "none".to_owned(), |digits| format!("1e-{digits}"));
            let _ = writeln!(out, "| {} | {asked} | {} | {error:.1e} |", line.name, time(*seconds));
        }
        if let (false, Some(remark)) = (line.trips.is_empty(), &line.remark) {
            let _ = writeln!(out, "| {} | | no more: {remark} | |", line.name);
        }
    }
    if let Ok(versions) = &report.versions {
        let known = versions.iter().filter_map(|(name, version)| Some(format!("{name} {}", version.as_ref()?)));
        let known: Vec<String> = known.collect();
        let _ = writeln!(out, "\nPeers: {}.", known.join(", "));
    }
    out
}
