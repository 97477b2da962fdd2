//! The table `[touch]` of a scene.

use crate::panel::finger::Finger;
use crate::scene::plane::{Position, Rectangle};
use crate::tolerances;
use chladni_frf::{Error, Result};
use chladni_text::toml_reader::{Keys, Table, Value};

/// Fingers on the panel while the scene plays.
#[derive(Debug, Clone, PartialEq)]
pub struct Touch {
    /// Largest number at once.
    pub fingers: usize,
    /// Their places.
    pub places: TouchPlaces,
    /// The criterion that must hold while they touch.
    pub criterion: TouchCriterion,
    /// Fingertips, in the order of the scene.
    pub impedances: Vec<Touching>,
    /// κ that the drive must keep under all fingers.
    pub kappa_least: f64,
}

/// Places that fingers touch.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum TouchPlaces {
    /// Anywhere on hot ground.
    Hot,
    /// Anywhere on judged ground.
    Any,
    /// At these places, m.
    Points(Vec<Position>),
}

/// The criterion that must hold while fingers touch.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum TouchCriterion {
    /// The ground felt by each finger, alone on the panel.
    Own,
    /// The ground felt by each finger, the others there.
    Pair,
    /// All hot and cold ground.
    Field,
}

/// A fingertip that may touch.
#[derive(Debug, Clone, PartialEq)]
pub struct Touching {
    /// `light`, `mid`, `firm`, or the numbers that the scene gives.
    pub name: String,
    /// Its damper, mass and spring.
    pub finger: Finger,
}

const CRITERIA: [(&str, TouchCriterion); 3] = [
    ("own", TouchCriterion::Own),
    ("pair", TouchCriterion::Pair),
    ("field", TouchCriterion::Field),
];
const IMPEDANCES: &str = "\"light\", \"mid\", \"firm\", or {c = 1.5, m = 0.00015, k = 1500.0} in \
                          N s/m, kg and N/m";
/// Fingertips that a scene without a list of them expects.
const USUAL: [&str; 2] = ["light", "mid"];

/// Reads the table; `keys` are those of the whole scene.
///
/// # Errors
/// An unknown key or word, no place, no fingertip.
pub(crate) fn read_touch(table: &Table, keys: Keys) -> Result<Touch> {
    table.only_keys(keys, "touch")?;
    let impedances = match table.get("impedance") {
        Some(value) => read_impedances(&value, keys)?,
        None => USUAL
            .iter()
            .filter_map(|name| Touching::named(name))
            .collect(),
    };
    let criterion = table
        .get("criterion")
        .map(|value| read_criterion(&value))
        .transpose()?;
    let fingers = match table.get("fingers") {
        Some(value) => match value.count()? {
            count @ 1..=tolerances::MOST_FINGERS => count,
            _ => {
                let expected = format!("1 to {}", tolerances::MOST_FINGERS);
                return Err(value.error("no such number of fingers", expected));
            }
        },
        None => 1,
    };
    let kappa_least = table
        .get("kappa_least")
        .map(|value| value.positive())
        .transpose()?;
    Ok(Touch {
        fingers,
        places: read_places(table)?,
        criterion: criterion.unwrap_or(TouchCriterion::Field),
        impedances,
        kappa_least: kappa_least.unwrap_or(tolerances::KAPPA_LEAST),
    })
}

fn read_criterion(value: &Value) -> Result<TouchCriterion> {
    let name = value.string()?;
    let known = CRITERIA.iter().find(|(known, _)| *known == name);
    known
        .map(|(_, criterion)| *criterion)
        .ok_or_else(|| value.error("no such criterion", "\"own\", \"pair\" or \"field\""))
}

fn read_places(table: &Table) -> Result<TouchPlaces> {
    if let Some(points) = table.get("points_m") {
        if let Some(both) = table.get("where") {
            return Err(both.error("fingers touch either somewhere or at points", "one of them"));
        }
        let list = points.list()?;
        let places = list
            .iter()
            .map(|point| point.numbers::<2>("[x, y] in metres"));
        let places = places.collect::<Result<Vec<_>>>()?;
        if places.is_empty() {
            return Err(points.error("no place is touched", "at least one [x, y]"));
        }
        return Ok(TouchPlaces::Points(places));
    }
    match table.get("where") {
        None => Ok(TouchPlaces::Hot),
        Some(value) => match value.string()? {
            "hot" => Ok(TouchPlaces::Hot),
            "any" => Ok(TouchPlaces::Any),
            _ => Err(value.error(
                "no such ground",
                "\"hot\" or \"any\"; or points_m = [[x, y], ...] in place of it",
            )),
        },
    }
}

fn read_impedances(value: &Value, keys: Keys) -> Result<Vec<Touching>> {
    let read = |entry: &Value| -> Result<Touching> {
        if entry.is_string() {
            let known = Touching::named(entry.string()?);
            return known.ok_or_else(|| entry.error("no such fingertip", IMPEDANCES));
        }
        let table = entry.table()?;
        table.only_keys(keys, "touch.impedance")?;
        let part = |key: &str| table.get(key).map_or(Ok(0.0), |value| value.not_negative());
        let finger = Finger {
            damping_n_s_per_m: part("c")?,
            mass_kg: part("m")?,
            stiffness_n_per_m: part("k")?,
        };
        if finger == Finger::of_mass(0.0) {
            return Err(entry.error("a fingertip that is nothing", IMPEDANCES));
        }
        let given = ["c", "m", "k"].into_iter().zip([
            finger.damping_n_s_per_m,
            finger.mass_kg,
            finger.stiffness_n_per_m,
        ]);
        let given = given.filter(|(key, _)| table.get(key).is_some());
        let parts: Vec<String> = given
            .map(|(key, value)| format!("{key} = {value}"))
            .collect();
        let name = parts.join(", ");
        Ok(Touching { name, finger })
    };
    let all = value.list()?.iter().map(read).collect::<Result<Vec<_>>>()?;
    if all.is_empty() {
        return Err(value.error("no fingertip", IMPEDANCES));
    }
    Ok(all)
}

impl Touch {
    /// Refuses places far beyond the responses: what a finger does there is not known. The rim of a
    /// panel, half the spacing of the responses beyond them, is not far.
    ///
    /// # Errors
    /// [`chladni_frf::ErrorKind::BadData`].
    pub(crate) fn check_places(&self, responses_m: &[Position]) -> Result<()> {
        let (TouchPlaces::Points(places), Some(scanned)) =
            (&self.places, Rectangle::around(responses_m))
        else {
            return Ok(());
        };
        let [width_m, height_m] = [scanned.x_max - scanned.x_min, scanned.y_max - scanned.y_min];
        let spacing_m = width_m.max(height_m) / (responses_m.len() as f64).sqrt();
        let known = scanned.grown(spacing_m);
        let outside = places.iter().find(|place| !known.contains(**place));
        outside.map_or(Ok(()), |[x, y]| {
            Err(Error::bad_data("a finger lies beyond the responses")
                .field("touch.points_m")
                .found(format!("[{x}, {y}]"))
                .expected(format!(
                    "points inside x {:.4} to {:.4} m, y {:.4} to {:.4} m",
                    known.x_min, known.x_max, known.y_min, known.y_max
                ))
                .help("give places on the scanned ground, in metres"))
        })
    }

    /// The same with its fingertips by their impedance at `frequency_hz`, the softest first.
    pub(crate) fn softest_first(&self, frequency_hz: f64) -> Self {
        let mut touch = self.clone();
        let firmness = |touching: &Touching| touching.finger.impedance(frequency_hz).norm();
        touch
            .impedances
            .sort_by(|a, b| firmness(a).total_cmp(&firmness(b)));
        touch
    }
}

impl Touching {
    /// The fingertip of a name.
    pub fn named(name: &str) -> Option<Self> {
        let finger = match name {
            "light" => Finger::LIGHT,
            "mid" => Finger::MID,
            "firm" => Finger::FIRM,
            _ => return None,
        };
        let name = name.to_owned();
        Some(Self { name, finger })
    }
}
