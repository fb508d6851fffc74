//! `coord` statements.

use super::elaborate::Elaborator;
use super::members::Members;
use super::names::{Coordinate, Entity, Family, Grid, SymbolKind, member_name};
use super::units;
use crate::syntax::Declaration;

/// What a coordinate takes: two symbols, their names, its unit.
const BYTES_EACH: usize = 400;

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
    pub(super) fn coordinate(&mut self, declaration: &Declaration) {
        let name = &declaration.name;
        self.has_units |= declaration.unit.is_some();
        let factor =
            declaration.unit.map(|unit| units::factor(&mut self.world.pool, self.file, unit, &mut self.errors));
        let members = self.members(declaration.indices.as_deref(), name);
        let family = self.world.coordinate_families.len();
        if !self.introduce(name, Entity::Coordinate(family)) {
            return;
        }
        let mut own = Family { name: name.text.to_string(), span: name.span, grid: Grid::default() };
        let base = self.world.coordinates.len();
        let mut keys = Vec::new();
        let count = members.as_ref().map_or(0, Members::count);
        let what = format!("`{}`", name.text);
        self.world.pool.budget().at(what, Some(name.span));
        let room = self.world.pool.budget().room(count, BYTES_EACH);
        let members = members.filter(|_| room.is_ok());
        if let Some(members) = members {
            own.grid.rank = members.rank;
            keys = members.keys();
            let added = own.add(&members, base, false);
            self.note(added);
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
                unit: None,
                factor,
            });
        }
        self.world.coordinate_families.push(own);
        self.world.coordinate_units.push(factor);
    }
}
