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
