//! Where the undeformed surfaces of a wheel and a rail overlap, cell by cell.
//!
//! The rail's surface is the reference: a cell lies at the distance x ahead of the deepest place and at the arc length y along the rail's
//! section (e2: to the left), and each strip has its own normal n(y). The overlap is counted along it: the wheel's surface, of
//! revolution about its axle, is met at `P + t n` where
//!
//! ```text
//! F(t) = rho(t) - R(u(t)) = 0,    u: coordinate along the axle, rho: distance from it,    overlap d = -t
//! ```
//!
//! That is exact for any profiles, yaw and roll, and for patches that bend around a gauge corner, where distances along one single direction
//! would not be those that the surfaces must yield by.

use super::Settings;
use crate::contact::search::algebraic::Pair;
use crate::geometry::track::rail_surface::rail_point;
use nalgebra::Vector3;

/// Beyond this distance [m] nothing is looked for: it counts as a gap of that width.
const FAR: f64 = 5e-3;
/// Spacing of the first look across the rail, m, and steps of the arc length's integral in it.
const SPACING: f64 = 2e-4;
/// Half the base of the parabola that finds the deepest place of a strip, m, and how often.
const BASE: f64 = 1e-3;
const ROUNDS: usize = 4;
const ITERATIONS: usize = 12;

/// A place on the rail and the wheel above it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sample {
    /// d, m; negative: a gap.
    pub overlap: f64,
    /// On the rail.
    pub point: Vector3<f64>,
    /// Out of the rail, unit.
    pub normal: Vector3<f64>,
    /// Into the wheel, unit.
    pub wheel_normal: Vector3<f64>,
    /// Forward along the rail, unit.
    pub forward: Vector3<f64>,
}

impl Sample {
    /// The wheel's undeformed material.
    pub fn on_wheel(&self) -> Vector3<f64> {
        self.point - self.normal * self.overlap
    }

    /// Along which pressure acts on the wheel, per its size: alike bodies yield alike, and the pressed surface lies half way between both.
    pub fn pressing(&self) -> Vector3<f64> {
        (self.normal + self.wheel_normal / self.wheel_normal.dot(&self.normal)) * 0.5
    }

    /// Half way between wheel and rail.
    pub fn between(&self) -> Vector3<f64> {
        self.point - self.normal * (0.5 * self.overlap)
    }
}

/// Looks at the rail's coordinate `eta`, `lead` [m] ahead of the wheelset's centre.
pub(super) fn sample(pair: &Pair, lead: f64, eta: f64) -> Sample {
    let (rail, _) = rail_point(pair.rail, pair.distance + lead, eta);
    let normal = (rail.t1.cross(&rail.t2) * pair.rail.side.sign()).normalize();
    let axle = pair.axes.column(1) * pair.wheel.side.sign();
    let from = rail.position - pair.centre;
    let (first, last) = pair.wheel.profile.range();
    let along = normal.dot(&axle);
    let (mut overlap, mut wheel_normal) = (0.0, normal);
    for _ in 0..ITERATIONS {
        let from = from - normal * overlap;
        let axial = from.dot(&axle);
        let radial = from - axle * axial;
        let rho = radial.norm();
        let u = axial - pair.wheel.half_spacing;
        let (radius, slope) = pair.wheel.profile.value_and_slope(u);
        // dF/dt; the normal points to the axle.
        let change = normal.dot(&radial) / rho - slope * along;
        let step = (rho - radius) / change;
        wheel_normal = (axle * slope - radial / rho) / slope.hypot(1.0);
        overlap += step;
        if !(overlap.abs() < FAR) || !(first..=last).contains(&u) {
            overlap = -FAR;
            break;
        }
        if step.abs() < 1e-13 {
            break;
        }
    }
    Sample { overlap, point: rail.position, normal, wheel_normal, forward: rail.t1.normalize() }
}

/// A strip along the rail where the overlap is largest.
#[derive(Clone, Copy, Debug)]
struct Strip {
    eta: f64,
    /// Arc length from the first strip, m.
    arc: f64,
    /// Where along it, m, how much, and half the length of the overlap, m.
    lead: f64,
    overlap: f64,
    half: f64,
}

/// The box of the rail's surface within which the surfaces overlap.
#[derive(Clone, Debug)]
pub(super) struct Domain {
    /// Lead of its begin and end, m.
    pub lead: [f64; 2],
    /// Arc length from the deepest place to both edges, outward positive, m, and the rail's coordinate over arc length.
    pub arc: [f64; 2],
    table: Vec<(f64, f64)>,
    /// Lead, rail coordinate and overlap of the deepest place.
    pub deepest: (f64, f64, f64),
    places: Vec<Place>,
}

/// Where the surfaces overlap without a gap: width across and length along the rail, m, and the largest overlap, m.
#[derive(Clone, Copy, Debug)]
struct Place {
    width: f64,
    length: f64,
    overlap: f64,
}

/// Cells that a place shall have each way, and the share of the load below which fewer will do.
const RESOLVED: f64 = 20.0;
const SMALL_SHARE: f64 = 0.02;
/// Most cells along the rail and across, and what they are a multiple of.
const MOST: [f64; 2] = [128.0, 256.0];
const MULTIPLE: f64 = 8.0;

impl Domain {
    /// The grid that has [`RESOLVED`] cells across each place that matters, and no fewer cells than `settings`.
    ///
    /// A flange that touches beside a loaded tread is a twentieth as wide as both with the way between them: with 32 cells it lay on one of them, its
    /// highest pressure was half of what it is and the creep force of the wheel 0.2 mu N off. A place carries about overlap * sqrt(width * length).
    pub fn resolving(&self, settings: Settings) -> Settings {
        let carries = |place: &Place| place.overlap * (place.width * place.length).sqrt();
        let all: f64 = self.places.iter().map(carries).sum();
        let box_sides = [self.lead[1] - self.lead[0], self.arc[1] - self.arc[0]];
        let mut cells = [settings.columns, settings.rows];
        for place in &self.places {
            let matters = (carries(place) / (all * SMALL_SHARE)).min(1.0);
            for (way, own) in [place.length, place.width].into_iter().enumerate() {
                let needed = (RESOLVED * matters * box_sides[way] / own).min(MOST[way]);
                if needed > cells[way] as f64 {
                    cells[way] = ((needed / MULTIPLE).ceil() * MULTIPLE) as usize;
                }
            }
        }
        Settings { columns: cells[0], rows: cells[1], ..settings }
    }

    /// `None` where the surfaces do not overlap.
    pub fn find(pair: &Pair) -> Option<Domain> {
        let (first, last) = pair.rail.profile.range();
        let count = ((last - first) / SPACING).ceil().max(2.0) as usize;
        let mut strips = Vec::with_capacity(count + 1);
        let (mut arc, mut before): (f64, Option<(f64, f64)>) = (0.0, None);
        for k in 0..=count {
            let eta = first + (last - first) * k as f64 / count as f64;
            let value = pair.rail.profile.at(eta).value;
            if let Some((eta_before, value_before)) = before {
                arc += f64::hypot(eta - eta_before, value - value_before);
            }
            before = Some((eta, value));
            strips.push(Strip { eta, arc, ..deepest_along(pair, eta) });
        }
        // A narrow patch may lie between two strips: the deepest ones are looked at more closely.
        let (deepest, _) = strips.iter().enumerate().max_by(|a, b| a.1.overlap.total_cmp(&b.1.overlap))?;
        let deepest = refine(pair, &strips, deepest);
        if !(deepest.overlap > 0.0) {
            return None;
        }
        let overlapping = || strips.iter().filter(|strip| strip.overlap > 0.0);
        let inside = [
            overlapping().next().map_or(deepest.eta, |strip| strip.eta.min(deepest.eta)),
            overlapping().next_back().map_or(deepest.eta, |strip| strip.eta.max(deepest.eta)),
        ];
        let outside = [
            strips.iter().rev().find(|strip| strip.eta < inside[0]).map_or(first, |strip| strip.eta),
            strips.iter().find(|strip| strip.eta > inside[1]).map_or(last, |strip| strip.eta),
        ];
        let ends = [0, 1].map(|side| edge(pair, outside[side], inside[side]));
        let reach = overlapping().chain([&deepest]).map(|strip| [strip.lead - strip.half, strip.lead + strip.half]);
        let lead = reach.fold([f64::INFINITY, f64::NEG_INFINITY], |lead, next| [lead[0].min(next[0]), lead[1].max(next[1])]);
        let table: Vec<(f64, f64)> = strips.iter().map(|strip| (strip.arc, strip.eta)).collect();
        let from = arc_at(&table, deepest.eta);
        let arc = ends.map(|eta| arc_at(&table, eta) - from);
        let table = table.into_iter().map(|(arc, eta)| (arc - from, eta)).collect();
        let places = strips.split(|strip| !(strip.overlap > 0.0)).filter(|place| !place.is_empty()).map(|place| Place {
            width: place[place.len() - 1].arc - place[0].arc + SPACING,
            length: 2.0 * place.iter().map(|strip| strip.half).fold(0.0, f64::max),
            overlap: place.iter().map(|strip| strip.overlap).fold(0.0, f64::max),
        });
        Some(Domain { lead, arc, table, deepest: (deepest.lead, deepest.eta, deepest.overlap), places: places.collect() })
    }

    /// Rail coordinate at an arc length from the deepest place, m.
    pub fn eta(&self, arc: f64) -> f64 {
        let k = self.table.partition_point(|entry| entry.0 <= arc).clamp(1, self.table.len() - 1);
        let ((a, from), (b, to)) = (self.table[k - 1], self.table[k]);
        from + (to - from) * (arc - a) / (b - a)
    }
}

/// Arc length at a rail coordinate, m: along chords, which are shorter than the arc by less than 1e-8 m.
fn arc_at(table: &[(f64, f64)], eta: f64) -> f64 {
    let k = table.partition_point(|entry| entry.1 <= eta).clamp(1, table.len() - 1);
    let ((a, from), (b, to)) = (table[k - 1], table[k]);
    a + (b - a) * (eta - from) / (to - from)
}

/// The deepest place along a strip: by parabolas, from below the axle on.
fn deepest_along(pair: &Pair, eta: f64) -> Strip {
    let mut lead = 0.0;
    let mut found = Strip { eta, arc: 0.0, lead, overlap: -FAR, half: 0.0 };
    for _ in 0..ROUNDS {
        let [behind, here, ahead] = [lead - BASE, lead, lead + BASE].map(|lead| sample(pair, lead, eta).overlap);
        let bend = (ahead - 2.0 * here + behind) / (BASE * BASE);
        if !(here > -FAR && behind > -FAR && ahead > -FAR && bend < 0.0) {
            break;
        }
        let half = (2.0 * here.max(0.0) / -bend).sqrt();
        found = Strip { lead, overlap: here, half, ..found };
        let step = -0.5 * (ahead - behind) / (BASE * bend);
        if step.abs() < 1e-9 {
            break;
        }
        lead += step.clamp(-0.02, 0.02);
    }
    found
}

/// The deepest place between the neighbours of a strip (golden section).
fn refine(pair: &Pair, strips: &[Strip], at: usize) -> Strip {
    const GOLDEN: f64 = 0.618_033_988_749_894_9;
    let (mut low, mut high) = (strips[at.saturating_sub(1)].eta, strips[(at + 1).min(strips.len() - 1)].eta);
    let mut inner = [high - GOLDEN * (high - low), low + GOLDEN * (high - low)].map(|eta| deepest_along(pair, eta));
    for _ in 0..30 {
        if inner[0].overlap > inner[1].overlap {
            high = inner[1].eta;
            inner = [deepest_along(pair, high - GOLDEN * (high - low)), inner[0]];
        } else {
            low = inner[0].eta;
            inner = [inner[1], deepest_along(pair, low + GOLDEN * (high - low))];
        }
    }
    [strips[at], inner[0], inner[1]].into_iter().max_by(|a, b| a.overlap.total_cmp(&b.overlap)).unwrap_or(strips[at])
}

/// Where the overlap begins, between a strip without and one with it.
fn edge(pair: &Pair, mut outside: f64, mut inside: f64) -> f64 {
    for _ in 0..30 {
        let middle = 0.5 * (outside + inside);
        *(if deepest_along(pair, middle).overlap > 0.0 { &mut inside } else { &mut outside }) = middle;
    }
    outside
}
