//! Bursts, fades and moving zones: what the ground does while the drive changes, and
//! drives that keep cold ground quiet meanwhile.
//!
//! `table` (what a scene says) → `plan` (chains of places and ramps) → `voice` (the panel
//! about each carrier, the steady drives) → `tracks` (the drive over time) → `simulate`
//! → `judge`; `modal_ramp` makes ramps that every mode follows. `on_rig` does all that for a
//! rig that a calibration knows.

mod auto_ramp;
mod causal;
mod channel_map;
mod check_paths;
mod contact;
mod envelope;
mod envelope_program;
mod frames;
mod indices;
mod judge;
mod listener;
mod modal_ramp;
mod on_rig;
mod passages;
mod plan;
mod play;
mod program_ramp;
mod programs;
mod read_table;
mod recorded;
mod sidecar;
mod signal;
mod simulate;
mod splines;
mod stage;
mod stress;
mod table;
mod timeline;
mod tracks;
mod voice;
mod wav_file;

pub use channel_map::{ChannelMap, Mapped};
pub use frames::{AreaFrames, TimeFrames};
pub use indices::{AreaMeasures, TimeEvent, TimeIndices};
pub use judge::{TimeMeasure, TimeTraces};
pub use modal_ramp::modal_ramp;
pub use on_rig::{evaluate_signal, play, stress_in_time};
pub use play::{PlayOptions, Played};
pub(crate) use read_table::read_time;
pub use recorded::Recorded;
pub use sidecar::{Channel, Sidecar, SIGNAL_FORMAT, SIGNAL_VERSION};
pub use signal::{Signal, SignalOptions};
pub use stress::TimeStressRow;
pub use table::{Burst, Fade, Level, Measure, Move, RampTime, Ramps, TimeTable};
pub use wav_file::SampleFormat;
