//! Every constant that decides how exact the simulator is, in one place.

/// Plate modes are kept up to this multiple of the band's top: what lies above it would
/// add a nearly constant compliance of about 1/16 of its own static share. Twice as much
/// quadruples the modes and changes no in-band pole.
pub const BAND_FACTOR: f64 = 4.0;

/// Modes kept at least, so that a low band still has a true world above it.
pub const LEAST_MODES: usize = 60;

/// Polynomials added along each side beyond the k·L/2 that resolve the highest kept wave.
///
/// Measured on the default panel (100 modes up to 4 kHz, against 70 × 60 polynomials),
/// largest relative error of a frequency: 4 more 2e-4, 6 more 5e-6, 8 more 8e-8, 10 more
/// 3e-8, 14 more 1e-8 (0.03 s), 30 more 6e-10 (0.12 s). From eight on the error falls
/// slowly: it is the corners' singularity, not the wave. With 14: simply supported and
/// clamped plates 1e-10 and better, clamped edges that meet free ones 4e-6. Point masses
/// add a singularity of their own: 34 masses of 0.1 g leave 5e-6 in the first nine
/// elastic modes, 1e-4 at 2 kHz.
pub const EXTRA_TERMS: usize = 14;

/// Products of one parity block above which the simulator refuses: the dense eigenvalue
/// problem takes minutes there.
pub const MOST_BLOCK_TERMS: usize = 3000;

/// Points this far outside the plate, relative to its sides, still count as on the edge:
/// roundings of a layout.
pub const EDGE_SLACK: f64 = 1e-9;

/// Point masses closer than this fraction of the side to their mirror image count as
/// symmetric.
pub const SYMMETRY_SLACK: f64 = 1e-9;

/// The thin-plate equation overestimates frequencies where the bending wavelength falls
/// below this many thicknesses: shear and rotary inertia then cost about one per cent
/// (Mindlin 1951).
pub const THIN_PLATE_WAVELENGTH_PER_THICKNESS: f64 = 20.0;

/// Spectral lines that a half-power bandwidth must hold at least; below, `simulate` warns
/// that damping cannot be identified. Three lines are comfortable.
pub const LEAST_LINES_PER_BANDWIDTH: f64 = 1.0;

/// σ that is added to ω² where springs hold a plate, 1/s²: 1 Hz, below any mode and above
/// the rounding of a stiffness that spans twelve decades.
pub const SPRING_SHIFT: f64 = 39.478;

/// A motion with ω² below this share of σ is one that no spring holds.
pub const STILL_SHARE: f64 = 1e-3;

/// Shapes of the nominal plate that a measured shape is made of, over the number of
/// responses: half of these leave room to see what does not fit.
pub const SCALING_SHARE: f64 = 0.5;
/// The same at most: what the modes of a band below 1 kHz need on a panel.
pub const MOST_SCALING_SHAPES: usize = 60;
/// The same at least: three rigid motions and a few bending ones.
pub const LEAST_SCALING_SHAPES: usize = 8;

/// Difference of the routes to the scale, rms over the modes, relative, from which none is
/// taken: the panel is not the one that was measured.
pub const SCALE_DISAGREEMENT: f64 = 0.10;

/// Error that both routes share, relative: 0.6 % below 420 Hz and 0.9 % below 700 Hz where
/// Poisson's ratio is 20 % off.
pub const SHARED_SCALE_ERROR: f64 = 0.01;

/// A residual −R/ω² is that of a rigid body where the band begins below this share of the
/// first natural frequency.
pub const RIGID_BAND: f64 = 0.5;

/// Turns in which inverse mass matrix and gains of the channels are found; from gains that
/// are 10 % off six turns leave 1e-6 of it.
pub const GAIN_ROUNDS: usize = 12;

// plate.rs

/// Largest loss factor: what has more does not ring, and is no plate with modes.
pub const MOST_LOSS_FACTOR: f64 = 2.0;

// panel.rs

/// Lowest signal-to-noise ratio, dB: noise a hundred thousand times the FRFs, in amplitude.
pub const LEAST_SNR_DB: f64 = -100.0;

// modes.rs

/// Points whose shapes are evaluated together: bounds the memory of dense grids.
pub const POINTS_AT_ONCE: usize = 256;

// time.rs

/// Records of a continuous force before the first that counts: transients have gone.
pub const SETTLING_RECORDS: usize = 4;
