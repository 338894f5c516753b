//! The virtual scanner: scans of a true surface.
//!
//! `scan = quantised(faults(blurred(truth(q)) + marks) + white + correlated + piston + tilt · (p - centre))` at
//! `q = p - shift - turn z × (p - centre)`, then holes, an empty rim and spikes. Every scan has its own registration
//! error and its own noise, the repeated scan included.

use effects::RunError;
use glam::DVec2;
use sdf_bake::{BrickGrid, HeightMap, PixelGrid};
use sim::Profilometer;

use super::fault::Fault;
use super::noise::{correlated, streaked};
use random::Stream;
use trials::trial::ExposureMask;

/// Correlation lengths of grinding marks along and across the path [m].
const MARK_LENGTHS: [f64; 2] = [4e-3, 0.4e-3];
/// Removed depth above which a place counts as ground and has marks; more than lattice and tilt of a scan cause [m].
const MARKED_DEPTH: f64 = 5e-6;

/// Sizes of the scanner's errors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Instrument {
    /// Standard deviation of the lateral blur, a Gaussian [m].
    pub blur: f64,
    /// Step of the heights [m].
    pub quantum: f64,
    /// Noise that is independent between pixels, standard deviation [m].
    pub white: f64,
    /// Noise that is correlated between pixels, standard deviation [m].
    pub correlated: f64,
    /// Distance at which its correlation has fallen to 1/e [m].
    pub correlation_length: f64,
    /// Height offset of a scan, standard deviation [m].
    pub piston: f64,
    /// Tilt of a scan along x and y, standard deviation [1].
    pub tilt: f64,
    /// Lateral shift of a scan along x and y, standard deviation [m].
    pub shift: f64,
    /// Turn of a scan about z, standard deviation [rad].
    pub turn: f64,
    /// Least and greatest share of pixels that are missing in holes.
    pub holes: [f64; 2],
    /// Greatest radius of a hole [m].
    pub hole_radius: f64,
    /// Width of the empty rim of a height map [pixels].
    pub rim: usize,
    /// Share of pixels that are spikes.
    pub spikes: f64,
    /// Least and greatest height of a spike, up or down [m].
    pub spike_height: [f64; 2],
    /// Blur of the exposed border, standard deviation [m]; sanding only.
    pub border_blur: f64,
    /// Noise of the dose at the exposed border, correlated over `correlation_length` [1]; sanding only.
    pub border_noise: f64,
    /// Half width of the dose interval around the threshold in which the optics are undecided [1]; sanding only.
    pub undecided: f64,
    /// Grinding marks along the path in the tool's track, drawn again after each pass, root mean square [m]; grinding
    /// only.
    pub marks: f64,
}

impl Instrument {
    /// A good instrument and a careful operator (benchmark family N0).
    pub fn clean() -> Self {
        Self {
            blur: 30e-6,
            quantum: 1e-6,
            white: 2e-6,
            correlated: 2e-6,
            correlation_length: 2e-3,
            piston: 10e-6,
            tilt: 1e-4,
            shift: 5e-6,
            turn: 0.0,
            holes: [0.008, 0.012],
            hole_radius: 0.8e-3,
            rim: 1,
            spikes: 2e-3,
            spike_height: [40e-6, 400e-6],
            border_blur: 0.2e-3,
            border_noise: 0.01,
            undecided: 0.005,
            marks: 0.0,
        }
    }

    /// Shiny surfaces, re-fixtured after every pass: larger errors of every kind (benchmark family N1).
    pub fn hard() -> Self {
        Self {
            blur: 80e-6,
            white: 3e-6,
            correlated: 4e-6,
            piston: 20e-6,
            tilt: 2e-4,
            shift: 20e-6,
            holes: [0.05, 0.2],
            hole_radius: 1.5e-3,
            spikes: 1e-2,
            border_blur: 0.4e-3,
            border_noise: 0.03,
            undecided: 0.02,
            ..Self::clean()
        }
    }

    /// A good instrument on surfaces with texture: grinding marks, and a coating like orange peel.
    pub fn textured() -> Self {
        Self { marks: 4e-6, border_noise: 0.03, ..Self::clean() }
    }

    /// A good instrument under which the part is clamped again for each scan.
    pub fn clamped() -> Self {
        Self { shift: 20e-6, turn: 2e-3, ..Self::clean() }
    }

    /// Root mean square of one scan's noise without spikes [m].
    pub fn noise(&self) -> f64 {
        // The variance of rounding is a twelfth of the squared step.
        (self.white.powi(2) + self.correlated.powi(2) + self.quantum.powi(2) / 12.0).sqrt()
    }

    /// Scans the heights of a part.
    ///
    /// # Errors
    /// If a formula of the fault gives no finite number.
    pub(super) fn heights(
        &self,
        part: &BrickGrid,
        pixels: PixelGrid,
        fault: Option<Fault>,
        stream: &mut Stream,
    ) -> Result<HeightMap, RunError> {
        let profilometer = self.profilometer(pixels, self.blur, stream);
        let (placed, seen) = (profilometer.pixels, profilometer.heights(part));
        let mut map = HeightMap { pixels, ..seen };
        if let Some(mut fault) = fault {
            self.mark(&mut map, placed, &mut fault);
            map.heights = fault.of(&map, part, placed)?;
        }
        self.disturb(&mut map, stream);
        self.drop(&mut map, stream);
        Ok(map)
    }

    /// Scans a mask of the exposed substrate.
    ///
    /// - `threshold`: dose from which the substrate counts as exposed
    pub(super) fn mask(
        &self,
        part: &BrickGrid,
        pixels: PixelGrid,
        threshold: f64,
        stream: &mut Stream,
    ) -> ExposureMask {
        let doses = self.profilometer(pixels, self.border_blur, stream).channel(part, &part.dose);
        let noise = correlated((pixels.nx, pixels.ny), self.correlation_length / pixels.pitch, stream);
        let holes = self.holes(&pixels, stream);
        let exposed = (0..pixels.len()).map(|k| {
            let dose = doses[k] + self.border_noise * noise[k];
            let is_decided = !holes[k] && (dose - threshold).abs() > self.undecided;
            is_decided.then_some(dose >= threshold)
        });
        ExposureMask { pixels, exposed: exposed.collect() }
    }

    /// The optics above a part that lies shifted and turned under them.
    fn profilometer(&self, pixels: PixelGrid, blur: f64, stream: &mut Stream) -> Profilometer {
        let shift = self.shift * DVec2::new(stream.normal(), stream.normal());
        // An instrument without turn draws no number for it.
        let turn = if self.turn > 0.0 { self.turn * stream.normal() } else { 0.0 };
        Profilometer { pixels: PixelGrid { origin: pixels.origin - shift, ..pixels }, turn: -turn, blur }
    }

    /// Adds noise, offset and tilt; rounds.
    fn disturb(&self, map: &mut HeightMap, stream: &mut Stream) {
        let PixelGrid { pitch, nx, ny, .. } = map.pixels;
        let shared = correlated((nx, ny), self.correlation_length / pitch, stream);
        let piston = self.piston * stream.normal();
        let tilt = self.tilt * DVec2::new(stream.normal(), stream.normal());
        let centre = 0.5 * (map.pixels.position(0, 0) + map.pixels.position(nx - 1, ny - 1));
        for (k, height) in map.heights.iter_mut().enumerate() {
            let place = map.pixels.position(k % nx, k / nx) - centre;
            *height += piston + tilt.dot(place) + self.white * stream.normal() + self.correlated * shared[k];
            *height = (*height / self.quantum).round() * self.quantum;
        }
    }

    /// Adds the marks of the last pass in the tool's track.
    ///
    /// - `placed`: true positions of the pixels
    fn mark(&self, map: &mut HeightMap, placed: PixelGrid, fault: &mut Fault) {
        if self.marks == 0.0 {
            return;
        }
        let PixelGrid { pitch, nx, ny, .. } = placed;
        let marks = streaked((nx, ny), MARK_LENGTHS.map(|length| length / pitch), &mut fault.marks);
        for (k, height) in map.heights.iter_mut().enumerate() {
            let depth = fault.piece.height(placed.position(k % nx, k / nx)) - *height;
            if depth > MARKED_DEPTH {
                *height += self.marks * marks[k];
            }
        }
    }

    /// Removes the pixels of holes and rim, and adds spikes.
    fn drop(&self, map: &mut HeightMap, stream: &mut Stream) {
        let PixelGrid { nx, ny, .. } = map.pixels;
        let holes = self.holes(&map.pixels, stream);
        let on_rim = |k: usize| (k % nx).min(nx - 1 - k % nx).min(k / nx).min(ny - 1 - k / nx) < self.rim;
        for (k, height) in map.heights.iter_mut().enumerate() {
            if stream.happens(self.spikes) {
                let spike = stream.ratio_between(self.spike_height);
                *height += if stream.happens(0.5) { spike } else { -spike };
                *height = (*height / self.quantum).round() * self.quantum;
            }
            if holes[k] || on_rim(k) {
                *height = f64::NAN;
            }
        }
    }

    /// Draws holes, discs of random size, until their share is reached; true for each pixel in a hole.
    fn holes(&self, pixels: &PixelGrid, stream: &mut Stream) -> Vec<bool> {
        let PixelGrid { pitch, nx, ny, .. } = *pixels;
        let goal = (stream.between(self.holes) * pixels.len() as f64) as usize;
        let mut missing = vec![false; pixels.len()];
        let mut count = 0;
        while count < goal {
            let centre = DVec2::new(stream.between([0.0, nx as f64]), stream.between([0.0, ny as f64]));
            // Small holes are the most frequent.
            let radius = stream.ratio_between([0.5 * pitch, self.hole_radius.max(pitch)]) / pitch;
            let low = (centre - radius).max(DVec2::ZERO).ceil();
            let high = (centre + radius).min(DVec2::new(nx as f64 - 1.0, ny as f64 - 1.0));
            for j in low.y as usize..=high.y.max(0.0) as usize {
                for i in low.x as usize..=high.x.max(0.0) as usize {
                    let within = i < nx && j < ny && DVec2::new(i as f64, j as f64).distance(centre) <= radius;
                    if within && count < goal && !std::mem::replace(&mut missing[pixels.at(i, j)], true) {
                        count += 1;
                    }
                }
            }
        }
        missing
    }
}
