//! Why a model has no small oscillations to speak of.

use crate::budget::Exceeded;
use crate::diagnostic::{at, nowhere};
use crate::mistakes::mistakes;
use crate::span::Span;

/// What a model may say that the modes of this version do not cover.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Feature {
    /// Terms linear in the velocities that give a gyroscopic matrix.
    Gyroscopic,
    /// A `dissipation` function.
    Dissipation,
    /// A `constraint`.
    Constraint,
    /// `equilibrium NAME' = …`
    SteadyMotion,
}

/// What is not defined where a `guess` or `equilibrium` comes to no number.
pub(super) const GIVEN_VALUE: &str = "the given value";

mistakes! {
/// A model that can't be linearized.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
Error LinearizeError {
    /// A parameter without a value where numbers are asked for.
    #[error("the parameter `{name}` has no value")]
    "E0301" MissingValue {
        /// The parameter.
        name: String,
        /// Where it is declared.
        span: Span,
    } => at(*span, "declared without a value").with_help(format!(
        "give it a value in the file, or on the command line: --set {name}=VALUE"
    )),

    /// A point given as equilibrium where parameters without values decide whether a force acts.
    #[error(
        "whether this is an equilibrium depends on values of parameters: the force on `{coordinate}` is {force}"
    )]
    "E0321" ForceOfParameters {
        /// The coordinate.
        coordinate: String,
        /// The generalised force, as an expression.
        force: String,
        /// Where the equilibrium is given.
        span: Span,
    } => at(*span, "given here").with_help(
        "where a root is taken the sign of a parameter counts, which its value tells: give the parameters values in the file, or on the command line by --set",
    ),

    /// A point given as equilibrium where a force acts.
    #[error("this is no equilibrium: a force {force} acts on `{coordinate}`")]
    "E0302" NotAnEquilibrium {
        /// The coordinate.
        coordinate: String,
        /// The generalised force, as an expression, as a number or both.
        force: String,
        /// Where the equilibrium is given.
        span: Span,
    } => at(*span, "given here").with_help(
        "at an equilibrium every generalised force vanishes; a point nearby can be given as `guess`, and the equilibrium is searched for from there",
    ),

    /// A force that vanishes nowhere.
    #[error("there is no equilibrium: {}", describe_forces(.forces))]
    "E0303" NoEquilibrium {
        /// The coordinate (or the combination that moves together) and the force on it.
        forces: Vec<(String, String)>,
        /// Where the coordinate is declared.
        span: Span,
    } => at(*span, "this coordinate runs away").with_help(
        "without an equilibrium there are no small oscillations; is a restoring force missing?",
    ),

    /// A search that led nowhere.
    #[error("no equilibrium was found")]
    "E0304" EquilibriumNotFound {
        /// The coordinate with the largest force left.
        coordinate: String,
        /// That force.
        force: String,
        /// The point the search ended at.
        point: String,
        /// Where the coordinate is declared.
        span: Span,
    } => at(*span, format!("the force on `{coordinate}` is still {force}"))
        .with_help(format!(
            "the search ended at {point}; if there is an equilibrium, give a point near it with `guess`"
        )),

    /// A search that began or ended where a constraint says nothing of where to go.
    #[error(
        "no equilibrium was found: the gradient of a constraint vanishes at {point}, where the search {}",
        if *.ended { "ended" } else { "began" }
    )]
    "E0320" ConstraintFlat {
        /// The point.
        point: String,
        /// Whether the search ended there; else it began there.
        ended: bool,
        /// Whether the constraint holds there, as nearly as can be told.
        holds: bool,
        /// The constraint.
        span: Span,
    } => at(*span, "this constraint")
        .with_help(if *holds {
            "a constraint that is a square or a product, as (x - y)^2 = 0, doesn't tell which motions it allows where it holds: write x = y; if there is an equilibrium elsewhere, give a point near it with `guess`"
        } else {
            "there it holds no motion back, and no force of it leads anywhere: start elsewhere, with `guess`"
        }),

    /// An energy or one of its derivatives that is no number at the point in question.
    #[error("{what} is not defined at {point}")]
    "E0305" NotFinite {
        /// `the energy`, `the force`, …
        what: String,
        /// The point.
        point: String,
        /// What makes it undefined, if that can be told: `the divisor `a - b` is 0 for a = 1, b = 1`.
        cause: Option<String>,
        /// Where the term stands.
        span: Span,
    } => {
        let label = if what == GIVEN_VALUE { "given here" } else { "in this term" };
        let help = cause.as_deref().unwrap_or(
            "is something divided by zero, a root taken of a negative number, or a number too large? Look at the values of parameters and at all terms of a sum; if a coordinate is to blame, `guess` moves the starting point",
        );
        at(*span, label).with_help(help)
    },

    /// A direction without inertia.
    #[error("{} has no inertia{}", combination_words(.combination), if *.proved { ": the mass matrix is singular" } else { " that can be told from none: the mass matrix is not shown to be positive definite" })]
    "E0306" SingularMass {
        /// The coordinates that move together, with their amplitudes.
        combination: Vec<(String, f64)>,
        /// Whether the inertia is exactly 0; otherwise bounds do not tell it from 0.
        proved: bool,
        /// Where the first of them is declared.
        span: Span,
    } => at(*span,
            if *proved {
                "its velocity does not occur squared in T"
            } else {
                "moves without any, or with too little beside the others"
            },
        )
        .with_help("every coordinate needs a kinetic energy of its own; is a term of T missing?"),

    /// A direction with negative inertia.
    #[error("{} has a negative inertia: the mass matrix is not positive", combination_words(.combination))]
    "E0307" IndefiniteMass {
        /// The coordinates that move together, with their amplitudes.
        combination: Vec<(String, f64)>,
        /// Where the first of them is declared.
        span: Span,
    } => at(*span, "declared here")
        .with_help("a kinetic energy can't be negative; look for a wrong sign in T"),

    /// A feature of the language that modes do not cover.
    #[error("{}", unsupported_words(*.feature))]
    "E0308" Unsupported {
        /// Which.
        feature: Feature,
        /// Where.
        span: Span,
    } => at(*span, "")
        .with_help("`modes` covers all of these"),

    /// A steady rate of a coordinate that something depends on.
    #[error("`{coordinate}` can't turn at a constant rate: it is not cyclic")]
    "E0312" NotCyclic {
        /// The coordinate.
        coordinate: String,
        /// Where the rate stands.
        span: Span,
        /// Where the coordinate itself occurs.
        energy: Span,
    } => at(*span, "turned here")
        .with_secondary(*energy, format!("depends on `{coordinate}`"))
        .with_help("only a coordinate that occurs by its velocity alone keeps its rate; a rotation that a motor keeps up is written with an explicit rate in place of the coordinate"),

    /// Constraints that can't hold together.
    #[error("{}", contradiction_words(.difference.as_deref()))]
    "E0313" ConstraintsContradict {
        /// What the sides of this one differ by where the others hold; `None` where no place was found at which they
        /// all hold.
        difference: Option<String>,
        /// The constraint.
        span: Span,
    } => at(*span, "this constraint")
        .with_help(if difference.is_some() {
            "leave one of them out, or mend its numbers"
        } else {
            "give a point near the equilibrium with `guess`; are there more constraints than the body can follow?"
        }),

    /// A given equilibrium off a constraint.
    #[error("the equilibrium that is given breaks a constraint: its sides differ by {difference}")]
    "E0314" ConstraintBroken {
        /// Left less right side.
        difference: String,
        /// The constraint.
        span: Span,
        /// Where the equilibrium is given.
        given: Option<Span>,
    } => at(*span, "broken").and_at(*given, "given here").with_help(
        "an equilibrium has to obey all constraints; a point nearby can be given as `guess`",
    ),

    /// Constraints that depend on each other just at the equilibrium.
    #[error(
        "the constraints are singular at {point}: just there they don't determine which motions they allow"
    )]
    "E0315" ConstraintsSingular {
        /// The point.
        point: String,
        /// A constraint.
        span: Span,
    } => at(*span, "the gradients of the constraints are dependent there")
        .with_help("the body has more or fewer ways to move there than beside it, and small oscillations are not defined; look for an equilibrium elsewhere with `guess`"),

    /// A dissipation that has no second derivatives at rest.
    #[error("the dissipation is not smooth at rest")]
    "E0316" FrictionNotSmooth {
        /// What is to blame, as an expression.
        part: String,
        /// Where the term stands.
        span: Span,
    } => at(*span, format!("`{part}` has a corner where nothing moves"))
        .with_help("dry friction has no small oscillations: a body at rest sticks; write friction by squares of velocities, 1/2*c*x'^2"),

    /// A steady rate that friction brakes.
    #[error("`{coordinate}` does not keep its rate: friction acts on it with {force}")]
    "E0317" RateNotKept {
        /// The coordinate.
        coordinate: String,
        /// The force, as an expression.
        force: String,
        /// Where the rate stands.
        span: Span,
    } => at(*span, "turned here")
        .with_help("a steady motion has no friction along it, or a drive that balances it: friction against a medium that turns along is 1/2*c*(psi' - S)^2"),

    /// Coordinates that lose a direction at the equilibrium, as Euler angles do.
    #[error("the coordinates are singular at this equilibrium: {} moves nothing there, and does so beside it", combination_words(.combination))]
    "E0318" SingularCoordinates {
        /// The coordinates that move together, with their amplitudes.
        combination: Vec<(String, f64)>,
        /// Where the first of them is declared.
        span: Span,
    } => at(*span, "loses its own motion there")
        .with_help("Euler angles do that where two axes coincide (gimbal lock); take angles about other axes, for an upright top R = rot_x(a)*rot_y(b)*rot_z(psi)"),

    /// Energies that depend on the time.
    #[error("this model depends on the time explicitly and has no normal modes")]
    "E0309" TimeDependent {
        /// Where.
        span: Span,
    } => at(*span, "contains the time")
        .with_help("the motion about a state that is driven has Floquet multipliers instead: `librate floquet` finds them"),

    /// The eigenvalue problem could not be solved.
    #[error("the modes could not be computed: {reason}")]
    "E0310" NoModes {
        /// What the numeric stage says.
        reason: String,
    } => nowhere(),

    /// More coordinates than a dense problem can have.
    #[error("{coordinates} coordinates are too many for dense matrices (at most {most})")]
    "E0311" TooLarge {
        /// How many.
        coordinates: usize,
        /// How many are possible.
        most: usize,
    } => nowhere()
        .with_help("fewer coordinates, or one part of a body that repeats, fit into memory"),
} else {
    /// The work or the memory is beyond the budget.
    #[error(transparent)]
    Budget(#[from] Exceeded),
}
}

fn describe_forces(forces: &[(String, String)]) -> String {
    let parts: Vec<String> =
        forces.iter().map(|(coordinate, force)| format!("the force on {coordinate} is {force} everywhere")).collect();
    parts.join(", ")
}

/// `theta`, or `x[1] + x[2]` for coordinates that move together.
pub(crate) fn combination_words(combination: &[(String, f64)]) -> String {
    if let [(only, _)] = combination {
        return format!("the coordinate `{only}`");
    }
    let mut text = String::new();
    for (name, amplitude) in combination.iter().take(6) {
        let sign = if *amplitude < 0.0 { "-" } else { "+" };
        let size = amplitude.abs();
        let factor = if (size - 1.0).abs() < 1e-9 { String::new() } else { format!("{size:.4}*") };
        if text.is_empty() {
            text = format!("{}{factor}{name}", if sign == "-" { "-" } else { "" });
        } else {
            text = format!("{text} {sign} {factor}{name}");
        }
    }
    if combination.len() > 6 {
        text.push_str(" + …");
    }
    format!("the motion along {text}")
}

fn contradiction_words(difference: Option<&str>) -> String {
    match difference {
        Some(difference) => format!(
            "the constraints contradict each other: where the others hold, the sides of this one differ by {difference}"
        ),
        None => "no place was found where all constraints hold".to_owned(),
    }
}

fn unsupported_words(feature: Feature) -> &'static str {
    match feature {
        Feature::Gyroscopic => {
            "the energies have terms linear in the velocities, which is beyond a mass and a stiffness matrix"
        }
        Feature::Dissipation => "the model has a dissipation function, which is beyond a mass and a stiffness matrix",
        Feature::Constraint => "the model has constraints, which derivations don't cover yet",
        Feature::SteadyMotion => "the model asks for a steady motion, which is beyond a mass and a stiffness matrix",
    }
}
