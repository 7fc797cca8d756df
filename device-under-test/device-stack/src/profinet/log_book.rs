//! The log book of the station: record 0xF830, with an entry for each connection that ended by an abort.

use super::stack::Stack;
use alloc::vec::Vec;
use station::Time;
use wire::octets::{Append, ByteOrder};
use wire::profinet::blocks::{BlockHeader, BlockType};
use wire::profinet::rpc::Uuid;
use wire::profinet::status::{AbortReason, PnioStatus};

/// Number of entries that are kept. The oldest one is dropped first.
const ENTRIES: usize = 16;

/// An entry of the log book.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct LogBookEntry {
    time: Time,
    ar_uuid: Uuid,
    status: PnioStatus,
}

impl Stack {
    /// Notes that the connection `ar_uuid` was aborted for `reason`.
    pub(super) fn note_abort(&mut self, now: Time, ar_uuid: Uuid, reason: AbortReason) {
        if self.log_book.len() >= ENTRIES {
            self.log_book.remove(0);
        }
        self.log_book.push(LogBookEntry { time: now, ar_uuid, status: PnioStatus::abort(reason) });
    }

    /// Appends the LogBookData block: the time now, the number of entries, and for each its time, the UUID of its
    /// connection, its PNIO status and a detail of four bytes.
    pub(super) fn write_log_book(&self, now: Time, out: &mut Vec<u8>) {
        BlockHeader::write(BlockType::LOG_BOOK_DATA, out, |out| {
            out.put(&now.as_nanos().to_be_bytes());
            out.put_u16(self.log_book.len() as u16);
            for entry in &self.log_book {
                out.put(&entry.time.as_nanos().to_be_bytes());
                entry.ar_uuid.write(out, ByteOrder::Big);
                out.put_u32(entry.status.into());
                out.put_u32(0);
            }
        });
    }
}
