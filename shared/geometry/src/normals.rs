//! Many standard normal numbers at once, with the bits of one at a time.
//!
//! The same approximations as in [`normal`](crate::normal), in its operations and their
//! order, but written so that vector instructions can be made of them.
#![allow(
    clippy::excessive_precision,
    reason = "the coefficients stand here with all the digits of the source"
)]

#[cfg(test)]
use crate::trig;

#[cfg(target_arch = "x86_64")]
use crate::avx2::Avx2;
use crate::normal::{
    CENTRAL, CENTRAL_ABOVE, CENTRAL_BELOW, NEAR_ABOVE, NEAR_BELOW, NEAR_TAIL, TWO_TO_MINUS_64,
    outer_quantile, standard_normal, tail_of,
};

/// [`standard_normal`] of every number of `bits`, to the last bit, in a third of the
/// time: the approximation that holds for most is computed for all, in vectors.
/// Of slices of unlike length, the part that both have is written.
pub fn standard_normals(bits: &[u64], z: &mut [f64]) {
    #[cfg(target_arch = "x86_64")]
    {
        if is_x86_feature_detected!("avx512f") && is_x86_feature_detected!("avx512dq") {
            // SAFETY: the processor has these, as it says.
            unsafe { standard_normals_in_eights(bits, z) };
            return;
        }
        if Avx2::detect().is_some() {
            // SAFETY: the processor has AVX2, as `Avx2` proves.
            unsafe { standard_normals_in_fours(bits, z) };
            return;
        }
    }
    standard_normals_plain(bits, z);
}

/// [`standard_normals`], compiled for vectors of eight.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512dq")]
fn standard_normals_in_eights(bits: &[u64], z: &mut [f64]) {
    standard_normals_plain(bits, z);
}

/// [`standard_normals`], compiled for vectors of four.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn standard_normals_in_fours(bits: &[u64], z: &mut [f64]) {
    standard_normals_plain(bits, z);
}

#[inline(always)]
fn standard_normals_plain(bits: &[u64], z: &mut [f64]) {
    for (bits, z) in bits.chunks(PIECE).zip(z.chunks_mut(PIECE)) {
        normals_of_a_piece(bits, z);
    }
}

/// The bits of 2⁵², whose mantissa counts in ones.
const ONES: u64 = 0x433 << 52;

/// How many are taken at a time, so that what is between fits on the stack.
const PIECE: usize = 256;

/// How many are computed together.
const TOGETHER: usize = 8;

/// Up to [`PIECE`] normals. First the central approximation for all; then those
/// that lie farther out, about one in seven, together, because one after the
/// other each would wait for its own logarithm, root and quotient.
#[inline(always)]
fn normals_of_a_piece(bits: &[u64], z: &mut [f64]) {
    let (mut outer, mut count) = ([0_u16; PIECE + TOGETHER], 0);
    let mut first = 0;
    let (chunks, rest) = bits.as_chunks();
    let (z_chunks, z_rest) = z.as_chunks_mut();
    for (bits, z) in chunks.iter().zip(z_chunks) {
        let far;
        (*z, far) = central_normals(bits);
        for (k, far) in far.into_iter().enumerate() {
            // Without a branch, which no processor could predict.
            outer[count] = (first + k) as u16;
            count += usize::from(far);
        }
        first += TOGETHER;
    }
    for (bits, z) in rest.iter().zip(z_rest) {
        *z = standard_normal(*bits);
    }
    let outer = &outer[..count];
    let mut tails = [[0.5; TOGETHER]; PIECE / TOGETHER];
    for (tail, place) in tails.as_flattened_mut().iter_mut().zip(outer) {
        *tail = tail_of(bits[*place as usize]);
    }
    for (tails, places) in tails.iter().zip(outer.chunks(TOGETHER)) {
        let quantiles = outer_quantiles(tails);
        for (quantile, place) in quantiles.iter().zip(places) {
            z[*place as usize] = with_sign_of(*quantile, bits[*place as usize]);
        }
    }
}

/// The central approximation, and which of them lie where it does not hold.
#[inline(always)]
fn central_normals(bits: &[u64; TOGETHER]) -> ([f64; TOGETHER], [bool; TOGETHER]) {
    let (mut q, mut r) = ([0.0; TOGETHER], [0.0; TOGETHER]);
    for k in 0..TOGETHER {
        q[k] = 0.5 - wide_tail_of(bits[k]);
        r[k] = CENTRAL * CENTRAL - q[k] * q[k];
    }
    let (above, below) = (polynomials(&r, &CENTRAL_ABOVE), polynomials(&r, &CENTRAL_BELOW));
    let (mut z, mut far) = ([0.0; TOGETHER], [false; TOGETHER]);
    for k in 0..TOGETHER {
        z[k] = with_sign_of(q[k] * (above[k] / below[k]), bits[k]);
        far[k] = q[k] > CENTRAL;
    }
    (z, far)
}

/// [`tail_of`], to the last bit, without the conversion from 64-bit integers, which AVX2
/// lacks: each half of the number is exact as the end of a mantissa, and only their sum is
/// rounded.
#[inline(always)]
fn wide_tail_of(bits: u64) -> f64 {
    /// 2⁸⁴, whose mantissa counts in 2³².
    const UPPER: u64 = 0x453 << 52;
    const BOTH: f64 = f64::from_bits(UPPER) + f64::from_bits(ONES);
    let ones = f64::from_bits(ONES | (bits & 0xffff_ffff));
    let upper = f64::from_bits(UPPER | (bits << 1 >> 33));
    ((upper - BOTH + ones) + 0.5) * TWO_TO_MINUS_64
}

/// [`outer_quantile`] of every tail.
#[inline(always)]
fn outer_quantiles(tails: &[f64; TOGETHER]) -> [f64; TOGETHER] {
    let (mut r, mut from_near) = ([0.0; TOGETHER], [0.0; TOGETHER]);
    let logarithms = logarithms(tails);
    for k in 0..TOGETHER {
        r[k] = (-logarithms[k]).sqrt();
        from_near[k] = r[k] - 1.6;
    }
    let above = polynomials(&from_near, &NEAR_ABOVE);
    let below = polynomials(&from_near, &NEAR_BELOW);
    let mut quantiles = [0.0; TOGETHER];
    let mut has_farther = false;
    for k in 0..TOGETHER {
        quantiles[k] = above[k] / below[k];
        has_farther |= r[k] > NEAR_TAIL;
    }
    if has_farther {
        // Two in a hundred thousand million.
        for k in (0..TOGETHER).filter(|k| r[*k] > NEAR_TAIL) {
            quantiles[k] = outer_quantile(tails[k]);
        }
    }
    quantiles
}

/// [`trig::ln`] of every number, to the last bit; they are positive, finite and
/// not subnormal.
///
/// Source: fdlibm's `e_log.c` (Sun Microsystems, 1993), which `trig::ln` is, too:
/// x = 2ᵏ·(1 + f) with √½ < 1 + f < √2, and ln(1 + f) from a polynomial in
/// s = f/(2 + f). Departure: no special cases, so that vectors can be made of it.
#[inline(always)]
fn logarithms(x: &[f64; TOGETHER]) -> [f64; TOGETHER] {
    const LN2_HI: f64 = 6.931_471_803_691_238_164_90e-1;
    const LN2_LO: f64 = 1.908_214_929_270_587_700_02e-10;
    const G: [f64; 7] = [
        6.666_666_666_666_735_13e-1,
        3.999_999_999_940_941_908e-1,
        2.857_142_874_366_239_149e-1,
        2.222_219_843_214_978_396e-1,
        1.818_357_216_161_805_012e-1,
        1.531_383_769_920_937_332e-1,
        1.479_819_860_511_658_591e-1,
    ];
    /// The upper half of √½'s bits, where the exponent is taken to change.
    const ROOT_HALF: u64 = 0x3fe6_a09e << 32;
    const ONE: u64 = 0x3ff0_0000 << 32;
    let (mut f, mut dk) = ([0.0; TOGETHER], [0.0; TOGETHER]);
    for k in 0..TOGETHER {
        let moved = x[k].to_bits() + (ONE - ROOT_HALF);
        let mantissa = (moved & (u64::MAX >> 12)) + ROOT_HALF;
        f[k] = f64::from_bits(mantissa) - 1.0;
        dk[k] = f64::from_bits(ONES | moved >> 52) - (f64::from_bits(ONES) + 1023.0);
    }
    let mut logarithms = [0.0; TOGETHER];
    for k in 0..TOGETHER {
        let (f, dk) = (f[k], dk[k]);
        let half_square = 0.5 * f * f;
        let s = f / (2.0 + f);
        let z = s * s;
        let w = z * z;
        let odd = w * (G[1] + w * (G[3] + w * G[5]));
        let even = z * (G[0] + w * (G[2] + w * (G[4] + w * G[6])));
        let rest = even + odd;
        logarithms[k] = s * (half_square + rest) + dk * LN2_LO - half_square + f + dk * LN2_HI;
    }
    logarithms
}

/// The top one of `bits` is the sign.
#[inline(always)]
fn with_sign_of(magnitude: f64, bits: u64) -> f64 {
    f64::from_bits(magnitude.to_bits() ^ (bits & (1 << 63)))
}

/// [`polynomial`] at every `r`.
#[inline(always)]
fn polynomials(r: &[f64; TOGETHER], coefficients: &[f64; 8]) -> [f64; TOGETHER] {
    let mut sums = [0.0; TOGETHER];
    for coefficient in coefficients.iter().rev() {
        for k in 0..TOGETHER {
            sums[k] = sums[k] * r[k] + coefficient;
        }
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A way to compute them, with its name.
    type Normals = fn(&[u64], &mut [f64]);

    /// Those that this processor has.
    fn ways() -> Vec<(&'static str, Normals)> {
        let mut ways: Vec<(_, Normals)> =
            vec![("chosen", standard_normals), ("plain", standard_normals_plain)];
        #[cfg(target_arch = "x86_64")]
        if Avx2::detect().is_some() {
            // SAFETY: the processor has AVX2, as `Avx2` proves.
            ways.push(("fours", |bits, z| unsafe { standard_normals_in_fours(bits, z) }));
        }
        ways
    }

    #[test]
    fn several_at_a_time_have_the_bits_of_one() {
        let mut bits: Vec<u64> =
            (0..10_007_u64).map(|k| k.wrapping_mul(0x9e37_79b9_7f4a_7c15)).collect();
        // The edges: of the sign, of the approximations, of the range.
        let edge = |p: f64| (p / TWO_TO_MINUS_64) as u64;
        for tail in [0.075, 1.4e-11, 0.5] {
            bits.extend((0..20).map(|k| edge(tail) - 10 + k).flat_map(|b| [b, b | 1 << 63]));
        }
        bits.extend([0, 1, u64::MAX, u64::MAX >> 1, 1 << 63]);
        for length in [0, 1, 15, 16, 17, bits.len()] {
            let bits = &bits[bits.len() - length..];
            for (way, normals) in ways() {
                let mut z = vec![f64::NAN; length];
                normals(bits, &mut z);
                for (bits, z) in bits.iter().zip(z) {
                    let one = standard_normal(*bits);
                    assert_eq!(z.to_bits(), one.to_bits(), "{way}: {bits:#x}");
                }
            }
        }
    }

    #[test]
    fn several_logarithms_have_the_bits_of_one() {
        let mut bits = 1_u64;
        for _ in 0..20_000 {
            // Of all tails there are, and of numbers around √½ and 1.
            let x: [f64; TOGETHER] = core::array::from_fn(|k| {
                bits = bits.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                let tail = tail_of(bits >> (k * 4));
                if k % 4 == 3 { 0.5 + tail } else { tail }
            });
            for (found, x) in logarithms(&x).iter().zip(x) {
                assert_eq!(found.to_bits(), trig::ln(x).to_bits(), "{x}");
            }
        }
        for x in
            [f64::MIN_POSITIVE, 0.707, 0.708, core::f64::consts::FRAC_1_SQRT_2, 1.0, 1.414_3, 2.0]
        {
            assert_eq!(logarithms(&[x; TOGETHER])[0].to_bits(), trig::ln(x).to_bits(), "{x}");
        }
    }
}
