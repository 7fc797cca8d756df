//! Stations that are not devices, damaged frames on the wire, and the damaged frames that the controller can send.
//!
//! None of them establishes an AR, and no received frame makes the controller panic.
#![allow(clippy::unwrap_used, reason = "a test that unwraps nothing has failed")]

use crate::common::*;
use core::time::Duration;
use encspec_controllers::profinet_io::*;
use rstest::rstest;
use station::{Outbox, Station, Time};
use wire::datagram::Datagram;
use wire::ethernet::FrameHeader;
use wire::profinet::rpc::RpcPdu;
use wire::profinet::status::AbortReason;

/// Returns every frame, modified by a function.
struct Mirror(fn(&[u8]) -> Vec<Vec<u8>>);

impl Station for Mirror {
    fn receive(&mut self, _now: Time, frame: &[u8], out: &mut Outbox) {
        (self.0)(frame).iter().for_each(|back| out.push(back));
    }
    fn wake(&mut self, _now: Time, _out: &mut Outbox) {}
    fn deadline(&self) -> Option<Time> {
        None
    }
}

fn swapped(frame: &[u8]) -> Vec<u8> {
    let mut back = frame.to_vec();
    back[..6].copy_from_slice(&frame[6..12]);
    back[6..12].copy_from_slice(&frame[..6]);
    back
}

/// The frame as though the device had sent it, also with the IPv4 addresses exchanged.
fn answered(frame: &[u8]) -> Vec<Vec<u8>> {
    let mut back = frame.to_vec();
    back[..6].copy_from_slice(&OWN.0);
    back[6..12].copy_from_slice(&DEVICE.0);
    let mut other = back.clone();
    if back[12..14] == [8, 0] {
        other[26..30].copy_from_slice(&back[30..34]);
        other[30..34].copy_from_slice(&back[26..30]);
        other[34..36].copy_from_slice(&back[36..38]);
        other[36..38].copy_from_slice(&back[34..36]);
    }
    vec![back, other]
}

#[rstest]
#[case::silent(|_: &[u8]| vec![])]
#[case::echo(|frame: &[u8]| vec![frame.to_vec()])]
#[case::reflector(|frame: &[u8]| vec![frame.to_vec(), swapped(frame)])]
#[case::in_the_name_of_the_device(answered)]
fn reflected_frames_establish_no_ar(#[case] mirror: fn(&[u8]) -> Vec<Vec<u8>>) {
    for device in [DeviceAddress::Name(NAME.into()), DeviceAddress::Mac(DEVICE)] {
        let mut rig = ControllerRig::with(Mirror(mirror));
        let connection = ArConfig { device, ..connection() };
        let ControllerOutcome::StartUp(result) = rig.ask(ControllerRequest::Connect(Box::new(connection))) else {
            panic!()
        };
        assert_eq!((result.standing, result.identify, result.connect), (false, None, None));
        let wait = Duration::from_millis(200);
        assert_eq!(
            rig.ask(ControllerRequest::Identify { by: IdentifyBy::All, wait }),
            ControllerOutcome::Stations(vec![])
        );
        let partner = Partner { mac: DEVICE, ip: DEVICE_IP };
        let ControllerOutcome::Endpoints(Err(CallError::NoAnswer(_))) =
            rig.ask(ControllerRequest::EndpointLookup { partner })
        else {
            panic!("a reflected call was accepted as an answer")
        };
        let ControllerOutcome::Dcp(DcpOutcome::NoAnswer(_)) = rig.ask(ControllerRequest::DcpSignal { to: DEVICE })
        else {
            panic!()
        };
    }
}

/// A device that answers until Connect and then only reflects: no ApplicationReady of its own, no data.
#[test]
fn reflected_cyclic_frames_are_not_frames_of_the_device() {
    let mut rig = ControllerRig::new();
    rig.device.cyclic = false;
    rig.controller.request(rig.now, ControllerRequest::Connect(Box::new(connection()))).unwrap();
    let mut reflected = 0;
    while rig.controller.take_outcome().is_none() {
        assert!(rig.step(rig.now + Duration::from_secs(20)));
        let cyclic = |(_, ours, frame): &&(Time, bool, Vec<u8>)| *ours && frame[12..14] == [0x81, 0];
        if rig.log.last().as_ref().is_some_and(cyclic) {
            let mut out = Outbox::new();
            out.push(&swapped(&rig.log.last().unwrap().2));
            rig.launch(false, &out);
            reflected += 1;
        }
    }
    assert!(reflected > 5);
    assert_eq!(rig.controller.state(), ArState::None);
}

/// An answer of the device is ignored when it has another source, another destination, or answers another request.
#[rstest]
#[case::control(0, |_: &mut Vec<u8>| {}, true)]
#[case::identify_of_another_transaction(0, |frame: &mut Vec<u8>| frame[21] ^= 1, false)]
#[case::identify_under_another_frame_id(0, |frame: &mut Vec<u8>| frame[15] = 0xFD, false)]
#[case::identify_as_a_request(0, |frame: &mut Vec<u8>| frame[17] = 0, false)]
#[case::set_of_another_transaction(1, |frame: &mut Vec<u8>| frame[21] ^= 1, false)]
#[case::set_as_get(1, |frame: &mut Vec<u8>| frame[16] = 3, false)]
#[case::set_from_another_station(1, |frame: &mut Vec<u8>| frame[11] ^= 1, false)]
#[case::arp_in_the_name_of_another(2, |frame: &mut Vec<u8>| frame[27] ^= 1, false)]
#[case::arp_about_another_address(2, |frame: &mut Vec<u8>| frame[31] ^= 1, false)]
#[case::arp_request(2, |frame: &mut Vec<u8>| frame[21] = 1, false)]
#[case::rpc_from_another_mac(3, |frame: &mut Vec<u8>| frame[11] ^= 1, false)]
#[case::rpc_from_another_address(3, |frame: &mut Vec<u8>| readdressed(frame, 26), false)]
#[case::rpc_to_another_address(3, |frame: &mut Vec<u8>| readdressed(frame, 30), false)]
fn an_answer_must_match_source_destination_and_request(
    #[case] at: usize,
    #[case] change: fn(&mut Vec<u8>),
    #[case] stands: bool,
) {
    let mut rig = ControllerRig::new();
    // The kind of answer: to Identify, to Set, to ARP, to Connect.
    let kinds: [fn(&[u8]) -> bool; 4] = [
        |frame| frame[14..16] == [0xFE, 0xFF],
        |frame| frame[14..16] == [0xFE, 0xFD],
        |frame| frame[12..14] == [0x08, 0x06],
        |frame| frame[12..14] == [0x08, 0x00] && frame[36..38] == 49_152u16.to_be_bytes(),
    ];
    rig.forge = Box::new(move |frame| {
        if kinds[at](frame) {
            change(frame);
        }
    });
    let result = rig.start(connection());
    assert_eq!(result.standing, stands);
    let waited = |why| matches!(why, ArFailureReason::Waited(_) | ArFailureReason::Call(CallError::NoAnswer(_)));
    assert!(result.failed.is_none_or(|failure| waited(failure.why)), "expected a timeout");
}

/// Adds one to the first byte of the IPv4 address at `at` and corrects the checksum of the header.
fn readdressed(frame: &mut [u8], at: usize) {
    frame[at] += 1;
    frame[24..26].fill(0);
    let words = frame[14..34].chunks(2).map(|word| u32::from(word[0]) << 8 | u32::from(word[1]));
    let sum: u32 = words.sum();
    let sum = (sum & 0xFFFF) + (sum >> 16);
    frame[24..26].copy_from_slice(&(!(sum as u16)).to_be_bytes());
}

/// A reflected call of the controller gets no answer, since that answer could be reflected too.
#[test]
fn a_reflected_call_is_not_served() {
    let mut rig = ControllerRig::standing();
    rig.device.hook = Box::new(|_| Reaction::Silence);
    rig.controller.request(rig.now, ControllerRequest::Read { target: PARAMETERS, length: 9 }).unwrap();
    let mut out = Outbox::new();
    rig.controller.wake(rig.now, &mut out);
    let request = out.frames().find(|frame| frame[12..14] == [8, 0]).unwrap();
    let [_, mut back] = answered(request).try_into().unwrap();
    // To the server port of the controller, from its client port.
    back[34..38].copy_from_slice(&request[34..38]);
    let mut answer = Outbox::new();
    rig.controller.receive(rig.now, &back, &mut answer);
    assert!(answer.is_empty());
}

/// Frames of random bytes, some with valid headers of frames that the controller processes.
struct RandomFrameStation {
    random: u64,
    next: Time,
}

impl RandomFrameStation {
    fn octet(&mut self) -> u8 {
        self.random = self.random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.random >> 56) as u8
    }
}

impl Station for RandomFrameStation {
    fn receive(&mut self, _now: Time, _frame: &[u8], _out: &mut Outbox) {}
    fn wake(&mut self, now: Time, out: &mut Outbox) {
        if now < self.next {
            return;
        }
        self.next = now + Duration::from_micros(500);
        let heads: [&[u8]; 8] = [
            &[0x88, 0x92, 0xC0, 0x01],
            &[0x88, 0x92, 0xFE, 0xFF, 5, 1],
            &[0x88, 0x92, 0xFE, 0xFD, 4, 1],
            &[0x88, 0x92, 0xFE, 0x01, 0, 1, 2, 5, 0x11],
            &[0x88, 0x92, 0xFE, 0xFE, 5, 0],
            &[0x08, 0x06, 0, 1, 8, 0, 6, 4, 0, 2],
            &[0x08, 0x00, 0x45],
            &[],
        ];
        let head = heads[usize::from(self.octet() % 8)];
        let mut frame = [OWN.0, DEVICE.0].concat();
        frame.extend_from_slice(head);
        let length = usize::from(self.octet()) + 48;
        frame.extend((0..length).map(|_| self.octet()));
        out.push(&frame);
    }
    fn deadline(&self) -> Option<Time> {
        Some(self.next)
    }
}

#[test]
fn random_frames_establish_no_ar() {
    for seed in 0..20 {
        let mut rig = ControllerRig::with(RandomFrameStation { random: seed, next: Time::ZERO });
        let connection = ArConfig { device: DeviceAddress::Mac(DEVICE), ..connection() };
        let ControllerOutcome::StartUp(result) = rig.ask(ControllerRequest::Connect(Box::new(connection))) else {
            panic!()
        };
        assert!(!result.standing && result.connect.is_none(), "{result:?}");
    }
}

/// An established AR receives every frame that the device ever sent, cut at every length and with each byte damaged, and
/// continues or ends.
#[test]
fn damaged_frames_never_panic() {
    let mut rig = ControllerRig::standing();
    rig.ask(ControllerRequest::Read { target: PARAMETERS, length: 10 });
    let frames: Vec<Vec<u8>> = rig.log.iter().filter(|(_, ours, _)| !ours).map(|(.., frame)| frame.clone()).collect();
    let mut kinds_sent = std::collections::BTreeSet::new();
    let kinds = frames.into_iter().filter(|frame| kinds_sent.insert((frame.len(), frame[12..16].to_vec())));
    for frame in kinds {
        let mut trials: Vec<Vec<u8>> = (0..=frame.len()).map(|length| frame[..length].to_vec()).collect();
        for at in 0..frame.len() {
            for damage in [0x01, 0x80, 0xFF] {
                let mut damaged = frame.clone();
                damaged[at] ^= damage;
                trials.push(damaged);
            }
        }
        for trial in &trials {
            rig.controller.receive(rig.now, trial, &mut Outbox::new());
        }
        // The same during a start-up and a call, where answers are awaited.
        let mut starting = ControllerRig::new();
        starting.controller.request(starting.now, ControllerRequest::Connect(Box::new(connection()))).unwrap();
        for trial in &trials {
            starting.step(starting.now + Duration::from_secs(1));
            starting.controller.receive(starting.now, trial, &mut Outbox::new());
        }
    }
    assert!(kinds_sent.len() > 6, "{kinds_sent:?}");
}

#[rstest]
fn each_broken_frame_can_be_made_and_leaves_the_ar_alone(#[values(0, 1)] round: usize) {
    for (broken, word, sentence) in DamagedIoFrame::TABLE {
        assert_eq!(DamagedIoFrame::by_word(word), Some(*broken));
        assert!(sentence.ends_with('.'));
        // Round 0: no AR, only a silent partner. Round 1: an established AR.
        let partner = Some(Partner { mac: DEVICE, ip: DEVICE_IP });
        let ask = ControllerRequest::Broken { broken: *broken, partner };
        if round == 0 {
            let mut rig = ControllerRig::with(Mirror(|_| vec![]));
            let of_ar = word.starts_with("cyclic") || *broken == DamagedIoFrame::RecordLength;
            match rig.ask(ask) {
                ControllerOutcome::Impossible(_) => assert!(of_ar, "{word}"),
                ControllerOutcome::Broken(_) => assert!(!of_ar, "{word}"),
                other => panic!("{other:?}"),
            }
            continue;
        }
        let mut rig = ControllerRig::standing();
        let mut out = Outbox::new();
        rig.controller.request(rig.now, ask).unwrap();
        rig.controller.wake(rig.now, &mut out);
        let Some(ControllerOutcome::Broken(frame)) = rig.controller.take_outcome() else { panic!("{word}") };
        assert!(out.frames().any(|sent| sent == frame), "{word}");
        // The scripted device does not survive the frame; the AR itself continues.
        rig.run(Duration::from_secs(1));
        assert_eq!(rig.controller.state(), ArState::Data, "{word}");
    }
    assert_eq!(broken_frames().count(), DamagedIoFrame::TABLE.len());
}

/// Each frame has the damage that its sentence describes.
#[test]
fn damaged_frames_have_the_damage_of_their_sentence() {
    let mut rig = ControllerRig::standing();
    let mut make = |broken| {
        rig.controller.request(rig.now, ControllerRequest::Broken { broken, partner: None }).unwrap();
        rig.controller.wake(rig.now, &mut Outbox::new());
        match rig.controller.take_outcome() {
            Some(ControllerOutcome::Broken(frame)) => frame,
            other => panic!("{other:?}"),
        }
    };
    assert_eq!(make(DamagedIoFrame::CyclicShort).len(), 14 + 4 + 2 + 20);
    assert_eq!(make(DamagedIoFrame::CyclicInvalid)[18 + 2 + 40 + 2], 0x31);
    assert_eq!(make(DamagedIoFrame::CyclicFrameId)[18..20], [0xC0, 0x40]);
    assert_eq!(make(DamagedIoFrame::Runt).len(), 15);
    assert!(RpcPdu::parse(Datagram::parse(&make(DamagedIoFrame::RpcVersion)).unwrap().payload).is_err());
    assert!(RpcPdu::parse(Datagram::parse(&make(DamagedIoFrame::RpcLength)).unwrap().payload).is_err());
    assert!(!Datagram::parse(&make(DamagedIoFrame::UdpChecksum)).unwrap().checksum_ok());
    assert!(Datagram::parse(&make(DamagedIoFrame::RpcFragment)).unwrap().checksum_ok());
    for broken in [DamagedIoFrame::DcpLength, DamagedIoFrame::DcpBlockLength] {
        let frame = make(broken);
        assert!(wire::profinet::dcp::Dcp::parse(FrameHeader::parse(&frame).unwrap().1).is_err(), "{broken}");
    }
    let mut out = Outbox::new();
    rig.controller.request(rig.now, ControllerRequest::Abort { code: AbortReason::ABORT_REQUEST }).unwrap();
    rig.controller.wake(rig.now, &mut out);
}

#[test]
fn the_controller_answers_arp_and_identify_and_announces_itself() {
    use wire::datagram::arp::{Arp, ArpOperation};
    use wire::ethernet::Mac;
    use wire::profinet::dcp::{Dcp, DcpValue};
    let mut controller = Controller::new(settings());
    let mut ask = |frame: &dyn Fn(&mut Vec<u8>)| -> Vec<Vec<u8>> {
        let (mut octets, mut out) = (Vec::new(), Outbox::new());
        frame(&mut octets);
        controller.receive(Time::ZERO, &octets, &mut out);
        out.frames().map(<[u8]>::to_vec).collect()
    };
    let [reply] = ask(&|octets| Arp::request(DEVICE, DEVICE_IP, OWN_IP).write_frame(octets)).try_into().unwrap();
    let reply = Arp::parse(&reply[14..]).unwrap();
    assert_eq!((reply.operation, reply.sender_mac, reply.sender_ip), (ArpOperation::REPLY, OWN, OWN_IP));
    assert!(ask(&|octets| Arp::request(DEVICE, DEVICE_IP, DEVICE_IP).write_frame(octets)).is_empty());
    for (name, count) in [(&b"controller"[..], 1), (b"other", 0)] {
        let filters = || vec![DcpValue::NameOfStation(name.to_vec())];
        let request = Dcp::identify(77, 1, filters());
        let answers = ask(&|octets| request.write_frame(Mac::DCP_MULTICAST, DEVICE, octets));
        assert_eq!(answers.len(), count);
        let stations = answers.iter().map(|answer| IdentifiedStation::of(OWN, &Dcp::parse(&answer[14..]).unwrap()));
        assert!(stations.into_iter().all(|station| station.role == Some(2) && station.ip.address == OWN_IP));
    }
    let mut rig = ControllerRig::new();
    assert_eq!(
        rig.ask(ControllerRequest::Lldp { chassis: vec![], port: b"port-001".to_vec() }),
        ControllerOutcome::Sent
    );
    assert_eq!(rig.ask(ControllerRequest::Raw(vec![1; 60])), ControllerOutcome::Sent);
}
