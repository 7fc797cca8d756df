//! What Linux lets be set at a serial line beyond termios.

use std::io;
use std::os::fd::{AsRawFd, BorrowedFd};

/// Where the flags stand in `serial_struct`, in words of 32 bits.
const FLAGS: usize = 4;
/// Octets are handed over at once instead of being gathered.
const LOW_LATENCY: u32 = 1 << 13;
/// More words than `serial_struct` has on any machine.
const WORDS: usize = 32;

/// The kernel is to hand over received octets at once; a line that cannot do so says so.
pub fn low_latency(line: BorrowedFd<'_>) -> io::Result<()> {
    // The structure holds a pointer, which wants its alignment.
    #[repr(C, align(16))]
    struct Line([u32; WORDS]);
    let mut state = Line([0; WORDS]);
    let pointer = &raw mut state;
    // SAFETY: `state` lives through the call and is larger than the structure that the kernel writes.
    if unsafe { libc::ioctl(line.as_raw_fd(), libc::TIOCGSERIAL as _, pointer) } != 0 {
        return Err(io::Error::last_os_error());
    }
    state.0[FLAGS] |= LOW_LATENCY;
    let pointer = &raw const state;
    // SAFETY: `state` is what the kernel has written but for one flag; it only reads it.
    match unsafe { libc::ioctl(line.as_raw_fd(), libc::TIOCSSERIAL as _, pointer) } {
        0 => Ok(()),
        _ => Err(io::Error::last_os_error()),
    }
}

/// The hardware is to switch the driver of RS-485 on while it sends; a line that cannot do so says so.
pub fn drive_rs485(line: BorrowedFd<'_>) -> io::Result<()> {
    const ENABLED: u32 = 1;
    const RTS_ON_SEND: u32 = 1 << 1;
    const SET: libc::c_ulong = 0x542F;
    let settings: [u32; 8] = [ENABLED | RTS_ON_SEND, 0, 0, 0, 0, 0, 0, 0];
    let pointer = &raw const settings;
    // SAFETY: `settings` has the size of `serial_rs485` and lives through the call.
    match unsafe { libc::ioctl(line.as_raw_fd(), SET as _, pointer) } {
        0 => Ok(()),
        _ => Err(io::Error::last_os_error()),
    }
}

/// The line RTS is to be off; a line that has none says so.
pub fn take_rts_away(line: BorrowedFd<'_>) -> io::Result<()> {
    let lines: libc::c_int = libc::TIOCM_RTS;
    let pointer = &raw const lines;
    // SAFETY: `lines` is the int that the kernel reads and lives through the call.
    match unsafe { libc::ioctl(line.as_raw_fd(), libc::TIOCMBIC as _, pointer) } {
        0 => Ok(()),
        _ => Err(io::Error::last_os_error()),
    }
}
