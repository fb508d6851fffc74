//! Why a model has no frequencies that change with the amplitude.

use crate::diagnostic::Diagnostic;
use crate::linearize::LinearizeError;
use crate::model::Feature;
use crate::span::Span;

/// That a feature is not covered, what it is called where it stands, and a way round it.
fn words(feature: Feature) -> (&'static str, &'static str, &'static str) {
    match feature {
        Feature::Time => (
            "this model depends on the time explicitly: it has no frequencies of its own",
            "contains the time",
            "`motion` follows what is driven, `floquet` has its stability",
        ),
        Feature::Dissipation => (
            "friction takes energy away: the amplitude does not stay what it is",
            "friction",
            "the frequencies without friction are those of the model without this line",
        ),
        Feature::Constraint => (
            "the model has constraints, which the change of frequencies with the amplitude does not cover",
            "a constraint",
            "write the energies with the coordinates that are left",
        ),
        Feature::SteadyMotion => (
            "the change of frequencies with the amplitude is not covered about a steady motion",
            "turned here",
            "leave the rate out, or write it into the energies in place of the velocity",
        ),
    }
}

/// A model whose frequencies have no leading change with the amplitude.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum AmplitudeError {
    /// Something without periodic motions, or that is not covered.
    #[error("{}", words(*feature).0)]
    Unsupported {
        /// What.
        feature: Feature,
        /// Where.
        span: Span,
    },
    /// Terms linear in the velocities that are no total derivative by the time.
    #[error("terms linear in the velocities act on the motion: it has gyroscopic forces")]
    Gyroscopic {
        /// The first such term.
        span: Span,
    },
    /// A Lagrangian that is no quadratic polynomial in the velocities.
    #[error("the energies are not quadratic in the velocities")]
    NotQuadratic {
        /// The term.
        span: Span,
    },
    /// A motion that runs away.
    #[error("the equilibrium is unstable: {count} of its modes {}", if *.count == 1 { "grows" } else { "grow" })]
    Unstable {
        /// How many modes grow.
        count: usize,
    },
    /// Third and fourth derivatives that are no numbers.
    #[error(
        "the energies have no third and fourth derivatives at the equilibrium, or none within the range of doubles"
    )]
    NotSmooth,
    /// Too many terms to be written out.
    #[error("the energies have {terms} terms, more than {most}")]
    TooLarge {
        /// How many.
        terms: usize,
        /// How many there may be.
        most: usize,
    },
    /// What an earlier stage says.
    #[error(transparent)]
    Linearize(LinearizeError),
}

impl From<&AmplitudeError> for Diagnostic {
    fn from(error: &AmplitudeError) -> Self {
        described(error).with_code(error.code())
    }
}

fn described(error: &AmplitudeError) -> Diagnostic {
    let message = error.to_string();
    match error {
        AmplitudeError::Unsupported { feature, span } => {
            let (_, label, help) = words(*feature);
            Diagnostic::error(message, *span, label).with_help(help)
        }
        AmplitudeError::Gyroscopic { span } => {
            Diagnostic::error(message, *span, "linear in the velocities").with_help(
                "the change of frequencies with the amplitude is known here for L = T - V with T quadratic in the velocities",
            )
        }
        AmplitudeError::NotQuadratic { span } => {
            Diagnostic::error(message, *span, "not quadratic in the velocities").with_help(
                "the change of frequencies with the amplitude is known here for L = T - V with T quadratic in the velocities",
            )
        }
        AmplitudeError::Unstable { .. } => Diagnostic::global(message)
            .with_help("give a point near a minimum of the potential with `guess` or `equilibrium`"),
        AmplitudeError::NotSmooth => Diagnostic::global(message)
            .with_help("a power like x^(7/2) has a stiffness there, and yet its part of the frequency is not in proportion to the square of the amplitude"),
        AmplitudeError::TooLarge { .. } => Diagnostic::global(message),
        AmplitudeError::Linearize(error) => Diagnostic::from(error),
    }
}
