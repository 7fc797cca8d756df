//! What was heard as a script: the steps in their timing.
//!
//! Between two steps the script waits as long as the controller did. This room must not know frames or devices.

use super::ask::Ask;
use super::heard::Conversation;
use std::time::Duration;

/// Shorter waits than this are how long our own steps take.
pub(super) const SHORTEST: Duration = Duration::from_millis(3);
/// Longer waits are cut to this where time does not matter.
pub const LONGEST: Duration = Duration::from_secs(60);

/// The steps of a conversation with the waits between them.
pub fn script(heard: &Conversation) -> Vec<Ask> {
    let mut script = Vec::new();
    let mut last = None;
    for asked in &heard.asked {
        let waited = last.map_or(Duration::ZERO, |last| asked.at.since(last)).min(LONGEST);
        if waited >= SHORTEST {
            // Whole milliseconds: what is lost is less than a cycle of a usual connection.
            script.push(Ask::Wait(Duration::from_millis(waited.as_millis() as u64)));
        }
        script.push(asked.ask.clone());
        last = Some(asked.done);
    }
    script
}
