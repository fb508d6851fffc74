//! Problems from exact rationals, and exact witnesses, for the tests of the numeric stage.

#![allow(dead_code, unreachable_pub, clippy::unwrap_used)]

pub mod precise;

use dashu_int::ops::Gcd;
use dashu_int::{IBig, UBig};
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

/// The number of eigenvalues of K x = s M x below s, exactly: the negative pivots of K - s M (Sylvester), in integers by Bareiss' elimination
/// (Math. Comp. 22, 1968), whose pivots are quotients of what stands on the diagonal by what stood there before. Also the dimension of the kernel.
pub fn count_below(mass: &Exact, stiffness: &Exact, s: &RBig) -> (usize, usize) {
    let n = mass.len();
    let entry = |i: usize, j: usize| &stiffness[i][j] - &(&mass[i][j] * s);
    let exact: Exact = (0..n).map(|i| (0..n).map(|j| entry(i, j)).collect()).collect();
    let multiple = exact.iter().flatten().fold(UBig::ONE, |all, own| {
        let common = (&all).gcd(own.denominator());
        all / common * own.denominator()
    });
    let whole = |own: &RBig| own.numerator() * IBig::from(&multiple / own.denominator());
    let mut rows: Vec<Vec<IBig>> = exact.iter().map(|row| row.iter().map(whole).collect()).collect();
    // What each row was divided by last: rows of a band are brought up to date when they are needed.
    let mut divisors = vec![IBig::ONE; n];
    let (mut negative, mut before) = (0, IBig::ONE);
    let mut left: Vec<usize> = (0..n).collect();
    while !left.is_empty() {
        let mut update = |rows: &mut [Vec<IBig>], i: usize| {
            if divisors[i] != before {
                rows[i].iter_mut().for_each(|own| *own = &*own * &before / &divisors[i]);
                divisors[i] = before.clone();
            }
        };
        let Some(at) = left.iter().position(|&i| rows[i][i] != IBig::ZERO) else {
            let pairs = || left.iter().flat_map(|&p| left.iter().map(move |&q| (p, q)));
            let Some((p, q)) = pairs().find(|&(p, q)| rows[p][q] != IBig::ZERO) else { break };
            // The diagonal vanishes: in the sum of two rows and columns twice the entry beside it stands there.
            update(&mut rows, p);
            update(&mut rows, q);
            left.iter().for_each(|&j| rows[p][j] = &rows[p][j] + &rows[q][j]);
            left.iter().for_each(|&i| rows[i][p] = &rows[i][p] + &rows[i][q]);
            continue;
        };
        let p = left.remove(at);
        update(&mut rows, p);
        let pivot = rows[p].clone();
        negative += usize::from((pivot[p] < IBig::ZERO) != (before < IBig::ZERO));
        for &i in left.iter().filter(|&&i| pivot[i] != IBig::ZERO) {
            update(&mut rows, i);
            let factor = rows[i][p].clone();
            left.iter().for_each(|&j| rows[i][j] = (&pivot[p] * &rows[i][j] - &factor * &pivot[j]) / &before);
        }
        left.iter().filter(|&&i| pivot[i] != IBig::ZERO).for_each(|&i| divisors[i] = pivot[p].clone());
        before = pivot[p].clone();
    }
    (negative, left.len())
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
