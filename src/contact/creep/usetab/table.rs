//! The packed table.
//!
//! Over the unit ball of [`super::coordinates`] the force is `F(u) = L u + |u| K(u)`: L is the linear law of each shape
//! (slopes of the exact theory at zero), K, zero at the middle, is tabulated on a cubic lattice of spacing 1/n and on a
//! geometric sequence of a/b; [`super::spline`] interpolates it. The quarter of the lattice with xi >= 0 and phi >= 0 is
//! stored; the rest follows from the mirror symmetries
//!
//! ```text
//! xi -> -xi:                Fx odd,  Fy even, Mz even
//! (eta, phi) -> -(eta, phi): Fx even, Fy odd,  Mz odd
//! ```
//!
//! File, little endian: magic, version, n, number of shapes, cells of the exact grid (u32), nu (f64), checksum (u64);
//! five slopes (f64) per shape; scales of the three components (f64); K as i16.

use super::coordinates::Triple;
use super::layout::{Layout, Slopes};
use super::spline::Spline;

const MAGIC: &[u8; 8] = b"WRCREEP\0";
/// To be raised whenever the meaning of the numbers changes.
const VERSION: u32 = 1;

/// Why bytes are not a table for this program.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum TableError {
    #[error("not a creep-force table")]
    Foreign,
    #[error("a creep-force table of version {0}, expected {VERSION}: make it anew with `wheelrail table`")]
    Version(u32),
    #[error("a creep-force table that is cut short or damaged")]
    Damaged,
}

/// A table ready for use.
#[derive(Clone, Debug)]
pub struct Table {
    layout: Layout,
    spline: Spline,
}

fn checksum(bytes: &[u8]) -> u64 {
    // FNV-1a
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3))
}

/// Packs slopes and K (shape after shape) into the bytes of a file.
pub(crate) fn pack(layout: Layout, slopes: &[Slopes], values: &[Triple]) -> Vec<u8> {
    let mut body = Vec::new();
    for slope in slopes.iter().flat_map(|slopes| slopes.0) {
        body.extend(slope.to_le_bytes());
    }
    let largest: Triple = std::array::from_fn(|c| values.iter().fold(0.0, |most, value| value[c].abs().max(most)));
    let scales = largest.map(|largest| largest.max(1e-12) / f64::from(i16::MAX));
    for scale in scales {
        body.extend(scale.to_le_bytes());
    }
    for value in values {
        for (value, scale) in value.iter().zip(scales) {
            body.extend(((value / scale).round() as i16).to_le_bytes());
        }
    }
    let mut bytes = MAGIC.to_vec();
    for number in [VERSION, layout.steps as u32, layout.shapes as u32, layout.cells as u32] {
        bytes.extend(number.to_le_bytes());
    }
    bytes.extend(layout.nu.to_le_bytes());
    bytes.extend(checksum(&body).to_le_bytes());
    bytes.extend(body);
    bytes
}

/// Reads numbers off the front of a slice.
struct Reader<'a>(&'a [u8]);

impl Reader<'_> {
    fn take<const N: usize>(&mut self) -> Result<[u8; N], TableError> {
        let (first, rest) = self.0.split_first_chunk::<N>().ok_or(TableError::Damaged)?;
        self.0 = rest;
        Ok(*first)
    }

    fn whole(&mut self) -> Result<u32, TableError> {
        Ok(u32::from_le_bytes(self.take()?))
    }

    fn number(&mut self) -> Result<f64, TableError> {
        Ok(f64::from_le_bytes(self.take()?))
    }
}

impl Table {
    /// Unpacks a file.
    ///
    /// # Errors
    /// [`TableError`] unless the bytes are a whole table of this version.
    pub fn read(bytes: &[u8]) -> Result<Self, TableError> {
        let mut reader = Reader(bytes);
        if reader.take::<8>().map_err(|_| TableError::Foreign)? != *MAGIC {
            return Err(TableError::Foreign);
        }
        let version = reader.whole()?;
        if version != VERSION {
            return Err(TableError::Version(version));
        }
        let [steps, shapes, cells] = [reader.whole()?, reader.whole()?, reader.whole()?].map(|n| n as usize);
        let layout = Layout { steps, shapes, cells, nu: reader.number()? };
        let sum = u64::from_le_bytes(reader.take()?);
        if !(4..=64).contains(&steps) || !(4..=64).contains(&shapes) || checksum(reader.0) != sum {
            return Err(TableError::Damaged);
        }
        let mut slopes = Vec::with_capacity(shapes);
        for _ in 0..shapes {
            let mut numbers = [0.0; 5];
            for number in &mut numbers {
                *number = reader.number()?;
            }
            slopes.push(Slopes(numbers));
        }
        let scales = [reader.number()?, reader.number()?, reader.number()?];
        if reader.0.len() != shapes * layout.points() * 6 {
            return Err(TableError::Damaged);
        }
        let stored: Vec<Triple> = reader
            .0
            .as_chunks::<6>()
            .0
            .iter()
            .map(|b| std::array::from_fn(|c| scales[c] * f64::from(i16::from_le_bytes([b[2 * c], b[2 * c + 1]]))))
            .collect();
        Ok(Table { layout, spline: Spline::new(&layout, &slopes, &stored) })
    }

    /// Sizes of the table.
    pub fn layout(&self) -> Layout {
        self.layout
    }

    /// Force in mu N and moment in mu N sqrt(a b) at `u` in the ball; `a_over_b` within the table.
    #[inline]
    pub(crate) fn force(&self, a_over_b: f64, u: Triple) -> Triple {
        self.spline.force(a_over_b, u)
    }
}
