//! Holonomic constraints: multipliers as further coordinates, and tangent spaces.
//!
//! With multipliers lambda, an equilibrium under constraints c = 0 is a point where
//! U = V - T0 - sum of lambda_a c_a(q) is stationary in q and lambda alike (Lagrange, Mécanique analytique,
//! part 1, section 4). So the multipliers join the coordinates, each constraint becomes a term of the potential, and
//! search and proof of the equilibrium, symmetries and zero modes are those of any other model. The second derivatives
//! of U by q are then the stiffness with the curvature of the constraints, V'' - sum of lambda c'', and
//! those by lambda and q are -∂c/∂q, from which the directions are worked out that the constraints allow.

use super::elimination::Elimination;
use super::parameters::{Formulas, known_values};
use crate::expr::{ExprId, Pool};
use crate::model::{Local, Model, TermFamily};
use crate::precision::{self, Ball, Big, Complex, Eliminated, Enclosure, Scalar, clear_column};

/// A model whose multipliers are coordinates behind its own.
#[derive(Clone, Debug)]
pub(crate) struct Tied {
    pub(crate) model: Model,
    /// The number of coordinates proper.
    pub(super) visible: usize,
    /// The constraints that have a multiplier, by number.
    kept: Vec<usize>,
    /// Those that follow from others wherever these hold, or contradict them.
    pub(crate) dependent: Vec<usize>,
}

impl Tied {
    /// What the multipliers are called.
    pub(crate) fn names(&self) -> Vec<String> {
        self.model.coordinates.names().skip(self.visible).collect()
    }

    /// What the constraints with a multiplier set to zero.
    pub(crate) fn expressions(&self) -> Vec<ExprId> {
        let constraints = self.kept.iter().filter_map(|at| self.model.constraints.get(*at));
        constraints.map(|own| own.expression).collect()
    }
}

/// The model with a multiplier for each constraint that is independent of those before it.
///
/// A multiplier is called `lambda`, or `lambda[2]` for the second of several constraints, where that is free.
pub(crate) fn with_multipliers(model: &Model) -> Tied {
    let family = model.unused_name(&["lambda", "Lambda", "multiplier"]);
    let visible = model.coordinates.len();
    let mut model = model.clone();
    let (kept, dependent) = independent(&mut model);
    for number in &kept {
        let constraint = model.constraints[*number];
        let name = match model.constraints.len() {
            1 => family.clone(),
            _ => format!("{family}[{}]", number + 1),
        };
        let at = model.coordinates.len();
        let own = model.add_coordinate(&name, name.clone(), constraint.span);
        let term = model.pool.times(constraint.expression, own.coordinate);
        let body = model.pool.neg(term);
        let mut coordinates = Vec::new();
        let mut locals = Vec::new();
        for used in model.pool.symbols_of(&[constraint.expression]) {
            if let Some(place) = model.symbols.coordinate(used) {
                coordinates.push(u32::try_from(place).unwrap_or(u32::MAX));
                locals.push(Local::new(used, model.coordinates.at(place).velocity));
            }
        }
        coordinates.push(u32::try_from(at).unwrap_or(u32::MAX));
        locals.push(own);
        model.potential.push(TermFamily::single(constraint.span, body, locals, coordinates));
    }
    Tied { model, visible, kept, dependent }
}

/// What the constraints that are independent of those before them set to zero.
pub fn independent_constraints(model: &Model) -> Vec<ExprId> {
    let (kept, _) = independent(&mut model.clone());
    kept.into_iter().filter_map(|number| model.constraints.get(number)).map(|own| own.expression).collect()
}

/// Which constraints have gradients that are independent of those before them, and which follow from these.
fn independent(model: &mut Model) -> (Vec<usize>, Vec<usize>) {
    let known = known_values(model);
    let bodies: Vec<ExprId> = model.constraints.iter().map(|own| own.expression).collect();
    let bodies = model.pool.substitute(&bodies, &known);
    let Model { pool, symbols, .. } = &mut *model;
    let gradients: Vec<Vec<(usize, ExprId)>> = bodies.iter().map(|body| symbols.slopes(pool, *body)).collect();
    let follows = depend(pool, &gradients);
    // One without a value follows from nothing, which is told where it is evaluated.
    (0..bodies.len()).partition(|number| !follows[*number] || pool.is_undefined(bodies[*number]))
}

/// Which rows are combinations of those before them, at random points; none where all together are too much work.
///
/// A row that is a combination of others at a random point is so everywhere, whatever signs roots have: the constraint is a
/// function of the others. (What is drawn modulo a prime of 61 bits misses an independent row once in 1e18.)
pub(super) fn depend(pool: &Pool, rows: &[Vec<(usize, ExprId)>]) -> Vec<bool> {
    let all: Vec<ExprId> = rows.iter().flatten().map(|(_, entry)| *entry).collect();
    let mut depend: Option<Vec<bool>> = None;
    for values in pool.points_at_random(&all, 1) {
        let mut values = values.into_iter();
        let mut elimination = Elimination::default();
        let depend = depend.get_or_insert_with(|| vec![true; rows.len()]);
        for (row, depends) in rows.iter().zip(depend.iter_mut()) {
            // In order, which slopes come in.
            let row = row.iter().zip(&mut values).map(|((place, _), value)| (*place as u32, value));
            match elimination.add(row.filter(|(_, value)| *value != 0).collect()) {
                Some(is_new) => *depends &= !is_new,
                None => return vec![false; rows.len()],
            }
        }
        if !depend.contains(&true) {
            break;
        }
    }
    depend.unwrap_or_else(|| vec![false; rows.len()])
}

/// What is less beside the largest entry of its row follows no others where they may follow it.
const LEAST_PIVOT: f64 = 1e-3;

/// The directions that constraints allow: q' = Z y'.
///
/// As many coordinates as there are constraints are expressed by the others, which y' consists of.
#[derive(Clone, Debug)]
pub(crate) struct Tangent<S: Scalar> {
    /// By number, ascending: the coordinates that the others follow.
    pub(crate) free: Vec<usize>,
    /// The coordinates that follow.
    pub(super) bound: Vec<usize>,
    /// Per bound coordinate, one entry a free one.
    pub(super) slopes: Vec<Vec<S>>,
}

/// Which coordinates follow the others, of all or of some alone: one for each constraint.
pub(super) fn choose_bound<S: Enclosure>(
    gradients: &[Vec<S>],
    among: Option<&[usize]>,
    precision: S::Precision,
) -> Option<Vec<usize>> {
    eliminate(gradients.to_vec(), largest_among(among), precision).map(|own| own.pivots)
}

/// The same of all coordinates, where it can be of those that move nothing.
pub(super) fn choose_light(gradients: &[Vec<Ball>], moved: &[bool]) -> Option<Vec<usize>> {
    let rank = |column: usize, size: f64| (size > 0.0).then(|| (!moved[column] && size > LEAST_PIVOT, size));
    eliminate(gradients.to_vec(), rank, ()).map(|own| own.pivots)
}

/// The largest pivots that exclude 0, in some columns or in all.
pub(super) fn largest_among(columns: Option<&[usize]>) -> impl Fn(usize, f64) -> Option<f64> {
    move |column, size| (size > 0.0 && columns.is_none_or(|given| given.contains(&column))).then_some(size)
}

/// Gauss-Jordan elimination in enclosures, with a pivot for each row: by the rank of its column and its size beside what else its
/// row has, so that the units of a constraint do not matter; an entry without a rank is none.
pub(super) fn eliminate<S: Enclosure, R: PartialOrd>(
    rows: Vec<Vec<S>>,
    rank: impl Fn(usize, f64) -> Option<R>,
    precision: S::Precision,
) -> Option<Eliminated<S>> {
    let count = rows.len();
    let ranks = |row: &[S]| {
        let sizes: Vec<f64> = row.iter().map(S::certain_size).collect();
        let largest = sizes.iter().copied().fold(0.0, f64::max);
        sizes.into_iter().enumerate().map(|(column, size)| rank(column, size / largest)).collect()
    };
    Some(precision::eliminate(rows, ranks, precision)).filter(|own| own.pivots.len() == count)
}

/// Gauss-Jordan elimination with the largest pivots in given columns, one a row, which are brought to that order; `size` is positive for what
/// may be divided by.
pub(super) fn solve_for<S: Scalar>(
    rows: &mut [Vec<S>],
    columns: impl IntoIterator<Item = usize>,
    size: impl Fn(&S) -> f64,
    precision: S::Precision,
) -> Option<()> {
    for (at, column) in columns.into_iter().enumerate() {
        let largest = |a: &usize, b: &usize| size(&rows[*a][column]).total_cmp(&size(&rows[*b][column]));
        let pivot = (at..rows.len()).max_by(largest).filter(|row| size(&rows[*row][column]) > 0.0)?;
        rows.swap(at, pivot);
        clear_column(rows, at, column, precision);
    }
    Some(())
}

/// The solution of linear equations, each with its right side for a last entry; `None` where they
/// are not shown to have just one.
pub(crate) fn solve<S: Enclosure>(equations: Vec<Vec<S>>, precision: S::Precision) -> Option<Vec<S>> {
    let unknowns: Vec<usize> = (0..equations.len()).collect();
    let Eliminated { pivots, rows } = eliminate(equations, largest_among(Some(&unknowns)), precision)?;
    let mut solution: Vec<Option<S>> = vec![None; unknowns.len()];
    for (pivot, row) in pivots.iter().zip(&rows) {
        solution[*pivot] = row.last().cloned();
    }
    solution.into_iter().collect()
}

impl Tangent<Ball> {
    /// All components of a shape of the exponent s, from those that the others follow: of these z it is (s + γ) z = (s Z - β) y, with -β and -γ
    /// side by side in `drift`, of which γ is nilpotent.
    pub(crate) fn carried(&self, drift: &[Vec<Ball>], s: &Complex<Ball>, y: &[Complex<Ball>]) -> Vec<Complex<Ball>> {
        let zero = Complex::zero(());
        let sum = |row: &[Ball], x: &[Complex<Ball>]| {
            row.iter().zip(x).fold(zero, |sum, (factor, x)| sum.add(&x.times(factor)))
        };
        let mut all = y.to_vec();
        all.resize(y.len() + self.bound.len(), zero);
        for _ in 0..=self.bound.len() {
            let next = self.slopes.iter().zip(drift).map(|(slopes, row)| sum(slopes, y).add(&sum(row, &all).div(s)));
            let next: Vec<Complex<Ball>> = next.collect();
            all[y.len()..].clone_from_slice(&next);
        }
        let mut placed = vec![zero; all.len()];
        self.free.iter().chain(&self.bound).zip(all).for_each(|(place, own)| placed[*place] = own);
        placed
    }
}

impl Tangent<Big> {
    /// The same in balls.
    pub(crate) fn to_balls(&self) -> Tangent<Ball> {
        let row = |row: &Vec<Big>| row.iter().map(Big::to_ball).collect();
        let slopes = self.slopes.iter().map(row).collect();
        Tangent { free: self.free.clone(), bound: self.bound.clone(), slopes }
    }
}

impl<S: Scalar> Tangent<S> {
    /// From gradients by `n` coordinates solved for those that follow, one row each; without any all directions.
    pub(super) fn solved(n: usize, rows: &[Vec<S>], bound: Vec<usize>) -> Self {
        let free: Vec<usize> = (0..n).filter(|at| !bound.contains(at)).collect();
        let slopes = rows.iter().map(|row| free.iter().map(|at| row[*at].neg()).collect()).collect();
        Self { free, bound, slopes }
    }

    /// ZᵀAZ for a matrix (column by column) whose first rows and columns are those of the coordinates.
    pub(crate) fn reduce(&self, matrix: &[S], order: usize) -> Vec<S> {
        let (n, m) = (self.free.len() + self.bound.len(), self.free.len());
        self.image(&self.image(matrix, order, n), m, m)
    }

    /// (AZ)ᵀ, column by column, for the first rows of a matrix that has so many altogether.
    fn image(&self, matrix: &[S], order: usize, rows: usize) -> Vec<S> {
        let mut image = Vec::with_capacity(rows * self.free.len());
        for row in 0..rows {
            for (column, own) in self.free.iter().enumerate() {
                let mut sum = matrix[row + order * own].clone();
                for (bound, slopes) in self.bound.iter().zip(&self.slopes) {
                    let entry = &matrix[row + order * bound];
                    if !entry.is_exact_zero() && !slopes[column].is_exact_zero() {
                        sum = sum.add(&entry.mul(&slopes[column]));
                    }
                }
                image.push(sum);
            }
        }
        image
    }

    /// The same for a symmetric matrix: what encloses an entry encloses its mirror image.
    pub(crate) fn reduce_symmetric(&self, matrix: &[S], order: usize) -> Vec<S> {
        let m = self.free.len();
        let mut reduced = self.reduce(matrix, order);
        for column in 0..m {
            for row in 0..column {
                reduced[row + m * column] = reduced[column + m * row].clone();
            }
        }
        reduced
    }

    /// The components of a direction that the constraints allow, for the free coordinates.
    pub(crate) fn restrict(&self, vector: &[S]) -> Vec<S> {
        self.free.iter().map(|at| vector[*at].clone()).collect()
    }
}

impl<S: Enclosure> Tangent<S> {
    /// From the gradients of the constraints, one row each, and the coordinates that are to follow;
    /// `None` where these can't be shown to.
    pub(crate) fn new(gradients: &[Vec<S>], bound: &[usize], precision: S::Precision) -> Option<Self> {
        let Eliminated { pivots, rows } = eliminate(gradients.to_vec(), largest_among(Some(bound)), precision)?;
        Some(Self::solved(rows.first().map_or(0, Vec::len), &rows, pivots))
    }

    /// Z, one row a coordinate.
    pub(super) fn rows(&self, precision: S::Precision) -> Vec<Vec<S>> {
        let m = self.free.len();
        let mut rows = vec![vec![S::exact(0.0, precision); m]; m + self.bound.len()];
        for (column, own) in self.free.iter().enumerate() {
            rows[*own][column] = S::exact(1.0, precision);
        }
        for (bound, slopes) in self.bound.iter().zip(&self.slopes) {
            rows[*bound].clone_from(slopes);
        }
        rows
    }

    /// Z y for a y whose components are off by up to `error`, and what those of Z y are off by: for a row z
    /// of Z and its enclosure z~ ± r at most |z| error + r |y|, and m u |z~| |y| for a sum of m products of doubles
    /// (Higham, Accuracy and Stability of Numerical Algorithms (2002), section 3.1).
    pub(crate) fn embed(&self, motion: &[f64], error: f64) -> (Vec<f64>, f64) {
        let m = self.free.len() as f64;
        let mut vector = vec![0.0; self.free.len() + self.bound.len()];
        for (own, y) in self.free.iter().zip(motion) {
            vector[*own] = *y;
        }
        let mut worst = error;
        for (bound, slopes) in self.bound.iter().zip(&self.slopes) {
            let (mut sum, mut off) = (0.0, 0.0);
            for (slope, y) in slopes.iter().zip(motion) {
                let middle = slope.mid_f64();
                let rounding = (m + 1.0) * f64::EPSILON * middle.abs();
                sum += middle * y;
                off += slope.abs_upper() * error + (slope.mid_f64_error() + rounding) * y.abs();
            }
            vector[*bound] = sum;
            // The factor covers the rounding of the bound itself.
            worst = worst.max(off * (1.0 + (2.0 * m + 8.0) * f64::EPSILON));
        }
        (vector, worst)
    }
}

/// The rows -∂c/∂q of second derivatives of U, from all of them (column by column).
pub(crate) fn gradients<S: Scalar>(second: &[S], visible: usize, order: usize) -> Vec<Vec<S>> {
    (visible..order).map(|row| (0..visible).map(|column| second[row + order * column].clone()).collect()).collect()
}

/// What the sides of a constraint differ by at a point; `None` where parameters have no values.
pub(crate) fn difference(model: &Model, number: usize, at: &[Ball]) -> Option<Ball> {
    let mut pool = model.pool.clone();
    let expression = pool.substitute_one(model.constraints.get(number)?.expression, &known_values(model));
    Formulas::new(model, &pool, &[expression])?.at(model, at, ())?.first().copied()
}
