//! A workbench on a temporary folder, and a browser that opens it.

#![allow(dead_code, reason = "each test uses a part of it")]

pub mod devtools;
pub mod http;
pub mod sets;

use std::fs;
use std::net::SocketAddr;
use std::path::{Path, PathBuf};

use workbench::{Options, Workbench};

/// Token in the program's format.
pub const TOKEN: &str = "00112233445566778899aabbccddeeff";

/// A server that runs until the test ends.
pub struct Server {
    pub address: SocketAddr,
    pub url: String,
}

/// Starts a server on a folder.
pub fn serve(folder: &Path, out: &Path) -> Server {
    let address = SocketAddr::from(([127, 0, 0, 1], 0));
    let options =
        Options { folder: folder.to_owned(), out: out.to_owned(), address, token: TOKEN.to_owned(), device: None };
    let bench = Workbench::bind(options).expect("a free port");
    let server = Server { address: bench.address(), url: bench.url() };
    std::thread::spawn(move || bench.run());
    server
}

/// Returns the path of the bundled campaign.
pub fn bundled() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../data/campaigns/first-look")
}

/// Copies a folder.
pub fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).unwrap();
    for entry in fs::read_dir(from).unwrap() {
        let entry = entry.unwrap();
        let place = to.join(entry.file_name());
        if entry.file_type().unwrap().is_dir() {
            copy(&entry.path(), &place);
        } else {
            fs::copy(entry.path(), place).unwrap();
        }
    }
}
