//! A random scene as text, from a seed: vehicle, profiles, track, laws, formulation, integrator, inputs.
//!
//! Nothing is drawn so as to be easy: features begin and end anywhere, suspensions are soft or hard by five orders, steps and
//! tolerances go over all that docs/scene.md allows in part, starts may stand on irregular track or beside the equilibrium.

use super::super::case::{InputChange, Method};
use super::additions::with_additions;
use super::dice::Dice;
use crate::formulation::{DRIVE_TORQUE, LATERAL_FORCE, LEFT_FRICTION, LONGITUDINAL_FORCE, RIGHT_FRICTION, VERTICAL_FORCE};
use std::fmt::Write as _;

/// A scene that was drawn.
#[derive(Clone, Debug)]
pub struct RandomScene {
    pub seed: u64,
    /// TOML; says what the inputs do in comments.
    pub text: String,
    pub inputs: Vec<InputChange>,
    /// s.
    pub stop: f64,
    /// The method's name and its number, m or s.
    pub integrator: &'static str,
    pub fixed: bool,
    pub setting: f64,
    /// Instead of the drawn one.
    pub method: Option<Method>,
}

impl RandomScene {
    /// The scene of a seed.
    pub fn draw(seed: u64) -> RandomScene {
        let mut dice = Dice::new(seed);
        let mut text = format!("name = \"random_{seed}\"\n\n");
        let vehicle =
            dice.pick(&["suspended_wheelset", "suspended_wheelset", "suspended_wheelset", "bogie", "bogie", "vehicle_manchester_1"]);
        let stop = if vehicle == "vehicle_manchester_1" { dice.log(0.15, 0.5) } else { dice.log(0.2, 1.5) };
        let slow = dice.chance(0.12);
        let speed = if slow { dice.log(0.06, 3.0) } else { dice.flat(3.0, 80.0) };
        let speed = if dice.chance(0.08) { -speed } else { speed };
        let curved = speed > 0.0 && dice.chance(0.25);
        wheels(&mut dice, &mut text, vehicle, speed, curved);
        track(&mut dice, &mut text, vehicle, speed, stop, curved);
        contact(&mut dice, &mut text, slow);
        let (integrator, fixed, setting) = solver(&mut dice, &mut text);
        let _ = write!(text, "\n[run]\nstop = {stop}\nstep = 1e-3\n");
        let inputs = inputs(&mut dice, stop);
        for change in &inputs {
            let name = ["driveTorque", "lateralForce", "verticalForce", "leftFriction", "rightFriction", "longitudinalForce"];
            let _ = writeln!(text, "# input of the leading wheelset: {} = {} at {} s", name[change.input], change.value, change.time);
        }
        let text = with_additions(seed, with_patches(seed, text), vehicle, speed.signum(), speed.abs() * stop);
        RandomScene { seed, text, inputs, stop, integrator, fixed, setting, method: None }
    }

    /// The same scene run with another method.
    pub fn with(mut self, method: Option<Method>) -> RandomScene {
        if let Some(method) = method {
            (self.integrator, self.fixed) = (method.integrator, method.is_fixed());
            // A step has a unit; it is told only.
            self.setting = method.setting.split_once('=').and_then(|(_, value)| value.parse().ok()).unwrap_or(f64::NAN);
            self.method = Some(method);
        }
        self
    }
}

/// Wheel and rail that belong together, and the distance of the rails.
const PAIRS: [(&str, &str, &str, f64); 6] = [
    ("{ kind = \"s1002\", radius = 0.46 }", "{ kind = \"60e1\" }", "gauge = 1.435\ninclination = \"1:40\"", 1.5),
    ("{ kind = \"s1002\", radius = 0.42 }", "{ kind = \"60e2\" }", "gauge = 1.437\ninclination = \"1:40\"", 1.5),
    ("{ kind = \"s1002\", radius = 0.5 }", "{ kind = \"uic60\" }", "gauge = 1.432\ninclination = \"1:20\"", 1.5),
    ("{ kind = \"apta\", design = \"APTA140\", radius = 0.457 }", "{ kind = \"60e1\" }", "gauge = 1.435\ninclination = \"1:40\"", 1.5),
    (
        "{ kind = \"cone\", radius = 0.457, slope = 0.025 }",
        "{ kind = \"arc\", radius = 0.3 }",
        "rail_distance = 1.432\ninclination = \"1:40\"",
        1.432,
    ),
    ("{ kind = \"cone\", radius = 0.45, slope = 0.05 }", "{ kind = \"60e1\" }", "rail_distance = 1.5\ninclination = \"1:20\"", 1.5),
];

fn wheels(dice: &mut Dice, text: &mut String, vehicle: &str, speed: f64, curved: bool) {
    let free = dice.chance(0.2);
    let _ = write!(text, "[vehicle]\ntemplate = \"{vehicle}\"\nspeed = {speed}\ngravity = 9.81\n");
    if free {
        text.push_str("travel = \"free\"\n");
    }
    if vehicle != "suspended_wheelset" {
        if curved && !free {
            text.push_str("drive = \"leading\"\n");
        }
        if dice.chance(0.3) {
            let _ = write!(text, "\n[vehicle.initial]\ndistance = {}\n", dice.flat(0.0, 40.0));
        }
        return;
    }
    let mass = dice.log(200.0, 5e3);
    let inertia = mass * dice.flat(0.3, 0.7);
    let _ = write!(text, "\n[vehicle.wheelset]\nmass = {mass}\ninertia_xx = {inertia}\ninertia_zz = {inertia}\n");
    let _ = writeln!(text, "inertia_yy = {}\nvertical_load = {}", mass * 0.1, dice.log(1e4, 1.5e5));
    // The place of PAIRS is drawn with the track; a mark stands for it.
    text.push_str("tread_circle_distance = @DISTANCE\nprofile = @WHEEL\n");
    if dice.chance(0.85) {
        let stiff = |dice: &mut Dice| dice.log(1e4, 1e8);
        let (along, across) = (stiff(dice), stiff(dice));
        let damping = [if dice.chance(0.3) { 0.0 } else { dice.log(1e2, 3e5) }, if dice.chance(0.3) { 0.0 } else { dice.log(1e2, 1e5) }];
        let _ = write!(text, "\n[vehicle.suspension]\ndistance = {}\nlongitudinal_stiffness = {along}\n", dice.flat(0.8, 2.0));
        let _ = writeln!(text, "longitudinal_damping = {}\nlateral_stiffness = {across}\nlateral_damping = {}", damping[0], damping[1]);
    }
    if dice.chance(0.35) {
        text.push_str("\n[vehicle.initial]\n");
        for (key, most) in [("vy", 0.1), ("y", 2e-3), ("yaw", 2e-3), ("yaw_rate", 0.1), ("distance", 40.0)] {
            if dice.chance(0.35) {
                let value = if key == "distance" { dice.flat(0.0, most) } else { dice.sign() * dice.log(most / 100.0, most) };
                let _ = writeln!(text, "{key} = {value}");
            }
        }
    }
}

fn track(dice: &mut Dice, text: &mut String, vehicle: &str, speed: f64, stop: f64, curved: bool) {
    // The vehicles' own wheels are S1002.
    let (wheel, rail, place, distance) = if vehicle == "suspended_wheelset" { dice.pick(&PAIRS) } else { dice.pick(&PAIRS[..2]) };
    *text = text.replace("@DISTANCE", &distance.to_string()).replace("@WHEEL", wheel);
    let _ = write!(text, "\n[track]\n{place}\n");
    if !curved && dice.chance(0.15) {
        let _ = writeln!(text, "grade = {}", dice.sign() * dice.log(1e-3, 0.04));
    }
    let _ = writeln!(text, "rail = {rail}");
    let reach = (speed.abs() * stop).max(0.2);
    let ahead = |dice: &mut Dice| speed.signum() * dice.flat(0.0, reach) + if vehicle == "vehicle_manchester_1" { 10.8 } else { 0.0 };
    if curved {
        let radius = dice.sign() * dice.log(150.0, 3e3);
        let cant = -radius.signum() * dice.flat(0.0, 0.1);
        let node = format!("radius = {radius}\nsuperelevation = \"{cant} m\"\n");
        if dice.chance(0.3) {
            let _ = write!(text, "\n[[track.node]]\ndistance = 0\n{node}");
        } else {
            let (begin, length) = (ahead(dice), dice.flat(5.0, 40.0));
            let _ = write!(text, "\n[[track.node]]\ndistance = {begin}\n\n[[track.node]]\ndistance = {}\n{node}", begin + length);
        }
    }
    let deviations = dice.pick(&[0, 0, 1, 1, 2, 3]);
    for _ in 0..deviations {
        let shape = dice.pick(&["cosine", "haversine", "ramp"]);
        let direction = dice.pick(&["lateral", "vertical"]);
        let length = dice.log(0.4, 20.0);
        // Steeper ones are impacts that leave no wheel whole.
        let most = (0.01 * length).min(0.008);
        let begin = ahead(dice);
        let (low, high) = if speed < 0.0 { (begin - length, begin) } else { (begin, begin + length) };
        let _ = write!(text, "\n[[track.deviation]]\nrail = \"{}\"\ndirection = \"{direction}\"\n", dice.pick(&["left", "right", "both"]));
        let _ = write!(text, "shape = \"{shape}\"\namplitude = {}\nfrom = {low}\nto = {high}\n", dice.sign() * dice.log(most / 50.0, most));
    }
    if dice.chance(0.35) {
        let spectrum = dice.pick(&["fra4", "fra5", "fra6", "ore_b176_low", "ore_b176_high"]);
        let (from, length) = (dice.flat(-0.3, 0.8) * reach, dice.log(10.0, 300.0));
        let _ = write!(
            text,
            "\n[[track.irregularity]]\nkind = \"spectrum\"\nspectrum = \"{spectrum}\"\nseed = {}\n",
            dice.pick(&[1, 2, 3, 4, 5])
        );
        let _ = write!(
            text,
            "from = {from}\nto = {}\nfade = {}\nscale = {}\n",
            from + length,
            dice.flat(0.02, 0.25) * length,
            dice.log(0.1, 1.0)
        );
    }
}

/// Some elastic wheels press with patches of strips; by dice of their own, so that seeds of before make the same scenes otherwise.
fn with_patches(seed: u64, text: String) -> String {
    const OTHER: u64 = 0x7061_7463_6865_7321;
    let elastic = text.contains("formulation = \"ECF-") && !text.contains("[contact.transient]");
    match elastic && Dice::new(seed ^ OTHER).chance(STRIPS) {
        true => text
            .replacen("[contact]\n", "[contact]\npatch = \"strips\"\n", 1)
            .replace("\npoints = 1\n", "\n")
            .replace("\npoints = 3\n", "\n"),
        false => text,
    }
}

/// Share of elastic scenes with patches of strips.
const STRIPS: f64 = 0.2;

fn contact(dice: &mut Dice, text: &mut String, slow: bool) {
    let formulation = dice.pick(&["ECF-A", "ECF-A", "ECF-N", "ECCF", "ACCF"]);
    let lift = if dice.chance(0.8) { "elastic" } else { "stop" };
    let friction = if dice.chance(0.1) { 0.0 } else { dice.flat(0.02, 0.7) };
    let _ = write!(text, "\n[contact]\nformulation = \"{formulation}\"\non_lift = \"{lift}\"\nfriction = {friction}\n");
    // Mostly as many as the profiles need: a fixed number below that makes forces jump where two places are equally deep.
    match dice.pick(&[1, 0, 0, 0, 3]) {
        0 => {}
        points => text.push_str(&format!("points = {points}\n")),
    }
    text.push_str("material = { youngs_modulus = 2.1e11, poisson_ratio = 0.28 }\n");
    let curvature = if dice.chance(0.85) { "patch" } else { "point" };
    let _ = writeln!(text, "normal = {{ law = \"hertz\", curvature = \"{curvature}\", conformal = \"bounded\" }}");
    let law = dice.pick(&["shen_hedrick_elkins", "polach", "fastsim", "usetab", "shen_hedrick_elkins", "kalker_linear"]);
    let _ = match law {
        "fastsim" => writeln!(text, "creep = {{ law = \"fastsim\", strips = 10, cells = 10 }}"),
        "polach" if dice.chance(0.5) => writeln!(text, "creep = {{ law = \"polach\", surface = \"wet\" }}"),
        law => writeln!(text, "creep = {{ law = \"{law}\" }}"),
    };
    let _ = match dice.pick(&[0, 0, 1, 2, 3]) {
        0 => writeln!(text, "damping = {}", dice.log(1e8, 1e10)),
        1 => writeln!(text, "damping = {{ law = \"none\" }}"),
        2 => writeln!(text, "damping = {{ law = \"hunt_crossley\", restitution = {}, impact_speed = 0.2 }}", dice.flat(0.2, 0.95)),
        _ => writeln!(text, "damping = {{ law = \"linear\", coefficient = {}, full_at = 1e-5 }}", dice.log(1e4, 3e5)),
    };
    if slow || dice.chance(0.1) {
        let _ = write!(text, "\n[contact.transient]\nbelow = {}\n", dice.flat(0.5, 4.0));
    }
}

fn solver(dice: &mut Dice, text: &mut String) -> (&'static str, bool, f64) {
    let integrator = dice.pick(&[
        "rosenbrock",
        "rosenbrock",
        "auto",
        "imex",
        "imex",
        "dormand_prince",
        "dormand_prince",
        "rk43",
        "generalised_alpha",
        "real_time",
        "rk4",
        "zhai",
    ]);
    let (fixed, setting) = match integrator {
        "rosenbrock" | "imex" => (false, dice.log(1e-8, 3e-4)),
        "auto" | "dormand_prince" | "rk43" => (false, dice.log(1e-9, 1e-5)),
        "generalised_alpha" | "real_time" => (true, dice.log(1e-4, 4e-3)),
        "rk4" => (true, dice.log(3e-5, 7e-4)),
        _ => (true, dice.log(1e-5, 5e-4)),
    };
    let key = if fixed { "step" } else { "tolerance" };
    let _ = write!(text, "\n[solver]\nintegrator = \"{integrator}\"\n{key} = {setting:e}\n");
    (integrator, fixed, setting)
}

/// What a master does, once in four scenes.
fn inputs(dice: &mut Dice, stop: f64) -> Vec<InputChange> {
    if !dice.chance(0.25) {
        return Vec::new();
    }
    let mut all = Vec::new();
    for _ in 0..dice.pick(&[1, 2, 3]) {
        let time = dice.flat(0.0, stop);
        let (input, value) = match dice.pick(&[0, 1, 2, 3, 4, 5]) {
            0 => (DRIVE_TORQUE, dice.sign() * dice.log(100.0, 2e4)),
            1 => (LATERAL_FORCE, dice.sign() * dice.log(100.0, 2e4)),
            2 => (VERTICAL_FORCE, dice.sign() * dice.log(100.0, 1e4)),
            3 => (LEFT_FRICTION, dice.flat(0.0, 2.0)),
            4 => (RIGHT_FRICTION, dice.flat(0.0, 2.0)),
            _ => (LONGITUDINAL_FORCE, dice.sign() * dice.log(100.0, 1e4)),
        };
        all.push(InputChange { time, input, value });
    }
    all.sort_by(|a, b| a.time.total_cmp(&b.time));
    all
}
