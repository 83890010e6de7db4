//! Opens a scene: an embedded one by name or a file, with `--set key=value` applied to its text.

use super::assemble;
use super::embedded;
pub use super::error::SceneError;
use super::identifier::identifier;
use super::overrides;
use super::spec::{INITIAL, Scene};
use super::start::{self, Start};
use super::steady_state::{alike, steady_state};
use crate::formulation::Model;
use crate::geometry::Side;
use crate::settings::{Section, SettingsError, Source};
use std::path::Path;
use toml_edit::Document;

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
    if path.is_dir() {
        let problem = "it is a folder; expected a scene file in it";
        return Err(SceneError::Unreadable { path: path.into(), problem: problem.into() });
    }
    if !path.is_file() {
        return Err(SceneError::unknown(name));
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

/// Reads a scene from text.
///
/// # Errors
/// [`SceneError`].
pub fn read(name: &str, mut source: Source, overrides: &[String]) -> Result<Scene, SceneError> {
    let mut made = Vec::new();
    for argument in overrides {
        let done = overrides::apply(&source.text, argument)?;
        source.text = done.text;
        source.overridden.push(done.key);
        made.extend(done.made);
    }
    let document = Document::parse(source.text.clone()).map_err(|error| syntax(&source, &error))?;
    let root = Section::collecting(document.as_table(), &source);
    let explained = |all: Vec<SettingsError>| all.into_iter().map(|error| overrides::explain(error, &made)).collect::<Vec<_>>();
    let mut scene = Scene::read(name, root, source.clone()).map_err(explained)?;
    super::detail::cut(&mut scene)?;
    // What a formulation refuses is known before anything is run.
    let model = assemble::model(&scene).map_err(|error| SceneError::Assembly { file: scene.source.file.clone(), error })?;
    refuse_bridged_bends(&scene, &model)?;
    resolve_initial(&mut scene)?;
    Ok(scene)
}

/// A wheel may be this much less curved than a rail bends upwards, 1 where it just touches it at one place: the flange, a little larger than the
/// tread, touches too.
const MOST_BENT: f64 = 0.9;

/// Refuses rails that bend upwards so sharply that a wheel would stand on two places along the track, of which a contact search along the
/// profiles finds one, now this and now that.
fn refuse_bridged_bends(scene: &Scene, model: &Model) -> Result<(), SceneError> {
    for side in Side::BOTH {
        let Some((bend, distance)) = model.track.rail(side).sharpest_bend() else { continue };
        let radius = model.wheelsets.iter().map(|wheelset| wheelset.wheel(side).profile.at(0.0).value).fold(0.0, f64::max);
        if bend * radius > MOST_BENT {
            return Err(SceneError::Bend { file: scene.source.file.clone(), side: side.name(), bend: 1.0 / bend, distance, radius });
        }
    }
    Ok(())
}

fn syntax(source: &Source, error: &toml_edit::TomlError) -> SceneError {
    let start = error.span().map_or(0, |span| span.start.min(source.text.len()));
    let line = source.text.as_bytes()[..start].iter().filter(|&&b| b == b'\n').count() + 1;
    SceneError::Syntax { file: source.file.clone(), line, problem: error.message().trim().to_string() }
}

/// Turns initial values that the scene gives into what the FMU shows, which means the same by them: added to the equilibrium (absent ones: nothing),
/// or absolute where `from_equilibrium = false`, absent ones then taken from the equilibrium of this moment.
fn resolve_initial(scene: &mut Scene) -> Result<(), SceneError> {
    let initial = &mut scene.vehicle.initial;
    if initial.from_equilibrium {
        initial.values = initial.given.map(|given| given.unwrap_or(0.0));
        return Ok(());
    }
    // The equilibrium is that of the track there.
    initial.values[0] = initial.given[0].unwrap_or(0.0);
    // Only these are not zero in the equilibrium; where all of them are given it need not exist.
    let not_zero: &[&str] = match start::start(scene) {
        _ if start::displaced(scene).is_some() => &["y", "z", "roll", "yaw", "vy", "vz", "roll_rate", "yaw_rate", "pitch_rate"],
        Start::Curve(_) => &["y", "z", "roll", "yaw", "pitch_rate"],
        _ if alike(scene) => &["z", "pitch_rate"],
        _ => &["z", "pitch_rate", "roll"],
    };
    let initial = &scene.vehicle.initial;
    let needed = INITIAL.iter().zip(initial.given).any(|(key, given)| given.is_none() && not_zero.contains(&key.0));
    let found = if needed {
        steady_state(scene).map_err(|error| SceneError::Equilibrium { file: scene.source.file.clone(), error })?.initial_values()
    } else {
        [0.0; INITIAL.len()]
    };
    let initial = &mut scene.vehicle.initial;
    for ((value, given), found) in initial.values.iter_mut().zip(initial.given).zip(found) {
        *value = given.unwrap_or(found);
    }
    Ok(())
}
