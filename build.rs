//! Gives program and FMU library a common build id: a hash of every source file, so that `export`
//! can refuse a library that was built from other sources.

use sha2::{Digest, Sha256};
use std::path::{Path, PathBuf};

fn collect(folder: &Path, files: &mut Vec<PathBuf>) {
    let Ok(entries) = std::fs::read_dir(folder) else { return };
    for entry in entries.flatten() {
        let path = entry.path();
        if path.is_dir() {
            collect(&path, files);
        } else {
            files.push(path);
        }
    }
}

fn main() {
    let mut files = vec![PathBuf::from("Cargo.toml"), PathBuf::from("build.rs")];
    for folder in ["src", "fmu", "modelDescription"] {
        println!("cargo:rerun-if-changed={folder}");
        collect(Path::new(folder), &mut files);
    }
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rerun-if-changed=Cargo.toml");
    files.sort();
    let mut hash = Sha256::new();
    for file in &files {
        // Separators of the host must not change the id.
        hash.update(file.to_string_lossy().replace('\\', "/").as_bytes());
        hash.update(std::fs::read(file).unwrap_or_default());
    }
    for variable in ["PROFILE", "TARGET"] {
        hash.update(std::env::var(variable).unwrap_or_default().as_bytes());
    }
    let id: String = hash.finalize().iter().take(12).map(|byte| format!("{byte:02x}")).collect();
    println!("cargo:rustc-env=WHEELRAIL_BUILD_ID={id}");
    println!("cargo:rustc-env=WHEELRAIL_TARGET={}", std::env::var("TARGET").unwrap_or_default());
}
