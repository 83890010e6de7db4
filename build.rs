//! Gives program and FMU library a common build id: a hash of every source file and of the locked dependencies, so that `export`
//! can refuse a library that was built from other sources; and makes the table of Hertz's ellipses that would else be made at each start.

#[allow(dead_code, reason = "the program has use for the rest")]
#[path = "src/contact/normal/hertz_integrals.rs"]
mod hertz_integrals;

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

/// m_a, m_b and approach of `contact::normal::hertz_integrals`, little endian.
fn write_ellipses() {
    let nodes = hertz_integrals::nodes();
    let bytes: Vec<u8> = nodes.iter().flat_map(|node| [node.m_a, node.m_b, node.approach]).flat_map(f64::to_le_bytes).collect();
    let folder = std::env::var_os("OUT_DIR").unwrap_or_default();
    std::fs::write(Path::new(&folder).join("hertz_nodes.bin"), bytes).unwrap_or_else(|error| panic!("table of Hertz's ellipses: {error}"));
}

fn main() {
    write_ellipses();
    let mut files = vec![PathBuf::from("Cargo.toml"), PathBuf::from("Cargo.lock"), PathBuf::from("build.rs")];
    for folder in ["src", "fmu", "modelDescription"] {
        println!("cargo:rerun-if-changed={folder}");
        collect(Path::new(folder), &mut files);
    }
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rerun-if-changed=Cargo.toml");
    println!("cargo:rerun-if-changed=Cargo.lock");
    files.sort();
    let mut hash = Sha256::new();
    for file in &files {
        // Neither separators nor line ends of the host may change the id: a library that was built elsewhere, for another platform, has the same.
        hash.update(file.to_string_lossy().replace('\\', "/").as_bytes());
        let text = std::fs::read(file).unwrap_or_default();
        hash.update(text.split(|byte| *byte == b'\r').collect::<Vec<_>>().concat());
    }
    hash.update(std::env::var("PROFILE").unwrap_or_default().as_bytes());
    let id: String = hash.finalize().iter().take(12).map(|byte| format!("{byte:02x}")).collect();
    println!("cargo:rustc-env=WHEELRAIL_BUILD_ID={id}");
    let target = |part: &str| std::env::var(format!("CARGO_CFG_TARGET_{part}")).unwrap_or_default();
    if target("OS") == "linux" || (target("OS"), target("ENV")) == ("windows".into(), "gnu".into()) {
        // The FMU's library alone: programs keep their symbols for those who profile them.
        println!("cargo:rustc-cdylib-link-arg=-Wl,-s");
    }
    if target("OS") == "macos" {
        // A library there says what it is called: by itself the path that it was linked to.
        println!("cargo:rustc-cdylib-link-arg=-Wl,-install_name,@rpath/libwheelrail.dylib");
    }
    println!("cargo:rustc-env=WHEELRAIL_TARGET={}", std::env::var("TARGET").unwrap_or_default());
}
