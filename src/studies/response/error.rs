//! Why a model has no steady response, or none that is computed.

use librate_core::diagnostic::{at, nowhere};
use librate_core::linearize::LinearizeError;
use librate_core::mistakes;
use librate_core::model::ModelError;

mistakes! {
/// A model without the steady response that is asked for.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
Error ResponseError {
    /// An input or output that is no coordinate.
    #[error("the {what} `{name}` is not a coordinate of the model")]
    "E1101" NotACoordinate {
        /// Which of the two it is.
        what: &'static str,
        /// As it was given.
        name: String,
        /// The coordinate that may have been meant.
        nearest: Option<String>,
        /// The first coordinate.
        first: String,
    } => match nearest {
        Some(nearest) => nowhere().with_help(format!("did you mean `{nearest}`?")),
        None => nowhere()
            .with_help(format!("forces act on coordinates, and coordinates respond: `--input '{first}' --output '{first}'`")),
    },

    /// No force is given, and the model has none that depends on the time.
    #[error("nothing drives this model: no energy and no force depends on the time")]
    "E1102" NotDriven => nowhere().with_help(
        "give a harmonic force of unit amplitude with `--input x --over omega=a..b:n`, or write a drive into the model: `force x = F*cos(W*t)`",
    ),

    /// A force is given beside one that the model has.
    #[error("this model already contains the time, in addition to the force on `{input}`")]
    "E1103" DrivenAlready(span) {
        /// The coordinate the force is to act on.
        input: String,
    } => at(*span, "contains the time").with_help(
        "without `--input` the response to the model's own drive is computed; for another force write the model without it",
    ),

    /// The parameter of the range is not in the frequency of the drive.
    #[error("the frequency of the drive does not depend on `{parameter}`")]
    "E1104" OtherFrequency(span) {
        /// The parameter.
        parameter: String,
        /// The angular frequency of the drive, as an expression.
        rate: Option<String>,
    } => {
        let shown = at(*span, "contains the time");
        match rate {
            Some(rate) => shown.with_help(format!(
                "the drive contains the time in sines and cosines of ({rate})*t: give a range of a parameter in it"
            )),
            None => shown.with_help("a drive contains the time in sines and cosines: `cos(W*t)`, for `--over W=a..b:n`"),
        }
    },

    /// A drive that is no sum of cos(W t) and sin(W t).
    #[error("the drive is not harmonic: {reason}")]
    "E1105" NotHarmonic(span) {
        /// What else it is.
        reason: String,
    } => at(*span, "contains the time").with_help(
        "the steady response is that to a force of one frequency; `floquet` finds periodic motions, `motion` follows any",
    ),

    /// A drive that changes the inertia, the friction or the stiffness.
    #[error("the drive is parametric: {matrix} at the equilibrium {verb} on the time", verb = if *.proved { "depends" } else { "may depend" })]
    "E1106" Parametric(span) {
        /// Which matrix.
        matrix: &'static str,
        /// Whether that is so; else it is not shown that it is not so.
        proved: bool,
    } => at(*span, "contains the time").with_help(
        "the linearised equations then have periodic coefficients: `floquet` decides on their stability, `motion` follows them",
    ),

    /// A feature of the language that responses do not cover.
    #[error("the response is not computed for {what}")]
    "E1107" Unsupported(span) {
        /// Which, in words.
        what: &'static str,
    } => at(*span, "").with_help("`motion` integrates a driven model from any start; without the drive `modes` has its exponents"),

    /// A negative frequency.
    #[error("the frequency is negative from {from} to {to}")]
    "E1108" NegativeFrequency {
        /// Where the range begins.
        from: String,
        /// Where it ends.
        to: String,
    } => nowhere().with_help("the response at -omega is the complex conjugate of that at omega: give a range from 0 on"),

    /// A range for peaks that has no inside.
    #[error("there is nothing between the ends of the range: both are {range}")]
    "E1110" EmptyRange {
        /// Both of its ends.
        range: String,
    } => nowhere().with_help("give the range of frequencies to search for peaks: `--over omega=0..20`"),

    /// Too much to write out.
    #[error("{coordinates} coordinates with {terms} terms are too many for the response to the model's own drive")]
    "E1109" TooLarge {
        /// How many coordinates.
        coordinates: usize,
        /// How many terms.
        terms: usize,
    } => nowhere()
        .with_help("at most 10000 terms are possible, because the equations of motion are written out; with `--input` there may be more"),
} else {
    /// What is wrong with a model already without its drive.
    #[error(transparent)]
    Linearize(#[from] LinearizeError),
    /// A value of the range that the model can't have.
    #[error(transparent)]
    Model(#[from] ModelError),
}
}
