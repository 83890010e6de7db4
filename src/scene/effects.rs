//! `[effects]`: effects that a scene leaves out, by one word each, although its other tables call for them.
//!
//! [`super::leave_out`] takes it off the data that was read, so that the model has no object of it: steps never ask whether an effect is on.

use super::vehicle::Element;
use crate::geometry::track::irregularity::Quantity;
use crate::settings::{Section, SettingsError, did_you_mean};

/// An effect that `effects.NAME = "off"` leaves out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Switch {
    Spin,
    Transient,
    FrictionAlong,
    FrictionAcross,
    Gyroscopic,
    Flange,
    OutOfRound,
    TrackFlexibility,
    Alignment,
    LongitudinalLevel,
    CrossLevel,
    Gauge,
    Curvature,
    Cant,
    Grade,
}

impl Switch {
    /// Every switch: key, name, and what is left out, in words.
    pub const ALL: [(Switch, &str, &str, &str); 15] = [
        (Switch::Spin, "spin", "spin creepage", "its lateral force and its moment"),
        (Switch::Transient, "transient", "transient contact", "[contact.transient]: creep is steady"),
        (Switch::FrictionAlong, "friction_along", "friction along the track", "[[contact.friction_along]]"),
        (Switch::FrictionAcross, "friction_across", "friction across the rail", "[contact.friction_across]"),
        (Switch::Gyroscopic, "gyroscopic", "gyroscopic moments", "of spinning wheelsets"),
        (Switch::Flange, "flange", "flanges", "wheels go on straight from where they lean by 10 deg"),
        (Switch::OutOfRound, "out_of_round", "wheels out of round", "flats and polygons"),
        (Switch::TrackFlexibility, "track_flexibility", "track that gives way", "track.flexibility: rails are rigid"),
        (
            Switch::Alignment,
            "alignment",
            "alignment of the rails",
            "mean lateral displacement of both rails, of deviations and irregularities",
        ),
        (Switch::LongitudinalLevel, "longitudinal_level", "longitudinal level", "mean vertical displacement of both rails"),
        (Switch::CrossLevel, "cross_level", "cross level", "difference of the rails' vertical displacements"),
        (Switch::Gauge, "gauge", "gauge deviation", "difference of the rails' lateral displacements"),
        (Switch::Curvature, "curvature", "curvature", "of [[track.node]]"),
        (Switch::Cant, "cant", "cant", "superelevation of [[track.node]]"),
        (Switch::Grade, "grade", "grade", "track.grade, and that of [[track.node]]"),
    ];

    /// Its key in `[effects]`.
    pub fn key(self) -> &'static str {
        Switch::ALL[self as usize].1
    }

    /// What it switches.
    pub fn name(self) -> &'static str {
        Switch::ALL[self as usize].2
    }

    /// What it leaves out.
    pub fn words(self) -> &'static str {
        Switch::ALL[self as usize].3
    }
}

/// The quantities of displaced rails.
pub const QUANTITIES: [(Switch, Quantity); 4] = [
    (Switch::Alignment, Quantity::Alignment),
    (Switch::LongitudinalLevel, Quantity::LongitudinalLevel),
    (Switch::CrossLevel, Quantity::CrossLevel),
    (Switch::Gauge, Quantity::Gauge),
];

/// `[effects]`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Effects {
    /// Switches that are off, in the order of [`Switch::ALL`].
    pub off: Vec<Switch>,
    /// Does curvature change within [`ABRUPT`] where it changes?
    pub abrupt: bool,
    /// Force elements that are left out, by name or [`stem`].
    pub without: Vec<String>,
    /// Is every effect of the scene computed at each evaluation, also where it is known to do nothing?
    pub all: bool,
    /// Are contacts of right wheels those of left ones in a mirror?
    pub half: bool,
}

/// Length over which the curvature of an abrupt transition changes, m.
pub const ABRUPT: f64 = 1.0;

/// The name of a force element without numbers and sides: `truck[1].damper[2].left` and its likes are `truck.damper`.
pub fn stem(name: &str) -> String {
    let parts =
        name.split('.').map(|part| part.split_once('[').map_or(part, |(word, _)| word)).filter(|part| !matches!(*part, "left" | "right"));
    parts.collect::<Vec<_>>().join(".")
}

impl Effects {
    /// Reads `[effects]` of a scene with these force elements (`None`: they could not be read).
    ///
    /// # Errors
    /// [`SettingsError`] with file and line.
    pub fn read(section: Section, forces: Option<&[Element]>) -> Result<Effects, SettingsError> {
        let mut off = Vec::new();
        for (switch, key, ..) in Switch::ALL {
            if section.word_or(key, &["on", "off"], "on")? == "off" {
                off.push(switch);
            }
        }
        let abrupt = section.word_or("transitions", &["on", "abrupt"], "on")? == "abrupt";
        let without = section.optional_texts("without")?.unwrap_or_default();
        if let Some(forces) = forces {
            let names: Vec<String> = forces.iter().flat_map(|force| [stem(force.0.name()), force.0.name().to_string()]).collect();
            let names: Vec<&str> = names.iter().map(String::as_str).collect();
            for name in &without {
                if !names.contains(&name.as_str()) {
                    let mut stems: Vec<String> = Vec::new();
                    for stem in forces.iter().map(|force| stem(force.0.name())) {
                        if !stems.contains(&stem) {
                            stems.push(stem);
                        }
                    }
                    let meant = did_you_mean(name, &names);
                    let known = if stems.is_empty() { "the vehicle has none".into() } else { stems.join(", ") };
                    return Err(section.error("without", format!("found \"{name}\"{meant}, expected force elements: {known}")));
                }
            }
        }
        let all = section.word_or("mode", &["auto", "all"], "auto")? == "all";
        let half = section.word_or("symmetry", &["none", "half"], "none")? == "half";
        section.finish()?;
        Ok(Effects { off, abrupt, without, all, half })
    }

    /// Is an effect left out?
    pub fn is_off(&self, switch: Switch) -> bool {
        self.off.contains(&switch)
    }

    /// Is this force element left out?
    pub fn leaves_out(&self, element: &str) -> bool {
        self.without.iter().any(|name| name == element || *name == stem(element))
    }

    /// What the scene's words leave out: name and reason, for the plan.
    pub fn describe(&self) -> Vec<(&'static str, String)> {
        let switches = self.off.iter().map(|switch| (switch.name(), format!("effects.{} = \"off\": {}", switch.key(), switch.words())));
        let abrupt =
            self.abrupt.then(|| ("transition curves", format!("effects.transitions = \"abrupt\": curvature changes within {ABRUPT} m")));
        let without =
            (!self.without.is_empty()).then(|| ("force elements", format!("effects.without = [\"{}\"]", self.without.join("\", \""))));
        let all = "effects.mode = \"all\": each effect is computed at each evaluation, also where it is known to do nothing";
        let all = self.all.then(|| ("guards", all.to_string()));
        let half = "effects.symmetry = \"half\": contacts of right wheels are those of left ones in a mirror";
        let half = self.half.then(|| ("right wheels", half.to_string()));
        switches.chain(abrupt).chain(without).chain(all).chain(half).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_every_switch_stands_at_its_place_in_the_list() {
        for (index, (switch, key, ..)) in Switch::ALL.into_iter().enumerate() {
            assert_eq!((switch as usize, switch.key()), (index, key));
        }
    }

    #[test]
    fn prop_stems_have_neither_numbers_nor_sides() {
        for (name, expected) in [
            ("truck[1].primary[2].left", "truck.primary"),
            ("coach[3].truck[2].lateral_stop", "coach.truck.lateral_stop"),
            ("coupler[1]", "coupler"),
            ("wheelset.suspension", "wheelset.suspension"),
        ] {
            assert_eq!(stem(name), expected);
        }
    }
}
