//! Names of bodies and design positions, as an entry of a module means them.

use super::SUSPENSION;
use super::expand::{Entry, Scope};
use crate::geometry::Side;
use crate::mbs::force::{Attachment, Places};
use crate::settings::{Section, SettingsError, did_you_mean};
use crate::units::Dimension;
use nalgebra::Vector3;

/// All bodies of a vehicle in the model's order.
pub(super) struct Bodies {
    pub names: Vec<String>,
    /// Design positions of the centres of mass, m.
    pub positions: Vec<Vector3<f64>>,
}

/// Reads names and positions for one entry.
#[derive(Clone, Copy)]
pub(super) struct Resolver<'f> {
    scopes: &'f [Scope],
    bodies: &'f Bodies,
    scope: usize,
    /// Where the `to` of an element between two copies of a module is.
    next: Option<usize>,
    side: Option<Side>,
}

impl<'f> Resolver<'f> {
    pub fn new(scopes: &'f [Scope], bodies: &'f Bodies, entry: &Entry) -> Self {
        Resolver { scopes, bodies, scope: entry.scope, next: entry.next, side: entry.side }
    }

    /// The resolver of one end of a force element.
    fn of_end(&self, key: &str) -> Self {
        Resolver { scope: self.next.filter(|_| key == "to").unwrap_or(self.scope), ..*self }
    }

    /// A vector of the entry as written, or mirrored for the right one of a pair.
    pub fn mirrored(&self, vector: Vector3<f64>) -> Vector3<f64> {
        match self.side {
            Some(Side::Right) => Vector3::new(vector.x, -vector.y, vector.z),
            _ => vector,
        }
    }

    /// Design position of a body's centre of mass, m.
    pub fn position(&self, body: usize) -> Vector3<f64> {
        self.bodies.positions[body]
    }

    /// The body that `section.key` names.
    pub fn body(&self, section: &Section, key: &'static str) -> Result<usize, SettingsError> {
        let name = section.text(key)?;
        self.find(&name).ok_or_else(|| {
            let own = &self.scopes[self.scope].prefix;
            let known: Vec<&str> = self.bodies.names.iter().map(|known| known.strip_prefix(own.as_str()).unwrap_or(known)).collect();
            section.error(key, format!("found \"{name}\"{}, expected a body: {}", did_you_mean(&name, &known), known.join(", ")))
        })
    }

    /// Here first, then in what surrounds the module.
    fn find(&self, name: &str) -> Option<usize> {
        let mut scope = Some(self.scope);
        while let Some(index) = scope {
            let full = format!("{}{name}", self.scopes[index].prefix);
            let sided = self.side.map(|side| format!("{full}.{}", side.name()));
            let found = sided.into_iter().chain([full]).find_map(|full| self.bodies.names.iter().position(|known| *known == full));
            if found.is_some() {
                return found;
            }
            scope = self.scopes[index].parent;
        }
        None
    }

    /// A point counted from the centre of the body that it is on, which it may not be far from.
    pub fn near(&self, section: &Section, key: &'static str, (body, point): (usize, Vector3<f64>)) -> Result<Vector3<f64>, SettingsError> {
        let local = point - self.position(body);
        if local.norm() <= FARTHEST {
            return Ok(local);
        }
        let problem = format!(
            "stands {:.0} m from the centre of {}; expected at most {FARTHEST} m: lengths are metres here, a distance in millimetres is written \"900 mm\"",
            local.norm(),
            self.bodies.names[body]
        );
        Err(section.error(key, problem))
    }

    /// The design position `section.key` in the vehicle's design frame, m.
    pub fn point(&self, section: &Section, key: &'static str) -> Result<Vector3<f64>, SettingsError> {
        Ok(self.placed(section.triple(key, Dimension::Length)?.into()))
    }

    /// The same, `None` when absent.
    pub fn optional_point(&self, section: &Section, key: &'static str) -> Result<Option<Vector3<f64>>, SettingsError> {
        Ok(section.optional_triple(key, Dimension::Length)?.map(|point| self.placed(point.into())))
    }

    fn placed(&self, point: Vector3<f64>) -> Vector3<f64> {
        self.scopes[self.scope].offset + self.mirrored(point)
    }
}

/// The places that a force element holds on to: `from` and `to`, each `{ body = "...", at = [x, y, z] }`, or the body's name alone
/// where the element gives one `at` for both; `"world"` is what does not move.
pub(super) struct ElementPlaces<'r> {
    pub resolver: &'r Resolver<'r>,
    /// The element's full name.
    pub name: &'r str,
}

/// No body of a railway vehicle reaches further from its centre than this, m.
const FARTHEST: f64 = 60.0;
/// The place that is no body.
const WORLD: &str = "world";

impl Places for ElementPlaces<'_> {
    fn attachment(&self, section: &Section, key: &'static str) -> Result<Attachment, SettingsError> {
        let shared = self.resolver.optional_point(section, "at")?;
        let resolver = self.resolver.of_end(key);
        let body = |section: &Section, key| match section.text(key)?.as_str() {
            WORLD => Ok(None),
            _ => resolver.body(section, key).map(Some),
        };
        let (body, point) = if section.has_table(key) {
            let place = section.section(key)?;
            let found = (body(&place, "body")?, resolver.optional_point(&place, "at")?.or(shared));
            place.finish()?;
            found
        } else {
            (body(section, key)?, shared)
        };
        let Some(point) = point else {
            let problem = "has no place; expected { body = \"NAME\", at = [x, y, z] }, or at = [x, y, z] for both ends of the element";
            return Err(section.error(key, problem));
        };
        let local = match body {
            Some(body) => resolver.near(section, key, (body, point))?,
            None => point,
        };
        Ok(Attachment { body, local })
    }

    fn body(&self, section: &Section, key: &'static str) -> Result<usize, SettingsError> {
        let own = self.name.strip_suffix(SUSPENSION).filter(|_| !section.has(key));
        match own.and_then(|own| self.resolver.bodies.names.iter().position(|name| name == own)) {
            Some(wheelset) => Ok(wheelset),
            None => self.resolver.body(section, key),
        }
    }

    fn design_vector(&self, from: &Attachment, to: &Attachment) -> Vector3<f64> {
        let point = |place: &Attachment| place.local + place.body.map_or_else(Vector3::zeros, |body| self.resolver.position(body));
        point(to) - point(from)
    }

    fn name(&self, _: &Section) -> Result<String, SettingsError> {
        Ok(self.name.into())
    }

    fn mirror(&self) -> f64 {
        self.resolver.mirrored(Vector3::y()).y
    }
}
