//! `librate check`: whether a model is valid, and with `--fix` the corrections that messages offer.

use librate::diagnostic;

use super::args::{Check, ModelArgs};
use super::{Answer, Failure, Loaded, Size, fmt, input, load, load_text, output, wrong_request};
use output::write_out;

/// Corrections can show further mistakes: so often they are made.
const ROUNDS: usize = 20;

/// The file with all corrections made that are certain enough; says what changed, and what becomes of the model.
fn corrected(args: &ModelArgs) -> Result<Loaded, Failure> {
    if input::is_stream(&args.file) {
        return Err(wrong_request("standard input can't be corrected in place".to_owned(), "name a file"));
    }
    let source = input::read_model(&args.file)?;
    let mut newer = source.clone();
    let mut found = load_text(args, newer.clone(), Size::Any);
    for _ in 0..ROUNDS {
        let told = match &found {
            Ok(loaded) => &loaded.warnings,
            Err(Failure::Model(_, told)) => told,
            Err(_) => break,
        };
        let text = diagnostic::replaced(&newer.text, told.iter().filter_map(|own| own.replacement.as_ref()));
        if text == newer.text {
            break;
        }
        newer.text = text;
        found = load_text(args, newer.clone(), Size::Any);
    }
    if newer.text != source.text {
        fmt::rewrite(&args.file, &source, &newer.text)?;
        write_out(&output::visible(&fmt::difference(&source, &newer.text, "corrected"), false))?;
    }
    found
}

pub(super) fn text(args: &Check) -> Result<Answer, Failure> {
    let loaded = if args.fix { corrected(&args.model) } else { load(&args.model, Size::Any) };
    let Loaded { source, model, warnings, .. } = loaded?;
    let name = model.name.clone().unwrap_or(source.shown().into_owned());
    let count = model.coordinates.len();
    let plural = if count == 1 { "" } else { "s" };
    let energies = if model.lagrangian {
        "the lagrangian is in order"
    } else if model.potential.is_empty() {
        "T is in order, V is 0"
    } else {
        "T and V are in order"
    };
    let text = format!("{name}: {count} coordinate{plural}, {energies}\n");
    Ok(Answer::new(text, Some((source, warnings))))
}
