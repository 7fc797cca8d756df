//! Deviations of the PROFINET stack with state about records.

use alloc::vec::Vec;
use device_stack::profinet::{RecordAccess, StackHooks, StationData, StationLoad};
use wire::profinet::status::RecordError;

/// Record indices of I&M1 to I&M3.
fn is_text(index: u16) -> bool {
    matches!(index, 0xAFF1..=0xAFF3)
}

/// Returns blank texts after each power-up, until one is written.
#[derive(Default)]
pub struct ImTextsLost {
    is_blank: bool,
}

impl StackHooks for ImTextsLost {
    fn load_station(&mut self, start: StationLoad, _: &mut StationData) {
        self.is_blank |= start == StationLoad::PowerUp;
    }

    fn written(&mut self, access: RecordAccess, _: &[u8], _: &mut Result<(), RecordError>) {
        self.is_blank &= !is_text(access.index);
    }

    fn read(&mut self, access: RecordAccess, result: &mut Result<Vec<u8>, RecordError>) {
        if let (true, true, Ok(data)) = (self.is_blank, is_text(access.index), result) {
            data[6..].fill(b' ');
        }
    }
}

/// Returns the text that was written last, whichever is read.
#[derive(Default)]
pub struct KeepsLastText {
    text: Vec<u8>,
}

impl StackHooks for KeepsLastText {
    fn written(&mut self, access: RecordAccess, data: &[u8], _: &mut Result<(), RecordError>) {
        if is_text(access.index) {
            self.text = data.to_vec();
        }
    }

    fn read(&mut self, access: RecordAccess, result: &mut Result<Vec<u8>, RecordError>) {
        if let (true, false, Ok(data)) = (is_text(access.index), self.text.is_empty(), result) {
            data.clone_from(&self.text);
        }
    }
}
