//! Bugs of where records answer and of what they do to the cyclic exchange.

use super::Deviation;
use core::time::Duration;

/// The bugs of this seam.
pub static BUGS: &[Deviation] = encoder_bugs! {
    "access-point-at-the-telegram" "Records answer at the subslot of the telegram only."
        => |b| b.records.answer_at = |asked, (api, slot, _)| asked == (api, slot, 2);
    "parameters-in-slot-0" "Records answer at the device access point only."
        => |b| b.records.answer_at = |asked, _| asked == (0, 0, 1);
    "records-at-every-submodule" "Records answer at each submodule of the encoder."
        => |b| b.records.answer_at = |(api, slot, _), access_point| (api, slot) == (access_point.0, access_point.1);
    "parameters-at-b02f" "The parameter access has the record B02Fh."
        => |b| b.records.parameter_access = 0xB02F;
    "record-read-freezes-position" "The signals of the telegram stand still while a parameter request is handled."
        => |b| b.records.hold_up = Duration::from_millis(20);
    "telegram-84-needs-class-4" "Telegram 84 is refused where class 4 is off."
        => |b| b.records.go_with = |telegram, class_4| class_4 || telegram.number != 84;
    "telegram-82-not-offered" "Telegram 82 is refused."
        => |b| b.records.go_with = |telegram, _| telegram.number != 82;
};
