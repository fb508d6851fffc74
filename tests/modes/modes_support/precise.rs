//! Exact problems at any precision, and exact witnesses of printed frequencies.

use std::cell::RefCell;

use dashu_int::IBig;
use dashu_ratio::RBig;
use librate::modes::{Kind, Options};
use librate::precision::{Big, Rounding};
use librate_core::modes::{Mode, PreciseProblem, Source, Spectrum, solve_from};
use librate_core::precision::Magnitude;

use super::{Exact, ball, count_below, parse, problem};

/// An exact number with so many bits.
pub fn big(x: &RBig, bits: usize) -> Big {
    let numerator = x.numerator().clone();
    let denominator = x.denominator();
    let length = |x: &IBig| x.to_string().len() as i64 * 10 / 3;
    let places = bits as i64 + length(&IBig::from(denominator.clone())) - length(&numerator) + 8;
    let places = places.max(0);
    let shifted = &numerator << places as usize;
    let quotient = &shifted / denominator;
    let exact = &quotient * IBig::from(denominator.clone()) == shifted;
    let value = Big::from_parts(quotient, -places, bits + 16);
    if exact { value } else { value.with_added_radius(Magnitude::power_of_two(-places)) }
}

fn flat(a: &Exact, bits: usize) -> Vec<Big> {
    (0..a.len()).flat_map(|c| (0..a.len()).map(move |r| big(&a[r][c], bits))).collect()
}

/// An exact problem, and the bits that it was asked for.
struct Known<'a> {
    mass: &'a Exact,
    stiffness: &'a Exact,
    zeros: &'a [Vec<RBig>],
    asked: RefCell<Vec<usize>>,
}

impl Source for Known<'_> {
    fn precisely(&self, bits: usize) -> Option<PreciseProblem> {
        self.asked.borrow_mut().push(bits);
        let vector = |z: &Vec<RBig>| z.iter().map(|x| big(x, bits)).collect();
        Some(PreciseProblem {
            dimension: self.mass.len(),
            mass: flat(self.mass, bits),
            stiffness: flat(self.stiffness, bits),
            zero_vectors: self.zeros.iter().map(vector).collect(),
        })
    }
}

/// The modes with matrices of any precision to draw on; also the bits that were asked for.
pub fn solved_precisely(
    mass: &Exact,
    stiffness: &Exact,
    zeros: &[Vec<RBig>],
    options: &Options,
) -> (Spectrum, Vec<usize>) {
    let mut coarse = problem(mass, stiffness);
    coarse.zero_vectors = zeros.iter().map(|z| z.iter().map(ball).collect()).collect();
    let known = Known { mass, stiffness, zeros, asked: RefCell::new(Vec::new()) };
    let spectrum = solve_from(&coarse, &known, options).unwrap();
    (spectrum, known.asked.into_inner())
}

/// The frequency, or the growth of an unstable mode, as it is printed.
pub fn printed(mode: &Mode, digits: usize) -> (String, Rounding) {
    let decimal = match (&mode.precise, mode.kind) {
        (Some(precise), Kind::Unstable) => precise.growth.decimal(digits),
        (Some(precise), _) => precise.omega.decimal(digits),
        (None, Kind::Unstable) => librate::precision::decimal(&mode.growth, digits),
        (None, _) => librate::precision::decimal(&mode.omega, digits),
    };
    (decimal.text, decimal.rounding)
}

/// Both ends of the interval that a correctly rounded number stands for.
pub fn ends(text: &str) -> (RBig, RBig) {
    let (mantissa, exponent) = text.split_once('e').unwrap_or((text, "0"));
    let decimals = mantissa.split_once('.').map_or(0, |(_, d)| d.len());
    let place = exponent.parse::<i32>().unwrap() - decimals as i32;
    let half = parse(&format!("5e{}", place - 1));
    let value = parse(text);
    (&value - &half, value + half)
}

/// Exact witness: every printed frequency has its digits, all correctly rounded (the k-th
/// eigenvalue lies between the squares of the ends of what the digits stand for, by counting), and
/// the balls beside them enclose the same.
pub fn check_printed(mass: &Exact, stiffness: &Exact, spectrum: &Spectrum, digits: usize) {
    let mut modes: Vec<&Mode> = spectrum.modes.iter().collect();
    let unstable = modes.iter().filter(|m| m.kind == Kind::Unstable).count();
    // By rising eigenvalue: the printing order, as unstable ones come by falling growth.
    assert!(modes[..unstable].iter().all(|m| m.kind == Kind::Unstable));
    for (k, mode) in modes.drain(..).enumerate() {
        if mode.kind == Kind::Zero {
            continue;
        }
        let (text, rounding) = printed(mode, digits);
        assert!(matches!(rounding, Rounding::Correct | Rounding::Tie), "mode {k}: {text} {rounding:?}");
        let (low, high) = ends(&text);
        let (low, high) = (&low * &low, &high * &high);
        let (low, high) = match mode.kind {
            Kind::Unstable => (-high, -low),
            _ => (low, high),
        };
        let (below, _) = count_below(mass, stiffness, &low);
        let (under, at) = count_below(mass, stiffness, &high);
        assert!(below <= k, "mode {k}: {below} eigenvalues below {text}");
        assert!(under + at > k, "mode {k}: {} eigenvalues up to {text}", under + at);
    }
}
