//! From 64 random bits to a uniform or a standard normal number.
//!
//! Source: M. J. Wichura, *Algorithm AS 241: The percentage points of the normal
//! distribution*, Applied Statistics 37 (1988) 477–484, routine PPND16: three
//! rational approximations of degree 7 with a relative error of about 1e-16.
//!
//! Departures: the routine takes a probability p and forms p − ½ and 1 − p; here
//! one bit gives the sign and the other 63 the probability of the tail, so both
//! tails are equally fine and the law is symmetric to the last bit.
//!
//! Why not a rejection method (the ziggurat of the `rand_distr` crate is faster
//! by some nanoseconds): it uses a number of draws that varies, and its tail
//! calls `ln` through the `num-traits` crate, which is the platform's as soon
//! as *any* crate of a program switches that crate's `std` feature on. Here
//! one slot is one deviate, and `ln` is [`trig::ln`].
#![allow(
    clippy::excessive_precision,
    reason = "the coefficients stand here with all the digits of the source"
)]

use crate::trig;

/// 2⁻⁵³ and 2⁻⁶⁴, exact.
const TWO_TO_MINUS_53: f64 = 1.0 / (1_u64 << 53) as f64;
pub(crate) const TWO_TO_MINUS_64: f64 = 0.5 / (1_u64 << 63) as f64;

/// Up to this |p − ½| the first approximation holds: 85 % of all draws.
pub(crate) const CENTRAL: f64 = 0.425;

/// Up to this √(−ln p) the second holds: p above 1.4e-11.
pub(crate) const NEAR_TAIL: f64 = 5.0;

/// The number u in [0, 1) made of the upper 53 bits: every multiple of 2⁻⁵³
/// below one, all equally likely.
#[inline]
#[must_use]
pub fn uniform(bits: u64) -> f64 {
    (bits >> 11) as i64 as f64 * TWO_TO_MINUS_53
}

/// The standard normal number z that belongs to `bits`: the top bit is its
/// sign, the other 63 are, as (m + ½)·2⁻⁶⁴, the probability of lying farther out
/// on that side. |z| is at most 9.1.
#[inline]
#[must_use]
pub fn standard_normal(bits: u64) -> f64 {
    let magnitude = upper_quantile(tail_of(bits));
    if bits >> 63 == 0 { magnitude } else { -magnitude }
}

/// The probability that the lower 63 of `bits` stand for.
#[inline(always)]
pub(crate) fn tail_of(bits: u64) -> f64 {
    // Signed, because that conversion is one instruction; 63 bits fit.
    ((bits & (u64::MAX >> 1)) as i64 as f64 + 0.5) * TWO_TO_MINUS_64
}

/// The z ≥ 0 that a standard normal number exceeds with probability `tail`, for
/// `tail` in (0, ½].
fn upper_quantile(tail: f64) -> f64 {
    let q = 0.5 - tail;
    if q <= CENTRAL {
        let r = CENTRAL * CENTRAL - q * q;
        return q * ratio(r, &CENTRAL_ABOVE, &CENTRAL_BELOW);
    }
    outer_quantile(tail)
}

/// [`upper_quantile`] of a `tail` below ½ − [`CENTRAL`].
pub(crate) fn outer_quantile(tail: f64) -> f64 {
    let r = (-trig::ln(tail)).sqrt();
    if r <= NEAR_TAIL {
        ratio(r - 1.6, &NEAR_ABOVE, &NEAR_BELOW)
    } else {
        ratio(r - NEAR_TAIL, &FAR_ABOVE, &FAR_BELOW)
    }
}

/// The quotient of two polynomials at `r`, coefficients from the constant up.
#[inline]
fn ratio(r: f64, above: &[f64; 8], below: &[f64; 8]) -> f64 {
    polynomial(r, above) / polynomial(r, below)
}

/// Horner's rule. A product and a sum, not a fused one: same bits everywhere.
#[inline]
fn polynomial(r: f64, coefficients: &[f64; 8]) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, c| sum * r + c)
}

pub(crate) const CENTRAL_ABOVE: [f64; 8] = [
    3.387_132_872_796_366_608,
    133.141_667_891_784_377_45,
    1_971.590_950_306_551_442_7,
    13_731.693_765_509_461_125,
    45_921.953_931_549_871_457,
    67_265.770_927_008_700_853,
    33_430.575_583_588_128_105,
    2_509.080_928_730_122_672_7,
];
pub(crate) const CENTRAL_BELOW: [f64; 8] = [
    1.0,
    42.313_330_701_600_911_252,
    687.187_007_492_057_908_3,
    5_394.196_021_424_751_107_7,
    21_213.794_301_586_595_867,
    39_307.895_800_092_710_61,
    28_729.085_735_721_942_674,
    5_226.495_278_852_854_561,
];
pub(crate) const NEAR_ABOVE: [f64; 8] = [
    1.423_437_110_749_683_577_34,
    4.630_337_846_156_545_295_9,
    5.769_497_221_460_691_405_5,
    3.647_848_324_763_204_605_04,
    1.270_458_252_452_368_382_58,
    0.241_780_725_177_450_611_77,
    0.022_723_844_989_269_184_583_3,
    7.745_450_142_783_414_076_4e-4,
];
pub(crate) const NEAR_BELOW: [f64; 8] = [
    1.0,
    2.053_191_626_637_758_821_87,
    1.676_384_830_183_803_849_4,
    0.689_767_334_985_100_004_55,
    0.148_103_976_427_480_074_59,
    0.015_198_666_563_616_457_196_6,
    5.475_938_084_995_344_946e-4,
    1.050_750_071_644_416_843_24e-9,
];
const FAR_ABOVE: [f64; 8] = [
    6.657_904_643_501_103_777_2,
    5.463_784_911_164_114_369_9,
    1.784_826_539_917_291_335_8,
    0.296_560_571_828_504_891_23,
    0.026_532_189_526_576_123_093,
    0.001_242_660_947_388_078_438_6,
    2.711_555_568_743_487_578_15e-5,
    2.010_334_399_292_288_132_65e-7,
];
const FAR_BELOW: [f64; 8] = [
    1.0,
    0.599_832_206_555_887_937_69,
    0.136_929_880_922_735_805_31,
    0.014_875_361_290_850_614_852_5,
    7.868_691_311_456_132_591e-4,
    1.846_318_317_510_054_681_8e-5,
    1.421_511_758_316_445_888_7e-7,
    2.044_263_103_389_939_785_64e-15,
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_of_the_tables() {
        // Tail probability and quantile, from tables of the normal law.
        for (tail, z) in [
            (0.4, 0.253_347_103_135_799_7),
            (0.25, 0.674_489_750_196_081_7),
            (0.1, 1.281_551_565_544_600_5),
            (0.01, 2.326_347_874_040_841_2),
            (1e-3, 3.090_232_306_167_813_5),
            (1e-6, 4.753_424_308_822_899),
            (1e-10, 6.361_340_902_404_056),
            (1e-15, 7.941_345_326_170_997),
            (1e-19, 9.013_271_153_126_675),
        ] {
            let found = upper_quantile(tail);
            assert!((found - z).abs() < 2e-14, "{tail}: {found} for {z}");
        }
        assert_eq!(upper_quantile(0.5), 0.0);
    }

    #[test]
    fn the_three_approximations_meet() {
        for edge in [0.5 - CENTRAL, trig::exp(-NEAR_TAIL * NEAR_TAIL)] {
            let (inside, outside) =
                (upper_quantile(edge * (1.0 + 1e-15)), upper_quantile(edge * (1.0 - 1e-15)));
            assert!((inside - outside).abs() < 1e-14, "{inside} {outside}");
        }
    }

    #[test]
    fn one_bit_is_the_sign_and_the_rest_the_size() {
        for bits in [0, 1, 12_345, 1 << 40, (1 << 62) + 7, u64::MAX >> 1] {
            assert_eq!(standard_normal(bits | 1 << 63), -standard_normal(bits));
            assert!(standard_normal(bits) >= 0.0);
        }
        let farthest = standard_normal(0);
        assert!(farthest > 9.0 && farthest < 9.2, "{farthest}");
        assert_eq!(standard_normal(u64::MAX >> 1), 0.0);
    }

    #[test]
    fn the_size_falls_as_the_number_rises() {
        let mut last = f64::INFINITY;
        for step in 0..10_000_u64 {
            let z = standard_normal(step * ((1 << 63) / 10_000));
            assert!(z < last, "step {step}");
            last = z;
        }
    }

    #[test]
    fn uniform_numbers_stay_below_one() {
        assert_eq!(uniform(0), 0.0);
        assert_eq!(uniform(u64::MAX), 1.0 - TWO_TO_MINUS_53);
        assert_eq!(uniform(1 << 63), 0.5);
    }

    #[test]
    fn pinned_bits() {
        // Measured once; any platform that prints other bits breaks replay. One
        // value from each approximation; a failure prints the bits to write here.
        for (bits, pinned) in [
            (0x7000_0000_0000_0000, 0x3fc4_22c1_aadb_2493),
            (0x0123_4567_89ab_cdef, 0x4004_ee2d_c0a9_dff7),
            (0x0000_0000_0001_2345, 0x401f_10a3_c58f_f402),
        ] {
            let found = standard_normal(bits);
            assert_eq!(found.to_bits(), pinned, "pin {:#018x}, which is {found}", found.to_bits());
        }
    }
}
