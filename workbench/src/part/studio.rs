//! Photographs on a device: a thread owns its kernels and the last field that was loaded.

use std::io;
use std::sync::{Arc, mpsc};
use std::thread;

use render::{Camera, Frame, Photographer, Raster, Scene};
use sdf_bake::BrickGrid;
use shaders::Device;

use crate::error::Refusal;

/// A device that takes photographs. Its thread ends when this is dropped.
pub(crate) struct Studio {
    orders: mpsc::Sender<Order>,
}

/// A photograph to take.
struct Order {
    field: Arc<BrickGrid>,
    camera: Camera,
    raster: Raster,
    reply: mpsc::Sender<Result<Frame, String>>,
}

impl Studio {
    /// Starts the thread of a device.
    ///
    /// # Errors
    /// If the system cannot start a thread.
    pub(crate) fn on(device: Device) -> io::Result<Self> {
        let (orders, received) = mpsc::channel();
        thread::Builder::new().name("studio".into()).spawn(move || serve(&device, &received))?;
        Ok(Self { orders })
    }

    /// Takes the photograph of a field that [`Scene::photograph`] takes on the CPU.
    ///
    /// # Errors
    /// If the field does not fit on the device, or the device fails.
    pub(super) fn photograph(&self, field: Arc<BrickGrid>, camera: Camera, raster: Raster) -> Result<Frame, Refusal> {
        let (reply, answer) = mpsc::channel();
        let lost = || Refusal::wrong("the device ended; --backend cpu draws without it");
        self.orders.send(Order { field, camera, raster, reply }).map_err(|_| lost())?;
        answer.recv().map_err(|_| lost())?.map_err(|words| Refusal::wrong(format!("the device: {words}")))
    }
}

fn serve(device: &Device, orders: &mpsc::Receiver<Order>) {
    let photographer = Photographer::new(device).map_err(|fault| fault.to_string());
    let mut loaded = None;
    for Order { field, camera, raster, reply } in orders {
        let photograph = |photographer: &Photographer<'_>| {
            let known = loaded.take().filter(|(own, _)| Arc::ptr_eq(own, &field));
            let (_, buffers) = match known {
                Some(known) => loaded.insert(known),
                None => loaded.insert((field.clone(), photographer.load(&field).map_err(|error| error.to_string())?)),
            };
            let taken = photographer.photograph(buffers, &Scene::new(&field), &camera, &raster);
            taken.map_err(|error| error.to_string())
        };
        let taken = photographer.as_ref().map_err(Clone::clone).and_then(photograph);
        // A page that was closed does not wait for its picture.
        let _gone = reply.send(taken);
    }
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use glam::DVec3;
    use shaders::device::{BackendChoice, open};

    use super::*;

    #[test]
    fn a_device_takes_the_photograph_of_the_cpu() {
        let device = match open(BackendChoice::Gpu) {
            Ok(opened) => opened.device.expect("gpu was chosen"),
            Err(error) => {
                let promised = std::env::var_os("ROBOFIN_REQUIRE_GPU").is_some_and(|value| value == "1");
                assert!(!promised, "ROBOFIN_REQUIRE_GPU=1, but no device opens: {error}");
                writeln!(io::stderr(), "NOT TESTED: photographs on a device: {error}").unwrap();
                return;
            }
        };
        let studio = Studio::on(device).unwrap();
        let raster = Raster { width: 64, height: 48, samples_per_side: 1 };
        for radius in [0.01, 0.008, 0.01] {
            let half = DVec3::splat(0.011);
            let ball = Arc::new(BrickGrid::from_distance(-half, half, 0.5e-3, 3.0, |p| p.length() - radius));
            let camera = Camera::framing(-half, half, -0.9, 0.6, 4.0 / 3.0);
            let expected = Scene::new(&ball).photograph(&camera, &raster).to_srgb8();
            let found = studio.photograph(ball, camera, raster).unwrap().to_srgb8();
            let far = expected.rgb.iter().zip(&found.rgb).filter(|(a, b)| a.abs_diff(**b) > 2).count();
            assert!(far * 1000 < expected.rgb.len(), "{far} of {} values differ", expected.rgb.len());
        }
    }
}
