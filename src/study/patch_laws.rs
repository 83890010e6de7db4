//! Laws of the patch against half-space contact of the real surfaces, pose by pose.
//!
//! A wheelset is set down as rigid at each lateral shift and yaw, and its left wheel lowered until half-space contact ([`crate::contact::patch`]) carries
//! the load. In that pose the strips ([`crate::contact::strips`]) and the scene's ellipse at the deepest place say what they carry, where, and how they
//! creep while the wheelset rolls at the pitch rate of its tread circle.

use super::contact_geometry::{Attitude, WheelsetOnTrack};
use super::ellipse_patch::ellipse_patch;
use super::strip_patch::{StripPatch, Strips};
use crate::contact::patch::{Motion, PatchCell, PatchSolution, Settings, depth_under_load};
use crate::geometry::Side;
use crate::math::rotation::AxleFrame;
use crate::scene::spec::Scene;
use nalgebra::{Matrix3, Vector3};
use rayon::prelude::*;
use std::f64::consts::PI;

/// Which poses.
#[derive(Clone, Debug)]
pub struct Poses {
    /// Lateral shifts, m, yaws, rad, and vertical loads of the left wheel, N.
    pub shifts: Vec<f64>,
    pub yaws: Vec<f64>,
    pub loads: Vec<f64>,
    /// Cells each way of the half-space contact.
    pub cells: usize,
}

/// What a law says less what half-space contact says.
#[derive(Clone, Copy, Debug)]
pub struct Difference {
    /// Of the normal force, in parts of it, of the load's centre along the rail's section, m, and of the area, in parts of it.
    pub normal_force: f64,
    pub centre: f64,
    pub area: f64,
    /// Of the creep force, in parts of mu N.
    pub creep: f64,
}

/// One pose.
#[derive(Clone, Debug)]
pub struct Row {
    pub y: f64,
    pub yaw: f64,
    pub load: f64,
    /// Normal force of the half-space contact, N.
    pub normal_force: f64,
    pub strips: Difference,
    /// `None` where the pose is not in the table.
    pub table: Option<Difference>,
    /// `None` where the laws know none.
    pub ellipse: Option<Difference>,
    /// The half-space contact from the inner to the outer side of the rail.
    pub bands: Vec<Band>,
}

/// The cells of a patch in one row along the rail.
#[derive(Clone, Copy, Debug)]
pub struct Band {
    /// Where it lies across, from the rail section's origin, outward, m.
    pub ends: [f64; 2],
    /// The highest in it, Pa.
    pub pressure: f64,
}

/// What a law says of a pose.
struct Said {
    force: f64,
    centre: Vector3<f64>,
    area: f64,
    creep: Vector3<f64>,
}

/// All poses in which the wheelset stands, in order.
pub fn rows(scene: &Scene, poses: &Poses) -> Vec<Row> {
    let all = poses.yaws.iter().flat_map(|yaw| poses.loads.iter().map(move |load| (*yaw, *load)));
    let all: Vec<(f64, f64, f64)> = all.flat_map(|(yaw, load)| poses.shifts.iter().map(move |y| (*y, yaw, load))).collect();
    let wheelset = WheelsetOnTrack::new(scene, Attitude::default(), None);
    let strips = Strips::new(scene, &wheelset.pair(Side::Left, &Vector3::zeros(), &Matrix3::identity()));
    all.into_par_iter().filter_map(|(y, yaw, load)| row(scene, &strips, (y, yaw, load), poses.cells)).collect()
}

fn row(scene: &Scene, strips: &Strips, (y, yaw, load): (f64, f64, f64), cells: usize) -> Option<Row> {
    let wheelset = WheelsetOnTrack::new(scene, Attitude { yaw, ..Attitude::default() }, None);
    let stand = wheelset.stand(y, wheelset.start()).ok()?;
    let axes = AxleFrame::new(yaw, stand.roll).axes;
    let side = Side::Left;
    let high = Vector3::new(wheelset.station, stand.y, stand.height[side.index()]);
    let settings = Settings { columns: cells, rows: cells, extrapolate: true, ..Settings::default() };
    let (depth, pressed) = depth_under_load(&wheelset.pair(side, &high, &axes), load, scene.contact.material, settings, None)?;
    let centre = high - Vector3::z() * depth;
    let pair = wheelset.pair(side, &centre, &axes);
    let (speed, friction) = (scene.vehicle.speed, scene.contact.friction);
    let rate = speed / pair.wheel.profile.at(0.0).value;
    let motion = Motion { velocity: Vector3::x() * speed, rotation: axes.column(1) * rate, speed };
    let exact = pressed.roll(&motion, friction);
    let force = exact.pressing.norm();
    let normal = exact.pressing / force;
    let across = normal.cross(&Vector3::x()).normalize();
    let less = |said: Said| Difference {
        normal_force: said.force / force - 1.0,
        centre: (said.centre - exact.centre).dot(&across),
        area: said.area / exact.area() - 1.0,
        creep: (said.creep - exact.creep_force).norm() / (friction * force),
    };
    let of =
        |patch: StripPatch| less(Said { force: patch.pressing.norm(), centre: patch.centre, area: patch.area, creep: patch.creep_force });
    let (strips, table) = strips.patches(&pair, &motion)?;
    let touch = &stand.contacts[side.index()];
    let ellipse = ellipse_patch(scene, &pair, touch, None, &motion).map(|ellipse| {
        let creep = ellipse.axes.e1 * ellipse.creep.longitudinal + ellipse.axes.e2 * ellipse.creep.lateral;
        less(Said { force: ellipse.normal_force, centre: ellipse.place, area: PI * ellipse.patch.a * ellipse.patch.b, creep })
    });
    let bands = bands(&exact, side, pair.rail.section(wheelset.station).origin.y);
    Some(Row { y, yaw, load, normal_force: force, strips: of(strips), table: table.map(of), ellipse, bands })
}

/// From the inner to the outer side; cells of one row follow each other.
fn bands(patch: &PatchSolution, side: Side, origin: f64) -> Vec<Band> {
    let of = |row: &[PatchCell]| {
        // Of a tilted cell the part across.
        let (at, half) = (side.sign() * (row[0].point.y - origin), 0.5 * patch.cell_size[1] * row[0].normal.z.abs());
        Band { ends: [at - half, at + half], pressure: row.iter().map(|cell| cell.pressure).fold(0.0, f64::max) }
    };
    let mut bands: Vec<Band> = patch.cells.chunk_by(|a, b| a.place[1] == b.place[1]).map(of).collect();
    bands.sort_by(|a, b| a.ends[0].total_cmp(&b.ends[0]));
    bands
}

/// Mean and worst of the sizes of one figure over rows that have it.
pub fn mean_and_worst(rows: &[Row], law: fn(&Row) -> Option<Difference>, figure: fn(&Difference) -> f64) -> [f64; 2] {
    let sizes: Vec<f64> = rows.iter().filter_map(law).map(|difference| figure(&difference).abs()).collect();
    [sizes.iter().sum::<f64>() / sizes.len() as f64, sizes.iter().copied().fold(0.0, f64::max)]
}
