//! What statements and expressions are made of, so that no pass lists the forms that it passes over.
#![cfg_attr(
    not(all(feature = "engine", feature = "format")),
    allow(dead_code, reason = "each of the two walks over a part")
)]

use super::ast::{Binding, ExprKind, ExprRef, File, IndexKind, Indices, Name, StatementKind};

impl StatementKind {
    /// The name with its value that a statement gives, if it is of that form.
    pub(crate) fn binding(&self) -> Option<&Binding> {
        match self {
            Self::Param(binding)
            | Self::Let(binding)
            | Self::Guess { binding, .. }
            | Self::Equilibrium { binding, .. } => Some(binding),
            Self::Model { .. }
            | Self::Coord { .. }
            | Self::Kinetic(_)
            | Self::Potential(_)
            | Self::Lagrangian(_)
            | Self::Dissipation(_)
            | Self::Constraint { .. }
            | Self::Period(_)
            | Self::Table { .. } => None,
        }
    }

    /// The energy that a statement gives, or the dissipation function.
    pub(crate) fn energy(&self) -> Option<ExprRef> {
        match self {
            Self::Kinetic(value) | Self::Potential(value) | Self::Lagrangian(value) | Self::Dissipation(value) => {
                Some(*value)
            }
            Self::Model { .. }
            | Self::Param(_)
            | Self::Coord { .. }
            | Self::Let(_)
            | Self::Constraint { .. }
            | Self::Guess { .. }
            | Self::Equilibrium { .. }
            | Self::Period(_)
            | Self::Table { .. } => None,
        }
    }

    /// The names that a statement declares.
    pub(crate) fn declared(&self) -> Vec<&Name> {
        match self {
            Self::Coord { declarations } => declarations.iter().map(|one| &one.name).collect(),
            Self::Table { name, .. } => vec![name],
            Self::Param(binding) | Self::Let(binding) => vec![&binding.name],
            Self::Model { .. }
            | Self::Kinetic(_)
            | Self::Potential(_)
            | Self::Lagrangian(_)
            | Self::Dissipation(_)
            | Self::Constraint { .. }
            | Self::Guess { .. }
            | Self::Equilibrium { .. }
            | Self::Period(_) => Vec::new(),
        }
    }

    /// The indices in brackets behind its names.
    pub(crate) fn indices(&self) -> impl Iterator<Item = &Indices> {
        let (own, declared) = match self {
            Self::Coord { declarations } => (None, declarations.as_slice()),
            Self::Constraint { indices, .. } => (indices.as_deref(), [].as_slice()),
            Self::Param(binding)
            | Self::Let(binding)
            | Self::Guess { binding, .. }
            | Self::Equilibrium { binding, .. } => (binding.indices.as_deref(), [].as_slice()),
            Self::Model { .. }
            | Self::Kinetic(_)
            | Self::Potential(_)
            | Self::Lagrangian(_)
            | Self::Dissipation(_)
            | Self::Period(_)
            | Self::Table { .. } => (None, [].as_slice()),
        };
        let declared = declared.iter().filter_map(|one| one.indices.as_deref());
        own.into_iter().chain(declared)
    }
}

impl Indices {
    /// Members, bounds and the filter.
    pub(crate) fn expressions(&self) -> impl Iterator<Item = ExprRef> {
        let entries = self.entries.iter().flat_map(|entry| match &entry.kind {
            IndexKind::Member(at) => [Some(*at), None],
            IndexKind::Range { from, to, .. } => [Some(*from), Some(*to)],
            IndexKind::Rows { .. } => [None, None],
        });
        entries.flatten().chain(self.filter)
    }

    /// The tables whose rows they run over.
    pub(crate) fn tables(&self) -> impl Iterator<Item = &Name> {
        self.entries.iter().filter_map(|entry| match &entry.kind {
            IndexKind::Rows { table, .. } => Some(table),
            IndexKind::Member(_) | IndexKind::Range { .. } => None,
        })
    }
}

impl File {
    /// All indices, of statements and of sums.
    pub(crate) fn indices(&self) -> impl Iterator<Item = &Indices> {
        let sums = self
            .expressions
            .iter()
            .filter_map(|expr| if let ExprKind::SumOver { indices, .. } = expr.kind { Some(indices) } else { None });
        let statements = self.statements.iter();
        statements.flat_map(|own| own.kind.indices()).chain(sums)
    }

    /// The expressions directly below one, those of indices included.
    pub(crate) fn children(&self, at: ExprRef, out: &mut Vec<ExprRef>) {
        match &self.expr(at).kind {
            ExprKind::Number(_) | ExprKind::Name(_) => {}
            ExprKind::Index { base, indices } => {
                out.push(*base);
                out.extend(*indices);
            }
            ExprKind::Field { base, .. } => out.push(*base),
            ExprKind::Prime(inner) | ExprKind::Negate(inner) | ExprKind::Not(inner) => {
                out.push(*inner);
            }
            ExprKind::Power { base, exponent } => out.extend([*base, *exponent]),
            ExprKind::Product(factors) => out.extend(factors.iter().map(|factor| factor.value())),
            ExprKind::Sum(terms) => out.extend(terms.iter().map(|term| term.value())),
            ExprKind::Call { arguments, .. } => out.extend(*arguments),
            ExprKind::SumOver { indices, body } => {
                out.extend(indices.expressions());
                out.push(*body);
            }
            ExprKind::Vector(parts) | ExprKind::And(parts) | ExprKind::Or(parts) => {
                out.extend(*parts);
            }
            ExprKind::Compare { left, right, .. } => out.extend([*left, *right]),
        }
    }
}
