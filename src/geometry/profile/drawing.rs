//! Rows of the data files that the program carries (`data/*.csv`, mm): read once, when a scene names the profile.

use crate::settings::{Section, SettingsError};
use serde::de::DeserializeOwned;

/// Metres per millimetre.
pub(super) const MM: f64 = 1e-3;

/// The rows of an embedded CSV file; an error there is one of the program, not of the scene.
pub(super) fn rows<T: DeserializeOwned>(section: &Section, text: &str) -> Result<Vec<T>, SettingsError> {
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_reader(text.as_bytes());
    let rows: Result<Vec<T>, csv::Error> = reader.deserialize().collect();
    rows.map_err(|error| section.error("kind", format!("the program's own data can't be read: {error}")))
}

/// For data of the program that make no profile.
pub(super) fn broken(section: &Section) -> SettingsError {
    section.error("kind", "the program's own data make no profile")
}
