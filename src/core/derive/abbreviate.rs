//! Names for what a page would repeat: distances of a molecule, sums of masses, an angle with its arccosine.
//!
//! Counted is what stands on the page, not what the pool holds once. A name is given where it saves much, and the
//! names as a whole have to save a good part of the page; else everything stays written out.

use std::collections::{BTreeMap, BTreeSet};

use hashbrown::HashMap;

use super::motion::MotionSum;
use super::simplify::{Weights, bases_with, rebuild};
use super::{Derivation, Names};
use crate::expr::{ExprId, Node, Pool, Substitution, Symbol};
use crate::number::Number;
use crate::order::{Gather, Order};

/// What is named has so many symbols at least, stands there so often, and saves so many.
const LEAST_SYMBOLS: u64 = 8;
const LEAST_TIMES: u64 = 3;
const LEAST_SAVED: u64 = 60;
/// More names than this are more to remember than they save.
const MOST_NAMES: usize = 12;
/// Rounds of naming: what is named contains what is named in the next one.
const MOST_ROUNDS: usize = 4;

/// A name and what it stands for.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Definition {
    /// The name, which is no name of the model.
    pub name: String,
    /// Its symbol.
    pub symbol: Symbol,
    /// What it stands for; earlier names may occur.
    pub value: ExprId,
    /// The same in the model language, a distance as the length of a vector.
    pub text: String,
}

/// What gets a name.
#[derive(Clone, Copy)]
struct Candidate {
    id: ExprId,
    /// Whether it is the square root of the expression.
    root: bool,
    saved: u64,
}

struct Named {
    symbol: ExprId,
    /// The name of the distance of two points, which tells what it is; others get theirs in the end.
    distance: Option<String>,
    value: ExprId,
    /// How it is written where that is shorter than the value.
    text: Option<String>,
}

impl Derivation {
    /// The same derivation for a page, with names for Lorentz factors and for what it would repeat too often, and what they
    /// stand for, each after those that occur in it. `None` where there is none of the first and the second would save little.
    ///
    /// Closed forms and normal coordinates are left as they are.
    #[must_use]
    pub fn abbreviated(&self) -> Option<(Self, Vec<Definition>)> {
        let mut page = self.clone();
        let mut definitions = page.put_lorentz_factors();
        if let Some((shorter, more)) = page.without_repetitions() {
            definitions.extend(more);
            return Some((shorter, definitions));
        }
        (!definitions.is_empty()).then_some((page, definitions))
    }

    /// Puts in gamma for 1/√(1 - v²/c²), unless the model has that letter.
    fn put_lorentz_factors(&mut self) -> Vec<Definition> {
        let mut roots = Vec::new();
        self.for_each_on_page(&mut |e| roots.push(*e));
        let names = self.names.coordinates.iter();
        let velocity = |name: &String| self.pool.as_symbol(*self.symbols.get(&format!("{name}'"))?);
        let velocities: Vec<Symbol> = names.filter_map(velocity).collect();
        let is_own = |base, exponent: &Number| is_half(exponent) && is_lorentz(&self.pool, &velocities, base);
        let found = bases_with(&self.pool, &roots, is_own);
        let is_taken = |name: &str| name.starts_with("gamma") || name.starts_with('γ');
        if found.is_empty() || self.own_names().any(is_taken) {
            return Vec::new();
        }
        let mut definitions = Vec::new();
        let mut images = Images { images: HashMap::new(), roots: HashMap::new() };
        for (at, base) in found.iter().enumerate() {
            let name = if found.len() == 1 { "gamma".to_owned() } else { format!("gamma{}", at + 1) };
            let symbol = self.pool.fresh_symbol(&name);
            let factor = self.pool.symbol_expr(symbol);
            images.roots.insert(*base, self.pool.powi(factor, -1));
            let value = self.pool.product_of_powers(&[(*base, Number::half().neg())]);
            definitions.push(Definition { name, symbol, value, text: self.pool.display(value) });
        }
        images.apply(&mut self.pool, &roots);
        self.for_each_on_page(&mut |e| *e = images.of(*e));
        definitions
    }

    /// With names for what the page would repeat.
    fn without_repetitions(&mut self) -> Option<(Self, Vec<Definition>)> {
        let mut roots = Vec::new();
        self.for_each_on_page(&mut |e| roots.push(*e));
        let mut weights = Weights::default();
        let before = weights.of_all(&self.pool, &roots);
        if candidates(&self.pool, &mut weights, &roots, &self.entries_on_page()).is_empty() {
            return None;
        }
        let mut page = self.clone();
        let mut pool = std::mem::take(&mut page.pool);
        let mut letters = Letters::new(self);
        let mut named: Vec<Named> = Vec::new();
        for _ in 0..MOST_ROUNDS {
            let mut all = roots.clone();
            all.extend(named.iter().map(|own| own.value));
            let mut chosen = candidates(&pool, &mut weights, &all, &page.entries_on_page());
            chosen.truncate(MOST_NAMES.saturating_sub(named.len()));
            if chosen.is_empty() {
                break;
            }
            let first = named.len();
            named.extend(chosen.iter().map(|candidate| letters.name(&mut pool, *candidate)));
            let (earlier, new) = named.split_at_mut(first);
            let mut images = Images::new(&chosen, new);
            images.apply(&mut pool, &all);
            roots.iter_mut().for_each(|root| *root = images.of(*root));
            for own in earlier {
                let image = images.of(own.value);
                if image != own.value {
                    own.value = image;
                    own.text = None;
                }
            }
            page.for_each_on_page(&mut |e| *e = images.of(*e));
        }
        let definitions: Vec<ExprId> = named.iter().map(|own| own.value).collect();
        let after = weights.of_all(&pool, &roots).saturating_add(weights.of_all(&pool, &definitions));
        // A tenth at least.
        if named.is_empty() || after.saturating_add(before / 10) > before {
            return None;
        }
        let named = in_order(&pool, named);
        let (definitions, renamed) = letters.numbered(&mut pool, named);
        page.for_each_on_page(&mut |e| *e = pool.substitute_one(*e, &renamed));
        page.pool = pool;
        Some((page, definitions))
    }

    /// The entries of M and K: what is searched for there is not to be found elsewhere.
    fn entries_on_page(&self) -> BTreeSet<ExprId> {
        let linear = self.linear.iter();
        linear.flat_map(|linear| linear.mass.iter().chain(&linear.stiffness)).flatten().copied().collect()
    }

    /// What has names.
    fn for_each_on_page(&mut self, visit: &mut dyn FnMut(&mut ExprId)) {
        let mut in_sum = |sum: &mut MotionSum| {
            let powers = sum.powers.iter_mut().flat_map(|own| {
                std::iter::once(&mut own.factor).chain(own.sum.terms.iter_mut().map(|term| &mut term.coefficient))
            });
            powers.chain(sum.terms.iter_mut().map(|term| &mut term.coefficient)).for_each(&mut *visit);
        };
        let [equations, momenta, hamiltonian] =
            ["equations", "momenta", "hamiltonian"].map(|chapter| self.shows(chapter));
        if equations {
            self.equations.iter_mut().flatten().for_each(&mut in_sum);
        }
        if let Some(own) = self.independent.as_mut().filter(|_| equations) {
            own.follows.iter_mut().for_each(|(_, speed)| in_sum(speed));
            own.equations.iter_mut().for_each(&mut in_sum);
        }
        if let Some(energy) = self.energy.as_mut().filter(|_| momenta) {
            energy.momenta.iter_mut().for_each(&mut in_sum);
        }
        if let Some(energy) = self.energy.as_mut().filter(|_| hamiltonian) {
            in_sum(&mut energy.function);
            energy.hamiltonian.iter_mut().for_each(&mut in_sum);
        }
        if let Ok(linear) = &mut self.linear {
            if let Some(part) = &mut linear.second_order {
                part.equations.iter_mut().for_each(&mut in_sum);
                in_sum(&mut part.kinetic);
                in_sum(&mut part.potential);
            }
            linear.mass.iter_mut().chain(&mut linear.stiffness).flatten().for_each(visit);
        }
    }
}

/// What is worth a name, the most saving first; none of them is a part of another.
fn candidates(pool: &Pool, weights: &mut Weights, roots: &[ExprId], entries: &BTreeSet<ExprId>) -> Vec<Candidate> {
    let ids = pool.reachable(roots);
    // How often each stands on the page, and how often below a root or a fractional power.
    let mut times: HashMap<ExprId, u64> = HashMap::with_capacity(ids.len());
    let mut below_root: HashMap<ExprId, u64> = HashMap::new();
    for root in roots {
        *times.entry(*root).or_default() += 1;
    }
    for id in ids.iter().rev() {
        let own = times.get(id).copied().unwrap_or(0);
        pool.node(*id).for_each_child(|child| {
            let count = times.entry(child).or_default();
            *count = count.saturating_add(own);
        });
        if let Node::Product(factors) = pool.node(*id) {
            for (base, _) in factors.iter().filter(|(_, e)| is_half(e)) {
                let count = below_root.entry(*base).or_default();
                *count = count.saturating_add(own);
            }
        }
    }
    let mut found: Vec<Candidate> = Vec::new();
    for id in ids {
        let is_one = pool.terms(id).len() > 1
            || matches!(pool.node(id), Node::Function(..) | Node::Power { .. } | Node::Atan2 { .. });
        let count = times.get(&id).copied().unwrap_or(0);
        if !is_one || count < LEAST_TIMES || entries.contains(&id) {
            continue;
        }
        let root = below_root.get(&id).is_some_and(|of| 2 * of >= count);
        let weight = weights.of(pool, id) + 2;
        if weight < LEAST_SYMBOLS {
            continue;
        }
        // Each but the one in the definition becomes one symbol.
        let saved = ((count - 1).saturating_mul(weight)).saturating_sub(count + 4);
        if saved >= LEAST_SAVED {
            found.push(Candidate { id, root, saved });
        }
    }
    found.order_by_key(|own| (std::cmp::Reverse(own.saved), own.id));
    let mut chosen: Vec<Candidate> = Vec::new();
    let mut inside: BTreeSet<ExprId> = BTreeSet::new();
    for own in found {
        let parts = pool.reachable(&[own.id]);
        if inside.contains(&own.id) || parts.iter().any(|id| chosen.iter().any(|c| c.id == *id)) {
            continue;
        }
        inside.extend(parts);
        chosen.push(own);
        if chosen.len() == MOST_NAMES {
            break;
        }
    }
    chosen
}

/// Whether a sum is 1 less squares and products of velocities.
fn is_lorentz(pool: &Pool, velocities: &[Symbol], e: ExprId) -> bool {
    let Node::Sum { constant, terms } = pool.node(e) else { return false };
    if !constant.is_one() || terms.iter().any(|(_, by)| !by.is_negative()) {
        return false;
    }
    // In velocities, where all terms of a sum are of the same degree; what differs counts as 0.
    let mut degrees: HashMap<ExprId, Number> = HashMap::new();
    for id in pool.reachable(&[e]) {
        let of = |id: ExprId| degrees.get(&id).cloned().unwrap_or(Number::ZERO);
        let degree = match pool.node(id) {
            Node::Symbol(own) if velocities.contains(own) => Number::ONE,
            Node::Sum { constant, terms } => {
                let first = terms.first().map_or(Number::ZERO, |(term, _)| of(*term));
                let alike = constant.is_zero() && terms.iter().all(|(term, _)| of(*term) == first);
                if alike { first } else { Number::ZERO }
            }
            Node::Product(factors) => {
                factors.iter().fold(Number::ZERO, |sum, (base, exponent)| sum.add(&of(*base).mul(exponent)))
            }
            _ => Number::ZERO,
        };
        degrees.insert(id, degree);
    }
    terms.iter().all(|(term, _)| degrees.get(term) == Some(&Number::from(2)))
}

/// Whether an exponent is whole but for a half.
fn is_half(exponent: &Number) -> bool {
    !exponent.is_integer() && exponent.mul(&Number::from(2)).is_integer()
}

/// What becomes of expressions where some have names.
struct Images {
    images: HashMap<ExprId, ExprId>,
    /// The bases whose roots have names.
    roots: HashMap<ExprId, ExprId>,
}

impl Images {
    fn new(chosen: &[Candidate], named: &[Named]) -> Self {
        let of = |root: bool| {
            let own = chosen.iter().zip(named).filter(|(own, _)| own.root == root);
            own.map(|(own, name)| (own.id, name.symbol)).gather()
        };
        Self { images: of(false), roots: of(true) }
    }

    fn of(&self, e: ExprId) -> ExprId {
        self.images.get(&e).copied().unwrap_or(e)
    }

    fn apply(&mut self, pool: &mut Pool, roots: &[ExprId]) {
        for id in pool.reachable(roots) {
            if self.images.contains_key(&id) {
                continue;
            }
            let image = if let Some(root) = self.roots.get(&id) {
                pool.square(*root)
            } else if matches!(pool.node(id), Node::Product(_)) {
                // S^(3/2) is the third power of the root.
                let power = |(base, exponent): (ExprId, Number)| match self.roots.get(&base) {
                    Some(root) => (*root, exponent.mul(&Number::from(2))),
                    None => (self.of(base), exponent),
                };
                let factors: Vec<(ExprId, Number)> = pool.factors(id).into_iter().map(power).collect();
                pool.product_of_powers(&factors)
            } else {
                rebuild(pool, id, &self.images)
            };
            self.images.insert(id, image);
        }
    }
}

/// Names that the model does not use.
struct Letters {
    distance: String,
    other: String,
    count: usize,
    names: Names,
    taken: BTreeSet<String>,
}

impl Letters {
    fn new(derivation: &Derivation) -> Self {
        let taken: BTreeSet<String> = derivation.own_names().map(str::to_owned).gather();
        let free = |letters: &[&str]| {
            let unused = letters.iter().find(|own| !taken.contains(**own));
            unused.map_or_else(|| format!("{}_", letters[0]), ToString::to_string)
        };
        let [distance, other] = [["d", "s", "D", "R"], ["u", "v", "w", "z"]].map(|letters| free(&letters));
        Self { distance, other, count: 0, names: derivation.names.clone(), taken }
    }

    fn name(&mut self, pool: &mut Pool, candidate: Candidate) -> Named {
        let points = if candidate.root { self.points(pool, candidate.id) } else { None };
        let text =
            points.as_ref().map(|Points { family, from, to }| format!("norm({family}[{to}] - {family}[{from}])"));
        let short = points.filter(|own| own.from.len() + own.to.len() == 2);
        let distance = short.map(|Points { from, to, .. }| format!("{}{from}{to}", self.distance));
        let distance = distance.filter(|name| self.taken.insert(name.clone()));
        let symbol = pool.fresh_symbol(distance.as_ref().unwrap_or(&self.other));
        let symbol = pool.symbol_expr(symbol);
        let value = if candidate.root { pool.sqrt(candidate.id) } else { candidate.id };
        Named { symbol, distance, value, text }
    }

    /// The definitions, with numbers in the order in which they stand, and what is renamed for it.
    fn numbered(&mut self, pool: &mut Pool, named: Vec<Named>) -> (Vec<Definition>, Substitution) {
        let mut renamed = Substitution::new();
        let mut definitions = Vec::new();
        for own in named {
            let Some(old) = pool.as_symbol(own.symbol) else { continue };
            let value = pool.substitute_one(own.value, &renamed);
            let (name, symbol) = if let Some(name) = own.distance {
                (name, old)
            } else {
                let name = self.next();
                let symbol = pool.fresh_symbol(&name);
                renamed.insert(old, pool.symbol_expr(symbol));
                (name, symbol)
            };
            definitions.push(Definition { name, symbol, value, text: own.text.unwrap_or_else(|| pool.display(value)) });
        }
        (definitions, renamed)
    }

    /// The next name without a meaning.
    fn next(&mut self) -> String {
        loop {
            self.count += 1;
            let name = format!("{}{}", self.other, self.count);
            if self.taken.insert(name.clone()) {
                return name;
            }
        }
    }

    /// The two points of a family whose distance is the root of a sum of squares.
    fn points(&self, pool: &Pool, e: ExprId) -> Option<Points<'_>> {
        let Node::Sum { constant, terms } = pool.node(e) else { return None };
        let mut axes: BTreeSet<&str> = BTreeSet::new();
        let mut points: Option<Points<'_>> = None;
        for (term, coefficient) in terms {
            let Node::Product(factors) = pool.node(*term) else { return None };
            let [(base, exponent)] = &**factors else { return None };
            let Node::Sum { constant, terms } = pool.node(*base) else { return None };
            let [(a, one), (b, other)] = &**terms else { return None };
            let opposite = one.abs().is_one() && *other == one.neg() && constant.is_zero();
            if !opposite || !coefficient.is_one() || *exponent != Number::from(2) {
                return None;
            }
            let (from, to) = (self.component(pool, *a)?, self.component(pool, *b)?);
            let alike = from.family == to.family && from.axis == to.axis;
            let own = Points { family: from.family, from: from.point, to: to.point };
            if !alike || points.as_ref().is_some_and(|p| *p != own) {
                return None;
            }
            axes.insert(from.axis);
            points = Some(own);
        }
        let points = points.filter(|_| constant.is_zero())?;
        let start = format!("{}[{},", points.family, points.from);
        let all = self.names.coordinates.iter().filter(|name| name.starts_with(&start)).count();
        (all == axes.len()).then_some(points)
    }

    fn component(&self, pool: &Pool, e: ExprId) -> Option<Component<'_>> {
        let name = pool.symbol_name(pool.as_symbol(e)?);
        let own = self.names.coordinates.iter().find(|own| **own == name)?;
        let (family, indices) = own.strip_suffix(']')?.split_once('[')?;
        let (point, axis) = indices.rsplit_once(',')?;
        Some(Component { family, point, axis })
    }
}

/// A coordinate `r[2,1]`.
struct Component<'a> {
    family: &'a str,
    point: &'a str,
    axis: &'a str,
}

#[derive(PartialEq, Eq)]
struct Points<'a> {
    family: &'a str,
    from: &'a str,
    to: &'a str,
}

/// What has names, each after those that it needs.
fn in_order(pool: &Pool, named: Vec<Named>) -> Vec<Named> {
    let symbols: BTreeMap<Symbol, usize> =
        named.iter().enumerate().filter_map(|(at, own)| Some((pool.as_symbol(own.symbol)?, at))).gather();
    let needs: Vec<Vec<usize>> = named
        .iter()
        .map(|own| pool.symbols(own.value).into_iter().filter_map(|symbol| symbols.get(&symbol).copied()).collect())
        .collect();
    let mut done = vec![false; named.len()];
    let mut order = Vec::new();
    let mut weights = Weights::default();
    let weights: Vec<u64> = named.iter().map(|own| weights.of(pool, own.value)).collect();
    // Distances first, by their names; then the shorter ones, so that sums of masses grow term by term.
    let rank = |at: &usize| {
        let name = named[*at].distance.as_deref();
        (name.is_none(), name, weights[*at], *at)
    };
    while let Some(at) =
        (0..named.len()).filter(|at| !done[*at] && needs[*at].iter().all(|need| done[*need])).min_by_key(rank)
    {
        done[at] = true;
        order.push(at);
    }
    let mut all: Vec<Option<Named>> = named.into_iter().map(Some).collect();
    order.into_iter().filter_map(|at| all.get_mut(at).and_then(Option::take)).collect()
}
