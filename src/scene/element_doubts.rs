//! Data of force elements that were probably meant otherwise: another unit, columns of a table that have changed places, a pair in one place.

use crate::formulation::Model;
use crate::mbs::body::Body;
use crate::mbs::force::{ForceElement, Table};
use crate::settings::Number;
use crate::units::Unit;

/// Coefficients of friction between parts of a vehicle end below this.
const ROUGHEST: f64 = 1.5;
/// Speeds of dampers and displacements of springs and stops that tables go to end below these, m/s and m.
const FASTEST: f64 = 20.0;
const FARTHEST: f64 = 2.0;
/// A spring on which the lighter of its bodies would swing slower than this [1/s], one that damps it slower, or a bar on which its roll does, does nothing.
const SLOWEST: f64 = 0.2;
const WEAKEST: f64 = 2e-3;
/// Vertical part of the direction of what carries.
const STANDS: f64 = 0.7;
/// A motor does not turn so much slower than its axle.
const SLOWER: f64 = 0.5;

/// The first of them, and how many more.
pub(super) fn doubts(model: &Model) -> Option<String> {
    let elements = &model.system.forces;
    let above = links_to_wheelsets(model);
    let own = |force: &dyn ForceElement| {
        let doubt = force
            .doubt()
            .or_else(|| rough(force))
            .or_else(|| geared_down(force))
            .or_else(|| columns(force))
            .or_else(|| feeble(force, model))
            .or_else(|| upside_down(force, &model.system.bodies, &above));
        Some(format!("{}: {}", force.name(), doubt?))
    };
    let mut all = elements.iter().filter_map(|force| own(force.as_ref()).or_else(|| in_one_place(force.as_ref(), model)));
    let first = all.next()?;
    match all.count() {
        0 => Some(first),
        more => Some(format!("{first} (and {more} more elements)")),
    }
}

fn rough(force: &dyn ForceElement) -> Option<String> {
    let found = force.constants().into_iter().find(|number| number.name == "friction" && number.value > ROUGHEST)?.value;
    Some(format!("friction = {found}: surfaces of vehicles have 0.1 to 0.6; per cent are written \"{found} %\""))
}

/// Ratios that are turns of the axle for one of the rotor.
fn geared_down(force: &dyn ForceElement) -> Option<String> {
    let found = force.constants().into_iter().find(|number| number.name == "ratio" && number.value < SLOWER)?.value;
    Some(format!("ratio = {found}: turns of the rotor or shaft for one of the axle, mostly 1 to 8: was its reciprocal meant?"))
}

/// Tables that go further than anything moves.
fn columns(force: &dyn ForceElement) -> Option<String> {
    // A stop's table ends nowhere on its free side.
    let reach = |table: &Table| [table.from, table.to].into_iter().filter(|end| end.is_finite()).map(f64::abs).fold(0.0, f64::max);
    let most = |table: &Table| if table.unit == "m/s" { FASTEST } else { FARTHEST };
    let table = force.tables().into_iter().find(|table| reach(table) > most(table))?;
    let what = if table.unit == "m/s" { "speed" } else { "displacement" };
    Some(format!("{} goes to {} {}: was another unit meant? Its points are [{what}, force]", table.key, reach(&table), table.unit))
}

/// Springs, dampers and bars that the lighter of their bodies does not feel.
fn feeble(force: &dyn ForceElement, model: &Model) -> Option<String> {
    // What resists running is told by its force at speed.
    let [Some(_), Some(_)] = force.bodies() else { return None };
    let bodies = || force.reach().into_iter().flatten().filter_map(|body| model.system.bodies.get(body));
    let mass = bodies().map(|body| body.mass).fold(f64::INFINITY, f64::min);
    let inertia = bodies().map(|body| body.inertia.moments().into_iter().fold(f64::INFINITY, f64::min)).fold(f64::INFINITY, f64::min);
    let nothing = |number: &Number| {
        let (least, of) = match number.unit {
            Unit::NewtonPerMetre => (SLOWEST * SLOWEST * mass, "N/mm or kN/m"),
            Unit::NewtonMetrePerRadian => (SLOWEST * SLOWEST * inertia, "kN m/rad"),
            Unit::NewtonSecondPerMetre => (WEAKEST * mass, "kN s/m"),
            _ => return None,
        };
        (number.value > 0.0 && number.value < least && least.is_finite()).then(|| {
            format!(
                "{} = {} {} does next to nothing on what it holds: was another unit meant ({of})?",
                number.name,
                number.value,
                number.unit.name()
            )
        })
    };
    force.constants().iter().find_map(nothing)
}

/// An element that can't but press, and presses what it carries down.
fn upside_down(force: &dyn ForceElement, bodies: &[Body], above: &[usize]) -> Option<String> {
    let axis = force.presses()?;
    let [Some(from), Some(to)] = force.bodies() else { return None };
    let rises = above[to].cmp(&above[from]) as i32;
    let wrong = axis.z.abs() > STANDS && f64::from(rises) * axis.z < 0.0;
    let [from, to] = [from, to].map(|body| bodies[body].name.as_str());
    let (carried, carrier) = if rises > 0 { (to, from) } else { (from, to) };
    wrong.then(|| {
        format!(
            "it presses {carried} down on {carrier}, which carries it: \"axis\" points from \"from\" to where its spring presses \"to\""
        )
    })
}

/// How many elements and joints lie between each body and the nearest wheelset.
fn links_to_wheelsets(model: &Model) -> Vec<usize> {
    let mut links = vec![usize::MAX; model.system.bodies.len()];
    links[..model.wheelsets.len()].fill(0);
    let forces = model.system.forces.iter().map(|force| force.bodies());
    let joints = model.system.joints.iter().map(|joint| [Some(joint.bodies.first), joint.bodies.second]);
    // Wheels with a motion of their own are no bodies.
    let count = links.len();
    let among = |[from, to]: [Option<usize>; 2]| Some([from?, to?]).filter(|pair| pair.iter().all(|body| *body < count));
    let pairs: Vec<[usize; 2]> = forces.chain(joints).filter_map(among).collect();
    for reached in 0.. {
        let mut further = false;
        for [a, b] in pairs.iter().flat_map(|[a, b]| [[*a, *b], [*b, *a]]) {
            if links[a] == reached && links[b] > reached + 1 {
                links[b] = reached + 1;
                further = true;
            }
        }
        if !further {
            break;
        }
    }
    links
}

/// A mirrored pair that stands in the middle.
fn in_one_place(force: &dyn ForceElement, model: &Model) -> Option<String> {
    let pair = force.name().strip_suffix(".left")?;
    let other = model.system.forces.iter().find(|other| other.name().strip_suffix(".right") == Some(pair))?;
    let holds = force.holds();
    (holds.iter().all(Option::is_some) && holds == other.holds())
        .then(|| format!("{pair}: mirrored = true, and it stands in the middle: two of them act in one place"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{assemble, load};

    fn with(element: &str) -> Option<String> {
        let element = format!("vehicle.force=[{{name=\"s\",{element}}}]");
        let scene = load::open("bogie", &[element]).unwrap_or_else(|error| panic!("{error}"));
        doubts(&assemble::model(&scene).unwrap())
    }

    const ENDS: &str = "from={body=\"car\",at=[0,1.0,1.0]},to={body=\"frame\",at=[0,1.0,0.5]}";

    #[test]
    fn prop_units_and_columns_of_elements_are_doubted() {
        let spring = |data: &str| with(&format!("kind=\"spring_damper\",{ENDS},axis=\"z\",{data}"));
        for (data, words) in [
            ("force_over_speed=[[-5000,-0.2],[5000,0.2]]", "goes to 5000 m/s"),
            ("force_over_length=[[-20,-2000],[20,2000]]", "goes to 20 m"),
            ("stiffness=50", "stiffness = 50 N/m does next to nothing"),
            ("stiffness=1e5,damping=3", "damping = 3 N.s/m does next to nothing"),
        ] {
            let found = spring(data).unwrap_or_default();
            assert!(found.starts_with("s: ") && found.contains(words), "{data}: {found}");
        }
        for data in [
            "force_over_speed=[[-0.2,-5000],[0.2,5000]]",
            "force_over_length=[[-0.02,-2000],[0.02,2000]]",
            "stiffness=1e4,damping=300",
            "stiffness=0,damping=300",
        ] {
            assert_eq!(spring(data), None, "{data}");
        }
    }

    #[test]
    fn prop_wedges_that_press_down_what_they_carry_are_doubted() {
        let wagon = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/scenes/freight_wagon_wedges.toml");
        let with = |changes: &[&str]| {
            let changes: Vec<String> = changes.iter().map(|key| format!("vehicle.module.truck.force[wedge].{key}")).collect();
            let scene = load::open(wagon, &changes).unwrap_or_else(|error| panic!("{error}"));
            doubts(&assemble::model(&scene).unwrap())
        };
        assert_eq!([with(&[]), with(&["from=bolster", "to=side_frame", "axis=-z"])], [None, None]);
        for wrong in [&["axis=-z"][..], &["from=bolster", "to=side_frame"]] {
            let found = with(wrong).unwrap_or_default();
            assert!(found.contains("presses truck[1].bolster down on truck[1].side_frame.left"), "{wrong:?}: {found}");
        }
    }

    #[test]
    fn prop_pairs_in_the_middle_are_doubted() {
        let pair = |y: &str| {
            let ends = ENDS.replace("1.0,1.0", &format!("{y},1.0")).replace("1.0,0.5", &format!("{y},0.5"));
            with(&format!("mirrored=true,kind=\"spring_damper\",{ends},axis=\"z\",stiffness=1e5"))
        };
        assert!(pair("0").unwrap_or_default().contains("two of them act in one place"), "{:?}", pair("0"));
        assert_eq!(pair("0.9"), None);
    }
}
