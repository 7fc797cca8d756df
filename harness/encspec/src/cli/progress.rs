//! A progress bar on standard error for captures that are read, if standard error is a terminal.

use indicatif::{HumanCount, ProgressBar, ProgressState, ProgressStyle};
use replay::ReadProgress;
use std::fs;
use std::io::{self, IsTerminal};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// The progress of reading some files.
pub(super) struct CaptureReadProgress {
    bar: ProgressBar,
    frames: Arc<AtomicU64>,
}

impl CaptureReadProgress {
    /// A bar for these files; hidden if standard error is not a terminal.
    pub fn of(files: &[String]) -> CaptureReadProgress {
        let frames = Arc::new(AtomicU64::new(0));
        if !io::stderr().is_terminal() {
            return CaptureReadProgress { bar: ProgressBar::hidden(), frames };
        }
        // Pipes have no length.
        let lengths: Option<u64> = files.iter().map(|name| Some(fs::metadata(name).ok()?.len())).sum();
        let (bar, template) = match lengths.filter(|&length| length > 0) {
            Some(length) => (ProgressBar::new(length), "{bar:30} {percent}% {frames}, {rate}, {eta} left"),
            None => (ProgressBar::new_spinner(), "{spinner} {frames}, {rate}, {elapsed}"),
        };
        let (counted, rated) = (frames.clone(), frames.clone());
        let style = ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar());
        // A failed write only affects the bar.
        let style = style
            .with_key("frames", move |_: &ProgressState, out: &mut dyn std::fmt::Write| {
                let _ = write!(out, "{} frames", HumanCount(counted.load(Ordering::Relaxed)));
            })
            .with_key("rate", move |state: &ProgressState, out: &mut dyn std::fmt::Write| {
                let seconds = state.elapsed().as_secs_f64().max(0.001);
                let rate = rated.load(Ordering::Relaxed) as f64 / seconds;
                let _ = write!(out, "{} frames/s", HumanCount(rate as u64));
            });
        CaptureReadProgress { bar: bar.with_style(style), frames }
    }

    /// Advances the bar. Several threads may call it.
    pub fn step(&self, progress: ReadProgress) {
        self.frames.fetch_add(progress.frames, Ordering::Relaxed);
        self.bar.inc(progress.octets);
    }
}

impl Drop for CaptureReadProgress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
