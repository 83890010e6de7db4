//! The FMU through its C interface: fmpy as the master, a C host, and a comparison with native runs bit by bit.
//!
//! The tests make their own Python environment under target/ from pinned packages.

#[path = "../common/mod.rs"]
mod common;
mod examples;
mod packaging;
mod results;
mod three;
mod tutorial;

use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::{LazyLock, OnceLock};
use wheelrail::fmi::description;
use wheelrail::fmi::ffi::host::LoadedFmu;
use wheelrail::fmi::instance::{Instance, StepOutcome};
use wheelrail::fmi::package;
use wheelrail::fmi::uri;
use wheelrail::formulation::{DRIVE_TORQUE, LATERAL_FORCE, LEFT_FRICTION};
use wheelrail::scene::spec::Scene;
use wheelrail::scene::{embedded, load};

const ROOT: &str = env!("CARGO_MANIFEST_DIR");

fn run(command: &mut Command) -> String {
    let shown = format!("{command:?}");
    let output = command.output().unwrap_or_else(|error| panic!("{shown}: {error}"));
    let text = format!("{}{}", String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(output.status.success(), "{shown} failed:\n{text}");
    text
}

/// The folder that holds everything the tests make.
fn scratch() -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).to_path_buf();
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

/// Python of the tests' own environment; made once per set of pinned packages.
fn python() -> &'static Path {
    static PYTHON: OnceLock<PathBuf> = OnceLock::new();
    PYTHON.get_or_init(|| {
        let requirements = Path::new(ROOT).join("tests/fmu/requirements.txt");
        let folder = scratch().join("python");
        let program = folder.join(if cfg!(windows) { "Scripts/python.exe" } else { "bin/python" });
        let stamp = folder.join("installed.txt");
        let wanted = std::fs::read(&requirements).unwrap();
        if std::fs::read(&stamp).ok().as_deref() != Some(&wanted) {
            let _ = std::fs::remove_dir_all(&folder);
            let system = if cfg!(windows) { "python" } else { "python3" };
            let old = "import sys; sys.exit(0 if sys.version_info >= (3, 11) else 'the FMU tests need Python 3.11 or newer, found ' + sys.version)";
            run(Command::new(system).args(["-c", old]));
            run(Command::new(system).args(["-m", "venv"]).arg(&folder));
            run(Command::new(&program).args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check", "-r"]).arg(&requirements));
            std::fs::write(&stamp, wanted).unwrap();
        }
        program
    })
}

/// The exported FMU, unpacked beside it.
struct Fmu {
    /// Of the scene.
    name: String,
    file: PathBuf,
    folder: PathBuf,
    guid: String,
}

impl Fmu {
    fn library(&self) -> PathBuf {
        let name = format!("{}{}", self.name, std::env::consts::DLL_SUFFIX);
        self.folder.join("binaries").join(package::platform()).join(name)
    }
    fn resources(&self) -> String {
        uri::from_path(&self.folder.join("resources"))
    }
}

fn export(scene: &str, file: &Path) -> String {
    export_changed(scene, &[], file)
}

fn export_changed(scene: &str, changes: &[&str], file: &Path) -> String {
    let mut command = Command::new(env!("CARGO_BIN_EXE_wheelrail"));
    command.args(["export", scene, "--check", "full"]).args(changes.iter().flat_map(|change| ["--set", change]));
    run(command.arg("-o").arg(file))
}

static FMU: LazyLock<Fmu> = LazyLock::new(|| {
    let folder = scratch().join("fmu");
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    let file = folder.join("suspended_wheelset.fmu");
    let text = export("suspended_wheelset", &file);
    assert!(text.contains("FMI 2.0 co-simulation") && text.contains("200.0"), "{text}");
    let unpacked = folder.join("unpacked");
    let mut archive = zip::ZipArchive::new(std::fs::File::open(&file).unwrap()).unwrap();
    archive.extract(&unpacked).unwrap();
    let packed = package::pack_scene(&load::open("suspended_wheelset", &[]).unwrap()).unwrap();
    Fmu { name: "suspended_wheelset".into(), file, folder: unpacked, guid: packed.description.guid }
});

/// The shipped scene with a formulation each.
const FORMULATIONS: [(&str, &[&str]); 4] = [
    ("ACCF", &["contact.formulation=ACCF"]),
    ("ECCF", &["contact.formulation=ECCF"]),
    ("ECF-A", &["contact.formulation=ECF-A"]),
    ("ECF-N", &["contact.formulation=ECF-N"]),
];

/// A dip of the right rail that its wheel can't follow.
const DIP: [&str; 3] = ["track.deviation[1].direction=vertical", "track.deviation[1].amplitude=-25 mm", "track.deviation[1].to=23"];

/// A constraint formulation in the dip. A lift-off that ends the run would end the check of the export too: it stops before.
fn dip(formulation: &'static str, on_lift: &'static str) -> Vec<&'static str> {
    let mut changes = DIP.to_vec();
    changes.push(formulation);
    changes.extend(if on_lift == "stop" { ["contact.on_lift=stop", "run.stop=0.4"] } else { ["contact.on_lift=elastic", "run.stop=1.0"] });
    changes
}

/// The FMU of the shipped scene with changes, as `FOLDER/NAME.fmu` and unpacked.
fn changed_fmu(folder: &Path, name: &str, changes: &[&str]) -> Fmu {
    scene_fmu(folder, name, "suspended_wheelset", changes).1
}

/// A scene with changes, and its FMU as `FOLDER/NAME.fmu` and unpacked.
fn scene_fmu(folder: &Path, name: &str, scene: &str, changes: &[&str]) -> (Scene, Fmu) {
    let file = folder.join(format!("{name}.fmu"));
    export_changed(scene, changes, &file);
    let unpacked = folder.join(name);
    zip::ZipArchive::new(std::fs::File::open(&file).unwrap()).unwrap().extract(&unpacked).unwrap();
    let scene = changed(scene, changes);
    let guid = package::pack_scene(&scene).unwrap().description.guid;
    let fmu = Fmu { name: scene.name.clone(), file, folder: unpacked, guid };
    (scene, fmu)
}

/// An embedded scene with changes.
fn changed(scene: &str, changes: &[&str]) -> Scene {
    let changes: Vec<String> = changes.iter().map(|change| (*change).to_string()).collect();
    load::open(scene, &changes).unwrap()
}

/// The files of an FMU.
fn unpacked(file: &Path) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    zip::ZipArchive::new(std::fs::File::open(file).unwrap()).unwrap().extract(folder.path()).unwrap();
    folder
}

/// A wheelset with flanges that tests push about.
fn flange_scene() -> String {
    common::data("scenes/apta_flange.toml").to_str().unwrap().into()
}

fn script(name: &str, extra: &[&OsStr]) {
    let script = Path::new(ROOT).join("tests/fmu").join(name);
    let text = run(Command::new(python()).arg("-B").arg(script).arg(&FMU.file).args(extra));
    println!("{text}");
    assert!(text.lines().last().is_some_and(|line| line.ends_with(" 0 failed")), "{text}");
}

#[test]
fn fmu_description_and_archive_pass_fmpy_and_the_toolbox() {
    let second = FMU.file.with_file_name("second.fmu");
    export("suspended_wheelset", &second);
    assert_eq!(std::fs::read(&FMU.file).unwrap(), std::fs::read(&second).unwrap(), "the same scene gives the same bytes");
    script("check_description.py", &[second.as_os_str()]);
}

#[test]
fn fmu_fmpy_simulates_it() {
    script("simulate.py", &[]);
}

#[test]
fn fmu_communication_steps_and_input_derivatives() {
    script("communication.py", &[]);
}

#[test]
fn fmu_states_reset_and_two_instances() {
    script("states.py", &[]);
}

#[test]
fn fmu_parameters_tuned_during_a_run() {
    script("tuning.py", &[]);
}

#[test]
fn fmu_coupled_with_external_traction_and_brake() {
    script("coupling.py", &[]);
}

#[test]
fn fmu_coupled_with_a_model_of_the_track() {
    let folder = tempfile::tempdir().unwrap();
    let changes = ["interface.inputs=[\"rail_motion\", \"centre_forces\"]"];
    let fmu = changed_fmu(folder.path(), "rails", &changes);
    script("rails.py", &[fmu.file.as_os_str()]);
}

#[test]
fn fmu_sweep_on_dask_loses_nothing_with_a_killed_worker() {
    let folder = tempfile::tempdir().unwrap();
    let native = folder.path().join("native.csv");
    let mut sweep = Command::new(env!("CARGO_BIN_EXE_wheelrail"));
    sweep.args(["sweep", "suspended_wheelset", "--set", "contact.friction=0.2..0.5:0.02", "--set", "vehicle.initial.y=0,0.001,0.002"]);
    sweep.args(["--scalar", "max:*.derailmentQuotient", "--scalar", "rms:wheelset.y", "--scalar", "min:*.verticalForce"]);
    sweep.args(["--scalar", "p99.85:wheelset.*.lateralForce", "--stop", "0.5", "--step", "0.005", "-o"]);
    run(sweep.arg(&native));
    script("dask_cluster.py", &[native.as_os_str(), Path::new(ROOT).join("examples/sweep_dask.py").as_os_str()]);
}

#[test]
fn fmu_bad_calls_from_python() {
    script("bad_calls.py", &[]);
}

#[test]
fn fmu_output_derivatives() {
    script("derivatives.py", &[]);
}

#[test]
fn fmu_every_formulation() {
    let folder = tempfile::tempdir().unwrap();
    for (name, changes) in FORMULATIONS {
        export_changed("suspended_wheelset", changes, &folder.path().join(format!("{name}.fmu")));
    }
    for (name, changes) in &FORMULATIONS[..2] {
        for on_lift in ["stop", "elastic"] {
            export_changed("suspended_wheelset", &dip(changes[0], on_lift), &folder.path().join(format!("{name}-{on_lift}.fmu")));
        }
    }
    script("formulations.py", &[folder.path().as_os_str()]);
}

#[test]
fn fmu_brakes_to_a_standstill_holds_and_drives_off() {
    let file = scratch().join("wheelset_standstill.fmu");
    export("wheelset_standstill", &file);
    script("standstill.py", &[file.as_os_str()]);
    let script = Path::new(ROOT).join("tests/fmu/check_description.py");
    let text = run(Command::new(python()).arg("-B").arg(script).arg(&file));
    assert!(text.contains(" 0 failed"), "{text}");
}

#[test]
fn fmu_flange_contact_and_derailment() {
    let folder = tempfile::tempdir().unwrap();
    let cases: [(&str, &[&str]); 3] = [
        ("ECF-A", &["contact.formulation=ECF-A"]),
        ("ECCF", &["contact.formulation=ECCF", "contact.on_lift=elastic"]),
        ("ECCF-stop", &["contact.formulation=ECCF", "contact.on_lift=stop"]),
    ];
    for (name, changes) in cases {
        export_changed(&flange_scene(), changes, &folder.path().join(format!("{name}.fmu")));
    }
    script("derailment.py", &[folder.path().as_os_str()]);
}

/// Runs a scene natively and as FMU through the same sequence of (time, step) pairs, steps uneven on purpose; returns the number
/// of steps in which wheels lifted off or landed, and how often contacts beside the first began or ended.
fn native_run_is_the_same(scene: &Scene, fmu: &Fmu, stop: f64) -> (usize, usize) {
    let packed = package::pack_scene(scene).unwrap();
    let references: Vec<u32> = packed.table.outputs.iter().map(|output| output.reference).collect();
    let mut fmu = LoadedFmu::start(&fmu.library(), &fmu.guid, &fmu.resources()).unwrap();
    let mut native = common::start(scene);
    let outputs = common::table(&native, scene);
    let (mut time, mut rows, mut warnings, mut others) = (0.0, 0, 0, 0);
    while time < stop {
        let step = [0.001, 0.00237, 0.01, 0.0005][rows % 4];
        // Inputs change too: steps of torque and force, a ramp and a parabola.
        let change = [(30, DRIVE_TORQUE, [800.0, 0.0, 0.0]), (90, LATERAL_FORCE, [0.0, 4e3, 2e3]), (200, LEFT_FRICTION, [0.5, 0.0, 0.0])];
        for (at, input, [value, first, second]) in change {
            if rows == at {
                let reference = 1001 + input as u32;
                fmu.set_real(reference, value).unwrap();
                if first != 0.0 {
                    fmu.set_input_derivatives(reference, first, second).unwrap();
                    native.set_input(input, value, 0.0, 0.0);
                }
                native.set_input(input, value, first, second);
            }
        }
        let warned = fmu.do_step(time, step).unwrap();
        time += step;
        native.advance(time).unwrap();
        let (lifts, others_now): (Vec<_>, Vec<_>) = native.take_events().into_iter().partition(|event| event.change.changes_mode());
        assert_eq!(warned, !lifts.is_empty(), "the FMU warns of lift-offs and landings, at t = {time}");
        others += others_now.len();
        warnings += usize::from(warned);
        rows += 1;
        let theirs = fmu.get_real(&references).unwrap();
        let snapshot = native.snapshot().unwrap();
        for (output, theirs) in outputs.iter().zip(theirs) {
            assert_eq!(output.value(snapshot).to_bits(), theirs.to_bits(), "{output:?} at t = {time}");
        }
    }
    assert!(rows > 210 && native.statistics().restarts + native.statistics().taken_up >= 3, "every change must have been made");
    println!(
        "{} {}: {rows} steps, {} outputs, all equal to the last bit, {warnings} warnings, {others} begins and ends",
        scene.name,
        scene.contact.formulation_name,
        outputs.len()
    );
    (warnings, others)
}

#[test]
fn fmu_native_run_is_the_same_to_the_last_bit() {
    let scene = load::open("suspended_wheelset", &[]).unwrap();
    assert_eq!(native_run_is_the_same(&scene, &FMU, 1.5), (0, 0));
}

#[test]
fn fmu_native_run_is_the_same_to_the_last_bit_in_every_formulation() {
    let folder = tempfile::tempdir().unwrap();
    // Twelve states of the wheelset, and two contacts' own.
    for ((name, changes), states) in FORMULATIONS.iter().zip([12 + 16, 12, 12, 12 + 2]) {
        let scene = common::scene(changes);
        assert_eq!(common::start(&scene).model().dimension(), states, "{name}");
        assert_eq!(native_run_is_the_same(&scene, &changed_fmu(folder.path(), name, changes), 0.8), (0, 0), "{name}");
    }
    for (name, changes) in &FORMULATIONS[..2] {
        let changes = dip(changes[0], "elastic");
        let fmu = changed_fmu(folder.path(), &format!("{name}-elastic"), &changes);
        assert_eq!(native_run_is_the_same(&common::scene(&changes), &fmu, 0.8), (2, 0), "{name}: a lift-off and a landing");
    }
}

#[test]
fn fmu_a_vehicle_cut_to_a_truck_or_a_wheelset_runs_as_natively() {
    let folder = tempfile::tempdir().unwrap();
    for (level, bodies) in [("truck", 3), ("wheelset", 1)] {
        let changes = [format!("vehicle.detail={level}"), "vehicle.travel=free".into()];
        let changes: Vec<&str> = changes.iter().map(String::as_str).collect();
        let (scene, fmu) = scene_fmu(folder.path(), level, "vehicle_manchester_1", &changes);
        assert_eq!(scene.vehicle.body_count(), bodies);
        let text = std::fs::read_to_string(fmu.folder.join("modelDescription.xml")).unwrap();
        assert!(text.contains("truck[1].wheelset[1].y\"") && !text.contains("truck[2]") && !text.contains("\"car."), "{level}");
        native_run_is_the_same(&scene, &fmu, 0.8);
    }
}

#[test]
fn fmu_native_run_is_the_same_to_the_last_bit_with_several_contacts_and_at_low_speed() {
    let folder = tempfile::tempdir().unwrap();
    let apta = flange_scene();
    // On the grade it stops, rolls back and is driven on; the wheelset with flanges is thrown against them.
    let cases: &[(&str, &str, &[&str], usize)] = &[
        ("s1002", "wheelset_s1002", &[], 0),
        ("standstill", "wheelset_standstill", &["vehicle.speed=0.02"], 0),
        ("standstill_ECCF", "wheelset_standstill", &["vehicle.speed=0.02", "contact.formulation=ECCF"], 0),
        ("flange", &apta, &["vehicle.initial.vy=1"], 2),
        ("flange_ECCF", &apta, &["vehicle.initial.vy=1", "contact.formulation=ECCF", "contact.on_lift=elastic"], 2),
    ];
    for (name, scene, changes, least) in cases {
        let (scene, fmu) = scene_fmu(folder.path(), name, scene, changes);
        let (warnings, others) = native_run_is_the_same(&scene, &fmu, 0.8);
        // Thrown so hard, a wheel of rigid contact lifts off.
        assert!(
            (warnings == 0) != changes.contains(&"contact.on_lift=elastic") && others >= *least,
            "{name}: {warnings} warnings, {others} begins and ends of contacts"
        );
    }
}

/// Every embedded scene: the trajectory of the native run to the last bit, a description that fmpy accepts, and steps that fmpy takes.
#[test]
fn fmu_every_embedded_scene_runs_as_natively_and_under_fmpy() {
    let folder = tempfile::tempdir().unwrap();
    let made: Vec<(bool, PathBuf)> = embedded::SCENES
        .iter()
        .map(|embedded| {
            let (scene, fmu) = scene_fmu(folder.path(), embedded.name, embedded.name, &["run.stop=0.2"]);
            native_run_is_the_same(&scene, &fmu, 0.8);
            (!scene.vehicle.is_lone(), fmu.file)
        })
        .collect();
    let several = made.iter().filter(|(several, _)| *several).map(|(_, file)| file);
    // Python starts once: its packages take longer to load than an FMU to check.
    let check = "import sys; sys.path.insert(0, sys.argv.pop(1)); import check_description, common\n\
                 for file in sys.argv[1:]: report = common.Report(); check_description.script(report, file); print('\\n', report.failed, 'failed')";
    let found = run(Command::new(python()).args(["-B", "-c", check]).arg(Path::new(ROOT).join("tests/fmu")).args(several.clone()));
    assert_eq!(found.matches(" 0 failed").count(), several.count(), "{found}");
    let steps = "import sys, fmpy, fmpy.validation\n\
                 for file in sys.argv[1:]:\n \
                 problems = fmpy.validation.validate_fmu(file); assert not problems, problems\n \
                 print(len(fmpy.simulate_fmu(file, stop_time=0.2, output_interval=0.02)), 'rows')";
    let found = run(Command::new(python()).args(["-c", steps]).args(made.iter().map(|(_, file)| file)));
    assert_eq!(found.matches("11 rows").count(), made.len(), "{found}");
}

/// The folder of the official FMI 2.0 headers in the fmpy package.
fn headers() -> PathBuf {
    let text = run(Command::new(python()).args(["-c", "import fmpy, os; print(os.path.join(os.path.dirname(fmpy.__file__), 'c-code'))"]));
    PathBuf::from(text.trim())
}

/// The C host, compiled against the official headers.
fn c_host() -> &'static Path {
    static HOST: OnceLock<PathBuf> = OnceLock::new();
    HOST.get_or_init(|| {
        let program = scratch().join("fmi2_host");
        let target = env!("WHEELRAIL_TARGET");
        let compiler =
            cc::Build::new().target(target).host(target).opt_level(2).debug(true).out_dir(scratch()).cargo_metadata(false).get_compiler();
        let mut command = compiler.to_command();
        command.args(["-std=c11", "-Wall", "-Wextra", "-Werror", "-I"]).arg(headers());
        command.arg(Path::new(ROOT).join("fmu/host/fmi2_host.c")).arg("-o").arg(&program).args(["-ldl", "-lpthread", "-lm"]);
        run(&mut command);
        program
    })
}

/// The variable list that the C host reads.
fn variable_list() -> &'static Path {
    static LIST: OnceLock<PathBuf> = OnceLock::new();
    LIST.get_or_init(|| {
        let packed = package::pack_scene(&load::open("suspended_wheelset", &[]).unwrap()).unwrap();
        let lines: Vec<String> = packed
            .table
            .variables
            .iter()
            .map(|variable| {
                let causality = if variable.is_tunable() { "tunable" } else { variable.causality };
                format!("{} {} {:?} {causality}\n", variable.name, variable.reference, variable.kind)
            })
            .collect();
        let file = scratch().join("variables.txt");
        std::fs::write(&file, lines.concat()).unwrap();
        file
    })
}

fn host_arguments(mode: &str, extra: &[&str]) -> Vec<std::ffi::OsString> {
    let mut arguments: Vec<std::ffi::OsString> =
        vec![mode.into(), FMU.library().into(), FMU.resources().into(), FMU.guid.clone().into(), variable_list().into()];
    arguments.extend(extra.iter().map(Into::into));
    arguments
}

fn c_host_mode(mode: &str, extra: &[&str]) {
    let text = run(Command::new(c_host()).args(host_arguments(mode, extra)));
    assert!(!text.contains("FAIL") && text.contains(" 0 failed"), "{text}");
    println!("{}", text.lines().last().unwrap_or_default());
}

#[test]
fn fmu_c_host_abi() {
    let categories: Vec<&str> = description::LOG_CATEGORIES.iter().map(|category| category.0).collect();
    c_host_mode("abi", &categories);
}

#[test]
fn fmu_c_host_bad_calls() {
    c_host_mode("bad", &[]);
}

#[test]
fn fmu_c_host_states() {
    c_host_mode("states", &[]);
}

#[test]
fn fmu_c_host_threads() {
    c_host_mode("threads", &["8"]);
}

#[test]
fn fmu_c_host_resource_uris() {
    c_host_mode("urls", &[]);
}

/// A C99 hexadecimal float as `%a` writes it.
fn hex_float(text: &str) -> f64 {
    let (sign, rest) = text.strip_prefix('-').map_or((1.0, text), |rest| (-1.0, rest));
    let (digits, exponent) = rest.trim_start_matches("0x").split_once('p').unwrap_or_else(|| panic!("not a hex float: {text}"));
    let (whole, fraction) = digits.split_once('.').unwrap_or((digits, ""));
    let mantissa = u64::from_str_radix(&format!("{whole}{fraction}"), 16).unwrap();
    let exponent: i32 = exponent.parse::<i32>().unwrap() - 4 * fraction.len() as i32;
    // Two exact powers, so that neither overflows.
    sign * mantissa as f64 * 2f64.powi(exponent / 2) * 2f64.powi(exponent - exponent / 2)
}

#[test]
fn fmu_c_host_run_with_parameters_is_the_native_run_to_the_last_bit() {
    let (steps, out) = (scratch().join("steps.txt"), scratch().join("c_host.csv"));
    let pairs: Vec<(f64, f64)> = (0..100)
        .scan(0.0, |time, i| {
            let pair = (*time, [0.004, 0.0071, 0.01][i % 3]);
            *time = pair.0 + pair.1;
            Some(pair)
        })
        .collect();
    std::fs::write(&steps, pairs.iter().map(|(time, step)| format!("{time:?} {step:?}\n")).collect::<String>()).unwrap();
    let values = ["wheelset.mass=1700", "wheelset.initial.y=0.001", "wheelset.driveTorque=500"];
    let mut extra = vec![steps.to_str().unwrap(), out.to_str().unwrap()];
    extra.extend(values);
    run(Command::new(c_host()).args(host_arguments("csv", &extra)));

    let mut scene = common::scene(&[]);
    scene.vehicle.wheelsets[0].spec.mass = 1700.0;
    scene.vehicle.initial.values[1] = 0.001;
    let mut native = common::start(&scene);
    native.set_input(DRIVE_TORQUE, 500.0, 0.0, 0.0);
    let outputs = common::table(&native, &scene);
    let text = std::fs::read_to_string(&out).unwrap();
    let mut lines = text.lines();
    let names: Vec<&str> = lines.next().unwrap().split(',').map(|name| name.trim_matches('"')).collect();
    let mut compared = 0;
    for (row, line) in lines.enumerate() {
        if row > 0 {
            let (time, step) = pairs[row - 1];
            native.advance(time + step).unwrap();
        }
        let snapshot = native.snapshot().unwrap();
        for (name, cell) in names.iter().zip(line.split(',')) {
            if let Some(output) = outputs.iter().find(|output| output.name == *name) {
                assert_eq!(
                    hex_float(cell).to_bits(),
                    output.value(snapshot).to_bits(),
                    "{name} in row {row}: {cell} {}",
                    output.value(snapshot)
                );
                compared += 1;
            }
        }
    }
    assert_eq!(compared, 101 * outputs.len());
}

#[test]
fn fmu_c_host_benchmark_runs() {
    // Prints the cost per simulated second through C; nothing about time is asserted.
    for step in ["0.01", "0.001"] {
        let text = run(Command::new(c_host()).args(host_arguments("bench", &[step, "5"])));
        for line in text.lines().filter(|line| line.starts_with("bench step")) {
            println!("{line}");
        }
        assert!(text.contains("cpu_seconds_per_simulated_second"), "{text}");
    }
}

#[test]
fn fmu_c_host_damaged_profile_files() {
    // An FMU that carries profile files must refuse them when they are damaged.
    let file = scratch().join("measured_profiles.fmu");
    export(&format!("{ROOT}/examples/measured_profiles/scene.toml"), &file);
    let unpacked = scratch().join("measured_profiles");
    let _ = std::fs::remove_dir_all(&unpacked);
    zip::ZipArchive::new(std::fs::File::open(&file).unwrap()).unwrap().extract(&unpacked).unwrap();
    let scene = load::open(&format!("{ROOT}/examples/measured_profiles/scene.toml"), &[]).unwrap();
    let packed = package::pack_scene(&scene).unwrap();
    let library = unpacked.join("binaries").join(package::platform()).join(format!("measured_profiles{}", std::env::consts::DLL_SUFFIX));
    let mut command = Command::new(c_host());
    command.arg("bad").arg(library).arg(uri::from_path(&unpacked.join("resources"))).arg(&packed.description.guid).arg(variable_list());
    let text = run(command.args(["profiles/wheel.csv", "profiles/rail.csv"]));
    assert!(text.contains(" 0 failed") && text.contains("wheel.csv"), "{text}");
}

#[test]
fn fmu_serialised_states_say_why_they_are_refused() {
    let resources = FMU.folder.join("resources");
    let instance = Instance::new(&resources, &FMU.guid).unwrap();
    let blob = instance.serialize(&instance.save()).unwrap();
    assert_eq!(instance.deserialize(&blob).unwrap(), instance.save());
    let refused = |change: &dyn Fn(&mut Vec<u8>)| {
        let mut bytes = blob.clone();
        change(&mut bytes);
        instance.deserialize(&bytes).unwrap_err().to_string()
    };
    assert_eq!(instance.serialized_size(&instance.save()).unwrap(), blob.len());
    // Layout: magic 8, version 4, GUID 38, length 8, checksum 4, payload.
    assert!(refused(&|b| b[0] ^= 1).contains("not a serialised state of this program"));
    assert!(refused(&|b| b[8] = 250).contains("format version 250"));
    assert!(refused(&|b| b[12..50].copy_from_slice(b"{00000000-0000-0000-0000-000000000000}")).contains("another FMU"));
    assert!(refused(&|b| b[50] ^= 1).contains("bytes long"));
    assert!(refused(&|b| b[60] ^= 1).contains("checksum"));
    assert!(refused(&|b| *b.last_mut().unwrap() ^= 1).contains("checksum"));
    assert!(
        refused(&|b| {
            b.pop();
        })
        .contains("bytes long")
    );
    assert!(refused(&|b| b.push(0)).contains("bytes long"));
    assert!(refused(&Vec::clear).contains("bytes long"));
}

/// A master tries a step, takes it back and goes another way, also into an instance of its own and from bytes: no warning is left of the course that it gave up. The state is saved within a step
/// that the integrator has made already, and what was tried ends before that step does.
#[test]
fn fmu_a_course_that_is_taken_back_leaves_no_warning() {
    let new = || {
        let mut instance = Instance::new(&FMU.folder.join("resources"), &FMU.guid).unwrap();
        instance.setup_experiment(None, 0.0, None).unwrap();
        instance.enter_initialization().unwrap();
        instance.exit_initialization().unwrap();
        instance
    };
    let force = |instance: &Instance| {
        let variable = instance.table().variables.iter().find(|variable| variable.name == "wheelset.verticalForceInput").unwrap();
        variable.reference
    };
    let mut calm = new();
    calm.do_step(0.0, 0.101).unwrap();
    calm.do_step(0.101, 0.3).unwrap();
    let mut instance = new();
    instance.do_step(0.0, 0.101).unwrap();
    let saved = instance.save();
    let reference = force(&instance);
    instance.set_real(&[reference], &[-5e6]).unwrap();
    let _ = instance.do_step(0.101, 5e-4);
    assert!(instance.notes() != calm.notes(), "{:?}", instance.notes());
    let bytes = instance.serialize(&saved).unwrap();
    instance.restore(&saved).unwrap();
    let mut other = new();
    let read = other.deserialize(&bytes).unwrap();
    other.restore(&read).unwrap();
    for mut instance in [instance, other] {
        instance.do_step(0.101, 0.3).unwrap();
        assert_eq!(instance.notes(), calm.notes());
    }
}

/// Ten million communication steps of a microsecond end where a thousand of 10 ms do, to the bit.
#[test]
fn fmu_ten_million_communication_steps() {
    let ends = |per_second: u32| -> Vec<u64> {
        let mut instance = Instance::new(&FMU.folder.join("resources"), &FMU.guid).unwrap();
        instance.setup_experiment(None, 0.0, None).unwrap();
        instance.enter_initialization().unwrap();
        instance.exit_initialization().unwrap();
        let (rate, step) = (f64::from(per_second), 1.0 / f64::from(per_second));
        for k in 0..10 * per_second {
            assert!(matches!(instance.do_step(f64::from(k) / rate, step), Ok(StepOutcome::Done)), "{k}");
        }
        let references: Vec<u32> = instance.table().outputs.iter().map(|output| output.reference).collect();
        let mut values = vec![0.0; references.len()];
        instance.get_real(&references, &mut values).unwrap();
        values.into_iter().map(f64::to_bits).collect()
    };
    assert!(ends(1_000_000) == ends(100));
}

#[test]
fn fmu_communication_points_far_from_zero_are_checked_by_the_step() {
    let mut instance = Instance::new(&FMU.folder.join("resources"), &FMU.guid).unwrap();
    let start = 1e9;
    instance.setup_experiment(None, start, Some(start + 1.0)).unwrap();
    instance.enter_initialization().unwrap();
    instance.exit_initialization().unwrap();
    assert!(instance.do_step(start + 0.5, 0.01).is_err(), "half a second off is not the instance's time");
    assert!(matches!(instance.do_step(start, 0.01), Ok(StepOutcome::Done)));
    assert!(instance.do_step(start + 0.01, 1.2).is_err(), "past the stop time");
    assert!((instance.time() - start - 0.01).abs() < 1e-6);
}

#[test]
fn fmu_c_host_under_valgrind() {
    let installed = Command::new("valgrind").arg("--version").output().is_ok_and(|output| output.status.success());
    if !installed {
        assert!(std::env::var_os("WHEELRAIL_REQUIRE_VALGRIND").is_none(), "valgrind is required here but not installed");
        // Past the test runner's capture, so that it is seen.
        let _ =
            std::io::Write::write_all(&mut std::io::stderr(), b"valgrind is not installed: the memory check of the C host was left out\n");
        return;
    }
    for (mode, extra) in [("abi", vec![]), ("bad", vec![]), ("states", vec![]), ("urls", vec![]), ("threads", vec!["4"])] {
        let mut command = Command::new("valgrind");
        command.args(["-q", "--leak-check=full", "--show-leak-kinds=definite,indirect", "--error-exitcode=9"]).arg(c_host());
        let text = run(command.args(host_arguments(mode, &extra)));
        assert!(text.contains(" 0 failed") && !text.contains("definitely lost"), "{mode}: {text}");
        println!("valgrind {mode}: no error, no leak");
    }
    // A curved track: what the compiler made of its iterators read what nobody had written.
    let mut command = Command::new("valgrind");
    command.args(["-q", "--error-exitcode=9"]).arg(env!("CARGO_BIN_EXE_wheelrail"));
    run(command.args(["run", "vehicle_curve", "--stop", "0.001", "--set", "contact.patch=ellipse"]));
}

#[test]
fn fmu_a_scene_with_profile_files_carries_them() {
    let folder = tempfile::tempdir().unwrap();
    let deep = folder.path().join("a/b");
    std::fs::create_dir_all(&deep).unwrap();
    std::fs::create_dir_all(folder.path().join("other")).unwrap();
    // Two different files of the same name, reached by ../
    std::fs::write(folder.path().join("a/p.csv"), "u,radius\n-0.05,0.45825\n0,0.457\n0.05,0.45575\n").unwrap();
    let head: String = (-50..=50)
        .map(|i| {
            let e = f64::from(i) * 5e-4;
            format!("{e},{}\n", -e * e / ((0.09 - e * e).sqrt() + 0.3))
        })
        .collect();
    std::fs::write(folder.path().join("other/p.csv"), format!("eta,height\n{head}")).unwrap();
    let text = embedded::find("suspended_wheelset").unwrap().text;
    let scene = deep.join("my scene.toml");
    let text = text.replace("name = \"suspended_wheelset\"\n", "");
    std::fs::write(&scene, text).unwrap();
    let changes =
        ["vehicle.wheelset.profile={kind=\"points\", file=\"../p.csv\"}", "track.rail={kind=\"points\", file=\"../../other/p.csv\"}"];
    let file = folder.path().join("out.fmu");
    let mut command = Command::new(env!("CARGO_BIN_EXE_wheelrail"));
    command.arg("export").arg(&scene).arg("-o").arg(&file);
    for change in changes {
        command.args(["--set", change]);
    }
    let text = run(&mut command);
    assert!(text.contains("my_scene") || text.contains("out.fmu"), "{text}");
    let mut archive = zip::ZipArchive::new(std::fs::File::open(&file).unwrap()).unwrap();
    let names: Vec<String> = archive.file_names().map(|name| name.unwrap().into_owned()).collect();
    assert!(names.contains(&"resources/profiles/p.csv".into()) && names.contains(&"resources/profiles/p_2.csv".into()), "{names:?}");
    assert!(names.iter().any(|name| name.ends_with(&format!("my_scene{}", std::env::consts::DLL_SUFFIX))), "{names:?}");
    let unpacked = folder.path().join("unpacked");
    archive.extract(&unpacked).unwrap();
    let script = Path::new(ROOT).join("tests/fmu/check_description.py");
    assert!(run(Command::new(python()).arg("-B").arg(script).arg(&file)).contains(" 0 failed"));
}

/// The generated XML of each embedded scene stands in modelDescription/golden as a lock on the interface.
/// `WHEELRAIL_BLESS=1 cargo test` writes it anew.
#[test]
fn fmu_golden_description_of_each_scene() {
    for scene in embedded::SCENES {
        let packed = package::pack_scene(&load::open(scene.name, &[]).unwrap()).unwrap();
        // The GUID changes with every word of the scene; it is not part of the interface.
        let xml = packed.description.xml.replace(&packed.description.guid, "{guid}");
        let file = Path::new(ROOT).join("modelDescription/golden").join(format!("{}.xml", scene.name));
        if std::env::var_os("WHEELRAIL_BLESS").is_some() {
            std::fs::write(&file, &xml).unwrap();
        }
        let golden = std::fs::read_to_string(&file).unwrap_or_default();
        assert!(
            golden == xml,
            "{} differs from {}; if the interface was meant to change, run WHEELRAIL_BLESS=1 cargo test fmu_golden",
            scene.name,
            file.display()
        );
    }
}

#[test]
fn prop_a_parameter_without_effect_is_not_there() {
    let names = |scene: &str, changes: &[&str]| -> Vec<String> {
        let changes: Vec<String> = changes.iter().map(|change| (*change).to_string()).collect();
        let packed = package::pack_scene(&load::open(scene, &changes).unwrap()).unwrap();
        packed.table.variables.iter().map(|variable| variable.name.clone()).collect()
    };
    let has = |names: &[String], name: &str| names.iter().any(|found| found == name);
    assert!(has(&names("suspended_wheelset", &[]), "contact.damping"));
    // A law with numbers of its own knows no C of Eq. 28.
    assert!(!has(&names("suspended_wheelset", &["contact.damping={ law = \"none\" }"]), "contact.damping"));
    for (changes, force, input) in [(&[][..], true, false), (&["vehicle.travel=free"], false, true)] {
        let names = names("suspended_wheelset", changes);
        assert_eq!((has(&names, "wheelset.drivingForce"), has(&names, "wheelset.longitudinalForceInput")), (force, input));
    }
}

#[test]
fn prop_value_references_are_unique_and_stable() {
    let packed = package::pack_scene(&load::open("suspended_wheelset", &[]).unwrap()).unwrap();
    let by_reference: BTreeMap<u32, &str> = packed.table.variables.iter().map(|v| (v.reference, v.name.as_str())).collect();
    assert_eq!(by_reference.len(), packed.table.variables.len());
    // A scene that shows less keeps the references of what it still shows.
    let small =
        load::open("suspended_wheelset", &["interface.outputs=[\"motion\"]".into(), "interface.inputs=[\"friction\"]".into()]).unwrap();
    let small = package::pack_scene(&small).unwrap();
    assert!(small.table.variables.len() < packed.table.variables.len());
    for variable in &small.table.variables {
        assert_eq!(by_reference.get(&variable.reference), Some(&variable.name.as_str()));
    }
}

/// Inputs of force elements are variables with references of their own, begin with what the scene says, and change at once only what shows the element and the accelerations of
/// its bodies.
#[test]
fn fmu_inputs_of_motors_and_brakes_are_variables() {
    let file = format!("{ROOT}/examples/braked_coach.toml");
    let packed = package::pack_scene(&load::open(&file, &[]).unwrap()).unwrap();
    let table = &packed.table;
    let variable = |name: &str| table.variables.iter().position(|variable| variable.name == name).unwrap_or_else(|| panic!("no {name}"));
    let brake = variable("brake[2].largestTorque");
    let own = &table.variables[brake];
    assert_eq!((own.causality, own.start, own.min, own.reference), ("input", Some(5400.0), Some(0.0), 4_000_100));
    let reacts = |name: &str| {
        let output = table.outputs.iter().find(|output| output.name == name).unwrap_or_else(|| panic!("no {name}"));
        table.dependencies(output).iter().any(|(index, _)| *index == brake + 1)
    };
    assert!(reacts("brake[2].torque") && reacts("truck[1].wheelset[2].pitchAcceleration"));
    for other in [
        "brake[1].torque",
        "truck[1].wheelset[1].pitchAcceleration",
        "truck[1].wheelset[2].pitchRate",
        "truck[1].wheelset[2].usedAdhesion",
        "truck[1].wheelset[2].slipSpeed",
    ] {
        assert!(!reacts(other), "{other}");
    }
    let without = ["interface.inputs=[\"friction\"]".to_string()];
    let less = package::pack_scene(&load::open(&file, &without).unwrap()).unwrap();
    assert!(less.table.variables.iter().all(|variable| !variable.name.ends_with("largestTorque")));
    // What is not shown keeps what the scene says.
    assert!(less.table.start_inputs.iter().filter(|value| **value == 5400.0).count() == 4);
}
