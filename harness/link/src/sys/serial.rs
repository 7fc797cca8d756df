//! Linux settings of a serial line beyond termios.

use std::io;
use std::os::fd::{AsRawFd, BorrowedFd};

/// The index of the flags in `serial_struct`, in 32-bit words.
const FLAGS: usize = 4;
/// ASYNC_LOW_LATENCY: received bytes are delivered at once instead of in batches.
const LOW_LATENCY: u32 = 1 << 13;
/// More words than `serial_struct` has on any architecture.
const WORDS: usize = 32;

/// Makes the kernel deliver received bytes at once; fails if the driver does not support it.
pub fn low_latency(line: BorrowedFd<'_>) -> io::Result<()> {
    // The structure holds a pointer, which requires its alignment.
    #[repr(C, align(16))]
    struct SerialStruct([u32; WORDS]);
    let mut state = SerialStruct([0; WORDS]);
    let pointer = &raw mut state;
    // SAFETY: `state` lives through the call and is larger than the structure that the kernel writes.
    if unsafe { libc::ioctl(line.as_raw_fd(), libc::TIOCGSERIAL as _, pointer) } != 0 {
        return Err(io::Error::last_os_error());
    }
    state.0[FLAGS] |= LOW_LATENCY;
    let pointer = &raw const state;
    // SAFETY: `state` is what the kernel has written except for one flag; the kernel only reads it.
    match unsafe { libc::ioctl(line.as_raw_fd(), libc::TIOCSSERIAL as _, pointer) } {
        0 => Ok(()),
        _ => Err(io::Error::last_os_error()),
    }
}

/// Makes the hardware switch the RS-485 driver on by RTS while it sends; fails if the driver does not support it.
pub fn drive_rs485(line: BorrowedFd<'_>) -> io::Result<()> {
    /// SER_RS485_ENABLED.
    const ENABLED: u32 = 1;
    /// SER_RS485_RTS_ON_SEND.
    const RTS_ON_SEND: u32 = 1 << 1;
    /// TIOCSRS485.
    const SET: libc::c_ulong = 0x542F;
    let settings: [u32; 8] = [ENABLED | RTS_ON_SEND, 0, 0, 0, 0, 0, 0, 0];
    let pointer = &raw const settings;
    // SAFETY: `settings` has the size of `serial_rs485` and lives through the call.
    match unsafe { libc::ioctl(line.as_raw_fd(), SET as _, pointer) } {
        0 => Ok(()),
        _ => Err(io::Error::last_os_error()),
    }
}

/// Clears RTS; fails on a line without RTS.
pub fn clear_rts(line: BorrowedFd<'_>) -> io::Result<()> {
    let lines: libc::c_int = libc::TIOCM_RTS;
    let pointer = &raw const lines;
    // SAFETY: `lines` is the int that the kernel reads and lives through the call.
    match unsafe { libc::ioctl(line.as_raw_fd(), libc::TIOCMBIC as _, pointer) } {
        0 => Ok(()),
        _ => Err(io::Error::last_os_error()),
    }
}
