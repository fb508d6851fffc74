//! Units in which the numbers of a model are about 1, where those that it is written in are far from it.
//!
//! Energies, times and each coordinate get a power of two for a unit, which is put into all expressions before anything is
//! differentiated: q_i = 2^length_i q_i', t = t'/2^rate, E = 2^energy E'. So M_ij = 2^(energy - 2 rate - length_i - length_j) M_ij', K and G + C
//! likewise with no and one power of the rate, and λ = 2^rate λ'. Nothing is rounded. What the expressions of such a model go through on
//! their way may be anywhere, so that they are evaluated in numbers whose exponents have no end ([`Values::wide`]), and end as balls.

use super::MOST_COORDINATES;
use super::assemble::{Assembly, Part, Values, evaluate_closed};
use super::constrained::{choose_bound, gradients};
use super::tied::put_multipliers_in;
use super::velocity::Matrix;
use crate::expr::{ExprId, Pool, Substitution, Symbol};
use crate::model::{Model, TermFamily};
use crate::number::Number;
use crate::precision::{Ball, Big, DoubleDouble, Magnitude, Scalar, up};

/// Entries of matrices from 2^-300 to 2^300 are left as they are: their squares and quotients are doubles.
const USUAL: i64 = 300;

/// Units beyond 2 to the power of this are none: numbers of the language end not much later.
const FARTHEST: i64 = 20_000;

/// What is left by rounding numbers about 1 is larger than 2 to minus this.
const ROUNDED: i64 = 120;

/// Units are estimated with so many bits.
const BITS: usize = 192;

/// Powers of two that a model is measured in, far from usual numbers.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Units {
    /// An energy E is 2^energy E'. Even.
    energy: i64,
    /// An exponent λ is 2^rate λ'.
    rate: i64,
    /// A coordinate q_i is 2^lengths_i q_i'.
    lengths: Vec<i64>,
}

/// n for a magnitude in [2^n, 2^(n+1)); `None` for 0 and what is no number.
fn exponent(size: Magnitude) -> Option<i64> {
    (!size.is_zero() && size.is_finite()).then(|| size.parts().1)
}

/// Where the numbers of a model are.
#[derive(Clone, Copy, PartialEq)]
enum Range {
    Usual,
    /// An entry that is none or large, or a coordinate with small ones alone.
    Far,
    /// Something is not told from 0: it may be small, or lost on its way.
    Open,
}

/// The entries of a row.
#[derive(Clone, Copy)]
struct Row {
    /// The power of two of the largest.
    most: Option<i64>,
    /// The same of those that are told from 0.
    told: Option<i64>,
    /// Whether one may be 0 or not.
    is_open: bool,
}

/// Where the numbers of the model are at a point: entries of M, G, C, K and N, and forces.
fn range<S: Scalar>(
    assembly: &Assembly,
    values: &Values<S>,
    at: &[S],
    size: impl Fn(&S) -> Option<i64>,
    is_open: impl Fn(&S) -> bool,
) -> Range {
    // Elements without force where the equilibrium is given have none to ask for.
    let force = if assembly.unstressed { Vec::new() } else { assembly.gradient(at, values) };
    let is_usual = |x: &S| x.is_finite() && size(x) <= Some(USUAL);
    let mut far = !force.iter().all(is_usual);
    for matrix in [Matrix::Gyroscopic, Matrix::Damping, Matrix::Circulatory] {
        assembly.velocity_entries(matrix, at, values, &mut |_, _, share| far |= !is_usual(&share));
    }
    let mut open = false;
    for part in [Part::Inertia, Part::Stiffness] {
        let mut rows = vec![Row { most: None, told: None, is_open: false }; at.len()];
        assembly.entries(part, at, values, |i, j, share| {
            let own = size(share);
            far |= !share.is_finite() || own > Some(USUAL);
            let is_open = is_open(share);
            for row in [i, j] {
                if let Some(row) = rows.get_mut(row as usize) {
                    row.most = own.max(row.most);
                    row.is_open |= is_open;
                    row.told = if is_open { row.told } else { own.max(row.told) };
                }
            }
        });
        far |= rows.iter().any(|row| row.most.is_some_and(|own| own < -USUAL));
        open |= rows.iter().any(|row| row.is_open && row.told < Some(-USUAL));
        if part == Part::Stiffness {
            // Beside a stiffness that is told from 0, a force that is not, for its rounding alone, moves nothing.
            let is_lost =
                |row: &Row, force: &S| row.told < Some(-USUAL) || size(force) < row.told.map(|own| own - ROUNDED);
            open |= rows.iter().zip(&force).any(|(row, force)| is_open(force) && is_lost(row, force));
        }
    }
    match (far, open) {
        (true, _) => Range::Far,
        (false, true) => Range::Open,
        (false, false) => Range::Usual,
    }
}

/// Whether the numbers of a model leave the range in which doubles do, where its search would start.
fn is_far(model: &Model, assembly: &Assembly, values: &Values<Ball>, start: &[Big]) -> bool {
    let rough: Vec<Ball> = start.iter().map(Big::to_far_ball).collect();
    let size = |x: &Ball| exponent(Magnitude::from_f64(x.abs_upper()));
    let small = |x: &Ball| size(x) < Some(-USUAL) && !x.is_zero();
    if rough.iter().any(small) {
        return true;
    }
    let is_open = |x: &Ball| x.contains_zero() && !x.is_zero();
    let is_usual = |x: &Ball| !x.contains_zero() && size(x).is_some_and(|own| own.abs() <= USUAL);
    if assembly.rests_plainly(&rough, values, is_usual) {
        return false;
    }
    match range(assembly, values, &rough, size, is_open) {
        Range::Far => true,
        Range::Usual => false,
        Range::Open => {
            let Ok(values) = assembly.values::<Big>(model, BITS) else { return false };
            let size = |x: &Big| exponent(x.abs_upper()).filter(|_| !x.contains_zero());
            // A force that balls do not tell from none, and is one.
            let lost = |x: &Big| size(x) < Some(-USUAL) && !x.contains_zero();
            assembly.gradient(start, &values).iter().any(lost)
                || range(assembly, &values, start, size, |_| false) == Range::Far
        }
    }
}

/// Where the search would start.
pub(super) fn start<S: Scalar>(model: &Model, precision: S::Precision) -> Option<Vec<S>> {
    let given = model.equilibria.iter().zip(model.guesses.iter());
    given
        .map(|(stated, guess)| match stated.or(guess) {
            Some(given) => evaluate_closed(&model.pool, given.value?, precision),
            None => Some(S::from_number(&Number::ZERO, precision)),
        })
        .collect()
}

/// Units for a model whose numbers are far from usual; `None` for any other, and where there are no numbers at all. The coordinates from
/// `visible` on are multipliers.
pub(super) fn choose(model: &Model, assembly: &Assembly, values: &Values<Ball>, visible: usize) -> Option<Units> {
    // They are estimated from dense matrices.
    if visible > MOST_COORDINATES {
        return None;
    }
    let mut at = start::<Big>(model, BITS)?;
    if !is_far(model, assembly, values, &at) {
        return None;
    }
    let n = at.len();
    let values = assembly.values::<Big>(model, BITS).ok()?;
    if visible < n {
        let second = assembly.stiffness(&at, &values);
        let bound = choose_bound(&gradients(&second, visible, n), None, BITS);
        // What is not determined stays 0.
        let mut tied = at.clone();
        if let Some(bound) = bound
            && put_multipliers_in(assembly, &values, &mut tied, visible, &bound).is_some()
        {
            at = tied;
        }
    }
    let mass = assembly.mass(&at, &values);
    let stiffness = assembly.stiffness(&at, &values);
    let finite = |matrix: &[Big]| matrix.iter().all(Big::is_finite);
    if !(finite(&mass) && finite(&stiffness)) {
        return None;
    }
    let of = |matrix: &[Big], i: usize, j: usize| exponent(matrix[i + n * j].abs_upper());
    let sizes: Vec<Option<i64>> = (0..visible).map(|i| of(&mass, i, i)).collect();
    let mut known: Vec<i64> = sizes.iter().copied().flatten().collect();
    known.sort_unstable();
    let middle = known.get(known.len() / 2).copied().unwrap_or(0) & !1;
    // Coordinates in which the kinetic energy is about 2^middle q'²/2; what has no mass follows the others' unit.
    let length = |size: &Option<i64>| size.map_or(0, |size| (middle - size).div_euclid(2));
    let mut lengths: Vec<i64> = sizes.iter().map(length).collect();
    let by = |lengths: &[i64], i: usize, j: usize| lengths[i] + lengths[j] - middle;
    // |λ| is at most about max(|D|, √|S|); without either, that of the force over one unit.
    let velocity: Vec<Vec<Big>> = [Matrix::Gyroscopic, Matrix::Damping]
        .into_iter()
        .filter_map(|matrix| assembly.velocity_matrix(matrix, &at, &values))
        .collect();
    let mut rate: Option<i64> = None;
    for (i, j) in (0..visible).flat_map(|i| (0..visible).map(move |j| (i, j))) {
        let square = of(&stiffness, i, j).map(|own| (own + by(&lengths, i, j)).div_euclid(2));
        let once = velocity.iter().filter_map(|matrix| of(matrix, i, j));
        let once = once.map(|own| own + by(&lengths, i, j)).max();
        rate = rate.max(square).max(once);
    }
    let force = assembly.gradient(&at, &values);
    let pushes = |i: usize| exponent(force[i].abs_upper()).map(|own| own + lengths[i] - middle);
    let pushed = (0..visible).filter_map(pushes).max();
    let rate = rate.or(pushed.map(|own| own.div_euclid(2))).unwrap_or(0);
    // The way that the forces go, or where the search starts, is about one unit.
    let away = (0..visible).filter_map(|i| Some(exponent(at[i].abs_upper())? - lengths[i]));
    let way = away.chain(pushed.map(|own| own - 2 * rate)).max();
    let way = way.filter(|way| way.abs() > USUAL).unwrap_or(0);
    lengths.iter_mut().for_each(|own| *own += way);
    let energy = middle + 2 * way + 2 * rate;
    for k in visible..n {
        let slopes = (0..visible).filter_map(|i| Some(of(&stiffness, k, i)? + lengths[i]));
        lengths.push(slopes.max().map_or(0, |most| energy - most));
    }
    let is_far = |own: &i64| own.abs() > FARTHEST;
    (![energy, rate].iter().chain(&lengths).any(is_far)).then_some(Units { energy, rate, lengths })
}

/// 2^exponent.
pub fn power_of_two(exponent: i64) -> Number {
    let by = i32::try_from(exponent).unwrap_or(0);
    Number::from(2).powi(by).unwrap_or_default()
}

impl Units {
    /// n for exponents λ of 2^n λ'.
    pub fn rate(&self) -> i64 {
        self.rate
    }

    /// Puts the units into all that numbers come from.
    pub(super) fn put_in(&self, model: &mut Model) {
        let pool = &mut model.pool;
        for family in model.kinetic.iter_mut().chain(&mut model.potential) {
            self.put_in_family(pool, family, -self.energy);
        }
        for family in &mut model.forces {
            self.put_in_family(pool, family, -self.energy - if family.acts_on.is_some() { 0 } else { self.rate });
        }
        let mut map = Substitution::default();
        for (coordinate, length) in model.coordinates.iter().zip(&self.lengths) {
            let own = pool.symbol_expr(coordinate.symbol);
            map.insert(coordinate.symbol, pool.scale(own, &power_of_two(*length)));
        }
        for constraint in &mut model.constraints {
            constraint.expression = pool.substitute_one(constraint.expression, &map);
        }
        for stated in [&mut model.guesses, &mut model.equilibria] {
            for (coordinate, given) in stated.given_mut() {
                let by = power_of_two(-self.length(coordinate));
                given.symbolic = pool.scale(given.symbolic, &by);
                given.value = given.value.map(|value| pool.scale(value, &by));
            }
        }
    }

    /// The same for a family of terms, which is multiplied by 2^factor, and a force by the unit of what it acts on. Where one slot is filled with coordinates of several units, the units
    /// are slots themselves.
    fn put_in_family(&self, pool: &mut Pool, family: &mut TermFamily, factor: i64) {
        let width = family.locals.len();
        let length = |number: u32| self.lengths.get(number as usize).copied().unwrap_or(0);
        let mut map = Substitution::default();
        let mut slots: Vec<(usize, Symbol)> = Vec::new();
        let mut units: Vec<ExprId> = Vec::with_capacity(width);
        for (at, local) in family.locals.iter().enumerate() {
            let mut own = family.coordinates.iter().skip(at).step_by(width);
            let first = own.next().map_or(0, |number| length(*number));
            let unit = if own.all(|number| length(*number) == first) {
                pool.number(power_of_two(first))
            } else {
                let unit = pool.symbol(&format!("unit {}", local.coordinate.index()));
                slots.push((at, unit));
                pool.symbol_expr(unit)
            };
            units.push(unit);
            map.insert(local.coordinate, pool.times(unit, local.coordinate));
            let velocity = pool.times(unit, local.velocity);
            map.insert(local.velocity, pool.scale(velocity, &power_of_two(self.rate)));
        }
        let mut body = pool.substitute_one(family.body, &map);
        if let Some(unit) = family.acts_on.and_then(|place| units.get(place)) {
            body = pool.mul(*unit, body);
        }
        family.body = pool.scale(body, &power_of_two(factor));
        if !slots.is_empty() {
            family.add_values(&slots, |number| pool.number(power_of_two(length(number))));
        }
    }

    /// The power of two that brings the shape of a mode, x with xᵀMx = 1, to SI in a coordinate.
    pub(crate) fn of_shapes(&self, coordinate: usize) -> i64 {
        self.length(coordinate) + self.rate - self.energy / 2
    }

    /// Brings the shape of a mode to SI, or a part of it, in all coordinates; with `back` the other way.
    pub(crate) fn shape(&self, vector: &mut [f64], back: bool) {
        for (at, x) in vector.iter_mut().enumerate() {
            let by = clamped(self.of_shapes(at));
            *x = DoubleDouble::exact(*x).scale(if back { -by } else { by }).hi;
        }
    }

    /// A bound of all components of such a shape, likewise.
    pub(crate) fn shape_error(&self, bound: f64, coordinates: usize, back: bool) -> f64 {
        let powers = || (0..coordinates).map(|at| self.of_shapes(at));
        let most = powers().max().unwrap_or(0);
        let bound = Magnitude::from_f64(bound).scale(if back { -most } else { most });
        // What is smaller than doubles are, was rounded.
        let lost = powers().min().filter(|_| back);
        let lost = lost.map_or(Magnitude::ZERO, |least| Magnitude::power_of_two(-1074 - least));
        up(bound.max(lost).to_f64())
    }

    /// Bounds of the components of such a shape in SI one by one, where `bound` is that of the largest.
    pub(crate) fn component_errors(&self, bound: f64, coordinates: usize) -> Vec<f64> {
        let powers = (0..coordinates).map(|at| self.of_shapes(at));
        let most = powers.clone().max().unwrap_or(0);
        let bound = Magnitude::from_f64(bound);
        let of = |by: i64| up(bound.scale(by - most).to_f64());
        powers.map(of).collect()
    }

    /// A direction of all coordinates in SI, its largest component 1.
    pub(crate) fn direction(&self, vector: &mut [f64]) {
        let sizes = vector.iter().zip(&self.lengths);
        let sizes = sizes.map(|(x, length)| Magnitude::from_f64(*x).scale(*length));
        let most = sizes.filter_map(exponent).max().unwrap_or(0);
        for (x, length) in vector.iter_mut().zip(&self.lengths) {
            *x = DoubleDouble::exact(*x).scale(clamped(length - most)).hi;
        }
    }

    /// n for lengths of a coordinate of 2^n.
    pub fn length(&self, coordinate: usize) -> i64 {
        self.lengths.get(coordinate).copied().unwrap_or(0)
    }

    /// n for energies of 2^n.
    pub fn energy(&self) -> i64 {
        self.energy
    }

    /// Coordinates that were measured in these units, in SI.
    pub(super) fn positions(&self, values: &[Ball]) -> Vec<Ball> {
        let both = values.iter().zip(&self.lengths);
        both.map(|(value, length)| value.scale_far(*length)).collect()
    }
}

/// Further than any double.
fn clamped(exponent: i64) -> i32 {
    exponent.clamp(-3000, 3000) as i32
}
