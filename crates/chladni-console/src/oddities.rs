//! Oddities of a set of FRFs that reading shows. Those that only a fit shows are in
//! `chladni-rfp/src/checks`.

use crate::limits::{CLIPPED_LINES, LINES_OF_A_TEST, LOWEST_END_HZ};
use crate::table::counted;
use chladni_frf::{driving_point_faults, Dof, Finding, FrfSet};
use num_complex::Complex64;

/// Oddities that matter to every command.
pub fn of_set(frf: &FrfSet) -> Vec<Finding> {
    [kilohertz(frf), clipped(frf), directions(frf)]
        .into_iter()
        .flatten()
        .collect()
}

/// Findings for listings only, on oddities that may be meant.
pub fn of_listing(frf: &FrfSet) -> Vec<Finding> {
    let (responses, references) = (frf.responses.len(), frf.references.len());
    let swapped = (references > responses).then(|| {
        let words = format!(
            "more references ({references}) than responses ({responses}), as a roving hammer \
             gives them"
        );
        Finding::note("more-references", words).help(
            "if the sensor roved and the force stayed in its place, response and reference are \
             swapped: correct the export",
        )
    });
    // commands that fit report driving points from the model, which shows more
    swapped
        .into_iter()
        .chain(driving_point_faults(frf))
        .collect()
}

fn kilohertz(frf: &FrfSet) -> Option<Finding> {
    let last = *frf.frequency_hz.last()?;
    (last < LOWEST_END_HZ && frf.frequency_hz.len() >= LINES_OF_A_TEST).then(|| {
        let words = format!("the frequency axis ends at {last} Hz: is it in kHz?");
        Finding::caution("axis-in-khz", words).help("correct the axis or its unit")
    })
}

fn clipped(frf: &FrfSet) -> Option<Finding> {
    let found: Vec<(usize, usize)> = frf
        .all_pairs()
        .filter(|&(i, j)| is_clipped(frf.values.frf(i, j).as_slice().unwrap_or(&[])))
        .collect();
    let &(i, j) = found.first()?;
    let words = format!(
        "{} of {} FRFs are clipped: they stay at their largest value over {CLIPPED_LINES} lines or \
         more, the first of them ({}, {})",
        found.len(),
        frf.pairs(),
        frf.responses[i],
        frf.references[j]
    );
    Some(
        Finding::caution("clipped", words)
            .dofs([frf.responses[i], frf.references[j]])
            .help("measure again at a lower level, or export without limits"),
    )
}

fn is_clipped(values: &[Complex64]) -> bool {
    [
        |value: &Complex64| value.re.abs(),
        |value: &Complex64| value.im.abs(),
    ]
    .into_iter()
    .any(|part| {
        // a run of CLIPPED_LINES values contains one of these pairs of neighbours
        let mut pairs = values.windows(2).step_by(CLIPPED_LINES - 1);
        if !pairs.any(|pair| part(&pair[0]) == part(&pair[1])) {
            return false;
        }
        let largest = values.iter().map(part).fold(0.0, f64::max);
        let mut run = 0;
        largest > 0.0
            && values.iter().any(|value| {
                run = if part(value) == largest { run + 1 } else { 0 };
                run >= CLIPPED_LINES
            })
    })
}

fn directions(frf: &FrfSet) -> Option<Finding> {
    let mut axes: Vec<(Dof, usize)> = Vec::new();
    for &dof in &frf.responses {
        match axes
            .iter_mut()
            .find(|(known, _)| known.direction.axis() == dof.direction.axis())
        {
            Some((_, count)) => *count += 1,
            None => axes.push((dof, 1)),
        }
    }
    let names: Vec<String> = axes
        .iter()
        .map(|(dof, count)| {
            format!(
                "{} along {}",
                counted(*count, "response"),
                dof.direction.axis()
            )
        })
        .collect();
    (axes.len() > 1).then(|| {
        let words = format!(
            "mixed axes: {}; maps show the most frequent one, scenes judge +Z alone",
            names.join(", ")
        );
        Finding::caution("mixed-axes", words)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plateau_at_the_largest_value_is_clipped_and_a_peak_is_not() {
        let peak: Vec<Complex64> = (0..60)
            .map(|k| Complex64::new(0.1, -1.0 / (1.0 + (f64::from(k) - 30.0).powi(2) / 40.0)))
            .collect();
        assert!(!is_clipped(
            &peak
                .iter()
                .map(|value| value + Complex64::new(1e-6 * value.im, 0.0))
                .collect::<Vec<_>>()
        ));
        let flat: Vec<Complex64> = peak
            .iter()
            .map(|value| Complex64::new(1e-3 * value.im, value.im.max(-0.7)))
            .collect();
        assert!(is_clipped(&flat));
        assert!(!is_clipped(&vec![Complex64::ZERO; 60]));
    }
}
