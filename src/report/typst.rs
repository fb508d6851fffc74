//! A page in Typst.

use super::markup::{Markup, Writer};
use super::page::{Page, words};
use librate_core::derive::Derivation;
use librate_core::typeset::Formula;

const TYPST: Markup = Markup {
    heading: ["\n== ", "\n"],
    paragraph: ["\n", ".\n"],
    list: ["\n", ".\n"],
    lead: ["", ":\n"],
    gap: "",
    most_columns: 12,
    has_lines: true,
    formula: |formula| format!("${}$", formula.typst()),
    escaped,
    display,
};

/// The same page as a Typst document, which can be included in others.
#[must_use]
pub fn derive_typst(derivation: &Derivation) -> String {
    let page = &Page::new(derivation);
    let mut out = "#set math.equation(numbering: \"(1)\")\n".to_owned();
    if let Some(name) = &page.model {
        out.push_str(&format!("\n= {}\n", escaped(&name.replace('_', " "))));
    }
    out + &TYPST.parts(page)
}

fn display(writer: &Writer<'_>, formula: &Formula, remark: &str) -> String {
    let quoted = |text: &str| if text.is_empty() { String::new() } else { format!("{text:?}") };
    let remark = words(remark, quoted, |formula| format!(" {} ", writer.notation.relation(formula).typst()));
    let space = if remark.is_empty() { "" } else { " wide " };
    format!("$ {}{space}{remark} $\n", formula.typst_display())
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
