//! Values that are allowed but that no railway vehicle has, mostly another unit than was meant, or that make a run mean little.

use super::assemble::points_needed;
use super::beam_cautions::beam_cautions;
use super::held_apart::held_apart;
use super::oversights::oversights;
use super::profile_notes::{RADII, profile_doubts, radius};
use super::rough_track::{on_rigid_rails, tilted};
use super::spec::Scene;
use super::start::lone_on_a_transition;
use super::vehicle::PlacedBody;
use crate::contact::patch::PatchLaw;
use crate::formulation::Model;
use crate::mbs::inertia::Inertia;
use crate::solve::SettingKind;

/// Coefficients of friction of steel on steel end below this, sanded rails among them.
const FRICTION: f64 = 1.0;
/// The largest principal moment of inertia is at most the sum of the two others; by this part more is rounding of data.
const ROUNDING: f64 = 0.02;

/// All of them.
pub fn improbable(scene: &Scene, model: &Model) -> Vec<String> {
    friction(scene)
        .into_iter()
        .chain(modulus(scene))
        .chain(gravity(scene))
        .chain(high(scene))
        .chain(moments(scene))
        .chain(swapped(scene))
        .chain(distances(scene))
        .chain(few_places(scene, model))
        .chain(undamped(scene))
        .chain(on_rigid_rails(scene, model))
        .chain(tilted(scene, model))
        .chain(oversights(scene, model))
        .chain(beam_cautions(scene, model))
        .chain(held_apart(scene))
        .chain(lone_on_a_transition(scene))
        .chain(profile_doubts(scene))
        .collect()
}

fn friction(scene: &Scene) -> Option<String> {
    let found = scene.contact.friction;
    (found > FRICTION).then(|| format!("contact.friction = {found}: steel on steel has 0.05 to 0.6; per cent are written \"{found} %\""))
}

/// Young's moduli of wheels and rails, Pa.
const MODULI: [f64; 2] = [5e10, 5e11];

fn modulus(scene: &Scene) -> Option<String> {
    let found = scene.contact.material.youngs_modulus;
    (!(MODULI[0]..=MODULI[1]).contains(&found)).then(|| {
        format!("contact.material.youngs_modulus = {found} Pa: steel has 2.1e11 (\"210 GPa\", \"30e6 psi\"): was another unit meant?")
    })
}

/// On the earth's surface, m/s2; 0 leaves weights out on purpose.
const GRAVITY: [f64; 2] = [9.7, 9.9];

fn gravity(scene: &Scene) -> Option<String> {
    let found = scene.vehicle.gravity;
    (found != 0.0 && !(GRAVITY[0]..=GRAVITY[1]).contains(&found))
        .then(|| format!("vehicle.gravity = {found} m/s2: on earth it is 9.78 to 9.83: was another unit meant?"))
}

/// Centres of mass are not higher above the rails, m: double-deck cars have 2 m.
const HIGHEST: f64 = 4.0;

fn high(scene: &Scene) -> Option<String> {
    let high = |placed: &&PlacedBody| placed.position.z > HIGHEST;
    let placed = scene.vehicle.bodies.iter().find(high)?;
    Some(format!(
        "{}: its centre of mass is {:.1} m above the rails; those of vehicles' bodies are below {HIGHEST} m: was another unit or place meant?",
        placed.body.name, placed.position.z
    ))
}

/// `J1 <= J2 + J3` of any distribution of mass.
fn moments(scene: &Scene) -> Vec<String> {
    let of = |(name, inertia): (&str, &Inertia)| {
        let all = inertia.moments();
        let (largest, sum) = (all.into_iter().fold(0.0, f64::max), all.iter().sum::<f64>());
        let others = sum - largest;
        (largest > (1.0 + ROUNDING) * others).then(|| {
            format!(
                "{name}: a moment of inertia of {largest} kg m2 is more than the sum of the two others, {others} kg m2: no body has that"
            )
        })
    };
    let bodies = scene.vehicle.bodies.iter().map(|placed| (placed.body.name.as_str(), &placed.body.inertia));
    bodies.filter_map(of).collect()
}

/// Bodies that weigh at least so much of the heaviest and stand over wheelsets so far apart, m, are longer than wide.
const CAR: f64 = 0.5;
const BASE: f64 = 5.0;
/// By so much their moment about the long axis may be the larger one.
const SWAPPED: f64 = 1.5;

/// Car bodies whose moments about x and y have changed places.
fn swapped(scene: &Scene) -> Option<String> {
    let vehicle = &scene.vehicle;
    let heaviest = vehicle.bodies.iter().map(|placed| placed.body.mass).fold(0.0, f64::max);
    let places = || vehicle.wheelsets.iter().map(|wheelset| wheelset.x);
    if places().fold(f64::NEG_INFINITY, f64::max) - places().fold(f64::INFINITY, f64::min) < BASE {
        return None;
    }
    let body = vehicle.bodies.iter().map(|placed| &placed.body).filter(|body| body.mass > CAR * heaviest).find(|body| {
        let [about_x, about_y, about_z] = body.inertia.moments();
        about_x > SWAPPED * about_y && about_x <= (1.0 + ROUNDING) * (about_y + about_z)
    })?;
    let [about_x, about_y, _] = body.inertia.moments();
    Some(format!(
        "{}: inertia_xx = {about_x} kg m2 is more than inertia_yy = {about_y} kg m2; a body that is longer than wide has less about x, its long axis: have they changed places?",
        body.name
    ))
}

/// Wheelsets that stand in each other.
fn distances(scene: &Scene) -> Option<String> {
    let all = &scene.vehicle.wheelsets;
    let radius = all.iter().flat_map(|wheelset| wheelset.spec.profiles.iter().map(radius)).fold(0.0, f64::max).min(RADII[1]);
    let mut order: Vec<usize> = (0..all.len()).collect();
    order.sort_by(|a, b| all[*a].x.total_cmp(&all[*b].x));
    let near = order.windows(2).find(|pair| all[pair[1]].x - all[pair[0]].x < radius)?;
    let [a, b] = [near[0], near[1]].map(|index| &all[index].spec.name);
    Some(format!("{a} and {b} are {} m apart: their wheels stand in each other", all[near[1]].x - all[near[0]].x))
}

/// Elastic ellipses at fewer places than the profiles touch at: where two share a load the one place jumps between them at each evaluation (APTA140 in its flange at
/// 37 m/s and R 231 m without friction: 45 000 steps rejected in 0.45 s, loads at single times 17 % below their mean).
fn few_places(scene: &Scene, model: &Model) -> Option<String> {
    let given = scene.contact.points.filter(|_| scene.contact.patch.law == PatchLaw::Ellipse && model.formulation.on_lift().is_none())?;
    let needed = points_needed(scene);
    (given < needed).then(|| {
        format!(
            "contact.points = {given}, but these profiles touch at up to {needed} places: where places share a load, it jumps between them there; loads at single times \
             then mean little, and steps are short"
        )
    })
}

/// Elastic contacts that nothing damps, with a method that damps: a wheelset on one bump of 0.3 mm rings with 7.2 kN for ever, with `rosenbrock` at default tolerances with 2.4 kN after
/// 4.5 s, 12 % of the static wheel load (the load tolerance alone acts on it: 1e-3 is off by 1.7 %).
fn undamped(scene: &Scene) -> Option<String> {
    let integrator = &scene.solver.integrator;
    let damps = integrator.linearises() && integrator.setting().kind == SettingKind::Tolerance;
    (scene.contact.rings() && damps).then(|| {
        "contact.damping takes nothing: a wheel that rings on its contact (100 to 300 Hz) would do so for ever, but implicit steps take its swing away, two thirds in some seconds; \
         solver.load_tolerance = 1e-3 or solver.integrator = \"dormand_prince\" (as with \"auto\") keep it"
            .into()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{assemble, load};

    const LOCOMOTIVE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/scenes/locomotive_with_motors.toml");
    const TRAM: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/scenes/tram_independent_wheels.toml");

    fn of(scene: &str, change: &str) -> Vec<String> {
        let changes: Vec<String> = if change.is_empty() { Vec::new() } else { vec![change.into()] };
        let scene = load::open(scene, &changes).unwrap_or_else(|error| panic!("{error}"));
        improbable(&scene, &assemble::model(&scene).unwrap())
    }

    /// What no slip of a unit explains away is refused, with its key.
    #[test]
    fn prop_gauges_in_millimetres_are_refused() {
        for key in ["track.gauge=1435", "vehicle.wheelset.tread_circle_distance=1500"] {
            let error = load::open("wheelset_s1002", &[key.into()]).err().map(|error| error.to_string()).unwrap_or_default();
            let (name, _) = key.split_once('=').unwrap();
            assert!(error.contains(name) && error.contains("a distance in millimetres"), "{error}");
        }
    }

    #[test]
    fn prop_attachments_in_millimetres_are_refused() {
        let element = |at: &str| {
            format!(
                "vehicle.force=[{{kind=\"spring_damper\",name=\"s\",from={{body=\"car\",at=[0,{at},1.0]}},to={{body=\"frame\",at=[0,{at},0.5]}},stiffness=1e6}}]"
            )
        };
        let opened = |at: &str| load::open("bogie", &[element(at)]).err().map(|error| error.to_string()).unwrap_or_default();
        assert!(opened("900").contains("900 m from the centre of") && opened("900").contains("\"900 mm\""), "{}", opened("900"));
        assert!(!opened("0.9").contains("from the centre"), "{}", opened("0.9"));
        let sensor = "vehicle.sensor=[{name=\"floor\",body=\"car\",at=[9500,0,1200]}]".to_string();
        let refused = load::open("bogie", &[sensor]).err().map(|error| error.to_string()).unwrap_or_default();
        assert!(refused.contains("stands 9575 m from the centre of car"), "{refused}");
    }

    /// A car on springs under its middle stands upright in a run on straight track, and falls in any other. Rate by hand, on trucks that do not give way:
    /// `sqrt((m g h - k y^2) / (J + m h^2))`, h from the springs' plane to the car's centre.
    #[test]
    fn analytic_a_car_that_does_not_stand_by_itself_is_named() {
        let open = |changes: &[&str]| {
            let changes: Vec<String> = changes.iter().map(|change| (*change).to_string()).collect();
            let scene = load::open(TRAM, &changes).unwrap_or_else(|error| panic!("{error}"));
            improbable(&scene, &assemble::model(&scene).unwrap())
        };
        let bar = "vehicle.module.truck.force[anti_roll_bar].stiffness=100";
        let narrow = "vehicle.module.truck.force[secondary].at=[0,0.05,0.6]";
        assert_eq!([open(&[bar]), open(&[narrow])], [Vec::<String>::new(), vec![]]);
        let found = open(&[bar, narrow]);
        assert!(found.len() == 1 && found[0].contains("car does not stand by itself") && found[0].contains("in roll"), "{found:?}");
        let by_hand = ((12e3 * 9.81 * 0.9 - 4.0 * 3e5 * 0.05 * 0.05) / (14e3 + 12e3 * 0.81_f64)).sqrt();
        let rate: f64 = found[0].split(" 1/s").next().and_then(|words| words.rsplit(' ').next()?.parse().ok()).unwrap();
        println!("{rate} 1/s, by hand {by_hand:.2} 1/s");
        assert!(rate > by_hand && rate < 1.5 * by_hand, "{rate} {by_hand}");
    }

    /// A line has a sense: what presses must lie on its side, and can be reached.
    #[test]
    fn prop_stops_that_act_inside_out_are_refused_or_named() {
        let with = |kind: &str, to: &str, more: &str| {
            let ends = format!("from={{body=\"car\",at=[0,0,0.8]}},to={{body=\"frame\",at=[{to}]}}");
            let element = format!("vehicle.force=[{{kind=\"{kind}\",name=\"stop\",{ends},{more}}}]");
            load::open("bogie", &[element])
                .map(|scene| improbable(&scene, &assemble::model(&scene).unwrap()))
                .map_err(|error| error.to_string())
        };
        let coupler = "draw_stiffness=5e6,buffer_stiffness=8e6,slack=\"40 mm\"";
        assert!(with("coupler", "-1.0,0,0.8", &format!("{coupler},axis=\"x\"")).unwrap_err().contains("points from \"to\" to \"from\""));
        assert!(with("coupler", "-0.015,0,0.8", coupler).unwrap_err().contains("they would meet before it presses"));
        for good in [format!("{coupler},axis=\"-x\""), coupler.into()] {
            assert_eq!(with("coupler", "-1.0,0,0.8", &good), Ok(vec![]), "{good}");
        }
        let buffer = "stiffness=4e6,sides=\"compression\"";
        let refused = with("bump_stop", "0,0,0.8", buffer).unwrap_err();
        // The frame's centre is below the car's.
        assert!(refused.contains("axis = \"-z\""), "{refused}");
        let named = with("bump_stop", "0,0,0.8", &format!("{buffer},axis=\"z\"")).unwrap();
        assert!(named.len() == 1 && named[0].contains("acts where the two part"), "{named:?}");
        assert_eq!(with("bump_stop", "0,0,0.8", &format!("{buffer},axis=\"-z\"")), Ok(vec![]));
        assert!(with("bump_stop", "-0.06,0,0.8", &format!("{buffer},clearance=\"80 mm\"")).unwrap_err().contains("0.08 m of free travel"));
        let far = with("bump_stop", "0,0.2,0.8", "stiffness=4e6,axis=\"y\",clearance=25").unwrap();
        assert!(far[0].contains("\"25 mm\""), "{far:?}");
        // Half a millimetre is no line.
        assert!(with("spring_damper", "0,0,0.8005", "stiffness=1e6").unwrap_err().contains("both places coincide"));
    }

    #[test]
    fn prop_slips_of_units_are_named_and_embedded_scenes_are_not() {
        for (scene, change, words) in [
            ("wheelset_s1002", "vehicle.wheelset.profile.radius=2", "radius of 2 m"),
            ("wheelset_s1002", "contact.friction=35", "\"35 %\""),
            ("wheelset_s1002", "contact.material.youngs_modulus=2.1e10", "\"210 GPa\""),
            ("wheelset_s1002", "vehicle.wheelset.inertia_yy=1000", "all of its mass at the tread"),
            (LOCOMOTIVE, "vehicle.module.truck.force[motor[1]].ratio=0.2", "was its reciprocal meant"),
            (LOCOMOTIVE, "vehicle.module.truck.force[motor[1]].to.at=[-1.28,0,0.46]", "names an axle and a place 2.56 m away"),
            (LOCOMOTIVE, "vehicle.module.truck.force[motor[1]].from.at=[9.5,0,0.5]", "motor[1]: holds on to truck[1].frame 9.50 m"),
            ("vehicle_manchester_1", "vehicle.body[car].inertia_xx=6e6", "no body has that"),
            (
                "vehicle_manchester_1",
                "track.deviation=[{rail=\"left\",direction=\"vertical\",shape=\"ramp\",amplitude=\"60 mm\",from=20,to=60}]",
                "40 mrad are left out of their inclination",
            ),
            ("vehicle_manchester_1", "vehicle.body[car].mass=32", "radius of gyration of"),
            ("wheelset_s1002", "track.inclination=-0.025", "lean outward"),
            ("wheelset_s1002", "vehicle.wheelset.tread_circle_distance=1.435", "outside of each gauge line"),
            (TRAM, "vehicle.module.truck.force[secondary].stiffness=[80,120,300]", "m of spring"),
            ("vehicle_manchester_1", "track.node=[{distance=20},{distance=80,radius=\"1000 m\",superelevation=\"60 mm\"}]", "inner rail"),
            (
                "vehicle_manchester_1",
                "track.deviation=[{rail=\"left\",direction=\"vertical\",shape=\"cosine\",amplitude=\"3 mm\",from=9000,to=9010}]",
                "acts nowhere",
            ),
            (
                "vehicle_manchester_1",
                "vehicle.module.truck.force=[{name=\"arm\",kind=\"spring_damper\",from={body=\"frame\",at=[0.9,1.0,0.9]},to={body=\"wheelset[1]\",at=[0.9,1.0,0.46]},stiffness=1e5}]",
                "off the axle's line",
            ),
        ] {
            let found = of(scene, change);
            assert!(found.len() == 1 && found[0].contains(words), "{change}: {found:?}");
        }
        let exchanged = ["vehicle.body[car].inertia_xx=1.97e6", "vehicle.body[car].inertia_yy=56800"].map(String::from);
        let scene = load::open("vehicle_manchester_1", &exchanged).unwrap_or_else(|error| panic!("{error}"));
        let found = improbable(&scene, &assemble::model(&scene).unwrap());
        assert!(found.len() == 1 && found[0].contains("have they changed places"), "{found:?}");
        // "auto" takes an explicit method there.
        let ringing = |integrator: &str| {
            let changes = ["contact.damping={law=\"none\"}".into(), format!("solver={{integrator=\"{integrator}\", tolerance=1e-5}}")];
            let scene = load::open("vehicle_manchester_1", &changes).unwrap_or_else(|error| panic!("{error}"));
            improbable(&scene, &assemble::model(&scene).unwrap())
        };
        assert!(ringing("rosenbrock")[0].contains("implicit steps take its swing away") && ringing("auto").is_empty());
        let with = |points: &str| {
            let changes = ["contact.patch=ellipse".to_string(), format!("contact.points={points}")];
            let scene = load::open("wheelset_s1002", &changes).unwrap_or_else(|error| panic!("{error}"));
            improbable(&scene, &assemble::model(&scene).unwrap())
        };
        assert!(with("1")[0].contains("touch at up to") && with("4").is_empty(), "{:?}", with("1"));
        for scene in crate::scene::embedded::SCENES.iter().map(|scene| scene.name) {
            assert_eq!(of(scene, ""), Vec::<String>::new(), "{scene}");
        }
    }

    #[test]
    fn hard_starts_on_transitions_and_two_imposed_speeds_in_curves_are_told() {
        let of = |scene: &str, changes: &[&str]| {
            let changes: Vec<String> = changes.iter().map(|change| change.to_string()).collect();
            let scene = load::open(scene, &changes).unwrap_or_else(|error| panic!("{scene}: {error}"));
            improbable(&scene, &assemble::model(&scene).unwrap())
        };
        let spiral = "track.node=[{distance=-50}, {distance=50, radius=-250, superelevation=\"120 mm\"}]";
        let told = |found: &[String], words: &str| found.iter().any(|note| note.contains(words));
        let on = |place: &str| told(&of("suspended_wheelset", &[spiral, place]), "starts on a transition");
        assert!(on("vehicle.initial.distance=0") && !on("vehicle.initial.distance=-60") && !on("vehicle.initial.distance=60"));
        let curve = |radius: u32| format!("track.node=[{{distance=-500, radius={radius}}}]");
        let pushed = |radius: u32, change: &str| told(&of("vehicle_manchester_1", &[&curve(radius), change]), "pushes against the other's");
        let usual = "vehicle.speed=10";
        assert!(pushed(150, "vehicle.drive=all") && !pushed(2000, "vehicle.drive=all") && !pushed(150, usual));
    }
}
