//! Which effects a scene holds, and by which overrides of the command line each is switched off or exchanged for a neighbour.
//!
//! Everything comes from the scene that was read and its model: nothing is listed that the scene does not have, and what this page does not know is
//! not left out of the run but of the list alone (bodies, masses, profiles, the vertical load).

use crate::contact::creep::{self, polach};
use crate::contact::patch::{self, PatchLaw};
use crate::formulation::flexibility::{BEAM, Flexibility, TRAVELLING};
use crate::formulation::{Model, contact_index};
use crate::geometry::Side;
use crate::geometry::profile::Flangeless;
use crate::geometry::track::centre_line::Node;
use crate::geometry::track::components;
use crate::scene::effects::{QUANTITIES, Switch, stem};
use crate::scene::patch_choice;
use crate::scene::spec::Scene;
use crate::scene::start;
use serde::Serialize;
use toml_edit::{Document, Item, TableLike};

/// What is done to an effect.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// It is left out.
    Off,
    /// The scene leaves it out, and it is taken in.
    On,
    /// Something simpler stands for it.
    Simpler,
    /// Something that knows more stands for it.
    Fuller,
    /// Another way to the same.
    Other,
}

/// A scene with one effect changed.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Variant {
    pub effect: String,
    pub kind: Kind,
    /// What takes its place, or "off".
    pub change: String,
    /// `key=value`, as `--set` takes it.
    pub overrides: Vec<String>,
}

/// Displacements below this are none, m.
pub(super) const NOTHING: f64 = 1e-9;
/// Distance of readings of the track, m, and how many there may be.
const READING: f64 = 0.1;
const READINGS: usize = 50_000;

#[derive(Default)]
struct List(Vec<Variant>);

impl List {
    fn add(&mut self, effect: impl Into<String>, kind: Kind, change: impl Into<String>, overrides: &[&str]) {
        let overrides = overrides.iter().map(ToString::to_string).collect();
        self.0.push(Variant { effect: effect.into(), kind, change: change.into(), overrides });
    }

    /// A switch of `[effects]`, to where it does not stand.
    fn switch(&mut self, scene: &Scene, switch: Switch) {
        let (kind, word) = if scene.effects.is_off(switch) { (Kind::On, "on") } else { (Kind::Off, "off") };
        self.add(switch.name(), kind, word, &[&format!("effects.{}={word}", switch.key())]);
    }
}

/// Everything that can be changed in a scene that runs for `stop` [s].
pub fn variants(scene: &Scene, model: &Model, stop: f64) -> Vec<Variant> {
    let mut list = List::default();
    contact(scene, model, &mut list);
    creep_law(scene, &mut list);
    vehicle(scene, &mut list);
    track(scene, model, stop, &mut list);
    guards(scene, model, &mut list);
    list.0
}

/// What is not computed where it is known to do nothing: to be computed all the same, as a check.
fn guards(scene: &Scene, model: &Model, list: &mut List) {
    let guarded = model.track.line().is_some()
        || model.track.left.deviates()
        || model.track.right.deviates()
        || scene.contact.transient.is_some()
        || (0..model.contacts()).any(|wheel| model.searches_contacts(wheel));
    if scene.effects.half {
        list.add("contacts of right wheels", Kind::Fuller, "computed", &["effects.symmetry=none"]);
    }
    if guarded && !scene.effects.all {
        list.add("effects where they do nothing", Kind::Fuller, "computed", &["effects.mode=all"]);
    }
}

/// Places, patches and normal forces.
fn contact(scene: &Scene, model: &Model, list: &mut List) {
    let contact = &scene.contact;
    let (rigid, strips) = (model.formulation.constrains(), contact.patch.law.forms());
    match (rigid, strips) {
        (true, _) => {
            let alike = patch_choice::alike(scene, &[contact.formulation_name, "ECF-A"]);
            let changes: Vec<&str> = ["contact.formulation=ECF-A"].into_iter().chain(alike.as_deref()).collect();
            list.add("rigid contact", Kind::Other, "ECF-A", &changes);
        }
        (false, false) => list.add("elastic contact", Kind::Other, "ECCF", &["contact.formulation=ECCF", "contact.on_lift=elastic"]),
        // A constraint holds one place of rigid surfaces.
        (false, true) => list.add(
            "elastic contact",
            Kind::Other,
            "ECCF",
            &["contact.formulation=ECCF", "contact.on_lift=elastic", "contact.patch=ellipse"],
        ),
    }
    match (rigid, strips) {
        (true, _) => {}
        // Patches that join and part have no states to hand over.
        (false, false) if contact.transient.is_some() => {}
        (false, _) => levels(scene, model, list),
    }
    if !strips && contact.normal_name == "assumed" {
        list.add(
            "stated contact stiffness",
            Kind::Fuller,
            "hertz",
            &[r#"contact.normal={ law = "hertz", curvature = "patch", conformal = "bounded" }"#],
        );
    } else if !strips {
        // A scene without [contact.normal] has curvatures over the patch.
        let stated = word(scene, &["contact", "normal"], "law").is_some();
        let over_patch = !stated || word(scene, &["contact", "normal"], "curvature").as_deref() == Some("patch");
        let (kind, rule) = if over_patch { (Kind::Simpler, "point") } else { (Kind::Fuller, "patch") };
        let change = match stated {
            true => format!("contact.normal.curvature={rule}"),
            false => format!("contact.normal={{ law = \"hertz\", curvature = \"{rule}\", conformal = \"bounded\" }}"),
        };
        list.add(format!("curvature at the {}", if over_patch { "patch" } else { "point" }), kind, rule, &[&change]);
    }
    let searched = (0..model.wheelsets.len())
        .flat_map(|index| Side::BOTH.map(|side| contact_index(index, side)))
        .any(|wheel| model.searches_contacts(wheel));
    let several = !strips && scene.points > 1 && searched && model.formulation.points_per_wheel() == 1;
    if several {
        list.add("several places per wheel", Kind::Off, "1", &["contact.points=1"]);
    }
    if contact.damping_law.name != "none" && (!rigid || several) {
        list.add("contact damping", Kind::Off, "none", &[r#"contact.damping={ law = "none" }"#]);
    }
    if contact.transient.is_some() || scene.effects.is_off(Switch::Transient) {
        list.switch(scene, Switch::Transient);
    }
    let [along, across] = contact.friction_map.as_ref().map(|map| map.describe().map(|words| words.is_some())).unwrap_or_default();
    for (there, switch) in [(along, Switch::FrictionAlong), (across, Switch::FrictionAcross)] {
        if there || scene.effects.is_off(switch) {
            list.switch(scene, switch);
        }
    }
}

/// Other levels of detail of the patch that the formulation can have, in the order of the registry, from the fullest on.
fn levels(scene: &Scene, model: &Model, list: &mut List) {
    let own = scene.contact.patch.law;
    let place = |law: PatchLaw| patch::REGISTRY.iter().position(|entry| entry.parse == law).unwrap_or(0);
    let possible = |law: PatchLaw| !law.needs_all_places() || model.formulation.points_per_wheel() == 1;
    // A table says what strips say.
    // The reference takes hours where a run takes seconds: it is nobody's neighbour unless the scene has it.
    let other = |law: PatchLaw| law != own && law != PatchLaw::Exact && (law != PatchLaw::Table || own == PatchLaw::Strips);
    let name = match own {
        PatchLaw::Strips | PatchLaw::Table => "non-elliptic patches",
        PatchLaw::Ellipse => "elliptic patches",
        PatchLaw::Linear => "linear contact",
        PatchLaw::Exact => "half-spaces on a grid",
    };
    // Beside other patches Kalker's problem would be solved for ellipses, as slowly.
    let quick: &[&str] = if own == PatchLaw::Exact { &["contact.creep={ law = \"usetab\" }"] } else { &[] };
    for entry in patch::REGISTRY.iter().filter(|entry| other(entry.parse) && possible(entry.parse)) {
        let kind = if place(entry.parse) < place(own) { Kind::Fuller } else { Kind::Simpler };
        list.add(name, kind, entry.name, &[&[format!("contact.patch={}", entry.name).as_str()], quick].concat());
    }
}

/// Laws whose friction may fall with the speed of sliding.
const FALLING: [&str; 4] = ["polach", "fastsim", "fastrip", "usetab"];
/// Laws of their own kind, between which and others nothing is simpler or fuller.
const APART: [&str; 2] = ["kalker_linear", "polach"];

/// The creep law and its settings.
fn creep_law(scene: &Scene, list: &mut List) {
    let law = scene.contact.creep_name.as_str();
    let number = |key: &str| number(scene, &["contact", "creep"], key);
    let surface = word(scene, &["contact", "creep"], "surface").unwrap_or("ideal".into());
    let (ratio, decay) = if law == "polach" { polach::friction_of(&surface).unwrap_or((1.0, 0.0)) } else { (1.0, 0.0) };
    let (ratio, decay) = (number("friction_ratio").unwrap_or(ratio), number("friction_decay").unwrap_or(decay));
    let falls = ratio < 1.0 && decay > 0.0;
    let factors: Vec<String> = ["kalker_factor", "longitudinal_factor", "lateral_factor"]
        .into_iter()
        .filter_map(|key| number(key).filter(|factor| *factor < 1.0).map(|factor| format!(", {key} = {factor}")))
        .collect();
    let table = |name: &str| {
        let friction =
            if falls && FALLING.contains(&name) { format!(", friction_ratio = {ratio}, friction_decay = {decay}") } else { String::new() };
        format!("contact.creep={{ law = \"{name}\"{}{friction} }}", factors.concat())
    };
    if !scene.contact.patch.law.forms() {
        list.switch(scene, Switch::Spin);
    }
    // Of a law that is linear nothing is left but its slopes; on the patch of half-spaces there is but one.
    if matches!(scene.contact.patch.law, PatchLaw::Linear | PatchLaw::Exact) {
        return;
    }
    if law != "kalker_linear" {
        list.add("saturation of creep forces", Kind::Off, "kalker_linear", &[&table("kalker_linear")]);
    }
    let place = |name: &str| creep::REGISTRY.iter().position(|entry| entry.name == name).unwrap_or(0);
    let others = || creep::REGISTRY.iter().map(|entry| entry.name).filter(|name| !APART.contains(name) && *name != law);
    if let Some(simpler) = others().rfind(|name| place(name) < place(law)) {
        list.add(format!("creep law {law}"), Kind::Simpler, simpler, &[&table(simpler)]);
    }
    if let Some(fuller) = others().find(|name| place(name) > place(law)) {
        list.add(format!("creep law {law}"), Kind::Fuller, fuller, &[&table(fuller)]);
    }
    if falls {
        list.add("falling friction", Kind::Off, "off", &["contact.creep.friction_ratio=1"]);
    }
    if !factors.is_empty() {
        let all = ["kalker_factor", "longitudinal_factor", "lateral_factor"].map(|key| format!("contact.creep.{key}=1"));
        list.add("reduced Kalker coefficients", Kind::Off, "off", &all.each_ref().map(String::as_str));
    }
}

/// Names as a list of the scene has them.
fn quoted(names: &[&String]) -> String {
    names.iter().map(|name| format!("\"{name}\"")).collect::<Vec<_>>().join(", ")
}

/// Bodies and what is between them.
fn vehicle(scene: &Scene, list: &mut List) {
    if let Some([now, next]) = scene.vehicle.coarser.filter(|_| scene.track.line.is_none()) {
        list.add(format!("detail {}", now.word()), Kind::Simpler, next.word(), &[&format!("vehicle.detail={}", next.word())]);
    }
    if let (false, None) = (scene.vehicle.followers.is_empty(), &scene.track.line) {
        let names = quoted(&scene.vehicle.followers.iter().collect::<Vec<_>>());
        list.add("detailed vehicles behind", Kind::Simpler, "point masses", &[&format!("vehicle.point_masses=[{names}]")]);
    }
    if scene.vehicle.speed != 0.0 || !scene.vehicle.speed_imposed {
        list.switch(scene, Switch::Gyroscopic);
    }
    let mut profiles = scene.vehicle.wheel_profiles().into_iter().flatten();
    if scene.effects.is_off(Switch::Flange) || profiles.any(|choice| Flangeless::new(choice.profile.clone()).is_some()) {
        list.switch(scene, Switch::Flange);
    }
    if scene.effects.is_off(Switch::OutOfRound)
        || scene.vehicle.wheelsets.iter().any(|placed| placed.spec.out_of_round.iter().any(Option::is_some))
    {
        list.switch(scene, Switch::OutOfRound);
    }
    let mut stems: Vec<String> = Vec::new();
    for force in &scene.vehicle.forces {
        let stem = stem(force.0.name());
        if !stems.contains(&stem) {
            stems.push(stem);
        }
    }
    let left_out = &scene.effects.without;
    for stem in &stems {
        let names: Vec<&String> = left_out.iter().chain([stem]).collect();
        list.add(stem.as_str(), Kind::Off, "off", &[&format!("effects.without=[{}]", quoted(&names))]);
    }
    for name in left_out {
        let names: Vec<&String> = left_out.iter().filter(|other| *other != name).collect();
        list.add(name.as_str(), Kind::On, "on", &[&format!("effects.without=[{}]", quoted(&names))]);
    }
}

/// What the rails do on the way.
fn track(scene: &Scene, model: &Model, stop: f64, list: &mut List) {
    match scene.track.flexibility.is_some() || scene.effects.is_off(Switch::TrackFlexibility) {
        true => {
            list.switch(scene, Switch::TrackFlexibility);
            // Levels of detail: a mass under each wheel, rails on sleepers.
            match scene.track.flexibility {
                Some(Flexibility::Travelling(_)) => {
                    list.add("masses under wheels", Kind::Fuller, BEAM, &["track.flexibility=beam"]);
                }
                Some(Flexibility::Beam(_)) => {
                    list.add("rails on sleepers", Kind::Simpler, TRAVELLING, &["track.flexibility=travelling"]);
                }
                None => {}
            }
        }
        // The usual track is laid where the formulation knows rails that move, and they are not moved already.
        false
            if !(model.formulation.constrains()
                || model.rail_motion
                || scene.vehicle.is_lone()
                || (model.axles_twist() && model.laws.transient.is_some())) =>
        {
            list.add("rigid track", Kind::Fuller, "travelling", &["track.flexibility=travelling"]);
        }
        false => {}
    }
    let found = components::largest(&start::deviations(scene), way(scene, stop));
    for (switch, quantity) in QUANTITIES {
        if found[quantity.index()] > NOTHING || scene.effects.is_off(switch) {
            list.switch(scene, switch);
        }
    }
    let nodes = scene.track.alignment.as_ref().map_or(&[][..], |alignment| &alignment.nodes);
    let any = |of: fn(&Node) -> f64| nodes.iter().any(|node| of(node) != 0.0);
    let bends = nodes.windows(2).any(|pair| pair[0].curvature != pair[1].curvature);
    for (there, switch) in [
        (any(|node| node.curvature), Switch::Curvature),
        (any(|node| node.superelevation), Switch::Cant),
        (any(|node| node.grade) || scene.track.grade != 0.0, Switch::Grade),
    ] {
        if there || scene.effects.is_off(switch) {
            list.switch(scene, switch);
        }
    }
    if scene.effects.abrupt {
        list.add("abrupt transitions", Kind::Fuller, "as stated", &["effects.transitions=on"]);
    } else if bends {
        list.add("transition curves", Kind::Simpler, "abrupt", &["effects.transitions=abrupt"]);
    }
}

/// Places that wheels of a scene pass, m.
pub(super) fn way(scene: &Scene, stop: f64) -> impl Iterator<Item = f64> {
    let places = || scene.vehicle.wheelsets.iter().map(|wheelset| wheelset.x);
    let travelled = scene.vehicle.speed * stop;
    let rear = places().fold(f64::INFINITY, f64::min) + travelled.min(0.0);
    let front = places().fold(f64::NEG_INFINITY, f64::max) + travelled.max(0.0);
    let origin = start::origin(scene);
    let count = (((front - rear) / READING).ceil() as usize).clamp(1, READINGS);
    (0..=count).map(move |k| origin + rear + (front - rear) * k as f64 / count as f64)
}

/// A value of the scene's text.
fn value<T>(scene: &Scene, path: &[&str], key: &str, read: impl Fn(&Item) -> Option<T>) -> Option<T> {
    let document = Document::parse(scene.source.text.as_str()).ok()?;
    let table = path.iter().try_fold(document.as_table() as &dyn TableLike, |table, step| table.get(step)?.as_table_like())?;
    read(table.get(key)?)
}

fn word(scene: &Scene, path: &[&str], key: &str) -> Option<String> {
    value(scene, path, key, |item| item.as_str().map(String::from))
}

fn number(scene: &Scene, path: &[&str], key: &str) -> Option<f64> {
    let plain = |item: &Item| item.as_float().or_else(|| item.as_integer().map(|whole| whole as f64));
    value(scene, path, key, |item| plain(item).or_else(|| item.as_str().and_then(|text| text.trim().parse().ok())))
}
