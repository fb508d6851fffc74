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
pub mod modes;
