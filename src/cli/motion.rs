//! `librate motion`.

use std::io::{self, Write};

use anstream::AutoStream;
use librate::diagnostic::Diagnostic;
use librate::linearize::{Feature, LinearizeError, linearize};
use librate::model::Model;
use librate::motion::{self, Enclosed, MotionError, Start, System, Times, Trajectory};
use librate::report::{self, MotionsCsv};
use librate::{Error, modes, oscillation};

use super::args::{self, MessageFormat};
use super::input::{self, Source};
use super::threads::in_order;
use super::{Answer, Failure, Loaded, Size, constant, during, failed, load_values, output};

const HELP: &str = "times and amplitudes are numbers: `10`, `1/2`, `2*pi`";

/// Rows of a table, and points of a curve that looks smooth.
const SAMPLES: usize = 101;
const SAMPLES_DRAWN: usize = 601;

pub(super) fn text(args: &args::Motion, format: MessageFormat) -> Result<Answer, Failure> {
    // Either an end or a table of times is there.
    let until = constant(args.until.as_deref().unwrap_or("0"), HELP)?;
    let [at, starts] = [&args.at, &args.start_table].map(|file| file.as_deref().map(input::read_table).transpose());
    let (at, starts) = (at?, starts?);
    let amplitude = args.amplitude.as_deref().map(|text| constant(text, HELP)).transpose()?;
    let Loaded { mut source, model, warnings, .. } = load_values(&args.model, Size::Dense)?;
    source.taken.extend([&at, &starts].into_iter().flatten().flat_map(|table| table.taken.clone()));
    let computed = during(&args.model, "integrating the motion", || -> Result<_, Error> {
        let system = System::new(&model)?;
        let samples = args.samples.unwrap_or(if args.model.drawn { SAMPLES_DRAWN } else { SAMPLES });
        let asked = || Times::new(&until, samples);
        let times = at.as_ref().map_or_else(asked, |table| Times::table(&table.text))?;
        let linearized = if args.linear {
            if let Some(own) = model.rolling.first() {
                return Err(LinearizeError::Unsupported { feature: Feature::Rolling, span: own.span }.into());
            }
            let linearized = linearize(model.clone())?;
            linearized.check_inertia()?;
            Some(linearized)
        } else {
            Start::linearized(&model, args.mode.is_some())?
        };
        if let Some(table) = &starts {
            let starts = Start::table(&table.text, &model, linearized.as_ref(), &system)?;
            let method = method(args, &model, system)?;
            return Ok(Computed::Ensemble(Box::new(Ensemble { model, method, starts, times })));
        }
        let start = if let (Some(mode), Some(amplitude), Some(linearized)) = (args.mode, &amplitude, &linearized) {
            let normal = oscillation::normal_modes(linearized, &modes::Options::default())?;
            Start::mode(mode, amplitude, &model, (linearized, &normal), &system)?
        } else {
            let start = args.start.as_deref().unwrap_or_default();
            Start::parse(start, &model, linearized.as_ref(), &system)?
        };
        let method = method(args, &model, system)?;
        let known = method.motion(&start, &times, args.digits)?;
        let linearized = linearized.as_ref().filter(|_| args.linear);
        let linear = linearized.and_then(|own| Some(motion::superposition(own, &start, &times)?.collect::<Vec<_>>()));
        let remarks = report::start_remark(&model, &start).into_iter().chain([report::motion_remark(&known)]);
        Ok(Computed::Motion {
            remarks: remarks.collect(),
            text: if args.model.drawn {
                report::motion_svg(&model, &known, linear.as_deref())
            } else if args.json {
                report::motion_json(&model, &known, args.digits)
            } else {
                report::motion_csv(&model, &known, linear.as_deref(), args.digits)
            },
        })
    });
    let (text, remarks) = match computed {
        Ok(Computed::Motion { text, remarks }) => (text, remarks),
        Ok(Computed::Ensemble(ensemble)) => return ensemble.answer(args, source, warnings, format),
        Err(error) => return Err(failed(&source, &warnings, error)),
    };
    if format == MessageFormat::Text {
        for remark in remarks {
            // Nobody to read it is no mistake.
            let _ = writeln!(AutoStream::auto(io::stderr()), "{remark}");
        }
    }
    Ok(Answer::new(text, Some((source, warnings))))
}

/// What is asked for.
enum Computed {
    /// The table or picture, and how it was computed.
    Motion {
        text: String,
        remarks: Vec<String>,
    },
    Ensemble(Box<Ensemble>),
}

fn method(args: &args::Motion, model: &Model, system: System) -> Result<Method, MotionError> {
    Ok(match args.tolerance {
        None if args.proved => Method::Proved(Enclosed::new(model)?),
        tolerance => Method::Followed(system, tolerance),
    })
}

/// Motions from several starts.
struct Ensemble {
    model: Model,
    method: Method,
    starts: Vec<Result<Start, MotionError>>,
    times: Times,
}

impl Ensemble {
    /// The motions in the order of the starts, on all cores; what is wrong with one is told, and its rows are missing.
    fn answer(
        self,
        args: &args::Motion,
        source: Source,
        mut remarks: Vec<Diagnostic>,
        format: MessageFormat,
    ) -> Result<Answer, Failure> {
        let Self { model, method, starts, times } = &self;
        if format == MessageFormat::Text {
            let moved = starts.iter().map(|start| report::start_remark(model, start.as_ref().ok()?));
            let moved: Vec<(usize, String)> =
                (1..).zip(moved).filter_map(|(number, own)| Some((number, own?))).collect();
            if let Some((number, first)) = moved.first() {
                let others = match moved.len() - 1 {
                    0 => String::new(),
                    1 => "; so was one other".to_owned(),
                    more => format!("; so were {more} others"),
                };
                let _ = writeln!(AutoStream::auto(io::stderr()), "start {number}: {first}{others}");
            }
        }
        let work = || {
            |at: usize| {
                let start = starts[at].as_ref().map_err(Clone::clone)?;
                method.motion(start, times, args.digits)
            }
        };
        let (mut number, mut known) = (0, 0);
        output::write_rest(|out| {
            let mut table = MotionsCsv::new(out, model, args.digits).map_err(output::failed)?;
            in_order(args.threads, starts.len(), "integrating the motions", work, |motion: Result<Trajectory, _>| {
                number += 1;
                args.model.guard.go_on(&source)?;
                let motion = match motion {
                    Ok(motion) => motion,
                    Err(error) => {
                        remarks.extend(Error::from(error).diagnostics().into_iter().map(|mut told| {
                            told.message = format!("start {number}: {}", told.message);
                            told
                        }));
                        return Ok(());
                    }
                };
                known += 1;
                table.motion(number, &motion).map_err(output::failed)
            })?;
            table.finish().map_err(output::failed)
        })?;
        if known == 0 {
            return Err(Failure::Model(source, remarks));
        }
        Ok(Answer::new(String::new(), Some((source, remarks))))
    }
}

/// How a motion is computed.
enum Method {
    /// With a tolerance quickly.
    Followed(System, Option<f64>),
    Proved(Enclosed),
}

impl Method {
    fn motion(&self, start: &Start, times: &Times, digits: usize) -> Result<Trajectory, MotionError> {
        match self {
            Self::Followed(system, None) => system.motion(start, times),
            Self::Followed(system, Some(tolerance)) => system.quick(start, times, *tolerance),
            Self::Proved(enclosed) => enclosed.motion(start, times, digits),
        }
    }
}
