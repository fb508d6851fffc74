//! `librate equilibria`.

use clap::Args;
use librate::diagnostic::Diagnostic;
use librate::equilibria::{self, Region};
use librate::report;

use super::args::ModelArgs;
use super::{Answer, Failure, Size, load_values, range, style};

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
    load_values(&args.model, Size::Any)?.answer(&args.model, "searching the box", |made, model, warnings| {
        let region = Region::parse(&args.region, &model)?;
        let (text, reasons) = if let Some(range) = &over {
            let diagram = equilibria::follow(made, &region, range)?;
            let text = if args.model.drawn {
                report::diagram_svg(&model, &diagram)
            } else if args.json {
                report::diagram_json(&model, &diagram)
            } else {
                report::diagram_text(&model, &diagram, &style())
            };
            (text, diagram.reasons)
        } else {
            let found = equilibria::find(&model, &region)?;
            let text = if args.model.drawn {
                report::equilibria_svg(&model, &found, &equilibria::landscape(&model, &region)?)
            } else if args.json {
                report::equilibria_json(&model, &found)
            } else {
                report::equilibria_text(&model, &found, &style())
            };
            (text, found.reasons)
        };
        warnings.extend(reasons.iter().map(Diagnostic::remark));
        Ok(text)
    })
}
