//! Branch and prune: a box is cut into pieces until each has no equilibrium, or lies where there is exactly one.
//!
//! A piece X is dropped where an equation has no zero on it, or where Newton's operator in intervals (Hansen and Sengupta, BIT 21
//! (1981)) leaves nothing: for a zero z in X and the middle c, 0 = F(z) = F(c) + A (z - c) with some A of J(X), so that
//! z_i = c_i - (b_i + Σ_{j≠i} (YA)_ij (z_j - c_j))/(YA)_ii with b = Y F(c), for any Y. It drops no zero. What it
//! leaves is cut further; where Newton's method in doubles finds a zero close by, that is proved ([`super::root`]) with a region in
//! which it is the only one, and pieces within such a region are done. Nothing depends on the order of pieces.

use nalgebra::DMatrix;

use librate_core::budget::{Budget, Exceeded};
use librate_core::precision::{Ball, Interval, Scalar};

use super::forces::{Evaluator, Forces};
use super::poles::Poles;
use super::root::Root;
use super::symmetric::Symmetries;

/// Pieces this small beside the whole are not cut further, the first few that are not decided excepted.
const SMALLEST: f64 = 1.0 / (1_u64 << 24) as f64;
const FINEST: f64 = 1.0 / (1_u64 << 44) as f64;
const FEW_UNDECIDED: usize = 16;
/// The same where so many have not been decided that there is a line of equilibria.
const COARSE: f64 = 1.0 / 256.0;
const MANY_UNDECIDED: usize = 2000;
/// Operations after which what is left is undecided, where nobody watches the time.
const MOST_WORK: usize = 3_000_000_000;
/// Steps of Newton's method in doubles.
const MOST_STEPS: usize = 25;
/// A contraction is repeated where it leaves less than this of a side.
const WORTHWHILE: f64 = 0.75;
const MOST_ROUNDS: usize = 6;
/// Newton's operator has an approximate inverse on pieces no larger than this beside the whole.
const PRECONDITIONED: f64 = 0.05;
/// Rows are solved for each unknown up to so many.
const FEW: usize = 12;

/// What a search found.
#[derive(Default)]
pub(super) struct Findings {
    pub(super) roots: Vec<Root>,
    /// Pieces that were not decided.
    pub(super) undecided: Vec<Vec<Interval>>,
    /// Whether it ended before all was examined.
    pub(super) is_cut_short: bool,
    /// How many pieces there were.
    pub(super) pieces: usize,
}

/// A search under way.
pub(super) struct Search<'a> {
    pub(super) poles: &'a mut Poles,
    pub(super) intervals: Evaluator<Interval>,
    pub(super) doubles: Evaluator<f64>,
    pub(super) balls: Evaluator<Ball>,
    /// The values of parameters that vary.
    pub(super) parameters: Vec<Ball>,
    /// Where it searches.
    pub(super) whole: Vec<Interval>,
    /// What carries equilibria into each other.
    pub(super) symmetries: Symmetries,
    /// Equations that follow from the others.
    pub(super) moments: Option<Evaluator<Interval>>,
    found: Findings,
    scratch: Vec<Interval>,
    cost: usize,
}

/// What is left of a piece.
enum Left {
    Nothing,
    /// Whether derivatives are bounded on it, with these.
    Some(Option<Vec<Interval>>),
}

impl<'a> Search<'a> {
    pub(super) fn new(forces: &'a mut Forces, parameters: Vec<Ball>, whole: Vec<Interval>) -> Self {
        let n = forces.unknowns;
        Self {
            intervals: forces.prepare(),
            doubles: forces.prepare(),
            balls: forces.prepare(),
            cost: forces.operations() + 4 * n * n * n,
            poles: &mut forces.poles,
            parameters,
            whole,
            symmetries: Symmetries::default(),
            moments: None,
            found: Findings::default(),
            scratch: Vec::new(),
        }
    }

    /// Decides the whole box, or as much of it as can be.
    pub(super) fn run(mut self, budget: &Budget) -> Result<Findings, Exceeded> {
        let mut todo = vec![self.whole.clone()];
        while let Some(mut piece) = todo.pop() {
            budget.check()?;
            self.found.pieces += 1;
            let is_long = !budget.is_watched() && self.found.pieces.saturating_mul(self.cost) > MOST_WORK;
            if is_long || budget.is_nearly_spent() {
                self.found.is_cut_short = true;
                self.found.undecided.push(piece);
                self.found.undecided.append(&mut todo);
                break;
            }
            if self.symmetries.leave_aside(&mut piece) || self.is_known(&piece) {
                continue;
            }
            let Left::Some(slopes) = self.contract(&mut piece) else { continue };
            if slopes.is_some() && !self.is_known(&piece) {
                self.look_for(&piece);
            }
            if self.is_known(&piece) {
                continue;
            }
            let smallest = match self.found.undecided.len() {
                0..FEW_UNDECIDED => FINEST,
                FEW_UNDECIDED..=MANY_UNDECIDED => SMALLEST,
                _ => COARSE,
            };
            if self.share(&piece).1 < smallest {
                self.found.undecided.push(piece);
                continue;
            }
            todo.extend(self.cut(&piece, slopes.as_deref()));
        }
        Ok(self.found)
    }

    /// With the parameters behind.
    pub(super) fn inputs<S: Scalar>(&self, at: &[S], of: impl Fn(&Ball) -> S) -> Vec<S> {
        at.iter().cloned().chain(self.parameters.iter().map(of)).collect()
    }

    fn is_known(&self, piece: &[Interval]) -> bool {
        self.found.roots.iter().any(|root| root.holds(piece))
    }

    /// The side that is longest beside that of the whole, and how long.
    fn share(&self, piece: &[Interval]) -> (usize, f64) {
        let shares = piece.iter().zip(&self.whole).map(|(own, whole)| match whole.width() {
            0.0 => 0.0,
            width => own.width() / width,
        });
        shares.enumerate().fold((0, 0.0), |best, own| if own.1 > best.1 { own } else { best })
    }

    fn contract(&mut self, piece: &mut [Interval]) -> Left {
        let mut slopes = None;
        for _ in 0..MOST_ROUNDS {
            let inputs = self.inputs(piece, Interval::of_ball);
            if !self.balance(piece, &inputs) {
                return Left::Nothing;
            }
            let inputs = self.inputs(piece, Interval::of_ball);
            let force = self.intervals.force(&inputs);
            let Some((_, equations)) = force.split_last() else { return Left::Nothing };
            if force.iter().any(Interval::is_empty) || equations.iter().any(|own| !own.contains(0.0)) {
                return Left::Nothing;
            }
            let usable = |all: &[Interval]| all.iter().all(Interval::is_usable);
            let own = usable(&force).then(|| self.intervals.slopes(&inputs)).filter(|own| usable(own));
            let Some(own) = own else {
                let excluded = self.poles.exclude(&inputs, &mut self.scratch);
                return if excluded { Left::Nothing } else { Left::Some(None) };
            };
            let before: Vec<f64> = piece.iter().map(Interval::width).collect();
            if !self.newton(piece, &own) {
                return Left::Nothing;
            }
            slopes = Some(own);
            let shrank = piece.iter().zip(&before).any(|(own, before)| own.width() < WORTHWHILE * before);
            if !shrank {
                break;
            }
        }
        let inputs = self.inputs(piece, Interval::of_ball);
        if self.poles.exclude(&inputs, &mut self.scratch) { Left::Nothing } else { Left::Some(slopes) }
    }

    /// What sums of forces leave of a piece; false where that is nothing.
    fn balance(&mut self, piece: &mut [Interval], inputs: &[Interval]) -> bool {
        let Some(moments) = &mut self.moments else { return true };
        let values = moments.force(inputs);
        if values.iter().any(|own| !own.is_empty() && !own.contains(0.0)) {
            return false;
        }
        let centre: Vec<Interval> = piece.iter().map(|own| Interval::point(own.middle())).collect();
        let middle: Vec<Interval> = centre.iter().chain(&inputs[piece.len()..]).copied().collect();
        let (values, slopes) = (moments.force(&middle), moments.slopes(inputs));
        values.iter().zip(slopes.chunks(piece.len())).all(|(own, row)| {
            let is_usable = own.is_usable() && row.iter().all(Interval::is_usable);
            !is_usable || solve_row(piece, &centre, row, own, None)
        })
    }

    /// Newton's operator; false where nothing is left.
    fn newton(&mut self, piece: &mut [Interval], slopes: &[Interval]) -> bool {
        let n = piece.len();
        let centre: Vec<Interval> = piece.iter().map(|own| Interval::point(own.middle())).collect();
        let force = self.intervals.force(&self.inputs(&centre, Interval::of_ball));
        if !force.iter().all(Interval::is_usable) {
            return true;
        }
        for (i, own) in force.iter().take(n).enumerate() {
            let row = &slopes[n * i..n * (i + 1)];
            if !solve_row(piece, &centre, row, own, (n > FEW).then_some(i)) {
                return false;
            }
        }
        // Over large pieces slopes change too much for it.
        if self.share(piece).1 > PRECONDITIONED {
            return true;
        }
        let middle = DMatrix::from_fn(n, n, |i, j| slopes[n * i + j].middle());
        let Some(inverse) = middle.try_inverse() else { return true };
        for i in 0..n {
            let mut row = vec![Interval::point(0.0); n];
            let mut b = Interval::point(0.0);
            for k in 0..n {
                let y = Interval::point(inverse[(i, k)]);
                if inverse[(i, k)] == 0.0 {
                    continue;
                }
                b = b.add(&y.mul(&force[k]));
                for (slot, slope) in row.iter_mut().zip(&slopes[n * k..n * (k + 1)]) {
                    *slot = slot.add(&y.mul(slope));
                }
            }
            if !b.is_bounded() || row.iter().any(|own| !own.is_bounded()) {
                continue;
            }
            if !solve_row(piece, &centre, &row, &b, Some(i)) {
                return false;
            }
        }
        true
    }

    /// Newton's method in doubles from the middle of a piece, and a proof where it ends close by.
    fn look_for(&mut self, piece: &[Interval]) {
        let start: Vec<f64> = piece.iter().map(Interval::middle).collect();
        let Some(end) = self.follow(&start, piece) else { return };
        let may_hold = |root: &Root| end.iter().zip(&root.region).all(|(x, region)| region.contains(*x));
        if self.found.roots.iter().any(may_hold) {
            return;
        }
        let sides: Vec<f64> = piece.iter().zip(&self.whole).map(|(own, all)| side(own, all)).collect();
        if let Some(root) = self.prove(&end, &sides)
            && !self.found.roots.iter().any(|other| other.is_same(&root))
        {
            self.found.roots.push(root.clone());
            for image in self.symmetries.images(&root) {
                if !self.found.roots.iter().any(|other| other.is_same(&image)) {
                    self.found.roots.push(image);
                }
            }
        }
    }

    /// Where Newton's method leads, if it stays near a piece.
    fn follow(&mut self, start: &[f64], piece: &[Interval]) -> Option<Vec<f64>> {
        let sides = piece.iter().zip(&self.whole);
        let widths: Vec<f64> = sides.map(|(own, whole)| own.width().max(SMALLEST * whole.width())).collect();
        self.descend(start, &widths, &|step, at| {
            // A root further away belongs to another piece.
            let most = if step < 3 { 3.0 } else { 1.0 };
            let off = |(x, own): (&f64, &Interval)| (x - own.hi).max(own.lo - x);
            at.iter().zip(piece).zip(&widths).all(|(own, width)| off(own) <= most * width)
        })
    }

    /// Where Newton's method leads, if it stays about the box.
    pub(super) fn converged(&mut self, start: &[f64]) -> Option<Vec<f64>> {
        let widths: Vec<f64> = self.whole.iter().map(Interval::width).collect();
        let near = |at: &[f64]| at.iter().zip(start).zip(&widths).all(|((x, y), width)| (x - y).abs() <= *width);
        self.descend(start, &widths, &|_, at| near(at))
    }

    /// Newton's method in doubles, as long as it stays where it may be; steps are measured in widths.
    fn descend(&mut self, start: &[f64], widths: &[f64], may_be: &dyn Fn(usize, &[f64]) -> bool) -> Option<Vec<f64>> {
        let mut at = start.to_vec();
        let mut last = f64::INFINITY;
        for step in 0..MOST_STEPS {
            let change = self.step(&at)?;
            at.iter_mut().zip(&change).for_each(|(x, by)| *x -= by);
            if !may_be(step, &at) {
                return None;
            }
            // What rounding leaves of a step is none.
            let rest = |(by, x): (&f64, &f64)| (by.abs() - 4.0 * f64::EPSILON * x.abs()).max(0.0);
            let size =
                change.iter().zip(&at).map(rest).zip(widths).map(|(rest, width)| rest / width).fold(0.0, f64::max);
            if size < 1e-10 && (size >= 0.5 * last || size < 1e-15) {
                return Some(at);
            }
            last = size;
        }
        (last < 1e-9).then_some(at)
    }

    /// The step J⁻¹F of Newton's method.
    fn step(&mut self, at: &[f64]) -> Option<Vec<f64>> {
        let n = at.len();
        if n == 0 {
            return Some(Vec::new());
        }
        let inputs = self.inputs(at, Ball::mid_f64);
        let force = self.doubles.force(&inputs);
        let matrix = DMatrix::from_row_slice(n, n, &self.doubles.slopes(&inputs));
        let right = nalgebra::DVector::from_column_slice(&force[..n]);
        let step = matrix.lu().solve(&right)?;
        step.iter().all(|x| x.is_finite()).then(|| step.iter().copied().collect())
    }

    /// Two pieces: along the border of a region that is known, else in the middle of a side that matters.
    fn cut(&self, piece: &[Interval], slopes: Option<&[Interval]>) -> Vec<Vec<Interval>> {
        let (widest, share) = self.share(piece);
        let mut at = (widest, piece[widest].middle());
        if let Some(slopes) = slopes {
            let side = self.steepest(piece, slopes);
            let own = piece[side].width() / self.whole[side].width();
            if own > share / 16.0 {
                at = (side, piece[side].middle());
            }
        }
        'roots: for root in &self.found.roots {
            let mut border = None;
            for (i, (own, region)) in piece.iter().zip(&root.region).enumerate() {
                if region.hi < own.lo || own.hi < region.lo {
                    continue 'roots;
                }
                let margin = 0.1 * own.width();
                for end in [region.lo, region.hi] {
                    if own.lo + margin < end && end < own.hi - margin {
                        border = Some((i, end));
                    }
                }
            }
            if let Some(border) = border {
                at = border;
                break;
            }
        }
        let (side, end) = at;
        let own = piece[side];
        let [mut low, mut high] = [piece.to_vec(), piece.to_vec()];
        low[side] = Interval::new(own.lo, end);
        high[side] = Interval::new(end, own.hi);
        vec![high, low]
    }

    /// The side along which equations change most.
    fn steepest(&self, piece: &[Interval], slopes: &[Interval]) -> usize {
        let n = piece.len();
        let mut impact = vec![0.0; n];
        for row in slopes.chunks(n) {
            let own: Vec<f64> = row.iter().zip(piece).map(|(slope, side)| slope.size() * side.width()).collect();
            let total: f64 = own.iter().sum();
            if total > 0.0 {
                impact.iter_mut().zip(own).for_each(|(sum, own)| *sum += own / total);
            }
        }
        (0..n).fold(0, |best, i| if impact[i] > impact[best] { i } else { best })
    }
}

/// Half the side of a region to begin with.
fn side(piece: &Interval, whole: &Interval) -> f64 {
    (0.5 * piece.width()).max(1e-9 * whole.width())
}

/// What b + Σ row_j (z_j - c_j) = 0 leaves of each unknown, or of one; false where nothing is left.
fn solve_row(piece: &mut [Interval], centre: &[Interval], row: &[Interval], b: &Interval, only: Option<usize>) -> bool {
    let terms: Vec<Interval> = row.iter().zip(piece.iter().zip(centre)).map(|(a, (x, c))| a.mul(&x.sub(c))).collect();
    let total = terms.iter().fold(*b, |sum, term| sum.add(term));
    if !total.contains(0.0) {
        return false;
    }
    let wanted = only.map_or_else(|| 0..row.len(), |i| i..i + 1);
    for j in wanted {
        if row[j].contains(0.0) {
            continue;
        }
        let others = terms.iter().enumerate().filter(|(k, _)| *k != j).fold(*b, |sum, (_, term)| sum.add(term));
        piece[j] = piece[j].meet(&centre[j].sub(&others.div(&row[j])));
        if piece[j].is_empty() {
            return false;
        }
    }
    true
}
