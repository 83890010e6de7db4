//! What a master's calls cost: steps alone, with outputs read, with inputs set, at several communication steps.
//!
//! CPU time of one thread through the instance that the C functions drive; a call through C adds some 20 ns. Nothing here is asserted.

use cpu_time::ThreadTime;
use wheelrail::fmi::instance::{Instance, StepOutcome};
use wheelrail::fmi::package;
use wheelrail::fmi::variables::{Role, VariableTable};
use wheelrail::scene::load;
use wheelrail::sim::outputs::{Needs, Output};

/// Scene, its changes and what is simulated, s.
const SCENES: [(&str, &[&str], f64); 3] = [
    ("suspended_wheelset", &["solver.integrator=rosenbrock"], 2.0),
    ("vehicle_manchester_1", &[], 2.0),
    ("vehicle_curve", &["vehicle.initial.distance=15"], 2.0),
];

/// What a master does at each communication point.
#[derive(Clone)]
enum Calls {
    Nothing,
    /// Reads these, in one call.
    Read(Vec<u32>),
    /// Reads these, each in a call of its own.
    ReadEach(Vec<u32>),
    /// Sets an input to what a sine says.
    Set(u32),
    /// Sets value and derivatives of a line that goes on.
    SetRamp(u32),
}

struct Case {
    table: VariableTable,
    folder: tempfile::TempDir,
    guid: String,
    stop: f64,
}

impl Case {
    fn new(name: &str, changes: &[&str], stop: f64) -> Case {
        let changes: Vec<String> = changes.iter().map(|change| (*change).to_string()).collect();
        let scene = load::open(name, &changes).unwrap_or_else(|error| panic!("{error}"));
        let packed = package::pack_scene(&scene).unwrap_or_else(|error| panic!("{error}"));
        let folder = tempfile::tempdir().unwrap_or_else(|error| panic!("{error}"));
        for (file, content) in &packed.resources {
            std::fs::write(folder.path().join(file), content).unwrap_or_else(|error| panic!("{error}"));
        }
        let table = VariableTable::new(&scene).unwrap_or_else(|error| panic!("{error}"));
        Case { table, folder, guid: packed.description.guid, stop }
    }

    fn started(&self) -> Instance {
        let mut instance = Instance::new(self.folder.path(), &self.guid).unwrap_or_else(|error| panic!("{error}"));
        instance.setup_experiment(None, 0.0, None).unwrap_or_else(|error| panic!("{error}"));
        instance.enter_initialization().unwrap_or_else(|error| panic!("{error}"));
        instance.exit_initialization().unwrap_or_else(|error| panic!("{error}"));
        instance
    }

    fn references(&self, wanted: impl Fn(&Output) -> bool) -> Vec<u32> {
        self.table.outputs.iter().filter(|output| wanted(output)).map(|output| output.reference).collect()
    }

    fn input(&self, name: &str) -> Option<u32> {
        let found = self.table.variables.iter().find(|variable| matches!(variable.role, Role::Input(_)) && variable.name.ends_with(name));
        found.map(|variable| variable.reference)
    }

    /// CPU seconds per simulated second, best of several.
    fn cost(&self, step: f64, calls: &Calls) -> f64 {
        let count = (self.stop / step).round() as u32;
        let mut best = f64::INFINITY;
        for _ in 0..3 {
            let mut instance = self.started();
            let mut values = vec![0.0; self.table.outputs.len()];
            let clock = ThreadTime::now();
            for i in 0..count {
                let time = instance.time();
                let done: Result<(), _> = match calls {
                    Calls::Set(input) => instance.set_real(&[*input], &[100.0 * (20.0 * time).sin()]),
                    Calls::SetRamp(input) => instance
                        .set_real(&[*input], &[100.0 * time])
                        .and_then(|()| instance.set_input_derivatives(&[*input], &[1], &[100.0])),
                    _ => Ok(()),
                };
                done.unwrap_or_else(|error| panic!("{error}"));
                let outcome = instance.do_step(step * f64::from(i), step).unwrap_or_else(|error| panic!("{error}"));
                assert!(!matches!(outcome, StepOutcome::Discarded(..)), "{outcome:?}");
                match calls {
                    Calls::Read(references) => {
                        instance.get_real(references, &mut values[..references.len()]).unwrap_or_else(|error| panic!("{error}"));
                    }
                    Calls::ReadEach(references) => {
                        for (reference, value) in references.iter().zip(&mut values) {
                            let value = std::slice::from_mut(value);
                            instance.get_real(&[*reference], value).unwrap_or_else(|error| panic!("{error}"));
                        }
                    }
                    _ => {}
                }
            }
            best = best.min(clock.elapsed().as_secs_f64() / self.stop);
        }
        best
    }
}

/// Time of setting a constant of a force element during a run, s.
fn tuning(case: &Case) -> Option<f64> {
    let own = |name: &str| !name.starts_with("contact.") && !name.starts_with("solver.");
    let found = case.table.variables.iter().find(|variable| variable.variability == "tunable" && own(&variable.name))?;
    let (reference, start) = (found.reference, found.start?);
    let mut instance = case.started();
    const CALLS: u32 = 200;
    let mut best = f64::INFINITY;
    for _ in 0..5 {
        let clock = ThreadTime::now();
        for i in 0..CALLS {
            let value = start * (1.0 + 1e-3 * f64::from(1 + i % 2));
            instance.set_real(&[reference], &[value]).unwrap_or_else(|error| panic!("{error}"));
        }
        best = best.min(clock.elapsed().as_secs_f64() / f64::from(CALLS));
    }
    Some(best)
}

fn main() {
    for name in ["suspended_wheelset", "vehicle_manchester_1", "train"] {
        if let Some(time) = tuning(&Case::new(name, &[], 0.0)) {
            println!("{name}: an element's constant is set in {:.1} us", 1e6 * time);
        }
    }
    for (name, changes, stop) in SCENES {
        let case = Case::new(name, changes, stop);
        let mut times: Vec<f64> = (0..7)
            .map(|_| {
                let clock = ThreadTime::now();
                let instance = case.started();
                let time = clock.elapsed().as_secs_f64();
                drop(instance);
                time
            })
            .collect();
        times.sort_by(f64::total_cmp);
        println!("{name} {}: {} outputs; instantiate and initialise {:.1} ms", changes.join(" "), case.table.outputs.len(), 1e3 * times[0]);
        let all = case.references(|_| true);
        let motion = case.references(|output| output.needs == Needs::Motion);
        let accelerations = case.references(|output| output.unit.name() == "m/s2" || output.unit.name() == "rad/s2");
        let wheels = case.references(|output| output.group == "wheels");
        let lateral = case.input("lateralForceInput").unwrap_or_default();
        for step in [1e-3, 1e-4] {
            let alone = case.cost(step, &Calls::Nothing);
            println!("  every {} ms: steps alone {:.2} ms per simulated second; with, as a multiple of that:", 1e3 * step, 1e3 * alone);
            for (what, calls) in [
                (format!("{} outputs of motion", motion.len()), Calls::Read(motion.clone())),
                (format!("{} accelerations", accelerations.len()), Calls::Read(accelerations.clone())),
                (format!("{} outputs of wheels", wheels.len()), Calls::Read(wheels.clone())),
                (format!("all {} outputs", all.len()), Calls::Read(all.clone())),
                (format!("all {} outputs, one call each", all.len()), Calls::ReadEach(all.clone())),
                ("an input changed".to_string(), Calls::Set(lateral)),
                ("an input that goes on".to_string(), Calls::SetRamp(lateral)),
            ] {
                println!("    {:6.2}  {what}", case.cost(step, &calls) / alone);
            }
        }
    }
}
