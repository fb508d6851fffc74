//! `librate motion`.

use std::io::{self, Write};

use anstream::AutoStream;
use librate::linearize::{self, LinearizeError, Linearized};
use librate::model::{Constant, Model, ModelError};
use librate::motion::{self, Enclosed, MotionError, Start, System, Times, Trajectory};
use librate::precision::Ball;
use librate::report::{self, MotionCsv, MotionJson};
use librate::{Error, modes, oscillation};

use super::args::{self, MessageFormat};
use super::output::{self, write_file};
use super::progress::Progress;
use super::{Answer, Failure, Loaded, Size, failed, fault, load_values, wrong_request};

/// A number on the command line.
fn constant(text: &str) -> Result<Constant, Failure> {
    Constant::parse(text).map_err(|error| {
        let reason = match error {
            ModelError::BadSetting { reason, .. } => reason,
            other => other.to_string(),
        };
        let help = "times and amplitudes are numbers: `10`, `1/2`, `2*pi`";
        wrong_request(format!("can't read `{text}`: {reason}"), help)
    })
}

pub(super) fn text(args: &args::Motion, format: MessageFormat) -> Result<Answer, Failure> {
    let until = constant(&args.until)?;
    let amplitude = args.amplitude.as_deref().map(constant).transpose()?;
    let Loaded { mut source, model, warnings } = load_values(&args.model, Size::Dense)?;
    let progress = Progress::start("integrating the motion");
    let computed = || -> Result<_, Error> {
        let system = System::new(&model)?;
        let times = Times::new(&until, args.samples)?;
        let at_once = times.at_once(2 * model.coordinates.len() + 1);
        // A motion needs no equilibrium, unless it starts there.
        let linearized = match linearize::linearize(model.clone()) {
            Ok(linearized) => Some(linearized),
            Err(error) if args.mode.is_some() || args.linear => return Err(error.into()),
            Err(
                error @ (LinearizeError::MissingValue { .. }
                | LinearizeError::NotAnEquilibrium { .. }
                | LinearizeError::ConstraintBroken { .. }),
            ) => return Err(error.into()),
            Err(_) => None,
        };
        if let Some(linearized) = &linearized {
            linearized.check_inertia()?;
        }
        let start = match (args.mode, &amplitude, &linearized) {
            (Some(mode), Some(amplitude), Some(linearized)) => {
                let normal = oscillation::normal_modes(linearized, &modes::Options::default())?;
                Start::mode(mode, amplitude, linearized, &normal, &system)?
            }
            _ => {
                let start = args.start.as_deref().unwrap_or_default();
                Start::parse(start, &model, linearized.as_ref(), &system)?
            }
        };
        let method = match args.tolerance {
            None if args.proved => Method::Proved(Enclosed::new(&model)?),
            tolerance => Method::Followed(system, tolerance),
        };
        let known = method.motion(&start, &at_once, args.digits)?;
        Ok(Motion {
            linearized: linearized.filter(|_| args.linear),
            digits: args.digits,
            method,
            start,
            times,
            known,
            model,
        })
    }();
    drop(progress);
    let motion = match computed {
        Ok(computed) => computed,
        Err(error) => return Err(failed(source, warnings, error)),
    };
    let (model, known) = (&motion.model, &motion.known);
    let linear = |times: &Times| -> Option<Vec<Vec<f64>>> {
        let linearized = motion.linearized.as_ref()?;
        Some(motion::superposition(linearized, &motion.start, times)?.collect())
    };
    if let Some(file) = &args.svg {
        let shown = motion.times.at_once(2 * model.coordinates.len() + 1);
        let picture = report::motion_svg(model, known, linear(&shown).as_deref());
        write_file(file, &picture, &mut source)?;
    }
    if format == MessageFormat::Text {
        let moved = report::start_remark(model, &motion.start);
        for remark in moved.into_iter().chain([report::motion_remark(known)]) {
            // Nobody to read it is no mistake.
            let _ = writeln!(AutoStream::auto(io::stderr()), "{remark}");
        }
    }
    let remarks = Some((source, warnings));
    if known.rows.len() < motion.times.len() {
        let json = args.json;
        return Ok(Answer { text: String::new(), rest: Some(Box::new(move |out| motion.write(json, out))), remarks });
    }
    let text = if args.json {
        report::motion_json(model, known, args.digits)
    } else {
        report::motion_csv(model, known, linear(&motion.times).as_deref(), args.digits)
    };
    Ok(Answer::new(text, remarks))
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

/// A motion that is known at some times.
struct Motion {
    model: Model,
    method: Method,
    start: Start,
    times: Times,
    known: Trajectory,
    /// For the superposition of modes, where it is asked for.
    linearized: Option<Linearized>,
    digits: usize,
}

impl Motion {
    /// Writes all rows as they are computed, so that a table may be as long as one likes.
    fn write(self, json: bool, out: &mut dyn Write) -> Result<(), Failure> {
        let (model, known, digits) = (&self.model, &self.known, self.digits);
        if json {
            let kept = tempfile::tempfile().map_err(not_kept)?;
            let mut table = MotionJson::new(kept, model, known, digits);
            self.each(|time, row| table.row(time, row).map_err(not_kept))?;
            return table.finish(out).map_err(output::failed);
        }
        let linearized = self.linearized.as_ref();
        let mut linear = linearized.and_then(|own| motion::superposition(own, &self.start, &self.times));
        let table = MotionCsv::new(out, model, known, linear.is_some(), digits);
        let mut table = table.map_err(output::failed)?;
        self.each(|time, row| {
            let linear = linear.as_mut().and_then(Iterator::next);
            let linear = linear.unwrap_or_default();
            table.row(time, row, &linear).map_err(output::failed)
        })?;
        table.finish().map(drop).map_err(output::failed)
    }

    /// All rows, as long as nothing fails.
    fn each(&self, mut row: impl FnMut(&Ball, &[Ball]) -> Result<(), Failure>) -> Result<(), Failure> {
        let mut written = Ok(());
        let each = |at: usize, values: Vec<Ball>| {
            written = row(&self.times.at(at), &values);
            written.is_ok()
        };
        let (start, times, known) = (&self.start, &self.times, &self.known);
        let followed = match &self.method {
            Method::Followed(system, tolerance) => system.rows(start, times, known, *tolerance, each),
            Method::Proved(enclosed) => enclosed.rows(start, times, known, each),
        };
        written?;
        followed.map_err(|error| fault(error.to_string()))
    }
}

/// Why columns were not kept.
fn not_kept(error: io::Error) -> Failure {
    fault(format!("can't keep the columns in a temporary file: {error}; without `--json` rows are written at once"))
}
