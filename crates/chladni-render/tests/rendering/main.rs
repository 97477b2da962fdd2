//! Rendering, against its definitions, bounds and a dense panel.

mod area;
mod common;
mod correction;
mod covariance;
mod equivariance;
mod evaluate;
mod fewest;
mod foreign_fields;
mod gains;
mod methods;
mod modal;
mod rig;
mod robust;
mod scene_file;
mod signals;
mod spoilt_fields;
mod stress;
mod swapped_cables;
mod time;
mod time_refused;
mod tones;
mod touch;
mod weights_file;
mod zones;
