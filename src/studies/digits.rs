//! How well results have to be known.

/// So many significant digits, 1 to `MOST`, have to be certain.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Digits<const MOST: usize> {
    /// How many.
    pub digits: usize,
}

impl<const MOST: usize> Default for Digits<MOST> {
    /// Ten digits.
    fn default() -> Self {
        Self { digits: 10 }
    }
}

impl<const MOST: usize> Digits<MOST> {
    /// With so many digits (1 to `MOST`).
    #[must_use]
    pub fn digits(mut self, digits: usize) -> Self {
        self.digits = digits.clamp(1, MOST);
        self
    }
}
