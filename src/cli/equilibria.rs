//! `librate equilibria`.

use clap::Args;
use librate::diagnostic::Diagnostic;
use librate::equilibria::{self, Region};
use librate::{Error, report};

use super::args::ModelArgs;
use super::{Answer, Failure, Loaded, Size, during, failed, load_values, range, style};

pub(super) const ABOUT: &str = "\
Every equilibrium in a box of coordinates, none missed: each with a proved enclosure, its stability and its lowest
frequency.

The box has a closed range for each coordinate, in its unit; the name of a family stands for all its members, and a
coordinate that nothing depends on may be left out. It is divided until each part is proved to have no equilibrium or
exactly one. Where that can't be decided (equilibria that coincide, or lie on a line), a message says so. What the file says with `guess`
and `equilibrium` is left aside, but for the rates of steady motions.

With --over the equilibria at each value of a parameter are connected to branches, each proved to be one, and folds, pitchforks and
crossings in which branches end or meet are proved and located. What begins and ends between two neighbouring values is not seen.";

pub(super) const EXAMPLE: &str = "\
Examples:
    librate equilibria models/double_well.lag --box x=-3..3
    librate equilibria models/bead_on_hoop.lag --box th=-pi..pi --set W=10
    librate equilibria models/bead_on_hoop.lag --box th=-1..1 --over W=0..20:41
    librate equilibria models/earth_moon_l4.lag --box 'x=-2..2, y=-2..2' --json";

/// What can be typed.
#[derive(Debug, Args)]
pub(crate) struct Equilibria {
    #[command(flatten)]
    pub(crate) model: ModelArgs,
    /// A range for each coordinate: `x=-2..2, phi=-pi..pi`
    #[arg(long = "box", value_name = "RANGES", allow_hyphen_values = true)]
    pub(crate) region: String,
    /// Values of a parameter over which branches are followed: first, last and how many
    #[arg(long, value_name = "NAME=a..b:count")]
    pub(crate) over: Option<String>,
    /// JSON instead of text
    #[arg(long)]
    pub(crate) json: bool,
}

pub(super) fn text(args: &Equilibria) -> Result<Answer, Failure> {
    let help = "write `--over NAME=a..b:count`: `--over P=0..1:101`";
    let over = args.over.as_deref().map(|text| range(text, help)).transpose()?;
    let Loaded { source, made, model, mut warnings } = load_values(&args.model, Size::Any)?;
    let computed = during(&args.model, "searching the box", || -> Result<(String, Vec<String>), Error> {
        let region = Region::parse(&args.region, &model)?;
        let Some(range) = &over else {
            let found = equilibria::find(&model, &region)?;
            let text = if args.model.drawn {
                report::equilibria_svg(&model, &found, &equilibria::landscape(&model, &region)?)
            } else if args.json {
                report::equilibria_json(&model, &found)
            } else {
                report::equilibria_text(&model, &found, &style())
            };
            return Ok((text, found.reasons));
        };
        let diagram = equilibria::follow(&made, &region, range)?;
        let text = if args.model.drawn {
            report::diagram_svg(&model, &diagram)
        } else if args.json {
            report::diagram_json(&model, &diagram)
        } else {
            report::diagram_text(&model, &diagram, &style())
        };
        Ok((text, diagram.reasons))
    });
    let (text, reasons) = computed.map_err(|error| failed(&source, &warnings, error))?;
    warnings.extend(reasons.iter().map(Diagnostic::remark));
    Ok(Answer::new(text, Some((source, warnings))))
}
