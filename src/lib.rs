//! A language for small oscillations, and what it takes to get from a model file to normal modes
//! in which every printed digit is right.
//!
//! A physicist writes kinetic and potential energy the way they stand on the blackboard; the
//! library derives the mass and stiffness matrices at equilibrium symbolically, in exact numbers,
//! and computes frequencies and shapes with rigorous error bounds.
//!
//! # The whole trip
//!
//! Each arrow is one function from one public type to the next:
//!
//! ```text
//! text ──▶ syntax ──▶ model ──▶ linearized ──▶ normal modes ──▶ report
//!   syntax::parse  model::elaborate  linearize::linearize  oscillation::normal_modes
//! ```
//!
#![cfg_attr(feature = "engine", doc = "```")]
#![cfg_attr(not(feature = "engine"), doc = "```ignore")]
//! use librate::{linearize, model, oscillation, syntax};
//!
//! let text = "
//!     param g = 9.81  param l = 1
//!     coord theta
//!     T = 1/2*l^2*theta'^2
//!     V = g*l*(1 - cos(theta))
//! ";
//! let file = syntax::parse(text).map_err(|errors| errors[0].clone())?;
//! let model = model::elaborate(&file, &Default::default(), &Default::default())
//!     .map_err(|errors| errors[0].clone())?;
//! let linearized = linearize::linearize(model)?;
//! let normal = oscillation::normal_modes(&linearized, &Default::default())?;
//! let omega = &normal.modes[0].omega;
//! assert_eq!(omega.mid_f64(), 9.81_f64.sqrt());
//! assert!(omega.radius < 1e-29);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Tools that only read model files build with `default-features = false`: the parser, the syntax
//! tree and the diagnostics stand on pest and thiserror alone; the feature `format` adds the
//! canonical layout of model files. Results as text and JSON come with
//! the feature `cli`.
//!
//! The modules stand in reading order: a stage uses only what stands above it.

pub mod span;

pub mod explain;

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

#[cfg(feature = "engine")]
pub mod oscillation;

#[cfg(feature = "engine")]
pub mod batch;

#[cfg(feature = "engine")]
mod error;

#[cfg(feature = "engine")]
pub use error::Error;

#[cfg(feature = "cli")]
pub mod report;
