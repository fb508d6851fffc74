//! Finds the words for a mistake from the place where the grammar gave up.
//!
//! The grammar knows only what it would have accepted. What a person meant shows in the tokens
//! around the place, so this reads the statement's tokens once more, up to that place, and picks
//! the kind of mistake. It never decides whether a text is right.

mod context;
mod fixes;
mod lines;
mod operands;
mod units;

use super::error::SyntaxError;
use super::lexer::{Lexer, Token, TokenKind};
use super::split::{MOST_ERRORS, expects_operand};
use super::words;
use crate::diagnostic::{is_misspelt, nearest};
use crate::span::Span;
use context::Context;
pub(super) use fixes::{are_factors, separator_in};
pub(super) use lines::foreign_line;

/// The mistake in the statement at `span` that the grammar could not read beyond `at`;
/// `expected` is what it would have accepted, in plain words.
pub(super) fn explain(source: &str, span: Span, at: u32, expected: Vec<&'static str>) -> SyntaxError {
    match Context::read(source, span, at) {
        Some(context) => context.mistake(expected),
        None => SyntaxError::Unexpected { found: "this".to_owned(), expected, span },
    }
}

/// The mistake of text that belongs to no statement and begins with `token`.
pub(super) fn no_statement(source: &str, token: Token, next: Option<Token>) -> SyntaxError {
    let text = token.text(source);
    if token.kind != TokenKind::Word {
        return SyntaxError::NoStatement { found: describe(source, token), span: token.span() };
    }
    let suggestion = suggested(source, token, next);
    let is_unknown = suggestion.is_none() && !words::is_control(text);
    if is_unknown && next.is_some_and(|next| binds(source, next)) && words::reserved_meaning(text).is_none() {
        let declared = fixes::given_by(source, token, next);
        SyntaxError::MissingStatementWord { name: text.to_owned(), fix: None, declared, span: token.span() }
    } else {
        // `end` on a line of its own is not needed.
        let is_certain = match suggestion {
            Some(own) => words::synonym(text) == Some(own) || is_misspelt(text, own),
            None => text == "end" && next.is_none_or(|next| next.first_on_line),
        };
        SyntaxError::UnknownStatement { word: text.to_owned(), suggestion, is_certain, span: token.span() }
    }
}

/// The mistake of a word outside of brackets that was meant to begin a statement: at the
/// beginning of a line, or spelt nearly as a statement word and followed by a name.
pub(super) fn unknown_statement(
    source: &str,
    before: Token,
    found: Token,
    after: Option<Token>,
) -> Option<SyntaxError> {
    let reserved = words::reserved_meaning(found.text(source)).is_some();
    if found.kind != TokenKind::Word
        || reserved
        || expects_operand(before.kind, before.text(source))
        || before.kind == TokenKind::Dot
    {
        return None;
    }
    // `def T(x)`: what follows begins a statement of its own.
    let behind = || Lexer::new(source, Span::new(found.end, source.len() as u32)).code().next();
    let after = if is_definition(found.text(source)) { after.or_else(behind) } else { after };
    let before_word = after.is_some_and(|after| after.kind == TokenKind::Word);
    if !found.first_on_line && !before_word {
        return None;
    }
    let suggestion = suggested(source, found, after);
    let meant = if found.first_on_line {
        let is_end = found.text(source) == "end" && !fixes::is_declared(source, found.start, "end");
        suggestion.is_some() || before_word || is_end || after.is_some_and(|after| binds(source, after))
    } else {
        suggestion.is_some() && before_word
    };
    meant.then(|| no_statement(source, found, after))
}

/// Whether a token gives what stands before it a value, a unit or indices.
fn binds(source: &str, token: Token) -> bool {
    matches!(token.kind, TokenKind::Equals | TokenKind::Colon) || token.text(source) == "["
}

/// The further words in the text at `span`, behind a mistake of that kind, that were meant to
/// begin statements.
pub(super) fn more_unknown_statements(source: &str, span: Span) -> Vec<SyntaxError> {
    let mut errors = Vec::new();
    let mut tokens = Lexer::new(source, span).code().peekable();
    let mut depth = 0_usize;
    let mut before = None;
    // A word that is told, or was before; what follows it may be its name.
    let mut told = span.start;
    while let Some(token) = tokens.next() {
        depth = token.depth_behind(depth);
        if errors.len() >= MOST_ERRORS {
            break;
        }
        if let Some(before) = before.replace(token)
            && depth == 0
        {
            let next = tokens.peek().copied();
            let error = unknown_statement(source, before, token, next);
            let begins = error.is_none()
                && before.start != told
                && token.kind == TokenKind::Word
                && words::reserved_meaning(token.text(source)).is_none()
                && !expects_operand(before.kind, before.text(source))
                && fixes::binds(source, token, span.end);
            let error = error.or_else(|| begins.then(|| no_statement(source, token, next)));
            if error.is_some() {
                told = token.start;
            }
            errors.extend(error);
        }
    }
    errors
}

fn is_definition(word: &str) -> bool {
    matches!(word, "def" | "define")
}

/// The statement word meant by a word, judged by the word and by what follows it.
fn suggested(source: &str, token: Token, next: Option<Token>) -> Option<&'static str> {
    let word = token.text(source);
    let fits = |candidate: &&'static str| match next.map(|next| next.kind) {
        Some(TokenKind::Equals) => words::is_function_statement(candidate),
        Some(TokenKind::Word) => !words::is_function_statement(candidate),
        _ => words::takes_expression(candidate),
    };
    if words::is_control(word) {
        return None;
    }
    let is_energy =
        |own: &&str| words::is_function_statement(own) && next.is_some_and(|next| next.text(source) == *own);
    if is_definition(word)
        && let Some(energy) = words::STATEMENT_WORDS.into_iter().find(is_energy)
    {
        return Some(energy);
    }
    words::synonym(word)
        .or_else(|| words::guessed(word))
        .filter(|s| fits(s))
        .or_else(|| nearest(word, words::STATEMENT_WORDS.into_iter().filter(|s| fits(s))))
}

fn describe(source: &str, token: Token) -> String {
    let text: String = token.text(source).chars().take(30).collect();
    match token.kind {
        TokenKind::Word if !words::is_statement_word(&text) && !words::is_connective(&text) => {
            format!("the name `{text}`")
        }
        TokenKind::Number | TokenKind::HalfNumber => format!("the number `{text}`"),
        TokenKind::Text | TokenKind::OpenText => "text in quotes".to_owned(),
        _ => format!("`{text}`"),
    }
}
