//! Damping law: structural, viscous, or decided by evidence (theory.md, eq. 16–17).
//!
//! Both laws describe a single light resonance almost equally well: the wrong one shifts
//! the frequency by η²/4 and the loss factor by about 0.28η² (relative). The sums of
//! squares decide where they differ by more than chance; otherwise the question is
//! undecidable on these data, and the answer says so.

use crate::damping::structural::POWERS;
use crate::damping::viscous::{from_structural, refine_viscous, ViscousFit};
use crate::data::columns::Columns;
use crate::poles::prune::threshold;
use crate::poles::refine::Refined;
use crate::tolerances as tol;
use chladni_frf::Damping;
use chladni_linalg::LinalgError;
use num_complex::Complex64;

/// What the wrong law shifts a frequency and a loss factor by, relative and over η².
const FREQUENCY_SHIFT: f64 = 0.25;
const LOSS_SHIFT: f64 = 0.28;

/// Part of the difference that decides, below which what a step takes off no longer
/// matters: steps shrink from one to the next.
const LAW_SETTLED: f64 = 1e-2;

/// A law, and its own poles where they are not the structural ones.
#[derive(Debug)]
pub(crate) struct Law {
    /// The law of the numbers below.
    pub damping: Damping,
    /// The viscous fit where that is the law.
    pub viscous: Option<ViscousFit>,
}

impl Law {
    fn structural() -> Self {
        Self {
            damping: Damping::Structural,
            viscous: None,
        }
    }
    fn viscous(fit: ViscousFit) -> Self {
        Self {
            damping: Damping::Viscous,
            viscous: Some(fit),
        }
    }

    /// The law that is asked for, the other one not looked at.
    pub fn given(work: &Columns, refined: &Refined, damping: Damping) -> Result<Self, LinalgError> {
        Ok(match damping {
            Damping::Structural => Self::structural(),
            Damping::Viscous => Self::viscous(twin(
                work,
                &expressible(refined),
                tol::FINE_STEP,
                |_, _, _| false,
            )?),
        })
    }
}

/// What free residues say of the laws.
#[derive(Debug)]
pub(crate) struct Choice {
    /// The law asked for, or else the one that the data prefer.
    pub law: Law,
    /// The other one, where free residues cannot tell them apart.
    pub rival: Option<Law>,
    /// True where the data prefer the other law to the one asked for.
    pub contradicted: bool,
}

impl From<Law> for Choice {
    fn from(law: Law) -> Self {
        Self {
            law,
            rival: None,
            contradicted: false,
        }
    }
}

/// True where both laws can express the pole: Re λ > 0 (ζ < 0.71), stable. Others are
/// background, and the viscous twin has no need of what the structural law needed to
/// mimic it.
pub(crate) fn expressible_pole(lambda: Complex64) -> bool {
    lambda.re > 0.0 && lambda.im > 0.0
}

/// Rise of the sum of squares that tells one law from the other: chance, for white noise
/// of this variance.
pub(crate) fn chance(work: &Columns, variance: f64) -> f64 {
    threshold(work.columns(), work.lines()) * variance
}

/// Fits the viscous twin and lets the evidence decide: by a difference of more than
/// `least_gain`, or not at all for light damping where line shapes are no pure
/// resonances: `heaviest_sure` is the largest loss factor that is sure on measured data,
/// `None` where the residual is white. A law that is `asked` for is taken, and the
/// evidence told.
pub(crate) fn choose(
    work: &Columns,
    refined: &Refined,
    least_gain: f64,
    heaviest_sure: Option<f64>,
    asked: Option<Damping>,
) -> Result<Choice, LinalgError> {
    if refined.lambda.is_empty() || heaviest_sure.is_some_and(|loss| loss < tol::LAW_ALIKE) {
        return Ok(Law::given(work, refined, asked.unwrap_or(Damping::Structural))?.into());
    }
    let start = expressible(refined);
    let viscous_asked = asked == Some(Damping::Viscous);
    let tolerance = if viscous_asked {
        tol::FINE_STEP
    } else {
        tol::ROUGH_STEP
    };
    // a race is over once the steps left can no longer change who wins
    let structural_sse = refined.projection.sse;
    let decided = |sse: f64, drop: f64, left: usize| {
        !viscous_asked
            && (sse - drop * left as f64 > structural_sse + least_gain
                || drop < LAW_SETTLED * least_gain)
    };
    let fit = twin(work, &start, tolerance, decided)?;
    let gain = structural_sse - fit.sse;
    // poles that the viscous law cannot express make it poorer: a narrow loss proves
    // nothing then
    let comparable = start.len() == refined.lambda.len();
    let prefers = match gain {
        gain if gain > least_gain => Some(Damping::Viscous),
        gain if gain <= -least_gain && comparable => Some(Damping::Structural),
        _ => None,
    };
    let (law, rival) = match asked.or(prefers) {
        Some(Damping::Viscous) => (Law::viscous(fit), Law::structural()),
        _ => (Law::structural(), Law::viscous(fit)),
    };
    let contradicted = prefers.is_some_and(|preferred| preferred != law.damping);
    Ok(Choice {
        law,
        rival: prefers.is_none().then_some(rival),
        contradicted,
    })
}

/// Where the viscous twin starts.
fn expressible(refined: &Refined) -> Vec<Complex64> {
    refined
        .lambda
        .iter()
        .copied()
        .filter(|l| expressible_pole(*l))
        .map(from_structural)
        .collect()
}

fn twin(
    work: &Columns,
    start: &[Complex64],
    tolerance: f64,
    decided: impl Fn(f64, f64, usize) -> bool,
) -> Result<ViscousFit, LinalgError> {
    refine_viscous(work, start, &POWERS, tol::REFINE_FINE, tolerance, decided)
}

/// Shift of frequency or loss factor under the wrong law, whichever is more, in error
/// bars.
pub(crate) fn shift(loss_factor: f64, relative_omega_std: f64, loss_factor_std: f64) -> f64 {
    let square = loss_factor * loss_factor;
    (FREQUENCY_SHIFT * square / relative_omega_std)
        .max(LOSS_SHIFT * square * loss_factor / loss_factor_std)
}

/// What is said where neither free residues nor common shapes decide; `most`: the largest
/// [`shift`].
pub(crate) fn undecidable(taken: Damping, most: f64) -> String {
    format!(
        "damping law undecidable: structural and viscous damping explain these data equally well; the numbers follow the {} law \
         (frequencies under the other one differ by about η²/4, up to {most:.0} error bars here; say --damping if you know the law)",
        name(taken)
    )
}

/// What is said of a law that the data contradict.
pub(crate) fn contradicted(asked: Damping) -> String {
    let (own, other) = match asked {
        Damping::Structural => (name(asked), name(Damping::Viscous)),
        Damping::Viscous => (name(asked), name(Damping::Structural)),
    };
    format!(
        "the data contradict the {own} damping that was asked for: {other} damping explains them better than noise allows; frequencies and \
         loss factors are off by more than their error bars (leave --damping out)"
    )
}

fn name(damping: Damping) -> &'static str {
    match damping {
        Damping::Structural => "structural",
        Damping::Viscous => "viscous",
    }
}
