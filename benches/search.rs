//! Time of what one elastic contact costs before its creep force: the search for all contacts, that over nodes, one known contact, and
//! the normal law with the curvature at the point and over the patch. S1002 on 60E1, and a cone on an arc.

use criterion::{Criterion, criterion_group, criterion_main};
use nalgebra::{Matrix3, Vector3};
use std::hint::black_box;
use std::time::Duration;
use wheelrail::contact::Material;
use wheelrail::contact::normal::NormalLaw;
use wheelrail::contact::patch::{Motion, Pressed as PressedPatch, Settings};
use wheelrail::contact::search::algebraic::{ContactLocation, Pair, SurfaceParameters};
use wheelrail::contact::search::global::{GlobalSearch, Minima};
use wheelrail::contact::search::nodal::NodalSearch;
use wheelrail::contact::strips::{MOST, Near, Part, Parts, RailStrips, Scratch, press};
use wheelrail::geometry::Side;
use wheelrail::geometry::surface::Wheel;
use wheelrail::geometry::track::Rail;
use wheelrail::math::rotation::AxleFrame;
use wheelrail::scene::load;
use wheelrail::sim::Simulation;

/// Reach of the search in a running simulation, m.
const REACH: f64 = 5e-4;
/// Penetration of a loaded tread, m.
const PENETRATION: f64 = 7e-5;
/// Poses, so that no branch is learned by heart.
const POSES: usize = 40;

struct Stand {
    wheel: Wheel,
    rail: Rail,
    law: Box<dyn NormalLaw>,
    search: GlobalSearch,
    axes: Matrix3<f64>,
}

impl Stand {
    fn new(scene: &str, curvature: &str) -> Self {
        let change = format!("contact.normal={{ law = \"hertz\", curvature = \"{curvature}\", conformal = \"bounded\" }}");
        let scene = load::open(scene, &[change]).unwrap_or_else(|error| panic!("{error}"));
        let simulation = Simulation::new(&scene, 0.0).unwrap_or_else(|error| panic!("{error}"));
        let model = simulation.model();
        let (wheel, rail) = (model.wheelsets[0].wheel(Side::Left).clone(), model.track.rail(Side::Left).clone());
        let law = (scene.contact.normal)(scene.contact.material);
        let search = GlobalSearch::new(wheel.profile.as_ref(), rail.profile.as_ref());
        Stand { wheel, rail, law, search, axes: AxleFrame::new(1e-3, 0.0).axes }
    }

    fn pair<'a>(&'a self, centre: &'a Vector3<f64>) -> Pair<'a> {
        Pair { wheel: &self.wheel, rail: &self.rail, centre, axes: &self.axes, distance: 0.0 }
    }

    /// Where the wheelset's centre is when the deepest contact of the wheel is pressed in, for shifts around `y` [m].
    fn poses(&self, y: f64) -> Vec<Vector3<f64>> {
        let mut minima = Minima::default();
        (0..POSES)
            .map(|i| {
                let mut centre = Vector3::new(0.0, y + 5e-6 * i as f64, 0.46);
                for _ in 0..12 {
                    self.search.find(&self.pair(&centre), 0.1, &mut minima);
                    let Some(deepest) = minima.deepest() else { panic!("no contact") };
                    centre.z += -deepest.distance - PENETRATION;
                }
                centre
            })
            .collect()
    }

    fn located(&self, poses: &[Vector3<f64>]) -> Vec<ContactLocation> {
        let mut minima = Minima::default();
        let mut locate = |centre: &Vector3<f64>| {
            let pair = self.pair(centre);
            self.search.find(&pair, REACH, &mut minima);
            let Some(deepest) = minima.deepest() else { panic!("no contact") };
            self.search.polish(&pair, deepest).location
        };
        poses.iter().map(&mut locate).collect()
    }
}

fn searches(criterion: &mut Criterion) {
    for (scene, name) in [("wheelset_s1002", "S1002/60E1"), ("suspended_wheelset", "cone/arc")] {
        let stand = Stand::new(scene, "point");
        for y in [0.5e-3, -2e-3] {
            let poses = stand.poses(y);
            let located = stand.located(&poses);
            let mut minima = Minima::default();
            let mut at = 0;
            let mut turn = || {
                at = (at + 1) % POSES;
                at
            };
            let mut delicate = 0;
            for centre in &poses {
                stand.search.find(&stand.pair(centre), REACH, &mut minima);
                delicate += usize::from(minima.delicate);
            }
            println!("{name}, y {:.1} mm: {delicate} of {POSES} poses delicate", 1e3 * y);
            criterion.bench_function(&format!("{name} {:+.1} mm: find", 1e3 * y), |bencher| {
                bencher.iter(|| stand.search.find(black_box(&stand.pair(&poses[turn()])), REACH, &mut minima));
            });
            criterion.bench_function(&format!("{name} {:+.1} mm: polish", 1e3 * y), |bencher| {
                let pair = stand.pair(&poses[0]);
                stand.search.find(&pair, REACH, &mut minima);
                bencher.iter(|| stand.search.polish(black_box(&pair), &minima[0]));
            });
            criterion.bench_function(&format!("{name} {:+.1} mm: locate", 1e3 * y), |bencher| {
                bencher.iter(|| {
                    // From the neighbouring pose.
                    let i = turn();
                    stand.pair(&poses[i]).locate(black_box(&located[(i + 1) % POSES].parameters))
                });
            });
        }
    }
}

fn nodal_searches(criterion: &mut Criterion) {
    for (scene, name) in [("wheelset_s1002", "S1002/60E1"), ("suspended_wheelset", "cone/arc")] {
        let stand = Stand::new(scene, "point");
        let poses = stand.poses(0.5e-3);
        let section = stand.rail.section(0.0);
        for spacing in [4e-4, 1e-4] {
            let search = NodalSearch::new(&stand.wheel, &stand.rail, spacing).unwrap_or_else(|error| panic!("{error}"));
            for (lift, state) in [(0.0, "pressed in"), (1e-3, "apart")] {
                let mut at = 0;
                criterion.bench_function(&format!("{name}: nodes every {:.1} mm, {state}", 1e3 * spacing), |bencher| {
                    bencher.iter(|| {
                        at = (at + 1) % POSES;
                        let centre = poses[at] + Vector3::new(0.0, 0.0, lift);
                        search.search(black_box(&centre), &stand.axes, (0.0, 0.0), &section, 4)
                    });
                });
            }
        }
    }
}

fn normal_laws(criterion: &mut Criterion) {
    for curvature in ["point", "patch"] {
        let stand = Stand::new("wheelset_s1002", curvature);
        for y in [0.5e-3, -2e-3] {
            let located = stand.located(&stand.poses(y));
            let mut at = 0;
            let mut turn = || {
                at = (at + 1) % POSES;
                &located[at]
            };
            criterion.bench_function(&format!("curvature {curvature} {:+.1} mm: contact", 1e3 * y), |bencher| {
                bencher.iter(|| {
                    let found = turn();
                    stand.law.contact(black_box(&found.shape(&stand.wheel, &stand.rail)), found.penetration)
                });
            });
            criterion.bench_function(&format!("curvature {curvature} {:+.1} mm: contact_under", 1e3 * y), |bencher| {
                bencher.iter(|| stand.law.contact_under(black_box(&turn().shape(&stand.wheel, &stand.rail)), 7e4));
            });
        }
    }
}

/// The patches of real surfaces: strips with their parts, half-spaces on a grid.
fn patches(criterion: &mut Criterion) {
    let material = Material { youngs_modulus: 2.1e11, poisson_ratio: 0.28 };
    let stand = Stand::new("wheelset_s1002", "point");
    for y in [0.5e-3, -2e-3] {
        let (poses, located) = (stand.poses(y), stand.located(&stand.poses(y)));
        let rail = RailStrips::new(&stand.rail, std::iter::once(&stand.wheel));
        let mut scratch = Scratch::new(rail.len());
        let mut at = 0;
        criterion.bench_function(&format!("strips {:+.1} mm: pressed, with their parts", 1e3 * y), |bencher| {
            bencher.iter(|| {
                at = (at + 1) % POSES;
                let SurfaceParameters { rail: eta, lead, .. } = located[at].parameters;
                let places = std::iter::once(Near { eta, lead, overlap: located[at].penetration });
                let pressed = press(black_box(&stand.pair(&poses[at])), &rail, places, material, &mut scratch);
                let parts = Parts::new(pressed, &rail, MOST);
                (0..parts.len())
                    .map(|k| Part::new(parts.share(pressed, k, k), &rail, stand.wheel.profile.as_ref(), material).load)
                    .sum::<f64>()
            });
        });
        let settings = Settings { columns: 33, rows: 33, extrapolate: false, ..Settings::default() };
        let motion = Motion { velocity: Vector3::x() * 20.0, rotation: stand.axes.column(1) * (20.0 / 0.46), speed: 20.0 };
        criterion.bench_function(&format!("half-spaces {:+.1} mm on 33 x 33 cells: normal problem", 1e3 * y), |bencher| {
            bencher.iter(|| PressedPatch::new(black_box(&stand.pair(&poses[at])), material, settings));
        });
        let pressed = PressedPatch::new(&stand.pair(&poses[0]), material, settings).unwrap();
        criterion.bench_function(&format!("half-spaces {:+.1} mm on 33 x 33 cells: rolling", 1e3 * y), |bencher| {
            bencher.iter(|| pressed.roll(black_box(&motion), 0.35).creep_force);
        });
    }
}

criterion_group! {
    name = search;
    config = Criterion::default().sample_size(30).warm_up_time(Duration::from_millis(200)).measurement_time(Duration::from_millis(800));
    targets = searches, nodal_searches, normal_laws, patches
}
criterion_main!(search);
