//! Compressed capture files: detected by their first bytes and decompressed while reading, with constant memory.
//!
//! Errors of the compression name the offset in the compressed file. This module must not know the capture formats.

use std::fmt;
use std::io::{self, BufRead, BufReader, Chain, Cursor, ErrorKind, Read};

use flate2::bufread::MultiGzDecoder;
use ruzstd::decoding::errors::{FrameDecoderError, ReadFrameHeaderError};
use ruzstd::decoding::{BlockDecodingStrategy, FrameDecoder};

/// Maximum window of a compressed file in bytes; `zstd` uses larger ones only from level 20 on or with `--long`.
const LONGEST_WINDOW: u64 = 16 * 1024 * 1024;
/// Bytes read from a compressed file at a time.
const AT_A_TIME: usize = 64 * 1024;

/// A file whose first bytes were read to detect the format.
type PeekedFile<R> = Chain<Cursor<Vec<u8>>, R>;

/// The uncompressed bytes of a file.
pub(super) enum Unpacked<R: Read> {
    Plain(PeekedFile<R>),
    Gzip(Box<MultiGzDecoder<CountingReader<R>>>),
    Zstd(Box<Zstd<R>>),
}

/// Damage of the compression; it is the source of an [`io::Error`].
#[derive(Debug)]
pub(super) struct PackingDamage {
    /// Number of bytes of the compressed file read when the damage was detected.
    pub packed_at: u64,
    /// What is wrong.
    pub what: String,
    /// Whether all bytes are present and only their checksum does not match, so that any of them may be wrong.
    pub untrusted: bool,
}

impl fmt::Display for PackingDamage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "the compressed file is damaged at or before byte {}: {}", self.packed_at, self.what)
    }
}

impl std::error::Error for PackingDamage {}

impl<R: Read> Unpacked<R> {
    /// Detects the compression from the first bytes of `input`, regardless of the file name.
    pub fn new(mut input: R) -> io::Result<Unpacked<R>> {
        let mut begin = Vec::new();
        input.by_ref().take(4).read_to_end(&mut begin)?;
        let is_zstd = match begin.first_chunk::<4>().map(|magic| u32::from_le_bytes(*magic)) {
            // A frame, or a skippable frame (RFC 8878, 3.1).
            Some(magic) => magic == 0xFD2F_B528 || magic & 0xFFFF_FFF0 == 0x184D_2A50,
            None => false,
        };
        let is_gzip = begin.starts_with(&[0x1F, 0x8B]);
        let begun = Cursor::new(begin).chain(input);
        if !is_zstd && !is_gzip {
            return Ok(Unpacked::Plain(begun));
        }
        let counted = CountingReader { input: BufReader::with_capacity(AT_A_TIME, begun), taken: 0 };
        Ok(if is_gzip {
            Unpacked::Gzip(Box::new(MultiGzDecoder::new(counted)))
        } else {
            Unpacked::Zstd(Box::new(Zstd::new(counted)))
        })
    }
}

impl<R: Read> Read for Unpacked<R> {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        match self {
            Unpacked::Plain(input) => input.read(into),
            Unpacked::Gzip(decoder) => decoder.read(into).map_err(|error| {
                let packed_at = decoder.get_ref().taken;
                match error.kind() {
                    ErrorKind::UnexpectedEof => ends_too_soon(packed_at),
                    ErrorKind::InvalidInput | ErrorKind::InvalidData => {
                        let untrusted = error.to_string().contains("checksum");
                        damaged(packed_at, error.to_string(), untrusted)
                    }
                    _ => error,
                }
            }),
            Unpacked::Zstd(decoder) => decoder.read(into),
        }
    }
}

fn ends_too_soon(packed_at: u64) -> io::Error {
    damaged(packed_at, "it ends too soon".to_owned(), false)
}

fn damaged(packed_at: u64, what: String, untrusted: bool) -> io::Error {
    io::Error::new(ErrorKind::InvalidData, PackingDamage { packed_at, what, untrusted })
}

/// Counts the bytes read from the compressed file.
pub(super) struct CountingReader<R: Read> {
    input: BufReader<PeekedFile<R>>,
    taken: u64,
}

impl<R: Read> Read for CountingReader<R> {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        let read = self.input.read(into)?;
        self.taken += read as u64;
        Ok(read)
    }
}

impl<R: Read> BufRead for CountingReader<R> {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        self.input.fill_buf()
    }

    fn consume(&mut self, count: usize) {
        self.taken += count as u64;
        self.input.consume(count);
    }
}

/// The frames of a zstd file in sequence.
pub(super) struct Zstd<R: Read> {
    input: CountingReader<R>,
    decoder: FrameDecoder,
    in_frame: bool,
    /// The pending error, returned after the bytes that could be decompressed.
    failure: Option<io::Error>,
}

/// An empty raw block marked as the last one (RFC 8878, 3.1.1.2), and space for a checksum: it makes the decoder return the bytes
/// that it retains as history.
const LAST_BLOCK: [u8; 7] = [1, 0, 0, 0, 0, 0, 0];

impl<R: Read> Zstd<R> {
    fn new(input: CountingReader<R>) -> Zstd<R> {
        let mut decoder = FrameDecoder::new();
        decoder.set_max_window_size(LONGEST_WINDOW);
        Zstd { input, decoder, in_frame: false, failure: None }
    }

    /// Begins the next frame and skips skippable ones; returns false at the end of the file.
    fn begin(&mut self) -> io::Result<bool> {
        while !self.input.fill_buf()?.is_empty() {
            match self.decoder.init(&mut self.input) {
                Ok(()) => return Ok(true),
                Err(FrameDecoderError::ReadFrameHeaderError(ReadFrameHeaderError::SkipFrame { length, .. })) => {
                    let skipped = io::copy(&mut self.input.by_ref().take(length.into()), &mut io::sink())?;
                    if skipped < u64::from(length) {
                        return Err(ends_too_soon(self.input.taken));
                    }
                }
                Err(error) => return Err(self.wrong(&error)),
            }
        }
        Ok(false)
    }

    fn wrong(&mut self, error: &FrameDecoderError) -> io::Error {
        let at_end = self.input.fill_buf().is_ok_and(<[u8]>::is_empty);
        match error {
            FrameDecoderError::WindowSizeTooBig { requested, .. } => {
                let megabytes = requested.div_ceil(1024 * 1024);
                let what = format!(
                    "it is compressed with a window of {megabytes} MB: decompress it first (zstd -d --long=31)"
                );
                damaged(self.input.taken, what, false)
            }
            _ if at_end => ends_too_soon(self.input.taken),
            _ => damaged(self.input.taken, error.to_string(), false),
        }
    }

    /// Whether the checksum of the frame matches, if it has one.
    fn check(&self) -> io::Result<()> {
        match (self.decoder.get_checksum_from_data(), self.decoder.get_calculated_checksum()) {
            (Some(stored), Some(is)) if stored != is => {
                Err(damaged(self.input.taken, "its checksum does not match".to_owned(), true))
            }
            _ => Ok(()),
        }
    }
}

impl<R: Read> Read for Zstd<R> {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        loop {
            if self.failure.is_some() {
                let read = self.decoder.read(into)?;
                return if read > 0 { Ok(read) } else { self.failure.take().map_or(Ok(0), Err) };
            }
            if self.decoder.can_collect() > 0 {
                return self.decoder.read(into);
            }
            if self.in_frame && self.decoder.is_finished() {
                self.in_frame = false;
                self.check()?;
            }
            if !self.in_frame {
                if !self.begin()? {
                    return Ok(0);
                }
                self.in_frame = true;
            }
            let strategy = BlockDecodingStrategy::UptoBlocks(1);
            if let Err(error) = self.decoder.decode_blocks(&mut self.input, strategy) {
                self.failure = Some(self.wrong(&error));
                // This fails if the last block was already read; then the decoder retains nothing.
                let _ = self.decoder.decode_blocks(&LAST_BLOCK[..], BlockDecodingStrategy::All);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{CaptureItem, CaptureReader, DamageEffect, NotACapture};
    use crate::damage::{every_flipped_bit, every_prefix};
    use rstest::rstest;

    /// Two packets in a pcap file, compressed by gzip 1.12 -9n.
    const GZIP: &str =
        "1f8b0800000000000203bb7278d3422606160618f8ff9f81819101824140048a19b101a83a981a262c0000c6aa56cc60000000";
    /// The same by zstd 1.5.4.
    const ZSTD: &str =
        "28b52ffd246035010090d4c3b2a102000400ffff00000100140114020800b82420df5259e0e8ed9cc1b23b5c08c005fa2d082e";

    fn octets(hex: &str) -> Vec<u8> {
        let pair = |at: usize| u8::from_str_radix(&hex[at..at + 2], 16).expect("hexadecimal");
        (0..hex.len()).step_by(2).map(pair).collect()
    }

    /// The packets and the damage.
    type UnpackResult = (Vec<Vec<u8>>, Vec<(u64, DamageEffect, String)>);

    fn read(file: &[u8]) -> UnpackResult {
        let (mut packets, mut damage) = (Vec::new(), Vec::new());
        let mut reader = match CaptureReader::new(file) {
            Ok(reader) => reader,
            Err(refused) => return (packets, vec![(0, DamageEffect::Missing, refused.to_string())]),
        };
        while let Some(item) = reader.next() {
            match item {
                CaptureItem::Packet(packet) => packets.push(packet.captured.to_vec()),
                CaptureItem::Damage(found) => damage.push((found.at, found.effect, found.what)),
            }
            assert!(packets.len() + damage.len() < 100, "endless output from a small file");
        }
        (packets, damage)
    }

    fn both() -> Vec<Vec<u8>> {
        vec![vec![1; 20], vec![2; 20]]
    }

    #[rstest]
    fn compressed_files_are_read_regardless_of_their_name(#[values(GZIP, ZSTD)] packed: &str) {
        assert_eq!(read(&octets(packed)), (both(), vec![]));
    }

    /// Both formats allow concatenated files; zstd also allows skippable frames between them.
    #[test]
    fn concatenated_compressed_files_are_read() {
        let mut gzip = octets(GZIP);
        gzip.extend(octets(GZIP));
        let (packets, damage) = read(&gzip);
        // The second file header is not a record.
        assert_eq!((packets.len(), damage.len()), (4, 1), "{damage:?}");
        let mut zstd = vec![0x5A, 0x2A, 0x4D, 0x18, 2, 0, 0, 0, 7, 7];
        zstd.extend(octets(ZSTD));
        zstd.extend([0x50, 0x2A, 0x4D, 0x18, 0, 0, 0, 0]);
        assert_eq!(read(&zstd), (both(), vec![]));
    }

    #[rstest]
    fn a_truncated_file_is_reported_with_its_offset(#[values(GZIP, ZSTD)] packed: &str) {
        every_prefix(&octets(packed), |prefix| {
            let (packets, damage) = read(prefix);
            assert!(both().starts_with(&packets));
            assert!(!damage.is_empty() || prefix.len() + 8 >= packed.len() / 2, "{} bytes are complete", prefix.len());
        });
        let packed = octets(packed);
        let (packets, damage) = read(&packed[..packed.len() - 1]);
        assert_eq!(packets, both());
        let (at, effect, what) = &damage[0];
        assert_eq!((*at, *effect), (96, DamageEffect::Missing));
        assert!(what.contains("byte") && what.ends_with("it ends too soon"), "{what}");
    }

    /// A flipped bit in the compressed bytes never goes unnoticed, except where no checksum can detect it.
    #[rstest]
    fn a_flipped_bit_is_found(#[values(GZIP, ZSTD)] packed: &str) {
        let mut untrusted = 0;
        every_flipped_bit(&octets(packed), |index, flipped| {
            let (packets, damage) = read(flipped);
            assert!(packets == both() || !damage.is_empty(), "byte {index}: {packets:?}");
            untrusted += usize::from(damage.iter().any(|(_, effect, _)| *effect == DamageEffect::Untrusted));
        });
        assert!(untrusted > 0, "no checksum was verified");
    }

    #[test]
    fn a_window_that_is_too_large_is_refused_with_advice() {
        // A frame header with the window descriptor 0x88: 2^27 bytes, 128 MB.
        let file = [0x28, 0xB5, 0x2F, 0xFD, 0x00, 0x88, 1, 0, 0];
        let refused = CaptureReader::new(&file[..]).expect_err("too large");
        assert!(matches!(refused, NotACapture::Unreadable(_)));
        assert!(
            refused.to_string().ends_with("a window of 128 MB: decompress it first (zstd -d --long=31)"),
            "{refused}"
        );
    }
}
