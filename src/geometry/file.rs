//! A file that a scene names with `file`, relative to the scene: a profile, a measured irregularity.

use crate::settings::{Section, SettingsError};
use std::path::{Path, PathBuf};

/// Largest file, bytes: a million points of a series with all columns.
const LARGEST: u64 = 128 << 20;

/// A file that a scene refers to.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneFile {
    /// Dotted key in the scene that names the file.
    pub key: String,
    pub path: PathBuf,
    pub content: Vec<u8>,
    /// Folder for files of its kind among an FMU's resources.
    pub folder: &'static str,
}

/// An opened file.
pub(super) struct OpenFile {
    /// Path for messages.
    pub path: String,
    pub text: String,
    /// What an FMU must carry.
    pub kept: SceneFile,
}

impl OpenFile {
    /// Opens what `section.file` names; an FMU keeps it in `keep_in`.
    pub(super) fn open(section: &Section, keep_in: &'static str) -> Result<Self, SettingsError> {
        let name = section.text("file")?;
        let Some(folder) = &section.source().folder else {
            return Err(
                section.error("file", format!("found \"{name}\", but an embedded scene has no folder: save the scene to a file first"))
            );
        };
        let path = folder.join(&name);
        let unreadable = |problem: String| section.error("file", format!("can't read \"{}\": {problem}", path.display()));
        let about = std::fs::metadata(&path).map_err(|error| unreadable(error.to_string()))?;
        // A device or a pipe may have no end.
        if !about.is_file() {
            return Err(unreadable("it is no file".into()));
        }
        if about.len() > LARGEST {
            return Err(unreadable(format!("it has {} MB; expected at most {} MB", about.len() >> 20, LARGEST >> 20)));
        }
        let content = std::fs::read(&path).map_err(|error| unreadable(error.to_string()))?;
        // Instruments write comments in whatever code page they like; numbers are ASCII in all of them.
        let text = String::from_utf8_lossy(&content).into_owned();
        let kept = SceneFile { key: section.full_key("file"), path: Path::new(&name).to_path_buf(), content, folder: keep_in };
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
