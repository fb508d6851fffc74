//! From pest's pairs to the tree, one statement at a time.
//!
//! The depth of its calls is bounded by the nesting that the scan in `split` lets through.

mod expressions;
mod units;

use std::cell::{Cell, RefCell};

use pest::Parser;
use pest::error::{ErrorVariant, InputLocation};
use pest::iterators::Pair;

use super::arena::{Expressions, Units};
use super::ast::{
    Binding, Comment, Comparison, Drawn, ExprKind, ExprRef, File, IndexEntry, IndexKind, Indices, Name, Statement,
    StatementKind,
};
use super::error::SyntaxError;
use super::grammar::{Grammar, Rule, in_words};
use super::split::MOST_LEVELS;
use super::{explain, words};
use crate::span::Span;

/// Collects the trees of a file's statements.
pub(super) struct Builder {
    pub(super) statements: Vec<Statement>,
    comments: Vec<Comment>,
    pub(super) units: Units,
    // Shared by the callbacks of the precedence parser.
    pub(super) expressions: RefCell<Expressions>,
    error: RefCell<Option<SyntaxError>>,
    in_filter: Cell<bool>,
    /// Where the text that pest has been given begins in the file.
    offset: u32,
}

impl Builder {
    pub(super) fn new(comments: Vec<Comment>, statements: usize) -> Self {
        Self {
            statements: Vec::with_capacity(statements),
            comments,
            units: Units::default(),
            expressions: RefCell::new(Expressions::default()),
            error: RefCell::new(None),
            in_filter: Cell::new(false),
            offset: 0,
        }
    }

    pub(super) fn finish(self) -> File {
        let mut expressions = self.expressions.into_inner();
        expressions.finish();
        File { statements: self.statements, expressions, units: self.units, comments: self.comments }
    }

    /// Reads the statement at `span` of `source` and keeps its tree.
    pub(super) fn statement(&mut self, source: &str, span: Span) -> Result<(), SyntaxError> {
        let text = source.get(span.range()).unwrap_or("");
        self.offset = span.start;
        let mut pairs = Grammar::parse(Rule::single, text).map_err(|error| match error.variant {
            ErrorVariant::ParsingError { positives, .. } => {
                let at = match error.location {
                    InputLocation::Pos(at) | InputLocation::Span((at, _)) => at,
                };
                explain::explain(source, span, span.start + at as u32, in_words(&positives))
            }
            // pest's own guard of the stack, which the count of levels should forestall.
            ErrorVariant::CustomError { .. } => SyntaxError::NestingTooDeep { most: MOST_LEVELS, span },
        })?;
        let statement = pairs.next().and_then(|single| single.into_inner().next());
        let kind = required(statement, span).and_then(|pair| self.kind(pair));
        // What the tree objects to stands before the place where building it ended.
        let kind = match self.error.take() {
            Some(mut error) => {
                if let SyntaxError::MissingMultiplication { is_certain, separator, span: place, .. } = &mut error {
                    *separator = explain::separator_in(source, span, *place);
                    *is_certain = separator.is_none() && explain::are_factors(source, span, *place);
                }
                Err(error)
            }
            None => kind,
        }?;
        self.statements.push(Statement { span, kind });
        Ok(())
    }

    fn span(&self, pair: &Pair<'_, Rule>) -> Span {
        let span = pair.as_span();
        Span::new(self.offset + span.start() as u32, self.offset + span.end() as u32)
    }

    /// Keeps the first error that pest had no objection to.
    fn object(&self, error: SyntaxError) {
        self.error.borrow_mut().get_or_insert(error);
    }

    fn kind(&mut self, pair: Pair<'_, Rule>) -> Result<StatementKind, SyntaxError> {
        let rule = pair.as_rule();
        let span = self.span(&pair);
        Ok(match rule {
            Rule::model => {
                let name = pair.into_inner().find(|part| part.as_rule() == Rule::name);
                StatementKind::Model { name: self.name(&required(name, span)?) }
            }
            Rule::param => StatementKind::Param(self.parameters(pair)?),
            Rule::let_named => StatementKind::Let(self.binding(pair)?.0),
            Rule::force => StatementKind::Force(self.binding(pair)?.0),
            Rule::guess => {
                let (binding, rate) = self.binding(pair)?;
                StatementKind::Guess { binding, rate }
            }
            Rule::equilibrium => {
                let (binding, rate) = self.binding(pair)?;
                StatementKind::Equilibrium { binding, rate }
            }
            Rule::coord => StatementKind::Coord { declarations: self.bindings(pair)? },
            Rule::constraint => self.constraint(pair)?,
            Rule::draw => self.drawing(pair)?,
            Rule::assume => self.assumptions(pair),
            Rule::table => {
                let (mut name, mut path) = (None, None);
                for part in pair.into_inner() {
                    match part.as_rule() {
                        Rule::name => name = Some(self.declared(&part)),
                        Rule::text => path = Some((part.as_str(), self.span(&part))),
                        _ => {}
                    }
                }
                let (path, path_span) = required(path, span)?;
                StatementKind::Table { name: required(name, span)?, path: path.trim_matches('"').to_owned(), path_span }
            }
            _ => {
                let expr = required(self.expressions_in(pair).pop(), span)?;
                match rule {
                    Rule::kinetic => StatementKind::Kinetic(expr),
                    Rule::potential => StatementKind::Potential(expr),
                    Rule::lagrangian => StatementKind::Lagrangian(expr),
                    Rule::dissipation => StatementKind::Dissipation(expr),
                    Rule::period => StatementKind::Period(expr),
                    _ => return required(None, span),
                }
            }
        })
    }

    fn constraint(&mut self, pair: Pair<'_, Rule>) -> Result<StatementKind, SyntaxError> {
        let span = self.span(&pair);
        let (indices, sides) = self.for_each(pair)?;
        match sides.as_slice() {
            [left, right] => Ok(StatementKind::Constraint { indices, left: *left, right: *right }),
            _ => required(None, span),
        }
    }

    fn drawing(&mut self, pair: Pair<'_, Rule>) -> Result<StatementKind, SyntaxError> {
        let word = pair.clone().into_inner().find(|part| part.as_rule() == Rule::drawn);
        let drawn = word.and_then(|word| Drawn::ALL.into_iter().find(|own| own.as_str() == word.as_str()));
        let (indices, points) = self.for_each(pair)?;
        Ok(StatementKind::Draw { drawn: drawn.unwrap_or(Drawn::Point), indices, points })
    }

    /// Indices in brackets, if there, and the expressions behind them.
    fn for_each(&self, pair: Pair<'_, Rule>) -> Result<(Option<Box<Indices>>, Vec<ExprRef>), SyntaxError> {
        let (mut indices, mut expressions) = (None, Vec::new());
        for part in pair.into_inner() {
            match part.as_rule() {
                Rule::indices => indices = Some(Box::new(self.indices(part)?)),
                Rule::expr => expressions.push(self.expression(part)),
                _ => {}
            }
        }
        Ok((indices, expressions))
    }

    fn assumptions(&self, pair: Pair<'_, Rule>) -> StatementKind {
        let relations = self.with_filter(true, || self.expressions_in(pair));
        for at in &relations {
            let expressions = self.expressions.borrow();
            let Some(relation) = expressions.get(*at) else { continue };
            if !matches!(relation.kind, ExprKind::Compare { operator, .. } if operator != Comparison::Equal) {
                self.object(SyntaxError::NoRelation { span: relation.span });
            }
        }
        StatementKind::Assume(relations)
    }

    /// The names of a `param` statement. A unit, and a value with its uncertainty, are those of the names before them
    /// that have none: `param m1, m2 : kg = 1, k : N/m = 5`.
    fn parameters(&mut self, pair: Pair<'_, Rule>) -> Result<Vec<Binding>, SyntaxError> {
        let mut bindings = self.bindings(pair)?;
        let (mut unit, mut value) = (None, (None, None));
        for binding in bindings.iter_mut().rev() {
            if binding.value.is_some() {
                (unit, value) = (None, (binding.value, binding.uncertainty));
            }
            binding.unit = binding.unit.or(unit);
            unit = binding.unit;
            (binding.value, binding.uncertainty) = value;
        }
        Ok(bindings)
    }

    /// The names that a `param` or a `coord` statement has between commas.
    fn bindings(&mut self, pair: Pair<'_, Rule>) -> Result<Vec<Binding>, SyntaxError> {
        let parts = pair.into_inner().filter(|part| matches!(part.as_rule(), Rule::parameter | Rule::declaration));
        parts.map(|part| Ok(self.binding(part)?.0)).collect()
    }

    /// The parts of `param`, `let`, `force`, `guess`, `equilibrium` and of a name of `coord`; the flag is
    /// the prime of a rate.
    fn binding(&mut self, pair: Pair<'_, Rule>) -> Result<(Binding, bool), SyntaxError> {
        let span = self.span(&pair);
        let (mut name, mut indices, mut unit) = (None, None, None);
        let (mut value, mut uncertainty, mut rate) = (None, None, false);
        for part in pair.into_inner() {
            match part.as_rule() {
                Rule::name => name = Some(self.declared(&part)),
                Rule::indices => indices = Some(Box::new(self.indices(part)?)),
                Rule::unit => unit = Some(self.unit(part)?),
                Rule::expr => value = Some(self.expression(part)),
                Rule::uncertainty => uncertainty = self.expressions_in(part).pop(),
                Rule::rate => rate = true,
                _ => {}
            }
        }
        let binding = Binding { name: required(name, span)?, indices, unit, value, uncertainty };
        Ok((binding, rate))
    }

    fn name(&self, pair: &Pair<'_, Rule>) -> Name {
        Name { text: pair.as_str().into(), span: self.span(pair) }
    }

    /// A name that the file declares, which can't be one of the language's own.
    fn declared(&self, pair: &Pair<'_, Rule>) -> Name {
        let name = self.name(pair);
        if let Some(meaning) = words::reserved_meaning(&name.text) {
            self.object(SyntaxError::ReservedName { name: name.text.to_string(), meaning, span: name.span });
        }
        name
    }

    fn indices(&self, pair: Pair<'_, Rule>) -> Result<Indices, SyntaxError> {
        let span = self.span(&pair);
        let (mut entries, mut filter) = (Vec::new(), None);
        for part in pair.into_inner() {
            let span = self.span(&part);
            match part.as_rule() {
                Rule::rows => {
                    let mut names = part.into_inner().filter(|part| part.as_rule() == Rule::name);
                    let variable = required(names.next(), span)?;
                    let table = required(names.next(), span)?;
                    let kind = IndexKind::Rows { variable: self.declared(&variable), table: self.name(&table) };
                    entries.push(IndexEntry { span, kind });
                }
                Rule::range | Rule::unnamed => entries.push(IndexEntry { span, kind: self.range(part)? }),
                Rule::filter => filter = self.with_filter(true, || self.expressions_in(part).pop()),
                _ => {}
            }
        }
        Ok(Indices { span, entries: entries.into(), filter })
    }

    fn range(&self, pair: Pair<'_, Rule>) -> Result<IndexKind, SyntaxError> {
        let span = self.span(&pair);
        let (mut variable, mut from, mut to) = (None, None, None);
        for part in pair.into_inner() {
            match part.as_rule() {
                Rule::name => variable = Some(self.declared(&part)),
                Rule::expr if from.is_none() => from = Some(self.expression(part)),
                Rule::expr => to = Some(self.expression(part)),
                _ => {}
            }
        }
        let from = required(from, span)?;
        Ok(if let Some(to) = to { IndexKind::Range { variable, from, to } } else { IndexKind::Member(from) })
    }
}

/// A part that the grammar makes sure of; its absence is an error like any other.
fn required<T>(part: Option<T>, span: Span) -> Result<T, SyntaxError> {
    part.ok_or_else(|| incomplete(span))
}

fn incomplete(span: Span) -> SyntaxError {
    SyntaxError::Unexpected { found: "an incomplete statement".to_owned(), expected: Vec::new(), span }
}
