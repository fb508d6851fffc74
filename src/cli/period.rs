//! `librate period`.

use librate::diagnostic::Diagnostic;
use librate::model::{ModelError, Range};
use librate::period::{self, Options, Oscillator, Place, Request};
use librate::refine;
use librate::report::{self, Remarks};

use super::args;
use super::{
    Answer, Failure, Loaded, Size, constant, during, failed, load_values, range, style, wrong_request, wrong_value,
};

/// What is asked for.
enum Wish {
    One(Request),
    Curve(Range),
}

fn wish(args: &args::Period) -> Result<Wish, Failure> {
    let number = |text: &str| constant(text, "amplitudes and energies are numbers: `1/2`, `pi - 1e-6`, `sqrt(2)`");
    if let Some(text) = &args.over {
        let help = "write `--over amplitude=a..b:count` or `--over energy=a..b:count`";
        let range = range(text, help)?;
        if !matches!(range.name(), "amplitude" | "energy") {
            let message = format!("a period has no curve over `{}`", range.name());
            return Err(wrong_request(message, help));
        }
        return Ok(Wish::Curve(range));
    }
    match (&args.amplitude, &args.energy) {
        (Some(text), None) => Ok(Wish::One(Request::Amplitude(number(text)?))),
        (None, Some(text)) => Ok(Wish::One(Request::Energy(number(text)?))),
        _ => Err(wrong_request(
            "the motion is not specified".to_owned(),
            "write `--amplitude A`, `--energy E` or `--over amplitude=a..b:count`",
        )),
    }
}

pub(super) fn text(args: &args::Period) -> Result<Answer, Failure> {
    let wish = wish(args)?;
    let options = Options::default().digits(args.digits);
    let Loaded { source, model, mut warnings, .. } = load_values(&args.model, Size::Dense)?;
    let oscillator = Oscillator::of_model(&model).map_err(|error| failed(&source, &warnings, error))?;
    let text = match wish {
        Wish::One(request) => {
            let found = during(&args.model, "integrating the period", || oscillator.period(&request, &options));
            let found = found.map_err(|error| failed(&source, &warnings, error))?;
            if args.json {
                report::period_json(&oscillator, &found, &options)
            } else {
                report::period_text(&oscillator, &found, &options, &style())
            }
        }
        Wish::Curve(range) => {
            let work = || match args.model.drawn {
                true => refined(&oscillator, &range, &options),
                false => Ok(period::curve(&oscillator, &range, &options)?.collect::<Vec<Place>>()),
            };
            let places = during(&args.model, "integrating the periods over the range", work);
            let places = places.map_err(|error: ModelError| wrong_value(&error))?;
            let mut remarks = Remarks::new(range.name());
            for (value, error) in places.iter().filter_map(|own| Some((own.value, own.result.as_ref().err()?))) {
                remarks.add(value, vec![Diagnostic::from(error)]);
            }
            warnings.extend(remarks.all);
            if places.iter().all(|place| place.result.is_err()) {
                return Err(Failure::Model(source, warnings));
            }
            if args.model.drawn {
                report::period_svg(oscillator.model(), &range, &places)
            } else if args.json {
                report::period_curve_json(&oscillator, &places, &options)
            } else {
                report::period_csv(&range, &places, &options)
            }
        }
    };
    Ok(Answer::new(text, Some((source, warnings))))
}

/// With places between where the curve bends.
fn refined(oscillator: &Oscillator, range: &Range, options: &Options) -> Result<Vec<Place>, ModelError> {
    let (finest, step) = refine::finest(range);
    let row = |place: &Place| vec![place.result.as_ref().map_or(f64::NAN, |own| own.period.mid_f64())];
    refine::refined(range.len(), step, row, |places| {
        places.iter().map(|at| period::place(oscillator, &finest, *at, options)).collect()
    })
}
