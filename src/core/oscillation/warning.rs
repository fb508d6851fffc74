//! Results that are probably not what was meant.

use super::{NormalModes, Stability};
use crate::diagnostic::{Diagnostic, at};
use crate::linearize::{Linearized, Origin, Shape, Structure};
use crate::mistakes;
use crate::model::Model;
use crate::modes::{Kind, Options, is_definite, leading};
use crate::order::Order;
use crate::precision::{Ball, SparseMatrix};
use crate::span::Span;

/// What is said of an equilibrium that was found and does not hold.
fn runs_from(span: Span, coordinate: &str) -> Diagnostic {
    at(span, format!("`{coordinate}` moves away from it")).with_help(
        "if a stable one was meant, start the search near it with `guess`; if this one is meant, give it with `equilibrium`",
    )
}

mistakes! {
/// Something suspicious about the normal modes of a model.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
Warning Warning {
    /// Nobody asked for the equilibrium that was taken, and the motion runs away from it in every
    /// direction.
    #[error("the equilibrium is a maximum of the potential energy")]
    "W0101" Maximum(span) {
        /// That coordinate.
        coordinate: String,
    } => runs_from(*span, coordinate),

    /// The same in some directions.
    #[error("the equilibrium is a saddle of the potential energy")]
    "W0102" Saddle(span) {
        /// That coordinate.
        coordinate: String,
    } => runs_from(*span, coordinate),

    /// The equilibrium was searched for, and that there is one where the search ended is not proved.
    #[error("the existence of the equilibrium that was found is not proved")]
    "W0103" NotProved(span) {
        /// That coordinate.
        coordinate: String,
    } => at(*span, format!("the error of `{coordinate}` is an estimate, and so are all digits below")).with_help(
        "some motion has no restoring force there, at least to second order; if the equilibrium is known, give it with `equilibrium`",
    ),

    /// A frequency is the small difference of large terms, as near a bifurcation.
    #[error(
        "omega of mode {mode} is ill-conditioned: its square is the difference of terms, and only {share} of their size"
    )]
    "W0104" IllConditioned(span) {
        /// The number of the mode, from 1.
        mode: usize,
        /// ω² over the terms, with one digit.
        share: String,
        /// The relative change of the terms that may change ω by a hundredth, with one digit.
        change: String,
    } => at(*span, format!("relative changes of {change} in these terms may change it by 1 %")).with_help(
        "all printed digits are right for the numbers as given in the file; if these are measured, fewer digits are significant",
    ),

    /// A constraint that says nothing that others do not.
    #[error("{} follows from the others and has no effect", if *.one_of_several { "one of these constraints" } else { "this constraint" })]
    "W0105" DependentConstraint(span) {
        /// Whether it is one of a family.
        one_of_several: bool,
    } => at(*span, "ignored").with_help(
        "the model is the same without it; if it was meant to restrict another motion, it is wrong",
    ),

    /// A dissipation that is negative for some motion.
    #[error("the dissipation supplies energy")]
    "W0106" FeedsEnergy(span) {
        /// The coordinate that moves most in such a motion.
        coordinate: String,
        /// Another one, if it is by moving in turns that the two take energy in: round a loop in the one sense or
        /// the other.
        other: Option<String>,
    } => match other {
        Some(other) => at(*span, format!("when `{coordinate}` and `{other}` go around a closed loop, in one sense or the other"))
            .with_help("friction against a rotating medium drags bodies along; if a motor is meant to supply the energy, this is right; write other forces as `force x = …`"),
        None => at(*span, format!("negative when `{coordinate}` moves"))
            .with_help("friction dissipates energy: F = 1/2*c*x'^2 with a positive c; if a motor is meant to supply energy, write its force: `force x = …`"),
    },

    /// A steady response beside a motion that grows.
    #[error("the equilibrium is unstable: the steady response is never reached")]
    "W0107" NeverReached(span) {
        /// The coordinate that moves most in such a motion.
        coordinate: String,
    } => at(*span, format!("`{coordinate}` moves away without end"))
        .with_help("the unstable modes are added to it and grow; give a stable equilibrium with `guess` or `equilibrium`"),
}
}

impl NormalModes {
    /// What is suspicious about the modes, whether they were computed with vectors or without.
    ///
    /// An equilibrium that the file gives with `equilibrium` was meant.
    #[must_use]
    pub fn warnings(&self, linearized: &Linearized) -> Vec<Diagnostic> {
        let mut found: Vec<Warning> = not_proved(linearized).into_iter().collect();
        found.extend(dependent_constraints(linearized));
        match linearized.structure() {
            Structure::Conservative => {
                found.extend(runs_away(linearized, self));
                found.extend(ill_conditioned(linearized, self));
            }
            // Of a large model dense matrices would be needed.
            _ if self.method.is_some() => {}
            Structure::Gyroscopic => found.extend(runs_away(linearized, self)),
            Structure::Circulatory | Structure::Damped => {
                found.extend(runs_away(linearized, self));
                found.extend(feeds_energy(linearized, self));
            }
        }
        found.iter().map(Diagnostic::from).collect()
    }
}

/// All exponents of more coordinates are not computed for a warning.
const MOST_TOLD: usize = 200;

/// What is to be said of a steady response about this equilibrium; nothing of more than 200 coordinates whose energy does not bound them.
#[must_use]
pub fn never_reached(linearized: &Linearized) -> Option<Warning> {
    if super::sparse::is_bound(linearized) || linearized.dimension() > MOST_TOLD {
        return None;
    }
    let modes = super::normal_modes(linearized, &Options::default().digits(2)).ok()?;
    let fastest = modes.modes.first().filter(|_| modes.stability == Stability::Unstable)?;
    let coordinate = linearized.model().coordinates.get(largest(&fastest.vector)?)?;
    Some(Warning::NeverReached { span: coordinate.span, coordinate: coordinate.name() })
}

fn dependent_constraints(linearized: &Linearized) -> Vec<Warning> {
    let Model { constraints, rolling, redundant, .. } = linearized.model();
    let all = || constraints.iter().chain(rolling).chain(redundant);
    let dependent = linearized.dependent_constraints().iter().filter_map(|number| constraints.get(*number));
    dependent
        .chain(redundant)
        .map(|own| Warning::DependentConstraint {
            one_of_several: all().filter(|other| other.span == own.span).count() > 1,
            span: own.span,
        })
        .collect()
}

/// A motion that takes energy in from friction.
fn feeds_energy(linearized: &Linearized, modes: &NormalModes) -> Option<Warning> {
    let model = linearized.model();
    // Conditions on velocities have shares in C and N that are no friction.
    let span = model.dissipation.filter(|_| model.force.is_none() && model.rolling.is_empty())?;
    feeds_moving(linearized, span).or_else(|| {
        // A medium that drags along and takes out more than it feeds in is friction like any other.
        let swells = |mode: &super::NormalMode| mode.growth.is_positive() && mode.omega.is_positive();
        let grows = modes.modes.iter().any(swells);
        grows.then(|| feeds_round_loops(linearized, span)).flatten()
    })
}

/// The forces -N q do the work -∮ qᵀNᵀdq round a loop: 0 for all loops only if N is symmetric, and in the plane of q_i and q_j
/// the area times N_ij - N_ji, with a sign for each sense.
fn feeds_round_loops(linearized: &Linearized, span: Span) -> Option<Warning> {
    let matrix = linearized.circulatory()?;
    let n = linearized.dimension();
    // Under constraints the matrix is that of the coordinates that are left.
    let axis = |i: usize| {
        let unit: Vec<f64> = (0..n).map(|j| f64::from(u8::from(i == j))).collect();
        let (whole, _) = linearized.embed(&unit, 0.0);
        whole.iter().position(|x| *x == 1.0)
    };
    let pairs = (0..n).flat_map(|i| (i + 1..n).map(move |j| (i, j)));
    let torque = |&(i, j): &(usize, usize)| matrix[i + n * j] - matrix[j + n * i];
    let pairs: Vec<(usize, usize)> = pairs.filter(|pair| !torque(pair).contains_zero()).collect();
    let (largest, _) = leading(pairs.len(), |at| torque(&pairs[at]).mid_f64().abs())?;
    let (i, j) = pairs[largest];
    let coordinates = &linearized.model().coordinates;
    let name = |i: usize| Some(coordinates.get(axis(i)?)?.name());
    Some(Warning::FeedsEnergy { span, coordinate: name(i)?, other: Some(name(j)?) })
}

/// A motion with q'ᵀ C q' < 0: an eigenvector of C in doubles is tried in enclosures.
fn feeds_moving(linearized: &Linearized, span: Span) -> Option<Warning> {
    let damping = linearized.damping()?;
    let direction = super::exponents::falling_direction(&linearized.mass(), &damping)?;
    let (whole, _) = linearized.embed(&direction, 0.0);
    let most = largest(&whole)?;
    Some(Warning::FeedsEnergy { span, coordinate: linearized.model().coordinates.get(most)?.name(), other: None })
}

/// The place of the first component within 1e-6 of the largest, about.
fn largest(vector: &[f64]) -> Option<usize> {
    leading(vector.len(), |at| vector[at].abs()).map(|(at, _)| at)
}

/// Terms that are so many times as large as ω² nearly cancel.
const ILL_CONDITIONED: f64 = 1e6;

/// So many modes are judged, those with the smallest |ω²|; large ones can't be small differences.
const MOST_JUDGED: usize = 8;

/// The worst of the soft modes, if that is bad.
fn ill_conditioned(linearized: &Linearized, modes: &NormalModes) -> Option<Warning> {
    let modes = super::in_units(linearized, modes);
    let mut soft: Vec<(usize, Shape<'_>)> = modes
        .modes
        .iter()
        .enumerate()
        .filter(|(_, mode)| matches!(mode.kind, Kind::Oscillation | Kind::Unstable))
        .filter(|(_, mode)| mode.vector.len() == linearized.dimension())
        .filter(|(_, mode)| mode.imaginary.is_empty())
        .filter_map(|(at, mode)| {
            let shape =
                Shape { vector: &mode.vector, error: mode.vector_error_bound, square: mode.omega_squared?.mid_f64() };
            Some((at, shape))
        })
        .collect();
    soft.order_by(|(_, a), (_, b)| a.square.abs().total_cmp(&b.square.abs()));
    soft.truncate(MOST_JUDGED);
    if soft.is_empty() {
        return None;
    }
    let (numbers, shapes): (Vec<usize>, Vec<Shape<'_>>) = soft.into_iter().unzip();
    let ratios = linearized.cancellation(&shapes, ILL_CONDITIONED)?;
    let judged = numbers.into_iter().zip(&shapes).zip(ratios);
    let ((at, shape), ratio) =
        judged.filter(|(_, ratio)| *ratio >= ILL_CONDITIONED).reduce(|a, b| if b.1 > a.1 { b } else { a })?;
    let span = linearized.model().coordinates.get(largest(shape.vector)?)?.span;
    // ω changes by half as much as ω².
    let [share, change] = [1.0, 0.02].map(|part| format!("{:.0e}", part / ratio));
    Some(Warning::IllConditioned { span, mode: at + 1, share, change })
}

fn not_proved(linearized: &Linearized) -> Option<Warning> {
    let equilibrium = linearized.equilibrium();
    let mut searched = linearized.model().coordinates.iter().zip(&equilibrium.origins);
    let (coordinate, _) = searched.find(|(_, origin)| !equilibrium.proved && **origin == Origin::Found)?;
    Some(Warning::NotProved { span: coordinate.span, coordinate: coordinate.name() })
}

fn runs_away(linearized: &Linearized, modes: &NormalModes) -> Option<Warning> {
    let model = linearized.model();
    let fastest = modes.modes.first().filter(|mode| mode.kind == Kind::Unstable)?;
    let origins = &linearized.equilibrium().origins;
    if !model.rolling.is_empty() || origins.iter().all(|origin| *origin == Origin::Given) {
        return None;
    }
    // Other forces make motions grow about a minimum, too, and a steady motion is no equilibrium of a potential.
    let falls = || super::exponents::falling_direction(&linearized.mass(), &linearized.stiffness()).is_some();
    if linearized.structure() != Structure::Conservative && (model.rates.any() || !falls()) {
        return None;
    }
    let leading = fastest.leading().or_else(|| {
        let shaped = super::normal_modes(linearized, &Options::default().digits(2).lowest(1)).ok()?;
        shaped.modes.first()?.leading()
    });
    let own = model.coordinates.get(leading?)?;
    let (span, coordinate) = (own.span, own.name());
    Some(match is_maximum(linearized) {
        true => Warning::Maximum { span, coordinate },
        false => Warning::Saddle { span, coordinate },
    })
}

/// Whether K is proved to be negative definite.
fn is_maximum(linearized: &Linearized) -> bool {
    let dense = |matrix: &[Ball]| SparseMatrix::from_dense(linearized.dimension(), matrix);
    let (mass, stiffness) =
        linearized.sparse().unwrap_or_else(|| (dense(&linearized.mass()), dense(&linearized.stiffness())));
    let turned: Vec<_> = stiffness.entries().map(|(i, j, entry)| (i as u32, j as u32, -*entry)).collect();
    is_definite(&SparseMatrix::from_shares(mass.dimension(), &turned), &mass)
}
