//! Units in brackets behind a name: read as an index, they leave mistakes behind that say nothing of it.

use super::ModelError;
use crate::diagnostic::Diagnostic;
use crate::span::Span;
use crate::syntax::units::look_up;
use crate::syntax::{ExprKind, ExprRef, File, IndexKind, Indices, Name, StatementKind, print_expr};

/// `param m [kg] = 1` and `coord x [m]`: where something is wrong that may follow from it, the unit is reported instead of
/// what is wrong in the brackets.
pub(super) fn units_in_brackets(file: &File, errors: &mut Vec<ModelError>) {
    if errors.is_empty() {
        return;
    }
    let mut declared: Vec<(&Name, &Indices)> = Vec::new();
    for statement in &file.statements {
        declared
            .extend(statement.kind.parameters().iter().filter_map(|own| Some((&own.name, own.indices.as_deref()?))));
        if let StatementKind::Coord { declarations } = &statement.kind {
            declared.extend(declarations.iter().filter_map(|own| Some((&own.name, own.indices.as_deref()?))));
        }
    }
    let is_shape = |error: &ModelError| matches!(error, ModelError::Shape { .. });
    for (name, indices) in declared {
        let [only] = &*indices.entries else { continue };
        let IndexKind::Member(unit) = only.kind else { continue };
        if indices.filter.is_some() || !is_unit(file, unit) {
            continue;
        }
        let is_inside = |error: &ModelError| place(error).is_some_and(|own| within(own, indices.span));
        let is_certain = errors.iter().any(|own| is_inside(own) && matches!(own, ModelError::UndeclaredName { .. }));
        if is_certain || errors.iter().any(|own| is_inside(own) || is_shape(own)) {
            errors.retain(|own| !is_inside(own));
            let fix = format!("{} : {}", name.text, print_expr(file, unit));
            let span = Span::new(name.span.end, indices.span.end);
            errors.push(ModelError::UnitInBrackets { fix, is_certain, span });
        }
    }
}

fn place(error: &ModelError) -> Option<Span> {
    Diagnostic::from(error).primary.map(|label| label.span)
}

fn within(own: Span, whole: Span) -> bool {
    whole.start <= own.start && own.end <= whole.end
}

/// Whether an index is made of names of units alone: `kg`, `m/s^2`.
fn is_unit(file: &File, root: ExprRef) -> bool {
    let mut todo = vec![root];
    let mut named = false;
    while let Some(at) = todo.pop() {
        match &file.expr(at).kind {
            ExprKind::Name(name) if look_up(name).is_some() => named = true,
            ExprKind::Product(_) | ExprKind::Power { .. } | ExprKind::Number(_) | ExprKind::Negate(_) => {}
            _ => return false,
        }
        file.children(at, &mut todo);
    }
    named
}
