//! Decompression of LZF (Lehmann 2000): literal runs, and copies of earlier bytes.

/// Decompresses to exactly `length` bytes.
///
/// # Errors
/// A description of the fault.
pub(super) fn unpacked(packed: &[u8], length: usize) -> Result<Vec<u8>, String> {
    let mut bytes = Vec::new();
    let mut rest = packed.iter().copied();
    let mut next = || rest.next().ok_or_else(|| "packed points that end too early".to_owned());
    while bytes.len() < length {
        let control = usize::from(next()?);
        if control < 32 {
            for _ in 0..=control {
                bytes.push(next()?);
            }
            continue;
        }
        let mut count = control >> 5;
        if count == 7 {
            count += usize::from(next()?);
        }
        let distance = ((control & 31) << 8) + usize::from(next()?) + 1;
        let start = bytes.len().checked_sub(distance).ok_or("packed points that refer to nothing")?;
        for at in start..start + count + 2 {
            bytes.push(bytes[at]);
        }
    }
    if bytes.len() == length {
        Ok(bytes)
    } else {
        Err(format!("{} bytes of points where {length} are stated", bytes.len()))
    }
}
