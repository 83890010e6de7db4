//! What is assessed: names, units, where the definitions stand, and limits.

use serde::Serialize;

/// What a limit depends on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum VehicleKind {
    #[default]
    Passenger,
    Locomotive,
    Freight,
}

/// A quantity of the table.
#[derive(Debug, PartialEq)]
pub struct Quantity {
    /// In JSON and `--limit`.
    pub key: &'static str,
    pub name: &'static str,
    /// What is shown, and how many of it an SI unit has.
    pub unit: &'static str,
    pub factor: f64,
    pub digits: usize,
    /// The table that it stands in.
    pub group: &'static str,
    /// Document and clause.
    pub source: &'static str,
}

const SAFETY: &str = "Running safety";
const LOADING: &str = "Track loading";
const RIDE: &str = "Ride characteristics";
const COMFORT: &str = "Comfort";
const WEAR: &str = "Wear";

const EN14363: &str = "EN 14363, on-track tests";

const fn quantity([key, name, unit, group, source]: [&'static str; 5], factor: f64, digits: usize) -> Quantity {
    Quantity { key, name, unit, factor, digits, group, source }
}

pub static COMPLETED: Quantity = quantity(["completed", "run reached its end", "s", SAFETY, "-"], 1.0, 2);
pub static SUM_Y: Quantity = quantity(["sum_y", "sum of guiding forces, 2 m mean", "kN", SAFETY, EN14363], 1e-3, 2);
pub static QUOTIENT: Quantity = quantity(["y_over_q", "Y/Q, 2 m mean", "-", SAFETY, EN14363], 1.0, 3);
pub static INSTABILITY: Quantity =
    quantity(["sum_y_rms", "sum of guiding forces, rms over 100 m (instability)", "kN", SAFETY, EN14363], 1e-3, 2);
pub static NADAL: Quantity =
    quantity(["nadal", "Y/Q, 2 m mean, over Nadal's limit", "-", SAFETY, "M. J. Nadal 1896; EN 14363, quasi-static tests"], 1.0, 3);
pub static UNLOADING: Quantity =
    quantity(["unloading", "wheel unloading dQ/Q0, 2 m mean", "-", SAFETY, "EN 14363, safety on twisted track"], 1.0, 3);
pub static SAFETY_LATERAL: Quantity =
    quantity(["acc_y_safety", "lateral acceleration of the body, to 6 Hz", "m/s2", SAFETY, EN14363], 1.0, 3);
pub static SAFETY_VERTICAL: Quantity =
    quantity(["acc_z_safety", "vertical acceleration of the body, 0.4-4 Hz", "m/s2", SAFETY, EN14363], 1.0, 3);
pub static SAFETY_FRAME: Quantity =
    quantity(["acc_y_frame", "lateral acceleration of the bogie frame, to 10 Hz", "m/s2", SAFETY, EN14363], 1.0, 3);
pub static Q_MAX: Quantity = quantity(["q_max", "vertical wheel force Q", "kN", LOADING, EN14363], 1e-3, 2);
pub static Y_QST: Quantity = quantity(["y_qst", "quasi-static guiding force Y", "kN", LOADING, EN14363], 1e-3, 2);
pub static Q_QST: Quantity = quantity(["q_qst", "quasi-static vertical wheel force Q", "kN", LOADING, EN14363], 1e-3, 2);
pub static RIDE_LATERAL: Quantity = quantity(["acc_y_ride", "lateral acceleration, 0.4-10 Hz", "m/s2", RIDE, EN14363], 1.0, 3);
pub static RIDE_VERTICAL: Quantity = quantity(["acc_z_ride", "vertical acceleration, 0.4-10 Hz", "m/s2", RIDE, EN14363], 1.0, 3);
pub static RMS_LATERAL: Quantity = quantity(["rms_y_ride", "lateral acceleration, 0.4-10 Hz, rms", "m/s2", RIDE, EN14363], 1.0, 3);
pub static RMS_VERTICAL: Quantity = quantity(["rms_z_ride", "vertical acceleration, 0.4-10 Hz, rms", "m/s2", RIDE, EN14363], 1.0, 3);
pub static LATERAL_QST: Quantity = quantity(["acc_y_qst", "quasi-static lateral acceleration", "m/s2", RIDE, EN14363], 1.0, 3);
pub static MEAN_COMFORT: Quantity = quantity(["n_mv", "mean comfort N_MV", "-", COMFORT, "EN 12299:2009, 6.7.2"], 1.0, 2);
pub static SPERLING_LATERAL: Quantity =
    quantity(["wz_y", "Sperling's Wz, lateral", "-", COMFORT, "E. Sperling 1941; C. Betzhold 1956"], 1.0, 2);
pub static SPERLING_VERTICAL: Quantity =
    quantity(["wz_z", "Sperling's Wz, vertical", "-", COMFORT, "E. Sperling 1941; C. Betzhold 1956"], 1.0, 2);
pub static WEIGHTED: [Quantity; 3] = [
    quantity(["iso_x", "weighted rms along the track (Wd)", "m/s2", COMFORT, "ISO 2631-1:1997, 6"], 1.0, 4),
    quantity(["iso_y", "weighted rms lateral (Wd)", "m/s2", COMFORT, "ISO 2631-1:1997, 6"], 1.0, 4),
    quantity(["iso_z", "weighted rms vertical (Wk)", "m/s2", COMFORT, "ISO 2631-1:1997, 6"], 1.0, 4),
];
pub static WEIGHTED_TOTAL: Quantity = quantity(["iso_total", "weighted rms, vector sum", "m/s2", COMFORT, "ISO 2631-1:1997, 6.5"], 1.0, 4);
pub static WEAR_WHEEL: Quantity = quantity(
    ["t_gamma", "wear number T gamma of the most worn wheel, mean over distance", "J/m", WEAR, "docs/outputs.md, wearNumber"],
    1.0,
    2,
);
pub static WEAR_ALL: Quantity =
    quantity(["t_gamma_sum", "wear number T gamma of all wheels, mean over distance", "J/m", WEAR, "docs/outputs.md, wearNumber"], 1.0, 2);

/// All of them, as they stand in the table.
pub static ALL: [&Quantity; 24] = [
    &COMPLETED,
    &SUM_Y,
    &QUOTIENT,
    &INSTABILITY,
    &NADAL,
    &UNLOADING,
    &SAFETY_LATERAL,
    &SAFETY_VERTICAL,
    &SAFETY_FRAME,
    &Q_MAX,
    &Y_QST,
    &Q_QST,
    &RIDE_LATERAL,
    &RIDE_VERTICAL,
    &RMS_LATERAL,
    &RMS_VERTICAL,
    &LATERAL_QST,
    &MEAN_COMFORT,
    &SPERLING_LATERAL,
    &SPERLING_VERTICAL,
    &WEIGHTED[0],
    &WEIGHTED[1],
    &WEIGHTED[2],
    &WEIGHTED_TOTAL,
];

/// The same with wear, which has no limit of its own.
pub fn by_key(key: &str) -> Option<&'static Quantity> {
    ALL.iter().copied().chain([&WEAR_WHEEL, &WEAR_ALL]).find(|quantity| quantity.key == key)
}

/// Keys that a limit may be given for.
pub fn keys() -> Vec<&'static str> {
    ALL[1..].iter().map(|quantity| quantity.key).chain([WEAR_WHEEL.key, WEAR_ALL.key]).collect()
}

const KN: f64 = 1e3;

/// Limit of the sum of guiding forces for the static axle load [N], N: `k (10 kN + P0/3)`, k = 0.85 for freight wagons.
pub fn sum_of_guiding_forces(axle_load: f64, kind: VehicleKind) -> f64 {
    let part = if kind == VehicleKind::Freight { 0.85 } else { 1.0 };
    part * (10.0 * KN + axle_load / 3.0)
}

/// Limit of Q for the static wheel load [N] and the admissible speed [m/s], N: `90 kN + Q0`, at most 200 kN up to 160 km/h, 190 up to 200, 180 up to 250, 170 up to
/// 300, 160 above; 210 kN up to 100 km/h for wheel loads above 112.5 kN.
pub fn vertical_force(wheel_load: f64, speed: f64) -> f64 {
    let steps = [(160.0, 200.0), (200.0, 190.0), (250.0, 180.0), (300.0, 170.0)];
    let kmh = 3.6 * speed * (1.0 - 1e-9);
    let by_speed = steps.into_iter().find(|step| kmh <= step.0).map_or(160.0, |step| step.1);
    let cap = if wheel_load > 112.5 * KN && kmh <= 100.0 { 210.0 } else { by_speed };
    (90.0 * KN + wheel_load).min(cap * KN)
}

/// Limit of the quasi-static guiding force, N.
pub const GUIDING_QST: f64 = 60.0 * KN;

/// Limit of the quasi-static vertical wheel force for the static wheel load [N], N: 145 kN; 155 kN above 112.5 kN.
pub fn vertical_qst(wheel_load: f64) -> f64 {
    KN * if wheel_load > 112.5 * KN { 155.0 } else { 145.0 }
}

/// Nadal's limit of Y/Q: `(tan g - mu) / (1 + mu tan g)` for the flange angle g [rad]; `None` where it guides nothing (g below the angle of friction).
pub fn nadal(angle: f64, friction: f64) -> Option<f64> {
    let limit = (angle - friction.atan()).tan();
    (limit > 0.0).then_some(limit)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_limits() {
        assert_eq!(sum_of_guiding_forces(120e3, VehicleKind::Passenger), 50e3);
        assert_eq!(sum_of_guiding_forces(120e3, VehicleKind::Freight), 42.5e3);
        let q = |load: f64, kmh: f64| (vertical_force(load * 1e3, kmh / 3.6) / 1e3).round();
        assert_eq!(
            [q(50.0, 120.0), q(112.5, 160.0), q(105.0, 200.0), q(95.0, 250.0), q(85.0, 300.0), q(85.0, 320.0)],
            [140.0, 200.0, 190.0, 180.0, 170.0, 160.0]
        );
        assert_eq!([q(125.0, 100.0), q(125.0, 120.0)], [210.0, 200.0]);
        // The textbook value: 70 degrees, mu = 0.36.
        let limit = nadal(70.0_f64.to_radians(), 0.36).unwrap();
        let tan = 70.0_f64.to_radians().tan();
        assert!((limit - (tan - 0.36) / (1.0 + 0.36 * tan)).abs() < 1e-12 && (limit - 1.2).abs() < 0.01, "{limit}");
        assert_eq!(nadal(0.1, 0.36), None);
    }

    #[test]
    fn prop_keys_are_different() {
        let keys = keys();
        assert!(keys.iter().all(|key| keys.iter().filter(|other| *other == key).count() == 1 && by_key(key).is_some()));
        assert!(ALL.iter().all(|quantity| quantity.name.chars().count() < 70));
    }
}
