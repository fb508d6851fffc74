//! Formulas in Typst's mathematical mode.

use super::block::sign;
use super::dialect::{Dialect, Lines};
use super::pieces::{Bracket, Token};
use super::symbol::unicode_word;
use super::{Formula, Symbol};

const TYPST: Dialect = Dialect {
    number: ["", ""],
    scientific: ["", " dot.op 10^(", ")"],
    minus: "-",
    letter,
    word: |text| word(unicode_word(text)),
    subscript: ["", "_(", ")"],
    power: ["", "^(", ")"],
    both: ["", "_(", ")^(", ")"],
    delta: ["δ ", ""],
    differential: ["thin upright(d) ", ""],
    fraction: ["frac(", ", ", ")"],
    root: ["sqrt(", ")"],
    bars: [["abs(", ")"], ["norm(", ")"]],
    brackets: [["(", ")"]; 2],
    matrix: ["mat(", ")"],
    entries: ["; ", ", "],
    rate: ["frac(upright(d), upright(d) t) ", ""],
    limits: [(["sum_(", ")^(", ")"], ["sum_(", ")"]), (["integral_(", ")^(", ")"], ["integral_(", ")"])],
    row: ["", ""],
    beside: " ",
    times: " dot.op ",
    apart: " thin ",
    cross: " times ",
    signs: ["-", " + ", " - "],
    commas: [",", ", ", ", "],
    space: " ",
    before_comma: true,
    e: "upright(e)",
    function: |name| match name {
        "atan2" | "rows" => format!("op(\"{name}\")"),
        name => name.to_owned(),
    },
    applied: [" ", " "],
    sign: |sign| sign.forms()[1].to_owned(),
    verbatim: |text| format!("\"{}\"", text.replace(['"', '\\'], "")),
};

const LINES: Lines = Lines {
    around: ["", ""],
    behind_left: "",
    breaks: [" & ", " \\\n& quad \"\""],
    factor: ["dot.op ", " "],
    token: |token, out| out.push_str(&token_text(token)),
};

impl Formula {
    /// The formula in Typst, without `$`.
    #[must_use]
    pub fn typst(&self) -> String {
        self.written(&TYPST)
    }

    /// The formula for lines of its own, broken as [`latex_display`](Self::latex_display) breaks them.
    #[must_use]
    pub fn typst_display(&self) -> String {
        self.displayed(&TYPST, &LINES)
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
        Token::Relation(own) => format!(" {} ", own.forms()[1]),
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

fn letter(symbol: &Symbol) -> String {
    let letter = word(if symbol.plain { &symbol.letter } else { unicode_word(&symbol.letter) });
    match symbol.dots {
        0 => letter,
        1 => format!("dot({letter})"),
        2 => format!("dot.double({letter})"),
        _ => format!("dot.triple({letter})"),
    }
}
