//! `wheelrail table -o FILE`: the creep-force table of the creep law `usetab`, computed with the exact theory.

use super::output::{Kind, Target};
use super::progress::bar;
use super::{Failure, print, refused};
use crate::contact::creep::usetab::generate::generate;
use crate::contact::creep::usetab::layout::Layout;
use crate::contact::creep::usetab::table::Table;
use clap::Args;
use std::path::PathBuf;

#[derive(Args)]
#[command(after_help = "\
The program carries the table of the defaults, src/contact/creep/usetab/table.bin: a new one takes effect when it replaces that file and \
the program is built anew. It takes some minutes.")]
pub(super) struct Arguments {
    /// File to write
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Cells of the exact theory across each axis of the ellipse, even; a second grid has half as many
    #[arg(long, value_name = "N", default_value_t = 32)]
    grid: usize,
    /// Steps of the table from no creepage to full slip
    #[arg(long, value_name = "N", default_value_t = 12)]
    steps: usize,
    /// Number of a/b between 0.1 and 10
    #[arg(long, value_name = "N", default_value_t = 11)]
    shapes: usize,
    /// Poisson's ratio
    #[arg(long, value_name = "NU", default_value_t = 0.28)]
    nu: f64,
}

pub(super) fn table(arguments: &Arguments) -> Result<(), Failure> {
    let Arguments { output, grid, steps, shapes, nu } = arguments;
    if !(grid % 2 == 0 && (8..=128).contains(grid)) {
        return Err(Failure::Input(format!("--grid {grid}: expected an even number from 8 to 128")));
    }
    if !(4..=64).contains(steps) || !(4..=64).contains(shapes) {
        return Err(Failure::Input(format!("--steps {steps} --shapes {shapes}: expected numbers from 4 to 64")));
    }
    if !(0.0..=0.5).contains(nu) {
        return Err(Failure::Input(format!("--nu {nu}: expected a number from 0 to 0.5")));
    }
    // Before minutes of work: can the file be written at all?
    let target = Target::find(output, Kind::Binary).map_err(refused)?;
    let bar = bar(0, "{eta}");
    let bytes = generate(Layout { steps: *steps, shapes: *shapes, cells: *grid, nu: *nu }, &|ready, all| {
        bar.set_length(all as u64);
        bar.set_position(ready as u64);
    });
    bar.finish_and_clear();
    // What was written must be readable.
    Table::read(&bytes).map_err(|error| Failure::Run(error.to_string()))?;
    target.write(&bytes)?;
    print(&format!("{}: {} bytes\n", output.display(), bytes.len()))?;
    Ok(())
}
