//! Units: names, prefixes, the factors that lead to SI, and the dimensions.
//!
//! What the dimensions say about the energies is the business of [`super::dimension`].

use super::{Dimension, ModelError};
use crate::diagnostic::{Meant, nearest};
use crate::expr::{ExprId, Pool};
use crate::number::Number;
use crate::order::Gather;
use crate::span::Span;
use crate::syntax::{File, UnitKind, UnitRef};

/// A unit: its SI factor as a decimal literal, of an angle by which part of pi, and whether it takes prefixes.
struct Known {
    name: &'static str,
    factor: &'static str,
    /// The factor is to be multiplied by pi over this.
    pi_over: Option<i64>,
    prefixes: bool,
    /// The exponents of kg, m, s, A, K, mol, cd.
    exponents: [i8; 7],
}

const fn unit(name: &'static str, factor: &'static str, prefixes: bool, exponents: [i8; 7]) -> Known {
    Known { name, factor, pi_over: None, prefixes, exponents }
}

/// A unit with an angle: pi over a number, times a whole one.
const fn angle(name: &'static str, factor: &'static str, pi_over: i64, exponents: [i8; 7]) -> Known {
    Known { name, factor, pi_over: Some(pi_over), prefixes: false, exponents }
}

/// SI base and derived units (the SI Brochure, 9th edition), those accepted beside them, atomic
/// ones with CODATA 2022 values, and those of engineers: the thermochemical calorie, the international inch and pound,
/// and the pound-force with the standard gravity 9.80665 m/s^2.
const UNITS: &[Known] = &[
    unit("m", "1", true, [0, 1, 0, 0, 0, 0, 0]),
    unit("g", "1e-3", true, [1, 0, 0, 0, 0, 0, 0]),
    unit("s", "1", true, [0, 0, 1, 0, 0, 0, 0]),
    unit("A", "1", true, [0, 0, 0, 1, 0, 0, 0]),
    unit("K", "1", true, [0, 0, 0, 0, 1, 0, 0]),
    unit("mol", "1", true, [0, 0, 0, 0, 0, 1, 0]),
    unit("cd", "1", true, [0, 0, 0, 0, 0, 0, 1]),
    unit("rad", "1", true, [0, 0, 0, 0, 0, 0, 0]),
    unit("sr", "1", true, [0, 0, 0, 0, 0, 0, 0]),
    unit("Hz", "1", true, [0, 0, -1, 0, 0, 0, 0]),
    unit("N", "1", true, [1, 1, -2, 0, 0, 0, 0]),
    unit("Pa", "1", true, [1, -1, -2, 0, 0, 0, 0]),
    unit("J", "1", true, [1, 2, -2, 0, 0, 0, 0]),
    unit("W", "1", true, [1, 2, -3, 0, 0, 0, 0]),
    unit("C", "1", true, [0, 0, 1, 1, 0, 0, 0]),
    unit("V", "1", true, [1, 2, -3, -1, 0, 0, 0]),
    unit("F", "1", true, [-1, -2, 4, 2, 0, 0, 0]),
    unit("ohm", "1", true, [1, 2, -3, -2, 0, 0, 0]),
    unit("Ω", "1", true, [1, 2, -3, -2, 0, 0, 0]),
    unit("S", "1", true, [-1, -2, 3, 2, 0, 0, 0]),
    unit("Wb", "1", true, [1, 2, -2, -1, 0, 0, 0]),
    unit("T", "1", true, [1, 0, -2, -1, 0, 0, 0]),
    unit("H", "1", true, [1, 2, -2, -2, 0, 0, 0]),
    unit("lm", "1", true, [0, 0, 0, 0, 0, 0, 1]),
    unit("lx", "1", true, [0, -2, 0, 0, 0, 0, 1]),
    unit("Bq", "1", true, [0, 0, -1, 0, 0, 0, 0]),
    unit("Gy", "1", true, [0, 2, -2, 0, 0, 0, 0]),
    unit("Sv", "1", true, [0, 2, -2, 0, 0, 0, 0]),
    unit("kat", "1", true, [0, 0, -1, 0, 0, 1, 0]),
    unit("L", "1e-3", true, [0, 3, 0, 0, 0, 0, 0]),
    unit("l", "1e-3", true, [0, 3, 0, 0, 0, 0, 0]),
    unit("min", "60", false, [0, 0, 1, 0, 0, 0, 0]),
    unit("h", "3600", false, [0, 0, 1, 0, 0, 0, 0]),
    unit("d", "86400", false, [0, 0, 1, 0, 0, 0, 0]),
    unit("angstrom", "1e-10", false, [0, 1, 0, 0, 0, 0, 0]),
    unit("t", "1e3", false, [1, 0, 0, 0, 0, 0, 0]),
    unit("u", "1.66053906892e-27", false, [1, 0, 0, 0, 0, 0, 0]),
    unit("eV", "1.602176634e-19", true, [1, 2, -2, 0, 0, 0, 0]),
    unit("cal", "4.184", true, [1, 2, -2, 0, 0, 0, 0]),
    unit("bar", "1e5", true, [1, -1, -2, 0, 0, 0, 0]),
    unit("atm", "101325", false, [1, -1, -2, 0, 0, 0, 0]),
    unit("in", "0.0254", false, [0, 1, 0, 0, 0, 0, 0]),
    unit("ft", "0.3048", false, [0, 1, 0, 0, 0, 0, 0]),
    unit("lb", "0.45359237", false, [1, 0, 0, 0, 0, 0, 0]),
    unit("lbf", "4.4482216152605", false, [1, 1, -2, 0, 0, 0, 0]),
    angle("deg", "1", 180, [0; 7]),
    angle("rev", "2", 1, [0; 7]),
    angle("rpm", "1", 30, [0, 0, -1, 0, 0, 0, 0]),
];

/// The prefixes of the powers of 1000 from the tenth down; the power 0 has none.
const BY_THOUSANDS: &str = "QRYZEPTGMk munpfazyrq";

/// The others, each with its power of ten.
const PREFIXES: [(&str, i32); 6] = [("da", 1), ("h", 2), ("d", -1), ("c", -2), ("µ", -6), ("μ", -6)];

/// The names of the units, without prefixes.
pub fn unit_names() -> impl Iterator<Item = &'static str> {
    UNITS.iter().map(|known| known.name)
}

/// The same, and those with the usual prefixes: `kg`, `cm`, `kN`.
pub fn units_with_prefixes() -> impl Iterator<Item = String> {
    let prefixed = |prefix: &'static str| {
        let units = UNITS.iter().filter(|known| known.prefixes);
        units.map(move |known| format!("{prefix}{}", known.name))
    };
    let usual = ["k", "M", "G", "m", "u", "n"].into_iter().flat_map(prefixed);
    unit_names().map(str::to_owned).chain(usual).chain(["cm".to_owned()])
}

/// What is measured in a unit, which may have a prefix.
///
/// ```
/// let force = librate::model::unit_dimension("kN").map(|own| own.to_string());
/// assert_eq!(force.as_deref(), Some("a force"));
/// ```
#[must_use]
pub fn unit_dimension(name: &str) -> Option<Dimension> {
    exponents(name).map(Dimension::new)
}

fn named_factor(pool: &mut Pool, name: &str) -> Option<ExprId> {
    let (known, exponent) = look_up(name)?;
    let number = Number::parse(known.factor)?.mul(&Number::from(10).powi(exponent)?);
    let Some(over) = known.pi_over else { return Some(pool.number(number)) };
    let share = number.div(&Number::from(over))?;
    Some(pool.scale(pool.pi(), &share))
}

/// The unit that a name means, and the power of ten of its prefix.
fn look_up(name: &str) -> Option<(&'static Known, i32)> {
    if let Some(known) = UNITS.iter().find(|known| known.name == name) {
        return Some((known, 0));
    }
    let by_thousands = BY_THOUSANDS.split_inclusive(|_| true).zip((-10..=10).rev().map(|power| 3 * power));
    PREFIXES.into_iter().chain(by_thousands).find_map(|(prefix, exponent)| {
        let rest = name.strip_prefix(prefix)?;
        let known = UNITS.iter().find(|known| known.name == rest && known.prefixes)?;
        Some((known, exponent))
    })
}

/// The exponents of kg, m, s, A, K, mol and cd in a unit.
pub(super) fn exponents(name: &str) -> Option<[i8; 7]> {
    look_up(name).map(|(known, _)| known.exponents)
}

fn unknown(name: &str, span: Span) -> ModelError {
    let known = UNITS.iter().map(|known| known.name);
    // Prefixes are told apart by their case, and `n` may be short for anything.
    let same = of_other_case(name).map(|own| Meant { text: own.to_owned(), is_certain: name.len() > 1 });
    let written = || power(name).or_else(|| product(name)).map(Meant::certain);
    let near = || nearest(name, known).map(|own| Meant::guess(own.to_owned()));
    ModelError::UnknownUnit { name: name.to_owned(), span, nearest: same.or_else(written).or_else(near) }
}

/// `kg` for `Kg` and `KG`, `Hz` for `hz`: of the units that are often written so the only one.
fn of_other_case(name: &str) -> Option<&'static str> {
    let plain = UNITS.iter().map(|known| known.name).chain(["kg", "cm", "km"]);
    plain.filter(|own| own.eq_ignore_ascii_case(name)).only()
}

/// `s2`, as many programs write it, in the language: `s^2`.
fn power(name: &str) -> Option<String> {
    let base = name.trim_end_matches(|c: char| c.is_ascii_digit());
    let exponent = name.get(base.len()..).filter(|digits| !digits.is_empty())?;
    look_up(base).map(|_| format!("{base}^{exponent}"))
}

/// `Nm` in the language: `N*m`; what ends in s may be a plural.
fn product(name: &str) -> Option<String> {
    let parts = (1..name.len()).rev().filter_map(|at| Some((name.get(..at)?, name.get(at..)?)));
    let is_known = |name: &str| name != "s" && look_up(name).is_some();
    let mut known = parts.filter(|(left, right)| is_known(left) && is_known(right));
    known.next().map(|(left, right)| format!("{left}*{right}"))
}

/// The names in a unit, with their places and exponents.
pub(super) fn powers(file: &File, unit: UnitRef) -> Vec<(&str, Span, Number)> {
    let mut todo = vec![(unit, Number::ONE)];
    let mut names = Vec::new();
    while let Some((at, exponent)) = todo.pop() {
        match file.unit(at).kind {
            UnitKind::One => {}
            UnitKind::Name(name) => names.push((name, file.unit(at).span, exponent)),
            UnitKind::Product(factors) => {
                let signed = |under: bool| if under { exponent.neg() } else { exponent.clone() };
                todo.extend(factors.iter().rev().map(|(under, factor)| (*factor, signed(*under))));
            }
            UnitKind::Power { base, numerator, denominator } => {
                let own = Number::ratio(i64::from(numerator), i64::from(denominator));
                todo.extend(own.map(|own| (base, exponent.mul(&own))));
            }
        }
    }
    names
}

/// The exponents of kg, m, s, A, K, mol and cd in a whole unit; `None` where a name in it is not known.
pub(super) fn dimension(file: &File, unit: UnitRef) -> Option<[Number; 7]> {
    let mut sum = [0; 7].map(Number::from);
    for (name, _, exponent) in powers(file, unit) {
        for (sum, own) in sum.iter_mut().zip(exponents(name)?) {
            *sum = sum.add(&exponent.mul(&Number::from(i64::from(own))));
        }
    }
    Some(sum)
}

/// The factor by which a number in a unit becomes a number in SI: an expression without symbols.
pub(super) fn factor(pool: &mut Pool, file: &File, unit: UnitRef, errors: &mut Vec<ModelError>) -> ExprId {
    let mut product = pool.one();
    for (name, span, exponent) in powers(file, unit) {
        match named_factor(pool, name) {
            Some(factor) => {
                let factor = pool.powr(factor, &exponent);
                product = pool.mul(product, factor);
            }
            None => errors.push(unknown(name, span)),
        }
    }
    product
}
