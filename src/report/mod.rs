//! Results in writing: text for a person, JSON for a program.
//!
//! Every number that has a bound is printed with the digits its bound decides and no others
//! ([`crate::precision::decimal`]). Nothing is computed here, and nothing is written anywhere: the
//! functions return text.

mod derive;
mod json;
mod modes;

pub use derive::derive_text;
pub use json::{derive_json, modes_json};
pub use modes::modes_text;

use anstyle::{AnsiColor, Effects};

/// How text is laid out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Style {
    /// Whether escape sequences for colours are wanted.
    pub color: bool,
    /// How many columns a line should have at most; tables that don't fit leave things out, but
    /// never a frequency.
    pub width: usize,
}

impl Default for Style {
    /// Without colours, 100 columns.
    fn default() -> Self {
        Self {
            color: false,
            width: 100,
        }
    }
}

/// What a piece of text is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Tone {
    Heading,
    Good,
    Careful,
    Bad,
}

impl Style {
    fn paint(&self, tone: Tone, text: &str) -> String {
        if !self.color {
            return text.to_owned();
        }
        let style = match tone {
            Tone::Heading => anstyle::Style::new().effects(Effects::BOLD),
            Tone::Good => AnsiColor::Green.on_default(),
            Tone::Careful => AnsiColor::Yellow.on_default(),
            Tone::Bad => AnsiColor::Red.on_default().effects(Effects::BOLD),
        };
        format!("{style}{text}{style:#}")
    }
}

/// `three_pendulums: 3 coordinates`
fn headline(name: Option<&str>, coordinates: usize) -> String {
    let count = counted(coordinates, "coordinate");
    match name {
        Some(name) => format!("{name}: {count}"),
        None => count,
    }
}

/// `1 coordinate`, `3 coordinates`
fn counted(count: usize, noun: &str) -> String {
    let plural = if count == 1 { "" } else { "s" };
    format!("{count} {noun}{plural}")
}

/// Pads numbers on both sides so that their decimal points stand in one column.
fn align_at_point(numbers: &mut [String]) {
    let point = |text: &str| text.find(['.', 'e']).unwrap_or(text.len());
    let left = numbers.iter().map(|text| point(text)).max().unwrap_or(0);
    for text in numbers.iter_mut() {
        *text = format!("{}{text}", " ".repeat(left - point(text)));
    }
    let width = numbers.iter().map(String::len).max().unwrap_or(0);
    for text in numbers.iter_mut() {
        *text = format!("{text:<width$}");
    }
}

/// Joins items with commas into lines of at most `width` columns, each with the same indentation.
fn flow(items: &[String], indentation: &str, width: usize) -> String {
    let mut out = String::new();
    let mut used = 0;
    for (at, item) in items.iter().enumerate() {
        let comma = if at + 1 < items.len() { "," } else { "" };
        let size = item.chars().count() + comma.len();
        if at == 0 || used + 1 + size > width {
            if at > 0 {
                out.push('\n');
            }
            out.push_str(indentation);
            used = indentation.len();
        } else {
            out.push(' ');
            used += 1;
        }
        out.push_str(item);
        out.push_str(comma);
        used += size;
    }
    out.push('\n');
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_stand_below_each_other() {
        let mut numbers = ["3.13", "0", "12.5e20", "1e-7"].map(str::to_owned);
        align_at_point(&mut numbers);
        assert_eq!(
            numbers,
            [" 3.13   ", " 0      ", "12.5e20 ", " 1e-7   "].map(|s| s.to_owned())
        );
        align_at_point(&mut []);
    }

    #[test]
    fn lists_flow_into_lines() {
        let items = ["a = 1", "b = 2", "c = 3"].map(str::to_owned);
        assert_eq!(flow(&items, "  ", 16), "  a = 1, b = 2,\n  c = 3\n");
        assert_eq!(flow(&items, "  ", 1), "  a = 1,\n  b = 2,\n  c = 3\n");
    }
}
