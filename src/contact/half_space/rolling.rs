//! Influence of tractions that stand still in a patch while the bodies roll through it.
//!
//! Slip over the rolled distance: `s = w - du/dx`, w without tractions, the derivative taken over one cell, from the cell's middle to the next
//! middle ahead. (Taking x at the cell's middle, not half way to the next one, keeps c32 = -c23 on every grid to four digits; CONTACT takes it a
//! sixth of a cell ahead.)

use super::influence::{Convolver, Influence, Kernel, Pair, rectangle};

/// Displacement difference `shift` ahead of a cell i columns and j rows away from a loaded one.
pub(crate) fn influence(size: Pair, nu: f64, shift: f64, (i, j): (i32, i32)) -> Influence {
    let [xx, yy, xy, _] = rectangle(i as f64 * size[0] + shift, j as f64 * size[1], size, nu);
    [xx, yy, xy]
}

/// Slip per distance rolled by unit traction (over G, where lengths are in metres), for cells of `size`.
pub(crate) fn kernel(size: Pair, nu: f64, convolver: &Convolver) -> Kernel {
    let (columns, rows) = (convolver.columns as i32, convolver.rows as i32);
    // Each influence is needed for its own place and as the one ahead of another; xy is odd across the strips.
    let all: Vec<Influence> = (0..rows).flat_map(|j| (1 - columns..=columns).map(move |i| influence(size, nu, 0.0, (i, j)))).collect();
    let at = |i: i32, j: i32| {
        let [xx, yy, xy] = all[(j.abs() * 2 * columns + i + columns - 1) as usize];
        [xx, yy, xy * f64::from(j.signum())]
    };
    convolver.kernel(|i, j| {
        let (here, ahead) = (at(i, j), at(i + 1, j));
        std::array::from_fn(|k| (here[k] - ahead[k]) / size[0])
    })
}
