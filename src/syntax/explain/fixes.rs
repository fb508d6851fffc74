//! Fixes written out with what the text says: short ones only, for the others a pattern does.

use super::super::lexer::{Lexer, Token, TokenKind};
use super::super::words;
use super::context::Context;
use crate::span::Span;

/// A longer fix would not be read.
const MOST_CHARACTERS: usize = 60;

/// As far back a declaration is looked for: every mistake looks, and files may be long.
const LOOKED_BACK: u32 = 1 << 16;

/// Tokens as they are printed in a fix: without blanks, what stands in brackets left out.
fn compact(source: &str, span: Span) -> Option<String> {
    let mut out = String::new();
    let mut depth = 0_usize;
    for token in Lexer::new(source, span) {
        match token.kind {
            TokenKind::Comment => continue,
            TokenKind::Close => depth = depth.checked_sub(1)?,
            _ => {}
        }
        if depth == 0 {
            out.push_str(token.text(source));
        }
        if token.kind == TokenKind::Open {
            depth += 1;
            if depth == 1 {
                out.push('…');
            }
        }
        if out.len() > 4 * MOST_CHARACTERS {
            return None;
        }
    }
    short(out)
}

/// A piece of the text on one line.
fn verbatim(source: &str, start: u32, end: u32) -> Option<String> {
    let text = source.get(Span::new(start, end).range())?.trim();
    let plain = !text.is_empty() && !text.contains(['\n', '#']);
    short(text.to_owned()).filter(|_| plain)
}

fn short(text: String) -> Option<String> {
    (text.chars().count() <= MOST_CHARACTERS).then_some(text)
}

/// Whether the name at `token` is given a value or a unit: `k = …`, `k[1..3] : N/m`.
pub(super) fn binds(source: &str, token: Token, end: u32) -> bool {
    let mut depth = 0_usize;
    let rest = Lexer::new(source, Span::new(token.end, end));
    for next in rest.filter(|next| next.kind != TokenKind::Comment) {
        match next.kind {
            TokenKind::Open if next.text(source) == "[" || depth > 0 => depth += 1,
            TokenKind::Close if depth > 0 => depth -= 1,
            TokenKind::Equals | TokenKind::Colon if depth == 0 => return true,
            TokenKind::Comparison if depth == 0 => return next.text(source) == "==",
            _ if depth == 0 => return false,
            _ => {}
        }
    }
    false
}

impl Context<'_> {
    /// The product that ends before the place: `1/2` before the `x` of `1/2 x`.
    pub(super) fn product_before(&self) -> Option<String> {
        compact(self.source, Span::new(self.chain?, self.before.end))
    }

    /// `param l = 30 cm`, `param g = 9.81 : m/s^2`: the statement with the unit behind the name.
    pub(super) fn with_unit_behind_name(&self, unit: Token) -> Option<String> {
        let name = verbatim(self.source, self.word.end, self.name_end?)?;
        let value = verbatim(self.source, self.value_start?, self.before.end)?;
        let unit = verbatim(self.source, unit.start, self.unit_end(unit)?)?;
        short(format!("{} {name} : {unit} = {value}", self.statement))
    }

    /// Where a unit ends that begins at a token; `None` where something else goes on.
    pub(super) fn unit_end(&self, unit: Token) -> Option<u32> {
        let rest = Lexer::new(self.source, Span::new(unit.start, self.end));
        let (mut end, mut complete) = (unit.end, false);
        for token in rest.filter(|token| token.kind != TokenKind::Comment) {
            match token.kind {
                TokenKind::Word | TokenKind::Number | TokenKind::Open if complete => break,
                TokenKind::Word | TokenKind::Number | TokenKind::Close => complete = true,
                TokenKind::Open
                | TokenKind::Star
                | TokenKind::Slash
                | TokenKind::Caret
                | TokenKind::Minus => complete = false,
                _ => return None,
            }
            end = token.end;
        }
        complete.then_some(end)
    }

    /// Whether a unit begins at `found`: behind a value of numbers alone, where a name would have to be
    /// declared.
    pub(super) fn is_unit_behind_number(&self, found: Token) -> bool {
        let name = self.text(found);
        self.before.kind == TokenKind::Number
            && self.enclosures.is_empty()
            && matches!(self.statement, "param" | "guess" | "equilibrium")
            && found.kind == TokenKind::Word
            && words::reserved_for(name).is_none()
            && self.value_start.is_some_and(|start| {
                Lexer::new(self.source, Span::new(start, self.before.end))
                    .all(|token| !matches!(token.kind, TokenKind::Word | TokenKind::PlusMinus))
            })
            && !self.is_declared(name)
    }

    /// Whether a name is declared before the statement, and not too long before.
    fn is_declared(&self, name: &str) -> bool {
        let mut from = self.word.start.saturating_sub(LOOKED_BACK);
        while !self.source.is_char_boundary(from as usize) {
            from += 1;
        }
        let mut before: Option<Token> = None;
        let mut word = "";
        let tokens = Lexer::new(self.source, Span::new(from, self.word.start));
        for token in tokens.filter(|token| token.kind != TokenKind::Comment) {
            let text = self.text(token);
            let declares = before.is_some_and(|before| match before.kind {
                TokenKind::Comma => word == "coord",
                _ => words::is_naming(self.text(before)),
            });
            if declares && text == name {
                return true;
            }
            if words::is_statement_word(text) {
                word = text;
            }
            before = Some(token);
        }
        false
    }

    /// The statement begun by the name at the place, whose word is missing: `param k = 2`.
    pub(super) fn with_statement_word(&self, name: Token) -> Option<String> {
        let word = match self.statement {
            "param" | "let" | "guess" | "equilibrium" => self.statement,
            _ => return None,
        };
        let rest = Lexer::new(self.source, Span::new(name.start, self.end));
        let mut tokens = rest.filter(|token| token.kind != TokenKind::Comment);
        let equals =
            tokens.find(|token| token.kind == TokenKind::Equals || self.text(*token) == "==");
        let Some(equals) = equals else {
            let declared = verbatim(self.source, name.start, self.end)?;
            return short(format!("{word} {declared}"));
        };
        let head = verbatim(self.source, name.start, equals.start)?;
        let value = match (tokens.next(), tokens.next()) {
            (Some(only), None) => self.text(only),
            (Some(number), Some(next))
                if number.kind == TokenKind::Number && next.kind == TokenKind::Word =>
            {
                self.text(number)
            }
            _ => "…",
        };
        short(format!("{word} {head} = {value}"))
    }
}
