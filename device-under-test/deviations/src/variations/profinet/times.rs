//! When a PROFINET device answers and acts.

use crate::needs::Need;
use crate::seams::late::{FrameTopic, Jitter, LateFrames};
use crate::tables::Group;
use core::time::Duration;
use device_stack::profinet::IoIdentity;
use wire::profinet::dcp::ServiceId;
use wire::profinet::rpc::Opnum;

const fn ms(milliseconds: u64) -> Duration {
    Duration::from_millis(milliseconds)
}

/// The variations, by what they need.
pub static GROUPS: &[Group] = &[
    Group {
        needs: &[Need::Profinet],
        deviations: permitted! {
            // DCP
            "dcp-get-late" "A DCP Get is answered after 300 ms."
                "IEC 61158-6-10, DCP: a client waits 1 s for the answer to Get and Set"
                => |d| d.late.sent(|topic| (topic == FrameTopic::Dcp(ServiceId::GET)).then_some(ms(300)));
            "dcp-set-late" "A DCP Set is answered after 400 ms, for instance once the value is stored."
                "IEC 61158-6-10, DCP: a client waits 1 s for the answer to Get and Set"
                => |d| d.late.sent(|topic| (topic == FrameTopic::Dcp(ServiceId::SET)).then_some(ms(400)));
            "dcp-taken-late" "A DCP Get or Set is processed 150 ms after it has arrived."
                "IEC 61158-6-10, DCP: a client waits 1 s for the answer to Get and Set"
                => |d| d.late.received(|topic| {
                    let is_of_client = matches!(topic, FrameTopic::Dcp(ServiceId::GET | ServiceId::SET));
                    is_of_client.then_some(ms(150))
                });
            "dcp-jitters" "Each DCP Get and Set is answered after another time of up to 250 ms."
                "IEC 61158-6-10, DCP: a client waits 1 s for the answer to Get and Set"
                => |d| jitter(&mut d.late, 1, ms(250), |topic| matches!(topic, FrameTopic::Dcp(ServiceId::GET | ServiceId::SET)));
            "identify-late" "DCP Identify is answered 300 ms after the time of the ResponseDelayFactor."
                "IEC 61158-6-10, DCP Identify: a client waits 400 ms or longer, whatever the delay of the factor"
                => |d| d.late.sent(|topic| (topic == FrameTopic::Identify).then_some(ms(300)));
            "identify-jitters" "DCP Identify is answered after another time of up to 100 ms each."
                "IEC 61158-6-10, DCP Identify: the delay is a random number of steps of 10 ms"
                => |d| jitter(&mut d.late, 2, ms(100), |topic| topic == FrameTopic::Identify);

            // RPC
            "connect-late" "Connect is answered after 700 ms."
                "the standard and the manuals print no time for the answer to Connect; CLRPC repeats and pings"
                => |d| d.late.sent(|topic| (topic == FrameTopic::Response(Opnum::CONNECT)).then_some(ms(700)));
            "read-late" "A record read is answered after 250 ms."
                "the standard and the manuals are silent about the time of a record read; CLRPC repeats and pings"
                => |d| d.late.sent(|topic| is_read(topic).then_some(ms(250)));
            "write-late" "A record write is answered after 250 ms."
                "the standard and the manuals are silent about the time of a record write; CLRPC repeats and pings"
                => |d| d.late.sent(|topic| (topic == FrameTopic::Response(Opnum::WRITE)).then_some(ms(250)));
            "write-taken-late" "A record write is processed 120 ms after it has arrived."
                "the standard and the manuals are silent about the time of a record write; CLRPC repeats and pings"
                => |d| d.late.received(|topic| (topic == FrameTopic::Request(Opnum::WRITE)).then_some(ms(120)));
            "records-jitter" "Each record access is answered after another time of up to 80 ms."
                "the standard and the manuals are silent about the time of a record access; CLRPC repeats and pings"
                => |d| jitter(&mut d.late, 3, ms(80), |topic| is_read(topic) || topic == FrameTopic::Response(Opnum::WRITE));
            "parameter-end-late" "The end of the parameters is confirmed after 300 ms."
                "IEC 61158-6-10, Control: no time for the confirmation of PrmEnd is printed"
                => |d| d.late.sent(|topic| (topic == FrameTopic::Response(Opnum::CONTROL)).then_some(ms(300)));
            "release-late" "Release is confirmed after 300 ms, when the cyclic data have ended."
                "IEC 61158-6-10, Release: no time for the confirmation is printed"
                => |d| d.late.sent(|topic| (topic == FrameTopic::Response(Opnum::RELEASE)).then_some(ms(300)));
            "release-taken-late" "Release is processed 1 ms after it has arrived, and inputs are sent until then."
                "IEC 61158-6-10, Release: no time for the processing is printed"
                => |d| d.late.received(|topic| (topic == FrameTopic::Request(Opnum::RELEASE)).then_some(ms(1)));
            "application-ready-call-late" "ApplicationReady is sent 400 ms after the first good inputs."
                "IEC 61158-6-10, ApplicationReady: the controller waits for it during the remote application timeout of 300 s"
                => |d| d.late.sent(|topic| (topic == FrameTopic::Request(Opnum::CONTROL)).then_some(ms(400)));

            // Start
            "boots-fast" "The device answers 300 ms after power-up."
                "the manuals print no minimum time from power-up to the first frame"
                => |d| d.stack.identity(|identity| identity.boot_time = ms(300));
            "boots-slowly" "The device answers 8 s after power-up."
                "the manuals and the standard print no time from power-up to the first frame, except for fast start-up"
                => |d| d.stack.identity(boot_slowly);
            "arp-late" "An ARP request is answered after 80 ms."
                "RFC 826 prints no time for an answer"
                => |d| d.late.sent(|topic| (topic == FrameTopic::Arp).then_some(ms(80)));
        },
    },
    Group {
        needs: &[Need::Alarms],
        deviations: permitted! {
            "alarm-acknowledged-late" "An alarm PDU of the controller gets its transport acknowledgement after 60 ms."
                "IEC 61158-6-10, RTATimeoutFactor: the shortest timeout is 100 ms"
                => |d| d.late.sent(|topic| (topic == FrameTopic::AlarmAck).then_some(ms(60)));
            "alarm-late" "An alarm is sent 150 ms after its cause."
                "the standard and the manuals print no time from a fault to its alarm"
                => |d| d.late.sent(|topic| (topic == FrameTopic::AlarmData).then_some(ms(150)));
            "alarm-jitters" "Each alarm is sent after another time of up to 60 ms."
                "the standard and the manuals print no time from a fault to its alarm"
                => |d| jitter(&mut d.late, 4, ms(60), |topic| topic == FrameTopic::AlarmData);
        },
    },
];

fn is_read(topic: FrameTopic) -> bool {
    matches!(topic, FrameTopic::Response(Opnum::READ | Opnum::READ_IMPLICIT))
}

fn boot_slowly(identity: &mut IoIdentity) {
    identity.boot_time = ms(8_000);
}

/// Sends the frames of some topics after a time of less than `most` that differs each time.
fn jitter(late: &mut LateFrames, seed: u64, most: Duration, is_meant: fn(FrameTopic) -> bool) {
    let mut times = Jitter::new(seed);
    late.sent(move |topic| is_meant(topic).then(|| times.next(most)));
}
