//! What those who embed the library rely on.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "tests stop at the first surprise"
)]

fn crosses_threads<T: Send + Sync + 'static>() {}

#[test]
fn everything_can_cross_threads() {
    use librate::{diagnostic, span, syntax};
    crosses_threads::<span::Span>();
    crosses_threads::<diagnostic::Diagnostic>();
    crosses_threads::<syntax::File>();
    crosses_threads::<syntax::SyntaxError>();
    #[cfg(feature = "engine")]
    {
        use librate::{expr, linearize, model, modes, number, oscillation, precision};
        crosses_threads::<number::Number>();
        crosses_threads::<precision::Ball>();
        crosses_threads::<expr::Pool>();
        crosses_threads::<expr::Tape>();
        crosses_threads::<model::Model>();
        crosses_threads::<model::ModelError>();
        crosses_threads::<model::Settings>();
        crosses_threads::<model::TableTexts>();
        crosses_threads::<model::Warning>();
        crosses_threads::<linearize::Linearized>();
        crosses_threads::<linearize::LinearizeError>();
        crosses_threads::<linearize::SymbolicMatrices>();
        crosses_threads::<modes::Problem>();
        crosses_threads::<modes::Spectrum>();
        crosses_threads::<modes::ModesError>();
        crosses_threads::<oscillation::NormalModes>();
        crosses_threads::<oscillation::Warning>();
        crosses_threads::<librate::Error>();
    }
    #[cfg(feature = "cli")]
    crosses_threads::<librate::report::Style>();
}

/// No global state: the same model gives the same result on many threads at once.
#[cfg(feature = "engine")]
#[test]
fn threads_do_not_disturb_each_other() {
    use librate::{linearize, model, modes, oscillation, syntax};
    let omega = |stiffness: usize| {
        let text = format!(
            "param k = {stiffness}  coord x, y
             T = 1/2*x'^2 + 1/2*y'^2  V = 1/2*k*x^2 + 1/2*(x - y)^2 + exp(y) - y"
        );
        let file = syntax::parse(&text).unwrap();
        let model = model::elaborate(&file, &Default::default(), &Default::default()).unwrap();
        let linearized = linearize::linearize(model).unwrap();
        let normal = oscillation::normal_modes(&linearized, &modes::Options::default()).unwrap();
        let all = normal.modes.iter();
        all.map(|mode| mode.omega.mid_f64()).collect::<Vec<_>>()
    };
    let alone: Vec<_> = (1..9).map(omega).collect();
    let together: Vec<_> = std::thread::scope(|scope| {
        let threads: Vec<_> = (1..9).map(|k| scope.spawn(move || omega(k))).collect();
        let results = threads.into_iter().map(|thread| thread.join().unwrap());
        results.collect()
    });
    assert_eq!(alone, together);
}

/// What an editor does while somebody types: every beginning of a file is answered with a tree or
/// with mistakes that have a place in it.
#[test]
fn every_beginning_of_a_file_is_answered() {
    use librate::{diagnostic::Diagnostic, syntax};
    let text = std::fs::read_to_string("models/three_pendulums.lag").unwrap();
    for end in (0..text.len()).filter(|end| text.is_char_boundary(*end)) {
        if let Err(errors) = syntax::parse(&text[..end]) {
            assert!(!errors.is_empty());
            for error in &errors {
                let diagnostic = Diagnostic::from(error);
                let label = diagnostic.primary.expect("a place");
                assert!(label.span.end as usize <= end && label.span.start <= label.span.end);
                assert!(diagnostic.code.is_some() && !diagnostic.message.is_empty());
            }
        }
    }
}
