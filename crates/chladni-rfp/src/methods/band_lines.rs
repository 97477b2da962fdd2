//! The lines of one band, and the health of the method by the roots that it finds there.

use crate::data::screening::Screened;
use crate::methods::bands::Band;
use crate::methods::equation_error::{BandEquations, Root};
use crate::methods::found::negative_damping;
use crate::methods::limits::{BROADEST, CONDITION_HELD, MOST_UNCERTAIN};
use chladni_frf::Finding;
use num_complex::Complex64;

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
) -> Vec<Finding> {
    let mut warnings = Vec::new();
    let ill = conditions.iter().filter(|c| **c > CONDITION_HELD).count();
    if ill > 0 {
        let worst = conditions.iter().fold(0.0_f64, |m, c| m.max(*c));
        let of = if conditions.len() > 1 {
            format!(" in {ill} of {} FRFs", conditions.len())
        } else {
            String::new()
        };
        warnings.push(
            Finding::caution(
                "ill-conditioned",
                format!(
                    "{label}: the equations are ill-conditioned{of} (condition {worst:.0e}): the \
                     order is higher than the data can tell (harmless without noise)"
                ),
            )
            .value("condition", worst)
            .help("ask for fewer modes, or fit a narrower band"),
        );
    }
    let inside: Vec<&Root> = roots.iter().filter(|root| lines.in_band(root.s)).collect();
    let negative = inside.iter().filter(|root| root.s.re > 0.0).count();
    if 2 * negative > inside.len() {
        warnings.push(negative_damping(
            &format!("{label}: "),
            negative,
            inside.len(),
        ));
    }
    warnings
}
