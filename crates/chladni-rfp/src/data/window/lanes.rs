//! Complex numbers, some at a time, for [`chladni_linalg::wide`].

use num_complex::Complex64;
use std::ops::{Add, Mul, Sub};

/// An array by the value of each lane: a loop, which the compiler turns into wide operations more
/// surely than a closure over the array.
macro_rules! lanes {
    ($l:ident => $value:expr) => {{
        let mut out = [0.0; L];
        for $l in 0..L {
            out[$l] = $value;
        }
        out
    }};
}

/// L complex numbers.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Lanes<const L: usize> {
    pub re: [f64; L],
    pub im: [f64; L],
}

impl<const L: usize> Lanes<L> {
    pub const ZERO: Self = Self {
        re: [0.0; L],
        im: [0.0; L],
    };

    /// The numbers of all lanes.
    #[inline(always)]
    pub fn of(number: impl Fn(usize) -> Complex64) -> Self {
        let mut lanes = Self::ZERO;
        for l in 0..L {
            lanes.set(l, number(l));
        }
        lanes
    }

    #[inline(always)]
    pub fn set(&mut self, l: usize, number: Complex64) {
        (self.re[l], self.im[l]) = (number.re, number.im);
    }

    #[inline(always)]
    pub fn get(&self, l: usize) -> Complex64 {
        Complex64::new(self.re[l], self.im[l])
    }

    /// The first of them, as many as there is room for.
    #[inline(always)]
    pub fn write(&self, to: &mut [Complex64]) {
        for (l, to) in to.iter_mut().enumerate().take(L) {
            *to = self.get(l);
        }
    }

    pub fn sum(&self) -> Complex64 {
        Complex64::new(self.re.iter().sum(), self.im.iter().sum())
    }

    /// |z|².
    #[inline(always)]
    pub fn norm_sqr(&self) -> [f64; L] {
        lanes!(l => self.re[l] * self.re[l] + self.im[l] * self.im[l])
    }

    /// 1/z; not a number at 0.
    #[inline(always)]
    pub fn inverse(self) -> Self {
        let square = self.norm_sqr();
        self.conj() * lanes!(l => 1.0 / square[l])
    }

    #[inline(always)]
    pub fn conj(self) -> Self {
        Self {
            im: lanes!(l => -self.im[l]),
            ..self
        }
    }
}

impl<const L: usize> From<Complex64> for Lanes<L> {
    #[inline(always)]
    fn from(number: Complex64) -> Self {
        Self {
            re: [number.re; L],
            im: [number.im; L],
        }
    }
}

impl<const L: usize> From<f64> for Lanes<L> {
    #[inline(always)]
    fn from(number: f64) -> Self {
        Complex64::from(number).into()
    }
}

impl<const L: usize> Add for Lanes<L> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self {
            re: lanes!(l => self.re[l] + other.re[l]),
            im: lanes!(l => self.im[l] + other.im[l]),
        }
    }
}

impl<const L: usize> Sub for Lanes<L> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self + other * -1.0
    }
}

impl<const L: usize> Mul for Lanes<L> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        let (a, b) = (self, other);
        Self {
            re: lanes!(l => a.re[l] * b.re[l] - a.im[l] * b.im[l]),
            im: lanes!(l => a.re[l] * b.im[l] + a.im[l] * b.re[l]),
        }
    }
}

impl<const L: usize> Mul<Complex64> for Lanes<L> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, factor: Complex64) -> Self {
        self * Self::from(factor)
    }
}

impl<const L: usize> Mul<[f64; L]> for Lanes<L> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, factors: [f64; L]) -> Self {
        Self {
            re: lanes!(l => self.re[l] * factors[l]),
            im: lanes!(l => self.im[l] * factors[l]),
        }
    }
}

impl<const L: usize> Mul<f64> for Lanes<L> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, factor: f64) -> Self {
        self * [factor; L]
    }
}
