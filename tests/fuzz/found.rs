//! What was found once, by its name.
