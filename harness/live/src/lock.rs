//! One lock per device under test, so that parallel test processes never use the same device.
//!
//! A device inside this process (a model, a null device) is private and needs no lock. The lock is a file lock of the operating
//! system, so it ends with the process that holds it.

use std::fs::{File, OpenOptions, TryLockError};
use std::io::{self, Read, Seek, Write};
use std::path::{Path, PathBuf};
use std::sync::mpsc;
use std::thread;
use std::time::Duration;

/// The lock on a device; the device is free when this is dropped.
#[derive(Debug)]
pub struct Lock {
    _file: File,
}

/// Why a device could not be locked.
#[derive(Debug, thiserror::Error)]
pub enum LockError {
    /// Another process uses it.
    #[error("{device} is in use by {holder}; it was not free within {} s", waited.as_secs())]
    Busy {
        device: String,
        /// The process that uses it, if known.
        holder: Holder,
        /// How long this process waited.
        waited: Duration,
    },
    /// The lock file cannot be used.
    #[error("the lock of {device} cannot be used: {}: {source}", path.display())]
    File { device: String, path: PathBuf, source: io::Error },
}

/// The process that uses a device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Holder(pub Option<u32>);

impl std::fmt::Display for Holder {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.0 {
            Some(process) => write!(f, "process {process}"),
            None => f.write_str("another process"),
        }
    }
}

impl Lock {
    /// Locks `device`, waiting for at most `patience`; `waiting` is called once with the process that holds it.
    ///
    /// `device` is the same text in every process that means the same device; the lock files are in `folder`.
    pub fn take(
        device: &str,
        folder: &Path,
        patience: Duration,
        waiting: &mut dyn FnMut(Holder),
    ) -> Result<Lock, LockError> {
        let path = folder.join(file_name(device));
        let failed = |source| LockError::File { device: device.to_owned(), path: path.clone(), source };
        let file = open(&path).map_err(failed)?;
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::Error(source)) => return Err(failed(source)),
            Err(TryLockError::WouldBlock) => {
                waiting(holder(&file));
                if !wait(&file, patience).map_err(failed)? {
                    let holder = holder(&file);
                    return Err(LockError::Busy { device: device.to_owned(), holder, waited: patience });
                }
            }
        }
        // The holder is only information for waiting processes; the lock works without it.
        let _ = sign(&file);
        Ok(Lock { _file: file })
    }
}

/// Waits for the lock in a thread of its own, because the operating system's wait has no timeout.
fn wait(file: &File, patience: Duration) -> io::Result<bool> {
    let (done, answer) = mpsc::channel();
    let waiter = file.try_clone()?;
    let waiting = thread::spawn(move || done.send(waiter.lock()));
    match answer.recv_timeout(patience) {
        Ok(locked) => {
            // Privileges can be dropped only if no other thread still has them.
            let _ = waiting.join();
            locked.map(|()| true)
        }
        Err(_) => Ok(false),
    }
}

/// Opens a lock file; the file of another user may be read-only, which is enough.
fn open(path: &Path) -> io::Result<File> {
    if path.symlink_metadata().is_ok_and(|found| found.file_type().is_symlink()) {
        return Err(io::Error::other("it is a symbolic link"));
    }
    let writable = OpenOptions::new().read(true).write(true).create(true).truncate(false).open(path);
    writable.or_else(|error| match error.kind() {
        io::ErrorKind::PermissionDenied => File::open(path),
        _ => Err(error),
    })
}

fn sign(mut file: &File) -> io::Result<()> {
    file.set_len(0)?;
    file.rewind()?;
    writeln!(file, "{}", std::process::id())
}

fn holder(mut file: &File) -> Holder {
    let mut text = String::new();
    let read = file.rewind().and_then(|()| file.take(32).read_to_string(&mut text));
    Holder(read.ok().and_then(|_| text.trim().parse().ok()))
}

/// A unique file name for each device: the readable part of its name, and a hash of all of it.
fn file_name(device: &str) -> String {
    let readable: String = device.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '-' }).take(60).collect();
    let sum = device
        .bytes()
        .chain(network().bytes())
        .fold(0xCBF2_9CE4_8422_2325_u64, |sum, octet| (sum ^ u64::from(octet)).wrapping_mul(0x0000_0100_0000_01B3));
    format!("encspec-{readable}-{sum:016x}.lock")
}

/// The network namespace: interfaces in two namespaces may have the same name.
fn network() -> String {
    std::fs::read_link("/proc/thread-self/ns/net").map_or_else(|_| String::new(), |link| link.display().to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn folder(name: &str) -> PathBuf {
        let folder = std::env::temp_dir().join(format!("encspec-lock-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a folder for the test");
        folder
    }

    fn take(device: &str, folder: &Path, holders: &mut Vec<Holder>) -> Result<Lock, LockError> {
        Lock::take(device, folder, Duration::from_millis(50), &mut |holder| holders.push(holder))
    }

    #[test]
    fn a_device_is_locked_by_one_process_at_a_time() {
        let (folder, mut holders) = (folder("one"), Vec::new());
        let first = take("nic:eth0", &folder, &mut holders).expect("it is free");
        let second = take("nic:eth0", &folder, &mut holders);
        let me = Holder(Some(std::process::id()));
        assert!(matches!(second, Err(LockError::Busy { holder, .. }) if holder == me), "{second:?}");
        assert_eq!(holders, [me]);
        drop(first);
        take("nic:eth0", &folder, &mut holders).expect("it is free again");
    }

    #[test]
    fn devices_do_not_share_a_lock() {
        let (folder, mut holders) = (folder("two"), Vec::new());
        let _first = take("nic:eth0", &folder, &mut holders).expect("it is free");
        let _other = take("nic:eth1", &folder, &mut holders).expect("the other is free");
        // Names that look alike in a file name are still two devices.
        let _third = take("nic eth0", &folder, &mut holders).expect("the third is free");
        assert_eq!(holders, []);
    }

    #[test]
    fn a_waiting_process_gets_the_lock_when_it_is_free() {
        let folder = folder("wait");
        let first = take("serial:a", &folder, &mut Vec::new()).expect("it is free");
        let mut first = Some(first);
        // It is released as soon as another process is known to wait.
        let second = Lock::take("serial:a", &folder, Duration::from_secs(30), &mut |_| drop(first.take()));
        second.expect("it became free");
    }

    #[test]
    fn a_symbolic_link_is_refused() {
        let folder = folder("link");
        let target = folder.join("target");
        std::fs::write(&target, "precious").expect("a file");
        let link = folder.join(file_name("nic:eth9"));
        let _ = std::fs::remove_file(&link);
        #[cfg(unix)]
        {
            std::os::unix::fs::symlink(&target, &link).expect("a link");
            assert!(matches!(take("nic:eth9", &folder, &mut Vec::new()), Err(LockError::File { .. })));
        }
        assert_eq!(std::fs::read_to_string(&target).expect("the file"), "precious");
    }
}
