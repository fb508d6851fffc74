//! Energies as sums of elements w·phi(s), the way a finite-element code sees them.
//!
//! A term is taken apart, from the outside in, through sums and constant factors, down to functions
//! phi of an inner expression s. Its second derivative is then
//! w·phi''·∇s∇sᵀ + w·phi'·∇∇s: the first part is a factor (it carries accuracy, since it is never
//! added up before it is needed), the second vanishes where the element is unstressed. Squares are
//! never expanded on the way. Nothing is evaluated here.

use std::collections::{BTreeMap, HashMap};

use crate::expr::{ExprId, Node, Pool, Substitution, Symbol};
use crate::number::Number;
use crate::precision::Function;

/// One element, with respect to the variables of its term (by their place in a list).
#[derive(Clone, Debug, PartialEq)]
pub struct Element {
    /// w·phi'(s): the tension; zero where the element is at rest.
    pub first: ExprId,
    /// w·phi''(s): the stiffness of the element.
    pub second: ExprId,
    /// ∇s: the entries that are not zero.
    pub slope: Vec<(usize, ExprId)>,
    /// ∇∇s: the entries on and above the diagonal that are not zero.
    pub curvature: Vec<(usize, usize, ExprId)>,
}

/// What phi is, seen from an element's inner expression.
enum Outer {
    Power(Number),
    Function(Function),
    /// phi(s) = s: nothing more can be split off.
    Identity,
}

/// Takes an expression apart into elements with respect to `variables`.
pub(crate) fn elements(pool: &mut Pool, root: ExprId, variables: &[Symbol]) -> Vec<Element> {
    let places: HashMap<Symbol, usize> = variables
        .iter()
        .enumerate()
        .map(|(place, symbol)| (*symbol, place))
        .collect();
    let varying = varying_nodes(pool, root, &places);
    // Children have smaller numbers than parents: from the top down every weight is complete
    // before it is used.
    let mut weights: BTreeMap<ExprId, Vec<ExprId>> = BTreeMap::new();
    if varying.contains_key(&root) {
        weights.insert(root, vec![pool.one()]);
    }
    let mut result = Vec::new();
    while let Some((node, parts)) = weights.pop_last() {
        let weight = pool.sum(&parts);
        if pool.as_number(weight).is_some_and(Number::is_zero) {
            continue;
        }
        match pool.node(node).clone() {
            Node::Sum { terms, .. } => {
                for (term, coefficient) in &terms {
                    if varying.contains_key(term) {
                        let share = pool.scale(weight, coefficient);
                        weights.entry(*term).or_default().push(share);
                    }
                }
            }
            Node::Product(factors) => {
                let inner: Vec<&(ExprId, Number)> = factors
                    .iter()
                    .filter(|(base, _)| varying.contains_key(base))
                    .collect();
                if let [(base, exponent)] = inner.as_slice() {
                    let mut outside = vec![weight];
                    for (other, power) in factors.iter().filter(|(other, _)| other != base) {
                        outside.push(pool.powr(*other, power));
                    }
                    let weight = pool.product(&outside);
                    if exponent.is_one() {
                        weights.entry(*base).or_default().push(weight);
                    } else {
                        let outer = Outer::Power(exponent.clone());
                        result.push(element(pool, weight, &outer, *base, variables, &places));
                    }
                } else {
                    let constant: Vec<ExprId> = factors
                        .iter()
                        .filter(|(base, _)| !varying.contains_key(base))
                        .map(|(base, power)| (*base, power.clone()))
                        .collect::<Vec<_>>()
                        .into_iter()
                        .map(|(base, power)| pool.powr(base, &power))
                        .chain(std::iter::once(weight))
                        .collect();
                    let weight = pool.product(&constant);
                    let parts: Vec<(ExprId, Number)> = inner.into_iter().cloned().collect();
                    let s = pool.product_of_powers(&parts);
                    result.push(element(
                        pool,
                        weight,
                        &Outer::Identity,
                        s,
                        variables,
                        &places,
                    ));
                }
            }
            Node::Function(function, inner) => {
                let outer = Outer::Function(function);
                result.push(element(pool, weight, &outer, inner, variables, &places));
            }
            Node::Symbol(_) | Node::Power { .. } | Node::Atan2 { .. } => {
                result.push(element(
                    pool,
                    weight,
                    &Outer::Identity,
                    node,
                    variables,
                    &places,
                ));
            }
            Node::Number(_) | Node::Pi | Node::Undefined => {}
        }
    }
    // The order of the text, not of the walk.
    result.reverse();
    result
}

/// The nodes below a root that depend on one of the variables.
fn varying_nodes(
    pool: &Pool,
    root: ExprId,
    places: &HashMap<Symbol, usize>,
) -> HashMap<ExprId, ()> {
    let mut varying = HashMap::new();
    for id in pool.reachable(&[root]) {
        let depends = match pool.node(id) {
            Node::Symbol(symbol) => places.contains_key(symbol),
            Node::Sum { terms, .. } => terms.iter().any(|(term, _)| varying.contains_key(term)),
            Node::Product(factors) => factors.iter().any(|(base, _)| varying.contains_key(base)),
            Node::Power { base, exponent } => {
                varying.contains_key(base) || varying.contains_key(exponent)
            }
            Node::Function(_, inner) => varying.contains_key(inner),
            Node::Atan2 { y, x } => varying.contains_key(y) || varying.contains_key(x),
            Node::Number(_) | Node::Pi | Node::Undefined => false,
        };
        if depends {
            varying.insert(id, ());
        }
    }
    varying
}

fn element(
    pool: &mut Pool,
    weight: ExprId,
    outer: &Outer,
    s: ExprId,
    variables: &[Symbol],
    places: &HashMap<Symbol, usize>,
) -> Element {
    let (first, second) = match outer {
        Outer::Identity => (pool.one(), pool.zero()),
        Outer::Power(exponent) => {
            let one = Number::from(1);
            let once = exponent.sub(&one);
            let twice = once.sub(&one);
            let slope = pool.powr(s, &once);
            let bend = pool.powr(s, &twice);
            (
                pool.scale(slope, exponent),
                pool.scale(bend, &exponent.mul(&once)),
            )
        }
        Outer::Function(function) => {
            let z = pool.symbol("z of phi(z)");
            let ze = pool.symbol_expr(z);
            let phi = pool.apply(*function, ze);
            let slope = pool.diff(phi, z);
            let bend = pool.diff(slope, z);
            let mut at_s = Substitution::default();
            at_s.insert(z, s);
            let both = pool.substitute(&[slope, bend], &at_s);
            (both[0], both[1])
        }
    };
    let first = pool.mul(weight, first);
    let second = pool.mul(weight, second);
    let slope = sparse_gradient(pool, s, variables, places);
    let mut curvature = Vec::new();
    for (i, entry) in &slope {
        for (j, second) in sparse_gradient(pool, *entry, variables, places) {
            if j >= *i {
                curvature.push((*i, j, second));
            }
        }
    }
    Element {
        first,
        second,
        slope,
        curvature,
    }
}

/// The derivatives by the variables that occur, without those that vanish identically.
fn sparse_gradient(
    pool: &mut Pool,
    root: ExprId,
    variables: &[Symbol],
    places: &HashMap<Symbol, usize>,
) -> Vec<(usize, ExprId)> {
    if pool.is_constant(root) {
        return Vec::new();
    }
    let mut present: Vec<usize> = pool
        .symbols_of(&[root])
        .iter()
        .filter_map(|symbol| places.get(symbol).copied())
        .collect();
    present.sort_unstable();
    let by: Vec<Symbol> = present.iter().map(|place| variables[*place]).collect();
    let entries = pool.gradient(root, &by);
    present
        .into_iter()
        .zip(entries)
        .filter(|(_, entry)| !pool.as_number(*entry).is_some_and(Number::is_zero))
        .collect()
}

impl Element {
    /// The same element with its expressions replaced, for instance at velocity zero.
    pub(crate) fn substituted(&self, pool: &mut Pool, values: &Substitution) -> Self {
        let mut roots = vec![self.first, self.second];
        roots.extend(self.slope.iter().map(|(_, entry)| *entry));
        roots.extend(self.curvature.iter().map(|(_, _, entry)| *entry));
        let new = pool.substitute(&roots, values);
        let is_zero = |pool: &Pool, e: ExprId| pool.as_number(e).is_some_and(Number::is_zero);
        let split = 2 + self.slope.len();
        let mut slope: Vec<(usize, ExprId)> = self
            .slope
            .iter()
            .zip(&new[2..split])
            .map(|((i, _), entry)| (*i, *entry))
            .collect();
        let mut curvature: Vec<(usize, usize, ExprId)> = self
            .curvature
            .iter()
            .zip(&new[split..])
            .map(|((i, j, _), entry)| (*i, *j, *entry))
            .collect();
        slope.retain(|(_, entry)| !is_zero(pool, *entry));
        curvature.retain(|(_, _, entry)| !is_zero(pool, *entry));
        if is_zero(pool, new[0]) {
            curvature.clear();
        }
        Self {
            first: new[0],
            second: new[1],
            slope,
            curvature,
        }
    }
}
