//! A vehicle on straight track as a flow over speed.

use super::station::{LENGTH, Section, Station, steady};
use crate::scene::spec::Scene;
use crate::solve::SettingKind;
use crate::study::cycles::{Flow, Lost, Turn};
use crate::study::modes::Mode;
use std::ops::ControlFlow;
use std::sync::{Mutex, PoisonError};

/// The loosest tolerance with which turns are integrated, m: they are differenced.
const TOLERANCE: f64 = 1e-7;
/// How much more exactly a motion is integrated again to see what that changes: of a tolerance, and of a step.
const FINER: f64 = 10.0;
const SHORTER: f64 = 2.0;
/// Error of a turn in parts of the tolerance, as runs beside each other show it; of a fixed step, m.
const LOCAL: f64 = 0.1;
const FIXED: f64 = 1e-8;
/// Vehicles that are kept at their speeds.
const KEPT: usize = 8;

/// A scene's vehicle.
pub struct Vehicle {
    scene: Scene,
    pub section: Section,
    unit: f64,
    kept: Mutex<Vec<Station>>,
}

/// The scene with its integrator as turns need it.
fn exact(scene: &Scene) -> Scene {
    let setting = scene.solver.integrator.setting();
    let value = if setting.kind == SettingKind::Tolerance { setting.value.min(TOLERANCE).max(setting.range.0) } else { setting.value };
    with(scene, value, 1.0)
}

fn with(scene: &Scene, setting: f64, finer: f64) -> Scene {
    let mut scene = scene.clone();
    scene.solver.integrator = scene.solver.integrator.with_setting(setting);
    scene.solver.load_tolerance /= finer;
    scene
}

impl Vehicle {
    /// About a swinging mode at a `speed` [m/s]; a change of speed by `unit` [m/s] counts as much as one of a swing by 1 mm.
    ///
    /// # Errors
    /// Why it has no limit cycles, in words.
    pub fn new(scene: &Scene, speed: f64, swinging: &Mode, unit: f64) -> Result<Self, String> {
        let scene = exact(scene);
        let simulation = steady(&scene, speed).map_err(|error| error.to_string())?;
        let section = Section::new(&simulation, &swinging.shape, 1.0 / swinging.frequency)?;
        Ok(Vehicle { scene, section, unit, kept: Mutex::default() })
    }

    /// The same, integrated more exactly.
    pub fn finer(&self) -> Self {
        let setting = self.scene.solver.integrator.setting();
        let (value, finer) = match setting.kind {
            SettingKind::Tolerance => ((setting.value / FINER).max(setting.range.0), FINER),
            SettingKind::Step => ((setting.value / SHORTER).max(setting.range.0), 1.0),
        };
        Vehicle { scene: with(&self.scene, value, finer), section: self.section.clone(), unit: self.unit, kept: Mutex::default() }
    }

    /// How turns are integrated, in words.
    pub fn integration(&self) -> String {
        let setting = self.scene.solver.integrator.setting();
        match setting.kind {
            SettingKind::Tolerance => format!("{}, tolerance {:.0e}", self.scene.solver.name, setting.value),
            SettingKind::Step => format!("{}, step {:.0e} s", self.scene.solver.name, setting.value),
        }
    }

    fn take(&self, speed: f64) -> Result<Station, Lost> {
        let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(found) = kept.iter().position(|station| station.speed == speed) {
            return Ok(kept.remove(found));
        }
        drop(kept);
        Station::new(&self.scene, speed)
    }

    fn give(&self, station: Station) {
        let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        if kept.len() >= KEPT {
            kept.remove(0);
        }
        kept.push(station);
    }

    /// Runs at a speed [m/s] without a stop; see [`Station::run`].
    ///
    /// # Errors
    /// [`Lost`].
    pub fn run(&self, speed: f64, from: &[f64], each: impl FnMut(Turn) -> ControlFlow<()>) -> Result<(), Lost> {
        let mut station = self.take(speed)?;
        let done = station.run(&self.section, from, each);
        self.give(station);
        done
    }
}

impl Flow for Vehicle {
    fn turn(&self, speed: f64, from: &[f64]) -> Result<Turn, Lost> {
        let mut found = None;
        self.run(speed, from, |turn| {
            found = Some(turn);
            ControlFlow::Break(())
        })?;
        found.ok_or(Lost::NoReturn)
    }

    fn unit(&self) -> f64 {
        self.unit
    }

    fn error(&self) -> f64 {
        let setting = self.scene.solver.integrator.setting();
        let error = if setting.kind == SettingKind::Tolerance { LOCAL * setting.value } else { FIXED };
        error / LENGTH
    }
}
