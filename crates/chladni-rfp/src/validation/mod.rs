//! Yardsticks of modal testing: of shapes (MAC, phase collinearity and deviation,
//! complexity), of FRFs (mode indicator, reciprocity), and of a model against its data
//! (reconstruction error).

mod cmif;
mod complexity;
mod mac;
mod reciprocity;
mod reconstruction;

pub use cmif::cmif;
pub use complexity::{mean_phase_deviation_deg, modal_complexity_factor, mpc};
pub use mac::{auto_mac, mac, mac_matrix};
pub use reciprocity::{reciprocity, ReciprocalPair};
pub use reconstruction::reconstruction_error;
