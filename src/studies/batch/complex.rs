//! Complex numbers of eight parameter sets.

use std::ops::{Add, AddAssign, Mul, Neg, Sub};

use faer::c64;

use librate_core::precision::Lane;

/// Eight complex numbers side by side.
#[derive(Clone, Copy, Debug)]
pub(super) struct ComplexLane {
    pub(super) re: Lane,
    pub(super) im: Lane,
}

impl ComplexLane {
    pub(super) const ZERO: Self = Self::real(Lane::ZERO);
    pub(super) const ONE: Self = Self::real(Lane::ONE);

    #[inline(always)]
    pub(super) const fn real(re: Lane) -> Self {
        Self { re, im: Lane::ZERO }
    }

    #[inline(always)]
    pub(super) fn conj(self) -> Self {
        Self { re: self.re, im: -self.im }
    }

    #[inline(always)]
    pub(super) fn times(self, factor: Lane) -> Self {
        Self { re: self.re * factor, im: self.im * factor }
    }

    /// |z|².
    #[inline(always)]
    pub(super) fn square(self) -> Lane {
        self.re * self.re + self.im * self.im
    }

    #[inline(always)]
    pub(super) fn abs(self) -> Lane {
        self.square().sqrt()
    }

    /// |Re z| + |Im z|, which is |z| or more.
    #[inline(always)]
    pub(super) fn sum(self) -> Lane {
        self.re.abs() + self.im.abs()
    }

    #[inline(always)]
    pub(super) fn choose(self, choice: Lane, other: Self) -> Self {
        Self { re: self.re.choose(choice, other.re), im: self.im.choose(choice, other.im) }
    }

    #[inline(always)]
    pub(super) fn over(self, other: Self) -> Self {
        (self * other.conj()).times(Lane::ONE / other.square())
    }

    /// A root, whichever.
    #[inline(always)]
    pub(super) fn root(self) -> Self {
        let long = ((self.abs() + self.re.abs()) * Lane::splat(0.5)).sqrt();
        let short = (self.im * Lane::splat(0.5) / long).choose(long.above(Lane::ZERO), Lane::ZERO);
        let left = Lane::ZERO.above(self.re);
        Self { re: short.choose(left, long), im: long.choose(left, short) }
    }

    #[inline(always)]
    pub(super) fn get(self, lane: usize) -> c64 {
        c64::new(self.re.0[lane], self.im.0[lane])
    }
}

impl Add for ComplexLane {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self { re: self.re + other.re, im: self.im + other.im }
    }
}

impl Sub for ComplexLane {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self { re: self.re - other.re, im: self.im - other.im }
    }
}

impl Mul for ComplexLane {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self { re: self.re * other.re - self.im * other.im, im: self.re * other.im + self.im * other.re }
    }
}

impl Neg for ComplexLane {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self { re: -self.re, im: -self.im }
    }
}

impl AddAssign for ComplexLane {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}
