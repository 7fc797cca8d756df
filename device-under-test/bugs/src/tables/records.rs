//! Bugs of the subslots that serve records, and of the effect of records on the cyclic exchange.

use super::Group;
use super::start::{PARAMETER_ACCESS, USER_PARAMETERS};
use crate::needs::Need;
use crate::seams::Deviations;
use alloc::collections::BTreeMap;
use alloc::vec::Vec;
use core::time::Duration;
use device_stack::profinet::{PluggableSubmodule, RecordAccess, RecordRefusal};
use encoder_profile::checks::EncoderCheck;
use encoder_profile::encoder_object::{ENCODER_API, ENCODER_SLOT};
use encoder_profile::facts::SubmoduleFacts;
use encoder_profile::hooks::{EncoderHooks, EncoderView, RecordOctets, SubmoduleInputs};
use encoder_profile::profidrive::telegram::{InputSignal, SignalImage};
use encoder_profile::profidrive::user_parameters::UserParameterData;
use station::Time;

/// The deviations, by what they need.
pub static GROUPS: &[Group] = &[
    // Subslots that serve records
    Group {
        needs: &[Need::Profinet, Need::EncoderProfile],
        deviations: bugs! {
            "access-point-at-the-telegram" "Records are served only at the subslot of the telegram."
                => |d| answer_at(d, |api, slot, subslot| (api, slot, subslot) == (ENCODER_API, ENCODER_SLOT, 2));
            "parameters-in-slot-0" "Records are served only at the device access point."
                => |d| answer_at(d, |api, slot, subslot| (api, slot, subslot) == (0, 0, 1));
            "records-at-every-submodule" "Records are served at each submodule of the encoder."
                => |d| answer_at(d, |api, slot, _| (api, slot) == (ENCODER_API, ENCODER_SLOT));
            "parameters-at-b02f" "The parameter access has the record index B02Fh."
                => |d| d.checks.check(|check, right| match check {
                    EncoderCheck::IsParameterAccess(index) => index == 0xB02F,
                    _ => right,
                });
        },
    },
    // Effect on cyclic data
    Group {
        needs: &[Need::EncoderProfile],
        deviations: bugs! {
            "record-read-freezes-position" "The signals of the telegram are frozen while a parameter request is processed."
                => |d| d.encoder.add(ReadFreezesPosition::default());
        },
    },
    // User parameters that depend on the telegram
    Group {
        needs: &[Need::Profinet, Need::Telegram(84)],
        deviations: bugs! {
            "telegram-84-needs-class-4" "Telegram 84 is refused with class 4 off."
                => |d| d.encoder.write_record(|view, access, octets| refuse(access, octets, |user| number(view) == 84 && !user.class_4));
        },
    },
    Group {
        needs: &[Need::Profinet, Need::Telegram(82)],
        deviations: bugs! {
            "telegram-82-not-offered" "Telegram 82 is refused."
                => |d| d.encoder.write_record(|view, access, octets| refuse(access, octets, |_| number(view) == 82));
        },
    },
];

fn answer_at(d: &mut Deviations, at: fn(u32, u16, u16) -> bool) {
    d.checks.check(move |check, right| match check {
        EncoderCheck::RecordAnswersAt(api, slot, subslot) => at(api, slot, subslot),
        _ => right,
    });
}

/// The number of the telegram in use.
fn number(view: &EncoderView<'_>) -> u16 {
    view.submodules[0].telegram.number
}

/// Refuses user parameters for which `is_refused` returns `true`.
pub fn refuse(
    access: &RecordAccess,
    octets: RecordOctets,
    is_refused: impl FnOnce(&UserParameterData) -> bool,
) -> RecordOctets {
    let user = octets.as_ref().ok().and_then(|octets| UserParameterData::parse(octets));
    match user.filter(|_| access.index == USER_PARAMETERS) {
        Some(user) if is_refused(&user) => Err(RecordRefusal::InvalidParameter),
        _ => octets,
    }
}

/// For how long a parameter request freezes the signals.
const HELD_UP: Duration = Duration::from_millis(20);

/// The last inputs of each subslot, and until when they are repeated.
#[derive(Default)]
struct ReadFreezesPosition {
    until: Option<Time>,
    sent: BTreeMap<u16, Vec<u8>>,
}

impl EncoderHooks for ReadFreezesPosition {
    fn plugged(&mut self, plugged: Vec<PluggableSubmodule>) -> Vec<PluggableSubmodule> {
        self.sent.clear();
        plugged
    }

    fn write_record(&mut self, view: &EncoderView<'_>, access: &RecordAccess, octets: RecordOctets) -> RecordOctets {
        if access.index == PARAMETER_ACCESS {
            self.until = Some(view.now + HELD_UP);
        }
        octets
    }

    fn inputs(
        &mut self,
        view: &EncoderView<'_>,
        submodule: &SubmoduleFacts,
        _: &SignalImage,
        right: SubmoduleInputs,
    ) -> SubmoduleInputs {
        let sent = self.sent.entry(submodule.subslot).or_default();
        let is_held_up = self.until.is_some_and(|until| view.now < until) && sent.len() == right.octets.len();
        // ZSW2_ENC is not frozen.
        let begin = if submodule.telegram.inputs.first() == Some(&InputSignal::Zsw2Enc) { 2 } else { 0 };
        let held = if is_held_up { core::mem::take(sent) } else { right.octets.clone() };
        *sent = [&right.octets[..begin], &held[begin..]].concat();
        SubmoduleInputs { octets: sent.clone(), ..right }
    }
}
