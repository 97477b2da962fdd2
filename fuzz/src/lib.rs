//! The work of every fuzz target on its bytes: what the seeded mutations ask of a reader,
//! on a file in memory.

pub mod differential;
pub mod pieces;
#[path = "../../crates/chladni-cli/src/studio/question.rs"]
pub mod question;
pub mod questions;
#[path = "../../crates/chladni-render/tests/mutation/targets.rs"]
pub mod scenes;
#[path = "../../crates/chladni-io/tests/mutation/targets.rs"]
pub mod targets;

use cpu_time::ThreadTime;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;
use std::time::Duration;

/// One folder for all executions of a process: making one takes longer than most readers
/// need.
static FOLDER: LazyLock<PathBuf> = LazyLock::new(|| {
    // work handed to another thread and waited for takes longer, too
    rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .use_current_thread()
        .build_global()
        .unwrap();
    let memory = Path::new("/dev/shm");
    let parent = if memory.is_dir() {
        memory.to_path_buf()
    } else {
        std::env::temp_dir()
    };
    let folder = parent.join(format!("chladni-fuzz-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    folder
});

/// A reader that works longer hangs.
const SLOWEST: Duration = Duration::from_secs(1);

/// Runs `target` on `data` as a file with this extension. Processor time is what counts:
/// on a busy machine any run may be held up.
///
/// # Panics
/// A target that hangs.
pub fn on_file(data: &[u8], extension: &str, target: impl Fn(&Path, &[u8])) {
    let path = FOLDER.join("input").with_extension(extension);
    in_time(|| target(&path, data));
}

/// Runs `work`, which has a second.
///
/// # Panics
/// Work that hangs.
pub fn in_time(work: impl FnOnce()) {
    LazyLock::force(&FOLDER);
    let started = ThreadTime::now();
    work();
    let worked = started.elapsed();
    assert!(worked < SLOWEST, "{worked:?} of work");
}

/// Reads text as a scene, a panel and a selection.
pub fn toml_inputs(path: &Path, data: &[u8]) {
    targets::selection(path, data);
    let _ = chladni_render::Scene::read(path);
    let _ = chladni_plate::Panel::read(path, 1 << 28);
}
