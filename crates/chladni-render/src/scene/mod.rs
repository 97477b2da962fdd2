//! The scene: its file enters; drive frequency, limits, zones and actuators leave.
//!
//! `scene_file` (the [`Scene`](scene_file::Scene)) reads its tables by `keys`, `actuators`,
//! `circuit`, `read_threshold` and `read_zones`; `tones` shares limits among frequencies. The
//! tables `[time]`, `[touch]` and a calibration are read in the rooms of these.
//! `zones` (in `plane`) says what each place is: hot, cold, or not judged; `threshold` and
//! `limits` say what is felt there. `other_kind` recognises a file in the place of another.

pub(crate) mod actuators;
mod beside;
pub(crate) mod circuit;
pub(crate) mod count;
pub(crate) mod drift;
mod keys;
pub(crate) mod limits;
pub(crate) mod other_kind;
pub(crate) mod plane;
pub(crate) mod read_threshold;
pub(crate) mod read_zones;
pub(crate) mod scene_file;
pub(crate) mod threshold;
pub(crate) mod tones;
pub(crate) mod zones;
