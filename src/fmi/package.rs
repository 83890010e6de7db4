//! The .fmu archive: description, library, resources and documentation, the same bytes every time.

use super::description;
use super::documentation;
use super::libraries::{self, Library};
pub use super::packed_scene::PackedScene;
use super::platform::Platform;
use super::terminals;
use super::variables::VariableTable;
use super::version::Version;
use crate::scene::load::{self, SceneError};
use crate::scene::spec::Scene;
use crate::scene::table_store;
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
    #[error("{}: can't be written: {problem}", path.display())]
    Unwritable { path: PathBuf, problem: String },
    #[error("{0}")]
    Scene(#[from] SceneError),
    #[error("the archive can't be made: {0}")]
    Archive(#[from] zip::result::ZipError),
    #[error("the scene's text can't be packed: {0}")]
    Text(String),
}

/// FMI 2.0's name of this host's platform folder.
pub fn platform() -> String {
    Platform::host().folder(Version::Two)
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
    for (key, table) in scene.tables.all() {
        resources.insert(format!("{}/{}", table_store::FOLDER, table_store::file_name(&key)), table_store::to_bytes(&table));
    }
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
pub(super) fn scratch_folder() -> Result<tempfile::TempDir, PackageError> {
    tempfile::tempdir().map_err(|error| PackageError::Unwritable { path: std::env::temp_dir(), problem: error.to_string() })
}

/// Where an FMU keeps its library for this host.
pub fn library_path(identifier: &str, version: Version) -> String {
    libraries::path(Platform::host(), identifier, version)
}

/// Files of an archive, by path, to a folder.
pub(super) fn write_folder(folder: &Path, files: &BTreeMap<String, Vec<u8>>) -> Result<(), PackageError> {
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

/// The entry point of license information.
const LICENSES: &str =
    concat!(include_str!("../../LICENSE"), "\n----\nThe library holds other software too, with licenses of its own: third_party.txt\n");

/// All files of the FMU.
pub fn files(packed: &PackedScene, libraries: &[Library]) -> BTreeMap<String, Vec<u8>> {
    let mut files: BTreeMap<String, Vec<u8>> = BTreeMap::new();
    files.insert("modelDescription.xml".into(), packed.description.xml.clone().into_bytes());
    for library in libraries {
        files.insert(library.path(&packed.scene.name, packed.table.version), library.bytes.clone());
    }
    files.insert("documentation/index.html".into(), documentation::html(packed).into_bytes());
    files.insert("documentation/licenses/license.txt".into(), LICENSES.as_bytes().to_vec());
    files.insert("documentation/licenses/third_party.txt".into(), include_bytes!("../../fmu/licenses/third_party.txt").to_vec());
    let icon = include_bytes!("../../fmu/model.png").to_vec();
    files.insert("terminalsAndIcons/terminalsAndIcons.xml".into(), terminals::xml(packed).into_bytes());
    files.insert("terminalsAndIcons/icon.png".into(), icon.clone());
    files.insert(format!("terminalsAndIcons/{}.png", terminals::ICON), include_bytes!("../../fmu/terminal.png").to_vec());
    files.insert("model.png".into(), picture(packed).unwrap_or(icon));
    for (name, content) in &packed.resources {
        files.insert(format!("resources/{name}"), content.clone());
    }
    files
}

/// The vehicle's own picture.
#[cfg(feature = "plot")]
fn picture(packed: &PackedScene) -> Option<Vec<u8>> {
    super::vehicle_picture::Drawing::new(&packed.scene.vehicle).png()
}

/// Without pictures: none.
#[cfg(not(feature = "plot"))]
fn picture(_: &PackedScene) -> Option<Vec<u8>> {
    None
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
