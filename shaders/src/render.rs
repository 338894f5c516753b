//! Pictures of a part on the device; host file of `render.wgsl` and `occupancy.wgsl`.

use crate::brick_grid::{GridBuffers, GridError};
use crate::buffers::{binding_entry, binding_limit, pipeline, read, upload};
use crate::constants::WORKGROUP_SIZE;
use crate::device::{Device, DeviceFault};
use crate::fault::mib;
use crate::stage::RenderStage;
use crate::wgsl::{Kernel, OCCUPANCY, RENDER};

/// Rows of four values per pixel: colour and depth [m]; normal and dose; position [m] and removed depth [m]; weld id
/// and visible object (`SEEN_BACKGROUND`, `SEEN_PART` or `SEEN_TABLE`).
pub const ROWS_PER_PIXEL: usize = 4;
/// Pixels along a side of a workgroup's tile.
const TILE: u32 = 8;
const _: () = assert!(TILE * TILE == WORKGROUP_SIZE, "a tile is not a workgroup");

/// A part as the device draws it: φ and the visible channels.
#[derive(Clone, Copy, Debug)]
pub struct PartChannels<'a> {
    /// φ and its brick index.
    pub grid: GridBuffers<'a>,
    /// Weld id of each voxel, shape `[bricks, 512]`; empty for none.
    pub label: &'a [u16],
    /// Coating dose D, shape `[bricks, 512]`; empty for none.
    pub dose: &'a [f32],
    /// Removed depth [m], shape `[bricks, 512]`; empty for none.
    pub removed: &'a [f32],
}

/// Reason why no picture was made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RenderError {
    /// The scene has a feature that the kernels lack.
    #[error("{feature} is photographed on the CPU only: use --backend cpu")]
    OnlyOnTheCpu {
        /// The feature, with its article.
        feature: &'static str,
    },
    /// Header and arrays of the grid do not match.
    #[error(transparent)]
    Grid(#[from] GridError),
    /// A channel has a different size from φ.
    #[error("the channel `{channel}` has {found} values for {expected} of phi")]
    Channel {
        /// `label`, `dose` or `removed`.
        channel: &'static str,
        /// Values given.
        found: usize,
        /// Values of φ.
        expected: usize,
    },
    /// An array is larger than the adapter can bind.
    #[error(
        "the {array} takes {} and {adapter} binds at most {}: use {instead} or --backend cpu",
        mib(bytes),
        mib(limit)
    )]
    TooLarge {
        /// Name of the array.
        array: &'static str,
        /// Its size [bytes].
        bytes: u64,
        /// The largest binding [bytes].
        limit: u64,
        /// The adapter.
        adapter: String,
        /// Remedy: a smaller input.
        instead: &'static str,
    },
    /// The device failed.
    #[error(transparent)]
    Device(#[from] DeviceFault),
}

/// The compiled kernels.
#[derive(Debug)]
pub struct Renderer<'a> {
    device: &'a Device,
    occupancy: wgpu::ComputePipeline,
    render: wgpu::ComputePipeline,
}

/// A part on the device.
#[derive(Debug)]
pub struct PartBuffers {
    entries: u32,
    header: wgpu::Buffer,
    index: wgpu::Buffer,
    phi: wgpu::Buffer,
    blocks: wgpu::Buffer,
    label: wgpu::Buffer,
    dose: wgpu::Buffer,
    removed: wgpu::Buffer,
}

/// A picture on the device.
#[derive(Debug)]
pub struct Drawn {
    pixels: wgpu::Buffer,
    bytes: u64,
}

impl<'a> Renderer<'a> {
    /// Compiles the kernels.
    ///
    /// # Errors
    /// [`DeviceFault`] if the driver refuses one.
    pub fn new(device: &'a Device) -> Result<Self, DeviceFault> {
        let compiled = |kernel: Kernel| {
            device.guarded(&format!("compiling the kernel `{}`", kernel.entry), |device| {
                pipeline(device, kernel.entry, kernel.text())
            })
        };
        Ok(Self { device, occupancy: compiled(OCCUPANCY)?, render: compiled(RENDER)? })
    }

    /// Uploads a part.
    ///
    /// # Errors
    /// [`RenderError`] if arrays do not match or exceed the adapter's binding limit, or the device fails.
    pub fn load(&self, part: &PartChannels<'_>) -> Result<PartBuffers, RenderError> {
        part.grid.validate()?;
        let values = part.grid.phi.len();
        for (channel, found) in
            [("label", part.label.len()), ("dose", part.dose.len()), ("removed", part.removed.len())]
        {
            if found != 0 && found != values {
                return Err(RenderError::Channel { channel, found, expected: values });
            }
        }
        self.check_size("pool of this grid", 4 * values as u64, "a larger voxel")?;
        self.check_size("index of this grid", 4 * part.grid.index.len() as u64, "a larger voxel")?;
        // The number of weld ids is even: a brick has 512.
        let label: Vec<u32> = part.label.chunks(2).map(|two| u32::from(two[0]) | u32::from(two[1]) << 16).collect();
        // At least one entry, because an empty array cannot be bound.
        let blocks = vec![0u8; 8 * part.grid.header.bricks.max(1) as usize];
        let storage = wgpu::BufferUsages::STORAGE;
        let channels =
            [4 * values, 4 * part.grid.index.len(), 4 * label.len(), 4 * part.dose.len(), 4 * part.removed.len()];
        let during = format!("uploading a part of {}", mib(&(channels.iter().sum::<usize>() as u64)));
        let loaded = self.device.guarded(&during, |device| PartBuffers {
            entries: part.grid.index.len() as u32,
            header: uniform(device, "grid header", &part.grid.header),
            index: upload(device, "grid index", bytemuck::cast_slice(part.grid.index), storage),
            phi: upload(device, "grid phi", bytemuck::cast_slice(part.grid.phi), storage),
            blocks: upload(device, "grid blocks", &blocks, storage),
            label: upload(device, "grid label", bytemuck::cast_slice(&label), storage),
            dose: upload(device, "grid dose", bytemuck::cast_slice(part.dose), storage),
            removed: upload(device, "grid removed", bytemuck::cast_slice(part.removed), storage),
        });
        Ok(loaded?)
    }

    /// Submits the work for one picture; nothing is read back.
    ///
    /// `rows`: two for each lamp (unit direction towards it and spread; irradiance), then two for each point of the
    /// marks' path (position [m] and arc length [m]; unit direction of motion).
    ///
    /// # Errors
    /// [`RenderError`] if the picture exceeds the adapter's binding limit or the device fails.
    pub fn draw(&self, part: &PartBuffers, stage: &RenderStage, rows: &[[f32; 4]]) -> Result<Drawn, RenderError> {
        let bytes = u64::from(stage.width) * u64::from(stage.height) * (ROWS_PER_PIXEL * size_of::<[f32; 4]>()) as u64;
        self.check_size("picture", bytes, "a smaller --size")?;
        let drawn = self.device.guarded(&format!("drawing a picture of {}", mib(&bytes)), |device| {
            let pixels = device.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("pixels"),
                size: bytes.max(16),
                usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC,
                mapped_at_creation: false,
            });
            let stage_buffer = uniform(device, "stage", stage);
            let rows = upload(device, "rows", bytemuck::cast_slice(rows), wgpu::BufferUsages::STORAGE);
            let mut encoder =
                device.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("picture") });
            let first = [&part.header, &part.index, &part.phi, &part.blocks];
            pass(device, &mut encoder, (OCCUPANCY, &self.occupancy), &first, groups(device, part.entries));
            let second = [
                &part.header,
                &stage_buffer,
                &part.index,
                &part.phi,
                &part.blocks,
                &part.label,
                &part.dose,
                &part.removed,
                &rows,
                &pixels,
            ];
            let tiles = (stage.width.div_ceil(TILE), stage.height.div_ceil(TILE));
            pass(device, &mut encoder, (RENDER, &self.render), &second, tiles);
            device.queue.submit([encoder.finish()]);
            Drawn { pixels, bytes }
        });
        Ok(drawn?)
    }

    /// Reads a picture back: [`ROWS_PER_PIXEL`] rows for each pixel, row by row from the top left.
    ///
    /// # Errors
    /// [`DeviceFault`] if the device fails.
    pub fn read(&self, drawn: &Drawn) -> Result<Vec<[f32; 4]>, DeviceFault> {
        let device = self.device;
        let during = "reading a picture back";
        let copy = device.guarded(during, |device| {
            let copy = device.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("pixels, read back"),
                size: drawn.bytes.max(16),
                usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            });
            let mut encoder =
                device.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("read back") });
            encoder.copy_buffer_to_buffer(&drawn.pixels, 0, &copy, 0, drawn.bytes);
            device.queue.submit([encoder.finish()]);
            copy
        })?;
        let values: Vec<[f32; 4]> = read(device, during, &copy)?;
        Ok(values[..drawn.bytes as usize / 16].to_vec())
    }

    /// Waits until all submitted work is done.
    ///
    /// # Errors
    /// [`DeviceFault`] if the device fails.
    pub fn wait(&self) -> Result<(), DeviceFault> {
        let done = self.device.device.poll(wgpu::PollType::wait_indefinitely());
        done.map(drop).map_err(|error| self.device.fault("drawing", &error))
    }

    fn check_size(&self, array: &'static str, bytes: u64, instead: &'static str) -> Result<(), RenderError> {
        let limit = binding_limit(self.device);
        if bytes <= limit {
            return Ok(());
        }
        Err(RenderError::TooLarge { array, bytes, limit, adapter: self.device.adapter().to_string(), instead })
    }
}

/// Numbers of workgroups along two axes, for at least `count` in all, each within the limit of one axis.
fn groups(device: &Device, count: u32) -> (u32, u32) {
    let most = device.device.limits().max_compute_workgroups_per_dimension;
    let rows = count.div_ceil(most).max(1);
    (count.div_ceil(rows), rows)
}

fn uniform<T: bytemuck::Pod>(device: &Device, label: &str, value: &T) -> wgpu::Buffer {
    upload(device, label, bytemuck::bytes_of(value), wgpu::BufferUsages::UNIFORM)
}

fn pass(
    device: &Device,
    encoder: &mut wgpu::CommandEncoder,
    (kernel, pipeline): (Kernel, &wgpu::ComputePipeline),
    bound: &[&wgpu::Buffer],
    (x, y): (u32, u32),
) {
    let entries: Vec<_> = (0..).zip(bound).map(|(binding, buffer)| binding_entry(binding, buffer)).collect();
    let bindings = device.device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some(kernel.entry),
        layout: &pipeline.get_bind_group_layout(0),
        entries: &entries,
    });
    let descriptor = wgpu::ComputePassDescriptor { label: Some(kernel.entry), timestamp_writes: None };
    let mut pass = encoder.begin_compute_pass(&descriptor);
    pass.set_pipeline(pipeline);
    pass.set_bind_group(0, &bindings, &[]);
    pass.dispatch_workgroups(x, y, 1);
}
