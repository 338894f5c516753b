use std::fs;
use std::path::{Path, PathBuf};

use export::python::{Places, Script};

use crate::outside::{python, untested};

fn places(own: PathBuf) -> Places {
    Places { chosen: None, active: None, own: Some(own), bootstrap_allowed: true }
}

#[cfg(unix)]
fn fake_interpreter(venv: &Path, last_words: &str) -> PathBuf {
    use std::os::unix::fs::PermissionsExt;
    let bin = venv.join("bin");
    fs::create_dir_all(&bin).expect("the folder can be made");
    let path = bin.join("python");
    fs::write(&path, format!("#!/bin/sh\necho '{last_words}' >&2\nexit 1\n")).expect("the script can be written");
    fs::set_permissions(&path, fs::Permissions::from_mode(0o755)).expect("it can be made executable");
    path
}

#[cfg(unix)]
#[test]
fn a_chosen_interpreter_is_used_or_refused_and_never_passed_over() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = fake_interpreter(folder.path(), "Python 3.9 found, 3.11 to 3.14 needed");
    let places = Places { chosen: Some(path), ..places(folder.path().join("unused")) };
    let error = places.find(Some(&mut |_| panic!("nothing is made"))).expect_err("3.9 is too old").to_string();
    assert!(error.contains("ROBOFIN_PYTHON") && error.contains("Python 3.9 found"), "{error}");
    assert_eq!(error.lines().count(), 1, "{error}");
}

#[cfg(unix)]
#[test]
fn an_environment_that_somebody_else_made_is_left_alone() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let venv = folder.path().join(".venv");
    fake_interpreter(&venv, "No module named pxr");
    let error = places(venv.clone()).find(Some(&mut |_| panic!("nothing is made"))).expect_err("it lacks pxr");
    assert!(error.to_string().contains("No module named pxr"), "{error}");
    assert!(venv.join("bin/python").exists());
}

#[test]
fn nothing_is_made_where_that_is_forbidden() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let venv = folder.path().join(".venv");
    let forbidden = Places { bootstrap_allowed: false, ..places(venv.clone()) };
    for found in [forbidden.find(Some(&mut |_| panic!("nothing is made"))), places(venv.clone()).find(None)] {
        let error = found.expect_err("there is none").to_string();
        assert!(error.contains("ROBOFIN_NO_BOOTSTRAP"), "{error}");
    }
    assert_eq!(fs::read_dir(folder.path()).expect("the folder").count(), 0);
}

#[test]
fn two_that_start_together_make_one_environment_and_replace_an_outdated_one() {
    if python("making a Python environment").is_none() {
        return;
    }
    let folder = tempfile::tempdir().expect("a temporary folder");
    let venv = folder.path().join(".venv");
    fs::create_dir_all(&venv).expect("the folder can be made");
    fs::write(venv.join("robofin-requirements.txt"), "usd-core==1.0\n").expect("the stamp can be written");
    let make = || {
        let mut announced = 0;
        places(venv.clone()).find(Some(&mut |_| announced += 1)).map(|python| (python, announced))
    };
    let (one, two) = std::thread::scope(|scope| {
        let other = scope.spawn(make);
        (make(), other.join().expect("no panic"))
    });
    let ((one, first), (two, second)) = match (one, two) {
        (Ok(one), Ok(two)) => (one, two),
        (Err(error), _) | (_, Err(error)) => return untested("making a Python environment", &error.to_string()),
    };
    assert_eq!(one, two);
    assert_eq!(first + second, 1, "one makes it, the other waits");
    assert!(one.versions().contains("USD 0.26.11"), "{}", one.versions());
    assert!(one.executable().starts_with(&venv));
    assert!(!folder.path().join(".venv.tmp").exists());
}

#[test]
fn a_script_that_fails_is_quoted() {
    let Some(python) = python("errors of the Python scripts") else { return };
    let error = python.run_script(Script::ExportUsd, ["/absent/job.json"]).expect_err("there is no job").to_string();
    assert!(error.contains("export_usd.py failed") && error.contains("/absent/job.json"), "{error}");
    assert_eq!(error.lines().count(), 1, "{error}");
}
