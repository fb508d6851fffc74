//! The matrices that go with velocities, and what friction does at rest.
//!
//! A term a(q)·q' of L gives G_ij = ∂a_i/∂q_j - ∂a_j/∂q_i. Rayleigh's function F gives the damping
//! C = ∂²F/∂q'∂q' and, where friction drags along with a medium that moves, forces -∂F/∂q' at rest
//! and the circulatory matrix N_ij = ∂²F/∂q_i'∂q_j. A generalised force Q_i adds -Q_i at rest, -∂Q_i/∂q_j to N, and of
//! -∂Q_i/∂q_j' the symmetric part to C and the rest to G. As with energies, a family of terms is differentiated
//! once and its instances are scattered.

use super::assemble::{Assembly, Values};
use super::elements::{Splitter, elements};
use super::error::LinearizeError;
use super::facts::{Facts, Variable};
use super::inputs::Inputs;
use super::symbolic;
use crate::expr::{ExprId, Node, Pool, Symbol, Tape};
use crate::model::{Model, TermFamily, slopes_by};
use crate::number::Number;
use crate::precision::{Ball, Big, Function, Scalar};

/// Which matrix an entry belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Matrix {
    /// G: entered with its mirror image of opposite sign.
    Gyroscopic,
    /// C.
    Damping,
    /// N.
    Circulatory,
}

/// Derivatives of one family, ready to be evaluated.
#[derive(Clone, Debug)]
pub(crate) struct VelocityFamily {
    pub(super) terms: TermFamily,
    pub(super) inputs: Inputs,
    pub(super) derivatives: Derivatives,
    /// One output for each entry.
    tape: Tape,
    rest_tape: Tape,
}

/// The sum of two matrices of which one or both may not be there.
pub(super) fn sum<S: Scalar>(left: Option<Vec<S>>, right: Option<Vec<S>>) -> Option<Vec<S>> {
    match (left, right) {
        (Some(left), Some(right)) => Some(left.iter().zip(&right).map(|(x, y)| x.add(y)).collect()),
        (one, None) | (None, one) => one,
    }
}

/// M, G, C, K and N column by column, where they are there.
pub(super) type Numbers<S> = [Option<Vec<S>>; 5];

impl VelocityFamily {
    /// Compiles; `number` gives each constant of an instance its number.
    pub(super) fn new(
        model: &Model,
        terms: TermFamily,
        derivatives: Derivatives,
        number: &mut impl FnMut(ExprId) -> u32,
    ) -> Option<Self> {
        let all = derivatives.expressions();
        if all.is_empty() {
            return None;
        }
        let (expressions, rest) = all.split_at(derivatives.entries.len());
        let inputs = Inputs::new(model, &all, terms.constants.iter().map(|constant| number(*constant)).collect());
        Some(Self {
            tape: inputs.tape(model, &model.pool, &terms, expressions)?,
            rest_tape: inputs.tape(model, &model.pool, &terms, rest)?,
            terms,
            inputs,
            derivatives,
        })
    }

    /// Whether friction acts at rest, somewhere.
    pub(super) fn acts_at_rest(&self) -> bool {
        !self.derivatives.rest.is_empty()
    }

    fn is_of(&self, matrix: Matrix) -> bool {
        self.derivatives.entries.iter().any(|(own, ..)| *own == matrix)
    }

    /// The entries of D = G + C by local variables: row, column and share.
    pub(super) fn velocity_rows(&self, pool: &mut Pool) -> Vec<(usize, usize, ExprId)> {
        let mut rows = Vec::new();
        for (matrix, i, j, entry) in &self.derivatives.entries {
            match matrix {
                Matrix::Damping => rows.push((*i, *j, *entry)),
                Matrix::Gyroscopic => rows.extend([(*i, *j, *entry), (*j, *i, pool.neg(*entry))]),
                Matrix::Circulatory => {}
            }
        }
        rows
    }

    /// The factors of the squares that F is a sum of at rest, with the parameters in them; `None` where it is none.
    fn strengths(&self, model: &Model) -> Option<(Tape, Inputs)> {
        let mut pool = model.pool.clone();
        let velocities: Vec<Symbol> = self.terms.locals.iter().map(|local| local.velocity).collect();
        let mut splitter = Splitter::about(&self.terms.locals);
        let at_rest = self.terms.at_rest(&pool);
        let mut factors = Vec::new();
        for element in elements(&mut pool, &mut splitter, self.terms.body, &velocities, Variable::Velocity) {
            let element = element.at_rest(&mut pool, &mut splitter.facts, &at_rest);
            if !(element.first.is_zero() || element.curvature.is_empty()) {
                return None;
            }
            factors.push(element.second);
        }
        let inputs = self.inputs.of_others(model, &factors);
        Some((inputs.tape(model, &pool, &self.terms, &factors)?, inputs))
    }

    /// The first instance whose entries at a point are not finite.
    pub(super) fn not_finite<S: Scalar>(&self, at: &[S], values: &Values<S>) -> Option<usize> {
        let mut found = None;
        self.inputs.run(&self.terms, &self.tape, at, values, |instance, numbers, _| {
            if !numbers.iter().all(S::is_finite) {
                found.get_or_insert(instance);
            }
        });
        found
    }
}

/// Refuses a dissipation with a corner at rest: a modulus, a root or a quotient of what vanishes there, and second derivatives that are
/// not defined.
pub(super) fn check_smooth(model: &Model) -> Result<(), LinearizeError> {
    let mut facts = Facts::about(model.forces.iter().flat_map(|family| &family.locals));
    let pool = &model.pool;
    for family in &model.forces {
        for id in pool.reachable(&[family.body]) {
            let sharp = match pool.node(id) {
                Node::Function(Function::Abs, x) => facts.rests(pool, *x),
                Node::Product(factors) => factors.iter().any(|(base, power)| {
                    let smooth = power.is_integer() && !power.is_negative();
                    !smooth && facts.rests(pool, *base)
                }),
                _ => false,
            };
            if sharp && !has_derivatives(pool, family) {
                let what = if family.acts_on.is_some() { "the force" } else { "the dissipation" };
                return Err(LinearizeError::FrictionNotSmooth { what, part: pool.display(id), span: family.span });
            }
        }
    }
    Ok(())
}

/// Whether the second derivatives by the velocities have values at rest: they do for |v|³.
fn has_derivatives(pool: &Pool, family: &TermFamily) -> bool {
    let mut pool = pool.clone();
    Derivatives::friction(&mut pool, family).expressions().into_iter().all(|entry| !pool.is_undefined(entry))
}

/// What a family of terms is differentiated to.
#[derive(Clone, Debug)]
pub(super) struct Derivatives {
    /// Matrix, row and column (by local variable), and the entry.
    entries: Vec<(Matrix, usize, usize, ExprId)>,
    /// ∂F/∂q' at rest: by local variable.
    pub(super) rest: Vec<(usize, ExprId)>,
}

impl Derivatives {
    /// Those of the entries, then those at rest.
    pub(super) fn expressions(&self) -> Vec<ExprId> {
        let entries = self.entries.iter().map(|(.., e)| *e);
        entries.chain(self.rest.iter().map(|(_, e)| *e)).collect()
    }

    /// Of the coefficients of velocities in L, by local variable.
    pub(super) fn gyroscopic(pool: &mut Pool, terms: &TermFamily, coefficients: &[(usize, ExprId)]) -> Self {
        let coordinates: Vec<Symbol> = terms.locals.iter().map(|local| local.coordinate).collect();
        let mut entries = Vec::new();
        for (i, coefficient) in coefficients {
            let slopes = slopes_by(pool, *coefficient, &coordinates).into_iter().filter(|(j, _)| j != i);
            entries.extend(slopes.map(|(j, slope)| (Matrix::Gyroscopic, *i, j, slope)));
        }
        Self { entries, rest: Vec::new() }
    }

    /// Of F, or of a generalised force.
    pub(super) fn friction(pool: &mut Pool, family: &TermFamily) -> Self {
        let coordinates: Vec<Symbol> = family.locals.iter().map(|local| local.coordinate).collect();
        let velocities: Vec<Symbol> = family.locals.iter().map(|local| local.velocity).collect();
        let at_rest = family.at_rest(pool);
        let (mut entries, mut rest) = (Vec::new(), Vec::new());
        for (i, mut force) in family.drags(pool) {
            let at_rest_slopes = |pool: &mut Pool, force| {
                let slopes = slopes_by(pool, force, &velocities).into_iter();
                slopes.map(|(j, entry)| (j, pool.substitute_one(entry, &at_rest))).collect::<Vec<_>>()
            };
            let mut slopes = at_rest_slopes(pool, force);
            if slopes.iter().any(|(_, entry)| pool.is_undefined(*entry)) {
                force = slow(pool, family, force);
                slopes = at_rest_slopes(pool, force);
            }
            for (j, entry) in slopes {
                if entry.is_zero() {
                    continue;
                }
                if family.acts_on.is_none() || i == j {
                    entries.push((Matrix::Damping, i, j, entry));
                    continue;
                }
                let half = pool.scale(entry, &Number::half());
                entries.push((Matrix::Damping, i, j, half));
                entries.push((Matrix::Damping, j, i, half));
                entries.push((Matrix::Gyroscopic, i, j, half));
            }
            let force = pool.substitute_one(force, &at_rest);
            for (j, entry) in slopes_by(pool, force, &coordinates) {
                entries.push((Matrix::Circulatory, i, j, entry));
            }
            if !force.is_zero() {
                rest.push((i, force));
            }
        }
        Self { entries, rest }
    }
}

/// A force without those terms that become 0 faster than the velocities do, as v |v| does: their derivatives at rest are 0, also
/// where rules of differentiation find 0/0.
fn slow(pool: &mut Pool, family: &TermFamily, force: ExprId) -> ExprId {
    let mut facts = Facts::about(&family.locals);
    let mut terms = pool.terms(force);
    terms.retain(|(term, _)| facts.of(pool, *term).order <= 1.0);
    let parts: Vec<ExprId> = terms.iter().map(|(term, factor)| pool.scale(*term, factor)).collect();
    pool.sum(&parts)
}

impl Assembly {
    /// Leaves out of G, and of C where generalised forces have a part in it, what is proved to vanish at a point of
    /// expressions: where a term of L is a total time derivative, and where parts of forces cancel.
    pub(super) fn forget_what_vanishes(&mut self, model: &mut Model, point: &[ExprId]) {
        for matrix in [Matrix::Gyroscopic, Matrix::Damping] {
            let forced = |family: &VelocityFamily| matrix == Matrix::Gyroscopic || family.terms.acts_on.is_some();
            if self.velocity.iter().any(|family| forced(family) && family.is_of(matrix))
                && symbolic::vanishes(model, self, matrix, point)
            {
                self.vanishing.push(matrix);
                let vanishing = &self.vanishing;
                let left = |family: &VelocityFamily| {
                    family.derivatives.entries.iter().any(|(own, ..)| !vanishing.contains(own))
                };
                self.velocity.retain(|family| family.acts_at_rest() || left(family));
            }
        }
    }

    /// ∂F/∂q' at rest is added to a gradient.
    pub(super) fn add_friction_at_rest<S: Scalar>(&self, at: &[S], values: &Values<S>, gradient: &mut [S]) {
        for family in self.velocity.iter().filter(|family| family.acts_at_rest()) {
            family.inputs.run(&family.terms, &family.rest_tape, at, values, |instance, numbers, _| {
                let coordinates = family.terms.coordinates_of(instance);
                for ((place, _), number) in family.derivatives.rest.iter().zip(numbers) {
                    let entry = &mut gradient[coordinates[*place] as usize];
                    *entry = entry.add(number);
                }
            });
        }
    }

    /// What adds up to G, C or N: row, column and share, often several for one entry.
    pub(super) fn velocity_entries<S: Scalar>(
        &self,
        matrix: Matrix,
        at: &[S],
        values: &Values<S>,
        share: &mut dyn FnMut(usize, usize, S),
    ) {
        if let Some((at, wide)) = values.wide(at) {
            self.velocity_entries(matrix, &at, wide, &mut |i, j, own: Big| {
                if let Some(own) = S::from_wide(&own) {
                    share(i, j, own);
                }
            });
            return;
        }
        if self.vanishing.contains(&matrix) {
            return;
        }
        for family in self.velocity.iter().filter(|family| family.is_of(matrix)) {
            family.inputs.run(&family.terms, &family.tape, at, values, |instance, numbers, _| {
                let coordinates = family.terms.coordinates_of(instance);
                for ((own, i, j, _), number) in family.derivatives.entries.iter().zip(numbers) {
                    if *own != matrix || number.is_exact_zero() {
                        continue;
                    }
                    let (i, j) = (coordinates[*i] as usize, coordinates[*j] as usize);
                    if matrix == Matrix::Gyroscopic {
                        // Nothing is left on the diagonal.
                        if i == j {
                            continue;
                        }
                        share(j, i, number.neg());
                    }
                    share(i, j, number.clone());
                }
            });
        }
    }

    /// G, C or N, dense, column by column; `None` where no term contributes.
    pub(crate) fn velocity_matrix<S: Scalar>(&self, matrix: Matrix, at: &[S], values: &Values<S>) -> Option<Vec<S>> {
        // Shares that cancel are added up before they are rounded.
        if let Some((at, wide)) = values.wide(at) {
            let found = self.velocity_matrix(matrix, &at, wide)?;
            return Some(found.iter().filter_map(S::from_wide).collect());
        }
        let n = self.dimension;
        let zero = S::from_number(&Number::ZERO, values.precision());
        let mut result: Option<Vec<S>> = None;
        self.velocity_entries(matrix, at, values, &mut |i, j, number| {
            let entries = result.get_or_insert_with(|| vec![zero.clone(); n * n]);
            entries[i + n * j] = entries[i + n * j].add(&number);
        });
        result
    }

    /// All matrices at a point.
    pub(super) fn matrices<S: Scalar>(&self, at: &[S], values: &Values<S>) -> Numbers<S> {
        let of = |matrix| self.velocity_matrix(matrix, at, values);
        let [gyroscopic, damping, circulatory] = [Matrix::Gyroscopic, Matrix::Damping, Matrix::Circulatory].map(of);
        [Some(self.mass(at, values)), gyroscopic, damping, Some(self.stiffness(at, values)), circulatory]
    }

    /// Whether C is not negative, exactly: a sum of squares of velocities with factors that are not, and of forces on a coordinate against
    /// its own velocity.
    pub(super) fn is_passive(&self, model: &Model, at: &[Ball], values: &Values<Ball>) -> bool {
        self.velocity.iter().filter(|family| family.is_of(Matrix::Damping)).all(|family| {
            let damping = |tape: &Tape, inputs: &Inputs, chosen: &dyn Fn(usize) -> bool| {
                let mut fine = true;
                inputs.run(&family.terms, tape, at, values, |_, numbers, _| {
                    let mut own = numbers.iter().enumerate().filter(|(k, _)| chosen(*k));
                    fine &= own.all(|(_, x)| x.is_zero() || x.is_positive());
                });
                fine
            };
            if family.terms.acts_on.is_some() {
                let entries = &family.derivatives.entries;
                let is_damping = |k: usize| entries[k].0 == Matrix::Damping;
                let diagonal = entries.iter().all(|(own, i, j, _)| *own != Matrix::Damping || i == j);
                return diagonal && damping(&family.tape, &family.inputs, &is_damping);
            }
            family.strengths(model).is_some_and(|(tape, inputs)| damping(&tape, &inputs, &|_| true))
        })
    }

    /// The entries of G, C or N as expressions: row, column and share.
    pub(crate) fn velocity_expressions(
        &self,
        matrix: Matrix,
    ) -> impl Iterator<Item = (&TermFamily, usize, usize, ExprId)> {
        let there = !self.vanishing.contains(&matrix);
        self.velocity.iter().filter(move |_| there).flat_map(move |family| {
            let own = family.derivatives.entries.iter().filter(move |(own, ..)| *own == matrix);
            own.map(move |(_, i, j, e)| (&family.terms, *i, *j, *e))
        })
    }

    /// ∂F/∂q' at rest as expressions.
    pub(crate) fn friction_at_rest(&self) -> impl Iterator<Item = (&TermFamily, usize, ExprId)> {
        let families = self.velocity.iter();
        families.flat_map(|family| family.derivatives.rest.iter().map(move |(place, e)| (&family.terms, *place, *e)))
    }

    /// Which coordinates no generalised force acts on at rest, nor friction.
    pub(super) fn without_force_at_rest(&self, coordinates: usize) -> Vec<bool> {
        let mut free = vec![true; coordinates];
        for (terms, place, _) in self.friction_at_rest() {
            (0..terms.count).for_each(|instance| free[terms.coordinates_of(instance)[place] as usize] = false);
        }
        free
    }

    /// Whether friction acts at rest, somewhere.
    pub(crate) fn acts_at_rest(&self) -> bool {
        self.velocity.iter().any(VelocityFamily::acts_at_rest)
    }
}
