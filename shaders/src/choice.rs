//! Choice between CPU and GPU, with its reason as data, from the list of adapters alone.

use std::fmt;
use std::str::FromStr;

use crate::adapters::{AdapterKind, AdapterReport, Adapters};

/// Package to install if a driver is missing.
pub const DRIVER_PACKAGE: &str = "mesa-vulkan-drivers";

/// The user's choice: `--backend auto|cpu|gpu`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum BackendChoice {
    /// The GPU if there is a hardware one, otherwise the CPU.
    #[default]
    Auto,
    /// The CPU.
    Cpu,
    /// A GPU, software drivers included, or an error.
    Gpu,
}

/// An unknown backend choice.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("backend \"{0}\" is unknown: use auto, cpu or gpu")]
pub struct UnknownChoice(pub String);

impl FromStr for BackendChoice {
    type Err = UnknownChoice;

    fn from_str(text: &str) -> Result<Self, UnknownChoice> {
        match text {
            "auto" => Ok(Self::Auto),
            "cpu" => Ok(Self::Cpu),
            "gpu" => Ok(Self::Gpu),
            other => Err(UnknownChoice(other.into())),
        }
    }
}

impl fmt::Display for BackendChoice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Auto => "auto",
            Self::Cpu => "cpu",
            Self::Gpu => "gpu",
        })
    }
}

/// Backend on which the work runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Backend {
    /// The Rust code.
    Cpu,
    /// The WGSL code.
    Gpu,
}

impl fmt::Display for Backend {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Cpu => "cpu",
            Self::Gpu => "gpu",
        })
    }
}

/// Chosen backend and reason.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Decision {
    /// The backend.
    pub backend: Backend,
    /// Position of the adapter in [`Adapters::found`]; `None` on the CPU.
    pub adapter: Option<usize>,
    /// Reason, in one line for the log.
    pub reason: String,
}

impl Decision {
    pub(crate) fn cpu(why: &str) -> Self {
        Self { backend: Backend::Cpu, adapter: None, reason: format!("CPU: {why}") }
    }

    fn gpu(best: &AdapterReport) -> Self {
        Self { backend: Backend::Gpu, adapter: Some(0), reason: format!("GPU: {best}") }
    }
}

/// Error if no adapter matches; the text names the search criteria and the package to install.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct NoAdapter(pub String);

/// Chooses the backend.
///
/// # Errors
/// [`NoAdapter`] for `gpu` without an adapter.
pub fn decide(choice: BackendChoice, adapters: &Adapters) -> Result<Decision, NoAdapter> {
    match choice {
        BackendChoice::Auto => Ok(auto(adapters)),
        BackendChoice::Cpu => Ok(Decision::cpu("asked for")),
        BackendChoice::Gpu => adapters.found.first().map(Decision::gpu).ok_or_else(|| NoAdapter(why_none(adapters))),
    }
}

/// The choice of `auto`: the best adapter, or the CPU if the best one is a software driver, which runs on the same
/// processor.
pub fn auto(adapters: &Adapters) -> Decision {
    match adapters.found.first() {
        None => Decision::cpu(&why_none(adapters)),
        Some(best) if best.kind == AdapterKind::Cpu => Decision::cpu(&format!(
            "the only adapter, {}, is a software driver and runs on this same processor; a real GPU needs its own \
             (AMD, Intel: apt-get install {DRIVER_PACKAGE}; NVIDIA: NVIDIA's); --backend gpu takes this one",
            best.name
        )),
        Some(best) => Decision::gpu(best),
    }
}

/// The choice of `auto` on a machine without a graphics processor, whatever drivers are installed.
pub(crate) fn without_hardware() -> Decision {
    Decision::cpu(&format!(
        "this machine shows no graphics processor (no render node in /dev); --backend gpu takes a software driver \
         (apt-get install {DRIVER_PACKAGE})"
    ))
}

/// Reason why no adapter was found, and what to do.
fn why_none(adapters: &Adapters) -> String {
    let filter = &adapters.filter;
    if let (Some(name), false) = (&filter.name, adapters.passed_over.is_empty()) {
        let there = adapters.passed_over.join("; ");
        return format!("no adapter's name contains \"{name}\" (WGPU_ADAPTER_NAME); there are: {there}");
    }
    if let (Some(asked), true) = (&filter.backends, adapters.backends.is_empty()) {
        return format!("WGPU_BACKEND={asked} names no backend of this build: use vulkan, metal or dx12, or unset it");
    }
    format!(
        "no graphics adapter found (looked at {}): the driver or the Vulkan loader is missing; \
         on Debian or Ubuntu: apt-get install {DRIVER_PACKAGE}",
        adapters.backends.join(", ")
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::adapters::{AdapterLimits, Filter};

    fn adapters(kinds: &[AdapterKind]) -> Adapters {
        let limits = AdapterLimits {
            storage_binding_bytes: 1 << 27,
            buffer_bytes: 1 << 28,
            storage_buffers: 8,
            workgroup_invocations: 256,
            workgroup_bytes: 1 << 14,
            workgroups_per_axis: 65_535,
        };
        let report = |&kind: &AdapterKind| AdapterReport {
            name: format!("{kind} adapter"),
            backend: "vulkan".into(),
            driver: String::new(),
            kind,
            limits,
        };
        Adapters { backends: vec!["vulkan".into()], found: kinds.iter().map(report).collect(), ..Adapters::default() }
    }

    #[test]
    fn without_an_adapter_auto_is_the_cpu_and_gpu_an_error_and_both_name_the_package() {
        let none = adapters(&[]);
        let decision = decide(BackendChoice::Auto, &none).unwrap();
        assert_eq!((decision.backend, decision.adapter), (Backend::Cpu, None));
        assert!(decision.reason.contains(DRIVER_PACKAGE) && !decision.reason.contains('\n'), "{}", decision.reason);
        let error = decide(BackendChoice::Gpu, &none).unwrap_err();
        assert!(error.to_string().contains(DRIVER_PACKAGE), "{error}");
    }

    #[test]
    fn a_software_driver_is_used_only_when_a_gpu_is_asked_for() {
        let software = adapters(&[AdapterKind::Cpu]);
        let auto = decide(BackendChoice::Auto, &software).unwrap();
        assert_eq!(auto.backend, Backend::Cpu);
        assert!(auto.reason.contains("cpu adapter") && auto.reason.contains(DRIVER_PACKAGE), "{}", auto.reason);
        assert_eq!(decide(BackendChoice::Gpu, &software).unwrap().adapter, Some(0));
    }

    #[test]
    fn a_real_adapter_is_taken_by_auto_and_left_by_cpu() {
        let real = adapters(&[AdapterKind::Integrated, AdapterKind::Cpu]);
        assert_eq!(decide(BackendChoice::Auto, &real).unwrap().backend, Backend::Gpu);
        assert_eq!(decide(BackendChoice::Cpu, &real).unwrap().backend, Backend::Cpu);
    }

    #[test]
    fn a_name_or_backend_that_matches_nothing_is_named() {
        let mut none = adapters(&[]);
        none.filter = Filter { backends: None, name: Some("h200".into()) };
        none.passed_over = vec!["llvmpipe".into()];
        let error = decide(BackendChoice::Gpu, &none).unwrap_err().to_string();
        assert!(error.contains("h200") && error.contains("llvmpipe"), "{error}");

        let mut none = Adapters::default();
        none.filter.backends = Some("nonsense".into());
        let error = decide(BackendChoice::Gpu, &none).unwrap_err().to_string();
        assert!(error.contains("WGPU_BACKEND=nonsense"), "{error}");
    }

    #[test]
    fn choices_are_read_back_as_they_are_written() {
        for choice in [BackendChoice::Auto, BackendChoice::Cpu, BackendChoice::Gpu] {
            assert_eq!(choice.to_string().parse(), Ok(choice));
        }
        assert!("cuda".parse::<BackendChoice>().unwrap_err().to_string().contains("auto, cpu or gpu"));
    }
}
