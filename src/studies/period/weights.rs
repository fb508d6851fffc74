//! What is taken out of 1/sqrt(E - U) before it is expanded, and the moments of that.

use librate_core::precision::{Enclosure, Function};

/// w(x), with E - U = h(x)/w(x)².
#[derive(Clone, Debug)]
pub(super) enum Weight<S> {
    /// 1.
    One,
    /// 1/sqrt(x): x = 0 is a turning point.
    Root,
    /// 1/sqrt(x (x + b)), b > 0: there is another zero at x = -b. On panels that begin at x = 0.
    Pair(S),
}

impl<S: Enclosure> Weight<S> {
    /// How many zeros are taken out.
    pub(super) fn zeros(&self) -> usize {
        match self {
            Self::One => 0,
            Self::Root => 1,
            Self::Pair(_) => 2,
        }
    }

    /// A place below `from` and the zeros.
    pub(super) fn reach(&self, from: f64) -> f64 {
        match self {
            Self::One => from,
            Self::Root => 0.0,
            Self::Pair(beyond) => -beyond.abs_upper_magnitude().to_f64(),
        }
    }

    /// The weight for the panels after the first one, which ends at `to`: far from both zeros it takes none.
    pub(super) fn onwards(self, to: f64) -> Self {
        match self {
            Self::Pair(beyond) if beyond.mid_f64() < to => Self::One,
            Self::Pair(_) => Self::Root,
            Self::One | Self::Root => self,
        }
    }

    /// The coefficients of h from those of E - U, in s with x = c + r s. Over an interval c too, from coefficients over it.
    pub(super) fn taken_out(&self, excess: &[S], c: &S, r: &S) -> Vec<S> {
        match self {
            Self::One => excess.to_vec(),
            Self::Root => divided(excess, c, r),
            Self::Pair(beyond) => divided(&divided(excess, c, r), &c.add(beyond), r),
        }
    }

    /// J_k = ∫ s^k w(x) dx for k below `count`, from `from` to `to`, where s is -1 and 1; to more than `bits`.
    pub(super) fn moments(&self, from: f64, to: f64, count: usize, bits: u32, number: &impl Fn(f64) -> S) -> Vec<S> {
        match self {
            Self::One => of_one(&number(to - from), count, number),
            Self::Root => of_root(from, to, count, bits, number),
            Self::Pair(beyond) => of_pair(beyond, to, count, number),
        }
    }
}

/// D/x from the coefficients of D, with x = c + r s: r h_(k-1) + c h_k = D_k.
fn divided<S: Enclosure>(coefficients: &[S], c: &S, r: &S) -> Vec<S> {
    let mut h: Vec<S> = Vec::with_capacity(coefficients.len());
    for value in coefficients {
        let rest = h.last().map_or_else(|| value.clone(), |before| value.sub(&r.mul(before)));
        h.push(rest.div(c));
    }
    h
}

fn of_one<S: Enclosure>(width: &S, count: usize, number: &impl Fn(f64) -> S) -> Vec<S> {
    let moment = |k: usize| {
        if k.is_multiple_of(2) { width.div(&number((k + 1) as f64)) } else { number(0.0) }
    };
    (0..count).map(moment).collect()
}

/// By parts, with x = r (kappa + s): (k + 1/2) J_k + k kappa J_(k-1) = [s^k sqrt x] from -1 to 1.
fn of_root<S: Enclosure>(from: f64, to: f64, count: usize, bits: u32, number: &impl Fn(f64) -> S) -> Vec<S> {
    let (left, right) = (number(from).sqrt(), number(to).sqrt());
    let (sum, difference) = (right.add(&left), right.sub(&left));
    let ends = |k: usize| {
        if k.is_multiple_of(2) { &difference } else { &sum }
    };
    let half_odd = |k: usize| number(k as f64 + 0.5);
    let kappa = number(from + to).div(&number(to - from));
    let mut moments = vec![number(0.0); count];
    if from == 0.0 {
        // kappa = 1: errors do not grow.
        for k in 0..count {
            let mut rest = ends(k).clone();
            if k > 0 {
                rest = rest.sub(&number(k as f64).mul(&moments[k - 1]));
            }
            moments[k] = rest.div(&half_odd(k));
        }
        return moments;
    }
    // kappa >= 3: downwards, errors shrink by more than half a step each time, and what the far end is taken for
    // does not matter: |J_k| <= J_0 = 2 (sqrt(to) - sqrt(from)).
    let more = (f64::from(bits) + 32.0) / kappa.mid_f64().max(2.0).log2();
    let mut above = number(0.0).with_added_magnitude(difference.abs_upper_magnitude().scale(1));
    for k in (1..count + more as usize).rev() {
        above = ends(k).sub(&half_odd(k).mul(&above)).div(&number(k as f64).mul(&kappa));
        if let Some(place) = moments.get_mut(k - 1) {
            *place = above.clone();
        }
    }
    moments
}

/// From 0 on, x = r (1 + s), and with e = b/r, q(s) = (1 + s)(1 + s + e), w = 1/(r sqrt q). J_0 = 2 arsinh(sqrt(to/b)). By
/// parts, from the derivative of s^k sqrt(q):
/// (k + 1) J_(k+1) + (k + 1/2)(2 + e) J_k + k (1 + e) J_(k-1) = [s^k sqrt q] from -1 to 1 = sqrt(2 (2 + e)).
/// Radii grow by 1 + sqrt 2 a step for small e; the coefficients that these moments meet fall faster.
fn of_pair<S: Enclosure>(beyond: &S, to: f64, count: usize, number: &impl Fn(f64) -> S) -> Vec<S> {
    let one = number(1.0);
    let e = beyond.div(&number(0.5 * to));
    let ratio = number(to).div(beyond);
    let root = ratio.sqrt().add(&ratio.add(&one).sqrt());
    let mut moments = Vec::with_capacity(count);
    moments.push(root.apply(Function::Ln).mul(&number(2.0)));
    let (once, twice) = (e.add(&one), e.add(&number(2.0)));
    let ends = twice.add(&twice).sqrt();
    while moments.len() < count {
        let k = (moments.len() - 1) as f64;
        let mut rest = ends.clone();
        if let Some(last) = moments.last() {
            rest = rest.sub(&number(k + 0.5).mul(&twice).mul(last));
        }
        if let Some(before) = moments.len().checked_sub(2).and_then(|at| moments.get(at)) {
            rest = rest.sub(&number(k).mul(&once).mul(before));
        }
        moments.push(rest.div(&number(k + 1.0)));
    }
    moments
}
