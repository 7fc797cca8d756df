//! Deviations of the PROFINET stack in the records with its connections (ARData).

use super::record_access::missing;
use super::{Deviation, Group};
use crate::needs::Need;
use crate::seams::stack::Stack;
use alloc::vec::Vec;

/// The deviations, by what they need.
pub static GROUPS: &[Group] = &[Group { needs: &[Need::Profinet], deviations: BUGS }];

const RECORDS: [u16; 2] = [0xF020, 0xF820];
/// Block header and number of connections.
const HEAD: usize = 8;
/// From the start of a connection: AR type, length of the name, and what comes before the name.
const AR_TYPE: usize = 52;
const NAME_LENGTH: usize = 64;
const NAME: usize = 66;
const SUPERVISOR: u8 = 6;

const BUGS: &[Deviation] = bugs! {
    "connections-not-read" "The records with the connections cannot be read." => |d| missing(&mut d.stack, &RECORDS);
    "connections-empty" "The records with the connections list none." => |d| connections(&mut d.stack, Vec::clear);
    "connections-kept" "The record with the connections also lists the last one that has ended." => |d| {
        let mut last = None;
        connections(&mut d.stack, move |list| {
            let kept = last.take();
            last = list.last().cloned().or_else(|| kept.clone());
            if list.is_empty() {
                list.extend(kept);
            }
        });
    };
    "connections-of-one-controller" "The record lists one connection only." => |d| connections(&mut d.stack, |list| {
        list.truncate(1);
    });
    "connections-of-controllers-only" "The record does not list connections of supervisors." => |d| connections(&mut d.stack, |list| {
        list.retain(|one| one[AR_TYPE + 1] != SUPERVISOR);
    });
    "connections-of-another-kind" "The record lists connections of controllers as those of a redundant system."
        => |d| connections(&mut d.stack, |list| {
            list.iter_mut().filter(|one| one[AR_TYPE + 1] != SUPERVISOR).for_each(|one| one[AR_TYPE + 1] = 0x20);
        });
    "connections-with-repeated-apis" "The record lists the API of a connection once for each of two submodules."
        => |d| connections(&mut d.stack, |list| {
            for one in list {
                let at = apis(one);
                if one[at + 1] == 1 {
                    one[at + 1] = 2;
                    // What follows the list are zeros, as API 0 is.
                    one.extend_from_within(at + 4..at + 8);
                }
            }
        });
    "connections-without-cyclic-data" "The record lists connections without their cyclic data." => |d| connections(&mut d.stack, |list| {
        for one in list {
            let at = cyclic(one);
            let count = usize::from(one[at + 1]);
            one[at + 1] = 0;
            one.drain(at + 4..at + 4 + 12 * count);
        }
    });
};

/// Where a connection has the number of its cyclic connections.
fn cyclic(connection: &[u8]) -> usize {
    // The padded name, and the length of an empty name with its padding.
    (NAME + usize::from(connection[NAME_LENGTH + 1])).next_multiple_of(4) + 4
}

/// Where a connection has the number of its APIs.
fn apis(connection: &[u8]) -> usize {
    let at = cyclic(connection);
    at + 4 + 12 * usize::from(connection[at + 1])
}

/// The length of a connection.
fn length(connection: &[u8]) -> usize {
    let apis = apis(connection);
    apis + 4 + 4 * usize::from(connection[apis + 1]) + 4
}

/// Changes the connections in both records.
fn connections(stack: &mut Stack, mut change: impl FnMut(&mut Vec<Vec<u8>>) + 'static) {
    stack.record(move |index, data| {
        if !RECORDS.contains(&index) || data.len() < HEAD {
            return;
        }
        let mut rest = data.split_off(HEAD);
        let mut list = Vec::new();
        while !rest.is_empty() {
            let next = rest.split_off(length(&rest));
            list.push(core::mem::replace(&mut rest, next));
        }
        change(&mut list);
        data[7] = list.len() as u8;
        data.extend(list.concat());
        let length = (data.len() - 4) as u16;
        data[2..4].copy_from_slice(&length.to_be_bytes());
    });
}
