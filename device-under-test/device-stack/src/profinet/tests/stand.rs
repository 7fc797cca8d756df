//! Actions of the stand, and the state of the stack for LEDs.

use super::bench::*;
use crate::profinet::StackStatus;
use alloc::vec::Vec;
use station::{Duration, Stand, StandAction, StandRefusal};
use wire::profinet::blocks::connect::Connect;
use wire::profinet::dcp::Dcp;
use wire::profinet::status::PnioStatus;

fn status(bench: &mut StackBench) -> StackStatus {
    assert!(bench.device.led(bench.now, "led").is_some(), "LEDs can be read in every state");
    bench.device.application().status
}

const ALONE: StackStatus = StackStatus {
    has_supply: true,
    is_booting: false,
    is_linked: true,
    has_connection: false,
    exchanges_data: false,
    module_differs: false,
    is_signalling: false,
};

#[test]
fn an_led_gets_the_state_of_the_stack() {
    let mut bench = StackBench::new();
    assert_eq!(status(&mut bench), ALONE);
    bench.connect(&full_connect());
    bench.exchange(2);
    assert_eq!(status(&mut bench), StackStatus { has_connection: true, ..ALONE });
    bench.release();
    bench.start();
    let in_data = StackStatus { has_connection: true, exchanges_data: true, ..ALONE };
    assert_eq!(status(&mut bench), in_data);
    bench.device.link(bench.now, false);
    assert_eq!(status(&mut bench), StackStatus { is_linked: false, ..in_data });
    bench.run(Duration::from_secs(1));
    assert_eq!(status(&mut bench), StackStatus { is_linked: false, ..ALONE });
    bench.device.power(bench.now, false);
    assert_eq!(status(&mut bench), StackStatus { is_linked: false, ..StackStatus::default() });
    bench.device.power(bench.now, true);
    assert_eq!(status(&mut bench), StackStatus { has_supply: true, is_booting: true, ..StackStatus::default() });
    assert_eq!(bench.device.led(bench.now, "another"), None);
}

#[test]
fn an_led_gets_module_differences_and_dcp_signal() {
    let mut bench = StackBench::new();
    let mut modules = modules();
    modules[1].submodules[1].submodule_ident_number = 99;
    assert_eq!(bench.connect(&Connect::of(connect_blocks(&modules))).0, PnioStatus::OK);
    assert_eq!(status(&mut bench), StackStatus { has_connection: true, module_differs: true, ..ALONE });
    bench.release();
    bench.dcp(&Dcp::signal(3), DEVICE);
    assert_eq!(status(&mut bench), StackStatus { is_signalling: true, ..ALONE });
    assert_eq!(bench.device.led(bench.now, "led"), Some("flashing"));
    bench.run(Duration::from_secs(3));
    assert_eq!(status(&mut bench), ALONE);
}

#[test]
fn frame_is_called_once_for_all_submodules() {
    let mut bench = StackBench::new();
    bench.start();
    let before = bench.device.application().frames;
    bench.exchange(5);
    assert_eq!(bench.device.application().frames - before, 5);
}

#[test]
fn buttons_switches_and_temperature_reach_the_application() {
    let mut bench = StackBench::new();
    let actions = [StandAction::Button("preset", true), StandAction::Switch("x1", 8), StandAction::Temperature(85.0)];
    for action in &actions {
        assert_eq!(bench.device.act(bench.now, action), Ok(bench.now));
    }
    let expected: Vec<_> = actions.iter().map(|action| alloc::format!("{action:?}")).collect();
    assert_eq!(bench.device.application().actions, expected);
    let refused = bench.device.act(bench.now, &StandAction::Fault("memory", true));
    assert!(matches!(refused, Err(StandRefusal::CannotDo(_))));
}

#[test]
fn an_undervoltage_is_a_loss_of_power_and_ends_by_itself() {
    let mut bench = StackBench::new();
    bench.start();
    let feed = |bench: &mut StackBench, volts| bench.device.act(bench.now, &StandAction::SupplyVoltage(volts)).unwrap();
    feed(&mut bench, 8.9);
    assert_eq!(bench.device.application().log.last().unwrap(), "down");
    assert_eq!(status(&mut bench), StackStatus { is_linked: true, ..StackStatus::default() });
    bench.take();
    bench.exchange(20);
    assert!(StackBench::inputs(&bench.take()).is_empty());
    feed(&mut bench, 24.0);
    assert_eq!(bench.device.application().log.last().unwrap(), "up");
    assert!(status(&mut bench).is_booting);
    bench.run(Duration::from_secs(2));
    bench.start();
    bench.device.power(bench.now, false);
    feed(&mut bench, 5.0);
    bench.device.power(bench.now, true);
    assert!(!status(&mut bench).has_supply, "the supply is back, and too low");
    feed(&mut bench, 24.0);
    assert!(status(&mut bench).is_booting);
    let ups = bench.device.application().log.iter().filter(|line| *line == "up").count();
    assert_eq!(ups, 2);
}
