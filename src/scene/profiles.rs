//! Profiles of both sides.

use crate::geometry::profile::{self, Part, ProfileChoice};
use crate::settings::{Section, SettingsError};

/// One table for both sides, or one for each.
pub(super) fn read_profiles(
    section: &Section,
    [both, left, right]: [&'static str; 3],
    part: Part,
) -> Result<[ProfileChoice; 2], SettingsError> {
    let (own_left, own_right) = (section.optional_section(left)?, section.optional_section(right)?);
    if let (Some(left), Some(right)) = (own_left, own_right) {
        // A template's common table may be there.
        if section.has_own(both) {
            return Err(section.error(both, "each side has its own table: this one serves nothing"));
        }
        return Ok([profile::parse(left, part)?, profile::parse(right, part)?]);
    }
    let shared = profile::parse(section.section(both)?, part)?;
    let own = |key| section.optional_section(key)?.map(|own| profile::parse(own, part)).transpose();
    Ok([own(left)?.unwrap_or(shared.clone()), own(right)?.unwrap_or(shared)])
}
