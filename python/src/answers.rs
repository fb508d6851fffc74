//! What goes back to Python.

use librate::derive;
use librate::diagnostic::{Diagnostic, Label};
use librate::linearize::Linearized;
use librate::modes::Options;
use librate::oscillation::NormalModes;
use librate::report::{self, FrequencyUnit, Style};
use pyo3::prelude::*;

use crate::job::{Failure, Page};

/// Columns of messages.
const MESSAGE_WIDTH: usize = 140;
/// Nobody reads more mistakes than this.
const MOST_TOLD: usize = 1000;

/// More digits than this are not certified.
pub(crate) const MOST_DIGITS: usize = 250;

/// A number of digits.
pub(crate) fn digits(count: i64, most: usize) -> Result<usize, Failure> {
    let found = usize::try_from(count).ok().filter(|count| (1..=most).contains(count));
    found.ok_or_else(|| Failure::request(format!("there can't be {count} digits"), &format!("from 1 to {most}")))
}

/// A count of something, 1 or more.
pub(crate) fn positive(name: &str, count: Option<i64>) -> Result<Option<usize>, Failure> {
    let Some(count) = count else { return Ok(None) };
    match usize::try_from(count) {
        Ok(0) | Err(_) => {
            Err(Failure::request(format!("`{name}` can't be {count}"), "a whole number, 1 or more, is needed"))
        }
        Ok(count) => Ok(Some(count)),
    }
}

/// What a command answers.
#[derive(IntoPyObject)]
pub(crate) struct Answer {
    /// For the fields of a result; empty for a picture.
    pub(crate) json: String,
    /// For a reader.
    pub(crate) text: String,
    pub(crate) warnings: Shown,
}

/// Errors or warnings about a text.
#[derive(Default, IntoPyObject)]
pub(crate) struct Shown {
    /// All of them, drawn into the text.
    pub(crate) drawn: String,
    told: Vec<Told>,
}

/// One of them.
#[derive(IntoPyObject)]
struct Told {
    severity: &'static str,
    code: Option<&'static str>,
    message: String,
    help: Option<String>,
    spans: Vec<Place>,
}

/// A place in the text, in characters.
#[derive(IntoPyObject)]
struct Place {
    start: usize,
    end: usize,
    line: usize,
    column: usize,
    label: String,
}

impl Shown {
    pub(crate) fn new(page: &Page, told: &[Diagnostic]) -> Self {
        if told.is_empty() {
            return Self::default();
        }
        let lines = Lines::new(&page.text);
        let one = |told: &Diagnostic| Told {
            severity: told.severity.as_str(),
            code: told.code,
            message: told.message.clone(),
            help: told.help.clone(),
            spans: told.primary.iter().chain(&told.secondary).map(|label| lines.place(label)).collect(),
        };
        let style = Style::default().width(MESSAGE_WIDTH);
        let drawn = report::diagnostics_text(&page.name, &page.text, told, &style);
        Self { drawn: drawn.trim_end().to_owned(), told: told.iter().take(MOST_TOLD).map(one).collect() }
    }
}

/// Where the lines of a text begin, in bytes and in characters, so that no place needs all of the text.
struct Lines<'a> {
    text: &'a str,
    starts: Vec<[usize; 2]>,
}

impl<'a> Lines<'a> {
    fn new(text: &'a str) -> Self {
        let mut starts = vec![[0, 0]];
        let [mut bytes, mut characters] = [0, 0];
        for line in text.split_inclusive('\n') {
            bytes += line.len();
            characters += line.chars().count();
            starts.push([bytes, characters]);
        }
        Self { text, starts }
    }

    /// The number of the line from 0, and the characters in front of a byte, on it and at all.
    fn position(&self, at: u32) -> [usize; 3] {
        let mut at = (at as usize).min(self.text.len());
        while !self.text.is_char_boundary(at) {
            at -= 1;
        }
        let line = self.starts.partition_point(|[bytes, _]| *bytes <= at).saturating_sub(1);
        let [bytes, characters] = self.starts.get(line).copied().unwrap_or_default();
        let column = self.text.get(bytes..at).map_or(0, |before| before.chars().count());
        [line, column, characters + column]
    }

    fn place(&self, label: &Label) -> Place {
        let [line, column, start] = self.position(label.span.start);
        let [_, _, end] = self.position(label.span.end);
        Place { start, end, line: line + 1, column: column + 1, label: label.text.clone() }
    }
}

/// Modes about an equilibrium.
#[pyclass(frozen, module = "librate._native")]
pub(crate) struct Modes {
    pub(crate) linearized: Linearized,
    pub(crate) modes: NormalModes,
    pub(crate) options: Options,
    pub(crate) unit: Option<FrequencyUnit>,
}

/// Doubles in a row, as bytes.
#[derive(IntoPyObject)]
pub(crate) struct Numbers {
    data: Vec<u8>,
    /// Whether they are pairs of real and imaginary parts.
    complex: bool,
}

/// The bytes of doubles.
pub(crate) fn bytes(numbers: impl Iterator<Item = f64>) -> impl Iterator<Item = u8> {
    numbers.flat_map(f64::to_ne_bytes)
}

/// The doubles of bytes.
pub(crate) fn doubles(bytes: &[u8]) -> impl Iterator<Item = f64> {
    bytes.chunks_exact(8).map(|chunk| chunk.try_into().map_or(f64::NAN, f64::from_ne_bytes))
}

#[pymethods]
impl Modes {
    /// As `librate modes --json` has it, without vectors.
    fn json(&self, py: Python<'_>) -> String {
        py.detach(|| {
            let options = self.options.clone().without_vectors();
            report::modes_json(&self.linearized, &self.modes, &options)
        })
    }

    /// As `librate modes` has it.
    fn text(&self, py: Python<'_>) -> String {
        py.detach(|| {
            let style = Style::default().unit(self.unit);
            report::modes_text(&self.linearized, &self.modes, &self.options, &style)
        })
    }

    /// The shapes, one mode after the other.
    fn vectors(&self, py: Python<'_>) -> Numbers {
        py.detach(|| {
            let modes = &self.modes.modes;
            let complex = modes.iter().any(|mode| !mode.imaginary.is_empty());
            let parts = modes.iter().flat_map(|mode| {
                mode.vector.iter().enumerate().flat_map(move |(at, real)| {
                    let imaginary = complex.then(|| mode.imaginary.get(at).copied().unwrap_or(0.0));
                    [Some(*real), imaginary].into_iter().flatten()
                })
            });
            Numbers { data: bytes(parts).collect(), complex }
        })
    }
}

/// A derivation.
#[pyclass(frozen, module = "librate._native")]
pub(crate) struct Derivation {
    pub(crate) derivation: derive::Derivation,
}

#[pymethods]
impl Derivation {
    fn json(&self, py: Python<'_>) -> String {
        py.detach(|| report::derive_json(&self.derivation))
    }

    fn text(&self, py: Python<'_>, ascii: bool) -> String {
        py.detach(|| report::derive_text(&self.derivation, &Style::default().ascii(ascii)))
    }

    fn latex(&self, py: Python<'_>, standalone: bool) -> String {
        py.detach(|| report::derive_latex(&self.derivation, standalone))
    }

    fn html(&self, py: Python<'_>) -> String {
        py.detach(|| report::derive_html(&self.derivation))
    }

    fn typst(&self, py: Python<'_>) -> String {
        py.detach(|| report::derive_typst(&self.derivation))
    }
}
