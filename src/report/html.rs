//! A page as HTML with MathML.

use super::markup::Markup;
use super::page::Page;
use librate_core::derive::Derivation;

const HTML: Markup = Markup {
    heading: ["<h3>", "</h3>\n"],
    paragraph: ["<p>", ".</p>\n"],
    list: ["<p>", ".</p>\n"],
    lead: ["<p>", ":</p>\n"],
    gap: "",
    most_columns: 12,
    has_lines: false,
    formula: |formula| formula.mathml(false),
    escaped,
    display: |writer, formula, remark| {
        let remark = writer.marked(remark);
        let remark = if remark.is_empty() { remark } else { format!("<span>{remark}</span>") };
        format!("<div class=\"formula\">{}{remark}</div>\n", formula.mathml(true))
    },
};

const STYLE: &str = "<style>
.librate { max-width: 60rem; counter-reset: equation; }
.librate .formula { display: flex; align-items: center; gap: 1rem; overflow: auto hidden; padding: 0.5em 0; margin: 0.1em 0; counter-increment: equation; }
.librate .formula math { flex: 1 0 auto; }
.librate .formula::after { content: '(' counter(equation) ')'; }
</style>
";

/// The same page as an HTML element `article` with its style, whose formulas are MathML; it is XML too.
#[must_use]
pub fn derive_html(derivation: &Derivation) -> String {
    let page = &Page::new(derivation);
    let mut out = format!("<article class=\"librate\">\n{STYLE}");
    if let Some(name) = &page.model {
        out.push_str(&format!("<h2>{}</h2>\n", escaped(&name.replace('_', " "))));
    }
    out.push_str(&HTML.parts(page));
    out.push_str("</article>\n");
    out
}

/// Text, not markup.
fn escaped(text: &str) -> String {
    text.replace("<->", "↔").replace("->", "→").replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}
