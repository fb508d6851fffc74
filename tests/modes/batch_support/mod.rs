//! What the tests of parameter studies share.

#![allow(dead_code, reason = "each test file uses its share")]

use librate::model::{Model, Settings, TableTexts, elaborate};
use librate::oscillation::NormalModes;
use librate::precision::Ball;
use librate::syntax::parse;
use librate_studies::batch::Solution;

pub(crate) fn model(text: &str) -> Model {
    let file = parse(text).unwrap_or_else(|errors| panic!("{errors:?}"));
    elaborate(&file, &TableTexts::new(), &Settings::new()).unwrap_or_else(|errors| panic!("{errors:?}"))
}

/// Knuth's MMIX generator, between 0 and 1.
pub(crate) fn random(state: &mut u64) -> f64 {
    *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    (*state >> 11) as f64 / (1_u64 << 53) as f64
}

/// M-orthonormality, the equation itself, and the sign.
pub(crate) fn check_vectors(name: &str, n: usize, own: &Solution<'_>) {
    let product =
        |a: &[f64], x: &[f64]| -> Vec<f64> { (0..n).map(|i| (0..n).map(|j| a[i + n * j] * x[j]).sum()).collect() };
    let dot = |x: &[f64], y: &[f64]| -> f64 { x.iter().zip(y).map(|(x, y)| x * y).sum() };
    let largest = own.omega_squared.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    let vectors: Vec<&[f64]> = own.vectors.chunks(n).collect();
    assert_eq!(vectors.len(), n);
    for (i, x) in vectors.iter().enumerate() {
        let (mx, kx) = (product(own.mass, x), product(own.stiffness, x));
        for (j, y) in vectors.iter().enumerate() {
            let unit = f64::from(u8::from(i == j));
            assert!((dot(y, &mx) - unit).abs() < 1e-10, "{name}: vectors {i} and {j}");
            let energy = dot(y, &kx) - unit * own.omega_squared[i];
            assert!(energy.abs() <= 1e-10 * largest, "{name}: vectors {i} and {j}");
        }
        let size = x.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        let first = x.iter().find(|x| x.abs() >= size * (1.0 - 1e-6)).unwrap();
        assert!(*first > 0.0, "{name}: sign of vector {i}");
    }
}

/// An exponent, growth and omega.
pub(crate) type Exponent = [Ball; 2];

/// All exponents of a model of so many coordinates, as often as their multiplicity.
fn all_exponents(n: usize, modes: &NormalModes) -> Vec<Exponent> {
    let mut all = Vec::new();
    for mode in &modes.modes {
        let (growth, omega) = (mode.growth, mode.omega);
        all.push([growth, omega]);
        if !omega.is_zero() {
            all.push([growth, -omega]);
        } else if modes.paired {
            all.push([-growth, omega]);
        }
    }
    assert!(all.len() <= 2 * n);
    // Of zeros as many as the kernel of the stiffness has dimensions are listed.
    all.resize(2 * n, [Ball::ZERO; 2]);
    all
}

/// A bound of the distance from a number to an exponent.
fn distance(value: [f64; 2], exact: &Exponent) -> f64 {
    let [re, im] = [0, 1].map(|at| (exact[at] - Ball::exact(value[at])).abs_upper());
    re.hypot(im)
}

/// A place for one more among those that have one, moving others where that helps.
fn place(k: usize, fits: &[Vec<usize>], seen: &mut [bool], owner: &mut [Option<usize>]) -> bool {
    fits[k].iter().any(|at| {
        if std::mem::replace(&mut seen[*at], true) {
            return false;
        }
        let free = match owner[*at] {
            None => true,
            Some(other) => place(other, fits, seen, owner),
        };
        if free {
            owner[*at] = Some(k);
        }
        free
    })
}

/// Whether exact exponents can be given in such an order that all bounds hold.
pub(crate) fn bounds_hold(own: &Solution<'_>, exact: &[Exponent]) -> bool {
    // The exact ones are enclosures themselves.
    let slack = |exact: &Exponent| {
        exact[0].radius + exact[1].radius + 4.0 * f64::EPSILON * exact[0].abs_upper().max(exact[1].abs_upper())
    };
    let fits = |k: usize| {
        let (value, bound) = (own.exponents[k], own.exponent_bounds[k]);
        let near = |at: &usize| distance([value.re, value.im], &exact[*at]) <= bound + 4.0 * slack(&exact[*at]);
        (0..exact.len()).filter(near).collect::<Vec<_>>()
    };
    let fits: Vec<Vec<usize>> = (0..exact.len()).map(fits).collect();
    let mut owner = vec![None; exact.len()];
    (0..exact.len()).all(|k| place(k, &fits, &mut vec![false; exact.len()], &mut owner))
}

/// Order, conjugates, bounds and shapes of a set that is solved; gives the largest bound of all exponents and of those
/// that are apart from others, as parts of the largest exponent.
pub(crate) fn check_exponents(name: &str, n: usize, own: &Solution<'_>, modes: &NormalModes) -> [f64; 2] {
    let exact = all_exponents(n, modes);
    assert_eq!(own.exponents.len(), 2 * n);
    assert!(bounds_hold(own, &exact), "{name}: {:?} {:?} {exact:?}", own.exponents, own.exponent_bounds);
    assert!(own.omega_squared.is_empty() && own.vectors.is_empty() && own.mode(0).is_none());
    assert!(own.exponents.is_sorted_by(|a, b| (a.im.abs(), a.re) <= (b.im.abs(), b.re)), "{name}: {:?}", own.exponents);
    let mut at = 0;
    while at < 2 * n {
        if own.exponents[at].im != 0.0 {
            assert!(own.exponents[at].im > 0.0 && own.exponents[at + 1] == own.exponents[at].conj(), "{name}");
            assert_eq!(own.exponent_bounds[at], own.exponent_bounds[at + 1], "{name}");
            at += 1;
        }
        at += 1;
    }
    let largest = own.exponents.iter().fold(0.0_f64, |most, s| most.max(s.re.hypot(s.im)));
    let is_apart = |k: &usize| {
        let others = own.exponents.iter().enumerate().filter(|(at, _)| at != k);
        others.map(|(_, s)| *s - own.exponents[*k]).all(|off| off.re.hypot(off.im) > 1e-4 * largest)
    };
    let most = |k: &mut dyn Iterator<Item = usize>| k.fold(0.0_f64, |most, k| most.max(own.exponent_bounds[k]));
    let worst =
        [most(&mut (0..2 * n)), most(&mut (0..2 * n).filter(is_apart))].map(|bound| bound / largest.max(1e-300));
    if worst[0] < 1e-9 {
        check_shapes(name, n, own);
    }
    worst
}

/// (s² M + s B + K) x = 0 to the rounding of the first-order problem, whose unit of time is that of the fastest
/// oscillation where s is slower; and the length.
fn check_shapes(name: &str, n: usize, own: &Solution<'_>) {
    for (s, x) in own.exponents.iter().zip(own.shapes.chunks(n)) {
        let (mut most, mut length) = (0.0_f64, 0.0);
        for i in 0..n {
            let mut rest = *s * 0.0;
            for (j, x_j) in x.iter().enumerate() {
                let [m, b, k] = [own.mass, own.velocity, own.stiffness].map(|a| a[i * n + j]);
                let terms = [*s * *s * m * *x_j, *s * b * *x_j, *x_j * k];
                rest += terms[0] + terms[1] + terms[2];
                length += m * (x[i].re * x_j.re + x[i].im * x_j.im);
            }
            most = most.max(rest.re.hypot(rest.im));
        }
        let sizes =
            [own.mass, own.velocity, own.stiffness].map(|a| a.iter().fold(0.0_f64, |most, x| most.max(x.abs())));
        let rate = s.re.hypot(s.im).max((sizes[2] / sizes[0]).sqrt());
        let longest = x.iter().fold(0.0_f64, |most, x| most.max(x.re.hypot(x.im)));
        let all = sizes[0] * rate * rate + sizes[1] * rate + sizes[2];
        assert!(most <= 1e-12 * longest * all, "{name}: {s} {x:?} {most:e} of {all:e}");
        assert!((length - 1.0).abs() < 1e-10, "{name}: {length}");
    }
}
