//! Writes the maps that `tests/files/scripts/check.py` opens with other programs: those that the crate writes, and
//! those of formats that no free program writes.
//!
//! `cargo run -p robofin-instruments --example samples FOLDER`

#[path = "../tests/common/mod.rs"]
mod common;

use std::error::Error;
use std::path::PathBuf;

use instruments::surface::write;

fn main() -> Result<(), Box<dyn Error>> {
    let folder = PathBuf::from(std::env::args_os().nth(1).ok_or("the folder to write into is expected")?);
    for name in ["map.x3p", "map.sur", "map.asc"] {
        let file = folder.join(name);
        std::fs::write(&file, write(&file, &common::map())?)?;
    }
    for (name, bytes) in common::encoders::all() {
        std::fs::write(folder.join(name), bytes)?;
    }
    Ok(())
}
