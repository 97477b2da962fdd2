//! A tighter certified bound: the phases that the relaxation lets go are held in sectors,
//! one case after the other.
//!
//! Every drive moves two hot rows with some phase difference. Cut the circle into
//! sectors, prove a bound for each ([`Dual`]), and the largest of them holds for every
//! drive (branch and bound; Lawler and Wood, Oper. Res. 14 (1966) 699). All pairs have
//! the row of the largest multiplier in common, so that two narrow sectors bound the
//! difference of their other rows, too. The sector that is cut next belongs to the row
//! whose phase the relaxed solution of the worst case leaves most open.

use crate::panel::drive::Drive;
use crate::solving::dual::{Dual, Sector};
use crate::tolerances;
use chladni_frf::Result;
use ndarray::{Array2, ArrayView2, Axis};
use num_complex::Complex64;
use std::f64::consts::{FRAC_PI_2, PI};

/// A case: sectors of rows over the common one, and a bound that holds there, squared.
struct Case {
    star: Vec<Sector>,
    bound: f64,
}

/// A bound, squared, of at most what `root` proved, `bound`; ends below the target, after
/// `tolerances::MOST_CASES`, or at a case whose own bound arithmetic does not reach.
///
/// * `hot`, `bounded`: the rows of `root`; the last bounded ones are unit rows, one per actuator
/// * `target`: what is sought, squared, once the drive that one more case leans on is
///   known
pub(crate) fn tighten(
    root: &Dual,
    hot: ArrayView2<Complex64>,
    bounded: ArrayView2<Complex64>,
    bound: f64,
    mut target: impl FnMut(Drive) -> Result<f64>,
) -> Result<f64> {
    let weights = root.of_hot();
    if weights.len() < 2 {
        return Ok(bound); // one row has no phase difference to hold
    }
    let bounded = counting(root, hot, bounded);
    let common = (0..weights.len())
        .max_by(|&a, &b| weights[a].total_cmp(&weights[b]))
        .unwrap_or(0);
    let mut open = vec![Case {
        star: Vec::new(),
        bound,
    }];
    let (mut proven, mut enough) = (0.0, 0.0);
    for number in 1..=tolerances::MOST_CASES {
        let Some(worst) = (0..open.len()).max_by(|&a, &b| open[a].bound.total_cmp(&open[b].bound))
        else {
            break;
        };
        let case = open.swap_remove(worst);
        let Ok((dual, bound, drive)) = solved(hot, bounded.view(), &case, enough) else {
            open.push(case);
            break;
        };
        // a drive takes as long as many cases
        if number.is_power_of_two() && bound > enough {
            enough = target(drive)?;
        }
        match dual.hot_products().filter(|_| bound > enough) {
            Some(products) => open.extend(
                cut(&case.star, common, &products, &dual.of_hot())
                    .into_iter()
                    .map(|star| Case { star, bound }),
            ),
            None => proven = f64::max(proven, bound),
        }
    }
    Ok(open
        .iter()
        .map(|case| case.bound)
        .fold(proven, f64::max)
        .min(bound))
}

/// The multipliers of a case, the bound that they prove, and the drive that it leans on.
fn solved(
    hot: ArrayView2<Complex64>,
    bounded: ArrayView2<Complex64>,
    case: &Case,
    enough: f64,
) -> Result<(Dual, f64, Drive)> {
    let mut dual = Dual::start(hot, bounded, with_differences(&case.star))?;
    let (bound, drive) = dual.solve(enough)?;
    Ok((dual, bound.min(case.bound), drive))
}

/// The bounded rows whose multipliers count. A proof without the others is one, and takes a
/// tenth of the time. Where they leave a drive unbounded, as that of an actuator that moves
/// nothing, the unit rows of all actuators are among them.
fn counting(
    root: &Dual,
    hot: ArrayView2<Complex64>,
    bounded: ArrayView2<Complex64>,
) -> Array2<Complex64> {
    let of_bounded = root.of_bounded();
    let least = tolerances::CASE_ROWS * of_bounded.iter().copied().fold(0.0, f64::max);
    let units = bounded.nrows() - bounded.ncols();
    let rows = |with_units: bool| {
        let kept: Vec<usize> = (0..of_bounded.len())
            .filter(|&k| of_bounded[k] > least || (with_units && k >= units))
            .collect();
        bounded.select(Axis(0), &kept)
    };
    let few = rows(false);
    match Dual::start(hot, few.view(), Vec::new()) {
        Ok(_) => few,
        Err(_) => rows(true),
    }
}

/// The sectors of a case, and those that they imply between two rows beside the common
/// one.
fn with_differences(star: &[Sector]) -> Vec<Sector> {
    let mut all = star.to_vec();
    for (k, a) in star.iter().enumerate() {
        for b in &star[..k] {
            let half_width = a.half_width + b.half_width;
            if half_width < FRAC_PI_2 {
                all.push(Sector {
                    rows: [a.rows[1], b.rows[1]],
                    middle: b.middle - a.middle,
                    half_width,
                });
            }
        }
    }
    all
}

/// The cases that one is cut into: halves of a sector, or thirds of the circle for a row
/// that has none yet.
fn cut(
    star: &[Sector],
    common: usize,
    products: &Array2<Complex64>,
    weights: &[f64],
) -> Vec<Vec<Sector>> {
    let openness = |row: usize| {
        let size = (products[[common, common]].re * products[[row, row]].re).sqrt();
        weights[row] * (1.0 - products[[common, row]].norm() / size)
    };
    let rows = (0..weights.len()).filter(|&row| row != common);
    let row = rows
        .max_by(|&a, &b| openness(a).total_cmp(&openness(b)))
        .expect("two hot rows");
    let with = |sector: Sector| {
        star.iter()
            .copied()
            .filter(|known| known.rows != sector.rows)
            .chain([sector])
            .collect()
    };
    match star.iter().find(|sector| sector.rows == [common, row]) {
        Some(&sector) => {
            let half_width = 0.5 * sector.half_width;
            [-half_width, half_width]
                .map(|shift| {
                    with(Sector {
                        middle: sector.middle + shift,
                        half_width,
                        ..sector
                    })
                })
                .to_vec()
        }
        None => {
            let middle = products[[row, common]].arg();
            let third = |k: i32| Sector {
                rows: [common, row],
                middle: middle + 2.0 * PI / 3.0 * f64::from(k),
                half_width: PI / 3.0,
            };
            [0, 1, 2].map(|k| with(third(k))).to_vec()
        }
    }
}
