//! Numbers of a stretch of signal.

/// Value below which `percent` of the values lie, linearly between order statistics (type 7 of Hyndman and Fan); `None` without values.
pub fn percentile(values: &[f64], percent: f64) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let last = sorted.len().checked_sub(1)?;
    let at = 0.01 * percent * last as f64;
    let below = (at.floor() as usize).min(last);
    let above = (below + 1).min(last);
    Some(sorted[below] + (at - below as f64) * (sorted[above] - sorted[below]))
}

/// The larger size of the 0.15 % and the 99.85 % percentile.
pub fn extreme(values: &[f64]) -> Option<f64> {
    Some(percentile(values, 0.15)?.abs().max(percentile(values, 99.85)?.abs()))
}

/// Root mean square; `None` without values.
pub fn rms(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| (values.iter().map(|x| x * x).sum::<f64>() / values.len() as f64).sqrt())
}

/// Arithmetic mean and the standard deviation of a sample; `None` without values.
pub fn mean_and_deviation(values: &[f64]) -> Option<(f64, f64)> {
    let count = values.len() as f64;
    let mean = (!values.is_empty()).then(|| values.iter().sum::<f64>() / count)?;
    let squares: f64 = values.iter().map(|x| (x - mean).powi(2)).sum();
    Some((mean, (squares / (count - 1.0).max(1.0)).sqrt()))
}

/// Means over `window` [m] at every `step` [m] of travel of a signal that is linear between its samples: distance at the window's end, mean. With a whole
/// window alone. `distance` must not fall.
pub fn sliding_means(distance: &[f64], values: &[f64], window: f64, step: f64) -> Vec<(f64, f64)> {
    let Some((first, last)) = distance.first().zip(distance.last()) else { return Vec::new() };
    let mut integrals = vec![0.0; distance.len()];
    for k in 1..distance.len() {
        integrals[k] = integrals[k - 1] + 0.5 * (distance[k] - distance[k - 1]) * (values[k] + values[k - 1]);
    }
    let integral = |s: f64| {
        let k = distance.partition_point(|d| *d <= s).clamp(1, distance.len() - 1) - 1;
        let (ahead, width) = (s - distance[k], distance[k + 1] - distance[k]);
        let slope = if width > 0.0 { (values[k + 1] - values[k]) / width } else { 0.0 };
        integrals[k] + ahead * (values[k] + 0.5 * slope * ahead)
    };
    if distance.len() < 2 || last - first < window {
        return Vec::new();
    }
    let count = ((last - first - window) / step + 1e-9).floor() as usize;
    let at = |k: usize| first + window + step * k as f64;
    (0..=count).map(|k| (at(k), (integral(at(k)) - integral(at(k) - window)) / window)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_percentiles_lie_between_order_statistics() {
        let values: Vec<f64> = (0..=1000).rev().map(f64::from).collect();
        assert_eq!([0.0, 0.15, 50.0, 99.85, 100.0].map(|p| percentile(&values, p).unwrap().round()), [0.0, 2.0, 500.0, 999.0, 1000.0]);
        assert!((percentile(&values, 0.15).unwrap() - 1.5).abs() < 1e-9 && (extreme(&values).unwrap() - 998.5).abs() < 1e-9);
        assert_eq!((percentile(&[], 50.0), percentile(&[3.0], 99.85), rms(&[])), (None, Some(3.0), None));
        assert!((rms(&[3.0, -4.0]).unwrap() - 12.5_f64.sqrt()).abs() < 1e-15);
        assert_eq!(mean_and_deviation(&[1.0, 3.0]), Some((2.0, 2.0_f64.sqrt())));
    }

    /// The mean of a straight line is its value in the window's middle, whatever the samples.
    #[test]
    fn analytic_sliding_means_of_a_straight_line() {
        let distance: Vec<f64> = (0..400).map(|k| 0.03 * f64::from(k) + 0.01 * f64::from(k % 3)).collect();
        let values: Vec<f64> = distance.iter().map(|s| 4.0 - 3.0 * s).collect();
        let means = sliding_means(&distance, &values, 2.0, 0.5);
        assert_eq!(means.len(), 1 + ((distance[399] - 2.0) / 0.5).floor() as usize);
        assert!(means.iter().all(|(at, mean)| (mean - (4.0 - 3.0 * (at - 1.0))).abs() < 1e-9), "{means:?}");
        assert!(sliding_means(&distance[..10], &values[..10], 2.0, 0.5).is_empty() && sliding_means(&[], &[], 2.0, 0.5).is_empty());
    }
}
