//! What bounds never decide, decided for rational matrices of moderate size: repeated exponents, growth 0, the
//! multiplicity of the exponent 0, and the blocks of each ([`super::blocks`]).
//!
//! The characteristic polynomial p(λ) = det(λ²M + λD + S) is interpolated from exact determinants and taken apart by
//! multiplicity, which leaves factors f with simple roots. An imaginary root iω of f has the root -iω beside it,
//! so that both are roots of gcd(f(λ), f(-λ)), a polynomial in λ²; the rest of f has none. So growth is 0 exactly
//! where λ² is a real negative root of that polynomial, and omega is 0 where a root is real; both are decided
//! by discs that hold one root each and meet no other disc on the other side of the axis.
//!
//! Where square roots are left in the entries, p is the product over their conjugates, and which of its roots are those of
//! the matrices themselves is what the kernels there tell.

use dashu_int::IBig;

use super::Options;
use super::basis::{Metric, finished};
use super::blocks::{Blocks, Pencil, Search};
use super::complex::{Wide, largest};
use super::polynomial::{Polynomial, determinant, roots, through};
use crate::polynomial::Polynomial as Divisible;
use crate::precision::{Big, Integers, Rounding};

/// Up to this number of coordinates, with all conjugates.
pub(crate) const LARGEST: usize = 20;
/// The most bits that roots are separated with.
const MOST_BITS: usize = 8192;
/// What is a tie with so many bits is left one.
const BITS_OF_TIES: usize = 1024;
/// So often the bits are doubled for blocks and vectors.
const RISES: usize = 4;
/// Vectors shall be known as well as this.
const FINE: f64 = 1e-14;

/// An exponent with its multiplicity, its parts exactly 0 where they are.
pub(super) struct ExactRoot {
    pub(super) lambda: Wide,
    pub(super) multiplicity: usize,
    /// `None` where it is not known.
    pub(super) blocks: Option<Blocks>,
}

/// All exponents: conjugates once, of real pairs ±s both.
pub(super) struct ExactSpectrum {
    /// The exponent 0, if it is one.
    pub(super) zero: Option<ExactRoot>,
    pub(super) roots: Vec<ExactRoot>,
}

/// λ²M + λD + S, row by row.
fn at([m, d, s]: &[Vec<Vec<IBig>>; 3], lambda: &IBig) -> Vec<Vec<IBig>> {
    let n = m.len();
    let entry = |i: usize, j: usize| (&m[i][j] * lambda + &d[i][j]) * lambda + &s[i][j];
    (0..n).map(|i| (0..n).map(|j| entry(i, j)).collect()).collect()
}

/// The exact spectrum; `None` where it is out of reach.
pub(super) fn exact(
    matrices: &Integers,
    n: usize,
    options: &Options,
    semisimple: bool,
    metric: Option<&Metric<'_>>,
) -> Option<ExactSpectrum> {
    let pencil = Pencil { matrices, n };
    let order = n.checked_mul(pencil.conjugates())?;
    if order > LARGEST || matrices.matrices.iter().any(|m| m.len() != n * order) {
        return None;
    }
    let whole = matrices.matrices.each_ref().map(|matrix| pencil.whole(matrix));
    let values = (0..=2 * order).map(|k| determinant(at(&whole, &IBig::from(k))));
    // Of lower degree where M is singular, and 0 where anything solves the equations.
    let mut p = through(values.collect());
    if p.is_empty() {
        return None;
    }
    let zeros = p.iter().take_while(|c| c.is_zero()).count();
    p.drain(..zeros);
    let semisimple = semisimple && pencil.conjugates() == 1;
    let rate = |bits: usize| matrices.rate.value(bits);
    let mut zero = None;
    if zeros > 0 {
        let line: Polynomial = vec![IBig::ZERO, IBig::ONE];
        let origin = |bits: usize| Some(vec![Wide::zero(bits)]);
        let found = with_blocks(&pencil, (&line, zeros), &origin, 128, false, metric)?;
        zero = found.into_iter().next();
    }
    let mut found = Vec::new();
    for (factor, multiplicity) in Divisible::of_one(p).factors(0) {
        let turned = |(k, c): (usize, IBig)| if k % 2 == 1 { -c } else { c };
        let even = factor.common_divisor(&Divisible::of_one(factor.whole().into_iter().enumerate().map(turned)));
        let rest = factor.over(&even)?.whole();
        let [factor, even] = [factor, even].map(|own| own.whole());
        // Roots in pairs ±λ, none of them 0: a polynomial in λ².
        if even.iter().skip(1).step_by(2).any(|c| !c.is_zero()) {
            return None;
        }
        let squares: Polynomial = even.iter().step_by(2).cloned().collect();
        let lambdas = |bits: usize| {
            let lambdas = separated(&squares, &rest, bits)?;
            let rounding = |x: &Big| (x * &rate(bits)).scale(options.power).decimal(options.digits).rounding;
            let covered = |x: &Big| match rounding(x) {
                Rounding::Correct => true,
                Rounding::Tie => bits >= BITS_OF_TIES,
                Rounding::Fewer | Rounding::Undecided => false,
            };
            lambdas.iter().all(|lambda| covered(&lambda.re) && covered(&lambda.im)).then_some(lambdas)
        };
        let bits = 128 + 4 * options.digits;
        let factor = (&factor, multiplicity);
        found.extend(with_blocks(&pencil, factor, &lambdas, bits, semisimple, metric)?);
    }
    let in_units = |mut root: ExactRoot| {
        root.lambda = root.lambda.times(&rate(root.lambda.re.bits()));
        for head in root.blocks.iter_mut().flat_map(|blocks| &mut blocks.heads) {
            for (x, unit) in head.iter_mut().zip(&matrices.coordinates) {
                *x = x.times(&unit.value(x.re.bits()));
            }
        }
        root
    };
    let own = |root: &ExactRoot| root.multiplicity > 0;
    Some(ExactSpectrum {
        zero: zero.filter(own).map(in_units),
        roots: found.into_iter().filter(own).map(in_units).collect(),
    })
}

/// The roots of a factor: from `lambdas` with as many bits as separate them and show their blocks.
fn with_blocks(
    pencil: &Pencil<'_>,
    (factor, multiplicity): (&Polynomial, usize),
    lambdas: &dyn Fn(usize) -> Option<Vec<Wide>>,
    mut bits: usize,
    semisimple: bool,
    metric: Option<&Metric<'_>>,
) -> Option<Vec<ExactRoot>> {
    let mut best: Option<Vec<ExactRoot>> = None;
    let mut rises = 0;
    while bits <= MOST_BITS && rises < RISES {
        let Some(lambdas) = lambdas(bits) else {
            bits *= 2;
            continue;
        };
        let alone = pencil.conjugates() == 1;
        let search = if metric.is_none() && alone && (multiplicity == 1 || semisimple) {
            let single = Blocks { sizes: vec![1; multiplicity], heads: Vec::new() };
            Search::Found(vec![single; lambdas.len()])
        } else {
            pencil.blocks(factor, &lambdas, multiplicity, semisimple, metric)
        };
        let roots = |blocks: Vec<Option<Blocks>>| -> Vec<ExactRoot> {
            let both = lambdas.iter().cloned().zip(blocks);
            both.map(|(lambda, blocks)| ExactRoot {
                lambda,
                // What is a root of conjugates alone has no blocks.
                multiplicity: blocks.as_ref().map_or(multiplicity, |blocks| blocks.sizes.iter().sum()),
                blocks,
            })
            .collect()
        };
        let last = match search {
            Search::Found(found) => {
                let fine = found.iter().flat_map(|own| &own.heads).all(|head| {
                    let (vector, bound) = finished(head);
                    bound <= FINE * largest(&vector)
                });
                best = Some(roots(found.into_iter().map(Some).collect()));
                fine
            }
            Search::Finer | Search::TooLarge => {
                // Which are roots of conjugates alone is not known then.
                let open = || Some(roots(vec![None; lambdas.len()])).filter(|_| alone);
                best = best.or_else(open);
                matches!(search, Search::TooLarge)
            }
        };
        if last {
            break;
        }
        rises += 1;
        bits *= 2;
    }
    best
}

/// All roots λ, λ² a root of `squares` or λ one of `rest`, that are not below the real axis. Imaginary parts of roots are exactly 0 or
/// have a sign.
fn separated(squares: &Polynomial, rest: &Polynomial, bits: usize) -> Option<Vec<Wide>> {
    let zero = || Big::zero(bits);
    let mut all = Vec::new();
    for s in roots(squares, bits)? {
        if s.im.is_zero() {
            if s.re.is_negative() {
                all.push(Wide::new(zero(), (-&s.re).sqrt()));
            } else if s.re.is_positive() {
                let root = s.re.sqrt();
                all.push(Wide::new(-&root, zero()));
                all.push(Wide::new(root, zero()));
            } else {
                return None;
            }
        } else if s.im.is_positive() {
            // λ = a + ib: a² - b² = Re s, 2ab = Im s, a² + b² = |s|.
            let modulus = s.square_of_modulus().sqrt();
            let (a, b) = if s.re.is_negative() {
                let b = (&modulus - &s.re).scale(-1).sqrt();
                (&s.im / &b.scale(1), b)
            } else {
                let a = (&modulus + &s.re).scale(-1).sqrt();
                (a.clone(), &s.im / &a.scale(1))
            };
            all.push(Wide::new(-&a, b.clone()));
            all.push(Wide::new(a, b));
        }
    }
    all.extend(roots(rest, bits)?.into_iter().filter(|root| !root.im.is_negative()));
    Some(all)
}
