//! A scene as it is packed.

use super::description::Description;
use super::variables::VariableTable;
use crate::scene::spec::Scene;
use std::collections::BTreeMap;

/// A scene as it stands in an FMU: its text names itself and its files lie in folders, one for each kind.
pub struct PackedScene {
    pub scene: Scene,
    pub table: VariableTable,
    pub description: Description,
    /// Path below resources/ and content.
    pub resources: BTreeMap<String, Vec<u8>>,
}
