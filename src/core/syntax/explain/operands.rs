//! Mistakes with operands: two in a row, or a word that can't be one.

use super::super::error::SyntaxError;
use super::super::lexer::{Lexer, Token, TokenKind};
use super::super::words;
use super::context::{Context, Part};
use super::fixes;
use crate::span::Span;

impl Context<'_> {
    /// A word, a number or an opening bracket where none can be.
    pub(super) fn operand(&self, found: Token, naming: bool) -> Option<SyntaxError> {
        let span = found.span();
        let text = self.text(found);
        let word = found.kind == TokenKind::Word;
        if word && text == "not" {
            return Some(SyntaxError::MisplacedNot { span });
        }
        if text == "where" && self.before.kind == TokenKind::Comma {
            return Some(SyntaxError::CommaBeforeWhere { span: self.before.span() });
        }
        if word && words::is_connective(text) {
            return self.before_expects_operand().then(|| self.missing_operand(found));
        }
        if word && words::is_statement_word(text) {
            let needless = self.is_difference_of_energies(found).then(|| Span::new(self.word.start, self.end));
            return Some(SyntaxError::WordInExpression { word: text.to_owned(), needless, span });
        }
        if self.statement == "table" && self.part == Part::Value {
            return Some(SyntaxError::MissingPath { fix: None, span });
        }
        if self.before_expects_operand() {
            return None;
        }
        if naming {
            return match (word, self.statement) {
                _ if self.before.kind == TokenKind::Prime => {
                    Some(SyntaxError::MisplacedRate { statement: self.statement, span: self.before.span() })
                }
                (false, _) if text == "(" => Some(SyntaxError::FunctionDefinition { span }),
                _ if self.before_is_word() => Some(SyntaxError::MissingRightSide {
                    statement: self.statement,
                    value: None,
                    span: self.word.span(),
                }),
                (true, word) if words::takes_several(word) => Some(SyntaxError::MissingComma {
                    span: self.before.span().to(span),
                    left: self.text(self.before).to_owned(),
                    right: text.to_owned(),
                }),
                (true, statement) => Some(SyntaxError::SeveralNames { statement, span }),
                (false, statement)
                    if found.kind == TokenKind::Number && !matches!(statement, "model" | "coord" | "table") =>
                {
                    Some(SyntaxError::MissingRightSide { statement, value: Some(text.to_owned()), span })
                }
                (false, _) => None,
            };
        }
        let indices = self.part == Part::Name || self.statement == "constraint";
        let opened = self.before_last.is_some_and(|t| matches!(self.text(t), "[" | ","));
        if self.before.kind == TokenKind::Word && indices && opened && self.enclosures.len() == 1 {
            return Some(SyntaxError::IndexWithoutIn {
                name: self.text(self.before).to_owned(),
                span: self.before.span().to(span),
            });
        }
        if word
            && self.part == Part::Value
            && self.enclosures.is_empty()
            && self.statement != "constraint"
            && words::reserved_meaning(text).is_none()
            && fixes::binds(self.source, found, self.end)
        {
            return Some(SyntaxError::MissingStatementWord {
                name: text.to_owned(),
                fix: self.with_statement_word(found),
                declared: fixes::given_by(self.source, found, self.after),
                span,
            });
        }
        let chooses = |own: Token| {
            own.kind == TokenKind::Word && words::is_control(self.text(own)) && !self.is_declared(self.text(own))
        };
        if let Some(chosen) = [self.before, found].into_iter().find(|own| chooses(*own)) {
            return Some(SyntaxError::ConditionOutsideFilter { is_choice: true, span: chosen.span() });
        }
        if text == "to" && self.enclosures.last().is_some_and(|own| own.has_in && !own.has_range) {
            let end = self.after.filter(|after| !after.first_on_line).map_or(found.end, |after| after.start);
            return Some(SyntaxError::ColonForRange {
                is_word: true,
                is_end: false,
                span: Span::new(self.before.end, end),
            });
        }
        if let Some(error) = self.foreign_number(found).or_else(|| self.misplaced_unit(found)) {
            return Some(error);
        }
        if text == "[" && self.before.kind == TokenKind::Number {
            return Some(SyntaxError::PostfixOnNumber { sign: text.to_owned(), span });
        }
        Some(self.side_by_side(found))
    }

    /// Two operands with nothing between them.
    fn side_by_side(&self, found: Token) -> SyntaxError {
        let before = self.before;
        let both = before.span().to(found.span());
        if before.kind == TokenKind::Number && found.kind == TokenKind::Number {
            return SyntaxError::TwoNumbers { span: both };
        }
        if let Some(error) = self.foreign_derivative(found).or_else(|| self.prefixed_function(found)) {
            return error;
        }
        if before.kind == TokenKind::Prime && self.argument(found).as_deref() == Some("t") {
            let end = self.closing(found).map_or(found.end, |close| close.end);
            return SyntaxError::ArgumentOfDerivative { fix: None, span: Span::new(found.start, end) };
        }
        let is_function = |token: Token| token.kind == TokenKind::Word && words::is_function(self.text(token));
        if is_function(before) {
            // What goes on behind it may or may not belong to the argument.
            let whole = self.after.is_none_or(|after| {
                matches!(after.kind, TokenKind::Word | TokenKind::Plus | TokenKind::Minus | TokenKind::Close)
            });
            let argument = match self.after {
                // `sin 2x`
                Some(after)
                    if found.kind == TokenKind::Number && after.kind == TokenKind::Word && !after.first_on_line =>
                {
                    let product = format!("{}*{}", self.text(found), self.text(after));
                    if words::reserved_meaning(self.text(after)).is_none() { product } else { "…".to_owned() }
                }
                _ if whole && found.kind != TokenKind::Open => self.text(found).to_owned(),
                _ => "…".to_owned(),
            };
            return SyntaxError::MissingParentheses { function: self.text(before).to_owned(), argument, span: both };
        }
        let chain = Lexer::new(self.source, Span::new(self.chain.unwrap_or(found.start), found.start));
        let chain: Vec<Token> = chain.collect();
        let (exponent, rest) = match chain.as_slice() {
            [rest @ .., minus, last] if minus.kind == TokenKind::Minus => (minus.span().to(last.span()), rest),
            [rest @ .., last] => (last.span(), rest),
            [] => (both, &[][..]),
        };
        match rest {
            [.., function, caret] if is_function(*function) && caret.kind == TokenKind::Caret => {
                let exponent = self.source.get(exponent.range()).unwrap_or_default().to_owned();
                SyntaxError::FunctionPower {
                    function: self.text(*function).to_owned(),
                    change: self.power_moved(*function, &exponent, found),
                    exponent,
                    span: function.span().to(before.span()),
                }
            }
            _ => self.missing_multiplication(found),
        }
    }

    pub(super) fn missing_multiplication(&self, found: Token) -> SyntaxError {
        let product = self.product_before();
        let left = match (self.before.kind, self.before_last) {
            _ if product.is_some() => product.unwrap_or_default(),
            (TokenKind::Close, _) if self.text(self.before) == ")" => "(…)".to_owned(),
            (TokenKind::Close, _) => "[…]".to_owned(),
            (TokenKind::Prime, Some(last)) => format!("{}'", self.text(last)),
            _ => self.text(self.before).to_owned(),
        };
        let right = match (self.text(found), self.after) {
            ("(", _) => "(…)".to_owned(),
            ("[", _) => "[…]".to_owned(),
            (name, Some(after)) if found.kind == TokenKind::Word && self.text(after) == "(" && after.glued => {
                format!("{name}(…)")
            }
            (text, _) => text.to_owned(),
        };
        let span = self.before.span().to(found.span());
        let unit = || Some(format!("if a unit is meant, {}", self.with_unit(found)?));
        let uncertain = self.uncertainty(found);
        // A line that is meant for itself is no factor.
        let statement = Span::new(self.word.start, self.end);
        let separator = fixes::separator_in(self.source, statement, span);
        let whole = self
            .product_with_signs()
            .filter(|(span, _)| span.end > found.start && fixes::separator_in(self.source, statement, *span).is_none());
        let is_factor = whole.is_some() || !found.first_on_line;
        let fix = whole.as_ref().and_then(|(_, text)| fixes::short(text.clone()));
        let fix = fix.unwrap_or_else(|| format!("{left}*{right}"));
        // With a power of ten, `1.66(5)e-27`, it is no product.
        let (fix, instead) = match uncertain {
            Some(own) if own.contains('e') => (own, None),
            Some(own) => (fix, Some(format!("if the uncertainty of the last digits is meant, `{own}`"))),
            None => {
                let instead = unit().or_else(|| self.below_the_bar(found, &fix));
                (fix, instead)
            }
        };
        let (place, text) = whole.unwrap_or_else(|| (Span::new(self.before.end, found.start), "*".to_owned()));
        // Between two spaces an operator may be missing, before a number that of a power, and nobody writes 0 or 1 times
        // something.
        let is_plain = found.start - self.before.end <= 1
            && found.kind != TokenKind::Number
            && !matches!(self.text(self.before), "0" | "1");
        // What is called behind a point may be a function.
        let is_called = self.text(found) == "(" && self.before_last.is_some_and(|last| last.kind == TokenKind::Dot);
        let is_certain = is_factor
            && is_plain
            && !is_called
            && separator.is_none()
            && fixes::are_factors(self.source, statement, place.to(found.span()));
        SyntaxError::MissingMultiplication { fix, place, text, is_certain, separator, instead, span }
    }
}
