//! `speed-and-error.md`: every number in it comes from the run that writes it.

use std::error::Error;
use std::fmt::Write as _;
use std::path::Path;

use librate::modes::PrecisionLevel;

use super::case::{FAMILIES, MANY_DIGITS};
use super::cells::{cells, error, error_cell, header, present, ratio, table, time_and_error_cell, time_cell, verdict};
use super::clock::median;
use super::growth;
use super::large::LargeReport;
use super::machine::{filled, locked, machine, said};
use super::plots;
use super::run::{CHOLMOD, DEFAULT, FAER, Group, Measured, PATHS, PathInfo, Plan, Report, Verdict, librate_paths};

/// Writes the document into a folder, and its pictures into one beside it. What was not measured stays as it is there.
///
/// # Errors
/// Where a file can't be written.
pub(crate) fn write(
    dense: Option<&Report>,
    sparse: Option<&LargeReport>,
    plan: &Plan,
    out: &Path,
) -> Result<(), Box<dyn Error>> {
    let folder = out.join("speed-and-error");
    std::fs::create_dir_all(&folder)?;
    let file = out.join("speed-and-error.md");
    let before = std::fs::read_to_string(&file).unwrap_or_default();
    let chapter = match sparse {
        Some(own) => {
            std::fs::write(folder.join("large.svg"), plots::sizes(&own.report, &growth::families())?)?;
            growth::text(own, plan)
        }
        None => before[growth::place(&before)].to_owned(),
    };
    let text = match dense {
        Some(report) => {
            std::fs::write(folder.join("hard.svg"), plots::hard(report)?)?;
            std::fs::write(folder.join("sizes.svg"), plots::sizes(report, &families())?)?;
            text(report, &chapter, plan)
        }
        None => {
            let mut text = before;
            text.replace_range(growth::place(&text), &chapter);
            text
        }
    };
    std::fs::write(file, text)?;
    Ok(())
}

/// Slugs and titles of the families.
fn families() -> Vec<(&'static str, &'static str)> {
    FAMILIES.iter().map(|family| (family.slug, family.title)).collect()
}

/// The text that is in `document.txt`, with what was measured for the names in braces.
fn text(report: &Report, chapter: &str, plan: &Plan) -> String {
    filled(include_str!("document.txt"), |name| match name {
        "missing" => missing(report),
        "unit" => report.unit.to_owned(),
        "hard" => report.hard().count().to_string(),
        "paths" => summary(report),
        "rotations" => jacobi_cost(report),
        "problems" => report.measured.len().to_string(),
        "levels" => levels(report),
        "errors" => hard(report, "error", &error_cell),
        "times" => hard(report, "time", &|m, path| time_cell(report, m, path)),
        "failures" => failures(report),
        "zeros" => zeros(report),
        "sizes" => sizes(report),
        "many digits" => many_digits(report),
        "large" => chapter.to_owned(),
        "bounds" => bounds(report),
        "losses" => losses(report),
        "machine" => machine(),
        "rust" => said("rustc", "--version").unwrap_or_else(|| "rustc of unknown version".to_owned()),
        "librate" => env!("CARGO_PKG_VERSION").to_owned(),
        "peers" => peers(report),
        "patience" => plan.patience.to_string(),
        "longest" => plan.longest.to_string(),
        "coordinates" => MANY_DIGITS.to_string(),
        library => locked(library).to_owned(),
    })
}

/// The peers that are left out.
fn missing(report: &Report) -> String {
    match &report.peers {
        Ok(versions) => {
            let missing: Vec<&str> =
                versions.iter().filter(|(_, version)| version.is_none()).map(|(name, _)| name.as_str()).collect();
            if missing.is_empty() {
                return String::new();
            }
            format!("Not installed in this run, and left out: {}.\n\n", missing.join(", "))
        }
        Err(reason) => format!("Without the peers in Python ({reason}); the paths they take are left out.\n\n"),
    }
}

/// One line a path.
fn summary(report: &Report) -> String {
    let mut rows = Vec::new();
    for path in present(report.hard(), |_| true) {
        let of = |test: &dyn Fn(&Verdict) -> bool| report.hard().filter(|m| test(verdict(m, path))).count();
        let applies = of(&|v| matches!(v, Verdict::Done(_) | Verdict::Failed(_)));
        let fails = of(&|v| matches!(v, Verdict::Failed(_)));
        let signs = of(&|v| matches!(v, Verdict::Done(o) if o.judged.wrong_signs > 0));
        let errors: Vec<f64> = report.hard().filter_map(|m| Some(m.of(path.label)?.judged.error)).collect();
        let times: Vec<f64> = report.hard().filter_map(|m| report.ratio(m, path.label)).collect();
        let worst = errors.iter().copied().fold(0.0, f64::max);
        let bounds = report.hard().filter_map(|m| m.of(path.label)?.certified.as_ref());
        let bound = bounds.map(|c| c.bound).reduce(f64::max);
        rows.push(vec![
            path.label.to_owned(),
            applies.to_string(),
            fails.to_string(),
            signs.to_string(),
            median(errors).map_or(String::new(), error),
            error(worst),
            bound.map_or("none".to_owned(), error),
            median(times).map_or(String::new(), ratio),
        ]);
    }
    let titles =
        ["path", "applies", "gives up", "wrong sign", "error, median", "error, worst", "bound, worst", "time, median"];
    table(&titles.map(str::to_owned), rows) + "\n" + &described(|path| path.label != CHOLMOD)
}

/// What paths are.
pub(crate) fn described(which: impl Fn(&PathInfo) -> bool) -> String {
    let paths = PATHS.iter().filter(|path| which(path));
    paths.map(|path| format!("- **{}**: {}\n", path.label, path.what)).collect()
}

/// What the rotations cost at the largest size that they were given.
fn jacobi_cost(report: &Report) -> String {
    let largest = |slug| {
        let costs = report.family(slug).filter_map(|m| Some((m.n, report.ratio(m, "Jacobi on the factor")?)));
        let (n, cost) = costs.last()?;
        Some(format!("{slug} {} at n = {n}", ratio(cost)))
    };
    let costs: Vec<String> = FAMILIES.iter().filter_map(|family| largest(family.slug)).collect();
    format!(" (times `{}`: {})", report.unit, costs.join(", "))
}

/// On how many problems each precision level was needed, and on which.
fn levels(report: &Report) -> String {
    let levels =
        [PrecisionLevel::Doubles, PrecisionLevel::Refined, PrecisionLevel::DoubleDouble, PrecisionLevel::Precise];
    let answered = |label: &str, level: PrecisionLevel| {
        let all = report.measured.iter().filter_map(|m| m.of(label)?.certified.as_ref());
        all.filter(|certified| certified.level == level).count().to_string()
    };
    let row = |level: PrecisionLevel| {
        cells(vec![level.as_str().to_owned()], librate_paths().map(|(label, _)| answered(label, level)))
    };
    let mut titles =
        cells(vec!["precision level".to_owned()], librate_paths().map(|(_, digits)| format!("{digits} digits")));
    let out = table(&titles, levels.map(row)) + "\nAnd on each of them:\n\n";
    titles[0] = "problem".to_owned();
    let row = |measured: &Measured| {
        let levels = librate_paths().map(|(label, _)| {
            let certified = measured.of(label).and_then(|o| o.certified.as_ref());
            certified.map_or(String::new(), |certified| certified.level.as_str().to_owned())
        });
        cells(vec![measured.name.replace('_', " ")], levels)
    };
    out + &table(&titles, report.measured.iter().map(row))
}

fn name_and_size(measured: &Measured) -> Vec<String> {
    vec![measured.name.replace('_', " "), measured.n.to_string()]
}

/// Errors or times on each hard problem.
fn hard(report: &Report, title: &str, cell: &dyn Fn(&Measured, &PathInfo) -> String) -> String {
    let paths = present(report.hard(), |path| match path.group {
        Group::Doubles | Group::Peer | Group::Jacobi => true,
        Group::Librate(digits) => digits <= 25,
        Group::Mpmath(_) | Group::Flint(_) => false,
    });
    let row = |m: &Measured| cells(name_and_size(m), paths.iter().map(|path| cell(m, path)));
    table(&header(&[title, "n"], &paths), report.hard().map(row))
}

/// What those say that give up.
fn failures(report: &Report) -> String {
    let mut out = String::new();
    let reasons = report.hard().flat_map(|m| {
        let failed = PATHS.iter().zip(&m.verdicts).filter_map(|(path, verdict)| match verdict {
            Verdict::Failed(reason) => Some((path.label, reason.as_str())),
            Verdict::Done(_) | Verdict::Absent | Verdict::TooLong => None,
        });
        failed.map(|(label, reason)| (m.name.as_str(), label, reason))
    });
    // Several paths may say the same.
    let mut said: Vec<(&str, &str, Vec<&str>)> = Vec::new();
    for (name, label, reason) in reasons {
        match said.iter_mut().find(|(n, r, _)| (*n, *r) == (name, reason)) {
            Some((_, _, labels)) => labels.push(label),
            None => said.push((name, reason, vec![label])),
        }
    }
    if !said.is_empty() {
        out.push_str("\nWhat those say that give up:\n\n");
    }
    for (name, reason, labels) in said {
        let _ = writeln!(out, "- {}, {}: {reason}", name.replace('_', " "), labels.join(", "));
    }
    out
}

/// What becomes of zero modes.
fn zeros(report: &Report) -> String {
    let singular = || report.measured.iter().filter(|m| m.zeros > 0);
    let paths = present(singular(), |path| !matches!(path.group, Group::Librate(15..)));
    let row = |measured: &Measured| {
        let zeros = paths.iter().map(|path| match verdict(measured, path) {
            Verdict::Done(outcome) => outcome.judged.zero.map_or(String::new(), error),
            Verdict::Failed(_) => "gives up".to_owned(),
            Verdict::Absent | Verdict::TooLong => String::new(),
        });
        cells(vec![measured.name.replace('_', " "), measured.zeros.to_string()], zeros)
    };
    table(&header(&["problem", "zeros"], &paths), singular().map(row))
}

/// The families against n.
fn sizes(report: &Report) -> String {
    families().into_iter().map(|family| against_n(report, family)).collect()
}

/// Time and error of all paths on a family, one column a size.
pub(crate) fn against_n(report: &Report, (slug, title): (&str, &str)) -> String {
    let paths = present(report.family(slug), |_| true);
    let titles = cells(vec![title.to_owned()], report.family(slug).map(|m| format!("n = {}", m.n)));
    let row = |path: &&PathInfo| {
        cells(vec![path.label.to_owned()], report.family(slug).map(|m| time_and_error_cell(report, m, path)))
    };
    table(&titles, paths.iter().map(row)) + "\n"
}

/// librate beside the tools for many digits.
fn many_digits(report: &Report) -> String {
    let many = |path: &PathInfo| match path.group {
        Group::Librate(digits) => digits >= 25,
        Group::Mpmath(_) | Group::Flint(_) => true,
        Group::Doubles | Group::Peer | Group::Jacobi => false,
    };
    let some = || report.measured.iter().filter(|m| m.n <= MANY_DIGITS && m.n > 2);
    let paths = present(some(), many);
    let row = |m: &Measured| cells(name_and_size(m), paths.iter().map(|path| time_and_error_cell(report, m, path)));
    table(&header(&["problem", "n"], &paths), some().map(row))
}

/// How much larger than the errors the bounds are.
fn bounds(report: &Report) -> String {
    let mut rows = Vec::new();
    for (label, digits) in librate_paths() {
        let all: Vec<_> = report.measured.iter().filter_map(|m| m.of(label)?.certified.as_ref()).collect();
        let slack: Vec<f64> = all.iter().filter_map(|c| c.slack).collect();
        let largest = slack.iter().copied().fold(0.0, f64::max);
        let bound = all.iter().map(|c| c.bound).fold(0.0, f64::max);
        let fewer = all.iter().filter(|c| !c.covered).count();
        let broken = all.iter().filter(|c| !c.holds).count();
        rows.push(vec![
            digits.to_string(),
            all.len().to_string(),
            error(bound),
            median(slack).map_or(String::new(), ratio),
            ratio(largest),
            fewer.to_string(),
            broken.to_string(),
        ]);
    }
    let titles = [
        "digits asked for",
        "problems",
        "largest bound",
        "bound / error, median",
        "largest",
        "fewer digits covered",
        "bounds that do not hold",
    ];
    table(&titles.map(str::to_owned), rows)
}

/// Where something else is faster, said plainly.
fn losses(report: &Report) -> String {
    let mut out = String::new();
    for family in &FAMILIES {
        let all: Vec<&Measured> = report.family(family.slug).collect();
        let costs: Vec<String> =
            all.iter().filter_map(|m| Some(format!("{} at n = {}", ratio(report.ratio(m, DEFAULT)?), m.n))).collect();
        let _ = writeln!(
            out,
            "- {}: the default takes {} times as long as `{}`, which gives no bounds.",
            family.title,
            costs.join(", "),
            report.unit
        );
    }
    let slower = |label: &str, other: &str| {
        let ratios: Vec<f64> =
            report.measured.iter().filter_map(|m| Some(report.ratio(m, label)? / report.ratio(m, other)?)).collect();
        let (count, more) = (ratios.len(), ratios.iter().filter(|r| **r > 1.0).count());
        let largest = ratios.iter().copied().fold(0.0, f64::max);
        (count, more, median(ratios), largest)
    };
    for (own, other) in [
        (DEFAULT, report.unit),
        (DEFAULT, FAER),
        (DEFAULT, "LAPACK tridiagonal"),
        (DEFAULT, "ARPACK"),
        ("librate, 50 digits", "mpmath, 50 digits"),
        ("librate, 50 digits", "python-flint, 50 digits"),
        ("librate, 100 digits", "mpmath, 100 digits"),
        ("librate, 100 digits", "python-flint, 100 digits"),
    ] {
        if let (count, more, Some(middle), largest) = slower(own, other) {
            let _ = writeln!(
                out,
                "- {own} beside {other}: slower on {more} of {count} problems, {} times as long in the median, {} at most.",
                ratio(middle),
                ratio(largest)
            );
        }
    }
    if let (_, _, Some(middle), largest) = slower("librate, 25 digits", "librate, 15 digits") {
        let _ = writeln!(
            out,
            "- 25 digits take {} times as long as 15 in the median, {} at most: where double-double does not quite reach, \
             all modes that miss digits go to arbitrary precision.",
            ratio(middle),
            ratio(largest)
        );
    }
    out
}

/// Those that are there.
fn peers(report: &Report) -> String {
    let Ok(versions) = &report.peers else { return String::new() };
    let all: Vec<String> =
        versions.iter().filter_map(|(name, version)| Some(format!("{name} {}", version.as_ref()?))).collect();
    format!("- Peers: {}; one thread, as everything here.\n", all.join(", "))
}
