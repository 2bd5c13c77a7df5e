//! Arithmetic on several numbers at a time.
//!
//! A scan is written in [`Pack`]s: four `f64` where a result is computed, eight
//! `f32` where it is only decided what to compute. [`super::plain`] does it in
//! any build on any machine, [`super::wide`] with the 256-bit registers of x86-64
//! processors that have AVX2. Both are IEEE 754 arithmetic, lane by lane and
//! without a fused product and sum, so which of them is used changes no bit.

use core::ops::{Add, BitAnd, BitOr, BitXor, Div, Mul, Not, Sub};

/// How many beams go together.
pub(super) const BEAMS: usize = 4;

pub(super) use crate::wall_blocks::WALLS;

/// Some numbers at work.
pub(super) trait Pack:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self>
{
    /// The right to make numbers of nothing: the [`Way`] itself.
    type Token: Copy;
    /// `f64` or `f32`.
    type Number: Copy;
    /// The numbers in memory.
    type Array: Copy;
    /// A truth for each number.
    type Mask: Copy
        + BitAnd<Output = Self::Mask>
        + BitOr<Output = Self::Mask>
        + BitXor<Output = Self::Mask>
        + Not<Output = Self::Mask>;

    /// The token with which this was made.
    fn token(self) -> Self::Token;
    /// The same number in every lane.
    fn all(token: Self::Token, number: Self::Number) -> Self;
    /// From memory.
    fn load(token: Self::Token, numbers: &Self::Array) -> Self;
    /// To memory.
    fn store(self) -> Self::Array;
    /// Without the signs.
    fn abs(self) -> Self;
    /// The square roots.
    fn sqrt(self) -> Self;
    /// `self` where it is greater, else `other`; `other` where one is NaN.
    fn max(self, other: Self) -> Self;
    /// `self` where it is less, else `other`; `other` where one is NaN.
    fn min(self, other: Self) -> Self;
    /// `self` < `other`; false where one is NaN, as for all comparisons.
    fn lt(self, other: Self) -> Self::Mask;
    /// `self` ≤ `other`.
    fn le(self, other: Self) -> Self::Mask;
    /// `self` = `other`.
    fn eq(self, other: Self) -> Self::Mask;
    /// `yes` where the mask is true, else `no`.
    fn choose(mask: Self::Mask, yes: Self, no: Self) -> Self;
    /// Bit k of the result is lane k of the mask.
    fn bits(mask: Self::Mask) -> u32;
    /// The same truth in every lane.
    fn every(token: Self::Token, truth: bool) -> Self::Mask;
}

/// Numbers that are good to seven digits.
pub(super) trait Rough: Pack<Number = f32, Array = [f32; WALLS]> {
    /// The differences between `f64` numbers and one of them, rounded.
    fn differences(token: Self::Token, numbers: &[f64; WALLS], from: f64) -> Self;
    /// Cut off to whole numbers; the numbers are between 0 and 2³¹, or the
    /// result is anything.
    fn whole(self) -> [i32; WALLS];
}

/// A way of computing.
pub(super) trait Way: Copy {
    /// For results.
    type Exact: Pack<Token = Self, Number = f64, Array = [f64; BEAMS]>;
    /// For decisions.
    type Rough: Rough + Pack<Token = Self>;
}
