//! Filters over pairs of rows, as `where a < b and (a.x - b.x)^2 + (a.y - b.y)^2 <= c^2`, without a visit to every pair.
//!
//! What a filter reads of the last index alone are a few numbers for each of its values: points, which a tree of
//! nested boxes holds (a k-d tree). With the other indices fixed, the filter is evaluated for whole boxes, in enclosures:
//! where it is false of a box it is false of all values in it. So any filter that compares is sieved, not only distances,
//! and what is left is exactly what visiting all pairs would leave. A box in which some value might have no value (a
//! divisor that may be 0) is opened down to its values, and these are left to the exact evaluation.

use std::cmp::Ordering;

use super::ModelError;
use super::index::{Quantity, is_so};
use super::names::World;
use super::program::{Binder, IndexOp, IndexProgram};
use super::run::MOST_INSTANCES;
use crate::order::Order;
use crate::precision::{Function, Interval, Scalar};
use crate::span::Span;

/// Shorter indices are visited one by one.
const LEAST_VALUES: usize = 32;

/// Longer ones, too: points and boxes would take as much memory as the terms.
const MOST_VALUES: usize = 1 << 20;

/// A box with so few values is not divided.
const MOST_IN_LEAF: usize = 4;

/// How many values of the first index are tried to foresee the number of terms.
const SAMPLES: u64 = 64;

/// What a filter is made of: the parts that depend on the last index alone, those that do not depend on it, and
/// operations on both.
#[derive(Clone, Debug)]
enum Step {
    Inner(usize),
    Outer(usize),
    Apply(IndexOp),
}

/// A part of a filter while it is taken apart.
struct Piece {
    /// Where its operations stand.
    from: usize,
    to: usize,
    outer: bool,
    inner: bool,
    steps: Vec<Step>,
}

/// The values of the last index of a sum, for one of its filters.
#[derive(Debug)]
pub(super) struct Sieve {
    /// Which of the filters.
    pub(super) filter: usize,
    steps: Vec<Step>,
    /// After how many steps another part of an `and` around all is known.
    parts: Vec<usize>,
    outer: Vec<IndexProgram>,
    /// The first value of the index.
    first: i64,
    /// For each value what the filter reads of it, and the value itself: `width` numbers.
    points: Vec<Interval>,
    width: usize,
    /// The values, from 0, in the order of the tree.
    order: Vec<u32>,
    /// For each node of the tree what holds its points, `width` intervals. The children of node k are 2k and 2k + 1.
    boxes: Vec<Interval>,
}

/// A value that a sieve leaves, and whether the filter is certain to hold of it.
pub(super) type Left = (i64, bool);

impl World {
    /// The sieve of the last index, where there is a filter for one; `None` where all values are to be visited.
    pub(super) fn sieve(
        &self,
        binders: &[Binder],
        filters: &[(usize, &IndexProgram)],
        span: Span,
    ) -> Result<Option<Sieve>, ModelError> {
        let [first, last] = binders else { return Ok(None) };
        let pair = filters
            .iter()
            .position(|(after, filter)| *after == 2 && [0, 1].iter().all(|slot| filter.depends(|own| own == *slot)));
        let (Some(filter), Some(outer)) = (pair, self.fixed_count(std::slice::from_ref(first))) else {
            return Ok(None);
        };
        let (start, _) = self.binder_range(first, &[])?;
        let range = if last.is_fixed() {
            Some(self.binder_range(last, &[])?)
        } else {
            let mut hull: Option<(i64, i64)> = None;
            for value in start..start.saturating_add_unsigned(outer) {
                let Ok((from, to)) = self.binder_range(last, &[value]) else { return Ok(None) };
                if from <= to {
                    hull = Some(hull.map_or((from, to), |own| (own.0.min(from), own.1.max(to))));
                }
            }
            hull
        };
        let Some(range) = range else { return Ok(None) };
        let Some(sieve) = Sieve::new(self, filter, filters[filter].1, range) else { return Ok(None) };
        let all = outer.saturating_mul(sieve.order.len() as u64);
        if all > MOST_INSTANCES {
            let step = (outer / SAMPLES).max(1);
            let tried = (0..outer).step_by(usize::try_from(step).unwrap_or(usize::MAX));
            let (mut count, mut found) = (0_u64, 0_u64);
            for value in tried {
                let slots = [start.saturating_add_unsigned(value)];
                let range = self.binder_range(last, &slots)?;
                count += 1;
                found += sieve.left(self, &slots, range).map_or(sieve.order.len(), |left| left.len()) as u64;
            }
            if found.saturating_mul(outer) / count.max(1) > MOST_INSTANCES {
                return Err(super::run::too_many_terms(span));
            }
        }
        Ok(Some(sieve))
    }
}

impl Sieve {
    fn new(world: &World, number: usize, filter: &IndexProgram, range: (i64, i64)) -> Option<Self> {
        let ops = &filter.ops;
        let count =
            usize::try_from(range.1 - range.0 + 1).ok().filter(|count| (LEAST_VALUES..=MOST_VALUES).contains(count))?;
        let program =
            |piece: &Piece| IndexProgram::new(ops.get(piece.from..piece.to).unwrap_or_default().to_vec(), filter.span);
        let (mut inner, mut outer, mut parts) = (Vec::new(), Vec::new(), Vec::new());
        let mut pieces: Vec<Piece> = Vec::new();
        for (at, (op, _)) in ops.iter().enumerate() {
            let operands = pieces.split_off(pieces.len().checked_sub(op.operands())?);
            let slot = if let IndexOp::Variable(slot) = op { Some(*slot) } else { None };
            let mut piece = Piece {
                from: operands.first().map_or(at, |first| first.from),
                to: at + 1,
                outer: slot == Some(0) || operands.iter().any(|own| own.outer),
                inner: slot == Some(1) || operands.iter().any(|own| own.inner),
                steps: Vec::new(),
            };
            if piece.outer && piece.inner {
                for own in operands {
                    match (own.outer, own.inner) {
                        (true, true) => piece.steps.extend(own.steps),
                        (false, true) => {
                            piece.steps.push(Step::Inner(inner.len()));
                            inner.push(program(&own));
                        }
                        (_, false) => {
                            piece.steps.push(Step::Outer(outer.len()));
                            outer.push(program(&own));
                        }
                    }
                    if at + 1 == ops.len() && matches!(op, IndexOp::And(_)) {
                        parts.push(piece.steps.len());
                    }
                }
                piece.steps.push(Step::Apply(op.clone()));
            }
            pieces.push(piece);
        }
        let whole = pieces.pop().filter(|whole| whole.outer && whole.inner)?;
        let width = inner.len() + 1;
        let mut points = Vec::with_capacity(width * count);
        for value in range.0..=range.1 {
            for program in &inner {
                points.push(enclosed(world, program, &[0, value])?);
            }
            points.push(Interval::point(value as f64));
        }
        let order = (0..u32::try_from(count).ok()?).collect();
        let (steps, boxes) = (whole.steps, Vec::new());
        let mut own = Self { filter: number, steps, parts, outer, first: range.0, points, width, order, boxes };
        // The index itself divides only where there is nothing else: boxes are to be small in space.
        let plain = |program: &IndexProgram| matches!(program.ops.as_slice(), [(IndexOp::Variable(_), _)]);
        let mut axes: Vec<usize> = (0..inner.len()).filter(|k| !plain(&inner[*k])).collect();
        if axes.is_empty() {
            axes.push(inner.len());
        }
        own.divide(&axes);
        Some(own)
    }

    fn point(&self, value: u32) -> &[Interval] {
        let from = value as usize * self.width;
        self.points.get(from..from + self.width).unwrap_or(&[])
    }

    /// Orders the values so that every node of the tree holds neighbours, and finds the boxes.
    fn divide(&mut self, axes: &[usize]) {
        let mut whole: Option<Vec<f64>> = None;
        let mut todo = vec![(1, 0, self.order.len())];
        while let Some((node, from, to)) = todo.pop() {
            let mut ends = vec![Interval::new(f64::INFINITY, f64::NEG_INFINITY); self.width];
            for value in &self.order[from..to] {
                for (Interval { lo, hi, .. }, own) in ends.iter_mut().zip(self.point(*value)) {
                    *lo = lo.min(own.lo);
                    *hi = hi.max(own.hi);
                }
            }
            let spread = |axis: usize| ends[axis].width();
            let scale = whole.get_or_insert_with(|| (0..self.width).map(spread).collect());
            let relative = |axis: usize| if scale[axis] > 0.0 { spread(axis) / scale[axis] } else { 0.0 };
            let widest = axes.iter().copied().max_by(|a, b| relative(*a).total_cmp(&relative(*b)));
            let place = node * self.width;
            self.boxes.resize(self.boxes.len().max(place + self.width), Interval::point(0.0));
            self.boxes[place..place + self.width].copy_from_slice(&ends);
            if to - from <= MOST_IN_LEAF {
                continue;
            }
            let middle = from.midpoint(to);
            let (points, width) = (&self.points, self.width);
            let key = |value: &u32| points[*value as usize * width + widest.unwrap_or(0)].lo;
            self.order[from..to].select_nth_unstable_by(middle - from, |a, b| key(a).total_cmp(&key(b)).then(a.cmp(b)));
            todo.extend([(2 * node, from, middle), (2 * node + 1, middle, to)]);
        }
    }

    /// The values in a range of which the filter may hold, ascending; `None` where only the exact evaluation tells.
    pub(super) fn left(&self, world: &World, slots: &[i64], range: (i64, i64)) -> Option<Vec<Left>> {
        let outer: Vec<Interval> =
            self.outer.iter().map(|program| enclosed(world, program, slots)).collect::<Option<_>>()?;
        let mut left = Vec::new();
        let mut stack = Vec::new();
        let mut todo = vec![(1, 0, self.order.len())];
        while let Some((node, from, to)) = todo.pop() {
            let all = self.boxes.get(node * self.width..(node + 1) * self.width)?;
            let is_out = all.last().is_none_or(|own| own.hi < range.0 as f64 || own.lo > range.1 as f64);
            let verdict = if is_out { Some(false) } else { self.verdict(all, &outer, &mut stack) };
            if verdict == Some(false) {
                continue;
            }
            if verdict.is_none() && to - from > MOST_IN_LEAF {
                let middle = from.midpoint(to);
                todo.extend([(2 * node, from, middle), (2 * node + 1, middle, to)]);
                continue;
            }
            for value in self.order.get(from..to)? {
                let verdict = verdict.or_else(|| self.verdict(self.point(*value), &outer, &mut stack));
                let value = self.first + i64::from(*value);
                if verdict != Some(false) && (range.0..=range.1).contains(&value) {
                    left.push((value, verdict == Some(true)));
                }
            }
        }
        left.put_in_order();
        Some(left)
    }

    /// Whether the filter holds everywhere in a box, or nowhere.
    fn verdict(&self, inner: &[Interval], outer: &[Interval], stack: &mut Vec<Interval>) -> Option<bool> {
        stack.clear();
        for (done, step) in (1..).zip(&self.steps) {
            let number = match step {
                Step::Inner(k) => *inner.get(*k)?,
                Step::Outer(k) => *outer.get(*k)?,
                Step::Apply(op) => {
                    let at = stack.len().checked_sub(op.operands())?;
                    let result = apply(op, stack.get(at..)?)?;
                    stack.truncate(at);
                    result
                }
            };
            if told(number) == Some(false) && self.parts.contains(&done) {
                return Some(false);
            }
            stack.push(number);
        }
        stack.pop().and_then(told)
    }
}

/// Conditions are numbers here: 1 where they hold, 0 where they do not, and [0, 1] where that is open.
fn condition(truth: Option<bool>) -> Interval {
    match truth {
        Some(true) => Interval::point(1.0),
        Some(false) => Interval::point(0.0),
        None => Interval::new(0.0, 1.0),
    }
}

fn told(condition: Interval) -> Option<bool> {
    if condition.hi <= 0.0 { Some(false) } else { (condition.lo > 0.0).then_some(true) }
}

fn is_condition(program: &IndexProgram) -> bool {
    let last = program.ops.last().map(|(op, _)| op);
    matches!(last, Some(IndexOp::Compare(_) | IndexOp::Not | IndexOp::And(_) | IndexOp::Or(_)))
}

/// An enclosure of what a part of a filter comes to; `None` where that is an error.
fn enclosed(world: &World, program: &IndexProgram, slots: &[i64]) -> Option<Interval> {
    let found = match world.quantity(program, slots) {
        Ok(Quantity::Truth(truth)) => condition(Some(truth)),
        Ok(number) => Interval::of_ball(&number.ball()),
        // An `and` or `or` around it may be decided by others.
        Err(_) if is_condition(program) => condition(None),
        Err(_) => return None,
    };
    found.is_usable().then_some(found)
}

/// How numbers of two intervals compare; `None` where it is open.
fn order(a: &Interval, b: &Interval) -> Option<Ordering> {
    let is_decided = a.hi < b.lo || a.lo > b.hi || a.width() == 0.0 && a == b;
    if is_decided { a.lo.partial_cmp(&b.lo) } else { None }
}

/// An operation on all members of its operands; `None` where one of them may have no value.
fn apply(op: &IndexOp, operands: &[Interval]) -> Option<Interval> {
    let sum = |terms: &mut dyn Iterator<Item = Interval>| {
        terms.reduce(|sum, term| sum.add(&term)).unwrap_or(Interval::point(0.0))
    };
    let all_are = |truth: bool| operands.iter().all(|own| told(*own) == Some(truth));
    let one_is = |truth: bool| operands.iter().any(|own| told(*own) == Some(truth));
    let result = match (op, operands) {
        (IndexOp::Negate, [a]) => a.neg(),
        (IndexOp::Sum(subtracted), _) => {
            sum(&mut operands.iter().zip(subtracted).map(|(term, minus)| if *minus { term.neg() } else { *term }))
        }
        (IndexOp::Product(divided), _) => {
            operands.iter().zip(divided).fold(Interval::point(1.0), |product, (factor, under)| {
                if *under { product.div(factor) } else { product.mul(factor) }
            })
        }
        (IndexOp::Power, [base, exponent]) => {
            let whole = exponent.lo == exponent.hi && exponent.lo.fract() == 0.0 && exponent.lo.abs() < 1e4;
            if whole { base.powi(exponent.lo as i32) } else { return None }
        }
        (IndexOp::Sqrt, [a]) => a.sqrt(),
        (IndexOp::Norm(_), _) => sum(&mut operands.iter().map(|part| part.powi(2))).sqrt(),
        (IndexOp::Apply(Function::Abs), [a]) => a.abs(),
        (IndexOp::Compare(comparison), [a, b]) => condition(order(a, b).map(|order| is_so(order, *comparison))),
        (IndexOp::Not, [a]) => condition(told(*a).map(|holds| !holds)),
        (IndexOp::And(_), _) => condition(if one_is(false) { Some(false) } else { all_are(true).then_some(true) }),
        (IndexOp::Or(_), _) => condition(if one_is(true) { Some(true) } else { all_are(false).then_some(false) }),
        // Of anything else nothing is told.
        _ => return None,
    };
    result.is_usable().then_some(result)
}
