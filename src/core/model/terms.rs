//! Energies as families of terms.
//!
//! An energy is taken apart at its outer sums. `sum(i in 1..N, …)` becomes one term with slots and
//! a table of what every instance fills them with, whatever N is; what can't be kept so (a
//! pendulum's prefix sums) is written out into a single further term. Nothing is expanded and
//! nothing is differentiated here.

use std::collections::BTreeSet;
use std::ops::Range;

use hashbrown::HashMap;

use super::ModelError;
use super::compile::{Compiler, Scope};
use super::coordinates::numbered_slopes;
use super::instance::{Instance, Leaf};
use super::names::{Entity, Key, SymbolKind, World};
use super::program::{Binder, IndexOp, IndexProgram, Op, Program};
use super::run::Stop;
use super::table::Cell;
use super::values::Value;
use crate::expr::{ExprId, Pool, Substitution, Symbol};
use crate::number::Number;
use crate::order::{Gather, Order};
use crate::span::Span;
use crate::syntax::{ExprKind, ExprRef, File, Indices, Member};

/// A coordinate as it appears in the body of a [`TermFamily`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Local {
    /// The symbol that stands for the coordinate.
    pub coordinate: Symbol,
    /// The symbol that stands for its velocity.
    pub velocity: Symbol,
}

/// Terms of one form: a body with slots, and what each instance fills them with.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct TermFamily {
    /// Where the term stands.
    pub span: Span,
    /// The term, an expression in the symbols of `locals` and `values` and in parameters.
    pub body: ExprId,
    /// The coordinates in the body.
    pub locals: Vec<Local>,
    /// Further slots, filled with parameters or numbers.
    pub values: Vec<Symbol>,
    /// How many instances there are.
    pub count: usize,
    /// Numbers of the coordinates, `locals.len()` an instance.
    pub coordinates: Vec<u32>,
    /// Expressions for `values`, `values.len()` an instance.
    pub constants: Vec<ExprId>,
    /// Of a generalised force: the place in `locals` of the coordinate on which the body acts.
    pub acts_on: Option<usize>,
}

impl Local {
    /// The symbols of a coordinate and of its velocity.
    pub(crate) fn new(coordinate: Symbol, velocity: Symbol) -> Self {
        Self { coordinate, velocity }
    }
}

/// The derivatives by some variables, by their places, without those that vanish identically.
pub(crate) fn slopes_by(pool: &mut Pool, e: ExprId, variables: &[Symbol]) -> Vec<(usize, ExprId)> {
    let mut slopes = numbered_slopes(pool, e, |symbol| variables.iter().position(|own| *own == symbol));
    slopes.put_in_order();
    slopes
}

impl TermFamily {
    /// A term with a single instance.
    pub(crate) fn single(span: Span, body: ExprId, locals: Vec<Local>, coordinates: Vec<u32>) -> Self {
        Self { span, body, locals, values: Vec::new(), count: 1, coordinates, constants: Vec::new(), acts_on: None }
    }

    /// What puts all velocities to 0.
    #[must_use]
    pub fn at_rest(&self, pool: &Pool) -> Substitution {
        self.locals.iter().map(|local| (local.velocity, pool.zero())).gather()
    }

    /// What a family of [`Model::forces`](super::Model::forces) adds to the left sides of Lagrange's equations, by local:
    /// ∂F/∂q' of a dissipation function, -Q of a generalised force.
    pub fn drags(&self, pool: &mut Pool) -> Vec<(usize, ExprId)> {
        if let Some(place) = self.acts_on {
            return vec![(place, pool.neg(self.body))];
        }
        let velocities: Vec<Symbol> = self.locals.iter().map(|local| local.velocity).collect();
        slopes_by(pool, self.body, &velocities)
    }

    /// The coordinates of an instance, one number a local.
    #[must_use]
    pub fn coordinates_of(&self, instance: usize) -> &[u32] {
        let width = self.locals.len();
        self.coordinates.get(instance * width..(instance + 1) * width).unwrap_or(&[])
    }

    /// The values of an instance, one expression a value slot.
    #[must_use]
    pub fn constants_of(&self, instance: usize) -> &[ExprId] {
        let width = self.values.len();
        self.constants.get(instance * width..(instance + 1) * width).unwrap_or(&[])
    }

    /// Adds value slots, each with its place and the symbol that stands for the value that a coordinate there has.
    pub(crate) fn add_values(&mut self, slots: &[(usize, Symbol)], mut value: impl FnMut(u32) -> ExprId) {
        let mut constants = Vec::with_capacity(self.constants.len() + self.count * slots.len());
        for at in 0..self.count {
            constants.extend(self.constants_of(at));
            let numbers = self.coordinates_of(at);
            constants.extend(slots.iter().map(|(place, _)| value(numbers[*place])));
        }
        self.values.extend(slots.iter().map(|(_, symbol)| *symbol));
        self.constants = constants;
    }
}

/// Whether an expression is, seen from outside, a sum over an index.
pub(super) fn is_additive(file: &File, world: &World, root: ExprRef) -> bool {
    let mut todo = vec![root];
    while let Some(at) = todo.pop() {
        match &file.expr(at).kind {
            ExprKind::SumOver { .. } => return true,
            ExprKind::Sum(terms) => todo.extend(terms.iter().map(|term| term.value())),
            ExprKind::Negate(inner) => todo.push(*inner),
            ExprKind::Product(factors) => {
                todo.extend(factors.iter().filter(|factor| !factor.inverted()).map(|factor| factor.value()))
            }
            ExprKind::Name(name) => {
                if let Some((Entity::Let(number), _)) = world.names.get(*name)
                    && let family = &world.lets[*number]
                    && family.family.grid.rank == 0
                    && family.pieces.first().is_some_and(|piece| piece.additive)
                {
                    return true;
                }
            }
            _ => {}
        }
    }
    false
}

/// A part of an energy on its way from the outside in.
#[derive(Clone, Default)]
struct Part {
    at: ExprRef,
    negated: bool,
    prefactors: Vec<Prefactor>,
    binders: Vec<Binder>,
    filters: Vec<(usize, IndexProgram)>,
    scope: Scope,
    /// The coordinate on which it acts, of a generalised force.
    acts_on: Option<Program>,
    /// It has a mistake that is told already.
    broken: bool,
}

/// A factor in front of a part.
#[derive(Clone, Debug)]
struct Prefactor {
    divides: bool,
    program: Program,
    /// What it is and the indices outside of it, where there are sums in it.
    sums: Option<(ExprRef, Scope)>,
}

/// The terms of an energy. Every part is worked on, whatever is wrong with those before it.
pub(super) fn families(compiler: &mut Compiler<'_>, root: ExprRef) -> Result<Vec<TermFamily>, ModelError> {
    work_out(compiler, Part { at: root, ..Part::default() })
}

/// The terms of a generalised force on a coordinate or a family, with a factor for its unit; on those `listed` component by component.
pub(super) fn forces(
    compiler: &mut Compiler<'_>,
    root: ExprRef,
    acts_on: Entity,
    indices: Option<&Indices>,
    listed: Option<&[Key]>,
    factor: Option<ExprId>,
) -> Result<Vec<TermFamily>, ModelError> {
    let span = compiler.file.expr(root).span;
    let mut part = Part { at: root, ..Part::default() };
    if let (Some(indices), None) = (indices, listed) {
        let (binders, filter) = compiler.binders(indices, &mut part.scope);
        let most = binders.len();
        part.filters.extend(filter.map(|filter| (filter.known_after(most), filter)));
        part.binders = binders;
    }
    let at = |slot| IndexProgram::of(IndexOp::Variable(slot), span);
    let read = Op::Read { entity: acts_on, indices: (0..part.binders.len()).map(at).collect() };
    let constant = |key: &Key| IndexProgram::of(IndexOp::Number(Number::from(key[0])), span);
    let member = |key: &Key| (Op::Read { entity: acts_on, indices: [constant(key)].into() }, span);
    let ops = match listed {
        Some(keys) => keys.iter().map(member).chain([(Op::Vector(keys.len()), span)]).collect(),
        None => vec![(read, span)],
    };
    part.acts_on = Some(Program { ops, span });
    let factor = factor.map(|factor| Program { ops: vec![(Op::Literal(factor), span)], span });
    part.prefactors.extend(factor.map(|program| Prefactor { divides: false, program, sums: None }));
    work_out(compiler, part)
}

/// Terms that are written out, by the coordinate on which they act, if it is one.
type WrittenOut = Vec<(Option<Symbol>, ExprId)>;

fn work_out(compiler: &mut Compiler<'_>, whole: Part) -> Result<Vec<TermFamily>, ModelError> {
    let span = compiler.file.expr(whole.at).span;
    let mut mistakes = Vec::new();
    let mut result = Vec::new();
    let mut written_out = WrittenOut::new();
    let mut parts = vec![whole];
    while let Some(part) = parts.pop() {
        let (broken, before) = (part.broken, compiler.errors.len());
        let others = parts.len();
        let part = take_apart(compiler, part, &mut parts);
        let broken = broken || compiler.errors.len() > before;
        for part in parts.iter_mut().skip(others) {
            part.broken = broken;
        }
        let Some(part) = part else { continue };
        let program = assemble(compiler, &part);
        if !broken && compiler.errors.len() == before {
            let world = &mut *compiler.world;
            let before = mistakes.len();
            let mut work =
                Work { part: &part, program: &program, written_out: &mut written_out, mistakes: &mut mistakes };
            if let Err(error) = instantiate(world, &mut work, &mut result)
                && mistakes.len() == before
            {
                mistakes.push(error);
            }
        }
    }
    if !mistakes.is_empty() {
        mistakes.retain(|mistake| *mistake != (ModelError::FollowOn {}));
        mistakes.into_iter().for_each(|mistake| compiler.fail(mistake));
        return Err(ModelError::FollowOn {});
    }
    for (acts_on, terms) in written_out.into_iter().grouped() {
        let body = compiler.world.pool.sum(&terms);
        let mut only = Finisher::new(compiler.world, acts_on, body, span);
        only.push(compiler.world, &[], &[], 0);
        result.push(only.family);
    }
    Ok(result)
}

/// Pushes the pieces of a part, or gives it back where it is one piece.
fn take_apart(compiler: &mut Compiler<'_>, mut part: Part, parts: &mut Vec<Part>) -> Option<Part> {
    let file = compiler.file;
    let at = part.at;
    if !is_additive(file, compiler.world, at) {
        return Some(part);
    }
    part.at = match &file.expr(at).kind {
        ExprKind::Sum(terms) => {
            // The last on the stack comes first.
            for term in terms.iter().rev() {
                parts.push(Part { at: term.value(), negated: part.negated ^ term.inverted(), ..part.clone() });
            }
            return None;
        }
        ExprKind::Negate(inner) => {
            part.negated = !part.negated;
            *inner
        }
        ExprKind::Product(factors) => {
            let is_sum = |own: &&Member| !own.inverted() && is_additive(file, compiler.world, own.value());
            let sums = factors.iter().filter(is_sum).map(|own| own.value());
            // A product of sums is one term.
            let Some(inner) = sums.only() else { return Some(part) };
            for factor in factors.iter().filter(|factor| factor.value() != inner) {
                let program = compiler.value(factor.value(), &mut part.scope);
                let has_sums = program.ops.iter().any(|(op, _)| matches!(op, Op::SumOver(_) | Op::Integral(..)));
                let sums = has_sums.then(|| (factor.value(), part.scope.clone()));
                part.prefactors.push(Prefactor { divides: factor.inverted(), program, sums });
            }
            inner
        }
        ExprKind::SumOver { indices, body } => {
            let (binders, filter) = compiler.binders(indices, &mut part.scope);
            part.binders.extend(binders);
            let most = part.binders.len();
            part.filters.extend(filter.map(|filter| (filter.known_after(most), filter)));
            *body
        }
        ExprKind::Name(name) => {
            let root = match compiler.world.names.get(*name) {
                Some((Entity::Let(number), _)) => compiler.world.lets[*number].pieces.first().map(|piece| piece.root),
                Some(_) | None => None,
            };
            let Some(root) = root else { return Some(part) };
            // The indices outside are not visible inside the named expression.
            for (name, _) in &mut part.scope.variables {
                name.clear();
            }
            root
        }
        // None of these is a sum over an index.
        _ => return Some(part),
    };
    parts.push(part);
    None
}

/// The program of a whole part: prefactors times the expression, with the sign.
fn assemble(compiler: &mut Compiler<'_>, part: &Part) -> Program {
    let mut scope = part.scope.clone();
    let core = compiler.value(part.at, &mut scope);
    let span = core.span;
    let mut ops: Vec<(Op, Span)> = part.acts_on.iter().flat_map(|acts_on| acts_on.ops.iter().cloned()).collect();
    let mut divided: Vec<bool> = Vec::new();
    for Prefactor { divides, program, sums } in &part.prefactors {
        divided.push(*divides);
        let inside = part.scope.variables.iter();
        match sums {
            // The indices inside the sum in front of which it stands are not visible in it, but have their slots: its own come behind.
            Some((factor, outside)) if outside.variables.len() < inside.len() => {
                let mut scope = outside.clone();
                let inside = inside.skip(outside.variables.len());
                scope.variables.extend(inside.map(|(_, variable)| (String::new(), *variable)));
                ops.extend(compiler.value(*factor, &mut scope).ops);
            }
            Some(_) | None => ops.extend(program.ops.iter().cloned()),
        }
    }
    ops.extend(core.ops);
    if !divided.is_empty() {
        divided.push(false);
        ops.push((Op::Product(divided.into()), span));
    }
    if part.negated {
        ops.push((Op::Negate, span));
    }
    if part.acts_on.is_some() {
        ops.push((Op::Together(2), span));
    }
    Program { ops, span }
}

/// What a part has given: of a generalised force the symbol of the coordinate and the force, else an energy. Forces on a
/// vector come component by component.
fn given(world: &World, part: &Part, value: &Value, span: Span) -> Result<WrittenOut, ModelError> {
    if part.acts_on.is_none() {
        let help = Some("the square of a vector is `dot(v, v)`".to_owned());
        let energy = value.scalar("an energy").map_err(|(what, _)| ModelError::Shape { what, span, help })?;
        return Ok(vec![(None, energy)]);
    }
    let Value::Vector(both) = value else { return Ok(Vec::new()) };
    let [on, force] = both.as_slice() else { return Ok(Vec::new()) };
    // One for all that it acts on, or one for each.
    let each = if let Value::Scalar(force) = force { Some(on.map(&mut |_| *force)) } else { force.shaped(on) };
    let Some(each) = each else {
        let what = format!("the force is {}, but what it acts on is {}", force.describe(), on.describe());
        return Err(ModelError::Shape { what, span, help: None });
    };
    let (on, forces) = (on.scalars(), each.scalars());
    Ok(on.into_iter().zip(forces).map(|(on, force)| (world.pool.as_symbol(on), force)).collect())
}

/// A part that is worked out, and what comes of it beside families of terms.
struct Work<'a> {
    part: &'a Part,
    program: &'a Program,
    written_out: &'a mut WrittenOut,
    mistakes: &'a mut Vec<ModelError>,
}

/// What is left to do for an instance whose form can't be had: its mistakes, or the term written out.
fn stopped(world: &mut World, work: &mut Work<'_>, slots: &mut Vec<i64>, stop: Stop) -> Result<(), ModelError> {
    let program = work.program;
    match stop {
        Stop::Error(error) => {
            work.mistakes.push((*error).clone());
            world.find_mistakes(program, slots, work.mistakes);
            Err(*error)
        }
        Stop::WriteOut => {
            let value = world.run_written_out(program, slots)?;
            work.written_out.extend(given(world, work.part, &value, program.span)?);
            Ok(())
        }
    }
}

/// The last indices of a sum are dealt with together, where they take no more values than this.
const SHORT_INDICES: u64 = 16;

/// Runs a part for all its instances; where one has mistakes, all of these are told.
fn instantiate(world: &mut World, work: &mut Work<'_>, result: &mut Vec<TermFamily>) -> Result<(), ModelError> {
    let (part, span) = (work.part, work.program.span);
    if part.binders.is_empty() {
        let value = match world.run_written_out(work.program, &mut Vec::new()) {
            Ok(value) => value,
            Err(error) => return stopped(world, work, &mut Vec::new(), error.into()),
        };
        work.written_out.extend(given(world, part, &value, span)?);
        return Ok(());
    }
    // Stretches run along the last index that is not short.
    let is_short = |from: &usize| world.fixed_count(&part.binders[*from..]).is_some_and(|count| count <= SHORT_INDICES);
    let along = (1..part.binders.len()).find(is_short).unwrap_or(part.binders.len());
    let (outer, inner) = part.binders.split_at(along);
    let filters = part.filters.iter().map(|(after, filter)| (*after, filter));
    let (outer_filters, inner_filters): (Vec<_>, Vec<_>) = filters.partition(|(after, _)| *after <= along);
    let inner_filters: Vec<(usize, &IndexProgram)> =
        inner_filters.into_iter().map(|(after, filter)| (after - along, filter)).collect();
    world.check_room(outer, &outer_filters)?;
    let mut forms = Forms::default();
    let (mut slots, mut steps) = (Vec::new(), Vec::new());
    world.stretches::<ModelError>(outer, &outer_filters, &mut slots, span, |world, slots, most| {
        steps.clear();
        steps.resize(slots.len(), 0);
        steps.last_mut().into_iter().for_each(|last| *last = 1);
        forms.begin(most);
        if inner.is_empty() {
            forms.add(world, work, slots, &mut steps)?;
        } else {
            world.push_growth(inner, &inner_filters, &mut steps, &mut forms.current);
            world.instances(inner, &inner_filters, slots, span, |world, slots| {
                forms.add(world, work, slots, &mut steps)
            })?;
        }
        Ok(forms.push(world))
    })?;
    result.extend(forms.finishers.into_iter().map(|finisher| finisher.family));
    Ok(())
}

/// The forms of a part, and the instances that are being dealt with.
#[derive(Default)]
struct Forms {
    /// By signature, the numbers of the finishers: several where a force acts on a vector.
    numbers: HashMap<Vec<u32>, Range<usize>>,
    finishers: Vec<Finisher>,
    current: Instance,
    /// Of one value of the outer indices, with their forms.
    instances: Vec<(Range<usize>, Vec<Leaf>, Vec<i64>)>,
    /// How many of them are in use.
    used: usize,
}

impl Forms {
    /// Begins a stretch with so many further instances at most.
    fn begin(&mut self, most: u64) {
        self.used = 0;
        self.current.clear(most);
    }

    /// Adds an instance, with all that are like it.
    fn add(
        &mut self,
        world: &mut World,
        work: &mut Work<'_>,
        slots: &mut Vec<i64>,
        steps: &mut Vec<i64>,
    ) -> Result<(), ModelError> {
        let program = work.program;
        self.current.clear(self.current.reach);
        if let Err(stop) = world.run_light(program, slots, steps, &mut self.current) {
            self.current.limit(0);
            return stopped(world, work, slots, stop);
        }
        let form = if let Some(form) = self.numbers.get(&self.current.signature) {
            form.clone()
        } else {
            let mut full = Instance::default();
            let value = match world.run(program, slots, Some(&mut full)) {
                Ok(value) => value,
                Err(stop) => {
                    self.current.limit(0);
                    return stopped(world, work, slots, stop);
                }
            };
            let before = self.finishers.len();
            for (acts_on, body) in given(world, work.part, &value, program.span)? {
                self.finishers.push(Finisher::new(world, acts_on, body, program.span));
            }
            let form = before..self.finishers.len();
            self.numbers.insert(self.current.signature.clone(), form.clone());
            form
        };
        if self.instances.len() == self.used {
            self.instances.push(Default::default());
        }
        if let Some((own, leaves, steps)) = self.instances.get_mut(self.used) {
            *own = form;
            std::mem::swap(leaves, &mut self.current.leaves);
            std::mem::swap(steps, &mut self.current.steps);
        }
        self.used += 1;
        Ok(())
    }

    /// Hands over what was added, for as many instances as it holds; how many further ones these are.
    fn push(&mut self, world: &mut World) -> u64 {
        let reach = self.current.reach;
        for further in 0..=i64::try_from(reach).unwrap_or(0) {
            for (form, leaves, steps) in self.instances.iter().take(self.used) {
                for finisher in self.finishers.get_mut(form.clone()).into_iter().flatten() {
                    finisher.push(world, leaves, steps, further);
                }
            }
        }
        reach
    }
}

/// A family while its instances come in: which leaf goes where.
struct Finisher {
    family: TermFamily,
    /// For every local: the leaf, or the coordinate itself where all instances share it.
    local_sources: Vec<Source>,
    value_sources: Vec<usize>,
}

/// Slots come before what all instances share.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Source {
    Leaf(usize),
    Shared(usize),
}

impl Finisher {
    fn new(world: &World, acts_on: Option<Symbol>, body: ExprId, span: Span) -> Self {
        let mut family = TermFamily { count: 0, ..TermFamily::single(span, body, Vec::new(), Vec::new()) };
        let mut value_sources = Vec::new();
        let mut sources = BTreeSet::new();
        for symbol in world.pool.symbols_of(&[body]).into_iter().chain(acts_on) {
            match world.kinds.get(symbol) {
                Some(SymbolKind::CoordinateSlot(k) | SymbolKind::VelocitySlot(k) | SymbolKind::AccelerationSlot(k)) => {
                    sources.insert(Source::Leaf(k));
                }
                Some(SymbolKind::Coordinate(i) | SymbolKind::Velocity(i) | SymbolKind::Acceleration(i)) => {
                    sources.insert(Source::Shared(i));
                }
                Some(SymbolKind::ValueSlot(k)) => {
                    family.values.push(symbol);
                    value_sources.push(k);
                }
                Some(SymbolKind::Parameter(_) | SymbolKind::Time) | None => {}
            }
        }
        family.locals.extend(sources.iter().map(|source| match source {
            Source::Leaf(k) => Local::new(world.coordinate_slots[*k][0], world.coordinate_slots[*k][1]),
            Source::Shared(i) => Local::new(world.coordinates.at(*i).symbol, world.coordinates.at(*i).velocity),
        }));
        family.acts_on = acts_on.and_then(|on| family.locals.iter().position(|local| local.coordinate == on));
        Self { family, local_sources: sources.into_iter().collect(), value_sources }
    }

    /// Adds the instance that comes so many steps after the one with these leaves.
    fn push(&mut self, world: &mut World, leaves: &[Leaf], steps: &[i64], further: i64) {
        let moved = |number: usize, k: usize| number.wrapping_add_signed((steps[k] * further) as isize);
        for source in &self.local_sources {
            let number = match source {
                Source::Shared(number) => *number,
                Source::Leaf(k) => match leaves.get(*k) {
                    Some(Leaf::Coordinate(number)) => moved(*number, *k),
                    Some(Leaf::Parameter(_) | Leaf::Field { .. } | Leaf::Number(_)) | None => 0,
                },
            };
            self.family.coordinates.push(u32::try_from(number).unwrap_or(u32::MAX));
        }
        for k in &self.value_sources {
            let constant = match leaves.get(*k) {
                Some(Leaf::Parameter(number)) => match world.parameters.get(moved(*number, *k)) {
                    Some(parameter) => parameter.symbolic,
                    None => world.pool.zero(),
                },
                // A text was refused when the term was read.
                Some(Leaf::Field { table, row, column }) => {
                    match world.tables[*table].field(row + steps[*k] * further, *column) {
                        Some(Cell::Number(number)) => world.pool.number(number.clone()),
                        Some(Cell::Text(_)) | None => world.pool.zero(),
                    }
                }
                Some(Leaf::Number(number)) => {
                    let number = number.add(&Number::from(steps[*k] * further));
                    world.pool.number(number)
                }
                Some(Leaf::Coordinate(_)) | None => world.pool.zero(),
            };
            self.family.constants.push(constant);
        }
        self.family.count += 1;
        world.pool.hold(size_of::<u32>() * (self.local_sources.len() + self.value_sources.len()));
    }
}
