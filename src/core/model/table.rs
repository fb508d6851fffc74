//! Tables: CSV text with a header, or a matrix, read into exact numbers.

use super::instance::{Along, same_side};
use super::matrix_market;
use crate::model::ModelError;
use crate::number::Number;
use crate::span::Span;

/// The texts of the CSV and Matrix Market files that a model names, by the path as the model writes it.
///
/// The library reads no files; whoever calls it hands over what it has.
#[derive(Clone, Debug, Default)]
#[must_use]
pub struct TableTexts {
    texts: Vec<(String, Result<String, String>)>,
}

impl TableTexts {
    /// No tables.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds the text of the file that the model calls `path`; it takes the place of what was said
    /// about that file before.
    pub fn with(mut self, path: impl Into<String>, text: impl Into<String>) -> Self {
        self.texts.push((path.into(), Ok(text.into())));
        self
    }

    /// Remembers why the file that the model calls `path` could not be read, for the error message; a
    /// text given before is forgotten.
    pub fn with_failure(mut self, path: impl Into<String>, reason: impl Into<String>) -> Self {
        self.texts.push((path.into(), Err(reason.into())));
        self
    }

    /// The length of all texts.
    #[must_use]
    pub fn bytes(&self) -> usize {
        let texts = self.texts.iter().filter_map(|(_, text)| text.as_ref().ok());
        texts.map(String::len).sum()
    }

    /// The text of the file that the model calls `path`.
    #[must_use]
    pub fn text(&self, path: &str) -> Option<&str> {
        self.get(path)?.as_deref().ok()
    }

    fn get(&self, path: &str) -> Option<&Result<String, String>> {
        let found = self.texts.iter().rev().find(|(name, _)| name == path);
        found.map(|(_, text)| text)
    }
}

/// One field. Columns of names or remarks may stand in a table as long as no expression uses them.
#[derive(Clone, Debug)]
pub enum Cell {
    /// An exact number.
    Number(Number),
    /// Any other text.
    Text(String),
}

/// A table of exact numbers.
#[derive(Clone, Debug, Default)]
pub struct Table {
    pub(crate) name: String,
    pub(crate) span: Span,
    /// The names of the columns, in order.
    pub columns: Vec<String>,
    pub(crate) path: String,
    /// Row by row.
    cells: Vec<Cell>,
    /// Of each column, whether there are texts in it.
    texts: Vec<bool>,
    /// The lines of the rows, from 1.
    lines: Vec<u64>,
}

impl Table {
    /// How many rows there are.
    pub fn rows(&self) -> usize {
        self.lines.len()
    }

    /// The line of a row counted from 1.
    pub fn line(&self, row: usize) -> u64 {
        let line = row.checked_sub(1).and_then(|row| self.lines.get(row));
        line.copied().unwrap_or(1)
    }

    /// The first names of columns, shortened, for messages: no more of a file than it takes to see what it is.
    pub fn some_columns(&self) -> Vec<String> {
        const MOST: usize = 8;
        let names = self.columns.iter().take(MOST);
        let mut names: Vec<String> = names.map(|name| excerpt(name)).collect();
        if self.columns.len() > MOST {
            names.push("…".to_owned());
        }
        names
    }

    /// The field in a row counted from 1.
    pub fn field(&self, row: i64, column: usize) -> Option<&Cell> {
        let row = usize::try_from(row).ok()?.checked_sub(1)?;
        if row >= self.rows() || column >= self.columns.len() {
            return None;
        }
        self.cells.get(row * self.columns.len() + column)
    }

    /// For how many steps a field stays a number.
    pub(super) fn steady(&self, row: Along, column: usize) -> u64 {
        if row.step == 0 {
            return u64::MAX;
        }
        if self.texts.get(column) != Some(&false) {
            return 0;
        }
        let rows = i64::try_from(self.rows()).unwrap_or(i64::MAX);
        same_side(&[row], &[1], &[rows])
    }

    /// Stands for a table that could not be read.
    pub(crate) fn unread(name: &str, span: Span) -> Self {
        Self { name: name.to_owned(), span, ..Self::default() }
    }

    /// From the text of a CSV file, or of a Matrix Market file if its name ends in `.mtx`.
    pub fn read(name: &str, path: &str, span: Span, path_span: Span, texts: &TableTexts) -> Result<Self, ModelError> {
        let missing = |reason: String| ModelError::MissingTable { path: path.to_owned(), reason, span: path_span };
        let text = match texts.get(path) {
            None => return Err(missing(String::new())),
            Some(Err(reason)) => return Err(missing(format!(": {reason}"))),
            Some(Ok(text)) => text.trim_start_matches('\u{feff}'),
        };
        let bad =
            |line: u64, reason: String| ModelError::BadTable { path: path.to_owned(), line, reason, span: path_span };
        let own = Self { path: path.to_owned(), ..Self::unread(name, span) };
        if path.to_ascii_lowercase().ends_with(".mtx") {
            let entries = matrix_market::entries(text).map_err(|(line, reason)| bad(line, reason))?;
            let lines = entries.iter().map(|(_, line)| *line).collect();
            let cells = entries.into_iter().flat_map(|(fields, _)| fields).map(Cell::Number).collect();
            let (columns, texts) = (["i", "j", "v"].map(str::to_owned).to_vec(), vec![false; 3]);
            return Ok(Self { columns, cells, texts, lines, ..own });
        }
        let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_reader(text.as_bytes());
        let describe = |error: &csv::Error| {
            let line = error.position().map_or(1, csv::Position::line);
            let reason = match error.kind() {
                csv::ErrorKind::UnequalLengths { expected_len, len, .. } => {
                    format!("{len} fields where the header has {expected_len}")
                }
                csv::ErrorKind::Utf8 { .. } => "not UTF-8 text".to_owned(),
                _ => error.to_string(),
            };
            bad(line, reason)
        };
        let columns: Vec<String> = match reader.headers() {
            Ok(header) => header.iter().map(|name| name.trim().to_owned()).collect(),
            Err(error) => return Err(describe(&error)),
        };
        if columns.is_empty() || columns.iter().all(String::is_empty) {
            return Err(bad(1, "there is no header with column names".to_owned()));
        }
        if let [only] = columns.as_slice()
            && let Some(separator) = only.chars().find(|c| matches!(c, ';' | '\t'))
        {
            let named = if separator == ';' { "semicolons" } else { "tabs" };
            return Err(bad(1, format!("the columns are separated by {named}; commas are needed")));
        }
        let mut numbered = columns.iter().enumerate();
        if let Some((_, column)) = numbered.find(|(at, column)| columns[..*at].contains(column)) {
            return Err(bad(1, format!("the column `{}` occurs twice", excerpt(column))));
        }
        let mut cells = Vec::new();
        let mut texts = vec![false; columns.len()];
        let mut lines = Vec::new();
        let mut record = csv::StringRecord::new();
        while reader.read_record(&mut record).map_err(|error| describe(&error))? {
            let line = record.position().map_or(0, csv::Position::line);
            // The reader takes the end of the text for the quote that is missing.
            let start = record.position().map_or(0, csv::Position::byte);
            let whole = text.as_bytes().get(start as usize..reader.position().byte() as usize).unwrap_or_default();
            let quotes = whole.iter().filter(|byte| **byte == b'"').count();
            if quotes % 2 == 1 && record.iter().any(|field| field.contains('\n')) {
                return Err(bad(line, "a quote that is opened here is never closed".to_owned()));
            }
            for (field, is_text) in record.iter().zip(&mut texts) {
                let field = field.trim();
                let number = parse_field(field);
                *is_text |= number.is_none();
                cells.push(number.map_or_else(|| Cell::Text(excerpt(field)), Cell::Number));
            }
            lines.push(line);
        }
        Ok(Self { columns, cells, texts, lines, ..own })
    }
}

/// What messages quote of a field.
pub(super) fn excerpt(field: &str) -> String {
    const MOST: usize = 40;
    if let Some((end, _)) = field.char_indices().nth(MOST) { format!("{}…", &field[..end]) } else { field.to_owned() }
}

/// Decimal numbers as spreadsheets write them: with a sign, with `.5` and `5.` too.
pub(super) fn parse_field(field: &str) -> Option<Number> {
    let (negative, digits) = match field.strip_prefix('-') {
        Some(rest) => (true, rest),
        None => (false, field.strip_prefix('+').unwrap_or(field)),
    };
    let (mantissa, exponent) = match digits.find(['e', 'E']) {
        Some(at) => (&digits[..at], &digits[at..]),
        None => (digits, ""),
    };
    if mantissa == "." {
        return None;
    }
    let mut plain = String::with_capacity(digits.len() + 2);
    if mantissa.starts_with('.') {
        plain.push('0');
    }
    plain.push_str(mantissa);
    if mantissa.ends_with('.') {
        plain.push('0');
    }
    plain.push_str(exponent);
    let number = Number::parse(&plain)?;
    Some(if negative { number.neg() } else { number })
}
