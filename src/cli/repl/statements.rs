//! What a statement declares, and its text with another value.

use librate::syntax::{Binding, ExprKind, ExprRef, File, IndexKind, Indices, Name, Statement, StatementKind};

/// One value for all members of a longer family is not written as a list.
const LONGEST_LIST: usize = 20;

/// A name with its indices, ranges as dots.
pub(super) fn declared_name(name: &Name, indices: Option<&Indices>, text: &str) -> String {
    let Some(indices) = indices else { return name.text.to_string() };
    let entry = |at: usize| match &indices.entries[at].kind {
        IndexKind::Member(_) => text[indices.entries[at].span.range()].split_whitespace().collect(),
        IndexKind::Range { .. } | IndexKind::Rows { .. } => "..".to_owned(),
    };
    let entries: Vec<String> = (0..indices.entries.len()).map(entry).collect();
    let filter = if indices.filter.is_some() { &text[indices.span.range()] } else { "" };
    format!("{}[{}]{filter}", name.text, entries.join(","))
}

/// What a statement declares; another one of the same takes its place. The members of a family that are declared one by one are different.
pub(super) fn declared(kind: &StatementKind, text: &str) -> Vec<String> {
    let bound = |own: &Binding| declared_name(&own.name, own.indices.as_deref(), text);
    match kind {
        StatementKind::Model { .. } => vec!["model".to_owned()],
        StatementKind::Param(bindings) => bindings.iter().map(bound).collect(),
        StatementKind::Coord { declarations } => declarations.iter().map(bound).collect(),
        StatementKind::Let(own) => vec![bound(own)],
        StatementKind::Table { name, .. } => vec![name.text.to_string()],
        StatementKind::Kinetic(_) => vec!["T".to_owned()],
        StatementKind::Potential(_) => vec!["V".to_owned()],
        StatementKind::Lagrangian(_) => vec!["lagrangian".to_owned()],
        StatementKind::Dissipation(_) => vec!["dissipation".to_owned()],
        StatementKind::Period(_) => vec!["period".to_owned()],
        StatementKind::Force(own) => vec![format!("force {}", bound(own))],
        StatementKind::Guess { binding, rate } => vec![format!("guess {rate} {}", bound(binding))],
        StatementKind::Equilibrium { binding, rate } => vec![format!("equilibrium {rate} {}", bound(binding))],
        StatementKind::Constraint { .. } | StatementKind::Assume(_) | StatementKind::Draw { .. } => Vec::new(),
    }
}

/// Which statements need which: those of a rank only what has a lower one, or the same.
pub(super) fn rank(kind: &StatementKind) -> u8 {
    match kind {
        StatementKind::Model { .. } => 0,
        StatementKind::Table { .. } => 1,
        StatementKind::Param(_) => 2,
        StatementKind::Coord { .. } => 3,
        StatementKind::Let(_) => 4,
        _ => 5,
    }
}

/// A value as it is typed.
pub(super) struct Typed<'t> {
    /// With its uncertainty, without comments behind it.
    pub(super) text: &'t str,
    pub(super) is_uncertain: bool,
}

/// What a statement gives values to, where another value can be typed.
pub(super) fn bindings_of(kind: &StatementKind) -> &[Binding] {
    if let StatementKind::Let(own) = kind { std::slice::from_ref(own) } else { kind.parameters() }
}

/// Where the `=` ends that stands before a value.
pub(super) fn behind_equals(text: &str, value: u32) -> usize {
    text[..value as usize].rfind('=').map_or(0, |at| at + 1)
}

/// The statement with another value for one of its names, which leaves those that it shares one with. An uncertainty stays
/// where the value has none.
pub(super) fn with_value(file: &File, statement: &Statement, at: usize, text: &str, value: &Typed<'_>) -> String {
    let all = bindings_of(&statement.kind);
    let old = &all[at];
    let is_shared =
        |own: &Binding| own.value == old.value && own.unit == old.unit && (own.value, own.unit) != (None, None);
    let head = |own: &Binding| {
        let end = own.indices.as_ref().map_or(own.name.span, |indices| indices.span).range().end;
        own.name.span.range().start..end
    };
    let group: Vec<&Binding> = all.iter().filter(|own| std::ptr::eq(*own, old) || is_shared(own)).collect();
    let first = group.first().map_or(0, |own| head(own).start);
    let last = group.last().map_or(0, |own| head(own).end);
    let following = all.iter().map(|own| head(own).start).find(|start| *start > last);
    let end = following.and_then(|start| text[..start].rfind(',')).unwrap_or(statement.span.range().end);
    let equals = old.value.map_or(end, |own| behind_equals(text, file.expr(own).span.start));
    // From the unit on, and what stands behind the value.
    let unit = text[last..equals].trim_end_matches('=').trim_end();
    let sign = old.uncertainty.filter(|_| !value.is_uncertain).and_then(|_| {
        let from = file.expr(old.value?).span.range().end;
        text[from..end].find(['±', '+']).map(|sign| from + sign)
    });
    let uncertainty = sign.map_or_else(String::new, |sign| format!(" {}", text[sign..end].trim_end()));
    let given = format!("{unit} = {}{uncertainty}", value.text);
    if group.len() == 1 {
        return format!("{}{given}{}", &text[..last], &text[end..]);
    }
    let others: Vec<&str> = group.iter().filter(|own| !std::ptr::eq(**own, old)).map(|own| &text[head(own)]).collect();
    let whole = statement.span.range().end;
    format!(
        "{}{}{}, {}{given}{}",
        &text[..first],
        others.join(", "),
        &text[last..whole],
        &text[head(old)],
        &text[whole..]
    )
}

/// The statement with another value for one member of a family, whose members have a list, or all of them one value.
pub(super) fn with_member(
    file: &File,
    statement: &Statement,
    at: usize,
    (text, typed, new): (&str, &str, &Binding),
    value: &str,
) -> Option<String> {
    let all = bindings_of(&statement.kind);
    let old = all.get(at).filter(|old| all.iter().filter(|own| own.value == old.value).count() == 1)?;
    let only = |own: &Indices| if own.entries.len() == 1 { own.entries.first().cloned() } else { None };
    let IndexKind::Range { variable: None, from, to } = only(old.indices.as_deref()?)?.kind else { return None };
    let member = only(new.indices.as_deref()?)?;
    let whole = |at: ExprRef| text[file.expr(at).span.range()].parse::<usize>().ok();
    let member = typed[member.span.range()].parse::<usize>().ok()?;
    let (first, last) = (whole(from)?, whole(to).unwrap_or(usize::MAX));
    let at = member.checked_sub(first).filter(|_| member <= last)?;
    let expr = file.expr(old.value?);
    if let ExprKind::Vector(entries) = expr.kind {
        let place = file.expr(*entries.get(at)?).span.range();
        return Some(format!("{}{value}{}", &text[..place.start], &text[place.end..]));
    }
    let count = last.checked_sub(first).filter(|count| *count < LONGEST_LIST)? + 1;
    let own = &text[expr.span.range()];
    let list: Vec<&str> = (0..count).map(|number| if number == at { value } else { own }).collect();
    Some(format!("{}[{}]{}", &text[..expr.span.range().start], list.join(", "), &text[expr.span.range().end..]))
}
