//! The same matrices as expressions: what `derive` shows, and the forces that messages name.
//!
//! Families are written out here, instance by instance, with the model's own symbols. Numeric
//! commands never come this way, but for an error message.

use std::collections::BTreeMap;

use hashbrown::HashSet;

use super::assemble::{Assembly, evaluate_closed, signed_terms};
use super::elements::Element;
use super::equilibrium::{Equilibrium, Origin, short};
use super::error::LinearizeError;
use super::multipliers::SymbolicConstraints;
use super::parameters::known_values;
use super::rolling::SymbolicRolling;
use super::velocity::Matrix;
use crate::expr::{ExprId, Function, Pool, Substitution, Symbol, ZeroVerdict};
use crate::model::{Model, SymbolKind, TermFamily};
use crate::number::Number;
use crate::order::Gather;
use crate::precision::Ball;
use crate::syntax::Comparison;

/// Messages write out at most this many instances.
const MOST_FOR_MESSAGES: usize = 10_000;

/// M and K at the equilibrium, as expressions in the parameters.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct SymbolicMatrices {
    /// Where the expressions live.
    pub pool: Pool,
    /// The coordinates' names.
    pub coordinates: Vec<String>,
    /// The equilibrium; a coordinate that was found numerically stands as itself.
    pub equilibrium: Vec<ExprId>,
    /// Whether such coordinates were not searched for, since parameters have no values.
    pub(crate) open: bool,
    /// A force that vanishes there at the values of the parameters alone, with the name of its coordinate.
    pub(crate) at_values: Option<(String, String)>,
    /// The mass matrix, row by row.
    pub mass: Vec<Vec<ExprId>>,
    /// The stiffness matrix, row by row.
    pub stiffness: Vec<Vec<ExprId>>,
    /// The gyroscopic matrix G, row by row; `None` where it is 0.
    pub gyroscopic: Option<Vec<Vec<ExprId>>>,
    /// The damping matrix C, row by row; `None` where it is 0.
    pub damping: Option<Vec<Vec<ExprId>>>,
    /// The circulatory matrix N of friction that acts at rest, row by row; `None` where it is 0.
    pub circulatory: Option<Vec<Vec<ExprId>>>,
    /// What constraints add; `None` where there are none that are independent.
    pub constraints: Option<SymbolicConstraints>,
    /// What conditions on velocities leave; `None` where there are none.
    pub rolling: Option<SymbolicRolling>,
}

impl SymbolicMatrices {
    /// Whether an entry has no value.
    pub(super) fn are_undefined(&self) -> bool {
        let others = [&self.gyroscopic, &self.damping, &self.circulatory];
        let all = [&self.mass, &self.stiffness].into_iter();
        let mut entries = all.chain(others.into_iter().flatten()).flatten().flatten();
        entries.any(|entry| self.pool.is_undefined(*entry))
    }

    /// Keeps what belongs to the first coordinates: those before multipliers.
    pub(super) fn first(&mut self, visible: usize) {
        let others = [&mut self.gyroscopic, &mut self.damping, &mut self.circulatory];
        let all = [&mut self.mass, &mut self.stiffness].into_iter();
        for rows in all.chain(others.into_iter().flatten()) {
            rows.truncate(visible);
            for row in rows {
                row.truncate(visible);
            }
        }
        self.coordinates.truncate(visible);
        self.equilibrium.truncate(visible);
    }
}

/// The replacement that turns a family's body into the term of one instance.
pub fn instance(
    model: &Model,
    pool: &mut Pool,
    terms: &TermFamily,
    at: usize,
    equilibrium: Option<&[ExprId]>,
) -> Substitution {
    let mut map = Substitution::default();
    for (local, number) in terms.locals.iter().zip(terms.coordinates_of(at)) {
        let coordinate = model.coordinates.at(*number as usize);
        let q = equilibrium.map_or_else(|| pool.symbol_expr(coordinate.symbol), |values| values[*number as usize]);
        let v = pool.symbol_expr(coordinate.velocity);
        map.insert(local.coordinate, q);
        map.insert(local.velocity, v);
    }
    for (symbol, constant) in terms.values.iter().zip(terms.constants_of(at)) {
        map.insert(*symbol, *constant);
    }
    map
}

/// An expression of a family's body, for each of its instances.
pub(crate) fn instances(
    model: &Model,
    pool: &mut Pool,
    terms: &TermFamily,
    e: ExprId,
    point: Option<&[ExprId]>,
) -> Vec<ExprId> {
    let own = (0..terms.count).map(|at| {
        let map = instance(model, pool, terms, at, point);
        pool.substitute_one(e, &map)
    });
    own.collect()
}

/// The sum of some terms, every instance, at a point if one is given, with the values that are known; a term that comes
/// with `true` is taken away.
pub fn written_out<'a>(
    model: &Model,
    pool: &mut Pool,
    families: impl Iterator<Item = (bool, &'a TermFamily)>,
    point: Option<&[ExprId]>,
    known: &Substitution,
) -> ExprId {
    let mut terms = Vec::new();
    for (negative, family) in families {
        let sign = if negative { Number::MINUS_ONE } else { Number::ONE };
        terms.extend(instances(model, pool, family, family.body, point).into_iter().map(|term| (term, sign.clone())));
    }
    let sum = pool.linear(&terms);
    pool.substitute_one(sum, known)
}

/// A generalised force by coordinate, written out.
pub fn forces_of(model: &Model, pool: &mut Pool, family: &TermFamily) -> Vec<(usize, ExprId)> {
    let forces = instances(model, pool, family, family.body, None).into_iter().enumerate();
    let forces = forces.filter_map(|(at, force)| Some((family.coordinates_of(at)[family.acts_on?] as usize, force)));
    forces.collect()
}

/// What forces that no energy gives add to the left sides of Lagrange's equations at rest: coordinates and shares.
pub(super) fn drags_at_rest(model: &Model, pool: &mut Pool) -> Vec<(usize, ExprId)> {
    let mut shares = Vec::new();
    for family in &model.forces {
        let at_rest = family.at_rest(pool);
        for (place, drag) in family.drags(pool) {
            let drag = pool.substitute_one(drag, &at_rest);
            let own = instances(model, pool, family, drag, None).into_iter().enumerate();
            shares.extend(own.map(|(at, share)| (family.coordinates_of(at)[place] as usize, share)));
        }
    }
    shares
}

/// The generalised force -∂V/∂q at velocity zero with what no energy gives, as an expression; `None` where there
/// are too many terms to write out.
fn force(model: &Model, pool: &mut Pool, coordinate: usize) -> Option<ExprId> {
    let families = signed_terms(model).map(|(_, terms)| terms).chain(&model.forces);
    let total: usize = families.map(|terms| terms.count).sum();
    if total > MOST_FOR_MESSAGES {
        return None;
    }
    let symbol = model.coordinates.at(coordinate).symbol;
    let mut parts = Vec::new();
    for (negative, terms) in signed_terms(model) {
        for at in 0..terms.count {
            if !terms.coordinates_of(at).contains(&u32::try_from(coordinate).ok()?) {
                continue;
            }
            let map = instance(model, pool, terms, at, None);
            let body = pool.substitute_one(terms.body, &map);
            let body = model.at_rest(pool, body);
            let slope = pool.diff(body, symbol);
            parts.push(if negative { pool.neg(slope) } else { slope });
        }
    }
    let drags = drags_at_rest(model, pool).into_iter().filter(|(at, _)| *at == coordinate);
    parts.extend(drags.map(|(_, drag)| pool.neg(drag)));
    Some(pool.sum(&parts))
}

/// A force in a message: the expression where it is short, and the number.
pub(crate) fn force_text(model: &Model, coordinate: usize, value: f64) -> String {
    let mut pool = model.pool.clone();
    let expression =
        force(model, &mut pool, coordinate).map(|force| pool.display(force)).filter(|text| text.chars().count() <= 80);
    match expression {
        Some(text) if text == short(value) => text,
        Some(text) => format!("{text} = {}", short(value)),
        None => short(value),
    }
}

/// The force on a coordinate, if it is the same everywhere and not zero.
pub(crate) fn constant_force(model: &Model, coordinate: usize, value: f64) -> Option<String> {
    let mut pool = model.pool.clone();
    let force = force(model, &mut pool, coordinate)?;
    let varies = |symbol| !matches!(model.symbols.get(symbol), Some(SymbolKind::Parameter(_)) | None);
    (value != 0.0 && !pool.depends_on(force, &varies)).then(|| force_text(model, coordinate, value))
}

/// Whether the force along a combination of coordinates is the same everywhere, with the values
/// that the parameters have; `None` where there is too much to write out.
pub(crate) fn constant_along(model: &Model, motion: &[(usize, Number)]) -> Option<bool> {
    let mut pool = model.pool.clone();
    let mut parts = Vec::new();
    for (coordinate, factor) in motion {
        let own = force(model, &mut pool, *coordinate)?;
        parts.push(pool.scale(own, factor));
    }
    let total = pool.sum(&parts);
    let total = pool.substitute_one(total, &known_values(model));
    // Between corners a force may be constant, and another one behind them.
    let moves = |symbol| model.coordinates.iter().any(|own| own.symbol == symbol);
    if !pool.with_signs(&[total], moves).1.is_empty() {
        return Some(false);
    }
    Some(model.coordinates.iter().all(|coordinate| {
        let slope = pool.diff(total, coordinate.symbol);
        pool.vanishes(slope)
    }))
}

/// Where the model says, or, with `guessed`, where it guesses, or 0.
pub(super) fn stated(model: &Model, guessed: bool) -> Vec<ExprId> {
    let both = model.equilibria.iter().zip(model.guesses.iter());
    let stated = both.map(|(given, guess)| given.or(guess.filter(|_| guessed)));
    stated.map(|own| own.map_or(model.pool.zero(), |own| own.symbolic)).collect()
}

/// The equilibrium as `derive` shows it: what was searched for stands as itself.
pub(crate) fn equilibrium_expressions(model: &Model, pool: &mut Pool, equilibrium: &Equilibrium) -> Vec<ExprId> {
    let mut point = stated(model, false);
    for (i, coordinate) in model.coordinates.iter().enumerate() {
        if equilibrium.origins[i] == Origin::Found && model.equilibria.get(i).is_none() {
            point[i] = pool.symbol_expr(coordinate.symbol);
        }
    }
    point
}

/// Whether all forces vanish identically at a point, whatever the parameters but for those `known`; `None` if
/// that can't be said.
pub(crate) fn forces_vanish(
    model: &Model,
    assembly: &Assembly,
    point: &[ExprId],
    known: &Substitution,
) -> Option<bool> {
    let Some((mut pool, forces)) = forces(model, model.pool.clone(), assembly, point) else { return Some(false) };
    let mut decided = true;
    for force in forces.into_values() {
        let force = pool.substitute_one(force, known);
        match pool.is_zero(force) {
            ZeroVerdict::Zero => {}
            ZeroVerdict::NonZero => return Some(false),
            ZeroVerdict::Unknown => decided = false,
        }
    }
    decided.then_some(true)
}

/// The first force at a point that is given in full which is not 0 whatever the parameters are.
pub(crate) fn doubtful_force(model: &Model, assembly: &Assembly, point: &[ExprId]) -> Option<LinearizeError> {
    let given = model.equilibria.given().next()?.span;
    if model.equilibria.iter().any(|given| given.is_none()) {
        return None;
    }
    let (mut pool, forces) = forces(model, model.pool.clone(), assembly, point)?;
    let (number, force) = forces.into_iter().find(|(_, force)| !pool.vanishes(*force))?;
    let force = pool.neg(force);
    let functions = pool.reachable(&[force]).into_iter().filter_map(|id| pool.as_function(id));
    let sizes = functions.filter(|(function, _)| *function == Function::Abs);
    let unsigned = sizes.map(|(_, x)| pool.display(x));
    Some(LinearizeError::ForceOfParameters {
        coordinate: model.coordinates.get(number as usize)?.name(),
        force: pool.display(force),
        unsigned: unsigned.collect(),
        span: given,
    })
}

/// A force that is the same wherever coordinates are that stand as themselves at a point.
pub(super) struct ConstantForce {
    /// The number of its coordinate.
    pub(super) number: usize,
    force: ExprId,
    pool: Pool,
}

impl ConstantForce {
    /// A force that does not vanish identically at a point of a pool wherever coordinates are that stand as themselves there.
    pub(super) fn find(model: &Model, pool: Pool, assembly: &Assembly, point: &[ExprId]) -> Option<Self> {
        let (mut pool, forces) = forces(model, pool, assembly, point)?;
        let coordinates: HashSet<Symbol> = model.coordinates.iter().map(|own| own.symbol).collect();
        let is_open = |symbol| coordinates.contains(&symbol);
        let mut all = forces.into_iter();
        let (number, force) = all.find(|(_, force)| !pool.vanishes(*force) && !pool.depends_on(*force, &is_open))?;
        let force = pool.neg(force);
        Some(Self { number: number as usize, force, pool })
    }

    /// It in the model language.
    pub(super) fn text(&self) -> String {
        self.pool.display(self.force)
    }

    /// Whether it is different from 0 whatever the parameters, by what is assumed of them.
    pub(super) fn acts(&mut self, model: &Model) -> bool {
        let pool = &mut self.pool;
        let is_strict = |of| matches!(of, Comparison::Greater | Comparison::Less | Comparison::NotEqual);
        let strict = model.assumptions.iter().filter(|own| is_strict(own.relation));
        let differences = strict.flat_map(|own| [pool.sub(own.left, own.right), pool.sub(own.right, own.left)]);
        let excluded: Vec<ExprId> = differences.collect();
        let (_, core) = pool.split_content(self.force);
        pool.factors(core).iter().all(|(base, _)| excluded.contains(base) || pool.as_number(*base).is_some())
    }

    /// Whether it is different from 0 where parameters have values beside those that they have.
    pub(super) fn acts_nearby(&mut self, model: &Model) -> bool {
        let nearby = model.parameters.iter().zip(1..).filter_map(|(own, number)| {
            let value = evaluate_closed::<f64>(&model.pool, own.value?, ())?;
            let step = 1e-3 / f64::from(number);
            let value = if value == 0.0 { step } else { value * (1.0 + step) };
            Some((own.symbol, self.pool.number(Number::from_f64_exact(value)?)))
        });
        let nearby = nearby.collect();
        let value = self.pool.substitute_one(self.force, &nearby);
        evaluate_closed::<Ball>(&self.pool, value, ()).is_some_and(|value| !value.contains_zero())
    }
}

/// The derivatives of V - T0 and what friction adds at rest, one a coordinate, at a point of a pool, which comes with them; none where
/// one of them is undefined.
pub(super) fn forces(
    model: &Model,
    mut pool: Pool,
    assembly: &Assembly,
    point: &[ExprId],
) -> Option<(Pool, BTreeMap<u32, ExprId>)> {
    for (family, at) in assembly.instances() {
        let map = instance(model, &mut pool, &family.terms, at, Some(point));
        let logarithms = pool.substitute(&family.logarithms, &map);
        if logarithms.iter().any(|e| pool.is_undefined(*e))
            || family.potential.iter().any(|element| element.is_undefined_at(&mut pool, &map))
        {
            return None;
        }
    }
    let forces = at_rest(model, &mut pool, assembly, point);
    let sums = forces.into_iter().map(|(coordinate, parts)| (coordinate, pool.sum(&parts))).gather();
    Some((pool, sums))
}

/// What numbers are the sums of, by coordinate or by the coordinates of an entry.
pub(super) type Parts<K = u32> = BTreeMap<K, Vec<ExprId>>;

/// The derivatives of V - T0 at a point and what friction adds at rest, by coordinate: what each is the sum of.
pub(super) fn at_rest(model: &Model, pool: &mut Pool, assembly: &Assembly, point: &[ExprId]) -> Parts {
    let mut forces = slopes(model, pool, assembly, point);
    for (family, place, force) in assembly.friction_at_rest() {
        for (at, part) in instances(model, pool, family, force, Some(point)).into_iter().enumerate() {
            forces.entry(family.coordinates_of(at)[place]).or_default().push(part);
        }
    }
    forces
}

/// The derivatives of V - T0 at a point, one a coordinate.
pub(super) fn gradient(model: &Model, pool: &mut Pool, assembly: &Assembly, point: &[ExprId]) -> Vec<ExprId> {
    let mut gradient = vec![pool.zero(); model.coordinates.len()];
    for (number, parts) in slopes(model, pool, assembly, point) {
        gradient[number as usize] = pool.sum(&parts);
    }
    gradient
}

/// The same by coordinate: what each is the sum of.
fn slopes(model: &Model, pool: &mut Pool, assembly: &Assembly, point: &[ExprId]) -> Parts {
    let mut gradient = Parts::new();
    for (family, at) in assembly.instances() {
        let map = instance(model, pool, &family.terms, at, Some(point));
        let coordinates = family.terms.coordinates_of(at);
        for element in &family.potential {
            let here = element.substituted(pool, &map);
            for (place, slope) in &here.slope {
                let part = pool.mul(here.first, *slope);
                gradient.entry(coordinates[*place]).or_default().push(part);
            }
        }
    }
    gradient
}

/// Writes M and K out at an equilibrium.
pub(crate) fn matrices(model: &Model, assembly: &Assembly, equilibrium: &Equilibrium) -> SymbolicMatrices {
    let mut pool = model.pool.clone();
    let point = equilibrium_expressions(model, &mut pool, equilibrium);
    matrices_at(model, pool, assembly, &point)
}

/// Writes M and K out at a point of expressions of a pool that builds on the model's.
pub(super) fn matrices_at(model: &Model, mut pool: Pool, assembly: &Assembly, point: &[ExprId]) -> SymbolicMatrices {
    let n = model.coordinates.len();
    let mut mass = BTreeMap::new();
    let mut stiffness = BTreeMap::new();
    for (family, at) in assembly.instances() {
        let map = instance(model, &mut pool, &family.terms, at, Some(point));
        let coordinates = family.terms.coordinates_of(at);
        for (elements, into) in [(&family.inertia, &mut mass), (&family.potential, &mut stiffness)] {
            for element in elements {
                let here = element.substituted(&mut pool, &map);
                scatter(&mut pool, &here, coordinates, into);
            }
        }
    }
    let mut dense = |entries: Parts<(u32, u32)>| {
        let mut rows = vec![vec![pool.zero(); n]; n];
        for ((i, j), parts) in entries {
            let (i, j) = (i as usize, j as usize);
            rows[i][j] = pool.sum(&parts);
            rows[j][i] = rows[i][j];
        }
        rows
    };
    let mass = dense(mass);
    let stiffness = dense(stiffness);
    // G, C and N, unless they are shown to be 0.
    let [gyroscopic, damping, circulatory] = [Matrix::Gyroscopic, Matrix::Damping, Matrix::Circulatory].map(|matrix| {
        let mut rows: Option<Vec<Vec<ExprId>>> = None;
        for ((i, j), parts) in shares_of_velocities(model, &mut pool, assembly, matrix, point) {
            let entry = pool.sum(&parts);
            if !pool.vanishes(entry) {
                rows.get_or_insert_with(|| vec![vec![pool.zero(); n]; n])[i][j] = entry;
            }
        }
        rows
    });
    SymbolicMatrices {
        gyroscopic,
        damping,
        circulatory,
        coordinates: model.coordinates.names().collect(),
        equilibrium: point.to_vec(),
        open: false,
        at_values: None,
        constraints: None,
        rolling: None,
        mass,
        stiffness,
        pool,
    }
}

/// Whether G, C or N is proved to be zero at a point of expressions.
pub(super) fn vanishes(model: &mut Model, assembly: &Assembly, matrix: Matrix, point: &[ExprId]) -> bool {
    model.with_pool(|model, pool| {
        shares_of_velocities(model, pool, assembly, matrix, point).values().all(|parts| {
            let entry = pool.sum(parts);
            pool.vanishes(entry)
        })
    })
}

/// What the entries of G, C or N are the sums of.
fn shares_of_velocities(
    model: &Model,
    pool: &mut Pool,
    assembly: &Assembly,
    matrix: Matrix,
    point: &[ExprId],
) -> Parts<(usize, usize)> {
    let mut entries: Parts<(usize, usize)> = Parts::new();
    for (family, i, j, share) in assembly.velocity_expressions(matrix) {
        for (at, share) in instances(model, pool, family, share, Some(point)).into_iter().enumerate() {
            let numbers = family.coordinates_of(at);
            let (i, j) = (numbers[i] as usize, numbers[j] as usize);
            if matrix == Matrix::Gyroscopic {
                if i == j {
                    continue;
                }
                let opposite = pool.neg(share);
                entries.entry((j, i)).or_default().push(opposite);
            }
            entries.entry((i, j)).or_default().push(share);
        }
    }
    entries
}

/// Adds w·phi''·∇s∇sᵀ + w·phi'·∇∇s of one element to the upper triangle.
fn scatter(pool: &mut Pool, element: &Element, coordinates: &[u32], into: &mut Parts<(u32, u32)>) {
    let two = Number::from(2);
    let mut add = |pool: &mut Pool, a: u32, b: u32, value: ExprId, twice: bool| {
        // Two slots that hold the same coordinate meet on the diagonal from both sides.
        let value = if twice && a == b { pool.scale(value, &two) } else { value };
        into.entry((a.min(b), a.max(b))).or_default().push(value);
    };
    if !element.second.is_zero() {
        for (k, (a, left)) in element.slope.iter().enumerate() {
            for (l, (b, right)) in element.slope.iter().enumerate().skip(k) {
                let value = pool.product(&[element.second, *left, *right]);
                add(pool, coordinates[*a], coordinates[*b], value, k != l);
            }
        }
    }
    for (a, b, bend) in &element.curvature {
        let value = pool.mul(element.first, *bend);
        add(pool, coordinates[*a], coordinates[*b], value, a != b);
    }
}
