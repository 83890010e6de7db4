//! What some random scenes have besides: motors and brakes on their axles, axles that twist, magnets on the rail, friction that changes along the track and across the head.
//!
//! By dice of their own, so that seeds of before make the same scenes otherwise.

use super::dice::Dice;
use std::fmt::Write as _;

const OTHER: u64 = 0x6578_7472_6173_2121;
const TWISTING: u64 = 0x7477_6973_7469_6e67;
/// Shares of trucks and vehicles with motors or brakes, and of scenes with friction by place.
const DRIVEN: f64 = 0.3;
/// Of scenes with axles that twist, and of those, with a brake on a single wheel; of scenes with magnets on the rail.
const TWISTED: f64 = 0.15;
const ONE_WHEEL: f64 = 0.5;
const MAGNETS: f64 = 0.05;
const ALONG: f64 = 0.12;
const ACROSS: f64 = 0.08;

/// The scene with what its seed adds; it travels `reach` [m] in the direction of `sign`.
pub(super) fn with_additions(seed: u64, text: String, vehicle: &str, sign: f64, reach: f64) -> String {
    let mut dice = Dice::new(seed ^ OTHER);
    let (driven, along, across) = (dice.chance(DRIVEN), dice.chance(ALONG), dice.chance(ACROSS));
    let mut text = text;
    let axles = axles(vehicle);
    if driven && !axles.is_empty() {
        let kind = element(&mut dice);
        let own: String = axles.iter().enumerate().map(|(k, axle)| axle.element(k + 1, &kind)).collect();
        text = text.replacen("\n[track]\n", &format!("\n{own}\n[track]\n"), 1);
    }
    let twisting = twisting(seed, vehicle, &axles);
    if !twisting.is_empty() {
        text = text.replacen("\n[track]\n", &format!("\n{twisting}\n[track]\n"), 1);
    }
    if text.contains("\nfriction = 0\n") {
        return text;
    }
    let mut places = String::new();
    if along {
        let (at, factor, length) = (sign * dice.flat(0.0, reach), dice.log(0.1, 2.0), dice.log(0.05, 5.0));
        let (first, last) = (at.min(at + sign * 10.0), at.max(at + sign * 10.0));
        let rail = dice.pick(&["left", "right", "both"]);
        let _ = write!(places, "\n[[contact.friction_along]]\nrail = \"{rail}\"\ntransition = {length}\n");
        let _ = writeln!(places, "factors = [[{first}, 1.0], [{}, {factor}], [{}, 1.0]]", first + 0.2 * (last - first), last);
    }
    if across {
        let _ = writeln!(places, "\n[contact.friction_across]\ngauge_face = {}\nfrom = \"15 deg\"\nto = \"40 deg\"", dice.log(0.1, 1.0));
    }
    text.replacen("\n[solver]\n", &format!("{places}\n[solver]\n"), 1)
}

/// Axles that twist, all alike, and magnets under frames.
fn twisting(seed: u64, vehicle: &str, axles: &[Axle]) -> String {
    let mut dice = Dice::new(seed ^ TWISTING);
    let (twisted, magnets) = (dice.chance(TWISTED), dice.chance(MAGNETS));
    let mut text = String::new();
    if twisted {
        let share = dice.flat(0.2, 0.8);
        let kind = if dice.chance(0.5) {
            format!("kind = \"independent_wheels\"\ndamping = {}\nleft_share = {share}\n", dice.pick(&["0", "10", "1000"]))
        } else {
            let stiffness = dice.log(1e3, 2e7);
            format!(
                "kind = \"flexible_axle\"\nstiffness = {stiffness}\ndamping = {}\nleft_share = {share}\n",
                stiffness * dice.log(1e-5, 1e-2)
            )
        };
        let lone = [Axle { body: "wheelset", x: 0.0, carrier: "", at: 0.0 }];
        let all = if vehicle == "suspended_wheelset" { &lone } else { axles };
        for (number, axle) in all.iter().enumerate() {
            let _ = write!(text, "[[vehicle.force]]\nname = \"twist[{}]\"\nbody = \"{}\"\n{kind}", number + 1, axle.body);
        }
        if dice.chance(ONE_WHEEL) && vehicle != "suspended_wheelset" {
            let (torque, side) = (dice.log(300.0, 1.5e4), dice.pick(&["left", "right"]));
            let brake =
                format!("kind = \"brake\"\ntype = \"disc\"\nwheel = \"{side}\"\ntorque = {torque}\nstiffness = {}\n", dice.log(2e5, 2e7));
            text.extend(axles.iter().take(1).map(|axle| axle.element(99, &brake)));
        }
    }
    if magnets && vehicle == "bogie" {
        let (attraction, friction) = (dice.log(1e3, 1e5), dice.flat(0.05, 0.5));
        let (rise, stiffness) = (dice.log(0.02, 1.0), dice.log(1e6, 1e8));
        let _ = write!(
            text,
            "[[vehicle.force]]\nname = \"magnets\"\nkind = \"magnetic_track_brake\"\non = {{ body = \"frame\", at = [0.0, 0.0, 0.05] }}\n"
        );
        let _ = write!(text, "friction = {friction}\nsliding_friction = {}\nhalf_speed = {}\n", 0.3 * friction, dice.log(1.0, 20.0));
        let _ = writeln!(text, "attraction = {attraction}\nrise_time = {rise}\nstiffness = {stiffness}");
    }
    text
}

/// An axle, what carries its motor or brake, and where both are along the vehicle, m.
struct Axle {
    body: &'static str,
    x: f64,
    carrier: &'static str,
    at: f64,
}

impl Axle {
    fn element(&self, number: usize, kind: &str) -> String {
        let Axle { body, x, carrier, at } = self;
        format!(
            "[[vehicle.force]]\nname = \"drive[{number}]\"\nfrom = {{ body = \"{carrier}\", at = [{at}, 0.0, 0.46] }}\nto = {{ body = \"{body}\", at = [{x}, 0.0, 0.46] }}\n{kind}"
        )
    }
}

fn axles(vehicle: &str) -> Vec<Axle> {
    let of = |body, x, carrier, at| Axle { body, x, carrier, at };
    match vehicle {
        "bogie" => vec![of("wheelset[1]", 1.28, "frame", 0.6), of("wheelset[2]", -1.28, "frame", -0.6)],
        "vehicle_manchester_1" => vec![
            of("truck[1].wheelset[1]", 10.78, "truck[1].frame", 10.1),
            of("truck[1].wheelset[2]", 8.22, "truck[1].frame", 8.9),
            of("truck[2].wheelset[1]", -8.22, "truck[2].frame", -8.9),
            of("truck[2].wheelset[2]", -10.78, "truck[2].frame", -10.1),
        ],
        _ => Vec::new(),
    }
}

/// Keys of one kind of drive or brake, the same on all axles.
fn element(dice: &mut Dice) -> String {
    let stiffness = dice.log(2e5, 2e7);
    match dice.pick(&["disc", "tread", "shaft", "nose"]) {
        "disc" => format!("kind = \"brake\"\ntype = \"disc\"\ntorque = {}\nstiffness = {stiffness}\n", dice.log(300.0, 1.5e4)),
        "tread" => {
            let force = dice.log(2e3, 6e4);
            format!(
                "kind = \"brake\"\ntype = \"tread\"\nfriction = {}\nblock_force = {force}\nstiffness = {stiffness}\n",
                dice.flat(0.05, 0.4)
            )
        }
        mount => {
            let (torque, ratio) = (dice.sign() * dice.log(50.0, 3e3), dice.flat(1.5, 6.0));
            let mut keys = format!("kind = \"motor_gear\"\nmount = \"{mount}\"\nratio = {ratio}\ntorque = {torque}\n");
            if dice.chance(0.6) {
                let damping = stiffness * dice.log(1e-4, 1e-2);
                let _ = write!(keys, "rotor_inertia = {}\nstiffness = {stiffness}\ndamping = {damping}\n", dice.log(0.2, 20.0));
            }
            keys
        }
    }
}
