//! Thin rectangular plates by Legendre-Ritz: the truth for fixtures, tests, benches and
//! `chladni simulate`.
//!
//! A [`Panel`] (plate, measured grid, driven points, frequency axis, noise) becomes a
//! [`Simulation`]: an FRF set, and the modal model whose synthesis gives that set without
//! its noise. [`Synthetic`] makes FRFs of abstract modes, without a plate, for tests of
//! identification, and [`cramer_rao`] says how well any unbiased method can find their
//! poles ([`cramer_rao_rank_one`], [`cramer_rao_real`]: with one shape, one real shape
//! per mode). [`TimeTest`] simulates a whole measurement in time, with its leakage and
//! windows.
//!
//! ```
//! use chladni_plate::{simulate, Panel};
//!
//! let mut panel = Panel::default(); // 268 x 170 x 0.7 mm of glass, free edges
//! panel.frf.step_hz = 20.0;
//! let simulation = simulate(&panel, Some(1), Some(40.0))?; // seed, signal-to-noise ratio in dB
//! assert_eq!(simulation.frf.values.dim(), (77, 34, 50));
//! assert!((simulation.truth.in_band_modes().next().unwrap().frequency_hz - 54.3).abs() < 0.1);
//! # Ok::<(), chladni_frf::Error>(())
//! ```
//!
//! | you want | you call | you get |
//! |---|---|---|
//! | FRFs of a plate | [`simulate()`] on a [`Panel`] | [`Simulation`] |
//! | FRFs of chosen modes | [`Synthetic::build`] | [`SyntheticSet`] |
//! | a measurement in time | [`TimeTest`] | [`TimeSet`] |
//! | the least possible error | [`cramer_rao()`] | [`CramerRao`] |
//! | mass-scaled shapes without a driving point | [`scale_by_panel`] | [`PanelScale`] |
//!
//! Errors are [`chladni_frf::Error`]; the feature `system` computes with LAPACK.
//!
//! # Equations
//!
//! Kirchhoff's plate, D ∇⁴w − ρh ω² w = 0 with D = E h³/(12(1−ν²)), solved by the
//! Rayleigh-Ritz method with products of orthonormal polynomials along the sides (module
//! `ritz`; Leissa, *J. Sound Vib.* 31, 1973, 257-293). Any mix of free, simply supported,
//! clamped and elastic edges, point masses and springs. FRFs are modal sums with structural damping
//! (module `response`).
//!
//! # When not to use it
//!
//! Plates whose bending wavelength falls below some 20 thicknesses (shear and rotary
//! inertia are left out: real frequencies are lower), laminates, orthotropic or curved
//! panels, and plates in heavy fluids. Published frequencies that come from short series
//! (Leissa's 36 beam products) are upper bounds and lie 0.1 to 1 % above these.

mod checks;
mod cramer_rao;
mod cramer_rao_structured;
mod edge_basis;
mod edges;
mod layout;
mod modes;
mod noise;
mod panel;
mod panel_file;
mod plate;
mod point_mass;
mod point_spring;
mod response;
mod ritz;
mod scaling;
mod simulate;
mod synthetic;
mod time;
mod tolerances;

pub use cramer_rao::{cramer_rao, CramerRao};
pub use cramer_rao_structured::{cramer_rao_rank_one, cramer_rao_real};
pub use edges::{Edge, Edges};
pub use layout::Layout;
pub use modes::PlateModes;
pub use noise::{
    add_noise_of_variance, add_white_noise, gain_noise, mean_square, noise_variance, outliers,
};
pub use panel::{Measurement, NewtonsPerVolt, Panel, ReferenceFrame, ResponseGrid};
pub use plate::{LossFactor, Plate};
pub use point_mass::PointMass;
pub use point_spring::PointSpring;
pub use response::{synthesise_by_products, DampedPlate};
pub use scaling::{scale_by_panel, PanelScale, RigidBody, ScaleRoute};
pub use simulate::{simulate, Simulation};
pub use synthetic::{Synthetic, SyntheticSet, SyntheticShapes};
pub use time::{Excitation, TimeSet, TimeTest};
