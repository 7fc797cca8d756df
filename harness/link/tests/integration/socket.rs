//! Frames over a stream, against a peer that the test plays byte by byte.

use crate::common::{A_WHILE, LONG, frame, next, silent};
use encspec_link::{Clock, FrameSocket, LinkError, Port, SocketAddress};
use rstest::rstest;
use station::{Duration, Time};
use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::os::unix::net::{UnixListener, UnixStream};
use std::sync::mpsc::channel;
use std::{fs, thread};
use testing::Folder;
use testing::stall::retry_on_stall;

const PEER: [u8; 6] = [0x02, 0, 0, 0, 0, 0x55];

/// The format of QEMU: the length in four bytes, big-endian, then the frame.
fn packed(frame: &[u8]) -> Vec<u8> {
    let mut octets = vec![0, 0, (frame.len() >> 8) as u8, frame.len() as u8];
    octets.extend_from_slice(frame);
    octets
}

/// A socket that is connected to a peer in this test.
fn connected() -> (FrameSocket, TcpStream, Clock) {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a free port");
    let address = format!("127.0.0.1:{}", listener.local_addr().expect("it has an address").port());
    let socket = FrameSocket::open(&address.parse().expect("an address")).expect("the peer listens");
    let peer = listener.accept().expect("it was called").0;
    peer.set_nodelay(true).expect("TCP can");
    (socket, peer, Clock::start())
}

#[test]
fn frames_are_written_in_the_format_of_qemu() {
    retry_on_stall(|| {
        let (mut socket, mut peer, clock) = connected();
        for length in [14, 60, 1518] {
            let sent = frame(PEER, length);
            socket.send(&sent).expect("it is sent");
            let mut received = vec![0; 4 + length];
            peer.read_exact(&mut received).expect("it arrives");
            assert_eq!(received, packed(&sent));
            peer.write_all(&received).expect("the peer answers");
            assert_eq!(next(&mut socket, &clock).1, sent);
        }
        assert_eq!(socket.mac(), None);
        assert!(socket.describe().starts_with("the socket 127.0.0.1:"), "{}", socket.describe());
    });
}

#[test]
fn a_frame_may_arrive_in_any_pieces() {
    retry_on_stall(|| {
        let (mut socket, mut peer, clock) = connected();
        let stream: Vec<u8> =
            [20, 60, 0, 33].into_iter().flat_map(|length| packed(&frame(PEER, length)[..length])).collect();
        for cut in 0..=stream.len() {
            peer.write_all(&stream[..cut]).expect("the first piece");
            let mut lengths = Vec::new();
            while lengths.len() < [24, 88, 92, 129].iter().filter(|end| **end <= cut && **end != 92).count() {
                lengths.push(next(&mut socket, &clock).1.len());
            }
            let mut into = Vec::new();
            assert_eq!(socket.receive(&clock, Time::ZERO, &mut into), Ok(None), "no complete frame is left at {cut}");
            peer.write_all(&stream[cut..]).expect("the second piece");
            while lengths.len() < 3 {
                lengths.push(next(&mut socket, &clock).1.len());
            }
            assert_eq!(lengths, [20, 60, 33], "an empty frame is skipped; cut at {cut}");
        }
        assert!(silent(&mut socket, &clock));
    });
}

#[test]
fn a_frame_arrives_when_it_is_complete() {
    retry_on_stall(|| {
        let (mut socket, mut peer, clock) = connected();
        let octets = packed(&frame(PEER, 60));
        peer.write_all(&octets[..30]).expect("the first piece");
        assert!(silent(&mut socket, &clock));
        let before = clock.now();
        peer.write_all(&octets[30..]).expect("the second piece");
        let (arrived, _) = next(&mut socket, &clock);
        assert!(arrived >= before && arrived <= clock.now());
    });
}

/// What a peer sends before it closes, and the reason in the error.
#[rstest]
#[case::nothing(&[], "it closed the connection")]
#[case::half_a_length(&[0, 0], "it closed the connection in the middle of a frame")]
#[case::half_a_frame(&[0, 0, 0, 60, 1, 2, 3], "it closed the connection in the middle of a frame")]
fn a_peer_that_closes_is_gone(#[case] last: &[u8], #[case] why: &str) {
    retry_on_stall(|| {
        let (mut socket, mut peer, clock) = connected();
        peer.write_all(&packed(&frame(PEER, 60))).expect("a last frame");
        peer.write_all(last).expect("a piece");
        drop(peer);
        assert_eq!(next(&mut socket, &clock).1, frame(PEER, 60), "frames received before are returned");
        let gone = socket.receive(&clock, clock.now() + LONG, &mut Vec::new()).expect_err("the peer has closed");
        let name = socket.describe();
        assert_eq!(gone, LinkError::Gone(format!("the peer at {name} is gone: {why}; start it again")));
        assert!(!socket.carrier());
        assert!(socket.send(&frame(PEER, 60)).is_err_and(|error| error.is_gone()));
        assert!(socket.receive(&clock, Time::ZERO, &mut Vec::new()).is_err_and(|error| error.is_gone()));
    });
}

/// The longest valid length, and two invalid ones.
#[rstest]
#[case::longest(69_632, true)]
#[case::one_more(69_633, false)]
#[case::absurd(u32::MAX, false)]
fn a_length_beyond_the_longest_frame_is_an_error(#[case] length: u32, #[case] valid: bool) {
    retry_on_stall(|| {
        let (mut socket, mut peer, clock) = connected();
        peer.write_all(&length.to_be_bytes()).expect("a length");
        let result = socket.receive(&clock, clock.now() + A_WHILE, &mut Vec::new());
        if valid {
            assert_eq!(result, Ok(None), "the rest of the frame is missing");
            let writer = thread::spawn(move || peer.write_all(&vec![7; length as usize]).map(|()| peer));
            assert_eq!(next(&mut socket, &clock).1, vec![7; length as usize]);
            writer.join().expect("the peer runs").expect("the peer writes");
        } else {
            let why = result.expect_err("the length is invalid").to_string();
            assert!(why.contains(&format!("it sent an invalid frame length, {length} bytes")), "{why}");
        }
    });
}

#[test]
fn a_slow_peer_loses_whole_frames_and_does_not_block_the_sender() {
    retry_on_stall(|| {
        let (mut socket, mut peer, clock) = connected();
        let sent = 20_000_u32;
        let begin = clock.now();
        for number in 0..sent {
            let mut numbered = frame(PEER, 1500);
            numbered[14..18].copy_from_slice(&number.to_be_bytes());
            socket.send(&numbered).expect("a slow peer is no error");
        }
        assert!(clock.now().since(begin) < LONG, "sending did not wait for the peer");
        assert!(socket.lost() > 0, "the test sends more than the queue holds");
        let (arrived, numbers) = channel();
        let reader = thread::spawn(move || {
            let mut octets = vec![0; 1504];
            while peer.read_exact(&mut octets).is_ok() {
                assert_eq!(octets[..4], [0, 0, 5, 0xDC], "frames stay complete");
                if arrived.send(u32::from_be_bytes([octets[18], octets[19], octets[20], octets[21]])).is_err() {
                    return;
                }
            }
        });
        // Queued frames are written as soon as the peer accepts them, also while nothing is sent.
        let expected = usize::try_from(u64::from(sent) - socket.lost()).expect("a small number");
        let mut received: Vec<u32> = Vec::new();
        while received.len() < expected && clock.now().since(begin) < 2 * LONG {
            let until = clock.now() + Duration::from_millis(5);
            assert_eq!(socket.receive(&clock, until, &mut Vec::new()), Ok(None));
            received.extend(numbers.try_iter());
        }
        drop(socket);
        reader.join().expect("the peer reads");
        received.extend(numbers.try_iter());
        assert!(received.is_sorted(), "in the order of sending");
        assert_eq!(received.len(), expected);
    });
}

#[rstest]
#[case::tcp("listen:127.0.0.1:0")]
#[case::unix("listen:unix:PATH")]
fn a_listening_socket_accepts_the_next_peer_after_one_has_closed(#[case] address: &str) {
    retry_on_stall(|| {
        let folder = Folder::new(&format!("listen-{}", address.len()));
        let path = folder.join("wire");
        let address: SocketAddress = address.replace("PATH", &path.display().to_string()).parse().expect("an address");
        let mut socket = FrameSocket::bind(&address).expect("the address is free");
        let clock = Clock::start();
        let mut into = Vec::new();
        assert!(
            socket.receive(&clock, Time::ZERO, &mut into).is_err_and(|error| error.is_gone()),
            "no peer has connected yet"
        );
        assert!(socket.recover(&clock, clock.now() + A_WHILE).is_err_and(|error| error.is_gone()));
        let there: SocketAddress =
            socket.address().to_string().trim_start_matches("listen:").parse().expect("an address");
        for round in 0..3 {
            let mut peer = FrameSocket::open(&there).expect("it listens");
            socket.recover(&clock, clock.now() + LONG).expect("a peer is here");
            assert!(socket.carrier());
            peer.send(&frame(PEER, 60 + round)).expect("it is sent");
            assert_eq!(next(&mut socket, &clock).1, frame(PEER, 60 + round));
            socket.send(&frame([0xFF; 6], 60)).expect("it is sent");
            assert_eq!(next(&mut peer, &clock).1, frame([0xFF; 6], 60));
            drop(peer);
            assert!(socket.receive(&clock, clock.now() + LONG, &mut into).is_err_and(|error| error.is_gone()));
        }
        drop(socket);
        assert!(!path.exists(), "the file is removed on drop");
    });
}

#[test]
fn a_connecting_socket_tries_again_until_the_peer_is_back() {
    retry_on_stall(|| {
        let folder = Folder::new("again");
        let path = folder.join("wire");
        let listener = UnixListener::bind(&path).expect("a free name");
        let address = SocketAddress::Unix(path.clone());
        let mut socket = FrameSocket::open(&address).expect("the peer listens");
        let clock = Clock::start();
        let (mut peer, _) = listener.accept().expect("it was called");
        peer.write_all(&packed(&frame(PEER, 60))[..10]).expect("a piece that must be discarded");
        drop((listener, peer));
        fs::remove_file(&path).expect("the name is there");
        assert!(socket.receive(&clock, clock.now() + LONG, &mut Vec::new()).is_err_and(|error| error.is_gone()));
        assert!(
            socket.recover(&clock, clock.now() + A_WHILE).is_err_and(|error| error.is_gone()),
            "the peer is not back"
        );

        let returns = thread::spawn(move || {
            let listener = UnixListener::bind(path)?;
            let (mut peer, _) = listener.accept()?;
            peer.write_all(&packed(&frame([0xFF; 6], 64)))?;
            Ok::<UnixStream, std::io::Error>(peer)
        });
        socket.recover(&clock, clock.now() + LONG).expect("it is back");
        assert_eq!(next(&mut socket, &clock).1, frame([0xFF; 6], 64));
        returns.join().expect("the peer runs").expect("the peer works");
    });
}

#[test]
fn the_error_of_an_unusable_socket_is_one_sentence() {
    retry_on_stall(|| {
        let folder = Folder::new("unusable");
        let path = folder.join("wire");
        let why = |address: &str| match FrameSocket::open(&address.parse().expect("an address")) {
            Err(LinkError::Unusable(why)) => why,
            other => panic!("{address}: {other:?}"),
        };
        let path_text = path.display();
        let no_peer = why(&path.display().to_string());
        assert!(no_peer.starts_with(&format!("cannot connect to the socket {path_text}: ")), "{no_peer}");
        assert!(no_peer.ends_with("; start the peer first, or wait for it with the prefix listen:"), "{no_peer}");

        fs::write(&path, "a report").expect("a file");
        let file = why(&format!("listen:{path_text}"));
        assert_eq!(
            file,
            format!("cannot listen at {path_text}: a file that is not a socket exists there; choose another name")
        );
        assert_eq!(fs::read_to_string(&path).expect("it is still there"), "a report");

        let listener = TcpListener::bind("127.0.0.1:0").expect("a free port");
        let port = listener.local_addr().expect("it has an address").port();
        let taken = why(&format!("listen:127.0.0.1:{port}"));
        assert!(taken.starts_with(&format!("cannot listen at 127.0.0.1:{port}: ")), "{taken}");
    });
}

#[test]
fn a_stale_socket_file_is_replaced_and_a_used_one_is_not() {
    retry_on_stall(|| {
        let folder = Folder::new("stale");
        let path = folder.join("wire");
        drop(UnixListener::bind(&path).expect("a free name"));
        assert!(path.exists(), "the file stays");
        let address = SocketAddress::ListenUnix(path.clone());
        let first = FrameSocket::bind(&address).expect("the file is replaced");
        let error = FrameSocket::bind(&address).expect_err("a process listens");
        let why = "another process listens there; choose another name";
        assert_eq!(error, LinkError::Unusable(format!("cannot listen at {}: {why}", path.display())));
        drop(first);
        FrameSocket::bind(&address).expect("it is free again");
    });
}
