//! Random scenes over the whole schema, each judged against a tight explicit run and by the books of every run.

mod additions;
mod dice;
mod judge;
mod scene;

pub use judge::{Class, Verdict, judge, judge_with};
pub use scene::RandomScene;
