//! Tables of columns, without lines.

use comfy_table::{Cell, CellAlignment, ContentArrangement, Table, presets};

use super::{Style, Tone};

/// Spaces between columns.
pub(super) const GAP: usize = 2;

/// One column: its heading, its cells and which way they lean.
pub(super) struct Column {
    heading: String,
    cells: Vec<String>,
    alignment: CellAlignment,
}

impl Column {
    /// Cells that end in one column.
    pub(super) fn right(heading: &str, cells: Vec<String>) -> Self {
        Self { heading: heading.to_owned(), cells, alignment: CellAlignment::Right }
    }

    /// 1, 2, …
    pub(super) fn counting(heading: &str, count: usize) -> Self {
        Self::right(heading, (1..=count).map(|at| at.to_string()).collect())
    }

    /// Cells that begin in one column.
    pub(super) fn words(heading: &str, cells: Vec<String>) -> Self {
        Self { heading: heading.to_owned(), cells, alignment: CellAlignment::Left }
    }

    /// Numbers whose decimal points stand in one column.
    pub(super) fn numbers(heading: &str, mut cells: Vec<String>) -> Self {
        align_at_point(&mut cells);
        Self::words(heading, cells)
    }

    /// The width, with the gap that separates it from the next.
    pub(super) fn width(&self) -> usize {
        let cells = self.cells.iter().map(|cell| cell.chars().count()).max();
        cells.unwrap_or(0).max(self.heading.chars().count()) + GAP
    }
}

/// Writes columns side by side, a line a row; `painted` gives the word of a row to be coloured,
/// the first of its kind in the row.
pub(super) fn draw<'a>(
    columns: &[Column],
    rows: usize,
    painted: impl Fn(usize) -> Option<(Tone, &'a str)>,
    style: &Style,
) -> String {
    let mut table = plain();
    table.set_header(columns.iter().map(|column| Cell::new(&column.heading).set_alignment(column.alignment)));
    let cell = |column: &Column, at: usize| Cell::new(column.cells.get(at).map_or("", String::as_str));
    let row = |at: usize| columns.iter().map(move |column| cell(column, at).set_alignment(column.alignment));
    table.add_rows((0..rows).map(row));
    let mut out = String::new();
    for (line, text) in lines(&mut table).into_iter().enumerate() {
        let painted = match line.checked_sub(1) {
            None => style.paint(Tone::Heading, &text),
            Some(at) => match painted(at) {
                Some((tone, word)) => text.replacen(word, &style.paint(tone, word), 1),
                None => text,
            },
        };
        out.push_str(&painted);
        out.push('\n');
    }
    out
}

/// A table without lines that never wraps.
pub(super) fn plain() -> Table {
    let mut table = Table::new();
    table.load_style(presets::NOTHING);
    table.set_content_arrangement(ContentArrangement::Disabled);
    table
}

/// The lines of a table, without spaces at their ends.
pub(super) fn lines(table: &mut Table) -> Vec<String> {
    for column in table.column_iter_mut() {
        column.set_padding((0, GAP as u16));
    }
    table.lines().map(|line| line.trim_end().to_owned()).collect()
}

/// Pads numbers on both sides so that their decimal points stand in one column.
fn align_at_point(numbers: &mut [String]) {
    let point = |text: &str| text.find(['.', 'e']).unwrap_or(text.len());
    let left = numbers.iter().map(|text| point(text)).max().unwrap_or(0);
    for text in numbers.iter_mut() {
        *text = format!("{}{text}", " ".repeat(left - point(text)));
    }
    let width = numbers.iter().map(String::len).max().unwrap_or(0);
    for text in numbers.iter_mut() {
        *text = format!("{text:<width$}");
    }
}
