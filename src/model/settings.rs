//! Values set from outside: `--set NAME=VALUE`.

use super::ModelError;
use crate::syntax::{self, Binding, File, StatementKind};

/// Values that replace those of the file.
#[derive(Clone, Debug, Default)]
pub struct Settings {
    pub(super) entries: Vec<Setting>,
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
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds `NAME=VALUE`; the name may be a member (`m[2]`), the value an exact constant expression.
    ///
    /// # Errors
    /// [`ModelError::BadSetting`] where the text can't be read.
    pub fn add(&mut self, text: &str) -> Result<(), ModelError> {
        let bad = |reason: &str| ModelError::BadSetting {
            text: text.to_owned(),
            reason: reason.to_owned(),
        };
        if !text.contains('=') {
            return Err(bad("there is no `=`"));
        }
        let mut file = syntax::parse(&format!("param {text}"))
            .map_err(|errors| bad(&errors.first().map_or_else(String::new, ToString::to_string)))?;
        let mut statements = std::mem::take(&mut file.statements).into_iter();
        match (statements.next().map(|first| first.kind), statements.next()) {
            (Some(StatementKind::Param(binding)), None) if binding.value.is_some() => {
                self.entries.push(Setting {
                    text: text.to_owned(),
                    file,
                    binding,
                });
                Ok(())
            }
            _ => Err(bad("it must be one name and one value")),
        }
    }
}
