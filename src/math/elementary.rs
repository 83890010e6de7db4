//! Logarithm and powers without a branch, so that the compiler finds several at once; not as exact as the standard library's, but without jumps.

use std::f64::consts::{LN_2, LOG2_E, SQRT_2};

const MANTISSA: u64 = 0x000f_ffff_ffff_ffff;
const ONE: u64 = 0x3ff0_0000_0000_0000;
/// 2^52, whose last bits are an integer; in 1.5 times it (`ROUND`) also a negative one.
const WHOLE: u64 = 0x4330_0000_0000_0000;
const ROUND: f64 = 6_755_399_441_055_744.0;

/// ln of a positive number to 1e-9 (of itself or of 1): exponent and mantissa m between sqrt(1/2) and sqrt(2), `ln m = 2 atanh z`,
/// z = (m - 1) / (m + 1) up to 0.172, by its series whose last coefficient (for 1/9) makes the ends meet.
#[inline(always)]
pub fn logarithm(x: f64) -> f64 {
    const LAST: f64 = 0.113_855_628_259_924_12;
    let bits = x.to_bits();
    let (upper, exponent) =
        (f64::from_bits((bits & MANTISSA) | ONE), f64::from_bits((bits >> 52) | WHOLE) - f64::from_bits(WHOLE) - 1023.0);
    let halved = upper > SQRT_2;
    let (m, exponent) = (if halved { 0.5 * upper } else { upper }, if halved { exponent + 1.0 } else { exponent });
    let z = (m - 1.0) / (m + 1.0);
    let z2 = z * z;
    exponent * LN_2 + 2.0 * z * (1.0 + z2 * (1.0 / 3.0 + z2 * (1.0 / 5.0 + z2 * (1.0 / 7.0 + z2 * LAST))))
}

/// e^x to 1e-9 for |x| < 700: `2^k e^r` with |r| up to ln 2 / 2 by its series.
#[inline(always)]
fn exponential(x: f64) -> f64 {
    let shifted = x * LOG2_E + ROUND;
    let r = x - (shifted - ROUND) * LN_2;
    let series = 1.0
        + r * (1.0 + r / 2.0 * (1.0 + r / 3.0 * (1.0 + r / 4.0 * (1.0 + r / 5.0 * (1.0 + r / 6.0 * (1.0 + r / 7.0 * (1.0 + r / 8.0)))))));
    // The last bits of `shifted` are k.
    let scale = f64::from_bits((shifted.to_bits() << 52).wrapping_add(ONE));
    scale * series
}

/// x^p for x > 0, to 1e-9 (1 + |p|).
#[inline(always)]
pub fn power(x: f64, p: f64) -> f64 {
    exponential(p * logarithm(x))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_logarithm_and_powers() {
        for k in -400..400 {
            let x = 1.37f64.powi(k) * 1.001;
            assert!((logarithm(x) - x.ln()).abs() < 1e-9 * x.ln().abs().max(1.0), "{x}");
            assert!((power(x, 0.3) / x.powf(0.3) - 1.0).abs() < 1e-9 && (power(x, -2.5) * x.powf(2.5) - 1.0).abs() < 3e-9, "{x}");
        }
    }

    #[test]
    fn prop_nothing_jumps_where_pieces_meet() {
        for x in [SQRT_2, 4.0 * SQRT_2, 1.0, 2.0, 0.5 * SQRT_2] {
            assert!((logarithm(x * (1.0 + 1e-15)) - logarithm(x * (1.0 - 1e-15))).abs() < 1e-13, "{x}");
        }
        let meet = 0.5 * LN_2;
        assert!((exponential(meet * (1.0 + 1e-15)) / exponential(meet * (1.0 - 1e-15)) - 1.0).abs() < 1e-9);
    }
}
