//! Formulas as LaTeX, with what amsmath brings.

use super::block::sign;
use super::pieces::{Bracket, Breaker, Piece, Token};
use super::points::TERM;
use super::symbol::{Subscript, latex_word};
use super::{Formula, Sign, Symbol};

/// The width of a line in points, of `article` at 10 points with room for a number.
const LINE: f64 = 318.0;
/// How far lines that go on are indented.
const INDENT: f64 = 20.0;
/// The width of a letter of a remark.
const LETTER: f64 = 5.2;

impl Formula {
    /// The formula in LaTeX's mathematical mode. Needs the package `amsmath` for matrices.
    #[must_use]
    pub fn latex(&self) -> String {
        let mut out = String::new();
        self.write(&mut out);
        out
    }

    /// The formula for a line of its own, without `$` or `\[`: one that is too long for a line of the class `article` at 10 points
    /// is broken before relations and signs, in an `aligned` environment.
    #[must_use]
    pub fn latex_display(&self) -> String {
        let Some((left, lines)) = self.broken() else {
            return self.latex();
        };
        let left = left.map_or(String::new(), |left| left.latex() + " ");
        let mut out = format!("\\begin{{aligned}}\n{left}");
        for (at, pieces) in lines.iter().enumerate() {
            out.push_str(if at == 0 { "& " } else { " \\\\\n&\\quad {}" });
            for (place, piece) in pieces.iter().enumerate() {
                if piece.is_factor {
                    out.push_str(if place == 0 { r"\cdot " } else { r"\, " });
                }
                piece.tokens.iter().for_each(|token| write_token(token, &mut out));
            }
        }
        out.push_str("\n\\end{aligned}");
        out
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
        let breaker = Breaker { line, measure: &points };
        Some((left, breaker.lines(&Self::Relation(rest.to_vec()), INDENT)))
    }

    /// Whether the formula fits on a line of [`latex_display`](Self::latex_display), with so many letters beside it.
    #[must_use]
    pub fn fits_line(&self, letters: usize) -> bool {
        let beside = if letters == 0 { 0.0 } else { 20.0 + LETTER * letters as f64 };
        self.points() + beside <= LINE
    }

    fn write(&self, out: &mut String) {
        match self {
            Self::Number(digits) => out.push_str(digits),
            Self::Scientific { digits, exponent } => {
                out.push_str(&format!(r"{digits} \cdot 10^{{{exponent}}}"));
            }
            Self::Symbol(symbol) => write_symbol(symbol, out),
            Self::Indexed(inner, feet) => {
                inner.write(out);
                write_feet(feet, out);
            }
            Self::Product(factors) => write_product(factors, out),
            Self::Sum(terms) => {
                for (at, (negative, term)) in terms.iter().enumerate() {
                    out.push_str(sign(at == 0, *negative));
                    term.write(out);
                }
            }
            Self::Fraction(above, below) => {
                out.push_str(r"\frac{");
                above.write(out);
                out.push_str("}{");
                below.write(out);
                out.push('}');
            }
            Self::Power(base, exponent) => {
                base.write(out);
                out.push_str("^{");
                exponent.write(out);
                out.push('}');
            }
            Self::Root(inner) => {
                out.push_str(r"\sqrt{");
                inner.write(out);
                out.push('}');
            }
            Self::Function { name, power, arguments } => write_function(name, power.as_deref(), arguments, out),
            Self::Bars { double, inner } => {
                let bar = if *double { r"\Vert" } else { r"\vert" };
                out.push_str(&format!(r"\left{bar} "));
                inner.write(out);
                out.push_str(&format!(r" \right{bar}"));
            }
            Self::Parentheses(inner) => write_parentheses(inner, out),
            Self::Matrix(rows) => write_matrix(rows, out),
            Self::Between { cross, sides } => {
                sides.0.write(out);
                out.push_str(if *cross { r" \times " } else { r" \cdot " });
                sides.1.write(out);
            }
            Self::Rate(inner) => {
                out.push_str(r"\frac{\mathrm{d}}{\mathrm{d}t} ");
                inner.write(out);
            }
            Self::Total { integral, below, above, body } => {
                out.push_str(if *integral { r"\int_{" } else { r"\sum_{" });
                for (at, line) in below.iter().enumerate() {
                    if at > 0 {
                        out.push_str(r",\, ");
                    }
                    line.write(out);
                }
                out.push('}');
                if let Some(above) = above {
                    out.push_str("^{");
                    above.write(out);
                    out.push('}');
                }
                out.push(' ');
                body.write(out);
            }
            Self::Differential(symbol) => {
                out.push_str(r"\,\mathrm{d}");
                write_symbol(symbol, out);
            }
            Self::Relation(parts) => row(parts, out),
            Self::Verbatim(text) => {
                let text = text.replace('_', r"\_").replace('^', r"\textasciicircum{}");
                out.push_str(&format!(r"\texttt{{{text}}}"));
            }
            Self::Sign(sign) => out.push_str(match sign {
                Sign::Equal => "=",
                Sign::NotEqual => r"\neq",
                Sign::Less => "<",
                Sign::LessEqual => r"\leq",
                Sign::Greater => ">",
                Sign::GreaterEqual => r"\geq",
                Sign::In => r"\in",
                Sign::Comma => r",\;",
                Sign::Not => r"\neg",
                Sign::And => r"\land",
                Sign::Or => r"\lor",
                Sign::If => r"\quad \text{if}",
            }),
        }
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

    /// Whether it ends with an argument without brackets.
    pub(super) fn is_open_function(&self) -> bool {
        matches!(self, Self::Function { arguments, .. } if stands_open(arguments))
    }
}

/// The width of a part of a line in points.
fn points(token: &Token) -> f64 {
    match token {
        Token::Whole(formula) => formula.points(),
        Token::Term { first: true, negative: false } => 0.0,
        Token::Term { .. } => TERM,
        Token::Relation(sign) => Formula::Sign(*sign).points(),
        Token::Open(_) | Token::Close(_) => 7.0,
        Token::Exponent(formula) => formula.points(),
        Token::Exp => 17.0,
        Token::Space => 1.7,
        Token::Comma => 4.5,
        Token::Over => 8.0,
    }
}

fn write_token(token: &Token, out: &mut String) {
    let bracket = |own: &Bracket, round| match own {
        Bracket::Round => round,
        Bracket::Bars => r"\vert",
        Bracket::DoubleBars => r"\Vert",
    };
    match token {
        Token::Whole(formula) => formula.write(out),
        Token::Term { first, negative } => out.push_str(sign(*first, *negative)),
        Token::Relation(sign) => {
            if !out.ends_with(' ') {
                out.push(' ');
            }
            Formula::Sign(*sign).write(out);
            out.push(' ');
        }
        Token::Open(own) => out.push_str(&format!(r"\Bigl{} ", bracket(own, "("))),
        Token::Close(own) => out.push_str(&format!(r" \Bigr{}", bracket(own, ")"))),
        Token::Exponent(formula) => {
            out.push_str("^{");
            formula.write(out);
            out.push('}');
        }
        Token::Exp => out.push_str(r"\exp "),
        Token::Space => out.push_str(r" \, "),
        Token::Comma => out.push_str(", "),
        Token::Over => out.push_str(r" \Big/ "),
    }
}

/// Parts one after another, with spaces.
fn row(parts: &[Formula], out: &mut String) {
    for (at, part) in parts.iter().enumerate() {
        if at > 0 && !matches!(part, Formula::Sign(Sign::Comma)) {
            out.push(' ');
        }
        part.write(out);
    }
}

fn write_matrix(rows: &[Vec<Formula>], out: &mut String) {
    out.push_str(r"\begin{pmatrix}");
    for (at, entries) in rows.iter().enumerate() {
        out.push_str(if at == 0 { " " } else { r" \\ " });
        for (column, entry) in entries.iter().enumerate() {
            if column > 0 {
                out.push_str(" & ");
            }
            entry.write(out);
        }
    }
    out.push_str(r" \end{pmatrix}");
}

fn write_product(factors: &[Formula], out: &mut String) {
    let mut before: Option<&Formula> = None;
    for factor in factors {
        match before {
            None => {}
            Some(last) if last.is_open_function() => out.push_str(r" \, "),
            // A digit would run on.
            Some(_) if factor.begins_with_digit() => out.push_str(r" \cdot "),
            Some(_) => out.push(' '),
        }
        factor.write(out);
        before = Some(factor);
    }
}

/// Whether a function's argument needs no brackets.
pub(super) fn stands_open(arguments: &[Formula]) -> bool {
    matches!(arguments, [Formula::Symbol(_) | Formula::Number(_)])
}

fn write_function(name: &str, power: Option<&Formula>, arguments: &[Formula], out: &mut String) {
    match name {
        "exp" if arguments.is_empty() => out.push_str(r"\mathrm{e}"),
        "atan2" | "rows" => out.push_str(&format!(r"\operatorname{{{name}}}")),
        _ => out.push_str(&format!(r"\{name}")),
    }
    if let Some(power) = power {
        out.push_str("^{");
        power.write(out);
        out.push('}');
    }
    match arguments {
        [] => {}
        [argument] if stands_open(arguments) => {
            out.push(' ');
            argument.write(out);
        }
        [argument] => write_parentheses(argument, out),
        several => {
            out.push('(');
            for (at, argument) in several.iter().enumerate() {
                if at > 0 {
                    out.push_str(", ");
                }
                argument.write(out);
            }
            out.push(')');
        }
    }
}

fn write_parentheses(inner: &Formula, out: &mut String) {
    let (open, close) = if inner.is_tall() { (r"\left( ", r" \right)") } else { ("(", ")") };
    out.push_str(open);
    inner.write(out);
    out.push_str(close);
}

fn write_symbol(symbol: &Symbol, out: &mut String) {
    out.push_str(&symbol.latex_letter());
    write_feet(&symbol.subscript, out);
}

fn write_feet(feet: &[Subscript], out: &mut String) {
    if feet.is_empty() {
        return;
    }
    out.push_str("_{");
    for (at, foot) in feet.iter().enumerate() {
        if at > 0 {
            out.push(',');
        }
        match foot {
            Subscript::Word(word) => out.push_str(&latex_word(word)),
            Subscript::Index(formula) => formula.write(out),
            Subscript::Coordinate(symbol) => write_symbol(symbol, out),
        }
    }
    out.push('}');
}
