//! Structs that are stored in buffers: declared once in Rust with their units, and written out as WGSL from there.
//!
//! A field is an `f32`, a `u32`, an `i32`, a vector of four or an array of those; three-vectors have an alignment that
//! Rust does not share. The build fails if a field would lie elsewhere in WGSL or the size is not a multiple of 16
//! bytes.

use bytemuck::{Pod, Zeroable};

/// A field type with the same layout in Rust and WGSL.
pub trait SharedType {
    /// Its name in WGSL.
    const WGSL: &'static str;
    /// Its alignment in WGSL [bytes].
    const ALIGN: usize;
}

macro_rules! shared_types {
    ($($rust:ty = $wgsl:literal, $align:literal;)+) => {
        $(impl SharedType for $rust {
            const WGSL: &'static str = $wgsl;
            const ALIGN: usize = $align;
        })+
    };
}

shared_types! {
    f32 = "f32", 4;
    u32 = "u32", 4;
    i32 = "i32", 4;
    [f32; 4] = "vec4<f32>", 16;
    [i32; 4] = "vec4<i32>", 16;
    [u32; 4] = "vec4<u32>", 16;
    [[f32; 4]; 20] = "array<vec4<f32>, 20>", 16;
    [[i32; 4]; 4] = "array<vec4<i32>, 4>", 16;
}

macro_rules! shared_struct {
    ($(#[doc = $about:literal])+ $name:ident { $($(#[doc = $doc:literal])+ $field:ident: $type:ty,)+ }) => {
        $(#[doc = $about])+
        #[repr(C)]
        #[derive(Clone, Copy, Debug, Pod, Zeroable)]
        pub struct $name { $($(#[doc = $doc])+ pub $field: $type,)+ }

        const _: () = {
            assert!(size_of::<$name>() % 16 == 0, "the size is not a multiple of 16 bytes");
            $(assert!(
                std::mem::offset_of!($name, $field) % <$type as SharedType>::ALIGN == 0,
                "a field is not where WGSL would put it"
            );)+
        };

        impl $name {
            /// The WGSL text that declares this struct.
            pub fn wgsl() -> String {
                let mut text = String::new();
                $(text.push_str(&format!("//{}\n", $about));)+
                text.push_str(&format!("struct {} {{\n", stringify!($name)));
                $(
                    $(text.push_str(&format!("    //{}\n", $doc));)+
                    text.push_str(&format!("    {}: {},\n", stringify!($field), <$type as SharedType>::WGSL));
                )+
                text + "}\n"
            }
        }
    };
}
pub(crate) use shared_struct;

mod trial;

pub use trial::{LogRecord, PathPiece, TrialSetup, TrialState};

shared_struct! {
    /// Description of a brick grid for a kernel, besides its two arrays.
    GridHeader {
        /// Brick coordinates of the first index entry [bricks]; the fourth is 0.
        origin: [i32; 4],
        /// Index entries per axis [bricks], x slowest; the fourth is 0.
        dims: [u32; 4],
        /// Distance between voxels [m].
        voxel: f32,
        /// Distance at which φ is truncated [m].
        band: f32,
        /// Bricks in the pool; a smaller index entry is a slot, any other a code.
        bricks: u32,
        /// Value of a sample at a point that is not finite: NaN, which WGSL cannot express.
        invalid: f32,
    }
}

shared_struct! {
    /// Values that all trials of a submission share.
    RunHeader {
        /// Planes of values in a brick; the first is φ.
        planes: u32,
        /// Plane of the dose, or ABSENT.
        dose_plane: u32,
        /// Plane of the removed depth, or ABSENT.
        removed_plane: u32,
        /// Plane of the label, or ABSENT.
        label_plane: u32,
    }
}

/// The WGSL text that declares every struct of this module.
pub fn wgsl() -> String {
    let texts = [
        GridHeader::wgsl(),
        RunHeader::wgsl(),
        TrialSetup::wgsl(),
        TrialState::wgsl(),
        PathPiece::wgsl(),
        LogRecord::wgsl(),
    ];
    texts.concat()
}

impl GridHeader {
    /// The header of a grid.
    ///
    /// - `origin`: brick coordinates of the first index entry [bricks]
    /// - `dims`: index entries per axis [bricks]
    /// - `voxel`, `band`: voxel distance and truncation distance [m]
    /// - `bricks`: bricks in the pool
    pub fn new(origin: [i32; 3], dims: [u32; 3], voxel: f32, band: f32, bricks: u32) -> Self {
        let [x, y, z] = origin;
        let [nx, ny, nz] = dims;
        Self { origin: [x, y, z, 0], dims: [nx, ny, nz, 0], voxel, band, bricks, invalid: f32::NAN }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_shader_text_carries_every_field_with_its_unit() {
        let text = GridHeader::wgsl();
        assert!(text.contains("struct GridHeader {"), "{text}");
        assert!(text.contains("    // Distance between voxels [m].\n    voxel: f32,"), "{text}");
        assert!(text.contains("origin: vec4<i32>,"), "{text}");
    }

    #[test]
    fn naga_puts_each_field_where_rust_does() {
        let module = naga::front::wgsl::parse_str(&GridHeader::wgsl()).expect("the struct parses");
        let (_, declared) = module.types.iter().find(|(_, t)| t.name.as_deref() == Some("GridHeader")).unwrap();
        let naga::TypeInner::Struct { members, span } = &declared.inner else { panic!("not a struct") };
        assert_eq!(*span as usize, size_of::<GridHeader>());
        let offsets: Vec<u32> = members.iter().map(|member| member.offset).collect();
        assert_eq!(offsets, [0, 16, 32, 36, 40, 44]);
        assert_eq!(std::mem::offset_of!(GridHeader, invalid), 44);
    }
}
