//! The .fmu archive: description, library, resources and documentation, the same bytes every time.

use super::build_mark::{BUILD_MARK, MARK_PREFIX};
use super::description;
use super::documentation;
use super::ffi::{host, v3};
pub use super::packed_scene::PackedScene;
use super::terminals;
use super::variables::VariableTable;
use super::version::Version;
use crate::scene::load::{self, SceneError};
use crate::scene::spec::Scene;
use crate::settings::Source;
use std::collections::BTreeMap;
use std::io::{Cursor, Write};
use std::path::{Path, PathBuf};
use toml_edit::DocumentMut;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

/// Why no FMU was written.
#[derive(Debug, thiserror::Error)]
pub enum PackageError {
    #[error("no FMU library was found ({looked}); build it with `cargo build --release --lib`, or name it with --library FILE")]
    NoLibrary { looked: String },
    #[error("{}: can't be read: {problem}", path.display())]
    Unreadable { path: PathBuf, problem: String },
    #[error("{}: {found}; build program and library together with `cargo build --release` (see CONTRIBUTING.md)", path.display())]
    OtherBuild { path: PathBuf, found: String },
    #[error("{}: can't be written: {problem}", path.display())]
    Unwritable { path: PathBuf, problem: String },
    #[error("{0}")]
    Scene(#[from] SceneError),
    #[error("the archive can't be made: {0}")]
    Archive(#[from] zip::result::ZipError),
    #[error("the scene's text can't be packed: {0}")]
    Text(String),
    #[error("the finished FMU failed its check: {0}")]
    Check(#[from] host::HostError),
}

/// FMI 2.0's name of this host's platform folder.
pub fn platform() -> &'static str {
    Version::Two.platform()
}

/// File name of a shared library on this host.
fn library_name(stem: &str) -> String {
    format!("{}{stem}{}", if cfg!(windows) { "" } else { std::env::consts::DLL_PREFIX }, std::env::consts::DLL_SUFFIX)
}

/// The FMU's library of this program: the one that is named, else in `deps/` next to the program, else beside it.
///
/// # Errors
/// [`PackageError`] when there is none or it is of another build.
pub fn find_library(named: Option<&Path>) -> Result<Vec<u8>, PackageError> {
    let name = library_name("wheelrail");
    let folder = std::env::current_exe().ok().and_then(|program| program.parent().map(Path::to_path_buf)).unwrap_or_default();
    let candidates = match named {
        Some(path) => vec![path.to_path_buf()],
        None => vec![folder.join("deps").join(&name), folder.join(&name)],
    };
    let path = candidates.iter().find(|path| path.is_file()).ok_or_else(|| PackageError::NoLibrary {
        looked: candidates.iter().map(|path| path.display().to_string()).collect::<Vec<_>>().join(", "),
    })?;
    let bytes = std::fs::read(path).map_err(|error| PackageError::Unreadable { path: path.clone(), problem: error.to_string() })?;
    check_build(&bytes).map_err(|found| PackageError::OtherBuild { path: path.clone(), found })?;
    Ok(bytes)
}

/// Is this a library of the same build?
fn check_build(bytes: &[u8]) -> Result<(), String> {
    let contains = |needle: &[u8]| bytes.windows(needle.len()).any(|window| window == needle);
    if contains(BUILD_MARK.as_bytes()) {
        Ok(())
    } else if contains(MARK_PREFIX) {
        Err("this library was built from other sources than this program".into())
    } else {
        Err("this is not an FMU library of wheelrail".into())
    }
}

/// Prepares a scene for an FMU of FMI 2.0.
///
/// # Errors
/// [`PackageError`].
pub fn pack_scene(scene: &Scene) -> Result<PackedScene, PackageError> {
    pack_scene_as(scene, Version::Two)
}

/// Prepares a scene for an FMU. What an FMU reads back is what is described.
///
/// # Errors
/// [`PackageError`].
pub fn pack_scene_as(scene: &Scene, version: Version) -> Result<PackedScene, PackageError> {
    let mut document: DocumentMut =
        scene.source.text.parse().map_err(|error: toml_edit::TomlError| PackageError::Text(error.to_string()))?;
    document.insert("name", toml_edit::value(&scene.name));
    let mut resources = BTreeMap::new();
    for file in scene.files() {
        let stem = file.path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_else(|| "profile".into());
        let extension = file.path.extension().map_or_else(|| "csv".into(), |extension| extension.to_string_lossy().into_owned());
        let folder = file.folder;
        let mut path = format!("{folder}/{stem}.{extension}");
        let mut count = 1;
        while resources.get(&path).is_some_and(|content| *content != file.content) {
            count += 1;
            path = format!("{folder}/{stem}_{count}.{extension}");
        }
        set_text(&mut document, &file.key, &path);
        resources.insert(path, file.content.clone());
    }
    let text = document.to_string();
    resources.insert("scene.toml".into(), text.clone().into_bytes());

    // Read it back from a folder, exactly as an instance will.
    let folder = scratch_folder()?;
    write_folder(folder.path(), &resources)?;
    let source = Source { file: "resources/scene.toml".into(), text, overridden: vec![], folder: Some(folder.path().into()) };
    let scene = load::read(&scene.name, source, &[])?;
    let table =
        VariableTable::of_version(&scene, version).map_err(|error| SceneError::Assembly { file: scene.source.file.clone(), error })?;
    let description = description::describe(&scene, &table);
    Ok(PackedScene { scene, table, description, resources })
}

/// Replaces the string at a dotted key that is known to exist.
fn set_text(document: &mut DocumentMut, key: &str, text: &str) {
    let mut item = document.as_item_mut();
    for step in key.split('.') {
        // `name`, or `name[number]` in a list, counted from 1.
        let (name, number) = step.strip_suffix(']').and_then(|step| step.split_once('[')).map_or((step, None), |(name, n)| (name, Some(n)));
        let index = number.map(|number| number.parse::<usize>().unwrap_or(0).wrapping_sub(1));
        let next = item.get_mut(name).and_then(|entry| match index {
            Some(index) => entry.get_mut(index),
            None => Some(entry),
        });
        match next {
            Some(next) => item = next,
            None => return,
        }
    }
    *item = toml_edit::value(text);
}

/// A folder that is removed when it is dropped.
fn scratch_folder() -> Result<tempfile::TempDir, PackageError> {
    tempfile::tempdir().map_err(|error| PackageError::Unwritable { path: std::env::temp_dir(), problem: error.to_string() })
}

/// Where an FMU keeps its library for this host.
pub fn library_path(identifier: &str, version: Version) -> String {
    format!("binaries/{}/{identifier}{}", version.platform(), std::env::consts::DLL_SUFFIX)
}

fn write_folder(folder: &Path, files: &BTreeMap<String, Vec<u8>>) -> Result<(), PackageError> {
    for (name, content) in files {
        let path = folder.join(name);
        let unwritable = |error: std::io::Error| PackageError::Unwritable { path: path.clone(), problem: error.to_string() };
        if let Some(parent) = path.parent() {
            std::fs::create_dir_all(parent).map_err(unwritable)?;
        }
        std::fs::write(&path, content).map_err(unwritable)?;
    }
    Ok(())
}

/// All files of the FMU.
pub fn files(packed: &PackedScene, library: &[u8]) -> BTreeMap<String, Vec<u8>> {
    let mut files: BTreeMap<String, Vec<u8>> = BTreeMap::new();
    files.insert("modelDescription.xml".into(), packed.description.xml.clone().into_bytes());
    files.insert(library_path(&packed.scene.name, packed.table.version), library.to_vec());
    files.insert("documentation/index.html".into(), documentation::html(packed).into_bytes());
    files.insert("documentation/license.txt".into(), include_bytes!("../../LICENSE").to_vec());
    let icon = include_bytes!("../../fmu/model.png").to_vec();
    if packed.table.version == Version::Three {
        files.insert("terminalsAndIcons/terminalsAndIcons.xml".into(), terminals::xml(packed).into_bytes());
        files.insert("terminalsAndIcons/icon.png".into(), icon.clone());
        let terminal = include_bytes!("../../fmu/terminal.png").to_vec();
        files.insert(format!("terminalsAndIcons/{}.png", terminals::ICON), terminal);
    }
    files.insert("model.png".into(), icon);
    for (name, content) in &packed.resources {
        files.insert(format!("resources/{name}"), content.clone());
    }
    files
}

/// The archive's bytes: fixed order, fixed time stamps.
///
/// # Errors
/// [`PackageError::Archive`].
pub fn archive(files: &BTreeMap<String, Vec<u8>>) -> Result<Vec<u8>, PackageError> {
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    let options = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Deflated)
        .last_modified_time(DateTime::default())
        .unix_permissions(0o644);
    // The description comes first, where readers look for it.
    let first = files.iter().filter(|(name, _)| *name == "modelDescription.xml");
    for (name, content) in first.chain(files.iter().filter(|(name, _)| *name != "modelDescription.xml")) {
        zip.start_file(name.as_str(), options)?;
        zip.write_all(content).map_err(zip::result::ZipError::Io)?;
    }
    Ok(zip.finish()?.into_inner())
}

/// One row of the check's table: time and the values of the chosen outputs.
pub type CheckRow = (f64, Vec<f64>);

/// Unpacks the FMU's files to a folder, loads its own library and steps it; returns the values of `references` at
/// `rows` + 1 equidistant times from 0 to `stop`.
///
/// # Errors
/// [`PackageError::Check`] with the library's own words.
pub fn check(
    files: &BTreeMap<String, Vec<u8>>,
    packed: &PackedScene,
    references: &[u32],
    stop: f64,
    step: f64,
    rows: usize,
) -> Result<Vec<CheckRow>, PackageError> {
    let folder = scratch_folder()?;
    write_folder(folder.path(), files)?;
    let library = folder.path().join(library_path(&packed.scene.name, packed.table.version));
    let resources = super::uri::from_path(&folder.path().join("resources"));
    let guid = &packed.description.guid;
    let mut fmu: Box<dyn host::Steps> = match packed.table.version {
        Version::Two => Box::new(host::LoadedFmu::start(&library, guid, &resources)?),
        Version::Three => Box::new(v3::host::LoadedFmu::start(&library, guid, &folder.path().join("resources"))?),
    };
    let mut table = vec![(0.0, fmu.get_real(references)?)];
    let mut time = 0.0;
    for row in 1..=rows {
        let end = stop * row as f64 / rows as f64;
        for next in crate::sim::recording::communication_points(time, end, step) {
            fmu.do_step(time, next - time)?;
            time = next;
        }
        table.push((time, fmu.get_real(references)?));
    }
    Ok(table)
}
