//! The monodromy matrix: the derivative of the state after a period by the state before it.

use crate::flow::{Enclosing, Equations};
use librate_core::precision::{Enclosure, Magnitude, Matrix};

/// The map over a period, which takes a state to that a period later.
pub(super) struct PeriodMap<S> {
    /// The state after the period, from the midpoint of the initial one.
    pub(super) image: Vec<S>,
    /// Its derivative by the initial state, for every initial state in the box, but for a factor ...
    pub(super) monodromy: Matrix<S>,
    /// ... 2 to this, which is not 0 only beyond the range of doubles.
    pub(super) exponent: i64,
    /// How many steps it took.
    pub(super) steps: usize,
}

/// Why the integration ended before the period was over.
pub(super) enum Stop {
    /// No step leads on, or what it leads to has no bounds.
    Singular { time: f64 },
    /// More steps than these, which are all that are made.
    TooManySteps { steps: usize },
}

/// Steps after which it is looked how many there will be.
const FIRST_STEPS: usize = 256;
/// How many times too long a way has to seem there to be given up at once.
const HOPELESS: f64 = 2.0;

/// What steps do, one after the other, to displacements from the path of midpoints: d -> 2^`exponent` `slopes` d + `drift`.
struct Link<S> {
    /// 2 to this is how many steps.
    level: u32,
    slopes: Matrix<S>,
    exponent: i64,
    drift: Vec<S>,
}

/// Steps put together in pairs, pairs of pairs, and so on, like the digits of a binary number.
///
/// Multiplied one by one, k enclosed matrices that turn have radii that grow like c^k, because each product wraps the turned box
/// of the one before. The radius of a product is at most |A| rad B + rad A |B| (and what is rounded), so that in a balanced
/// tree it grows by a factor a level, of which there are log2 k: as a power of k.
struct Chain<S: Enclosure> {
    precision: S::Precision,
    links: Vec<Link<S>>,
}

impl<S: Enclosure> Chain<S> {
    fn new(precision: S::Precision) -> Self {
        Self { precision, links: Vec::new() }
    }

    fn push(&mut self, slopes: Matrix<S>, drift: Vec<S>) {
        let mut link = Link { level: 0, slopes, exponent: 0, drift };
        while self.links.last().is_some_and(|last| last.level == link.level) {
            let Some(last) = self.links.pop() else { break };
            link = self.joined(&last, &link);
        }
        self.links.push(link);
    }

    fn joined(&self, first: &Link<S>, second: &Link<S>) -> Link<S> {
        let mut slopes = second.slopes.mul(&first.slopes, self.precision);
        let mut exponent = first.exponent.saturating_add(second.exponent);
        // A state that is followed itself would have left the range of doubles as well.
        if first.drift.is_empty() {
            let sizes = slopes.entries().iter().map(Enclosure::abs_upper_magnitude);
            let (_, size) = sizes.fold(Magnitude::ZERO, Magnitude::max).parts();
            if size > FAR {
                slopes = slopes.map(|x| x.times_power_of_two(-size));
                exponent = exponent.saturating_add(size);
            }
        }
        let drift = second.slopes.image(&first.drift, self.precision);
        Link {
            level: second.level.max(first.level) + 1,
            slopes,
            exponent,
            drift: drift.iter().zip(&second.drift).map(|(x, y)| x.add(y)).collect(),
        }
    }

    /// Where displacements of the initial state have come.
    fn image(&self, initial: &[S]) -> Vec<S> {
        self.links.iter().fold(initial.to_vec(), |before, link| {
            link.slopes.image(&before, self.precision).iter().zip(&link.drift).map(|(x, y)| x.add(y)).collect()
        })
    }

    /// All of it as one.
    fn whole(mut self) -> Option<Link<S>> {
        let mut link = self.links.pop()?;
        while let Some(earlier) = self.links.pop() {
            link = self.joined(&earlier, &link);
        }
        Some(link)
    }
}

/// A product of matrices larger than 2 to this is scaled; products of two such are still balls.
pub(super) const FAR: i64 = 400;

/// The map over a period in at most so many steps, from all points within `reach` of `start`.
///
/// The state at each step is m + d for a midpoint m and a displacement d, whose set is the image of the initial box by a
/// [`Chain`]: parallelepipeds, so that the turning of that box costs nothing, and a box for what is rounded at each step (R. J.
/// Lohner, in Computational Ordinary Differential Equations (1992), 425). With T over the whole state the image of x is that of the
/// midpoint c plus T (x - c).
pub(super) fn period_map<S: Enclosure>(
    equations: &Equations,
    period: &S,
    start: &[S],
    reach: &[f64],
    (order, most_steps): (usize, usize),
    precision: S::Precision,
) -> Result<PeriodMap<S>, Stop> {
    let n = equations.dimension();
    let mut walk = Enclosing::<S>::new(equations, order, precision);
    let zero = S::exact(0.0, precision);
    let mut middle = start.to_vec();
    let initial: Vec<S> = reach.iter().map(|r| zero.with_added_radius(*r)).collect();
    let mut chain = Chain::new(precision);
    let mut time = zero.clone();
    for steps in 1..=most_steps {
        let spread = chain.image(&initial);
        let state: Vec<S> = middle.iter().zip(&spread).map(|(m, d)| m.add(d)).collect();
        let left = period.sub(&time);
        let Some(step) = walk.step(&time, &state, &left) else { return Err(Stop::Singular { time: time.mid_f64() }) };
        // From the midpoint m to the center of the state, and from its image to the next midpoint.
        let shift: Vec<S> = middle.iter().zip(&state).map(|(m, x)| m.sub(&x.center())).collect();
        middle = step.image.iter().map(S::center).collect();
        let slopes = Matrix::new(n, step.slopes);
        let shifted = slopes.image(&shift, precision);
        let ends = step.image.iter().zip(&middle);
        let drift = shifted.iter().zip(ends).map(|(d, (image, m))| d.add(&image.sub(m))).collect();
        chain.push(slopes, drift);
        if step.whole {
            // The initial box aside: from its midpoint.
            let drift = chain.image(&vec![zero.clone(); start.len()]);
            let image: Vec<S> = middle.iter().zip(&drift).map(|(m, d)| m.add(d)).collect();
            let whole = chain.whole().filter(|whole| whole.slopes.entries().iter().chain(&image).all(S::is_finite));
            let singular = Stop::Singular { time: period.mid_f64() };
            return whole.ok_or(singular).map(|whole| PeriodMap {
                image,
                monodromy: whole.slopes,
                exponent: whole.exponent,
                steps,
            });
        }
        time = time.add(&step.length);
        if steps == FIRST_STEPS {
            let (made, most) = (steps as f64, most_steps as f64);
            if made * (period.mid_f64() / time.mid_f64()) > HOPELESS * most {
                break;
            }
        }
    }
    Err(Stop::TooManySteps { steps: most_steps })
}

/// A number in a message.
pub(super) fn short(value: f64) -> String {
    format!("{value:.6}").trim_end_matches('0').trim_end_matches('.').to_owned()
}
