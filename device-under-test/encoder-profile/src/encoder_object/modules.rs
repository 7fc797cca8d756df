//! The submodules of an encoder and its identification data.

use crate::encoder_object::hooks::EncoderHooks;
use crate::facts::{EncoderVariant, ManualFacts, SubmoduleFacts};
use crate::profidrive::telegram::Telegram;
use alloc::format;
use alloc::vec::Vec;
use device_stack::Attached;
use device_stack::profinet::{IoIdentity, PluggableSubmodule};

/// API of the encoder profile.
pub const ENCODER_API: u32 = 0x3D00;
/// Slot of the encoder object.
pub const ENCODER_SLOT: u16 = 1;
/// Subslot of the parameter access point.
pub const ACCESS_POINT_SUBSLOT: u16 = 1;
/// Ident of the submodule in slot 0. No manual specifies it.
const SUBMODULE_OF_SLOT_0: u32 = 1;

/// Every submodule that can be plugged. Alternatives for one subslot follow each other.
pub(super) fn plugs(
    facts: &ManualFacts,
    variant: &EncoderVariant,
    hooks: &Attached<dyn EncoderHooks>,
) -> Vec<PluggableSubmodule> {
    let fixed = |api, slot, module_ident, submodule_ident| PluggableSubmodule {
        api,
        slot,
        module_ident,
        subslot: 1,
        submodule_ident,
        input_octets: 0,
        output_octets: 0,
    };
    let mut plugs = Vec::from([fixed(0, 0, variant.access_point, SUBMODULE_OF_SLOT_0)]);
    plugs
        .extend(facts.modules.iter().map(|module| fixed(ENCODER_API, ENCODER_SLOT, module.ident, module.access_point)));
    let submodules = facts.modules.iter().flat_map(|module| module.submodules.iter().map(|one| (module.ident, one)));
    let mut with_data: Vec<PluggableSubmodule> = submodules
        .map(|(module_ident, submodule)| PluggableSubmodule {
            api: ENCODER_API,
            slot: ENCODER_SLOT,
            module_ident,
            subslot: submodule.subslot,
            submodule_ident: submodule.ident,
            input_octets: reported_input_octets(submodule.telegram, hooks),
            output_octets: submodule.telegram.output_octets,
        })
        .collect();
    with_data.sort_by_key(|plug| plug.subslot);
    plugs.extend(with_data);
    plugs
}

/// The input length of a telegram in bytes, as reported to the stack.
pub fn reported_input_octets(telegram: &Telegram, hooks: &Attached<dyn EncoderHooks>) -> u16 {
    hooks.apply(telegram.input_octets, |hooks, right| hooks.input_octets(telegram, right))
}

/// The plugged submodules with data; without any, the default one.
pub(super) fn submodules_in_use(
    facts: &'static ManualFacts,
    plugged: &[PluggableSubmodule],
) -> Vec<&'static SubmoduleFacts> {
    let of_encoder = plugged.iter().filter(|plug| (plug.api, plug.slot) == (ENCODER_API, ENCODER_SLOT));
    let matching = of_encoder.filter_map(|plug| {
        let module = facts.modules.iter().find(|module| module.ident == plug.module_ident)?;
        module.submodules.iter().find(|one| (one.subslot, one.ident) == (plug.subslot, plug.submodule_ident))
    });
    let mut in_use: Vec<&'static SubmoduleFacts> = matching.collect();
    if in_use.is_empty() {
        in_use.extend(facts.modules.iter().flat_map(|module| module.submodules).next());
    }
    in_use
}

/// The identification data of a specimen with this MAC address. Its last three bytes are the serial number.
pub fn identity(facts: &ManualFacts, variant: &EncoderVariant, mac: [u8; 6]) -> IoIdentity {
    let [.., a, b, c] = mac;
    IoIdentity {
        vendor_id: facts.identity.vendor_id,
        device_id: facts.identity.device_id,
        station_type: variant.station_type,
        order_id: variant.order_id,
        serial_number: format!("{a:02X}{b:02X}{c:02X}"),
        ports: facts.identity.ports,
        hardware_revision: facts.identity.hardware_revision,
        software_revision: facts.identity.software_revision,
        revision_counter: 0,
        profile_id: ENCODER_API as u16,
        profile_specific_type: 0,
        im_version: [1, 1],
        im_supported: facts.identity.im_supported,
        boot_time: facts.timing.boot,
        has_fast_start_up: false,
    }
}
