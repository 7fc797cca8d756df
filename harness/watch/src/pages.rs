//! Appends pcapng blocks to a file so that a killed process leaves no half block.
//!
//! A kill can cut a write between two memory pages, but not within one. So no write crosses a page, and each page of the file
//! consists of whole blocks: a filling block, which every reader skips, ends a page in which the next block has no room.

use std::io::{self, Write};

/// The size of a memory page, or a part of one.
const PAGE: usize = 4_096;
/// A block type for local use (pcapng, 11.1): bytes that mean nothing.
const FILLING: u32 = 0x8000_0001;
/// The shortest block: type, and the length twice.
const SHORTEST: usize = 12;

/// A file that is written page by page.
#[derive(Debug)]
pub struct PagedFile<W> {
    output: W,
    /// What is not written yet: the end of the last page.
    pending: Vec<u8>,
    length: u64,
}

impl<W: Write> PagedFile<W> {
    /// Continues a file of no bytes.
    pub fn new(output: W) -> PagedFile<W> {
        PagedFile { output, pending: Vec::with_capacity(PAGE), length: 0 }
    }

    /// The number of bytes, written or not.
    pub fn length(&self) -> u64 {
        self.length
    }

    pub fn output(&self) -> &W {
        &self.output
    }

    /// Appends a block, whose length is a multiple of 4.
    pub fn append(&mut self, block: &[u8]) -> io::Result<()> {
        let room = self.room();
        if block.len() != room && block.len() + SHORTEST > room && room < PAGE {
            let length = (room as u32).to_le_bytes();
            self.pending.extend_from_slice(&FILLING.to_le_bytes());
            self.pending.extend_from_slice(&length);
            self.pending.resize(self.pending.len() + room - SHORTEST, 0);
            self.pending.extend_from_slice(&length);
            self.length += room as u64;
            self.flush()?;
        }
        self.pending.extend_from_slice(block);
        self.length += block.len() as u64;
        if self.room() == PAGE || block.len() + SHORTEST > PAGE { self.flush() } else { Ok(()) }
    }

    /// Writes what is pending.
    pub fn flush(&mut self) -> io::Result<()> {
        if self.pending.is_empty() {
            return Ok(());
        }
        let written = self.output.write_all(&self.pending);
        self.pending.clear();
        written
    }

    /// The number of bytes to the end of the page.
    fn room(&self) -> usize {
        PAGE - (self.length % PAGE as u64) as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Notes the offset and length of each write.
    #[derive(Default)]
    struct Writes(Vec<u8>, Vec<(usize, usize)>);

    impl Write for Writes {
        fn write(&mut self, octets: &[u8]) -> io::Result<usize> {
            self.1.push((self.0.len(), octets.len()));
            self.0.extend_from_slice(octets);
            Ok(octets.len())
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    fn block(length: usize) -> Vec<u8> {
        let mut block = vec![7; length];
        block[4..8].copy_from_slice(&(length as u32).to_le_bytes());
        block[length - 4..].copy_from_slice(&(length as u32).to_le_bytes());
        block
    }

    #[test]
    fn no_write_crosses_a_page_and_each_ends_at_the_end_of_a_block() {
        let mut file = PagedFile::new(Writes::default());
        let lengths: Vec<usize> = (0..4_000).map(|number| 12 + number * 52 % 2_100 / 4 * 4).collect();
        for (number, length) in lengths.iter().enumerate() {
            file.append(&block(*length)).expect("a Vec takes everything");
            if number % 17 == 0 {
                file.flush().expect("a Vec takes everything");
            }
        }
        file.flush().expect("a Vec takes everything");
        let Writes(octets, writes) = file.output();
        let (mut at, mut ends, mut found) = (0, Vec::new(), Vec::new());
        while at < octets.len() {
            let length = u32::from_le_bytes(octets[at + 4..at + 8].try_into().expect("four bytes")) as usize;
            if octets[at] == 7 {
                found.push(length);
            }
            at += length;
            ends.push(at);
        }
        assert_eq!(found, lengths);
        for (begin, length) in writes {
            assert_eq!(begin / PAGE, (begin + length - 1) / PAGE, "a write of {length} bytes at {begin}");
            assert!(ends.binary_search(&(begin + length)).is_ok());
        }
    }
}
