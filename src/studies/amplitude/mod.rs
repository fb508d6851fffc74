//! How the frequencies of normal modes change with their amplitude, to the leading order.
//!
//! Each mode continues to a family of periodic motions (A. M. Lyapunov's theorem, where no other frequency is a whole multiple of its
//! own): omega = omega_0 (1 + change A² + …) for an amplitude A of the mode's largest component. The change comes from third and
//! fourth derivatives of the energies at the equilibrium (`expansion`), enclosed together with the shapes and frequencies that it
//! is made from (`basis`). Where another mode has once, twice or three times the frequency and is driven at it, the series has no
//! such term: that is found out before anything is divided by the difference, and told.
//!
//! Which motions are stable is not said, but for one whose half frequency is another mode's own. Nothing is computed for models whose velocities do more than make up a quadratic T.
//!
//! ```
//! use librate::{amplitude, linearize::linearize, model, oscillation, syntax};
//!
//! let file = syntax::parse("coord phi  T = 1/2*phi'^2  V = 1 - cos(phi)")?;
//! let model = model::elaborate(&file, &Default::default(), &Default::default())?;
//! let linearized = linearize(model)?;
//! let modes = oscillation::normal_modes(&linearized, &Default::default())?;
//! let found = amplitude::amplitude(&linearized, &modes)?;
//! // A pendulum: 1 - A²/16
//! let change = found.modes[0].change.unwrap();
//! assert!((change.mid_f64() + 1.0 / 16.0).abs() <= change.mid_f64_error());
//! # Ok::<(), librate::Error>(())
//! ```

mod basis;
mod energies;
mod error;
mod expansion;

pub use energies::check;
pub use error::AmplitudeError;

use basis::Basis;
use energies::Energies;
use expansion::{Ended, Expansion};

use librate_core::linearize::{LinearizeError, Linearized, Structure};
use librate_core::modes::Kind;
use librate_core::oscillation::{NormalMode, NormalModes, in_units};
use librate_core::precision::Ball;

/// Components this near to the largest count as largest: the first of them is taken.
const EQUAL: f64 = 1e-6;

/// What becomes of all modes.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Amplitudes {
    /// One a mode, in the order of [`NormalModes::modes`].
    pub modes: Vec<ModeAmplitude>,
}

/// How the frequency of one mode changes with its amplitude.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct ModeAmplitude {
    /// The number of the coordinate whose amplitude is meant: the first one with the mode's largest component (within 1e-6).
    pub coordinate: usize,
    /// omega = omega_0 (1 + change A² + …), A in SI: in 1/rad² for an angle; `None` where [`ModeAmplitude::obstacle`] says why.
    pub change: Option<Ball>,
    /// The amplitude up to which each part of the motion of second and third order, as a vector of normal coordinates, is at most a
    /// tenth of the mode's own, and so is the relative change of the frequency; in doubles. `None` where there are no
    /// such parts.
    pub reach: Option<f64>,
    /// Why there is no change.
    pub obstacle: Option<Obstacle>,
    /// Modes of the same frequency (within the bounds), by number, which this one does not drive from rest at this order within
    /// the bounds: any mixture of them may be a mode as well.
    pub equal: Vec<usize>,
    /// A mode of half the frequency (within the bounds) that this one drives, by number: it grows from next to nothing, so that the
    /// motion in this mode alone is unstable however small it is.
    pub drives: Option<usize>,
}

/// Why a mode's frequency has no leading change with the square of the amplitude. Modes are given by number from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Obstacle {
    /// The mode does not oscillate.
    NoOscillation,
    /// The motion drives a mode without stiffness away.
    Drift {
        /// That mode.
        with: usize,
    },
    /// A mode of the same frequency is driven: the shapes of the motions are decided at the next order.
    OneToOne {
        /// That mode.
        with: usize,
    },
    /// A mode of twice the frequency is driven at the second order.
    OneToTwo {
        /// That mode.
        with: usize,
    },
    /// A mode of three times the frequency is driven at the third order.
    OneToThree {
        /// That mode.
        with: usize,
    },
    /// Shapes that the bounds do not separate leave it open.
    Undecided,
}

/// The leading change of each frequency; `modes` are all modes with their shapes.
///
/// # Errors
/// As [`check`]; velocities in the energies beyond a quadratic T, an unstable equilibrium, energies that are not smooth there.
pub fn amplitude(linearized: &Linearized, modes: &NormalModes) -> Result<Amplitudes, AmplitudeError> {
    let budget = linearized.model().pool.budget();
    linearized.check_inertia().map_err(AmplitudeError::Linearize)?;
    budget.at("the derivatives of the energies", None);
    let amplitudes = amplitudes(linearized, modes);
    budget.check().map_err(LinearizeError::from).map_err(AmplitudeError::Linearize)?;
    amplitudes
}

/// The coordinate of the largest component: the first of those that are as large.
fn largest(mode: &NormalMode) -> usize {
    let size = mode.vector.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    mode.vector.iter().position(|x| x.abs() >= size * (1.0 - EQUAL)).unwrap_or(0)
}

fn amplitudes(linearized: &Linearized, modes: &NormalModes) -> Result<Amplitudes, AmplitudeError> {
    let model = linearized.model();
    check(model)?;
    let energies = Energies::new(linearized.measured_model())?;
    if linearized.structure() != Structure::Conservative {
        let span = model.kinetic.first().map(|family| family.span).unwrap_or_default();
        return Err(AmplitudeError::Gyroscopic { span });
    }
    let grows = |mode: &&NormalMode| mode.kind == Kind::Unstable;
    let count = modes.modes.iter().filter(grows).count();
    if count > 0 {
        return Err(AmplitudeError::Unstable { count });
    }
    let undecided = ModeAmplitude { obstacle: Some(Obstacle::Undecided), ..Default::default() };
    let largest: Vec<usize> = modes.modes.iter().map(largest).collect();
    let units = linearized.units();
    let modes = &*in_units(linearized, modes);
    let Some(basis) = Basis::new(linearized, modes) else {
        let modes = vec![undecided; modes.modes.len()];
        return Ok(Amplitudes { modes });
    };
    let mut expansion = Expansion::new(&energies, &basis, linearized.measured_equilibrium());
    let mut found = Vec::with_capacity(largest.len());
    for (at, mode) in modes.modes.iter().enumerate() {
        let mut own = ModeAmplitude { coordinate: largest[at], ..Default::default() };
        match expansion.mode(at, mode, &mut own) {
            Ok(()) => {}
            Err(Ended::Obstacle(obstacle)) => own.obstacle = Some(obstacle),
            Err(Ended::NotSmooth) => return Err(AmplitudeError::NotSmooth {}),
        }
        found.push(own);
    }
    if let Some(units) = units {
        for mode in &mut found {
            let length = units.length(mode.coordinate);
            mode.change = mode.change.map(|change| change.scale_far(-2 * length));
            let reach = mode.reach.map(|reach| Ball::exact(reach).scale_far(length));
            mode.reach = reach.map(|reach| reach.mid_f64());
        }
    }
    // The term a² b of the mean Lagrangian that a mode drives one of twice the frequency with is what makes this one excite it.
    for slow in 0..found.len() {
        if let Some(Obstacle::OneToTwo { with }) = found[slow].obstacle {
            found[with].drives.get_or_insert(slow);
        }
    }
    Ok(Amplitudes { modes: found })
}
