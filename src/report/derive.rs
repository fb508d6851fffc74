//! Derivations as pages to read.

use super::page::Page;
use super::{Style, html, latex, plain, typst};
use librate_core::derive::Derivation;

/// The derivation as text, in the order of the page: Lagrange's equations, momenta and what is
/// conserved, the equilibrium, T and V to second order, M, K, the linearized equations, symmetry and
/// closed forms of the frequencies.
///
/// What would be repeated too often is given a name at the top. Matrices have aligned columns where they fit into the width, else their entries that are not
/// zero stand one a line, with the upper triangle standing for both.
#[must_use]
pub fn derive_text(derivation: &Derivation, style: &Style) -> String {
    plain::write(&Page::new(derivation), style)
}

/// The same page in LaTeX: headings and numbered formulas to be read into a document that has the package `amsmath`, or with
/// `standalone` a whole document. No line is wider than a page of the class `article`.
#[must_use]
pub fn derive_latex(derivation: &Derivation, standalone: bool) -> String {
    latex::write(&Page::new(derivation), standalone)
}

/// The same page as an HTML element `article` with its style, whose formulas are MathML; it is XML too.
#[must_use]
pub fn derive_html(derivation: &Derivation) -> String {
    html::write(&Page::new(derivation))
}

/// The same page as a Typst document, which can be included in others.
#[must_use]
pub fn derive_typst(derivation: &Derivation) -> String {
    typst::write(&Page::new(derivation))
}
