//! `evaluate --field` and `correct` where two cables are swapped.

use crate::common::Folder;
use serde_json::Value;

#[test]
fn two_swapped_cables_are_the_likeliest_cause() {
    let folder = Folder::with_glass();
    folder.write(
        "scene.toml",
        "frequency_hz = 330.0\n[zones]\ngrid = [2, 2]\nhot = [1]\n",
    );
    folder.run("render model.json scene.toml -o w.json -q");
    let mut weights: Value = serde_json::from_str(&folder.text("w.json")).unwrap();
    for part in ["re", "im", "amplitude", "phase_deg"] {
        let [one, other] = [3, 20].map(|k| weights["weights"][k][part].clone());
        (weights["weights"][3][part], weights["weights"][20][part]) = (other, one);
    }
    folder.write("swapped.json", weights.to_string());
    folder
        .run("simulate panel.toml --play swapped.json -o played.csv --snr-db 40 -q")
        .exits(0);
    let field = folder.text("played.csv");
    let other_weights = |line: &&str| !line.contains("weights_sha256");
    let lines: Vec<&str> = field.lines().filter(other_weights).collect();
    folder.write("field.csv", lines.join("\n") + "\n");
    let run = folder
        .run("evaluate w.json --scene scene.toml --on model.json --field field.csv")
        .exits(0);
    let cause = "Likeliest cause: two cables are swapped.";
    assert!(run.stdout.contains(cause), "{}", run.stdout);
    let channels = [3, 20].map(|k| weights["weights"][k]["reference"].as_str().unwrap());
    let [one, other] = channels;
    let words = format!("the cables of {one} and {other} are swapped");
    assert!(run.said().contains(&words), "{}", run.stderr);
    let run = folder
        .run("correct model.json scene.toml --weights w.json --field field.csv -o next.json")
        .exits(0);
    assert!(run.said().contains(&words), "{}", run.stderr);
}
