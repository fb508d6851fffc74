//! Reading declared quantities: members, slices and families, and writing out the members of
//! `let` families.

use std::sync::Arc;

use super::ModelError;
use super::instance::{Along, Instance, Leaf, key_of};
use super::names::{Entity, Key, LetPiece, Progress, World};
use super::run::{DEEPEST_LET, Stop};
use super::values::{Value, filled};
use crate::span::Span;

impl World {
    fn out_of_range(&self, entity: Entity, at: &[i64], span: Span) -> Stop {
        let Some(family) = self.family(entity) else { return Stop::WriteOut };
        let mut error = family.out_of_range(at, span);
        if let (Entity::Coordinate(_) | Entity::Let(_), ModelError::IndexOutOfRange { help, .. }) = (entity, &mut error)
        {
            *help = help.take().or_else(|| family.fixed_end(at, matches!(entity, Entity::Let(_))));
        }
        error.into()
    }

    /// The first and the last value of the index behind those that are there.
    fn bounds(&self, entity: Entity, at: &[i64], span: Span) -> Result<(i64, i64), Stop> {
        let bounds = self.family(entity).and_then(|family| family.grid.bounds(at));
        bounds.ok_or_else(|| self.out_of_range(entity, at, span))
    }

    /// The number of a parameter or coordinate, which has no components.
    fn number_of(&self, entity: Entity, at: &Key, has_more: bool, span: Span) -> Result<usize, Stop> {
        let family = self.family(entity).ok_or(Stop::WriteOut)?;
        let rank = family.grid.rank;
        if has_more {
            let what = format!("`{}`", family.name);
            return Err(Stop::from(ModelError::TooManyIndices { what, available: rank, span }));
        }
        family.grid.find(at).ok_or_else(|| self.out_of_range(entity, &at[..rank], span))
    }

    /// The value of a member, a slice or a family; 0 in a light run, which finds out only what fills the slots of an instance.
    pub(super) fn read(
        &mut self,
        entity: Entity,
        at: &[Along],
        span: Span,
        mut instance: Option<&mut Instance>,
        is_light: bool,
    ) -> Result<Value, Stop> {
        if self.broken.contains(&entity) {
            return Err(Stop::from(ModelError::FollowOn {}));
        }
        let rank = self.family(entity).map_or(0, |family| family.grid.rank);
        let (indices, rest) = at.split_at(at.len().min(rank));
        let own = key_of(indices);
        if let (Some(instance), Some(family)) = (&mut instance, self.family(entity)) {
            instance.limit(family.grid.steady(indices));
        }
        if at.len() < rank {
            let (from, to) = self.bounds(entity, &own[..at.len()], span)?;
            if let Some(instance) = &mut instance {
                instance.note(to - from);
            }
            let mut deeper = [Along::default(); 3];
            deeper[..at.len()].copy_from_slice(at);
            let mut parts = Vec::new();
            for index in from..=to {
                deeper[at.len()].value = index;
                let part = self.read(entity, &deeper[..=at.len()], span, instance.as_deref_mut(), is_light)?;
                parts.extend((!is_light).then_some(part));
            }
            return Ok(Value::Vector(filled(parts)));
        }
        match entity {
            Entity::Parameter(family) => {
                let number = self.number_of(entity, &own, !rest.is_empty(), span)?;
                match (instance, self.parameters.get(number)) {
                    // A parameter without indices is the same for all instances.
                    (Some(instance), _) if rank > 0 => {
                        let growth = self.parameter_families[family].grid.growth(indices);
                        let slot = instance.slot(Leaf::Parameter(number), growth);
                        Ok(if is_light { Value::Zero } else { Value::Scalar(self.value_slot(slot)) })
                    }
                    (_, Some(parameter)) => Ok(Value::Scalar(parameter.symbolic)),
                    // A member of the family that is being worked out.
                    (_, None) => Err(self.parameter_families[family].recursive(&own, span).into()),
                }
            }
            Entity::Coordinate(family) => {
                let number = self.number_of(entity, &own, !rest.is_empty(), span)?;
                let symbol = match instance {
                    Some(instance) => {
                        let growth = self.coordinate_families[family].grid.growth(indices);
                        let slot = instance.slot(Leaf::Coordinate(number), growth);
                        if is_light {
                            return Ok(Value::Zero);
                        }
                        self.coordinate_slot(slot)[0]
                    }
                    None => self.coordinates.at(number).symbol,
                };
                Ok(Value::Scalar(self.pool.symbol_expr(symbol)))
            }
            Entity::Let(family) => {
                let value = match &mut instance {
                    Some(instance) if rank > 0 => {
                        let mut slots = own[..rank].to_vec();
                        let mut steps: Vec<i64> = indices.iter().map(|index| index.step).collect();
                        let (number, piece) = self.let_piece(family, &own, span)?;
                        let program = Arc::clone(&piece.program);
                        if piece.filter.as_ref().is_some_and(|filter| filter.moves(&steps)) {
                            instance.limit(0);
                        }
                        instance.note(i64::try_from(number).unwrap_or(i64::MAX));
                        if is_light {
                            self.run_light(&program, &mut slots, &mut steps, instance).map(|()| Value::Zero)?
                        } else {
                            self.run(&program, &mut slots, Some(instance))?
                        }
                    }
                    Some(_) if is_light => Value::Zero,
                    Some(_) | None => self.let_member(family, own, span)?,
                };
                rest.iter().for_each(|index| instance.iter_mut().for_each(|own| own.note_index(*index)));
                component(value, rest.iter().map(|index| index.value), span)
            }
            Entity::Table(_) => Err(Stop::WriteOut),
        }
    }

    /// The piece of a `let` family that gives a member, to be run with slots, and its number.
    fn let_piece(&self, family: usize, at: &Key, span: Span) -> Result<(usize, &LetPiece), Stop> {
        let own = &self.lets[family];
        if own.recursive || own.depth > DEEPEST_LET {
            return Err(Stop::WriteOut);
        }
        let (number, piece) = self.piece_of(family, at, span)?;
        if piece.list { Err(Stop::WriteOut) } else { Ok((number, piece)) }
    }

    /// The piece of a `let` family that has a member, and its number.
    fn piece_of(&self, family: usize, at: &Key, span: Span) -> Result<(usize, &LetPiece), Stop> {
        let own = &self.lets[family];
        let indices = &at[..own.family.grid.rank];
        let missing = || self.out_of_range(Entity::Let(family), indices, span);
        let number = own.family.grid.find_by(at, |block| block.base).ok_or_else(missing)?;
        let piece = own.pieces.get(number).ok_or_else(missing)?;
        match &piece.filter {
            Some(filter) if !self.holds(filter, indices)? => Err(missing()),
            Some(_) | None => Ok((number, piece)),
        }
    }

    /// A member of a `let` family, written out.
    pub(super) fn let_member(&mut self, family: usize, at: Key, span: Span) -> Result<Value, Stop> {
        if let Some(value) = self.lets[family].members.get(&at) {
            return Ok(value.clone());
        }
        if self.lets[family].recursive {
            self.write_out_up_to(family, at, span)?;
            let value = self.lets[family].members.get(&at).cloned();
            let rank = self.lets[family].family.grid.rank;
            return value.ok_or_else(|| self.out_of_range(Entity::Let(family), &at[..rank], span));
        }
        self.write_out_member(family, at, span)
    }

    /// Writes out a member of a `let` family and remembers it.
    fn write_out_member(&mut self, family: usize, at: Key, span: Span) -> Result<Value, Stop> {
        let own = &self.lets[family];
        let rank = own.family.grid.rank;
        let (piece, found) = self.piece_of(family, &at, span)?;
        let (program, list) = (Arc::clone(&found.program), found.list);
        let block = own.family.grid.blocks.iter().find(|block| block.base == piece).cloned();
        let mut slots = at[..rank].to_vec();
        let mut value = self.run(&program, &mut slots, None)?;
        if let Some(block) = block.filter(|_| list) {
            for (axis, index) in at.iter().take(rank).enumerate() {
                let Value::Vector(parts) = &value else { break };
                let place = usize::try_from(index - block.lower[axis]).ok();
                let Some(part) = place.filter(|_| parts.len() == block.extent(axis)).and_then(|i| parts.get(i)) else {
                    break;
                };
                value = part.clone();
            }
        }
        self.lets[family].members.insert(at, value.clone());
        Ok(value)
    }

    /// Writes out the members of a recursive family in ascending order, up to one.
    fn write_out_up_to(&mut self, family: usize, at: Key, span: Span) -> Result<(), Stop> {
        if self.lets[family].progress.is_none() {
            let order = self.lets[family].family.grid.keys();
            self.lets[family].progress = Some(Progress { order, done: 0, current: None, failed: false });
        }
        loop {
            let own = &mut self.lets[family];
            let Some(progress) = own.progress.as_mut() else { return Ok(()) };
            if let Some(current) = progress.current {
                // A member that is being written out asks for one that comes later, or for itself.
                return if at >= current { Err(own.family.recursive(&current, span).into()) } else { Ok(()) };
            }
            if progress.failed {
                return Err(Stop::from(ModelError::FollowOn {}));
            }
            let Some(next) = progress.order.get(progress.done).copied() else { return Ok(()) };
            if next > at {
                return Ok(());
            }
            progress.done += 1;
            if own.members.contains_key(&next) {
                continue;
            }
            progress.current = Some(next);
            let written = self.write_out_member(family, next, span);
            if let Some(progress) = self.lets[family].progress.as_mut() {
                progress.current = None;
                progress.failed = written.is_err();
            }
            written?;
        }
    }

    /// Writes out all members of a `let` family.
    pub(super) fn write_out_all(&mut self, family: usize, span: Span) -> Result<(), ModelError> {
        for at in self.lets[family].family.grid.keys() {
            self.let_member(family, at, span).map_err(|stop| stop.written_out(span))?;
        }
        Ok(())
    }
}

pub(super) fn component(mut value: Value, at: impl IntoIterator<Item = i64>, span: Span) -> Result<Value, Stop> {
    for index in at {
        let mut parts = match value {
            Value::Vector(parts) => parts,
            Value::Zero => return Ok(Value::Zero),
            Value::Scalar(_) => {
                return Err(Stop::from(ModelError::TooManyIndices { what: "a number".to_owned(), available: 0, span }));
            }
        };
        let count = parts.len();
        value = match usize::try_from(index) {
            Ok(i) if (1..=count).contains(&i) => parts.swap_remove(i - 1),
            _ => {
                let (member, available) = (format!("[{index}]"), format!("the vector has the components 1..{count}"));
                let (help, declared) = (None, None);
                return Err(Stop::from(ModelError::IndexOutOfRange { help, member, available, span, declared }));
            }
        };
    }
    Ok(value)
}
