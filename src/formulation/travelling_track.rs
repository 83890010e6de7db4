//! Track that gives way: a mass on springs and dampers under each wheel, which travels with it.
//!
//! The rail under a wheel is displaced by u = (0, u_y, u_z) in the axes of the track frame beside the wheelset's centre (left and up positive),
//! u = 0 where it carries nothing. With the force F of all contacts of the wheel on the wheelset:
//!
//! ```text
//! m_y u_y'' + c_y u_y' + k_y u_y = -F_y        m_z u_z'' + c_z u_z' + k_z u_z = -F_z
//! ```
//!
//! Wheel and rail then stand to each other as `rail_motion` says of rails that move from outside: the velocity of the rail's material is u', and it has
//! no slope along the track, because what travels along is the deflection, not the rail. At rest `u_z = -Q / k_z`; the receptance of the rail is
//! `1 / (k - m w^2 + i c w)`; a wheel of unsprung mass M swings on it at `sqrt(k_z / (M + m_z)) / (2 pi)`, the P2 frequency (Jenkins and others, 1974).
//!
//! *Numbers.* Vertically those of the group standard GM/TT0088 for the P2 force (one wheel on good track: 245 kg, 62 MN/m, 55.4 kN s/m). Laterally 170 kg, 25 MN/m
//! and 20 kN s/m are assumed, of the usual size (a third to a half of the vertical stiffness).
//!
//! *Energy.* Vehicle and track together keep theirs, but for dampers and contacts: `m u'^2 / 2 + k u^2 / 2` is stored in each direction, `c u'^2` becomes heat.
//!
//! *Left out:* the rail's bending waves and the sleepers' spacing (above about 100 Hz a track answers otherwise), coupling of wheels and wheelsets through rail and sleeper,
//! turning of the rail's head under lateral force, the inertia of the travelling mass in curves, and the weight of the rail, which it carries before any wheel comes.
//! Rigid contact (ACCF, ECCF) is refused: its constraints would need the rails' accelerations among their unknowns.

use crate::settings::{Section, SettingsError};
use crate::units::Dimension;

/// u_y, u_z [m], u_y', u_z' [m/s] of one rail under one wheel.
pub const RAIL_STATES: usize = 4;
/// Least and greatest of what makes sense: kg, N/m, N s/m.
pub const MASSES: (f64, f64) = (1.0, 1e5);
pub const STIFFNESSES: (f64, f64) = (1e6, 1e12);
pub const DAMPINGS: (f64, f64) = (0.0, 1e8);

/// Track under one wheel in one direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Support {
    /// kg.
    pub mass: f64,
    /// N/m.
    pub stiffness: f64,
    /// N s/m.
    pub damping: f64,
}

/// Track under each wheel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TravellingTrack {
    pub lateral: Support,
    pub vertical: Support,
}

impl Default for TravellingTrack {
    fn default() -> Self {
        TravellingTrack {
            lateral: Support { mass: 170.0, stiffness: 25e6, damping: 20e3 },
            vertical: Support { mass: 245.0, stiffness: 62e6, damping: 55.4e3 },
        }
    }
}

impl TravellingTrack {
    /// Reads the table `flexibility` with `model = "travelling"`.
    ///
    /// # Errors
    /// [`SettingsError`] with file and line.
    pub(super) fn read(section: &Section) -> Result<Self, SettingsError> {
        let usual = Self::default();
        Ok(TravellingTrack {
            lateral: support(section, LATERAL, usual.lateral)?,
            vertical: support(section, ["vertical_mass", "vertical_stiffness", "vertical_damping"], usual.vertical)?,
        })
    }

    /// Numbers of the lateral and the vertical direction by what they are.
    pub(super) fn pairs(&self) -> [[f64; 2]; 3] {
        let of = |number: fn(&Support) -> f64| [number(&self.lateral), number(&self.vertical)];
        [of(|support| support.mass), of(|support| support.stiffness), of(|support| support.damping)]
    }

    /// What it is, for `wheelrail plan`.
    pub fn describe(&self) -> String {
        let of =
            |Support { mass, stiffness, damping }: Support| format!("{mass} kg on {} MN/m and {} kN s/m", 1e-6 * stiffness, 1e-3 * damping);
        format!("under each wheel {} vertically, {} laterally", of(self.vertical), of(self.lateral))
    }

    /// Frequency with which half of an unsprung mass [kg] of a wheelset swings on its rail, Hz.
    pub fn p2_frequency(&self, unsprung: f64) -> f64 {
        let Support { mass, stiffness, .. } = self.vertical;
        (stiffness / (0.5 * unsprung + mass)).sqrt() / std::f64::consts::TAU
    }
}

/// A number of the section, or `default` where it is absent.
pub(super) fn number(
    section: &Section,
    key: &'static str,
    dimension: Dimension,
    default: f64,
    range: (f64, f64),
) -> Result<f64, SettingsError> {
    if section.has(key) { section.within(key, dimension, range) } else { Ok(default) }
}

/// A mass on a spring and a damper by its three keys.
pub(super) fn support(section: &Section, [mass, stiffness, damping]: [&'static str; 3], usual: Support) -> Result<Support, SettingsError> {
    Ok(Support {
        mass: number(section, mass, Dimension::Mass, usual.mass, MASSES)?,
        stiffness: number(section, stiffness, Dimension::Stiffness, usual.stiffness, STIFFNESSES)?,
        damping: number(section, damping, Dimension::Damping, usual.damping, DAMPINGS)?,
    })
}

pub(super) const LATERAL: [&str; 3] = ["lateral_mass", "lateral_stiffness", "lateral_damping"];
