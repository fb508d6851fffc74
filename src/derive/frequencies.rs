//! Symmetry classes and closed forms of the frequencies.
//!
//! M and K are looked at twice: as they stand, and with parameters of a kind that have equal values taken
//! as one. What hangs together is a part; chains, rings and nets are recognised (`lattice`), the other
//! parts are taken apart by symmetry (`blocks`), and blocks are solved (`roots`). Every closed form
//! is compared with certified numbers before it is given out (`check`).

use std::collections::BTreeMap;

use super::blocks::{adapted, commuting_mirrors, is_free, waves};
use super::check::Checker;
use super::lattice::{Angles, Lattice, lattice};
use super::pair::{Pair, Sparse};
use super::roots::{Degree, roots};
use super::simplify::Simplifier;
use super::ties::Ties;
use crate::expr::{ExprId, Node, Pool};
use crate::model::Model;
use crate::number::Number;
use crate::symmetry::{GroupKind, SignedPermutation, Symmetry, wave_number};

/// Larger models get no closed forms: they could not be checked in reasonable time.
const MOST_COORDINATES: usize = 1500;

/// Closed forms of more symbols than this are no help to anybody.
const MOST_SYMBOLS: u64 = 160;

/// What the symmetry of a model tells about its frequencies.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Frequencies {
    /// With all parameters different.
    pub general: Case,
    /// With parameters equal as their values are, where that tells more.
    pub tied: Option<Case>,
    /// A symmetry that the model would have if parameters were equal that aren't.
    pub would_be: Option<Exchange>,
    /// What is taken to be positive, or where the second is true negative, as it is at the values.
    pub signs: Vec<(ExprId, bool)>,
    /// What has been done to the frequencies since.
    pub approximations: Vec<Approximation>,
}

/// What has been done to closed forms.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Approximation {
    /// A parameter went to a value.
    Limit {
        /// The parameter.
        name: String,
        /// The value.
        value: Number,
    },
    /// They were expanded in powers of a parameter.
    Expansion {
        /// The parameter.
        name: String,
        /// The highest power.
        order: u32,
    },
}

/// A symmetry and what it needs.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Exchange {
    /// Generators of the group.
    pub generators: Vec<SignedPermutation>,
    /// What kind of group it is.
    pub kind: GroupKind,
    /// The parameters that have to be equal for it, set by set.
    pub ties: Vec<Vec<String>>,
}

/// Frequencies under some equalities of parameters.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Case {
    /// The parameters that are taken to be equal, set by set; the first stands for all.
    pub ties: Vec<Vec<String>>,
    /// The symmetry, with the ties that it needs by itself.
    pub symmetry: Option<Exchange>,
    /// Blocks of M and K, one a class, where mirrors take them apart.
    pub blocks: Vec<Block>,
    /// Series of frequencies, given by their number.
    pub series: Vec<Series>,
    /// The closed forms, checked, one for each distinct frequency.
    pub frequencies: Vec<Frequency>,
    /// Whether these are all frequencies.
    pub complete: bool,
}

/// A frequency in closed form.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Frequency {
    /// omega^2.
    pub omega_squared: ExprId,
    /// How many modes have it.
    pub multiplicity: usize,
    /// The class of these modes, where they all have the same.
    pub symmetry: Option<String>,
}

/// M and K among vectors of one class of symmetry.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Block {
    /// The class.
    pub class: String,
    /// The vectors: coordinates with whole components.
    pub basis: Vec<Vec<(usize, i64)>>,
    /// BᵀMB for the vectors as the columns of B, row by row.
    pub mass: Vec<Vec<ExprId>>,
    /// BᵀKB.
    pub stiffness: Vec<Vec<ExprId>>,
}

/// Frequencies of a chain, ring or net as a function of their numbers.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Series {
    /// omega^2 in the symbols `j` (and `i` before it, in two dimensions).
    pub omega_squared: ExprId,
    /// The names of the numbers, with their angles.
    pub numbers: Vec<(String, Angles)>,
}

/// What is found on the way, before it is checked.
#[derive(Default)]
struct Found {
    /// By omega^2: multiplicity and class, where all have the same.
    frequencies: BTreeMap<ExprId, (usize, Option<String>)>,
    series: Vec<Series>,
    blocks: Vec<Block>,
    count: usize,
}

impl Found {
    fn add(&mut self, omega_squared: ExprId, multiplicity: usize, symmetry: Option<String>) {
        let place = self.frequencies.entry(omega_squared);
        let (count, class) = place.or_insert_with(|| (0, symmetry.clone()));
        *count += multiplicity;
        if *class != symmetry {
            *class = None;
        }
        self.count += multiplicity;
    }
}

/// Looks for symmetries and closed forms.
pub(super) fn frequencies(
    model: &Model,
    pool: &mut Pool,
    short: &mut Simplifier,
    mass: &[Vec<ExprId>],
    stiffness: &[Vec<ExprId>],
    cubic: bool,
) -> Frequencies {
    let degree = if cubic { Degree::Three } else { Degree::Two };
    let pair = Pair::new(pool, mass, stiffness);
    let checker = Checker::new(model, &pair);
    let (pair, mut signs) = checker.signed(pool, short, &pair);
    let pair = pair.canonical(pool, short);
    let used = pool.symbols_of(&pair.values());
    let pattern = pair.pattern(pool);
    let plain = Symmetry::find(&pattern);
    let order = |symmetry: &Option<Symmetry>| symmetry.as_ref().map_or(1.0, |found| found.order);
    let none = Ties::default();
    let mut general = case(model, pool, short, &pair, plain.as_ref(), &none, degree);
    checker.check(pool, &pair, &mut general);

    let ties = Ties::of_a_kind(model, pool, &used, true);
    let mut tied = None;
    let mut tied_order = order(&plain);
    if !ties.is_empty() {
        let map = ties.substitution(model, pool);
        let equal = pair.substituted(pool, short, &map);
        let (equal, more) = checker.signed(pool, short, &equal);
        signs.extend(more);
        let equal = equal.canonical(pool, short);
        let pattern = equal.pattern(pool);
        let symmetry = Symmetry::find(&pattern);
        tied_order = tied_order.max(order(&symmetry));
        if equal.values().iter().any(|value| pool.is_undefined(*value)) {
            return Frequencies {
                general,
                tied: None,
                would_be: None,
                signs,
                approximations: Vec::new(),
            };
        }
        let mut found = case(model, pool, short, &equal, symmetry.as_ref(), &ties, degree);
        if let (Some(own), Some(symmetry)) = (&mut found.symmetry, &symmetry) {
            let needed = ties.needed(model, pool, short, &pair, &symmetry.generators);
            let map = needed.substitution(model, pool);
            let pair = pair.substituted(pool, short, &map);
            let pattern = pair.pattern(pool);
            let holds = symmetry.generators.iter().all(|g| pattern.is_kept_by(g));
            own.ties = if holds { needed } else { ties.clone() }.sets(model);
        }
        checker.check(pool, &equal, &mut found);
        let more_symmetric = order(&symmetry) > order(&plain);
        let solved = |case: &Case| {
            case.frequencies
                .iter()
                .map(|f| f.multiplicity)
                .sum::<usize>()
        };
        let shorter = |case: &Case, short: &mut Simplifier| -> u64 {
            let all = case.frequencies.iter();
            all.map(|f| short.weight(pool, f.omega_squared)).sum()
        };
        let better = solved(&found) > solved(&general)
            || (solved(&found) > 0 && shorter(&found, short) < shorter(&general, short));
        if more_symmetric || better {
            tied = Some(found);
        }
    }

    let mut would_be = None;
    let all = Ties::of_a_kind(model, pool, &used, false);
    // Equal parameters may move an equilibrium that depends on them.
    let at_zero = model
        .guesses
        .iter()
        .chain(&model.equilibria)
        .all(Option::is_none);
    if at_zero && !all.is_empty() && all != ties {
        let map = all.substitution(model, pool);
        let equal = pair.substituted(pool, short, &map);
        let equal = equal.canonical(pool, short);
        if equal.values().iter().any(|value| pool.is_undefined(*value)) {
            return Frequencies {
                general,
                tied,
                would_be: None,
                signs,
                approximations: Vec::new(),
            };
        }
        let pattern = equal.pattern(pool);
        if let Some(symmetry) = Symmetry::find(&pattern)
            && symmetry.order > tied_order
        {
            let needed = all.needed(model, pool, short, &pair, &symmetry.generators);
            let map = needed.substitution(model, pool);
            let equal = pair.substituted(pool, short, &map);
            let equal = equal.canonical(pool, short);
            let pattern = equal.pattern(pool);
            if symmetry.generators.iter().all(|g| pattern.is_kept_by(g)) {
                would_be = Some(Exchange {
                    generators: symmetry.generators,
                    kind: symmetry.kind,
                    ties: needed.sets(model),
                });
            }
        }
    }
    Frequencies {
        general,
        tied,
        would_be,
        signs,
        approximations: Vec::new(),
    }
}

fn case(
    model: &Model,
    pool: &mut Pool,
    short: &mut Simplifier,
    pair: &Pair,
    symmetry: Option<&Symmetry>,
    ties: &Ties,
    degree: Degree,
) -> Case {
    let mut found = Found::default();
    if pair.len() <= MOST_COORDINATES {
        closed_forms(pool, short, pair, symmetry, degree, &mut found);
    }
    let frequencies: Vec<Frequency> = found
        .frequencies
        .into_iter()
        .map(|(omega_squared, (multiplicity, symmetry))| Frequency {
            omega_squared,
            multiplicity,
            symmetry,
        })
        .collect();
    Case {
        ties: ties.sets(model),
        symmetry: symmetry.map(|symmetry| Exchange {
            generators: symmetry.generators.clone(),
            kind: symmetry.kind.clone(),
            ties: Vec::new(),
        }),
        blocks: found.blocks,
        series: found.series,
        complete: found.count == pair.len(),
        frequencies,
    }
}

fn closed_forms(
    pool: &mut Pool,
    short: &mut Simplifier,
    pair: &Pair,
    symmetry: Option<&Symmetry>,
    degree: Degree,
    found: &mut Found,
) {
    let parts = pair.components(pool);
    let mut rest: Vec<usize> = Vec::new();
    for part in &parts {
        let own = pair.restricted(part);
        if is_free(pool, &own) {
            let zero = pool.zero();
            found.add(zero, part.len(), None);
        } else if let Some(lattice) = lattice(pool, short, &own) {
            let symmetry = symmetry.filter(|_| parts.len() == 1);
            add_lattice(pool, short, &lattice, symmetry, found);
        } else {
            rest.extend(part);
        }
    }
    if rest.is_empty() {
        return;
    }
    rest.sort_unstable();
    if let Some(symmetry) = symmetry {
        if let Some(waves) = waves(pool, short, pair, symmetry, &rest)
            && let GroupKind::Ring { length, .. } = symmetry.kind
        {
            let n = i64::try_from(length).unwrap_or(i64::MAX);
            let angles = Angles::of_ring(n);
            for j in 0..=n / 2 {
                let angle = angles.angle(pool, j);
                let twice = j > 0 && 2 * j < n;
                for value in waves.at(pool, angle) {
                    let value = short.simplify(pool, value);
                    let class = usize::try_from(j).map(wave_number).ok();
                    found.add(value, if twice { 2 } else { 1 }, class);
                }
            }
            let number = pool.variable("j");
            let angle = angles.general(pool, number);
            for omega_squared in waves.at(pool, angle) {
                found.series.push(Series {
                    omega_squared,
                    numbers: vec![("j".to_owned(), angles)],
                });
            }
            return;
        }
        let mirrors = commuting_mirrors(symmetry);
        let kept =
            |g: &SignedPermutation| rest.iter().all(|i| rest.binary_search(&g.of(*i).0).is_ok());
        if !mirrors.is_empty() && mirrors.iter().all(kept) {
            let is_class = matches!(symmetry.kind, GroupKind::Mirrors(_));
            for part in adapted(&mirrors, &rest) {
                let block = pair.projected(pool, short, &part.basis);
                let class = is_class.then(|| part.class.clone());
                solve_parts(pool, short, &block, class, degree, found);
                if is_class {
                    let (mass, stiffness) = block.dense(pool);
                    found.blocks.push(Block {
                        class: part.class,
                        basis: part.basis.into_iter().map(sorted).collect(),
                        mass,
                        stiffness,
                    });
                }
            }
            return;
        }
    }
    let own = pair.restricted(&rest);
    solve_parts(pool, short, &own, None, degree, found);
}

fn sorted(mut vector: Sparse) -> Sparse {
    vector.sort_unstable();
    vector
}

/// Solves what hangs together in a block, part by part.
fn solve_parts(
    pool: &mut Pool,
    short: &mut Simplifier,
    block: &Pair,
    class: Option<String>,
    degree: Degree,
    found: &mut Found,
) {
    for part in block.components(pool) {
        let own = block.restricted(&part);
        for value in roots(pool, short, &own, degree).into_iter().flatten() {
            let value = opened(pool, short, value);
            if !pool.is_undefined(value) && short.weight(pool, value) <= MOST_SYMBOLS {
                found.add(value, 1, class.clone());
            }
        }
    }
}

/// A product with a sum that has fractions in it, as the sum of the products: `g/l + k/m` and not
/// `(g + k*l/m)/l`.
fn opened(pool: &mut Pool, short: &mut Simplifier, e: ExprId) -> ExprId {
    let (size, core) = pool.split_content(e);
    // A lone term keeps its number as a sum.
    let (size, core) = if let Node::Sum { constant, terms } = pool.node(core)
        && constant.is_zero()
        && let [(term, factor)] = &**terms
    {
        (size.mul(factor), *term)
    } else {
        (size, core)
    };
    let Node::Product(factors) = pool.node(core) else {
        return e;
    };
    let factors = factors.to_vec();
    let sums = factors.iter().enumerate().filter(|(_, (base, exponent))| {
        exponent.is_one() && matches!(pool.node(*base), Node::Sum { .. })
    });
    let sums: Vec<usize> = sums.map(|(at, _)| at).collect();
    let [at] = sums.as_slice() else {
        return e;
    };
    let Node::Sum { constant, terms } = pool.node(factors[*at].0) else {
        return e;
    };
    let divides = |term: &ExprId| {
        let of_factors =
            |factors: &[(ExprId, Number)]| factors.iter().any(|(_, e)| e.is_negative());
        matches!(pool.node(*term), Node::Product(factors) if of_factors(factors))
    };
    if !terms.iter().any(|(term, _)| divides(term)) {
        return e;
    }
    let mut parts: Vec<(ExprId, Number)> = terms.to_vec();
    let constant = constant.clone();
    if !constant.is_zero() {
        parts.push((pool.one(), constant));
    }
    let mut sum = Vec::new();
    for (term, coefficient) in parts {
        let mut product = factors.clone();
        product[*at] = (term, Number::ONE);
        let product = pool.product_of_powers(&product);
        let product = short.simplify(pool, product);
        sum.push((product, coefficient.mul(&size)));
    }
    pool.linear(&sum)
}

/// The frequencies of a chain, ring or net one by one, and as a series.
fn add_lattice(
    pool: &mut Pool,
    short: &mut Simplifier,
    lattice: &Lattice,
    symmetry: Option<&Symmetry>,
    found: &mut Found,
) {
    let names = ["i", "j"];
    let names = names.iter().skip(2 - lattice.dimensions.len().min(2));
    let numbers: Vec<(String, Angles)> = names
        .zip(&lattice.dimensions)
        .map(|(name, dimension)| ((*name).to_owned(), dimension.angles()))
        .collect();
    let mut general = Vec::new();
    for (name, angles) in &numbers {
        let number = pool.variable(name);
        general.push(angles.general(pool, number));
    }
    found.series.push(Series {
        omega_squared: lattice.at(pool, &general),
        numbers: numbers.clone(),
    });
    // Each dimension: the angles with the numbers and multiplicities.
    let choices: Vec<Vec<(i64, ExprId, usize)>> = numbers
        .iter()
        .map(|(_, angles)| angles.distinct(pool))
        .collect();
    let mut all: Vec<(Vec<i64>, Vec<ExprId>, usize)> = vec![(Vec::new(), Vec::new(), 1)];
    for choices in &choices {
        let mut next = Vec::with_capacity(all.len() * choices.len());
        for (js, angles, multiplicity) in &all {
            for (j, angle, own) in choices {
                let mut js = js.clone();
                let mut angles = angles.clone();
                js.push(*j);
                angles.push(*angle);
                next.push((js, angles, multiplicity * own));
            }
        }
        all = next;
    }
    for (js, angles, multiplicity) in all {
        let value = lattice.at(pool, &angles);
        // Sines that came out as roots leave something to be added up.
        let value = if pool.symbols(value).is_empty() || lattice.dimensions.len() > 1 {
            value
        } else {
            short.simplify(pool, value)
        };
        let class = lattice.class(&js, symmetry);
        found.add(value, multiplicity, class);
    }
}

impl Lattice {
    /// The class of a mode by its number: for a ring the wave number; for a chain with equal ends, whose
    /// vectors are sin(i theta), cos((i - 1/2) theta) or sin((i - 1/2) theta), even and odd in turn.
    fn class(&self, js: &[i64], symmetry: Option<&Symmetry>) -> Option<String> {
        use super::lattice::Ends;
        let ([dimension], [j]) = (self.dimensions.as_slice(), js) else {
            return None;
        };
        match (&symmetry?.kind, dimension.ends) {
            (GroupKind::Ring { .. }, Ends::Joined) => usize::try_from(*j).map(wave_number).ok(),
            (GroupKind::Mirrors(mirrors), Ends::Corners(left, right))
                if left == right && mirrors.len() == 1 =>
            {
                let even = (j % 2 == 0) == (left == 1);
                Some(if even { "even" } else { "odd" }.to_owned())
            }
            (GroupKind::Ring { .. } | GroupKind::Mirrors(_) | GroupKind::Other, _) => None,
        }
    }
}

impl Angles {
    /// The angles of a ring of n cells.
    pub(super) fn of_ring(n: i64) -> Self {
        Self {
            step: 1,
            offset: 0,
            divisor: n,
            first: 0,
            last: n - 1,
            ring: Some(n),
        }
    }

    /// The different ones with their multiplicities.
    fn distinct(&self, pool: &mut Pool) -> Vec<(i64, ExprId, usize)> {
        let last = self.ring.map_or(self.last, |n| n / 2);
        let mut all = Vec::new();
        for j in self.first..=last {
            let twice = self.ring.is_some_and(|n| j > 0 && 2 * j < n);
            let angle = self.angle(pool, j);
            all.push((j, angle, if twice { 2 } else { 1 }));
        }
        all
    }

    /// Whether every number but the first (and the middle one of an even ring) stands for two modes.
    #[must_use]
    pub fn is_ring(&self) -> bool {
        self.ring.is_some()
    }
}

impl Frequency {
    /// The multiplicity as a number.
    #[must_use]
    pub fn count(&self) -> Number {
        Number::from(i64::try_from(self.multiplicity).unwrap_or(i64::MAX))
    }
}
