//! `let` statements: pieces of families and the members they have.

use std::collections::HashMap;
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
use crate::span::Span;
use crate::syntax::{Binding, Name};

impl Elaborator<'_> {
    pub(super) fn named_expression(&mut self, binding: &Binding) {
        let name = &binding.name;
        let Some(root) = binding.value else { return };
        let Some(known) = self.known_let(binding) else {
            return;
        };
        let before = self.errors.len();
        let members = self.members(binding.indices.as_deref(), name);
        let rank = binding.indices.as_ref().map_or(0, |i| i.entries.len().min(3));
        let number = known.unwrap_or_else(|| self.new_let(name, rank));
        let mut scope = members.as_ref().map_or_else(Scope::default, |members| members.scope.clone());
        let additive = is_additive(self.file, &self.world, root);
        let mut compiler = self.compiler();
        compiler.current_let = Some(number);
        if rank == 0 && mentions(compiler.file, root, &name.text) {
            compiler
                .errors
                .push(ModelError::RecursiveLet { name: name.text.to_string(), span: compiler.file.expr(root).span });
        }
        let program = if compiler.errors.len() > before && rank == 0 {
            Program::default()
        } else {
            compiler.value(root, &mut scope)
        };
        let mut program = program;
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

    /// The family that a binding adds to, if that is not a new one; `None` where the name is given twice.
    fn known_let(&mut self, binding: &Binding) -> Option<Option<usize>> {
        let name = &binding.name;
        match self.world.names.get(name.text.as_str()).copied() {
            Some((Entity::Let(family), _))
                if binding.indices.is_some() && self.world.lets[family].family.grid.rank > 0 =>
            {
                Some(Some(family))
            }
            Some((_, first)) => {
                self.errors.push(ModelError::GivenTwice { name: name.text.to_string(), span: name.span, first });
                None
            }
            None => Some(None),
        }
    }

    fn new_let(&mut self, name: &Name, rank: usize) -> usize {
        let number = self.world.lets.len();
        let grid = Grid { rank, ..Default::default() };
        self.world.lets.push(LetFamily {
            family: Family { name: name.text.to_string(), span: name.span, grid },
            pieces: Vec::new(),
            members: HashMap::new(),
            recursive: false,
            depth: 0,
            cost: 0,
            progress: None,
        });
        if rank > 0 {
            // A member may use lower ones.
            self.introduce(name, Entity::Let(number));
        }
        number
    }

    pub(super) fn add_let_members(&mut self, number: usize, piece: usize, members: &Members, name: &Name) -> bool {
        let own = &mut self.world.lets[number];
        // Members written out before this piece came may be followed by lower ones now.
        own.progress = None;
        if own.family.grid.rank != members.rank {
            let what = format!(
                "`{}` was given with {} before",
                name.text,
                super::error::counted_indices(own.family.grid.rank)
            );
            self.errors.push(ModelError::BadIndices { what, span: members.span });
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
}
