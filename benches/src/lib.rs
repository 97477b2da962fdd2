//! Speed against accuracy: named cases with known truth, every method on each of them,
//! and the time of each stage.
//!
//! * [`Solver`]: all methods of both kinds under their names
//! * [`CASES`], [`Problem`]: the truth, the noise of a seed, the Cramér-Rao bounds
//! * [`accuracy`]: errors over the bound, coverage of the error bars, missed and spurious
//!   modes, time; [`accuracy_figures`] draws error against time with the Pareto front
//! * [`own_data`]: what cheaper settings lose on data whose truth nobody knows
//! * [`profile`]: stage times, and the floor that no method can go below
//!
//! * [`stability`]: where methods fail, whether they know it, and whether error bars hold
//! * [`wild`]: structures drawn from a seed, in either damping law, modes beyond the band
//! * [`measured`]: tests simulated in time, over ways to measure
//! * [`scenes`]: rendering from noisy FRFs to a drive on the true plate, by every method
//! * [`rigs`]: drives corrected by measured fields, on rigs with faults drawn from a seed
//! * [`time`]: bursts, by every way of ramping and by the inverse filter
//! * [`kernels`]: dense kernels at the sizes of a fit, every back end that is linked in
//!
//! `chladni bench` writes the files; `docs/accuracy.md` says what they show. Criterion's
//! benches of single stages are in `benches/`.

mod accuracy;
mod accuracy_figures;
mod accuracy_tables;
mod cases;
mod countdown;
mod csv;
mod demonstration;
mod journal;
mod kernels;
mod knobs;
mod large;
mod measured;
mod mode_columns;
mod mode_errors;
mod own_data;
mod pareto;
mod peers;
mod problem;
mod profile;
mod rig;
mod scene;
mod score;
mod solver;
mod stability;
mod statistics;
mod time;
mod wild;

pub use accuracy::{accuracy, AccuracyOptions, AccuracyRow};
pub use accuracy_figures::accuracy_figures;
pub use accuracy_tables::{accuracy_csv, accuracy_modes_csv};
pub use cases::{Case, Target, CASES};
pub use demonstration::{corner_scene, panel_77x34_1997_lines};
pub use journal::Journal;
pub use kernels::{kernels, kernels_csv, kernels_figure, KernelRow};
pub use knobs::Setting;
pub use large::{large, Size};
pub use measured::{
    measured, measured_cells, measured_csv, measured_figures, measured_summary, MeasuredCell,
    MeasuredForce, MeasuredOptions, MeasuredOutcome, MeasuredRow, MeasuredSummary, MeasuredWay,
    MEASURED_CELLS,
};
pub use mode_errors::{ModeErrors, Spread};
pub use own_data::{own_csv, own_data, own_figures, OwnRow};
pub use pareto::front;
pub use peers::PeerRow;
pub use problem::{Bounds, Problem};
pub use profile::{
    profile, profile_csv, profile_figure, scaling, scaling_csv, scaling_figure, Floor, ProfileCase,
    ProfileOptions, ProfileRow, ProfileSource, ScalingRow, PROFILE_CASES,
};
pub use rig::{rig_csv, rig_figures, rigs, RigError, RigOptions, RigRow, RigWay};
pub use scene::{
    paper, paper_csv, paper_figures, scene_csv, scene_figures, scene_knobs, scenes, touch,
    touch_csv, Means, PaperModes, PaperRow, PaperRun, SceneCase, SceneDrive, SceneOptions,
    ScenePanel, SceneRow, Served, TouchRow, PAPER_CUTS, PAPER_MODES, SCENE_CASES,
};
pub use score::{Match, Score};
pub use solver::Solver;
pub use stability::{
    calibration, calibration_csv, failures_csv, stability, stability_csv, stability_figures,
    Calibration, Map, MapAxis, StabilityOptions, StabilityRow, Trial, MAPS,
};
pub use statistics::median;
pub use time::{
    fitted_csv, fitted_verdict, time, time_cases, time_csv, time_figures, time_fitted,
    time_verdict, FittedRow, TimeCase, TimeRow,
};
pub use wild::{
    summary, wild, wild_csv, wild_draws_csv, wild_figures, wild_measurement, Criterion, Difficulty,
    Draw, WildOptions, WildOutcome, WildRow,
};
