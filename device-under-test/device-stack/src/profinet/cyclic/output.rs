//! The outputs of one submodule in the frames that the device receives.

use super::super::hooks::AttachedStackHooks;
use crate::profinet::IoApplication;
use station::Time;

/// The position of the data of a submodule in the frame. Its IOPS follows them.
#[derive(Clone, Copy, Debug)]
pub(super) struct OutputOffset {
    pub slot: u16,
    pub subslot: u16,
    pub at: usize,
    pub octets: usize,
    pub is_usable: bool,
    pub was_good: bool,
}

impl OutputOffset {
    /// Says whether the submodule can receive outputs. Outputs that end are reported.
    pub(super) fn set_usable(
        &mut self,
        now: Time,
        is_usable: bool,
        application: &mut dyn IoApplication,
        hooks: &AttachedStackHooks,
    ) {
        self.is_usable = is_usable;
        if !is_usable && self.was_good {
            self.was_good = false;
            self.deliver(now, application, None, hooks);
        }
    }

    /// Passes new outputs to the application, or that they have ended.
    pub(super) fn deliver(
        &self,
        now: Time,
        application: &mut dyn IoApplication,
        data: Option<&[u8]>,
        hooks: &AttachedStackHooks,
    ) {
        if !hooks.is_any() {
            return application.outputs(now, self.slot, self.subslot, data);
        }
        let data = hooks.apply(data.map(<[u8]>::to_vec), |hooks, mut data| {
            hooks.outputs(self.slot, self.subslot, &mut data);
            data
        });
        application.outputs(now, self.slot, self.subslot, data.as_deref());
    }
}
