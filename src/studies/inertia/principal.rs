//! Principal moments and axes of a tensor whose entries are exact constants.
//!
//! The moments are the eigenvalues of I x = lambda x, which is the problem of [`librate_core::modes`] with M = 1 and K = I:
//! the certified stage finds them. What bounds alone can't decide is decided on the exact entries, and only
//! where it is asked: that a moment is 0 (det I = 0), and that two are equal (the discriminant is 0).

use std::ops::Range;

use super::{InertiaError, square};
use librate_core::expr::{ExprId, Pool, Tape};
use librate_core::modes::{self, Kind, ModesError, Options, PreciseProblem, Problem, Source, Spectrum};
use librate_core::number::Number;
use librate_core::precision::{Ball, Big, Rounding, Scalar, decimal};

/// The entries of a symmetric tensor, by row.
pub(super) type Entries = [[ExprId; 3]; 3];

/// The axes of the six independent entries.
const PAIRS: [(usize, usize); 6] = [(0, 0), (1, 0), (2, 0), (1, 1), (2, 1), (2, 2)];

/// Digits beyond those asked for, with which a rounding is tried that fewer do not decide. More decide nothing:
/// what is left then is a tie.
const MORE_DIGITS: [usize; 4] = [0, 3, 12, 40];
/// Digits end here, as in `modes`.
const MOST_DIGITS: usize = 250;

/// A principal moment and its axis.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Moment {
    /// The moment of inertia, in kg m² where the file has units.
    pub value: Ball,
    /// The same to more digits, where a ball does not hold as many as were asked for.
    pub precise: Option<Big>,
    /// A unit vector along the axis; the first component within 1e-6 of the largest is positive.
    pub axis: [f64; 3],
    /// A bound of the error of each component; where moments are equal, of the distance from the space of their axes.
    pub axis_error_bound: f64,
}

/// Principal moments that are equal, or that no bound tells apart.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Equal {
    /// Their numbers, from 0: two or three in a row. Their axes are a choice among many.
    pub moments: Range<usize>,
    /// Whether they are proved to be equal, from the exact entries.
    pub proved: bool,
    /// Of two: the coordinate axis (0, 1, 2) that all of their axes are perpendicular to, where that is exactly one.
    pub across: Option<usize>,
}

/// Why no body has these moments.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Impossible {
    /// One is negative, proved.
    Negative,
    /// The largest is larger than the sum of the two others, proved: I1 + I2 - I3 = 2 Σ m z² for a body.
    Triangle,
}

/// The principal moments of a tensor.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Principal {
    /// Three, ascending; their axes are orthonormal.
    pub moments: Vec<Moment>,
    /// Which of them are equal.
    pub equal: Vec<Equal>,
    /// Why no body has such a tensor; `None` where one may.
    pub impossible: Option<Impossible>,
}

/// A symmetric tensor of exact constants.
pub(super) struct Exact<'a> {
    pub(super) pool: &'a mut Pool,
    /// In the symbols of parameters, where that proves more than their values do.
    pub(super) symbolic: Entries,
    /// Without symbols.
    pub(super) closed: Entries,
}

/// Values of expressions without symbols.
pub(super) fn values<S: Scalar>(pool: &Pool, closed: &[ExprId], precision: S::Precision) -> Option<Vec<S>> {
    Some(Tape::compile(pool, closed, &[]).ok()?.prepare::<S>(precision).evaluate(&[], &mut Vec::new()))
}

/// The same with so many bits; nothing is a number where one has no value.
pub(super) fn bigs(pool: &Pool, closed: &[ExprId], bits: usize) -> Vec<Big> {
    values(pool, closed, bits).unwrap_or_else(|| vec![Big::not_finite(bits); closed.len()])
}

/// The tensor as a source of entries of any precision.
struct Precisely<'a> {
    pool: &'a Pool,
    entries: Entries,
    kernel: Vec<[ExprId; 3]>,
}

impl Source for Precisely<'_> {
    fn precisely(&self, bits: usize) -> Option<PreciseProblem> {
        let mass = square(|row, column| if row == column { Big::one(bits) } else { Big::zero(bits) });
        let vectors = self.kernel.iter().map(|v| values(self.pool, v, bits));
        Some(PreciseProblem {
            dimension: 3,
            mass: mass.into_iter().flatten().collect(),
            stiffness: values(self.pool, self.entries.as_flattened(), bits)?,
            zero_vectors: vectors.collect::<Option<_>>()?,
        })
    }
}

impl Exact<'_> {
    /// The principal moments to so many digits; `not_finite` is said of an entry, by row and column from 0, that is no finite number.
    pub(super) fn principal(
        &mut self,
        digits: usize,
        not_finite: impl Fn(usize, usize) -> InertiaError,
    ) -> Result<Principal, InertiaError> {
        // One triangle stands for both, so that what is solved is symmetric to the last bit.
        for (row, column) in PAIRS {
            self.closed[column][row] = self.closed[row][column];
        }
        let stiffness = values::<Ball>(self.pool, self.closed.as_flattened(), ());
        let stiffness = stiffness.ok_or_else(|| not_finite(0, 0))?;
        if let Some(at) = stiffness.iter().position(|entry| !entry.is_finite()) {
            return Err(not_finite(at / 3, at % 3));
        }
        let unit = |at| if at % 4 == 0 { Ball::ONE } else { Ball::ZERO };
        let mut problem =
            Problem { dimension: 3, mass: (0..9).map(unit).collect(), stiffness, zero_vectors: Vec::new() };
        let mut spectrum = self.solve(&problem, Vec::new(), digits)?;
        let undecided = |mode: &modes::Mode| mode.kind == Kind::Undecided;
        if spectrum.modes.iter().any(undecided) {
            let kernel = self.kernel();
            let vectors = kernel.iter().map(|vector| values::<Ball>(self.pool, vector, ()));
            if let Some(vectors) = vectors.collect::<Option<Vec<_>>>()
                && !vectors.is_empty()
            {
                problem.zero_vectors = vectors;
                spectrum = self.solve(&problem, kernel, digits)?;
            }
        }
        Ok(self.named(&spectrum))
    }

    /// The modes with M = 1, to as many digits as it takes to round omega², not omega.
    fn solve(&self, problem: &Problem, kernel: Vec<[ExprId; 3]>, digits: usize) -> Result<Spectrum, InertiaError> {
        let no_moments = |error: ModesError| InertiaError::NoMoments { reason: error.to_string() };
        let source = Precisely { pool: self.pool, entries: self.closed, kernel };
        let mut last = None;
        for more in MORE_DIGITS {
            let options = Options::default().digits((digits + more).min(MOST_DIGITS));
            let spectrum = modes::solve_from(problem, &source, &options).map_err(no_moments)?;
            let rounded = |mode: &modes::Mode| {
                let written = match &mode.precise {
                    Some(precise) => precise.omega_squared.decimal(digits),
                    None => decimal(&mode.omega_squared, digits),
                };
                written.rounding == Rounding::Correct || mode.kind == Kind::Undecided
            };
            let all = spectrum.modes.iter().all(rounded);
            let better = |before: &Spectrum| before.level <= spectrum.level;
            if last.as_ref().is_none_or(better) {
                last = Some(spectrum);
            }
            if all || digits + more >= MOST_DIGITS {
                break;
            }
        }
        last.ok_or_else(|| no_moments(ModesError::NoConvergence))
    }

    /// Ascending moments, what is equal among them, and whether a body can have them.
    fn named(&mut self, spectrum: &Spectrum) -> Principal {
        // Negative eigenvalues come by falling growth, which is ascending, then 0, then positive ones.
        let moments: Vec<Moment> = spectrum
            .modes
            .iter()
            .map(|mode| Moment {
                value: mode.omega_squared,
                precise: mode.precise.as_ref().map(|precise| precise.omega_squared.clone()),
                axis: [0, 1, 2].map(|at| mode.vector.get(at).copied().unwrap_or(0.0)),
                axis_error_bound: mode.vector_error_bound,
            })
            .collect();
        let mut equal: Vec<Equal> = Vec::new();
        let mut from = 0;
        for modes in spectrum.modes.chunk_by(|a, b| a.cluster == b.cluster) {
            let count = modes.len();
            if count > 1 {
                let zero = modes[0].kind == Kind::Zero;
                equal.push(Equal {
                    moments: from..from + count,
                    proved: zero || self.are_equal(count),
                    across: if count == 2 { self.across() } else { None },
                });
            }
            from += count;
        }
        Principal { impossible: impossible(&moments), moments, equal }
    }

    /// Whether everything vanishes of what is made of the entries, in one of their forms.
    fn vanish(&mut self, of: impl Fn(&mut Pool, &Entries) -> Vec<ExprId>) -> bool {
        [self.symbolic, self.closed].iter().any(|entries| {
            let all = of(self.pool, entries);
            all.into_iter().all(|e| self.pool.vanishes(e))
        })
    }

    /// Whether all three moments are equal, or two of them.
    fn are_equal(&mut self, count: usize) -> bool {
        self.vanish(|pool, entries| {
            if count < 3 {
                return vec![discriminant(pool, entries)];
            }
            let [first, second] = [1, 2].map(|at| pool.sub(entries[0][0], entries[at][at]));
            vec![first, second, entries[1][0], entries[2][0], entries[2][1]]
        })
    }

    /// The coordinate axis about which the tensor is symmetric: no products of inertia at all, and the moments about the
    /// other two equal.
    fn across(&mut self) -> Option<usize> {
        (0..3).find(|axis| {
            let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
            self.vanish(|pool, e| vec![e[1][0], e[2][0], e[2][1], pool.sub(e[i][i], e[j][j])])
        })
    }

    /// Independent vectors of the kernel, without symbols, where the determinant is 0.
    ///
    /// For a symmetric matrix of rank 2 the adjugate is c n nᵀ with c ≠ 0, n the null vector: any of its columns
    /// with a diagonal entry that is not 0 will do. At rank 1 it is 0, and the kernel is what is perpendicular to
    /// a row that is not 0.
    fn kernel(&mut self) -> Vec<[ExprId; 3]> {
        let (zero, one) = (self.pool.zero(), self.pool.one());
        let entries = self.closed;
        if entries.as_flattened().iter().all(|e| self.pool.vanishes(*e)) {
            return vec![[one, zero, zero], [zero, one, zero], [zero, zero, one]];
        }
        if !self.vanish(|pool, form| vec![determinant(pool, form)]) {
            return Vec::new();
        }
        if self.vanish(|pool, form| adjugate(pool, form).as_flattened().to_vec()) {
            let found = entries.iter().find_map(|row| {
                let values = values::<Ball>(self.pool, row, ())?;
                Some((row, (0..3).find(|at| !values[*at].contains_zero())?))
            });
            let Some((row, at)) = found else { return Vec::new() };
            let across = |other: usize| {
                let mut vector = [zero; 3];
                vector[at] = self.pool.neg(row[other]);
                vector[other] = row[at];
                vector
            };
            return [(at + 1) % 3, (at + 2) % 3].map(across).to_vec();
        }
        let adjugate = adjugate(self.pool, &entries);
        let diagonal = [0, 1, 2].map(|at| adjugate[at][at]);
        let Some(sizes) = values::<Ball>(self.pool, &diagonal, ()) else { return Vec::new() };
        let largest = (0..3).reduce(|a, b| if sizes[b].abs_lower() > sizes[a].abs_lower() { b } else { a });
        match largest {
            Some(at) if !sizes[at].contains_zero() => vec![[0, 1, 2].map(|row| adjugate[row][at])],
            _ => Vec::new(),
        }
    }
}

/// Whether moments are impossible for a body, by certified signs: I3 > I1 + I2 or I1 < 0.
fn impossible(moments: &[Moment]) -> Option<Impossible> {
    let [a, b, c] = moments else { return None };
    if a.value.is_negative() {
        return Some(Impossible::Negative);
    }
    let excess = c.value - a.value - b.value;
    excess.is_positive().then_some(Impossible::Triangle)
}

/// a b - c d.
fn minor(pool: &mut Pool, [a, b, c, d]: [ExprId; 4]) -> ExprId {
    let (plus, minus) = (pool.mul(a, b), pool.mul(c, d));
    pool.sub(plus, minus)
}

/// The matrix of cofactors.
fn adjugate(pool: &mut Pool, e: &Entries) -> Entries {
    square(|i, j| {
        // Cyclic rows and columns carry the sign with them.
        let (r, s, u, v) = ((i + 1) % 3, (i + 2) % 3, (j + 1) % 3, (j + 2) % 3);
        minor(pool, [e[r][u], e[s][v], e[r][v], e[s][u]])
    })
}

fn determinant(pool: &mut Pool, e: &Entries) -> ExprId {
    let cofactors = adjugate(pool, e)[0];
    pool.dot(&e[0], &cofactors)
}

/// 4 J2³ - 27 J3² of the deviator S, J2 = tr(S²)/2, J3 = det S: the discriminant of the characteristic polynomial
/// (s³ - J2 s - J3), 0 exactly where two moments are equal. S is multiplied by 3.
fn discriminant(pool: &mut Pool, e: &Entries) -> ExprId {
    let mut deviator = *e;
    for (i, row) in deviator.iter_mut().enumerate() {
        for (j, entry) in row.iter_mut().enumerate() {
            *entry = if i == j {
                let (b, c) = (e[(i + 1) % 3][(i + 1) % 3], e[(i + 2) % 3][(i + 2) % 3]);
                let minus = Number::from(-1);
                pool.linear(&[(*entry, Number::from(2)), (b, minus.clone()), (c, minus)])
            } else {
                pool.scale(*entry, &Number::from(3))
            };
        }
    }
    let squares: Vec<(ExprId, Number)> =
        deviator.as_flattened().iter().map(|entry| (pool.powi(*entry, 2), Number::half())).collect();
    let j2 = pool.linear(&squares);
    let j3 = determinant(pool, &deviator);
    let (cube, square) = (pool.powi(j2, 3), pool.powi(j3, 2));
    pool.linear(&[(cube, Number::from(4)), (square, Number::from(-27))])
}
