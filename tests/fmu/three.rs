//! FMI 3.0: the same model through the other interface.

use super::{FMU, ROOT, changed, changed_fmu, common, dip, flange_scene, python, run, script, unpacked};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::LazyLock;
use wheelrail::fmi::ffi::host::Steps;
use wheelrail::fmi::ffi::v3::host::LoadedFmu;
use wheelrail::fmi::package;
use wheelrail::fmi::version::Version;
use wheelrail::formulation::{DRIVE_TORQUE, LATERAL_FORCE, LEFT_FRICTION};
use wheelrail::scene::spec::Scene;
use wheelrail::scene::{embedded, load};

/// The FMU of a scene with changes as `FOLDER/NAME.fmu`.
fn export(folder: &Path, name: &str, scene: &str, changes: &[&str]) -> PathBuf {
    let file = folder.join(format!("{name}.fmu"));
    let mut command = Command::new(env!("CARGO_BIN_EXE_wheelrail"));
    command.args(["export", scene, "--fmi", "3", "-o"]).arg(&file).args(changes.iter().flat_map(|change| ["--set", change]));
    let text = run(&mut command);
    assert!(text.contains("FMI 3.0 co-simulation") && text.contains("instantiation token {"), "{text}");
    file
}

/// The FMUs that the scripts run.
static FOLDER: LazyLock<tempfile::TempDir> = LazyLock::new(|| {
    let folder = tempfile::tempdir().unwrap();
    export(folder.path(), "three", "suspended_wheelset", &[]);
    export(folder.path(), "bogie", "bogie", &["run.stop=0.2"]);
    let coach = format!("{ROOT}/examples/braked_coach.toml");
    export(
        folder.path(),
        "rails",
        &coach,
        &["run.stop=0.1", "interface.inputs=[\"rail_motion\", \"elements\", \"centre_forces\", \"friction\"]"],
    );
    export(folder.path(), "dip", "suspended_wheelset", &dip("contact.formulation=ECCF", "elastic"));
    export(folder.path(), "stop", "suspended_wheelset", &dip("contact.formulation=ECCF", "stop"));
    export(folder.path(), "bounce", "suspended_wheelset", &dip("contact.formulation=ECF-A", "elastic"));
    export(folder.path(), "flange", &flange_scene(), &["contact.formulation=ECF-A"]);
    folder
});

#[test]
fn fmu_three_describes_itself_and_gives_the_results_of_two() {
    script("fmi3.py", &[FOLDER.path().as_os_str()]);
}

#[test]
fn fmu_three_updates_early_returns_and_events() {
    script("fmi3_steps.py", &[FOLDER.path().as_os_str()]);
}

#[test]
fn fmu_three_under_another_master() {
    script("fmi3_loader.py", &[FOLDER.path().as_os_str()]);
}

#[test]
fn fmu_three_bad_calls() {
    script("fmi3_calls.py", &[FOLDER.path().as_os_str()]);
}

#[test]
fn fmu_both_follow_a_speed_that_a_master_imposes() {
    let folder = tempfile::tempdir().unwrap();
    let changes = ["vehicle.speed={start=20,time_constant=0.5,largest_acceleration=2}", "solver.tolerance=1e-7"];
    let two = changed_fmu(folder.path(), "two", &changes);
    let three = export(folder.path(), "three", "suspended_wheelset", &changes);
    script("speed.py", &[two.file.as_os_str(), three.as_os_str()]);
}

#[test]
fn fmu_a_run_with_a_table_of_inputs_is_that_of_a_driven_fmu() {
    let folder = tempfile::tempdir().unwrap();
    let changes = ["vehicle.speed={start=20,time_constant=0.5,largest_acceleration=2}", "solver.tolerance=1e-7", "run.step=0.01"];
    let fmu = changed_fmu(folder.path(), "table", &changes);
    let [table, native] = ["inputs.csv", "native.csv"].map(|name| folder.path().join(name));
    // Bends between output times, a jump at one and a jump between two.
    let text = "# of the test\ntime,speed,wheelset.driveTorque,wheelset.left.frictionFactor\n0,21,0,1\n0.3137,21,0,1\n1.2,23,1500,0.6\n1.2,23,-800,0.6\n1.6043,22,100,0.9\n1.6043,24,0,1\n";
    std::fs::write(&table, text).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_wheelrail"));
    command.args([
        "run",
        "suspended_wheelset",
        "--stop",
        "2",
        "--columns",
        "*.vx,*.y,*.vy,*.yaw,*.distance,*.left.verticalForce,*.left.lateralForce,*.drivingForce",
    ]);
    command.args(changes.iter().flat_map(|change| ["--set", change])).arg("--inputs").arg(&table).arg("-o").arg(&native);
    run(&mut command);
    // The same rows for a master that knows no comments.
    std::fs::write(&table, text.split_once('\n').unwrap().1).unwrap();
    script("input_table.py", &[fmu.file.as_os_str(), table.as_os_str(), native.as_os_str()]);
}

/// Steps of uneven length with inputs that change, natively and as FMU.
fn native_run_is_the_same(scene: &Scene, fmu: &Path, stop: f64) {
    let packed = package::pack_scene_as(scene, Version::Three).unwrap();
    let folder = unpacked(fmu);
    let library = folder.path().join(package::library_path(&scene.name, Version::Three));
    let references: Vec<u32> = packed.table.outputs.iter().map(|output| output.reference).collect();
    let mut fmu = LoadedFmu::start(&library, &packed.description.guid, &folder.path().join("resources")).unwrap();
    let mut native = common::start(scene);
    let outputs = common::table(&native, scene);
    let (mut time, mut rows) = (0.0, 0);
    while time < stop {
        let step = [0.001, 0.00237, 0.01, 0.0005][rows % 4];
        for (at, input, value) in [(30, DRIVE_TORQUE, 800.0), (60, LATERAL_FORCE, 2e3), (90, LEFT_FRICTION, 0.5)] {
            if rows == at {
                fmu.set_real(1001 + input as u32, value).unwrap();
                native.set_input(input, value, 0.0, 0.0);
            }
        }
        fmu.do_step(time, step).unwrap();
        time += step;
        native.advance(time).unwrap();
        rows += 1;
        let theirs = fmu.get_real(&references).unwrap();
        let snapshot = native.snapshot().unwrap();
        for (output, theirs) in outputs.iter().zip(theirs) {
            assert_eq!(output.value(snapshot).to_bits(), theirs.to_bits(), "{output:?} at t = {time}");
        }
    }
    assert!(rows > 100 && native.statistics().restarts + native.statistics().taken_up >= 3, "every change must have been made");
}

#[test]
fn fmu_three_native_run_is_the_same_to_the_last_bit() {
    let cases: [(&str, &str, Vec<&str>); 3] = [
        ("elastic", "suspended_wheelset", vec!["contact.formulation=ECF-A"]),
        ("rigid", "suspended_wheelset", dip("contact.formulation=ECCF", "elastic")),
        ("curve", "vehicle_curve", vec!["run.stop=0.2"]),
    ];
    for (name, scene, changes) in cases {
        let file = export(FOLDER.path(), name, scene, &changes);
        native_run_is_the_same(&changed(scene, &changes), &file, 0.7);
    }
}

/// Stops at the integrator's own steps leave every bit of a run where it is, with every kind of integrator.
#[test]
fn equiv_a_run_over_the_integrators_stops_is_the_run_without_them() {
    let cases: [(&str, &[&str], f64); 7] = [
        ("suspended_wheelset", &["contact.formulation=ECF-A"], 0.8),
        ("suspended_wheelset", &["contact.formulation=ACCF", "contact.on_lift=elastic"], 0.8),
        ("suspended_wheelset", &["contact.formulation=ECF-A", "solver.integrator=dormand_prince"], 0.6),
        ("wheelset_s1002", &["solver.integrator=real_time", "solver.step=0.0005"], 0.6),
        ("suspended_wheelset", &["solver.integrator=rk4", "solver.step=0.0001"], 0.6),
        ("bogie", &[], 0.4),
        ("vehicle_curve", &[], 1.0),
    ];
    for (scene, changes, stop) in cases {
        let scene = changed(scene, changes);
        let (mut plain, mut stopping) = (common::start(&scene), common::start(&scene));
        let mut stops = 0;
        for i in 1..=4 {
            let target = stop * f64::from(i) / 4.0;
            plain.advance(target).unwrap();
            while stopping.time() < target {
                stopping.advance_to_stop(target).unwrap();
                stops += 1;
            }
            assert_eq!((stopping.time(), plain.time()), (target, target));
            let rows = [&mut plain, &mut stopping].map(|run| {
                let outputs = common::table(run, &scene);
                let snapshot = run.snapshot().unwrap();
                outputs.iter().map(|output| output.value(snapshot).to_bits()).collect::<Vec<u64>>()
            });
            assert!(rows[0] == rows[1], "{} {changes:?} at {target} s", scene.name);
        }
        assert_eq!(plain.statistics().steps, stopping.statistics().steps);
        assert!(stops as u64 + 8 > plain.statistics().steps && stops > 4, "{}: {stops} stops", scene.name);
    }
}

/// The description of every embedded scene is valid, and of two it is a lock on the interface (`WHEELRAIL_BLESS=1 cargo test fmu_three` writes them anew).
#[test]
fn fmu_three_golden_descriptions_are_valid_for_every_scene() {
    let folder = tempfile::tempdir().unwrap();
    let mut files = Vec::new();
    for scene in embedded::SCENES {
        let packed = package::pack_scene_as(&load::open(scene.name, &[]).unwrap(), Version::Three).unwrap();
        let file = folder.path().join(format!("{}.xml", scene.name));
        std::fs::write(&file, &packed.description.xml).unwrap();
        files.push(file);
        if !matches!(scene.name, "suspended_wheelset" | "bogie") {
            continue;
        }
        let xml = packed.description.xml.replace(&packed.description.guid, "{token}");
        let golden = Path::new(ROOT).join("modelDescription/golden/fmi3").join(format!("{}.xml", scene.name));
        if std::env::var_os("WHEELRAIL_BLESS").is_some() {
            std::fs::create_dir_all(golden.parent().unwrap()).unwrap();
            std::fs::write(&golden, &xml).unwrap();
        }
        let found = std::fs::read_to_string(&golden).unwrap_or_default();
        assert!(
            found == xml,
            "{} differs; if the interface was meant to change, run WHEELRAIL_BLESS=1 cargo test fmu_three",
            golden.display()
        );
    }
    let check = "import sys\nfrom fmpy import read_model_description\n\
                 for file in sys.argv[1:]:\n \
                 read = read_model_description(file, validate=True, validate_variable_names=True, validate_model_structure=True)\n \
                 print(len(read.modelVariables), 'valid')";
    let found = run(Command::new(python()).args(["-c", check]).args(&files));
    assert_eq!(found.matches("valid").count(), files.len(), "{found}");
}

#[test]
fn fmu_three_and_two_share_no_instantiation_token() {
    let scene = load::open("suspended_wheelset", &[]).unwrap();
    let three = package::pack_scene_as(&scene, Version::Three).unwrap();
    assert_ne!(three.description.guid, FMU.guid, "an FMU of one version must not take the description of the other");
}
