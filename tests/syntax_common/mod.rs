//! Trees without places, in one order, for comparing.
use librate::span::Span;
use librate::syntax::*;

/// The same file with all places at 0, comments dropped, and the arenas in the order in which
/// the statements use them.
pub(crate) fn strip_spans(file: &File) -> File {
    let mut copy = Copy {
        from: file,
        to: File::default(),
    };
    for statement in &file.statements {
        let kind = copy.statement(&statement.kind);
        copy.to.statements.push(Statement {
            span: Span::default(),
            kind,
        });
    }
    copy.to
}

struct Copy<'f> {
    from: &'f File,
    to: File,
}

fn name(name: &Name) -> Name {
    Name {
        text: name.text.clone(),
        span: Span::default(),
    }
}

impl Copy<'_> {
    fn statement(&mut self, kind: &StatementKind) -> StatementKind {
        match kind {
            StatementKind::Model { name: n } => StatementKind::Model { name: name(n) },
            StatementKind::Param(b) => StatementKind::Param(self.binding(b)),
            StatementKind::Let(b) => StatementKind::Let(self.binding(b)),
            StatementKind::Guess(b) => StatementKind::Guess(self.binding(b)),
            StatementKind::Equilibrium { binding, rate } => StatementKind::Equilibrium {
                binding: self.binding(binding),
                rate: *rate,
            },
            StatementKind::Coord { declarations } => StatementKind::Coord {
                declarations: declarations
                    .iter()
                    .map(|d| Declaration {
                        name: name(&d.name),
                        indices: d.indices.as_ref().map(|i| self.indices(i)),
                        unit: d.unit.map(|u| self.unit(u)),
                    })
                    .collect(),
            },
            StatementKind::Kinetic(e) => StatementKind::Kinetic(self.expr(*e)),
            StatementKind::Potential(e) => StatementKind::Potential(self.expr(*e)),
            StatementKind::Lagrangian(e) => StatementKind::Lagrangian(self.expr(*e)),
            StatementKind::Dissipation(e) => StatementKind::Dissipation(self.expr(*e)),
            StatementKind::Period(e) => StatementKind::Period(self.expr(*e)),
            StatementKind::Constraint {
                indices,
                left,
                right,
            } => StatementKind::Constraint {
                indices: indices.as_ref().map(|i| self.indices(i)),
                left: self.expr(*left),
                right: self.expr(*right),
            },
            StatementKind::Table { name: n, path, .. } => StatementKind::Table {
                name: name(n),
                path: path.clone(),
                path_span: Span::default(),
            },
        }
    }

    fn binding(&mut self, b: &Binding) -> Binding {
        Binding {
            name: name(&b.name),
            indices: b.indices.as_ref().map(|i| self.indices(i)),
            unit: b.unit.map(|u| self.unit(u)),
            value: b.value.map(|e| self.expr(e)),
            uncertainty: b.uncertainty.map(|e| self.expr(e)),
        }
    }

    fn indices(&mut self, indices: &Indices) -> Indices {
        Indices {
            span: Span::default(),
            entries: indices
                .entries
                .iter()
                .map(|entry| IndexEntry {
                    span: Span::default(),
                    kind: match &entry.kind {
                        IndexKind::Member(e) => IndexKind::Member(self.expr(*e)),
                        IndexKind::Range { variable, from, to } => IndexKind::Range {
                            variable: variable.as_ref().map(name),
                            from: self.expr(*from),
                            to: self.expr(*to),
                        },
                        IndexKind::Rows { variable, table } => IndexKind::Rows {
                            variable: name(variable),
                            table: name(table),
                        },
                    },
                })
                .collect(),
            filter: indices.filter.map(|e| self.expr(e)),
        }
    }

    fn unit(&mut self, at: UnitRef) -> UnitRef {
        let kind = match &self.from.unit(at).kind {
            UnitKind::One => UnitKind::One,
            UnitKind::Name(n) => UnitKind::Name(n.clone()),
            UnitKind::Product(factors) => UnitKind::Product(
                factors
                    .iter()
                    .map(|(divided, unit)| (*divided, self.unit(*unit)))
                    .collect(),
            ),
            UnitKind::Power {
                base,
                numerator,
                denominator,
            } => UnitKind::Power {
                base: self.unit(*base),
                numerator: *numerator,
                denominator: *denominator,
            },
        };
        self.to.units.push(Unit {
            span: Span::default(),
            kind,
        });
        UnitRef(self.to.units.len() as u32 - 1)
    }

    fn exprs(&mut self, list: &[ExprRef]) -> Vec<ExprRef> {
        list.iter().map(|e| self.expr(*e)).collect()
    }

    fn expr(&mut self, at: ExprRef) -> ExprRef {
        let kind = match &self.from.expr(at).kind {
            ExprKind::Number(text) => ExprKind::Number(text.clone()),
            ExprKind::Name(text) => ExprKind::Name(text.clone()),
            ExprKind::Index { base, indices } => ExprKind::Index {
                base: self.expr(*base),
                indices: self.exprs(indices),
            },
            ExprKind::Field { base, field } => ExprKind::Field {
                base: self.expr(*base),
                field: name(field),
            },
            ExprKind::Prime(e) => ExprKind::Prime(self.expr(*e)),
            ExprKind::Negate(e) => ExprKind::Negate(self.expr(*e)),
            ExprKind::Power { base, exponent } => ExprKind::Power {
                base: self.expr(*base),
                exponent: self.expr(*exponent),
            },
            ExprKind::Product(factors) => ExprKind::Product(
                factors
                    .iter()
                    .map(|f| Factor {
                        divided: f.divided,
                        value: self.expr(f.value),
                    })
                    .collect(),
            ),
            ExprKind::Sum(terms) => ExprKind::Sum(
                terms
                    .iter()
                    .map(|t| Term {
                        subtracted: t.subtracted,
                        value: self.expr(t.value),
                    })
                    .collect(),
            ),
            ExprKind::Call {
                function,
                arguments,
            } => ExprKind::Call {
                function: name(function),
                arguments: self.exprs(arguments),
            },
            ExprKind::SumOver { indices, body } => ExprKind::SumOver {
                indices: self.indices(indices),
                body: self.expr(*body),
            },
            ExprKind::Vector(list) => ExprKind::Vector(self.exprs(list)),
            ExprKind::Compare {
                operator,
                left,
                right,
            } => ExprKind::Compare {
                operator: *operator,
                left: self.expr(*left),
                right: self.expr(*right),
            },
            ExprKind::Not(e) => ExprKind::Not(self.expr(*e)),
            ExprKind::And(list) => ExprKind::And(self.exprs(list)),
            ExprKind::Or(list) => ExprKind::Or(self.exprs(list)),
        };
        self.to.expressions.push(Expr {
            span: Span::default(),
            kind,
        });
        ExprRef(self.to.expressions.len() as u32 - 1)
    }
}
