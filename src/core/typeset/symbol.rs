//! Names of the model language as symbols: `theta_0` as a letter with a subscript.

use std::collections::{BTreeMap, BTreeSet};

use super::block::symbol_text;
use crate::order::Gather;
use crate::syntax::GREEK;

/// A letter with its subscript, its dots and a prefix.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Symbol {
    /// A letter, the name of a Greek one, or a word.
    pub letter: String,
    /// What stands at the foot, comma by comma.
    pub subscript: Vec<Subscript>,
    /// How many time derivatives: dots.
    pub dots: u32,
    /// Whether a delta stands before it: a displacement.
    pub delta: bool,
    /// Whether the letters are printed as they are, though they name a Greek one.
    pub plain: bool,
}

/// A part of a subscript.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Subscript {
    /// Part of a name: digits, a letter, a word.
    Word(String),
    /// The index of a member of a family, as LaTeX and as text.
    Index(super::Formula),
    /// The coordinate that a momentum belongs to.
    Coordinate(Symbol),
}

/// Names that are short for those of Greek letters.
const SHORT: &[(&str, &str)] = &[
    ("al", "alpha"),
    ("be", "beta"),
    ("ga", "gamma"),
    ("de", "delta"),
    ("ep", "epsilon"),
    ("eps", "epsilon"),
    ("th", "theta"),
    ("la", "lambda"),
    ("ph", "phi"),
    ("ps", "psi"),
    ("om", "omega"),
    ("Th", "Theta"),
    ("La", "Lambda"),
    ("Ph", "Phi"),
    ("Ps", "Psi"),
    ("Om", "Omega"),
];

/// Words of the language that are no names, beside a name `L` or `F`.
const SCRIPT: &[(&str, &str, &str)] = &[("lagrangian", r"\mathcal{L}", "ℒ"), ("dissipation", r"\mathcal{F}", "ℱ")];

/// The Greek letter that letters are short for.
fn in_full(letters: &str) -> Option<&'static str> {
    SHORT.iter().find(|(short, _)| *short == letters).map(|(_, name)| *name)
}

/// By its name or as the letter itself.
fn greek(name: &str) -> Option<(&'static str, &'static str)> {
    // The sign for micro is the letter mu.
    let name = if name == "\u{b5}" { "mu" } else { name };
    let found = GREEK.iter().chain(SCRIPT).find(|(known, _, letter)| *known == name || *letter == name);
    found.map(|(_, latex, unicode)| (*latex, *unicode))
}

/// A word in LaTeX: a letter as it is, a Greek one by its command, several letters upright.
pub(super) fn latex_word(word: &str) -> String {
    greek(word).map_or_else(|| plain_latex(word), |(latex, _)| latex.to_owned())
}

fn plain_latex(word: &str) -> String {
    let mut letters = word.chars();
    let escaped = || word.replace('_', r"\_");
    match (letters.next(), letters.next()) {
        // Fonts for formulas have no other letters.
        _ if !word.is_ascii() => format!(r"\text{{{}}}", escaped()),
        (Some(only), None) => only.to_string(),
        _ if word.chars().all(|c| c.is_ascii_digit()) => word.to_owned(),
        _ => format!(r"\mathrm{{{}}}", escaped()),
    }
}

/// A word in Unicode text.
pub(super) fn unicode_word(word: &str) -> &str {
    greek(word).map_or(word, |(_, unicode)| unicode)
}

impl Symbol {
    /// Whether it is written with several letters.
    pub(super) fn is_word(&self) -> bool {
        self.letter.chars().nth(1).is_some() && (self.plain || greek(&self.letter).is_none())
    }

    /// The symbol of a name: underscores and trailing digits begin subscripts, `th` is short for `theta`.
    #[must_use]
    pub fn of(name: &str) -> Self {
        let mut symbol = Self::spelled(name);
        if let Some(letter) = in_full(&symbol.letter) {
            symbol.letter = letter.to_owned();
        }
        symbol
    }

    /// The same with the letters that are there.
    fn spelled(name: &str) -> Self {
        let mut parts = name.split('_').filter(|part| !part.is_empty());
        let head = parts.next().unwrap_or(name);
        let letters = head.trim_end_matches(|c: char| c.is_ascii_digit());
        let (letter, digits) = if letters.is_empty() { (head, "") } else { head.split_at(letters.len()) };
        let word = |part: &str| Subscript::Word(part.to_owned());
        let mut subscript = Vec::new();
        if !digits.is_empty() {
            subscript.push(word(digits));
        }
        subscript.extend(parts.map(word));
        Self { letter: letter.to_owned(), subscript, ..Self::default() }
    }

    /// Without subscripts, the whole name in the place of a letter.
    pub(super) fn whole(name: &str) -> Self {
        Self { letter: name.to_owned(), plain: true, ..Self::default() }
    }

    /// The letter alone in LaTeX, with its dots.
    pub(super) fn latex_letter(&self) -> String {
        let letter =
            if self.plain && self.letter.is_ascii() { plain_latex(&self.letter) } else { latex_word(&self.letter) };
        match self.dots {
            0 => letter,
            1 => format!(r"\dot{{{letter}}}"),
            2 => format!(r"\ddot{{{letter}}}"),
            3 => format!(r"\dddot{{{letter}}}"),
            more => format!(r"{letter}^{{({more})}}"),
        }
    }

    /// The letter alone in Unicode, with its dots; a word has none.
    pub(super) fn unicode_letter(&self) -> String {
        let letter = if self.plain { &self.letter } else { unicode_word(&self.letter) };
        let dots = match self.dots {
            _ if self.is_word() => "",
            0 => "",
            1 => "\u{307}",
            2 => "\u{308}",
            _ => "\u{20db}",
        };
        let delta = if self.delta { "δ" } else { "" };
        format!("{delta}{letter}{dots}")
    }
}

/// The symbols of names that are not to be printed as [`Symbol::of`] has them, so that no two names of a model look alike: `th`
/// stays as it is beside `theta`, and `la` beside `lb`. Members of families come with their indices.
pub(super) fn kept_apart<'a>(names: impl IntoIterator<Item = &'a str>) -> BTreeMap<String, Symbol> {
    let names: BTreeSet<&str> = names.into_iter().map(|name| name.trim_end_matches('\'')).gather();
    let family = |name: &'a str| name.split('[').next().unwrap_or(name);
    let letters: BTreeSet<String> = names.iter().map(|name| Symbol::spelled(family(name)).letter).gather();
    let has_sibling = |own: &str| {
        let mut others = letters.iter().filter(|other| *other != own && other.len() == own.len());
        others.any(|other| other.get(..1) == own.get(..1) && in_full(other).is_none() && greek(other).is_none())
    };
    let mut apart = BTreeMap::new();
    for name in &names {
        let spelled = Symbol::spelled(family(name));
        if in_full(&spelled.letter).is_some() && has_sibling(&spelled.letter) {
            apart.insert(family(name).to_owned(), spelled);
        }
    }
    for other in [Symbol::spelled, Symbol::whole] {
        let mut alike: BTreeMap<String, Vec<&str>> = BTreeMap::new();
        for name in &names {
            let mut symbol = apart.get(family(name)).cloned().unwrap_or_else(|| Symbol::of(family(name)));
            let indices = name.split(['[', ',', ']']).skip(1).map(str::trim).filter(|index| !index.is_empty());
            symbol.subscript.extend(indices.map(|index| Subscript::Word(index.to_owned())));
            alike.entry(symbol_text(&symbol)).or_default().push(name);
        }
        for name in alike.values().filter(|names| names.len() > 1).flatten() {
            apart.insert(family(name).to_owned(), other(family(name)));
        }
    }
    apart
}
