//! The period over a range of amplitudes or energies.

use super::{Options, Oscillator, Period, PeriodError, Request};
use librate_core::model::{Constant, ModelError, Range};

/// The motion at one place of a range.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Place {
    /// The amplitude or energy as it was put in, rounded to a double.
    pub value: f64,
    /// Its period, or why there is none.
    pub result: Result<Period, PeriodError>,
}

/// The periods at each place of a range `amplitude=a..b:count` or `energy=a..b:count`, one after the other as they are
/// asked for.
///
/// # Errors
/// [`ModelError::BadSetting`] for another name.
pub fn curve<'a>(
    oscillator: &'a Oscillator,
    range: &'a Range,
    options: &'a Options,
) -> Result<impl ExactSizeIterator<Item = Place> + 'a, ModelError> {
    let request = match range.name() {
        "amplitude" => Request::Amplitude,
        "energy" => Request::Energy,
        other => {
            return Err(ModelError::BadSetting {
                text: other.to_owned(),
                reason: "a period depends on the `amplitude` or the `energy`".to_owned(),
            });
        }
    };
    let constants = (0..range.len()).map(|place| Constant::parse(&range.expression(place)));
    let constants = constants.collect::<Result<Vec<Constant>, ModelError>>()?;
    Ok(constants.into_iter().enumerate().map(move |(at, constant)| Place {
        value: range.value(at).unwrap_or(f64::NAN),
        result: oscillator.period(&request(constant), options),
    }))
}
