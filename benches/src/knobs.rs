//! Knobs: one option of a method turned from the least to the most, everything else as it
//! is.

use chladni_frf::{FrfSet, FrfValues};
use chladni_rfp::{Effort, FitOptions, Method, RfpOptions, RfpWeight, ShapeModel};
use num_complex::Complex32;
use std::fmt;

/// One setting of a knob.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Setting {
    /// So many modes more than there are.
    Order(i32),
    /// Data in single precision.
    Single,
    /// Constraints on shapes while poles are refined.
    Shapes(ShapeModel),
    /// Columns of the count sketch.
    SketchColumns(usize),
    /// Steps of vector fitting.
    PoolIterations(usize),
    /// Passes over the data beyond the two.
    ExtraPasses(usize),
    /// Steps to the maximum-likelihood poles.
    LikelihoodSteps(usize),
    /// A form of rational fraction polynomials.
    Fraction(RfpOptions),
}

impl fmt::Display for Setting {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Order(more) => write!(f, "order {more:+}"),
            Self::Single => f.write_str("f32"),
            Self::Shapes(shapes) => write!(f, "shapes {}", shapes.as_str()),
            Self::SketchColumns(columns) => write!(f, "sketch {columns}"),
            Self::PoolIterations(steps) => write!(f, "pool steps {steps}"),
            Self::ExtraPasses(passes) => write!(f, "extra passes {passes}"),
            Self::LikelihoodSteps(steps) => write!(f, "likelihood steps {steps}"),
            Self::Fraction(RfpOptions { local: true, .. }) => f.write_str("local"),
            Self::Fraction(rfp) => f.write_str(rfp.weight.as_str()),
        }
    }
}

/// A knob of a method.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Knob {
    pub(crate) method: Method,
    /// For the legend.
    pub(crate) about: &'static str,
    pub(crate) settings: &'static [Setting],
    /// Position of the method among them unless told otherwise.
    pub(crate) as_it_is: f64,
}

/// Cases on which knobs are turned.
pub(crate) const KNOB_CASES: [&str; 2] = ["panel", "overlap-1"];

/// Rational fraction polynomials of all FRFs, by what they are fitted by.
const fn fraction(weight: RfpWeight) -> Setting {
    Setting::Fraction(RfpOptions {
        weight,
        bands: None,
        local: false,
    })
}

/// Rational fraction polynomials from 1982 to here.
pub(crate) const FAMILY: Knob = Knob {
    method: Method::Rfp,
    about: "each FRF by itself (1982), one denominator (1985), SK, Gauss-Newton, IV",
    settings: &[
        Setting::Fraction(RfpOptions {
            weight: RfpWeight::Linear,
            bands: None,
            local: true,
        }),
        fraction(RfpWeight::Linear),
        fraction(RfpWeight::Sk),
        fraction(RfpWeight::Gn),
    ],
    as_it_is: 4.0,
};

/// The knobs that options of a fit give.
pub(crate) const KNOBS: [Knob; 8] = [
    Knob {
        method: Method::Lean,
        about: "order, 4 less to 8 more than there are",
        settings: &[
            Setting::Order(-4),
            Setting::Order(-1),
            Setting::Order(1),
            Setting::Order(3),
            Setting::Order(8),
        ],
        as_it_is: 0.0,
    },
    Knob {
        method: Method::Auto,
        about: "shapes free, of one phase, real",
        settings: &[
            Setting::Shapes(ShapeModel::Free),
            Setting::Shapes(ShapeModel::Rank1),
            Setting::Shapes(ShapeModel::Real),
        ],
        as_it_is: 3.0,
    },
    Knob {
        method: Method::Auto,
        about: "data in f32, f64",
        settings: &[Setting::Single],
        as_it_is: 1.0,
    },
    Knob {
        method: Method::Lean,
        about: "data in f32, f64",
        settings: &[Setting::Single],
        as_it_is: 1.0,
    },
    Knob {
        method: Method::Lean,
        about: "0, 1, 2, 4, 30 likelihood steps",
        settings: &[
            Setting::LikelihoodSteps(0),
            Setting::LikelihoodSteps(1),
            Setting::LikelihoodSteps(2),
            Setting::LikelihoodSteps(4),
        ],
        as_it_is: 4.0,
    },
    Knob {
        method: Method::Auto,
        about: "24, 40, 80, 160 columns of the sketch",
        settings: &[
            Setting::SketchColumns(24),
            Setting::SketchColumns(40),
            Setting::SketchColumns(160),
        ],
        as_it_is: 1.5,
    },
    Knob {
        method: Method::Auto,
        about: "2, 4, 8, 16 steps of vector fitting",
        settings: &[
            Setting::PoolIterations(2),
            Setting::PoolIterations(4),
            Setting::PoolIterations(16),
        ],
        as_it_is: 1.5,
    },
    Knob {
        method: Method::Auto,
        about: "at most 0, 1, 3 passes beyond two",
        settings: &[Setting::ExtraPasses(0), Setting::ExtraPasses(1)],
        as_it_is: 2.0,
    },
];

impl Knob {
    /// Place of a setting along the knob; `None` where it belongs to another one.
    pub(crate) fn position(&self, setting: Setting) -> Option<f64> {
        let place = self.settings.iter().position(|own| *own == setting)?;
        Some(if let Setting::Order(more) = setting {
            f64::from(more)
        } else {
            place as f64
        })
    }
}

impl Setting {
    /// The options with this setting, for data with so many modes.
    pub(crate) fn options(self, options: FitOptions, modes: usize) -> FitOptions {
        match self {
            Self::Order(more) => FitOptions {
                modes: Some(modes.saturating_add_signed(more as isize)),
                ..options
            },
            Self::Shapes(shapes) => FitOptions { shapes, ..options },
            Self::SketchColumns(sketch_columns) => FitOptions {
                effort: Effort {
                    sketch_columns,
                    ..options.effort
                },
                ..options
            },
            Self::PoolIterations(pool_iterations) => FitOptions {
                effort: Effort {
                    pool_iterations,
                    ..options.effort
                },
                ..options
            },
            Self::ExtraPasses(extra_passes) => FitOptions {
                effort: Effort {
                    extra_passes,
                    ..options.effort
                },
                ..options
            },
            Self::LikelihoodSteps(likelihood_steps) => FitOptions {
                effort: Effort {
                    likelihood_steps,
                    ..options.effort
                },
                ..options
            },
            Self::Fraction(rfp) => FitOptions { rfp, ..options },
            Self::Single => options,
        }
    }

    /// The data with this setting.
    pub(crate) fn data(self, frf: FrfSet) -> FrfSet {
        match (self, &frf.values) {
            (Self::Single, FrfValues::F64(values)) => {
                let values =
                    FrfValues::F32(values.mapv(|v| Complex32::new(v.re as f32, v.im as f32)));
                FrfSet { values, ..frf }
            }
            _ => frf,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn settings_turn_what_they_say() {
        let options = Setting::Order(-4).options(FitOptions::default(), 34);
        assert_eq!(
            (options.modes, Setting::Order(-4).to_string()),
            (Some(30), "order -4".to_string())
        );
        let order = KNOBS[0];
        let places: Vec<f64> = order
            .settings
            .iter()
            .filter_map(|&setting| order.position(setting))
            .collect();
        assert!(
            places.windows(2).all(|pair| pair[0] < pair[1]) && !places.contains(&order.as_it_is)
        );
        assert_eq!(order.position(Setting::Single), None);
        let names: Vec<String> = FAMILY.settings.iter().map(Setting::to_string).collect();
        assert_eq!(names, ["local", "linear", "sk", "gn"]);
        let forms = FAMILY
            .settings
            .iter()
            .map(|form| form.options(FitOptions::default(), 34).rfp);
        assert!(forms.into_iter().all(|rfp| rfp != RfpOptions::default()));
        let turned = [
            Setting::SketchColumns(24),
            Setting::PoolIterations(2),
            Setting::ExtraPasses(0),
        ]
        .map(|setting| setting.options(FitOptions::default(), 34).effort);
        assert!(turned.iter().all(|effort| *effort != Effort::default()));
        assert_eq!(
            turned.map(|effort| (
                effort.sketch_columns,
                effort.pool_iterations,
                effort.extra_passes
            ))[2]
                .2,
            0
        );
    }
}
