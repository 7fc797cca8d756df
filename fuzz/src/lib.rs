//! What the fuzz targets share: captures made of fuzzed frames, and a device whose wire a fuzzer disturbs.

use std::path::Path;
use std::sync::LazyLock;
use suite::model::Manual;
use suite_yaml::Sources;
use virtual_wire::PcapngWriter;
use virtual_wire::capture::LinkType;

mod disturbed;
mod files;
mod wires;

pub use disturbed::{exchange, trials};

/// The manual whose rules judge fuzzed captures on PROFINET.
pub const PROFINET: &str = "lika-xac77-profinet";
/// The manual whose rules judge fuzzed captures on PROFIBUS.
pub const PROFIBUS: &str = "datalogic-amt58-profibus";

/// A target: its name, and what it does with the bytes of the fuzzer.
pub type FuzzTarget = (&'static str, fn(&[u8]));

/// All targets. Those of captures read, judge and tell; those of exchanges have a controller or master, a device and a case.
pub static TARGETS: [FuzzTarget; 14] = [
    ("application", files::application),
    ("bench_file", files::bench_file),
    ("capture", replayed),
    ("dp_exchange", |data| exchange(PROFIBUS, data)),
    ("ethernet_frames", |data| replayed(&capture(data, LinkType::ETHERNET))),
    ("gsd", files::gsd),
    ("gsdml", files::gsdml),
    ("hex_log", files::hex_log),
    ("io_exchange", |data| exchange(PROFINET, data)),
    ("profibus", wires::profibus),
    ("profinet", wires::profinet),
    ("qemu", files::qemu),
    ("suite", files::suite),
    ("telegrams", |data| replayed(&capture(data, LinkType::PROFIBUS))),
];

/// The target of this name.
pub fn target(name: &str) -> Option<fn(&[u8])> {
    TARGETS.iter().find(|(of, _)| *of == name).map(|(_, does)| *does)
}

/// The suites of the checkout, read when a target starts: to build them in would build their loader twice.
pub static SUITES: LazyLock<Sources> = LazyLock::new(|| {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../suites");
    Sources::folder(&folder).unwrap_or_else(|errors| panic!("{errors}"))
});

/// The two manuals.
pub static MANUALS: LazyLock<Vec<Manual>> =
    LazyLock::new(|| suite_yaml::load_some(&SUITES, &[PROFINET, PROFIBUS]).unwrap_or_else(|errors| panic!("{errors}")));

/// Fuzzed bytes as frames: before each stand two bytes of length, then two of the time since the frame before, in steps of 16 µs.
pub fn frames(data: &[u8]) -> impl Iterator<Item = (u64, &[u8])> {
    let (mut rest, mut time) = (data, 0);
    std::iter::from_fn(move || {
        let (&[length, longer, short, long], behind) = rest.split_first_chunk()?;
        let length = usize::from(u16::from_le_bytes([length, longer]) % 1600).min(behind.len());
        let (frame, behind) = behind.split_at(length);
        time += u64::from(u16::from_le_bytes([short, long])) * 16_000;
        rest = behind;
        Some((time, frame))
    })
}

/// A capture of fuzzed frames.
pub fn capture(data: &[u8], link: LinkType) -> Vec<u8> {
    let write = || -> std::io::Result<Vec<u8>> {
        let mut writer = PcapngWriter::new(Vec::new(), "fuzz")?;
        let interface = writer.interface("fuzz", link)?;
        for (time, frame) in frames(data) {
            writer.packet(interface, station::Time::from_nanos(time), frame, None)?;
        }
        writer.finish()
    };
    write().expect("a vector takes everything")
}

/// Reads and judges a capture, and makes all its texts.
pub fn replayed(octets: &[u8]) {
    if let Ok(report) = replay::capture("fuzz", octets, &MANUALS) {
        let mut annotated = Vec::new();
        let _ = replay::annotate(&report, octets, &mut annotated, None);
        let report = replay::ReplayReport { captures: vec![report] };
        std::hint::black_box(replay::text(&report));
        std::hint::black_box(serde_json::to_string(&report).expect("a report is JSON"));
    }
}

/// Reads bytes with a function, writes what was read and reads it again: both have to be the same.
#[macro_export]
macro_rules! twice {
    ($read:expr, $octets:expr) => {
        if let Ok(first) = $read($octets) {
            let mut written = Vec::new();
            first.write(&mut written);
            let again = $read(&written);
            assert_eq!(again.as_ref(), Ok(&first), "written as {written:02X?}");
        }
    };
}
