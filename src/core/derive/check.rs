//! Closed forms against certified numbers.
//!
//! Where all parameters have values the model goes the whole way to its normal modes, by the other path, and
//! the closed forms are evaluated with rigorous bounds at the same values; where some have none, M and K
//! are evaluated at values drawn for them. A closed form stands if there are as many modes as its multiplicity says whose
//! enclosures meet it, each mode counted once.

use std::cell::OnceCell;
use std::collections::{BTreeMap, BTreeSet};

use hashbrown::HashMap;

use super::collapse::angle;
use super::cubic::Solved;
use super::frequencies::{Case, Frequency};
use super::pair::Pair;
use super::simplify::{Algebra, bases_with};
use crate::expr::{ExprId, Pool, Symbol, Tape, mix};
use crate::linearize::{self, LinearizeError, Linearized, Units, evaluate_closed, known_values, may_be_singular};
use crate::model::Model;
use crate::modes::{self, Options, Problem};
use crate::number::Number;
use crate::order::Order;
use crate::oscillation::{NormalMode, NormalModes, in_units, mass_error, normal_modes};
use crate::precision::{Ball, Big, Function, Magnitude, Scalar};
use crate::syntax::Comparison;

/// An enclosure has to tell so much of a number.
pub(super) const WIDEST: f64 = 1e-9;

/// Bits of numbers beyond the range of balls.
const BITS: usize = 192;

/// Values that are smaller than this, or larger than its reciprocal, may make no difference beside others.
const LEAST_ALIKE: f64 = 1e-6;

/// As often values are drawn that the model's assumptions hold for.
const MOST_DRAWS: usize = 1000;

/// What has a sign at the values of the parameters, and whether that is negative.
pub(super) type Signs = BTreeSet<(ExprId, bool)>;

/// Letters for whole numbers, and lists of their values.
pub(super) type Letters<'a> = (&'a [Symbol], &'a [Vec<i64>]);

/// What is replaced by what it is at the values of the parameters.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Resolve {
    /// acos(cos(x)) by x, between 0 and pi.
    Angles,
    /// Absolute values.
    Sizes,
}

/// A mode in closed form.
pub(super) struct Column {
    pub(super) omega_squared: ExprId,
    /// xᵀMx
    pub(super) mass: ExprId,
    pub(super) vector: Vec<ExprId>,
}

/// A mode to compare with.
#[derive(Clone)]
struct Reference {
    omega_squared: Ball,
    symmetry: Option<String>,
}

/// What closed forms are compared with. The model goes its way to numbers only where there is something to
/// compare.
pub(super) struct Checker<'a> {
    pub(super) model: &'a Model,
    /// The values of parameters, drawn for those that have none.
    values: HashMap<Symbol, Ball>,
    /// Whether all parameters have values.
    complete: bool,
    /// How often values had to be drawn.
    draws: usize,
    /// The model in numbers.
    sample: OnceCell<Option<Linearized>>,
    modes: OnceCell<Option<NormalModes>>,
}

impl<'a> Checker<'a> {
    pub(super) fn new(model: &'a Model) -> Self {
        let mut checker = Self::drawn(model, 0);
        while !checker.complete && checker.draws < MOST_DRAWS {
            // Only assumptions may want negative values.
            let steps = if !checker.assumptions_hold() {
                1
            } else if !checker.is_real() {
                2
            } else {
                break;
            };
            checker = Self::drawn(model, checker.draws + steps);
        }
        checker
    }

    fn drawn(model: &'a Model, draws: usize) -> Self {
        let mut values = HashMap::new();
        let mut complete = true;
        for (i, parameter) in model.parameters.iter().enumerate() {
            let value = parameter.value;
            let value = value.and_then(|value| evaluate_closed(&model.pool, value, BITS));
            let value = value.map(|value: Big| value.to_far_ball());
            complete &= value.is_some();
            values.insert(parameter.symbol, value.unwrap_or_else(|| Ball::from_number(&drawn(i, draws), ())));
        }
        Self { model, values, complete, draws, sample: OnceCell::new(), modes: OnceCell::new() }
    }

    /// Whether the values are as the model assumes.
    fn assumptions_hold(&self) -> bool {
        self.model.assumptions.iter().all(|own| {
            let sides = self.evaluate(&self.model.pool, &[own.left, own.right]);
            let difference = sides.map(|sides| sides[0].sub(&sides[1]));
            difference.is_some_and(|difference| match own.relation {
                Comparison::Greater | Comparison::GreaterEqual => difference.is_positive(),
                Comparison::Less | Comparison::LessEqual => difference.is_negative(),
                Comparison::Equal | Comparison::NotEqual => true,
            })
        })
    }

    /// Whether a given equilibrium and the roots of parameters in the energies and forces are real at the values.
    fn is_real(&self) -> bool {
        let (model, pool) = (self.model, &self.model.pool);
        let given: Vec<ExprId> = model.equilibria.given().map(|own| own.symbolic).collect();
        let terms = [&model.kinetic, &model.potential, &model.forces].into_iter().flatten().map(|own| own.body);
        let is_root = |base, power: &Number| {
            !power.is_integer() && pool.symbols_of(&[base]).iter().all(|own| self.values.contains_key(own))
        };
        let below = bases_with(pool, &terms.collect::<Vec<_>>(), is_root);
        let is_finite = |own: &[ExprId]| self.evaluate(pool, own).is_none_or(|own| own.iter().all(Ball::is_finite));
        is_finite(&given) && below.iter().all(|own| self.is_negative(pool, *own) != Some(true))
    }

    /// The model in numbers, where all parameters have values.
    pub(super) fn linearized(&self) -> Option<&Linearized> {
        if self.complete { self.sample() } else { None }
    }

    /// The same with values drawn for those that have none.
    fn sample(&self) -> Option<&Linearized> {
        let made = self.sample.get_or_init(|| {
            let count = self.model.coordinates.len();
            let wanted = !self.complete || count > 0 && linearize::check_size(count).is_ok();
            let mut model = wanted.then(|| self.model.clone())?;
            for (i, parameter) in model.parameters.iter_mut().enumerate() {
                parameter.value.get_or_insert_with(|| model.pool.number(drawn(i, self.draws)));
            }
            linearize::linearize(model).ok()
        });
        made.as_ref()
    }

    /// That the coordinates lose a motion at the equilibrium which they have beside it (gimbal lock), at the values of the
    /// parameters or drawn ones.
    pub(super) fn singular_coordinates(&self, pool: &Pool, mass: &[Vec<ExprId>]) -> Option<LinearizeError> {
        let values = self.evaluate(pool, &mass.concat())?;
        if !may_be_singular(mass.len(), &values) {
            return None;
        }
        let LinearizeError::SingularCoordinates { combination, span, .. } = mass_error(self.sample()?)? else {
            return None;
        };
        Some(LinearizeError::SingularCoordinates { combination, drawn: !self.complete, span })
    }

    /// Its modes, in SI.
    fn modes(&self) -> Option<&NormalModes> {
        let solve = |own: &Linearized| normal_modes(own, &Options::default().without_vectors()).ok();
        self.modes.get_or_init(|| self.linearized().and_then(solve)).as_ref()
    }

    /// The same, once nothing is left to compare.
    pub(super) fn into_modes(self) -> Option<NormalModes> {
        self.modes();
        self.modes.into_inner().flatten()
    }

    /// Whether a symbol is a parameter with a value.
    pub(super) fn has_value(&self, symbol: Symbol) -> bool {
        self.model.parameters.iter().any(|parameter| parameter.symbol == symbol && parameter.value.is_some())
    }

    /// Whether a parameter is negative, where it has a value that tells.
    pub(super) fn sign(&self, symbol: Symbol) -> Option<bool> {
        let value = self.values.get(&symbol).filter(|value| self.has_value(symbol) && !value.contains_zero());
        value.map(Ball::is_negative)
    }

    /// What the numbers of the other path are measured in, where that is not SI.
    fn units(&self) -> Option<&Units> {
        self.linearized()?.units()
    }

    /// Whether an expression is different from 0 at the values of the parameters, drawn ones too.
    pub(super) fn differs_from_zero(&self, pool: &Pool, e: ExprId) -> bool {
        self.is_negative(pool, e).is_some()
    }

    /// Whether an expression is negative there, if it is different from 0.
    pub(super) fn is_negative(&self, pool: &Pool, e: ExprId) -> Option<bool> {
        let value = self.evaluate(pool, &[e])?;
        (value[0].is_finite() && !value[0].contains_zero()).then(|| value[0].is_negative())
    }

    /// Expressions with the values that parameters have.
    pub(super) fn at_values(&self, pool: &mut Pool, all: &[ExprId]) -> Vec<ExprId> {
        pool.substitute(all, &known_values(self.model))
    }

    /// Modes to hold exponents against, where all parameters have values and the model is in no units of its own.
    pub(super) fn exponents(&self) -> Option<&[NormalMode]> {
        self.linearized().filter(|own| own.units().is_none())?;
        self.modes().map(|own| own.modes.as_slice())
    }

    /// The value of a parameter, or of a coordinate or multiplier at an equilibrium that was searched for.
    fn value(&self, pool: &Pool, symbol: Symbol) -> Option<Ball> {
        if let Some(value) = self.values.get(&symbol) {
            return Some(*value);
        }
        let mut coordinates = self.model.coordinates.iter();
        if let Some(at) = coordinates.position(|coordinate| coordinate.symbol == symbol) {
            return match self.sample() {
                Some(own) => own.equilibrium().values.get(at).copied(),
                None if self.complete => None,
                // What holds whatever the coordinates are.
                None => Some(Ball::from_number(&drawn(self.values.len() + at, self.draws), ())),
            };
        }
        let name = pool.symbol_name(symbol);
        let mut multipliers = self.sample()?.multipliers();
        multipliers.find_map(|(own, value)| (own == name).then_some(value))
    }

    /// M and K without absolute values of what has a sign at the values of the parameters, with acos(cos(x))
    /// as x where that is between 0 and pi; and what signs these are.
    pub(super) fn signed(&self, pool: &mut Algebra<'_>, pair: &Pair) -> (Pair, Signs) {
        let mut pair = pair.clone();
        let mut signs = Signs::new();
        // With its angle a term may vanish, and with it what has a sign in it.
        for only in [Resolve::Angles, Resolve::Sizes] {
            let images = self.resolved(pool, &pair.values(), only, &mut signs);
            if !images.is_empty() {
                pair = pair.changed(pool, |pool, values| pool.replaced(values, &images));
            }
        }
        (pair, signs)
    }

    /// What functions in some expressions become where they can be told from the values.
    fn resolved(&self, pool: &mut Pool, roots: &[ExprId], only: Resolve, signs: &mut Signs) -> HashMap<ExprId, ExprId> {
        let mut images: HashMap<ExprId, ExprId> = HashMap::new();
        if !self.complete {
            return images;
        }
        // What may be replaced, and by what.
        let argument = |id: ExprId| match (only, pool.as_function(id)?) {
            (Resolve::Sizes, (Function::Abs, x)) => Some((id, x)),
            (Resolve::Angles, (Function::Acos, x)) => Some((id, angle(pool, x, Function::Cos)?)),
            (Resolve::Sizes | Resolve::Angles, _) => None,
        };
        let arguments: Vec<(ExprId, ExprId)> = pool.reachable(roots).into_iter().filter_map(argument).collect();
        let inner: Vec<ExprId> = arguments.iter().map(|(_, x)| *x).collect();
        let values = self.evaluate(pool, &inner).unwrap_or_default();
        // Without a number in front: alpha > 0, not 2*alpha > 0.
        let sign = |pool: &mut Pool, x: ExprId, negative: bool| {
            let (size, core) = pool.split_content(x);
            (core, negative != size.is_negative())
        };
        for ((id, x), value) in arguments.into_iter().zip(values) {
            match only {
                Resolve::Angles if value.is_positive() && Ball::PI.sub(&value).is_positive() => {
                    images.insert(id, x);
                    let rest = pool.sub(pool.pi(), x);
                    signs.extend([sign(pool, x, false), sign(pool, rest, false)]);
                }
                Resolve::Sizes if value.is_positive() || value.is_negative() => {
                    images.insert(id, if value.is_negative() { pool.neg(x) } else { x });
                    signs.insert(sign(pool, x, value.is_negative()));
                }
                Resolve::Angles | Resolve::Sizes => {}
            }
        }
        images
    }

    /// Columns of omega^2, xᵀMx and x each, in the units of the other path; there x is about 1.
    fn measured_columns(&self, pool: &Pool, columns: &[ExprId], n: usize) -> Option<Vec<Ball>> {
        let Some(units) = self.units() else { return self.evaluate(pool, columns) };
        let mut found = Vec::with_capacity(columns.len());
        for column in self.wide(pool, columns)?.chunks(n + 2) {
            let [square, mass, x @ ..] = column else { return None };
            let x: Vec<Big> = x.iter().enumerate().map(|(at, x)| x.scale(-units.length(at))).collect();
            let largest = x.iter().map(Big::abs_upper);
            let (_, by) = largest.fold(Magnitude::ZERO, Magnitude::max).parts();
            let mass = mass.scale(2 * units.rate() - units.energy() - 2 * by);
            found.extend([square.scale(-2 * units.rate()), mass].iter().map(Big::to_ball));
            found.extend(x.iter().map(|x| x.scale(-by).to_ball()));
        }
        Some(found)
    }

    /// Whether the columns are the modes: to each its omega^2 and xᵀMx, in the order of rising omega^2.
    pub(super) fn are_modes(&self, pool: &Pool, pair: &Pair, columns: &[Column]) -> bool {
        let n = pair.len();
        let Some(mut modes) = self.references(pool, pair) else { return false };
        let mut all = Vec::new();
        for column in columns {
            all.extend([column.omega_squared, column.mass]);
            all.extend(&column.vector);
        }
        let Some(values) = self.measured_columns(pool, &all, n) else { return false };
        let largest = modes.iter().map(|mode| mode.omega_squared.abs_upper()).fold(0.0, f64::max);
        modes.order_by(|a, b| a.omega_squared.mid_f64().total_cmp(&b.omega_squared.mid_f64()));
        let columns = || values.chunks_exact(n + 2);
        let meets = |(column, mode): (&[Ball], &Reference)| is_zero(&column[0].sub(&mode.omega_squared), largest);
        columns().len() == n
            && modes.len() == n
            && columns().zip(&modes).all(meets)
            && self.are_solutions(pool, pair, columns().map(|own| (own[0], own[1], &own[2..])))
    }

    /// Whether columns, each with its omega^2 and xᵀMx, solve K x = omega^2 M x with the numbers of the other path, one by one, and are
    /// orthogonal.
    fn are_solutions<'c>(
        &self,
        pool: &Pool,
        pair: &Pair,
        mut columns: impl Iterator<Item = (Ball, Ball, &'c [Ball])>,
    ) -> bool {
        let Some((mass, stiffness)) = self.matrices(pool, pair) else { return false };
        let n = pair.len();
        let product = |matrix: &[Ball], rows: &[BTreeMap<usize, ExprId>], x: &[Ball]| -> Vec<Ball> {
            let row =
                |(i, row): (usize, &BTreeMap<usize, ExprId>)| sum(row.keys().map(|j| matrix[i + n * j].mul(&x[*j])));
            rows.iter().enumerate().map(row).collect()
        };
        let largest = size(&stiffness);
        let mut before: Vec<(&[Ball], Vec<Ball>)> = Vec::new();
        columns.all(|(square, norm, x)| {
            let image = product(&mass, &pair.mass, x);
            let forces = product(&stiffness, &pair.stiffness, x);
            let inertia: Vec<Ball> = image.iter().map(|m| m.mul(&square)).collect();
            let scale = largest * size(x) + size(&inertia);
            let solves = forces.iter().zip(&inertia).all(|(f, m)| is_zero(&f.sub(m), scale));
            let unit = norm.is_positive() && is_zero(&dot(x, &image).sub(&norm), norm.abs_upper());
            let orthogonal = before
                .iter()
                .all(|(other, theirs)| is_zero(&dot(x, theirs), size(x) * size(theirs) + size(other) * size(&image)));
            before.push((x, image));
            solves && unit && orthogonal
        })
    }

    /// Columns whose components are given by places and numbers: `[omega_squared, component]` with letters for both, and the
    /// values of these for each coordinate (none for one that rests) and each mode.
    pub(super) fn waves(&self, pool: &Pool, forms: [ExprId; 2], letters: [Letters<'_>; 2]) -> Option<Vec<Vec<Ball>>> {
        let Some(units) = self.units() else {
            let value = |symbol| self.value(pool, symbol);
            return waves(pool, forms, letters, (), value);
        };
        let value = |symbol| self.wide_value(pool, symbol);
        let columns = waves(pool, forms, letters, BITS, value)?;
        let power = |place: usize| place.checked_sub(1).map_or(2 * units.rate(), |at| units.of_shapes(at));
        let measured =
            |column: &Vec<Big>| column.iter().enumerate().map(|(place, x)| x.scale(-power(place)).to_ball()).collect();
        Some(columns.iter().map(measured).collect())
    }

    /// Whether such columns, omega^2 in front, are modes with xᵀMx = 1, orthogonal to each other.
    pub(super) fn are_waves(&self, pool: &Pool, pair: &Pair, columns: &[Vec<Ball>]) -> bool {
        self.are_solutions(pool, pair, columns.iter().map(|own| (own[0], Ball::ONE, &own[1..])))
    }

    /// M and K in numbers, column by column: from the other path where all parameters have values. Under constraints that
    /// may have other coordinates left.
    fn matrices(&self, pool: &Pool, pair: &Pair) -> Option<(Vec<Ball>, Vec<Ball>)> {
        match self.linearized() {
            Some(linearized) if !linearized.is_reduced() => Some((linearized.mass(), linearized.stiffness())),
            Some(_) | None => self.evaluated(pool, pair),
        }
    }

    /// Takes what does not hold out of a case, and puts the rest in ascending order.
    pub(super) fn check(&self, pool: &Pool, pair: &Pair, case: &mut Case) {
        if case.frequencies.is_empty() {
            case.complete = false;
            return;
        }
        let expressions: Vec<ExprId> = case.frequencies.iter().map(|f| f.omega_squared).collect();
        let (Some(values), Some(modes)) = (self.squares(pool, &expressions), self.references(pool, pair)) else {
            case.frequencies.clear();
            case.series.clear();
            case.solved.clear();
            case.complete = false;
            return;
        };
        let mut forms: Vec<(Ball, Frequency)> = values.into_iter().zip(case.frequencies.drain(..)).collect();
        forms.order_by(|(a, _), (b, _)| a.mid_f64().total_cmp(&b.mid_f64()));
        // Forms that only look different are one, which stands for itself.
        let mut merged: Vec<ExprId> = Vec::new();
        forms.dedup_by(|(later, form), (value, kept)| {
            let both = [form.omega_squared, kept.omega_squared];
            let same = later.sub(value).contains_zero() && (equal(pool, both) || self.are_equal_nearby(pool, both));
            if same {
                // Forms of one block were found together.
                kept.omega_squared = both[0].min(both[1]);
                merged.push(both[0].max(both[1]));
                kept.join(form);
            }
            same
        });
        let scale = modes.iter().map(|mode| mode.omega_squared.abs_upper()).fold(0.0, f64::max);
        let has_group = self.point_group().is_some();
        if has_group {
            for block in &mut case.blocks {
                let values = self.solved(pool, &Pair::new(&block.mass, &block.stiffness)).unwrap_or_default();
                let moving = values.iter().filter(|own| !own.omega_squared.contains_zero());
                let classes: Option<BTreeSet<&str>> = moving.map(|own| class_of(&modes, &own.omega_squared)).collect();
                if let Some(classes) = classes.filter(|classes| !classes.is_empty()) {
                    block.class = Vec::from_iter(classes).join(", ");
                }
            }
        }
        let mut used = vec![false; modes.len()];
        let before = forms.len();
        let mut failed: Vec<ExprId> = Vec::new();
        forms.retain_mut(|(value, form)| {
            let meets = |at: &usize| {
                let own = &modes[*at].omega_squared;
                !used[*at] && own.radius <= WIDEST * scale && own.sub(value).contains_zero()
            };
            let fits: Vec<usize> = (0..modes.len()).filter(meets).take(form.multiplicity).collect();
            let narrow = value.is_finite() && value.radius <= WIDEST * scale;
            if !narrow || fits.len() < form.multiplicity {
                failed.push(form.omega_squared);
                return false;
            }
            fits.iter().for_each(|at| used[*at] = true);
            // Classes of a point group have names of their own; elsewhere, where the symmetry itself gives no name, the modes may have one.
            let class = class_of(&modes, value).map(str::to_owned);
            if has_group {
                form.symmetry = class;
            } else if form.symmetry.is_none() {
                form.symmetry_at_values = class;
            }
            true
        });
        if forms.len() < before {
            case.complete = false;
            case.series.clear();
        }
        let has = |solved: &Solved, of: &[ExprId]| solved.frequencies.iter().any(|e| of.contains(e));
        // Without the names for a page nobody wants to see the rest of them.
        let gone = case.solved.iter().filter(|solved| has(solved, &failed));
        let gone: Vec<ExprId> = gone.flat_map(|solved| solved.frequencies.clone()).collect();
        forms.retain(|(_, form)| !gone.contains(&form.omega_squared));
        case.solved.retain(|solved| !has(solved, &failed) && !has(solved, &merged));
        case.frequencies = forms.into_iter().map(|(_, form)| form).collect();
    }

    pub(super) fn evaluate(&self, pool: &Pool, expressions: &[ExprId]) -> Option<Vec<Ball>> {
        let symbols = pool.symbols_of(expressions);
        let inputs: Option<Vec<Ball>> = symbols.iter().map(|symbol| self.value(pool, *symbol)).collect();
        let mut found = Tape::compile(pool, expressions, &symbols).ok()?.evaluate(&inputs?, &mut Vec::new());
        if !found.iter().all(Ball::is_finite) {
            let wide = self.wide(pool, expressions)?;
            let open = found.iter_mut().zip(&wide).filter(|(own, _)| !own.is_finite());
            open.for_each(|(own, wide)| *own = wide.to_far_ball());
        }
        Some(found)
    }

    /// The same in numbers of any range.
    fn wide(&self, pool: &Pool, expressions: &[ExprId]) -> Option<Vec<Big>> {
        let symbols = pool.symbols_of(expressions);
        let inputs: Option<Vec<Big>> = symbols.iter().map(|symbol| self.wide_value(pool, *symbol)).collect();
        let tape = Tape::compile(pool, expressions, &symbols).ok()?;
        Some(tape.prepare::<Big>(BITS).evaluate(&inputs?, &mut Vec::new()))
    }

    fn wide_value(&self, pool: &Pool, symbol: Symbol) -> Option<Big> {
        let mut parameters = self.model.parameters.iter();
        let own = parameters.find(|parameter| parameter.symbol == symbol);
        match own.and_then(|parameter| parameter.value) {
            Some(value) => evaluate_closed(&self.model.pool, value, BITS),
            None => Some(Big::from_ball(&self.value(pool, symbol)?, BITS)),
        }
    }

    /// Squares of frequencies in the units of the other path, where it has some.
    fn squares(&self, pool: &Pool, expressions: &[ExprId]) -> Option<Vec<Ball>> {
        let Some(units) = self.units() else { return self.evaluate(pool, expressions) };
        let wide = self.wide(pool, expressions)?;
        Some(wide.iter().map(|own| own.scale(-2 * units.rate()).to_ball()).collect())
    }

    /// The point group of the model at the values of its parameters, where it has one.
    pub(super) fn point_group(&self) -> Option<&str> {
        self.modes()?.point_group.as_deref()
    }

    /// The modes to compare with: of the other path, or of M and K at the values at hand.
    fn references(&self, pool: &Pool, pair: &Pair) -> Option<Vec<Reference>> {
        let Some((linearized, modes)) = self.linearized().zip(self.modes()) else { return self.solved(pool, pair) };
        let reference = |mode: &NormalMode| Reference {
            omega_squared: mode.omega_squared.unwrap_or(Ball::NOT_FINITE),
            symmetry: mode.symmetry.clone(),
        };
        Some(in_units(linearized, modes).modes.iter().map(reference).collect())
    }

    /// M and K at the values at hand, column by column.
    fn evaluated(&self, pool: &Pool, pair: &Pair) -> Option<(Vec<Ball>, Vec<Ball>)> {
        let n = pair.len();
        let entries = pair.values();
        let values = self.evaluate(pool, &entries)?;
        let value: HashMap<ExprId, Ball> = entries.into_iter().zip(values).collect();
        let dense = |rows: &[BTreeMap<usize, ExprId>]| {
            let mut matrix = vec![Ball::ZERO; n * n];
            for (i, row) in rows.iter().enumerate() {
                for (j, value) in row.iter().filter_map(|(j, entry)| Some((j, value.get(entry)?))) {
                    matrix[i + n * j] = *value;
                }
            }
            matrix
        };
        Some((dense(&pair.mass), dense(&pair.stiffness)))
    }

    /// The same at values near those of the parameters which have no relation to each other. Where one is 0 all are nearer to 1, so that
    /// it counts beside them.
    fn near(&self) -> Self {
        let mut near = Self::drawn(self.model, self.draws);
        near.complete = false;
        if self.has_zeros() {
            near.equalize();
        }
        for (i, parameter) in self.model.parameters.iter().enumerate() {
            if let Some(value) = near.values.get_mut(&parameter.symbol) {
                let change = drawn(i, 0).mul(&Number::ratio(1, 1000).unwrap_or_default());
                let change = Ball::from_number(&change, ());
                *value = if value.is_zero() { change } else { value.add(&value.mul(&change)) };
            }
        }
        near
    }

    fn has_zeros(&self) -> bool {
        self.values.values().any(Ball::is_zero)
    }

    /// All values but 0 nearer to 1, in the same order.
    fn equalize(&mut self) {
        for value in self.values.values_mut().filter(|value| !value.is_zero()) {
            let size = value.mid_f64().abs().powf(1.0 / 16.0);
            *value = Ball::exact(size.copysign(value.mid_f64()));
        }
    }

    /// Whether two forms with different roots have the same value there too, as far as a ball tells.
    fn are_equal_nearby(&self, pool: &Pool, both: [ExprId; 2]) -> bool {
        let mut near = self.near();
        let meets = |near: &Self| {
            let values = near.evaluate(pool, &both);
            values.map(|values| is_zero(&values[0].sub(&values[1]), values[0].abs_upper() * WIDEST))
        };
        let is_extreme = |value: &Ball| !(LEAST_ALIKE..1.0 / LEAST_ALIKE).contains(&value.abs_upper());
        if meets(&near) != Some(true) || !near.values.values().any(is_extreme) {
            return meets(&near) == Some(true);
        }
        // A value that is tiny beside the others makes no difference.
        near.equalize();
        meets(&near) != Some(false)
    }

    /// How often squares of frequencies occur in a block beyond those of it that are known: near the values of the parameters, where no
    /// equilibrium that was searched for depends on them.
    pub(super) fn missed(&self, pool: &Pool, block: &Pair, own: &[ExprId], all: &[ExprId]) -> Option<Vec<usize>> {
        if all.is_empty() {
            return None;
        }
        let squares = [own, all].concat();
        let at = |of: &Self| Some((of.evaluate(pool, &squares)?, of.solved(pool, block)?));
        // At zeros themselves forms are equal that are not.
        let (values, modes) = at(&self.near()).or_else(|| if self.has_zeros() { None } else { at(self) })?;
        let scale = modes.iter().map(|mode| mode.omega_squared.abs_upper()).fold(0.0, f64::max);
        let meets = |a: &Ball, b: &Ball| is_zero(&a.sub(b), scale);
        let (own, all) = values.split_at(own.len());
        let missed = all.iter().enumerate().map(|(at, z)| {
            let known = own.iter().filter(|own| meets(own, z)).count();
            let count = modes.iter().filter(|mode| meets(&mode.omega_squared, z)).count();
            // The same in another form.
            if all[..at].iter().any(|other| meets(other, z)) { 0 } else { count.saturating_sub(known) }
        });
        Some(missed.collect())
    }

    /// The frequencies of M and K at the values at hand.
    fn solved(&self, pool: &Pool, pair: &Pair) -> Option<Vec<Reference>> {
        let (mass, stiffness) = self.evaluated(pool, pair)?;
        // Nothing oscillates: no bound of a computation is as narrow as this.
        if stiffness.iter().all(Ball::is_zero) {
            return Some(vec![Reference { omega_squared: Ball::ZERO, symmetry: None }; pair.len()]);
        }
        let problem = Problem { dimension: pair.len(), mass, stiffness, zero_vectors: Vec::new() };
        let spectrum = modes::solve(&problem, &Options::default().without_vectors()).ok()?;
        let modes =
            spectrum.modes.into_iter().map(|mode| Reference { omega_squared: mode.omega_squared, symmetry: None });
        Some(modes.collect())
    }
}

/// The class of the modes with a frequency, where they all have one.
fn class_of<'a>(modes: &'a [Reference], omega_squared: &Ball) -> Option<&'a str> {
    let mut own = modes.iter().filter(|mode| mode.omega_squared.sub(omega_squared).contains_zero());
    let class = own.next()?.symmetry.as_deref()?;
    own.all(|mode| mode.symmetry.as_deref() == Some(class)).then_some(class)
}

/// [`Checker::waves`] in numbers of one kind, with the values of parameters.
fn waves<S: Scalar>(
    pool: &Pool,
    forms: [ExprId; 2],
    [(places, at), (numbers, modes)]: [Letters<'_>; 2],
    precision: S::Precision,
    known: impl Fn(Symbol) -> Option<S>,
) -> Option<Vec<Vec<S>>> {
    let zero = S::from_number(&Number::ZERO, precision);
    let symbols = pool.symbols_of(&forms);
    // Of letters, which list they are in.
    let mut inputs = Vec::new();
    let mut letters = Vec::new();
    for (input, symbol) in symbols.iter().enumerate() {
        let place = places.iter().position(|own| own == symbol);
        let number = numbers.iter().position(|own| own == symbol);
        if place.is_some() || number.is_some() {
            letters.push((input, place, number));
            inputs.push(zero.clone());
        } else {
            inputs.push(known(*symbol)?);
        }
    }
    let tape = Tape::compile(pool, &forms, &symbols).ok()?;
    let prepared = tape.prepare::<S>(precision);
    let mut room = Vec::new();
    let mut columns = Vec::new();
    for mode in modes {
        let mut column = vec![zero.clone(); at.len() + 1];
        for (i, own) in at.iter().enumerate().filter(|(_, own)| !own.is_empty()) {
            for (input, place, number) in &letters {
                let value = match (place, number) {
                    (Some(at), _) => own.get(*at),
                    (None, at) => mode.get((*at)?),
                };
                inputs[*input] = S::from_number(&Number::from(*value?), precision);
            }
            let values = prepared.evaluate(&inputs, &mut room);
            let [square, component] = values.as_slice() else { return None };
            column[0] = square.clone();
            column[i + 1] = component.clone();
        }
        columns.push(column);
    }
    Some(columns)
}

fn sum(terms: impl Iterator<Item = Ball>) -> Ball {
    terms.fold(Ball::ZERO, |sum, term| sum.add(&term))
}

fn dot(x: &[Ball], y: &[Ball]) -> Ball {
    sum(x.iter().zip(y).map(|(x, y)| x.mul(y)))
}

/// An upper bound of the magnitudes.
fn size(of: &[Ball]) -> f64 {
    of.iter().map(Ball::abs_upper).fold(0.0, f64::max)
}

/// Whether a value of parts of that size is 0, as far as enclosures tell.
fn is_zero(value: &Ball, size: f64) -> bool {
    value.contains_zero() && value.is_finite() && value.radius <= WIDEST * size
}

fn equal(pool: &Pool, [a, b]: [ExprId; 2]) -> bool {
    // A copy is needed to write the difference down; only near coincidences come here.
    let mut pool = pool.clone();
    pool.agree(a, b)
}

/// A positive rational number without a relation to the others: (2 a + 1)/(2 b), between 1/2 and 2.
fn drawn(number: usize, draws: usize) -> Number {
    let bits = mix((number as u64).wrapping_add((draws as u64) << 32));
    let part = i64::try_from(bits >> 45).unwrap_or(0);
    // part is below 2^19, so that this is between 1/2 and 2.
    let size = Number::ratio((1 << 18) + part, 1 << 19).unwrap_or(Number::ONE);
    // In later draws of any sign.
    if draws % 2 == 1 && bits & 1 == 1 { size.neg() } else { size }
}
