//! M, K, G, C and N at the equilibrium, dense or sparse, added up from the elements.

use super::Linearized;
use super::assemble::Part;
use super::constrained::Tangent;
use super::velocity::{Matrix, sum};
use crate::precision::{Ball, SparseMatrix};

impl Linearized {
    /// The same with coordinates without inertia among the others, not following them: for forces that act on them.
    #[must_use]
    pub fn with_massless(&self) -> Self {
        Self { massless: None, flow: None, ..self.clone() }
    }

    /// The same with multipliers of constraints among the coordinates, which are behind the others; `None` under conditions on
    /// velocities.
    #[must_use]
    pub fn bordered(&self) -> Option<Self> {
        let own = self.rolling().is_none().then(|| self.with_massless())?;
        Some(Self { constrained: None, ..own })
    }

    /// What the motions consist of that constraints allow, one row a coordinate and one column for each that the matrices have;
    /// `None` where these are all coordinates, and where massless ones follow.
    #[must_use]
    pub fn directions(&self) -> Option<Vec<Vec<Ball>>> {
        let own = self.constrained.as_ref().filter(|_| self.is_constrained() && self.massless().is_none());
        own.map(|own| own.tangent.rows(()))
    }

    /// The mass matrix, dense, column by column, in SI.
    #[must_use]
    pub fn mass(&self) -> Vec<Ball> {
        if let Some((_, [mass, ..])) = self.rolled_numbers() {
            return mass.clone().unwrap_or_default();
        }
        let mass = self.assembly.mass(&self.equilibrium.values, &self.values);
        self.reduced(mass, Tangent::reduce_symmetric)
    }

    /// The stiffness matrix, dense, column by column, in SI: symmetric, without what friction at rest adds
    /// to it ([`Linearized::circulatory`]).
    #[must_use]
    pub fn stiffness(&self) -> Vec<Ball> {
        if let Some((_, [_, _, _, stiffness, _])) = self.rolled_numbers() {
            return stiffness.clone().unwrap_or_default();
        }
        let stiffness = self.assembly.stiffness(&self.equilibrium.values, &self.values);
        self.reduced(stiffness, Tangent::reduce_symmetric)
    }

    /// How many shares of entries are added up in [`Linearized::sparse`], at most.
    pub(crate) fn shares(&self) -> u64 {
        self.assembly.shares()
    }

    /// M and K as sparse matrices, in SI: K symmetric, as [`Linearized::stiffness`]. `None` under constraints, and where
    /// massless coordinates follow the others.
    #[must_use]
    pub fn sparse(&self) -> Option<(SparseMatrix, SparseMatrix)> {
        if self.is_reduced() { None } else { self.whole() }
    }

    /// The same of all coordinates as if nothing tied them. `None` under conditions on velocities.
    pub(crate) fn whole(&self) -> Option<(SparseMatrix, SparseMatrix)> {
        if !self.model.rolling.is_empty() {
            return None;
        }
        let (at, n) = (&self.equilibrium.values, self.coordinates());
        let added = |part| {
            let mut shares = Vec::with_capacity(self.assembly.shares_of(part) as usize);
            // Multipliers stand behind.
            let is_own = |i: u32, j: u32| (i.max(j) as usize) < n;
            self.assembly.entries(part, at, &self.values, |i, j, share| {
                shares.extend(is_own(i, j).then_some((i, j, *share)));
            });
            SparseMatrix::from_shares(n, &shares)
        };
        Some((added(Part::Inertia), added(Part::Stiffness)))
    }

    /// A matrix for the motions that are left, which `step` takes from so many coordinates to those that they follow.
    fn reduced(&self, matrix: Vec<Ball>, step: impl Fn(&Tangent<Ball>, &[Ball], usize) -> Vec<Ball>) -> Vec<Ball> {
        let all = (matrix, self.model.coordinates.len());
        self.tangents().fold(all, |(matrix, order), own| (step(own, &matrix, order), own.free.len())).0
    }

    fn of_velocities(&self, matrix: Matrix) -> Option<Vec<Ball>> {
        if let Some((_, [_, gyroscopic, damping, _, circulatory])) = self.rolled_numbers() {
            return match matrix {
                Matrix::Gyroscopic => gyroscopic.clone(),
                Matrix::Damping => damping.clone(),
                Matrix::Circulatory => circulatory.clone(),
            };
        }
        let matrix = self.assembly.velocity_matrix(matrix, &self.equilibrium.values, &self.values)?;
        Some(self.reduced(matrix, Tangent::reduce))
    }

    /// G, C or N with all entries that are not exactly 0.
    pub(super) fn sparse_of_velocities(&self, matrix: Matrix) -> SparseMatrix {
        let n = self.dimension();
        let mut shares: Vec<(u32, u32, Ball)> = Vec::new();
        let mut share = |i: usize, j: usize, value: Ball| shares.push((i as u32, j as u32, value));
        if self.is_reduced() || self.units().is_some() {
            let dense = self.of_velocities(matrix).unwrap_or_default();
            dense.into_iter().enumerate().for_each(|(at, value)| share(at % n, at / n, value));
        } else {
            self.assembly.velocity_entries(matrix, &self.equilibrium.values, &self.values, &mut share);
        }
        SparseMatrix::from_shares(n, &shares)
    }

    /// G + C and N as sparse matrices, in SI, of which all entries are stored; where [`Linearized::sparse`] has the others.
    pub(crate) fn sparse_velocity(&self) -> [SparseMatrix; 2] {
        let [gyroscopic, damping, circulatory] =
            [Matrix::Gyroscopic, Matrix::Damping, Matrix::Circulatory].map(|matrix| self.sparse_of_velocities(matrix));
        [gyroscopic.plus(&damping), circulatory]
    }

    /// Whether friction takes energy from every motion or leaves it, exactly; `false` where that is not known.
    pub(crate) fn is_passive(&self) -> bool {
        self.assembly.is_passive(&self.model, &self.equilibrium.values, &self.values)
    }

    /// The gyroscopic matrix G, dense, column by column, in SI; `None` without terms that give one.
    #[must_use]
    pub fn gyroscopic(&self) -> Option<Vec<Ball>> {
        self.of_velocities(Matrix::Gyroscopic)
    }

    /// The damping matrix C, dense, column by column, in SI; `None` without friction.
    #[must_use]
    pub fn damping(&self) -> Option<Vec<Ball>> {
        self.of_velocities(Matrix::Damping)
    }

    /// The circulatory matrix N, dense, column by column, in SI: what friction that acts at rest adds to
    /// the stiffness. `None` where there is none.
    #[must_use]
    pub fn circulatory(&self) -> Option<Vec<Ball>> {
        self.of_velocities(Matrix::Circulatory)
    }

    /// G + C and K + N, dense, column by column, in SI.
    #[must_use]
    pub fn velocity_and_stiffness(&self) -> (Vec<Ball>, Vec<Ball>) {
        let stiffness = sum(Some(self.stiffness()), self.circulatory()).unwrap_or_default();
        let velocity = sum(self.gyroscopic(), self.damping());
        (velocity.unwrap_or_else(|| vec![Ball::ZERO; stiffness.len()]), stiffness)
    }
}
