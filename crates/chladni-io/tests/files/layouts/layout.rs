//! The choices that make a layout, and what must come of it.

use chladni_frf::{FrfKind, ReferenceUnit};
use rand::seq::IndexedRandom;
use rand::Rng;
use rand_chacha::ChaCha8Rng;
use std::f64::consts::TAU;

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Form {
    ReIm,
    ImRe,
    Degrees,
    Radians,
    Decibels,
}

/// Place of the unit of the FRFs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum UnitPlace {
    Square,
    Round,
    Behind,
    Slash,
    Underscores,
    Row,
    Remark,
    Line,
    OnlySecond,
    Nowhere,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Shape {
    One,
    Wide,
    Long,
}

/// Place of the DOFs in a wide table.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum DofPlace {
    Before,
    Inside,
    RowAbove,
    Nowhere,
}

#[derive(Debug, Clone)]
pub(super) struct Layout {
    pub(super) shape: Shape,
    pub(super) form: Form,
    pub(super) delimiter: &'static str,
    pub(super) decimal_comma: bool,
    pub(super) header: bool,
    pub(super) header_sign: &'static str,
    pub(super) names: usize,
    pub(super) unit: (&'static str, f64, FrfKind, ReferenceUnit),
    pub(super) unit_place: UnitPlace,
    pub(super) phase_labelled: bool,
    pub(super) decibel_reference: bool,
    pub(super) frequency: (&'static str, f64),
    pub(super) frequency_labelled: bool,
    pub(super) dofs: DofPlace,
    pub(super) gap: Option<&'static str>,
    pub(super) commented_rows: Option<&'static str>,
    pub(super) prelude: usize,
    pub(super) coherence: bool,
    pub(super) trailing_delimiter: bool,
    pub(super) line_end: &'static str,
    pub(super) encoding: usize,
    pub(super) digits: usize,
}

/// The outcome that a layout must have.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Expected {
    Read,
    Refused,
    Either,
}

pub(super) const UNITS: [(&str, f64, FrfKind, ReferenceUnit); 8] = [
    ("m/s/N", 1.0, FrfKind::Mobility, ReferenceUnit::Newton),
    ("mm/s/N", 1e-3, FrfKind::Mobility, ReferenceUnit::Newton),
    ("(mm/s)/N", 1e-3, FrfKind::Mobility, ReferenceUnit::Newton),
    ("µm/s/V", 1e-6, FrfKind::Mobility, ReferenceUnit::Volt),
    ("m/s²/N", 1.0, FrfKind::Accelerance, ReferenceUnit::Newton),
    ("m/s^2/N", 1.0, FrfKind::Accelerance, ReferenceUnit::Newton),
    ("mm/N", 1e-3, FrfKind::Receptance, ReferenceUnit::Newton),
    ("g/N", 9.80665, FrfKind::Accelerance, ReferenceUnit::Newton),
];

pub(super) const FREQUENCIES: [(&str, f64); 7] = [
    ("Hz", 1.0),
    ("Hz", 1.0),
    ("Hz", 1.0),
    ("kHz", 1e3),
    ("MHz", 1e6),
    ("rad/s", 1.0 / TAU),
    ("rpm", 1.0 / 60.0),
];

pub(super) const NAMES: [[(&str, &str); 2]; 6] = [
    [("re", "im"), ("mag", "phase")],
    [("Real", "Imag"), ("Magnitude", "Phase")],
    [("Re(H)", "Im(H)"), ("Abs(H)", "Arg(H)")],
    [("H_real", "H_imag"), ("H_mag", "H_phase")],
    [("RealPart", "ImagPart"), ("Amplitude", "Angle")],
    [("Realteil", "Imaginärteil"), ("Betrag", "Phase")],
];

pub(super) const PRELUDES: [&[&str]; 6] = [
    &[],
    &["Some analyser 2.1", "Date: 3 May"],
    &["# operator = somebody", "% a remark of no use"],
    &["// points: 12"],
    &["Plate A", ""],
    &["\"Title\"", "Points\t12"],
];

pub(super) const ENCODINGS: [&str; 5] = [
    "utf-8",
    "utf-8 with mark",
    "utf-16 le",
    "utf-16 be",
    "latin-1",
];

pub(super) fn draw(random: &mut ChaCha8Rng) -> Layout {
    let mut pick = |items: &[&'static str]| *items.choose(random).unwrap();
    let delimiter = pick(&[",", ";", "\t", " ", "   "]);
    let header_sign = pick(&["", "", "", "", "# ", "% ", "//"]);
    let gap = pick(&["", "", "", "NaN", "NA", "blank", "nan(ind)"]);
    let commented = pick(&["", "", "", "#", "%", "// "]);
    let line_end = pick(&["\n", "\n", "\r\n", "\r"]);
    let unit_place = [
        UnitPlace::Square,
        UnitPlace::Square,
        UnitPlace::Round,
        UnitPlace::Behind,
        UnitPlace::Slash,
        UnitPlace::Underscores,
        UnitPlace::Row,
        UnitPlace::Row,
        UnitPlace::Remark,
        UnitPlace::Line,
        UnitPlace::OnlySecond,
        UnitPlace::Nowhere,
    ];
    let forms = [
        Form::ReIm,
        Form::ReIm,
        Form::ImRe,
        Form::Degrees,
        Form::Radians,
        Form::Decibels,
    ];
    let shapes = [Shape::One, Shape::Wide, Shape::Long];
    let dofs = [
        DofPlace::Before,
        DofPlace::Inside,
        DofPlace::RowAbove,
        DofPlace::Nowhere,
    ];
    Layout {
        shape: *shapes.choose(random).unwrap(),
        form: *forms.choose(random).unwrap(),
        delimiter,
        decimal_comma: random.random_bool(0.3),
        header: random.random_bool(0.92),
        header_sign,
        names: random.random_range(0..NAMES.len()),
        unit: *UNITS.choose(random).unwrap(),
        unit_place: *unit_place.choose(random).unwrap(),
        phase_labelled: random.random_bool(0.7),
        decibel_reference: random.random_bool(0.7),
        frequency: *FREQUENCIES.choose(random).unwrap(),
        frequency_labelled: random.random_bool(0.8),
        dofs: *dofs.choose(random).unwrap(),
        gap: Some(gap).filter(|gap| !gap.is_empty()),
        commented_rows: Some(commented).filter(|sign| !sign.is_empty()),
        prelude: random.random_range(0..PRELUDES.len()),
        coherence: random.random_bool(0.2),
        trailing_delimiter: random.random_bool(0.1),
        line_end,
        encoding: random.random_range(0..ENCODINGS.len()),
        digits: random.random_range(0..3),
    }
    .possible()
}

impl Layout {
    /// Without what no writer could do.
    fn possible(mut self) -> Self {
        let blanks = self.delimiter.trim_matches(' ').is_empty();
        if blanks && self.gap == Some("blank") {
            self.gap = Some("NaN");
        }
        self.trailing_delimiter &= !blanks;
        if blanks && matches!(self.unit_place, UnitPlace::Behind | UnitPlace::Slash) {
            self.unit_place = UnitPlace::Square;
        }
        if self.form == Form::Decibels && self.unit_place == UnitPlace::Underscores {
            self.unit_place = UnitPlace::Square; // nobody writes `mag_dB_re_1_mm_s_N`
        }
        if self.form == Form::Decibels && self.unit_place == UnitPlace::OnlySecond {
            self.unit_place = UnitPlace::Square;
        }
        if !matches!(self.form, Form::ReIm | Form::ImRe) && self.unit_place == UnitPlace::OnlySecond
        {
            self.unit_place = UnitPlace::Square; // the second is a phase
        }
        let row_of_labels = self.unit_place == UnitPlace::Row;
        if (self.shape == Shape::Long || (blanks && self.form == Form::Decibels)) && row_of_labels {
            self.unit_place = UnitPlace::Square;
        }
        if !self.header {
            let remark = matches!(self.unit_place, UnitPlace::Remark | UnitPlace::Line);
            if !remark {
                self.unit_place = UnitPlace::Nowhere;
            }
            self.frequency_labelled = false;
            self.phase_labelled = false;
            self.dofs = DofPlace::Nowhere;
            if self.shape == Shape::Long {
                self.shape = Shape::One;
            }
        }
        if !self.header_sign.is_empty() && self.unit_place == UnitPlace::Row {
            self.unit_place = UnitPlace::Square;
        }
        if self.dofs == DofPlace::RowAbove && (blanks || !self.header_sign.is_empty()) {
            self.dofs = DofPlace::Before;
        }
        if blanks && self.names == 5 && self.dofs == DofPlace::Before {
            self.names = 0;
        }
        if !self.frequency_labelled {
            self.frequency = FREQUENCIES[0];
        }
        if self.unit_place == UnitPlace::Nowhere && self.form == Form::Decibels {
            self.decibel_reference = false;
        }
        self
    }

    pub(super) fn expected(&self) -> Expected {
        let polar = matches!(self.form, Form::Degrees | Form::Radians | Form::Decibels);
        let commas = self.decimal_comma && self.delimiter == ",";
        let ambiguous_phase =
            (self.form == Form::Radians || self.form == Form::Decibels) && !self.phase_labelled;
        if commas
            || (self.form == Form::Decibels && !self.decibel_reference)
            || (self.form == Form::Radians && ambiguous_phase)
            || (!self.header && polar)
        {
            return Expected::Refused;
        }
        // a row of units between blanks cannot leave one out
        let blanks = self.delimiter.trim_matches(' ').is_empty();
        if self.unit_place == UnitPlace::Row && blanks && polar && !self.phase_labelled {
            return Expected::Refused;
        }
        if !self.header {
            return Expected::Either;
        }
        Expected::Read
    }

    pub(super) fn polar(&self) -> bool {
        !matches!(self.form, Form::ReIm | Form::ImRe)
    }

    /// Label of the unit of the first or second column of an FRF, where it has one.
    pub(super) fn label(&self, second: bool) -> String {
        let unit = self.unit.0;
        let is_angle = self.polar() && second;
        if is_angle {
            let angle = match self.form {
                Form::Radians => ["rad", "radians", "Radian"][self.names % 3],
                _ => ["deg", "°", "degrees"][self.names % 3],
            };
            return if self.phase_labelled { angle } else { "" }.into();
        }
        if self.form == Form::Decibels {
            return if self.decibel_reference {
                format!("dB re 1 {unit}")
            } else {
                "dB".into()
            };
        }
        unit.into()
    }

    pub(super) fn name(&self, second: bool, pair: Option<&str>) -> String {
        let of_form = NAMES[self.names][usize::from(self.polar())];
        let swapped = self.form == Form::ImRe;
        let part = if second != swapped {
            of_form.1
        } else {
            of_form.0
        };
        let blanks = self.delimiter.trim_matches(' ').is_empty();
        let named = match (self.dofs, pair) {
            (DofPlace::Before, Some(pair)) if blanks => format!("{pair}_{part}"),
            (DofPlace::Before, Some(pair)) => format!("{pair} {part}"),
            (DofPlace::Inside, Some(pair)) => format!("{part}({pair})"),
            _ => part.to_owned(),
        };
        let label = self.label(second);
        let is_angle = self.polar() && second;
        // an angle stands in the name where the FRF's unit stands elsewhere
        let place = match self.unit_place {
            UnitPlace::Row => return named,
            UnitPlace::OnlySecond if !second => return named,
            UnitPlace::Remark | UnitPlace::Line | UnitPlace::Nowhere | UnitPlace::Underscores
                if is_angle =>
            {
                UnitPlace::Behind
            }
            UnitPlace::Remark | UnitPlace::Line | UnitPlace::Nowhere
                if self.form == Form::Decibels =>
            {
                UnitPlace::Square
            }
            UnitPlace::Remark | UnitPlace::Line | UnitPlace::Nowhere => return named,
            place => place,
        };
        if label.is_empty() {
            return named;
        }
        match place {
            UnitPlace::Square if blanks => format!("{named}[{}]", label.replace(' ', "_")),
            UnitPlace::Square | UnitPlace::OnlySecond => format!("{named} [{label}]"),
            UnitPlace::Round if blanks => format!("{named}({})", label.replace(' ', "_")),
            UnitPlace::Round => format!("{named} ({label})"),
            UnitPlace::Slash => format!("{named} / ({label})"),
            UnitPlace::Underscores if !label.contains(['(', '^', '²']) => {
                format!("{named}_{}", label.replace('/', "_"))
            }
            _ if blanks => format!("{named}_{label}"),
            _ => format!("{named} {label}"),
        }
    }

    pub(super) fn frequency_name(&self) -> String {
        let name = ["f", "Frequency", "freq", "frequency"][self.names % 4];
        let unit = self.frequency.0;
        if !self.frequency_labelled || self.unit_place == UnitPlace::Row {
            return name.into();
        }
        let blanks = self.delimiter.trim_matches(' ').is_empty();
        match self.names {
            0 => format!("{name}_{unit}"),
            1 if blanks => format!("{name}({unit})"),
            1 => format!("{name} ({unit})"),
            2 if !blanks => format!("{name} in {unit}"),
            3 => format!("{name}/{unit}"),
            _ if blanks => format!("{name}[{unit}]"),
            _ => format!("{name} [{unit}]"),
        }
    }

    pub(super) fn number(&self, value: f64) -> String {
        let text = match self.digits {
            0 => format!("{value:.9e}"),
            1 => format!("{value:+.9E}"),
            _ => format!("{value:.9e}").replace('e', "D"),
        };
        if self.decimal_comma {
            text.replace('.', ",")
        } else {
            text
        }
    }
}
