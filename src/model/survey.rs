//! What a file names, before anything is worked out: where names are declared and which set ranges.

use std::collections::{HashMap, HashSet};

use crate::span::Span;
use crate::syntax::{ExprKind, ExprRef, File, IndexKind, Indices, Name, StatementKind};

/// The names that a statement declares.
pub(super) fn declared(kind: &StatementKind) -> Vec<&Name> {
    match kind {
        StatementKind::Param(binding) | StatementKind::Let(binding) => vec![&binding.name],
        StatementKind::Coord { declarations } => declarations.iter().map(|one| &one.name).collect(),
        StatementKind::Table { name, .. } => vec![name],
        StatementKind::Model { .. }
        | StatementKind::Kinetic(_)
        | StatementKind::Potential(_)
        | StatementKind::Lagrangian(_)
        | StatementKind::Dissipation(_)
        | StatementKind::Constraint { .. }
        | StatementKind::Guess { .. }
        | StatementKind::Equilibrium { .. }
        | StatementKind::Period(_) => Vec::new(),
    }
}

/// Where every name is declared first.
pub(super) fn declared_names(file: &File) -> HashMap<String, Span> {
    let mut names = HashMap::new();
    for name in file.statements.iter().flat_map(|own| declared(&own.kind)) {
        names.entry(name.text.to_string()).or_insert(name.span);
    }
    names
}

/// The names that set ranges, indices and filters, directly or through other parameters.
pub(super) fn structural_names(file: &File) -> HashSet<String> {
    let mut todo: Vec<ExprRef> = Vec::new();
    let add = |indices: &Indices, todo: &mut Vec<ExprRef>| {
        for entry in &indices.entries {
            match &entry.kind {
                IndexKind::Member(at) => todo.push(*at),
                IndexKind::Range { from, to, .. } => todo.extend([*from, *to]),
                IndexKind::Rows { .. } => {}
            }
        }
        todo.extend(indices.filter);
    };
    for expr in &file.expressions {
        match &expr.kind {
            ExprKind::SumOver { indices, .. } => add(indices, &mut todo),
            ExprKind::Index { indices, .. } => todo.extend(*indices),
            ExprKind::Call {
                function,
                arguments,
            } if matches!(function.text.as_str(), "mod" | "floor") => todo.extend(*arguments),
            ExprKind::Number(_)
            | ExprKind::Name(_)
            | ExprKind::Field { .. }
            | ExprKind::Prime(_)
            | ExprKind::Negate(_)
            | ExprKind::Power { .. }
            | ExprKind::Product(_)
            | ExprKind::Sum(_)
            | ExprKind::Call { .. }
            | ExprKind::Vector(_)
            | ExprKind::Compare { .. }
            | ExprKind::Not(_)
            | ExprKind::And(_)
            | ExprKind::Or(_) => {}
        }
    }
    let mut definitions: HashMap<&str, Vec<ExprRef>> = HashMap::new();
    for statement in &file.statements {
        match &statement.kind {
            StatementKind::Param(binding) => {
                if let Some(indices) = &binding.indices {
                    add(indices, &mut todo);
                }
                if let Some(value) = binding.value {
                    definitions
                        .entry(&binding.name.text)
                        .or_default()
                        .push(value);
                }
            }
            StatementKind::Let(binding)
            | StatementKind::Guess { binding, .. }
            | StatementKind::Equilibrium { binding, .. } => {
                if let Some(indices) = &binding.indices {
                    add(indices, &mut todo);
                }
            }
            StatementKind::Coord { declarations } => {
                for one in declarations {
                    if let Some(indices) = &one.indices {
                        add(indices, &mut todo);
                    }
                }
            }
            StatementKind::Constraint { indices, .. } => {
                if let Some(indices) = indices {
                    add(indices, &mut todo);
                }
            }
            StatementKind::Model { .. }
            | StatementKind::Kinetic(_)
            | StatementKind::Potential(_)
            | StatementKind::Lagrangian(_)
            | StatementKind::Dissipation(_)
            | StatementKind::Period(_)
            | StatementKind::Table { .. } => {}
        }
    }
    let mut names = HashSet::new();
    while let Some(at) = todo.pop() {
        if let ExprKind::Name(name) = &file.expr(at).kind
            && !names.contains(*name)
        {
            names.insert((*name).to_owned());
            todo.extend(definitions.get(name).into_iter().flatten());
        }
        children(file, at, &mut todo);
    }
    names
}

/// The tables whose rows number coordinates.
pub(super) fn tables_of_coordinates(file: &File) -> impl Iterator<Item = String> {
    let declarations = file
        .statements
        .iter()
        .flat_map(|statement| match &statement.kind {
            StatementKind::Coord { declarations } => declarations.as_slice(),
            _ => &[],
        });
    declarations
        .filter_map(|one| one.indices.as_deref())
        .flat_map(|indices| &indices.entries)
        .filter_map(|entry| match &entry.kind {
            IndexKind::Rows { table, .. } => Some(table.text.to_string()),
            IndexKind::Member(_) | IndexKind::Range { .. } => None,
        })
}

/// The expressions directly below one, those of indices included.
pub(super) fn children(file: &File, at: ExprRef, out: &mut Vec<ExprRef>) {
    match &file.expr(at).kind {
        ExprKind::Number(_) | ExprKind::Name(_) => {}
        ExprKind::Index { base, indices } => {
            out.push(*base);
            out.extend(*indices);
        }
        ExprKind::Field { base, .. } => out.push(*base),
        ExprKind::Prime(inner) | ExprKind::Negate(inner) | ExprKind::Not(inner) => out.push(*inner),
        ExprKind::Power { base, exponent } => out.extend([*base, *exponent]),
        ExprKind::Product(factors) => out.extend(factors.iter().map(|factor| factor.value())),
        ExprKind::Sum(terms) => out.extend(terms.iter().map(|term| term.value())),
        ExprKind::Call { arguments, .. } => out.extend(*arguments),
        ExprKind::SumOver { indices, body } => {
            for entry in &indices.entries {
                match &entry.kind {
                    IndexKind::Member(at) => out.push(*at),
                    IndexKind::Range { from, to, .. } => out.extend([*from, *to]),
                    IndexKind::Rows { .. } => {}
                }
            }
            out.extend(indices.filter);
            out.push(*body);
        }
        ExprKind::Vector(parts) | ExprKind::And(parts) | ExprKind::Or(parts) => out.extend(*parts),
        ExprKind::Compare { left, right, .. } => out.extend([*left, *right]),
    }
}

/// Whether an expression names something.
pub(super) fn mentions(file: &File, root: ExprRef, name: &str) -> bool {
    let mut todo = vec![root];
    while let Some(at) = todo.pop() {
        if matches!(&file.expr(at).kind, ExprKind::Name(own) if *own == name) {
            return true;
        }
        children(file, at, &mut todo);
    }
    false
}
