//! Two ways of ours to the same result.

use crate::common::{column, largest_difference, read, run, scene, start, table};
use wheelrail::scene::load;

#[test]
fn equiv_analytic_profiles_and_their_201_point_splines() {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/measured_profiles/scene.toml");
    let splined = load::open(file, &["solver.tolerance=1e-13".into()]).unwrap();
    assert_eq!(splined.files().count(), 2, "both profiles must come from files");
    let (a, b) = (run(&scene(&["solver.tolerance=1e-13"]), 5.0, 0.01), run(&splined, 5.0, 0.01));
    // The rail's curvature is off by h^2 f''''/12 = 8e-8 relative at h = 0.3 mm, which moves the normal force.
    for (name, allowed) in [("y", 1e-9), ("yaw", 1e-9), ("z", 1e-9), ("left.normalForce", 0.1), ("left.contact[1].semiAxisB", 1e-8)] {
        let difference = largest_difference(&column(&a, name), &column(&b, name));
        println!("{name}: largest difference {difference:.1e}");
        assert!(difference < allowed, "{name}: {difference:e}");
        assert!(difference > 0.0, "the spline was not used");
    }
}

#[test]
fn equiv_result_does_not_depend_on_the_communication_step() {
    let scene = scene(&[]);
    let [fine, coarse] = [0.001, 0.010].map(|step| run(&scene, 3.0, step));
    for name in ["y", "z", "yaw", "roll"] {
        let fine: Vec<f64> = column(&fine, name).into_iter().step_by(10).collect();
        let difference = largest_difference(&fine, &column(&coarse, name));
        println!("{name}: 1 ms against 10 ms, largest difference {difference:.1e}");
        assert!(difference < 1e-9, "{name}: {difference:e}");
    }
}

#[test]
fn equiv_integrators_agree() {
    let adaptive = run(&scene(&[]), 2.0, 0.01);
    let fixed = run(&scene(&["solver.integrator=rk4", "solver.step=0.0005"]), 2.0, 0.01);
    let difference = largest_difference(&column(&adaptive, "y"), &column(&fixed, "y"));
    println!("Dormand-Prince against RK4 with 0.5 ms: {difference:.1e} m");
    assert!(difference < 1e-8);
}

#[test]
fn equiv_looking_at_outputs_changes_nothing() {
    let scene = scene(&[]);
    let (mut watched, mut alone) = (start(&scene), start(&scene));
    let outputs = table(&watched, &scene);
    for i in 1..=200 {
        let time = 0.005 * f64::from(i);
        watched.advance(time).unwrap();
        alone.advance(time).unwrap();
        if i % 20 == 0 {
            for one in [&mut watched, &mut alone] {
                one.set_input(wheelrail::formulation::LATERAL_FORCE, 1e3 * f64::from(i % 3), 0.0, 0.0);
            }
        }
        read(&mut watched, &outputs);
        let along = watched.slope().unwrap();
        watched.displace(1e-6, &along, None).unwrap();
    }
    assert_eq!(watched.state(), alone.state());
}

/// Derivatives right after an input was set are slopes of what is handed out next, also of wheels that it does not touch: the step that comes restarts along f, or goes
/// on with what the input changes.
#[test]
fn equiv_derivatives_after_an_input_is_set_are_slopes_of_what_follows() {
    const AHEAD: f64 = 2e-6;
    let track = "track.irregularity=[{kind=\"spectrum\",spectrum=\"ore_b176_low\",seed=1,from=5,to=400,fade=5}]";
    let scene = load::open("bogie", &["track.deviation=[]".into(), track.into()]).unwrap_or_else(|error| panic!("{error}"));
    let mut simulation = start(&scene);
    let outputs = table(&simulation, &scene);
    let named = |name: &str| outputs.iter().find(|output| output.name == name).expect("an output");
    let all = ["wheelset[1].left.verticalForce", "wheelset[2].left.verticalForce", "wheelset[2].az"].map(named);
    let (mut worst, mut largest) = ([0.0f64; 3], [0.0f64; 3]);
    for i in 1..60 {
        simulation.advance(0.0103 * f64::from(i)).unwrap();
        let torque = if i % 2 == 0 { 3e3 } else { 6e3 };
        simulation.set_input(wheelrail::formulation::input_index(0, wheelrail::formulation::DRIVE_TORQUE), torque, 0.0, 0.0);
        let along = simulation.slope().unwrap();
        let mut told = |offset: f64| {
            simulation.displace(offset, &along, None).unwrap();
            all.map(|output| output.value(simulation.seen()))
        };
        let (ahead, behind) = (told(1e-6), told(-1e-6));
        let mut at = |time: f64| {
            simulation.advance(time).unwrap();
            let snapshot = simulation.snapshot().unwrap();
            all.map(|output| output.value(snapshot))
        };
        let time = 0.0103 * f64::from(i);
        let (first, second) = (at(time + AHEAD), at(time + 2.0 * AHEAD));
        for k in 0..3 {
            let slope = (second[k] - first[k]) / AHEAD;
            worst[k] = worst[k].max(((ahead[k] - behind[k]) / 2e-6 - slope).abs());
            largest[k] = largest[k].max(slope.abs());
        }
    }
    println!("off by {worst:.3?} of {largest:.3?}");
    // Where places of strips begin to slide slopes change within that time, by up to 3 %.
    assert!((0..3).all(|k| worst[k] < 0.05 * largest[k]));
}

#[test]
fn equiv_restored_state_continues_bit_for_bit() {
    let scene = scene(&[]);
    let mut simulation = start(&scene);
    simulation.advance(0.6037).unwrap();
    simulation.set_input(wheelrail::formulation::LATERAL_FORCE, 1e4, 5e4, 1e5);
    let saved = simulation.state().clone();
    simulation.advance(0.8).unwrap();
    let first = simulation.state().clone();
    assert_ne!(saved, first);
    assert!(simulation.restore(&saved));
    simulation.advance(0.8).unwrap();
    assert_eq!(simulation.state(), &first);

    let mut other = start(&scene);
    assert!(other.restore(&saved));
    other.advance(0.8).unwrap();
    assert_eq!(other.state(), &first);
}

#[test]
fn equiv_mirrored_scene_gives_mirrored_results() {
    let mirrored = scene(&["track.deviation[1].rail=left", "track.deviation[1].amplitude=-10 mm", "solver.tolerance=1e-13"]);
    let (a, b) = (run(&scene(&["solver.tolerance=1e-13"]), 2.0, 0.01), run(&mirrored, 2.0, 0.01));
    let opposite = |name: &str| column(&b, name).iter().map(|value| -value).collect::<Vec<_>>();
    assert!(largest_difference(&column(&a, "y"), &opposite("y")) < 1e-11);
    assert!(largest_difference(&column(&a, "yaw"), &opposite("yaw")) < 1e-11);
    assert!(largest_difference(&column(&a, "left.normalForce"), &column(&b, "right.normalForce")) < 1e-4);
}

#[test]
fn equiv_rolling_backward_over_the_mirrored_disturbance() {
    // The disturbance is symmetric about 25 m: backward from 50 m is forward from 0 m seen in a mirror.
    let (forward, backward) =
        (scene(&["solver.tolerance=1e-13"]), scene(&["solver.tolerance=1e-13", "vehicle.speed=-40", "vehicle.initial.distance=50"]));
    let (a, b) = (run(&forward, 2.0, 0.01), run(&backward, 2.0, 0.01));
    let opposite = |name: &str| column(&b, name).iter().map(|value| -value).collect::<Vec<_>>();
    assert!(largest_difference(&column(&a, "y"), &column(&b, "y")) < 1e-11);
    assert!(largest_difference(&column(&a, "yaw"), &opposite("yaw")) < 1e-11);
    assert!(largest_difference(&column(&a, "drivingForce"), &opposite("drivingForce")) < 1e-3);
    assert!(largest_difference(&column(&a, "left.lateralForce"), &column(&b, "left.lateralForce")) < 1e-2);
}

/// Runs the paper's scene with a formulation and further changes, 5 s every 10 ms.
fn with(formulation: &str, changes: &[&str]) -> wheelrail::sim::recording::Recording {
    let formulation = format!("contact.formulation={formulation}");
    let mut all = vec![formulation.as_str()];
    all.extend(changes);
    run(&scene(&all), 5.0, 0.01)
}

#[test]
fn equiv_accf_and_eccf_solve_the_same_equations() {
    let (augmented, embedded) = (with("ACCF", &["solver.tolerance=1e-13"]), with("ECCF", &["solver.tolerance=1e-13"]));
    // Normal forces jump at the ends of the deviation (50 and 75 rows down), where the side of the jump is a matter of rounding.
    let away = |name: &str, recording: &_| {
        let kinks = |row: &usize| ![50, 75].contains(row);
        column(recording, name).into_iter().enumerate().filter(|(row, _)| kinks(row)).map(|(_, value)| value).collect::<Vec<_>>()
    };
    for (name, allowed) in
        [("y", 1e-9), ("yaw", 1e-9), ("z", 1e-12), ("roll", 1e-10), ("left.normalForce", 0.05), ("right.normalForce", 0.05)]
    {
        let difference = largest_difference(&away(name, &augmented), &away(name, &embedded));
        println!("ACCF against ECCF, {name}: largest difference {difference:.1e}");
        assert!(difference < allowed, "{name}: {difference:e}");
        assert!(difference > 0.0, "{name}: one of them must have been run twice");
    }
}

#[test]
fn equiv_elastic_contact_tends_to_the_constraint_with_stiffness() {
    let mut last: Option<(f64, f64)> = None;
    for factor in [1.0, 8.0, 64.0] {
        let modulus = format!("contact.material.youngs_modulus={:e}", 2.07e11 * factor);
        // Stiffer contact vibrates faster; damping as it is, so that the vibration decays as fast or faster than before.
        let changes = [modulus.as_str(), "solver.tolerance=1e-12"];
        let (elastic, rigid) = (with("ECF-A", &changes), with("ECCF", &changes));
        let lateral = largest_difference(&column(&elastic, "y"), &column(&rigid, "y"));
        let lower: Vec<f64> = column(&rigid, "z").iter().zip(column(&elastic, "z")).map(|(rigid, elastic)| rigid - elastic).collect();
        let penetration = column(&elastic, "left.contact[1].penetration");
        println!(
            "E x {factor}: lateral difference {lateral:.2e} m, lower by {:.4e} m, static penetration {:.4e} m",
            lower[0], penetration[0]
        );
        // At rest the elastic wheelset stands lower by the penetration, over the cosine of the contact angle (1:40).
        assert!((lower[0] * 0.025f64.atan().cos() / penetration[0] - 1.0).abs() < 1e-6);
        assert!(lateral < 5e-6 && lateral > 0.0);
        if let Some((lateral_before, lower_before)) = last {
            // E^(-2/3): a quarter for eight times the modulus.
            assert!((lower_before / lower[0] / 4.0 - 1.0).abs() < 1e-6, "{}", lower_before / lower[0]);
            let ratio = lateral_before / lateral;
            assert!((3.5..4.5).contains(&ratio), "the lateral difference must fall fourfold: {ratio}");
        }
        last = Some((lateral, lower[0]));
    }
}

#[test]
fn equiv_nodal_search_solves_the_algebraic_equations_at_any_spacing() {
    let algebraic = with("ECF-A", &["solver.tolerance=1e-10"]);
    for spacing in ["1.6 mm", "0.4 mm", "0.1 mm", "0.025 mm"] {
        let nodal = with("ECF-N", &[&format!("contact.node_spacing={spacing}"), "solver.tolerance=1e-8"]);
        let differences = ["y", "z", "left.normalForce"].map(|name| largest_difference(&column(&algebraic, name), &column(&nodal, name)));
        println!(
            "ECF-N, nodes every {spacing}: y {:.1e} m, z {:.1e} m, normal force {:.1e} N",
            differences[0], differences[1], differences[2]
        );
        // The profiles tell where the contact is, at any spacing.
        assert!(differences[0] < 1e-9 && differences[1] < 5e-9 && differences[2] < 1.0, "{differences:?}");
    }
}

#[test]
fn equiv_creep_forces_of_nodes_are_nearly_as_smooth_as_the_algebraic_ones() {
    // Section 4.2 takes contacts at nodes: on a 1:40 cone the rolling radius would jump by 0.025 mm at 1 mm of spacing, Fx by Kalker's
    // c11 G a b times 5.5e-5 (300 N). Here they are where the overlap is deepest between them.
    let jump = |formulation: &str, spacing: &str| {
        let formulation = format!("contact.formulation={formulation}");
        let scene = scene(&[&formulation, &format!("contact.node_spacing={spacing}")]);
        let mut simulation = start(&scene);
        let outputs = table(&simulation, &scene);
        simulation.advance(0.6).unwrap();
        let (mut largest, mut last) = (0f64, None);
        for row in 1..=20_000 {
            simulation.advance(0.6 + 1e-5 * f64::from(row)).unwrap();
            let force = read(&mut simulation, &outputs)["right.contact[1].creepForceX"];
            largest = last.map_or(largest, |last: f64| largest.max((force - last).abs()));
            last = Some(force);
        }
        println!("{formulation}, nodes every {spacing}: largest change of Fx within 10 us {largest:.2} N");
        largest
    };
    let smooth = jump("ECF-A", "1 mm");
    let (coarse, fine) = (jump("ECF-N", "1 mm"), jump("ECF-N", "0.1 mm"));
    assert!(coarse < 10.0 * smooth && fine < 2.0 * smooth, "{coarse} {fine} {smooth}");
}

#[test]
fn equiv_block_solution_of_the_augmented_system_is_the_dense_one() {
    // Eq. 13 written out for one wheelset: 5 coordinates (x is imposed), 8 surface parameters, 10 multipliers.
    use nalgebra::{DMatrix, DVector, Matrix6, Vector4};
    use wheelrail::contact::search::algebraic::Pair;
    use wheelrail::formulation::contact_index;
    use wheelrail::geometry::Side;
    let scene = scene(&["contact.formulation=ACCF", "vehicle.initial.y=4 mm", "vehicle.initial.yaw=3 mrad"]);
    let mut simulation = start(&scene);
    for time in [0.02, 0.55, 0.63, 0.71] {
        simulation.advance(time).unwrap();
        let snapshot = simulation.snapshot().unwrap().clone();
        let model = simulation.model();
        let (system, wheelset) = (&snapshot.workspace.system, &model.wheelsets[0]);
        let (motion, body) = (&system.motions[0], &model.system.bodies[0]);
        let mass: Matrix6<f64> = body.mobility(motion).try_inverse().unwrap();
        // The wrenches hold everything but the normal forces.
        let free = nalgebra::Vector6::from(body.accelerations(motion, &system.wrenches[0]));
        let force = mass * free;
        let mut matrix = DMatrix::zeros(23, 23);
        let mut right = DVector::zeros(23);
        matrix.view_mut((0, 0), (5, 5)).copy_from(&mass.fixed_view::<5, 5>(1, 1));
        right.rows_mut(0, 5).copy_from(&force.fixed_rows::<5>(1));
        let mut normal_lengths = Vec::new();
        for (index, side) in Side::BOTH.into_iter().enumerate() {
            let own = &snapshot.y[model.contact_states(contact_index(0, side))];
            let (wheel, rail) = (wheelset.wheel(side), model.track.rail(side));
            let pair = Pair { wheel, rail, centre: &motion.position, axes: &motion.frame.axes, distance: motion.position.x };
            let contact = pair.point_contact(&Vector4::from_column_slice(&own[..4]));
            let bias = pair.bias(&contact, &Vector4::from_column_slice(&own[4..]), &motion.carrier());
            assert!(contact.residual.norm() < 1e-12, "constraints hold: {}", contact.residual);
            for i in 0..5 {
                let row = 13 + 5 * index + i;
                let coefficients = motion.coefficients(&contact.by_velocity[i], &contact.by_rotation[i]);
                for j in 0..5 {
                    matrix[(row, j)] = coefficients[j + 1];
                    matrix[(j, row)] = coefficients[j + 1];
                }
                for j in 0..4 {
                    matrix[(row, 5 + 4 * index + j)] = contact.by_parameters[(i, j)];
                    matrix[(5 + 4 * index + j, row)] = contact.by_parameters[(i, j)];
                }
                right[row] = -bias[i];
            }
            normal_lengths.push(contact.normal_length());
        }
        let solution = matrix.full_piv_lu().solve(&right).unwrap();
        for j in 0..5 {
            let ours = snapshot.dy[6 + 1 + j];
            assert!((solution[j] - ours).abs() < 1e-8 * (1.0 + ours.abs()), "t = {time}, coordinate {j}: {} {ours}", solution[j]);
        }
        for (index, side) in Side::BOTH.into_iter().enumerate() {
            let range = model.contact_states(contact_index(0, side));
            for j in 0..4 {
                let (theirs, ours) = (solution[5 + 4 * index + j], snapshot.dy[range.start + 4 + j]);
                assert!((theirs - ours).abs() < 1e-8 * (1.0 + ours.abs()), "t = {time}, {side:?} parameter {j}: {theirs} {ours}");
            }
            let normal_force = -solution[13 + 5 * index + 2] * normal_lengths[index];
            let ours = snapshot.workspace.contacts[index].normal_force;
            assert!((normal_force / ours - 1.0).abs() < 1e-9, "t = {time}: {normal_force} {ours}");
            // Eq. 14: only the multiplier along the normal is left.
            for i in [0, 1, 3, 4] {
                assert!(solution[13 + 5 * index + i].abs() < 1e-5, "multiplier {i}: {}", solution[13 + 5 * index + i]);
            }
        }
    }
}
