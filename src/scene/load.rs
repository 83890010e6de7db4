//! Opens a scene: an embedded one by name or a file, with `--set key=value` applied to its text.

use super::assemble;
use super::embedded;
use super::equilibrium::{self, EquilibriumError};
use super::spec::{INITIAL, Scene};
use super::start::{self, Start};
use crate::formulation::AssemblyError;
use crate::settings::{Section, SettingsError, Source, did_you_mean};
use std::path::{Path, PathBuf};
use toml_edit::{ArrayOfTables, Document, DocumentMut, Item, Table};

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
    #[error("{file}: {error}")]
    Assembly { file: String, error: AssemblyError },
    #[error("{file}: {error}")]
    Equilibrium { file: String, error: EquilibriumError },
}

/// Opens the embedded scene `name`, or the file of that path.
///
/// # Errors
/// [`SceneError`], with file and line where they are known.
pub fn open(name: &str, overrides: &[String]) -> Result<Scene, SceneError> {
    if let Some(scene) = embedded::find(name) {
        let source = Source { file: format!("{name}.toml"), text: scene.text.into(), overridden: vec![], folder: None };
        return read(name, source, overrides);
    }
    let path = Path::new(name);
    if !path.is_file() {
        let known: Vec<&str> = embedded::SCENES.iter().map(|scene| scene.name).collect();
        return Err(SceneError::NotFound { name: name.into(), suggestion: did_you_mean(name, &known), known: known.join(", ") });
    }
    open_file(path, &identifier(path), overrides)
}

/// Opens a scene file under a given name.
///
/// # Errors
/// [`SceneError`].
pub fn open_file(path: &Path, name: &str, overrides: &[String]) -> Result<Scene, SceneError> {
    let text = std::fs::read_to_string(path).map_err(|error| SceneError::Unreadable { path: path.into(), problem: error.to_string() })?;
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let source = Source { file: path.display().to_string(), text, overridden: vec![], folder: Some(folder.into()) };
    read(name, source, overrides)
}

/// A file name as an identifier that C and XML accept.
fn identifier(path: &Path) -> String {
    let stem = path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
    let mut name: String = stem.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    if !name.starts_with(|c: char| c.is_ascii_alphabetic()) {
        name.insert_str(0, "scene_");
    }
    name
}

/// Reads a scene from text.
///
/// # Errors
/// [`SceneError`].
pub fn read(name: &str, mut source: Source, overrides: &[String]) -> Result<Scene, SceneError> {
    for argument in overrides {
        let (key, text) = apply_override(&source.text, argument)?;
        source.text = text;
        source.overridden.push(key);
    }
    let document = Document::parse(source.text.clone()).map_err(|error| syntax(&source, &error))?;
    let root = Section::root(document.as_table(), &source);
    let mut scene = Scene::read(name, root, source.clone())?;
    // What a formulation refuses is known before anything is run.
    assemble::model(&scene).map_err(|error| SceneError::Assembly { file: scene.source.file.clone(), error })?;
    resolve_initial(&mut scene)?;
    Ok(scene)
}

fn syntax(source: &Source, error: &toml_edit::TomlError) -> SceneError {
    let start = error.span().map_or(0, |span| span.start.min(source.text.len()));
    let line = source.text.as_bytes()[..start].iter().filter(|&&b| b == b'\n').count() + 1;
    SceneError::Syntax { file: source.file.clone(), line, problem: error.message().trim().to_string() }
}

/// Replaces one value in a scene's text, keeping comments; returns the dotted key and the new text.
fn apply_override(text: &str, argument: &str) -> Result<(String, String), SceneError> {
    let refuse = |problem: String| SceneError::Override { argument: argument.into(), problem };
    let (key, value) = argument.split_once('=').ok_or_else(|| refuse("expected key=value, for example vehicle.speed=30".into()))?;
    let (key, value) = (key.trim(), value.trim());
    let mut document: DocumentMut =
        text.parse().map_err(|error: toml_edit::TomlError| refuse(format!("the scene can't be read: {error}")))?;
    let item: Item = match value.parse::<toml_edit::Value>() {
        Ok(value) => value.into(),
        // Words and quantities need no quotes on the command line.
        Err(_) => toml_edit::Value::from(value).into(),
    };
    let mut path: Vec<&str> = key.split('.').collect();
    let last = path.pop().filter(|last| !last.is_empty()).ok_or_else(|| refuse("the key is empty".into()))?;
    let mut table: &mut dyn toml_edit::TableLike = document.as_table_mut();
    for step in path {
        let (step, index) = match step.split_once('[') {
            Some((step, index)) => {
                let inner = index.strip_suffix(']').filter(|inner| !inner.is_empty());
                (step, Some(inner.ok_or_else(|| refuse(format!("\"[{index}\" is not a number or name in brackets")))?))
            }
            None => (step, None),
        };
        let number = index.and_then(|index| index.parse::<usize>().ok());
        let named = index.is_some() && number.is_none();
        let entry = table.entry(step).or_insert_with(|| match named {
            true => Item::ArrayOfTables(ArrayOfTables::new()),
            false => Item::Table(Table::new()),
        });
        table = match (index, entry) {
            (Some(index), Item::ArrayOfTables(tables)) => {
                let count = tables.len();
                entry_at(tables, index).ok_or_else(|| refuse(format!("{step} has {count} entries, counted from 1")))?
            }
            (Some(_), Item::Value(toml_edit::Value::Array(values))) => {
                let count = values.len();
                let place = number.and_then(|index| index.checked_sub(1));
                let value = place.and_then(|i| values.get_mut(i)).and_then(|value| value.as_inline_table_mut());
                value.ok_or_else(|| refuse(format!("{step} has {count} entries, counted from 1")))?
            }
            (None, entry) if entry.is_table_like() => entry.as_table_like_mut().ok_or_else(|| refuse(format!("{step} is not a table")))?,
            _ => return Err(refuse(format!("{step} is not a table of that kind"))),
        };
    }
    match (table.get_mut(last), item) {
        // A word stays one, whatever it looks like (60e1 is a rail, not 600); quantities may be numbers in quotes.
        (Some(Item::Value(toml_edit::Value::String(old))), Item::Value(toml_edit::Value::Integer(_) | toml_edit::Value::Float(_))) => {
            let mut new = toml_edit::Formatted::new(value.to_string());
            *new.decor_mut() = old.decor().clone();
            *old = new;
        }
        // Keep the old value's surroundings (spaces, comments).
        (Some(Item::Value(old)), Item::Value(mut new)) => {
            *new.decor_mut() = old.decor().clone();
            *old = new;
        }
        (_, item) => {
            table.insert(last, item);
        }
    }
    Ok((key.to_string(), document.to_string()))
}

/// The table of that number, counted from 1, or of that `name`; one of an unknown name is made, to change what a template says.
fn entry_at<'t>(tables: &'t mut ArrayOfTables, index: &str) -> Option<&'t mut dyn toml_edit::TableLike> {
    let place = match index.parse::<usize>() {
        Ok(number) => number.checked_sub(1)?,
        Err(_) => tables.iter().position(|table| table.get("name").and_then(Item::as_str) == Some(index)).unwrap_or(tables.len()),
    };
    if place == tables.len() && index.parse::<usize>().is_err() {
        let mut table = Table::new();
        table.insert("name", toml_edit::value(index));
        tables.push(table);
    }
    tables.get_mut(place).map(|table| table as &mut dyn toml_edit::TableLike)
}

/// Turns initial values that the scene gives into what the FMU shows: offsets to the equilibrium, or absolute values
/// where `from_equilibrium = false`, absent ones taken from the equilibrium of this moment.
fn resolve_initial(scene: &mut Scene) -> Result<(), SceneError> {
    let initial = &mut scene.vehicle.initial;
    if initial.from_equilibrium && initial.given.iter().all(Option::is_none) {
        return Ok(());
    }
    // The equilibrium is that of the track there.
    initial.values[0] = initial.given[0].unwrap_or(0.0);
    // Only these are not zero in the equilibrium; where all of them are given it need not exist.
    let not_zero: &[&str] = match start::start(scene) {
        Start::Curve(_) => &["y", "z", "roll", "yaw", "pitch_rate"],
        _ if equilibrium::alike(scene) => &["z", "pitch_rate"],
        _ => &["z", "pitch_rate", "roll"],
    };
    let initial = &scene.vehicle.initial;
    let needed =
        initial.from_equilibrium || INITIAL.iter().zip(initial.given).any(|(key, given)| given.is_none() && not_zero.contains(&key.0));
    let found = if needed {
        equilibrium::steady_rolling(scene)
            .map_err(|error| SceneError::Equilibrium { file: scene.source.file.clone(), error })?
            .initial_values()
    } else {
        [0.0; INITIAL.len()]
    };
    let initial = &mut scene.vehicle.initial;
    for ((value, given), found) in initial.values.iter_mut().zip(initial.given).zip(found) {
        let absolute = given.unwrap_or(found);
        *value = if initial.from_equilibrium { absolute - found } else { absolute };
    }
    Ok(())
}
