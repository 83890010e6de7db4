//! The table of FMU variables: inputs, outputs, parameters and what they mean.

use super::additions::Additions;
pub use super::additions::Array;
use super::parameters;
use super::variable::WHEELSET;
pub use super::variable::{Kind, Role, Variable};
use super::version::Version;
use crate::formulation::AssemblyError;
use crate::formulation::inputs::{ELEMENT_INPUTS, InputRow, RAIL_ROWS, TRAVEL_ROWS, WANTED_SPEED, WHEELSET_ROWS, input_index, rail_input};
use crate::geometry::Side;
use crate::scene::assemble;
use crate::scene::spec::Scene;
use crate::scene::vehicle::FASTEST;
use crate::sim::SimulationState;
use crate::sim::feedthrough::whose;
use crate::sim::outputs::{Output, integral, rate};
use crate::sim::vehicle_outputs::{BODY, FORCE_INPUT, STRIDE, scene_outputs};
use crate::units::Unit;
use std::collections::HashMap;

/// All variables of a scene.
pub struct VariableTable {
    /// Those of both versions of FMI.
    pub variables: Vec<Variable>,
    pub outputs: Vec<Output>,
    /// Of the FMU.
    pub version: Version,
    /// What only FMI 3.0 shows: nothing in an FMU of FMI 2.0.
    pub additions: Additions,
    /// Values of all inputs of the model, shown or not, before a master sets any.
    pub start_inputs: Vec<f64>,
    wheelsets: usize,
    /// Place of the wanted speed in the input vector, where the speed is an input.
    pub speed_input: Option<usize>,
    /// The bodies whose speed is imposed.
    driven: Vec<usize>,
    /// By input of force elements: the element's number among the vehicle's, and its bodies.
    elements: Vec<(usize, [Option<usize>; 3])>,
    first_element_input: usize,
    /// Is the track straight and level for ever?
    straight: bool,
    /// Index of each reference.
    index: HashMap<u32, usize>,
}

impl VariableTable {
    /// Builds the table of a scene for FMI 2.0.
    ///
    /// # Errors
    /// [`AssemblyError`] when the formulation can't treat the scene.
    pub fn new(scene: &Scene) -> Result<Self, AssemblyError> {
        Self::of_version(scene, Version::Two)
    }

    /// The same for either version.
    ///
    /// # Errors
    /// [`AssemblyError`] when the formulation can't treat the scene.
    pub fn of_version(scene: &Scene, version: Version) -> Result<Self, AssemblyError> {
        let model = assemble::model(scene)?;
        let outputs = scene_outputs(scene, &model);
        let mut variables = inputs(scene);
        variables.extend(element_inputs(scene, model.first_element_input()));
        let start_inputs = model.start_inputs();
        let travel = model.first_travel_input(start_inputs.len());
        variables.extend(travel.map(|first| travel_inputs(scene, first)).unwrap_or_default());
        variables.extend(outputs.iter().enumerate().map(|(index, output)| Variable {
            reference: output.reference,
            name: output.name.clone(),
            description: output.description.clone(),
            kind: Kind::Real,
            causality: "output",
            variability: "continuous",
            initial: Some("calculated"),
            unit: output.unit,
            start: None,
            min: None,
            max: None,
            role: Role::Output(index),
        }));
        variables.extend(parameters::parameters(scene));
        variables.extend(locals(model.formulation.constrains(), scene.solver.integrator.linearises(), version));
        let index = variables.iter().enumerate().map(|(index, variable)| (variable.reference, index)).collect();
        let forces = scene.vehicle.forces.iter().enumerate();
        let elements = forces.flat_map(|(number, force)| std::iter::repeat_n((number, force.0.reach()), force.0.inputs().len())).collect();
        Ok(VariableTable {
            variables,
            additions: if version == Version::Three { Additions::new(scene, &outputs) } else { Additions::default() },
            version,
            outputs,
            start_inputs,
            speed_input: travel.map(|first| first + WANTED_SPEED),
            driven: model.system.drives.iter().map(|drive| drive.body).collect(),
            wheelsets: model.wheelsets.len(),
            elements,
            first_element_input: model.first_element_input(),
            straight: scene.track.line.is_none(),
            index,
        })
    }

    /// The variable with a reference.
    pub fn find(&self, reference: u32) -> Option<&Variable> {
        self.place(reference).map(|place| self.at(place))
    }

    /// The variable at a place of [`VariableTable::place`].
    pub fn at(&self, place: usize) -> &Variable {
        self.variables.get(place).unwrap_or_else(|| &self.additions.variables[place - self.variables.len()])
    }

    /// How many values a reference stands for: 1, or an array's.
    pub fn size(&self, reference: u32) -> usize {
        self.additions.array(reference).map_or(1, |array| array.elements.len())
    }

    /// The scalars behind references, arrays by their elements.
    pub fn scalars(&self, references: &[u32]) -> Vec<u32> {
        let mut scalars = Vec::with_capacity(references.len());
        for reference in references {
            match self.additions.array(*reference) {
                Some(array) => scalars.extend(&array.elements),
                None => scalars.push(*reference),
            }
        }
        scalars
    }

    /// References of all outputs of FMI 3.0, in the order in which they are described.
    pub fn output_references(&self) -> Vec<u32> {
        let scalars = self.variables.iter().chain(&self.additions.variables).filter(|variable| variable.causality == "output");
        scalars.map(|variable| variable.reference).chain(self.additions.arrays.iter().map(|array| array.reference)).collect()
    }

    /// References of the inputs that an output or an array of outputs depends on at the same instant, in their order, and whether each enters with
    /// fixed factors; `None` where that is not known, or it is no output.
    pub fn known_dependencies(&self, reference: u32) -> Option<Vec<(u32, bool)>> {
        let mut places = Vec::new();
        for scalar in self.scalars(&[reference]) {
            let Role::Output(output) = self.find(scalar)?.role else { return None };
            places.extend(self.dependencies(&self.outputs[output]));
        }
        // Of each input the one that is not fixed comes first, and stays.
        places.sort_unstable();
        places.dedup_by_key(|(place, _)| *place);
        Some(places.into_iter().map(|(place, fixed)| (self.variables[place - 1].reference, fixed)).collect())
    }

    /// Where the variable with a reference stands, those that only FMI 3.0 shows behind the others.
    pub fn place(&self, reference: u32) -> Option<usize> {
        let addition = || Some(self.variables.len() + self.additions.place(reference)?);
        self.index.get(&reference).copied().or_else(addition)
    }

    /// Where the output stands whose derivative by time this output is, if the FMU shows it.
    pub fn integral(&self, variable: &Variable) -> Option<usize> {
        let reference = variable.reference;
        let shown = matches!(variable.role, Role::Output(_)) && (WHEELSET..BODY).contains(&reference);
        let number = integral(reference % WHEELSET, self.straight).filter(|_| shown)?;
        self.place(reference - reference % WHEELSET + number)
    }

    /// The output that is the derivative by time of this variable, if the FMU shows it.
    pub fn rate(&self, variable: &Variable) -> Option<&Variable> {
        let reference = variable.reference;
        let shown = matches!(variable.role, Role::Output(_)) && (WHEELSET..BODY).contains(&reference);
        let number = rate(reference % WHEELSET, self.straight).filter(|_| shown)?;
        self.variables.get(self.place(reference - reference % WHEELSET + number)?)
    }

    /// Does an output depend at the same instant on the input at this place of the input vector?
    pub fn depends(&self, output: &Output, input: usize) -> bool {
        if let Some(place) = input.checked_sub(self.first_element_input) {
            return match self.elements.get(place) {
                Some((element, ends)) => output.feedthrough.by_element(*element, ends),
                None => output.feedthrough.by_speed(&self.driven),
            };
        }
        let (wheelset, number) = whose(self.wheelsets, input);
        output.feedthrough.by_wheelset(wheelset, number)
    }

    /// Does the input, on which the output depends, enter it with a factor that parameters alone say?
    pub fn is_fixed(&self, output: &Output, input: usize) -> bool {
        input < self.first_element_input && output.feedthrough.is_fixed(whose(self.wheelsets, input).1)
    }

    /// 1-based indices of the inputs that an output depends on, and whether each enters with a fixed factor.
    pub fn dependencies(&self, output: &Output) -> Vec<(usize, bool)> {
        let indexed = self.variables.iter().enumerate();
        let depends = |(index, variable): (usize, &Variable)| match variable.role {
            Role::Input(input) if self.depends(output, input) => Some((index + 1, self.is_fixed(output, input))),
            _ => None,
        };
        indexed.filter_map(depends).collect()
    }
}

/// The inputs of the wheelsets, each followed by those of the rails under it, in the groups that a scene shows.
fn inputs(scene: &Scene) -> Vec<Variable> {
    let axles = scene.vehicle.axles();
    let asked = |row: &InputRow, driven: bool| scene.interface.inputs.contains(&row.group.name) && !(row.along && driven);
    let mut variables = Vec::new();
    for (index, (wheelset, driven)) in axles.iter().copied().enumerate().filter(|(_, axle)| scene.interface.shows(axle.0)) {
        let begin = WHEELSET * (index as u32 + 1);
        for (number, row) in WHEELSET_ROWS.iter().enumerate().filter(|(_, row)| asked(row, driven)) {
            variables.push(input(row, begin + row.id, format!("{wheelset}.{}", row.name), input_index(index, number)));
        }
        for side in Side::BOTH {
            for (number, row) in RAIL_ROWS.iter().enumerate().filter(|(_, row)| asked(row, driven)) {
                let (reference, name) = (begin + row.id + 10 * side.index() as u32, format!("{wheelset}.{}.{}", side.name(), row.name));
                variables.push(input(row, reference, name, rail_input(axles.len(), index, side, number)));
            }
        }
    }
    variables
}

/// The inputs that force elements bring along, from `first` on in the input vector.
fn element_inputs(scene: &Scene, first: usize) -> Vec<Variable> {
    let (mut variables, mut place) = (Vec::new(), first);
    for (number, element) in scene.vehicle.forces.iter().enumerate() {
        let (part, element) = (element.0.name(), &element.0);
        for (index, own) in element.inputs().iter().enumerate() {
            let row = InputRow {
                id: 0,
                group: &ELEMENT_INPUTS,
                name: own.name,
                unit: own.unit,
                neutral: element.start_input(index),
                least: own.least,
                most: None,
                along: false,
                text: own.description,
            };
            let reference = FORCE_INPUT + STRIDE * number as u32 + own.number;
            if scene.interface.inputs.contains(&ELEMENT_INPUTS.name) && scene.interface.shows(part) {
                variables.push(input(&row, reference, format!("{part}.{}", own.name), place));
            }
            place += 1;
        }
    }
    variables
}

/// The inputs of a speed that is one, from `first` on in the input vector.
fn travel_inputs(scene: &Scene, first: usize) -> Vec<Variable> {
    let of_row = |(number, row): (usize, &InputRow)| {
        let mut variable = input(row, row.id, row.name.into(), first + number);
        if number == WANTED_SPEED {
            (variable.start, variable.min, variable.max) = (Some(scene.vehicle.speed), Some(-FASTEST), Some(FASTEST));
        }
        variable
    };
    TRAVEL_ROWS.iter().enumerate().map(of_row).collect()
}

/// The input at `place` in the input vector.
fn input(row: &InputRow, reference: u32, name: String, place: usize) -> Variable {
    let [min, max] = row.unit.bounds(row.least, row.most);
    Variable {
        reference,
        name,
        description: row.text.into(),
        kind: Kind::Real,
        causality: "input",
        variability: "continuous",
        initial: None,
        unit: row.unit,
        start: Some(row.neutral),
        min,
        max,
        role: Role::Input(place),
    }
}

/// Counters of work; those of constraints only where contact is one, those of implicit methods only with one. They change in steps, which in FMI 3.0 only continuous variables may.
fn locals(constrains: bool, linearises: bool, version: Version) -> Vec<Variable> {
    let (kind, variability) = if version == Version::Three { (Kind::Real, "continuous") } else { (Kind::Integer, "discrete") };
    let counter = |reference, name: &str, text: &str, read: fn(&SimulationState) -> u64| Variable {
        reference,
        name: name.into(),
        description: text.into(),
        kind,
        causality: "local",
        variability,
        initial: Some("calculated"),
        unit: Unit::One,
        start: None,
        min: None,
        max: None,
        role: Role::Counter(read),
    };
    let mut locals = vec![
        counter(900, "solver.steps", "accepted steps of the integrator since the start", |s| s.integration.statistics.steps),
        counter(901, "solver.rejectedSteps", "rejected attempts", |s| s.integration.statistics.rejected),
        counter(902, "solver.evaluations", "evaluations of the right-hand side", |s| s.integration.statistics.evaluations),
        counter(903, "solver.restarts", "restarts at changes of inputs", |s| s.integration.statistics.restarts),
        counter(904, "solver.searchIterations", "Newton iterations of contact searches; pairs of nodes looked at in ECF-N", |s| {
            s.work.search_iterations
        }),
        Variable {
            reference: 910,
            name: "scene.title".into(),
            description: "title of the scene that this FMU was made from".into(),
            kind: Kind::String,
            causality: "local",
            variability: "constant",
            initial: Some("exact"),
            unit: Unit::One,
            start: None,
            min: None,
            max: None,
            role: Role::Title,
        },
    ];
    if constrains {
        locals.extend([
            counter(905, "solver.projections", "steps whose end was moved onto the constraints (in ACCF every evaluation does it)", |s| {
                s.integration.statistics.projections
            }),
            counter(906, "solver.events", "lift-offs and landings", |s| s.integration.statistics.events),
            counter(907, "solver.constraintIterations", "Newton iterations on the position constraints", |s| s.work.constraint_iterations),
            counter(908, "solver.forceIterations", "evaluations of the loop between normal and creep forces", |s| s.work.force_iterations),
        ]);
    }
    if linearises {
        locals.extend([
            counter(911, "solver.linearisations", "Jacobians", |s| s.integration.statistics.linearisations),
            counter(912, "solver.factorisations", "factorisations of I - a J", |s| s.integration.statistics.factorisations),
            counter(913, "solver.iterations", "Newton iterations of the integrator", |s| s.integration.statistics.iterations),
        ]);
    }
    locals
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::embedded::SCENES;
    use crate::scene::load;
    use crate::scene::spec::OUTPUT_GROUPS;

    /// One number, one variable: whatever groups a scene shows, on rails that give way too.
    #[test]
    fn prop_no_two_variables_have_one_reference() {
        let all = OUTPUT_GROUPS.iter().filter(|group| **group != crate::scene::spec::RAIL_FORCES).map(|group| format!("\"{group}\""));
        let shown = format!("interface.outputs=[{}]", all.collect::<Vec<_>>().join(","));
        let mut counted = 0;
        for scene in SCENES {
            for flexibility in [None, Some("track.flexibility=travelling"), Some("track.flexibility=beam")] {
                let changes: Vec<String> = std::iter::once(shown.clone()).chain(flexibility.map(str::to_string)).collect();
                // Not every scene goes with every track.
                let Ok(scene) = load::open(scene.name, &changes) else { continue };
                for version in [Version::Two, Version::Three] {
                    let Ok(table) = VariableTable::of_version(&scene, version) else { continue };
                    let own = table.variables.iter().chain(&table.additions.variables).map(|variable| (variable.reference, &variable.name));
                    let mut all: Vec<(u32, &String)> =
                        own.chain(table.additions.arrays.iter().map(|array| (array.reference, &array.name))).collect();
                    all.sort_unstable();
                    let twice = all.windows(2).find(|pair| pair[0].0 == pair[1].0);
                    assert!(twice.is_none(), "{} {flexibility:?}: {twice:?}", scene.name);
                    counted += 1;
                }
            }
        }
        assert!(counted > 3 * SCENES.len(), "{counted}");
    }

    /// Beside a curve the centre's speed is not that of its place along the centre line: `s' = v / (1 - k y)`.
    #[test]
    fn prop_the_speed_is_the_rate_of_the_distance_on_straight_track_alone() {
        for (scene, straight) in [("vehicle_manchester_1", true), ("vehicle_curve", false)] {
            let table = VariableTable::new(&load::open(scene, &[]).unwrap()).unwrap();
            let named = |name: &str| table.variables.iter().find(|variable| variable.name == name).unwrap();
            for wheelset in ["truck[1].wheelset[1]", "truck[2].wheelset[2]"] {
                let rate = |name: &str| table.rate(named(&format!("{wheelset}.{name}"))).map(|rate| rate.name.clone());
                assert_eq!(rate("distance").is_some(), straight, "{scene}");
                assert_eq!(rate("y"), Some(format!("{wheelset}.vy")));
                assert_eq!(table.integral(named(&format!("{wheelset}.vx"))).is_some(), straight, "{scene}");
            }
        }
    }
}
