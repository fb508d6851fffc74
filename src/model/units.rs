//! Units: names, prefixes, and the factors that lead to SI.
//!
//! Only conversion: what the dimensions say about the energies is not checked here.

use super::ModelError;
use crate::diagnostic::nearest;
use crate::expr::{ExprId, Pool};
use crate::number::Number;
use crate::span::Span;
use crate::syntax::{File, UnitKind, UnitRef};

/// A unit: its SI factor as a decimal literal, a power of pi in it, and whether it takes prefixes.
struct Known {
    name: &'static str,
    factor: &'static str,
    /// The factor is to be multiplied by pi.
    pi: bool,
    prefixes: bool,
}

const fn unit(name: &'static str, factor: &'static str, prefixes: bool) -> Known {
    Known {
        name,
        factor,
        pi: false,
        prefixes,
    }
}

/// SI base and derived units (the SI Brochure, 9th edition), those accepted beside them, and
/// atomic ones with CODATA 2022 values.
const UNITS: &[Known] = &[
    unit("m", "1", true),
    unit("g", "1e-3", true),
    unit("s", "1", true),
    unit("A", "1", true),
    unit("K", "1", true),
    unit("mol", "1", true),
    unit("cd", "1", true),
    unit("rad", "1", true),
    unit("sr", "1", true),
    unit("Hz", "1", true),
    unit("N", "1", true),
    unit("Pa", "1", true),
    unit("J", "1", true),
    unit("W", "1", true),
    unit("C", "1", true),
    unit("V", "1", true),
    unit("F", "1", true),
    unit("ohm", "1", true),
    unit("Ω", "1", true),
    unit("S", "1", true),
    unit("Wb", "1", true),
    unit("T", "1", true),
    unit("H", "1", true),
    unit("L", "1e-3", true),
    unit("l", "1e-3", true),
    unit("min", "60", false),
    unit("h", "3600", false),
    unit("d", "86400", false),
    unit("angstrom", "1e-10", false),
    unit("u", "1.66053906892e-27", false),
    unit("eV", "1.602176634e-19", true),
    Known {
        name: "deg",
        factor: "1",
        pi: true,
        prefixes: false,
    },
];

const PREFIXES: &[(&str, i32)] = &[
    ("da", 1),
    ("Q", 30),
    ("R", 27),
    ("Y", 24),
    ("Z", 21),
    ("E", 18),
    ("P", 15),
    ("T", 12),
    ("G", 9),
    ("M", 6),
    ("k", 3),
    ("h", 2),
    ("d", -1),
    ("c", -2),
    ("m", -3),
    ("u", -6),
    ("µ", -6),
    ("μ", -6),
    ("n", -9),
    ("p", -12),
    ("f", -15),
    ("a", -18),
    ("z", -21),
    ("y", -24),
    ("r", -27),
    ("q", -30),
];

fn named_factor(pool: &mut Pool, name: &str) -> Option<ExprId> {
    let value = |pool: &mut Pool, known: &Known, exponent: i32| {
        let factor = Number::parse(known.factor)?;
        let ten = Number::from(10).powi(exponent)?;
        let number = factor.mul(&ten);
        if !known.pi {
            return Some(pool.number(number));
        }
        // deg = pi/180
        let degree = number.div(&Number::from(180))?;
        let pi = pool.pi();
        Some(pool.scale(pi, &degree))
    };
    if let Some(known) = UNITS.iter().find(|known| known.name == name) {
        return value(pool, known, 0);
    }
    PREFIXES.iter().find_map(|(prefix, exponent)| {
        let rest = name.strip_prefix(prefix)?;
        let known = UNITS
            .iter()
            .find(|known| known.name == rest && known.prefixes)?;
        value(pool, known, *exponent)
    })
}

fn unknown(name: &str, span: Span) -> ModelError {
    ModelError::UnknownUnit {
        name: name.to_owned(),
        span,
        nearest: nearest(name, UNITS.iter().map(|known| known.name)).map(str::to_owned),
    }
}

/// The factor by which a number in a unit becomes a number in SI: an expression without symbols.
pub(super) fn factor(
    pool: &mut Pool,
    file: &File,
    unit: UnitRef,
    errors: &mut Vec<ModelError>,
) -> ExprId {
    // Children stand before parents: one pass over the arena up to the wanted unit, but only over
    // what belongs to it.
    enum Task {
        Visit(UnitRef),
        Power(i32, i32),
        Product(Vec<bool>),
    }
    let mut tasks = vec![Task::Visit(unit)];
    let mut done: Vec<ExprId> = Vec::new();
    while let Some(task) = tasks.pop() {
        match task {
            Task::Visit(at) => match &file.unit(at).kind {
                UnitKind::One => done.push(pool.one()),
                UnitKind::Name(name) => {
                    let found = named_factor(pool, name);
                    if found.is_none() {
                        errors.push(unknown(name, file.unit(at).span));
                    }
                    done.push(found.unwrap_or_else(|| pool.one()));
                }
                UnitKind::Product(factors) => {
                    tasks.push(Task::Product(
                        factors.iter().map(|(under, _)| *under).collect(),
                    ));
                    tasks.extend(factors.iter().rev().map(|(_, factor)| Task::Visit(*factor)));
                }
                UnitKind::Power {
                    base,
                    numerator,
                    denominator,
                } => {
                    tasks.push(Task::Power(*numerator, *denominator));
                    tasks.push(Task::Visit(*base));
                }
            },
            Task::Power(numerator, denominator) => {
                let exponent = Number::ratio(i64::from(numerator), i64::from(denominator));
                let base = done.pop().unwrap_or_else(|| pool.one());
                let exponent = exponent.unwrap_or_else(|| Number::from(1));
                done.push(pool.powr(base, &exponent));
            }
            Task::Product(under) => {
                let factors = done.split_off(done.len().saturating_sub(under.len()));
                let mut product = pool.one();
                for (factor, under) in factors.into_iter().zip(under) {
                    product = if under {
                        pool.div(product, factor)
                    } else {
                        pool.mul(product, factor)
                    };
                }
                done.push(product);
            }
        }
    }
    done.pop().unwrap_or_else(|| pool.one())
}
