//! The scenes of examples/scenes: each runs as a user would run it, and its numbers are held against formulas that fit on the back of an envelope.
//!
//! `WHEELRAIL_BLESS=1` writes the table of examples/scenes/README.md and the pictures beside it.

use std::collections::{BTreeSet, HashMap};
use std::path::{Path, PathBuf};
use std::process::Command;

const G: f64 = 9.81;

/// What a scene must show.
struct Fact {
    what: &'static str,
    unit: &'static str,
    formula: &'static str,
    found: f64,
    expected: f64,
    /// Largest difference; none: `found` must be below `expected`.
    within: Option<f64>,
}

impl Fact {
    fn equal(what: &'static str, unit: &'static str, found: f64, formula: &'static str, expected: f64, within: f64) -> Fact {
        Fact { what, unit, formula, found, expected, within: Some(within) }
    }

    fn below(what: &'static str, unit: &'static str, found: f64, formula: &'static str, expected: f64) -> Fact {
        Fact { what, unit, formula, found, expected, within: None }
    }

    fn holds(&self) -> bool {
        match self.within {
            Some(within) => (self.found - self.expected).abs() <= within,
            None => self.found < self.expected,
        }
    }

    /// A row of the page's table.
    fn row(&self, scene: &str) -> String {
        let number = |x: f64| {
            let digits = (3 - x.abs().max(1e-6).log10().floor() as i32).clamp(0, 4) as usize;
            if x.abs() < 1e-4 { "0".to_string() } else { format!("{x:.digits$}") }
        };
        let relation = if self.within.is_some() { "" } else { "< " };
        format!(
            "| `{scene}` | {}, {} | {} | {relation}{} | {} |",
            self.what,
            self.unit,
            number(self.found),
            number(self.expected),
            self.formula
        )
    }
}

/// A finished run.
struct Run {
    columns: HashMap<String, Vec<f64>>,
    /// Standard error of the program, and how it ended.
    said: String,
    code: i32,
}

impl Run {
    fn column(&self, name: &str) -> &[f64] {
        self.columns.get(name).unwrap_or_else(|| panic!("no output {name}"))
    }

    fn first(&self, name: &str) -> f64 {
        self.column(name)[0]
    }

    fn last(&self, name: &str) -> f64 {
        self.column(name)[self.column(name).len() - 1]
    }

    fn largest(&self, name: &str) -> f64 {
        self.column(name).iter().copied().fold(f64::NEG_INFINITY, f64::max)
    }

    fn mean(&self, name: &str) -> f64 {
        self.column(name).iter().sum::<f64>() / self.column(name).len() as f64
    }

    /// Sum over wheelsets of an output at the first (0) or last (1) row.
    fn sum(&self, wheelsets: &[&str], output: &str, last: bool) -> f64 {
        wheelsets
            .iter()
            .map(|wheelset| format!("{wheelset}.{output}"))
            .map(|name| if last { self.last(&name) } else { self.first(&name) })
            .sum()
    }

    /// Mean load of all wheels at the start, N.
    /// Mean over the last fifth of the run of the sum over wheelsets of an output.
    fn late(&self, wheelsets: &[&str], output: &str) -> f64 {
        let mean = |wheelset: &&str| {
            let column = self.column(&format!("{wheelset}.{output}"));
            let late = &column[column.len() * 4 / 5..];
            late.iter().sum::<f64>() / late.len() as f64
        };
        wheelsets.iter().map(mean).sum()
    }

    fn mean_load(&self, wheelsets: &[&str]) -> f64 {
        (self.sum(wheelsets, "left.verticalForce", false) + self.sum(wheelsets, "right.verticalForce", false))
            / (2 * wheelsets.len()) as f64
    }
}

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/scenes")
}

fn program(arguments: &[&str]) -> (String, String, i32) {
    let output = Command::new(env!("CARGO_BIN_EXE_wheelrail")).args(arguments).output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    (text(output.stdout), text(output.stderr), output.status.code().unwrap())
}

fn run(scene: &str, scratch: &Path) -> Run {
    let [file, rows] = [folder().join(format!("{scene}.toml")), scratch.join(format!("{scene}.csv"))];
    let [file, rows, plots] = [&file, &rows, scratch].map(|path| path.to_str().unwrap());
    let (_, said, code) = program(&["run", file, "-o", rows, "--plot", plots]);
    let mut reader = csv::Reader::from_path(rows).unwrap_or_else(|error| panic!("{scene}: {error}\n{said}"));
    let names: Vec<String> = reader.headers().unwrap().iter().map(|name| name.split(" [").next().unwrap().to_string()).collect();
    let mut columns = vec![Vec::new(); names.len()];
    for record in reader.records() {
        for (column, number) in columns.iter_mut().zip(record.unwrap().iter()) {
            column.push(number.parse().unwrap());
        }
    }
    Run { columns: names.into_iter().zip(columns).collect(), said, code }
}

const TRUCKS: [&str; 4] = ["truck[1].wheelset[1]", "truck[1].wheelset[2]", "truck[2].wheelset[1]", "truck[2].wheelset[2]"];
const STATIC: &str = "m g / 8";

/// Nadal's limit of Y/Q for a flange angle in degrees.
fn nadal(angle: f64, friction: f64) -> f64 {
    let slope = angle.to_radians().tan();
    (slope - friction) / (1.0 + friction * slope)
}

fn tram(run: &Run) -> Vec<Fact> {
    let (mass, speed, radius) = (12000.0 + 2.0 * 1600.0 + 4.0 * 700.0, 15.0 / 3.6, 50.0);
    let spin = |side: f64| speed * (1.0 + side * 0.75 / radius) / 0.35;
    let longitudinal = |wheel: &str| (run.last(&format!("{wheel}.longitudinalForce")) / run.last(&format!("{wheel}.verticalForce"))).abs();
    let largest = TRUCKS.iter().flat_map(|w| [longitudinal(&format!("{w}.left")), longitudinal(&format!("{w}.right"))]).fold(0.0, f64::max);
    vec![
        Fact::equal("wheel load at rest", "kN", run.mean_load(&TRUCKS) / 1e3, STATIC, mass * G / 8e3, 0.02),
        Fact::equal(
            "spin of the first wheelset's inner wheel",
            "rad/s",
            run.last("truck[1].axle[1].leftSpeed"),
            "V (1 - b/R) / r",
            spin(-1.0),
            0.03,
        ),
        Fact::equal(
            "spin of the last wheelset's outer wheel",
            "rad/s",
            run.last("truck[2].axle[2].rightSpeed"),
            "V (1 + b/R) / r",
            spin(1.0),
            0.03,
        ),
        Fact::below("largest longitudinal force over load", "-", largest, "0.2, what rigid axles use of the friction", 0.02),
        Fact::equal(
            "force of all wheels on the rails, outward",
            "kN",
            -run.late(&TRUCKS, "trackShiftingForce") / 1e3,
            "m V^2 / R",
            mass * speed * speed / radius / 1e3,
            0.1,
        ),
    ]
}

fn wagon(run: &Run) -> Vec<Fact> {
    let mass = 81000.0 + 2.0 * 600.0 + 4.0 * 500.0 + 4.0 * 1350.0;
    let ratios: Vec<f64> = ["truck[1].wedge.left", "truck[2].wedge.left"]
        .iter()
        .flat_map(|wedge| {
            let [friction, spring] = ["frictionForce", "springForce"].map(|name| run.column(&format!("{wedge}.{name}")));
            friction.iter().zip(spring).map(|(friction, spring)| friction / spring).collect::<Vec<_>>()
        })
        .collect();
    let (least, largest) = ratios.iter().fold((0.0, 0.0), |(a, b): (f64, f64), x| (a.min(*x), b.max(*x)));
    let heights = run.column("car.z");
    let swing = |rows: &[f64]| rows.iter().copied().fold(f64::MIN, f64::max) - rows.iter().copied().fold(f64::MAX, f64::min);
    let first = swing(heights);
    vec![
        Fact::equal("wheel load at rest", "kN", run.mean_load(&TRUCKS) / 1e3, STATIC, mass * G / 8e3, 0.05),
        Fact::equal("friction over spring force, bolster going down", "-", largest, "mu / (tan b - mu)", 0.25 / 0.75, 0.01),
        Fact::equal("friction over spring force, bolster going up", "-", least, "-mu / (tan b + mu)", -0.25 / 1.25, 0.01),
        Fact::below(
            "swing of the car in the last second over its largest",
            "-",
            swing(&heights[heights.len() - 200..]) / first,
            "friction ends it",
            0.05,
        ),
    ]
}

fn locomotive(run: &Run) -> Vec<Fact> {
    let (mass, pull, torque, radius) = (84000.0, 180e3, 4.0 * 5200.0 * 4.6, 0.46);
    let turning = 112.0 + 8.0 * 4.6 * 4.6;
    let acceleration = (torque / radius - pull) / (mass + 4.0 * turning / (radius * radius));
    let rails = torque / radius - 4.0 * turning * acceleration / (radius * radius);
    // Rods and springs share the pull between truck and car.
    let height = (5.0e6 * 0.6 + 320e3 * 0.8275) / 5.32e6;
    let truck = rails / 2.0 - 16000.0 * acceleration;
    let own = acceleration * (8000.0 * 0.6 + 8000.0 * 0.46 + 2.0 * (112.0 - 8.0 * 4.6) / radius);
    let to_rear = (pull * 1.0 + 52000.0 * acceleration * 1.8 - 2.0 * truck * height) / 19.0;
    // The car stays behind by what they yield, and its load with it.
    let behind = (52000.0 * G / 2.0 - to_rear) * truck / 5.32e6;
    let shifted = (truck * height + behind + own) / 2.56;
    let leading = mass * G / 4.0 - to_rear / 2.0 - shifted;
    let [time, speed] = ["time", "truck[1].wheelset[1].vx"].map(|name| run.column(name));
    let (begin, end) = (time.len() - 251, time.len() - 1);
    let found = (speed[end] - speed[begin]) / (time[end] - time[begin]);
    vec![
        Fact::equal("wheel load at rest", "kN", run.mean_load(&TRUCKS) / 1e3, STATIC, mass * G / 8e3, 0.05),
        Fact::equal("acceleration", "m/s2", found, "(4 T i / r - F) / (m + 4 (J + i^2 J_r) / r^2)", acceleration, 0.01 * acceleration),
        Fact::equal(
            "load of a leading wheel when pulling",
            "kN",
            run.last("truck[1].wheelset[1].left.verticalForce") / 1e3,
            "moments about truck and vehicle: what is pulled at a height unloads the front",
            leading / 2e3,
            0.2,
        ),
        Fact::below(
            "used adhesion of the leading wheelset",
            "-",
            run.last("truck[1].wheelset[1].usedAdhesion"),
            "0.55 of a dry rail",
            0.55,
        ),
    ]
}

/// Moment about the track of the forces on a wheel at its contacts, beyond that of its vertical force 0.75 m from the middle, N m.
fn out_of_place(run: &Run, wheelset: &str, side: &str) -> f64 {
    let scene = wheelrail::scene::load::open(&folder().join("metro_r100.toml").display().to_string(), &[]).unwrap();
    let profile = &scene.vehicle.leading().profiles[0].profile;
    let sign = if side == "left" { 1.0 } else { -1.0 };
    let at = |name: &str| run.last(&format!("{wheelset}.{name}"));
    // Force across and up, and place across and up, of each contact.
    let contacts: Vec<[f64; 4]> = (1..=4)
        .map(|number| format!("{side}.contact[{number}]"))
        .filter(|contact| at(&format!("{contact}.normalForce")) > 0.0)
        .map(|contact| {
            let of = |name: &str| at(&format!("{contact}.{name}"));
            let (sin, cos) = of("angle").sin_cos();
            let [pressing, creep] = [of("normalForce"), of("creepForceY")];
            let (along, radius) = (sign * (0.75 + of("wheelCoordinate")), profile.at(of("wheelCoordinate")).value);
            let lead = of("wheelAngle");
            [
                creep * cos - sign * pressing * sin,
                pressing * cos + sign * creep * sin,
                at("y") + along + at("roll") * radius + radius * lead * at("yaw"),
                at("z") + along * at("roll") - radius * lead.cos(),
            ]
        })
        .collect();
    let moment = |[across, up, y, z]: &[f64; 4]| (y - sign * 0.75) * up - z * across;
    // Parts that are partly one share what they creep: what is left to the sums acts at their mean place.
    let [across, up] = [0, 1].map(|i| contacts.iter().map(|contact| contact[i]).sum::<f64>());
    let [y, z] = [2, 3].map(|i| contacts.iter().map(|contact| contact[i] * contact[1]).sum::<f64>() / up);
    let left = [at(&format!("{side}.lateralForce")) - across, at(&format!("{side}.verticalForce")) - up, y, z];
    contacts.iter().map(moment).sum::<f64>() + moment(&left)
}

fn metro(run: &Run) -> Vec<Fact> {
    let (mass, speed, radius): (f64, f64, f64) = (22000.0 + 2.0 * 3000.0 + 4.0 * 1500.0, 10.0, 100.0);
    let cant = (0.080_f64 / 1.511).asin();
    let deficiency = speed * speed / radius * cant.cos() - G * cant.sin();
    // Moments about the line through the places of the track beside the wheelsets, along the track: the mean of those lies so far inwards of the track beside the car
    // (on a chord of 11 m), or a truck (of 2.1 m), and cant lifts it.
    let turn = speed / radius;
    let weighs = |mass: f64, y: f64, z: f64, chord: f64| {
        let outwards = turn * turn * (radius - y);
        let [across, down] = [outwards * cant.cos() - G * cant.sin(), outwards * cant.sin() + G * cant.cos()];
        mass * (across * (z - chord * cant.sin()) - down * (y - chord * cant.cos()))
    };
    let at = |name: &str| run.last(name);
    let truck_chord = 1.05_f64.powi(2) / (2.0 * radius);
    let mut moment = weighs(22000.0, at("car.y"), at("car.z"), truck_chord + 5.5_f64.powi(2) / (2.0 * radius));
    for frame in ["truck[1].frame", "truck[2].frame"] {
        moment += weighs(3000.0, at(&format!("{frame}.y")), at(&format!("{frame}.z")), truck_chord);
    }
    for wheelset in TRUCKS {
        moment += weighs(1500.0, at(&format!("{wheelset}.y")), at(&format!("{wheelset}.z")), 0.0);
        // Axles that turn with the track: J omega V / R.
        moment += 110.0 * at(&format!("{wheelset}.pitchRate")) * turn * cant.cos();
        moment += ["left", "right"].iter().map(|side| out_of_place(run, wheelset, side)).sum::<f64>();
    }
    // The leading wheelset is pulled in its own direction, at the height of its axle.
    let ahead = at("truck[1].wheelset[1].distance") - at("car.distance");
    moment -= at("truck[1].wheelset[1].drivingForce") * ahead / radius * 0.42;
    let sides = run.sum(&TRUCKS, "right.verticalForce", true) - run.sum(&TRUCKS, "left.verticalForce", true);
    let yaw = run.last("truck[1].wheelset[1].yaw") - run.last("truck[1].wheelset[2].yaw");
    vec![
        Fact::equal("wheel load at rest", "kN", run.mean_load(&TRUCKS) / 1e3, STATIC, mass * G / 8e3, 0.05),
        Fact::equal(
            "force of all wheels on the rails, outward",
            "kN",
            -run.sum(&TRUCKS, "trackShiftingForce", true) / 1e3,
            "m (V^2/R cos f - g sin f)",
            mass * deficiency / 1e3,
            0.02 * mass * deficiency / 1e3,
        ),
        Fact::equal(
            "load of the outer wheels less the inner ones",
            "kN",
            sides / 1e3,
            "moments of all masses where they are, of spinning axles (4 %) and of contacts beside the tread circles (5 %)",
            moment / 0.75 / 1e3,
            0.005 * moment / 0.75 / 1e3,
        ),
        Fact::equal(
            "yaw of the first wheelset less that of the second",
            "mrad",
            yaw * 1e3,
            "-wheelbase / R, less what the primary springs yield",
            -21.0,
            2.5,
        ),
        Fact::below(
            "Y/Q of the leading outer wheel",
            "-",
            run.last("truck[1].wheelset[1].right.derailmentQuotient"),
            "Nadal's limit, 70 degrees and friction 0.3",
            nadal(70.0, 0.3),
        ),
    ]
}

fn coach(run: &Run) -> Vec<Fact> {
    let load = (32000.0 + 2.0 * 2615.0 + 4.0 * 1813.0) * G / 8.0;
    let mean = |output: &str| TRUCKS.iter().map(|wheelset| run.mean(&format!("{wheelset}.left.{output}"))).sum::<f64>() / 4.0;
    let yaw = TRUCKS.iter().map(|wheelset| run.largest(&format!("{wheelset}.y"))).fold(0.0, f64::max);
    vec![
        Fact::equal("mean load of the left wheels on the way", "kN", mean("verticalForce") / 1e3, STATIC, load / 1e3, 0.4),
        Fact::equal("mean sinking of the rail under them", "mm", -mean("railVerticalDeflection") * 1e3, "Q / k", load / 62e6 * 1e3, 0.01),
        Fact::below(
            "largest wheel load",
            "kN",
            run.largest("truck[1].wheelset[1].right.verticalForce") / 1e3,
            "170, a limit of EN 14363",
            170.0,
        ),
        Fact::below(
            "largest lateral displacement",
            "mm",
            yaw * 1e3,
            "no hunting from flange to flange: 6 of clearance and what rails stray",
            12.0,
        ),
    ]
}

fn measured(run: &Run) -> Vec<Fact> {
    let file = folder().join("measured_profiles.toml");
    let (text, ..) = program(&["contact", file.to_str().unwrap(), "--json", "--amplitude", "3 mm"]);
    let conicity = serde_json::from_str::<serde_json::Value>(&text).unwrap()["conicity"]["en15302"]["value"].as_f64().unwrap();
    let [y, way] = ["wheelset.y", "wheelset.distance"].map(|name| run.column(name));
    let crossings: Vec<f64> = (1..y.len())
        .filter(|k| y[k - 1] < 0.0 && y[*k] >= 0.0)
        .map(|k| way[k - 1] - y[k - 1] * (way[k] - way[k - 1]) / (y[k] - y[k - 1]))
        .collect();
    let wave = (crossings[crossings.len() - 1] - crossings[0]) / (crossings.len() - 1) as f64;
    let klingel = std::f64::consts::TAU * (0.75_f64 * 0.46 / conicity).sqrt();
    vec![
        Fact::equal("wheel load", "kN", run.mean_load(&["wheelset"]) / 1e3, "(m g + F) / 2", (1813.0 * G + 91300.0) / 2e3, 0.2),
        Fact::equal("amplitude", "mm", run.largest("wheelset.y") * 1e3, "yaw wave / (2 pi)", 2.3 * klingel / std::f64::consts::TAU, 0.25),
        Fact::equal("wavelength", "m", wave, "2 pi sqrt(b r / conicity), conicity of `wheelrail contact`", klingel, 0.03 * klingel),
    ]
}

fn derailment(run: &Run) -> Vec<Fact> {
    let wheelsets = ["wheelset[1]", "wheelset[2]"];
    let quotient = run.column("wheelset[1].right.derailmentQuotient");
    let peak = (0..quotient.len()).max_by(|a, b| quotient[*a].total_cmp(&quotient[*b])).unwrap();
    let angle = 70.0 - run.column("wheelset[1].roll")[peak].to_degrees();
    // Twist before the wheel climbs far: the leading wheelset is 3 m on the ramp, the other one still in front of it.
    let at = run.column("wheelset[1].distance").iter().position(|s| *s >= 11.0).unwrap();
    let s: f64 = (run.column("wheelset[1].distance")[at] - 8.0) / 9.0;
    let twist = 0.055 * s.powi(4) * (35.0 - 84.0 * s + 70.0 * s * s - 20.0 * s.powi(3));
    let rate = 0.055 * 140.0 * (s * (1.0 - s)).powi(3) * 15.0 / 3.6 / 9.0;
    let lost = |row: usize| run.column("wheelset[1].right.verticalForce")[row] - run.column("wheelset[1].left.verticalForce")[row];
    vec![
        Fact::equal("wheel load at rest", "kN", run.mean_load(&wheelsets) / 1e3, "m g / 4", (10000.0 + 2600.0) * G / 4e3, 0.1),
        Fact::equal(
            "load that the leading outer wheel lost after 3 m of ramp",
            "kN",
            (lost(0) - lost(at)) / 2e3,
            "(k h + c h') (w / b)^2 / 4, springs w = 2 m and wheels b = 1.5 m apart",
            (0.8e6 * twist + 15e3 * rate) * (2.0_f64 / 1.5).powi(2) / 4.0 / 1e3,
            0.15,
        ),
        Fact::equal(
            "Y/Q with which the wheel climbs",
            "-",
            quotient[peak],
            "Nadal's limit, flange 70 degrees less the wheelset's roll, friction 0.45",
            nadal(angle, 0.45),
            0.05,
        ),
        Fact::equal(
            "y with the flange's tip on the rail's head",
            "mm",
            run.last("wheelset[1].y") * 1e3,
            "tip 56 mm inside the tread circle, middle of the head 3 mm outside it, head 72 mm wide",
            -59.0,
            36.0,
        ),
    ]
}

fn brake(run: &Run) -> Vec<Fact> {
    let mass = 32000.0 + 2.0 * 2615.0 + 4.0 * 1813.0;
    let discs = 4.0 * 5000.0 / 0.46;
    let inert = mass + 4.0 * 112.0 / (0.46 * 0.46);
    let (mut t, mut v, mut way, dt) = (0.0, 120.0 / 3.6, 0.0, 1e-4);
    while v > 0.0 {
        let magnets = 320e3 * (1.0 - f64::exp(-t / 0.3)) * (0.08 + 0.12 / (1.0 + v / 10.0));
        let slower = (discs + magnets + 600.0 + 2.0 * v * v - mass * G * 0.01) / inert * dt;
        (t, way, v) = (t + dt, way + (v - slower / 2.0) * dt, v - slower);
    }
    let [time, distance, speed] = ["time", "car.distance", "truck[1].wheelset[1].vx"].map(|name| run.column(name));
    let rest = speed.iter().position(|v| *v < 0.01).unwrap();
    let motion = distance[distance.len() - 250..].iter().map(|s| (s - distance[distance.len() - 1]).abs()).fold(0.0, f64::max);
    let adhesion = TRUCKS.iter().map(|wheelset| run.column(&format!("{wheelset}.usedAdhesion"))[rest / 2].abs()).sum::<f64>() / 4.0;
    let slower = (speed[rest / 2 - 25] - speed[rest / 2 + 25]) / (time[rest / 2 + 25] - time[rest / 2 - 25]);
    vec![
        Fact::equal("wheel load at rest", "kN", run.mean_load(&TRUCKS) / 1e3, STATIC, mass * G / 8e3, 0.05),
        Fact::equal(
            "braking distance",
            "m",
            distance[rest] - distance[0],
            "integral of v dt, forces of discs, magnets, air, grade",
            way,
            0.01 * way,
        ),
        Fact::equal("time to rest", "s", time[rest], "the same", t, 0.01 * t),
        Fact::equal(
            "adhesion used by the discs, mean of the wheelsets",
            "-",
            adhesion,
            "(4 T / r - 4 J a / r^2) / (m g)",
            (discs - (inert - mass) * slower) / (mass * G),
            0.001,
        ),
        Fact::equal("motion in the last five seconds", "mm", motion * 1e3, "0, the brakes hold", 0.0, 1e-3),
    ]
}

type Facts = fn(&Run) -> Vec<Fact>;

/// Every scene of the folder, its facts, the picture that its page shows, and whether it derails.
const SCENES: [(&str, Facts, &str); 8] = [
    ("tram_independent_wheels", tram, "_forces"),
    ("freight_wagon_wedges", wagon, ""),
    ("locomotive_with_motors", locomotive, ""),
    ("metro_r100", metro, "_forces"),
    ("high_speed_coach", coach, ""),
    ("measured_profiles", measured, ""),
    ("derailment_on_twist", derailment, ""),
    ("brake_to_standstill", brake, ""),
];

/// What a picture says, without the numbers of its axes, which change with the last digits of a run.
fn words(picture: &Path) -> Vec<String> {
    let text = std::fs::read_to_string(picture).unwrap();
    let said = text.split("<text").skip(1).filter_map(|rest| Some(rest.split_once('>')?.1.split_once("</text>")?.0.trim().to_string()));
    said.filter(|said| said.parse::<f64>().is_err()).collect()
}

#[test]
fn analytic_scenes_to_copy_show_what_formulas_say() {
    let files: BTreeSet<String> = std::fs::read_dir(folder())
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "toml"))
        .map(|path| path.file_stem().unwrap().to_string_lossy().into_owned())
        .collect();
    assert_eq!(files, SCENES.iter().map(|scene| scene.0.to_string()).collect(), "a scene without facts, or facts without a scene");
    let scratch = tempfile::tempdir().unwrap();
    let runs: Vec<Run> = std::thread::scope(|scope| {
        let started: Vec<_> = SCENES.iter().map(|scene| scope.spawn(|| run(scene.0, scratch.path()))).collect();
        started.into_iter().map(|thread| thread.join().unwrap()).collect()
    });
    let page = folder().join("README.md");
    let text = std::fs::read_to_string(&page).unwrap();
    let (mut rows, mut failed) = (Vec::new(), Vec::new());
    for ((scene, facts, picture), run) in SCENES.iter().zip(&runs) {
        let derails = *scene == "derailment_on_twist";
        assert_eq!(run.code, i32::from(derails), "{scene}: {}", run.said);
        assert_eq!(run.said.contains("derailed: the tip of the flange stands on the rail"), derails, "{scene}: {}", run.said);
        assert!(text.contains(&format!("{scene}.toml")) && text.contains(&format!("images/{scene}.svg")), "{scene} is not on the page");
        let [drawn, shown] = [scratch.path().join(format!("{scene}{picture}.svg")), folder().join(format!("images/{scene}.svg"))];
        if std::env::var_os("WHEELRAIL_BLESS").is_some() {
            std::fs::create_dir_all(shown.parent().unwrap()).unwrap();
            std::fs::copy(&drawn, &shown).unwrap();
        }
        assert_eq!(words(&drawn), words(&shown), "{scene}: its picture is of another run, WHEELRAIL_BLESS=1 draws it anew");
        for fact in facts(run) {
            rows.push(fact.row(scene));
            println!("{}", rows[rows.len() - 1]);
            if !fact.holds() {
                failed.push(rows[rows.len() - 1].clone());
            }
        }
    }
    assert!(failed.is_empty(), "{}", failed.join("\n"));
    const MARKS: [&str; 2] = ["<!-- facts, written by tests/analytic/example_scenes.rs -->\n", "<!-- / -->"];
    let begin = text.find(MARKS[0]).unwrap() + MARKS[0].len();
    let end = begin + text[begin..].find(MARKS[1]).unwrap();
    let table = format!("| scene | what | found | formula | |\n|---|---|---|---|---|\n{}\n", rows.join("\n"));
    if std::env::var_os("WHEELRAIL_BLESS").is_some() {
        std::fs::write(&page, format!("{}{table}{}", &text[..begin], &text[end..])).unwrap();
        return;
    }
    // Last digits may be others on another machine.
    let names = |table: &str| table.lines().map(|row| row.split('|').take(3).collect::<String>()).collect::<Vec<_>>();
    assert_eq!(names(&text[begin..end]), names(&table), "WHEELRAIL_BLESS=1 writes the table anew");
}
