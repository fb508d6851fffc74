//! Multipliers in double-double, and with more bits where that does not decide.

use super::error::FloquetError;
use super::monodromy::{FAR, PeriodMap, Stop, period_map, short};
use super::motion::Driven;
use super::multipliers::{self, Multiplier, Place, is_lacking, missing_bits};
use super::orbit::{Lost, SEARCH, orbit, search};
use crate::flow::{Equations, Plain};
use librate_core::expr::{ExprId, Tape};
use librate_core::groups::connected;
use librate_core::linearize::evaluate_closed;
use librate_core::precision::{Ball, Big, Enclosure, Magnitude, Matrix};

/// The order of the steps in double-double: about the best for 32 digits.
const ORDER: usize = 34;
/// Bits of the first precision level beyond double-double, where digits do not ask for more; the second one has twice as many.
const FIRST_BITS: usize = 192;
/// Precision levels beyond double-double. What the first one leaves open, most often, no bits decide: 1 twice with one vector, as a
/// coordinate that is free has it. So the second one has to be cheap.
const LEVELS: usize = 2;
/// Bits for eigenvalues of what leaves the range of doubles.
const RANGE_BITS: usize = 128;
/// Products of balls in an integration over a period: some ten seconds.
const WORK: f64 = 1e9;
/// What a product of numbers of 128 bits takes beside one of balls, about.
const WIDE: f64 = 5.0;
/// Integrations over a period that it about takes to find and prove a periodic motion.
const PASSES: usize = 4;
/// As many steps are always made.
const FEWEST_STEPS: usize = 2000;
/// As many steps are the most.
const MOST_STEPS: usize = 1_000_000;

/// What is to be followed over a period.
pub(super) struct Task<'a> {
    pub(super) driven: &'a Driven,
    pub(super) equations: &'a Equations,
    pub(super) period: &'a Ball,
    /// The coordinates of what rests.
    pub(super) point: &'a [ExprId],
    pub(super) digits: usize,
}

/// Multipliers, and what they come from.
pub(super) struct Found {
    /// The state at t = 0 of a periodic motion.
    pub(super) start: Vec<Ball>,
    pub(super) monodromy: Vec<Ball>,
    pub(super) multipliers: Vec<Multiplier>,
    /// The least and the largest value of each component of a periodic motion, about.
    pub(super) range: Vec<(f64, f64)>,
    /// How many steps a period takes.
    steps: usize,
}

impl Task<'_> {
    /// About what rests at all times.
    pub(super) fn about_rest(&self) -> Result<Found, FloquetError> {
        let steps = (ORDER, self.most_steps());
        let there = period_map::<Ball>(self.equations, self.period, &[], &[], steps, ());
        let there = there.map_err(|stop| self.stopped(&stop))?;
        let found = self.found(Vec::new(), &there, ());
        let wide = |bits: usize, steps: (usize, usize), _: &Found| {
            let period = self.precise_period(bits)?;
            let there = period_map::<Big>(self.equations, &period, &[], &[], steps, bits).ok()?;
            Some(self.found(Vec::new(), &there, bits))
        };
        Ok(self.refined(found, 1, wide))
    }

    /// About the periodic motion near a state.
    pub(super) fn about_motion(&self, start: &[f64]) -> Result<Found, FloquetError> {
        let steps = (ORDER, self.most_steps());
        let mut plain = Plain::new(self.equations);
        let guess = search(&mut plain, self.period.mid_f64(), start, (steps.1, SEARCH));
        let guess = guess.map_err(|lost| self.lost(&lost))?;
        let wide = |bits: usize, steps: (usize, usize), nearer: Option<&[Ball]>| {
            let period = self.precise_period(bits)?;
            let own = orbit::<Big>(self.equations, &period, &guess, nearer, steps, bits).ok()?;
            Some(self.found(own.start, &own.period_map, bits))
        };
        let in_balls = orbit::<Ball>(self.equations, self.period, &guess, None, steps, ());
        let found = match in_balls {
            Ok(own) => self.found(own.start, &own.period_map, ()),
            Err(lost) => {
                let failed = self.lost(&lost);
                if matches!(lost, Lost::Stopped(Stop::TooManySteps { .. })) {
                    return Err(failed);
                }
                // A motion that magnifies what is rounded more than double-double has digits.
                let bits = (0..LEVELS).map(|level| FIRST_BITS << level);
                bits.flat_map(|bits| wide(bits, self.wide_steps(bits), None)).next().ok_or(failed)?
            }
        };
        let found = self.refined(found, PASSES, |bits, steps, found| wide(bits, steps, Some(&found.start)));
        Ok(Found { range: guess.range, ..found })
    }

    /// With more bits, as long as something is not decided and a level is not too much work.
    fn refined(
        &self,
        mut found: Found,
        passes: usize,
        wide: impl Fn(usize, (usize, usize), &Found) -> Option<Found>,
    ) -> Found {
        let missing = missing_bits(&found.multipliers, self.digits);
        let mut bits = FIRST_BITS.max((128 + missing).next_multiple_of(64));
        for level in 0..LEVELS {
            let steps = self.wide_steps(bits);
            let most = (steps.1 >> (4 * level)) / passes;
            if !is_lacking(&found.multipliers, self.digits) || found.steps > most {
                break;
            }
            let finer = wide(bits, steps, &found);
            let open = |found: &Found| undecided(&found.multipliers);
            let Some(finer) = finer.filter(|finer| open(finer) <= open(&found)) else { break };
            let steps = found.steps;
            found = Found { steps, ..finer };
            bits *= 2;
        }
        found
    }

    fn found<S: Enclosure>(&self, start: Vec<S>, there: &PeriodMap<S>, precision: S::Precision) -> Found {
        let tangent = self.driven.tied.as_ref().map(|own| own.tangent(&start, precision));
        let along = tangent.as_ref().map(|(kept, basis)| {
            let all = there.monodromy.mul(basis, precision);
            let rows: Vec<&[S]> = all.rows().collect();
            Matrix::new(kept.len(), kept.iter().flat_map(|row| rows[*row].to_vec()).collect())
        });
        let monodromy = along.as_ref().unwrap_or(&there.monodromy);
        let form = || {
            let form = self.form(&start, precision)?;
            let Some((_, basis)) = &tangent else { return Some(form) };
            let form = Matrix::new(2 * self.driven.dimension(), form).mul(basis, precision);
            Some(basis.transposed().mul(&form, precision).into_entries())
        };
        let sizes = monodromy.entries().iter().map(Enclosure::abs_upper_magnitude);
        let size = sizes.fold(Magnitude::ZERO, Magnitude::max);
        let wide = || -> Vec<Big> {
            monodromy.entries().iter().map(|x| x.unrounded(RANGE_BITS).scale(there.exponent)).collect()
        };
        let multipliers = if there.exponent != 0 || size.scale(-FAR) > Magnitude::ONE {
            let wide = wide();
            let bits = wide.first().map_or(RANGE_BITS, Big::bits);
            self.multipliers(&wide, bits, &|| None)
        } else {
            self.multipliers(monodromy.entries(), precision, &form)
        };
        let monodromy = match there.exponent {
            0 => monodromy.entries().iter().map(Enclosure::to_ball).collect(),
            _ => wide().iter().map(Big::to_ball).collect(),
        };
        Found {
            start: start.iter().map(Enclosure::to_ball).collect(),
            monodromy,
            multipliers,
            range: Vec::new(),
            steps: there.steps,
        }
    }

    /// The form Σ δq_i ∧ δp_i that no motion without friction changes, in displacements of q and q' at the beginning, row by row: with
    /// δp = A δq + M δq' its entries are A - Aᵀ, M and -M.
    fn form<S: Enclosure>(&self, start: &[S], precision: S::Precision) -> Option<Vec<S>> {
        let (pool, half) = (&self.driven.pool, self.driven.dimension());
        let zero = S::exact(0.0, precision);
        let mut inputs = vec![zero.clone()];
        if start.is_empty() {
            let tape = Tape::compile(pool, self.point, &[]).ok()?;
            inputs.extend(tape.prepare::<S>(precision).evaluate(&[], &mut Vec::new()));
            inputs.resize(2 * half + 1, zero.clone());
        } else {
            inputs.extend(start.iter().cloned());
        }
        let tape = Tape::compile(pool, &self.driven.canonical(), &self.driven.symbols()).ok()?;
        let values = tape.prepare::<S>(precision).evaluate(&inputs, &mut Vec::new());
        let entry = |at: usize| {
            let ((i, upper), (j, left)) = [at / (2 * half), at % (2 * half)].map(|k| (k % half, k < half)).into();
            let mass = || values.get(half * half + half * i + j);
            match (upper, left) {
                (true, true) => Some(values.get(half * i + j)?.sub(values.get(half * j + i)?)),
                (true, false) => mass().cloned(),
                (false, true) => Some(mass()?.neg()),
                (false, false) => Some(zero.clone()),
            }
        };
        (0..4 * half * half).map(entry).collect()
    }

    /// The period with more bits.
    fn precise_period(&self, bits: usize) -> Option<Big> {
        evaluate_closed(&self.driven.pool, self.driven.period.0, bits).filter(Big::is_positive)
    }

    /// Products of a step of an order, about.
    fn work(&self, order: usize) -> f64 {
        let [rows, n, order] = [self.equations.couplings(), self.equations.dimension(), order].map(|x| x as f64);
        rows * n * order.powi(2)
    }

    fn most_steps(&self) -> usize {
        let steps = (WORK / self.work(ORDER)).min(MOST_STEPS as f64) as usize;
        steps.max(FEWEST_STEPS)
    }

    /// The order of the steps that suits a number of bits, and how many are made.
    fn wide_steps(&self, bits: usize) -> (usize, usize) {
        let order = bits / 3;
        let most = WORK / (self.work(order) * WIDE * (bits as f64 / 128.0));
        (order, most.min(MOST_STEPS as f64) as usize)
    }

    fn stopped(&self, stop: &Stop) -> FloquetError {
        let energy = self.driven.driven_at;
        match stop {
            Stop::Singular { time } => FloquetError::Singular { time: short(*time), span: energy },
            Stop::TooManySteps { steps } => FloquetError::TooLong {
                period: short(self.period.mid_f64()),
                steps: *steps,
                span: self.driven.period.1,
                energy,
            },
        }
    }

    fn lost(&self, lost: &Lost) -> FloquetError {
        match lost {
            Lost::Search(reason) => {
                FloquetError::NoPeriodicMotion { reason: (*reason).to_owned(), span: self.driven.driven_at }
            }
            Lost::Stopped(stop) => self.stopped(stop),
        }
    }

    /// Those of a monodromy matrix, of each set of coordinates by itself that nothing couples to the others: what coincides in two
    /// of them has vectors of its own in each. A set holds the velocities of its coordinates, so that its part of a
    /// symplectic matrix is symplectic.
    fn multipliers<S: Enclosure>(
        &self,
        monodromy: &[S],
        precision: S::Precision,
        form: &dyn Fn() -> Option<Vec<S>>,
    ) -> Vec<Multiplier> {
        let n = monodromy.len().isqrt();
        let half = n / 2;
        let coupled = |i: usize, j: usize| {
            [i, i + half].iter().any(|row| [j, j + half].iter().any(|column| !monodromy[n * row + column].is_zero()))
        };
        let mut all = Vec::new();
        for members in connected(half, |i, j| coupled(i, j) || coupled(j, i)) {
            let velocities = members.iter().map(|i| i + half);
            let rows: Vec<usize> = members.iter().copied().chain(velocities).collect();
            let part = |of: &[S]| -> Vec<S> {
                let places = rows.iter().flat_map(|row| rows.iter().map(move |column| n * row + column));
                places.map(|at| of[at].clone()).collect()
            };
            let form = || form().map(|form| part(&form));
            let symplectic = members.iter().all(|i| !self.driven.damped[*i]);
            all.extend(self.of_block(&part(monodromy), symplectic, precision, &form));
        }
        all
    }

    /// Of what is coupled: by eigenvectors in doubles, where these do not do by better ones.
    fn of_block<S: Enclosure>(
        &self,
        block: &[S],
        symplectic: bool,
        precision: S::Precision,
        form: &dyn Fn() -> Option<Vec<S>>,
    ) -> Vec<Multiplier> {
        let n = block.len().isqrt();
        if n == 2 {
            return multipliers::of_two(block, symplectic, precision);
        }
        let form = symplectic.then_some(form);
        let many = |careful| multipliers::of_many(block, n, form, careful, precision);
        let quick = many(false);
        if !is_lacking(&quick, self.digits) {
            return quick;
        }
        let careful = many(true);
        match (careful.is_empty(), quick.is_empty()) {
            (false, false) if undecided(&careful) <= undecided(&quick) => careful,
            (false, true) => careful,
            (_, false) => quick,
            (true, true) => multipliers::unknown(block, n, precision),
        }
    }
}

/// How many multipliers bounds do not place.
fn undecided(multipliers: &[Multiplier]) -> usize {
    multipliers.iter().filter(|own| own.place == Place::Undecided).count()
}
