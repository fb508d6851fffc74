//! Symmetries are proved: motions along which the potential does not change, identically.
//!
//! A generator xi(q) with xi·∇U = 0 identically gives K xi(q0) = 0 at every equilibrium q0 (the
//! derivative of the identity, with ∇U(q0) = 0, which generalised forces that act at rest forbid: for those who ask to heed). Two kinds are searched for: constant ones
//! (translations, cyclic coordinates), which are the common null space of all gradients, and
//! rotations of coordinates that come as vectors or as equally long families. Whether an identity
//! holds is decided family by family at random points modulo a large prime.

use std::borrow::Cow;
use std::collections::BTreeMap;

use hashbrown::HashSet;

use super::assemble::{Assembly, ElementFamily};
use super::elimination::{Elimination, Row, nullspace_mod};
use super::parameters::rational_values;
use super::verify::hold_in_true_numbers;
use super::{naming, symbolic};
use crate::expr::{ExprId, ModularPoint, Pool, Symbol, add_mod, fraction_mod, mul_mod, neg_mod};
use crate::groups::Groups;
use crate::model::{CoordinateFamily, Model, TermFamily};
use crate::number::Number;
use crate::order::{Gather, Order};
use crate::precision::{Ball, Scalar};

/// An identity is tested at so many points.
const POINTS: u64 = 6;

/// Energies are written out and added up where terms and coordinates are no more than this, multiplied.
const MOST_TOGETHER: usize = 1000;

/// Stands for a coordinate that a term does not contain; any element but 0 would do.
const STRANGER: u64 = 0x0123_4567_89ab_cdef;

/// A motion along which the potential does not change anywhere, identically.
#[derive(Clone, Debug)]
pub(crate) struct Symmetry {
    generator: Generator,
    /// What it is, in words.
    pub(super) meaning: String,
}

#[derive(Clone, Debug)]
enum Generator {
    /// The same everywhere.
    Constant(Vec<Number>),
    Rotation(Rotation),
}

impl Symmetry {
    /// The generator at a point.
    pub(crate) fn vector<S: Scalar>(&self, at: &[S], precision: S::Precision) -> Vec<S> {
        match &self.generator {
            Generator::Constant(vector) => vector.iter().map(|number| S::from_number(number, precision)).collect(),
            Generator::Rotation(rotation) => {
                let mut vector = vec![S::from_number(&Number::ZERO, precision); at.len()];
                for (i, (partner, minus)) in &rotation.partner {
                    let value = &at[*partner as usize];
                    vector[*i as usize] = if *minus { value.neg() } else { value.clone() };
                }
                vector
            }
        }
    }

    /// The generator, if it is the same everywhere.
    pub(crate) fn constant(&self) -> Option<&[Number]> {
        match &self.generator {
            Generator::Constant(vector) => Some(vector),
            Generator::Rotation(_) => None,
        }
    }

    /// Whether no force that goes with velocities acts along it or on it, identically: D ξ = 0, term by term.
    pub(super) fn is_unmoved(&self, assembly: &Assembly, pool: &mut Pool) -> bool {
        let stranger = pool.fresh_symbol("stranger");
        let stranger = pool.symbol_expr(stranger);
        assembly.velocity.iter().all(|family| {
            let rows = family.velocity_rows(pool);
            let mut tested: HashSet<Vec<ExprId>> = HashSet::new();
            (0..family.terms.count).all(|instance| {
                let speeds = self.speeds(pool, &family.terms, instance, stranger);
                if !tested.insert(speeds.clone()) {
                    return true;
                }
                (0..speeds.len()).all(|i| {
                    let own = rows.iter().filter(|(row, ..)| *row == i);
                    let parts: Vec<ExprId> = own.map(|(_, j, entry)| pool.mul(*entry, speeds[*j])).collect();
                    let sum = pool.sum(&parts);
                    pool.vanishes(sum)
                })
            })
        })
    }

    /// The generator by local variables of a term, with a `stranger` for what the term does not contain.
    fn speeds(&self, pool: &mut Pool, terms: &TermFamily, instance: usize, stranger: ExprId) -> Vec<ExprId> {
        let coordinates = terms.coordinates_of(instance);
        let mut speed = |own: &u32| match &self.generator {
            Generator::Constant(vector) => pool.number(vector.get(*own as usize).cloned().unwrap_or_default()),
            Generator::Rotation(rotation) => {
                let Some((partner, minus)) = rotation.partner.get(own) else { return pool.zero() };
                let place = coordinates.iter().position(|other| other == partner);
                let partner = place.map_or(stranger, |at| pool.symbol_expr(terms.locals[at].coordinate));
                if *minus { pool.neg(partner) } else { partner }
            }
        };
        coordinates.iter().map(&mut speed).collect()
    }

    /// Whether it never moves any but these coordinates.
    pub(super) fn moves_only(&self, allowed: &[bool]) -> bool {
        match &self.generator {
            Generator::Constant(vector) => vector.iter().zip(allowed).all(|(x, ok)| *ok || x.is_zero()),
            Generator::Rotation(rotation) => rotation.partner.keys().all(|i| allowed[*i as usize]),
        }
    }
}

/// The symmetries that never move any but the coordinates allowed to. Those read off modulo a prime
/// are tried in true numbers near `at`. With `at_values` those of small models too that hold for these parameters alone, as equal
/// weights on both sides of a pulley; a frequency that is 0 for them may follow a parameter.
pub(crate) fn symmetries(
    model: &Model,
    assembly: &Assembly,
    at: &[Ball],
    allowed: &[bool],
    at_values: bool,
) -> Vec<Symmetry> {
    let mut pool = model.pool.clone();
    let families = || assembly.families.iter();
    let instances: usize = families().map(|family| family.terms.count).sum();
    let together = instances * at.len() <= MOST_TOGETHER;
    let bodies = if together {
        vec![whole(model, &mut pool, assembly, at_values)]
    } else {
        families().map(|family| body(&mut pool, family)).collect()
    };
    let found = constant_generators(model, &pool, &bodies, allowed);
    let mut found = hold_in_true_numbers(model, assembly, at, found, together);
    found.extend(rotations(model, assembly, &pool, &bodies, together));
    found.retain(|symmetry| symmetry.moves_only(allowed));
    found
}

/// An energy that is to stay unchanged, as its instances fill it in.
struct Body<'a> {
    /// Its coordinates.
    symbols: Vec<Symbol>,
    /// ∂U/∂q by these.
    gradient: Vec<ExprId>,
    /// The coordinates of the model that instances take for them, one after the other.
    coordinates: Cow<'a, [u32]>,
}

impl Body<'_> {
    fn instances(&self) -> impl Iterator<Item = &[u32]> {
        self.coordinates.chunks(self.symbols.len().max(1))
    }
}

/// The energy of a family.
fn body<'a>(pool: &mut Pool, family: &'a ElementFamily) -> Body<'a> {
    let terms = &family.terms;
    Body {
        symbols: terms.locals.iter().map(|local| local.coordinate).collect(),
        gradient: gradient(pool, family),
        coordinates: Cow::Borrowed(&terms.coordinates),
    }
}

/// The sum of all energies, written out: terms may change as long as their sum doesn't.
fn whole(model: &Model, pool: &mut Pool, assembly: &Assembly, at_values: bool) -> Body<'static> {
    let n = model.coordinates.len();
    let here: Vec<ExprId> = model.coordinates.iter().map(|own| pool.symbol_expr(own.symbol)).collect();
    let gradient = symbolic::gradient(model, pool, assembly, &here);
    Body {
        symbols: model.coordinates.iter().map(|own| own.symbol).collect(),
        gradient: if at_values { pool.substitute(&gradient, &rational_values(model)) } else { gradient },
        coordinates: (0..u32::try_from(n).unwrap_or(0)).collect(),
    }
}

/// ∂U/∂q of a family's body by its locals, as expressions.
fn gradient(pool: &mut Pool, family: &ElementFamily) -> Vec<ExprId> {
    let mut parts: Vec<Vec<ExprId>> = vec![Vec::new(); family.terms.locals.len()];
    for element in &family.potential {
        for (place, slope) in &element.slope {
            let part = pool.mul(element.first, *slope);
            parts[*place].push(part);
        }
    }
    parts.iter().map(|parts| pool.sum(parts)).collect()
}

/// Constant vectors along which no term changes, and which move only what is allowed to.
fn constant_generators(model: &Model, pool: &Pool, bodies: &[Body<'_>], allowed: &[bool]) -> Vec<Symmetry> {
    let n = model.coordinates.len();
    let mut spanned = Vec::with_capacity(bodies.len());
    for body in bodies.iter().filter(|body| !body.gradient.iter().all(|slope| slope.is_zero())) {
        let Some(rows) = functionals(pool, &body.gradient) else { return Vec::new() };
        spanned.push((body, rows));
    }
    let visit = |take: &mut dyn FnMut(Row) -> Option<()>| -> Option<()> {
        for (body, rows) in &spanned {
            for (coordinates, row) in body.instances().flat_map(|own| rows.iter().map(move |row| (own, row))) {
                let entries = coordinates.iter().copied().zip(row.iter().copied());
                take(entries.filter(|(_, x)| *x != 0).collect())?;
            }
        }
        Some(())
    };
    // What acts between two coordinates, by their difference alone, leaves them one.
    let mut same = Groups::new(n);
    let _ = visit(&mut |row| {
        if let [(i, x), (j, y)] = row[..]
            && add_mod(x, y) == 0
        {
            same.join(i as usize, j as usize);
        }
        Some(())
    });
    let groups = same.all();
    let mut place = vec![0; n];
    for (own, group) in (0..).zip(&groups) {
        group.iter().for_each(|i| place[*i] = own);
    }
    let mut eliminated = Elimination::default();
    let mut held = allowed.iter().zip(&place).filter(|(ok, _)| !**ok);
    let added = held.try_for_each(|(_, own)| eliminated.add(vec![(*own, 1)]).map(|_| ())).and_then(|()| {
        visit(&mut |mut row| {
            row.iter_mut().for_each(|(i, _)| *i = place[*i as usize]);
            row.put_in_order();
            let of_one = |group: &[(u32, u64)]| (group[0].0, group.iter().fold(0, |sum, (_, x)| add_mod(sum, *x)));
            let row: Row = row.chunk_by(|a, b| a.0 == b.0).map(of_one).filter(|(_, value)| *value != 0).collect();
            if row.is_empty() { Some(()) } else { eliminated.add(row).map(|_| ()) }
        })
    });
    if added.is_none() {
        return Vec::new();
    }
    let symmetry = |vector: Vec<u64>| {
        let of_groups = vector.into_iter().map(fraction_mod).collect::<Option<Vec<Number>>>()?;
        let exact: Vec<Number> = place.iter().map(|own| of_groups[*own as usize].clone()).collect();
        Some(Symmetry { meaning: naming::constant(model, &exact), generator: Generator::Constant(exact) })
    };
    eliminated.kernel(groups.len()).into_iter().filter_map(symmetry).collect()
}

/// The linear functionals of the local coordinates that a constant generator has to annihilate: a
/// reduced basis of the span of the gradient.
fn functionals(pool: &Pool, gradient: &[ExprId]) -> Option<Vec<Vec<u64>>> {
    let d = gradient.len();
    let rows = (0..d as u64 + 3).map(|point| pool.evaluate_at_random(gradient, point));
    // The kernel of all sampled gradients, and the functionals that vanish on it.
    let kernel = nullspace_mod(&rows.collect::<Option<Vec<_>>>()?, d);
    Some(nullspace_mod(&kernel, d))
}

/// A rotation in the plane of two axes: what each coordinate's velocity is.
#[derive(Clone, Debug)]
pub(crate) struct Rotation {
    /// By coordinate: the coordinate that its velocity is, and whether with a minus.
    partner: BTreeMap<u32, (u32, bool)>,
    /// The axis it is about, from 0, in space.
    about: Option<usize>,
}

impl Rotation {
    /// The coordinates in ascending order, with the one that is the velocity of each, and whether with a minus.
    pub(crate) fn parts(&self) -> Vec<(usize, usize, bool)> {
        self.partner.iter().map(|(i, (j, minus))| (*i as usize, *j as usize, *minus)).collect()
    }

    /// Whether nothing else is there that could turn.
    fn turns_all(&self, model: &Model) -> bool {
        model.families.iter().all(|family| family.range().any(|i| self.partner.contains_key(&(i as u32))))
    }
}

/// What a rotation is called.
pub(crate) fn rotation_name(model: &Model, rotation: &Rotation) -> String {
    let turned: Vec<u32> = rotation.partner.keys().copied().collect();
    naming::rotation(model, &turned, rotation.about, rotation.turns_all(model))
}

/// Coordinates that come as vectors, of which there may be several widths, in the order in which they are tried:
/// by axis, those of all bodies.
fn vectors(model: &Model) -> Vec<Vec<Vec<usize>>> {
    let mut spaces = Vec::new();
    // Families of vectors of the same width turn together.
    for (width, least) in [(2_usize, 2), (3, 2), (2, 1), (3, 1)] {
        let turns = |own: &&CoordinateFamily| own.extents.len() >= least && own.extents.last() == Some(&width);
        let vectors: Vec<_> = model.families.iter().filter(turns).collect();
        // A family with one index is one vector, or many numbers: it is tried after the others.
        if vectors.is_empty() || least == 1 && vectors.iter().all(|one| one.extents.len() > 1) {
            continue;
        }
        let axis = |axis: usize| {
            let of = |family: &&CoordinateFamily| (family.first + axis..family.first + family.len()).step_by(width);
            vectors.iter().flat_map(of).collect()
        };
        spaces.push((0..width).map(axis).collect());
    }
    spaces
}

/// Equally long plain families, or single coordinates, as axes of one space.
fn plain_spaces(model: &Model) -> impl Iterator<Item = Vec<Vec<usize>>> {
    let mut lengths: BTreeMap<usize, Vec<Vec<usize>>> = BTreeMap::new();
    for family in model.families.iter().filter(|family| family.extents.len() <= 1) {
        lengths.entry(family.len()).or_default().push(family.range().collect());
    }
    lengths.into_values()
}

/// Single coordinates that are named by their axis and a number, as `x1`, `y1`, `x2`, `y2`, by axis.
fn named_space(model: &Model) -> Vec<Vec<usize>> {
    let mut named: BTreeMap<String, Vec<usize>> = BTreeMap::new();
    for (i, mut axis) in model.coordinates.names().enumerate() {
        axis.truncate(axis.trim_end_matches(|c: char| c.is_numeric() || c == '_').len());
        named.entry(axis).or_default().push(i);
    }
    named.into_values().collect()
}

/// The spaces that coordinates may be those of: vectors, plain families as axes, and single coordinates with an axis and a number. By axis,
/// those of all bodies.
pub(super) fn spaces(model: &Model) -> Vec<Vec<Vec<usize>>> {
    let mut spaces = vectors(model);
    spaces.extend(plain_spaces(model));
    spaces.push(named_space(model));
    spaces.retain(|axes| axes.windows(2).all(|pair| pair[0].len() == pair[1].len()));
    spaces
}

/// The planes in which coordinates can be rotated together.
pub(crate) fn candidate_rotations(model: &Model) -> Vec<Rotation> {
    let mut spaces = vectors(model);
    // More than a few axes are no space that turns.
    let named = |axes: &[Vec<usize>]| {
        let first = |axis: &Vec<usize>| axis.first().map(|i| model.coordinates.at(*i).name());
        axes.iter()
            .zip(0..)
            .all(|(axis, number)| first(axis).is_some_and(|name| name.starts_with(naming::axis_name(number).as_str())))
    };
    let vectors = spaces.len();
    spaces.extend(plain_spaces(model).filter(|axes| (2..=6).contains(&axes.len())));
    let bodies = named_space(model);
    let is_space = bodies.iter().all(|axis| axis.len() > 1 && axis.len() == bodies[0].len());
    spaces.extend((is_space && (2..=3).contains(&bodies.len())).then_some(bodies));
    let mut rotations = Vec::new();
    for (number, axes) in spaces.into_iter().enumerate() {
        // Vectors have the axes x, y and z; what stands alone may be called so.
        let in_space = axes.len() == 3 && (number < vectors || named(&axes));
        for a in 0..axes.len() {
            for b in a + 1..axes.len() {
                let mut partner = BTreeMap::new();
                for (i, j) in axes[a].iter().zip(&axes[b]) {
                    let (i, j) = (*i as u32, *j as u32);
                    partner.insert(i, (j, true));
                    partner.insert(j, (i, false));
                }
                let about = in_space.then(|| 3 - a - b);
                rotations.push(Rotation { partner, about });
            }
        }
    }
    rotations
}

fn rotations(model: &Model, assembly: &Assembly, pool: &Pool, bodies: &[Body<'_>], together: bool) -> Vec<Symmetry> {
    let mut found = Vec::new();
    let holds = |rotation: &Rotation| bodies.iter().all(|body| is_invariant(pool, body, rotation));
    for rotation in candidate_rotations(model) {
        if !holds(&rotation) {
            continue;
        }
        let components = components(model.coordinates.len(), assembly, &rotation);
        let whole = components.len() == 1 && rotation.turns_all(model);
        for component in &components {
            let parts = component.iter().filter_map(|i| rotation.partner.get_key_value(i));
            let partner = parts.map(|(i, own)| (*i, *own)).gather();
            let own = Rotation { partner, about: rotation.about };
            // What one part gains may be what another loses.
            if together && components.len() > 1 && !holds(&own) {
                continue;
            }
            let meaning = naming::rotation(model, component, rotation.about, whole);
            found.push(Symmetry { generator: Generator::Rotation(own), meaning });
        }
    }
    found
}

/// Whether an energy does not change under a rotation, identically: Σ xi_i ∂U/∂q_i = 0.
fn is_invariant(pool: &Pool, body: &Body<'_>, rotation: &Rotation) -> bool {
    let mut tested: HashSet<Vec<Option<(usize, bool)>>> = HashSet::new();
    for coordinates in body.instances() {
        // The partner of every local: a local too, or one that the term does not contain.
        let partner = |coordinate: &u32| {
            let (partner, minus) = rotation.partner.get(coordinate)?;
            let place = coordinates.iter().position(|other| other == partner);
            Some((place.unwrap_or(usize::MAX), *minus))
        };
        let pattern: Vec<Option<(usize, bool)>> = coordinates.iter().map(partner).collect();
        if !tested.insert(pattern.clone()) {
            continue;
        }
        for point in 0..POINTS {
            let seed = 1000 + point;
            let value = |symbol| ModularPoint::random_value(seed, symbol);
            let Some(slopes) = pool.evaluate_mod(&body.gradient, value, seed) else { return false };
            let mut sum = 0;
            for (place, partner) in pattern.iter().enumerate() {
                let Some((partner, minus)) = partner else { continue };
                let velocity = match body.symbols.get(*partner) {
                    Some(symbol) => value(*symbol),
                    // The term does not contain the partner: any value will do.
                    None => STRANGER + place as u64,
                };
                let velocity = if *minus { neg_mod(velocity) } else { velocity };
                sum = add_mod(sum, mul_mod(velocity, slopes[place]));
            }
            if sum != 0 {
                return false;
            }
        }
    }
    true
}

/// The bodies that hang together, with the axes of a rotation tied to each other.
fn components(n: usize, assembly: &Assembly, rotation: &Rotation) -> Vec<Vec<u32>> {
    let mut together = Groups::new(n);
    let mut tie = |a: u32, b: u32| together.join(a as usize, b as usize);
    for (family, instance) in assembly.instances().filter(|(family, _)| !family.potential.is_empty()) {
        for pair in family.terms.coordinates_of(instance).windows(2) {
            tie(pair[0], pair[1]);
        }
    }
    for (i, (j, _)) in &rotation.partner {
        tie(*i, *j);
    }
    let turning = |group: Vec<usize>| -> Vec<u32> {
        let all = group.into_iter().map(|i| i as u32);
        all.filter(|i| rotation.partner.contains_key(i)).collect()
    };
    together.all().into_iter().map(turning).filter(|group| !group.is_empty()).collect()
}
