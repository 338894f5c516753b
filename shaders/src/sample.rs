//! φ at a list of points on the device; host file of `sample.wgsl`.

use crate::brick_grid::{GridBuffers, GridError};
use crate::buffers::{binding_entry, binding_limit, pipeline, read, upload};
use crate::constants::WORKGROUP_SIZE;
use crate::device::{Device, DeviceFault};
use crate::fault::mib;
use crate::wgsl::SAMPLE;

/// Bytes of a point in its buffer.
const POINT_BYTES: u64 = size_of::<[f32; 4]>() as u64;
/// Bytes of a φ in its buffer.
const PHI_BYTES: u64 = size_of::<f32>() as u64;

/// Reason why points were not sampled.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SampleError {
    /// Header and arrays of the grid do not match.
    #[error(transparent)]
    Grid(#[from] GridError),
    /// An array is larger than the adapter can bind.
    #[error(
        "the {array} of this grid takes {} and {adapter} binds at most {}: use a larger voxel or --backend cpu",
        mib(bytes),
        mib(limit)
    )]
    TooLarge {
        /// `pool` or `index`.
        array: &'static str,
        /// Its size [bytes].
        bytes: u64,
        /// The largest binding [bytes].
        limit: u64,
        /// The adapter.
        adapter: String,
    },
    /// The device failed.
    #[error(transparent)]
    Device(#[from] DeviceFault),
}

/// A grid on the device, ready to be sampled.
#[derive(Debug)]
pub struct Sampler<'a> {
    device: &'a Device,
    pipeline: wgpu::ComputePipeline,
    header: wgpu::Buffer,
    index: wgpu::Buffer,
    phi: wgpu::Buffer,
}

impl<'a> Sampler<'a> {
    /// Uploads a grid and compiles the kernel.
    ///
    /// # Errors
    /// [`SampleError::Grid`] if header and arrays do not match, [`SampleError::TooLarge`] if an array exceeds the
    /// adapter's binding limit, [`SampleError::Device`] if the device fails.
    pub fn new(device: &'a Device, grid: &GridBuffers<'_>) -> Result<Self, SampleError> {
        grid.validate()?;
        check_size(device, "pool", grid.phi.len())?;
        check_size(device, "index", grid.index.len())?;
        let pipeline =
            device.guarded("compiling the kernel `sample`", |device| pipeline(device, SAMPLE.entry, SAMPLE.text()))?;
        let during = format!("uploading a grid of {}", mib(&(4 * (grid.index.len() + grid.phi.len()) as u64)));
        let sampler = device.guarded(&during, |_| Self {
            device,
            pipeline,
            header: upload(device, "grid header", bytemuck::bytes_of(&grid.header), wgpu::BufferUsages::UNIFORM),
            index: upload(device, "grid index", bytemuck::cast_slice(grid.index), wgpu::BufferUsages::STORAGE),
            phi: upload(device, "grid phi", bytemuck::cast_slice(grid.phi), wgpu::BufferUsages::STORAGE),
        });
        Ok(sampler?)
    }

    /// Samples φ [m] at points [m]: ±band beyond the band, NaN if a point is not finite. The fourth component of a
    /// point is ignored. Agrees with [`GridBuffers::sample_phi`] within rounding.
    ///
    /// # Errors
    /// [`SampleError::Device`] if the device fails.
    pub fn sample(&self, points: &[[f32; 4]]) -> Result<Vec<f32>, SampleError> {
        let mut phi = Vec::with_capacity(points.len());
        for chunk in points.chunks(self.points_per_dispatch()) {
            self.sample_chunk(chunk, &mut phi)?;
        }
        Ok(phi)
    }

    /// Maximum number of points for one dispatch and one binding.
    fn points_per_dispatch(&self) -> usize {
        let limits = self.device.device.limits();
        let by_groups = u64::from(limits.max_compute_workgroups_per_dimension) * u64::from(WORKGROUP_SIZE);
        by_groups.min(binding_limit(self.device) / POINT_BYTES) as usize
    }

    fn sample_chunk(&self, points: &[[f32; 4]], phi: &mut Vec<f32>) -> Result<(), DeviceFault> {
        let device = self.device;
        let read_back = device.guarded("sampling", |_| self.dispatch(points))?;
        phi.extend(read::<f32>(device, "reading the samples back", &read_back)?);
        Ok(())
    }

    /// Submits one dispatch; returns the buffer that will hold φ.
    fn dispatch(&self, points: &[[f32; 4]]) -> wgpu::Buffer {
        let Device { device, queue, .. } = self.device;
        let size = points.len() as u64 * PHI_BYTES;
        let buffer = |label, usage| {
            device.create_buffer(&wgpu::BufferDescriptor { label: Some(label), size, usage, mapped_at_creation: false })
        };
        let point_list = upload(self.device, "points", bytemuck::cast_slice(points), wgpu::BufferUsages::STORAGE);
        let phi = buffer("sampled phi", wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC);
        let read_back = buffer("sampled phi, read back", wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST);
        let bound = [&self.header, &self.index, &self.phi, &point_list, &phi];
        let entries: Vec<_> = (0..).zip(bound).map(|(binding, buffer)| binding_entry(binding, buffer)).collect();
        let bindings = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("sample bindings"),
            layout: &self.pipeline.get_bind_group_layout(0),
            entries: &entries,
        });
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("sample") });
        {
            let mut pass = encoder
                .begin_compute_pass(&wgpu::ComputePassDescriptor { label: Some("sample"), timestamp_writes: None });
            pass.set_pipeline(&self.pipeline);
            pass.set_bind_group(0, &bindings, &[]);
            pass.dispatch_workgroups((points.len() as u32).div_ceil(WORKGROUP_SIZE), 1, 1);
        }
        encoder.copy_buffer_to_buffer(&phi, 0, &read_back, 0, size);
        queue.submit([encoder.finish()]);
        read_back
    }
}

/// Refuses an array of 4-byte values that exceeds the device's binding limit.
fn check_size(device: &Device, array: &'static str, values: usize) -> Result<(), SampleError> {
    let bytes = values as u64 * 4;
    let limit = binding_limit(device);
    if bytes <= limit {
        return Ok(());
    }
    Err(SampleError::TooLarge { array, bytes, limit, adapter: device.adapter().to_string() })
}
