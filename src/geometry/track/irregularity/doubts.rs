//! What is allowed in a measured series but is mostly another unit than was meant, or not what a vehicle should be run over.

/// Distances between points of measured track, m: roughness every millimetre, geometry every 0.25 m, by hand some metres.
const SPACINGS: [f64; 2] = [4e-4, 15.0];
/// Rails that move less than this, m, are better than any that is measured; with points nearer than that, m, it is roughness.
const STILL: f64 = 3e-5;
const GEOMETRY: f64 = 0.05;
/// Series with fewer points are made by hand.
const MADE_BY_HAND: usize = 20;
/// Smoothing that moves the points by more than this part of their own swing flattens them.
const FLATTENED: f64 = 0.5;

/// Where points stand nearer or further apart than anyone measures; `spline` goes from one to the next, or lines that invent nothing.
pub(super) fn of_spacing(positions: &[f64], spline: bool) -> Option<String> {
    let mut apart: Vec<f64> = positions.windows(2).map(|pair| pair[1] - pair[0]).collect();
    apart.sort_by(f64::total_cmp);
    let median = *apart.get(apart.len() / 2)?;
    let [dense, wide] = SPACINGS;
    let by_hand = positions.len() < MADE_BY_HAND || !spline;
    (median < dense || median > wide && !by_hand).then(|| {
        let held = if median > wide { "vehicles see hardly anything of such waves" } else { "waves that short lie within a patch" };
        format!("its points stand {median} m apart, where geometry is measured every 0.1 to 5 m and roughness every millimetre: another unit of distance? ({held})")
    })
}

/// Where a column hardly moves: `values` of the column `name` at the `positions`, m, that act `scale` times.
pub(super) fn of_size(name: &str, values: &[f64], scale: f64, positions: &[f64]) -> Option<String> {
    let length = positions.last()? - positions.first()?;
    let [least, most] =
        values.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[least, most], value| [least.min(*value), most.max(*value)]);
    let swing = (scale * (most - least)).abs();
    (swing > 0.0 && swing < 2.0 * STILL && values.len() >= MADE_BY_HAND && length > GEOMETRY * values.len() as f64).then(|| {
        format!("{name} moves by {:.2e} mm between its extremes, where measured rails move by millimetres: another unit?", 1e3 * swing)
    })
}

/// Where smoothing takes most of a column away: from its `values` to those that are left, m.
pub(super) fn of_smoothing(name: &str, values: &[f64], left: &[f64]) -> Option<String> {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let rms = |squares: f64| (squares / count).sqrt();
    let own = rms(values.iter().map(|value| (value - mean).powi(2)).sum());
    let moved = rms(values.iter().zip(left).map(|(value, left)| (value - left).powi(2)).sum());
    (moved > FLATTENED * own).then(|| {
        format!(
            "smoothing moves the points of {name} by {:.3} mm rms, and they swing by {:.3} mm: it flattens what was measured, not its noise",
            1e3 * moved,
            1e3 * own
        )
    })
}
