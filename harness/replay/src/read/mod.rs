//! Opens capture files: by name or from standard input, several at a time, with progress.
//!
//! [`capture`](super::capture) judges the contents of a file. [`order`] puts the frames in order of time, [`damage`] says what damage
//! means, and [`reassembly`] reassembles fragmented datagrams. This module must not know what a frame means.

pub(super) mod damage;
pub(super) mod order;
pub(super) mod reassembly;

use super::layout_guess::StationIdentity;
use super::report::{CaptureReport, ReplayReport};
use std::fs::File;
use std::io::{self, Read};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;
use suite::model::Manual;
use virtual_wire::capture::NotACapture;

/// Progress is reported after this many frames.
const PACE: u64 = 0x2000;

/// Upper limit of the files read at the same time; each may need some megabytes for unpacking.
const MOST_AT_ONCE: usize = 4;

/// A file that cannot be replayed.
#[derive(Debug, thiserror::Error)]
#[error("{file}: {why}{}", next(.why))]
pub struct CannotReplay {
    /// The file as the user named it.
    pub file: String,
    pub why: NotACapture,
}

/// What to do about it.
fn next(why: &NotACapture) -> &'static str {
    match why {
        NotACapture::OtherFormat(_) => "; if Wireshark can open it, save it as pcapng there",
        NotACapture::Empty => {
            "; either the recording ended before its first packet, or the file was not copied completely"
        }
        NotACapture::Unreadable(error) if error.kind() == io::ErrorKind::IsADirectory => {
            "; give the names of the capture files in it"
        }
        NotACapture::Unreadable(_) => "",
    }
}

/// Frames and bytes read since the last report, over all files.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ReadProgress {
    /// Frames.
    pub frames: u64,
    /// Bytes of the stored file, packed or not.
    pub octets: u64,
}

/// A callback for progress; it is called from several threads.
pub type ProgressCallback<'a> = &'a (dyn Fn(ReadProgress) + Sync);

/// Reads the capture files, where `-` is standard input, and judges them by the rules of `manuals`.
pub fn files(files: &[String], manuals: &[Manual]) -> Result<ReplayReport, CannotReplay> {
    let captures = each(files, manuals, &|_| {}).into_iter().collect::<Result<_, _>>()?;
    Ok(ReplayReport { captures })
}

/// Like [`files`], several files at a time, with the results in the given order; calls `progress` while it reads.
pub fn each(
    files: &[String],
    manuals: &[Manual],
    progress: ProgressCallback<'_>,
) -> Vec<Result<CaptureReport, CannotReplay>> {
    let next = AtomicUsize::new(0);
    let done: Mutex<Vec<_>> = Mutex::new(files.iter().map(|_| None).collect());
    let workers = thread::available_parallelism().map_or(1, usize::from).min(files.len()).min(MOST_AT_ONCE);
    let work = || {
        loop {
            let place = next.fetch_add(1, Ordering::Relaxed);
            let Some(name) = files.get(place) else { return };
            let report = file(name, manuals, progress);
            // If a thread panics the whole replay panics at the end of the scope.
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

fn file(name: &str, manuals: &[Manual], progress: ProgressCallback<'_>) -> Result<CaptureReport, CannotReplay> {
    let octets = AtomicUsize::new(0);
    let mut frames = 0;
    let mut report_progress = |read: u64, at_end: bool| {
        if at_end || read.is_multiple_of(PACE) {
            progress(ReadProgress { frames: read - frames, octets: octets.swap(0, Ordering::Relaxed) as u64 });
            frames = read;
        }
    };
    let mut read = |input: &mut dyn Read, identities: &[StationIdentity]| {
        super::capture_with(name, CountedReader(input, &octets), manuals, identities, &mut report_progress)
    };
    let report = match name {
        "-" => read(&mut io::stdin().lock(), &[]).map(|(report, _)| report),
        _ => File::open(name).map_err(NotACapture::from).and_then(|mut file| match read(&mut file, &[])? {
            (report, late) if late.is_empty() => Ok(report),
            // A later frame says what a station is: its manual holds from the first frame on.
            (_, late) => Ok(read(&mut File::open(name)?, &late)?.0),
        }),
    };
    report.map_err(|why| CannotReplay { file: name.to_owned(), why })
}

/// Counts the bytes read from a file.
struct CountedReader<'a, R>(R, &'a AtomicUsize);

impl<R: Read> Read for CountedReader<'_, R> {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        let read = self.0.read(into)?;
        self.1.fetch_add(read, Ordering::Relaxed);
        Ok(read)
    }
}
