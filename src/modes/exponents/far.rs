//! First approximations where doubles do not do: exponents so far apart that the slow ones are rounding beside the fast.
//!
//! The matrices as they stand in double-double are whole numbers over a power of two. The roots of their exact
//! characteristic polynomial are known to as many digits as are asked for, each relative to itself, and the vectors from
//! both sides are what elimination leaves at them. What the matrices are uncertain by is left to the bounds.

use dashu_int::IBig;
use faer::c64;

use super::super::dense::Matrix;
use super::basis::Metric;
use super::blocks::Pencil;
use super::complex::{Complex, Wide};
use super::exact::exact;
use super::scale::Scaled;
use super::start::Start;
use super::{IntegerQuadratic, Options, Units};
use crate::precision::Big;

/// Digits of the exponents.
const DIGITS: usize = 20;

/// Exponents and vectors of a problem without zero modes whose exponents are simple.
pub(super) fn far_start(scaled: &Scaled) -> Option<Start> {
    let n = scaled.n;
    if !scaled.zero.is_empty() {
        return None;
    }
    let matrices = whole(scaled)?;
    let mass = |i: usize, j: usize| {
        let entry = matrices.mass.get(j * n + i).cloned();
        Big::from_parts(entry.unwrap_or_default(), 0, 128 + 4 * DIGITS)
    };
    let metric = Metric { n, mass: &mass, shift: &vec![0; n] };
    let found = exact(&matrices, n, &Options::default().digits(DIGITS), false, Some(&metric))?;
    let right = Pencil { matrices: &matrices, n };
    let turned = transposed(&matrices, n);
    let left = Pencil { matrices: &turned, n };
    let mut start = Start {
        mu: Vec::with_capacity(2 * n),
        x: Vec::with_capacity(2 * n),
        y: Vec::with_capacity(2 * n),
        twin: Vec::with_capacity(2 * n),
        zeros: 0,
        chains: 0,
        links: Vec::new(),
    };
    for root in found.roots.into_iter().chain(found.zero) {
        let blocks = root.blocks.filter(|_| root.multiplicity == 1)?;
        let x = blocks.heads.into_iter().next()?;
        let lambda = Wide { re: root.growth, im: root.omega };
        let y = left.null_vector(&lambda)?;
        // yᵀ(2λM + D)x = 1, and |x|² = 1 / |λ| as in `start`.
        let slope = right.slope(&lambda, &x);
        let bits = lambda.re.bits();
        let zero = || Wide::zero(bits);
        let product = y.iter().zip(&slope).fold(zero(), |sum, (y, s)| sum.add(&y.mul(s)));
        let size = |x: &Wide| (&(&x.re * &x.re) + &(&x.im * &x.im)).sqrt();
        let square = x.iter().fold(Big::zero(bits), |sum, x| &sum + &(&(&x.re * &x.re) + &(&x.im * &x.im)));
        let length = (&Big::one(bits) / &(&square * &size(&lambda))).sqrt();
        let inverse = Wide { re: Big::one(bits), im: Big::zero(bits) }.div(&product.times(&length));
        let x: Vec<Complex> = x.iter().map(|x| x.times(&length).to_complex()).collect();
        let y: Vec<Complex> = y.iter().map(|y| y.mul(&inverse).to_complex()).collect();
        if !x.iter().chain(&y).all(|x| x.is_finite()) {
            return None;
        }
        let mu = c64::new(lambda.re.mid_f64(), lambda.im.mid_f64());
        let real = lambda.im.is_zero();
        if !real {
            start.mu.push(mu);
            start.x.push(x.clone());
            start.y.push(y.clone());
            start.twin.push(None);
        }
        let conjugate = |v: &[Complex]| v.iter().map(Complex::conjugate).collect();
        start.twin.push((!real).then(|| start.mu.len() - 1));
        start.mu.push(if real { mu } else { c64::new(mu.re, -mu.im) });
        start.x.push(if real { x } else { conjugate(&x) });
        start.y.push(if real { y } else { conjugate(&y) });
    }
    (start.mu.len() == 2 * n).then_some(start)
}

/// The midpoints, all times one power of two.
fn whole(scaled: &Scaled) -> Option<IntegerQuadratic> {
    let entries = |matrix: &Matrix| -> Vec<Big> {
        let columns = (0..scaled.n).flat_map(|j| (0..scaled.n).map(move |i| (i, j)));
        columns.map(|(i, j)| Big::from_double_double(matrix.get(i, j), 128)).collect()
    };
    let all = [entries(&scaled.mass.mid), entries(&scaled.velocity.mid), entries(&scaled.stiffness.mid)];
    let nonzero = all.iter().flatten().filter(|x| !x.is_zero());
    let least = nonzero.map(|x| x.mid().1).min()?;
    let whole = |entries: &[Big]| -> Option<Vec<IBig>> {
        let entries = entries.iter().map(|x| {
            let (significand, exponent) = x.mid();
            if significand.is_zero() {
                return Some(IBig::ZERO);
            }
            let shift = usize::try_from(exponent - least).ok()?;
            Some(significand << shift)
        });
        entries.collect()
    };
    Some(IntegerQuadratic {
        mass: whole(&all[0])?,
        velocity: whole(&all[1])?,
        stiffness: whole(&all[2])?,
        units: Units::default(),
    })
}

fn transposed(matrices: &IntegerQuadratic, n: usize) -> IntegerQuadratic {
    let turned = |matrix: &[IBig]| -> Vec<IBig> {
        let places = (0..n).flat_map(|j| (0..n).map(move |i| i * n + j));
        places.filter_map(|at| matrix.get(at).cloned()).collect()
    };
    IntegerQuadratic {
        mass: turned(&matrices.mass),
        velocity: turned(&matrices.velocity),
        stiffness: turned(&matrices.stiffness),
        units: Units::default(),
    }
}
