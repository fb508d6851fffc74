//! Closed forms against certified numbers.
//!
//! Where all parameters have values the model goes the whole way to its normal modes, by the other path, and
//! the closed forms are evaluated with rigorous bounds at the same values; where some have none, M and K
//! are evaluated at values drawn for them. A closed form stands if there are as many modes as its multiplicity says whose
//! enclosures meet it, each mode counted once.

use std::collections::HashMap;

use super::frequencies::{Case, Frequency};
use super::pair::Pair;
use super::simplify::{Simplifier, rebuild};
use crate::expr::{ExprId, Node, Pool, Symbol, Tape, ZeroVerdict};
use crate::linearize::{self, Linearized};
use crate::model::Model;
use crate::modes::{self, Options, Problem};
use crate::number::Number;
use crate::oscillation::normal_modes;
use crate::precision::{Ball, Function, Scalar};

/// An enclosure has to tell so much of a number.
const WIDEST: f64 = 1e-9;

/// A mode to compare with.
struct Reference {
    omega_squared: Ball,
    symmetry: Option<String>,
}

/// What closed forms are compared with.
pub(super) struct Checker {
    /// The values of parameters, and of coordinates at an equilibrium that was searched for.
    values: HashMap<Symbol, Ball>,
    /// The modes, where all parameters have values.
    modes: Option<Vec<Reference>>,
}

impl Checker {
    pub(super) fn new(model: &Model, pair: &Pair) -> Self {
        let mut values = HashMap::new();
        let mut complete = true;
        for (i, parameter) in model.parameters.iter().enumerate() {
            let value = parameter.value.and_then(|value| {
                let tape = Tape::compile(&model.pool, &[value], &[]).ok()?;
                tape.evaluate::<Ball>(&[], &mut Vec::new())
                    .into_iter()
                    .next()
            });
            complete &= value.is_some();
            values.insert(parameter.symbol, value.unwrap_or_else(|| drawn(i)));
        }
        let linearized = (complete && pair.len() > 0)
            .then(|| linearize::linearize(model.clone()).ok())
            .flatten();
        let modes = linearized.as_ref().and_then(|linearized| {
            let found = &linearized.equilibrium().values;
            for (coordinate, value) in model.coordinates.iter().zip(found) {
                values.insert(coordinate.symbol, *value);
            }
            references(linearized)
        });
        Self { values, modes }
    }

    /// M and K without absolute values of what has a sign at the values of the parameters, with acos(cos(x))
    /// as x where that is between 0 and pi; and what signs these are.
    pub(super) fn signed(
        &self,
        pool: &mut Pool,
        short: &mut Simplifier,
        pair: &Pair,
    ) -> (Pair, Vec<(ExprId, bool)>) {
        let entries = pair.values();
        let ids = pool.reachable(&entries);
        // What replaces each, and what has to be positive for it.
        let mut arguments: Vec<(ExprId, ExprId, bool)> = Vec::new();
        for id in &ids {
            if let Node::Function(function, x) = *pool.node(*id) {
                match (function, pool.node(x)) {
                    (Function::Abs, _) => arguments.push((*id, x, false)),
                    // The angle between 0 and pi.
                    (Function::Acos, Node::Function(Function::Cos, angle)) => {
                        arguments.push((*id, *angle, true));
                    }
                    (_, _) => {}
                }
            }
        }
        if arguments.is_empty() || self.modes.is_none() {
            return (pair.clone(), Vec::new());
        }
        let inner: Vec<ExprId> = arguments.iter().map(|(_, x, _)| *x).collect();
        let values = self.evaluate(pool, &inner).unwrap_or_default();
        let mut images: HashMap<ExprId, ExprId> = HashMap::new();
        let mut signs = Vec::new();
        for ((id, x, is_angle), value) in arguments.into_iter().zip(values) {
            let negative = value.is_negative();
            if is_angle {
                if value.is_positive() && Ball::PI.sub(&value).is_positive() {
                    images.insert(id, x);
                    let pi = pool.pi();
                    let rest = pool.sub(pi, x);
                    signs.extend([(x, false), (rest, false)]);
                }
            } else if value.is_positive() || negative {
                images.insert(id, if negative { pool.neg(x) } else { x });
                signs.push((x, negative));
            }
        }
        signs.sort_unstable();
        signs.dedup();
        for id in ids {
            if !images.contains_key(&id) {
                let new = rebuild(pool, id, &images);
                images.insert(id, new);
            }
        }
        (pair.replaced(pool, short, &images), signs)
    }

    /// Takes what does not hold out of a case, and puts the rest in ascending order.
    pub(super) fn check(&self, pool: &Pool, pair: &Pair, case: &mut Case) {
        if case.frequencies.is_empty() {
            case.complete = false;
            return;
        }
        let expressions: Vec<ExprId> = case.frequencies.iter().map(|f| f.omega_squared).collect();
        let own = match &self.modes {
            Some(_) => None,
            None => self.solved(pool, pair),
        };
        let (Some(values), Some(modes)) = (
            self.evaluate(pool, &expressions),
            self.modes.as_ref().or(own.as_ref()),
        ) else {
            case.frequencies.clear();
            case.series.clear();
            case.complete = false;
            return;
        };
        let mut forms: Vec<(Ball, Frequency)> =
            values.into_iter().zip(case.frequencies.drain(..)).collect();
        forms.sort_by(|(a, _), (b, _)| a.mid_f64().total_cmp(&b.mid_f64()));
        // Forms that only look different are one.
        forms.dedup_by(|(later, form), (value, kept)| {
            let same = later.sub(value).contains_zero()
                && equal(pool, form.omega_squared, kept.omega_squared);
            if same {
                kept.multiplicity += form.multiplicity;
                if kept.symmetry != form.symmetry {
                    kept.symmetry = None;
                }
            }
            same
        });
        let scale = modes
            .iter()
            .map(|mode| mode.omega_squared.abs_upper())
            .fold(0.0, f64::max);
        let mut used = vec![false; modes.len()];
        let before = forms.len();
        forms.retain_mut(|(value, form)| {
            let fits: Vec<usize> = modes
                .iter()
                .enumerate()
                .filter(|(at, mode)| {
                    !used[*at]
                        && mode.omega_squared.radius <= WIDEST * scale
                        && mode.omega_squared.sub(value).contains_zero()
                })
                .map(|(at, _)| at)
                .take(form.multiplicity)
                .collect();
            let narrow = value.is_finite() && value.radius <= WIDEST * scale;
            if !narrow || fits.len() < form.multiplicity {
                return false;
            }
            for at in &fits {
                used[*at] = true;
            }
            // Where the symmetry itself gives no name, the modes may have one.
            if form.symmetry.is_none()
                && let Some(first) = fits.first()
                && let Some(class) = &modes[*first].symmetry
                && fits
                    .iter()
                    .all(|at| modes[*at].symmetry.as_ref() == Some(class))
            {
                form.symmetry = Some(class.clone());
            }
            true
        });
        if forms.len() < before {
            case.complete = false;
            case.series.clear();
        }
        case.frequencies = forms.into_iter().map(|(_, form)| form).collect();
    }

    fn evaluate(&self, pool: &Pool, expressions: &[ExprId]) -> Option<Vec<Ball>> {
        let symbols = pool.symbols_of(expressions);
        let inputs: Option<Vec<Ball>> = symbols
            .iter()
            .map(|symbol| self.values.get(symbol).copied())
            .collect();
        let tape = Tape::compile(pool, expressions, &symbols).ok()?;
        Some(tape.evaluate(&inputs?, &mut Vec::new()))
    }

    /// The frequencies of M and K at the values at hand.
    fn solved(&self, pool: &Pool, pair: &Pair) -> Option<Vec<Reference>> {
        let n = pair.len();
        let entries = pair.values();
        let values = self.evaluate(pool, &entries)?;
        let value: HashMap<ExprId, Ball> = entries.into_iter().zip(values).collect();
        let dense = |rows: &[std::collections::BTreeMap<usize, ExprId>]| {
            let mut matrix = vec![Ball::ZERO; n * n];
            for (i, row) in rows.iter().enumerate() {
                for (j, entry) in row {
                    if let Some(value) = value.get(entry) {
                        matrix[i + n * j] = *value;
                    }
                }
            }
            matrix
        };
        let problem = Problem {
            dimension: n,
            mass: dense(&pair.mass),
            stiffness: dense(&pair.stiffness),
            zero_vectors: Vec::new(),
        };
        let spectrum = modes::solve(&problem, &Options::default().without_vectors()).ok()?;
        let modes = spectrum.modes.into_iter().map(|mode| Reference {
            omega_squared: mode.omega_squared,
            symmetry: None,
        });
        Some(modes.collect())
    }
}

fn equal(pool: &Pool, a: ExprId, b: ExprId) -> bool {
    // A copy is needed to write the difference down; only near coincidences come here.
    let mut pool = pool.clone();
    let difference = pool.sub(a, b);
    pool.is_zero(difference) == ZeroVerdict::Zero
}

fn references(linearized: &Linearized) -> Option<Vec<Reference>> {
    let modes = normal_modes(linearized, &Options::default().without_vectors()).ok()?;
    let references = modes.modes.into_iter().map(|mode| Reference {
        omega_squared: mode.omega_squared.unwrap_or(Ball::NOT_FINITE),
        symmetry: mode.symmetry,
    });
    Some(references.collect())
}

/// A positive rational number without a relation to the others: (2 a + 1)/(2 b), between 1/2 and 2.
fn drawn(number: usize) -> Ball {
    let mut x = (number as u64).wrapping_add(0x9e37_79b9_7f4a_7c15);
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    let part = i64::try_from(x >> 45).unwrap_or(0);
    // part is below 2^19, so that this is between 1/2 and 2.
    let value = Number::ratio((1 << 18) + part, 1 << 19).unwrap_or(Number::ONE);
    Ball::from_number(&value, ())
}
