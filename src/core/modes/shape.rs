//! Mode shapes from certified columns: normalisation, a reproducible basis in clusters, signs, and
//! a bound of the error of every component.

use super::certify::Cluster;
use super::dense::{Matrix, Plain};
use super::pencil::{Orthonormal, Scaled, ZeroSpace};
use super::product::{Part, bound_product, product, product_bound};
use super::start::{factor, forward};
use super::{Certificate, Solution, Source};
use crate::precision::{Ball, DoubleDouble, U2, clear_column, sum_of_products, up};

/// A component this near the largest one decides the sign of a vector.
const NEARLY_LARGEST: f64 = 1.0 - 1e-6;
/// A component that small beside the largest one is no pivot of an echelon basis.
const NO_PIVOT: f64 = 1e-3;

/// A vector in the original coordinates and the bound of its components.
pub(super) struct Shape {
    pub(super) vector: Vec<f64>,
    pub(super) error_bound: f64,
}

/// How far the exact eigenvectors are from the columns of X, per cluster.
pub(super) struct Errors {
    /// Component by component, in scaled coordinates, n by number of clusters.
    components: Plain,
    /// Σ |z| over the zero vectors, by row.
    zero: Vec<f64>,
    /// In M-length.
    length: Vec<f64>,
    /// Along the zero vectors.
    along: Vec<f64>,
}

impl Errors {
    /// For a single eigenvalue the exact eigenvector is x'_k + Σ x'_i y_i with |y_i| <= τ_i
    /// ([`Cluster::reach`]), where x' is x without its part along the zero vectors.
    ///
    /// For a cluster of c columns, take a vector y = Y a of its exact eigenspace with unit component
    /// e_k in the cluster, the columns of Y being G-orthonormal eigenvectors. As G >= 1/2
    /// (certified), a G-normalised vector is at most √2 in length, so |y_i| <= τ_i √2 √c ‖a‖ and
    /// ‖a‖ = ‖y‖_G <= √g_kk + √2 √c ‖a‖ t with t = Σ τ_i √g_ii. For √(2c) t <= 1/4 and g_kk <= 3/2 that
    /// gives ‖a‖ <= 1.64 and |y_i| <= 2.4 √c τ_i. Such a y exists for every k, because no eigenvector
    /// combination vanishes on the cluster.
    pub(super) fn new(leak: &[f64], certificate: &Certificate, x: &Matrix, zero: &ZeroSpace) -> Self {
        let m = x.columns;
        let clusters = &certificate.clusters;
        let mut reach = Plain::zeros(m, clusters.len());
        let mut length = Vec::with_capacity(clusters.len());
        let mut along = Vec::with_capacity(clusters.len());
        for (index, cluster) in clusters.iter().enumerate() {
            let c = cluster.len() as f64;
            // √g_ii <= 1.23, as g_ii <= 3/2 is certified.
            let total = 1.23 * 1.000_001 * cluster.total;
            let factor = if cluster.len() == 1 {
                1.0
            } else if (2.0 * c).sqrt() * total <= 0.25 {
                2.4 * c.sqrt()
            } else {
                f64::INFINITY
            };
            let scaled = |tau: &f64| if *tau == 0.0 { 0.0 } else { up(factor * tau) };
            reach.column_mut(index).iter_mut().zip(&cluster.reach).for_each(|(to, tau)| *to = scaled(tau));
            length.push(if total == 0.0 { 0.0 } else { up(factor * total) });
            let others: f64 = match zero.mid.columns {
                0 => 0.0,
                _ => leak.iter().zip(&cluster.reach).map(|(l, t)| l * t).sum(),
            };
            let own = certificate.order[cluster.start..cluster.end].iter().fold(0.0_f64, |most, &i| most.max(leak[i]));
            let others = if others == 0.0 { 0.0 } else { factor * others };
            // 1/√(1 - f) <= √2 for the defect f <= 1/2 of the zero space.
            along.push(1.42 * (own + others) * (1.0 + 1e-9));
        }
        let components = bound_product(&x.magnitudes(), &reach);
        let zero = (0..x.rows).map(|row| zero.mid.hi.row(row).map(|z| z.abs()).sum()).collect();
        Self { components, zero, length, along }
    }

    /// The bound of a component of a vector of the cluster, in scaled coordinates.
    fn component(&self, row: usize, index: usize) -> f64 {
        let z = self.zero[row];
        // bound_product adds 1e-300 for underflow; a column that reaches nowhere is exact.
        let own = if self.length[index] == 0.0 { 0.0 } else { self.components.get(row, index) };
        if own == 0.0 && self.along[index] == 0.0 { 0.0 } else { up(own + self.along[index] * z) }
    }
}

/// The vectors of one cluster, M-orthonormal, in the original coordinates.
pub(super) fn cluster_shapes(
    problem: &Scaled,
    solution: &Solution,
    columns: &[usize],
    errors: &Errors,
    index: usize,
) -> Vec<Shape> {
    let x = &solution.x;
    if let [k] = *columns {
        let g = solution.gram.diagonal(k);
        let norm = g.mid.sqrt();
        let inverse = DoubleDouble::ONE / norm;
        // The exact vector has M-length norm (1 ± η), the roundings of root, quotient and product
        // included: 4, 16 and 8 u².
        let eta = up(errors.length[index] / norm.hi + g.radius / g.mid.hi + 32.0 * U2);
        // Of 1/√g and of 1/(1 - η), rounded up.
        let scale = up(1.0 / norm.hi);
        let rest = if eta < 0.5 { up(1.0 / (1.0 - eta)) } else { f64::INFINITY };
        let component = |row: usize| {
            let value = x.get(row, k) * inverse;
            (value, up((errors.component(row, index) * scale + value.hi.abs() * eta) * rest))
        };
        return vec![unscaled(problem, (0..problem.n).map(component))];
    }
    // An echelon basis does not depend on the basis that the solver happened to find.
    let basis = x.gather(columns);
    let gram = solution.gram.block(columns);
    let transform = echelon(&basis, &gram);
    let vectors = product(&basis, &transform, Part::All);
    let shape = |q: usize| {
        let weight: f64 = transform.hi.column(q).iter().map(|t| t.abs()).sum();
        let component = |row: usize| {
            // The product of basis and transform is rounded, too.
            let terms = transform.hi.column(q).iter().enumerate();
            let size: f64 = terms.map(|(p, t)| (basis.get(row, p).hi * t).abs()).sum();
            let rounding = product_bound(columns.len()) * size;
            let error = errors.component(row, index) * weight + rounding;
            (vectors.get(row, q), error * (1.0 + 1e-9))
        };
        unscaled(problem, (0..problem.n).map(component))
    };
    (0..columns.len()).map(shape).collect()
}

/// The entries of the unit matrix.
pub(super) fn unit(i: usize, j: usize) -> DoubleDouble {
    if i == j { DoubleDouble::ONE } else { DoubleDouble::ZERO }
}

/// The zero vectors, M-orthonormal, in the original coordinates: an echelon basis of each of the spaces that their source tells apart.
pub(super) fn zero_shapes(problem: &Scaled, zero: &ZeroSpace, source: &dyn Source) -> Vec<Shape> {
    let z = zero.vectors.len();
    let own = |v: &Vec<Ball>| v.iter().zip(&problem.shift).map(|(x, shift)| x.scale(*shift).mid_f64()).collect();
    let vectors: Vec<Vec<f64>> = zero.vectors.iter().map(own).collect();
    let spaces = source.zero_spaces(&vectors);
    let spaces = spaces.unwrap_or_else(|| vec![(0..z).map(|q| (0..z).map(|p| unit(p, q).hi).collect()).collect()]);
    spaces.iter().filter(|own| !own.is_empty()).flat_map(|own| shapes_in_space(problem, zero, own)).collect()
}

/// An echelon basis of the space that combinations of the zero vectors span.
fn shapes_in_space(problem: &Scaled, zero: &ZeroSpace, space: &[Vec<f64>]) -> Vec<Shape> {
    let own = Matrix::from_fn(zero.vectors.len(), space.len(), |p, q| DoubleDouble::exact(space[q][p]));
    let gram = product(&own.transposed(), &own, Part::All);
    let transform = echelon(&product(&zero.mid, &own, Part::All), &gram);
    let transform = product(&own, &transform, Part::All);
    let shape = |q: usize| {
        let sum = |row: usize| {
            let parts = zero.vectors.iter().enumerate();
            parts.fold(Ball::ZERO, |sum, (p, v)| sum + v[row] * Ball::from(transform.get(p, q)))
        };
        let combined: Vec<Ball> = (0..problem.n).map(sum).collect();
        // |1/√(1 + e) - 1| <= |e| for |e| <= 1/2: how far the length is from 1.
        let defect = (problem.mass.form(&combined) - Ball::ONE).abs_upper();
        let defect = if defect <= 0.5 { defect } else { f64::INFINITY };
        let component = |value: &Ball| {
            let size = value.abs_upper();
            (value.mid, if size == 0.0 { 0.0 } else { up(value.radius + size * defect) * 2.0 })
        };
        unscaled(problem, combined.iter().map(component))
    };
    (0..space.len()).map(shape).collect()
}

/// A vector from its components and what each may be off by, back in the original coordinates and rounded to doubles.
fn unscaled(problem: &Scaled, components: impl Iterator<Item = (DoubleDouble, f64)>) -> Shape {
    let (mut vector, mut bound) = (Vec::with_capacity(problem.n), 0.0_f64);
    for ((value, error), &shift) in components.zip(&problem.shift) {
        let (value, error) =
            if shift == 0 { (value, error) } else { (value.scale(shift), DoubleDouble::exact(error).scale(shift).hi) };
        vector.push(value.hi);
        let error = if error == 0.0 && value.lo == 0.0 { 0.0 } else { up(error + value.lo.abs()) };
        bound = bound.max(if error.is_nan() { f64::INFINITY } else { error });
    }
    finish(vector, bound)
}

/// A vector with that sign.
pub(crate) fn signed(vector: Vec<f64>) -> Vec<f64> {
    finish(vector, 0.0).vector
}

/// A vector of doubles in its final form, with a bound of its error.
pub(super) fn finish(mut vector: Vec<f64>, error_bound: f64) -> Shape {
    orient(&mut vector);
    Shape { vector, error_bound }
}

/// The first of so many components whose size is within 1e-6 of the largest, and that; `None` without components.
pub(crate) fn leading(count: usize, size: impl Fn(usize) -> f64) -> Option<(usize, f64)> {
    let largest = (0..count).map(&size).fold(0.0, f64::max);
    Some(((0..count).find(|at| size(*at) >= NEARLY_LARGEST * largest)?, largest))
}

/// The sign of a vector: the first component within 1e-6 of the largest is positive.
pub fn orient(vector: &mut [f64]) {
    let mut largest = [0.0_f64; 4];
    let (lanes, rest) = vector.as_chunks::<4>();
    for x in lanes {
        for (most, x) in largest.iter_mut().zip(x) {
            *most = if x.abs() > *most { x.abs() } else { *most };
        }
    }
    let all = largest.iter().chain(rest);
    let largest = all.fold(0.0_f64, |most, x| most.max(x.abs()));
    let first = vector.iter().find(|x| x.abs() >= NEARLY_LARGEST * largest);
    let sign = if first.is_some_and(|x| *x < 0.0) { -1.0 } else { 1.0 };
    // No negative zeros.
    vector.iter_mut().for_each(|x| *x = *x * sign + 0.0);
}

/// The c by c transform T for which U T is the echelon basis of the columns of U (n by c),
/// orthonormalised in its order: U_P T₀ = 1 for the first rows P that carry pivots, and
/// T = T₀ L⁻ᵀ with T₀ᵀ G T₀ = L Lᵀ. (Scaled coordinates do as well as the original ones: the lengths
/// of the echelon basis vectors do not matter in the end.)
pub(super) fn echelon(basis: &Matrix, gram: &Matrix) -> Matrix {
    let c = basis.columns;
    let pivots = pivot_rows(basis);
    let row = |(p, &row): (usize, &usize)| {
        let own = (0..c).map(|q| basis.get(row, q));
        own.chain((0..c).map(|q| unit(p, q))).collect()
    };
    let inverse = invert(pivots.iter().enumerate().map(row).collect());
    let mut transform = inverse.clone();
    if by_cholesky(&mut transform, gram) > WELL_CONDITIONED {
        return transform;
    }
    // Where pivots of many columns get small one after the other, the square of their condition is beyond double-double.
    one_by_one(&inverse, gram).unwrap_or(transform)
}

/// Pivots of a Cholesky factor that differ by less leave twenty digits of double-double.
const WELL_CONDITIONED: f64 = 1e-6;

/// Gram-Schmidt on the columns of T, one by one and each twice, which leaves them orthonormal to rounding (L. Giraud, J. Langou,
/// M. Rozložník, J. van den Eshof, Numer. Math. 101 (2005) 87).
fn one_by_one(transform: &Matrix, gram: &Matrix) -> Option<Matrix> {
    let c = transform.columns;
    let rows: Vec<Vec<Ball>> = (0..c).map(|i| (0..c).map(|j| gram.get(i, j).into()).collect()).collect();
    let image = |x: &[Ball]| rows.iter().map(|row| sum_of_products(row, x, ())).collect();
    let columns = (0..c).map(|k| (0..c).map(|row| transform.get(row, k).into()).collect()).collect();
    let found = Orthonormal::new(columns, &image, ()).ok()?;
    Some(Matrix::from_fn(c, c, |row, k| found.vectors[k][row].mid))
}

/// Gram-Schmidt on the columns of T by the Cholesky factor of TᵀGT; the least pivot beside the largest.
fn by_cholesky(transform: &mut Matrix, gram: &Matrix) -> f64 {
    let c = transform.columns;
    let image = product(gram, transform, Part::All);
    let square = product(&transform.transposed(), &image, Part::Lower);
    let Ok(l) = factor(c, &|i, j| Ball::from(square.get(i, j)), 0.0, ()) else { return 0.0 };
    for row in 0..c {
        let mut own: Vec<Ball> = (0..c).map(|k| transform.get(row, k).into()).collect();
        forward(&l, &mut own);
        own.iter().enumerate().for_each(|(k, x)| transform.set(row, k, x.mid));
    }
    let pivots = || (0..c).map(|k| l[k][k].mid_f64());
    pivots().fold(f64::INFINITY, f64::min) / pivots().fold(0.0, f64::max)
}

/// The first rows in which the columns are independent, by elimination on a copy in doubles.
fn pivot_rows(basis: &Matrix) -> Vec<usize> {
    let (n, c) = (basis.rows, basis.columns);
    let mut b: Vec<Vec<f64>> = (0..c).map(|q| basis.hi.column(q).to_vec()).collect();
    let mut pivots: Vec<usize> = Vec::with_capacity(c);
    for p in 0..c {
        let rest = &b[p..];
        let largest = rest.iter().flatten().fold(0.0_f64, |most, x| most.max(x.abs()));
        // The eliminated rows are left out. The row with the largest entry always qualifies.
        let found = (0..n).filter(|row| !pivots.contains(row)).find_map(|row| {
            let best = (p..c).max_by(|&x, &y| b[x][row].abs().total_cmp(&b[y][row].abs()))?;
            (b[best][row].abs() > NO_PIVOT * largest).then_some((row, best))
        });
        let Some((row, best)) = found else { break };
        b.swap(p, best);
        let pivot = b[p][row];
        let column: Vec<f64> = b[p].iter().map(|x| x / pivot).collect();
        for other in &mut b[p + 1..] {
            let factor = other[row];
            for (x, y) in other.iter_mut().zip(&column) {
                *x -= factor * y;
            }
            other[row] = 0.0;
        }
        pivots.push(row);
    }
    // Columns that rounding made dependent: any rows will do for a basis of some kind.
    let others: Vec<usize> = (0..n).filter(|row| !pivots.contains(row)).take(c - pivots.len()).collect();
    pivots.extend(others);
    pivots.sort_unstable();
    pivots
}

/// The inverse by Gauss-Jordan elimination with row pivoting, from the rows with those of the unit matrix behind them.
fn invert(mut rows: Vec<Vec<DoubleDouble>>) -> Matrix {
    let n = rows.len();
    for k in 0..n {
        let best = (k..n).max_by(|&p, &q| rows[p][k].hi.abs().total_cmp(&rows[q][k].hi.abs())).unwrap_or(k);
        rows.swap(k, best);
        clear_column(&mut rows, k, k, ());
    }
    Matrix::from_fn(n, n, |i, j| rows[i][n + j])
}

/// A quick upper estimate of the vector errors of a cluster, for deciding whether to refine.
pub(super) fn rough_error(cluster: &Cluster) -> f64 {
    cluster.total * (cluster.len() as f64).sqrt()
}
