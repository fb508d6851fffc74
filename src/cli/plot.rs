//! `librate plot`: the answers of other commands as pictures.

use std::path::PathBuf;

use librate::report::{self, SweepView};

use super::args::{MessageFormat, Plotted};
use super::{Answer, Failure, chart, equilibria, modes_text, motion, period, response, sweep, wrong_request};

pub(super) fn text(what: &mut Plotted, format: MessageFormat) -> Result<Answer, Failure> {
    let (answer, output): (_, &Option<PathBuf>) = match what {
        Plotted::Modes(own) => (modes_text(&own.args, report::modes_svg), &own.output),
        Plotted::Spectrum(own) => (modes_text(&own.args, report::spectrum_svg), &own.output),
        Plotted::Sweep(own) => {
            own.drawn.args.view = SweepView::new(std::mem::take(&mut own.orders), own.root_locus);
            (sweep::text(&own.drawn.args), &own.drawn.output)
        }
        Plotted::Response(own) => (response::text(&own.args), &own.output),
        Plotted::Period(own) if own.args.over.is_none() => {
            let message = "a single period is no curve".to_owned();
            return Err(wrong_request(message, "write `--over amplitude=a..b:count` or `--over energy=a..b:count`"));
        }
        Plotted::Period(own) => (period::text(&own.args), &own.output),
        Plotted::Floquet(own) => match own.args.map.as_slice() {
            [first, second] => (chart::run(&own.args, first, second), &own.output),
            _ => {
                let message = "multipliers at one place are no chart".to_owned();
                return Err(wrong_request(message, "write `--map NAME=a..b:count NAME=c..d:count`"));
            }
        },
        Plotted::Motion(own) if own.args.start_table.is_some() => {
            let message = "motions from several starts are not drawn".to_owned();
            return Err(wrong_request(message, "draw one of them with `--start`"));
        }
        Plotted::Equilibria(own) => (equilibria::text(&own.args), &own.output),
        Plotted::Motion(own) => (motion::text(&own.args, format), &own.output),
    };
    answer?.into_file(output.as_deref())
}
