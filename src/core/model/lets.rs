//! `let` statements: pieces of families and the members they have.

use std::sync::Arc;

use super::ModelError;
use super::compile::Scope;
use super::elaborate::Elaborator;
use super::members::Members;
use super::names::{Entity, Family, Grid, Key, LetFamily, LetPiece, member_name};
use super::program::{Op, Program};
use super::run::{COSTLIEST_LET, DEEPEST_LET};
use super::survey::mentions;
use super::terms::is_additive;
use crate::syntax::{Binding, ExprKind, ExprRef, Name};

impl Elaborator<'_> {
    pub(super) fn named_expression(&mut self, binding: &Binding) {
        let name = &binding.name;
        let Some(root) = binding.value else { return };
        let is_let = |entity| if let Entity::Let(family) = entity { Some(family) } else { None };
        let Some(known) = self.known_family(binding, is_let) else { return };
        let before = self.errors.len();
        let members = self.members(binding.indices.as_deref(), name);
        let rank = binding.indices.as_ref().map_or(0, |i| i.entries.len().min(3));
        let number = known.unwrap_or_else(|| self.new_let(name, rank));
        let mut scope = members.as_ref().map_or_else(Scope::default, |members| members.scope.clone());
        let additive = is_additive(self.file, &self.world, root);
        let mut compiler = self.compiler();
        compiler.current_let = Some(number);
        if rank == 0 && mentions(compiler.file, root, |own| own == name.text.as_str()) {
            let span = compiler.file.expr(root).span;
            compiler.errors.push(ModelError::RecursiveLet { name: name.text.to_string(), through: None, span });
        }
        // Without indices nothing can be said of what is written in them.
        let mut program = if compiler.errors.len() > before && (rank == 0 || members.is_none()) {
            Program::default()
        } else {
            compiler.value(root, &mut scope)
        };
        let (recursive, depth, cost) = (compiler.recursive, compiler.depth, compiler.cost);
        if rank == 0 {
            self.introduce(name, Entity::Let(number));
        }
        if let Some(factor) = self.unit_factor(binding.unit, &program) {
            let span = program.span;
            program.ops.insert(0, (Op::Literal(factor), span));
            program.ops.push((Op::Product(Box::new([false, false])), span));
        }
        let span = program.span;
        if let Some(error) = members.as_ref().and_then(|members| self.list_length(name, members, root)) {
            self.errors.push(error);
        }
        let own = &mut self.world.lets[number];
        own.recursive |= recursive;
        own.depth = own.depth.max(depth + 1);
        own.cost = own.cost.max(cost.saturating_add(1));
        if own.cost > COSTLIEST_LET {
            own.depth = own.depth.max(DEEPEST_LET + 1);
        }
        let too_deep = own.depth > DEEPEST_LET;
        let piece = own.pieces.len();
        let named = members.as_ref().is_some_and(|members| members.named);
        let single = members.as_ref().is_some_and(|members| members.block.is_none());
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
            if let Some(value) = self.value_of(&program, &[]) {
                self.world.lets[number].members.insert([0; 3], value);
            }
            return;
        }
        let own = &mut self.world.lets[number];
        // Members written out before this piece came may be followed by lower ones now.
        own.progress = None;
        let added = own.family.add(&members, piece, true);
        if self.note(added).is_none() {
            return;
        }
        if too_deep {
            let written = self.world.write_out_all(number, span);
            self.note(written);
        }
    }

    /// The mistake of a list, or of one in a list, that has not one element for each value of its index.
    fn list_length(&self, name: &Name, members: &Members, root: ExprRef) -> Option<ModelError> {
        let block = members.block.as_ref().filter(|_| !members.named)?;
        let mut level = vec![([0; 3], root)];
        // A single member has no list of its own.
        for axis in (0..members.rank).filter(|axis| block.extent(*axis) > 1) {
            let mut parts = Vec::new();
            for (at, list) in level {
                let ExprKind::Vector(own) = self.file.expr(list).kind else { continue };
                let (expected, found) = (block.extent(axis), own.len());
                if found != expected {
                    let (name, span) = (member_name(&name.text, axis, &at), self.file.expr(list).span);
                    return Some(ModelError::ListLength { name, expected, found, span });
                }
                parts.extend((block.lower[axis]..).zip(own).map(|(index, part)| {
                    let mut deeper: Key = at;
                    deeper[axis] = index;
                    (deeper, *part)
                }));
            }
            level = parts;
        }
        None
    }

    fn new_let(&mut self, name: &Name, rank: usize) -> usize {
        let number = self.world.lets.len();
        let grid = Grid { rank, ..Default::default() };
        let family = Family { name: name.text.to_string(), span: name.span, grid };
        self.world.lets.push(LetFamily { family, ..LetFamily::default() });
        if rank > 0 {
            // A member may use lower ones.
            self.introduce(name, Entity::Let(number));
        }
        number
    }
}
