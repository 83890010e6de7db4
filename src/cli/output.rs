//! Where results go. A file is whole or untouched: it is written beside its place and takes it at the end, through symbolic links; what is no
//! file (a device, a pipe, standard output) is written as it comes. Nothing that can't be written is passed over in silence, but for a reader
//! that has seen enough (`| head`).

use std::fs::{File, OpenOptions};
use std::io::{BufWriter, ErrorKind, Write};
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;

/// Why a result can't be kept.
#[derive(Debug, thiserror::Error)]
pub(super) enum OutputError {
    #[error("{}: can't be written: there is no folder {}; make the folder first", path.display(), folder.display())]
    NoFolder { path: PathBuf, folder: PathBuf },
    #[error("{}: can't be written: it is {found}, expected a file", path.display())]
    NoFile { path: PathBuf, found: &'static str },
    #[error("{}: can't be written: {}; expected a name that ends in {known}", path.display(), ending_words(ending))]
    Ending { path: PathBuf, ending: String, known: &'static str },
    #[error("{}: can't be written: its symbolic links lead nowhere", path.display())]
    Links { path: PathBuf },
    #[error("{}: can't be written: {problem}", path.display())]
    Unwritable { path: PathBuf, problem: std::io::Error },
    #[error("{}: can't be written: {problem}; what was written until then is in {}", path.display(), part.display())]
    Part { path: PathBuf, part: PathBuf, problem: std::io::Error },
    #[error("standard output: can't be written: {problem}")]
    Stdout { problem: std::io::Error },
}

fn ending_words(ending: &str) -> String {
    format!("nothing is written as .{ending}")
}

/// What a file may be.
#[derive(Clone, Copy)]
pub(super) enum Kind {
    /// Rows of text; may go to "-", a device or a pipe.
    Csv,
    /// Rows of a run: CSV, which may go to "-", a device or a pipe, or by the file's ending Parquet or MAT.
    Results,
    /// Columns of a sweep, in a file and nothing else.
    Parquet,
    /// Text of any ending.
    Text,
    /// A picture.
    Svg,
    /// A page for a browser.
    Html,
    /// A file and nothing else.
    Fmu,
    /// A system of FMUs: the same.
    Ssp,
    /// A table of creep forces: the same.
    Binary,
}

impl Kind {
    /// The endings that its files have, and how they are named; one that another kind of file has would deceive whoever opens it.
    fn endings(self) -> Option<(&'static [&'static str], &'static str)> {
        match self {
            Kind::Csv => Some((&["csv"], ".csv")),
            Kind::Results => Some((&["csv", "parquet", "mat"], ".csv, .parquet or .mat")),
            Kind::Parquet => Some((&["parquet"], ".parquet")),
            Kind::Fmu => Some((&["fmu"], ".fmu")),
            Kind::Ssp => Some((&["ssp"], ".ssp")),
            Kind::Svg => Some((&["svg"], ".svg")),
            Kind::Html => Some((&["html", "htm"], ".html")),
            Kind::Text | Kind::Binary => None,
        }
    }

    fn may_stream(self) -> bool {
        matches!(self, Kind::Csv | Kind::Results | Kind::Text | Kind::Svg | Kind::Html)
    }
}

/// Where a result will go, known to be writable.
#[derive(Debug)]
pub(super) struct Target {
    /// As the user named it.
    path: PathBuf,
    place: Place,
}

#[derive(Clone, Debug)]
enum Place {
    Stdout,
    /// A device or a pipe.
    Stream,
    /// Behind all links, and whether it must be written where it stands because its folder takes no new files.
    File {
        path: PathBuf,
        in_place: bool,
    },
}

impl Target {
    /// Finds out where `path` leads and whether it can be written, and changes nothing there. "-" is standard output.
    ///
    /// # Errors
    /// [`OutputError`]: better known before the work than after it.
    pub fn find(path: &Path, kind: Kind) -> Result<Target, OutputError> {
        let found = |place| Ok(Target { path: path.into(), place });
        if kind.may_stream() && path == Path::new("-") {
            return found(Place::Stdout);
        }
        match std::fs::metadata(path) {
            Ok(there) if there.is_dir() => return Err(OutputError::NoFile { path: path.into(), found: "a folder" }),
            Ok(there) if !there.is_file() => return stream(path, kind),
            _ => {}
        }
        let Some(file) = follow(path)? else { return stream(path, kind) };
        if let (Some((right, known)), Some(ending)) = (kind.endings(), path.extension())
            && !right.iter().any(|right| ending.eq_ignore_ascii_case(right))
        {
            return Err(OutputError::Ending { path: path.into(), ending: ending.to_string_lossy().into_owned(), known });
        }
        let exists = file.exists();
        if exists {
            OpenOptions::new().write(true).open(&file).map_err(|error| unwritable(path, error))?;
        }
        match beside(&file) {
            Ok(_) => found(Place::File { path: file, in_place: false }),
            Err(_) if exists => found(Place::File { path: file, in_place: true }),
            Err(error) => Err(unwritable(path, error)),
        }
    }

    /// As the user named it.
    pub fn path(&self) -> &Path {
        &self.path
    }

    pub fn is_stdout(&self) -> bool {
        matches!(self.place, Place::Stdout)
    }

    /// Is it a file, neither standard output nor a device or a pipe?
    pub fn is_plain_file(&self) -> bool {
        matches!(self.place, Place::File { .. })
    }

    /// Begins to write: until [`Pending::finish`] a file keeps what it has.
    ///
    /// # Errors
    /// [`OutputError`].
    pub fn begin(&self) -> Result<Pending, OutputError> {
        let failed = |problem| unwritable(&self.path, problem);
        let sink = match &self.place {
            Place::Stdout => Sink::Stdout(std::io::stdout()),
            Place::Stream => Sink::File(OpenOptions::new().write(true).open(&self.path).map_err(failed)?),
            Place::File { path, in_place: true } => Sink::File(File::create(path).map_err(failed)?),
            Place::File { path, in_place: false } => Sink::Beside(Box::new(beside(path).map_err(failed)?), path.clone()),
        };
        Ok(Pending { path: self.path.clone(), out: BufWriter::with_capacity(1 << 16, sink) })
    }

    /// Writes all of it.
    ///
    /// # Errors
    /// [`OutputError`]; a closed pipe is none.
    pub fn write(&self, bytes: &[u8]) -> Result<(), OutputError> {
        let mut pending = self.begin()?;
        match pending.write_all(bytes) {
            Ok(()) => pending.finish(),
            Err(error) => pending.fail(error),
        }
    }
}

/// Do both names lead to the same file that is there?
pub(super) fn same_file(one: &Path, other: &Path) -> bool {
    one.canonicalize().ok().is_some_and(|one| other.canonicalize().ok() == Some(one))
}

/// Writes a whole file of any ending.
///
/// # Errors
/// [`OutputError`].
pub(super) fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), OutputError> {
    Target::find(path, Kind::Text)?.write(bytes)
}

fn unwritable(path: &Path, problem: std::io::Error) -> OutputError {
    let folder = path.parent().filter(|folder| problem.kind() == ErrorKind::NotFound && !folder.exists());
    match folder {
        Some(folder) => OutputError::NoFolder { path: path.into(), folder: folder.into() },
        None => OutputError::Unwritable { path: path.into(), problem },
    }
}

fn stream(path: &Path, kind: Kind) -> Result<Target, OutputError> {
    if !kind.may_stream() {
        return Err(OutputError::NoFile { path: path.into(), found: "a device, a pipe or a socket" });
    }
    Ok(Target { path: path.into(), place: Place::Stream })
}

/// The file behind all symbolic links, there already or not; `None` where they lead to a file of this process (`/dev/stdout`).
fn follow(path: &Path) -> Result<Option<PathBuf>, OutputError> {
    const MOST_LINKS: usize = 40;
    let mut file = path.to_path_buf();
    for _ in 0..MOST_LINKS {
        if file.starts_with("/proc") {
            return Ok(None);
        }
        match std::fs::read_link(&file) {
            // An absolute link takes the place of the whole path.
            Ok(link) => file = file.parent().unwrap_or(Path::new("")).join(link),
            Err(_) => return Ok(Some(file)),
        }
    }
    Err(OutputError::Links { path: path.into() })
}

/// A new file beside another one: `results.csv.Ab12Cd.part`. It goes away unless it is kept; after a kill it is what was computed until then.
fn beside(path: &Path) -> std::io::Result<NamedTempFile> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut name = path.file_name().unwrap_or_default().to_os_string();
    name.push(".");
    let mut builder = tempfile::Builder::new();
    builder.prefix(&name).suffix(".part");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        // Those of the file that it replaces, else those of any new file: the system takes away what the user's mask forbids.
        let there = std::fs::metadata(path).map_or(0o666, |there| there.permissions().mode());
        builder.permissions(std::fs::Permissions::from_mode(there & 0o777));
    }
    builder.tempfile_in(folder)
}

enum Sink {
    Stdout(std::io::Stdout),
    File(File),
    /// A file beside its place, and that place.
    Beside(Box<NamedTempFile>, PathBuf),
}

impl Write for Sink {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        match self {
            Sink::Stdout(out) => out.write(bytes),
            Sink::File(file) => file.write(bytes),
            Sink::Beside(file, _) => file.as_file_mut().write(bytes),
        }
    }

    fn flush(&mut self) -> std::io::Result<()> {
        match self {
            Sink::Stdout(out) => out.flush(),
            Sink::File(file) => file.flush(),
            Sink::Beside(file, _) => file.as_file_mut().flush(),
        }
    }
}

/// A result that is being written.
pub(super) struct Pending {
    path: PathBuf,
    out: BufWriter<Sink>,
}

impl Write for Pending {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.out.write(bytes)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        self.out.flush()
    }
}

impl Pending {
    /// Writes what is left; a file takes its place.
    ///
    /// # Errors
    /// [`OutputError`]; a closed pipe is none.
    pub fn finish(mut self) -> Result<(), OutputError> {
        if let Err(error) = self.out.flush() {
            return self.fail(error);
        }
        let (sink, _) = self.out.into_parts();
        let Sink::Beside(file, place) = sink else { return Ok(()) };
        // Some systems say only here that the disk is full.
        if let Err(problem) = file.as_file().sync_all() {
            return Err(kept(self.path, *file, problem));
        }
        match file.persist(&place) {
            Ok(_) => Ok(()),
            Err(error) => Err(kept(self.path, error.file, error.error)),
        }
    }

    /// What a failure to write means: nothing where a reader has seen enough, else an error; what could be written stays beside its place.
    ///
    /// # Errors
    /// [`OutputError`].
    pub fn fail(self, problem: std::io::Error) -> Result<(), OutputError> {
        // The rest of the buffer is not tried again.
        let (sink, _) = self.out.into_parts();
        match sink {
            _ if problem.kind() == ErrorKind::BrokenPipe => Ok(()),
            Sink::Stdout(_) => Err(OutputError::Stdout { problem }),
            Sink::File(_) => Err(OutputError::Unwritable { path: self.path, problem }),
            Sink::Beside(file, _) => Err(kept(self.path, *file, problem)),
        }
    }
}

fn kept(path: PathBuf, file: NamedTempFile, problem: std::io::Error) -> OutputError {
    match file.keep() {
        Ok((_, part)) => OutputError::Part { path, part, problem },
        Err(_) => OutputError::Unwritable { path, problem },
    }
}

/// Prints to stdout.
///
/// # Errors
/// [`OutputError::Stdout`]; a closed pipe is none.
pub(super) fn print(text: &str) -> Result<(), OutputError> {
    let mut out = std::io::stdout();
    // What stays in a buffer at the end of the program would be lost in silence.
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(problem) if problem.kind() != ErrorKind::BrokenPipe => Err(OutputError::Stdout { problem }),
        _ => Ok(()),
    }
}

#[cfg(test)]
#[cfg(unix)]
mod tests {
    use super::*;
    use std::os::unix::fs::symlink;

    #[test]
    fn prop_a_file_keeps_what_it_has_until_the_end() {
        let folder = tempfile::tempdir().unwrap();
        let (file, link) = (folder.path().join("a.csv"), folder.path().join("link.csv"));
        std::fs::write(&file, "old").unwrap();
        symlink("a.csv", &link).unwrap();
        let read = || std::fs::read_to_string(&file).unwrap();
        let mut pending = Target::find(&link, Kind::Csv).unwrap().begin().unwrap();
        pending.write_all(b"new").unwrap();
        pending.flush().unwrap();
        assert_eq!(read(), "old");
        drop(pending);
        assert_eq!((read().as_str(), std::fs::read_dir(folder.path()).unwrap().count()), ("old", 2), "what is given up leaves nothing");
        Target::find(&link, Kind::Csv).unwrap().write(b"new").unwrap();
        assert_eq!((read().as_str(), std::fs::read_link(&link).unwrap().to_str()), ("new", Some("a.csv")));
        // A link to a file that is not there yet.
        symlink("b.csv", folder.path().join("ahead.csv")).unwrap();
        Target::find(&folder.path().join("ahead.csv"), Kind::Csv).unwrap().write(b"b").unwrap();
        assert_eq!(std::fs::read_to_string(folder.path().join("b.csv")).unwrap(), "b");
    }

    #[test]
    fn prop_what_is_no_file_is_refused_or_streamed() {
        let folder = tempfile::tempdir().unwrap();
        let refused = |path: &Path, kind| Target::find(path, kind).unwrap_err();
        assert!(matches!(refused(folder.path(), Kind::Csv), OutputError::NoFile { found: "a folder", .. }));
        assert!(matches!(refused(Path::new("/dev/null"), Kind::Fmu), OutputError::NoFile { .. }));
        assert!(matches!(refused(&folder.path().join("no/x.csv"), Kind::Csv), OutputError::NoFolder { .. }));
        let parquet = refused(&folder.path().join("x.parquet"), Kind::Csv).to_string();
        assert!(parquet.contains("nothing is written as .parquet; expected a name that ends in .csv"), "{parquet}");
        let circle = folder.path().join("circle.csv");
        symlink("circle.csv", &circle).unwrap();
        assert!(matches!(refused(&circle, Kind::Csv), OutputError::Links { .. }));
        Target::find(Path::new("/dev/null"), Kind::Csv).unwrap().write(b"x").unwrap();
        if Path::new("/dev/full").exists() {
            let full = Target::find(Path::new("/dev/full"), Kind::Csv).unwrap().write(b"x");
            assert!(matches!(full, Err(OutputError::Unwritable { .. })), "{full:?}");
        }
    }
}
