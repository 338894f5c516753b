//! Damaged and truncated files give an error or a map, never a panic, and never use more memory than the bytes justify.

mod common;

use std::path::{Path, PathBuf};

use common::{encoders, sample};
use instruments::Misread;
use instruments::surface::{self, Source, Surface, Window};

/// Number of damaged copies of each file.
const DAMAGES: u64 = 400;
/// Number of lengths to which each file is truncated.
const CUTS: usize = 120;
/// Maximum number of pixels per byte of a sample; deflate compresses a thousand bytes into one.
const MOST_PIXELS_PER_BYTE: usize = 4000;

/// Every sample, from other programs or from an encoder of this crate.
fn samples() -> Vec<(PathBuf, Vec<u8>)> {
    let folder = sample("");
    let mut files: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.retain(|file| file.is_file() && file.extension().is_some_and(|extension| extension != "md"));
    files.sort();
    assert!(files.len() > 25);
    let mut samples: Vec<(PathBuf, Vec<u8>)> =
        files.into_iter().map(|file| (file.clone(), std::fs::read(file).unwrap())).collect();
    samples.extend(encoders::all().map(|(name, bytes)| (PathBuf::from(name), bytes)));
    samples
}

fn read(file: &Path, bytes: &[u8]) -> Result<Surface, Misread> {
    let found = surface::read(&Source { file, bytes, window: Window::default() });
    match &found {
        Ok(surface) => {
            assert_eq!(surface.heights.len(), surface.nx * surface.ny, "{}", file.display());
            assert!(surface.heights.len() <= bytes.len() * MOST_PIXELS_PER_BYTE, "{}", file.display());
        }
        Err(error) => assert!(error.to_string().starts_with(&file.display().to_string()), "{error}"),
    }
    found
}

/// A seeded stream of numbers (Steele, Lea, Flood 2014).
struct Stream(u64);

impl Stream {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut mixed = self.0;
        mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^ (mixed >> 31)
    }

    fn below(&mut self, end: usize) -> usize {
        (self.next() % end as u64) as usize
    }
}

#[test]
fn damaged_files_are_read_or_refused() {
    let mut refused = 0;
    for (file, bytes) in samples() {
        let mut stream = Stream(1);
        for damage in 0..DAMAGES {
            let mut damaged = bytes.clone();
            // Headers are at the start and, in zips, at the end; half of the damage falls there.
            let at = match damage % 4 {
                0 => stream.below(bytes.len().min(600)),
                1 => bytes.len() - 1 - stream.below(bytes.len().min(400)),
                _ => stream.below(bytes.len()),
            };
            let count = 1 + stream.below(8).min(bytes.len() - at - 1);
            for byte in &mut damaged[at..at + count] {
                *byte = [stream.next() as u8, 0, 0xff, 0x7f, b'9'][stream.below(5)];
            }
            refused += usize::from(read(&file, &damaged).is_err());
        }
    }
    assert!(refused > 1000, "{refused} were refused");
}

#[test]
fn shortened_files_are_read_or_refused() {
    for (file, bytes) in samples() {
        let step = (bytes.len() / CUTS).max(1);
        for length in (0..bytes.len()).step_by(step) {
            let _ = read(&file, &bytes[..length]);
        }
    }
}

/// A truncated binary file is refused; a text may end with any line.
#[test]
fn binary_files_cut_in_half_are_refused() {
    for (file, bytes) in samples() {
        let is_text = bytes.iter().all(|&c| c != 0);
        let half = read(&file, &bytes[..bytes.len() / 2]);
        assert!(is_text || half.is_err(), "{} cut in half is read as {:?}", file.display(), half.map(|map| map.format));
    }
}

#[test]
fn claims_that_the_bytes_do_not_justify_are_refused() {
    let mut sur = std::fs::read(sample("surfalize.sur")).unwrap();
    sur[108..116].copy_from_slice(&[0, 0x40, 0, 0, 0, 0x40, 0, 0]);
    let sdf =
        b"aISO-1.0\nNumPoints = 16384\nNumProfiles = 16384\nXscale = 1e-6\nYscale = 1e-6\nZscale = 1\n*\n1 2 3\n*\n";
    let npy = std::fs::read(sample("c_order.npy")).unwrap();
    let mut shape = npy.clone();
    let at = shape.windows(8).position(|word| word == b"(17, 24)").unwrap();
    shape[at..at + 8].copy_from_slice(b"(999,99)");
    let asc = b"ncols 16384\nnrows 16384\ncellsize 1\n1 2 3\n";
    for (name, bytes) in [("a.sur", &sur[..]), ("a.sdf", sdf), ("a.npy", &shape), ("a.asc", asc)] {
        let error = read(Path::new(name), bytes).unwrap_err().to_string();
        assert!(error.contains("expected"), "{error}");
    }
}
