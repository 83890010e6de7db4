//! A profile file that a scene names with `file`, relative to the scene.

use super::ProfileFile;
use crate::settings::{Section, SettingsError};
use std::path::Path;

/// An opened profile file.
pub(super) struct OpenFile {
    /// Path for messages.
    pub path: String,
    pub text: String,
    /// What an FMU must carry.
    pub kept: ProfileFile,
}

impl OpenFile {
    pub(super) fn open(section: &Section) -> Result<Self, SettingsError> {
        let name = section.text("file")?;
        let Some(folder) = &section.source().folder else {
            return Err(
                section.error("file", format!("found \"{name}\", but an embedded scene has no folder: save the scene to a file first"))
            );
        };
        let path = folder.join(&name);
        let content = std::fs::read(&path).map_err(|error| section.error("file", format!("can't read \"{}\": {error}", path.display())))?;
        // Instruments write comments in whatever code page they like; numbers are ASCII in all of them.
        let text = String::from_utf8_lossy(&content).into_owned();
        let kept = ProfileFile { key: section.full_key("file"), path: Path::new(&name).to_path_buf(), content };
        Ok(OpenFile { path: path.display().to_string(), text, kept })
    }

    /// Extension in small letters, empty without one.
    pub(super) fn extension(&self) -> String {
        self.kept.path.extension().map(|extension| extension.to_string_lossy().to_lowercase()).unwrap_or_default()
    }

    /// An error in `line` of the file (0: in the whole of it).
    pub(super) fn error(&self, line: usize, key: &str, problem: impl Into<String>) -> SettingsError {
        SettingsError { file: self.path.clone(), line, key: key.into(), problem: problem.into() }
    }
}
