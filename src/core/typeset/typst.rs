//! Formulas in Typst's mathematical mode.

use super::block::sign;
use super::latex::stands_open;
use super::pieces::{Bracket, Token};
use super::symbol::{Subscript, unicode_word};
use super::{Formula, Sign, Symbol};

impl Formula {
    /// The formula in Typst, without `$`.
    #[must_use]
    pub fn typst(&self) -> String {
        match self {
            Self::Number(digits) => digits.clone(),
            Self::Scientific { digits, exponent } => format!("{digits} dot.op 10^({exponent})"),
            Self::Symbol(symbol) => symbol_text(symbol),
            Self::Indexed(inner, feet) => format!("{}{}", inner.typst(), feet_text(feet)),
            Self::Product(factors) => {
                let mut out = String::new();
                for (at, factor) in factors.iter().enumerate() {
                    if at > 0 {
                        out.push_str(if factor.begins_with_digit() { " dot.op " } else { " " });
                    }
                    out.push_str(&factor.typst());
                }
                out
            }
            Self::Sum(terms) => {
                let mut out = String::new();
                for (at, (negative, term)) in terms.iter().enumerate() {
                    out.push_str(sign(at == 0, *negative));
                    out.push_str(&term.typst());
                }
                out
            }
            Self::Fraction(above, below) => format!("frac({}, {})", above.typst(), below.typst()),
            Self::Power(base, exponent) => format!("{}^({})", base.typst(), exponent.typst()),
            Self::Root(inner) => format!("sqrt({})", inner.typst()),
            Self::Function { name, power, arguments } => {
                let name = match *name {
                    "exp" if arguments.is_empty() => "upright(e)".to_owned(),
                    "atan2" | "rows" => format!("op(\"{name}\")"),
                    name => name.to_owned(),
                };
                let power = power.as_ref().map_or(String::new(), |power| format!("^({})", power.typst()));
                let inner: Vec<String> = arguments.iter().map(Self::typst).collect();
                match inner.as_slice() {
                    [] => format!("{name}{power}"),
                    [one] if stands_open(arguments) => format!("{name}{power} {one}"),
                    several => format!("{name}{power} ({})", several.join(", ")),
                }
            }
            Self::Bars { double, inner } => {
                format!("{}({})", if *double { "norm" } else { "abs" }, inner.typst())
            }
            Self::Parentheses(inner) => format!("({})", inner.typst()),
            Self::Matrix(rows) => {
                let rows = rows.iter().map(|row| row.iter().map(Self::typst).collect::<Vec<_>>().join(", "));
                format!("mat({})", rows.collect::<Vec<_>>().join("; "))
            }
            Self::Between { cross, sides } => {
                format!("{} {} {}", sides.0.typst(), if *cross { "times" } else { "dot.op" }, sides.1.typst())
            }
            Self::Rate(inner) => format!("frac(upright(d), upright(d) t) {}", inner.typst()),
            Self::Total { integral, below, above, body } => {
                let name = if *integral { "integral" } else { "sum" };
                let below: Vec<String> = below.iter().map(Self::typst).collect();
                let above = above.as_ref().map_or(String::new(), |above| format!("^({})", above.typst()));
                format!("{name}_({}){above} {}", below.join(", "), body.typst())
            }
            Self::Differential(symbol) => format!("thin upright(d) {}", symbol_text(symbol)),
            Self::Relation(parts) => parts.iter().map(Self::typst).collect::<Vec<_>>().join(" "),
            Self::Verbatim(text) => format!("\"{}\"", text.replace(['"', '\\'], "")),
            Self::Sign(sign) => match sign {
                Sign::Equal => "=",
                Sign::NotEqual => "!=",
                Sign::Less => "<",
                Sign::LessEqual => "<=",
                Sign::Greater => ">",
                Sign::GreaterEqual => ">=",
                Sign::In => "in",
                Sign::Comma => ",",
                Sign::Not => "not",
                Sign::And => "and",
                Sign::Or => "or",
                Sign::If => "quad \"if\"",
            }
            .to_owned(),
        }
    }

    /// The formula for lines of its own, broken as [`latex_display`](Self::latex_display) breaks them.
    #[must_use]
    pub fn typst_display(&self) -> String {
        let Some((left, lines)) = self.broken() else {
            return self.typst();
        };
        let mut out = left.map_or(String::new(), |left| left.typst());
        for (at, pieces) in lines.iter().enumerate() {
            out.push_str(if at == 0 { " & " } else { " \\\n& quad " });
            for (place, piece) in pieces.iter().enumerate() {
                if piece.is_factor {
                    out.push_str(if place == 0 { "dot.op " } else { " " });
                }
                piece.tokens.iter().for_each(|token| out.push_str(&token_text(token)));
            }
        }
        out
    }
}

fn token_text(token: &Token) -> String {
    let bracket = |own: &Bracket, side: &str| match own {
        Bracket::Round => format!(" paren.{side} "),
        Bracket::Bars => " bar.v ".to_owned(),
        Bracket::DoubleBars => " bar.v.double ".to_owned(),
    };
    match token {
        Token::Whole(formula) => formula.typst(),
        Token::Term { first, negative } => sign(*first, *negative).to_owned(),
        Token::Relation(own) => format!(" {} ", Formula::Sign(*own).typst()),
        Token::Open(own) => bracket(own, "l"),
        Token::Close(own) => bracket(own, "r"),
        Token::Exponent(formula) => format!("zws^({})", formula.typst()),
        Token::Exp => "exp".to_owned(),
        Token::Space => " ".to_owned(),
        Token::Comma => ", ".to_owned(),
        Token::Over => " \\/ ".to_owned(),
    }
}

/// A letter, or a word in quotation marks.
fn word(text: &str) -> String {
    let plain = text.chars().count() == 1 || text.bytes().all(|b| b.is_ascii_digit());
    if plain { text.to_owned() } else { format!("\"{text}\"") }
}

fn symbol_text(symbol: &Symbol) -> String {
    let letter = word(if symbol.plain { &symbol.letter } else { unicode_word(&symbol.letter) });
    let letter = match symbol.dots {
        0 => letter,
        1 => format!("dot({letter})"),
        2 => format!("dot.double({letter})"),
        _ => format!("dot.triple({letter})"),
    };
    let delta = if symbol.delta { "δ " } else { "" };
    format!("{delta}{letter}{}", feet_text(&symbol.subscript))
}

fn feet_text(feet: &[Subscript]) -> String {
    let texts = feet.iter().map(|foot| match foot {
        Subscript::Word(text) => word(unicode_word(text)),
        Subscript::Index(formula) => formula.typst(),
        Subscript::Coordinate(symbol) => symbol_text(symbol),
    });
    let texts = texts.collect::<Vec<_>>().join(",");
    if texts.is_empty() { texts } else { format!("_({texts})") }
}
