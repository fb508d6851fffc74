//! A page in Typst.

use super::page::{Line, Matrix, Page, Part, capitalized, words};
use librate_core::typeset::{Formula, Notation};

/// Matrices of more columns than this are given by their entries.
const MOST_COLUMNS: usize = 12;

/// Writes a page: a document, which can be included in another one.
pub(super) fn write(page: &Page) -> String {
    let notation = &page.notation;
    let mut out = "#set math.equation(numbering: \"(1)\")\n".to_owned();
    if let Some(name) = &page.model {
        out.push_str(&format!("\n= {}\n", escaped(&name.replace('_', " "))));
    }
    for part in &page.parts {
        match part {
            Part::List(title, items) => {
                out.push_str(&format!("\n{}.\n", sentence(&format!("{title}: {}", items.join(", ")), notation)));
            }
            Part::Section(title, lines, _) => {
                out.push_str(&format!("\n== {}\n", sentence(title, notation)));
                lines.iter().for_each(|own| out.push_str(&line(own, notation)));
            }
            Part::Matrix(own) => {
                out.push_str(&format!("\n== {}\n{}", sentence(&own.title, notation), entries(own, notation)));
            }
            Part::Paragraph(words) => out.push_str(&format!("\n{}.\n", sentence(words, notation))),
            Part::Gap => {}
        }
    }
    out
}

fn line(line: &Line, notation: &Notation) -> String {
    match line {
        Line::Formula(text, remark) => {
            let formula = notation.relation(text);
            let remark = remark.trim_start_matches([',', ' ']);
            let remark = words(
                remark,
                |text| if text.is_empty() { String::new() } else { format!("{text:?}") },
                |formula| format!(" {} ", notation.relation(formula).typst()),
            );
            display(&formula, &remark)
        }
        Line::Below(matrix) => entries(matrix, notation),
        Line::Item(text, words) => format!("\n${}$: {}.\n", notation.relation(text).typst(), marked(words, notation)),
        Line::Words(words) => format!("\n{}.\n", sentence(words, notation)),
    }
}

fn display(formula: &Formula, remark: &str) -> String {
    let space = if remark.is_empty() { "" } else { " wide " };
    format!("$ {}{space}{remark} $\n", formula.typst_display())
}

/// A small matrix as a whole, of a large one the entries that are not zero.
fn entries(matrix: &Matrix, notation: &Notation) -> String {
    match matrix.formula(notation, MOST_COLUMNS).filter(|formula| formula.fits_line(0)) {
        Some(formula) => display(&formula, ""),
        None => {
            let (remark, entries) = matrix.listed();
            let entries = entries.map(|text| display(&notation.relation(&text), ""));
            sentence(&format!("{remark}the entries that are not zero:\n"), notation) + &entries.collect::<String>()
        }
    }
}

fn sentence(text: &str, notation: &Notation) -> String {
    marked(&capitalized(text), notation)
}

fn marked(text: &str, notation: &Notation) -> String {
    words(text, escaped, |formula| format!("${}$", notation.relation(formula).typst()))
}

/// Text, not markup.
fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.replace("<->", "↔").replace("->", "→").chars() {
        if "\\#$*_`<>@[]=~-+/".contains(c) {
            out.push('\\');
        }
        out.push(c);
    }
    out
}
