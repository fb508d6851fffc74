//! M and K as sparse rows of expressions, and what becomes of them in another basis.

use std::collections::{BTreeMap, BTreeSet};

use hashbrown::HashMap;

use super::equilibria::angle;
use super::simplify::{Algebra, Monomial, Opening, bases_with, expand};
use crate::expr::{ExprId, ModularPoint, Pool, neg_mod};
use crate::number::Number;
use crate::order::{Gather, Order};
use crate::symmetry::Pattern;

/// A row without its zeros.
type Row = BTreeMap<usize, ExprId>;

/// A vector without its zeros.
pub(super) type Sparse = Vec<(usize, i64)>;

/// Two symmetric matrices.
#[derive(Clone, Debug, Default)]
pub(super) struct Pair {
    pub(super) mass: Vec<Row>,
    pub(super) stiffness: Vec<Row>,
}

fn sparse(rows: &[Vec<ExprId>]) -> Vec<Row> {
    let entries = |row: &Vec<ExprId>| row.iter().copied().enumerate().filter(|(_, value)| !value.is_zero()).gather();
    rows.iter().map(entries).collect()
}

impl Pair {
    pub(super) fn new(mass: &[Vec<ExprId>], stiffness: &[Vec<ExprId>]) -> Self {
        Self { mass: sparse(mass), stiffness: sparse(stiffness) }
    }

    pub(super) fn len(&self) -> usize {
        self.mass.len()
    }

    /// M_ij and K_ij.
    pub(super) fn at(&self, pool: &Pool, i: usize, j: usize) -> (ExprId, ExprId) {
        let of = |rows: &[Row]| rows.get(i).and_then(|row| row.get(&j)).copied().unwrap_or(pool.zero());
        (of(&self.mass), of(&self.stiffness))
    }

    /// The columns in which a row of M or K has an entry.
    pub(super) fn columns(&self, i: usize) -> BTreeSet<usize> {
        self.mass[i].keys().chain(self.stiffness[i].keys()).copied().collect()
    }

    /// The different entries, in ascending order.
    pub(super) fn values(&self) -> Vec<ExprId> {
        let rows = self.mass.iter().chain(&self.stiffness);
        let values: BTreeSet<ExprId> = rows.flat_map(BTreeMap::values).copied().gather();
        values.into_iter().collect()
    }

    /// With the entries that some make of all, each in its shortest form.
    pub(super) fn changed(
        &self,
        pool: &mut Algebra<'_>,
        change: impl FnOnce(&mut Pool, &[ExprId]) -> Vec<ExprId>,
    ) -> Self {
        let values = self.values();
        let images = change(pool, &values);
        self.replaced(pool, &values.into_iter().zip(images).gather())
    }

    /// With each entry replaced, and in its shortest form.
    pub(super) fn replaced(&self, pool: &mut Algebra<'_>, images: &HashMap<ExprId, ExprId>) -> Self {
        let mut image: HashMap<ExprId, ExprId> = HashMap::new();
        for value in self.values() {
            let new = images.get(&value).copied().unwrap_or(value);
            image.insert(value, pool.simplify(new));
        }
        let of = |rows: &[Row]| {
            let replaced = |row: &Row| {
                let entries = row.iter().filter_map(|(j, value)| {
                    let value = image.get(value).copied().unwrap_or(*value);
                    (!value.is_zero()).then_some((*j, value))
                });
                entries.gather()
            };
            rows.iter().map(replaced).collect()
        };
        Self { mass: of(&self.mass), stiffness: of(&self.stiffness) }
    }

    /// With sines and cosines of twice an angle in those of the angle, where both occur in an entry and that is shorter.
    pub(super) fn with_halved_angles(&self, pool: &mut Algebra<'_>) -> Self {
        let images = self.values().into_iter().filter_map(|value| Some((value, halved_angles(pool, value)?)));
        let images: HashMap<ExprId, ExprId> = images.gather();
        if images.is_empty() { self.clone() } else { self.replaced(pool, &images) }
    }

    /// With roots of sums that are multiples of each other as multiples of one of them.
    pub(super) fn with_like_roots(&self, pool: &mut Algebra<'_>) -> Self {
        let images = proportional_radicands(pool, &self.values());
        if images.is_empty() {
            return self.clone();
        }
        self.changed(pool, |pool, values| pool.replaced(values, &images))
    }

    /// With entries that are equal or opposite brought to one form, and without those that vanish.
    ///
    /// Candidates are those that agree at a random point modulo a prime.
    pub(super) fn canonical(&self, pool: &mut Algebra<'_>) -> Self {
        let own = self.with_like_roots(pool);
        let values = own.values();
        let seed = 1;
        let random = |symbol| ModularPoint::random_value(seed, symbol);
        let Some(residues) = pool.evaluate_mod(&values, random, seed) else { return own };
        let mut first: HashMap<u64, ExprId> = HashMap::new();
        let mut images: HashMap<ExprId, ExprId> = HashMap::new();
        for (value, residue) in values.into_iter().zip(residues) {
            if residue == 0 && pool.vanishes(value) {
                images.insert(value, pool.zero());
                continue;
            }
            if let Some(same) = first.get(&residue).copied()
                && pool.agree(value, same)
            {
                images.insert(value, same);
                continue;
            }
            if let Some(opposite) = first.get(&neg_mod(residue)).copied() {
                let sum = pool.add(value, opposite);
                if pool.vanishes(sum) {
                    images.insert(value, pool.neg(opposite));
                    continue;
                }
            }
            first.insert(residue, value);
        }
        if images.is_empty() { own } else { own.replaced(pool, &images) }
    }

    /// Which entries are the same expression, or opposite ones.
    pub(super) fn pattern(&self, pool: &mut Pool) -> Pattern {
        let mut labels: HashMap<(ExprId, ExprId), i64> = HashMap::new();
        let mut count = 0;
        let mut pattern = Pattern::new(self.len());
        let zero = pool.zero();
        for i in 0..self.len() {
            for j in self.columns(i) {
                let (m, k) = self.at(pool, i, j);
                let label = match labels.get(&(m, k)) {
                    Some(label) => *label,
                    None => {
                        count += 1;
                        labels.insert((pool.neg(m), pool.neg(k)), -count);
                        labels.insert((m, k), count);
                        count
                    }
                };
                if i == j {
                    pattern.set_diagonal(i, label.unsigned_abs(), k != zero);
                } else {
                    pattern.push(i, j, label, k != zero);
                }
            }
        }
        pattern
    }

    /// The rows and columns of some coordinates, in this order.
    pub(super) fn restricted(&self, to: &[usize]) -> Self {
        let place: HashMap<usize, usize> = to.iter().enumerate().map(|(at, i)| (*i, at)).collect();
        let of = |rows: &[Row]| {
            let row = |i: &usize| rows[*i].iter().filter_map(|(j, value)| Some((*place.get(j)?, *value))).gather();
            to.iter().map(row).collect()
        };
        Self { mass: of(&self.mass), stiffness: of(&self.stiffness) }
    }

    /// BᵀMB and BᵀKB for columns of B of whole numbers, each entry in its shortest form.
    pub(super) fn projected(&self, pool: &mut Algebra<'_>, basis: &[Sparse]) -> Self {
        let column = |own: &Sparse| own.iter().map(|(i, factor)| (*i, pool.number(Number::from(*factor)))).collect();
        let basis: Vec<Vec<(usize, ExprId)>> = basis.iter().map(column).collect();
        self.in_basis(pool, &basis)
    }

    /// The same for columns of expressions.
    pub(super) fn in_basis(&self, pool: &mut Algebra<'_>, basis: &[Vec<(usize, ExprId)>]) -> Self {
        let mut of = |rows: &[Row]| -> Vec<Row> {
            let mut out = vec![Row::new(); basis.len()];
            for (a, left) in basis.iter().enumerate() {
                // The row leftᵀ times the matrix.
                let mut row: BTreeMap<usize, Vec<ExprId>> = BTreeMap::new();
                for (i, factor) in left {
                    for (j, value) in &rows[*i] {
                        row.entry(*j).or_default().push(pool.mul(*value, *factor));
                    }
                }
                for (b, right) in basis.iter().enumerate().skip(a) {
                    let mut parts: Vec<ExprId> = Vec::new();
                    for (j, factor) in right {
                        parts.extend(row.get(j).into_iter().flatten().map(|value| pool.mul(*value, *factor)));
                    }
                    if parts.is_empty() {
                        continue;
                    }
                    let sum = pool.short(|pool| pool.sum(&parts));
                    if !sum.is_zero() {
                        out[a].insert(b, sum);
                        out[b].insert(a, sum);
                    }
                }
            }
            out
        };
        Self { mass: of(&self.mass), stiffness: of(&self.stiffness) }
    }

    /// Written out, row by row.
    pub(super) fn dense(&self, pool: &Pool) -> (Vec<Vec<ExprId>>, Vec<Vec<ExprId>>) {
        let of = |rows: &[Row]| {
            let row = |row: &Row| {
                let at = |j| row.get(&j).copied().unwrap_or(pool.zero());
                (0..rows.len()).map(at).collect()
            };
            rows.iter().map(row).collect()
        };
        (of(&self.mass), of(&self.stiffness))
    }

    /// The coordinates of each part that hangs together.
    pub(super) fn components(&self, pool: &mut Pool) -> Vec<Vec<usize>> {
        self.pattern(pool).parts()
    }
}

/// Sums below roots that are others times a number once they are multiplied out; the shortest is taken in place of all.
fn proportional_radicands(pool: &mut Algebra<'_>, all: &[ExprId]) -> HashMap<ExprId, ExprId> {
    let sums = bases_with(pool, all, |base, exponent| !exponent.is_integer() && pool.is_sum(base));
    let mut sums: Vec<ExprId> = sums.into_iter().collect();
    sums.order_by_key(|sum| pool.weight(*sum));
    let mut first: HashMap<Vec<(Monomial, Number)>, (ExprId, Number)> = HashMap::new();
    let mut images = HashMap::new();
    for sum in sums {
        let terms = expand(pool, sum, Opening::Powers).unwrap_or_default();
        let size = terms.values().fold(Number::ZERO, |size, own| size.gcd(own));
        let Some(inverse) = size.recip() else { continue };
        let whole = terms.into_iter().map(|(monomial, own)| (monomial, own.mul(&inverse))).collect();
        match first.get(&whole) {
            Some((other, by)) => _ = images.insert(sum, pool.scale(*other, &size.mul(by))),
            None => _ = first.insert(whole, (sum, inverse)),
        }
    }
    images
}

/// An expression with sin(2 x) as 2 sin(x) cos(x) and cos(2 x) as one of its three forms, where functions of x occur too;
/// if that is shorter.
fn halved_angles(pool: &mut Algebra<'_>, e: ExprId) -> Option<ExprId> {
    let angles: Vec<ExprId> = pool.reachable(&[e]).into_iter().filter_map(|id| angle(pool, id)).collect();
    let two = Number::from(2);
    let doubled: Vec<(ExprId, ExprId)> =
        angles.iter().map(|x| (pool.scale(*x, &two), *x)).filter(|(twice, _)| angles.contains(twice)).collect();
    if doubled.is_empty() {
        return None;
    }
    let mut best = (pool.weight(e), None);
    for form in 0..3 {
        let mut images: HashMap<ExprId, ExprId> = HashMap::new();
        for (twice, x) in &doubled {
            let (sine, cosine) = (pool.sin(*x), pool.cos(*x));
            let product = pool.mul(sine, cosine);
            let of_sine = pool.scale(product, &two);
            let (s2, c2, one) = (pool.square(sine), pool.square(cosine), pool.one());
            let of_cosine = match form {
                0 => pool.linear(&[(one, Number::ONE), (s2, Number::from(-2))]),
                1 => pool.linear(&[(c2, Number::from(2)), (one, Number::MINUS_ONE)]),
                _ => pool.sub(c2, s2),
            };
            images.insert(pool.sin(*twice), of_sine);
            images.insert(pool.cos(*twice), of_cosine);
        }
        let image = pool.short(|pool| pool.replaced(&[e], &images)[0]);
        let weight = pool.weight(image);
        if weight < best.0 {
            best = (weight, Some(image));
        }
    }
    best.1
}
