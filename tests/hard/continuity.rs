//! ECF-A's normal forces and patches are continuous in the pose: wheels led over their rails from tread to flange, pose by pose.

use crate::common;
use wheelrail::formulation::{Evaluation, Workspace};
use wheelrail::geometry::Side;
use wheelrail::scene::load;
use wheelrail::sim::Simulation;

/// What all contacts of a wheel carry together [N], and their semi-axes weighted by what each carries [N m].
type Sums = [f64; 3];

/// Load that the wheel carries, N; roll that lifts the other wheel off its rail, rad.
const LOAD: f64 = 80e3;
const ROLL: f64 = 4e-3;
/// From the tread's outer part to the flange, m, and the length of a straight way between two poses.
const FROM: f64 = -11e-3;
const TO: f64 = 8e-3;
const WAY: f64 = 50e-6;
/// Poses between which nothing bends by more than BENT (of N, N a, N b) are smooth; others are halved down to WIDTH [m]. Over that, N may
/// change by JUMP of itself: 1e-6 for each nanometre, of which this is a thousandth.
const FINE: usize = 10;
const BENT: f64 = 1e-5;
const WIDTH: f64 = 1e-12;
const JUMP: f64 = 1e-6;

/// One wheelset, one wheel of which is pressed in poses of our choice.
struct Stand {
    simulation: Simulation,
    start: Vec<f64>,
    memory: wheelrail::formulation::memory::ModelMemory,
    inputs: Vec<f64>,
    side: Side,
}

impl Stand {
    fn new(changes: &[String], side: Side) -> Self {
        let all = ["contact.friction=0", "contact.damping=0"];
        let changes: Vec<String> = all.iter().map(|change| (*change).to_string()).chain(changes.iter().cloned()).collect();
        let path = common::data("scenes/apta_flange.toml");
        let scene = load::open_file(&path, "apta_flange", &changes).unwrap_or_else(|error| panic!("{error}"));
        let mut simulation = common::start(&scene);
        let snapshot = simulation.snapshot().unwrap();
        let (memory, inputs, start) = (snapshot.memory().clone(), snapshot.inputs().to_vec(), snapshot.y.clone());
        Stand { simulation, start, memory, inputs, side }
    }

    /// The wheelset moved by `y` towards the flange of its wheel and `z` up, m; contacts are searched from nothing.
    fn at(&self, workspace: &mut Workspace, [y, z]: [f64; 2]) -> Option<Sums> {
        let model = self.simulation.model();
        let (mut state, mut memory, mut rates) = (self.start.clone(), self.memory.clone(), vec![0.0; self.start.len()]);
        let sign = self.side.sign();
        state[1] += sign * y;
        state[2] += z;
        state[3] -= sign * ROLL;
        let at = Evaluation { t: 0.0, inputs: &self.inputs, y: &state, memory: &mut memory };
        model.derivative(workspace, at, &mut rates).ok()?;
        let add = |sums: Sums, [force, a, b]: [f64; 3]| [sums[0] + force, sums[1] + force * a, sums[2] + force * b];
        let of = |report: &wheelrail::formulation::ContactReport| [report.normal_force, report.patch.a, report.patch.b];
        Some(workspace.reports(self.side.index()).map(of).fold(Sums::default(), add))
    }

    /// The height above or below `z` [m] at which the wheel carries its load.
    fn balance(&self, workspace: &mut Workspace, y: f64, z: f64) -> f64 {
        // Pressed beyond what elastic contact bears it fails.
        let mut presses = |z: f64| self.at(workspace, [y, z]).is_none_or(|sums| sums[0] > LOAD);
        let (mut low, mut high, mut width) = (z, z, 1e-4);
        while presses(high) && high < 0.05 {
            (low, high, width) = (high, high + width, 1.4 * width);
        }
        width = 1e-4;
        while !presses(low) && low > -0.05 {
            (high, low, width) = (low, low - width, 1.4 * width);
        }
        for _ in 0..30 {
            let middle = 0.5 * (low + high);
            *(if presses(middle) { &mut low } else { &mut high }) = middle;
        }
        0.5 * (low + high)
    }
}

/// Jumps between two poses, given by their places on the way.
fn jumps(at: &mut impl FnMut(f64) -> Option<Sums>, ends: [(f64, Sums); 2], found: &mut Vec<(f64, Sums)>) {
    let [(from, a), (to, b)] = ends;
    if to - from <= WIDTH {
        let jump = [0, 1, 2].map(|i| ((b[i] - a[i]) / a[i]).abs());
        if jump.iter().any(|jump| *jump > JUMP) {
            found.push((from, jump));
        }
        return;
    }
    let middle = 0.5 * (from + to);
    let Some(c) = at(middle) else { return };
    if [0, 1, 2].iter().any(|i| ((c[*i] - 0.5 * (a[*i] + b[*i])) / c[*i]).abs() > BENT) {
        jumps(at, [(from, a), (middle, c)], found);
        jumps(at, [(middle, c), (to, b)], found);
    }
}

/// Jumps over the whole way of the wheel, and how much of the way was looked at.
fn sweep(stand: &Stand) -> (Vec<(f64, Sums)>, f64) {
    let mut workspace = stand.simulation.model().workspace();
    let count = ((TO - FROM) / WAY).round() as usize;
    let mut z = 4e-3;
    let poses: Vec<[f64; 2]> = (0..=count)
        .map(|i| {
            let y = FROM + (TO - FROM) * i as f64 / count as f64;
            z = stand.balance(&mut workspace, y, z);
            [y, z]
        })
        .collect();
    let (mut found, mut seen) = (Vec::new(), 0);
    for [from, to] in poses.windows(2).map(|pair| [pair[0], pair[1]]) {
        let length = (to[0] - from[0]).hypot(to[1] - from[1]);
        let mut at = |s: f64| stand.at(&mut workspace, [0, 1].map(|i| from[i] + (to[i] - from[i]) * s / length));
        let values: Option<Vec<(f64, Sums)>> = (0..=FINE)
            .map(|i| {
                let s = length * i as f64 / FINE as f64;
                // Round the corner between tread and flange a straight way leads away from the rail, or deep into it.
                Some((s, at(s).filter(|sums| sums[0] > 0.5 * LOAD && sums[0] < 2.0 * LOAD)?))
            })
            .collect();
        let Some(values) = values else { continue };
        seen += 1;
        let before = found.len();
        values.windows(2).for_each(|pair| jumps(&mut at, [pair[0], pair[1]], &mut found));
        found[before..].iter_mut().for_each(|jump| jump.0 = from[0] + (to[0] - from[0]) * jump.0 / length);
    }
    (found, seen as f64 / count as f64)
}

/// Wheels and rails by name.
fn pairs() -> Vec<(String, Vec<String>)> {
    let pair = |wheel: &str, rail: &str, profile: String, head: String| {
        (format!("{wheel} on {rail}"), vec![format!("vehicle.wheelset.profile={profile}"), format!("track.rail={head}")])
    };
    let designs = ["APTA120", "APTA140", "APTA140M", "APTA220", "APTA240", "APTA320", "APTA340", "NRCC6Acela", "NRCCAmtrak"];
    let s1002 = || "{kind=\"s1002\",radius=0.46}".to_string();
    let head = |kind: &str| format!("{{kind=\"{kind}\"}}");
    let apta = |design: &str| format!("{{kind=\"apta\",design=\"{design}\",radius=0.46}}");
    let measured = |kind: &str, file: &str, more: &str| {
        format!("{{kind=\"{kind}\",file=\"{}\",smoothing=\"0.02 mm\"{more}}}", common::data("profiles").join(file).display())
    };
    let mut all: Vec<_> = ["60e1", "60e2", "uic60"].map(|rail| pair("S1002", rail, s1002(), head(rail))).into();
    all.extend(designs.map(|design| pair(design, "60e1", apta(design), head("60e1"))));
    all.push(pair("a measured S1002", "60e1", measured("miniprof", "wheel_s1002.whl", ",radius=0.46"), head("60e1")));
    all.push(pair("S1002", "a measured 60E1", s1002(), measured("miniprof", "rail_60e1.ban", "")));
    all
}

/// N jumped where a profile had turned by more than the gap's closed form could bear (S1002's flange root: 1.5 % of N, 6 % of b, and
/// hundreds of jumps of 1e-4), and where a third place became deeper than the second of two (S1002 on 60E2: 29 % of N).
#[test]
fn hard_normal_forces_and_patches_do_not_jump() {
    let mut all = Vec::new();
    for (name, changes) in pairs() {
        for side in Side::BOTH {
            let stand = Stand::new(&changes, side);
            let (found, seen) = sweep(&stand);
            println!(
                "{name}, {}: {} contacts, {:.0} % seen, {} jumps",
                side.name(),
                stand.simulation.model().points,
                100.0 * seen,
                found.len()
            );
            assert!(seen > 0.9, "{name}, {}: only {seen} of the way", side.name());
            for (y, jump) in &found {
                println!("    at {:.6} mm: N {:.1e}, a {:.1e}, b {:.1e}", 1e3 * y, jump[0], jump[1], jump[2]);
            }
            all.extend(found.into_iter().map(|jump| (name.clone(), side, jump)));
        }
    }
    assert!(all.is_empty(), "{} jumps, the first: {:?}", all.len(), all[0]);
}

/// With `contact.points = 1` a wheel is followed at its deepest place, on profiles that have several too. (A coach ended at 1.01 s with "found no
/// solution (25 iterations, residual 4.8e-13)".)
#[test]
fn hard_one_place_works_on_every_pair() {
    let settings = ["contact.points=1", "vehicle.initial.y=4.5 mm", "solver={integrator=\"rosenbrock\",tolerance=1e-5}"].map(String::from);
    for (name, pair) in pairs() {
        for formulation in ["ECF-A", "ECCF", "ACCF"] {
            let own = [format!("contact.formulation={formulation}"), "contact.on_lift=elastic".into()];
            let changes: Vec<String> = pair.iter().chain(&settings).chain(&own).cloned().collect();
            let scene = load::open_file(&common::data("scenes/apta_flange.toml"), "apta_flange", &changes).unwrap();
            let mut simulation = common::start(&scene);
            simulation.advance(1.5).unwrap_or_else(|error| panic!("{name}, {formulation}: {error}"));
        }
    }
    let scene = load::open("vehicle_manchester_1", &["contact.points=1".to_string()]).unwrap();
    common::start(&scene).advance(2.0).unwrap_or_else(|error| panic!("{error}"));
}

/// At the point the curvature of measured or hollow profiles may be anything: by default the ellipse is bounded and the run goes on.
#[test]
fn hard_curvature_at_the_point_goes_on_where_it_is_conformal() {
    let point = [
        "contact.normal={law=\"hertz\",curvature=\"point\"}",
        "vehicle.initial.y=6 mm",
        "solver={integrator=\"rosenbrock\",tolerance=1e-5}",
    ];
    for (name, pair) in pairs() {
        let changes: Vec<String> = pair.iter().cloned().chain(point.map(String::from)).collect();
        let scene = load::open_file(&common::data("scenes/apta_flange.toml"), "apta_flange", &changes).unwrap();
        common::start(&scene).advance(1.0).unwrap_or_else(|error| panic!("{name}: {error}"));
    }
}
