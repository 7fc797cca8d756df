//! Safe functions for system calls for which no safe library exists.
//!
//! This module must not know what the descriptors and frames are used for.
#![expect(unsafe_code, reason = "system calls; every block says why it is sound")]

#[cfg(target_os = "linux")]
pub mod packet;
#[cfg(target_os = "linux")]
pub mod process;
#[cfg(target_os = "linux")]
pub mod serial;

use std::io;
use std::os::fd::{AsRawFd, BorrowedFd};

use crate::Clock;
use station::{Duration, Time};

/// The events that [`wait`] waits for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PollEvent {
    /// Data can be read; also an error or the end of the stream.
    Reading,
    /// Data can be written.
    Writing,
    /// Either of the two.
    Both,
}

/// Waits until `socket` is ready for `event` or `clock` shows `until`; an interrupt ends the wait early.
pub fn wait(socket: BorrowedFd<'_>, event: PollEvent, clock: &Clock, until: Time) -> io::Result<()> {
    let events = match event {
        PollEvent::Reading => libc::POLLIN,
        PollEvent::Writing => libc::POLLOUT,
        PollEvent::Both => libc::POLLIN | libc::POLLOUT,
    };
    poll(&mut [libc::pollfd { fd: socket.as_raw_fd(), events, revents: 0 }], clock.remaining(until))
}

/// Sleeps until `clock` shows `until`; an interrupt ends it early.
pub fn pause(clock: &Clock, until: Time) {
    // Without a descriptor the only error is an interrupt, which ends the sleep.
    let _ = poll(&mut [], clock.remaining(until));
}

#[cfg(target_os = "linux")]
fn poll(entries: &mut [libc::pollfd], timeout: Duration) -> io::Result<()> {
    let timeout = libc::timespec {
        tv_sec: libc::time_t::try_from(timeout.as_secs()).unwrap_or(libc::time_t::MAX),
        tv_nsec: timeout.subsec_nanos() as libc::c_long,
    };
    let count = entries.len() as libc::nfds_t;
    // SAFETY: `entries` and `timeout` live through the call, `count` is the length of `entries`, no mask is given.
    let result = unsafe { libc::ppoll(entries.as_mut_ptr(), count, &raw const timeout, std::ptr::null()) };
    interrupted_is_fine(result)
}

#[cfg(not(target_os = "linux"))]
fn poll(entries: &mut [libc::pollfd], timeout: Duration) -> io::Result<()> {
    let timeout = i32::try_from(timeout.as_micros().div_ceil(1000)).unwrap_or(i32::MAX);
    // SAFETY: `entries` lives through the call and its length is passed.
    let result = unsafe { libc::poll(entries.as_mut_ptr(), entries.len() as libc::nfds_t, timeout) };
    interrupted_is_fine(result)
}

fn interrupted_is_fine(result: libc::c_int) -> io::Result<()> {
    if result >= 0 {
        return Ok(());
    }
    let error = io::Error::last_os_error();
    if error.kind() == io::ErrorKind::Interrupted { Ok(()) } else { Err(error) }
}

/// Sets an option of a socket.
///
/// `T` is an integer or a C structure without pointers.
pub fn set_option<T: Copy>(socket: BorrowedFd<'_>, level: i32, name: i32, value: T) -> io::Result<()> {
    let length = size_of::<T>() as libc::socklen_t;
    // SAFETY: `value` lives through the call and `length` is its size; the kernel only reads it.
    let result =
        unsafe { libc::setsockopt(socket.as_raw_fd(), level, name, (&raw const value).cast::<libc::c_void>(), length) };
    if result == 0 { Ok(()) } else { Err(io::Error::last_os_error()) }
}
