//! Numbers that Rust and WGSL must agree on, declared once here and written out into every kernel.

macro_rules! shared_constants {
    ($($(#[doc = $doc:literal])+ $name:ident = $value:expr;)+) => {
        $($(#[doc = $doc])+ pub const $name: u32 = $value;)+

        /// The WGSL text that declares every constant of this module.
        pub fn wgsl() -> String {
            let mut text = String::new();
            $(
                $(text.push_str(&format!("//{}\n", $doc));)+
                text.push_str(&format!("const {}: u32 = {}u;\n", stringify!($name), $name));
            )+
            text
        }
    };
}

shared_constants! {
    /// log2 of the voxels along the side of a brick.
    BRICK_SHIFT = 3;
    /// Voxels along the side of a brick.
    BRICK_SIDE = 1 << BRICK_SHIFT;
    /// Voxels in a brick.
    BRICK_VOXELS = BRICK_SIDE * BRICK_SIDE * BRICK_SIDE;
    /// Index entry of a brick that is wholly outside, beyond the band.
    OUTSIDE = u32::MAX;
    /// Index entry of a brick that is wholly inside, beyond the band.
    INSIDE = u32::MAX - 1;
    /// Voxel coordinates are looked up below this: from 2^22 on, an f32 steps by half a voxel or more.
    FARTHEST_VOXEL = 1 << 22;
    /// Invocations in a workgroup of a kernel over a list: two waves of 32, one of 64, inside every limit.
    WORKGROUP_SIZE = 64;
    /// A pixel shows the room behind the scene.
    SEEN_BACKGROUND = 0;
    /// A pixel shows the part.
    SEEN_PART = 1;
    /// A pixel shows the table.
    SEEN_TABLE = 2;
}
