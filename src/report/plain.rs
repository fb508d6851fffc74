//! A page as text of some width.

use unicode_width::UnicodeWidthStr;

use super::page::{self, Form, Line, Matrix, Page, Part};
use super::table::{lines, plain};
use super::{Style, Tone, headline, listed};
use librate_core::derive::Derivation;
use librate_core::typeset::{Block, Formula, Notation};

/// Formulas of more lines are not written behind a title.
const MOST_IN_SECTION: usize = 12;

/// The derivation as text, in the order of the page: Lagrange's equations, momenta and what is
/// conserved, the equilibrium, T and V to second order, M, K, the linearized equations, symmetry and
/// closed forms of the frequencies.
///
/// What would be repeated too often is given a name at the top. Matrices have aligned columns where they fit into the width, else their entries that are not
/// zero stand one a line, with the upper triangle standing for both.
#[must_use]
pub fn derive_text(derivation: &Derivation, style: &Style) -> String {
    let page = &Page::new(derivation);
    let layout = Layout { style, notation: (!style.ascii).then_some(&page.notation) };
    let mut out = style.paint(Tone::Heading, &headline(page.model.as_deref(), page.dimension)) + "\n";
    for part in &page.parts {
        match part {
            Part::List(title, items) => {
                let items: Vec<String> = items.iter().map(|item| layout.words(item)).collect();
                out.push_str(&listed(&layout.words(title), &items, style.width));
            }
            Part::Section(title, lines, form) => out.push_str(&layout.section(title, lines, *form)),
            Part::Matrix(matrix) => out.push_str(&format!("\n{}", layout.matrix(matrix))),
            Part::Paragraph(words) => {
                out.push('\n');
                out.extend(wrapped(&layout.words(words), style.width).into_iter().map(|line| line + "\n"));
            }
            Part::Gap => out.push('\n'),
        }
    }
    out
}

/// Lines of at most `width` columns, broken at spaces; all but the first are indented.
pub(super) fn wrapped(text: &str, width: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split(' ') {
        match lines.last_mut() {
            Some(line) if line.width() + 1 + word.width() <= width => line.push_str(&format!(" {word}")),
            Some(_) => lines.push(format!("    {word}")),
            None => lines.push(word.to_owned()),
        }
    }
    lines
}

/// How the page is laid out and what its names stand for.
struct Layout<'a> {
    style: &'a Style,
    /// None where the language's own notation is wanted.
    notation: Option<&'a Notation>,
}

impl Layout<'_> {
    /// A formula of the model language with a remark behind it, in the lines that it takes; what is none stays as it is.
    fn lines(&self, text: &str, remark: &str, width: usize) -> Vec<String> {
        let remark = self.words(remark);
        let Some(notation) = self.notation else { return vec![format!("{text}{remark}")] };
        let Some(formula) = notation.read_relation(text) else { return wrapped(&format!("{text}{remark}"), width) };
        if remark.is_empty() {
            return formula.text(width);
        }
        let block = Block::beside(&[formula.block(), Block::line(&remark)]);
        if block.width() <= width {
            return block.lines().map(str::to_owned).collect();
        }
        let mut lines = formula.text(width);
        let remark = wrapped(remark.trim_start_matches([',', ' ']), width.saturating_sub(4));
        lines.extend(remark.into_iter().map(|line| format!("    {line}")));
        lines
    }

    /// Words with formulas of one line; what needs more stays as it is.
    fn words(&self, words: &str) -> String {
        let Some(notation) = self.notation else { return words.replace('`', "") };
        page::words(words, str::to_owned, |part| {
            let formula = notation.read_relation(part);
            match formula.map(|formula| formula.block()) {
                Some(block) if block.height() == 1 => block.lines().collect(),
                Some(_) | None => part.to_owned(),
            }
        })
    }

    fn line(&self, line: &Line, width: usize) -> Vec<String> {
        match line {
            Line::Formula(text, remark) => self.lines(text, remark, width),
            Line::Item(text, words) => self.lines(text, &format!(": {words}"), width),
            Line::Words(words) => wrapped(&self.words(words), width),
            Line::Below(matrix) => {
                let lines = self.small_matrix(matrix, width.saturating_sub(2)).into_iter();
                lines.map(|line| format!("  {line}")).collect()
            }
        }
    }

    fn section(&self, title: &str, all: &[Line], form: Form) -> String {
        let title = self.words(title);
        let width = self.style.width.saturating_sub(2);
        let formulas: Vec<Vec<String>> = all.iter().map(|line| self.line(line, width)).collect();
        let tall = formulas.iter().any(|lines| lines.len() > 1);
        if form == Form::Inline && (!tall || all.len() > MOST_IN_SECTION) {
            let one = |line: &Line| match line {
                Line::Formula(text, _) => self.words(&format!("`{text}`")),
                Line::Item(..) | Line::Words(_) | Line::Below(_) => String::new(),
            };
            return listed(&title, &all.iter().map(one).collect::<Vec<_>>(), self.style.width);
        }
        let mut out = if form == Form::Inline { String::new() } else { "\n".to_owned() };
        for line in wrapped(&title, self.style.width) {
            out.push_str(&(self.style.paint(Tone::Heading, &line) + "\n"));
        }
        for (at, lines) in formulas.iter().enumerate() {
            if tall && at > 0 && form != Form::Close {
                out.push('\n');
            }
            for line in lines {
                out.push_str(format!("  {line}").trim_end());
                out.push('\n');
            }
        }
        out
    }

    /// `M = ...` beside each other where that fits, else the entries that are not zero.
    fn small_matrix(&self, matrix: &Matrix, width: usize) -> Vec<String> {
        let Some(notation) = self.notation else {
            let rows = matrix.dense().unwrap_or_default();
            let rows: Vec<String> = rows.iter().map(|row| format!("[{}]", row.join(", "))).collect();
            return vec![format!("{} = [{}]", matrix.letter, rows.join(", "))];
        };
        let whole = matrix.formula(notation, width).map(|formula| formula.block());
        match whole.filter(|block| block.width() <= width) {
            Some(block) => block.lines().map(str::to_owned).collect(),
            None => matrix.listed().1.iter().flat_map(|line| self.line(line, width)).collect(),
        }
    }

    /// Aligned columns where they fit into the width, else the entries that are not zero.
    fn matrix(&self, matrix: &Matrix) -> String {
        let heading = self.style.paint(Tone::Heading, &format!("{} {}", matrix.title, matrix.letter));
        // A matrix that can't fit is not written out only to be measured.
        let dense = matrix.dense().filter(|_| matrix.columns * 3 <= self.style.width);
        let lines: Option<Vec<String>> = dense.map(|rows| match self.notation {
            Some(notation) => {
                let entry = |text: &&str| {
                    let formula = notation.read(text);
                    formula.map_or_else(|| Block::line(text), |formula: Formula| formula.block())
                };
                let entries: Vec<Vec<Block>> = rows.iter().map(|row| row.iter().map(entry).collect()).collect();
                Block::matrix(&entries).lines().map(str::to_owned).collect()
            }
            None => {
                let mut table = plain();
                table.add_rows(rows);
                lines(&mut table)
            }
        });
        let mut out = String::new();
        if let Some(lines) = lines.filter(|lines| lines.iter().all(|line| line.width() + 2 <= self.style.width)) {
            out.push_str(&format!("{heading}\n"));
            out.extend(lines.iter().map(|line| format!("  {line}\n")));
        } else {
            let (remark, entries) = matrix.listed();
            out.push_str(&format!("{heading}, {remark}entries that are not zero:\n"));
            let width = self.style.width.saturating_sub(2);
            out.extend(entries.iter().flat_map(|line| self.line(line, width)).map(|line| format!("  {line}\n")));
        }
        out
    }
}
