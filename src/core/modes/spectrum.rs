//! Certified columns as modes in printing order.

use super::levels::Solution;
use super::pencil::{Scaled, ZeroSpace};
use super::{Kind, Mode, Options, Precise, PrecisionLevel, Source, Spectrum, Stability, shape};
use crate::precision::{Ball, Big, Scalar};

/// The modes in printing order.
pub(super) fn spectrum(
    scaled: &Scaled,
    (zero, source): (&ZeroSpace, &dyn Source),
    solution: &Solution,
    options: &Options,
) -> Spectrum {
    let Solution { x, leak, certificate, precise, .. } = solution;
    let zeros = zero.vectors.len();
    let total = certificate.eigenvalues.len() + zeros;
    let wanted = options.lowest.unwrap_or(total).min(total);
    let unstable = certificate.eigenvalues.iter().take_while(|x| x.is_negative()).count();
    let undecided = certificate.eigenvalues.iter().filter(|x| x.contains_zero()).count();
    let stability = stability(unstable, undecided, zeros);
    let mut modes = Vec::with_capacity(wanted);
    let zero_shapes = if options.vectors { shape::zero_shapes(scaled, zero, source) } else { Vec::new() };
    let mut zero_shapes = zero_shapes.into_iter();
    let errors = options.vectors.then(|| shape::Errors::new(leak, certificate, x, zero));
    let mut number = 0;
    let mut put_zeros = |modes: &mut Vec<Mode>, number: &mut u32| {
        for _ in 0..zeros {
            let shape = zero_shapes.next();
            modes.push(mode((Ball::ZERO, 0), None, Kind::Zero, shape, *number));
        }
        *number += u32::from(zeros > 0);
    };
    for (index, cluster) in certificate.clusters.iter().enumerate() {
        if cluster.start == unstable {
            put_zeros(&mut modes, &mut number);
        }
        if modes.len() >= wanted {
            break;
        }
        let own_number = number;
        number += 1;
        let columns = &certificate.order[cluster.start..cluster.end];
        let shapes = errors.as_ref().map(|errors| shape::cluster_shapes(scaled, solution, columns, errors, index));
        let mut shapes = shapes.into_iter().flatten();
        for position in cluster.start..cluster.end {
            if position == unstable && position > cluster.start {
                put_zeros(&mut modes, &mut number);
            }
            // The sign and the root before they leave the range of doubles.
            let value = certificate.eigenvalues[position];
            let kind = if value.is_positive() {
                Kind::Oscillation
            } else if value.is_negative() {
                Kind::Unstable
            } else {
                Kind::Undecided
            };
            let precise = precise.get(position).and_then(Option::as_ref);
            let precise = precise.map(|x| x.scale(scaled.power.into()));
            let value = (value, scaled.power);
            modes.push(mode(value, precise, kind, shapes.next(), own_number));
        }
    }
    if unstable == certificate.eigenvalues.len() {
        put_zeros(&mut modes, &mut number);
    }
    modes.truncate(wanted);
    let precise = modes.iter().any(|mode| mode.precise.is_some());
    let level = if precise { PrecisionLevel::Precise } else { solution.level };
    Spectrum { modes, stability, level }
}

/// What so many modes of a kind say together.
pub(super) fn stability(unstable: usize, undecided: usize, zeros: usize) -> Stability {
    if unstable > 0 {
        Stability::Unstable
    } else if undecided > 0 {
        Stability::Undecided
    } else if zeros > 0 {
        Stability::Neutral
    } else {
        Stability::Stable
    }
}

/// A mode with ω² as a ball times an even power of two.
pub(super) fn mode(
    (omega_squared, power): (Ball, i32),
    precise: Option<Big>,
    kind: Kind,
    shape: Option<shape::Shape>,
    cluster: u32,
) -> Mode {
    let (omega, growth) = roots(kind, &omega_squared, Ball::ZERO);
    let (omega, growth) = (omega.scale(power / 2), growth.scale(power / 2));
    let (vector, vector_error_bound) = shape.map_or((Vec::new(), 0.0), |shape| (shape.vector, shape.error_bound));
    Mode {
        kind,
        omega_squared: omega_squared.scale(power),
        omega,
        growth,
        precise: precise.map(|omega_squared| {
            let (omega, growth) = roots(kind, &omega_squared, Big::zero(omega_squared.bits()));
            Box::new(Precise { omega_squared, omega, growth })
        }),
        vector,
        vector_error_bound,
        cluster,
    }
}

/// Frequency and growth of a mode with this ω².
fn roots<S: Scalar>(kind: Kind, omega_squared: &S, zero: S) -> (S, S) {
    match kind {
        Kind::Oscillation => (omega_squared.sqrt(), zero),
        Kind::Zero => (zero.clone(), zero),
        Kind::Unstable => (zero, omega_squared.neg().sqrt()),
        Kind::Damped | Kind::Overdamped | Kind::Undecided => (omega_squared.sqrt(), omega_squared.neg().sqrt()),
    }
}
