//! All points as CSV: what the study is in `#` lines, then one row per point, coupled runs last.

use crate::study::accuracy::{Apart, COUPLING, Errors, FACTOR, HOLDS, Measured, Outcome, Quantity, Setting, Standing, Study};
use std::io::Write;

/// The columns.
pub(super) const HEADER: [&str; 44] = [
    "formulation",
    "integrator",
    "tolerance",
    "step",
    "error_y [m]",
    "error_N [N]",
    "cpu_per_simulated_second",
    "realtime_factor",
    "rhs",
    "newton",
    "rejected",
    "outcome",
    "error_y_rms [m]",
    "error_N_rms [N]",
    "error_N_95 [N]",
    "error_Q [N]",
    "error_Q_rms [N]",
    "error_Q_95 [N]",
    "error_YQ",
    "error_YQ_rms",
    "error_YQ_95",
    "error_acceleration [m/s2]",
    "error_acceleration_rms [m/s2]",
    "error_acceleration_95 [m/s2]",
    "error_wavelength [m]",
    "y_told",
    "Q_told",
    "N_told",
    "YQ_told",
    "acceleration_told",
    "wavelength_told",
    "steps",
    "linearisations",
    "factorisations",
    "search_iterations",
    "force_iterations",
    "constraint_iterations",
    "cpu_smallest",
    "cpu_largest",
    "repeats",
    "creep_law",
    "node_spacing [m]",
    "smoothing [m]",
    "communication_step [s]",
];

/// The processor's name, where the system tells it.
pub(super) fn machine() -> String {
    let known = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let name = known.lines().find_map(|line| line.strip_prefix("model name")?.split_once(':').map(|(_, name)| name.trim().to_string()));
    let cores = std::thread::available_parallelism().map_or(1, |cores| cores.get());
    format!("{}, {cores} cores, {} {}", name.unwrap_or_else(|| "unknown processor".into()), std::env::consts::OS, std::env::consts::ARCH)
}

/// Writes everything.
pub(super) fn write(mut writer: impl Write, study: &Study) -> std::io::Result<()> {
    let note = |writer: &mut dyn Write, key: &str, text: &str| writeln!(writer, "# {key}: {}", text.replace(['\n', '\r'], " "));
    note(&mut writer, "program", &format!("wheelrail {}", env!("CARGO_PKG_VERSION")))?;
    note(&mut writer, "machine", &machine())?;
    note(&mut writer, "scene", &format!("{} ({})", study.scene, study.title))?;
    note(
        &mut writer,
        "span",
        &format!("{} s, outputs every {} s, worst of {}", study.stop, study.step, study.wheelset.as_deref().unwrap_or("all wheelsets")),
    )?;
    note(&mut writer, "errors", "largest over the run, at output times that no step knows of; _95: 95 % of the samples are nearer; told: shown (FACTOR times the reference's uncertainty or more), below, useless (larger than the motion), absent".replace("FACTOR", &FACTOR.to_string()).as_str())?;
    note(&mut writer, "cost", "CPU seconds of one thread per simulated second, median of the repeated runs without outputs")?;
    for model in &study.models {
        let text = match &model.reference {
            Ok(reference) => format!(
                "{}: {} with {} and {} at tolerance {:e} m; uncertainty: y {:.1e} m, Q {:.1e} N, N {:.1e} N, YQ {:.1e}, acceleration {:.1e} m/s2{}",
                model.name,
                reference.formulation,
                reference.methods[0],
                reference.methods[1],
                reference.tolerance,
                reference.uncertainty.y.largest,
                reference.uncertainty.vertical.largest,
                reference.uncertainty.normal.largest,
                reference.uncertainty.quotient.largest,
                reference.uncertainty.acceleration.largest,
                wavelength(reference.uncertainty.wavelength)
            ),
            Err(reason) => format!("{}: none: {reason}", model.name),
        };
        note(&mut writer, "reference", &text)?;
    }
    for difference in &study.differences {
        let [first, second] = [difference.first, difference.second].map(|model| study.models[model].name.as_str());
        let part = |quantity: Quantity| match study.apart(difference, quantity)? {
            Apart::Told(apart) => Some(format!("{} {apart:.3e} {}", quantity.key(), quantity.unit()).trim_end().to_string()),
            Apart::Untold => Some(format!("{} not to be told from the references", quantity.key())),
        };
        let parts: Vec<String> = Quantity::ALL.into_iter().filter_map(part).collect();
        let text = format!("{first} against {second}: {}: no numerical error", parts.join(", "));
        note(&mut writer, "models", &text)?;
    }
    for text in &study.notes {
        note(&mut writer, "note", text)?;
    }
    if !study.coupled.is_empty() {
        note(&mut writer, "rows with a communication step", COUPLING)?;
    }
    let mut csv = csv::Writer::from_writer(writer);
    csv.write_record(HEADER)?;
    for point in &study.points {
        let variant = &study.variants[point.variant];
        let (outcome, done) = match &point.outcome {
            Outcome::Done { measured, errors } => ("ok".to_string(), Some((measured, errors))),
            Outcome::Failed(reason) => (format!("failed: {reason}"), None),
            Outcome::Skipped(reason) => (format!("not run: {reason}"), None),
        };
        let told = Quantity::ALL.map(|quantity| done.map_or("", |_| told(study.standing(point, quantity))));
        let own =
            [variant.creep_law.map(String::from).unwrap_or_default(), some(variant.node_spacing), some(variant.smoothing), String::new()];
        csv.write_record(row(variant.formulation, &point.setting, &outcome, done, told, own))?;
    }
    for coupled in &study.coupled {
        let told = if coupled.errors.y.largest < coupled.floor { "below" } else { "shown" };
        let own = [String::new(), String::new(), String::new(), format!("{:?}", coupled.step)];
        let outcome = format!("ok, input {}", HOLDS[coupled.hold]);
        csv.write_record(row(
            coupled.formulation,
            &coupled.setting,
            &outcome,
            Some((&coupled.measured, &coupled.errors)),
            [told, "", "", "", "", ""],
            own,
        ))?;
    }
    csv.flush()
}

fn told(standing: Standing) -> &'static str {
    match standing {
        Standing::Shown(_) => "shown",
        Standing::Below(_) => "below",
        Standing::Useless => "useless",
        Standing::Absent => "absent",
    }
}

/// Behind other quantities.
fn wavelength(value: Option<f64>) -> String {
    value.map(|value| format!(", wavelength {value:.1e} m")).unwrap_or_default()
}

fn some(value: Option<f64>) -> String {
    value.map(|value| format!("{value:?}")).unwrap_or_default()
}

fn row(
    formulation: &str,
    setting: &Setting,
    outcome: &str,
    done: Option<(&Measured, &Errors)>,
    told: [&str; 6],
    own: [String; 4],
) -> Vec<String> {
    let number = |value: &dyn Fn(&Measured, &Errors) -> f64| {
        done.map(|(measured, errors)| format!("{:?}", value(measured, errors))).unwrap_or_default()
    };
    let count = |value: &dyn Fn(&Measured) -> u64| done.map(|(measured, _)| value(measured).to_string()).unwrap_or_default();
    let mut row = vec![formulation.to_string(), setting.integrator.to_string(), some(setting.tolerance()), some(setting.step())];
    row.extend([
        number(&|_, errors| errors.y.largest),
        number(&|_, errors| errors.normal.largest),
        number(&|measured, _| measured.median()),
        number(&|measured, _| 1.0 / measured.median()),
        count(&|measured| measured.statistics.evaluations),
        count(&|measured| measured.statistics.iterations),
        count(&|measured| measured.statistics.rejected),
        outcome.to_string(),
        number(&|_, errors| errors.y.rms),
        number(&|_, errors| errors.normal.rms),
        number(&|_, errors| errors.normal.most),
        number(&|_, errors| errors.vertical.largest),
        number(&|_, errors| errors.vertical.rms),
        number(&|_, errors| errors.vertical.most),
        number(&|_, errors| errors.quotient.largest),
        number(&|_, errors| errors.quotient.rms),
        number(&|_, errors| errors.quotient.most),
        number(&|_, errors| errors.acceleration.largest),
        number(&|_, errors| errors.acceleration.rms),
        number(&|_, errors| errors.acceleration.most),
        some(done.and_then(|(_, errors)| errors.wavelength)),
    ]);
    row.extend(told.map(String::from));
    row.extend([
        count(&|measured| measured.statistics.steps),
        count(&|measured| measured.statistics.linearisations),
        count(&|measured| measured.statistics.factorisations),
        count(&|measured| measured.work.search_iterations),
        count(&|measured| measured.work.force_iterations),
        count(&|measured| measured.work.constraint_iterations),
        number(&|measured, _| measured.spread().0),
        number(&|measured, _| measured.spread().1),
        count(&|measured| measured.cpu.len() as u64),
    ]);
    row.extend(own);
    row
}
