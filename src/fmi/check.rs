//! A finished FMU loaded and stepped as a master would do it: `wheelrail export` looks at what it has written.

use super::ffi::host::{HostError, LoadedFmu, Steps};
use super::ffi::v3;
use super::package::{self, PackageError};
use super::packed_scene::PackedScene;
use super::version::Version;
use std::collections::BTreeMap;

/// Why an FMU could not be looked at, or what it answered.
#[derive(Debug, thiserror::Error)]
pub enum CheckError {
    #[error("{0}")]
    Unpacked(Box<PackageError>),
    #[error("the finished FMU failed its check: {0}")]
    Host(#[from] HostError),
}

impl From<PackageError> for CheckError {
    fn from(error: PackageError) -> Self {
        CheckError::Unpacked(Box::new(error))
    }
}

/// One row of the check's table: time and the values of the chosen outputs.
pub type CheckRow = (f64, Vec<f64>);

/// Unpacks the FMU's files to a folder, loads its own library and steps it; returns the values of `references` at
/// `rows` + 1 equidistant times from 0 to `stop`.
///
/// # Errors
/// [`CheckError::Host`] with the library's own words.
pub fn check(
    files: &BTreeMap<String, Vec<u8>>,
    packed: &PackedScene,
    references: &[u32],
    stop: f64,
    step: f64,
    rows: usize,
) -> Result<Vec<CheckRow>, CheckError> {
    let folder = package::scratch_folder()?;
    package::write_folder(folder.path(), files)?;
    let library = folder.path().join(package::library_path(&packed.scene.name, packed.table.version));
    let resources = super::uri::from_path(&folder.path().join("resources"));
    let guid = &packed.description.guid;
    let mut fmu: Box<dyn Steps> = match packed.table.version {
        Version::Two => Box::new(LoadedFmu::start(&library, guid, &resources)?),
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
