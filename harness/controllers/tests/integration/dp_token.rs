//! Medium access of the DP master: idle times, token holding time, and whose token it accepts.

use crate::dp::hex;
use core::time::Duration;
use encspec_controllers::profibus_dp::{MasterRequest, MasterSettings, ProfibusMaster};
use rstest::rstest;
use station::Time;
use virtual_wire::VirtualBus;
use wire::profibus::fdl::{BaudRate, BitTimes};
use wire::profibus::global_control::{GlobalCommand, GlobalControl};

// TID1 follows the token, TID2 the Global_Control, in bits.
#[rstest]
#[case(1_500_000, 37, 150)]
#[case(3_000_000, 46, 250)]
#[case(12_000_000, 76, 800)]
fn a_token_is_followed_by_tid1_and_a_request_without_answer_by_tid2(
    #[case] baud: u32,
    #[case] idle_1: u64,
    #[case] idle_2: u64,
) {
    let baud = BaudRate(baud);
    let mut master = ProfibusMaster::new(MasterSettings::new(2, baud));
    let control = GlobalControl { command: GlobalCommand::default(), groups: 0 };
    master.request(Time::ZERO, MasterRequest::GlobalControl { to: 127, control }).expect("nothing else is under way");
    let mut bus = VirtualBus::new(baud, master.settings().slot_time);
    let mut log = Vec::new();
    bus.run(&mut [&mut master], Time::ZERO + Duration::from_millis(3), &mut |frame| {
        log.push((frame.begin, frame.time, hex(frame.frame)));
    });
    let silence = |index: usize| baud.bits(log[index + 1].0.nanos_since(log[index].1) + 1);
    assert_eq!(log[0].2, "DC 02 02");
    assert_eq!(silence(0), BitTimes(idle_1));
    let at = log.iter().position(|(_, _, octets)| octets.starts_with("68")).expect("Global_Control is sent");
    assert_eq!(silence(at), BitTimes(idle_2));
    assert_eq!(bus.violations(), []);
}
