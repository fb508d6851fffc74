//! The same model over a range of one parameter: a [`Range`].
//!
//! Each place of the range makes the whole trip, with the value put in exactly as `--set` would: certified
//! frequencies, an equilibrium of its own, and as many modes as there are then. For thousands of sets
//! in doubles there is `batch::Study`.

use crate::error::Error;
use librate_core::linearize::{self, Linearized};
use librate_core::model::{self, Range, Settings, TableTexts};
use librate_core::modes::Options;
use librate_core::oscillation::{self, NormalModes};
use librate_core::syntax::File;

/// The model at one place of a range.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Place {
    /// The parameter's value as it was put in, in the unit that it is declared with; rounded to a double.
    pub value: f64,
    /// The linearized model and its modes, or why there are none.
    pub result: Result<(Linearized, NormalModes), Error>,
}

/// The modes at each place of a range, one after the other as they are asked for.
pub fn sweep<'a>(
    file: &'a File,
    tables: &'a TableTexts,
    settings: &'a Settings,
    range: &'a Range,
    options: &'a Options,
) -> impl ExactSizeIterator<Item = Place> + 'a {
    (0..range.len()).map(move |place| {
        let solve = || -> Result<(Linearized, NormalModes), Error> {
            let mut settings = settings.clone();
            settings.add(&format!("{} = {}", range.name(), range.expression(place)))?;
            linearize::check_size(model::coordinate_count(file, tables, &settings))?;
            let model = model::elaborate(file, tables, &settings)?;
            let linearized = linearize::linearize(model)?;
            let modes = oscillation::normal_modes(&linearized, options)?;
            Ok((linearized, modes))
        };
        Place { value: range.value(place).unwrap_or(f64::NAN), result: solve() }
    })
}
