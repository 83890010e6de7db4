//! Scenes that the program carries with it.

/// A scene's name and text.
pub struct EmbeddedScene {
    pub name: &'static str,
    pub text: &'static str,
}

/// Every embedded scene; tests walk this list.
pub static SCENES: &[EmbeddedScene] = &[
    EmbeddedScene { name: "suspended_wheelset", text: include_str!("../../fmu/scenes/suspended_wheelset.toml") },
    EmbeddedScene { name: "wheelset_s1002", text: include_str!("../../fmu/scenes/wheelset_s1002.toml") },
    EmbeddedScene { name: "wheelset_standstill", text: include_str!("../../fmu/scenes/wheelset_standstill.toml") },
    EmbeddedScene { name: "bogie", text: include_str!("../../fmu/scenes/bogie.toml") },
    EmbeddedScene { name: "vehicle_manchester_1", text: include_str!("../../fmu/scenes/vehicle_manchester_1.toml") },
    EmbeddedScene { name: "vehicle_equalised", text: include_str!("../../fmu/scenes/vehicle_equalised.toml") },
    EmbeddedScene { name: "vehicle_bumps", text: include_str!("../../fmu/scenes/vehicle_bumps.toml") },
    EmbeddedScene { name: "vehicle_curve", text: include_str!("../../fmu/scenes/vehicle_curve.toml") },
    EmbeddedScene { name: "train", text: include_str!("../../fmu/scenes/train.toml") },
];

/// The embedded scene of that name.
pub fn find(name: &str) -> Option<&'static EmbeddedScene> {
    SCENES.iter().find(|scene| scene.name == name)
}
