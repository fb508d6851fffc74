//! What statements and expressions are made of, so that no pass lists the forms that it passes over.
#![cfg_attr(not(feature = "engine"), allow(dead_code, reason = "each of the two walks over a part"))]

use super::ast::{Binding, ExprKind, ExprRef, File, IndexKind, Indices, Name, StatementKind};

impl StatementKind {
    /// The names with their values that a statement gives.
    pub(crate) fn bindings(&self) -> &[Binding] {
        if let Self::Let(binding)
        | Self::Force(binding)
        | Self::Guess { binding, .. }
        | Self::Equilibrium { binding, .. } = self
        {
            return std::slice::from_ref(binding);
        }
        self.parameters()
    }

    /// The name with its value that a statement gives, if it gives one.
    pub(crate) fn binding(&self) -> Option<&Binding> {
        if let [binding] = self.bindings() { Some(binding) } else { None }
    }

    /// The names with their values that a `param` statement gives.
    pub fn parameters(&self) -> &[Binding] {
        if let Self::Param(bindings) = self { bindings } else { &[] }
    }

    /// The names that a `coord` statement declares.
    pub(crate) fn coordinates(&self) -> &[Binding] {
        if let Self::Coord { declarations } = self { declarations } else { &[] }
    }

    /// The energy that a statement gives, or the dissipation function.
    pub(crate) fn energy(&self) -> Option<ExprRef> {
        if let Self::Kinetic(value) | Self::Potential(value) | Self::Lagrangian(value) | Self::Dissipation(value) = self
        {
            return Some(*value);
        }
        None
    }

    /// The names that a statement declares.
    pub(crate) fn declared(&self) -> impl Iterator<Item = &Name> {
        let single =
            if let Self::Table { name, .. } | Self::Let(Binding { name, .. }) = self { Some(name) } else { None };
        single.into_iter().chain(self.coordinates().iter().chain(self.parameters()).map(|one| &one.name))
    }

    /// The indices in brackets behind its names.
    pub(crate) fn indices(&self) -> impl Iterator<Item = &Indices> {
        let own = self.bindings().iter().chain(self.coordinates()).map(|binding| &binding.indices);
        let tied =
            if let Self::Constraint { indices, .. } | Self::Draw { indices, .. } = self { Some(indices) } else { None };
        own.chain(tied).filter_map(Option::as_deref)
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
            ExprKind::Prime(inner) | ExprKind::Negate(inner) | ExprKind::Not(inner) => out.push(*inner),
            ExprKind::Power { base, exponent } => out.extend([*base, *exponent]),
            ExprKind::Product(members) | ExprKind::Sum(members) => out.extend(members.iter().map(|own| own.value())),
            ExprKind::Call { arguments, .. } => out.extend(*arguments),
            ExprKind::SumOver { indices, body } | ExprKind::IntegralOver { indices, body } => {
                out.extend(indices.expressions());
                out.push(*body);
            }
            ExprKind::Vector(parts) | ExprKind::And(parts) | ExprKind::Or(parts) => out.extend(*parts),
            ExprKind::Compare { left, right, .. } => out.extend([*left, *right]),
        }
    }
}
