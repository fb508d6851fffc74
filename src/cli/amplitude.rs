//! `librate amplitude`.

use librate::{Error, amplitude, linearize, modes, oscillation, report};

use super::args;
use super::{Answer, Failure, Loaded, Size, during, failed, load_values, style};

/// Shapes to fewer digits would cost digits of the change.
const SHAPE_DIGITS: usize = 14;

pub(super) fn text(args: &args::Amplitude) -> Result<Answer, Failure> {
    let Loaded { source, model, mut warnings, .. } = load_values(&args.model, Size::Dense)?;
    let options = modes::Options::default().digits(args.digits.max(SHAPE_DIGITS));
    let computed = during(&args.model, "computing the modes and their change", || -> Result<_, Error> {
        amplitude::check(&model)?;
        let linearized = linearize::linearize(model.clone())?;
        let normal = oscillation::normal_modes(&linearized, &options)?;
        let found = amplitude::amplitude(&linearized, &normal)?;
        Ok((linearized, normal, found))
    });
    let (linearized, normal, found) = computed.map_err(|error| failed(&source, &warnings, error))?;
    warnings.extend(normal.warnings(&linearized));
    let text = if args.json {
        report::amplitude_json(&linearized, &normal, &found, args.digits)
    } else {
        report::amplitude_text(&linearized, &normal, &found, args.digits, &style())
    };
    Ok(Answer::new(text, Some((source, warnings))))
}
