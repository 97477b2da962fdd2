//! Twelve usual mistakes, each made from a clean simulated set: `info` or `fit` names the mistake,
//! and says nothing about the clean set.

use crate::common::Folder;
use chladni_frf::{Dof, FrfKind, FrfSet, FrfValues};
use chladni_io::{read_frf, write_contents, Contents};
use num_complex::Complex64;

/// 4 responses on the plate and its 10 driving points.
const PANEL: &str =
    "[responses]\ngrid = [4, 3]\nspacing_m = 0.05\nat_references = true\n[references]\nedge_count = [3, 2]\nspacing_m = 0.06\n\
                     [frf]\nstart_hz = 20.0\nstop_hz = 400.0\nstep_hz = 0.5\n";

/// A clean set as HDF5, universal file and table.
fn clean() -> Folder {
    let folder = Folder::new();
    folder.write("panel.toml", PANEL);
    folder.run("simulate panel.toml -o clean.h5 -q").exits(0);
    for other in ["unv", "csv"] {
        folder
            .run(&format!("convert clean.h5 -o clean.{other} -q"))
            .exits(0);
    }
    folder
}

/// Writes `spoiled.h5`: the clean set after `spoil`.
fn spoil(folder: &Folder, spoil: impl FnOnce(&mut FrfSet)) {
    let (mut frf, ..) = read_frf(&[folder.path().join("clean.h5")], &Default::default()).unwrap();
    spoil(&mut frf);
    write_contents(
        &folder.path().join("spoiled.h5"),
        &Contents {
            frf: Some(frf),
            ..Contents::default()
        },
        true,
    )
    .unwrap();
}

fn each_value(frf: &mut FrfSet, change: impl Fn(Complex64) -> Complex64) {
    let FrfValues::F64(values) = &mut frf.values else {
        panic!("a simulation is of double precision")
    };
    values.mapv_inplace(change);
}

/// The text of a command on stderr.
fn says(folder: &Folder, line: &str) -> String {
    folder.run(line).said()
}

/// Checks that `words` are said of the spoiled file and not of the clean one.
fn named(folder: &Folder, command: &str, spoiled: &str, clean: &str, words: &str) {
    let (of_spoiled, of_clean) = (
        says(folder, &format!("{command} {spoiled}")),
        says(folder, &format!("{command} {clean}")),
    );
    assert!(
        of_spoiled.contains(words),
        "{command} {spoiled}: {of_spoiled}"
    );
    assert!(!of_clean.contains(words), "{command} {clean}: {of_clean}");
}

#[test]
fn wrong_units_in_a_universal_file_and_in_a_table() {
    let folder = clean();
    let text = folder.text("clean.unv");
    let labelled = text.replace("m/s", "mm/s");
    assert_ne!(text, labelled);
    folder.write("spoiled.unv", labelled);
    named(&folder, "info", "spoiled.unv", "clean.unv", "contradicts");
    let said = says(&folder, "info spoiled.unv");
    assert_eq!(
        (
            said.matches("contradicts").count(),
            said.matches("(and 219 more datasets)").count()
        ),
        (1, 1),
        "{said}"
    );
    let table = folder.text("clean.csv");
    let unit = table.replacen("m/s/N", "bar", usize::MAX);
    assert_ne!(table, unit, "{}", &table[..300]);
    folder.write("spoiled.csv", unit);
    named(
        &folder,
        "info",
        "spoiled.csv",
        "clean.csv",
        "is no motion per force or volt",
    );
}

#[test]
fn wrong_kind_and_receptance_called_mobility() {
    let folder = clean();
    spoil(&folder, |frf| frf.kind = Some(FrfKind::Accelerance));
    named(&folder, "fit", "spoiled.h5", "clean.h5", "wrong FRF kind?");
    spoil(&folder, |frf| {
        let lines = frf.frequency_hz.clone();
        let FrfValues::F64(values) = &mut frf.values else {
            panic!("a simulation is of double precision")
        };
        for (mut line, &hz) in values.axis_iter_mut(ndarray::Axis(2)).zip(&lines) {
            line.mapv_inplace(|value| value / Complex64::new(0.0, std::f64::consts::TAU * hz));
        }
    });
    named(
        &folder,
        "fit",
        "spoiled.h5",
        "clean.h5",
        "as if the data were receptance",
    );
}

#[test]
fn wrong_time_sign() {
    let folder = clean();
    spoil(&folder, |frf| each_value(frf, |value| value.conj()));
    named(&folder, "fit", "spoiled.h5", "clean.h5", "--time-sign");
    // the advice is not the option that spoiled the data
    let said = folder.run("fit clean.h5 --time-sign -").exits(1).said();
    assert!(said.contains("(--time-sign +)"), "{said}");
}

/// The delay that is told, taken off by the option that is named, gives the modes of the clean set,
/// also part by part; a file keeps what was taken off.
#[test]
fn delayed_throughout() {
    let folder = clean();
    folder
        .run("convert clean.h5 --delay -0.004 -o late.h5 -q")
        .exits(0);
    named(&folder, "fit", "late.h5", "clean.h5", "all FRFs lag by ");
    let said = says(&folder, "fit late.h5");
    let (_, advice) = said.split_once("take it off: ").expect("advice");
    let advice: Vec<&str> = advice.split_whitespace().take(2).collect();
    let sure = |line: &str| -> Vec<f64> {
        let fit = folder.run(&format!("{line} --json")).exits(0).json();
        let modes = fit["modes"].as_array().expect("modes");
        let is_sure =
            |mode: &&serde_json::Value| mode["trust"] == "sure" && mode["in_band"] == true;
        let sure = modes.iter().filter(is_sure);
        sure.filter_map(|mode| mode["frequency_hz"].as_f64())
            .collect()
    };
    let of_clean = sure("fit clean.h5");
    folder
        .run("convert late.h5 --delay 0.004 -o mended.csv -q")
        .exits(0);
    for (line, most) in [
        // what is left of it opens the law: bars hold both
        (&*format!("fit late.h5 {}", advice.join(" ")), 2e-5),
        ("fit late.h5 --delay 0.004 --memory 100K", 1e-6),
        ("fit mended.csv", 1e-6),
    ] {
        let found = sure(line);
        assert_eq!(found.len(), of_clean.len(), "{line}");
        for (found, clean) in found.iter().zip(&of_clean) {
            assert!((found / clean - 1.0).abs() < most, "{line}: {found}");
        }
    }
    for wrong in ["nan", "5ms", "1e9"] {
        let said = folder.run(&format!("fit late.h5 --delay {wrong}"));
        assert!(said.exits(2).said().contains("--delay"), "{wrong}");
    }
}

#[test]
fn reversed_direction() {
    let folder = clean();
    spoil(&folder, |frf| each_value(frf, |value| -value));
    named(
        &folder,
        "fit",
        "spoiled.h5",
        "clean.h5",
        "points the other way",
    );
}

#[test]
fn mixed_axes_of_frequency_and_of_the_sensor() {
    let folder = clean();
    folder.write(
        "other.toml",
        PANEL.replace("step_hz = 0.5", "step_hz = 1.0"),
    );
    folder.run("simulate other.toml -o other.h5 -q").exits(0);
    let mixed = folder.run("fit clean.h5 other.h5 --duplicates first");
    assert_eq!(mixed.code, 65, "{}", mixed.stderr);
    assert!(mixed.stderr.contains("frequency ax"), "{}", mixed.stderr);
    spoil(&folder, |frf| {
        frf.responses[2] = format!("{}:+X", frf.responses[2].node)
            .parse::<Dof>()
            .unwrap()
    });
    named(&folder, "info", "spoiled.h5", "clean.h5", "mixed axes");
}

#[test]
fn missing_reference() {
    let folder = clean();
    folder.write("spoiled.csv", "f (Hz),re,im\n10,1,0\n20,2,1\n30,1,0\n");
    let said = says(&folder, "info spoiled.csv");
    assert!(
        said.contains("names no reference DOF") && said.contains("--reference"),
        "{said}"
    );
}

#[test]
fn decimal_commas_between_commas() {
    let folder = Folder::new();
    let rows: String = (1..40)
        .map(|k| format!("{},5,0,{k},1,25\n", 10 + k))
        .collect();
    folder.write("spoiled.csv", format!("f,re,im\n{rows}"));
    let run = folder.run("info spoiled.csv");
    assert!(run.stderr.contains("decimal"), "{}", run.stderr);
}

#[test]
fn kilohertz_called_hertz() {
    let folder = clean();
    spoil(&folder, |frf| {
        frf.frequency_hz.mapv_inplace(|hz| hz / 1000.0)
    });
    named(&folder, "info", "spoiled.h5", "clean.h5", "is it in kHz?");
}

#[test]
fn response_and_reference_swapped() {
    let folder = clean();
    spoil(&folder, |frf| {
        let FrfValues::F64(values) = &frf.values else {
            panic!("a simulation is of double precision")
        };
        frf.values = FrfValues::F64(
            values
                .clone()
                .permuted_axes([1, 0, 2])
                .as_standard_layout()
                .into_owned(),
        );
        std::mem::swap(&mut frf.responses, &mut frf.references);
    });
    named(&folder, "info -v", "spoiled.h5", "clean.h5", "swapped");
}

#[test]
fn clipped_data() {
    let folder = clean();
    spoil(&folder, |frf| {
        let FrfValues::F64(values) = &frf.values else {
            panic!("a simulation is of double precision")
        };
        let most = 0.2 * values.iter().map(|value| value.norm()).fold(0.0, f64::max);
        each_value(frf, |value| {
            Complex64::new(value.re.clamp(-most, most), value.im.clamp(-most, most))
        });
    });
    for command in ["info", "fit"] {
        named(&folder, command, "spoiled.h5", "clean.h5", "clipped:");
    }
}

#[test]
fn missing_driving_point() {
    let folder = clean();
    folder.write("without.toml", PANEL.replace("at_references = true\n", ""));
    folder
        .run("simulate without.toml -o spoiled.h5 -q")
        .exits(0);
    named(&folder, "fit -v", "spoiled.h5", "clean.h5", "driving point");
}
