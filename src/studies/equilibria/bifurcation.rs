//! Where branches of equilibria end or meet, proved by extended systems.
//!
//! The system F(z, p) = 0, ∂F/∂z v = 0, ℓ·v = 1 in (z, p, v) has a regular solution where branches end in a quadratic fold, and nowhere else (G. Moore
//! and A. Spence, SIAM J. Numer. Anal. 17 (1980) 567). Where S with S² = 1 takes equilibria into equilibria, the same system with z in the
//! space that S leaves alone and Sv = -v is regular where a simple eigenvalue passes through 0 (B. Werner and A. Spence, SIAM J. Numer. Anal. 21
//! (1984) 388): a pitchfork. The same holds where forces merely stay in such a space, as in x (p - x) at x = 0: two branches cross.
//! ℓ is a vector of doubles near v. That a branch parts there with a quadratic bend, or crosses at an angle, is one more linear system
//! with the derivatives J of the same: along z(s), p(s), a pitchfork with p' = 0 has J (3z'', 3p'', z''') = -(3D²F(v, v), D³F(v, v, v), 0), and a
//! crossing J (2a, 2p', z'') = -(0, D²F(v, v), 0) with z' = v + a.

use librate_core::worded;
use std::collections::HashMap;

use nalgebra::DMatrix;

use librate_core::expr::{ExprId, Pool, Substitution, Symbol, Tape};
use librate_core::number::Number;
use librate_core::precision::{Ball, Interval, System};

use super::forces::{Equations, Forces};
use super::search::Search;

/// Symmetries are searched for among so many coordinates.
const MOST_COORDINATES: usize = 8;
/// So many of them are tried.
const MOST_SYMMETRIES: usize = 64;
/// How far a place may be from what a symmetry leaves alone, beside the box, ...
const NEAR: f64 = 0.05;
/// ... and a direction of length 1 from what it reverses.
const ALIGNED: f64 = 0.2;
/// Half sides of the regions that are tried first, beside the box.
const REGION: f64 = 1e-2;

worded! {
/// What happens where branches end or meet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
Kind {
    /// Two branches end in each other.
    Fold "fold",
    /// From a symmetric branch two part that are mirror images of each other.
    Pitchfork "pitchfork",
    /// Two branches cross.
    Transcritical "transcritical",
}
/// `fold`, `pitchfork` or `transcritical`.
as_str
}

/// What becomes of a coordinate: another one, or its opposite; one that turns into its opposite is held at so many half turns.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct Image {
    of: usize,
    opposite: bool,
    half_turns: i32,
}

impl Image {
    fn itself(of: usize) -> Self {
        Self { of, opposite: false, half_turns: 0 }
    }

    /// The value of an unknown, by its number, that is this image.
    fn value(self, own: usize, at: &[Ball]) -> Ball {
        match (self.opposite, self.of == own) {
            (true, true) => Ball::PI * Ball::exact(f64::from(self.half_turns)),
            (true, false) => -at[self.of],
            (false, _) => at[self.of],
        }
    }
}

/// A permutation with signs that is its own inverse.
type Involution = Vec<Image>;

/// A system that is regular at bifurcations of one kind.
struct Extended {
    kind: Kind,
    forces: Forces,
    /// The higher derivatives that tell how the parameter changes along the branch that parts; `None` for folds.
    bend: Option<Tape>,
    /// Where each unknown of the equations has its value from: one that comes before it, or itself.
    origins: Involution,
    /// The unknowns of the equations whose values are unknown here, and those in which there is a direction.
    values: Vec<usize>,
    directions: Vec<usize>,
}

/// A bifurcation that is proved.
pub(super) struct Proved {
    pub(super) kind: Kind,
    /// The unknowns.
    pub(super) at: Vec<Ball>,
    /// The parameter in SI.
    pub(super) value: Ball,
    /// Per unknown; at a pitchfork those of the symmetric branch are as these say.
    origins: Involution,
}

impl Proved {
    /// Whether unknowns may be those of the symmetric branch.
    pub(super) fn is_symmetric(&self, at: &[Ball]) -> bool {
        let mut pairs = self.origins.iter().zip(at).enumerate();
        pairs.all(|(own, (origin, x))| (*x - origin.value(own, at)).contains_zero())
    }
}

/// The systems of a family of equations with one parameter.
pub(super) struct Systems<'a> {
    equations: &'a Equations,
    whole: &'a [Interval],
    range: [f64; 2],
    fold: Option<Extended>,
    crossings: HashMap<Involution, Option<Extended>>,
}

impl<'a> Systems<'a> {
    pub(super) fn new(equations: &'a Equations, whole: &'a [Interval], range: [f64; 2]) -> Self {
        Self { equations, whole, range, fold: fold(equations), crossings: HashMap::new() }
    }

    /// The bifurcation at which a branch ends near a place; `slopes` are the derivatives there.
    pub(super) fn near(&mut self, place: &[f64], value: f64, slopes: &[f64]) -> Option<Proved> {
        let direction = null_direction(slopes, place.len())?;
        let spot = Spot { place, value, direction: &direction, whole: self.whole, range: self.range };
        if let Some(proved) = self.fold.as_mut().and_then(|system| system.solved(&spot)) {
            return Some(proved);
        }
        if self.equations.is_constrained || place.len() > MOST_COORDINATES {
            return None;
        }
        let all = involutions(&spot);
        for own in &all {
            self.crossings.entry(own.clone()).or_insert_with(|| crossing(self.equations, own));
        }
        for kind in [Kind::Pitchfork, Kind::Transcritical] {
            for own in &all {
                let system = self.crossings.get_mut(own).and_then(Option::as_mut).filter(|system| system.kind == kind);
                if let Some(proved) = system.and_then(|system| system.solved(&spot)) {
                    return Some(proved);
                }
            }
        }
        None
    }
}

/// A place near a bifurcation.
struct Spot<'a> {
    place: &'a [f64],
    value: f64,
    /// Of length 1, along which forces hardly change.
    direction: &'a [f64],
    whole: &'a [Interval],
    range: [f64; 2],
}

/// The direction along which forces change least.
fn null_direction(slopes: &[f64], n: usize) -> Option<Vec<f64>> {
    if !slopes.iter().all(|x| x.is_finite()) {
        return None;
    }
    let svd = DMatrix::from_row_slice(n, n, slopes).svd(false, true);
    let rows = svd.v_t?;
    let least = svd.singular_values.imin();
    Some(rows.row(least).iter().copied().collect())
}

impl Extended {
    /// Its solution near a place.
    fn solved(&mut self, spot: &Spot<'_>) -> Option<Proved> {
        let own: Vec<f64> = self.directions.iter().map(|at| spot.direction[*at]).collect();
        let square: f64 = own.iter().map(|x| x * x).sum();
        if square < 0.25 {
            return None;
        }
        let weights: Vec<Ball> = own.iter().map(|x| Ball::exact(x / square)).collect();
        let mut start: Vec<f64> = self.values.iter().map(|at| spot.place[*at]).collect();
        let mut whole: Vec<Interval> = self.values.iter().map(|at| spot.whole[*at]).collect();
        start.push(spot.value);
        let [from, to] = spot.range;
        whole.push(Interval::new(from.min(to), from.max(to)));
        start.extend(&own);
        whole.extend(own.iter().map(|_| Interval::new(-1.0, 1.0)));
        let sides: Vec<f64> = whole.iter().map(|own| REGION * own.width()).collect();
        let mut search = Search::new(&mut self.forces, weights.clone(), whole);
        let end = search.converged(&start)?;
        let root = search.prove(&end, &sides)?;
        if let Some(bend) = &self.bend {
            let inputs: Vec<Ball> = root.at.iter().chain(&weights).copied().collect();
            let slopes = self.forces.prepare().slopes(&inputs);
            let right = bend.prepare(()).evaluate(&inputs, &mut Vec::new());
            let along = System::new(root.at.len(), slopes)?.solve(&right)?;
            if along.get(self.values.len())?.contains_zero() {
                return None;
            }
        }
        let value = *root.at.get(self.values.len())?;
        let mut at = vec![Ball::ZERO; self.origins.len()];
        for (own, x) in self.values.iter().zip(&root.at) {
            at[*own] = *x;
        }
        let at: Vec<Ball> = self.origins.iter().enumerate().map(|(own, origin)| origin.value(own, &at)).collect();
        let near = |(x, (y, whole)): (&Ball, (&f64, &Interval))| (x.mid_f64() - y).abs() <= 0.25 * whole.width();
        let is_near = at.iter().zip(spot.place.iter().zip(spot.whole)).all(near);
        is_near.then(|| Proved { kind: self.kind, at, value, origins: self.origins.clone() })
    }
}

/// Σ w_k x_k - 1.
fn normalisation(pool: &mut Pool, weights: &[ExprId], vector: &[ExprId]) -> ExprId {
    let (sum, one) = (pool.dot(weights, vector), pool.one());
    pool.sub(sum, one)
}

/// The derivative of an expression along a direction.
fn along(pool: &mut Pool, of: ExprId, unknowns: &[Symbol], direction: &[ExprId]) -> ExprId {
    let slopes = pool.gradient(of, unknowns);
    pool.dot(&slopes, direction)
}

/// The second derivative along a direction.
fn twice_along(pool: &mut Pool, of: ExprId, unknowns: &[Symbol], direction: &[ExprId]) -> ExprId {
    let slope = along(pool, of, unknowns, direction);
    along(pool, slope, unknowns, direction)
}

/// `count` symbols, also as expressions.
fn fresh(pool: &mut Pool, name: &str, count: usize) -> (Vec<Symbol>, Vec<ExprId>) {
    let symbols: Vec<Symbol> = (0..count).map(|at| pool.fresh_symbol(&format!("{name} {at}"))).collect();
    let expressions = symbols.iter().map(|own| pool.symbol_expr(*own)).collect();
    (symbols, expressions)
}

/// Moore and Spence's system.
fn fold(equations: &Equations) -> Option<Extended> {
    let mut pool = equations.pool.clone();
    let n = equations.unknowns.len();
    let (directions, vector) = fresh(&mut pool, "direction", n);
    let (weights, factors) = fresh(&mut pool, "weight", n);
    let mut all = equations.all.clone();
    all.extend(equations.all.iter().map(|own| along(&mut pool, *own, &equations.unknowns, &vector)));
    all.push(normalisation(&mut pool, &factors, &vector));
    let unknowns = equations.unknowns.iter().chain(&equations.parameters).chain(&directions).copied().collect();
    let system = Equations { pool, unknowns, parameters: weights, all, is_constrained: equations.is_constrained };
    let origins = (0..n).map(Image::itself).collect();
    let (values, directions) = ((0..n).collect(), (0..n).collect());
    Some(Extended { kind: Kind::Fold, forces: system.plain()?, bend: None, origins, values, directions })
}

/// Werner and Spence's system for a symmetry; `None` where it is none.
fn crossing(equations: &Equations, own: &Involution) -> Option<Extended> {
    let mut pool = equations.pool.clone();
    let unknowns = &equations.unknowns;
    let z: Vec<ExprId> = unknowns.iter().map(|symbol| pool.symbol_expr(*symbol)).collect();
    let signed = |pool: &mut Pool, x: ExprId, opposite: bool| if opposite { pool.neg(x) } else { x };
    // The images of all, the space that is left alone, and a direction that is reversed.
    let (mut images, mut restriction) = (Substitution::default(), Substitution::default());
    let (mut values, mut directions) = (Vec::new(), Vec::new());
    for (at, image) in own.iter().enumerate() {
        let moved = signed(&mut pool, z[image.of], image.opposite);
        let pi = pool.pi();
        let turns = |pool: &mut Pool, count: i32| pool.scale(pi, &Number::from(i64::from(count)));
        let shift = turns(&mut pool, 2 * image.half_turns);
        images.insert(unknowns[at], pool.add(moved, shift));
        match (image.of == at, image.opposite) {
            (true, true) => {
                restriction.insert(unknowns[at], turns(&mut pool, image.half_turns));
                directions.push(at);
            }
            (false, _) if image.of < at => {
                restriction.insert(unknowns[at], moved);
            }
            (same, _) => {
                values.push(at);
                directions.extend((!same).then_some(at));
            }
        }
    }
    let earlier = |(at, image): (usize, &Image)| if image.of > at { Image::itself(at) } else { *image };
    let origins = own.iter().enumerate().map(earlier).collect();
    let (steps, step) = fresh(&mut pool, "direction", directions.len());
    let (weights, factors) = fresh(&mut pool, "weight", directions.len());
    let mut vector = vec![pool.zero(); z.len()];
    let mut across = Vec::new();
    for (at, step) in directions.iter().zip(&step) {
        let Image { of, opposite, .. } = own[*at];
        vector[*at] = *step;
        let mut force = equations.all[*at];
        if of != *at {
            vector[of] = signed(&mut pool, *step, !opposite);
            let other = signed(&mut pool, equations.all[of], opposite);
            force = pool.sub(force, other);
        }
        across.push(force);
    }
    let vanish = |pool: &Pool, all: &[ExprId]| all.iter().all(|own| pool.vanishes(*own));
    let moved = pool.substitute(&equations.all, &images);
    let mut differences = Vec::new();
    for (image, moved) in own.iter().zip(moved) {
        let expected = signed(&mut pool, equations.all[image.of], image.opposite);
        differences.push(pool.sub(moved, expected));
    }
    let kind = if vanish(&pool, &differences) {
        Kind::Pitchfork
    } else {
        let held = pool.substitute(&across, &restriction);
        if !vanish(&pool, &held) {
            return None;
        }
        Kind::Transcritical
    };
    let mut all: Vec<ExprId> = values.iter().map(|at| equations.all[*at]).collect();
    let mut bend = Vec::with_capacity(values.len() + across.len() + 1);
    for own in &all {
        let twice = twice_along(&mut pool, *own, unknowns, &vector);
        bend.push(if kind == Kind::Pitchfork { pool.scale(twice, &Number::from(3)) } else { pool.zero() });
    }
    for own in across {
        let slope = along(&mut pool, own, unknowns, &vector);
        let of = if kind == Kind::Pitchfork { slope } else { own };
        bend.push(twice_along(&mut pool, of, unknowns, &vector));
        all.push(slope);
    }
    let mut all = pool.substitute(&all, &restriction);
    let mut bend = pool.substitute(&bend, &restriction);
    all.push(normalisation(&mut pool, &factors, &step));
    bend.push(pool.zero());
    let symbols = values.iter().map(|at| unknowns[*at]).chain(equations.parameters.iter().copied()).chain(steps);
    let unknowns: Vec<Symbol> = symbols.collect();
    let inputs: Vec<Symbol> = unknowns.iter().chain(&weights).copied().collect();
    let bend = Some(Tape::compile(&pool, &bend, &inputs).ok()?);
    let system = Equations { unknowns, parameters: weights, all, is_constrained: false, pool };
    Some(Extended { kind, forces: system.plain()?, bend, origins, values, directions })
}

/// Permutations with signs that leave a place about where it is and reverse its direction.
fn involutions(spot: &Spot<'_>) -> Vec<Involution> {
    let mut found = Vec::new();
    let mut images = vec![None; spot.place.len()];
    extend(spot, 0, &mut images, &mut found);
    found
}

fn extend(spot: &Spot<'_>, at: usize, images: &mut Vec<Option<Image>>, found: &mut Vec<Involution>) {
    if found.len() >= MOST_SYMMETRIES {
        return;
    }
    let Some(own) = images.get(at) else {
        let all: Option<Involution> = images.iter().copied().collect();
        // What leaves all alone reverses nothing.
        found.extend(all.filter(|all| all.iter().enumerate().any(|(at, image)| image.of != at || image.opposite)));
        return;
    };
    if own.is_some() {
        return extend(spot, at + 1, images, found);
    }
    let near =
        |a: f64, b: f64, other: usize| (a - b).abs() <= NEAR * spot.whole[at].width().min(spot.whole[other].width());
    let (x, v) = (spot.place[at], spot.direction[at]);
    let half_turns = if near(x, 0.0, at) { 0 } else { (x / std::f64::consts::PI).round() as i32 };
    if near(x, f64::from(half_turns) * std::f64::consts::PI, at) {
        images[at] = Some(Image { of: at, opposite: true, half_turns });
        extend(spot, at + 1, images, found);
    }
    for other in at + 1..images.len() {
        let (y, w) = (spot.place[other], spot.direction[other]);
        if images[other].is_some() {
            continue;
        }
        for opposite in [false, true] {
            let sign = if opposite { -1.0 } else { 1.0 };
            if near(x, sign * y, other) && (v + sign * w).abs() <= ALIGNED {
                images[at] = Some(Image { of: other, opposite, half_turns: 0 });
                images[other] = Some(Image { of: at, opposite, half_turns: 0 });
                extend(spot, at + 1, images, found);
                images[other] = None;
            }
        }
    }
    if v.abs() <= ALIGNED {
        images[at] = Some(Image::itself(at));
        extend(spot, at + 1, images, found);
    }
    images[at] = None;
}
