//! Writes pcapng.

use std::io::{self, Write};

use station::Time;
use wire::ethernet::Mac;

use super::LinkType;

/// Option number of a comment, in every kind of block.
const COMMENT: u16 = 1;
/// Option number of the end of the options.
const END_OF_OPTIONS: u16 = 0;
/// Option number of an interface's name.
const INTERFACE_NAME: u16 = 2;
/// Option number of an interface's time resolution.
const INTERFACE_TIME_RESOLUTION: u16 = 9;
/// Option number of the program that wrote the section.
const USER_APPLICATION: u16 = 4;
/// Record of a name resolution block: a MAC address, and its name with a NUL behind it.
const NAME_OF_EUI48: u16 = 3;
/// Longest value of an option.
const LONGEST_OPTION: usize = 0xFFFF;

/// Writes a pcapng file of one section, little-endian, with times in nanoseconds.
#[derive(Debug)]
pub struct PcapngWriter<W> {
    output: W,
    block: Vec<u8>,
    interfaces: u32,
}

impl<W: Write> PcapngWriter<W> {
    /// Writes the section header; `application` is the name of the writing program in it.
    pub fn new(output: W, application: &str) -> io::Result<PcapngWriter<W>> {
        let mut writer = PcapngWriter { output, block: Vec::new(), interfaces: 0 };
        writer.begin(0x0A0D_0D0A);
        writer.word(0x1A2B_3C4D);
        // Version 1.0, and a section length of -1: unknown.
        writer.word(1);
        writer.block.extend_from_slice(&(-1i64).to_le_bytes());
        writer.option(USER_APPLICATION, application.as_bytes());
        writer.option(END_OF_OPTIONS, &[]);
        writer.end()?;
        Ok(writer)
    }

    /// Describes an interface and returns its number, from 0, for [`packet`](Self::packet).
    pub fn interface(&mut self, name: &str, link_type: LinkType) -> io::Result<u32> {
        self.begin(1);
        self.word(u32::from(link_type.0));
        // No limit on the length of a captured packet.
        self.word(0);
        self.text(INTERFACE_NAME, name);
        self.option(INTERFACE_TIME_RESOLUTION, &[9]);
        self.option(END_OF_OPTIONS, &[]);
        self.end()?;
        self.interfaces += 1;
        Ok(self.interfaces - 1)
    }

    /// Names stations by their MAC addresses: a name resolution block, nothing for no names.
    pub fn names(&mut self, names: &[(Mac, String)]) -> io::Result<()> {
        if names.is_empty() {
            return Ok(());
        }
        self.begin(4);
        for (mac, name) in names {
            let value = [&mac.0[..], name.as_bytes(), &[0]].concat();
            self.option(NAME_OF_EUI48, &value[..value.len().min(LONGEST_OPTION)]);
        }
        self.option(END_OF_OPTIONS, &[]);
        self.end()
    }

    /// Writes a complete packet that `interface` received at `time` (nanoseconds since 1970), with an optional comment.
    ///
    /// A comment beyond 65,535 bytes is cut at the last character that fits. An undescribed interface and a packet beyond 4 GiB
    /// are refused with [`io::ErrorKind::InvalidInput`].
    pub fn packet(&mut self, interface: u32, time: Time, octets: &[u8], comment: Option<&str>) -> io::Result<()> {
        let original = u32::try_from(octets.len()).unwrap_or(u32::MAX);
        self.cut_packet(interface, time, octets, original, comment)
    }

    /// Like [`packet`](Self::packet), of which `octets` were captured of `original` bytes.
    pub fn cut_packet(
        &mut self,
        interface: u32,
        time: Time,
        octets: &[u8],
        original: u32,
        comment: Option<&str>,
    ) -> io::Result<()> {
        let Ok(length) = u32::try_from(octets.len()) else { return Err(io::ErrorKind::InvalidInput.into()) };
        if interface >= self.interfaces {
            return Err(io::ErrorKind::InvalidInput.into());
        }
        let nanos = time.as_nanos();
        self.begin(6);
        self.word(interface);
        self.word((nanos >> 32) as u32);
        self.word(nanos as u32);
        self.word(length);
        self.word(original);
        self.padded(octets);
        if let Some(text) = comment {
            self.text(COMMENT, text);
            self.option(END_OF_OPTIONS, &[]);
        }
        self.end()
    }

    /// The output so far.
    pub fn output_mut(&mut self) -> &mut W {
        &mut self.output
    }

    /// Flushes the buffer and returns the output.
    pub fn finish(mut self) -> io::Result<W> {
        self.output.flush()?;
        Ok(self.output)
    }

    fn begin(&mut self, block_type: u32) {
        self.block.clear();
        self.word(block_type);
        self.word(0);
    }

    fn end(&mut self) -> io::Result<()> {
        let length = (self.block.len() + 4) as u32;
        self.block[4..8].copy_from_slice(&length.to_le_bytes());
        self.word(length);
        self.output.write_all(&self.block)
    }

    fn word(&mut self, value: u32) {
        self.block.extend_from_slice(&value.to_le_bytes());
    }

    /// A text option, cut at the last character that fits.
    fn text(&mut self, code: u16, text: &str) {
        let end = (0..=text.len().min(LONGEST_OPTION)).rev().find(|end| text.is_char_boundary(*end));
        self.option(code, &text.as_bytes()[..end.unwrap_or(0)]);
    }

    fn option(&mut self, code: u16, value: &[u8]) {
        self.block.extend_from_slice(&code.to_le_bytes());
        self.block.extend_from_slice(&(value.len() as u16).to_le_bytes());
        self.padded(value);
    }

    fn padded(&mut self, octets: &[u8]) {
        self.block.extend_from_slice(octets);
        self.block.resize(self.block.len().next_multiple_of(4), 0);
    }
}
