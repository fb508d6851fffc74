//! A page in LaTeX.

use super::markup::{Markup, Writer};
use super::page::{Page, words};
use librate_core::derive::Derivation;
use librate_core::typeset::Formula;

const LATEX: Markup = Markup {
    heading: ["\n\\subsection*{", "}\n"],
    paragraph: ["\n", ".\n"],
    list: ["", ".\n\n"],
    lead: ["", ":\n"],
    gap: "\n",
    // `amsmath` has no more.
    most_columns: 10,
    has_lines: true,
    formula: |formula| format!("${}$", formula.latex()),
    escaped,
    display,
};

/// The same page in LaTeX: headings and numbered formulas to be read into a document that has the package `amsmath`, or with
/// `standalone` a whole document. No line is wider than a page of the class `article`.
#[must_use]
pub fn derive_latex(derivation: &Derivation, standalone: bool) -> String {
    let page = &Page::new(derivation);
    let out = LATEX.parts(page);
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

/// With a remark beside the formula, or below where there is no room.
fn display(writer: &Writer<'_>, formula: &Formula, remark: &str) -> String {
    let text = formula.latex_display();
    let fits = formula.fits_line(remark.chars().count());
    let (beside, below) = match () {
        () if remark.is_empty() => (String::new(), String::new()),
        () if fits => (format!(" \\qquad {}", beside(writer, remark)), String::new()),
        () => (String::new(), format!("{}.\n", writer.sentence(remark))),
    };
    format!("\\begin{{equation}}\n{text}{beside}\n\\end{{equation}}\n{below}")
}

/// Words within a formula.
fn beside(writer: &Writer<'_>, remark: &str) -> String {
    let text = |text: &str| if text.is_empty() { String::new() } else { format!("\\text{{{}}}", escaped(text)) };
    words(remark, text, |formula| writer.notation.relation(formula).latex())
}

/// Text, not formula.
fn escaped(text: &str) -> String {
    let arrows = [("<->", "↔"), ("->", "→"), ("--", "—")];
    let text = arrows.iter().fold(text.to_owned(), |text, (from, to)| text.replace(from, to));
    let mut out = String::with_capacity(text.len());
    let raised = |c: char| "⁰¹²³⁴⁵⁶⁷⁸⁹⁻".chars().zip("0123456789-".chars()).find(|(own, _)| *own == c);
    for c in text.chars() {
        match c {
            '_' | '%' | '&' | '#' | '$' | '{' | '}' => {
                out.push('\\');
                out.push(c);
            }
            '\\' => out.push_str("\\textbackslash{}"),
            '^' => out.push_str("\\textasciicircum{}"),
            '·' => out.push_str(r"$\cdot$"),
            '±' => out.push_str(r"$\pm$"),
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
            c => out.push_str(&raised(c).map_or("?".to_owned(), |(_, digit)| format!("\\textsuperscript{{{digit}}}"))),
        }
    }
    out
}
