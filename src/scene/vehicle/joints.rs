//! `[[vehicle.joint]]`: `first` and `second` (bodies), `at` (design position) and, where a kind has axes, `axis` (of both, or of
//! the first) and `second_axis` (universal joint), as vectors in the design frame.

use super::places::Resolver;
use crate::mbs::joint::{Axes, Joint, Place, REGISTRY};
use crate::mbs::kkt::RowBodies;
use crate::settings::{Section, SettingsError, choose};
use crate::units::Dimension;
use nalgebra::Vector3;

/// Reads one joint.
pub(super) fn read(name: &str, section: &Section, resolver: &Resolver) -> Result<Joint, SettingsError> {
    let (axes, build) = choose(REGISTRY, section, "kind")?.parse;
    let (first, second) = (resolver.body(section, "first")?, resolver.body(section, "second")?);
    if first == second {
        return Err(section.error("second", "is the first body; expected another one"));
    }
    let point = resolver.point(section, "at")?;
    let axis = |key: &'static str| -> Result<Vector3<f64>, SettingsError> {
        let axis: Vector3<f64> = section.triple(key, Dimension::None)?.into();
        if axis.norm() < 1e-9 {
            return Err(section.error(key, "found a vector of length 0, expected a direction"));
        }
        Ok(resolver.mirrored(axis))
    };
    let place = |body: usize, axis: Option<&Vector3<f64>>| {
        let local = point - resolver.position(body);
        axis.map_or(Place::at(local), |axis| Place::along(local, axis))
    };
    let (one, two) = match axes {
        Axes::None => (None, None),
        Axes::One => {
            let both = axis("axis")?;
            (Some(both), Some(both))
        }
        Axes::Crossed => {
            let (one, two) = (axis("axis")?, axis("second_axis")?);
            if one.normalize().dot(&two.normalize()).abs() > 1e-6 {
                return Err(section.error("second_axis", "is not across axis; expected a vector at a right angle to it"));
            }
            (Some(one), Some(two))
        }
    };
    let bodies = RowBodies { first, second: Some(second) };
    Ok(build(name, bodies, &place(first, one.as_ref()), &place(second, two.as_ref())))
}
