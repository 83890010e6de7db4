//! Which bodies' accelerations change with which bodies' coordinates, and which columns of differences can be taken at once.
//!
//! Joints tie bodies to clusters: whatever moves or loads one of them moves all. A force element couples the clusters of its bodies. The
//! accelerations of a cluster therefore change with its own coordinates and those of its neighbours, and two clusters can be
//! moved at once when they neither touch nor have a neighbour in common. Clusters get colours so (greedily, in order): a train needs no
//! more of them than one of its coaches in the middle.

use crate::mbs::system::System;

/// The graph of a system's bodies.
pub(super) struct Couplings {
    /// Bodies of each cluster.
    pub clusters: Vec<Vec<usize>>,
    /// Per cluster: itself and its neighbours.
    pub reach: Vec<Vec<usize>>,
    /// Clusters of each colour.
    pub colours: Vec<Vec<usize>>,
}

impl Couplings {
    pub fn new(system: &System) -> Self {
        let count = system.bodies.len();
        let mut cluster_of: Vec<usize> = (0..count).collect();
        for joint in &system.joints {
            let Some(second) = joint.bodies.second else { continue };
            let (a, b) = (cluster_of[joint.bodies.first], cluster_of[second]);
            for cluster in &mut cluster_of {
                if *cluster == a.max(b) {
                    *cluster = a.min(b);
                }
            }
        }
        let mut names = cluster_of.clone();
        names.sort_unstable();
        names.dedup();
        let cluster_of: Vec<usize> = cluster_of.iter().map(|name| names.partition_point(|other| other < name)).collect();
        let mut clusters = vec![Vec::new(); names.len()];
        for (body, cluster) in cluster_of.iter().enumerate() {
            clusters[*cluster].push(body);
        }
        let mut reach: Vec<Vec<usize>> = (0..clusters.len()).map(|cluster| vec![cluster]).collect();
        for force in &system.forces {
            let bodies = force.reach();
            for (first, second) in [(0, 1), (0, 2), (1, 2)] {
                if let (Some(first), Some(second)) = (bodies[first], bodies[second]) {
                    let (first, second) = (cluster_of[first], cluster_of[second]);
                    reach[first].push(second);
                    reach[second].push(first);
                }
            }
        }
        for reach in &mut reach {
            reach.sort_unstable();
            reach.dedup();
        }
        let colours = colours(&reach);
        Couplings { clusters, reach, colours }
    }
}

fn colours(reach: &[Vec<usize>]) -> Vec<Vec<usize>> {
    let mut colour_of: Vec<Option<usize>> = vec![None; reach.len()];
    let mut colours: Vec<Vec<usize>> = Vec::new();
    for cluster in 0..reach.len() {
        let near = reach[cluster].iter().flat_map(|neighbour| &reach[*neighbour]);
        let taken: Vec<usize> = near.filter_map(|other| colour_of[*other]).collect();
        let free = (0..colours.len()).find(|colour| !taken.contains(colour)).unwrap_or(colours.len());
        if free == colours.len() {
            colours.push(Vec::new());
        }
        colours[free].push(cluster);
        colour_of[cluster] = Some(free);
    }
    colours
}

#[cfg(test)]
mod tests {
    use super::*;

    /// No two clusters of a colour reach the same one; a chain needs three colours, however long it is.
    #[test]
    fn prop_columns_of_a_colour_share_no_row() {
        for length in [3, 10, 200] {
            let chain: Vec<Vec<usize>> = (0..length).map(|i: usize| (i.saturating_sub(1)..(i + 2).min(length)).collect()).collect();
            let found = colours(&chain);
            assert_eq!(found.len(), 3);
            assert_eq!(found.iter().map(Vec::len).sum::<usize>(), length);
            for colour in &found {
                let mut rows: Vec<usize> = colour.iter().flat_map(|cluster| chain[*cluster].clone()).collect();
                let count = rows.len();
                rows.sort_unstable();
                rows.dedup();
                assert_eq!(rows.len(), count);
            }
        }
    }

    /// Differences for a train of three coaches take few more evaluations than those for one coach, and all have a colour.
    #[test]
    fn prop_a_train_needs_few_more_colours_than_a_coach() {
        let found = |name: &str| {
            let scene = crate::scene::load::open(name, &[]).unwrap_or_else(|error| panic!("{error}"));
            let system = crate::scene::assemble::model(&scene).unwrap().system;
            let couplings = Couplings::new(&system);
            assert_eq!(couplings.colours.iter().flatten().count(), system.bodies.len());
            couplings.colours.len()
        };
        let (coach, train) = (found("vehicle_manchester_1"), found("train"));
        println!("colours: coach {coach}, train {train}");
        assert!(coach == 5 && train <= 7, "{coach} {train}");
    }
}
