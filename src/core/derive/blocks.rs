//! M and K in coordinates of one symmetry each, where they fall apart into blocks.

use std::collections::BTreeMap;

use super::lattice::{Ends, components};
use super::pair::{Pair, Sparse};
use super::roots::of_polynomial;
use super::simplify::Algebra;
use crate::expr::{ExprId, Pool, Substitution, Symbol};
use crate::number::Number;
use crate::symmetry::{GroupKind, SignedPermutation, Symmetry};

/// Twice as many classes for each mirror.
const MOST_MIRRORS: usize = 8;

/// Elements of a group that are looked through for mirrors.
const MOST_ELEMENTS: usize = 200;

/// Vectors of one symmetry under mirrors that commute, and the class they make.
#[derive(Clone, Debug)]
pub(super) struct Adapted {
    /// Under which mirrors they are odd.
    pub(super) odd: Vec<bool>,
    /// The vectors, with whole components.
    pub(super) basis: Vec<Sparse>,
}

/// Mirrors that commute: all of the group where it is made of them, else some of it.
pub(super) fn commuting_mirrors(symmetry: &Symmetry) -> Vec<SignedPermutation> {
    if let GroupKind::Mirrors(mirrors) = &symmetry.kind
        && mirrors.len() <= MOST_MIRRORS
    {
        return mirrors.clone();
    }
    let mut chosen: Vec<SignedPermutation> = Vec::new();
    let generators = symmetry.generators.iter().cloned();
    for g in generators.chain(SignedPermutation::group(&symmetry.generators, MOST_ELEMENTS)) {
        let undoes_itself = g.after(&g).is_identity() && !g.moves_nothing();
        let commutes = chosen.iter().all(|h| g.after(h) == h.after(&g));
        // What products of the others do already tells nothing new.
        let is_new = || !SignedPermutation::group(&chosen, 1 << MOST_MIRRORS).contains(&g);
        if undoes_itself && commutes && chosen.len() < MOST_MIRRORS && is_new() {
            chosen.push(g);
        }
    }
    chosen
}

/// Vectors of each symmetry, on some coordinates that the mirrors keep together.
///
/// For a class with the signs c the vectors are the products of (1 + c P) over the mirrors P, applied
/// to one coordinate of each set that the mirrors take to each other.
pub(super) fn adapted(mirrors: &[SignedPermutation], coordinates: &[usize]) -> Vec<Adapted> {
    let mut classes = Vec::new();
    for signs in 0_u32..1 << mirrors.len() {
        let odd = |at: usize| signs & (1 << at) != 0;
        let mut seen: Vec<usize> = Vec::new();
        let mut basis = Vec::new();
        for start in coordinates {
            if seen.contains(start) {
                continue;
            }
            let mut vector: BTreeMap<usize, i64> = BTreeMap::from([(*start, 1)]);
            let mut orbit = vec![*start];
            for (at, mirror) in mirrors.iter().enumerate() {
                let images = vector.clone().into_iter().map(|(i, value)| {
                    let (to, negative) = mirror.of(i);
                    (to, if negative != odd(at) { -value } else { value })
                });
                for (to, value) in images {
                    *vector.entry(to).or_default() += value;
                }
                let images: Vec<usize> = orbit.iter().map(|i| mirror.of(*i).0).collect();
                orbit.extend(images);
            }
            seen.extend(orbit);
            vector.retain(|_, value| *value != 0);
            if !vector.is_empty() {
                // Of one size: each coordinate is reached by as many products of mirrors.
                basis.push(vector.into_iter().map(|(i, value)| (i, value.signum())).collect());
            }
        }
        if !basis.is_empty() {
            classes.push(Adapted { odd: (0..mirrors.len()).map(odd).collect(), basis });
        }
    }
    classes
}

/// The frequencies of a ring with one or two coordinates a cell, for each wave number.
#[derive(Clone, Debug)]
pub(super) struct Waves {
    /// The symbol of s = sin(pi j/N)^2.
    pub(super) square: Symbol,
    /// The branches.
    pub(super) omega_squared: Vec<ExprId>,
    /// The polynomial in z whose zeros they are.
    coefficients: Vec<ExprId>,
}

/// The branches of a ring, on some coordinates that the turn keeps together; `None` for more than two
/// coordinates a cell.
///
/// With the waves exp(i r theta) over the cells M and K become Hermitian, as small as a cell, with
/// entries A_ab = sum over r of A(a_0, b_r) exp(i r theta). For two coordinates
/// det(K - z M) has |K_ab|^2, |M_ab|^2 and Re(conj(M_ab) K_ab), which are sums of products with cosines
/// of the differences of the places.
pub(super) fn waves(pool: &mut Algebra<'_>, pair: &Pair, symmetry: &Symmetry, coordinates: &[usize]) -> Option<Waves> {
    let GroupKind::Ring { turn, length } = &symmetry.kind else { return None };
    let mut cells: Vec<Vec<usize>> = Vec::new();
    let mut seen: Vec<usize> = Vec::new();
    for start in coordinates {
        if seen.contains(start) {
            continue;
        }
        let cycle: Vec<usize> = std::iter::successors(Some(*start), |i| Some(turn.of(*i).0)).take(*length).collect();
        seen.extend(&cycle);
        cells.push(cycle);
    }
    let square = pool.fresh_symbol("s");
    let ring = RingSums { square: pool.symbol_expr(square), length: *length };
    let row = |of: &[BTreeMap<usize, ExprId>], a: &[usize], b: &[usize]| -> Vec<(usize, ExprId)> {
        let first = a.first().and_then(|i| of.get(*i));
        b.iter().enumerate().filter_map(|(r, j)| Some((r, *first?.get(j)?))).collect()
    };
    let (m, k) = (&pair.mass, &pair.stiffness);
    let mut coefficients = match cells.as_slice() {
        [a] => {
            let stiffness = ring.real(pool, &row(k, a, a))?;
            let mass = ring.real(pool, &row(m, a, a))?;
            vec![pool.neg(stiffness), mass]
        }
        [a, b] => {
            let (m11, k11) = (ring.real(pool, &row(m, a, a))?, ring.real(pool, &row(k, a, a))?);
            let (m22, k22) = (ring.real(pool, &row(m, b, b))?, ring.real(pool, &row(k, b, b))?);
            let (m12, k12) = (row(m, a, b), row(k, a, b));
            let mm = ring.correlation(pool, &m12, &m12)?;
            let mk = ring.correlation(pool, &m12, &k12)?;
            let kk = ring.correlation(pool, &k12, &k12)?;
            let second = pool.mul(m11, m22);
            let second = pool.sub(second, mm);
            let (left, right) = (pool.mul(m11, k22), pool.mul(m22, k11));
            let first = pool.linear(&[(left, Number::MINUS_ONE), (right, Number::MINUS_ONE), (mk, Number::from(2))]);
            let last = pool.mul(k11, k22);
            let last = pool.sub(last, kk);
            vec![last, first, second]
        }
        _ => return None,
    };
    pool.shorten(coefficients.iter_mut());
    let omega_squared = of_polynomial(pool, &coefficients)?;
    if omega_squared.iter().any(|value| pool.is_undefined(*value)) {
        return None;
    }
    Some(Waves { square, omega_squared, coefficients })
}

struct RingSums {
    square: ExprId,
    length: usize,
}

/// Formulas reach no further around a ring.
const MOST_DISTANCE: usize = 6;

impl RingSums {
    /// cos(r theta) as a polynomial in s, with cos(theta) = 1 - 2 s.
    fn cosine(&self, pool: &mut Pool, distance: usize) -> Option<ExprId> {
        let distance = distance.min(self.length - distance);
        let near = distance <= MOST_DISTANCE;
        near.then(|| components(pool, Ends::Joined, self.square, distance + 1))
            .and_then(|all| all.get(distance).copied())
    }

    /// The sum of value times cos(r theta).
    fn real(&self, pool: &mut Pool, row: &[(usize, ExprId)]) -> Option<ExprId> {
        let mut parts = Vec::new();
        for (r, value) in row {
            let cosine = self.cosine(pool, *r)?;
            parts.push(pool.mul(*value, cosine));
        }
        Some(pool.sum(&parts))
    }

    /// The real part of conj(A) B for sums A and B of value times exp(i r theta).
    fn correlation(&self, pool: &mut Pool, left: &[(usize, ExprId)], right: &[(usize, ExprId)]) -> Option<ExprId> {
        let mut parts = Vec::new();
        for (r, a) in left {
            for (s, b) in right {
                let cosine = self.cosine(pool, r.abs_diff(*s))?;
                parts.push(pool.product(&[*a, *b, cosine]));
            }
        }
        Some(pool.sum(&parts))
    }
}

impl Waves {
    /// The branches where theta/2 is this symbol's angle.
    pub(super) fn general(&self, pool: &mut Pool, angle: ExprId) -> Vec<ExprId> {
        let map = self.with(pool, angle);
        pool.substitute(&self.omega_squared, &map)
    }

    /// The branches at an angle theta/2, where roots may be drawn that can't be in general.
    pub(super) fn at(&self, pool: &mut Algebra<'_>, angle: ExprId) -> Vec<ExprId> {
        let map = self.with(pool, angle);
        let mut coefficients = pool.substitute(&self.coefficients, &map);
        pool.shorten(coefficients.iter_mut());
        of_polynomial(pool, &coefficients).unwrap_or_default()
    }

    fn with(&self, pool: &mut Pool, angle: ExprId) -> Substitution {
        let sine = pool.sin(angle);
        Substitution::from([(self.square, pool.square(sine))])
    }
}

/// Whether nothing stiff is in a pair.
pub(super) fn is_free(pair: &Pair) -> bool {
    pair.stiffness.iter().flat_map(BTreeMap::values).all(|value| value.is_zero())
}
