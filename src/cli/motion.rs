//! `librate motion`.

use std::io::{self, Write};

use anstream::AutoStream;
use librate::linearize::{self, LinearizeError};
use librate::model::{Constant, ModelError};
use librate::motion::{self, Enclosed, Start, System, Times};
use librate::{Error, modes, oscillation, report};

use super::args::{self, MessageFormat};
use super::output::write_file;
use super::progress::Progress;
use super::{Answer, Failure, Loaded, Size, failed, load_values, wrong_request};

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
    let Loaded {
        mut source,
        model,
        warnings,
    } = load_values(&args.model, Size::Dense)?;
    let progress = Progress::start("following the motion");
    let computed = || -> Result<_, Error> {
        let system = System::new(&model)?;
        let times = Times::new(&until, args.samples)?;
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
        let trajectory = match args.tolerance {
            None if args.proved => Enclosed::new(&model)?.motion(&start, &times, args.digits)?,
            Some(tolerance) => system.quick(&start, &times, tolerance)?,
            None => system.motion(&start, &times)?,
        };
        let linear = linearized.filter(|_| args.linear);
        let linear = linear.and_then(|own| motion::superposition(&own, &start, &times));
        Ok((trajectory, linear, report::start_remark(&model, &start)))
    }();
    drop(progress);
    let (trajectory, linear, moved) = match computed {
        Ok(computed) => computed,
        Err(error) => return Err(failed(source, warnings, error)),
    };
    if let Some(file) = &args.svg {
        write_file(
            file,
            &report::motion_svg(&model, &trajectory, linear.as_deref()),
            &mut source,
        )?;
    }
    if format == MessageFormat::Text {
        for remark in moved
            .into_iter()
            .chain([report::motion_remark(&trajectory)])
        {
            // Nobody to read it is no mistake.
            let _ = writeln!(AutoStream::auto(io::stderr()), "{remark}");
        }
    }
    let text = if args.json {
        report::motion_json(&model, &trajectory, args.digits)
    } else {
        report::motion_csv(&model, &trajectory, linear.as_deref(), args.digits)
    };
    Ok(Answer {
        text,
        remarks: Some((source, warnings)),
    })
}
