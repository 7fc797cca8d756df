//! Captures of PROFIBUS from a serial line or a log: reads bytes with times, writes pcapng with link type 257.
//!
//! Each frame is a packet with the time of its first start bit. Bytes that are not a frame are packets of their own, with a
//! comment that says what is wrong. This module must not know serial lines, nor what the frames mean.

mod hex_log;
mod join;
mod stamp;

pub use hex_log::{Chunk, HexLog};
pub use join::{Joined, Joiner};

use crate::capture::{LinkType, PcapngWriter};
use station::Time;
use std::io::{self, BufRead, Read, Write};
use wire::profibus::fdl::BaudRate;

/// Number of errors of a log that are listed individually.
const MOST_MISTAKES: usize = 20;
/// Maximum length of a line of a log in bytes.
const LONGEST_LINE: u64 = 1 << 20;

/// What was recorded.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RecordingCounts {
    /// Number of frames.
    pub frames: u64,
    /// Number of packets of bytes that are not a frame.
    pub damaged: u64,
    /// Time of the first packet and of the last.
    pub span: Option<(Time, Time)>,
}

/// Writes what is received on a PROFIBUS.
#[derive(Debug)]
pub struct CaptureRecorder<W> {
    writer: PcapngWriter<W>,
    interface: u32,
    joiner: Joiner,
    counts: RecordingCounts,
}

impl<W: Write> CaptureRecorder<W> {
    /// Begins the capture; `place` is the name of the line, `baud` the rate of the bus if known. Each packet is written to
    /// `output` at once, so that an interrupted recording has everything received before.
    pub fn new(output: W, place: &str, baud: Option<BaudRate>) -> io::Result<CaptureRecorder<W>> {
        let mut writer = PcapngWriter::new(output, concat!("encspec ", env!("CARGO_PKG_VERSION")))?;
        let interface = writer.interface(place, LinkType::PROFIBUS)?;
        Ok(CaptureRecorder { writer, interface, joiner: Joiner::new(baud), counts: RecordingCounts::default() })
    }

    /// Processes bytes, the first of which began at `begin`, in nanoseconds since 1970.
    pub fn record(&mut self, begin: Time, octets: &[u8]) -> io::Result<()> {
        let CaptureRecorder { writer, interface, joiner, counts } = self;
        let mut result = Ok(());
        joiner.push(begin, octets, &mut |joined| write_packet(writer, *interface, counts, &joined, &mut result));
        result
    }

    /// When incomplete bytes end; `None` if there are none.
    pub fn silent_at(&self) -> Option<Time> {
        self.joiner.silent_at()
    }

    /// Reports silence on the wire or the end of the log.
    pub fn silence(&mut self) -> io::Result<()> {
        let CaptureRecorder { writer, interface, joiner, counts } = self;
        let mut result = Ok(());
        joiner.silence(&mut |joined| write_packet(writer, *interface, counts, &joined, &mut result));
        result
    }

    /// The counts so far.
    pub fn counts(&self) -> RecordingCounts {
        self.counts
    }

    /// Writes the incomplete bytes and returns the output.
    pub fn finish(mut self) -> io::Result<(W, RecordingCounts)> {
        self.silence()?;
        Ok((self.writer.finish()?, self.counts))
    }
}

fn write_packet<W: Write>(
    writer: &mut PcapngWriter<W>,
    interface: u32,
    counts: &mut RecordingCounts,
    joined: &Joined,
    result: &mut io::Result<()>,
) {
    let comment = joined.damage.map(|why| format!("no frame: {why}"));
    let written = writer.packet(interface, joined.begin, &joined.octets, comment.as_deref());
    if result.is_ok() {
        *result = written;
    }
    match joined.damage {
        None => counts.frames += 1,
        Some(_) => counts.damaged += 1,
    }
    let first = counts.span.map_or(joined.begin, |(first, _)| first);
    counts.span = Some((first, joined.begin));
}

/// Why a log could not be imported.
#[derive(Debug, thiserror::Error)]
pub enum ImportError {
    /// The log cannot be read.
    #[error("cannot be read: {0}")]
    Unreadable(io::Error),
    /// The capture cannot be written.
    #[error("{0}")]
    Unwritable(io::Error),
    /// Lines are wrong: their numbers from 1 and what is wrong with them, and the number of further wrong lines.
    #[error("lines of the log are wrong")]
    Wrong(Vec<(usize, String)>, usize),
}

/// Writes the bytes of a hex log as a capture. The error lists wrong lines; the output is then useless.
pub fn import<W: Write>(
    mut log: impl BufRead,
    output: W,
    place: &str,
    baud: Option<BaudRate>,
) -> Result<(W, RecordingCounts), ImportError> {
    let mut recorder = CaptureRecorder::new(output, place, baud).map_err(ImportError::Unwritable)?;
    let (mut reader, mut mistakes, mut more) = (HexLog::default(), Vec::new(), 0);
    let mut line = Vec::new();
    for number in 1.. {
        line.clear();
        let count = (&mut log).take(LONGEST_LINE).read_until(b'\n', &mut line).map_err(ImportError::Unreadable)?;
        if count == 0 {
            break;
        }
        match reader.line(number, &String::from_utf8_lossy(&line)) {
            Ok(Some(chunk)) if mistakes.is_empty() => {
                recorder.record(chunk.begin, &chunk.octets).map_err(ImportError::Unwritable)?;
            }
            Ok(_) => {}
            Err(what) if mistakes.len() < MOST_MISTAKES => mistakes.push((number, what)),
            Err(_) => more += 1,
        }
    }
    if mistakes.is_empty() {
        recorder.finish().map_err(ImportError::Unwritable)
    } else {
        Err(ImportError::Wrong(mistakes, more))
    }
}
