//! `wheelrail contact SCENE --pose "y=3mm,load=50kN"`: one pose with all that the scene's laws say of it.

use super::{Arguments, load, notes, number};
use crate::cli::{Failure, print, table};
use crate::contact::creepage::Creepage;
use crate::scene::profile_notes::profile_doubts;
use crate::scene::spec::Scene;
use crate::settings::did_you_mean;
use crate::study::pose::{Answer, Height, Place, Question, pose as evaluate};
use crate::units::Dimension;
use serde_json::{Map, Value, json};
use std::f64::consts::PI;

/// What a pose may name: key, dimension, largest size in SI units.
const KEYS: [(&str, Dimension, f64); 11] = [
    ("y", Dimension::Length, 0.2),
    ("z", Dimension::Length, 10.0),
    ("roll", Dimension::Angle, 0.1),
    ("yaw", Dimension::Angle, 0.1),
    ("load", Dimension::Force, 1e6),
    ("approach", Dimension::Length, 5e-3),
    ("speed", Dimension::Speed, 500.0),
    ("pitch_rate", Dimension::AngularSpeed, 1e4),
    ("longitudinal", Dimension::None, 10.0),
    ("lateral", Dimension::None, 10.0),
    ("spin", Dimension::Curvature, 1e3),
];
/// Slower than this a wheelset has no creepages, m/s.
const SLOWEST: f64 = 0.05;

/// The keys that a pose gives, in the order of [`KEYS`].
struct Given([Option<f64>; KEYS.len()]);

impl Given {
    fn parse(text: &str) -> Result<Self, Failure> {
        let wrong = |what: String| Failure::Input(format!("--pose {text:?}: {what}"));
        let mut given = Given([None; KEYS.len()]);
        for part in text.split(',').map(str::trim).filter(|part| !part.is_empty()) {
            let names = KEYS.map(|key| key.0);
            let Some((name, value)) = part.split_once('=') else {
                return Err(wrong(format!("found {part:?}, expected key=value, e.g. \"y=3mm,yaw=5mrad,load=50kN\"")));
            };
            let (name, value) = (name.trim(), value.trim());
            let Some(index) = names.iter().position(|known| *known == name) else {
                return Err(wrong(format!("found key {name:?}{}, expected one of {}", did_you_mean(name, &names), names.join(", "))));
            };
            let (_, dimension, most) = KEYS[index];
            let found = dimension.parse(value).filter(|found| found.abs() <= most);
            let found =
                found.ok_or_else(|| wrong(format!("{name}: found {value:?}, expected {} of at most {most}", dimension.expectation())))?;
            if given.0[index].replace(found).is_some() {
                return Err(wrong(format!("{name} is given twice")));
            }
        }
        given.check().map_err(wrong)?;
        Ok(given)
    }

    fn of(&self, name: &str) -> Option<f64> {
        KEYS.iter().position(|key| key.0 == name).and_then(|index| self.0[index])
    }

    fn check(&self) -> Result<(), String> {
        let names = |keys: &[&'static str]| keys.iter().filter(|key| self.of(key).is_some()).copied().collect::<Vec<_>>();
        let heights = names(&["z", "load", "approach"]);
        if heights.len() > 1 {
            return Err(format!(
                "found {}, expected one of z, load and approach: each says how far the wheels are pressed down",
                heights.join(" and ")
            ));
        }
        let creepages = names(&["longitudinal", "lateral", "spin"]);
        if self.of("pitch_rate").is_some() && !creepages.is_empty() {
            return Err(format!("found pitch_rate and {}, expected a motion or creepages", creepages.join(", ")));
        }
        match (self.of("load"), self.of("speed")) {
            (Some(load), _) if !(load > 0.0) => Err(format!("load: found {load} N, expected a force above 0")),
            (_, Some(speed)) if !(speed.abs() >= SLOWEST) => Err(format!("speed: found {speed} m/s, expected at least {SLOWEST} m/s")),
            _ => Ok(()),
        }
    }

    fn question(&self, arguments: &Arguments, scene: &Scene) -> Result<Question, Failure> {
        let station = arguments.at.as_deref().map(|at| number("at", at, Dimension::Length)).transpose()?;
        let height = match (self.of("z"), self.of("approach"), self.of("load")) {
            (Some(z), ..) => Height::Stated(z),
            (_, Some(approach), _) => Height::Approach(approach),
            (_, _, Some(load)) => Height::Load(load),
            _ => Height::Load(load(arguments, scene)?),
        };
        let speed = self.of("speed").unwrap_or(scene.vehicle.speed);
        if !(speed.abs() >= SLOWEST) {
            let what = format!("--pose: the scene's speed is {speed} m/s, where there are no creepages; give one, e.g. speed=20");
            return Err(Failure::Input(what));
        }
        let [longitudinal, lateral, spin] = ["longitudinal", "lateral", "spin"].map(|key| self.of(key));
        let any = longitudinal.or(lateral).or(spin).is_some();
        let or_none = |value: Option<f64>| value.unwrap_or(0.0);
        let creepage = Creepage { longitudinal: or_none(longitudinal), lateral: or_none(lateral), spin: or_none(spin) };
        Ok(Question {
            y: or_none(self.of("y")),
            yaw: or_none(self.of("yaw")),
            roll: self.of("roll").or(arguments.no_roll.then_some(0.0)),
            height,
            station,
            speed,
            pitch_rate: self.of("pitch_rate"),
            creepage: any.then_some(creepage),
        })
    }
}

pub(super) fn pose(arguments: &Arguments, scene: &Scene, text_of_pose: &str) -> Result<(), Failure> {
    let question = Given::parse(text_of_pose)?.question(arguments, scene)?;
    let answer = evaluate(scene, &question).map_err(|error| Failure::Run(format!("{}: {error}", scene.source.file)))?;
    match arguments.json {
        true => print(&format!("{}\n", as_json(scene, &question, &answer)))?,
        false => print(&text(scene, &question, &answer))?,
    }
    Ok(())
}

/// A row: name in JSON, in words, factor and digits in words, and its value in SI units; `None` where nothing is pressed.
type Line = (&'static str, &'static str, f64, usize, fn(&Place) -> Option<f64>);

fn pressed(place: &Place) -> Option<&Place> {
    (place.found.report.normal_force > 0.0).then_some(place)
}

fn curvature(profile: &crate::geometry::profile::ProfilePoint) -> f64 {
    profile.d2 / (1.0 + profile.d1 * profile.d1).powf(1.5)
}

const LINES: [Line; 33] = [
    ("wheel_coordinate", "wheel coordinate u [mm]", 1e3, 3, |p| Some(p.found.report.parameters.wheel)),
    ("rail_coordinate", "rail coordinate eta [mm]", 1e3, 3, |p| Some(p.found.report.parameters.rail)),
    ("rolling_radius", "rolling radius [mm]", 1e3, 4, |p| Some(p.rolling_radius)),
    ("angle", "contact angle [deg]", 180.0 / PI, 4, |p| Some(p.angle)),
    ("lead", "lead [mm]", 1e3, 3, |p| Some(p.found.report.parameters.lead)),
    ("penetration", "penetration along the normal [um]", 1e6, 3, |p| Some(p.found.report.penetration)),
    ("wheel_curvature", "curvature of the wheel's profile R'' [1/m]", 1.0, 3, |p| Some(curvature(&p.found.report.profiles[0]))),
    ("rail_curvature", "curvature of the rail's profile f'' [1/m]", 1.0, 3, |p| Some(curvature(&p.found.report.profiles[1]))),
    ("half_curvature_along", "half relative curvature A along [1/m]", 1.0, 4, |p| Some(p.found.half_curvatures[0])),
    ("half_curvature_across", "half relative curvature B across [1/m]", 1.0, 4, |p| Some(p.found.half_curvatures[1])),
    ("share", "share of its force [-]", 1.0, 4, |p| Some(pressed(p)?.found.report.share)),
    ("normal_force", "normal force N [kN]", 1e-3, 4, |p| Some(pressed(p)?.found.report.normal_force)),
    ("stiffness", "stiffness K_h [1e10 N/m^1.5]", 1e-10, 4, |p| Some(pressed(p)?.found.report.stiffness)),
    ("slope", "dN/d(penetration) [MN/m]", 1e-6, 1, |p| Some(pressed(p)?.found.report.elastic_slope)),
    ("semi_axis_a", "semi-axis a, rolling direction [mm]", 1e3, 4, |p| Some(pressed(p)?.found.report.patch.a)),
    ("semi_axis_b", "semi-axis b, across [mm]", 1e3, 4, |p| Some(pressed(p)?.found.report.patch.b)),
    ("axis_ratio", "a/b [-]", 1.0, 4, |p| Some(pressed(p)?.found.report.patch.a / p.found.report.patch.b)),
    ("area", "area [mm2]", 1e6, 2, |p| Some(area(pressed(p)?))),
    ("mean_pressure", "mean pressure [MPa]", 1e-6, 1, |p| Some(pressed(p)?.found.report.normal_force / area(p))),
    ("highest_pressure", "highest pressure [MPa]", 1e-6, 1, |p| Some(pressed(p)?.found.highest_pressure)),
    ("c11", "Kalker's c11 [-]", 1.0, 4, |p| Some(p.kalker?.c11)),
    ("c22", "Kalker's c22 [-]", 1.0, 4, |p| Some(p.kalker?.c22)),
    ("c23", "Kalker's c23 [-]", 1.0, 4, |p| Some(p.kalker?.c23)),
    ("c33", "Kalker's c33 [-]", 1.0, 4, |p| Some(p.kalker?.c33)),
    ("friction", "friction coefficient [-]", 1.0, 4, |p| Some(p.friction)),
    ("longitudinal_creepage", "creepage along [1e-3]", 1e3, 5, |p| Some(pressed(p)?.found.report.creepage.longitudinal)),
    ("lateral_creepage", "creepage across [1e-3]", 1e3, 5, |p| Some(pressed(p)?.found.report.creepage.lateral)),
    ("spin_creepage", "spin [1/m]", 1.0, 5, |p| Some(pressed(p)?.found.report.creepage.spin)),
    ("creep_force_x", "creep force along [kN]", 1e-3, 4, |p| Some(pressed(p)?.found.report.creep_force.longitudinal)),
    ("creep_force_y", "creep force across [kN]", 1e-3, 4, |p| Some(pressed(p)?.found.report.creep_force.lateral)),
    ("spin_moment", "spin moment [N m]", 1.0, 3, |p| Some(pressed(p)?.found.report.creep_force.spin_moment)),
    ("used_friction", "creep force over mu N [-]", 1.0, 4, |p| used(pressed(p)?)),
    ("wear_number", "wear number, without spin [N]", 1.0, 2, |p| Some(wear(pressed(p)?))),
];

fn area(place: &Place) -> f64 {
    PI * place.found.report.patch.a * place.found.report.patch.b
}

fn used(place: &Place) -> Option<f64> {
    let report = &place.found.report;
    let bound = place.friction * report.normal_force;
    (bound > 0.0).then(|| report.creep_force.longitudinal.hypot(report.creep_force.lateral) / bound)
}

/// |Fx xi_x| + |Fy xi_y|, N.
fn wear(place: &Place) -> f64 {
    let (force, creepage) = (place.found.report.creep_force, place.found.report.creepage);
    (force.longitudinal * creepage.longitudinal).abs() + (force.lateral * creepage.lateral).abs()
}

fn text(scene: &Scene, question: &Question, answer: &Answer) -> String {
    let number = |value: f64, digits: usize| {
        // No minus sign before zeros.
        let shown = if value.abs() < 0.5 * 0.1f64.powi(digits as i32) { 0.0 } else { value };
        if value.is_finite() { format!("{shown:.digits$}") } else { "-".into() }
    };
    let mut head = vec![String::new()];
    for wheel in &answer.wheels {
        head.extend((1..=wheel.places.len()).map(|k| format!("{} {k}", wheel.side.name())));
    }
    let places = || answer.wheels.iter().flat_map(|wheel| &wheel.places);
    let row = |(_, name, factor, digits, of): &Line| {
        let cells = places().map(|place| of(place).map_or("-".into(), |value| number(factor * value, *digits)));
        [name.to_string()].into_iter().chain(cells).collect::<Vec<_>>()
    };
    let wheels: Vec<Vec<String>> = answer
        .wheels
        .iter()
        .map(|wheel| {
            let force = wheel.force * 1e-3;
            let lengths = [number(1e3 * wheel.height, 5), number(1e6 * wheel.approach, 3)];
            let forces = [force.z, force.y, force.x].map(|value| number(value, 4));
            [wheel.side.name().to_string()].into_iter().chain(lengths).chain(forces).collect()
        })
        .collect();
    let wheel_head = ["wheel", "z of the centre [mm]", "approach [um]", "Q [kN]", "Y, left positive [kN]", "along [kN]"].map(String::from);
    let rolling = match (answer.pitch_rate, question.pitch_rate) {
        (None, _) => "creepages are given".into(),
        (Some(rate), None) => format!("rolling freely, pitch rate {rate:.5} rad/s"),
        (Some(rate), Some(_)) => format!("pitch rate {rate} rad/s"),
    };
    let contact = &scene.contact;
    let mut text = format!(
        "{}\n\n  {}\n  y {} mm, yaw {} mrad, roll {} mrad; {} m/s, {rolling}\n  contact.patch = \"{}\", contact.normal.law = \"{}\", contact.creep.law = \"{}\"\n\n{}\n{}",
        scene.title,
        super::pair_in_force(scene),
        number(1e3 * question.y, 3),
        number(1e3 * question.yaw, 3),
        number(1e3 * answer.roll, 4),
        question.speed,
        contact.patch.law.name(),
        contact.normal_name,
        contact.creep_name,
        table(&wheel_head, &wheels),
        table(&head, &LINES.iter().map(row).collect::<Vec<_>>())
    );
    if contact.patch.law.forms() {
        text += "\n  a, b, and so area and mean pressure: the ellipse of the patch's moments; N and highest pressure: of its strips\n";
    }
    text + &notes(doubts(scene, answer))
}

/// What a user should know of profiles and pose.
fn doubts(scene: &Scene, answer: &Answer) -> Vec<String> {
    let fallen = answer.wheels.iter().filter(|wheel| wheel.on_top);
    let fallen = fallen.map(|wheel| format!("the {} wheel stands on the top of its flange: it has derailed", wheel.side.name()));
    let ended = answer.wheels.iter().filter_map(|wheel| {
        let profiles = [&scene.vehicle.leading().profiles, &scene.track.rails].map(|both| &both[wheel.side.index()].profile);
        // An ellipse is that of the place's curvatures, wherever the profile ends.
        let places = if scene.contact.patch.law.forms() { &wheel.places[..] } else { &[] };
        let end = places.iter().find_map(|place| place.found.report.profile_end(profiles[0].as_ref(), profiles[1].as_ref()))?;
        Some(end.words(&format!("the {} wheel's patch", wheel.side.name())))
    });
    fallen.chain(ended).chain(profile_doubts(scene)).collect()
}

fn as_json(scene: &Scene, question: &Question, answer: &Answer) -> Value {
    let place = |place: &Place| LINES.iter().map(|(key, _, _, _, of)| ((*key).to_string(), json!(of(place)))).collect::<Map<_, _>>();
    let wheel = |wheel: &crate::study::pose::WheelInPose| {
        json!({
            "side": wheel.side.name(), "height": wheel.height, "approach": wheel.approach,
            "vertical_force": wheel.force.z, "lateral_force": wheel.force.y, "longitudinal_force": wheel.force.x,
            "places": wheel.places.iter().map(place).collect::<Vec<_>>(),
        })
    };
    json!({
        "scene": scene.name, "title": scene.title, "y": question.y, "yaw": question.yaw, "roll": answer.roll, "speed": question.speed,
        "pitch_rate": answer.pitch_rate, "patch": scene.contact.patch.law.name(), "normal_law": scene.contact.normal_name,
        "creep_law": scene.contact.creep_name, "doubts": doubts(scene, answer), "wheels": answer.wheels.each_ref().map(wheel),
    })
}
