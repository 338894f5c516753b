//! Prints the reading time of a map with a million pixels in each format: `cargo run --release --example timings`.

use std::fmt::Write as _;
use std::path::Path;
use std::time::Instant;

use glam::DVec2;
use instruments::surface::{self, Source, Surface, Window, write};

/// Pixels along each side.
const SIDE: usize = 1000;

fn height(i: usize, j: usize) -> f64 {
    let (i, j) = (i as f64, j as f64);
    1e-6 * (0.3 * i + 0.5 * j + 20.0 * (0.07 * i).sin())
}

fn map() -> Surface {
    let heights = (0..SIDE * SIDE).map(|at| height(at % SIDE, at / SIDE)).collect();
    let pitch = Some(DVec2::splat(5e-6));
    Surface { format: "X3P", nx: SIDE, ny: SIDE, pitch, origin: None, heights, notes: Vec::new() }
}

/// A text with one cell per pixel.
fn text(header: &str, cell: impl Fn(&mut String, usize, usize)) -> Vec<u8> {
    let mut text = header.to_owned();
    for j in 0..SIDE {
        for i in 0..SIDE {
            cell(&mut text, i, j);
        }
        text.push('\n');
    }
    text.into_bytes()
}

fn points(separator: &str, jitter: f64) -> Vec<u8> {
    text("", |text, i, j| {
        let shift = jitter * ((i * 7919 + j * 104_729) % 1000) as f64;
        let (x, y) = (i as f64 * 0.005 + shift, j as f64 * 0.005 - shift);
        let _ = writeln!(text, "{x:.6}{separator}{y:.6}{separator}{:.6}", height(i, j) * 1e3);
    })
}

fn grid(header: &str, separator: char) -> Vec<u8> {
    text(header, |text, i, j| {
        let end = if i + 1 < SIDE { separator.to_string() } else { String::new() };
        let _ = write!(text, "{:.6}{end}", height(i, j) * 1e3);
    })
}

fn npy() -> Vec<u8> {
    let header = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({SIDE}, {SIDE}), }}");
    let mut bytes = b"\x93NUMPY\x01\0".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.as_bytes());
    bytes.extend(map().heights.iter().flat_map(|height| (height * 1e3).to_le_bytes()));
    bytes
}

fn pcd() -> Vec<u8> {
    let count = SIDE * SIDE;
    let mut bytes = format!(
        "VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH {count}\nHEIGHT 1\nPOINTS {count}\n\
         DATA binary\n"
    )
    .into_bytes();
    for at in 0..count {
        let (i, j) = (at % SIDE, at / SIDE);
        for value in [i as f64 * 0.005, j as f64 * 0.005, height(i, j) * 1e3] {
            bytes.extend((value as f32).to_le_bytes());
        }
    }
    bytes
}

fn main() {
    let map = map();
    let written = |name: &str| write(Path::new(name), &map).expect("the map has heights and a pitch");
    let sdf = format!(
        "aISO-1.0\nNumPoints = {SIDE}\nNumProfiles = {SIDE}\nXscale = 5e-6\nYscale = 5e-6\nZscale = 1e-3\nDataType = 7\n*\n"
    );
    let mut sdf = grid(&sdf, ' ');
    sdf.extend(b"*\n");
    for (name, bytes) in [
        ("map.sur", written("map.sur")),
        ("map.x3p", written("map.x3p")),
        ("map.asc", written("map.asc")),
        ("map.sdf", sdf),
        ("gwyddion.txt", grid("# Channel: z\n# Width: 5 mm\n# Height: 5 mm\n# Value units: mm\n", '\t')),
        ("grid.csv", grid("", ',')),
        ("grid.txt", grid("", ' ')),
        ("points.csv", points(",", 0.0)),
        ("points.xyz", points(" ", 0.0)),
        ("cloud.xyz", points(" ", 1e-6)),
        ("map.npy", npy()),
        ("points.pcd", pcd()),
    ] {
        let start = Instant::now();
        let found = surface::read(&Source { file: Path::new(name), bytes: &bytes, window: Window::default() });
        let found = found.map(|map| format!("{}, {} x {}", map.format, map.nx, map.ny));
        let seconds = start.elapsed().as_secs_f64();
        println!("{name:12} {:6.1} MB {seconds:6.3} s  {found:?}", bytes.len() as f64 * 1e-6);
    }
    for folder in std::env::args().skip(1) {
        for file in std::fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path()) {
            let Ok(bytes) = std::fs::read(&file) else { continue };
            let start = Instant::now();
            let found = surface::read(&Source { file: &file, bytes: &bytes, window: Window::default() });
            let found = found.map(|map| format!("{}, {} x {}", map.format, map.nx, map.ny));
            let seconds = start.elapsed().as_secs_f64();
            println!("{} {:6.1} MB {seconds:6.3} s  {found:?}", file.display(), bytes.len() as f64 * 1e-6);
        }
    }
}
