//! M and K as `derive` prints them beside the same as a book has them (tests/reference/book_forms.txt): equal,
//! and not longer by more than a tenth.
#![cfg(feature = "engine")]
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::print_stdout,
    reason = "tests stop at the first surprise"
)]

use crate::common;

use common::load;
use librate::derive::{Parts, derive};
use librate::expect::Expected;

/// A printed form may have a tenth more tokens than the book's.
const MOST: f64 = 1.1;

/// Names with their indices, numbers, and signs one by one.
fn tokens(text: &str) -> usize {
    let mut count = 0;
    let mut rest = text.trim_start();
    while let Some(first) = rest.chars().next() {
        let word = |c: char| c.is_alphanumeric() || c == '_' || c == '.';
        let mut end = first.len_utf8();
        if word(first) {
            end = rest.find(|c: char| !word(c)).unwrap_or(rest.len());
            if first.is_alphabetic() && rest[end..].starts_with('[') {
                end += rest[end..].find(']').unwrap() + 1;
            }
        }
        count += 1;
        rest = rest[end..].trim_start();
    }
    count
}

#[test]
fn tokens_are_counted_as_a_reader_counts_them() {
    assert_eq!(tokens("m[1]*l[1]^2"), 5);
    assert_eq!(tokens("-1/2*(r[1,2] - 0.5)"), 10);
    assert_eq!(tokens("[[a, 0], [0, b1]]"), 13);
}

#[test]
fn matrices_are_the_books_and_as_short() {
    let file = std::fs::read_to_string("tests/reference/book_forms.txt").unwrap();
    let mut long = Vec::new();
    let (mut ours, mut books, mut checked) = (0, 0, 0);
    for entry in file.split("\n\n").skip(1) {
        let mut lines = entry.lines();
        let name = lines.next().unwrap();
        let form = |line: Option<&str>, letter| line.unwrap().strip_prefix(letter).unwrap().to_owned();
        let mass = form(lines.next(), "M = ");
        let stiffness = form(lines.next(), "K = ");
        let model = load(format!("models/{name}.lag").as_ref());
        let derivation = derive(&model, &Parts::default()).unwrap();
        let expected = Expected::new().mass(&mass).stiffness(&stiffness);
        if let Err(mismatches) = expected.compare(&derivation) {
            panic!("{name}: {mismatches}");
        }
        let linear = derivation.linear.as_ref().unwrap();
        for (letter, own, book) in [("M", &linear.mass, mass), ("K", &linear.stiffness, stiffness)] {
            let rows = own.iter().map(|row| {
                let row: Vec<String> = row.iter().map(|e| derivation.pool.display(*e)).collect();
                format!("[{}]", row.join(", "))
            });
            let own = format!("[{}]", rows.collect::<Vec<_>>().join(", "));
            let counts = [tokens(&own), tokens(&book)];
            ours += counts[0];
            books += counts[1];
            checked += 1;
            if counts[0] as f64 > MOST * counts[1] as f64 {
                long.push(format!("{name}, {letter}: {counts:?}\n  {own}\n  {book}"));
            }
        }
    }
    println!("{ours} tokens in {checked} matrices, in the books {books}");
    assert!(checked > 80, "{checked}");
    assert!(long.is_empty(), "{}", long.join("\n"));
}
