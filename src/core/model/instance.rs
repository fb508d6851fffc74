//! The instances of a term: what each fills the slots with, and stretches of instances that do so alike.
//!
//! Along an index, members mostly follow each other evenly and terms keep their form. So a light run
//! ([`World::run_light`](super::names::World)) finds out for the first instance of a stretch not only what fills the
//! slots, but also how much each grows from one instance to the next (its step), and for how many further instances
//! all this holds (the reach): until a member lies in another box, two leaves meet, or a table ends; and for none
//! where something depends on the index in any other way.

use super::names::{Grid, Key, World};
use super::program::{Binder, IndexForm, IndexOp, IndexProgram, Op};
use crate::number::Number;

/// Larger steps are left to runs of their own, so that nothing overflows.
const LONGEST_STEP: i64 = 1 << 20;

/// Families with more members given one by one change from one instance to the next.
const MOST_SINGLES: usize = 16;

/// What a slot of a term is filled with.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) enum Leaf {
    Coordinate(usize),
    Parameter(usize),
    Field { table: usize, row: i64, column: usize },
    Number(Number),
}

impl Leaf {
    /// By how much another leaf lies beyond this one; `None` where they never meet.
    fn distance(&self, other: &Self) -> Option<i64> {
        match (self, other) {
            (Self::Coordinate(a), Self::Coordinate(b)) | (Self::Parameter(a), Self::Parameter(b)) => {
                i64::try_from(*b).ok()?.checked_sub(i64::try_from(*a).ok()?)
            }
            (Self::Field { table, row, column }, Self::Field { table: other_table, row: other_row, column: other }) => {
                (table == other_table && column == other).then(|| other_row - row)
            }
            (Self::Number(a), Self::Number(b)) if a == b => Some(0),
            // What has a step is whole.
            (Self::Number(a), Self::Number(b)) => b.to_i64()?.checked_sub(a.to_i64()?),
            (Self::Coordinate(_) | Self::Parameter(_) | Self::Field { .. } | Self::Number(_), _) => None,
        }
    }
}

/// The slots of one instance of a term and of those that follow it, and the way that led to them.
#[derive(Debug, Default)]
pub(super) struct Instance {
    pub(super) signature: Vec<u32>,
    pub(super) leaves: Vec<Leaf>,
    /// How much each leaf grows from one instance to the next.
    pub(super) steps: Vec<i64>,
    /// For how many further instances signature and steps hold.
    pub(super) reach: u64,
    pub(super) in_exponent: usize,
}

impl Instance {
    /// Empty, with so many further instances at most.
    pub(super) fn clear(&mut self, reach: u64) {
        self.signature.clear();
        self.leaves.clear();
        self.steps.clear();
        self.reach = reach;
        self.in_exponent = 0;
    }

    /// The slot of a leaf; a leaf met before keeps its slot.
    pub(super) fn slot(&mut self, leaf: Leaf, step: i64) -> usize {
        // Terms have few slots; the search is short.
        let mut found = None;
        for (slot, (own, own_step)) in self.leaves.iter().zip(&self.steps).enumerate() {
            let Some(distance) = own.distance(&leaf) else { continue };
            self.reach = self.reach.min(apart(distance, step - own_step));
            if distance == 0 {
                found = Some(slot);
                break;
            }
        }
        let slot = found.unwrap_or_else(|| {
            self.leaves.push(leaf);
            self.steps.push(step);
            self.leaves.len() - 1
        });
        self.signature.push(u32::try_from(slot).unwrap_or(u32::MAX));
        slot
    }

    /// Notes a number that decides the form of the term.
    pub(super) fn note(&mut self, number: i64) {
        let bits = number.cast_unsigned();
        self.signature.push((bits >> 32) as u32);
        self.signature.push((bits & 0xffff_ffff) as u32);
    }

    /// Notes an index that decides the form of the term.
    pub(super) fn note_index(&mut self, index: Along) {
        self.note(index.value);
        self.limit(if index.step == 0 { u64::MAX } else { 0 });
    }

    /// A number as a slot or, in exponents, as part of the form.
    pub(super) fn note_number(&mut self, number: Number, step: i64) {
        if self.in_exponent == 0 {
            self.slot(Leaf::Number(number), step);
            return;
        }
        self.limit(if step == 0 { u64::MAX } else { 0 });
        if let Some(integer) = number.to_i64() {
            self.note(integer);
        } else {
            self.signature.extend(number.to_string().bytes().map(u32::from));
        }
    }

    /// Enters an exponent, or leaves it.
    pub(super) fn exponent(&mut self, op: &Op) {
        if matches!(op, Op::BeginExponent) { self.in_exponent += 1 } else { self.in_exponent -= 1 }
    }

    /// A step, and where there is none that what was found holds for this instance only.
    pub(super) fn step(&mut self, step: Option<i64>) -> i64 {
        self.limit(if step.is_some() { u64::MAX } else { 0 });
        step.unwrap_or(0)
    }

    /// That what was found holds for so many further instances only.
    pub(super) fn limit(&mut self, reach: u64) {
        self.reach = self.reach.min(reach);
    }
}

/// For how many steps two leaves stay apart, or together where they are.
fn apart(distance: i64, step: i64) -> u64 {
    if step == 0 {
        u64::MAX
    } else if distance == 0 {
        0
    } else if distance.checked_rem(step) == Some(0) && (distance < 0) != (step < 0) {
        (distance / step).unsigned_abs() - 1
    } else {
        u64::MAX
    }
}

/// An index along a stretch: its value at the first instance, and how much it grows from one to the next.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Along {
    pub(super) value: i64,
    pub(super) step: i64,
}

/// Up to three indices at the first instance; unused ones are 0.
pub(super) fn key_of(at: &[Along]) -> Key {
    std::array::from_fn(|axis| at.get(axis).map_or(0, |index| index.value))
}

/// For how many steps indices stay within a box, or out of it where they are.
pub(super) fn same_side(at: &[Along], lower: &[i64], upper: &[i64]) -> u64 {
    // The steps after which they are within: an interval.
    let (mut first, mut last) = (0, i64::MAX);
    for (axis, Along { value, step }) in at.iter().enumerate() {
        let (low, high) = (lower[axis] - value, upper[axis] - value);
        if *step == 0 {
            if low > 0 || high < 0 {
                return u64::MAX;
            }
            continue;
        }
        let (low, high) = if *step > 0 { (low, high) } else { (-high, -low) };
        let step = step.abs();
        first = first.max(-(-low).div_euclid(step));
        last = last.min(high.div_euclid(step));
    }
    if first > last { u64::MAX } else { (if first > 0 { first - 1 } else { last }).unsigned_abs() }
}

impl Grid {
    /// For how many steps the indices stay in the same boxes.
    pub(super) fn steady(&self, at: &[Along]) -> u64 {
        if at.iter().all(|index| index.step == 0) {
            return u64::MAX;
        }
        if self.singles.len() > MOST_SINGLES {
            return 0;
        }
        let boxes = self.blocks.iter().map(|block| same_side(at, &block.lower, &block.upper));
        let singles = self.singles.keys().map(|key| same_side(at, key, key));
        boxes.chain(singles).min().unwrap_or(u64::MAX)
    }

    /// How much the number of a member grows with each step, as long as these stay in the same boxes.
    pub(super) fn growth(&self, at: &[Along]) -> i64 {
        let key = key_of(at);
        let Some(block) = self.blocks.iter().find(|block| block.contains(&key)) else { return 0 };
        let stride = |axis: usize| (axis + 1..3).map(|inner| block.extent(inner)).product::<usize>();
        let strides = (0..at.len()).map(|axis| i64::try_from(stride(axis)).unwrap_or(i64::MAX));
        strides.zip(at).map(|(stride, index)| stride.saturating_mul(index.step)).sum()
    }
}

impl IndexProgram {
    /// Whether it depends on an index variable of which this is true.
    pub(super) fn depends(&self, on: impl Fn(usize) -> bool) -> bool {
        self.ops.iter().any(|(op, _)| matches!(op, IndexOp::Variable(slot) if on(*slot)))
    }

    /// How many of so many index variables it takes to know it, one at least.
    pub(super) fn known_after(&self, most: usize) -> usize {
        (1..most).find(|after| !self.depends(|slot| slot >= *after)).unwrap_or(most)
    }

    /// Whether it depends on index variables.
    pub(super) fn varies(&self) -> bool {
        self.depends(|_| true)
    }

    /// Whether it depends on variables that move.
    pub(super) fn moves(&self, steps: &[i64]) -> bool {
        self.depends(|slot| steps.get(slot).is_some_and(|step| *step != 0))
    }
}

impl World {
    /// How much an index grows with each step of the variables; `None` where it may do so unevenly.
    pub(super) fn growth(&self, index: &IndexProgram, slots: &[i64], steps: &[i64]) -> Option<i64> {
        if !index.moves(steps) {
            return Some(0);
        }
        match &index.form {
            IndexForm::Constant(_) => Some(0),
            IndexForm::Shifted { slot, .. } => steps.get(*slot).copied(),
            IndexForm::RowField { .. } => None,
            IndexForm::General => {
                let further: Vec<i64> = slots.iter().zip(steps).map(|(value, step)| value + step).collect();
                let linear = further.len() == slots.len() && is_linear(&index.ops, steps);
                let ends = linear.then(|| [slots, &further].map(|slots| self.integer(index, slots)));
                // Whole at both ends of a step, so whole after any number of them.
                let [Ok(here), Ok(there)] = ends? else { return None };
                Some(there - here).filter(|step| step.abs() < LONGEST_STEP)
            }
        }
    }

    /// How much the variable of a sum within a term grows with each step of those outside; `None` where its range
    /// changes otherwise.
    pub(super) fn binder_growth(&self, binder: &Binder, steps: &[i64]) -> Option<i64> {
        let simple = |index: &IndexProgram| match &index.form {
            _ if !index.moves(steps) => Some(0),
            IndexForm::Shifted { slot, .. } => steps.get(*slot).copied(),
            IndexForm::Constant(_) | IndexForm::RowField { .. } | IndexForm::General => None,
        };
        let [from, to] = &binder.ends;
        simple(from).filter(|step| simple(to) == Some(*step))
    }
}

/// Whether a number is linear in the variables that move.
fn is_linear(ops: &[(IndexOp, crate::span::Span)], steps: &[i64]) -> bool {
    // For each number on the stack whether it moves.
    let mut stack: Vec<bool> = Vec::new();
    for (op, _) in ops {
        let operands = stack.split_off(stack.len().saturating_sub(op.operands()));
        let moving = operands.iter().filter(|moves| **moves).count();
        let linear = match op {
            IndexOp::Negate | IndexOp::Sum(_) => true,
            IndexOp::Product(divided) => {
                moving == 0 || (moving == 1 && !operands.iter().zip(divided).any(|(moves, divided)| *moves && *divided))
            }
            // Nothing else is linear in what moves.
            _ => moving == 0,
        };
        if !linear {
            return false;
        }
        let moves = matches!(op, IndexOp::Variable(slot) if steps.get(*slot).is_some_and(|step| *step != 0));
        stack.push(moves || moving > 0);
    }
    true
}
