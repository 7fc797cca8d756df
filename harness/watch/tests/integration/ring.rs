//! The ring on disk and the incidents saved from it.

use crate::machine::{GOOD, STOP, run, time};
use encspec_watch::{DiskRing, LiveWatch, RingSettings, WatchLine};
use station::{Duration, Time};
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use virtual_wire::CaptureReader;
use virtual_wire::capture::{CaptureItem, LinkType};

/// A folder that is removed at the end.
struct RecorderFolder(PathBuf);

impl RecorderFolder {
    fn new(name: &str) -> RecorderFolder {
        let path = std::env::temp_dir().join(format!("encspec-watch-{name}-{}", std::process::id()));
        let _ = fs::remove_dir_all(&path);
        RecorderFolder(path)
    }

    fn files(&self, begin: &str) -> Vec<PathBuf> {
        let entries = fs::read_dir(&self.0).expect("the folder").map(|entry| entry.expect("an entry").path());
        let mut found: Vec<PathBuf> =
            entries.filter(|path| path.file_name().is_some_and(|of| of.to_string_lossy().starts_with(begin))).collect();
        found.sort();
        found
    }

    fn ring(&self, size: u64) -> DiskRing {
        let interfaces = vec![("line".to_owned(), LinkType::ETHERNET)];
        let settings = RingSettings { folder: self.0.clone(), size, incidents: 100_000_000, interfaces };
        DiskRing::start(&settings).expect("a folder")
    }
}

impl Drop for RecorderFolder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// The times and comments of a capture, which must not be damaged.
fn packets(path: &Path) -> Vec<(Time, Option<String>)> {
    let mut reader = CaptureReader::new(File::open(path).expect("a file")).expect("a capture");
    let mut packets = Vec::new();
    while let Some(item) = reader.next() {
        match item {
            CaptureItem::Packet(packet) => packets.push((packet.time, packet.comment.map(|of| of.into_owned()))),
            CaptureItem::Damage(damage) => panic!("{}: {}", path.display(), damage.what),
        }
    }
    packets
}

#[test]
fn an_incident_has_the_frames_from_30_s_before_to_10_s_after_and_the_finding_as_a_comment() {
    let folder = RecorderFolder::new("incident");
    let mut watch = LiveWatch::new(&[], Some(folder.ring(100_000_000)));
    let stop = 40_000..40_300;
    let lines =
        run(&mut watch, 0..60_000, |from, cycle| Some(if from == 0x10 && stop.contains(&cycle) { STOP } else { GOOD }));
    let name = lines.iter().find_map(|(_, line)| match line {
        WatchLine::Finding(line) => line.incident.clone(),
        _ => None,
    });
    let (rest, counts) = watch.end();
    let is_saved = |line: &WatchLine| matches!(line, WatchLine::Incident { is_complete: true, .. });
    assert!(lines.iter().map(|(_, line)| line).chain(&rest).any(is_saved));
    assert_eq!((counts.incidents, counts.lost_by_ring), (1, 0));
    let packets = packets(&folder.0.join(name.expect("the finding names its incident")));
    let (first, last) = (packets[0].0, packets[packets.len() - 1].0);
    let begin = time(40_000).since(first);
    assert!(begin >= Duration::from_secs(30) && begin < Duration::from_millis(30_200), "{begin:?}");
    let end = last.since(time(40_000));
    assert!(end >= Duration::from_secs(10) && end < Duration::from_secs(13), "{end:?}");
    let commented: Vec<_> = packets.iter().filter(|(_, comment)| comment.is_some()).collect();
    assert_eq!(commented.len(), 1);
    assert_eq!(commented[0].0, time(40_000) + Duration::from_micros(160));
    assert!(commented[0].1.as_ref().is_some_and(|text| text.starts_with("PN-STATUS-STOP")));
    // No frame is missing: four stations send in each millisecond.
    let expected = (last.since(first).as_micros() as usize).div_ceil(1_000) * 4;
    assert!(packets.len().abs_diff(expected) <= 4, "{} packets, {expected} expected", packets.len());
}

#[test]
fn the_ring_keeps_to_its_size_and_its_files_are_whole() {
    let folder = RecorderFolder::new("size");
    let size = 2_000_000;
    let mut watch = LiveWatch::new(&[], Some(folder.ring(size)));
    run(&mut watch, 0..30_000, |_, _| Some(GOOD));
    let (_, counts) = watch.end();
    assert_eq!(counts.lost_by_ring, 0);
    let files = folder.files("ring-");
    let sum: u64 = files.iter().map(|path| fs::metadata(path).expect("a file").len()).sum();
    assert!(sum <= size && sum > size * 8 / 10, "{sum} bytes");
    let times: Vec<Time> = files.iter().flat_map(|path| packets(path)).map(|(time, _)| time).collect();
    assert!(times.is_sorted());
    assert_eq!(times.last(), Some(&(time(29_999) + Duration::from_micros(190))));
}

#[test]
fn a_ring_goes_on_where_an_earlier_one_ended_and_begins_a_new_file_when_asked() {
    let folder = RecorderFolder::new("again");
    let mut watch = LiveWatch::new(&[], Some(folder.ring(50_000_000)));
    run(&mut watch, 0..1_000, |_, _| Some(GOOD));
    watch.rotate();
    run(&mut watch, 1_000..2_000, |_, _| Some(GOOD));
    watch.end();
    assert_eq!(folder.files("ring-").len(), 2);
    let mut watch = LiveWatch::new(&[], Some(folder.ring(50_000_000)));
    run(&mut watch, 2_000..3_000, |_, _| Some(GOOD));
    watch.end();
    let files = folder.files("ring-");
    assert_eq!(files.iter().map(|path| packets(path).len()).collect::<Vec<_>>(), [4_000, 4_000, 4_000]);
}
