//! Formulas as LaTeX, with what amsmath brings.

use super::symbol::{Subscript, latex_word};
use super::{Formula, Sign, Symbol};

/// About how many letters wide a line of a page is.
const LINE: usize = 64;

impl Formula {
    /// The formula in LaTeX's mathematical mode. Needs the package `amsmath` for matrices.
    #[must_use]
    pub fn latex(&self) -> String {
        let mut out = String::new();
        self.write(&mut out);
        out
    }

    /// The formula for a line of its own, without `$` or `\[`: one that is too long for a line is broken before
    /// the signs of its outermost sum, in an `aligned` environment.
    #[must_use]
    pub fn latex_display(&self) -> String {
        if self.weight() <= LINE {
            return self.latex();
        }
        let (head, body) = match self {
            Self::Relation(parts) => match parts.as_slice() {
                [left, sign @ Self::Sign(_), right @ ..] => (format!("{} &{} ", left.latex(), sign.latex()), right),
                _ => return self.latex(),
            },
            _ => ("& ".to_owned(), std::slice::from_ref(self)),
        };
        let mut pieces = Vec::new();
        for (at, part) in body.iter().enumerate() {
            let first = pieces.len();
            part.pieces(&mut pieces);
            if at > 0
                && let Some(piece) = pieces.get_mut(first)
            {
                piece.text.insert(0, ' ');
            }
        }
        let mut out = format!("\\begin{{aligned}}\n{head}");
        let mut used = head.len() / 4;
        for (at, piece) in pieces.iter().enumerate() {
            if at > 0 && used + piece.weight > LINE {
                out.push_str(" \\\\\n&\\quad {}");
                used = 0;
            }
            used += piece.weight;
            out.push_str(&piece.text);
        }
        out.push_str("\n\\end{aligned}");
        out
    }

    /// What a line may be broken between: the terms of the outermost sum, and those in brackets at the end of a
    /// term that is longer than half a line.
    fn pieces(&self, out: &mut Vec<Piece>) {
        match self {
            Self::Sum(terms) => {
                for (at, (negative, term)) in terms.iter().enumerate() {
                    let first = out.len();
                    term.pieces(out);
                    let mut text = String::new();
                    write_sign(at == 0, *negative, &mut text);
                    if let Some(piece) = out.get_mut(first) {
                        piece.text.insert_str(0, &text);
                        piece.weight += 2;
                    }
                }
            }
            _ if self.weight() > LINE / 2 => match self.with_sum_last().as_deref() {
                Some([before @ .., Self::Parentheses(inner)]) => {
                    let first = out.len();
                    inner.pieces(out);
                    let mut text = String::new();
                    write_product(before, &mut text);
                    if let Some(piece) = out.get_mut(first) {
                        piece.text.insert_str(0, &format!(r"{text} \Bigl( "));
                        piece.weight += before.iter().map(Self::weight).sum::<usize>() + 1;
                    }
                    if let Some(piece) = out.last_mut() {
                        piece.text.push_str(r" \Bigr)");
                        piece.weight += 1;
                    }
                }
                _ => out.push(Piece::of(self)),
            },
            _ => out.push(Piece::of(self)),
        }
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
                    write_sign(at == 0, *negative, out);
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

/// What stays on one line.
struct Piece {
    text: String,
    weight: usize,
}

impl Piece {
    fn of(formula: &Formula) -> Self {
        Self { text: formula.latex(), weight: formula.weight() }
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

fn write_sign(first: bool, negative: bool, out: &mut String) {
    out.push_str(match (first, negative) {
        (true, false) => "",
        (true, true) => "-",
        (false, false) => " + ",
        (false, true) => " - ",
    });
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
