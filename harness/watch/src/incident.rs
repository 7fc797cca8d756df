//! Saves the frames around a finding: copies them from the ring to a file of their own, with the finding as a comment.

use crate::line::WatchLine;
use replay::utc;
use station::Time;
use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::os::unix::fs::FileExt;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use virtual_wire::PcapngWriter;

/// An enhanced packet block (pcapng, 4.3).
const PACKET: u32 = 6;
/// The bytes of an enhanced packet block before those of the packet.
const PACKET_HEAD: usize = 28;
/// The end of the name of a file that is not complete yet.
pub(crate) const INCOMPLETE: &str = "part";

/// An incident to be saved.
#[derive(Clone, Debug)]
pub(crate) struct IncidentOrder {
    pub name: String,
    pub from: Time,
    pub until: Time,
    /// The findings by their frames.
    pub comments: BTreeMap<u64, String>,
}

/// A piece of a file of the ring: whole blocks.
#[derive(Clone, Debug)]
pub(crate) struct RingPiece {
    pub file: Arc<File>,
    pub offset: u64,
    pub length: u64,
    /// The number of its first frame.
    pub first: u64,
}

/// The pieces for an incident, and whether the ring still had all of them.
#[derive(Clone, Debug)]
pub(crate) struct IncidentPieces {
    pub order: IncidentOrder,
    pub pieces: Vec<RingPiece>,
    pub is_complete: bool,
}

/// Saves an incident in `folder`; `header` are the blocks before the first packet. Deletes the oldest incidents beyond `limit` bytes.
pub(crate) fn save(folder: &Path, header: &[u8], limit: u64, incident: &IncidentPieces, now: Time) -> WatchLine {
    let wall_clock = utc(now);
    let order = &incident.order;
    let path = folder.join(&order.name);
    match write(&path, header, incident) {
        Ok(frames) => {
            delete_oldest(folder, limit, &path);
            WatchLine::Incident {
                wall_clock,
                file: path.display().to_string(),
                from: utc(order.from),
                until: utc(order.until),
                frames,
                is_complete: incident.is_complete,
            }
        }
        Err(error) => {
            WatchLine::Note { wall_clock, text: format!("the incident {} cannot be saved: {error}", path.display()) }
        }
    }
}

fn write(path: &Path, header: &[u8], incident: &IncidentPieces) -> io::Result<u64> {
    let early = path.with_extension(INCOMPLETE);
    let mut output = BufWriter::with_capacity(1 << 18, File::create(&early)?);
    output.write_all(header)?;
    let (mut frames, mut octets) = (0, Vec::new());
    for piece in &incident.pieces {
        octets.resize(piece.length as usize, 0);
        piece.file.read_exact_at(&mut octets, piece.offset)?;
        let has_comment = incident.order.comments.range(piece.first..).next().is_some();
        let (mut rest, mut number) = (octets.as_slice(), piece.first);
        while let Some((block, after)) = first_block(rest) {
            rest = after;
            if word(block, 0) != Some(PACKET) {
                continue;
            }
            match incident.order.comments.get(&number).filter(|_| has_comment) {
                Some(comment) => write_commented(&mut output, block, comment)?,
                None => output.write_all(block)?,
            }
            frames += 1;
            number += 1;
        }
    }
    output.flush()?;
    fs::rename(early, path)?;
    Ok(frames)
}

/// The first block, and what follows it.
fn first_block(octets: &[u8]) -> Option<(&[u8], &[u8])> {
    let length = word(octets, 4)? as usize;
    octets.split_at_checked(length).filter(|_| length > 0)
}

fn word(octets: &[u8], at: usize) -> Option<u32> {
    octets.get(at..at + 4)?.try_into().ok().map(u32::from_le_bytes)
}

/// Writes a packet block with a comment.
fn write_commented(output: &mut impl Write, block: &[u8], comment: &str) -> io::Result<()> {
    let fields = (word(block, 8), word(block, 12), word(block, 16), word(block, 20), word(block, 24));
    let (Some(interface), Some(high), Some(low), Some(length), Some(original)) = fields else {
        return output.write_all(block);
    };
    let time = Time::from_nanos(u64::from(high) << 32 | u64::from(low));
    let Some(octets) = block.get(PACKET_HEAD..PACKET_HEAD + length as usize) else { return output.write_all(block) };
    // Only the block of the packet is taken from this writer, not its header.
    let mut writer = PcapngWriter::new(Vec::new(), "")?;
    for _ in 0..=interface {
        writer.interface("", virtual_wire::capture::LinkType::ETHERNET)?;
    }
    writer.output_mut().clear();
    writer.cut_packet(interface, time, octets, original, Some(comment))?;
    output.write_all(&writer.finish()?)
}

/// The saved incidents in a folder with their sizes, the oldest first.
fn saved(folder: &Path) -> Vec<(PathBuf, u64)> {
    files(folder, "incident-", "pcapng")
}

/// The files in a folder whose names begin and end like this, by name, with their sizes.
pub(crate) fn files(folder: &Path, begin: &str, extension: &str) -> Vec<(PathBuf, u64)> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let mut found: Vec<(PathBuf, u64)> = entries
        .filter(|entry| entry.file_name().to_string_lossy().starts_with(begin))
        .map(|entry| (entry.path(), entry.metadata().map_or(0, |data| data.len())))
        .filter(|(path, _)| path.extension().is_some_and(|of| of == extension))
        .collect();
    found.sort();
    found
}

fn delete_oldest(folder: &Path, limit: u64, newest: &Path) {
    let saved = saved(folder);
    let mut sum: u64 = saved.iter().map(|(_, size)| size).sum();
    for (path, size) in saved.iter().filter(|(path, _)| path != newest) {
        if sum <= limit {
            return;
        }
        // A file that cannot be removed is tried again with the next incident.
        if fs::remove_file(path).is_ok() {
            sum -= size;
        }
    }
}
