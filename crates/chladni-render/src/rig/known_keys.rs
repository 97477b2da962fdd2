//! Parts of a calibration that other files have, too. A calibration refuses keys of them that
//! those pass over.

use chladni_frf::{Checksum, ComplexMatrix, Source};
use serde::de::Error;
use serde::{Deserialize, Deserializer};

/// Files that a calibration was learned from.
pub(super) fn sources<'de, D>(from: D) -> Result<Vec<Source>, D::Error>
where
    D: Deserializer<'de>,
{
    #[derive(Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Known {
        file: String,
        sha256: Option<String>,
        blake3: Option<String>,
    }
    let source = |known: Known| {
        let file = known.file;
        Checksum::of_fields(known.sha256, known.blake3)
            .map(|checksum| Source { file, checksum })
            .map_err(D::Error::custom)
    };
    let known = Vec::<Known>::deserialize(from)?;
    known.into_iter().map(source).collect()
}

/// A mobility, or a covariance.
pub(super) fn matrix<'de, D>(from: D) -> Result<ComplexMatrix, D::Error>
where
    D: Deserializer<'de>,
{
    #[derive(Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Known {
        re: Vec<Vec<f64>>,
        im: Vec<Vec<f64>>,
    }
    let Known { re, im } = Known::deserialize(from)?;
    ComplexMatrix::of_parts(&re, &im).map_err(D::Error::custom)
}
