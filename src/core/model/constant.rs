//! Exact numbers from the command line.

use super::settings::of_value;
use super::{ModelError, Parameter, Settings, TableTexts, elaborate};
use crate::budget::Budget;
use crate::expr::{ExprId, Pool};
use crate::number::Number;

/// Enough for any number that a person types.
const BYTES: u64 = 50_000_000;

fn first(errors: &[impl ToString]) -> String {
    errors.first().map_or_else(String::new, ToString::to_string)
}

/// A number without symbols, exact: `1/3`, `pi - 1e-6`, `sqrt(2)`.
#[derive(Clone, Debug)]
pub struct Constant {
    text: String,
    pool: Box<Pool>,
    value: ExprId,
}

impl Constant {
    /// Reads a constant expression of the model language.
    ///
    /// # Errors
    /// [`ModelError::BadSetting`] with what is wrong.
    ///
    /// ```
    /// use librate::{linearize, model::Constant};
    /// let half = Constant::parse("pi/2")?;
    /// let number = linearize::constant(half.pool(), half.value());
    /// assert_eq!(number.map(|x| x.mid_f64()), Some(std::f64::consts::FRAC_PI_2));
    /// assert!(Constant::parse("2*x").is_err() && Constant::parse("1) + (2").is_err());
    /// # Ok::<(), librate::model::ModelError>(())
    /// ```
    pub fn parse(text: &str) -> Result<Self, ModelError> {
        Self::read(text).map_err(|reason| ModelError::BadSetting { text: text.to_owned(), reason })
    }

    /// The same with what is wrong in words.
    ///
    /// # Errors
    /// What is wrong.
    pub fn read(text: &str) -> Result<Self, String> {
        // By itself first, so that it is one expression and no further statements.
        Settings::new().add(&format!("x = {text}")).map_err(|error| match error {
            ModelError::BadSetting { reason, .. } => reason,
            other => other.to_string(),
        })?;
        let file = crate::syntax::parse(&format!("param x = {text}\ncoord q\nT = q'^2")).map_err(|own| first(&own))?;
        let settings = Settings::new().within(Budget::new(BYTES));
        let model = elaborate(&file, &TableTexts::new(), &settings)
            .map_err(|own| own.first().map_or_else(String::new, of_value))?;
        let value = match model.parameters.as_slice() {
            [only] if only.uncertainty.is_some() => return Err("a number without an uncertainty is meant".to_owned()),
            [only] => only.value,
            _ => None,
        };
        let value = value.ok_or("it is not a constant")?;
        Ok(Self { text: text.trim().to_owned(), pool: Box::new(model.pool), value })
    }

    /// Reads a number in the unit of a parameter of a model with this pool: in SI from then on.
    ///
    /// # Errors
    /// What is wrong.
    pub fn of_parameter(text: &str, parameter: &Parameter, pool: &Pool) -> Result<Self, String> {
        let own = Self::read(text)?;
        parameter.unit.map_or(Ok(own), |unit| Self::read(&format!("({text})*({})", pool.display(unit))))
    }

    /// As it was written.
    #[must_use]
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The expression, in the pool of [`Constant::pool`].
    #[must_use]
    pub fn value(&self) -> ExprId {
        self.value
    }

    /// Where the expression lives.
    #[must_use]
    pub fn pool(&self) -> &Pool {
        &self.pool
    }
}

impl From<&Number> for Constant {
    fn from(number: &Number) -> Self {
        let mut pool = Box::<Pool>::default();
        let value = pool.number(number.clone());
        Self { text: number.to_string(), pool, value }
    }
}
