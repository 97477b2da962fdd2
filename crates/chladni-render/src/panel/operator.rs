//! Response of the panel at the drive frequency: velocity at the responses per unit of
//! each actuator in use.
//!
//! The operator is mobility whatever kind the model was fitted in or the FRFs were
//! measured in. Responses count where they are along Z of a node whose position is known;
//! the zones of a scene lie in the plane x, y. A response measured along −Z is turned
//! round, so that the field has one sign everywhere.

use crate::digits::hertz;
use crate::scene::plane::Position;
use crate::tolerances;
use chladni_frf::{
    Direction, Dof, Error, Finding, FrfKind, FrfSet, ModalModel, Node, ReferenceUnit, Result,
    Severity,
};
use ndarray::Array2;
use num_complex::Complex64;
use std::collections::HashMap;
use std::f64::consts::TAU;

/// Mobility at one frequency, with the DOFs and positions that its rows and columns
/// belong to.
#[derive(Debug, Clone, PartialEq)]
pub struct Operator {
    /// Frequency at which it holds, Hz.
    pub frequency_hz: f64,
    /// Response DOFs, one per row.
    pub responses: Vec<Dof>,
    /// Row of each response in the model or FRF set.
    pub response_rows: Vec<usize>,
    /// Positions of the responses, m.
    pub positions_m: Vec<Position>,
    /// Actuators in use, one per column.
    pub references: Vec<Dof>,
    /// Column of each actuator in the model or FRF set.
    pub reference_columns: Vec<usize>,
    /// Unit of the actuators.
    pub unit: ReferenceUnit,
    /// Velocity per unit of each actuator, (m/s)/N or (m/s)/V; axes (response,
    /// reference).
    pub mobility: Array2<Complex64>,
    /// Findings about what was left out.
    pub findings: Vec<Finding>,
}

impl Operator {
    /// The operator of a modal model; `only` lists the actuators in use, `None` means
    /// all.
    ///
    /// # Errors
    /// [`chladni_frf::ErrorKind::BadData`]: sizes that disagree, NaN in a mode, an
    /// unknown actuator, no usable response.
    pub fn of_model(model: &ModalModel, frequency_hz: f64, only: Option<&[Dof]>) -> Result<Self> {
        check_model(model)?;
        let mut operator = Self::select(
            &model.responses,
            &model.references,
            &model.nodes,
            only,
            model.reference_unit,
        )?;
        operator.frequency_hz = frequency_hz;
        let receptance = model.receptance_by(chladni_linalg::matmul, frequency_hz);
        let factor = FrfKind::Mobility.from_receptance(TAU * frequency_hz);
        operator.fill(|row, column| factor * receptance[[row, column]]);
        if operator.mobility.iter().any(|value| !value.is_finite()) {
            return Err(
                Error::bad_data("the model has no finite mobility at the drive frequency")
                    .field("modes")
                    .found(format!("{} Hz", hertz(frequency_hz)))
                    .expected("a drive frequency off every undamped mode")
                    .help(
                        "an undamped mode at exactly this frequency does that: move the drive \
                       frequency",
                    ),
            );
        }
        if operator.mobility.iter().all(|value| value.norm() == 0.0) {
            return Err(Error::bad_data(
                "no actuator in use moves any response at the drive \
                                        frequency",
            )
            .field("modes")
            .found("zeros")
            .expected(
                "modes or residual terms that are not zero at the responses and at the \
                           actuators in use",
            ));
        }
        if model.in_band_modes().next().is_none() {
            operator.findings.push(
                Finding::caution(
                    "field-of-residuals",
                    "the model has no mode in its band: out-of-band poles and residual terms make \
                     the whole field",
                )
                .help("fit the band around the drive frequency"),
            );
        }
        operator.findings.extend(outside_band(model, frequency_hz));
        operator.findings.extend(untrusted(model));
        Ok(operator)
    }

    /// The operator of measured FRFs: their line nearest to `frequency_hz`, converted to
    /// mobility.
    ///
    /// # Errors
    /// The kind is unknown; no line within half a line; an unknown actuator; no usable
    /// response.
    pub fn of_line(frf: &FrfSet, frequency_hz: f64, only: Option<&[Dof]>) -> Result<Self> {
        let kind = frf.known_kind()?;
        let line = nearest_line(frf, frequency_hz)?;
        let mut operator = Self::select(
            &frf.responses,
            &frf.references,
            &frf.geometry.nodes,
            only,
            frf.reference_unit,
        )?;
        let omega = TAU * frf.frequency_hz[line];
        let factor = FrfKind::Mobility.from_receptance(omega) / kind.from_receptance(omega);
        operator.frequency_hz = frf.frequency_hz[line];
        operator.fill(|row, column| factor * frf.values.get(row, column, line));
        if (operator.frequency_hz - frequency_hz).abs() > tolerances::SAME_FREQUENCY * frequency_hz
        {
            let [line, asked] = [operator.frequency_hz, frequency_hz].map(hertz);
            let words = format!("judged on the line at {line} Hz, the nearest to {asked} Hz");
            let finding = Finding::note("nearest-line", words);
            operator
                .findings
                .push(finding.value("line_hz", operator.frequency_hz));
        }
        operator.drop_unmeasured()?;
        Ok(operator)
    }

    fn select(
        responses: &[Dof],
        references: &[Dof],
        nodes: &[Node],
        only: Option<&[Dof]>,
        unit: ReferenceUnit,
    ) -> Result<Self> {
        let mut operator = Self {
            frequency_hz: f64::NAN,
            responses: Vec::new(),
            response_rows: Vec::new(),
            positions_m: Vec::new(),
            references: Vec::new(),
            reference_columns: Vec::new(),
            unit,
            mobility: Array2::zeros((0, 0)),
            findings: Vec::new(),
        };
        operator.select_responses(responses, nodes)?;
        operator.select_references(references, only)?;
        Ok(operator)
    }

    fn select_responses(&mut self, responses: &[Dof], nodes: &[Node]) -> Result<()> {
        let positions: HashMap<u64, [f64; 3]> =
            nodes.iter().map(|node| (node.label, node.xyz_m)).collect();
        let mut taken: HashMap<[i64; 2], (Dof, f64)> = HashMap::new();
        let (mut sideways, mut nowhere, mut again) = (Vec::new(), Vec::new(), Vec::new());
        let mut above = None;
        for (row, &dof) in responses.iter().enumerate() {
            let Some(&[x, y, z]) = positions.get(&dof.node) else {
                nowhere.push(dof);
                continue;
            };
            if dof.direction.axis() != Direction::PLUS_Z {
                sideways.push(dof);
                continue;
            }
            let place = [x, y].map(|metres| (metres / tolerances::POSITION_M).round() as i64);
            if let Some(&(first, height_m)) = taken.get(&place) {
                if (z - height_m).abs() > tolerances::POSITION_M && above.is_none() {
                    above = Some(out_of_plane([first, dof], [height_m, z]));
                }
                again.push(dof);
                continue;
            }
            taken.insert(place, (dof, z));
            self.responses.push(dof);
            self.response_rows.push(row);
            self.positions_m.push([x, y]);
        }
        let left_out = |finding: Finding, list: &[Dof]| {
            let first = list.first()?;
            let text = format!(
                "{} left out: {}; the first is {first}",
                responses_in_words(list.len()),
                finding.text
            );
            let dofs = list.iter().copied();
            Some(Finding { text, ..finding }.dofs(dofs))
        };
        let many = tolerances::MOST_COINCIDING * responses.len() as f64;
        let mut coincide = Finding::note("responses-coincide", "at the place of another one");
        if again.len() as f64 > many {
            if let Some(error) = above {
                return Err(error);
            }
            coincide.severity = Severity::Caution;
            coincide = coincide.help("check the positions of the nodes (metres)");
        }
        let not_along = Finding::note("responses-not-along-z", "not along Z");
        let no_place = Finding::caution("responses-without-position", "no position in the file")
            .help("give the file its geometry (nodes in metres)");
        self.findings.extend(left_out(coincide, &again));
        self.findings.extend(left_out(not_along, &sideways));
        self.findings.extend(left_out(no_place, &nowhere));
        if self.responses.is_empty() {
            return Err(Error::bad_data("no response can be judged")
                .field("responses")
                .found(format!(
                    "{} not along Z, {} without a position",
                    sideways.len(),
                    nowhere.len()
                ))
                .expected("responses along Z at nodes with known positions")
                .help(match nowhere.is_empty() {
                    true => "a panel lies in the x–y plane and moves along Z: give the responses that direction",
                    false => "the file with the FRFs must carry the geometry (nodes in metres)",
                }));
        }
        Ok(())
    }

    fn select_references(&mut self, references: &[Dof], only: Option<&[Dof]>) -> Result<()> {
        if references.is_empty() {
            return Err(Error::bad_data("no actuator")
                .field("references")
                .found("none")
                .expected("at least one reference DOF"));
        }
        let mut columns: Vec<usize> = match only {
            None => (0..references.len()).collect(),
            Some(list) => list
                .iter()
                .map(|&dof| column_of(dof, references))
                .collect::<Result<_>>()?,
        };
        columns.sort_unstable();
        columns.dedup();
        self.references = columns.iter().map(|&column| references[column]).collect();
        self.reference_columns = columns;
        Ok(())
    }

    /// Fills the matrix from the source's rows and columns, turning responses along −Z
    /// round.
    fn fill(&mut self, value: impl Fn(usize, usize) -> Complex64) {
        let size = (self.responses.len(), self.references.len());
        self.mobility = Array2::zeros(size);
        let rows = self.mobility.rows_mut().into_iter();
        let sources = self.response_rows.iter().zip(&self.responses);
        for (mut row, (&source, response)) in rows.zip(sources) {
            let sign = response.direction.sign();
            let columns = row.iter_mut().zip(&self.reference_columns);
            columns.for_each(|(place, &column)| *place = value(source, column) * sign);
        }
    }

    /// Leaves out responses with an unmeasured value (NaN) at an actuator in use.
    fn drop_unmeasured(&mut self) -> Result<()> {
        let keep: Vec<usize> = (0..self.responses.len())
            .filter(|&i| self.mobility.row(i).iter().all(|v| v.is_finite()))
            .collect();
        let dropped: Vec<Dof> = (0..self.responses.len())
            .filter(|i| !keep.contains(i))
            .map(|i| self.responses[i])
            .collect();
        if keep.is_empty() {
            return Err(Error::bad_data(
                "no response was measured for every actuator in use at this line",
            )
            .field("FRF values")
            .found(format!("NaN, at {} Hz", self.frequency_hz))
            .help("measure the missing pairs, or leave their actuators out with actuators.use"));
        }
        if !dropped.is_empty() {
            self.findings.push(
                Finding::caution(
                    "responses-unmeasured",
                    format!(
                        "{} not judged: not measured for every actuator at {} Hz",
                        responses_in_words(dropped.len()),
                        hertz(self.frequency_hz)
                    ),
                )
                .dofs(dropped)
                .help("measure the missing pairs"),
            );
            self.mobility = self.mobility.select(ndarray::Axis(0), &keep);
            self.responses = keep.iter().map(|&i| self.responses[i]).collect();
            self.response_rows = keep.iter().map(|&i| self.response_rows[i]).collect();
            self.positions_m = keep.iter().map(|&i| self.positions_m[i]).collect();
        }
        Ok(())
    }
}

/// The error of many responses at one place in x and y, two of them at these heights.
fn out_of_plane([first, second]: [Dof; 2], [first_m, second_m]: [f64; 2]) -> Error {
    Error::bad_data("responses lie above each other")
        .field("responses")
        .found(format!(
            "{first} at z = {first_m} m, {second} at z = {second_m} m"
        ))
        .expected("one response at each place in x and y")
        .help("a panel lies in the x–y plane and moves along Z: turn the geometry so that it does")
}

fn responses_in_words(count: usize) -> String {
    match count {
        1 => "1 response".into(),
        _ => format!("{count} responses"),
    }
}

/// The column of the actuator that the user calls `dof`, whatever its sense.
pub(crate) fn column_of(dof: Dof, references: &[Dof]) -> Result<usize> {
    references
        .iter()
        .position(|&reference| reference.same_axis(dof))
        .ok_or_else(|| {
            let shown: Vec<String> = references
                .iter()
                .take(tolerances::DOFS_SHOWN)
                .map(Dof::to_string)
                .collect();
            let more = if references.len() > shown.len() {
                ", ..."
            } else {
                ""
            };
            Error::bad_data("no such actuator")
                .field("actuators.use")
                .found(dof)
                .expected(format!(
                    "one of the {} references: {}{more}",
                    references.len(),
                    shown.join(", ")
                ))
        })
}

/// Index of the line nearest to `frequency_hz`, at most half a line away.
fn nearest_line(frf: &FrfSet, frequency_hz: f64) -> Result<usize> {
    let axis = &frf.frequency_hz;
    let outside = |expected: String| {
        Error::bad_data("the FRFs have no line at the drive frequency")
            .field("frequency_hz")
            .found(format!("{frequency_hz} Hz"))
            .expected(expected)
            .help("measure there, or choose a drive frequency on the measured axis")
    };
    let distance = |k: usize| (axis[k] - frequency_hz).abs();
    let Some(nearest) = (0..axis.len()).min_by(|&a, &b| distance(a).total_cmp(&distance(b))) else {
        return Err(outside("at least one line".into()));
    };
    let left = nearest.checked_sub(1).map(|k| axis[nearest] - axis[k]);
    let right = (nearest + 1 < axis.len()).then(|| axis[nearest + 1] - axis[nearest]);
    let spacing = if frequency_hz < axis[nearest] {
        left.or(right)
    } else {
        right.or(left)
    };
    if distance(nearest) > 0.5 * spacing.unwrap_or(0.0) + tolerances::SAME_FREQUENCY * frequency_hz
    {
        let (first, last) = (axis[0], axis[axis.len() - 1]);
        return Err(outside(format!(
            "a frequency within half a line of the axis, {first} to {last} Hz"
        )));
    }
    Ok(nearest)
}

/// True where the fitted band holds `frequency_hz`; also where the model states none.
pub(crate) fn is_in_band(model: &ModalModel, frequency_hz: f64) -> bool {
    let [low, high] = model.band_hz;
    let slack_hz = tolerances::SAME_FREQUENCY * frequency_hz;
    let is_stated = low < high;
    !is_stated || (low - slack_hz..=high + slack_hz).contains(&frequency_hz)
}

/// The finding of a drive where nothing was fitted; that of a model without modes in its band
/// says more.
pub(crate) fn outside_band(model: &ModalModel, frequency_hz: f64) -> Option<Finding> {
    if is_in_band(model, frequency_hz) || model.in_band_modes().next().is_none() {
        return None;
    }
    let [low, high] = model.band_hz;
    let [drive, from, to] = [frequency_hz, low, high].map(hertz);
    let words = format!(
        "the drive frequency of {drive} Hz lies outside the fitted band of {from} to {to} Hz: the \
         model says nothing reliable there"
    );
    let finding = Finding::caution("drive-outside-band", words)
        .value("frequency_hz", frequency_hz)
        .value("band_low_hz", low)
        .value("band_high_hz", high)
        .help("take a drive frequency inside the band, or fit the model around this one");
    Some(finding)
}

/// The finding about a model that its own fit does not trust, with the first reason that it gave.
fn untrusted(model: &ModalModel) -> Option<Finding> {
    let quality = &model.quality;
    let is_fault = |finding: &&Finding| finding.severity == Severity::Fault;
    let reason = quality.findings.iter().find(is_fault);
    let reason = reason.map_or_else(String::new, |fault| format!(": {}", fault.text));
    let words = format!(
        "the fit of this model is not to be trusted{reason}; nor is what is rendered with it"
    );
    let finding = Finding::fault("untrusted-model", words)
        .help("mend what the fit complains of, and fit again");
    (!quality.trusted).then_some(finding)
}

/// Sizes that agree and finite numbers: a hand-made model may have neither.
fn check_model(model: &ModalModel) -> Result<()> {
    let (rows, columns) = (model.responses.len(), model.references.len());
    for (k, mode) in model.modes.iter().enumerate() {
        let field = |name: &str| format!("modes[{}].{name}", k + 1);
        for (name, found, expected) in [
            ("shape", mode.shape.0.len(), rows),
            ("participation", mode.participation.0.len(), columns),
            ("shape_std", mode.shape_std.len(), rows),
        ] {
            if found != expected {
                return Err(Error::bad_data("sizes disagree")
                    .field(field(name))
                    .found(found)
                    .expected(expected));
            }
        }
        let scalars = [
            mode.frequency_hz,
            mode.frequency_std_hz,
            mode.loss_factor,
            mode.loss_factor_std,
            mode.scale_std.unwrap_or_default(),
        ];
        let finite = all_finite(&mode.shape.0)
            && all_finite(&mode.participation.0)
            && mode
                .shape_std
                .iter()
                .chain(&scalars)
                .all(|value| value.is_finite());
        if !finite {
            return Err(Error::bad_data("NaN or infinity in a mode")
                .field(format!("modes[{}]", k + 1))
                .found(format!("mode at {} Hz", mode.frequency_hz))
                .expected("finite numbers")
                .help("fit the model again, or drop this mode"));
        }
    }
    for (k, term) in model.residual_terms.terms.iter().enumerate() {
        let field = format!("residual_terms.terms[{}]", k + 1);
        if term.matrix.0.dim() != (rows, columns) {
            let found = format!("{} x {}", term.matrix.0.nrows(), term.matrix.0.ncols());
            return Err(Error::bad_data("sizes disagree")
                .field(field)
                .found(found)
                .expected(format!("{rows} x {columns}")));
        }
        if !all_finite(&term.matrix.0) {
            return Err(Error::bad_data("NaN or infinity in a residual term")
                .field(field)
                .found("NaN or infinity")
                .expected("finite numbers"));
        }
    }
    Ok(())
}

/// No NaN and no infinity; looks at all values, which takes less time than to stop at one.
fn all_finite<'a>(values: impl IntoIterator<Item = &'a Complex64>) -> bool {
    let values = values.into_iter();
    values.fold(true, |all, value| {
        all & value.re.is_finite() & value.im.is_finite()
    })
}

/// The mode in whose half-power bandwidth `frequency_hz` lies, Hz.
pub(crate) fn mode_on(model: &ModalModel, frequency_hz: f64) -> Option<f64> {
    let distance = |hz: f64| (hz - frequency_hz).abs();
    let near = model
        .in_band_modes()
        .filter(|mode| distance(mode.frequency_hz) <= 0.5 * mode.loss_factor * mode.frequency_hz);
    near.map(|mode| mode.frequency_hz)
        .min_by(|a, b| distance(*a).total_cmp(&distance(*b)))
}
