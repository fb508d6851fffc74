//! Modes and exponents: bounds, digits, hard cases, sensitivities, batches.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "tests stop at the first surprise")]

mod batch;
mod batch_exponents;
mod batch_pencils;
#[cfg(feature = "engine")]
mod batch_support;
#[cfg(feature = "engine")]
#[path = "../common/mod.rs"]
mod common;
mod exponents;
mod exponents_properties;
mod exponents_random;
mod families;
mod hard;
mod massless;
mod matrix_market;
mod models;
mod modes;
mod modes_precise;
mod modes_properties;
#[cfg(feature = "engine")]
mod modes_support;
mod rolling;
mod sensitivity;
mod sparse;
mod sparse_exponents;
mod sparse_memory;
