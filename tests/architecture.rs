//! The house's floors: a module uses only modules on lower floors (or its own).

use std::path::{Path, PathBuf};

/// Floor of each top-level module; modules of equal floor may not use each other unless listed in `SAME_FLOOR`.
const FLOORS: &[(&str, u32)] = &[
    ("math", 0),
    ("units", 0),
    ("settings", 0),
    ("geometry", 1),
    ("contact", 2),
    ("mbs", 3),
    ("formulation", 4),
    ("solve", 5),
    ("scene", 6),
    ("sim", 7),
    ("fmi", 8),
    ("study", 8),
    ("cli", 9),
];

/// Uses on one floor that are meant.
const SAME_FLOOR: &[(&str, &str)] = &[("settings", "units")];

fn rust_files(folder: &Path, files: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            rust_files(&path, files);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            files.push(path);
        }
    }
}

fn sources() -> Vec<(PathBuf, String)> {
    let mut files = Vec::new();
    rust_files(&Path::new(env!("CARGO_MANIFEST_DIR")).join("src"), &mut files);
    files.sort();
    files.into_iter().map(|file| (file.clone(), std::fs::read_to_string(file).unwrap())).collect()
}

fn floor(module: &str) -> u32 {
    FLOORS
        .iter()
        .find(|floor| floor.0 == module)
        .unwrap_or_else(|| panic!("module {module} has no floor; add it to tests/architecture.rs"))
        .1
}

/// The top-level module that a file belongs to; `None` for lib.rs and main.rs.
fn module_of(file: &Path) -> Option<String> {
    let below = file.strip_prefix(Path::new(env!("CARGO_MANIFEST_DIR")).join("src")).unwrap();
    let first = below.components().next().unwrap().as_os_str().to_string_lossy().into_owned();
    let name = first.trim_end_matches(".rs").to_string();
    (name != "lib" && name != "main").then_some(name)
}

#[test]
fn prop_modules_use_only_lower_floors() {
    let mut uses = 0;
    for (file, text) in sources() {
        let Some(own) = module_of(&file) else { continue };
        for (at, _) in text.match_indices("crate::") {
            let used: String = text[at + "crate::".len()..].chars().take_while(|c| c.is_ascii_alphanumeric() || *c == '_').collect();
            if used == own || used.is_empty() {
                continue;
            }
            uses += 1;
            let lower = floor(&used) < floor(&own);
            let meant = SAME_FLOOR.contains(&(own.as_str(), used.as_str()));
            assert!(lower || meant, "{}: {own} (floor {}) uses {used} (floor {})", file.display(), floor(&own), floor(&used));
            // Integration knows only mathematics and settings.
            assert!(own != "solve" || floor(&used) == 0, "{}: solve uses {used}", file.display());
        }
    }
    assert!(uses > 50, "the test no longer sees the use lines");
}

#[test]
fn prop_files_stay_small_and_unsafe_stays_in_ffi() {
    for (file, text) in sources() {
        let code = text.split("#[cfg(test)]").next().unwrap_or_default();
        let lines = code.lines().filter(|line| !line.trim().is_empty() && !line.trim_start().starts_with("//")).count();
        assert!(lines <= 420, "{} has {lines} lines of code: which two ideas does it hold?", file.display());
        let in_ffi = file.components().any(|part| part.as_os_str() == "ffi");
        let words = code.lines().filter(|line| !line.trim_start().starts_with("//") && !line.contains("unsafe_code"));
        assert!(in_ffi || !words.into_iter().any(|line| line.contains("unsafe ")), "{}: unsafe outside fmi/ffi", file.display());
    }
}

#[test]
fn prop_no_unwrap_or_expect_outside_tests() {
    for (file, text) in sources() {
        let code = text.split("#[cfg(test)]").next().unwrap_or_default();
        // A file of tests is as good as a module of tests.
        if file.file_name().is_some_and(|name| name == "tests.rs" || name == "test_surfaces.rs") {
            continue;
        }
        for (number, line) in code.lines().enumerate() {
            let bare = line.contains(".unwrap()") || line.contains(".expect(") || line.contains("panic!(") || line.contains("todo!(");
            assert!(!bare, "{}:{}: {line}", file.display(), number + 1);
        }
    }
}
