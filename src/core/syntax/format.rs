//! Canonical layout of a model file, comments kept.
//!
//! The tree is printed, and its lines are broken where the printer says they may be; comments
//! and blank lines come from the text. What the layout depends on — the tree, the places of
//! comments, blank lines, statements that share a line, members set apart — is the same in the
//! text that comes out, so that formatting it again changes nothing.

mod comments;
mod layout;
mod page;
mod pieces;

use super::ast::{ExprKind, ExprRef, File, Statement, StatementKind};
use super::error::SyntaxError;
use super::print::{Piece, Printer};
use crate::span::Span;
use layout::WIDTH;
use page::{Head, Page, Written};
use pieces::{Pieces, width};

/// Between statements that share a line.
const GAP: usize = 2;

/// The text of a model file in canonical layout: what an editor or `librate fmt` puts in its place.
///
/// The result parses to the same tree, holds the same comments, each with its statement, and is
/// its own canonical layout. Lines end as the first line of the text does, a byte order mark is
/// dropped, and no line is longer than 100 columns unless a comment, or what can't be broken,
/// makes it so.
///
/// # Errors
/// The mistakes of a text that doesn't parse, as [`parse`](super::parse) gives them.
///
/// ```
/// use librate::syntax::format;
/// let text = "coord  x:m #to the right\n\n\n\nT=( 1/2*m )*x'^2;V = k*(x)^2/2";
/// assert_eq!(format(text)?, "coord x : m  # to the right\n\nT = (1/2*m)*x'^2  V = k*x^2/2\n");
/// # Ok::<(), Vec<librate::syntax::SyntaxError>>(())
/// ```
pub fn format(source: &str) -> Result<String, Vec<SyntaxError>> {
    let file = super::parse(source)?;
    let first_line = source.split_inclusive('\n').next().unwrap_or("");
    let line_end = if first_line.ends_with("\r\n") { "\r\n" } else { "\n" };
    let printer = Printer::new(&file, Pieces::default());
    let mut formatter = Formatter { source, file: &file, page: Page::default(), printer, comment: 0, end: 0 };
    formatter.file();
    Ok(formatter.page.finish(line_end))
}

struct Formatter<'s, 'f> {
    source: &'s str,
    file: &'f File,
    page: Page<'f>,
    printer: Printer<'f, Pieces<'f>>,
    /// The next comment to be written.
    comment: usize,
    /// The end of what has been written, in the source.
    end: u32,
}

impl<'f> Formatter<'_, 'f> {
    fn file(&mut self) {
        let statements = &self.file.statements;
        let mut at = 0;
        while let Some(statement) = statements.get(at) {
            self.remarks(statement.span.start);
            self.gap(statement.span.start);
            let mut next = at + 1;
            while self.shares_line(statements.get(next - 1), statements.get(next)) {
                next += 1;
            }
            let run = statements.get(at..next).unwrap_or(&[]);
            if run.len() < 2 || !self.in_one_line(run) {
                for (place, statement) in run.iter().enumerate() {
                    let following = statements.get(at + place + 1);
                    self.statement(statement, following);
                }
            }
            at = next;
        }
        self.remarks(u32::MAX);
    }

    fn text(&self, start: u32, end: u32) -> &str {
        let range = Span::new(start, end.max(start)).range();
        self.source.get(range).unwrap_or("")
    }

    /// Leaves a blank line if there are any between what was written and what begins here.
    fn gap(&mut self, start: u32) {
        if self.text(self.end, start).matches('\n').nth(1).is_some() {
            self.page.blank();
        }
    }

    /// Comments on lines of their own, up to a place in the source.
    fn remarks(&mut self, until: u32) {
        let file = self.file;
        while let Some(comment) = file.comments.get(self.comment) {
            if comment.span.start >= until {
                break;
            }
            self.gap(comment.span.start);
            self.page.remark(0, comment);
            self.end = comment.span.end;
            self.comment += 1;
        }
    }

    /// The comment behind the last token of a statement.
    fn end_comment(&self, from: usize, following: Option<&Statement>) -> Option<usize> {
        let comment = self.file.comments.get(from)?;
        let until = following.map_or(u32::MAX, |next| next.span.start);
        (comment.trailing && comment.span.start < until).then_some(from)
    }

    fn shares_line(&self, above: Option<&Statement>, below: Option<&Statement>) -> bool {
        let both = above.zip(below);
        both.is_some_and(|(above, below)| !self.text(above.span.end, below.span.start).contains('\n'))
    }

    /// The pieces of a statement, in the printer's room.
    fn pieces(&mut self, statement: &'f Statement) -> &mut Pieces<'f> {
        self.printer.plus_minus = if self.ascii_sign(statement) { "+/-" } else { "±" };
        self.printer.out().clear();
        self.printer.statement(statement);
        self.printer.out()
    }

    /// Whether an uncertainty was written with `+/-`.
    fn ascii_sign(&self, statement: &Statement) -> bool {
        let between = statement.kind.parameters().iter().filter_map(|binding| {
            let (value, uncertainty) = (self.file.expr(binding.value?), self.file.expr(binding.uncertainty?));
            Some(self.text(value.span.end, uncertainty.span.start))
        });
        between.flat_map(str::lines).any(|line| line.split('#').next().is_some_and(|code| code.contains("+/-")))
    }

    /// Statements that shared a line, if they still can.
    fn in_one_line(&mut self, run: &'f [Statement]) -> bool {
        let file = self.file;
        let (Some(first), Some(last)) = (run.first(), run.last()) else { return false };
        let end = last.span.end;
        let inside = file.comments.get(self.comment);
        if inside.is_some_and(|comment| comment.span.start < end)
            || run.iter().any(|statement| self.is_split(statement))
        {
            return false;
        }
        let mut line = String::new();
        for statement in run {
            let gap = if statement.span == first.span { 0 } else { GAP };
            let pieces = self.pieces(statement);
            // Bytes are at least columns, nearly: this only ends the search early.
            if line.len() > 4 * WIDTH || width(&line) + gap + pieces.total() > WIDTH {
                return false;
            }
            line.extend(std::iter::repeat_n(' ', gap));
            (0..pieces.list.len()).for_each(|at| line.push_str(pieces.flat(at)));
        }
        self.end = end;
        let comment = self.take_end_comment(end);
        self.page.whole(line, comment, None);
        true
    }

    /// The comment that stands behind a place, which is the end of a statement.
    fn take_end_comment(&mut self, end: u32) -> Option<&'f super::ast::Comment> {
        let file = self.file;
        let following = file.statements.get(file.statements.partition_point(|s| s.span.start < end));
        let at = self.end_comment(self.comment, following)?;
        let comment = file.comments.get(at)?;
        self.comment = at + 1;
        self.end = comment.span.end;
        Some(comment)
    }

    fn statement(&mut self, statement: &'f Statement, following: Option<&Statement>) {
        let file = self.file;
        let first = self.comment;
        let inside =
            file.comments.iter().skip(first).take_while(|comment| comment.span.start < statement.span.end).count();
        let behind = first + inside;
        let end = self.end_comment(behind, following);
        let split = self.is_split(statement);
        let written = if inside == 0 { self.written_sign(statement) } else { None };
        let source = self.source;
        self.pieces(statement);
        let pieces = self.printer.out();
        let comments = &file.comments;
        let range = (first, behind);
        let placed = comments::place(source, statement.span, comments, range, end, pieces);
        if placed.inside.is_empty() && !split && pieces.total() <= WIDTH {
            let mut line = String::with_capacity(pieces.total());
            (0..pieces.list.len()).for_each(|at| line.push_str(pieces.flat(at)));
            let comment = placed.end.and_then(|at| comments.get(at));
            let head = head_of(statement, pieces, written);
            self.page.whole(line, comment, head);
        } else {
            layout::lay(pieces, &placed, comments, split, &mut self.page);
        }
        self.comment = end.map_or(behind, |at| at + 1);
        let last = end.and_then(|at| file.comments.get(at));
        self.end = last.map_or(statement.span.end, |comment| comment.span.end);
    }

    /// Whether the members of the right side were set apart: a line was broken between terms of
    /// the sum that it is, or between entries of the vector.
    fn is_split(&self, statement: &Statement) -> bool {
        let binding = statement.kind.binding();
        let Some(value) = binding.map_or(statement.kind.energy(), |binding| binding.value) else { return false };
        let apart = |one: ExprRef, other: ExprRef| {
            let (one, other) = (self.file.expr(one).span, self.file.expr(other).span);
            self.text(one.end, other.start).contains('\n')
        };
        match self.file.expr(value).kind {
            ExprKind::Sum(terms) => terms.windows(2).any(|two| apart(two[0].value(), two[1].value())),
            ExprKind::Vector(entries) => entries.windows(2).any(|two| apart(two[0], two[1])),
            _ => false,
        }
    }

    /// Where the `=` of a statement stands in the source, if the statement begins a line.
    fn written_sign(&self, statement: &Statement) -> Option<Written> {
        let behind = |span: Span| self.text(span.end, statement.span.end).find('=');
        let (end, equals) = if let StatementKind::Table { name, .. } = &statement.kind {
            (name.span.end, behind(name.span)?)
        } else {
            let binding = statement.kind.binding()?;
            let indices = binding.indices.as_ref().map(|indices| indices.span);
            let unit = binding.unit.map(|unit| self.file.unit(unit).span);
            let end = unit.or(indices).unwrap_or(binding.name.span);
            (end.end, behind(end)?)
        };
        let start = statement.span.start;
        let before = self.text(self.end, start);
        let margin = match before.rfind('\n') {
            Some(at) => before.get(at + 1..)?,
            None if self.end == 0 => before,
            None => return None,
        };
        if !margin.trim_start_matches('\u{feff}').trim().is_empty() {
            return None;
        }
        let head = self.text(start, end + equals as u32);
        (!head.contains('\n'))
            .then(|| Written { column: width(margin) + width(head), padded: head.len() > head.trim_end().len() + 1 })
    }
}

/// What lines up the `=` of a statement in one line.
fn head_of(statement: &Statement, pieces: &Pieces<'_>, written: Option<Written>) -> Option<Head> {
    let (mut depth, mut byte, mut colon) = (0_usize, 0, None);
    for (at, piece) in pieces.list.iter().enumerate() {
        match piece {
            Piece::Open(_) => depth += 1,
            Piece::Close => depth = depth.saturating_sub(1),
            Piece::Token(text) if depth == 0 && text == ":" => colon = Some(pieces.between(0, at)),
            Piece::Token(text) if depth == 0 && text == "=" => {
                let (word, column) = (std::mem::discriminant(&statement.kind), pieces.between(0, at));
                return Some(Head { word, byte, column, colon, written });
            }
            Piece::Token(_) | Piece::Blank | Piece::Place(..) => {}
        }
        byte += pieces.flat(at).len();
    }
    None
}
