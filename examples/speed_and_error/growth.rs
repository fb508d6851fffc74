//! The chapter on large models: beside peers, and how time and memory grow with n.

use std::fmt::Write as _;
use std::ops::Range;

use super::cells::{ratio, table};
use super::document::{against_n, described};
use super::large::{Growth, LARGE, LargeReport, PEERS};
use super::machine::{machine, said};
use super::run::{DEFAULT, Plan};

const TITLE: &str = "## Large models\n";
/// What the chapter is in front of.
const NEXT: &str = "## The bounds\n";

/// Where the chapter is in a document, or is to be.
pub(crate) fn place(document: &str) -> Range<usize> {
    let end = || document.find(NEXT).unwrap_or(document.len());
    let Some(start) = document.find(TITLE) else { return end()..end() };
    let length = document[start + TITLE.len()..].find("\n## ");
    start..length.map_or(document.len(), |length| start + TITLE.len() + length + 1)
}

/// Slugs and titles of the families.
pub(crate) fn families() -> Vec<(&'static str, &'static str)> {
    LARGE.iter().map(|family| (family.slug, family.title)).collect()
}

/// The chapter.
pub(crate) fn text(own: &LargeReport, plan: &Plan) -> String {
    let report = &own.report;
    let mut out = format!(
        "{TITLE}\nThe lowest modes of the models of `models/large`, frequencies alone. librate starts from the text of the model, \
         in a process of its own, and ends with modes that have bounds and of which none is missing; the peers are given M and K in \
         sparse form, as one would have them from a program written by hand.\n\n\
         ![Time and error against n](speed-and-error/large.svg)\n\n",
    );
    out += &described(|path| path.label == DEFAULT || PEERS.contains(&path.label));
    out.push('\n');
    out.extend(families().into_iter().map(|family| against_n(report, family)));
    let _ = writeln!(
        out,
        "Time by that of `{}`, and the largest relative error of a frequency in brackets; a mode that a peer has missed shows as an error of its \
         successor. A question mark: `{}` itself gives up or was left out. The network has no closed form: librate's error is its bound, the others are \
         held against its midpoints. Too long: more than {} s, going by the size before and n to the power of 1.5; where librate is left out, \
         all are.\n",
        report.unit, report.unit, plan.longest_sparse
    );
    out.push_str(
        "How librate's time and memory grow: those at the largest size by those at the smallest, and the exponents of n that fit all sizes best. Memory is the \
         most that the process had, which begins at some megabytes.\n\n",
    );
    let titles = ["family", "n", "time", "exponent", "of it modes alone", "memory, MB", "exponent", "largest bound"];
    out += &table(&titles.map(str::to_owned), LARGE.iter().filter_map(|family| row(own, family.slug)));
    let _ = write!(out, "\nOn {}; {}.", machine(), said("rustc", "--version").unwrap_or_default());
    if plan.largest_sparse < usize::MAX {
        let _ = write!(out, " A short run: models of up to {} coordinates alone.", plan.largest_sparse);
    }
    out.push('\n');
    match &report.peers {
        Ok(versions) => {
            let used = versions.iter().filter(|(name, _)| !["mpmath", "python-flint"].contains(&name.as_str()));
            let all = used.map(|(name, version)| match version {
                Some(version) => format!("{name} {version}"),
                None => format!("{name} is not installed"),
            });
            let _ = writeln!(out, "Peers: {}; one thread.\n", all.collect::<Vec<_>>().join(", "));
        }
        Err(reason) => {
            let _ = writeln!(out, "Without the peers in Python ({reason}).\n");
        }
    }
    out
}

/// How a family grows.
fn row(own: &LargeReport, slug: &str) -> Option<Vec<String>> {
    let all: Vec<&Growth> = own.growth.iter().filter(|own| own.slug == slug).collect();
    let (first, last) = (all.first()?, all.last()?);
    let exponent = |of: &dyn Fn(&Growth) -> f64| slope(all.iter().map(|own| ((own.n as f64).ln(), of(own).ln())));
    let digits = |exponent: Option<f64>| exponent.map_or(String::new(), |own| format!("{own:.2}"));
    let bounds = own.report.family(slug).filter_map(|m| Some(m.of(DEFAULT)?.certified.as_ref()?.bound));
    Some(vec![
        slug.to_owned(),
        format!("{} to {}", first.n, last.n),
        format!("{} ×", ratio(last.seconds[0] / first.seconds[0])),
        digits(exponent(&|own| own.seconds[0])),
        format!("{:.0} %", 100.0 * last.seconds[1] / last.seconds[0]),
        format!("{:.0} to {:.0}", first.megabytes, last.megabytes),
        digits(exponent(&|own| own.megabytes)),
        bounds.reduce(f64::max).map_or(String::new(), super::cells::error),
    ])
}

/// The slope of the line that fits some points best; none for fewer than two places.
fn slope(points: impl Iterator<Item = (f64, f64)>) -> Option<f64> {
    let points: Vec<(f64, f64)> = points.collect();
    let count = points.len() as f64;
    let mean = |of: fn(&(f64, f64)) -> f64| points.iter().map(of).sum::<f64>() / count;
    let (x, y) = (mean(|p| p.0), mean(|p| p.1));
    let width: f64 = points.iter().map(|p| (p.0 - x) * (p.0 - x)).sum();
    let both: f64 = points.iter().map(|p| (p.0 - x) * (p.1 - y)).sum();
    (width > 0.0).then_some(both / width)
}
