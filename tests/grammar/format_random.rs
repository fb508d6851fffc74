//! The laws of layout on random files: random trees, written with random gaps and comments.
#![cfg(feature = "format")]

use crate::format_laws;
use crate::syntax_trees;

use format_laws::laws;
use librate::syntax::{format, parse, print_statement};
use proptest::prelude::*;
use proptest::sample::select;
use syntax_trees::{Planter, bounds};

/// The tokens of a line of code without comments.
fn tokens(code: &str) -> Vec<&str> {
    let bytes = code.as_bytes();
    let word = |c: char| c.is_alphanumeric() || c == '_';
    let mut found = Vec::new();
    let mut at = 0;
    while at < code.len() {
        let rest = &code[at..];
        let first = rest.chars().next().unwrap();
        let length = if first == ' ' {
            at += 1;
            continue;
        } else if first.is_ascii_digit() {
            // Exponents hold signs, and `1..3` is three tokens.
            let mut end = 1;
            while end < rest.len() {
                let c = rest.as_bytes()[end];
                let exponent = matches!(rest.as_bytes()[end - 1], b'e' | b'E');
                let digit = |at: usize| rest.as_bytes().get(at).is_some_and(u8::is_ascii_digit);
                if c.is_ascii_alphanumeric() || exponent && matches!(c, b'+' | b'-') || c == b'.' && digit(end + 1) {
                    end += 1;
                } else {
                    break;
                }
            }
            end
        } else if word(first) {
            rest.find(|c| !word(c)).unwrap_or(rest.len())
        } else if first == '"' {
            rest[1..].find('"').unwrap() + 2
        } else if [b"..", b"==", b"!=", b"<=", b">="].iter().any(|two| bytes[at..].starts_with(*two)) {
            2
        } else {
            first.len_utf8()
        };
        found.push(&rest[..length]);
        at += length;
    }
    found
}

/// A gap between two tokens; the first are the ordinary ones.
const GAPS: [&str; 14] =
    ["", "", "", "", " ", " ", "  ", "\t", "\n", "\n    ", "\n\n\n", " # why\n", "#plain\n", "\n  # on its own\n\n"];

/// Between statements.
const ENDS: [&str; 16] = [
    "\n",
    "\n",
    "\n",
    "\n\n",
    "  ",
    " ",
    ";",
    "; \n\n\n",
    "\r\n",
    " # behind\n",
    " #! kept  \n",
    "\n# before\n",
    "\n\n   #before # twice\n\n# 12\n",
    " # T = 1\n#\n",
    "#\"\n",
    " # behind\n\n\n\n# before ω\n",
];

fn glued(before: &str, after: &str) -> bool {
    let digit = after.starts_with(|c: char| c.is_ascii_digit());
    after == "(" || after == "." || before == "." || before == "-" && digit
}

fn separate(before: &str, after: &str) -> bool {
    let word = |c: Option<char>| c.is_some_and(|c| c.is_alphanumeric() || c == '_');
    word(before.chars().last()) && word(after.chars().next())
}

fn scattered(statements: &[String], gaps: &[&str], ends: &[&str]) -> String {
    let mut gaps = gaps.iter().cycle();
    let mut ends = ends.iter().cycle();
    let mut source = String::new();
    for statement in statements {
        let tokens = tokens(statement);
        for (at, token) in tokens.iter().enumerate() {
            if at > 0 {
                let before = tokens[at - 1];
                let gap = if glued(before, token) { "" } else { gaps.next().unwrap() };
                source.push_str(gap);
                if gap.is_empty() && separate(before, token) {
                    source.push(' ');
                }
            }
            source.push_str(token);
        }
        let end = ends.next().unwrap();
        source.push_str(end);
    }
    source
}

fn gaps() -> impl Strategy<Value = Vec<&'static str>> {
    prop_oneof![
        proptest::collection::vec(select(GAPS.to_vec()), 20..120),
        proptest::collection::vec(select(GAPS[..8].to_vec()), 20..40),
        proptest::collection::vec(select(GAPS[..10].to_vec()), 20..120),
    ]
}

fn statements(bound: &syntax_trees::Bound) -> Vec<String> {
    let mut planter = Planter::default();
    planter.statements(bound);
    let file = &planter.file;
    file.statements
        .iter()
        .map(|statement| match print_statement(file, statement) {
            text if text.starts_with("T = ") => format!("T = ({})", &text[4..]),
            text => text,
        })
        .collect()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 150, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn layout_keeps_its_laws(
        some in proptest::collection::vec(bounds(), 1..3),
        gaps in gaps(),
        ends in proptest::collection::vec(select(ENDS.to_vec()), 1..20),
    ) {
        let all: Vec<String> = some.iter().flat_map(statements).collect();
        laws(&scattered(&all, &gaps, &ends));
    }

    #[test]
    fn short_statements_line_up_and_stay_so(
        lines in proptest::collection::vec((
            select(vec!["param", "let", "guess"]),
            select(vec!["a", "bc", "l[1..3]", "long_name"]),
            select(vec!["", " : m", " : kg/m^3", ": rad"]),
            select(vec![" = ", "= ", "   = ", "      = ", "\n ="]),
            select(vec!["1", "-0.30", "[1, 2, 3]", "sin(2*x) + 1"]),
            select(ENDS.to_vec()),
        ), 1..30),
    ) {
        let source: String = lines
            .iter()
            .map(|(word, name, unit, sign, value, end)| format!("{word} {name}{unit}{sign}{value}{end}"))
            .collect();
        laws(&source);
    }

    #[test]
    fn line_ends_do_not_matter(
        bound in bounds(),
        gaps in gaps(),
        ends in proptest::collection::vec(select(ENDS.to_vec()), 1..9),
    ) {
        let source = scattered(&statements(&bound), &gaps, &ends).replace('\r', "");
        let windows = source.replace('\n', "\r\n");
        let formatted = laws(&source);
        let wanted = if source.contains('\n') { formatted.replace('\n', "\r\n") } else { formatted };
        prop_assert_eq!(laws(&windows), wanted.clone());
        prop_assert_eq!(laws(&format!("\u{feff}{windows}")), wanted);
    }

    #[test]
    fn any_text_is_answered(source in any::<String>()) {
        prop_assert_eq!(format(&source).is_ok(), parse(&source).is_ok());
    }
}
