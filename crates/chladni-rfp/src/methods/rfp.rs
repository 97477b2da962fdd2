//! Rational fraction polynomials, each FRF by itself, per band.
//!
//! Every FRF is fitted with N(jω)/D(jω) in the measured kind ([`super::equation_error`]): mobility as mobility,
//! accelerance as accelerance, with as many more numerator terms as the kind has powers of jω. Its roots are estimates of
//! the poles as seen from one pair of points. A mode shows in many FRFs at the same place, a computational pole does not:
//! poles of all FRFs are gathered into clusters no wider than half a half-bandwidth, one pole per FRF, and clusters that
//! fewer than a third of the FRFs join are dropped. The pole is the median over its cluster, its standard deviation that of
//! the median (normal scatter from the median absolute deviation). Clusters too small for a scatter take the linearised
//! deviation of the single fits instead.
//!
//! Cost: one small least-squares problem per FRF and band; [`FRFS_USED`] FRFs at most.
//!
//! When not to use it: as an estimate to report. The equation error is weighted by |D|², so damping comes out biased and weak
//! modes next to strong ones are missed. In the study of initialisers on synthetic plates the best basis (this one) missed
//! no mode of 8, 4 of 12 at 60 dB, 10 of 20 and 19 of 34, and stood one to three decades above the Cramér–Rao bound where
//! it hit; a mode with a node at two thirds of the points is lost by rule. It is here because published results were made
//! with it, and because on a few well-separated modes of clean data it is fast and good.
//!
//! M. H. Richardson, D. L. Formenti, *Parameter estimation from frequency response measurements using rational fraction
//! polynomials*, Proc. IMAC 1 (1982) 167–181.

use super::bands::{in_hertz, Band, BandPlan};
use super::equation_error::{Denominator, Root};
use super::{health, BandLines, ClassicPoles};
use crate::error::FitError;
use crate::options::FitOptions;
use crate::screen::Screened;
use num_complex::Complex64;
use rayon::prelude::*;

/// Most FRFs fitted. The median over 200 is known to a tenth of the single scatter, and bias then dominates.
const FRFS_USED: usize = 200;
/// Poles of two FRFs belong together within this part of the smaller half-bandwidth. Larger merges modes a bandwidth
/// apart, smaller breaks noisy clusters up.
const CLUSTER_RADIUS: f64 = 0.5;
/// The same for poles sharper than the lines resolve, in line spacings.
const CLUSTER_SPACINGS: f64 = 0.25;
/// A cluster counts where at least one in this many FRFs joins it.
const CLUSTER_SHARE: usize = 3;
/// Members from which the scatter says more than the single fits.
const SCATTER_MEMBERS: usize = 6;

/// Common poles by clustering those of each FRF.
///
/// * returns poles as viscous s/ω_max, upper half plane
///
/// # Errors
/// [`FitError::Kernel`] where the bands cannot be set up; an FRF that cannot be fitted is left out, said in the warnings.
pub(crate) fn rfp(data: &Screened, options: &FitOptions) -> Result<ClassicPoles, FitError> {
    let (sketch, energy) = data.sketch(options.seed);
    let plan = BandPlan::new(data, &sketch, &energy, options);
    let mut found = ClassicPoles { warnings: plan.warnings, ..ClassicPoles::default() };
    let used = evenly(data.pairs.len(), FRFS_USED);
    if used.len() < data.pairs.len() {
        found.warnings.push(format!("poles come from {} of {} FRFs, evenly chosen", used.len(), data.pairs.len()));
    }
    let mut modes = Vec::new();
    for band in &plan.bands {
        let lines = BandLines::new(data, band)?;
        let fits = fit_each(data, band, &lines, &used);
        if fits.len() < used.len() {
            let label = in_hertz(data, &band.rows);
            found.warnings.push(format!("{label}: {} of {} FRFs could not be fitted", used.len() - fits.len(), used.len()));
        }
        let conditions: Vec<f64> = fits.iter().map(|fit| fit.condition).collect();
        let roots: Vec<Root> = fits.iter().flat_map(|fit| fit.roots.clone()).collect();
        found.warnings.extend(health(&in_hertz(data, &band.rows), &conditions, &roots, &lines));
        modes.extend(common(&fits, &lines));
    }
    Ok(found.with_modes(modes, options.modes))
}

fn fit_each(data: &Screened, band: &Band, lines: &BandLines, used: &[usize]) -> Vec<Denominator> {
    // receptance·g back to the measured kind: its phase jᵖ, so that numerators are real polynomials in jω
    let phase = data.kind.from_receptance(1.0);
    used.par_iter()
        .filter_map(|&l| lines.equations.solve(data.block(l..l + 1, band.rows.clone()).mapv(|v| v * phase).view()).ok())
        .collect()
}

/// `most` of 0..total, evenly spread.
fn evenly(total: usize, most: usize) -> Vec<usize> {
    let count = total.min(most);
    (0..count).map(|i| (2 * i + 1) * total / (2 * count)).collect()
}

/// A physical pole of one FRF.
#[derive(Debug, Clone, Copy)]
struct Candidate {
    frf: usize,
    root: Root,
}

/// Clusters of poles that at least a third of the FRFs share, best supported first.
fn common(fits: &[Denominator], lines: &BandLines) -> Vec<Root> {
    let mut left: Vec<Candidate> = fits
        .iter()
        .enumerate()
        .flat_map(|(frf, fit)| fit.roots.iter().filter(|root| lines.physical(root)).map(move |&root| Candidate { frf, root }))
        .collect();
    let least_radius = CLUSTER_SPACINGS * lines.spacing;
    let mut modes = Vec::new();
    loop {
        let Some(seed) = largest(&left, least_radius) else { break };
        // once more around the median, which is a better centre than any single pole
        let centre = median_pole(&seed.iter().map(|&i| left[i].root).collect::<Vec<_>>());
        let around = gather(&left, centre, least_radius);
        let members = if around.len() >= seed.len() { around } else { seed };
        if CLUSTER_SHARE * members.len() < fits.len() || members.len() < fits.len().min(2) {
            break;
        }
        modes.push(summary(&members.iter().map(|&i| left[i].root).collect::<Vec<_>>()));
        left = left.iter().enumerate().filter(|(i, _)| !members.contains(i)).map(|(_, c)| *c).collect();
    }
    modes
}

/// The largest cluster around one of the poles; the tightest of equally large ones.
fn largest(poles: &[Candidate], least_radius: f64) -> Option<Vec<usize>> {
    let spread = |centre: Complex64, members: &[usize]| members.iter().map(|&i| (poles[i].root.s - centre).norm()).sum::<f64>();
    poles
        .par_iter()
        .map(|candidate| {
            let members = gather(poles, candidate.root.s, least_radius);
            let spread = spread(candidate.root.s, &members);
            (members, spread)
        })
        .collect::<Vec<_>>()
        .into_iter()
        .max_by(|a, b| a.0.len().cmp(&b.0.len()).then(b.1.total_cmp(&a.1)))
        .map(|(members, _)| members)
}

/// Indices of the poles near `centre`, the nearest one of each FRF. Poles come FRF by FRF.
fn gather(poles: &[Candidate], centre: Complex64, least_radius: f64) -> Vec<usize> {
    let mut members: Vec<(usize, f64)> = Vec::new();
    for (i, candidate) in poles.iter().enumerate() {
        let distance = (candidate.root.s - centre).norm();
        if distance > (CLUSTER_RADIUS * candidate.root.s.re.abs().min(centre.re.abs())).max(least_radius) {
            continue;
        }
        match members.last_mut() {
            Some(last) if poles[last.0].frf == candidate.frf => {
                if distance < last.1 {
                    *last = (i, distance);
                }
            }
            _ => members.push((i, distance)),
        }
    }
    members.into_iter().map(|(i, _)| i).collect()
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let n = values.len();
    0.5 * (values[(n - 1) / 2] + values[n / 2])
}

fn median_pole(roots: &[Root]) -> Complex64 {
    Complex64::new(median(roots.iter().map(|r| r.s.re).collect()), median(roots.iter().map(|r| r.s.im).collect()))
}

/// Median pole of a cluster and the standard deviation of that median.
fn summary(roots: &[Root]) -> Root {
    let quantities = |root: &Root| [root.s.norm(), -2.0 * root.s.re / root.s.norm()];
    // standard deviation from the median absolute deviation, and of a median relative to that of a mean, normal scatter
    let (from_mad, of_median) = (1.4826, 1.2533);
    let shrink = |members: usize| if members > 2 { of_median / (members as f64).sqrt() } else { 1.0 / (members as f64).sqrt() };
    let deviation = [0, 1].map(|q| {
        let single = if roots.len() >= SCATTER_MEMBERS {
            let middle = median(roots.iter().map(|r| quantities(r)[q]).collect());
            from_mad * median(roots.iter().map(|r| (quantities(r)[q] - middle).abs()).collect())
        } else {
            median(roots.iter().map(|r| r.deviation[q]).collect())
        };
        single * shrink(roots.len())
    });
    Root { s: median_pole(roots), deviation }
}

#[cfg(test)]
mod tests {
    use super::super::{grfp, synthetic::Structure};
    use super::*;
    use std::f64::consts::TAU;

    #[test]
    fn probe() {
        for crowd in [4_u32, 8, 12, 20, 34] {
            for snr_db in [Some(140.0), Some(60.0), Some(40.0)] {
                let modes: Vec<(f64, f64)> = (0..crowd).map(|n| (20.0 + 20.0 * f64::from(n), 0.12 / (20.0 + 20.0 * f64::from(n)) + 0.002)).collect();
                let s = Structure { modes, responses: 12, snr_db, lines: 1601, band_hz: [10.0, 10.0 + 20.0 * f64::from(crowd)], ..Structure::four_modes() };
                for (name, m) in [("rfp", rfp as fn(&Screened, &FitOptions) -> _), ("grfp", grfp)] {
                    let (found, worst) = s.run(m, None, 1);
                    let wm = TAU * s.band_hz[1];
                    let missed = s.poles().iter().filter(|p| !found.poles.iter().any(|q| (*p / wm - q).norm() < 0.5 * p.re.abs() / wm)).count();
                    eprintln!("crowd {crowd} FRFs {snr_db:?} {name}: {} poles missed {missed} worst {worst:.1e} sd {:.1e} {:?}", found.poles.len(), found.deviation.iter().map(|d| d[0]).fold(0.0, f64::max), found.warnings);
                }
            }
        }
        for (responses, snr) in [(1, 60.0), (1, 40.0), (1, 30.0), (3, 60.0), (3, 20.0), (24, 60.0), (24, 40.0), (24, 20.0)] {
            for modes in [Some(4), None] {
                for (name, m) in [("rfp", rfp as fn(&Screened, &FitOptions) -> _), ("grfp", grfp)] {
                    let s = Structure { responses, snr_db: Some(snr), ..Structure::four_modes() };
                    let truth = s.poles();
                    let mut z = vec![Vec::new(); 2];
                    let mut spurious = Vec::new();
                    let mut missed = 0;
                    let mut e = Vec::new();
                    for seed in 0..30 {
                        let (found, _) = s.run(m, modes, seed);
                        let wm = TAU * 105.0;
                        let mut hit = vec![false; found.poles.len()];
                        for p in &truth {
                            let p = p / wm;
                            let best = (0..found.poles.len()).min_by(|&a, &b| (found.poles[a] - p).norm().total_cmp(&(found.poles[b] - p).norm()));
                            match best {
                                Some(i) if (found.poles[i] - p).norm() < 0.5 * p.re.abs() => {
                                    hit[i] = true;
                                    let q = found.poles[i];
                                    e.push((q.norm() - p.norm()).abs() / p.norm());
                                    z[0].push(((q.norm() - p.norm()) / found.deviation[i][0]).powi(2));
                                    z[1].push(((-2.0 * q.re / q.norm() + 2.0 * p.re / p.norm()) / found.deviation[i][1]).powi(2));
                                }
                                _ => missed += 1,
                            }
                        }
                        for i in 0..hit.len() {
                            if !hit[i] {
                                spurious.push(found.deviation[i][0] / found.poles[i].re.abs());
                            }
                        }
                    }
                    spurious.sort_by(f64::total_cmp);
                    z.iter_mut().for_each(|z| z.push(1.0)); let rms = |v: &Vec<f64>| (v.iter().sum::<f64>() / v.len() as f64).sqrt();
                    eprintln!("{responses} FRFs {snr} dB {modes:?} {name}: missed {missed} spurious {} sd/halfbw {:.2?}.. z_f {:.2} med {:.2} z_eta {:.2} med {:.2} worst f {:.1e}", spurious.len(), spurious.iter().step_by(spurious.len() / 5 + 1).collect::<Vec<_>>(), rms(&z[0]), median(z[0].clone()).sqrt(), rms(&z[1]), median(z[1].clone()).sqrt(), e.iter().fold(0.0_f64, |m, v| m.max(*v)));
                }
            }
        }
    }
}
