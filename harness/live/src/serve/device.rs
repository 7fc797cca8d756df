//! A served device: a reference device that can be replaced, with its stand behind the control channel.

use crate::control::{StandAnswer, StandCommand, ability};
use deviations::ReferenceDevice;
use engine::exchangeable_device::ExchangeableDevice;
use station::{Duration, Outbox, Stand, StandAction, StandRefusal, Station, Time};

/// The state in which a device is made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InitialDeviceState {
    /// With the name and the address that it is served with.
    Named,
    /// Factory state: without them.
    FactoryState,
}

/// Makes a reference device, the same one each time.
pub type DeviceMaker = Box<dyn Fn(InitialDeviceState) -> Box<dyn ReferenceDevice>>;

/// The names that a manual declares for its stand.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct DeclaredStandNames {
    /// Faults.
    pub faults: Vec<String>,
    /// Buttons.
    pub buttons: Vec<String>,
    /// Coding switches, each with one valid position.
    pub switches: Vec<(String, u32)>,
    /// LEDs.
    pub leds: Vec<String>,
    /// Counters.
    pub counters: Vec<String>,
}

/// A reference device on a live wire. The clock of a replaced device starts at zero, as on a virtual wire.
pub struct ServedDevice {
    make: DeviceMaker,
    device: ExchangeableDevice,
    due: Option<Time>,
    abilities: Vec<String>,
}

impl ServedDevice {
    /// A device made by `make`; its abilities list those `names` that its stand supports.
    pub fn new(make: DeviceMaker, names: &DeclaredStandNames) -> ServedDevice {
        let abilities = abilities(&mut *make(InitialDeviceState::Named), names);
        let device = ExchangeableDevice::new(make(InitialDeviceState::Named));
        let due = device.deadline();
        ServedDevice { make, device, due, abilities }
    }

    /// The abilities of its stand, as suites name them.
    pub fn abilities(&self) -> &[String] {
        &self.abilities
    }

    /// Executes a line of the control channel at `now`.
    pub fn answer(&mut self, now: Time, line: &str) -> StandAnswer {
        match StandCommand::parse(line) {
            Ok(StandCommand::Act(action)) => match self.act(now, &action) {
                Ok(done) => StandAnswer::Done(done.since(now)),
                Err(StandRefusal::CannotDo(why)) => StandAnswer::Cannot(why + &self.others_like(&ability(&action))),
                Err(refusal) => refusal.into(),
            },
            Ok(StandCommand::Led(name)) => match self.led(now, name) {
                Some(word) => StandAnswer::Word(word.into()),
                None => StandAnswer::Cannot(format!("there is no LED {name}")),
            },
            Ok(StandCommand::Counter(name)) => match self.counter(now, name) {
                Some(count) => StandAnswer::Word(count.to_string()),
                None => StandAnswer::Cannot(format!("there is no counter {name}")),
            },
            Ok(StandCommand::Abilities) => StandAnswer::Word(self.abilities.join(" ")),
            Ok(StandCommand::Help) => StandAnswer::help(),
            Err(why) => StandAnswer::Cannot(why),
        }
    }

    /// The abilities of the same kind as an unsupported one, as the end of a sentence.
    fn others_like(&self, lacking: &str) -> String {
        let Some((kind, _)) = lacking.split_once('.') else { return String::new() };
        let is_like = |name: &&str| name.split_once('.').is_some_and(|(of, _)| of == kind);
        let known: Vec<&str> = self.abilities.iter().map(String::as_str).filter(is_like).collect();
        if known.is_empty() { String::new() } else { format!("; there are {}", known.join(", ")) }
    }

    fn note_deadline(&mut self) {
        self.due = self.device.deadline();
    }
}

impl Station for ServedDevice {
    fn receive(&mut self, now: Time, frame: &[u8], out: &mut Outbox) {
        self.device.receive(now, frame, out);
        self.note_deadline();
    }

    fn wake(&mut self, now: Time, out: &mut Outbox) {
        self.device.wake(now, out);
        self.note_deadline();
    }

    fn deadline(&self) -> Option<Time> {
        self.due
    }
}

impl Stand for ServedDevice {
    fn act(&mut self, now: Time, action: &StandAction<'_>) -> Result<Time, StandRefusal> {
        let done = match action {
            StandAction::ReplaceDevice => {
                self.device.exchange(now, (self.make)(InitialDeviceState::Named));
                Ok(now)
            }
            StandAction::RestoreFactoryState => {
                self.device.exchange(now, (self.make)(InitialDeviceState::FactoryState));
                Ok(now)
            }
            action => self.device.act(now, action),
        };
        self.note_deadline();
        done
    }

    fn led(&mut self, now: Time, name: &str) -> Option<&'static str> {
        self.device.led(now, name)
    }

    fn counter(&mut self, now: Time, name: &str) -> Option<u64> {
        self.device.counter(now, name)
    }
}

/// The abilities of the stand of `device`: tries each action once.
fn abilities(device: &mut dyn ReferenceDevice, names: &DeclaredStandNames) -> Vec<String> {
    let now = Time::ZERO;
    let mut actions = vec![
        StandAction::Link(true),
        StandAction::ShaftSpeed(0.0),
        StandAction::ShaftRamp { rpm: 0.0, acceleration: 1.0 },
        StandAction::ShaftCounts(0),
        StandAction::Turn { steps: 1.0, rpm: 1.0 },
        StandAction::SupplyVoltage(24.0),
        StandAction::Temperature(25.0),
        StandAction::Skip(Duration::ZERO),
    ];
    actions.extend(names.faults.iter().map(|name| StandAction::Fault(name, false)));
    actions.extend(names.buttons.iter().map(|name| StandAction::Button(name, false)));
    actions.extend(names.switches.iter().map(|(name, position)| StandAction::Switch(name, *position)));
    actions.push(StandAction::Power(true));
    let mut can: Vec<String> = actions.iter().filter(|action| device.act(now, action).is_ok()).map(ability).collect();
    can.extend([StandAction::ReplaceDevice, StandAction::RestoreFactoryState].iter().map(ability));
    can.extend(names.leds.iter().filter(|name| device.led(now, name).is_some()).map(|name| format!("led.{name}")));
    let counters = names.counters.iter().filter(|name| device.counter(now, name).is_some());
    can.extend(counters.map(|name| format!("counter.{name}")));
    can.sort();
    can
}

#[cfg(test)]
mod tests {
    use super::*;
    use deviations::{Setup, build};
    use rstest::rstest;

    fn served() -> ServedDevice {
        let make = |made| {
            let setup = Setup {
                shaft: 5,
                station_name: if made == InitialDeviceState::Named { "encoder-under-test" } else { "" },
                ..Setup::default()
            };
            build("lika-xac77-profinet", "xac7718", &setup).expect("a reference device")
        };
        let names = DeclaredStandNames {
            faults: vec!["memory".into(), "light".into()],
            buttons: vec!["preset".into()],
            leds: vec!["bf".into()],
            counters: vec!["nvm_writes".into(), "laughs".into()],
            ..DeclaredStandNames::default()
        };
        ServedDevice::new(Box::new(make), &names)
    }

    const NOON: Time = Time::from_nanos(43_200_000_000_000);

    #[rstest]
    #[case("power down", "ok")]
    #[case("shaft counts 1000", "ok")]
    #[case("turn revolutions 1 rpm 60", "ok done-in 1000000000")]
    #[case("fault memory present", "ok")]
    #[case("fault light present", "cannot the reference device does not support this action; there are fault.memory")]
    #[case("button preset pressed", "cannot the reference device does not support this action")]
    #[case("clock 60", "ok")]
    #[case("renew", "ok")]
    #[case("device as_delivered", "ok")]
    #[case("led bf", "cannot there is no LED bf")]
    #[case("counter nvm_writes", "ok 0")]
    #[case("counter laughs", "cannot there is no counter laughs")]
    #[case(
        "abilities",
        "ok clock counter.nvm_writes device fault.memory link power renew shaft.acceleration shaft.counts shaft.speed turn"
    )]
    #[case("dance", "cannot unknown command dance; send `help` for a list of commands")]
    fn each_line_is_answered(#[case] line: &str, #[case] answer: &str) {
        assert_eq!(served().answer(NOON, line).to_string(), answer);
    }

    #[test]
    fn a_renewed_device_lives_by_its_own_clock() {
        let mut device = served();
        device.answer(NOON, "renew");
        let mut out = Outbox::new();
        device.wake(NOON, &mut out);
        assert!(device.deadline().is_some_and(|due| due > NOON), "{:?}", device.deadline());
        device.answer(NOON, "power down");
        assert_eq!(device.deadline(), None);
        device.answer(NOON, "power up");
        assert_eq!(device.deadline(), Some(NOON + Duration::from_secs(2)), "it boots");
        device.answer(NOON, "clock 1.5");
        assert_eq!(device.deadline(), Some(NOON + Duration::from_millis(500)));
        device.answer(NOON, "renew");
        assert_eq!(device.deadline(), Some(NOON), "a replaced device has power");
    }
}
