//! A simulated measurement: FRFs of a virtual panel with noise, and the modal model that
//! is its truth.

use crate::layout::Layout;
use crate::noise::{add_white_noise, mean_square};
use crate::panel::Panel;
use crate::response::DampedPlate;
use crate::tolerances::LEAST_LINES_PER_BANDWIDTH;
use chladni_frf::{
    ComplexMatrix, ComplexVector, Damping, Error, ErrorKind, Finding, FrfSet, FrfValues,
    ModalModel, Mode, Quality, ReferenceUnit, ResidualTerm, ResidualTerms, Result, Scaling, Trust,
    CREATED_BY, MODEL_FORMAT,
};
use ndarray::{Array2, Axis};
use num_complex::Complex64;
use std::f64::consts::TAU;

/// FRFs, and what they are made of.
#[derive(Debug, Clone)]
#[must_use]
#[non_exhaustive]
pub struct Simulation {
    /// The measurement, with noise.
    pub frf: FrfSet,
    /// The model whose synthesis gives the FRFs without noise, to rounding.
    pub truth: ModalModel,
    /// E|n|² of the noise on each value, in the measured kind's unit squared.
    pub noise_variance: f64,
    /// The plate, for FRFs at any other points.
    pub plate: DampedPlate,
    /// Findings on this panel that the user should know.
    pub findings: Vec<Finding>,
}

/// Simulates the measurement that `panel` describes.
///
/// * `seed`, `snr_db`: take the place of the panel's; an infinite `snr_db` gives FRFs
///   without noise
///
/// The same panel and seed give the same bits at any number of threads.
///
/// # Errors
/// [`chladni_frf::ErrorKind::BadData`] where [`Panel::check`] fails, or more modes are
/// asked for than can be found. Memory is the caller's affair: see
/// [`Panel::check_memory`].
pub fn simulate(panel: &Panel, seed: Option<u64>, snr_db: Option<f64>) -> Result<Simulation> {
    panel.check()?;
    let mut panel = panel.clone();
    panel.frf.seed = seed.unwrap_or(panel.frf.seed);
    panel.frf.snr_db = snr_db.unwrap_or(panel.frf.snr_db);

    let layout = panel.layout();
    let plate = DampedPlate::of_panel(&panel, panel.frf.stop_hz)?;
    let frequency_hz = panel.frf.frequency_hz();
    let mut values = plate.frfs(
        panel.frf.kind,
        &layout.responses_m,
        &layout.references_m,
        &frequency_hz,
    )?;
    let force = panel.references.newtons_per_volt.as_ref();
    if let Some(force) = force {
        let of_each = force.of_references(layout.references_m.len());
        for (mut column, newtons) in values.axis_iter_mut(Axis(1)).zip(of_each) {
            column.mapv_inplace(|value| value * newtons);
        }
    }
    let noise_variance = add_white_noise(&mut values, panel.frf.snr_db, panel.frf.seed)?;
    let relative_error = (noise_variance / mean_square(&values)).sqrt();

    let findings = findings(&panel, &plate);
    let mut truth = truth(&panel, &layout, &plate, relative_error)?;
    if let Some(force) = force {
        per_volt(&mut truth, &force.of_references(layout.references_m.len()));
    }
    let frf = FrfSet {
        frequency_hz,
        values: FrfValues::F64(values),
        responses: layout.response_dofs,
        references: layout.reference_dofs,
        kind: Some(panel.frf.kind),
        reference_unit: truth.reference_unit,
        coherence: None,
        variance: None,
        estimation: None,
        geometry: layout.geometry,
    };
    Ok(Simulation {
        frf: frf.checked()?,
        truth,
        noise_variance,
        plate,
        findings,
    })
}

/// The modal model of the panel: elastic modes with their own poles, rigid-body modes as
/// the residual term −Σ ψψᵀ/ω².
fn truth(
    panel: &Panel,
    layout: &Layout,
    plate: &DampedPlate,
    relative_error: f64,
) -> Result<ModalModel> {
    let shapes = plate.modes.evaluate(&layout.responses_m)?;
    let participations = plate.modes.evaluate(&layout.references_m)?;
    let band_hz = [panel.frf.start_hz, panel.frf.stop_hz];
    let modes = elastic(plate, &shapes, &participations, band_hz);
    let omega_scale = TAU * panel.frf.stop_hz;
    let rigid = rigid_term(plate, &shapes, &participations, omega_scale);
    let options = serde_json::to_value(panel).map_err(|error| {
        Error::new(
            ErrorKind::Internal,
            format!("the panel cannot be written into the model: {error}"),
        )
    })?;
    Ok(ModalModel {
        format: MODEL_FORMAT.into(),
        version: 1,
        created_by: CREATED_BY.into(),
        source: Vec::new(),
        options: [("panel".to_string(), options)].into_iter().collect(),
        frf_kind: panel.frf.kind,
        reference_unit: ReferenceUnit::Newton,
        band_hz,
        damping: Damping::Structural,
        scaling: Scaling::UnitModalMass,
        responses: layout.response_dofs.clone(),
        references: layout.reference_dofs.clone(),
        nodes: layout.geometry.nodes.clone(),
        lines: layout.geometry.lines.clone(),
        faces: layout.geometry.faces.clone(),
        method: "simulate".into(),
        modes,
        residual_terms: ResidualTerms {
            omega_scale_rad_per_s: omega_scale,
            terms: rigid.into_iter().collect(),
        },
        quality: Quality {
            relative_error,
            chi2_per_dof: 1.0,
            trusted: true,
            findings: Vec::new(),
            path: None,
        },
    })
}

/// The model with references in volts: its shapes lose their scale, the largest value of
/// each is 1.
fn per_volt(model: &mut ModalModel, newtons_per_volt: &[f64]) {
    model.reference_unit = ReferenceUnit::Volt;
    model.scaling = Scaling::Unscaled;
    for mode in &mut model.modes {
        let sizes = mode.shape.0.iter().map(|value| value.norm());
        let largest = sizes.fold(f64::MIN_POSITIVE, f64::max);
        mode.shape.0.iter_mut().for_each(|value| *value /= largest);
        for (value, newtons) in mode.participation.0.iter_mut().zip(newtons_per_volt) {
            *value *= largest * newtons;
        }
    }
    for term in &mut model.residual_terms.terms {
        for (mut column, &newtons) in term
            .matrix
            .0
            .columns_mut()
            .into_iter()
            .zip(newtons_per_volt)
        {
            column.mapv_inplace(|value| value * newtons);
        }
    }
}

/// The rigid-body modes as a residual term; `None` where the plate has none.
fn rigid_term(
    plate: &DampedPlate,
    shapes: &Array2<f64>,
    participations: &Array2<f64>,
    omega_scale: f64,
) -> Option<ResidualTerm> {
    let rigid = plate.modes.rigid_count();
    let matrix = Array2::from_shape_fn((shapes.nrows(), participations.nrows()), |(i, j)| {
        let sum: f64 = (0..rigid)
            .map(|n| shapes[[i, n]] * participations[[j, n]])
            .sum();
        Complex64::new(-sum / omega_scale.powi(2), 0.0)
    });
    (rigid > 0).then_some(ResidualTerm {
        power: -2,
        matrix: ComplexMatrix(matrix),
    })
}

/// The elastic modes, with what they are at responses and references.
fn elastic(
    plate: &DampedPlate,
    shapes: &Array2<f64>,
    participations: &Array2<f64>,
    band_hz: [f64; 2],
) -> Vec<Mode> {
    let (frequencies, loss_factors) = (plate.modes.frequency_hz(), plate.loss_factors());
    let column = |table: &Array2<f64>, n: usize| {
        ComplexVector(table.column(n).iter().map(|&v| v.into()).collect())
    };
    (plate.modes.rigid_count()..plate.modes.len())
        .map(|n| Mode {
            frequency_hz: frequencies[n],
            frequency_std_hz: 0.0,
            loss_factor: loss_factors[n],
            loss_factor_std: 0.0,
            damping_ratio: loss_factors[n] / 2.0,
            in_band: band_hz[0] <= frequencies[n] && frequencies[n] <= band_hz[1],
            trust: Trust::Sure,
            reasons: Default::default(),
            mpc: 1.0,
            shape: column(shapes, n),
            shape_std: vec![0.0; shapes.nrows()],
            scale_std: None,
            participation: column(participations, n),
        })
        .collect()
}

fn findings(panel: &Panel, plate: &DampedPlate) -> Vec<Finding> {
    let mut findings = Vec::new();
    let (frequencies, loss_factors) = (plate.modes.frequency_hz(), plate.loss_factors());
    let in_band = |n: &usize| (panel.frf.start_hz..=panel.frf.stop_hz).contains(&frequencies[*n]);
    let modes: Vec<usize> = (plate.modes.rigid_count()..plate.modes.len())
        .filter(in_band)
        .collect();
    if modes.is_empty() {
        let words = format!(
            "no elastic mode between {} and {} Hz; the first one lies at {:.1} Hz",
            panel.frf.start_hz,
            panel.frf.stop_hz,
            frequencies[plate.modes.rigid_count()]
        );
        findings.push(Finding::caution("no-mode-simulated", words).help("widen the band"));
    }
    let narrow = |n: &&usize| {
        loss_factors[**n] * frequencies[**n] < LEAST_LINES_PER_BANDWIDTH * panel.frf.step_hz
    };
    if let Some(&first) = modes.iter().find(narrow) {
        let words = format!(
            "the half-power bandwidth of {} of {} modes is below the line spacing of {} Hz (at {:.1} Hz: {:.3} Hz): \
             damping can hardly be identified there",
            modes.iter().filter(narrow).count(),
            modes.len(),
            panel.frf.step_hz,
            frequencies[first],
            loss_factors[first] * frequencies[first]
        );
        findings
            .push(Finding::caution("lines-too-far-apart", words).help("take a smaller step_hz"));
    }
    if panel.plate.is_thick_at(TAU * panel.frf.stop_hz) {
        let words = format!(
            "at {} Hz the bending wavelength is below 20 thicknesses; real plates have lower \
             frequencies there than this thin-plate model",
            panel.frf.stop_hz
        );
        findings.push(Finding::note("beyond-thin-plates", words));
    }
    findings
}
