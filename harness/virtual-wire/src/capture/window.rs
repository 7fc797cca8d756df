//! A window that slides over the octets of a file.

use std::io::{self, ErrorKind, Read};

/// What is read at a time, in octets, as long as no record asks for more.
const USUAL: usize = 256 * 1024;

/// The octets of `input` that are in memory, and where in the file they are.
///
/// Memory is twice the most that was ever asked for at once, whatever the length of the file.
#[derive(Debug)]
pub(super) struct Window<R> {
    input: R,
    memory: Vec<u8>,
    start: usize,
    end: usize,
    offset: u64,
    ended: bool,
    failure: Option<io::Error>,
}

impl<R: Read> Window<R> {
    pub fn new(input: R) -> Window<R> {
        Window { input, memory: Vec::new(), start: 0, end: 0, offset: 0, ended: false, failure: None }
    }

    /// The octets in memory.
    pub fn octets(&self) -> &[u8] {
        &self.memory[self.start..self.end]
    }

    /// The same, to put right what is known to be wrong.
    pub fn octets_mut(&mut self) -> &mut [u8] {
        &mut self.memory[self.start..self.end]
    }

    /// Where in the file the first of them is.
    pub fn offset(&self) -> u64 {
        self.offset
    }

    /// Reads on until `count` octets are in memory or the file ends; says how many there are.
    pub fn want(&mut self, count: usize) -> usize {
        if self.end - self.start < count && !self.ended {
            self.fill(count);
        }
        self.end - self.start
    }

    /// Slides on by `count` octets, or to the end of what is in memory.
    pub fn consume(&mut self, count: usize) {
        let count = count.min(self.end - self.start);
        self.start += count;
        self.offset += count as u64;
    }

    /// What stopped the reading before the end of the file; told once.
    pub fn failure(&mut self) -> Option<io::Error> {
        self.failure.take()
    }

    fn fill(&mut self, count: usize) {
        self.memory.copy_within(self.start..self.end, 0);
        self.end -= self.start;
        self.start = 0;
        // Twice as much, so that octets are moved once however small the steps are in which the window slides.
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
    fn memory_does_not_grow_with_the_file_but_with_what_is_asked_for() {
        let length = 50 * 1024 * 1024 + 3;
        let mut window = Window::new(io::repeat(7).take(length));
        while window.want(1_000) > 0 {
            assert_eq!((window.octets().first(), window.octets().last()), (Some(&7), Some(&7)));
            window.consume(997);
        }
        assert_eq!((window.offset(), window.memory.len()), (length, USUAL));

        let mut window = Window::new(io::repeat(7).take(length));
        assert_eq!(window.want(1_000_000), 2_000_000);
        assert_eq!(window.memory.len(), 2_000_000);
    }
}
