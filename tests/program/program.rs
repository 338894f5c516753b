//! Runs the program and checks the properties that every verb guarantees.

use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitStatus, Stdio};
use std::sync::LazyLock;
use std::time::{Duration, Instant};

use serde_json::Value;
use tempfile::TempDir;

/// Time after which a run counts as hung.
const PATIENCE: Duration = Duration::from_secs(180);

/// Returns the path of the bundled part.
pub(crate) fn bracket() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("data/bracket.obj")
}

/// Output and exit status of a run.
pub(crate) struct Outcome {
    pub(crate) status: ExitStatus,
    pub(crate) stdout: String,
    pub(crate) stderr: String,
}

/// Returns a command for the program with unchecked arguments.
pub(crate) fn robofin<S: AsRef<OsStr>>(arguments: impl IntoIterator<Item = S>) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_robofin"));
    command.args(arguments);
    command
}

/// Returns `robofin weld` of the bundled part with coarse voxels.
pub(crate) fn weld_bracket(out: &Path) -> Command {
    let mut command = robofin(["weld", "--seed", "7", "--usd", "off", "--resolution", "64"]);
    command.arg(bracket()).arg("--out").arg(out);
    command
}

/// Runs a command to its end; fails the test if it hangs.
pub(crate) fn run(command: &mut Command) -> Outcome {
    let shown = format!("{command:?}");
    let folder = tempfile::tempdir().expect("a temporary folder");
    let place = |name: &str| folder.path().join(name);
    let file = |name: &str| fs::File::create(place(name)).expect("a file for the output");
    command.stdin(Stdio::null()).stdout(file("stdout")).stderr(file("stderr"));
    let mut child = command.spawn().expect("the program can be started");
    let started = Instant::now();
    let status = loop {
        if let Some(status) = child.try_wait().expect("the program can be waited for") {
            break status;
        }
        if started.elapsed() > PATIENCE {
            child.kill().expect("the program can be stopped");
            child.wait().expect("the program ends");
            panic!("{shown} hangs");
        }
        std::thread::sleep(Duration::from_millis(5));
    };
    let read = |name: &str| String::from_utf8(fs::read(place(name)).expect("the output")).expect("the output is text");
    Outcome { status, stdout: read("stdout"), stderr: read("stderr") }
}

impl Outcome {
    /// Asserts that the run succeeded and did not panic.
    #[track_caller]
    pub(crate) fn succeeds(self) -> Self {
        assert_eq!(self.status.code(), Some(0), "{}", self.stderr);
        assert!(!self.stderr.contains("panicked"), "{}", self.stderr);
        self
    }

    /// Asserts that the run ended with this exit code and one `error:` line that contains all of `words`; returns that
    /// line.
    #[track_caller]
    pub(crate) fn is_refused(&self, code: i32, words: &[&str]) -> String {
        let text = &self.stderr;
        assert_eq!(self.status.code(), Some(code), "{words:?} expected in: {text}");
        assert!(!text.contains("panicked") && !text.contains("RUST_BACKTRACE"), "{text}");
        let errors: Vec<&str> = text.lines().filter(|line| line.starts_with("error: ")).collect();
        assert_eq!(errors.len(), 1, "one error line is expected: {text}");
        for word in words {
            assert!(errors[0].contains(word), "{word:?} is missing in: {}", errors[0]);
        }
        errors[0].to_owned()
    }

    /// Asserts that the run ended as wrong use, with one `error:` line for each of `faults` in this order, which
    /// contains all its words.
    #[track_caller]
    pub(crate) fn is_refused_for_all(&self, faults: &[&[&str]]) {
        let text = &self.stderr;
        assert_eq!(self.status.code(), Some(2), "{text}");
        let errors: Vec<&str> = text.lines().filter(|line| line.starts_with("error: ")).collect();
        assert_eq!(errors.len(), faults.len(), "{} error lines are expected: {text}", faults.len());
        for (error, words) in errors.iter().zip(faults) {
            assert!(words.iter().all(|word| error.contains(word)), "{words:?} expected in: {error}");
        }
    }

    /// Returns the single JSON object on standard output.
    #[track_caller]
    pub(crate) fn answer(&self) -> Value {
        let value: Value = serde_json::from_str(&self.stdout).expect("standard output is one JSON value");
        assert!(value.is_object(), "{value}");
        value
    }
}

/// Returns an asset of the bundled part, made once.
pub(crate) fn asset() -> &'static Path {
    static ASSET: LazyLock<TempDir> = LazyLock::new(|| {
        let folder = tempfile::tempdir().expect("a temporary folder");
        run(&mut weld_bracket(&folder.path().join("asset"))).succeeds();
        folder
    });
    static PLACE: LazyLock<PathBuf> = LazyLock::new(|| ASSET.path().join("asset"));
    &PLACE
}

/// Copies [`asset`], where a test may damage it.
pub(crate) fn copy_of_asset(folder: &Path) -> PathBuf {
    let place = folder.join("asset");
    fs::create_dir(&place).expect("a folder for the copy");
    for (name, content) in files(asset()) {
        fs::write(place.join(name), content).expect("a copied file");
    }
    place
}

/// Reads all files of a flat folder by name.
pub(crate) fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    names(folder).into_iter().map(|name| (name.clone(), fs::read(folder.join(name)).expect("a file"))).collect()
}

/// Returns the names in a folder, sorted.
pub(crate) fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).expect("the folder can be read");
    let mut names: Vec<String> =
        entries.map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}
