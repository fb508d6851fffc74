//! Running index programs: exact numbers for indices, ranges and filters.

use std::cmp::Ordering;

use super::ModelError;
use super::error::counted_indices;
use super::functions::Builtin;
use super::names::{Entity, World, key};
use super::program::{IndexForm, IndexOp, IndexProgram};
use super::table::Cell;
use crate::expr::{ExprId, evaluate_closed};
use crate::number::Number;
use crate::precision::{Ball, Function, Scalar};
use crate::span::Span;
use crate::syntax::Comparison;

/// A number that sets an index, or the truth of a condition.
#[derive(Clone, Debug)]
pub(super) enum Quantity {
    Exact(Number),
    /// Where roots and functions come in: an enclosure.
    Enclosed(Ball),
    Truth(bool),
    /// What has no value, and why.
    Missing(Box<ModelError>),
}

/// Stands for an operand that is missing.
static NOTHING: Quantity = Quantity::Truth(false);

impl Quantity {
    pub(super) fn ball(&self) -> Ball {
        match self {
            Self::Exact(number) => Ball::from_number(number, ()),
            Self::Enclosed(ball) => *ball,
            Self::Truth(_) | Self::Missing(_) => Ball::from_number(&Number::from(0), ()),
        }
    }

    fn exact(&self) -> Option<&Number> {
        if let Self::Exact(number) = self { Some(number) } else { None }
    }

    fn is_true(&self) -> bool {
        matches!(self, Self::Truth(true))
    }
}

impl World {
    /// The number that an index program comes to.
    pub(super) fn quantity(&self, program: &IndexProgram, slots: &[i64]) -> Result<Quantity, ModelError> {
        match &program.form {
            IndexForm::Constant(value) => Ok(Quantity::Exact(Number::from(*value))),
            IndexForm::Shifted { slot, shift } => {
                let variable = Number::from(slots.get(*slot).copied().unwrap_or(0));
                Ok(Quantity::Exact(variable.add(&Number::from(*shift))))
            }
            IndexForm::RowField { table, slot, column } => {
                let row = slots.get(*slot).copied().unwrap_or(0);
                let field = self.field(*table, row, *column, program.span)?;
                Ok(Quantity::Exact(field.clone()))
            }
            IndexForm::General => self.run_index(&program.ops, slots, program.span),
        }
    }

    /// The whole number that an index program comes to.
    pub(super) fn integer(&self, program: &IndexProgram, slots: &[i64]) -> Result<i64, ModelError> {
        // Far from the ends, so that no sum or difference of indices overflows.
        let within = |n: &i64| n.unsigned_abs() < i64::MAX.unsigned_abs() / 4;
        let span = program.span;
        let far = |value: String| ModelError::TooLarge { count: format!("indices like {value}"), span };
        let not = |value: String| ModelError::NotAnInteger { value, span };
        match self.quantity(program, slots)? {
            Quantity::Exact(number) if number.is_integer() => {
                number.to_i64().filter(within).ok_or_else(|| far(short(&number)))
            }
            Quantity::Exact(number) => Err(not(short(&number))),
            Quantity::Enclosed(ball) => {
                let (near, whole) = (ball.mid_f64(), ball.mid_f64().round());
                let is_near = (ball - Ball::exact(whole)).contains_zero();
                let rounded = format!("what roots or functions make {whole} but for their rounding");
                Err(not(if is_near { rounded } else { near.to_string() }))
            }
            Quantity::Truth(_) | Quantity::Missing(_) => Err(not("a condition".to_owned())),
        }
    }

    /// Whether a filter holds.
    pub(super) fn holds(&self, filter: &IndexProgram, slots: &[i64]) -> Result<bool, ModelError> {
        Ok(self.quantity(filter, slots)?.is_true())
    }

    pub(super) fn field(&self, table: usize, row: i64, column: usize, span: Span) -> Result<&Number, ModelError> {
        let table = &self.tables[table];
        match table.field(row, column) {
            Some(Cell::Number(number)) => Ok(number),
            Some(Cell::Text(text)) => Err(ModelError::BadTable {
                path: table.path.clone(),
                line: table.line(usize::try_from(row).unwrap_or(0)),
                reason: match table.columns[column].as_str() {
                    column if text.is_empty() => format!("the cell in column `{column}` is empty, a number is needed"),
                    column => format!("`{text}` in column `{column}` is not a number"),
                },
                span,
            }),
            None => Err(ModelError::IndexOutOfRange {
                help: None,
                member: format!("{}[{row}]", table.name),
                available: format!("the table has {} rows, counted from 1", table.rows()),
                span,
                declared: Some(table.span),
            }),
        }
    }

    /// The exact value of a parameter by its indices, or an enclosure of one that is not rational.
    fn parameter_quantity(&self, family: usize, indices: &[Quantity], span: Span) -> Result<Quantity, ModelError> {
        let whole = |index: &Quantity| {
            let value = || index.exact().map_or("the index".to_owned(), Number::to_string);
            let whole = index.exact().and_then(Number::to_i64);
            whole.ok_or_else(|| ModelError::NotAnInteger { value: value(), span })
        };
        let indices = indices.iter().map(whole).collect::<Result<Vec<i64>, _>>()?;
        if indices.len() > 3 {
            let family = &self.parameter_families[family];
            let what = format!("`{}`", family.name);
            return Err(ModelError::TooManyIndices { what, available: family.grid.rank, span });
        }
        if self.broken.contains(&Entity::Parameter(family)) {
            return Err(ModelError::FollowOn {});
        }
        let family = &self.parameter_families[family];
        let at = key(&indices);
        let rank = family.grid.rank;
        if indices.len() != rank {
            let what = format!("`{}` has {}, not {}", family.name, counted_indices(rank), indices.len());
            return Err(ModelError::shape((what, None), span));
        }
        let Some(number) = family.grid.find(&at) else { return Err(family.out_of_range(&indices, span)) };
        // A member of the family that is being worked out, or of one that could not be.
        let Some(parameter) = self.parameters.get(number) else { return Err(family.recursive(&at, span)) };
        let Some(value) = parameter.value else {
            return Err(ModelError::MissingValue { name: parameter.name.clone(), span });
        };
        self.closed_quantity(value).ok_or_else(|| ModelError::Undefined {
            what: format!("the value of `{}`", parameter.name),
            span,
            help: None,
        })
    }

    /// The number that an expression without symbols comes to.
    pub(super) fn closed_quantity(&self, value: ExprId) -> Option<Quantity> {
        if let Some(number) = self.pool.as_number(value) {
            return Some(Quantity::Exact(number.clone()));
        }
        evaluate_closed(&self.pool, value, ()).filter(Ball::is_finite).map(Quantity::Enclosed)
    }

    fn run_index(&self, ops: &[(IndexOp, Span)], slots: &[i64], whole: Span) -> Result<Quantity, ModelError> {
        let mut stack: Vec<Quantity> = Vec::new();
        for (op, span) in ops {
            let at = stack.len().saturating_sub(op.operands());
            let operands = stack.get(at..).unwrap_or_default();
            let missing = operands.iter().find(|own| matches!(own, Quantity::Missing(_)));
            let result = match missing.filter(|_| !matches!(op, IndexOp::And(_) | IndexOp::Or(_))) {
                Some(missing) => missing.clone(),
                None => {
                    let result = self.apply_index(op, operands, slots, *span);
                    result.unwrap_or_else(|error| Quantity::Missing(Box::new(error)))
                }
            };
            stack.truncate(at);
            stack.push(result);
        }
        match stack.pop() {
            Some(Quantity::Missing(error)) => Err(*error),
            Some(result) => Ok(result),
            None => Err(ModelError::Undefined { what: "this".to_owned(), span: whole, help: None }),
        }
    }

    /// One operation; only of `and` and `or` operands may have no value.
    fn apply_index(
        &self,
        op: &IndexOp,
        operands: &[Quantity],
        slots: &[i64],
        span: Span,
    ) -> Result<Quantity, ModelError> {
        let undefined = |what: &str| ModelError::Undefined { what: what.to_owned(), span, help: None };
        let operand = |place: usize| operands.get(place).unwrap_or(&NOTHING);
        Ok(match op {
            IndexOp::Number(number) => Quantity::Exact(number.clone()),
            IndexOp::Broken => return Err(ModelError::FollowOn {}),
            IndexOp::Pi => Quantity::Enclosed(Ball::pi(())),
            IndexOp::Variable(slot) => Quantity::Exact(Number::from(slots.get(*slot).copied().unwrap_or(0))),
            IndexOp::Parameter { family, .. } => self.parameter_quantity(*family, operands, span)?,
            IndexOp::Field { table, column } => {
                let row = operand(0).exact().and_then(Number::to_i64);
                let row = row.ok_or_else(|| ModelError::NotAnInteger { value: "the row".to_owned(), span })?;
                Quantity::Exact(self.field(*table, row, *column, span)?.clone())
            }
            IndexOp::Negate => match operand(0) {
                Quantity::Exact(a) => Quantity::Exact(a.neg()),
                other => Quantity::Enclosed(other.ball().neg()),
            },
            IndexOp::Power => power(operand(0), operand(1)).ok_or_else(|| undefined("this power"))?,
            IndexOp::Product(divided) => {
                product(operands, divided).ok_or_else(|| undefined("a quotient with divisor 0"))?
            }
            IndexOp::Sum(subtracted) => total(operands, subtracted),
            IndexOp::Mod => {
                let both = operand(0).exact().zip(operand(1).exact());
                let (a, b) = both.ok_or_else(|| undefined("`mod` of numbers that are not rational"))?;
                Quantity::Exact(a.rem_floor(b).ok_or_else(|| undefined("`mod` by zero"))?)
            }
            IndexOp::Floor => Quantity::Exact(floor(operand(0), span)?),
            IndexOp::Sqrt => root(operand(0)).ok_or_else(|| undefined("the root of a negative number"))?,
            IndexOp::Norm(_) => {
                let two = Quantity::Exact(Number::from(2));
                let squares: Option<Vec<Quantity>> = operands.iter().map(|part| power(part, &two)).collect();
                let squares = squares.ok_or_else(|| undefined("this `norm`"))?;
                let square = total(&squares, &vec![false; squares.len()]);
                root(&square).ok_or_else(|| undefined("this `norm`"))?
            }
            IndexOp::Apply(function) => applied(*function, operand(0), span)?,
            IndexOp::Compare(comparison) => {
                let truth = compare(operand(0), operand(1), *comparison);
                Quantity::Truth(truth.ok_or(ModelError::UndecidedComparison { span })?)
            }
            IndexOp::Not => Quantity::Truth(!operand(0).is_true()),
            IndexOp::And(_) => decided(operands, false),
            IndexOp::Or(_) => decided(operands, true),
        })
    }
}

/// `and` is false where one operand is, `or` true where one is, whether the others have values or not.
fn decided(operands: &[Quantity], by: bool) -> Quantity {
    if operands.iter().any(|own| matches!(own, Quantity::Truth(truth) if *truth == by)) {
        return Quantity::Truth(by);
    }
    let missing = operands.iter().find(|own| matches!(own, Quantity::Missing(_)));
    missing.cloned().unwrap_or(Quantity::Truth(!by))
}

fn floor(value: &Quantity, span: Span) -> Result<Number, ModelError> {
    if let Quantity::Exact(a) = value {
        return Ok(a.floor());
    }
    let ball = value.ball();
    let (low, high) = (ball.lower().floor(), ball.upper().floor());
    if low != high {
        return Err(ModelError::UndecidedComparison { span });
    }
    let undefined = || ModelError::Undefined { what: "this `floor`".to_owned(), span, help: None };
    Number::from_f64_exact(low).ok_or_else(undefined)
}

fn applied(function: Function, x: &Quantity, span: Span) -> Result<Quantity, ModelError> {
    if let (Function::Abs, Quantity::Exact(a)) = (function, x) {
        return Ok(Quantity::Exact(a.abs()));
    }
    let ball = x.ball().apply(function);
    if ball.is_finite() || function == Function::Abs {
        return Ok(Quantity::Enclosed(ball));
    }
    let x = x.exact().map_or("…".to_owned(), Number::to_string);
    Err(Builtin::Elementary(function).undefined_for(&x, span))
}

/// A number in a message: long ones by their beginning.
fn short(number: &Number) -> String {
    let text = number.to_string();
    if text.len() <= 40 {
        return text;
    }
    let start: String = text.chars().take(20).collect();
    format!("{start}… ({} characters)", text.len())
}

fn power(base: &Quantity, exponent: &Quantity) -> Option<Quantity> {
    if let (Quantity::Exact(a), Quantity::Exact(e)) = (base, exponent)
        && let Some(e) = e.to_i64()
    {
        let e = i32::try_from(e).ok()?;
        return a.powi(e).map(Quantity::Exact);
    }
    if exponent.exact() == Some(&Number::half()) {
        return root(base);
    }
    let ball = base.ball().pow(&exponent.ball());
    ball.is_finite().then_some(Quantity::Enclosed(ball))
}

fn root(radicand: &Quantity) -> Option<Quantity> {
    if radicand.exact().is_some_and(Number::is_negative) {
        return None;
    }
    if let Some(root) = radicand.exact().and_then(Number::sqrt_exact) {
        return Some(Quantity::Exact(root));
    }
    let ball = radicand.ball().sqrt();
    ball.is_finite().then_some(Quantity::Enclosed(ball))
}

fn product(factors: &[Quantity], divided: &[bool]) -> Option<Quantity> {
    let mut result = Quantity::Exact(Number::from(1));
    for (factor, divided) in factors.iter().zip(divided) {
        result = match (&result, factor) {
            (Quantity::Exact(a), Quantity::Exact(b)) => Quantity::Exact(if *divided { a.div(b)? } else { a.mul(b) }),
            (a, b) => {
                let [a, b] = [a, b].map(Quantity::ball);
                Some(if *divided { a.div(&b) } else { a.mul(&b) }).filter(Ball::is_finite).map(Quantity::Enclosed)?
            }
        };
    }
    Some(result)
}

fn total(terms: &[Quantity], subtracted: &[bool]) -> Quantity {
    let zero = Quantity::Exact(Number::from(0));
    terms.iter().zip(subtracted).fold(zero, |sum, (term, subtracted)| match (&sum, term) {
        (Quantity::Exact(a), Quantity::Exact(b)) => Quantity::Exact(if *subtracted { a.sub(b) } else { a.add(b) }),
        (a, b) if *subtracted => Quantity::Enclosed(a.ball().sub(&b.ball())),
        (a, b) => Quantity::Enclosed(a.ball().add(&b.ball())),
    })
}

fn compare(a: &Quantity, b: &Quantity, comparison: Comparison) -> Option<bool> {
    let order = match (a, b) {
        (Quantity::Exact(a), Quantity::Exact(b)) => a.cmp(b),
        (a, b) => {
            let difference = a.ball().sub(&b.ball());
            if difference.is_positive() {
                Ordering::Greater
            } else if difference.is_negative() {
                Ordering::Less
            } else {
                return None;
            }
        }
    };
    Some(is_so(order, comparison))
}

/// What a comparison says of two numbers in this order.
pub(super) fn is_so(order: Ordering, comparison: Comparison) -> bool {
    match comparison {
        Comparison::Equal => order.is_eq(),
        Comparison::NotEqual => order.is_ne(),
        Comparison::Less => order.is_lt(),
        Comparison::LessEqual => order.is_le(),
        Comparison::Greater => order.is_gt(),
        Comparison::GreaterEqual => order.is_ge(),
    }
}
