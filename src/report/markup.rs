//! Pages in a markup: what LaTeX, HTML and Typst have in common.

use super::page::{Line, Matrix, Page, Part, capitalized, words};
use librate_core::typeset::{Formula, Notation};

/// How a markup writes what a page consists of: pairs stand before and behind it.
pub(super) struct Markup {
    pub(super) heading: [&'static str; 2],
    pub(super) paragraph: [&'static str; 2],
    pub(super) list: [&'static str; 2],
    /// Words that formulas follow.
    pub(super) lead: [&'static str; 2],
    pub(super) gap: &'static str,
    /// Matrices of more columns than this are given by their entries.
    pub(super) most_columns: usize,
    /// Whether a matrix has to fit on a line.
    pub(super) has_lines: bool,
    /// A formula among words.
    pub(super) formula: fn(&Formula) -> String,
    /// Words, not markup.
    pub(super) escaped: fn(&str) -> String,
    /// A formula on a line of its own, with a remark.
    pub(super) display: fn(&Writer<'_>, &Formula, &str) -> String,
}

impl Markup {
    /// All parts of a page.
    pub(super) fn parts(&self, page: &Page) -> String {
        let writer = Writer { markup: self, notation: &page.notation };
        page.parts.iter().map(|part| writer.part(part)).collect()
    }
}

/// Writes the parts of a page.
pub(super) struct Writer<'a> {
    markup: &'a Markup,
    pub(super) notation: &'a Notation,
}

fn between([before, behind]: [&str; 2], text: &str) -> String {
    format!("{before}{text}{behind}")
}

impl Writer<'_> {
    fn part(&self, part: &Part) -> String {
        let own = self.markup;
        let heading = |title: &str| between(own.heading, &self.sentence(title));
        match part {
            Part::List(title, items) => between(own.list, &self.sentence(&format!("{title}: {}", items.join(", ")))),
            Part::Section(title, lines, _) => {
                heading(title) + &lines.iter().map(|own| self.line(own)).collect::<String>()
            }
            Part::Matrix(matrix) => heading(&matrix.title) + &self.entries(matrix),
            Part::Paragraph(words) => between(own.paragraph, &self.sentence(words)),
            Part::Gap => own.gap.to_owned(),
        }
    }

    fn line(&self, line: &Line) -> String {
        match line {
            Line::Formula(text, remark) => self.display(text, remark.trim_start_matches([',', ' '])),
            Line::Below(matrix) => self.entries(matrix),
            Line::Item(text, words) => {
                let formula = (self.markup.formula)(&self.notation.relation(text));
                between(self.markup.paragraph, &format!("{formula}: {}", self.marked(words)))
            }
            Line::Words(words) => between(self.markup.paragraph, &self.sentence(words)),
        }
    }

    fn display(&self, text: &str, remark: &str) -> String {
        (self.markup.display)(self, &self.notation.relation(text), remark)
    }

    /// A small matrix as a whole; of a large one the entries that are not zero, the upper triangle standing for both.
    fn entries(&self, matrix: &Matrix) -> String {
        let whole = matrix.formula(self.notation, self.markup.most_columns);
        match whole.filter(|formula| !self.markup.has_lines || formula.fits_line(0)) {
            Some(formula) => (self.markup.display)(self, &formula, ""),
            None => {
                let (remark, entries) = matrix.listed();
                let lead = self.sentence(&format!("{remark}the entries that are not zero"));
                between(self.markup.lead, &lead) + &entries.iter().map(|own| self.line(own)).collect::<String>()
            }
        }
    }

    pub(super) fn sentence(&self, text: &str) -> String {
        self.marked(&capitalized(text))
    }

    /// Words with the formulas among them.
    pub(super) fn marked(&self, text: &str) -> String {
        words(text, self.markup.escaped, |formula| (self.markup.formula)(&self.notation.relation(formula)))
    }
}
