//! Chains, rings and nets of any size, whose frequencies are sines.
//!
//! Let T be the matrix with 1 beside the diagonal, 0 on it and a corner c = 0, 1 or -1 at each end. Its
//! eigenvalues are 2 cos(theta), all different, with the angles of the table below (W.-C. Yueh, Applied
//! Mathematics E-Notes 5 (2005) 66; G. Strang, SIAM Review 41 (1999) 135 for the vectors). What commutes with T has
//! the same vectors v, with v_1 not 0, so that its eigenvalue is the first row times v/v_1; and by T v =
//! 2 cos(theta) v the components v_i/v_1 are polynomials in x = 2 cos(theta): 1, x - c, then x times the last one
//! minus the one before.
//!
//! What commutes with the turn of a ring by one place has the waves exp(i j theta) for vectors, and as
//! it is symmetric the eigenvalue is the first row times cos(j theta).
//!
//! The corner stands for what is at the end: 0 a wall, 1 a free end, -1 a wall half a distance off.

use std::collections::BTreeMap;

use super::pair::Pair;
use super::simplify::Algebra;
use crate::expr::{ExprId, Pool, Substitution, Symbol};
use crate::number::Number;
use crate::order::Gather;

/// Entries at a larger distance than this make no shorter formula.
const MOST_DISTANCE: usize = 4;

/// What is at the ends of one dimension.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Ends {
    /// The two corners.
    Corners(i8, i8),
    /// The ends are joined.
    Joined,
}

/// The angles of one dimension: theta/2 = (step j + offset) pi/divisor, j from `first` to `last`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Angles {
    /// What j is multiplied with.
    pub step: i64,
    /// What is added.
    pub offset: i64,
    /// What pi is divided by.
    pub divisor: i64,
    /// The first j.
    pub first: i64,
    /// The last j.
    pub last: i64,
    /// Whether the angles belong to a ring: j and `ring` - j are the same frequency.
    pub ring: Option<i64>,
}

/// One dimension of a chain, ring or net.
#[derive(Clone, Copy, Debug)]
pub(super) struct Dimension {
    pub(super) ends: Ends,
    pub(super) size: usize,
}

impl Dimension {
    pub(super) fn angles(&self) -> Angles {
        let n = i64::try_from(self.size).unwrap_or(i64::MAX / 8);
        let (step, offset, divisor, first, last, ring) = match self.ends {
            Ends::Joined => (1, 0, n, 0, n - 1, Some(n)),
            Ends::Corners(0, 0) => (1, 0, 2 * (n + 1), 1, n, None),
            Ends::Corners(1, 1) => (1, 0, 2 * n, 0, n - 1, None),
            Ends::Corners(-1, -1) => (1, 0, 2 * n, 1, n, None),
            Ends::Corners(1, 0) | Ends::Corners(0, 1) => (2, 1, 2 * (2 * n + 1), 0, n - 1, None),
            Ends::Corners(-1, 0) | Ends::Corners(0, -1) => (1, 0, 2 * n + 1, 1, n, None),
            Ends::Corners(..) => (2, 1, 4 * n, 0, n - 1, None),
        };
        Angles { step, offset, divisor, first, last, ring }
    }

    /// The columns of row i of T that are not 0, but for corners; on a ring of a turn by one place.
    fn row(&self, i: usize) -> Vec<(usize, i64)> {
        let Ends::Corners(left, right) = self.ends else { return vec![((i + 1) % self.size, 1)] };
        let before = i.checked_sub(1).map_or((i, i64::from(left)), |before| (before, 1));
        let behind = if i + 1 < self.size { (i + 1, 1) } else { (i, i64::from(right)) };
        vec![before, behind]
    }
}

/// A chain, ring or net with the frequencies as a function of s = sin(theta/2)^2 in each dimension.
pub(super) struct Lattice {
    pub(super) dimensions: Vec<Dimension>,
    /// The symbol that stands for s in each dimension.
    pub(super) squares: Vec<Symbol>,
    pub(super) omega_squared: ExprId,
    /// The eigenvalue of M.
    pub(super) mass: ExprId,
    /// The coordinates along the chain.
    pub(super) order: Vec<usize>,
}

/// The corners that are tried, one after another.
const CORNERS: [(i8, i8); 9] = [(0, 0), (1, 1), (1, 0), (0, 1), (-1, -1), (-1, 0), (0, -1), (1, -1), (-1, 1)];

/// The lattice that a connected pair of matrices is, if it is one.
pub(super) fn lattice(pool: &mut Algebra<'_>, pair: &Pair) -> Option<Lattice> {
    let n = pair.len();
    if n < 3 {
        return None;
    }
    let order = path(pair).unwrap_or_else(|| (0..n).collect());
    let ordered = pair.restricted(&order);
    if let Some(ends) = ends(pool, &ordered, n, 1) {
        let dimension = Dimension { ends, size: n };
        return formula(pool, &ordered, order, vec![dimension]);
    }
    for rows in (2..=n / 2).filter(|rows| n.is_multiple_of(*rows)) {
        let columns = n / rows;
        // The last index is the fastest.
        let Some(inner) = ends(pool, pair, columns, 1) else { continue };
        if let Some(outer) = ends(pool, pair, rows, columns) {
            let outer = Dimension { ends: outer, size: rows };
            let inner = Dimension { ends: inner, size: columns };
            return formula(pool, pair, (0..n).collect(), vec![outer, inner]);
        }
    }
    None
}

/// The coordinates along a path, or around a ring, if each has at most two neighbours.
fn path(pair: &Pair) -> Option<Vec<usize>> {
    let n = pair.len();
    let neighbours = (0..n).map(|i| pair.columns(i).into_iter().filter(|j| *j != i).collect());
    let neighbours: Vec<Vec<usize>> = neighbours.collect();
    if neighbours.iter().any(|own| own.is_empty() || own.len() > 2) {
        return None;
    }
    let start = neighbours.iter().position(|own| own.len() == 1).unwrap_or(0);
    let mut order = vec![start];
    let mut seen = vec![false; n];
    seen[start] = true;
    while let Some(next) = order.last().and_then(|at| neighbours[*at].iter().find(|j| !seen[**j])) {
        seen[*next] = true;
        order.push(*next);
    }
    (order.len() == n).then_some(order)
}

/// The ends with which a dimension of T, of two places at least, among indices `stride` apart, commutes with M and K.
fn ends(pool: &mut Pool, pair: &Pair, size: usize, stride: usize) -> Option<Ends> {
    let corners = CORNERS.map(|(left, right)| Ends::Corners(left, right));
    (size > 2).then_some(Ends::Joined).into_iter().chain(corners).find(|ends| {
        let dimension = Dimension { ends: *ends, size };
        commutes(pool, &pair.mass, dimension, stride) && commutes(pool, &pair.stiffness, dimension, stride)
    })
}

/// Whether AT = TA, entry by entry.
fn commutes(pool: &mut Pool, matrix: &[BTreeMap<usize, ExprId>], dimension: Dimension, stride: usize) -> bool {
    let size = dimension.size;
    let t_row = |i: usize| {
        let place = i / stride % size;
        let base = i - place * stride;
        dimension.row(place).into_iter().map(move |(j, value)| (base + j * stride, value))
    };
    (0..matrix.len()).all(|i| {
        let mut row: BTreeMap<usize, BTreeMap<ExprId, i64>> = BTreeMap::new();
        // Row i of AT: A_ik T_kj, T being symmetric.
        for (k, value) in &matrix[i] {
            for (j, factor) in t_row(*k) {
                *row.entry(j).or_default().entry(*value).or_default() += factor;
            }
        }
        // Minus row i of TA: T_ik A_kj.
        for (k, factor) in t_row(i) {
            for (j, value) in &matrix[k] {
                *row.entry(*j).or_default().entry(*value).or_default() -= factor;
            }
        }
        row.into_values().all(|parts| {
            let parts = parts.into_iter().filter(|(_, c)| *c != 0).map(|(e, c)| (e, Number::from(c)));
            let sum = pool.linear(&parts.collect::<Vec<_>>());
            pool.vanishes(sum)
        })
    })
}

/// v_i/v_1 as polynomials in s = sin(theta/2)^2, x = 2 - 4 s, for the first few i; on a ring for
/// the distance i.
pub(super) fn components(pool: &mut Pool, ends: Ends, square: ExprId, count: usize) -> Vec<ExprId> {
    let two = pool.integer(2);
    let x = pool.linear(&[(two, Number::ONE), (square, Number::from(-4))]);
    let one = pool.one();
    let second = match ends {
        Ends::Joined => pool.scale(x, &Number::half()),
        Ends::Corners(left, _) => {
            let corner = pool.integer(i64::from(left));
            pool.sub(x, corner)
        }
    };
    let mut values = vec![one, second];
    while values.len() < count {
        let (a, b) = (values[values.len() - 2], values[values.len() - 1]);
        let product = pool.mul(x, b);
        values.push(pool.sub(product, a));
    }
    values
}

fn formula(pool: &mut Algebra<'_>, pair: &Pair, order: Vec<usize>, dimensions: Vec<Dimension>) -> Option<Lattice> {
    let squares: Vec<Symbol> = (0..dimensions.len()).map(|_| pool.fresh_symbol("s")).collect();
    let mut factors = Vec::new();
    for (dimension, square) in dimensions.iter().zip(&squares) {
        let square = pool.symbol_expr(*square);
        factors.push(components(pool, dimension.ends, square, MOST_DISTANCE + 1));
    }
    if dimensions.len() > 1 && !turns_both_ways(pair, &dimensions) {
        return None;
    }
    let mut eigenvalue = |row: &BTreeMap<usize, ExprId>| {
        let mut parts = Vec::new();
        for (at, value) in row {
            let mut product = vec![*value];
            let mut rest = *at;
            for (dimension, factors) in dimensions.iter().zip(&factors).rev() {
                let mut place = rest % dimension.size;
                rest /= dimension.size;
                if dimension.ends == Ends::Joined {
                    place = place.min(dimension.size - place);
                }
                product.push(*factors.get(place)?);
            }
            parts.push(pool.product(&product));
        }
        Some(pool.short(|pool| pool.sum(&parts)))
    };
    let stiffness = eigenvalue(pair.stiffness.first()?)?;
    let mass = eigenvalue(pair.mass.first()?)?;
    if mass.is_zero() {
        return None;
    }
    let quotient = pool.div(stiffness, mass);
    Some(Lattice { dimensions, squares, omega_squared: pool.simplify(quotient), mass, order })
}

/// Whether the first rows are the same when a ring among several dimensions is run through the other
/// way: only then the waves in each dimension may be taken as cosines.
fn turns_both_ways(pair: &Pair, dimensions: &[Dimension]) -> bool {
    let first_rows = [pair.mass.first(), pair.stiffness.first()];
    let mut stride = 1;
    for dimension in dimensions.iter().rev() {
        let size = dimension.size;
        let mirrored = |at: usize| {
            let place = at / stride % size;
            at - place * stride + (size - place) % size * stride
        };
        if dimension.ends == Ends::Joined
            && !first_rows.iter().flatten().all(|row| {
                let mut entries = row.iter();
                entries.all(|(at, value)| row.get(&mirrored(*at)) == Some(value))
            })
        {
            return false;
        }
        stride *= size;
    }
    true
}

impl Angles {
    /// The angle theta/2 of j.
    pub(super) fn angle(&self, pool: &mut Pool, j: i64) -> ExprId {
        let turns = Number::ratio(self.step * j + self.offset, self.divisor);
        pool.scale(pool.pi(), &turns.unwrap_or_default())
    }

    /// The same for a symbol j.
    pub(super) fn general(&self, pool: &mut Pool, j: ExprId) -> ExprId {
        let offset = pool.integer(self.offset);
        let numerator = pool.linear(&[(j, Number::from(self.step)), (offset, Number::ONE)]);
        let product = pool.mul(pool.pi(), numerator);
        let inverse = Number::ratio(1, self.divisor).unwrap_or_default();
        pool.scale(product, &inverse)
    }
}

impl Lattice {
    /// An expression where the angles theta/2 of the dimensions are these.
    pub(super) fn at(&self, pool: &mut Pool, e: ExprId, angles: &[ExprId]) -> ExprId {
        let squares = angles.iter().map(|angle| {
            let sine = pool.sin(*angle);
            pool.square(sine)
        });
        let map: Substitution = self.squares.iter().copied().zip(squares).gather();
        pool.substitute_one(e, &map)
    }
}
