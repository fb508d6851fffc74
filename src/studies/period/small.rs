//! Small oscillations, and what comes next to them.

use super::panel::Field;
use librate_core::precision::Enclosure;

/// 2 pi sqrt(M/K) at the equilibrium and the leading change of the frequency.
///
/// With X = ∫ sqrt(M/M0) dx and U = u2 X² + U3 X³ + U4 X⁴ + …: omega = omega_0 (1 + A² (3 U4/(4 u2) - 15 U3²/(16 u2²)))
/// (L. D. Landau and E. M. Lifshitz, Mechanics, §28, with omega_0² = 2 u2/M0, alpha = 3 U3/M0, beta = 4 U4/M0). The
/// amplitude of X is that of x to the leading order.
pub(super) fn small<S: Enclosure>(field: &mut Field<S>, at: &S) -> (Option<S>, Option<S>) {
    let (u, m) = field.expand(at, &field.number(1.0), 5);
    let number = |value: f64| field.number(value);
    let (two, three) = (number(2.0), number(3.0));
    let ([_, _, u2, u3, u4], [m0, m1, m2, _, _]) = (u.as_slice(), m.as_slice()) else { return (None, None) };
    if !(u2.is_positive() && m0.is_positive()) {
        return (None, None);
    }
    let small = field.pi().mul(&two).mul(&m0.div(&u2.add(u2)).sqrt());
    // M = M0 (1 + a x + b x²): X = x + p x² + r x³ with p = a/4, r = b/6 - a²/24; then x = X - p X² + (2p² - r) X³.
    let (a, b) = (m1.div(m0), m2.div(m0));
    let p = a.mul(&number(0.25));
    let sixth = number(0.25).mul(&two).div(&three);
    let r = b.mul(&sixth).sub(&a.mul(&a).mul(&number(1.0).div(&number(24.0))));
    let square = p.mul(&p);
    let third = u3.sub(&p.mul(u2).mul(&two));
    let fourth =
        u2.mul(&square.mul(&number(10.0).mul(&number(0.5))).sub(&r.mul(&two))).sub(&p.mul(u3).mul(&three)).add(u4);
    let bend = fourth.div(u2).mul(&number(0.75)).sub(&third.div(u2).powi(2).mul(&number(0.9375)));
    (small.is_finite().then_some(small), bend.is_finite().then_some(bend))
}
