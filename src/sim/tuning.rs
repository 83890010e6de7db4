//! Numbers of a model that change during a run: friction, the contact's damping, constants of force elements, the integrator's setting.
//!
//! A tuned model is the model that the run began with and the numbers in force, whatever stood in between: elements are made from those of the
//! start each time, so that a state that is put back meets the same model to the bit. What the start has found stays: preloads from balance (a
//! spring that grows stiffer is not hung up anew) and the static wheel loads by which errors are measured.

use super::Simulation;
use crate::formulation::Model;
use crate::mbs::force::ForceElement;
use crate::scene::spec::Scene;
use crate::solve::Integrator;
use std::sync::Arc;

/// The numbers in force.
pub struct Tuning<'a> {
    /// With the friction and damping of contact, and as many force elements as that of the start.
    pub scene: &'a Scene,
    /// Of the method that the run began with.
    pub integrator: &'a Arc<dyn Integrator>,
    /// Constants that are not what they were at the start: the element's place among the vehicle's, the constant's number, its value. Always
    /// in the same order.
    pub constants: &'a [(usize, u32, f64)],
}

/// Elements of the model that were tuned, by place in it, as they were at the start.
pub(super) type Untuned = Vec<(usize, Box<dyn ForceElement>)>;

/// Constants of elements as in [`Tuning`], and the tolerance.
pub(super) type Tuned = (Vec<(usize, u32, f64)>, Option<f64>);

/// Finds the modes of the bodies as the scene has them.
pub(super) fn as_begun(model: &mut Model, integrator: &Arc<dyn Integrator>) -> Tuned {
    (Vec::new(), find_modes(model, integrator))
}

/// For the integrator's tolerance, which is given back. Fixed steps have none, and nothing that could hold modes.
fn find_modes(model: &mut Model, integrator: &Arc<dyn Integrator>) -> Option<f64> {
    let tolerance = integrator.setting().tolerance();
    tolerance.inspect(|tolerance| model.find_body_modes(*tolerance))
}

impl Simulation {
    /// Puts other numbers in force from the present time on. The integration restarts here, as after a jump of an input.
    pub fn tune(&mut self, tuning: &Tuning) {
        self.restart();
        self.adopt(tuning);
    }

    /// The same for a state that has yet to be put back ([`Simulation::restore`]) and was made under these numbers: nothing restarts.
    pub fn adopt(&mut self, Tuning { scene, integrator, constants }: &Tuning) {
        let contact = &scene.contact;
        self.model.laws.friction = contact.friction;
        self.model.laws.damping = (contact.damping_law.build)(contact.damping);
        self.integrator = Arc::clone(integrator);
        let forces = &mut self.model.system.forces;
        for (place, element) in self.untuned.drain(..) {
            forces[place] = element;
        }
        // The vehicle's elements stand behind weights and loads.
        let first = forces.len() - scene.vehicle.forces.len();
        for (place, number, value) in *constants {
            let place = first + place;
            if self.untuned.iter().all(|untuned| untuned.0 != place) {
                self.untuned.push((place, forces[place].clone_box()));
            }
            forces[place].set_constant(*number, *value);
        }
        self.model.weigh_forces();
        let tuned = (constants.to_vec(), integrator.setting().tolerance());
        if self.tuned != tuned {
            find_modes(&mut self.model, integrator);
            self.tuned = tuned;
        }
        self.workspace.forget();
        self.known = None;
    }
}
