//! Where tables of patches are kept: beside a scene (an FMU's resources), and in the user's cache folder from run to run.
//!
//! The cache is `$WHEELRAIL_CACHE`, else `$XDG_CACHE_HOME/wheelrail`, `%LOCALAPPDATA%\\wheelrail` or `~/.cache/wheelrail`. A file is called by the hash of all that its table
//! depends on and ends with a sum of its content: what is missing, old or damaged is made anew. A folder that can't be written is no error.

use crate::contact::strips::PatchTable;
use crate::formulation::patch_tables::TableStore;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

/// Folder of an FMU's resources in which its tables are.
pub const FOLDER: &str = "tables";
/// Bytes of the sum at the end.
const SUM: usize = 4;

/// Is somebody at the terminal who wants to know what takes seconds?
static TELL: AtomicBool = AtomicBool::new(false);

/// From now on what takes seconds is said on stderr.
pub fn tell() {
    TELL.store(true, Ordering::Relaxed);
}

/// Files in folders.
#[derive(Debug)]
pub struct FileStore {
    beside: Option<PathBuf>,
    cache: Option<PathBuf>,
}

impl FileStore {
    /// Of a scene in a folder.
    pub fn of(folder: Option<&Path>) -> FileStore {
        FileStore { beside: folder.map(|folder| folder.join(FOLDER)), cache: cache_folder() }
    }
}

fn cache_folder() -> Option<PathBuf> {
    let named = |key: &str| std::env::var_os(key).filter(|value| !value.is_empty()).map(PathBuf::from);
    named("WHEELRAIL_CACHE")
        .or_else(|| ["XDG_CACHE_HOME", "LOCALAPPDATA"].iter().find_map(|key| named(key)).map(|folder| folder.join("wheelrail")))
        .or_else(|| named("HOME").map(|home| home.join(".cache").join("wheelrail")))
}

/// Name of the file of a table.
pub fn file_name(key: &str) -> String {
    format!("patches-{key}.bin")
}

/// What its file holds.
pub fn to_bytes(table: &PatchTable) -> Vec<u8> {
    let mut bytes = postcard::to_stdvec(table).unwrap_or_default();
    let sum = sum_of(&bytes);
    bytes.extend_from_slice(&sum);
    bytes
}

/// Against damage, not against malice; a hash of 10 MB that is any safer takes longer than a run.
fn sum_of(content: &[u8]) -> [u8; SUM] {
    crc32fast::hash(content).to_le_bytes()
}

fn from_file(path: &Path) -> Option<PatchTable> {
    let bytes = std::fs::read(path).ok()?;
    let (content, sum) = bytes.split_at_checked(bytes.len().checked_sub(SUM)?)?;
    if sum_of(content) != sum {
        return None;
    }
    postcard::from_bytes(content).ok().filter(PatchTable::is_whole)
}

impl TableStore for FileStore {
    fn find(&self, key: &str) -> Option<PatchTable> {
        [&self.beside, &self.cache].into_iter().flatten().find_map(|folder| from_file(&folder.join(file_name(key))))
    }

    fn begin(&self, what: &str) {
        if TELL.load(Ordering::Relaxed) {
            let kept = self.cache.as_ref().map_or("not kept: no cache folder".into(), |folder| format!("kept in {}", folder.display()));
            eprintln!("making the table of patches of {what}; takes some seconds, once ({kept})");
        }
    }

    fn keep(&self, key: &str, table: &PatchTable) {
        let Some(folder) = &self.cache else { return };
        let written = std::fs::create_dir_all(folder).and_then(|()| {
            let mut file = tempfile::NamedTempFile::new_in(folder)?;
            file.write_all(&to_bytes(table))?;
            file.persist(folder.join(file_name(key))).map_err(|error| error.error)?;
            Ok(())
        });
        if let (Err(error), true) = (written, TELL.load(Ordering::Relaxed)) {
            eprintln!("the table is not kept: {}: {error}", folder.display());
        }
    }
}
