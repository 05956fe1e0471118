//! Arithmetic on the lanes of one SIMD register, written as on plain numbers.
//!
//! [`Real`] holds as many `f64` as the machine's registers do. Fused multiply-add is used where the hardware has it and
//! is a multiplication and an addition where it has not (never the slow software routine behind `f64::mul_add`).
#![allow(clippy::indexing_slicing, reason = "`K` registers, indexed by loops over `K`")]

use pulp::Simd;
use std::ops::{Add, Mul, Neg, Sub};

/// One number in each lane of `K` registers, worked on side by side so that none waits for its own last result.
#[derive(Debug, Clone, Copy)]
pub struct Real<S: Simd, const K: usize> {
    simd: S,
    lanes: [S::f64s; K],
}

/// Three components.
#[derive(Debug, Clone, Copy)]
pub struct Triple<S: Simd, const K: usize> {
    /// First component.
    pub x: Real<S, K>,
    /// Second component.
    pub y: Real<S, K>,
    /// Third component.
    pub z: Real<S, K>,
}

impl<S: Simd, const K: usize> Real<S, K> {
    /// The same number in all lanes.
    #[inline(always)]
    pub fn splat(simd: S, value: f64) -> Self {
        Real { simd, lanes: [simd.splat_f64s(value); K] }
    }

    /// Registers `index..index + K` of eight lanes; zero beyond them.
    #[inline(always)]
    pub fn load(simd: S, lanes: &[f64; 8], index: usize) -> Self {
        let (registers, _) = S::as_simd_f64s(lanes);
        let mut loaded = Real::splat(simd, 0.0);
        for k in 0..K {
            if let Some(register) = registers.get(index + k) {
                loaded.lanes[k] = *register;
            }
        }
        loaded
    }

    /// Into registers `index..index + K` of eight lanes.
    #[inline(always)]
    pub fn store(self, lanes: &mut [f64; 8], index: usize) {
        let (registers, _) = S::as_mut_simd_f64s(lanes);
        for k in 0..K {
            if let Some(register) = registers.get_mut(index + k) {
                *register = self.lanes[k];
            }
        }
    }

    /// `self * b + c`.
    #[inline(always)]
    pub fn times_plus(mut self, b: Self, c: Self) -> Self {
        for k in 0..K {
            self.lanes[k] = self.simd.mul_add_e_f64s(self.lanes[k], b.lanes[k], c.lanes[k]);
        }
        self
    }

    /// `c - self * b`.
    #[inline(always)]
    pub fn times_from(mut self, b: Self, c: Self) -> Self {
        for k in 0..K {
            self.lanes[k] = self.simd.negate_mul_add_e_f64s(self.lanes[k], b.lanes[k], c.lanes[k]);
        }
        self
    }

    /// `1 / sqrt(self)`.
    #[inline(always)]
    pub fn reciprocal_root(mut self) -> Self {
        for k in 0..K {
            self.lanes[k] = self.simd.sqrt_f64s(self.lanes[k]);
        }
        self.reciprocal()
    }

    /// `1 / self`.
    #[inline(always)]
    pub fn reciprocal(mut self) -> Self {
        let one = self.simd.splat_f64s(1.0);
        for k in 0..K {
            self.lanes[k] = self.simd.div_f64s(one, self.lanes[k]);
        }
        self
    }
}

impl<S: Simd, const K: usize> Add for Real<S, K> {
    type Output = Self;
    #[inline(always)]
    fn add(mut self, b: Self) -> Self {
        for k in 0..K {
            self.lanes[k] = self.simd.add_f64s(self.lanes[k], b.lanes[k]);
        }
        self
    }
}

impl<S: Simd, const K: usize> Sub for Real<S, K> {
    type Output = Self;
    #[inline(always)]
    fn sub(mut self, b: Self) -> Self {
        for k in 0..K {
            self.lanes[k] = self.simd.sub_f64s(self.lanes[k], b.lanes[k]);
        }
        self
    }
}

impl<S: Simd, const K: usize> Mul for Real<S, K> {
    type Output = Self;
    #[inline(always)]
    fn mul(mut self, b: Self) -> Self {
        for k in 0..K {
            self.lanes[k] = self.simd.mul_f64s(self.lanes[k], b.lanes[k]);
        }
        self
    }
}

impl<S: Simd, const K: usize> Neg for Real<S, K> {
    type Output = Self;
    #[inline(always)]
    fn neg(mut self) -> Self {
        for k in 0..K {
            self.lanes[k] = self.simd.neg_f64s(self.lanes[k]);
        }
        self
    }
}

impl<S: Simd, const K: usize> Triple<S, K> {
    /// Cross product.
    #[inline(always)]
    pub fn cross(self, b: Self) -> Self {
        Triple {
            x: self.z.times_from(b.y, self.y * b.z),
            y: self.x.times_from(b.z, self.z * b.x),
            z: self.y.times_from(b.x, self.x * b.y),
        }
    }

    /// `self x b + c`.
    #[inline(always)]
    pub fn cross_plus(self, b: Self, c: Self) -> Self {
        Triple {
            x: self.z.times_from(b.y, self.y.times_plus(b.z, c.x)),
            y: self.x.times_from(b.z, self.z.times_plus(b.x, c.y)),
            z: self.y.times_from(b.x, self.x.times_plus(b.y, c.z)),
        }
    }

    /// `self + b`.
    #[inline(always)]
    pub fn plus(self, b: Self) -> Self {
        Triple { x: self.x + b.x, y: self.y + b.y, z: self.z + b.z }
    }

    /// `self - b`.
    #[inline(always)]
    pub fn minus(self, b: Self) -> Self {
        Triple { x: self.x - b.x, y: self.y - b.y, z: self.z - b.z }
    }

    /// Dot product.
    #[inline(always)]
    pub fn dot(self, b: Self) -> Real<S, K> {
        self.z.times_plus(b.z, self.y.times_plus(b.y, self.x * b.x))
    }

    /// `factor * self`.
    #[inline(always)]
    pub fn scaled(self, factor: Real<S, K>) -> Self {
        Triple { x: self.x * factor, y: self.y * factor, z: self.z * factor }
    }

    /// `factor * self + c`.
    #[inline(always)]
    pub fn scaled_plus(self, factor: Real<S, K>, c: Self) -> Self {
        Triple {
            x: self.x.times_plus(factor, c.x),
            y: self.y.times_plus(factor, c.y),
            z: self.z.times_plus(factor, c.z),
        }
    }
}
