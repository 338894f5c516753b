//! NanoVDB's checksum of a grid: two CRC-32, one of the head, one of the CRCs of all nodes.

/// Value of half a checksum that was not computed.
pub(super) const NONE: u32 = u32::MAX;
/// Length of the magic number and the checksum itself, which no checksum covers [bytes].
const UNCOVERED: usize = 16;

/// CRC of grid head, tree and root; `bytes` ends after the last root entry.
pub(super) fn head(bytes: &[u8]) -> u32 {
    crc32fast::hash(&bytes[UNCOVERED..])
}

/// CRC of the nodes' CRCs: upper, lower, leaves, each list in file order. [`NONE`] for an empty tree.
///
/// Each CRC counts as eight bytes, the size of `uint_fast32_t` where the 64-bit writers run.
pub(super) fn tail(nodes: impl Iterator<Item = u32>) -> u32 {
    of_nodes(nodes.map(u64::from))
}

/// [`tail`] for a writer with four bytes in `uint_fast32_t`.
pub(super) fn narrow_tail(nodes: impl Iterator<Item = u32>) -> u32 {
    of_nodes(nodes)
}

fn of_nodes<T: bytemuck::Pod>(nodes: impl Iterator<Item = T>) -> u32 {
    let crcs: Vec<T> = nodes.collect();
    if crcs.is_empty() { NONE } else { crc32fast::hash(bytemuck::cast_slice(&crcs)) }
}

pub(super) fn join(head: u32, tail: u32) -> u64 {
    u64::from(tail) << 32 | u64::from(head)
}
