//! The structure of λ²M + λD + S at an exponent: how many Jordan blocks it has, of which sizes, and the vectors that
//! head them.
//!
//! A chain of length k at λ is x_0 ≠ 0, x_1, …, x_{k-1} with Σ_j L⁽ʲ⁾(λ)/j! x_{i-j} = 0 for i < k: a vector of the
//! kernel of the block Toeplitz matrix T_k of L, L' and L''/2 = M. Its kernel has the dimension Σ min(k, κ) over the
//! sizes κ of the blocks at λ (Gohberg, Lancaster, Rodman, Matrix Polynomials, 1.5), so that the dimensions for k = 1, 2, …
//! tell how many blocks are at least that long, and the heads of chains of length k are the space that these begin with.
//!
//! An upper bound of a dimension is what elimination leaves whose pivots exclude 0 (at enclosures of λ). A lower one
//! comes from exact numbers: for C the companion matrix of a polynomial f with simple roots, M⊗C² + D⊗C + S⊗1 is
//! similar to the direct sum of L over all roots of f, and so is T_k; its rank is that of a whole matrix. Where
//! the two meet in the sum over the roots, they meet at each.
//!
//! Square roots √d in the entries are the matrices [[0, d], [1, 0]] there, so that the sum is over their conjugates too: over L with
//! either sign of each.

use dashu_int::IBig;

use super::basis::Metric;
use super::complex::Wide;
use super::polynomial::{Polynomial, rank};
use crate::precision::{Big, Eliminated, Integers, eliminate, sum_of_products};

/// Products of words that an exact rank may cost, about: a second.
const MOST_WORK: f64 = 1e9;

/// The blocks at a root by falling size, and for each the vector that heads it: xᴴMx = 1, all of them orthogonal. Those that
/// are longest span the heads of chains of that length, and so on down.
#[derive(Clone, Debug)]
pub(super) struct Blocks {
    pub(super) sizes: Vec<usize>,
    /// Empty if not asked for.
    pub(super) heads: Vec<Vec<Wide>>,
}

/// What came of looking for blocks.
pub(super) enum Search {
    Found(Vec<Blocks>),
    /// The enclosures are too wide.
    Finer,
    /// Exact ranks cost too much.
    TooLarge,
}

/// λ²M + λD + S with whole entries.
pub(super) struct Pencil<'a> {
    pub(super) matrices: &'a Integers,
    pub(super) n: usize,
}

impl Pencil<'_> {
    /// How many choices of signs the square roots in the entries have.
    pub(super) fn conjugates(&self) -> usize {
        1 << self.matrices.roots.len()
    }

    /// One of the matrices with 2^k by 2^k blocks for its entries, row by row: √d_S √d_T is √d_(S xor T) times the product of what
    /// S and T share.
    pub(super) fn whole(&self, matrix: &[IBig]) -> Vec<Vec<IBig>> {
        let (n, conjugates) = (self.n, self.conjugates());
        let shared = |bits: usize| {
            let roots = self.matrices.roots.iter().enumerate();
            let own = roots.filter(|(at, _)| bits >> at & 1 == 1);
            own.fold(IBig::ONE, |product, (_, root)| product * root)
        };
        let products: Vec<IBig> = (0..conjugates).map(shared).collect();
        let entry = |row: usize, column: usize| {
            let (i, of, j, from) = (row % n, row / n, column % n, column / n);
            let part = matrix.get((of ^ from) * n * n + j * n + i);
            part.map_or(IBig::ZERO, |part| part * &products[(of ^ from) & from])
        };
        let size = n * conjugates;
        let row = |i: usize| (0..size).map(|j| entry(i, j)).collect();
        (0..size).map(row).collect()
    }

    /// One of the matrices with the square roots whose bits are set turned into their negatives, column by column.
    pub(super) fn values(&self, matrix: &[IBig], conjugate: usize, bits: usize) -> Vec<Big> {
        let square = self.n * self.n;
        let big = |x: &IBig| Big::from_parts(x.clone(), 0, bits);
        let roots: Vec<Big> = self.matrices.roots.iter().map(|root| big(root).sqrt()).collect();
        let mut sums = vec![Big::zero(bits); square];
        for (part, entries) in matrix.chunks(square.max(1)).enumerate() {
            let own = roots.iter().enumerate().filter(|(at, _)| part >> at & 1 == 1);
            let mut root = own.fold(Big::one(bits), |product, (_, root)| &product * root);
            if (part & conjugate).count_ones() % 2 == 1 {
                root = -&root;
            }
            for (sum, entry) in sums.iter_mut().zip(entries) {
                if !entry.is_zero() {
                    *sum = &*sum + &(&big(entry) * &root);
                }
            }
        }
        sums
    }

    /// The blocks at the roots of f, a polynomial with simple roots, all of the given multiplicity with all conjugates; none at
    /// those that are roots of conjugates alone. `semisimple` where it is known that all blocks have size 1.
    pub(super) fn blocks(
        &self,
        f: &Polynomial,
        roots: &[Wide],
        multiplicity: usize,
        semisimple: bool,
        metric: Option<&Metric<'_>>,
    ) -> Search {
        // Dimensions of the kernels of T_1, T_2, …, one list a root, and with all conjugates at the last level.
        let mut dimensions: Vec<Vec<usize>> = vec![Vec::new(); roots.len()];
        let mut all = vec![0; roots.len()];
        let mut kernels: Vec<Vec<Echelon>> = roots.iter().map(|_| Vec::new()).collect();
        let mut level = 0;
        while level < multiplicity && all.iter().any(|own| *own != multiplicity) {
            level += 1;
            let (mut total, mut certain) = (0, true);
            for (at, lambda) in roots.iter().enumerate() {
                let before = all[at];
                let nullity = |echelon: &Echelon| level * self.n - echelon.rank();
                let own = Echelon::new(self.chains(lambda, level, 0));
                dimensions[at].push(nullity(&own));
                all[at] = nullity(&own);
                kernels[at].push(own);
                for conjugate in 1..self.conjugates() {
                    all[at] += nullity(&Echelon::new(self.chains(lambda, level, conjugate)));
                }
                if all[at] > multiplicity {
                    return Search::Finer;
                }
                // One chain at least is a step longer, as long as the multiplicity is not reached.
                certain &= all[at] == (before + 1).min(multiplicity);
                // One above the axis stands for its conjugate, too.
                total += all[at] * if lambda.im.is_zero() { 1 } else { 2 };
            }
            let known = certain || semisimple && total == multiplicity * (f.len() - 1);
            if !known {
                match self.exact_dimension(f, level) {
                    None => return Search::TooLarge,
                    Some(exact) if exact != total => return Search::Finer,
                    Some(_) => {}
                }
            }
        }
        let each = dimensions.iter().zip(&kernels);
        let found = each.map(|(dimensions, kernels)| self.headed(dimensions, kernels, metric)).collect::<Option<_>>();
        found.map_or(Search::Finer, Search::Found)
    }

    /// Sizes from the dimensions of the kernels, and heads from the longest chains down.
    fn headed(&self, dimensions: &[usize], kernels: &[Echelon], metric: Option<&Metric<'_>>) -> Option<Blocks> {
        let (mut sizes, mut heads) = (Vec::new(), Vec::new());
        for level in (1..=dimensions.len()).rev() {
            let before = level.checked_sub(2).map_or(0, |at| dimensions[at]);
            // So many blocks are of this size at least.
            let count = dimensions[level - 1].checked_sub(before)?;
            let more = count.checked_sub(sizes.len())?;
            if more == 0 {
                continue;
            }
            sizes.extend(std::iter::repeat_n(level, more));
            if let Some(metric) = metric {
                let mut chains = kernels.get(level - 1)?.kernel();
                chains.iter_mut().for_each(|chain| chain.truncate(self.n));
                let new = metric.orthonormal(&heads, chains, more)?;
                heads.extend(new);
            }
        }
        Some(Blocks { sizes, heads })
    }

    /// The vector of the kernel of the transpose at an exponent, where that has one dimension.
    pub(super) fn left_null_vector(&self, lambda: &Wide) -> Option<Vec<Wide>> {
        let rows = self.chains(lambda, 1, 0);
        let column = |j: usize| rows.iter().map(|row| row[j].clone()).collect();
        let echelon = Echelon::new((0..self.n).map(column).collect());
        let simple = echelon.rank() + 1 == self.n;
        echelon.kernel().into_iter().next().filter(|_| simple)
    }

    /// (2λM + D)x
    pub(super) fn slope(&self, lambda: &Wide, x: &[Wide]) -> Vec<Wide> {
        let rows = self.chains(lambda, 2, 0).into_iter().skip(self.n);
        rows.map(|row| sum_of_products(&row, x, lambda.re.bits())).collect()
    }

    /// T_k at λ, of a conjugate.
    fn chains(&self, lambda: &Wide, level: usize, conjugate: usize) -> Vec<Vec<Wide>> {
        let (n, bits) = (self.n, lambda.re.bits());
        let [mass, velocity, stiffness] =
            self.matrices.matrices.each_ref().map(|matrix| self.values(matrix, conjugate, bits));
        let mut rows = vec![vec![Wide::zero(bits); n * level]; n * level];
        for i in 0..n {
            for j in 0..n {
                let k = j * n + i;
                let m = mass[k].clone();
                let product = lambda.times(&m);
                let plus = |mut x: Wide, y: &Big| {
                    x.re = &x.re + y;
                    x
                };
                let value = plus(plus(product.clone(), &velocity[k]).mul(lambda), &stiffness[k]);
                let slope = plus(product.times(&Big::one(bits).scale(1)), &velocity[k]);
                let curve = Wide { re: m, im: Big::zero(bits) };
                for (down, part) in [value, slope, curve].into_iter().enumerate() {
                    for at in down..level {
                        rows[at * n + i][(at - down) * n + j] = part.clone();
                    }
                }
            }
        }
        rows
    }

    /// The dimension of the kernel of T_k summed over the roots of f, exactly.
    ///
    /// With a the leading coefficient of f and C = aC₁ for C₁ the companion matrix, T_k times a².
    fn exact_dimension(&self, f: &Polynomial, level: usize) -> Option<usize> {
        let (n, d) = (self.n * self.conjugates(), f.len().checked_sub(1)?);
        let [mass, velocity, stiffness] = self.matrices.matrices.each_ref().map(|matrix| self.whole(matrix));
        let lead = f.last()?;
        let one = |p: usize, q: usize| IBig::from(u8::from(p == q));
        let mut c = vec![vec![IBig::ZERO; d]; d];
        for i in 0..d {
            if i > 0 {
                c[i][i - 1] = lead.clone();
            }
            c[i][d - 1] -= &f[i];
        }
        let square = |i: usize, j: usize| (0..d).map(|k| &c[i][k] * &c[k][j]).sum::<IBig>();
        let square: Vec<Vec<IBig>> = (0..d).map(|i| (0..d).map(|j| square(i, j)).collect()).collect();
        let size = n * d * level;
        let mut rows = vec![vec![IBig::ZERO; size]; size];
        let curvature = lead * lead;
        for i in 0..n {
            for j in 0..n {
                let m = &mass[i][j];
                let v = &velocity[i][j] * lead;
                let s = &stiffness[i][j] * &curvature;
                let twice = m * lead * IBig::from(2);
                for p in 0..d {
                    for q in 0..d {
                        let parts = [
                            m * &square[p][q] + &v * &c[p][q] + &s * one(p, q),
                            &twice * &c[p][q] + &v * lead * one(p, q),
                            m * &curvature * one(p, q),
                        ];
                        for (down, part) in parts.iter().enumerate() {
                            for at in down..level {
                                rows[(at * n + i) * d + p][((at - down) * n + j) * d + q] = part.clone();
                            }
                        }
                    }
                }
            }
        }
        let bits = rows.iter().flatten().map(dashu_int::ops::BitTest::bit_len);
        let words = (bits.max().unwrap_or(0) * size / 64 + 1) as f64;
        ((size as f64).powi(3) * words <= MOST_WORK).then(|| size - rank(rows))
    }
}

/// Rows after elimination with complete pivoting, as far as pivots exclude 0.
struct Echelon {
    width: usize,
    bits: usize,
    eliminated: Eliminated<Wide>,
}

impl Echelon {
    fn new(rows: Vec<Vec<Wide>>) -> Self {
        let width = rows.first().map_or(0, Vec::len);
        let bits = rows.iter().flatten().next().map_or(64, |x| x.re.bits());
        let least = |x: &Wide| Some(x.re.abs_lower().max(x.im.abs_lower())).filter(|size| !size.is_zero());
        Self { width, bits, eliminated: eliminate(rows, |row| row.iter().map(least).collect(), bits) }
    }

    fn rank(&self) -> usize {
        self.eliminated.pivots.len()
    }

    /// A basis of the kernel, where the rank is no larger than what was found.
    fn kernel(&self) -> Vec<Vec<Wide>> {
        let Eliminated { pivots, rows } = &self.eliminated;
        let vector = |free: usize| {
            let mut vector = vec![Wide::zero(self.bits); self.width];
            vector[free].re = Big::one(self.bits);
            for (at, row) in pivots.iter().zip(rows) {
                vector[*at] = Wide::zero(self.bits).sub(&row[free]);
            }
            vector
        };
        (0..self.width).filter(|column| !pivots.contains(column)).map(vector).collect()
    }
}
