//! Arithmetic on the lanes of one SIMD register, written as on plain numbers.
//!
//! [`Real`] holds as many `f64` as the machine's registers do. Fused multiply-add is used where the hardware has it and
//! is a multiplication and an addition where it has not (never the slow software routine behind `f64::mul_add`).

use pulp::Simd;
use std::ops::{Add, Mul, Neg, Sub};

/// One number in each lane.
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

    /// Lanes from the start of a slice; missing ones are zero.
    #[inline(always)]
    pub fn load(simd: S, slice: &[f64]) -> Self {
        let (whole, rest) = S::as_simd_f64s(slice);
        let lanes = whole.first().map_or_else(|| simd.partial_load_f64s(rest), |first| *first);
        Real { simd, lanes }
    }

    /// Lanes to the start of a slice.
    #[inline(always)]
    pub fn store(self, slice: &mut [f64]) {
        let (whole, rest) = S::as_mut_simd_f64s(slice);
        match whole.first_mut() {
            Some(first) => *first = self.lanes,
            None => self.simd.partial_store_f64s(rest, self.lanes),
        }
    }

    /// `self * b + c`.
    #[inline(always)]
    pub fn times_plus(self, b: Self, c: Self) -> Self {
        Real { lanes: self.simd.mul_add_e_f64s(self.lanes, b.lanes, c.lanes), ..self }
    }

    /// `c - self * b`.
    #[inline(always)]
    pub fn times_from(self, b: Self, c: Self) -> Self {
        Real { lanes: self.simd.negate_mul_add_e_f64s(self.lanes, b.lanes, c.lanes), ..self }
    }

    /// `1 / sqrt(self)`.
    #[inline(always)]
    pub fn reciprocal_root(self) -> Self {
        let one = self.simd.splat_f64s(1.0);
        Real { lanes: self.simd.div_f64s(one, self.simd.sqrt_f64s(self.lanes)), ..self }
    }

    /// `1 / self`.
    #[inline(always)]
    pub fn reciprocal(self) -> Self {
        let one = self.simd.splat_f64s(1.0);
        Real { lanes: self.simd.div_f64s(one, self.lanes), ..self }
    }
}

impl<S: Simd> Add for Real<S> {
    type Output = Self;
    #[inline(always)]
    fn add(self, b: Self) -> Self {
        Real { lanes: self.simd.add_f64s(self.lanes, b.lanes), ..self }
    }
}

impl<S: Simd> Sub for Real<S> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, b: Self) -> Self {
        Real { lanes: self.simd.sub_f64s(self.lanes, b.lanes), ..self }
    }
}

impl<S: Simd> Mul for Real<S> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, b: Self) -> Self {
        Real { lanes: self.simd.mul_f64s(self.lanes, b.lanes), ..self }
    }
}

impl<S: Simd> Neg for Real<S> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Real { lanes: self.simd.neg_f64s(self.lanes), ..self }
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
