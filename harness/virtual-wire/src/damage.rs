//! Ways to damage bytes, to test parsers.

/// Calls `check` with every prefix of `octets`, from the empty one to all but the last byte.
pub fn every_prefix(octets: &[u8], mut check: impl FnMut(&[u8])) {
    for end in 0..octets.len() {
        check(&octets[..end]);
    }
}

/// Calls `check` with `octets` with one bit flipped, for each bit in turn. `check` also receives the index of the changed byte.
pub fn every_flipped_bit(octets: &[u8], mut check: impl FnMut(usize, &[u8])) {
    let mut damaged = octets.to_vec();
    for index in 0..damaged.len() {
        for bit in 0..8 {
            damaged[index] ^= 1 << bit;
            check(index, &damaged);
            damaged[index] ^= 1 << bit;
        }
    }
}

/// Calls `check` `rounds` times with `octets` with `bits` bits flipped, possibly the same bit twice.
///
/// The bits are random, but the same for the same `seed`. Empty `octets` stay unchanged.
pub fn random_flips(octets: &[u8], seed: u64, rounds: usize, bits: usize, mut check: impl FnMut(&[u8])) {
    let mut random = Random::new(seed);
    for _ in 0..rounds {
        let mut damaged = octets.to_vec();
        for _ in 0..bits.min(octets.len() * 8) {
            let bit = random.below(octets.len() as u64 * 8) as usize;
            damaged[bit / 8] ^= 1 << (bit % 8);
        }
        check(&damaged);
    }
}

/// Pseudo-random numbers, the same for the same seed (xorshift by Marsaglia).
#[derive(Clone, Debug)]
pub(crate) struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Random {
        // The state must not be zero, or it stays zero.
        Random(seed.wrapping_add(0x9E37_79B9_7F4A_7C15).max(1))
    }

    /// A number below `end`, which must not be 0.
    pub fn below(&mut self, end: u64) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        // The low bits are less random.
        (self.0 >> 16) % end
    }

    pub fn octet(&mut self) -> u8 {
        self.below(0x100) as u8
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prefixes_grow_by_one_and_leave_out_the_whole() {
        let mut seen = Vec::new();
        every_prefix(&[7, 8, 9], |prefix| seen.push(prefix.to_vec()));
        assert_eq!(seen, [vec![], vec![7], vec![7, 8]]);
    }

    #[test]
    fn each_bit_is_flipped_once_and_alone() {
        let mut seen = Vec::new();
        every_flipped_bit(&[0x00, 0xFF], |index, octets| seen.push((index, octets[0], octets[1])));
        assert_eq!(seen.len(), 16);
        assert_eq!((seen[3], seen[15]), ((0, 0x08, 0xFF), (1, 0x00, 0x7F)));
    }

    #[test]
    fn the_same_seed_does_the_same_damage() {
        let collect = |seed| {
            let mut seen = Vec::new();
            random_flips(&[0; 64], seed, 4, 3, |octets| seen.push(octets.to_vec()));
            seen
        };
        assert_eq!(collect(1), collect(1));
        assert_ne!(collect(1), collect(2));
        assert!(collect(1).iter().all(|octets| octets.iter().any(|octet| *octet != 0)));
        random_flips(&[], 1, 1, 1, |octets| assert!(octets.is_empty()));
    }
}
