//! Results that are probably not what was meant.

use super::NormalModes;
use crate::diagnostic::Diagnostic;
use crate::linearize::{Linearized, Origin};
use crate::modes::Kind;
use crate::span::Span;

/// Something suspicious about the normal modes of a model.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Warning {
    /// Nobody asked for the equilibrium that was taken, and the motion runs away from it in every
    /// direction.
    #[error("the equilibrium is a maximum of the potential energy")]
    Maximum {
        /// Where the coordinate is declared that runs away fastest.
        span: Span,
        /// That coordinate.
        coordinate: String,
    },
    /// The same in some directions.
    #[error("the equilibrium is a saddle of the potential energy")]
    Saddle {
        /// Where the coordinate is declared that runs away fastest.
        span: Span,
        /// That coordinate.
        coordinate: String,
    },
    /// The equilibrium was searched for, and that there is one where the search ended is not proved.
    #[error("the equilibrium that was found is not proved")]
    NotProved {
        /// Where the first coordinate is declared that was searched for.
        span: Span,
        /// That coordinate.
        coordinate: String,
    },
}

impl Warning {
    /// The code of this kind, `W0101`.
    #[must_use]
    pub fn code(&self) -> &'static str {
        match self {
            Self::Maximum { .. } => "W0101",
            Self::Saddle { .. } => "W0102",
            Self::NotProved { .. } => "W0103",
        }
    }
}

impl From<&Warning> for Diagnostic {
    fn from(warning: &Warning) -> Self {
        match warning {
            Warning::Maximum { span, coordinate } | Warning::Saddle { span, coordinate } => {
                Self::warning(
                    warning.to_string(),
                    *span,
                    format!("`{coordinate}` runs away from it"),
                )
                .with_code(warning.code())
                .with_help(
                    "if a stable one was meant, start the search near it with `guess`; if this one, give it with `equilibrium`",
                )
            }
            Warning::NotProved { span, coordinate } => Self::warning(
                warning.to_string(),
                *span,
                format!("how near `{coordinate}` is to it is an estimate, and so are all digits below"),
            )
            .with_code(warning.code())
            .with_help(
                "nothing holds some motion there, to second order at least; if the equilibrium is known, give it with `equilibrium`",
            ),
        }
    }
}

/// What is suspicious about modes that were computed with vectors or without.
///
/// An equilibrium that the file gives with `equilibrium` was meant.
#[must_use]
pub fn warnings(linearized: &Linearized, modes: &NormalModes) -> Vec<Warning> {
    let mut found = not_proved(linearized);
    found.extend(runs_away(linearized, modes));
    found
}

fn not_proved(linearized: &Linearized) -> Vec<Warning> {
    let equilibrium = linearized.equilibrium();
    if equilibrium.proved {
        return Vec::new();
    }
    let coordinates = &linearized.model().coordinates;
    let mut searched = coordinates.iter().zip(&equilibrium.origins);
    searched
        .find(|(_, origin)| **origin == Origin::Found)
        .map(|(coordinate, _)| Warning::NotProved {
            span: coordinate.span,
            coordinate: coordinate.name.clone(),
        })
        .into_iter()
        .collect()
}

fn runs_away(linearized: &Linearized, modes: &NormalModes) -> Vec<Warning> {
    let origins = &linearized.equilibrium().origins;
    let unstable = modes
        .modes
        .iter()
        .filter(|mode| mode.kind == Kind::Unstable)
        .count();
    if unstable == 0 || origins.iter().all(|origin| *origin == Origin::Given) {
        return Vec::new();
    }
    let coordinates = &linearized.model().coordinates;
    let largest = modes.modes.first().and_then(|mode| {
        let sizes = mode.vector.iter().map(|x| x.abs()).enumerate();
        sizes.reduce(|a, b| if b.1 > a.1 * (1.0 + 1e-6) { b } else { a })
    });
    let Some(coordinate) = coordinates.get(largest.map_or(0, |(at, _)| at)) else {
        return Vec::new();
    };
    let (span, name) = (coordinate.span, coordinate.name.clone());
    vec![if unstable == coordinates.len() {
        Warning::Maximum {
            span,
            coordinate: name,
        }
    } else {
        Warning::Saddle {
            span,
            coordinate: name,
        }
    }]
}
