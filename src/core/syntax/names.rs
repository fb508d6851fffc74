//! Where the names of a file stand, and which belong together: what an editor needs to find a declaration or to rename.

use super::ast::{Binding, ExprKind, ExprRef, File, IndexKind, Indices, Name, StatementKind, UnitKind, UnitRef};
use crate::order::Gather;
use crate::span::Span;

/// What a name is the name of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum NameKind<'f> {
    /// A parameter, coordinate, named expression or table, or something that is not declared.
    Quantity,
    /// The index of a sum or a binding, with the statement or sum that it belongs to.
    Index(Span),
    /// A column, of this table where that can be told.
    Column(Option<&'f str>),
    /// A function.
    Function,
    /// A unit.
    Unit,
    /// The model.
    Model,
}

/// One place of a name. Places with the same text and kind are of the same thing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[non_exhaustive]
pub struct NamePlace<'f> {
    /// Where it stands.
    pub span: Span,
    /// The letters.
    pub text: &'f str,
    /// What it names.
    pub kind: NameKind<'f>,
    /// Whether it is declared here, or given a piece of its definition.
    pub is_declaration: bool,
}

/// All names of a file, in the order of their places.
///
/// ```
/// use librate::syntax::{names, parse};
/// let file = parse("param k = 2  coord x  V = sum(i in 1..2, i*k*x^2)")?;
/// let all: Vec<&str> = names(&file).iter().map(|name| name.text).collect();
/// assert_eq!(all, ["k", "x", "i", "i", "k", "x"]);
/// # Ok::<(), Vec<librate::syntax::SyntaxError>>(())
/// ```
#[must_use]
pub fn names(file: &File) -> Vec<NamePlace<'_>> {
    let mut finder = Finder { file, scopes: Vec::new(), todo: Vec::new(), found: Vec::new() };
    for statement in &file.statements {
        finder.statement(&statement.kind, statement.span);
    }
    // Several names may share a value or a unit.
    finder.found.into_iter().distinct()
}

/// The indices of a binding or a sum, and the scope around them.
struct Scope<'f> {
    indices: &'f Indices,
    span: Span,
    outer: Option<usize>,
}

struct Finder<'f> {
    file: &'f File,
    scopes: Vec<Scope<'f>>,
    /// What is still to be read, in which scope.
    todo: Vec<(ExprRef, Option<usize>)>,
    found: Vec<NamePlace<'f>>,
}

impl<'f> Finder<'f> {
    fn statement(&mut self, kind: &'f StatementKind, span: Span) {
        match kind {
            StatementKind::Model { name } => self.place(name, NameKind::Model, true),
            StatementKind::Param(all) | StatementKind::Coord { declarations: all } => {
                all.iter().for_each(|own| self.binding(own, span, true));
            }
            StatementKind::Let(binding) => self.binding(binding, span, true),
            StatementKind::Force(binding)
            | StatementKind::Guess { binding, .. }
            | StatementKind::Equilibrium { binding, .. } => self.binding(binding, span, false),
            StatementKind::Constraint { indices, left, right } => {
                let scope = self.indices(indices.as_deref(), span, None);
                self.todo.extend([(*left, scope), (*right, scope)]);
            }
            StatementKind::Draw { indices, points, .. } => {
                let scope = self.indices(indices.as_deref(), span, None);
                self.todo.extend(points.iter().map(|own| (*own, scope)));
            }
            StatementKind::Assume(relations) => self.todo.extend(relations.iter().map(|own| (*own, None))),
            StatementKind::Kinetic(value)
            | StatementKind::Potential(value)
            | StatementKind::Lagrangian(value)
            | StatementKind::Dissipation(value)
            | StatementKind::Period(value) => self.todo.push((*value, None)),
            StatementKind::Table { name, .. } => self.place(name, NameKind::Quantity, true),
        }
        while let Some((at, scope)) = self.todo.pop() {
            self.expression(at, scope);
        }
    }

    fn place(&mut self, name: &'f Name, kind: NameKind<'f>, is_declaration: bool) {
        self.found.push(NamePlace { span: name.span, text: &name.text, kind, is_declaration });
    }

    fn binding(&mut self, binding: &'f Binding, span: Span, declares: bool) {
        self.place(&binding.name, NameKind::Quantity, declares);
        let scope = self.indices(binding.indices.as_deref(), span, None);
        self.unit(binding.unit);
        let values = binding.value.into_iter().chain(binding.uncertainty);
        self.todo.extend(values.map(|value| (value, scope)));
    }

    /// Opens a scope, if there are indices.
    fn indices(&mut self, indices: Option<&'f Indices>, span: Span, outer: Option<usize>) -> Option<usize> {
        let Some(indices) = indices else { return outer };
        let own = self.scopes.len();
        self.scopes.push(Scope { indices, span, outer });
        for entry in &indices.entries {
            match &entry.kind {
                IndexKind::Member(_) | IndexKind::Range { variable: None, .. } => {}
                IndexKind::Range { variable: Some(variable), .. } => self.place(variable, NameKind::Index(span), true),
                IndexKind::Rows { variable, table } => {
                    self.place(variable, NameKind::Index(span), true);
                    self.place(table, NameKind::Quantity, false);
                }
            }
        }
        self.todo.extend(indices.expressions().map(|at| (at, Some(own))));
        Some(own)
    }

    /// The scope in which a name is an index, and the table whose rows it runs over.
    fn index(&self, name: &str, mut scope: Option<usize>) -> Option<(Span, Option<&'f str>)> {
        while let Some(own) = scope.and_then(|at| self.scopes.get(at)) {
            let found = own.indices.entries.iter().find_map(|entry| match &entry.kind {
                IndexKind::Range { variable: Some(variable), .. } if *variable.text == *name => Some(None),
                IndexKind::Rows { variable, table } if *variable.text == *name => Some(Some(&*table.text)),
                IndexKind::Member(_) | IndexKind::Range { .. } | IndexKind::Rows { .. } => None,
            });
            if let Some(table) = found {
                return Some((own.span, table));
            }
            scope = own.outer;
        }
        None
    }

    fn expression(&mut self, at: ExprRef, scope: Option<usize>) {
        let expr = self.file.expr(at);
        let mut inner = scope;
        match expr.kind {
            ExprKind::Name("pi" | "t") => {}
            ExprKind::Name(text) => {
                let kind = self.index(text, scope).map_or(NameKind::Quantity, |(span, _)| NameKind::Index(span));
                self.found.push(NamePlace { span: expr.span, text, kind, is_declaration: false });
            }
            ExprKind::Field { base, field } => {
                let table = match self.file.expr(base).kind {
                    ExprKind::Name(row) => self.index(row, scope).and_then(|(_, table)| table),
                    ExprKind::Index { base, .. } => match self.file.expr(base).kind {
                        ExprKind::Name(table) => Some(table),
                        _ => None,
                    },
                    _ => None,
                };
                self.place(field, NameKind::Column(table), false);
            }
            ExprKind::Call { function, .. } => self.place(function, NameKind::Function, false),
            ExprKind::SumOver { indices, .. } | ExprKind::IntegralOver { indices, .. } => {
                inner = self.indices(Some(indices), expr.span, scope);
            }
            _ => {}
        }
        let mut children = Vec::new();
        self.file.children(at, &mut children);
        self.todo.extend(children.into_iter().map(|child| (child, inner)));
    }

    fn unit(&mut self, unit: Option<UnitRef>) {
        let mut todo: Vec<UnitRef> = unit.into_iter().collect();
        while let Some(at) = todo.pop() {
            let unit = self.file.unit(at);
            match unit.kind {
                UnitKind::One => {}
                UnitKind::Name(text) => {
                    let place = NamePlace { span: unit.span, text, kind: NameKind::Unit, is_declaration: false };
                    self.found.push(place);
                }
                UnitKind::Product(factors) => todo.extend(factors.iter().map(|(_, factor)| *factor)),
                UnitKind::Power { base, .. } => todo.push(base),
            }
        }
    }
}
