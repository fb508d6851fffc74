//! Statement by statement from the syntax tree to the model.

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use super::compile::{Compiler, Scope};
use super::names::{
    Block, Coordinate, Entity, Family, Key, LetFamily, LetPiece, Parameter, SymbolKind, World, key,
    member_name,
};
use super::program::{Binder, BinderKind, IndexForm, IndexOp, IndexProgram, Op, Program};
use super::run::DEEPEST_LET;
use super::settings::Settings;
use super::table::{Table, TableTexts};
use super::terms::{TermFamily, families, is_additive};
use super::values::Value;
use super::{Given, Model, ModelError, units};
use crate::diagnostic::nearest;
use crate::expr::{ExprId, Substitution};
use crate::span::Span;
use crate::syntax::{
    Binding, Declaration, ExprKind, ExprRef, File, IndexKind, Indices, Name, StatementKind, UnitRef,
};

/// More members than this in one family are refused.
const MOST_MEMBERS: usize = 20_000_000;

pub(super) fn elaborate(
    file: &File,
    tables: &TableTexts,
    settings: &Settings,
) -> Result<Model, Vec<ModelError>> {
    let mut elaborator = Elaborator {
        file,
        world: World::default(),
        errors: Vec::new(),
        later: declared_names(file),
        structural: structural_names(file),
        set: HashMap::new(),
        model_name: None,
        energies: Energies::default(),
        has_units: false,
    };
    elaborator.read_settings(settings);
    for statement in &file.statements {
        elaborator.declare(&statement.kind, statement.span, tables);
    }
    elaborator.check_settings(settings);
    elaborator.finish()
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
struct SetValue {
    value: Value,
    used: bool,
}

struct Elaborator<'a> {
    file: &'a File,
    world: World,
    errors: Vec<ModelError>,
    later: HashMap<String, Span>,
    structural: HashSet<String>,
    /// By name, and by member where one is set.
    set: HashMap<(String, Option<Key>), SetValue>,
    model_name: Option<(String, Span)>,
    energies: Energies,
    has_units: bool,
}

/// Where every name is declared first.
fn declared_names(file: &File) -> HashMap<String, Span> {
    let mut names = HashMap::new();
    let mut add = |name: &Name| {
        names.entry(name.text.clone()).or_insert(name.span);
    };
    for statement in &file.statements {
        match &statement.kind {
            StatementKind::Param(binding) | StatementKind::Let(binding) => add(&binding.name),
            StatementKind::Coord { declarations } => {
                declarations.iter().for_each(|one| add(&one.name));
            }
            StatementKind::Table { name, .. } => add(name),
            StatementKind::Model { .. }
            | StatementKind::Kinetic(_)
            | StatementKind::Potential(_)
            | StatementKind::Lagrangian(_)
            | StatementKind::Dissipation(_)
            | StatementKind::Constraint { .. }
            | StatementKind::Guess(_)
            | StatementKind::Equilibrium { .. }
            | StatementKind::Period(_) => {}
        }
    }
    names
}

/// The names that set ranges, indices and filters, directly or through other parameters.
fn structural_names(file: &File) -> HashSet<String> {
    let mut todo: Vec<ExprRef> = Vec::new();
    let add = |indices: &Indices, todo: &mut Vec<ExprRef>| {
        for entry in &indices.entries {
            match &entry.kind {
                IndexKind::Member(at) => todo.push(*at),
                IndexKind::Range { from, to, .. } => todo.extend([*from, *to]),
                IndexKind::Rows { .. } => {}
            }
        }
        todo.extend(indices.filter);
    };
    for expr in &file.expressions {
        match &expr.kind {
            ExprKind::SumOver { indices, .. } => add(indices, &mut todo),
            ExprKind::Index { indices, .. } => todo.extend(indices),
            ExprKind::Call {
                function,
                arguments,
            } if matches!(function.text.as_str(), "mod" | "floor") => todo.extend(arguments),
            ExprKind::Number(_)
            | ExprKind::Name(_)
            | ExprKind::Field { .. }
            | ExprKind::Prime(_)
            | ExprKind::Negate(_)
            | ExprKind::Power { .. }
            | ExprKind::Product(_)
            | ExprKind::Sum(_)
            | ExprKind::Call { .. }
            | ExprKind::Vector(_)
            | ExprKind::Compare { .. }
            | ExprKind::Not(_)
            | ExprKind::And(_)
            | ExprKind::Or(_) => {}
        }
    }
    let mut definitions: HashMap<&str, Vec<ExprRef>> = HashMap::new();
    for statement in &file.statements {
        match &statement.kind {
            StatementKind::Param(binding) => {
                if let Some(indices) = &binding.indices {
                    add(indices, &mut todo);
                }
                if let Some(value) = binding.value {
                    definitions.entry(&binding.name.text).or_default().push(value);
                }
            }
            StatementKind::Let(binding)
            | StatementKind::Guess(binding)
            | StatementKind::Equilibrium { binding, .. } => {
                if let Some(indices) = &binding.indices {
                    add(indices, &mut todo);
                }
            }
            StatementKind::Coord { declarations } => {
                for one in declarations {
                    if let Some(indices) = &one.indices {
                        add(indices, &mut todo);
                    }
                }
            }
            StatementKind::Constraint { indices, .. } => {
                if let Some(indices) = indices {
                    add(indices, &mut todo);
                }
            }
            StatementKind::Model { .. }
            | StatementKind::Kinetic(_)
            | StatementKind::Potential(_)
            | StatementKind::Lagrangian(_)
            | StatementKind::Dissipation(_)
            | StatementKind::Period(_)
            | StatementKind::Table { .. } => {}
        }
    }
    let mut names = HashSet::new();
    while let Some(at) = todo.pop() {
        if let ExprKind::Name(name) = &file.expr(at).kind
            && !names.contains(name)
        {
            names.insert(name.clone());
            todo.extend(definitions.get(name.as_str()).into_iter().flatten());
        }
        children(file, at, &mut todo);
    }
    names
}

/// The expressions directly below one, those of indices included.
fn children(file: &File, at: ExprRef, out: &mut Vec<ExprRef>) {
    match &file.expr(at).kind {
        ExprKind::Number(_) | ExprKind::Name(_) => {}
        ExprKind::Index { base, indices } => {
            out.push(*base);
            out.extend(indices);
        }
        ExprKind::Field { base, .. } => out.push(*base),
        ExprKind::Prime(inner) | ExprKind::Negate(inner) | ExprKind::Not(inner) => out.push(*inner),
        ExprKind::Power { base, exponent } => out.extend([*base, *exponent]),
        ExprKind::Product(factors) => out.extend(factors.iter().map(|factor| factor.value)),
        ExprKind::Sum(terms) => out.extend(terms.iter().map(|term| term.value)),
        ExprKind::Call { arguments, .. } => out.extend(arguments),
        ExprKind::SumOver { indices, body } => {
            for entry in &indices.entries {
                match &entry.kind {
                    IndexKind::Member(at) => out.push(*at),
                    IndexKind::Range { from, to, .. } => out.extend([*from, *to]),
                    IndexKind::Rows { .. } => {}
                }
            }
            out.extend(indices.filter);
            out.push(*body);
        }
        ExprKind::Vector(parts) | ExprKind::And(parts) | ExprKind::Or(parts) => out.extend(parts),
        ExprKind::Compare { left, right, .. } => out.extend([*left, *right]),
    }
}

impl IndexProgram {
    /// Whether it depends on index variables.
    fn varies(&self) -> bool {
        match &self.form {
            IndexForm::Constant(_) => false,
            IndexForm::Shifted { .. } | IndexForm::RowField { .. } => true,
            IndexForm::General(ops) => ops
                .iter()
                .any(|(op, _)| matches!(op, IndexOp::Variable(_))),
        }
    }
}

/// The indices of a binding, compiled: where the members are.
struct Members {
    rank: usize,
    /// A full box, or the members one by one.
    block: Option<Block>,
    keys: Vec<Key>,
    filter: Option<IndexProgram>,
    scope: Scope,
    /// Whether the right side may name an index.
    named: bool,
    span: Span,
}

impl<'a> Elaborator<'a> {
    fn compiler(&mut self) -> Compiler<'_> {
        Compiler {
            file: self.file,
            world: &mut self.world,
            later: &self.later,
            errors: &mut self.errors,
            depth: 0,
            recursive: false,
            current_let: None,
        }
    }

    fn note<T>(&mut self, result: Result<T, ModelError>) -> Option<T> {
        result.map_err(|error| self.errors.push(error)).ok()
    }

    fn read_settings(&mut self, settings: &Settings) {
        for setting in &settings.entries {
            let mut errors = Vec::new();
            let later = HashMap::new();
            let mut compiler = Compiler {
                file: &setting.file,
                world: &mut self.world,
                later: &later,
                errors: &mut errors,
                depth: 0,
                recursive: false,
                current_let: None,
            };
            let mut at = Vec::new();
            if let Some(indices) = &setting.binding.indices {
                let (binders, _) = compiler.binders(indices, &mut Scope::default());
                for binder in &binders {
                    match compiler.world.binder_range(binder, &[]) {
                        Ok((from, to)) if from == to => at.push(from),
                        Ok(_) | Err(_) => compiler.errors.push(ModelError::BadSetting {
                            text: setting.text.clone(),
                            reason: "one member is set at a time".to_owned(),
                        }),
                    }
                }
            }
            let value = setting.binding.value.map(|value| {
                let program = compiler.value(value, &mut Scope::default());
                compiler.world.run_written_out(&program, &mut Vec::new())
            });
            let reason = match (errors.first(), value) {
                (Some(error), _) => error.to_string(),
                (None, Some(Err(error))) => error.to_string(),
                (None, Some(Ok(value))) => {
                    let member = setting.binding.indices.as_ref().map(|_| key(&at));
                    let name = setting.binding.name.text.clone();
                    let set = SetValue {
                        value,
                        used: false,
                    };
                    self.set.insert((name, member), set);
                    continue;
                }
                (None, None) => "there is no value".to_owned(),
            };
            self.errors.push(ModelError::BadSetting {
                text: setting.text.clone(),
                reason,
            });
        }
    }

    fn check_settings(&mut self, settings: &Settings) {
        for setting in &settings.entries {
            let name = &setting.binding.name.text;
            let unused = self
                .set
                .iter()
                .any(|((own, _), value)| own == name && !value.used);
            if !unused {
                continue;
            }
            let mut known: Vec<&str> = self
                .world
                .parameters
                .iter()
                .map(|parameter| parameter.name.as_str())
                .collect();
            known.extend(self.world.parameter_families.iter().map(|f| f.name.as_str()));
            let shown = setting
                .text
                .split_once('=')
                .map_or(name.as_str(), |(left, _)| left.trim());
            let nearest = nearest(shown, known).map(str::to_owned);
            self.errors.push(ModelError::UnknownSetting {
                name: shown.to_owned(),
                nearest,
            });
        }
    }

    fn declare(&mut self, kind: &StatementKind, span: Span, tables: &TableTexts) {
        match kind {
            StatementKind::Model { name } => {
                self.once(&mut |e| &mut e.model_name, name.text.clone(), span, "model");
            }
            StatementKind::Param(binding) => self.parameter(binding),
            StatementKind::Coord { declarations } => {
                for one in declarations {
                    self.coordinate(one);
                }
            }
            StatementKind::Let(binding) => self.named_expression(binding),
            StatementKind::Kinetic(at) => {
                self.once(&mut |e| &mut e.energies.kinetic, *at, span, "T");
            }
            StatementKind::Potential(at) => {
                self.once(&mut |e| &mut e.energies.potential, *at, span, "V");
            }
            StatementKind::Lagrangian(at) => {
                self.once(&mut |e| &mut e.energies.lagrangian, *at, span, "lagrangian");
            }
            StatementKind::Dissipation(at) => {
                self.once(&mut |e| &mut e.energies.dissipation, *at, span, "dissipation");
            }
            StatementKind::Period(at) => {
                self.once(&mut |e| &mut e.energies.period, *at, span, "period");
            }
            StatementKind::Table {
                name,
                path,
                path_span,
            } => {
                let table = Table::read(&name.text, path, name.span, *path_span, tables);
                // A table that can't be read is declared all the same, lest every use of it err.
                match table {
                    Ok(table) => {
                        let number = self.world.tables.len();
                        if self.introduce(name, Entity::Table(number)) {
                            self.world.tables.push(table);
                        }
                    }
                    Err(error) => {
                        self.errors.push(error);
                        self.later.remove(&name.text);
                    }
                }
            }
            // These need all coordinates and are read at the end.
            StatementKind::Constraint { .. }
            | StatementKind::Guess(_)
            | StatementKind::Equilibrium { .. } => {}
        }
    }

    /// Fills something that a model has once.
    fn once<T>(
        &mut self,
        field: &mut dyn FnMut(&mut Self) -> &mut Option<(T, Span)>,
        value: T,
        span: Span,
        what: &'static str,
    ) {
        let slot = field(self);
        if let Some((_, first)) = slot {
            let first = *first;
            self.errors.push(ModelError::SecondStatement { what, span, first });
        } else {
            *slot = Some((value, span));
        }
    }

    /// Declares a new name.
    fn introduce(&mut self, name: &Name, entity: Entity) -> bool {
        if let Some((_, first)) = self.world.names.get(&name.text) {
            let first = *first;
            self.errors.push(ModelError::GivenTwice {
                name: name.text.clone(),
                span: name.span,
                first,
            });
            return false;
        }
        self.world
            .names
            .insert(name.text.clone(), (entity, name.span));
        true
    }

    /// Compiles the indices of a binding and finds its members.
    fn members(&mut self, indices: Option<&Indices>, name: &Name) -> Option<Members> {
        let before = self.errors.len();
        let mut scope = Scope::default();
        let Some(indices) = indices else {
            return Some(Members {
                rank: 0,
                block: None,
                keys: vec![[0; 3]],
                filter: None,
                scope,
                named: false,
                span: name.span,
            });
        };
        let rank = indices.entries.len();
        if rank > 3 {
            self.errors.push(ModelError::BadIndices {
                what: "a family has at most three indices".to_owned(),
                span: indices.span,
            });
            return None;
        }
        let (binders, filter) = self.compiler().binders(indices, &mut scope);
        if self.errors.len() > before {
            return None;
        }
        let named = scope.variables.iter().any(|(name, _)| !name.is_empty());
        let mut members = Members {
            rank,
            block: None,
            keys: Vec::new(),
            filter,
            scope,
            named,
            span: name.span.to(indices.span),
        };
        let single = indices
            .entries
            .iter()
            .all(|entry| matches!(entry.kind, IndexKind::Member(_)));
        let rectangular = binders.iter().all(|binder| match &binder.kind {
            BinderKind::Range { from, to } => !from.varies() && !to.varies(),
            BinderKind::Rows(_) => true,
        });
        if rectangular && !single {
            let block = self.block(&binders, members.span)?;
            if members.filter.is_none() {
                members.block = Some(block);
                return Some(members);
            }
        }
        let filters: Vec<(usize, &IndexProgram)> = members
            .filter
            .iter()
            .map(|filter| (rank, filter))
            .collect();
        let mut keys = Vec::new();
        let found = self.world.instances::<ModelError>(
            &binders,
            &filters,
            &mut Vec::new(),
            members.span,
            |_, slots| {
                keys.push(key(slots));
                Ok(())
            },
        );
        self.note(found)?;
        members.keys = keys;
        Some(members)
    }

    fn block(&mut self, binders: &[Binder], span: Span) -> Option<Block> {
        let mut block = Block {
            lower: [0; 3],
            upper: [0; 3],
            base: 0,
            span,
        };
        for (axis, binder) in binders.iter().enumerate() {
            let range = self.world.binder_range(binder, &[]);
            let (from, to) = self.note(range)?;
            block.lower[axis] = from;
            block.upper[axis] = to.max(from - 1);
        }
        let count = (0..binders.len()).try_fold(1_usize, |count, axis| {
            count.checked_mul(block.extent(axis))
        });
        if count.is_none_or(|count| count > MOST_MEMBERS) {
            self.errors.push(ModelError::TooLarge {
                count: format!("more than {MOST_MEMBERS} members"),
                span,
            });
            return None;
        }
        Some(block)
    }

    /// The factor of a unit where the right side is in that unit: where it names no quantity.
    fn unit_factor(&mut self, unit: Option<UnitRef>, program: &Program) -> Option<ExprId> {
        let unit = unit?;
        self.has_units = true;
        let factor = units::factor(&mut self.world.pool, self.file, unit, &mut self.errors);
        (!reads_names(program)).then_some(factor)
    }

    fn parameter(&mut self, binding: &Binding) {
        let name = &binding.name;
        let known = self.world.names.get(&name.text).copied();
        let family = match known {
            Some((Entity::Parameter(family), _))
                if binding.indices.is_some()
                    && self.world.parameter_families[family].grid.rank > 0 =>
            {
                family
            }
            Some((_, first)) => {
                self.errors.push(ModelError::GivenTwice {
                    name: name.text.clone(),
                    span: name.span,
                    first,
                });
                return;
            }
            None => {
                let family = self.world.parameter_families.len();
                self.world.parameter_families.push(Family {
                    name: name.text.clone(),
                    span: name.span,
                    grid: super::names::Grid {
                        rank: binding.indices.as_ref().map_or(0, |i| i.entries.len().min(3)),
                        ..Default::default()
                    },
                });
                family
            }
        };
        let members = self.members(binding.indices.as_ref(), name);
        let mut scope = members
            .as_ref()
            .map_or_else(Scope::default, |members| members.scope.clone());
        let program = binding
            .value
            .map(|value| self.compiler().value(value, &mut scope));
        let uncertainty = binding
            .uncertainty
            .map(|value| self.compiler().value(value, &mut scope));
        self.introduce_family(name, Entity::Parameter(family), known.is_some());
        let factor = match &program {
            Some(program) => self.unit_factor(binding.unit, program),
            None => {
                let nothing = Program::default();
                self.unit_factor(binding.unit, &nothing)
            }
        };
        let Some(members) = members else { return };
        let Some(keys) = self.add_members(family, &members, name) else {
            return;
        };
        // One value fills the family; a list gives the members; an index makes each its own.
        let mut shared: Option<Value> = None;
        if let Some(program) = &program
            && !members.named
        {
            let mut slots = keys
                .first()
                .map_or_else(Vec::new, |at| at[..members.rank].to_vec());
            let value = self.world.run_written_out(program, &mut slots);
            let Some(value) = self.note(value) else { return };
            shared = Some(value);
        }
        let sigma = uncertainty.and_then(|program| {
            let value = self.world.run_written_out(&program, &mut Vec::new());
            let value = self.note(value)?;
            let value = self.one_scalar(&value, "an uncertainty", program.span)?;
            self.scaled(value, factor)
        });
        let list: Option<Vec<ExprId>> = match &shared {
            Some(value @ Value::Vector(_)) => {
                let scalars = value.scalars();
                if scalars.len() != keys.len() || !self.shape_fits(value, &members) {
                    let found = match value {
                        Value::Vector(parts) if members.rank == 1 => parts.len(),
                        Value::Vector(_) | Value::Scalar(_) => scalars.len(),
                    };
                    let span = program.as_ref().map_or(name.span, |program| program.span);
                    if members.rank == 0 {
                        self.errors.push(ModelError::Shape {
                            what: format!("`{}` is one number, but {} is given", name.text, value.describe()),
                            span,
                            help: Some(format!("declare a family: `param {}[1..{found}] = …`", name.text)),
                        });
                    } else {
                        self.errors.push(ModelError::ListLength {
                            name: name.text.clone(),
                            expected: keys.len(),
                            found,
                            span,
                        });
                    }
                    return;
                }
                Some(scalars)
            }
            Some(Value::Scalar(_)) | None => None,
        };
        for (position, at) in keys.iter().enumerate() {
            let own = match (&program, &list, &shared) {
                (None, _, _) => None,
                (Some(_), Some(list), _) => list.get(position).copied(),
                (Some(_), None, Some(value)) => value.scalar("").ok(),
                (Some(program), None, None) => {
                    let value = self
                        .world
                        .run_written_out(program, &mut at[..members.rank].to_vec());
                    let Some(value) = self.note(value) else { return };
                    match self.one_scalar(&value, "a parameter", program.span) {
                        Some(value) => Some(value),
                        None => return,
                    }
                }
            };
            let own = own.and_then(|own| self.scaled(own, factor));
            let span = program.as_ref().map_or(name.span, |program| program.span);
            self.add_parameter(&name.text, name.span, members.rank, *at, own, sigma, factor, span);
        }
    }

    fn shape_fits(&self, value: &Value, members: &Members) -> bool {
        let Some(block) = &members.block else {
            return members.rank == 1;
        };
        let mut level = vec![value];
        for axis in 0..members.rank {
            let mut next = Vec::new();
            for value in level {
                match value {
                    Value::Vector(parts) if parts.len() == block.extent(axis) => {
                        next.extend(parts.iter());
                    }
                    Value::Vector(_) | Value::Scalar(_) => return false,
                }
            }
            level = next;
        }
        level.iter().all(|value| matches!(value, Value::Scalar(_)))
    }

    fn one_scalar(&mut self, value: &Value, what: &str, span: Span) -> Option<ExprId> {
        match value.scalar(what) {
            Ok(e) => Some(e),
            Err((what, help)) => {
                self.errors.push(ModelError::Shape { what, span, help });
                None
            }
        }
    }

    #[allow(clippy::unnecessary_wraps)] // used in chains of options
    fn scaled(&mut self, value: ExprId, factor: Option<ExprId>) -> Option<ExprId> {
        Some(match factor {
            Some(factor) => self.world.pool.mul(factor, value),
            None => value,
        })
    }

    /// Declares a family, or a further piece of one.
    fn introduce_family(&mut self, name: &Name, entity: Entity, known: bool) {
        if !known {
            self.introduce(name, entity);
        }
    }

    /// Adds members to a parameter family; gives their indices in the order of numbering.
    fn add_members(
        &mut self,
        family: usize,
        members: &Members,
        name: &Name,
    ) -> Option<Vec<Key>> {
        let base = self.world.parameters.len();
        let own = &mut self.world.parameter_families[family];
        if own.grid.rank != members.rank {
            let what = format!("`{}` has {} indices", name.text, own.grid.rank);
            self.errors.push(ModelError::BadIndices {
                what,
                span: members.span,
            });
            return None;
        }
        let twice = |at: &Key, first: Span| ModelError::GivenTwice {
            name: member_name(&name.text, members.rank, at),
            span: members.span,
            first,
        };
        if let Some(block) = &members.block {
            if let Some((at, first)) = own.grid.overlap(block) {
                self.errors.push(twice(&at, first));
                return None;
            }
            let mut block = block.clone();
            block.base = base;
            let keys = block.keys().collect();
            own.grid.blocks.push(block);
            return Some(keys);
        }
        for (position, at) in members.keys.iter().enumerate() {
            if own.grid.find(at).is_some() {
                let first = own.grid.singles.get(at).map_or(own.span, |(_, span)| *span);
                self.errors.push(twice(at, first));
                return None;
            }
            own.grid.singles.insert(*at, (base + position, members.span));
        }
        Some(members.keys.clone())
    }

    #[allow(clippy::too_many_arguments)] // all of one parameter
    fn add_parameter(
        &mut self,
        family: &str,
        span: Span,
        rank: usize,
        at: Key,
        own: Option<ExprId>,
        sigma: Option<ExprId>,
        factor: Option<ExprId>,
        value_span: Span,
    ) {
        let name = member_name(family, rank, &at);
        let number = self.world.parameters.len();
        let symbol = self.world.pool.fresh_symbol(&name);
        self.world.kinds.insert(symbol, SymbolKind::Parameter(number));
        let plain = self.world.pool.symbol_expr(symbol);
        let set = self.setting(family, rank, &at, factor);
        let own = set.or(own);
        let mut symbolic = plain;
        let mut value = None;
        if let Some(own) = own {
            if let Some(on) = self.varying_symbol(own) {
                self.errors.push(ModelError::NotConstant {
                    what: format!("the parameter `{name}`"),
                    on,
                    span: value_span,
                });
            } else if set.is_none() && !self.world.pool.symbols_of(&[own]).is_empty() {
                symbolic = own;
            }
            value = self.closed(own);
            if self.structural.contains(family)
                && let Some(value) = value
                && self.world.pool.as_number(value).is_some()
            {
                symbolic = value;
            }
        }
        let uncertainty = sigma.and_then(|sigma| self.closed(sigma));
        self.world.parameters.push(Parameter {
            name,
            span,
            symbol,
            symbolic,
            value,
            uncertainty,
        });
    }

    /// The value that was set from outside for a member.
    fn setting(
        &mut self,
        family: &str,
        rank: usize,
        at: &Key,
        factor: Option<ExprId>,
    ) -> Option<ExprId> {
        let single = (family.to_owned(), (rank > 0).then_some(*at));
        let whole = (family.to_owned(), None);
        let found = [single, whole].into_iter().find_map(|place| {
            let set = self.set.get_mut(&place)?;
            set.used = true;
            set.value.scalar("").ok()
        })?;
        // It is in the unit that the file declares, as in the file itself.
        self.scaled(found, factor)
    }

    /// A coordinate or the time, where an expression depends on one.
    fn varying_symbol(&self, e: ExprId) -> Option<String> {
        let symbols = self.world.pool.symbols_of(&[e]);
        let varying = symbols.into_iter().find(|symbol| {
            !matches!(
                self.world.kinds.get(symbol),
                Some(SymbolKind::Parameter(_)) | None
            )
        })?;
        Some(self.world.pool.symbol_name(varying).to_owned())
    }

    /// The expression with all parameters replaced by their values.
    fn closed(&mut self, e: ExprId) -> Option<ExprId> {
        let symbols = self.world.pool.symbols_of(&[e]);
        if symbols.is_empty() {
            return Some(e);
        }
        let mut values = Substitution::default();
        for symbol in symbols {
            match self.world.kinds.get(&symbol) {
                Some(SymbolKind::Parameter(number)) => {
                    values.insert(symbol, self.world.parameters[*number].value?);
                }
                Some(_) | None => return None,
            }
        }
        self.world.pool.substitute(&[e], &values).first().copied()
    }

    fn coordinate(&mut self, declaration: &Declaration) {
        let name = &declaration.name;
        self.has_units |= declaration.unit.is_some();
        if let Some(unit) = declaration.unit {
            units::factor(&mut self.world.pool, self.file, unit, &mut self.errors);
        }
        let members = self.members(declaration.indices.as_ref(), name);
        let family = self.world.coordinate_families.len();
        if !self.introduce(name, Entity::Coordinate(family)) {
            return;
        }
        let mut own = Family {
            name: name.text.clone(),
            span: name.span,
            grid: super::names::Grid::default(),
        };
        let base = self.world.coordinates.len();
        let mut keys = Vec::new();
        if let Some(members) = members {
            own.grid.rank = members.rank;
            if let Some(mut block) = members.block {
                block.base = base;
                keys.extend(block.keys());
                own.grid.blocks.push(block);
            } else {
                for (position, at) in members.keys.iter().enumerate() {
                    own.grid.singles.insert(*at, (base + position, members.span));
                }
                keys.extend(members.keys);
            }
        } else {
            own.grid.rank = declaration.indices.as_ref().map_or(0, |i| i.entries.len().min(3));
        }
        for at in keys {
            let number = self.world.coordinates.len();
            let member = member_name(&name.text, own.grid.rank, &at);
            let symbol = self.world.pool.fresh_symbol(&member);
            let velocity = self.world.pool.fresh_symbol(&format!("{member}'"));
            self.world.kinds.insert(symbol, SymbolKind::Coordinate(number));
            self.world.kinds.insert(velocity, SymbolKind::Velocity(number));
            self.world.coordinates.push(Coordinate {
                name: member,
                span: name.span,
                symbol,
                velocity,
            });
        }
        self.world.coordinate_families.push(own);
    }

    fn named_expression(&mut self, binding: &Binding) {
        let name = &binding.name;
        let Some(root) = binding.value else { return };
        let known = self.world.names.get(&name.text).copied();
        let family = match known {
            Some((Entity::Let(family), _))
                if binding.indices.is_some() && self.world.lets[family].family.grid.rank > 0 =>
            {
                Some(family)
            }
            Some((_, first)) => {
                self.errors.push(ModelError::GivenTwice {
                    name: name.text.clone(),
                    span: name.span,
                    first,
                });
                return;
            }
            None => None,
        };
        if let Some(unit) = binding.unit {
            self.has_units = true;
            units::factor(&mut self.world.pool, self.file, unit, &mut self.errors);
        }
        let before = self.errors.len();
        let members = self.members(binding.indices.as_ref(), name);
        let rank = binding.indices.as_ref().map_or(0, |i| i.entries.len().min(3));
        let number = family.unwrap_or(self.world.lets.len());
        if family.is_none() {
            self.world.lets.push(LetFamily {
                family: Family {
                    name: name.text.clone(),
                    span: name.span,
                    grid: super::names::Grid {
                        rank,
                        ..Default::default()
                    },
                },
                pieces: Vec::new(),
                members: HashMap::new(),
                recursive: false,
                depth: 0,
                progress: None,
            });
            if rank > 0 {
                // A member may use lower ones.
                self.introduce(name, Entity::Let(number));
            }
        }
        let mut scope = members
            .as_ref()
            .map_or_else(Scope::default, |members| members.scope.clone());
        let additive = is_additive(self.file, &self.world, root);
        let mut compiler = self.compiler();
        compiler.current_let = Some(number);
        if rank == 0 && mentions(compiler.file, root, &name.text) {
            compiler.errors.push(ModelError::RecursiveLet {
                name: name.text.clone(),
                span: compiler.file.expr(root).span,
            });
        }
        let program = if compiler.errors.len() > before && rank == 0 {
            Program::default()
        } else {
            compiler.value(root, &mut scope)
        };
        let (recursive, depth) = (compiler.recursive, compiler.depth);
        if rank == 0 {
            self.introduce(name, Entity::Let(number));
        }
        let span = program.span;
        let own = &mut self.world.lets[number];
        own.recursive |= recursive;
        own.depth = own.depth.max(depth + 1);
        let too_deep = own.depth > DEEPEST_LET;
        let piece = own.pieces.len();
        let named = members.as_ref().is_some_and(|members| members.named);
        let single = members
            .as_ref()
            .is_some_and(|members| members.block.is_none());
        own.pieces.push(LetPiece {
            program: Arc::new(program),
            filter: members.as_ref().and_then(|members| members.filter.clone()),
            list: rank > 0 && !named && !single,
            root,
            additive: additive && rank == 0,
        });
        if self.errors.len() > before {
            return;
        }
        let Some(members) = members else { return };
        if rank == 0 {
            let program = Arc::clone(&self.world.lets[number].pieces[piece].program);
            let value = self.world.run_written_out(&program, &mut Vec::new());
            if let Some(value) = self.note(value) {
                self.world.lets[number].members.insert([0; 3], value);
            }
            return;
        }
        if !self.add_let_members(number, piece, &members, name) {
            return;
        }
        if too_deep {
            let written = self.world.write_out_all(number, span);
            self.note(written);
        }
    }

    fn add_let_members(
        &mut self,
        number: usize,
        piece: usize,
        members: &Members,
        name: &Name,
    ) -> bool {
        let own = &mut self.world.lets[number];
        // Members written out before this piece came may be followed by lower ones now.
        own.progress = None;
        if own.family.grid.rank != members.rank {
            let what = format!("`{}` has {} indices", name.text, own.family.grid.rank);
            self.errors.push(ModelError::BadIndices {
                what,
                span: members.span,
            });
            return false;
        }
        let twice = |at: &Key, first: Span| ModelError::GivenTwice {
            name: member_name(&name.text, members.rank, at),
            span: members.span,
            first,
        };
        let grid = &mut own.family.grid;
        if let Some(block) = &members.block {
            if let Some((at, first)) = grid.overlap(block) {
                self.errors.push(twice(&at, first));
                return false;
            }
            let mut block = block.clone();
            block.base = piece;
            grid.blocks.push(block);
            return true;
        }
        for at in &members.keys {
            if grid.find_block(at).is_some() {
                let first = grid.singles.get(at).map_or(own.family.span, |(_, span)| *span);
                self.errors.push(twice(at, first));
                return false;
            }
            grid.singles.insert(*at, (piece, members.span));
        }
        true
    }

    /// `guess`, `equilibrium` and rates: one list of values per coordinate.
    fn given(
        &mut self,
        binding: &Binding,
        what: &'static str,
        into: &mut [Option<Given>],
    ) {
        let name = &binding.name;
        let Some(root) = binding.value else { return };
        let Some(&(entity, _)) = self.world.names.get(&name.text) else {
            let known: Vec<&str> = self
                .world
                .coordinate_families
                .iter()
                .map(|family| family.name.as_str())
                .collect();
            let nearest = nearest(&name.text, known).map(str::to_owned);
            self.errors.push(ModelError::NotACoordinate {
                name: name.text.clone(),
                span: name.span,
                nearest,
            });
            return;
        };
        let Entity::Coordinate(family) = entity else {
            self.errors.push(ModelError::NotACoordinate {
                name: name.text.clone(),
                span: name.span,
                nearest: None,
            });
            return;
        };
        let Some(members) = self.members(binding.indices.as_ref(), name) else {
            return;
        };
        let before = self.errors.len();
        let mut scope = members.scope.clone();
        let program = self.compiler().value(root, &mut scope);
        let factor = self.unit_factor(binding.unit, &program);
        if self.errors.len() > before {
            return;
        }
        let keys: Vec<Key> = match &members.block {
            Some(block) => block.keys().collect(),
            None => members.keys.clone(),
        };
        let rank = self.world.coordinate_families[family].grid.rank;
        if members.rank > rank {
            self.errors.push(ModelError::TooManyIndices {
                what: format!("`{}`", name.text),
                available: rank,
                span: members.span,
            });
            return;
        }
        for (position, at) in keys.iter().enumerate() {
            let value = self
                .world
                .run_written_out(&program, &mut at[..members.rank].to_vec());
            let Some(value) = self.note(value) else { return };
            let value = match (&value, members.named) {
                // A list without an index gives the members one by one.
                (Value::Vector(parts), false)
                    if members.rank == 1 && members.block.is_some() && parts.len() == keys.len() =>
                {
                    parts[position].clone()
                }
                (Value::Vector(_) | Value::Scalar(_), _) => value,
            };
            if !self.assign(family, &at[..members.rank], &value, factor, what, members.span, program.span, into) {
                return;
            }
        }
    }

    #[allow(clippy::too_many_arguments)] // one assignment with all its places
    fn assign(
        &mut self,
        family: usize,
        at: &[i64],
        value: &Value,
        factor: Option<ExprId>,
        what: &'static str,
        span: Span,
        value_span: Span,
        into: &mut [Option<Given>],
    ) -> bool {
        let own = &self.world.coordinate_families[family];
        let rank = own.grid.rank;
        if at.len() < rank {
            let Some((from, to)) = own.grid.bounds(at) else {
                self.errors.push(ModelError::IndexOutOfRange {
                    member: member_name(&own.name, at.len(), &key(at)),
                    available: own.grid.describe(&own.name),
                    span,
                    declared: Some(own.span),
                });
                return false;
            };
            let count = usize::try_from(to - from + 1).unwrap_or(0);
            if let Value::Vector(parts) = value
                && parts.len() != count
            {
                self.errors.push(ModelError::ListLength {
                    name: member_name(&own.name, at.len(), &key(at)),
                    expected: count,
                    found: parts.len(),
                    span: value_span,
                });
                return false;
            }
            return (from..=to).enumerate().all(|(i, index)| {
                let mut deeper = at.to_vec();
                deeper.push(index);
                let part = match value {
                    Value::Vector(parts) => &parts[i],
                    Value::Scalar(_) => value,
                };
                self.assign(family, &deeper, part, factor, what, span, value_span, into)
            });
        }
        let Some(number) = own.grid.find(&key(at)) else {
            self.errors.push(ModelError::IndexOutOfRange {
                member: member_name(&own.name, rank, &key(at)),
                available: own.grid.describe(&own.name),
                span,
                declared: Some(own.span),
            });
            return false;
        };
        let Some(symbolic) = self.one_scalar(value, &format!("{what} of a coordinate"), value_span) else {
            return false;
        };
        if let Some(on) = self.varying_symbol(symbolic) {
            self.errors.push(ModelError::NotConstant {
                what: format!("{what} of `{}`", self.world.coordinates[number].name),
                on,
                span: value_span,
            });
            return false;
        }
        let Some(symbolic) = self.scaled(symbolic, factor) else {
            return false;
        };
        if let Some(first) = &into[number] {
            self.errors.push(ModelError::GivenTwice {
                name: format!("{what} of {}", self.world.coordinates[number].name),
                span,
                first: first.span,
            });
            return false;
        }
        let value = self.closed(symbolic);
        into[number] = Some(Given {
            symbolic,
            value,
            span: span.to(value_span),
        });
        true
    }

    fn energy(
        &mut self,
        statement: Option<(ExprRef, Span)>,
        name: &'static str,
    ) -> Vec<TermFamily> {
        let Some((root, _)) = statement else {
            return Vec::new();
        };
        let families = families(&mut self.compiler(), root);
        let Some(families) = self.note(families) else {
            return Vec::new();
        };
        for family in &families {
            let accelerated = self
                .world
                .pool
                .symbols_of(&[family.body])
                .iter()
                .any(|symbol| {
                    matches!(
                        self.world.kinds.get(symbol),
                        Some(SymbolKind::Acceleration(_) | SymbolKind::AccelerationSlot(_))
                    )
                });
            if accelerated {
                let span = self.acceleration_place(root);
                self.errors.push(ModelError::Acceleration { energy: name, span });
                break;
            }
        }
        families
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
            children(self.file, at, &mut todo);
        }
        self.file.expr(root).span
    }

    /// Checks an expression that no command of this stage uses.
    fn check_value(&mut self, root: ExprRef, indices: Option<&Indices>, name: &Name) {
        let Some(members) = self.members(indices, name) else {
            return;
        };
        let before = self.errors.len();
        let mut scope = members.scope.clone();
        let program = self.compiler().value(root, &mut scope);
        if self.errors.len() > before {
            return;
        }
        let keys: Vec<Key> = match &members.block {
            Some(block) => block.keys().collect(),
            None => members.keys.clone(),
        };
        for at in keys {
            let value = self
                .world
                .run_written_out(&program, &mut at[..members.rank].to_vec());
            let Some(value) = self.note(value) else { return };
            if self.one_scalar(&value, "this", program.span).is_none() {
                return;
            }
        }
    }

    fn finish(mut self) -> Result<Model, Vec<ModelError>> {
        let count = self.world.coordinates.len();
        let (mut guesses, mut equilibria, mut rates) =
            (vec![None; count], vec![None; count], vec![None; count]);
        let mut constraints = Vec::new();
        for statement in &self.file.statements {
            match &statement.kind {
                StatementKind::Guess(binding) => self.given(binding, "the guess", &mut guesses),
                StatementKind::Equilibrium {
                    binding,
                    rate: false,
                } => self.given(binding, "the equilibrium", &mut equilibria),
                StatementKind::Equilibrium {
                    binding,
                    rate: true,
                } => self.given(binding, "the rate", &mut rates),
                StatementKind::Constraint {
                    indices,
                    left,
                    right,
                } => {
                    let name = Name {
                        text: "constraint".to_owned(),
                        span: statement.span,
                    };
                    self.check_value(*left, indices.as_ref(), &name);
                    self.check_value(*right, indices.as_ref(), &name);
                    constraints.push(statement.span);
                }
                StatementKind::Model { .. }
                | StatementKind::Param(_)
                | StatementKind::Coord { .. }
                | StatementKind::Let(_)
                | StatementKind::Kinetic(_)
                | StatementKind::Potential(_)
                | StatementKind::Lagrangian(_)
                | StatementKind::Dissipation(_)
                | StatementKind::Period(_)
                | StatementKind::Table { .. } => {}
            }
        }
        let energies = std::mem::take(&mut self.energies);
        if let (Some((_, span)), Some((_, energy))) =
            (energies.lagrangian, energies.kinetic.or(energies.potential))
        {
            self.errors
                .push(ModelError::LagrangianBesideEnergies { span, energy });
        } else if energies.kinetic.is_none() && energies.lagrangian.is_none() {
            self.errors.push(ModelError::MissingKinetic {});
        }
        if count == 0 && self.world.coordinate_families.is_empty() {
            self.errors.push(ModelError::NoCoordinates {});
        }
        let kinetic = self.energy(energies.kinetic, "T");
        let potential = self.energy(energies.potential, "V");
        let lagrangian = self.energy(energies.lagrangian, "lagrangian");
        self.energy(energies.dissipation, "dissipation");
        let period = energies.period.and_then(|(root, span)| self.period(root, span));
        if !self.errors.is_empty() {
            return Err(tidy(self.errors));
        }
        let time_dependent = self.time_dependence(&[&kinetic, &potential, &lagrangian]);
        let is_lagrangian = energies.lagrangian.is_some();
        Ok(Model {
            name: self.model_name.map(|(name, _)| name),
            families: self
                .world
                .coordinate_families
                .iter()
                .flat_map(coordinate_families)
                .collect(),
            coordinates: self.world.coordinates,
            parameters: self.world.parameters,
            symbols: self.world.kinds,
            kinetic: if is_lagrangian { lagrangian } else { kinetic },
            potential,
            lagrangian: is_lagrangian,
            guesses,
            equilibria,
            rates,
            dissipation: energies.dissipation.map(|(_, span)| span),
            constraints,
            period,
            time_dependent,
            has_units: self.has_units,
            pool: self.world.pool,
        })
    }

    fn period(&mut self, root: ExprRef, span: Span) -> Option<Given> {
        let program = self.compiler().value(root, &mut Scope::default());
        let value = self.world.run_written_out(&program, &mut Vec::new());
        let value = self.note(value)?;
        let symbolic = self.one_scalar(&value, "the period", program.span)?;
        if let Some(on) = self.varying_symbol(symbolic) {
            self.errors.push(ModelError::NotConstant {
                what: "the period".to_owned(),
                on,
                span: program.span,
            });
        }
        let value = self.closed(symbolic);
        Some(Given {
            symbolic,
            value,
            span,
        })
    }

    fn time_dependence(&self, energies: &[&Vec<TermFamily>]) -> Option<Span> {
        let time = self.world.time?;
        energies.iter().flat_map(|families| families.iter()).find_map(|family| {
            let symbols = self.world.pool.symbols_of(&[family.body]);
            symbols.contains(&time).then_some(family.span)
        })
    }
}

/// The boxes of a family of coordinates.
fn coordinate_families(family: &Family) -> Vec<super::CoordinateFamily> {
    let one = |extents: Vec<usize>, first: usize| super::CoordinateFamily {
        name: family.name.clone(),
        extents,
        first,
    };
    let rank = family.grid.rank;
    let boxes = family.grid.blocks.iter().map(|block| {
        let extents = (0..rank).map(|axis| block.extent(axis)).collect();
        one(extents, block.base)
    });
    let mut singles: Vec<usize> = family.grid.singles.values().map(|(first, _)| *first).collect();
    singles.sort_unstable();
    boxes
        .chain(singles.into_iter().map(|first| one(Vec::new(), first)))
        .collect()
}

/// Whether a program names a declared quantity: a parameter, a coordinate or a `let`.
fn reads_names(program: &Program) -> bool {
    let mut todo = vec![program];
    while let Some(program) = todo.pop() {
        for (op, _) in &program.ops {
            match op {
                Op::Read { .. } => return true,
                Op::SumOver(sum) => todo.push(&sum.body),
                Op::Number(number) => {
                    if let IndexForm::General(ops) = &number.form
                        && ops
                            .iter()
                            .any(|(op, _)| matches!(op, IndexOp::Parameter { .. }))
                    {
                        return true;
                    }
                }
                Op::Literal(_)
                | Op::Time
                | Op::Field { .. }
                | Op::Prime
                | Op::Negate
                | Op::BeginExponent
                | Op::EndExponent
                | Op::Power
                | Op::Product(_)
                | Op::Sum(_)
                | Op::Vector(_)
                | Op::Component(_)
                | Op::Call(..) => {}
            }
        }
    }
    false
}

/// Whether an expression names something.
fn mentions(file: &File, root: ExprRef, name: &str) -> bool {
    let mut todo = vec![root];
    while let Some(at) = todo.pop() {
        if matches!(&file.expr(at).kind, ExprKind::Name(own) if own == name) {
            return true;
        }
        children(file, at, &mut todo);
    }
    false
}

/// In the order of the file, each once.
fn tidy(mut errors: Vec<ModelError>) -> Vec<ModelError> {
    let place = |error: &ModelError| {
        crate::diagnostic::Diagnostic::from(error)
            .primary
            .map_or(Span::new(u32::MAX, u32::MAX), |label| label.span)
    };
    errors.sort_by_key(place);
    let mut seen: Vec<ModelError> = Vec::new();
    for error in errors {
        if !seen.contains(&error) {
            seen.push(error);
        }
    }
    seen
}
