//! Variations that the manuals permit: with each of them every case and every rule has to pass.

use super::Group;
use crate::needs::Need;
use wire::profibus::fdl::BitTimes;

/// By what they need.
pub static GROUPS: &[Group] = &[
    Group {
        needs: &[Need::Profibus],
        deviations: permitted! {
            "answers-at-max-tsdr" "Answers come 60 bits after the request, the latest that its GSD allows at every rate up to 500 kbit/s."
                "MaxTsdr of the GSD; IEC 61158-4-3, station delay of a responder"
                => |d| d.slave.delay(|min_tsdr| BitTimes(min_tsdr.0.max(60)));
        },
    },
    Group {
        needs: &[Need::EncoderProfile, Need::Parameter(964)],
        deviations: permitted! {
            "software-of-a-later-year" "P964 and, where there is one, P975 name a later year of the software."
                "the manuals print the place of the year, not the year"
                => |d| d.encoder.element(|_, at, year| if let (964 | 975, 3) = at { year + 1 } else { year });
        },
    },
];
