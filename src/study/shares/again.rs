//! Laws that are called again and again: what that takes longer is what the law costs where it stands.
//!
//! A law takes some 50 to 500 ns per call, too short for a clock around each call. A model whose law does its work [`EXTRA`] times more, with the same
//! result, takes longer by as many times the law's cost, with the arguments, the order and the caches of a real evaluation.

use crate::contact::creep::slopes::CreepSlopes;
use crate::contact::creep::{CreepLaw, RollingContact};
use crate::contact::creepage::CreepForce;
use crate::contact::normal::damping::{Approach, DampingLaw, DampingSlopes};
use crate::contact::normal::{ConformalContact, ContactShape, ElasticContact, NormalLaw};
use crate::scene::spec::Scene;
use std::hint::black_box;
use std::sync::Arc;

/// Further calls per call.
pub(super) const EXTRA: usize = 4;

#[derive(Debug)]
struct Again<L: ?Sized> {
    law: Box<L>,
}

impl<L: ?Sized> Again<L> {
    fn again<T>(&self, call: impl Fn(&L) -> T) -> T {
        for _ in 0..EXTRA {
            black_box(call(black_box(&self.law)));
        }
        call(&self.law)
    }
}

impl NormalLaw for Again<dyn NormalLaw> {
    fn contact(&self, shape: &ContactShape, penetration: f64) -> Result<ElasticContact, ConformalContact> {
        self.again(|law| law.contact(shape, penetration))
    }

    fn contact_under(&self, shape: &ContactShape, force: f64) -> Result<(f64, ElasticContact), ConformalContact> {
        self.again(|law| law.contact_under(shape, force))
    }

    fn describe(&self) -> String {
        self.law.describe()
    }
}

impl DampingLaw for Again<dyn DampingLaw> {
    fn force(&self, approach: &Approach) -> f64 {
        self.again(|law| law.force(approach))
    }

    fn slopes(&self, approach: &Approach) -> DampingSlopes {
        self.law.slopes(approach)
    }

    fn describe(&self) -> String {
        self.law.describe()
    }
}

impl CreepLaw for Again<dyn CreepLaw> {
    fn force(&self, contact: &RollingContact) -> CreepForce {
        self.again(|law| law.force(contact))
    }

    fn slopes(&self, contact: &RollingContact, force: &CreepForce) -> CreepSlopes {
        self.law.slopes(contact, force)
    }
}

/// The scene with its normal and damping laws called again.
pub(super) fn normal_again(scene: &Scene) -> Scene {
    let mut changed = scene.clone();
    let (normal, damping) = (scene.contact.normal.clone(), scene.contact.damping_law.build.clone());
    changed.contact.normal = Arc::new(move |material| Box::new(Again { law: normal(material) }));
    changed.contact.damping_law.build = Arc::new(move |constant| Box::new(Again { law: damping(constant) }));
    changed
}

/// The scene with its creep law called again.
pub(super) fn creep_again(scene: &Scene) -> Scene {
    let mut changed = scene.clone();
    let creep = scene.contact.creep.clone();
    changed.contact.creep = Arc::new(move |material| Box::new(Again { law: creep(material) }));
    changed
}
