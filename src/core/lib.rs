//! From a text to normal modes: the stages of `librate`, for its own crates. Whoever uses librate uses the crate
//! [`librate`](https://docs.rs/librate), which says what is public; here everything is that another of its crates or a test
//! needs, and any of it may change.
//!
//! The modules stand in reading order: a stage uses only what stands above it.

pub mod span;

pub mod order;

pub mod explain;

pub mod diagnostic;

pub mod mistakes;

pub mod choices;

#[cfg(feature = "engine")]
pub mod groups;

pub mod syntax;
#[cfg(feature = "format")]
pub mod typeset;

#[cfg(feature = "engine")]
pub mod budget;

#[cfg(feature = "engine")]
pub mod number;

#[cfg(feature = "engine")]
pub mod precision;

#[cfg(feature = "engine")]
pub mod expr;

#[cfg(feature = "engine")]
mod polynomial;

#[cfg(feature = "engine")]
pub mod model;

#[cfg(feature = "engine")]
pub mod linearize;

#[cfg(feature = "engine")]
pub mod modes;

#[cfg(feature = "engine")]
pub mod symmetry;

#[cfg(feature = "engine")]
pub mod oscillation;

#[cfg(feature = "engine")]
pub mod derive;
