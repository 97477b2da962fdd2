//! Identification of FRFs that an analyser would have estimated: simulated in time, windowed, averaged (H₁). The truth is
//! that of the simulator (chladni-plate, `time.rs`), which knows nothing of the identification.

use chladni_frf::{ModalModel, Mode, Trust};
use chladni_plate::{Excitation, TimeTest, Window};
use chladni_rfp::{fit, FitOptions};

/// Record length, s: lines 0.5 Hz apart.
const RECORD_S: f64 = 2.0;
/// Natural frequencies, Hz: separate by 30 lines and more.
const MODES: [f64; 6] = [41.3, 87.7, 140.2, 203.9, 281.4, 352.6];

/// One row of the table.
struct Case {
    excitation: Excitation,
    window: Window,
    responses: usize,
    /// Half-power bandwidth of every mode in lines.
    lines_per_bandwidth: f64,
    snr_db: f64,
}

impl Case {
    fn bandwidth_hz(&self) -> f64 {
        self.lines_per_bandwidth / RECORD_S
    }

    fn test(&self, seed: u64) -> TimeTest {
        TimeTest {
            natural_frequency_hz: MODES.to_vec(),
            damping_ratio: MODES.iter().map(|f| self.bandwidth_hz() / (2.0 * f)).collect(),
            responses: self.responses,
            sample_rate_hz: 1024.0,
            record_s: RECORD_S,
            padding: 1,
            band_hz: [10.0, 400.0],
            averages: if self.excitation == Excitation::Random { 32 } else { 8 },
            excitation: self.excitation,
            window: self.window,
            snr_db: self.snr_db,
            seed,
        }
    }
}

const HAMMER: Excitation = Excitation::Hammer { contact_s: 0.004 };
const BURST: Excitation = Excitation::BurstRandom { part: 0.5 };
/// e^{−3} at the end of the record.
const EXPONENTIAL: Window = Window::Exponential { rate_per_s: 1.5 };

/// Four cases for each way to measure: FRFs, lines per bandwidth and noise turn in a Latin square.
fn cases() -> Vec<Case> {
    let ways = [
        (HAMMER, Window::Rectangular),
        (HAMMER, EXPONENTIAL),
        (BURST, Window::Rectangular),
        // wrong: the window weighs the start of the response, where most of it is, least
        (BURST, Window::Hann),
        (Excitation::Random, Window::Hann),
        (Excitation::Random, Window::Rectangular),
    ];
    let squares = [(1, 3.0, 40.0), (3, 1.5, 30.0), (6, 6.0, 25.0), (3, 3.0, 35.0), (6, 1.5, 40.0), (1, 6.0, 30.0)];
    let mut all = Vec::new();
    for (w, (excitation, window)) in ways.into_iter().enumerate() {
        for step in 0..4 {
            let (responses, lines_per_bandwidth, snr_db) = squares[(w + step) % squares.len()];
            all.push(Case { excitation, window, responses, lines_per_bandwidth, snr_db });
        }
    }
    all
}

/// Modes of the structure that no mode of the model stands for, and `sure` modes that stand for none or for one already taken.
fn missed_and_false(case: &Case, model: &ModalModel) -> (Vec<f64>, Vec<f64>) {
    // a window broadens lines; half a broadened bandwidth is less than two lines more
    let near = |mode: &Mode, f: f64| (mode.frequency_hz - f).abs() < 0.5 * case.bandwidth_hz() + 0.5 / RECORD_S;
    let missed = MODES.iter().copied().filter(|f| !model.in_band_modes().any(|m| near(m, *f))).collect();
    let mut free = MODES.to_vec();
    let mut wrong = Vec::new();
    for mode in model.in_band_modes().filter(|m| m.trust == Trust::Sure) {
        match free.iter().position(|f| near(mode, *f)) {
            Some(taken) => drop(free.remove(taken)),
            None => wrong.push(mode.frequency_hz),
        }
    }
    (missed, wrong)
}

#[test]
fn every_mode_is_found_and_no_false_one_is_sure() {
    let cases = cases();
    assert_eq!(cases.len(), 24);
    let mut failures = Vec::new();
    let (mut sure, mut weak) = (0, 0);
    for (number, case) in cases.iter().enumerate() {
        let set = case.test(number as u64).build().unwrap();
        let model = fit(&set.frf, &FitOptions::default(), &|_| {}).unwrap().model;
        let (missed, wrong) = missed_and_false(case, &model);
        sure += model.in_band_modes().filter(|m| m.trust == Trust::Sure).count();
        weak += model.in_band_modes().filter(|m| m.trust == Trust::Weak).count();
        println!(
            "{number}: {:?} {:?}, {} FRFs, {} lines per bandwidth, {} dB: missed {missed:?}, false {wrong:?}; {:?}",
            case.excitation, case.window, case.responses, case.lines_per_bandwidth, case.snr_db, model.quality.path
        );
        for m in &model.modes {
            println!("    {:9.3} ± {:.3} Hz, zeta {:.5} {:?} {:?}", m.frequency_hz, m.frequency_std_hz, m.damping_ratio, m.trust, m.reasons);
        }
        if !missed.is_empty() || !wrong.is_empty() {
            failures.push(number);
        }
    }
    println!("{sure} sure, {weak} weak of {} modes", 24 * MODES.len());
    assert!(failures.is_empty(), "cases {failures:?}");
}
