//! DOFs that the user declares for FRFs whose files name none or wrong ones.

use chladni_frf::{Dof, Error, Result};
use std::path::Path;

/// A list of DOFs, one row for each FRF in the order of the files.
///
/// ```
/// use chladni_io::DeclaredDofs;
/// let list = DeclaredDofs::parse("response, reference\n5:+Z, 101:+Z\n5:+Z, 102:+Z\n");
/// assert_eq!(list.unwrap().rows.len(), 2);
/// ```
#[derive(Debug, Clone, PartialEq, Default)]
pub struct DeclaredDofs {
    /// In the order of the FRFs.
    pub rows: Vec<DeclaredRow>,
}

/// One row of such a list.
#[derive(Debug, Clone, PartialEq)]
pub struct DeclaredRow {
    /// Name of the file of the FRF; `None`: the next file.
    pub file: Option<String>,
    /// Response DOF.
    pub response: Dof,
    /// Reference DOF.
    pub reference: Dof,
}

impl DeclaredRow {
    /// A row of the cells `response, reference` or `file, response, reference`.
    ///
    /// # Errors
    /// [`chladni_frf::ErrorKind::BadData`] for other cells.
    pub fn of_cells(cells: &[impl AsRef<str>]) -> Result<Self> {
        let cells: Vec<&str> = cells.iter().map(AsRef::as_ref).collect();
        let (file, response, reference) = match cells.as_slice() {
            [response, reference] => (None, response, reference),
            [file, response, reference] => (Some((*file).to_owned()), response, reference),
            _ => {
                return Err(Error::bad_data("no row of a list of DOFs")
                    .found(cells.join(", "))
                    .expected("response, reference or file, response, reference"))
            }
        };
        let dof = |name: &str, text: &str| {
            text.parse::<Dof>()
                .map_err(|message| Error::bad_word(&message, text).field(name))
        };
        Ok(Self {
            file,
            response: dof("response", response)?,
            reference: dof("reference", reference)?,
        })
    }
}

impl DeclaredDofs {
    /// Reads a file of such rows.
    ///
    /// # Errors
    /// Those of reading, and of [`Self::parse`].
    pub fn read(path: &Path) -> Result<Self> {
        let text = chladni_text::read_text(path, "a list of DOFs")?;
        Self::parse(&text).map_err(|error| error.file(path))
    }

    /// Reads rows `response, reference` or `file, response, reference`, cut at commas,
    /// semicolons, tabs or blanks. A first line of names and lines with `#` are skipped.
    ///
    /// # Errors
    /// [`chladni_frf::ErrorKind::BadData`] with the line of a row that cannot be read.
    pub fn parse(text: &str) -> Result<Self> {
        let mut rows = Vec::new();
        for (number, line) in (1..).zip(text.lines()) {
            let line = line.trim_start_matches('\u{feff}').trim();
            let cells: Vec<&str> = line
                .split(|c: char| c.is_whitespace() || ",;".contains(c))
                .filter(|cell| !cell.is_empty())
                .collect();
            let is_header = rows.is_empty() && cells.contains(&"response");
            if line.is_empty() || line.starts_with('#') || is_header {
                continue;
            }
            let row = DeclaredRow::of_cells(&cells);
            rows.push(row.map_err(|error| error.at_line(number))?);
        }
        if rows.is_empty() {
            return Err(Error::bad_data("the list of DOFs is empty")
                .at_line(1)
                .found("no row")
                .expected("rows response, reference"));
        }
        Ok(Self { rows })
    }

    /// The DOFs of the FRFs of one file, `count` in number: its own rows, else the next
    /// `count` rows without a file, from `at` on.
    pub(super) fn of_file(
        &self,
        file: &str,
        count: usize,
        at: &mut usize,
    ) -> Result<Vec<(Dof, Dof)>> {
        let dofs = |row: &DeclaredRow| (row.response, row.reference);
        let own: Vec<_> = self
            .rows
            .iter()
            .filter(|row| row.file.as_deref() == Some(file))
            .map(dofs)
            .collect();
        let found = if own.is_empty() {
            let unnamed = self.rows.iter().filter(|row| row.file.is_none());
            let next: Vec<_> = unnamed.skip(*at).take(count).map(dofs).collect();
            *at += next.len();
            next
        } else {
            own
        };
        if found.len() == count {
            return Ok(found);
        }
        Err(
            Error::bad_data("the list of DOFs does not fit the FRFs of the file")
                .field("dofs")
                .found(format!("{} rows for {file}", found.len()))
                .expected(format!("{count}, one for each FRF"))
                .help("give one row for each FRF, in the order of the FRFs in the file"),
        )
    }

    /// Refuses rows that belong to no FRF.
    pub(super) fn refuse_rest(&self, files: &[String], at: usize) -> Result<()> {
        let unnamed = self.rows.iter().filter(|row| row.file.is_none()).count();
        let stranger = self
            .rows
            .iter()
            .filter_map(|row| row.file.as_ref())
            .find(|file| !files.contains(file));
        let found = match stranger {
            Some(file) => format!("rows for {file}, which was not given"),
            None if at < unnamed => format!("{unnamed} rows"),
            None => return Ok(()),
        };
        Err(
            Error::bad_data("the list of DOFs has rows that no FRF belongs to")
                .field("dofs")
                .found(found)
                .expected(format!("{at} rows, one for each FRF"))
                .help("leave them out, or give their files"),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_with_and_without_files_and_those_that_are_none() {
        let list = "# hammer\nfile;response;reference\np1.csv;5:+Z;101Z\n\np2.csv\t5Z 102Z\n";
        let list = DeclaredDofs::parse(list).unwrap();
        assert_eq!(list.rows[1].file.as_deref(), Some("p2.csv"));
        assert_eq!(list.rows[1].reference.to_string(), "102:+Z");
        for (text, words) in [
            ("5Z\n", "line 1"),
            ("5Z,6Z\n5,6Z\n", "line 2: response"),
            ("# nothing\n", "empty"),
        ] {
            let error = DeclaredDofs::parse(text).unwrap_err().to_string();
            assert!(error.contains(words), "{error}");
        }
    }
}
