//! `librate show`: a page with the modes in motion.

use librate::derive::{self, Parts};
use librate::diagnostic::Diagnostic;
use librate::report::{self, Shown};
use librate::{figure, modes, oscillation};

use super::output::into_file;
use super::progress::Progress;
use super::{Answer, Failure, Loaded, Size, args, failed, load, solved, wrong_request};

/// A page of more modes would be too long to look through.
const MOST_MODES: usize = 200;

pub(super) fn text(args: &args::Show) -> Result<Answer, Failure> {
    let Loaded { mut source, model, mut warnings } =
        load(&args.model, if args.lowest.is_some() { Size::Any } else { Size::Dense })?;
    let shown = args.lowest.unwrap_or(model.coordinates.len());
    if shown > MOST_MODES {
        let help = format!("choose some: `--lowest 20`; a page has room for {MOST_MODES}");
        return Err(wrong_request(format!("{shown} modes are too many for a page"), &help));
    }
    let mut options = modes::Options::default().digits(args.digits);
    options.lowest = args.lowest;
    let progress = Progress::stages("computing the modes", &args.model.guard);
    // A derivation may fail where there are modes, and is left out then.
    let derivation = derive::derive(&model, &Parts::all()).ok();
    let computed = solved(model, &options);
    drop(progress);
    let (linearized, modes) = match computed {
        Ok(computed) => computed,
        Err(error) => return Err(failed(source, warnings, error)),
    };
    warnings.extend(oscillation::warnings(&linearized, &modes).iter().map(Diagnostic::from));
    let figure = figure::figure(&linearized);
    let mut page = report::show_html(&Shown {
        text: &source.text,
        linearized: &linearized,
        modes: &modes,
        options: &options,
        figure: figure.as_ref(),
        derivation: derivation.as_ref(),
    });
    into_file(args.output.as_ref(), &mut page, &mut source)?;
    Ok(Answer::new(page, Some((source, warnings))))
}
