//! Certified discs as exponents in printing order.

use std::cell::OnceCell;
use std::cmp::Ordering;

use faer::c64;

use super::certify::{Certificate, Disc, Group};
use super::columns::Columns;
use super::complex::{Complex, largest};
use super::couplings::Residuals;
use super::repeated::{cluster_shapes, zero, zero_shapes};
use super::scale::Scaled;
use super::shape::Shapes;
use super::signature::is_definite;
use super::solve::Solution;
use super::{Exponent, Exponents, Kind, Limit, Options, Precise, PrecisionLevel, Stability};
use crate::order::Order;
use crate::precision::{Ball, Big, up};

/// What is proved about the problem as a whole.
#[derive(Clone, Debug)]
pub(super) struct Facts {
    pub(super) gyroscopic: bool,
    /// Exponents are in pairs ±s: D is skew and S symmetric, or D is 0.
    pub(super) paired: bool,
    /// Nothing is damped and S is positive definite: all exponents are imaginary and have as many vectors as
    /// their multiplicity, for the energy xᴴSx + |λ|² xᴴMx bounds all solutions.
    pub(super) definite: bool,
    /// D and S are symmetric, exactly.
    pub(super) symmetric: bool,
    /// A lower bound of the multiplicity of the exponent 0.
    pub(super) least_zeros: usize,
    /// Zero vectors that head a chain as they stand.
    pub(super) zero_heads: Vec<usize>,
}

/// What is known of the exponent of a column.
pub(super) struct Status {
    /// Whether growth, or omega, is exactly 0.
    pub(super) growth_zero: bool,
    pub(super) omega_zero: bool,
    /// Whether digits or a sign are missing.
    pub(super) lacking: bool,
    /// Whether the vector is worse than doubles have it, though its exponent may do.
    pub(super) rough: bool,
    /// About how many bits are missing.
    pub(super) score: f64,
}

/// What is known of all columns.
pub(super) fn status(
    facts: &Facts,
    columns: &Columns,
    measured: &[Residuals],
    certificate: &Certificate,
    options: &Options,
) -> Vec<Status> {
    let m = columns.count();
    // Whether the group of the first column holds the exponent 0 as often as is proved, and nothing else.
    let zeros = columns.together() > 0 && certificate.groups[certificate.of[0]].members.len() == facts.least_zeros;
    // By group, where asked for.
    let definite: Vec<OnceCell<bool>> = vec![OnceCell::new(); certificate.groups.len()];
    let on_axis = |j: usize| {
        let at = certificate.of[j];
        let group = &certificate.groups[at];
        let sign = if facts.gyroscopic { -1.0 } else { 1.0 };
        *definite[at].get_or_init(|| is_definite(columns, measured, group, sign))
    };
    let discs: Vec<Disc> = (0..m).map(|j| certificate.disc(j)).collect();
    let status = |j: usize| {
        let of_zero = columns.together() > 0 && certificate.of[j] == certificate.of[0];
        if of_zero && zeros {
            return Status { growth_zero: true, omega_zero: true, lacking: false, rough: false, score: 0.0 };
        }
        let Disc { own: disc, radius, shared } = discs[j];
        let mu = columns.mu(j);
        let (re, im) = (mu.re.mid.hi, mu.im.mid.hi);
        // An exponent alone in its disc is its own mirror image if the mirrored disc meets no other.
        let alone = |mirrored: Complex| {
            let is_apart = |k: usize| {
                let other = columns.mu(k);
                let apart = other.sub(&mirrored).modulus() * (1.0 - 1e-14);
                // Exponents of more bits are rounded to double-double here.
                let rounding = 1e-30 * (other.modulus() + mirrored.modulus());
                apart > up(disc + discs[k].own + rounding)
            };
            shared == 1 && (0..m).all(|k| k == j || is_apart(k))
        };
        let conjugate = mu.conjugate();
        let across = Complex { re: -conjugate.re, im: -conjugate.im };
        let near = |part: f64| part.abs() <= up(radius);
        let growth_zero = !of_zero
            && (facts.definite
                || facts.paired && near(re) && (alone(across) || facts.gyroscopic && shared > 1 && on_axis(j)));
        let omega_zero = !of_zero
            && !facts.definite
            && near(im)
            && (alone(conjugate) || facts.symmetric && shared > 1 && on_axis(j));
        let (Complex { re: growth, im: omega }, wide) = columns.value(j, radius);
        let size = re.hypot(im);
        let part = |zero: bool, value: &Ball, wide: Option<&Big>| {
            if zero {
                return (true, 0.0);
            }
            let least = if value.mid.hi == 0.0 { 1e-20 * size } else { value.mid.hi.abs() };
            let need = least * 10f64.powi(-(options.digits.min(300) as i32) - 3);
            let missing = (radius / need).log2();
            let bits = if missing.is_nan() { 2000.0 } else { missing.clamp(0.0, 2000.0) };
            let covered = wide.map_or_else(|| options.covers(value, false), |wide| options.covers(wide, false));
            (covered, bits)
        };
        let a = part(growth_zero, &growth, wide.as_ref().map(|w| &w.re));
        let b = part(omega_zero, &omega, wide.as_ref().map(|w| &w.im));
        Status { growth_zero, omega_zero, lacking: of_zero || !(a.0 && b.0), rough: false, score: a.1 + b.1 }
    };
    (0..m).map(status).collect()
}

/// What vectors are off by beside their largest component, at most, before another round is spent on them; and what
/// shapes of a group may be off by.
const ROUGH: f64 = 1e-11;

/// Vectors with an angle between them whose square is less may be one.
const PARALLEL: f64 = 1e-8;

/// Whether two vectors are the same but for a factor, nearly.
fn is_parallel(a: &Residuals, b: &Residuals) -> bool {
    let product: c64 = a.x.iter().zip(&b.x).map(|(x, y)| x.value.conj() * y.value).sum();
    let size = |of: &Residuals| of.x.iter().map(|x| x.value.norm_sqr()).sum::<f64>();
    product.norm_sqr() >= (1.0 - PARALLEL) * size(a) * size(b)
}

/// Marks columns whose vectors are [`Status::rough`], and those that may have a vector less than there are exponents.
pub(super) fn mark_rough(
    statuses: &mut [Status],
    columns: &Columns,
    measured: &[Residuals],
    certificate: &Certificate,
) {
    let largest = |residuals: &Residuals| residuals.x.iter().map(|x| x.value.norm()).fold(0.0, f64::max);
    let largest: Vec<f64> = measured.iter().map(largest).collect();
    // Vectors of several exponents at one place that are next to parallel may be one vector of a Jordan block.
    for group in &certificate.groups {
        let own = group.members.iter().filter(|&&j| j >= columns.together());
        let own: Vec<usize> = own.copied().collect();
        for (at, &j) in own.iter().enumerate() {
            for &i in &own[..at] {
                if is_parallel(&measured[i], &measured[j]) {
                    statuses[i].lacking = true;
                    statuses[j].lacking = true;
                }
            }
        }
    }
    for j in columns.together()..columns.count() {
        let group = &certificate.groups[certificate.of[j]];
        let off: f64 = group.reach.iter().zip(&largest).map(|(a, b)| a * b).sum();
        let missing = (off / (ROUGH * largest[j])).log2();
        if missing > 0.0 {
            statuses[j].rough = true;
            statuses[j].score += missing.min(100.0);
        }
    }
}

/// The entries in printing order.
pub(super) fn spectrum(scaled: &Scaled, solution: &Solution, options: &Options) -> Exponents {
    let mut entries = Vec::new();
    let Solution { columns, certificate, facts, .. } = solution;
    let shapes = Shapes { scaled, solution, wanted: options.vectors };
    // Of the real exponents without dissipation the growing half stands for the pairs.
    let mut real: Vec<usize> = Vec::new();
    for j in columns.together()..columns.count() {
        if columns.conjugate_of[j].is_some() {
            continue;
        }
        let paired = columns.conjugate_of.contains(&Some(j));
        let status = &solution.statuses[j];
        // A pair of columns beside the real axis may stand for two real exponents.
        let copies = if paired && status.omega_zero { 2 } else { 1 };
        for _ in 0..copies {
            if facts.paired && !status.growth_zero && (!paired || status.omega_zero) {
                real.push(j);
            } else {
                entries.push(entry(scaled, solution, j, &shapes, options));
            }
        }
    }
    real.order_by(|&a, &b| columns.mu(b).re.mid.hi.total_cmp(&columns.mu(a).re.mid.hi));
    real.truncate(real.len().div_ceil(2));
    entries.extend(real.into_iter().map(|j| entry(scaled, solution, j, &shapes, options)));
    if options.vectors {
        for group in &certificate.groups {
            orthonormal(scaled, solution, &shapes, group, &mut entries);
        }
    }
    let z = columns.zeros;
    if z > 0 {
        let zeros = if facts.paired { facts.least_zeros / 2 } else { z };
        let basis = options.vectors.then(|| zero_shapes(scaled, solution, zeros));
        let mut basis = basis.flatten().unwrap_or_default().into_iter();
        let shape = |k: usize| basis.next().unwrap_or_else(|| shapes.of(k % z));
        entries.extend((0..zeros).map(shape).map(|shape| zero(shape, None, certificate.of[0] as u32)));
        // Columns of the exponent 0 that are not proved to be of it.
        let left = columns.together().saturating_sub(facts.least_zeros);
        let left = if facts.paired { left / 2 } else { left };
        for k in 0..left {
            let j = columns.together() - 1 - k;
            let mut open = entry(scaled, solution, j, &shapes, options);
            open.kind = Kind::Undecided;
            open.limit = Some(Limit::Unresolved { count: columns.together() });
            entries.push(open);
        }
    }
    // On the axis several exponents are known to be there because their form is definite, and then each has its vector.
    finish(entries, solution.level, options, &|entry| entry.growth.is_zero())
}

/// Puts an orthonormal basis in the place of the shapes of a group of exponents that the bounds do not separate, if they
/// show as many vectors as there are of them.
fn orthonormal(scaled: &Scaled, solution: &Solution, shapes: &Shapes<'_>, group: &Group, entries: &mut [Exponent]) {
    let columns = &solution.columns;
    let Some(&first) = group.members.first() else { return };
    let one_place = group.members.len() > 1
        && group.shared.iter().all(|shared| *shared == group.members.len())
        && group.members.iter().all(|&j| j >= columns.together());
    if !one_place {
        return;
    }
    let mut spanning = Vec::with_capacity(group.members.len());
    for &j in &group.members {
        let conjugate = columns.conjugate_of[j].is_some();
        let paired = columns.conjugate_of.iter().position(|conjugate_of| *conjugate_of == Some(j));
        let paired = conjugate || paired.is_some_and(|other| group.members.contains(&other));
        if paired && !solution.statuses[j].omega_zero {
            return;
        }
        let (vector, bound) = shapes.of(j);
        if !paired {
            spanning.push((vector, bound));
        } else if !conjugate {
            // A pair that stands for two real exponents.
            let part = |of: &dyn Fn(&c64) -> f64| vector.iter().map(|x| c64::new(of(x), 0.0)).collect();
            spanning.push((part(&|x| x.re), bound));
            spanning.push((part(&|x| x.im), bound));
        }
    }
    let Some(basis) = cluster_shapes(scaled, &spanning) else { return };
    let is_fine = |(vector, bound): &(Vec<c64>, f64)| *bound <= ROUGH * largest(vector);
    if !basis.iter().all(is_fine) {
        return;
    }
    let cluster = solution.certificate.of[first] as u32;
    let own = entries.iter_mut().filter(|entry| entry.cluster == cluster);
    for (entry, shape) in own.zip(basis) {
        (entry.vector, entry.vector_error_bound) = shape;
    }
}

fn entry(scaled: &Scaled, solution: &Solution, j: usize, shapes: &Shapes<'_>, options: &Options) -> Exponent {
    let Solution { columns, certificate, statuses, .. } = solution;
    let status = &statuses[j];
    let Disc { radius, shared, .. } = certificate.disc(j);
    let (Complex { re: growth, im: omega }, wide) = columns.value(j, radius);
    let growth = if status.growth_zero { Ball::ZERO } else { growth.scale(scaled.power) };
    let omega = if status.omega_zero { Ball::ZERO } else { omega.scale(scaled.power) };
    let omega = if omega.is_negative() { -omega } else { omega };
    let precise = wide.map(|mu| {
        let part = |zero: bool, x: &Big| {
            if zero { Big::zero(x.bits()) } else { x.scale(scaled.power.into()) }
        };
        let omega = part(status.omega_zero, &mu.im);
        let omega = if omega.is_negative() { -&omega } else { omega };
        Box::new(Precise::complex(omega, part(status.growth_zero, &mu.re)))
    });
    // More than the digits was aimed at; what has these lacks nothing.
    let decided = |x: &Ball, precise: Option<&Big>| precise.map_or_else(|| options.decides(x), |x| options.decides(x));
    let both = || {
        decided(&growth, precise.as_ref().map(|own| &own.growth))
            && decided(&omega, precise.as_ref().map(|own| &own.omega))
    };
    let limit = if !status.lacking {
        None
    } else if shared > 1 {
        Some(Limit::Unresolved { count: shared })
    } else {
        (!both()).then_some(Limit::Open)
    };
    Exponent { precise, limit, ..Exponent::new(growth, omega, shapes.of(j), certificate.of[j] as u32) }
}

/// -exponent² where one part is exactly 0.
pub(super) fn omega_squared(growth: &Ball, omega: &Ball) -> Option<Ball> {
    if growth.is_zero() {
        Some(*omega * *omega)
    } else if omega.is_zero() {
        Some(-(*growth * *growth))
    } else {
        None
    }
}

pub(super) fn kind(growth: &Ball, omega: &Ball) -> Kind {
    if growth.is_positive() {
        Kind::Unstable
    } else if growth.is_negative() && omega.is_zero() {
        Kind::Overdamped
    } else if growth.is_negative() && omega.is_positive() {
        Kind::Damped
    } else if growth.is_zero() && omega.is_positive() {
        Kind::Oscillation
    } else {
        Kind::Undecided
    }
}

/// Unstable ones by falling growth, then zeros, then by rising frequency and falling growth.
fn sort(entries: &mut [Exponent]) {
    let place = |entry: &Exponent| match entry.kind {
        Kind::Unstable => 0,
        Kind::Zero => 1,
        _ => 2,
    };
    let compare = |a: &Ball, b: &Ball| a.mid.hi.total_cmp(&b.mid.hi).then(a.mid.lo.total_cmp(&b.mid.lo));
    let falling = |a: &Exponent, b: &Exponent| compare(&b.growth, &a.growth);
    let rising = |a: &Exponent, b: &Exponent| compare(&a.omega, &b.omega);
    entries.order_by(|a, b| {
        place(a)
            .cmp(&place(b))
            .then_with(|| if place(a) == 0 { falling(a, b).then(rising(a, b)) } else { rising(a, b) })
    });
    // What may be equal is no order: neighbours that may be are put in order for themselves.
    let is_tie =
        |a: &Exponent, b: &Exponent| place(a) > 0 && place(a) == place(b) && (a.omega - b.omega).contains_zero();
    let gap = |a: &Exponent, b: &Exponent| Some(&a.precise.as_ref()?.omega - &b.precise.as_ref()?.omega);
    for tied in entries.chunk_by_mut(is_tie) {
        // More digits tell some of them apart.
        let is_precise = tied.iter().all(|own| own.precise.is_some());
        if is_precise {
            let sign = |gap: Big| gap.is_positive().cmp(&gap.is_negative());
            tied.order_by(|a, b| gap(a, b).map_or(Ordering::Equal, |own| sign(own.center())));
        }
        for tied in tied.chunk_by_mut(|a, b| !is_precise || gap(a, b).is_none_or(|own| own.contains_zero())) {
            tied.order_by(falling);
        }
    }
}

/// The exponents of parts that nothing couples as those of the whole, in its order; their vectors have the
/// length of the whole already.
pub(crate) fn joined(parts: Vec<Exponents>, options: &Options) -> Exponents {
    let mut entries: Vec<Exponent> = Vec::new();
    let (mut stability, mut level) = (Stability::Stable, PrecisionLevel::Doubles);
    let mut secular = Some(false);
    // What one part says of the whole, the graver the later.
    let gravity = |stability: Stability| match stability {
        Stability::Stable => 0,
        Stability::Neutral => 1,
        Stability::Undecided => 2,
        Stability::Unstable => 3,
    };
    for part in parts {
        if gravity(part.stability) > gravity(stability) {
            stability = part.stability;
        }
        level = level.max(part.level);
        secular = match (secular, part.secular) {
            (Some(true), _) | (_, Some(true)) => Some(true),
            (None, _) | (_, None) => None,
            (Some(false), Some(false)) => Some(false),
        };
        let numbers = entries.iter().map(|entry| entry.cluster + 1);
        let next = numbers.max().unwrap_or(0);
        let known = entries.len();
        for mut entry in part.entries {
            entry.cluster += next;
            // Separate problems may have exponents that are equal.
            let near = |other: &&Exponent| {
                (other.omega - entry.omega).contains_zero()
                    && (other.growth - entry.growth).contains_zero()
                    && (other.kind == Kind::Zero) == (entry.kind == Kind::Zero)
            };
            let conjugate_of = entries[..known].iter().find(near).map(|other| other.cluster);
            let own = entry.cluster;
            entries.push(entry);
            if let Some(conjugate_of) = conjugate_of {
                let same = entries.iter_mut().filter(|other| other.cluster == own);
                same.for_each(|other| other.cluster = conjugate_of);
            }
        }
    }
    Exponents { entries: listed(entries, options), stability, secular, level }
}

/// In order, as many as are wanted; clusters are counted in the order of their first members.
fn listed(mut entries: Vec<Exponent>, options: &Options) -> Vec<Exponent> {
    sort(&mut entries);
    let mut numbers: Vec<u32> = Vec::new();
    for entry in &mut entries {
        let at = numbers.iter().position(|&n| n == entry.cluster);
        let at = at.unwrap_or_else(|| {
            numbers.push(entry.cluster);
            numbers.len() - 1
        });
        entry.cluster = at as u32;
    }
    entries.truncate(options.lowest.unwrap_or(usize::MAX));
    entries
}

/// Sorted, numbered and judged; `semisimple` tells of an exponent that is not separated from others whether all of these
/// are known to have their own vectors.
pub(crate) fn finish(
    entries: Vec<Exponent>,
    level: PrecisionLevel,
    options: &Options,
    semisimple: &dyn Fn(&Exponent) -> bool,
) -> Exponents {
    let some = |kind: Kind| entries.iter().any(|entry| entry.kind == kind);
    let on_axis = |entry: &Exponent| matches!(entry.kind, Kind::Oscillation | Kind::Zero);
    let secular = |entry: &Exponent| on_axis(entry) && matches!(entry.limit, Some(Limit::Defective { .. }));
    let may_be_secular = |entry: &Exponent| {
        entry.growth.contains_zero() && matches!(entry.limit, Some(Limit::Unresolved { .. })) && !semisimple(entry)
    };
    let grows = entries.iter().any(secular);
    let may_grow = entries.iter().any(may_be_secular);
    let stability = if some(Kind::Unstable) {
        Stability::Unstable
    } else if entries.iter().any(|entry| {
        let open = entry.growth.contains_zero() && !entry.growth.is_zero();
        open || entry.kind == Kind::Oscillation && may_be_secular(entry)
    }) {
        Stability::Undecided
    } else if some(Kind::Zero) || grows {
        Stability::Neutral
    } else {
        Stability::Stable
    };
    let secular = if grows { Some(true) } else { (!may_grow).then_some(false) };
    Exponents { entries: listed(entries, options), stability, secular, level }
}
