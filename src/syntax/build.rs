//! From pest's pairs to the tree, one statement at a time.
//!
//! The depth of its calls is bounded by the nesting that the scan in `split` lets through.

use std::cell::{Cell, RefCell};

use pest::Parser;
use pest::error::{ErrorVariant, InputLocation};
use pest::iterators::{Pair, Pairs};
use pest::pratt_parser::PrattParser;

use super::ast::{
    Binding, Comment, Comparison, Declaration, Expr, ExprKind, ExprRef, Factor, File, IndexEntry,
    IndexKind, Indices, Name, Statement, StatementKind, Term, Unit, UnitKind, UnitRef,
};
use super::error::SyntaxError;
use super::explain;
use super::grammar::{Grammar, Rule, in_words, precedences};
use super::split::MOST_LEVELS;
use super::words;
use crate::span::Span;

/// Collects the trees of a file's statements.
pub(super) struct Builder {
    precedences: PrattParser<Rule>,
    statements: Vec<Statement>,
    comments: Vec<Comment>,
    units: Vec<Unit>,
    // Shared by the callbacks of the precedence parser.
    expressions: RefCell<Vec<Expr>>,
    error: RefCell<Option<SyntaxError>>,
    in_filter: Cell<bool>,
    /// Where the statement begins that pest has been given.
    offset: Cell<u32>,
}

/// An operand on its way through the precedence parser: sums, products and the like stay open
/// for further members until a stronger or weaker operator takes them.
struct Operand<'i> {
    /// Parentheses included.
    span: Span,
    form: Form<'i>,
}

enum Form<'i> {
    Done(ExprRef),
    Name(&'i str),
    Sum(Vec<Term>),
    Product(Vec<Factor>),
    Compare(Comparison, ExprRef, ExprRef),
    And(Vec<ExprRef>),
    Or(Vec<ExprRef>),
}

impl Builder {
    pub(super) fn new(comments: Vec<Comment>, statements: usize) -> Self {
        Self {
            precedences: precedences(),
            statements: Vec::with_capacity(statements),
            comments,
            units: Vec::new(),
            expressions: RefCell::new(Vec::new()),
            error: RefCell::new(None),
            in_filter: Cell::new(false),
            offset: Cell::new(0),
        }
    }

    pub(super) fn finish(self) -> File {
        File {
            statements: self.statements,
            expressions: self.expressions.into_inner(),
            units: self.units,
            comments: self.comments,
        }
    }

    /// Reads the statement at `span` of `source` and keeps its tree.
    pub(super) fn statement(&mut self, source: &str, span: Span) -> Result<(), SyntaxError> {
        let text = source.get(span.range()).unwrap_or("");
        self.offset.set(span.start);
        let pairs = Grammar::parse(Rule::single, text).map_err(|error| match error.variant {
            ErrorVariant::ParsingError { positives, .. } => {
                let at = match error.location {
                    InputLocation::Pos(at) | InputLocation::Span((at, _)) => at,
                };
                explain::explain(source, span, span.start + at as u32, in_words(&positives))
            }
            // pest's own guard of the stack, which the count of levels should forestall.
            ErrorVariant::CustomError { .. } => SyntaxError::NestingTooDeep {
                most: MOST_LEVELS,
                span,
            },
        })?;
        let single = pairs.into_iter().next();
        let statement = single.and_then(|single| single.into_inner().next());
        let kind = self.kind(required(statement, span)?)?;
        match self.error.take() {
            Some(error) => Err(error),
            None => {
                self.statements.push(Statement { span, kind });
                Ok(())
            }
        }
    }

    fn span(&self, pair: &Pair<'_, Rule>) -> Span {
        let span = pair.as_span();
        let offset = self.offset.get();
        Span::new(offset + span.start() as u32, offset + span.end() as u32)
    }

    /// Keeps the first error that pest had no objection to.
    fn object(&self, error: SyntaxError) {
        self.error.borrow_mut().get_or_insert(error);
    }

    fn kind(&mut self, pair: Pair<'_, Rule>) -> Result<StatementKind, SyntaxError> {
        let rule = pair.as_rule();
        let span = self.span(&pair);
        Ok(match rule {
            Rule::model => StatementKind::Model {
                name: required(self.first_name(pair.into_inner()), span)?,
            },
            Rule::param => StatementKind::Param(self.binding(pair)?.0),
            Rule::let_named => StatementKind::Let(self.binding(pair)?.0),
            Rule::guess => StatementKind::Guess(self.binding(pair)?.0),
            Rule::equilibrium => {
                let (binding, rate) = self.binding(pair)?;
                StatementKind::Equilibrium { binding, rate }
            }
            Rule::coord => {
                let mut declarations = Vec::new();
                for part in pair.into_inner() {
                    if part.as_rule() == Rule::declaration {
                        let (binding, _) = self.binding(part)?;
                        declarations.push(Declaration {
                            name: binding.name,
                            indices: binding.indices,
                            unit: binding.unit,
                        });
                    }
                }
                StatementKind::Coord { declarations }
            }
            Rule::constraint => self.constraint(pair)?,
            Rule::table => {
                let mut name = None;
                let mut path = None;
                for part in pair.into_inner() {
                    match part.as_rule() {
                        Rule::name => name = Some(self.declared(&part)),
                        Rule::text => path = Some((part.as_str(), self.span(&part))),
                        _ => {}
                    }
                }
                let (path, path_span) = required(path, span)?;
                StatementKind::Table {
                    name: required(name, span)?,
                    path: path.trim_matches('"').to_owned(),
                    path_span,
                }
            }
            _ => {
                let expr = pair.into_inner().find(|part| part.as_rule() == Rule::expr);
                let expr = self.expression(required(expr, span)?);
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
        let mut indices = None;
        let mut sides = Vec::with_capacity(2);
        for part in pair.into_inner() {
            match part.as_rule() {
                Rule::indices => indices = Some(self.indices(part)?),
                Rule::expr => sides.push(self.expression(part)),
                _ => {}
            }
        }
        match sides.as_slice() {
            [left, right] => Ok(StatementKind::Constraint {
                indices,
                left: *left,
                right: *right,
            }),
            _ => required(None, span),
        }
    }

    /// The parts of `param`, `let`, `guess`, `equilibrium` and of a name of `coord`; the flag is
    /// the prime of a rate.
    fn binding(&mut self, pair: Pair<'_, Rule>) -> Result<(Binding, bool), SyntaxError> {
        let span = self.span(&pair);
        let mut name = None;
        let mut indices = None;
        let mut unit = None;
        let mut value = None;
        let mut uncertainty = None;
        let mut rate = false;
        for part in pair.into_inner() {
            match part.as_rule() {
                Rule::name => name = Some(self.declared(&part)),
                Rule::indices => indices = Some(self.indices(part)?),
                Rule::unit => unit = Some(self.unit(part)?),
                Rule::expr => value = Some(self.expression(part)),
                Rule::uncertainty => {
                    let expr = part.into_inner().find(|part| part.as_rule() == Rule::expr);
                    uncertainty = expr.map(|expr| self.expression(expr));
                }
                Rule::rate => rate = true,
                _ => {}
            }
        }
        let binding = Binding {
            name: required(name, span)?,
            indices,
            unit,
            value,
            uncertainty,
        };
        Ok((binding, rate))
    }

    fn name(&self, pair: &Pair<'_, Rule>) -> Name {
        Name {
            text: pair.as_str().to_owned(),
            span: self.span(pair),
        }
    }

    /// A name that the file declares, which can't be one of the language's own.
    fn declared(&self, pair: &Pair<'_, Rule>) -> Name {
        let name = self.name(pair);
        if let Some(meaning) = words::reserved_for(&name.text) {
            self.object(SyntaxError::ReservedName {
                name: name.text.clone(),
                meaning,
                span: name.span,
            });
        }
        name
    }

    fn first_name(&self, parts: Pairs<'_, Rule>) -> Option<Name> {
        parts
            .into_iter()
            .find(|part| part.as_rule() == Rule::name)
            .map(|part| self.name(&part))
    }

    fn indices(&self, pair: Pair<'_, Rule>) -> Result<Indices, SyntaxError> {
        let span = self.span(&pair);
        let mut entries = Vec::new();
        let mut filter = None;
        for part in pair.into_inner() {
            let span = self.span(&part);
            match part.as_rule() {
                Rule::rows => {
                    let mut names = part
                        .into_inner()
                        .filter(|part| part.as_rule() == Rule::name);
                    let variable = required(names.next(), span)?;
                    let table = required(names.next(), span)?;
                    let kind = IndexKind::Rows {
                        variable: self.declared(&variable),
                        table: self.name(&table),
                    };
                    entries.push(IndexEntry { span, kind });
                }
                Rule::range | Rule::unnamed => {
                    let kind = self.range(part)?;
                    entries.push(IndexEntry { span, kind });
                }
                Rule::filter => {
                    let expr = part.into_inner().find(|part| part.as_rule() == Rule::expr);
                    let outside = self.in_filter.replace(true);
                    filter = expr.map(|expr| self.expression(expr));
                    self.in_filter.set(outside);
                }
                _ => {}
            }
        }
        Ok(Indices {
            span,
            entries,
            filter,
        })
    }

    fn range(&self, pair: Pair<'_, Rule>) -> Result<IndexKind, SyntaxError> {
        let span = self.span(&pair);
        let mut variable = None;
        let mut from = None;
        let mut to = None;
        for part in pair.into_inner() {
            match part.as_rule() {
                Rule::name => variable = Some(self.declared(&part)),
                Rule::expr if from.is_none() => from = Some(self.expression(part)),
                Rule::expr => to = Some(self.expression(part)),
                _ => {}
            }
        }
        let from = required(from, span)?;
        Ok(match to {
            Some(to) => IndexKind::Range { variable, from, to },
            None => IndexKind::Member(from),
        })
    }

    // ---- units --------------------------------------------------------------------------------

    fn push_unit(&mut self, span: Span, kind: UnitKind) -> UnitRef {
        self.units.push(Unit { span, kind });
        UnitRef(self.units.len() as u32 - 1)
    }

    fn unit(&mut self, pair: Pair<'_, Rule>) -> Result<UnitRef, SyntaxError> {
        let span = self.span(&pair);
        let mut factors = Vec::new();
        let mut divided = false;
        for part in pair.into_inner() {
            match part.as_rule() {
                Rule::divide => divided = true,
                Rule::multiply => divided = false,
                Rule::unit_factor => factors.push((divided, self.unit_factor(part)?)),
                _ => {}
            }
        }
        match factors.as_slice() {
            [(_, only)] => Ok(*only),
            _ => Ok(self.push_unit(span, UnitKind::Product(factors))),
        }
    }

    fn unit_factor(&mut self, pair: Pair<'_, Rule>) -> Result<UnitRef, SyntaxError> {
        let span = self.span(&pair);
        let mut base = None;
        let mut power = None;
        for part in pair.into_inner() {
            let here = self.span(&part);
            match part.as_rule() {
                Rule::unit_one => base = Some(self.push_unit(here, UnitKind::One)),
                Rule::unit_name => {
                    base = Some(self.push_unit(here, UnitKind::Name(part.as_str().to_owned())));
                }
                Rule::unit => base = Some(self.unit(part)?),
                Rule::exponent => power = Some(self.unit_exponent(part)?),
                _ => {}
            }
        }
        let base = required(base, span)?;
        Ok(match power {
            Some((numerator, denominator)) => self.push_unit(
                span,
                UnitKind::Power {
                    base,
                    numerator,
                    denominator,
                },
            ),
            None => base,
        })
    }

    fn unit_exponent(&self, pair: Pair<'_, Rule>) -> Result<(i32, i32), SyntaxError> {
        let span = self.span(&pair);
        let mut numerator = None;
        let mut denominator = Some(1);
        for part in pair.into_inner() {
            let value = part.as_str().parse::<i32>().ok();
            match part.as_rule() {
                Rule::integer => numerator = value,
                Rule::natural => denominator = value,
                _ => {}
            }
        }
        match (numerator, denominator) {
            (Some(numerator), Some(denominator)) if denominator != 0 => {
                Ok((numerator, denominator))
            }
            _ => Err(SyntaxError::UnitExponent { span }),
        }
    }

    // ---- expressions --------------------------------------------------------------------------

    fn push(&self, span: Span, kind: ExprKind) -> ExprRef {
        let mut expressions = self.expressions.borrow_mut();
        expressions.push(Expr { span, kind });
        ExprRef(expressions.len() as u32 - 1)
    }

    fn expression(&self, pair: Pair<'_, Rule>) -> ExprRef {
        let operand = self
            .precedences
            .map_primary(|pair| self.primary(pair))
            .map_prefix(|sign, operand| self.prefix(&sign, operand))
            .map_postfix(|operand, sign| self.postfix(operand, sign))
            .map_infix(|left, sign, right| self.infix(left, &sign, right))
            .parse(pair.into_inner());
        self.close(operand)
    }

    fn expressions_in(&self, pair: Pair<'_, Rule>) -> Vec<ExprRef> {
        pair.into_inner()
            .filter(|part| part.as_rule() == Rule::expr)
            .map(|part| self.expression(part))
            .collect()
    }

    /// Makes a node of an operand that takes no more members.
    fn close(&self, operand: Operand<'_>) -> ExprRef {
        let kind = match operand.form {
            Form::Done(at) => return at,
            Form::Name(name) => ExprKind::Name(name.to_owned()),
            Form::Sum(terms) => ExprKind::Sum(terms),
            Form::Product(factors) => ExprKind::Product(factors),
            Form::Compare(operator, left, right) => ExprKind::Compare {
                operator,
                left,
                right,
            },
            Form::And(members) => ExprKind::And(members),
            Form::Or(members) => ExprKind::Or(members),
        };
        self.push(operand.span, kind)
    }

    fn primary<'i>(&self, pair: Pair<'i, Rule>) -> Operand<'i> {
        let span = self.span(&pair);
        let form = match pair.as_rule() {
            Rule::name => Form::Name(pair.as_str()),
            Rule::number => Form::Done(self.push(span, ExprKind::Number(pair.as_str().to_owned()))),
            Rule::vector => {
                let members = self.expressions_in(pair);
                Form::Done(self.push(span, ExprKind::Vector(members)))
            }
            Rule::sum_over => Form::Done(self.sum_over(pair)),
            // A parenthesis closes what is inside and leaves no node of its own.
            _ => match self.expressions_in(pair).first() {
                Some(inner) => Form::Done(*inner),
                None => self.impossible(span),
            },
        };
        Operand { span, form }
    }

    /// For shapes of pairs that the grammar has no way to make: an error instead of a tree.
    fn impossible<'i>(&self, span: Span) -> Form<'i> {
        self.object(incomplete(span));
        Form::Name("")
    }

    fn sum_over(&self, pair: Pair<'_, Rule>) -> ExprRef {
        let span = self.span(&pair);
        let mut indices = Err(incomplete(span));
        let mut body = None;
        for part in pair.into_inner() {
            match part.as_rule() {
                Rule::sum_indices => indices = self.indices(part),
                Rule::expr => {
                    // The condition around a sum doesn't reach into it.
                    let outside = self.in_filter.replace(false);
                    body = Some(self.expression(part));
                    self.in_filter.set(outside);
                }
                _ => {}
            }
        }
        let kind = match (indices, body) {
            (Ok(indices), Some(body)) => ExprKind::SumOver { indices, body },
            (Err(error), _) => {
                self.object(error);
                ExprKind::Vector(Vec::new())
            }
            (Ok(_), None) => {
                self.object(incomplete(span));
                ExprKind::Vector(Vec::new())
            }
        };
        self.push(span, kind)
    }

    fn prefix<'i>(&self, sign: &Pair<'i, Rule>, operand: Operand<'i>) -> Operand<'i> {
        let at = self.span(sign);
        let span = at.to(operand.span);
        let inner = self.close(operand);
        let kind = if sign.as_rule() == Rule::not {
            self.condition(at);
            ExprKind::Not(inner)
        } else {
            ExprKind::Negate(inner)
        };
        Operand {
            span,
            form: Form::Done(self.push(span, kind)),
        }
    }

    fn postfix<'i>(&self, operand: Operand<'i>, sign: Pair<'i, Rule>) -> Operand<'i> {
        let at = self.span(&sign);
        let span = operand.span.to(at);
        if sign.as_rule() == Rule::arguments {
            return self.call(operand, sign);
        }
        let base = self.close(operand);
        let kind = match sign.as_rule() {
            Rule::subscript => ExprKind::Index {
                base,
                indices: self.expressions_in(sign),
            },
            Rule::field => {
                let column = sign
                    .into_inner()
                    .find(|part| part.as_rule() == Rule::column);
                match column {
                    Some(column) => ExprKind::Field {
                        base,
                        field: self.name(&column),
                    },
                    None => {
                        self.object(incomplete(at));
                        ExprKind::Prime(base)
                    }
                }
            }
            _ => ExprKind::Prime(base),
        };
        Operand {
            span,
            form: Form::Done(self.push(span, kind)),
        }
    }

    fn call<'i>(&self, operand: Operand<'i>, list: Pair<'i, Rule>) -> Operand<'i> {
        let at = self.span(&list);
        let span = operand.span.to(at);
        let Form::Name(name) = operand.form else {
            return Operand {
                span,
                form: self.impossible(span),
            };
        };
        if operand.span.end != at.start && !words::is_function(name) {
            self.object(SyntaxError::MissingMultiplication {
                left: name.to_owned(),
                right: "(…)".to_owned(),
                span: Span::new(operand.span.start, at.start + 1),
            });
        }
        let function = Name {
            text: name.to_owned(),
            span: operand.span,
        };
        let arguments = self.expressions_in(list);
        let kind = ExprKind::Call {
            function,
            arguments,
        };
        Operand {
            span,
            form: Form::Done(self.push(span, kind)),
        }
    }

    fn infix<'i>(
        &self,
        left: Operand<'i>,
        sign: &Pair<'i, Rule>,
        right: Operand<'i>,
    ) -> Operand<'i> {
        let span = left.span.to(right.span);
        let at = self.span(sign);
        let form = match sign.as_rule() {
            Rule::add => self.sum(left, false, right),
            Rule::subtract => self.sum(left, true, right),
            Rule::multiply => self.product(left, false, right),
            Rule::divide => self.product(left, true, right),
            Rule::equal => self.compare(at, left, Comparison::Equal, right),
            Rule::not_equal => self.compare(at, left, Comparison::NotEqual, right),
            Rule::less => self.compare(at, left, Comparison::Less, right),
            Rule::less_equal => self.compare(at, left, Comparison::LessEqual, right),
            Rule::greater => self.compare(at, left, Comparison::Greater, right),
            Rule::greater_equal => self.compare(at, left, Comparison::GreaterEqual, right),
            Rule::and => {
                self.condition(at);
                let mut members = match left.form {
                    Form::And(members) => members,
                    _ => vec![self.close(left)],
                };
                members.push(self.close(right));
                Form::And(members)
            }
            Rule::or => {
                self.condition(at);
                let mut members = match left.form {
                    Form::Or(members) => members,
                    _ => vec![self.close(left)],
                };
                members.push(self.close(right));
                Form::Or(members)
            }
            _ => {
                let base = self.close(left);
                let exponent = self.close(right);
                Form::Done(self.push(span, ExprKind::Power { base, exponent }))
            }
        };
        Operand { span, form }
    }

    fn sum<'i>(&self, left: Operand<'i>, subtracted: bool, right: Operand<'i>) -> Form<'i> {
        let mut terms = match left.form {
            Form::Sum(terms) => terms,
            _ => vec![Term {
                subtracted: false,
                value: self.close(left),
            }],
        };
        let value = self.close(right);
        terms.push(Term { subtracted, value });
        Form::Sum(terms)
    }

    fn product<'i>(&self, left: Operand<'i>, divided: bool, right: Operand<'i>) -> Form<'i> {
        let mut factors = match left.form {
            Form::Product(factors) => factors,
            _ => vec![Factor {
                divided: false,
                value: self.close(left),
            }],
        };
        let value = self.close(right);
        factors.push(Factor { divided, value });
        Form::Product(factors)
    }

    fn compare<'i>(
        &self,
        at: Span,
        left: Operand<'i>,
        operator: Comparison,
        right: Operand<'i>,
    ) -> Form<'i> {
        self.condition(at);
        if let Form::Compare(..) = left.form {
            self.object(SyntaxError::ChainedComparison {
                first: left.span,
                span: at,
            });
        }
        Form::Compare(operator, self.close(left), self.close(right))
    }

    /// Conditions stand only behind `where`.
    fn condition(&self, span: Span) {
        if !self.in_filter.get() {
            self.object(SyntaxError::ConditionOutsideFilter { span });
        }
    }
}

/// A part that the grammar makes sure of; its absence is an error like any other.
fn required<T>(part: Option<T>, span: Span) -> Result<T, SyntaxError> {
    part.ok_or_else(|| incomplete(span))
}

fn incomplete(span: Span) -> SyntaxError {
    SyntaxError::Unexpected {
        found: "an incomplete statement".to_owned(),
        expected: Vec::new(),
        span,
    }
}
