//! Closed forms of M and K, part by part: lattices, waves on a ring, blocks of classes, small parts.

use std::collections::{BTreeMap, BTreeSet};

use super::blocks::{adapted, commuting_mirrors, is_free, waves, whole_waves};
use super::check::Checker;
use super::frequencies::{Block, Case, Frequency, Series};
use super::lattice::{Angles, Dimension, Ends, Lattice, lattice};
use super::pair::{Pair, Sparse};
use super::roots::{Request, Roots, of_factor, roots};
use super::shapes::{Shape, one_fraction, shapes};
use super::simplify::{A_STOREY, Algebra, bases_with, split};
use crate::expr::{ExprId, Node};
use crate::number::Number;
use crate::symmetry::{GroupKind, SignedPermutation, Symmetry, wave_number};

/// Closed forms of more symbols than this are no help to anybody.
const MOST_SYMBOLS: u64 = 160;

/// A block of which not all frequencies are known.
#[derive(Clone)]
struct Unsolved {
    block: Pair,
    /// The squares of those that are.
    known: Vec<ExprId>,
    class: Option<String>,
}

/// What is found on the way, before it is checked.
#[derive(Default)]
pub(super) struct Found {
    /// By omega^2.
    pub(super) frequencies: BTreeMap<ExprId, Frequency>,
    /// Series, blocks, cubics and quartics, and what is solved on request only.
    pub(super) case: Case,
    /// The modes of small parts.
    pub(super) shapes: Vec<Shape>,
    /// Chains, rings and nets, with the coordinates of the model.
    pub(super) lattices: Vec<Lattice>,
    /// Blocks of which not all frequencies are known.
    unsolved: Vec<Unsolved>,
}

impl Found {
    fn add(&mut self, omega_squared: ExprId, multiplicity: usize, symmetry: Option<String>) {
        let new = Frequency::new(omega_squared, multiplicity, symmetry);
        self.frequencies.entry(omega_squared).and_modify(|own| own.join(&new)).or_insert(new);
    }
}

/// The squares of frequencies of a block of which all but two at most are `known`, each as often as it occurs: by tr M⁻¹K and
/// tr (M⁻¹K)². `None` where M is not diagonal, or more are left.
fn left_over(pool: &mut Algebra<'_>, block: &Pair, known: &[(ExprId, usize)], request: Request<'_>) -> Option<Roots> {
    let n = block.len();
    let left = n.checked_sub(known.iter().map(|(_, times)| times).sum())?;
    let places: Vec<_> = (0..n).flat_map(|i| block.columns(i).into_iter().map(move |j| (i, j))).collect();
    if known.is_empty()
        || !(1..=2).contains(&left)
        || places.iter().any(|(i, j)| i != j && !block.at(pool, *i, *j).0.is_zero())
    {
        return None;
    }
    let mut traces = [Vec::new(), Vec::new()];
    for (i, j) in places {
        let (_, stiffness) = block.at(pool, i, j);
        let [mi, mj] = [i, j].map(|i| (block.at(pool, i, i).0, Number::MINUS_ONE));
        if i == j {
            traces[0].push(pool.product_of_powers(&[(stiffness, Number::ONE), mi.clone()]));
        }
        traces[1].push(pool.product_of_powers(&[(stiffness, Number::from(2)), mi, mj]));
    }
    let mut sums = traces.map(|parts| pool.short(|pool| pool.sum(&parts)));
    for (power, sum) in (1..).zip(&mut sums) {
        let parts = known.iter().map(|(z, times)| (pool.powi(*z, power), Number::from(-(*times as i64))));
        let parts: Vec<_> = std::iter::once((*sum, Number::ONE)).chain(parts.collect::<Vec<_>>()).collect();
        *sum = pool.short(|pool| pool.linear(&parts));
    }
    if left == 1 {
        return Some(Roots::of(vec![sums[0]]));
    }
    let square = pool.square(sums[0]);
    let product = pool.linear(&[(square, Number::half()), (sums[1], Number::half().neg())]);
    let coefficients = [pool.simplify(product), pool.neg(sums[0]), pool.one()];
    Some(of_factor(pool, request, &coefficients))
}

/// The search for closed forms.
pub(super) struct Search<'a> {
    pub(super) request: Request<'a>,
    pub(super) found: &'a mut Found,
}

impl Search<'_> {
    /// Looks for closed forms of all parts. Classes have a name where the symmetry is one of the energies.
    pub(super) fn closed_forms(&mut self, pool: &mut Algebra<'_>, pair: &Pair, by: (Option<&Symmetry>, bool)) {
        let (symmetry, named) = by;
        let parts = pair.components(pool);
        let mut rest: Vec<usize> = Vec::new();
        for part in &parts {
            let own = pair.restricted(part);
            if is_free(&own) {
                self.found.add(pool.zero(), part.len(), None);
                self.found.shapes.extend(self.small_part(pool, &own, part));
            } else if let Some(mut lattice) = lattice(pool, &own) {
                let symmetry = symmetry.filter(|_| named && parts.len() == 1);
                self.add_lattice(pool, &lattice, symmetry);
                lattice.order = lattice.order.iter().map(|i| part[*i]).collect();
                self.found.lattices.push(lattice);
            } else {
                rest.extend(part);
            }
        }
        if rest.is_empty() {
            return;
        }
        rest.sort_unstable();
        if let Some(symmetry) = symmetry {
            if let Some(waves) = waves(pool, pair, symmetry, &rest)
                && let GroupKind::Ring { length, .. } = symmetry.kind
            {
                let angles = Dimension { ends: Ends::Joined, size: length }.angles();
                for (j, angle, multiplicity) in angles.distinct(pool) {
                    for value in waves.at(pool, angle) {
                        let value = pool.simplify(value);
                        let class = usize::try_from(j).map(wave_number).ok();
                        self.found.add(value, multiplicity, class.filter(|_| named));
                    }
                }
                let letter = self.request.model.unused_name(&["j", "s", "b"]);
                let number = pool.variable(&letter);
                let angle = angles.general(pool, number);
                let branches = waves.general(pool, angle);
                // A formula that nobody can read is worse than the frequencies one by one.
                if branches.iter().all(|e| pool.weight(*e) <= MOST_SYMBOLS) {
                    let branches = branches.into_iter();
                    self.found.case.series.extend(
                        branches.map(|omega_squared| Series { omega_squared, numbers: vec![(letter.clone(), angles)] }),
                    );
                }
                return;
            }
            let mirrors = commuting_mirrors(symmetry);
            let kept = |g: &SignedPermutation| rest.iter().all(|i| rest.binary_search(&g.of(*i).0).is_ok());
            if !mirrors.is_empty() && mirrors.iter().all(kept) {
                let is_class = named && matches!(symmetry.kind, GroupKind::Mirrors(_));
                for part in adapted(&mirrors, &rest) {
                    let block = pair.projected(pool, &part.basis);
                    let class = is_class.then(|| symmetry.class_under_mirrors(&part.odd));
                    self.solve_parts(pool, &block, &part.basis, class.clone());
                    if let Some(class) = class {
                        let (mass, stiffness) = block.dense(pool);
                        self.found.case.blocks.push(Block { class, basis: part.basis, mass, stiffness });
                    }
                }
                return;
            }
        }
        let own = pair.restricted(&rest);
        self.solve_parts(pool, &own, &units(&rest), None);
    }

    /// Looks for closed forms of parts that a turn takes to themselves.
    pub(super) fn closed_forms_of_rings(&mut self, pool: &mut Algebra<'_>, pair: &Pair) {
        for part in pair.components(pool) {
            let own = pair.restricted(&part);
            let all: Vec<usize> = (0..part.len()).collect();
            match Symmetry::find(&own.pattern(pool)).map(|own| own.kind) {
                Some(GroupKind::Ring { turn, length }) => {
                    for (basis, doubled) in whole_waves(&turn, length, &all) {
                        let block = own.projected(pool, &basis);
                        let parts = block.components(pool);
                        let exchanged = |part: &[usize]| -> Vec<usize> {
                            let half = basis.len() / 2;
                            let others: BTreeSet<usize> = part.iter().map(|i| (i + half) % basis.len()).collect();
                            others.into_iter().collect()
                        };
                        for part in &parts {
                            let other = exchanged(part);
                            let twice = doubled && other != *part && parts.contains(&other);
                            if !twice || *part < other {
                                self.solve(pool, &block.restricted(part), (None, if twice { 2 } else { 1 }));
                            }
                        }
                    }
                }
                Some(GroupKind::Mirrors(_) | GroupKind::Other) | None => {
                    self.solve(pool, &own, (None, 1));
                }
            }
        }
    }

    /// The modes of a part of one or two coordinates whose frequencies are known otherwise.
    fn small_part(&self, pool: &mut Algebra<'_>, own: &Pair, part: &[usize]) -> Vec<Shape> {
        if part.len() > 2 {
            return Vec::new();
        }
        let values = roots(pool, own, self.request).zeros;
        shapes(pool, own, &values, &units(part))
    }

    /// Solves what hangs together in a block, part by part.
    fn solve_parts(&mut self, pool: &mut Algebra<'_>, block: &Pair, basis: &[Sparse], class: Option<String>) {
        for part in block.components(pool) {
            let own = block.restricted(&part);
            let values = self.solve(pool, &own, (class.as_ref(), 1));
            let basis: Vec<Sparse> = part.iter().map(|i| basis[*i].clone()).collect();
            let shapes = shapes(pool, &own, &values, &basis).into_iter();
            self.found.shapes.extend(shapes.map(|own| Shape { symmetry: class.clone(), ..own }));
        }
    }

    /// The frequencies of a part that is there so many times, each as often as it is one of the part.
    fn solve(&mut self, pool: &mut Algebra<'_>, own: &Pair, (class, times): (Option<&String>, usize)) -> Vec<ExprId> {
        let before = self.found.case.solved.len();
        let solution = roots(pool, own, Request { before, ..self.request });
        let values = self.take(pool, solution, (class, times));
        if values.len() < own.len() {
            let unsolved = Unsolved { block: own.clone(), known: values.clone(), class: class.cloned() };
            self.found.unsolved.extend(std::iter::repeat_n(unsolved, times));
        }
        values
    }

    /// Takes the zeros of a part in that can be read.
    fn take(
        &mut self,
        pool: &mut Algebra<'_>,
        solution: Roots,
        (class, times): (Option<&String>, usize),
    ) -> Vec<ExprId> {
        self.found.case.on_request = self.found.case.on_request.max(solution.unsolved);
        let mut values = Vec::new();
        for value in solution.zeros {
            let is_solved = solution.solved.iter().any(|solved| solved.frequencies.contains(&value));
            let value = if is_solved { value } else { readable(pool, value) };
            if is_solved || !pool.is_undefined(value) && pool.weight(value) <= MOST_SYMBOLS {
                self.found.add(value, times, class.cloned());
                values.push(value);
            }
        }
        for solved in solution.solved {
            if self.found.case.solved.iter().all(|other| other.frequencies != solved.frequencies) {
                self.found.case.solved.push(solved);
            }
        }
        values
    }

    /// Counts frequencies of other blocks in those that are not solved, too, and solves these for what they leave.
    pub(super) fn count_copies(&mut self, pool: &mut Algebra<'_>, checker: &Checker<'_>) {
        let known: Vec<ExprId> = self.found.frequencies.keys().copied().collect();
        for Unsolved { block, known: own, class } in std::mem::take(&mut self.found.unsolved) {
            let missed = checker.missed(pool, &block, &own, &known).unwrap_or_default();
            let copies = known.iter().copied().zip(missed).filter(|(_, missed)| *missed > 0);
            let mut all: Vec<(ExprId, usize)> = copies.collect();
            all.iter().for_each(|(z, times)| self.found.add(*z, *times, class.clone()));
            all.extend(own.into_iter().map(|z| (z, 1)));
            let before = self.found.case.solved.len();
            if let Some(solution) = left_over(pool, &block, &all, Request { before, ..self.request }) {
                self.take(pool, solution, (class.as_ref(), 1));
            }
        }
    }

    /// The frequencies of a chain, ring or net one by one, and as a series.
    fn add_lattice(&mut self, pool: &mut Algebra<'_>, lattice: &Lattice, symmetry: Option<&Symmetry>) {
        let names = [["i", "h", "a"], ["j", "s", "b"]].iter().skip(2 - lattice.dimensions.len().min(2));
        let numbers: Vec<(String, Angles)> = names
            .zip(&lattice.dimensions)
            .map(|(names, dimension)| (self.request.model.unused_name(names), dimension.angles()))
            .collect();
        let mut general = Vec::new();
        for (name, angles) in &numbers {
            let number = pool.variable(name);
            general.push(angles.general(pool, number));
        }
        let omega_squared = lattice.at(pool, lattice.omega_squared, &general);
        self.found.case.series.push(Series { omega_squared, numbers: numbers.clone() });
        // Numbers, angles and multiplicities of all dimensions so far.
        let mut all: Vec<(Vec<i64>, Vec<ExprId>, usize)> = vec![(Vec::new(), Vec::new(), 1)];
        for (_, angles) in &numbers {
            let own = angles.distinct(pool);
            let longer = all.iter().flat_map(|(js, angles, times)| {
                own.iter().map(move |(j, angle, more)| {
                    ([js.as_slice(), &[*j]].concat(), [angles.as_slice(), &[*angle]].concat(), times * more)
                })
            });
            all = longer.collect();
        }
        for (js, angles, multiplicity) in all {
            let value = lattice.at(pool, lattice.omega_squared, &angles);
            // Sines that came out as roots leave something to be added up.
            let value = if pool.symbols(value).is_empty() || lattice.dimensions.len() > 1 {
                value
            } else {
                pool.simplify(value)
            };
            let class = lattice.class(&js, symmetry);
            self.found.add(value, multiplicity, class);
        }
    }
}

/// The vectors that move one coordinate each.
fn units(coordinates: &[usize]) -> Vec<Sparse> {
    coordinates.iter().map(|i| vec![(*i, 1)]).collect()
}

/// The polished form; (a ∓ √b)/c where that piles up fractions about a root.
fn readable(pool: &mut Algebra<'_>, e: ExprId) -> ExprId {
    let polished = pool.polished(e);
    let opened = opened(pool, polished);
    let has_roots = !bases_with(pool, &[opened], |_, exponent| !exponent.is_integer()).is_empty();
    if !has_roots || pool.piled_up(opened) == 0 {
        return opened;
    }
    let flat = one_fraction(pool, opened);
    let best = [opened, flat, e].into_iter().min_by_key(|e| pool.cost(&[*e]) + A_STOREY * pool.piled_up(*e));
    best.unwrap_or(opened)
}

/// A product with a sum that has fractions in it, as the sum of the products: `g/l + k/m` and not
/// `(g + k*l/m)/l`.
fn opened(pool: &mut Algebra<'_>, e: ExprId) -> ExprId {
    let (size, core) = pool.split_content(e);
    // A lone term keeps its number as a sum.
    let (factor, core) = split(pool, core);
    let size = size.mul(&factor);
    let Node::Product(factors) = pool.node(core) else { return e };
    let factors = factors.to_vec();
    let sums = factors.iter().enumerate().filter(|(_, (base, exponent))| exponent.is_one() && pool.is_sum(*base));
    let sums: Vec<usize> = sums.map(|(at, _)| at).collect();
    let [at] = sums.as_slice() else { return e };
    let parts = pool.terms(factors[*at].0);
    let divides = |term: ExprId| pool.factors(term).iter().any(|(_, exponent)| exponent.is_negative());
    if !parts.iter().any(|(term, _)| divides(*term)) {
        return e;
    }
    let mut sum = Vec::new();
    for (term, coefficient) in parts {
        let mut product = factors.clone();
        product[*at] = (term, Number::ONE);
        let product = pool.product_of_powers(&product);
        sum.push((pool.simplify(product), coefficient.mul(&size)));
    }
    let sum = pool.linear(&sum);
    // k (1/m + 1/M) has no bar of its own.
    let is_plain = pool.fractions_in_sums(&[factors[*at].0]) == 1;
    let is_bare = is_plain && factors.iter().all(|(_, exponent)| !exponent.is_negative());
    if is_bare && pool.cost(&[e]) < pool.cost(&[sum]) { e } else { sum }
}

impl Lattice {
    /// The class of a mode by its number: for a ring the wave number; for a chain with equal ends, whose
    /// vectors are sin(i theta), cos((i - 1/2) theta) or sin((i - 1/2) theta), even and odd in turn.
    fn class(&self, js: &[i64], symmetry: Option<&Symmetry>) -> Option<String> {
        let ([dimension], [j]) = (self.dimensions.as_slice(), js) else { return None };
        match (&symmetry?.kind, dimension.ends) {
            (GroupKind::Ring { .. }, Ends::Joined) => usize::try_from(*j).map(wave_number).ok(),
            (GroupKind::Mirrors(mirrors), Ends::Corners(left, right)) if left == right && mirrors.len() == 1 => {
                let mut signs = mirrors.iter().flat_map(|g| self.order.iter().map(|i| g.of(*i).1));
                let turned = signs.next()?;
                let even = ((j % 2 == 0) == (left == 1)) != turned;
                let one = signs.all(|sign| sign == turned);
                one.then(|| if even { "even" } else { "odd" }.to_owned())
            }
            (GroupKind::Ring { .. } | GroupKind::Mirrors(_) | GroupKind::Other, _) => None,
        }
    }
}
