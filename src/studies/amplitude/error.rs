//! Why a model has no frequencies that change with the amplitude.

use librate_core::diagnostic::{at, nowhere};
use librate_core::linearize::LinearizeError;
use librate_core::mistakes;
use librate_core::model::Feature;

/// That a feature is not covered, and a way round it.
fn words(feature: Feature) -> [&'static str; 2] {
    match feature {
        Feature::Time => [
            "the change of frequencies with the amplitude is not computed for models that contain the time",
            "leave out this term if it has no effect on the equations of motion; `motion` integrates a driven model",
        ],
        Feature::Dissipation => [
            "friction dissipates energy: the amplitude is not constant",
            "without this line the model has the frequencies without friction",
        ],
        Feature::Force => [
            "a generalised force acts: the amplitude need not be constant",
            "write a force with a potential into V; `motion` integrates the others",
        ],
        Feature::Constraint => [
            "the change of frequencies with the amplitude is not computed for models with constraints",
            "write the energies in independent coordinates",
        ],
        Feature::Rolling => [
            "the change of frequencies with the amplitude is not computed under conditions on velocities",
            "`motion` integrates such a model at any amplitude",
        ],
        Feature::SteadyMotion => [
            "the change of frequencies with the amplitude is not computed about a steady motion",
            "the momentum p of what turns is constant: remove the coordinate and its velocity, and add p^2/(2*I) to V, with the inertia I of the rotation, such as m*r^2",
        ],
    }
}

mistakes! {
/// A model whose frequencies have no leading change with the amplitude.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
Error AmplitudeError {
    /// Something without periodic motions, or that is not covered.
    #[error("{}", words(*feature)[0])]
    "E0801" Unsupported(span) {
        /// What.
        feature: Feature,
    } => {
        at(*span, feature.label()).with_help(words(*feature)[1])
    },

    /// Terms linear in the velocities that are no total derivative by the time.
    #[error("terms linear in the velocities act on the motion: it has gyroscopic forces")]
    "E0802" Gyroscopic(span) => at(*span, "linear in the velocities").with_help(
        "the change of frequencies with the amplitude is computed for L = T - V with T quadratic in the velocities",
    ),

    /// A Lagrangian that is no quadratic polynomial in the velocities.
    #[error("the energies are not quadratic in the velocities")]
    "E0803" NotQuadratic(span) => at(*span, "not quadratic in the velocities").with_help(
        "the change of frequencies with the amplitude is computed for L = T - V with T quadratic in the velocities",
    ),

    /// A motion that runs away.
    #[error("the equilibrium is unstable: {count} of its modes {}", if *.count == 1 { "grows" } else { "grow" })]
    "E0804" Unstable {
        /// How many modes grow.
        count: usize,
    } => nowhere().with_help("give a point near a minimum of the potential with `guess` or `equilibrium`"),

    /// Third and fourth derivatives that are no numbers.
    #[error(
        "the energies have no third and fourth derivatives at the equilibrium, or none within the range of doubles"
    )]
    "E0805" NotSmooth {} => nowhere()
        .with_help("a power like x^(7/2) has a stiffness there, but its contribution to the frequency is not proportional to the square of the amplitude"),

    /// Too many terms to be written out.
    #[error("the energies have {terms} terms, more than {most}")]
    "E0806" TooLarge {
        /// How many.
        terms: usize,
        /// How many there may be.
        most: usize,
    } => nowhere(),
} else {
    /// What an earlier stage says.
    #[error(transparent)]
    Linearize(LinearizeError),
}
}
