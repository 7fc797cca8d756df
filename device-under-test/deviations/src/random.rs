//! Random combinations of what a manual permits, the same for a seed on every machine.

use crate::{Deviation, Subject, variations};
use alloc::vec;
use alloc::vec::Vec;

/// How a name of a random combination begins; the seed follows.
const RANDOM: &str = "random:";
/// One in this many variations is in a random combination.
const ONE_IN: u64 = 3;
/// Variations of which a device has one at most: each says something else about the same thing, or one hides all that the other shows.
const ALTERNATIVES: [&[&str]; 5] = [
    &["firmware-of-two-digits", "firmware-of-a-prototype"],
    // What is shown in one frame is lost with it.
    &["preset-bit-ends-with-the-preset", "input-frames-lost"],
    &["preset-bit-ends-with-the-preset", "input-frames-lost-in-a-row"],
    &["acknowledgement-answered-in-one-frame", "input-frames-lost"],
    &["acknowledgement-answered-in-one-frame", "input-frames-lost-in-a-row"],
];

impl Subject {
    /// Returns the permitted variations that `name` stands for: the one with this name, those of a random combination,
    /// `random:SEED` with a number as seed, or other places of the start parameters, `start-parameters-elsewhere:SEED`; `None` if it is
    /// none of them.
    pub fn variations_of(&self, name: &str) -> Option<Vec<&'static Deviation>> {
        let name = variations::start_layout_seed(name).map_or(name, |_| variations::ELSEWHERE);
        match name.strip_prefix(RANDOM) {
            Some(seed) => Some(self.random_variations(seed.parse().ok()?)),
            None => self.permitted().find(|known| known.name == name).map(|known| vec![known]),
        }
    }

    /// Returns a random combination of permitted variations, each with a probability of one in three, in the order of the tables;
    /// of variations that exclude each other the first.
    ///
    /// The choice depends on `seed` and on the name of each variation, so a new variation changes nothing for the others. There is at
    /// least one, if the manual permits any.
    pub fn random_variations(&self, seed: u64) -> Vec<&'static Deviation> {
        let mut chosen: Vec<_> =
            self.permitted().filter(|known| draw(seed, known.name).is_multiple_of(ONE_IN)).collect();
        for names in ALTERNATIVES {
            let kept = chosen.iter().map(|known| known.name).find(|name| names.contains(name));
            chosen.retain(|known| Some(known.name) == kept || !names.contains(&known.name));
        }
        if chosen.is_empty() {
            return self.permitted().min_by_key(|known| draw(seed, known.name)).into_iter().collect();
        }
        chosen
    }
}

/// Returns a number that looks random: FNV-1a over the name, mixed with the seed as in SplitMix64.
fn draw(seed: u64, name: &str) -> u64 {
    let hash = name
        .bytes()
        .fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3));
    let mut mixed = hash ^ seed.wrapping_mul(0x9e37_79b9_7f4a_7c15);
    mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    mixed ^ (mixed >> 31)
}
