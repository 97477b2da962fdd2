//! Simulates the glass panel, identifies it, renders four scenes and writes the report
//! and all charts into a folder, to look at them: `cargo run --release -p chladni-report
//! --example panel_report -- FOLDER`

use chladni_plate::{simulate, Panel};
use chladni_render::{render, stress, sweep, Scene};
use chladni_report::{charts, data, html, ChartFormats, RenderedScene, ReportInput};
use std::path::{Path, PathBuf};
use std::time::Instant;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = PathBuf::from(std::env::args().nth(1).ok_or("name a folder")?);
    std::fs::create_dir_all(&folder)?;
    let panel = Panel::from_toml("[plate]\n", 4 << 30)?;
    let simulation = simulate(&panel, None, None)?;
    let model = chladni_rfp::fit(&simulation.frf, &Default::default())?.model;
    let scene = |cell: usize| {
        format!(
            "frequency_hz = 300.0\n[zones]\ngrid = [2, 2]\nhot = [{cell}]\ncells_m = [0.0, \
                 0.0, 0.268, 0.170]\n"
        )
    };
    let mut renderings = Vec::new();
    for cell in 1..=4 {
        let scene = Scene::parse(&scene(cell), Path::new(""))?;
        let mut rendering = render(&model, &scene, &Default::default())?;
        if cell == 1 {
            rendering.weights.stress =
                Some(stress(&rendering.weights, &scene, &model, &Default::default())?.0);
            rendering.weights.sweep =
                Some(sweep(&model, &scene, &Default::default(), [290.0, 310.0])?);
        }
        renderings.push(rendering);
    }
    let input = ReportInput {
        title: "Glass panel, 77 × 34 FRFs".into(),
        model: Some(&model),
        measured: Some(&simulation.frf),
        scenes: renderings.iter().map(RenderedScene::of_rendering).collect(),
        ..ReportInput::default()
    };
    let start = Instant::now();
    let page = html(&input)?;
    println!(
        "report.html: {} kB in {:.1} s",
        page.len() / 1000,
        start.elapsed().as_secs_f64()
    );
    std::fs::write(folder.join("report.html"), page)?;
    std::fs::write(folder.join("data.json"), data(&input)?.to_string())?;
    let alone = ReportInput {
        measured: None,
        ..input.clone()
    };
    std::fs::write(folder.join("report-without-frfs.html"), html(&alone)?)?;
    let start = Instant::now();
    for (name, bytes) in charts(
        &input,
        ChartFormats {
            svg: true,
            png: true,
            gif: true,
        },
    )? {
        std::fs::write(folder.join(name), bytes)?;
    }
    println!("charts in {:.1} s", start.elapsed().as_secs_f64());
    Ok(())
}
