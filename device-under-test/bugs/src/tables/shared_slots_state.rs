//! Deviations of the PROFINET stack with state about shared and exchanged submodules.

use alloc::vec::Vec;
use device_stack::profinet::{ArEvent, StackCheck, StackHooks};
use wire::profinet::alarm::{AlarmNotification, AlarmType};

/// Ends every connection when one is released.
#[derive(Default)]
pub struct EndsAllWithOne {
    is_due: bool,
}

impl StackHooks for EndsAllWithOne {
    fn connection(&mut self, event: ArEvent) {
        self.is_due |= event == ArEvent::Released;
    }

    fn aborts(&mut self, aborts: bool) -> bool {
        core::mem::take(&mut self.is_due) || aborts
    }
}

/// Ends the connections when a module is pulled.
#[derive(Default)]
pub struct EndsWithPull {
    is_due: bool,
}

impl StackHooks for EndsWithPull {
    fn alarm(&mut self, alarm: &mut AlarmNotification, is_sent: bool) -> bool {
        self.is_due |= alarm.alarm_type == AlarmType::PULL;
        is_sent
    }

    fn aborts(&mut self, aborts: bool) -> bool {
        core::mem::take(&mut self.is_due) || aborts
    }
}

/// Never gives a submodule again that was connected beside another connection.
#[derive(Default)]
pub struct StaysLocked {
    open: usize,
    taken: Vec<(u16, u16)>,
}

impl StackHooks for StaysLocked {
    fn check(&mut self, check: StackCheck<'_>, verdict: bool) -> bool {
        let StackCheck::OwnedByOther(slot, subslot) = check else { return verdict };
        let is_taken = self.taken.contains(&(slot, subslot));
        if !is_taken && self.open > 0 {
            self.taken.push((slot, subslot));
        }
        is_taken || verdict
    }

    fn connection(&mut self, event: ArEvent) {
        self.open = match event {
            ArEvent::Opened => self.open + 1,
            ArEvent::Released | ArEvent::Aborted | ArEvent::Ended => self.open.saturating_sub(1),
        };
    }
}
