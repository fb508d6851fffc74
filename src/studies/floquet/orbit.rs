//! Periodic motions: found in doubles, proved to exist at any precision.

use nalgebra::{DMatrix, DVector, Dyn, LU};

use super::basis::inverse;
use super::monodromy::{PeriodMap, Stop, period_map};
use crate::flow::{Equations, Plain, count};
use librate_core::order::Order;
use librate_core::precision::{Ball, Complex, Enclosure, Magnitude, Matrix};

/// Newton steps to a periodic motion, in doubles.
const NEWTON: usize = 60;
/// A period is cut into so many pieces ...
const PIECES: usize = 8;
/// ... or fewer, so that the states at their ends have no more components than this.
const MOST_UNKNOWNS: usize = 400;
/// Steps in time that are made in doubles: some ten seconds.
pub(super) const SEARCH: usize = 2_000_000;
/// An integration over a period that takes so many times the steps of the first one has gone astray.
const ASTRAY: usize = 20;
/// Newton steps from doubles on: each about doubles the digits.
const CORRECTIONS: usize = 7;
/// Sizes of the box about a periodic motion, in roundings of its scale, that are tried in turn.
const BOXES: [f64; 4] = [2e4, 2e7, 2e11, 2e15];

/// A periodic motion that was proved to exist.
pub(super) struct Orbit<S> {
    /// The state at t = 0.
    pub(super) start: Vec<S>,
    pub(super) period_map: PeriodMap<S>,
}

/// A motion that is periodic as far as doubles tell.
pub(super) struct Guess {
    pub(super) start: Vec<f64>,
    /// About the size of the state where it moves.
    scale: Vec<f64>,
    /// The least and the largest value of each component on the way.
    pub(super) range: Vec<(f64, f64)>,
}

/// Why no periodic motion was proved.
pub(super) enum Lost {
    /// In words.
    Search(&'static str),
    /// What is found can't be followed over a period.
    Stopped(Stop),
}

/// Newton's method in doubles for the states at several times of a period, each of which is to become the next (multiple shooting:
/// J. Stoer, R. Bulirsch, Introduction to Numerical Analysis, section 7.3.5). So what runs away from an unstable motion within a
/// period is no obstacle. It begins with rest where the guess is, or with the motion from there, whichever Newton's method has less
/// to move. A period that takes more than `most_steps` is too long; all of it takes `budget` steps at most.
pub(super) fn search(
    plain: &mut Plain,
    period: f64,
    start: &[f64],
    (most_steps, budget): (usize, usize),
) -> Result<Guess, Lost> {
    let n = start.len();
    let pieces = (MOST_UNKNOWNS / n.max(1)).clamp(1, PIECES);
    let mut shooting = Shooting { plain, period, n, pieces, steps: 0, range: Vec::new() };
    let resting = DVector::from_iterator(n * pieces, start.iter().copied().cycle().take(n * pieces));
    let limit = most_steps.saturating_add(1);
    let mut begins: Vec<Place> = shooting.place(resting, limit).into_iter().collect();
    if shooting.steps > most_steps {
        return Err(Lost::Stopped(Stop::TooManySteps { steps: most_steps }));
    }
    let first = shooting.steps;
    begins.extend(shooting.followed(start, limit).and_then(|states| shooting.place(states, limit)));
    begins.order_by(|a, b| a.asked.norm().total_cmp(&b.asked.norm()));
    // Where it takes that much longer it has gone astray.
    let most = ASTRAY * (first + 10);
    let mut lost = Lost::Search("the motion from the guess ends before the period is over");
    for (at, begin) in begins.into_iter().enumerate() {
        match shooting.newton(begin, most, budget) {
            Ok(states) => {
                shooting.around(&states, usize::MAX);
                let size = |own: &(f64, f64)| own.0.abs().max(own.1.abs());
                // A box needs a scale where a component is 0.
                let scale = shooting.range.iter().map(size);
                return Ok(Guess {
                    start: states.as_slice()[..n].to_vec(),
                    scale: scale.map(|size| size.max(f64::MIN_POSITIVE)).collect(),
                    range: shooting.range,
                });
            }
            Err(own) if at == 0 => lost = own,
            Err(_) => {}
        }
    }
    Err(lost)
}

/// States at several times of a period.
struct Shooting<'a> {
    plain: &'a mut Plain,
    period: f64,
    n: usize,
    pieces: usize,
    /// Steps in time that were made.
    steps: usize,
    /// The least and the largest value of each component the last time around.
    range: Vec<(f64, f64)>,
}

/// Where Newton's method is.
struct Place {
    states: DVector<f64>,
    /// The step that it asks for.
    asked: DVector<f64>,
    slopes: LU<f64, Dyn, Dyn>,
    /// Whether nothing is left over.
    exact: bool,
}

impl Place {
    fn new(states: DVector<f64>, gaps: &DVector<f64>, slopes: DMatrix<f64>) -> Self {
        let slopes = slopes.lu();
        // Where periodic motions are not isolated none is asked for.
        let asked = slopes.solve(gaps).unwrap_or_else(|| states.map(|_| f64::INFINITY));
        Self { states, asked, slopes, exact: gaps.norm() == 0.0 }
    }
}

impl Shooting<'_> {
    fn time(&self, piece: usize) -> f64 {
        self.period * (count(piece) / count(self.pieces))
    }

    /// The state at the end of a piece, and its derivative.
    fn piece(&mut self, at: usize, state: &[f64], most: usize) -> Option<(Vec<f64>, Vec<f64>)> {
        let (begin, end) = (self.time(at), self.time(at + 1));
        let (steps, range) = (&mut self.steps, &mut self.range);
        self.plain.set_most_steps(most);
        self.plain.travel(begin, end, state, |_, state, _| {
            *steps += 1;
            range.resize(state.len(), (f64::INFINITY, f64::NEG_INFINITY));
            for ((low, high), x) in range.iter_mut().zip(state) {
                (*low, *high) = (low.min(*x), high.max(*x));
            }
        })
    }

    /// By how much each state misses the next one, and the derivative of that.
    fn around(&mut self, states: &DVector<f64>, most: usize) -> Option<(DVector<f64>, DMatrix<f64>)> {
        let (n, pieces) = (self.n, self.pieces);
        let mut gaps = DVector::zeros(n * pieces);
        let mut slopes = DMatrix::zeros(n * pieces, n * pieces);
        let before = self.steps;
        self.range.clear();
        for at in 0..pieces {
            let left = most.saturating_sub(self.steps - before);
            let own = &states.as_slice()[n * at..n * (at + 1)];
            let (end, turned) = self.piece(at, own, left)?;
            let next = n * ((at + 1) % pieces);
            for i in 0..n {
                gaps[n * at + i] = end[i] - states[next + i];
                for j in 0..n {
                    slopes[(n * at + i, n * at + j)] += turned[n * i + j];
                }
                slopes[(n * at + i, next + i)] -= 1.0;
            }
        }
        Some((gaps, slopes))
    }

    /// The states that a motion goes through.
    fn followed(&mut self, start: &[f64], most: usize) -> Option<DVector<f64>> {
        let mut states = start.to_vec();
        let mut own = start.to_vec();
        for at in 0..self.pieces - 1 {
            own = self.piece(at, &own, most)?.0;
            states.extend_from_slice(&own);
        }
        Some(DVector::from_vec(states))
    }

    fn place(&mut self, states: DVector<f64>, most: usize) -> Option<Place> {
        let (gaps, slopes) = self.around(&states, most)?;
        Some(Place::new(states, &gaps, slopes))
    }

    fn newton(&mut self, mut own: Place, most: usize, budget: usize) -> Result<DVector<f64>, Lost> {
        for _ in 0..NEWTON {
            let asked = own.asked.norm();
            if !asked.is_finite() {
                return Err(Lost::Search("periodic motions are not isolated here"));
            }
            let small = asked <= 1e-13 * (own.states.norm() + asked.min(1e-3));
            // Shorter steps as long as the way around is longer than before; measured in the step that it asks for.
            let mut shorter = 1.0;
            loop {
                let next = &own.states - &own.asked * shorter;
                if let Some((gaps, slopes)) = self.around(&next, most) {
                    let other = own.slopes.solve(&gaps);
                    let other = other.map_or(f64::INFINITY, |other| other.norm());
                    if other <= asked * (1.0 - 0.25 * shorter) || small {
                        own = Place::new(next, &gaps, slopes);
                        break;
                    }
                }
                shorter *= 0.5;
                if self.steps > budget {
                    return Err(Lost::Search("the search takes too many steps"));
                }
                if shorter < 1e-6 {
                    return Err(Lost::Search("the search ends where it comes no nearer"));
                }
            }
            if small || own.exact {
                return Ok(own.states);
            }
        }
        Err(Lost::Search("the search takes too many steps"))
    }
}

/// The periodic motion near a state: found by Newton's method on the map over a period, proved by Krawczyk's theorem (R.
/// Krawczyk, Computing 4 (1969) 187): with C about (DP - 1)⁻¹ and F(x) = P(x) - x, if
/// K = c - C F(c) + (1 - C DF(X)) (X - c) lies inside X, then X holds exactly one zero of F, and K holds it.
pub(super) fn orbit<S: Enclosure>(
    equations: &Equations,
    period: &S,
    guess: &Guess,
    nearer: Option<&[Ball]>,
    steps: (usize, usize),
    precision: S::Precision,
) -> Result<Orbit<S>, Lost> {
    let n = guess.start.len();
    let rounding = S::rounding(precision);
    let largest = guess.scale.iter().fold(0.0_f64, |most, s| most.max(*s));
    let largest = if largest > 1e-200 { largest } else { 1.0 };
    let mut center: Vec<S> = match nearer {
        Some(known) => known.iter().map(|x| S::from_ball(x, precision).center()).collect(),
        None => guess.start.iter().map(|x| S::exact(*x, precision)).collect(),
    };
    let mut asked: Vec<f64> = vec![0.0; n];
    let mut newton = None;
    for _ in 0..CORRECTIONS {
        let there = period_map(equations, period, &center, &vec![0.0; n], steps, precision).map_err(Lost::Stopped)?;
        let own = Correction::new(&there.monodromy, precision);
        let own = own.ok_or(Lost::Search("periodic motions are not isolated here"))?;
        let step = own.step(&there.image, &center);
        for (x, s) in center.iter_mut().zip(&step) {
            *x = x.sub(s).center();
        }
        asked = step.iter().map(Enclosure::abs_upper).collect();
        newton = Some(own);
        // What the next one will about be.
        let share = asked.iter().fold(0.0_f64, |most, a| most.max(*a)) / largest;
        if share.is_nan() || 1e3 * share * share <= BOXES[0] * rounding || share <= 100.0 * rounding {
            break;
        }
    }
    let Some(newton) = newton else { return Err(Lost::Search("periodic motions are not isolated here")) };
    for size in BOXES.map(|size| size * rounding) {
        let sizes = guess.scale.iter().zip(&asked);
        let reach = sizes.map(|(s, a)| size * s.max(1e-3 * largest) + 4.0 * a.min(size * largest));
        let reach: Vec<f64> = reach.collect();
        let there = period_map(equations, period, &center, &reach, steps, precision).map_err(Lost::Stopped)?;
        if let Some(start) = newton.inside(&there, &center, &reach) {
            return Ok(Orbit { start, period_map: there });
        }
    }
    Err(Lost::Search(
        "the one that comes closest is not proved to be periodic, and at a resonance without damping there is none",
    ))
}

/// C of Krawczyk's theorem, taken as exactly what it is.
struct Correction<S: Enclosure> {
    precision: S::Precision,
    inverse: Matrix<S>,
}

/// DP - 1.
fn slopes<S: Enclosure>(monodromy: &Matrix<S>, precision: S::Precision) -> Matrix<S> {
    let mut slopes = monodromy.clone();
    for i in 0..monodromy.rows().len() {
        slopes[(i, i)] = slopes[(i, i)].sub(&S::exact(1.0, precision));
    }
    slopes
}

impl<S: Enclosure> Correction<S> {
    /// About (DP - 1)⁻¹.
    fn new(monodromy: &Matrix<S>, precision: S::Precision) -> Option<Self> {
        let zero = S::exact(0.0, precision);
        let slopes = slopes(monodromy, precision).map(|slope| Complex::new(slope.center(), zero.clone()));
        Some(Self { precision, inverse: inverse(&slopes, precision)?.map(|entry| entry.re.clone()) })
    }

    /// C F(c).
    fn step(&self, image: &[S], center: &[S]) -> Vec<S> {
        let difference: Vec<S> = image.iter().zip(center).map(|(p, x)| p.sub(x)).collect();
        self.inverse.image(&difference, self.precision)
    }

    /// K, if it lies inside X.
    fn inside(&self, there: &PeriodMap<S>, center: &[S], reach: &[f64]) -> Option<Vec<S>> {
        let one = S::exact(1.0, self.precision);
        let step = self.step(&there.image, center);
        let product = self.inverse.mul(&slopes(&there.monodromy, self.precision), self.precision);
        let mut start = Vec::with_capacity(reach.len());
        for (i, row) in product.rows().enumerate() {
            // Row i of 1 - C (DP - 1), times the box.
            let mut spread = Magnitude::ZERO;
            for (j, (product, reach)) in row.iter().zip(reach).enumerate() {
                let size = if i == j { one.sub(product).abs_upper_magnitude() } else { product.abs_upper_magnitude() };
                spread = spread + size * Magnitude::from_f64(*reach);
            }
            if step[i].abs_upper_magnitude() + spread >= Magnitude::from_f64(reach[i]) {
                return None;
            }
            start.push(center[i].sub(&step[i]).with_added_magnitude(spread));
        }
        start.iter().all(S::is_finite).then_some(start)
    }
}
