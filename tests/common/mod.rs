//! Models from files and texts, for all test files that want them.

#![allow(dead_code, reason = "each test file uses a part of it")]

use std::path::{Path, PathBuf};

use librate::model::{Model, Settings, TableTexts, elaborate};
use librate::syntax::{StatementKind, parse};

/// The textbook models.
pub(crate) fn model_files() -> Vec<PathBuf> {
    let mut files: Vec<PathBuf> = std::fs::read_dir("models")
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|end| end == "lag"))
        .collect();
    files.sort();
    assert!(files.len() > 40);
    files
}

/// A model file with its tables.
pub(crate) fn load(path: &Path) -> Model {
    let text = std::fs::read_to_string(path).unwrap();
    model_in(&text, path.parent().unwrap(), &[])
}

/// A model without tables.
pub(crate) fn model(text: &str) -> Model {
    model_in(text, Path::new("."), &[])
}

/// A model whose tables are in a folder, with settings.
pub(crate) fn model_in(text: &str, folder: &Path, settings: &[&str]) -> Model {
    let file = parse(text).unwrap_or_else(|errors| panic!("{text}: {errors:?}"));
    let mut tables = TableTexts::new();
    for statement in &file.statements {
        if let StatementKind::Table { path: table, .. } = &statement.kind {
            let csv = std::fs::read_to_string(folder.join(table)).unwrap();
            tables = tables.with(table.clone(), csv);
        }
    }
    let mut all = Settings::new();
    for setting in settings {
        all.add(setting).unwrap();
    }
    elaborate(&file, &tables, &all).unwrap_or_else(|errors| panic!("{text}: {errors:?}"))
}
