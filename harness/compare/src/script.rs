//! The script of a conversation: the steps with their timing.
//!
//! Between two steps the script waits as long as the controller did. This module must not know frames or devices.

use super::action::ControllerAction;
use super::conversation::Conversation;
use std::time::Duration;

/// Shorter waits are within the duration of the harness's own steps.
pub(super) const SHORTEST: Duration = Duration::from_millis(3);
/// Longer waits are cut to this where time does not matter.
pub const LONGEST: Duration = Duration::from_secs(60);

/// The steps of a conversation with the waits between them.
pub fn script(conversation: &Conversation) -> Vec<ControllerAction> {
    let mut script = Vec::new();
    let mut last = None;
    for asked in &conversation.actions {
        let waited = last.map_or(Duration::ZERO, |last| asked.at.since(last)).min(LONGEST);
        if waited >= SHORTEST {
            // Whole milliseconds: the loss is less than a cycle of a usual connection.
            script.push(ControllerAction::Wait(Duration::from_millis(waited.as_millis() as u64)));
        }
        script.push(asked.ask.clone());
        last = Some(asked.done);
    }
    script
}
