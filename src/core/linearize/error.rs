//! Why a model has no small oscillations to speak of.

use crate::budget::Exceeded;
use crate::diagnostic::{at, nowhere};
use crate::mistakes;
use crate::span::Span;
use crate::worded;

worded! {
/// What a model may say that not every study covers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
Feature {
    /// A `constraint`.
    Constraint "the model has constraints, which are not supported here",
    /// A `constraint` on velocities.
    Rolling "the model has conditions on velocities, which are not supported here",
    /// A coordinate without inertia.
    Massless "this coordinate has no inertia and follows the others, which is not supported here",
}
/// What is said where it is not covered.
words
}

worded! {
/// What is known of the inertia of a direction in which M is not positive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
Inertia {
    /// There is none, exactly.
    None ": the mass matrix is singular",
    /// There is none, and no force of springs either.
    NoneAndFree " and nothing holds it: the mass matrix is singular",
    /// Bounds do not tell it from 0.
    Undecided " that can be distinguished from zero: the mass matrix is not shown to be positive definite",
}
/// How the sentence that a motion has no inertia ends.
words
}

/// What is not defined where a `guess` or `equilibrium` comes to no number.
pub(super) const GIVEN_VALUE: &str = "the given value";

mistakes! {
/// A model that can't be linearized.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
Error LinearizeError {
    /// A parameter without a value where numbers are asked for.
    #[error("the parameter `{name}` has no value")]
    "E0301" MissingValue(span) {
        /// The parameter.
        name: String,
    } => at(*span, "declared without a value").with_help(format!(
        "give it a value in the file, or on the command line: --set {name}=VALUE"
    )),

    /// A point given as equilibrium where parameters without values decide whether a force acts.
    #[error(
        "whether this is an equilibrium depends on the values of parameters: the force on `{coordinate}` is {force}"
    )]
    "E0321" ForceOfParameters(span) {
        /// The coordinate.
        coordinate: String,
        /// The generalised force, as an expression.
        force: String,
        /// What absolute values are taken of in it.
        unsigned: Vec<String>,
    } => at(*span, "given here").with_help(match unsigned.first() {
        Some(first) => format!(
            "the sign of `{first}` is not known: write `assume {first} > 0` where it is positive, or give the parameters values"
        ),
        None => "the sign of a root depends on signs of parameters: write them with `assume d > 0`, or give the parameters values".to_owned(),
    }),

    /// A point given as equilibrium where a force acts.
    #[error("this is not an equilibrium: a force {force} acts on `{coordinate}`")]
    "E0302" NotAnEquilibrium(span) {
        /// The coordinate.
        coordinate: String,
        /// The generalised force, as an expression, as a number or both.
        force: String,
    } => at(*span, "given here").with_help(
        "at an equilibrium every generalised force vanishes; if this point is only near the equilibrium, give it with `guess`: the search starts there",
    ),

    /// A force that vanishes nowhere.
    #[error("there is no equilibrium: {}", describe_forces(.forces))]
    "E0303" NoEquilibrium(span) {
        /// The coordinate (or the combination that moves together) and the force on it.
        forces: Vec<(String, String)>,
    } => at(*span, "there is no restoring force on this coordinate").with_help(
        "without an equilibrium there are no small oscillations; is a restoring force missing?",
    ),

    /// A search that led nowhere.
    #[error("no equilibrium was found")]
    "E0304" EquilibriumNotFound(span) {
        /// The coordinate with the largest force left.
        coordinate: String,
        /// That force.
        force: String,
        /// The point the search ended at.
        point: String,
    } => at(*span, format!("the force on `{coordinate}` is still {force}"))
        .with_help(format!(
            "the search ended at {point}; if there is an equilibrium, give a point near it with `guess`"
        )),

    /// A search that began or ended where a constraint says nothing of where to go.
    #[error(
        "no equilibrium was found: the gradient of a constraint vanishes at {point}, where the search {}",
        if *.ended { "ended" } else { "began" }
    )]
    "E0320" ConstraintFlat(span) {
        /// The point.
        point: String,
        /// Whether the search ended there; else it began there.
        ended: bool,
        /// Whether the constraint holds there, as nearly as can be told.
        holds: bool,
    } => at(*span, "this constraint")
        .with_help(if *holds {
            "a constraint that is a square or a product, such as (x - y)^2 = 0, does not determine the allowed motions: write x = y; if there is an equilibrium elsewhere, give a point near it with `guess`"
        } else {
            "there the constraint restricts no motion and exerts no force: start elsewhere, with `guess`"
        }),

    /// An energy or one of its derivatives that is no number at the point in question.
    #[error("{what} is not defined at {point}")]
    "E0305" NotFinite(span) {
        /// `the energy`, `the force`, …
        what: String,
        /// The point.
        point: String,
        /// What makes it undefined, if that can be told: `the divisor `a - b` is 0 for a = 1, b = 1`.
        cause: Option<String>,
    } => {
        let label = if what == GIVEN_VALUE { "given here" } else { "in this term" };
        let help = cause.as_deref().unwrap_or(
            "is there a division by zero, a root of a negative number, or a number too large? Check the values of the parameters and all terms of sums; if a coordinate is the cause, choose another starting point with `guess`",
        );
        at(*span, label).with_help(help)
    },

    /// A direction without inertia that follows no others.
    #[error("{} has no inertia{}", combination_words(.combination), .inertia.words())]
    "E0306" SingularMass(span) {
        /// The coordinates that move together, with their amplitudes.
        combination: Vec<(String, f64)>,
        /// What is known of it.
        inertia: Inertia,
    } => at(*span,
            if *inertia == Inertia::Undecided {
                "has none, or too little compared with the others"
            } else {
                "its velocity does not occur squared in T"
            },
        )
        .with_help("a motion needs a kinetic energy, or a spring in V that it follows, or a damper in `dissipation`; is a term missing?"),

    /// A direction without inertia that what it couples to would have to hold.
    #[error("{} has no inertia and can't be eliminated: it fixes other coordinates instead of following them", combination_words(.combination))]
    "E0326" NotCondensed(span) {
        /// The coordinates that move together, with their amplitudes.
        combination: Vec<(String, f64)>,
    } => at(*span, "V has no term of second order in this motion")
        .with_help("a multiplier, such as y in V = y*(x - a), is written `constraint x = a`; otherwise give the motion a mass in T or a spring in V"),

    /// A direction with negative inertia.
    #[error("{} has a negative inertia: the mass matrix is not positive", combination_words(.combination))]
    "E0307" IndefiniteMass(span) {
        /// The coordinates that move together, with their amplitudes.
        combination: Vec<(String, f64)>,
    } => at(*span, "declared here")
        .with_help("a kinetic energy can't be negative; is a sign in T wrong?"),

    /// A rest or steady motion that a condition on velocities forbids.
    #[error("this condition on the velocities does not hold at the equilibrium: its sides differ by {difference}")]
    "E0322" RollingBroken(span) {
        /// The left side less the right one, as an expression.
        difference: String,
    } => at(*span, "violated by the steady motion")
        .with_help("give rates that satisfy it: a wheel that rolls at speed v turns at the rate v/r"),

    /// Conditions on velocities whose small oscillations are not worked out.
    #[error("the small oscillations under these conditions on velocities are not covered: {reason}")]
    "E0323" RollingNotCovered(span) {
        /// Why.
        reason: &'static str,
    } => at(*span, "a condition on velocities")
        .with_help("`motion` integrates the full equations; conditions with constant coefficients, x' = r*theta', are always covered"),

    /// A feature of the language that modes do not cover.
    #[error("{}", .feature.words())]
    "E0308" Unsupported(span) {
        /// Which.
        feature: Feature,
    } => at(*span, "")
        .with_help(match feature {
            Feature::Rolling => "`modes` and `motion` cover them; their equilibria come in families and are not isolated",
            Feature::Massless => "`modes`, `derive`, `sweep`, `sensitivity`, `response` and `export` of matrices cover it; for other commands give it a small inertia",
            Feature::Constraint => "write the energies in independent coordinates, such as an angle in place of x and y on a circle; `modes` covers constraints",
        }),

    /// A steady rate of a coordinate that something depends on.
    #[error("`{coordinate}` can't turn at a constant rate{}", if .tied.is_some() { " alone" } else { ", because it is not cyclic" })]
    "E0312" NotCyclic(span) {
        /// The coordinate.
        coordinate: String,
        /// Where the coordinate itself occurs.
        energy: Span,
        /// The rate of another one at which a constraint holds on: `p2' = R1*W/R2`.
        tied: Option<String>,
    } => match tied {
        Some(rate) => at(*span, "given here")
            .with_secondary(*energy, "violated as time goes on, at the given rates")
            .with_help(format!("give also the rate of the coordinate tied to `{coordinate}`, from the constraint: `equilibrium {rate}`")),
        None => at(*span, "given here")
            .with_secondary(*energy, format!("depends on `{coordinate}`"))
            .with_help("a coordinate keeps its rate only if the energies contain its velocity but not the coordinate itself; for a rotation maintained by a motor, write the rate in place of the coordinate"),
    },

    /// Constraints that can't hold together.
    #[error("{}", contradiction_words(.difference.as_deref()))]
    "E0313" ConstraintsContradict(span) {
        /// What the sides of this one differ by where the others hold; `None` where no place was found at which they
        /// all hold.
        difference: Option<String>,
    } => at(*span, "this constraint")
        .with_help(if difference.is_some() {
            "remove one of them, or correct its numbers"
        } else {
            "give a point near the equilibrium with `guess`; are there too many constraints?"
        }),

    /// A given equilibrium off a constraint.
    #[error("the given equilibrium violates a constraint: its sides differ by {difference}")]
    "E0314" ConstraintBroken(span) {
        /// Left less right side.
        difference: String,
        /// Where the equilibrium is given.
        given: Option<Span>,
    } => at(*span, "violated").and_at(*given, "given here").with_help(
        "an equilibrium must satisfy all constraints; if this is only near the equilibrium, give it with `guess`",
    ),

    /// Constraints that depend on each other at the equilibrium, though not everywhere.
    #[error(
        "the constraints are singular at {point}: there they do not determine the allowed motions"
    )]
    "E0315" ConstraintsSingular(span) {
        /// The point.
        point: String,
    } => at(*span, "the gradients of the constraints are dependent there")
        .with_help("a redundant constraint, such as an extra bar in a closed linkage, follows from the others where they hold: leave it out; otherwise the body has more or fewer degrees of freedom there than nearby, and small oscillations are not defined: search for an equilibrium elsewhere with `guess`"),

    /// A dissipation that has no second derivatives at rest, or a force that has no first ones.
    #[error("{what} is not smooth at rest")]
    "E0316" FrictionNotSmooth(span) {
        /// `the dissipation` or `the force`.
        what: &'static str,
        /// What is to blame, as an expression.
        part: String,
    } => at(*span, format!("`{part}` has a corner at rest"))
        .with_help("with dry friction there are no small oscillations: a body at rest sticks; write friction with squares of velocities, F = 1/2*c*x'^2, and forces with powers of them"),

    /// A steady rate that friction brakes.
    #[error("`{coordinate}` does not keep its rate: a force of {force} acts on it")]
    "E0317" RateNotKept(span) {
        /// The coordinate.
        coordinate: String,
        /// The force, as an expression.
        force: String,
    } => at(*span, "given here")
        .with_help("in a steady motion there is no friction, or a drive balances it: friction against a medium that turns at the same rate is 1/2*c*(psi' - S)^2"),

    /// Coordinates that lose a direction at the equilibrium, as Euler angles do.
    #[error("the coordinates are singular at this equilibrium: {} moves nothing there, but does nearby", singular_words(.combination, *.drawn))]
    "E0318" SingularCoordinates(span) {
        /// The coordinates that move together, with their amplitudes.
        combination: Vec<(String, f64)>,
        /// Whether the amplitudes are those of values that were drawn for parameters.
        drawn: bool,
    } => at(*span, "has no independent motion there")
        .with_help("Euler angles are singular where two axes coincide (gimbal lock): use angles about other axes, for an upright top R = rot_x(a)*rot_y(b)*rot_z(psi); a joint without mass is singular where the rods are in line: give it a small mass, or write T with the velocities at the equilibrium, as 1/2*m*(l1*a' + l2*b')^2"),

    /// Energies that depend on the time.
    #[error("this model depends on the time explicitly and has no normal modes")]
    "E0309" TimeDependent(span) => at(*span, "contains the time")
        .with_help("the motion about a driven state has Floquet multipliers instead: `librate floquet` computes them; the response to a harmonic force is computed by `librate response`"),

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
        /// Whether they are too many for source code.
        in_code: bool,
    } => nowhere().with_help(if *in_code {
        "source code is for small models; `librate export --matrix-market` and `--npz` write sparse matrices of any number of coordinates"
    } else {
        "some of the modes need no dense matrices: `librate modes --lowest 10`; with constraints, friction that acts at rest or a search for the equilibrium use fewer coordinates"
    }),
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

/// Only which coordinates move, where the amplitudes are those of drawn values.
fn singular_words(combination: &[(String, f64)], drawn: bool) -> String {
    if combination.len() < 2 || !drawn {
        return combination_words(combination);
    }
    let mut names: Vec<String> = combination.iter().take(6).map(|(name, _)| format!("`{name}`")).collect();
    if combination.len() > 6 {
        names.push("…".to_owned());
    }
    format!("a motion of {} together", names.join(", "))
}

fn contradiction_words(difference: Option<&str>) -> String {
    match difference {
        Some(difference) => format!(
            "the constraints contradict each other: where the others hold, the sides of this one differ by {difference}"
        ),
        None => "no point was found where all constraints hold".to_owned(),
    }
}
