//! Long statements, read in pieces.
//!
//! Every region that [`cut`] finds is read piece by piece and its terms joined; in the text around
//! it a `0` takes its place, which is exchanged for the sum when the tree is built. Where anything
//! goes wrong the statement is read once more in one piece, so that a mistake is reported as if
//! nothing had been cut.

use std::cell::{Cell, RefCell};

use pest::Parser;

use super::expressions::Operand;
use super::{Builder, statement_in};
use crate::span::Span;
use crate::syntax::ast::{ExprKind, ExprRef, Member, StatementKind};
use crate::syntax::cut::{self, Region};
use crate::syntax::grammar::{Grammar, Rule};

/// Longer statements are read in pieces of about this many bytes, as far as they are sums.
const PIECE: u32 = 1 << 14;
/// The text in the place of a sum.
const STAND_IN: &str = "0";

/// A sum that has been read.
#[derive(Clone, Copy, Debug)]
pub(super) struct Known {
    span: Span,
    expr: ExprRef,
}

/// Where the text given to pest stands in the file.
#[derive(Debug, Default)]
pub(super) struct Places {
    /// Where the text begins, while nothing is replaced in it.
    offset: Cell<u32>,
    /// From which place in the text on which place in the file, rising.
    shifts: RefCell<Vec<(u32, u32)>>,
    /// Places in the text where a stand-in begins, rising, with what it stands for.
    stand_ins: RefCell<Vec<(u32, ExprRef)>>,
    /// How many of them the tree has used.
    used: Cell<usize>,
}

impl Places {
    /// A text that is taken from the file as it is.
    pub(super) fn plain(&self, offset: u32) {
        self.offset.set(offset);
        self.shifts.borrow_mut().clear();
        self.stand_ins.borrow_mut().clear();
        self.used.set(0);
    }

    /// The place in the file.
    pub(super) fn of(&self, at: u32) -> u32 {
        let shifts = self.shifts.borrow();
        let before = shifts.partition_point(|(from, _)| *from <= at);
        match before.checked_sub(1).and_then(|last| shifts.get(last)) {
            Some((from, to)) => at - from + to,
            None => at + self.offset.get(),
        }
    }

    /// What stands for the expression that begins there.
    pub(super) fn stand_in(&self, at: usize) -> Option<ExprRef> {
        let stand_ins = self.stand_ins.borrow();
        if stand_ins.is_empty() {
            return None;
        }
        let found = stand_ins.binary_search_by_key(&(at as u32), |(from, _)| *from);
        let (_, expr) = stand_ins.get(found.ok()?)?;
        self.used.set(self.used.get() + 1);
        Some(*expr)
    }

    /// The text at `span` with stand-ins for what is known in it.
    fn text(&self, source: &str, span: Span, known: &[Known]) -> String {
        self.plain(span.start);
        let mut shifts = self.shifts.borrow_mut();
        let mut stand_ins = self.stand_ins.borrow_mut();
        let mut text = String::new();
        let mut at = span.start;
        for one in known {
            text.push_str(source.get(Span::new(at, one.span.start).range()).unwrap_or(""));
            stand_ins.push((text.len() as u32, one.expr));
            shifts.push((text.len() as u32, one.span.start));
            text.push_str(STAND_IN);
            at = one.span.end;
            shifts.push((text.len() as u32, at));
        }
        text.push_str(source.get(Span::new(at, span.end).range()).unwrap_or(""));
        text
    }

    fn all_used(&self) -> bool {
        self.used.get() == self.stand_ins.borrow().len()
    }
}

impl Builder {
    /// Reads a statement in pieces of about [`PIECE`] bytes; `None` if it can't be cut or if
    /// something in it is wrong.
    pub(super) fn in_pieces(&mut self, source: &str, span: Span) -> Option<StatementKind> {
        if span.end - span.start <= PIECE {
            return None;
        }
        let regions = cut::regions(source, span, PIECE);
        if regions.is_empty() {
            return None;
        }
        let before = self.expressions.borrow().mark();
        let units = self.units.len();
        let kind = self.joined(source, span, regions);
        if kind.is_none() {
            self.error.take();
            self.in_filter.set(false);
            self.expressions.borrow_mut().back_to(before);
            self.units.back_to(units);
        }
        self.places.plain(span.start);
        kind
    }

    fn joined(&mut self, source: &str, span: Span, regions: Vec<Region>) -> Option<StatementKind> {
        let mut known: Vec<Known> = Vec::new();
        for region in regions {
            let within = known.partition_point(|one| one.span.start < region.span.start);
            let inner = known.split_off(within);
            let expr = self.region(source, &region, &inner)?;
            known.push(Known { span: region.span, expr });
        }
        let text = self.places.text(source, span, &known);
        let statement = statement_in(Grammar::parse(Rule::single, &text).ok()?)?;
        let kind = self.kind(statement).ok()?;
        let whole = self.places.all_used() && self.error.borrow().is_none();
        whole.then_some(kind)
    }

    fn region(&self, source: &str, region: &Region, inner: &[Known]) -> Option<ExprRef> {
        let mut terms = Vec::new();
        let mut start = region.span.start;
        let mut subtracted = false;
        let mut inner = inner;
        let ends = region.signs.iter().map(Some).chain([None]);
        for sign in ends {
            let end = sign.map_or(region.span.end, |sign| sign.span.start);
            let within = inner.partition_point(|one| one.span.start < end);
            let (here, later) = inner.split_at(within);
            inner = later;
            self.piece(source, Span::new(start, end), here, subtracted, &mut terms)?;
            if let Some(sign) = sign {
                start = sign.span.end;
                subtracted = sign.subtracted;
            }
        }
        Some(self.push(region.span, ExprKind::Sum(&terms)))
    }

    /// Adds the terms of a piece to those before it.
    fn piece(
        &self,
        source: &str,
        span: Span,
        known: &[Known],
        subtracted: bool,
        terms: &mut Vec<Member>,
    ) -> Option<()> {
        let replaced;
        let text = if known.is_empty() {
            self.places.plain(span.start);
            source.get(span.range())?
        } else {
            replaced = self.places.text(source, span, known);
            &replaced
        };
        let alone = Grammar::parse(Rule::alone, text).ok()?.next()?;
        let expr = alone.into_inner().find(|pair| pair.as_rule() == Rule::expr)?;
        let operand: Operand<'_> = self.operand(expr);
        match operand.sum() {
            Ok(more) => {
                let (first, rest) = more.split_first()?;
                terms.push(Member::new(subtracted, first.value()));
                terms.extend(rest);
            }
            Err(operand) => terms.push(Member::new(subtracted, self.close(operand))),
        }
        let whole = self.places.all_used() && self.error.borrow().is_none();
        whole.then_some(())
    }
}
