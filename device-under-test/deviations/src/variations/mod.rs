//! Variations that the manuals permit. With each of them, and with any combination, every case and every rule has to pass.
//!
//! A variation names the clause that leaves it free, or says that the manual is silent and which clause was looked for. It never
//! excuses a fault: no time exceeds a protocol timer, and frames keep their exact length.

/// Defines permitted variations, one per line: `"name" "Sentence." "the clause that permits it" => |d| attach;`.
macro_rules! permitted {
    ($($name:literal $sentence:literal $clause:literal => |$deviations:ident| $attach:expr;)*) => {
        &[$(deviation_hooks::Deviation {
            name: $name,
            sentence: $sentence,
            kind: deviation_hooks::DeviationKind::Permitted { clause: $clause },
            attach: |$deviations: &mut deviation_hooks::seams::Deviations| { $attach; },
        }),*]
    };
}

mod a3m60;
mod a3m60_state;
mod afx60;
mod amt58;
mod amt58_state;
mod encoder;
mod profibus;
mod profibus_state;
mod profinet;
mod requests;
mod rounding;
mod sendix;
mod sendix_state;
mod start_layouts;
mod xac77;
mod xac77_signals;

use deviation_hooks::Group;

pub use encoder::POSITION_NOISE;
pub use profinet::description::{CHANGES, DescriptionChange};
pub use profinet::vendor_records::VendorRecord;
pub use start_layouts::{ELSEWHERE, seed as start_layout_seed, start_layout};

/// The variations, by topic.
pub static GROUPS: &[&[Group]] = &[
    afx60::GROUPS,
    a3m60::GROUPS,
    amt58::GROUPS,
    encoder::GROUPS,
    profibus::GROUPS,
    profinet::cyclic::GROUPS,
    profinet::description::GROUPS,
    profinet::discovery::GROUPS,
    profinet::identity::GROUPS,
    profinet::ip_packets::GROUPS,
    profinet::path::GROUPS,
    profinet::ports::GROUPS,
    profinet::rpc::GROUPS,
    profinet::snmp::GROUPS,
    profinet::startup::GROUPS,
    profinet::times::GROUPS,
    sendix::GROUPS,
    start_layouts::GROUPS,
    xac77::GROUPS,
];
