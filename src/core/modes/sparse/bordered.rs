//! s²M + sD + S as a pencil of first order at one complex number, with borders: solutions with it, and a proof that it is regular.
//!
//! With y = s x and any positive definite K the equations (s²M + sD + S) x = 0 are P(s) (x, y) = 0,
//!
//! ```text
//!   P(s) = [ sK    -K   ] = P(σ) + (s - σ) E,   E = [ K   0 ].
//!          [ S   D + sM ]                           [ 0   M ]
//! ```
//!
//! Where K is S itself, E measures the energy: P is normal in these units but for D, so that no singular value of P(σ) is less than the distance of
//! the next exponent from σ where nothing is damped. Singular values σᵢ of any matrix B are the eigenvalues ±σᵢ of [[0, B], [Bᴴ, 0]], or of
//!
//! ```text
//!   ½ [ B + Bᴴ   Bᴴ - B  ]
//!     [ B - Bᴴ  -B - Bᴴ  ],
//! ```
//!
//! which has the Hermitian part of B on its diagonal, so that it is decomposed as well as a real stiffness is: of P(σ) times a number
//! that makes σ positive. Real and imaginary parts make a real symmetric matrix of it, and counting its eigenvalues below τ > 0 as any others'
//! proves that no σᵢ is less than τ (S. Rump, "Verification methods: rigorous results using floating-point arithmetic", Acta Numerica 19
//! (2010) 287, section 10.8, has the same for symmetric matrices).

use faer::c64;

use super::order::elimination;
use super::rows::{Rows, U};
use super::shifted::{Factor, Pencil};
use crate::order::Gather;
use crate::precision::{Ball, Complex, SparseMatrix, up};

/// M, D, S and K by rows, and what lengths are measured with.
pub(super) struct Form {
    pub(super) mass: Rows,
    pub(super) velocity: Rows,
    pub(super) stiffness: Rows,
    /// K, which is not less than `floor` times M.
    pub(super) energy: Rows,
    pub(super) floor: f64,
    /// With d so that M - diag(d) is not negative: √d, and 1/√d rounded up.
    pub(super) weights: Vec<f64>,
    pub(super) roots: Vec<f64>,
    /// In which the coordinates are eliminated, see [`Form::order`].
    pub(super) order: Vec<usize>,
}

/// A row and a column beside P(σ), 2n entries each.
pub(super) struct Border {
    pub(super) column: Vec<c64>,
    pub(super) row: Vec<c64>,
}

/// P(σ) with borders, as a real symmetric matrix.
pub(super) struct Bordered {
    pencil: Pencil,
    /// What P(σ) and its columns are multiplied by.
    turn: c64,
}

/// Entries of the lower triangle that are added up.
#[derive(Default)]
pub(super) struct Shares(Vec<(u32, u32, Ball)>);

impl Form {
    /// An order in which to eliminate coordinates that any of some matrices couple; `None` where there is no memory.
    pub(super) fn order(matrices: [&Rows; 4]) -> Option<Vec<usize>> {
        let n = matrices[0].dimension();
        let (mut starts, mut rows) = (vec![0], Vec::new());
        // A matrix that is not symmetric couples both ways.
        let mut columns: Vec<Vec<usize>> = vec![Vec::new(); n];
        for i in 0..n {
            for j in matrices.iter().flat_map(|own| own.entries(i)).map(|(j, _)| j) {
                columns[i.max(j)].push(i.min(j));
            }
        }
        for column in columns {
            rows.extend(column.into_iter().distinct());
            starts.push(rows.len());
        }
        let symbolic = elimination(&starts, &rows, None)?.symbolic;
        Some(symbolic.perm().map_or_else(|| (0..n).collect(), |own| own.arrays().0.to_vec()))
    }

    /// n.
    pub(super) fn dimension(&self) -> usize {
        self.roots.len()
    }

    /// Bounds in length of M⁻¹D and M⁻¹S.
    pub(super) fn norms(&self) -> [f64; 2] {
        [&self.velocity, &self.stiffness].map(|rows| {
            // √(‖A‖₁ ‖A‖∞) of D^(-1/2) A D^(-1/2) for a matrix that need not be symmetric.
            let n = self.dimension();
            let (mut columns, mut most) = (vec![0.0; n], 0.0_f64);
            for i in 0..n {
                let mut sum = 0.0;
                for (j, entry) in rows.entries(i) {
                    let own = entry.abs_upper() * self.roots[i] * self.roots[j];
                    sum += own;
                    columns[j] += own;
                }
                most = most.max(sum);
            }
            let other = columns.into_iter().fold(0.0, f64::max);
            up((most * other).sqrt() * (1.0 + (2 * n + 32) as f64 * U))
        })
    }

    /// E u, in doubles.
    pub(super) fn first_order(&self, u: &[c64]) -> Vec<c64> {
        let (x, y) = u.split_at(self.dimension());
        let row = |rows: &Rows, x: &[c64], i: usize| {
            let parts = rows.row(i).map(|at| x[rows.columns[at] as usize] * rows.high[at]);
            parts.fold(c64::new(0.0, 0.0), |sum, part| sum + part)
        };
        let n = self.dimension();
        (0..n).map(|i| row(&self.energy, x, i)).chain((0..n).map(|i| row(&self.mass, y, i))).collect()
    }
}

impl Shares {
    /// An entry of a Hermitian matrix with its mirror image. Unknowns are sums (`part` 0) and differences (1) of complex ones, of which each
    /// has two real parts.
    fn hermitian(&mut self, [a, of]: [usize; 2], [b, with]: [usize; 2], z: &Complex<Ball>) {
        let place = |at: usize, part: usize, imaginary: usize| (2 * (2 * at + part) + imaginary) as u32;
        for (i, j, value) in [(0, 0, z.re), (1, 1, z.re), (1, 0, z.im), (0, 1, -z.im)] {
            let (i, j) = (place(a, of, i), place(b, with, j));
            if !value.is_zero() {
                self.0.push((i.max(j), i.min(j), value));
            }
        }
    }

    /// An entry of B.
    pub(super) fn add(&mut self, a: usize, b: usize, entry: &Complex<Ball>) {
        if a == b {
            self.hermitian([a, 0], [a, 0], &Complex::new(entry.re, Ball::ZERO));
            self.hermitian([a, 1], [a, 1], &Complex::new(-entry.re, Ball::ZERO));
            self.hermitian([a, 1], [a, 0], &Complex::new(Ball::ZERO, entry.im));
            return;
        }
        let half = entry.scale(-1);
        let minus = Complex::new(-half.re, -half.im);
        self.hermitian([a, 0], [b, 0], &half);
        self.hermitian([a, 1], [b, 1], &minus);
        self.hermitian([a, 1], [b, 0], &half);
        self.hermitian([b, 1], [a, 0], &minus.conjugate());
    }
}

impl Bordered {
    /// P(σ) with borders. `None` where there is no memory.
    pub(super) fn new(form: &Form, sigma: c64, borders: &[Border]) -> Option<Self> {
        let n = form.dimension();
        let order = 2 * n + borders.len();
        // A number that bounds need not hold for: only σ times it has to be what it is.
        let turn = sigma.conj() * (1.0 / sigma.norm());
        let by = Complex::<Ball>::from_c64(turn, ());
        let turned = by.mul(&Complex::from_c64(sigma, ()));
        let minus = Complex::new(-by.re, -by.im);
        let mut shares = Shares::default();
        for i in 0..n {
            for (j, entry) in form.energy.entries(i) {
                shares.add(i, j, &turned.times(&entry));
                shares.add(i, n + j, &minus.times(&entry));
            }
            for (j, entry) in form.stiffness.entries(i) {
                shares.add(n + i, j, &by.times(&entry));
            }
            for (j, entry) in form.velocity.entries(i) {
                shares.add(n + i, n + j, &by.times(&entry));
            }
            for (j, entry) in form.mass.entries(i) {
                shares.add(n + i, n + j, &turned.times(&entry));
            }
        }
        for (number, border) in borders.iter().enumerate() {
            for i in 0..2 * n {
                shares.add(i, 2 * n + number, &Complex::from_c64(border.column[i], ()));
                shares.add(2 * n + number, i, &Complex::from_c64(border.row[i], ()));
            }
        }
        let matrix = SparseMatrix::from_shares(4 * order, &shares.0);
        shares.0.clear();
        for at in 0..2 * n {
            let (rows, first) = if at < n { (&form.energy, 0) } else { (&form.mass, n) };
            for (j, entry) in rows.entries(at - first).filter(|(j, _)| first + j <= at) {
                let slots = (0..4).map(|slot| ((4 * at + slot) as u32, (4 * (first + j) + slot) as u32, entry));
                shares.0.extend(slots);
            }
        }
        shares.0.extend((8 * n..4 * order).map(|at| (at as u32, at as u32, Ball::ONE)));
        let unit = SparseMatrix::from_shares(4 * order, &shares.0);
        let root = form.floor.sqrt() * (1.0 - 4.0 * U);
        let weights = form.weights.iter().map(|own| own * root).chain(form.weights.iter().copied());
        let weights = weights.chain(borders.iter().map(|_| 1.0)).flat_map(|own| [own * own * (1.0 - 8.0 * U); 4]);
        // x before y of each coordinate: the other way round squares of K would be left of what is as small as K.
        let slots = |at: usize| 4 * at..4 * at + 4;
        let first = form.order.iter().flat_map(|i| slots(*i).chain(slots(n + i)));
        let places: Vec<usize> = first.chain(8 * n..4 * order).collect();
        let pencil = Pencil::of(Rows::new(&matrix), Rows::new(&unit), weights.collect(), Some(&places))?;
        Some(Self { pencil, turn })
    }

    /// Any matrix, turned already, in units of d, its rows eliminated in an order. `None` where there is no memory.
    pub(super) fn of(shares: &Shares, weights: &[f64], order: &[usize], turn: c64) -> Option<Self> {
        let n = weights.len();
        let matrix = SparseMatrix::from_shares(4 * n, &shares.0);
        let diagonal = |at: usize| (at as u32, at as u32, Ball::exact(weights[at / 4]));
        let unit = SparseMatrix::from_shares(4 * n, &(0..4 * n).map(diagonal).collect::<Vec<_>>());
        let weights = weights.iter().flat_map(|own| [own * (1.0 - 8.0 * U); 4]).collect();
        let places: Vec<usize> = order.iter().flat_map(|i| 4 * i..4 * i + 4).collect();
        Some(Self { pencil: Pencil::of(Rows::new(&matrix), Rows::new(&unit), weights, Some(&places))?, turn })
    }

    /// About how many entries a decomposition has.
    pub(super) fn fill(&self) -> usize {
        self.pencil.fill()
    }

    /// What solutions are made with, of a matrix that is this part of the norm aside.
    pub(super) fn factor(&self, part: f64) -> Option<Factor<'_>> {
        self.pencil.factor(part * self.pencil.stiffness_norms.0)
    }

    /// A proved lower bound of the singular values in units of E, next to `wanted`; else how many seem to be less.
    pub(super) fn least(&self, wanted: f64) -> Result<f64, usize> {
        let factor = self.pencil.factor(wanted).ok_or(0_usize)?;
        let half = self.pencil.dimension() / 2;
        let least = (wanted - factor.error) * (1.0 - 4.0 * U);
        // Real and imaginary parts count each twice.
        if factor.negative == half && least > 0.0 { Ok(least) } else { Err(factor.negative.abs_diff(half) / 2) }
    }

    /// P⁻¹f and P⁻ᴴg, about.
    pub(super) fn solve(&self, factor: &Factor<'_>, f: &[c64], g: &[c64]) -> [Vec<c64>; 2] {
        let parts = |(f, g): (&c64, &c64)| {
            let (f, g) = (self.turn * f, self.turn.conj() * g);
            [(f + g) * 0.5, (f - g) * 0.5]
        };
        let mut both: Vec<f64> = f.iter().zip(g).flat_map(parts).flat_map(|z| [z.re, z.im]).collect();
        factor.solve(&mut both);
        let part = |at: usize, part: usize| c64::new(both[4 * at + 2 * part], both[4 * at + 2 * part + 1]);
        let all = 0..self.pencil.dimension() / 4;
        [all.clone().map(|at| part(at, 0) - part(at, 1)).collect(), all.map(|at| part(at, 0) + part(at, 1)).collect()]
    }
}
