//! The superposition of normal modes beside a motion: the linearized equations, solved exactly.
//!
//! With x = (q, q') they are x' = A x, and rows at equal steps follow each other by exp(A h).

use nalgebra::{DMatrix, DVector};

use super::{Start, Times};
use librate_core::linearize::{Linearized, Units};
use librate_core::precision::{Ball, Scalar};

/// What the linearized equations make of a start, one row a sample as they are asked for: coordinates and velocities in doubles,
/// SI. `None` where M is singular to working precision.
#[must_use]
pub fn superposition<'a>(
    linearized: &'a Linearized,
    start: &Start,
    times: &'a Times,
) -> Option<impl Iterator<Item = Vec<f64>> + 'a> {
    let m = linearized.dimension();
    let n = linearized.coordinates();
    let of = |entries: &[Ball]| DMatrix::from_iterator(m, m, entries.iter().map(Ball::mid_f64));
    let (velocity, stiffness) = linearized.velocity_and_stiffness();
    let mass = of(&linearized.mass()).lu();
    let stiffness = mass.solve(&of(&stiffness))?;
    let velocity = mass.solve(&of(&velocity))?;
    let mut generator = DMatrix::zeros(2 * m, 2 * m);
    generator.view_mut((0, m), (m, m)).copy_from(&DMatrix::identity(m, m));
    generator.view_mut((m, 0), (m, m)).copy_from(&-stiffness);
    generator.view_mut((m, m), (m, m)).copy_from(&-velocity);
    // The matrices are in units of the model, times and motions in SI.
    let units = linearized.units();
    let rate = units.map_or(0, Units::rate);
    let length = move |coordinate: usize| units.map_or(0, |own| own.length(coordinate));
    let propagator = exponential(generator * times.at(1).scale_far(rate).mid_f64());
    let rest = &linearized.equilibrium().values;
    let rates = linearized.rates();
    let free = linearized.free_coordinates();
    // What is small beside its place is told before it is rounded.
    let displaced = |values: &[Ball], from: &[Ball], rate: i64| -> Vec<f64> {
        let both = values.iter().zip(from).enumerate();
        let all: Vec<f64> = both.map(|(i, (x, at))| x.sub(at).scale_far(-rate - length(i)).mid_f64()).collect();
        free.iter().filter_map(|at| all.get(*at).copied()).collect()
    };
    let state = [displaced(&start.positions, rest, 0), displaced(&start.velocities, &rates, rate)].concat();
    let equilibrium: Vec<f64> = rest.iter().map(Ball::mid_f64).collect();
    let rates: Vec<f64> = rates.iter().map(Ball::mid_f64).collect();
    let mut state = DVector::from_vec(state);
    Some((0..times.len()).map(move |row| {
        let t = times.at(row).mid_f64();
        let (positions, _) = linearized.embed(&state.as_slice()[..m], 0.0);
        let (velocities, _) = linearized.embed(&state.as_slice()[m..], 0.0);
        let in_si = |x: f64, exponent: i64| Ball::exact(x).scale_far(exponent).mid_f64();
        let places = (0..n).map(|i| equilibrium[i] + rates[i] * t + in_si(positions[i], length(i)));
        let speeds = (0..n).map(|i| rates[i] + in_si(velocities[i], rate + length(i)));
        let values = places.chain(speeds).collect();
        state = &propagator * &state;
        values
    }))
}

/// e^A: the Taylor series of A/2^s, squared s times (C. Moler, C. Van Loan, SIAM Rev. 45 (2003) 3, methods 1 and 3; nalgebra's
/// own needs its feature `std`, which brings five crates for products of large matrices).
fn exponential(matrix: DMatrix<f64>) -> DMatrix<f64> {
    // Norms up to 1/2 are left, where 16 terms are below a rounding; what is not finite stays so.
    let squarings = (matrix.norm().log2() + 1.0).ceil().clamp(0.0, 1100.0) as i32;
    let small = matrix * 0.5_f64.powi(squarings);
    let one = DMatrix::identity(small.nrows(), small.ncols());
    let sum = (1..=16).rev().fold(one.clone(), |sum, term| &one + &small * sum / f64::from(term));
    (0..squarings).fold(sum, |sum, _| &sum * &sum)
}
