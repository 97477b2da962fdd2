//! Writes universal files: 151, 164 (SI), 2411 or 15, 82, 2412, one 55 or 2414 per shape,
//! and one 58 or 58b per function.
//!
//! A [`Plan`] checks everything before the first byte is written:
//!
//! * Every pair of an FRF set becomes a function of type 4 and its coherence one of type
//!   6; pairs that were not measured are left out. Other functions are written in SI.
//! * An even axis gets spacing 1 and its exact step as `df=` in ID line 4, because record
//!   7 prints six digits of it. An uneven axis gets spacing 0; as text it keeps six
//!   digits only.
//! * Binary values are exact. Text keeps 13 digits of doubles and 6 of singles.
//! * Masked lines (NaN) stay NaN in the binary form, where readers mask them again. As
//!   text they are refused: dropping them would give every FRF an axis of its own.
//! * Dates are blank: the same data give the same bytes.

use super::write_function::{coherence, frf, in_si};
use super::write_options::WriteOptions;
use super::{write58, write_mesh, write_shape};
use crate::{Abscissa, Contents, Function, Shape, ShapeForm};
use chladni_frf::{Error, ErrorKind, Finding, Result, CREATED_BY};
use std::io::{self, Write};

/// Largest number that a field of ten columns holds.
pub(super) const LARGEST_NODE: u64 = 9_999_999_999;

/// The checked content and options of a universal file to write.
#[derive(Debug)]
pub struct Plan<'a> {
    contents: &'a Contents,
    options: WriteOptions,
    /// Axis of the FRF set.
    axis: Abscissa,
    warnings: Vec<Finding>,
}

/// Checks and writes `contents`. Returns findings on what the format cannot hold.
///
/// # Errors
/// As [`Plan::new`], and [`ErrorKind::Io`].
pub fn write(
    sink: &mut dyn Write,
    contents: &Contents,
    options: WriteOptions,
) -> Result<Vec<Finding>> {
    let plan = Plan::new(contents, options)?;
    plan.write(sink)
        .map_err(|error| Error::new(ErrorKind::Io, format!("cannot write: {error}")))?;
    Ok(plan.warnings)
}

impl<'a> Plan<'a> {
    /// Checks that everything fits the format.
    ///
    /// # Errors
    /// A node number of more than ten digits, and masked values where text is to be
    /// written.
    pub fn new(contents: &'a Contents, options: WriteOptions) -> Result<Self> {
        let axis = contents.frf.as_ref().map_or(
            Abscissa::Even {
                start: 0.0,
                step: 1.0,
            },
            |set| axis_of(&set.frequency_hz.to_vec()),
        );
        let mut plan = Self {
            contents,
            options,
            axis,
            warnings: Vec::new(),
        };
        let geometry = contents.geometry();
        for node in &geometry.nodes {
            check_node(node.label)?;
        }
        for label in geometry
            .lines
            .iter()
            .chain(&geometry.faces)
            .flatten()
            .chain(contents.shapes.iter().flat_map(|shape| &shape.nodes))
        {
            check_node(*label)?;
        }
        let many_cornered = write_mesh::faces_as_lines(geometry);
        if many_cornered > 0 {
            plan.warnings.push(Finding::note(
                "digits-lost",
                format!(
                    "{many_cornered} faces with more than four corners are written as closed \
                     trace lines (82)"
                ),
            ));
        }
        if options.old_datasets && !geometry.nodes.is_empty() {
            plan.warnings.push(Finding::note(
                "digits-lost",
                "dataset 15 keeps 6 digits of the coordinates; 2411 (.uff, .unv) and HDF5 keep all",
            ));
        }
        plan.check_shapes()?;
        plan.check_functions()?;
        Ok(plan)
    }

    fn check_functions(&mut self) -> Result<()> {
        let mut count = 0;
        let mut lost: Vec<Finding> = Vec::new();
        self.each_function(|function| {
            count += 1;
            check_node(function.response.node)?;
            check_node(function.reference.node)?;
            for warning in write58::check(function, self.options)? {
                // once, however many functions it concerns
                if !lost.contains(&warning) {
                    lost.push(warning);
                }
            }
            Ok::<(), Error>(())
        })?;
        self.warnings.append(&mut lost);
        if count > 0 && !self.options.binary {
            self.warnings.push(Finding::note(
                "digits-lost",
                "text keeps 13 digits of double and 6 of single precision; the binary form and \
                 HDF5 are exact",
            ));
        }
        Ok(())
    }

    fn check_shapes(&mut self) -> Result<()> {
        let shapes = &self.contents.shapes;
        shapes.iter().try_for_each(write_shape::check)?;
        if !shapes.is_empty() {
            self.warnings.push(Finding::note(
                "digits-lost",
                "datasets 55 and 2414 keep 6 digits of shapes; HDF5 keeps all",
            ));
        }
        let at_rest = |shape: &&Shape| {
            let becomes_55 = self.options.old_datasets && shape.form == ShapeForm::Analysis2414;
            becomes_55 && shape.nodes.len() < self.contents.geometry().nodes.len()
        };
        let count = shapes.iter().filter(at_rest).count();
        if count > 0 {
            self.warnings.push(Finding::note(
                "digits-lost",
                format!(
                    "{count} shapes have no value at some nodes: dataset 55 takes these as at rest"
                ),
            ));
        }
        Ok(())
    }

    /// Findings on what the format cannot hold.
    pub fn warnings(&self) -> &[Finding] {
        &self.warnings
    }

    /// Writes the file.
    ///
    /// # Errors
    /// Those of `sink`.
    pub fn write(&self, sink: &mut dyn Write) -> io::Result<()> {
        write_header(sink)?;
        write_mesh::write_nodes(sink, self.contents.geometry(), self.options)?;
        write_mesh::write_mesh(sink, self.contents.geometry())?;
        for (k, shape) in self.contents.shapes.iter().enumerate() {
            write_shape::write(sink, shape, k + 1, self.options)?;
        }
        self.each_function(|function| write58::write(sink, function, self.options))
    }

    /// Calls `each` with every function of the file, in order.
    fn each_function<E>(
        &self,
        mut each: impl FnMut(&Function) -> std::result::Result<(), E>,
    ) -> std::result::Result<(), E> {
        if let Some(set) = &self.contents.frf {
            for response in 0..set.responses.len() {
                for reference in 0..set.references.len() {
                    for function in [
                        frf(set, response, reference),
                        coherence(set, response, reference),
                    ]
                    .into_iter()
                    .flatten()
                    {
                        each(&Function {
                            abscissa: self.axis.clone(),
                            ..function
                        })?;
                    }
                }
            }
        }
        self.contents
            .functions
            .iter()
            .try_for_each(|function| each(&in_si(function)))
    }
}

fn check_node(label: u64) -> Result<()> {
    if label <= LARGEST_NODE {
        return Ok(());
    }
    Err(
        Error::bad_data("the node number does not fit a universal file")
            .field("node number")
            .found(label)
            .expected("at most ten digits")
            .help("renumber the nodes, or write HDF5"),
    )
}

/// The axis; start and step where all its steps are equal within rounding.
fn axis_of(frequency_hz: &[f64]) -> Abscissa {
    /// Rounding of a computed axis, in units of the last place of its largest value.
    const ROUNDING: f64 = 4.0 * f64::EPSILON;
    let (Some(&first), Some(&last)) = (frequency_hz.first(), frequency_hz.last()) else {
        return Abscissa::Even {
            start: 0.0,
            step: 1.0,
        };
    };
    if frequency_hz.len() == 1 {
        return Abscissa::Even {
            start: first,
            step: 1.0,
        };
    }
    let mean = (last - first) / (frequency_hz.len() - 1) as f64;
    // the step that an axis was computed from is usually a short decimal number
    let short = |digits: usize| format!("{mean:.digits$e}").parse().unwrap_or(mean);
    let error = |step: f64| -> f64 {
        frequency_hz
            .iter()
            .enumerate()
            .map(|(k, x)| (first + step * k as f64 - x).abs())
            .fold(0.0, f64::max)
    };
    let candidates = [mean, frequency_hz[1] - first, short(14), short(11)];
    let (step, error) = candidates.map(|step| (step, error(step))).into_iter().fold(
        (mean, f64::INFINITY),
        |best, next| {
            if next.1 < best.1 {
                next
            } else {
                best
            }
        },
    );
    if error <= ROUNDING * first.abs().max(last.abs()) {
        Abscissa::Even { start: first, step }
    } else {
        Abscissa::Uneven(frequency_hz.to_vec())
    }
}

fn write_header(sink: &mut dyn Write) -> io::Result<()> {
    let no_date = format!("{:20}", "");
    write!(
        sink,
        "    -1\n   \
         151\nNONE\nNONE\n{CREATED_BY}\n{no_date}{:10}{:10}{:10}\n{no_date}\n{CREATED_BY}\n{no_date}\n    -1\n",
        0, 0, 0
    )?;
    write!(
        sink,
        "    -1\n   164\n{:10}{:<20}{:10}\n",
        1, "SI: Meter (newton)", 2
    )?;
    write!(
        sink,
        "{0}{0}{0}\n{1}\n    -1\n",
        write58::fortran(1.0, 25, 17, 'D'),
        write58::fortran(273.15, 25, 17, 'D')
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn computed_even_axes_are_recognised_and_keep_their_step() {
        for step in [0.1, 0.3125, 1.0 / 3.0, 2.44140625, 0.5] {
            for first in [0.0, 10.0] {
                let axis: Vec<f64> = (0..6400).map(|k| first + step * f64::from(k)).collect();
                assert_eq!(
                    axis_of(&axis),
                    Abscissa::Even { start: first, step },
                    "{first} {step}"
                );
            }
        }
    }

    #[test]
    fn an_axis_with_one_line_missing_is_uneven() {
        let axis: Vec<f64> = (0..100).filter(|k| *k != 50).map(f64::from).collect();
        assert_eq!(axis_of(&axis), Abscissa::Uneven(axis.clone()));
        assert_eq!(
            axis_of(&[7.0]),
            Abscissa::Even {
                start: 7.0,
                step: 1.0
            }
        );
    }
}
