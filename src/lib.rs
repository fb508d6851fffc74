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
//! use librate::{Error, derive, linearize, model, modes, oscillation, syntax};
//!
//! let file = syntax::parse("param k = 4  param m = 1  coord x  T = 1/2*m*x'^2  V = 1/2*k*x^2")?;
//! let mut settings = Settings::new();
//! settings.add("m = 1/4")?;
//! let model = model::elaborate(&file, &TableTexts::new(), &settings)?;
//! assert!(model.warnings(&file).is_empty());
//!
//! let derivation = derive::derive(&model, &derive::Parts::default())?;
//! let linear = derivation.linear?;
//! assert_eq!(derivation.pool.display(linear.stiffness[0][0]), "k");
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
//! Enums of errors and structs of results are open (`#[non_exhaustive]`): they grow with minor versions. The kinds of the
//! syntax tree, of expressions and of results are closed, so that a tool that walks them learns of a new one from its
//! compiler; a new one is a new major version. Codes, JSON fields and the language itself only grow.
//!
//! The modules stand in reading order: a stage uses only what stands above it. They name what one calls, makes, matches on or
//! takes in a function of one's own. The parts of results are in the crates `librate-core` and `librate-studies`, where links
//! lead: their fields and methods are as public as the results that hold them. What else is public there is for librate alone
//! and may change at any time.

/// Places in a text. In full: [`librate_core::span`].
pub mod span {
    pub use librate_core::span::Span;
}

/// Errors and warnings as data: a message, a code, places, the fix. In full: [`librate_core::diagnostic`].
pub mod diagnostic {
    pub use librate_core::diagnostic::{Diagnostic, Label, Replacement, Severity, nearest, replaced};
}

/// A page on each code. In full: [`librate_core::explain`].
pub mod explain {
    pub use librate_core::explain::{codes, explain};
}

/// From text to a syntax tree, and back. In full: [`librate_core::syntax`].
pub mod syntax {
    #[cfg(feature = "format")]
    pub use librate_core::syntax::format;
    pub use librate_core::syntax::{
        Binding, Comparison, Drawn, Expr, ExprKind, ExprRef, FUNCTIONS, File, IndexKind, Indices, MOST_BYTES, Name,
        NameKind, NamePlace, STATEMENT_WORDS, Statement, StatementKind, SyntaxError, UnitKind, names, parse,
        parse_changed, parse_readable, print_expr, print_statement, reserved_meaning, signature,
    };
}

/// Syntax trees as formulas, in LaTeX and in Unicode. In full: [`librate_core::typeset`].
#[cfg(feature = "format")]
pub mod typeset {
    pub use librate_core::typeset::{Formula, Notation};
}

#[cfg(feature = "engine")]
mod engine {
    /// A limit on memory and work that all stages share. In full: [`librate_core::budget`].
    pub mod budget {
        pub use librate_core::budget::{Budget, Exceeded, Limit, Limits};
    }

    /// Exact rational numbers. In full: [`librate_core::number`].
    pub mod number {
        pub use librate_core::number::Number;
    }

    /// Numbers with rigorous bounds, and the digits that these decide. In full: [`librate_core::precision`].
    pub mod precision {
        pub use librate_core::precision::{Ball, Big, Rounding, Scalar, decimal};
    }

    /// Expressions, canonical and shared: what matrices and derivations are made of. In full: [`librate_core::expr`].
    pub mod expr {
        pub use librate_core::expr::{ExprId, Function, Node, Pool, Symbol, Tape, ZeroVerdict};
    }

    /// What the text means: names, shapes, ranges, tables, settings. In full: [`librate_core::model`].
    pub mod model {
        pub use librate_core::model::{
            Constant, Dimension, Model, ModelError, Parameter, Range, Settings, TableTexts, constants,
            coordinate_count, dimensions, elaborate, mistakes, parse, unit_dimension, unit_names, units_with_prefixes,
        };
    }

    /// The equilibrium, and the matrices there, in symbols and in numbers with bounds. In full: [`librate_core::linearize`].
    pub mod linearize {
        pub use librate_core::linearize::{
            Feature, LinearizeError, Linearized, Structure, check_size, constant, linearize,
        };
    }

    /// What is wanted of the modes, and what they are called. In full: [`librate_core::modes`].
    pub mod modes {
        pub use librate_core::modes::{Kind, Method, Options, PrecisionLevel, Stability, exponents::Limit};
    }

    /// Normal modes with the names and units of the model. In full: [`librate_core::oscillation`].
    pub mod oscillation {
        pub use librate_core::oscillation::{NormalMode, NormalModes, normal_modes};
    }

    /// The derivation, to read. In full: [`librate_core::derive`].
    pub mod derive {
        pub use librate_core::derive::{
            CHAPTERS, Conserved, Derivation, Motion, MotionSum, Parts, derive, in_independent_coordinates, linearized,
        };
    }

    /// How frequencies follow uncertain parameters. In full: [`librate_studies::sensitivity`].
    pub mod sensitivity {
        pub use librate_studies::sensitivity::{Sensitivities, ignored, put_uncertainties, sensitivities};
    }

    /// Masses, centres and inertia tensors of bodies. In full: [`librate_studies::inertia`].
    pub mod inertia {
        pub use librate_studies::inertia::{
            Amount, Body, InertiaError, Mesh, NamedTensor, of_model, of_points, warnings,
        };
    }

    /// One model, thousands of parameter sets. In full: [`librate_studies::batch`].
    pub mod batch {
        pub use librate_studies::batch::{Options, Outcome, Solutions, Study, StudyError};
    }

    /// A model as functions for other languages. In full: [`librate_studies::code`].
    pub mod code {
        pub use librate_studies::code::{Code, code};
    }

    /// Derivations compared with what they should be, for tests. In full: [`librate_studies::expect`].
    pub mod expect {
        pub use librate_studies::expect::{Expected, Mismatches, are_equal};
    }

    /// Periodic motion, periodic coefficients: multipliers, exponents, resonances. In full: [`librate_studies::floquet`].
    pub mod floquet {
        pub use librate_studies::floquet::{Floquet, FloquetError, Options, Place, floquet};
    }

    /// Motion in time. In full: [`librate_studies::motion`].
    pub mod motion {
        pub use librate_studies::motion::{Enclosed, MotionError, Start, System, Times, Trajectory, superposition};
    }

    /// The period at finite amplitude. In full: [`librate_studies::period`].
    pub mod period {
        pub use librate_studies::period::{
            Motion, Options, Oscillator, Period, PeriodError, Place, Request, curve, place,
        };
    }

    /// How frequencies begin to change with the amplitude. In full: [`librate_studies::amplitude`].
    pub mod amplitude {
        pub use librate_studies::amplitude::{AmplitudeError, Amplitudes, Obstacle, amplitude, check};
    }

    /// The points of a model and the lines between them. In full: [`librate_studies::figure`].
    pub mod figure {
        pub use librate_studies::figure::{Figure, figure};
    }

    /// The steady response to a harmonic force. In full: [`librate_studies::response`].
    pub mod response {
        pub use librate_studies::response::{PeakKind, Peaks, Request, Response, ResponseError, Study, Value};
    }

    /// Every equilibrium in a box. In full: [`librate_studies::equilibria`].
    pub mod equilibria {
        pub use librate_studies::equilibria::{
            Diagram, EquilibriaError, Equilibrium, Found, Kind, Region, find, follow, landscape,
        };
    }

    /// The modes over a range of a parameter. In full: [`librate_studies::sweep`].
    pub mod sweep {
        pub use librate_studies::sweep::{Place, Sweep, Worker};
    }

    /// Modes followed by their shapes over a range of a parameter. In full: [`librate_studies::tracking`].
    pub mod tracking {
        pub use librate_studies::tracking::{Tracked, branches};
    }

    /// More places where curves bend. In full: [`librate_studies::refine`].
    pub mod refine {
        pub use librate_studies::refine::{finest, refined};
    }

    /// Modes over a grid of one or two parameters. In full: [`librate_studies::grid`].
    pub mod grid {
        pub use librate_studies::grid::{Grid, GridError, Nodes};
    }

    /// Charts of stability over two parameters. In full: [`librate_studies::chart`].
    pub mod chart {
        pub use librate_studies::chart::{Chart, Place};
    }

    pub use librate_studies::{Error, Source, assert_derives};
}

#[cfg(feature = "engine")]
pub use engine::*;

/// Results in writing.
#[cfg(feature = "report")]
pub mod report {
    pub use librate_report::*;
}
