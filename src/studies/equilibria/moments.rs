//! Sums of forces, of their moments and of their virials, which vanish at an equilibrium too: what acts between bodies cancels in them.
//!
//! For any field w the forces along it have the sum Σ w_i F_i = dU(q + εw)/dε + Σ w_i Q_i. Fields are translations, rotations and the dilation of
//! coordinates with indices; sums that keep poles are of no use, but for the virial.

use librate_core::expr::{ExprId, Substitution, Symbol, Tape};
use librate_core::linearize::AtRest;
use librate_core::model::Model;
use librate_core::order::Gather;
use librate_core::precision::Interval;

use super::forces::Evaluator;
use super::poles::bases;
use super::symmetric::place;

/// More components are not turned into each other.
const MOST_COMPONENTS: usize = 6;

/// Equations that follow from the others, of a model without constraints, where some coordinates are held; `searched` are the coordinates
/// by number, with these.
pub(super) fn moments(
    model: &Model,
    searched: &[usize],
    rest: &AtRest,
    held: &Substitution,
) -> Option<Evaluator<Interval>> {
    if !rest.constraints.is_empty() {
        return None;
    }
    let mut rest = rest.clone();
    let mut found: Vec<ExprId> = Vec::new();
    for field in fields(model, searched, &mut rest) {
        let along = along(&mut rest, &field);
        let is_dilation = field.iter().zip(&rest.coordinates).all(|(w, q)| rest.pool.as_symbol(*w) == Some(*q));
        if along != rest.pool.zero()
            && (is_dilation || bases(&rest.pool, along, &rest.coordinates).is_empty())
            && !rest.pool.is_undefined(along)
        {
            found.push(along);
        }
    }
    if found.is_empty() {
        return None;
    }
    let AtRest { mut pool, mut coordinates, parameters, .. } = rest;
    let found = pool.substitute(&found, held);
    coordinates.retain(|own| !held.contains_key(own));
    let slopes: Vec<ExprId> = found.iter().flat_map(|own| pool.gradient(*own, &coordinates)).collect();
    let inputs: Vec<Symbol> = coordinates.into_iter().chain(parameters).collect();
    let [force, slopes, drifts] =
        [found.as_slice(), &slopes, &[]].map(|roots| Some(Tape::compile(&pool, roots, &inputs).ok()?.prepare(())));
    Some(Evaluator { force: force?, slopes: slopes?, drifts: drifts?, scratch: Vec::new() })
}

/// Σ w_i F_i.
pub(super) fn along(rest: &mut AtRest, field: &[ExprId]) -> ExprId {
    let AtRest { pool, coordinates, potential, others, .. } = rest;
    let shift = pool.fresh_symbol("shift");
    let epsilon = pool.symbol_expr(shift);
    let mut map = Substitution::default();
    for (symbol, w) in coordinates.iter().zip(field) {
        let (own, by) = (pool.symbol_expr(*symbol), pool.mul(epsilon, *w));
        map.insert(*symbol, pool.add(own, by));
    }
    let moved = pool.substitute_one(*potential, &map);
    let slope = pool.diff(moved, shift);
    let zero = pool.zero();
    let mut terms = vec![pool.substitute_one(slope, &[(shift, zero)].into_iter().collect())];
    terms.extend(field.iter().zip(others.iter()).map(|(w, other)| pool.mul(*w, *other)));
    pool.sum(&terms)
}

/// A component of a vector: its family, and the last index where there are several.
pub(super) type Component = (usize, Option<usize>);

/// The components of vectors, and of each unknown the component and the body: of more than `least` indices the last tells the component, of others
/// the family does.
pub(super) fn bodies(
    model: &Model,
    searched: &[usize],
    least: usize,
) -> (Vec<Component>, Vec<(Component, Vec<usize>)>) {
    let parted = |at: &usize| {
        let (family, mut key) = place(model, *at);
        let component = if key.len() > least { key.pop() } else { None };
        ((family, component), key)
    };
    let places: Vec<(Component, Vec<usize>)> = searched.iter().map(parted).collect();
    let mut components = places.iter().map(|own| own.0).distinct();
    components.truncate(MOST_COMPONENTS);
    (components, places)
}

/// The field of a rotation of all bodies that turns two components into each other; `None` where a body lacks one.
pub(super) fn turn(
    places: &[(Component, Vec<usize>)],
    [first, second]: [Component; 2],
    rest: &mut AtRest,
) -> Option<Vec<ExprId>> {
    let AtRest { pool, coordinates, .. } = rest;
    let turned = places.iter().map(|(component, body)| {
        let (other, sign) = match component {
            own if *own == first => (second, -1),
            own if *own == second => (first, 1),
            _ => return Some(pool.zero()),
        };
        // The same body of another family, or of the same.
        let at = places.iter().position(|own| own.0 == other && own.1 == *body)?;
        let own = pool.symbol_expr(coordinates[at]);
        Some(if sign < 0 { pool.neg(own) } else { own })
    });
    turned.collect()
}

/// Translations along each component of all bodies, rotations of two into each other, and the dilation.
fn fields(model: &Model, searched: &[usize], rest: &mut AtRest) -> Vec<Vec<ExprId>> {
    let (components, places) = bodies(model, searched, 1);
    let (zero, one) = (rest.pool.zero(), rest.pool.one());
    let mut found: Vec<Vec<ExprId>> = Vec::new();
    for (number, first) in components.iter().enumerate() {
        found.push(places.iter().map(|own| if own.0 == *first { one } else { zero }).collect());
        for second in components.iter().skip(number + 1) {
            found.extend(turn(&places, [*first, *second], rest));
        }
    }
    found.push(rest.coordinates.iter().map(|own| rest.pool.symbol_expr(*own)).collect());
    found
}
