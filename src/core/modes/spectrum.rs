//! Certified columns as modes in printing order.

use super::climb::Solution;
use super::pencil::{Scaled, ZeroSpace};
use super::precise::Precise;
use super::{Kind, Mode, Options, Rung, Spectrum, Stability, shape};
use crate::precision::{Ball, Big};

/// The modes in printing order.
pub(super) fn spectrum(scaled: &Scaled, zero: &ZeroSpace, solution: &Solution, options: &Options) -> Spectrum {
    let Solution { x, leak, certificate, precise, correction, .. } = solution;
    let basis = correction.as_ref().map_or(x, |before| &before.basis);
    let zeros = zero.vectors.len();
    let total = certificate.eigenvalues.len() + zeros;
    let wanted = options.lowest.unwrap_or(total).min(total);
    let unstable = certificate.eigenvalues.iter().take_while(|x| x.is_negative()).count();
    let undecided = certificate.eigenvalues.iter().filter(|x| x.contains_zero()).count();
    let stability = if unstable > 0 {
        Stability::Unstable
    } else if undecided > 0 {
        Stability::Undecided
    } else if zeros > 0 {
        Stability::Neutral
    } else {
        Stability::Stable
    };
    let mut modes = Vec::with_capacity(wanted);
    let mut zero_shapes = if options.vectors { shape::zero_shapes(scaled, zero) } else { Vec::new() }.into_iter();
    let errors = options.vectors.then(|| shape::Errors::new(scaled, leak, certificate, basis, zero));
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
        let mut shapes = errors
            .as_ref()
            .map(|errors| shape::cluster_shapes(scaled, solution, columns, errors, index))
            .unwrap_or_default()
            .into_iter();
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
    let rung = if precise { Rung::Precise } else { solution.rung };
    Spectrum { modes, stability, rung }
}

/// A mode with ω² as a ball times an even power of two.
fn mode(
    (omega_squared, power): (Ball, i32),
    precise: Option<Big>,
    kind: Kind,
    shape: Option<shape::Shape>,
    cluster: u32,
) -> Mode {
    let both = match kind {
        Kind::Oscillation => (omega_squared.sqrt(), Ball::ZERO),
        Kind::Zero => (Ball::ZERO, Ball::ZERO),
        Kind::Unstable => (Ball::ZERO, (-omega_squared).sqrt()),
        Kind::Damped | Kind::Overdamped | Kind::Undecided => (omega_squared.sqrt(), (-omega_squared).sqrt()),
    };
    let (omega, growth) = (both.0.scale(power / 2), both.1.scale(power / 2));
    let (vector, vector_error_bound) = shape.map_or((Vec::new(), 0.0), |shape| (shape.vector, shape.error_bound));
    Mode {
        kind,
        omega_squared: omega_squared.scale(power),
        omega,
        growth,
        precise: precise.map(|x| Box::new(Precise::new(x, kind))),
        vector,
        vector_error_bound,
        cluster,
    }
}
