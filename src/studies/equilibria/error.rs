//! Why a box can't be searched.

use librate_core::budget::Exceeded;
use librate_core::diagnostic::nowhere;
use librate_core::linearize::LinearizeError;
use librate_core::mistakes;
use librate_core::model::ModelError;

mistakes! {
/// A box that is none, or a model whose equilibria are not searched for.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
Error EquilibriaError {
    /// Words that are no side of a box.
    #[error("can't read `{text}`: {reason}")]
    "E0720" BadSide {
        /// What was written.
        text: String,
        /// What is wrong.
        reason: String,
    } => nowhere().with_help("a box has a range for each coordinate: `--box \"x=-2..2, phi=-pi..pi\"`"),

    /// A name that no coordinate has.
    #[error("there is no coordinate `{name}`")]
    "E0721" NotACoordinate {
        /// The name.
        name: String,
        /// One that is spelled alike, or all there are.
        help: String,
    } => nowhere().with_help(help),

    /// A range without values, or without ends.
    #[error("the range of `{coordinate}` is {what}: {from}..{to}")]
    "E0722" BadRange {
        /// The coordinate.
        coordinate: String,
        /// `reversed`, `infinite` or `too large`.
        what: &'static str,
        /// The lower end.
        from: String,
        /// The upper end.
        to: String,
    } => nowhere().with_help(match *what {
        "reversed" => format!("write `{coordinate}={to}..{from}`"),
        _ => "both ends are finite; a large box does as well".to_owned(),
    }),

    /// A coordinate that the box has no range for.
    #[error("the box has no range for {}", listed(.coordinates))]
    "E0723" MissingSide {
        /// The coordinates.
        coordinates: Vec<String>,
    } => nowhere().with_help(format!(
        "add `{}=a..b`; only a coordinate that nothing depends on may be left out",
        coordinates.first().map_or("x", String::as_str)
    )),

    /// Too many coordinates.
    #[error("the model has {coordinates} coordinates and constraints, more than {most}")]
    "E0724" TooLarge {
        /// How many.
        coordinates: usize,
        /// How many there may be.
        most: usize,
    } => nowhere().with_help("all equilibria in a box are searched for in small models; `modes` finds one near `guess`"),

    /// Forces that can't be written out.
    #[error("the forces on a model at rest are not defined")]
    "E0725" NoForces {} => nowhere().with_help("is there friction that is undefined at rest, such as a velocity divided by its absolute value?"),

    /// A parameter on which it depends how many coordinates or terms there are.
    #[error("`{parameter}` can't vary: it sets the range of an index")]
    "E0726" SetsRanges {
        /// The parameter.
        parameter: String,
    } => nowhere().with_help("branches are followed over a parameter on which the forces depend smoothly"),

    /// More values than are examined.
    #[error("{values} values of the parameter are too many")]
    "E0727" TooManyValues {
        /// How many.
        values: usize,
        /// How many there may be.
        most: usize,
    } => nowhere().with_help(format!("at most {most}; between two values branches are followed all the same")),
} else {
    /// The work or the memory is beyond the budget.
    #[error(transparent)]
    Budget(#[from] Exceeded),
    /// A value that the parameter can't have.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// What an earlier stage says.
    #[error(transparent)]
    Linearize(#[from] LinearizeError),
}
}

/// `` `x`, `y` and `z` ``
fn listed(names: &[String]) -> String {
    const MOST: usize = 6;
    let mut shown: Vec<String> = names.iter().take(MOST).map(|name| format!("`{name}`")).collect();
    shown.extend((names.len() > MOST).then(|| format!("{} others", names.len() - MOST)));
    match shown.split_last() {
        Some((last, [])) => last.clone(),
        Some((last, first)) => format!("{} and {last}", first.join(", ")),
        None => String::new(),
    }
}
