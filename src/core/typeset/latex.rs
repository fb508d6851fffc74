//! Formulas as LaTeX, with what amsmath brings.

use super::block::sign;
use super::dialect::{Dialect, Lines};
use super::pieces::{Bracket, Breaker, Piece, Token};
use super::points::TERM;
use super::symbol::latex_word;
use super::{Formula, Symbol};

/// The width of a line in points, of `article` at 10 points with room for a number.
const LINE: f64 = 318.0;
/// How far lines that go on are indented.
const INDENT: f64 = 20.0;
/// The width of a letter of a remark.
const LETTER: f64 = 5.2;

const LATEX: Dialect = Dialect {
    number: ["", ""],
    scientific: ["", r" \cdot 10^{", "}"],
    minus: "-",
    letter: Symbol::latex_letter,
    word: latex_word,
    subscript: ["", "_{", "}"],
    power: ["", "^{", "}"],
    both: ["", "_{", "}^{", "}"],
    delta: [r"\delta ", ""],
    differential: [r"\,\mathrm{d}", ""],
    fraction: [r"\frac{", "}{", "}"],
    root: [r"\sqrt{", "}"],
    bars: [[r"\left\vert ", r" \right\vert"], [r"\left\Vert ", r" \right\Vert"]],
    brackets: [["(", ")"], [r"\left( ", r" \right)"]],
    matrix: [r"\begin{pmatrix} ", r" \end{pmatrix}"],
    entries: [r" \\ ", " & "],
    rate: [r"\frac{\mathrm{d}}{\mathrm{d}t} ", ""],
    limits: [([r"\sum_{", "}^{", "}"], [r"\sum_{", "}"]), ([r"\int_{", "}^{", "}"], [r"\int_{", "}"])],
    row: ["", ""],
    beside: " ",
    times: r" \cdot ",
    apart: r" \, ",
    cross: r" \times ",
    signs: ["-", " + ", " - "],
    commas: [",", ", ", r",\, "],
    space: " ",
    before_comma: false,
    e: r"\mathrm{e}",
    function: |name| match name {
        "atan2" | "rows" => format!(r"\operatorname{{{name}}}"),
        _ => format!(r"\{name}"),
    },
    applied: [" ", ""],
    sign: |sign| sign.forms()[0].to_owned(),
    verbatim: |text| format!(r"\texttt{{{}}}", text.replace('_', r"\_").replace('^', r"\textasciicircum{}")),
};

const LINES: Lines = Lines {
    around: ["\\begin{aligned}\n", "\n\\end{aligned}"],
    behind_left: " ",
    breaks: ["& ", " \\\\\n&\\quad {}"],
    factor: [r"\cdot ", r"\, "],
    token: write_token,
};

impl Formula {
    /// The formula in LaTeX's mathematical mode. Needs the package `amsmath` for matrices.
    #[must_use]
    pub fn latex(&self) -> String {
        self.written(&LATEX)
    }

    /// The formula for a line of its own, without `$` or `\[`: one that is too long for a line of the class `article` at 10 points
    /// is broken before relations and signs, in an `aligned` environment.
    #[must_use]
    pub fn latex_display(&self) -> String {
        self.displayed(&LATEX, &LINES)
    }

    /// The lines of a formula that is too long for one, behind what stands on the left of its relation if that is short.
    pub(super) fn broken(&self) -> Option<(Option<&Self>, Vec<Vec<Piece>>)> {
        if self.points() <= LINE {
            return None;
        }
        let parts = match self {
            Self::Relation(parts) => parts.as_slice(),
            other => std::slice::from_ref(other),
        };
        let (left, rest) = match parts {
            [left, Self::Sign(_), ..] if left.points() < LINE / 4.0 => (Some(left), parts.get(1..).unwrap_or_default()),
            parts => (None, parts),
        };
        let line = LINE - left.map_or(0.0, Self::points);
        let breaker = Breaker { line, measure: &points, has_root_signs: false };
        Some((left, breaker.lines(&Self::Relation(rest.to_vec()), INDENT)))
    }

    /// Whether the formula fits on a line of [`latex_display`](Self::latex_display), with so many letters beside it.
    #[must_use]
    pub fn fits_line(&self, letters: usize) -> bool {
        let beside = if letters == 0 { 0.0 } else { 20.0 + LETTER * letters as f64 };
        self.points() + beside <= LINE
    }

    /// About how many letters wide the formula is.
    pub(super) fn weight(&self) -> usize {
        let all = |parts: &[Self]| parts.iter().map(Self::weight).sum::<usize>();
        match self {
            Self::Number(digits) => digits.len(),
            Self::Scientific { digits, exponent } => digits.len() + exponent.len() + 2,
            Self::Symbol(symbol) | Self::Differential(symbol) => 1 + symbol.subscript.len(),
            Self::Indexed(inner, feet) => inner.weight() + feet.len(),
            Self::Product(factors) => all(factors),
            Self::Sum(terms) => terms.iter().map(|(_, term)| term.weight() + 2).sum(),
            Self::Fraction(above, below) => above.weight().max(below.weight()) + 1,
            Self::Power(base, exponent) => base.weight() + exponent.weight().div_ceil(2),
            Self::Root(inner) | Self::Bars { inner, .. } | Self::Parentheses(inner) => inner.weight() + 2,
            Self::Function { name, arguments, .. } => name.len() + all(arguments) + 1,
            Self::Matrix(rows) => rows.iter().map(|row| all(row) + 2 * row.len()).max().unwrap_or(0),
            Self::Between { sides, .. } => sides.0.weight() + sides.1.weight() + 2,
            Self::Rate(inner) => inner.weight() + 3,
            Self::Total { body, .. } => body.weight() + 4,
            Self::Relation(parts) => all(parts),
            Self::Sign(_) => 3,
            Self::Verbatim(text) => text.len(),
        }
    }

    /// Whether the formula is higher than a line, so that brackets have to grow.
    pub(super) fn is_tall(&self) -> bool {
        match self {
            Self::Number(_)
            | Self::Scientific { .. }
            | Self::Symbol(_)
            | Self::Differential(_)
            | Self::Sign(_)
            | Self::Verbatim(_) => false,
            Self::Fraction(..) | Self::Matrix(_) | Self::Rate(_) | Self::Total { .. } => true,
            Self::Product(parts) | Self::Relation(parts) => parts.iter().any(Self::is_tall),
            Self::Sum(terms) => terms.iter().any(|(_, term)| term.is_tall()),
            Self::Indexed(inner, _)
            | Self::Root(inner)
            | Self::Bars { inner, .. }
            | Self::Parentheses(inner)
            | Self::Power(inner, _) => inner.is_tall(),
            Self::Function { arguments, .. } => arguments.iter().any(Self::is_tall),
            Self::Between { sides, .. } => sides.0.is_tall() || sides.1.is_tall(),
        }
    }

    /// Whether the first sign of the formula is a digit.
    pub(super) fn begins_with_digit(&self) -> bool {
        match self {
            Self::Number(_) | Self::Scientific { .. } => true,
            Self::Power(base, _) => base.begins_with_digit(),
            Self::Product(factors) => factors.first().is_some_and(Self::begins_with_digit),
            _ => false,
        }
    }

    /// Whether one of two factors is a name of several letters and the other no number.
    pub(super) fn runs_into(&self, next: &Self) -> bool {
        let is_number = matches!(self, Self::Number(_) | Self::Scientific { .. } | Self::Fraction(..));
        !is_number && !next.begins_with_digit() && (self.is_word() || next.is_word())
    }

    /// Whether it is a name of several letters, or a power of one.
    fn is_word(&self) -> bool {
        match self {
            Self::Symbol(symbol) => symbol.is_word(),
            Self::Indexed(inner, _) | Self::Power(inner, _) => inner.is_word(),
            _ => false,
        }
    }

    /// Whether it ends with an argument without brackets.
    pub(super) fn is_open_function(&self) -> bool {
        matches!(self, Self::Function { arguments, .. } if stands_open(arguments))
    }
}

/// The width of a part of a line in points.
fn points(token: &Token) -> f64 {
    match token {
        Token::Whole(formula) | Token::Exponent(formula) => formula.points(),
        Token::Term { first: true, negative: false } => 0.0,
        Token::Term { .. } => TERM,
        Token::Relation(sign) => Formula::Sign(*sign).points(),
        Token::Open(_) | Token::Close(_) => 7.0,
        Token::Exp => 17.0,
        Token::Space => 1.7,
        Token::Comma => 4.5,
        Token::Over => 8.0,
    }
}

fn write_token(token: &Token, out: &mut String) {
    let bracket = |own: &Bracket, round| [round, r"\vert", r"\Vert"][*own as usize];
    match token {
        Token::Whole(formula) => out.push_str(&formula.latex()),
        Token::Term { first, negative } => out.push_str(sign(*first, *negative)),
        Token::Relation(sign) => {
            if !out.ends_with(' ') {
                out.push(' ');
            }
            out.push_str(&format!("{} ", sign.forms()[0]));
        }
        Token::Open(own) => out.push_str(&format!(r"\Bigl{} ", bracket(own, "("))),
        Token::Close(own) => out.push_str(&format!(r" \Bigr{}", bracket(own, ")"))),
        Token::Exponent(formula) => out.push_str(&format!("^{{{}}}", formula.latex())),
        Token::Exp => out.push_str(r"\exp "),
        Token::Space => out.push_str(r" \, "),
        Token::Comma => out.push_str(", "),
        Token::Over => out.push_str(r" \Big/ "),
    }
}

/// Whether a function's argument needs no brackets.
pub(super) fn stands_open(arguments: &[Formula]) -> bool {
    matches!(arguments, [Formula::Symbol(_) | Formula::Number(_)])
}
