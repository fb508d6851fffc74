//! `guess`, `equilibrium` and `force` statements: something for each coordinate that they name.

use hashbrown::HashMap;

use super::ModelError;
use super::elaborate::Elaborator;
use super::members::{Members, reads_names};
use super::names::{Entity, Key, key, member_name};
use super::terms::{TermFamily, forces};
use super::values::Value;
use crate::diagnostic::Meant;
use crate::expr::ExprId;
use crate::order::Gather;
use crate::span::Span;
use crate::syntax::{Binding, ExprKind};

/// An expression without symbols for a coordinate, from `guess` or `equilibrium`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Given {
    /// In the model's parameters, as derivations show it.
    pub symbolic: ExprId,
    /// The value: without symbols. `None` where a parameter has no value.
    pub value: Option<ExprId>,
    /// Where it stands.
    pub span: Span,
}

/// For each coordinate what is given for it, if anything is. Takes no memory where nothing is given at all.
#[derive(Clone, Debug, Default)]
pub struct Givens {
    /// Empty, or one for each.
    all: Vec<Option<Given>>,
    count: usize,
}

impl Givens {
    /// Nothing, for so many coordinates.
    #[must_use]
    pub fn none(count: usize) -> Self {
        Self { all: Vec::new(), count }
    }

    /// Nothing for one more coordinate.
    pub(super) fn add(&mut self) {
        self.count += 1;
        if !self.all.is_empty() {
            self.all.push(None);
        }
    }

    /// What is given for a coordinate.
    #[must_use]
    pub fn get(&self, coordinate: usize) -> Option<Given> {
        self.all.get(coordinate).copied().flatten()
    }

    /// Whether anything is given.
    #[must_use]
    pub fn any(&self) -> bool {
        self.all.iter().any(Option::is_some)
    }

    /// One coordinate after the other.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = Option<Given>> + Clone + '_ {
        (0..self.count).map(|coordinate| self.get(coordinate))
    }

    /// All that is given.
    pub fn given(&self) -> impl Iterator<Item = Given> + '_ {
        self.all.iter().flatten().copied()
    }

    /// All that is given, with the numbers of the coordinates.
    pub fn given_mut(&mut self) -> impl Iterator<Item = (usize, &mut Given)> {
        self.all.iter_mut().enumerate().filter_map(|(coordinate, given)| Some((coordinate, given.as_mut()?)))
    }

    /// Gives something for a coordinate.
    pub fn set(&mut self, coordinate: usize, given: Option<Given>) {
        if given.is_some() {
            self.all.resize(self.count, None);
        }
        if let Some(own) = self.all.get_mut(coordinate) {
            *own = given;
        }
    }
}

/// Longer lists of coordinates end in dots.
const MOST_LISTED: usize = 6;

impl Elaborator<'_> {
    /// The coordinates that a statement is about: their family, and the members that it names.
    fn concerned(&mut self, binding: &Binding) -> Option<(usize, Members)> {
        let name = &binding.name;
        let entity = self.world.names.get(name.text.as_str()).map(|(entity, _)| *entity);
        let Some(entity @ Entity::Coordinate(family)) = entity else {
            let known = self.world.coordinate_families.iter().map(|family| family.name.as_str());
            let nearest = Meant::near(&name.text, known.filter(|_| entity.is_none()));
            let names = self.world.coordinate_families.iter().map(|family| format!("`{}`", family.name));
            let more = (self.world.coordinate_families.len() > MOST_LISTED).then(|| "…".to_owned());
            let coordinates = names.take(MOST_LISTED).chain(more).collect::<Vec<_>>().join(", ");
            let name = name.text.to_string();
            return self.refuse(ModelError::NotACoordinate { name, span: binding.name.span, nearest, coordinates });
        };
        // What members there are is not known where the declaration has a mistake of its own.
        let grid = &self.world.coordinate_families[family].grid;
        if self.world.broken.contains(&entity) && grid.numbers().next().is_none() {
            return None;
        }
        let rank = grid.rank;
        let members = self.members(binding.indices.as_deref(), name)?;
        if members.rank > rank {
            let what = format!("`{}`", name.text);
            return self.refuse(ModelError::TooManyIndices { what, available: rank, span: members.span });
        }
        Some((family, members))
    }

    /// The generalised forces of a statement, as families of terms; `acted` tells on which coordinates others act already.
    pub(super) fn force(&mut self, binding: &Binding, acted: &mut HashMap<u32, Span>) -> Option<Vec<TermFamily>> {
        let root = binding.value?;
        let (family, members) = self.concerned(binding)?;
        let before = self.errors.len();
        let program = self.compiler().value(root, &mut members.scope.clone());
        let factor = self.unit_factor(binding.unit, &program);
        if self.errors.len() > before {
            return None;
        }
        let on = Entity::Coordinate(family);
        // A list without an index gives the members one by one.
        let is_list = matches!(self.file.expr(root).kind, ExprKind::Vector(_)) && members.rank == 1 && !members.named;
        let listed = members.block.as_ref().filter(|_| is_list).map(|block| block.keys().collect::<Vec<Key>>());
        let indices = binding.indices.as_deref();
        let found = forces(&mut self.compiler(), root, on, indices, listed.as_deref(), factor);
        let found = self.note(found)?;
        self.check_accelerations(&found, root, "a force");
        let span = binding.name.span;
        let own = found.iter().flat_map(|family| {
            (0..family.count).filter_map(|at| family.coordinates_of(at).get(family.acts_on?).copied())
        });
        for number in own.distinct() {
            if let Some(first) = acted.insert(number, span) {
                let name = format!("the force on {}", self.world.coordinates.at(number as usize).name());
                return self.refuse(ModelError::GivenTwice { name, help: None, span, first });
            }
        }
        Some(found)
    }

    /// `guess`, `equilibrium` and rates: one list of values per coordinate.
    pub(super) fn given(&mut self, binding: &Binding, what: &'static str, into: &mut Givens) {
        let Some(root) = binding.value else { return };
        let Some((family, members)) = self.concerned(binding) else { return };
        let before = self.errors.len();
        let mut scope = members.scope.clone();
        let program = self.compiler().value(root, &mut scope);
        // Without a unit of its own the statement is in the coordinate's.
        let factor = match binding.unit {
            Some(_) => self.unit_factor(binding.unit, &program),
            None => self.world.coordinate_units[family].filter(|_| !reads_names(&program)),
        };
        if self.errors.len() > before {
            return;
        }
        let keys = members.keys();
        for (position, at) in keys.iter().enumerate() {
            let Some(value) = self.value_of(&program, &at[..members.rank]) else { return };
            let value = match (&value, members.named) {
                // A list without an index gives the members one by one.
                (Value::Vector(parts), false)
                    if members.rank == 1 && members.block.is_some() && parts.len() == keys.len() =>
                {
                    parts[position].clone()
                }
                (Value::Vector(_), false) if members.block.is_some() && self.shape_fits(&value, &members) => {
                    Value::Scalar(value.scalars()[position])
                }
                (Value::Vector(_) | Value::Scalar(_) | Value::Zero, _) => value,
            };
            let at = &at[..members.rank];
            if self.assign(family, at, &value, factor, what, members.span, program.span, into).is_none() {
                return;
            }
        }
    }

    #[allow(clippy::too_many_arguments)] // one assignment with all its places
    pub(super) fn assign(
        &mut self,
        family: usize,
        at: &[i64],
        value: &Value,
        factor: Option<ExprId>,
        what: &'static str,
        span: Span,
        value_span: Span,
        into: &mut Givens,
    ) -> Option<()> {
        let own = &self.world.coordinate_families[family];
        let rank = own.grid.rank;
        if at.len() < rank {
            let Some((from, to)) = own.grid.bounds(at) else {
                let error = own.out_of_range(at, span);
                return self.refuse(error);
            };
            let count = usize::try_from(to - from + 1).unwrap_or(0);
            if let Value::Vector(parts) = value
                && parts.len() != count
            {
                let name = member_name(&own.name, at.len(), &key(at));
                let (expected, found) = (count, parts.len());
                return self.refuse(ModelError::ListLength { name, expected, found, span: value_span });
            }
            return (from..=to).enumerate().try_for_each(|(i, index)| {
                let mut deeper = at.to_vec();
                deeper.push(index);
                let part = if let Value::Vector(parts) = value { &parts[i] } else { value };
                self.assign(family, &deeper, part, factor, what, span, value_span, into)
            });
        }
        let Some(number) = own.grid.find(&key(at)) else {
            let error = own.out_of_range(&at[..rank], span);
            return self.refuse(error);
        };
        let symbolic = self.one_scalar(value, &format!("{what} of a coordinate"), value_span)?;
        let name = self.world.coordinates.at(number).name();
        if let Some(on) = self.world.varying_symbol(symbolic) {
            return self.refuse(ModelError::NotConstant { what: format!("{what} of `{name}`"), on, span: value_span });
        }
        let symbolic = self.scaled(symbolic, factor);
        if let Some(first) = into.get(number) {
            let (name, first) = (format!("{what} of {name}"), first.span);
            return self.refuse(ModelError::GivenTwice { name, help: None, span, first });
        }
        let value = self.world.closed(symbolic);
        into.set(number, Some(Given { symbolic, value, span: span.to(value_span) }));
        Some(())
    }
}
