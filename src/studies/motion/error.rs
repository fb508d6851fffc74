//! Why a motion can't be computed.

use librate_core::diagnostic::nowhere;
use librate_core::linearize::LinearizeError;
use librate_core::mistakes;

mistakes! {
/// A motion that can't be computed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
Error MotionError {
    /// An entry of a list of starting values that can't be read.
    #[error("can't read the start `{text}`: {reason}")]
    "E0601" BadStart {
        /// The entry.
        text: String,
        /// What is wrong.
        reason: String,
    } => nowhere().with_help("write coordinates and velocities with their values: `--start \"phi[1]=0.1, phi[1]'=0\"`"),

    /// A starting value for something that is no coordinate.
    #[error("`{name}` is not a coordinate of the model")]
    "E0602" NotACoordinate {
        /// The name.
        name: String,
        /// The coordinate that may have been meant.
        nearest: Option<String>,
    } => match nearest {
        Some(nearest) => nowhere().with_help(format!("did you mean `{nearest}`?")),
        None => nowhere().with_help("initial values are given for coordinates, and for velocities with a prime: `x=1, x'=0`"),
    },

    /// A mode that the model does not have.
    #[error("there is no mode {mode}: the model has {count}")]
    "E0603" NoSuchMode {
        /// The number that was asked for.
        mode: usize,
        /// How many modes there are.
        count: usize,
    } => nowhere().with_help("modes are counted from 1 in the order of `librate modes`"),

    /// An amplitude that is no number.
    #[error("the amplitude `{text}` is not a number")]
    "E0604" BadAmplitude {
        /// As it was given.
        text: String,
    } => nowhere().with_help("an amplitude is the largest displacement of the mode: `--amplitude 1/10`"),

    /// An end or a number of rows that is none.
    #[error("no rows until {until}: {reason}")]
    "E0605" BadTimes {
        /// The end as it was given.
        until: String,
        /// The number of rows.
        samples: usize,
        /// What is wrong.
        reason: String,
    } => nowhere().with_help("write for example `--until 10 --samples 101`"),

    /// A start off the constraints that nothing can be done about.
    #[error("the start does not satisfy the constraints: {reason}")]
    "E0606" OffConstraints {
        /// By how much, or why the rest can't be found.
        reason: String,
    } => nowhere().with_help("give as many coordinates as there are degrees of freedom; the others follow from the constraints"),

    /// A table of starts or of times that is none.
    #[error("the table can't be used (line {line}): {reason}")]
    "E0615" BadTable {
        /// The line of the file, from 1.
        line: u64,
        /// What is wrong.
        reason: String,
    } => nowhere().with_help("a table has a header: coordinates and velocities for `--start-table`, `t` for `--at`; and rows of numbers"),

    /// The motion ends on its way.
    #[error("the motion meets a singularity at t = {time}, {place}: {reason}")]
    "E0607" Singular {
        /// When.
        time: String,
        /// Where.
        place: String,
        /// What is wrong there.
        reason: String,
    } => nowhere().with_help("a shorter time, another start or other coordinates avoid it"),

    /// The motion can't be followed, for no reason that is certain.
    #[error("the motion can't be continued beyond t = {time}, {place}: {reason}")]
    "E0614" Stuck {
        /// When.
        time: String,
        /// Where.
        place: String,
        /// What is known of it.
        reason: String,
    } => nowhere().with_help("a shorter time, another start or other coordinates avoid it"),

    /// Too much to write out.
    #[error("{terms} terms are too many to integrate: at most {most}")]
    "E0608" TooLarge {
        /// How many terms.
        terms: usize,
        /// The limit.
        most: usize,
    } => nowhere().with_help("every step evaluates all of them: use a smaller model"),

    /// A table that is too large.
    #[error("a table of {numbers} numbers is too large: at most {most}")]
    "E0609" TooManyNumbers {
        /// How many numbers.
        numbers: usize,
        /// The limit.
        most: usize,
    } => nowhere().with_help("request fewer rows"),

    /// A motion of too many steps.
    #[error("the motion takes too many steps: {steps} lead to t = {reached}")]
    "E0610" TooLong {
        /// How far it was followed.
        reached: String,
        /// In how many steps.
        steps: usize,
    } => nowhere().with_help(
        "request a shorter time; the fastest oscillation, decay or rotation of the model sets the steps",
    ),

    /// A motion that can't be proved up to its end.
    #[error("the motion is proved only up to t = {reached}: {reason}")]
    "E0611" NotProved {
        /// How far it was followed.
        reached: String,
        /// What ended it.
        reason: &'static str,
    } => nowhere().with_help("request a shorter time; without `--proved` the digits are estimates"),

    /// A start that is only known about.
    #[error("the start is not known exactly enough for a proof")]
    "E0612" OpenStart {} => nowhere().with_help(
        "give a number for every coordinate and velocity that does not rest at the equilibrium",
    ),

    /// Too much to solve for the accelerations.
    #[error(
        "{coordinates} coordinates with their constraints are too many for a proof: at most {most}"
    )]
    "E0613" TooLargeToProve {
        /// How many coordinates and constraints.
        coordinates: usize,
        /// The limit.
        most: usize,
    } => nowhere().with_help("without `--proved` the digits are estimates"),
} else {
    /// What keeps the model from having an equilibrium or modes.
    #[error(transparent)]
    Linearize(#[from] LinearizeError),
}
}
