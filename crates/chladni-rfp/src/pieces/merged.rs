//! Merged partials as the source of a fit. They answer what they were made for, and ask for the
//! next pass where they cannot.

use crate::damping::basis::basis;
use crate::data::columns::Columns;
use crate::data::error::FitError;
use crate::data::layout::DataLayout;
use crate::data::options::FitOptions;
use crate::data::pair_weights::{NextWeights, NoiseSource, PairWeights};
use crate::data::products::Projected;
use crate::data::screening::{check_lines, check_scale, lines_left_out, Screened};
use crate::data::source::{Source, Way};
use crate::pieces::error::PieceError;
use crate::pieces::limits;
use crate::pieces::partial::SketchSums;
use crate::pieces::plan::Plan;
use crate::pieces::poles::{DofWeights, Matrix, Pass, Poles};
use crate::pieces::whole::{none, Set, Whole, WholeProducts};
use crate::poles::passes::on_all_lines;
use chladni_frf::{Damping, Error, Finding};
use chladni_linalg::blocked::projected;
use chladni_linalg::LinalgError;
use ndarray::{Array1, Array2, ArrayView1, Axis, ShapeBuilder};
use num_complex::Complex64;
use std::ops::Deref;

/// The reason that a fit of merged partials does not go on.
#[derive(Debug)]
pub(crate) enum Stop {
    /// For good.
    Error(PieceError),
    /// Until the blocks have been reduced with these.
    Pass(Box<Poles>),
}

impl From<FitError> for Stop {
    fn from(error: FitError) -> Self {
        Self::Error(error.into())
    }
}

impl From<LinalgError> for Stop {
    fn from(error: LinalgError) -> Self {
        Self::Error(error.into())
    }
}

/// Merged partials of all blocks.
#[derive(Debug, Clone)]
pub(crate) struct Merged<'a> {
    layout: DataLayout,
    plan: &'a Plan,
    modes: Option<usize>,
    /// In work units, all columns of one noise level: (line, column).
    sketch: Array2<Complex64>,
    /// Energy of each line over all FRFs, in work units.
    energy: Array1<f64>,
    /// Noise energy of each FRF as the data tell it.
    given: Option<(Vec<f64>, NoiseSource)>,
    made: Option<Made<'a>>,
    /// The point where the walk stopped for the pass that these partials are of.
    way: Option<Way>,
}

/// Products, and the poles that they were made with.
#[derive(Debug, Clone)]
struct Made<'a> {
    poles: &'a Poles,
    way: &'a Way,
    products: &'a WholeProducts,
}

impl Deref for Merged<'_> {
    type Target = DataLayout;
    fn deref(&self) -> &DataLayout {
        &self.layout
    }
}

impl<'a> Merged<'a> {
    /// The source that `whole` is.
    ///
    /// # Errors
    /// Too few lines or none with values; a pass over other FRFs than the one before.
    pub fn new(whole: &'a Whole, options: &FitOptions) -> Result<Self, PieceError> {
        let Whole {
            plan,
            poles,
            set,
            sketch,
            products,
        } = whole;
        let asked = poles.as_deref().filter(|poles| !poles.is_of_pilot());
        // the number of modes is settled with the poles
        let modes = asked.map_or(options.modes, |poles| poles.modes);
        let options = &FitOptions {
            modes,
            ..options.clone()
        };
        let source = match (sketch, asked) {
            (Some(sums), asked) => Self::of_sketch(plan, asked, set, sums, options)?,
            (None, Some(poles)) => Self::of_poles(plan, poles, set, options)?,
            (None, None) => return Err(none().into()),
        };
        let made = poles.as_deref().zip(products.as_ref());
        Ok(Self {
            made: made.and_then(|(poles, products)| {
                let way = poles.way.as_ref()?;
                Some(Made {
                    poles,
                    way,
                    products,
                })
            }),
            ..source
        })
    }

    /// The number of modes asked for.
    pub fn modes(&self) -> Option<usize> {
        self.modes
    }

    /// Of a pass that made a sketch; `asked`: what it was run with, where it was not the
    /// first.
    fn of_sketch(
        plan: &'a Plan,
        asked: Option<&Poles>,
        set: &Set,
        sums: &SketchSums,
        options: &FitOptions,
    ) -> Result<Self, PieceError> {
        let SketchSums {
            columns,
            counts,
            line_energy,
            bad,
        } = sums;
        let (lines, band_hz) = plan.lines()?;
        let good: Vec<usize> = (0..lines.len())
            .filter(|&k| !bad[k] && line_energy[k] > 0.0)
            .collect();
        let used =
            |k: &usize| asked.is_none_or(|poles| poles.lines.binary_search(&lines[*k]).is_ok());
        let kept: Vec<usize> = good.iter().copied().filter(used).collect();
        if kept.is_empty() {
            return Err(FitError::NoData.into());
        }
        check_lines(kept.len(), band_hz, options.modes)?;
        let used = kept.iter().map(|&k| lines[k]).collect();
        let mut layout = with_dofs(plan.layout(used, options.effort)?, set);
        match asked {
            Some(poles) => poles.tell(&mut layout),
            None if good.len() < lines.len() => {
                let left_out = lines.len() - good.len();
                // it was not counted whether some FRF has values there
                layout
                    .warnings
                    .push(lines_left_out(left_out, 0, lines.len()));
            }
            None => {}
        }
        let energy: Array1<f64> = kept.iter().map(|&k| line_energy[k]).collect();
        layout.rms = (energy.sum() / (kept.len() * layout.pairs.len()) as f64).sqrt();
        check_scale(layout.rms)?;
        let factor = layout.factor();
        let filled: Vec<usize> = (0..counts.len()).filter(|&c| counts[c] > 0).collect();
        let sums = columns.array();
        let scaled = |(k, c): (usize, usize)| {
            sums[[kept[k], filled[c]]] * factor / (counts[filled[c]] as f64).sqrt()
        };
        Ok(Self {
            sketch: Array2::from_shape_fn((kept.len(), filled.len()).f(), scaled),
            energy: energy * factor.norm_sqr(),
            given: set
                .given
                .clone()
                .map(|(noise_source, noise)| (noise, noise_source)),
            layout,
            plan,
            modes: options.modes,
            made: None,
            way: None,
        })
    }

    /// Of a pass that made products alone.
    fn of_poles(
        plan: &'a Plan,
        poles: &Poles,
        set: &Set,
        options: &FitOptions,
    ) -> Result<Self, PieceError> {
        let mut layout = with_dofs(poles.layout(options.effort)?, set);
        poles.tell(&mut layout);
        if layout.pairs.len() != poles.frfs {
            return Err(
                Error::bad_data("the second pass was not run over the FRFs of the first")
                    .field("number of FRFs")
                    .found(layout.pairs.len())
                    .expected(format!(
                        "{}, as many as the poles were found on",
                        poles.frfs
                    ))
                    .help("reduce every block again with the poles, and merge all of them")
                    .into(),
            );
        }
        Ok(Self {
            layout,
            plan,
            modes: poles.modes,
            sketch: poles.sketch.array(),
            energy: Array1::from(poles.line_energy.clone()),
            given: None,
            made: None,
            way: poles.way.clone(),
        })
    }

    /// A pass that others must make.
    fn asked(&self, pass: Pass, way: Option<Way>) -> Poles {
        let sketch = match pass {
            Pass::Anew => Array2::zeros((self.lines.len(), 0)),
            Pass::Products | Pass::Pilot => self.sketch.clone(),
        };
        let weighting = self.layout.weighting.as_ref();
        Poles {
            plan: self.plan.clone(),
            pass,
            lines: self.lines.clone(),
            rms: self.rms,
            line_energy: self.energy.to_vec(),
            sketch: Matrix::from(sketch),
            frfs: self.pairs.len(),
            modes: self.modes,
            weighting: weighting.map(|weighting| {
                let rms = weighting.rms;
                DofWeights::new(self, &weighting.weights, weighting.noise_source, rms)
            }),
            next_weights: self.next_weights,
            dropped_hz: self.dropped_hz.clone(),
            outlier_rounds: self.outlier_rounds,
            warnings: self.warnings.clone(),
            way,
        }
    }

    /// True where the products at hand compress the data for the poles of `way` as well:
    /// on the same lines, weighted or not as those are, as many poles, each within their basis
    /// but for a small share. The part outside costs a share of the information, and no bias:
    /// compressed columns are mixtures of whole FRFs, and the basis only says how they are mixed.
    fn serves(&self, made: &Made, way: &Way) -> Result<bool, LinalgError> {
        if made.poles.lines != self.lines
            || made.way.lambda.len() != way.lambda.len()
            || made.way.weights().is_empty() != way.weights().is_empty()
        {
            return Ok(false);
        }
        if made.way == way {
            return Ok(true);
        }
        let columns = basis(&self.axis().in_law(way.law), &way.lambda, &[]);
        let in_law = self.in_law(made.way.law);
        let q = on_all_lines(&in_law, &made.way.lambda)?;
        let (_, outside) = projected(q.view(), columns.view());
        let energy = |column: ArrayView1<Complex64>| {
            column.iter().map(|value| value.norm_sqr()).sum::<f64>()
        };
        Ok(outside
            .columns()
            .into_iter()
            .zip(columns.columns())
            .all(|(outside, all)| energy(outside) < limits::PILOT_SHARE * energy(all)))
    }
}

impl Source for Merged<'_> {
    type Stop = Stop;

    fn sketch(&self, _: u64) -> (Columns, Array1<f64>) {
        let work = self.axis().with_columns(self.sketch.clone());
        (work, self.energy.clone())
    }

    fn projected(
        &self,
        way: &Way,
        _: Array2<Complex64>,
        energy: &Array1<f64>,
    ) -> Result<Projected, Stop> {
        if let Some(made) = &self.made {
            if self.serves(made, way)? {
                let WholeProducts { t, gram, .. } = made.products;
                let turned = |x: &Array2<f64>| made.products.turned(x);
                let weights = way.weights();
                return Ok(Projected::new(
                    &self.layout,
                    [t, gram],
                    turned,
                    energy,
                    weights,
                )?);
            }
        }
        Err(Stop::Pass(Box::new(
            self.asked(Pass::Products, Some(way.clone())),
        )))
    }

    fn way(&self) -> Option<&Way> {
        self.way.as_ref()
    }

    fn without(&self, places: &[usize]) -> Self {
        let (layout, kept) = self.layout.without(places);
        Self {
            layout,
            sketch: self.sketch.select(Axis(0), &kept),
            energy: self.energy.select(Axis(0), &kept),
            way: None,
            ..self.clone()
        }
    }

    fn in_law(&self, law: Damping) -> Self {
        let mut other = self.clone();
        other.layout.law = law;
        other
    }

    fn given_noise(&self) -> Option<(Vec<f64>, NoiseSource)> {
        self.given.clone()
    }

    fn weighted(
        &self,
        weights: Option<(PairWeights, Option<NoiseSource>)>,
        left: NextWeights,
    ) -> Result<Self, Stop> {
        let mut other = self.clone();
        other.layout.next_weights = left;
        if weights.is_none() && self.weighting.is_none() {
            return Ok(other);
        }
        let made = self.made.as_ref();
        let made = made.filter(|made| made.poles.lines == self.lines);
        let mut asked = other.asked(Pass::Anew, made.map(|made| made.way.clone()));
        asked.weighting = weights.map(|(weights, noise_source)| {
            DofWeights::new(self, &weights, noise_source, self.measured_rms())
        });
        Err(Stop::Pass(Box::new(asked)))
    }

    fn noted(&self, finding: Option<Finding>) -> Self {
        let mut other = self.clone();
        other.layout.warnings.extend(finding);
        other
    }

    fn values(&self) -> Option<&Screened<'_>> {
        None
    }
}

/// The layout of all FRFs.
fn with_dofs(layout: DataLayout, set: &Set) -> DataLayout {
    DataLayout {
        responses: set.responses.clone(),
        references: set.references.clone(),
        nodes: set.nodes.clone(),
        pairs: set.pairs.clone(),
        energy: set.energy.clone(),
        ..layout
    }
}
