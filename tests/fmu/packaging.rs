//! What an archive holds beside the description: libraries of several platforms, reference results, a system around the FMU; and many instances at once.

use super::{FMU, ROOT, python, run, scratch, script, unpacked};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Barrier;
use wheelrail::fmi::ffi::host::LoadedFmu;
use wheelrail::fmi::package;

/// A library for Windows on x86-64, or Linux on ARM, in its header, with the mark of the library that this FMU holds.
fn foreign(folder: &Path, name: &str, windows: bool) -> PathBuf {
    let own = std::fs::read(FMU.library()).unwrap();
    let prefix = b"wheelrail-build-id:";
    let digits = |rest: &[u8]| rest.len() > 24 && rest[..24].iter().all(u8::is_ascii_hexdigit) && rest[24] == b':';
    let at = own.windows(prefix.len()).enumerate().find(|(at, part)| part == prefix && digits(&own[at + prefix.len()..])).unwrap().0;
    let mut bytes = vec![0_u8; 0x100];
    if windows {
        bytes[..2].copy_from_slice(b"MZ");
        bytes[0x3c] = 0x80;
        bytes[0x80..0x86].copy_from_slice(b"PE\0\0\x64\x86");
        bytes[0x97] = 0x20;
    } else {
        bytes[..6].copy_from_slice(b"\x7fELF\x02\x01");
        bytes[16] = 3;
        bytes[18] = 183;
    }
    bytes.extend_from_slice(&own[at..at + prefix.len() + 25]);
    let file = folder.join(name);
    std::fs::write(&file, bytes).unwrap();
    file
}

fn wheelrail(arguments: &[&str]) -> (String, bool) {
    let output = Command::new(env!("CARGO_BIN_EXE_wheelrail")).args(arguments).output().unwrap();
    let text = format!("{}{}", String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    (text, output.status.success())
}

#[test]
fn fmu_holds_libraries_of_several_platforms() {
    let folder = tempfile::tempdir().unwrap();
    let (dll, arm) = (foreign(folder.path(), "wheelrail.dll", true), foreign(folder.path(), "arm.so", false));
    let file = folder.path().join("several.fmu");
    let of = |library: &Path| library.to_str().unwrap().to_string();
    for (fmi, host, windows, linux) in
        [("2", package::platform(), "win64", "aarch64-linux"), ("3", "x86_64-linux".into(), "x86_64-windows", "aarch64-linux")]
    {
        // The platform is named in either version's words, or not at all.
        let libraries = [format!("win64={}", of(&dll)), of(&arm)];
        let (text, well) = wheelrail(&[
            "export",
            "suspended_wheelset",
            "--fmi",
            fmi,
            "--json",
            "--library",
            &libraries[0],
            "--library",
            &libraries[1],
            "-o",
            &of(&file),
        ]);
        assert!(well, "{text}");
        let archive = unpacked(&file);
        for (platform, name, library) in [(windows, "suspended_wheelset.dll", &dll), (linux, "suspended_wheelset.so", &arm)] {
            let held = std::fs::read(archive.path().join("binaries").join(platform).join(name)).unwrap();
            assert_eq!(held, std::fs::read(library).unwrap());
            assert!(text.contains(&format!("\"{platform}\"")), "{text}");
        }
        if cfg!(all(target_os = "linux", target_arch = "x86_64")) {
            let own = archive.path().join("binaries").join(&host).join("suspended_wheelset.so");
            assert_eq!(std::fs::read(own).unwrap(), std::fs::read(FMU.library()).unwrap());
        }
        assert_eq!(std::fs::read_dir(archive.path().join("binaries")).unwrap().count(), 3);
        for name in
            ["documentation/licenses/license.txt", "documentation/licenses/third_party.txt", "terminalsAndIcons/terminalsAndIcons.xml"]
        {
            assert!(archive.path().join(name).is_file(), "{name}");
        }
    }
    for (library, sentence) in [
        (format!("linux64={}", of(&dll)), "is made for win64, not for linux64"),
        (format!("window={}", of(&dll)), "is no platform"),
        (of(&folder.path().join("several.fmu")), "not an FMU library"),
    ] {
        let (text, well) = wheelrail(&["export", "suspended_wheelset", "-o", &of(&file), "--library", &library]);
        assert!(!well && text.contains(sentence), "{text}");
    }
}

#[test]
fn fmu_library_shows_no_symbols_but_those_of_fmi() {
    if cfg!(target_os = "linux") {
        let text = run(Command::new(python()).arg("-B").arg(format!("{ROOT}/tests/fmu/library.py")).arg(FMU.library()));
        assert!(text.contains(" 0 failed"), "{text}");
        println!("{text}");
    }
}

/// Other masters than FMPy, where they have packages: two wheelsets that push each other get what they get by hand, to the bit.
#[test]
fn fmu_coupled_under_other_masters() {
    if cfg!(all(target_os = "linux", target_arch = "x86_64")) {
        script("masters.py", &[]);
    }
}

/// model.png is a PNG of this vehicle: on nothing, as wide as high, with more ink where there is more vehicle; another one for each vehicle, the same bytes each time.
#[test]
fn fmu_shows_its_own_vehicle() {
    let picture = |scene: &str| {
        let packed = package::pack_scene(&super::changed(scene, &[])).unwrap();
        package::files(&packed, &[]).remove("model.png").unwrap()
    };
    let found = ["suspended_wheelset", "bogie", "vehicle_manchester_1", "train"].map(picture);
    for (i, bytes) in found.iter().enumerate() {
        assert_eq!(&bytes[..8], b"\x89PNG\r\n\x1a\n");
        let number = |at: usize| u32::from_be_bytes(bytes[at..at + 4].try_into().unwrap());
        assert_eq!((&bytes[12..16], number(16), number(20)), (&b"IHDR"[..], 400, 400));
        assert!(found[..i].iter().all(|other| other != bytes));
        let picture = tiny_skia::Pixmap::decode_png(bytes).unwrap();
        let inked = picture.pixels().iter().filter(|pixel| pixel.alpha() > 0).count();
        println!("{} bytes, {:.1} % inked", bytes.len(), 100.0 * inked as f64 / 16e4);
        assert!((400..120_000).contains(&inked) && picture.pixels()[0].alpha() == 0, "{inked}");
    }
    assert_eq!(picture("bogie"), found[1]);
}

#[test]
fn fmu_holds_the_results_that_it_gives() {
    let file = scratch().join("reference_curve.fmu");
    super::export_changed("vehicle_curve", &["run.stop=0.5"], &file);
    let wheelset = scratch().join("reference_three.fmu");
    let three = ["export", "suspended_wheelset", "--fmi", "3", "-o", wheelset.to_str().unwrap()];
    assert!(wheelrail(&three).1);
    script("reference.py", &[file.as_os_str(), wheelset.as_os_str()]);
}

#[test]
fn fmu_in_a_system_structure() {
    let folder = tempfile::tempdir().unwrap();
    let coach = format!("{ROOT}/examples/braked_coach.toml");
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_string();
    for (scene, name) in [("suspended_wheelset", "wheelset.ssp"), (coach.as_str(), "coach.ssp")] {
        let (text, well) = wheelrail(&["export", scene, "--ssp", "--set", "run.stop=0.2", "-o", &path(name)]);
        assert!(well && text.contains("SSP 1.0"), "{text}");
    }
    script("system.py", &[path("wheelset.ssp").as_ref(), path("coach.ssp").as_ref()]);
    for arguments in [&["--ssp", "--fmi", "3"][..], &["--ssp", "-o", "x.fmu"]] {
        let (text, well) = wheelrail(&[&["export", "suspended_wheelset"][..], arguments].concat());
        assert!(!well && (text.contains("SSP 1.0") || text.contains(".ssp")), "{text}");
    }
}

/// Memory of this process, bytes; 0 where it can't be told.
fn memory() -> f64 {
    let pages = std::fs::read_to_string("/proc/self/statm").ok();
    pages.and_then(|text| text.split(' ').nth(1)?.parse::<f64>().ok()).unwrap_or(0.0) * 4096.0
}

/// A thousand instances that live at once in one process, stepped in turns by sixteen threads, give the same bits.
#[test]
fn fmu_a_thousand_instances_on_sixteen_threads() {
    const THREADS: usize = 16;
    const EACH: usize = 63;
    const STEPS: usize = 40;
    let packed = package::pack_scene(&super::changed("suspended_wheelset", &[])).unwrap();
    let references: Vec<u32> = packed.table.outputs.iter().map(|output| output.reference).collect();
    let (library, resources) = (FMU.library(), FMU.resources());
    let before = memory();
    let all_live = Barrier::new(THREADS);
    let results: Vec<(Vec<u64>, f64)> = std::thread::scope(|scope| {
        let worker = || {
            let mut own: Vec<LoadedFmu> = (0..EACH).map(|_| LoadedFmu::start(&library, &FMU.guid, &resources).unwrap()).collect();
            all_live.wait();
            for step in 0..STEPS {
                for fmu in &mut own {
                    fmu.do_step(0.01 * step as f64, 0.01).unwrap();
                }
            }
            all_live.wait();
            let used = memory();
            let bits = |fmu: &mut LoadedFmu| fmu.get_real(&references).unwrap().iter().map(|value| value.to_bits()).collect::<Vec<u64>>();
            let first = bits(&mut own[0]);
            assert!(own.iter_mut().all(|fmu| bits(fmu) == first), "instances of one thread differ");
            (first, used)
        };
        let threads: Vec<_> = (0..THREADS).map(|_| scope.spawn(worker)).collect();
        threads.into_iter().map(|thread| thread.join().unwrap()).collect()
    });
    assert!(results.iter().all(|(bits, _)| *bits == results[0].0), "instances of different threads differ");
    println!("{} instances: {:.0} kB each", THREADS * EACH, (results[0].1 - before) / 1e3 / (THREADS * EACH) as f64);
}

/// An FMU whose wheels read their patches from a table brings it along: nothing is made, or looked for elsewhere, where it runs.
#[test]
fn fmu_carries_its_table_of_patches() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let with = |cache: &str, arguments: &[&str]| {
        let done = Command::new(env!("CARGO_BIN_EXE_wheelrail")).args(arguments).env("WHEELRAIL_CACHE", path(cache)).output().unwrap();
        assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
        String::from_utf8_lossy(&done.stderr).into_owned()
    };
    let (file, native, carried) = (path("tabled.fmu"), path("native.csv"), path("carried.csv"));
    let [file, native, carried] = [&file, &native, &carried].map(|path| path.to_str().unwrap());
    let made = with("first", &["export", "wheelset_s1002", "--set", "contact.patch=table", "-o", file]);
    assert!(made.contains("making the table of patches"), "{made}");
    let unzipped = path("unzipped");
    zip::ZipArchive::new(std::fs::File::open(file).unwrap()).unwrap().extract(&unzipped).unwrap();
    let tables: Vec<_> = std::fs::read_dir(unzipped.join("resources/tables")).unwrap().collect();
    assert_eq!(tables.len(), 1, "one for both sides");
    let scene = unzipped.join("resources/scene.toml");
    with("first", &["run", "wheelset_s1002", "--set", "contact.patch=table", "--stop", "0.5", "-o", native]);
    let said = with("second", &["run", scene.to_str().unwrap(), "--stop", "0.5", "-o", carried]);
    assert!(!said.contains("making the table") && !path("second").exists(), "{said}");
    assert_eq!(std::fs::read(native).unwrap(), std::fs::read(carried).unwrap());
    // A damaged one is made anew.
    for table in tables {
        let path = table.unwrap().path();
        let mut bytes = std::fs::read(&path).unwrap();
        let middle = bytes.len() / 2;
        bytes[middle] ^= 1;
        std::fs::write(&path, bytes).unwrap();
    }
    let said = with("third", &["run", scene.to_str().unwrap(), "--stop", "0.5", "-o", carried]);
    assert!(said.contains("making the table"));
    assert_eq!(std::fs::read(native).unwrap(), std::fs::read(carried).unwrap());
}
