//! A batch in progress: submissions, reallocation, and read-back of the results.

use super::{
    Chunk, DeviceFault, Running, STATUS_NEEDS_BRICKS, STATUS_NEEDS_COLUMNS, STATUS_RUNNING, STORAGE, SimulateError,
    TrialCapacity, TrialResults, TrialState, WORD, binding_entry, check, entries, lay_out, mib, read, sizes, zeros,
};
use crate::buffers::STAGED;
use crate::constants::{BRICK_VOXELS, COLUMN_ARRAYS, INSIDE};
use crate::layout::{LogRecord, TrialSetup};

/// A range of a buffer to be copied: from, to, length [words].
type Stretch = (u64, u64, u64);

impl Running<'_> {
    /// The setups as currently stored in the buffers.
    pub fn setups(&self) -> &[TrialSetup] {
        &self.setups
    }

    /// Current memory of each trial.
    pub fn capacity(&self) -> TrialCapacity {
        self.capacity
    }

    /// Runs one submission: [`TrialCapacity::ticks`] phases of each trial, without read-back in between. Then allocates
    /// more memory if a trial needs it.
    ///
    /// # Errors
    /// [`SimulateError::TooLarge`] if no more memory can be allocated, [`SimulateError::Device`] if the device fails.
    pub fn advance(&mut self) -> Result<Chunk, SimulateError> {
        let device = self.simulator.device;
        let (states, rows) = device.guarded("simulating", |_| self.submit())?;
        let chunk = Chunk {
            states: read(device, "reading the states back", &states)?,
            rows: read::<LogRecord>(device, "reading the logs back", &rows)?,
        };
        self.make_room(&chunk.states)?;
        Ok(chunk)
    }

    /// Submits the dispatches and the copies for read-back.
    fn submit(&self) -> (wgpu::Buffer, wgpu::Buffer) {
        let device = self.simulator.device;
        let buffers = &self.buffers;
        let bound = [
            &buffers.header,
            &buffers.setups,
            &buffers.states,
            &buffers.index,
            &buffers.pool,
            &buffers.columns,
            &buffers.path,
            &buffers.log,
            &buffers.values,
        ];
        let entries: Vec<_> = (0..).zip(bound).map(|(binding, buffer)| binding_entry(binding, buffer)).collect();
        let bindings = device.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("simulate bindings"),
            layout: &self.simulator.kernels.layout,
            entries: &entries,
        });
        let mut encoder = encoder(device);
        {
            let mut pass = encoder
                .begin_compute_pass(&wgpu::ComputePassDescriptor { label: Some("simulate"), timestamp_writes: None });
            pass.set_bind_group(0, &bindings, &[]);
            for pipeline in (0..self.capacity.ticks).flat_map(|_| &self.simulator.kernels.pipelines) {
                pass.set_pipeline(pipeline);
                pass.dispatch_workgroups(self.setups.len() as u32, 1, 1);
            }
        }
        let states = copy_out(device, &mut encoder, &buffers.states);
        let rows = copy_out(device, &mut encoder, &buffers.log);
        device.queue.submit([encoder.finish()]);
        (states, rows)
    }

    /// Allocates memory for the trials that stopped for lack of it, and resumes them.
    fn make_room(&mut self, states: &[TrialState]) -> Result<(), SimulateError> {
        let needed = |status: u32| states.iter().filter(|state| state.status == status).map(|state| state.needed).max();
        let mut capacity = self.capacity;
        if let Some(bricks) = needed(STATUS_NEEDS_BRICKS) {
            capacity.bricks = bricks.max(2 * capacity.bricks);
        }
        if let Some(lines) = needed(STATUS_NEEDS_COLUMNS) {
            capacity.lines = lines.max(capacity.lines + capacity.lines / 4);
        }
        if capacity != self.capacity {
            self.move_into(capacity)?;
        }
        let stands = |state: &TrialState| matches!(state.status, STATUS_NEEDS_BRICKS | STATUS_NEEDS_COLUMNS);
        for trial in (0..states.len()).filter(|&trial| stands(&states[trial])) {
            let at = trial * size_of::<TrialState>() + std::mem::offset_of!(TrialState, status);
            let running = STATUS_RUNNING.to_le_bytes();
            self.simulator.device.queue.write_buffer(&self.buffers.states, at as u64, &running);
        }
        Ok(())
    }

    /// Moves all trials into buffers of another size.
    fn move_into(&mut self, capacity: TrialCapacity) -> Result<(), SimulateError> {
        let mut setups = self.setups.clone();
        lay_out(&mut setups, capacity, self.shared, self.values_each);
        let device = self.simulator.device;
        check(device, (&setups, &self.header), capacity, self.shared)?;
        let size = sizes(&setups, &self.header, capacity, self.shared);
        let brick = u64::from(self.header.planes) * u64::from(BRICK_VOXELS);
        let pairs = || self.setups.iter().zip(&setups);
        let mut bricks = vec![(0, 0, self.shared * brick)];
        bricks.extend(pairs().map(|(old, new)| {
            (
                u64::from(old.spare_first) * brick,
                u64::from(new.spare_first) * brick,
                u64::from(old.spare_bricks) * brick,
            )
        }));
        let index: Vec<Stretch> = pairs()
            .map(|(old, new)| {
                (old.grid_dims[3].into(), new.grid_dims[3].into(), u64::from(entries(old) + old.spare_bricks))
            })
            .collect();
        let columns: Vec<Stretch> = pairs().flat_map(|(old, new)| column_stretches(old, new)).collect();
        let buffers = &mut self.buffers;
        let during = format!("allocating {} (trials: {})", mib(&size.total()), setups.len());
        device.guarded(&during, |device| {
            let mut encoder = encoder(device);
            for (buffer, label, bytes, stretches) in [
                (&mut buffers.pool, "bricks", size.pool, bricks),
                (&mut buffers.index, "brick index", size.index, index),
                (&mut buffers.columns, "columns", size.columns, columns),
            ] {
                let larger = zeros(device, label, bytes, STORAGE);
                for (from, to, words) in stretches {
                    encoder.copy_buffer_to_buffer(buffer, from * WORD, &larger, to * WORD, words * WORD);
                }
                *buffer = larger;
            }
            device.queue.write_buffer(&buffers.setups, 0, bytemuck::cast_slice(&setups));
            device.queue.submit([encoder.finish()]);
        })?;
        (self.setups, self.capacity) = (setups, capacity);
        Ok(())
    }

    /// Reads the results of the trials, in their order.
    ///
    /// # Errors
    /// The device's fault.
    pub fn remains(&self) -> Result<Vec<TrialResults>, DeviceFault> {
        let index: Vec<u32> = self.read_all("reading the brick indices back", &self.buffers.index)?;
        let values: Vec<f32> = self.read_all("reading the values back", &self.buffers.values)?;
        let brick = u64::from(self.header.planes) * u64::from(BRICK_VOXELS);
        let mut results = Vec::new();
        let mut own_bricks = Vec::new();
        for (setup, values) in self.setups.iter().zip(values.chunks_exact(self.values_each)) {
            let first = setup.grid_dims[3] as usize;
            let index = index[first..first + entries(setup) as usize].to_vec();
            let own = index.iter().filter(|slot| **slot >= setup.shared_bricks && **slot < INSIDE).count();
            own_bricks.push((u64::from(setup.spare_first) * brick, own as u64 * brick));
            results.push(TrialResults { index, bricks: Vec::new(), values: values.to_vec() });
        }
        let bricks = self.read_ranges("reading the bricks back", &self.buffers.pool, &own_bricks)?;
        results.iter_mut().zip(bricks).for_each(|(result, bricks)| result.bricks = bricks);
        Ok(results)
    }

    /// Reads ranges of a buffer, each a first word and a number of words: many at once, because each read-back waits for
    /// the device.
    fn read_ranges(
        &self,
        during: &str,
        buffer: &wgpu::Buffer,
        ranges: &[(u64, u64)],
    ) -> Result<Vec<Vec<f32>>, DeviceFault> {
        let device = self.simulator.device;
        let mut read_so_far = Vec::with_capacity(ranges.len());
        let mut rest = ranges;
        while !rest.is_empty() {
            let (now, later) = rest.split_at(staged_together(rest));
            let words: u64 = now.iter().map(|(_, words)| words).sum();
            let staged = device.guarded(during, |device| {
                let mut encoder = encoder(device);
                let staged = staging(device, (words * WORD).max(WORD));
                let mut to = 0;
                for (from, words) in now.iter().filter(|(_, words)| *words > 0) {
                    encoder.copy_buffer_to_buffer(buffer, from * WORD, &staged, to * WORD, words * WORD);
                    to += words;
                }
                device.queue.submit([encoder.finish()]);
                staged
            })?;
            let all: Vec<f32> = read(device, during, &staged)?;
            let mut unread = all.as_slice();
            for (_, words) in now {
                let (own, others) = unread.split_at(*words as usize);
                read_so_far.push(own.to_vec());
                unread = others;
            }
            rest = later;
        }
        Ok(read_so_far)
    }

    fn read_all<T: bytemuck::Pod>(&self, during: &str, buffer: &wgpu::Buffer) -> Result<Vec<T>, DeviceFault> {
        let device = self.simulator.device;
        let staged = device.guarded(during, |device| {
            let mut encoder = encoder(device);
            let staged = copy_out(device, &mut encoder, buffer);
            device.queue.submit([encoder.finish()]);
            staged
        })?;
        read(device, during, &staged)
    }
}

/// Number of the first ranges that fit into one staging buffer, at least one.
fn staged_together(ranges: &[(u64, u64)]) -> usize {
    let ends = ranges.iter().scan(0, |end, (_, words)| {
        *end += words * WORD;
        Some(*end)
    });
    ends.take_while(|end| *end <= STAGED as u64).count().max(1)
}

/// The arrays over a trial's columns.
fn column_stretches(old: &TrialSetup, new: &TrialSetup) -> impl Iterator<Item = Stretch> {
    let (old, new) = (*old, *new);
    (0..COLUMN_ARRAYS).map(move |array| {
        let first = |setup: &TrialSetup| u64::from(setup.column_first + array * setup.column_lines);
        (first(&old), first(&new), u64::from(old.column_lines))
    })
}

fn encoder(device: &crate::Device) -> wgpu::CommandEncoder {
    device.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("simulate") })
}

fn staging(device: &crate::Device, bytes: u64) -> wgpu::Buffer {
    device.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("read back"),
        size: bytes,
        usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    })
}

/// Copies a whole buffer into one that can be mapped.
fn copy_out(device: &crate::Device, encoder: &mut wgpu::CommandEncoder, buffer: &wgpu::Buffer) -> wgpu::Buffer {
    let staged = staging(device, buffer.size());
    encoder.copy_buffer_to_buffer(buffer, 0, &staged, 0, buffer.size());
    staged
}
