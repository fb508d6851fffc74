//! The kinds of mistakes inside a statement, told apart by the tokens around their place.

use super::super::error::SyntaxError;
use super::super::lexer::{Lexer, Token, TokenKind};
use super::super::split::expects_operand;
use super::super::words;
use super::{describe, fixes, no_statement, unknown_statement};
use crate::order::Gather;
use crate::span::Span;

/// Signs of other languages that give a value.
const ASSIGNMENTS: [&str; 4] = [":=", "<-", "+=", "-="];

/// An open bracket before the place.
#[derive(Default)]
pub(super) struct Enclosure {
    /// Of a sum, and of an integral.
    pub(super) sum: bool,
    integral: bool,
    /// Since the last comma at this level.
    pub(super) has_in: bool,
    pub(super) has_range: bool,
    pub(super) filter: bool,
    /// Whether an index with `in` has been seen at all.
    pub(super) indexed: bool,
    /// The product around it.
    chain: Option<u32>,
}

/// Where outside of brackets the place is.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Part {
    Name,
    Unit,
    Value,
}

/// The tokens around the place, and what stands before it.
pub(super) struct Context<'s> {
    pub(super) source: &'s str,
    pub(super) statement: &'static str,
    pub(super) word: Token,
    pub(super) before_last: Option<Token>,
    pub(super) before: Token,
    pub(super) found: Option<Token>,
    pub(super) after: Option<Token>,
    pub(super) enclosures: Vec<Enclosure>,
    pub(super) part: Part,
    /// A `==` outside of brackets.
    pub(super) comparison: Option<Token>,
    /// Where the declared name begins, where it ends with its indices, and where the value begins.
    pub(super) name_start: u32,
    pub(super) name_end: Option<u32>,
    pub(super) value_start: Option<u32>,
    /// Where the product begins that is being read.
    pub(super) chain: Option<u32>,
    pub(super) end: u32,
}

impl<'s> Context<'s> {
    pub(super) fn read(source: &'s str, span: Span, at: u32) -> Option<Self> {
        let mut tokens = Lexer::new(source, span).code();
        let word = tokens.next()?;
        let statement = words::STATEMENT_WORDS.into_iter().find(|s| *s == word.text(source))?;
        let mut context = Context {
            source,
            statement,
            word,
            before_last: None,
            before: word,
            found: None,
            after: None,
            enclosures: Vec::new(),
            part: if words::takes_expression(statement) { Part::Value } else { Part::Name },
            comparison: None,
            name_start: word.end,
            name_end: None,
            value_start: None,
            chain: None,
            end: span.end,
        };
        for token in tokens {
            if context.found.is_some() {
                context.after = Some(token);
                break;
            }
            if token.end > at {
                context.found = Some(token);
            } else {
                context.pass(token);
            }
        }
        Some(context)
    }

    /// Takes note of a token before the place.
    fn pass(&mut self, token: Token) {
        let text = token.text(self.source);
        self.follow_product(token);
        match token.kind {
            TokenKind::Open => self.enclosures.push(Enclosure {
                sum: matches!(self.before.text(self.source), "sum" | "integral"),
                integral: self.before.text(self.source) == "integral",
                filter: self.enclosures.last().is_some_and(|e| e.filter),
                chain: self.chain.take(),
                ..Enclosure::default()
            }),
            // Behind the indices of a constraint a product begins.
            TokenKind::Close => {
                let enclosure = self.enclosures.pop().filter(|enclosure| enclosure.sum || !enclosure.indexed);
                self.chain = enclosure.and_then(|enclosure| enclosure.chain);
            }
            TokenKind::Comma => match self.enclosures.last_mut() {
                Some(enclosure) => {
                    enclosure.has_in = false;
                    enclosure.has_range = false;
                    enclosure.filter = false;
                }
                None if self.part == Part::Unit || words::takes_several(self.statement) => {
                    self.part = Part::Name;
                    self.name_start = token.end;
                    (self.name_end, self.value_start) = (None, None);
                }
                None => {}
            },
            TokenKind::Range => {
                if let Some(enclosure) = self.enclosures.last_mut() {
                    enclosure.has_range = true;
                }
            }
            TokenKind::Word => {
                if let Some(enclosure) = self.enclosures.last_mut() {
                    if text == "in" {
                        enclosure.has_in = true;
                        enclosure.indexed = true;
                    } else if text == "where" {
                        enclosure.filter = true;
                    }
                }
            }
            TokenKind::Colon if self.enclosures.is_empty() => {
                self.part = Part::Unit;
                self.name_end.get_or_insert(token.start);
            }
            TokenKind::Equals if self.enclosures.is_empty() => {
                self.part = Part::Value;
                self.name_end.get_or_insert(token.start);
                self.value_start.get_or_insert(token.end);
            }
            TokenKind::Comparison if self.enclosures.is_empty() && text == "==" => self.comparison = Some(token),
            _ => {}
        }
        self.before_last = Some(self.before);
        self.before = token;
    }

    /// Keeps the beginning of the product that a token belongs to.
    fn follow_product(&mut self, token: Token) {
        let ends = expects_operand(token.kind, token.text(self.source))
            && !matches!(token.kind, TokenKind::Star | TokenKind::Slash | TokenKind::Caret | TokenKind::Open)
            && self.before.kind != TokenKind::Caret;
        if ends || self.statement == "draw" && self.before_is_word() {
            self.chain = None;
        } else {
            self.chain.get_or_insert(token.start);
        }
    }

    pub(super) fn text(&self, token: Token) -> &'s str {
        token.text(self.source)
    }

    pub(super) fn before_expects_operand(&self) -> bool {
        expects_operand(self.before.kind, self.text(self.before))
            || self.before_is_word() && words::takes_expression(self.statement)
    }

    pub(super) fn before_is_word(&self) -> bool {
        self.before.start == self.word.start
    }

    /// Whether a name to be declared should stand at the place.
    fn at_name(&self) -> bool {
        self.enclosures.is_empty()
            && self.part == Part::Name
            && (self.before_is_word() && words::is_naming(self.statement) || self.before.kind == TokenKind::Comma)
    }

    pub(super) fn mistake(&self, expected: Vec<&'static str>) -> SyntaxError {
        let Some(found) = self.found else { return self.at_end() };
        self.by_place(found).or_else(|| self.by_token(found)).unwrap_or_else(|| SyntaxError::Unexpected {
            found: describe(self.source, found),
            expected,
            span: found.span(),
        })
    }

    fn at_end(&self) -> SyntaxError {
        let statement = self.statement;
        let span = self.before.span();
        let end = Span::new(self.end, self.end);
        if self.before_is_word() && words::is_naming(statement)
            || self.before.kind == TokenKind::Comma && self.part == Part::Name && statement != "draw"
        {
            return SyntaxError::MissingName { statement, found: "nothing".to_owned(), span };
        }
        if self.before_is_word() {
            return match words::takes_expression(statement) {
                true => SyntaxError::MissingExpression { statement, span },
                false => SyntaxError::MissingRightSide { statement, value: None, span: end },
            };
        }
        match self.before.kind {
            TokenKind::Equals if statement == "table" => SyntaxError::MissingPath { fix: None, span },
            TokenKind::Equals => SyntaxError::MissingValue { span },
            TokenKind::Colon => SyntaxError::MissingUnit { span, assignment: None },
            TokenKind::Dot => SyntaxError::MissingColumn { span },
            _ if self.before_expects_operand() => {
                SyntaxError::MissingOperand { sign: self.text(self.before).to_owned(), span, found: None }
            }
            _ => match self.comparison {
                Some(token) => SyntaxError::ComparisonForEquals { span: token.span() },
                None if statement == "draw" => SyntaxError::MissingExpression { statement, span: end },
                None => SyntaxError::MissingRightSide { statement, value: None, span: end },
            },
        }
    }

    /// Mistakes that show in where the place is, whatever stands there.
    fn by_place(&self, found: Token) -> Option<SyntaxError> {
        let text = self.text(found);
        let span = found.span();
        let statement = self.statement;
        if self.at_name() {
            let reserved = words::reserved_meaning(text).filter(|_| found.kind == TokenKind::Word);
            if found.kind == TokenKind::Equals && statement == "model" {
                return Some(SyntaxError::NeedlessEquals { statement, span });
            }
            if self.before.kind == TokenKind::Comma
                && let Some(error) = self.before_last.and_then(|last| decimal_comma(self.source, last, found))
            {
                return Some(error);
            }
            return Some(match reserved {
                Some(meaning) => SyntaxError::ReservedName { name: text.to_owned(), meaning, span },
                None => SyntaxError::MissingName { statement, found: describe(self.source, found), span },
            });
        }
        if self.before.kind == TokenKind::Dot {
            return Some(SyntaxError::MissingColumn { span: self.before.span() });
        }
        if self.before.kind == TokenKind::Colon && found.kind == TokenKind::Equals {
            return Some(SyntaxError::MissingUnit {
                span: if found.glued { self.before.span().to(span) } else { self.before.span() },
                assignment: found.glued.then_some(":="),
            });
        }
        if self.enclosures.is_empty()
            && let Some(error) = unknown_statement(self.source, self.before, found, self.after)
        {
            return Some(error);
        }
        let binds = self.after.is_some_and(|after| self.text(after) == "in");
        if found.kind == TokenKind::Word
            && binds
            && let Some(meaning) = words::reserved_meaning(text)
        {
            return Some(SyntaxError::ReservedName { name: text.to_owned(), meaning, span });
        }
        if self.part == Part::Unit {
            return Some(self.in_unit(found));
        }
        let indices = || self.constraint_indices().filter(|_| statement == "constraint");
        if text == "in"
            && let Some(error) = self.foreign_sum().or_else(indices)
        {
            return Some(error);
        }
        if found.kind == TokenKind::Colon
            && let Some(enclosure) = self.enclosures.last()
            && (enclosure.has_in || self.part == Part::Name && words::is_naming(statement))
            && matches!(self.before.kind, TokenKind::Number | TokenKind::Word | TokenKind::Close)
        {
            let is_whole = enclosure.has_range || self.is_table_of_index();
            let is_end = is_whole && enclosure.sum && self.is_last_entry(found);
            return (is_end || !is_whole).then_some(SyntaxError::ColonForRange { is_word: false, is_end, span });
        }
        if found.kind == TokenKind::Word && self.before_expects_operand() {
            match text {
                "sum" => return Some(SyntaxError::SumWithoutIndex { span }),
                "integral" => return Some(SyntaxError::IntegralForm { span }),
                _ => {}
            }
        }
        let enclosure = self.enclosures.last()?;
        if enclosure.integral && (!enclosure.indexed || enclosure.has_in && found.kind == TokenKind::Close) {
            return Some(SyntaxError::IntegralForm { span });
        }
        if enclosure.sum && !enclosure.indexed {
            return Some(SyntaxError::SumWithoutIndex { span });
        }
        let ends_entry = matches!(found.kind, TokenKind::Comma | TokenKind::Close);
        if enclosure.has_in && ends_entry && !self.before_expects_operand() {
            let rows = self.before_last.is_some_and(|t| self.text(t) == "in");
            if enclosure.sum
                && found.kind == TokenKind::Close
                && (enclosure.has_range || rows && self.before.kind == TokenKind::Word)
            {
                return Some(SyntaxError::SumWithoutBody { span });
            }
            if !enclosure.has_range {
                return Some(SyntaxError::HalfRange { span: self.before.span() });
            }
        }
        None
    }

    /// Whether the name before the place is that of a table behind `in`.
    fn is_table_of_index(&self) -> bool {
        self.before_last.is_some_and(|own| self.text(own) == "in")
            && fixes::declaring_word(self.source, self.word.start, self.text(self.before)) == Some("table")
    }

    /// Whether neither a comma nor a colon follows in the bracket around a token.
    fn is_last_entry(&self, token: Token) -> bool {
        let mut depth = 1_usize;
        let mut rest = Lexer::new(self.source, Span::new(token.end, self.end)).code();
        let end = rest.find(|own| {
            let is_sign = depth == 1 && matches!(own.kind, TokenKind::Comma | TokenKind::Colon);
            depth = own.depth_behind(depth);
            is_sign || depth == 0
        });
        end.is_some_and(|own| own.kind == TokenKind::Close)
    }

    /// `:=`, `<-`, `+=`
    fn assignment(&self, first: Token) -> Option<SyntaxError> {
        let second = self.after.filter(|after| after.glued)?;
        let sign = ASSIGNMENTS.into_iter().find(|sign| [self.text(first), self.text(second)].concat() == *sign)?;
        Some(SyntaxError::MissingUnit { span: first.span().to(second.span()), assignment: Some(sign) })
    }

    fn in_unit(&self, found: Token) -> SyntaxError {
        let span = found.span();
        if let Some(error) = self.assignment(found) {
            return error;
        }
        if self.before.kind == TokenKind::Caret
            || self.before.kind == TokenKind::Open && self.before_last.is_some_and(|t| t.kind == TokenKind::Caret)
        {
            return SyntaxError::UnitExponent { span };
        }
        if found.kind == TokenKind::Equals && self.statement == "coord" {
            return SyntaxError::CoordinateValue { span };
        }
        let side_by_side = matches!(self.before.kind, TokenKind::Word | TokenKind::Close)
            && (found.kind == TokenKind::Word || self.text(found) == "(");
        if side_by_side {
            return self.missing_multiplication(found);
        }
        match found.kind {
            TokenKind::Comparison if self.text(found) == "==" => SyntaxError::ComparisonForEquals { span },
            _ => SyntaxError::BadUnit { span },
        }
    }

    /// Mistakes that show in what stands at the place.
    fn by_token(&self, found: Token) -> Option<SyntaxError> {
        let span = found.span();
        let text = self.text(found);
        let statement = self.statement;
        let naming = self.part == Part::Name && self.enclosures.is_empty();
        if naming && let Some(error) = self.assignment(found) {
            return Some(error);
        }
        match found.kind {
            TokenKind::Plus if self.before_expects_operand() => {
                // Behind another sign and before a blank it is the operand between them that is missing.
                let is_sign = matches!(
                    self.before.kind,
                    TokenKind::Caret | TokenKind::Star | TokenKind::Slash | TokenKind::Minus
                ) && self.after.is_some_and(|after| !after.glued);
                Some(if is_sign { self.missing_operand(found) } else { SyntaxError::UnaryPlus { span } })
            }
            TokenKind::PlusMinus => {
                let value = self.value_start.and_then(|start| self.source.get(start as usize..)).unwrap_or_default();
                let in_list =
                    statement == "param" && value.trim_start().starts_with('[') && !self.enclosures.is_empty();
                Some(SyntaxError::MisplacedUncertainty { in_list, span })
            }
            TokenKind::Text => Some(SyntaxError::MisplacedText { number: quoted_number(text), span }),
            TokenKind::Word | TokenKind::Number | TokenKind::Open => self.operand(found, naming),
            TokenKind::Prime if statement == "table" && self.part == Part::Value => self.path_in_single_quotes(found),
            TokenKind::Prime if naming => Some(SyntaxError::MisplacedRate { statement, span }),
            TokenKind::Prime if self.before.kind == TokenKind::Number => {
                Some(SyntaxError::PostfixOnNumber { sign: text.to_owned(), span })
            }
            TokenKind::Equals => self.equals(found),
            TokenKind::Comparison if naming && text == "==" => Some(SyntaxError::ComparisonForEquals { span }),
            TokenKind::Comma => self.comma(found, naming),
            TokenKind::Colon if self.enclosures.is_empty() => match self.part {
                Part::Value if words::is_naming(statement) => Some(self.unit_behind_colon(found)),
                Part::Name if matches!(statement, "param" | "coord" | "let") => None,
                Part::Unit => None,
                Part::Name | Part::Value => Some(SyntaxError::MisplacedUnit { statement, span }),
            },
            TokenKind::Range if !self.before_expects_operand() => Some(SyntaxError::MisplacedRange { span }),
            TokenKind::Minus | TokenKind::Dot if naming => {
                let fix = format!("{}_{}", self.text(self.before), self.after.map_or("", |t| self.text(t)));
                Some(SyntaxError::BrokenName {
                    fix,
                    is_certain: statement == "model",
                    span: self.before.span().to(self.after.map_or(span, |after| after.span())),
                })
            }
            TokenKind::Comparison | TokenKind::Star | TokenKind::Slash | TokenKind::Caret
                if matches!(self.before.kind, TokenKind::Equals | TokenKind::Open | TokenKind::Comma)
                    || self.before_is_word() =>
            {
                Some(SyntaxError::MissingLeftOperand { sign: text.to_owned(), span })
            }
            TokenKind::Comparison
            | TokenKind::Star
            | TokenKind::Slash
            | TokenKind::Caret
            | TokenKind::Close
            | TokenKind::Range
            | TokenKind::Prime
            | TokenKind::Colon
                if self.before_expects_operand() =>
            {
                Some(self.missing_operand(found))
            }
            _ => None,
        }
    }

    /// `table t = 'a.csv'`
    fn path_in_single_quotes(&self, open: Token) -> Option<SyntaxError> {
        let rest = self.source.get(open.end as usize..self.end as usize)?;
        let (path, _) = rest.lines().next()?.split_once('\'')?;
        let span = Span::new(open.start, open.end + path.len() as u32 + 1);
        Some(SyntaxError::MissingPath { fix: (!path.contains('"')).then(|| format!("\"{path}\"")), span })
    }

    pub(super) fn missing_operand(&self, found: Token) -> SyntaxError {
        SyntaxError::MissingOperand {
            sign: self.text(self.before).to_owned(),
            span: self.before.span(),
            found: Some((describe(self.source, found), found.span())),
        }
    }

    fn equals(&self, found: Token) -> Option<SyntaxError> {
        let span = found.span();
        let statement = self.statement;
        if let Some(enclosure) = self.enclosures.last() {
            return enclosure.filter.then_some(SyntaxError::EqualsForComparison { span });
        }
        if matches!(statement, "model" | "period") {
            return Some(SyntaxError::NeedlessEquals { statement, span });
        }
        if statement == "coord" {
            return Some(SyntaxError::CoordinateValue { span });
        }
        if statement == "assume" {
            return Some(SyntaxError::NoRelation { span });
        }
        if self.before_expects_operand() {
            return Some(SyntaxError::MissingLeftOperand { sign: "=".to_owned(), span });
        }
        if self.before.kind == TokenKind::Word && self.before.first_on_line {
            return Some(no_statement(self.source, self.before, self.found));
        }
        (self.part == Part::Value).then_some(SyntaxError::SecondEquals { span })
    }

    fn comma(&self, found: Token, naming: bool) -> Option<SyntaxError> {
        let span = found.span();
        if self.before_expects_operand() {
            return Some(self.missing_operand(found));
        }
        if naming {
            return Some(SyntaxError::SeveralNames {
                statement: self.statement,
                span: self.after.map_or(span, |after| after.span()),
            });
        }
        if !self.enclosures.is_empty() {
            return None;
        }
        let decimal = self.after.and_then(|after| decimal_comma(self.source, self.before, after));
        decimal.or_else(|| {
            (self.part == Part::Value).then_some(SyntaxError::SeveralValues { statement: self.statement, span })
        })
    }
}

/// `1,5`, `1,000`, `1.000,5`: numbers before and after a comma outside of brackets, where they can be one number.
fn decimal_comma(source: &str, before: Token, after: Token) -> Option<SyntaxError> {
    if before.kind != TokenKind::Number || after.kind != TokenKind::Number {
        return None;
    }
    let is_whole = before.end + 1 == after.start;
    let mut groups = vec![before.text(source), after.text(source)];
    let mut end = after.end;
    let mut rest = Lexer::new(source, Span::new(end, source.len() as u32));
    while let (Some(comma), Some(number)) = (rest.next(), rest.next())
        && (is_whole && comma.glued && comma.kind == TokenKind::Comma)
        && (number.glued && number.kind == TokenKind::Number)
    {
        groups.push(number.text(source));
        end = number.end;
    }
    let plain = |text: &str| text.bytes().all(|b| b.is_ascii_digit());
    let [first, middle @ .., last] = groups.as_slice() else { return None };
    let (whole, fraction) = last.split_once('.').map_or((*last, None), |(whole, rest)| (whole, Some(rest)));
    let in_threes = middle.iter().chain([&whole]).all(|own| own.len() == 3 && plain(own));
    let grouped = in_threes && plain(first) && first.len() <= 3 && *first != "0";
    let thousands = match first.split_once('.') {
        _ if grouped => Some(groups.concat()),
        Some((left, right)) if right.len() == 3 && middle.is_empty() && plain(last) => {
            Some(format!("{left}{right}.{last}"))
        }
        _ => None,
    };
    let is_one = middle.is_empty() && fraction.is_none() && plain(first);
    let decimal = is_one.then(|| groups.join("."));
    (decimal.is_some() || thousands.is_some()).then(|| SyntaxError::DecimalComma {
        is_certain: is_whole && !in_threes,
        decimal,
        thousands,
        span: Span::new(before.start, end),
    })
}

/// The number in a text in quotes, if there is nothing else.
fn quoted_number(text: &str) -> Option<String> {
    let inside = text.trim_matches('"').trim();
    let digits = inside.strip_prefix('-').unwrap_or(inside);
    let span = Span::new(0, u32::try_from(digits.len()).ok()?);
    let number = Lexer::new(digits, span).only()?.kind == TokenKind::Number;
    (number && inside.len() <= 40).then(|| inside.to_owned())
}
