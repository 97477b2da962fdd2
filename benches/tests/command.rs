//! The program `chladni-bench`: tables and charts of the named cases.

mod common;

use chladni_io::{read_frf, write_frf, ReadOptions};
use chladni_plate::{simulate, Panel};
use chladni_rfp::FitOptions;
use common::Folder;
use std::sync::OnceLock;

#[test]
fn accuracy_writes_a_table_and_a_chart_for_each_case() {
    let folder = Folder::new();
    let line = "accuracy -o out --case few-lines --method auto --seeds 2";
    let json = folder.run(&format!("{line} --json")).exits(0).json();
    assert_eq!(
        (json["seeds"].as_u64(), json["rows"].as_u64()),
        (Some(2), Some(1))
    );
    for name in [
        "accuracy.csv",
        "accuracy-few-lines.svg",
        "accuracy-few-lines.png",
    ] {
        assert!(folder.path().join("out").join(name).is_file(), "{name}");
    }
    let csv = folder.text("out/accuracy.csv");
    let header = csv.lines().find(|line| !line.starts_with('#')).unwrap();
    assert!(
        header.starts_with("case,method,time_s,frequency_rmse_over_crlb,"),
        "{header}"
    );

    let again = folder.run(line).exits(73);
    assert!(again.stderr.contains("--force"), "{}", again.stderr);
    folder.run(&format!("{line} --force -q")).exits(0);
}

#[test]
fn data_of_ones_own_tell_what_cheaper_settings_lose() {
    let folder = Folder::new();
    folder
        .run("accuracy -o out --case easy --method lean --seeds 1 --export -q")
        .exits(0);
    let line =
        "accuracy -o own --input out/frf-easy-0.h5 --method auto --method lean --method peak";
    let json = folder.run(&format!("{line} --json")).exits(0).json();
    assert_eq!(json["modes"], 8);
    let csv = folder.text("own/accuracy-input.csv");
    let row = |name: &str| -> Vec<String> {
        let line = csv.lines().find(|line| line.starts_with(name));
        let cells = line
            .unwrap_or_else(|| panic!("no {name}: {csv}"))
            .split(',');
        cells.map(str::to_owned).collect()
    };
    let number = |name: &str, cell: usize| row(name)[cell].parse::<f64>().unwrap();
    assert_eq!(
        row("auto,")[3..7],
        ["0", "0", "0", "0"],
        "the default beside itself"
    );
    assert_eq!(number("auto,", 9), 1.0);
    let [lean, peak] = ["lean,", "peak,"].map(|name| number(name, 9));
    assert!(
        lean < 2.0 && peak > 5.0,
        "lean at the bound {lean}, peaks far from it {peak}"
    );
    assert!(row("\"auto, pool steps 2\"").len() > 9, "knobs were turned");
    for name in [
        "accuracy-input.svg",
        "accuracy-input-knobs.png",
        "accuracy-input.html",
    ] {
        assert!(folder.path().join("own").join(name).is_file(), "{name}");
    }
    let run = folder
        .run("accuracy -o other --input out/frf-easy-0.h5 --method mls")
        .exits(2);
    assert!(run.stderr.contains("scene"), "{}", run.stderr);
}

/// A table that the program wrote: its text, and cells by row and column.
struct Table {
    text: String,
    header: Vec<String>,
    rows: Vec<Vec<String>>,
}

impl Table {
    fn of(text: String) -> Self {
        let mut lines = text
            .lines()
            .filter(|line| !line.starts_with('#'))
            .map(|line| line.split(',').map(str::to_owned).collect::<Vec<_>>());
        let header = lines.next().unwrap();
        let rows = lines.collect();
        Self { text, header, rows }
    }

    fn cell<'a>(&self, row: &'a [String], name: &str) -> &'a str {
        &row[self.header.iter().position(|cell| cell == name).unwrap()]
    }

    fn value(&self, row: &[String], name: &str) -> f64 {
        self.cell(row, name).parse().unwrap()
    }
}

#[test]
fn an_unknown_case_is_answered_with_the_known_ones() {
    let run = Folder::new().run("accuracy -o out --case hard").exits(2);
    assert!(
        run.stderr.contains("overlap-3") && run.stderr.contains("hard"),
        "{}",
        run.stderr
    );
    let run = Folder::new().run("profile -o nowhere/out").exits(73);
    assert!(run.stderr.contains("folder"), "{}", run.stderr);
}

#[test]
fn scenes_are_judged_on_the_true_plate() {
    let folder = Folder::new();
    let line = "scene -o out --case quarter-1-335-hz --method robust --method modal \
                --actuators 7,all --json";
    assert_eq!(folder.run(line).exits(0).json()["rows"], 4);
    let table = Table::of(folder.text("out/scene.csv"));
    assert_eq!(table.header[..4], ["scene", "method", "modes", "actuators"]);
    let csv = &table.text;
    let cell = |row: usize, column: usize| table.rows[row][column].as_str();
    let value = |row: usize, name: &str| table.value(&table.rows[row], name);
    // seven actuators, all of them; then the two-step inverse
    assert_eq!((cell(0, 3), cell(1, 3), cell(2, 1)), ("7", "34", "modal"));
    assert!(
        value(1, "points_success") >= 0.99
            && value(1, "window_hot") >= 0.97
            && value(1, "window_cold") >= 0.97,
        "{csv}"
    );
    assert!(
        value(1, "drift_least") >= 0.97
            && value(1, "max_force_n") <= 2e-3
            && value(1, "touched_least") >= 0.90,
        "{csv}"
    );
    assert!(value(3, "window_total") < 0.9, "{csv}");
    assert!(folder
        .run("scene -o out --case nowhere")
        .exits(2)
        .stderr
        .contains("quarter-1"));
}

/// The files and the answer of the seed paper's reproduction.
struct Paper {
    json: serde_json::Value,
    /// Names of the files in its folder.
    names: Vec<String>,
    page: String,
    table: Table,
}

/// The reproduction, made once for all tests.
fn paper() -> &'static Paper {
    static PAPER: OnceLock<Paper> = OnceLock::new();
    PAPER.get_or_init(|| {
        let folder = Folder::new();
        let json = folder.run("scene --paper -o out --json").exits(0).json();
        let files = std::fs::read_dir(folder.path().join("out")).unwrap();
        let names = files.map(|file| file.unwrap().file_name().into_string().unwrap());
        Paper {
            json,
            names: names.collect(),
            page: folder.text("out/paper.html"),
            table: Table::of(folder.text("out/paper.csv")),
        }
    })
}

#[test]
fn the_paper_is_reproduced_by_one_command() {
    let paper = paper();
    let files = paper.json["files"].as_array().unwrap();
    let figures = [
        "coefficients",
        "weightings",
        "levels",
        "field",
        "field-default",
        "modes",
        "places",
    ];
    for name in figures
        .iter()
        .flat_map(|name| ["svg", "png"].map(|end| format!("paper-{name}.{end}")))
    {
        assert!(
            files
                .iter()
                .any(|file| file.as_str().unwrap().ends_with(&name)),
            "{name} of {files:?}"
        );
        assert!(paper.names.contains(&name), "{name}");
    }
    assert!(paper.page.contains("paper-coefficients"));
    assert_eq!(paper.json["rows"], paper.table.rows.len());
}

#[test]
fn the_default_method_serves_every_response_at_every_place_of_the_paper() {
    let table = &paper().table;
    let ours = || {
        let rows = table.rows.iter();
        rows.filter(|row| table.cell(row, "method") == "robust")
    };
    assert_eq!(ours().count(), 14);
    assert!(
        ours().all(|row| table.value(row, "points_success") >= 0.99
            && table.value(row, "max_force_n") < 0.01),
        "{}",
        table.text
    );
}

/// The rank of 34 modes at 34 actuators that symmetry leaves; on the exact panel the same
/// in every quarter.
#[test]
fn the_two_steps_of_the_paper_lack_three_ranks_in_every_quarter() {
    let table = &paper().table;
    let is_paper = |row: &[String]| {
        let scene = table.cell(row, "scene");
        table.cell(row, "modes_of") == "exact"
            && table.cell(row, "modes") == "34"
            && table.cell(row, "cut").is_empty()
            && scene.starts_with("quarter")
            && scene.len() == 9
    };
    let rows: Vec<&Vec<String>> = table.rows.iter().filter(|row| is_paper(row)).collect();
    assert_eq!(rows.len(), 4);
    for row in &rows {
        assert_eq!(
            (
                table.cell(row, "psi_rank"),
                table.cell(row, "psi_condition")
            ),
            ("31", "")
        );
        for name in [
            "points_hot",
            "points_cold",
            "points_success",
            "window_total",
        ] {
            assert!(
                (table.value(row, name) - table.value(rows[0], name)).abs() < 1e-9,
                "{name}: {row:?}"
            );
        }
    }
}

#[test]
fn no_number_of_modes_makes_the_two_steps_of_a_quarter_worth_more_than_silence() {
    let table = &paper().table;
    let csv = &table.text;
    let modal = || {
        table.rows.iter().filter(|row| {
            table.cell(row, "scene") == "quarter-1" && table.cell(row, "method") == "modal"
        })
    };
    let quarters = || modal().filter(|row| table.cell(row, "cut").is_empty());
    assert!(quarters().count() > 68);
    // 53 of 68 judged responses
    assert!(
        quarters().all(|row| (table.value(row, "points_silence") - 53.0 / 68.0).abs() < 1e-4),
        "{csv}"
    );
    assert!(
        quarters()
            .all(|row| table.value(row, "points_success") < table.value(row, "points_silence")),
        "{csv}"
    );
    // as one, without small singular values, 16 exact modes and more do
    let cut = modal().filter(|row| {
        table.cell(row, "modes_of") == "exact"
            && table.value(row, "modes") >= 16.0
            && table.cell(row, "cut") == "0.0030000"
    });
    assert!(
        cut.clone().count() == 23
            && cut
                .clone()
                .all(|row| table.value(row, "points_success") > 0.8),
        "{csv}"
    );
    // and it is the modes that no equation has which spoil it: without them 28 modes
    // serve everything
    let alone = quarters()
        .find(|row| table.cell(row, "modes_of") == "exact" && table.cell(row, "modes") == "28")
        .unwrap();
    assert_eq!(
        (
            table.value(alone, "alone_hot"),
            table.value(alone, "alone_cold")
        ),
        (1.0, 1.0)
    );
}

#[test]
fn the_paper_has_its_own_cases() {
    let run = Folder::new().run("scene --paper -o out --case quarter-1");
    assert!(run.exits(2).stderr.contains("--case"));
}

#[test]
fn stability_writes_cells_failures_calibration_and_a_page() {
    let folder = Folder::new();
    let line = "stability -o out --case spacing-references --method peak --seeds 1 --quick \
                --export-silent --json";
    let json = folder.run(line).exits(0).json();
    assert_eq!(json["rows"], 9);
    assert!(folder
        .text("out/stability.csv")
        .contains("case,method,spacing_bandwidths,references,found,missed,spurious,announced,"));
    assert!(folder
        .text("out/stability-calibration.csv")
        .contains("wrong_silent"));
    assert!(folder
        .text("out/stability.html")
        .contains("stability-spacing-references-peak"));
    assert!(!folder.path().join("out/stability.journal").exists());
    // peaks closer than their width are one peak: what went wrong in silence can be
    // fitted again
    let silent = json["files"]
        .as_array()
        .unwrap()
        .iter()
        .filter(|file| file.as_str().unwrap().ends_with(".h5"))
        .count();
    assert!(silent > 0 && silent <= 20, "{json}");
    let run = folder.run("stability -o out --case nowhere").exits(2);
    assert!(run.stderr.contains("snr-overlap"), "{}", run.stderr);
}

#[test]
fn solvers_and_profile_write_their_tables() {
    let folder = Folder::new();
    folder.run("solvers -o out --quick").exits(0);
    let csv = folder.text("out/solvers.csv");
    assert!(
        csv.contains("kernel,backend,size,time_s,") && csv.contains("\nsvd,"),
        "{csv}"
    );
    assert!(folder.path().join("out/solvers.svg").is_file());

    let mut panel = Panel::default();
    (panel.frf.stop_hz, panel.frf.step_hz) = (150.0, 0.5);
    let frf = simulate(&panel, None, None).unwrap().frf;
    write_frf(&folder.path().join("panel.h5"), &frf, false).unwrap();
    folder.run("profile -o out --input panel.h5").exits(0);
    let csv = folder.text("out/profile.csv");
    assert!(
        csv.lines()
            .any(|line| line.starts_with("fit,") && line.contains(",panel.h5,auto,")),
        "{csv}"
    );
    assert!(folder
        .run("profile -o out --input nowhere.h5 --force")
        .exits(66)
        .stderr
        .contains("nowhere.h5"));
}

#[test]
fn wild_has_a_row_for_each_structure_and_exports_one_that_can_be_fitted() {
    let folder = Folder::new();
    let line = "wild -o out --quick --seed 3 --seeds 3 --export --json";
    let json = folder.run(line).exits(0).json();
    assert_eq!(json["seeds"], 3);
    let internal = &json["criteria"][0];
    assert_eq!(
        (internal["name"].as_str(), internal["count"].as_u64()),
        (Some("internal errors"), Some(0))
    );
    let csv = folder.text("out/wild.csv");
    let mut lines = csv.lines().filter(|line| !line.starts_with('#'));
    assert_eq!(
        lines.next().unwrap(),
        "seed,law,kind,modes,references,responses,snr_db,complexity,found,spurious,spurious_sure,\
         announced,damping,undecidable,chi2_per_dof,frequency_within_95,time_s"
    );
    let rows: Vec<Vec<&str>> = lines.map(|line| line.split(',').collect()).collect();
    assert_eq!(rows.len(), 3);
    let seed = rows[0][0];
    let files = [folder.path().join(format!("out/wild-{seed}.h5"))];
    let (frf, ..) = read_frf(&files, &ReadOptions::default()).unwrap();
    let fit = chladni_rfp::fit(&frf, &FitOptions::default()).unwrap();
    assert!(fit.model.modes.len() < 200);
    let truth = folder.text(&format!("out/wild-{seed}.json"));
    assert!(
        truth.contains(rows[0][1]),
        "the law of the row is that of the truth"
    );
}
