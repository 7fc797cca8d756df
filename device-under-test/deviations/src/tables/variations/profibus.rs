//! What a PROFIBUS slave may do, whatever the manual of the encoder says.

use crate::needs::Need;
use crate::tables::Group;
use wire::profibus::fdl::BitTimes;

/// The variations, by what they need.
pub static GROUPS: &[Group] = &[Group {
    needs: &[Need::Profibus],
    deviations: permitted! {
        "answers-at-max-tsdr" "Answers come 60 bits after the request, the MaxTsdr of the GSD at every baud rate up to 500 kbit/s."
            "MaxTsdr of the GSD; IEC 61158-4-3, station delay of a responder"
            => |d| d.slave.delay(|min_tsdr| BitTimes(min_tsdr.0.max(60)));
    },
}];
