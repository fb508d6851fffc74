//! The text as a row of tokens, for finding statements and for explaining mistakes.
//!
//! Every byte of the text belongs to a token, a comment or white space; what the language has no
//! use for becomes a token too, so that it can be pointed at. The grammar has its own idea of
//! tokens and the tree is built from that one alone.

use crate::span::Span;

/// In bytes; a longer group in braces is not read as one, so that looking ahead stays cheap.
const LONGEST_GROUP: usize = 200;

/// What a token is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum TokenKind {
    Comment,
    Word,
    Number,
    /// `1.` or `.5`.
    HalfNumber,
    Text,
    /// A quote without its partner on the same line.
    OpenText,
    Open,
    Close,
    Prime,
    Dot,
    Range,
    Comma,
    Colon,
    Semicolon,
    Plus,
    Minus,
    Star,
    Slash,
    Caret,
    DoubleStar,
    Equals,
    Comparison,
    PlusMinus,
    /// Characters that mean nothing in the language.
    Illegal,
}

/// A token and its place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Token {
    pub(super) kind: TokenKind,
    pub(super) start: u32,
    pub(super) end: u32,
    /// Whether it is the first on its line.
    pub(super) first_on_line: bool,
    /// Whether it follows the token before it without a gap.
    pub(super) glued: bool,
}

impl Token {
    pub(super) fn span(self) -> Span {
        Span::new(self.start, self.end)
    }

    pub(super) fn text(self, source: &str) -> &str {
        source.get(self.span().range()).unwrap_or("")
    }

    /// How many brackets are open behind it, of which so many were before it.
    pub(super) fn depth_behind(self, depth: usize) -> usize {
        match self.kind {
            TokenKind::Open => depth + 1,
            TokenKind::Close => depth.saturating_sub(1),
            _ => depth,
        }
    }
}

/// Whether a name may begin with the character.
pub(super) fn is_letter(c: char) -> bool {
    if c.is_ascii() { c.is_ascii_alphabetic() || c == '_' } else { pest::unicode::LETTER(c) }
}

/// Whether a name may go on with the character.
pub(super) fn is_word_rest(c: char) -> bool {
    if c.is_ascii() {
        c.is_ascii_alphanumeric() || c == '_'
    } else {
        pest::unicode::LETTER(c) || pest::unicode::DECIMAL_NUMBER(c)
    }
}

/// Superscript and subscript signs are read as one group: `⁻³`.
fn script_group(c: char) -> u8 {
    match c {
        '¹' | '²' | '³' | '⁰' | '⁴'..='⁹' | '⁺' | '⁻' => 1,
        '₀'..='₉' => 2,
        _ => 0,
    }
}

/// Runs over the tokens of a text; `Copy`, so that looking ahead is a copy.
#[derive(Clone, Copy)]
pub(super) struct Lexer<'s> {
    source: &'s str,
    at: usize,
    end: usize,
    first_on_line: bool,
}

impl<'s> Lexer<'s> {
    /// The tokens of `source` within `span`.
    pub(super) fn new(source: &'s str, span: Span) -> Self {
        Self { source, at: span.range().start, end: span.range().end.min(source.len()), first_on_line: true }
    }

    /// Without comments.
    pub(super) fn code(self) -> impl Iterator<Item = Token> {
        self.filter(|token| token.kind != TokenKind::Comment)
    }

    fn byte(&self, ahead: usize) -> u8 {
        let at = self.at + ahead;
        if at < self.end { self.source.as_bytes()[at] } else { 0 }
    }

    fn character(&self) -> Option<char> {
        self.source.get(self.at..self.end)?.chars().next()
    }

    /// Goes on behind the end of the line.
    pub(super) fn skip_line(&mut self) {
        let rest = &self.source.as_bytes()[self.at..self.end];
        self.at += rest.iter().position(|&b| b == b'\n').unwrap_or(rest.len());
    }

    fn skip_space(&mut self) {
        while self.at < self.end {
            match self.source.as_bytes()[self.at] {
                b'\n' => self.first_on_line = true,
                b' ' | b'\t' | b'\r' => {}
                _ => break,
            }
            self.at += 1;
        }
    }

    fn digits(&mut self) {
        while self.byte(0).is_ascii_digit() {
            self.at += 1;
        }
    }

    fn exponent(&mut self) {
        if matches!(self.byte(0), b'e' | b'E') {
            let sign = usize::from(matches!(self.byte(1), b'+' | b'-'));
            if self.byte(1 + sign).is_ascii_digit() {
                self.at += 1 + sign;
                self.digits();
            }
        }
    }

    fn number(&mut self) -> TokenKind {
        self.digits();
        let mut kind = TokenKind::Number;
        if self.byte(0) == b'.' {
            if self.byte(1).is_ascii_digit() {
                self.at += 1;
                self.digits();
            } else if self.byte(1) != b'.' {
                self.at += 1;
                kind = TokenKind::HalfNumber;
            }
        }
        self.exponent();
        kind
    }

    /// As far as the characters go on so.
    fn run(&mut self, kind: TokenKind, goes_on: impl Fn(&char) -> bool) -> TokenKind {
        while let Some(c) = self.character().filter(&goes_on) {
            self.at += c.len_utf8();
        }
        kind
    }

    fn word(&mut self) -> TokenKind {
        self.run(TokenKind::Word, |c| is_word_rest(*c))
    }

    fn quoted(&mut self) -> TokenKind {
        let rest = &self.source.as_bytes()[self.at + 1..self.end];
        let inside = rest.iter().take_while(|byte| !matches!(byte, b'\n' | b'\r' | b'"')).count();
        self.at += 1 + inside;
        if self.byte(0) == b'"' { self.sign(TokenKind::Text, 1) } else { TokenKind::OpenText }
    }

    fn illegal(&mut self, first: char) -> TokenKind {
        let group = script_group(first);
        self.run(TokenKind::Illegal, |c| *c == first || (group != 0 && script_group(*c) == group))
    }

    /// `\dot{x}`, `\frac{1}{2}`: a backslash, a word and what belongs to it in braces.
    fn command(&mut self) -> TokenKind {
        self.at += 1;
        self.word();
        while self.byte(0) == b'{' {
            let Some(length) = self.group() else { break };
            self.at += length;
        }
        TokenKind::Illegal
    }

    /// The length of the group in braces that begins here, if it ends nearby on the line.
    fn group(&self) -> Option<usize> {
        let rest = &self.source.as_bytes()[self.at..self.end.min(self.at + LONGEST_GROUP)];
        let mut depth = 0_usize;
        for (at, byte) in rest.iter().enumerate() {
            match byte {
                b'{' => depth += 1,
                b'}' if depth == 1 => return Some(at + 1),
                b'}' => depth -= 1,
                b'\n' => return None,
                _ => {}
            }
        }
        None
    }

    fn sign(&mut self, kind: TokenKind, length: usize) -> TokenKind {
        self.at += length;
        kind
    }

    fn kind(&mut self) -> TokenKind {
        let next = self.byte(1);
        match self.byte(0) {
            b'#' => {
                self.skip_line();
                TokenKind::Comment
            }
            b'0'..=b'9' => self.number(),
            b'"' => self.quoted(),
            b'(' | b'[' => self.sign(TokenKind::Open, 1),
            b')' | b']' => self.sign(TokenKind::Close, 1),
            b'\'' => self.sign(TokenKind::Prime, 1),
            b'.' if next == b'.' => self.sign(TokenKind::Range, 2),
            b'.' if next.is_ascii_digit() => {
                self.at += 1;
                self.digits();
                self.exponent();
                TokenKind::HalfNumber
            }
            // Not signs of the language, but of others that work on arrays.
            b'.' if matches!(next, b'*' | b'/' | b'^') => self.sign(TokenKind::Illegal, 2),
            b'.' => self.sign(TokenKind::Dot, 1),
            b',' => self.sign(TokenKind::Comma, 1),
            b':' => self.sign(TokenKind::Colon, 1),
            b';' => self.sign(TokenKind::Semicolon, 1),
            b'+' if next == b'/' && self.byte(2) == b'-' => self.sign(TokenKind::PlusMinus, 3),
            b'+' => self.sign(TokenKind::Plus, 1),
            b'-' => self.sign(TokenKind::Minus, 1),
            b'*' if next == b'*' => self.sign(TokenKind::DoubleStar, 2),
            b'*' => self.sign(TokenKind::Star, 1),
            b'/' => self.sign(TokenKind::Slash, 1),
            b'^' => self.sign(TokenKind::Caret, 1),
            b'\\' if next.is_ascii_alphabetic() => self.command(),
            // A thin space of TeX, and what stands below each other.
            b'\\' if matches!(next, b',' | b';' | b':' | b'!') => self.sign(TokenKind::Illegal, 2),
            b'&' if next == b'=' => self.sign(TokenKind::Illegal, 2),
            b'{' => match self.group() {
                Some(length) => self.sign(TokenKind::Illegal, length),
                None => self.illegal('{'),
            },
            // Not signs of the language, but meant as one.
            b'<' if next == b'>' => self.sign(TokenKind::Illegal, 2),
            b'=' if matches!(next, b'<' | b'>') => self.sign(TokenKind::Illegal, 2),
            b'=' | b'!' | b'<' | b'>' if next == b'=' => self.sign(TokenKind::Comparison, 2),
            b'=' => self.sign(TokenKind::Equals, 1),
            b'<' | b'>' => self.sign(TokenKind::Comparison, 1),
            _ => match self.character() {
                Some('±') => self.sign(TokenKind::PlusMinus, '±'.len_utf8()),
                Some(c) if is_letter(c) => self.word(),
                Some(c) => self.illegal(c),
                None => self.sign(TokenKind::Illegal, 1),
            },
        }
    }
}

impl Iterator for Lexer<'_> {
    type Item = Token;

    fn next(&mut self) -> Option<Token> {
        let before = self.at;
        self.skip_space();
        if self.at >= self.end {
            return None;
        }
        let start = self.at;
        let first_on_line = std::mem::replace(&mut self.first_on_line, false);
        let kind = self.kind();
        Some(Token {
            kind,
            // Files are at most 32 MB long.
            start: start as u32,
            end: self.at as u32,
            first_on_line,
            glued: before == start,
        })
    }
}
