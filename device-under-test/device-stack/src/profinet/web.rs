//! The web server: TCP connections with one request and one response each.
//!
//! This module must not know the content of pages.

use alloc::vec;
use alloc::vec::Vec;
use smoltcp::iface::{SocketHandle, SocketSet};
use smoltcp::socket::tcp::{Socket, SocketBuffer, State};
use smoltcp::time::Duration;
use wire::http::{HttpRequest, HttpResponse, PORT, ParseProgress};

/// The function that answers requests.
pub(super) type PageHandler<'a> = &'a mut dyn FnMut(&HttpRequest) -> HttpResponse;

/// The connections of the web server.
pub(super) struct HttpServer {
    connections: Vec<HttpConnection>,
}

struct HttpConnection {
    socket: SocketHandle,
    /// The received part of the request.
    request: Vec<u8>,
    /// The part of the response that is still to be sent; `None` before there is a response.
    answer: Option<Vec<u8>>,
}

impl HttpServer {
    const CONNECTIONS: usize = 4;
    const LONGEST_REQUEST: usize = 4096;

    /// A server that does not listen yet.
    pub(super) fn new(sockets: &mut SocketSet<'static>) -> HttpServer {
        HttpServer { connections: (0..HttpServer::CONNECTIONS).map(|_| HttpConnection::new(sockets)).collect() }
    }

    /// Drops all connections, because their address is no longer in use.
    pub(super) fn forget(&mut self, sockets: &mut SocketSet<'static>) {
        self.connections.iter_mut().for_each(|connection| connection.reset(sockets));
    }

    /// Answers received requests. Returns whether there is something to send.
    ///
    /// While the server is not open, it finishes running requests and accepts no new ones.
    pub(super) fn serve(&mut self, sockets: &mut SocketSet<'static>, is_open: bool, pages: PageHandler<'_>) -> bool {
        let mut has_sent = false;
        for connection in &mut self.connections {
            has_sent |= connection.process(sockets, pages);
        }
        if is_open {
            self.listen(sockets);
        } else {
            self.connections.iter().for_each(|connection| connection.stop_listening(sockets));
        }
        has_sent
    }

    /// Makes free connections listen. If none is free, a connection in TIME-WAIT is reused.
    fn listen(&mut self, sockets: &mut SocketSet<'static>) {
        let is = |of: &HttpConnection, sockets: &SocketSet<'_>, state| of.state(sockets) == state;
        let waits = self.connections.iter().any(|of| is(of, sockets, State::Listen) || is(of, sockets, State::Closed));
        if !waits && let Some(old) = self.connections.iter_mut().find(|of| is(of, sockets, State::TimeWait)) {
            old.reset(sockets);
        }
        for connection in &mut self.connections {
            if connection.state(sockets) == State::Closed {
                connection.request.clear();
                connection.answer = None;
                let listens = sockets.get_mut::<Socket<'_>>(connection.socket).listen(PORT);
                debug_assert!(listens.is_ok(), "the socket is closed, and the port is not 0");
            }
        }
    }
}

impl HttpConnection {
    const BUFFER: usize = 2048;
    /// How long a client may be silent before the server drops its connection.
    const PATIENCE: Duration = Duration::from_secs(10);

    fn new(sockets: &mut SocketSet<'static>) -> HttpConnection {
        HttpConnection { socket: sockets.add(HttpConnection::socket()), request: Vec::new(), answer: None }
    }

    fn socket() -> Socket<'static> {
        let buffer = || SocketBuffer::new(vec![0; HttpConnection::BUFFER]);
        let mut socket = Socket::new(buffer(), buffer());
        socket.set_ack_delay(None);
        socket.set_nagle_enabled(false);
        socket.set_timeout(Some(HttpConnection::PATIENCE));
        socket.set_keep_alive(Some(HttpConnection::PATIENCE / 2));
        socket
    }

    fn reset(&mut self, sockets: &mut SocketSet<'static>) {
        sockets.remove(self.socket);
        *self = HttpConnection::new(sockets);
    }

    fn state(&self, sockets: &SocketSet<'_>) -> State {
        sockets.get::<Socket<'_>>(self.socket).state()
    }

    fn stop_listening(&self, sockets: &mut SocketSet<'_>) {
        let socket = sockets.get_mut::<Socket<'_>>(self.socket);
        if socket.state() == State::Listen {
            socket.close();
        }
    }

    /// Processes received data and sends as much as the buffer takes. Returns whether something was sent.
    fn process(&mut self, sockets: &mut SocketSet<'_>, pages: PageHandler<'_>) -> bool {
        let socket = sockets.get_mut::<Socket<'_>>(self.socket);
        if self.answer.is_none() {
            while socket.can_recv() {
                let request = &mut self.request;
                let taken = socket.recv(|octets| {
                    request.extend_from_slice(octets);
                    (octets.len(), ())
                });
                if taken.is_err() {
                    break;
                }
            }
            self.answer = match HttpRequest::read(&self.request) {
                ParseProgress::Whole(request) => Some(pages(&request).to_vec()),
                ParseProgress::More if self.request.len() <= HttpServer::LONGEST_REQUEST => None,
                ParseProgress::More | ParseProgress::Bad(_) => Some(HttpResponse::page(400, "").to_vec()),
            };
        }
        let Some(answer) = self.answer.as_mut().filter(|_| socket.may_send()) else {
            // A client that leaves without a request gets no response.
            let is_left = socket.state() == State::CloseWait;
            if is_left {
                socket.close();
            }
            return is_left;
        };
        let sent = socket.send_slice(answer).unwrap_or(answer.len());
        answer.drain(..sent);
        if answer.is_empty() {
            socket.close();
        }
        answer.is_empty() || sent > 0
    }
}
