use dashu_int::IBig;

use super::Big;
use crate::number::Number;

/// A positive root of a positive whole number: radicand^(1/index).
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Root {
    /// Positive.
    pub radicand: IBig,
    /// Positive; 1 for the whole number itself.
    pub index: u32,
}

impl Default for Root {
    /// 1
    fn default() -> Self {
        Self { radicand: IBig::ONE, index: 1 }
    }
}

impl Root {
    /// The number with so many bits.
    #[must_use]
    pub fn value(&self, bits: usize) -> Big {
        let radicand = Big::from_parts(self.radicand.clone(), 0, bits);
        match self.index {
            1 => radicand,
            2 => radicand.sqrt(),
            index => {
                let inverse = Number::from(i64::from(index)).recip();
                radicand.pow(&Big::from_number(&inverse.unwrap_or(Number::ONE), bits))
            }
        }
    }
}
