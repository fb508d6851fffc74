//! Normal coordinates, where closed forms give the modes (`shapes`).
//!
//! With the modes a_r, a_rᵀ M a_s = 0 for r ≠ s, the coordinates are q = sum of a_r Q_r/sqrt(a_rᵀ M a_r), and
//! L = 1/2 sum of (Q_r'^2 - omega_r^2 Q_r^2) (Landau and Lifshitz, Mechanics, §23). That the vectors are the
//! modes is checked with the numbers of the other path before anything is given out.

use super::check::{Checker, Column};
use super::frequencies::Case;
use super::motion::{Factor, Motion, MotionSum, MotionTerm};
use super::pair::Pair;
use super::roots::up_to_sign;
use super::shapes::{Shape, combined};
use super::simplify::Algebra;
use super::waves::unused;
use crate::expr::{ExprId, Pool, Substitution, Symbol};
use crate::model::Model;
use crate::number::Number;
use crate::order::{Gather, Keyed, Order};
use crate::precision::Ball;

/// No page has room for the normal coordinates of more.
const MOST_COORDINATES: usize = 12;

/// Normal coordinates of a model.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct NormalCoordinates {
    /// One a mode, in the order of rising omega^2 at the values of the parameters.
    pub modes: Vec<NormalMode>,
    /// The displacements as sums over [`Motion::Normal`], one a coordinate, with `abbreviations`.
    pub coordinates: Vec<MotionSum>,
    /// L = 1/2 sum of (Q'^2 - omega^2 Q^2), with the symbols of the frequencies.
    pub lagrangian: MotionSum,
    /// What is not written out in `coordinates`.
    pub abbreviations: Vec<Abbreviation>,
    /// The family of the frequencies: `omega`, if the model has no such name.
    pub omega: String,
}

/// A mode in closed form.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct NormalMode {
    /// omega^2.
    pub omega_squared: ExprId,
    /// Its class of symmetry, where it has one.
    pub symmetry: Option<String>,
    /// What each coordinate is moved by where the normal coordinate is 1: xᵀMx = 1. Written out, but for `omega`.
    pub amplitudes: Vec<ExprId>,
    /// The symbol that stands for the root of `omega_squared` in the amplitudes: for modes of three and four coordinates, which
    /// nobody could read otherwise.
    pub omega: Option<ExprId>,
}

/// Names on the page for what is too long to be repeated, or the same in several modes.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Abbreviation {
    /// The names, all of the same value; or one name with a letter for the number of the mode.
    pub names: Vec<String>,
    /// What they stand for.
    pub value: ExprId,
    /// The letter for the number of the mode, and the modes by their numbers, from 0; nothing where there is no letter.
    pub modes: Option<(String, Vec<usize>)>,
}

/// The normal coordinates of a case, if the shapes are all its modes and hold against certified numbers.
pub(super) fn normal_coordinates(
    pool: &mut Algebra<'_>,
    checker: &Checker<'_>,
    pair: &Pair,
    case: &Case,
    shapes: Vec<Shape>,
) -> Option<NormalCoordinates> {
    let count = pair.len();
    if !case.complete || shapes.len() != count || !(2..=MOST_COORDINATES).contains(&count) {
        return None;
    }
    let squares: Vec<ExprId> = shapes.iter().map(|shape| shape.omega_squared).collect();
    let mut sorted: Vec<(Ball, Shape)> = checker.evaluate(pool, &squares)?.into_iter().zip(shapes).collect();
    sorted.order_by(|(a, _), (b, _)| a.mid_f64().total_cmp(&b.mid_f64()));
    let shapes: Vec<Shape> = sorted.into_iter().map(|(_, shape)| shape).collect();
    let columns = shapes.iter().map(|shape| {
        let vector = shape.along(count, pool);
        let mut all = written_out(pool, shape, &vector).into_iter();
        let mass = all.next().unwrap_or_else(|| pool.undefined());
        Column { omega_squared: shape.omega_squared, mass, vector: all.collect() }
    });
    let columns: Vec<Column> = columns.collect();
    if !checker.are_modes(pool, pair, &columns) {
        return None;
    }
    let model = checker.model;
    let mut page = Page::new(model);
    let modes = columns.iter().zip(&shapes).enumerate();
    let modes = modes.map(|(r, (column, shape))| {
        let omega = shape.is_long().then(|| variable(pool, &page.omega, r));
        let amplitudes = match omega {
            Some(omega) => shape.in_terms_of(pool, count, omega),
            None => normalised(pool, &column.vector, column.mass),
        };
        NormalMode { omega_squared: column.omega_squared, symmetry: shape.symmetry.clone(), amplitudes, omega }
    });
    let modes = modes.collect();
    let terms = shapes.iter().enumerate().flat_map(|(r, shape)| {
        let amplitudes = page.amplitudes(pool, (count, r), shape).into_iter().enumerate();
        amplitudes.map(move |(i, amplitude)| (i, MotionTerm::new(amplitude, &[(Motion::Normal(r), 1)])))
    });
    let coordinates = terms.by_place(count).into_iter().map(|terms| MotionSum::new(pool, terms)).collect();
    Some(NormalCoordinates {
        modes,
        coordinates,
        lagrangian: page.lagrangian(pool, &shapes),
        abbreviations: page.abbreviations(pool),
        omega: page.omega,
    })
}

/// The mass of a shape, then its vector, without a symbol for omega.
fn written_out(pool: &mut Algebra<'_>, shape: &Shape, vector: &[ExprId]) -> Vec<ExprId> {
    let mut all = vec![shape.with_factors(pool, shape.mass)];
    all.extend(vector);
    let Some(omega) = shape.omega else { return all };
    // Only its square occurs.
    let root = pool.sqrt(shape.omega_squared);
    let all = pool.substitute(&all, &Substitution::from([(omega, root)]));
    // Zeros of cubics and quartics are only put into numbers.
    if shape.is_long() { all } else { all.into_iter().map(|e| pool.simplify(e)).collect() }
}

impl Shape {
    /// An expression with what its symbols for factors stand for.
    fn with_factors(&self, pool: &mut Pool, e: ExprId) -> ExprId {
        let factors = self.parts.iter().skip(1).map(|(_, factor)| *factor);
        let map: Substitution = self.factors.iter().copied().zip(factors).gather();
        pool.substitute_one(e, &map)
    }

    /// The amplitudes with xᵀMx = 1, in which this stands for the frequency.
    fn in_terms_of(&self, pool: &mut Pool, count: usize, omega: ExprId) -> Vec<ExprId> {
        let mass = self.with_factors(pool, self.mass);
        let norm = norm(pool, mass);
        let vector: Vec<ExprId> = self.along(count, pool).into_iter().map(|e| pool.mul(e, norm)).collect();
        let map = self.omega.map(|own| (own, omega)).into_iter().collect();
        pool.substitute(&vector, &map)
    }
}

/// 1/sqrt(mass), up to its sign: that of a mode is free, so that absolute values are needed below roots alone.
fn norm(pool: &mut Pool, mass: ExprId) -> ExprId {
    let root = pool.powr(mass, &Number::half().neg());
    up_to_sign(pool, root)
}

/// A vector by the root of its mass.
fn normalised(pool: &mut Algebra<'_>, vector: &[ExprId], mass: ExprId) -> Vec<ExprId> {
    let norm = norm(pool, mass);
    vector.iter().map(|component| pool.short(|pool| pool.mul(*component, norm))).collect()
}

/// What is said about normal coordinates on a page, in names that the model does not use.
struct Page {
    omega: String,
    ratios: Vec<String>,
    norm: String,
    number: String,
    /// What is abbreviated: the letter, the value, and the modes.
    parts: Vec<((String, ExprId), Vec<usize>)>,
}

/// Letters for ratios of amplitudes.
fn ratio_names(model: &Model) -> Vec<String> {
    let mut free = unused(model, &["a", "b", "c", "u", "v", "w", "alpha", "beta", "gamma"]);
    while free.len() < 3 {
        free.push(format!("ratio_{}_of_the_derivation", free.len() + 1));
    }
    free
}

impl Page {
    fn new(model: &Model) -> Self {
        Self {
            omega: model.unused_name(&["omega", "Omega", "w"]),
            ratios: ratio_names(model),
            norm: model.unused_name(&["A", "B", "C", "U"]),
            number: model.unused_name(&["r", "s", "n", "j"]),
            parts: Vec::new(),
        }
    }

    /// What each coordinate is moved by in a mode, as it is written there: what it is normalised by has a name where it
    /// would stand twice, and so has a long ratio.
    fn amplitudes(&mut self, pool: &mut Algebra<'_>, (count, r): (usize, usize), shape: &Shape) -> Vec<ExprId> {
        let moved: usize = shape.parts.iter().map(|(vector, _)| vector.len()).sum();
        if moved < 2 {
            let vector = shape.along(count, pool);
            return normalised(pool, &vector, shape.mass);
        }
        let mut map = Substitution::new();
        if let Some(omega) = shape.omega {
            map.insert(omega, pool.variable(&format!("{}[{}]", self.omega, self.number)));
        }
        let mut factors = Vec::new();
        for (at, (vector, factor)) in shape.parts.iter().enumerate() {
            let mut factor = *factor;
            let mut any = factor;
            // The first one is 1.
            if shape.omega.is_some()
                && !pool.is_constant(factor)
                && let Some(letter) = self.ratios.get(at.wrapping_sub(1)).cloned()
            {
                let value = pool.substitute_one(factor, &map);
                any = pool.variable(&format!("{letter}[{}]", self.number));
                factor = self.abbreviate(pool, letter, r, value);
            }
            if let Some(own) = at.checked_sub(1).and_then(|at| shape.factors.get(at)) {
                map.insert(*own, any);
            }
            factors.push((vector, factor));
        }
        let mass = pool.substitute_one(shape.mass, &map);
        let norm = norm(pool, mass);
        let norm = self.abbreviate(pool, self.norm.clone(), r, norm);
        let factors: Vec<_> = factors.into_iter().map(|(vector, factor)| (vector, pool.mul(factor, norm))).collect();
        combined(pool, count, factors.into_iter())
    }

    /// The symbol of a mode for a value.
    fn abbreviate(&mut self, pool: &mut Pool, letter: String, r: usize, value: ExprId) -> ExprId {
        let symbol = variable(pool, &letter, r);
        self.parts.under((letter, value)).push(r);
        symbol
    }

    fn abbreviations(&self, pool: &mut Pool) -> Vec<Abbreviation> {
        // `omega[r]`, and ratios that are given in it.
        let any = format!("[{}]", self.number);
        let all = self.parts.iter().map(|((letter, value), modes)| {
            let family = |own: Symbol| Some((own, pool.symbol_name(own).strip_suffix(&any)?.to_owned()));
            let numbered: Vec<(Symbol, String)> = pool.symbols(*value).into_iter().filter_map(family).collect();
            // Of a single mode it is said with its number.
            if let ([_, ..], [r]) = (numbered.as_slice(), modes.as_slice()) {
                let own = numbered.iter().map(|(own, family)| (*own, variable(pool, family, *r)));
                let map: Substitution = own.gather();
                let names = vec![format!("{letter}[{}]", r + 1)];
                return Abbreviation { names, value: pool.substitute_one(*value, &map), modes: None };
            }
            let (names, modes) = if !numbered.is_empty() {
                let name = format!("{letter}[{}]", self.number);
                (vec![name], Some((self.number.clone(), modes.clone())))
            } else {
                let names = modes.iter().map(|r| format!("{letter}[{}]", r + 1));
                (names.collect(), None)
            };
            Abbreviation { names, value: *value, modes }
        });
        all.collect()
    }

    /// 1/2 sum of (Q'^2 - omega^2 Q^2)
    fn lagrangian(&self, pool: &mut Pool, shapes: &[Shape]) -> MotionSum {
        let mut terms = Vec::new();
        for (r, shape) in shapes.iter().enumerate() {
            terms.push(MotionTerm::new(pool.one(), &[(Motion::NormalVelocity(r), 2)]));
            if !shape.omega_squared.is_zero() {
                let omega = variable(pool, &self.omega, r);
                let square = pool.square(omega);
                terms.push(MotionTerm::new(pool.neg(square), &[(Motion::Normal(r), 2)]));
            }
        }
        MotionSum { factor: Factor::Half, ..MotionSum::new(pool, terms) }
    }
}

/// A member of a family of symbols.
fn variable(pool: &mut Pool, family: &str, r: usize) -> ExprId {
    pool.variable(&format!("{family}[{}]", r + 1))
}
