//! What `librate` does beside small oscillations: motion in time, periods at finite amplitude, parametric resonance, bodies and
//! their inertia, parameter sets and sweeps. Like `librate_core` it is for librate's own crates and may change.
//!
//! The modules stand in reading order: a study uses only what stands above it.

pub mod flow;

mod mechanics;

mod digits;

mod source;

pub mod refine;

pub mod program;

pub mod code;

pub mod figure;

pub mod sensitivity;

pub mod inertia;

pub mod batch;

pub mod expect;

pub mod floquet;

pub mod motion;

pub mod equilibria;

pub mod period;

pub mod amplitude;

pub mod response;

mod error;

pub use digits::Digits;
pub use error::Error;
pub use source::Source;

pub mod sweep;

pub mod tracking;

pub mod grid;

pub mod chart;
