//! Every constant of this room: meaning, unit, where it comes from, and what happens at other
//! values where that was tried.
//!
//! A value without an origin is judgement: nobody has calibrated it.

// around.rs

/// MAC of two poles that may be one mode.
pub(super) const ONE_SHAPE: f64 = 0.9;
/// Lines between two poles that may be one mode, broadened by a window: under Hann's they lie 1.1
/// to 1.3 apart at two lines per bandwidth.
pub(super) const ONE_LINE: f64 = 2.0;

// common_delay.rs

/// Decay of a mode times a delay that it outlasts. Poles that stand for a delay reach e^{−στ} of
/// about the noise over the data.
pub(super) const OUTLASTED: f64 = 3.0;
/// Longest delay that is looked for, in cycles at the mean spacing of the modes: those that stand
/// for a delay lie about one apart.
pub(super) const COMMON_REACH: f64 = 1.5;
/// Shortest over longest delay that the same modes are asked for: a third of an octave.
pub(super) const PART_FROM: f64 = 0.8;
/// Decay of a mode over the mean spacing of all in Hz, from which on it is taken for broad: poles that
/// stand for a delay have 2.2 and more at 30 dB, modes of a panel 0.5 and less.
pub(super) const OVERLAP: f64 = 2.0;
/// Fewest broad modes that make a delay likely.
pub(super) const BROAD_LEAST: usize = 12;
/// FRFs whose impulse responses are looked at, at most.
pub(super) const SILENCE_FRFS_MOST: usize = 16;
/// Part of the modes that outlast a delay which must lie on its line.
pub(super) const ON_LINE: f64 = 0.7;

// correlation.rs

/// α·T of exponential windows.
pub(super) const DECAYS: [f64; 9] = [0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0, 12.0];
/// Lengths of bursts under a Hann window, in parts of a record. Errors of bursts between two of them
/// lie between theirs; those of 0.9 and more are those of a continuous force.
pub(super) const PARTS: [f64; 7] = [0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8];
/// Places of a record at which windows are taken for sums over it.
pub(super) const RECORD_PLACES: usize = 256;
/// Lags of lines over which errors must be uncorrelated once the likeliest correlation is
/// taken out.
pub(super) const LAGS_HELD: usize = 4;
/// Part of the variance that is white in any case: no correlation is exact.
pub(super) const ALWAYS_WHITE: f64 = 1e-3;

// delay.rs

/// Rounds of regression on phases that are taken anew about the delay of the round before.
pub(super) const DELAY_ROUNDS: usize = 4;
/// Phase of a well-known mode, rad: real structures are not real to more than some
/// degrees.
pub(super) const NATURAL_PHASE: f64 = 0.03;
/// Modes that must carry the evidence: fewer fit some delay by chance.
pub(super) const DELAY_LEAST_MODES: f64 = 4.0;
/// Rms phase, rad, that may be left after the delay is taken off: shapes more complex
/// than that hide a delay.
pub(super) const LEFT_OVER: f64 = 0.2;
/// A delay counts from so many of its standard deviations ...
pub(super) const DELAY_SIGMAS: f64 = 5.0;
/// ... and from this phase at the highest mode, rad (3°).
pub(super) const LEAST_PHASE: f64 = 0.05;
/// Longest trial delay, in cycles at the mean spacing of the modes: there doubled phases
/// turn by half a cycle from mode to mode, and beyond it they fold.
pub(super) const TRIAL_REACH: f64 = 0.25;
/// Phase at the highest mode from one trial delay to the next, rad.
pub(super) const TRIAL_STEP: f64 = 0.25;
/// Most trial delays on either side: taste.
pub(super) const TRIALS_MOST: usize = 20_000;

// delayed_response.rs

/// Part of its expected misfit that noise leaves on the line at least: half.
pub(super) const NOISE_LEFT: f64 = 0.5;
/// Modes that must show a response well: two lie on a line with one of many delays.
pub(super) const RESPONSE_LEAST_MODES: usize = 3;
/// Responses that must show a mode well: of two that differ neither is the one that lags.
pub(super) const AGREE_LEAST: usize = 3;
/// Standard deviation of a value over its size below which a mode shows well.
pub(super) const WELL_SEEN: f64 = 0.2;
/// Least spread of phases, rad: values are no truer than that however small their error.
pub(super) const REAL_PHASE: f64 = 0.01;
/// Rounds in which the common phase of a mode comes to that of most responses.
pub(super) const COMMON_ROUNDS: usize = 12;

// estimation.rs

/// Lines within which poles may be one mode that a Hann window on blows has set beside itself: it
/// does so at one line to both sides, and noise moves them.
pub(super) const BESIDE_LINES: f64 = 2.5;

// hidden.rs

/// Poles around such a place that may take over what a mode there would add.
pub(super) const NEIGHBOURS: usize = 6;
/// Half-bandwidths, and lines, on both sides of it.
pub(super) const HIDDEN_WINDOW: (f64, usize) = (8.0, 16);
/// Modal overlap (half-bandwidths of both neighbours over their distance) at which a mode may
/// hide between two others. Between nearer ones it always may.
pub(super) const HIDING_OVERLAP: std::ops::Range<f64> = 0.3..1.5;

// kind.rs

/// Mean of unit phasors (or of (ΣR²)/Σ|R|²) from which the modes count as of one phase;
/// random phases of five modes reach it in less than one case of a hundred, complex
/// shapes with 20° of scatter lie above it.
pub(super) const COHERENT: f64 = 0.7;
/// The phase must lie this near to a multiple of 90°, rad.
pub(super) const KIND_NEAR: f64 = std::f64::consts::PI / 6.0;
/// Modes needed, with driving points and without.
pub(super) const KIND_LEAST_MODES: [usize; 2] = [2, 3];
/// Residual term that the other kind would have, over what the modes make of it, from which
/// on the kind is doubted.
pub(super) const BESIDE_SHARE: f64 = 0.5;

// line_shape.rs

/// Strongest FRFs looked at for each mode.
pub(super) const LINE_SHAPE_FRFS_MOST: usize = 16;
/// Half-bandwidths, and lines, on both sides of a mode.
pub(super) const REACH: (f64, usize) = (4.0, 8);
/// Half-bandwidths to the next mode.
pub(super) const ALONE: f64 = 12.0;
/// Steps of the fit of one pole.
pub(super) const STEPS: usize = 20;
/// A step smaller than this part of the decay ends the fit.
pub(super) const STILL: f64 = 1e-4;
/// Lines taken off for the unknowns of a line shape. Lines are counted once however many FRFs
/// there are: leakage errors of one record are common to all of them.
pub(super) const UNKNOWNS: usize = 4;
/// Part of each record of a burst under Hann's window that is taken for continuous noise most
/// often: of shorter ones errors do not show the leakage, of longer ones damping comes out less
/// wrong (simulated tests).
pub(super) const CUT_BURST: f64 = 0.6;
/// Log-likelihood by which one window must beat the others.
pub(super) const DECIDES: f64 = 12.0;
/// Part of the decay that a window is taken to have added at most where a fit starts:
/// taste, the steps do the rest.
pub(super) const SHARPENED_MOST: f64 = 0.7;
/// Largest step of the pole, in decays.
pub(super) const LINE_SHAPE_STEP: f64 = 0.5;
/// Length of a step that did not serve, over that before.
pub(super) const LINE_SHAPE_SHORTER: f64 = 0.3;

// moving.rs

/// FRFs looked at for each mode: the strongest.
pub(super) const MOVING_FRFS_MOST: usize = 48;
/// Half-bandwidths, and lines, on both sides of a mode.
pub(super) const MOVING_WINDOW: (f64, usize) = (4.0, 6);
/// Scatter of the frequency over the FRFs, in half-bandwidths, at which a mode moves.
pub(super) const MOVES: f64 = 0.5;
/// ... and that must exceed so many times what noise does.
pub(super) const OVER_NOISE: f64 = 3.0;
/// Share of the modes that must move before the data as a whole contradict one set of
/// poles.
pub(super) const SHARE: f64 = 0.5;
/// Half-bandwidths to the next mode below which a mode is not looked at by itself.
pub(super) const MOVING_ALONE: f64 = 2.0;
/// Half-bandwidths from the common pole beyond which the pole of one FRF counts no
/// farther.
pub(super) const MOVING_FARTHEST: f64 = 4.0;

// noise.rs

/// Complex values that a fit must leave over for its modes to be sure: single FRFs of noise
/// had a sure mode in 7 of 100 sets of 10 lines and in 2 of 12, and have none since.
pub(super) const LEAST_LEFT: usize = 6;
/// Rms residual over rms data from which data are mostly noise. At 0.9 noise of unequal
/// levels over flat FRFs still had a sure mode in 8 of 40 sets.
pub(super) const MOSTLY_NOISE: f64 = 0.5;
/// Ratio of a mode's gain to the largest that uneven noise makes by chance; modes above it are not
/// tested.
pub(super) const CLEAR_OF_NOISE: f64 = 10.0;
/// Energy that other poles must leave of a mode's column for the mode to be judged: those of
/// one pole leave none.
pub(super) const OWN_LEAST: f64 = 1e-8;
/// FRFs that are held at a time.
pub(super) const NOISE_FRFS: usize = 256;

// phases.rs

/// Log-likelihood of a delay over phases of no order, beyond the looks: one in twenty by chance
/// at most.
pub(super) const DELAY_LIKELIER: f64 = 3.0;

// reciprocal.rs

/// Gain difference that is named, as a ratio: calibrated chains agree to one or two per
/// cent.
pub(super) const GAIN: f64 = 0.05;
/// ... and must exceed so many of its standard deviations.
pub(super) const RECIPROCAL_SIGMAS: f64 = 5.0;
/// Share of an FRF that no factor explains.
pub(super) const UNLIKE: f64 = 0.3;
/// Neighbouring lines of a resonance that carry one piece of evidence together.
pub(super) const LINES_TOGETHER: f64 = 8.0;
/// Relative errors of the fit that [`UNLIKE`] must be exceeded by.
pub(super) const UNLIKE_ERRORS: f64 = 3.0;

// split.rs

/// Poles nearer than so many of the larger half-bandwidth are looked at together.
pub(super) const SPLIT_NEAR: f64 = 2.0;
/// Half-bandwidths, and lines, on both sides.
pub(super) const SPLIT_WINDOW: (f64, usize) = (4.0, 8);
/// Modes at most that a group is taken for, each moving: three, where lines of neighbours meet.
pub(super) const SPLIT_MOVING_MOST: usize = 3;
/// Poles of a group up to which more than one is tried.
pub(super) const SPLIT_POLES_MOST: usize = 24;
/// Groups, more than half of all, that moving modes explain: then the larger others are doubted.
pub(super) const SPLIT_GROUPS: usize = 2;
/// FRFs looked at: of the DOFs that show the modes best.
pub(super) const SPLIT_FRFS_MOST: usize = 48;
/// FRFs looked at of each DOF of the smaller side, at least.
pub(super) const SPLIT_SET_LEAST: usize = 4;
/// MAC of two modes of one shape. Twins that references make which drift by 0.01 to 0.3 bandwidths
/// had 0.99 and more.
pub(super) const SPLIT_ONE_SHAPE: f64 = 0.95;
/// Energy that moving modes must leave over what common poles leave, where the residual is more
/// than noise.
pub(super) const SPLIT_CLEARLY: f64 = 0.5;
/// MAC that two modes of a group must have where the larger side may have moved: where each of its
/// DOFs shows one mode of a pair alone, a pole for each explains the FRFs as well.
pub(super) const SPLIT_LIKE: f64 = 0.8;
/// DOFs from which on a shape tells modes apart: two modes have like values at two DOFs in one
/// case of seven.
pub(super) const SPLIT_DOFS_LEAST: usize = 3;
/// Twins stand nearer than this part of their half-bandwidth.
pub(super) const TWIN_NEAR: f64 = 0.5;
/// Their damping differs by less than this factor.
pub(super) const TWIN_DAMPING: f64 = 1.4;
/// Fewest modes with a twin: one close pair is none of many.
pub(super) const TWINS_LEAST: usize = 5;

// window_bias.rs

/// Loss factors that a window could have raised by this much, relative, are worth a word,
/// and wider bars: at eight lines per bandwidth under a Hann window it is 1.5 %.
pub(super) const BIAS: f64 = 0.01;
/// ... and are worth a fit that undoes it.
pub(super) const BIAS_UNDONE: f64 = 0.03;
/// Part of a loss factor that bars take a window to have added at most: they have twice the
/// length of what would be left.
pub(super) const DOUBT_MOST: f64 = 2.0 / 3.0;
/// Part of a relative error of damping that a mass-normalised shape has, the height of the
/// peak given: its residue, the square of the shape, is that height times the decay.
pub(super) const SCALE_OF_DAMPING: f64 = 0.5;
/// Part of the power of a residual under a window that was told, over that of pure resonances, from
/// which the data contradict the window. Of a window told rightly both leave the same noise, under
/// a wrong one 3 to 10⁴ times as much was seen.
pub(super) const CONTRADICTS: f64 = 2.0;

// turned_response.rs

/// Least angle that is named, rad (10°): shapes of real structures are complex by some degrees, and
/// signal paths agree to a few.
pub(super) const LEAST_TURN: f64 = 0.17;

// witness.rs

/// Lines of a stretch whose errors are looked at together.
pub(super) const STRETCH: usize = 40;
/// ... where long ones are fewer than [`STRETCHES_LEAST`].
pub(super) const SHORT_STRETCH: usize = 20;
/// Fewest stretches over all FRFs that are asked.
pub(super) const STRETCHES_LEAST: usize = 3;
/// Distance to the next mode, in bandwidths, and in lines.
pub(super) const BESIDE: (f64, f64) = (4.0, 10.0);
/// Level of a line over the lower quartile of all from which on it is not noise alone.
pub(super) const NOISE_ONLY: f64 = 2.5;
/// Lines on both sides that the level is a median of.
pub(super) const LEVEL_AROUND: usize = 20;
/// FRFs that are asked, and how many of them count as independent: one force is in all.
pub(super) const FRFS_ASKED: (usize, usize) = (16, 4);
/// Weights of a sixth difference: ten lines beside a mode it leaves less than a tenth of what a
/// fourth one leaves of misfit, over noise.
pub(super) const SIXTH: [f64; 7] = [1.0, -6.0, 15.0, -20.0, 15.0, -6.0, 1.0];
/// Coherence of the errors of two FRFs from which on they are taken for shared. Independent
/// ones have 0.08 ± 0.02 over a stretch; leakage of records at 50 dB mostly 0.3 and more.
/// At 0.2 one simulated test of 360 was read wrongly.
pub(super) const SHARED: f64 = 0.15;
/// Mean of these coherences by chance and of leakage, as above.
pub(super) const COHERENCE: (f64, f64) = (0.08, 0.3);
/// Log-likelihood of the first over the second from which on errors are taken for independent, of
/// one force and of several. Of tests simulated with two forces that drop, 4 of 500 were read as
/// made without a window at 0, 2 of 750 at 2.
pub(super) const APART: [f64; 2] = [2.0, 3.0];
/// Part of the log-likelihood of what correlation is left that counts against the likeliest.
/// Under forces that drop, simulated, a wrong likeliest left 10 to 30.
pub(super) const MISFIT_COUNTS: f64 = 0.25;
/// Deviation of a line from an even axis, in spacings, from which on lines are not
/// neighbours.
pub(super) const WITNESS_UNEVEN: f64 = 0.01;
/// Log-likelihood from which on the errors of neighbouring lines say something.
pub(super) const SAYS: f64 = 5.0;
