//! A page as HTML with MathML.

use super::page::{Line, Matrix, Page, Part, capitalized, words};
use librate_core::typeset::{Formula, Notation};

/// Matrices of more columns than this are given by their entries.
const MOST_COLUMNS: usize = 12;

const STYLE: &str = "<style>
.librate { max-width: 60rem; counter-reset: equation; }
.librate .formula { display: flex; align-items: center; gap: 1rem; overflow-x: auto; margin: 0.6em 0; counter-increment: equation; }
.librate .formula math { flex: 1 0 auto; }
.librate .formula::after { content: '(' counter(equation) ')'; }
</style>
";

/// Writes a page: an element `article`, which is well-formed XML.
pub(super) fn write(page: &Page) -> String {
    let notation = &page.notation;
    let mut out = format!("<article class=\"librate\">\n{STYLE}");
    if let Some(name) = &page.model {
        out.push_str(&format!("<h2>{}</h2>\n", escaped(&name.replace('_', " "))));
    }
    for part in &page.parts {
        match part {
            Part::List(title, items) => {
                let items = items.join(", ");
                out.push_str(&format!("<p>{}.</p>\n", sentence(&format!("{title}: {items}"), notation)));
            }
            Part::Section(title, lines, _) => {
                out.push_str(&format!("<h3>{}</h3>\n", sentence(title, notation)));
                lines.iter().for_each(|own| out.push_str(&line(own, notation)));
            }
            Part::Matrix(own) => {
                out.push_str(&format!("<h3>{}</h3>\n{}", sentence(&own.title, notation), entries(own, notation)));
            }
            Part::Paragraph(words) => out.push_str(&format!("<p>{}.</p>\n", sentence(words, notation))),
            Part::Gap => {}
        }
    }
    out.push_str("</article>\n");
    out
}

fn line(line: &Line, notation: &Notation) -> String {
    match line {
        Line::Formula(text, remark) => {
            let remark = marked(remark.trim_start_matches([',', ' ']), notation);
            let remark = if remark.is_empty() { remark } else { format!("<span>{remark}</span>") };
            display(&notation.relation(text), &remark)
        }
        Line::Below(matrix) => entries(matrix, notation),
        Line::Item(text, words) => {
            format!("<p>{}: {}.</p>\n", notation.relation(text).mathml(false), marked(words, notation))
        }
        Line::Words(words) => format!("<p>{}.</p>\n", sentence(words, notation)),
    }
}

fn display(formula: &Formula, remark: &str) -> String {
    format!("<div class=\"formula\">{}{remark}</div>\n", formula.mathml(true))
}

/// A small matrix as a whole, of a large one the entries that are not zero.
fn entries(matrix: &Matrix, notation: &Notation) -> String {
    match matrix.formula(notation, MOST_COLUMNS) {
        Some(formula) => display(&formula, ""),
        None => {
            let (remark, entries) = matrix.listed();
            let remark = sentence(&format!("{remark}the entries that are not zero"), notation);
            let entries = entries.map(|text| display(&notation.relation(&text), ""));
            format!("<p>{remark}:</p>\n") + &entries.collect::<String>()
        }
    }
}

fn sentence(text: &str, notation: &Notation) -> String {
    marked(&capitalized(text), notation)
}

fn marked(text: &str, notation: &Notation) -> String {
    words(text, escaped, |formula| notation.relation(formula).mathml(false))
}

/// Text, not markup.
fn escaped(text: &str) -> String {
    let arrows = text.replace("<->", "↔").replace("->", "→");
    arrows.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}
