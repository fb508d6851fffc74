//! The shapes of modes whose omega^2 has a closed form: one to four coordinates that hang together, or as many vectors of a class
//! of symmetry.
//!
//! A column of the adjugate of K - z M solves (K - z M) a = 0; where there are two coordinates a form without a root below the
//! bar is tried beside it. Long ones are written with a symbol for omega.

use std::collections::BTreeMap;

use super::pair::{Pair, Sparse};
use super::simplify::{Algebra, Opening, expand, split, with_common_factor, written};
use crate::expr::{ExprId, Pool, Symbol};
use crate::number::Number;

/// A ratio of amplitudes of more symbols gets a name of its own.
const MOST_IN_RATIO: u64 = 16;
/// Likewise what it is normalised by.
const MOST_IN_MASS: u64 = 32;
/// Above that it is written with the ratio.
const MOST_WITH_RATIO: u64 = 64;
/// Ratios of three or four coordinates of more symbols fit on no page.
const MOST_IN_COLUMN: u64 = 400;

/// A mode as it is found.
pub(super) struct Shape {
    pub(super) omega_squared: ExprId,
    pub(super) symmetry: Option<String>,
    /// Vectors and what each is multiplied by; 1 for the first.
    pub(super) parts: Vec<(Sparse, ExprId)>,
    /// aᵀMa
    pub(super) mass: ExprId,
    /// Stands for the frequency in the factors and in the mass, where it is not written out there.
    pub(super) omega: Option<Symbol>,
    /// What stands for the factors in the mass, from the second on; none where they are written out there.
    pub(super) factors: Vec<Symbol>,
}

impl Shape {
    /// One vector alone.
    fn alone(pool: &Pool, omega_squared: ExprId, vector: &Sparse, mass: ExprId) -> Self {
        let parts = vec![(vector.clone(), pool.one())];
        Self { omega_squared, symmetry: None, parts, mass, omega: None, factors: Vec::new() }
    }

    /// Whether it is the shape of three coordinates or more, which is too long to be written out.
    pub(super) fn is_long(&self) -> bool {
        self.parts.len() > 2
    }

    pub(super) fn along(&self, count: usize, pool: &mut Pool) -> Vec<ExprId> {
        combined(pool, count, self.parts.iter().map(|(basis, factor)| (basis, *factor)))
    }
}

/// The sum of vectors times factors.
pub(super) fn combined<'a>(
    pool: &mut Pool,
    count: usize,
    parts: impl Iterator<Item = (&'a Sparse, ExprId)>,
) -> Vec<ExprId> {
    let mut vector = vec![Vec::new(); count];
    for (basis, factor) in parts {
        for (i, component) in basis {
            if let Some(place) = vector.get_mut(*i) {
                place.push((factor, Number::from(*component)));
            }
        }
    }
    vector.iter().map(|terms| pool.linear(terms)).collect()
}

/// The modes of a part of one or two coordinates with these omega^2; `basis` says which vectors of the model its
/// coordinates are. None where they can't be told apart.
pub(super) fn shapes(pool: &mut Algebra<'_>, part: &Pair, squares: &[ExprId], basis: &[Sparse]) -> Vec<Shape> {
    match (squares, basis) {
        ([square], [vector]) => vec![Shape::alone(pool, *square, vector, part.at(pool, 0, 0).0)],
        ([first, second], [u, v]) => {
            if pool.agree(*first, *second) {
                return Vec::new();
            }
            let block = Block::new(pool, part);
            [*first, *second].into_iter().map(|square| block.mode(pool, square, [u, v])).collect()
        }
        _ if squares.len() == basis.len() => column(pool, part, squares, basis).unwrap_or_default(),
        _ => Vec::new(),
    }
}

/// The modes of three or four coordinates, all by the same column of the adjugate of K - omega^2 M, in which omega is a symbol.
fn column(pool: &mut Algebra<'_>, part: &Pair, squares: &[ExprId], basis: &[Sparse]) -> Option<Vec<Shape>> {
    let n = part.len();
    if !(3..=4).contains(&n) {
        return None;
    }
    let one = pool.one();
    let symbol = pool.fresh_symbol("omega");
    let omega = pool.symbol_expr(symbol);
    let square = pool.square(omega);
    let mut entry = |i: usize, j: usize| {
        let (m, k) = part.at(pool, i, j);
        let inertia = pool.mul(square, m);
        pool.sub(k, inertia)
    };
    let entries: Vec<Vec<ExprId>> = (0..n).map(|i| (0..n).map(|j| entry(i, j)).collect()).collect();
    let mut best: Option<(u64, Vec<ExprId>)> = None;
    for row in 0..n {
        let cofactors: Vec<ExprId> = (0..n).map(|other| cofactor(pool, &entries, row, other)).collect();
        let first = *cofactors.first()?;
        if pool.vanishes(first) {
            continue;
        }
        let mut ratios = Vec::new();
        for cofactor in &cofactors[1..] {
            let quotient = pool.short(|pool| pool.div(*cofactor, first));
            ratios.push(on_one_bar(pool, quotient));
        }
        let weight = pool.weight_of(&ratios);
        if best.as_ref().is_none_or(|(least, _)| weight < *least) {
            best = Some((weight, ratios));
        }
    }
    let (_, ratios) = best.filter(|(weight, _)| *weight <= MOST_IN_COLUMN)?;
    let factors: Vec<Symbol> = ratios.iter().map(|_| pool.fresh_symbol("a")).collect();
    let mut amplitudes = vec![one];
    amplitudes.extend(factors.iter().map(|symbol| pool.symbol_expr(*symbol)));
    let mut terms = Vec::new();
    for i in 0..n {
        for j in i..n {
            let (m, _) = part.at(pool, i, j);
            let product = pool.product(&[m, amplitudes[i], amplitudes[j]]);
            terms.push((product, Number::from(if i == j { 1 } else { 2 })));
        }
    }
    let mass = pool.short(|pool| pool.linear(&terms));
    let vectors: Vec<(Sparse, ExprId)> =
        basis.iter().cloned().zip(std::iter::once(one).chain(ratios)).filter(|(_, factor)| !factor.is_zero()).collect();
    // A factor that is 0 for all modes would leave its symbol without a meaning.
    if vectors.len() < n {
        return None;
    }
    let shapes = squares.iter().map(|omega_squared| Shape {
        omega_squared: *omega_squared,
        symmetry: None,
        parts: vectors.clone(),
        mass,
        omega: Some(symbol),
        factors: factors.clone(),
    });
    Some(shapes.collect())
}

/// The cofactor of an entry of a matrix of up to four rows.
fn cofactor(pool: &mut Algebra<'_>, entries: &[Vec<ExprId>], row: usize, column: usize) -> ExprId {
    let without = |at: usize| (0..entries.len()).filter(move |i| *i != at);
    let rows: Vec<Vec<ExprId>> = without(row).map(|i| without(column).map(|j| entries[i][j]).collect()).collect();
    let minor = pool.short(|pool| determinant(pool, &rows));
    if (row + column).is_multiple_of(2) { minor } else { pool.neg(minor) }
}

/// The determinant of up to three rows.
pub(super) fn determinant(pool: &mut Pool, rows: &[Vec<ExprId>]) -> ExprId {
    let two = |pool: &mut Pool, [a, b]: [ExprId; 2], [c, d]: [ExprId; 2]| {
        let (left, right) = (pool.mul(a, d), pool.mul(b, c));
        pool.sub(left, right)
    };
    match rows {
        [a] => a[0],
        [a, b] => two(pool, [a[0], a[1]], [b[0], b[1]]),
        [a, b, c] => {
            let mut parts = Vec::new();
            for (i, entry) in a.iter().enumerate() {
                let (j, k) = ((i + 1) % 3, (i + 2) % 3);
                let minor = two(pool, [b[j], b[k]], [c[j], c[k]]);
                parts.push(pool.mul(*entry, minor));
            }
            pool.sum(&parts)
        }
        _ => pool.undefined(),
    }
}

/// M and K of two coordinates.
struct Block {
    m: [ExprId; 3],
    k: [ExprId; 3],
}

impl Block {
    fn new(pool: &Pool, part: &Pair) -> Self {
        let entries = [(0, 0), (0, 1), (1, 1)].map(|(i, j)| part.at(pool, i, j));
        Self { m: entries.map(|(m, _)| m), k: entries.map(|(_, k)| k) }
    }

    /// The mode of a frequency; with a symbol for omega where that is shorter by far.
    fn mode(&self, pool: &mut Algebra<'_>, square: ExprId, [u, v]: [&Sparse; 2]) -> Shape {
        let one = pool.one();
        let parts = |ratio: ExprId| {
            [(u.clone(), one), (v.clone(), ratio)].into_iter().filter(|(_, factor)| !factor.is_zero()).collect()
        };
        let mut mode = Shape::alone(pool, square, v, self.m[2]);
        let Some((at, ratio)) = self.ratio(pool, square, None) else { return mode };
        mode.parts = parts(ratio);
        mode.mass = self.mass(pool, ratio);
        if pool.weight(ratio) <= MOST_IN_RATIO && pool.weight(mode.mass) <= MOST_IN_MASS {
            return mode;
        }
        let symbol = pool.fresh_symbol("omega");
        let omega = pool.symbol_expr(symbol);
        let omega_squared = pool.square(omega);
        if let Some((_, ratio)) = self.ratio(pool, omega_squared, Some(at)) {
            mode.parts = parts(ratio);
            mode.mass = self.mass(pool, ratio);
            mode.omega = Some(symbol);
            if pool.weight(mode.mass) > MOST_WITH_RATIO {
                let symbol = pool.fresh_symbol("a");
                let factor = pool.symbol_expr(symbol);
                mode.mass = self.mass(pool, factor);
                mode.factors = vec![symbol];
            }
        }
        mode
    }

    /// M_11 + 2 M_12 a + M_22 a^2
    fn mass(&self, pool: &mut Algebra<'_>, ratio: ExprId) -> ExprId {
        let square = pool.square(ratio);
        let (mixed, last) = (pool.mul(self.m[1], ratio), pool.mul(self.m[2], square));
        let sum =
            pool.short(|pool| pool.linear(&[(self.m[0], Number::ONE), (mixed, Number::from(2)), (last, Number::ONE)]));
        let sum = on_one_bar(pool, sum);
        let (size, product) = split(pool, sum);
        let factors = pool.factors(product).into_iter().map(|(base, power)| (pool.polished(base), power));
        let factors: Vec<(ExprId, Number)> = factors.collect();
        let product = pool.product_of_powers(&factors);
        pool.scale(product, &size)
    }

    /// The shortest of the forms that the two rows of (K - z M) a = 0 give, or of one form of them; and which ones have a
    /// value. Both rows together give a third, in which z stands in no denominator: with z1 + z2 = s and z1 z2 = p
    ///
    /// ```text
    /// a = ((M_11 K_12 - K_11 M_12) z + K_11 M_12 s - K_11 K_12 - M_11 M_12 p) / (M_12^2 p - M_12 K_12 s + K_12^2)
    /// ```
    ///
    /// which is the first row, a = (K_11 - z1 M_11)/(z1 M_12 - K_12), extended by z2 M_12 - K_12.
    fn ratio(&self, pool: &mut Algebra<'_>, z: ExprId, forms: Option<[bool; 3]>) -> Option<([bool; 3], ExprId)> {
        let entry = |pool: &mut Pool, i: usize| {
            let inertia = pool.mul(z, self.m[i]);
            pool.linear(&[(self.k[i], Number::ONE), (inertia, Number::MINUS_ONE)])
        };
        let [first, mixed, last] = [0, 1, 2].map(|i| entry(pool, i));
        let opposite = pool.neg(mixed);
        let fractions = [(first, opposite), (opposite, last), self.without_root(pool, z)];
        let mut best: Option<(u64, ExprId)> = None;
        let mut usable = [false; 3];
        for (at, (above, below)) in fractions.into_iter().enumerate() {
            let below = pool.simplify(below);
            if !forms.map_or_else(|| !pool.vanishes(below), |forms| forms[at]) {
                continue;
            }
            usable[at] = true;
            let above = pool.simplify(above);
            let quotient = pool.short(|pool| pool.div(above, below));
            let quotient = on_one_bar(pool, quotient);
            let weight = pool.weight(quotient);
            if !pool.is_undefined(quotient) && best.is_none_or(|(least, _)| weight < least) {
                best = Some((weight, quotient));
            }
        }
        best.map(|(_, ratio)| (usable, ratio))
    }

    /// Numerator and denominator of the third form.
    fn without_root(&self, pool: &mut Pool, z: ExprId) -> (ExprId, ExprId) {
        let ([m1, m12, m2], [k1, k12, k2]) = (self.m, self.k);
        let of_m = determinant(pool, &[vec![m1, m12], vec![m12, m2]]);
        let of_k = determinant(pool, &[vec![k1, k12], vec![k12, k2]]);
        let p = pool.div(of_k, of_m);
        let crossed = [pool.mul(m1, k2), pool.mul(m2, k1), pool.mul(m12, k12)];
        let traced =
            pool.linear(&[(crossed[0], Number::ONE), (crossed[1], Number::ONE), (crossed[2], Number::from(-2))]);
        let s = pool.div(traced, of_m);
        let (left, right) = (pool.mul(m1, k12), pool.mul(k1, m12));
        let slope = pool.sub(left, right);
        let terms = [
            (pool.mul(slope, z), Number::ONE),
            (pool.product(&[k1, m12, s]), Number::ONE),
            (pool.mul(k1, k12), Number::MINUS_ONE),
            (pool.product(&[m1, m12, p]), Number::MINUS_ONE),
        ];
        let above = pool.linear(&terms);
        let (m, k) = (pool.square(m12), pool.square(k12));
        let terms =
            [(pool.mul(m, p), Number::ONE), (pool.product(&[m12, k12, s]), Number::MINUS_ONE), (k, Number::ONE)];
        (above, pool.linear(&terms))
    }
}

/// A sum of fractions as one fraction, where that is not much longer.
pub(super) fn on_one_bar(pool: &mut Algebra<'_>, e: ExprId) -> ExprId {
    let fraction = fraction_with(pool, e, Opening::Powers);
    let (own, before) = (pool.weight(fraction), pool.weight(e));
    if own <= before + before / 2 { fraction } else { e }
}

/// A sum of fractions as one fraction, multiplied out or not, whichever reads better.
pub(super) fn one_fraction(pool: &mut Algebra<'_>, e: ExprId) -> ExprId {
    let all = [Opening::Powers, Opening::Outermost].map(|opening| fraction_with(pool, e, opening));
    all.into_iter().min_by_key(|own| pool.cost(&[*own])).unwrap_or(e)
}

/// By base: the largest power below a fraction bar.
pub(super) fn below_bars<'a>(factors: impl Iterator<Item = &'a (ExprId, Number)>) -> BTreeMap<ExprId, Number> {
    let mut below: BTreeMap<ExprId, Number> = BTreeMap::new();
    for (base, exponent) in factors.filter(|(_, exponent)| exponent.is_negative()) {
        let power = below.entry(*base).or_insert(Number::ZERO);
        *power = exponent.neg().max(std::mem::take(power));
    }
    below
}

fn fraction_with(pool: &mut Algebra<'_>, e: ExprId, opening: Opening) -> ExprId {
    let Some(monomials) = expand(pool, e, opening) else { return e };
    let below = below_bars(monomials.keys().flatten());
    if below.is_empty() {
        return e;
    }
    let terms = monomials.into_iter().map(|(mut monomial, coefficient)| {
        monomial.extend(below.iter().map(|(base, power)| (*base, power.clone())));
        (monomial, coefficient)
    });
    let above = pool.short(|pool| written(pool, terms));
    // What all terms have in common stands in front, even where that is no shorter.
    let mut factors = vec![(with_common_factor(pool, above), Number::ONE)];
    factors.extend(below.into_iter().map(|(base, power)| (base, power.neg())));
    pool.product_of_powers(&factors)
}
