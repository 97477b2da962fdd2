//! Layouts that an earlier version misread: they are read correctly, or refused by name.

use crate::common::Folder;

/// `chladni convert` of a table to our own; its rows.
fn converted(folder: &Folder, text: &str, options: &str) -> (i32, String, String) {
    folder.write("table.csv", text);
    let run = folder.run(&format!("convert table.csv -o out.csv --force {options}"));
    let rows = if run.code == 0 {
        let written = folder.text("out.csv");
        written
            .lines()
            .filter(|line| !line.starts_with('#'))
            .collect::<Vec<_>>()
            .join("\n")
    } else {
        String::new()
    };
    (run.code, rows, run.stderr)
}

#[test]
fn the_header_above_a_row_without_numbers_is_kept() {
    let folder = Folder::new();
    for gap in ["NaN", "NA", ""] {
        let text =
            format!("f [Hz],7:-X/9:+Z re [mm/s/N],7:-X/9:+Z im\n0,{gap},{gap}\n1,2,3\n2,4,5\n");
        let (code, rows, said) = converted(&folder, &text, "");
        assert_eq!(code, 0, "{said}");
        assert!(rows.contains("\n7,-1,9,3,1.0,0.002,0.003"), "{rows}");
        assert!(!said.contains("no unit"), "{said}");
    }
}

#[test]
fn decimal_commas_decibels_and_radians_end_with_exit_65() {
    let folder = Folder::new();
    for (text, words) in [
        (
            "node,dir,ref_node,ref_dir,f,re,im\n1,3,101,3,10,5,0,0012,-0,0003\n1,3,101,3,11,5,0,0013,-0,0004\n",
            "decimal comma",
        ),
        ("f,mag_db,phase\n1,-20,90\n2,-30,-90\n", "dB without its reference"),
        ("f,mag,phase\n1,2,1.5\n2,3,-1.5\n", "--phase-unit"),
    ] {
        let (code, _, said) = converted(&folder, text, "");
        assert_eq!(code, 65, "{said}");
        assert!(said.contains(words), "{said}");
    }
    let text = "f,mag,phase\n1,2,0\n2,3,3.141592653589793\n";
    let (code, rows, said) = converted(&folder, text, "--phase-unit rad");
    assert_eq!(code, 0, "{said}");
    assert!(rows.contains("1,3,1,0,2.0,-3.0,"), "{rows}");
    let (code, rows, _) = converted(
        &folder,
        "f,mag,phase_rad\n1,2,0\n2,3,3.141592653589793\n",
        "",
    );
    assert_eq!(code, 0);
    assert!(rows.contains("2.0,-3.0,"), "{rows}");
}

#[test]
fn rows_that_are_comments_are_no_data() {
    let folder = Folder::new();
    for sign in ["#", "%", "//"] {
        let text = format!("f,re,im\n1,2,3\n{sign}1.5,9,9\n2,4,5\n");
        let (code, rows, said) = converted(&folder, &text, "");
        assert_eq!(code, 0, "{said}");
        assert!(!rows.contains("9.0"), "{rows}");
    }
}

#[test]
fn our_own_archives_read_back() {
    let folder = Folder::new();
    folder.write(
        "one.csv",
        "# unit = m/s/N\nresponse,reference,f,re,im\n1Z,9Z,5,1.5,2.5\n2Z,9Z,5,3.5,4.5\n",
    );
    folder.run("convert one.csv -o one.npz").exits(0);
    folder.run("convert one.npz -o back.csv").exits(0);
    assert!(folder.text("back.csv").contains("\n2,3,9,3,5.0,3.5,4.5\n"));
}

#[test]
fn a_model_is_written_for_other_programs() {
    let folder = Folder::with_panel();
    folder.run("convert truth.json -o modes.csv").exits(0);
    folder.run("convert truth.json -o model.mat").exits(0);
    let table = folder.text("modes.csv");
    let rows: Vec<&str> = table
        .lines()
        .filter(|line| !line.starts_with('#'))
        .collect();
    assert!(rows[0].starts_with("mode,frequency_hz,"), "{}", rows[0]);
    assert!(
        rows[0].contains(",shape 1:+Z re,shape 1:+Z im,"),
        "{}",
        rows[0]
    );
    let model: serde_json::Value = serde_json::from_str(&folder.text("truth.json")).unwrap();
    let modes = model["modes"].as_array().unwrap();
    assert_eq!(rows.len(), modes.len() + 1);
    let frequency: f64 = rows[1].split(',').nth(1).unwrap().parse().unwrap();
    assert_eq!(frequency, modes[0]["frequency_hz"].as_f64().unwrap());
    // neither is read as measured data
    for file in ["modes.csv", "model.mat"] {
        let run = folder.run(&format!("fit {file} --frf-kind mobility -o again.json"));
        assert_eq!(run.code, 65, "{file}: {}", run.stderr);
    }
}

#[test]
fn hammer_records_without_a_time_column_are_estimated() {
    let folder = Folder::new();
    for file in 1..=3 {
        let rows: String = (0..256)
            .map(|k| {
                let blow = if k == 4 { 1.0 } else { 0.0 };
                let answer = if k > 4 {
                    (-0.05 * f64::from(k - 4)).exp() * f64::from(k).sin()
                } else {
                    0.0
                };
                format!("{blow:.6},{answer:.6}\n")
            })
            .collect();
        folder.write(
            &format!("hit_{file}.csv"),
            format!("force_N,acc_m_s2\n{rows}"),
        );
    }
    let refused = folder.run("estimate hit_1.csv -o frf.h5");
    assert_eq!(refused.code, 65);
    assert!(
        refused.stderr.contains("--sample-rate"),
        "{}",
        refused.stderr
    );
    let run = folder
        .run("estimate hit_*.csv -o frf.h5 --sample-rate 4000")
        .exits(0);
    assert!(run.stdout.contains("accelerance"), "{}", run.stdout);
    assert_eq!(
        run.stderr.matches("name no DOF").count(),
        1,
        "{}",
        run.stderr
    );
    assert!(run.said().contains("(and 2 more files)"), "{}", run.stderr);
}

#[test]
fn dofs_are_declared_by_options_and_by_a_list() {
    let folder = Folder::new();
    for file in 1..=2 {
        folder.write(&format!("p{file}.csv"), "f,re [m/s/N],im\n1,2,3\n2,4,5\n");
    }
    folder.write("dofs.txt", "response,reference\n5:+Z,101:+Z\n5:+Z,102:-X\n");
    folder
        .run("convert p1.csv p2.csv --dofs dofs.txt -o list.csv")
        .exits(0);
    assert!(folder
        .text("list.csv")
        .contains("\n5,3,102,-1,2.0,4.0,5.0\n"));
    folder
        .run("convert p1.csv p2.csv --response 7 --reference 1,7 -o told.csv")
        .exits(0);
    assert!(folder.text("told.csv").contains("\n7,3,7,3,1.0,2.0,3.0\n"));
    folder.write("short.txt", "5Z,6Z\n");
    let run = folder.run("convert p1.csv p2.csv --dofs short.txt -o none.csv");
    assert_eq!(run.code, 65, "{}", run.stderr);
}

#[test]
fn a_list_of_dofs_is_an_input_like_any_other() {
    let folder = Folder::new();
    folder.write("p.csv", "f,re [m/s/N],im\n1,2,3\n2,4,5\n");
    folder.write("dofs.txt", "5:+Z,101:+Z\n");
    let missing = folder.run("info p.csv --dofs none.txt --json");
    assert_eq!(missing.code, 66, "{}", missing.stderr);
    assert_eq!(missing.json()["error"]["file"], "none.txt");
    folder.write("bad.txt", "5:+Z,101:+Q\n");
    let bad = folder.run("info p.csv --dofs bad.txt --json");
    assert_eq!(bad.code, 65, "{}", bad.stderr);
    assert_eq!(bad.json()["error"]["line"], 1);
    // it is never overwritten
    folder
        .run("convert p.csv --dofs dofs.txt -o dofs.txt --force")
        .exits(73);
    assert_eq!(folder.text("dofs.txt"), "5:+Z,101:+Z\n");
}
