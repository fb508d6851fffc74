//! `librate inertia`: tells the three kinds of files apart and hands each to the library.

use std::path::Path;

use librate::diagnostic::{Diagnostic, Label};
use librate::inertia::{self, Amount, InertiaError, Mesh};
use librate::span::Span;
use librate::{model, report, sensitivity};

use super::args::Inertia;
use super::input::{self, Source};
use super::{Answer, Failure, USAGE, during, failed, parsed, style, wrong_value};

/// What a file describes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Model,
    Points,
    Mesh,
}

/// By the end of its name, or else by how it begins.
fn kind(file: &Path, bytes: &[u8]) -> Kind {
    let ending = file.extension().map(|ending| ending.to_ascii_lowercase());
    match ending.as_deref().and_then(|ending| ending.to_str()) {
        Some("lag") => return Kind::Model,
        Some("csv") => return Kind::Points,
        Some("stl") => return Kind::Mesh,
        Some(_) | None => {}
    }
    let solid = bytes.trim_ascii_start().get(..5).is_some_and(|word| word.eq_ignore_ascii_case(b"solid"));
    if solid || bytes.contains(&0) {
        return Kind::Mesh;
    }
    // A model has no line of names and commas without any other sign.
    let text = String::from_utf8_lossy(bytes);
    let header = text.lines().map(|line| line.trim_start_matches('\u{feff}').trim());
    let header = header.filter(|line| !line.is_empty() && !line.starts_with('#'));
    let mut header = header.take(1).flat_map(|line| line.split(','));
    let plain = |name: &str| name.trim().chars().all(|c| c.is_alphanumeric() || "_ ()\"".contains(c));
    let names = header.clone().count();
    if names >= 4 && header.all(plain) { Kind::Points } else { Kind::Model }
}

/// The result for a file of any kind.
pub(super) fn text(args: &Inertia) -> Result<Answer, Failure> {
    let amount = amount(args)?;
    let bytes = input::read_bytes(&args.model.file)?;
    let kind = kind(&args.model.file, &bytes);
    let wrong = |option: &str, only: &str| Failure::Other {
        message: format!("{option} is for {only}"),
        help: None,
        status: USAGE,
    };
    if amount.is_some() && kind != Kind::Mesh {
        let option = if args.mass.is_some() { "--mass" } else { "--density" };
        return Err(wrong(option, "meshes"));
    }
    if !args.model.settings.is_empty() && kind != Kind::Model {
        return Err(wrong("--set", "models"));
    }
    if kind == Kind::Mesh {
        let body = during(&args.model, "integrating over the mesh", || {
            Mesh::read_stl(&bytes)?.body(&amount.unwrap_or_default(), args.digits)
        });
        let source = Source::of(&args.model.file, String::new());
        return body_answer(args, source, body);
    }
    if kind == Kind::Points {
        let source = input::points_text(&args.model.file, bytes)?;
        let body = inertia::of_points(&source.text, args.digits);
        return body_answer(args, source, body);
    }
    model_answer(args, input::model_text(&args.model.file, bytes)?)
}

/// What `--density` or `--mass` say.
fn amount(args: &Inertia) -> Result<Option<Amount>, Failure> {
    let read = match (&args.density, &args.mass) {
        (Some(text), _) => Amount::density(text),
        (None, Some(text)) => Amount::mass(text),
        (None, None) => return Ok(None),
    };
    read.map(Some).map_err(|error| wrong_value(&error))
}

fn body_answer(args: &Inertia, source: Source, body: Result<inertia::Body, InertiaError>) -> Result<Answer, Failure> {
    let body = body.map_err(|error| {
        let mut told = Diagnostic::from(&error);
        told.primary = told.primary.or_else(|| line_label(&source.text, error.line()?));
        Failure::Model(source.clone(), vec![told])
    })?;
    let text = if args.json {
        report::body_json(&body, args.digits)
    } else {
        report::body_text(&source.shown(), &body, args.digits, &style())
    };
    Ok(Answer::new(text, None))
}

/// The whole of a line, from 1.
fn line_label(text: &str, number: u64) -> Option<Label> {
    let mut start = 0;
    for (at, line) in (1..).zip(text.split_inclusive('\n')) {
        if at == number {
            let end = start + line.trim_end().len();
            let span = Span::new(u32::try_from(start).ok()?, u32::try_from(end).ok()?);
            return Diagnostic::error("", span, "").primary;
        }
        start += line.len();
    }
    None
}

fn model_answer(args: &Inertia, source: Source) -> Result<Answer, Failure> {
    let (source, made) = parsed(&args.model, source)?;
    let model = model::elaborate(&made.file, &made.tables, &made.settings.only_tensors())
        .map_err(|errors| failed(&source, &[], errors))?;
    let wrong = |errors: Vec<_>| Failure::Model(source.clone(), errors.iter().map(Diagnostic::from).collect());
    let tensors = inertia::of_model(&model, args.digits).map_err(wrong)?;
    let name = model.name.as_deref();
    let warnings = tensors.iter().filter_map(inertia::NamedTensor::warning);
    let warnings = warnings.chain(sensitivity::ignored(&model)).collect();
    let text = if args.json {
        report::tensors_json(name, &tensors, args.digits)
    } else {
        report::tensors_text(name, &tensors, args.digits, &style())
    };
    Ok(Answer::new(text, Some((source, warnings))))
}
