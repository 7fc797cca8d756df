//! What an encoder with the encoder profile may do, whatever its manual says.

use crate::needs::Need;
use crate::tables::Group;
use core::time::Duration;
use encoder_profile::encoder_object::hooks::MemoryWrite;

/// The variations, by what they need.
pub static GROUPS: &[Group] = &[
    Group {
        needs: &[Need::EncoderProfile, Need::Parameter(964)],
        deviations: permitted! {
            "software-of-a-later-year" "P964 and, if present, P975 contain a later year of the software."
                "the manuals print the position of the year, not the year"
                => |d| d.encoder.element(|_, at, year| if let (964 | 975, 3) = at { year + 1 } else { year });
        },
    },
    Group {
        needs: &[Need::EncoderProfile, Need::Profinet],
        deviations: permitted! {
            "presets-fast" "An offset is stored in a tenth of the time, so a preset is answered earlier."
                "the manuals print no minimum time for a preset"
                => |d| d.encoder.store(|_, write| write.map(|write| match write {
                    MemoryWrite::Offset { offset, takes } => MemoryWrite::Offset { offset, takes: takes / 10 },
                    MemoryWrite::PresetValue { .. } => write,
                }));
            "ready-late" "The first good data come 50 ms after the end of the parameters."
                "the manuals are silent about the time from the end of the parameters to ApplicationReady"
                => |d| d.encoder.ready(|_, _| Duration::from_millis(50));
        },
    },
];
