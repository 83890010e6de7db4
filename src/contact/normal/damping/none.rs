//! No contact damping.

use super::{Approach, DampingLaw, DampingSlopes};
use crate::settings::Entry;
use std::sync::Arc;

pub(super) const ENTRY: Entry<super::Parse> =
    Entry { name: "none", summary: "no contact damping", reference: "-", parse: |_| Ok((0.0, Arc::new(|_| Box::new(Undamped)))) };

#[derive(Clone, Copy, Debug)]
struct Undamped;

impl DampingLaw for Undamped {
    fn force(&self, _: &Approach) -> f64 {
        0.0
    }

    fn slopes(&self, _: &Approach) -> DampingSlopes {
        DampingSlopes::default()
    }

    fn describe(&self) -> String {
        "none".into()
    }
}
