//! The ring: the frames of the last minutes on disk, in pcapng files of which the oldest is deleted. A thread writes it, so that a slow
//! disk does not keep frames from being judged; what the disk does not take is counted as lost.

use crate::incident::{INCOMPLETE, IncidentOrder, IncidentPieces, RingPiece, files, save};
use crate::line::WatchLine;
use crate::pages::PagedFile;
use replay::utc;
use station::{Duration, Time};
use std::collections::VecDeque;
use std::fs::{self, File};
use std::io;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::{self, JoinHandle};
use virtual_wire::PcapngWriter;
use virtual_wire::capture::LinkType;

/// Frames are passed to the disk when so many bytes have come together, or after this time.
const CHUNK: usize = 1 << 16;
const CHUNK_TIME: Duration = Duration::from_millis(100);
/// Chunks that may wait for the disk: 16 MB.
const MOST_CHUNKS: usize = 256;
/// The ring consists of so many files.
const FILES: u64 = 16;
/// The shortest file of the ring in bytes.
const SHORTEST_FILE: u64 = 1 << 16;
/// For so long the ring knows where its frames are; an incident begins later.
const INDEXED: Duration = Duration::from_secs(240);

/// Where the ring is, and how long.
#[derive(Clone, Debug)]
pub struct RingSettings {
    pub folder: PathBuf,
    /// Upper limit of its files together in bytes.
    pub size: u64,
    /// Upper limit of the incidents together in bytes.
    pub incidents: u64,
    /// The interfaces of the frames: name and link type.
    pub interfaces: Vec<(String, LinkType)>,
}

/// A piece of the ring on its way to the disk.
#[derive(Debug, Default)]
struct RingChunk {
    octets: Vec<u8>,
    first: u64,
    frames: u64,
    begin: Time,
    end: Time,
}

#[derive(Debug)]
enum RingOrder {
    Chunk(RingChunk),
    Incident(IncidentOrder),
    Rotate,
}

/// The near end of the ring.
#[derive(Debug)]
pub struct DiskRing {
    orders: Option<Sender<RingOrder>>,
    /// Chunks that wait for the disk.
    waiting: Arc<AtomicUsize>,
    writer: PcapngWriter<Vec<u8>>,
    chunk: RingChunk,
    interfaces: Vec<LinkType>,
    lost: Arc<AtomicU64>,
    lines: Receiver<WatchLine>,
    thread: Option<JoinHandle<()>>,
}

impl DiskRing {
    /// Starts the ring in its folder, which is created; the files of an earlier ring are part of it.
    pub fn start(settings: &RingSettings) -> io::Result<DiskRing> {
        fs::create_dir_all(&settings.folder)?;
        for (path, _) in files(&settings.folder, "incident-", INCOMPLETE) {
            let _ = fs::remove_file(path);
        }
        let mut writer = PcapngWriter::new(Vec::new(), concat!("encspec watch ", env!("CARGO_PKG_VERSION")))?;
        for (name, link) in &settings.interfaces {
            writer.interface(name, *link)?;
        }
        let header = std::mem::take(writer.output_mut());
        let (orders, receiver) = channel();
        let waiting = Arc::new(AtomicUsize::new(0));
        let (lines, received) = channel();
        let lost = Arc::new(AtomicU64::new(0));
        let saver = Saver::start(settings, &header, &lines)?;
        let mut disk = RingDisk {
            settings: settings.clone(),
            header,
            file: None,
            files: files(&settings.folder, "ring-", "pcapng").into(),
            index: VecDeque::new(),
            forgotten: None,
            number: 0,
            lines,
            lost: Arc::clone(&lost),
            waiting: Arc::clone(&waiting),
            has_failed: false,
        };
        let work = move || {
            for order in receiver {
                disk.take(order, &saver);
            }
            disk.end(saver);
        };
        let thread = Some(thread::Builder::new().name("ring".to_owned()).spawn(work)?);
        let interfaces = settings.interfaces.iter().map(|(_, link)| *link).collect();
        Ok(DiskRing {
            orders: Some(orders),
            waiting,
            writer,
            chunk: RingChunk::default(),
            interfaces,
            lost,
            lines: received,
            thread,
        })
    }

    /// Adds a frame; numbers follow each other.
    pub fn frame(&mut self, number: u64, time: Time, link: LinkType, octets: &[u8], original: u32) {
        let Some(interface) = self.interfaces.iter().position(|known| *known == link) else { return };
        if self.chunk.frames == 0 {
            (self.chunk.first, self.chunk.begin, self.chunk.end) = (number, time, time);
        }
        // A Vec takes everything, and the interface is a known one.
        let _ = self.writer.cut_packet(interface as u32, time, octets, original, None);
        self.chunk.frames += 1;
        self.chunk.begin = self.chunk.begin.min(time);
        self.chunk.end = self.chunk.end.max(time);
        if self.writer.output_mut().len() >= CHUNK || time.since(self.chunk.begin) >= CHUNK_TIME {
            self.pass_on();
        }
    }

    /// Passes the frames so far to the disk; to be called at least once a second.
    pub fn pass_on(&mut self) {
        if self.chunk.frames == 0 {
            return;
        }
        let mut chunk = std::mem::take(&mut self.chunk);
        chunk.octets = std::mem::take(self.writer.output_mut());
        self.writer.output_mut().reserve(CHUNK + 4_096);
        // A slow disk must not keep frames from being judged.
        let has_room = self.waiting.fetch_add(1, Ordering::Relaxed) < MOST_CHUNKS;
        let frames = chunk.frames;
        if !has_room || !self.order(RingOrder::Chunk(chunk)) {
            self.waiting.fetch_sub(1, Ordering::Relaxed);
            self.lost.fetch_add(frames, Ordering::Relaxed);
        }
    }

    /// Begins a new file, so that the others may be moved away.
    pub fn rotate(&mut self) {
        self.pass_on();
        self.order(RingOrder::Rotate);
    }

    /// Saves the frames from one time to another, which must have passed.
    pub(crate) fn save(&mut self, order: IncidentOrder) {
        self.pass_on();
        self.order(RingOrder::Incident(order));
    }

    /// Passes an order to the disk; returns false if its thread has panicked.
    fn order(&self, order: RingOrder) -> bool {
        self.orders.as_ref().is_some_and(|orders| orders.send(order).is_ok())
    }

    /// The number of frames that the disk did not take.
    pub fn lost(&self) -> u64 {
        self.lost.load(Ordering::Relaxed)
    }

    /// What happened to the files since the last call.
    pub fn lines(&self) -> Vec<WatchLine> {
        self.lines.try_iter().collect()
    }

    /// Writes everything and ends; returns what happened to the files.
    pub fn end(mut self) -> Vec<WatchLine> {
        self.pass_on();
        self.orders = None;
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
        self.lines.iter().collect()
    }
}

/// The thread that saves incidents, so that the ring goes on meanwhile.
#[derive(Debug)]
struct Saver {
    orders: Sender<(IncidentPieces, Time)>,
    thread: JoinHandle<()>,
}

impl Saver {
    fn start(settings: &RingSettings, header: &[u8], lines: &Sender<WatchLine>) -> io::Result<Saver> {
        let (orders, receiver) = channel::<(IncidentPieces, Time)>();
        let (settings, header, lines) = (settings.clone(), header.to_vec(), lines.clone());
        let work = move || {
            for (incident, now) in receiver {
                let _ = lines.send(save(&settings.folder, &header, settings.incidents, &incident, now));
            }
        };
        Ok(Saver { orders, thread: thread::Builder::new().name("incidents".to_owned()).spawn(work)? })
    }
}

/// The far end of the ring: its files.
struct RingDisk {
    settings: RingSettings,
    header: Vec<u8>,
    file: Option<(PathBuf, PagedFile<Arc<File>>)>,
    /// The files before the present one with their sizes, the oldest first.
    files: VecDeque<(PathBuf, u64)>,
    /// The pieces of the last minutes: begin, end, piece.
    index: VecDeque<(Time, Time, RingPiece)>,
    /// The end of the last piece that was forgotten.
    forgotten: Option<Time>,
    number: u64,
    lines: Sender<WatchLine>,
    lost: Arc<AtomicU64>,
    waiting: Arc<AtomicUsize>,
    has_failed: bool,
}

impl RingDisk {
    fn take(&mut self, order: RingOrder, saver: &Saver) {
        match order {
            RingOrder::Chunk(chunk) => {
                self.waiting.fetch_sub(1, Ordering::Relaxed);
                if let Err(error) = self.write(&chunk) {
                    self.lost.fetch_add(chunk.frames, Ordering::Relaxed);
                    self.file = None;
                    if !std::mem::replace(&mut self.has_failed, true) {
                        let folder = self.settings.folder.display();
                        let text = format!("the ring in {folder} cannot be written: {error}");
                        let _ = self.lines.send(WatchLine::Note { wall_clock: utc(chunk.end), text });
                    }
                } else {
                    self.has_failed = false;
                }
            }
            RingOrder::Rotate => self.close(),
            RingOrder::Incident(order) => {
                let meets = |(begin, end, _): &&(Time, Time, RingPiece)| *end >= order.from && *begin <= order.until;
                let pieces = self.index.iter().filter(meets).map(|(_, _, piece)| piece.clone()).collect();
                let is_complete = self.forgotten.is_none_or(|forgotten| forgotten < order.from);
                let now = order.until;
                // If the thread has panicked, the ring still has the frames.
                let _ = saver.orders.send((IncidentPieces { order, pieces, is_complete }, now));
            }
        }
    }

    fn write(&mut self, chunk: &RingChunk) -> io::Result<()> {
        let limit = (self.settings.size / FILES).max(SHORTEST_FILE);
        if self.file.as_ref().is_some_and(|(_, file)| file.length() >= limit) {
            self.close();
        }
        self.make_room(chunk.octets.len() as u64);
        if self.file.is_none() {
            self.number += 1;
            let stamp = utc(chunk.begin).replace(['-', ':'], "");
            let stamp = stamp.split('.').next().unwrap_or_default();
            let path = self.settings.folder.join(format!("ring-{stamp}Z-{:06}.pcapng", self.number));
            let file = File::options().write(true).read(true).create_new(true).open(&path)?;
            let mut file = PagedFile::new(Arc::new(file));
            let mut rest = self.header.as_slice();
            while let Some((block, after)) = split_block(rest) {
                file.append(block)?;
                rest = after;
            }
            self.file = Some((path, file));
        }
        let Some((_, file)) = &mut self.file else { return Ok(()) };
        let offset = file.length();
        let mut rest = chunk.octets.as_slice();
        while let Some((block, after)) = split_block(rest) {
            file.append(block)?;
            rest = after;
        }
        file.flush()?;
        let piece =
            RingPiece { file: Arc::clone(file.output()), offset, length: file.length() - offset, first: chunk.first };
        self.index.push_back((chunk.begin, chunk.end, piece));
        while self.index.front().is_some_and(|(_, end, _)| chunk.end.since(*end) > INDEXED) {
            self.forget_first();
        }
        Ok(())
    }

    fn forget_first(&mut self) {
        if let Some((_, end, _)) = self.index.pop_front() {
            self.forgotten = Some(end);
        }
    }

    fn close(&mut self) {
        if let Some((path, file)) = self.file.take() {
            self.files.push_back((path, file.length()));
        }
    }

    /// Deletes the oldest files until there is room for so many bytes.
    fn make_room(&mut self, octets: u64) {
        let present = self.file.as_ref().map_or(0, |(_, file)| file.length());
        let mut sum: u64 = self.files.iter().map(|(_, size)| size).sum::<u64>() + present + octets;
        while sum > self.settings.size
            && let Some((path, size)) = self.files.pop_front()
        {
            // A file that was moved away is not there any more. Incidents that wait have it open.
            let _ = fs::remove_file(path);
            sum -= size;
            let mut rest = size;
            while rest > 0
                && let Some((_, _, piece)) = self.index.front()
                && !self.is_present(piece)
            {
                rest = rest.saturating_sub(piece.length);
                let is_last_of_file =
                    self.index.get(1).is_none_or(|(_, _, next)| !Arc::ptr_eq(&next.file, &piece.file));
                self.forget_first();
                if is_last_of_file {
                    break;
                }
            }
        }
    }

    /// Whether a piece is in the file that is being written.
    fn is_present(&self, piece: &RingPiece) -> bool {
        self.file.as_ref().is_some_and(|(_, file)| Arc::ptr_eq(file.output(), &piece.file))
    }

    fn end(mut self, saver: Saver) {
        self.close();
        drop(saver.orders);
        let _ = saver.thread.join();
    }
}

/// The first block of some, and the others.
fn split_block(octets: &[u8]) -> Option<(&[u8], &[u8])> {
    let length = u32::from_le_bytes(octets.get(4..8)?.try_into().ok()?) as usize;
    octets.split_at_checked(length).filter(|_| length > 0)
}
