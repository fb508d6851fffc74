//! The derivation to read.

use super::table::{lines, plain};
use super::{Style, Tone, headline, listed};
use crate::expr::ExprId;
use crate::linearize::SymbolicMatrices;
use crate::number::Number;

/// M and K as text: matrices with aligned columns where they fit into the width, else their
/// entries that are not zero, one a line, with the upper triangle standing for both.
#[must_use]
pub fn derive_text(name: Option<&str>, matrices: &SymbolicMatrices, style: &Style) -> String {
    let count = matrices.coordinates.len();
    let mut out = style.paint(Tone::Heading, &headline(name, count));
    out.push('\n');
    out.push_str(&listed("coordinates", &matrices.coordinates, style.width));
    out.push_str(&equilibrium_text(matrices, style));
    for (title, letter, rows) in [
        ("mass matrix", "M", &matrices.mass),
        ("stiffness matrix", "K", &matrices.stiffness),
    ] {
        out.push('\n');
        out.push_str(&matrix_text(title, letter, rows, matrices, style));
    }
    out
}

fn equilibrium_text(matrices: &SymbolicMatrices, style: &Style) -> String {
    let pool = &matrices.pool;
    let zero = |at: &ExprId| pool.as_number(*at).is_some_and(Number::is_zero);
    if matrices.equilibrium.iter().all(zero) {
        return "equilibrium: all coordinates 0\n".to_owned();
    }
    let mut searched = Vec::new();
    let mut items = Vec::new();
    for (name, value) in matrices.coordinates.iter().zip(&matrices.equilibrium) {
        let text = pool.display(*value);
        if text == *name {
            searched.push(name.clone());
        } else {
            items.push(format!("{name} = {text}"));
        }
    }
    let mut out = String::new();
    if !items.is_empty() {
        out.push_str(&listed("equilibrium", &items, style.width));
    }
    if !searched.is_empty() {
        let title = "equilibrium found numerically; standing for its value below";
        out.push_str(&listed(title, &searched, style.width));
    }
    out
}

fn matrix_text(
    title: &str,
    letter: &str,
    rows: &[Vec<ExprId>],
    matrices: &SymbolicMatrices,
    style: &Style,
) -> String {
    let pool = &matrices.pool;
    let zero = |at: ExprId| pool.as_number(at).is_some_and(Number::is_zero);
    let heading = style.paint(Tone::Heading, &format!("{title} {letter}"));
    // A matrix that can't fit is not written out only to be measured.
    if rows.len() * 3 <= style.width {
        let mut table = plain();
        for row in rows {
            table.add_row(row.iter().map(|at| pool.display(*at)));
        }
        let lines = lines(&mut table);
        if lines
            .iter()
            .all(|line| line.chars().count() + 2 <= style.width)
        {
            let body: String = lines.iter().map(|line| format!("  {line}\n")).collect();
            return format!("{heading}\n{body}");
        }
    }
    let mut out = format!("{heading}, symmetric; entries that are not zero:\n");
    for (i, row) in rows.iter().enumerate() {
        for (j, at) in row.iter().enumerate().skip(i) {
            if !zero(*at) {
                let text = pool.display(*at);
                out.push_str(&format!("  {letter}[{}, {}] = {text}\n", i + 1, j + 1));
            }
        }
    }
    out
}
