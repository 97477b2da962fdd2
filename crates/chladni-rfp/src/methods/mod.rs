//! Enters: a sketch or compressed columns; leaves: the poles of one named method. Residues,
//! error bars and grades for given poles are the same for every method (`bars`).
//!
//! | method | idea | source |
//! |---|---|---|
//! | `auto` | maximum likelihood, or the measured-data path | theory.md, sections 2 and 3 |
//! | `lean` | vector fitting, then maximum likelihood, order given | theory.md, section 2 |
//! | `vf` | relaxed vector fitting in x = ω² | Gustavsen 2006 |
//! | `lscf` | common denominator in z, stabilization | Van der Auweraer et al. 2001 |
//! | `plscf` | matrix denominator in z, stabilization | Guillaume et al. 2003 |
//! | `aaa` | barycentric interpolation in x, greedy | Lietaert et al. 2022 |
//! | `rfp`, `grfp` | rational fraction polynomials, reweighted to the likeliest poles | Richardson & Formenti, IMAC 3, 1985; theory.md, section 14 |
//! | the same, `local` | each FRF by itself, linear | Richardson & Formenti, IMAC 1, 1982 |
//! | `peak` | peaks and half-power points | practice |
//! | `circle` | circles in the complex plane | Kennedy & Pancu 1947 |
//!
//! All start from the same two passes over the data (`survey`). `rfp` works in the plane of
//! a damping law (`plane`; `rfp_search`), per band (`overlapping_bands`), on polynomials made for each weight
//! (`lanczos`, `fraction`): `sanathanan_koerner`, then `instrumental`. The form of 1982
//! (`local`) has bands of its own (`bands`), half-function Forsythe polynomials
//! (`forsythe`) and the linear equation error (`equation_error`).
//! Those in the z plane share their normal equations (`matrix_fraction`) and the choice
//! of modes by `stabilization`; those in the plane x choose by the significance of
//! residues (`selection`).

pub(crate) mod aaa;
pub(crate) mod auto;
pub(crate) mod band_lines;
pub(crate) mod bands;
pub(crate) mod bars;
pub(crate) mod circle;
pub(crate) mod clusters;
pub(crate) mod equation_error;
pub(crate) mod fit;
pub(crate) mod forsythe;
pub(crate) mod found;
pub(crate) mod fraction;
pub(crate) mod instrumental;
pub(crate) mod lanczos;
pub(crate) mod lean;
pub(crate) mod limits;
pub(crate) mod local;
pub(crate) mod lscf;
pub(crate) mod matrix_fraction;
pub(crate) mod overlapping_bands;
pub(crate) mod peak;
pub(crate) mod plscf;
pub(crate) mod rfp;
pub(crate) mod rfp_search;
pub(crate) mod sanathanan_koerner;
pub(crate) mod selection;
pub(crate) mod stabilization;
pub(crate) mod survey;
#[cfg(test)]
pub(crate) mod synthetic;
pub(crate) mod vf;
