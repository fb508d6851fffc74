//! Some modes of large models: from the model file to certified modes in a process of its own, beside peers that are given the matrices.

use std::error::Error;
use std::fs::File;
use std::path::Path;
use std::process::Command;

use librate::budget::Budget;
use librate::linearize::{Linearized, linearize};
use librate::model::{Settings, TableTexts, elaborate};
use librate::modes::{Kind, Options, PrecisionLevel};
use librate::number::Number;
use librate::oscillation::{NormalModes, normal_modes};
use librate::report::{matrices, write_npz};
use librate::syntax::parse;
use serde_json::{Value, json};

use super::clock::fastest;
use super::judge::Enclosure;
use super::paths::Answer;
use super::peers::Peers;
use super::points;
use super::run::{CHOLMOD, DEFAULT, Measured, PATHS, Plan, Report, Verdict, certified};
use super::truth::{Known, sines};

/// The peer that times are compared with.
const UNIT: &str = "ARPACK";
/// Peers for large models.
pub(crate) const PEERS: [&str; 3] = [UNIT, CHOLMOD, "LAPACK tridiagonal"];
/// Bytes for one problem.
const BYTES: u64 = 8_000_000_000;
/// How time is taken to grow with n, to leave out what would take too long.
const GROWTH: f64 = 1.5;
/// Where there is no closed form, others are held against librate's midpoints, to so many digits.
const OWN_DIGITS: usize = 20;

/// A file of `models/large` in several sizes.
pub(crate) struct Large {
    pub(crate) slug: &'static str,
    pub(crate) title: &'static str,
    /// Its N, or the number of points in its table.
    sizes: &'static [usize],
    dimension: fn(usize) -> usize,
    /// So many of the lowest modes.
    count: usize,
    /// The lowest ω² in any order and some more, from 4 sin²(jπ/2(N + 1)), j = 1, 2, ...; none without a closed form.
    squares: fn(&[Number]) -> Vec<Number>,
}

pub(crate) const LARGE: [Large; 4] = [
    Large {
        slug: "chain",
        title: "chain between walls (tridiagonal), lowest 10",
        sizes: &[1_000, 10_000, 100_000, 1_000_000],
        dimension: |n| n,
        count: 10,
        squares: <[Number]>::to_vec,
    },
    Large {
        slug: "net",
        title: "stretched net in its plane, every frequency twice, lowest 10",
        sizes: &[20, 30, 60, 100],
        dimension: |n| 2 * n * n,
        count: 10,
        squares: |sines| {
            let fifth = Number::from(5);
            let along = |a: &Number, b: &Number| a.add(&b.div(&fifth).unwrap_or_else(|| b.clone()));
            let all = sums(sines, along);
            all.iter().flat_map(|own| [own.clone(), own.clone()]).collect()
        },
    },
    Large {
        slug: "membrane",
        title: "membrane, most frequencies twice, lowest 50",
        sizes: &[30, 60, 100, 300],
        dimension: |n| n * n,
        count: 50,
        squares: |sines| sums(sines, Number::add),
    },
    Large {
        slug: "network",
        title: "elastic network of random points in space, six zeros, lowest 20",
        sizes: &[300, 1_000, 10_000, 100_000],
        dimension: |n| 3 * n,
        count: 20,
        squares: |_| Vec::new(),
    },
];

fn sums(sines: &[Number], sum: impl Fn(&Number, &Number) -> Number) -> Vec<Number> {
    sines.iter().flat_map(|a| sines.iter().map(|b| sum(a, b))).collect()
}

/// What librate took for a problem.
pub(crate) struct Growth {
    pub(crate) slug: &'static str,
    pub(crate) n: usize,
    /// From the text to the modes, and for the modes alone from T and V about the equilibrium.
    pub(crate) seconds: [f64; 2],
    pub(crate) megabytes: f64,
}

/// The large models, measured.
pub(crate) struct LargeReport {
    pub(crate) report: Report,
    pub(crate) growth: Vec<Growth>,
}

impl Large {
    /// The sizes up to so many coordinates.
    pub(crate) fn sizes(&self, largest: usize) -> impl Iterator<Item = usize> {
        self.sizes.iter().copied().filter(move |size| (self.dimension)(*size) <= largest)
    }

    /// The lowest ω², where there is a closed form.
    fn truth(&self, size: usize) -> Option<Known> {
        // The lowest fifty of a membrane are among the first ten in either direction.
        let Known { values, digits } = sines(size, self.count.min(24));
        let mut values = (self.squares)(&values);
        values.sort_by(|a, b| a.sub(b).to_f64().total_cmp(&0.0));
        values.truncate(self.count);
        (!values.is_empty()).then_some(Known { values, digits })
    }
}

/// What [`one`] says, or what it is refused for; from its arguments.
pub(crate) type Ask<'a> = &'a dyn Fn([String; 4]) -> Result<Result<String, String>, Box<dyn Error>>;

/// In a process of its own, whose memory is all for the problem.
///
/// # Errors
/// Where there is no process.
pub(crate) fn ask_child(arguments: [String; 4]) -> Result<Result<String, String>, Box<dyn Error>> {
    let output = Command::new(std::env::current_exe()?).arg(ONE).args(arguments).output()?;
    let text = |bytes: Vec<u8>| String::from_utf8_lossy(&bytes).into_owned();
    Ok(if output.status.success() { Ok(text(output.stdout)) } else { Err(text(output.stderr)) })
}

/// Measures all families; `tell` hears about each problem before it begins.
///
/// # Errors
/// Where there is no place for the matrices, or no process for librate.
pub(crate) fn run(
    plan: &Plan,
    peers: &mut Result<Peers, String>,
    ask: Ask<'_>,
    mut tell: impl FnMut(&str),
) -> Result<LargeReport, Box<dyn Error>> {
    let (mut measured, mut growth) = (Vec::new(), Vec::new());
    let folder = tempfile::tempdir()?;
    let file = folder.path().join("pencil.npz");
    for family in &LARGE {
        let mut before: Option<Measured> = None;
        for size in family.sizes(plan.largest_sparse) {
            let n = (family.dimension)(size);
            tell(&format!("{}, n = {n}", family.slug));
            let is_long = |label: &str| {
                let seconds = before.as_ref().and_then(|before| match before.verdict(label)? {
                    Verdict::Done(own) => Some(own.seconds * (n as f64 / before.n as f64).powf(GROWTH)),
                    Verdict::TooLong => Some(f64::INFINITY),
                    Verdict::Failed(_) | Verdict::Absent => None,
                });
                seconds.is_some_and(|seconds| seconds > plan.longest_sparse)
            };
            let mut verdicts: Vec<Verdict> = PATHS.iter().map(|_| Verdict::Absent).collect();
            let mut put = |label: &str, verdict: Verdict| {
                let mut slots = PATHS.iter().zip(&mut verdicts);
                if let Some((_, slot)) = slots.find(|(path, _)| path.label == label) {
                    *slot = verdict;
                }
            };
            let mut zeros = 0;
            if is_long(DEFAULT) {
                put(DEFAULT, Verdict::TooLong);
            } else {
                match of_librate(family, size, (ask, &file), plan)? {
                    Err(reason) => put(DEFAULT, Verdict::Failed(reason)),
                    Ok((own, answer)) => {
                        growth.push(own);
                        let known = family.truth(size);
                        let is_closed = known.is_some();
                        let known = known.unwrap_or_else(|| Known {
                            values: answer.values.iter().map(|x| x.mid.clone()).collect(),
                            digits: OWN_DIGITS,
                        });
                        zeros = known.values.iter().filter(|x| x.is_zero()).count();
                        let mut outcome = certified(&known, answer, 10);
                        if let (false, Some(own)) = (is_closed, &outcome.certified) {
                            outcome.judged.error = own.bound;
                        }
                        put(DEFAULT, Verdict::Done(outcome));
                        if let Ok(some) = peers
                            && some.has("scipy")
                            && let Err(error) = some.set_large(&file, known.values.len(), zeros > 0)
                        {
                            *peers = Err(error);
                        }
                        for path in PATHS.iter().filter(|path| PEERS.contains(&path.label)) {
                            if path.label == "LAPACK tridiagonal" && family.slug != "chain" {
                                continue;
                            }
                            let is_long = is_long(path.label);
                            put(path.label, if is_long { Verdict::TooLong } else { plan.peer(&known, path, peers) });
                        }
                    }
                }
            }
            let name = format!("{}, n = {n}", family.slug);
            let now = Measured { name, n, zeros, family: Some(family.slug), verdicts };
            measured.extend(before.replace(now));
        }
        measured.extend(before);
    }
    Ok(LargeReport { report: Report::new(measured, UNIT, peers), growth })
}

/// What librate makes of a model; M and K go to a file.
///
/// # Errors
/// Where nobody answers; inside, what the model is refused for.
fn of_librate(
    family: &'static Large,
    size: usize,
    (ask, file): (Ask<'_>, &Path),
    plan: &Plan,
) -> Result<Result<(Growth, Answer), String>, Box<dyn Error>> {
    let file = file.display().to_string();
    let said = match ask([family.slug.to_owned(), size.to_string(), plan.patience.to_string(), file])? {
        Ok(said) => said,
        Err(said) => return Ok(Err(said.lines().next().unwrap_or("ended without a word").to_owned())),
    };
    let said: Value = serde_json::from_str(&said)?;
    let number = |key: &str| said[key].as_f64().ok_or("no answer");
    let exact = |text: &Value| text.as_str().and_then(|text| Number::from_f64_exact(text.parse().ok()?));
    let enclosure =
        |value: &Value| Some(Enclosure { mid: exact(&value[0])?.add(&exact(&value[1])?), radius: exact(&value[2])? });
    let values: Option<Vec<Enclosure>> = said["values"].as_array().ok_or("no values")?.iter().map(enclosure).collect();
    let seconds = number("seconds")?;
    let growth = Growth {
        slug: family.slug,
        n: (family.dimension)(size),
        seconds: [seconds, number("modes")?],
        megabytes: number("megabytes")?,
    };
    // The small problem of the modes that are wanted is all that has a level.
    Ok(Ok((growth, Answer { seconds, values: values.ok_or("no numbers")?, level: PrecisionLevel::Doubles })))
}

/// The argument of a process for one problem.
pub(crate) const ONE: &str = "--one";

/// One problem, from the text to the modes: a family, a size, the seconds of repeats, and a file for M and K.
///
/// # Errors
/// What the model is refused for, and what a file is.
pub(crate) fn one(root: &Path, [slug, size, patience, file]: [String; 4]) -> Result<String, Box<dyn Error>> {
    let (size, patience) = (size.parse::<u32>()?, patience.parse()?);
    let family = LARGE.iter().find(|family| family.slug == slug).ok_or("no such family")?;
    let text = std::fs::read_to_string(root.join(format!("models/large/{slug}.lag")))?;
    let (mut settings, mut tables) = (Settings::new().within(Budget::new(BYTES)), TableTexts::new());
    if slug == "network" {
        tables = tables.with("points.csv".to_owned(), points::table(size));
    } else {
        settings.add(&format!("N={size}"))?;
    }
    let options = Options::default().lowest(family.count).without_vectors();
    let (seconds, result) = fastest(patience, || -> Result<(Linearized, NormalModes), librate::Error> {
        let linearized = linearize(elaborate(&parse(&text)?, &tables, &settings)?)?;
        let modes = normal_modes(&linearized, &options)?;
        Ok((linearized, modes))
    });
    let (linearized, modes) = result?;
    let megabytes = peak().unwrap_or(f64::NAN);
    let (alone, _) = fastest(patience, || normal_modes(&linearized, &options));
    write_npz(&matrices(&linearized)?, File::create(file)?)?;
    let values = modes.modes.iter().map(|mode| {
        let own = mode.omega_squared.filter(|_| mode.kind != Kind::Zero);
        own.map_or([0.0; 3], |own| [own.mid.hi, own.mid.lo, own.radius]).map(|x| format!("{x:e}"))
    });
    let values: Vec<[String; 3]> = values.collect();
    Ok(json!({"seconds": seconds, "modes": alone, "megabytes": megabytes, "values": values}).to_string())
}

/// The most memory that this process had, in megabytes, where the system tells it.
fn peak() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kilobytes: f64 = line.split_whitespace().next()?.parse().ok()?;
    Some(1.024e-3 * kilobytes)
}
