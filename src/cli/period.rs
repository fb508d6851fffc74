//! `librate period`.

use librate::diagnostic::Diagnostic;
use librate::model::{Constant, ModelError, Range};
use librate::period::{self, Options, Oscillator, Place, Request};
use librate::report;

use super::args;
use super::input::Source;
use super::progress::Progress;
use super::{Answer, Failure, Loaded, Size, failed, load_values, style, wrong_request, wrong_setting};

/// What is asked for.
enum Wish {
    One(Request),
    Curve(Range),
}

fn wish(args: &args::Period) -> Result<Wish, Failure> {
    let constant = |text: &str| {
        Constant::parse(text).map_err(|error| {
            let reason = match error {
                ModelError::BadSetting { reason, .. } => reason,
                other => other.to_string(),
            };
            let help = "amplitudes and energies are numbers: `1/2`, `pi - 1e-6`, `sqrt(2)`";
            wrong_request(format!("can't read `{text}`: {reason}"), help)
        })
    };
    if let Some(range) = &args.over {
        let help = "write `--over amplitude=a..b:count` or `--over energy=a..b:count`";
        let range = Range::parse(range).map_err(|error| wrong_request(error.to_string(), help))?;
        if !matches!(range.name(), "amplitude" | "energy") {
            let message = format!("a period has no curve over `{}`", range.name());
            return Err(wrong_request(message, help));
        }
        return Ok(Wish::Curve(range));
    }
    match (&args.amplitude, &args.energy) {
        (Some(text), None) => Ok(Wish::One(Request::Amplitude(constant(text)?))),
        (None, Some(text)) => Ok(Wish::One(Request::Energy(constant(text)?))),
        _ => Err(wrong_request(
            "the motion is not specified".to_owned(),
            "write `--amplitude A`, `--energy E` or `--over amplitude=a..b:count`",
        )),
    }
}

pub(super) fn text(args: &args::Period) -> Result<Answer, Failure> {
    let wish = wish(args)?;
    let options = Options::default().digits(args.digits);
    let Loaded { source, model, mut warnings } = load_values(&args.model, Size::Dense)?;
    let oscillator = match Oscillator::of_model(&model) {
        Ok(oscillator) => oscillator,
        Err(error) => return Err(failed(source, warnings, error)),
    };
    let text = match wish {
        Wish::One(request) => {
            let progress = Progress::start("integrating the period");
            let found = oscillator.period(&request, &options);
            drop(progress);
            let found = match found {
                Ok(found) => found,
                Err(error) => return Err(failed(source, warnings, error)),
            };
            if args.json {
                report::period_json(&oscillator, &found, &options)
            } else {
                report::period_text(&oscillator, &found, &options, &style())
            }
        }
        Wish::Curve(range) => {
            let progress = Progress::start("integrating the periods over the range");
            let places = period::curve(&oscillator, &range, &options).map(|places| places.collect::<Vec<Place>>());
            drop(progress);
            let places = places.map_err(|error| wrong_setting(&error))?;
            remark(&source, &range, &places, &mut warnings)?;
            if args.model.drawn {
                report::period_svg(&range, &places, oscillator.model().has_units)
            } else if args.json {
                report::period_curve_json(&oscillator, &places, &options)
            } else {
                report::period_csv(&range, &places, &options)
            }
        }
    };
    Ok(Answer::new(text, Some((source, warnings))))
}

/// Why places have no period, each reason once; an error where none has.
fn remark(source: &Source, range: &Range, places: &[Place], warnings: &mut Vec<Diagnostic>) -> Result<(), Failure> {
    let errors = places.iter().filter_map(|place| Some((place.value, place.result.as_ref().err()?)));
    let errors: Vec<_> = errors.collect();
    let mut told: Vec<Diagnostic> = Vec::new();
    for (value, error) in &errors {
        let mut diagnostic = Diagnostic::from(*error);
        if told.iter().all(|other| other.code != diagnostic.code) {
            diagnostic.message = format!("at {} = {value}: {}", range.name(), diagnostic.message);
            told.push(diagnostic);
        }
    }
    warnings.extend(told);
    if !places.is_empty() && errors.len() == places.len() {
        return Err(Failure::Model(source.clone(), std::mem::take(warnings)));
    }
    Ok(())
}
