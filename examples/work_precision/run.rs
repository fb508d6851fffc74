//! What is measured: times, and errors against 40 digits.

use std::error::Error;
use std::path::Path;

use librate::linearize::linearize;
use librate::model::{self, Constant, Model};
use librate::motion::{Start, System, Times, Trajectory};
use librate::number::Number;
use librate::precision::{Ball, Big};
use librate::syntax;
use serde_json::{Value, json};

use super::clock::fastest;
use super::process::Peers;

/// The model, as a user writes it.
pub(crate) const MODEL: &str = "param g = 9.81
coord p, q
let r1 = [sin(p), -cos(p)]
let r2 = r1 + [sin(q), -cos(q)]
T = 1/2*dot(r1', r1') + 1/2*dot(r2', r2')
V = g*r1[2] + g*r2[2]";
/// Where it starts.
const START: &str = "p = 3/10, q = 3/10";
/// For how many seconds.
pub(crate) const UNTIL: f64 = 100.0;
/// Bits that errors are told with.
const BITS: usize = 160;
/// What integrators are asked for.
const TOLERANCES: std::ops::RangeInclusive<i32> = 4..=18;

/// An integrator.
pub(crate) struct Method {
    pub(crate) name: &'static str,
    /// The package it needs; none for librate.
    package: Option<&'static str>,
    /// The smallest tolerance that it is asked for, as a power of ten.
    last: i32,
}

/// In doubles, to a tolerance.
pub(crate) const QUICK: &str = "librate, to a tolerance";
/// What a motion gives without one.
pub(crate) const FULL: &str = "librate, all digits";
/// The fastest peer.
pub(crate) const HEYOKA: &str = "heyoka";
/// The usual peer.
pub(crate) const DOP853: &str = "SciPy DOP853";

pub(crate) const METHODS: [Method; 7] = [
    Method { name: QUICK, package: None, last: 17 },
    Method { name: FULL, package: None, last: 0 },
    Method { name: HEYOKA, package: Some("heyoka"), last: 16 },
    Method { name: "heyoka, 80 bits", package: Some("heyoka"), last: 18 },
    // SciPy takes no relative tolerance below 100 units of rounding.
    Method { name: DOP853, package: Some("scipy"), last: 13 },
    Method { name: "SciPy LSODA", package: Some("scipy"), last: 13 },
    Method { name: "SciPy Radau", package: Some("scipy"), last: 11 },
];

/// One trip.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Trip {
    /// As a power of ten; `None` where none is asked for.
    pub(crate) tolerance: Option<i32>,
    /// CPU seconds.
    pub(crate) seconds: f64,
    /// CPU seconds of what is done once for a model.
    pub(crate) prepared: f64,
    /// The largest error of the two angles and their rates at the end.
    pub(crate) error: f64,
}

/// All trips of a method.
pub(crate) struct Line {
    pub(crate) name: &'static str,
    pub(crate) trips: Vec<Trip>,
    /// Why there is none, or no more.
    pub(crate) remark: Option<String>,
}

impl Line {
    /// The time that an error takes, between the trips on both sides of it on logarithmic scales; `None` where the
    /// method does not reach it or is only measured below.
    pub(crate) fn time_at(&self, error: f64) -> Option<f64> {
        let (error, log) = (error.ln(), f64::ln);
        self.trips.windows(2).find_map(|pair| {
            let [coarse, fine] = [pair[0], pair[1]].map(|trip| (log(trip.error), log(trip.seconds)));
            if !(fine.0 <= error && error <= coarse.0 && fine.0 < coarse.0) {
                return None;
            }
            let share = (coarse.0 - error) / (coarse.0 - fine.0);
            Some((coarse.1 + share * (fine.1 - coarse.1)).exp())
        })
    }

    /// The smallest error.
    pub(crate) fn best(&self) -> f64 {
        let errors = self.trips.iter().map(|trip| trip.error);
        errors.fold(f64::INFINITY, f64::min)
    }
}

pub(crate) struct Report {
    pub(crate) lines: Vec<Line>,
    pub(crate) versions: Result<Vec<(String, Option<String>)>, String>,
}

impl Report {
    pub(crate) fn line(&self, name: &str) -> Option<&Line> {
        self.lines.iter().find(|line| line.name == name && !line.trips.is_empty())
    }
}

/// The four numbers at the end, from the reference.
fn truth(root: &Path) -> Result<Vec<Big>, Box<dyn Error>> {
    let text = std::fs::read_to_string(root.join("tests/reference/motion.json"))?;
    let all: Value = serde_json::from_str(&text)?;
    let last = all["double_pendulum"].as_array().and_then(|rows| rows.last());
    let row = last.and_then(Value::as_array).ok_or("no reference")?;
    let values = row.iter().map(|value| value.as_str().and_then(decimal));
    values.collect::<Option<_>>().ok_or_else(|| "no number".into())
}

/// A decimal number of any length.
fn decimal(text: &str) -> Option<Big> {
    let size = Big::from_number(&Number::parse(text.trim_start_matches('-'))?, BITS);
    Some(if text.starts_with('-') { -&size } else { size })
}

fn worst(own: &[Big], truth: &[Big]) -> f64 {
    let off = own.iter().zip(truth).map(|(own, truth)| (own - truth).mid_f64().abs());
    if own.len() == truth.len() { off.fold(0.0, f64::max) } else { f64::NAN }
}

fn end(trajectory: &Trajectory) -> Vec<Big> {
    let last = trajectory.rows.last().map_or(&[][..], Vec::as_slice);
    last.iter().map(|value| Big::from_ball(&Ball::from(value.mid), BITS)).collect()
}

fn elaborated() -> Result<Model, Box<dyn Error>> {
    let file = syntax::parse(MODEL).map_err(librate::Error::from)?;
    Ok(model::elaborate(&file, &Default::default(), &Default::default()).map_err(librate::Error::from)?)
}

/// Measures all methods that are there; a method ends where a trip takes longer than `longest`.
pub(crate) fn run(
    root: &Path,
    mut peers: Result<Peers, String>,
    patience: f64,
    longest: f64,
) -> Result<Report, Box<dyn Error>> {
    let truth = truth(root)?;
    let model = elaborated()?;
    let (prepared, system) = fastest(patience, || System::new(&model));
    let system = system?;
    let linearized = linearize(model.clone())?;
    let start = Start::parse(START, &model, Some(&linearized), &system)?;
    let times = Times::new(&Constant::parse(&UNTIL.to_string())?, 2)?;
    let own = |tolerance: Option<i32>| -> Result<Trip, String> {
        let (seconds, found) = fastest(patience, || match tolerance {
            Some(digits) => system.quick(&start, &times, 10f64.powi(-digits)),
            None => system.motion(&start, &times),
        });
        let found = found.map_err(|error| error.to_string())?;
        let error = worst(&end(&found), &truth);
        Ok(Trip { tolerance, seconds, prepared, error })
    };
    let mut lines = Vec::new();
    for method in &METHODS {
        let mut line = Line { name: method.name, trips: Vec::new(), remark: None };
        let tolerances: Vec<Option<i32>> = match method.last {
            0 => vec![None],
            last => TOLERANCES.filter(|digits| *digits <= last).map(Some).collect(),
        };
        if let (Some(package), Ok(peers)) = (method.package, &peers)
            && !peers.has(package)
        {
            line.remark = Some(format!("{package} is not installed"));
            lines.push(line);
            continue;
        }
        for tolerance in tolerances {
            let trip = match (method.package, &mut peers) {
                (None, _) => own(tolerance),
                (Some(_), Err(reason)) => Err(reason.clone()),
                (Some(_), Ok(peers)) => asked(peers, method.name, tolerance, patience, &truth),
            };
            match trip {
                Ok(trip) => line.trips.push(trip),
                Err(reason) => {
                    line.remark = Some(reason);
                    break;
                }
            }
            if line.trips.last().is_some_and(|trip| trip.seconds > longest) {
                break;
            }
        }
        lines.push(line);
    }
    let versions = peers.map(|peers| peers.versions.clone());
    Ok(Report { lines, versions })
}

fn asked(peers: &mut Peers, name: &str, tolerance: Option<i32>, patience: f64, truth: &[Big]) -> Result<Trip, String> {
    let asked = tolerance.map(|digits| 10f64.powi(-digits));
    peers.ask(&json!({"run": name, "tolerance": asked, "until": UNTIL, "patience": patience}))?;
    let answer = peers.answer()?;
    let state = answer["state"].as_array().map_or(&[][..], Vec::as_slice);
    let state: Option<Vec<Big>> = state.iter().map(|x| x.as_str().and_then(decimal)).collect();
    let times = (answer["seconds"].as_f64(), answer["prepared"].as_f64());
    let (Some(state), (Some(seconds), Some(prepared))) = (state, times) else {
        return Err("no answer".to_owned());
    };
    Ok(Trip { tolerance, seconds, prepared, error: worst(&state, truth) })
}
