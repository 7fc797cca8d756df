//! The preset without a handshake: one word with a value and a trigger bit.
//!
//! Bit 31 is the trigger. Each rising edge carries out an absolute preset to the value in the lower bits. Sources:
//! Kübler Sendix 58xx, 8.1 (ManTel860); SICK A3M60, 3.4.2 (IO·04 and IO·08).

use crate::profidrive::checks::{AttachedChecks, EncoderCheck};
use device_stack::Attached;

/// Bit 31, the trigger.
pub const TRIGGER: u32 = 1 << 31;

/// What a manual specifies about the preset without a handshake.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TriggerFacts {
    /// Mask of the value bits.
    pub value: u32,
    pub beyond_range: BeyondRange,
    /// Whether a trigger bit that is set in the first word of a connection counts as an edge.
    pub first_word_counts: bool,
}

/// How a value beyond the range is handled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BeyondRange {
    /// It is limited to the highest position.
    Limited,
    /// It is reduced modulo the range.
    Reduced,
}

impl TriggerFacts {
    /// The value in a word. There are `range` positions.
    pub fn value(&self, word: u32, range: u64) -> u64 {
        let value = u64::from(word & self.value);
        match self.beyond_range {
            BeyondRange::Limited => value.min(range - 1),
            BeyondRange::Reduced => value % range,
        }
    }
}

/// The step of the preset by a trigger that a deviation may change. The default changes nothing.
#[allow(unused_variables, reason = "the names document the step")]
pub trait TriggerSteps {
    /// The value of a preset in units, from its word and the number of positions.
    fn value(&mut self, word: u32, range: u64, right: u64) -> u64 {
        right
    }
}

/// Detects the trigger.
#[derive(Clone, Debug)]
pub struct TriggerDetector {
    /// The previous word; `None` before the first one of a connection.
    before: Option<u32>,
    checks: AttachedChecks,
    steps: Attached<dyn TriggerSteps>,
}

impl TriggerDetector {
    /// A trigger that has received no word yet.
    pub fn new(checks: AttachedChecks, steps: Attached<dyn TriggerSteps>) -> TriggerDetector {
        TriggerDetector { before: None, checks, steps }
    }

    /// Processes the word of one frame; `None` (bad outputs) counts as 0. Returns the value if a preset starts.
    ///
    /// `range` is the number of positions, at least 1.
    pub fn take(&mut self, facts: &TriggerFacts, word: Option<u32>, range: u64) -> Option<u64> {
        let now = word.unwrap_or(0);
        let before = self.before.replace(now);
        let was_clear = before.map_or(facts.first_word_counts, |before| before & TRIGGER == 0);
        let begins = self.checks.check(EncoderCheck::TriggersPreset { before, now }, was_clear && now & TRIGGER != 0);
        let value = facts.value(now, range);
        begins.then(|| self.steps.apply(value, |steps, value| steps.value(now, range, value)))
    }

    /// The connection has ended: drops the last word.
    pub fn ended(&mut self) {
        self.before = None;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rstest::rstest;

    const SENDIX: TriggerFacts =
        TriggerFacts { value: (1 << 28) - 1, beyond_range: BeyondRange::Limited, first_word_counts: true };
    const A3M60: TriggerFacts =
        TriggerFacts { value: !TRIGGER, beyond_range: BeyondRange::Reduced, first_word_counts: false };

    fn trigger() -> TriggerDetector {
        TriggerDetector::new(AttachedChecks::default(), Attached::NONE)
    }

    fn take(facts: &TriggerFacts, words: &[Option<u32>]) -> alloc::vec::Vec<Option<u64>> {
        let mut trigger = trigger();
        words.iter().map(|word| trigger.take(facts, *word, 8192)).collect()
    }

    // Manual of the Sendix 58xx, 8.1: only the edge triggers, and the value is limited to the highest position.
    #[rstest]
    #[case::edge(&[Some(0x1234), Some(0x8000_1234), Some(0x8000_1234), Some(0x1234)], &[None, Some(0x1234), None, None])]
    #[case::first_frame(&[Some(0x8000_0000)], &[Some(0)])]
    #[case::value_changes(&[Some(0x8000_0010), Some(0x8000_0020)], &[Some(0x10), None])]
    #[case::again(&[Some(0x8000_0010), Some(0), Some(0x8000_0020)], &[Some(0x10), None, Some(0x20)])]
    #[case::bad_outputs(&[Some(0x8000_0010), None, Some(0x8000_0010)], &[Some(0x10), None, Some(0x10)])]
    #[case::highest(&[Some(0x8000_1FFF), Some(0), Some(0x8FFF_FFFF)], &[Some(8191), None, Some(8191)])]
    #[case::unused_bits(&[Some(0xF000_1234)], &[Some(0x1234)])]
    #[case::byte_order(&[Some(0x0000_0080)], &[None])]
    fn presets_by_word(#[case] words: &[Option<u32>], #[case] presets: &[Option<u64>]) {
        assert_eq!(take(&SENDIX, words), presets);
    }

    // Manual of the A3M60, 3.4.2: bit 31 must be 0 before an edge counts.
    #[rstest]
    #[case::first_frame(&[Some(0x8000_0001), Some(0), Some(0x8000_2001)], &[None, None, Some(1)])]
    #[case::cleared(&[None, Some(0x8000_0002)], &[None, Some(2)])]
    fn presets_by_bit_31(#[case] words: &[Option<u32>], #[case] presets: &[Option<u64>]) {
        assert_eq!(take(&A3M60, words), presets);
    }

    #[test]
    fn the_first_word_of_the_next_connection_can_trigger() {
        let mut trigger = trigger();
        assert_eq!(trigger.take(&SENDIX, Some(TRIGGER), 8192), Some(0));
        trigger.ended();
        assert_eq!(trigger.take(&SENDIX, Some(TRIGGER), 8192), Some(0));
    }
}
