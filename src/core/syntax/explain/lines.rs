//! Lines as other languages and the blackboard have them: comments, imports, equations of motion.
//!
//! A right model has no word that begins a line and neither a statement nor an operand, so it is not read twice here.

use super::super::error::{SyntaxError, is_import};
use super::super::lexer::{Lexer, Token, TokenKind};
use super::super::split::expects_operand;
use super::super::words;
use crate::span::Span;

/// What begins a comment elsewhere and is nothing here; `--` is a sign twice.
const COMMENT_MARKS: [&str; 2] = ["//", "%"];

/// The mistake of a line that begins at `token`, or of its rest if that is a comment; `before` is the token before it.
pub(in super::super) fn foreign_line(
    source: &str,
    before: Option<Token>,
    token: Token,
    rest: Lexer<'_>,
    in_brackets: bool,
) -> Option<SyntaxError> {
    let complete = before.is_none_or(|before| {
        let text = before.text(source);
        !expects_operand(before.kind, text) && before.kind != TokenKind::Dot && !words::is_statement_word(text)
    });
    let first = token.first_on_line && !in_brackets && complete;
    match token.kind {
        TokenKind::Slash | TokenKind::Illegal if !in_brackets || token.first_on_line => {
            let text = source.get(token.start as usize..)?;
            let mark = COMMENT_MARKS.into_iter().find(|mark| text.starts_with(mark))?;
            // `param p : % = 5` is meant as a unit.
            let unit = before.is_some_and(|before| before.kind == TokenKind::Colon);
            let span = Span::new(token.start, token.start + mark.len() as u32);
            (!unit).then_some(SyntaxError::ForeignComment { span })
        }
        TokenKind::Word | TokenKind::Number if first => of_another_language(source, token, rest),
        _ => None,
    }
}

fn of_another_language(source: &str, token: Token, rest: Lexer<'_>) -> Option<SyntaxError> {
    let mut line = vec![token];
    let others = rest.into_iter().filter(|other| other.kind != TokenKind::Comment);
    line.extend(others.take_while(|other| !other.first_on_line));
    let span = token.span().to(line.last()?.span());
    let word = token.text(source);
    let next = line.get(1).map(|next| next.kind);
    if is_import(word) && next == Some(TokenKind::Word) {
        return Some(SyntaxError::UnknownStatement { word: word.to_owned(), suggestion: None, span });
    }
    if word == "t" && next == Some(TokenKind::Equals) {
        let span = token.span();
        return Some(SyntaxError::UnknownStatement { word: word.to_owned(), suggestion: Some("T"), span });
    }
    let gives = |own: &Token| own.kind == TokenKind::Equals || own.text(source) == "==";
    let second = line.windows(3).find(|three| {
        matches!(three, [name, first, second] if name.kind == TokenKind::Word
            && first.kind == TokenKind::Prime && second.kind == TokenKind::Prime)
    })?;
    let coordinate = second.first()?.text(source).to_owned();
    line.iter().any(gives).then_some(SyntaxError::EquationOfMotion { coordinate, span })
}
