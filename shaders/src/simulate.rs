//! A pass of many trials on the device, one workgroup each; host file of the kernels `simulate_*.wgsl`.
//!
//! A trial runs phase by phase. A phase is four dispatches: two parts of the work over all columns, the reductions, and
//! the choice of the next phase. No kernel needs a barrier, and all trials run in parallel whatever their phases are.
//!
//! Trials share the bricks of their asset and copy a brick before they write to it. A trial that runs out of memory for
//! bricks or columns stops until [`Running::advance`] has allocated more, and then resumes.

use std::sync::Arc;

use crate::buffers::{binding_entry, binding_limit, pipeline_in, read, write, zeros};
use crate::constants::{BRICK_VOXELS, COLUMN_ARRAYS, STATUS_NEEDS_BRICKS, STATUS_NEEDS_COLUMNS, STATUS_RUNNING};
use crate::device::{Device, DeviceFault, FaultKind};
use crate::fault::mib;
use crate::layout::{LogRecord, PathPiece, RunHeader, TrialSetup, TrialState};
use crate::wgsl::{Kernel, SIMULATE_CONTROL, SIMULATE_FIRST, SIMULATE_REDUCE, SIMULATE_SECOND};

/// Bytes of a number in a buffer.
const WORD: u64 = 4;
const STORAGE: wgpu::BufferUsages = wgpu::BufferUsages::STORAGE;

/// Reason why a batch was not simulated.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SimulateError {
    /// An array is larger than the adapter can bind.
    #[error(
        "the {array} of {trials} trials take {} and {adapter} binds at most {}: \
         fewer trials at once, a larger voxel or --backend cpu",
        mib(bytes),
        mib(limit)
    )]
    TooLarge {
        /// `bricks`, `columns`, `index` or `log`.
        array: &'static str,
        /// Trials in the batch.
        trials: usize,
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

impl SimulateError {
    /// Returns true if fewer trials at once may succeed.
    pub fn is_for_want_of_room(&self) -> bool {
        match self {
            Self::TooLarge { .. } => true,
            Self::Device(fault) => fault.kind == FaultKind::OutOfMemory,
        }
    }
}

/// Memory of each trial of a batch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TrialCapacity {
    /// Number of own bricks.
    pub bricks: u32,
    /// Number of columns of its height field.
    pub lines: u32,
    /// Number of phases of a submission.
    pub ticks: u32,
}

impl Default for TrialCapacity {
    fn default() -> Self {
        Self { bricks: 64, lines: 2048, ticks: 512 }
    }
}

impl TrialCapacity {
    /// Rows of the log: a step takes three phases or more.
    fn log_rows(&self) -> u32 {
        self.ticks / 3 + 2
    }
}

/// Trials before their first phase. [`Simulator::load`] fills in the offsets of the setups.
#[derive(Clone, Debug)]
pub struct Batch {
    /// Values that all trials share.
    pub header: RunHeader,
    /// One for each trial; the caller fills in `first_brick`, `shared_bricks`, `path_first` and `path_pieces`.
    pub setups: Vec<TrialSetup>,
    /// One for each trial.
    pub states: Vec<TrialState>,
    /// Brick index of each trial, one after the other.
    pub index: Vec<u32>,
    /// Bricks of all assets, shape `[bricks, planes, 512]`.
    pub bricks: Vec<f32>,
    /// Paths.
    pub path: Vec<PathPiece>,
    /// Values of all trials, the same number for each.
    pub values: Vec<f32>,
}

/// The kernels with the formulas of a model, on a device.
#[derive(Debug)]
pub struct Simulator<'a> {
    device: &'a Device,
    kernels: Arc<Kernels>,
}

/// Compiled kernels.
#[derive(Debug)]
pub(crate) struct Kernels {
    layout: wgpu::BindGroupLayout,
    /// In the order in which a phase runs them.
    pipelines: [wgpu::ComputePipeline; 4],
}

/// A batch in progress.
#[derive(Debug)]
pub struct Running<'a> {
    simulator: &'a Simulator<'a>,
    capacity: TrialCapacity,
    header: RunHeader,
    setups: Vec<TrialSetup>,
    /// Number of bricks of the assets.
    shared: u64,
    values_each: usize,
    buffers: Buffers,
}

/// The buffers of a batch in the order of their bindings.
#[derive(Debug)]
struct Buffers {
    header: wgpu::Buffer,
    setups: wgpu::Buffer,
    states: wgpu::Buffer,
    index: wgpu::Buffer,
    pool: wgpu::Buffer,
    columns: wgpu::Buffer,
    path: wgpu::Buffer,
    log: wgpu::Buffer,
    values: wgpu::Buffer,
}

/// Result of a submission.
#[derive(Clone, Debug)]
pub struct Chunk {
    /// State of each trial.
    pub states: Vec<TrialState>,
    /// Rows of the log; each trial's form a ring buffer of [`TrialSetup::log_rows`].
    pub rows: Vec<LogRecord>,
}

/// Results of a finished trial.
#[derive(Clone, Debug)]
pub struct TrialResults {
    /// Its index: slots from [`TrialSetup::shared_bricks`] on are its own bricks.
    pub index: Vec<u32>,
    /// Its own bricks, shape `[bricks, planes, 512]`.
    pub bricks: Vec<f32>,
    /// Its values.
    pub values: Vec<f32>,
}

impl<'a> Simulator<'a> {
    /// Compiles the kernels with the formulas of a model, as WGSL in the form of `no_model.wgsl`; once per device.
    ///
    /// # Errors
    /// The device's fault.
    pub fn new(device: &'a Device, formulas: &str) -> Result<Self, DeviceFault> {
        let during = "compiling the kernels of `simulate`";
        let mut known = device.kernels.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        if let Some(kernels) = known.get(formulas) {
            return Ok(Self { device, kernels: kernels.clone() });
        }
        let kernels = Arc::new(device.guarded(during, |device| {
            let layout = bind_group_layout(device);
            let all = [SIMULATE_FIRST, SIMULATE_SECOND, SIMULATE_REDUCE, SIMULATE_CONTROL];
            let compile =
                |kernel: Kernel| pipeline_in(device, kernel.entry, kernel.with_formulas(formulas), Some(&layout));
            Kernels { pipelines: all.map(compile), layout }
        })?);
        known.insert(formulas.to_owned(), kernels.clone());
        Ok(Self { device, kernels })
    }

    /// Uploads a batch.
    ///
    /// # Errors
    /// [`SimulateError::TooLarge`] if an array exceeds the binding limit, [`SimulateError::Device`] if the device
    /// fails.
    pub fn load(&self, batch: Batch, capacity: TrialCapacity) -> Result<Running<'_>, SimulateError> {
        let trials = batch.setups.len();
        let planes = u64::from(batch.header.planes);
        let shared = batch.bricks.len() as u64 / (planes * u64::from(BRICK_VOXELS));
        let header = batch.header;
        let values_each = batch.values.len() / trials;
        let mut setups = batch.setups;
        lay_out(&mut setups, capacity, shared, values_each);
        check(self.device, (&setups, &header), capacity, shared)?;
        let index = spread_index(&batch.index, &setups);
        let size = sizes(&setups, &header, capacity, shared);
        let [run, setup_buffer, states, index, pool, columns, path, log, values] = filled(
            self.device,
            &format!("uploading {} (trials: {trials})", mib(&size.total())),
            [
                ("run", bytemuck::bytes_of(&header), 0, wgpu::BufferUsages::UNIFORM),
                ("setups", bytemuck::cast_slice(&setups), 0, STORAGE),
                ("states", bytemuck::cast_slice(&batch.states), 0, STORAGE),
                ("brick index", bytemuck::cast_slice(&index), 0, STORAGE),
                ("bricks", bytemuck::cast_slice(&batch.bricks), size.pool, STORAGE),
                ("columns", &[], size.columns, STORAGE),
                ("path", bytemuck::cast_slice(&batch.path), 0, STORAGE),
                ("log", &[], size.log, STORAGE),
                ("values", bytemuck::cast_slice(&batch.values), 0, STORAGE),
            ],
        )?;
        let buffers = Buffers { header: run, setups: setup_buffer, states, index, pool, columns, path, log, values };
        Ok(Running { simulator: self, capacity, header, setups, shared, values_each, buffers })
    }
}

/// Label, content, size in bytes if larger than the content, and usage of a buffer.
type Content<'a> = (&'a str, &'a [u8], u64, wgpu::BufferUsages);

/// Creates buffers, then fills them: a write without memory for it would lose the device, a failed creation does not.
fn filled<const N: usize>(
    device: &Device,
    during: &str,
    contents: [Content; N],
) -> Result<[wgpu::Buffer; N], DeviceFault> {
    let buffers = device.guarded(during, |device| {
        contents.map(|(label, bytes, room, usage)| zeros(device, label, room.max(bytes.len() as u64), usage))
    })?;
    device.guarded(during, |device| {
        buffers.iter().zip(contents).for_each(|(buffer, (_, bytes, ..))| write(device, buffer, bytes));
    })?;
    Ok(buffers)
}

/// The bindings of `trial_data.wgsl`.
fn bind_group_layout(device: &Device) -> wgpu::BindGroupLayout {
    let storage = |read_only| wgpu::BufferBindingType::Storage { read_only };
    let kinds = [
        wgpu::BufferBindingType::Uniform,
        storage(true),
        storage(false),
        storage(false),
        storage(false),
        storage(false),
        storage(true),
        storage(false),
        storage(false),
    ];
    let entry = |(binding, ty)| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::COMPUTE,
        ty: wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None },
        count: None,
    };
    let entries: Vec<_> = (0..).zip(kinds).map(entry).collect();
    let descriptor = wgpu::BindGroupLayoutDescriptor { label: Some("simulate bindings"), entries: &entries };
    device.device.create_bind_group_layout(&descriptor)
}

/// Index entries of a trial.
fn entries(setup: &TrialSetup) -> u32 {
    let [x, y, z, _] = setup.grid_dims;
    x * y * z
}

/// Assigns each trial its offsets in the arrays, one trial after the other.
fn lay_out(setups: &mut [TrialSetup], capacity: TrialCapacity, shared: u64, values_each: usize) {
    let mut index = 0;
    for (trial, setup) in (0..).zip(setups) {
        setup.grid_dims[3] = index;
        setup.source_first = index + entries(setup);
        index = setup.source_first + capacity.bricks;
        setup.spare_first = shared as u32 + trial * capacity.bricks;
        setup.spare_bricks = capacity.bricks;
        setup.column_first = trial * capacity.lines * COLUMN_ARRAYS;
        setup.column_lines = capacity.lines;
        setup.log_first = trial * capacity.log_rows();
        setup.log_rows = capacity.log_rows();
        setup.value_first = trial * values_each as u32;
    }
}

/// The trials' indices, extended by the sources of their own bricks.
fn spread_index(index: &[u32], setups: &[TrialSetup]) -> Vec<u32> {
    let mut spread = Vec::new();
    let mut first = 0;
    for setup in setups {
        let count = entries(setup) as usize;
        spread.extend_from_slice(&index[first..first + count]);
        spread.resize(spread.len() + setup.spare_bricks as usize, 0);
        first += count;
    }
    spread
}

/// Sizes of the arrays that grow with the number of trials [bytes].
struct Sizes {
    pool: u64,
    columns: u64,
    index: u64,
    log: u64,
}

impl Sizes {
    fn total(&self) -> u64 {
        self.pool + self.columns + self.index + self.log
    }
}

fn sizes(setups: &[TrialSetup], header: &RunHeader, capacity: TrialCapacity, shared: u64) -> Sizes {
    let trials = setups.len() as u64;
    let bricks = shared + trials * u64::from(capacity.bricks);
    let index: u64 = setups.iter().map(|setup| u64::from(entries(setup)) + u64::from(capacity.bricks)).sum();
    Sizes {
        pool: bricks * u64::from(header.planes) * u64::from(BRICK_VOXELS) * WORD,
        columns: trials * u64::from(capacity.lines) * u64::from(COLUMN_ARRAYS) * WORD,
        index: index * WORD,
        log: trials * u64::from(capacity.log_rows()) * size_of::<LogRecord>() as u64,
    }
}

/// Refuses a batch that the device cannot bind.
fn check(
    device: &Device,
    (setups, header): (&[TrialSetup], &RunHeader),
    capacity: TrialCapacity,
    shared: u64,
) -> Result<(), SimulateError> {
    let limit = binding_limit(device);
    let Sizes { pool, columns, index, log } = sizes(setups, header, capacity, shared);
    let arrays = [("bricks", pool), ("columns", columns), ("index", index), ("log", log)];
    match arrays.into_iter().find(|(_, bytes)| *bytes > limit) {
        Some((array, bytes)) => {
            let adapter = device.adapter().to_string();
            Err(SimulateError::TooLarge { array, trials: setups.len(), bytes, limit, adapter })
        }
        None => Ok(()),
    }
}

mod running;
