//! Viscous structures with true modes outside the band.

use crate::common::{fitted, missed_and_spurious};
use chladni_frf::{Damping, FrfSet, FrfValues, ModalModel};
use chladni_plate::{cramer_rao_real, CramerRao, Synthetic, SyntheticSet, SyntheticShapes};
use chladni_rfp::FitOptions;
use ndarray::Array1;
use num_complex::Complex64;
use std::collections::BTreeMap;
use std::f64::consts::TAU;

/// Natural frequencies of the modes below and above the band of the close modes, Hz.
const OUTSIDE_HZ: [f64; 4] = [4.6, 569.0, 655.0, 771.0];

/// Seeds of each case: `CHLADNI_SEEDS`, else `few`.
fn seeds(few: u64) -> u64 {
    std::env::var("CHLADNI_SEEDS").map_or(few, |count| count.parse().expect("a number"))
}

/// Twelve responses to (natural frequency, loss factor) in a band of 1601 lines.
fn set(
    modes: impl Iterator<Item = (f64, f64)>,
    damping: Damping,
    references: usize,
    snr_db: f64,
    seed: u64,
) -> SyntheticSet {
    let (natural_frequency_hz, loss_factor) = modes.unzip();
    Synthetic {
        natural_frequency_hz,
        loss_factor,
        responses: 12,
        references,
        damping,
        frequency_hz: Array1::range(9.8, 499.6, 0.30625),
        snr_db,
        seed,
        ..Synthetic::default()
    }
    .build()
    .expect("a set")
}

/// Seven modes, two of them with a neighbour within half their bandwidth, and those
/// `outside`.
fn close(references: usize, outside: &[f64], snr_db: f64, seed: u64) -> SyntheticSet {
    close_in(Damping::Viscous, references, outside, snr_db, seed)
}

/// The same in either law.
fn close_in(
    damping: Damping,
    references: usize,
    outside: &[f64],
    snr_db: f64,
    seed: u64,
) -> SyntheticSet {
    let inside = [
        (75.1, 0.02),
        (144.0, 0.0125),
        (144.0 * (1.0 + 0.3 * 0.0125), 0.014),
        (226.4, 0.018),
        (311.0, 0.022),
        (311.0 * (1.0 + 0.3 * 0.022), 0.025),
        (424.8, 0.015),
    ];
    let outside = outside.iter().map(|f| (*f, 0.02));
    set(
        inside.into_iter().chain(outside),
        damping,
        references,
        snr_db,
        seed,
    )
}

/// Natural frequencies, Hz, and damping ratios of modes well apart.
const SEPARATE: [(f64, f64); 8] = [
    (36.4, 0.018),
    (68.9, 0.0135),
    (109.3, 0.009),
    (124.1, 0.0105),
    (216.2, 0.0065),
    (294.1, 0.012),
    (349.8, 0.0055),
    (451.7, 0.008),
];

/// Those, and modes outside the band, at one reference.
fn separate(snr_db: f64, seed: u64) -> SyntheticSet {
    let outside = [4.1, 566.0, 622.0, 701.0].map(|f| (f, 0.01));
    let modes = SEPARATE.into_iter().chain(outside);
    let damped = modes.map(|(f, ratio)| (f, 2.0 * ratio));
    set(damped, Damping::Viscous, 1, snr_db, seed)
}

fn viscous() -> FitOptions {
    FitOptions {
        damping: Some(Damping::Viscous),
        ..FitOptions::default()
    }
}

/// Largest standard deviations of any mode: they are numbers, whatever the data tell.
fn all_bars_are_numbers(model: &ModalModel) -> bool {
    let finite = |value: &f64| value.is_finite() && *value >= 0.0;
    model.modes.iter().all(|mode| {
        finite(&mode.frequency_std_hz)
            && finite(&mode.loss_factor_std)
            && mode.shape_std.iter().all(finite)
    })
}

#[test]
fn error_bars_end_no_fit() {
    for seed in 1..=6 {
        let set = close(3, &OUTSIDE_HZ, 40.0, seed);
        for options in [FitOptions::default(), viscous()] {
            let model = fitted(&set.frf, &options);
            assert!(all_bars_are_numbers(&model), "seed {seed}");
        }
    }
}

#[test]
fn each_mode_outside_the_band_is_accounted_for_by_itself() {
    for outside in OUTSIDE_HZ {
        for (references, snr_db) in [(1, 40.0), (3, 40.0), (1, 60.0)] {
            let set = close(references, &[outside], snr_db, 3);
            let model = fitted(&set.frf, &viscous());
            let chi2 = model.quality.chi2_per_dof;
            assert!(
                (0.97..1.03).contains(&chi2),
                "mode at {outside} Hz, {references} references, {snr_db} dB: χ² {chi2}"
            );
        }
    }
}

/// Normal deviates within so many standard deviations, 95 % of them.
const SIGMAS_95: f64 = 1.96;

#[test]
fn both_laws_are_told() {
    for law in [Damping::Viscous, Damping::Structural] {
        for snr_db in [40.0, 60.0, 80.0] {
            for seed in 1..=seeds(2) {
                let set = close_in(law, 3, &OUTSIDE_HZ, snr_db, seed);
                let model = fitted(&set.frf, &FitOptions::default());
                let case = format!("{law:?}, {snr_db} dB, seed {seed}");
                assert_eq!(model.damping, law, "{case}: {:?}", model.quality);
                assert_exact(&set, &model, &case);
            }
        }
    }
}

/// Half-bandwidths that the bound of a frequency has at most where the data show the mode.
const SEEN: f64 = 0.05;

/// Every mode found that the data show, none too many, and nothing left but noise.
fn assert_exact(set: &SyntheticSet, model: &ModalModel, case: &str) {
    let (missed, spurious) = missed_and_spurious(&set.truth, model);
    let bound = bound_of_all(set);
    for mode in missed {
        let place = set.truth.modes.iter().position(|other| other == mode);
        let std_hz = bound.frequency_std_hz[place.expect("a true mode")];
        let half_bandwidth = 0.5 * mode.loss_factor * mode.frequency_hz;
        assert!(
            std_hz > SEEN * half_bandwidth,
            "{case}: {} Hz missed",
            mode.frequency_hz
        );
    }
    assert_eq!(spurious.len(), 0, "{case}");
    let chi2 = model.quality.chi2_per_dof;
    assert!((0.97..1.03).contains(&chi2), "{case}: χ² {chi2}");
    let path = model.quality.path.as_deref().unwrap_or_default();
    assert!(!path.contains("weighted"), "{case}, equal noise: {path}");
    // the file itself, laid over the data, leaves what its search said
    let FrfValues::F64(values) = &set.frf.values else {
        panic!("simulated values are f64");
    };
    let energy: f64 = values.iter().map(|v| v.norm_sqr()).sum();
    let left = model.quality.relative_error.powi(2) * energy / set.noise_variance;
    let ratio = left / values.len() as f64;
    assert!(
        (0.95..1.03).contains(&ratio),
        "{case}: {ratio} of the noise left"
    );
}

/// The bound of real shapes with the modes outside the band as unknown as the others.
fn bound_of_all(set: &SyntheticSet) -> CramerRao {
    let mut truth = set.truth.clone();
    truth.modes.iter_mut().for_each(|mode| mode.in_band = true);
    let axis = &set.frf.frequency_hz;
    cramer_rao_real(&truth, axis, set.noise_variance, &[]).expect("a bound")
}

/// Errors of frequencies (0) and loss factors (1) over the bound of real shapes, squared, by
/// mode; and how many lie within their 95 % intervals, of how many.
#[derive(Default)]
struct Errors {
    squares: BTreeMap<(usize, usize), Vec<f64>>,
    held: f64,
    all: f64,
}

impl Errors {
    /// Of one more fit.
    fn add(&mut self, set: &SyntheticSet, model: &ModalModel) {
        let bound = bound_of_all(set);
        for mode in model.in_band_modes() {
            let off =
                |place: &usize| (set.truth.modes[*place].frequency_hz - mode.frequency_hz).abs();
            let nearest = (0..set.truth.modes.len()).min_by(|a, b| off(a).total_cmp(&off(b)));
            let place = nearest.expect("a true mode");
            let truth = &set.truth.modes[place];
            let errors = [
                (
                    mode.frequency_hz - truth.frequency_hz,
                    mode.frequency_std_hz,
                    bound.frequency_std_hz[place],
                ),
                (
                    mode.loss_factor - truth.loss_factor,
                    mode.loss_factor_std,
                    bound.loss_factor_std[place],
                ),
            ];
            for (which, (error, bar, bound)) in errors.into_iter().enumerate() {
                self.held += f64::from(error.abs() <= SIGMAS_95 * bar);
                self.all += 1.0;
                let squares = self.squares.entry((which, place)).or_default();
                squares.push((error / bound).powi(2));
            }
        }
    }

    /// Root mean square of frequencies (0) or loss factors (1): median and worst mode.
    fn over_bound(&self, which: usize) -> (f64, f64) {
        let own = self.squares.range((which, 0)..(which + 1, 0));
        let rms = |squares: &Vec<f64>| (squares.iter().sum::<f64>() / squares.len() as f64).sqrt();
        let mut rms: Vec<f64> = own.map(|(_, squares)| rms(squares)).collect();
        rms.sort_by(f64::total_cmp);
        let (low, high) = (rms[(rms.len() - 1) / 2], rms[rms.len() / 2]);
        (0.5 * (low + high), rms[rms.len() - 1])
    }
}

/// Either law explains them, the wrong one with more poles.
#[test]
fn data_without_noise_take_the_law_that_needs_fewer_poles() {
    let one = [(403.3, 0.0065), (776.2, 0.0066), (1900.0, 0.01)];
    let four = [
        (46.4, 0.0188),
        (288.9, 0.0202),
        (360.1, 0.025),
        (875.3, 0.0216),
    ];
    let one_of_three = (&one[..], (455.0, 1422.0), 4, 1600);
    let all_of_four = (&four[..], (36.1, 971.0), 12, 400);
    for (modes, (low_hz, high_hz), responses, lines) in [one_of_three, all_of_four] {
        for seed in 1..=3 {
            let (natural_frequency_hz, loss_factor) = modes.iter().copied().unzip();
            let set = Synthetic {
                natural_frequency_hz,
                loss_factor,
                responses,
                damping: Damping::Viscous,
                frequency_hz: Array1::linspace(low_hz, high_hz, lines),
                snr_db: f64::INFINITY,
                seed,
                ..Synthetic::default()
            };
            let model = fitted(&set.build().expect("a set").frf, &FitOptions::default());
            let case = format!("{} modes, seed {seed}", modes.len());
            assert_eq!(model.damping, Damping::Viscous, "{case}");
            let found: Vec<f64> = model.in_band_modes().map(|m| m.frequency_hz).collect();
            let inside = modes.iter().filter(|m| low_hz < m.0 && m.0 < high_hz);
            assert_eq!(found.len(), inside.clone().count(), "{case}: {found:?}");
            for (found, (truth, _)) in found.iter().zip(inside) {
                let error = (found / truth - 1.0).abs();
                assert!(error < 1e-9, "{case}: {found} for {truth}");
            }
        }
    }
}

/// A few seeds by default; `CHLADNI_SEEDS=240` holds the fit to the goals: within 1.1 times
/// the bound in the median and 1.4 times for the worst mode, 92 to 97 % of the intervals.
/// The median of 60 seeds is off by 0.04 by chance, that of 240 by 0.02.
#[test]
fn errors_stand_at_the_bound_and_their_bars_hold() {
    let seeds = seeds(2);
    let (median_most, worst_most, held) = match seeds {
        ..20 => (1.6, 3.5, 0.85..1.0),
        20..200 => (1.2, 1.4, 0.92..0.97),
        _ => (1.1, 1.4, 0.92..0.97),
    };
    type Make = fn(f64, u64) -> SyntheticSet;
    let cases: [(&str, Make); 3] = [
        ("separate", separate),
        ("close, one reference", |db, seed| {
            close(1, &OUTSIDE_HZ, db, seed)
        }),
        ("close, three references", |db, seed| {
            close(3, &OUTSIDE_HZ, db, seed)
        }),
    ];
    for (name, make) in cases {
        for snr_db in [40.0, 60.0, 80.0] {
            let mut errors = Errors::default();
            for seed in 1..=seeds {
                let set = make(snr_db, seed);
                let model = fitted(&set.frf, &viscous());
                assert_exact(&set, &model, &format!("{name}, {snr_db} dB, seed {seed}"));
                errors.add(&set, &model);
            }
            let share = errors.held / errors.all;
            let ratios = [0, 1].map(|which| errors.over_bound(which));
            println!("{name}, {snr_db} dB: {ratios:.2?} of the bound, {share:.3} held");
            assert!(held.contains(&share), "{name}, {snr_db} dB: {share} held");
            for (median, worst) in ratios {
                assert!(
                    median <= median_most && worst <= worst_most,
                    "{name}, {snr_db} dB"
                );
            }
        }
    }
}

/// Faults of a measurement chain that turn all residues: degrees, and delays, s.
const FAULTS: [(f64, f64); 3] = [(0.0, 0.0), (0.5, 0.0), (0.0, 10e-6)];

/// Eight modes with a mean loss factor `loss`, within a factor of two, through a faulty
/// chain.
fn through(fault: (f64, f64), law: Damping, loss: f64, snr_db: f64, seed: u64) -> FrfSet {
    let spread = |n: usize| loss * 2.0f64.powf(((n * 5) % 8) as f64 / 7.0 - 0.5);
    let modes = SEPARATE
        .iter()
        .enumerate()
        .map(|(n, (f, _))| (*f, spread(n)));
    faulty(set(modes, law, 1, snr_db, seed).frf, fault)
}

/// FRFs with a phase, degrees, and a delay, s, that all of them share.
fn faulty(mut frf: FrfSet, fault: (f64, f64)) -> FrfSet {
    let axis = frf.frequency_hz.clone();
    let FrfValues::F64(values) = &mut frf.values else {
        panic!("simulated values are f64");
    };
    for ((_, _, k), value) in values.indexed_iter_mut() {
        let (degrees, delay_s) = fault;
        *value *= Complex64::from_polar(1.0, degrees.to_radians() - TAU * axis[k] * delay_s);
    }
    frf
}

/// Of 72 sets by default, of 1080 with `CHLADNI_SEEDS=30`: no wrong verdict, and at loss
/// factors from 1 % 85 % right at 40 dB, 99 % at 60 dB.
#[test]
fn no_phase_and_no_delay_makes_the_law_another() {
    let seeds = seeds(2);
    for snr_db in [40.0, 60.0] {
        let (mut right, mut all) = (0, 0);
        for loss in [0.01, 0.02, 0.04] {
            for fault in FAULTS {
                for (law, seed) in [Damping::Viscous, Damping::Structural]
                    .into_iter()
                    .flat_map(|law| (1..=seeds).map(move |seed| (law, seed)))
                {
                    let frf = through(fault, law, loss, snr_db, seed);
                    let model = fitted(&frf, &FitOptions::default());
                    let findings = &model.quality.findings;
                    let decided = !findings.iter().any(|f| f.code == "law-undecidable");
                    let case = format!("{law:?}, loss {loss}, {fault:?}, {snr_db} dB, seed {seed}");
                    assert!(!decided || model.damping == law, "{case}");
                    right += u32::from(decided);
                    all += 1;
                }
            }
        }
        let least = if snr_db < 50.0 { 0.85 } else { 0.99 };
        let share = f64::from(right) / f64::from(all);
        println!("{snr_db} dB: {right} of {all} laws told");
        assert!(share >= least, "{snr_db} dB: {right} of {all}");
    }
}

/// Loss factors all alike look like a phase of all FRFs, and complex shapes turn residues
/// more than a light mode's law does: most such sets tell no law, and none a wrong one.
#[test]
fn what_hides_the_law_gives_no_wrong_one() {
    let five_per_cent = SyntheticShapes::Turned { phase_deg: 3.0 };
    let thirty_per_cent = SyntheticShapes::Turned { phase_deg: 17.0 };
    let draws = [
        (SyntheticShapes::Real, (0.5, 0.0)),
        (five_per_cent, (0.0, 0.0)),
        (thirty_per_cent, (0.0, 0.0)),
    ];
    for law in [Damping::Viscous, Damping::Structural] {
        for (shapes, fault) in draws {
            for (loss, seed) in [0.005, 0.02]
                .into_iter()
                .flat_map(|loss| (1..=seeds(2)).map(move |seed| (loss, seed)))
            {
                let set = Synthetic {
                    natural_frequency_hz: SEPARATE.map(|(f, _)| f).to_vec(),
                    loss_factor: vec![loss],
                    responses: 12,
                    references: 1,
                    shapes,
                    damping: law,
                    frequency_hz: Array1::range(9.8, 499.6, 0.30625),
                    snr_db: 50.0,
                    seed,
                    ..Synthetic::default()
                };
                let frf = faulty(set.build().expect("a set").frf, fault);
                let model = fitted(&frf, &FitOptions::default());
                let open = |code: &str| code == "law-undecidable" || code == "law-if-phases-true";
                let told = !model.quality.findings.iter().any(|f| open(&f.code));
                let case = format!("{law:?}, {shapes:?}, {fault:?}, loss {loss}, seed {seed}");
                assert!(!told || model.damping == law, "{case}");
            }
        }
    }
}
