//! Opening capture files: by name or from standard input, several at a time, with the progress that is made.
//!
//! What is in a file is looked at by [`capture`](super::capture); the order of its frames is put right by [`order`], and what
//! damage means is told by [`damage`], and datagrams that were cut are put together by [`reassembly`]. This room must not know what a frame means.

pub(super) mod damage;
pub(super) mod order;
pub(super) mod reassembly;

use super::report::{CaptureReport, ReplayReport};
use std::fs::File;
use std::io::{self, Read};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;
use suite::model::Manual;
use virtual_wire::capture::NotACapture;

/// After how many frames the progress is told.
const PACE: u64 = 0x2000;

/// Files that are read at the same time; each may need some megabytes to be unpacked.
const MOST_AT_ONCE: usize = 4;

/// Why a file cannot be replayed at all.
#[derive(Debug, thiserror::Error)]
#[error("{file}: {why}{}", next(.why))]
pub struct CannotReplay {
    /// The file as it was named.
    pub file: String,
    /// Why.
    pub why: NotACapture,
}

/// What to do about it.
fn next(why: &NotACapture) -> &'static str {
    match why {
        NotACapture::OtherFormat(_) => "; if Wireshark opens it, save it as pcapng there",
        NotACapture::Empty => "; the recording ended before its first packet, or the file was not copied",
        NotACapture::Unreadable(error) if error.kind() == io::ErrorKind::IsADirectory => "; name the captures in it",
        NotACapture::Unreadable(_) => "",
    }
}

/// What was read since the last time that it was told, of whichever file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Progress {
    /// Frames.
    pub frames: u64,
    /// Octets of the file as it is stored, packed or not.
    pub octets: u64,
}

/// Who is told what progress is made, from several threads.
pub type Told<'a> = &'a (dyn Fn(Progress) + Sync);

/// Reads the capture files, `-` being standard input, and judges them by the rules of `manuals`.
pub fn files(files: &[String], manuals: &[Manual]) -> Result<ReplayReport, CannotReplay> {
    let captures = each(files, manuals, &|_| {}).into_iter().collect::<Result<_, _>>()?;
    Ok(ReplayReport { captures })
}

/// The same, several at a time, file by file in the order in which they were named; `told` hears of the progress.
pub fn each(files: &[String], manuals: &[Manual], told: Told<'_>) -> Vec<Result<CaptureReport, CannotReplay>> {
    let next = AtomicUsize::new(0);
    let done: Mutex<Vec<_>> = Mutex::new(files.iter().map(|_| None).collect());
    let workers = thread::available_parallelism().map_or(1, usize::from).min(files.len()).min(MOST_AT_ONCE);
    let work = || {
        loop {
            let place = next.fetch_add(1, Ordering::Relaxed);
            let Some(name) = files.get(place) else { return };
            let report = file(name, manuals, told);
            // A thread that panicked takes the whole replay down when its scope ends.
            if let Ok(mut done) = done.lock() {
                done[place] = Some(report);
            }
        }
    };
    match workers {
        0 | 1 => work(),
        _ => thread::scope(|scope| {
            for _ in 0..workers {
                scope.spawn(work);
            }
        }),
    }
    done.into_inner().map(|done| done.into_iter().flatten().collect()).unwrap_or_default()
}

fn file(name: &str, manuals: &[Manual], told: Told<'_>) -> Result<CaptureReport, CannotReplay> {
    let octets = AtomicUsize::new(0);
    let mut frames = 0;
    let mut tell = |read: u64, at_end: bool| {
        if at_end || read.is_multiple_of(PACE) {
            told(Progress { frames: read - frames, octets: octets.swap(0, Ordering::Relaxed) as u64 });
            frames = read;
        }
    };
    let report = match name {
        "-" => super::capture_with(name, Counted(io::stdin().lock(), &octets), manuals, &mut tell),
        _ => File::open(name)
            .map_err(NotACapture::from)
            .and_then(|file| super::capture_with(name, Counted(file, &octets), manuals, &mut tell)),
    };
    report.map_err(|why| CannotReplay { file: name.to_owned(), why })
}

/// Counts the octets that are read of a file.
struct Counted<'a, R>(R, &'a AtomicUsize);

impl<R: Read> Read for Counted<'_, R> {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        let read = self.0.read(into)?;
        self.1.fetch_add(read, Ordering::Relaxed);
        Ok(read)
    }
}
