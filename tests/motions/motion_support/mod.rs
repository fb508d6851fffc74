//! Motions as tests ask for them, held against tests/reference/motion.json.

#![allow(
    dead_code,
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "tests stop at the first surprise, and no test uses all of this"
)]

use librate::linearize::{Linearized, linearize};
use librate::model::{Constant, Model};
use librate::motion::{Enclosed, MotionError, Start, System, Times, Trajectory};
use librate::number::Number;
use librate::precision::{Big, Scalar};
use librate::report::motion_csv;

pub(crate) const BITS: usize = 200;

pub(crate) fn times(until: &str, samples: usize) -> Times {
    Times::new(&Constant::parse(until).unwrap(), samples).unwrap()
}

/// An amplitude that is a part of what the model is made of: a molecule is not a metre long.
pub(crate) fn share(linearized: &Linearized, part: f64) -> Constant {
    let places = linearized.equilibrium().values.iter();
    let large = places.map(|x| x.mid_f64().abs()).fold(0.0, f64::max);
    let size = if large > 0.0 && large < 1e-3 { large } else { 1.0 };
    Constant::parse(&format!("{:e}", part * size)).unwrap()
}

pub(crate) fn start(model: &Model, text: &str) -> Start {
    let system = System::new(model).unwrap();
    let linearized = linearize(model.clone()).ok();
    Start::parse(text, model, linearized.as_ref(), &system).unwrap()
}

pub(crate) fn motion(model: &Model, from: &str, until: &str, samples: usize) -> Trajectory {
    let system = System::new(model).unwrap();
    system.motion(&start(model, from), &times(until, samples)).unwrap()
}

pub(crate) fn decimal(text: &str) -> Big {
    Big::from_number(&Number::parse(text.trim_start_matches('-')).unwrap(), BITS)
}

pub(crate) fn signed(text: &str) -> Big {
    let value = decimal(text);
    if text.starts_with('-') { value.neg() } else { value }
}

pub(crate) fn reference(name: &str) -> Vec<Vec<String>> {
    let text = std::fs::read_to_string("tests/reference/motion.json").unwrap();
    let all: serde_json::Value = serde_json::from_str(&text).unwrap();
    let rows = all[name].as_array().unwrap().iter();
    rows.map(|row| {
        let row = row.as_array().unwrap().iter();
        row.map(|value| value.as_str().unwrap().to_owned()).collect()
    })
    .collect()
}

/// Holds estimates of the error and printed digits against the reference.
pub(crate) fn check(name: &str, model: &Model, trajectory: &Trajectory, digits: usize) {
    let want = reference(name);
    assert_eq!(trajectory.rows.len(), want.len(), "{name}");
    for (row, want) in trajectory.rows.iter().zip(&want) {
        assert_eq!(row.len(), want.len(), "{name}");
        for (own, want) in row.iter().zip(want) {
            let off = Big::from_ball(own, BITS).sub(&signed(want)).mid_f64().abs();
            // References have 40 digits. Where nothing is proved, a start that is rounded to 31 counts as exact in the radius.
            let unit = if trajectory.proved.is_some() { 1e-39 } else { 1e-31 };
            let bound = own.radius + unit * signed(want).mid_f64().abs().max(1.0);
            assert!(off <= bound, "{name}: {own:?} is off by {off:e} from {want}");
        }
    }
    let csv = motion_csv(model, trajectory, None, digits);
    let mut table = csv::Reader::from_reader(csv.as_bytes());
    for (row, want) in table.records().zip(&want) {
        for (cell, want) in row.unwrap().iter().skip(1).zip(want) {
            let (own, want) = (signed(cell), signed(want));
            let off = own.sub(&want).mid_f64().abs();
            // What is 0 comes as 1e-60 from the reference.
            if want.mid_f64().abs() < 1e-45 {
                assert_eq!(cell, "0", "{name}");
                continue;
            }
            let unit = 10.0_f64.powf(own.mid_f64().abs().log10().floor() + 1.0)
                / 10.0_f64.powi(i32::try_from(digits).unwrap());
            assert!(off <= 0.5001 * unit, "{name}: {cell} is off by {off:e}");
        }
    }
}

/// The same with a proof.
pub(crate) fn proved(
    model: &Model,
    from: &str,
    until: &str,
    samples: usize,
    digits: usize,
) -> Result<Trajectory, MotionError> {
    Enclosed::new(model)?.motion(&start(model, from), &times(until, samples), digits)
}
