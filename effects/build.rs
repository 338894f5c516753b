//! A release build embeds the folder `library/` and is built again when it changes. A debug build reads it.

use std::env;

fn main() {
    let release = env::var("PROFILE").is_ok_and(|profile| profile == "release");
    println!("cargo::rerun-if-changed={}", if release { "library" } else { "build.rs" });
}
