//! How the derivative changes with time alone: by inputs that have a slope.
//!
//! A linearly implicit step that leaves df/dt out keeps its order, but not where a fast state follows what an input asks for: a brake's deflection lags
//! behind a ramp of its bound by a way that the step's length decides, and so does the momentum that it takes from the vehicle (a wagon braked within 1.5 s
//! went 7 mm too far at a tolerance of 1e-5, 3 mm at 1e-6). With
//!
//! ```text
//! df/dt = (f(inputs at t + e) - f(inputs at t)) / e,   e = 1e-6 s, of bodies and force elements alone
//! ```
//!
//! beside what a moving frame asks for ([`super::moving_frame`]), ramps are followed as states are. What contacts meet of inputs (friction, rails that move) is not in it.

use super::inputs::WHEELSET_INPUTS;
use super::{EvaluationError, Model, Workspace};

/// e, s.
const SPAN: f64 = 1e-6;

impl Model {
    /// Derivative of the bodies' and force elements' states under `inputs` at `time` [s], without contact, where motions are known; the rest of `dy` is
    /// left as it is.
    ///
    /// # Errors
    /// [`EvaluationError`] where joints leave no accelerations.
    pub fn loaded_alone(
        &self,
        workspace: &mut Workspace,
        inputs: &[f64],
        (time, y): (f64, &[f64]),
        dy: &mut [f64],
    ) -> Result<(), EvaluationError> {
        self.take_inputs(&mut workspace.system, time, inputs);
        self.system.load_bodies(y, &mut workspace.system);
        for (wheelset, own) in self.wheelsets.iter().zip(inputs.as_chunks::<WHEELSET_INPUTS>().0) {
            let applied = self.input_wrench(&workspace.system, wheelset.body, own);
            workspace.system.wrenches[wheelset.body] += applied;
        }
        self.accelerate(workspace, time, y, dy)
    }

    /// Adds df/dt at the state that was linearised last; `at` writes the inputs of a time into `inputs`, which ends as those of `time`. Leaves the bodies'
    /// loads without contact.
    pub fn find_drift(&self, workspace: &mut Workspace, (time, y): (f64, &[f64]), inputs: &mut [f64], at: impl Fn(f64, &mut [f64])) {
        let [mut now, mut later] = std::mem::take(&mut workspace.frame.drift);
        let mut found = true;
        for (dy, ahead) in [(&mut later, SPAN), (&mut now, 0.0)] {
            at(time + ahead, inputs);
            // What bodies follow at a time of their own (imposed speeds) is in J's frame.
            found &= self.loaded_alone(workspace, inputs, (time, y), dy).is_ok();
        }
        if found {
            let change = workspace.frame.change.iter_mut();
            change.zip(later.iter().zip(&now)).for_each(|(change, (later, now))| *change += (later - now) / SPAN);
        }
        workspace.frame.drift = [now, later];
    }
}
