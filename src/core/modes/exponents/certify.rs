//! Discs that hold all exponents of a nearly diagonal pencil, with multiplicity.
//!
//! The one fact used: let H(σ) be the pencil of [`super::couplings`], H_t(σ) the same with all entries beside
//! the diagonal times t, and d > 0 with |H_ii(σ)| d_i > Σ_{j≠i} |H_ij(σ)| d_j for all i and all σ on the boundary
//! of a region. Then H_t(σ) is dominant for 0 <= t <= 1 too, hence never singular there (Levy, Desplanques; Horn
//! and Johnson, Matrix Analysis, 6.1), so that the number of zeros of the polynomial det H_t(σ) within the
//! region does not depend on t (the argument principle). For t = 0 it is the number of diagonal entries that
//! vanish within it; for t = 1 the number of exponents, with multiplicity: det H(σ) = det W det(A - σB) det V,
//! and neither factor is 0 since H(σ) is not singular on the boundary.
//!
//! For a group C of columns take d = 1 in C and d = τ outside, where for the rows outside
//!
//! ```text
//!   |H_ii| τ_i >= Σ_{c∈C} |H_ic| + Σ_{j∉C} |H_ij| τ_j ,
//! ```
//!
//! about |H_ic| / gap. Then the rows of C need only, with the residual from the left in H_ci,
//!
//! ```text
//!   |σ - μ_c| |Q_cc| > |H_cc(μ_c)| + Σ_{c'∈C} |H_cc'| + Σ_{i∉C} |H_ci| τ_i ,
//! ```
//!
//! which is quadratic in the residuals for a group of one (Wilkinson's scaling of Gershgorin's discs; Stewart, Sun,
//! Matrix Perturbation Theory, IV.2). The region is the union of the discs of C; rows outside see all of it.
//! A vector a with H(λ) a = 0 for λ in the region has |a_i| <= τ_i max_C |a_c|, since the comparison matrix
//! of the rows outside is a nonsingular M-matrix.

use super::super::certify::slack;
use super::couplings::Couplings;
use crate::groups::connected;
use crate::precision::up;

/// Columns that the bounds do not separate, or a single one.
#[derive(Clone, Debug)]
pub(super) struct Group {
    pub(super) members: Vec<usize>,
    /// By member: the discs together hold as many exponents as there are members; each component of
    /// their union holds as many as it has discs.
    pub(super) discs: Vec<f64>,
    /// By member: an exponent (each member one, with multiplicity) is no further than this from μ.
    pub(super) radii: Vec<f64>,
    /// By member: how many discs, and so exponents, the component of its disc has.
    pub(super) shared: Vec<usize>,
    /// τ by column, 0 for members.
    pub(super) reach: Vec<f64>,
}

/// What is proved about all exponents.
pub(super) struct Certificate {
    pub(super) groups: Vec<Group>,
    /// The group of every column.
    pub(super) of: Vec<usize>,
}

impl Certificate {
    pub(super) fn disc(&self, column: usize) -> Disc {
        let group = &self.groups[self.of[column]];
        match group.members.iter().position(|&c| c == column) {
            Some(at) => Disc { own: group.discs[at], radius: group.radii[at], shared: group.shared[at] },
            None => Disc { own: f64::INFINITY, radius: f64::INFINITY, shared: 0 },
        }
    }
}

/// Where the exponent of a column is.
pub(super) struct Disc {
    /// The radius of the column's own disc.
    pub(super) own: f64,
    /// How far the exponent may be from the column's.
    pub(super) radius: f64,
    /// How many exponents are in the component of the disc.
    pub(super) shared: usize,
}

/// Whether a > b; false where one is not a number.
fn exceeds(a: f64, b: f64) -> bool {
    a > b
}

/// What distances are trusted to.
const NEAR: f64 = 1.0 - 1e-11;
const FAR: f64 = 1.0 + 1e-11;

/// Discs for all columns, those in `together` (of the exponent 0) as one group from the start. `conjugate_of` tells
/// which column is the exact conjugate of another one.
pub(super) fn certify(couplings: &Couplings, together: usize, conjugate_of: &[Option<usize>]) -> Certificate {
    let m = couplings.size;
    let first = (together > 0).then(|| (0..together).collect());
    let mut sets: Vec<Vec<usize>> = first.into_iter().chain((together..m).map(|j| vec![j])).collect();
    let mut of = vec![0; m];
    for (at, set) in sets.iter().enumerate() {
        set.iter().for_each(|&j| of[j] = at);
    }
    let mut done: Vec<Option<Group>> = vec![None; sets.len()];
    loop {
        let open = (0..sets.len()).find(|&at| !sets[at].is_empty() && done[at].is_none());
        let (a, b) = if let Some(at) = open {
            // The conjugate of a column that is done.
            let of_conjugate = |j: usize| done[of[conjugate_of[j]?]].as_ref().filter(|group| group.members.len() == 1);
            let set = &sets[at];
            let group = match of_conjugate(set[0]).filter(|_| set.len() == 1) {
                Some(group) => Ok(mirrored(group, set[0], conjugate_of)),
                None => enclose(couplings, set.clone()),
            };
            match group {
                Ok(group) => {
                    done[at] = Some(group);
                    continue;
                }
                Err(culprit) => (at, of[culprit]),
            }
        } else {
            // Regions of different groups must not meet, lest an exponent be counted twice.
            let mut disc = vec![0.0; m];
            for group in done.iter().flatten() {
                group.members.iter().zip(&group.discs).for_each(|(&c, &r)| disc[c] = r);
            }
            let apart = |i: usize, j: usize| exceeds(couplings.distance.get(i, j) * NEAR, up(disc[i] + disc[j]));
            let met = |j: usize| (0..j).find(|&i| of[i] != of[j] && !apart(i, j)).map(|i| (of[i], of[j]));
            match (0..m).find_map(met) {
                Some(pair) => pair,
                None => break,
            }
        };
        let moved = std::mem::take(&mut sets[b]);
        moved.iter().for_each(|&j| of[j] = a);
        sets[a].extend(moved);
        sets[a].sort_unstable();
        (done[a], done[b]) = (None, None);
    }
    let groups: Vec<Group> = done.into_iter().flatten().collect();
    for (at, group) in groups.iter().enumerate() {
        group.members.iter().for_each(|&j| of[j] = at);
    }
    Certificate { groups, of }
}

fn mirrored(group: &Group, column: usize, conjugate_of: &[Option<usize>]) -> Group {
    let m = group.reach.len();
    // Who is whose conjugate, either way.
    let mut partner: Vec<usize> = (0..m).collect();
    for (j, i) in conjugate_of.iter().enumerate() {
        if let Some(i) = *i {
            partner[j] = i;
            partner[i] = j;
        }
    }
    Group { members: vec![column], reach: (0..m).map(|j| group.reach[partner[j]]).collect(), ..group.clone() }
}

/// The discs of a group, or the column that it can't be separated from.
fn enclose(couplings: &Couplings, members: Vec<usize>) -> Result<Group, usize> {
    let Couplings { size, right, left_t, q, q_t, defect, least, distance, .. } = couplings;
    let m = *size;
    let factor = 1.0 + slack(4 * m);
    let outside: Vec<usize> = (0..m).filter(|i| !members.contains(i)).collect();
    let pairs = members.iter().flat_map(|&a| members.iter().map(move |&b| (a, b)));
    let width = pairs.map(|(a, b)| distance.get(a, b) * FAR).fold(0.0, f64::max);
    // Distances from the nearest member from below, and from all points that lie between members from above.
    let mut gap = vec![0.0; m];
    let mut far = vec![0.0; m];
    for &i in &outside {
        let all = || members.iter().map(|&c| distance.get(i, c));
        gap[i] = all().fold(f64::INFINITY, |near, d| near.min(d * NEAR));
        far[i] = all().fold(0.0, |most, d| f64::max(most, d * FAR));
    }
    let nearest = || outside.iter().copied().reduce(|a, b| if gap[b] < gap[a] { b } else { a });
    let joined = |culprit: Option<usize>| culprit.map_or_else(|| Ok(hopeless(members.clone(), m)), Err);
    // What the rows come to for columns that are hardly coupled.
    let mut radius: f64 = 0.0;
    for &c in &members {
        let sum = outside.iter().fold(defect[c], |sum, &i| sum + left_t.get(i, c) * right.get(i, c) / gap[i]);
        let sum = members.iter().fold(sum, |sum, &b| sum + (right.get(c, b) + width * q.get(c, b)));
        radius = radius.max(2.0 * sum / least[c]);
    }
    if !radius.is_finite() {
        return joined(nearest());
    }
    let mut base = vec![0.0; m];
    let mut diagonal = vec![0.0; m];
    for _ in 0..12 {
        let reach = up(width + radius);
        for &i in &outside {
            diagonal[i] = ((gap[i] - radius) * NEAR * least[i] - defect[i]) * NEAR;
            if !exceeds(diagonal[i], 0.0) {
                return Err(i);
            }
            let sum = members.iter().fold(0.0, |sum, &c| sum + (right.get(i, c) + reach * q.get(i, c)));
            base[i] = sum * factor;
        }
        let rows = Rows { outside: &outside, base: &base, diagonal: &diagonal };
        let Some(tau) = rows.sufficient(couplings, &|j| far[j] + reach) else {
            // The row that needs the most is the one to blame.
            let needs = |i: usize| base[i] / diagonal[i];
            return joined(outside.iter().copied().max_by(|&a, &b| needs(a).total_cmp(&needs(b))));
        };
        let mut discs = Vec::with_capacity(members.len());
        let mut needed: f64 = 0.0;
        for &c in &members {
            let (h, g) = (left_t.column(c), q_t.column(c));
            let sum = outside.iter().fold(defect[c], |sum, &i| sum + (h[i] + reach * g[i]) * tau[i]);
            // Entry (c, c) of both matrices is 0.
            let sum = members.iter().fold(sum, |sum, &b| sum + (right.get(c, b) + reach * q.get(c, b)));
            let r = up(sum * factor / least[c] * FAR);
            discs.push(r);
            needed = needed.max(r);
        }
        // A maximum passes over what is not a number.
        if discs.iter().any(|r| !r.is_finite()) {
            break;
        }
        if needed <= radius {
            let (radii, shared) = spread(couplings, &members, &discs);
            return Ok(Group { members, discs, radii, shared, reach: tau });
        }
        radius = 2.0 * needed;
    }
    joined(nearest())
}

/// Rows outside of a group: what the members contribute to each, and a lower bound of its diagonal entry.
struct Rows<'a> {
    outside: &'a [usize],
    base: &'a [f64],
    diagonal: &'a [f64],
}

impl Rows<'_> {
    /// τ from below, by the iteration of Jacobi; then a little more, until one step shows it sufficient. 0 inside of the group.
    fn sufficient(&self, couplings: &Couplings, far: &dyn Fn(usize) -> f64) -> Option<Vec<f64>> {
        let factor = 1.0 + slack(4 * couplings.size);
        let mut tau = vec![0.0; couplings.size];
        let mut next = vec![0.0; couplings.size];
        for &i in self.outside {
            tau[i] = self.base[i] / self.diagonal[i] + 1e-280;
        }
        for round in 0..10 {
            next.fill(0.0);
            for &j in self.outside {
                let t = tau[j];
                let s = far(j) * t;
                let (h, g) = (couplings.right.column(j), couplings.q.column(j));
                for ((next, h), g) in next.iter_mut().zip(h).zip(g) {
                    *next += h * t + g * s;
                }
            }
            let mut shown = round > 0;
            for &i in self.outside {
                // Entry (i, i) of both matrices is 0.
                next[i] = up((self.base[i] + next[i]) * factor / self.diagonal[i]);
                shown &= next[i] <= tau[i];
            }
            if shown {
                tau.fill(0.0);
                self.outside.iter().for_each(|&i| tau[i] = next[i]);
                return Some(tau);
            }
            for &i in self.outside {
                tau[i] = 1.01 * next[i].max(tau[i] * 0.5) + 1e-280;
            }
            if tau.iter().any(|t| !exceeds(1e100, *t)) {
                break;
            }
        }
        None
    }
}

fn hopeless(members: Vec<usize>, size: usize) -> Group {
    let k = members.len();
    Group {
        members,
        discs: vec![f64::INFINITY; k],
        radii: vec![f64::INFINITY; k],
        shared: vec![k; k],
        reach: vec![f64::INFINITY; size],
    }
}

/// How far an exponent may be from each member: to the far end of the component of its disc; and how many
/// discs the component has.
fn spread(couplings: &Couplings, members: &[usize], discs: &[f64]) -> (Vec<f64>, Vec<usize>) {
    let distance = |a: usize, b: usize| couplings.distance.get(members[a], members[b]);
    let meet = |a: usize, b: usize| !exceeds(distance(a, b) * NEAR, up(discs[a] + discs[b]));
    let far_end = |a: usize, b: usize| up(distance(a, b) * FAR + discs[b]);
    let (mut radii, mut shared) = (vec![0.0; members.len()], vec![0; members.len()]);
    for component in connected(members.len(), meet) {
        for &a in &component {
            radii[a] = component.iter().map(|&b| far_end(a, b)).fold(0.0, f64::max);
            shared[a] = component.len();
        }
    }
    (radii, shared)
}
