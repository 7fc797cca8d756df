//! Identification and maintenance: I&M0, and the texts I&M1 to I&M3 that a user can write.

use crate::profinet::IoIdentity;
use wire::profinet::blocks::im::{Im0, ImText, SoftwareRevision, padded};

/// The texts I&M1 to I&M3. They are blank in factory state and survive a loss of power.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct ImTexts([ImText; 3]);

impl Default for ImTexts {
    fn default() -> ImTexts {
        ImTexts([
            ImText::Tag { function: [b' '; 32], location: [b' '; 22] },
            ImText::Date([b' '; 16]),
            ImText::Descriptor([b' '; 54]),
        ])
    }
}

impl ImTexts {
    /// The text I&M`number`, 1 to 3, if a device with this identity has it.
    pub(super) fn get(&self, identity: &IoIdentity, number: u16) -> Option<&ImText> {
        let is_supported = number < 16 && identity.im_supported & (1 << number) != 0;
        self.0.get(usize::from(number).checked_sub(1)?).filter(|_| is_supported)
    }

    /// Replaces the text of the same kind. I&M4 is not stored.
    pub(super) fn put(&mut self, text: ImText) {
        if let Some(stored) = self.0.iter_mut().find(|stored| stored.block() == text.block()) {
            *stored = text;
        }
    }
}

/// I&M0 of a device with this identity.
pub(super) fn im0(identity: &IoIdentity) -> Im0 {
    let [prefix, functional_enhancement, bug_fix, internal_change] = identity.software_revision;
    Im0 {
        vendor_id: identity.vendor_id,
        order_id: padded(identity.order_id),
        serial_number: padded(&identity.serial_number),
        hardware_revision: identity.hardware_revision,
        software_revision: SoftwareRevision { prefix, functional_enhancement, bug_fix, internal_change },
        revision_counter: identity.revision_counter,
        profile_id: identity.profile_id,
        profile_specific_type: identity.profile_specific_type,
        im_version: identity.im_version,
        im_supported: identity.im_supported,
    }
}
