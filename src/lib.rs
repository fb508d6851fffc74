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
//! # What to call
//!
//! **An editor** parses while somebody types, draws what is wrong and formats on saving. It builds with
//! `default-features = false, features = ["format"]`, on pest, thiserror and unicode-width alone:
//!
#![cfg_attr(feature = "format", doc = "```")]
#![cfg_attr(not(feature = "format"), doc = "```ignore")]
//! use librate::{diagnostic::Diagnostic, explain, syntax};
//!
//! let errors = syntax::parse("coord x  T = 1/2*x'^2  V = 2 x").unwrap_err();
//! let diagnostic = Diagnostic::from(&errors[0]);
//! assert_eq!(diagnostic.code, Some("E0007"));
//! assert_eq!(diagnostic.help.as_deref(), Some("write `2*x`"));
//! assert!(explain::explain("E0007").is_some());
//!
//! assert_eq!(syntax::format("coord x\nT=1/2*x'^2")?, "coord x\nT = 1/2*x'^2\n");
//! # Ok::<(), Vec<syntax::SyntaxError>>(())
//! ```
//!
//! **A notebook** wants the [derivation](crate::derive) to look at, then numbers, with parameters set from outside:
//!
#![cfg_attr(feature = "engine", doc = "```")]
#![cfg_attr(not(feature = "engine"), doc = "```ignore")]
//! use librate::model::{Settings, TableTexts};
//! use librate::{Error, linearize, model, modes, oscillation, syntax};
//!
//! let file = syntax::parse("param k = 4  param m = 1  coord x  T = 1/2*m*x'^2  V = 1/2*k*x^2")?;
//! let mut settings = Settings::new();
//! settings.add("m = 1/4")?;
//! let model = model::elaborate(&file, &TableTexts::new(), &settings)?;
//! assert!(model::warnings(&file, &model).is_empty());
//!
//! let matrices = linearize::derive(model.clone())?;
//! assert_eq!(matrices.pool.display(matrices.stiffness[0][0]), "k");
//!
//! let linearized = linearize::linearize(model)?;
//! let options = modes::Options::default().digits(20);
//! let normal = oscillation::normal_modes(&linearized, &options)?;
//! assert_eq!(normal.modes[0].omega.mid_f64(), 4.0);
//! # Ok::<(), Error>(())
//! ```
//!
//! **A simulation** derives once and solves thousands of parameter sets in doubles with rigorous bounds:
//! [`batch::Study`](crate::batch). Nothing here keeps global state, and every type can cross threads, so
//! the sets may be dealt out to as many as there are.
//!
//! Errors are one enum a stage, collected in [`Error`](enum@crate::Error); each turns into a
//! [`Diagnostic`](diagnostic::Diagnostic) with a code, its places and the fix. The library never prints,
//! never panics on any input, and never reads a file it was not handed. Results as text, JSON, CSV, LaTeX and pictures come with
//! the feature `report`; the folder `schema` describes the JSON.
//!
//! # What may change
//!
//! Enums of errors and results and structs of results are open (`#[non_exhaustive]`): they grow with minor
//! versions. The kinds of the syntax tree are closed, so that a tool that walks it learns of a new form
//! from its compiler; a new form is a new major version. Codes, JSON fields and the language itself only
//! grow.
//!
//! The modules stand in reading order: a stage uses only what stands above it.

pub use librate_core::{diagnostic, explain, span, syntax};

#[cfg(feature = "format")]
pub use librate_core::typeset;

#[cfg(feature = "engine")]
pub use librate_core::{budget, derive, expr, linearize, model, modes, number, oscillation, precision, symmetry};
#[cfg(feature = "engine")]
pub use librate_studies::{
    Error, amplitude, assert_derives, batch, chart, expect, floquet, flow, inertia, motion, period, sensitivity, sweep,
};

#[cfg(feature = "report")]
pub use librate_report as report;
