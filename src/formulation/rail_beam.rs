//! Track that gives way as rails on sleepers (`track.flexibility = "beam"`): its numbers, and the rails that a vehicle needs.
//!
//! Vertically each rail is a Timoshenko beam on pads, sleepers and ballast, which the wheels run along: sleepers pass under them (V / L), waves go ahead and behind, and couple
//! the wheels of a bogie. Modes up to a highest frequency are kept; what the others give way stands for itself under each wheel ([`LeftOut`]). The track has no end: it is a ring (`mbs::ring` has the equations), so much longer than the
//! wheels that stand on it as waves need to die out to [`LEFT`]. Wheels that far from the next have a ring of their own; all are alike. Laterally a mass travels under each wheel as in
//! [`super::travelling_track`].
//!
//! *Numbers.* Rails: EN 13674-1 (mass per metre, area, vertical second moment), E = 210 GPa, G = 81 GPa, 7850 kg/m3, shear coefficient 0.4 (usual for rails), loss factor 0.02
//! (of the usual size). Sleepers are 0.6 m apart. Pads, sleepers and ballast are assumed, of the size of published sets for concrete sleepers (half a sleeper 125 kg and pads of 65 MN/m:
//! Zhai, Wang, Lin, J. Sound Vib. 270, 2004; 170 kg, 225 MN/m: Math. Problems in Engineering 2017, 5872419): 150 kg, stiff pads of 200 MN/m with a loss factor
//! of about 0.25 at 500 Hz, ballast of 50 MN/m with one of about 1 at 100 Hz. Dampers are viscous.
//!
//! *Left out:* left and right rail do not know each other (each has its half of the sleepers), pads have no length and hold no turn, ballast has no mass, supports never lift off;
//! lateral bending, torsion and the turn of the head. Steady states (starts) stand on the mean of this track over a bay: a mass that travels on its mean stiffness; `modes` on
//! one that answers as the track does where a wheelset swings on it ([`RailBeam::stand_in`]).

use super::travelling_track::{DAMPINGS, LATERAL, MASSES, Support, TravellingTrack, number, support};
use crate::mbs::ring::{Bay, LeftOut, Ring};
use crate::settings::{Section, SettingsError};
use crate::units::Dimension;
use std::f64::consts::TAU;
use std::sync::Arc;

/// What is left of a wave that has gone round, in parts of its amplitude.
const LEFT: f64 = 0.01;
/// Track before the first and behind the last wheel of a ring, together, m: at least and at most.
const BESIDE: (f64, f64) = (24.0, 150.0);
/// Distance up to which wheels share a ring of any length, and from the first to the last wheel that share one because of waves between them, m: the work grows with its square.
const APART: f64 = 12.0;
const SHARED: f64 = 60.0;
/// Steel: E and G, N/m2, density, kg/m3, and the shear coefficient of a rail.
const YOUNGS_MODULUS: f64 = 210e9;
const SHEAR_MODULUS: f64 = 81e9;
const DENSITY: f64 = 7850.0;
const SHEAR_COEFFICIENT: f64 = 0.4;
/// Of what stands for the modes that are left out: far above what they are asked, so that it does not ring.
const LOCAL_DAMPING: f64 = 0.1;
/// By name: kg/m, area in m2 and vertical second moment in m4.
const RAILS: [(&str, [f64; 3]); 2] = [("60E1", [60.21, 76.70e-4, 3038.3e-8]), ("54E1", [54.77, 69.77e-4, 2337.9e-8])];
/// Rounds in which the frequency of a wheel on its rail settles.
const SETTLED: usize = 30;
/// Least and greatest of what makes sense.
const SPACINGS: (f64, f64) = (0.2, 2.0);
const PADS: (f64, f64) = (1e6, 1e11);
const SLEEPERS: (f64, f64) = (1.0, 1e4);
const LOSSES: (f64, f64) = (0.0, 0.5);
/// Hz. The rail below it is what a contact and a sleeper feel; above it a section is no beam.
const FREQUENCIES: (f64, f64) = (300.0, 20000.0);
const BAYS: (f64, f64) = (8.0, 2000.0);

/// Rails on sleepers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RailBeam {
    pub rail: &'static str,
    pub bay: Bay,
    pub lateral: Support,
    /// Modes up to this one, Hz.
    pub highest: f64,
    /// In the ring; `None`: as many as the vehicle needs.
    pub bays: Option<usize>,
}

impl Default for RailBeam {
    fn default() -> Self {
        let (rail, section) = RAILS[0];
        let bay = Bay {
            bending: 0.0,
            shear: 0.0,
            mass: 0.0,
            rotary: 0.0,
            loss: 0.02,
            spacing: 0.6,
            pad_stiffness: 200e6,
            pad_damping: 16e3,
            sleeper_mass: 150.0,
            ballast_stiffness: 50e6,
            ballast_damping: 80e3,
        };
        RailBeam { rail, bay: of_section(bay, section), lateral: TravellingTrack::default().lateral, highest: 3000.0, bays: None }
    }
}

fn of_section(bay: Bay, [mass, area, second_moment]: [f64; 3]) -> Bay {
    Bay {
        bending: YOUNGS_MODULUS * second_moment,
        shear: SHEAR_COEFFICIENT * SHEAR_MODULUS * area,
        mass,
        rotary: DENSITY * second_moment,
        ..bay
    }
}

impl RailBeam {
    /// Reads the table `flexibility` with `model = "beam"`.
    ///
    /// # Errors
    /// [`SettingsError`] with file and line.
    pub(super) fn read(section: &Section) -> Result<Self, SettingsError> {
        let usual = RailBeam::default();
        let name = section.word_or("rail", &RAILS.map(|(name, _)| name), usual.rail)?;
        let (rail, numbers) = RAILS.into_iter().find(|(own, _)| *own == name).unwrap_or(RAILS[0]);
        let bay = of_section(usual.bay, numbers);
        let bay = Bay {
            loss: number(section, "rail_loss_factor", Dimension::None, bay.loss, LOSSES)?,
            spacing: number(section, "sleeper_spacing", Dimension::Length, bay.spacing, SPACINGS)?,
            pad_stiffness: number(section, "pad_stiffness", Dimension::Stiffness, bay.pad_stiffness, PADS)?,
            pad_damping: number(section, "pad_damping", Dimension::Damping, bay.pad_damping, DAMPINGS)?,
            sleeper_mass: number(section, "sleeper_mass", Dimension::Mass, bay.sleeper_mass, SLEEPERS)?,
            ballast_stiffness: number(section, "ballast_stiffness", Dimension::Stiffness, bay.ballast_stiffness, PADS)?,
            ballast_damping: number(section, "ballast_damping", Dimension::Damping, bay.ballast_damping, DAMPINGS)?,
            ..bay
        };
        let highest = number(section, "highest_frequency", Dimension::None, usual.highest, FREQUENCIES)?;
        let bays = if section.has("bays") { Some(section.within("bays", Dimension::None, BAYS)?) } else { None };
        if let Some(count) = bays.filter(|count| count % 2.0 != 0.0) {
            return Err(section.error("bays", format!("found {count:?}, expected an even whole number of bays in the ring")));
        }
        let lateral = support(section, LATERAL, usual.lateral)?;
        Ok(RailBeam { rail, bay, lateral, highest, bays: bays.map(|count| count as usize) })
    }

    /// The rails under wheelsets that stand at these places along the track [m] and run at `speed` [m/s].
    pub fn lay(&self, places: &[f64], speed: f64) -> LaidRails {
        let mut order: Vec<usize> = (0..places.len()).collect();
        order.sort_by(|a, b| places[*b].total_cmp(&places[*a]));
        let apart = |from: usize, to: usize| places[from] - places[to];
        // Those that stand together, and of these those whose waves meet.
        let mut together: Vec<Vec<usize>> = Vec::new();
        for index in order {
            match together.last_mut().filter(|group| group.last().is_some_and(|last| apart(*last, index) <= APART)) {
                Some(group) => group.push(index),
                None => together.push(vec![index]),
            }
        }
        // How far waves go.
        let decay = self.bay.least_decay(self.highest);
        let reach = (LEFT.recip().ln() / decay).clamp(BESIDE.0, BESIDE.1);
        let most = self.bays.map_or(SHARED, |bays| 0.5 * bays as f64 * self.bay.spacing);
        let mut groups: Vec<Vec<usize>> = Vec::new();
        let mut parted = f64::INFINITY;
        for own in together {
            let (first, last) = (own[0], own[own.len() - 1]);
            let gap = groups.last().map_or(f64::INFINITY, |before| apart(before[before.len() - 1], first));
            match groups.last_mut().filter(|before| gap <= reach && apart(before[0], last) < most) {
                Some(before) => before.extend(own),
                None => {
                    parted = parted.min(gap);
                    groups.push(own);
                }
            }
        }
        let span = |group: &Vec<usize>| places[group[0]] - group.last().map_or(0.0, |last| places[*last]);
        let longest = groups.iter().map(span).fold(0.0, f64::max);
        let half = ((longest + reach) / (2.0 * self.bay.spacing)).ceil();
        let bays = self.bays.unwrap_or(2 * half as usize);
        let mut seats = vec![Seat::default(); places.len()];
        for (number, group) in groups.iter().enumerate() {
            group.iter().enumerate().for_each(|(place, index)| seats[*index] = Seat { group: number, place });
        }
        let ring = Arc::new(Ring::new(&self.bay, bays, TAU * self.highest));
        let LeftOut { compliance, square, .. } = ring.left_out();
        let mass = 1.0 / (compliance * square);
        let local = Support { mass, stiffness: 1.0 / compliance, damping: 2.0 * LOCAL_DAMPING * mass * square.sqrt() };
        let stand_in = TravellingTrack { lateral: self.lateral, ..TravellingTrack::default() };
        let under = TravellingTrack { lateral: self.lateral, vertical: local };
        let mut rails = LaidRails { ring, under, groups, seats, longest, parted, decay, stand_in };
        rails.stand_in.vertical.stiffness = 1.0 / rails.mean_sag(places, speed);
        rails
    }

    /// What stands under each wheel for this track where an unsprung mass of `unsprung` [kg] swings on it (P2): a mass on a spring and a damper that answer there, and at
    /// rest, as the rail does under a wheel that travels. The frequency too, Hz.
    ///
    /// With the dynamic stiffness `D = 1 / receptance` at `w = sqrt(Re D / M)`: `k - m w^2 = Re D`, `c w = Im D`; k that at rest, or where the track is stiffer at w, what the
    /// least mass asks for.
    pub fn stand_in(&self, places: &[f64], speed: f64, unsprung: f64) -> (TravellingTrack, f64) {
        let rails = self.lay(places, speed);
        let left_out = rails.ring.left_out().compliance;
        let dynamic = |w: f64| (rails.ring.mean_receptance(w, speed) + left_out).inv();
        let mut stand_in = rails.stand_in;
        let mut w = (stand_in.vertical.stiffness / unsprung).sqrt();
        for _ in 0..SETTLED {
            w = (dynamic(w).re.max(MASSES.0) / unsprung).sqrt();
        }
        let answer = dynamic(w);
        let own = &mut stand_in.vertical;
        own.mass = ((own.stiffness - answer.re) / (w * w)).max(self.bay.mass * self.bay.spacing);
        own.stiffness = answer.re + own.mass * (w * w);
        own.damping = (answer.im / w).max(0.0);
        (stand_in, w / TAU)
    }

    /// The numbers, for `wheelrail plan`.
    pub fn describe(&self) -> String {
        let Bay { spacing, pad_stiffness, sleeper_mass, ballast_stiffness, .. } = self.bay;
        // MN/m, without what the conversion makes of its last digits.
        let [pad, ballast] = [pad_stiffness, ballast_stiffness].map(|stiffness| stiffness.round() / 1e6);
        format!("{} on pads of {pad} MN/m, half sleepers of {sleeper_mass} kg every {spacing} m and ballast of {ballast} MN/m", self.rail)
    }
}

/// Where a wheelset stands.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Seat {
    pub group: usize,
    pub place: usize,
}

/// The rails of a model.
#[derive(Clone, Debug)]
pub struct LaidRails {
    pub ring: Arc<Ring>,
    /// What travels under each wheel: the lateral mass, and on the ring what its modes leave out.
    pub under: TravellingTrack,
    /// Wheelsets that share rails, foremost first.
    pub groups: Vec<Vec<usize>>,
    /// By wheelset.
    pub seats: Vec<Seat>,
    /// From the first to the last wheelset of a group, m.
    pub longest: f64,
    /// Between wheels that stand next to each other on different rings, m.
    pub parted: f64,
    /// Of the wave that goes farthest, 1/m.
    pub decay: f64,
    /// What gives way like the mean of this track: under each wheel a mass that travels.
    pub stand_in: TravellingTrack,
}

impl LaidRails {
    /// What is left of a wave that has gone round, and of one that should have come to the next ring, in parts of its amplitude: of that which goes farthest.
    pub fn left_of_waves(&self) -> [f64; 2] {
        [self.ring.length() - self.longest, self.parted].map(|way| (-self.decay * way).exp())
    }

    /// Mean over a bay of how far the rail gives way under a wheel for each newton that it and the others carry alike, m/N.
    fn mean_sag(&self, places: &[f64], speed: f64) -> f64 {
        let sag = |own: usize| {
            let all = &self.groups[self.seats[own].group];
            all.iter().map(|other| self.ring.mean_compliance(places[own] - places[*other], speed)).sum::<f64>()
        };
        (0..places.len()).map(sag).sum::<f64>() / places.len().max(1) as f64 + self.ring.left_out().compliance
    }
}
