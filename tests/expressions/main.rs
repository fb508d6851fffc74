//! Numbers: fractions, enclosures and their digits. Symbols: derivatives, laws, simplification, series.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "tests stop at the first surprise")]

mod balls;
mod big;
mod convolutions;
mod decimals;
mod deep;
mod derive;
mod doubles;
mod dual;
mod elementary;
mod exact;
#[cfg(feature = "engine")]
mod expr_support;
mod laws;
mod magnitudes;
mod modular;
mod numbers;
mod series;
mod simplify;
