//! Sums of products in twice the working precision, by error-free transformations.
//!
//! T. J. Dekker, "A floating-point technique for extending the available precision", Numer. Math. 18 (1971), and
//! T. Ogita, S. M. Rump, S. Oishi, "Accurate sum and dot product", SIAM J. Sci. Comput. 26 (2005). The error of a product by fused
//! multiply-add where the processor has it (`pulp` asks at run time), by splitting where it would be slow: the same number.

use pulp::{Arch, Simd, WithSimd};

/// `a + b = sum + error`, exactly (Knuth).
#[inline(always)]
fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let virtual_b = sum - a;
    (sum, (a - (sum - virtual_b)) + (b - virtual_b))
}

/// A sum whose rounding errors are kept.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Sum {
    high: f64,
    low: f64,
}

impl Sum {
    pub(crate) fn add(&mut self, value: f64) {
        let (sum, error) = two_sum(self.high, value);
        self.high = sum;
        self.low += error;
    }

    pub(crate) fn value(self) -> f64 {
        self.high + self.low
    }
}

/// `a = high + low` with at most 26 bits each (Veltkamp); overflows above 1e300.
#[inline(always)]
fn split(a: f64) -> (f64, f64) {
    let shifted = 134_217_729.0 * a;
    let high = shifted - (shifted - a);
    (high, a - high)
}

/// `a b = product + error`, exactly while nothing under- or overflows (Dekker; where there is fused multiply-add, in two operations).
#[inline(always)]
fn two_product<S: Simd>(a: f64, b: f64) -> (f64, f64) {
    let product = a * b;
    if S::F64_LANES > 1 {
        return (product, a.mul_add(b, -product));
    }
    let ((a_high, a_low), (b_high, b_low)) = (split(a), split(b));
    (product, ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low)
}

/// `sum += factor * column`, element by element, the sum being `high + low`.
pub(super) fn accumulate(high: &mut [f64], low: &mut [f64], factor: f64, column: &[f64]) {
    Arch::new().dispatch(Accumulate { high, low, factor, column });
}

struct Accumulate<'a> {
    high: &'a mut [f64],
    low: &'a mut [f64],
    factor: f64,
    column: &'a [f64],
}

impl WithSimd for Accumulate<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        for ((high, low), &a) in self.high.iter_mut().zip(self.low.iter_mut()).zip(self.column) {
            let (product, product_error) = two_product::<S>(self.factor, a);
            let (sum, sum_error) = two_sum(*high, product);
            *high = sum;
            *low += product_error + sum_error;
        }
    }
}

/// `a . b` as if computed in twice the working precision and rounded once.
pub(super) fn compensated_dot(a: &[f64], b: &[f64]) -> f64 {
    Arch::new().dispatch(Dot { a, b })
}

struct Dot<'a> {
    a: &'a [f64],
    b: &'a [f64],
}

impl WithSimd for Dot<'_> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> f64 {
        const LANES: usize = 4;
        let mut high = [0.0; LANES];
        let mut low = [0.0; LANES];
        let (a_blocks, a_rest) = self.a.as_chunks::<LANES>();
        let (b_blocks, b_rest) = self.b.as_chunks::<LANES>();
        for (a, b) in a_blocks.iter().zip(b_blocks) {
            for ((high, low), (a, b)) in high.iter_mut().zip(&mut low).zip(a.iter().zip(b)) {
                let (product, product_error) = two_product::<S>(*a, *b);
                let (sum, sum_error) = two_sum(*high, product);
                *high = sum;
                *low += product_error + sum_error;
            }
        }
        for (&a, &b) in a_rest.iter().zip(b_rest) {
            let (product, product_error) = two_product::<S>(a, b);
            let (sum, sum_error) = two_sum(high[0], product);
            high[0] = sum;
            low[0] += product_error + sum_error;
        }
        let (left, left_error) = two_sum(high[0], high[1]);
        let (right, right_error) = two_sum(high[2], high[3]);
        let (sum, error) = two_sum(left, right);
        sum + (error + left_error + right_error + ((low[0] + low[1]) + (low[2] + low[3])))
    }
}
