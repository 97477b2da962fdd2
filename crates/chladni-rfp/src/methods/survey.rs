//! The common start of every method of the family: one pass over the data for the count
//! sketch and the visible peaks, and a second one for the compressed columns.
//!
//! The compression is a randomised singular value decomposition: the strongest left
//! singular vectors of the sketch span the lines' directions that carry more than noise,
//! and the pass of theory.md, eq. 13–15, turns them into at most twice as many real
//! mixtures of all FRFs. They hold the signal of the whole set at its signal-to-noise
//! ratio; no method sees the truth of another's poles. N. Halko, P. G. Martinsson, J. A.
//! Tropp, SIAM Rev. 53 (2011) 217–288.

use super::limits::{EXPECTED, LINES_PER_MODE, NOISE_HALF_WINDOW, SPARE_POLES};
use crate::damping::basis::RESIDUAL_POWERS;
use crate::damping::verdict::{verdict, Fitted, Verdict, Window};
use crate::data::columns::{line_energy, Columns};
use crate::data::options::FitOptions;
use crate::data::peaks::{fourth_difference_noise, peaks, thinned, Peak};
use crate::data::products::{measured_basis, project};
use crate::data::screening::Screened;
use crate::data::source::Source;
use crate::poles::rank::rank_over_noise;
use crate::poles::refine::Projection;
use crate::tolerances as tol;
use chladni_linalg::{matmul, qr_thin, svd_thin, LinalgError};
use ndarray::{s, Array1, Array2};
use num_complex::Complex64;

/// The first pass.
pub(crate) struct Survey<'a> {
    /// The measurement.
    pub data: &'a Screened<'a>,
    /// Signed sums of FRFs.
    pub sketch: Columns,
    /// Energy of each line over all FRFs.
    pub energy: Array1<f64>,
    /// Visible peaks of the energy, the most prominent first.
    pub peaks: Vec<Peak>,
}

/// The second pass.
pub(crate) struct Compressed {
    /// Real mixtures of FRFs, or the FRFs themselves where there are few.
    pub work: Columns,
    /// From columns to FRFs, (column, FRF), orthonormal rows; `None`: the columns are the
    /// FRFs.
    pub back: Option<Array2<f64>>,
    /// Energy of all FRFs that the columns do not hold: noise.
    pub outside: f64,
    /// Directions of the lines that stand out of the noise.
    pub rank: usize,
}

impl<'a> Survey<'a> {
    /// Runs the first pass.
    pub fn new(data: &'a Screened<'a>, seed: u64) -> Self {
        let (sketch, energy) = data.sketch(seed);
        let mean = &energy / data.pairs.len() as f64;
        let noise = fourth_difference_noise(&sketch, NOISE_HALF_WINDOW);
        let peaks = peaks(&sketch, &mean, &noise);
        Self {
            data,
            sketch,
            energy,
            peaks,
        }
    }

    /// Runs the second pass.
    ///
    /// # Errors
    /// A decomposition that fails.
    pub fn compress(&self) -> Result<Compressed, LinalgError> {
        let sketch = &self.sketch;
        let whole = |rank| Compressed {
            work: sketch.clone(),
            back: None,
            outside: 0.0,
            rank,
        };
        let of_frfs = sketch.columns() == self.data.pairs.len();
        let wide = sketch.lines() <= sketch.columns();
        if wide && of_frfs {
            return Ok(whole(self.peaks.len()));
        }
        let (u, singular_values) = if wide {
            let (u, values, _) = svd_thin(sketch.b.view())?;
            (u, values)
        } else {
            let (q, r) = qr_thin(sketch.b.view())?;
            let (u, values, _) = svd_thin(r.view())?;
            (matmul(q.view(), u.view()), values)
        };
        let (rank, floor_seen) = rank_over_noise(&singular_values.to_vec(), sketch.lines());
        // the second pass would return a direction of noise alone as if it were signal
        let directions = (if floor_seen { rank } else { u.ncols() })
            .max(self.peaks.len())
            .clamp(1, u.ncols());
        if of_frfs && (!floor_seen || 2 * directions >= sketch.columns()) {
            return Ok(whole(rank));
        }
        let q = u.slice(s![.., ..directions]).to_owned();
        let projected = project(
            self.data,
            measured_basis(self.data, &q, &[]),
            &self.energy,
            &[],
        )?;
        let outside = (self.energy.sum() - projected.work.energy()).max(0.0);
        Ok(Compressed {
            work: projected.work,
            back: Some(projected.back),
            outside,
            rank,
        })
    }

    /// Starting poles at the visible peaks.
    pub fn seeds(&self) -> Vec<Complex64> {
        self.peaks.iter().map(|peak| peak.lambda).collect()
    }

    /// Rows that pole finders look at: all, or on long records those near the peaks and
    /// some of the rest.
    pub fn rows(&self) -> Vec<usize> {
        thinned(&self.sketch, &self.peaks)
    }

    /// Modes to expect: as many as asked for, else a third more than visible peaks or
    /// directions of the data.
    pub fn expected(&self, columns: &Compressed, options: &FitOptions) -> usize {
        options
            .modes
            .unwrap_or(self.peaks.len().max(columns.rank) * EXPECTED.0 / EXPECTED.1)
            .max(1)
    }

    /// Poles to start with for so many modes: some to spare for noise and for what lies
    /// outside the band.
    pub fn pool_size(&self, modes: usize) -> usize {
        (modes + SPARE_POLES)
            .min(self.data.lines.len() / LINES_PER_MODE)
            .max(1)
    }
}

impl Compressed {
    /// Noise variance of one value, where a model with `unknowns` columns leaves `sse` of
    /// the compressed data.
    pub fn variance(&self, data: &Screened, sse: f64, unknowns: usize) -> f64 {
        let values = data.lines.len() * data.pairs.len();
        let freedom = values.saturating_sub(unknowns * self.work.columns()).max(1);
        ((self.outside + sse) / freedom as f64).max(tol::ROUNDING_VARIANCE * self.mean_square())
    }

    /// The damping law that the turn of the residues of these poles tells; poles in the law of the
    /// columns.
    ///
    /// # Errors
    /// A kernel that fails.
    pub fn law_verdict(
        &self,
        data: &Screened,
        poles: &[Complex64],
        options: &FitOptions,
    ) -> Result<Verdict, LinalgError> {
        if poles.is_empty() {
            return Ok(Verdict::Undecidable);
        }
        let projection = Projection::new(&self.work, poles, &RESIDUAL_POWERS)?;
        let unknowns = poles.len() + RESIDUAL_POWERS.len();
        let fitted = Fitted {
            lambda: poles,
            powers: &RESIDUAL_POWERS,
            coefficients: &projection.coefficients()?,
            variance: self.variance(data, projection.sse, unknowns),
            frfs: data.pairs.len(),
            window: Window {
                kind: data.kind,
                decay: data.decay_of_window(options),
            },
        };
        verdict(&self.work, &fitted)
    }

    fn mean_square(&self) -> f64 {
        line_energy(&self.work.b).sum() / self.work.lines() as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::methods::synthetic::Structure;

    /// A first pass that was freed is made again with the same bits, by whoever asks.
    #[test]
    fn a_sketch_does_not_depend_on_what_is_kept() {
        let structure = Structure {
            responses: 200,
            snr_db: Some(40.0),
            ..Structure::four_modes()
        };
        let (frf, options) = (structure.frf(1), FitOptions::default());
        let data = Screened::new(&frf, &options).unwrap();
        let seed = options.seed;
        assert!(data.first_pass.of(seed, |_| ()).is_some());
        assert!(data.first_pass.of(seed + 1, |_| ()).is_none());
        let sketches = |data: &Screened| {
            let fewer = data.without(&[3, 7]);
            let all = [data.sketch(seed), data.sketch(seed + 1), fewer.sketch(seed)];
            all.map(|(sketch, energy)| (sketch.b, energy))
        };
        let kept = sketches(&data);
        data.clone().end_first_pass();
        assert!(data.first_pass.of(seed, |_| ()).is_none());
        assert_eq!(sketches(&data), kept);
    }
}
