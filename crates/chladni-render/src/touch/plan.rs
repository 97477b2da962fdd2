//! Fingers at places: what the mobility becomes under them.
//!
//! Each finger takes the motion of its place away as a load does,
//!
//! H ← H − y_f (1/Z + Y_ff)⁻¹ h_f (theory.md, eq. 52),
//!
//! one after the other; y_f is the mobility from its place to all, of the modes alone, and
//! h_f that from the actuators to its place, interpolated between the responses.

use super::table::{Touch, TouchCriterion, TouchPlaces};
use crate::panel::drive::Drive;
use crate::panel::interpolation::{Interpolation, Nodes};
use crate::panel::modal_field::ModalField;
use crate::panel::operator::Operator;
use crate::problems::problem::Rows;
use crate::scene::plane::{Position, Rectangle};
use crate::scene::zones::{Ground, ZoneMap};
use crate::tolerances;
use chladni_frf::{ModalModel, Scaling};
use ndarray::{concatenate, s, Array2, ArrayView2, Axis};
use num_complex::Complex64;

/// Fingers and the places that they touch.
#[derive(Debug, Clone)]
pub(crate) struct TouchPlan {
    /// The touch that the scene asks for.
    pub(crate) touch: Touch,
    /// False where the size of the modes under a finger had to be guessed.
    pub(crate) is_known: bool,
    /// Force over velocity of each fingertip, N·s/m, the softest first.
    impedances: Vec<Complex64>,
    /// Places that fingers touch, m.
    places_m: Vec<Position>,
    ground: Vec<Ground>,
    onto: Interpolation,
    /// Mobility from each place to all responses.
    from_places: Array2<Complex64>,
    /// Mobility from place to place.
    under: Array2<Complex64>,
    /// Places of the fingers that touch at once.
    cases: Vec<Vec<usize>>,
}

/// Responses that are judged, the first of them hot.
#[derive(Clone, Copy)]
pub(crate) struct Judged<'a> {
    pub(crate) operator: &'a Operator,
    pub(crate) zones: &'a ZoneMap,
    /// Rows of the operator, hot ones first.
    pub(crate) rows: &'a [usize],
    /// Number of hot ones.
    pub(crate) hot: usize,
}

impl TouchPlan {
    /// The fingers of `touch` over `operator`; `None` where the responses carry no area, or
    /// no place is on the ground that is asked for.
    ///
    /// * `between`: places between those of the grid that drives are made for, to judge them
    pub(crate) fn new(
        model: &ModalModel,
        operator: &Operator,
        zones: &ZoneMap,
        touch: &Touch,
        between: bool,
    ) -> Option<Self> {
        let nodes = Nodes::new(&operator.positions_m)?;
        let around = Rectangle::around(&operator.positions_m)?;
        let places_m = places(touch, zones, around, between);
        if places_m.is_empty() {
            return None;
        }
        let onto = nodes.onto(&places_m)?;
        let still = Drive::zeros(operator.references.len());
        let to_all = ModalField::new(model, operator, &still).between_responses();
        let from_places = onto.apply(to_all.view());
        let under = onto.apply(from_places.t());
        let touch = touch.softest_first(operator.frequency_hz);
        let impedances = touch.impedances.iter();
        Some(Self {
            is_known: model.scaling == Scaling::UnitModalMass,
            impedances: impedances
                .map(|touching| touching.finger.impedance(operator.frequency_hz))
                .collect(),
            ground: places_m
                .iter()
                .map(|&place| zones.classify(place))
                .collect(),
            cases: cases(&touch, places_m.len()),
            touch,
            places_m,
            onto,
            from_places,
            under,
        })
    }

    /// Number of places.
    pub(crate) fn places(&self) -> usize {
        self.places_m.len()
    }

    /// Mobility at the responses, then at the fingers of a case, under them.
    fn touched(
        &self,
        mobility: &Array2<Complex64>,
        at_places: &Array2<Complex64>,
        case: &[usize],
        impedance: Complex64,
    ) -> Array2<Complex64> {
        let free = concatenate![Axis(0), mobility.view(), at_places.select(Axis(0), case)];
        let from = concatenate![
            Axis(0),
            self.from_places.select(Axis(0), case).t(),
            self.under.select(Axis(0), case).select(Axis(1), case)
        ];
        // the fingers stand as columns beside the actuators, so that each feels the others
        let mut all = concatenate![Axis(1), free, from];
        let (responses, actuators) = mobility.dim();
        for k in 0..case.len() {
            let bound = impedance.inv() + all[[responses + k, actuators + k]];
            let from = all.column(actuators + k).to_owned();
            let to = all.row(responses + k).mapv(|value| value / bound);
            for (mut row, &from) in all.rows_mut().into_iter().zip(&from) {
                row.scaled_add(-from, &to);
            }
        }
        all.slice(s![.., ..actuators]).to_owned()
    }

    /// The rows that must keep their limits under the `softest` fingertips, every case of
    /// fingers, hot ones first.
    pub(crate) fn rows(&self, judged: Judged, softest: usize) -> Rows {
        let mut hot: Vec<Array2<Complex64>> = Vec::new();
        let mut cold: Vec<Array2<Complex64>> = Vec::new();
        let (mut hot_m, mut cold_m) = (Vec::new(), Vec::new());
        self.each(judged, softest, |case, touched| {
            let [hot_rows, cold_rows] = self.asked(judged, case);
            let positions = |rows: &[usize]| -> Vec<Position> {
                rows.iter()
                    .map(|&row| self.position(judged.operator, case, row))
                    .collect()
            };
            hot_m.extend(positions(&hot_rows));
            cold_m.extend(positions(&cold_rows));
            hot.push(touched.select(Axis(0), &hot_rows));
            cold.push(touched.select(Axis(0), &cold_rows));
        });
        let count = hot_m.len();
        let all: Vec<ArrayView2<Complex64>> =
            hot.iter().chain(&cold).map(|rows| rows.view()).collect();
        let none = Array2::zeros((0, judged.operator.references.len()));
        let mobility = match all.is_empty() {
            true => none,
            false => concatenate(Axis(0), &all).expect("rows of one operator"),
        };
        hot_m.extend(cold_m);
        Rows::new(mobility, count, hot_m, judged.zones)
    }

    /// Hands on the touched mobility of every case.
    pub(crate) fn each(
        &self,
        judged: Judged,
        softest: usize,
        mut take: impl FnMut(&[usize], Array2<Complex64>),
    ) {
        let mobility = &judged.operator.mobility;
        let at_places = self.onto.apply(mobility.view());
        for &impedance in &self.impedances[..softest] {
            for case in &self.cases {
                take(case, self.touched(mobility, &at_places, case, impedance));
            }
        }
    }

    /// Rows of the touched mobility that are asked for: hot and cold ones.
    fn asked(&self, judged: Judged, case: &[usize]) -> [Vec<usize>; 2] {
        if self.touch.criterion == TouchCriterion::Field {
            let (hot, cold) = judged.rows.split_at(judged.hot);
            return [hot.to_vec(), cold.to_vec()];
        }
        let responses = judged.operator.responses.len();
        [Ground::Hot, Ground::Cold].map(|wanted| {
            let on = |k: &usize| self.ground[case[*k]] == wanted;
            (0..case.len()).filter(on).map(|k| responses + k).collect()
        })
    }

    fn position(&self, operator: &Operator, case: &[usize], row: usize) -> Position {
        match operator.positions_m.get(row) {
            Some(place) => *place,
            None => self.places_m[case[row - operator.positions_m.len()]],
        }
    }

    /// Loss of its own motion under the firmest finger, dB, median over the places: where
    /// it is large, a mode carries the motion and the finger moves it.
    pub(crate) fn loss_db(&self, softest: usize) -> f64 {
        let Some(&impedance) = self.impedances[..softest].last() else {
            return 0.0;
        };
        let mut losses: Vec<f64> = (0..self.places_m.len())
            .map(|k| 20.0 * (1.0 + impedance * self.under[[k, k]]).norm().log10())
            .collect();
        losses.sort_by(f64::total_cmp);
        losses[losses.len() / 2]
    }
}

/// The places that fingers are tried at.
fn places(touch: &Touch, zones: &ZoneMap, around: Rectangle, between: bool) -> Vec<Position> {
    let wanted = |ground: Ground| match touch.places {
        TouchPlaces::Hot => ground == Ground::Hot,
        _ => ground != Ground::Ignored,
    };
    if let TouchPlaces::Points(points) = &touch.places {
        return points.clone();
    }
    let area_m2 = (around.x_max - around.x_min) * (around.y_max - around.y_min);
    let coarse_m = (area_m2 / tolerances::MOST_TOUCH_GRID).sqrt();
    let mut step_m = tolerances::TOUCH_STEP_M.max(coarse_m);
    loop {
        let offset = if between { 0.5 * step_m } else { 0.0 };
        let axis = |low: f64, high: f64| {
            let steps = ((high - low - offset) / step_m + tolerances::GRID_ROUNDING)
                .floor()
                .max(0.0) as usize;
            (0..=steps).map(move |k| low + offset + step_m * k as f64)
        };
        let all = axis(around.y_min, around.y_max)
            .flat_map(|y| axis(around.x_min, around.x_max).map(move |x| [x, y]));
        let places: Vec<Position> = all
            .filter(|&place| around.contains(place) && wanted(zones.classify(place)))
            .collect();
        if places.len() <= tolerances::MOST_TOUCH_PLACES {
            return places;
        }
        step_m *= std::f64::consts::SQRT_2;
    }
}

/// Fingers that touch at once: each place alone; where there are more fingers, each place
/// with others, as far from each other as their list allows.
fn cases(touch: &Touch, places: usize) -> Vec<Vec<usize>> {
    let mut cases: Vec<Vec<usize>> = (0..places).map(|k| vec![k]).collect();
    for count in 2..=touch.fingers.min(places) {
        let together = |first: usize| -> Vec<usize> {
            (0..count)
                .map(|finger| (first + finger * places / count) % places)
                .collect()
        };
        cases.extend((0..places).map(together));
    }
    cases
}
