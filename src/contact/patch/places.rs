//! A wheel's patches one by one, as the equations of motion ask for them: what each carries and where, and what creep forces each has.
//!
//! Patches are apart where a whole row of cells between them is not pressed. Forces act on the wheel's undeformed material, whose slip the tractions
//! know. A patch has the ellipse of its moments, as in Hertz's theory: `a^2 = 5 <x^2>`, `b^2 = 5 <y^2>`, means by pressure.

use super::pressed::{Grid, Grids, Rolled};
use super::{Motion, Pressed};
use crate::contact::Patch;
use nalgebra::Vector3;

/// One patch of a wheel; all forces act on the wheel.
#[derive(Clone, Debug, Default)]
pub struct Place {
    /// First and last row of cells: arc length from the deepest place, left positive, m.
    rows: [f64; 2],
    /// Sum of pressures, N, and their force, N, with its moment about `arm`, N m.
    pub load: f64,
    pub force: Vector3<f64>,
    pub moment: Vector3<f64>,
    /// Centre of load on the undeformed wheel, from the wheelset's centre, m; ahead of that along the rail, m; the rail's coordinate there, m.
    pub arm: Vector3<f64>,
    pub lead: f64,
    pub eta: f64,
    /// Along the rail, not unit.
    pub forward: Vector3<f64>,
    /// Largest overlap of the undeformed surfaces, m.
    pub overlap: f64,
    pub patch: Patch,
    /// Pa.
    pub highest_pressure: f64,
}

/// Creep force of a patch [N], its moment about the patch's `arm` [N m] and what friction bounds it by [N].
#[derive(Clone, Copy, Debug, Default)]
pub struct PlaceCreep {
    pub force: Vector3<f64>,
    pub moment: Vector3<f64>,
    pub bound: f64,
}

/// Friction of a cell: from the number of its place, its lead [m] and the rail's coordinate [m]; with what damping makes of its pressure.
pub type FrictionOf<'f> = &'f dyn Fn(usize, f64, f64) -> f64;

impl Pressed {
    /// Its patches from right to left, at most `most`: the nearest ones count as one beyond that.
    pub fn places(&self, most: usize) -> Vec<Place> {
        let Some(grids) = &self.grids else { return Vec::new() };
        let mut rows = rows(grids.fine.places.iter().map(|place| place[1]), grids.fine.size[1]);
        while rows.len() > most.max(1) {
            let gap = |k: &usize| rows[k + 1][0] - rows[*k][1];
            let Some(k) = (0..rows.len() - 1).min_by(|a, b| gap(a).total_cmp(&gap(b))) else { break };
            rows[k][1] = rows[k + 1][1];
            rows.remove(k + 1);
        }
        rows.iter().map(|rows| self.place(grids, *rows)).collect()
    }

    fn place(&self, grids: &Grids, rows: [f64; 2]) -> Place {
        let grid = &grids.fine;
        let area = self.material.shear_modulus() * grid.size[0] * grid.size[1];
        let mut place = Place { rows, ..Place::default() };
        let (mut first, mut second) = ([0.0; 2], [0.0; 2]);
        for k in (0..grid.cells.len()).filter(|k| within(grid.places[*k][1], rows)) {
            let (at, load) = (&grid.samples[k], area * grid.pressures[k]);
            let (arm, force) = (at.on_wheel() - self.centre, at.pressing() * load);
            place.load += load;
            place.force += force;
            place.moment += arm.cross(&force);
            place.arm += arm * load;
            place.forward += at.forward * load;
            place.overlap = place.overlap.max(at.overlap);
            place.highest_pressure = place.highest_pressure.max(self.material.shear_modulus() * grid.pressures[k]);
            for way in 0..2 {
                let x = grid.places[k][way];
                first[way] += load * x;
                second[way] += load * (x * x);
            }
        }
        let per_load = 1.0 / place.load;
        place.arm *= per_load;
        place.moment -= place.arm.cross(&place.force);
        place.forward *= per_load;
        let [a, b] = [0, 1].map(|way| {
            let mean = first[way] * per_load;
            (5.0 * (second[way] * per_load - mean * mean + grid.size[way] * grid.size[way] / 12.0)).sqrt()
        });
        place.patch = Patch { a, b };
        (place.lead, place.eta) = (first[0] * per_load, grids.eta(first[1] * per_load));
        place
    }

    /// Creep forces of these places in rolling, in their order.
    pub fn rolling(&self, places: &[Place], motion: &Motion, friction: FrictionOf) -> Vec<PlaceCreep> {
        let Some(grids) = &self.grids else { return Vec::new() };
        let on = |grid: &Grid| self.creep_on(grids, grid, (places, motion), friction);
        let mut fine = on(&grids.fine);
        if let Some(coarse) = grids.coarse.as_ref().map(on) {
            for (fine, coarse) in fine.iter_mut().zip(&coarse) {
                let force = fine.force * 2.0 - coarse.force;
                let size = force.norm();
                fine.moment = fine.moment * 2.0 - coarse.moment;
                fine.force = if size > fine.bound { force * (fine.bound / size) } else { force };
            }
        }
        fine
    }

    fn creep_on(&self, grids: &Grids, grid: &Grid, (places, motion): (&[Place], &Motion), friction: FrictionOf) -> Vec<PlaceCreep> {
        let area = self.material.shear_modulus() * grid.size[0] * grid.size[1];
        let mut creeps = vec![PlaceCreep::default(); places.len()];
        let of: Vec<usize> = grid.places.iter().map(|[_, arc]| nearest(places, *arc)).collect();
        let friction: Vec<f64> =
            grid.places.iter().zip(&of).map(|([lead, arc], place)| friction(*place, *lead, grids.eta(*arc)).max(0.0)).collect();
        let Rolled { tractions, .. } = grid.roll(self, motion, &friction);
        for (k, [x, y]) in tractions.into_iter().enumerate() {
            let (at, place, creep) = (&grid.samples[k], &places[of[k]], &mut creeps[of[k]]);
            let force = (at.forward * x + at.normal.cross(&at.forward) * y) * area;
            creep.force += force;
            creep.moment += (at.on_wheel() - self.centre - place.arm).cross(&force);
            creep.bound += friction[k] * grid.pressures[k] * area;
        }
        creeps
    }
}

impl Grids {
    /// Rail coordinate at an arc length from the deepest place, left positive, m.
    fn eta(&self, arc: f64) -> f64 {
        self.domain.eta(arc * self.left)
    }
}

fn within(arc: f64, rows: [f64; 2]) -> bool {
    (rows[0]..=rows[1]).contains(&arc)
}

/// Ranges of rows in which something is pressed, from right to left: of the arc lengths of cells [m] in that order, `height` [m] each.
pub(super) fn rows(arcs: impl Iterator<Item = f64>, height: f64) -> Vec<[f64; 2]> {
    let mut rows: Vec<[f64; 2]> = Vec::new();
    for arc in arcs {
        match rows.last_mut().filter(|last| arc - last[1] < 1.5 * height) {
            Some(last) => last[1] = arc,
            None => rows.push([arc; 2]),
        }
    }
    rows
}

/// The place at an arc length, or the nearest.
fn nearest(places: &[Place], arc: f64) -> usize {
    let beyond = |place: &Place| (place.rows[0] - arc).max(arc - place.rows[1]).max(0.0);
    (0..places.len()).min_by(|a, b| beyond(&places[*a]).total_cmp(&beyond(&places[*b]))).unwrap_or(0)
}
