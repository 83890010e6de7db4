//! Opens the scene of a case, with the files that it reads in a folder of its own.

use super::case::Case;
use crate::scene::embedded;
use crate::scene::load::{self, SceneError};
use crate::scene::spec::Scene;
use crate::settings::Source;
use std::path::Path;
use tempfile::TempDir;

/// The folder of a case's files; it goes when this is dropped.
pub(super) fn folder(case: &Case) -> Result<Option<TempDir>, String> {
    let Some(files) = case.files else { return Ok(None) };
    let failed = |error: std::io::Error| format!("the scratch folder can't be written: {error}");
    let folder = tempfile::tempdir().map_err(failed)?;
    for (name, content) in files() {
        std::fs::write(folder.path().join(name), content).map_err(failed)?;
    }
    Ok(Some(folder))
}

/// The scene with its own changes and those that make it one of a formulation and a method.
pub(super) fn open(case: &Case, folder: Option<&Path>, more: &[String]) -> Result<Scene, SceneError> {
    let mut changes: Vec<String> = case.changes.iter().map(ToString::to_string).collect();
    changes.extend_from_slice(more);
    let text = match case.text {
        Some(text) => text(),
        None => embedded::find(case.scene).map(|scene| scene.text.to_string()).unwrap_or_default(),
    };
    read(case.scene, text, folder, &changes)
}

/// A scene from text.
pub(super) fn read(name: &str, text: String, folder: Option<&Path>, changes: &[String]) -> Result<Scene, SceneError> {
    let source = Source { file: format!("{name}.toml"), text, overridden: vec![], folder: folder.map(Path::to_path_buf) };
    load::read(name, source, changes)
}

/// Changes that set the formulation; a rigid wheel that lifts goes on elastically.
pub(super) fn formulation(name: &str) -> Vec<String> {
    vec![format!("contact.formulation={name}"), "contact.on_lift=elastic".into()]
}
