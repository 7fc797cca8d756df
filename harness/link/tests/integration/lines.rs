//! Lines over a Unix socket, with server and client in one process.

use encspec_link::LinkError;
use encspec_link::lines::{LineClient, LineConnection, LineListener};
use station::Duration;
use std::io::{Read, Write};
use std::os::unix::fs::PermissionsExt;
use std::os::unix::net::UnixStream;
use std::{fs, thread};
use testing::Folder;
use testing::stall::retry_on_stall;

const LONG: Duration = Duration::from_secs(5);

fn accepted(listener: &LineListener) -> LineConnection {
    listener.accept().expect("the listener works").expect("a client has connected")
}

#[test]
fn a_line_is_answered_by_a_line() {
    retry_on_stall(|| {
        let folder = Folder::new("answer");
        let path = folder.join("line");
        let listener = LineListener::bind(&path).expect("a free name");
        assert!(listener.accept().expect("the listener works").is_none(), "accept does not block");
        let mut client = LineClient::connect(&path).expect("it listens");
        let mut connection = accepted(&listener);
        assert_eq!(connection.poll_line(), Ok(None), "poll_line does not block");
        let serving = thread::spawn(move || {
            for _ in 0..2 {
                let line = connection.wait_line(LONG).expect("the client is there").expect("a line comes");
                connection.write_line(&format!("received {line}\nand no second line")).expect("it is sent");
            }
            connection
        });
        assert_eq!(client.request("power down", LONG).expect("an answer"), "received power down and no second line");
        assert_eq!(client.request("größer", LONG).expect("an answer"), "received größer and no second line");
        let mut connection = serving.join().expect("it serves");
        drop(client);
        assert!(connection.poll_line().is_err_and(|error| error.is_gone()));
    });
}

#[test]
fn lines_arrive_in_any_pieces_and_several_at_once() {
    retry_on_stall(|| {
        let folder = Folder::new("pieces");
        let path = folder.join("line");
        let listener = LineListener::bind(&path).expect("a free name");
        let mut peer = UnixStream::connect(&path).expect("it listens");
        let mut connection = accepted(&listener);
        let mut line = || connection.poll_line().expect("the peer is there");
        peer.write_all(b"pow").expect("a piece");
        assert_eq!(line(), None);
        peer.write_all(b"er up\r\nled \xFF\n\nhal").expect("a piece");
        assert_eq!(line().as_deref(), Some("power up"));
        assert_eq!(line().as_deref(), Some("led \u{FFFD}"));
        assert_eq!(line().as_deref(), Some(""));
        assert_eq!(line(), None);
        drop(peer);
        assert!(connection.poll_line().is_err_and(|error| error.is_gone()), "half a line is not a line");
    });
}

#[test]
fn an_endless_line_and_a_peer_that_accepts_no_data_end_the_connection() {
    retry_on_stall(|| {
        let folder = Folder::new("flood");
        let path = folder.join("line");
        let listener = LineListener::bind(&path).expect("a free name");
        let mut peer = UnixStream::connect(&path).expect("it listens");
        let mut connection = accepted(&listener);
        let flood = thread::spawn(move || {
            // Writing fails once the other side has closed.
            let _ = peer.write_all(&vec![b'x'; 1 << 20]);
            peer
        });
        let mut result = connection.wait_line(LONG);
        assert!(result.is_err_and(|error| error.to_string().contains("a line is longer than 64 KiB")));
        drop(connection);
        flood.join().expect("the peer runs");

        let mut peer = UnixStream::connect(&path).expect("it listens");
        let mut connection = accepted(&listener);
        // The peer also sends meanwhile; the writer must not spin because of it.
        peer.write_all(b"help\n").expect("a line");
        loop {
            result = connection.write_line(&"y".repeat(4096)).map(|()| None);
            if let Err(error) = result {
                assert!(error.is_gone() && error.to_string().contains("accepts no more data"), "{error}");
                break;
            }
        }
        let mut taken = vec![0; 4096];
        peer.read_exact(&mut taken).expect("the written data arrives");
    });
}

#[test]
fn a_late_answer_is_never_taken_for_that_to_the_next_line() {
    retry_on_stall(|| {
        let folder = Folder::new("late");
        let path = folder.join("line");
        let listener = LineListener::bind(&path).expect("a free name");
        let mut client = LineClient::connect(&path).expect("it listens");
        let mut first = accepted(&listener);
        let error = client.request("led power", Duration::from_millis(30)).expect_err("no answer");
        assert_eq!(error, LinkError::Gone(format!("{} did not answer `led power` within 30 ms", path.display())));
        assert_eq!(first.poll_line().expect("it was sent").as_deref(), Some("led power"));
        let _ = first.write_line("too late");
        let asking = thread::spawn(move || client.request("counter nvm", LONG));
        let mut second = loop {
            if let Some(connection) = listener.accept().expect("the listener works") {
                break connection;
            }
            thread::yield_now();
        };
        assert_eq!(second.wait_line(LONG).expect("it is there").as_deref(), Some("counter nvm"));
        second.write_line("ok 7").expect("it is sent");
        assert_eq!(asking.join().expect("the client runs").expect("an answer"), "ok 7");
    });
}

#[test]
fn only_this_user_may_connect_and_only_one_process_listens() {
    retry_on_stall(|| {
        let folder = Folder::new("rights");
        let path = folder.join("line");
        let listener = LineListener::bind(&path).expect("a free name");
        let mode = fs::metadata(&path).expect("it is there").permissions().mode();
        assert_eq!(mode & 0o777, 0o600);
        let error = LineListener::bind(&path).expect_err("a process listens");
        assert!(error.to_string().contains("another process listens there"), "{error}");
        assert_eq!(listener.path(), path);
        drop(listener);
        assert!(!path.exists(), "the file is removed on drop");
        let error = LineClient::connect(&path).expect_err("no process listens");
        assert!(matches!(&error, LinkError::Unusable(why) if why.starts_with("cannot connect to ")), "{error}");
    });
}
