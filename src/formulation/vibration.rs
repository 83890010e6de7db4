//! The fastest vibration of bodies on their force elements, which explicit steps must follow.
//!
//! Explicit Runge-Kutta methods do not damp an undamped swing, they blow it up: of order 5 from w h = 0.95 on. A light body on a stiff bushing (60 kg, 250 Hz,
//! 0.5 % of critical damping) so began to ring out of nothing by 0.1 mm, which is the tolerance's, and 260 m/s2, which is nobody's. What contacts do is seen by the
//! error of their forces; of the elements the greatest eigenvalue is asked for,
//!
//! ```text
//! x'' = M^-1 (dW/dx x + dW/dx' x'),   J x = lambda x,   J^2 x = 2 Re(lambda) J x - |lambda|^2 x   in the plane of the fastest pair
//! ```
//!
//! by iterations with J^2, W the wrenches of all force elements, without contacts, joints and elements' own states (a damper in series with a spring counts as its
//! spring): each of them makes bodies slower. Steps are bounded by the method's own limit on that ray (`solve::stability`).

use super::{Model, Workspace};

/// How often it is asked for, s: elements stiffen as they are pressed, and a swing grows by less than a hundredth in a step.
const LOOKED: f64 = 0.1;
/// Products with J^2.
const ITERATIONS: usize = 16;

/// |lambda| [1/s] and damping, -Re(lambda) / |lambda|, of the fastest vibration, and when that was found [s].
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Vibration {
    pub rate: f64,
    pub damping: f64,
    looked: Option<f64>,
}

impl Model {
    /// Finds it at the state `y` at `t` [s] that was evaluated last, where it is time to. Leaves the Jacobian of force elements alone.
    pub fn note_vibration(&self, workspace: &mut Workspace, t: f64, y: &[f64], vibration: &mut Vibration) {
        let due = vibration.looked.is_none_or(|looked| !(looked..looked + LOOKED).contains(&t));
        let Some(mut tangent) = workspace.tangent.take_if(|_| due) else { return };
        tangent.clear();
        tangent.add_forces(&self.system, &workspace.system, y);
        tangent.finish(&self.system, &workspace.system);
        let frame = &mut workspace.frame;
        let [x, once] = &mut frame.drift;
        let [rate, damping] = tangent.fastest([x, once, &mut frame.change], ITERATIONS);
        *vibration = Vibration { rate, damping, looked: Some(t) };
        workspace.tangent = Some(tangent);
    }
}
