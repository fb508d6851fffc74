//! What a file names, before anything is worked out: where names are declared and which set ranges.

use hashbrown::{HashMap, HashSet};

use crate::span::Span;
use crate::syntax::{ExprKind, ExprRef, File, Indices, StatementKind};

/// Where every name is declared first.
pub(super) fn declared_names(file: &File) -> HashMap<String, Span> {
    let mut names = HashMap::new();
    for name in file.statements.iter().flat_map(|own| own.kind.declared()) {
        names.entry(name.text.to_string()).or_insert(name.span);
    }
    names
}

/// The names that set ranges, indices and filters, directly or through other parameters.
pub(super) fn structural_names(file: &File) -> HashSet<String> {
    let mut todo: Vec<ExprRef> = file.indices().flat_map(Indices::expressions).collect();
    for expr in file.expressions.iter() {
        if let ExprKind::Index { indices, .. } = expr.kind {
            todo.extend(indices);
        }
        if let ExprKind::Call { function, arguments } = expr.kind
            && matches!(function.text.as_str(), "mod" | "floor")
        {
            todo.extend(arguments);
        }
    }
    let mut names = HashSet::new();
    if todo.is_empty() {
        return names;
    }
    let mut definitions: HashMap<&str, Vec<ExprRef>> = HashMap::new();
    for statement in &file.statements {
        for binding in statement.kind.parameters() {
            let own = definitions.entry(&binding.name.text).or_default();
            own.extend(binding.value);
        }
    }
    while let Some(at) = todo.pop() {
        if let ExprKind::Name(name) = &file.expr(at).kind
            && !names.contains(*name)
        {
            names.insert((*name).to_owned());
            todo.extend(definitions.get(name).into_iter().flatten());
        }
        file.children(at, &mut todo);
    }
    names
}

/// The tables whose rows number coordinates.
pub(super) fn tables_of_coordinates(file: &File) -> impl Iterator<Item = String> {
    let statements = file.statements.iter().map(|statement| &statement.kind);
    let coordinates = statements.filter(|kind| matches!(kind, StatementKind::Coord { .. }));
    coordinates.flat_map(|kind| kind.indices()).flat_map(Indices::tables).map(|table| table.text.to_string())
}

/// The name of `w` and of `w[i]`, with the indices.
pub(super) fn named(file: &File, at: ExprRef) -> Option<(&str, &[ExprRef])> {
    let (bare, indices) = match file.expr(at).kind {
        ExprKind::Index { base, indices } => (base, indices),
        _ => (at, &[][..]),
    };
    if let ExprKind::Name(name) = file.expr(bare).kind { Some((name, indices)) } else { None }
}

/// Whether an expression names something of which this holds.
pub(super) fn mentions(file: &File, root: ExprRef, mut sought: impl FnMut(&str) -> bool) -> bool {
    let mut todo = vec![root];
    while let Some(at) = todo.pop() {
        if matches!(&file.expr(at).kind, ExprKind::Name(own) if sought(own)) {
            return true;
        }
        file.children(at, &mut todo);
    }
    false
}
