//! Running programs: once in full, to symbolic values, and once an instance of a sum in light form,
//! to find out only what the instance fills the slots of its term with.
//!
//! Both walk through a program in the same order. What the light run meets on its way (which member
//! of a family, which piece of a `let`, how many terms of an inner sum) it writes down as a
//! signature; an instance with the same signature as another has the same term with other slots, and
//! is never run in full.

use super::ModelError;
use super::functions::Builtin;
use super::index::Quantity;
use super::instance::{Along, Instance, Leaf};
use super::names::World;
use super::program::{Binder, Field, IndexProgram, Op, Program, SumProgram};
use super::read::component;
use super::sieve::Left;
use super::values::{self, Value};
use crate::expr::{ExprId, Node, Symbol};
use crate::number::Number;
use crate::span::Span;

/// More terms than this in one sum are refused.
pub(super) const MOST_INSTANCES: u64 = 20_000_000;

/// What a term of a sum takes, at least.
pub(crate) const BYTES_A_TERM: usize = 128;

/// A term with more slots than this couples too much to be worth keeping as a family.
const MOST_SLOTS: usize = 64;

/// `let` families nested deeper than this are written out when they are declared.
pub(super) const DEEPEST_LET: usize = 64;

/// `let` families whose members read more members than this, directly and through others, too.
pub(super) const COSTLIEST_LET: u64 = 4096;

/// Why a run stopped.
pub(super) enum Stop {
    Error(Box<ModelError>),
    /// The term can't have slots: it must be written out.
    WriteOut,
}

impl Stop {
    /// The mistake of what is written out already.
    pub(super) fn written_out(self, span: Span) -> ModelError {
        match self {
            Self::Error(error) => *error,
            // Only runs with slots ask for it.
            Self::WriteOut => ModelError::Undefined { what: "this".to_owned(), span, help: None },
        }
    }
}

impl From<ModelError> for Stop {
    fn from(error: ModelError) -> Self {
        Self::Error(Box::new(error))
    }
}

fn shape(misfit: values::Misfit, span: Span) -> Stop {
    Stop::from(ModelError::shape(misfit, span))
}

impl World {
    /// Runs a program to its value; with an `instance`, members become slots.
    pub(super) fn run(
        &mut self,
        program: &Program,
        slots: &mut Vec<i64>,
        mut instance: Option<&mut Instance>,
    ) -> Result<Value, Stop> {
        let mut stack: Vec<Value> = Vec::new();
        for (op, span) in &program.ops {
            let operands = stack.split_off(stack.len().saturating_sub(operand_count(op)));
            stack.extend(self.step(op, *span, operands, slots, instance.as_deref_mut())?);
        }
        Ok(stack.pop().unwrap_or(Value::Vector(Vec::new())))
    }

    /// One operation; `None` where it leaves no value.
    pub(super) fn step(
        &mut self,
        op: &Op,
        span: Span,
        operands: Vec<Value>,
        slots: &mut Vec<i64>,
        mut instance: Option<&mut Instance>,
    ) -> Result<Option<Value>, Stop> {
        self.pool.take_outgrown();
        let value = match op {
            Op::Literal(e) => Value::Scalar(*e),
            Op::Broken => return Err(Stop::from(ModelError::FollowOn {})),
            Op::Time => {
                let time = self.time_symbol();
                Value::Scalar(self.pool.symbol_expr(time))
            }
            Op::Number(number) => {
                let number = self.exact(number, slots)?;
                Value::Scalar(self.number_value(number, Leaf::Number, instance.as_deref_mut()))
            }
            Op::Field(Field { table, row, column }) => {
                let row = self.integer(row, slots)?;
                let number = self.field(*table, row, *column, span)?.clone();
                let leaf = |_| Leaf::Field { table: *table, row, column: *column };
                Value::Scalar(self.number_value(number, leaf, instance.as_deref_mut()))
            }
            Op::Read { entity, indices } => {
                let at = self.integers(indices, slots)?.into_iter().map(|value| Along { value, step: 0 });
                self.read(*entity, &at.collect::<Vec<_>>(), span, instance.as_deref_mut(), false)?
            }
            Op::BeginExponent | Op::EndExponent => {
                if let Some(instance) = instance {
                    instance.exponent(op);
                }
                return Ok(None);
            }
            Op::Prime => match operands.first() {
                Some(value) => value.map(&mut |e| self.time_derivative(e)),
                None => Value::Vector(Vec::new()),
            },
            Op::Negate => match operands.first() {
                Some(value) => value.map(&mut |e| self.pool.neg(e)),
                None => Value::Vector(Vec::new()),
            },
            Op::Power => self.power(&operands, span)?,
            Op::Product(inverted) | Op::Sum(inverted) => {
                let parts: Vec<(bool, Value)> = inverted.iter().copied().zip(operands).collect();
                let combine = if matches!(op, Op::Sum(_)) { values::sum } else { values::product };
                combine(&mut self.pool, &parts).map_err(|e| shape(e, span))?
            }
            Op::Vector(_) => Value::rows(operands).map_err(|e| shape(e, span))?,
            Op::Together(_) => Value::Vector(operands),
            Op::Component(indices) => {
                let at = self.integers(indices, slots)?;
                let base = operands.into_iter().next().unwrap_or(Value::Vector(Vec::new()));
                component(base, at, span)?
            }
            Op::Call(builtin, _) => {
                let value = self.call(*builtin, &operands, span)?;
                if self.is_undefined(&value) && !self.pool.is_spent() {
                    return Err(Stop::from(builtin.undefined(&self.pool, &operands, span)));
                }
                value
            }
            Op::SumOver(sum) => self.sum_over(sum, slots, instance, span)?,
            Op::Integral(variable, body) => self.integral(*variable, body, &operands, slots, instance, span)?,
        };
        self.pool.budget().check().map_err(ModelError::from)?;
        if self.is_undefined(&value) {
            if self.pool.take_outgrown() {
                let what = "this value".to_owned();
                return Err(Stop::from(ModelError::NumberTooLong { what, span }));
            }
            let what = match op {
                Op::Product(_) => "a quotient with divisor 0",
                Op::Power => "this power",
                _ => "this value",
            };
            return Err(Stop::from(ModelError::Undefined { what: what.to_owned(), span, help: None }));
        }
        Ok(Some(value))
    }

    fn is_undefined(&self, value: &Value) -> bool {
        matches!(value, Value::Scalar(e) if matches!(self.pool.node(*e), Node::Undefined))
    }

    /// Runs a program without slots; everything is written out.
    pub(super) fn run_written_out(&mut self, program: &Program, slots: &mut Vec<i64>) -> Result<Value, ModelError> {
        self.run(program, slots, None).map_err(|stop| stop.written_out(program.span))
    }

    /// Finds out what an instance fills the slots with, and its signature, and for how many further ones it does so alike
    /// where the index variables grow by `steps`.
    pub(super) fn run_light(
        &mut self,
        program: &Program,
        slots: &mut Vec<i64>,
        steps: &mut Vec<i64>,
        instance: &mut Instance,
    ) -> Result<(), Stop> {
        for (op, span) in &program.ops {
            match op {
                Op::Number(number) => {
                    let value = self.exact(number, slots)?;
                    let step = self.growth(number, slots, steps);
                    let step = instance.step(step);
                    instance.note_number(value, step);
                }
                Op::Field(Field { table, row, column }) => {
                    let row = self.along(row, slots, steps, instance)?;
                    let number = self.field(*table, row.value, *column, *span)?;
                    if instance.in_exponent == 0 {
                        instance.limit(self.tables[*table].steady(row, *column));
                        let leaf = Leaf::Field { table: *table, row: row.value, column: *column };
                        instance.slot(leaf, row.step);
                    } else {
                        instance.note_number(number.clone(), row.step);
                    }
                }
                Op::Read { entity, indices } => {
                    if indices.len() <= 3 {
                        let mut at = [Along::default(); 3];
                        for (own, index) in at.iter_mut().zip(indices) {
                            *own = self.along(index, slots, steps, instance)?;
                        }
                        self.read(*entity, &at[..indices.len()], *span, Some(instance), true)?;
                    } else {
                        let at = indices.iter().map(|index| self.along(index, slots, steps, instance));
                        let at = at.collect::<Result<Vec<Along>, _>>()?;
                        self.read(*entity, &at, *span, Some(instance), true)?;
                    }
                }
                Op::BeginExponent | Op::EndExponent => instance.exponent(op),
                Op::Component(indices) => {
                    for index in indices {
                        let index = self.along(index, slots, steps, instance)?;
                        instance.note_index(index);
                    }
                }
                Op::SumOver(sum) => self.sum_light(sum, slots, steps, *span, instance)?,
                Op::Integral(_, body) => self.run_light(body, slots, steps, instance)?,
                Op::Broken => return Err(Stop::from(ModelError::FollowOn {})),
                Op::Literal(_)
                | Op::Time
                | Op::Prime
                | Op::Negate
                | Op::Power
                | Op::Product(_)
                | Op::Sum(_)
                | Op::Vector(_)
                | Op::Together(_)
                | Op::Call(..) => {}
            }
        }
        Ok(())
    }

    fn sum_light(
        &mut self,
        sum: &SumProgram,
        slots: &mut Vec<i64>,
        steps: &mut Vec<i64>,
        span: Span,
        instance: &mut Instance,
    ) -> Result<(), Stop> {
        let (mut count, outer) = (0_i64, steps.len());
        let filters = filters(sum);
        self.push_growth(&sum.binders, &filters, steps, instance);
        let done = self.instances(&sum.binders, &filters, slots, span, |world, slots| {
            count += 1;
            world.run_light(&sum.body, slots, steps, instance)?;
            if instance.leaves.len() > MOST_SLOTS { Err(Stop::WriteOut) } else { Ok(()) }
        });
        steps.truncate(outer);
        instance.note(count);
        done
    }

    /// Adds the steps of the indices of a sum within a term.
    pub(super) fn push_growth(
        &self,
        binders: &[Binder],
        filters: &[(usize, &IndexProgram)],
        steps: &mut Vec<i64>,
        instance: &mut Instance,
    ) {
        for binder in binders {
            let growth = self.binder_growth(binder, steps);
            steps.push(instance.step(growth));
        }
        if filters.iter().any(|(_, filter)| filter.moves(steps)) {
            instance.limit(0);
        }
    }

    /// An index, and how it grows.
    fn along(
        &self,
        index: &IndexProgram,
        slots: &[i64],
        steps: &[i64],
        instance: &mut Instance,
    ) -> Result<Along, ModelError> {
        let value = self.integer(index, slots)?;
        Ok(Along { value, step: instance.step(self.growth(index, slots, steps)) })
    }

    fn integers(&self, indices: &[IndexProgram], slots: &[i64]) -> Result<Vec<i64>, ModelError> {
        indices.iter().map(|index| self.integer(index, slots)).collect()
    }

    fn exact(&self, number: &IndexProgram, slots: &[i64]) -> Result<Number, ModelError> {
        match self.quantity(number, slots)? {
            Quantity::Exact(number) => Ok(number),
            Quantity::Enclosed(_) | Quantity::Truth(_) | Quantity::Missing(_) => {
                Err(ModelError::Undefined { what: "a rational number; this".to_owned(), span: number.span, help: None })
            }
        }
    }

    /// A number, or with an instance the slot of its leaf.
    fn number_value(
        &mut self,
        number: Number,
        leaf: impl FnOnce(Number) -> Leaf,
        instance: Option<&mut Instance>,
    ) -> ExprId {
        match instance {
            Some(instance) if instance.in_exponent == 0 => {
                let slot = instance.slot(leaf(number), 0);
                self.value_slot(slot)
            }
            Some(_) | None => self.pool.number(number),
        }
    }

    /// Runs `body` for every value of the indices, in order; their slots lie on top of `slots`.
    pub(super) fn instances<E: From<ModelError>>(
        &mut self,
        binders: &[Binder],
        filters: &[(usize, &IndexProgram)],
        slots: &mut Vec<i64>,
        span: Span,
        mut body: impl FnMut(&mut Self, &mut Vec<i64>) -> Result<(), E>,
    ) -> Result<(), E> {
        self.stretches(binders, filters, slots, span, |world, slots, _| body(world, slots).map(|()| 0))
    }

    /// As [`World::instances`] for a `body` that may deal with several values of the last index at once: given how many there
    /// are at most after the current one, it says how many of these it has dealt with.
    pub(super) fn stretches<E: From<ModelError>>(
        &mut self,
        binders: &[Binder],
        filters: &[(usize, &IndexProgram)],
        slots: &mut Vec<i64>,
        span: Span,
        body: impl FnMut(&mut Self, &mut Vec<i64>, u64) -> Result<u64, E>,
    ) -> Result<(), E> {
        let base = slots.len();
        let done = self.walk(binders, filters, slots, span, body);
        // Whatever it ended with: a term may be run once more, written out.
        slots.truncate(base);
        done
    }

    fn walk<E: From<ModelError>>(
        &mut self,
        binders: &[Binder],
        filters: &[(usize, &IndexProgram)],
        slots: &mut Vec<i64>,
        span: Span,
        mut body: impl FnMut(&mut Self, &mut Vec<i64>, u64) -> Result<u64, E>,
    ) -> Result<(), E> {
        let base = slots.len();
        let last_slot = base + binders.len().saturating_sub(1);
        let filtered = filters.iter().any(|(_, filter)| filter.depends(|slot| slot == last_slot));
        let sieve = if base == 0 { self.sieve(binders, filters, span)? } else { None };
        if sieve.is_none() {
            self.check_count(binders, slots, span)?;
        }
        // What a sieve has left of the last index.
        let mut listed: Option<std::vec::IntoIter<Left>> = None;
        let mut levels: Vec<(i64, i64)> = Vec::with_capacity(binders.len());
        // Sums within sums count together.
        if base == 0 {
            self.steps = 0;
        }
        let mut descend = true;
        loop {
            if descend && levels.len() < binders.len() {
                let range = self.binder_range(&binders[levels.len()], slots)?;
                levels.push(range);
                if levels.len() == binders.len() {
                    listed = sieve.as_ref().and_then(|sieve| sieve.left(self, slots, range)).map(Vec::into_iter);
                }
            }
            let Some((next, last)) = levels.last_mut() else { return Ok(()) };
            let (mut value, last) = (*next, *last);
            *next += 1;
            let depth = levels.len();
            let mut certain = None;
            if depth == binders.len()
                && let Some(listed) = &mut listed
            {
                let (left, is_certain) = listed.next().unwrap_or((last + 1, false));
                value = left;
                certain = sieve.as_ref().filter(|_| is_certain).map(|sieve| sieve.filter);
            }
            slots.truncate(base + depth - 1);
            if value > last {
                levels.pop();
                if levels.is_empty() {
                    return Ok(());
                }
                descend = false;
                continue;
            }
            self.steps += 1;
            self.pool.budget().check().map_err(ModelError::from)?;
            if self.steps > MOST_INSTANCES {
                return Err(E::from(too_many_terms(span)));
            }
            slots.push(value);
            descend = true;
            for (number, (after, filter)) in filters.iter().enumerate() {
                if *after == depth && certain != Some(number) && !self.holds(filter, slots)? {
                    descend = false;
                }
            }
            if descend && depth == binders.len() {
                let before = self.steps;
                let most = if filtered { 0 } else { (last - value).unsigned_abs() };
                let further = body(self, slots, most)?;
                slots.truncate(base + depth);
                descend = false;
                if let Some((next, _)) = levels.last_mut() {
                    *next += i64::try_from(further).unwrap_or(i64::MAX);
                }
                // Those dealt with at once count as much as the first.
                self.steps += further.saturating_mul(self.steps - before + 1);
                if self.steps > MOST_INSTANCES {
                    return Err(E::from(too_many_terms(span)));
                }
            }
        }
    }

    /// Refuses a sum with too many terms before the first is worked out: the ranges of all indices
    /// but the last are walked through, those of the last added up.
    fn check_count(&mut self, binders: &[Binder], slots: &mut Vec<i64>, span: Span) -> Result<(), ModelError> {
        let Some((last, outer)) = binders.split_last().filter(|(_, outer)| !outer.is_empty()) else {
            // A single range is checked where it is read.
            return Ok(());
        };
        if let Some(count) = self.fixed_count(binders) {
            return if count > MOST_INSTANCES { Err(too_many_terms(span)) } else { Ok(()) };
        }
        let (steps, mut count) = (self.steps, 0_u64);
        self.steps = 0;
        let counted = self.instances(outer, &[], slots, span, |world, slots| {
            let (from, to) = world.binder_range(last, slots)?;
            count += u64::try_from(to - from + 1).unwrap_or(0);
            if count > MOST_INSTANCES { Err(too_many_terms(span)) } else { Ok(()) }
        });
        self.steps = steps;
        counted
    }

    /// Refuses more terms than there is memory for before the first, where no filter tells how many there are; what is too
    /// much for any memory has an error of its own.
    pub(super) fn check_room(&self, binders: &[Binder], filters: &[(usize, &IndexProgram)]) -> Result<(), ModelError> {
        let count =
            self.fixed_count(binders).filter(|count| filters.is_empty() && *count <= MOST_INSTANCES).unwrap_or(0);
        let count = usize::try_from(count).unwrap_or(usize::MAX);
        Ok(self.pool.budget().room(count, BYTES_A_TERM)?)
    }

    /// How many values indices take whose ranges depend on no index.
    pub(super) fn fixed_count(&self, binders: &[Binder]) -> Option<u64> {
        binders.iter().try_fold(1_u64, |count, binder| {
            let (from, to) = if binder.is_fixed() { self.binder_range(binder, &[]).ok()? } else { return None };
            Some(count.saturating_mul(u64::try_from(to - from + 1).unwrap_or(0)))
        })
    }

    pub(super) fn binder_range(&self, binder: &Binder, slots: &[i64]) -> Result<(i64, i64), ModelError> {
        let [from, to] = &binder.ends;
        let range = (self.integer(from, slots)?, self.integer(to, slots)?);
        let count = range.1.saturating_sub(range.0).saturating_add(1);
        if u64::try_from(count).is_ok_and(|count| count > MOST_INSTANCES) {
            return Err(ModelError::TooLarge { count: format!("the {count} values of this range"), span: binder.span });
        }
        Ok(range)
    }

    fn sum_over(
        &mut self,
        sum: &SumProgram,
        slots: &mut Vec<i64>,
        mut instance: Option<&mut Instance>,
        span: Span,
    ) -> Result<Value, Stop> {
        let mut terms: Vec<(bool, Value)> = Vec::new();
        let filters = filters(sum);
        self.check_room(&sum.binders, &filters)?;
        self.instances::<Stop>(&sum.binders, &filters, slots, span, |world, slots| {
            let term = world.run(&sum.body, slots, instance.as_deref_mut())?;
            terms.push((false, term));
            Ok(())
        })?;
        values::sum(&mut self.pool, &terms).map_err(|e| shape(e, span))
    }

    /// Exact, or an error; what slots leave open is written out.
    fn integral(
        &mut self,
        variable: Symbol,
        body: &Program,
        bounds: &[Value],
        slots: &mut Vec<i64>,
        mut instance: Option<&mut Instance>,
        span: Span,
    ) -> Result<Value, Stop> {
        let bounds: Result<Vec<ExprId>, _> = bounds.iter().map(|bound| bound.scalar("a bound")).collect();
        let bounds = bounds.map_err(|e| shape(e, span))?;
        let [from, to] = bounds.as_slice() else { return Ok(Value::Vector(Vec::new())) };
        let value = self.run(body, slots, instance.as_deref_mut())?;
        let mut integrals = Vec::new();
        for e in value.scalars() {
            match self.integral_of(e, variable, [*from, *to], body.span) {
                Ok(integral) => integrals.push(integral),
                Err(_) if instance.is_some() => return Err(Stop::WriteOut),
                Err(error) => return Err(error.into()),
            }
        }
        let (mut integrals, zero) = (integrals.into_iter(), self.pool.zero());
        Ok(value.map(&mut |_| integrals.next().unwrap_or(zero)))
    }

    fn power(&mut self, operands: &[Value], span: Span) -> Result<Value, Stop> {
        let [base, exponent] = operands else { return Ok(Value::Vector(Vec::new())) };
        if matches!(base, Value::Vector(_)) {
            let help = match base.scalars().len() {
                1 => {
                    "a family of three members is declared by a range: `x[1..3]`; \
                     a unit stands behind a colon: `coord x : m`"
                }
                _ => "the square of a vector is `dot(v, v)`",
            };
            return Err(shape((format!("{} has no power", base.describe()), Some(help.to_owned())), span));
        }
        let base = base.scalar("the base").map_err(|e| shape(e, span))?;
        let mut exponent = exponent.scalar("the exponent").map_err(|e| shape(e, span))?;
        if base == self.pool.zero() {
            // 0^p is 0 or nothing: p decides, as far as it has a value.
            exponent = self.closed(exponent).unwrap_or(exponent);
        }
        Ok(Value::Scalar(self.pool.power(base, exponent)))
    }

    fn call(&mut self, builtin: Builtin, operands: &[Value], span: Span) -> Result<Value, Stop> {
        // The only function that needs more than its arguments.
        let rotation = operands.first().filter(|_| builtin == Builtin::AngularVelocity);
        let rate = rotation.map(|own| own.map(&mut |e| self.time_derivative(e)));
        builtin.apply(&mut self.pool, operands, rate).map_err(|e| shape(e, span))
    }
}

/// How many values an operation takes from the stack.
pub(super) fn operand_count(op: &Op) -> usize {
    match op {
        Op::Prime | Op::Negate | Op::Component(_) => 1,
        Op::Power | Op::Integral(..) => 2,
        Op::Product(parts) | Op::Sum(parts) => parts.len(),
        Op::Vector(count) | Op::Together(count) | Op::Call(_, count) => *count,
        Op::Literal(_)
        | Op::Broken
        | Op::Time
        | Op::Number(_)
        | Op::Field(_)
        | Op::Read { .. }
        | Op::BeginExponent
        | Op::EndExponent
        | Op::SumOver(_) => 0,
    }
}

pub(super) fn too_many_terms(span: Span) -> ModelError {
    ModelError::TooLarge { count: format!("more than {MOST_INSTANCES} terms"), span }
}

pub(super) fn filters(sum: &SumProgram) -> Vec<(usize, &IndexProgram)> {
    let after = sum.binders.len();
    sum.filter.iter().map(|filter| (after, filter)).collect()
}
