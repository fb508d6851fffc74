//! Lines of the formatted file: lines up what stands below each other, and writes the text.

use std::borrow::Cow;

use super::super::ast::{Comment, StatementKind};
use super::layout::WIDTH;
use super::pieces::width;

/// Signs further right than this are not lined up, ...
const DEEPEST_SIGN: usize = 40;
/// Comments are lined up where their lines differ by no more than this.
const FAR: usize = 24;

/// What lines up the `=` of a statement that has a line to itself.
pub(super) struct Head {
    /// `param`, `let`, …
    pub(super) word: std::mem::Discriminant<StatementKind>,
    /// The byte of the `=` in its line.
    pub(super) byte: usize,
    /// Its column.
    pub(super) column: usize,
    /// The column of the colon before it.
    pub(super) colon: Option<usize>,
    /// Where it stands in the source.
    pub(super) written: Option<Written>,
}

/// An `=` in the source.
#[derive(Clone, Copy)]
pub(super) struct Written {
    pub(super) column: usize,
    /// Whether more than one blank stands before it.
    pub(super) padded: bool,
}

struct Line<'s> {
    code: String,
    comment: Option<Cow<'s, str>>,
    blank_before: bool,
    head: Option<Head>,
    /// Columns of `code`.
    width: usize,
    /// Blanks to be put before its `=`.
    shift: usize,
}

/// The lines written so far.
#[derive(Default)]
pub(super) struct Page<'s> {
    lines: Vec<Line<'s>>,
    /// A blank line is to be left before the next one.
    blank: bool,
}

/// The text of a comment: a blank between `#` and words, none at the end.
fn text(comment: &Comment) -> Cow<'_, str> {
    let text = comment.text.trim_end();
    let word = |c: char| c.is_alphanumeric() || matches!(c, '(' | '[' | '"' | '\'' | '`' | '„' | '“');
    if text.starts_with(word) { Cow::Owned(format!(" {text}")) } else { Cow::Borrowed(text) }
}

impl<'s> Page<'s> {
    /// A blank line follows, unless the page is empty.
    pub(super) fn blank(&mut self) {
        self.blank = !self.lines.is_empty();
    }

    /// A line of code.
    pub(super) fn line(&mut self, mut code: String, comment: Option<&'s Comment>) {
        code.truncate(code.trim_end_matches(' ').len());
        self.whole(code, comment, None);
    }

    /// A line that is a whole statement.
    pub(super) fn whole(&mut self, code: String, comment: Option<&'s Comment>, head: Option<Head>) {
        let (width, comment) = (width(&code), comment.map(text));
        self.lines.push(Line { code, comment, blank_before: std::mem::take(&mut self.blank), head, width, shift: 0 });
    }

    /// A comment on its own line.
    pub(super) fn remark(&mut self, indent: usize, comment: &'s Comment) {
        let code = format!("{}#{}", " ".repeat(indent), text(comment));
        self.whole(code, None, None);
    }

    /// All lines as text.
    pub(super) fn finish(mut self, line_end: &str) -> String {
        self.line_up_signs();
        let mut out = String::new();
        let mut at = 0;
        while at < self.lines.len() {
            let run = self.commented(at);
            let column = self.lines[at..run].iter().map(Line::columns).max();
            for line in &self.lines[at..run] {
                line.write(column.unwrap_or(0), line_end, &mut out);
            }
            at = run;
        }
        out
    }

    /// The end of the run of commented lines that begins at a line, at least one line.
    fn commented(&self, start: usize) -> usize {
        let (mut least, mut most) = (usize::MAX, 0);
        let mut end = start;
        while let Some(line) = self.lines.get(end) {
            least = least.min(line.columns());
            most = most.max(line.columns());
            let joins = line.comment.is_some() && !line.blank_before && most - least <= FAR;
            if end > start && !joins {
                break;
            }
            end += 1;
            if line.comment.is_none() {
                break;
            }
        }
        end
    }

    /// Puts the `=` of neighbouring statements of a kind below each other, if their units begin
    /// in the same column or their signs were lined up by the author.
    fn line_up_signs(&mut self) {
        let mut at = 0;
        while at < self.lines.len() {
            let mut end = at + 1;
            while end < self.lines.len() && joined(&self.lines[end - 1], &self.lines[end]) {
                end += 1;
            }
            let run = &mut self.lines[at..end];
            let column = run.iter().filter_map(Line::sign).max().unwrap_or(0);
            for line in run {
                line.shift = line.sign().map_or(0, |sign| column - sign);
            }
            at = end;
        }
    }
}

fn joined(above: &Line<'_>, below: &Line<'_>) -> bool {
    let (Some(_), Some(_), Some(first), Some(second)) = (above.sign(), below.sign(), &above.head, &below.head) else {
        return false;
    };
    let units = first.colon.is_some() && first.colon == second.colon;
    let written = first.written.zip(second.written);
    let written = written.is_some_and(|(one, other)| one.column == other.column && (one.padded || other.padded));
    !below.blank_before && first.word == second.word && (units || written)
}

impl Line<'_> {
    /// The column of the `=`, if it takes part in lining up: then there is room for that.
    fn sign(&self) -> Option<usize> {
        let head = self.head.as_ref()?;
        let room = WIDTH - DEEPEST_SIGN;
        let fits = head.column <= DEEPEST_SIGN && self.width - head.column <= room;
        fits.then_some(head.column)
    }

    fn columns(&self) -> usize {
        self.width + self.shift
    }

    fn write(&self, column: usize, line_end: &str, out: &mut String) {
        if self.blank_before {
            out.push_str(line_end);
        }
        let byte = self.head.as_ref().map_or(0, |head| head.byte);
        let (before, behind) = self.code.split_at_checked(byte).unwrap_or(("", &self.code));
        out.push_str(before);
        out.extend(std::iter::repeat_n(' ', self.shift));
        out.push_str(behind);
        if let Some(comment) = &self.comment {
            out.extend(std::iter::repeat_n(' ', column - self.columns() + 2));
            out.push('#');
            out.push_str(comment);
        }
        out.push_str(line_end);
    }
}
