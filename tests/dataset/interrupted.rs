//! Runs that are killed, and runs that make the same items at the same time.

use std::process::Stdio;
use std::thread::sleep;
use std::time::Duration;

use crate::program::run;
use crate::set::{assert_same, dataset, items, tree, undisturbed};

#[test]
fn killed_and_resumed_is_byte_for_byte_what_an_undisturbed_run_makes() {
    let (parts, whole) = undisturbed();
    let place = tempfile::tempdir().expect("a temporary folder");
    let out = place.path().join("set");
    let mut interrupted = 0;
    for delay in [5, 60, 150, 250, 400, 700] {
        let mut command = dataset(parts, &out);
        command.args(["--resume", "--jobs", "2"]).stdout(Stdio::null()).stderr(Stdio::null());
        let mut child = command.spawn().expect("the program can be started");
        sleep(Duration::from_millis(delay));
        child.kill().expect("the program can be killed");
        interrupted += usize::from(!child.wait().expect("the program ends").success());
        // Every item under its final name must be complete.
        for item in if out.join("assets").exists() { items(&out) } else { Vec::new() } {
            let name = item.file_name().expect("a name").to_string_lossy().into_owned();
            if !name.starts_with('.') {
                assert!(tree(&item) == tree(&whole.join("assets").join(&name)), "{name} after {delay} ms");
            }
        }
    }
    assert!(interrupted > 0, "all runs were finished before they were killed");
    run(dataset(parts, &out).arg("--resume")).succeeds();
    assert_same(&out, whole);
}

#[test]
fn two_runs_at_once_share_the_work_and_none_is_done_twice() {
    let (parts, whole) = undisturbed();
    let place = tempfile::tempdir().expect("a temporary folder");
    let out = place.path().join("set");
    let work = || run(dataset(parts, &out).args(["--resume", "--json", "--jobs", "2"]));
    let (one, two) = std::thread::scope(|scope| {
        let other = scope.spawn(work);
        (work(), other.join().expect("no panic"))
    });
    let made = [one.succeeds(), two.succeeds()].map(|told| told.stdout.matches("\"ending\":\"made\"").count());
    assert_eq!(made[0] + made[1], crate::set::ITEMS, "{made:?}");
    assert_same(&out, whole);
}

#[cfg(unix)]
#[test]
fn items_end_with_the_run_that_asked_for_them() {
    let (parts, _) = undisturbed();
    let place = tempfile::tempdir().expect("a temporary folder");
    let out = place.path().join("set");
    let mut command = dataset(parts, &out);
    // Fine voxels, so that an item takes long and can be interrupted.
    command.args(["--jobs", "1", "--resolution", "512"]).stdout(Stdio::null()).stderr(Stdio::null());
    let arguments: Vec<_> =
        command.get_args().filter(|word| *word != "--diagonal" && *word != "48").map(Into::into).collect();
    let mut command = crate::program::robofin::<std::ffi::OsString>(arguments);
    let mut child = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().expect("the program can be started");
    let is_staged =
        || out.join("assets").is_dir() && items(&out).iter().any(|path| path.to_string_lossy().contains(".part-"));
    while !is_staged() {
        sleep(Duration::from_millis(2));
    }
    child.kill().expect("the program can be killed");
    child.wait().expect("the program ends");
    sleep(Duration::from_millis(300));
    let left = tree(&out);
    sleep(Duration::from_millis(1500));
    assert!(tree(&out) == left, "something is still writing");
    assert!(items(&out).iter().all(|path| path.to_string_lossy().contains("/.")), "an item was finished all the same");
}
