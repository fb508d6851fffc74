//! Tables that are longer than memory: a motion is computed at part of the times, which tells its digits, and followed once more for
//! all of its rows, one after the other.
//!
//! It keeps no row.

use super::step::Real;
use super::{Enclosed, FINE, MotionError, Start, System, Times, Trajectory, quick};
use librate_core::linearize::LinearizeError;
use librate_core::precision::{Ball, Big, DoubleDouble};

/// A table is computed at once up to so many numbers.
const MOST_AT_ONCE: usize = 1_000_000;
/// Of one that is not, at least so many rows.
const FEWEST_ROWS: usize = 200;

impl Times {
    /// The times to compute at once for rows of so many numbers: these, or fewer from t = 0 to the same end.
    #[must_use]
    pub fn at_once(&self, numbers: usize) -> Self {
        if self.listed.is_some() {
            return self.clone();
        }
        let rows = (MOST_AT_ONCE / numbers.max(1)).max(FEWEST_ROWS);
        Self { samples: self.samples.min(rows), ..self.clone() }
    }
}

impl Trajectory {
    /// What values at a row of other times, to the same end, are off by: as much as at the rows on both sides of it.
    fn errors(&self, row: usize, times: &Times) -> impl Iterator<Item = f64> {
        let (last, other) = (self.rows.len().max(1) - 1, times.len().max(2) - 1);
        let place = row as u128 * last as u128;
        let at = |place: u128| usize::try_from(place).map_or(last, |at| at.min(last));
        let below = self.rows.get(at(place / other as u128));
        let above = self.rows.get(at(place.div_ceil(other as u128)));
        let both = below.into_iter().flatten().zip(above.into_iter().flatten());
        both.map(|(below, above)| below.radius.max(above.radius))
    }
}

impl System {
    /// Every row of a motion, one after the other, as long as `each` says to go on; what errors are estimated to be comes
    /// from the same motion at other times. With a tolerance the run is [`System::quick`]'s.
    ///
    /// # Errors
    /// As [`System::motion`].
    pub fn rows(
        &self,
        start: &Start,
        times: &Times,
        known: &Trajectory,
        tolerance: Option<f64>,
        mut each: impl FnMut(usize, Vec<Ball>) -> bool,
    ) -> Result<(), MotionError> {
        if let Some(tolerance) = tolerance {
            let mut each = |row: usize, values: Vec<f64>| each(row, values.into_iter().map(Ball::exact).collect());
            self.run::<f64>(start, times, quick(tolerance), &mut each)?;
        } else {
            let mut each = |row: usize, values: Vec<DoubleDouble>| {
                if row == 0 {
                    return each(0, start.row());
                }
                let values = values.into_iter().zip(known.errors(row, times));
                let values = values.map(|(x, error)| Ball::new(x.to_ball().mid, error));
                each(row, values.collect())
            };
            self.run::<DoubleDouble>(start, times, FINE, &mut each)?;
        }
        Ok(())
    }
}

impl Enclosed {
    /// Every row of a motion, one after the other, as long as `each` says to go on, with as many bits as it took at other times
    /// to the same end.
    ///
    /// # Errors
    /// As [`Enclosed::motion`].
    pub fn rows(
        &self,
        start: &Start,
        times: &Times,
        known: &Trajectory,
        mut each: impl FnMut(usize, Vec<Ball>) -> bool,
    ) -> Result<(), MotionError> {
        let bits = known.proved.unwrap_or(Self::BITS);
        let run = if bits == Self::BITS {
            self.run::<Ball>(start, times, Self::order(bits), (), &mut each)
        } else {
            self.run::<Big>(start, times, Self::order(bits), bits, &mut each)
        };
        self.budget.check().map_err(LinearizeError::from)?;
        run?.stuck.map_or(Ok(()), |stuck| Err(stuck.error()))
    }
}
