//! The drive of a model: where the time occurs in it, the harmonic force that it exerts at the equilibrium, and the model without it.
//!
//! Lagrange's equations are linear in L, and so are friction and forces: The equations averaged over a period of the drive are those of
//! the averaged energies and forces. These are taken at four times, which is exact for expressions with harmonics up to the third; that there
//! are none beyond the second is shown as an identity. Equilibrium, M, G, C, K and N are those of the averaged model. The force on it,
//! h(q0, 0, t) of the equations M q'' + h = 0, is a constant and multiples of cos(Ωt) and sin(Ωt), and nothing else at the equilibrium depends on the
//! time; both are identities, too.

use super::error::ResponseError;
use super::exact::Frequency;
use crate::floquet::motion::values;
use crate::mechanics::Mechanics;
use librate_core::expr::{ExprId, Node, Pool, Substitution, Symbol, Tape, ZeroVerdict};
use librate_core::linearize::{Linearized, all_terms, bodies, missing_value, signed_terms};
use librate_core::model::{Model, TermFamily};
use librate_core::number::Number;
use librate_core::order::Gather;
use librate_core::precision::{Complex, Enclosure, Function};
use librate_core::span::Span;

/// Terms beyond this are not written out.
const MOST_TERMS: usize = 10_000;

/// The model without its drive.
pub(super) struct Averaged {
    pub(super) model: Model,
    /// Whether it does not depend on the parameter in the frequency.
    pub(super) is_fixed: bool,
    /// The angular frequency, in the parameters.
    rate: ExprId,
    driven_at: Span,
}

/// An angular frequency, and the force on each coordinate it acts on.
pub(super) type Driven<S> = (S, Vec<(usize, Complex<S>)>);

/// The force of a drive, a function of the parameter in its frequency and of the equilibrium.
#[derive(Debug)]
pub(super) struct Drive {
    /// The coordinates on which it acts.
    pub(super) coordinates: Vec<usize>,
    /// The frequency, then what goes with the cosine and with the sine for each coordinate; then the slopes of all over the parameter.
    tape: Tape,
    /// The frequency once more, as an expression in the parameter.
    pool: Pool,
    rate: ExprId,
    parameter: Symbol,
}

/// Averages a driven model over its time.
pub(super) fn averaged(model: &Model, parameter: usize) -> Result<Averaged, ResponseError> {
    let driven_at = check(model)?;
    let not_harmonic = |reason: &str| ResponseError::NotHarmonic { reason: reason.to_owned(), span: driven_at };
    let mut own = model.clone();
    let mut pool = std::mem::take(&mut own.pool);
    let Some(time) = model.time() else { return Err(ResponseError::NotDriven {}) };
    let is_time = |symbol| symbol == time;
    let mut constants = all_terms(model).flat_map(|family| &family.constants);
    if model.constraints.iter().any(|own| pool.depends_on(own.expression, &is_time)) {
        return Err(not_harmonic("a constraint depends on the time"));
    }
    if constants.any(|constant| pool.depends_on(*constant, &is_time)) {
        return Err(not_harmonic("terms of a sum depend on the time, each in its own way"));
    }
    let known = values(model, &mut pool, &[parameter]);
    let rate = rate(model, &mut pool, time, &known, parameter, driven_at)?;
    let families = own.kinetic.iter_mut().chain(&mut own.potential);
    for family in families.chain(&mut own.forces) {
        if !pool.depends_on(family.body, &is_time) {
            continue;
        }
        if !has_two_harmonics(&mut pool, family, time, rate) {
            return Err(not_harmonic("it is no sum of sines and cosines of one angle, or has more than two harmonics"));
        }
        family.body = average(&mut pool, family.body, time, rate);
    }
    own.time_dependent = None;
    own.period = None;
    let is_fixed = is_fixed(&own, &mut pool, &known, model.parameters[parameter].symbol);
    own.pool = pool;
    Ok(Averaged { model: own, is_fixed, rate, driven_at })
}

/// Whether a model does not depend on a parameter, but for parts of its energies that contain neither coordinates nor velocities.
fn is_fixed(model: &Model, pool: &mut Pool, known: &Substitution, parameter: Symbol) -> bool {
    let given = model.equilibria.given().chain(model.guesses.given()).map(|given| given.symbolic);
    let constants = all_terms(model).flat_map(|family| family.constants.iter().copied());
    let constraints = model.constraints.iter().map(|own| own.expression);
    let rest: Vec<ExprId> = given.chain(constants).chain(constraints).collect();
    let rest = pool.substitute(&rest, known);
    if rest.into_iter().any(|e| pool.depends_on(e, &|symbol| symbol == parameter)) {
        return false;
    }
    let bodies: Vec<ExprId> = signed_terms(model).map(|(_, family)| family.body).collect();
    let drags: Vec<ExprId> = model.forces.iter().flat_map(|family| family.drags(pool)).map(|(_, drag)| drag).collect();
    let bodies = pool.substitute(&bodies, known);
    let changes: Vec<ExprId> = bodies.into_iter().map(|body| pool.diff(body, parameter)).collect();
    let slopes = changes.into_iter().flat_map(|change| pool.slopes(change, |symbol| symbol != parameter));
    let mut all: Vec<ExprId> = slopes.map(|(_, slope)| slope).collect();
    let drags = pool.substitute(&drags, known);
    all.extend(drags.into_iter().map(|drag| pool.diff(drag, parameter)));
    all.into_iter().all(|own| pool.vanishes(own))
}

/// Refuses what can't be taken apart; tells where the time occurs.
fn check(model: &Model) -> Result<Span, ResponseError> {
    let Some(span) = model.time_dependent else { return Err(ResponseError::NotDriven {}) };
    let refused = ["a drive under constraints on velocities", "a drive beside a steady motion"];
    if let Some((span, what)) = Mechanics::beside(model, refused) {
        return Err(ResponseError::Unsupported { what, span });
    }
    let terms = Mechanics::terms(model);
    if terms > MOST_TERMS {
        return Err(ResponseError::TooLarge { coordinates: model.coordinates.len(), terms });
    }
    Ok(span)
}

/// The one angular frequency of all sines and cosines with the time, with parameters in symbols.
fn rate(
    model: &Model,
    pool: &mut Pool,
    time: Symbol,
    known: &Substitution,
    parameter: usize,
    span: Span,
) -> Result<ExprId, ResponseError> {
    let mut rates: Vec<(ExprId, ExprId)> = Vec::new();
    for id in pool.reachable(&bodies(model)) {
        let Node::Function(Function::Sin | Function::Cos, x) = *pool.node(id) else { continue };
        let own = pool.diff(x, time);
        if pool.vanishes(own) {
            continue;
        }
        let own = if pool.display(own).starts_with('-') { pool.neg(own) } else { own };
        let value = pool.substitute_one(own, known);
        if pool.depends_on(value, &|symbol| symbol == time) {
            let reason = "an angle in it is not linear in the time".to_owned();
            return Err(ResponseError::NotHarmonic { reason, span });
        }
        let is_new = rates.iter().all(|(_, other)| !pool.agree(*other, value));
        rates.extend(is_new.then_some((own, value)));
    }
    // 2Ω, as of sin 2Ωt beside cos² Ωt, is the second harmonic of Ω.
    let halves: Vec<ExprId> = rates.iter().map(|own| pool.scale(own.1, &Number::half())).collect();
    if let [a, b] = rates[..] {
        let is_second = [pool.agree(halves[0], b.1), pool.agree(halves[1], a.1)];
        rates = [b, a].into_iter().zip(is_second).find(|own| own.1).map_or(rates, |own| vec![own.0]);
    }
    let named = |symbol| symbol == model.parameters[parameter].symbol;
    let is_open = |(_, value): &&(ExprId, ExprId)| pool.depends_on(*value, &named);
    let constant = |symbol| model.symbols.parameter(symbol).is_none();
    match rates.as_slice() {
        [] => {}
        [own] if pool.depends_on(own.1, &constant) => {}
        [own] if is_open(&own) => return Ok(own.0),
        all => {
            if let Some(own) = all.iter().find(is_open) {
                let Some(other) = all.iter().find(|other| other.0 != own.0) else { return Ok(own.0) };
                let [own, other] = [own.0, other.0].map(|rate| pool.display(rate));
                let reason = format!("sines and cosines in it have the angular frequencies {own} and {other}");
                return Err(ResponseError::NotHarmonic { reason, span });
            }
        }
    }
    let parameter = model.parameters[parameter].name.clone();
    let rate = rates.first().map(|(own, _)| pool.display(*own));
    Err(ResponseError::OtherFrequency { parameter, rate, span })
}

/// e'' + (k Ω)² e.
fn without_harmonic(pool: &mut Pool, e: ExprId, time: Symbol, rate: ExprId, harmonic: i64) -> ExprId {
    let square = pool.square(rate);
    let factor = pool.integer(harmonic * harmonic);
    let product = pool.product(&[factor, square, e]);
    let once = pool.diff(e, time);
    let twice = pool.diff(once, time);
    pool.add(twice, product)
}

/// Whether nothing is left of a body without its mean and two harmonics, identically: shown for what depends on the time without corners and
/// branches, which |cos Ωt| has, cos Ωt or -cos Ωt in between.
fn has_two_harmonics(pool: &mut Pool, family: &TermFamily, time: Symbol, rate: ExprId) -> bool {
    let varies = |e: &ExprId| pool.depends_on(*e, &|symbol| symbol == time);
    let is_smooth = |id: ExprId| match pool.node(id) {
        Node::Product(factors) => factors.iter().all(|(base, exponent)| exponent.is_integer() || !varies(base)),
        Node::Power { base, .. } => !varies(base),
        Node::Function(Function::Abs | Function::Asin | Function::Acos, x) => !varies(x),
        Node::Atan2 { .. } => !varies(&id),
        Node::Number(_) | Node::Pi | Node::Symbol(_) | Node::Undefined | Node::Sum { .. } | Node::Function(..) => true,
    };
    if !pool.reachable(&[family.body]).into_iter().all(is_smooth) {
        return false;
    }
    let slope = pool.diff(family.body, time);
    let left = [1, 2].into_iter().fold(slope, |left, harmonic| without_harmonic(pool, left, time, rate, harmonic));
    pool.vanishes(left)
}

/// The mean over four quarters of a period.
fn average(pool: &mut Pool, body: ExprId, time: Symbol, rate: ExprId) -> ExprId {
    let pi = pool.pi();
    let quarter = pool.div(pi, rate);
    let quarter = pool.scale(quarter, &Number::half());
    let share = Number::ratio(1, 4).unwrap_or_default();
    let parts: Vec<(ExprId, Number)> = (0..4)
        .map(|at| {
            let then = pool.scale(quarter, &Number::from(at));
            (pool.substitute_one(body, &Substitution::from([(time, then)])), share.clone())
        })
        .collect();
    pool.linear(&parts)
}

impl Averaged {
    /// The force at the equilibrium of the averaged model; `model` is the one with its drive.
    pub(super) fn drive(
        &self,
        model: &Model,
        parameter: usize,
        linearized: &Linearized,
    ) -> Result<Drive, ResponseError> {
        let span = self.driven_at;
        let mut pool = self.model.pool.clone();
        let known = values(model, &mut pool, &[parameter]);
        let mut mechanics = Mechanics::new(model, pool, &known);
        let equations = mechanics.equations();
        let place: Substitution = self.place(linearized, &mut mechanics);
        let (time, coordinates) = (mechanics.time, mechanics.coordinates.clone());
        let velocities = mechanics.velocities.clone();
        let mut pool = mechanics.pool;
        let rate = pool.substitute_one(self.rate, &known);
        let loads: Vec<ExprId> = equations.iter().map(|own| own.load).collect();
        let mass: Vec<ExprId> = equations.iter().flat_map(|own| own.mass.iter().map(|(_, entry)| *entry)).collect();
        check_parametric(&mut pool, "the mass matrix", mass, time, &place, span)?;
        for (variables, matrix) in [(&coordinates, "the stiffness"), (&velocities, "what goes with the velocities")] {
            let slopes = |load: &ExprId| pool.slopes(*load, |symbol| variables.contains(&symbol));
            let slopes = loads.iter().flat_map(slopes).map(|(_, slope)| slope).collect();
            check_parametric(&mut pool, matrix, slopes, time, &place, span)?;
        }
        let forces = pool.substitute(&loads, &place);
        let start = Substitution::from([(time, pool.zero())]);
        let slopes = forces.into_iter().map(|force| pool.diff(force, time)).enumerate();
        let mut slopes: Vec<(usize, ExprId)> = slopes.collect();
        slopes.retain(|(_, slope)| !pool.vanishes(*slope));
        // sin(Ωt) cos(Ωt) has the second alone.
        let others = [1, 2].map(|harmonic| {
            slopes.iter().position(|(_, slope)| {
                let left = without_harmonic(&mut pool, *slope, time, rate, harmonic);
                !pool.vanishes(left)
            })
        });
        let rate = match others {
            [None, _] => rate,
            [Some(_), None] => pool.scale(rate, &Number::from(2)),
            [Some(at), Some(_)] => {
                let own = model.coordinates.at(slopes[at].0).name();
                let reason = format!("the force on `{own}` has more than one harmonic, or forces have different ones");
                return Err(ResponseError::NotHarmonic { reason, span });
            }
        };
        let (mut driven, mut roots) = (Vec::new(), vec![rate]);
        for (at, slope) in slopes {
            // With h = const + c cos(Ωt) + s sin(Ωt) the force is -c and -s: h'' = -Ω² c and h' = Ω s at t = 0.
            let curvature = pool.diff(slope, time);
            let [slope, curvature] = [slope, curvature].map(|e| pool.substitute_one(e, &start));
            let square = pool.square(rate);
            let sine = pool.div(slope, rate);
            roots.push(pool.div(curvature, square));
            roots.push(pool.neg(sine));
            driven.push(at);
        }
        let mut inputs = vec![model.parameters[parameter].symbol];
        for at in 0..roots.len() {
            roots.push(pool.diff(roots[at], inputs[0]));
        }
        inputs.extend(&coordinates);
        let tape =
            Tape::compile(&pool, &roots, &inputs).map_err(|unbound| match model.symbols.parameter(unbound.symbol) {
                Some(number) => ResponseError::Linearize(missing_value(model, number)),
                None => ResponseError::NotHarmonic { reason: "its force has no value".to_owned(), span },
            })?;
        Ok(Drive { coordinates: driven, tape, pool, rate, parameter: model.parameters[parameter].symbol })
    }

    /// Rest at the equilibrium, where it is known exactly; coordinates that were searched for stay symbols.
    fn place(&self, linearized: &Linearized, mechanics: &mut Mechanics<'_>) -> Substitution {
        let equilibrium = linearized.equilibrium();
        let zero = mechanics.pool.zero();
        let mut place: Substitution = mechanics.velocities.iter().map(|velocity| (*velocity, zero)).gather();
        for (at, coordinate) in mechanics.coordinates.iter().enumerate() {
            let value = equilibrium.values.get(at);
            if value.is_some_and(|value| value.is_zero()) {
                place.insert(*coordinate, zero);
            } else if let Some(value) = equilibrium.expression(&self.model, at) {
                place.insert(*coordinate, value);
            }
        }
        place
    }
}

/// Refuses entries of a matrix that depend on the time at a place.
fn check_parametric(
    pool: &mut Pool,
    matrix: &'static str,
    entries: Vec<ExprId>,
    time: Symbol,
    place: &Substitution,
    span: Span,
) -> Result<(), ResponseError> {
    for entry in pool.substitute(&entries, place) {
        let slope = pool.diff(entry, time);
        let verdict = pool.is_zero(slope);
        if verdict != ZeroVerdict::Zero {
            let proved = verdict == ZeroVerdict::NonZero && pool.is_zero(entry) != ZeroVerdict::Unknown;
            return Err(ResponseError::Parametric { matrix, proved, span });
        }
    }
    Ok(())
}

impl Drive {
    /// The frequency for a rational value of the parameter, where its square is rational.
    pub(super) fn exactly(&self, parameter: &Number) -> Option<Frequency> {
        let mut pool = self.pool.clone();
        let parameter = Substitution::from([(self.parameter, pool.number(parameter.clone()))]);
        let rate = pool.substitute_one(self.rate, &parameter);
        Frequency::of(&mut pool, rate)
    }

    /// The angular frequency and the force on each coordinate, for a value of the parameter; then their slopes over it. F cos(Ωt) + F' sin(Ωt) is
    /// the real part of (F - iF') e^(iΩt).
    pub(super) fn at<S: Enclosure>(
        &self,
        parameter: &S,
        point: &[S],
        precision: S::Precision,
    ) -> Option<[Driven<S>; 2]> {
        let inputs: Vec<S> = std::iter::once(parameter).chain(point).cloned().collect();
        let numbers = self.tape.prepare::<S>(precision).evaluate(&inputs, &mut Vec::new());
        let own = |numbers: &[S]| {
            let (rate, forces) = numbers.split_first()?;
            let forces = self.coordinates.iter().zip(forces.chunks_exact(2));
            let forces = forces.map(|(at, pair)| (*at, Complex::new(pair[0].clone(), pair[1].neg())));
            numbers.iter().all(S::is_finite).then(|| (rate.clone(), forces.collect()))
        };
        let (values, slopes) = numbers.split_at(numbers.len() / 2);
        Some([own(values)?, own(slopes)?])
    }
}
