//! Where a long statement can be cut so that its pieces are read one after the other.
//!
//! What pest keeps of a text is much larger than the tree of it, so a sum of a hundred thousand
//! terms is read in pieces. A *region* is what stands between two delimiters: brackets, commas, `=`
//! and `±`. Where nothing in it but brackets binds weaker than `+` and `-`, it is a sum, and cut at
//! its signs its pieces are expressions of their own. Only the places are found here; whether the
//! pieces are right is the grammar's affair.

use super::lexer::{Lexer, Token, TokenKind};
use super::split::expects_operand;
use super::words;
use crate::span::Span;

/// A `+` or `-` between two terms.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sign {
    pub(super) span: Span,
    pub(super) subtracted: bool,
}

/// A sum that can be cut.
#[derive(Clone, Debug)]
pub(super) struct Region {
    /// From its first to its last token.
    pub(super) span: Span,
    /// The signs to cut at, one or more.
    pub(super) signs: Vec<Sign>,
}

/// What is known of a region while its end is sought.
struct Open {
    /// Where its first token begins.
    start: Option<u32>,
    /// Where the piece begins that is being passed.
    piece: u32,
    /// Whether nothing in it binds weaker than a sum.
    plain: bool,
    signs: Vec<Sign>,
}

impl Open {
    fn new() -> Self {
        Self { start: None, piece: 0, plain: true, signs: Vec::new() }
    }

    fn end(self, end: u32) -> Option<Region> {
        let start = self.start?;
        let cut = self.plain && !self.signs.is_empty();
        cut.then_some(Region { span: Span::new(start, end), signs: self.signs })
    }
}

/// The regions of a statement to be cut, inner ones before those around them, into pieces of at
/// least `least` bytes (the last may be shorter).
pub(super) fn regions(source: &str, statement: Span, least: u32) -> Vec<Region> {
    let mut found = Vec::new();
    let mut open = vec![Open::new()];
    let mut previous: Option<Token> = None;
    let mut tokens = Lexer::new(source, statement).filter(|token| token.kind != TokenKind::Comment);
    // The statement's word.
    let Some(word) = tokens.next() else {
        return found;
    };
    let mut end = word.end;
    for token in tokens {
        let operand_before = previous.is_some_and(|before| !expects_operand(before.kind, before.text(source)));
        match token.kind {
            TokenKind::Close | TokenKind::Comma | TokenKind::Equals | TokenKind::PlusMinus => {
                found.extend(open.pop().and_then(|region| region.end(end)));
                if token.kind != TokenKind::Close {
                    open.push(Open::new());
                }
            }
            _ => {}
        }
        if let Some(region) = open.last_mut() {
            let delimiter = matches!(token.kind, TokenKind::Comma | TokenKind::Equals | TokenKind::PlusMinus);
            if region.start.is_none() && !delimiter {
                region.start = Some(token.start);
                region.piece = token.start;
            }
            match token.kind {
                TokenKind::Plus | TokenKind::Minus if operand_before && token.start - region.piece >= least => {
                    region.piece = token.end;
                    region.signs.push(Sign { span: token.span(), subtracted: token.kind == TokenKind::Minus });
                }
                TokenKind::Comparison | TokenKind::Range | TokenKind::Colon => {
                    region.plain = false;
                }
                TokenKind::Word if words::is_connective(token.text(source)) => {
                    region.plain = false;
                }
                _ => {}
            }
        }
        if token.kind == TokenKind::Open {
            open.push(Open::new());
        }
        end = token.end;
        previous = Some(token);
    }
    found.extend(open.pop().and_then(|region| region.end(end)));
    found
}
