//! Outputs against what they say they are: places of sensors in curves, slip of unlike wheels, brakes that take hold and let go.

use wheelrail::scene::load;
use wheelrail::scene::spec::Scene;
use wheelrail::settings::Source;
use wheelrail::sim::Simulation;
use wheelrail::sim::vehicle_outputs::scene_outputs;

fn read(text: &str, changes: &[&str]) -> Scene {
    let source = Source { file: "outputs.toml".into(), text: text.into(), overridden: vec![], folder: None };
    let changes: Vec<String> = changes.iter().map(|change| (*change).to_string()).collect();
    load::read("outputs", source, &changes).unwrap_or_else(|error| panic!("{error}"))
}

fn values<const N: usize>(simulation: &mut Simulation, scene: &Scene, names: [&str; N]) -> [f64; N] {
    let outputs = scene_outputs(scene, simulation.model());
    let snapshot = simulation.snapshot().unwrap();
    names.map(|name| outputs.iter().find(|output| output.name == name).unwrap_or_else(|| panic!("no {name}")).value(snapshot))
}

/// A point dx ahead of a car's centre, as far from the centre of a left curve of radius R as `hypot(R - y, dx)`: it stands `dx^2 / 2R` further out than the section of
/// the car's centre says (overthrow), and further along by the angle.
#[test]
fn analytic_sensors_overthrow_in_curves() {
    const RADIUS: f64 = 300.0;
    let node = format!("track.node=[{{distance=-200,radius={RADIUS}}}]");
    let changes = ["track.deviation=[]".to_string(), node, "vehicle.speed=15".into()];
    let scene = load::open("vehicle_manchester_1", &changes).unwrap_or_else(|error| panic!("{error}"));
    let mut simulation = Simulation::new(&scene, 0.0).unwrap();
    simulation.advance(0.5).unwrap();
    for (sensor, ahead) in [("floor[1]", 9.5), ("floor[2]", -9.5)] {
        let names = ["car.distance", "car.y", "car.yaw", "car.roll", &format!("{sensor}.distance"), &format!("{sensor}.y")];
        let [distance, y, yaw, roll, along, across] = values(&mut simulation, &scene, names);
        // 0.6 m below the car's centre of mass.
        let beside = RADIUS - y - ahead * yaw - 0.6 * roll;
        let (right, angle) = (RADIUS - beside.hypot(ahead), (ahead / beside).atan());
        println!("{sensor}: y {across:.5} m, by hand {right:.5} m; {:.5} m ahead, by hand {:.5} m", along - distance, RADIUS * angle);
        assert!((across - right).abs() < 2e-3 && (right - y).abs() > 0.1, "{across} {right}");
        assert!((along - distance - RADIUS * angle).abs() < 5e-3, "{along} {distance} {angle}");
    }
}

/// A wheelset on cones of unlike radii, the left one first.
fn unlike(radii: [f64; 2]) -> String {
    let [left, right] = radii;
    format!(
        "name=\"unlike\"\n[vehicle]\ntemplate=\"suspended_wheelset\"\nspeed=25.0\n[vehicle.wheelset]\nmass=1568.0\ninertia_xx=656.0\ninertia_yy=168.0\ninertia_zz=656.0\n\
         vertical_load=98000.0\ntread_circle_distance=\"1500 mm\"\nleft_profile={{kind=\"cone\",radius={left},slope=0.05}}\nright_profile={{kind=\"cone\",radius={right},slope=0.05}}\n\
         [vehicle.suspension]\ndistance=\"2.0 m\"\nlongitudinal_stiffness=1.35e6\nlongitudinal_damping=1.0e4\nlateral_stiffness=2.5e5\nlateral_damping=3e3\n\
         [track]\nrail_distance=\"1500 mm\"\ninclination=\"1:20\"\nrail={{kind=\"arc\",radius=0.3}}\n[contact]\nformulation=\"ECF-A\"\nfriction=0.35\n\
         material={{youngs_modulus=\"207 GPa\",poisson_ratio=0.28}}\nnormal={{law=\"hertz\"}}\ncreep={{law=\"polach\"}}\n[interface]\noutputs=[\"motion\",\"adhesion\"]\n[run]\nstop=1.0\nstep=\"1 ms\"\n"
    )
}

/// Turned about, a wheelset has the same slip; it was counted with the left wheel's radius.
#[test]
fn analytic_slip_of_unlike_wheels_is_that_of_both() {
    let slip = |radii: [f64; 2]| {
        let scene = read(&unlike(radii), &[]);
        let mut simulation = Simulation::new(&scene, 0.0).unwrap();
        simulation.advance(1.0).unwrap();
        values(&mut simulation, &scene, ["wheelset.slipSpeed", "wheelset.y", "wheelset.pitchRate"])
    };
    let (one, other) = (slip([0.457, 0.455]), slip([0.455, 0.457]));
    println!("{one:?} {other:?}");
    assert!((one[1] + other[1]).abs() < 1e-8 && (one[0] - other[0]).abs() < 1e-6, "{one:?} {other:?}");
    // Its spin in space has what yaw rate and roll add to the pitch rate.
    assert!((one[0] - (0.456 * one[2] - 25.0)).abs() < 1e-6, "{one:?}");
    // It begins either way round; the height of its start was that of the left wheel, the right one 7 mm in its rail.
    let (one, other) = (slip([0.457, 0.450]), slip([0.450, 0.457]));
    assert!((one[1] + other[1]).abs() < 1e-8 && one[1].abs() > 1e-3, "{one:?} {other:?}");
}

const BRAKE: &str = "name=\"brake\"\n[vehicle]\ntemplate=\"bogie\"\nspeed=20.0\ntravel=\"free\"\n[[vehicle.force]]\nname=\"brake\"\nkind=\"brake\"\ntype=\"disc\"\n\
     from={body=\"frame\",at=[0.6,0.0,0.5]}\nto={body=\"wheelset[1]\",at=[1.28,0.0,0.46]}\nstiffness=\"6 MN m/rad\"\n[track]\ngauge=\"1435 mm\"\ninclination=\"1:40\"\nrail={kind=\"60e1\"}\n\
     [contact]\nformulation=\"ECF-A\"\nfriction=0.35\nmaterial={youngs_modulus=\"210 GPa\",poisson_ratio=0.28}\ncreep={law=\"polach\"}\n\
     [interface]\ninputs=[\"elements\"]\noutputs=[\"motion\",\"forces\",\"energy\"]\n[run]\nstop=0.4\nstep=\"1 ms\"\n";

/// Torque and heat of a brake that takes hold and lets go every 20 ms, at the default tolerance: by plain errors of its deflection they were off by 188 of 2000 N m and 0.9 %.
#[test]
fn hard_a_brake_that_is_let_go_is_as_right_as_its_torque() {
    let run = |changes: &[&str]| -> Vec<[f64; 2]> {
        let scene = read(BRAKE, changes);
        let mut simulation = Simulation::new(&scene, 0.0).unwrap();
        let input = simulation.model().first_element_input();
        let row = |k: u32| {
            let on = if (k / 20) % 2 == 1 { 2000.0 } else { 0.0 };
            simulation.set_input(input, on, 0.0, 0.0);
            simulation.advance(1e-3 * f64::from(k + 1)).unwrap();
            values(&mut simulation, &scene, ["brake.torque", "brake.heat"])
        };
        (0..400).map(row).collect()
    };
    let (found, right) = (run(&[]), run(&["solver.integrator=dormand_prince", "solver.tolerance=1e-9"]));
    let off = |k: usize| found.iter().zip(&right).map(|(a, b)| (a[k] - b[k]).abs()).fold(0.0, f64::max);
    let heat = right.last().unwrap()[1];
    println!("torque off by {:.1} N m, heat by {:.1} of {heat:.0} J", off(0), off(1));
    assert!(heat > 1e4 && off(0) < 60.0 && off(1) < 2e-3 * heat, "{} N m, {} J", off(0), off(1));
}

/// A truck whose boxes are held about the axle, with a sensor off the axle, before a slope.
const BOXES: &str = "name=\"boxes\"\n[vehicle]\ntemplate=\"bogie\"\nspeed=20.0\n[[vehicle.force]]\nname=\"link\"\nkind=\"bushing\"\n\
     from={body=\"frame\",at=[1.28,0.0,0.46]}\nto={body=\"wheelset[1]\",at=[1.28,0.0,0.46]}\nstiffness=[0.0,0.0,0.0]\ndamping=[0.0,0.0,0.0]\nrotational_stiffness=[0.0,2e6,0.0]\nrotational_damping=[0.0,2e3,0.0]\n\
     [[vehicle.sensor]]\nname=\"box\"\nbody=\"wheelset[1]\"\nat=[1.58,1.0,0.56]\nmeasured=true\n[track]\ngauge=\"1435 mm\"\ninclination=\"1:40\"\nrail={kind=\"60e1\"}\n\
     [contact]\nformulation=\"ECF-A\"\nfriction=0.35\nmaterial={youngs_modulus=\"210 GPa\",poisson_ratio=0.28}\ncreep={law=\"polach\"}\n\
     [interface]\noutputs=[\"motion\",\"bodies\",\"wheels\",\"sensors\",\"forces\",\"energy\"]\n[run]\nstop=0.4\nstep=\"1 ms\"\n";

/// A grade is a grade, whether nodes give it or the track has it from the beginning: boxes on axles stood level in the world on the former.
#[test]
fn analytic_boxes_stand_on_the_track_of_a_grade() {
    let names = [
        "wheelset[1].left.verticalForce",
        "wheelset[2].right.verticalForce",
        "frame.z",
        "link.momentY",
        "box.ax",
        "box.az",
        "box.y",
        "box.z",
        "link.angleY",
    ];
    let of = |changes: &[&str]| {
        let scene = read(BOXES, changes);
        let mut simulation = Simulation::new(&scene, 0.0).unwrap_or_else(|error| panic!("{error}"));
        simulation.advance(0.4).unwrap();
        values(&mut simulation, &scene, names)
    };
    let (plain, nodes) = (of(&["track.grade=0.03"]), of(&["track.node=[{distance=-500,grade=0.03}]"]));
    for ((name, one), other) in names.iter().zip(plain).zip(nodes) {
        println!("{name}: {one} {other}");
    }
    for ((name, one), other) in names.iter().zip(plain).zip(nodes) {
        assert!((one - other).abs() < 1e-5 * one.abs().max(0.1), "{name}: {one} with track.grade, {other} with track.node");
    }
}

/// In a vertical curve the track turns under the wheelset; slip is of the spin in space (with that against the track a sag of 1000 m showed 9 mm/s at 20 m/s).
#[test]
fn analytic_slip_in_a_vertical_curve_is_that_on_level_track() {
    let slip = |node: &str| {
        let changes = ["track.deviation=[]", node, "vehicle.speed=20", "interface.outputs=[\"motion\", \"adhesion\"]"].map(str::to_string);
        let scene = load::open("suspended_wheelset", &changes).unwrap_or_else(|error| panic!("{error}"));
        let mut simulation = Simulation::new(&scene, 0.0).unwrap();
        simulation.advance(3.0).unwrap();
        values(&mut simulation, &scene, ["wheelset.slipSpeed", "wheelset.pitchRate"])
    };
    let [level, level_rate] = slip("track.node=[{distance=-100},{distance=400}]");
    let [sag, sag_rate] = slip("track.node=[{distance=-100,grade=-0.1},{distance=300,grade=0.3}]");
    println!("slip {level:.5} and {sag:.5} m/s, spin {level_rate:.5} and {sag_rate:.5} rad/s");
    assert!((sag_rate - level_rate - 0.02).abs() < 0.002 && (sag - level).abs() < 1e-3);
}
