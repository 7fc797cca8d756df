//! What an encoder may do, whatever its manual says.

use crate::needs::Need;
use crate::tables::Group;
use core::time::Duration;
use encoder_profile::encoder::Measuring;
use encoder_profile::encoder::measuring::{MeasuringSteps, OffsetSum, Sampled};
use encoder_profile::encoder::velocity::MeasuredWay;
use reference_devices::manuals;

/// How far positions of a shaft at rest may differ with a variation, in steps: the tolerance of the stand.
pub const POSITION_NOISE: [(&str, u32); 1] = [("position-flickers", 1)];

/// The variations, by what they need.
pub static GROUPS: &[Group] = &[
    Group {
        needs: &[Need::EncoderProfile, Need::Parameter(964)],
        deviations: permitted! {
            "software-of-a-later-year" "P964 and, if present, P975 contain a later year of the software."
                "the manuals print the position of the year, not the year"
                => |d| d.encoder.element(|_, at, year| if let (964 | 975, 3) = at { year + 1 } else { year });
            "software-of-another-day" "P964 and, if present, P975 contain another day and month of the software."
                "the manuals print the position of day and month, not the date"
                => |d| d.encoder.element(|_, at, date| if let (964 | 975, 4) = at { 3112 } else { date });
        },
    },
    Group {
        needs: &[Need::EncoderProfile, Need::Profinet],
        deviations: permitted! {
            "presets-fast" "An offset is stored in a tenth of the time, so a preset is answered earlier."
                "the manuals print no minimum time for a preset"
                => |d| d.encoder.offset_takes(|takes| takes / 10);
            "ready-at-once" "The first good data come with ApplicationReady right after the end of the parameters."
                "the manuals are silent about the time from the end of the parameters to ApplicationReady"
                => |d| d.encoder.ready(|_, _| Duration::ZERO);
            "ready-late" "The first good data come 50 ms after the end of the parameters."
                "the manuals are silent about the time from the end of the parameters to ApplicationReady"
                => |d| d.encoder.ready(|_, _| Duration::from_millis(50));
            "ready-very-late" "The first good data come 5 s after the end of the parameters."
                "the manuals are silent; IEC 61158-6-10: RemoteApplicationReadyTimeout is at least 20 s"
                => |d| d.encoder.ready(|_, _| Duration::from_secs(5));
            "serial-number-of-another-specimen" "The serial number is that of another specimen."
                "a serial number differs from specimen to specimen"
                => |d| d.encoder.load(|_, mut retained| {
                    retained.serial_number = "00ABCDEF2611".into();
                    retained
                });
        },
    },
    Group {
        needs: &[Need::OfEither(&manuals::LIKA_XAC77, &manuals::SICK_AFX60)],
        deviations: permitted! {
            "presets-in-three-times-the-time" "An offset is stored in three times the time, so a preset is answered later."
                "these manuals print no maximum time for a preset"
                => |d| d.encoder.offset_takes(|takes| takes * 3);
        },
    },
    Group {
        needs: &[Need::Of(&manuals::LIKA_XAC77)],
        deviations: permitted! {
            "preset-values-stored-at-once" "A preset value is stored within a millisecond."
                "the manuals print no minimum time for storing P65000"
                => |d| d.encoder.preset_value_takes(|_| Duration::from_millis(1));
        },
    },
    Group {
        needs: &[Need::Encoder],
        deviations: permitted! {
            "position-flickers" "Every second sample of the position is one unit higher, as at the edge between two steps."
                "the manuals give an accuracy and a repeatability of some steps, and no hysteresis"
                => |d| d.measuring.add(Flicker { is_up: false });
            "velocity-rounded-down" "The velocity is rounded toward zero."
                "the manuals are silent about the rounding of a velocity"
                => |d| d.velocity.velocity(|way, right| if right == way.velocity() { toward_zero(way) } else { right });
        },
    },
];

/// The velocity without the fraction of a unit, but for the last thousandth.
fn toward_zero(way: &MeasuredWay) -> i64 {
    MeasuredWay { steps: way.steps.saturating_mul(1000), ..*way }.velocity() / 1000
}

/// A position at the edge between two steps.
struct Flicker {
    is_up: bool,
}

impl MeasuringSteps for Flicker {
    fn sampled(&mut self, _: &Measuring, _: Sampled) {
        self.is_up = !self.is_up;
    }

    fn shifted(&mut self, sum: &OffsetSum, position: u64) -> u64 {
        let end = sum.saturates_at.unwrap_or(sum.range).max(1);
        match (self.is_up, sum.saturates_at) {
            (false, _) => position,
            (true, Some(_)) => (position + 1).min(end - 1),
            (true, None) => (position + 1) % end,
        }
    }
}
