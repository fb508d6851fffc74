//! Lines that differ by their indices alone, as those of a chain do: one line for all, "for i in 2..99".
//!
//! Nothing is recognised but text: a run stands in place of lines each of which comes back letter by letter with its own number
//! put in for the index.

use librate_core::order::Order;
use std::cmp::{Ordering, Reverse};

use super::page::{Line, Words};

/// Fewer repetitions are written out.
const LEAST: usize = 4;
/// Lines that return after so many are found: the entries of a band, the rows of a lattice.
const LONGEST_PERIOD: usize = 12;
/// Of more items of a list the first and the last are written.
const MOST_ITEMS: usize = 12;
/// What an index may be called.
const INDICES: [&str; 6] = ["i", "j", "n", "p", "l", "s"];
/// What stands in place of an index until it has its name.
const MARKS: [&str; 2] = ["\u{1}", "\u{2}"];

/// A text with the whole numbers among its indices taken out.
struct Shape {
    /// What stands before each number, and behind the last.
    between: Vec<String>,
    numbers: Vec<usize>,
}

impl Shape {
    fn of(text: &str) -> Self {
        let (mut between, mut numbers) = (Vec::new(), Vec::new());
        let (mut before, mut inside) = (String::new(), false);
        for part in text.split_inclusive(['[', ',', ']']) {
            let own = part.trim_end_matches([',', ']']);
            match own.trim_start().parse() {
                Ok(number) if inside && own.len() < part.len() => {
                    before.push_str(own.trim_end_matches(|c: char| c.is_ascii_digit()));
                    between.push(std::mem::take(&mut before));
                    numbers.push(number);
                    before.push_str(&part[own.len()..]);
                }
                _ => before.push_str(part),
            }
            // Indices stand behind a name; a vector does not.
            inside = match part.strip_suffix('[') {
                Some(own) => own.ends_with(|c| is_of_name(c) || c == '\''),
                None => inside && part.ends_with(','),
            };
        }
        between.push(before);
        Self { between, numbers }
    }

    /// Which numbers go on to those of another text, each by 1; `None` where anything else differs, or nothing.
    fn step_to(&self, next: &Self) -> Option<Vec<bool>> {
        let pairs = || self.numbers.iter().zip(&next.numbers);
        let alike = self.between == next.between && pairs().all(|(a, b)| a == b || a + 1 == *b);
        (alike && self.numbers != next.numbers).then(|| pairs().map(|(a, b)| a < b).collect())
    }

    /// With an index for the number `at`, and what differs from it.
    fn with_index(&self, step: &[bool], index: &str, at: usize) -> String {
        let number = |(number, goes_on): (&usize, &bool)| match number.cmp(&at) {
            _ if !goes_on => number.to_string(),
            Ordering::Equal => index.to_owned(),
            Ordering::Greater => format!("{index}+{}", number - at),
            Ordering::Less => format!("{index}-{}", at - number),
        };
        let numbers = self.numbers.iter().zip(step).map(number).chain([String::new()]);
        self.between.iter().zip(numbers).flat_map(|(before, number)| [before.clone(), number]).collect()
    }
}

fn is_of_name(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

/// A line that stands for as many as its indices have values.
#[derive(Clone)]
struct Row {
    text: String,
    /// The mark in place of each index, its first value and its last.
    ranges: Vec<(&'static str, usize, usize)>,
}

impl Row {
    /// With names for the indices, in the order in which they occur.
    fn named(mut self, names: &[&str]) -> Line {
        self.ranges.order_by_key(|(mark, ..)| self.text.find(mark));
        let mut remark = String::new();
        for ((mark, first, last), name) in self.ranges.iter().zip(names) {
            self.text = self.text.replace(mark, name);
            let before = if remark.is_empty() { ", for" } else { "," };
            remark.push_str(&format!("{before} `{name}` in {first}..{last}"));
        }
        Line::Formula(self.text, remark)
    }
}

/// Relations with a line for each run of them, in two dimensions where runs follow each other alike.
pub(super) fn gathered(texts: impl IntoIterator<Item = String>) -> Vec<Line> {
    let rows: Vec<Row> = texts.into_iter().map(|text| Row { text, ranges: Vec::new() }).collect();
    if rows.len() < LEAST {
        return rows.into_iter().map(|row| row.named(&[])).collect();
    }
    let is_name = |name: &str| rows.iter().any(|row| row.text.split(|c| !is_of_name(c)).any(|other| other == name));
    let names: Vec<&str> = INDICES.into_iter().filter(|name| !is_name(name)).collect();
    let [first, second] = MARKS;
    let mut gathered = rows;
    if names.len() >= MARKS.len() {
        let count = gathered.len();
        gathered = pass(&gathered, first);
        // Rows of rows, where there are rows.
        if gathered.len() < count {
            gathered = pass(&gathered, second);
        }
    }
    gathered.into_iter().map(|row| row.named(&names)).collect()
}

fn pass(rows: &[Row], mark: &'static str) -> Vec<Row> {
    let shapes: Vec<Shape> = rows.iter().map(|row| Shape::of(&row.text)).collect();
    let step = |at: usize, period: usize| {
        let next = rows.get(at + period).filter(|next| next.ranges == rows[at].ranges);
        next.and_then(|_| shapes[at].step_to(&shapes[at + period]))
    };
    // How often the lines from here on come, with as many between.
    let times = |at: usize, period: usize| {
        let of_line = |place: usize| {
            let first = step(place, period);
            let goes_on = |place: &usize| first.is_some() && step(*place, period) == first;
            (place..).step_by(period).take_while(goes_on).count() + 1
        };
        (at..at + period).map(of_line).min().unwrap_or(1)
    };
    let mut out = Vec::new();
    let mut at = 0;
    while at < rows.len() {
        let found = (1..=LONGEST_PERIOD).map(|period| (times(at, period), period));
        let best = found
            .filter(|(times, _)| *times >= LEAST)
            .max_by_key(|(times, period)| ((times - 1) * period, Reverse(*period)));
        let Some((times, period)) = best else {
            out.push(rows[at].clone());
            at += 1;
            continue;
        };
        let steps: Vec<_> = (at..at + period).filter_map(|place| Some((place, step(place, period)?))).collect();
        // The first number that goes on is the index.
        let first = steps.first().and_then(|(place, step)| {
            step.iter().zip(&shapes[*place].numbers).find(|(goes_on, _)| **goes_on).map(|(_, number)| *number)
        });
        let first = first.unwrap_or(1);
        for (place, step) in steps {
            let text = shapes[place].with_index(&step, mark, first);
            let own = (mark, first, first + times - 1);
            out.push(Row { text, ranges: rows[place].ranges.iter().copied().chain([own]).collect() });
        }
        at += times * period;
    }
    out
}

/// The items of a list; of many that differ by their indices alone, the first two and the last.
pub(super) fn ends(items: Vec<Words>) -> Vec<Words> {
    let mut out = Vec::new();
    for run in items.chunk_by(|a, b| Shape::of(a).between == Shape::of(b).between) {
        match run {
            [first, second, .., last] if run.len() > MOST_ITEMS => {
                out.extend([first.clone(), second.clone(), "…".to_owned(), last.clone()]);
            }
            _ => out.extend_from_slice(run),
        }
    }
    out
}
