//! The form that a person would have written: sums multiplied out where that lets them collapse,
//! addition theorems used where they save a term, common factors in front.
//!
//! Several forms of the same expression are made and the one with the fewest symbols is taken;
//! the given one stays where nothing is shorter. All steps are identities that the pool's own
//! constructors apply as well, so that the value never changes.

use std::borrow::Borrow;
use std::collections::{BTreeMap, BTreeSet};
use std::ops::{Deref, DerefMut};

use hashbrown::{HashMap, HashSet};

use super::collapse::collapse;
use crate::expr::{ExprId, Node, Pool, collect_equal};
use crate::number::Number;
use crate::polynomial::add_to;

/// Products of sums are multiplied out to at most so many monomials.
const MOST_MONOMIALS: usize = 2000;
/// Common factors are taken out to this depth of parentheses.
const MOST_NESTED: u32 = 8;

/// A fraction within a sum is as hard to read as so many symbols.
pub(super) const A_STOREY: u64 = 4;

/// Powers of bases in ascending order, without repetition.
pub(super) type Monomial = Vec<(ExprId, Number)>;
/// Monomials with their coefficients.
pub(super) type Monomials = BTreeMap<Monomial, Number>;

/// How many symbols it takes to write the expressions of one pool, roughly.
#[derive(Debug, Default)]
pub(super) struct Weights(Vec<u64>);

/// The expressions of a pool, and the shortest forms that were found of them.
#[derive(Debug)]
pub struct Algebra<'a> {
    pool: &'a mut Pool,
    /// The shortest forms, without products of sums and squares and with them.
    images: HashMap<(bool, ExprId), ExprId>,
    /// Whether products of sums and squares are searched for.
    with_products: bool,
    weights: Weights,
}

impl Deref for Algebra<'_> {
    type Target = Pool;

    fn deref(&self) -> &Pool {
        self.pool
    }
}

impl DerefMut for Algebra<'_> {
    fn deref_mut(&mut self) -> &mut Pool {
        self.pool
    }
}

impl<'a> Algebra<'a> {
    /// Of a pool of which no shortest forms are known yet.
    pub fn new(pool: &'a mut Pool) -> Self {
        Self { pool, images: HashMap::new(), with_products: false, weights: Weights::default() }
    }

    /// The shortest form of a result, with sums as products of sums and with squares completed where that is easier to read.
    pub(super) fn polished(&mut self, e: ExprId) -> ExprId {
        // What differs by its sign stays so.
        let (size, core) = self.pool.split_content(e);
        self.with_products = true;
        let own = self.simplify(core);
        self.with_products = false;
        let own = self.pool.scale(own, &size);
        let own = self.with_common_factors(own);
        if self.cost(&[own]) < self.cost(&[e]) { own } else { e }
    }

    /// A product with what all terms of one of its sums have in common in front, where that is shorter: g a b - g √c is
    /// g (a b - √c).
    fn with_common_factors(&mut self, e: ExprId) -> ExprId {
        let (number, core) = split(self.pool, e);
        let mut made = Monomial::new();
        for (base, power) in self.pool.factors(core) {
            let is_open = power.is_one() && self.pool.is_sum(base);
            let terms = if is_open { expand(self.pool, base, Opening::Outermost) } else { None };
            let Some(terms) = terms.map(Vec::from_iter) else {
                made.push((base, power));
                continue;
            };
            let common: Monomial = common_factor(&terms).into_iter().filter(|own| own.1.is_integer()).collect();
            let rest = terms.iter().map(|(own, value)| (times(own, &common, &Number::MINUS_ONE), value));
            made.push((written(self.pool, rest), Number::ONE));
            made.extend(common);
        }
        let made = self.pool.product_of_powers(&made);
        let made = self.pool.scale(made, &number);
        if self.weight(made) < self.weight(e) { made } else { e }
    }

    /// The shortest form found of an expression, inner arguments included.
    pub fn simplify(&mut self, root: ExprId) -> ExprId {
        if let Some(image) = self.images.get(&(self.with_products, root)) {
            return *image;
        }
        let ids = self.pool.reachable(&[root]);
        // Arguments of functions and factors are shortened for themselves first.
        let mut closed: HashSet<ExprId> = [root].into_iter().collect();
        for id in ids.iter().filter(|id| !self.pool.is_sum(**id)) {
            self.pool.node(*id).for_each_child(|child| _ = closed.insert(child));
        }
        let mut local: HashMap<ExprId, ExprId> = HashMap::new();
        for id in ids {
            if self.pool.is_spent() {
                return root;
            }
            let is_closed = closed.contains(&id);
            if is_closed && let Some(image) = self.images.get(&(self.with_products, id)) {
                local.insert(id, *image);
                continue;
            }
            let rebuilt = rebuild(self.pool, id, &local);
            let new = if is_closed {
                let new = self.shortest(rebuilt);
                self.images.insert((self.with_products, id), new);
                new
            } else {
                rebuilt
            };
            local.insert(id, new);
        }
        local.get(&root).copied().unwrap_or(root)
    }

    /// Brings expressions to their shortest forms.
    pub(super) fn shorten<'e>(&mut self, all: impl Iterator<Item = &'e mut ExprId>) {
        all.for_each(|e| *e = self.simplify(*e));
    }

    /// The shortest form found of what is made.
    pub(super) fn short(&mut self, make: impl FnOnce(&mut Pool) -> ExprId) -> ExprId {
        let made = make(self.pool);
        self.simplify(made)
    }

    /// The shortest form found of a polynomial in bases, of which parts of powers count as one.
    pub(super) fn in_bases<'n>(
        &mut self,
        bases: &Monomial,
        terms: impl Iterator<Item = (&'n [u32], &'n Number)>,
    ) -> ExprId {
        let terms = terms.map(|(powers, value)| {
            let powers = bases.iter().zip(powers).filter(|(_, power)| **power > 0);
            let powers = powers.map(|((base, step), power)| (*base, step.mul(&Number::from(i64::from(*power)))));
            (powers.collect::<Monomial>(), value)
        });
        self.short(|pool| written(pool, terms))
    }

    /// The shortest of the forms of an expression whose closed parts are short already.
    fn shortest(&mut self, e: ExprId) -> ExprId {
        let e = self.cancelled(e);
        if !has_sums(self.pool, e) && !has_functions(self.pool, e) {
            return self.without_bars_under_roots(e);
        }
        let mut best = e;
        let mut before: Option<Vec<(Monomial, Number)>> = None;
        // Whether nothing is left to multiply out: any other opening gives the same terms.
        let mut is_flat = false;
        for opening in [Opening::Outermost, Opening::Factors, Opening::Powers] {
            let wanted = self.with_products && opening == Opening::Powers;
            if is_flat && !wanted {
                continue;
            }
            let terms = if is_flat { before.clone() } else { collapsed(self.pool, best, opening).map(Vec::from_iter) };
            let Some(terms) = terms else { continue };
            let is_open = |(base, exponent): &(ExprId, Number)| opens(exponent) && self.pool.is_sum(*base);
            is_flat = !terms.iter().any(|(monomial, _)| monomial.iter().any(is_open));
            let is_new = before.as_ref() != Some(&terms);
            let flat = is_new.then(|| written(self.pool, terms.iter().map(|(monomial, own)| (monomial, own))));
            let products = if wanted { self.products(&terms) } else { Vec::new() };
            if let Some(flat) = flat {
                before = Some(terms.clone());
                for candidate in [self.nested(terms), flat] {
                    if self.weight(candidate) < self.weight(best) {
                        best = candidate;
                    }
                }
            }
            for candidate in products {
                if self.weight(candidate) <= self.weight(best) {
                    best = candidate;
                }
            }
        }
        let best = self.without_bars_under_roots(best);
        self.over_powers(best)
    }

    /// A sum with common factors in front.
    pub(super) fn nested(&mut self, terms: Vec<(Monomial, Number)>) -> ExprId {
        factor(self.pool, terms, 0)
    }

    /// Factors that all terms of a sum below a fraction bar have in front of it, where what stands above cancels them: m g s/(m l² + m s²) is
    /// g s/(l² + s²).
    fn cancelled(&mut self, e: ExprId) -> ExprId {
        let below =
            |own: &(ExprId, Number), pool: &Pool| own.1.is_integer() && own.1.is_negative() && pool.is_sum(own.0);
        let mut terms = self.pool.terms(e);
        let mut changed = false;
        for (term, coefficient) in &mut terms {
            let mut factors = self.pool.factors(*term);
            if factors.len() < 2 || !factors.iter().any(|own| below(own, self.pool)) {
                continue;
            }
            let several = self.with_products && factors.iter().filter(|own| self.pool.is_sum(own.0)).count() > 1;
            for own in &mut factors {
                if below(own, self.pool) {
                    own.0 = with_common_factor(self.pool, own.0);
                }
                if several
                    && self.pool.is_sum(own.0)
                    && let Some(terms) = expand(self.pool, own.0, Opening::Powers)
                {
                    own.0 = self.in_factors(&terms.into_iter().collect::<Vec<_>>()).unwrap_or(own.0);
                }
            }
            let made = self.pool.product_of_powers(&factors);
            if self.weight(made) < self.weight(*term) {
                let (scale, core) = split(self.pool, made);
                (*term, *coefficient) = (core, coefficient.mul(&scale));
                changed = true;
            }
        }
        if changed { self.pool.linear(&terms) } else { e }
    }

    /// What stands below fraction bars under a root in front of it, where that cancels: a b² √(1 - c²/(a² b²)) is
    /// b √(a² b² - c²).
    fn without_bars_under_roots(&mut self, e: ExprId) -> ExprId {
        let (scale, core) = split(self.pool, e);
        let factors = self.pool.factors(core);
        let is_root = |(base, power): &(ExprId, Number)| power.abs() == Number::half() && self.pool.is_sum(*base);
        if factors.len() < 2 || !factors.iter().any(is_root) {
            return e;
        }
        let mut bars = BTreeSet::new();
        let mut made = Monomial::new();
        for (base, power) in &factors {
            let below = if self.pool.is_sum(*base) { divisors(self.pool, *base) } else { Monomial::new() };
            let terms = if below.is_empty() { None } else { expand(self.pool, *base, Opening::Outermost) };
            let Some(terms) = terms else {
                made.push((*base, power.clone()));
                continue;
            };
            let terms = terms.into_iter().map(|(monomial, own)| (times(&monomial, &below, &Number::ONE), own));
            made.push((written(self.pool, terms), power.clone()));
            bars.extend(below.iter().map(|(base, _)| *base));
            made.extend(below.into_iter().map(|(base, own)| (base, own.mul(power).neg())));
        }
        let whole = self.pool.product_of_powers(&made);
        let made = self.pool.factors(split(self.pool, whole).1);
        // Not where it only goes elsewhere, as in m c²/√(1 - v²/c²).
        let shrinks = |(base, power): &(ExprId, Number)| {
            !bars.contains(base) || power_of(&factors, *base).is_some_and(|own| power.abs() < own.abs())
        };
        let whole = self.pool.scale(whole, &scale);
        if made.iter().all(shrinks) && self.weight(whole) < self.weight(e) { whole } else { e }
    }

    /// The shortest form, multiplied out before that where powers of one sum are put together then.
    pub(super) fn short_over_powers(&mut self, e: ExprId) -> ExprId {
        let short = self.simplify(e);
        let Some(monomials) = collapsed(self.pool, short, Opening::Outermost) else { return short };
        let flat = written(self.pool, monomials);
        let together = self.over_powers(flat);
        let together = self.simplify(together);
        if self.weight(together) < self.weight(short) { together } else { short }
    }

    /// Several powers of one sum below a fraction bar over the highest, where that is shorter: m/√u + m v²/(c² √u³) with
    /// u = 1 - v²/c² is m/√u³.
    fn over_powers(&mut self, e: ExprId) -> ExprId {
        let all = self.pool.terms(e);
        let is_below = |term: &ExprId| {
            is_product_with(self.pool, *term, |base, power| power.is_negative() && self.pool.is_sum(base))
        };
        if !all.iter().any(|(term, _)| is_below(term)) {
            return e;
        }
        // With what an exponent is beyond a whole number.
        let mut powers: BTreeMap<(ExprId, Number), BTreeSet<Number>> = BTreeMap::new();
        for (base, exponent) in all.iter().flat_map(|(term, _)| self.pool.factors(*term)) {
            if self.pool.is_sum(base) {
                let part = exponent.sub(&exponent.floor());
                powers.entry((base, part)).or_default().insert(exponent);
            }
        }
        let mut found = powers.into_iter().filter(|(_, all)| all.len() > 1);
        let lowest =
            found.find_map(|((base, _), all)| Some((base, all.into_iter().next()?)).filter(|(_, e)| e.is_negative()));
        let Some((base, exponent)) = lowest else { return e };
        let inverse = exponent.neg();
        let has = |term: ExprId| {
            self.pool.factors(term).iter().any(|(own, power)| *own == base && power.sub(&exponent).is_integer())
        };
        let (with, without): (Vec<_>, Vec<_>) = all.into_iter().partition(|(term, _)| has(*term));
        let terms = with.into_iter().map(|(term, own)| ([(term, Number::ONE), (base, inverse.clone())], own));
        let above = written(self.pool, terms);
        let Some(monomials) = collapsed(self.pool, above, Opening::Powers) else { return e };
        let above = factor(self.pool, monomials.into_iter().collect(), 0);
        let whole = self.pool.product_of_powers(&[(above, Number::ONE), (base, exponent)]);
        let rest = self.pool.linear(&without);
        let whole = self.pool.add(whole, rest);
        if self.weight(whole) < self.weight(e) { whole } else { e }
    }

    /// How many symbols it takes to write an expression, roughly.
    pub(super) fn weight(&mut self, e: ExprId) -> u64 {
        self.weights.of(self.pool, e)
    }

    fn is_fraction(&self, e: ExprId) -> bool {
        self.pool.factors(e).iter().any(|(_, exponent)| exponent.is_negative())
    }

    fn has_fractions_for_terms(&self, e: ExprId) -> bool {
        self.pool.is_sum(e) && self.pool.terms(e).iter().any(|own| self.is_fraction(own.0))
    }

    /// How many sums have fractions for terms.
    pub(super) fn fractions_in_sums(&self, all: &[ExprId]) -> u64 {
        self.pool.reachable(all).into_iter().filter(|id| self.has_fractions_for_terms(*id)).count() as u64
    }

    /// How many sums of fractions stand above or below a bar.
    pub(super) fn piled_up(&self, e: ExprId) -> u64 {
        let fractions = self.pool.reachable(&[e]).into_iter().filter(|id| self.is_fraction(*id));
        let factors = fractions.flat_map(|id| self.pool.factors(id));
        factors.filter(|own| self.has_fractions_for_terms(own.0)).count() as u64
    }

    /// How hard expressions are to read.
    pub(super) fn cost(&mut self, all: &[ExprId]) -> u64 {
        self.weight_of(all).saturating_add(A_STOREY * self.fractions_in_sums(all))
    }

    /// The same of several.
    pub(super) fn weight_of(&mut self, all: &[ExprId]) -> u64 {
        self.weights.of_all(self.pool, all)
    }
}

impl Weights {
    pub(super) fn of(&mut self, pool: &Pool, e: ExprId) -> u64 {
        if let Some(weight) = self.0.get(e.index()) {
            return *weight;
        }
        for id in pool.ids_from(self.0.len()) {
            let weight = self.own(pool.node(id), pool);
            self.0.push(weight);
        }
        self.0.get(e.index()).copied().unwrap_or(u64::MAX)
    }

    pub(super) fn of_all(&mut self, pool: &Pool, all: &[ExprId]) -> u64 {
        all.iter().fold(0, |sum, e| sum.saturating_add(self.of(pool, *e)))
    }

    fn own(&self, node: &Node, pool: &Pool) -> u64 {
        let of = |id: &ExprId| self.0.get(id.index()).copied().unwrap_or(0);
        let total = |parts: &mut dyn Iterator<Item = u64>| parts.fold(0u64, |sum, part| sum.saturating_add(part));
        match node {
            Node::Number(value) => 1 + 2 * u64::from(!value.is_integer()),
            Node::Pi | Node::Symbol(_) | Node::Undefined => 1,
            Node::Sum { constant, terms } => {
                let mut signs = terms.len() as u64 + u64::from(!constant.is_zero());
                signs = signs.saturating_sub(1);
                let mut parts = terms.iter().map(|(term, c)| {
                    let number = u64::from(!c.abs().is_one()) * (2 + 2 * u64::from(!c.is_integer()));
                    of(term).saturating_add(number)
                });
                total(&mut parts).saturating_add(signs).saturating_add(u64::from(!constant.is_zero()))
            }
            Node::Product(factors) => {
                let mut parts = factors.iter().map(|(base, exponent)| {
                    let parentheses = matches!(pool.node(*base), Node::Sum { .. });
                    let power = 2 * u64::from(!exponent.abs().is_one());
                    of(base).saturating_add(2 * u64::from(parentheses) + power + 1)
                });
                total(&mut parts).saturating_sub(1)
            }
            Node::Power { base, exponent } => of(base).saturating_add(of(exponent)) + 3,
            Node::Function(_, x) => of(x).saturating_add(3),
            Node::Atan2 { y, x } => of(y).saturating_add(of(x)) + 4,
        }
    }
}

/// By what a sum has to be multiplied for no term to have a fraction bar; nothing where some of that may be negative.
fn divisors(pool: &Pool, e: ExprId) -> Monomial {
    let mut found: BTreeMap<ExprId, Number> = BTreeMap::new();
    for (base, power) in pool.terms(e).iter().flat_map(|(term, _)| pool.factors(*term)) {
        if power.is_negative() && power.is_integer() {
            let own = found.entry(base).or_default();
            *own = if *own < power.neg() { power.neg() } else { own.clone() };
        }
    }
    if found.keys().all(|base| pool.is_nonnegative(*base)) { found.into_iter().collect() } else { Monomial::new() }
}

/// Whether a power of this exponent can be multiplied out.
fn opens(exponent: &Number) -> bool {
    exponent.is_integer() && !exponent.is_negative()
}

/// The node with its children replaced by their images.
pub(super) fn rebuild(pool: &mut Pool, id: ExprId, images: &HashMap<ExprId, ExprId>) -> ExprId {
    pool.rebuilt_from(id, |child| images.get(&child).copied().unwrap_or(child))
}

/// Whether there is a sum of several terms to work on, outside of closed parts.
fn has_sums(pool: &Pool, e: ExprId) -> bool {
    let terms = pool.terms(e);
    let is_open = |base, exponent: &Number| opens(exponent) && pool.is_sum(base);
    terms.len() > 1 || terms.iter().any(|(term, _)| is_product_with(pool, *term, is_open))
}

/// Whether functions are among the factors of a single term.
fn has_functions(pool: &Pool, e: ExprId) -> bool {
    let (_, core) = split(pool, e);
    is_product_with(pool, core, |base, _| pool.as_function(base).is_some())
}

/// The bases of powers in some expressions that are such, in ascending order.
pub(super) fn bases_with(pool: &Pool, all: &[ExprId], such: impl Fn(ExprId, &Number) -> bool) -> BTreeSet<ExprId> {
    let mut found = BTreeSet::new();
    for id in pool.reachable(all) {
        if let Node::Product(factors) = pool.node(id) {
            found.extend(factors.iter().filter(|(base, exponent)| such(*base, exponent)).map(|(base, _)| *base));
        }
    }
    found
}

/// Whether an expression is a product with such a factor.
fn is_product_with(pool: &Pool, e: ExprId, such: impl Fn(ExprId, &Number) -> bool) -> bool {
    let Node::Product(factors) = pool.node(e) else { return false };
    factors.iter().any(|(base, exponent)| such(*base, exponent))
}

/// Which sums are multiplied out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Opening {
    /// The outermost one, or one factor of a product.
    Outermost,
    /// All that are factors, but not their squares and higher powers.
    Factors,
    /// All of them.
    Powers,
}

/// The terms of an expression as monomials; `None` where there get too many.
pub(super) fn expand(pool: &mut Pool, e: ExprId, opening: Opening) -> Option<Monomials> {
    let mut monomials = Monomials::new();
    let factors = pool.factors(e);
    // Products of what is still to be multiplied out: (coefficient, factors).
    let mut open: Vec<(Number, Vec<(ExprId, Number)>)> = vec![(Number::ONE, factors)];
    let mut steps = 0;
    let mut outermost = true;
    while let Some((coefficient, factors)) = open.pop() {
        steps += 1;
        if steps > 4 * MOST_MONOMIALS || monomials.len() > MOST_MONOMIALS {
            return None;
        }
        let wanted = |outermost: bool, exponent: &Number| match opening {
            Opening::Outermost => outermost && exponent.is_one(),
            Opening::Factors => exponent.is_one(),
            Opening::Powers => opens(exponent),
        };
        let at = factors.iter().position(|(base, exponent)| wanted(outermost, exponent) && pool.is_sum(*base));
        let Some(at) = at else {
            outermost = false;
            let product = pool.product_of_powers(&factors);
            // Multiplying may have left a number in front.
            let (scale, core) = split(pool, product);
            let coefficient = coefficient.mul(&scale);
            if pool.is_undefined(core) {
                return None;
            }
            match pool.as_number(core) {
                Some(value) if value.is_zero() => {}
                Some(value) => add_to(&mut monomials, Monomial::new(), &coefficient.mul(value)),
                None => add_to(&mut monomials, pool.factors(core), &coefficient),
            }
            continue;
        };
        let (base, exponent) = factors[at].clone();
        let mut rest = factors;
        let less = exponent.sub(&Number::ONE);
        if less.is_zero() {
            rest.remove(at);
        } else {
            rest[at].1 = less;
        }
        outermost = false;
        let Node::Sum { constant, terms } = pool.node(base) else { continue };
        if !constant.is_zero() {
            open.push((coefficient.mul(constant), rest.clone()));
        }
        for (term, factor) in terms {
            let own = pool.factors(*term);
            let is_open = |(base, exponent): &(ExprId, Number)| wanted(false, exponent) && pool.is_sum(*base);
            if rest.is_empty() && !own.iter().any(is_open) {
                add_to(&mut monomials, own, &coefficient.mul(factor));
                continue;
            }
            let mut product = rest.clone();
            product.extend(own);
            open.push((coefficient.mul(factor), product));
        }
        if open.len() > MOST_MONOMIALS {
            return None;
        }
    }
    Some(monomials)
}

/// The same with functions put together.
pub(super) fn collapsed(pool: &mut Pool, e: ExprId, opening: Opening) -> Option<Monomials> {
    let mut monomials = expand(pool, e, opening)?;
    collapse(pool, &mut monomials);
    Some(monomials)
}

/// A sum of one term as its coefficient and the term; all else is its own term.
pub(super) fn split(pool: &Pool, e: ExprId) -> (Number, ExprId) {
    if let [(term, coefficient)] = pool.terms(e).as_slice() { (coefficient.clone(), *term) } else { (Number::ONE, e) }
}

/// The sum of monomials with coefficients.
pub(super) fn written<M: AsRef<[(ExprId, Number)]>, C: Borrow<Number>>(
    pool: &mut Pool,
    terms: impl IntoIterator<Item = (M, C)>,
) -> ExprId {
    let terms = terms.into_iter().map(|(monomial, c)| (pool.product_of_powers(monomial.as_ref()), c.borrow().clone()));
    let terms: Vec<(ExprId, Number)> = terms.collect();
    pool.linear(&terms)
}

/// The sum with common factors in front, as Horner's scheme does it: what is in all terms, then
/// what is in most of them.
fn factor(pool: &mut Pool, mut terms: Vec<(Monomial, Number)>, nested: u32) -> ExprId {
    let mut sum: Vec<ExprId> = Vec::new();
    // The terms without the chosen factor are examined in the next round.
    while !terms.is_empty() {
        let common = common_factor(&terms);
        let mut inner = terms;
        if !common.is_empty() {
            inner.iter_mut().for_each(|(monomial, _)| *monomial = times(monomial, &common, &Number::MINUS_ONE));
        }
        let best = if nested < MOST_NESTED && inner.len() > 2 { most_frequent(&inner) } else { None };
        let Some(best) = best else {
            let value = written(pool, inner);
            sum.push(with_factor(pool, value, &common));
            break;
        };
        let has = |own: &Monomial| power_of(own, best.0).is_some_and(|power| power.is_negative() == best.1);
        let (with, without): (Vec<_>, Vec<_>) = inner.into_iter().partition(|(monomial, _)| has(monomial));
        if common.is_empty() {
            sum.push(factor(pool, with, nested + 1));
            terms = without;
        } else {
            let left = factor(pool, with, nested + 1);
            let right = factor(pool, without, nested + 1);
            let value = pool.add(left, right);
            sum.push(with_factor(pool, value, &common));
            break;
        }
    }
    pool.sum(&sum)
}

/// A sum with what is in all terms in front, and no more; as it is where it is too long.
pub(super) fn with_common_factor(pool: &mut Pool, e: ExprId) -> ExprId {
    let terms = expand(pool, e, Opening::Outermost);
    terms.map_or(e, |terms| factor(pool, terms.into_iter().collect(), MOST_NESTED))
}

fn with_factor(pool: &mut Pool, value: ExprId, common: &Monomial) -> ExprId {
    if common.is_empty() {
        return value;
    }
    let mut factors = common.clone();
    factors.push((value, Number::ONE));
    pool.product_of_powers(&factors)
}

/// The exponent that two powers of one base have in common.
fn shared(a: &Number, b: &Number) -> Option<Number> {
    if a.is_negative() != b.is_negative() {
        return None;
    }
    let smaller = if (a < b) != a.is_negative() { a } else { b };
    Some(smaller.clone())
}

/// What all terms have in common.
pub(super) fn common_factor(terms: &[(Monomial, Number)]) -> Monomial {
    let Some(((first, _), others)) = terms.split_first() else { return Monomial::new() };
    others.iter().fold(first.clone(), |common, (monomial, _)| {
        let shared = |(base, own)| Some((base, shared(&own, power_of(monomial, base)?)?));
        common.into_iter().filter_map(shared).collect()
    })
}

/// The power of a base in a monomial that has it.
pub(super) fn power_of(monomial: &Monomial, base: ExprId) -> Option<&Number> {
    monomial.binary_search_by_key(&base, |(own, _)| *own).ok().map(|at| &monomial[at].1)
}

/// a times b^power.
pub(super) fn times(a: &Monomial, b: &Monomial, power: &Number) -> Monomial {
    let mut product = a.clone();
    product.extend(b.iter().map(|(base, exponent)| (*base, exponent.mul(power))));
    collect_equal(&mut product);
    product
}

/// A base and the side of the fraction bar it stands on.
type Side = (ExprId, bool);

/// The base that stands in most terms, in two at least; the oldest of several. No square is taken apart for one other
/// term and nothing else: a² + d² - 2 a d c stays.
fn most_frequent(terms: &[(Monomial, Number)]) -> Option<Side> {
    let mut found: BTreeMap<Side, Vec<usize>> = BTreeMap::new();
    for (at, (monomial, _)) in terms.iter().enumerate() {
        for (base, exponent) in monomial {
            found.entry((*base, exponent.is_negative())).or_default().push(at);
        }
    }
    found.retain(|(base, _), places| match **places {
        [one, other] => {
            let [one, other] = [one, other].map(|at| &terms[at]);
            power_of(&one.0, *base) == power_of(&other.0, *base)
                || common_factor(&[one.clone(), other.clone()]).len() > 1
        }
        _ => places.len() > 2,
    });
    let most = found.values().map(Vec::len).max()?;
    found.into_iter().find(|(_, places)| places.len() == most).map(|(side, _)| side)
}
