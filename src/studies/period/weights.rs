//! w(x) with E - U = h(x)/w(x)², and its moments: w = 1/sqrt(x) where x = 0 is a turning point, and 1 elsewhere.

use librate_core::precision::Enclosure;

/// The coefficients of h = D/x from those of D, with x = c + r s: r h_(k-1) + c h_k = D_k. Over an interval c too, from
/// coefficients over it.
pub(super) fn divided<S: Enclosure>(coefficients: &[S], c: &S, r: &S) -> Vec<S> {
    let mut h: Vec<S> = Vec::with_capacity(coefficients.len());
    for value in coefficients {
        let rest = h.last().map_or_else(|| value.clone(), |before| value.sub(&r.mul(before)));
        h.push(rest.div(c));
    }
    h
}

/// J_k = ∫ s^k dx for k below `count`, where s is -1 and 1 at the ends.
pub(super) fn of_one<S: Enclosure>(width: &S, count: usize, number: &impl Fn(f64) -> S) -> Vec<S> {
    let moment = |k: usize| {
        if k.is_multiple_of(2) { width.div(&number((k + 1) as f64)) } else { number(0.0) }
    };
    (0..count).map(moment).collect()
}

/// J_k = ∫ s^k/sqrt(x) dx for k below `count`, from `from` to `to`, where s is -1 and 1; to more than `bits`. By parts, with
/// x = r (kappa + s): (k + 1/2) J_k + k kappa J_(k-1) = [s^k sqrt x] from -1 to 1.
pub(super) fn of_root<S: Enclosure>(from: f64, to: f64, count: usize, bits: u32, number: &impl Fn(f64) -> S) -> Vec<S> {
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
