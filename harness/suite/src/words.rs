//! Word tables of names that every device has.

/// A built-in word table: words and their numbers.
pub type WordList = &'static [(&'static str, i64)];

/// `io.cyclic`.
pub const CYCLIC: WordList = &[("running", 0), ("paused", 1)];
/// `io.global_control`.
pub const CLOCK: WordList = &[("running", 0), ("stopped", 1)];
/// `io.alarm_acknowledge`.
pub const ALARM_ACKNOWLEDGE: WordList = &[("given", 0), ("received", 1), ("held", 2)];
/// `device`.
pub const DELIVERY: WordList = &[("as_delivered", 0)];
/// `io.output_status`, `io.input_status`, `io.consumer_status`.
pub const STATUS: WordList = &[("bad", 0), ("good", 1)];
/// `connection`.
pub const CONNECTION: WordList = &[("none", 0), ("data", 1)];
/// `power`, `link`.
pub const UP_DOWN: WordList = &[("down", 0), ("up", 1)];
/// `fault.x`.
pub const PRESENCE: WordList = &[("absent", 0), ("present", 1)];
/// `button.x`.
pub const BUTTON: WordList = &[("released", 0), ("pressed", 1)];
/// `alarm.change`: the specifier of the channel properties.
pub const ALARM_CHANGE: WordList =
    &[("all_disappear", 0), ("appears", 1), ("disappears", 2), ("disappears_others_remain", 3)];
/// `alarm.severity`: from the maintenance bits of the channel properties.
pub const ALARM_SEVERITY: WordList = &[("diagnosis", 0), ("maintenance_required", 1), ("maintenance_demanded", 2)];
/// `alarm.priority`.
pub const ALARM_PRIORITY: WordList = &[("low", 0), ("high", 1)];
/// Modes of a field that counts by itself, in addition to a number.
pub const COUNTING: WordList = &[("counting", -1), ("held", -2)];

/// The word for a number.
pub fn word(table: WordList, number: i64) -> Option<&'static str> {
    table.iter().find(|(_, value)| *value == number).map(|(word, _)| *word)
}

/// The number of a word.
pub fn number(table: WordList, word: &str) -> Option<i64> {
    table.iter().find(|(name, _)| *name == word).map(|(_, value)| *value)
}
