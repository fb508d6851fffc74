//! Exact numbers from the command line.

use crate::expr::{ExprId, Pool};
use crate::linearize::evaluate_closed;
use crate::model::{self, ModelError, Settings, TableTexts};
use crate::number::Number;
use crate::precision::Scalar;

/// A number without symbols, exact: `1/3`, `pi - 1e-6`, `sqrt(2)`.
#[derive(Clone, Debug)]
pub struct Constant {
    text: String,
    pool: Pool,
    value: ExprId,
}

impl Constant {
    /// Reads a constant expression of the model language.
    ///
    /// # Errors
    /// [`ModelError::BadSetting`] with what is wrong.
    ///
    /// ```
    /// use librate::period::Constant;
    /// use librate::precision::Ball;
    /// let number = Constant::parse("pi/2")?.evaluate::<Ball>(());
    /// assert_eq!(number.mid_f64(), std::f64::consts::FRAC_PI_2);
    /// assert!(Constant::parse("2*x").is_err() && Constant::parse("1) + (2").is_err());
    /// # Ok::<(), librate::model::ModelError>(())
    /// ```
    pub fn parse(text: &str) -> Result<Self, ModelError> {
        let bad = |reason: String| ModelError::BadSetting {
            text: text.to_owned(),
            reason,
        };
        // By itself first, so that it is one expression and no further statements.
        Settings::new().add(&format!("x = {text}")).map_err(|error| match error {
            ModelError::BadSetting { reason, .. } => bad(reason),
            other => other,
        })?;
        let file = crate::syntax::parse(&format!("param x = {text}\ncoord q\nT = q'^2"))
            .map_err(|errors| bad(errors.first().map_or_else(String::new, ToString::to_string)))?;
        let model = model::elaborate(&file, &TableTexts::new(), &Settings::new())
            .map_err(|errors| bad(errors.first().map_or_else(String::new, ToString::to_string)))?;
        let value = match model.parameters.as_slice() {
            [only] => only.value,
            _ => None,
        };
        match value {
            Some(value) => Ok(Self {
                text: text.trim().to_owned(),
                pool: model.pool,
                value,
            }),
            None => Err(bad("it is no constant".to_owned())),
        }
    }

    /// As it was written.
    #[must_use]
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The number.
    #[must_use]
    pub fn evaluate<S: Scalar>(&self, precision: S::Precision) -> S {
        evaluate_closed::<S>(&self.pool, self.value, precision).unwrap_or_else(|| {
            let zero = S::from_number(&Number::ZERO, precision);
            zero.div(&zero)
        })
    }
}
