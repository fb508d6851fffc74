//! Symbols: derivatives, laws, simplification, series.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "tests stop at the first surprise"
)]

mod deep;
mod derive;
#[cfg(feature = "engine")]
mod expr_support;
mod laws;
mod modular;
mod series;
mod simplify;
