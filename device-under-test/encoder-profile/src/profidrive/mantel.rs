//! The preset without a handshake: one word that carries a value and its trigger.
//!
//! Bit 31 is the trigger, bits 27 to 0 are the value; each rising edge of the trigger carries out an absolute preset.
//! Source: Kübler Sendix 58xx, telegram 860.

use crate::encoder::PresetMode;

/// Bit 31, the trigger.
pub const TRIGGER: u32 = 1 << 31;
/// Bits 27 to 0, the value.
pub const VALUE: u32 = (1 << 28) - 1;

/// What the value of a preset could be taken from or limited by.
#[derive(Clone, Copy, Debug)]
pub struct Known {
    /// The range of positions in force, in units, at least 1.
    pub range: u64,
    /// The range that the user has set, in force or not.
    pub user_range: u64,
    /// The preset value of the parameters.
    pub preset_value: u32,
    /// The word of the frame before; 0 without one.
    pub before: u32,
}

/// What made the last word void.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cleared {
    /// Outputs that are not good.
    BadOutputs,
    /// The end of the connection.
    End,
}

/// Where bugs can be put into the preset without a handshake.
#[derive(Clone, Copy, Debug)]
pub struct Rules {
    /// Whether a preset begins, from the word before, if there is one that counts, and the word now.
    pub begins: fn(Option<u32>, u32) -> bool,
    /// Whether another preset begins, from how many there were in this connection.
    pub again: fn(u32) -> bool,
    /// The value of the preset, in units, from the word.
    pub value: fn(u32, &Known) -> u64,
    /// What a preset does with the value, from the home position mode in G1_STW.
    pub mode: fn(PresetMode) -> PresetMode,
    /// For how many frames the trigger has to stand, at least 1.
    pub frames: u8,
    /// For how many frames the trigger has to be 0 before it rises anew; the first time it need not.
    pub rests: u8,
    /// Whether outputs that are none leave the word before as it is.
    pub ignores_missing: bool,
    /// Whether the word before is forgotten.
    pub clears: fn(Cleared) -> bool,
}

impl Default for Rules {
    fn default() -> Rules {
        Rules {
            begins,
            again: |_| true,
            value,
            mode: |_| PresetMode::Absolute,
            frames: 1,
            rests: 0,
            ignores_missing: false,
            clears: |_| true,
        }
    }
}

/// Whether the trigger rises; without a word before it was 0.
pub fn begins(before: Option<u32>, now: u32) -> bool {
    before.unwrap_or(0) & TRIGGER == 0 && now & TRIGGER != 0
}

/// The value in the word, at most the highest position.
pub fn value(word: u32, known: &Known) -> u64 {
    u64::from(word & VALUE).min(known.range - 1)
}

/// Waits for the trigger.
#[derive(Clone, Debug)]
pub struct Trigger {
    before: Option<u32>,
    /// The frames for which the trigger has still to stand; 0 without a preset that begins.
    left: u8,
    /// The presets in this connection.
    presets: u32,
    /// For how many frames the trigger has been 0 since it was set.
    rested: u8,
    rules: Rules,
}

impl Trigger {
    /// A trigger that has seen no word yet.
    pub fn new(rules: Rules) -> Trigger {
        Trigger { before: None, left: 0, presets: 0, rested: u8::MAX, rules }
    }

    /// Takes the word of one frame, none where the outputs are bad and count as 0; gives the value if a preset is to be carried out.
    pub fn take(&mut self, word: Option<u32>, known: &Known) -> Option<u64> {
        let is_bad = word.is_none();
        if is_bad && self.rules.ignores_missing {
            return None;
        }
        let word = word.unwrap_or(0);
        let before = self.before.replace(word);
        let rested = self.rested;
        self.rested = if word & TRIGGER == 0 { rested.saturating_add(1) } else { 0 };
        if rested >= self.rules.rests && (self.rules.begins)(before, word) && (self.rules.again)(self.presets) {
            self.presets += 1;
            self.left = self.rules.frames;
        } else if word & TRIGGER == 0 {
            self.left = 0;
        }
        let is_last = self.left == 1;
        self.left = self.left.saturating_sub(1);
        if is_bad {
            self.clear(Cleared::BadOutputs);
        }
        is_last.then(|| (self.rules.value)(word, &Known { before: before.unwrap_or(0), ..*known }))
    }

    /// The last word no longer counts.
    pub fn clear(&mut self, cleared: Cleared) {
        if cleared == Cleared::End {
            (self.presets, self.rested) = (0, u8::MAX);
        }
        if (self.rules.clears)(cleared) {
            (self.before, self.left) = (None, 0);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rstest::rstest;

    const KNOWN: Known = Known { range: 8192, user_range: 4096, preset_value: 7, before: 0 };

    fn take(rules: Rules, words: &[Option<u32>]) -> alloc::vec::Vec<Option<u64>> {
        let mut trigger = Trigger::new(rules);
        words.iter().map(|word| trigger.take(*word, &KNOWN)).collect()
    }

    // Manual of the Sendix 58xx: the edge counts and nothing else, and the value is limited to the highest position.
    #[rstest]
    #[case::edge(&[Some(0x1234), Some(0x8000_1234), Some(0x8000_1234), Some(0x1234)], &[None, Some(0x1234), None, None])]
    #[case::first_frame(&[Some(0x8000_0000)], &[Some(0)])]
    #[case::value_changes(&[Some(0x8000_0010), Some(0x8000_0020)], &[Some(0x10), None])]
    #[case::again(&[Some(0x8000_0010), Some(0), Some(0x8000_0020)], &[Some(0x10), None, Some(0x20)])]
    #[case::bad_outputs(&[Some(0x8000_0010), None, Some(0x8000_0010)], &[Some(0x10), None, Some(0x10)])]
    #[case::highest(&[Some(0x8000_1FFF), Some(0), Some(0x8FFF_FFFF)], &[Some(8191), None, Some(8191)])]
    #[case::unused_bits(&[Some(0xF000_1234)], &[Some(0x1234)])]
    #[case::octet_order(&[Some(0x0000_0080)], &[None])]
    fn presets_by_word(#[case] words: &[Option<u32>], #[case] presets: &[Option<u64>]) {
        assert_eq!(take(Rules::default(), words), presets);
    }

    #[test]
    fn the_end_of_a_connection_is_an_edge() {
        let mut trigger = Trigger::new(Rules::default());
        assert_eq!(trigger.take(Some(TRIGGER), &KNOWN), Some(0));
        trigger.clear(Cleared::End);
        assert_eq!(trigger.take(Some(TRIGGER), &KNOWN), Some(0));
        let mut keeps = Trigger::new(Rules { clears: |_| false, ..Rules::default() });
        keeps.take(Some(TRIGGER), &KNOWN);
        keeps.clear(Cleared::End);
        assert_eq!(keeps.take(Some(TRIGGER), &KNOWN), None);
    }

    #[test]
    fn two_frames() {
        let rules = Rules { frames: 2, ..Rules::default() };
        let words = [Some(TRIGGER), Some(0), Some(TRIGGER | 5), Some(TRIGGER | 5), Some(TRIGGER | 5)];
        assert_eq!(take(rules, &words), [None, None, None, Some(5), None]);
    }
}
