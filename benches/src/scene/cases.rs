//! Named scenes on virtual panels.

use crate::scene::true_panel::TruePanel;
use chladni_frf::{Direction, Dof, FrfSet, FrfValues, ModalModel, Node, Result};
use chladni_plate::{add_white_noise, simulate, Panel};
use chladni_render::Scene;
use std::path::Path;

/// A panel that scenes are rendered on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ScenePanel {
    /// The glass panel of the examples: 77 responses over a window, 34 actuators.
    Glass,
    /// Another size, material, loss factor and seed: 1 mm aluminium, 84 responses, 38
    /// actuators. Nothing was tuned on it.
    Aluminium,
    /// The glass panel with 80 more responses outside the window, on two rings.
    Rim,
    /// The glass panel with driving points, so that the model can be mass-scaled.
    DrivingPoints,
    /// The glass panel, measured so far up that a fit finds 34 modes, as many as there
    /// are actuators.
    ManyModes,
}

/// A scene on a panel: cells of the whole panel are hot.
#[derive(Debug, Clone, Copy)]
pub struct SceneCase {
    /// Name on the command line and in tables.
    pub name: &'static str,
    /// The panel.
    pub panel: ScenePanel,
    /// Columns, rows of cells over the whole panel.
    pub grid: [usize; 2],
    /// The hot cell.
    pub hot: usize,
    /// Drive frequency, Hz.
    pub frequency_hz: f64,
    /// Width of the transition, m.
    pub transition_m: f64,
    /// Also run with `--quick`.
    pub quick: bool,
}

const fn case(
    name: &'static str,
    panel: ScenePanel,
    grid: [usize; 2],
    hot: usize,
    frequency_hz: f64,
    quick: bool,
) -> SceneCase {
    SceneCase {
        name,
        panel,
        grid,
        hot,
        frequency_hz,
        transition_m: 0.010,
        quick,
    }
}

/// All named scenes.
pub const SCENE_CASES: [SceneCase; 33] = [
    case("quarter-1", ScenePanel::Glass, [2, 2], 1, 300.0, true),
    case("quarter-2", ScenePanel::Glass, [2, 2], 2, 300.0, false),
    case("quarter-3", ScenePanel::Glass, [2, 2], 3, 300.0, false),
    case("quarter-4", ScenePanel::Glass, [2, 2], 4, 300.0, false),
    case(
        "quarter-1-335-hz",
        ScenePanel::Glass,
        [2, 2],
        1,
        335.0,
        true,
    ),
    case("ninth-1", ScenePanel::Glass, [3, 3], 1, 300.0, true),
    case("ninth-2", ScenePanel::Glass, [3, 3], 2, 300.0, false),
    case("ninth-3", ScenePanel::Glass, [3, 3], 3, 300.0, false),
    case("ninth-4", ScenePanel::Glass, [3, 3], 4, 300.0, false),
    case("ninth-5", ScenePanel::Glass, [3, 3], 5, 300.0, true),
    case("ninth-6", ScenePanel::Glass, [3, 3], 6, 300.0, false),
    case("ninth-7", ScenePanel::Glass, [3, 3], 7, 300.0, false),
    case("ninth-8", ScenePanel::Glass, [3, 3], 8, 300.0, false),
    case("ninth-9", ScenePanel::Glass, [3, 3], 9, 300.0, false),
    case(
        "aluminium-quarter-1",
        ScenePanel::Aluminium,
        [2, 2],
        1,
        300.0,
        true,
    ),
    case(
        "aluminium-quarter-2",
        ScenePanel::Aluminium,
        [2, 2],
        2,
        300.0,
        false,
    ),
    case(
        "aluminium-quarter-3",
        ScenePanel::Aluminium,
        [2, 2],
        3,
        300.0,
        false,
    ),
    case(
        "aluminium-quarter-4",
        ScenePanel::Aluminium,
        [2, 2],
        4,
        300.0,
        false,
    ),
    case(
        "aluminium-ninth-1",
        ScenePanel::Aluminium,
        [3, 3],
        1,
        300.0,
        false,
    ),
    case(
        "aluminium-ninth-2",
        ScenePanel::Aluminium,
        [3, 3],
        2,
        300.0,
        false,
    ),
    case(
        "aluminium-ninth-3",
        ScenePanel::Aluminium,
        [3, 3],
        3,
        300.0,
        false,
    ),
    case(
        "aluminium-ninth-4",
        ScenePanel::Aluminium,
        [3, 3],
        4,
        300.0,
        false,
    ),
    case(
        "aluminium-ninth-5",
        ScenePanel::Aluminium,
        [3, 3],
        5,
        300.0,
        false,
    ),
    case(
        "aluminium-ninth-6",
        ScenePanel::Aluminium,
        [3, 3],
        6,
        300.0,
        false,
    ),
    case(
        "aluminium-ninth-7",
        ScenePanel::Aluminium,
        [3, 3],
        7,
        300.0,
        false,
    ),
    case(
        "aluminium-ninth-8",
        ScenePanel::Aluminium,
        [3, 3],
        8,
        300.0,
        false,
    ),
    case(
        "aluminium-ninth-9",
        ScenePanel::Aluminium,
        [3, 3],
        9,
        300.0,
        false,
    ),
    case("rim-quarter-1", ScenePanel::Rim, [2, 2], 1, 300.0, false),
    case("rim-quarter-2", ScenePanel::Rim, [2, 2], 2, 300.0, false),
    case(
        "touch-quarter-1",
        ScenePanel::DrivingPoints,
        [2, 2],
        1,
        300.0,
        false,
    ),
    case(
        "touch-quarter-1-330-hz",
        ScenePanel::DrivingPoints,
        [2, 2],
        1,
        330.0,
        false,
    ),
    case(
        "touch-quarter-1-340-hz",
        ScenePanel::DrivingPoints,
        [2, 2],
        1,
        340.0,
        false,
    ),
    SceneCase {
        transition_m: 0.020,
        ..case("ninth-5-20-mm", ScenePanel::Glass, [3, 3], 5, 300.0, false)
    },
];

/// A measured panel and its truth.
pub(crate) struct MeasuredPanel {
    pub(crate) frf: FrfSet,
    pub(crate) truth: TruePanel,
    /// Its exact modes.
    pub(crate) exact: ModalModel,
    sides_m: [f64; 2],
    area_m: [f64; 4],
}

impl ScenePanel {
    pub(crate) fn panel(self) -> Panel {
        let mut panel = Panel::default();
        match self {
            Self::Glass | Self::Rim => {}
            Self::DrivingPoints => panel.responses.at_references = true,
            // between the elastic modes 34 and 35, at 1297.5 and 1306.8 Hz
            Self::ManyModes => panel.frf.stop_hz = 1302.0,
            Self::Aluminium => {
                (
                    panel.plate.length_m,
                    panel.plate.width_m,
                    panel.plate.thickness_m,
                ) = (0.300, 0.200, 0.001);
                (
                    panel.plate.youngs_modulus_pa,
                    panel.plate.poisson_ratio,
                    panel.plate.density_kg_per_m3,
                ) = (70.0e9, 0.33, 2700.0);
                panel.plate.loss_factor = chladni_plate::LossFactor::Common(0.008);
                (panel.responses.grid, panel.responses.spacing_m) = ([12, 7], 0.022);
                (panel.references.edge_count, panel.references.spacing_m) = ([12, 7], 0.022);
                panel.frf.seed = 7;
            }
        }
        panel
    }

    /// Simulates its measurement.
    pub(crate) fn measure(self) -> Result<MeasuredPanel> {
        let panel = self.panel();
        let mut simulation = simulate(&panel, None, None)?;
        let sides_m = [panel.plate.length_m, panel.plate.width_m];
        let window = panel.layout().responses_m
            [..panel.responses.grid[0] * panel.responses.grid[1]]
            .to_vec();
        let [first, last] = [window[0], window[window.len() - 1]];
        let mut area_m = [first[0], first[1], last[0], last[1]];
        if self == Self::Rim {
            area_m = [0.0, 0.0, sides_m[0], sides_m[1]];
            add_rim(&panel, &mut simulation.frf, &simulation.plate, sides_m)?;
        }
        let truth = TruePanel::new(&panel, simulation.plate, area_m)?;
        Ok(MeasuredPanel {
            truth,
            exact: simulation.truth,
            frf: simulation.frf,
            sides_m,
            area_m,
        })
    }
}

/// Measures 80 more places: 44 at the very edge, 36 half way to the window.
fn add_rim(
    panel: &Panel,
    frf: &mut FrfSet,
    plate: &chladni_plate::DampedPlate,
    sides_m: [f64; 2],
) -> Result<()> {
    let mut places = panel.layout().responses_m;
    let before = places.len();
    for (inset, count) in [(0.0, 44), (0.015, 36)] {
        places.extend(ring(sides_m, inset, count));
    }
    let mut values = plate.frfs(
        panel.frf.kind,
        &places,
        &panel.layout().references_m,
        &frf.frequency_hz,
    )?;
    add_white_noise(&mut values, panel.frf.snr_db, panel.frf.seed)?;
    frf.values = FrfValues::F64(values);
    for (k, &[x, y]) in places.iter().enumerate().skip(before) {
        let label = 1001 + k as u64;
        frf.responses.push(Dof::new(label, Direction::PLUS_Z));
        frf.geometry.nodes.push(Node {
            label,
            xyz_m: [x, y, 0.0],
        });
    }
    Ok(())
}

/// `count` places evenly spread along a rectangle `inset` inside the edges.
fn ring([length, width]: [f64; 2], inset: f64, count: usize) -> impl Iterator<Item = [f64; 2]> {
    let (a, b) = (length - 2.0 * inset, width - 2.0 * inset);
    (0..count).map(move |k| {
        let s = 2.0 * (a + b) * k as f64 / count as f64;
        let [x, y] = match s {
            s if s < a => [s, 0.0],
            s if s < a + b => [a, s - a],
            s if s < 2.0 * a + b => [2.0 * a + b - s, b],
            s => [0.0, 2.0 * (a + b) - s],
        };
        [x + inset, y + inset]
    })
}

impl SceneCase {
    /// The case of that name.
    pub fn named(name: &str) -> Option<&'static Self> {
        SCENE_CASES.iter().find(|case| case.name == name)
    }

    /// The scene on its measured panel.
    pub(crate) fn scene(&self, panel: &MeasuredPanel) -> Result<Scene> {
        panel.scene(self.grid, self.hot, self.frequency_hz, self.transition_m)
    }
}

impl MeasuredPanel {
    /// One cell of a grid over the whole panel is hot.
    pub(crate) fn scene(
        &self,
        grid: [usize; 2],
        hot: usize,
        frequency_hz: f64,
        transition_m: f64,
    ) -> Result<Scene> {
        self.scene_with(grid, hot, frequency_hz, transition_m, "")
    }

    /// The same with more tables.
    pub(crate) fn scene_with(
        &self,
        grid: [usize; 2],
        hot: usize,
        frequency_hz: f64,
        transition_m: f64,
        tables: &str,
    ) -> Result<Scene> {
        let [length_m, width_m] = self.sides_m;
        let text = format!(
            "frequency_hz = {frequency_hz:?}\n[zones]\ngrid = {grid:?}\nhot = [{hot}]\narea_m = {:?}\ncells_m = [0.0, 0.0, {length_m:?}, \
             {width_m:?}]\ntransition_m = {transition_m:?}\n{tables}",
            self.area_m
        );
        Scene::parse(&text, Path::new(""))
    }
}
