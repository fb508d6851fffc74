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
use super::machine::{locked, machine, said};
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
            text(report, chapter, plan)
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

fn text(report: &Report, chapter: String, plan: &Plan) -> String {
    [
        introduction(report),
        summary(report),
        choice(report),
        hard(report),
        zeros(report),
        sizes(report),
        many_digits(report),
        chapter + &bounds(report),
        losses(report),
        method(report, plan),
    ]
    .join("\n")
}

fn introduction(report: &Report) -> String {
    let mut out = String::from(
        "# Speed against error\n\nWhat each way to the normal frequencies costs, and how wrong it is. Written by\n\n    \
         cargo run --release --example speed_and_error\n\nwhich measures everything anew; \
         no measured number below is typed by hand. `--python PATH` names the interpreter that has the peers.\n\n",
    );
    match &report.peers {
        Ok(versions) => {
            let missing: Vec<&str> =
                versions.iter().filter(|(_, version)| version.is_none()).map(|(name, _)| name.as_str()).collect();
            if !missing.is_empty() {
                let _ = writeln!(out, "Not installed in this run, and left out: {}.\n", missing.join(", "));
            }
        }
        Err(reason) => {
            let _ = writeln!(out, "Without the peers in Python ({reason}); the paths they take are left out.\n");
        }
    }
    let _ = writeln!(
        out,
        "Times are CPU times as multiples of one call, `{}`, on the same problem in the same run: ratios carry over \
         from machine to machine to a factor of two or so, seconds do not. Errors are relative errors of the worst \
         frequency that is not zero, against true values known to more digits than any path gives. An error above \
         1 means that ω² has the wrong sign: a stable body is called unstable.\n\n\
         ![Time against true error on the hard problems](speed-and-error/hard.svg)\n",
        report.unit
    );
    out
}

/// One line a path.
fn summary(report: &Report) -> String {
    let mut out = String::from("## The paths\n\n");
    let count = report.hard().count();
    let _ = writeln!(
        out,
        "Over the {count} hard problems of the [table below](#the-hard-problems-one-by-one): on how many a path applies, on how many it \
         gives up, on how many some sign of ω² is wrong, and its errors and times.\n"
    );
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
    table(&mut out, &titles.map(str::to_owned), &rows);
    out.push('\n');
    described(&mut out, |path| path.label != CHOLMOD);
    out
}

/// What paths are.
pub(crate) fn described(out: &mut String, which: impl Fn(&PathInfo) -> bool) {
    for path in PATHS.iter().filter(|path| which(path)) {
        let _ = writeln!(out, "- **{}**: {}", path.label, path.what);
    }
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

/// What each precision level does, and on which problems.
fn choice(report: &Report) -> String {
    let mut out = String::from(
        "## What the default picks where, and why\n\n\
         librate has one path, and stops at the first precision level whose proved bounds cover the digits that are \
         asked for (ten unless told otherwise). Nobody chooses a method, and the problem is not classified beforehand: \
         each costs more than the one before, and is only tried where that one could not prove enough.\n\n\
         1. **Doubles.** Eigenvectors from faer. Quotients xᵀKx / xᵀMx and residuals of these \
         vectors, as they are, in double-double. The bound is quadratic in the residuals, so vectors in doubles are \
         good for eigenvalues of more. Where: whatever M and K determine well.\n\
         2. **Double-double refinement.** The same vectors, made better by products in double-double; each round squares their error. \
         Where: more digits are wanted than the first vectors are good for, or modes are so close together that doubles mix their shapes.\n\
         3. **Full double-double.** M has no Cholesky factor in doubles, or what it gives is of no use: \
         factor and reduction in double-double. Where: coordinates almost without mass, M nearly singular.\n\
         4. **Arbitrary precision.** M, K and the equilibrium from the exact expressions once more, with as many bits as the \
         missing digits take, for the modes that miss them. Where: more digits than double-double has, entries of K that do not hold \
         soft springs beside stiff ones, or whatever is beyond all the others.\n\n",
    );
    let _ = writeln!(
        out,
        "Plain Jacobi rotations in doubles, and no higher precision behind them, are right on most of what other solvers in doubles get wrong. But they \
         prove nothing, are no help where K is no sum of squares (gravity, tension) or M is nearly singular, and cost more \
         the larger the problem{}.\n\nThe highest precision level that was needed, on how many of the {} problems of this document:\n",
        jacobi_cost(report),
        report.measured.len()
    );
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
    table(&mut out, &titles, &levels.map(row));
    out.push_str("\nAnd on each of them:\n\n");
    titles[0] = "problem".to_owned();
    let row = |measured: &Measured| {
        let levels = librate_paths().map(|(label, _)| {
            let certified = measured.of(label).and_then(|o| o.certified.as_ref());
            certified.map_or(String::new(), |certified| certified.level.as_str().to_owned())
        });
        cells(vec![measured.name.replace('_', " ")], levels)
    };
    table(&mut out, &titles, &report.measured.iter().map(row).collect::<Vec<_>>());
    out.push_str(
        "\nAn empty cell: the true values are not known to so many digits, or it would have taken too long.\n",
    );
    out
}

fn name_and_size(measured: &Measured) -> Vec<String> {
    vec![measured.name.replace('_', " "), measured.n.to_string()]
}

/// Errors and times on each hard problem.
fn hard(report: &Report) -> String {
    let mut out = String::from(
        "## The hard problems one by one\n\n\
         Models of [`models/hard`](../models/hard), which say what is hard about them. Errors above 1e-9, where fewer than ten \
         digits are right, are bold; (±k): k squares have the wrong sign. Doubles are given M and K correctly rounded; part of \
         the error is already in that rounding, and no solver can mend it.\n\n",
    );
    let paths = present(report.hard(), |path| match path.group {
        Group::Doubles | Group::Peer | Group::Jacobi => true,
        Group::Librate(digits) => digits <= 25,
        Group::Mpmath(_) | Group::Flint(_) => false,
    });
    let rows = |cell: &dyn Fn(&Measured, &PathInfo) -> String| -> Vec<Vec<String>> {
        report.hard().map(|m| cells(name_and_size(m), paths.iter().map(|path| cell(m, path)))).collect()
    };
    table(&mut out, &header(&["error", "n"], &paths), &rows(&error_cell));
    let _ = writeln!(
        out,
        "\nTimes, `{}` = 1. librate's include evaluating M and K with bounds from the expressions, and proving zero modes; \
         the others are given the matrices. A question mark: `{}` itself gives up.\n",
        report.unit, report.unit
    );
    table(&mut out, &header(&["time", "n"], &paths), &rows(&|m, path| time_cell(report, m, path)));
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
    let mut out = String::from(
        "## Zero modes\n\nThe largest frequency that is truly zero, in units of the lowest one that is not; librate's are \
         proved to be zero.\n\n",
    );
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
    table(&mut out, &header(&["problem", "zeros"], &paths), &singular().map(row).collect::<Vec<_>>());
    out
}

/// The families against n.
fn sizes(report: &Report) -> String {
    let mut out = String::from(
        "## Against n\n\n\
         Families whose M and K are exact in doubles, so that every error is the solver's: a chain that floats freely, \
         a pendulum of n links, a network in which every mass is tied to every other by a \
         spring of its own, and a chain whose mass matrix is Hilbert's, with a condition number that grows thirtyfold with each n. All paths are given the matrices, librate also the zero vector of the chain.\n\n\
         ![Time and error against n](speed-and-error/sizes.svg)\n\n",
    );
    for (slug, title) in families() {
        against_n(&mut out, report, slug, title);
    }
    let _ = writeln!(
        out,
        "Time by that of `{}`, and the error in brackets. A question mark: `{}` itself gives up. Too long: more than the \
         limit [below](#how-it-was-measured).",
        report.unit, report.unit
    );
    out
}

/// Time and error of all paths on a family, one column a size.
pub(crate) fn against_n(out: &mut String, report: &Report, slug: &str, title: &str) {
    let paths = present(report.family(slug), |_| true);
    let titles = cells(vec![title.to_owned()], report.family(slug).map(|m| format!("n = {}", m.n)));
    let row = |path: &&PathInfo| {
        cells(vec![path.label.to_owned()], report.family(slug).map(|m| time_and_error_cell(report, m, path)))
    };
    table(out, &titles, &paths.iter().map(row).collect::<Vec<_>>());
    out.push('\n');
}

/// librate beside the tools for many digits.
fn many_digits(report: &Report) -> String {
    let mut out = String::from(
        "## Many digits\n\n\
         mpmath carries so many digits and leaves the errors to the user; python-flint computes with balls of that many digits, and \
         what is left of them depends on the problem; librate gives that many digits, with shapes.\n\n",
    );
    let many = |path: &PathInfo| match path.group {
        Group::Librate(digits) => digits >= 25,
        Group::Mpmath(_) | Group::Flint(_) => true,
        Group::Doubles | Group::Peer | Group::Jacobi => false,
    };
    let some = || report.measured.iter().filter(|m| m.n <= MANY_DIGITS && m.n > 2);
    let paths = present(some(), many);
    let row = |m: &Measured| cells(name_and_size(m), paths.iter().map(|path| time_and_error_cell(report, m, path)));
    table(&mut out, &header(&["problem", "n"], &paths), &some().map(row).collect::<Vec<_>>());
    out
}

/// How much larger than the errors the bounds are.
fn bounds(report: &Report) -> String {
    let mut out = String::from(
        "## The bounds\n\nThe largest bound that librate gives for a relative error, over all problems; how many times the true error a bound \
         is (the median over the frequencies of a problem; here the median of the problems, and the largest); and whether any bound \
         does not hold.\n\n",
    );
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
    table(&mut out, &titles.map(str::to_owned), &rows);
    out
}

/// Where something else is faster, said plainly.
fn losses(report: &Report) -> String {
    let mut out = String::from("## Where librate loses\n\n");
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
    out.push_str(
        "- All modes come from dense matrices: LAPACK's tridiagonal solver and ARPACK make use of the zeros, librate only where a few modes of a \
         large model are wanted ([above](#large-models)).\n",
    );
    out
}

fn method(report: &Report, plan: &Plan) -> String {
    let mut out = String::from("## How it was measured\n\n");
    let rust = said("rustc", "--version").unwrap_or_else(|| "rustc of unknown version".to_owned());
    let _ = writeln!(
        out,
        "- On {}; {rust}, release build. librate {}, nalgebra {}, faer {}, dashu-int {}.",
        machine(),
        env!("CARGO_PKG_VERSION"),
        locked("nalgebra"),
        locked("faer"),
        locked("dashu-int")
    );
    if let Ok(versions) = &report.peers {
        let all: Vec<String> =
            versions.iter().filter_map(|(name, version)| Some(format!("{name} {}", version.as_ref()?))).collect();
        let _ = writeln!(out, "- Peers: {}; one thread, as everything here.", all.join(", "));
    }
    let _ = writeln!(
        out,
        "- CPU time of the process, the fastest of several calls ({} s of repeats after the first; what takes longer is called once). What would \
         take more than {} s, going by the size before and n³, is left out.\n\
         - All modes with their shapes, but ARPACK the ten lowest, and mpmath and python-flint no shapes. mpmath and python-flint are given M and K in 300 digits, up to \
         {MANY_DIGITS} coordinates; everything else M and K in doubles.\n\
         - True values. Hard models: references of 40 digits made by other means ([`tests/reference/hard`](../tests/reference/hard)), up to {MANY_DIGITS} coordinates continued to \
         over 150 digits by Householder and QL in big floats of two precisions that share nothing with the solver (`examples/campaign/reference.rs`), and held against those 40. \
         Chain: 4 sin²(jπ/2n) in 448 bits. Pendulum: zeros of Laguerre's polynomial, each with a proof by signs. Network and Hilbert: the same Householder and QL.\n\
         - A path is run to so many digits only where the true values are known to five more. Errors of librate are those of the midpoints of its balls; what it prints is rounded \
         to the digits asked for.",
        plan.patience, plan.longest
    );
    out
}
