//! Problems from exact rationals, and exact witnesses, for the tests of the numeric stage.

#![allow(dead_code, unreachable_pub, clippy::unwrap_used)]

pub mod precise;

use dashu_int::IBig;
use dashu_ratio::RBig;
use librate::modes::Options;
use librate::precision::Ball;
use librate_core::modes::{Problem, Spectrum, solve};
use librate_core::precision::DoubleDouble;

/// A dense symmetric matrix of exact numbers.
pub type Exact = Vec<Vec<RBig>>;

pub fn ratio(numerator: i64, denominator: i64) -> RBig {
    RBig::from(numerator) / RBig::from(denominator)
}

pub fn power_of_ten(exponent: i32) -> RBig {
    let size = (0..exponent.abs()).fold(RBig::ONE, |p, _| p * RBig::from(10));
    if exponent < 0 { RBig::ONE / size } else { size }
}

pub fn double(x: f64) -> RBig {
    RBig::try_from(x).unwrap()
}

pub fn abs(x: RBig) -> RBig {
    if x < RBig::ZERO { -x } else { x }
}

/// The smallest ball of the usual kind around an exact number.
pub fn ball(x: &RBig) -> Ball {
    let hi = x.to_f64().value();
    let rest = x - double(hi);
    let lo = rest.to_f64().value();
    let error = abs(rest - double(lo));
    let radius = if error == RBig::ZERO { 0.0 } else { error.to_f64().value() * (1.0 + 1e-10) };
    Ball::new(DoubleDouble::new(hi, lo), radius)
}

/// A decimal number with exponent, exactly.
pub fn parse(text: &str) -> RBig {
    let (mantissa, exponent) = text.split_once('e').unwrap_or((text, "0"));
    let (whole, fraction) = mantissa.split_once('.').unwrap_or((mantissa, ""));
    let digits: IBig = format!("{whole}{fraction}").parse().unwrap();
    RBig::from(digits) * power_of_ten(exponent.parse::<i32>().unwrap() - fraction.len() as i32)
}

pub fn problem(mass: &Exact, stiffness: &Exact) -> Problem {
    let flat = |a: &Exact| (0..a.len()).flat_map(|c| (0..a.len()).map(move |r| ball(&a[r][c]))).collect();
    Problem { dimension: mass.len(), mass: flat(mass), stiffness: flat(stiffness), zero_vectors: Vec::new() }
}

pub fn with_digits(digits: usize) -> Options {
    Options::default().digits(digits)
}

pub fn diagonal(entries: &[RBig]) -> Exact {
    let n = entries.len();
    (0..n).map(|i| (0..n).map(|j| if i == j { entries[i].clone() } else { RBig::ZERO }).collect()).collect()
}

/// Masses between springs k[0] (to the left wall), k[1], ..., k[n] (to the right wall).
pub fn chain(masses: &[RBig], springs: &[RBig]) -> (Exact, Exact) {
    let n = masses.len();
    let mut k = vec![vec![RBig::ZERO; n]; n];
    for i in 0..n {
        k[i][i] = &springs[i] + &springs[i + 1];
        if i > 0 {
            k[i][i - 1] = -springs[i].clone();
            k[i - 1][i] = -springs[i].clone();
        }
    }
    (diagonal(masses), k)
}

pub fn integers(values: &[i64]) -> Vec<RBig> {
    values.iter().map(|&x| RBig::from(x)).collect()
}

/// The number of eigenvalues of K x = s M x below s, exactly: the negative pivots of the LDLᵀ
/// factorisation of K - s M, with 2 by 2 pivots where the diagonal vanishes (Sylvester).
/// Also the dimension of the kernel.
pub fn count_below(mass: &Exact, stiffness: &Exact, s: &RBig) -> (usize, usize) {
    let n = mass.len();
    let mut a: Exact = (0..n).map(|i| (0..n).map(|j| &stiffness[i][j] - &(&mass[i][j] * s)).collect()).collect();
    let mut left: Vec<usize> = (0..n).collect();
    let (mut negative, mut zero) = (0, 0);
    while !left.is_empty() {
        if let Some(at) = left.iter().position(|&i| a[i][i] != RBig::ZERO) {
            let p = left.remove(at);
            let pivot = a[p][p].clone();
            negative += usize::from(pivot < RBig::ZERO);
            for &i in &left {
                if a[i][p] == RBig::ZERO {
                    continue;
                }
                let factor = &a[i][p] / &pivot;
                for &j in &left {
                    let change = &factor * &a[p][j];
                    a[i][j] = &a[i][j] - &change;
                }
            }
            continue;
        }
        // The diagonal vanishes: a pair (p, q) with an entry beside it has one eigenvalue of
        // each sign.
        let pair = left.iter().find_map(|&p| left.iter().find(|&&q| a[p][q] != RBig::ZERO).map(|&q| (p, q)));
        let Some((p, q)) = pair else {
            zero += left.len();
            break;
        };
        negative += 1;
        left.retain(|&i| i != p && i != q);
        let b = a[p][q].clone();
        let old = a.clone();
        for &i in &left {
            for &j in &left {
                // A - [c d] [[0, b], [b, 0]]⁻¹ [c d]ᵀ
                let change = (&old[i][p] * &old[q][j] + &old[i][q] * &old[p][j]) / &b;
                a[i][j] = &a[i][j] - &change;
            }
        }
    }
    (negative, zero)
}

/// Exact witness: the k-th ω² lies in its ball, and clusters do not claim separation that is not
/// there.
pub fn check_enclosures(mass: &Exact, stiffness: &Exact, spectrum: &Spectrum) {
    let mut positions: Vec<&librate_core::modes::Mode> = spectrum.modes.iter().collect();
    positions.sort_by(|a, b| a.omega_squared.mid.partial_cmp(&b.omega_squared.mid).unwrap());
    for (k, mode) in positions.iter().enumerate() {
        let b = mode.omega_squared;
        assert!(b.is_finite());
        let mid = double(b.mid.hi) + double(b.mid.lo);
        let (low, high) = (&mid - double(b.radius), mid + double(b.radius));
        // λ_k >= low: at most k below; λ_k <= high: at least k + 1 not above.
        let (below, _) = count_below(mass, stiffness, &low);
        assert!(below <= k, "mode {k}: {below} eigenvalues below its enclosure {b:?}");
        let (below, at) = count_below(mass, stiffness, &high);
        assert!(below + at > k, "mode {k}: {} eigenvalues up to its enclosure's end {b:?}", below + at);
    }
}

/// The residual K x - ω² M x of every mode in doubles, beside the M-orthonormality of all.
pub fn check_vectors(problem: &Problem, spectrum: &Spectrum, tolerance: f64) {
    let n = problem.dimension;
    let apply = |a: &[Ball], x: &[f64]| -> Vec<f64> {
        (0..n).map(|r| (0..n).map(|c| a[c * n + r].mid_f64() * x[c]).sum()).collect()
    };
    for (i, a) in spectrum.modes.iter().enumerate() {
        let image = apply(&problem.mass, &a.vector);
        for (j, b) in spectrum.modes.iter().enumerate() {
            let dot: f64 = image.iter().zip(&b.vector).map(|(x, y)| x * y).sum();
            let want = f64::from(u8::from(i == j));
            assert!((dot - want).abs() < tolerance, "modes {i}, {j}: xᵀMy = {dot}");
        }
        let largest = a.vector.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        let first = a.vector.iter().find(|x| x.abs() >= (1.0 - 1e-6) * largest).unwrap();
        assert!(*first > 0.0);
    }
}

pub fn solved(mass: &Exact, stiffness: &Exact) -> (Problem, Spectrum) {
    let problem = problem(mass, stiffness);
    let spectrum = solve(&problem, &Options::default()).unwrap();
    (problem, spectrum)
}
