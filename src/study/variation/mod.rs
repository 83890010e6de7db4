//! A scene run many times with other values: [`parameter`] reads them, [`design`] says which runs there are, [`scalar`] what is kept of one, [`single`] makes it.

pub mod design;
pub mod parameter;
pub mod scalar;
pub mod single;
