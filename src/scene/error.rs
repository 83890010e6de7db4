//! Why a scene cannot be used.

use super::embedded;
use super::equilibrium::EquilibriumError;
use crate::formulation::AssemblyError;
use crate::settings::{SettingsError, did_you_mean};
use std::path::PathBuf;

/// Why a scene cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    #[error("no embedded scene and no file is called \"{name}\"{suggestion}; embedded scenes: {known}")]
    NotFound { name: String, suggestion: String, known: String },
    #[error("{}: can't be read: {problem}", path.display())]
    Unreadable { path: PathBuf, problem: String },
    #[error("{file}:{line}: {problem}")]
    Syntax { file: String, line: usize, problem: String },
    #[error("--set {argument}: {problem}")]
    Override { argument: String, problem: String },
    #[error("{0}")]
    Settings(#[from] SettingsError),
    #[error("{}", lines(all))]
    Several { all: Vec<SettingsError> },
    #[error("{file}: {error}")]
    Assembly { file: String, error: AssemblyError },
    #[error(
        "{file}: track: at {distance:.3} m the {side} rail bends upwards with a radius of {bend:.3} m, a wheel of {radius:.3} m would stand on two places along the track, which are not modelled; make what deviates there longer or lower, or smooth it as a wheel does"
    )]
    Bend { file: String, side: &'static str, bend: f64, distance: f64, radius: f64 },
    #[error("{file}: {error}")]
    Equilibrium { file: String, error: EquilibriumError },
}

impl SceneError {
    /// Nothing is called `name`.
    pub fn unknown(name: &str) -> SceneError {
        let known: Vec<&str> = embedded::SCENES.iter().map(|scene| scene.name).collect();
        SceneError::NotFound { name: name.into(), suggestion: did_you_mean(name, &known), known: known.join(", ") }
    }
}

/// All faults of a scene, one in a line.
fn lines(all: &[SettingsError]) -> String {
    const SHOWN: usize = 30;
    let mut text = format!("{} faults in the scene:", all.len());
    for error in all.iter().take(SHOWN) {
        text += &format!("\n  {error}");
    }
    match all.len().checked_sub(SHOWN) {
        Some(more) if more > 0 => format!("{text}\n  ... and {more} more"),
        _ => text,
    }
}

impl From<Vec<SettingsError>> for SceneError {
    fn from(mut all: Vec<SettingsError>) -> Self {
        match all.len() {
            1 => SceneError::Settings(all.remove(0)),
            _ => SceneError::Several { all },
        }
    }
}
