//! The characteristic polynomial of M q'' + (G + C) q' + (K + N) q = 0 in factors, and what stability needs.
//!
//! The polynomial det(s²M + s(G + C) + K + N) is that of each part which hangs together, without what its coefficients have in
//! common. Conditions are compared with certified exponents before they are given out.

use super::Linear;
use super::blocks::{adapted, commuting_mirrors};
use super::check::Checker;
use super::exponents::{Role, StabilityCondition};
use super::frequencies::Case;
use super::pair::Pair;
use super::pervasive::Pervasive;
use super::ring::{EXPONENT, Expanded, Ring};
use super::roots::{MOST_COORDINATES, determinant_of_polynomials};
use super::simplify::{Algebra, split};
use super::stability::{BesideRoot, Sign, Signs, conditions, conditions_in_coefficients, essential};
use crate::expr::{ExprId, Node, Pool};
use crate::groups::connected;
use crate::linearize::grows_from_zero;
use crate::number::Number;
use crate::polynomial::{Polynomial, determinant};
use crate::symmetry::Symmetry;
use crate::syntax::Comparison;

/// K of more coordinates is not looked at.
const MOST_MINORS: usize = 4;
/// Conditions of so few coordinates with friction are short whatever it does.
const FEW: usize = 2;
/// Of models with more coordinates only frequencies are examined.
const MOST_IN_ALL: usize = 40;
/// Determinants of more coordinates are not written out, those beyond the limit of closed forms as polynomials.
const MOST_COORDINATES_OF_POLYNOMIALS: usize = 24;
/// Nor are those of more symbols in all entries.
const MOST_SYMBOLS_OF_POLYNOMIALS: u64 = 3000;
/// Determinants of more symbols in all entries are not multiplied out.
const MOST_SYMBOLS: u64 = 500;
/// Characteristic polynomials of more terms are left out.
const MOST_TERMS: usize = 1000;
/// Conditions of more symbols are left out.
const MOST_IN_CONDITION: u64 = 5000;
/// Longer ones give way to simple ones that are sufficient.
const MOST_BESIDE_ENERGY: u64 = 100;

/// Polynomials in s, the constant first, row by row.
type Matrix = Vec<Vec<Vec<ExprId>>>;

/// A factor of the characteristic polynomial in which no zero is repeated.
pub(super) struct Factor {
    pub(super) polynomial: Polynomial,
    pub(super) times: usize,
    /// How often it is one of a single part, or class of symmetry.
    pub(super) repeated: usize,
    /// A bit for each of the parts, or classes, that have it.
    parts: u64,
}

impl Factor {
    /// Whether it has even powers of s alone.
    pub(super) fn is_even(&self) -> bool {
        self.polynomial.terms().all(|(powers, _)| powers[EXPONENT] % 2 == 0)
    }
}

/// The characteristic polynomial of all parts.
pub(super) struct Factored<'a> {
    checker: &'a Checker<'a>,
    linear: &'a Linear,
    pub(super) ring: Ring,
    pub(super) factors: Vec<Factor>,
    /// How often s is a factor.
    pub(super) zeros: u32,
    signs: Signs,
}

/// What has to be positive for stability.
pub(super) struct Conditions {
    /// As a page has it.
    pub(super) all: Vec<StabilityCondition>,
    /// Whether that tells of special values of the parameters, too.
    pub(super) settled: bool,
    /// What is necessary and sufficient, where the others are only sufficient, and shorter.
    pub(super) exact: Vec<ExprId>,
}

impl<'a> Factored<'a> {
    pub(super) fn new(checker: &'a Checker<'a>, pool: &mut Algebra<'_>, linear: &'a Linear) -> Option<Self> {
        if linear.mass.len() > MOST_IN_ALL {
            return None;
        }
        let rows = (0..linear.mass.len()).map(|i| (0..linear.mass.len()).map(|j| linear.entry(pool, i, j)).collect());
        let rows: Matrix = rows.collect();
        // Of conservative models it is known whether there is a symmetry, and few coordinates need none.
        let symmetric = linear.frequencies.as_ref().is_none_or(|own| own.best().symmetry.is_some());
        let few = linear.is_conservative() && (rows.len() <= MOST_COORDINATES || !symmetric);
        let blocks = if few { None } else { by_symmetry(pool, linear, &rows) };
        let (mut expanded, mut symbols) = (Vec::new(), 0);
        let mut known = known(checker, pool, linear);
        for rows in blocks.unwrap_or_else(|| vec![rows]) {
            let couples = |i: usize, j: usize| rows[i][j].iter().any(|own| !own.is_zero());
            for part in connected(rows.len(), |i, j| couples(i, j) || couples(j, i)) {
                let entries = part.iter().map(|i| part.iter().map(|j| rows[*i][*j].clone()).collect());
                let entries: Matrix = entries.collect();
                let all = entries.concat().concat();
                let weight = pool.weight_of(&all);
                if part.len() > MOST_COORDINATES {
                    if weight > MOST_SYMBOLS_OF_POLYNOMIALS || part.len() > MOST_COORDINATES_OF_POLYNOMIALS {
                        return None;
                    }
                    expanded.push((part.len(), Expanded::new(pool, &all)?));
                    continue;
                }
                let is_short = weight <= MOST_SYMBOLS;
                symbols += weight;
                // Frequencies say what conditions say, elsewhere.
                if linear.is_conservative() && linear.mass.len() > MOST_COORDINATES && symbols > 2 * MOST_SYMBOLS {
                    return None;
                }
                let coefficients = determinant_of_polynomials(pool, &entries)?;
                let open = if is_short { Expanded::new(pool, &coefficients) } else { None };
                let is_open = open.is_some();
                expanded.push((1, open.unwrap_or_else(|| Expanded::as_they_stand(pool, &coefficients))));
                // det M is positive, unless it is 0.
                if coefficients.len() == 2 * part.len() + 1
                    && let Some(last) = coefficients.last()
                {
                    known.0.extend(match is_open {
                        true => Expanded::new(pool, &[*last]),
                        false => Some(Expanded::as_they_stand(pool, &[*last])),
                    });
                }
            }
        }
        let ring = Ring::new(pool, expanded.iter().map(|(_, own)| own).chain(&known.0));
        let mut factors = Vec::new();
        let mut zeros = 0;
        for (part, (n, own)) in expanded.iter().enumerate() {
            let coefficients = ring.polynomials(own)?;
            // Nothing is left of entries that are all 0: the determinant is, whatever the exponent.
            let degrees = coefficients.len().checked_div(n * n).filter(|own| *own > 0)?;
            let entries = coefficients.chunks(degrees);
            let entries: Vec<_> = entries.map(|own| Polynomial::from_coefficients(EXPONENT, own)).collect();
            let polynomial = ring.reduced(determinant(entries.chunks(*n).map(<[_]>::to_vec).collect())?);
            let common = polynomial.common_powers();
            zeros += common[EXPONENT];
            let polynomial = polynomial.without(&common);
            let polynomial = polynomial.over(&polynomial.content(EXPONENT))?;
            for (polynomial, times) in polynomial.split_factors(EXPONENT) {
                join(&mut factors, Factor { polynomial, times, repeated: times, parts: 1 << part });
            }
        }
        let signs = Signs::new(pool, &ring, &known);
        Some(Self { checker, linear, ring, factors, zeros, signs })
    }

    /// From squares of all frequencies; of two that a root tells apart from their sum and product.
    pub(super) fn of_squares(
        checker: &'a Checker<'a>,
        pool: &mut Algebra<'_>,
        linear: &'a Linear,
        case: &Case,
    ) -> Option<Self> {
        let mut open: Vec<(ExprId, usize)> =
            case.frequencies.iter().map(|own| (own.omega_squared, own.multiplicity)).collect();
        let (one, mut zeros, mut expanded) = (pool.one(), 0, Vec::new());
        while let Some((own, times)) = open.pop() {
            if own.is_zero() {
                zeros += 2 * u32::try_from(times).ok()?;
                continue;
            }
            let alone = Expanded::new(pool, &[own, one])?;
            let mut with_other = |(at, (other, others)): (usize, &(ExprId, usize))| {
                let sums = [pool.short(|pool| pool.mul(own, *other)), pool.short(|pool| pool.add(own, *other)), one];
                let quadratic = Expanded::new(pool, &sums).filter(|own| *others == times && !own.has_roots());
                Some((at, quadratic?))
            };
            let pair = alone.has_roots().then(|| open.iter().enumerate().find_map(&mut with_other)).flatten();
            if let Some((at, _)) = &pair {
                open.remove(*at);
            }
            expanded.push((times, pair.map_or(alone, |(_, quadratic)| quadratic)));
        }
        let known = known(checker, pool, linear);
        let ring = Ring::new(pool, expanded.iter().map(|(_, own)| own).chain(&known.0));
        let signs = Signs::new(pool, &ring, &known);
        let factor = |(times, own): &(usize, Expanded)| {
            let polynomial = Polynomial::from_coefficients(EXPONENT, &ring.polynomials(own)?);
            let polynomial = polynomial.with_powers(EXPONENT, |power| Some(2 * power))?;
            Some(Factor { polynomial, times: *times, repeated: *times, parts: 0 })
        };
        let factors = expanded.iter().map(factor).collect::<Option<_>>()?;
        Some(Self { checker, linear, ring, factors, zeros, signs })
    }

    /// The product of all factors; `None` where it would be too long.
    pub(super) fn characteristic(&self, pool: &mut Algebra<'_>) -> Option<Vec<ExprId>> {
        let mut whole = Polynomial::constant(self.ring.variables(), Number::ONE);
        for factor in &self.factors {
            for _ in 0..factor.times {
                whole = whole.times(&factor.polynomial);
                if whole.terms().count() > MOST_TERMS {
                    return None;
                }
            }
        }
        let whole = whole.primitive().coefficients(EXPONENT);
        let mut all: Vec<ExprId> = (0..self.zeros).map(|_| pool.zero()).collect();
        all.extend(whole.iter().map(|own| self.ring.expression(pool, own)));
        if let Some(last) = all.last()
            && self.checker.is_negative(pool, *last) == Some(true)
        {
            all.iter_mut().for_each(|own| *own = pool.short(|pool| pool.neg(*own)));
        }
        Some(all)
    }

    /// Whether the highest coefficient of a factor is positive, as M is.
    pub(super) fn leads_positively(&self, factor: &Factor) -> bool {
        factor.polynomial.coefficients(EXPONENT).last().is_some_and(|own| self.signs.sign(own).holds_always())
    }

    /// What has to be positive for stability; `None` where it is not written out.
    pub(super) fn stability(&self, pool: &mut Algebra<'_>) -> Option<Conditions> {
        let (checker, linear) = (self.checker, self.linear);
        // M > 0 is taken for granted, unless the values say otherwise.
        let is_negative = |pool: &mut Algebra<'_>, i: usize| checker.is_negative(pool, linear.mass[i][i]) == Some(true);
        if (0..linear.mass.len()).any(|i| is_negative(pool, i)) {
            return None;
        }
        let by_energy =
            (linear.damping.is_some() && linear.mass.len() > FEW).then(|| by_energy(checker, pool, linear)).flatten();
        let is_needed = |own: &StabilityCondition| own.role != Role::Sufficient;
        let of_energy = |all, exact| Some(Conditions { all, settled: false, exact });
        if by_energy.as_ref().is_some_and(|all| all.iter().all(is_needed)) {
            return of_energy(by_energy?, Vec::new());
        }
        let exact = self.by_signs(pool);
        let mut is_short = |own: &StabilityCondition| pool.weight_of(&[own.positive]) <= MOST_BESIDE_ENERGY;
        match (exact, by_energy) {
            (Some((long, _)), Some(all)) if !long.iter().all(&mut is_short) => {
                of_energy(all, long.iter().map(|own| own.positive).collect())
            }
            (Some((all, settled)), _) => Some(Conditions { all, settled, exact: Vec::new() }),
            (None, all) => of_energy(all?, Vec::new()),
        }
    }

    /// The same from the signs of what Routh and Hurwitz have, or of discriminants.
    fn by_signs(&self, pool: &mut Algebra<'_>) -> Option<(Vec<StabilityCondition>, bool)> {
        let linear = self.linear;
        let conservative = linear.is_conservative();
        // Exponents of several factors may be equal, without vectors enough.
        let circulatory = linear.circulatory.is_some();
        let bounded = conservative || !circulatory && is_definite(self.checker, pool, linear) == Some(true);
        let kind = [conservative, bounded];
        let mut above = Vec::new();
        let all = self.factors.iter().map(|factor| match BesideRoot::of(factor, &self.ring, &self.signs, kind) {
            Some(own) => {
                above.extend(self.above_root(pool, &own));
                Some(vec![own.constant])
            }
            None => conditions(factor, &self.ring, &self.signs, kind),
        });
        let all = all.collect::<Option<Vec<_>>>().map(|all| all.concat());
        let apart = bounded || self.even_of_one_part().next().is_none();
        let settled = apart && all.as_ref().is_some_and(|all| self.signs.are_settled(all));
        let kept = all.map(|all| essential(&all, &self.signs));
        let found = kept.as_ref().and_then(|kept| self.conditions(pool, kept, above));
        let told = kept.filter(|_| found.is_some());
        let mut found = found.or_else(|| self.in_coefficients(pool, kind))?;
        let mut known = self.signs.clone();
        told.iter().flatten().for_each(|own| known.learn(own));
        found.extend(self.not_zero(pool, &known));
        // Equal exponents have vectors enough where the energy keeps motions in bounds: without circulatory forces, with K definite. With
        // gyroscopic ones alone they may have elsewhere, which is not looked into: a page says that there are special values.
        if !bounded {
            let distinct = self.distinct(pool, &known)?.into_iter();
            let special = |own: StabilityCondition| StabilityCondition { open: None, role: Role::Special, ..own };
            found.extend(distinct.map(|own| if circulatory { own } else { special(own) }));
        }
        (conservative || drifts(pool, linear) == Some(false)).then_some((found, settled))
    }

    /// That b - √n q and b + √n q are positive.
    fn above_root(&self, pool: &mut Algebra<'_>, own: &BesideRoot) -> [StabilityCondition; 2] {
        let sign = of_values(self.checker, pool, &self.ring, &self.signs).sign(&own.base);
        let [middle, base] = [&own.middle, &own.base].map(|own| self.ring.expression(pool, own));
        let number = pool.number(own.number.clone());
        let root = pool.sqrt(number);
        let root = pool.mul(root, base);
        let opposite = pool.neg(root);
        [(opposite, !sign.negative), (root, sign.negative)].map(|(root, is_below)| {
            let positive = pool.add(middle, root);
            let positive = pool.polished(positive);
            // Where the sign of q is known the other one follows.
            StabilityCondition::new(positive, (is_below || !sign.factors.is_empty()).then_some(positive))
        })
    }

    /// Conditions as expressions, behind those that are some already, where they agree with the modes at the values of the parameters.
    fn conditions(
        &self,
        pool: &mut Algebra<'_>,
        all: &[Sign],
        mut found: Vec<StabilityCondition>,
    ) -> Option<Vec<StabilityCondition>> {
        let by_signs = of_values(self.checker, pool, &self.ring, &self.signs);
        for own in all {
            let positive = signed(pool, &self.ring, own);
            if pool.weight_of(&[positive]) > MOST_IN_CONDITION {
                return None;
            }
            let left = by_signs.sign(&own.product(self.ring.variables()));
            let open = (!left.holds_always()).then(|| signed(pool, &self.ring, &left));
            found.push(StabilityCondition::new(positive, open));
        }
        self.agreeing(pool, found)
    }

    /// That no exponent becomes 0 where a constant is a square, which is not negative elsewhere: squares, too, without what other
    /// conditions (`known`) and the signs of the parameters tell.
    fn not_zero(&self, pool: &mut Algebra<'_>, known: &Signs) -> Vec<StabilityCondition> {
        let conservative = self.linear.is_conservative();
        let by_signs = of_values(self.checker, pool, &self.ring, known);
        let mut found: Vec<StabilityCondition> = Vec::new();
        for factor in &self.factors {
            let constant = &factor.polynomial.coefficients(EXPONENT)[0];
            let mut square = |signs: &Signs| {
                let base = signs.open(constant, true);
                let base = (!base.is_constant()).then(|| self.ring.expression(pool, &base));
                base.map(|base| pool.square(base))
            };
            let (positive, open) = (square(known), square(&by_signs));
            let (Some(positive), Some(open)) = (positive, open) else { continue };
            // What no parameter is in is a number.
            if pool.is_constant(positive) || found.iter().any(|other| other.positive == positive) {
                continue;
            }
            let is_special = conservative || !pool.reachable(&[positive]).iter().any(|own| pool.is_sum(*own));
            found.push(match is_special {
                true => StabilityCondition { positive, open: None, role: Role::Special },
                false => StabilityCondition::new(positive, Some(open)),
            });
        }
        found
    }

    /// That factors without odd powers have no zeros in common, where they are of one part: else motions grow as powers of t. Squares, as
    /// conditions are what is positive, without what other conditions tell (`known`); `None` where they have some whatever the
    /// parameters are, or it is too long.
    fn distinct(&self, pool: &mut Algebra<'_>, known: &Signs) -> Option<Vec<StabilityCondition>> {
        let mut found = Vec::new();
        for (one, other) in self.even_of_one_part() {
            let resultant = self.ring.reduced(one.polynomial.resultant_of_even(&other.polynomial, EXPONENT)?);
            if resultant.is_zero() {
                return None;
            }
            let base = known.open(&resultant, false);
            if base.is_constant() {
                continue;
            }
            let base = self.ring.expression(pool, &base);
            let positive = pool.square(base);
            if pool.weight_of(&[positive]) > MOST_IN_CONDITION {
                return None;
            }
            found.push(StabilityCondition::new(positive, Some(positive)));
        }
        Some(found)
    }

    /// Pairs of factors without odd powers that are of one part.
    fn even_of_one_part(&self) -> impl Iterator<Item = (&Factor, &Factor)> {
        let even = |from: usize| self.factors[from..].iter().enumerate().filter(|(_, own)| own.is_even());
        even(0)
            .flat_map(move |(at, one)| even(at + 1).map(move |(_, own)| (one, own)))
            .filter(|(one, other)| one.parts & other.parts != 0)
    }

    /// Conditions in the coefficients of the factors, which are not multiplied out, where they agree with the modes.
    fn in_coefficients(&self, pool: &mut Algebra<'_>, kind: [bool; 2]) -> Option<Vec<StabilityCondition>> {
        let mut found = Vec::new();
        for factor in &self.factors {
            let (coefficients, conditions) = conditions_in_coefficients(factor, &self.signs, kind)?;
            let coefficients = coefficients.iter().map(|own| {
                let own = self.ring.expression(pool, own);
                pool.polished(own)
            });
            let coefficients: Vec<ExprId> = coefficients.collect();
            for condition in conditions {
                let terms = condition.terms().map(|(powers, number)| {
                    let powers = coefficients.iter().zip(powers).map(|(own, power)| pool.powi(*own, i64::from(*power)));
                    let powers: Vec<ExprId> = powers.collect();
                    (pool.product(&powers), number.clone())
                });
                let terms: Vec<(ExprId, Number)> = terms.collect();
                let positive = pool.linear(&terms);
                if pool.weight_of(&[positive]) > MOST_IN_CONDITION {
                    return None;
                }
                if !pool.is_constant(positive) || self.checker.is_negative(pool, positive) != Some(false) {
                    found.push(StabilityCondition::new(positive, Some(positive)));
                }
            }
        }
        self.agreeing(pool, found)
    }

    /// Conditions where they agree with the modes at the values of the parameters.
    fn agreeing(&self, pool: &mut Algebra<'_>, found: Vec<StabilityCondition>) -> Option<Vec<StabilityCondition>> {
        let signs: Vec<Option<bool>> = found.iter().map(|own| self.checker.is_negative(pool, own.positive)).collect();
        // Roots are taken for independent of each other on the way.
        if found.iter().any(|own| pool.vanishes(own.positive)) {
            return None;
        }
        let Some(modes) = self.checker.exponents() else { return Some(found) };
        let unstable = modes.iter().any(|mode| mode.growth.is_positive());
        // What is 0 at the values leaves it open, but not beside what is negative.
        let agrees = if signs.contains(&Some(true)) { unstable } else { !unstable || signs.contains(&None) };
        agrees.then_some(found)
    }
}

/// What has to be positive, as a product.
fn signed(pool: &mut Algebra<'_>, ring: &Ring, own: &Sign) -> ExprId {
    let mut factors: Vec<ExprId> = own.factors.iter().map(|factor| ring.expression(pool, factor)).collect();
    if own.negative {
        // The sign goes into a sum.
        let place = factors.iter().position(|factor| pool.is_sum(*factor)).unwrap_or(0);
        match factors.get_mut(place) {
            Some(factor) => *factor = pool.neg(*factor),
            None => factors.push(pool.integer(-1)),
        }
    }
    // A number before a product says nothing of its sign.
    let product = pool.product(&factors);
    let (size, core) = split(pool, product);
    if pool.is_constant(product) {
        return product;
    }
    if size.is_negative() { pool.neg(core) } else { core }
}

/// What is known to be positive where the parameters have the signs that they have in the model.
fn of_values(checker: &Checker<'_>, pool: &Pool, ring: &Ring, signs: &Signs) -> Signs {
    let mut own = signs.clone();
    for at in 0..ring.variables() {
        let base = ring.base(at).map(|(base, _)| base);
        // A power with a letter for its exponent is a base of its own.
        let base = base.map(|base| if let Node::Power { base, .. } = pool.node(base) { *base } else { base });
        let symbol = base.and_then(|base| pool.as_symbol(base));
        if symbol.and_then(|symbol| checker.sign(symbol)) == Some(false) {
            own.variables[at] = true;
        }
    }
    own
}

/// Whether K is positive definite where the parameters have the signs that they have in the model; `None` where that is too long to be told.
fn is_definite(checker: &Checker<'_>, pool: &mut Algebra<'_>, linear: &Linear) -> Option<bool> {
    let n = linear.stiffness.len();
    let known = known(checker, pool, linear);
    let expanded = if n > MOST_MINORS { None } else { Expanded::new(pool, &linear.stiffness.concat()) }?;
    let ring = Ring::new(pool, std::iter::once(&expanded).chain(&known.0));
    let rows = ring.of_signs(&expanded)?;
    let minor = |size: usize| determinant((0..size).map(|i| rows[n * i..n * i + size].to_vec()).collect());
    let minors: Vec<Polynomial> = (1..=n).map(|size| Some(ring.reduced(minor(size)?))).collect::<Option<_>>()?;
    let general = Signs::new(pool, &ring, &known);
    let by_signs = of_values(checker, pool, &ring, &general);
    Some(minors.iter().all(|own| !own.is_zero() && by_signs.sign(own).holds_always()))
}

/// That friction acts, and that the energy has a minimum, where friction takes energy out of all motions: what is left of that is what
/// keeps frequencies real without it.
fn by_energy(checker: &Checker<'_>, pool: &mut Algebra<'_>, linear: &Linear) -> Option<Vec<StabilityCondition>> {
    let known = known(checker, pool, linear);
    let signs = |pool: &mut Algebra<'_>, ring: &Ring| {
        let general = Signs::new(pool, ring, &known);
        (of_values(checker, pool, ring, &general), general)
    };
    let pervasive = Pervasive::new(pool, linear, &known.0, signs)?;
    let undamped = Linear { damping: None, gyroscopic: None, exponents: None, ..linear.clone() };
    let parts = Factored::new(checker, pool, &undamped)?;
    let zeros = parts.factors.iter().map(|own| own.times * own.polynomial.degree(EXPONENT) as usize).sum::<usize>();
    // All have inertia; and what is never held has friction of its own.
    if zeros + parts.zeros as usize != 2 * linear.mass.len() || parts.zeros > 0 && !pervasive.definite {
        return None;
    }
    let own = essential(&pervasive.conditions, &pervasive.signs);
    let role = if pervasive.needs(&own) { Role::Needed } else { Role::Sufficient };
    let own = own
        .into_iter()
        .map(|own| StabilityCondition { role, ..StabilityCondition::new(signed(pool, &pervasive.ring, &own), None) });
    let mut found: Vec<StabilityCondition> = own.collect();
    found.extend(parts.stability(pool)?.all);
    parts.agreeing(pool, found)
}

impl Linear {
    /// s²M + s(G + C) + K + N, the constant first.
    pub(super) fn entry(&self, pool: &mut Pool, i: usize, j: usize) -> Vec<ExprId> {
        let of = |rows: &Option<Vec<Vec<ExprId>>>| rows.as_ref().map(|rows| rows[i][j]);
        let sum = |pool: &mut Pool, parts: [Option<ExprId>; 2]| {
            let parts: Vec<ExprId> = parts.into_iter().flatten().collect();
            pool.sum(&parts)
        };
        let constant = sum(pool, [Some(self.stiffness[i][j]), of(&self.circulatory)]);
        let velocity = sum(pool, [of(&self.gyroscopic), of(&self.damping)]);
        vec![constant, velocity, self.mass[i][j]]
    }
}

/// What is positive: the diagonal of M, and what the model assumes; and what it assumes to be positive or 0.
fn known(checker: &Checker<'_>, pool: &mut Pool, linear: &Linear) -> (Vec<Expanded>, Vec<ExprId>) {
    let mut all: Vec<ExprId> = linear.mass.iter().enumerate().map(|(i, row)| row[i]).collect();
    let mut weak = Vec::new();
    for own in &checker.model.assumptions {
        match own.relation {
            Comparison::Greater => all.push(pool.sub(own.left, own.right)),
            Comparison::Less => all.push(pool.sub(own.right, own.left)),
            Comparison::GreaterEqual => weak.push(pool.sub(own.left, own.right)),
            Comparison::LessEqual => weak.push(pool.sub(own.right, own.left)),
            Comparison::Equal | Comparison::NotEqual => {}
        }
    }
    all.retain(|own| !own.is_zero());
    weak.retain(|own| !all.contains(own));
    (all.into_iter().filter_map(|own| Expanded::new(pool, &[own])).collect(), weak)
}

/// One block for each class of the mirrors that leave all matrices unchanged; `None` without such mirrors.
fn by_symmetry(pool: &mut Algebra<'_>, linear: &Linear, rows: &Matrix) -> Option<Vec<Matrix>> {
    let pair = Pair::new(&linear.mass, &linear.stiffness).canonical(pool);
    let symmetry = Symmetry::find(&pair.pattern(pool))?;
    let n = rows.len();
    let mut mirrors = commuting_mirrors(&symmetry);
    mirrors.retain(|mirror| {
        (0..n).all(|i| {
            (0..n).all(|j| {
                let ((to, turned), (other, also)) = (mirror.of(i), mirror.of(j));
                rows[i][j].iter().zip(&rows[to][other]).all(|(own, image)| {
                    let image = if turned == also { *image } else { pool.neg(*image) };
                    pool.agree(*own, image)
                })
            })
        })
    });
    if mirrors.is_empty() {
        return None;
    }
    let all: Vec<usize> = (0..n).collect();
    let mut blocks = Vec::new();
    for class in adapted(&mirrors, &all) {
        let mut block = vec![vec![Vec::new(); class.basis.len()]; class.basis.len()];
        for (entries, left) in block.iter_mut().zip(&class.basis) {
            for (entry, right) in entries.iter_mut().zip(&class.basis) {
                let mut sum_of = |power: usize| {
                    let products = left.iter().flat_map(|(i, x)| {
                        right.iter().map(move |(j, y)| (rows[*i][*j][power], Number::from(x * y))).collect::<Vec<_>>()
                    });
                    let products: Vec<(ExprId, Number)> = products.collect();
                    pool.short(|pool| pool.linear(&products))
                };
                *entry = (0..3).map(&mut sum_of).collect();
            }
        }
        blocks.push(block);
    }
    Some(blocks)
}

/// Takes another factor in, without what it has in common with one that is there: parts and classes of symmetry may share exponents.
fn join(factors: &mut Vec<Factor>, new: Factor) {
    let mut open = vec![new];
    while let Some(mut own) = open.pop() {
        for other in factors.iter_mut() {
            if other.polynomial.is_prime_to(&own.polynomial, EXPONENT) {
                continue;
            }
            let common = other.polynomial.common_divisor(&own.polynomial);
            let rests = [&other.polynomial, &own.polynomial].map(|of| of.over(&common));
            if common.degree(EXPONENT) > 0
                && let [Some(of_other), Some(of_own)] = rests
            {
                open.push(Factor { polynomial: of_other, ..*other });
                own.polynomial = of_own;
                let (times, repeated) = (other.times + own.times, other.repeated.max(own.repeated));
                *other = Factor { polynomial: common, times, repeated, parts: other.parts | own.parts };
            }
        }
        if own.polynomial.degree(EXPONENT) > 0 {
            factors.push(own);
        }
    }
}

/// Whether motions grow as t² or faster at the exponent 0, for most values of the parameters, where that is known.
fn drifts(pool: &mut Pool, linear: &Linear) -> Option<bool> {
    let n = linear.mass.len();
    let places = (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
    let entries: Vec<Vec<ExprId>> = places.map(|(i, j)| linear.entry(pool, i, j)).collect();
    grows_from_zero(pool, &entries)
}
