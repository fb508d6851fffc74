//! Coordinates: `coord` statements, and what is kept of the families that they declare. Of a member there is no entry:
//! its name, its symbols and its unit follow from its number.

use std::sync::Arc;

use hashbrown::HashMap;

use super::dimension::Dimensions;
use super::elaborate::Elaborator;
use super::members::Members;
use super::names::{Block, Entity, Family, Grid, Key, SymbolKind, member_name};
use crate::expr::{ExprId, Pool, Symbol, SymbolNames};
use crate::span::Span;
use crate::syntax::Binding;

/// What a coordinate takes before anything is computed of it: its numbers in the terms of the energies, its place, its
/// entries of M and K.
const BYTES_EACH: usize = 64;

/// A generalised coordinate.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct Coordinate<'a> {
    /// Where it is declared.
    pub span: Span,
    /// The coordinate's symbol.
    pub symbol: Symbol,
    /// Its velocity's symbol, named `x'`.
    pub velocity: Symbol,
    /// Its SI unit as the language writes it, `m`, `rad`, `kg^(1/2)*m`: where the file has units
    /// and they tell.
    pub unit: Option<&'a str>,
    /// What numbers in the unit that it is declared with are multiplied by to be in SI, an expression without
    /// symbols; `None` where they are in SI already.
    pub factor: Option<ExprId>,
    names: &'a Names,
    place: usize,
}

impl Coordinate<'_> {
    /// `theta`, `phi[1]`, `r[1,3]`.
    #[must_use]
    pub fn name(&self) -> String {
        self.names.member(self.place)
    }
}

/// The generalised coordinates of a model in the order of declaration, the last index fastest.
///
/// Families are kept whole; a [`Coordinate`] is put together when it is asked for.
#[derive(Clone, Debug, Default)]
pub struct Coordinates {
    rows: Vec<Row>,
    count: usize,
}

/// Coordinates declared together.
#[derive(Clone, Debug)]
struct Row {
    /// The number of the first.
    first: usize,
    names: Arc<Names>,
    span: Span,
    /// The symbols of the first and of its velocity; those of the next are two symbols further.
    symbols: [Symbol; 2],
    /// One for all, or one for each.
    units: Vec<Option<String>>,
    factor: Option<ExprId>,
}

/// The names of the members of a family, in the order of their numbers.
#[derive(Debug)]
struct Names {
    name: String,
    rank: usize,
    /// A full box, or the members one by one.
    block: Option<Block>,
    keys: Vec<Key>,
}

impl Names {
    fn member(&self, place: usize) -> String {
        let block = self.block.as_ref().map(|block| block.key(place));
        let at = block.or_else(|| self.keys.get(place).copied());
        member_name(&self.name, self.rank, &at.unwrap_or_default())
    }
}

/// Coordinates and velocities in turn.
impl SymbolNames for Names {
    fn name(&self, place: usize) -> String {
        let prime = if place.is_multiple_of(2) { "" } else { "'" };
        format!("{}{prime}", self.member(place / 2))
    }
}

impl Row {
    fn coordinate(&self, place: usize) -> Coordinate<'_> {
        let [symbol, velocity] = self.symbols.map(|symbol| symbol.after(2 * place));
        let unit = if let [only] = self.units.as_slice() { Some(only) } else { self.units.get(place) };
        let unit = unit.and_then(Option::as_deref);
        Coordinate { span: self.span, symbol, velocity, unit, factor: self.factor, names: &self.names, place }
    }
}

impl Coordinates {
    /// How many there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.count
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// The coordinate of a number below [`Coordinates::len`]; beyond it what comes last is counted on.
    ///
    /// # Panics
    /// Where there are no coordinates.
    #[must_use]
    pub fn at(&self, number: usize) -> Coordinate<'_> {
        let row = self.rows.partition_point(|row| row.first <= number).saturating_sub(1);
        let row = &self.rows[row];
        row.coordinate(number - row.first)
    }

    /// The coordinate of a number, if there is one.
    #[must_use]
    pub fn get(&self, number: usize) -> Option<Coordinate<'_>> {
        (number < self.count).then(|| self.at(number))
    }

    /// The first coordinate, if there is one.
    #[must_use]
    pub fn first(&self) -> Option<Coordinate<'_>> {
        self.get(0)
    }

    /// All of them, in order.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = Coordinate<'_>> + Clone {
        (0..self.count).map(|number| self.at(number))
    }

    /// The names of all of them, in order.
    pub fn names(&self) -> impl ExactSizeIterator<Item = String> + Clone + '_ {
        self.iter().map(|own| own.name())
    }

    /// The names that they are declared under, without indices.
    pub(crate) fn stems(&self) -> impl Iterator<Item = &str> {
        self.rows.iter().map(|row| row.names.name.as_str())
    }

    /// Adds a coordinate by itself.
    pub(super) fn push(&mut self, name: String, span: Span, symbols: [Symbol; 2], unit: Option<&str>) {
        let names = Arc::new(Names { name, rank: 0, block: None, keys: Vec::new() });
        let units = vec![unit.map(str::to_owned)];
        self.add(Row { first: self.count, names, span, symbols, units, factor: None }, 1);
    }

    /// Adds a row of so many coordinates, if there are any.
    fn add(&mut self, row: Row, count: usize) {
        if count > 0 {
            self.rows.push(row);
            self.count += count;
        }
    }

    /// Takes over the units that are known of the dimensions.
    pub(super) fn set_units(&mut self, dimensions: &Dimensions) {
        let ends: Vec<usize> = self.rows.iter().skip(1).map(|row| row.first).chain([self.count]).collect();
        for (row, end) in self.rows.iter_mut().zip(ends) {
            row.units = dimensions.units(&row.names.name, end - row.first);
        }
    }
}

/// What the symbols of a model's pool stand for.
#[derive(Clone, Debug, Default)]
pub struct Symbols {
    each: HashMap<Symbol, SymbolKind>,
    /// Coordinates and velocities in turn: the first symbol, how many coordinates, the number of the first.
    rows: Vec<(Symbol, usize, usize)>,
}

impl Symbols {
    /// What a symbol stands for; `None` for one that the model does not have.
    #[must_use]
    pub fn get(&self, symbol: Symbol) -> Option<SymbolKind> {
        let row = self.rows.partition_point(|(first, _, _)| *first <= symbol).checked_sub(1);
        if let Some((first, count, number)) = row.and_then(|row| self.rows.get(row)) {
            let place = symbol.index() - first.index();
            if place < 2 * count {
                let number = number + place / 2;
                let is_velocity = !place.is_multiple_of(2);
                return Some(if is_velocity { SymbolKind::Velocity(number) } else { SymbolKind::Coordinate(number) });
            }
        }
        self.each.get(&symbol).copied()
    }

    /// The number of the coordinate that a symbol is.
    #[must_use]
    pub fn coordinate(&self, symbol: Symbol) -> Option<usize> {
        if let Some(SymbolKind::Coordinate(number)) = self.get(symbol) { Some(number) } else { None }
    }

    /// The number of the coordinate whose velocity a symbol is.
    #[must_use]
    pub fn velocity(&self, symbol: Symbol) -> Option<usize> {
        if let Some(SymbolKind::Velocity(number)) = self.get(symbol) { Some(number) } else { None }
    }

    /// The number of the parameter that a symbol is.
    #[must_use]
    pub fn parameter(&self, symbol: Symbol) -> Option<usize> {
        if let Some(SymbolKind::Parameter(number)) = self.get(symbol) { Some(number) } else { None }
    }

    /// The derivatives by the coordinates, by their numbers, those that are not 0.
    pub fn slopes(&self, pool: &mut Pool, e: ExprId) -> Vec<(usize, ExprId)> {
        numbered_slopes(pool, e, |symbol| self.coordinate(symbol))
    }

    /// The same by the velocities.
    pub fn velocity_slopes(&self, pool: &mut Pool, e: ExprId) -> Vec<(usize, ExprId)> {
        numbered_slopes(pool, e, |symbol| self.velocity(symbol))
    }

    /// The symbol of the time, where the model speaks of it.
    #[must_use]
    pub fn time(&self) -> Option<Symbol> {
        let mut each = self.each.iter();
        each.find_map(|(symbol, kind)| (*kind == SymbolKind::Time).then_some(*symbol))
    }

    /// Those that stand for no coordinate and no velocity.
    pub(super) fn without_coordinates(&self) -> Self {
        let moves = |kind: &SymbolKind| matches!(kind, SymbolKind::Coordinate(_) | SymbolKind::Velocity(_));
        let each = self.each.iter().filter(|(_, kind)| !moves(kind)).map(|(symbol, kind)| (*symbol, *kind));
        Self { each: each.collect(), rows: Vec::new() }
    }

    pub(super) fn insert(&mut self, symbol: Symbol, kind: SymbolKind) {
        self.each.insert(symbol, kind);
    }
}

/// The derivatives by the symbols that have a number, by these numbers, those that are not 0.
pub(super) fn numbered_slopes(
    pool: &mut Pool,
    e: ExprId,
    number: impl Fn(Symbol) -> Option<usize>,
) -> Vec<(usize, ExprId)> {
    let slopes = pool.slopes(e, |symbol| number(symbol).is_some());
    slopes.into_iter().filter_map(|(symbol, slope)| Some((number(symbol)?, slope))).collect()
}

/// The boxes of a family of coordinates.
pub(super) fn coordinate_families(family: &Family) -> Vec<super::CoordinateFamily> {
    let one = |extents: Vec<usize>, first: usize| super::CoordinateFamily { name: family.name.clone(), extents, first };
    let rank = family.grid.rank;
    let boxes = family.grid.blocks.iter().map(|block| {
        let extents = (0..rank).map(|axis| block.extent(axis)).collect();
        one(extents, block.base)
    });
    let mut singles: Vec<usize> = family.grid.singles.values().map(|(first, _)| *first).collect();
    singles.sort_unstable();
    boxes.chain(singles.into_iter().map(|first| one(Vec::new(), first))).collect()
}

impl Elaborator<'_> {
    pub(super) fn coordinate(&mut self, declaration: &Binding) {
        let name = &declaration.name;
        let factor = self.factor(declaration.unit);
        let members = self.members(declaration.indices.as_deref(), name);
        let family = self.world.coordinate_families.len();
        if !self.introduce(name, Entity::Coordinate(family)) {
            return;
        }
        let rank = declaration.indices.as_ref().map_or(0, |i| i.entries.len().min(3));
        let grid = Grid { rank, ..Grid::default() };
        let mut own = Family { name: name.text.to_string(), span: name.span, grid };
        let base = self.world.coordinates.len();
        let count = members.as_ref().map_or(0, Members::count);
        let what = format!("`{}`", name.text);
        self.world.pool.budget().at(what, Some(name.span));
        let room = self.world.pool.budget().room(count, BYTES_EACH);
        if let Some(members) = members.filter(|_| room.is_ok()) {
            let added = own.add(&members, base, false);
            self.note(added);
            let names = Arc::new(Names { name: own.name.clone(), rank, block: members.block, keys: members.keys });
            let symbol = self.world.pool.fresh_symbols(2 * count, Arc::<Names>::clone(&names));
            self.world.kinds.rows.push((symbol, count, base));
            let symbols = [symbol, symbol.after(1)];
            let row = Row { first: base, names, span: name.span, symbols, units: Vec::new(), factor };
            self.world.coordinates.add(row, count);
        }
        self.world.coordinate_families.push(own);
        self.world.coordinate_units.push(factor);
    }
}
