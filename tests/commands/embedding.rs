//! What those who embed the library rely on.

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
        use librate::{expr, linearize, model, number, oscillation, precision};
        use librate_core::modes;
        crosses_threads::<number::Number>();
        crosses_threads::<precision::Ball>();
        crosses_threads::<expr::Pool>();
        crosses_threads::<expr::Tape>();
        crosses_threads::<model::Model>();
        crosses_threads::<model::ModelError>();
        crosses_threads::<model::Settings>();
        crosses_threads::<model::TableTexts>();
        crosses_threads::<linearize::Linearized>();
        crosses_threads::<linearize::LinearizeError>();
        crosses_threads::<modes::Problem>();
        crosses_threads::<modes::Spectrum>();
        crosses_threads::<modes::ModesError>();
        crosses_threads::<oscillation::NormalModes>();
        crosses_threads::<librate::Error>();
    }
    #[cfg(feature = "cli")]
    crosses_threads::<librate::report::Style>();
}

/// No global state: the same model gives the same result on many threads at once.
#[cfg(feature = "engine")]
#[test]
fn threads_do_not_disturb_each_other() {
    use librate::{linearize, model, oscillation, syntax};
    use librate_core::modes;
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
    use librate::diagnostic::Diagnostic;
    use librate::syntax;
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

/// Who builds the texts up may replace one: the last word counts.
#[cfg(feature = "engine")]
#[test]
fn a_later_table_takes_the_place_of_an_earlier_one() {
    use librate::model::{ModelError, Settings, TableTexts, elaborate};
    let file = librate::syntax::parse(
        "table rods = \"t.csv\"  coord x[1..rows(rods)]  T = 1/2*dot(x', x')  V = 1/2*dot(x, x)",
    )
    .unwrap();
    let count = |tables: &TableTexts| elaborate(&file, tables, &Settings::new()).map(|model| model.coordinates.len());
    let one = TableTexts::new().with("t.csv", "k\n1\n");
    assert_eq!(count(&one).unwrap(), 1);
    let two = one.with("other.csv", "k\n").with("t.csv", "k\n1\n2\n");
    assert_eq!(count(&two).unwrap(), 2);
    let none = two.with_failure("t.csv", "it was moved");
    let errors = count(&none).unwrap_err();
    assert!(matches!(errors[0], ModelError::MissingTable { .. }));
    assert_eq!(count(&none.with("t.csv", "k\n3\n")).unwrap(), 1);
}

/// The number of coordinates is known without the model.
#[cfg(feature = "engine")]
#[test]
fn coordinates_are_counted_before_the_energies_are_worked_out() {
    use librate::linearize::{LinearizeError, check_size};
    use librate::model::{Settings, TableTexts, coordinate_count, elaborate};
    use librate_core::linearize::MOST_COORDINATES;
    let tables = TableTexts::new().with("t.csv", "k\n1\n2\n");
    let mut seven = Settings::new();
    seven.add("N=7").unwrap();
    for (text, settings, expected) in [
        ("coord x, y[1..3], z[1..2, 0..4]", Settings::new(), 14),
        ("param N = 3  param M = 2*N - 1  coord x[1..M]", seven.clone(), 13),
        ("param N = 3  param m[1..N] = 1  coord x, y[i in 1..N where i != 2]", seven, 7),
        ("table rods = \"t.csv\"  param k = 3  coord x[b in rods], y[1..k*rows(rods)]", Settings::new(), 8),
        ("param n[1..2] = [4, 5]  coord x[1..n[2]], y[i in 1..3, j in i..3]", Settings::new(), 11),
    ] {
        let text = format!("{text}  coord s  T = 1/2*s'^2");
        let file = librate::syntax::parse(&text).unwrap();
        let model = elaborate(&file, &tables, &settings).unwrap();
        assert_eq!(model.coordinates.len(), expected + 1, "{text}");
        assert_eq!(coordinate_count(&file, &tables, &settings), expected + 1, "{text}");
    }
    assert_eq!(check_size(MOST_COORDINATES), Ok(()));
    assert!(matches!(check_size(MOST_COORDINATES + 1), Err(LinearizeError::TooLarge { .. })));
}
