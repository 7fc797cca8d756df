//! Captures of PROFIBUS from what was heard or logged: octets with times in, pcapng with link type 257 out.
//!
//! Each frame is a packet with the time of its first start bit. Octets that are no frame are packets of their own, with a comment
//! that says what is wrong with them. This room must not know lines, nor what the frames mean.

mod hex_log;
mod join;
mod stamp;

pub use hex_log::{Chunk, HexLog};
pub use join::{Joined, Joiner};

use crate::capture::{LinkType, PcapngWriter};
use station::Time;
use std::io::{self, BufRead, Read, Write};
use wire::profibus::fdl::BaudRate;

/// Mistakes of a log that are told one by one.
const MOST_MISTAKES: usize = 20;
/// A longer line is none of a log.
const LONGEST_LINE: u64 = 1 << 20;

/// What was recorded.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Frames.
    pub frames: u64,
    /// Packets of octets that are no frame.
    pub damaged: u64,
    /// From the first packet to the last.
    pub span: Option<(Time, Time)>,
}

/// Writes what is heard on a PROFIBUS.
#[derive(Debug)]
pub struct Recorder<W> {
    writer: PcapngWriter<W>,
    interface: u32,
    joiner: Joiner,
    counts: Counts,
}

impl<W: Write> Recorder<W> {
    /// Begins the capture; `place` is where it is heard, `baud` the rate of the bus where that is known.
    ///
    /// Each packet is handed to `output` in one go, so that a recording that breaks off has all that was heard before.
    pub fn new(output: W, place: &str, baud: Option<BaudRate>) -> io::Result<Recorder<W>> {
        let mut writer = PcapngWriter::new(output, concat!("encspec ", env!("CARGO_PKG_VERSION")))?;
        let interface = writer.interface(place, LinkType::PROFIBUS)?;
        Ok(Recorder { writer, interface, joiner: Joiner::new(baud), counts: Counts::default() })
    }

    /// Takes octets, the first of which began at `begin`, in nanoseconds since 1970.
    pub fn heard(&mut self, begin: Time, octets: &[u8]) -> io::Result<()> {
        let Recorder { writer, interface, joiner, counts } = self;
        let mut result = Ok(());
        joiner.push(begin, octets, &mut |joined| keep(writer, *interface, counts, &joined, &mut result));
        result
    }

    /// When octets that wait for others are over; none if nothing waits.
    pub fn silent_at(&self) -> Option<Time> {
        self.joiner.silent_at()
    }

    /// Says that the wire was silent, or that the log is at its end.
    pub fn silence(&mut self) -> io::Result<()> {
        let Recorder { writer, interface, joiner, counts } = self;
        let mut result = Ok(());
        joiner.silence(&mut |joined| keep(writer, *interface, counts, &joined, &mut result));
        result
    }

    /// What was recorded so far.
    pub fn counts(&self) -> Counts {
        self.counts
    }

    /// Writes out what waits and hands the output back.
    pub fn finish(mut self) -> io::Result<(W, Counts)> {
        self.silence()?;
        Ok((self.writer.finish()?, self.counts))
    }
}

fn keep<W: Write>(
    writer: &mut PcapngWriter<W>,
    interface: u32,
    counts: &mut Counts,
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
pub enum CannotImport {
    /// The log cannot be read.
    #[error("cannot be read: {0}")]
    Unreadable(io::Error),
    /// The capture cannot be written.
    #[error("{0}")]
    Unwritable(io::Error),
    /// Lines are wrong: their numbers from 1 and what is wrong with them, and how many more there are.
    #[error("lines of the log are wrong")]
    Wrong(Vec<(usize, String)>, usize),
}

/// Writes the octets of a hex log as a capture; the lines of all mistakes are told, and then what was written is of no use.
pub fn import<W: Write>(
    mut log: impl BufRead,
    output: W,
    place: &str,
    baud: Option<BaudRate>,
) -> Result<(W, Counts), CannotImport> {
    let mut recorder = Recorder::new(output, place, baud).map_err(CannotImport::Unwritable)?;
    let (mut reader, mut mistakes, mut more) = (HexLog::default(), Vec::new(), 0);
    let mut line = Vec::new();
    for number in 1.. {
        line.clear();
        let count = (&mut log).take(LONGEST_LINE).read_until(b'\n', &mut line).map_err(CannotImport::Unreadable)?;
        if count == 0 {
            break;
        }
        match reader.line(number, &String::from_utf8_lossy(&line)) {
            Ok(Some(chunk)) if mistakes.is_empty() => {
                recorder.heard(chunk.begin, &chunk.octets).map_err(CannotImport::Unwritable)?;
            }
            Ok(_) => {}
            Err(what) if mistakes.len() < MOST_MISTAKES => mistakes.push((number, what)),
            Err(_) => more += 1,
        }
    }
    if mistakes.is_empty() {
        recorder.finish().map_err(CannotImport::Unwritable)
    } else {
        Err(CannotImport::Wrong(mistakes, more))
    }
}
