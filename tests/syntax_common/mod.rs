//! Trees without places, in one order, for comparing.

use librate::span::Span;
use librate_core::syntax::*;

/// The same file with all places at 0, comments dropped, and the arenas in the order in which
/// the statements use them.
pub(crate) fn strip_spans(file: &File) -> File {
    copied(file, false)
}

fn copied(file: &File, keep: bool) -> File {
    let mut copy = Copy { from: file, to: File::default(), keep };
    for statement in &file.statements {
        let kind = copy.statement(&statement.kind);
        let span = copy.span(statement.span);
        copy.to.statements.push(Statement { span, kind });
    }
    copy.to
}

struct Copy<'f> {
    from: &'f File,
    to: File,
    keep: bool,
}

impl Copy<'_> {
    fn span(&self, span: Span) -> Span {
        if self.keep { span } else { Span::default() }
    }

    fn name(&self, name: &Name) -> Name {
        Name { text: name.text.clone(), span: self.span(name.span) }
    }

    fn statement(&mut self, kind: &StatementKind) -> StatementKind {
        match kind {
            StatementKind::Model { name: n } => StatementKind::Model { name: self.name(n) },
            StatementKind::Param(list) => StatementKind::Param(list.iter().map(|b| self.binding(b)).collect()),
            StatementKind::Let(b) => StatementKind::Let(self.binding(b)),
            StatementKind::Force(b) => StatementKind::Force(self.binding(b)),
            StatementKind::Guess { binding, rate } => {
                StatementKind::Guess { binding: self.binding(binding), rate: *rate }
            }
            StatementKind::Equilibrium { binding, rate } => {
                StatementKind::Equilibrium { binding: self.binding(binding), rate: *rate }
            }
            StatementKind::Coord { declarations } => {
                StatementKind::Coord { declarations: declarations.iter().map(|b| self.binding(b)).collect() }
            }
            StatementKind::Kinetic(e) => StatementKind::Kinetic(self.expr(*e)),
            StatementKind::Potential(e) => StatementKind::Potential(self.expr(*e)),
            StatementKind::Lagrangian(e) => StatementKind::Lagrangian(self.expr(*e)),
            StatementKind::Dissipation(e) => StatementKind::Dissipation(self.expr(*e)),
            StatementKind::Assume(list) => StatementKind::Assume(list.iter().map(|e| self.expr(*e)).collect()),
            StatementKind::Draw { drawn, indices, points } => StatementKind::Draw {
                drawn: *drawn,
                indices: indices.as_deref().map(|i| Box::new(self.indices(i))),
                points: points.iter().map(|e| self.expr(*e)).collect(),
            },
            StatementKind::Period(e) => StatementKind::Period(self.expr(*e)),
            StatementKind::Constraint { indices, left, right } => StatementKind::Constraint {
                indices: indices.as_deref().map(|i| Box::new(self.indices(i))),
                left: self.expr(*left),
                right: self.expr(*right),
            },
            StatementKind::Table { name: n, path, path_span } => {
                StatementKind::Table { name: self.name(n), path: path.clone(), path_span: self.span(*path_span) }
            }
        }
    }

    fn binding(&mut self, b: &Binding) -> Binding {
        Binding {
            name: self.name(&b.name),
            indices: b.indices.as_deref().map(|i| Box::new(self.indices(i))),
            unit: b.unit.map(|u| self.unit(u)),
            value: b.value.map(|e| self.expr(e)),
            uncertainty: b.uncertainty.map(|e| self.expr(e)),
        }
    }

    fn indices(&mut self, indices: &Indices) -> Indices {
        Indices {
            span: self.span(indices.span),
            entries: indices
                .entries
                .iter()
                .map(|entry| IndexEntry {
                    span: self.span(entry.span),
                    kind: match &entry.kind {
                        IndexKind::Member(e) => IndexKind::Member(self.expr(*e)),
                        IndexKind::Range { variable, from, to } => IndexKind::Range {
                            variable: variable.as_ref().map(|n| self.name(n)),
                            from: self.expr(*from),
                            to: self.expr(*to),
                        },
                        IndexKind::Rows { variable, table } => {
                            IndexKind::Rows { variable: self.name(variable), table: self.name(table) }
                        }
                    },
                })
                .collect(),
            filter: indices.filter.map(|e| self.expr(e)),
        }
    }

    fn unit(&mut self, at: UnitRef) -> UnitRef {
        let parts: Vec<(bool, UnitRef)>;
        let kind = match self.from.unit(at).kind {
            UnitKind::Product(factors) => {
                parts = factors.iter().map(|(divided, unit)| (*divided, self.unit(*unit))).collect();
                UnitKind::Product(&parts)
            }
            UnitKind::Power { base, numerator, denominator } => {
                UnitKind::Power { base: self.unit(base), numerator, denominator }
            }
            kind @ (UnitKind::One | UnitKind::Name(_)) => kind,
        };
        let span = self.span(self.from.unit(at).span);
        self.to.units.push(Unit { span, kind })
    }

    fn exprs(&mut self, list: &[ExprRef]) -> Vec<ExprRef> {
        list.iter().map(|e| self.expr(*e)).collect()
    }

    fn expr(&mut self, at: ExprRef) -> ExprRef {
        let list: Vec<ExprRef>;
        let factors: Vec<Member>;
        let terms: Vec<Member>;
        let indices_of_sum: Indices;
        let one_name: Name;
        let from = self.from.expr(at);
        let kind = match from.kind {
            ExprKind::Number(_) | ExprKind::Name(_) => from.kind,
            ExprKind::Index { base, indices } => {
                let base = self.expr(base);
                list = self.exprs(indices);
                let indices = &list;
                ExprKind::Index { base, indices }
            }
            ExprKind::Field { base, field } => {
                one_name = self.name(field);
                ExprKind::Field { base: self.expr(base), field: &one_name }
            }
            ExprKind::Prime(e) => ExprKind::Prime(self.expr(e)),
            ExprKind::Negate(e) => ExprKind::Negate(self.expr(e)),
            ExprKind::Power { base, exponent } => {
                ExprKind::Power { base: self.expr(base), exponent: self.expr(exponent) }
            }
            ExprKind::Product(members) => {
                factors = members.iter().map(|f| Member::new(f.inverted(), self.expr(f.value()))).collect();
                ExprKind::Product(&factors)
            }
            ExprKind::Sum(members) => {
                terms = members.iter().map(|t| Member::new(t.inverted(), self.expr(t.value()))).collect();
                ExprKind::Sum(&terms)
            }
            ExprKind::Call { function, arguments } => {
                one_name = self.name(function);
                list = self.exprs(arguments);
                ExprKind::Call { function: &one_name, arguments: &list }
            }
            ExprKind::SumOver { indices, body } => {
                indices_of_sum = self.indices(indices);
                ExprKind::SumOver { indices: &indices_of_sum, body: self.expr(body) }
            }
            ExprKind::IntegralOver { indices, body } => {
                indices_of_sum = self.indices(indices);
                ExprKind::IntegralOver { indices: &indices_of_sum, body: self.expr(body) }
            }
            ExprKind::Vector(members) => {
                list = self.exprs(members);
                ExprKind::Vector(&list)
            }
            ExprKind::Compare { operator, left, right } => {
                ExprKind::Compare { operator, left: self.expr(left), right: self.expr(right) }
            }
            ExprKind::Not(e) => ExprKind::Not(self.expr(e)),
            ExprKind::And(members) => {
                list = self.exprs(members);
                ExprKind::And(&list)
            }
            ExprKind::Or(members) => {
                list = self.exprs(members);
                ExprKind::Or(&list)
            }
        };
        let span = self.span(from.span);
        self.to.expressions.push(Expr { span, kind })
    }
}
