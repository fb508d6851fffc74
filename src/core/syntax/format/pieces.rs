//! A statement as a row of tokens, places to break, and groups, with its widths.

use std::borrow::Cow;

use unicode_width::UnicodeWidthStr;

use super::super::print::{Break, Group, Sink};

/// A member of the row.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Piece<'f> {
    Token(Cow<'f, str>),
    Blank,
    Place(Break, &'static str),
    Open(Group),
    Close,
}

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
        match (self.before.get(from), self.before.get(to)) {
            (Some(start), Some(end)) => end.saturating_sub(*start) as usize,
            (Some(_), None) | (None, Some(_)) | (None, None) => 0,
        }
    }

    /// The text of a piece in one line.
    pub(super) fn flat(&self, at: usize) -> &str {
        match self.list.get(at) {
            Some(Piece::Token(text)) => text,
            Some(Piece::Blank) => " ",
            Some(Piece::Place(_, flat)) => flat,
            Some(Piece::Open(_) | Piece::Close) | None => "",
        }
    }

    /// Takes the widths again after a change.
    pub(super) fn measure(&mut self) {
        let list = std::mem::take(&mut self.list);
        self.clear();
        list.into_iter().for_each(|piece| self.push(piece));
    }

    fn push(&mut self, piece: Piece<'f>) {
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

impl<'f> Sink<'f> for Pieces<'f> {
    fn token(&mut self, text: Cow<'f, str>) {
        self.push(Piece::Token(text));
    }

    fn blank(&mut self) {
        self.push(Piece::Blank);
    }

    fn place(&mut self, kind: Break, flat: &'static str) {
        self.push(Piece::Place(kind, flat));
    }

    fn open(&mut self, group: Group) {
        self.push(Piece::Open(group));
    }

    fn close(&mut self) {
        self.push(Piece::Close);
    }
}
