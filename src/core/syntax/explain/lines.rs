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

/// The mistake of a line that begins at `token`, or of its rest if that is a comment; `before` is the token before it, in a
/// statement that begins with the word `statement`.
pub(in super::super) fn foreign_line(
    source: &str,
    before: Option<Token>,
    token: Token,
    rest: Lexer<'_>,
    in_brackets: bool,
    statement: &str,
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
            // `7 // 2` and `n % 2` may be meant as numbers: a text has two words without a sign between them.
            let operand = |token: Token| matches!(token.kind, TokenKind::Word | TokenKind::Number | TokenKind::Open);
            let line = text.lines().next().unwrap_or_default().trim_start_matches(mark);
            let mut behind = Lexer::new(line, Span::new(0, line.len() as u32));
            let is_text = [behind.next(), behind.next()].into_iter().all(|own| own.is_some_and(operand));
            let is_certain = token.first_on_line && complete || is_text;
            (!unit).then_some(SyntaxError::ForeignComment { is_certain, span })
        }
        TokenKind::Word | TokenKind::Number if first => of_another_language(source, token, rest, statement),
        _ => None,
    }
}

/// `x^2 + y^2 = 1`: an equation of more than a name on its left, without accelerations; one that follows a `constraint` may
/// belong to it.
fn constraint_without_word(source: &str, line: &[Token], statement: &str) -> Option<SyntaxError> {
    let equals = line.iter().position(|own| own.kind == TokenKind::Equals)?;
    let (left, right) = (line.get(..equals)?, line.get(equals + 1..)?);
    let mut depth = 0_usize;
    let is_sum = left.iter().any(|own| {
        match own.kind {
            TokenKind::Open => depth += 1,
            TokenKind::Close => depth = depth.saturating_sub(1),
            _ => {}
        }
        let sign = matches!(own.kind, TokenKind::Plus | TokenKind::Minus | TokenKind::Star | TokenKind::Caret);
        depth == 0 && sign
    });
    let strange = |own: &Token| {
        let kinds = [TokenKind::Equals, TokenKind::Colon, TokenKind::Prime, TokenKind::Illegal, TokenKind::Range];
        kinds.contains(&own.kind) || words::is_statement_word(own.text(source))
    };
    if statement == "constraint" || !is_sum || left.iter().chain(right).any(strange) {
        return None;
    }
    let text = |span: Span| source.get(span.range()).map(str::trim);
    let name = text(left.first()?.span().to(left.last()?.span()))?.to_owned();
    let fix = format!("constraint {name} = {}", text(right.first()?.span().to(right.last()?.span()))?);
    Some(SyntaxError::MissingStatementWord { name, fix: Some(fix), span: line.first()?.span() })
}

fn of_another_language(source: &str, token: Token, rest: Lexer<'_>, statement: &str) -> Option<SyntaxError> {
    let mut line = vec![token];
    let others = rest.into_iter().filter(|other| other.kind != TokenKind::Comment);
    line.extend(others.take_while(|other| !other.first_on_line));
    let span = token.span().to(line.last()?.span());
    let word = token.text(source);
    let next = line.get(1).map(|next| next.kind);
    if is_import(word) && next == Some(TokenKind::Word) {
        return Some(SyntaxError::UnknownStatement {
            word: word.to_owned(),
            suggestion: None,
            is_certain: false,
            span,
        });
    }
    if word == "t" && next == Some(TokenKind::Equals) {
        let (suggestion, span) = (Some("T"), token.span());
        let is_certain = line.iter().any(|own| own.kind == TokenKind::Prime);
        return Some(SyntaxError::UnknownStatement { word: word.to_owned(), suggestion, is_certain, span });
    }
    let gives = |own: &Token| own.kind == TokenKind::Equals || own.text(source) == "==";
    if let Some(error) = constraint_without_word(source, &line, statement) {
        return Some(error);
    }
    let second = line.windows(3).find(|three| {
        matches!(three, [name, first, second] if name.kind == TokenKind::Word
            && first.kind == TokenKind::Prime && second.kind == TokenKind::Prime)
    })?;
    let coordinate = second.first()?.text(source).to_owned();
    line.iter().any(gives).then_some(SyntaxError::EquationOfMotion { coordinate, span })
}
