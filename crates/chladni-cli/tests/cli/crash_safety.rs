//! Results are complete or missing: after a kill, without space, and with any number of threads.

use crate::common::Folder;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

const KILLS: u32 = 200;

/// The program in `folder`, without output.
fn chladni(folder: &Folder, line: &str) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_chladni"));
    command
        .current_dir(folder.path())
        .args(line.split_whitespace())
        .stdout(Stdio::null())
        .stderr(Stdio::null());
    command
}

/// A folder with two panels, each as HDF5 and as universal file.
fn two_results() -> (Folder, [Vec<u8>; 2]) {
    let folder = Folder::with_panel();
    folder
        .run("simulate panel.toml -o other.h5 --seed 7 -q")
        .exits(0);
    let results = ["panel", "other"].map(|name| {
        folder
            .run(&format!("convert {name}.h5 -o {name}.unv -q"))
            .exits(0);
        folder.read(&format!("{name}.unv"))
    });
    (folder, results)
}

#[test]
fn a_killed_run_leaves_the_old_file_or_the_new_one() {
    let (folder, results) = two_results();
    assert_ne!(results[0], results[1]);
    folder.write("out.unv", &results[0]);
    let started = Instant::now();
    assert!(chladni(&folder, "convert panel.h5 -o out.unv --force")
        .status()
        .unwrap()
        .success());
    let whole = started.elapsed();
    let (mut finished, mut replaced, mut holds) = (0, 0, 0);
    for k in 0..KILLS {
        let name = ["panel", "other"][(1 - holds) % 2];
        let mut child = chladni(&folder, &format!("convert {name}.h5 -o out.unv --force"))
            .spawn()
            .unwrap();
        // golden-ratio steps spread the kills evenly over slightly more than a run
        let part = f64::from(k) * 0.618_033_988_75 % 1.0;
        std::thread::sleep(Duration::from_secs_f64(1.3 * part * whole.as_secs_f64()));
        finished += u32::from(child.try_wait().unwrap().is_some());
        child.kill().ok(); // SIGKILL
        child.wait().unwrap();
        let found = folder.read("out.unv");
        let now = results.iter().position(|result| *result == found);
        let now = now.unwrap_or_else(|| {
            panic!(
                "kill {k}: neither the old nor the new file, {} bytes",
                found.len()
            )
        });
        replaced += u32::from(now != holds);
        holds = now;
    }
    println!("{KILLS} kills: {finished} after the end, {replaced} with the new file in place");
    assert!(finished < KILLS, "kills must come while it runs");
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_leaves_the_old_file_and_nothing_else() {
    let folder = Folder::with_panel();
    let before = folder.names();
    for (name, old) in [("out.csv", None), ("panel.unv", Some("old"))] {
        if let Some(old) = old {
            folder.write(name, old);
        }
        // files are limited to 64 blocks and the signal is ignored, so that writing fails as on a
        // full disk
        let line = format!(
            "trap '' XFSZ; ulimit -f 64; exec {} --json convert panel.h5 -o {name} --force",
            env!("CARGO_BIN_EXE_chladni")
        );
        let output = Command::new("sh")
            .args(["-c", &line])
            .current_dir(folder.path())
            .output()
            .unwrap();
        let answer: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        assert_eq!(
            (output.status.code(), answer["error"]["kind"].as_str()),
            (Some(74), Some("io")),
            "{answer}"
        );
        if let Some(old) = old {
            assert_eq!(folder.text(name), old);
            std::fs::remove_file(folder.path().join(name)).unwrap();
        }
        assert_eq!(folder.names(), before, "nothing was left behind");
    }
}

/// Number of moments for each signal and each way to start; `CHLADNI_ROUNDS=50 cargo test
/// --release --test cli signal` tries more.
#[cfg(target_os = "linux")]
fn rounds() -> u32 {
    std::env::var("CHLADNI_ROUNDS")
        .map_or(3, |text| text.parse().expect("CHLADNI_ROUNDS is a number"))
}

/// Waits until a process has begun its work: it catches SIGTERM, the 15th.
#[cfg(target_os = "linux")]
fn wait_for_start(pid: u32) {
    loop {
        let Ok(status) = std::fs::read_to_string(format!("/proc/{pid}/status")) else {
            return;
        };
        let caught = status.lines().find_map(|line| line.strip_prefix("SigCgt:"));
        let caught = caught.map(|mask| u64::from_str_radix(mask.trim(), 16).unwrap());
        if status.contains("State:\tZ") || caught.is_some_and(|mask| mask >> 14 & 1 == 1) {
            return;
        }
        std::thread::sleep(Duration::from_micros(200));
    }
}

#[cfg(target_os = "linux")]
#[test]
fn any_signal_leaves_the_old_file_or_the_new_one_and_nothing_beside_it() {
    let (folder, results) = two_results();
    folder.write("out.unv", &results[0]);
    let names = folder.names();
    let started = Instant::now();
    folder
        .run("convert panel.h5 -o out.unv --force -q")
        .exits(0);
    let whole = started.elapsed();
    let mut left = 0;
    // a background job ignores Ctrl-C, and a job under nohup the closed terminal
    for start in ["trap '' INT QUIT; exec", "exec nohup", "exec"] {
        for signal in ["KILL", "TERM", "HUP", "XFSZ"] {
            let mut ends = Vec::new();
            for k in 0..rounds() {
                let name = ["panel", "other"][k as usize % 2];
                let program = env!("CARGO_BIN_EXE_chladni");
                let line = format!("{start} {program} convert {name}.h5 -o out.unv --force");
                let mut child = Command::new("sh")
                    .args(["-c", &line])
                    .current_dir(folder.path())
                    .stdout(Stdio::null())
                    .stderr(Stdio::null())
                    .spawn()
                    .unwrap();
                wait_for_start(child.id());
                // golden-ratio steps spread the moments evenly over a run
                let part = f64::from(k + 1) * 0.618_033_988_75 % 1.0;
                std::thread::sleep(Duration::from_secs_f64(part * whole.as_secs_f64()));
                let kill = format!("kill -s {signal} {}", child.id());
                Command::new("sh").args(["-c", &kill]).output().unwrap();
                let end = child.wait().unwrap();
                ends.push(end.code());
                let expected: &[Option<i32>] = match signal {
                    "KILL" => &[Some(0), None],
                    _ if signal == "HUP" && start.contains("nohup") => &[Some(0)],
                    _ => &[Some(0), Some(130)],
                };
                let told = format!("{start} {signal} {k}: {end}");
                assert!(expected.contains(&end.code()), "{told}");
                assert!(results.contains(&folder.read("out.unv")), "{told}");
                if signal == "KILL" {
                    left += usize::from(folder.names() != names);
                } else {
                    assert_eq!(folder.names(), names, "{told}");
                }
            }
            // the next run removes the temporary files of a killed one
            folder
                .run("convert panel.h5 -o out.unv --force -q")
                .exits(0);
            assert_eq!(folder.names(), names, "{start} {signal}");
            println!("{start} {signal}: {ends:?}");
        }
    }
    println!("{left} killed runs left a temporary file, until the next");
}

#[cfg(target_os = "linux")]
#[test]
fn a_file_that_grows_too_large_is_an_interruption() {
    let folder = Folder::with_panel();
    let before = folder.names();
    for extension in ["csv", "h5", "uff", "npz"] {
        let line = format!(
            "ulimit -f 64; exec {} --json convert panel.h5 -o out.{extension}",
            env!("CARGO_BIN_EXE_chladni")
        );
        let output = Command::new("sh")
            .args(["-c", &line])
            .current_dir(folder.path())
            .output()
            .unwrap();
        let answer: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        assert_eq!(output.status.code(), Some(130), "{answer}");
        assert_eq!(answer["error"]["code"], 130);
        assert_eq!(folder.names(), before, "nothing was left behind");
    }
}

#[test]
fn an_output_that_is_an_input_or_cannot_be_made_is_refused() {
    let folder = Folder::with_panel();
    let before = folder.read("panel.h5");
    for line in [
        "convert panel.h5 -o panel.h5 --force",
        "convert panel.h5 -o ./panel.h5 --force",
        "estimate panel.h5 -o panel.h5 --force",
    ] {
        folder.run(line).exits(73);
    }
    assert_eq!(folder.read("panel.h5"), before);
    // a file in place of a folder, and a folder in place of a file
    folder
        .run("convert panel.h5 -o panel.toml/out.h5")
        .exits(73);
    std::fs::create_dir(folder.path().join("taken.h5")).unwrap();
    folder.run("convert panel.h5 -o taken.h5 --force").exits(73);
}

#[cfg(target_os = "linux")]
#[test]
fn a_read_only_folder_is_refused() {
    use std::os::unix::fs::PermissionsExt;
    let folder = Folder::with_panel();
    let locked = folder.path().join("locked");
    std::fs::create_dir(&locked).unwrap();
    std::fs::set_permissions(&locked, std::fs::Permissions::from_mode(0o555)).unwrap();
    // permissions do not bind an administrator, but no file can be made among the
    // system's own
    let binds = std::fs::write(locked.join("probe"), "").is_err();
    let target = if binds {
        "locked/out.h5"
    } else {
        "/proc/out.h5"
    };
    let run = folder
        .run(&format!("convert panel.h5 -o {target}"))
        .exits(73);
    assert!(
        run.stderr.contains("out.h5") && run.stderr.contains("help"),
        "{}",
        run.stderr
    );
    assert!(!binds || std::fs::read_dir(&locked).unwrap().count() == 0);
    std::fs::set_permissions(&locked, std::fs::Permissions::from_mode(0o755)).unwrap();
}

#[test]
fn files_are_the_same_bytes_at_any_number_of_threads() {
    let folder = Folder::with_panel();
    let mut signal = String::from("t [s],101:+Z [N],1:+Z [m/s],2:+Z [m/s]\n");
    for k in 0..4096_u32 {
        let drive = f64::from(k.wrapping_mul(2_654_435_761) >> 8) / f64::from(1 << 24) - 0.5;
        signal += &format!(
            "{},{drive},{},{}\n",
            f64::from(k) / 1000.0,
            drive * 0.5,
            0.1 * drive + 0.01 * (0.3 * f64::from(k)).sin()
        );
    }
    folder.write("time.csv", signal);
    for (line, extension) in [
        ("convert panel.h5 -o", "uff"),
        ("convert panel.h5 -o", "unv"),
        ("convert panel.h5 -o", "csv"),
        ("convert panel.h5 -o", "npz"),
        ("convert panel.h5 -o", "h5"),
        ("convert truth.json -o", "vtu"),
        ("estimate time.csv -o", "h5"),
    ] {
        let name = |threads: u32| format!("threads-{threads}.{extension}");
        for threads in [1, 2, 4] {
            folder
                .run(&format!(
                    "{line} {} --threads {threads} --force -q",
                    name(threads)
                ))
                .exits(0);
        }
        assert_eq!(
            folder.read(&name(1)),
            folder.read(&name(2)),
            "{line} {extension}"
        );
        assert_eq!(
            folder.read(&name(1)),
            folder.read(&name(4)),
            "{line} {extension}"
        );
    }
}
