//! Stand-in for the exact rational number; replaced at the merge with the symbolic core.

use dashu_ratio::RBig;

/// An exact rational number.
#[derive(Clone, Debug, PartialEq)]
pub struct Number(RBig);

impl From<i64> for Number {
    fn from(value: i64) -> Self {
        Self(RBig::from(value))
    }
}

impl From<RBig> for Number {
    fn from(value: RBig) -> Self {
        Self(value)
    }
}

impl Number {
    /// The number as an unevaluated sum of two doubles and an absolute bound of the error.
    pub fn to_double_double(&self) -> (f64, f64, f64) {
        let value = |x: &RBig| x.to_f64().value();
        let hi = value(&self.0);
        let Ok(high) = RBig::try_from(hi) else {
            return (hi, 0.0, f64::INFINITY);
        };
        let rest = &self.0 - &high;
        let lo = value(&rest);
        let Ok(low) = RBig::try_from(lo) else {
            return (hi, 0.0, f64::INFINITY);
        };
        if rest == low {
            (hi, lo, 0.0)
        } else {
            (hi, lo, lo.abs() * f64::EPSILON + f64::MIN_POSITIVE)
        }
    }
}
