//! Statement by statement from the syntax tree to the model.

use std::cell::OnceCell;
use std::thread;

use hashbrown::{HashMap, HashSet};

use super::compile::{Compiler, Scope};
use super::coordinates::coordinate_families;
use super::names::{Entity, Key, SymbolKind, World};
use super::points::{Drawing, MOST_MEMBERS};
use super::settings::{Purpose, Settings};
use super::survey::{structural_names, tables_of_coordinates};
use super::table::{Table, TableTexts};
use super::terms::{TermFamily, families};
use super::values::{Value, sum};
use super::{Constraint, Given, Givens, Model, ModelError, dimension};
use crate::expr::{ExprId, Pool};
use crate::order::Order;
use crate::span::Span;
use crate::syntax::{ExprKind, ExprRef, File, Indices, Name, Statement, StatementKind};

/// A file of so many expressions takes long enough for a thread of its own.
const LONG_FILE: usize = 2000;

/// Checks a parsed file.
///
/// # Errors
/// All mistakes that could be told apart, each with its place.
pub fn elaborate(file: &File, tables: &TableTexts, settings: &Settings) -> Result<Model, Vec<ModelError>> {
    let mut elaborator = Elaborator::new(file, settings);
    // Dimensions need the file alone: those of a long one are worked out beside the rest.
    thread::scope(|scope| {
        let is_long = file.expressions.len() > LONG_FILE;
        let infer = || dimension::infer(file);
        let beside = is_long.then(|| thread::Builder::new().spawn_scoped(scope, infer).ok()).flatten();
        elaborator.read_settings(settings);
        elaborator.declare_all(tables);
        elaborator.check_settings(settings);
        let dimensions = || beside.and_then(|own| own.join().ok()).unwrap_or_else(infer);
        elaborator.finish(settings.purpose, dimensions)
    })
}

/// The values of the parameters and of the named expressions that are constants, whatever mistakes other statements have, and
/// the pool in which they are.
///
/// ```
/// use librate::{linearize, model, syntax};
/// let (file, _) = syntax::parse_readable("param k = 3  let q = 2*k  let = 1");
/// let (pool, values) = model::constants(&file, &Default::default(), &Default::default());
/// let values: Vec<_> = values.iter().map(|(name, e)| (name.as_str(), linearize::constant(&pool, *e).unwrap().mid_f64())).collect();
/// assert_eq!(values, [("k", 3.0), ("q", 6.0)]);
/// ```
#[must_use]
pub fn constants(file: &File, tables: &TableTexts, settings: &Settings) -> (Pool, Vec<(String, ExprId)>) {
    let mut elaborator = Elaborator::new(file, settings);
    elaborator.read_settings(settings);
    elaborator.declare_all(tables);
    let mut world = elaborator.world;
    let is_right = |family: &str| world.names.get(family).is_some_and(|(entity, _)| !world.broken.contains(entity));
    let family = |name: &str| name.split('[').next().unwrap_or_default().to_owned();
    let parameters = world.parameters.iter().filter(|own| is_right(&family(&own.name)));
    let mut values: Vec<(String, ExprId)> = parameters.filter_map(|own| Some((own.name.clone(), own.value?))).collect();
    let lets = world.lets.iter().filter(|own| is_right(&own.family.name));
    let single = lets.filter_map(|own| match own.members.get(&[0; 3]) {
        Some(Value::Scalar(value)) if own.family.grid.rank == 0 => Some((own.family.name.clone(), *value)),
        _ => None,
    });
    let single: Vec<(String, ExprId)> = single.collect();
    for (name, value) in single {
        if world.varying_symbol(value).is_none() {
            values.extend(world.closed(value).map(|value| (name, value)));
        }
    }
    (world.pool, values)
}

/// The number of coordinates of a parsed file, from its declarations alone: long before
/// [`elaborate`] is through where there are many, and without looking at energies.
///
/// What has a mistake counts nothing; `elaborate` tells it.
///
/// ```
/// use librate::{model, syntax};
/// let file = syntax::parse("param N = 1000000  coord x[1..N, 1..3]  T = 1/2*x[1,1]'^2")?;
/// assert_eq!(model::coordinate_count(&file, &Default::default(), &Default::default()), 3000000);
/// # Ok::<(), Vec<librate::syntax::SyntaxError>>(())
/// ```
#[must_use]
pub fn coordinate_count(file: &File, tables: &TableTexts, settings: &Settings) -> usize {
    let mut elaborator = Elaborator::new(file, settings);
    elaborator.read_settings(settings);
    let mut wanted = elaborator.structural.clone();
    wanted.extend(tables_of_coordinates(file));
    let mut count = 0_usize;
    for statement in &file.statements {
        for binding in statement.kind.parameters().iter().filter(|one| wanted.contains(one.name.text.as_str())) {
            elaborator.parameter(binding);
        }
        if let StatementKind::Table { name, .. } = &statement.kind
            && wanted.contains(name.text.as_str())
        {
            elaborator.declare(&statement.kind, statement.span, tables);
        }
        for one in statement.kind.coordinates() {
            let members = elaborator.members(one.indices.as_deref(), &one.name);
            count = count.saturating_add(members.map_or(0, |members| members.count()));
        }
    }
    count
}

/// The statements that are worked on after all declarations.
#[derive(Default)]
struct Energies {
    kinetic: Option<(ExprRef, Span)>,
    potential: Option<(ExprRef, Span)>,
    lagrangian: Option<(ExprRef, Span)>,
    dissipation: Option<(ExprRef, Span)>,
    period: Option<(ExprRef, Span)>,
}

/// A value from `--set`, and whether a parameter took it.
pub(super) struct SetValue {
    pub(super) value: Value,
    /// Its uncertainty.
    pub(super) sigma: Option<Value>,
    pub(super) used: bool,
    /// As it was written.
    pub(super) text: String,
}

pub(super) struct Elaborator<'a> {
    pub(super) file: &'a File,
    pub(super) world: World,
    pub(super) errors: Vec<ModelError>,
    pub(super) later: OnceCell<HashMap<String, Span>>,
    pub(super) structural: HashSet<String>,
    /// By name, and by member where one is set.
    pub(super) set: HashMap<(String, Option<Key>), SetValue>,
    model_name: Option<(String, Span)>,
    energies: Energies,
    pub(super) has_units: bool,
    /// How often something was left out because of an earlier mistake.
    follow_ons: usize,
}

impl<'a> Elaborator<'a> {
    fn new(file: &'a File, settings: &Settings) -> Self {
        let budget = settings.budget.clone().unwrap_or_default();
        Self {
            file,
            world: World { pool: Pool::within(budget), ..World::default() },
            errors: Vec::new(),
            later: OnceCell::new(),
            structural: structural_names(file),
            set: HashMap::new(),
            model_name: None,
            energies: Energies::default(),
            has_units: false,
            follow_ons: 0,
        }
    }

    pub(super) fn compiler(&mut self) -> Compiler<'_> {
        Compiler::new(self.file, &mut self.world, &self.later, &mut self.errors)
    }

    /// Reports a mistake in place of what it keeps from being made.
    pub(super) fn refuse<T>(&mut self, error: ModelError) -> Option<T> {
        self.errors.push(error);
        None
    }

    pub(super) fn note<T>(&mut self, result: Result<T, ModelError>) -> Option<T> {
        match result {
            Ok(value) => Some(value),
            Err(ModelError::FollowOn {}) => {
                self.follow_ons += 1;
                None
            }
            Err(error) => self.refuse(error),
        }
    }

    fn declare_all(&mut self, tables: &TableTexts) {
        let file = self.file;
        for statement in &file.statements {
            self.begin(&statement.kind, statement.span);
            let before = (self.errors.len(), self.follow_ons);
            self.declare(&statement.kind, statement.span, tables);
            if before != (self.errors.len(), self.follow_ons) {
                self.mark_broken(&statement.kind);
            }
        }
    }

    /// Tells the budget which statement is being worked on.
    fn begin(&self, kind: &StatementKind, span: Span) {
        let what =
            kind.declared().next().map_or_else(|| "this statement".to_owned(), |first| format!("`{}`", first.text));
        self.world.pool.budget().at(what, Some(span));
    }

    fn declare(&mut self, kind: &StatementKind, span: Span, tables: &TableTexts) {
        let energies = &mut self.energies;
        match kind {
            StatementKind::Model { name } => {
                let first = self.file.statements.first().map_or(span, |own| own.span);
                if first.start < span.start && self.model_name.is_none() {
                    let name = name.text.to_string();
                    self.errors.push(ModelError::MisplacedModel { name, first, span });
                }
                once(&mut self.model_name, name.text.to_string(), span, "model", &mut self.errors);
            }
            StatementKind::Param(bindings) => bindings.iter().for_each(|binding| self.parameter(binding)),
            StatementKind::Coord { declarations } => declarations.iter().for_each(|one| self.coordinate(one)),
            StatementKind::Let(binding) => self.named_expression(binding),
            StatementKind::Kinetic(at) => once(&mut energies.kinetic, *at, span, "T", &mut self.errors),
            StatementKind::Potential(at) => once(&mut energies.potential, *at, span, "V", &mut self.errors),
            StatementKind::Lagrangian(at) => once(&mut energies.lagrangian, *at, span, "lagrangian", &mut self.errors),
            StatementKind::Dissipation(at) => {
                once(&mut energies.dissipation, *at, span, "dissipation", &mut self.errors);
            }
            StatementKind::Period(at) => once(&mut energies.period, *at, span, "period", &mut self.errors),
            StatementKind::Table { name, path, path_span } => {
                let table = Table::read(&name.text, path, name.span, *path_span, tables);
                // A table that can't be read is declared all the same, lest every use of it err.
                let table = table.unwrap_or_else(|error| {
                    self.errors.push(error);
                    Table::unread(&name.text, name.span)
                });
                let number = self.world.tables.len();
                if self.introduce(name, Entity::Table(number)) {
                    self.world.tables.push(table);
                }
            }
            StatementKind::Assume(relations) => {
                for at in relations {
                    let found = self.assumption(*at);
                    for own in found.unwrap_or_default() {
                        self.errors.extend(self.world.assumed_before(&own));
                        self.world.assumptions.push(own);
                    }
                }
            }
            // These need all coordinates and are read at the end.
            StatementKind::Force(_)
            | StatementKind::Constraint { .. }
            | StatementKind::Draw { .. }
            | StatementKind::Guess { .. }
            | StatementKind::Equilibrium { .. } => {}
        }
    }

    /// What a statement with a mistake declares is broken.
    fn mark_broken(&mut self, kind: &StatementKind) {
        for name in kind.declared() {
            if let Some((entity, _)) = self.world.names.get(name.text.as_str()) {
                self.world.broken.insert(*entity);
            }
        }
    }

    /// Declares a new name.
    pub(super) fn introduce(&mut self, name: &Name, entity: Entity) -> bool {
        if let Some((_, first)) = self.world.names.get(name.text.as_str()) {
            let (text, span, first) = (name.text.to_string(), name.span, *first);
            self.errors.push(ModelError::GivenTwice { name: text, help: None, span, first });
            return false;
        }
        self.world.names.insert(name.text.to_string(), (entity, name.span));
        true
    }

    fn energy(&mut self, statement: Option<(ExprRef, Span)>, name: &'static str) -> Vec<TermFamily> {
        let Some((root, _)) = statement else { return Vec::new() };
        let span = self.file.expr(root).span;
        self.world.pool.budget().at(name, Some(span));
        let families = families(&mut self.compiler(), root);
        let families = self.note(families).unwrap_or_default();
        self.check_accelerations(&families, root, name);
        families
    }

    /// Refuses accelerations in energies and forces.
    pub(super) fn check_accelerations(&mut self, families: &[TermFamily], root: ExprRef, name: &'static str) {
        let bodies: Vec<ExprId> = families.iter().map(|family| family.body).collect();
        let symbols = self.world.pool.symbols_of(&bodies);
        if symbols.into_iter().filter_map(|symbol| self.world.kinds.get(symbol)).any(SymbolKind::is_acceleration) {
            let span = self.acceleration_place(root);
            self.errors.push(ModelError::Acceleration { energy: name, span });
        }
    }

    /// The first `''`, or the whole energy where the acceleration comes from a named expression.
    fn acceleration_place(&self, root: ExprRef) -> Span {
        let mut todo = vec![root];
        while let Some(at) = todo.pop() {
            if let ExprKind::Prime(inner) = &self.file.expr(at).kind
                && let ExprKind::Prime(_) = &self.file.expr(*inner).kind
            {
                return self.file.expr(at).span;
            }
            self.file.children(at, &mut todo);
        }
        self.file.expr(root).span
    }

    /// What a `constraint` sets to zero, left less right, a member at a time and of vectors a component at a time. Members
    /// are written out.
    fn constraint(&mut self, sides: [ExprRef; 2], indices: Option<&Indices>, span: Span) -> Option<Vec<Constraint>> {
        let name = Name { text: "constraint".into(), span };
        let members = self.members(indices, &name)?;
        let programs = self.compiled(&sides, &members.scope)?;
        let mut found = Vec::new();
        for at in members.keys() {
            // 0 is one of any shape.
            let mut value = |program| match self.value_of(program, &at[..members.rank])? {
                Value::Scalar(e) if e.is_zero() => Some(Value::Zero),
                value => Some(value),
            };
            let [left, right] = [value(&programs[0])?, value(&programs[1])?];
            let Ok(difference) = sum(&mut self.world.pool, &[(false, left.clone()), (true, right.clone())]) else {
                let shapes = format!("{} and {}", left.describe(), right.describe());
                let what = format!("the sides of a constraint must have the same shape, but are {shapes}");
                return self.refuse(ModelError::shape((what, None), span));
            };
            let mut components = difference.scalars();
            // Of vectors in a plane one component may say 0 = 0.
            if components.iter().any(|one| !one.is_zero()) {
                components.retain(|one| !one.is_zero());
            }
            for expression in components {
                if let Some(on) = self.not_linear(expression) {
                    return self.refuse(ModelError::ConstraintNotLinear { on, span });
                }
                found.push(Constraint { expression, span });
            }
        }
        Some(found)
    }

    /// The first acceleration in an expression, or velocity that it is not linear in, by name.
    fn not_linear(&mut self, e: ExprId) -> Option<String> {
        let World { pool, kinds, coordinates, .. } = &mut self.world;
        let moves = |symbol| matches!(kinds.get(symbol), Some(SymbolKind::Velocity(_)));
        pool.symbols_of(&[e]).into_iter().find_map(|symbol| match kinds.get(symbol)? {
            SymbolKind::Velocity(number) => {
                let slope = pool.diff(e, symbol);
                let bends = pool.slopes(slope, moves);
                let bent = bends.iter().any(|(_, bend)| !pool.vanishes(*bend));
                bent.then(|| format!("{}'", coordinates.at(number).name()))
            }
            SymbolKind::Acceleration(number) => Some(format!("{}''", coordinates.at(number).name())),
            _ => None,
        })
    }

    /// Whether a constraint is one on velocities.
    fn rolls(&self, constraint: &Constraint) -> bool {
        let moves = |symbol| matches!(self.world.kinds.get(symbol), Some(SymbolKind::Velocity(_)));
        self.world.pool.depends_on(constraint.expression, &moves)
    }

    fn finish(
        mut self,
        purpose: Purpose,
        dimensions: impl FnOnce() -> dimension::Dimensions,
    ) -> Result<Model, Vec<ModelError>> {
        let count = self.world.coordinates.len();
        let [mut guesses, mut guessed_velocities, mut equilibria, mut rates] = [(); 4].map(|()| Givens::none(count));
        let mut constraints = Vec::new();
        let (mut forces, mut acted, mut first_force) = (Vec::new(), HashMap::new(), None);
        // Those that declare nothing.
        for statement in self.file.statements.iter().filter(|own| own.kind.declared().next().is_none()) {
            self.begin(&statement.kind, statement.span);
            let (what, into, binding) = match &statement.kind {
                StatementKind::Guess { binding, rate: true } => {
                    ("the guessed velocity", &mut guessed_velocities, binding)
                }
                StatementKind::Guess { binding, rate: false } => ("the guess", &mut guesses, binding),
                StatementKind::Equilibrium { binding, rate: true } => ("the rate", &mut rates, binding),
                StatementKind::Equilibrium { binding, rate: false } => ("the equilibrium", &mut equilibria, binding),
                StatementKind::Force(binding) => {
                    first_force = first_force.or(Some(statement.span));
                    forces.extend(self.force(binding, &mut acted).unwrap_or_default());
                    continue;
                }
                StatementKind::Constraint { indices, left, right } => {
                    let found = self.constraint([*left, *right], indices.as_deref(), statement.span);
                    constraints.extend(found.unwrap_or_default());
                    continue;
                }
                _ => continue,
            };
            self.given(binding, what, into);
        }
        let energies = std::mem::take(&mut self.energies);
        if let (Some((_, span)), Some((_, energy))) = (energies.lagrangian, energies.kinetic.or(energies.potential)) {
            self.errors.push(ModelError::LagrangianBesideEnergies { span, energy });
        } else if purpose != Purpose::Tensors && energies.kinetic.is_none() && energies.lagrangian.is_none() {
            self.errors.push(ModelError::MissingKinetic {});
        }
        let empty = self.world.coordinate_families.first().map(|family| family.span);
        let declares = |own: &Statement| matches!(own.kind, StatementKind::Coord { .. });
        let may_be_meant = !self.errors.is_empty() && self.file.statements.iter().any(declares);
        if purpose != Purpose::Tensors && count == 0 && !may_be_meant {
            self.errors.push(ModelError::NoCoordinates { empty });
        }
        let mut kinetic = self.energy(energies.kinetic, "T");
        let mut potential = self.energy(energies.potential, "V");
        let mut lagrangian = self.energy(energies.lagrangian, "lagrangian");
        forces.extend(self.energy(energies.dissipation, "dissipation"));
        let period = energies.period.and_then(|(root, span)| self.period(root, span));
        // Behind the energies, whose parts stand in the order in which they are met.
        let drawing = self.drawing(purpose);
        let dimensions = dimensions();
        self.errors.extend(dimensions.errors.iter().cloned().map(ModelError::from));
        // Whatever else there is to say may only follow from it.
        if let Err(exceeded) = self.world.pool.budget().check() {
            return Err(vec![exceeded.into()]);
        }
        if !self.errors.is_empty() {
            return Err(tidy(self.errors));
        }
        self.world.coordinates.set_units(&dimensions);
        self.drop_time([&mut kinetic, &mut potential, &mut lagrangian], &mut forces);
        let time_dependent = self.time_dependence(&[&kinetic, &potential, &lagrangian, &forces], &constraints);
        let (rolling, constraints): (Vec<_>, Vec<_>) = constraints.into_iter().partition(|own| self.rolls(own));
        let tensors = self.tensors(purpose == Purpose::Tensors, &dimensions);
        let unnamed_tensors = self.unnamed_tensors();
        let points = if purpose == Purpose::Picture && drawing.is_none() { self.points() } else { Vec::new() };
        Ok(Model {
            name: self.model_name.map(|(name, _)| name),
            families: self.world.coordinate_families.iter().flat_map(coordinate_families).collect(),
            coordinates: self.world.coordinates,
            parameters: self.world.parameters,
            named: self.world.lets.iter().map(|own| own.family.name.clone()).collect(),
            symbols: self.world.kinds,
            kinetic: if energies.lagrangian.is_some() { lagrangian } else { kinetic },
            potential,
            lagrangian: energies.lagrangian.is_some(),
            guesses,
            guessed_velocities,
            equilibria,
            rates,
            dissipation: energies.dissipation.map(|(_, span)| span),
            force: first_force,
            forces,
            constraints,
            assumptions: self.world.assumptions,
            rolling,
            redundant: Vec::new(),
            follow: Vec::new(),
            period,
            time_dependent,
            tensors,
            unnamed_tensors,
            points,
            drawing,
            has_units: self.has_units,
            pool: self.world.pool,
        })
    }

    /// What `draw` statements say, if there are any.
    fn drawing(&mut self, purpose: Purpose) -> Option<Drawing> {
        let mut drawing = None;
        for statement in &self.file.statements {
            if let StatementKind::Draw { drawn, indices, points } = &statement.kind {
                self.begin(&statement.kind, statement.span);
                let most = if purpose == Purpose::Picture { MOST_MEMBERS } else { 1 };
                let drawing = drawing.get_or_insert_default();
                self.draw((drawing, most), *drawn, (indices.as_deref(), points), statement.span);
            }
        }
        drawing
    }

    fn period(&mut self, root: ExprRef, span: Span) -> Option<Given> {
        let program = self.compiler().value(root, &mut Scope::default());
        let symbolic = self.number_of(&program, &[], "the period")?;
        if let Some(on) = self.world.varying_symbol(symbolic) {
            self.errors.push(ModelError::NotConstant { what: "the period".to_owned(), on, span: program.span });
        }
        let value = self.world.closed(symbolic);
        Some(Given { symbolic, value, span })
    }
}

/// Fills something that a model has once.
fn once<T>(slot: &mut Option<(T, Span)>, value: T, span: Span, what: &'static str, errors: &mut Vec<ModelError>) {
    match slot {
        Some((_, first)) => errors.push(ModelError::SecondStatement { what, span, first: *first }),
        None => *slot = Some((value, span)),
    }
}

/// In the order of the file, each once.
fn tidy(errors: Vec<ModelError>) -> Vec<ModelError> {
    let place = |error: &ModelError| {
        crate::diagnostic::Diagnostic::from(error).primary.map_or(Span::new(u32::MAX, u32::MAX), |label| label.span)
    };
    let mut errors: Vec<(Span, ModelError)> = errors.into_iter().map(|error| (place(&error), error)).collect();
    errors.order_by_key(|(place, _)| *place);
    let mut seen: Vec<(Span, ModelError)> = Vec::new();
    let mut without_value: HashSet<String> = HashSet::new();
    // What is said of the first coordinate that is missing is enough.
    let missing = |error: &ModelError| matches!(error, ModelError::UndeclaredName { coordinate: Some(_), .. });
    if errors.iter().any(|(_, error)| missing(error)) {
        errors.retain(|(_, error)| !matches!(error, ModelError::NoCoordinates { .. }));
    }
    for (place, error) in errors {
        // A parameter without a value lacks it wherever it is used.
        let is_new = !matches!(&error, ModelError::MissingValue { name, .. } if !without_value.insert(name.clone()));
        let mut beside = seen.iter().rev().take_while(|(other, _)| *other == place);
        if is_new && !beside.any(|(_, other)| *other == error) {
            seen.push((place, error));
        }
    }
    seen.into_iter().map(|(_, error)| error).collect()
}
