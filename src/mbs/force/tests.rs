use super::*;
use nalgebra::Vector3;
