//! What is answered from a text and what is known of it.

use librate::diagnostic::{self, Replacement};
use librate::model;
use librate::span::Span;
use librate::syntax::{self, ExprKind, NameKind, NamePlace, StatementKind, signature};
use serde_json::{Value, json};

use super::check::Facts;
use super::complete::{is_letter, without_word};
use super::document::{Document, is_renamable};
use crate::cli::messages::Lines;

/// So many members of a family are shown.
const SHOWN: usize = 6;

pub(super) fn hover(document: &Document, facts: &Facts, at: usize) -> Value {
    let Some(name) = document.name_at(at) else { return own_word(document, at) };
    let text = match name.kind {
        NameKind::Quantity => quantity(document, facts, &name),
        NameKind::Function => called(name.text),
        NameKind::Unit => model::unit_dimension(name.text)
            .map(|own| format!("`{}` measures {own}: `{}` in SI", name.text, own.unit())),
        NameKind::Index(around) => {
            let whole = document.source(around).lines().next().unwrap_or_default();
            Some(format!("an index of\n```librate\n{whole}\n```"))
        }
        NameKind::Column(table) => table.map(|own| format!("a column of the table `{own}`")),
        NameKind::Model => None,
    };
    shown(document, name.span, text)
}

/// What is said of a place; nothing where there is nothing to say.
fn shown(document: &Document, span: Span, text: Option<String>) -> Value {
    let Some(text) = text else { return Value::Null };
    json!({"contents": {"kind": "markdown", "value": text}, "range": document.lines().range(span)})
}

/// How a function is called, and what it is.
fn called(word: &str) -> Option<String> {
    signature(word).map(|(call, meaning)| format!("```librate\n{call}\n```\n{meaning}"))
}

/// What a word of the language is, which is no name: `T`, `sum`.
fn own_word(document: &Document, at: usize) -> Value {
    let (before, behind) = document.text.split_at_checked(at).unwrap_or_default();
    let start = without_word(before).len();
    let end = at + behind.find(|c| !is_letter(c)).unwrap_or(behind.len());
    let word = document.text.get(start..end).unwrap_or_default();
    let is_comment = before.rsplit('\n').next().is_some_and(|line| line.contains('#'));
    let text = called(word).or_else(|| syntax::reserved_meaning(word).map(|own| format!("`{word}` {own}")));
    shown(document, Span::new(start as u32, end as u32), text.filter(|_| !is_comment))
}

/// The statements that declare a name, its value, its dimension.
fn quantity(document: &Document, facts: &Facts, name: &NamePlace<'_>) -> Option<String> {
    let declarations: Vec<Span> =
        document.same(name).iter().filter(|own| own.is_declaration).map(|own| own.span).collect();
    let statements = document.file.statements.iter();
    let holds = |whole: Span| declarations.iter().any(|own| whole.start <= own.start && own.end <= whole.end);
    let mut lines: Vec<String> = Vec::new();
    for statement in statements.filter(|own| holds(own.span)) {
        let rest = document.text.get(statement.span.end as usize..).unwrap_or_default();
        let comment = rest.lines().next().filter(|rest| rest.trim_start().starts_with('#'));
        lines.push(format!("{}{}", document.source(statement.span), comment.unwrap_or_default()));
    }
    if lines.is_empty() {
        return None;
    }
    let mut text = format!("```librate\n{}\n```", lines.join("\n"));
    let dimension = facts.dimensions.get(name.text);
    let unit = dimension.filter(|own| !own.is_number()).map(|own| format!(" {}", own.unit())).unwrap_or_default();
    if let Some(values) = facts.values.get(name.text) {
        let mut shown: Vec<String> =
            values.iter().take(SHOWN).map(|(member, digits)| format!("`{member} = {digits}{unit}`")).collect();
        shown.extend((values.len() > SHOWN).then(|| "…".to_owned()));
        text = format!("{text}\n{}", shown.join(", "));
    }
    if let Some(dimension) = dimension {
        text = format!("{text}\n\n{dimension}");
    }
    let members = facts.at_rest.get(name.text).map(Vec::as_slice).unwrap_or_default();
    for own in members.iter().take(SHOWN) {
        text = format!("{text}\n\n{}", own.line(dimension));
    }
    if members.len() > SHOWN {
        text.push_str("\n\n…");
    }
    Some(text)
}

pub(super) fn definition(document: &Document, at: usize) -> Value {
    let Some(name) = document.name_at(at) else { return Value::Null };
    if let NameKind::Column(table) = name.kind {
        let path = table.and_then(|table| document.table(table));
        let start = json!({"line": 0, "character": 0});
        return path.map_or(
            Value::Null,
            |path| json!([{"uri": document.beside(path), "range": {"start": start, "end": start}}]),
        );
    }
    let lines = document.lines();
    let places = document.same(&name).into_iter().filter(|own| own.is_declaration);
    places.map(|own| document.location(&lines, own.span)).collect()
}

pub(super) fn references(document: &Document, at: usize, with_declaration: bool) -> Value {
    let Some(name) = document.name_at(at) else { return Value::Null };
    let lines = document.lines();
    let places = document.same(&name).into_iter().filter(|own| with_declaration || !own.is_declaration);
    places.map(|own| document.location(&lines, own.span)).collect()
}

/// What would be renamed here.
pub(super) fn renamed_place(document: &Document, at: usize) -> Value {
    match document.name_at(at).filter(is_renamable) {
        Some(name) => json!({"range": document.lines().range(name.span), "placeholder": name.text}),
        None => Value::Null,
    }
}

/// The name that is asked for at all its places. The new text must read as the old one with other letters.
pub(super) fn rename(document: &Document, at: usize, new: &str) -> Result<Value, String> {
    let name = document.name_at(at).filter(is_renamable).ok_or("there is no name here that could be changed")?;
    if !document.is_readable {
        return Err("first correct the mistakes: places of the name may be in what can't be read".to_owned());
    }
    let names = syntax::names(&document.file);
    let is_taken = |own: &NamePlace<'_>| own.text == new && is_renamable(own) && own.kind != NameKind::Model;
    if name.kind != NameKind::Model && names.iter().any(is_taken) {
        return Err(format!("`{new}` is in use already"));
    }
    let places = document.same(&name);
    let changes: Vec<Replacement> = places.iter().map(|own| Replacement::new(own.span, new)).collect();
    let text = diagnostic::replaced(&document.text, &changes);
    let reads = syntax::parse(&text).is_ok_and(|file| {
        let again = syntax::names(&file);
        let alike = |(old, other): (&NamePlace<'_>, &NamePlace<'_>)| {
            old.text == other.text || (other.text == new && places.iter().any(|place| place.span == old.span))
        };
        again.len() == names.len() && names.iter().zip(&again).all(alike)
    });
    if !reads {
        return Err(format!("`{new}` can't be used as a name"));
    }
    let lines = document.lines();
    let edits: Vec<Value> = changes.iter().map(|own| edit(&lines, own)).collect();
    Ok(json!({"changes": {document.uri.clone(): edits}}))
}

fn edit(lines: &Lines<'_>, own: &Replacement) -> Value {
    json!({"range": lines.range(own.span), "newText": own.text})
}

/// The kinds of the protocol.
fn symbol_kind(kind: &StatementKind) -> u8 {
    match kind {
        StatementKind::Model { .. } => 2,  // a module
        StatementKind::Param(_) => 14,     // a constant
        StatementKind::Coord { .. } => 8,  // a field
        StatementKind::Let(_) => 13,       // a variable
        StatementKind::Table { .. } => 18, // an array
        StatementKind::Kinetic(_)
        | StatementKind::Potential(_)
        | StatementKind::Lagrangian(_)
        | StatementKind::Dissipation(_)
        | StatementKind::Force(_)
        | StatementKind::Constraint { .. }
        | StatementKind::Assume(_)
        | StatementKind::Guess { .. }
        | StatementKind::Equilibrium { .. }
        | StatementKind::Period(_)
        | StatementKind::Draw { .. } => 12, // a function
    }
}

/// The statements by what they declare, or by their first word.
pub(super) fn outline(document: &Document) -> Value {
    let lines = document.lines();
    let names = syntax::names(&document.file);
    let mut all = Vec::new();
    for statement in &document.file.statements {
        let Span { start, end } = statement.span;
        let inside = names.iter().filter(|own| start <= own.span.start && own.span.end <= end);
        let declared: Vec<&NamePlace<'_>> =
            inside.filter(|own| own.is_declaration && !matches!(own.kind, NameKind::Index(_))).collect();
        let text = document.source(statement.span);
        let kind = symbol_kind(&statement.kind);
        let mut push = |name: &str, place: Span| {
            all.push(json!({
                "name": name,
                "detail": text.lines().next().unwrap_or_default(),
                "kind": kind,
                "range": lines.range(statement.span),
                "selectionRange": lines.range(place),
            }));
        };
        if declared.is_empty() {
            let word = text.split(|c: char| c.is_whitespace() || c == '=').next().unwrap_or_default();
            push(word, Span::new(start, start + word.len() as u32));
        }
        declared.iter().for_each(|own| push(own.text, own.span));
    }
    Value::Array(all)
}

pub(super) fn formatted(document: &Document) -> Value {
    match syntax::format(&document.text) {
        Ok(text) if *text == *document.text => json!([]),
        Ok(text) => {
            let whole = Span::new(0, document.text.len() as u32);
            json!([{"range": document.lines().range(whole), "newText": text}])
        }
        Err(_) => Value::Null,
    }
}

/// Values that parameters get from others, and units that are not written.
pub(super) fn hints(document: &Document, facts: &Facts, range: &Value) -> Value {
    let lines = document.lines();
    let shown = lines.offset(&range["start"])..=lines.offset(&range["end"]);
    let mut all = Vec::new();
    let mut hint = |at: u32, label: Option<String>| {
        if let Some(label) = label.filter(|_| shown.contains(&(at as usize))) {
            all.push(json!({"position": lines.position(at), "label": label, "kind": 1, "paddingLeft": true}));
        }
    };
    let unit = |name: &str| facts.dimensions.get(name).map(|own| format!(": {}", own.unit()));
    for statement in &document.file.statements {
        let bindings = match &statement.kind {
            StatementKind::Param(all) | StatementKind::Coord { declarations: all } => all.as_slice(),
            StatementKind::Let(binding) => std::slice::from_ref(binding),
            _ => &[],
        };
        for binding in bindings {
            if binding.unit.is_none() {
                let place = binding.indices.as_ref().map_or(binding.name.span, |own| own.span);
                hint(place.end, unit(&binding.name.text));
            }
            if let Some(value) = binding.value.map(|at| document.file.expr(at))
                && !matches!(value.kind, ExprKind::Number(_) | ExprKind::Negate(_) | ExprKind::Vector(_))
                && let Some([(_, digits)]) = facts.values.get(&*binding.name.text).map(Vec::as_slice)
            {
                // In SI, beside a unit that may be another one.
                let unit = facts.dimensions.get(&*binding.name.text).filter(|_| binding.unit.is_some());
                let unit = unit.map_or_else(String::new, |own| format!(" {}", own.unit()));
                hint(value.span.end, Some(format!("= {digits}{unit}")));
            }
        }
    }
    Value::Array(all)
}

/// The frequencies, above the first line.
pub(super) fn lens(facts: &Facts) -> Value {
    let start = json!({"line": 0, "character": 0});
    let lens =
        |title: &String| json!({"range": {"start": start, "end": start}, "command": {"title": title, "command": ""}});
    facts.modes.iter().map(lens).collect()
}

/// The changes that correct what is wrong in a range.
pub(super) fn fixes(document: &Document, facts: &Facts, range: &Value) -> Value {
    let lines = document.lines();
    let (start, end) = (lines.offset(&range["start"]), lines.offset(&range["end"]));
    let all = facts.diagnostics.iter().filter_map(|own| {
        let change = own.replacement.as_ref().or(own.proposal.as_ref())?;
        let place = own.primary.as_ref()?.span.range();
        if place.start > end || start > place.end {
            return None;
        }
        let title = match change.text.as_str() {
            "" => format!("Remove `{}`", document.source(change.span)),
            text => format!("Write `{text}`"),
        };
        Some(json!({
            "title": title,
            "kind": "quickfix",
            "isPreferred": own.replacement.is_some(),
            "edit": {"changes": {document.uri.clone(): [edit(&lines, change)]}},
        }))
    });
    all.collect()
}
