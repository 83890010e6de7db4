//! `vehicle.speed` as a table: the speed follows it, the driving force is what the acceleration takes, whatever formulation, method and track.

use crate::common::{largest_difference, run, start};
use wheelrail::scene::load;
use wheelrail::scene::spec::Scene;
use wheelrail::sim::recording::Recording;

const RAMP: &str = "vehicle.speed=[{time=0,speed=\"10 m/s\"},{time=1,speed=\"10 m/s\"},{time=4,speed=\"54 km/h\"}]";
const ENERGY: &str = "interface.outputs=[\"motion\",\"wheels\",\"suspension\",\"bodies\",\"power\",\"energy\"]";

fn open(scene: &str, changes: &[&str]) -> Result<Scene, String> {
    let changes: Vec<String> = changes.iter().map(|change| (*change).to_string()).collect();
    load::open(scene, &changes).map_err(|error| error.to_string())
}

fn scene(name: &str, changes: &[&str]) -> Scene {
    open(name, changes).unwrap_or_else(|error| panic!("{changes:?}: {error}"))
}

/// Speed, acceleration and way of [`RAMP`]: trapezium of 3 s with corners of 0.75 s.
fn ramp(t: f64) -> [f64; 3] {
    let (corner, length, rise) = (0.75, 3.0, 5.0);
    let (plateau, d) = (rise / (length - corner), (t - 1.0).clamp(0.0, length));
    let way = |d: f64| plateau * d.powi(3) / (6.0 * corner);
    let (speed, acceleration, gained) = if d < corner {
        (0.5 * plateau * d * d / corner, plateau * d / corner, way(d))
    } else if d <= length - corner {
        let e = d - corner;
        (plateau * (0.5 * corner + e), plateau, way(corner) + plateau * (0.5 * corner * e + 0.5 * e * e))
    } else {
        let left = length - d;
        // From the end backwards: rise - what is still to come.
        (rise - 0.5 * plateau * left * left / corner, plateau * left / corner, 0.5 * rise * length - (rise * left - way(left)))
    };
    [10.0 + speed, acceleration, 10.0 * t + gained + rise * (t - 1.0 - length).max(0.0)]
}

fn column(recording: &Recording, name: &str) -> Vec<f64> {
    recording.column(name).unwrap_or_else(|| panic!("no column {name}"))
}

/// Largest |column - expected|.
fn off(recording: &Recording, name: &str, expected: impl Fn(usize) -> f64) -> f64 {
    column(recording, name).iter().enumerate().map(|(row, value)| (value - expected(row)).abs()).fold(0.0, f64::max)
}

/// `F_d + F_x = (m + M) a` at every instant, and on a plain track in steady acceleration `F_d = (m + M + I / r^2) a` but for the resistance of rolling (0.3 N), r the rolling radius.
#[test]
fn analytic_driving_force_speed_and_way_of_a_ramp() {
    let adaptive = "solver.tolerance=1e-7";
    let cases = [
        ("ECF-A", "rosenbrock", adaptive, 1e-9),
        ("ECF-A", "dormand_prince", adaptive, 1e-9),
        ("ECF-A", "rk43", adaptive, 1e-9),
        ("ECF-A", "imex", adaptive, 1e-9),
        ("ECF-A", "rk4", "solver.step=1e-4", 1e-9),
        ("ECF-A", "zhai", "solver.step=1e-4", 1e-7),
        ("ECF-A", "real_time", "solver.step=1e-3", 1e-6),
        ("ECF-A", "generalised_alpha", "solver.step=1e-3", 2e-6),
        ("ECF-N", "rosenbrock", adaptive, 1e-9),
        ("ECCF", "rosenbrock", adaptive, 1e-9),
        ("ACCF", "dormand_prince", adaptive, 1e-9),
        ("ECCF", "real_time", "solver.step=1e-3", 1e-6),
    ];
    let (mass, inertia, radius) = (1568.0 + 98000.0 / 9.81, 168.0, 0.457);
    for (formulation, method, setting, way) in cases {
        let [formulation, integrator] = [format!("contact.formulation={formulation}"), format!("solver.integrator={method}")];
        let scene = scene("suspended_wheelset", &["track.deviation=[]", RAMP, &formulation, &integrator, setting]);
        let run = run(&scene, 4.5, 0.0125);
        let time = column(&run, "time");
        let speed = off(&run, "wheelset.vx", |row| ramp(time[row])[0]);
        let rate = off(&run, "wheelset.ax", |row| ramp(time[row])[1]);
        let distance = off(&run, "wheelset.distance", |row| ramp(time[row])[2]);
        println!("{formulation} {method}: speed {speed:.1e}, acceleration {rate:.1e}, way {distance:.1e}");
        assert!(speed < 1e-9 && rate < 1e-9 && distance < way, "{formulation} {method}: {speed:e} {rate:e} {distance:e}");
        let creep = ["left", "right"].map(|side| column(&run, &format!("wheelset.{side}.longitudinalForce")));
        let balance = off(&run, "wheelset.drivingForce", |row| mass * ramp(time[row])[1] - creep[0][row] - creep[1][row]);
        assert!(balance < 1e-6, "{formulation} {method}: {balance} N");
        let force = column(&run, "wheelset.drivingForce");
        for row in (0..time.len()).filter(|row| (2.2..3.0).contains(&time[*row])) {
            let expected = (mass + inertia / (radius * radius)) * ramp(time[row])[1];
            assert!((force[row] / expected - 1.0).abs() < 5e-4, "{formulation} {method}: {} {expected}", force[row]);
        }
    }
}

/// Over distance: V(s) at every instant, `a = V dV/ds`; backwards it is the mirror image.
#[test]
fn analytic_a_speed_over_distance() {
    let table = |sign: f64| {
        let nodes = [(10.0, 12.0), (60.0, 20.0), (110.0, 8.0)].map(|(s, v)| (sign * s, sign * v));
        let mut nodes = nodes.map(|(s, v)| format!("{{distance={s},speed={v}}}"));
        if sign < 0.0 {
            nodes.reverse();
        }
        format!("vehicle.speed=[{}]", nodes.join(","))
    };
    for method in ["solver.tolerance=1e-7", "solver.integrator=dormand_prince", "contact.formulation=ECCF"] {
        let both = [1.0, -1.0].map(|sign| {
            let scene = scene("suspended_wheelset", &["track.deviation=[]", "solver.integrator=rosenbrock", &table(sign), method]);
            let profile = scene.vehicle.speed_profile().unwrap().clone();
            let run = run(&scene, 9.0, 0.0125);
            let distance = column(&run, "wheelset.distance");
            let speed = off(&run, "wheelset.vx", |row| profile.at(distance[row])[0]);
            let rate = off(&run, "wheelset.ax", |row| profile.at(distance[row]).iter().product());
            assert!(speed < 1e-9 && rate < 1e-9, "{method}: {speed:e} {rate:e}");
            assert!((column(&run, "wheelset.vx")[distance.len() - 1] - sign * 8.0).abs() < 1e-9);
            (distance, column(&run, "wheelset.drivingForce"))
        });
        let mirrored = both[1].0.iter().map(|s| -s).collect::<Vec<_>>();
        assert!(largest_difference(&both[0].0, &mirrored) < 1e-6, "{method}: {}", largest_difference(&both[0].0, &mirrored));
    }
}

/// A vehicle under steady acceleration: the forces of all driven wheelsets together are `(sum of m + sum of I / r^2) a`, and the wheelsets keep their distances.
#[test]
fn analytic_driving_force_of_a_coach() {
    for drive in ["all", "leading"] {
        let ramp = "vehicle.speed=[{time=0,speed=20},{time=1,speed=20},{time=41,speed=40}]";
        let scene = scene("vehicle_manchester_1", &["track.deviation=[]", ramp, &format!("vehicle.drive={drive}")]);
        let simulation = start(&scene);
        let model = simulation.model();
        let turning = scene.vehicle.wheelsets.iter().map(|placed| {
            let spec = &placed.spec;
            spec.axial_inertia / spec.profiles[0].profile.at(0.0).value.powi(2)
        });
        let mass = model.system.bodies.iter().map(|body| body.mass).sum::<f64>() + turning.sum::<f64>();
        let run = run(&scene, 20.0, 0.05);
        let (time, acceleration) = (column(&run, "time"), 20.0 / 39.0);
        let driven: Vec<Vec<f64>> =
            run.columns.iter().filter(|(name, _)| name.ends_with(".drivingForce")).map(|(name, _)| column(&run, name)).collect();
        assert_eq!(driven.len(), if drive == "all" { 2 } else { 1 });
        let total = |row: usize| driven.iter().map(|force| force[row]).sum::<f64>();
        let rolling = total(0);
        let steady: Vec<f64> = (0..time.len()).filter(|row| time[*row] > 10.0).map(total).collect();
        let mean = steady.iter().sum::<f64>() / steady.len() as f64 - rolling;
        println!("{drive}: {mean} N, expected {}", mass * acceleration);
        assert!((mean / (mass * acceleration) - 1.0).abs() < 2e-3, "{drive}: {mean} {}", mass * acceleration);
    }
}

/// In a curve the speed along the track is that of the table, and books of energy close with the work of the driving force: with a supported load, too.
#[test]
fn analytic_a_ramp_in_a_curve_and_its_energy() {
    let curve = "track.node=[{distance=0},{distance=40},{distance=80,radius=500,superelevation=\"60 mm\"}]";
    let faster = "vehicle.speed=[{time=0.5,speed=15},{time=6,speed=22}]";
    let farther = "vehicle.speed=[{distance=30,speed=15},{distance=90,speed=22}]";
    let cases = [
        ("suspended_wheelset", vec![curve, faster, "track.deviation=[]", "solver.integrator=rosenbrock", "solver.tolerance=1e-8"]),
        ("suspended_wheelset", vec![curve, farther, "track.deviation=[]", "solver.integrator=rosenbrock", "solver.tolerance=1e-8"]),
        ("suspended_wheelset", vec![curve, faster, "track.deviation=[]", "contact.formulation=ECCF"]),
        ("vehicle_equalised", vec![curve, faster, "track.deviation=[]", "solver.tolerance=1e-7"]),
        (
            "vehicle_equalised",
            vec![curve, farther, "track.deviation=[]", "vehicle.drive=leading", "contact.formulation=ECCF", "contact.on_lift=elastic"],
        ),
    ];
    for (name, mut changes) in cases {
        changes.push(ENERGY);
        let scene = scene(name, &changes);
        let profile = scene.vehicle.speed_profile().unwrap().clone();
        let over_time = changes[1].contains("time");
        let run = run(&scene, 6.0, 0.02);
        let time = column(&run, "time");
        let leading = format!("{}.", scene.vehicle.leading().name);
        let distance = column(&run, &format!("{leading}distance"));
        for (wheelset, _) in scene.vehicle.axles().iter().filter(|axle| axle.1) {
            let worst = off(&run, &format!("{wheelset}.vx"), |row| profile.at(if over_time { time[row] } else { distance[row] })[0]);
            assert!(worst < 1e-9, "{name} {changes:?} {wheelset}: {worst:e}");
        }
        let sum = |ends: &[&str]| -> Vec<f64> {
            let names = run.columns.iter().map(|(name, _)| name).filter(|name| ends.iter().any(|end| name.ends_with(end)));
            let mut total = vec![0.0; time.len()];
            for name in names {
                total.iter_mut().zip(column(&run, name)).for_each(|(total, value)| *total += value);
            }
            total
        };
        let stored = sum(&["energy.kinetic", "energy.height", "energy.elements"]);
        let given = sum(&[".inputWork", ".drivingWork", ".work", "energy.contactWork", "energy.guideWork"]);
        let taken = sum(&[".frictionHeat", ".heat", "energy.suspensionHeat"]);
        let left = (0..time.len()).map(|i| (stored[i] - stored[0] - given[i] + taken[i]).abs()).fold(0.0, f64::max);
        println!("{name} {changes:?}: {left:.3e} J of {:.3e} J", given[time.len() - 1]);
        // What turns the weight of a supported load in a curve is in no book.
        let share = if name == "suspended_wheelset" { 2e-3 } else { 1e-3 };
        assert!(left < share * given[time.len() - 1].abs(), "{name} {changes:?}: {left} J of {}", given[time.len() - 1]);
    }
}

/// Explicit and implicit methods, with and without error control, come to one motion: over a deviation, with corners of the table inside of steps.
#[test]
fn equiv_methods_agree_on_a_ramp() {
    let ramp = "vehicle.speed=[{time=0.1,speed=38},{time=0.513,speed=43},{time=0.87,speed=41}]";
    for formulation in ["ECF-A", "ECCF"] {
        let formulation = format!("contact.formulation={formulation}");
        let with = |method: &[&str]| run(&scene("suspended_wheelset", &[&[ramp, &formulation], method].concat()), 1.5, 0.005);
        let reference = with(&["solver.integrator=dormand_prince", "solver.tolerance=1e-11"]);
        for (method, setting, most) in [
            ("rosenbrock", "solver.tolerance=1e-9", 1e-6),
            ("rk43", "solver.tolerance=1e-10", 1e-7),
            ("generalised_alpha", "solver.step=1e-4", 1e-5),
            ("real_time", "solver.step=1e-4", 1e-5),
            ("rk4", "solver.step=1e-4", 1e-7),
        ] {
            let own = with(&[&format!("solver.integrator={method}"), setting]);
            let y = largest_difference(&column(&reference, "wheelset.y"), &column(&own, "wheelset.y"));
            let s = largest_difference(&column(&reference, "wheelset.distance"), &column(&own, "wheelset.distance"));
            println!("{formulation} {method}: y {y:.1e}, distance {s:.1e}");
            assert!(y < most && s < most, "{formulation} {method}: {y:e} {s:e}");
        }
    }
}

/// Where a master looks changes nothing, and a clone of the state goes on with the same bits.
#[test]
fn prop_communication_and_clones_change_no_bit() {
    for table in [RAMP, "vehicle.speed=[{distance=5,speed=10},{distance=31,speed=16}]"] {
        let scene = scene("suspended_wheelset", &[table]);
        let at = |step: f64| {
            let mut simulation = start(&scene);
            let mut t = 0.0;
            while t < 3.0 - 1e-12 {
                t = (t + step).min(3.0);
                simulation.advance(t).unwrap();
            }
            simulation.snapshot().unwrap().y.clone()
        };
        assert_eq!(at(0.0173), at(3.0), "{table}");
        let mut simulation = start(&scene);
        simulation.advance(1.4).unwrap();
        let kept = simulation.state().clone();
        let mut whole = |kept: Option<&wheelrail::sim::SimulationState>| {
            if let Some(kept) = kept {
                assert!(simulation.restore(kept));
            }
            simulation.advance(3.0).unwrap();
            simulation.snapshot().unwrap().y.clone()
        };
        let (first, again) = (whole(None), whole(Some(&kept)));
        assert_eq!(first, again, "{table}");
        assert_eq!(first, at(3.0), "{table}");
    }
}

/// A part of a vehicle carries the mass of what is cut away along the track: it takes the same force as the whole.
#[test]
fn equiv_levels_of_detail_take_their_force() {
    let ramp = "vehicle.speed=[{time=0,speed=20},{time=21,speed=40}]";
    let scene = scene("vehicle_equalised", &["track.deviation=[]", ramp, "vehicle.detail=truck"]);
    let away = scene.vehicle.away().unwrap();
    let simulation = start(&scene);
    let turning: f64 =
        scene.vehicle.wheelsets.iter().map(|w| w.spec.axial_inertia / w.spec.profiles[0].profile.at(0.0).value.powi(2)).sum();
    let mass = simulation.model().system.bodies.iter().map(|body| body.mass).sum::<f64>() + away.carried + turning;
    let run = run(&scene, 15.0, 0.05);
    let time = column(&run, "time");
    let driven: Vec<Vec<f64>> =
        run.columns.iter().filter(|(name, _)| name.ends_with(".drivingForce")).map(|(name, _)| column(&run, name)).collect();
    let total = |row: usize| driven.iter().map(|force| force[row]).sum::<f64>();
    let steady: Vec<f64> = (0..time.len()).filter(|row| time[*row] > 8.0).map(total).collect();
    let mean = steady.iter().sum::<f64>() / steady.len() as f64 - total(0);
    println!("{mean} N, {mass} kg");
    assert!(away.carried > 1000.0 && (mean / mass - 1.0).abs() < 2e-3, "{mean} {mass}");
}

#[test]
fn prop_wrong_tables_are_refused_with_reason_and_cure() {
    for (table, said) in [
        ("[{time=1,speed=10}]", "vehicle.speed: found one node; expected two or more, or one number"),
        (
            "[{time=1,speed=10},{distance=2,speed=3}]",
            "vehicle.speed[2].distance: stands in a list over time; expected time in all nodes or distance",
        ),
        ("[{time=1,distance=1,speed=10},{time=2,speed=3}]", "vehicle.speed[1].distance: stands in a list over time"),
        ("[{time=1,speed=10},{time=\"1 s\",speed=3}]", "vehicle.speed[2].time: found 1.0 s behind 1.0 s; expected ascending time"),
        (
            "[{distance=1,speed=10},{distance=0,speed=3}]",
            "vehicle.speed[2].distance: found 0.0 m behind 1.0 m; expected ascending distance",
        ),
        ("[{time=1,speed=10},{time=2,speed=-3}]", "vehicle.speed[2].speed: found -3.0 m/s behind 10.0 m/s; expected one sign"),
        ("[{time=1,speed=10},{time=2,speed=0}]", "vehicle.speed[2].speed: found 0"),
        ("[{time=1,speed=10},{time=2,speed=600}]", "vehicle.speed[2].speed: found 600.0 m/s, expected at most 500.0 m/s"),
        ("[{time=1},{time=2,speed=6}]", "vehicle.speed[1].speed: is missing"),
        ("[{speed=10},{time=2,speed=5}]", "vehicle.speed[1].time: is missing; expected a time or a distance in each node"),
        ("[{time=1,speed=10,to=1},{time=2,speed=5}]", "vehicle.speed[1].to: unknown key"),
    ] {
        let error = open("suspended_wheelset", &[&format!("vehicle.speed={table}")]).err().unwrap_or_else(|| panic!("{table}"));
        assert!(error.contains(said), "{table}: {error}");
    }
    let free = open("suspended_wheelset", &[RAMP, "vehicle.travel=free"]).err().unwrap();
    assert!(free.contains("with travel = \"free\" forces along the track change the speed; expected one number"), "{free}");
    for table in ["[{time=-1,speed=10},{time=2,speed=5}]", "[{distance=-10,speed=10},{distance=20,speed=5}]"] {
        let within = open("suspended_wheelset", &[&format!("vehicle.speed={table}")]).unwrap();
        let error = wheelrail::sim::Simulation::new(&within, 0.0).unwrap_err().to_string();
        assert!(error.contains("within a ramp of vehicle.speed") && error.contains("begin it where the speed is constant"), "{error}");
    }
    // A later start is one at that time's speed.
    let later = wheelrail::sim::Simulation::new(&scene("suspended_wheelset", &[RAMP]), 7.0).unwrap();
    assert_eq!(later.state().integration.y[6], 15.0);
}

/// On a long hill of the rails the force that imposes the speed is the slope under each wheelset times its load, and what creep takes: 10 N. An error within the
/// tolerance of position, 1e-5 m, was 330 N of 3.4 kN in the springs along the track, to one side, and the work of the whole hill 70 kJ off.
#[test]
fn analytic_the_driving_force_on_a_hill_is_that_of_its_slopes() {
    let (height, from, length) = (5.0, 20.0, 1000.0);
    let hill = format!(
        "track.deviation=[{{rail=\"both\", direction=\"vertical\", shape=\"cosine\", amplitude={height}, from={from}, to={}}}]",
        from + length
    );
    let found = run(&scene("bogie", &[&hill, ENERGY]), 52.0, 0.05);
    let slope = |s: f64| {
        let wave = std::f64::consts::TAU / length;
        if (from..from + length).contains(&s) { 0.5 * height * wave * (wave * (s - from)).sin() } else { 0.0 }
    };
    let force = column(&found, "wheelset[1].drivingForce");
    let mut expected = vec![0.0; force.len()];
    for wheelset in ["wheelset[1]", "wheelset[2]"] {
        let part = |name: &str| column(&found, &format!("{wheelset}.{name}"));
        let (distance, left, right) = (part("distance"), part("left.verticalForce"), part("right.verticalForce"));
        for (i, sum) in expected.iter_mut().enumerate() {
            *sum += slope(distance[i]) * (left[i] + right[i]);
        }
    }
    // Where the hill begins and ends, its bend jumps and the vehicle bounces.
    let steady = 120..880;
    let worst = largest_difference(&force[steady.clone()], &expected[steady]);
    let [work, lost] = [column(&found, "wheelset[1].drivingWork"), column(&found, "energy.suspensionHeat")].map(|all| all[all.len() - 1]);
    let highest = column(&found, "wheelset[1].drivingWork").into_iter().fold(0.0f64, f64::max);
    println!(
        "driving force within {worst:.1} N of {:.0}; work {work:.0} J of {highest:.0} J uphill, heat of the suspension {lost:.0} J",
        slope(from + 0.25 * length) * 218e3
    );
    assert!(worst < 60.0 && work > 0.0 && work < 0.02 * highest);
}
