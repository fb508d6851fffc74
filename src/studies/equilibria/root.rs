//! A proof that there is exactly one equilibrium in a region, and where.
//!
//! Krawczyk's theorem (Computing 4 (1969)): with z and a matrix Y of doubles, a box U = z ± r and D an enclosure of 1 - Y J(U), if
//! |Y F(z)| + |D| r < r, component by component, there is exactly one zero z* of F in U. With θ = max_i (|D| r)_i / r_i < 1 it lies
//! within |Y F(y)|/(1 - θ) of any y in U, in the norm max |x_i|/r_i: z* - y = -Y F(y) + (1 - Y A)(z* - y) for an A of J(U).

use nalgebra::DMatrix;

use librate_core::precision::{Ball, Interval, Scalar, up};

use super::search::Search;

/// What half sides of regions are tried, beside those of a piece.
const REACHES: [f64; 12] = [8.0, 4.0, 2.0, 1.0, 0.5, 0.25, 0.125, 0.03125, 4e-3, 1e-4, 1e-6, 1e-8];
/// Steps with which a zero is made precise.
const MOST_STEPS: usize = 12;

/// One equilibrium.
#[derive(Clone, Debug)]
pub(super) struct Root {
    /// Where it is: the unknowns.
    pub(super) at: Vec<Ball>,
    /// A box in which it is the only zero.
    pub(super) region: Vec<Interval>,
}

impl Root {
    /// Whether a piece lies in the region.
    pub(super) fn holds(&self, piece: &[Interval]) -> bool {
        piece.iter().zip(&self.region).all(|(own, region)| own.is_within(region))
    }

    /// Whether another one is this.
    pub(super) fn is_same(&self, other: &Self) -> bool {
        are_within(&other.at, &self.region) || are_within(&self.at, &other.region)
    }
}

/// Whether enclosures lie in a region.
pub(super) fn are_within(at: &[Ball], region: &[Interval]) -> bool {
    at.iter().zip(region).all(|(x, region)| Interval::of_ball(x).is_within(region))
}

/// A region with one zero, and what proves it.
pub(super) struct Alone {
    pub(super) region: Vec<Interval>,
    half: Vec<f64>,
    inverse: DMatrix<f64>,
    ratio: f64,
}

impl Search<'_> {
    /// Tries to prove a zero near `at`, in as large a region as possible.
    pub(super) fn prove(&mut self, at: &[f64], sides: &[f64]) -> Option<Root> {
        let Alone { region, half, inverse, ratio } = self.alone(at, sides)?;
        let at = self.refined(at, &inverse, &half, ratio)?;
        // Its bound holds for points of the region alone.
        at.iter().zip(&region).all(|(x, region)| region.contains(x.mid_f64())).then_some(Root { at, region })
    }

    /// As large a region about `at` as possible in which there is exactly one zero, for all values of parameters.
    pub(super) fn alone(&mut self, at: &[f64], sides: &[f64]) -> Option<Alone> {
        let n = at.len();
        let slopes = self.doubles.slopes(&self.inputs(at, Ball::mid_f64));
        let inverse = DMatrix::from_row_slice(n, n, &slopes).try_inverse()?;
        if !inverse.iter().all(|x| x.is_finite()) {
            return None;
        }
        let point: Vec<Interval> = at.iter().map(|x| Interval::point(*x)).collect();
        let correction = self.correction(&inverse, &point)?;
        for reach in REACHES {
            let half: Vec<f64> = sides.iter().map(|side| reach * side).collect();
            let region: Vec<Interval> = at
                .iter()
                .zip(&half)
                .map(|(x, half)| Interval::new((x - half).next_up(), (x + half).next_down()))
                .collect();
            if region.iter().zip(at).any(|(own, x)| own.lo >= *x || own.hi <= *x) {
                return None;
            }
            if let Some(ratio) = self.contraction(&region, &inverse, at, &correction) {
                return Some(Alone { region, half, inverse, ratio });
            }
        }
        None
    }

    /// Y F at a point for all values of the parameters: at the middle ones, and how it changes from there.
    fn correction(&mut self, inverse: &DMatrix<f64>, point: &[Interval]) -> Option<Vec<Interval>> {
        let middle = self.inputs(point, |own| Interval::point(own.mid_f64()));
        let mut all = image(inverse, &self.intervals.force(&middle))?;
        let drifts = self.intervals.drifts(&self.inputs(point, Interval::of_ball));
        let count = self.parameters.len();
        for (at, parameter) in self.parameters.iter().enumerate() {
            let drift: Vec<Interval> = drifts.iter().skip(at).step_by(count).copied().collect();
            let off = Interval::of_ball(parameter).sub(&Interval::point(parameter.mid_f64()));
            for (own, drift) in all.iter_mut().zip(image(inverse, &drift)?) {
                *own = own.add(&drift.mul(&off));
            }
        }
        Some(all)
    }

    /// θ where Krawczyk's inequalities hold over a region.
    fn contraction(
        &mut self,
        region: &[Interval],
        inverse: &DMatrix<f64>,
        at: &[f64],
        correction: &[Interval],
    ) -> Option<f64> {
        let n = at.len();
        let inputs = self.inputs(region, Interval::of_ball);
        if !self.intervals.force(&inputs).iter().all(Interval::is_usable) {
            return None;
        }
        let slopes = self.intervals.slopes(&inputs);
        if !slopes.iter().all(Interval::is_usable) {
            return None;
        }
        // The distances from `at` to the ends, rounded towards it.
        let reach: Vec<f64> =
            region.iter().zip(at).map(|(own, x)| (own.hi - x).next_down().min((x - own.lo).next_down())).collect();
        let mut ratio: f64 = 0.0;
        for i in 0..n {
            let mut sum = 0.0;
            for j in 0..n {
                let one = Interval::point(if i == j { 1.0 } else { 0.0 });
                let product = |k: usize| Interval::point(inverse[(i, k)]).mul(&slopes[n * k + j]);
                let own = (0..n).fold(one, |own, k| own.sub(&product(k)));
                // The region may reach a little further on one side.
                let far = (region[j].hi - at[j]).max(at[j] - region[j].lo).next_up();
                sum = up(sum + own.size() * far);
            }
            if up(sum + correction[i].size()).next_up() >= reach[i] {
                return None;
            }
            ratio = ratio.max(up(sum / reach[i]));
        }
        (ratio < 1.0).then_some(ratio)
    }

    /// The zero with as many digits as balls give.
    fn refined(&mut self, at: &[f64], inverse: &DMatrix<f64>, half: &[f64], ratio: f64) -> Option<Vec<Ball>> {
        let n = at.len();
        let mut point: Vec<Ball> = at.iter().map(|x| Ball::exact(*x)).collect();
        let mut best: Option<(f64, Vec<Ball>)> = None;
        for _ in 0..MOST_STEPS {
            let force = self.balls.force(&self.inputs(&point, Ball::clone));
            let row = |i: usize| (0..n).fold(Ball::ZERO, |sum, k| sum + Ball::exact(inverse[(i, k)]) * force[k]);
            let step: Vec<Ball> = (0..n).map(row).collect();
            let norm = step.iter().zip(half).map(|(own, half)| up(own.abs_upper() / half)).fold(0.0, f64::max);
            if !norm.is_finite() {
                return None;
            }
            if best.as_ref().is_some_and(|(least, _)| norm >= 0.5 * least) {
                break;
            }
            best = Some((norm, point.clone()));
            if norm == 0.0 {
                break;
            }
            for (own, step) in point.iter_mut().zip(&step) {
                *own = Ball::new((*own - *step).mid, 0.0);
            }
        }
        let (norm, point) = best?;
        if norm == 0.0 {
            return Some(point);
        }
        let off = up(norm / (1.0 - ratio).next_down());
        Some(point.iter().zip(half).map(|(own, half)| own.with_added_radius(up(off * half))).collect())
    }
}

/// Y F.
fn image(inverse: &DMatrix<f64>, force: &[Interval]) -> Option<Vec<Interval>> {
    let n = inverse.nrows();
    let rows = (0..n)
        .map(|i| (0..n).fold(Interval::point(0.0), |sum, k| sum.add(&Interval::point(inverse[(i, k)]).mul(&force[k]))));
    let rows: Vec<Interval> = rows.collect();
    rows.iter().all(Interval::is_bounded).then_some(rows)
}
