//! Several numbers in one register of an x86-64 processor that has AVX2.
//!
//! Every `unsafe` block here calls instructions of AVX or AVX2 on registers, or
//! loads and stores an array that it is given; what they need is a processor
//! that has them. Each value has the [`Avx2`] with which it was made, and without one
//! none can be made.

use core::arch::x86_64::*;
use core::ops::{Add, BitAnd, BitOr, BitXor, Div, Mul, Not, Sub};

use super::lanes::{BEAMS, Pack, Rough, WALLS, Way};
use crate::avx2::Avx2;

impl Way for Avx2 {
    type Exact = Four;
    type Rough = Eight;
}

/// Four `f64`.
#[derive(Clone, Copy)]
pub(super) struct Four(__m256d, Avx2);

/// Eight `f32`.
#[derive(Clone, Copy)]
pub(super) struct Eight(__m256, Avx2);

/// A truth for each lane of a register: all ones or all zeros.
#[derive(Clone, Copy)]
pub(super) struct Truths<T>(T, Avx2);

/// An operator on registers, by the instruction that does it.
macro_rules! operator {
    ($type:ty, $trait:ident, $method:ident, $instruction:ident) => {
        impl $trait for $type {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                // SAFETY: the processor has AVX2: `self` has the proof.
                Self(unsafe { $instruction(self.0, other.0) }, self.1)
            }
        }
    };
}

operator!(Four, Add, add, _mm256_add_pd);
operator!(Four, Sub, sub, _mm256_sub_pd);
operator!(Four, Mul, mul, _mm256_mul_pd);
operator!(Four, Div, div, _mm256_div_pd);
operator!(Eight, Add, add, _mm256_add_ps);
operator!(Eight, Sub, sub, _mm256_sub_ps);
operator!(Eight, Mul, mul, _mm256_mul_ps);
operator!(Eight, Div, div, _mm256_div_ps);
operator!(Truths<__m256d>, BitAnd, bitand, _mm256_and_pd);
operator!(Truths<__m256d>, BitOr, bitor, _mm256_or_pd);
operator!(Truths<__m256d>, BitXor, bitxor, _mm256_xor_pd);
operator!(Truths<__m256>, BitAnd, bitand, _mm256_and_ps);
operator!(Truths<__m256>, BitOr, bitor, _mm256_or_ps);
operator!(Truths<__m256>, BitXor, bitxor, _mm256_xor_ps);

/// What is the same for both kinds of numbers but for the instructions' names.
macro_rules! pack {
    ($type:ident, $register:ty, $number:ty, $lanes:expr, $from_integers:ident,
     $all:ident $load:ident $store:ident $andnot:ident
     $sqrt:ident $max:ident $min:ident $cmp:ident $blend:ident $bits:ident) => {
        impl Not for Truths<$register> {
            type Output = Self;
            #[inline(always)]
            fn not(self) -> Self {
                self ^ $type::every(self.1, true)
            }
        }

        impl Pack for $type {
            type Token = Avx2;
            type Number = $number;
            type Array = [$number; $lanes];
            type Mask = Truths<$register>;

            #[inline(always)]
            fn token(self) -> Avx2 {
                self.1
            }

            #[inline(always)]
            fn all(avx2: Avx2, number: $number) -> Self {
                // SAFETY: the processor has AVX2, as `avx2` proves.
                Self(unsafe { $all(number) }, avx2)
            }

            #[inline(always)]
            fn load(avx2: Avx2, numbers: &[$number; $lanes]) -> Self {
                // SAFETY: as for `all`; the array is as long as the register.
                Self(unsafe { $load(numbers.as_ptr()) }, avx2)
            }

            #[inline(always)]
            fn store(self) -> [$number; $lanes] {
                let mut numbers = [0.0; $lanes];
                // SAFETY: as for `load`.
                unsafe { $store(numbers.as_mut_ptr(), self.0) };
                numbers
            }

            #[inline(always)]
            fn abs(self) -> Self {
                // SAFETY: as for `all`.
                Self(unsafe { $andnot($all(-0.0), self.0) }, self.1)
            }

            #[inline(always)]
            fn sqrt(self) -> Self {
                // SAFETY: as for `all`.
                Self(unsafe { $sqrt(self.0) }, self.1)
            }

            #[inline(always)]
            fn max(self, other: Self) -> Self {
                // SAFETY: as for `all`. For NaN and for zeros of unlike sign the
                // instruction returns its second operand, as it should.
                Self(unsafe { $max(self.0, other.0) }, self.1)
            }

            #[inline(always)]
            fn min(self, other: Self) -> Self {
                // SAFETY: as for `max`.
                Self(unsafe { $min(self.0, other.0) }, self.1)
            }

            #[inline(always)]
            fn lt(self, other: Self) -> Self::Mask {
                // SAFETY: as for `all`.
                Truths(unsafe { $cmp::<_CMP_LT_OQ>(self.0, other.0) }, self.1)
            }

            #[inline(always)]
            fn le(self, other: Self) -> Self::Mask {
                // SAFETY: as for `all`.
                Truths(unsafe { $cmp::<_CMP_LE_OQ>(self.0, other.0) }, self.1)
            }

            #[inline(always)]
            fn eq(self, other: Self) -> Self::Mask {
                // SAFETY: as for `all`.
                Truths(unsafe { $cmp::<_CMP_EQ_OQ>(self.0, other.0) }, self.1)
            }

            #[inline(always)]
            fn choose(mask: Self::Mask, yes: Self, no: Self) -> Self {
                // SAFETY: as for `all`.
                Self(unsafe { $blend(no.0, yes.0, mask.0) }, yes.1)
            }

            #[inline(always)]
            fn bits(mask: Self::Mask) -> u32 {
                // SAFETY: as for `all`.
                (unsafe { $bits(mask.0) }) as u32
            }

            #[inline(always)]
            fn every(avx2: Avx2, truth: bool) -> Self::Mask {
                // SAFETY: as for `all`.
                Truths(unsafe { $from_integers(_mm256_set1_epi32(-i32::from(truth))) }, avx2)
            }
        }
    };
}

pack!(Four, __m256d, f64, BEAMS, _mm256_castsi256_pd,
      _mm256_set1_pd _mm256_loadu_pd _mm256_storeu_pd _mm256_andnot_pd
      _mm256_sqrt_pd _mm256_max_pd _mm256_min_pd _mm256_cmp_pd _mm256_blendv_pd
      _mm256_movemask_pd);
pack!(Eight, __m256, f32, WALLS, _mm256_castsi256_ps,
      _mm256_set1_ps _mm256_loadu_ps _mm256_storeu_ps _mm256_andnot_ps
      _mm256_sqrt_ps _mm256_max_ps _mm256_min_ps _mm256_cmp_ps _mm256_blendv_ps
      _mm256_movemask_ps);

impl Rough for Eight {
    #[inline(always)]
    fn differences(avx2: Avx2, numbers: &[f64; WALLS], from: f64) -> Self {
        // SAFETY: as for `all` and `load`: twice four numbers.
        unsafe {
            let from = _mm256_set1_pd(from);
            let low = _mm256_sub_pd(_mm256_loadu_pd(numbers.as_ptr()), from);
            let high = _mm256_sub_pd(_mm256_loadu_pd(numbers.as_ptr().add(BEAMS)), from);
            Self(_mm256_set_m128(_mm256_cvtpd_ps(high), _mm256_cvtpd_ps(low)), avx2)
        }
    }

    #[inline(always)]
    fn whole(self) -> [i32; WALLS] {
        let mut whole = [0; WALLS];
        // SAFETY: as for `store`: eight `i32`.
        unsafe { _mm256_storeu_si256(whole.as_mut_ptr().cast(), _mm256_cvttps_epi32(self.0)) };
        whole
    }
}
