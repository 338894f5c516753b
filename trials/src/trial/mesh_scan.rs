//! STL and PLY surfaces as scans: looked at from above at the trial's pixels.

use std::path::Path;

use glam::{DVec2, DVec3};
use sdf_bake::read::{Format, UnitChoice, parse_mesh};
use sdf_bake::{HeightMap, PixelGrid};

use super::error::{Place, TrialError};
use super::scan::{Read, ScanFrame};

/// First bytes of a PLY file.
const PLY: &[u8] = b"ply";
/// Rounding that leaves a point on an edge inside [share of a triangle].
const ON_EDGE: f64 = 1e-9;
/// Part of a pixel by which a surface may miss the last one.
const LAST_PIXEL: f64 = 1e-6;
/// Pixels that a map may have.
const MOST_PIXELS: usize = 1 << 28;

/// The format of a surface, by its content and, as binary STL has no mark, its name; `None` for anything else.
pub(super) fn format(file: &Path, bytes: &[u8]) -> Option<Format> {
    let named = |extension: &str| file.extension().is_some_and(|own| own.eq_ignore_ascii_case(extension));
    if bytes.starts_with(PLY) || named("ply") {
        return Some(Format::Ply);
    }
    named("stl").then_some(Format::Stl)
}

/// Heights of a surface in millimetres at the pixels of a frame: the topmost point above each, missing where there is
/// none. Without a shape, the pixels reach from the frame's origin to the surface's end.
pub(super) fn read(file: &Path, bytes: &[u8], format: Format, frame: ScanFrame) -> Result<Read<HeightMap>, TrialError> {
    let place = || Place::file(file);
    let accepted = "an STL or PLY surface in mm is expected";
    let found = parse_mesh(bytes, format, UnitChoice::Millimetre, &file.to_string_lossy());
    let found = found.map_err(|error| place().bad(error.to_string(), accepted))?;
    let all = || found.mesh.positions.iter().map(|point| point.truncate());
    let low = all().fold(DVec2::INFINITY, DVec2::min);
    let high = all().fold(DVec2::NEG_INFINITY, DVec2::max);
    let last = (high - frame.origin) / frame.pitch + LAST_PIXEL;
    let beside = || {
        let (low, high, origin) = (low * 1e3, high * 1e3, frame.origin * 1e3);
        place().bad(
            format!("the surface spans x {:.2} to {:.2} mm, y {:.2} to {:.2} mm", low.x, high.x, low.y, high.y),
            format!("a surface over pixels from x {:.2} mm, y {:.2} mm on is expected", origin.x, origin.y),
        )
    };
    if !(last.cmpge(DVec2::ZERO).all() && last.max_element() < MOST_PIXELS as f64) {
        return Err(beside());
    }
    let (nx, ny) = frame.shape.unwrap_or((last.x as usize + 1, last.y as usize + 1));
    if nx.saturating_mul(ny) > MOST_PIXELS {
        return Err(place().bad(format!("{nx} x {ny} pixels"), format!("at most {MOST_PIXELS} are expected")));
    }
    let pixels = PixelGrid { origin: frame.origin, pitch: frame.pitch, nx, ny };
    let mut map = HeightMap { pixels, heights: vec![f64::NAN; pixels.len()] };
    for triangle in &found.mesh.triangles {
        cover(&mut map, triangle.map(|corner| found.mesh.positions[corner as usize]));
    }
    if map.missing() == map.heights.len() {
        return Err(beside());
    }
    let mut notes = vec![format!("a surface of {} triangles, looked at from above, in mm", found.mesh.triangles.len())];
    notes.extend(found.notes);
    Ok(Read { content: map, notes })
}

/// Raises the pixels under a triangle to it.
fn cover(map: &mut HeightMap, corners: [DVec3; 3]) {
    let pixels = map.pixels;
    let [a, b, c] = corners.map(|corner| pixels.coordinates(corner.truncate()));
    let doubled_area = (b - a).perp_dot(c - a);
    let low = a.min(b).min(c).ceil().max(DVec2::ZERO);
    let high = a.max(b).max(c).floor().min(DVec2::new(pixels.nx as f64 - 1.0, pixels.ny as f64 - 1.0));
    if doubled_area == 0.0 || !low.cmple(high).all() {
        return;
    }
    for j in low.y as usize..=high.y as usize {
        for i in low.x as usize..=high.x as usize {
            let at = DVec2::new(i as f64, j as f64);
            let shares = [(b, c), (c, a), (a, b)].map(|(p, q)| (p - at).perp_dot(q - at) / doubled_area);
            if shares.iter().all(|share| *share >= -ON_EDGE) {
                let height = shares.iter().zip(corners).map(|(share, corner)| share * corner.z).sum::<f64>();
                let pixel = &mut map.heights[j * pixels.nx + i];
                *pixel = pixel.max(height);
            }
        }
    }
}
