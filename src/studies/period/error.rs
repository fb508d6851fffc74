//! Why a model has no period to speak of.

use librate_core::budget::Exceeded;
use librate_core::diagnostic::{at, nowhere};
use librate_core::linearize::LinearizeError;
use librate_core::mistakes;
use librate_core::model::Feature;
use librate_core::span::Span;

/// That a feature is not covered, and a way round it.
fn words(feature: Feature) -> [&'static str; 2] {
    match feature {
        Feature::Time => [
            "the model contains the time, but the period is computed from a conserved energy",
            "leave out this term if it has no effect on the equations of motion; `motion` integrates the others",
        ],
        Feature::Dissipation => [
            "friction dissipates energy: no motion of this model is periodic",
            "without this line the model has the period without friction; `modes` computes the damped oscillations",
        ],
        Feature::Force => [
            "a generalised force acts: the energy need not be conserved",
            "a force of the coordinate alone has a potential: write it into V; `motion` integrates the others",
        ],
        Feature::Constraint | Feature::Rolling => {
            ["periods are not computed for models with constraints", "write the energies in one independent coordinate"]
        }
        Feature::SteadyMotion => [
            "a steady motion has no period of one coordinate",
            "the momentum p of the rotation is constant: remove the coordinate and its velocity, and add p^2/(2*I) to V, with the inertia I of the rotation, such as m*r^2",
        ],
    }
}

mistakes! {
/// A motion without a period, or a request that no motion answers.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
Error PeriodError {
    /// More or fewer coordinates than one.
    #[error("a period from energy conservation requires one coordinate, but this model has {count}")]
    "E0501" NotOneCoordinate {
        /// How many.
        count: usize,
        /// Where the second one is declared.
        span: Option<Span>,
    } => span.map_or_else(nowhere, |span| at(span, "one too many"))
        .with_help("`modes` computes small oscillations of several coordinates"),

    /// Something that the energy is not conserved with, or that is not covered.
    #[error("{}", words(*feature)[0])]
    "E0502" Unsupported(span) {
        /// What.
        feature: Feature,
    } => {
        at(*span, feature.label()).with_help(words(*feature)[1])
    },

    /// A kinetic energy that is no quadratic polynomial in the velocity, nor of another kind that is known.
    #[error("the equation of energy can't be solved for the velocity of `{coordinate}`")]
    "E0503" NotQuadratic(span) {
        /// The coordinate.
        coordinate: String,
    } => at(*span, "this coordinate").with_help(
        "T is 1/2*M(q)*q'^2, possibly with terms linear in q' and without q', with a term in q'^4, or relativistic, -m*c^2*sqrt(1 - q'^2/c^2)",
    ),

    /// An amplitude or energy that is no number, or no positive amplitude.
    #[error("{what} {value} is not valid: {reason}")]
    "E0504" BadRequest {
        /// `the amplitude` or `the energy`.
        what: &'static str,
        /// Its value.
        value: String,
        /// What is wrong with it.
        reason: &'static str,
    } => nowhere().with_help("give a positive amplitude, or the energy of the motion: `--amplitude 1/2`, `--energy 3`"),

    /// A barrier between the equilibrium and the turning point that is asked for.
    #[error("the amplitude {amplitude} is beyond the barrier at {coordinate} = {barrier}")]
    "E0505" BeyondBarrier {
        /// The amplitude.
        amplitude: String,
        /// The coordinate.
        coordinate: String,
        /// Where the barrier is.
        barrier: String,
        /// Its height above the equilibrium.
        height: String,
        /// The energy that the amplitude would need, above the equilibrium.
        energy: String,
    } => nowhere().with_help(format!(
        "the barrier is {height} above the equilibrium, the requested turning point {energy}; `--energy` accepts an energy above a barrier"
    )),

    /// The motion creeps up to the top of a barrier and never comes back, or next to that.
    #[error("{}", at_barrier_words(.coordinate, .barrier, .margin))]
    "E0506" AtBarrier {
        /// The coordinate.
        coordinate: String,
        /// Where the barrier is.
        barrier: String,
        /// A bound of the difference between the energy and the height of the barrier.
        margin: String,
        /// The height of the barrier, as a potential energy.
        height: String,
    } => {
        let message = nowhere();
        if margin == "0" {
            message.with_help(format!("the energy is the height of the barrier, {height}"))
        } else {
            message.with_help(format!(
                "the energy is the height of the barrier, {height}, to within {margin}; so long a period is not computed"
            ))
        }
    },

    /// An energy that no motion about the equilibrium has.
    #[error("the energy {energy} is not above the potential energy {potential} at the equilibrium")]
    "E0507" BelowEquilibrium {
        /// The energy.
        energy: String,
        /// U at the equilibrium.
        potential: String,
        /// Whether the equilibrium is a maximum of U.
        maximum: bool,
    } => nowhere().with_help(if *maximum {
        "the equilibrium is a maximum of the potential: give a point in the intended well with `guess`, in place of an `equilibrium`"
    } else {
        "the energy is E = T + V with V as written in the model"
    }),

    /// The equilibrium is a maximum, and the motion does not pass it.
    #[error(
        "the equilibrium {coordinate} = {equilibrium} is a maximum of the potential, and no motion about it has a turning point at this distance"
    )]
    "E0508" Maximum {
        /// The coordinate.
        coordinate: String,
        /// The equilibrium.
        equilibrium: String,
    } => nowhere().with_help("give a point in the intended well with `guess`, in place of an `equilibrium`"),

    /// A motion that nothing brings back.
    #[error("the motion is not periodic: {}", open_words(.coordinate, *.upward, .end.as_deref()))]
    "E0509" NotPeriodic {
        /// The coordinate.
        coordinate: String,
        /// Towards which side.
        upward: bool,
        /// Where the energies end, if they do.
        end: Option<String>,
    } => nowhere().with_help("where V has a well, a lower energy, or a smaller amplitude, stays in it"),

    /// Energies that have no expansion somewhere on the way.
    #[error("the energies are not smooth at {coordinate} = {place}, or too nearly singular there")]
    "E0510" NotSmooth {
        /// The coordinate.
        coordinate: String,
        /// The place.
        place: String,
    } => nowhere().with_help(
        "the period is computed where V and T can be differentiated between the turning points; poles, zeros of the inertia, and corners other than that of `abs` of a linear function of the coordinate are not supported",
    ),

    /// A mass that is negative on the way.
    #[error("the inertia of `{coordinate}` is negative at {coordinate} = {place}")]
    "E0511" NegativeMass(span) {
        /// The coordinate.
        coordinate: String,
        /// The place.
        place: String,
    } => at(*span, "declared here").with_help("a kinetic energy can't be negative; is a sign in T wrong?"),

    /// No kinetic energy.
    #[error("the coordinate `{coordinate}` has no inertia")]
    "E0513" NoInertia(span) {
        /// The coordinate.
        coordinate: String,
    } => at(*span, "its velocity does not occur squared in T")
        .with_help("a coordinate needs a kinetic energy; is a term of T missing?"),

    /// An integral with too much structure on the way.
    #[error(
        "the period was not computed: at {coordinate} = {place}, before the turning point, the integral reached the limit of steps"
    )]
    "E0514" TooLong {
        /// The coordinate.
        coordinate: String,
        /// How far the integral came.
        place: String,
    } => nowhere().with_help(
        "the force varies too often between the turning points; a smaller amplitude takes fewer steps",
    ),

    /// Bounds that do not decide, however precise.
    #[error(
        "the period could not be certified: at {coordinate} = {place} the energy is too close to the potential"
    )]
    "E0512" Undecided {
        /// The coordinate.
        coordinate: String,
        /// The place.
        place: String,
    } => nowhere().with_help("is it the energy of a barrier? There the period is infinite"),
} else {
    /// The work or the memory is beyond the budget.
    #[error(transparent)]
    Budget(#[from] Exceeded),
    /// What an earlier stage says.
    #[error(transparent)]
    Linearize(LinearizeError),
}
}

fn at_barrier_words(coordinate: &str, barrier: &str, margin: &str) -> String {
    let place = format!("the top of the barrier at {coordinate} = {barrier}");
    if margin == "0" {
        format!("the motion approaches {place} and never reaches it")
    } else {
        format!("the motion ends at {place} or nearly comes to rest there")
    }
}

fn open_words(coordinate: &str, upward: bool, end: Option<&str>) -> String {
    if let Some(end) = end {
        format!("`{coordinate}` reaches {end}, where the energies are no longer defined, with kinetic energy left")
    } else {
        format!("no turning point of `{coordinate}` was found on the way {}", if upward { "up" } else { "down" })
    }
}
