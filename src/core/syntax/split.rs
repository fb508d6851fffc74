//! Cuts the text into statements, in one pass over its tokens and without recursion.
//!
//! A statement begins with its word and ends where the next one begins, so a mistake in one
//! leaves the others whole. What can be refused without knowing the grammar is refused here:
//! characters that mean nothing, half numbers, brackets without partner, and nesting beyond
//! [`MOST_LEVELS`], so that no later pass meets a tree too deep for its stack. What stands in a
//! statement is not read here.

use hashbrown::HashSet;

use super::ast::Comment;
use super::error::SyntaxError;
use super::lexer::{Lexer, Token, TokenKind, is_letter, is_word_rest};
use super::lookalike::{self, Lookalike};
use super::{explain, words};
use crate::span::Span;

/// Brackets, signs, powers and primes within each other, all counted alike.
pub(super) const MOST_LEVELS: usize = 256;

/// More errors than anybody reads; the search ends there.
pub(super) const MOST_ERRORS: usize = 1000;

/// In bytes; a longer sum is not rewritten, since every index in braces would copy it.
const LONGEST_SUMMAND: usize = 1000;

/// A statement's place.
#[derive(Clone, Copy, Debug)]
pub(super) struct Piece {
    /// From its word to the end of its last token.
    pub(super) span: Span,
    /// Whether an error in it is known already.
    pub(super) broken: bool,
}

/// What the scan found.
#[derive(Debug, Default)]
pub(super) struct Pieces {
    pub(super) statements: Vec<Piece>,
    pub(super) comments: Vec<Comment>,
    pub(super) errors: Vec<SyntaxError>,
}

/// An open bracket, with the chains of the level around it.
struct Bracket {
    span: Span,
    character: u8,
    subscript: bool,
    chain: usize,
    nots: usize,
}

#[derive(Default)]
struct Splitter<'s> {
    source: &'s str,
    found: Pieces,
    current: Option<Piece>,
    /// The word that `current` begins with.
    word: &'s str,
    coordinates: HashSet<&'s str>,
    /// Behind text that belongs to no statement, until the next one begins.
    lost: bool,
    /// Whether a comment of another language interrupts `current`, so that nothing may go on behind it.
    interrupted: bool,
    previous: Option<Token>,
    in_unit: bool,
    brackets: Vec<Bracket>,
    /// Signs, powers and postfix operators of the operand being read.
    chain: usize,
    /// `not`s before it: they reach as far as the next `and`, `or` or comma.
    nots: usize,
    /// All levels open: brackets, and the chains of this level and of those around it.
    levels: usize,
}

/// The statements of `source` from byte `start` on.
pub(super) fn split(source: &str, start: u32) -> Pieces {
    let mut splitter = Splitter { source, ..Splitter::default() };
    let mut lexer = Lexer::new(source, Span::new(start, source.len() as u32));
    while let Some(token) = lexer.next() {
        if splitter.found.errors.len() >= MOST_ERRORS {
            break;
        }
        if splitter.take(token, lexer) {
            lexer.skip_line();
        }
    }
    splitter.finish();
    splitter.found
}

/// Whether an operand has to follow the token.
pub(super) fn expects_operand(kind: TokenKind, text: &str) -> bool {
    match kind {
        TokenKind::Plus
        | TokenKind::Minus
        | TokenKind::Star
        | TokenKind::DoubleStar
        | TokenKind::Slash
        | TokenKind::Caret
        | TokenKind::Equals
        | TokenKind::Comparison
        | TokenKind::PlusMinus
        | TokenKind::Comma
        | TokenKind::Colon
        | TokenKind::Range
        | TokenKind::Open => true,
        TokenKind::Word => words::is_connective(text),
        _ => false,
    }
}

impl<'s> Splitter<'s> {
    /// Reads a token; `true` if the rest of the line is of no use.
    fn take(&mut self, token: Token, rest: Lexer<'s>) -> bool {
        if token.kind == TokenKind::Comment {
            let text = token.text(self.source).get(1..).unwrap_or("");
            let text = text.strip_suffix('\r').unwrap_or(text).into();
            self.found.comments.push(Comment { text, span: token.span(), trailing: !token.first_on_line });
            return false;
        }
        if token.kind == TokenKind::Word && self.begins_statement(token, rest) {
            self.finish();
            self.current = Some(Piece { span: token.span(), broken: false });
            self.word = token.text(self.source);
            self.lost = false;
        } else if let Some(error) = self.foreign_line(token, rest) {
            let comment = matches!(error, SyntaxError::ForeignComment { .. });
            let passed = comment && self.lost && !token.first_on_line;
            if comment {
                self.interrupted = self.current.is_some();
            } else {
                self.finish();
                self.lost = true;
                self.previous = Some(token);
            }
            // Where all is lost already, the sign need not be one of a comment.
            if !passed {
                self.found.errors.push(error);
            }
            return true;
        } else if token.kind == TokenKind::Semicolon && self.brackets.is_empty() {
            self.finish();
            self.lost = false;
            self.previous = None;
            return false;
        } else if let Some(current) = &mut self.current {
            current.span.end = token.end;
            current.broken |= self.interrupted;
            let is_named = self.brackets.is_empty()
                && self.previous.is_some_and(|own| own.kind == TokenKind::Comma || own.text(self.source) == "coord");
            if self.word == "coord" && is_named && token.kind == TokenKind::Word {
                self.coordinates.insert(token.text(self.source));
            }
            self.inspect(token);
        } else if !self.lost {
            self.lost = true;
            let next = next_token(rest);
            let error = self.lexical_error(token);
            self.found.errors.push(error.unwrap_or_else(|| explain::no_statement(self.source, token, next)));
        } else if let Some(previous) = self.previous {
            let next = next_token(rest);
            let error = explain::unknown_statement(self.source, previous, token, next);
            self.found.errors.extend(error);
        }
        self.previous = Some(token);
        false
    }

    fn foreign_line(&self, token: Token, rest: Lexer<'s>) -> Option<SyntaxError> {
        // Behind its indices a constraint goes on in this line.
        let is_open = self.word == "constraint" && self.previous.is_some_and(|own| own.text(self.source) == "]");
        let is_coordinate = token.first_on_line && !is_open && self.coordinates.contains(token.text(self.source));
        let in_brackets = !self.brackets.is_empty();
        explain::foreign_line(self.source, self.previous, token, rest, in_brackets, self.word, is_coordinate)
    }

    /// Whether the word begins a statement, and isn't a unit, a column, or a mistake.
    fn begins_statement(&self, token: Token, rest: Lexer<'s>) -> bool {
        let word = token.text(self.source);
        if !words::is_statement_word(word) {
            return false;
        }
        let Some(previous) = self.previous else { return true };
        let before = previous.text(self.source);
        // `L = T - V` is lost as a whole.
        if self.lost
            && words::is_function_statement(word)
            && !token.first_on_line
            && expects_operand(previous.kind, before)
            && next_token(rest).is_none_or(|next| next.kind != TokenKind::Equals)
        {
            return false;
        }
        let Some(current) = self.current else { return true };
        if previous.kind == TokenKind::Dot && token.glued {
            return false;
        }
        if self.in_unit
            && matches!(word, "T" | "V")
            && matches!(
                previous.kind,
                TokenKind::Colon | TokenKind::Star | TokenKind::Slash | TokenKind::Open | TokenKind::Caret
            )
        {
            return false;
        }
        // `param T = 300` declares a reserved name; on a line of its own `T` is a statement.
        let names = previous.start == current.span.start && words::is_naming(self.word)
            || previous.kind == TokenKind::Comma && words::takes_several(self.word) && self.brackets.is_empty();
        if names && !token.first_on_line {
            return false;
        }
        // In the middle of an expression the word has to look like the beginning of a statement.
        let at_first = previous.start == current.span.start && !words::is_naming(self.word);
        // Unless it is the unit, or a column.
        let head = self.source.get(..previous.start as usize).unwrap_or_default();
        let is_column = head.ends_with('.') && !head.ends_with("..");
        let names_something = before == "in" && (self.in_unit || is_column);
        if self.brackets.is_empty() && !at_first && (names_something || !expects_operand(previous.kind, before)) {
            return true;
        }
        let Some(next) = next_token(rest) else { return token.first_on_line };
        let follower = next.text(self.source);
        if token.first_on_line && next.first_on_line {
            true
        } else if words::is_function_statement(word) {
            next.kind == TokenKind::Equals || token.first_on_line && follower == "=="
        } else if words::is_naming(word) {
            next.kind == TokenKind::Word && !next.first_on_line && !words::is_connective(follower)
        } else {
            token.first_on_line
                && matches!(next.kind, TokenKind::Word | TokenKind::Number | TokenKind::Open | TokenKind::Minus)
                && !words::is_connective(follower)
        }
    }

    fn report(&mut self, error: SyntaxError) {
        self.found.errors.push(error);
        if let Some(current) = &mut self.current {
            current.broken = true;
        }
    }

    fn lexical_error(&self, token: Token) -> Option<SyntaxError> {
        let text = token.text(self.source);
        let span = token.span();
        match token.kind {
            TokenKind::HalfNumber => {
                let (before, behind) = (self.source.get(..span.range().start)?, self.source.get(span.range().end..)?);
                let goes_on = before.ends_with(|c| matches!(c, '.' | ')' | ']' | '\'') || is_word_rest(c))
                    || text.ends_with('.') && behind.starts_with(is_letter);
                Some(SyntaxError::HalfNumber { fix: (!goes_on).then(|| whole_number(text)), span })
            }
            TokenKind::OpenText => Some(SyntaxError::OpenText { span }),
            TokenKind::Word if !text.is_ascii() => {
                let mut letters = text.char_indices();
                let (at, character, meant) =
                    letters.find_map(|(at, own)| lookalike::composed(own).map(|meant| (at, own, meant)))?;
                let start = token.start + at as u32;
                let span = Span::new(start, start + character.len_utf8() as u32);
                Some(SyntaxError::UnusualLetter { character, meant, span })
            }
            TokenKind::DoubleStar => Some(SyntaxError::DoubleStar { span }),
            TokenKind::Illegal => {
                if let Some(error) = self.index_in_braces(token) {
                    return Some(error);
                }
                let rest = self.source.get(span.range().end..).unwrap_or_default();
                let open = rest.starts_with('(');
                let mut words = Lexer::new(rest, Span::new(0, rest.len() as u32)).map(|own| own.text(rest));
                let is_sum = open && words.nth(2) == Some("in");
                let before = self.source.get(..span.range().start).and_then(|before| before.chars().next_back());
                let is_fraction = matches!(text, "½" | "⅓" | "¼" | "¾");
                // `1½` is 3/2.
                let whole = self.previous.filter(|own| own.kind == TokenKind::Number && !token.first_on_line);
                let whole = whole.filter(|_| is_fraction).map(|own| own.text(self.source));
                let is_glued = whole.is_some() || (is_fraction || text == "√") && before.is_some_and(is_word_rest);
                let read = if text == "&" && rest.trim_start().starts_with('=') { "&=" } else { text };
                let (fix, hint) = match lookalike::advice(read) {
                    _ if text == "√" && open => (Some("sqrt".to_owned()), None),
                    _ if text == "∑" && is_sum => (Some("sum".to_owned()), None),
                    Lookalike::Write(fix) => match whole {
                        Some(whole) => (Some(format!("({whole} + {})", fix.trim_matches(['(', ')']))), None),
                        None => (Some(apart(fix, before, rest.chars().next())), None),
                    },
                    Lookalike::Say(hint) => (None, Some(hint)),
                    Lookalike::Unknown => (None, None),
                };
                Some(SyntaxError::IllegalCharacter { character: shown(text), hint, fix, is_glued, span })
            }
            _ => None,
        }
    }

    /// `Sum[m[i], {i, 1, 3}]`, with `token` the first index in braces.
    fn index_in_braces(&self, token: Token) -> Option<SyntaxError> {
        let open = self.brackets.last()?.span;
        let head = self.source.get(..open.range().start)?;
        let (foreign, own) = [("Sum", "sum"), ("sum", "sum"), ("Integrate", "integral")]
            .into_iter()
            .find(|(foreign, _)| head.ends_with(foreign))?;
        let body = self.source.get(open.range().end..token.span().range().start)?.trim_end().strip_suffix(',')?.trim();
        if body.len() > LONGEST_SUMMAND {
            return None;
        }
        let mut ranges = Vec::new();
        let mut rest = self.source.get(token.span().range().start..)?;
        while let Some((index, behind)) = rest.strip_prefix('{').and_then(|rest| rest.split_once('}')) {
            ranges.push(range_in_braces(index)?);
            rest = behind.trim_start();
            rest = rest.strip_prefix(',').map_or(rest, str::trim_start);
        }
        if !rest.starts_with([')', ']']) {
            return None;
        }
        let body = without_double_brackets(body);
        let text = match own {
            "sum" => format!("sum({}, {body})", ranges.join(", ")),
            // The first is the outermost.
            _ => ranges.iter().rfold(body, |inside, range| format!("{own}({range}, {inside})")),
        };
        let is_short = text.chars().count() <= 60;
        let fix = if is_short { text.clone() } else { format!("{own}({}, …)", ranges.first()?) };
        let start = (open.range().start - foreign.len()) as u32;
        let end = (self.source.len() - rest.len() + 1) as u32;
        Some(SyntaxError::IndexInBraces { fix, text, span: Span::new(start, end) })
    }

    /// Whether a token is in what the last mistake rewrites, as the second index of a sum in braces.
    fn is_rewritten(&self, token: Token) -> bool {
        let last = self.found.errors.last();
        last.is_some_and(|own| matches!(own, SyntaxError::IndexInBraces { span, .. } if token.end <= span.end))
    }

    /// One more level; an error where it is one too many.
    fn deepen(&mut self, token: Token) {
        self.levels += 1;
        if self.levels == MOST_LEVELS + 1 && !self.current.is_some_and(|piece| piece.broken) {
            self.report(SyntaxError::NestingTooDeep { most: MOST_LEVELS, span: token.span() });
        }
    }

    fn link(&mut self, token: Token) {
        self.chain += 1;
        self.deepen(token);
    }

    /// An operand is complete.
    fn end_operand(&mut self) {
        self.levels -= self.chain;
        self.chain = 0;
    }

    /// A condition is complete.
    fn end_condition(&mut self) {
        self.end_operand();
        self.levels -= self.nots;
        self.nots = 0;
    }

    fn open(&mut self, token: Token, subscript: bool) {
        let character = self.source.as_bytes()[token.start as usize];
        self.brackets.push(Bracket { span: token.span(), character, subscript, chain: self.chain, nots: self.nots });
        self.chain = 0;
        self.nots = 0;
        self.deepen(token);
    }

    fn close(&mut self, token: Token) {
        let character = self.source.as_bytes()[token.start as usize];
        self.end_condition();
        let Some(bracket) = self.brackets.pop() else {
            self.report(SyntaxError::StrayBracket { bracket: char::from(character), span: token.span() });
            return;
        };
        self.levels -= 1;
        self.chain = bracket.chain;
        self.nots = bracket.nots;
        if (bracket.character == b'(') != (character == b')') {
            let [opening, close] = [bracket.character, character].map(char::from);
            let (open, span) = (bracket.span, token.span());
            self.report(SyntaxError::MismatchedBracket { bracket: opening, open, close, span });
        } else if bracket.subscript {
            self.link(token);
        }
    }

    /// Follows brackets and chains through a token of the current statement.
    fn inspect(&mut self, token: Token) {
        if let Some(error) = self.lexical_error(token).filter(|_| !self.is_rewritten(token)) {
            self.report(error);
        }
        let first = self.current.map(|piece| piece.span.start);
        let operand_before =
            self.previous.is_some_and(|p| Some(p.start) != first && !expects_operand(p.kind, p.text(self.source)));
        match token.kind {
            TokenKind::Open => {
                let subscript = operand_before && self.source.as_bytes()[token.start as usize] == b'[';
                self.open(token, subscript);
            }
            TokenKind::Close => self.close(token),
            TokenKind::Minus if operand_before => self.end_operand(),
            TokenKind::Prime | TokenKind::Caret | TokenKind::Dot | TokenKind::Minus => self.link(token),
            TokenKind::Word => match token.text(self.source) {
                "not" => {
                    self.nots += 1;
                    self.deepen(token);
                }
                "and" | "or" | "where" | "in" => self.end_condition(),
                _ => {}
            },
            TokenKind::Plus | TokenKind::Star | TokenKind::DoubleStar | TokenKind::Slash | TokenKind::Comparison => {
                self.end_operand()
            }
            TokenKind::Range | TokenKind::PlusMinus => self.end_condition(),
            TokenKind::Comma | TokenKind::Equals | TokenKind::Colon => {
                self.end_condition();
                self.in_unit = token.kind == TokenKind::Colon;
            }
            TokenKind::Semicolon => {
                if let Some(bracket) = self.brackets.last() {
                    let open = bracket.span;
                    self.report(SyntaxError::SemicolonInBrackets { span: token.span(), open });
                }
            }
            _ => {}
        }
    }

    /// Ends the current statement.
    fn finish(&mut self) {
        let Some(mut piece) = self.current.take() else { return };
        if let Some(bracket) = self.brackets.last()
            && !piece.broken
        {
            let (open, end) = (bracket.span, Span::new(piece.span.end, piece.span.end));
            self.found.errors.push(SyntaxError::UnclosedBracket { bracket: bracket.character.into(), open, end });
            piece.broken = true;
        }
        self.found.statements.push(piece);
        self.brackets.clear();
        self.interrupted = false;
        self.chain = 0;
        self.nots = 0;
        self.levels = 0;
        self.in_unit = false;
    }
}

fn next_token(rest: Lexer<'_>) -> Option<Token> {
    rest.code().next()
}

/// A word with blanks where letters or digits stand beside it: `i in 1..2` for `i∈1..2`.
fn apart(word: String, before: Option<char>, behind: Option<char>) -> String {
    let is_glued =
        |own: Option<char>, beside: Option<char>| own.is_some_and(is_word_rest) && beside.is_some_and(is_word_rest);
    let blank = |is_glued: bool| if is_glued { " " } else { "" };
    let [left, right] = [is_glued(before, word.chars().next()), is_glued(word.chars().next_back(), behind)].map(blank);
    format!("{left}{word}{right}")
}

/// `1.` as `1.0`, `.5` as `0.5`.
fn whole_number(text: &str) -> String {
    match text.split_once('.') {
        Some(("", after)) => format!("0.{after}"),
        Some((before, after)) => format!("{before}.0{after}"),
        None => text.to_owned(),
    }
}

/// `i in 1..3` for `i, 1, 3`.
fn range_in_braces(index: &str) -> Option<String> {
    match index.split(',').map(str::trim).collect::<Vec<&str>>().as_slice() {
        [name, to] => Some(format!("{name} in 1..{to}")),
        [name, from, to] => Some(format!("{name} in {from}..{to}")),
        _ => None,
    }
}

/// `x[i]` for `x[[i]]`.
fn without_double_brackets(text: &str) -> String {
    let (mut out, mut rest) = (String::new(), text);
    while let Some((before, behind)) = rest.split_once("[[") {
        let inside = behind.split_once("]]").filter(|(inside, _)| !inside.contains(['[', ']']));
        let Some((inside, behind)) = inside else { break };
        out.push_str(&format!("{before}[{inside}]"));
        rest = behind;
    }
    out + rest
}

/// The character as it can be shown: unseen ones by number.
fn shown(run: &str) -> String {
    let is_unseen = |c: char| matches!(c, '\u{300}'..='\u{36f}' | '\u{200b}'..='\u{200f}' | '\u{2060}' | '\u{feff}');
    match run.chars().next() {
        Some(c) if c.is_control() || c.is_whitespace() || is_unseen(c) => format!("U+{:04X}", u32::from(c)),
        _ => run.chars().take(20).collect(),
    }
}
