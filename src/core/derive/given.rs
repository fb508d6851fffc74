//! What a page begins with: the energies as the file has them, and the values of the parameters.

use super::Derivation;
use crate::model::{Model, Settings};
use crate::syntax::{
    Binding, ExprKind, ExprRef, File, IndexKind, StatementKind, print_expr, print_indices, print_unit,
};

/// Longer statements are not repeated, ...
const LONGEST: usize = 2_000;
/// ... nor lists of more values.
const MOST_VALUES: usize = 12;

/// The energies as they are written, and the values of the parameters.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct Given {
    /// `T = …` and what it is made of, in the order of the file, each with what its indices run over.
    pub statements: Vec<(String, Option<String>)>,
    /// `g = 9.81` and `m/s^2`; a list of values has a name and, in the second, its numbers.
    pub values: Vec<(String, Option<String>)>,
    /// The names that are defined there.
    pub names: Vec<String>,
    /// Whether numbers are in SI.
    pub has_units: bool,
}

impl Given {
    /// From a file and what replaces its values. What the model has no letter for is written out where it has this letter itself.
    pub(crate) fn new(file: &File, settings: &Settings, model: &Model) -> Self {
        let mut given = Self::default();
        let is_set = |name: &str| settings.texts().any(|text| head(text) == name);
        for statement in &file.statements {
            match &statement.kind {
                StatementKind::Kinetic(value) => given.statement(file, "T", *value),
                StatementKind::Potential(value) => given.statement(file, "V", *value),
                StatementKind::Lagrangian(value) => {
                    given.statement(file, &model.unused_name(&["L", "lagrangian"]), *value)
                }
                StatementKind::Dissipation(value) => {
                    given.statement(file, &model.unused_name(&["F", "dissipation"]), *value)
                }
                StatementKind::Let(own) => {
                    given.names.push(own.name.text.to_string());
                    given.binding(file, "", own);
                }
                StatementKind::Force(own) => given.binding(file, "Q_", own),
                StatementKind::Param(all) => {
                    all.iter().filter(|own| !is_set(&own.name.text)).for_each(|own| given.parameter(file, own));
                }
                _ => {}
            }
        }
        given.values.extend(settings.texts().map(|text| (text.replacen('=', " = ", 1), None)));
        given
    }

    fn statement(&mut self, file: &File, name: &str, value: ExprRef) {
        self.put(format!("{name} = {}", print_expr(file, value)), None);
    }

    fn put(&mut self, text: String, over: Option<String>) {
        if text.len() <= LONGEST {
            self.statements.push((text, over));
        }
    }

    fn binding(&mut self, file: &File, before: &str, own: &Binding) {
        if let Some(value) = own.value {
            let (name, over) = indexed(file, own);
            self.put(format!("{before}{name} = {}", print_expr(file, value)), over);
        }
    }

    /// A parameter with its value: a number, or a formula.
    fn parameter(&mut self, file: &File, own: &Binding) {
        let Some(at) = own.value else { return };
        let text = print_expr(file, at);
        if text.contains(|c: char| c.is_alphabetic() && c != 'e') || text.starts_with("[[") {
            return self.binding(file, "", own);
        }
        let unit = own.unit.map(|unit| print_unit(file, unit)).filter(|unit| unit != "1");
        let (name, over) = indexed(file, own);
        let (text, value, over) = match file.expr(at).kind {
            ExprKind::Vector(entries) if entries.len() > MOST_VALUES => return,
            ExprKind::Vector(entries) => {
                let all: Vec<String> = entries.iter().map(|at| format!("`{}`", print_expr(file, *at))).collect();
                (name, Some(format!("({})", all.join(", "))), None)
            }
            _ => (format!("{name} = {text}"), None, over.map(|over| format!("for {over}"))),
        };
        let behind: Vec<String> = [value, unit, over].into_iter().flatten().collect();
        self.values.push((text, (!behind.is_empty()).then(|| behind.join(" "))));
    }
}

/// `m[2]` of `m[2]=3` is one of `m`.
fn head(text: &str) -> &str {
    text.split(['[', '=', ' ']).next().unwrap_or_default()
}

/// The name with its indices, and what these run over.
fn indexed(file: &File, own: &Binding) -> (String, Option<String>) {
    let name = own.name.text.to_string();
    let Some(indices) = own.indices.as_deref() else { return (name, None) };
    let index = |kind: &IndexKind| match kind {
        IndexKind::Member(at) => Some(print_expr(file, *at)),
        IndexKind::Range { variable, .. } => variable.as_ref().map(|own| own.text.to_string()),
        IndexKind::Rows { variable, .. } => Some(variable.text.to_string()),
    };
    let all: Option<Vec<String>> = indices.entries.iter().map(|entry| index(&entry.kind)).collect();
    let runs = indices.entries.iter().any(|entry| !matches!(entry.kind, IndexKind::Member(_)));
    match all {
        Some(all) => (format!("{name}[{}]", all.join(", ")), runs.then(|| print_indices(file, indices))),
        // All members alike, or a list of them.
        None => (name, None),
    }
}

impl Derivation {
    /// Begins the page with the energies as the file has them and the values of the parameters.
    pub fn put_given(&mut self, file: &File, settings: &Settings, model: &Model) {
        self.given = Some(Given { has_units: model.has_units, ..Given::new(file, settings, model) });
    }
}
