//! Deviations of the generic PROFINET IO device, except for those of its stack.

use super::{Deviation, Group};
use crate::needs::Need;
use device_stack::profinet::{DiagnosisSeverity, StackCheck};
use reference_devices::manuals;
use wire::octets::ByteOrder;

/// The deviations, by what they need.
pub static GROUPS: &[Group] = &[Group { needs: &[Need::Of(&manuals::PROFINET_IO)], deviations: BUGS }];

const BUGS: &[Deviation] = bugs! {
    "any-name-taken" "A name that breaks the naming rules is accepted."
        => |d| d.stack.check(|check, right| right || matches!(check, StackCheck::Name(_)));
    "no-name-taken" "Every name is refused."
        => |d| d.stack.check(|check, right| right && !matches!(check, StackCheck::Name(_)));
    "little-endian-calls-garbled" "The NDR header of a little-endian call is read as big-endian, so the call fails."
        => |d| d.stack.call(|_, header, body| if header.order() == ByteOrder::Little { body.clear() });
    "name-lost-at-power-off" "The station name is lost at power-off."
        => |d| d.stack.set_station(|_, _, stored| stored.name.clear());
    "outputs-reversed" "The bytes of the outputs are used in reverse order."
        => |d| d.stack.outputs(|_, _, data| if let Some(data) = data { data.reverse() });
    "diagnosis-never-withdrawn" "A diagnosis stays after its fault has disappeared."
        => |d| d.stack.diagnosis(|change, is_noted| is_noted && change.appears);
    "fault-reported-as-maintenance" "A fault is reported as maintenance required."
        => |d| d.stack.diagnosis(|change, is_noted| {
            change.diagnosis.severity = DiagnosisSeverity::MaintenanceRequired;
            is_noted
        });
    "diagnosis-of-another-slot" "A diagnosis names another slot than that of the fault."
        => |d| d.stack.diagnosis(|change, is_noted| {
            change.diagnosis.slot = 2;
            is_noted
        });
};
