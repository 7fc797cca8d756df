//! Word tables of names that every device has.

/// A built-in word table: words and their numbers.
pub type Table = &'static [(&'static str, i64)];

/// `io.cyclic`.
pub const CYCLIC: Table = &[("running", 0), ("paused", 1)];
/// `io.global_control`.
pub const CLOCK: Table = &[("running", 0), ("stopped", 1)];
/// `io.alarm_acknowledge`.
pub const ALARM_ACKNOWLEDGE: Table = &[("given", 0), ("received", 1), ("held", 2)];
/// `device`.
pub const DELIVERY: Table = &[("as_delivered", 0)];
/// `io.output_status`, `io.input_status`, `io.consumer_status`.
pub const STATUS: Table = &[("bad", 0), ("good", 1)];
/// `connection`.
pub const CONNECTION: Table = &[("none", 0), ("data", 1)];
/// `power`, `link`.
pub const UP_DOWN: Table = &[("down", 0), ("up", 1)];
/// `fault.x`.
pub const PRESENCE: Table = &[("absent", 0), ("present", 1)];
/// `button.x`.
pub const BUTTON: Table = &[("released", 0), ("pressed", 1)];
/// `alarm.change`: the specifier of the channel properties.
pub const ALARM_CHANGE: Table =
    &[("all_disappear", 0), ("appears", 1), ("disappears", 2), ("disappears_others_remain", 3)];
/// `alarm.severity`: from the maintenance bits of the channel properties.
pub const ALARM_SEVERITY: Table = &[("diagnosis", 0), ("maintenance_required", 1), ("maintenance_demanded", 2)];
/// Modes of a field that counts by itself, in addition to a number.
pub const COUNTING: Table = &[("counting", -1), ("held", -2)];

/// The word for a number.
pub fn word(table: Table, number: i64) -> Option<&'static str> {
    table.iter().find(|(_, value)| *value == number).map(|(word, _)| *word)
}

/// The number of a word.
pub fn number(table: Table, word: &str) -> Option<i64> {
    table.iter().find(|(name, _)| *name == word).map(|(_, value)| *value)
}
