//! A virtual panel: the plate, where it is measured and driven, and how. Field by field
//! the panel file of `simulate`.

use crate::checks::{not_negative, positive};
use crate::modes::needed_terms;
use crate::plate::Plate;
use crate::tolerances::{BAND_FACTOR, LEAST_MODES};
use chladni_frf::{Error, FrfKind, Result};
use ndarray::Array1;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// Everything that a simulated measurement is made of. The default is the glass panel of
/// the examples.
///
/// ```
/// use chladni_plate::Panel;
/// let panel = Panel::from_toml("[plate]\nthickness_m = 0.001\n[frf]\nstop_hz = 500", 2 << 30).unwrap();
/// assert_eq!(panel.plate.length_m, 0.268, "what the file leaves out has its default");
/// let error = Panel::from_toml("[plate]\nthicknes_m = 0.001", 2 << 30).unwrap_err();
/// assert!(error.to_string().contains("line 2") && error.to_string().contains("thickness_m"));
/// ```
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Panel {
    /// The plate.
    pub plate: Plate,
    /// Points where it is measured.
    pub responses: ResponseGrid,
    /// Points where it is driven.
    pub references: ReferenceFrame,
    /// The measurement.
    pub frf: Measurement,
}

/// Measured points: nodes 1, 2, ... row by row on a grid centred on the plate.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ResponseGrid {
    /// Columns (along x) and rows (along y).
    pub grid: [usize; 2],
    /// Distance of columns and of rows, m.
    pub spacing_m: f64,
    /// Also measure at the references: driving points, after the nodes of the grid.
    pub at_references: bool,
    /// Also measure at the first reference: one driving point, which the scale of the
    /// shapes needs.
    pub driving_point: bool,
}

impl Default for ResponseGrid {
    fn default() -> Self {
        Self {
            grid: [11, 7],
            spacing_m: 0.020,
            at_references: false,
            driving_point: false,
        }
    }
}

/// Driven points: nodes 101, 102, ... counter-clockwise along the edges from the corner x
/// = 0, y = 0.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ReferenceFrame {
    /// Points along each long and along each short edge.
    pub edge_count: [usize; 2],
    /// Distance along the edge, m; the row is centred.
    pub spacing_m: f64,
    /// Distance from the edge, m.
    pub inset_m: f64,
    /// Mass of each actuator, kg, loading the plate.
    pub mass_kg: f64,
    /// Stiffness of each actuator to the ground, N/m.
    pub stiffness_n_per_m: f64,
    /// Damping of each actuator to the ground, N s/m.
    pub damping_n_s_per_m: f64,
    /// Force of each actuator per volt: with it the references are volts. `None`: they are
    /// newtons.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub newtons_per_volt: Option<NewtonsPerVolt>,
}

/// Force of actuators per volt, amplifier and coil together.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(
    untagged,
    expecting = "expected a number or an array of numbers, one per reference"
)]
pub enum NewtonsPerVolt {
    /// The same for all references.
    Common(f64),
    /// One per reference.
    PerReference(Vec<f64>),
}

impl NewtonsPerVolt {
    /// That of each of `count` references.
    pub fn of_references(&self, count: usize) -> Vec<f64> {
        match self {
            Self::Common(value) => vec![*value; count],
            Self::PerReference(list) => list.clone(),
        }
    }

    /// Checks the number of entries, and that one of them drives.
    fn check(&self, references: usize) -> Result<()> {
        let wrong = |found: String, expected: String| {
            Err(Error::bad_data("not a usable force per volt")
                .field("references.newtons_per_volt")
                .found(found)
                .expected(expected))
        };
        let list = match self {
            Self::Common(value) => std::slice::from_ref(value),
            Self::PerReference(list) => list,
        };
        if list.len() != references && matches!(self, Self::PerReference(_)) {
            let found = format!("{} numbers", list.len());
            return wrong(
                found,
                format!("one for each of the {references} references"),
            );
        }
        if let Some(value) = list.iter().find(|value| !value.is_finite()) {
            return wrong(value.to_string(), "finite numbers of N/V".into());
        }
        if list.iter().all(|value| *value == 0.0) {
            let expected = "at least one that is not 0; 0 is a dead actuator";
            return wrong("nothing but 0".into(), expected.into());
        }
        Ok(())
    }
}

impl Default for ReferenceFrame {
    fn default() -> Self {
        Self {
            edge_count: [11, 6],
            spacing_m: 0.020,
            inset_m: 0.005,
            mass_kg: 0.0,
            stiffness_n_per_m: 0.0,
            damping_n_s_per_m: 0.0,
            newtons_per_volt: None,
        }
    }
}

impl ReferenceFrame {
    /// Number of references, as a float so that no number of a file can overflow it.
    fn count(&self) -> f64 {
        let [long, short] = self.edge_count.map(|count| count as f64);
        2.0 * (long + short)
    }
}

/// Kind, frequency axis and noise of the FRFs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Measurement {
    /// Kind of the FRFs.
    pub kind: FrfKind,
    /// First line, Hz.
    pub start_hz: f64,
    /// Last line, Hz; an axis that does not hit it ends below.
    pub stop_hz: f64,
    /// Distance of lines, Hz.
    pub step_hz: f64,
    /// Level of the white circular noise on all FRFs and lines below the mean square of
    /// all, dB; infinite: no noise.
    pub snr_db: f64,
    /// Seed of the noise.
    pub seed: u64,
}

impl Default for Measurement {
    fn default() -> Self {
        Self {
            kind: FrfKind::Mobility,
            start_hz: 2.0,
            stop_hz: 1000.0,
            step_hz: 0.5,
            snr_db: 40.0,
            seed: 1,
        }
    }
}

impl Measurement {
    /// Number of spectral lines, as a float so that no number of a file can overflow it.
    fn line_count(&self) -> f64 {
        // a thousandth of a step is room for the roundings of decimal steps
        ((self.stop_hz - self.start_hz) / self.step_hz + 1e-3).floor() + 1.0
    }
    /// Frequency axis start, start + step, ..., Hz.
    pub fn frequency_hz(&self) -> Array1<f64> {
        (0..self.line_count() as usize)
            .map(|k| self.start_hz + self.step_hz * k as f64)
            .collect()
    }
}

impl Panel {
    /// Checks that all numbers are usable and that grid and frame fit on the plate.
    ///
    /// # Errors
    /// [`chladni_frf::ErrorKind::BadData`] naming the key, as `frf.step_hz`.
    pub fn check(&self) -> Result<()> {
        self.plate.check()?;
        self.check_points()?;
        self.check_measurement()
    }

    fn check_points(&self) -> Result<()> {
        let (responses, references) = (&self.responses, &self.references);
        positive("responses.spacing_m", responses.spacing_m)?;
        positive("references.spacing_m", references.spacing_m)?;
        not_negative("references.inset_m", references.inset_m)?;
        not_negative("references.mass_kg", references.mass_kg)?;
        let (stiffness, damping) = (references.stiffness_n_per_m, references.damping_n_s_per_m);
        not_negative("references.stiffness_n_per_m", stiffness)?;
        not_negative("references.damping_n_s_per_m", damping)?;
        if responses.grid.contains(&0) {
            return Err(Error::bad_data("a grid needs a column and a row")
                .field("responses.grid")
                .found(format!("{:?}", responses.grid))
                .expected("two whole numbers of at least 1"));
        }
        if references.edge_count == [0, 0] {
            return Err(Error::bad_data("no reference: nothing drives the plate")
                .field("references.edge_count")
                .found("[0, 0]")
                .expected("points along each long and each short edge, one of them at least 1"));
        }
        if let Some(force) = &references.newtons_per_volt {
            force.check(references.count() as usize)?;
        }
        let shorter = self.plate.length_m.min(self.plate.width_m);
        if references.inset_m > shorter / 2.0 {
            return Err(
                Error::bad_data("the references would lie beyond the middle of the plate")
                    .field("references.inset_m")
                    .found(references.inset_m)
                    .expected(format!("at most {}, half the shorter side", shorter / 2.0)),
            );
        }
        self.check_spans()
    }

    /// Refuses rows of points that are longer than their side of the plate.
    fn check_spans(&self) -> Result<()> {
        let (length, width) = (self.plate.length_m, self.plate.width_m);
        let (grid, edge_count) = (self.responses.grid, self.references.edge_count);
        let grid_sides = [length, width];
        let edges = [length.max(width), length.min(width)];
        let spacings = [self.responses.spacing_m, self.references.spacing_m];
        for (field, counts, spacing, sides) in [
            ("responses.grid", grid, spacings[0], grid_sides),
            ("references.edge_count", edge_count, spacings[1], edges),
        ] {
            for (count, side) in counts.into_iter().zip(sides) {
                let span = count.saturating_sub(1) as f64 * spacing;
                if span > side * (1.0 + crate::tolerances::EDGE_SLACK) {
                    return Err(Error::bad_data("the points do not fit on the plate")
                        .field(field)
                        .found(format!("{count} points {spacing} m apart, {span} m in all"))
                        .expected(format!("at most the side of {side} m"))
                        .help("take fewer points or a smaller spacing_m"));
                }
            }
        }
        Ok(())
    }

    fn check_measurement(&self) -> Result<()> {
        let frf = &self.frf;
        not_negative("frf.start_hz", frf.start_hz)?;
        positive("frf.stop_hz", frf.stop_hz)?;
        positive("frf.step_hz", frf.step_hz)?;
        crate::noise::check_snr("frf.snr_db", frf.snr_db)?;
        if frf.stop_hz < frf.start_hz {
            return Err(Error::bad_data("the frequency axis ends before it starts")
                .field("frf.stop_hz")
                .found(frf.stop_hz)
                .expected(format!("at least start_hz, {}", frf.start_hz)));
        }
        let may_float =
            self.plate.edges.is_elastic() || !self.plate.edges.rigid_products().is_empty();
        if frf.start_hz == 0.0 && may_float {
            return Err(Error::bad_data(
                "a plate that can move as a rigid body has no finite FRF at 0 Hz",
            )
            .field("frf.start_hz")
            .found(frf.start_hz)
            .expected("a number above 0"));
        }
        Ok(())
    }

    /// Bytes that [`crate::simulate`] needs at most, estimated from the sizes alone.
    pub fn memory_bytes(&self) -> f64 {
        let frame = self.references.count();
        let grid = self.responses.grid[0] as f64 * self.responses.grid[1] as f64;
        let responses = grid
            + if self.responses.at_references {
                frame
            } else {
                f64::from(u8::from(self.responses.driving_point))
            };
        let lines = self.frf.line_count().max(0.0);
        let top = BAND_FACTOR * self.frf.stop_hz;
        let [x, y] = needed_terms(&self.plate, top, LEAST_MODES);
        let modes = self.plate.asymptotic_mode_count(TAU * top) * 1.5 + LEAST_MODES as f64;
        let values = 16.0 * responses * frame * lines;
        let working = 16.0 * lines * (8.0 * frame + 2.0 * modes);
        let shapes = (responses + frame) * (256.0 + 40.0 * modes);
        // six square arrays per parity class, and the coefficients of all modes twice
        let plate = 8.0 * x * y * (6.0 * x * y / 4.0 + 2.0 * modes);
        values + working + shapes + plate
    }

    /// Refuses what would need more than `limit_bytes`, before anything is allocated.
    ///
    /// # Errors
    /// [`chladni_frf::ErrorKind::BadData`] with the sizes.
    pub fn check_memory(&self, limit_bytes: u64) -> Result<()> {
        let needed = self.memory_bytes();
        if needed <= limit_bytes as f64 {
            return Ok(());
        }
        let gib = |bytes: f64| format!("{:.3} GiB", bytes / (1u64 << 30) as f64);
        Err(Error::bad_data("this panel needs more memory than is allowed")
            .field("responses, references and frf")
            .found(format!(
                "{} for a grid of {} x {}, {} references along the edges and {:.0} lines up to {} Hz",
                gib(needed),
                self.responses.grid[0],
                self.responses.grid[1],
                self.references.count(),
                self.frf.line_count(),
                self.frf.stop_hz
            ))
            .expected(format!("at most {}", gib(limit_bytes as f64)))
            .help("take fewer points or lines, or allow more with `memory`"))
    }
}
