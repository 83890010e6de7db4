use super::*;
use crate::scene::load;
use crate::scene::spec::Scene;
use crate::settings::Source;
use expand::natural;
use nalgebra::vector;
use std::cmp::Ordering;

/// The embedded bogie with other tables in place of its vehicle.
fn read(vehicle: &str) -> Result<Scene, String> {
    let scene = crate::scene::embedded::find("bogie").unwrap().text;
    let start = scene.find("[vehicle]").unwrap();
    let (end, run) = (scene.find("[track]").unwrap(), scene.find("[interface]").unwrap());
    let text = format!("{}{vehicle}\n{}{}", &scene[..start], &scene[end..run], &scene[scene.find("[run]").unwrap()..]);
    load::read("s", Source { file: "s.toml".into(), text, overridden: vec![], folder: None }, &[]).map_err(|error| error.to_string())
}

const HEAD: &str =
    "[vehicle]\ntemplate = \"free\"\nspeed = 20.0\ngravity = 9.81\n[vehicle.wheel_profile]\nkind = \"s1002\"\nradius = 0.46\n";
const WHEELSET: &str =
    "mass = 1800\ninertia_xx = 1100\ninertia_yy = 110\ninertia_zz = 1100\ntread_circle_distance = 1.5\nx = 1.0\ndriven = true\n";
const BRICK: &str = "mass = 10\ninertia_xx = 1\ninertia_yy = 2\ninertia_zz = 3\n";

#[test]
fn analytic_modules_within_modules_are_placed_and_mirrored() {
    let text = format!(
        "{HEAD}[[vehicle.place]]\nname = \"car[1]\"\nmodule = \"car\"\nposition = [100, 0, 0]\n\
         [[vehicle.module.car.place]]\nname = \"truck[2]\"\nmodule = \"truck\"\nposition = [-9, 0.5, 0.1]\n\
         [[vehicle.module.car.body]]\nname = \"shell\"\nposition = [0, 0, 2]\n{BRICK}\
         [[vehicle.module.truck.wheelset]]\nname = \"wheelset\"\n{WHEELSET}\
         [[vehicle.module.truck.body]]\nname = \"box\"\nmirrored = true\nposition = [1, 2, 3]\n{BRICK}\
         [[vehicle.module.truck.force]]\nname = \"spring\"\nmirrored = true\nkind = \"bushing\"\nfrom = \"shell\"\nto = \"box\"\nat = [1, 2, 3]\nstiffness = [1, 1, 1]\n\
         [[vehicle.module.truck.joint]]\nname = \"hinge\"\nmirrored = true\nkind = \"revolute\"\nfirst = \"shell\"\nsecond = \"box\"\nat = [1, 2, 3]\naxis = [0, 1, 0]\n"
    );
    let free = read(&text).unwrap().vehicle;
    let bodies: Vec<(&str, Vector3<f64>)> = free.bodies.iter().map(|b| (b.body.name.as_str(), b.position)).collect();
    assert_eq!(
        bodies,
        [
            ("car[1].shell", vector![100.0, 0.0, 2.0]),
            ("car[1].truck[2].box.left", vector![92.0, 2.5, 3.1]),
            ("car[1].truck[2].box.right", vector![92.0, -1.5, 3.1]),
        ]
    );
    assert_eq!((free.wheelsets[0].spec.name.as_str(), free.wheelsets[0].x), ("car[1].truck[2].wheelset", 92.0));
    let names: Vec<&str> = free.forces.iter().map(|force| force.0.name()).collect();
    assert_eq!(names, ["car[1].truck[2].spring.left", "car[1].truck[2].spring.right"]);
    let joined: Vec<(usize, Option<usize>)> = free.joints.iter().map(|joint| (joint.bodies.first, joint.bodies.second)).collect();
    assert_eq!(joined, [(1, Some(2)), (1, Some(3))], "each box its own side");
}

#[test]
fn prop_numbers_in_names_count_by_value() {
    for (a, b) in [("axle[2]", "axle[10]"), ("axle[2].x", "axle[2].y"), ("a", "a.b"), ("truck[1].z", "truck[2].a")] {
        assert_eq!((natural(a, b), natural(b, a), natural(a, a)), (Ordering::Less, Ordering::Greater, Ordering::Equal), "{a} {b}");
    }
}

#[test]
fn prop_a_scene_changes_single_keys_of_a_template() {
    let head = "[vehicle]\ntemplate = \"vehicle_manchester_1\"\nspeed = 20.0\ngravity = 9.81\n";
    let changed = format!(
        "{head}[[vehicle.body]]\nname = \"car\"\nmass = 40000.0\n[[vehicle.module.truck.wheelset]]\nname = \"wheelset[2]\"\nmass = 1900.0\n"
    );
    let (plain, changed) = (read(head).unwrap().vehicle, read(&changed).unwrap().vehicle);
    assert_eq!(changed.bodies[0].body, Body { mass: 40000.0, ..plain.bodies[0].body.clone() });
    let masses: Vec<f64> = changed.wheelsets.iter().map(|w| w.spec.mass).collect();
    assert_eq!(masses, [1813.0, 1900.0, 1813.0, 1900.0], "in each truck");
    assert_eq!(changed.forces.len(), plain.forces.len());
    // A profile for each side goes before the template's one for both; beside the scene's own it serves nothing.
    let side = |side: &str, radius: f64| format!("{side}_wheel_profile = {{ kind = \"s1002\", radius = {radius} }}\n");
    let both = format!("{head}{}{}", side("left", 0.46), side("right", 0.459));
    let radii = read(&both).unwrap().vehicle.wheelsets[3].spec.profiles.each_ref().map(|choice| choice.profile.at(0.0).value);
    assert_eq!(radii, [0.46, 0.459]);
    let error = read(&format!("{both}wheel_profile = {{ kind = \"s1002\", radius = 0.46 }}\n")).err().unwrap_or_default();
    assert!(error.contains("this one serves nothing"), "{error}");
}

#[test]
fn hard_messages_say_what_is_wrong_with_a_vehicle() {
    let wheelset = format!("[[vehicle.wheelset]]\nname = \"w\"\n{WHEELSET}");
    let module = "[[vehicle.module.m.place]]\nname = \"again\"\nmodule = \"m\"\nposition = [0, 0, 0]\n";
    let joint = "[[vehicle.joint]]\nname = \"j\"\nkind = \"universal\"\nfirst = \"w\"\nsecond = \"b\"\nat = [0, 0, 0]\naxis = [1, 0, 0]\nsecond_axis = [1, 1, 0]\n";
    let body = format!("[[vehicle.body]]\nname = \"b\"\nposition = [0, 0, 1]\n{BRICK}");
    let force = "[[vehicle.force]]\nname = \"f\"\nkind = \"bushing\"\nfrom = \"w\"\nto = \"b\"\nstiffness = [1, 1, 1]\n";
    let template = "[vehicle]\ntemplate = \"vehicle_manchester_1\"\nspeed = 20.0\ngravity = 9.81\n";
    let cases = [
        (HEAD.to_string(), "vehicle.wheelset: is missing; expected at least one"),
        (format!("{HEAD}{}", wheelset.replace("driven = true", "")), "vehicle.travel: the imposed speed acts on no wheelset"),
        (format!("{HEAD}{wheelset}{module}"), "vehicle.module.m: is placed nowhere"),
        (
            format!("{HEAD}{wheelset}[[vehicle.place]]\nname = \"one\"\nmodule = \"m\"\nposition = [0, 0, 0]\n{module}"),
            "does \"m\" place itself?",
        ),
        (format!("{HEAD}{}", wheelset.replace("\"w\"", "\"1 w\"")), "vehicle.wheelset[1].name: found \"1 w\", expected letters"),
        (format!("{HEAD}{wheelset}{body}{joint}"), "vehicle.joint[1].second_axis: is not across axis"),
        (format!("{HEAD}{wheelset}{body}{body}"), "vehicle.body[2].name: \"b\" names something else already"),
        // What a template leaves out for the scene's entries to change is changed once.
        (
            format!(
                "{template}[[vehicle.body]]\nname = \"car\"\nmass = 4e4\n[[vehicle.body]]\nname = \"car\"\nposition = [0, 0, 1]\n{BRICK}"
            ),
            "\"car\" names something else already",
        ),
        (
            format!("{template}[[vehicle.body]]\nname = \"carr\"\nmass = 4e4\n"),
            "no entry of the template is called \"carr\" (did you mean \"car\"?)",
        ),
        (format!("{HEAD}{wheelset}{body}{force}"), "vehicle.force[1].from: has no place; expected { body"),
    ];
    for (text, words) in cases {
        let error = read(&text).err().unwrap_or_default();
        println!("{error}");
        assert!(error.contains(words), "{error}");
    }
}
