//! Takes what `[effects]` leaves out off the data that was read.

use super::effects::{ABRUPT, Effects, QUANTITIES, Switch};
use super::spec::{ContactSpec, PatchSpec, TrackSpec};
use super::vehicle::VehicleSpec;
use crate::contact::creep;
use crate::contact::patch::PatchLaw;
use crate::geometry::profile::Flangeless;
use crate::geometry::track::centre_line::{Alignment, CentreLine, Node};
use crate::geometry::track::components;
use crate::geometry::track::irregularity::Quantity;
use crate::settings::{Section, SettingsError};
use std::sync::Arc;

impl Effects {
    /// Takes what is left out off a contact.
    ///
    /// # Errors
    /// [`SettingsError`] where that can't be done.
    pub(super) fn leave_out_of_contact(&self, contact: &mut ContactSpec, section: &Section) -> Result<(), SettingsError> {
        if self.is_off(Switch::Spin) {
            if contact.patch.why.is_some() {
                contact.patch = PatchSpec { law: PatchLaw::Ellipse, why: Some("effects.spin = \"off\" is known of ellipses alone") };
            } else if contact.patch.law.forms() {
                let law = contact.patch.law.name();
                let problem = format!(
                    "found \"off\", but each strip of contact.patch = \"{law}\" has its own slip, of which spin is a part; expected contact.patch = \"ellipse\""
                );
                return Err(section.error("spin", problem));
            }
            let build = contact.creep.clone();
            contact.creep = Arc::new(move |material| creep::without_spin(build(material)));
        }
        if self.is_off(Switch::Transient) {
            contact.transient = None;
        }
        let (along, across) = (!self.is_off(Switch::FrictionAlong), !self.is_off(Switch::FrictionAcross));
        contact.friction_map = contact.friction_map.take().and_then(|map| map.keeping(along, across));
        Ok(())
    }

    /// Takes what is left out off a vehicle.
    pub(super) fn leave_out_of_vehicle(&self, vehicle: &mut VehicleSpec) {
        vehicle.forces.retain(|force| !self.leaves_out(force.0.name()));
        if self.is_off(Switch::Gyroscopic) {
            vehicle.wheelsets.iter_mut().for_each(|wheelset| wheelset.spec.gyroscopic = false);
        }
        if self.is_off(Switch::OutOfRound) {
            vehicle.wheelsets.iter_mut().for_each(|wheelset| wheelset.spec.out_of_round = [None, None]);
        }
        if self.is_off(Switch::Flange) {
            for choice in vehicle.wheelsets.iter_mut().flat_map(|wheelset| &mut wheelset.spec.profiles) {
                if let Some(flangeless) = Flangeless::new(choice.profile.clone()) {
                    choice.profile = Arc::new(flangeless);
                }
            }
        }
    }

    /// Takes what is left out off a track.
    pub(super) fn leave_out_of_track(&self, track: &mut TrackSpec) {
        let left_out: Vec<Quantity> = QUANTITIES.into_iter().filter(|one| self.is_off(one.0)).map(|one| one.1).collect();
        if !left_out.is_empty() {
            track.deviations = components::without(&track.deviations, &left_out);
        }
        if self.is_off(Switch::TrackFlexibility) {
            track.flexibility = None;
        }
        if self.is_off(Switch::Grade) {
            track.grade = 0.0;
        }
        let Some(alignment) = &mut track.alignment else { return };
        let before = alignment.clone();
        for node in &mut alignment.nodes {
            let kept = |switch: Switch, value: f64| if self.is_off(switch) { 0.0 } else { value };
            node.curvature = kept(Switch::Curvature, node.curvature);
            node.superelevation = kept(Switch::Cant, node.superelevation);
            node.grade = kept(Switch::Grade, node.grade);
        }
        if self.abrupt {
            alignment.nodes = abrupt(&alignment.nodes);
        }
        if *alignment != before {
            track.line = line(alignment);
        }
    }
}

/// The centre line that an alignment makes.
fn line(alignment: &Alignment) -> Option<Arc<CentreLine>> {
    CentreLine::new(alignment, nalgebra::Vector3::zeros(), 0.0).map(Arc::new)
}

/// Nodes whose curvature changes in the middle of each transition, so that the line turns by the same angle; cant and grade go on as they were.
fn abrupt(nodes: &[Node]) -> Vec<Node> {
    let mut all: Vec<Node> = Vec::with_capacity(3 * nodes.len());
    for (index, node) in nodes.iter().enumerate() {
        all.push(*node);
        let Some(next) = nodes.get(index + 1).filter(|next| next.curvature != node.curvature) else { continue };
        let length = next.distance - node.distance;
        if length <= ABRUPT {
            continue;
        }
        let at = |way: f64, curvature: f64| {
            let share = way / length;
            let between = |a: f64, b: f64| a + share * (b - a);
            Node {
                distance: node.distance + way,
                curvature,
                superelevation: between(node.superelevation, next.superelevation),
                grade: between(node.grade, next.grade),
            }
        };
        all.push(at(0.5 * (length - ABRUPT), node.curvature));
        all.push(at(0.5 * (length + ABRUPT), next.curvature));
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_an_abrupt_transition_turns_by_the_same_angle() {
        let node = |distance: f64, curvature: f64, superelevation: f64| Node { distance, curvature, superelevation, grade: 0.0 };
        let nodes = [node(0.0, 0.0, 0.0), node(30.0, 0.0, 0.0), node(90.0, 2e-3, 0.1), node(150.0, 2e-3, 0.1), node(150.5, 1e-3, 0.1)];
        let turn = |nodes: &[Node]| -> f64 {
            nodes.windows(2).map(|pair| 0.5 * (pair[0].curvature + pair[1].curvature) * (pair[1].distance - pair[0].distance)).sum()
        };
        let changed = abrupt(&nodes);
        assert_eq!(changed.len(), 7, "a change over less than a metre is abrupt already");
        assert!((turn(&changed) - turn(&nodes)).abs() < 1e-15 && turn(&nodes) > 0.17);
        assert_eq!((changed[2].distance, changed[2].curvature, changed[3].distance, changed[3].curvature), (59.5, 0.0, 60.5, 2e-3));
        assert!((changed[2].superelevation - 0.1 * 29.5 / 60.0).abs() < 1e-15);
    }
}
