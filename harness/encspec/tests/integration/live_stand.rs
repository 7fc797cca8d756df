//! The stand of a live bench: hooks and control channel. Neither blocks the wire.

use encspec::bench_file::{ShaftAbility, StandSpec};
use encspec::live::stand::LiveStand;
use link::lines::LineListener;
use rstest::rstest;
use station::{Stand, StandAction, StandRefusal, Time};
use std::time::{Duration, Instant};
use std::{fs, thread};
use testing::Folder;
use testing::stall::retry_on_stall;

fn hooked(folder: &Folder, hooks: &[(&str, &str)]) -> LiveStand {
    let hooks = hooks.iter().map(|(name, line)| ((*name).to_owned(), (*line).to_owned())).collect();
    LiveStand::new(&StandSpec { hooks, folder: folder.path().to_owned(), ..StandSpec::default() })
}

/// How long to wait for a hook or an answer.
const WAIT: Duration = Duration::from_secs(60);

/// Waits until `find` returns something, for [`WAIT`] at most. The clock of the wire does not advance meanwhile.
fn wait<T>(mut find: impl FnMut() -> Option<T>) -> T {
    let began = Instant::now();
    loop {
        if let Some(found) = find() {
            return found;
        }
        assert!(began.elapsed() < WAIT, "waited {WAIT:?}");
        thread::yield_now();
    }
}

fn done(stand: &mut LiveStand, action: &StandAction<'_>) -> Result<Time, StandRefusal> {
    stand.act(Time::ZERO, action)?;
    wait(|| stand.outcome(Time::ZERO))
}

#[rstest]
#[case(StandAction::Power(false), "power", "down")]
#[case(StandAction::Link(true), "link", "up")]
#[case(StandAction::ShaftSpeed(-60.5), "shaft.speed", "-60.5")]
#[case(StandAction::ShaftCounts(65536), "shaft.counts", "65536")]
#[case(StandAction::Fault("memory", true), "fault.memory", "present")]
#[case(StandAction::Button("preset", false), "button.preset", "released")]
#[case(StandAction::Switch("address", 12), "switch.address", "12")]
#[case(StandAction::RestoreFactoryState, "device", "as_delivered")]
#[case(StandAction::Skip(Duration::from_millis(1500)), "clock", "1.5")]
fn a_hook_gets_the_value(#[case] action: StandAction<'_>, #[case] name: &str, #[case] value: &str) {
    let folder = Folder::new(&format!("value-{name}"));
    let mut stand = hooked(&folder, &[(name, "touch 'got {value} $HOME'")]);
    assert_eq!(done(&mut stand, &action), Ok(Time::ZERO));
    assert!(folder.join(format!("got {value} $HOME")).exists(), "one argument, run in the folder, by no shell");
}

#[test]
fn a_turn_has_a_unit_and_a_speed() {
    let folder = Folder::new("turn");
    let mut stand = hooked(&folder, &[("turn", "touch by_{value}_{unit}_{rpm}")]);
    assert!(done(&mut stand, &StandAction::Turn { steps: -100.0, rpm: 60.0 }).is_ok());
    assert!(done(&mut stand, &StandAction::TurnRevolutions { revolutions: 2.5, rpm: 3000.0 }).is_ok());
    assert!(folder.join("by_-100_counts_60").exists() && folder.join("by_2.5_revolutions_3000").exists());
}

#[test]
fn a_ramp_has_an_acceleration() {
    let folder = Folder::new("ramp");
    let mut stand = hooked(&folder, &[("shaft.acceleration", "touch to_{value}_by_{acceleration}")]);
    assert_eq!(done(&mut stand, &StandAction::ShaftRamp { rpm: -60.0, acceleration: 7.5 }).err(), None);
    assert!(folder.join("to_-60_by_7.5").exists());
}

#[test]
fn a_slow_hook_does_not_block() {
    retry_on_stall(|| {
        let folder = Folder::new("slow");
        let mut stand = hooked(&folder, &[("power", "sleep 0.3 {value}"), ("renew", "sleep 0.3")]);
        let began = Instant::now();
        assert_eq!(stand.act(Time::ZERO, &StandAction::ReplaceDevice), Ok(Time::ZERO));
        assert_eq!(stand.outcome(Time::ZERO), None);
        assert!(began.elapsed() < Duration::from_millis(250), "act waited for the hook");
        let busy = stand.act(Time::ZERO, &StandAction::Power(true));
        assert!(matches!(busy, Err(StandRefusal::Broken(why)) if why.contains("still running")));
        assert_eq!(wait(|| stand.outcome(Time::from_nanos(5))), Ok(Time::from_nanos(5)));
        assert!(began.elapsed() >= Duration::from_millis(300));
    });
}

#[rstest]
#[case("ls /nonexistent-{value}", "the hook ls ended with exit status")]
#[case("./gone {value}", "the hook ./gone cannot be run: No such file")]
#[case("sh -c 'printf \"\\033[2Jbad\\n\" >&2; exit 3' {value}", "the hook sh ended with exit status: 3: \\u{1b}[2Jbad")]
fn a_failing_hook_breaks_the_bench(#[case] line: &str, #[case] why: &str) {
    let folder = Folder::new(&format!("fails-{}", line.len()));
    let mut stand = hooked(&folder, &[("power", line)]);
    match done(&mut stand, &StandAction::Power(true)) {
        Err(StandRefusal::Broken(said)) => assert!(said.starts_with(why), "{said}"),
        other => panic!("{other:?}"),
    }
}

#[test]
fn an_action_without_a_hook_is_refused() {
    let folder = Folder::new("no-hook");
    let mut stand = hooked(&folder, &[("power", "true {value}")]);
    let refused = stand.act(Time::ZERO, &StandAction::Fault("memory", true));
    assert!(matches!(refused, Err(StandRefusal::CannotDo(why)) if why.contains("fault.memory")));
    assert_eq!(stand.act(Time::ZERO, &StandAction::ShaftSpeed(0.0)), Ok(Time::ZERO), "the shaft is at rest anyway");
    assert_eq!(stand.led(Time::ZERO, "bus"), None);
}

#[test]
fn leds_and_counters_are_read_in_the_background() {
    let folder = Folder::new("readings");
    fs::write(folder.join("led"), "green\nmore\n").expect("a file");
    fs::write(folder.join("writes"), "7\n").expect("a file");
    let mut stand =
        hooked(&folder, &[("led.bus", "cat led"), ("counter.writes", "cat writes"), ("power", "true {value}")]);
    assert_eq!(stand.led(Time::ZERO, "bus"), None, "the first reading takes a moment");
    assert_eq!(wait(|| stand.led(Time::ZERO, "bus")), "green");
    assert_eq!(wait(|| stand.counter(Time::ZERO, "writes")), 7);
    fs::write(folder.join("led"), "red").expect("a file");
    fs::write(folder.join("writes"), "8\n").expect("a file");
    assert_eq!(wait(|| stand.counter(Time::ZERO, "writes")), 8, "each reading is returned once");
    assert_eq!(wait(|| stand.led(Time::ZERO, "bus").filter(|word| *word == "red")), "red");
    assert!(done(&mut stand, &StandAction::Power(true)).is_ok());
    assert_eq!(stand.led(Time::ZERO, "bus"), None, "a reading from before an action is discarded");
}

/// Answers received lines until the peer disconnects. Returns the lines.
fn serve(listener: LineListener, answers: &'static [(&'static str, &'static str)]) -> thread::JoinHandle<Vec<String>> {
    thread::spawn(move || {
        let mut connection = wait(|| listener.accept().expect("a connection"));
        let mut received = Vec::new();
        while let Ok(Some(line)) = connection.wait_line(WAIT) {
            let answer = answers.iter().find(|(ask, _)| *ask == line).map_or("cannot what", |(_, answer)| *answer);
            received.push(line);
            if connection.write_line(answer).is_err() {
                break;
            }
        }
        received
    })
}

fn controlled(folder: &Folder, offers: Option<&[&str]>) -> (StandSpec, LineListener) {
    let path = folder.join("control");
    let listener = LineListener::bind(&path).expect("it listens");
    let offers = offers.map(|names| names.iter().map(|name| (*name).to_owned()).collect());
    let shaft = ShaftAbility::default();
    (
        StandSpec { control: Some(path), offers, shaft, folder: folder.path().to_owned(), ..StandSpec::default() },
        listener,
    )
}

#[test]
fn the_control_channel_exchanges_lines() {
    retry_on_stall(|| {
        let folder = Folder::new("control");
        let (spec, listener) = controlled(&folder, None);
        let lines = serve(
            listener,
            &[
                ("abilities", "ok power turn led.bus"),
                ("power down", "ok"),
                ("turn counts 100 rpm 60", "ok done-in 250"),
                ("fault memory present", "broken the box \u{1b} smokes"),
                ("link up", "nonsense"),
            ],
        );
        let mut stand = LiveStand::new(&spec);
        let names = stand.offers().expect("it answers").expect("the bench has a channel");
        assert_eq!(names, ["power", "turn", "led.bus"]);
        assert_eq!(done(&mut stand, &StandAction::Power(false)), Ok(Time::ZERO));
        let turn = StandAction::Turn { steps: 100.0, rpm: 60.0 };
        assert_eq!(done(&mut stand, &turn), Ok(Time::from_nanos(250)));
        let broken = done(&mut stand, &StandAction::Fault("memory", true));
        assert!(matches!(broken, Err(StandRefusal::Broken(why)) if why == "the box \\u{1b} smokes"));
        assert!(
            matches!(done(&mut stand, &StandAction::ReplaceDevice), Err(StandRefusal::CannotDo(why)) if why == "what")
        );
        assert!(
            matches!(done(&mut stand, &StandAction::Link(true)), Err(StandRefusal::Broken(why)) if why.contains("nonsense"))
        );
        drop(stand);
        let received = lines.join().expect("no panic");
        assert_eq!(received[..3], ["abilities", "power down", "turn counts 100 rpm 60"]);
    });
}

#[test]
fn a_channel_without_a_listener_breaks_the_bench() {
    let folder = Folder::new("empty");
    let (spec, listener) = controlled(&folder, None);
    drop(listener);
    let mut stand = LiveStand::new(&spec);
    assert!(stand.offers().expect_err("no listener").contains("cannot connect to"));
    assert!(matches!(done(&mut stand, &StandAction::Power(true)), Err(StandRefusal::Broken(_))));
}

#[test]
fn a_channel_refuses_what_it_does_not_offer() {
    let folder = Folder::new("offers");
    let (spec, _listener) = controlled(&folder, Some(&["power"]));
    let mut stand = LiveStand::new(&spec);
    let refused = stand.act(Time::ZERO, &StandAction::ReplaceDevice);
    assert!(matches!(refused, Err(StandRefusal::CannotDo(why)) if why.contains("renew")));
}
