//! Answers HTTP requests with one text, as a monitoring system collects it: one request at a time, nothing is read but its first line.

use std::io::{self, Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::os::fd::AsFd;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};
use std::time::Instant;

use crate::Clock;
use crate::sys::{PollEvent, wait};
use station::Duration;

/// How long a client may take for its request, and for taking the answer.
const PATIENCE: Duration = Duration::from_secs(2);
/// The longest head of a request in bytes.
const LONGEST_HEAD: usize = 8_192;
/// How often the server checks whether it has to end, and for a client.
const LOOK_AGAIN: Duration = Duration::from_millis(50);

/// A server that answers `GET /metrics` on a thread of its own.
#[derive(Debug)]
pub struct TextServer {
    address: SocketAddr,
    ends: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl TextServer {
    /// Listens at `address`; `text` makes the answer.
    pub fn listen(address: SocketAddr, text: impl Fn() -> String + Send + 'static) -> io::Result<TextServer> {
        let listener = TcpListener::bind(address)?;
        listener.set_nonblocking(true)?;
        let address = listener.local_addr()?;
        let ends = Arc::new(AtomicBool::new(false));
        let end = Arc::clone(&ends);
        let serve = move || {
            while !end.load(Ordering::Relaxed) {
                match listener.accept() {
                    // A client that is slow or goes away is its own affair.
                    Ok((stream, _)) => drop(answer(stream, &text)),
                    Err(_) => {
                        let clock = Clock::start();
                        let until = clock.now() + LOOK_AGAIN;
                        // Without a client the wait ends by itself; after an error the next one is waited for.
                        let _ = wait(listener.as_fd(), PollEvent::Reading, &clock, until);
                    }
                }
            }
        };
        let thread = Some(thread::Builder::new().name("metrics".to_owned()).spawn(serve)?);
        Ok(TextServer { address, ends, thread })
    }

    /// The address, with the actual port if any free port was requested.
    pub fn address(&self) -> SocketAddr {
        self.address
    }
}

impl Drop for TextServer {
    fn drop(&mut self) {
        self.ends.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

fn answer(mut stream: TcpStream, text: &impl Fn() -> String) -> io::Result<()> {
    stream.set_nonblocking(false)?;
    stream.set_read_timeout(Some(PATIENCE))?;
    stream.set_write_timeout(Some(PATIENCE))?;
    let until = Instant::now() + PATIENCE;
    let (mut head, mut piece) = (Vec::new(), [0; 1_024]);
    while !head.windows(4).any(|end| end == b"\r\n\r\n") {
        let count = stream.read(&mut piece)?;
        if count == 0 || head.len() > LONGEST_HEAD || Instant::now() > until {
            return Ok(());
        }
        head.extend_from_slice(&piece[..count]);
    }
    let (status, body) = match head.split(|octet| *octet == b' ').nth(1) {
        Some(b"/" | b"/metrics") if head.starts_with(b"GET ") => ("200 OK", text()),
        _ => ("404 Not Found", "GET /metrics\n".to_owned()),
    };
    let length = body.len();
    write!(
        stream,
        "HTTP/1.1 {status}\r\nContent-Type: text/plain; version=0.0.4; charset=utf-8\r\nContent-Length: {length}\r\nConnection: close\r\n\r\n{body}"
    )
}
