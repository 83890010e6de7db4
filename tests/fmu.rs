//! The FMU through its C interface: fmpy as the master, a C host, and a comparison with native runs bit by bit.
//!
//! The tests make their own Python environment under target/ from pinned packages.

mod common;

use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::{LazyLock, OnceLock};
use wheelrail::fmi::description;
use wheelrail::fmi::ffi::host::LoadedFmu;
use wheelrail::fmi::package;
use wheelrail::fmi::uri;
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
            run(Command::new(if cfg!(windows) { "python" } else { "python3" }).args(["-m", "venv"]).arg(&folder));
            run(Command::new(&program).args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check", "-r"]).arg(&requirements));
            std::fs::write(&stamp, wanted).unwrap();
        }
        program
    })
}

/// The exported FMU, unpacked beside it.
struct Fmu {
    file: PathBuf,
    folder: PathBuf,
    guid: String,
}

impl Fmu {
    fn library(&self) -> PathBuf {
        let name = self.file.file_stem().unwrap().to_string_lossy().into_owned();
        self.folder.join("binaries").join(package::platform()).join(format!("{name}{}", std::env::consts::DLL_SUFFIX))
    }
    fn resources(&self) -> String {
        uri::from_path(&self.folder.join("resources"))
    }
}

fn export(scene: &str, file: &Path) -> String {
    run(Command::new(env!("CARGO_BIN_EXE_wheelrail")).args(["export", scene, "-o"]).arg(file))
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
    Fmu { file, folder: unpacked, guid: packed.description.guid }
});

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
fn fmu_coupled_with_external_traction_and_brake() {
    script("coupling.py", &[]);
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
fn fmu_native_run_is_the_same_to_the_last_bit() {
    // The same sequence of (time, step) pairs, steps uneven on purpose.
    let scene = load::open("suspended_wheelset", &[]).unwrap();
    let packed = package::pack_scene(&scene).unwrap();
    let references: Vec<u32> = packed.table.outputs.iter().map(|output| output.reference).collect();
    let mut fmu = LoadedFmu::start(&FMU.library(), &FMU.guid, &FMU.resources()).unwrap();
    let mut native = common::start(&scene);
    let outputs = common::table(&native, &scene);
    let (mut time, mut rows) = (0.0, 0);
    while time < 1.5 {
        let step = [0.001, 0.00237, 0.01, 0.0005][rows % 4];
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
    println!("{rows} steps, {} outputs, all equal to the last bit", outputs.len());
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
            .map(|variable| format!("{} {} {:?} {}\n", variable.name, variable.reference, variable.kind, variable.causality))
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

#[test]
fn fmu_c_host_under_valgrind() {
    let installed = Command::new("valgrind").arg("--version").output().is_ok_and(|output| output.status.success());
    if !installed {
        assert!(std::env::var_os("WHEELRAIL_REQUIRE_VALGRIND").is_none(), "valgrind is required here but not installed");
        println!("valgrind is not installed: the memory check of the C host was left out");
        return;
    }
    for (mode, extra) in [("abi", vec![]), ("bad", vec![]), ("states", vec![]), ("threads", vec!["4"])] {
        let mut command = Command::new("valgrind");
        command.args(["-q", "--leak-check=full", "--show-leak-kinds=definite,indirect", "--error-exitcode=9"]).arg(c_host());
        let text = run(command.args(host_arguments(mode, &extra)));
        assert!(text.contains(" 0 failed") && !text.contains("definitely lost"), "{mode}: {text}");
        println!("valgrind {mode}: no error, no leak");
    }
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
