//! Energies as sums of elements w·phi(s), the way a finite-element code sees them.
//!
//! A term is taken apart, from the outside in, through sums and constant factors, down to functions
//! phi of an inner expression s. Its second derivative is then
//! w·phi''·∇s∇sᵀ + w·phi'·∇∇s: the first part is a factor (it carries accuracy, since it is never
//! added up before it is needed), the second vanishes where the element is unstressed. Squares are
//! never expanded on the way. Nothing is evaluated here.

use std::collections::BTreeMap;

use hashbrown::HashMap;

use super::facts::{Facts, Variable};
use crate::expr::{ExprId, Node, Pool, Substitution, Symbol};
use crate::model::Local;
use crate::number::Number;
use crate::order::{Gather, Order};
use crate::precision::{Function, Scalar};

/// One element, with respect to the variables of its term (by their place in a list).
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
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
    /// |s|^r for r > 2, which has no corner at 0: r·|s|^(r-2)·s is its derivative.
    PowerOfModulus(Number),
    Function(Function),
    /// phi(s) = s: nothing more can be split off.
    Identity,
}

/// Derivatives of an expression, by symbol.
type Slopes = Box<[(Symbol, ExprId)]>;

/// Takes the terms of one pool apart.
#[derive(Debug)]
pub(crate) struct Splitter {
    pub(crate) facts: Facts,
    /// Derivatives of simple terms by coordinates and by velocities, which the sums of a chain of
    /// links have in common.
    known: [HashMap<ExprId, Slopes>; 2],
}

/// Takes an expression apart into elements with respect to `variables`, which are all the
/// variables of their kind in it.
pub(crate) fn elements(
    pool: &mut Pool,
    splitter: &mut Splitter,
    root: ExprId,
    variables: &[Symbol],
    kind: Variable,
) -> Vec<Element> {
    let places = variables.iter().enumerate().map(|(place, symbol)| (*symbol, place)).gather();
    let variables = Variables { places, kind };
    // Children have smaller numbers than parents: from the top down every weight is complete
    // before it is used.
    let mut weights: BTreeMap<ExprId, Vec<ExprId>> = BTreeMap::new();
    if splitter.facts.varies(pool, root, kind) {
        weights.insert(root, vec![pool.one()]);
    }
    let mut result = Vec::new();
    while let Some((node, parts)) = weights.pop_last() {
        let weight = pool.sum(&parts);
        if weight.is_zero() {
            continue;
        }
        match pool.node(node).clone() {
            Node::Sum { terms, .. } => {
                for (term, coefficient) in &terms {
                    if splitter.facts.varies(pool, *term, kind) {
                        let share = pool.scale(weight, coefficient);
                        weights.entry(*term).or_default().push(share);
                    }
                }
            }
            Node::Product(factors) => {
                let varies = |(base, _): &(ExprId, Number)| splitter.facts.varies(pool, *base, kind);
                let (inner, constant): (Vec<_>, Vec<_>) = factors.iter().cloned().partition(varies);
                let mut outside = vec![weight];
                outside.extend(constant.iter().map(|(base, power)| pool.powr(*base, power)));
                let weight = pool.product(&outside);
                let (outer, s) = match inner.as_slice() {
                    [(base, exponent)] if exponent.is_one() => {
                        weights.entry(*base).or_default().push(weight);
                        continue;
                    }
                    [(base, exponent)] => match pool.node(*base) {
                        Node::Function(Function::Abs, s) if *exponent > Number::from(2) => {
                            (Outer::PowerOfModulus(exponent.clone()), *s)
                        }
                        // In the derivative of (u + |u|)² as a whole no u/|u| is left.
                        Node::Sum { terms, .. } if terms.iter().any(|(term, _)| is_modulus(pool, *term)) => {
                            (Outer::Identity, pool.powr(*base, exponent))
                        }
                        _ => (Outer::Power(exponent.clone()), *base),
                    },
                    parts => (Outer::Identity, pool.product_of_powers(parts)),
                };
                result.push(element(pool, splitter, weight, &outer, s, &variables));
            }
            Node::Function(function, inner) => {
                let outer = Outer::Function(function);
                result.push(element(pool, splitter, weight, &outer, inner, &variables));
            }
            Node::Symbol(_) | Node::Power { .. } | Node::Atan2 { .. } => {
                result.push(element(pool, splitter, weight, &Outer::Identity, node, &variables));
            }
            Node::Number(_) | Node::Pi | Node::Undefined => {}
        }
    }
    // The order of the text, not of the walk.
    result.reverse();
    result
}

fn is_modulus(pool: &Pool, e: ExprId) -> bool {
    matches!(pool.node(e), Node::Function(Function::Abs, _))
}

/// The variables of a term with their places.
struct Variables {
    places: BTreeMap<Symbol, usize>,
    kind: Variable,
}

fn element(
    pool: &mut Pool,
    splitter: &mut Splitter,
    weight: ExprId,
    outer: &Outer,
    s: ExprId,
    variables: &Variables,
) -> Element {
    let slope = splitter.slopes(pool, s, variables);
    let mut curvature = Vec::new();
    for (i, entry) in &slope {
        let seconds = splitter.slopes(pool, *entry, variables).into_iter().filter(|(j, _)| j >= i);
        curvature.extend(seconds.map(|(j, second)| (*i, j, second)));
    }
    // The number of a weight and that of a derivative are multiplied first: long sums are copied for each.
    let weighed = |pool: &mut Pool, e: ExprId, factor: &Number| match pool.as_number(weight) {
        Some(own) => {
            let both = own.mul(factor);
            pool.scale(e, &both)
        }
        None => {
            let e = pool.scale(e, factor);
            pool.mul(weight, e)
        }
    };
    let (first, second) = match outer {
        Outer::Identity => (weight, pool.zero()),
        // At velocity zero, for which alone it is asked, s is 0, and long sums need not be weighed.
        Outer::Power(exponent)
            if *exponent == Number::from(2)
                && curvature.is_empty()
                && variables.kind == Variable::Velocity
                && splitter.facts.rests(pool, s) =>
        {
            let one = pool.one();
            (pool.zero(), weighed(pool, one, exponent))
        }
        Outer::Power(exponent) | Outer::PowerOfModulus(exponent) => {
            let once = exponent.sub(&Number::ONE);
            let twice = once.sub(&Number::ONE);
            let (slope, bend) = if let Outer::Power(_) = outer {
                (pool.powr(s, &once), pool.powr(s, &twice))
            } else {
                let modulus = pool.abs(s);
                let power = pool.powr(modulus, &twice);
                (pool.mul(power, s), power)
            };
            (weighed(pool, slope, exponent), weighed(pool, bend, &exponent.mul(&once)))
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
            (pool.mul(weight, both[0]), pool.mul(weight, both[1]))
        }
    };
    Element { first, second, slope, curvature }
}

impl Splitter {
    /// For terms with these coordinates and velocities.
    pub(crate) fn about<'a>(locals: impl IntoIterator<Item = &'a Local>) -> Self {
        Self { facts: Facts::about(locals), known: Default::default() }
    }

    /// An expression at velocity zero, which `values` puts in.
    pub(crate) fn at_rest(&mut self, pool: &mut Pool, e: ExprId, values: &Substitution) -> ExprId {
        if self.facts.rests(pool, e) {
            pool.zero()
        } else if self.facts.varies(pool, e, Variable::Velocity) {
            pool.substitute_one(e, values)
        } else {
            e
        }
    }

    /// The derivatives by the variables, by place, without those that vanish identically.
    fn slopes(&mut self, pool: &mut Pool, s: ExprId, variables: &Variables) -> Vec<(usize, ExprId)> {
        let kind = variables.kind;
        if !self.facts.varies(pool, s, kind) {
            return Vec::new();
        }
        let slopes = match self.simple_terms(pool, s, kind) {
            Some(terms) => self.slopes_of_terms(pool, &terms, kind),
            None => pool.slopes(s, |symbol| self.facts.is(symbol, kind)),
        };
        let places = &variables.places;
        let mut entries: Vec<(usize, ExprId)> =
            slopes.into_iter().filter_map(|(symbol, slope)| Some((*places.get(&symbol)?, slope))).collect();
        entries.put_in_order();
        entries
    }

    /// The terms of a sum that vary, if they are all simple: then nothing is lost by deriving
    /// them one by one. (A reverse sweep over the sum would share what deeper terms share.)
    fn simple_terms(&mut self, pool: &Pool, s: ExprId, kind: Variable) -> Option<Vec<(ExprId, Number)>> {
        let Node::Sum { terms, .. } = pool.node(s) else { return None };
        let mut simple = Vec::with_capacity(terms.len());
        for (term, coefficient) in terms {
            if self.facts.varies(pool, *term, kind) {
                if !self.facts.of(pool, *term).simple {
                    return None;
                }
                simple.push((*term, coefficient.clone()));
            }
        }
        Some(simple)
    }

    fn slopes_of_terms(
        &mut self,
        pool: &mut Pool,
        terms: &[(ExprId, Number)],
        kind: Variable,
    ) -> Vec<(Symbol, ExprId)> {
        let facts = &self.facts;
        let known = &mut self.known[kind as usize];
        let mut parts: Vec<(Symbol, ExprId, &Number)> = Vec::with_capacity(terms.len());
        for (term, coefficient) in terms {
            let slopes = known
                .entry(*term)
                .or_insert_with(|| pool.slopes(*term, |symbol| facts.is(symbol, kind)).into_boxed_slice());
            let weighted = slopes.iter().map(|(symbol, e)| (*symbol, *e, coefficient));
            parts.extend(weighted);
        }
        parts.order_by_key(|(symbol, ..)| *symbol);
        let mut slopes = Vec::with_capacity(parts.len());
        for group in parts.chunk_by(|(a, ..), (b, ..)| a == b) {
            let slope = match group {
                [(_, single, coefficient)] => pool.scale(*single, coefficient),
                _ => {
                    let group: Vec<(ExprId, Number)> = group.iter().map(|(_, e, c)| (*e, (*c).clone())).collect();
                    pool.linear(&group)
                }
            };
            if let [(symbol, ..), ..] = group
                && !slope.is_zero()
            {
                slopes.push((*symbol, slope));
            }
        }
        slopes
    }
}

impl Element {
    /// The same element at velocity zero, which `values` puts in.
    pub(crate) fn at_rest(&self, pool: &mut Pool, facts: &mut Facts, values: &Substitution) -> Self {
        let mut entries = self.entries();
        let mut open = Vec::new();
        for (at, entry) in entries.iter_mut().enumerate() {
            if facts.rests(pool, *entry) {
                *entry = pool.zero();
            } else if facts.varies(pool, *entry, Variable::Velocity) {
                open.push(at);
            }
        }
        let moving: Vec<ExprId> = open.iter().map(|at| entries[*at]).collect();
        for (at, entry) in open.into_iter().zip(pool.substitute(&moving, values)) {
            entries[at] = entry;
        }
        self.with_entries(&entries)
    }

    /// The same element with its expressions replaced, for instance at velocity zero.
    pub(crate) fn substituted(&self, pool: &mut Pool, values: &Substitution) -> Self {
        let new = pool.substitute(&self.entries(), values);
        self.with_entries(&new)
    }

    /// Whether the force has no value at a point.
    pub(crate) fn has_no_force_at(&self, pool: &mut Pool, values: &Substitution) -> bool {
        let here = self.substituted(pool, values);
        here.slope.iter().map(|(_, entry)| *entry).chain([here.first]).any(|e| pool.is_undefined(e))
    }

    /// Whether force or stiffness has no value at a point. That phi'' has none is no matter where ∇s is 0: where phi' has
    /// a value, phi''·∇s∇sᵀ goes to 0 there.
    pub(crate) fn is_undefined_at(&self, pool: &mut Pool, values: &Substitution) -> bool {
        let here = self.substituted(pool, values);
        let is = |e: ExprId| pool.is_undefined(e);
        is(here.first)
            || (is(here.second) && !here.slope.is_empty())
            || here.slope.iter().any(|(_, entry)| is(*entry))
            || here.curvature.iter().any(|(_, _, entry)| is(*entry))
    }

    /// ∇s of an instance, by coordinate, each once: one may fill two slots of a body.
    pub(super) fn slopes<S: Scalar>(&self, coordinates: &[u32], numbers: &[S]) -> Vec<(usize, S)> {
        let mut slopes: Vec<(usize, S)> = Vec::with_capacity(numbers.len());
        for ((place, _), number) in self.slope.iter().zip(numbers) {
            let coordinate = coordinates[*place] as usize;
            match slopes.iter_mut().find(|(other, _)| *other == coordinate) {
                Some((_, slope)) => *slope = slope.add(number),
                None => slopes.push((coordinate, number.clone())),
            }
        }
        slopes
    }

    /// All its expressions: w·phi', w·phi'', ∇s, ∇∇s.
    pub(crate) fn entries(&self) -> Vec<ExprId> {
        let mut entries = vec![self.first, self.second];
        entries.extend(self.slope.iter().map(|(_, entry)| *entry));
        entries.extend(self.curvature.iter().map(|(_, _, entry)| *entry));
        entries
    }

    /// The element with other expressions, without those that are zero.
    fn with_entries(&self, new: &[ExprId]) -> Self {
        let split = 2 + self.slope.len();
        let mut slope: Vec<(usize, ExprId)> =
            self.slope.iter().zip(&new[2..split]).map(|((i, _), entry)| (*i, *entry)).collect();
        let mut curvature: Vec<(usize, usize, ExprId)> =
            self.curvature.iter().zip(&new[split..]).map(|((i, j, _), entry)| (*i, *j, *entry)).collect();
        slope.retain(|(_, entry)| !entry.is_zero());
        curvature.retain(|(_, _, entry)| !entry.is_zero());
        if new[0].is_zero() {
            curvature.clear();
        }
        Self { first: new[0], second: new[1], slope, curvature }
    }
}
