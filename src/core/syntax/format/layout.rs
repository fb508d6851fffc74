//! Breaks statements into lines.
//!
//! One pass backwards measures how far it is to the next places to break, one pass forwards
//! writes; both are linear in the statement. A group that fits into its line stays in one. In
//! others all members begin lines, or, where they are all short, the lines are filled; beyond
//! that a line is broken where it is full.

use super::super::ast::Comment;
use super::super::print::{Break, Group, Piece};
use super::comments::Placed;
use super::page::Page;
use super::pieces::Pieces;

/// Columns of a line.
pub(super) const WIDTH: usize = 100;
/// Where a statement goes on in its next line; signs of sums stand `SIGN` left of it.
const INDENT: usize = 4;
/// The sign of a term and its blank.
const SIGN: usize = 2;
/// Sums that are right sides are lined up at their first term up to this column, ...
const DEEPEST_SUM: usize = 24;
/// ... lists that are right sides up to this one, ...
const DEEPEST_LIST: usize = 40;
/// ... what stands in brackets up to this one.
const DEEPEST: usize = 60;
/// A factor is moved to the next line rather than broken if that gains so many columns.
const GAIN: usize = 12;
/// Terms up to this width share lines, ...
const SHORT_TERM: usize = 20;
/// ... and entries of lists up to this one.
const SHORT_ENTRY: usize = 12;

/// What is known of each piece before anything is written.
struct Measures {
    /// The end of the group that begins here.
    close: Vec<u32>,
    /// The next place of this level or of one around it, weak ones apart.
    same: Vec<u32>,
    /// The next place that isn't weak.
    strong: Vec<u32>,
    /// The next place of any kind.
    any: Vec<u32>,
    /// Whether a comment inside the group needs a line's end.
    forced: Vec<bool>,
    /// Whether all members of the group are short.
    short: Vec<bool>,
}

impl Measures {
    fn new(pieces: &Pieces<'_>, placed: &Placed) -> Self {
        let count = pieces.list.len();
        let mut measures = Self {
            close: vec![0; count],
            same: vec![0; count],
            strong: vec![0; count],
            any: vec![0; count],
            forced: vec![false; count],
            short: vec![false; count],
        };
        measures.backwards(pieces);
        measures.forwards(pieces, placed);
        measures
    }

    fn backwards(&mut self, pieces: &Pieces<'_>) {
        // Statements have at most 32 MB, and no piece is empty but places and groups.
        let count = pieces.list.len() as u32;
        let mut levels = vec![(count, count)];
        let (mut strong, mut any) = (count, count);
        for (at, piece) in pieces.list.iter().enumerate().rev() {
            let (close, next) = levels.last().copied().unwrap_or((count, count));
            self.same[at] = next;
            self.strong[at] = strong;
            self.any[at] = any;
            let here = at as u32;
            match piece {
                Piece::Close => levels.push((here, next)),
                Piece::Open(_) => {
                    self.close[at] = close;
                    levels.pop();
                }
                Piece::Place(Break::Member | Break::Fill | Break::Factor, _) => {
                    if let Some(level) = levels.last_mut() {
                        level.1 = here;
                    }
                    (strong, any) = (here, here);
                }
                Piece::Place(Break::Weak | Break::Hidden, _) => any = here,
                Piece::Token(_) | Piece::Blank => {}
            }
        }
    }

    fn forwards(&mut self, pieces: &Pieces<'_>, placed: &Placed) {
        struct Level {
            open: usize,
            short: usize,
            item: usize,
            longest: usize,
            forced: bool,
        }
        let mut levels: Vec<Level> = Vec::new();
        let mut comments = placed.inside.iter().peekable();
        for (at, piece) in pieces.list.iter().enumerate() {
            while comments.next_if(|(place, _)| *place <= at).is_some() {
                if let Some(level) = levels.last_mut() {
                    level.forced = true;
                }
            }
            match piece {
                Piece::Open(group) => levels.push(Level {
                    open: at,
                    short: match group {
                        Group::Sum | Group::WholeSum => SHORT_TERM,
                        Group::List | Group::WholeList => SHORT_ENTRY,
                        Group::Other => 0,
                    },
                    item: at + 1,
                    longest: 0,
                    forced: false,
                }),
                Piece::Place(Break::Member, _) => {
                    if let Some(level) = levels.last_mut() {
                        level.longest = level.longest.max(pieces.between(level.item, at));
                        level.item = at + 1;
                    }
                }
                Piece::Close => {
                    let Some(level) = levels.pop() else { continue };
                    let longest = level.longest.max(pieces.between(level.item, at));
                    self.short[level.open] = longest <= level.short;
                    self.forced[level.open] = level.forced;
                    if let Some(around) = levels.last_mut() {
                        around.forced |= level.forced;
                    }
                }
                Piece::Place(Break::Fill | Break::Factor | Break::Weak | Break::Hidden, _)
                | Piece::Token(_)
                | Piece::Blank => {}
            }
        }
    }
}

/// A group that is not in one line.
struct Frame {
    /// Where lines inside it begin.
    indent: usize,
    /// Whether each member begins a line.
    apart: bool,
}

struct Writer<'p, 'f, 's> {
    pieces: &'p Pieces<'f>,
    measures: Measures,
    comments: &'s [Comment],
    page: &'p mut Page<'s>,
    line: String,
    column: usize,
    frames: Vec<Frame>,
}

/// Writes a statement; `split` where its right side was written with its members apart.
pub(super) fn lay<'s>(pieces: &Pieces<'_>, placed: &Placed, comments: &'s [Comment], split: bool, page: &mut Page<'s>) {
    let (measures, line, frames) = (Measures::new(pieces, placed), String::new(), Vec::new());
    let mut writer = Writer { pieces, measures, comments, page, line, column: 0, frames };
    let mut notes = placed.inside.iter().peekable();
    let mut here = Vec::new();
    let mut at = 0;
    while let Some(piece) = pieces.list.get(at) {
        match piece {
            Piece::Token(_) | Piece::Blank => writer.flat(at),
            Piece::Open(group) => {
                if writer.fits(at, *group, split) {
                    let close = writer.measures.close[at] as usize;
                    (at..close).for_each(|inner| writer.flat(inner));
                    at = close;
                } else {
                    writer.open(at, *group, split);
                }
            }
            Piece::Close => _ = writer.frames.pop(),
            Piece::Place(kind, _) => {
                here.clear();
                while let Some((_, comment)) = notes.next_if(|(place, _)| *place <= at) {
                    here.push(*comment);
                }
                if here.is_empty() {
                    writer.place(at, *kind);
                } else {
                    writer.notes(at, &here);
                }
            }
        }
        at += 1;
    }
    let line = std::mem::take(&mut writer.line);
    let end = placed.end.and_then(|comment| comments.get(comment));
    page.line(line, end);
}

impl Writer<'_, '_, '_> {
    fn flat(&mut self, at: usize) {
        self.line.push_str(self.pieces.flat(at));
        self.column += self.pieces.between(at, at + 1);
    }

    fn in_one_line(&self, at: usize) -> bool {
        let close = self.measures.close[at] as usize;
        let end = self.measures.same.get(close).map_or(close, |end| *end as usize);
        self.column + self.pieces.between(at, end) <= WIDTH
    }

    /// Whether a group is to stay in one line.
    fn fits(&self, at: usize, group: Group, split: bool) -> bool {
        let apart = split && matches!(group, Group::WholeSum | Group::WholeList);
        !self.measures.forced[at] && !apart && self.in_one_line(at)
    }

    fn open(&mut self, at: usize, group: Group, split: bool) {
        let whole = matches!(group, Group::WholeSum | Group::WholeList);
        let deepest = match group {
            Group::WholeSum => DEEPEST_SUM,
            Group::WholeList => DEEPEST_LIST,
            Group::Sum | Group::List | Group::Other => DEEPEST,
        };
        let indent = if self.column <= deepest { self.column } else { self.stepped() };
        // Short members share lines, unless comments or the author set them apart.
        let apart = self.measures.forced[at] || !self.measures.short[at] || split && whole && self.in_one_line(at);
        self.frames.push(Frame {
            indent: match group {
                Group::Sum | Group::WholeSum => indent.saturating_sub(SIGN).max(SIGN),
                Group::List | Group::WholeList | Group::Other => indent,
            },
            apart,
        });
    }

    fn indent(&self) -> usize {
        self.frames.last().map_or(INDENT, |frame| frame.indent)
    }

    /// The indent where lining up would be too deep.
    fn stepped(&self) -> usize {
        self.frames.last().map_or(INDENT, |frame| (frame.indent + INDENT).min(DEEPEST))
    }

    /// Where the line that begins at a place begins: further left where it wouldn't fit.
    fn indent_at(&self, at: usize) -> usize {
        let reach = self.pieces.between(at + 1, self.measures.any[at] as usize);
        self.indent().min(WIDTH.saturating_sub(reach)).max(SIGN)
    }

    fn place(&mut self, at: usize, kind: Break) {
        let blank = self.pieces.between(at, at + 1);
        let rest = WIDTH.saturating_sub(self.column + blank);
        let to = |next: &[u32]| self.pieces.between(at + 1, next[at] as usize);
        let item = to(&self.measures.same);
        let stays = match kind {
            Break::Member => {
                let apart = self.frames.last().is_some_and(|frame| frame.apart);
                !apart && item <= rest
            }
            Break::Fill | Break::Factor => {
                let moved =
                    self.indent() + item <= WIDTH && (kind == Break::Fill || self.column >= self.indent() + GAIN);
                item <= rest || !moved && to(&self.measures.strong) <= rest
            }
            Break::Weak | Break::Hidden => to(&self.measures.any) <= rest,
        };
        let indent = self.indent_at(at);
        if stays || kind != Break::Member && indent >= self.column && !self.unindent(at) {
            self.flat(at);
        } else {
            self.end_line(at);
        }
    }

    /// Behind a bracket: gives up lining up with it, where that helps.
    fn unindent(&mut self, at: usize) -> bool {
        let behind = at.checked_sub(1).and_then(|before| self.pieces.list.get(before));
        if !matches!(behind, Some(Piece::Open(_))) {
            return false;
        }
        let Some(frame) = self.frames.pop() else { return false };
        let indent = self.stepped().min(frame.indent);
        let helps = indent < self.column;
        self.frames.push(Frame { indent, ..frame });
        helps
    }

    fn end_line(&mut self, at: usize) {
        let line = std::mem::take(&mut self.line);
        self.page.line(line, None);
        self.begin_line(at);
    }

    fn begin_line(&mut self, at: usize) {
        self.column = self.indent_at(at);
        self.line = " ".repeat(self.column);
    }

    /// Writes comments at a place: the first behind what stands before it, if it stood so, the
    /// others on lines of their own.
    fn notes(&mut self, at: usize, notes: &[usize]) {
        let mut line = Some(std::mem::take(&mut self.line));
        let indent = self.indent_at(at);
        for note in notes {
            let Some(comment) = self.comments.get(*note) else { continue };
            match line.take() {
                Some(code) if comment.trailing => self.page.line(code, Some(comment)),
                Some(code) => {
                    self.page.line(code, None);
                    self.page.remark(indent, comment);
                }
                None => self.page.remark(indent, comment),
            }
        }
        if let Some(code) = line {
            self.page.line(code, None);
        }
        self.begin_line(at);
    }
}
