//! `librate export`: the matrices of a model as files of other programs.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use librate::code;
use librate::derive;
use librate::linearize::Linearized;
use librate::report::{self, Language, Matrix};

use super::output::{make_folder, write_content};
use super::progress::Progress;
use super::{Answer, Failure, Loaded, Size, args, failed, fault, load, load_values};

/// All matrices there are.
const NAMES: [&str; 5] = ["M", "K", "G", "C", "N"];

/// Writes the files; the answer lists them.
pub(super) fn text(args: &args::Export) -> Result<Answer, Failure> {
    let output = match (args.code, &args.output) {
        (Some(language), output) => return code(args, language, output.as_deref()),
        (None, Some(output)) => output,
        // Not without --code.
        (None, None) => return Err(fault("`-o PATH` is missing".to_owned())),
    };
    let Loaded { mut source, model, warnings, .. } = load_values(&args.model, Size::Any)?;
    let progress = Progress::start("computing the matrices", &args.model.guard);
    let linearized = derive::linearized(model).map_err(|error| failed(&source, &warnings, error))?;
    let matrices = report::matrices(&linearized).map_err(|error| match linearized.not_finite() {
        Some(undefined) => failed(&source, &warnings, undefined),
        None => fault(error),
    })?;
    if args.npz {
        write_content(output, &|out| report::write_npz(&matrices, out), &mut source)?;
    } else {
        make_folder(output)?;
        let is_own = |name: &str| matrices.iter().any(|matrix| matrix.name() == name);
        if let Some(name) = NAMES.iter().find(|name| !is_own(name) && file(args, output, name).exists()) {
            let (file, what) = (file(args, output, name), format!("this one has no {name}; remove that file first"));
            return Err(fault(format!("`{}` is of another model: {what}", file.display())));
        }
        let comments = comments(&linearized);
        for matrix in &matrices {
            let file = file(args, output, matrix.name());
            match args.petsc {
                true => write_content(&file, &|out| matrix.write_petsc(out), &mut source)?,
                false => write_content(&file, &|out| matrix.write_matrix_market(&comments, out), &mut source)?,
            }
        }
    }
    drop(progress);
    Ok(Answer::new(list(args, output, &matrices), Some((source, warnings))))
}

/// Writes the model as source code.
fn code(args: &args::Export, language: Language, output: Option<&Path>) -> Result<Answer, Failure> {
    let file = args.model.file.file_name().map(|own| own.to_string_lossy()).filter(|own| own != "-");
    let answer = load(&args.model, Size::Any)?.answer(&args.model, "compiling the model", |_, model, _| {
        Ok(report::code_text(&code::code(&model)?, language, file.as_deref()))
    })?;
    answer.into_file(output)
}

/// The file of a matrix in the folder.
fn file(args: &args::Export, output: &Path, name: &str) -> PathBuf {
    let name = if args.petsc { name.to_owned() } else { format!("{name}.mtx") };
    output.join(name)
}

/// What a reader of a Matrix Market file would else have to guess.
fn comments(linearized: &Linearized) -> Vec<String> {
    let model = linearized.model();
    let of = model.name.as_ref().map_or_else(String::new, |name| format!(" of {name}"));
    let mut comments = vec![format!("M q'' + (G + C) q' + (K + N) q = 0{of}, in SI where the model has units")];
    if linearized.is_reduced() {
        let others = if linearized.is_constrained() {
            "the others follow under the constraints"
        } else {
            "massless ones follow"
        };
        comments.push(format!("rows and columns are the coordinates that {others}:"));
        let free = linearized.free_coordinates().into_iter().enumerate();
        comments.extend(free.map(|(row, own)| format!("{} {}", row + 1, model.coordinates.at(own).name())));
    }
    comments
}

/// What was written, a line a matrix.
fn list(args: &args::Export, output: &Path, matrices: &[Matrix]) -> String {
    let mut out = String::new();
    for matrix in matrices {
        let (n, stored, name) = (matrix.dimension(), matrix.stored(), matrix.name());
        let file = if args.npz { output.to_owned() } else { file(args, output, name) };
        let file = Path::display(&file);
        let entries = if stored == 1 { "entry" } else { "entries" };
        let _ = writeln!(out, "{file}: {name}, {n} x {n}, {}, {stored} {entries}", matrix.mirror().as_str());
    }
    out
}
