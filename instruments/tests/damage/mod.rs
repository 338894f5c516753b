//! Damage to the bytes of a file: truncation at every length, and flips, insertions and copies from a seeded stream.

/// Number of damaged files for each kind of damage.
const TRIES: usize = 400;

/// A stream of numbers from a seed, after G. Marsaglia, "Xorshift RNGs", 2003.
struct Stream(u64);

impl Stream {
    fn below(&mut self, bound: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 % bound.max(1) as u64) as usize
    }
}

/// Calls `check` with damaged copies of a file.
pub fn every(bytes: &[u8], check: impl Fn(&[u8])) {
    let mut stream = Stream(0x9e37_79b9_7f4a_7c15);
    let step = (bytes.len() / TRIES).max(1);
    (0..bytes.len()).step_by(step).for_each(|end| check(&bytes[..end]));
    for _ in 0..TRIES {
        let mut damaged = bytes.to_vec();
        for _ in 0..=stream.below(3) {
            let at = stream.below(damaged.len());
            match stream.below(4) {
                0 => damaged[at] ^= 1 << stream.below(8),
                1 => damaged[at] = [0, 0x7f, 0x80, 0xff][stream.below(4)],
                2 => damaged.insert(at, b"\n,;\"-.0[("[stream.below(9)]),
                _ => {
                    let from = stream.below(damaged.len());
                    damaged[at] = damaged[from];
                }
            }
        }
        check(&damaged);
    }
}
