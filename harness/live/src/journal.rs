//! The journal of a live run: the device before the run, each change with its reason, and every verdict. Each entry is on the
//! disk before the run continues.
//!
//! A journal is a file of JSON lines in the folder `encspec-journal`. Its first line describes the device as found; a closing
//! line says that everything was restored, or why nothing more is. Unrestored changes survive a crash, and `encspec bench restore`
//! reads them. This module must not know how anything is restored.

pub use results::journal::{InitialDevice, InitialImRecord, InitialParameter, JournalEntry};
use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// The folder of the journals, in the current folder.
pub const FOLDER: &str = "encspec-journal";

/// A journal that is being written.
#[derive(Debug)]
pub struct Journal {
    file: File,
    path: PathBuf,
}

impl Journal {
    /// Begins a journal in `folder` with the device as found; the entry is on the disk when this returns.
    pub fn begin(folder: &Path, found: &InitialDevice) -> io::Result<Journal> {
        fs::create_dir_all(folder)?;
        let mac: String = match found.station {
            Some(station) => format!("station-{station}"),
            None => found.mac.chars().filter(char::is_ascii_hexdigit).collect(),
        };
        for number in 0..1000 {
            let path = folder.join(format!("{mac}-{}-{number}.jsonl", found.began));
            match OpenOptions::new().append(true).create_new(true).open(&path) {
                Ok(file) => {
                    let mut journal = Journal { file, path };
                    journal.add(&JournalEntry::Found(found.clone()))?;
                    // A new file is durable only when its folder is synced too.
                    File::open(folder)?.sync_all()?;
                    return Ok(journal);
                }
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
                Err(error) => return Err(error),
            }
        }
        Err(io::Error::other("too many journals of this device in this second"))
    }

    /// Continues an existing journal.
    pub fn resume(path: &Path) -> io::Result<Journal> {
        let file = OpenOptions::new().append(true).open(path)?;
        Ok(Journal { file, path: path.to_owned() })
    }

    /// Appends an entry; it is on the disk when this returns.
    pub fn add(&mut self, entry: &JournalEntry) -> io::Result<()> {
        let mut line = serde_json::to_string(entry)?;
        line.push('\n');
        self.file.write_all(line.as_bytes())?;
        self.file.sync_data()
    }

    /// The path of the file.
    pub fn path(&self) -> &Path {
        &self.path
    }
}

/// Why a journal cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum JournalError {
    /// The file cannot be read.
    #[error("the journal {} cannot be read: {source}", path.display())]
    File { path: PathBuf, source: io::Error },
    /// A line other than the last is invalid.
    #[error("line {line} of {} is not a journal entry: {why}", path.display())]
    Line {
        path: PathBuf,
        /// Line number, from 1.
        line: usize,
        why: String,
    },
    /// The first line does not describe the device.
    #[error("{} does not begin with the state of the device, so nothing can be restored from it", path.display())]
    NoBegin { path: PathBuf },
}

/// The content of a journal.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct JournalContent {
    /// The device as found.
    pub found: InitialDevice,
    /// The parameters as found.
    pub parameters: Vec<InitialParameter>,
    /// The records I&M1 to I&M4 as found.
    pub im_records: Vec<InitialImRecord>,
    /// The changes, in words; empty if there are none.
    pub changes: Vec<String>,
    /// The trial that was interrupted, and the names that it set at the stand.
    pub interrupted: Option<(String, Vec<String>)>,
    /// Number of verdicts.
    pub verdicts: usize,
    /// Whether everything was restored, or the journal was closed on purpose.
    pub closed: bool,
}

impl JournalContent {
    /// Whether something must still be restored.
    pub fn is_open(&self) -> bool {
        !self.closed && (!self.changes.is_empty() || !self.stand().is_empty())
    }

    /// The names at the stand that an interrupted trial may not have set back.
    pub fn stand(&self) -> &[String] {
        self.interrupted.as_ref().map_or(&[], |(_, stand)| stand)
    }

    /// Whether one of the changes begins with `word`.
    pub fn has_changed(&self, word: &str) -> bool {
        self.changes.iter().any(|change| change.starts_with(word))
    }
}

/// Reads a journal; an incomplete last line is ignored.
pub fn read(path: &Path) -> Result<JournalContent, JournalError> {
    let failed = |source| JournalError::File { path: path.to_owned(), source };
    let text = fs::read(path).map_err(failed)?;
    let text = String::from_utf8_lossy(&text);
    let mut entries = Vec::new();
    let lines: Vec<&str> = text.split_inclusive('\n').collect();
    for (index, line) in lines.iter().enumerate() {
        match serde_json::from_str::<JournalEntry>(line.trim_end()) {
            Ok(entry) => entries.push(entry),
            Err(_) if index + 1 == lines.len() && !line.ends_with('\n') => {}
            Err(error) => {
                return Err(JournalError::Line { path: path.to_owned(), line: index + 1, why: error.to_string() });
            }
        }
    }
    let mut entries = entries.into_iter();
    let Some(JournalEntry::Found(found)) = entries.next() else {
        return Err(JournalError::NoBegin { path: path.to_owned() });
    };
    let mut kept = JournalContent {
        found,
        parameters: Vec::new(),
        im_records: Vec::new(),
        changes: Vec::new(),
        interrupted: None,
        verdicts: 0,
        closed: false,
    };
    for entry in entries {
        match entry {
            JournalEntry::Found(_) | JournalEntry::Remark { .. } => {}
            JournalEntry::Permanence { name, ip } => {
                (kept.found.name_permanence, kept.found.ip_permanence) = (name, ip);
                kept.interrupted = None;
            }
            JournalEntry::Parameters(parameters) => kept.parameters = parameters,
            JournalEntry::ImRecords(records) => kept.im_records = records,
            JournalEntry::Changes { trial, what, stand } => {
                kept.closed = false;
                kept.interrupted = Some((trial, stand));
                for word in what {
                    if !kept.changes.contains(&word) {
                        kept.changes.push(word);
                    }
                }
            }
            JournalEntry::Verdict { .. } => {
                kept.interrupted = None;
                kept.verdicts += 1;
            }
            JournalEntry::Restored | JournalEntry::Closed { .. } => kept.closed = true,
        }
    }
    Ok(kept)
}

/// The journals in `folder` with unrestored changes, the newest first: the changes of the last run are restored before those of
/// earlier runs.
pub fn unrestored(folder: &Path) -> Vec<(PathBuf, JournalContent)> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let paths = entries.map(|entry| entry.path()).filter(|path| path.extension().is_some_and(|end| end == "jsonl"));
    let journals = paths.filter_map(|path| read(&path).ok().map(|kept| (path, kept)));
    let mut open: Vec<_> = journals.filter(|(_, kept)| kept.is_open()).collect();
    open.sort_by_key(|(_, kept)| std::cmp::Reverse(kept.found.began));
    open
}

#[cfg(test)]
mod tests {
    use super::*;
    use results::bench_file::DcpPermanence;
    use std::net::Ipv4Addr;

    fn found() -> InitialDevice {
        InitialDevice {
            version: "0.1.0".into(),
            began: 1_700_000_000,
            link: "nic:eth0".into(),
            bench: None,
            manual: "a-manual".into(),
            variant: "a-variant".into(),
            mac: "02:00:00:00:01:00".into(),
            station: None,
            vendor_id: 0x0239,
            device_id: 1,
            name: b"encoder-7".to_vec(),
            ip: Ipv4Addr::new(192, 168, 0, 10),
            mask: Ipv4Addr::new(255, 255, 255, 0),
            gateway: Ipv4Addr::UNSPECIFIED,
            ip_permanence: DcpPermanence::Permanent,
            name_permanence: DcpPermanence::Unknown,
        }
    }

    fn changes(what: &str) -> JournalEntry {
        JournalEntry::Changes { trial: "t".into(), what: vec![what.into()], stand: Vec::new() }
    }

    fn folder(name: &str) -> PathBuf {
        let folder = std::env::temp_dir().join(format!("encspec-journal-{name}-{}", std::process::id()));
        let _ = fs::remove_dir_all(&folder);
        folder
    }

    #[test]
    fn changes_are_recorded_wherever_the_run_was_interrupted() {
        let folder = folder("cut");
        let mut journal = Journal::begin(&folder, &found()).expect("a new journal");
        let parameters =
            vec![InitialParameter { number: 65000, subindex: 0, format: 0x43, octets: vec![0, 0, 0x12, 0x34] }];
        journal.add(&JournalEntry::Parameters(parameters.clone())).expect("written");
        journal.add(&changes("set_name")).expect("written");
        journal.add(&JournalEntry::Verdict { trial: "t".into(), verdict: "pass".into() }).expect("written");
        let whole = fs::read(journal.path()).expect("the file");
        let lines: Vec<usize> = (0..whole.len()).filter(|&at| whole[at] == b'\n').collect();
        for cut in 0..=whole.len() {
            fs::write(journal.path(), &whole[..cut]).expect("the file");
            let complete = lines.iter().filter(|&&end| cut >= end).count();
            match read(journal.path()) {
                Ok(kept) => {
                    assert!(complete >= 1, "cut at {cut}");
                    assert_eq!(kept.found, found());
                    assert_eq!(kept.parameters == parameters, complete >= 2, "cut at {cut}");
                    assert_eq!(kept.changes.len(), usize::from(complete >= 3), "cut at {cut}");
                    assert_eq!(kept.verdicts, usize::from(complete >= 4), "cut at {cut}");
                    assert_eq!(unrestored(&folder).len(), usize::from(complete >= 3), "cut at {cut}");
                }
                Err(error) => assert!(complete == 0, "cut at {cut}: {error}"),
            }
        }
    }

    #[test]
    fn the_last_line_closes_a_journal_and_two_journals_have_two_files() {
        let folder = folder("two");
        let mut first = Journal::begin(&folder, &found()).expect("a new journal");
        let second = Journal::begin(&folder, &found()).expect("another one in the same second");
        assert_ne!(first.path(), second.path());
        first.add(&changes("set_ip")).expect("written");
        let open: Vec<PathBuf> = unrestored(&folder).into_iter().map(|(path, _)| path).collect();
        assert_eq!(open, [first.path()]);
        first.add(&JournalEntry::Restored).expect("written");
        assert!(unrestored(&folder).is_empty());
    }

    #[test]
    fn a_journal_is_closed_on_purpose_with_a_reason() {
        let folder = folder("closed");
        let mut journal = Journal::begin(&folder, &found()).expect("a new journal");
        journal.add(&changes("set_ip")).expect("written");
        assert_eq!(unrestored(&folder).len(), 1);
        journal.add(&JournalEntry::Closed { reason: "the device was replaced".into() }).expect("written");
        assert!(unrestored(&folder).is_empty());
        let text = fs::read_to_string(journal.path()).expect("the file");
        assert!(text.ends_with("{\"closed\":{\"reason\":\"the device was replaced\"}}\n"), "{text}");
    }

    #[test]
    fn an_interrupted_trial_leaves_what_it_set_at_the_stand() {
        let folder = folder("stand");
        let mut journal = Journal::begin(&folder, &found()).expect("a new journal");
        let entry = |trial: &str| JournalEntry::Changes {
            trial: trial.into(),
            what: Vec::new(),
            stand: vec!["power".into(), "fault.memory".into()],
        };
        journal.add(&entry("first")).expect("written");
        journal.add(&JournalEntry::Verdict { trial: "first".into(), verdict: "pass".into() }).expect("written");
        assert!(unrestored(&folder).is_empty(), "it was set back before the verdict");
        journal.add(&entry("second")).expect("written");
        let kept = read(journal.path()).expect("a journal");
        assert_eq!(kept.interrupted.as_ref().map(|(trial, _)| trial.as_str()), Some("second"));
        assert_eq!(kept.stand(), ["power", "fault.memory"]);
        assert!(kept.is_open());
    }

    #[test]
    fn a_journal_of_an_earlier_version_is_read() {
        let folder = folder("earlier");
        let journal = Journal::begin(&folder, &found()).expect("a new journal");
        let text = fs::read_to_string(journal.path()).expect("the file");
        let text = text.replace(",\"ip_permanence\":\"permanent\"", "");
        let text = text + "{\"changes\":{\"trial\":\"t\",\"what\":[\"set_name\"]}}\n";
        fs::write(journal.path(), text).expect("the file");
        let kept = read(journal.path()).expect("a journal");
        assert_eq!((kept.found.ip_permanence, kept.is_open()), (DcpPermanence::Unknown, true));
    }

    #[test]
    fn an_invalid_line_is_reported() {
        let folder = folder("line");
        let journal = Journal::begin(&folder, &found()).expect("a new journal");
        let mut text = fs::read_to_string(journal.path()).expect("the file");
        text.push_str("{\"verdikt\": 1}\n");
        fs::write(journal.path(), &text).expect("the file");
        let error = read(journal.path()).expect_err("no such line").to_string();
        assert!(error.starts_with("line 2 of ") && error.contains("verdikt"), "{error}");
        assert!(matches!(read(&folder.join("none")), Err(JournalError::File { .. })));
    }
}
