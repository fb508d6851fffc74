//! Random trees survive printing and parsing; random text never breaks the parser.

use crate::syntax_common;
use crate::syntax_trees;

use librate::diagnostic::Diagnostic;
use librate::span::Span;
use librate_core::syntax::*;
use proptest::prelude::*;
use proptest::sample::select;
use syntax_common::strip_spans;
use syntax_trees::{Planter, bounds, trees};

/// What must hold for any text.
fn check(source: &str) {
    match parse(source) {
        Ok(file) => {
            let printed = print_file(&file);
            let again = parse(&printed).unwrap_or_else(|e| panic!("{printed}\n{e:#?}"));
            assert_eq!(strip_spans(&again), strip_spans(&file), "{printed}");
            for expr in file.expressions.iter() {
                assert!(source.get(expr.span.range()).is_some_and(|t| !t.is_empty()));
            }
        }
        Err(errors) => {
            assert!(!errors.is_empty());
            for error in errors {
                assert!(source.get(error.span().range()).is_some(), "{error:?}");
                let diagnostic = Diagnostic::from(&error);
                for label in diagnostic.primary.iter().chain(&diagnostic.secondary) {
                    assert!(source.get(label.span.range()).is_some(), "{error:?}");
                }
            }
        }
    }
}

const VALID: &str = "\
model m # comment
param g : m/s^2 = 9.81 ± 0.01
param m[1..3] : kg = [1, 2, 1]
param c[i in 1..n where i != 2 and not (i > 3)] = 2*i
table bonds = \"bonds.csv\"
coord x[1..N, 1..3] : m, φ : rad
let d[b in bonds] = norm(x[b.j] - x[b.i])'
T = sum(i in 1..N, j in i+1..N where i != j, 1/2*m*x[i]'^2) - -2^-x
V = [a, b][1]*(k/2)^2^3
constraint [i in 1..n] x[i] = 0
equilibrium φ' = 3; period 2*pi/W
";

pub(crate) fn alphabet() -> impl Strategy<Value = &'static str> {
    select(vec![
        "T",
        "V",
        "param",
        "let",
        "coord",
        "constraint",
        "period",
        "table",
        "model",
        "x",
        "a",
        "sum",
        "in",
        "where",
        "and",
        "or",
        "not",
        "(",
        ")",
        "[",
        "]",
        "=",
        "==",
        "!=",
        "<",
        "+",
        "-",
        "*",
        "/",
        "^",
        "'",
        ".",
        "..",
        ",",
        ":",
        ";",
        "1",
        "2.5",
        "1.",
        ".5",
        "±",
        "+/-",
        "\"a\"",
        "\"",
        "#",
        "\n",
        " ",
        "\r\n",
        "²",
        "**",
        "equilibrium",
        "guess",
        "1..3",
        "i in",
    ])
}

/// A file that was right before something was written, changed or left out in it.
pub(crate) fn changed() -> impl Strategy<Value = String> {
    proptest::collection::vec((0..VALID.len(), alphabet(), 0..3_u8), 1..5).prop_map(|changes| {
        let mut source: Vec<char> = VALID.chars().collect();
        for (at, word, change) in changes {
            let at = at.min(source.len().saturating_sub(1));
            match change {
                0 => {
                    source.remove(at);
                }
                1 => {
                    source.splice(at..at, word.chars());
                }
                _ => {
                    source.splice(at..=at, word.chars());
                }
            }
        }
        source.into_iter().collect()
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn printed_trees_parse_to_themselves(bound in bounds()) {
        let mut planter = Planter::default();
        planter.statements(&bound);
        let printed = print_file(&planter.file);
        let parsed = match parse(&printed) {
            Ok(file) => file,
            Err(errors) => return Err(TestCaseError::fail(format!("{printed}\n{errors:#?}"))),
        };
        prop_assert_eq!(strip_spans(&parsed), strip_spans(&planter.file), "{}", printed);
    }

    #[test]
    fn parentheses_are_all_needed(tree in trees()) {
        let mut planter = Planter::default();
        let value = planter.tree(&tree);
        planter.file.statements.push(Statement { span: Span::default(), kind: StatementKind::Potential(value) });
        let printed = print_file(&planter.file);
        let tree = strip_spans(&planter.file);
        // Taking a pair out changes the meaning, or is no expression any more.
        let mut open = Vec::new();
        let bytes = printed.as_bytes();
        for (at, byte) in bytes.iter().enumerate() {
            match byte {
                b'(' => open.push(at),
                b')' => {
                    let start = open.pop().unwrap();
                    let mut without = printed.clone();
                    without.remove(at);
                    without.remove(start);
                    if let Ok(file) = parse(&without) {
                        prop_assert_ne!(&strip_spans(&file), &tree, "{} and {}", printed, without);
                    }
                }
                _ => {}
            }
        }
    }

    #[test]
    fn any_text_is_answered(source in any::<String>()) {
        check(&source);
    }

    #[test]
    fn any_words_are_answered(words in proptest::collection::vec((alphabet(), any::<bool>()), 0..60)) {
        let source: String = words.iter().map(|(w, gap)| format!("{w}{}", if *gap { " " } else { "" })).collect();
        check(&source);
    }

    #[test]
    fn changed_files_are_answered(source in changed()) {
        check(&source);
    }
}

#[test]
fn the_unchanged_file_is_valid() {
    parse(VALID).unwrap();
    check(VALID);
}
