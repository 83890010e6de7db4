//! How far a sample of one run is from what another run has around the same sample.

/// Distance of `value` from the range of what `other` has within `reach` samples around `sample`; with 0 from that sample alone. Infinite where
/// either is no number: that is no small error.
pub fn beside(value: f64, other: &[f64], sample: usize, reach: usize) -> f64 {
    let near = &other[sample.saturating_sub(reach)..(sample + reach + 1).min(other.len())];
    if value.is_nan() || near.iter().any(|x| x.is_nan()) {
        return f64::INFINITY;
    }
    let (low, high) = near.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(*x), high.max(*x)));
    (value - high).max(low - value).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_a_jump_one_sample_away_is_no_distance() {
        let other = [1.0, 1.0, 5.0, 5.0];
        assert_eq!([0, 1].map(|reach| beside(5.0, &other, 1, reach)), [4.0, 0.0]);
        assert_eq!([0, 1].map(|reach| beside(7.0, &other, 3, reach)), [2.0, 2.0]);
        assert_eq!(beside(f64::NAN, &other, 0, 1), f64::INFINITY);
        assert_eq!(beside(1.0, &[f64::NAN, 1.0], 1, 1), f64::INFINITY);
    }
}
