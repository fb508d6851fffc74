//! From the exact integrals of a body to its mass, centre of mass and tensor.

use super::principal::{Entries, Exact, Principal, bigs};
use super::{InertiaError, square};
use librate_core::expr::{ExprId, Pool};
use librate_core::model::Constant;
use librate_core::number::Number;
use librate_core::precision::Big;

/// What a body is made of.
#[derive(Clone, Debug)]
pub enum Made {
    /// Points with masses.
    Points {
        /// How many.
        count: usize,
    },
    /// A solid of one density between triangles.
    #[non_exhaustive]
    Solid {
        /// How many triangles, those without area left out.
        triangles: usize,
        /// Triangles with coinciding corners, which bound nothing.
        left_out: usize,
        /// Closed surfaces that share no vertex; those of cavities count.
        surfaces: usize,
        /// How many of them bound cavities.
        cavities: usize,
        /// The volume, in the cube of the file's unit of length.
        volume: Box<Big>,
        /// The density, given or mass over volume.
        density: Box<Big>,
        /// Whether the density is the one that is taken where nobody says anything, 1.
        by_default: bool,
    },
}

/// A rigid body: its mass and how that is spread.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Body {
    /// What it is made of.
    pub made: Made,
    /// The mass.
    pub mass: Big,
    /// The centre of mass.
    pub centre: [Big; 3],
    /// The tensor of inertia about the centre of mass, by row, along the axes of the file.
    pub tensor: [[Big; 3]; 3],
    /// Principal moments and axes of that tensor.
    pub principal: Principal,
}

/// How heavy a solid is.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub enum Amount {
    /// A density of 1, in the file's units.
    #[default]
    Unit,
    /// So much mass per volume.
    Density(Constant),
    /// So much mass in all.
    Mass(Constant),
}

/// ∫ dV, ∫ r dV, ∫ r rᵀ dV, or sums over points with masses in place of volumes.
#[derive(Clone, Debug, Default)]
pub(super) struct Sums {
    pub(super) size: Number,
    pub(super) first: [Number; 3],
    pub(super) second: [[Number; 3]; 3],
}

/// Sums and a density.
pub(super) struct Integrals {
    sums: Sums,
    /// Where the density lives.
    pool: Pool,
    density: ExprId,
    made: Made,
}

/// Bits that hold so many digits and a few more.
pub(super) fn bits_for(digits: usize) -> usize {
    4 * digits + 128
}

impl Integrals {
    /// With a density of 1.
    pub(super) fn new(sums: Sums, made: Made) -> Self {
        let pool = Pool::new();
        Self { sums, density: pool.one(), pool, made }
    }

    /// The density of a solid of this volume.
    pub(super) fn with_amount(mut self, amount: &Amount) -> Self {
        let (constant, per) = match amount {
            Amount::Unit => return self,
            Amount::Density(constant) => (constant, Number::ONE),
            // The volume is positive: a mesh without is refused.
            Amount::Mass(constant) => (constant, self.sums.size.recip().unwrap_or_default()),
        };
        self.pool = constant.pool().clone();
        self.density = self.pool.scale(constant.value(), &per);
        if let Made::Solid { by_default, .. } = &mut self.made {
            *by_default = false;
        }
        self
    }

    /// Mass, centre, tensor about the centre (Steiner's theorem) and principal moments.
    pub(super) fn body(mut self, digits: usize) -> Result<Body, InertiaError> {
        let Sums { size, first, second } = &self.sums;
        let per_size = size.recip().unwrap_or_default();
        let centre: [Number; 3] = [0, 1, 2].map(|i| first[i].mul(&per_size));
        // ∫ (r - c)(r - c)ᵀ = ∫ r rᵀ - c ∫ rᵀ.
        let spread = |i: usize, j: usize| second[i][j].sub(&centre[i].mul(&first[j]));
        let trace = spread(0, 0).add(&spread(1, 1)).add(&spread(2, 2));
        // I = tr(J) 1 - J.
        let entries = square(|i, j| {
            let own = spread(i, j);
            if i == j { trace.sub(&own) } else { own.neg() }
        });
        let closed: Entries = square(|i, j| self.pool.scale(self.density, &entries[i][j]));
        let mass = self.pool.scale(self.density, size);
        let mut wanted = vec![mass, self.density];
        wanted.extend(centre.iter().map(|x| self.pool.number(x.clone())));
        wanted.extend(closed.as_flattened());
        let bits = bits_for(digits);
        let values = bigs(&self.pool, &wanted, bits);
        let value = |at: usize| values[at].clone();
        let mut made = self.made;
        if let Made::Solid { volume, density, .. } = &mut made {
            **volume = Big::from_number(size, bits);
            **density = value(1);
        }
        let mut exact = Exact { pool: &mut self.pool, symbolic: closed, closed };
        let principal = exact.principal(digits, |_, _| InertiaError::OutOfRange {})?;
        Ok(Body {
            made,
            mass: value(0),
            centre: [0, 1, 2].map(|i| value(2 + i)),
            tensor: square(|i, j| value(5 + 3 * i + j)),
            principal,
        })
    }
}
