//! Zero modes are proved: motions along which the potential does not change to second order.
//!
//! [`Symmetry`] gives those that hold everywhere. What the exact
//! matrix K of rational numbers shows beyond that is added ([`exact`], at any size), and what counting unstressed elements
//! shows ([`mechanism`]). Smallness of a number proves nothing
//! and is never asked for.

use super::assemble::{Assembly, Values};
use super::radicals::Surd;
use super::symmetry::{Symmetry, symmetries};
use super::{Linearized, exact, mechanism};
use crate::expr::Pool;
use crate::precision::{Ball, Enclosure, subtract};

/// What a zero mode is that no symmetry explains.
pub const NO_FORCE: &str = "no restoring force to second order";

/// A motion that is proved to cost no energy to second order.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct ZeroMode<N = Ball> {
    /// A vector of the kernel of K, one component a coordinate.
    pub vector: Vec<N>,
    /// What it is, in words: "translation", "rotation", …
    pub meaning: String,
    ground: Ground,
}

impl<N> ZeroMode<N> {
    /// Whether it is one whatever the values of the parameters are: a symmetry that holds identically.
    pub fn holds_everywhere(&self) -> bool {
        matches!(self.ground, Ground::Symmetry(_))
    }

    /// Whether no force that goes with velocities acts on it, whatever the parameters are.
    pub(super) fn is_unmoved(&self, assembly: &Assembly, pool: &mut Pool) -> bool {
        match &self.ground {
            Ground::Symmetry(own) | Ground::AtValues(own) => own.is_unmoved(assembly, pool),
            Ground::Plain | Ground::Exact(_) | Ground::Mechanism { .. } => false,
        }
    }

    /// The same mode with its vector in other coordinates.
    pub(super) fn mapped(self, map: impl FnOnce(&[N]) -> Vec<N>) -> Self {
        Self { vector: map(&self.vector), ..self }
    }
}

impl ZeroMode {
    /// A vector of numbers that are known exactly.
    pub(super) fn of_no_force(vector: Vec<Ball>) -> Self {
        Self { vector, meaning: NO_FORCE.to_owned(), ground: Ground::Plain }
    }

    /// A vector of the kernel of an exact matrix.
    pub(super) fn of_exact(vector: Vec<Surd>) -> Self {
        let numbers = vector.iter().map(|x| x.in_numbers(())).collect();
        Self { vector: numbers, meaning: NO_FORCE.to_owned(), ground: Ground::Exact(vector) }
    }
}

/// What a zero mode is known by; it gives the vector in any numbers.
#[derive(Clone, Debug)]
enum Ground {
    Symmetry(Symmetry),
    /// A symmetry for these values of the parameters.
    AtValues(Symmetry),
    /// Its vector holds zeros and a one.
    Plain,
    /// K is known exactly, and this is a vector of its kernel.
    Exact(Vec<Surd>),
    /// The kernel of the slopes of unstressed elements: the coordinates that have pivots, and the one
    /// without that this vector belongs to.
    Mechanism {
        pivots: Vec<usize>,
        own: usize,
    },
}

/// The proved zero modes at an equilibrium: linearly independent; of symmetries and loose parts alone where no others are wanted.
pub(crate) fn zero_modes(own: &Linearized, others: bool) -> Vec<ZeroMode> {
    let Linearized { model, assembly, values, .. } = own;
    let at = &own.equilibrium.values;
    let mut sieve = Sieve::default();
    let mut kept = Vec::new();
    let mut add = |kept: &mut Vec<ZeroMode>, mode: ZeroMode| {
        if sieve.accepts(&mode.vector) {
            kept.push(mode);
        }
    };
    // Of ξ·∇U = 0 follows K ξ = -(∂ξ/∂q)ᵀ ∇U, and ∇U is what generalised forces balance.
    let free = assembly.without_force_at_rest(at.len());
    let is_sound = |own: &Symmetry| own.constant().is_some() || own.moves_only(&free);
    for symmetry in symmetries(model, assembly, at, &vec![true; at.len()], false).into_iter().filter(is_sound) {
        let (vector, meaning) = (symmetry.vector(at, ()), symmetry.meaning.clone());
        add(&mut kept, ZeroMode { vector, meaning, ground: Ground::Symmetry(symmetry) });
    }
    if let Some(mechanism::Kernel { pivots, vectors }) = mechanism::kernel(assembly, at, values, None) {
        for (own, vector) in vectors {
            let ground = Ground::Mechanism { pivots: pivots.clone(), own };
            add(&mut kept, ZeroMode { vector, meaning: NO_FORCE.to_owned(), ground });
        }
    }
    if !others {
        return kept;
    }
    for vector in exact::kernel(own, kept.len()).unwrap_or_default() {
        add(&mut kept, ZeroMode::of_exact(vector));
    }
    for symmetry in symmetries(model, assembly, at, &vec![true; at.len()], true).into_iter().filter(is_sound) {
        let vector = symmetry.vector(at, ());
        add(&mut kept, ZeroMode { vector, meaning: NO_FORCE.to_owned(), ground: Ground::AtValues(symmetry) });
    }
    kept
}

/// The same zero modes in other numbers; `None` where these do not do for a mechanism.
pub(crate) fn in_numbers<S: Enclosure>(
    modes: &[ZeroMode],
    assembly: &Assembly,
    at: &[S],
    values: &Values<S>,
) -> Option<Vec<ZeroMode<S>>> {
    let precision = values.precision();
    let mut kernel: Option<mechanism::Kernel<S>> = None;
    let mut found = Vec::with_capacity(modes.len());
    for mode in modes {
        let vector = match &mode.ground {
            Ground::Symmetry(symmetry) | Ground::AtValues(symmetry) => symmetry.vector(at, precision),
            Ground::Plain => mode.vector.iter().map(|x| S::exact(x.mid_f64(), precision)).collect(),
            Ground::Exact(vector) => vector.iter().map(|x| x.in_numbers(precision)).collect(),
            Ground::Mechanism { pivots, own } => {
                if kernel.is_none() {
                    kernel = mechanism::kernel(assembly, at, values, Some(pivots));
                }
                let vector = kernel.as_ref()?.vectors.iter().find(|(other, _)| other == own);
                vector.map(|(_, vector)| vector.clone())?
            }
        };
        found.push(ZeroMode { vector, meaning: mode.meaning.clone(), ground: mode.ground.clone() });
    }
    Some(found)
}

/// Those of the symmetries that are independent at a point.
pub(crate) fn independent_symmetries(symmetries: Vec<Symmetry>, at: &[Ball]) -> Vec<Symmetry> {
    let mut sieve = Sieve::default();
    symmetries.into_iter().filter(|symmetry| sieve.accepts(&symmetry.vector(at, ()))).collect()
}

/// Vectors that are not shown to be independent of earlier ones are held back: Gaussian elimination in
/// enclosures, where an entry that is left and excludes 0 is the proof. So a rotation is told from the
/// translations however far from the origin the body is.
#[derive(Default)]
struct Sieve {
    /// With the place of the pivot of each; a vector vanishes at the pivots before it.
    basis: Vec<(usize, Vec<Ball>)>,
}

impl Sieve {
    fn accepts(&mut self, vector: &[Ball]) -> bool {
        if !vector.iter().all(Ball::is_finite) {
            return false;
        }
        let mut rest = vector.to_vec();
        for (pivot, other) in &self.basis {
            if rest[*pivot].is_zero() {
                continue;
            }
            let factor = rest[*pivot] / other[*pivot];
            subtract(&mut rest, other, &factor);
            rest[*pivot] = Ball::ZERO;
        }
        let sizes = rest.iter().map(Enclosure::certain_size).enumerate().filter(|(_, size)| *size > 0.0);
        let Some((pivot, _)) = sizes.reduce(|best, own| if own.1 > best.1 { own } else { best }) else { return false };
        self.basis.push((pivot, rest));
        true
    }
}
