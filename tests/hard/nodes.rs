//! ECF-N's normal force over the lateral position, pose by pose: what is left of jumps from node to node and from hump to hump.

use wheelrail::formulation::Evaluation;
use wheelrail::scene::load;
use wheelrail::sim::Simulation;

/// Normal forces of both places of the left wheel every micrometre to the left, up to a force of 120 kN in all.
fn forces(spacing: &str) -> Vec<[f64; 2]> {
    let changes = ["contact.formulation=ECF-N".to_string(), format!("contact.node_spacing={spacing}")];
    let scene = load::open("wheelset_s1002", &changes).unwrap();
    let mut simulation = Simulation::new(&scene, 0.0).unwrap();
    let snapshot = simulation.snapshot().unwrap();
    let (memory, inputs, start) = (snapshot.memory().clone(), snapshot.inputs().to_vec(), snapshot.y.clone());
    let model = simulation.model();
    let mut workspace = model.workspace();
    let mut at = |shift: f64| {
        let (mut y, mut memory, mut dy) = (start.clone(), memory.clone(), vec![0.0; start.len()]);
        y[1] += shift;
        let at = Evaluation { t: 0.0, inputs: &inputs, y: &y, memory: &mut memory };
        model.derivative(&mut workspace, at, &mut dy).ok()?;
        Some([&workspace.contacts[0], &workspace.further_contacts[0]].map(|report| report.normal_force))
    };
    (0..).map_while(|i| at(1e-6 * f64::from(i) - 4e-3)).take_while(|found| found.iter().sum::<f64>() < 1.2e5).collect()
}

/// Stiffness came from profiles shifted against each other by up to a spacing: the force jumped by 10 % (11 kN of 107 kN) from node to
/// node at 0.1 mm. Where two places 10 mm apart are equally deep the force jumped by 2 % at any spacing, as one of them had it all.
#[test]
fn hard_normal_force_of_nodes_is_continuous() {
    for (spacing, allowed) in [("0.4 mm", 2e-2), ("0.1 mm", 1e-3), ("0.025 mm", 3e-4)] {
        let found = forces(spacing);
        let all = |i: usize| found[i].iter().sum::<f64>();
        let (mut jump, mut shared) = (0.0f64, 0);
        for i in (0..found.len() - 3).filter(|i| all(*i) > 2e4) {
            let [a, b, c, d] = [0, 1, 2, 3].map(|ahead| all(i + ahead));
            // A step against what the slopes on both sides say.
            jump = jump.max(((c - b) - 0.5 * ((b - a) + (d - c))).abs() / b);
            shared += usize::from(found[i].iter().all(|force| *force > 0.1 * all(i)));
        }
        println!("nodes every {spacing}: {} poses, {shared} with two humps, jumps of {jump:.1e} N/N", found.len());
        assert!(jump < allowed && shared > 50, "{spacing}: {jump} {shared}");
        assert!(found.len() > 4000 && all(found.len() - 1) > 1.1e5);
    }
}

/// Forces of the left wheel [N] while it comes to its flange, and how many places carry, at poses every 20 um.
fn toward_the_flange(formulation: &str, patch: &str) -> Vec<([f64; 2], usize)> {
    let changes = [
        format!("contact.formulation={formulation}"),
        format!("contact.patch={patch}"),
        "track.rail={kind=\"60e2\"}".to_string(),
        "vehicle.wheelset.profile.radius=0.5".to_string(),
    ];
    let scene = load::open("wheelset_s1002", &changes).unwrap();
    let mut simulation = Simulation::new(&scene, 0.0).unwrap();
    let snapshot = simulation.snapshot().unwrap();
    let (mut memory, inputs, start) = (snapshot.memory().clone(), snapshot.inputs().to_vec(), snapshot.y.clone());
    let model = simulation.model();
    let mut workspace = model.workspace();
    let mut found = Vec::new();
    let (mut z, mut roll) = (start[2], start[4]);
    for i in 0..360 {
        let (mut y, mut dy) = (start.clone(), vec![0.0; start.len()]);
        y[1] += 2e-5 * f64::from(i);
        // Both wheels carry about 80 kN on their treads.
        for _ in 0..6 {
            (y[2], y[4]) = (z, roll);
            let at = Evaluation { t: 0.0, inputs: &inputs, y: &y, memory: &mut memory };
            if model.derivative(&mut workspace, at, &mut dy).is_err() {
                return found;
            }
            let [left, right] = [0, 1].map(|contact| (8e4 - workspace.wheel_force(contact, 0).z) / 2e9);
            (z, roll) = (z - 0.5 * (left + right), roll - 0.5 * (left - right) / 0.75);
        }
        let force = workspace.wheel_force(0, 0);
        found.push(([force.y, force.z], workspace.reports(0).filter(|report| report.normal_force > 100.0).count()));
    }
    found
}

/// S1002 on 60E2 stands on two places of its tread when its flange comes: with two contacts at most ECF-N dropped one of them, and Y fell by 4 kN. Its forces are
/// those of ECF-A everywhere.
#[test]
fn hard_nodes_find_a_third_place() {
    for patch in ["ellipse", "strips"] {
        let (nodes, exact) = (toward_the_flange("ECF-N", patch), toward_the_flange("ECF-A", patch));
        let worst = nodes
            .iter()
            .zip(&exact)
            .enumerate()
            .map(|(i, (a, b))| ([0, 1].map(|k| (a.0[k] - b.0[k]).abs()).into_iter().fold(0.0, f64::max), i));
        let (worst, place) = worst.max_by(|a, b| a.0.total_cmp(&b.0)).unwrap();
        let three = exact.iter().filter(|found| found.1 > 2).count();
        println!(
            "{patch}: {} poses, {three} with three places; largest difference {worst:.1} N at {place}: {:?} {:?}",
            nodes.len(),
            nodes[place],
            exact[place]
        );
        assert!(nodes.len() == exact.len() && nodes.len() > 300 && three > 0 && worst < 300.0, "{patch}: {worst}");
    }
}
