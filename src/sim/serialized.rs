//! Saved states of FMUs and checkpoints of runs as bytes: a header that proves where they come from, then the state itself.
//!
//! Layout (little endian): magic (8), format version (4), GUID (38), payload length (8), CRC-32 of all before and of
//! the payload (4), payload. A blob that fails any check is refused; memory is never copied raw. (The sum finds damage; against intent no sum
//! without a key would help, so that whatever is read is checked for sense.)

use serde::Serialize;
use serde::de::DeserializeOwned;

const MAGIC: &[u8; 8] = b"WHEELRL\x01";
const VERSION: u32 = 19;
const GUID_LENGTH: usize = 38;
const SUM: usize = 4;
const HEADER: usize = MAGIC.len() + 4 + GUID_LENGTH + 8 + SUM;

/// Why bytes are not a state of this FMU.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum BlobError {
    #[error("the serialised state is {found} bytes long, expected {expected}")]
    Length { found: usize, expected: usize },
    #[error("these bytes are not a serialised state of this program")]
    Magic,
    #[error("the serialised state has format version {0}, expected {VERSION}")]
    Version(u32),
    #[error("the serialised state belongs to another FMU (GUID {0})")]
    Guid(String),
    #[error("the serialised state is damaged: its checksum does not match")]
    Checksum,
    #[error("the serialised state can't be read: {0}")]
    Payload(String),
}

fn checksum(head: &[u8], payload: &[u8]) -> [u8; SUM] {
    let mut sum = crc32fast::Hasher::new();
    sum.update(head);
    sum.update(payload);
    sum.finalize().to_le_bytes()
}

/// Length of the serialised state at the beginning of bytes, as its header has it; `None` where the header is cut off.
pub fn length(bytes: &[u8]) -> Option<usize> {
    let payload = bytes.get(HEADER - SUM - 8..HEADER - SUM)?;
    usize::try_from(u64::from_le_bytes(payload.try_into().ok()?)).ok()?.checked_add(HEADER)
}

/// Writes a state; the same state gives the same bytes.
///
/// # Errors
/// [`BlobError::Payload`] when the state cannot be encoded.
pub fn write<T: Serialize>(guid: &str, state: &T) -> Result<Vec<u8>, BlobError> {
    let payload = postcard::to_stdvec(state).map_err(|error| BlobError::Payload(error.to_string()))?;
    let mut bytes = Vec::with_capacity(HEADER + payload.len());
    bytes.extend_from_slice(MAGIC);
    bytes.extend_from_slice(&VERSION.to_le_bytes());
    let mut name = guid.as_bytes().to_vec();
    name.resize(GUID_LENGTH, b' ');
    bytes.extend_from_slice(&name);
    bytes.extend_from_slice(&(payload.len() as u64).to_le_bytes());
    let sum = checksum(&bytes, &payload);
    bytes.extend_from_slice(&sum);
    bytes.extend_from_slice(&payload);
    Ok(bytes)
}

/// How many bytes [`write`] makes of a state.
///
/// # Errors
/// [`BlobError::Payload`] when the state cannot be encoded.
pub fn size<T: Serialize>(state: &T) -> Result<usize, BlobError> {
    let payload = postcard::serialize_with_flavor(state, postcard::ser_flavors::Size::default());
    payload.map(|length| HEADER + length).map_err(|error| BlobError::Payload(error.to_string()))
}

/// Reads a state that [`write`] has written for the same GUID.
///
/// # Errors
/// [`BlobError`].
pub fn read<T: DeserializeOwned>(guid: &str, bytes: &[u8]) -> Result<T, BlobError> {
    if bytes.len() < HEADER {
        return Err(BlobError::Length { found: bytes.len(), expected: HEADER });
    }
    let (magic, rest) = bytes.split_at(MAGIC.len());
    if magic != MAGIC {
        return Err(BlobError::Magic);
    }
    let (version, rest) = rest.split_at(4);
    let version = u32::from_le_bytes(version.try_into().unwrap_or_default());
    if version != VERSION {
        return Err(BlobError::Version(version));
    }
    let (name, rest) = rest.split_at(GUID_LENGTH);
    let name = String::from_utf8_lossy(name);
    if name.trim_end() != guid {
        return Err(BlobError::Guid(name.trim_end().chars().filter(|c| !c.is_control()).collect()));
    }
    let (length, rest) = rest.split_at(8);
    let length = u64::from_le_bytes(length.try_into().unwrap_or_default());
    let (sum, payload) = rest.split_at(SUM);
    if payload.len() as u64 != length {
        return Err(BlobError::Length {
            found: bytes.len(),
            expected: HEADER.saturating_add(usize::try_from(length).unwrap_or(usize::MAX)),
        });
    }
    if checksum(&bytes[..HEADER - SUM], payload) != sum {
        return Err(BlobError::Checksum);
    }
    let (state, rest) = postcard::take_from_bytes(payload).map_err(|error| BlobError::Payload(error.to_string()))?;
    if rest.is_empty() { Ok(state) } else { Err(BlobError::Payload("bytes are left over".into())) }
}
