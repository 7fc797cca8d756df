//! Start parameters at other places: no manual of the SICK encoders prints where they are.
//!
//! A harness takes the places from [`start_layout`], as it takes those of a live device from its GSDML or GSD.

use crate::needs::Need;
use crate::seams::start_layout::{Place, StartLayout, StartTable};
use alloc::vec::Vec;
use deviation_hooks::Group;
use reference_devices::manuals::{SICK_A3M60, SICK_AFX60};
use reference_devices::models::{sick_a3m60, sick_afx60};

/// The name of the variation. With `:SEED` behind it the parameters are at other places for each seed.
pub const ELSEWHERE: &str = "start-parameters-elsewhere";
/// The seed without one in the name.
const SEED: u64 = 1;

/// The vendor's record of the AFS60 and AFM60: eight whole parameters.
const AFX60: StartTable = StartTable {
    record: Some(sick_afx60::start_record::RECORD),
    octets: sick_afx60::start_record::OCTETS,
    places: &[
        Place::Bytes(0, 1),
        Place::Bytes(1, 1),
        Place::Bytes(2, 1),
        Place::Bytes(3, 1),
        Place::Bytes(4, 1),
        Place::Bytes(5, 4),
        Place::Bytes(9, 4),
        Place::Bytes(13, 4),
    ],
};

/// The user bytes of the A3M60: ten switches and seven whole parameters.
const A3M60: StartTable = StartTable {
    record: None,
    octets: sick_a3m60::set_prm::OCTETS,
    places: &[
        Place::Bit(0, 0),
        Place::Bit(0, 1),
        Place::Bit(0, 2),
        Place::Bit(0, 3),
        Place::Bit(0, 4),
        Place::Bit(0, 5),
        Place::Bit(1, 0),
        Place::Bit(1, 1),
        Place::Bit(1, 2),
        Place::Bit(1, 3),
        Place::Bytes(2, 4),
        Place::Bytes(6, 4),
        Place::Bytes(10, 1),
        Place::Bytes(11, 1),
        Place::Bytes(12, 4),
        Place::Bytes(16, 4),
        Place::Bytes(20, 1),
    ],
};

/// The variation, for each encoder of which the manual does not print the places.
pub static GROUPS: &[Group] = &[
    Group {
        needs: &[Need::Of(&SICK_AFX60)],
        deviations: permitted! {
            "start-parameters-elsewhere" "The start-up parameters of the vendor are at other places, among parameters that the manual does not have."
                "3.6.10 to 3.6.17 print their values; where they are in their record is up to the GSDML"
                => |d| d.start_layout = Some((AFX60, AFX60.elsewhere(SEED)));
        },
    },
    Group {
        needs: &[Need::Of(&SICK_A3M60)],
        deviations: permitted! {
            "start-parameters-elsewhere" "The parameters of Set_Prm are at other places, among parameters that the manual does not have."
                "section 3.6 prints their values; where they are in Set_Prm is up to the GSD"
                => |d| d.start_layout = Some((A3M60, A3M60.elsewhere(SEED)));
        },
    },
];

/// The seed in a name `start-parameters-elsewhere:SEED`; `None` for all others.
pub fn seed(name: &str) -> Option<u64> {
    name.strip_prefix(ELSEWHERE)?.strip_prefix(':')?.parse().ok()
}

/// The tables of the devices of a manual and the layout that the named variations give them, `varied` being what the names stand for;
/// `None` if they leave it as it is.
pub fn start_layout<'a>(
    manual: &str,
    names: impl Iterator<Item = &'a str>,
    mut varied: impl Iterator<Item = &'a str>,
) -> Option<(StartTable, StartLayout)> {
    let table = [(SICK_AFX60.name, AFX60), (SICK_A3M60.name, A3M60)].into_iter().find(|(of, _)| *of == manual)?.1;
    let seeds: Vec<u64> = names.filter_map(seed).collect();
    varied.any(|name| name == ELSEWHERE).then(|| (table, table.elsewhere(*seeds.last().unwrap_or(&SEED))))
}
