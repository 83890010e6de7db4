//! Reads a scene.

use super::effects::Effects;
use super::limits::{MOST_STEPS, SMALLEST_MODULUS, WIDEST};
use super::profiles::read_profiles;
use super::spec::*;
use super::table_store::FileStore;
use super::{assemble, patch_choice, solver_choice};
use crate::contact::friction::FrictionMap;
use crate::contact::patch::PatchLaw;
use crate::contact::transient::TransientSettings;
use crate::contact::{Material, creep, normal, patch};
use crate::formulation::{
    self, LOAD_TOLERANCE,
    flexibility::Flexibility,
    inputs::{GROUPS, RAIL_MOTION},
    patch_tables::PreparedTables,
    wheel_search::{MOST_POINTS, PreparedSearches},
};
use crate::geometry::profile::{Part, ProfileChoice};
use crate::geometry::track::centre_line::CentreLine;
use crate::geometry::track::{self, gauge, node};
use crate::settings::{Section, SettingsError, Source, did_you_mean};
use crate::solve;
use crate::units::Dimension;
use std::sync::Arc;

impl Scene {
    /// Reads all tables.
    ///
    /// # Errors
    /// All that is wrong with them.
    pub fn read(name: &str, root: Section, source: Source) -> Result<Scene, Vec<SettingsError>> {
        let read = Scene::read_tables(name, &root, source);
        // A scene with a fault may hold stand-ins.
        match (root.faults(), read) {
            (faults, Ok(scene)) if faults.is_empty() => Ok(scene),
            (faults, Err(error)) if faults.is_empty() => Err(vec![error]),
            (faults, _) => Err(faults),
        }
    }

    fn read_tables(name: &str, root: &Section, source: Source) -> Result<Scene, SettingsError> {
        let head = root.keep(read_head(name, root))?;
        let vehicle = root.keep(root.section("vehicle").and_then(super::vehicle::read))?;
        let track = root.keep(root.section("track").and_then(read_track))?;
        let contact = root.keep(root.section("contact").and_then(read_contact))?;
        let (mut vehicle, mut track, mut contact) = (vehicle, track, contact);
        let forces = vehicle.as_ref().map(|vehicle| vehicle.forces.as_slice());
        let effects = root.keep(root.section_or_empty("effects").and_then(|section| Effects::read(section, forces)))?.unwrap_or_default();
        if let Some(contact) = &mut contact {
            root.keep(root.section_or_empty("effects").and_then(|section| effects.leave_out_of_contact(contact, &section)))?;
        }
        let [transient, rings] = contact.as_ref().map_or([false; 2], |contact| [contact.transient.is_some(), contact.rings()]);
        let interface = match (root.keep(root.optional_section("interface"))?.flatten(), &vehicle) {
            (Some(section), Some(vehicle)) => root.keep(read_interface(section, vehicle))?,
            _ => Some(InterfaceSpec {
                inputs: default_inputs(),
                outputs: default_outputs(&[]),
                parameters: PARAMETER_GROUPS.to_vec(),
                only: None,
            }),
        };
        let read_solver = |section| read_solver(section, (transient, rings));
        let solver = root.keep(root.section_or_empty("solver").and_then(read_solver))?;
        let run = root.keep(root.section("run").and_then(read_run))?;
        // Behind the interface: what is left out has a name all the same.
        vehicle.iter_mut().for_each(|vehicle| effects.leave_out_of_vehicle(vehicle));
        track.iter_mut().for_each(|track| effects.leave_out_of_track(track));
        root.clone().finish()?;
        let (Some((name, title)), Some(vehicle), Some(track), Some(contact)) = (head, vehicle, track, contact) else {
            return Err(root.stop());
        };
        if let Some(map) = &contact.friction_map {
            root.keep(map.check(&root.section("contact")?, track.rails.each_ref().map(|rail| rail.profile.as_ref())))?;
        }
        let (Some(solver), Some(interface), Some(run)) = (solver, interface, run) else { return Err(root.stop()) };
        root.keep(check_settling(root, &vehicle, &solver))?;
        let (prepared, tables) = (PreparedSearches::default(), PreparedTables::stored(Arc::new(FileStore::of(source.folder.as_deref()))));
        let points = MOST_POINTS;
        let mut scene = Scene { name, source, title, vehicle, track, contact, effects, solver, interface, run, prepared, tables, points };
        scene.points = match scene.contact.patch.law {
            // All places at which surfaces may overlap.
            PatchLaw::Strips | PatchLaw::Table | PatchLaw::Exact => MOST_POINTS,
            PatchLaw::Linear => 1,
            PatchLaw::Ellipse => scene.contact.points.unwrap_or_else(|| assemble::points_needed(&scene)),
        };
        Ok(scene)
    }
}

/// Name and title.
fn read_head(name: &str, root: &Section) -> Result<(String, String), SettingsError> {
    let name = root.text_or("name", name)?;
    if !name.starts_with(|c: char| c.is_ascii_alphabetic()) || !name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_') {
        return Err(root.error("name", format!("found \"{name}\", expected letters, digits and _, a letter first")));
    }
    let title = root.text_or("title", &name)?;
    if title.chars().any(char::is_control) {
        return Err(root.error("title", "a control character can't stand in a title"));
    }
    Ok((name, title))
}

fn read_solver(solver: Section, contact: (bool, bool)) -> Result<SolverSpec, SettingsError> {
    let facts = solver_choice::facts(&solver, contact)?;
    let (automatic, why) = solver_choice::choose(&facts);
    let read = solve::parse(&solver, automatic)?;
    let load_tolerance = read_load_tolerance(&solver)?;
    let assumed = !solver.has("tolerance") && facts.tolerance.is_some();
    solver.finish()?;
    let why = read.automatic.then_some(why);
    Ok(SolverSpec { name: read.name, integrator: read.integrator, load_tolerance, why, assumed })
}

/// Fixed explicit steps must be short enough for the states of all force elements.
fn check_settling(root: &Section, vehicle: &VehicleSpec, solver: &SolverSpec) -> Result<(), SettingsError> {
    let least = solver.integrator.least_time_constant();
    let times = vehicle.forces.iter().filter_map(|element| Some((element.0.name(), element.0.time_constant()?)));
    let Some((name, time)) = times.min_by(|a, b| a.1.total_cmp(&b.1)).filter(|(_, time)| *time < least) else { return Ok(()) };
    let setting = solver.integrator.setting().value;
    let most = setting * time / least;
    let problem = format!(
        "found {setting:?} s, with which {} is not stable for {name}, whose state settles in {:.3} ms; expected at most {most:.1e} s, or an integrator with a tolerance",
        solver.name,
        1e3 * time
    );
    Err(root.section("solver")?.error("step", problem))
}

fn read_run(run: Section) -> Result<RunSpec, SettingsError> {
    let spec = RunSpec { stop: run.not_negative("stop", Dimension::Time)?, step: run.positive("step", Dimension::Time)? };
    if spec.stop / spec.step > MOST_STEPS {
        return Err(run.error("step", format!("found {:?} s, which makes more than {MOST_STEPS:?} steps until run.stop", spec.step)));
    }
    if spec.stop > 0.0 && spec.step > spec.stop {
        return Err(run.error("step", format!("found {:?} s, expected at most run.stop = {:?} s", spec.step, spec.stop)));
    }
    run.finish()?;
    Ok(spec)
}

/// Half the distance of standard gauge's rails, m, for what stands behind a distance that can't be read.
const HALF_STANDARD: f64 = 0.75;

fn read_track(section: Section) -> Result<TrackSpec, SettingsError> {
    let given = section.keep(read_inclination(&section))?;
    let inclination = given.unwrap_or(0.0);
    let grade = node::grade(&section)?;
    let rails = section.keep(read_profiles(&section, ["rail", "left_rail", "right_rail"], Part::Rail))?;
    let half_rail_distance = match &rails {
        Some(rails) => section.keep(read_half_distance(&section, rails, inclination))?,
        // Nothing can be measured, but the keys are known.
        None => {
            let _ = ["rail_distance", "gauge", "gauge_depth"].map(|key| section.has(key));
            None
        }
    };
    let base = 2.0 * half_rail_distance.unwrap_or(HALF_STANDARD);
    let alignment = section.keep(node::parse(&section, base))?;
    if alignment.as_ref().is_some_and(Option::is_some) && section.has("grade") {
        return Err(section.error("grade", "stands beside [[track.node]]; expected the nodes' own grade"));
    }
    let alignment = alignment.flatten();
    let line = alignment.as_ref().and_then(|alignment| CentreLine::new(alignment, nalgebra::Vector3::zeros(), 0.0)).map(Arc::new);
    let (mut deviations, mut files, mut doubts) = (Vec::new(), Vec::new(), Vec::new());
    for deviation in section.sections("deviation")? {
        deviations.extend(section.keep(track::parse_deviation(deviation))?.into_iter().flatten());
    }
    for irregularity in section.sections("irregularity")? {
        let Some(irregularity) = section.keep(track::irregularity::parse(irregularity))? else { continue };
        deviations.extend(irregularity.deviations);
        files.extend(irregularity.file);
        doubts.extend(irregularity.doubts);
    }
    let start_fade = if section.has("start_fade") { Some(section.positive("start_fade", Dimension::Length)?) } else { None };
    let flexibility = section.keep(Flexibility::parse(&section))?.flatten();
    section.clone().finish()?;
    let (Some(rails), Some(half_rail_distance), Some(inclination)) = (rails, half_rail_distance, given) else { return Err(section.stop()) };
    Ok(TrackSpec { half_rail_distance, inclination, grade, alignment, line, rails, deviations, start_fade, flexibility, files, doubts })
}

/// Half of `rail_distance`, or what `gauge` makes of it.
fn read_half_distance(section: &Section, rails: &[ProfileChoice; 2], inclination: f64) -> Result<f64, SettingsError> {
    for key in ["gauge", "rail_distance"] {
        section.refuse_beyond(key, Dimension::Length, WIDEST, "a distance in millimetres is written \"1435 mm\"")?;
    }
    if !section.has("gauge") {
        return Ok(0.5 * section.positive("rail_distance", Dimension::Length)?);
    }
    if section.has("rail_distance") {
        return Err(section.error("gauge", "stands beside rail_distance; expected one of them"));
    }
    let depth = section.number_or("gauge_depth", Dimension::Length, gauge::DEPTH)?;
    let reach = |choice: &ProfileChoice| {
        gauge::reach(choice.profile.as_ref(), inclination, depth).map_err(|early| section.error("gauge", early.to_string()))
    };
    let left = reach(&rails[0])?;
    let right = if Arc::ptr_eq(&rails[0].profile, &rails[1].profile) { left } else { reach(&rails[1])? };
    Ok(0.5 * (section.positive("gauge", Dimension::Length)? + left + right))
}

/// `"1:40"` is atan(1/40); otherwise an angle.
fn read_inclination(section: &Section) -> Result<f64, SettingsError> {
    const MOST_INCLINED: f64 = 0.5;
    let text = section.text("inclination").unwrap_or_default();
    let angle = match text.split_once(':').map(|(one, run)| (one.trim().parse::<f64>(), run.trim().parse::<f64>())) {
        Some((Ok(one), Ok(run))) => (one / run).atan(),
        _ => section.number("inclination", Dimension::Angle)?,
    };
    if angle.abs() < MOST_INCLINED {
        return Ok(angle);
    }
    let expected = "an angle below 0.5 rad, as a number in rad or a string such as \"1:40\" or \"1.4 deg\"";
    Err(section.error("inclination", format!("found {angle:?} rad, expected {expected}")))
}

fn read_contact(section: Section) -> Result<ContactSpec, SettingsError> {
    let formulation = section.keep(formulation::parse(&section))?;
    let material = section.keep(section.section("material").and_then(read_material))?;
    let normal = section.keep(read_normal(&section))?;
    let creep = section.keep(section.section("creep").and_then(|section| read_law(section, creep::parse)))?;
    let damping = section.keep(normal::damping::parse(&section))?;
    let friction = section.not_negative("friction", Dimension::None)?;
    let friction_map = section.keep(FrictionMap::parse(&section, friction))?;
    let constrains = formulation.as_ref().is_some_and(|(name, _)| formulation::CONSTRAINTS.contains(name));
    let patch = section.keep(patch::parse(&section).and_then(|named| patch_choice::choose(&section, named, constrains)))?;
    let points = section.keep(read_points(&section))?;
    let transient = section.keep(TransientSettings::parse(&section))?;
    section.clone().finish()?;
    let (Some((formulation_name, formulation)), Some(material), Some((normal_name, normal)), Some((creep_name, creep))) =
        (formulation, material, normal, creep)
    else {
        return Err(section.stop());
    };
    let (Some((damping, damping_law)), Some(points), Some(transient)) = (damping, points, transient) else { return Err(section.stop()) };
    let (Some(patch), Some(friction_map)) = (patch, friction_map) else { return Err(section.stop()) };
    Ok(ContactSpec {
        formulation_name,
        formulation,
        friction,
        friction_map,
        points,
        damping,
        damping_law,
        material,
        normal_name,
        normal,
        creep_name,
        creep,
        transient,
        patch,
    })
}

fn read_material(section: Section) -> Result<Material, SettingsError> {
    let poisson_ratio = section.within("poisson_ratio", Dimension::None, (0.0, 0.5))?;
    let youngs_modulus = section.at_least("youngs_modulus", Dimension::Pressure, SMALLEST_MODULUS)?;
    section.finish()?;
    Ok(Material { youngs_modulus, poisson_ratio })
}

/// `[contact.normal]` and its name; without it Hertz's ellipses as they suit real profiles.
fn read_normal(contact: &Section) -> Result<(String, normal::Build), SettingsError> {
    match contact.has("normal") {
        true => read_law(contact.section("normal")?, normal::parse),
        false => Ok((normal::DEFAULT.to_string(), normal::over_the_patch())),
    }
}

/// A law of contact and its name.
fn read_law<B>(section: Section, parse: fn(&Section) -> Result<B, SettingsError>) -> Result<(String, B), SettingsError> {
    let law = parse(&section)?;
    let name = section.text("law")?;
    section.finish()?;
    Ok((name, law))
}

/// `contact.points`; `None` when absent.
fn read_points(section: &Section) -> Result<Option<usize>, SettingsError> {
    let Some(points) = section.optional("points", Dimension::None)? else { return Ok(None) };
    if points.fract() == 0.0 && (1.0..=MOST_POINTS as f64).contains(&points) {
        return Ok(Some(points as usize));
    }
    Err(section.error("points", format!("found {points:?}, expected a whole number from 1 to {MOST_POINTS}")))
}

/// All groups that cost nothing.
fn default_inputs() -> Vec<&'static str> {
    GROUPS.iter().filter(|group| !group.on_request).map(|group| group.name).collect()
}

/// The same of outputs; forces on the rails belong to rails that move.
fn default_outputs(inputs: &[&str]) -> Vec<&'static str> {
    let moving = inputs.contains(&RAIL_MOTION.name);
    OUTPUT_GROUPS.iter().copied().filter(|group| !ON_REQUEST.contains(group) && (moving || *group != RAIL_FORCES)).collect()
}

fn read_interface(section: Section, vehicle: &VehicleSpec) -> Result<InterfaceSpec, SettingsError> {
    let only = section.optional_texts("only")?;
    let parts = vehicle.part_names();
    for name in only.iter().flatten() {
        let within = |part: &&str| part.strip_prefix(name.as_str()).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'));
        if !parts.iter().any(within) {
            let problem = format!("found \"{name}\"{}, expected parts of the vehicle: {}", did_you_mean(name, &parts), parts.join(", "));
            return Err(section.error("only", problem));
        }
    }
    let inputs = if section.has("inputs") { section.words_or_all("inputs", &GROUPS.map(|group| group.name))? } else { default_inputs() };
    let spec = InterfaceSpec {
        outputs: if section.has("outputs") { section.words_or_all("outputs", OUTPUT_GROUPS)? } else { default_outputs(&inputs) },
        inputs,
        parameters: section.words_or_all("parameters", PARAMETER_GROUPS)?,
        only,
    };
    section.finish()?;
    Ok(spec)
}

/// `solver.load_tolerance`.
fn read_load_tolerance(solver: &Section) -> Result<f64, SettingsError> {
    const RANGE: std::ops::RangeInclusive<f64> = 1e-9..=0.5;
    let value = solver.number_or("load_tolerance", Dimension::None, LOAD_TOLERANCE)?;
    if RANGE.contains(&value) {
        return Ok(value);
    }
    Err(solver.error(
        "load_tolerance",
        format!("found {value:?}, expected {:?} to {:?} (parts of the static wheel load)", RANGE.start(), RANGE.end()),
    ))
}
