//! Derivations: equations, closed forms, normal coordinates, LaTeX, book forms.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "tests stop at the first surprise")]

mod assumptions;
mod book_forms;
mod closed_forms;
#[cfg(feature = "engine")]
#[path = "../common/mod.rs"]
mod common;
mod derivation_of_a_cart;
mod derive;
mod derive_constraints;
#[cfg(feature = "cli")]
mod derive_support;
mod exponents;
mod factored;
mod latex;
mod normal_coordinates;
mod pages;
mod rolling;
mod signs;
mod solved;
mod typeset;
