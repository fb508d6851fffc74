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
    let requests = (0..range.len()).map(|at| request(range, at)).collect::<Result<Vec<Request>, ModelError>>()?;
    Ok(requests
        .into_iter()
        .enumerate()
        .map(move |(at, request)| at_request(oscillator, range, (at, &request), options)))
}

/// The period at one of them.
///
/// # Errors
/// As [`curve`].
pub fn place(oscillator: &Oscillator, range: &Range, at: usize, options: &Options) -> Result<Place, ModelError> {
    Ok(at_request(oscillator, range, (at, &request(range, at)?), options))
}

fn at_request(oscillator: &Oscillator, range: &Range, (at, request): (usize, &Request), options: &Options) -> Place {
    Place { value: range.value(at).unwrap_or(f64::NAN), result: oscillator.period(request, options) }
}

fn request(range: &Range, at: usize) -> Result<Request, ModelError> {
    let constant = Constant::parse(&range.expression(at))?;
    match range.name() {
        "amplitude" => Ok(Request::Amplitude(constant)),
        "energy" => Ok(Request::Energy(constant)),
        other => Err(ModelError::BadSetting {
            text: other.to_owned(),
            reason: "a period depends on the `amplitude` or the `energy`".to_owned(),
        }),
    }
}
