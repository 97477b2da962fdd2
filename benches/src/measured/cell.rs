//! The ways to measure that are simulated.

use chladni_frf::BlockWindow;
use chladni_rfp::{Correlation, Window};

/// Length of a record, s: lines 0.5 Hz apart.
pub(super) const RECORD_S: f64 = 2.0;

/// Responses of most cells.
const RESPONSES: usize = 3;

/// Noise of the responses below their mean square of most cells, dB.
pub(super) const SNR_DB: f64 = 50.0;

/// The excitation of the structure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum MeasuredForce {
    /// Noise without beginning or end.
    Random,
    /// Noise in the first part of each record, the structure at rest before.
    Burst(f64),
    /// A blow at the start of each record, the structure at rest before.
    Hammer,
    /// Sine by sine: FRFs with independent noise on every line, no records.
    Sines,
}

/// One way to measure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeasuredCell {
    /// Excitation.
    pub force: MeasuredForce,
    /// Responses.
    pub responses: usize,
    /// Forces at once, independent of each other, the first at the first response and so on.
    pub forces: usize,
    /// Window of the blocks.
    pub window: BlockWindow,
    /// Window of an analyser in place of it, one that `estimate` lacks: the set does not
    /// tell how it was made, the user names the window to the fit.
    pub analyser: Option<Window>,
    /// Length of all that is measured, in records.
    pub records: usize,
    /// Overlap of blocks.
    pub overlap: f64,
    /// Lines per half-power bandwidth of every mode.
    pub lines_per_bandwidth: f64,
    /// Drop of the force at each resonance, dB.
    pub drop_db: f64,
    /// Noise of the force below it, dB.
    pub force_snr_db: f64,
    /// Noise of the responses below their mean square, dB.
    pub snr_db: f64,
}

impl MeasuredCell {
    /// Correlation that the errors of neighbouring lines of its averaged FRFs have.
    ///
    /// Windows of analysers (flat top, Kaiser) fall off to both ends.
    pub fn correlation(&self) -> Correlation {
        if self.analyser.is_some() {
            return Correlation::Tapered;
        }
        match (self.force, self.window) {
            (MeasuredForce::Random | MeasuredForce::Burst(_), BlockWindow::Hann) => {
                Correlation::Tapered
            }
            (_, BlockWindow::Exponential { .. }) => Correlation::Exponential,
            _ => Correlation::White,
        }
    }

    /// True with one force and few responses.
    pub fn is_simple(&self) -> bool {
        self.forces == 1 && self.responses == RESPONSES
    }

    /// Blocks that are averaged.
    pub fn averages(&self) -> usize {
        let hop = 1.0 - self.overlap;
        ((self.records as f64 - 1.0) / hop + 1e-6) as usize + 1
    }

    /// The window in words.
    pub fn window_name(&self) -> String {
        match self.analyser {
            Some(window) => window.to_string(),
            None => self.window.name().to_owned(),
        }
    }

    /// In words, its own for each cell of the table.
    pub fn name(&self) -> String {
        let force = match self.force {
            MeasuredForce::Random => "random".into(),
            MeasuredForce::Burst(part) => format!("burst {part}"),
            MeasuredForce::Hammer => "hammer".into(),
            MeasuredForce::Sines => "sines".into(),
        };
        let mut name = match self.force {
            MeasuredForce::Sines => force,
            _ => format!("{force} {} {}", self.window_name(), self.averages()),
        };
        if self.forces > 1 {
            name += &format!(" of {} forces", self.forces);
        }
        if self.overlap > 0.0 {
            name += &format!(" x {:.2}", self.overlap);
        }
        name += &format!(" b={}", self.lines_per_bandwidth);
        if self.responses != RESPONSES {
            name += &format!(" {} responses", self.responses);
        }
        if self.drop_db > 0.0 {
            name += &format!(" drop {} dB", self.drop_db);
        }
        if self.force_snr_db.is_finite() {
            name += &format!(" force {} dB", self.force_snr_db);
        }
        if self.snr_db != SNR_DB {
            name += &format!(" noise {} dB", self.snr_db);
        }
        name
    }
}

/// 16 records of continuous noise, Hann, two thirds overlap: what `estimate --estimator
/// h1` does.
const HANN: MeasuredCell = MeasuredCell {
    force: MeasuredForce::Random,
    responses: RESPONSES,
    forces: 1,
    window: BlockWindow::Hann,
    analyser: None,
    records: 16,
    overlap: 2.0 / 3.0,
    lines_per_bandwidth: 2.0,
    drop_db: 0.0,
    force_snr_db: f64::INFINITY,
    snr_db: SNR_DB,
};
const RECTANGULAR: MeasuredCell = MeasuredCell {
    window: BlockWindow::Rectangular,
    records: 30,
    overlap: 0.0,
    ..HANN
};
/// As analysers do by default: half-overlapped blocks.
const FLATTOP: MeasuredCell = MeasuredCell {
    analyser: Some(Window::Flattop),
    overlap: 0.5,
    ..HANN
};
const KAISER: MeasuredCell = MeasuredCell {
    analyser: Some(Window::Kaiser { beta: 8.6 }),
    ..FLATTOP
};
const BURST: MeasuredCell = MeasuredCell {
    force: MeasuredForce::Burst(0.9),
    ..RECTANGULAR
};
/// A Hann window that has no business there.
const BURST_HANN: MeasuredCell = MeasuredCell {
    window: BlockWindow::Hann,
    ..BURST
};
const fn part(part: f64, cell: MeasuredCell) -> MeasuredCell {
    MeasuredCell {
        force: MeasuredForce::Burst(part),
        ..cell
    }
}
const HAMMER: MeasuredCell = MeasuredCell {
    force: MeasuredForce::Hammer,
    records: 5,
    ..RECTANGULAR
};
/// e^{−3} at the end of a record.
const EXPONENTIAL: MeasuredCell = MeasuredCell {
    window: BlockWindow::Exponential {
        rate_per_s: 3.0 / RECORD_S,
    },
    ..HAMMER
};

const SINES: MeasuredCell = MeasuredCell {
    force: MeasuredForce::Sines,
    records: 1,
    ..RECTANGULAR
};

const fn at(lines_per_bandwidth: f64, cell: MeasuredCell) -> MeasuredCell {
    MeasuredCell {
        lines_per_bandwidth,
        ..cell
    }
}

const fn dropping(drop_db: f64, cell: MeasuredCell) -> MeasuredCell {
    MeasuredCell { drop_db, ..cell }
}

const fn noisy(force_snr_db: f64, cell: MeasuredCell) -> MeasuredCell {
    MeasuredCell {
        force_snr_db,
        ..cell
    }
}

/// Noise of the responses of a poor test below their mean square, dB.
pub(super) const POOR_DB: f64 = 30.0;

/// Two forces at once.
const fn two(cell: MeasuredCell) -> MeasuredCell {
    MeasuredCell { forces: 2, ..cell }
}

/// More FRFs than a fit takes one by one.
const fn many(cell: MeasuredCell) -> MeasuredCell {
    MeasuredCell {
        responses: 30,
        ..cell
    }
}

/// As loud as responses of a poor test.
const fn loud(cell: MeasuredCell) -> MeasuredCell {
    MeasuredCell {
        snr_db: POOR_DB,
        ..cell
    }
}

/// All of them.
pub const MEASURED_CELLS: &[MeasuredCell] = &[
    at(1.0, HANN),
    at(2.0, HANN),
    at(4.0, HANN),
    at(8.0, HANN),
    MeasuredCell {
        records: 64,
        ..at(1.0, HANN)
    },
    MeasuredCell {
        records: 64,
        ..at(2.0, HANN)
    },
    MeasuredCell {
        overlap: 0.0,
        records: 30,
        ..at(2.0, HANN)
    },
    at(1.0, RECTANGULAR),
    at(2.0, RECTANGULAR),
    at(4.0, RECTANGULAR),
    at(2.0, FLATTOP),
    at(4.0, FLATTOP),
    at(8.0, FLATTOP),
    at(1.0, KAISER),
    at(2.0, KAISER),
    at(4.0, KAISER),
    at(1.0, BURST),
    at(2.0, BURST),
    at(4.0, BURST),
    at(2.0, part(0.3, BURST_HANN)),
    at(2.0, part(0.6, BURST_HANN)),
    at(2.0, BURST_HANN),
    at(1.0, HAMMER),
    at(2.0, HAMMER),
    at(1.0, EXPONENTIAL),
    at(4.0, EXPONENTIAL),
    noisy(34.0, at(1.0, EXPONENTIAL)),
    noisy(34.0, at(4.0, EXPONENTIAL)),
    at(1.0, SINES),
    at(2.0, SINES),
    at(4.0, SINES),
    dropping(12.0, at(2.0, HANN)),
    dropping(12.0, at(4.0, HANN)),
    dropping(30.0, at(4.0, HANN)),
    noisy(34.0, at(4.0, HANN)),
    noisy(34.0, dropping(20.0, at(4.0, HANN))),
    two(at(2.0, HANN)),
    two(at(4.0, HANN)),
    two(dropping(12.0, at(4.0, HANN))),
    two(loud(at(2.0, HANN))),
    many(at(2.0, HANN)),
    many(dropping(12.0, at(2.0, HANN))),
    many(dropping(12.0, at(4.0, HANN))),
    many(loud(at(4.0, HANN))),
    many(loud(at(8.0, HANN))),
    loud(at(0.5, HANN)),
    loud(at(1.0, HANN)),
    loud(at(2.0, HANN)),
    loud(at(4.0, HANN)),
    loud(at(8.0, HANN)),
];
