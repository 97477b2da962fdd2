//! `bench`: tables and charts of the named cases.

mod common;

use common::Folder;

#[test]
fn accuracy_writes_a_table_and_a_chart_for_each_case() {
    let folder = Folder::new();
    let line = "bench accuracy -o out --case few-lines --method auto --seeds 2";
    let json = folder.run(&format!("{line} --json")).exits(0).json();
    assert_eq!((json["seeds"].as_u64(), json["rows"].as_u64()), (Some(2), Some(1)));
    for name in ["accuracy.csv", "accuracy-few-lines.svg", "accuracy-few-lines.png"] {
        assert!(folder.path().join("out").join(name).is_file(), "{name}");
    }
    let csv = folder.text("out/accuracy.csv");
    let header = csv.lines().find(|line| !line.starts_with('#')).unwrap();
    assert!(header.starts_with("case,method,time_s,frequency_rmse_over_crlb,"), "{header}");

    let again = folder.run(line).exits(73);
    assert!(again.stderr.contains("--force"), "{}", again.stderr);
    folder.run(&format!("{line} --force -q")).exits(0);
}

#[test]
fn an_unknown_case_is_answered_with_the_known_ones() {
    let run = Folder::new().run("bench accuracy -o out --case hard").exits(2);
    assert!(run.stderr.contains("overlap-3") && run.stderr.contains("hard"), "{}", run.stderr);
    let run = Folder::new().run("bench profile -o nowhere/out").exits(73);
    assert!(run.stderr.contains("folder"), "{}", run.stderr);
}
