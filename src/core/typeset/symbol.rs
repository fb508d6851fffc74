//! Names of the model language as symbols: `theta_0` as a letter with a subscript.

/// A letter with its subscript, its dots and a prefix.
#[derive(Clone, Debug, Default, PartialEq)]
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
}

/// A part of a subscript.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Subscript {
    /// Part of a name: digits, a letter, a word.
    Word(String),
    /// The index of a member of a family, as LaTeX and as text.
    Index(super::Formula),
}

/// The Greek letters by name: LaTeX, Unicode.
const GREEK: &[(&str, &str, &str)] = &[
    ("alpha", r"\alpha", "α"),
    ("beta", r"\beta", "β"),
    ("gamma", r"\gamma", "γ"),
    ("delta", r"\delta", "δ"),
    ("epsilon", r"\varepsilon", "ε"),
    ("zeta", r"\zeta", "ζ"),
    ("eta", r"\eta", "η"),
    ("theta", r"\theta", "θ"),
    ("iota", r"\iota", "ι"),
    ("kappa", r"\kappa", "κ"),
    ("lambda", r"\lambda", "λ"),
    ("mu", r"\mu", "μ"),
    ("nu", r"\nu", "ν"),
    ("xi", r"\xi", "ξ"),
    ("pi", r"\pi", "π"),
    ("rho", r"\rho", "ρ"),
    ("sigma", r"\sigma", "σ"),
    ("tau", r"\tau", "τ"),
    ("upsilon", r"\upsilon", "υ"),
    ("phi", r"\varphi", "φ"),
    ("chi", r"\chi", "χ"),
    ("psi", r"\psi", "ψ"),
    ("omega", r"\omega", "ω"),
    ("Gamma", r"\Gamma", "Γ"),
    ("Delta", r"\Delta", "Δ"),
    ("Theta", r"\Theta", "Θ"),
    ("Lambda", r"\Lambda", "Λ"),
    ("Xi", r"\Xi", "Ξ"),
    ("Pi", r"\Pi", "Π"),
    ("Sigma", r"\Sigma", "Σ"),
    ("Upsilon", r"\Upsilon", "Υ"),
    ("Phi", r"\Phi", "Φ"),
    ("Psi", r"\Psi", "Ψ"),
    ("Omega", r"\Omega", "Ω"),
];

/// By its name or as the letter itself.
fn greek(name: &str) -> Option<(&'static str, &'static str)> {
    let found = GREEK.iter().find(|(known, _, letter)| *known == name || *letter == name);
    found.map(|(_, latex, unicode)| (*latex, *unicode))
}

/// A word in LaTeX: a letter as it is, a Greek one by its command, more letters upright.
pub(super) fn latex_word(word: &str) -> String {
    if let Some((latex, _)) = greek(word) {
        return latex.to_owned();
    }
    let mut letters = word.chars();
    match (letters.next(), letters.next()) {
        // Fonts for formulas have no other letters.
        _ if !word.is_ascii() => format!(r"\text{{{word}}}"),
        (Some(only), None) => only.to_string(),
        _ if word.chars().all(|c| c.is_ascii_digit()) => word.to_owned(),
        _ => format!(r"\mathrm{{{}}}", word.replace('_', r"\_")),
    }
}

/// A word in Unicode text.
pub(super) fn unicode_word(word: &str) -> &str {
    greek(word).map_or(word, |(_, unicode)| unicode)
}

impl Symbol {
    /// The symbol of a name: underscores and trailing digits begin subscripts.
    #[must_use]
    pub fn of(name: &str) -> Self {
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
        Self { letter: letter.to_owned(), subscript, dots: 0, delta: false }
    }

    /// The letter alone in LaTeX, with its dots.
    pub(super) fn latex_letter(&self) -> String {
        let letter = latex_word(&self.letter);
        let dotted = match self.dots {
            0 => letter,
            1 => format!(r"\dot{{{letter}}}"),
            2 => format!(r"\ddot{{{letter}}}"),
            3 => format!(r"\dddot{{{letter}}}"),
            more => format!(r"{letter}^{{({more})}}"),
        };
        if self.delta { format!(r"\delta {dotted}") } else { dotted }
    }

    /// The letter alone in Unicode, with its dots.
    pub(super) fn unicode_letter(&self) -> String {
        let letter = unicode_word(&self.letter);
        let dots = match self.dots {
            0 => "",
            1 => "\u{307}",
            2 => "\u{308}",
            _ => "\u{20db}",
        };
        let delta = if self.delta { "δ" } else { "" };
        // Over the last letter of a word.
        format!("{delta}{letter}{dots}")
    }
}
