//! The interface of the family: poles by one method, and the numbers that the classic
//! methods share.

use crate::data::error::FitError;
use crate::data::options::FitOptions;
use crate::data::screening::Screened;
use crate::methods::bands::Band;
use crate::methods::equation_error::{BandEquations, Root};
use crate::methods::stabilization::Stabilization;
use crate::methods::survey::{Compressed, Survey};
use chladni_frf::Damping;
use num_complex::Complex64;

/// Numerator terms beyond two per mode, for modes outside the band. Zero to four do
/// equally well once there are spare pole pairs.
pub(crate) const NUMERATOR_EXTRA: usize = 2;
/// Spectral lines (two real equations each) wanted for each real unknown of one FRF. At
/// one half the system is square and the fit reproduces the noise.
pub(crate) const LINES_PER_UNKNOWN: usize = 1;
/// Pole pairs beyond the peaks or the modes asked for. Four modes, 24 FRFs, 20 dB: none
/// to spare misses all four modes, two miss one, four none. Eight modes at 40 dB: one
/// misses up to three, two and more none, with a tenth of the error or less.
pub(crate) const SPARE_PAIRS: usize = 4;
/// Most visible peaks per band: with the spare pairs what the method holds.
pub(crate) const PEAKS_PER_BAND: usize = ORDER_HELD - SPARE_PAIRS;
/// Pole pairs per band that the method holds. D spans about twelve decades over twenty
/// even-spaced modes, and no weight is right for all of them at once.
pub(crate) const ORDER_HELD: usize = 12;
/// Condition beyond which the last digits of the measurement decide the answer.
pub(crate) const CONDITION_HELD: f64 = 1e12;
/// Half-bandwidth of the broadest pole that counts as a mode, relative to the width of
/// the band: broader ones stand for what lies outside.
pub(crate) const BROADEST: f64 = 0.5;
/// Largest standard deviation of a natural frequency relative to the half-bandwidth that
/// still counts as a mode. Modes stand below a third, computational poles mostly between
/// one and a thousand.
pub(crate) const MOST_UNCERTAIN: f64 = 0.5;

/// What a method found.
#[derive(Debug, Clone)]
pub(crate) struct MethodPoles {
    /// s/ω_max, upper half plane, Re s < 0; those out of the band stand for what lies
    /// there.
    pub poles: Vec<Complex64>,
    /// One sigma of |s|/ω_max and of η per pole where the method knows its own scatter.
    pub deviation: Option<Vec<[f64; 2]>>,
    /// Damping law to report in where none was asked for.
    pub law: Damping,
    /// What a user should know.
    pub warnings: Vec<String>,
    /// How they were found, in words.
    pub how: &'static str,
    /// Poles by order, where the method looks at several.
    pub stabilization: Option<Stabilization>,
}

/// A method: poles from the two passes over the data.
pub(crate) type Finder = fn(&Survey, &Compressed, &FitOptions) -> Result<MethodPoles, FitError>;

impl From<ClassicPoles> for MethodPoles {
    fn from(found: ClassicPoles) -> Self {
        Self {
            poles: found.poles,
            deviation: Some(found.deviation),
            law: Damping::Viscous,
            warnings: found.warnings,
            how: "linear equation error in orthogonal polynomials",
            stabilization: None,
        }
    }
}

/// What a classic method found.
#[derive(Debug, Clone, Default)]
pub(crate) struct ClassicPoles {
    /// s/ω_max, viscous, upper half plane, Re s < 0, rising in frequency.
    pub poles: Vec<Complex64>,
    /// One sigma of |s|/ω_max and of η = 2ζ per pole: scatter, not the method's bias.
    pub deviation: Vec<[f64; 2]>,
    /// What a user should know.
    pub warnings: Vec<String>,
}

impl ClassicPoles {
    /// Sorts out of `modes` what the user asked for: the most certain ones, all if no
    /// number was given.
    pub(crate) fn with_modes(mut self, mut modes: Vec<Root>, asked: Option<usize>) -> Self {
        modes.sort_by(|a, b| a.uncertainty().total_cmp(&b.uncertainty()));
        modes.truncate(asked.unwrap_or(usize::MAX));
        modes.sort_by(|a, b| a.s.im.total_cmp(&b.s.im));
        if let Some(asked) = asked.filter(|asked| *asked > modes.len()) {
            self.warnings.push(format!(
                "{asked} modes asked for, {} found: no further damped pole in the \
                               band is certain enough",
                modes.len()
            ));
        }
        self.poles = modes.iter().map(|root| root.s).collect();
        self.deviation = modes.iter().map(|root| root.deviation).collect();
        self
    }
}

/// The lines of one band: equations, limits of what counts as a mode there.
pub(crate) struct BandLines {
    pub equations: BandEquations,
    /// y of the first and the last line.
    pub reach: [f64; 2],
    /// Mean line spacing in y.
    pub spacing: f64,
}

impl BandLines {
    pub(crate) fn new(data: &Screened, band: &Band) -> Result<Self, chladni_linalg::LinalgError> {
        let y: Vec<f64> = data.x[band.rows.clone()].iter().map(|x| x.sqrt()).collect();
        let reach = [y[0], y[y.len() - 1]];
        let spacing = (reach[1] - reach[0]) / (y.len() - 1).max(1) as f64;
        Ok(Self {
            equations: BandEquations::new(y, band.order, data.kind.omega_power() as usize)?,
            reach,
            spacing,
        })
    }

    pub(crate) fn in_band(&self, s: Complex64) -> bool {
        s.im >= self.reach[0] && s.im <= self.reach[1]
    }

    /// A mode of the band: damped, its peak inside, no background, and known better than
    /// its own bandwidth.
    pub(crate) fn physical(&self, root: &Root) -> bool {
        let width = self.reach[1] - self.reach[0];
        root.s.re < 0.0
            && self.in_band(root.s)
            && -root.s.re <= BROADEST * width
            && root.uncertainty() <= MOST_UNCERTAIN
    }
}

/// Says what the roots of one band tell about the method's health: condition, and the
/// time sign.
pub(crate) fn health(
    label: &str,
    conditions: &[f64],
    roots: &[Root],
    lines: &BandLines,
) -> Vec<String> {
    let mut warnings = Vec::new();
    let ill = conditions.iter().filter(|c| **c > CONDITION_HELD).count();
    if ill > 0 {
        let worst = conditions.iter().fold(0.0_f64, |m, c| m.max(*c));
        let of = if conditions.len() > 1 {
            format!(" in {ill} of {} FRFs", conditions.len())
        } else {
            String::new()
        };
        warnings.push(format!(
            "{label}: the equations are ill-conditioned{of} (condition {worst:.0e}): the order is higher than the data can tell \
             (harmless without noise, where the order can be any); ask for fewer modes or fit a narrower band"
        ));
    }
    let inside: Vec<&Root> = roots.iter().filter(|root| lines.in_band(root.s)).collect();
    let negative = inside.iter().filter(|root| root.s.re > 0.0).count();
    if 2 * negative > inside.len() {
        warnings.push(format!(
            "{label}: {negative} of {} poles in the band have negative damping; the data may \
             follow e^(-jwt), or hold no mode",
            inside.len()
        ));
    }
    warnings
}
