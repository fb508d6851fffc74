//! A statement as a row of tokens, places to break, and groups, with its widths.

use unicode_width::UnicodeWidthStr;

use super::super::print::{Piece, Sink};

/// A statement in pieces.
#[derive(Default)]
pub(super) struct Pieces<'f> {
    pub(super) list: Vec<Piece<'f>>,
    /// How wide all before a piece is in one line, and at the end the whole.
    before: Vec<u32>,
}

/// Columns that a text takes.
pub(super) fn width(text: &str) -> usize {
    if text.bytes().all(|byte| (b' '..0x7f).contains(&byte)) { text.len() } else { text.width() }
}

impl<'f> Pieces<'f> {
    /// Drops all pieces, and keeps the room.
    pub(super) fn clear(&mut self) {
        self.list.clear();
        self.before.clear();
    }

    /// The width of the whole in one line.
    pub(super) fn total(&self) -> usize {
        self.before.last().map_or(0, |end| *end as usize)
    }

    /// The width of the pieces from one up to, not including, another.
    pub(super) fn between(&self, from: usize, to: usize) -> usize {
        let ends = self.before.get(from).zip(self.before.get(to));
        ends.map_or(0, |(start, end)| end.saturating_sub(*start) as usize)
    }

    /// The text of a piece in one line.
    pub(super) fn flat(&self, at: usize) -> &str {
        self.list.get(at).map_or("", Piece::flat)
    }
}

impl<'f> Sink<'f> for Pieces<'f> {
    fn put(&mut self, piece: Piece<'f>) {
        let at = self.list.len();
        self.list.push(piece);
        if at == 0 {
            self.before.push(0);
        }
        let end = self.total() + width(self.flat(at));
        // A statement has at most 32 MB.
        self.before.push(end as u32);
    }
}
