//! A page in LaTeX.

use super::page::{Line, Matrix, Page, Part, capitalized, words};
use librate_core::typeset::{Formula, Notation};

/// Matrices of more columns than this are given by their entries: `amsmath` has no more.
const MOST_COLUMNS: usize = 10;

/// Writes a page: headings and displayed formulas to be read into a document that has the package `amsmath`, or with
/// `standalone` a whole document.
pub(super) fn write(page: &Page, standalone: bool) -> String {
    let writer = Writer { notation: &page.notation };
    let mut out = String::new();
    for part in &page.parts {
        out.push_str(&writer.part(part));
    }
    if !standalone {
        return out;
    }
    let title = page
        .model
        .as_deref()
        .map_or(String::new(), |name| format!("\\section*{{{}}}\n", escaped(&name.replace('_', " "))));
    format!(
        "\\documentclass{{article}}\n\\usepackage{{amsmath}}\n\\allowdisplaybreaks\n\\begin{{document}}\n\\sloppy\n{title}{out}\\end{{document}}\n"
    )
}

struct Writer<'a> {
    notation: &'a Notation,
}

impl Writer<'_> {
    fn part(&self, part: &Part) -> String {
        match part {
            Part::List(title, items) => {
                let items: Vec<String> = items.iter().map(|item| self.words(item)).collect();
                format!("{}: {}.\n\n", self.sentence(title), items.join(", "))
            }
            Part::Section(title, lines, _) => {
                let mut out = self.heading(title);
                lines.iter().for_each(|line| out.push_str(&self.line(line)));
                out
            }
            Part::Matrix(matrix) => self.heading(&matrix.title) + &self.entries(matrix),
            Part::Paragraph(words) => format!("\n{}.\n", self.sentence(words)),
            Part::Gap => "\n".to_owned(),
        }
    }

    fn heading(&self, title: &str) -> String {
        format!("\n\\subsection*{{{}}}\n", self.sentence(title))
    }

    fn line(&self, line: &Line) -> String {
        match line {
            Line::Formula(text, remark) => self.display(&self.notation.relation(text), remark),
            Line::Below(matrix) => self.entries(matrix),
            Line::Item(text, words) => {
                let formula = self.notation.relation(text).latex();
                format!("\n${formula}$: {}.\n", self.words(words))
            }
            Line::Words(words) => format!("\n{}.\n", self.sentence(words)),
        }
    }

    /// With a remark beside the formula, or below where there is no room.
    fn display(&self, formula: &Formula, remark: &str) -> String {
        let remark = remark.trim_start_matches([',', ' ']);
        let text = formula.latex_display();
        let fits = formula.fits_line(remark.chars().count());
        let (beside, below) = match () {
            () if remark.is_empty() => (String::new(), String::new()),
            () if fits => (format!(" \\qquad {}", self.beside(remark)), String::new()),
            () => (String::new(), format!("{}.\n", self.sentence(remark))),
        };
        format!("\\begin{{equation}}\n{text}{beside}\n\\end{{equation}}\n{below}")
    }

    /// Words within a formula.
    fn beside(&self, remark: &str) -> String {
        let text = |text: &str| if text.is_empty() { String::new() } else { format!("\\text{{{}}}", escaped(text)) };
        words(remark, text, |formula| self.notation.relation(formula).latex())
    }

    /// A small matrix as a whole; of a large one the entries that are not zero, the upper triangle standing for both.
    fn entries(&self, matrix: &Matrix) -> String {
        match matrix.formula(self.notation, MOST_COLUMNS).filter(|formula| formula.fits_line(0)) {
            Some(formula) => self.display(&formula, ""),
            None => {
                let (remark, entries) = matrix.listed();
                let entries = entries.map(|text| self.display(&self.notation.relation(&text), ""));
                self.sentence(&format!("{remark}the entries that are not zero:\n")) + &entries.collect::<String>()
            }
        }
    }

    fn sentence(&self, text: &str) -> String {
        self.words(&capitalized(text))
    }

    fn words(&self, text: &str) -> String {
        words(text, escaped, |formula| format!("${}$", self.notation.relation(formula).latex()))
    }
}

/// Text, not formula.
fn escaped(text: &str) -> String {
    let arrows = [("<->", "↔"), ("->", "→"), ("--", "—")];
    let text = arrows.iter().fold(text.to_owned(), |text, (from, to)| text.replace(from, to));
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '_' | '%' | '&' | '#' | '$' | '{' | '}' => {
                out.push('\\');
                out.push(c);
            }
            '\\' => out.push_str("\\textbackslash{}"),
            '^' => out.push_str("\\textasciicircum{}"),
            '~' => out.push_str("\\textasciitilde{}"),
            '↔' => out.push_str(r"$\leftrightarrow$"),
            '→' => out.push_str(r"$\to$"),
            '…' => out.push_str(r"\dots{}"),
            '—' => out.push_str("-{}-"),
            '<' | '>' | '|' => out.push_str(&format!("${c}$")),
            c if c.is_ascii() => out.push(c),
            // Classes of straight molecules.
            'Σ' => out.push_str("$\\Sigma$"),
            'Π' => out.push_str("$\\Pi$"),
            // What the language has none of outside comments.
            _ => out.push('?'),
        }
    }
    out
}
