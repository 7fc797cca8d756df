//! Bugs of the factory reset.

use super::Deviation;
use device_stack::profinet::StationData;

/// The bugs of this seam.
pub static BUGS: &[Deviation] = encoder_bugs! {
    "reset-refused-while-connected" "A factory reset is refused while data are exchanged."
        => |b| b.reset.is_refused = |is_connected| is_connected;
    "reset-needs-a-connection" "A factory reset is refused while no data are exchanged."
        => |b| b.reset.is_refused = |is_connected| !is_connected;
    "reset-keeps-preset-value" "P65000 survives the factory reset."
        => |b| b.reset.preset_value = |before| before;
    "preset-value-of-erased-memory" "After a factory reset P65000 has all bits set."
        => |b| b.reset.preset_value = |_| u32::MAX;
    "reset-keeps-offset" "The offset survives the factory reset."
        => |b| b.reset.offset = |before| before;
    "reset-keeps-offset-unseen" "The offset survives the factory reset, and P65001 gives 0 for it at all times."
        => |b| {
            b.reset.offset = |before| before;
            b.at_encoder.element(|_, at, right| if at == (65001, 8) { 0 } else { right });
        };
    "reset-keeps-name" "The station name survives the factory reset."
        => |b| b.reset.station = |before| StationData { name: before.name.clone(), ..StationData::default() };
    "reset-gives-a-name" "After a factory reset the station has a name by default."
        => |b| b.reset.station = |_| StationData { name: b"encoder".to_vec(), ..StationData::default() };
    "reset-keeps-address" "The IP address survives the factory reset."
        => |b| b.reset.station = |before| StationData { ip: before.ip, mask: before.mask, ..StationData::default() };
    "reset-keeps-gateway" "The gateway survives the factory reset."
        => |b| b.reset.station = |before| StationData { gateway: before.gateway, ..StationData::default() };
    "reset-of-ram-only" "Name and addresses from before the factory reset are there again after a power cycle."
        => |b| b.reset.lasts = false;
    "serial-number-erased" "A factory reset erases the serial number."
        => |b| b.reset.identity = |identity| identity.serial_number.clear();
};
