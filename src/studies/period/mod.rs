//! The exact period of one coordinate at finite amplitude, by energy conservation.
//!
//! With L = 1/2 M(q) q'^2 - U(q) (a term linear in q' moves nothing) the energy E = 1/2 M q'^2 + U is conserved (and alike with an M
//! that depends on E - U, where L is relativistic or has a term in q'^4), and
//! the period is T = ∫ sqrt(2M/(E - U)) dq between the turning points, where E = U. The integral is taken by Taylor
//! expansions of the compiled energies with bounds of their rests, over enclosures (`panel`): that E - U is
//! positive between the turning points is proved on the way. Numbers are doubled doubles as long as these do, else as
//! long as it takes. Beyond all barriers of a potential that is periodic in the coordinate the motion is a rotation, and
//! its period the time in which the coordinate advances by that of U and M.
//!
//! ```
//! use librate::model::{self, Constant};
//! use librate::period::{Options, Oscillator, Request};
//! use librate::syntax;
//!
//! let text = "coord phi  T = 1/2*phi'^2  V = 1 - cos(phi)";
//! let file = syntax::parse(text)?;
//! let model = model::elaborate(&file, &Default::default(), &Default::default())?;
//! let oscillator = Oscillator::of_model(&model)?;
//! let request = Request::Amplitude(Constant::parse("pi/2")?);
//! let found = oscillator.period(&request, &Options::default())?;
//! // 4 K(sin(pi/4)) = gamma(1/4)²/sqrt(pi)
//! assert!((found.period.mid_f64() - 7.416298709205487).abs() < 1e-15);
//! assert!(found.period.radius < 1e-17);
//! # Ok::<(), librate::Error>(())
//! ```

mod barrier;
mod center;
mod curve;
mod energies;
mod error;
mod panel;
mod portrait;
mod small;
mod solve;
mod task;
mod turning;
mod weights;

pub use curve::{Place, curve, place};
pub use energies::check;
pub use error::PeriodError;
pub use portrait::{Course, Orbit, hills, portrait};

use center::{Center, Corner};
use energies::{Energies, Kinked};
use panel::{Field, Kink};

use crate::digits::Digits;
use librate_core::expr::{ExprId, Pool, Tape};
use librate_core::linearize::{Linearized, Units, evaluate_closed, linearize, power_of_two, short};
use librate_core::model::{Constant, Model};
use librate_core::number::Number;
use librate_core::precision::{Ball, Big, Enclosure, Magnitude, Scalar, one_digit_up_text};

/// Which motion is meant.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub enum Request {
    /// By its turning point above the equilibrium: the distance between the two, in the unit that the coordinate is
    /// declared with.
    Amplitude(Constant),
    /// By its energy E = T + V with V as written, in SI; where T has a part T0 without velocities, E = T2 - T0 + V,
    /// which is conserved.
    Energy(Constant),
}

/// How well: significant digits of the period that have to be certain, 1 to 250.
pub type Options = Digits<250>;

/// What kind of motion.
#[derive(Clone, Debug, PartialEq)]
pub enum Motion {
    /// To and fro between two turning points, the lower one first, in SI.
    Libration {
        /// The turning points.
        turning: [Ball; 2],
    },
    /// Round and round.
    Rotation {
        /// How far the coordinate goes in one period, in SI.
        advance: Ball,
    },
}

/// A period and what belongs to it.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Period {
    /// The period.
    pub period: Ball,
    /// The period with more digits than a ball has, where they were asked for.
    pub precise: Option<Big>,
    /// What kind of motion.
    pub motion: Motion,
    /// Its turning points, the lower one first, or its advance, with more digits; empty where balls have all.
    pub motion_precise: Vec<Big>,
    /// The energy, as a value of U = V - T0.
    pub energy: Ball,
    /// The energy with more digits, or where doubles do not hold it.
    pub energy_precise: Option<Big>,
    /// The equilibrium that amplitudes are measured from.
    pub equilibrium: Ball,
    /// That with more digits.
    pub equilibrium_precise: Option<Big>,
    /// Whether the equilibrium is known to be there. Where not, its place is an estimate, and a period by
    /// amplitude is that of the motion about this place.
    pub proved: bool,
    /// Whether the force jumps at the equilibrium, a corner of the potential.
    pub corner: bool,
    /// The period of small oscillations about the equilibrium, 2 pi sqrt(M/K); `None` where K is not positive or there
    /// is none, or the equilibrium is not proved.
    pub small: Option<Ball>,
    /// That with more digits.
    pub small_precise: Option<Big>,
    /// The leading change of the frequency: omega = omega_0 (1 + bend A² + …) for small amplitudes A; `None` where
    /// there are no small oscillations, and where T is not quadratic in the velocity.
    pub bend: Option<Ball>,
}

impl Period {
    /// The same in SI, where it was found in the units of an oscillator.
    fn in_si(mut self, of: &Oscillator) -> Self {
        let (energy, rate, length) = (of.power(Units::energy), of.power(Units::rate), of.length());
        self.period = self.period.scale_far(-rate);
        self.small = self.small.map(|small| small.scale_far(-rate));
        self.precise = self.precise.map(|period| period.scale(-rate));
        self.small_precise = self.small_precise.map(|small| small.scale(-rate));
        self.bend = self.bend.map(|bend| bend.scale_far(-2 * length));
        self.energy_precise = self.energy_precise.map(|own| own.scale(energy));
        self.energy = self.energy.scale_far(energy);
        self.equilibrium = self.equilibrium.scale_far(length);
        self.equilibrium_precise = self.equilibrium_precise.map(|place| place.scale(length));
        self.motion_precise = self.motion_precise.into_iter().map(|place| place.scale(length)).collect();
        match &mut self.motion {
            Motion::Libration { turning } => *turning = turning.map(|place| place.scale_far(length)),
            Motion::Rotation { advance } => *advance = advance.scale_far(length),
        }
        self
    }
}

/// A model of one coordinate, ready for periods.
#[derive(Clone, Debug)]
pub struct Oscillator {
    center: Center,
    energies: Tape,
    shape: Tape,
    even: bool,
    /// Whether M depends on the energy of the motion.
    stretched: bool,
    /// Of the expressions below.
    pool: Pool,
    kinks: Vec<Kink<ExprId>>,
    /// The period of U and M in the coordinate.
    advance: Option<ExprId>,
}

impl Oscillator {
    /// Takes the energies of a model of one coordinate, about its equilibrium or a corner of the potential.
    ///
    /// Where absolute values in V have their corner, as in `V = abs(x)`, nothing can be linearized, but there are motions
    /// about it. The corner is the given equilibrium, or the one next to the guess.
    ///
    /// # Errors
    /// As [`check`], where the equation of energy can't be solved for the velocity, and where there is neither an equilibrium nor a corner.
    pub fn of_model(model: &Model) -> Result<Self, PeriodError> {
        check(model)?;
        match linearize(model.clone()) {
            Ok(linearized) => Self::new(&linearized),
            Err(error) => Self::about_corner(model).ok_or(PeriodError::Linearize(error)),
        }
    }

    /// Takes the energies of a model of one coordinate that is linearized already.
    ///
    /// # Errors
    /// As [`check`], and where the equation of energy can't be solved for the velocity.
    pub fn new(linearized: &Linearized) -> Result<Self, PeriodError> {
        check(linearized.model())?;
        let energies = Energies::new(linearized.measured_model())?;
        Self::about(Center::Linearized(linearized.clone()), energies)
    }

    fn about_corner(model: &Model) -> Option<Self> {
        let mut energies = Energies::new(model).ok()?;
        Self::about(Center::Corner(Corner::find(model, &mut energies)?), energies).ok()
    }

    fn about(center: Center, mut energies: Energies) -> Result<Self, PeriodError> {
        let place = center.exactly(&energies.pool);
        let Kinked { tape, kinks, .. } = energies.kinked(place);
        let own = center.model().coordinates.at(0);
        // All parameters have values, or there would be no equilibrium.
        let tape = tape.ok_or_else(|| PeriodError::NotQuadratic { coordinate: own.name(), span: own.span })?;
        let stretched = energies.pool.depends_on(energies.mass, &|symbol| symbol == energies.energy);
        let even = place.is_some_and(|place| energies.is_even_about(place));
        let advance = energies.advance();
        Ok(Self { center, shape: shape()?, even, stretched, advance, kinks, pool: energies.pool, energies: tape })
    }

    /// The model.
    #[must_use]
    pub fn model(&self) -> &Model {
        self.center.model()
    }

    /// The name of the coordinate.
    #[must_use]
    pub fn coordinate_name(&self) -> String {
        self.coordinate().name()
    }

    fn coordinate(&self) -> librate_core::model::Coordinate<'_> {
        self.model().coordinates.at(0)
    }

    /// The period of a motion.
    ///
    /// # Errors
    /// Where there is no such motion, it is not periodic, or the energies are not smooth on its way.
    pub fn period(&self, request: &Request, options: &Options) -> Result<Period, PeriodError> {
        let budget = self.model().pool.budget();
        budget.at("the period", None);
        let period = solve::period(self, request, options);
        budget.check()?;
        period.map(|period| period.in_si(self))
    }

    /// What something is measured in, as a power of two: see [`Linearized::units`].
    fn power(&self, of: impl Fn(&Units) -> i64) -> i64 {
        self.center.units().map_or(0, of)
    }

    fn length(&self) -> i64 {
        self.power(|units| units.length(0))
    }

    /// A coordinate in a message.
    fn place(&self, value: f64) -> String {
        self.text(value, self.length())
    }

    /// An energy in a message.
    fn height(&self, value: f64) -> String {
        self.text(value, self.power(Units::energy))
    }

    /// A bound of a difference of energies in a message.
    fn margin(&self, value: Magnitude) -> String {
        one_digit_up_text(value.scale(self.power(Units::energy)).to_f64())
    }

    /// The equilibrium in the units of the energies, as precisely as it is known.
    fn position(&self, bits: usize) -> Big {
        let estimate = || Big::from_ball(&self.center.position(), bits);
        self.center.precisely(bits).map_or_else(estimate, |place| place.scale(-self.length()))
    }

    fn text(&self, value: f64, power: i64) -> String {
        short(Ball::exact(value).scale_far(power).mid_f64())
    }

    /// The number that is asked for, in the units of the energies.
    fn value<S: Scalar>(&self, request: &Request, precision: S::Precision) -> S {
        let (constant, factor, power) = match request {
            Request::Amplitude(constant) => (constant, self.coordinate().factor, self.length()),
            Request::Energy(constant) => (constant, None, self.power(Units::energy)),
        };
        // A constant has no symbols, which is all that an evaluation can fail for.
        let value = evaluate_closed::<S>(constant.pool(), constant.value(), precision);
        let mut value = value.unwrap_or_else(|| S::from_number(&Number::ZERO, precision));
        if power != 0 {
            value = value.mul(&S::from_number(&power_of_two(-power), precision));
        }
        let factor = factor.and_then(|factor| evaluate_closed::<S>(&self.model().pool, factor, precision));
        factor.map_or_else(|| value.clone(), |factor| value.mul(&factor))
    }

    /// How far the coordinate goes in a full turn.
    fn advance<S: Scalar>(&self, precision: S::Precision) -> Option<S> {
        evaluate_closed::<S>(&self.pool, self.advance?, precision)
    }

    fn field<S: Enclosure>(&self, precision: S::Precision) -> Field<S> {
        let kinks = self.kinks.iter().filter_map(|kink| kink.evaluated(&self.pool, precision));
        Field::new(&self.energies, &self.shape, kinks.collect(), precision)
    }
}

/// sqrt(2 M/h) from h and M.
fn shape() -> Result<Tape, PeriodError> {
    let mut pool = Pool::new();
    let (h, m) = (pool.symbol("h"), pool.symbol("M"));
    let (below, above) = (pool.symbol_expr(h), pool.symbol_expr(m));
    let quotient = pool.div(above, below);
    let quotient = pool.scale(quotient, &Number::from(2));
    let root = pool.sqrt(quotient);
    Tape::compile(&pool, &[root], &[h, m])
        .map_err(|_| PeriodError::Undecided { coordinate: String::new(), place: String::new() })
}
