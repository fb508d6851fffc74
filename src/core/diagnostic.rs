//! What all error types turn into when a person or an editor is to read them.
//!
//! Every stage has its own error enum; each variant converts to a [`Diagnostic`]: a message in a
//! physicist's words, the place, where it helps a second place, and the fix where there is one.
//! This module holds the plain data and never draws: `report::diagnostics_text` does.

use crate::order::Order;
use crate::span::Span;
use crate::worded;

worded! {
/// How bad it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[non_exhaustive]
Severity {
    /// The model can't be used.
    Error "error",
    /// Legal, but suspicious.
    Warning "warning",
}
/// `error` or `warning`.
as_str
}

/// A place with a remark.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub struct Label {
    /// Where.
    pub span: Span,
    /// What is to be said there; may be empty.
    pub text: String,
}

/// A change of the text: what stands at a place gives way to something else.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub struct Replacement {
    /// What is replaced; empty for an insertion.
    pub span: Span,
    /// By what; empty for a removal.
    pub text: String,
}

impl Replacement {
    /// What stands at a place gives way to a text.
    #[must_use]
    pub fn new(span: Span, text: impl Into<String>) -> Self {
        Self { span, text: text.into() }
    }
}

/// A text with all changes made; of two that overlap the first.
#[must_use]
pub fn replaced<'a>(text: &str, changes: impl IntoIterator<Item = &'a Replacement>) -> String {
    let mut changes: Vec<&Replacement> = changes.into_iter().collect();
    changes.order_by_key(|own| own.span.start);
    let (mut out, mut done) = (String::new(), 0);
    for own in changes {
        if let Some(kept) = text.get(done..own.span.start as usize) {
            out.push_str(kept);
            out.push_str(&own.text);
            done = own.span.end as usize;
        }
    }
    out.push_str(text.get(done..).unwrap_or_default());
    out
}

/// A message about a model file, ready to be drawn.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
#[must_use]
pub struct Diagnostic {
    /// Error or warning.
    pub severity: Severity,
    /// The kind of mistake, `E0012`; [`explain`](crate::explain::explain) knows more about it.
    /// `None` for what is no kind of its own.
    pub code: Option<&'static str>,
    /// What is wrong, one sentence without a full stop.
    pub message: String,
    /// The place of the mistake; `None` where the whole file is at fault.
    pub primary: Option<Label>,
    /// Where the other half of the mistake stands.
    pub secondary: Vec<Label>,
    /// The fix, if there is one.
    pub help: Option<String>,
    /// The fix as a change of the text, where it is certain enough to be made unseen: the same in the notation of the
    /// language where it has one reading only, or a slip of the pen (`is_misspelt`). What is declared by it is as
    /// before but for a coordinate whose velocity is used, and what has a meaning of its own keeps it.
    pub replacement: Option<Replacement>,
    /// A change that may be what is meant, for an editor that asks.
    pub proposal: Option<Replacement>,
}

impl Diagnostic {
    /// An error at a place.
    pub fn error(message: impl Into<String>, span: Span, label: impl Into<String>) -> Self {
        Self { primary: Some(Label { span, text: readable(label.into()) }), ..Self::global(message) }
    }

    /// An error of the file as a whole.
    pub fn global(message: impl Into<String>) -> Self {
        Self {
            severity: Severity::Error,
            code: None,
            message: readable(message.into()),
            primary: None,
            secondary: Vec::new(),
            help: None,
            replacement: None,
            proposal: None,
        }
    }

    /// A remark on an answer as a whole.
    pub fn remark(message: impl Into<String>) -> Self {
        Self { severity: Severity::Warning, ..Self::global(message) }
    }

    /// Something legal, but suspicious, at a place.
    pub fn warning(message: impl Into<String>, span: Span, label: impl Into<String>) -> Self {
        Self { severity: Severity::Warning, ..Self::error(message, span, label) }
    }

    /// The same with what is wrong.
    pub fn told(self, severity: Severity, message: String, code: &'static str) -> Self {
        Self { severity, message: readable(message), code: Some(code), ..self }
    }

    /// The same with a second place, if there is one.
    #[cfg(feature = "engine")]
    pub fn and_at(self, span: Option<Span>, text: &str) -> Self {
        if let Some(span) = span { self.with_secondary(span, text) } else { self }
    }

    /// The same with a fix, if there is one.
    pub(crate) fn or_help(self, help: Option<String>) -> Self {
        Self { help: help.map(readable).or(self.help), ..self }
    }

    /// The same with a change of the text that is the fix.
    pub(crate) fn replacing(mut self, span: Span, text: impl Into<String>) -> Self {
        self.replacement = Some(Replacement::new(span, text));
        self
    }

    /// The same with a change of the text that is to be asked for.
    #[cfg(feature = "engine")]
    pub(crate) fn proposing(mut self, span: Span, text: impl Into<String>) -> Self {
        self.proposal = Some(Replacement::new(span, text));
        self
    }

    /// The same with a change of the text, if there is one.
    pub(crate) fn or_replacing(self, change: Option<&(Span, String)>) -> Self {
        if let Some((span, text)) = change { self.replacing(*span, text) } else { self }
    }

    /// The same with the fix to write something else at a place.
    pub(crate) fn written(self, span: Span, text: impl Into<String>) -> Self {
        let text = text.into();
        self.with_help(format!("write `{text}`")).replacing(span, text)
    }

    /// The same with what was probably meant at a place, if there is something.
    #[cfg(feature = "engine")]
    pub(crate) fn or_meant(self, span: Span, meant: Option<&Meant>) -> Self {
        let Some(Meant { text, is_certain }) = meant else { return self };
        let shown = self.with_help(format!("did you mean `{text}`?"));
        if *is_certain { shown.replacing(span, text) } else { shown.proposing(span, text) }
    }

    /// The same with the code of its kind.
    pub fn with_code(mut self, code: &'static str) -> Self {
        self.code = Some(code);
        self
    }

    /// The same with a second place.
    pub fn with_secondary(mut self, span: Span, text: impl Into<String>) -> Self {
        self.secondary.push(Label { span, text: readable(text.into()) });
        self
    }

    /// The same with a fix.
    pub fn with_help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(readable(help.into()));
        self
    }
}

/// What was probably meant by something that is not declared.
#[cfg(feature = "engine")]
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Meant {
    /// As the language has it.
    pub text: String,
    /// Whether it can be written unseen.
    pub is_certain: bool,
}

#[cfg(feature = "engine")]
impl Meant {
    /// The same thing in the notation of the language.
    pub(crate) fn certain(text: String) -> Self {
        Self { text, is_certain: true }
    }

    /// What may be something else as well.
    pub(crate) fn guess(text: String) -> Self {
        Self { text, is_certain: false }
    }

    /// The nearest of the names that there are.
    pub(crate) fn near<'a>(name: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<Self> {
        let nearest = nearest(name, candidates)?;
        Some(Self { text: nearest.to_owned(), is_certain: is_misspelt(name, nearest) })
    }
}

/// A place with a label, of which it is not said yet what is wrong there.
pub fn at(span: Span, label: impl Into<String>) -> Diagnostic {
    Diagnostic::error("", span, label)
}

/// No place at all.
pub fn nowhere() -> Diagnostic {
    Diagnostic::global("")
}

/// Longer words than this are shortened in messages: they are no names that a person has written.
const LONGEST_WORD: usize = 100;

/// The text with the middle of overlong words left out.
fn readable(text: String) -> String {
    if text.len() <= LONGEST_WORD {
        return text;
    }
    let mut out = String::new();
    for piece in text.split_inclusive(char::is_whitespace) {
        if piece.char_indices().nth(LONGEST_WORD).is_none() {
            out.push_str(piece);
            continue;
        }
        let start = piece.char_indices().nth(LONGEST_WORD / 2);
        let end = piece.char_indices().rev().nth(LONGEST_WORD / 4);
        out.push_str(&piece[..start.map_or(0, |(at, _)| at)]);
        out.push('…');
        out.push_str(&piece[end.map_or(piece.len(), |(at, _)| at)..]);
    }
    out
}

/// Longer names are not compared: no person writes them.
const LONGEST_COMPARED: usize = 64;

/// The name among `candidates` that `name` was probably meant to be, if one is near enough.
///
/// Near means at most a third of the longer one's letters changed, inserted, dropped or swapped
/// (optimal string alignment distance), and one letter after the first in a name of two; a wrong case counts as half
/// a change, and an index at the end may be left out or added: `k` for `k12`.
#[must_use]
pub fn nearest<'a>(name: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    if name.len() > LONGEST_COMPARED {
        return None;
    }
    let lower = name.to_lowercase();
    let mut best: Option<(usize, &'a str)> = None;
    for candidate in candidates.into_iter().filter(|own| own.len() <= LONGEST_COMPARED) {
        // Doubled, so that a wrong case can cost half.
        let distance = strsim::osa_distance(name, candidate) + strsim::osa_distance(&lower, &candidate.to_lowercase());
        let [own, other] = [name, candidate].map(|text| text.chars().count());
        let [shorter, longer] = [own.min(other), own.max(other)];
        let allowed = match longer {
            2 if shorter == 1 && name.chars().next() == candidate.chars().next() => 2,
            0..=2 => 1,
            _ if without_index(name) == candidate || without_index(candidate) == name => distance,
            _ => (2 * longer).div_ceil(3).max(2),
        };
        if distance <= allowed && best.is_none_or(|(least, _)| distance < least) {
            best = Some((distance, candidate));
        }
    }
    best.map(|(_, candidate)| candidate)
}

/// Whether a name can only be a slip of the pen for another: one letter within it left out, doubled, wrong or swapped with its
/// neighbour, in four letters at least. `K` may be another stiffness than `k`, and `k2` than `k1`.
pub(crate) fn is_misspelt(name: &str, meant: &str) -> bool {
    let digits = |text: &str| text.chars().filter(char::is_ascii_digit).collect::<String>();
    let ends = |text: &str| (text.chars().next(), text.chars().next_back());
    name.chars().count().max(meant.chars().count()) >= 4
        && name.len() <= LONGEST_COMPARED
        && ends(name) == ends(meant)
        && digits(name) == digits(meant)
        && strsim::osa_distance(&name.to_lowercase(), &meant.to_lowercase()) == 1
}

/// Longer names are not taken for products.
const LONGEST_PRODUCT: usize = 6;

/// Different names that make up a name together: `m`, `g` and `l` for `mgl`.
pub(crate) fn factors_in<'n>(name: &'n str, is_name: &dyn Fn(&str) -> bool) -> Option<Vec<&'n str>> {
    let mut factors: Vec<&str> = Vec::new();
    let mut rest = name;
    while !rest.is_empty() && name.len() <= LONGEST_PRODUCT {
        let ends = rest.char_indices().map(|(at, c)| at + c.len_utf8()).rev();
        let factor = ends.filter_map(|end| rest.get(..end)).find(|own| is_name(own))?;
        if factors.contains(&factor) {
            return None;
        }
        factors.push(factor);
        rest = rest.get(factor.len()..)?;
    }
    (factors.len() > 1).then_some(factors)
}

/// `k` of `k12` and `k_12`.
fn without_index(name: &str) -> &str {
    name.trim_end_matches(|c: char| c.is_ascii_digit()).trim_end_matches('_')
}
