//! Every WGSL source parses and validates, without a device.

use std::collections::BTreeSet;

use naga::valid::{Capabilities, ValidationFlags, Validator};
use shaders::wgsl::KERNELS;

#[test]
fn every_kernel_validates_and_has_its_entry_point() {
    for kernel in KERNELS {
        let text = kernel.text();
        let module = naga::front::wgsl::parse_str(&text)
            .unwrap_or_else(|error| panic!("{}: {}", kernel.entry, error.emit_to_string(&text)));
        Validator::new(ValidationFlags::all(), Capabilities::empty())
            .validate(&module)
            .unwrap_or_else(|error| panic!("{}: {}", kernel.entry, error.emit_to_string(&text)));
        let entries: Vec<&str> = module.entry_points.iter().map(|entry| entry.name.as_str()).collect();
        assert_eq!(entries, [kernel.entry]);
        assert_eq!(module.entry_points[0].workgroup_size, [shaders::constants::WORKGROUP_SIZE, 1, 1]);
    }
}

#[test]
fn every_file_belongs_to_a_kernel_and_stays_short() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/src/wgsl");
    let files: BTreeSet<String> = std::fs::read_dir(folder)
        .expect("the folder of WGSL files")
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    let sources = || KERNELS.iter().flat_map(|kernel| kernel.sources);
    assert_eq!(files, sources().map(|source| source.file.to_string()).collect());
    for source in sources() {
        assert!(source.text.lines().count() <= 150, "{} is longer than 150 lines", source.file);
    }
}
