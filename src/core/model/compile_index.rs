//! From syntax to index programs: indices, bounds and conditions.

use super::ModelError;
use super::compile::{Compiler, Scope, Task, apart};
use super::functions::{Builtin, check_count};
use super::names::Entity;
use super::program::{Field, IndexForm, IndexOp, IndexProgram};
use crate::number::Number;
use crate::span::Span;
use crate::syntax::{ExprKind, ExprRef, Name, print_expr};

impl Compiler<'_> {
    /// Compiles a condition behind `where`.
    pub(super) fn condition(&mut self, root: ExprRef, scope: &mut Scope) -> IndexProgram {
        self.index_ops(root, true, scope)
    }

    /// A condition or a number, whichever is expected; the other is refused.
    fn expected(&mut self, at: ExprRef, condition: bool) -> Task<IndexOp> {
        let kind = &self.file.expr(at).kind;
        if matches!(kind, ExprKind::Compare { .. } | ExprKind::Not(_) | ExprKind::And(_) | ExprKind::Or(_)) != condition
        {
            let what = if condition {
                "a condition is expected here, not a number"
            } else {
                "a number is expected here, not a condition"
            };
            let span = self.file.expr(at).span;
            self.fail(ModelError::ConditionOrValue { what, span });
            return Task::Emit(IndexOp::Broken, span);
        }
        Task::Visit(at)
    }

    /// Compiles an index, a bound, or a number made of such.
    pub(super) fn index(&mut self, root: ExprRef, scope: &mut Scope) -> IndexProgram {
        self.index_ops(root, false, scope)
    }

    fn index_ops(&mut self, root: ExprRef, condition: bool, scope: &mut Scope) -> IndexProgram {
        let file = self.file;
        let mut ops: Vec<(IndexOp, Span)> = Vec::new();
        let mut tasks = vec![self.expected(root, condition)];
        while let Some(task) = tasks.pop() {
            let at = match task {
                Task::Emit(op, span) => {
                    ops.push((op, span));
                    continue;
                }
                Task::Visit(at) => at,
            };
            let span = file.expr(at).span;
            let (op, children): (IndexOp, Vec<ExprRef>) = match &file.expr(at).kind {
                ExprKind::Number(text) => (IndexOp::Number(self.literal(text, span)), vec![]),
                ExprKind::Name(name) => (self.index_name(name, span, scope), vec![]),
                ExprKind::Index { .. } => self.indexed_parameter(at, scope),
                ExprKind::Field { base, field } => match self.field(*base, field, scope) {
                    Some(Field { table, row, column }) => {
                        // The row's program stands in front of the operation that pops its value.
                        ops.extend(row.ops);
                        (IndexOp::Field { table, column }, vec![])
                    }
                    None => (IndexOp::Broken, vec![]),
                },
                ExprKind::Negate(inner) => (IndexOp::Negate, vec![*inner]),
                ExprKind::Power { base, exponent } => (IndexOp::Power, vec![*base, *exponent]),
                ExprKind::Product(factors) => {
                    let (divided, children) = apart(factors);
                    (IndexOp::Product(divided), children)
                }
                ExprKind::Sum(terms) => {
                    let (subtracted, children) = apart(terms);
                    (IndexOp::Sum(subtracted), children)
                }
                ExprKind::Call { function, arguments } => self.index_call(function, arguments, span, scope),
                ExprKind::Compare { operator, left, right } => (IndexOp::Compare(*operator), vec![*left, *right]),
                ExprKind::Not(inner) => (IndexOp::Not, vec![*inner]),
                ExprKind::And(parts) => (IndexOp::And(parts.len()), parts.to_vec()),
                ExprKind::Or(parts) => (IndexOp::Or(parts.len()), parts.to_vec()),
                ExprKind::Prime(_) => (self.not_for_indices("a time derivative".to_owned(), span), vec![]),
                ExprKind::SumOver { .. } => (self.not_for_indices("a sum".to_owned(), span), vec![]),
                ExprKind::IntegralOver { .. } => (self.not_for_indices("an integral".to_owned(), span), vec![]),
                ExprKind::Vector(parts) => {
                    // `x[[i]]`
                    let written: Vec<String> = parts.iter().map(|own| print_expr(file, *own)).collect();
                    let (what, index) = ("a vector".to_owned(), Some(written.join(", ")));
                    self.fail(ModelError::NotForIndices { what, index, inside: None, span });
                    (IndexOp::Broken, vec![])
                }
            };
            let logical = matches!(op, IndexOp::Not | IndexOp::And(_) | IndexOp::Or(_));
            tasks.push(Task::Emit(op, span));
            tasks.extend(children.iter().rev().map(|child| self.expected(*child, logical)));
        }
        IndexProgram::new(ops, file.expr(root).span)
    }

    fn index_name(&mut self, name: &str, span: Span, scope: &Scope) -> IndexOp {
        match (scope.find(name), self.entity(name)) {
            (Some((slot, _)), _) => IndexOp::Variable(slot),
            (None, Some(Entity::Parameter(family))) => IndexOp::Parameter { family, indices: 0 },
            (None, Some(_)) => self.not_for_indices(format!("`{name}`"), span),
            (None, None) if scope.integrated(name).is_some() => self.not_for_indices(format!("`{name}`"), span),
            (None, None) if name == "pi" => IndexOp::Pi,
            (None, None) if name == "t" => self.not_for_indices("the time".to_owned(), span),
            (None, None) => {
                self.undeclared(name, &[], span, scope);
                IndexOp::Broken
            }
        }
    }

    fn indexed_parameter(&mut self, at: ExprRef, scope: &Scope) -> (IndexOp, Vec<ExprRef>) {
        let file = self.file;
        let (base, indices) = self.flatten_index(at);
        let ExprKind::Name(name) = &file.expr(base).kind else {
            return (self.not_for_indices("this".to_owned(), file.expr(at).span), vec![]);
        };
        match self.entity(name) {
            Some(Entity::Parameter(family)) => (IndexOp::Parameter { family, indices: indices.len() }, indices),
            Some(_) => (self.not_for_indices(format!("`{name}`"), file.expr(at).span), vec![]),
            None => {
                self.undeclared(name, &indices, file.expr(at).span, scope);
                (IndexOp::Broken, vec![])
            }
        }
    }

    fn not_for_indices(&mut self, what: String, span: Span) -> IndexOp {
        self.fail(ModelError::NotForIndices { what, index: None, inside: None, span });
        IndexOp::Broken
    }

    fn index_call(
        &mut self,
        function: &Name,
        arguments: &[ExprRef],
        span: Span,
        scope: &Scope,
    ) -> (IndexOp, Vec<ExprRef>) {
        let broken = || (IndexOp::Broken, Vec::new());
        let op = match function.text.as_str() {
            "mod" => IndexOp::Mod,
            "floor" => IndexOp::Floor,
            "sqrt" => IndexOp::Sqrt,
            "norm" => {
                // norm([a, b, c]) of numbers: the parts are the arguments here.
                if let [only] = arguments
                    && let ExprKind::Vector(parts) = &self.file.expr(*only).kind
                {
                    return (IndexOp::Norm(parts.len()), parts.to_vec());
                }
                return (self.not_for_indices("`norm` of this".to_owned(), span), Vec::new());
            }
            "rows" => {
                if let [only] = arguments
                    && let ExprKind::Name(name) = &self.file.expr(*only).kind
                {
                    if let Some(Entity::Table(table)) = self.entity(name) {
                        let rows = self.world.tables[table].rows();
                        let rows = i64::try_from(rows).unwrap_or(i64::MAX);
                        return (IndexOp::Number(Number::from(rows)), Vec::new());
                    }
                    if self.entity(name).is_none() {
                        let span = self.file.expr(*only).span;
                        self.undeclared_table(name, span, scope);
                        return broken();
                    }
                }
                let what = "`rows` counts the rows of a table".to_owned();
                let help = "write `rows(NAME)` with the name of a table".to_owned();
                self.fail(ModelError::shape((what, Some(help)), span));
                return broken();
            }
            name => match Builtin::from_name(name) {
                Some(Builtin::Elementary(function)) => IndexOp::Apply(function),
                Some(_) => return (self.not_for_indices(format!("`{name}`"), span), Vec::new()),
                None => {
                    self.unknown_function(function, arguments, span, scope);
                    return broken();
                }
            },
        };
        if let Some(error) = check_count(function, arguments.len(), span) {
            self.fail(error);
            return broken();
        }
        (op, arguments.to_vec())
    }
}

impl IndexProgram {
    /// A single operation.
    pub(super) fn of(op: IndexOp, span: Span) -> Self {
        Self::new(vec![(op, span)], span)
    }

    /// Operations as they stand.
    pub(super) fn new(ops: Vec<(IndexOp, Span)>, span: Span) -> Self {
        let form = match ops.as_slice() {
            [(IndexOp::Number(n), _)] => n.to_i64().map(IndexForm::Constant),
            [(IndexOp::Variable(slot), _)] => Some(IndexForm::Shifted { slot: *slot, shift: 0 }),
            [(IndexOp::Variable(slot), _), (IndexOp::Number(n), _), (IndexOp::Sum(signs), _)] => n
                .to_i64()
                .filter(|n| n.abs() < i64::MAX / 4)
                .map(|n| IndexForm::Shifted { slot: *slot, shift: if signs[1] { -n } else { n } }),
            [(IndexOp::Variable(slot), _), (IndexOp::Field { table, column }, _)] => {
                Some(IndexForm::RowField { table: *table, slot: *slot, column: *column })
            }
            _ => None,
        };
        Self { ops, form: form.unwrap_or(IndexForm::General), span }
    }
}
