//! The weights file: what each actuator has to do, and what comes of it.

use crate::digits::hertz;
use crate::judging::ceiling::Ceiling;
use crate::judging::endurance::Endurance;
use crate::judging::frequency_sweep::FrequencySweep;
use crate::judging::indices::Indices;
use crate::methods::modal_steps::ModalSteps;
use crate::panel::drive::Drive;
use crate::rig::Correction;
use crate::scene::other_kind::{self, parse_as};
use crate::scene::tones::is_same;
use crate::tolerances;
use crate::touch::TouchIndices;
use chladni_frf::{Dof, Error, Finding, Findings, ReferenceUnit, Result, Severity, Source};
use num_complex::Complex64;
use serde::{Deserialize, Serialize};

/// Value of `format` in a weights file.
pub const WEIGHTS_FORMAT: &str = other_kind::WEIGHTS;
/// Version of the layout.
pub const WEIGHTS_VERSION: u32 = 1;

/// Actuator weights for a scene, and how they do in the model. Field by field the weights
/// file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Weights {
    /// Always [`WEIGHTS_FORMAT`].
    pub format: String,
    /// Version of the layout: 1.
    pub version: u32,
    /// Program and version.
    pub created_by: String,
    /// The files they were made from; filled by whoever read them.
    pub source: Vec<Source>,
    /// Options that can change the result.
    pub options: serde_json::Map<String, serde_json::Value>,
    /// Drive frequency, Hz; the first of several.
    pub frequency_hz: f64,
    /// The method that ran.
    pub method: String,
    /// File name of the scene.
    pub scene: String,
    /// One entry per actuator in use.
    pub weights: Vec<Weight>,
    /// In-band modes that the model sums explicitly.
    pub modes_used: usize,
    /// Weights that are not zero.
    pub actuators_used: usize,
    /// No judged response misses its limit in the model, within the force limits, at this
    /// frequency and all others; nor in the whole model, where fewer modes were summed and no
    /// measured line judged them.
    pub feasible: bool,
    /// Every judged response keeps its limit under model errors of so many standard
    /// deviations; negative where one misses.
    pub kappa: Option<f64>,
    /// The limit of physics, beside what was asked and found; where the scene is not met,
    /// or method `best` was asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ceiling: Option<Ceiling>,
    /// Share of simulated rigs on which the scene survives; for drives that are feasible.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub endurance: Option<Endurance>,
    /// Modal coefficients; of method `modal`, which goes through them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub modal: Option<ModalSteps>,
    /// Indices in the model.
    pub indices: Indices,
    /// Performance of the weights when the panel is not the model; where it was asked
    /// for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stress: Option<Vec<StressRow>>,
    /// Performance of the drive while fingers touch; where the scene expects them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub touch: Option<TouchIndices>,
    /// The scene at other frequencies; where it was asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sweep: Option<FrequencySweep>,
    /// Corrections by measured fields; of `chladni correct`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub correction: Option<Correction>,
    /// Everything the user should know, of all tones.
    #[serde(flatten)]
    pub findings: Findings,
    /// Tones driven at the same time at other frequencies: each a set of weights of its
    /// own.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub other_tones: Vec<Weights>,
}

/// The weight of one actuator: a peak phasor of e^{+jωt}.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Weight {
    /// Reference DOF.
    pub reference: Dof,
    /// Real part, in `unit`.
    pub re: f64,
    /// Imaginary part, in `unit`.
    pub im: f64,
    /// Amplitude, in `unit`; `re` and `im` are what counts.
    pub amplitude: f64,
    /// Phase, degrees, −180 to 180.
    pub phase_deg: f64,
    /// N or V.
    pub unit: ReferenceUnit,
}

impl Weight {
    /// The weight `value` of the actuator `reference`.
    pub fn new(reference: Dof, value: Complex64, unit: ReferenceUnit) -> Self {
        Self {
            reference,
            re: value.re,
            im: value.im,
            amplitude: value.norm(),
            phase_deg: value.arg().to_degrees(),
            unit,
        }
    }
    /// The phasor.
    pub fn value(&self) -> Complex64 {
        Complex64::new(self.re, self.im)
    }

    /// Checks that an actuator can have it, and that amplitude and phase are those of `re`
    /// and `im`.
    fn check(&self) -> Result<()> {
        let field = format!("weights, {}", self.reference);
        let (value, unit) = (self.value(), self.unit);
        let size = value.norm();
        if size > tolerances::MOST_WEIGHT {
            return Err(Error::bad_data("a weight that no actuator can have")
                .field(field)
                .found(format!("{size:e} {unit}"))
                .expected(format!("at most {:e} {unit}", tolerances::MOST_WEIGHT)));
        }
        let said = Complex64::from_polar(self.amplitude, self.phase_deg.to_radians());
        // numbers next to zero have no angle
        if (said - value).norm() <= tolerances::SAME_WEIGHT * size + f64::MIN_POSITIVE {
            return Ok(());
        }
        let shown =
            |amplitude: f64, phase_deg: f64| format!("{amplitude:.3e} {unit} at {phase_deg:.1}°");
        Err(Error::bad_data("a weight that is told in two ways")
            .field(field)
            .found(format!(
                "amplitude {}, re and im {}",
                shown(self.amplitude, self.phase_deg),
                shown(size, value.arg().to_degrees())
            ))
            .expected("the same phasor in both ways")
            .help(
                "re and im are what is driven: change these, and amplitude and phase_deg with them",
            ))
    }
}

impl Weights {
    /// The weight of each of `references`, N or V; 0 for those that are not driven. One of
    /// the opposite sense is turned round.
    pub fn at(&self, references: &[Dof]) -> Vec<Complex64> {
        let weight_of = |reference: &Dof| {
            let weight = self
                .weights
                .iter()
                .find(|weight| weight.reference.same_axis(*reference));
            weight.map_or(Complex64::ZERO, |weight| {
                weight.value() * weight.reference.direction.sign() * reference.direction.sign()
            })
        };
        references.iter().map(weight_of).collect()
    }

    /// The actuators whose weight is not zero, of all tones, each once.
    pub(crate) fn driven(&self) -> Vec<Dof> {
        let weights = self.tones().flat_map(|tone| &tone.weights);
        let mut driven = Vec::new();
        for weight in weights.filter(|weight| weight.value().norm() > 0.0) {
            if !driven.contains(&weight.reference) {
                driven.push(weight.reference);
            }
        }
        driven
    }

    /// A reason to doubt that a scene which is met in the model is met on the rig, in words that
    /// follow "met, but"; `None`: no reason.
    pub fn reservation(&self) -> Option<String> {
        let finding = |code: &str| self.own_finding(code);
        let of_model = [
            (
                "untrusted-model",
                "only in a model that is not to be trusted",
            ),
            ("drive-outside-band", "only in a model of other frequencies"),
            ("field-of-residuals", "only in a model without modes"),
            ("zone-without-response", "a hot zone holds no response"),
        ];
        if let Some((_, why)) = of_model.iter().find(|(code, _)| finding(code).is_some()) {
            return Some((*why).into());
        }
        if let Some(worse) = finding("replayed-worse") {
            let noun = if self.modes_used == 1 {
                "mode"
            } else {
                "modes"
            };
            let used = self.modes_used;
            return Some(match worse.severity {
                Severity::Fault => format!("only with {used} {noun}, not in the whole model"),
                _ => "not on the measured line".into(),
            });
        }
        finding("rig-sensitive")?;
        let on_drive = finding("mode-on-drive").map(|finding| finding.modes.first());
        Some(match on_drive {
            Some(Some(number)) => format!("mode {number} lies on the drive"),
            Some(None) => "a mode lies on the drive".into(),
            None => "not on every rig".into(),
        })
    }

    /// True where every judged response keeps its limit at the first frequency; `feasible` speaks of
    /// all of them.
    pub fn is_met(&self) -> bool {
        self.indices.points.min_ratio == 1.0
    }

    /// The finding `code` of the first tone. The texts of findings of other tones begin with
    /// their frequency; these are left out.
    pub fn own_finding(&self, code: &str) -> Option<&Finding> {
        let tones = self.other_tones.iter().map(|tone| tone.frequency_hz);
        // files of earlier versions have all digits of a frequency
        let others = tones.flat_map(|hz| [prefix(hz), format!("at {hz} Hz: ")]);
        let others: Vec<String> = others.collect();
        let is_own = |text: &str| !others.iter().any(|other| text.starts_with(other));
        let mut findings = self.findings.iter();
        findings.find(|finding| finding.code == code && is_own(&finding.text))
    }

    /// Takes over the findings of another tone.
    pub(crate) fn add_findings_of(&mut self, tone: &Self) {
        let known = |finding: &&Finding| !self.findings.contains(finding);
        let new = tone.findings.iter().filter(known).map(|finding| Finding {
            text: prefix(tone.frequency_hz) + &finding.text,
            ..finding.clone()
        });
        let new: Vec<Finding> = new.collect();
        self.findings.extend(new);
    }

    /// Reads a weights file's text.
    ///
    /// # Errors
    /// [`chladni_frf::ErrorKind::BadData`] with the line: no JSON, a missing field,
    /// another format, an actuator twice, no weight.
    pub fn parse(text: &str) -> Result<Self> {
        const AGAIN: &str = "give a weights file of Chladni, or render the scene again";
        let kind = (WEIGHTS_FORMAT, WEIGHTS_VERSION);
        let weights: Self = parse_as(text, kind, "not a weights file", AGAIN)?;
        weights.checked()
    }

    /// The text of a weights file.
    ///
    /// # Errors
    /// [`chladni_frf::ErrorKind::Internal`] where a number is not finite: a bug.
    pub fn to_json(&self) -> Result<String> {
        let text = serde_json::to_string_pretty(self);
        text.map(|text| text + "\n")
            .map_err(|error| Error::new(chladni_frf::ErrorKind::Internal, error.to_string()))
    }

    fn checked(mut self) -> Result<Self> {
        if self.format != WEIGHTS_FORMAT || self.version != WEIGHTS_VERSION {
            return Err(
                Error::bad_data("not a weights file that this version reads")
                    .field("format")
                    .found(format!("{} version {}", self.format, self.version))
                    .expected(format!("{WEIGHTS_FORMAT} version {WEIGHTS_VERSION}")),
            );
        }
        if self.weights.is_empty() {
            return Err(Error::bad_data("no weight in the file")
                .field("weights")
                .found("an empty list")
                .expected("one entry per actuator"));
        }
        if self.frequency_hz <= 0.0 {
            return Err(Error::bad_data("no drive frequency")
                .field("frequency_hz")
                .found(self.frequency_hz)
                .expected("a frequency in Hz"));
        }
        self.check_list()?;
        self.check_tones()?;
        self.other_tones = self
            .other_tones
            .into_iter()
            .map(Self::checked)
            .collect::<Result<_>>()?;
        Ok(self)
    }

    /// Checks that every actuator stands once, in one unit.
    fn check_list(&self) -> Result<()> {
        let mut seen = std::collections::HashSet::new();
        for weight in &self.weights {
            weight.check()?;
            if !seen.insert((weight.reference.node, weight.reference.direction.axis())) {
                return Err(Error::bad_data("an actuator occurs twice")
                    .field("weights")
                    .found(weight.reference)
                    .expected("each actuator once"));
            }
            if weight.unit != self.weights[0].unit {
                return Err(Error::bad_data("units of the weights differ")
                    .field("weights")
                    .found(format!("{} of {}", weight.unit, weight.reference))
                    .expected(format!(
                        "{}, as of the first actuator",
                        self.weights[0].unit
                    )));
            }
        }
        Ok(())
    }

    /// Checks that the other tones can sound beside this one.
    fn check_tones(&self) -> Result<()> {
        let mut known = vec![self.frequency_hz];
        for tone in &self.other_tones {
            let references = |weights: &Self| {
                weights
                    .weights
                    .iter()
                    .map(|weight| weight.reference)
                    .collect::<Vec<_>>()
            };
            let twice = known.iter().any(|&hz| is_same(hz, tone.frequency_hz));
            if twice
                || !tone.other_tones.is_empty()
                || tone.unit() != self.unit()
                || references(tone) != references(self)
            {
                return Err(Error::bad_data("tones that cannot sound together")
                    .field("other_tones")
                    .found(format!(
                        "{} actuators at {} Hz, in {}",
                        tone.weights.len(),
                        hertz(tone.frequency_hz),
                        tone.unit()
                    ))
                    .expected(
                        "each frequency once, without tones of its own, the actuators and \
                               the unit of the first",
                    ));
            }
            known.push(tone.frequency_hz);
        }
        Ok(())
    }

    /// The weights of every frequency that is driven.
    pub fn tones(&self) -> impl Iterator<Item = &Self> {
        std::iter::once(self).chain(&self.other_tones)
    }

    /// Refuses weights of another unit than that of the references they are to drive.
    ///
    /// # Errors
    /// [`chladni_frf::ErrorKind::BadData`].
    pub fn check_unit(&self, of_references: ReferenceUnit) -> Result<()> {
        if self.unit() == of_references {
            return Ok(());
        }
        Err(
            Error::bad_data("the weights and the data have different units")
                .field("weights")
                .found(self.unit())
                .expected(format!("{of_references}, the unit of the references"))
                .help("render the scene again with this model"),
        )
    }

    /// Unit of the weights.
    pub fn unit(&self) -> ReferenceUnit {
        self.weights
            .first()
            .map(|weight| weight.unit)
            .unwrap_or_default()
    }
}

/// Beginning of the findings of another tone.
fn prefix(frequency_hz: f64) -> String {
    format!("at {} Hz: ", hertz(frequency_hz))
}

/// One entry per actuator.
pub(crate) fn weight_list(references: &[Dof], drive: &Drive, unit: ReferenceUnit) -> Vec<Weight> {
    references
        .iter()
        .zip(drive)
        .map(|(&reference, &value)| Weight::new(reference, value, unit))
        .collect()
}

/// One trial of the stress table; shares of judged responses inside their limits.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct StressRow {
    /// The trial, in words.
    pub trial: String,
    /// Number of cases, each time otherwise.
    pub cases: usize,
    /// Mean share of responses served.
    pub success_mean: f64,
    /// Share that 95 % of the cases reach; the least of all where there are fewer than
    /// twenty.
    pub success_worst_5_percent: f64,
    /// The same for the smaller of hot and cold ratio.
    pub min_worst_5_percent: f64,
}
