//! Variations that the manuals permit. With each of them, and with any combination, every case and every rule has to pass.
//!
//! A variation names the clause that leaves it free, or says that the manual is silent and which clause was looked for. It never
//! excuses a fault: no time exceeds a protocol timer, and frames keep their exact length.

mod a3m60;
mod afx60;
mod amt58;
mod encoder;
mod profibus;
mod profinet;
mod sendix;
mod xac77;

use super::Group;

pub use encoder::POSITION_NOISE;

/// The variations, by topic.
pub static GROUPS: &[&[Group]] = &[
    afx60::GROUPS,
    a3m60::GROUPS,
    amt58::GROUPS,
    encoder::GROUPS,
    profibus::GROUPS,
    profinet::GROUPS,
    sendix::GROUPS,
    xac77::GROUPS,
];
