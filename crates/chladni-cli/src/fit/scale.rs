//! `chladni fit --scale`: mass-scaled shapes from driving points or from the panel itself
//! (continuity of shapes, or their modal mass).

use chladni_console::input::source;
use chladni_frf::{Error, ErrorKind, Finding, ModalModel, Result, Scaling, Source};
use chladni_plate::{scale_by_panel, Panel, ScaleRoute};
use clap::ValueEnum;
use serde_json::json;
use std::path::PathBuf;

/// Arguments that say where the scale of shapes comes from.
#[derive(Debug, clap::Args)]
#[group(id = "scale_arguments")]
pub struct Args {
    /// Scale of the shapes: unit modal mass by driving points, or by the geometry of a panel
    /// (they go on smoothly from responses to references, or have the modal mass 1); auto:
    /// driving points, else continuity where a panel is given
    #[arg(long, value_name = "SCALE", value_enum, default_value_t = Choice::Auto)]
    scale: Choice,
    /// Panel that was measured, for the scale of the shapes: plate, edges, coils
    #[arg(long, value_name = "PANEL.toml")]
    panel: Option<PathBuf>,
}

/// A way to the scale of shapes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Choice {
    Auto,
    Driving,
    Continuity,
    Mass,
}

impl Choice {
    fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::Driving => "driving",
            Self::Continuity => ScaleRoute::Continuity.name(),
            Self::Mass => ScaleRoute::Mass.name(),
        }
    }
}

/// A panel and its file.
pub struct GivenPanel {
    panel: Panel,
    source: Source,
}

impl Args {
    /// Reads the panel.
    ///
    /// # Errors
    /// Those of the panel; a scale that needs a panel without one, and the reverse.
    pub fn panel(&self, memory: u64) -> Result<Option<GivenPanel>> {
        let needs = matches!(self.scale, Choice::Continuity | Choice::Mass);
        match &self.panel {
            Some(_) if self.scale == Choice::Driving => {
                Err(Error::new(ErrorKind::Usage, "driving points need no panel")
                    .field("--panel")
                    .found("--scale driving")
                    .expected("--scale auto, continuity or mass")
                    .help("leave one of them out"))
            }
            Some(file) => Ok(Some(GivenPanel {
                panel: Panel::read(file, memory)?,
                source: source(file)?,
            })),
            None if needs => Err(Error::new(ErrorKind::Usage, "no panel to scale shapes by")
                .field("--scale")
                .found(self.scale.name())
                .expected("--panel PANEL.toml beside it")
                .help("write the panel as for `chladni simulate`")),
            None => Ok(None),
        }
    }

    /// The model with its shapes scaled as `--scale` asks.
    ///
    /// # Errors
    /// A scale that was asked for and cannot be found.
    pub fn scaled(&self, model: ModalModel, panel: Option<&GivenPanel>) -> Result<ModalModel> {
        let is_scaled = model.scaling == Scaling::UnitModalMass;
        let route = match (self.scale, panel) {
            (Choice::Driving, _) if !is_scaled => {
                return Err(Error::bad_data("no driving point tells the scale")
                    .field("--scale")
                    .found("no response that is a reference as well")
                    .expected("a driving point, its references in N")
                    .help("measure one, or give --panel in place of --scale driving"))
            }
            (Choice::Continuity, Some(panel)) => (panel, ScaleRoute::Continuity),
            (Choice::Mass, Some(panel)) => (panel, ScaleRoute::Mass),
            (Choice::Auto, Some(panel)) if !is_scaled => (panel, ScaleRoute::Continuity),
            _ => return Ok(model),
        };
        let (GivenPanel { panel, source }, route) = route;
        let mut model = match scale_by_panel(&model, panel, route) {
            Ok(scaled) => scaled.model,
            Err(error) if self.scale == Choice::Auto => {
                let mut model = model;
                model.quality.findings.push(refused(error));
                model
            }
            Err(error) => return Err(error),
        };
        model.source.push(source.clone());
        model
            .options
            .insert("scale".into(), json!(self.scale.name()));
        Ok(model)
    }
}

/// The caution that the panel gives no scale, with the reason.
fn refused(error: Error) -> Finding {
    let found = error
        .found
        .map_or(String::new(), |found| format!(": {found}"));
    let words = format!("the shapes keep no scale, {}{found}", error.message);
    Finding::caution("scale-refused", words).help(error.help.unwrap_or_default())
}
