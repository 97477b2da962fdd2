//! Constants of the crate, a table per room: meaning, unit, origin; where others were tried, what
//! they do.

mod judging;
mod methods;
mod panel;
mod problems;
mod reduction;
mod results;
mod rig;
mod scene;
mod solving;
mod time;
mod touch;

pub use judging::*;
pub use methods::*;
pub use panel::*;
pub use problems::*;
pub use reduction::*;
pub use results::*;
pub use rig::*;
pub use scene::*;
pub use solving::*;
pub use time::*;
pub use touch::*;
