//! Deviations of the PROFINET stack where controllers share a device, and where modules are pulled and plugged.

use super::shared_slots_state::{EndsAllWithOne, EndsWithPull, StaysLocked};
use super::{Deviation, Group};
use crate::needs::Need;
use crate::seams::stack::Stack;
use device_stack::profinet::StackCheck;
use reference_devices::manuals;
use wire::profinet::alarm::{AlarmNotification, AlarmType};
use wire::profinet::blocks::module_diff::{ArInfo, SubmoduleState};

/// The deviations, by what they need.
pub static GROUPS: &[Group] = &[Group { needs: &[Need::Of(&manuals::PROFINET_IO)], deviations: BUGS }];

const BUGS: &[Deviation] = bugs! {
    // Shared device
    "second-controller-refused" "A second controller is refused, although the GSDML says that two can share the device."
        => |d| d.stack.check(|check, right| match check {
            StackCheck::ConnectionLimit { is_exchange: true, others } => right && others == 0,
            _ => right,
        });
    "locked-called-own" "A submodule that another controller owns is reported as one of the connection's own."
        => |d| d.stack.difference(|_, differing| {
            let apis = differing.iter_mut().flat_map(|block| &mut block.apis);
            for submodule in apis.flat_map(|api| &mut api.modules).flat_map(|module| &mut module.submodules) {
                submodule.state = SubmoduleState::new(submodule.state.ident_info(), ArInfo::OWN, 0);
            }
        });
    "unusable-inputs-good" "The inputs of a submodule that is pulled, wrong or owned by another controller are good."
        => |d| d.stack.check(|check, right| right || matches!(check, StackCheck::Usable(..)));
    "unusable-outputs-consumed" "The outputs to a submodule that is pulled, wrong or owned by another controller have a good consumer status."
        => |d| d.stack.check(|check, right| right || matches!(check, StackCheck::Consumes(..)));
    "released-not-reported" "A controller that waits for a submodule is not informed when it is released."
        => |d| not_sent(&mut d.stack, AlarmType::RELEASED);
    "release-of-one-ends-all" "The release of one connection ends all others."
        => |d| d.stack.add(EndsAllWithOne::default());
    "released-slots-stay-locked" "A submodule that had an owner stays locked for every other controller after its release."
        => |d| d.stack.add(StaysLocked::default());
    "records-of-others-written" "Records of a submodule that another controller owns can be written."
        => |d| d.stack.check(|check, right| right || matches!(check, StackCheck::WritesOfOthers(_)));
    "records-of-others-not-read" "Records of a submodule that another controller owns cannot be read."
        => |d| d.stack.set(StackCheck::ReadsOfOthers, false);
    "diagnosis-to-all-controllers" "A diagnosis is reported to every controller that expects the submodule."
        => |d| d.stack.set(StackCheck::DiagnosisOfOthers, true);

    // Pull and plug
    "pull-not-reported" "A pulled module is not reported."
        => |d| not_sent(&mut d.stack, AlarmType::PULL);
    "pull-ends-connection" "A pulled module ends the connection."
        => |d| d.stack.add(EndsWithPull::default());
    "plug-not-reported" "A plugged module is not reported."
        => |d| not_sent(&mut d.stack, AlarmType::PLUG);
    "plug-reported-as-return" "A plugged module is reported as a submodule that has good data again."
        => |d| renamed(&mut d.stack, AlarmType::PLUG, AlarmType::RETURN_OF_SUBMODULE);
    "wrong-plug-reported-as-plug" "A module that does not belong into its slot is reported like one that does."
        => |d| renamed(&mut d.stack, AlarmType::PLUG_WRONG, AlarmType::PLUG);
    "plug-alarm-of-another-slot" "Alarms about pulled, plugged and released submodules name the next slot."
        => |d| d.stack.alarm(|alarm, is_sent| {
            alarm.slot += u16::from(is_about_plugs(alarm));
            is_sent
        });
    "plugged-good-at-once" "The inputs of a plugged submodule are good before the end of its parameters."
        => |d| d.stack.set(StackCheck::PlugAwaitsParameters, false);
    "plug-parameters-ignored" "The end of the parameters of a plugged or released submodule has no effect."
        => |d| d.stack.set(StackCheck::PlugBecomesReady, false);
    "plugged-listed-twice" "A submodule that is plugged while the device has no power is listed twice."
        => |d| d.stack.set(StackCheck::ReplacesPlugged, false);
    "plug-ready-not-sent" "A plugged or released submodule becomes ready without an ApplicationReady for it."
        => |d| d.stack.plug_ready(|_| None);
    "plug-ready-of-another-alarm" "The ApplicationReady for a plugged or released submodule has the sequence number of the next alarm."
        => |d| d.stack.plug_ready(|alarm| alarm.map(|alarm| alarm + 1));
};

fn is_about_plugs(alarm: &AlarmNotification) -> bool {
    let types = [AlarmType::PULL, AlarmType::PLUG, AlarmType::PLUG_WRONG, AlarmType::RELEASED];
    types.contains(&alarm.alarm_type)
}

/// Alarms of this type are not sent.
pub(super) fn not_sent(stack: &mut Stack, kind: AlarmType) {
    stack.alarm(move |alarm, is_sent| is_sent && alarm.alarm_type != kind);
}

/// Alarms of one type are sent as those of another.
pub(super) fn renamed(stack: &mut Stack, from: AlarmType, to: AlarmType) {
    stack.alarm(move |alarm, is_sent| {
        if alarm.alarm_type == from {
            alarm.alarm_type = to;
        }
        is_sent
    });
}
