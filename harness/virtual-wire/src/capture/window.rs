//! A window that moves over the bytes of a file.

use std::io::{self, ErrorKind, Read};

/// Bytes read at a time, unless a record needs more.
const USUAL: usize = 256 * 1024;

/// The bytes of `input` in memory and their offset in the file. Memory is at most twice the largest amount requested at once,
/// whatever the length of the file.
#[derive(Debug)]
pub(super) struct FileWindow<R> {
    input: R,
    memory: Vec<u8>,
    start: usize,
    end: usize,
    offset: u64,
    ended: bool,
    failure: Option<io::Error>,
}

impl<R: Read> FileWindow<R> {
    pub fn new(input: R) -> FileWindow<R> {
        FileWindow { input, memory: Vec::new(), start: 0, end: 0, offset: 0, ended: false, failure: None }
    }

    /// The bytes in memory.
    pub fn octets(&self) -> &[u8] {
        &self.memory[self.start..self.end]
    }

    /// The bytes in memory, to correct known damage.
    pub fn octets_mut(&mut self) -> &mut [u8] {
        &mut self.memory[self.start..self.end]
    }

    /// Offset of the first of them in the file.
    pub fn offset(&self) -> u64 {
        self.offset
    }

    /// Reads until `count` bytes are in memory or the file ends; returns the number of bytes in memory.
    pub fn fill_to(&mut self, count: usize) -> usize {
        if self.end - self.start < count && !self.ended {
            self.fill(count);
        }
        self.end - self.start
    }

    /// Moves on by `count` bytes, or to the end of the bytes in memory.
    pub fn consume(&mut self, count: usize) {
        let count = count.min(self.end - self.start);
        self.start += count;
        self.offset += count as u64;
    }

    /// The error that stopped the reading before the end of the file; returned once.
    pub fn failure(&mut self) -> Option<io::Error> {
        self.failure.take()
    }

    fn fill(&mut self, count: usize) {
        self.memory.copy_within(self.start..self.end, 0);
        self.end -= self.start;
        self.start = 0;
        // Twice as much, so that each byte is moved only once even if the window moves in small steps.
        let room = USUAL.max(count.saturating_mul(2));
        if self.memory.len() < room {
            self.memory.resize(room, 0);
        }
        while self.end < count && !self.ended {
            match self.input.read(&mut self.memory[self.end..]) {
                Ok(0) => self.ended = true,
                Ok(read) => self.end += read,
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) => {
                    self.ended = true;
                    self.failure = Some(error);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn memory_grows_with_the_requested_bytes_and_not_with_the_file() {
        let length = 50 * 1024 * 1024 + 3;
        let mut window = FileWindow::new(io::repeat(7).take(length));
        while window.fill_to(1_000) > 0 {
            assert_eq!((window.octets().first(), window.octets().last()), (Some(&7), Some(&7)));
            window.consume(997);
        }
        assert_eq!((window.offset(), window.memory.len()), (length, USUAL));

        let mut window = FileWindow::new(io::repeat(7).take(length));
        assert_eq!(window.fill_to(1_000_000), 2_000_000);
        assert_eq!(window.memory.len(), 2_000_000);
    }
}
