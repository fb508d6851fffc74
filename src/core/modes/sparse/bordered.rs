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
use super::shifted::{Factor, GivenOrder, Pattern, Pencil};
use crate::order::{Gather, Order};
use crate::precision::{Ball, Complex, up};

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
    pub(super) pattern: Pattern,
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

/// More than there can be singular values.
pub(super) const NO_PIVOT: usize = usize::MAX;

/// Columns and entries of a row of a complex matrix, by rising column.
pub(super) type Row = Vec<(usize, Complex<Ball>)>;

/// A row with these entries, added up where there are several in a column.
pub(super) fn row(parts: impl Iterator<Item = (usize, Complex<Ball>)>) -> Row {
    added_up(parts, Complex::add)
}

fn added_up<T>(parts: impl Iterator<Item = (usize, T)>, add: impl Fn(&T, &T) -> T) -> Vec<(usize, T)> {
    let mut all: Vec<(usize, T)> = parts.collect();
    all.order_by_key(|(j, _)| *j);
    all.dedup_by(|next, kept| {
        let is_same = next.0 == kept.0;
        if is_same {
            kept.1 = add(&kept.1, &next.1);
        }
        is_same
    });
    all
}

impl Form {
    /// An order in which to eliminate coordinates that any of some matrices couple; `None` where there is no memory.
    pub(super) fn order(matrices: [&Rows; 4]) -> Option<Vec<usize>> {
        let n = matrices[0].dimension();
        let (mut starts, mut rows) = (vec![0], Vec::new());
        // A matrix that is not symmetric couples both ways.
        let row =
            |i: usize| matrices.iter().flat_map(move |own| own.entries(i)).map(move |(j, _)| (i.max(j), i.min(j)));
        for column in (0..n).flat_map(row).by_place(n) {
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

/// The Hermitian matrix of a complex one, see above, as a real symmetric one. Unknowns are sums and differences of complex ones, each with a
/// real and an imaginary part.
fn hermitian(matrix: &[Row]) -> Rows {
    // The entries of columns above the diagonal.
    let mut above: Vec<Row> = vec![Row::new(); matrix.len()];
    for (a, row) in matrix.iter().enumerate() {
        row.iter().filter(|(b, _)| *b > a).for_each(|(b, entry)| above[*b].push((a, *entry)));
    }
    let mut rows = Rows::half();
    for (a, (own, above)) in matrix.iter().zip(above).enumerate() {
        // Entries of ½(B + Bᴴ) and ½(B - Bᴴ).
        let below = own.iter().filter(|(b, _)| *b <= a).map(|(b, entry)| {
            let half = entry.scale(-1);
            let [on, beside] = [Complex::new(entry.re, Ball::ZERO), Complex::new(Ball::ZERO, entry.im)];
            (*b, if *b == a { [on, beside] } else { [half, half] })
        });
        let above = above.into_iter().map(|(b, entry)| {
            let half = entry.conjugate().scale(-1);
            (b, [half, Complex::new(-half.re, -half.im)])
        });
        let pairs = added_up(below.chain(above), |[a, b], [c, d]| [a.add(c), b.add(d)]);
        for slot in 0..4 {
            for (b, [sum, difference]) in &pairs {
                for with in (0..4).filter(|with| 4 * b + with <= 4 * a + slot) {
                    let entry = if slot / 2 == with / 2 { sum } else { difference };
                    let part = if slot % 2 == with % 2 { entry.re } else { entry.im };
                    let is_negative = (with / 2 == 1) != (slot % 2 < with % 2);
                    rows.push(4 * b + with, &if is_negative { -part } else { part });
                }
            }
            rows.end_row();
        }
    }
    rows
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
        let mut matrix: Vec<Row> = Vec::with_capacity(order);
        for i in 0..n {
            let energy = || form.energy.entries(i);
            let own = energy().map(|(j, entry)| (j, turned.times(&entry)));
            matrix.push(own.chain(energy().map(|(j, entry)| (n + j, minus.times(&entry)))).collect());
        }
        for i in 0..n {
            let stiffness = form.stiffness.entries(i).map(|(j, entry)| (j, by.times(&entry)));
            let velocity = form.velocity.entries(i).map(|(j, entry)| (n + j, by.times(&entry)));
            let mass = form.mass.entries(i).map(|(j, entry)| (n + j, turned.times(&entry)));
            matrix.push(row(stiffness.chain(velocity).chain(mass)));
        }
        for (number, border) in borders.iter().enumerate() {
            let entries = |all: &[c64]| all.iter().map(|z| Complex::from_c64(*z, ())).collect::<Vec<_>>();
            for (row, entry) in matrix.iter_mut().zip(entries(&border.column)) {
                row.push((2 * n + number, entry));
            }
            matrix.push(entries(&border.row).into_iter().enumerate().collect());
        }
        let mut unit = Rows::half();
        for at in 0..4 * order {
            let (node, slot) = (at / 4, at % 4);
            let (rows, first) = if node < n { (&form.energy, 0) } else { (&form.mass, n) };
            if node < 2 * n {
                let below = rows.entries(node - first).filter(|(j, _)| first + j <= node);
                below.for_each(|(j, entry)| unit.push(4 * (first + j) + slot, &entry));
            } else {
                unit.push(at, &Ball::ONE);
            }
            unit.end_row();
        }
        let root = form.floor.sqrt() * (1.0 - 4.0 * U);
        let weights = form.weights.iter().map(|own| own * root).chain(form.weights.iter().copied());
        let weights = weights.chain(borders.iter().map(|_| 1.0)).flat_map(|own| [own * own * (1.0 - 8.0 * U); 4]);
        // x before y of each coordinate: the other way round squares of K would be left of what is as small as K.
        let slots = |at: usize| 4 * at..4 * at + 4;
        let first = form.order.iter().flat_map(|i| slots(*i).chain(slots(n + i)));
        let places: Vec<usize> = first.chain(8 * n..4 * order).collect();
        let order = GivenOrder { rows: &places, last: &form.pattern };
        let pencil = Pencil::of(hermitian(&matrix), unit, weights.collect(), Some(&order))?;
        Some(Self { pencil, turn })
    }

    /// Any matrix, turned already, in units of d, its rows eliminated in an order. `None` where there is no memory.
    pub(super) fn of(matrix: &[Row], weights: &[f64], order: &GivenOrder<'_>, turn: c64) -> Option<Self> {
        let mut unit = Rows::half();
        for at in 0..4 * weights.len() {
            unit.push(at, &Ball::exact(weights[at / 4]));
            unit.end_row();
        }
        let weights = weights.iter().flat_map(|own| [own * (1.0 - 8.0 * U); 4]).collect();
        let places: Vec<usize> = order.rows.iter().flat_map(|i| 4 * i..4 * i + 4).collect();
        let order = GivenOrder { rows: &places, last: order.last };
        Some(Self { pencil: Pencil::of(hermitian(matrix), unit, weights, Some(&order))?, turn })
    }

    /// About how many entries a decomposition has.
    pub(super) fn fill(&self) -> usize {
        self.pencil.fill()
    }

    /// What solutions are made with, of a matrix that is this part of the norm aside.
    pub(super) fn factor(&self, part: f64) -> Option<Factor<'_>> {
        self.pencil.factor(part * self.pencil.stiffness_norms.0)
    }

    /// A proved lower bound of the singular values in units of E, next to `wanted`; else how many seem to be less, [`NO_PIVOT`] where there is no
    /// decomposition.
    pub(super) fn least(&self, wanted: f64) -> Result<f64, usize> {
        let factor = self.pencil.factor(wanted).ok_or(NO_PIVOT)?;
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
