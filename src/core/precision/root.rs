use dashu_int::IBig;

use super::{Big, Scalar};
use crate::number::Number;

/// The root of the order `index`, positive, of a number that is not negative.
pub(crate) fn nth_root<S: Scalar>(radicand: S, index: u32, precision: S::Precision) -> S {
    match index {
        1 => radicand,
        2 => radicand.sqrt(),
        index => {
            let inverse = Number::from(i64::from(index)).recip();
            radicand.pow(&S::from_number(&inverse.unwrap_or(Number::ONE), precision))
        }
    }
}

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
    pub fn value(&self, bits: usize) -> Big {
        nth_root(Big::from_parts(self.radicand.clone(), 0, bits), self.index, bits)
    }
}

/// M, D and S of λ²M + λD + S exactly, times one positive number, in units in which they are whole or combinations of a few square
/// roots: q_i = coordinates_i q'_i and λ = rate λ'. Column by column: coefficients of the square roots of the products of `roots`,
/// one matrix for each subset of these, counted in binary.
#[derive(Clone, Debug, Default)]
pub struct Integers {
    /// M, D and S.
    pub matrices: [Vec<IBig>; 3],
    /// Positive whole numbers whose square roots are left in the entries; no product of some of them is a square.
    pub roots: Vec<IBig>,
    /// The unit of exponents.
    pub rate: Root,
    /// Units of the coordinates; missing ones are 1.
    pub coordinates: Vec<Root>,
}
