//! What must hold of the layout of any model file.

use librate::syntax::{File, format, parse};

use crate::syntax_common::strip_spans;

/// The texts of the comments, each with the number of the statement it belongs to: that which it
/// stands in or behind, else the next one.
fn belongings(file: &File) -> Vec<(usize, String)> {
    let mut found: Vec<(usize, String)> = Vec::new();
    let mut taken = None;
    for comment in &file.comments {
        let begun = file.statements.partition_point(|statement| statement.span.start < comment.span.start);
        let inside = begun > 0 && comment.span.start < file.statements[begun - 1].span.end;
        let behind = comment.trailing && begun > 0 && taken != Some(begun);
        let statement = if inside || behind { begun } else { begun + 1 };
        if behind && !inside {
            taken = Some(begun);
        }
        found.push((statement, comment.text.trim().to_owned()));
    }
    found
}

/// The part of a line that is no comment.
pub(crate) fn code(line: &str) -> &str {
    let mut quoted = false;
    for (at, c) in line.char_indices() {
        match c {
            '"' => quoted = !quoted,
            '#' if !quoted => return line[..at].trim_end(),
            _ => {}
        }
    }
    line
}

/// Formats a file that parses, and checks all that is promised.
pub(crate) fn laws(source: &str) -> String {
    let formatted = format(source).unwrap_or_else(|errors| panic!("{source}\n{errors:#?}"));
    let before = parse(source).unwrap();
    let after = parse(&formatted).unwrap_or_else(|e| panic!("{source}\n----\n{formatted}\n{e:#?}"));
    let both = format!("{source}\n----\n{formatted}");
    assert_eq!(strip_spans(&before), strip_spans(&after), "{both}");
    assert_eq!(belongings(&before), belongings(&after), "{both}");
    assert_eq!(format(&formatted).as_ref(), Ok(&formatted), "{both}");
    if formatted.is_empty() {
        return formatted;
    }
    let crlf = source.split_inclusive('\n').next().unwrap_or("").ends_with("\r\n");
    assert_eq!(formatted.contains("\r\n"), crlf, "{both}");
    let plain = formatted.replace("\r\n", "\n");
    assert!(plain.ends_with('\n') && !plain.starts_with('\n'), "{both}");
    assert!(!plain.contains("\n\n\n") && !plain.ends_with("\n\n"), "{both}");
    for line in plain.lines() {
        assert_eq!(line.trim_end(), line, "{both}");
        assert!(code(line).chars().count() <= 100, "{line}\n{both}");
    }
    formatted
}
