//! What must hold for any text, for the fuzzers and for the replay of what they have found.
#![allow(dead_code, unused_imports, reason = "every fuzz target uses one of the checks")]

#[path = "../tests/syntax_common/mod.rs"]
mod syntax_common;

use librate::diagnostic::Diagnostic;
use librate::span::Span;
use librate::syntax::{self, File};
use syntax_common::strip_spans;
#[cfg(feature = "engine")]
pub(crate) use trip::{tables, trip};

/// Parsing answers with a tree that prints to itself, or with mistakes that have a place.
pub(crate) fn parse(text: &str) {
    match syntax::parse(text) {
        Ok(file) => {
            places(text, &file);
            let printed = librate_core::syntax::print_file(&file);
            match syntax::parse(&printed) {
                Ok(again) => assert_eq!(strip_spans(&again), strip_spans(&file), "{printed}"),
                Err(errors) => panic!("{printed}\n{errors:#?}"),
            }
        }
        Err(errors) => answered(text, &errors.iter().map(Diagnostic::from).collect::<Vec<_>>()),
    }
}

/// The layout of a layout is itself, and its tree is the tree of the text.
pub(crate) fn format(text: &str) {
    let Ok(file) = syntax::parse(text) else {
        assert!(syntax::format(text).is_err());
        return;
    };
    let formatted = match syntax::format(text) {
        Ok(formatted) => formatted,
        Err(errors) => panic!("{errors:#?}"),
    };
    match syntax::parse(&formatted) {
        Ok(again) => assert_eq!(strip_spans(&again), strip_spans(&file), "{formatted}"),
        Err(errors) => panic!("{formatted}\n{errors:#?}"),
    }
    assert_eq!(syntax::format(&formatted).as_ref(), Ok(&formatted));
}

fn within(text: &str, span: Span) -> bool {
    text.get(span.range()).is_some()
}

fn places(text: &str, file: &File) {
    for statement in &file.statements {
        assert!(within(text, statement.span), "{statement:?}");
    }
    for expr in file.expressions.iter() {
        assert!(within(text, expr.span) && expr.span.start < expr.span.end, "{expr:?}");
    }
    for unit in file.units.iter() {
        assert!(within(text, unit.span) && unit.span.start < unit.span.end, "{unit:?}");
    }
    for comment in &file.comments {
        assert!(within(text, comment.span), "{comment:?}");
    }
}

/// Mistakes have messages, and places in the text.
pub(crate) fn answered(text: &str, diagnostics: &[Diagnostic]) {
    assert!(!diagnostics.is_empty(), "a mistake without a message");
    for diagnostic in diagnostics {
        assert!(!diagnostic.message.is_empty(), "{diagnostic:?}");
        for label in diagnostic.primary.iter().chain(&diagnostic.secondary) {
            assert!(within(text, label.span), "{diagnostic:?}");
        }
    }
}

#[cfg(feature = "engine")]
mod trip {
    use librate::model::{self, Settings, TableTexts};
    use librate::modes::Options;
    use librate::precision::Ball;
    use librate::{Error, linearize, oscillation, syntax};

    use super::answered;

    /// The longest text that [`trip`] takes, in bytes.
    const MOST_BYTES: usize = 4096;

    /// The most coordinates that [`trip`] takes.
    const MOST_COORDINATES: usize = 12;

    /// A small model is answered with finite modes, or with mistakes that have a place.
    pub(crate) fn trip(text: &str) {
        // A model may ask for as much work as it likes: with four digits for a million instances.
        let long_number = text.as_bytes().windows(4).any(|bytes| bytes.iter().all(u8::is_ascii_digit));
        if text.len() > MOST_BYTES || long_number {
            return;
        }
        if let Err(error) = modes(text) {
            answered(text, &error.diagnostics());
        }
    }

    /// What models that are fuzzed may read.
    pub(crate) fn tables() -> TableTexts {
        let text = "i,j,k,d,mass,x,y,z,name\n1,2,3,0.5,12,0,0,1,C\n2,3,4,1,16,1,0,0,O\n";
        let names = ["bonds.csv", "springs.csv", "atoms.csv", "data.csv"];
        names.into_iter().fold(TableTexts::new(), |tables, name| tables.with(name, text))
    }

    fn modes(text: &str) -> Result<(), Error> {
        let file = syntax::parse(text)?;
        let model = model::elaborate(&file, &tables(), &Settings::new())?;
        if model.coordinates.len() > MOST_COORDINATES {
            return Ok(());
        }
        let derived = librate_core::linearize::derive(model.clone());
        if let Ok(matrices) = &derived {
            for entry in matrices.mass.iter().chain(&matrices.stiffness).flatten() {
                assert!(!matrices.pool.display(*entry).is_empty());
            }
        }
        let linearized = linearize::linearize(model)?;
        let normal = oscillation::normal_modes(&linearized, &Options::default())?;
        derived?;
        for mode in &normal.modes {
            let square = mode.omega_squared.as_ref();
            for ball in square.into_iter().chain([&mode.omega, &mode.growth]) {
                finite(ball);
            }
            assert!(mode.omega.upper() >= 0.0);
            let conservative = linearized.structure() == linearize::Structure::Conservative;
            assert!(mode.growth.upper() >= 0.0 || !conservative);
            let parts = mode.vector.iter().chain(&mode.imaginary);
            assert!(parts.clone().all(|component| component.is_finite()));
            // In a group of exponents that are not told apart nothing may be known of a shape.
            assert!(mode.vector_error_bound.is_finite() || !conservative);
            assert!(mode.vector_error_bound >= 0.0);
        }
        Ok(())
    }

    fn finite(ball: &Ball) {
        assert!(ball.is_finite(), "{ball:?}");
        assert!(ball.lower() <= ball.upper(), "{ball:?}");
        assert!(ball.mid_f64_error() >= 0.0, "{ball:?}");
    }
}
