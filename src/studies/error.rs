//! Everything that can go wrong between a text and its modes, in one type for embedders.
//!
//! Each stage has its own error; this one only collects them, so that the whole way from a text to modes can use `?`.

use crate::amplitude::AmplitudeError;
use crate::equilibria::EquilibriaError;
use crate::floquet::FloquetError;
use crate::motion::MotionError;
use crate::period::PeriodError;
use crate::response::ResponseError;
use librate_core::diagnostic::Diagnostic;
use librate_core::linearize::LinearizeError;
use librate_core::model::ModelError;
use librate_core::order::Order;
use librate_core::syntax::SyntaxError;

/// What went wrong, by stage.
///
/// ```
/// use librate::{Error, linearize, model, oscillation, syntax};
///
/// fn stiffest(text: &str) -> Result<f64, Error> {
///     let file = syntax::parse(text)?;
///     let model = model::elaborate(&file, &model::TableTexts::new(), &model::Settings::new())?;
///     let linearized = linearize::linearize(model)?;
///     let modes = oscillation::normal_modes(&linearized, &Default::default())?;
///     Ok(modes.modes.last().map_or(0.0, |mode| mode.omega.mid_f64()))
/// }
///
/// assert_eq!(stiffest("coord x  T = 1/2*x'^2  V = 2*x^2")?, 2.0);
///
/// let error = stiffest("coord x  T = 1/2*m*x'^2").unwrap_err();
/// assert_eq!(error.diagnostics()[0].message, "`m` is not declared");
/// # Ok::<(), Error>(())
/// ```
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The text is no model file.
    #[error("{}", first_and_more(.0))]
    Syntax(Vec<SyntaxError>),
    /// What the text says is no model.
    #[error("{}", first_and_more(.0))]
    Model(Vec<ModelError>),
    /// The model has no small oscillations.
    #[error(transparent)]
    Linearize(#[from] LinearizeError),
    /// The motion can't be computed.
    #[error(transparent)]
    Motion(MotionError),
    /// The motion that is asked for has no period.
    #[error(transparent)]
    Period(PeriodError),
    /// The frequencies of the model have no leading change with the amplitude.
    #[error(transparent)]
    Amplitude(AmplitudeError),
    /// The equilibria in a box can't be searched for.
    #[error(transparent)]
    Equilibria(EquilibriaError),
    /// The model has no Floquet multipliers, or none were found.
    #[error(transparent)]
    Floquet(FloquetError),
    /// The model has no steady response, or none that is computed.
    #[error(transparent)]
    Response(ResponseError),
}

fn first_and_more(errors: &[impl ToString]) -> String {
    match errors {
        [] => "the model has a mistake".to_owned(),
        [only] => only.to_string(),
        [first, more @ ..] => format!("{} (and {} more)", first.to_string(), more.len()),
    }
}

impl From<Vec<SyntaxError>> for Error {
    fn from(errors: Vec<SyntaxError>) -> Self {
        Self::Syntax(errors)
    }
}

impl From<Vec<ModelError>> for Error {
    fn from(errors: Vec<ModelError>) -> Self {
        Self::Model(errors)
    }
}

impl From<ModelError> for Error {
    fn from(error: ModelError) -> Self {
        Self::Model(vec![error])
    }
}

/// What an earlier stage says stays that stage's error.
macro_rules! of_studies {
    ($($study:ident($error:ident) $($earlier:ident)+;)+) => {$(
        impl From<$error> for Error {
            fn from(error: $error) -> Self {
                match error {
                    $($error::$earlier(error) => error.into(),)+
                    error => Self::$study(error),
                }
            }
        }
    )+};
}

of_studies! {
    Motion(MotionError) Linearize;
    Period(PeriodError) Linearize;
    Amplitude(AmplitudeError) Linearize;
    Equilibria(EquilibriaError) Linearize;
    Floquet(FloquetError) Linearize;
    Response(ResponseError) Linearize Model;
}

impl Error {
    /// One message a mistake, in the order of the file; those without a place come last.
    #[must_use]
    pub fn diagnostics(&self) -> Vec<Diagnostic> {
        let mut all: Vec<Diagnostic> = match self {
            Self::Syntax(errors) => errors.iter().map(Diagnostic::from).collect(),
            Self::Model(errors) => errors.iter().map(Diagnostic::from).collect(),
            Self::Linearize(error) => vec![Diagnostic::from(error)],
            Self::Motion(error) => vec![Diagnostic::from(error)],
            Self::Period(error) => vec![Diagnostic::from(error)],
            Self::Amplitude(error) => vec![Diagnostic::from(error)],
            Self::Equilibria(error) => vec![Diagnostic::from(error)],
            Self::Floquet(error) => vec![Diagnostic::from(error)],
            Self::Response(error) => vec![Diagnostic::from(error)],
        };
        all.order_by_key(|diagnostic| {
            let place = diagnostic.primary.as_ref().map(|label| label.span.start);
            (place.is_none(), place)
        });
        all
    }
}
