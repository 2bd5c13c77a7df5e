//! Several numbers in an array, one after the other.

use core::ops::{Add, BitAnd, BitOr, BitXor, Div, Mul, Not, Sub};

use super::lanes::{BEAMS, Pack, Rough, WALLS, Way};

/// Computing with arrays.
#[derive(Clone, Copy)]
pub(super) struct Plain;

impl Way for Plain {
    type Exact = Array<f64, BEAMS>;
    type Rough = Array<f32, WALLS>;
}

/// Numbers.
#[derive(Clone, Copy)]
pub(super) struct Array<T, const N: usize>([T; N]);

/// Truths: all ones or all zeros each.
#[derive(Clone, Copy)]
pub(super) struct Truths<T, const N: usize>([T; N]);

#[inline(always)]
fn zip<T: Copy, U: Copy + Default, const N: usize>(
    a: &[T; N],
    b: &[T; N],
    operation: impl Fn(T, T) -> U,
) -> [U; N] {
    let mut result = [U::default(); N];
    for lane in 0..N {
        result[lane] = operation(a[lane], b[lane]);
    }
    result
}

/// An operator on arrays, by the operator on what is in them.
macro_rules! operator {
    ($type:ident, $($number:ty)|*, $trait:ident, $method:ident, $operator:tt) => {
        $(impl<const N: usize> $trait for $type<$number, N> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self(zip(&self.0, &other.0, |a, b| a $operator b))
            }
        })*
    };
}

operator!(Array, f64 | f32, Add, add, +);
operator!(Array, f64 | f32, Sub, sub, -);
operator!(Array, f64 | f32, Mul, mul, *);
operator!(Array, f64 | f32, Div, div, /);
operator!(Truths, u64 | u32, BitAnd, bitand, &);
operator!(Truths, u64 | u32, BitOr, bitor, |);
operator!(Truths, u64 | u32, BitXor, bitxor, ^);

/// What is the same for both kinds of numbers but for the name of their bits.
macro_rules! pack {
    ($number:ty, $bits:ty, $lanes:expr) => {
        impl Not for Truths<$bits, $lanes> {
            type Output = Self;
            #[inline(always)]
            fn not(self) -> Self {
                Self(zip(&self.0, &self.0, |a, _| !a))
            }
        }

        impl Pack for Array<$number, $lanes> {
            type Token = Plain;
            type Number = $number;
            type Array = [$number; $lanes];
            type Mask = Truths<$bits, $lanes>;

            #[inline(always)]
            fn token(self) -> Plain {
                Plain
            }

            #[inline(always)]
            fn all(_: Plain, number: $number) -> Self {
                Self([number; $lanes])
            }

            #[inline(always)]
            fn load(_: Plain, numbers: &[$number; $lanes]) -> Self {
                Self(*numbers)
            }

            #[inline(always)]
            fn store(self) -> [$number; $lanes] {
                self.0
            }

            #[inline(always)]
            fn abs(self) -> Self {
                Self(zip(&self.0, &self.0, |a, _| a.abs()))
            }

            #[inline(always)]
            fn sqrt(self) -> Self {
                Self(zip(&self.0, &self.0, |a, _| a.sqrt()))
            }

            #[inline(always)]
            fn max(self, other: Self) -> Self {
                Self(zip(&self.0, &other.0, |a, b| if a > b { a } else { b }))
            }

            #[inline(always)]
            fn min(self, other: Self) -> Self {
                Self(zip(&self.0, &other.0, |a, b| if a < b { a } else { b }))
            }

            #[inline(always)]
            fn lt(self, other: Self) -> Self::Mask {
                Truths(zip(&self.0, &other.0, |a, b| <$bits>::from(a < b).wrapping_neg()))
            }

            #[inline(always)]
            fn le(self, other: Self) -> Self::Mask {
                Truths(zip(&self.0, &other.0, |a, b| <$bits>::from(a <= b).wrapping_neg()))
            }

            #[inline(always)]
            fn eq(self, other: Self) -> Self::Mask {
                Truths(zip(&self.0, &other.0, |a, b| <$bits>::from(a == b).wrapping_neg()))
            }

            #[inline(always)]
            fn choose(mask: Self::Mask, yes: Self, no: Self) -> Self {
                let mut chosen = [0.0; $lanes];
                for lane in 0..$lanes {
                    // Bits, not a branch: what is chosen cannot be foreseen.
                    let (yes, no) = (yes.0[lane].to_bits(), no.0[lane].to_bits());
                    chosen[lane] =
                        <$number>::from_bits((yes & mask.0[lane]) | (no & !mask.0[lane]));
                }
                Self(chosen)
            }

            #[inline(always)]
            fn bits(mask: Self::Mask) -> u32 {
                let mut bits = 0;
                for lane in 0..$lanes {
                    bits |= ((mask.0[lane] & 1) as u32) << lane;
                }
                bits
            }

            #[inline(always)]
            fn every(_: Plain, truth: bool) -> Self::Mask {
                Truths([<$bits>::from(truth).wrapping_neg(); $lanes])
            }
        }
    };
}

pack!(f64, u64, BEAMS);
pack!(f32, u32, WALLS);

impl Rough for Array<f32, WALLS> {
    #[inline(always)]
    fn differences(_: Plain, numbers: &[f64; WALLS], from: f64) -> Self {
        let mut differences = [0.0; WALLS];
        for lane in 0..WALLS {
            differences[lane] = (numbers[lane] - from) as f32;
        }
        Self(differences)
    }

    #[inline(always)]
    fn whole(self) -> [i32; WALLS] {
        zip(&self.0, &self.0, |a, _| a as i32)
    }
}
