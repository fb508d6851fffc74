//! Cutting a statement changes nothing: neither its tree and places nor what is wrong with it.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "tests stop at the first surprise")]

use proptest::prelude::*;
use proptest::sample::select;

use super::{File, SyntaxError, parse_in_pieces};

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

fn answer(source: &str, piece: u32) -> Result<String, Vec<SyntaxError>> {
    parse_in_pieces(source, piece).map(|file| written(&file))
}

fn check(source: &str) {
    let whole = answer(source, u32::MAX);
    for piece in [1, 8, 50] {
        assert_eq!(answer(source, piece), whole, "{piece}: {source}");
    }
}

#[test]
fn cut_files_are_the_same() {
    for folder in ["models", "tests/language", "tests/errors", "tests/syntax", "tests/syntax_errors"] {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.extension().is_some_and(|extension| extension == "lag") {
                check(&std::fs::read_to_string(path).unwrap());
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
        check(source);
    }
}

#[test]
fn large_sums_are_cut() {
    let terms = " + 1/2*k*(x[1] - x[2])^2 - -sin(y)*[a, b + c][1]".repeat(3000);
    for source in [
        format!("V = 0{terms}"),
        format!("param a : m = 0{terms} ± (1{terms})^2 V = 1"),
        format!("V = 2*(0{terms}) - sum(i in 1..3, 3 - 4*i/(1{terms}))"),
        format!("V = 0{terms} + 2 x"),
        format!("V = 0{terms} + (1 < 2)"),
    ] {
        let whole = answer(&source, u32::MAX);
        assert!(answer(&source, super::PIECE) == whole);
        assert!(answer(&source, 500) == whole);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn cut_words_are_the_same(
        start in select(vec!["V = ", "period ", "constraint ", "param a = ", "let a[i in 1..n] : m = ", "V = 2*(", "V = sum(i in 1..2, "]),
        words in proptest::collection::vec(select(vec![
            "a", "2", "x[1]", "+", "-", "+", "-", "*", "^", "/", "(", ")", "(", ")", "[", "]", ",", "'", "=", "±",
            "sin(", "sum(i in 1..3, ", "where", "not", "and", "<", "..", "in", " # + \n", "b.c", "± 1", ":", "V =",
        ]), 0..25),
        end in select(vec!["", ")", "b)", "+ 1"]),
    ) {
        check(&format!("{start}{}{end}", words.join(" ")));
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
        prop_assert!(answer(&source, u32::MAX).is_ok(), "{}", source);
        check(&source);
    }
}
