//! All points as CSV: what the study is in `#` lines, then one row per point, coupled runs last.

use crate::study::accuracy::{Apart, COUPLING, Errors, FACTOR, HOLDS, Measured, Outcome, Quantity, Setting, Standing, Study};
use std::io::Write;

/// What stands in a row.
struct Row<'a> {
    formulation: &'a str,
    setting: &'a Setting,
    outcome: String,
    done: Option<(&'a Measured, &'a Errors)>,
    /// Of each quantity: shown, below, useless, absent.
    told: [&'a str; 6],
    /// Creep law, node spacing, smoothing, communication step.
    own: [String; 4],
}

/// A column: name and cell.
enum Cell {
    Words(fn(&Row) -> String),
    /// Of a run that came to its end.
    Number(fn(&Measured, &Errors) -> f64),
    Count(fn(&Measured) -> u64),
}

use Cell::{Count, Number, Words};

const COLUMNS: [(&str, Cell); 44] = [
    ("formulation", Words(|row| row.formulation.into())),
    ("integrator", Words(|row| row.setting.integrator.into())),
    ("tolerance", Words(|row| some(row.setting.tolerance()))),
    ("step", Words(|row| some(row.setting.step()))),
    ("error_y [m]", Number(|_, errors| errors.y.largest)),
    ("error_N [N]", Number(|_, errors| errors.normal.largest)),
    ("cpu_per_simulated_second", Number(|measured, _| measured.median())),
    ("realtime_factor", Number(|measured, _| 1.0 / measured.median())),
    ("rhs", Count(|measured| measured.statistics.evaluations)),
    ("newton", Count(|measured| measured.statistics.iterations)),
    ("rejected", Count(|measured| measured.statistics.rejected)),
    ("outcome", Words(|row| row.outcome.clone())),
    ("error_y_rms [m]", Number(|_, errors| errors.y.rms)),
    ("error_N_rms [N]", Number(|_, errors| errors.normal.rms)),
    ("error_N_95 [N]", Number(|_, errors| errors.normal.most)),
    ("error_Q [N]", Number(|_, errors| errors.vertical.largest)),
    ("error_Q_rms [N]", Number(|_, errors| errors.vertical.rms)),
    ("error_Q_95 [N]", Number(|_, errors| errors.vertical.most)),
    ("error_YQ", Number(|_, errors| errors.quotient.largest)),
    ("error_YQ_rms", Number(|_, errors| errors.quotient.rms)),
    ("error_YQ_95", Number(|_, errors| errors.quotient.most)),
    ("error_acceleration [m/s2]", Number(|_, errors| errors.acceleration.largest)),
    ("error_acceleration_rms [m/s2]", Number(|_, errors| errors.acceleration.rms)),
    ("error_acceleration_95 [m/s2]", Number(|_, errors| errors.acceleration.most)),
    ("error_wavelength [m]", Words(|row| some(row.done.and_then(|done| done.1.wavelength)))),
    ("y_told", Words(|row| row.told[0].into())),
    ("Q_told", Words(|row| row.told[1].into())),
    ("N_told", Words(|row| row.told[2].into())),
    ("YQ_told", Words(|row| row.told[3].into())),
    ("acceleration_told", Words(|row| row.told[4].into())),
    ("wavelength_told", Words(|row| row.told[5].into())),
    ("steps", Count(|measured| measured.statistics.steps)),
    ("linearisations", Count(|measured| measured.statistics.linearisations)),
    ("factorisations", Count(|measured| measured.statistics.factorisations)),
    ("search_iterations", Count(|measured| measured.work.search_iterations)),
    ("force_iterations", Count(|measured| measured.work.force_iterations)),
    ("constraint_iterations", Count(|measured| measured.work.constraint_iterations)),
    ("cpu_smallest", Number(|measured, _| measured.spread().0)),
    ("cpu_largest", Number(|measured, _| measured.spread().1)),
    ("repeats", Count(|measured| measured.cpu.len() as u64)),
    ("creep_law", Words(|row| row.own[0].clone())),
    ("node_spacing [m]", Words(|row| row.own[1].clone())),
    ("smoothing [m]", Words(|row| row.own[2].clone())),
    ("communication_step [s]", Words(|row| row.own[3].clone())),
];

impl Row<'_> {
    fn cell(&self, (_, cell): &(&str, Cell)) -> String {
        match cell {
            Words(words) => words(self),
            Number(number) => self.done.map(|(measured, errors)| format!("{:?}", number(measured, errors))).unwrap_or_default(),
            Count(count) => self.done.map(|(measured, _)| count(measured).to_string()).unwrap_or_default(),
        }
    }
}

/// The processor's name, where the system tells it.
pub(super) fn machine() -> String {
    let known = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let name = known.lines().find_map(|line| line.strip_prefix("model name")?.split_once(':').map(|(_, name)| name.trim().to_string()));
    let cores = std::thread::available_parallelism().map_or(1, |cores| cores.get());
    format!("{}, {cores} cores, {} {}", name.unwrap_or_else(|| "unknown processor".into()), std::env::consts::OS, std::env::consts::ARCH)
}

/// Writes everything.
pub(super) fn write(mut writer: impl Write, study: &Study) -> std::io::Result<()> {
    for (key, text) in notes(study) {
        writeln!(writer, "# {key}: {}", text.replace(['\n', '\r'], " "))?;
    }
    let mut csv = csv::Writer::from_writer(writer);
    csv.write_record(COLUMNS.iter().map(|column| column.0))?;
    for point in &study.points {
        let variant = &study.variants[point.variant];
        let outcome = match &point.outcome {
            Outcome::Done { .. } => "ok".to_string(),
            Outcome::Failed(reason) => format!("failed: {reason}"),
            Outcome::Skipped(reason) => format!("not run: {reason}"),
        };
        let done = Study::done(point);
        let told = Quantity::ALL.map(|quantity| done.map_or("", |_| told(study.standing(point, quantity))));
        let own =
            [variant.creep_law.map(String::from).unwrap_or_default(), some(variant.node_spacing), some(variant.smoothing), String::new()];
        let row = Row { formulation: variant.formulation, setting: &point.setting, outcome, done, told, own };
        csv.write_record(COLUMNS.iter().map(|column| row.cell(column)))?;
    }
    for coupled in &study.coupled {
        let told = [if coupled.errors.y.largest < coupled.floor { "below" } else { "shown" }, "", "", "", "", ""];
        let own = [String::new(), String::new(), String::new(), format!("{:?}", coupled.step)];
        let (outcome, done) = (format!("ok, input {}", HOLDS[coupled.hold]), Some((&coupled.measured, &coupled.errors)));
        let row = Row { formulation: coupled.formulation, setting: &coupled.setting, outcome, done, told, own };
        csv.write_record(COLUMNS.iter().map(|column| row.cell(column)))?;
    }
    csv.flush()
}

/// What the study is, in the order of its `#` lines.
fn notes(study: &Study) -> Vec<(&'static str, String)> {
    let whose = study.wheelset.as_deref().unwrap_or("all wheelsets");
    let mut all = vec![
        ("program", format!("wheelrail {}", env!("CARGO_PKG_VERSION"))),
        ("machine", machine()),
        ("scene", format!("{} ({})", study.scene, study.title)),
        ("span", format!("{} s, outputs every {} s, worst of {whose}", study.stop, study.step)),
        (
            "errors",
            format!(
                "largest over the run, at output times that no step knows of; _95: 95 % of the samples are nearer; told: shown ({FACTOR} times the \
                 reference's uncertainty or more), below, useless (larger than the motion), absent"
            ),
        ),
        ("cost", "CPU seconds of one thread per simulated second, median of the repeated runs without outputs".into()),
    ];
    for model in &study.models {
        let words = match &model.reference {
            Ok(reference) => {
                let sure = |quantity: Quantity| {
                    let value = reference.uncertainty.of(quantity)?;
                    Some(format!("{} {value:.1e} {}", quantity.key(), quantity.unit()).trim_end().to_string())
                };
                let uncertainty: Vec<String> = Quantity::ALL.into_iter().filter_map(sure).collect();
                let (formulation, [first, second], tolerance) = (reference.formulation, reference.methods, reference.tolerance);
                format!("{formulation} with {first} and {second} at tolerance {tolerance:e} m; uncertainty: {}", uncertainty.join(", "))
            }
            Err(reason) => format!("none: {reason}"),
        };
        all.push(("reference", format!("{}: {words}", model.name)));
    }
    for difference in &study.differences {
        let [first, second] = [difference.first, difference.second].map(|model| study.models[model].name.as_str());
        let part = |quantity: Quantity| match study.apart(difference, quantity)? {
            Apart::Told(apart) => Some(format!("{} {apart:.3e} {}", quantity.key(), quantity.unit()).trim_end().to_string()),
            Apart::Untold => Some(format!("{} not to be resolved from the references", quantity.key())),
        };
        let parts: Vec<String> = Quantity::ALL.into_iter().filter_map(part).collect();
        all.push(("models", format!("{first} against {second}: {}: no numerical error", parts.join(", "))));
    }
    all.extend(study.notes.iter().map(|note| ("note", note.clone())));
    if !study.coupled.is_empty() {
        all.push(("rows with a communication step", COUPLING.into()));
    }
    all
}

fn told(standing: Standing) -> &'static str {
    match standing {
        Standing::Shown(_) => "shown",
        Standing::Below(_) => "below",
        Standing::Useless => "useless",
        Standing::Absent => "absent",
    }
}

fn some(value: Option<f64>) -> String {
    value.map(|value| format!("{value:?}")).unwrap_or_default()
}
