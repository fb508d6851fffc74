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
    let cells = cycles(turn, *length, coordinates);
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

/// The coordinates that a turn takes to each other, one after the other.
fn cycles(turn: &SignedPermutation, length: usize, coordinates: &[usize]) -> Vec<Vec<usize>> {
    let mut cycles: Vec<Vec<usize>> = Vec::new();
    for start in coordinates {
        if !cycles.iter().flatten().any(|known| known == start) {
            cycles.push(std::iter::successors(Some(*start), |i| Some(turn.of(*i).0)).take(length).collect());
        }
    }
    cycles
}

/// Vectors of each wave number j of a ring of n cells, cos(2π j r/n) and then, unless they are all 0, as many sin(2π j r/n), up to a
/// factor, where that makes them whole: where n is 1, 2, 3, 4 or 6 times what it has in common with j. And whether there are sines.
pub(super) fn whole_waves(turn: &SignedPermutation, length: usize, coordinates: &[usize]) -> Vec<(Vec<Sparse>, bool)> {
    let cycles = cycles(turn, length, coordinates);
    let waves = (0..=length / 2).filter_map(|j| {
        let common = (1..=length).rev().find(|d| length.is_multiple_of(*d) && j.is_multiple_of(*d))?;
        // Twice the cosine of the angle.
        let step = match length / common {
            1 => 2,
            2 => -2,
            3 => -1,
            4 => 0,
            6 => 1,
            _ => return None,
        };
        let wave = |first: i64, second: i64, cycle: &Vec<usize>| -> Sparse {
            let values = std::iter::successors(Some((first, second)), |(a, b)| Some((*b, step * b - a)));
            cycle.iter().zip(values).map(|(i, (value, _))| (*i, value)).filter(|(_, value)| *value != 0).collect()
        };
        let (cosines, sines) = (cycles.iter().map(|own| wave(2, step, own)), cycles.iter().map(|own| wave(0, 1, own)));
        Some(if step.abs() == 2 { (cosines.collect(), false) } else { (cosines.chain(sines).collect(), true) })
    });
    waves.collect()
}

/// Columns along the way from an axis to each body and across it, where that turns coordinates in a plane by angles with rational
/// squares of their cosines; `None` where bodies are on the axis.
pub(super) fn around_an_axis(
    pool: &mut Algebra<'_>,
    axes: &[Vec<usize>],
    equilibrium: &[ExprId],
    values: &[f64],
) -> Option<Vec<Vec<(usize, ExprId)>>> {
    let planes = [[0, 1], [1, 2], [2, 0]].into_iter().take(if axes.len() == 2 { 1 } else { 3 });
    let turned = |pool: &mut Algebra<'_>, [k, l]: [usize; 2]| {
        let mut columns: Vec<Vec<(usize, ExprId)>> = (0..equilibrium.len()).map(|i| vec![(i, pool.one())]).collect();
        for (i, j) in axes.get(k)?.iter().zip(axes.get(l)?) {
            let [x, y] = [*i, *j].map(|at| pool.square(equilibrium[at]));
            let whole = pool.add(x, y);
            let mut part = |square: ExprId, sign: f64| {
                let share = pool.short(|pool| pool.div(square, whole));
                let share = pool.as_number(share)?.clone();
                let root = pool.number(share);
                let root = pool.powr(root, &Number::half());
                Some(if sign < 0.0 { pool.neg(root) } else { root })
            };
            let (c, s) = (part(x, values[*i])?, part(y, values[*j])?);
            columns[*i] = vec![(*i, c), (*j, s)];
            columns[*j] = vec![(*i, pool.neg(s)), (*j, c)];
        }
        Some(columns)
    };
    planes.into_iter().find_map(|plane| turned(pool, plane))
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
