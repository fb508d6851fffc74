//! Symmetry classes and closed forms of the frequencies.
//!
//! M and K are examined twice: as they stand, and with parameters of a kind that have equal values taken
//! as one. Symmetries of M and K take them apart; those of the energies among them give classes their names. What hangs together is a part; chains, rings and nets are recognised (`lattice`), the other
//! parts are taken apart by symmetry (`blocks`), and blocks are solved (`roots`). Every closed form
//! is compared with certified numbers before it is given out (`check`).

use super::Linear;
use super::blocks::around_an_axis;
use super::check::{Checker, Signs};
use super::cubic::Solved;
use super::forms::{Found, Search};
use super::lattice::Angles;
use super::normal::{NormalCoordinates, normal_coordinates};
use super::pair::Pair;
use super::roots::Request;
use super::simplify::Algebra;
use super::ties::Ties;
use super::waves::{NormalWaves, normal_waves};
use crate::expr::{ExprId, Pool};
use crate::linearize::Invariance;
use crate::model::{Constant, Model, Parameter};
use crate::order::Gather;
use crate::precision::Ball;
use crate::symmetry::{GroupKind, SignedPermutation, Symmetry};

/// Larger models get no closed forms: they could not be checked in reasonable time.
const MOST_COORDINATES: usize = 1500;

/// What the symmetry of a model tells about its frequencies.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Frequencies {
    /// With all parameters different.
    pub general: Case,
    /// With parameters equal as their values are, where that tells more.
    pub tied: Option<Case>,
    /// The point group of bodies whose energies turn freely, at the values of the parameters; the classes are its then.
    pub point_group: Option<String>,
    /// Whether parameters of M and K have equal values, without which the group may be a smaller one.
    pub group_of_values: bool,
    /// A symmetry that the model would have if parameters were equal that aren't.
    pub would_be: Option<Exchange>,
    /// What is taken to be positive, or where the second is true negative, as it is at the values.
    pub signs: Vec<(ExprId, bool)>,
    /// What has been done to the frequencies since.
    pub approximations: Vec<Approximation>,
}

impl Frequencies {
    /// The case whose closed forms stand for the model: without equalities of parameters where it knows all
    /// frequencies, else the one that knows more of them.
    #[must_use]
    pub fn best(&self) -> &Case {
        match &self.tied {
            Some(tied) if tied.known() > self.general.known() => tied,
            Some(_) | None => &self.general,
        }
    }
}

impl Case {
    /// The normal coordinates, where the modes are known too.
    fn add_normal(&mut self, pool: &mut Algebra<'_>, checker: &Checker<'_>, pair: &Pair, found: Found) {
        self.normal = normal_coordinates(pool, checker, pair, self, found.shapes);
        self.waves = normal_waves(pool, checker, pair, self, &found.lattices).unwrap_or_default();
    }

    /// How many frequencies have a closed form, each as often as it occurs.
    pub(crate) fn known(&self) -> usize {
        self.frequencies.iter().map(|f| f.multiplicity).sum()
    }
}

/// What has been done to closed forms.
#[derive(Clone, Debug)]
pub enum Approximation {
    /// A parameter went to a value.
    Limit {
        /// The parameter.
        name: String,
        /// The value, in SI.
        value: Constant,
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
#[derive(Clone, Debug, Default)]
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
    /// Those of blocks of three and four as a page has them.
    pub solved: Vec<Solved>,
    /// The highest degree, up to 4, of an equation for frequencies that was not solved because nobody asked for it.
    pub on_request: Option<usize>,
    /// Whether these are all frequencies.
    pub complete: bool,
    /// The normal coordinates, where all modes have a closed form too, checked as well.
    pub normal: Option<NormalCoordinates>,
    /// Those of a model that is a chain, ring or net, or several, as sums of sines; else none.
    pub waves: Vec<NormalWaves>,
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
    /// The same at the values of the parameters, of which some may only happen to be equal.
    pub symmetry_at_values: Option<String>,
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

/// Looks for symmetries and closed forms.
pub(super) fn frequencies(checker: &Checker<'_>, pool: &mut Algebra<'_>, linear: &Linear, most: usize) -> Frequencies {
    let model = checker.model;
    let request = Request { most, model, before: 0 };
    let pair = Pair::new(&linear.mass, &linear.stiffness).canonical(pool);
    let used = pool.symbols_of(&pair.values());
    let none = Ties::default();
    let plain = Symmetries::find(checker, pool, linear, &pair, &none);
    let (mut general, found) = case(checker, request, pool, &pair, &plain, &none);
    checker.check(pool, &pair, &mut general);
    if !general.complete
        && let Some(rings) = rings(checker, request, pool, linear, &pair)
        && rings.known() > general.known()
    {
        let Case { symmetry, blocks, .. } = general;
        general = Case { symmetry, blocks, ..rings };
    }
    general.add_normal(pool, checker, &pair, found);
    let point_group = checker.point_group().map(str::to_owned);
    let signs = linear.signs.clone();
    let is_used = |own: &&Parameter| used.binary_search(&own.symbol).is_ok();
    let values: Vec<ExprId> = model.parameters.iter().filter(is_used).filter_map(|own| own.value).collect();
    let group_of_values = values.iter().distinct().len() < values.len();
    let (tied, would_be, approximations) = (None, None, Vec::new());
    let mut result = Frequencies { general, tied, would_be, signs, point_group, group_of_values, approximations };

    let ties = Ties::of_a_kind(model, pool, &used, true);
    let mut tied_order = plain.order();
    if !ties.is_empty() {
        let equal = ties.applied(model, pool, &pair);
        let (equal, more) = checker.signed(pool, &equal);
        result.signs = linear.signs.iter().copied().chain(more).gather::<Signs>().into_iter().collect();
        let equal = equal.canonical(pool);
        let symmetry = Symmetries::find(checker, pool, linear, &equal, &ties);
        tied_order = tied_order.max(symmetry.order());
        if equal.values().iter().any(|value| pool.is_undefined(*value)) {
            return result;
        }
        let (mut found, modes) = case(checker, request, pool, &equal, &symmetry, &ties);
        if let (Some(own), Some(symmetry)) = (&mut found.symmetry, &symmetry.energies) {
            let needed = ties.needed(model, pool, &pair, symmetry);
            let pattern = needed.applied(model, pool, &pair).pattern(pool);
            let holds = symmetry.generators.iter().all(|g| pattern.is_kept_by(g));
            own.ties = if holds { needed } else { ties.clone() }.sets(model);
        }
        checker.check(pool, &equal, &mut found);
        found.add_normal(pool, checker, &equal, modes);
        let more_symmetric = symmetry.order() > plain.order();
        let mut weight = |case: &Case| case.frequencies.iter().map(|f| pool.weight(f.omega_squared)).sum::<u64>();
        let general = &result.general;
        let better = found.known() > general.known() || (found.known() > 0 && weight(&found) < weight(general));
        result.tied = Some(found).filter(|_| more_symmetric || better);
    }

    let all = Ties::of_a_kind(model, pool, &used, false);
    // Equal parameters may move an equilibrium that depends on them.
    let at_zero = !model.guesses.any() && !model.equilibria.any();
    if at_zero && !all.is_empty() && all != ties {
        let equal = all.applied(model, pool, &pair).canonical(pool);
        if equal.values().iter().any(|value| pool.is_undefined(*value)) {
            return result;
        }
        if let Some(symmetry) = Symmetries::find(checker, pool, linear, &equal, &all).energies
            && symmetry.order > tied_order
        {
            let needed = all.needed(model, pool, &pair, &symmetry);
            let pattern = needed.applied(model, pool, &pair).canonical(pool).pattern(pool);
            if symmetry.generators.iter().all(|g| pattern.is_kept_by(g)) {
                let Symmetry { generators, kind, .. } = symmetry;
                result.would_be = Some(Exchange { generators, kind, ties: needed.sets(model) });
            }
        }
    }
    result
}

/// The symmetries of M and K, and of the energies.
struct Symmetries {
    matrices: Option<Symmetry>,
    energies: Option<Symmetry>,
}

impl Symmetries {
    /// With some parameters equal.
    fn find(checker: &Checker<'_>, pool: &mut Pool, linear: &Linear, pair: &Pair, ties: &Ties) -> Self {
        let pattern = pair.pattern(pool);
        // The energies are those of all coordinates.
        let whole = pair.len() == checker.model.coordinates.len();
        let may = whole && pair.len() > 1 && Symmetry::may_have_classes(&pattern);
        let known = ties.substitution(checker.model, pool);
        let energies = || {
            let model = Model { pool: pool.clone(), ..checker.model.clone() };
            let mut energies = Invariance::new(model, known, linear.equilibrium.clone())?;
            Symmetry::of_energies(&pattern, &mut energies)
        };
        Self { matrices: Symmetry::find(&pattern), energies: may.then(energies).flatten() }
    }

    /// How many elements that of the energies has.
    fn order(&self) -> f64 {
        self.energies.as_ref().map_or(1.0, |found| found.order)
    }

    /// What M and K are taken apart by, and whether that is a symmetry of the energies: where that tells as much.
    fn for_blocks(&self) -> (Option<&Symmetry>, bool) {
        let (Some(matrices), Some(energies)) = (&self.matrices, &self.energies) else {
            let named = self.matrices.is_none();
            let own = if named { &self.energies } else { &self.matrices };
            return (own.as_ref(), named);
        };
        let as_much = match (&matrices.kind, &energies.kind) {
            (GroupKind::Mirrors(all), GroupKind::Mirrors(own)) => own.len() >= all.len(),
            (GroupKind::Ring { length, .. }, GroupKind::Ring { length: own, .. }) => own == length,
            (GroupKind::Mirrors(_) | GroupKind::Ring { .. } | GroupKind::Other, _) => false,
        };
        (Some(if as_much { energies } else { matrices }), as_much)
    }
}

fn case(
    checker: &Checker<'_>,
    request: Request<'_>,
    pool: &mut Algebra<'_>,
    pair: &Pair,
    symmetry: &Symmetries,
    ties: &Ties,
) -> (Case, Found) {
    let (case, found) = searched(checker, request, pool, pair.len(), |search, pool| {
        if pair.len() <= MOST_COORDINATES {
            search.closed_forms(pool, pair, symmetry.for_blocks());
        }
    });
    let symmetry = symmetry.energies.as_ref().map(|symmetry| Exchange {
        generators: symmetry.generators.clone(),
        kind: symmetry.kind.clone(),
        ties: Vec::new(),
    });
    (Case { ties: ties.sets(request.model), symmetry, ..case }, found)
}

/// What a search finds of so many frequencies, copies in other blocks among them.
fn searched(
    checker: &Checker<'_>,
    request: Request<'_>,
    pool: &mut Algebra<'_>,
    count: usize,
    look: impl FnOnce(&mut Search<'_>, &mut Algebra<'_>),
) -> (Case, Found) {
    let mut found = Found::default();
    let mut search = Search { request, found: &mut found };
    look(&mut search, pool);
    search.count_copies(pool, checker);
    let frequencies = std::mem::take(&mut found.frequencies).into_values().collect();
    let mut case = Case { frequencies, ..std::mem::take(&mut found.case) };
    case.complete = case.known() == count;
    (case, found)
}

/// What the point group of bodies around an axis tells in coordinates along the ways to them and across, where mirrors do not tell all.
fn rings(
    checker: &Checker<'_>,
    request: Request<'_>,
    pool: &mut Algebra<'_>,
    linear: &Linear,
    pair: &Pair,
) -> Option<Case> {
    checker.point_group()?;
    let linearized = checker.linearized()?;
    let at: Vec<f64> = linearized.equilibrium().values.iter().map(Ball::mid_f64).collect();
    let columns = around_an_axis(pool, &linearized.axes_of_bodies()?, &linear.equilibrium, &at)?;
    let turned = pair.in_basis(pool, &columns).canonical(pool);
    let (mut case, _) = searched(checker, request, pool, pair.len(), |search, pool| {
        search.closed_forms_of_rings(pool, &turned);
    });
    checker.check(pool, pair, &mut case);
    Some(case)
}

impl Angles {
    /// The different ones with their multiplicities.
    pub(super) fn distinct(&self, pool: &mut Pool) -> Vec<(i64, ExprId, usize)> {
        let last = self.ring.map_or(self.last, |n| n / 2);
        let twice = |j: i64| self.ring.is_some_and(|n| j > 0 && 2 * j < n);
        (self.first..=last).map(|j| (j, self.angle(pool, j), if twice(j) { 2 } else { 1 })).collect()
    }
}

impl Frequency {
    pub(super) fn new(omega_squared: ExprId, multiplicity: usize, symmetry: Option<String>) -> Self {
        Self { omega_squared, multiplicity, symmetry, symmetry_at_values: None }
    }

    /// Takes in another that is the same.
    pub(super) fn join(&mut self, other: &Self) {
        self.multiplicity += other.multiplicity;
        if self.symmetry != other.symmetry {
            self.symmetry = None;
        }
        if self.symmetry_at_values != other.symmetry_at_values {
            self.symmetry_at_values = None;
        }
    }
}
