//! The words of mechanics for dimensions, and how to say what factor is missing.

use super::Dimension;

/// Exponents of kg, m, s, A, K, mol, cd; the word; the unit's own symbol where it has one.
type Entry = ([i8; 7], &'static str, Option<&'static str>);

/// What a missing factor is called first: the simplest quantities.
const SIMPLE: &[Entry] = &[
    ([0, 1, 0, 0, 0, 0, 0], "a length", None),
    ([1, 0, 0, 0, 0, 0, 0], "a mass", None),
    ([0, 0, 1, 0, 0, 0, 0], "a time", None),
    ([0, 2, 0, 0, 0, 0, 0], "the square of a length", None),
    ([0, 0, 2, 0, 0, 0, 0], "the square of a time", None),
    ([0, 0, 0, 1, 0, 0, 0], "a current", None),
    ([0, 0, 1, 1, 0, 0, 0], "a charge", Some("C")),
    ([0, 0, 0, 0, 1, 0, 0], "a temperature", None),
    ([0, 0, 0, 0, 0, 1, 0], "an amount of substance", None),
    ([0, 0, 0, 0, 0, 0, 1], "a luminous intensity", None),
];

const WORDS: &[Entry] = &[
    ([0, 0, 0, 0, 0, 0, 0], "a pure number", None),
    ([0, 2, 0, 0, 0, 0, 0], "an area", None),
    ([0, 3, 0, 0, 0, 0, 0], "a volume", None),
    ([0, 0, -1, 0, 0, 0, 0], "a rate", None),
    ([0, 0, -2, 0, 0, 0, 0], "an angular acceleration", None),
    ([0, 1, -1, 0, 0, 0, 0], "a velocity", None),
    ([0, 1, -2, 0, 0, 0, 0], "an acceleration", None),
    ([0, 2, -2, 0, 0, 0, 0], "the square of a velocity", None),
    ([1, 1, -2, 0, 0, 0, 0], "a force", Some("N")),
    ([1, 2, -2, 0, 0, 0, 0], "an energy", Some("J")),
    ([1, 2, -3, 0, 0, 0, 0], "a power", Some("W")),
    ([1, 1, -1, 0, 0, 0, 0], "a momentum", None),
    ([1, 2, -1, 0, 0, 0, 0], "an angular momentum", Some("J*s")),
    ([1, 0, -2, 0, 0, 0, 0], "a spring constant", Some("N/m")),
    ([1, 0, -1, 0, 0, 0, 0], "a friction coefficient", None),
    ([1, 2, 0, 0, 0, 0, 0], "a moment of inertia", None),
    ([1, -1, 0, 0, 0, 0, 0], "a mass per length", None),
    ([1, -2, 0, 0, 0, 0, 0], "a mass per area", None),
    ([1, -3, 0, 0, 0, 0, 0], "a density", None),
    ([1, -1, -2, 0, 0, 0, 0], "a pressure", Some("Pa")),
    ([1, 2, -3, -1, 0, 0, 0], "a voltage", Some("V")),
    ([1, 1, -3, -1, 0, 0, 0], "an electric field", Some("V/m")),
    ([1, 2, -3, -2, 0, 0, 0], "a resistance", Some("ohm")),
    ([-1, -2, 3, 2, 0, 0, 0], "a conductance", Some("S")),
    ([-1, -2, 4, 2, 0, 0, 0], "a capacitance", Some("F")),
    ([1, 2, -2, -2, 0, 0, 0], "an inductance", Some("H")),
    ([1, 2, -2, -1, 0, 0, 0], "a magnetic flux", Some("Wb")),
    ([1, 0, -2, -1, 0, 0, 0], "a magnetic field", Some("T")),
];

fn find<'a>(list: &'a [Entry], dimension: &Dimension) -> Option<&'a Entry> {
    list.iter().find(|(exponents, _, _)| Dimension::new(*exponents) == *dimension)
}

/// The word for a quantity, with its article.
pub(super) fn word(dimension: &Dimension) -> Option<&'static str> {
    find(WORDS, dimension).or_else(|| find(SIMPLE, dimension)).map(|(_, word, _)| *word)
}

/// The symbol of a derived unit.
pub(super) fn symbol(dimension: &Dimension) -> Option<&'static str> {
    find(WORDS, dimension).or_else(|| find(SIMPLE, dimension)).and_then(|(_, _, symbol)| *symbol)
}

/// What to do to something of dimension `found` to make it `wanted`.
pub(super) fn remedy(found: &Dimension, wanted: &Dimension) -> String {
    let factor = found.missing(wanted);
    let inverse = factor.inverse();
    let times = |entry: &Entry| format!("multiply by {}", entry.1);
    let over = |entry: &Entry| format!("divide by {}", entry.1);
    let named = find(SIMPLE, &factor)
        .map(times)
        .or_else(|| find(SIMPLE, &inverse).map(over))
        .or_else(|| find(WORDS, &factor).map(times))
        .or_else(|| find(WORDS, &inverse).map(over));
    let remedy = named.unwrap_or_else(|| format!("a factor in {} is missing", factor.unit()));
    let is_rate = [-1, -2].iter().any(|power| factor == Dimension::new([0, 0, *power, 0, 0, 0, 0]));
    if is_rate { format!("{remedy}; is the prime of a velocity missing?") } else { remedy }
}
