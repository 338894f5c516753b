//! Graphics adapters of this machine, best first, as plain data.

use std::fmt;

/// Backends searched unless `WGPU_BACKEND` names others. OpenGL is left out: its software adapters appear on machines
/// without a Vulkan driver, and do not meet WebGPU's requirements.
const BACKENDS: wgpu::Backends = wgpu::Backends::VULKAN.union(wgpu::Backends::METAL).union(wgpu::Backends::DX12);

/// Selection of adapters by the user.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Filter {
    /// Comma-separated backends, as in `WGPU_BACKEND`; `None` for Vulkan, Metal and DX12.
    pub backends: Option<String>,
    /// Part of the adapter's name in any case, as in `WGPU_ADAPTER_NAME`; `None` for all.
    pub name: Option<String>,
}

impl Filter {
    /// Reads `WGPU_BACKEND` and `WGPU_ADAPTER_NAME`; an empty variable counts as unset.
    pub fn from_env() -> Self {
        let read = |name: &str| std::env::var(name).ok().filter(|value| !value.trim().is_empty());
        Self { backends: read("WGPU_BACKEND"), name: read("WGPU_ADAPTER_NAME") }
    }

    /// The requested backends that this build supports.
    fn wgpu_backends(&self) -> wgpu::Backends {
        let asked = self.backends.as_deref().map_or(BACKENDS, wgpu::Backends::from_comma_list);
        asked & wgpu::Instance::enabled_backend_features()
    }

    fn accepts(&self, adapter_name: &str) -> bool {
        let holds = |part: &String| adapter_name.to_lowercase().contains(&part.trim().to_lowercase());
        self.name.as_ref().is_none_or(holds)
    }
}

/// Kind of an adapter, in the order of preference.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum AdapterKind {
    /// A graphics card with memory of its own.
    Discrete,
    /// A graphics unit that shares the processor's memory.
    Integrated,
    /// A virtual machine's share of a card.
    Virtual,
    /// The driver does not say.
    Other,
    /// A driver that runs shaders on the processor, such as llvmpipe.
    Cpu,
}

impl fmt::Display for AdapterKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Discrete => "discrete",
            Self::Integrated => "integrated",
            Self::Virtual => "virtual",
            Self::Other => "other",
            Self::Cpu => "cpu",
        })
    }
}

impl From<wgpu::DeviceType> for AdapterKind {
    fn from(kind: wgpu::DeviceType) -> Self {
        match kind {
            wgpu::DeviceType::DiscreteGpu => Self::Discrete,
            wgpu::DeviceType::IntegratedGpu => Self::Integrated,
            wgpu::DeviceType::VirtualGpu => Self::Virtual,
            wgpu::DeviceType::Other => Self::Other,
            wgpu::DeviceType::Cpu => Self::Cpu,
        }
    }
}

/// The limits that decide which buffers and kernels fit on an adapter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AdapterLimits {
    /// Largest storage buffer that a kernel can bind [bytes]; it bounds the bricks of one grid.
    pub storage_binding_bytes: u64,
    /// Largest buffer [bytes].
    pub buffer_bytes: u64,
    /// Storage buffers in one kernel.
    pub storage_buffers: u32,
    /// Invocations in a workgroup.
    pub workgroup_invocations: u32,
    /// Memory shared by a workgroup [bytes].
    pub workgroup_bytes: u32,
    /// Workgroups along one axis of a dispatch.
    pub workgroups_per_axis: u32,
}

/// Description of one adapter, for messages and metadata.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AdapterReport {
    /// Name reported by the driver.
    pub name: String,
    /// `vulkan`, `metal` or `dx12`.
    pub backend: String,
    /// Driver and its version; empty if the driver does not report them.
    pub driver: String,
    /// Kind of adapter.
    pub kind: AdapterKind,
    /// Its limits.
    pub limits: AdapterLimits,
}

impl AdapterReport {
    fn of(adapter: &wgpu::Adapter) -> Self {
        let info = adapter.get_info();
        let limits = adapter.limits();
        Self {
            name: info.name,
            backend: info.backend.to_string(),
            driver: format!("{} {}", info.driver, info.driver_info).trim().to_string(),
            kind: info.device_type.into(),
            limits: AdapterLimits {
                storage_binding_bytes: limits.max_storage_buffer_binding_size,
                buffer_bytes: limits.max_buffer_size,
                storage_buffers: limits.max_storage_buffers_per_shader_stage,
                workgroup_invocations: limits.max_compute_invocations_per_workgroup,
                workgroup_bytes: limits.max_compute_workgroup_storage_size,
                workgroups_per_axis: limits.max_compute_workgroups_per_dimension,
            },
        }
    }
}

impl fmt::Display for AdapterReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} ({}, {}", self.name, self.backend, self.kind)?;
        if !self.driver.is_empty() {
            write!(f, ", {}", self.driver)?;
        }
        f.write_str(")")
    }
}

/// The adapters found, and the search criteria.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Adapters {
    /// Search criteria.
    pub filter: Filter,
    /// Backends searched; empty if this build has none of the requested ones.
    pub backends: Vec<String>,
    /// Adapters that pass the filter, best first.
    pub found: Vec<AdapterReport>,
    /// Names of the adapters that the name filter rejects.
    pub passed_over: Vec<String>,
}

/// Lists the adapters that pass a filter, best first; adapters of one kind stay in the driver's order.
/// A machine without any driver gives an empty list.
pub fn list(filter: &Filter) -> Adapters {
    enumerate(filter, 100).0
}

/// As [`list`], with the handles of `found` in the same order. Their devices refuse allocations that would exceed
/// `memory_percent` of the driver's memory budget.
pub(crate) fn enumerate(filter: &Filter, memory_percent: u8) -> (Adapters, Vec<wgpu::Adapter>) {
    let backends = filter.wgpu_backends();
    let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle_from_env();
    descriptor.backends = backends;
    // No dispatch is indirect: the device opens without the buffers and kernels that validate them.
    descriptor.flags.remove(wgpu::InstanceFlags::VALIDATION_INDIRECT_CALL);
    descriptor.memory_budget_thresholds.for_resource_creation = Some(memory_percent);
    let instance = wgpu::Instance::new(descriptor);
    let all = pollster::block_on(instance.enumerate_adapters(backends));
    let (passing, other): (Vec<_>, Vec<_>) = all
        .into_iter()
        .map(|adapter| (AdapterReport::of(&adapter), adapter))
        .partition(|(r, _)| filter.accepts(&r.name));
    let mut passing = passing;
    passing.sort_by_key(|(report, _)| report.kind);
    let (found, handles) = passing.into_iter().unzip();
    let adapters = Adapters {
        filter: filter.clone(),
        backends: backends.iter_names().map(|(name, _)| name.to_lowercase()).collect(),
        found,
        passed_over: other.into_iter().map(|(report, _)| report.name).collect(),
    };
    (adapters, handles)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_filter_takes_any_case_and_any_part() {
        let filter = Filter { backends: None, name: Some("LLVM".into()) };
        assert!(filter.accepts("llvmpipe (LLVM 15.0.6, 256 bits)"));
        assert!(!filter.accepts("NVIDIA H200"));
        assert!(Filter::default().accepts("NVIDIA H200"));
    }

    #[test]
    fn kinds_are_in_order_of_preference() {
        use AdapterKind::{Cpu, Discrete, Integrated, Other, Virtual};
        let mut kinds = [Cpu, Other, Integrated, Discrete, Virtual];
        kinds.sort();
        assert_eq!(kinds, [Discrete, Integrated, Virtual, Other, Cpu]);
    }

    #[test]
    fn opengl_is_looked_at_only_when_asked_for() {
        assert!(!Filter::default().wgpu_backends().contains(wgpu::Backends::GL));
        let nonsense = Filter { backends: Some("nonsense".into()), name: None };
        assert!(nonsense.wgpu_backends().is_empty());
    }
}
