//! How wide a formula is in print: in points, in Computer Modern at 10 points, rather too wide than too narrow.

use super::symbol::latex_word;
use super::{Formula, Sign, Subscript, Symbol};

/// Widths of italic letters from `a` and from `A`, in hundredths of a point (cmmi10).
const SMALL: [u16; 26] = [
    529, 429, 433, 520, 466, 490, 477, 576, 345, 412, 521, 298, 878, 600, 485, 503, 446, 451, 469, 361, 572, 485, 716,
    572, 490, 465,
];
const CAPITAL: [u16; 26] = [
    750, 759, 715, 828, 738, 643, 786, 831, 439, 555, 849, 681, 970, 803, 763, 642, 791, 759, 613, 584, 683, 583, 945,
    828, 581, 683,
];

/// How large formulas are: displayed, beside it in the text, at a foot, at the foot of a foot.
const SIZES: [f64; 4] = [1.0, 1.0, 0.8, 0.7];
const DISPLAY: usize = 0;
const TEXT: usize = 1;
const FOOT: usize = 2;

/// A sign between terms, a relation, with the space on both sides.
pub(super) const TERM: f64 = 12.3;
pub(super) const RELATION: f64 = 13.4;
/// A bracket that grows.
const BRACKET: f64 = 8.0;

/// Words in the text.
pub(super) fn words(text: &str) -> f64 {
    let widths = text.chars().map(|c| match c {
        'm' | 'w' | 'M' | 'W' => 9.2,
        'i' | 'j' | 'l' | 't' | 'f' | ' ' | ',' | '.' => 3.6,
        c if c.is_uppercase() => 7.6,
        _ => 5.4,
    });
    widths.sum()
}

/// A word as [`latex_word`] writes it.
fn word(text: &str) -> f64 {
    if text.bytes().all(|b| b.is_ascii_digit()) {
        return 5.0 * text.len() as f64;
    }
    let written = latex_word(text);
    let width =
        |table: &[u16; 26], from: u8, c: u8| table.get(usize::from(c - from)).map(|own| f64::from(*own) / 100.0);
    match written.as_bytes() {
        [c @ b'a'..=b'z'] => width(&SMALL, b'a', *c).unwrap_or(9.0),
        [c @ b'A'..=b'Z'] => width(&CAPITAL, b'A', *c).unwrap_or(10.0),
        [b'\\', b'v' | b'a'..=b'z', ..] if !written.contains('{') => 6.6,
        [b'\\', ..] if !written.contains('{') => 8.4,
        _ => words(text),
    }
}

impl Formula {
    /// The width of the displayed formula in points.
    pub(super) fn points(&self) -> f64 {
        self.at(DISPLAY)
    }

    fn at(&self, level: usize) -> f64 {
        let size = SIZES.get(level).copied().unwrap_or(0.7);
        let smaller = (level + 1).min(3);
        let foot = smaller.max(FOOT);
        let bracket = |inner: &Self| 2.0 * size * if inner.is_tall() { BRACKET } else { 4.0 };
        let all = |parts: &[Self], level: usize| parts.iter().map(|part| part.at(level)).sum::<f64>();
        match self {
            Self::Number(digits) => 5.0 * size * digits.len() as f64,
            Self::Scientific { digits, exponent } => 5.0 * size * (digits.len() + 3 + exponent.len()) as f64,
            Self::Symbol(symbol) => symbol_points(symbol, size, foot),
            Self::Differential(symbol) => 7.3 * size + symbol_points(symbol, size, foot),
            Self::Indexed(inner, feet) => inner.at(level) + feet_points(feet, foot),
            Self::Product(factors) => {
                let joints = factors.iter().zip(factors.iter().skip(1)).map(|(one, next)| match () {
                    () if next.begins_with_digit() => 7.3,
                    () if one.is_open_function() || one.runs_into(next) => 1.7,
                    // Beside a function and what has brackets that grow.
                    () => 1.7 * f64::from(u8::from(one.is_tall() || matches!(next, Self::Function { .. }))),
                });
                all(factors, level) + size * joints.sum::<f64>()
            }
            Self::Sum(terms) => {
                let first = terms.first().is_some_and(|(negative, _)| !negative);
                let signs = terms.len() as f64 - f64::from(u8::from(first));
                terms.iter().map(|(_, term)| term.at(level)).sum::<f64>() + TERM * size * signs
            }
            Self::Fraction(above, below) => above.at(smaller).max(below.at(smaller)) + 2.6,
            Self::Power(base, exponent) => base.at(level) + exponent.at(foot) + 0.6,
            Self::Root(inner) => inner.at(level) + 10.1 * size,
            Self::Function { name, power, arguments } => {
                let power = power.as_ref().map_or(0.0, |power| power.at(foot) + 0.6);
                let commas = 4.5 * size * arguments.len().saturating_sub(1) as f64;
                let brackets: f64 = match arguments.as_slice() {
                    [] => 0.0,
                    [Self::Symbol(_) | Self::Number(_)] => 1.7,
                    [one] => bracket(one),
                    several => several.iter().map(bracket).fold(0.0, f64::max),
                };
                size * words(name) + power + all(arguments, level) + commas + brackets
            }
            Self::Bars { inner, .. } | Self::Parentheses(inner) => inner.at(level) + bracket(inner) + 1.7 * size,
            Self::Matrix(rows) => {
                let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
                let widest = |column: usize| {
                    let cells = rows.iter().filter_map(|row| row.get(column));
                    cells.map(|cell| cell.at(level.max(TEXT))).fold(0.0, f64::max)
                };
                (0..columns).map(widest).sum::<f64>() + 10.0 * columns as f64 + 9.0
            }
            Self::Between { sides, .. } => sides.0.at(level) + sides.1.at(level) + TERM * size,
            Self::Rate(inner) => 16.0 * size + inner.at(level),
            Self::Total { integral, below, above, body } => {
                let own = all(below, foot) + 4.0 * below.len().saturating_sub(1) as f64;
                let above = above.as_ref().map_or(0.0, |above| above.at(foot));
                let sign = 15.0 * size;
                let limits =
                    if *integral || level > DISPLAY { sign + own.max(above) } else { sign.max(own).max(above) };
                limits + 2.0 + body.at(level)
            }
            Self::Relation(parts) => all(parts, level),
            Self::Sign(sign) => {
                size * match sign {
                    Sign::Comma => 7.3,
                    Sign::If => 22.0,
                    _ => RELATION,
                }
            }
            Self::Verbatim(text) => 5.3 * text.chars().count() as f64,
        }
    }
}

fn symbol_points(symbol: &Symbol, size: f64, foot: usize) -> f64 {
    let dots = if symbol.dots > 3 { 12.0 } else { 0.0 };
    let delta = if symbol.delta { 4.6 } else { 0.0 };
    size * (word(&symbol.letter) + dots + delta) + feet_points(&symbol.subscript, foot)
}

fn feet_points(feet: &[Subscript], foot: usize) -> f64 {
    let size = SIZES.get(foot).copied().unwrap_or(0.7);
    let widths = feet.iter().map(|own| match own {
        Subscript::Word(text) => size * word(text),
        Subscript::Index(formula) => formula.at(foot),
        Subscript::Coordinate(symbol) => symbol_points(symbol, size, (foot + 1).min(3)),
    });
    let commas = 2.8 * size * feet.len().saturating_sub(1) as f64;
    if feet.is_empty() { 0.0 } else { widths.sum::<f64>() + commas + 0.6 }
}
