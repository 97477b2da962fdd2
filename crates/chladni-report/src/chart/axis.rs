//! Axes: label, unit, scale, ticks.

use crate::text::{fixed, superscript};

/// Linear or logarithmic.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum Scale {
    /// Equal steps.
    #[default]
    Linear,
    /// Equal factors; values that are not positive are left out.
    Log,
}

/// An axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    /// The quantity that it shows.
    pub label: String,
    /// Its unit; `–` for a plain number.
    pub unit: String,
    /// Scale.
    pub scale: Scale,
    /// Ends; `None`: those of the data.
    pub range: Option<[f64; 2]>,
    /// Part of the range added at both ends where the data give it.
    pub padding: f64,
    /// Distance of ticks; `None`: chosen.
    pub step: Option<f64>,
    /// Names at places instead of numbers.
    pub names: Option<Vec<(f64, String)>>,
}

impl Axis {
    /// A linear axis over its data.
    pub fn linear(label: &str, unit: &str) -> Self {
        Self {
            label: label.into(),
            unit: unit.into(),
            scale: Scale::Linear,
            range: None,
            padding: 0.0,
            step: None,
            names: None,
        }
    }
    /// A logarithmic axis over its data.
    pub fn log(label: &str, unit: &str) -> Self {
        Self {
            scale: Scale::Log,
            ..Self::linear(label, unit)
        }
    }
    /// With these ends.
    pub fn range(self, range: [f64; 2]) -> Self {
        Self {
            range: Some(range),
            ..self
        }
    }
    /// With this part of the range added at both ends.
    pub fn padded(self, padding: f64) -> Self {
        Self { padding, ..self }
    }
    /// With ticks so far apart.
    pub fn step(self, step: f64) -> Self {
        Self {
            step: Some(step),
            ..self
        }
    }
    /// With names at places instead of numbers.
    pub fn names(self, names: Vec<(f64, String)>) -> Self {
        Self {
            names: Some(names),
            ..self
        }
    }

    /// Label and unit as the chart prints them.
    pub fn caption(&self) -> String {
        format!("{} ({})", self.label, self.unit)
    }

    /// The ends for data between `data[0]` and `data[1]`; without data these are +∞ and −∞.
    pub(crate) fn ends(&self, data: [f64; 2]) -> [f64; 2] {
        if let Some(range) = self.range {
            return range;
        }
        let [low, high] = if data[0] <= data[1] { data } else { [0.0, 1.0] };
        match self.scale {
            Scale::Linear => {
                let span = if high > low {
                    high - low
                } else {
                    low.abs().max(1.0)
                };
                let pad = if high > low {
                    self.padding * span
                } else {
                    0.5 * span
                };
                [low - pad, high + pad]
            }
            Scale::Log => {
                let (low, high) = if low > 0.0 { (low, high) } else { (1.0, 10.0) };
                let factor = if high > low {
                    (high / low).powf(self.padding)
                } else {
                    3.0
                };
                [low / factor, high * factor]
            }
        }
    }

    /// Places and texts of the ticks between the ends, about `tick_px` apart where the axis has
    /// neither step nor names. Small ticks have an empty text.
    pub(crate) fn ticks(
        &self,
        [low, high]: [f64; 2],
        length_px: f64,
        tick_px: f64,
    ) -> Vec<(f64, String)> {
        if let Some(names) = &self.names {
            return names
                .iter()
                .filter(|(place, _)| (low..=high).contains(place))
                .cloned()
                .collect();
        }
        match self.scale {
            Scale::Linear => linear_ticks(low, high, self.step, length_px, tick_px),
            Scale::Log => log_ticks(low, high, length_px, tick_px),
        }
    }
}

/// Px from tick to tick along x: room for a number.
pub(crate) const ALONG_X: f64 = 68.0;
/// Px from tick to tick along y: room for some lines.
pub(crate) const ALONG_Y: f64 = 36.0;
/// Most ticks on an axis.
const MAX_TICKS: f64 = 60.0;

fn linear_ticks(
    low: f64,
    high: f64,
    step: Option<f64>,
    length_px: f64,
    tick_px: f64,
) -> Vec<(f64, String)> {
    let span = high - low;
    if span.is_nan() || span <= 0.0 || !span.is_finite() {
        return Vec::new();
    }
    let step = step
        .filter(|step| span / step <= MAX_TICKS)
        .unwrap_or_else(|| nice_step(span * tick_px.min(length_px / 2.0) / length_px));
    let decimals = (-step.log10().floor()).clamp(0.0, 12.0) as usize;
    // steps such as 0.25 need one more decimal
    let decimals =
        decimals + usize::from(((step * 10f64.powi(decimals as i32)).fract() - 0.5).abs() < 0.1);
    let slack = 1e-9 * span;
    let (first, last) = (
        ((low - slack) / step).ceil() as i64,
        ((high + slack) / step).floor() as i64,
    );
    (first..=last)
        .map(|k| k as f64 * step)
        .map(|value| (value, fixed(value, decimals)))
        .collect()
}

/// The next larger of 1, 2, 2.5, 5 times a power of ten.
fn nice_step(rough: f64) -> f64 {
    let power = 10f64.powf(rough.log10().floor());
    let part = rough / power;
    let nice = [1.0, 2.0, 2.5, 5.0, 10.0]
        .into_iter()
        .find(|&nice| part <= nice * (1.0 + 1e-9))
        .unwrap_or(10.0);
    nice * power
}

fn log_ticks(low: f64, high: f64, length_px: f64, tick_px: f64) -> Vec<(f64, String)> {
    let (first, last) = (low.log10(), high.log10());
    let decades = last - first;
    if decades.is_nan() || decades <= 0.0 || !decades.is_finite() {
        return Vec::new();
    }
    let px_per_decade = length_px / decades;
    // every decade is named, or every second, third, ... where there is no room
    let every = (0.5 * tick_px / px_per_decade).ceil().max(1.0) as i32;
    let mut ticks = Vec::new();
    for exponent in first.floor() as i32..=last.ceil() as i32 {
        for digit in 1..10 {
            let value = f64::from(digit) * 10f64.powi(exponent);
            if value < low * (1.0 - 1e-9) || value > high * (1.0 + 1e-9) {
                continue;
            }
            let named = match digit {
                1 => exponent.rem_euclid(every) == 0,
                2 | 5 => px_per_decade > 3.0 * tick_px,
                _ => false,
            };
            if named {
                ticks.push((value, decade_name(digit, exponent)));
            } else if px_per_decade > 0.5 * tick_px || digit == 1 {
                ticks.push((value, String::new()));
            }
        }
    }
    ticks
}

fn decade_name(digit: i32, exponent: i32) -> String {
    if (-3..=4).contains(&exponent) {
        return fixed(
            f64::from(digit) * 10f64.powi(exponent),
            (-exponent).max(0) as usize,
        );
    }
    let factor = if digit == 1 {
        String::new()
    } else {
        format!("{digit}·")
    };
    format!("{factor}10{}", superscript(exponent))
}

/// The map from values to px along an axis.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Ruler {
    pub(crate) ends: [f64; 2],
    pub(crate) px: [f64; 2],
    pub(crate) log: bool,
}

impl Ruler {
    /// Place of `value`, px; NaN where it has none.
    pub(crate) fn place(&self, value: f64) -> f64 {
        let part = if self.log {
            if value <= 0.0 {
                return f64::NAN;
            }
            (value / self.ends[0]).ln() / (self.ends[1] / self.ends[0]).ln()
        } else {
            (value - self.ends[0]) / (self.ends[1] - self.ends[0])
        };
        self.px[0] + part * (self.px[1] - self.px[0])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(ticks: &[(f64, String)]) -> Vec<&str> {
        ticks
            .iter()
            .map(|tick| tick.1.as_str())
            .filter(|name| !name.is_empty())
            .collect()
    }

    #[test]
    fn ticks_are_round_numbers_inside_the_range() {
        assert_eq!(
            names(&Axis::linear("x", "Hz").ticks([2.0, 1000.0], 700.0, ALONG_X)),
            ["100", "200", "300", "400", "500", "600", "700", "800", "900", "1000"]
        );
        assert_eq!(
            names(&Axis::linear("x", "mm").ticks([0.0, 1.0], 300.0, ALONG_X)),
            ["0.00", "0.25", "0.50", "0.75", "1.00"]
        );
        assert_eq!(
            names(
                &Axis::linear("x", "°")
                    .step(90.0)
                    .ticks([-180.0, 180.0], 100.0, ALONG_Y)
            ),
            ["−180", "−90", "0", "90", "180"]
        );
        assert_eq!(
            names(&Axis::log("x", "s").ticks([0.02, 300.0], 600.0, ALONG_X)),
            ["0.1", "1", "10", "100"]
        );
        assert!(Axis::linear("x", "Hz")
            .ticks([1.0, 1.0], 300.0, ALONG_X)
            .is_empty());
    }

    #[test]
    fn logarithmic_places_are_equal_factors_apart() {
        let ruler = Ruler {
            ends: [1.0, 100.0],
            px: [0.0, 200.0],
            log: true,
        };
        assert!((ruler.place(10.0) - 100.0).abs() < 1e-12 && ruler.place(0.0).is_nan());
    }
}
