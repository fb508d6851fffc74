//! Formulas as MathML, with the elements of MathML Core. Browsers have lines of any length.

use super::dialect::Dialect;
use super::symbol::unicode_word;
use super::{Formula, Symbol};

const MATHML: Dialect = Dialect {
    number: ["<mn>", "</mn>"],
    scientific: ["<mrow><mn>", "</mn><mo>·</mo><msup><mn>10</mn><mn>", "</mn></msup></mrow>"],
    minus: "−",
    letter,
    word: |word| {
        let tag = if word.bytes().all(|b| b.is_ascii_digit()) { "mn" } else { "mi" };
        format!("<{tag}>{}</{tag}>", unicode_word(word))
    },
    subscript: ["<msub>", "", "</msub>"],
    power: ["<msup>", "", "</msup>"],
    both: ["<msubsup>", "", "", "</msubsup>"],
    delta: ["<mrow><mi>δ</mi>", "</mrow>"],
    differential: ["<mrow><mtext>d</mtext>", "</mrow>"],
    fraction: ["<mfrac>", "", "</mfrac>"],
    root: ["<msqrt>", "</msqrt>"],
    bars: [["<mrow><mo>|</mo>", "<mo>|</mo></mrow>"], ["<mrow><mo>‖</mo>", "<mo>‖</mo></mrow>"]],
    brackets: [["<mo>(</mo>", "<mo>)</mo>"]; 2],
    matrix: ["<mrow><mo>(</mo><mtable><mtr><mtd>", "</mtd></mtr></mtable><mo>)</mo></mrow>"],
    entries: ["</mtd></mtr><mtr><mtd>", "</mtd><mtd>"],
    rate: ["<mrow><mfrac><mtext>d</mtext><mtext>dt</mtext></mfrac>", "</mrow>"],
    limits: [
        (["<munderover><mo>∑</mo>", "", "</munderover>"], ["<munder><mo>∑</mo>", "</munder>"]),
        (["<msubsup><mo>∫</mo>", "", "</msubsup>"], ["<msub><mo>∫</mo>", "</msub>"]),
    ],
    row: ["<mrow>", "</mrow>"],
    beside: "<mo>&#x2062;</mo>",
    times: "<mo>·</mo>",
    apart: "<mo>&#x2062;</mo><mspace width=\"0.17em\"/>",
    cross: "<mo>×</mo>",
    signs: ["<mo>−</mo>", "<mo>+</mo>", "<mo>−</mo>"],
    commas: ["<mo>,</mo>"; 3],
    space: "",
    before_comma: true,
    e: "<mi>e</mi>",
    // As operators they have spaces around them.
    function: |name| format!("<mo lspace=\"0.17em\" rspace=\"0.17em\">{name}</mo>"),
    applied: ["<mo>&#x2061;</mo>"; 2],
    sign: |sign| {
        let tag = if sign == super::Sign::If { "mtext" } else { "mo" };
        format!("<{tag}>{}</{tag}>", sign.forms()[2])
    },
    verbatim: |text| format!("<mtext>{}</mtext>", text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")),
};

impl Formula {
    /// The formula as an element `math`, displayed on a line of its own or within a line.
    #[must_use]
    pub fn mathml(&self, display: bool) -> String {
        let display = if display { " display=\"block\"" } else { "" };
        format!("<math{display}>{}</math>", self.written(&MATHML))
    }
}

fn letter(symbol: &Symbol) -> String {
    let letter = if symbol.plain { &symbol.letter } else { unicode_word(&symbol.letter) };
    let dot = match symbol.dots {
        0 => return format!("<mi>{letter}</mi>"),
        1 => "˙",
        2 => "¨",
        _ => "⃛",
    };
    format!("<mover accent=\"true\"><mi>{letter}</mi><mo>{dot}</mo></mover>")
}
