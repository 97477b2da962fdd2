//! The drive frequency that `--frequency` asks for.

use chladni_console::table::significant;
use chladni_frf::Finding;
use chladni_render::FrequencySweep;

/// Drive frequency on the command line.
#[derive(Debug, Clone, Copy)]
pub enum Frequency {
    /// The best one of a sweep.
    Auto,
    /// Hz.
    Hertz(f64),
}

impl std::str::FromStr for Frequency {
    type Err = String;
    fn from_str(text: &str) -> std::result::Result<Self, String> {
        match (text, text.parse::<f64>()) {
            ("auto", _) => Ok(Self::Auto),
            (_, Ok(hz)) if hz.is_finite() && hz > 0.0 => Ok(Self::Hertz(hz)),
            _ => Err("neither `auto` nor a frequency in Hz".into()),
        }
    }
}

/// A sweep of drive frequencies, and the range that it tried.
pub struct RangeSweep {
    pub range_hz: [f64; 2],
    pub sweep: FrequencySweep,
}

impl RangeSweep {
    /// Tells that the sweep suggests no frequency, and that the scene keeps its own.
    ///
    /// * `band_hz`: the fitted band of the model
    pub fn finding(&self, scene_hz: f64, band_hz: [f64; 2]) -> Option<Finding> {
        let [scene, low, high, from, to] = [
            scene_hz,
            self.range_hz[0],
            self.range_hz[1],
            band_hz[0],
            band_hz[1],
        ]
        .map(|hz| significant(hz, 6));
        let (reason, help) = match (self.sweep.suggested_hz, self.sweep.outside_band) {
            (Some(_), _) => return None,
            (None, true) => (
                format!("lies in the fitted band of {from} to {to} Hz"),
                "sweep a range inside the fitted band (--sweep LO:HI)",
            ),
            (None, false) => (
                "serves any response".to_owned(),
                "sweep another range (--sweep LO:HI), or ask less of the scene",
            ),
        };
        let words = format!(
            "the scene keeps its frequency of {scene} Hz: no frequency from {low} to {high} Hz {reason}"
        );
        Some(Finding::caution("frequency-kept", words).help(help))
    }
}
