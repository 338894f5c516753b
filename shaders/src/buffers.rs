//! Buffers on the device: creation, binding, read-back.

use crate::device::{Device, DeviceFault};

/// Bytes that an upload or a read-back copies at once. It limits the staging memory, which otherwise would be as large
/// as the array itself.
pub(crate) const STAGED: usize = 32 << 20;

/// The largest storage buffer a kernel can bind [bytes].
pub(crate) fn binding_limit(device: &Device) -> u64 {
    let limits = device.device.limits();
    limits.max_storage_buffer_binding_size.min(limits.max_buffer_size)
}

pub(crate) fn binding_entry(binding: u32, buffer: &wgpu::Buffer) -> wgpu::BindGroupEntry<'_> {
    wgpu::BindGroupEntry { binding, resource: buffer.as_entire_binding() }
}

/// A buffer of zeros that can be copied to and from. It has at least four bytes, because an empty buffer cannot be
/// bound.
pub(crate) fn zeros(device: &Device, label: &str, bytes: u64, usage: wgpu::BufferUsages) -> wgpu::Buffer {
    let both_ways = wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC;
    device.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(label),
        size: bytes.max(4),
        usage: usage | both_ways,
        mapped_at_creation: false,
    })
}

/// A buffer that holds `bytes`.
pub(crate) fn upload(device: &Device, label: &str, bytes: &[u8], usage: wgpu::BufferUsages) -> wgpu::Buffer {
    let buffer = zeros(device, label, bytes.len() as u64, usage);
    write(device, &buffer, bytes);
    buffer
}

/// Fills a buffer from its beginning.
pub(crate) fn write(device: &Device, buffer: &wgpu::Buffer, bytes: &[u8]) {
    for (first, chunk) in (0..).step_by(STAGED).zip(bytes.chunks(STAGED)) {
        device.queue.write_buffer(buffer, first, chunk);
        if chunk.len() == STAGED {
            device.queue.submit([]);
            // Frees the staging memory; if the device fails here, the next operation reports it.
            let _ = device.device.poll(wgpu::PollType::wait_indefinitely());
        }
    }
}

/// Compiles a kernel from its text.
pub(crate) fn pipeline(device: &Device, entry: &str, text: String) -> wgpu::ComputePipeline {
    pipeline_in(device, entry, text, None)
}

/// The same with bindings shared by several kernels.
pub(crate) fn pipeline_in(
    device: &Device,
    entry: &str,
    text: String,
    bindings: Option<&wgpu::BindGroupLayout>,
) -> wgpu::ComputePipeline {
    let source = wgpu::ShaderSource::Wgsl(text.into());
    let module = device.device.create_shader_module(wgpu::ShaderModuleDescriptor { label: Some(entry), source });
    let layout = bindings.map(|bindings| {
        device.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some(entry),
            bind_group_layouts: &[Some(bindings)],
            immediate_size: 0,
        })
    });
    device.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some(entry),
        layout: layout.as_ref(),
        module: &module,
        entry_point: Some(entry),
        compilation_options: wgpu::PipelineCompilationOptions::default(),
        cache: None,
    })
}

/// Waits for the device and returns the content of `buffer`, which must be mappable.
pub(crate) fn read<T: bytemuck::Pod>(
    device: &Device,
    during: &str,
    buffer: &wgpu::Buffer,
) -> Result<Vec<T>, DeviceFault> {
    let mapped = device.guarded(during, |device| map(device, buffer))?;
    let bytes = mapped.map_err(|error| device.fault(during, error.as_ref()))?;
    Ok(bytes.chunks_exact(size_of::<T>()).map(bytemuck::pod_read_unaligned::<T>).collect())
}

/// Waits for the device and maps a buffer.
fn map(device: &Device, buffer: &wgpu::Buffer) -> Result<wgpu::BufferView, Box<dyn std::error::Error>> {
    let (sender, receiver) = std::sync::mpsc::channel();
    // The receiver outlives the wait below, so sending cannot fail.
    buffer.map_async(wgpu::MapMode::Read, .., move |outcome| drop(sender.send(outcome)));
    device.device.poll(wgpu::PollType::wait_indefinitely())?;
    receiver.recv()??;
    Ok(buffer.get_mapped_range(..)?)
}
