//! `librate equilibria`.

use clap::Args;
use librate::diagnostic::{Diagnostic, Severity};
use librate::equilibria::{self, Region};
use librate::{Error, report};

use super::args::ModelArgs;
use super::progress::Progress;
use super::{Answer, Failure, Loaded, Size, failed, load_values, style};

pub(super) const ABOUT: &str = "\
Every equilibrium in a box of coordinates, none missed: each with a proved enclosure, its stability and its lowest
frequency.

The box has a closed range for each coordinate, in its unit; the name of a family stands for all its members, and a
coordinate that nothing depends on may be left out. It is divided until each part is proved to have no equilibrium or
exactly one. Where that can't be decided (equilibria that coincide, or lie on a line), a message says so. What the file says with `guess`
and `equilibrium` is left aside, but for the rates of steady motions.";

pub(super) const EXAMPLE: &str = "\
Examples:
    librate equilibria double_well.lag --box x=-3..3
    librate equilibria bead_on_hoop.lag --box th=-pi..pi --set W=10
    librate equilibria earth_moon_l4.lag --box 'x=-2..2, y=-2..2' --json";

/// What can be typed.
#[derive(Debug, Args)]
pub(crate) struct Equilibria {
    #[command(flatten)]
    pub(crate) model: ModelArgs,
    /// A range for each coordinate: `x=-2..2, phi=-pi..pi`
    #[arg(long = "box", value_name = "RANGES", allow_hyphen_values = true)]
    pub(crate) region: String,
    /// JSON instead of text
    #[arg(long)]
    pub(crate) json: bool,
}

pub(super) fn text(args: &Equilibria) -> Result<Answer, Failure> {
    let Loaded { source, model, mut warnings } = load_values(&args.model, Size::Any)?;
    let progress = Progress::stages("searching the box", &args.model.guard);
    let computed = || -> Result<_, Error> {
        let region = Region::parse(&args.region, &model)?;
        Ok(equilibria::find(&model, &region)?)
    }();
    drop(progress);
    let found = match computed {
        Ok(found) => found,
        Err(error) => return Err(failed(source, warnings, error)),
    };
    warnings.extend(found.reasons.iter().map(|reason| {
        let mut told = Diagnostic::global(reason);
        told.severity = Severity::Warning;
        told
    }));
    let text = if args.json {
        report::equilibria_json(&model, &found)
    } else {
        report::equilibria_text(&model, &found, &style())
    };
    Ok(Answer::new(text, Some((source, warnings))))
}
