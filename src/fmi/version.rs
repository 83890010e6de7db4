//! The versions of FMI that an FMU may be made for.

/// Version of the standard.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Version {
    /// FMI 2.0.
    #[default]
    Two,
    /// FMI 3.0.
    Three,
}

impl Version {
    /// As modelDescription.xml says it.
    pub fn name(self) -> &'static str {
        match self {
            Version::Two => "2.0",
            Version::Three => "3.0",
        }
    }

    /// Name of this host's platform folder: one word in FMI 2.0, architecture and system in FMI 3.0.
    pub fn platform(self) -> &'static str {
        let wide = cfg!(target_pointer_width = "64");
        match (self, cfg!(target_os = "windows"), cfg!(target_os = "macos")) {
            (Version::Two, true, _) if wide => "win64",
            (Version::Two, true, _) => "win32",
            (Version::Two, _, true) => "darwin64",
            (Version::Two, ..) if wide => "linux64",
            (Version::Two, ..) => "linux32",
            (Version::Three, true, _) => of_architecture("x86_64-windows", "x86-windows", "aarch64-windows"),
            (Version::Three, _, true) => of_architecture("x86_64-darwin", "x86-darwin", "aarch64-darwin"),
            (Version::Three, ..) => of_architecture("x86_64-linux", "x86-linux", "aarch64-linux"),
        }
    }
}

/// That of this host's architecture.
fn of_architecture(wide: &'static str, narrow: &'static str, arm: &'static str) -> &'static str {
    match std::env::consts::ARCH {
        "aarch64" => arm,
        "x86" => narrow,
        _ => wide,
    }
}
