//! Values set from outside: `--set NAME=VALUE`.

use super::ModelError;
use crate::budget::Budget;
use crate::syntax::{self, Binding, File, StatementKind, SyntaxError};

const WITHOUT_UNIT: &str = "a value comes without a unit: it is in the one that the file declares, or else in SI";

/// The first of the errors, or what is to be said of a unit.
pub(super) fn reason(errors: &[SyntaxError], of_units: &str) -> String {
    match errors.first() {
        Some(SyntaxError::UnitBehindValue { .. }) => of_units.to_owned(),
        Some(error) => error.to_string(),
        None => String::new(),
    }
}

/// What is wrong with a value from outside, where names have no meaning.
pub(super) fn of_value(error: &ModelError) -> String {
    match error {
        ModelError::UndeclaredName { name, .. }
        | ModelError::RecursiveLet { name, .. }
        | ModelError::NotConstant { on: name, .. } => {
            format!("values are numbers, without names such as `{name}`")
        }
        other => other.to_string(),
    }
}

/// Values that replace those of the file, and what the model is wanted for.
#[derive(Clone, Debug, Default)]
#[must_use]
pub struct Settings {
    pub(super) entries: Vec<Setting>,
    pub(super) budget: Option<Budget>,
    pub(super) purpose: Purpose,
}

/// What a model is wanted for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Purpose {
    #[default]
    Motion,
    Tensors,
    Picture,
}

/// One setting: the parsed `param NAME = VALUE`.
#[derive(Clone, Debug)]
pub(super) struct Setting {
    pub(super) text: String,
    pub(super) file: File,
    pub(super) binding: Binding,
}

impl Settings {
    /// No settings.
    pub fn new() -> Self {
        Self::default()
    }

    /// Each as it was given, `m[2]=3`.
    pub(crate) fn texts(&self) -> impl Iterator<Item = &str> {
        self.entries.iter().map(|own| own.text.as_str())
    }

    /// The same for a model that keeps to a budget; without one it has [`Budget::default`] of its own.
    pub fn within(mut self, budget: Budget) -> Self {
        self.budget = Some(budget);
        self
    }

    /// The same for a model that is to be drawn: [`Model::points`](super::Model::points) are there.
    pub fn with_points(mut self) -> Self {
        self.purpose = Purpose::Picture;
        self
    }

    /// The same for a model of which only the tensors are wanted: energies and coordinates may be missing, and
    /// [`Model::tensors`](super::Model::tensors) has the members of families, too.
    pub fn only_tensors(mut self) -> Self {
        self.purpose = Purpose::Tensors;
        self
    }

    /// Adds `NAME=VALUE`; the name may be a member (`m[2]`), the value an exact constant expression, with an
    /// uncertainty behind it where there is one (`l = 1 ± 0.01`). It is in the unit that the file declares.
    ///
    /// # Errors
    /// [`ModelError::BadSetting`] where the text can't be read.
    pub fn add(&mut self, text: &str) -> Result<(), ModelError> {
        let bad = |reason: &str| ModelError::BadSetting { text: text.to_owned(), reason: reason.to_owned() };
        let (name, value) = text.split_once('=').ok_or_else(|| bad("there is no `=`"))?;
        // `a[1][2]` is `a[1,2]`, as in expressions.
        let statement = format!("param {}={value}", name.replace("][", ", "));
        let mut file = syntax::parse(&statement).map_err(|errors| bad(&reason(&errors, WITHOUT_UNIT)))?;
        let mut statements = std::mem::take(&mut file.statements).into_iter();
        let bindings = match (statements.next().map(|first| first.kind), statements.next()) {
            (Some(StatementKind::Param(bindings)), None) => bindings,
            _ => Vec::new(),
        };
        match <[Binding; 1]>::try_from(bindings) {
            Ok([binding]) if binding.unit.is_some() => Err(bad(WITHOUT_UNIT)),
            Ok([binding]) if binding.value.is_some() => {
                self.entries.push(Setting { text: text.to_owned(), file, binding });
                Ok(())
            }
            Ok(_) | Err(_) => Err(bad("it must be one name and one value")),
        }
    }
}
