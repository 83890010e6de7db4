//! `wheelrail scene NAME`: the text of an embedded scene, to start an own one from.

use super::{Failure, print};
use crate::scene::embedded;
use crate::scene::load::SceneError;
use clap::Args;

#[derive(Args)]
#[command(after_help = "Example: wheelrail scene suspended_wheelset > my.toml, then wheelrail run my.toml")]
pub(super) struct Arguments {
    /// Name of an embedded scene (see `wheelrail list scenes`)
    name: String,
}

pub(super) fn scene(arguments: &Arguments) -> Result<(), Failure> {
    let scene = embedded::find(&arguments.name).ok_or_else(|| SceneError::unknown(&arguments.name))?;
    Ok(print(scene.text)?)
}
