//! Trees of a text that was read before: where nothing has changed they are copied, moved to their new places.

use std::ops::Range;

use super::arena::{Kept, KeptUnit};
use super::ast::{Binding, ExprKind, ExprRef, File, IndexKind, Indices, Member, Name, Statement, StatementKind};
use super::build::Builder;
use crate::span::Span;

/// What is in front of the part of a sum that is read by itself.
const HEAD: &str = "V=0";

/// By how much numbers of expressions and of units, and places, are larger in the copy, modulo 2^32.
#[derive(Clone, Copy)]
pub(super) struct Shift {
    expressions: u32,
    units: u32,
    bytes: u32,
}

impl Shift {
    pub(super) fn span(self, span: &mut Span) {
        *span = Span::new(span.start.wrapping_add(self.bytes), span.end.wrapping_add(self.bytes));
    }

    fn expr(self, at: &mut ExprRef) {
        at.0 = at.0.wrapping_add(self.expressions);
    }

    fn all<'e>(self, all: impl IntoIterator<Item = &'e mut ExprRef>) {
        all.into_iter().for_each(|at| self.expr(at));
    }

    fn member(self, member: &Member) -> Member {
        let mut value = member.value();
        self.expr(&mut value);
        Member::new(member.inverted(), value)
    }

    fn name(self, name: &mut Name) {
        self.span(&mut name.span);
    }

    fn indices(self, own: &mut Indices) {
        self.span(&mut own.span);
        self.all(&mut own.filter);
        for entry in &mut own.entries {
            self.span(&mut entry.span);
            match &mut entry.kind {
                IndexKind::Member(at) => self.expr(at),
                IndexKind::Range { variable, from, to } => {
                    variable.iter_mut().for_each(|name| self.name(name));
                    self.all([from, to]);
                }
                IndexKind::Rows { variable, table } => [variable, table].into_iter().for_each(|name| self.name(name)),
            }
        }
    }

    fn binding(self, own: &mut Binding) {
        self.name(&mut own.name);
        own.indices.iter_mut().for_each(|indices| self.indices(indices));
        own.unit.iter_mut().for_each(|unit| unit.0 = unit.0.wrapping_add(self.units));
        self.all(own.value.iter_mut().chain(&mut own.uncertainty));
    }

    pub(super) fn kept(self, own: &mut Kept) {
        match own {
            Kept::Number(_) | Kept::Name(_) => {}
            Kept::Prime(inner) | Kept::Negate(inner) | Kept::Not(inner) => self.expr(inner),
            Kept::Power(left, right) | Kept::Compare(_, left, right) => self.all([left, right]),
            Kept::Product(members) | Kept::Sum(members) => {
                members.iter_mut().for_each(|own| *own = self.member(own));
            }
            Kept::Vector(list) | Kept::And(list) | Kept::Or(list) => self.all(list.iter_mut()),
            Kept::Index(base, indices) => self.all(indices.iter_mut().chain([base])),
            Kept::Field(base, field) => {
                self.expr(base);
                self.name(field);
            }
            Kept::Call(own) => {
                self.name(&mut own.0);
                self.all(own.1.iter_mut());
            }
            Kept::SumOver(indices, body) | Kept::IntegralOver(indices, body) => {
                self.indices(indices);
                self.expr(body);
            }
        }
    }

    pub(super) fn unit(self, own: &mut KeptUnit) {
        match own {
            KeptUnit::One | KeptUnit::Name(_) => {}
            KeptUnit::Power(base, ..) => base.0 = base.0.wrapping_add(self.units),
            KeptUnit::Product(factors) => {
                factors.iter_mut().for_each(|(_, factor)| factor.0 = factor.0.wrapping_add(self.units));
            }
        }
    }

    /// Whether a statement is one of those that are copied: there are few others in a file.
    fn statement(self, own: &mut Statement) -> bool {
        self.span(&mut own.span);
        match &mut own.kind {
            StatementKind::Param(all) | StatementKind::Coord { declarations: all } => {
                all.iter_mut().for_each(|own| self.binding(own));
            }
            StatementKind::Let(binding)
            | StatementKind::Force(binding)
            | StatementKind::Guess { binding, .. }
            | StatementKind::Equilibrium { binding, .. } => self.binding(binding),
            StatementKind::Kinetic(value)
            | StatementKind::Potential(value)
            | StatementKind::Lagrangian(value)
            | StatementKind::Dissipation(value) => self.expr(value),
            StatementKind::Constraint { indices, left, right } => {
                indices.iter_mut().for_each(|own| self.indices(own));
                self.all([left, right]);
            }
            StatementKind::Model { .. }
            | StatementKind::Draw { .. }
            | StatementKind::Assume(_)
            | StatementKind::Period(_)
            | StatementKind::Table { .. } => return false,
        }
        true
    }
}

/// A text that was read, and what another one has in common with it.
pub(super) struct Old<'o> {
    file: &'o File,
    text: &'o str,
    /// The part that is not in the other text: what is before and behind it is.
    changed: Range<usize>,
    /// By how much what is behind is further on there, modulo 2^32.
    shift: u32,
}

impl<'o> Old<'o> {
    pub(super) fn new(file: &'o File, text: &'o str, new: &str) -> Self {
        let alike = |(own, other): &(u8, u8)| own == other;
        let start = text.bytes().zip(new.bytes()).take_while(alike).count();
        let most = text.len().min(new.len()) - start;
        let end = text.bytes().rev().zip(new.bytes().rev()).take(most).take_while(alike).count();
        let shift = (new.len() as u32).wrapping_sub(text.len() as u32);
        Self { file, text, changed: start..text.len() - end, shift }
    }
}

/// What an energy is.
fn energy(kind: &mut StatementKind) -> Option<&mut ExprRef> {
    let (StatementKind::Kinetic(own)
    | StatementKind::Potential(own)
    | StatementKind::Lagrangian(own)
    | StatementKind::Dissipation(own)) = kind
    else {
        return None;
    };
    Some(own)
}

impl Builder {
    /// Copies the statement at `span` of `source`, if it was read before.
    pub(super) fn reuse(&mut self, old: &Old<'_>, source: &str, span: Span) -> bool {
        for bytes in [0, old.shift] {
            let start = span.start.wrapping_sub(bytes);
            let Ok(at) = old.file.statements.binary_search_by_key(&start, |own| own.span.start) else { continue };
            let Some(was) = old.file.statements.get(at) else { continue };
            if old.text.get(was.span.range()) == source.get(span.range()) {
                let (expressions, units) = (&old.file.expressions, &old.file.units);
                let (own, own_units) = (expressions.places(was.span), units.places(was.span));
                let shift = self.shift(&own, &own_units, bytes);
                let mut statement = was.clone();
                let is_copied = shift.statement(&mut statement);
                if is_copied {
                    self.expressions.get_mut().copy(expressions, own, shift);
                    self.units.copy(units, own_units, shift);
                    self.statements.push(statement);
                }
                return is_copied;
            }
            let is_changed = bytes == 0 && was.span.end.wrapping_add(old.shift) == span.end;
            if is_changed && self.long_sum(old, source, was, span).is_some() {
                return true;
            }
        }
        false
    }

    /// What becomes of these when they are copied behind all others.
    fn shift(&mut self, expressions: &Range<usize>, units: &Range<usize>, bytes: u32) -> Shift {
        let further = |len: usize, from: &Range<usize>| (len as u32).wrapping_sub(from.start as u32);
        let all = self.expressions.get_mut().len();
        Shift { expressions: further(all, expressions), units: further(self.units.len(), units), bytes }
    }

    /// Copies terms with their expressions.
    fn terms(&mut self, from: &File, own: Range<usize>, terms: &[Member], bytes: u32, all: &mut Vec<Member>) {
        let shift = self.shift(&own, &(0..0), bytes);
        self.expressions.get_mut().copy(&from.expressions, own, shift);
        all.extend(terms.iter().map(|own| shift.member(own)));
    }

    /// An energy that is a sum: terms before and behind the change are copied, and those between them are read as a sum with 0
    /// in place of the others.
    fn long_sum(&mut self, old: &Old<'_>, source: &str, was: &Statement, span: Span) -> Option<()> {
        let mut kind = was.kind.clone();
        let root = *energy(&mut kind)?;
        let whole = old.file.expr(root);
        let ExprKind::Sum(terms) = whole.kind else { return None };
        let place = |own: &Member| old.file.expr(own.value()).span;
        // The terms from `first` to `last` are read. Places of terms in brackets are within these: next to one, nothing is read.
        let first = terms.partition_point(|own| place(own).start as usize <= old.changed.start).checked_sub(1)?;
        let kept = terms.partition_point(|own| (place(own).end as usize) < old.changed.end).max(first) + 1;
        let last = (kept < terms.len()).then_some(kept);
        let front = place(terms.get(first.checked_sub(1).filter(|own| *own > 0)?)?).end;
        let back = last.map(|own| place(&terms[own]).start.wrapping_add(old.shift));
        let between = source.get(front as usize..back.unwrap_or(span.end) as usize)?;
        let text = format!("{HEAD}{between}{}", if back.is_some() { "0" } else { "" });
        let mut builder = Self::new(Vec::new(), 1);
        builder.statement(&text, Span::new(0, text.len() as u32)).ok()?;
        let new = builder.finish();
        let sum = new.expressions.iter().next_back()?;
        let ExprKind::Sum([head, read @ ..]) = sum.kind else { return None };
        let is_zero = |own: &Member, start: usize| {
            let own = new.expr(own.value());
            own.kind == ExprKind::Number("0") && own.span.start as usize == start
        };
        let (read, tail) = match back {
            Some(_) => read.split_last().map(|(tail, read)| (read, Some(tail)))?,
            None => (read, None),
        };
        if !is_zero(head, HEAD.len() - 1) || tail.is_some_and(|own| !is_zero(own, text.len() - 1)) {
            return None;
        }
        let behind = |term: usize| terms[term].value().0 as usize + 1;
        let bytes = front.wrapping_sub(HEAD.len() as u32);
        let mut all = Vec::with_capacity(terms.len() + read.len());
        let start = old.file.expressions.places(was.span).start;
        self.terms(old.file, start..behind(first - 1), &terms[..first], 0, &mut all);
        let count = new.expressions.len() - 1 - usize::from(back.is_some());
        self.terms(&new, 1..count, read, bytes, &mut all);
        let mut end = sum.span.end.wrapping_add(bytes);
        if let Some(last) = last {
            // The sign in front is as it was.
            self.terms(old.file, behind(last - 1)..root.0 as usize, &terms[last..], old.shift, &mut all);
            end = whole.span.end.wrapping_add(old.shift);
        }
        *energy(&mut kind)? = self.push(Span::new(whole.span.start, end), ExprKind::Sum(&all));
        self.statements.push(Statement { span, kind });
        Some(())
    }
}
