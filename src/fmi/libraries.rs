//! The shared libraries that go into an FMU, one for each platform, all built from the sources of this program.

use super::build_mark::{BUILD_MARK, MARK_PREFIX};
use super::platform::Platform;
use super::version::Version;
use std::path::{Path, PathBuf};

/// Why no library was taken.
#[derive(Debug, thiserror::Error)]
pub enum LibraryError {
    #[error(
        "no FMU library was found ({looked}); build it with `cargo build --release --lib`, or name it with --library {}=FILE",
        Platform::host().folder(Version::Two)
    )]
    NoLibrary { looked: String },
    #[error("{}: can't be read: {problem}", path.display())]
    Unreadable { path: PathBuf, problem: String },
    #[error("{}: {found}; build program and library from the same sources with `cargo build --release` (see CONTRIBUTING.md)", path.display())]
    OtherBuild { path: PathBuf, found: String },
    #[error("{}: this library is made for {found}, not for {said}", path.display())]
    WrongPlatform { path: PathBuf, found: String, said: String },
    #[error("{}: a second library for {platform}; an FMU holds one for each platform", path.display())]
    Twice { path: PathBuf, platform: String },
}

/// A library and what it is for.
#[derive(Clone, Debug)]
pub struct Library {
    pub platform: Platform,
    pub bytes: Vec<u8>,
}

impl Library {
    /// Where an FMU keeps it.
    pub fn path(&self, identifier: &str, version: Version) -> String {
        path(self.platform, identifier, version)
    }
}

/// Where an FMU keeps the library of a platform.
pub fn path(platform: Platform, identifier: &str, version: Version) -> String {
    format!("binaries/{}/{identifier}{}", platform.folder(version), platform.suffix())
}

/// A library as it is named on the command line: `PLATFORM=FILE`, or `FILE`, whose platform is what its header says.
#[derive(Clone, Debug, PartialEq)]
pub struct Named {
    platform: Option<Platform>,
    path: PathBuf,
}

impl Named {
    /// A library for whatever platform it is made for.
    pub fn file(path: &Path) -> Named {
        Named { platform: None, path: path.into() }
    }
}

impl std::str::FromStr for Named {
    type Err = String;

    fn from_str(text: &str) -> Result<Named, String> {
        match text.split_once('=') {
            Some((name, path)) => match Platform::named(name) {
                Some(platform) => Ok(Named { platform: Some(platform), path: path.into() }),
                // A file's name may contain "=".
                None if name.contains(['/', '\\', '.']) => Ok(Named::file(Path::new(text))),
                None => Err(format!("\"{name}\" is no platform; expected {}", Platform::names())),
            },
            None => Ok(Named::file(Path::new(text))),
        }
    }
}

/// File name of a shared library on this host.
fn library_name(stem: &str) -> String {
    format!("{}{stem}{}", if cfg!(windows) { "" } else { std::env::consts::DLL_PREFIX }, std::env::consts::DLL_SUFFIX)
}

/// The libraries of an FMU: those that are named, and for this host, where none of them is for it, the one in `deps/` next to the program, or else beside it. This host's comes first.
///
/// # Errors
/// [`LibraryError`] when there is none for this host, one can't be read, is of another build, is for another platform than is said, or two are for one platform.
pub fn find(named: &[Named]) -> Result<Vec<Library>, LibraryError> {
    let mut libraries: Vec<Library> = Vec::new();
    for one in named {
        for library in read(one)? {
            if libraries.iter().any(|other| other.platform == library.platform) {
                return Err(LibraryError::Twice { path: one.path.clone(), platform: library.platform.folder(Version::Two) });
            }
            libraries.push(library);
        }
    }
    let host = Platform::host();
    match libraries.iter().position(|library| library.platform == host) {
        Some(place) => libraries[..=place].rotate_right(1),
        None => libraries.insert(0, own(host)?),
    }
    Ok(libraries)
}

/// The library next to this program.
fn own(host: Platform) -> Result<Library, LibraryError> {
    let name = library_name("wheelrail");
    let folder = std::env::current_exe().ok().and_then(|program| program.parent().map(Path::to_path_buf)).unwrap_or_default();
    let candidates = [folder.join("deps").join(&name), folder.join(&name)];
    let path = candidates.iter().find(|path| path.is_file()).ok_or_else(|| LibraryError::NoLibrary {
        looked: candidates.iter().map(|path| path.display().to_string()).collect::<Vec<_>>().join(", "),
    })?;
    let named = Named { platform: Some(host), path: path.clone() };
    read(&named)?.into_iter().next().ok_or_else(|| other(path, format!("this is no library for {}", host.folder(Version::Two))))
}

fn other(path: &Path, found: String) -> LibraryError {
    LibraryError::OtherBuild { path: path.into(), found }
}

/// A file once for each platform that it is made for, or for the one that is named.
fn read(named: &Named) -> Result<Vec<Library>, LibraryError> {
    let path = &named.path;
    let bytes = std::fs::read(path).map_err(|error| LibraryError::Unreadable { path: path.clone(), problem: error.to_string() })?;
    check_build(&bytes).map_err(|found| other(path, found))?;
    let mut platforms = Platform::of_library(&bytes).map_err(|found| other(path, found))?;
    if let Some(platform) = named.platform {
        if !platforms.contains(&platform) {
            let found: Vec<String> = platforms.iter().map(|platform| platform.folder(Version::Two)).collect();
            return Err(LibraryError::WrongPlatform {
                path: path.clone(),
                found: found.join(" and "),
                said: platform.folder(Version::Two),
            });
        }
        platforms = vec![platform];
    }
    Ok(platforms.into_iter().map(|platform| Library { platform, bytes: bytes.clone() }).collect())
}

/// Is this a library of the same build?
fn check_build(bytes: &[u8]) -> Result<(), String> {
    let contains = |needle: &[u8]| bytes.windows(needle.len()).any(|window| window == needle);
    if contains(BUILD_MARK.as_bytes()) {
        Ok(())
    } else if contains(MARK_PREFIX) {
        Err("this library was built from other sources than this program".into())
    } else {
        Err("this is not an FMU library of wheelrail".into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A PE library for x86-64 with this build's mark, or another.
    fn library(mark: &str) -> tempfile::NamedTempFile {
        let mut bytes = vec![0_u8; 0x100];
        bytes[..2].copy_from_slice(b"MZ");
        bytes[0x3c] = 0x80;
        bytes[0x80..0x86].copy_from_slice(b"PE\0\0\x64\x86");
        bytes[0x97] = 0x20;
        bytes.extend_from_slice(mark.as_bytes());
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), bytes).unwrap();
        file
    }

    fn named(text: &str) -> Named {
        text.parse().unwrap_or_else(|error| panic!("{text}: {error}"))
    }

    #[test]
    fn prop_libraries_are_named_by_platform_and_file_or_file_alone() {
        assert_eq!(named("win64=a/b=c.dll"), Named { platform: Platform::named("win64"), path: "a/b=c.dll".into() });
        assert_eq!(named("aarch64-linux=x.so").platform, Platform::named("aarch64-linux"));
        for file in ["libwheelrail.so", "./a=b.so", "dir/a=b"] {
            assert_eq!(named(file), Named::file(Path::new(file)));
        }
        let message = "windows=x.dll".parse::<Named>().unwrap_err();
        assert!(message.contains("\"windows\" is no platform") && message.contains("win64") && message.contains("aarch64"), "{message}");
    }

    #[test]
    fn prop_libraries_of_other_platforms_and_builds_are_told_apart() {
        let good = library(BUILD_MARK);
        let path = good.path().to_str().unwrap();
        for text in [path.to_string(), format!("win64={path}"), format!("x86_64-windows={path}")] {
            let found = read(&named(&text)).unwrap();
            assert_eq!(found.len(), 1);
            assert_eq!(found[0].path("s", Version::Two), "binaries/win64/s.dll");
            assert_eq!(found[0].path("s", Version::Three), "binaries/x86_64-windows/s.dll");
        }
        let refused = |result: Result<Vec<Library>, LibraryError>| result.unwrap_err().to_string();
        let message = refused(read(&named(&format!("linux64={path}"))));
        assert!(message.contains("made for win64") && message.contains("linux64"), "{message}");
        let twice = refused(find(&[named(path), named(&format!("win64={path}"))]));
        assert!(twice.contains("second library for win64"), "{twice}");
        let other = library("wheelrail-build-id:000000000000000000000000:");
        assert!(refused(read(&Named::file(other.path()))).contains("other sources"));
        assert!(refused(read(&named("win64=/no/such/file"))).contains("can't be read"));
    }
}
