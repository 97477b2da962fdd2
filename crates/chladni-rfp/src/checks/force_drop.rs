//! A shaker's force that drops at resonances, told by the shape of the lines it leaves under
//! a known window.
//!
//! Near a resonance the power of the force goes as |jω − s|²/|jω − p|², p = d·Re s + j·Im s:
//! it is not white within one line, and columns of a white force are off (theory.md, eq. F4f). Line
//! shapes with d = 1 and with d as one unknown of all modes are compared; between the two
//! lies what the force may have done to damping and height of a mode.

use crate::checks::case::Case;
use crate::checks::limits::{self, DECIDES};
use crate::checks::line_shape::{Fitted, Isolated, LineShape};
use crate::checks::window_bias::widen;
use crate::checks::witness::decades;
use crate::data::window::kinds::Window;
use chladni_frf::{Finding, ModalModel, Mode, Trust};
use rayon::prelude::*;
use std::f64::consts::TAU;

/// A drop that line shapes speak of.
#[derive(Debug, Clone)]
pub(crate) struct ForceDrop {
    /// Decay of the dip over that of the mode.
    ratio: f64,
    /// Log-likelihood over an even force.
    gain: f64,
    /// Frequencies of modes, Hz, and the relative changes of their decay and height.
    changes: Vec<(f64, [f64; 2])>,
}

/// The drop; `None` where the force is even, the window is not known, or lines are too few.
pub(crate) fn force_drop(case: &Case) -> Option<ForceDrop> {
    let window = case.data.window?;
    if matches!(
        window,
        Window::None | Window::Transient | Window::Burst { .. }
    ) {
        return None;
    }
    let kernel = window.kernel()?;
    let errors = case.data.errors.as_deref()?;
    let record_s = errors.cycles(TAU / case.data.omega_max);
    let modes: Vec<&Mode> = case.model.in_band_modes().collect();
    let fits_of = |mode: &&Mode| -> Option<(f64, Isolated, Vec<Fitted>)> {
        let isolated = Isolated::new(case, mode, &modes)?;
        if isolated.bandwidth() * record_s < limits::DROP_LINES * TAU {
            return None;
        }
        let fit = |drop: &f64| {
            let shape = LineShape {
                kernel: Some(&kernel),
                record_s,
                drop: *drop,
            };
            isolated.fitted(&shape, 0.0).ok()
        };
        let fits: Option<Vec<Fitted>> = limits::DROPS.iter().map(fit).collect();
        Some((mode.frequency_hz, isolated, fits?))
    };
    let all: Vec<(f64, Isolated, Vec<Fitted>)> = modes.par_iter().filter_map(fits_of).collect();
    let gain = |n: usize| -> f64 {
        let over = all.iter().map(|(_, isolated, fits)| {
            isolated.log_likelihood(&fits[n]) - isolated.log_likelihood(&fits[0])
        });
        over.sum()
    };
    let (gain, most) = (1..limits::DROPS.len())
        .map(|n| (gain(n), n))
        .max_by(|a, b| a.0.total_cmp(&b.0))?;
    let height = |fit: &Fitted| -> f64 {
        let squares = fit.strength.iter().map(|v| v.norm_sqr());
        squares.sum::<f64>().sqrt()
    };
    let change = |(hz, _, fits): &(f64, Isolated, Vec<Fitted>)| {
        let (even, dropping) = (&fits[0], &fits[most]);
        let decay = (dropping.pole.re / even.pole.re - 1.0).abs();
        let height = (height(dropping) / height(even).max(f64::MIN_POSITIVE) - 1.0).abs();
        (*hz, [decay, height])
    };
    (gain > DECIDES).then(|| ForceDrop {
        ratio: limits::DROPS[most],
        gain,
        changes: all.iter().map(change).collect(),
    })
}

impl ForceDrop {
    /// Widens the bars of all modes by what the drop may have changed; modes that do not
    /// stand alone by the most of the others.
    pub fn hold(&self, model: &mut ModalModel) {
        let most = |which: usize| {
            let each = self.changes.iter().map(|(_, change)| change[which]);
            each.fold(0.0, f64::max)
        };
        let most = [most(0), most(1)];
        let scaling = model.scaling;
        let stands = |mode: &&mut Mode| mode.in_band && mode.trust != Trust::Rejected;
        for mode in model.modes.iter_mut().filter(stands) {
            let own = self.changes.iter().find(|(hz, _)| *hz == mode.frequency_hz);
            let [decay, height] = own.map_or(most, |(_, change)| *change);
            // a residue is the square of a shape
            widen(mode, scaling, decay, 0.5 * height);
        }
    }

    /// The finding, in words.
    pub fn finding(&self) -> Finding {
        let drop_db = 20.0 * self.ratio.log10();
        let words = format!(
            "the force drops at resonances, by about {drop_db:.0} dB: the line shapes of {} mode(s) \
             say so (10^{:.0} times as likely as those of an even force); the line shape of the \
             window is that of an even force, so the error bars hold the difference",
            self.changes.len(),
            decades(self.gain)
        );
        Finding::caution("force-drop", words)
            .modes_hz(self.changes.iter().map(|(hz, _)| *hz))
            .value("drop_db", drop_db)
            .value("line_shape_nats", self.gain)
            .help(
                "estimate the FRFs from the records by the local rational method, which a drop \
                 does not bias",
            )
    }
}
