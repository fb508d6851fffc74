//! The length of a statement changes nothing: neither its tree and places nor what is wrong with it. A statement with wide
//! gaps is held against itself without.

use librate::syntax::{File, SyntaxError, parse};
use librate_core::syntax::print_file;
use proptest::prelude::*;
use proptest::sample::select;

/// The width of a gap.
const PIECE: usize = 1 << 14;

/// Everything a file says, with its places, whatever the order in its arenas.
fn written(file: &File) -> String {
    let expressions: Vec<String> = file.expressions.iter().map(|expr| format!("{expr:?}")).collect();
    let units: Vec<String> = file.units.iter().map(|unit| format!("{unit:?}")).collect();
    let mut out = format!("{} expressions", expressions.len());
    let mut rest = vec![format!("{:?} {:?}", file.statements, file.comments)];
    while let Some(text) = rest.pop() {
        let Some(at) = text.find("Ref(") else {
            out += &text;
            continue;
        };
        let (before, after) = text.split_at(at + "Ref(".len());
        let (number, after) = after.split_once(')').unwrap();
        let number: usize = number.parse().unwrap();
        let list = if before.ends_with("UnitRef(") { &units } else { &expressions };
        out += before;
        rest.push(after.to_owned());
        rest.push(list[number].clone());
    }
    out
}

/// The tree or the errors of a text, with every place moved.
fn answer(source: &str, moved: impl Fn(usize) -> usize) -> Result<String, String> {
    let all = |text: String| {
        let mut out = String::new();
        let mut rest = text.as_str();
        for key in ["start: ", "end: "].into_iter().cycle() {
            let Some((before, after)) = rest.split_once(key) else {
                break;
            };
            let end = after.find(|c: char| !c.is_ascii_digit()).unwrap();
            let place: usize = after[..end].parse().unwrap();
            out += &format!("{before}{key}{}", moved(place));
            rest = &after[end..];
        }
        out + rest
    };
    // Quoted are pieces of the text, gaps and all, where they are not too long.
    let errors = |errors: Vec<SyntaxError>| {
        let text = all(format!("{errors:?}"));
        let parts: Vec<&str> = text.split('"').step_by(2).collect();
        parts.join("…")
    };
    parse(source).map(|file| all(written(&file))).map_err(errors)
}

/// Where a gap can be made: before signs between operands, outside comments and texts.
fn signs(source: &str) -> Vec<usize> {
    let mut found = Vec::new();
    let (mut comment, mut text, mut operand) = (false, false, false);
    for (at, c) in source.char_indices() {
        match c {
            '\n' => comment = false,
            '#' if !text => comment = true,
            '"' if !comment => text = !text,
            '+' | '-' if operand && !comment && !text => found.push(at),
            _ => {}
        }
        if !c.is_whitespace() {
            let exponent = "eE".contains(c) && source[..at].ends_with(|c: char| c.is_ascii_digit());
            operand = (c.is_alphanumeric() || "_')]".contains(c)) && !exponent;
        }
    }
    found
}

/// With gaps at so many signs at a time.
fn check(source: &str, many: usize) {
    let whole = answer(source, |place| place);
    for gaps in signs(source).chunks(many) {
        let mut wide = String::new();
        let mut last = 0;
        for gap in gaps {
            wide += &source[last..*gap];
            wide += &" ".repeat(PIECE);
            last = *gap;
        }
        wide += &source[last..];
        let moved = |place: usize| {
            let before = |k: &usize| gaps[*k] + (k + 1) * PIECE <= place;
            place - (0..gaps.len()).take_while(before).count() * PIECE
        };
        assert!(answer(&wide, moved) == whole, "{gaps:?}: {source}");
    }
}

#[test]
fn cut_files_are_the_same() {
    for folder in ["models", "tests/language", "tests/errors", "tests/syntax"] {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.extension().is_some_and(|extension| extension == "lag") {
                check(&std::fs::read_to_string(path).unwrap(), 3);
            }
        }
    }
}

#[test]
fn sums_are_cut_wherever_they_stand() {
    for source in [
        "V = a + b - c",
        "V = -a + -b - -c + 2^-d - e*-f",
        "V = (a + b) + (c - (d - e)) - f",
        "V = -(a + b)*(c - d)^(e + f)'",
        "V = sin(a + b - [c + d, e - f][1 + i]) + g(h + i, j - k).col",
        "V = sum(i in 1+n..n+m where i + 1 < n - (2 - k) and not (i + 1 == 3), x[i+1] - x[i-1])",
        "V = 1 + sum(i in a where (1 + 2) < i, (a + b)*2)",
        "V = (a + b < c) + d",
        "V = a + not b + c",
        "V = a + (b + 1..c - 2) + d",
        "period 2*pi + a - b",
        "constraint a + b = c - d + e",
        "constraint [i in 1..n - 1] x[i+1] - y = a + b",
        "param a : m^(1+2) = 1 + 2",
        "param a : m^(1 + 2)*s + kg = 1 + 2",
        "param a[1+2..3+4] : N/m = 1 + 2 ± 0.1 + 0.2 +/- 3",
        "param a = 1 + 2 +/- 0.1 - 0.2",
        "equilibrium x[1+1]' : rad = 2 - w # one + two\n + 3",
        "coord x[1..n+1], y[1..n-1] : m",
        "table a = 1 + 2",
        "T = a + + b",
        "T = a - (b + c",
        "T = a + b) - c",
        "T = a + b c - d",
        "T = a = b + c",
        "T = a +",
        "T = a +\nV = 1 + 2 - 3",
        "param sin : m^(1/0) = 1\nV = a + b",
    ] {
        for many in [1, 2, usize::MAX] {
            check(source, many);
        }
    }
}

#[test]
fn large_sums_are_cut() {
    let term = " + 1/2*k*(x[1] - x[2])^2 - -sin(y)*[a, b + c][1]";
    let models: [fn(&str) -> String; 3] = [
        |terms| format!("V = 0{terms}"),
        |terms| format!("param a : m = 0{terms} ± (1{terms})^2 V = 1"),
        |terms| format!("V = 2*(0{terms}) - sum(i in 1..3, 3 - 4*i/(1{terms}))"),
    ];
    let many = 3000;
    for model in models {
        // As long as its terms, and nothing in between: no sum became a term of another.
        let file = |count: usize| parse(&model(&term.repeat(count))).unwrap();
        let printed = |count: usize| print_file(&file(count));
        let grown = |size: &dyn Fn(usize) -> usize| {
            assert_eq!(size(many) - size(1), (many - 1) * (size(2) - size(1)));
        };
        grown(&|count| printed(count).len());
        grown(&|count| file(count).expressions.len());
        let brackets = |count: usize| printed(count).matches('(').count();
        grown(&brackets);
        let again = parse(&printed(many)).unwrap();
        assert!(print_file(&again) == printed(many));
    }
    for end in [" + 2 x", " + (1 < 2)"] {
        let source = |count: usize| format!("V = 0{}{end}", term.repeat(count));
        let whole = answer(&source(1), |place| place);
        assert!(whole.is_err());
        let skipped = (many - 1) * term.len();
        let moved = |place: usize| {
            if place > skipped { place - skipped } else { place }
        };
        assert_eq!(answer(&source(many), moved), whole);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 500, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn cut_words_are_the_same(
        start in select(vec!["V = ", "period ", "constraint ", "param a = ", "let a[i in 1..n] : m = ", "V = 2*(", "V = sum(i in 1..2, "]),
        words in proptest::collection::vec(select(vec![
            "a", "2", "x[1]", "+", "-", "+", "-", "*", "^", "/", "(", ")", "(", ")", "[", "]", ",", "'", "=", "±",
            "sin(", "sum(i in 1..3, ", "where", "not", "and", "<", "..", "in", " # + \n", "b.c", "± 1", ":", "V =",
        ]), 0..25),
        end in select(vec!["", ")", "b)", "+ 1"]),
    ) {
        check(&format!("{start}{}{end}", words.join(" ")), usize::MAX);
    }

    #[test]
    fn cut_sums_are_the_same(
        words in proptest::collection::vec((
            select(vec!["+", "-", "- -", "*", "^", "^-"]),
            select(vec!["a", "2", "x[i - 1]'", "f(a + b)", "(c - d)", "(-e + f*g)", "[a, b + c]", "(h)'", "sum(i in 1..n+1, i + j)"]),
        ), 1..12),
        around in select(vec![("V = a", ""), ("param p = a", "± b + c"), ("constraint a", "= b - c"), ("V = 1 + k*(2", ")^2 - 1")]),
    ) {
        let words: Vec<String> = words.iter().map(|(sign, operand)| format!("{sign} {operand}")).collect();
        let source = format!("{} {} {}", around.0, words.join(" "), around.1);
        prop_assert!(parse(&source).is_ok(), "{}", source);
        check(&source, usize::MAX);
    }
}
