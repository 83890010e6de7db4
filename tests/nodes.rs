//! ECF-N's normal force over the lateral position, pose by pose: what is left of its jumps from node to node.

use wheelrail::formulation::Evaluation;
use wheelrail::scene::load;
use wheelrail::sim::Simulation;

/// N of the left wheel and the wheel coordinate of its contact, every micrometre to the left, up to a force of 120 kN.
fn forces(spacing: &str) -> Vec<(f64, f64)> {
    let changes = ["contact.formulation=ECF-N".to_string(), format!("contact.node_spacing={spacing}")];
    let scene = load::open("wheelset_s1002", &changes).unwrap();
    let mut simulation = Simulation::new(&scene, 0.0).unwrap();
    let snapshot = simulation.snapshot().unwrap();
    let (memory, inputs, start) = (snapshot.memory().to_vec(), snapshot.inputs().to_vec(), snapshot.y.clone());
    let model = simulation.model();
    let mut workspace = model.workspace();
    let mut at = |shift: f64| {
        let (mut y, mut memory, mut dy) = (start.clone(), memory.clone(), vec![0.0; start.len()]);
        y[1] += shift;
        let at = Evaluation { t: 0.0, inputs: &inputs, y: &y, memory: &mut memory };
        model.derivative(&mut workspace, at, &mut dy).ok()?;
        let [first, second] = [&workspace.contacts[0], &workspace.further_contacts[0]];
        assert_eq!(second.normal_force, 0.0, "one batch");
        Some((first.normal_force, first.parameters.wheel))
    };
    (0..).map_while(|i| at(1e-6 * f64::from(i) - 4e-3)).take_while(|found| found.0 < 1.2e5).collect()
}

/// Stiffness came from profiles shifted against each other by up to a spacing: the force jumped by 10 % (11 kN of 107 kN) from node to
/// node at 0.1 mm. What is left is the paper's rule of one contact for each batch: the contact jumps to a place 10 mm away that has
/// become as deep and is softer there, at any spacing.
#[test]
fn hard_normal_force_of_nodes_is_continuous_but_where_the_place_changes() {
    for (spacing, allowed) in [("0.4 mm", 2e-2), ("0.1 mm", 1e-3), ("0.025 mm", 3e-4)] {
        let found = forces(spacing);
        let (mut near, mut far) = (0.0f64, 0.0f64);
        for four in found.windows(4).filter(|four| four[0].0 > 2e4) {
            let [a, b, c, d] = [0, 1, 2, 3].map(|i| four[i].0);
            let jumps = [0, 1, 2].map(|i| (four[i + 1].1 - four[i].1).abs() > 1e-3);
            if jumps[1] {
                far = far.max((c - b).abs() / b);
            } else if jumps == [false; 3] {
                // A step against what the slopes on both sides say.
                near = near.max(((c - b) - 0.5 * ((b - a) + (d - c))).abs() / b);
            }
        }
        println!("nodes every {spacing}: {} poses, jumps of {near:.1e} N/N from node to node, {far:.1e} from place to place", found.len());
        assert!(near < allowed && far < 0.03, "{spacing}: {near} {far}");
        assert!(found.len() > 4000 && found.last().unwrap().0 > 1.1e5);
    }
}
