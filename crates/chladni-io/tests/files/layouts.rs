//! Small FRF tables in thousands of layouts, with the truth beside them: each is read
//! right, or refused by a message that names the place and what to do. None is misread.
//!
//! `CHLADNI_LAYOUTS=2000 cargo test -p chladni-io --test files layouts` runs as many.

use chladni_frf::{Error, ErrorKind, FrfKind, FrfSet, ReferenceUnit};
use chladni_io::{read_frf, ReadOptions};
use num_complex::Complex64;
use rand::seq::IndexedRandom;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::TAU;

/// Variants that the suite runs; the environment variable runs more.
const VARIANTS: usize = 400;
/// Largest relative error of a value that was printed with nine digits.
const TOLERANCE: f64 = 1e-6;
/// At least this part must be read: a reader that refuses everything misreads nothing.
const LEAST_READ: f64 = 0.7;

#[derive(Debug, Clone, Copy, PartialEq)]
enum Form {
    ReIm,
    ImRe,
    Degrees,
    Radians,
    Decibels,
}

/// Place of the unit of the FRFs.
#[derive(Debug, Clone, Copy, PartialEq)]
enum UnitPlace {
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
enum Shape {
    One,
    Wide,
    Long,
}

/// Place of the DOFs in a wide table.
#[derive(Debug, Clone, Copy, PartialEq)]
enum DofPlace {
    Before,
    Inside,
    RowAbove,
    Nowhere,
}

#[derive(Debug, Clone)]
struct Layout {
    shape: Shape,
    form: Form,
    delimiter: &'static str,
    decimal_comma: bool,
    header: bool,
    header_sign: &'static str,
    names: usize,
    unit: (&'static str, f64, FrfKind, ReferenceUnit),
    unit_place: UnitPlace,
    phase_labelled: bool,
    decibel_reference: bool,
    frequency: (&'static str, f64),
    frequency_labelled: bool,
    dofs: DofPlace,
    gap: Option<&'static str>,
    commented_rows: Option<&'static str>,
    prelude: usize,
    coherence: bool,
    trailing_delimiter: bool,
    line_end: &'static str,
    encoding: usize,
    digits: usize,
}

/// The outcome that a layout must have.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Expected {
    Read,
    Refused,
    Either,
}

const UNITS: [(&str, f64, FrfKind, ReferenceUnit); 8] = [
    ("m/s/N", 1.0, FrfKind::Mobility, ReferenceUnit::Newton),
    ("mm/s/N", 1e-3, FrfKind::Mobility, ReferenceUnit::Newton),
    ("(mm/s)/N", 1e-3, FrfKind::Mobility, ReferenceUnit::Newton),
    ("µm/s/V", 1e-6, FrfKind::Mobility, ReferenceUnit::Volt),
    ("m/s²/N", 1.0, FrfKind::Accelerance, ReferenceUnit::Newton),
    ("m/s^2/N", 1.0, FrfKind::Accelerance, ReferenceUnit::Newton),
    ("mm/N", 1e-3, FrfKind::Receptance, ReferenceUnit::Newton),
    ("g/N", 9.80665, FrfKind::Accelerance, ReferenceUnit::Newton),
];
const FREQUENCIES: [(&str, f64); 7] = [
    ("Hz", 1.0),
    ("Hz", 1.0),
    ("Hz", 1.0),
    ("kHz", 1e3),
    ("MHz", 1e6),
    ("rad/s", 1.0 / TAU),
    ("rpm", 1.0 / 60.0),
];
const NAMES: [[(&str, &str); 2]; 6] = [
    [("re", "im"), ("mag", "phase")],
    [("Real", "Imag"), ("Magnitude", "Phase")],
    [("Re(H)", "Im(H)"), ("Abs(H)", "Arg(H)")],
    [("H_real", "H_imag"), ("H_mag", "H_phase")],
    [("RealPart", "ImagPart"), ("Amplitude", "Angle")],
    [("Realteil", "Imaginärteil"), ("Betrag", "Phase")],
];
const PRELUDES: [&[&str]; 6] = [
    &[],
    &["Some analyser 2.1", "Date: 3 May"],
    &["# operator = somebody", "% a remark of no use"],
    &["// points: 12"],
    &["Plate A", ""],
    &["\"Title\"", "Points\t12"],
];
const ENCODINGS: [&str; 5] = [
    "utf-8",
    "utf-8 with mark",
    "utf-16 le",
    "utf-16 be",
    "latin-1",
];

fn draw(random: &mut ChaCha8Rng) -> Layout {
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

    fn expected(&self) -> Expected {
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

    fn polar(&self) -> bool {
        !matches!(self.form, Form::ReIm | Form::ImRe)
    }

    /// Label of the unit of the first or second column of an FRF, where it has one.
    fn label(&self, second: bool) -> String {
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

    fn name(&self, second: bool, pair: Option<&str>) -> String {
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

    fn frequency_name(&self) -> String {
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

    fn number(&self, value: f64) -> String {
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

/// The truth: SI values on an axis in Hz, three responses at one reference.
struct Truth {
    frequency_hz: Vec<f64>,
    frfs: Vec<(&'static str, Vec<Complex64>)>,
    coherence: f64,
}

const PAIRS: [(&str, &str); 3] = [("1:+Z", "101:+Z"), ("2:+Z", "101:+Z"), ("7:-X", "101:+Z")];

fn truth(layout: &Layout, random: &mut ChaCha8Rng) -> Truth {
    let lines = random.random_range(8..14);
    let start = if layout.gap.is_some() { 0.0 } else { 5.0 };
    let step = random.random_range(3.0..9.0);
    let frequency_hz: Vec<f64> = (0..lines).map(|k| start + step * k as f64).collect();
    let count = if layout.shape == Shape::One { 1 } else { 3 };
    let resonance = TAU * (start + step * (lines as f64 / 2.0 - 0.3));
    let frfs = (0..count).map(|i| {
        let residue = random.random_range(0.5..2.0) * if i == 1 { -1.0 } else { 1.0 };
        let of_line = |&f: &f64| {
            let w = TAU * f;
            let below = Complex64::new(resonance * resonance - w * w, 0.05 * resonance * w);
            let value = residue / below;
            match layout.unit.2 {
                FrfKind::Receptance => value,
                FrfKind::Mobility => value * Complex64::new(0.0, w),
                FrfKind::Accelerance => value * -w * w,
            }
        };
        ("", frequency_hz.iter().map(of_line).collect())
    });
    let frfs: Vec<(&'static str, Vec<Complex64>)> = frfs.collect();
    Truth {
        frequency_hz,
        frfs: frfs
            .into_iter()
            .zip(PAIRS)
            .map(|((_, values), (response, _))| (response, values))
            .collect(),
        coherence: 0.75,
    }
}

/// The two numbers of a value as the layout writes them.
fn columns_of(layout: &Layout, value: Complex64) -> [f64; 2] {
    let value = value / layout.unit.1;
    match layout.form {
        Form::ReIm => [value.re, value.im],
        Form::ImRe => [value.im, value.re],
        Form::Degrees => [value.norm(), value.arg().to_degrees()],
        Form::Radians => [value.norm(), value.arg()],
        Form::Decibels => [20.0 * value.norm().log10(), value.arg().to_degrees()],
    }
}

fn table(layout: &Layout, truth: &Truth) -> String {
    let d = layout.delimiter;
    let end = if layout.trailing_delimiter { d } else { "" };
    let mut lines: Vec<String> = PRELUDES[layout.prelude]
        .iter()
        .map(|line| (*line).to_owned())
        .collect();
    match layout.unit_place {
        UnitPlace::Remark => lines.push(format!("# unit = {}", layout.unit.0)),
        UnitPlace::Line => lines.push(format!("Units: {}", layout.unit.0)),
        _ => {}
    }
    if layout.header {
        lines.extend(
            headers(layout, truth)
                .into_iter()
                .map(|line| format!("{}{}{end}", layout.header_sign, line.join(d))),
        );
    }
    let gap = |row: usize| layout.gap.filter(|_| row == 0);
    let cells = |row: usize, value: Complex64| -> Vec<String> {
        let mut cells: Vec<String> = columns_of(layout, value)
            .into_iter()
            .map(|number| match gap(row) {
                Some("blank") => String::new(),
                Some(gap) => gap.to_owned(),
                None => layout.number(number),
            })
            .collect();
        if layout.coherence {
            cells.push(layout.number(truth.coherence));
        }
        cells
    };
    let mut rows: Vec<Vec<String>> = Vec::new();
    if layout.shape == Shape::Long {
        for (i, (response, values)) in truth.frfs.iter().enumerate() {
            for (row, value) in values.iter().enumerate() {
                let f = layout.number(truth.frequency_hz[row] / layout.frequency.1);
                let mut line: Vec<String> = if layout.names.is_multiple_of(2) {
                    let (node, direction) = response.split_once(':').unwrap();
                    let code = if direction == "-X" { "-1" } else { "3" };
                    vec![node.into(), code.into(), "101".into(), "3".into()]
                } else {
                    vec![PAIRS[i].0.into(), PAIRS[i].1.into()]
                };
                line.push(f);
                line.extend(cells(row, *value));
                rows.push(line);
            }
        }
    } else {
        for (row, f) in truth.frequency_hz.iter().enumerate() {
            let mut line = vec![layout.number(f / layout.frequency.1)];
            for (_, values) in &truth.frfs {
                line.extend(cells(row, values[row]));
            }
            rows.push(line);
        }
    }
    for (at, row) in rows.iter().enumerate() {
        lines.push(format!("{}{end}", row.join(d)));
        if let Some(sign) = layout.commented_rows.filter(|_| at == 2 || at == 3) {
            lines.push(format!("{sign}{}{end}", row.join(d)));
        }
    }
    if let Some(sign) = layout.commented_rows.filter(|_| layout.names % 2 == 1) {
        // the first row, commented out above the data
        let first = lines.len() - rows.len() - 2;
        lines.insert(first, format!("{sign}{}{end}", rows[1].join(d)));
    }
    lines.push(String::new());
    lines.join(layout.line_end)
}

/// Rows of names and units.
fn headers(layout: &Layout, truth: &Truth) -> Vec<Vec<String>> {
    let mut names = Vec::new();
    if layout.shape == Shape::Long {
        if layout.names.is_multiple_of(2) {
            names.extend(["node", "dir", "ref_node", "ref_dir"].map(str::to_owned));
        } else {
            names.extend(["response", "reference"].map(str::to_owned));
        }
    }
    names.push(layout.frequency_name());
    let mut above = vec![String::new()];
    let mut units = vec![layout.frequency.0.to_owned()];
    let frfs = if layout.shape == Shape::Long {
        1
    } else {
        truth.frfs.len()
    };
    for (response, reference) in &PAIRS[..frfs] {
        let pair = match layout.names % 3 {
            0 => format!("{response}/{reference}"),
            1 => format!("{response}:{reference}"),
            _ => format!(
                "{}/{}",
                response.replace(':', ""),
                reference.replace(":+", "")
            ),
        };
        let in_name = Some(pair.as_str()).filter(|_| layout.shape != Shape::Long);
        names.extend([layout.name(false, in_name), layout.name(true, in_name)]);
        above.extend([pair, String::new()]);
        units.extend([layout.label(false), layout.label(true)]);
        if layout.coherence {
            names.push("coherence".into());
            above.push(String::new());
            units.push("-".into());
        }
    }
    let mut rows = Vec::new();
    if layout.dofs == DofPlace::RowAbove && layout.shape != Shape::Long {
        rows.push(above);
    }
    rows.push(names);
    if layout.unit_place == UnitPlace::Row {
        if !layout.frequency_labelled {
            units[0] = "Hz".into();
        }
        rows.push(units);
    }
    rows
}

fn encoded(text: &str, encoding: &str) -> Vec<u8> {
    match encoding {
        "utf-8" => text.into(),
        "utf-8 with mark" => [b"\xef\xbb\xbf", text.as_bytes()].concat(),
        "utf-16 le" => [0xfeff]
            .into_iter()
            .chain(text.encode_utf16())
            .flat_map(u16::to_le_bytes)
            .collect(),
        "utf-16 be" => [0xfeff]
            .into_iter()
            .chain(text.encode_utf16())
            .flat_map(u16::to_be_bytes)
            .collect(),
        _ => text.chars().map(|c| u8::try_from(c).unwrap()).collect(),
    }
}

/// The fault of what was read.
fn misread(layout: &Layout, truth: &Truth, set: &FrfSet, warnings: &[String]) -> Option<String> {
    let said = layout.unit_place != UnitPlace::Nowhere;
    let factor = if said { 1.0 } else { 1.0 / layout.unit.1 };
    let spoken = warnings
        .iter()
        .any(|warning| warning.contains("taken as SI"));
    if said == spoken {
        return Some(format!("unit: {warnings:?}"));
    }
    if set.kind != said.then_some(layout.unit.2) {
        return Some(format!("kind {:?}", set.kind));
    }
    if said && set.reference_unit != layout.unit.3 {
        return Some("unit of the reference".into());
    }
    let axis = set.frequency_hz.to_vec();
    let is_near = |a: f64, b: f64| (a - b).abs() <= TOLERANCE * b.abs();
    let same_axis = axis.len() == truth.frequency_hz.len()
        && axis
            .iter()
            .zip(&truth.frequency_hz)
            .all(|(a, b)| is_near(*a, *b));
    if !same_axis {
        return Some(format!("axis {axis:?} for {:?}", truth.frequency_hz));
    }
    let named = layout.shape == Shape::Long || (layout.header && layout.dofs != DofPlace::Nowhere);
    for (i, (response, values)) in truth.frfs.iter().enumerate() {
        let expected = if named {
            (*response).to_owned()
        } else {
            format!("{}:+Z", i + 1)
        };
        if set.responses.get(i).map(ToString::to_string) != Some(expected) {
            return Some(format!("responses {:?}", set.responses));
        }
        // without any header the assumption is said: real part first
        let assumed = layout.form == Form::ImRe
            && !layout.header
            && warnings
                .iter()
                .any(|warning| warning.contains("taken as real"));
        let found = set.values.frf(i, 0);
        for (k, (a, b)) in found.iter().zip(values).enumerate() {
            let masked = k == 0 && layout.gap.is_some();
            let b = if assumed {
                Complex64::new(b.im, b.re)
            } else {
                *b
            } * factor;
            let right = if masked {
                a.re.is_nan() && a.im.is_nan()
            } else {
                (a - b).norm() <= 10.0 * TOLERANCE * b.norm()
            };
            if !right {
                return Some(format!("value {k} of FRF {i}: {a} for {b}"));
            }
            let coherence = set.coherence.as_ref().map(|coherence| coherence[[i, 0, k]]);
            if coherence != layout.coherence.then_some(truth.coherence as f32) {
                return Some(format!("coherence {coherence:?}"));
            }
        }
    }
    let reference = if named { "101:+Z" } else { "1:S" };
    (set.references.len() != 1 || set.references[0].to_string() != reference)
        .then(|| format!("references {:?}", set.references))
}

/// The fault of a refusal.
fn unhelpful(error: &Error) -> Option<String> {
    let has_place = error.line.is_some() || error.field.is_some();
    let says_what_to_do = error.help.is_some() || error.expected.is_some();
    (error.kind != ErrorKind::BadData || !has_place || !says_what_to_do || error.found.is_none())
        .then(|| "the refusal names no place, or not what to do".into())
}

#[test]
fn every_layout_is_read_right_or_refused_by_name() {
    let variants = std::env::var("CHLADNI_LAYOUTS").map_or(VARIANTS, |count| {
        count.parse().expect("a number of variants")
    });
    let folder = tempfile::tempdir().unwrap();
    let mut wrong = Vec::new();
    let (mut read, mut refused) = (0, 0);
    for number in 0..variants {
        let mut random = ChaCha8Rng::seed_from_u64(number as u64);
        let layout = draw(&mut random);
        let truth = truth(&layout, &mut random);
        let text = table(&layout, &truth);
        let encoding = ENCODINGS[layout.encoding];
        let path = folder.path().join(format!("{number}.csv"));
        std::fs::write(&path, encoded(&text, encoding)).unwrap();
        let result = read_frf(&[path], &ReadOptions::default());
        let expected = layout.expected();
        let complaint = match &result {
            Ok((set, _, warnings)) => {
                read += 1;
                match misread(&layout, &truth, set, &crate::words(warnings)) {
                    None if expected == Expected::Refused => Some("read, by chance".into()),
                    complaint => complaint,
                }
            }
            Err(error) => {
                refused += 1;
                match unhelpful(error) {
                    None if expected == Expected::Read => Some("refused".into()),
                    complaint => complaint,
                }
                .map(|words: String| format!("{words}: {error}"))
            }
        };
        if let Some(complaint) = complaint {
            let head: Vec<&str> = text.split(layout.line_end).take(9).collect();
            wrong.push(format!(
                "variant {number}: {complaint}\n{layout:?}\n{}\n",
                head.join("\n")
            ));
        }
    }
    println!("{variants} layouts: {read} read, {refused} refused");
    assert!(
        wrong.is_empty(),
        "{} of {variants}:\n{}",
        wrong.len(),
        wrong[..wrong.len().min(12)].join("\n")
    );
    assert!(
        read as f64 >= LEAST_READ * variants as f64,
        "{read} of {variants} are read"
    );
}
