//! Normal coordinates of chains, rings and nets of any size: each coordinate a sum of sines times normal coordinates.
//!
//! What commutes with T of `lattice` has the vectors of T. With theta as its table says they are (G. Strang, SIAM Review 41 (1999)
//! 135), at the place i from 1 to N, by the corner c at the first place:
//!
//! ```text
//! c = 0: sin(i theta)     c = 1: cos((i - 1/2) theta)     c = -1: sin((i - 1/2) theta)
//! ```
//!
//! Their squares sum up to (N + 1)/2 for the corners (0, 0); to N/2 for (1, 1), (-1, -1), (1, -1) and (-1, 1); and to (2 N + 1)/4
//! where one corner is 0 (each by the sum of cos(2 i theta) or cos((2 i - 1) theta) as a geometric series). Only theta = 0 of
//! (1, 1) and theta = pi of (-1, -1), where all squares are 1, have N instead.
//!
//! A ring has cos(i theta - pi/4), theta = 2 pi j/N: cosine and sine of a wave with equal weights, which takes both waves j and N - j
//! apart (Hartley's transform). The squares sum up to N/2, products with other j to 0.
//!
//! With the eigenvalue mu_j of M the amplitudes are these by sqrt(mu_j sum of squares), so that xᵀMx = 1.

use super::check::Checker;
use super::frequencies::{Case, Series};
use super::lattice::{Dimension, Ends, Lattice};
use super::pair::Pair;
use crate::expr::{ExprId, Pool, Symbol};
use crate::model::Model;
use crate::number::Number;
use crate::order::Order;

/// All modes are held against the numbers up to so many coordinates, above that as many as `MOST_CHECKED`: that all are modes
/// follows from what was shown in symbols.
const MOST_FOR_ALL: usize = 64;
const MOST_CHECKED: usize = 16;

/// The normal coordinates of a chain, ring or net.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct NormalWaves {
    /// The coordinates by number, as they follow each other along the chain; of a net row by row.
    pub order: Vec<usize>,
    /// The letters of the places in each dimension, which run from 1 to the second.
    pub places: Vec<(String, i64)>,
    /// What a displacement is the sum of.
    pub sums: Vec<WaveSum>,
    /// The family of its normal coordinates: that of [`super::Names`] for the first chain of a model.
    pub normal: String,
    /// The family of its frequencies, with the numbers of the mode as indices.
    pub omega: String,
}

/// factor times the sum of shape times normal coordinate over some numbers.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct WaveSum {
    /// What doesn't depend on the mode.
    pub factor: ExprId,
    /// Its square.
    pub factor_squared: ExprId,
    /// What depends on place and mode, in the letters of both.
    pub shape: ExprId,
    /// The letters for the numbers of a mode with the first and the last number.
    pub numbers: Vec<WaveNumber>,
}

/// A number of a mode.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct WaveNumber {
    /// Its letter.
    pub name: String,
    /// The least.
    pub first: i64,
    /// The largest.
    pub last: i64,
}

/// The normal coordinates of a model that is made of lattices with the frequencies of a case, if they hold against certified numbers.
pub(super) fn normal_waves(
    pool: &mut Pool,
    checker: &Checker<'_>,
    pair: &Pair,
    case: &Case,
    lattices: &[Lattice],
) -> Option<Vec<NormalWaves>> {
    let all: usize = lattices.iter().map(|lattice| lattice.order.len()).sum();
    if !case.complete || all != pair.len() || case.series.len() != lattices.len() {
        return None;
    }
    let normals = free(checker.model, &["Q", "eta", "xi", "zeta"]);
    let omegas = free(checker.model, &["omega", "Omega", "w", "nu"]);
    let waves = lattices.iter().zip(&case.series).enumerate().map(|(at, (lattice, series))| {
        let waves = waves_of(pool, checker.model, series, lattice, [normals.get(at)?, omegas.get(at)?])?;
        waves.holds(pool, checker, pair, series.omega_squared).then_some(waves)
    });
    waves.collect()
}

/// Those names that a model does not use.
pub(super) fn unused(model: &Model, names: &[&str]) -> Vec<String> {
    let own = names.iter().filter(|name| model.unused_name(&[name]) == **name);
    own.map(|name| (*name).to_owned()).collect()
}

/// The same; one at least.
fn free(model: &Model, names: &[&str]) -> Vec<String> {
    let own = unused(model, names);
    if own.is_empty() { vec![model.unused_name(names)] } else { own }
}

fn waves_of(
    pool: &mut Pool,
    model: &Model,
    series: &Series,
    lattice: &Lattice,
    by: [&String; 2],
) -> Option<NormalWaves> {
    let dimensions = &lattice.dimensions;
    let exceptional = |ends: Ends| matches!(ends, Ends::Corners(1, 1) | Ends::Corners(-1, -1));
    if series.numbers.len() != dimensions.len()
        || (dimensions.len() > 1 && dimensions.iter().any(|own| exceptional(own.ends)))
    {
        return None;
    }
    let letters = [["n", "l", "r"], ["m", "p", "t"]];
    let letter = |names: &[&str; 3]| model.unused_name(names);
    let names: Vec<String> = match dimensions.as_slice() {
        [_] => vec![letter(&letters[0])],
        // The last index is the fastest.
        [_, _] => letters.iter().rev().map(letter).collect(),
        _ => return None,
    };
    let places: Vec<Symbol> = names.iter().map(|name| pool.symbol(name)).collect();
    let numbers: Vec<Symbol> = series.numbers.iter().map(|(name, _)| pool.symbol(name)).collect();
    let mut shape = Vec::new();
    let mut angles = Vec::new();
    let mut inverse = Number::ONE;
    for ((dimension, own), (place, number)) in dimensions.iter().zip(&series.numbers).zip(places.iter().zip(&numbers)) {
        let [place, number] = [place, number].map(|own| pool.symbol_expr(*own));
        let half = own.1.general(pool, number);
        angles.push(half);
        shape.push(dimension.component(pool, place, half));
        inverse = inverse.mul(&dimension.inverse_of_squares());
    }
    let mass = lattice.at(pool, lattice.mass, &angles);
    let shape = pool.product(&shape);
    let depends = pool.symbols(mass).iter().any(|s| numbers.contains(s));
    let (factor_squared, shape) = if depends {
        let weight = pool.powr(mass, &Number::half().neg());
        (pool.number(inverse), pool.mul(shape, weight))
    } else {
        let own = pool.div(pool.one(), mass);
        (pool.scale(own, &inverse), shape)
    };
    let ranges = series.numbers.iter();
    let ranges = ranges.map(|(name, own)| WaveNumber { name: name.clone(), first: own.first, last: own.last });
    let mut sums =
        vec![WaveSum { factor: pool.sqrt(factor_squared), factor_squared, shape, numbers: ranges.collect() }];
    // The mode of theta = 0 or pi stands apart.
    if let [dimension] = dimensions.as_slice()
        && exceptional(dimension.ends)
        && let [(number, angles)] = series.numbers.as_slice()
        && let [place] = places.as_slice()
    {
        let first = dimension.ends == Ends::Corners(1, 1);
        let at = if first { angles.first } else { angles.last };
        let half = angles.angle(pool, at);
        let place = pool.symbol_expr(*place);
        let shape = dimension.component(pool, place, half);
        let mass = lattice.at(pool, lattice.mass, &[half]);
        let own = pool.div(pool.one(), mass);
        let count = i64::try_from(dimension.size).ok()?;
        let square = pool.scale(own, &Number::ratio(1, count).unwrap_or_default());
        let alone = WaveSum {
            factor: pool.sqrt(square),
            factor_squared: square,
            shape,
            numbers: vec![WaveNumber { name: number.clone(), first: at, last: at }],
        };
        let others = sums.first_mut()?.numbers.first_mut()?;
        if first {
            others.first += 1;
        } else {
            others.last -= 1;
        }
        sums.push(alone);
        sums.order_by_key(|sum| sum.numbers.first().map(|own| own.first));
    }
    let size = |own: &Dimension| i64::try_from(own.size).unwrap_or(0);
    Some(NormalWaves {
        order: lattice.order.clone(),
        places: names.into_iter().zip(dimensions.iter().map(size)).collect(),
        sums,
        normal: by[0].clone(),
        omega: by[1].clone(),
    })
}

impl NormalWaves {
    /// Whether the vectors are modes in numbers.
    fn holds(&self, pool: &mut Pool, checker: &Checker<'_>, pair: &Pair, omega_squared: ExprId) -> bool {
        let count = self.order.len();
        let every = if count <= MOST_FOR_ALL { 1 } else { count / MOST_CHECKED };
        // By coordinate: its place in each dimension.
        let mut at = vec![Vec::new(); pair.len()];
        for (along, i) in self.order.iter().enumerate() {
            let mut rest = along;
            let mut own = Vec::new();
            for (_, size) in self.places.iter().rev() {
                let size = usize::try_from(*size).unwrap_or(1).max(1);
                own.push(i64::try_from(rest % size + 1).unwrap_or(0));
                rest /= size;
            }
            own.reverse();
            if let Some(place) = at.get_mut(*i) {
                *place = own;
            }
        }
        let places: Vec<Symbol> = self.places.iter().map(|(name, _)| pool.symbol(name)).collect();
        let mut columns = Vec::new();
        for sum in &self.sums {
            let numbers: Vec<Symbol> = sum.numbers.iter().map(|own| pool.symbol(&own.name)).collect();
            let amplitude = pool.mul(sum.factor, sum.shape);
            let mut modes: Vec<Vec<i64>> = vec![Vec::new()];
            for WaveNumber { first, last, .. } in &sum.numbers {
                let longer =
                    modes.iter().flat_map(|mode| (*first..=*last).map(|j| mode.iter().copied().chain([j]).collect()));
                modes = longer.collect();
            }
            let mut chosen: Vec<Vec<i64>> = modes.iter().step_by(every).cloned().collect();
            chosen.extend(modes.pop());
            chosen.dedup();
            let letters = [(places.as_slice(), at.as_slice()), (&numbers, &chosen)];
            let Some(found) = checker.waves(pool, [omega_squared, amplitude], letters) else { return false };
            columns.extend(found);
        }
        checker.are_waves(pool, pair, &columns)
    }
}

impl Dimension {
    /// One over the sum of the squares of the components.
    fn inverse_of_squares(&self) -> Number {
        let n = i64::try_from(self.size).unwrap_or(i64::MAX / 8);
        let (above, below) = match self.ends {
            Ends::Corners(0, 0) => (2, n + 1),
            Ends::Corners(0, _) | Ends::Corners(_, 0) => (4, 2 * n + 1),
            Ends::Joined | Ends::Corners(..) => (2, n),
        };
        Number::ratio(above, below).unwrap_or_default()
    }

    /// The component at a place, where theta/2 is this angle.
    fn component(&self, pool: &mut Pool, place: ExprId, half: ExprId) -> ExprId {
        let along = pool.mul(place, half);
        let two = Number::from(2);
        let angle = match self.ends {
            Ends::Corners(0, _) => pool.scale(along, &two),
            Ends::Corners(..) => pool.linear(&[(along, two), (half, Number::MINUS_ONE)]),
            Ends::Joined => {
                let pi = pool.pi();
                pool.linear(&[(along, two), (pi, Number::ratio(-1, 4).unwrap_or_default())])
            }
        };
        let is_even = matches!(self.ends, Ends::Joined | Ends::Corners(1, _));
        if is_even { pool.cos(angle) } else { pool.sin(angle) }
    }
}
