//! What the names of a model stand for: parameters, coordinates, named expressions, tables.

use std::collections::BTreeSet;
use std::sync::Arc;

use hashbrown::{HashMap, HashSet};

use super::assume::Assumption;
use super::coordinates::{Coordinates, Symbols};
use super::error::counted_indices;
use super::given::Givens;
use super::members::Members;
use super::program::{IndexProgram, Program};
use super::table::Table;
use super::terms::Local;
use super::values::Value;
use super::{Model, ModelError};
use crate::expr::{Derivatives, ExprId, Pool, Symbol};
use crate::order::{Gather, Order};
use crate::span::Span;
use crate::syntax::ExprRef;

/// Up to three indices; unused ones are 0.
pub(crate) type Key = [i64; 3];

pub(super) fn key(indices: &[i64]) -> Key {
    std::array::from_fn(|axis| indices.get(axis).copied().unwrap_or(0))
}

/// What a declared name stands for; the number is its place in the list of its kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Entity {
    Parameter(usize),
    Coordinate(usize),
    Let(usize),
    Table(usize),
}

/// A box of indices whose members are numbered from `base` on, the last index fastest.
#[derive(Clone, Debug)]
pub(super) struct Block {
    pub(super) lower: Key,
    pub(super) upper: Key,
    pub(super) base: usize,
    pub(super) span: Span,
}

impl Block {
    pub(super) fn contains(&self, at: &Key) -> bool {
        (0..3).all(|axis| (self.lower[axis]..=self.upper[axis]).contains(&at[axis]))
    }

    pub(super) fn extent(&self, axis: usize) -> usize {
        usize::try_from(self.upper[axis] - self.lower[axis] + 1).unwrap_or(0)
    }

    pub(super) fn len(&self) -> usize {
        (0..3).map(|axis| self.extent(axis)).product()
    }

    fn offset(&self, at: &Key) -> usize {
        (0..3).fold(0, |sum, axis| sum * self.extent(axis) + usize::try_from(at[axis] - self.lower[axis]).unwrap_or(0))
    }

    /// The indices of a member of the box, counted from 0.
    pub(super) fn key(&self, offset: usize) -> Key {
        let (mut key, mut left) = (self.lower, offset);
        for axis in (0..3).rev() {
            let extent = self.extent(axis).max(1);
            key[axis] += i64::try_from(left % extent).unwrap_or(0);
            left /= extent;
        }
        key
    }

    /// All indices of the box, the last fastest.
    pub(super) fn keys(&self) -> impl Iterator<Item = Key> + '_ {
        (0..self.len()).map(|offset| self.key(offset))
    }
}

/// The members of a family: where they are and which numbers they have.
#[derive(Clone, Debug, Default)]
pub(super) struct Grid {
    pub(super) rank: usize,
    pub(super) blocks: Vec<Block>,
    /// Members given one by one or through a filter.
    pub(super) singles: HashMap<Key, (usize, Span)>,
}

impl Grid {
    /// The number of a member, the box that holds it where there is one.
    pub(super) fn find(&self, at: &Key) -> Option<usize> {
        self.find_by(at, |block| block.base + block.offset(at))
    }

    /// The same, with another number in place of that of a member of a box.
    pub(super) fn find_by(&self, at: &Key, number: impl Fn(&Block) -> usize) -> Option<usize> {
        let block = self.blocks.iter().find(|block| block.contains(at));
        self.singles.get(at).map(|(number, _)| *number).or_else(|| block.map(number))
    }

    /// The indices of all members, ascending.
    pub(super) fn keys(&self) -> Vec<Key> {
        let boxes = self.blocks.iter().flat_map(Block::keys);
        let mut keys: Vec<Key> = boxes.chain(self.singles.keys().copied()).collect();
        keys.put_in_order();
        keys
    }

    /// The numbers of all members.
    pub(super) fn numbers(&self) -> impl Iterator<Item = usize> + '_ {
        let boxes = self.blocks.iter().flat_map(|block| block.base..block.base + block.len());
        boxes.chain(self.singles.values().map(|(number, _)| *number))
    }

    /// Where a member that is to be added is given already.
    pub(super) fn overlap(&self, block: &Block) -> Option<(Key, Span)> {
        let shared = self.blocks.iter().find_map(|other| {
            let least = std::array::from_fn(|axis| block.lower[axis].max(other.lower[axis]));
            (block.contains(&least) && other.contains(&least)).then_some((least, other.span))
        });
        let inside = self.singles.iter().filter(|(at, _)| block.contains(at));
        shared.or_else(|| inside.map(|(at, (_, span))| (*at, *span)).min())
    }

    /// Smallest and largest value of the index behind `prefix`, over all members.
    pub(super) fn bounds(&self, prefix: &[i64]) -> Option<(i64, i64)> {
        let axis = prefix.len();
        let boxes = self.blocks.iter().map(|block| (&block.lower, &block.upper));
        let all = boxes.chain(self.singles.keys().map(|at| (at, at)));
        let fitting = all.filter(|(lower, upper)| (0..axis).all(|i| (lower[i]..=upper[i]).contains(&prefix[i])));
        fitting.map(|(lower, upper)| (lower[axis], upper[axis])).reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
    }

    /// The ranges in words, for messages.
    pub(super) fn describe(&self, name: &str) -> String {
        let range = |block: &Block, axis: usize| format!("{}..{}", block.lower[axis], block.upper[axis]);
        let ranges = |block: &Block| (0..self.rank).map(|axis| range(block, axis)).collect::<Vec<_>>().join(", ");
        let mut parts: Vec<String> = self.blocks.iter().map(|own| format!("{name}[{}]", ranges(own))).collect();
        let mut singles: Vec<&Key> = self.singles.keys().collect();
        singles.put_in_order();
        parts.extend(singles.iter().take(4).map(|at| member_name(name, self.rank, at)));
        if singles.len() > 4 {
            parts.push("…".to_owned());
        }
        if parts.is_empty() { format!("`{name}` has no members") } else { format!("there is {}", parts.join(", ")) }
    }
}

/// `r[1,3]`, or the plain name of something without indices.
pub(super) fn member_name(name: &str, rank: usize, at: &Key) -> String {
    if rank == 0 {
        return name.to_owned();
    }
    let indices: Vec<String> = at[..rank].iter().map(ToString::to_string).collect();
    format!("{name}[{}]", indices.join(","))
}

#[derive(Clone, Debug, Default)]
pub(super) struct Family {
    pub(super) name: String,
    pub(super) span: Span,
    pub(super) grid: Grid,
}

impl Family {
    /// That there is no member at these indices.
    pub(super) fn out_of_range(&self, at: &[i64], span: Span) -> ModelError {
        let singles = self.grid.singles.keys().filter(|_| self.grid.rank == 1 && self.grid.blocks.is_empty());
        // `coord x[3]`, and `coord x[1-3]`, which is `x[-2]`.
        let several = singles.only().map(|own| match own[0] {
            last if last > 1 => format!("several members are declared by a range: `{}[1..{last}]`", self.name),
            _ => format!("several members are declared by a range: `{}[1..3]`", self.name),
        });
        ModelError::IndexOutOfRange {
            help: several,
            member: member_name(&self.name, at.len().min(3), &key(at)),
            available: self.grid.describe(&self.name),
            span,
            declared: Some(self.span),
        }
    }

    /// How the member next to all others of coordinates or a `let` is declared, which may be the fixed end of a chain.
    pub(super) fn fixed_end(&self, at: &[i64], is_let: bool) -> Option<String> {
        let ([block], [index], 1) = (self.grid.blocks.as_slice(), at, self.grid.rank) else { return None };
        let (name, lower, upper) = (&self.name, block.lower[0], block.upper[0]);
        (*index == lower - 1 || *index == upper + 1).then(|| {
            let (first, last) = (lower.min(*index), upper.max(*index));
            let declared = if is_let {
                format!("`let {name}[{index}] = …`")
            } else {
                format!("`coord {name}[{first}..{last}]` with `constraint {name}[{index}] = 0`")
            };
            format!(
                "where a sum goes too far, shorten it by a term; where the end is fixed, declare it as well: {declared}"
            )
        })
    }

    /// That a member is made from itself.
    pub(super) fn recursive(&self, at: &Key, span: Span) -> ModelError {
        ModelError::RecursiveLet { name: member_name(&self.name, self.grid.rank, at), through: None, span }
    }

    /// Adds members, numbered from `base` on, or all by `base` where they are of one piece.
    pub(super) fn add(&mut self, members: &Members, base: usize, is_piece: bool) -> Result<(), ModelError> {
        let (rank, span) = (self.grid.rank, members.span);
        if rank != members.rank {
            let what = format!("`{}` was given with {} before", self.name, counted_indices(rank));
            return Err(ModelError::BadIndices { what, span });
        }
        let name = |at: &Key| member_name(&self.name, rank, at);
        let twice = |at: &Key, first| ModelError::GivenTwice { name: name(at), help: None, span, first };
        if let Some(block) = &members.block {
            if let Some((at, first)) = self.grid.overlap(block) {
                return Err(twice(&at, first));
            }
            self.grid.blocks.push(Block { base, ..block.clone() });
            return Ok(());
        }
        for (position, at) in members.keys.iter().enumerate() {
            if self.grid.find(at).is_some() {
                let first = self.grid.singles.get(at).map_or(self.span, |(_, span)| *span);
                return Err(twice(at, first));
            }
            let number = if is_piece { base } else { base + position };
            self.grid.singles.insert(*at, (number, span));
        }
        Ok(())
    }
}

/// One `let` name: its pieces, and the members that have been written out so far.
#[derive(Clone, Debug, Default)]
pub(super) struct LetFamily {
    pub(super) family: Family,
    pub(super) pieces: Vec<LetPiece>,
    pub(super) members: HashMap<Key, Value>,
    /// A member uses lower ones: it can't be a term with slots and is written out.
    pub(super) recursive: bool,
    /// How deep named families nest in it.
    pub(super) depth: usize,
    /// How many members are read for one of it, through all the families below.
    pub(super) cost: u64,
    /// Members written out, ascending, of a recursive family.
    pub(super) progress: Option<Progress>,
}

impl LetFamily {
    /// The indices of all members, ascending.
    pub(super) fn keys(&self) -> Vec<Key> {
        if self.family.grid.rank == 0 { vec![[0; 3]] } else { self.family.grid.keys() }
    }
}

/// How far a recursive family is written out.
#[derive(Clone, Debug)]
pub(super) struct Progress {
    pub(super) order: Vec<Key>,
    pub(super) done: usize,
    /// The member that is being written out.
    pub(super) current: Option<Key>,
    /// A member had a mistake, which is told: those after it are not to be had.
    pub(super) failed: bool,
}

#[derive(Clone, Debug)]
pub(super) struct LetPiece {
    pub(super) program: Arc<Program>,
    pub(super) filter: Option<IndexProgram>,
    /// The right side is written without an index: a vector of the right length lists the members.
    pub(super) list: bool,
    /// The right side in the syntax tree.
    pub(super) root: ExprRef,
    /// It is a sum over many terms, which energies take apart.
    pub(super) additive: bool,
}

/// A declared parameter, one member of a family or a single one.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Parameter {
    /// `g`, `m[2]`.
    pub name: String,
    /// Where it is declared.
    pub span: Span,
    /// Its symbol in the pool.
    pub symbol: Symbol,
    /// What stands for it in derivations: the symbol itself, or, where it is defined from other
    /// parameters, the expression in those; a number where it sets ranges.
    pub symbolic: ExprId,
    /// Its value: an expression without symbols. `None` without a value.
    pub value: Option<ExprId>,
    /// Standard uncertainty, an expression without symbols.
    pub uncertainty: Option<ExprId>,
    /// What its unit is in SI, an expression without symbols. `None` without a unit.
    pub unit: Option<ExprId>,
}

impl Parameter {
    /// Whether it stands as itself in derivations, of a model with this pool.
    #[must_use]
    pub fn is_symbol(&self, pool: &Pool) -> bool {
        pool.as_symbol(self.symbolic) == Some(self.symbol)
    }
}

/// What a symbol of the pool means to the model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum SymbolKind {
    /// A coordinate, by its number.
    Coordinate(usize),
    /// A coordinate's velocity.
    Velocity(usize),
    /// A coordinate's acceleration.
    Acceleration(usize),
    /// A parameter, by its number.
    Parameter(usize),
    /// The time.
    Time,
    /// A place in a family's term that every instance fills with a coordinate of its own.
    CoordinateSlot(usize),
    /// The velocity of such a coordinate.
    VelocitySlot(usize),
    /// The acceleration of such a coordinate.
    AccelerationSlot(usize),
    /// A place that every instance fills with a parameter or number of its own.
    ValueSlot(usize),
}

impl SymbolKind {
    pub(super) fn is_acceleration(self) -> bool {
        matches!(self, Self::Acceleration(_) | Self::AccelerationSlot(_))
    }
}

/// Everything declared so far.
#[derive(Debug, Default)]
pub(super) struct World {
    pub(super) pool: Pool,
    pub(super) names: HashMap<String, (Entity, Span)>,
    pub(super) kinds: Symbols,
    pub(super) parameter_families: Vec<Family>,
    pub(super) parameters: Vec<Parameter>,
    pub(super) coordinate_families: Vec<Family>,
    /// The factor of the unit that a family is declared in.
    pub(super) coordinate_units: Vec<Option<ExprId>>,
    pub(super) coordinates: Coordinates,
    pub(super) accelerations: HashMap<usize, Symbol>,
    pub(super) lets: Vec<LetFamily>,
    pub(super) tables: Vec<Table>,
    /// Terms of the sum that is being worked out, those of sums within it included.
    pub(super) steps: u64,
    /// Of the statements read so far.
    pub(super) assumptions: Vec<Assumption>,
    pub(super) time: Option<Symbol>,
    /// What is declared with a mistake: reading it makes no further one.
    pub(super) broken: HashSet<Entity>,
    /// Some expression contains an acceleration.
    pub(super) accelerated: bool,
    /// Some function was called that takes tensors of inertia, or gives the angular velocity that stands beside one.
    pub(super) rigid: bool,
    /// Slot symbols, shared by all terms: coordinate, velocity, acceleration of slot k; value k.
    pub(super) coordinate_slots: Vec<[Symbol; 3]>,
    pub(super) value_slots: Vec<Symbol>,
    /// The time derivatives taken so far.
    pub(super) rates: Derivatives,
}

impl World {
    pub(super) fn time_symbol(&mut self) -> Symbol {
        if let Some(time) = self.time {
            return time;
        }
        let time = self.pool.fresh_symbol("t");
        self.kinds.insert(time, SymbolKind::Time);
        self.time = Some(time);
        time
    }

    pub(super) fn coordinate_slot(&mut self, k: usize) -> [Symbol; 3] {
        while self.coordinate_slots.len() <= k {
            let k = self.coordinate_slots.len();
            let symbols = ["", "'", "''"].map(|primes| self.pool.fresh_symbol(&format!("q{}{primes}", k + 1)));
            let kinds = [SymbolKind::CoordinateSlot, SymbolKind::VelocitySlot, SymbolKind::AccelerationSlot];
            symbols.into_iter().zip(kinds).for_each(|(symbol, kind)| self.kinds.insert(symbol, kind(k)));
            self.coordinate_slots.push(symbols);
        }
        self.coordinate_slots[k]
    }

    pub(super) fn value_slot(&mut self, k: usize) -> ExprId {
        while self.value_slots.len() <= k {
            let k = self.value_slots.len();
            let symbol = self.pool.fresh_symbol(&format!("c{}", k + 1));
            self.kinds.insert(symbol, SymbolKind::ValueSlot(k));
            self.value_slots.push(symbol);
        }
        self.pool.symbol_expr(self.value_slots[k])
    }

    pub(super) fn acceleration(&mut self, coordinate: usize) -> Symbol {
        if let Some(symbol) = self.accelerations.get(&coordinate) {
            return *symbol;
        }
        let name = format!("{}''", self.coordinates.at(coordinate).name());
        let symbol = self.pool.fresh_symbol(&name);
        self.kinds.insert(symbol, SymbolKind::Acceleration(coordinate));
        self.accelerations.insert(coordinate, symbol);
        symbol
    }

    /// The time derivative of a symbol: a velocity, an acceleration, 1 for the time, `None` for
    /// constants.
    pub(super) fn rate(&mut self, symbol: Symbol) -> Option<ExprId> {
        let rate = match self.kinds.get(symbol)? {
            SymbolKind::Coordinate(i) => self.coordinates.at(i).velocity,
            SymbolKind::Velocity(i) => {
                self.accelerated = true;
                self.acceleration(i)
            }
            SymbolKind::CoordinateSlot(k) => self.coordinate_slot(k)[1],
            SymbolKind::VelocitySlot(k) => {
                self.accelerated = true;
                self.coordinate_slot(k)[2]
            }
            SymbolKind::Time => return Some(self.pool.integer(1)),
            SymbolKind::Acceleration(_)
            | SymbolKind::AccelerationSlot(_)
            | SymbolKind::Parameter(_)
            | SymbolKind::ValueSlot(_) => return None,
        };
        Some(self.pool.symbol_expr(rate))
    }

    /// The family behind a parameter, coordinate or `let`.
    pub(super) fn family(&self, entity: Entity) -> Option<&Family> {
        match entity {
            Entity::Parameter(i) => self.parameter_families.get(i),
            Entity::Coordinate(i) => self.coordinate_families.get(i),
            Entity::Let(i) => self.lets.get(i).map(|family| &family.family),
            Entity::Table(_) => None,
        }
    }
}

impl Model {
    /// The symbol of the time, where the model speaks of it.
    #[must_use]
    pub fn time(&self) -> Option<Symbol> {
        self.symbols.time()
    }

    /// The model with some of its coordinates, and what is given of them: without energies, forces and constraints.
    pub(crate) fn bare(&self, kept: &[usize]) -> Self {
        let none = || Givens::none(0);
        let gone = (0..self.coordinates.len()).filter(|i| !kept.contains(i));
        let mut own = Self {
            coordinates: Coordinates::default(),
            families: Vec::new(),
            symbols: self.symbols.without_coordinates(),
            kinetic: Vec::new(),
            potential: Vec::new(),
            lagrangian: false,
            guesses: none(),
            guessed_velocities: none(),
            equilibria: none(),
            rates: none(),
            forces: Vec::new(),
            constraints: Vec::new(),
            rolling: Vec::new(),
            follow: gone.map(|i| self.coordinates.at(i).name()).collect(),
            ..self.clone()
        };
        for (at, i) in kept.iter().enumerate() {
            let old = self.coordinates.at(*i);
            own.insert_coordinate([old.symbol, old.velocity], old.name(), old.span, old.unit);
            own.guesses.set(at, self.guesses.get(*i));
            own.guessed_velocities.set(at, self.guessed_velocities.get(*i));
            own.equilibria.set(at, self.equilibria.get(*i));
            own.rates.set(at, self.rates.get(*i));
        }
        own
    }

    fn insert_coordinate(&mut self, [symbol, velocity]: [Symbol; 2], name: String, span: Span, unit: Option<&str>) {
        let at = self.coordinates.len();
        self.symbols.insert(symbol, SymbolKind::Coordinate(at));
        self.symbols.insert(velocity, SymbolKind::Velocity(at));
        self.coordinates.push(name, span, [symbol, velocity], unit);
        for given in [&mut self.guesses, &mut self.guessed_velocities, &mut self.equilibria, &mut self.rates] {
            given.add();
        }
    }

    /// Adds a coordinate that the file does not have, by the name of its symbol and the one that is shown.
    pub(crate) fn add_coordinate(&mut self, symbol: &str, name: String, span: Span) -> Local {
        let (symbol, velocity) = (self.pool.symbol(symbol), self.pool.symbol(&format!("{symbol}'")));
        self.insert_coordinate([symbol, velocity], name, span, None);
        Local::new(symbol, velocity)
    }

    /// The first of some names that no parameter, no coordinate and no expression has, to name what the model itself does not speak of.
    pub(crate) fn unused_name(&self, names: &[&str]) -> String {
        let parameters = self.parameters.iter().map(|p| p.name.as_str());
        let coordinates = self.coordinates.stems();
        let named = self.named.iter().map(String::as_str);
        let all = parameters.chain(coordinates).chain(named);
        let taken: BTreeSet<&str> = all.map(|name| name.split('[').next().unwrap_or(name)).collect();
        let free = names.iter().find(|name| !taken.contains(**name));
        // All of them taken: a name that is too long for anybody to have chosen.
        free.map_or_else(|| format!("{}_of_the_derivation", names.first().unwrap_or(&"")), ToString::to_string)
    }
}
