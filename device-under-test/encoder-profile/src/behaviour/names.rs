//! Which station names are taken.

/// Station names.
#[derive(Clone, Copy, Debug)]
pub struct Names {
    /// Whether an octet may stand in a label.
    pub is_allowed: fn(u8) -> bool,
    /// Whether an octet may stand at the beginning of a label.
    pub may_begin: fn(u8) -> bool,
    /// Whether an octet may stand at the end of a label.
    pub may_end: fn(u8) -> bool,
    /// The greatest total length.
    pub longest: usize,
    /// The shortest length of a label.
    pub shortest_label: usize,
    /// The last word about a name, from what the rules say.
    pub last_word: fn(&[u8], bool) -> bool,
    /// Whether names are taken between a factory reset and the next start.
    pub takes_after_reset: bool,
    /// Whether the labels are looked at, and not the total length alone.
    pub checks_labels: bool,
}

impl Default for Names {
    fn default() -> Names {
        Names {
            is_allowed: |octet| octet.is_ascii_alphanumeric() || octet == b'-',
            may_begin: |octet| octet != b'-',
            may_end: |octet| octet != b'-',
            longest: 127,
            shortest_label: 1,
            last_word: |_, is_right| is_right,
            takes_after_reset: true,
            checks_labels: true,
        }
    }
}
