//! Lines as other languages and the blackboard have them: comments, imports, equations of motion.
//!
//! A right model has no word that begins a line and neither a statement nor an operand, so it is not read twice here.

use super::super::error::{SyntaxError, is_import};
use super::super::lexer::{Lexer, Token, TokenKind, is_letter, is_word_rest};
use super::super::split::expects_operand;
use super::super::words;
use super::fixes::is_declared;
use super::suggested;
use crate::span::Span;

/// What begins a comment elsewhere, and what ends it where it may end on the line; `--` is a sign twice here, and `;` ends a
/// statement.
const COMMENT_MARKS: [(&str, Option<&str>); 7] = [
    ("//", None),
    ("%", None),
    ("--", None),
    (";", None),
    ("/*", Some("*/")),
    ("(*", Some("*)")),
    ("\"\"\"", Some("\"\"\"")),
];

/// So much of a comment is read, in characters: a line may be as long as a file.
const LONGEST_COMMENT: usize = 400;

/// What is written before or behind the name of a coordinate for its acceleration.
const ACCELERATIONS: [(&str, &str); 6] =
    [("dd", ""), ("", "_ddot"), ("", "ddot"), ("", "_dd"), ("", "dd"), ("", "_tt")];

/// The mistake of a line that begins at `token`, or of its rest if that is a comment; `before` is the token before it, in a
/// statement that begins with the word `statement`; `is_coordinate` is that `token` names one.
pub(in super::super) fn foreign_line(
    source: &str,
    before: Option<Token>,
    token: Token,
    rest: Lexer<'_>,
    in_brackets: bool,
    statement: &str,
    is_coordinate: bool,
) -> Option<SyntaxError> {
    let complete = before.is_none_or(|before| {
        let text = before.text(source);
        !expects_operand(before.kind, text) && before.kind != TokenKind::Dot && !words::is_statement_word(text)
    });
    let first = token.first_on_line && !in_brackets && complete;
    match token.kind {
        TokenKind::Slash
        | TokenKind::Illegal
        | TokenKind::Minus
        | TokenKind::Semicolon
        | TokenKind::Open
        | TokenKind::Text
            if !in_brackets || token.first_on_line =>
        {
            foreign_comment(source, before, token, complete)
        }
        TokenKind::Word | TokenKind::Number if first => {
            of_another_language(source, token, rest, statement, is_coordinate)
        }
        _ => None,
    }
}

/// A comment that begins at a token; `complete` is that no operand is missing before it.
fn foreign_comment(source: &str, before: Option<Token>, token: Token, complete: bool) -> Option<SyntaxError> {
    let rest = source.get(token.start as usize..)?;
    let (mark, end) = COMMENT_MARKS.into_iter().find(|(mark, _)| rest.starts_with(mark))?;
    let near = rest.char_indices().nth(LONGEST_COMMENT).map_or(rest, |(at, _)| &rest[..at]);
    let text = near.lines().next()?.trim_end();
    let line = text.trim_start_matches(mark);
    let mut behind = Lexer::new(line, Span::new(0, line.len() as u32));
    let first_two = [behind.next(), behind.next()];
    // `7 // 2` and `n % 2` may be meant as numbers: a text has two words without a sign between them.
    let operand = |token: Token| matches!(token.kind, TokenKind::Word | TokenKind::Number | TokenKind::Open);
    let is_text = first_two.into_iter().all(|own| own.is_some_and(operand));
    let plain = |own: Token| {
        let word = own.text(line);
        own.kind == TokenKind::Word && !words::is_connective(word) && !words::is_statement_word(word)
    };
    let are_words = first_two.into_iter().all(|own| own.is_some_and(plain));
    // `x^2 % potential` is no percentage, `50% of it` is one, and `50 % of it` may be.
    let is_value = |own: Token| {
        let head = source.get(..own.start as usize).unwrap_or_default();
        own.kind == TokenKind::Number && !head.trim_end_matches(['-', ' ']).ends_with('^')
    };
    let behind_value = mark == "%" && !token.first_on_line && before.is_some_and(is_value);
    let is_percentage = behind_value
        && first_two[0].is_none_or(|own| {
            !operand(own) || words::is_statement_word(own.text(line)) || token.glued && own.start > 0
        });
    let help = match (mark, end) {
        // `param p : % = 5` is meant as a unit, `1 ± 10%` as a percentage.
        _ if before.is_some_and(|before| before.kind == TokenKind::Colon) || is_percentage => return None,
        // Both have a meaning of their own.
        ("--", _) if before.is_none() || complete && are_words => None,
        (";", _) if are_words && !line.contains('=') && suggested(line, first_two[0]?, first_two[1]).is_none() => None,
        ("--" | ";", _) => return None,
        ("(*", Some(end)) if !text.contains(end) => return None,
        (_, Some(end)) => {
            let inside = text.get(mark.len()..)?;
            let is_whole = inside.find(end).is_some_and(|at| at + end.len() == inside.len());
            (!is_whole).then_some("write `#` before each line of it, and what follows on a line of its own")
        }
        _ if token.first_on_line && complete || is_text && !behind_value => None,
        ("//", _) => Some("write `#`; a quotient without its remainder is written `floor(a/b)`, in ranges and indices"),
        _ => Some("write `#`; 10% is `0.1`, a remainder is written `mod(a, b)`"),
    };
    let span = Span::new(token.start, token.start + mark.len() as u32);
    Some(SyntaxError::ForeignComment { help, span })
}

/// The coordinate whose acceleration is in a line: `x''`, `x_ddot`, `ddot(x)`, `diff(x, t, 2)`, `d^2x/dt^2`.
fn accelerated(source: &str, line: &[Token]) -> Option<String> {
    let words: Vec<&str> = line.iter().map(|own| own.text(source)).collect();
    let place = line.first()?.start;
    let declared = |name: &str| is_declared(source, place, name);
    let by_windows = words.iter().enumerate().find_map(|(at, word)| match words.get(at..)? {
        [name, "'", "'", ..] if name.starts_with(is_letter) => Some(*name),
        ["ddot", "(", name, ")", ..] => Some(*name),
        [_, "(", name, ",", "t", ",", "t" | "2", ")", ..] | [_, "[", name, ",", "{t,2}" | "{t, 2}", "]", ..] => {
            Some(*name)
        }
        _ => match *word {
            "ẍ" => Some("x"),
            "ÿ" => Some("y"),
            word => ACCELERATIONS.iter().find_map(|(before, behind)| {
                let name = word.strip_prefix(before)?.strip_suffix(behind)?;
                (declared(name) && !declared(word)).then_some(name)
            }),
        },
    });
    let quotient = || {
        let flat = words.concat().replace('^', "").replace('²', "2");
        let (before, behind) = flat.split_once("/dt2")?;
        let above = before.rsplit(|c| !is_word_rest(c)).next()?.strip_prefix("d2")?;
        let beside = behind.split(|c| !is_word_rest(c)).next()?;
        [above, beside].into_iter().find(|own| !own.is_empty()).map(str::to_owned)
    };
    by_windows.map(str::to_owned).or_else(quotient)
}

/// `x^2 + y^2 = 1`: an equation of more than a name on its left, without accelerations; one that follows a `constraint` may
/// belong to it.
fn constraint_without_word(source: &str, [left, right]: [&[Token]; 2], statement: &str) -> Option<SyntaxError> {
    let mut depth = 0_usize;
    let is_sum = left.iter().any(|own| {
        depth = own.depth_behind(depth);
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
    Some(SyntaxError::MissingStatementWord { name, fix: Some(fix), declared: None, span: left.first()?.span() })
}

/// `x(0) = 1`, `x[1]'(0) = 0`: a line that begins with a declared name and gives its value at the time 0.
fn initial_value(source: &str, [left, right]: [&[Token]; 2]) -> Option<SyntaxError> {
    let [name @ .., open, zero, close] = left else { return None };
    let is_zero = [open, zero, close].map(|own| own.text(source)) == ["(", "0", ")"];
    let first = name.first().filter(|first| is_zero && is_declared(source, first.start, first.text(source)))?;
    let name = source.get(first.span().to(name.last()?.span()).range())?;
    let value = if let [only] = right { only.text(source) } else { "…" };
    Some(SyntaxError::InitialValue { fix: format!("{name}={value}"), span: first.span().to(close.span()) })
}

/// `x = 0`, `x[1]' = 0`: a line that begins with a coordinate and gives it a value.
fn value_of_coordinate(source: &str, left: &[Token]) -> Option<SyntaxError> {
    let (first, members) = left.split_first()?;
    let (last, inside) = members.split_last().map_or((None, members), |(last, rest)| (Some(last), rest));
    let members = if last.is_some_and(|own| own.kind == TokenKind::Prime) { inside } else { members };
    let in_brackets = match members {
        [] => true,
        [open, .., close] => open.text(source) == "[" && close.text(source) == "]" && open.glued,
        [_] => false,
    };
    let plain = |own: &Token| matches!(own.kind, TokenKind::Number | TokenKind::Word | TokenKind::Comma);
    let plain = members.iter().all(|own| plain(own) || matches!(own.kind, TokenKind::Open | TokenKind::Close));
    let span = first.span().to(left.last()?.span());
    let name = source.get(span.range())?.to_owned();
    (in_brackets && plain).then_some(SyntaxError::MissingStatementWord {
        name,
        fix: None,
        declared: Some("coord"),
        span,
    })
}

fn of_another_language(
    source: &str,
    token: Token,
    rest: Lexer<'_>,
    statement: &str,
    is_coordinate: bool,
) -> Option<SyntaxError> {
    let mut line = vec![token];
    line.extend(rest.code().take_while(|other| !other.first_on_line));
    let span = token.span().to(line.last()?.span());
    let word = token.text(source);
    let next = line.get(1).map(|next| next.kind);
    if is_import(word) && next == Some(TokenKind::Word) {
        let word = word.to_owned();
        return Some(SyntaxError::UnknownStatement { word, suggestion: None, is_certain: false, span });
    }
    if word == "t" && next == Some(TokenKind::Equals) {
        let (suggestion, span) = (Some("T"), token.span());
        let is_certain = line.iter().any(|own| own.kind == TokenKind::Prime);
        return Some(SyntaxError::UnknownStatement { word: word.to_owned(), suggestion, is_certain, span });
    }
    let equals = line.iter().position(|own| own.kind == TokenKind::Equals);
    let sides = equals.and_then(|at| Some([line.get(..at)?, line.get(at + 1..)?]));
    if let Some(error) = sides.and_then(|sides| initial_value(source, sides)) {
        return Some(error);
    }
    let gives = |own: &Token| own.kind == TokenKind::Equals || own.text(source) == "==";
    if line.iter().any(gives)
        && let Some(coordinate) = accelerated(source, &line)
    {
        return Some(SyntaxError::EquationOfMotion { coordinate, span });
    }
    let value = sides.filter(|_| is_coordinate).and_then(|[left, _]| value_of_coordinate(source, left));
    value.or_else(|| constraint_without_word(source, sides?, statement))
}
