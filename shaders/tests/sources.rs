//! Tests without a device: every WGSL source parses and validates.

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

/// Name and value of each constant with a literal value that a text declares after `keyword`.
fn literals(text: &str, keyword: &str) -> Vec<(String, f64)> {
    let constant = |line: &str| {
        let (name, rest) = line.trim_start().strip_prefix(keyword)?.split_once(':')?;
        let value = rest.split_once('=')?.1.split_once(';')?.0.trim().replace('_', "");
        let value = value.trim_end_matches(['u', 'i', 'f']).parse().ok()?;
        Some((name.trim().to_owned(), value))
    };
    text.lines().filter_map(constant).collect()
}

#[test]
fn a_number_of_both_sides_is_declared_once() {
    let mut host = Vec::new();
    for folder in ["sim/src", "render/src"] {
        let files = walkdir::WalkDir::new(format!("{}/../{folder}", env!("CARGO_MANIFEST_DIR")));
        let rust = files.into_iter().map(|file| file.expect("a source file").into_path());
        for file in rust.filter(|path| path.extension().is_some_and(|ending| ending == "rs")) {
            let text = std::fs::read_to_string(&file)
                .expect("a source file")
                .replace("pub(crate) ", "")
                .replace("pub(super) ", "");
            host.extend(literals(&text.replace("pub const", "const"), "const "));
        }
    }
    assert!(host.len() > 50, "the search finds constants of the host");
    let sources: BTreeSet<(&str, &str)> =
        KERNELS.iter().flat_map(|kernel| kernel.sources).map(|source| (source.file, source.text)).collect();
    let mut device = 0;
    for (file, text) in sources {
        for (name, value) in literals(text, "const ") {
            device += 1;
            let twice = host.iter().any(|(other, also)| *other == name && (also - value).abs() <= 1e-6 * value.abs());
            assert!(!twice, "{file}: {name} = {value} is a constant of the host, too: declare it in constants.rs");
        }
    }
    assert!(device > 50, "the search finds constants of the device");
}
