//! Why a model has no Floquet multipliers, or none that were found.

use librate_core::diagnostic::{at, nowhere};
use librate_core::linearize::LinearizeError;
use librate_core::mistakes;
use librate_core::span::Span;

mistakes! {
/// A model without Floquet multipliers.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
Error FloquetError {
    /// Nothing depends on the time.
    #[error(
        "nothing in this model depends on the time explicitly: it has normal modes, not multipliers"
    )]
    "E0701" NoTime {
        /// Its `period` statement, if it has one.
        span: Option<Span>,
    } => span.map_or_else(nowhere, |span| at(span, "nothing depends on the time"))
        .with_help("use `librate modes`; a drive contains the time `t`: `cos(W*t)`"),

    /// The time occurs, but no period is given.
    #[error("this model depends on the time, but its period is not given")]
    "E0702" NoPeriod(span) {
        /// A period that may be meant, as an expression.
        suggestion: Option<String>,
    } => {
        let help = match suggestion {
            Some(period) => format!("write `period {period}`"),
            None => "write for example `period 2*pi/W` for a drive with cos(W*t); for drives of several frequencies a time after which all of them repeat".to_owned(),
        };
        at(*span, "contains the time").with_help(help)
    },

    /// The model at t and at t + period differs.
    #[error("this is not a period: the equations of motion at t = {time} and a period later differ")]
    "E0703" NotAPeriod(span) {
        /// A time at which they differ.
        time: String,
        /// Where the time occurs.
        energy: Span,
    } => at(*span, "given here").with_secondary(*energy, "contains the time")
        .with_help("a drive with cos(W*t) has the period 2*pi/W"),

    /// A period that is no positive number.
    #[error("the period is {value}, but must be a positive number")]
    "E0704" PeriodNotPositive(span) {
        /// What it is.
        value: String,
    } => at(*span, "given here").with_help("the period is a time, like 2*pi/W"),

    /// A given equilibrium on which a force acts at some time.
    #[error("this is not an equilibrium at all times: a force {force} acts on `{coordinate}`")]
    "E0705" EquilibriumMoves(span) {
        /// The coordinate.
        coordinate: String,
        /// The force, as an expression.
        force: String,
        /// Where the time occurs.
        energy: Span,
    } => at(*span, "given here").with_secondary(*energy, "contains the time")
        .with_help("remove the statement or replace it by `guess`: then the periodic motion near this point is searched for"),

    /// The search for a periodic motion led nowhere.
    #[error("no periodic motion was found: {reason}")]
    "E0706" NoPeriodicMotion(span) {
        /// Where the search ended.
        reason: String,
    } => at(*span, "contains the time")
        .with_help("give a point near the motion, and its velocity there at t = 0, with `guess x` and `guess x'`, or an equilibrium that holds at all times with `equilibrium`"),

    /// A motion that could not be followed over a period.
    #[error("the equations of motion could not be integrated beyond t = {time}")]
    "E0707" Singular(span) {
        /// How far they were followed.
        time: String,
    } => at(*span, "contains the time").with_help(
        "is there a division by zero, a root of a negative number, a corner as of abs, or an inertia 0 along the motion? Check the values of the parameters",
    ),

    /// Equations that have no value.
    #[error("the equations of motion are not defined")]
    "E0708" NotDefined(span) => at(*span, "contains the time").with_help(
        "every coordinate needs a kinetic energy; is a term of T missing, or is there a division by zero?",
    ),

    /// A feature of the language that multipliers do not cover.
    #[error("multipliers are not computed for models with {what}")]
    "E0709" Unsupported(span) {
        /// Which, in words.
        what: &'static str,
    } => at(*span, "")
        .with_help("choose coordinates that satisfy the constraints identically, or a `guess` in place of an `equilibrium`, and write driven rotations with `t`; `motion` integrates what conditions on velocities leave"),

    /// Too much to write out.
    #[error("{coordinates} coordinates with {terms} terms are too many for Floquet multipliers")]
    "E0710" TooLarge {
        /// How many coordinates.
        coordinates: usize,
        /// How many terms.
        terms: usize,
    } => nowhere()
        .with_help("at most 40 coordinates and 10000 terms are possible, because the equations of motion are written out"),

    /// A period that the motion takes too many steps through.
    #[error(
        "the period, {period}, is too long for this motion, which would take more than {steps} steps"
    )]
    "E0711" TooLong(span) {
        /// The period.
        period: String,
        /// How many steps are made at most.
        steps: usize,
        /// Where the time occurs.
        energy: Span,
    } => at(*span, "given here").with_secondary(*energy, "contains the time")
        .with_help("at most some thousand oscillations in one period of the drive are possible; are both in the same unit?"),
} else {
    /// What is wrong with a model already without its drive.
    #[error(transparent)]
    Linearize(#[from] LinearizeError),
}
}
