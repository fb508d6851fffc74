//! Symbols: derivatives, laws, simplification, series.

mod deep;
mod derive;
#[cfg(feature = "engine")]
mod expr_support;
mod laws;
mod modular;
mod series;
mod simplify;
