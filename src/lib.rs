//! librate
pub mod span;
pub mod diagnostic;
pub mod syntax;
#[cfg(feature = "engine")]
pub mod number;
#[cfg(feature = "engine")]
pub mod precision;
#[cfg(feature = "engine")]
pub mod expr;
#[cfg(feature = "engine")]
pub mod model;
#[cfg(feature = "engine")]
pub mod linearize;
#[cfg(feature = "engine")]
pub mod modes;
#[cfg(feature = "cli")]
pub mod report;
#[cfg(feature = "engine")]
mod error;
#[cfg(feature = "engine")]
pub use error::Error;
