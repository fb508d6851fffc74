//! Normal coordinates, where closed forms give the modes: one or two coordinates that hang together, or as many
//! in a class of symmetry.
//!
//! With the modes a_r, a_rᵀ M a_s = 0 for r ≠ s, the coordinates are q = sum of a_r Q_r/sqrt(a_rᵀ M a_r), and
//! L = 1/2 sum of (Q_r'^2 - omega_r^2 Q_r^2) (Landau and Lifshitz, Mechanics, §23). That the vectors are the
//! modes is checked with the numbers of the other path before anything is given out.

use std::collections::BTreeMap;

use super::check::{Checker, Column};
use super::frequencies::Case;
use super::motion::{Factor, Motion, MotionSum, MotionTerm};
use super::pair::{Pair, Sparse, is_zero};
use super::simplify::{Opening, Simplifier, expand, with_common_factor};
use crate::expr::{ExprId, Node, Pool, Substitution, Symbol, ZeroVerdict};
use crate::model::Model;
use crate::number::Number;
use crate::precision::Function;

/// No page has room for the normal coordinates of more.
const MOST_COORDINATES: usize = 12;

/// A ratio of amplitudes of more symbols gets a name of its own.
const MOST_IN_RATIO: u64 = 16;
/// Likewise what it is normalised by.
const MOST_IN_MASS: u64 = 32;

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
    /// What L is called there: `L`, if the model has no such name.
    pub lagrangian_name: String,
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
    /// What each coordinate is moved by where the normal coordinate is 1: xᵀMx = 1. Written out.
    pub amplitudes: Vec<ExprId>,
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

/// A mode as it is found.
pub(super) struct Shape {
    omega_squared: ExprId,
    symmetry: Option<String>,
    /// Vectors and what each is multiplied by; 1 for the first.
    parts: Vec<(Sparse, ExprId)>,
    /// aᵀMa
    mass: ExprId,
    /// Stands for the frequency in the factors and in the mass, where it is not written out there.
    omega: Option<Symbol>,
}

impl Shape {
    fn along(&self, count: usize, pool: &mut Pool) -> Vec<ExprId> {
        let mut vector = vec![Vec::new(); count];
        for (basis, factor) in &self.parts {
            for (i, component) in basis {
                if let Some(place) = vector.get_mut(*i) {
                    place.push((*factor, Number::from(*component)));
                }
            }
        }
        vector.iter().map(|terms| pool.linear(terms)).collect()
    }
}

/// The modes of a part of one or two coordinates with these omega^2; `basis` says which vectors of the model its
/// coordinates are. None where they can't be told apart.
pub(super) fn shapes(
    pool: &mut Pool,
    short: &mut Simplifier,
    part: &Pair,
    squares: &[ExprId],
    basis: &[Sparse],
    symmetry: Option<String>,
) -> Vec<Shape> {
    let one = pool.one();
    match (squares, basis) {
        ([square], [vector]) => vec![Shape {
            omega_squared: *square,
            symmetry,
            parts: vec![(vector.clone(), one)],
            mass: part.at(pool, 0, 0).0,
            omega: None,
        }],
        ([first, second], [u, v]) => {
            let difference = pool.sub(*first, *second);
            if pool.is_zero(difference) == ZeroVerdict::Zero {
                return Vec::new();
            }
            let block = Block::new(pool, part);
            let mut found = Vec::new();
            for square in [*first, *second] {
                let (ratio, mass, omega) = block.mode(pool, short, square);
                let parts = match ratio {
                    None => vec![(v.clone(), one)],
                    Some(ratio) if is_zero(pool, ratio) => vec![(u.clone(), one)],
                    Some(ratio) => vec![(u.clone(), one), (v.clone(), ratio)],
                };
                found.push(Shape {
                    omega_squared: square,
                    symmetry: symmetry.clone(),
                    parts,
                    mass,
                    omega,
                });
            }
            found
        }
        _ => Vec::new(),
    }
}

/// M and K of two coordinates.
struct Block {
    m: [ExprId; 3],
    k: [ExprId; 3],
}

impl Block {
    fn new(pool: &Pool, part: &Pair) -> Self {
        let entries = [(0, 0), (0, 1), (1, 1)].map(|(i, j)| part.at(pool, i, j));
        Self {
            m: entries.map(|(m, _)| m),
            k: entries.map(|(_, k)| k),
        }
    }

    /// The second amplitude by the first (`None` where the first is 0), and aᵀMa; with a symbol for omega where that is
    /// shorter by far.
    fn mode(
        &self,
        pool: &mut Pool,
        short: &mut Simplifier,
        square: ExprId,
    ) -> (Option<ExprId>, ExprId, Option<Symbol>) {
        let Some((at, ratio)) = self.ratio(pool, short, square, None) else {
            return (None, self.m[2], None);
        };
        let mass = self.mass(pool, short, ratio);
        if short.weight(pool, ratio) <= MOST_IN_RATIO && short.weight(pool, mass) <= MOST_IN_MASS {
            return (Some(ratio), mass, None);
        }
        let symbol = pool.fresh_symbol("omega");
        let omega = pool.symbol_expr(symbol);
        let omega_squared = pool.square(omega);
        match self.ratio(pool, short, omega_squared, Some(at)) {
            Some((_, ratio)) => {
                let mass = self.mass(pool, short, ratio);
                (Some(ratio), mass, Some(symbol))
            }
            None => (Some(ratio), mass, None),
        }
    }

    /// M_11 + 2 M_12 a + M_22 a^2
    fn mass(&self, pool: &mut Pool, short: &mut Simplifier, ratio: ExprId) -> ExprId {
        let square = pool.square(ratio);
        let (mixed, last) = (pool.mul(self.m[1], ratio), pool.mul(self.m[2], square));
        let sum = pool.linear(&[
            (self.m[0], Number::ONE),
            (mixed, Number::from(2)),
            (last, Number::ONE),
        ]);
        let sum = short.simplify(pool, sum);
        on_one_bar(pool, short, sum)
    }

    /// The shortest of the forms that the two rows of (K - z M) a = 0 give, or of one form of them; and which ones have a
    /// value. Both rows together give a third, in which z stands in no denominator: with z1 + z2 = s and z1 z2 = p
    ///
    /// ```text
    /// a = ((M_11 K_12 - K_11 M_12) z + K_11 M_12 s - K_11 K_12 - M_11 M_12 p) / (M_12^2 p - M_12 K_12 s + K_12^2)
    /// ```
    ///
    /// which is the first row, a = (K_11 - z1 M_11)/(z1 M_12 - K_12), extended by z2 M_12 - K_12.
    fn ratio(
        &self,
        pool: &mut Pool,
        short: &mut Simplifier,
        z: ExprId,
        forms: Option<[bool; 3]>,
    ) -> Option<([bool; 3], ExprId)> {
        let one = Number::ONE;
        let minus = Number::MINUS_ONE;
        let entry = |pool: &mut Pool, i: usize| {
            let inertia = pool.mul(z, self.m[i]);
            pool.linear(&[(self.k[i], one.clone()), (inertia, minus.clone())])
        };
        let [first, mixed, last] = [0, 1, 2].map(|i| entry(pool, i));
        let opposite = pool.neg(mixed);
        let mut fractions = vec![(first, opposite), (opposite, last)];
        fractions.push(self.without_root(pool, z));
        let mut best: Option<(u64, ExprId)> = None;
        let mut usable = [false; 3];
        for (at, (above, below)) in fractions.into_iter().enumerate() {
            let below = short.simplify(pool, below);
            let wanted = match forms {
                Some(forms) => forms[at],
                None => pool.is_zero(below) != ZeroVerdict::Zero,
            };
            if !wanted {
                continue;
            }
            usable[at] = true;
            let above = short.simplify(pool, above);
            let quotient = pool.div(above, below);
            let quotient = short.simplify(pool, quotient);
            let quotient = on_one_bar(pool, short, quotient);
            let weight = short.weight(pool, quotient);
            if !pool.is_undefined(quotient) && best.is_none_or(|(least, _)| weight < least) {
                best = Some((weight, quotient));
            }
        }
        best.map(|(_, ratio)| (usable, ratio))
    }

    /// Numerator and denominator of the third form.
    fn without_root(&self, pool: &mut Pool, z: ExprId) -> (ExprId, ExprId) {
        let ([m1, m12, m2], [k1, k12, k2]) = (self.m, self.k);
        let one = Number::ONE;
        let minus = Number::MINUS_ONE;
        let determinant = |pool: &mut Pool, a: ExprId, b: ExprId, c: ExprId| {
            let (diagonal, square) = (pool.mul(a, c), pool.square(b));
            pool.sub(diagonal, square)
        };
        let of_m = determinant(pool, m1, m12, m2);
        let of_k = determinant(pool, k1, k12, k2);
        let p = pool.div(of_k, of_m);
        let crossed = [pool.mul(m1, k2), pool.mul(m2, k1), pool.mul(m12, k12)];
        let traced = pool.linear(&[
            (crossed[0], one.clone()),
            (crossed[1], one.clone()),
            (crossed[2], Number::from(-2)),
        ]);
        let s = pool.div(traced, of_m);
        let (left, right) = (pool.mul(m1, k12), pool.mul(k1, m12));
        let slope = pool.sub(left, right);
        let terms = [
            (pool.mul(slope, z), one.clone()),
            (pool.product(&[k1, m12, s]), one.clone()),
            (pool.mul(k1, k12), minus.clone()),
            (pool.product(&[m1, m12, p]), minus.clone()),
        ];
        let above = pool.linear(&terms);
        let (m, k) = (pool.square(m12), pool.square(k12));
        let terms = [
            (pool.mul(m, p), one.clone()),
            (pool.product(&[m12, k12, s]), minus),
            (k, one),
        ];
        (above, pool.linear(&terms))
    }
}

/// A sum of fractions as one fraction, where that is not much longer.
fn on_one_bar(pool: &mut Pool, short: &mut Simplifier, e: ExprId) -> ExprId {
    let Some(monomials) = expand(pool, e, Opening::Powers) else {
        return e;
    };
    // By base: the largest power below a bar.
    let mut below: BTreeMap<ExprId, Number> = BTreeMap::new();
    for (base, exponent) in monomials.keys().flatten() {
        if exponent.is_negative() {
            let power = exponent.neg();
            let place = below.entry(*base).or_insert(Number::ZERO);
            if *place < power {
                *place = power;
            }
        }
    }
    if below.is_empty() {
        return e;
    }
    let terms: Vec<(ExprId, Number)> = monomials
        .into_iter()
        .map(|(mut monomial, coefficient)| {
            monomial.extend(below.iter().map(|(base, power)| (*base, power.clone())));
            (pool.product_of_powers(&monomial), coefficient)
        })
        .collect();
    let above = pool.linear(&terms);
    let above = short.simplify(pool, above);
    // What all terms have in common stands in front, even where that is no shorter.
    let above = match expand(pool, above, Opening::Outermost) {
        Some(terms) => with_common_factor(pool, terms.into_iter().collect()),
        None => above,
    };
    let mut factors = vec![(above, Number::ONE)];
    factors.extend(below.into_iter().map(|(base, power)| (base, power.neg())));
    let fraction = pool.product_of_powers(&factors);
    let (own, before) = (short.weight(pool, fraction), short.weight(pool, e));
    if own <= before + before / 2 {
        fraction
    } else {
        e
    }
}

/// The normal coordinates of a case, if the shapes are all its modes and hold against certified numbers.
pub(super) fn normal_coordinates(
    model: &Model,
    pool: &mut Pool,
    short: &mut Simplifier,
    checker: &Checker<'_>,
    pair: &Pair,
    case: &Case,
    mut shapes: Vec<Shape>,
) -> Option<NormalCoordinates> {
    let count = pair.len();
    if !case.complete || shapes.len() != count || !(2..=MOST_COORDINATES).contains(&count) {
        return None;
    }
    let squares: Vec<ExprId> = shapes.iter().map(|shape| shape.omega_squared).collect();
    let places = checker.ascending(pool, &squares)?;
    let mut sorted: Vec<(usize, Shape)> = places.into_iter().zip(shapes.drain(..)).collect();
    sorted.sort_by_key(|(place, _)| *place);
    let shapes: Vec<Shape> = sorted.into_iter().map(|(_, shape)| shape).collect();
    let columns: Vec<Column> = shapes
        .iter()
        .map(|shape| {
            let vector = shape.along(count, pool);
            let mut all = written_out(pool, short, shape, &vector).into_iter();
            let mass = all.next().unwrap_or_else(|| pool.undefined());
            Column {
                omega_squared: shape.omega_squared,
                mass,
                vector: all.collect(),
            }
        })
        .collect();
    if !checker.are_modes(pool, pair, &columns) {
        return None;
    }
    let modes = columns
        .iter()
        .zip(&shapes)
        .map(|(column, shape)| NormalMode {
            omega_squared: column.omega_squared,
            symmetry: shape.symmetry.clone(),
            amplitudes: normalised(pool, short, &column.vector, column.mass),
        })
        .collect();
    let mut page = Page::new(model);
    let mut terms = vec![Vec::new(); count];
    for (r, shape) in shapes.iter().enumerate() {
        let amplitudes = page.amplitudes(pool, short, (count, r), shape);
        for (row, amplitude) in terms.iter_mut().zip(amplitudes) {
            row.push(MotionTerm::new(amplitude, &[(Motion::Normal(r), 1)]));
        }
    }
    let coordinates = terms.into_iter();
    let coordinates = coordinates
        .map(|terms| MotionSum::new(pool, terms))
        .collect();
    Some(NormalCoordinates {
        modes,
        coordinates,
        lagrangian: page.lagrangian(pool, &shapes),
        lagrangian_name: model.unused_name(&["L", "lagrangian"]),
        abbreviations: page.abbreviations(pool),
        omega: page.omega,
    })
}

/// The mass of a shape, then its vector, without a symbol for omega.
fn written_out(
    pool: &mut Pool,
    short: &mut Simplifier,
    shape: &Shape,
    vector: &[ExprId],
) -> Vec<ExprId> {
    let mut all = vec![shape.mass];
    all.extend(vector);
    let Some(omega) = shape.omega else {
        return all;
    };
    // Only its square occurs.
    let root = pool.sqrt(shape.omega_squared);
    let all = pool.substitute(&all, &Substitution::from([(omega, root)]));
    all.into_iter().map(|e| short.simplify(pool, e)).collect()
}

/// 1/sqrt(mass), up to its sign: that of a mode is free, so that no absolute values are needed.
fn norm(pool: &mut Pool, mass: ExprId) -> ExprId {
    let root = pool.powr(mass, &Number::half().neg());
    let (size, core) = pool.split_content(root);
    let factors: Vec<(ExprId, Number)> = pool
        .factors(core)
        .into_iter()
        .map(|(base, exponent)| match *pool.node(base) {
            Node::Function(Function::Abs, x) => (x, exponent),
            _ => (base, exponent),
        })
        .collect();
    let product = pool.product_of_powers(&factors);
    pool.scale(product, &size)
}

/// A vector by the root of its mass.
fn normalised(
    pool: &mut Pool,
    short: &mut Simplifier,
    vector: &[ExprId],
    mass: ExprId,
) -> Vec<ExprId> {
    let norm = norm(pool, mass);
    let vector = vector.iter();
    vector
        .map(|component| {
            let product = pool.mul(*component, norm);
            short.simplify(pool, product)
        })
        .collect()
}

/// What is said about normal coordinates on a page, in names that the model does not use.
struct Page {
    omega: String,
    ratio: String,
    norm: String,
    number: String,
    /// What is abbreviated: the letter, the value, and the modes.
    parts: Vec<(String, ExprId, Vec<usize>)>,
}

/// The family of normal coordinates.
pub(super) fn family_name(model: &Model) -> String {
    model.unused_name(&["Q", "eta", "xi", "zeta"])
}

impl Page {
    fn new(model: &Model) -> Self {
        Self {
            omega: model.unused_name(&["omega", "Omega", "w"]),
            ratio: model.unused_name(&["a", "b", "c", "u"]),
            norm: model.unused_name(&["A", "B", "C", "U"]),
            number: model.unused_name(&["r", "s", "n", "j"]),
            parts: Vec::new(),
        }
    }

    /// What each coordinate is moved by in a mode, as it is written there: what it is normalised by has a name where it
    /// would stand twice, and so has a long ratio.
    fn amplitudes(
        &mut self,
        pool: &mut Pool,
        short: &mut Simplifier,
        (count, r): (usize, usize),
        shape: &Shape,
    ) -> Vec<ExprId> {
        let moved: usize = shape.parts.iter().map(|(vector, _)| vector.len()).sum();
        if moved < 2 {
            let vector = shape.along(count, pool);
            return normalised(pool, short, &vector, shape.mass);
        }
        let mut map = Substitution::new();
        if let Some(omega) = shape.omega {
            let number = self.number.clone();
            let any = pool.variable(&format!("{}[{number}]", self.omega));
            map.insert(omega, any);
        }
        let mut factors = Vec::new();
        for (vector, factor) in &shape.parts {
            let mut factor = *factor;
            if shape.omega.is_some() && !pool.is_constant(factor) {
                let value = pool.substitute_one(factor, &map);
                factor = self.abbreviate(pool, self.ratio.clone(), r, value);
            }
            factors.push((vector, factor));
        }
        let mass = pool.substitute_one(shape.mass, &map);
        let norm = norm(pool, mass);
        let norm = self.abbreviate(pool, self.norm.clone(), r, norm);
        let mut amplitudes = vec![Vec::new(); count];
        for (vector, factor) in factors {
            for (i, component) in vector {
                if let Some(place) = amplitudes.get_mut(*i) {
                    place.push((pool.mul(factor, norm), Number::from(*component)));
                }
            }
        }
        amplitudes.iter().map(|sum| pool.linear(sum)).collect()
    }

    /// The symbol of a mode for a value.
    fn abbreviate(&mut self, pool: &mut Pool, letter: String, r: usize, value: ExprId) -> ExprId {
        let symbol = variable(pool, &letter, r);
        let mut parts = self.parts.iter_mut();
        match parts.find(|(own, other, _)| *own == letter && *other == value) {
            Some((_, _, modes)) => modes.push(r),
            None => self.parts.push((letter, value, vec![r])),
        }
        symbol
    }

    fn abbreviations(&self, pool: &mut Pool) -> Vec<Abbreviation> {
        let any = pool.variable(&format!("{}[{}]", self.omega, self.number));
        let any = pool.as_symbol(any);
        let parts = self.parts.iter();
        parts
            .map(|(letter, value, modes)| {
                let numbered = pool.symbols(*value).iter().any(|s| Some(*s) == any);
                let (names, modes) = if numbered {
                    let name = format!("{letter}[{}]", self.number);
                    (vec![name], Some((self.number.clone(), modes.clone())))
                } else {
                    let names = modes.iter().map(|r| format!("{letter}[{}]", r + 1));
                    (names.collect(), None)
                };
                Abbreviation {
                    names,
                    value: *value,
                    modes,
                }
            })
            .collect()
    }

    /// 1/2 sum of (Q'^2 - omega^2 Q^2)
    fn lagrangian(&self, pool: &mut Pool, shapes: &[Shape]) -> MotionSum {
        let mut terms = Vec::new();
        for (r, shape) in shapes.iter().enumerate() {
            let one = pool.one();
            terms.push(MotionTerm::new(one, &[(Motion::NormalVelocity(r), 2)]));
            if !is_zero(pool, shape.omega_squared) {
                let omega = variable(pool, &self.omega, r);
                let square = pool.square(omega);
                let opposite = pool.neg(square);
                terms.push(MotionTerm::new(opposite, &[(Motion::Normal(r), 2)]));
            }
        }
        let mut sum = MotionSum::new(pool, terms);
        sum.factor = Factor::Half;
        sum
    }
}

/// A member of a family of symbols.
fn variable(pool: &mut Pool, family: &str, r: usize) -> ExprId {
    pool.variable(&format!("{family}[{}]", r + 1))
}
