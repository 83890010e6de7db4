//! How a wheel stands against its rail, seen along the rail.

use super::super::strip::Section;
use crate::contact::search::algebraic::Pair;
use nalgebra::Vector3;

/// A wheel against the section of a rail that is straight beside it.
///
/// The rail's section is taken where the middle of the tread circle is above it, so that a rail which bends or climbs is straight there; what its bend does
/// over the patch is added by [`super::look`].
#[derive(Clone, Copy, Debug)]
pub struct Standing {
    /// v, phi, h: of the tread circle's middle from the origin of the section, outward and up in the section, m; the axle's lean there, outer end up, rad.
    pub across: f64,
    pub lean: f64,
    pub high: f64,
    /// Tangent of the angle from the section's plane to the axle, forward where its outer end is, -.
    pub yaw: f64,
    /// Origin of the section from the wheelset's centre, m; along the rail, outward and up, unit.
    pub origin: Vector3<f64>,
    pub along: Vector3<f64>,
    pub outward: Vector3<f64>,
    pub up: Vector3<f64>,
    /// How far ahead of the section the tread circle's middle is, m (what is left).
    pub ahead: f64,
    /// Where the section is, along the track ahead of the wheelset's centre, m, and how much rail lies on a metre of it, -.
    pub station: f64,
    pub stretch: f64,
    /// How far the track's section leans along the rail, for a metre outward and up in it, -: where a rail runs aside or climbs they are not at right angles.
    pub shear: [f64; 2],
}

impl Standing {
    /// Of a pair whose rail has this section.
    pub fn new(pair: &Pair, section: &Section) -> Standing {
        let axle = pair.axes.column(1) * pair.wheel.side.sign();
        let middle = axle * pair.wheel.half_spacing;
        let [base, tangent, ..] = section.at(0.0);
        let station = (middle - base).dot(&tangent) / tangent.norm_squared();
        let [origin, tangent, outward, upward] = section.at(station);
        let stretch = tangent.norm();
        let along = tangent / stretch;
        let shear = [along.dot(&outward), along.dot(&upward)];
        let outward = (outward - along * shear[0]).normalize();
        let up = along.cross(&outward) * pair.wheel.side.sign();
        let from = middle - origin;
        let (out, rise) = (axle.dot(&outward), axle.dot(&up));
        Standing {
            across: from.dot(&outward),
            lean: rise.atan2(out),
            high: from.dot(&up),
            yaw: axle.dot(&along) / out.hypot(rise),
            origin,
            along,
            outward,
            up,
            ahead: from.dot(&along),
            station,
            stretch,
            shear,
        }
    }
}
