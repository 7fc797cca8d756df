//! Fast start-up: record 0x8090 (PDInterfaceFSUDataAdjust) says whether, when and how often the device says Hello once it is linked.
//!
//! The record is kept over a loss of power. Source: the fields that tshark decodes (`pn_io.fs_hello_*`).

use super::hooks::StackCheck;
use super::plugged::{INTERFACE_SUBSLOT, SubmoduleAddress};
use super::stack::Stack;
use alloc::vec::Vec;
use station::Duration;
use wire::octets::ByteReader;
use wire::profinet::blocks::{BlockHeader, BlockType, RawBlock};
use wire::profinet::status::RecordError;

/// PDInterfaceFSUDataAdjust: padding of two and the blocks below.
const FSU_DATA_ADJUST: BlockType = BlockType(0x0608);
/// FSHelloBlock: padding of two; mode, interval, number of repetitions and delay, four bytes each; times in milliseconds.
const FS_HELLO: BlockType = BlockType(0x0600);
/// FSParameterBlock and FastStartUpBlock, which the device accepts and does not use.
const OTHER_BLOCKS: [BlockType; 2] = [BlockType(0x0601), BlockType(0x0602)];

/// What the last record said.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct FastStartUp {
    record: Vec<u8>,
    hello: Option<HelloSettings>,
}

/// When and how often the device says Hello.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct HelloSettings {
    /// From the link to the first one.
    pub delay: Duration,
    /// From one to the next.
    pub interval: Duration,
    /// How often it is repeated.
    pub repetitions: u32,
}

/// One Hello as soon as the link is up: what a device does that has no such record.
pub(super) const ONCE: HelloSettings =
    HelloSettings { delay: Duration::ZERO, interval: Duration::from_millis(30), repetitions: 0 };

/// The settings of an FSHelloBlock; none if it switches the Hello off.
fn hello(body: &[u8]) -> Result<Option<HelloSettings>, RecordError> {
    let mut reader = ByteReader::new("FSHelloBlock", body);
    let mut word = || reader.u32().map_err(|_| RecordError::INVALID_PARAMETER);
    let (mode, interval, repetitions, delay) = (word()?, word()?, word()?, word()?);
    let delay = match (mode, delay) {
        (0, _) => return Ok(None),
        (1, _) => 0,
        (2, 0 | 50 | 100 | 500 | 1000) => delay,
        _ => return Err(RecordError::INVALID_PARAMETER),
    };
    if !matches!(interval, 30 | 50 | 100 | 300 | 500 | 1000) || !(1..=15).contains(&repetitions) {
        return Err(RecordError::INVALID_PARAMETER);
    }
    let time = |milliseconds: u32| Duration::from_millis(milliseconds.into());
    Ok(Some(HelloSettings { delay: time(delay), interval: time(interval), repetitions }))
}

impl Stack {
    /// When the device says Hello once it is linked, with `at_start` after its start; none if it does not.
    pub(super) fn hello_settings(&self, at_start: bool) -> Option<HelloSettings> {
        let settings = if self.identity.has_fast_start_up { self.retained.fast_start_up.hello } else { Some(ONCE) };
        if !self.hooks.check(StackCheck::SaysHello { at_start }, settings.is_some()) {
            return None;
        }
        let settings = settings.unwrap_or(ONCE);
        let is_delayed = self.hooks.check(StackCheck::DelayedHello, true);
        Some(HelloSettings { delay: if is_delayed { settings.delay } else { Duration::ZERO }, ..settings })
    }

    /// Reads the record of the interface; before it was written there is none.
    pub(super) fn read_fast_start_up(&self, place: SubmoduleAddress) -> Result<&[u8], RecordError> {
        let is_here = place.subslot == INTERFACE_SUBSLOT && !self.retained.fast_start_up.record.is_empty();
        if is_here { Ok(&self.retained.fast_start_up.record) } else { Err(RecordError::INVALID_INDEX) }
    }

    /// Writes the record of the interface. It takes effect at the next link or start.
    pub(super) fn write_fast_start_up(&mut self, place: SubmoduleAddress, data: &[u8]) -> Result<(), RecordError> {
        if place.subslot != INTERFACE_SUBSLOT || !self.identity.has_fast_start_up {
            return Err(RecordError::INVALID_INDEX);
        }
        let mut reader = ByteReader::new("PDInterfaceFSUDataAdjust", data);
        let wrong_length = |_| RecordError::WRITE_LENGTH_ERROR;
        let (header, mut body) = BlockHeader::read(&mut reader).map_err(wrong_length)?;
        if !reader.is_empty() {
            return Err(RecordError::WRITE_LENGTH_ERROR);
        }
        if header.kind != FSU_DATA_ADJUST || (header.version_high, header.version_low) != (1, 0) {
            return Err(RecordError::INVALID_PARAMETER);
        }
        body.u16().map_err(wrong_length)?;
        let mut written = FastStartUp { record: data.to_vec(), hello: None };
        while !body.is_empty() {
            let block = RawBlock::read(&mut body).map_err(|_| RecordError::INVALID_PARAMETER)?;
            match block.header.kind {
                FS_HELLO => {
                    let fields = block.body.get(2..).ok_or(RecordError::INVALID_PARAMETER)?;
                    written.hello = hello(fields)?;
                }
                kind if OTHER_BLOCKS.contains(&kind) => {}
                _ => return Err(RecordError::INVALID_PARAMETER),
            }
        }
        self.retained.fast_start_up = written;
        Ok(())
    }
}
