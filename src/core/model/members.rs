//! The members of families: the indices of a binding, and the shapes and units of its right side.

use super::compile::Scope;
use super::elaborate::Elaborator;
use super::names::{Block, Key, key};
use super::program::{Binder, IndexOp, IndexProgram, Op, Program};
use super::survey::mentions;
use super::values::Value;
use super::{ModelError, units};
use crate::diagnostic::Meant;
use crate::expr::ExprId;
use crate::span::Span;
use crate::syntax::{ExprRef, IndexEntry, IndexKind, Indices, Name, UnitRef, print_expr};

/// More members than this in one family are refused.
const MOST_MEMBERS: usize = 20_000_000;

/// The indices of a binding, compiled: where the members are.
#[derive(Default)]
pub(super) struct Members {
    pub(super) rank: usize,
    /// A full box, or the members one by one.
    pub(super) block: Option<Block>,
    pub(super) keys: Vec<Key>,
    pub(super) filter: Option<IndexProgram>,
    pub(super) scope: Scope,
    /// Whether the right side may name an index.
    pub(super) named: bool,
    pub(super) span: Span,
}

impl Members {
    /// Their indices, in the order of numbering.
    pub(super) fn keys(&self) -> Vec<Key> {
        self.block.as_ref().map_or_else(|| self.keys.clone(), |block| block.keys().collect())
    }

    /// How many members there are.
    pub(super) fn count(&self) -> usize {
        self.block.as_ref().map_or(self.keys.len(), Block::len)
    }
}

/// Whether a program names a declared quantity: a parameter, a coordinate or a `let`.
pub(super) fn reads_names(program: &Program) -> bool {
    let mut todo = vec![program];
    while let Some(program) = todo.pop() {
        for (op, _) in &program.ops {
            match op {
                Op::Read { .. } => return true,
                Op::SumOver(sum) => todo.push(&sum.body),
                Op::Integral(_, body) => todo.push(body),
                Op::Number(number) if number.ops.iter().any(|(op, _)| matches!(op, IndexOp::Parameter { .. })) => {
                    return true;
                }
                _ => {}
            }
        }
    }
    false
}

impl Elaborator<'_> {
    /// Compiles the indices of a binding and finds its members.
    pub(super) fn members(&mut self, indices: Option<&Indices>, name: &Name) -> Option<Members> {
        let before = self.errors.len();
        let mut scope = Scope::default();
        let Some(indices) = indices else {
            return Some(Members { keys: vec![[0; 3]], span: name.span, ..Members::default() });
        };
        let rank = indices.entries.len();
        if rank > 3 {
            let what = "a family has at most three indices".to_owned();
            return self.refuse(ModelError::BadIndices { what, span: indices.span });
        }
        let (binders, filter) = self.compiler().binders(indices, &mut scope);
        if self.errors.len() > before {
            if let Some(unit) = self.unit_in_brackets(indices) {
                self.errors.truncate(before);
                let meant = Meant::guess(format!("{} : {unit}", name.text));
                self.errors.push(ModelError::undeclared(&unit, Some(meant), name.span.to(indices.span)));
            }
            return None;
        }
        let named = scope.variables.iter().any(|(name, _)| !name.is_empty());
        let mut members =
            Members { rank, block: None, keys: Vec::new(), filter, scope, named, span: name.span.to(indices.span) };
        let single = indices.entries.iter().all(|entry| matches!(entry.kind, IndexKind::Member(_)));
        let rectangular = binders.iter().all(Binder::is_fixed);
        if rectangular && !single {
            let block = self.block(&binders, members.span)?;
            if members.filter.is_none() {
                members.block = Some(block);
                return Some(members);
            }
        }
        let filters: Vec<(usize, &IndexProgram)> = members.filter.iter().map(|filter| (rank, filter)).collect();
        let mut keys = Vec::new();
        let found =
            self.world.instances::<ModelError>(&binders, &filters, &mut Vec::new(), members.span, |_, slots| {
                keys.push(key(slots));
                Ok(())
            });
        self.note(found)?;
        members.keys = keys;
        Some(members)
    }

    /// The unit that stands in the place of an index: `param m [kg] = 2`.
    fn unit_in_brackets(&self, indices: &Indices) -> Option<String> {
        let [IndexEntry { kind: IndexKind::Member(at), .. }] = &*indices.entries else { return None };
        let is_unit = !mentions(self.file, *at, |own| units::unit_dimension(own).is_none());
        is_unit.then(|| print_expr(self.file, *at))
    }

    pub(super) fn block(&mut self, binders: &[Binder], span: Span) -> Option<Block> {
        let mut block = Block { lower: [0; 3], upper: [0; 3], base: 0, span };
        for (axis, binder) in binders.iter().enumerate() {
            let range = self.world.binder_range(binder, &[]);
            let (from, to) = self.note(range)?;
            block.lower[axis] = from;
            block.upper[axis] = to.max(from - 1);
        }
        let count = (0..binders.len()).try_fold(1_usize, |count, axis| count.checked_mul(block.extent(axis)));
        if count.is_none_or(|count| count > MOST_MEMBERS) {
            return self.refuse(ModelError::TooLarge { count: format!("more than {MOST_MEMBERS} members"), span });
        }
        Some(block)
    }

    /// The factor of a unit.
    pub(super) fn factor(&mut self, unit: Option<UnitRef>) -> Option<ExprId> {
        let unit = unit?;
        self.has_units = true;
        Some(units::factor(&mut self.world.pool, self.file, unit, &mut self.errors))
    }

    /// The same where the right side is in that unit: where it names no quantity.
    pub(super) fn unit_factor(&mut self, unit: Option<UnitRef>, program: &Program) -> Option<ExprId> {
        self.factor(unit).filter(|_| !reads_names(program))
    }

    /// The programs of some expressions, if none of them has a mistake.
    pub(super) fn compiled(&mut self, all: &[ExprRef], scope: &Scope) -> Option<Vec<Program>> {
        let before = self.errors.len();
        let programs = all.iter().map(|at| self.compiler().value(*at, &mut scope.clone())).collect();
        (self.errors.len() == before).then_some(programs)
    }

    /// The value of a program for some values of its indices.
    pub(super) fn value_of(&mut self, program: &Program, slots: &[i64]) -> Option<Value> {
        let value = self.world.run_written_out(program, &mut slots.to_vec());
        self.note(value)
    }

    /// The same of one that comes to a number.
    pub(super) fn number_of(&mut self, program: &Program, slots: &[i64], what: &str) -> Option<ExprId> {
        let value = self.value_of(program, slots)?;
        self.one_scalar(&value, what, program.span)
    }

    pub(super) fn one_scalar(&mut self, value: &Value, what: &str, span: Span) -> Option<ExprId> {
        value.scalar(what).map_err(|misfit| self.errors.push(ModelError::shape(misfit, span))).ok()
    }

    pub(super) fn scaled(&mut self, value: ExprId, factor: Option<ExprId>) -> ExprId {
        factor.map_or(value, |factor| self.world.pool.mul(factor, value))
    }
}
