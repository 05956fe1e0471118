//! Arithmetic on the lanes of one SIMD register, written as on plain numbers.
//!
//! [`Real`] holds as many `f64` as the machine's registers do. Fused multiply-add is used where the hardware has it and
//! is a multiplication and an addition where it has not (never the slow software routine behind `f64::mul_add`).

use pulp::Simd;
use std::ops::{Add, Mul, Neg, Sub};

/// One number in each lane of a register.
#[derive(Debug, Clone, Copy)]
pub struct Real<S: Simd> {
    simd: S,
    lanes: S::f64s,
}

/// Three components.
#[derive(Debug, Clone, Copy)]
pub struct Triple<S: Simd> {
    /// First component.
    pub x: Real<S>,
    /// Second component.
    pub y: Real<S>,
    /// Third component.
    pub z: Real<S>,
}

impl<S: Simd> Real<S> {
    /// The same number in all lanes.
    #[inline(always)]
    pub fn splat(simd: S, value: f64) -> Self {
        Real { simd, lanes: simd.splat_f64s(value) }
    }

    /// One register of eight lanes; zero beyond them.
    #[inline(always)]
    pub fn load(simd: S, lanes: &[f64; 8], register: usize) -> Self {
        let (registers, _) = S::as_simd_f64s(lanes);
        registers.get(register).map_or(Real::splat(simd, 0.0), |lanes| Real { simd, lanes: *lanes })
    }

    /// Into one register of eight lanes.
    #[inline(always)]
    pub fn store(self, lanes: &mut [f64; 8], register: usize) {
        let (registers, _) = S::as_mut_simd_f64s(lanes);
        registers.get_mut(register).into_iter().for_each(|slot| *slot = self.lanes);
    }

    #[inline(always)]
    fn with(self, lanes: S::f64s) -> Self {
        Real { lanes, ..self }
    }

    /// `self * b + c`.
    #[inline(always)]
    pub fn times_plus(self, b: Self, c: Self) -> Self {
        self.with(self.simd.mul_add_e_f64s(self.lanes, b.lanes, c.lanes))
    }

    /// `c - self * b`.
    #[inline(always)]
    pub fn times_from(self, b: Self, c: Self) -> Self {
        self.with(self.simd.negate_mul_add_e_f64s(self.lanes, b.lanes, c.lanes))
    }

    /// `1 / sqrt(self)`.
    #[inline(always)]
    pub fn reciprocal_root(self) -> Self {
        self.with(self.simd.sqrt_f64s(self.lanes)).reciprocal()
    }

    /// `1 / self`.
    #[inline(always)]
    pub fn reciprocal(self) -> Self {
        self.with(self.simd.div_f64s(self.simd.splat_f64s(1.0), self.lanes))
    }
}

impl<S: Simd> Add for Real<S> {
    type Output = Self;
    #[inline(always)]
    fn add(self, b: Self) -> Self {
        self.with(self.simd.add_f64s(self.lanes, b.lanes))
    }
}

impl<S: Simd> Sub for Real<S> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, b: Self) -> Self {
        self.with(self.simd.sub_f64s(self.lanes, b.lanes))
    }
}

impl<S: Simd> Mul for Real<S> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, b: Self) -> Self {
        self.with(self.simd.mul_f64s(self.lanes, b.lanes))
    }
}

impl<S: Simd> Neg for Real<S> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.with(self.simd.neg_f64s(self.lanes))
    }
}

impl<S: Simd> Triple<S> {
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
    pub fn dot(self, b: Self) -> Real<S> {
        self.z.times_plus(b.z, self.y.times_plus(b.y, self.x * b.x))
    }

    /// `factor * self`.
    #[inline(always)]
    pub fn scaled(self, factor: Real<S>) -> Self {
        Triple { x: self.x * factor, y: self.y * factor, z: self.z * factor }
    }

    /// `factor * self + c`.
    #[inline(always)]
    pub fn scaled_plus(self, factor: Real<S>, c: Self) -> Self {
        Triple {
            x: self.x.times_plus(factor, c.x),
            y: self.y.times_plus(factor, c.y),
            z: self.z.times_plus(factor, c.z),
        }
    }
}
