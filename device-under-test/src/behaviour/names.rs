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
    /// Whether the labels are looked at, and not the total length alone.
    pub checks_labels: bool,
}

impl Default for Names {
    fn default() -> Names {
        Names {
            is_allowed: |octet| octet.is_ascii_alphanumeric() || octet == b'-',
            may_begin: |octet| octet != b'-',
            may_end: |octet| octet != b'-',
            checks_labels: true,
        }
    }
}
