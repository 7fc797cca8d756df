//! Random choices that depend on a seed alone.

use controllers::random::SplitMix64;

/// A source of random choices.
#[derive(Clone, Debug)]
pub struct Draw(SplitMix64);

impl Draw {
    pub fn new(seed: u64) -> Draw {
        // Neighbouring seeds begin far apart.
        Draw(SplitMix64::new(seed.wrapping_mul(0xd134_2543_de82_ef95).wrapping_add(0x2545_f491_4f6c_dd1d)))
    }

    /// 64 random bits.
    pub fn bits(&mut self) -> u64 {
        self.0.bits()
    }

    /// A number from `from` to `to`, both included.
    pub fn between(&mut self, from: u64, to: u64) -> u64 {
        match to.saturating_sub(from).checked_add(1) {
            Some(count) => from + self.bits() % count,
            None => self.bits(),
        }
    }

    /// True in `percent` of a hundred cases.
    pub fn chance(&mut self, percent: u64) -> bool {
        self.between(0, 99) < percent
    }

    /// One of these; `None` if there are none.
    pub fn one<'a, T>(&mut self, of: &'a [T]) -> Option<&'a T> {
        let last = of.len().checked_sub(1)?;
        of.get(self.between(0, last as u64) as usize)
    }

    /// One of these, each as often as its weight says.
    pub fn weighted<'a, T>(&mut self, of: &'a [T], weight: impl Fn(&T) -> u64) -> Option<&'a T> {
        let all: u64 = of.iter().map(&weight).sum();
        let mut left = self.between(1, all.max(1));
        of.iter().find(|item| {
            let own = weight(item);
            let found = left <= own;
            left = left.saturating_sub(own);
            found
        })
    }

    /// A number that fits into `width` bits: small, a power of two, next to one, or any.
    pub fn number(&mut self, width: u32) -> u64 {
        let most = if width >= 64 { u64::MAX } else { (1 << width) - 1 };
        let power = 1_u64 << self.between(0, u64::from(width.clamp(1, 64)) - 1);
        let number = match self.between(0, 5) {
            0 => self.between(0, 3),
            1 => power,
            2 => power - 1,
            3 => most - self.between(0, 1),
            4 => self.between(0, 100_000),
            _ => self.bits(),
        };
        number & most
    }
}

#[cfg(test)]
mod tests {
    use super::Draw;

    #[test]
    fn the_seed_alone_decides() {
        let numbers = |seed| {
            let mut draw = Draw::new(seed);
            (0..8).map(|_| draw.between(1, 6)).collect::<Vec<_>>()
        };
        assert_eq!(numbers(3), numbers(3));
        assert_ne!(numbers(3), numbers(4));
        assert!((0..100).all(|seed| numbers(seed).iter().all(|number| (1..=6).contains(number))));
    }

    #[test]
    fn numbers_fit_and_reach_both_ends() {
        let mut draw = Draw::new(1);
        let numbers: Vec<u64> = (0..1000).map(|_| draw.number(8)).collect();
        assert!(numbers.iter().all(|number| *number < 256));
        assert!(numbers.contains(&0) && numbers.contains(&255));
        assert_eq!(draw.one::<u8>(&[]), None);
    }
}
