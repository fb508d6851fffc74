//! Certified discs as exponents in printing order.

use std::cell::OnceCell;

use faer::c64;

use super::certify::Certificate;
use super::columns::Columns;
use super::complex::Complex;
use super::couplings::Sheet;
use super::exact::ExactSpectrum;
use super::scale::Scaled;
use super::shape::Shapes;
use super::signature::is_definite;
use super::solve::Solution;
use super::{
    Exponent, ExponentKind, Exponents, Limit, Options, PreciseExponent, Stability, Structure,
};
use crate::precision::{Ball, Big, Rounding, decimal, up};

/// What is proved about the problem as a whole.
#[derive(Clone, Debug)]
pub(super) struct Facts {
    pub(super) gyroscopic: bool,
    /// Nothing is damped and S is positive definite: all exponents are imaginary and have as many vectors as
    /// their multiplicity, for the energy xᴴSx + |λ|² xᴴMx bounds all solutions.
    pub(super) definite: bool,
    /// D and S are symmetric, exactly.
    pub(super) symmetric: bool,
    /// A lower bound of the multiplicity of the exponent 0.
    pub(super) least_zeros: usize,
}

/// What is known of the exponent of a column.
#[derive(Clone, Debug)]
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

/// An exponent with its bound: growth and omega, and both to more digits where balls do not hold them.
#[derive(Clone, Debug)]
pub(super) struct Value {
    pub(super) growth: Ball,
    pub(super) omega: Ball,
    pub(super) wide: Option<(Big, Big)>,
}

impl Value {
    pub(super) fn new(growth: Ball, omega: Ball) -> Self {
        Self {
            growth,
            omega,
            wide: None,
        }
    }

    pub(super) fn wide(growth: Big, omega: Big) -> Self {
        Self {
            growth: growth.to_ball(),
            omega: omega.to_ball(),
            wide: Some((growth, omega)),
        }
    }
}

/// Whether the group of the first column holds the exponent 0 as often as is proved, and nothing else.
pub(super) fn zeros_proved(facts: &Facts, columns: &Columns, certificate: &Certificate) -> bool {
    columns.together() > 0
        && certificate.groups[certificate.of[0]].members.len() == facts.least_zeros
}

/// What is known of all columns.
pub(super) fn status(
    facts: &Facts,
    columns: &Columns,
    sheets: &[Sheet],
    value: &dyn Fn(usize, f64) -> Value,
    certificate: &Certificate,
    options: &Options,
) -> Vec<Status> {
    let m = columns.count();
    let zeros = zeros_proved(facts, columns, certificate);
    // By group, where asked for.
    let definite: Vec<OnceCell<bool>> = vec![OnceCell::new(); certificate.groups.len()];
    let on_axis = |j: usize| {
        let at = certificate.of[j];
        let group = &certificate.groups[at];
        let sign = if facts.gyroscopic { -1.0 } else { 1.0 };
        *definite[at].get_or_init(|| is_definite(columns, sheets, group, sign))
    };
    let discs: Vec<(f64, f64, usize)> = (0..m).map(|j| certificate.disc(j)).collect();
    (0..m)
        .map(|j| {
            let of_zero = columns.together() > 0 && certificate.of[j] == certificate.of[0];
            if of_zero && zeros {
                return Status {
                    growth_zero: true,
                    omega_zero: true,
                    lacking: false,
                    rough: false,
                    score: 0.0,
                };
            }
            let (disc, radius, shared) = discs[j];
            let (re, im) = (columns.mu[j].re.hi, columns.mu[j].im.hi);
            // An exponent alone in its disc is its own mirror image if the mirrored disc meets no other.
            let alone = |mirrored: Complex| {
                shared == 1
                    && (0..m).all(|k| {
                        k == j || {
                            let other = columns.mu[k];
                            let apart = other.sub(mirrored).size() * (1.0 - 1e-14);
                            // Exponents of more bits are rounded to double-double here.
                            let rounding = 1e-30 * (other.size() + mirrored.size());
                            apart > up(disc + discs[k].0 + rounding)
                        }
                    })
            };
            let conj = columns.mu[j].conj();
            let across = Complex {
                re: -conj.re,
                im: -conj.im,
            };
            let near = |part: f64| part.abs() <= up(radius);
            let growth_zero = !of_zero
                && (facts.definite
                    || facts.gyroscopic && near(re) && (alone(across) || shared > 1 && on_axis(j)));
            let omega_zero = !of_zero
                && !facts.definite
                && near(im)
                && (alone(conj) || facts.symmetric && shared > 1 && on_axis(j));
            let Value {
                growth,
                omega,
                wide,
            } = value(j, radius);
            let size = re.hypot(im);
            let part = |zero: bool, value: &Ball, wide: Option<&Big>| {
                if zero {
                    return (true, 0.0);
                }
                let least = if value.mid.hi == 0.0 {
                    1e-20 * size
                } else {
                    value.mid.hi.abs()
                };
                let need = least * 10f64.powi(-(options.digits.min(300) as i32) - 3);
                let missing = (radius / need).log2();
                let bits = if missing.is_nan() {
                    2000.0
                } else {
                    missing.clamp(0.0, 2000.0)
                };
                let covered = match wide {
                    Some(wide) => covers_wide(wide, options.digits),
                    None => covers(value, options.digits),
                };
                (covered, bits)
            };
            let a = part(growth_zero, &growth, wide.as_ref().map(|w| &w.0));
            let b = part(omega_zero, &omega, wide.as_ref().map(|w| &w.1));
            Status {
                growth_zero,
                omega_zero,
                lacking: of_zero || !(a.0 && b.0),
                rough: false,
                score: a.1 + b.1,
            }
        })
        .collect()
}

/// What vectors are off by beside their largest component, at most, before another round is spent on them.
const ROUGH: f64 = 1e-11;

/// Marks columns whose vectors are [`Status::rough`].
pub(super) fn mark_rough(
    statuses: &mut [Status],
    columns: &Columns,
    sheets: &[Sheet],
    certificate: &Certificate,
) {
    let largest: Vec<f64> = sheets
        .iter()
        .map(|sheet| {
            let sizes = sheet.x.iter().map(|x| x.value.re.hypot(x.value.im));
            sizes.fold(0.0, f64::max)
        })
        .collect();
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

/// Whether the number has `digits` digits, correctly rounded.
pub(super) fn covers(x: &Ball, digits: usize) -> bool {
    if x.contains_zero() {
        return false;
    }
    let size = x.mid.hi.abs();
    if x.radius / size > 10f64.powi(-(digits.min(300) as i32) - 3) {
        return false;
    }
    // Near a tie the bound has to be narrower. In doubles, if they can tell: 10^12 has a spacing of 1e-4.
    if digits <= 12 {
        let place = 10f64.powi(digits as i32 - 1 - size.log10().floor() as i32);
        let fraction = (size * place).fract();
        if size.log10().abs() < 200.0 && (fraction - 0.5).abs() > 2e-3 {
            return true;
        }
    }
    decimal(&x.abs(), digits).rounding == Rounding::Correct
}

/// The same for more digits than a ball has.
fn covers_wide(x: &Big, digits: usize) -> bool {
    if x.contains_zero() {
        return false;
    }
    let missing = x.radius().log2() - x.abs_upper().log2();
    missing < -3.33 * (digits as f64 + 3.0) && x.decimal(digits).rounding == Rounding::Correct
}

/// The entries in printing order.
pub(super) fn spectrum(scaled: &Scaled, solution: &Solution, options: &Options) -> Exponents {
    let mut entries = Vec::new();
    let Solution {
        columns,
        certificate,
        facts,
        ..
    } = solution;
    let columns = &columns.base;
    let shapes = Shapes::new(scaled, solution, options.vectors);
    // Of the real exponents without dissipation the growing half stands for the pairs.
    let mut real: Vec<usize> = Vec::new();
    for j in columns.together()..columns.count() {
        if columns.twin[j].is_some() {
            continue;
        }
        let paired = columns.twin.contains(&Some(j));
        let status = &solution.statuses[j];
        // A pair of columns beside the real axis may stand for two real exponents.
        let copies = if paired && status.omega_zero { 2 } else { 1 };
        for _ in 0..copies {
            if facts.gyroscopic && !status.growth_zero && (!paired || status.omega_zero) {
                real.push(j);
            } else {
                entries.push(entry(scaled, solution, j, &shapes, options));
            }
        }
    }
    real.sort_by(|&a, &b| columns.mu[b].re.hi.total_cmp(&columns.mu[a].re.hi));
    real.truncate(real.len().div_ceil(2));
    for j in real {
        entries.push(entry(scaled, solution, j, &shapes, options));
    }
    let z = columns.zeros;
    if z > 0 {
        let gyroscopic = scaled.structure == Structure::Gyroscopic;
        let zeros = if gyroscopic { facts.least_zeros / 2 } else { z };
        for k in 0..zeros {
            let (vector, vector_error_bound) = shapes.of(k % z);
            entries.push(zero(vector, vector_error_bound, certificate.of[0] as u32));
        }
        // Columns of the exponent 0 that are not proved to be of it.
        let left = columns.together().saturating_sub(facts.least_zeros);
        let left = if gyroscopic { left / 2 } else { left };
        for k in 0..left {
            let mut open = entry(
                scaled,
                solution,
                columns.together() - 1 - k,
                &shapes,
                options,
            );
            open.kind = ExponentKind::Undecided;
            entries.push(open);
        }
    }
    finish(entries, solution, options)
}

fn entry(
    scaled: &Scaled,
    solution: &Solution,
    j: usize,
    shapes: &Shapes<'_>,
    options: &Options,
) -> Exponent {
    let Solution {
        columns,
        certificate,
        statuses,
        ..
    } = solution;
    let status = &statuses[j];
    let (_, radius, shared) = certificate.disc(j);
    let Value {
        growth,
        omega,
        wide,
    } = columns.value(j, radius);
    let growth = if status.growth_zero {
        Ball::ZERO
    } else {
        growth.scale(scaled.power)
    };
    let mut omega = if status.omega_zero {
        Ball::ZERO
    } else {
        omega.scale(scaled.power)
    };
    if omega.is_negative() {
        omega = -omega;
    }
    let (vector, vector_error_bound) = shapes.of(j);
    let precise = wide.map(|(growth, omega)| {
        let part = |zero: bool, x: &Big| {
            if zero {
                Big::zero(x.bits())
            } else {
                x.scale(scaled.power.into())
            }
        };
        let omega = part(status.omega_zero, &omega);
        Box::new(PreciseExponent {
            growth: part(status.growth_zero, &growth),
            omega: if omega.is_negative() { -&omega } else { omega },
        })
    });
    // More than the digits was aimed at; what has these lacks nothing.
    let decided = |x: &Ball, precise: Option<&Big>| {
        let rounding = match precise {
            Some(x) if x.contains_zero() => return x.is_zero(),
            Some(x) => x.decimal(options.digits).rounding,
            None if x.contains_zero() => return x.is_zero(),
            None => decimal(&x.abs(), options.digits).rounding,
        };
        rounding == Rounding::Correct
    };
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
    Exponent {
        kind: kind(&growth, &omega),
        omega_squared: omega_squared(&growth, &omega),
        growth,
        omega,
        precise,
        vector,
        vector_error_bound,
        cluster: certificate.of[j] as u32,
        limit,
    }
}

/// The entries of a spectrum that was decided exactly, vectors from the nearest columns.
pub(super) fn exact_spectrum(
    scaled: &Scaled,
    solution: &Solution,
    exact: ExactSpectrum,
    options: &Options,
) -> Exponents {
    let columns = &solution.columns.base;
    let shapes = Shapes::new(scaled, solution, options.vectors);
    let mut entries = Vec::new();
    let mut used = vec![false; columns.count()];
    let mut cluster = 0;
    for root in exact.roots {
        let (growth, omega) = (root.growth.to_ball(), root.omega.to_ball());
        if solution.facts.gyroscopic && omega.is_zero() && growth.is_negative() {
            // The growing one stands for the pair.
            continue;
        }
        cluster += 1;
        let limit = match root.vectors {
            Some(vectors) => (vectors < root.multiplicity).then_some(Limit::Defective {
                multiplicity: root.multiplicity,
                vectors,
            }),
            None => Some(Limit::Unresolved {
                count: root.multiplicity,
            }),
        };
        let (re, im) = (
            growth.scale(-scaled.power).mid.hi,
            omega.scale(-scaled.power).mid.hi,
        );
        for _ in 0..root.multiplicity {
            let far =
                |j: &usize| (columns.mu[*j].re.hi - re).hypot(columns.mu[*j].im.hi.abs() - im);
            let nearest = (columns.together()..columns.count())
                .filter(|&j| columns.twin[j].is_none() && !used[j])
                .min_by(|a, b| far(a).total_cmp(&far(b)));
            let (vector, vector_error_bound) = match nearest {
                Some(j) => {
                    // A column above the axis serves once, its pair being one entry; a pair of columns near the axis
                    // may stand for two real exponents.
                    used[j] = !omega.is_zero() || !columns.twin.contains(&Some(j));
                    shapes.of(j)
                }
                None => (Vec::new(), f64::INFINITY),
            };
            entries.push(Exponent {
                kind: kind(&growth, &omega),
                growth,
                omega,
                omega_squared: omega_squared(&growth, &omega),
                precise: Some(Box::new(PreciseExponent {
                    growth: root.growth.clone(),
                    omega: root.omega.clone(),
                })),
                vector,
                vector_error_bound,
                cluster,
                limit,
            });
        }
    }
    let z = columns.zeros;
    let zeros = if solution.facts.gyroscopic {
        exact.zeros / 2
    } else if exact.zeros > 0 {
        z.max(1)
    } else {
        0
    };
    for k in 0..zeros {
        let (vector, vector_error_bound) = if z > 0 {
            shapes.of(k % z)
        } else {
            (Vec::new(), f64::INFINITY)
        };
        entries.push(zero(vector, vector_error_bound, 0));
    }
    finish(entries, solution, options)
}

fn zero(vector: Vec<c64>, vector_error_bound: f64, cluster: u32) -> Exponent {
    Exponent {
        kind: ExponentKind::Zero,
        growth: Ball::ZERO,
        omega: Ball::ZERO,
        omega_squared: Some(Ball::ZERO),
        precise: None,
        vector,
        vector_error_bound,
        cluster,
        limit: None,
    }
}

/// -exponent² where one part is exactly 0.
fn omega_squared(growth: &Ball, omega: &Ball) -> Option<Ball> {
    if growth.is_zero() {
        Some(*omega * *omega)
    } else if omega.is_zero() {
        Some(-(*growth * *growth))
    } else {
        None
    }
}

pub(super) fn kind(growth: &Ball, omega: &Ball) -> ExponentKind {
    if growth.is_positive() {
        ExponentKind::Unstable
    } else if growth.is_negative() {
        if omega.is_zero() {
            ExponentKind::Overdamped
        } else if omega.is_positive() {
            ExponentKind::Damped
        } else {
            ExponentKind::Undecided
        }
    } else if growth.is_zero() && omega.is_positive() {
        ExponentKind::Oscillation
    } else {
        ExponentKind::Undecided
    }
}

/// Unstable ones by falling growth, then zeros, then by rising frequency and falling growth.
fn sort(entries: &mut [Exponent]) {
    let place = |entry: &Exponent| match entry.kind {
        ExponentKind::Unstable => 0,
        ExponentKind::Zero => 1,
        _ => 2,
    };
    entries.sort_by(|a, b| {
        let falling = b.growth.mid.hi.total_cmp(&a.growth.mid.hi);
        place(a).cmp(&place(b)).then_with(|| {
            let rising = a.omega.mid.hi.total_cmp(&b.omega.mid.hi);
            if a.kind == ExponentKind::Unstable {
                falling.then(rising)
            } else if (a.omega - b.omega).contains_zero() {
                falling
            } else {
                rising
            }
        })
    });
}

/// The exponents of parts that nothing couples, as those of the whole.
pub(super) fn joined(parts: Vec<Exponents>, options: &Options) -> Exponents {
    let mut entries: Vec<Exponent> = Vec::new();
    let (mut stability, mut rung) = (Stability::Stable, super::Rung::Doubles);
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
        rung = rung.max(part.rung);
        let numbers = entries.iter().map(|entry| entry.cluster + 1);
        let next = numbers.max().unwrap_or(0);
        let known = entries.len();
        for mut entry in part.entries {
            entry.cluster += next;
            // Separate problems may have exponents that are equal.
            let near = |other: &&Exponent| {
                (other.omega - entry.omega).contains_zero()
                    && (other.growth - entry.growth).contains_zero()
                    && (other.kind == ExponentKind::Zero) == (entry.kind == ExponentKind::Zero)
            };
            let twin = entries[..known]
                .iter()
                .find(near)
                .map(|other| other.cluster);
            let own = entry.cluster;
            entries.push(entry);
            if let Some(twin) = twin {
                let same = entries.iter_mut().filter(|other| other.cluster == own);
                same.for_each(|other| other.cluster = twin);
            }
        }
    }
    sort(&mut entries);
    number(&mut entries);
    if let Some(wanted) = options.lowest {
        entries.truncate(wanted);
    }
    Exponents {
        entries,
        stability,
        rung,
    }
}

/// Clusters counted in the order of their first members.
fn number(entries: &mut [Exponent]) {
    let mut numbers: Vec<u32> = Vec::new();
    for entry in entries {
        let at = numbers.iter().position(|&n| n == entry.cluster);
        let at = at.unwrap_or_else(|| {
            numbers.push(entry.cluster);
            numbers.len() - 1
        });
        entry.cluster = at as u32;
    }
}

/// Sorted, numbered and judged.
fn finish(mut entries: Vec<Exponent>, solution: &Solution, options: &Options) -> Exponents {
    sort(&mut entries);
    let some = |kind: ExponentKind| entries.iter().any(|entry| entry.kind == kind);
    let stability = if some(ExponentKind::Unstable) {
        Stability::Unstable
    } else if entries.iter().any(|entry| {
        let open = entry.growth.contains_zero() && !entry.growth.is_zero();
        let repeated = matches!(entry.limit, Some(Limit::Unresolved { .. }));
        let semisimple = solution.facts.definite;
        open || repeated && !semisimple && entry.kind == ExponentKind::Oscillation
    }) {
        Stability::Undecided
    } else if some(ExponentKind::Zero)
        || entries.iter().any(|entry| {
            entry.kind == ExponentKind::Oscillation
                && matches!(entry.limit, Some(Limit::Defective { .. }))
        })
    {
        Stability::Neutral
    } else {
        Stability::Stable
    };
    number(&mut entries);
    if let Some(wanted) = options.lowest {
        entries.truncate(wanted);
    }
    Exponents {
        entries,
        stability,
        rung: solution.rung,
    }
}
