//! Where the comments inside a statement go.
//!
//! The formatted statement has the tokens of the source in their order, save parentheses that
//! nobody needs, so each comment has its place between two tokens. Lines are broken only at some
//! of these places. A comment at the end of a line goes on to the next place where a line may
//! end, or back behind the operand if an operator ended the line; one on a line of its own goes
//! back to the place in front of what it speaks of. None leaves its statement or passes another.

use super::super::ast::Comment;
use super::super::lexer::{Lexer, TokenKind};
use super::super::print::{Break, Piece};
use super::pieces::Pieces;
use crate::span::Span;

/// How far tokens are searched for that differ from the source: exponents of units.
const NEAR: usize = 6;

/// The comments of a statement, by number in the file.
pub(super) struct Placed {
    /// The piece that is a place to break, and the comment there; in order.
    pub(super) inside: Vec<(usize, usize)>,
    /// The comment behind the last token.
    pub(super) end: Option<usize>,
}

/// Finds the places of the comments `from..to` of the file in the statement at `span`, of which
/// `end` follows behind its last token.
pub(super) fn place(
    source: &str,
    span: Span,
    comments: &[Comment],
    (from, to): (usize, usize),
    end: Option<usize>,
    pieces: &Pieces<'_>,
) -> Placed {
    let mut placed = Placed { inside: Vec::new(), end };
    let inner = comments.get(from..to).unwrap_or(&[]);
    if inner.is_empty() {
        return placed;
    }
    let is_host =
        |piece: &Piece<'_>| matches!(piece, Piece::Place(Break::Member | Break::Fill | Break::Factor | Break::Weak, _));
    let hosts: Vec<usize> = (0..pieces.list.len()).filter(|at| is_host(&pieces.list[*at])).collect();
    let tokens = starts(source, span, pieces);
    let mut next = 0;
    let mut least = 0;
    let mut late = Vec::new();
    for (offset, comment) in inner.iter().enumerate() {
        while tokens.get(next).is_some_and(|(_, start)| *start < comment.span.start) {
            next += 1;
        }
        let before = next.checked_sub(1).and_then(|at| tokens.get(at));
        let behind = tokens.get(next).map_or(pieces.list.len(), |(at, _)| *at);
        let wanted = if comment.trailing {
            let first = before.map_or(0, |(at, _)| *at);
            let next = hosts.partition_point(|at| *at < first);
            // Behind an operator at the end of a line it speaks of what stands before that.
            let first = if is_operator(pieces, first) { first } else { 0 };
            hosts.get(next.saturating_sub(1)).filter(|at| **at + 1 == first).or_else(|| hosts.get(next))
        } else {
            let count = hosts.partition_point(|at| *at < behind);
            hosts.get(count.saturating_sub(1))
        };
        match wanted {
            Some(at) if late.is_empty() => {
                least = least.max(*at);
                placed.inside.push((least, from + offset));
            }
            Some(_) | None => late.push(from + offset),
        }
    }
    // Only one comment has room behind the last token.
    late.extend(placed.end);
    placed.end = late.pop();
    let last = hosts.last().copied().unwrap_or(0);
    placed.inside.extend(late.into_iter().map(|comment| (last, comment)));
    placed
}

fn is_operator(pieces: &Pieces<'_>, at: usize) -> bool {
    let signs = ["+", "-", "*", "/", "and", "or", "==", "!=", "<", "<=", ">", ">="];
    matches!(pieces.list.get(at), Some(Piece::Token(text)) if signs.contains(&text.as_ref()))
}

/// The pieces that are tokens, and where they start in the source; those not found are left out.
fn starts(source: &str, span: Span, pieces: &Pieces<'_>) -> Vec<(usize, u32)> {
    let tokens: Vec<_> = Lexer::new(source, span).code().collect();
    let mut at = 0;
    let mut found = Vec::new();
    for (place, piece) in pieces.list.iter().enumerate() {
        let Piece::Token(text) = piece else { continue };
        let same = |kind: TokenKind, written: &str| written == text || kind == TokenKind::PlusMinus && text == "±";
        let mut steps = 0;
        for (ahead, token) in tokens.iter().enumerate().skip(at) {
            let written = token.text(source);
            if same(token.kind, written) {
                found.push((place, token.start));
                at = ahead + 1;
                break;
            }
            // Parentheses that are not needed may be any number.
            if !matches!(written, "(" | ")") {
                steps += 1;
                if steps > NEAR {
                    break;
                }
            }
        }
    }
    found
}
