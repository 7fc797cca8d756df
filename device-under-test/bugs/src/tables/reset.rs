//! Bugs of the factory reset.

use super::Group;
use crate::needs::Need;
use alloc::rc::Rc;
use core::cell::Cell;
use device_stack::profinet::StationData;
use encoder_profile::checks::EncoderCheck;
use encoder_profile::facts::ClearedData;
use encoder_profile::hooks::{EncoderHooks, EncoderView, RetainedEncoderData};

/// The deviations, by what they need.
pub static GROUPS: &[Group] = &[Group {
    needs: &[Need::Profinet, Need::EncoderProfile],
    deviations: bugs! {
        "reset-refused-while-connected" "A factory reset is refused during data exchange."
            => |d| d.checks.set(EncoderCheck::FactoryReset { is_connected: true }, false);
        "reset-needs-a-connection" "A factory reset is refused without data exchange."
            => |d| d.checks.set(EncoderCheck::FactoryReset { is_connected: false }, false);
        "reset-keeps-preset-value" "P65000 survives the factory reset."
            => |d| d.encoder.reset(|view, _, left| RetainedEncoderData { preset_value: view.preset_value, ..left });
        "preset-value-of-erased-memory" "After a factory reset all bits of P65000 are set."
            => |d| d.encoder.reset(|_, clears, left| if clears.application {
                RetainedEncoderData { preset_value: u32::MAX, ..left }
            } else {
                left
            });
        "reset-keeps-offset" "The offset survives the factory reset."
            => |d| d.encoder.reset(reset_keeps_offset);
        "reset-keeps-offset-unseen" "The offset survives the factory reset, and P65001 always shows it as 0."
            => |d| {
                d.encoder.reset(reset_keeps_offset);
                d.encoder.element(|_, at, right| if at == (65001, 8) { 0 } else { right });
            };
        "reset-keeps-name" "The station name survives the factory reset."
            => |d| d.encoder.reset(|view, clears, left| {
                reset_station(view, clears, left, |before| StationData { name: before.name.clone(), ..StationData::default() })
            });
        "reset-gives-a-name" "After a factory reset the station has a default name."
            => |d| d.encoder.reset(|view, clears, left| {
                reset_station(view, clears, left, |_| StationData { name: b"encoder".to_vec(), ..StationData::default() })
            });
        "reset-keeps-address" "The IP address survives the factory reset."
            => |d| d.encoder.reset(|view, clears, left| {
                reset_station(view, clears, left, |before| StationData {
                    ip: before.ip,
                    mask: before.mask,
                    ..StationData::default()
                })
            });
        "reset-keeps-gateway" "The gateway survives the factory reset."
            => |d| d.encoder.reset(|view, clears, left| {
                reset_station(view, clears, left, |before| StationData { gateway: before.gateway, ..StationData::default() })
            });
        "reset-of-ram-only" "Name and addresses from before the factory reset are restored by a power cycle."
            => |d| d.encoder.add(ResetOfRamOnly::default());
        "serial-number-erased" "A factory reset erases the serial number."
            => |d| {
                let is_erased = Rc::new(Cell::new(false));
                let reset = is_erased.clone();
                d.encoder.reset(move |_, _, left| { reset.set(true); left });
                d.stack.im0(move |im0| if is_erased.get() { im0.serial_number = [b' '; 16] });
            };
    },
}];

fn reset_keeps_offset(view: &EncoderView<'_>, _: ClearedData, left: RetainedEncoderData) -> RetainedEncoderData {
    RetainedEncoderData { offset: view.measuring.offset, ..left }
}

/// Changes the station data that remain after a reset, given the previous ones.
fn reset_station(
    view: &EncoderView<'_>,
    clears: ClearedData,
    left: RetainedEncoderData,
    leaves: fn(&StationData) -> StationData,
) -> RetainedEncoderData {
    if clears.station { RetainedEncoderData { station: leaves(view.store.station.stored()), ..left } } else { left }
}

#[derive(Default)]
struct ResetOfRamOnly {
    before: Option<StationData>,
}

impl EncoderHooks for ResetOfRamOnly {
    fn reset(&mut self, view: &EncoderView<'_>, clears: ClearedData, left: RetainedEncoderData) -> RetainedEncoderData {
        if clears.station {
            self.before = Some(view.store.station.stored().clone());
        }
        left
    }

    fn load(&mut self, _: &EncoderView<'_>, retained: RetainedEncoderData) -> RetainedEncoderData {
        RetainedEncoderData { station: self.before.take().unwrap_or(retained.station), ..retained }
    }
}
