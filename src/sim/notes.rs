//! What a user should know about a run, and the memory of wheels' loads that tells it.

use super::Simulation;
use crate::formulation::wheel_loads::{NotedLoads, WheelLoads};
use crate::solve::SettingKind;

impl Simulation {
    /// When a flutter began that notes tell of, s.
    pub fn first_flutter(&self) -> Option<f64> {
        self.model.first_flutter(&self.state.flutter, &self.loads, self.integrator.setting().kind == SettingKind::Step)
    }

    /// What a user should know about the run so far: wheels that unload, loads no real track would meet, wheelsets that flutter, loads
    /// that swing fast of themselves, works that lag.
    pub fn notes(&self) -> Vec<String> {
        let mut notes = self.model.load_notes(&self.loads);
        if self.rubbed_in < 1.0 {
            notes.push(format!(
                "dry friction starts in this curve with {:.0} % of what the way through a transition would leave it: no balance was found with more; start before the curve where that matters",
                100.0 * self.rubbed_in
            ));
        }
        let fixed = self.integrator.setting().kind == SettingKind::Step;
        let flutter = self.model.flutter_note(&self.state.flutter, &self.loads, fixed);
        notes.extend(flutter.or_else(|| self.model.swing_note(&self.loads)));
        notes.extend(self.integrator.lags_in_integrals().then(|| self.model.books_note()).flatten());
        notes
    }

    /// What was noted of the wheels' loads; no part of the state, which goes on the same without.
    pub fn loads(&self) -> &WheelLoads {
        &self.loads
    }

    /// Puts back what had been noted when a state was saved.
    pub fn put_loads(&mut self, loads: &WheelLoads) {
        self.loads.copy_from(loads);
    }

    /// The same of what was serialised; `false`, and nothing is changed, where it is of another model.
    pub fn go_on_noting(&mut self, noted: NotedLoads) -> bool {
        self.loads.go_on(noted)
    }
}
