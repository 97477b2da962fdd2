//! Shapes, fields and estimates through the command line.

use crate::common::Folder;

#[test]
fn a_model_becomes_shapes_for_other_programs() {
    let folder = Folder::with_panel();
    let modes = folder.run("info truth.json --json").exits(0).json()["files"][0]["datasets"]
        .as_array()
        .unwrap()
        .clone();
    let in_band: Vec<_> = modes.iter().filter(|mode| mode["name"] == "mode").collect();
    for (extension, number) in [("unv", 2414), ("uff", 55), ("uf", 55)] {
        folder
            .run(&format!("convert truth.json -o shapes.{extension}"))
            .exits(0);
        let listed = folder
            .run(&format!("info --json shapes.{extension}"))
            .exits(0)
            .json();
        let shapes: Vec<_> = listed["files"][0]["datasets"]
            .as_array()
            .unwrap()
            .iter()
            .filter(|d| d["number"] == number)
            .cloned()
            .collect();
        assert_eq!(shapes.len(), in_band.len());
        for (shape, mode) in shapes.iter().zip(&in_band) {
            for key in ["frequency_hz", "damping_ratio"] {
                let (read, truth) = (shape[key].as_f64().unwrap(), mode[key].as_f64().unwrap());
                assert!(
                    (read - truth).abs() <= 1e-5 * truth,
                    "{extension} {key}: {read} for {truth}"
                );
            }
            assert_eq!(shape["nodes"], 24);
        }
    }
    // and on to HDF5 and ParaView, without loss
    folder.run("convert shapes.unv -o shapes.h5").exits(0);
    folder.run("convert shapes.h5 -o back.unv").exits(0);
    assert_eq!(folder.text("shapes.unv"), folder.text("back.unv"));
    folder.run("convert shapes.h5 -o shapes.vtu").exits(0);
    folder.run("convert truth.json -o list.pvd").exits(0);
    let list = folder.text("list.pvd");
    assert_eq!(list.matches("<DataSet ").count(), in_band.len());
    for k in 1..=in_band.len() {
        assert!(list.contains(&format!("file=\"list_{k}.vtu\"")));
        let grid = folder.text(&format!("list_{k}.vtu"));
        assert!(
            grid.contains("NumberOfPoints=\"34\"") && grid.trim_end().ends_with("</VTKFile>"),
            "{grid}"
        );
    }
}

#[test]
fn weights_become_the_field_that_they_make() {
    let folder = Folder::with_panel();
    folder.run("render truth.json scene.toml -o weights.json");
    folder
        .run("convert truth.json weights.json -o field.unv")
        .exits(0);
    let listed = folder.run("info --json field.unv").exits(0).json();
    let shapes: Vec<_> = listed["files"][0]["datasets"]
        .as_array()
        .unwrap()
        .iter()
        .filter(|d| d["number"] == 2414)
        .cloned()
        .collect();
    assert_eq!(
        (shapes.len(), shapes[0]["frequency_hz"].as_f64()),
        (1, Some(300.0))
    );
    // the field is stronger in the hot corner, at nodes 1 and 2
    let text = folder.text("field.unv");
    let body: Vec<&str> = text.split("  2414\n").nth(1).unwrap().lines().collect();
    let start = body.len() - 1 - 2 * 24;
    let speed = |node: usize| -> f64 {
        let values = body[start + 2 * (node - 1) + 1];
        assert_eq!(body[start + 2 * (node - 1)].trim(), node.to_string());
        let z: Vec<f64> = (4..6)
            .map(|k| values[13 * k..13 * (k + 1)].trim().parse().unwrap())
            .collect();
        z[0].hypot(z[1])
    };
    let hot = [1, 2].map(speed).into_iter().fold(f64::INFINITY, f64::min);
    let cold = [17, 18, 23, 24].map(speed).into_iter().fold(0.0, f64::max);
    assert!(hot > cold, "{hot} {cold}");
    // files in the other order
    folder
        .run("convert weights.json truth.json -o field.vtu")
        .exits(0);
    folder
        .run("convert truth.json weights.json -o field.csv")
        .exits(2);
}

/// y = 0.5·x of white noise: H = 0.5 on every line.
fn signal() -> Vec<(f64, f64)> {
    let mut state = 1_u32;
    let mut next = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(state >> 8) / f64::from(1 << 24) - 0.5
    };
    (0..8192).map(|_| next()).map(|x| (x, 0.5 * x)).collect()
}

/// A folder with `time.csv`, the records of [`signal`].
fn with_records() -> Folder {
    let folder = Folder::new();
    let rows: Vec<String> = signal()
        .iter()
        .enumerate()
        .map(|(k, (x, y))| format!("{},{x},{y}", k as f64 / 1024.0))
        .collect();
    folder.write(
        "time.csv",
        format!("t [s],101:+Z [N],1:+Z [m/s]\n{}\n", rows.join("\n")),
    );
    folder
}

#[test]
fn records_of_a_table_are_estimated() {
    let folder = with_records();
    for (estimator, averages) in [("h1", 94), ("h2", 94), ("hv", 94), ("lpm", 1), ("lrm", 1)] {
        let command = format!(
            "estimate time.csv -o frf.csv --estimator {estimator} --block 256 --force --json"
        );
        let result = folder.run(&command).exits(0).json();
        assert_eq!(
            (&result["frf_kind"], &result["lines"]),
            (&"mobility".into(), &127.into())
        );
        // 8192 samples in blocks of 256 that overlap by two thirds, or in one piece
        assert_eq!(result["averages"], serde_json::json!([averages, averages]));
        assert_eq!(result["estimator"], estimator);
        let table = folder.text("frf.csv");
        let mut lines = 0;
        for row in table.lines().filter(|row| row.starts_with("1,3,101,3,")) {
            let numbers: Vec<f64> = row.split(',').map(|cell| cell.parse().unwrap()).collect();
            assert!(
                (numbers[5] - 0.5).abs() < 1e-9 && numbers[6].abs() < 1e-9,
                "{row}"
            );
            assert!(
                (numbers[4] - 4.0 * f64::from(lines + 1)).abs() < 1e-9,
                "{row}"
            );
            assert!((numbers[7] - 1.0).abs() < 1e-6, "coherence: {row}");
            lines += 1;
        }
        assert_eq!(lines, 127);
    }
}

#[test]
fn records_survive_other_formats_and_so_does_what_is_made_of_them() {
    let folder = with_records();
    folder.run("convert time.csv -o time.uff").exits(0);
    folder
        .run("estimate time.uff -o again.csv --block 256")
        .exits(0);
    folder
        .run("estimate time.csv -o frf.csv --block 256")
        .exits(0);
    assert_eq!(folder.text("again.csv"), folder.text("frf.csv"));
}

#[test]
fn continuous_noise_without_a_word_of_windows_takes_the_local_rational_method() {
    let folder = with_records();
    let result = folder
        .run("estimate time.csv -o auto.csv --json")
        .exits(0)
        .json();
    assert_eq!(
        (&result["estimator"], &result["lines_per_value"]),
        (&"lrm".into(), &13.into())
    );
    let result = folder
        .run("estimate time.csv -o auto.csv --window hann --force --json")
        .exits(0)
        .json();
    assert_eq!(result["estimator"], "h1");
    folder
        .run("estimate time.csv -o none.csv --estimator lrm --window hann")
        .exits(2);
    folder
        .run("estimate time.csv -o none.csv --estimator lrm --block 4096")
        .exits(65);
}

#[test]
fn wrong_options_of_an_estimate_are_named_with_advice() {
    let folder = with_records();
    for (options, code, words) in [
        ("--block 0", 2, ["--block: ", "found 0 samples"]),
        ("--block 99999999", 65, ["--block: ", "8192"]),
        ("--overlap 1", 2, ["--overlap: ", "0.95"]),
        (
            "--sample-rate 2048",
            2,
            ["--sample-rate: ", "expected 1024 Hz, as"],
        ),
        (
            "--references 101:+Z,7:+Z",
            2,
            ["--references: ", "found 7:+Z; expected 101:+Z"],
        ),
    ] {
        let line = format!("estimate time.csv -o none.csv {options}");
        let told = folder.run(&line).exits(code).stderr;
        for word in words.into_iter().chain(["help: "]) {
            assert!(told.contains(word), "{options}: no {word} in {told}");
        }
    }
    let twice = folder.run("estimate time.csv time.csv -o twice.csv --json");
    let said = twice.exits(0).json().to_string();
    assert!(
        said.contains("same-records") && said.contains("time.csv of time.csv"),
        "{said}"
    );
}

#[test]
fn a_sound_file_needs_dofs_and_units() {
    let folder = Folder::new();
    let samples = signal();
    let mut wav = b"RIFF\0\0\0\0WAVEfmt ".to_vec();
    let bytes = samples.len() * 8;
    wav[4..8].copy_from_slice(&(36 + bytes as u32).to_le_bytes());
    for word in [16_u32, 0x0002_0003, 1024, 1024 * 8, 0x0020_0008] {
        wav.extend(word.to_le_bytes());
    }
    wav.extend(b"data");
    wav.extend((bytes as u32).to_le_bytes());
    for (x, y) in samples {
        wav.extend((x as f32).to_le_bytes());
        wav.extend((y as f32).to_le_bytes());
    }
    folder.write("take.wav", wav);
    folder.run("estimate take.wav -o frf.h5").exits(65);
    let unscaled = "estimate take.wav -o part.csv --dofs 101:+Z,1:+Z --units V,mm/s";
    let told = folder.run(unscaled).exits(0).said();
    assert!(told.contains("parts of full scale"), "{told}");
    let line = "estimate take.wav -o frf.csv --dofs 101:+Z,1:+Z --units V,mm/s --scales 10,20 \
                --block 256 --json";
    let run = folder.run(line).exits(0);
    assert!(!run.stderr.contains("full scale"), "{}", run.stderr);
    let result = run.json();
    assert_eq!(result["frf_kind"], "mobility");
    let table = folder.text("frf.csv");
    assert!(table.contains("# reference_unit = V"), "{}", &table[..200]);
    let row = table
        .lines()
        .find(|row| row.starts_with("1,3,101,3,"))
        .unwrap();
    let numbers: Vec<f64> = row.split(',').map(|cell| cell.parse().unwrap()).collect();
    // 0.5 · 20 mm/s over 10 V
    assert!(
        (numbers[5] - 1e-3).abs() < 1e-9 && numbers[6].abs() < 1e-9,
        "{row}"
    );
}
