//! Blocks that contradict each other: each is a measurement of the same FRF, and an average
//! hides that one of them was taken with a reversed sensor, in another range or by another
//! trigger.
//!
//! Of two blocks u and v, both FRFs H = Y/X around one peak of the response have a ratio r with
//! H_u ≈ r·H_v. Its error is told by the lines of the peak: what a common ratio leaves is noise.
//! A block contradicts where r is far from 1 on most peaks. A real factor g and a delay τ with
//! r = g·e^(−iωτ) on three quarters of them name the cause. The block that most others agree
//! with is what all are compared with.

use super::takes::{Take, Takes};
use crate::limits::{
    AGREE_PARTS, DELAY_MOST, DELAY_STEPS, FAR_PARTS, FORCE_LEAST, LAW_APART, LAW_EFFECT,
    LAW_ERRORS, LAW_PEAKS, LOOKED_AT_FIRST, PEAKS_MOST, PEAK_LEAST, PEAK_LINES, PEAK_PARTS,
    RATIO_APART, RATIO_COHERENT, RATIO_ERRORS, RATIO_FAR, RATIO_LAW,
};
use num_complex::Complex64;
use std::f64::consts::TAU;

/// Relation of one block to the others.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Apart {
    /// So many times as large, and so many samples later.
    Law { factor: f64, delay: f64 },
    /// No common factor on its peaks.
    Otherwise,
}

/// Ratio of two blocks on one peak.
#[derive(Debug, Clone, Copy)]
struct Ratio {
    /// Frequency of the peak, radians per sample.
    turn: f64,
    /// By the powers of both, so that noise of both does not pull it to 0.
    value: Complex64,
    error: f64,
    /// By least squares: 0 where the blocks have nothing in common.
    projected: Complex64,
    projected_error: f64,
    /// Both blocks follow one ratio.
    is_coherent: bool,
}

impl Ratio {
    fn is_apart(&self) -> bool {
        self.is_coherent && (self.value - 1.0).norm() > RATIO_APART + RATIO_ERRORS * self.error
    }

    fn is_far(&self) -> bool {
        (self.projected - 1.0).norm() > RATIO_FAR + RATIO_ERRORS * self.projected_error
    }
}

/// The blocks that contradict the one that most agree with.
#[derive(Debug, Default)]
pub(super) struct Contradicting {
    /// By run and place.
    pub blocks: Vec<([usize; 2], Apart)>,
    /// The blocks that agree are more than half: the others are the wrong ones.
    pub by_majority: bool,
}

pub(super) fn apart(takes: &Takes) -> Contradicting {
    let driven = driven(&takes.takes);
    let peaks = peaks(takes, &driven);
    if driven.len() < 2 || peaks.len() < 2 {
        return Contradicting::default();
    }
    let beside = |v: usize| -> Vec<Vec<Ratio>> {
        let of = |u: &&Take| {
            let ratios = peaks.iter().map(|peak| ratio(takes, u, driven[v], peak));
            ratios.collect()
        };
        driven.iter().map(of).collect()
    };
    // nearly always one of the first few blocks agrees with all
    let is_one = |v: usize| beside(v).iter().all(|ratios| agree(ratios));
    if (0..driven.len().min(LOOKED_AT_FIRST)).any(is_one) {
        return Contradicting::default();
    }
    let all: Vec<Vec<Vec<Ratio>>> = (0..driven.len()).map(beside).collect();
    let Some(middle) = middle(&all) else {
        return Contradicting::default();
    };
    let with = &all[middle];
    let mates = (0..driven.len()).filter(|&u| u != middle && agree(&with[u]));
    let mates: Vec<usize> = mates.collect();
    // a majority must tell what a block without any law is held against
    let is_majority = !mates.is_empty() && 2 * (mates.len() + 1) > driven.len();
    let is_known = |p: &usize| {
        let mut ratios = mates.iter().map(|&u| with[u][*p]);
        is_majority && ratios.all(|ratio| ratio.is_coherent && !ratio.is_apart())
    };
    let known: Vec<usize> = (0..peaks.len()).filter(is_known).collect();
    let others = (0..driven.len()).filter(|&u| !agree(&with[u]));
    let told = others.filter_map(|u| told(&with[u], &known).map(|apart| (driven[u].of, apart)));
    Contradicting {
        blocks: told.collect(),
        by_majority: is_majority,
    }
}

/// The block that most agree with; among equals the one that explains most others, with the least
/// delays.
fn middle(all: &[Vec<Vec<Ratio>>]) -> Option<usize> {
    let mates = |v: usize| all[v].iter().filter(|ratios| agree(ratios)).count();
    let most = (0..all.len()).map(mates).max()?;
    let related = |v: usize| {
        let laws = all[v].iter().filter_map(|ratios| law(ratios));
        laws.fold((0, 0.0), |(count, sum), (_, delay)| {
            (count + 1, sum + delay.abs())
        })
    };
    let equals = (0..all.len()).filter(|&v| mates(v) == most);
    let related: Vec<(usize, (usize, f64))> = equals.map(|v| (v, related(v))).collect();
    let better = |a: &&(usize, (usize, f64)), b: &&(usize, (usize, f64))| {
        let [(a, by), (b, other)] = [a.1, b.1];
        b.cmp(&a).then(by.round().total_cmp(&other.round()))
    };
    related.iter().min_by(better).map(|(v, _)| *v)
}

/// Relation of a block to the middle one, with which it does not agree; `known`: peaks that a
/// majority agrees on.
fn told(with: &[Ratio], known: &[usize]) -> Option<Apart> {
    let count = with.iter().filter(|ratio| ratio.is_coherent).count();
    let apart = with.iter().filter(|ratio| ratio.is_apart()).count();
    if let Some((factor, delay)) = law(with) {
        let [by_factor, by_delay] = LAW_APART;
        let parts = if delay == 0.0 { by_factor } else { by_delay };
        let least = count.div_ceil(parts).max(2);
        let is_clear = count > 2 || with.iter().all(|r| r.is_apart() && r.is_far());
        if apart >= least && is_clear {
            return Some(Apart::Law { factor, delay });
        }
    }
    let far = known.iter().filter(|&&peak| with[peak].is_far()).count();
    let is_told = known.len() > 2 && far > 1 && FAR_PARTS * far >= known.len();
    is_told.then_some(Apart::Otherwise)
}

/// Blocks in which the force acts as it does in most, without those that start from rest under a
/// force that goes on: their responses lack what the later ones hold of the blocks before.
fn driven(takes: &[Take]) -> Vec<&Take> {
    let power = |take: &Take| take.pairs.iter().map(|[x, _]| x.norm_sqr()).sum::<f64>();
    let mut powers: Vec<f64> = takes.iter().map(power).collect();
    powers.sort_by(f64::total_cmp);
    let usual = powers.get(powers.len() / 2).copied().unwrap_or(0.0);
    let acts = |take: &&Take| !take.is_start && power(take) > FORCE_LEAST * usual;
    takes.iter().filter(acts).collect()
}

/// Places of the lines around each of the strongest peaks of the response.
fn peaks(takes: &Takes, driven: &[&Take]) -> Vec<(usize, std::ops::Range<usize>)> {
    let mut powers = vec![0.0; takes.lines.len()];
    for take in driven {
        let all: f64 = take.pairs.iter().map(|[_, y]| y.norm_sqr()).sum();
        if all > 0.0 {
            let of = powers.iter_mut().zip(&take.pairs);
            of.for_each(|(power, [_, y])| *power += y.norm_sqr() / all);
        }
    }
    let reach = PEAK_LINES.max(takes.samples / 2 / PEAK_PARTS);
    let around = |at: usize| {
        let line = takes.lines[at];
        let first = takes.lines.partition_point(|&k| k + reach < line);
        let end = takes.lines.partition_point(|&k| k <= line + reach);
        first..end
    };
    let largest = powers.iter().copied().fold(0.0, f64::max);
    let mut strong: Vec<usize> = (0..powers.len())
        .filter(|&at| powers[at] > PEAK_LEAST * largest)
        .collect();
    strong.sort_by(|&a, &b| powers[b].total_cmp(&powers[a]));
    let is_top = |at: &usize| {
        powers[around(*at)]
            .iter()
            .all(|power| *power <= powers[*at])
    };
    let tops = strong.into_iter().filter(is_top).take(PEAKS_MOST);
    tops.map(|at| (takes.lines[at], around(at))).collect()
}

fn ratio(
    takes: &Takes,
    u: &Take,
    v: &Take,
    (line, lines): &(usize, std::ops::Range<usize>),
) -> Ratio {
    let (mut cross, mut of_u, mut of_v) = (Complex64::default(), 0.0, 0.0);
    for ([x, y], [other_x, other_y]) in u.pairs[lines.clone()].iter().zip(&v.pairs[lines.clone()]) {
        let powers = [x.norm_sqr(), other_x.norm_sqr()];
        if powers[0] > 0.0 && powers[1] > 0.0 {
            // noise of the response weighs by 1/|X|² in H
            let weight = powers[0] * powers[1] / (powers[0] + powers[1]);
            let (a, b) = (y / x, other_y / other_x);
            cross += weight * b.conj() * a;
            of_u += weight * a.norm_sqr();
            of_v += weight * b.norm_sqr();
        }
    }
    let spare = (lines.len() as f64 - 1.0).max(1.0);
    let coherence = cross.norm_sqr() / (of_u * of_v);
    // the least of NaN and 1 is 1
    let coherence = match coherence.is_finite() {
        true => coherence.min(1.0),
        false => 0.0,
    };
    let size = (of_u / of_v).sqrt();
    let noise = 1.0 - coherence;
    Ratio {
        turn: TAU * *line as f64 / takes.samples as f64,
        value: Complex64::from_polar(size, cross.arg()),
        // noise of one block alone makes it larger by half of the incoherent part
        error: size * ((noise / spare).sqrt() + 0.5 * noise),
        projected: cross / of_v,
        projected_error: size * (noise / spare).sqrt(),
        is_coherent: coherence > RATIO_COHERENT,
    }
}

/// True where both tell one FRF.
fn agree(ratios: &[Ratio]) -> bool {
    let coherent = ratios.iter().filter(|ratio| ratio.is_coherent).count();
    let apart = ratios.iter().filter(|ratio| ratio.is_apart()).count();
    coherent > 1 && AGREE_PARTS * apart <= coherent
}

/// Factor and delay that three quarters of the peaks follow; a delay only where no factor does.
fn law(ratios: &[Ratio]) -> Option<(f64, f64)> {
    let ratios: Vec<&Ratio> = ratios.iter().filter(|ratio| ratio.is_coherent).collect();
    if ratios.len() < 2 {
        return None;
    }
    let follow = |delay: f64| {
        let turned =
            |ratio: &&Ratio| (ratio.value * Complex64::from_polar(1.0, ratio.turn * delay)).re;
        let mut factors: Vec<f64> = ratios.iter().map(turned).collect();
        factors.sort_by(f64::total_cmp);
        let factor = factors[factors.len() / 2];
        let of = |ratio: &Ratio| factor * Complex64::from_polar(1.0, -ratio.turn * delay);
        let effect = ratios.iter().map(|ratio| (of(ratio) - 1.0).norm());
        let effect = effect.fold(0.0, f64::max);
        let within = (effect / LAW_EFFECT).min(RATIO_LAW) * factor.abs();
        let misfit =
            |ratio: &&Ratio| (ratio.value - of(ratio)).norm() / (within + LAW_ERRORS * ratio.error);
        let misfits: Vec<f64> = ratios.iter().map(misfit).collect();
        let count = misfits.iter().filter(|misfit| **misfit <= 1.0).count();
        let [least, of_all] = LAW_PEAKS;
        let is_followed = of_all * count >= least * ratios.len();
        let left: f64 = misfits.iter().map(|misfit| misfit.min(1.0).powi(2)).sum();
        (is_followed, left, factor)
    };
    if let (true, _, factor) = follow(0.0) {
        return Some((factor, 0.0));
    }
    if ratios.len() < 3 {
        return None;
    }
    let delays = (-(DELAY_MOST * DELAY_STEPS)..=DELAY_MOST * DELAY_STEPS)
        .map(|step| f64::from(step) / f64::from(DELAY_STEPS));
    delays
        .map(|delay| (delay, follow(delay)))
        .filter(|(_, (follows, ..))| *follows)
        .min_by(|a, b| a.1 .1.total_cmp(&b.1 .1))
        .map(|(delay, (_, _, factor))| (factor, delay))
}
