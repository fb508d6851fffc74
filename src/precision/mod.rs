//! precision
mod scalar;
pub use scalar::{Function, Scalar};
