//! Lists the files of `library/`, which the crate embeds: a new effect is one new file.

use std::path::Path;
use std::{env, fs};

fn main() {
    let folder = Path::new(&env::var("CARGO_MANIFEST_DIR").expect("cargo sets it")).join("library");
    println!("cargo::rerun-if-changed={}", folder.display());
    let entries = fs::read_dir(&folder).expect("the library is a folder");
    let names = entries.map(|entry| entry.expect("the folder can be read").file_name().into_string().expect("UTF-8"));
    let mut names: Vec<String> = names.filter(|name| name.ends_with(".toml")).collect();
    names.sort();
    let line = |name: &String| format!("({name:?}, include_str!({:?})),\n", folder.join(name));
    let list = format!("&[\n{}]\n", names.iter().map(line).collect::<String>());
    let out = env::var("OUT_DIR").expect("cargo sets it");
    fs::write(Path::new(&out).join("library.rs"), list).expect("the folder of outputs can be written");
}
