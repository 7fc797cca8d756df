//! `set` and `turn`: outputs go to the controller, everything else goes to the stand.

use super::RunningTrial;
use super::step_error::{BoxedStepError, StepError, StepResult};
use crate::outputs::{self, OutputChange};
use controllers::outputs::CounterMode;
use controllers::profinet_io::AlarmAcknowledge;
use expression::{HistoryState, Value};
use judge::format;
use results::outcome::FailureCause;
use results::verdict::Verdict;
use station::{Duration, StandAction, StandRefusal, Time};
use suite::device::{NameKind, SignalForm, StandName};
use suite::model::{SetValue, Setting, Turn, TurnAngle};
use suite::words;

/// The longest time for one action of a stand.
const LONGEST_ACTION: Duration = Duration::from_secs(3600);
/// The time between two queries whether it is done.
const LOOK_AGAIN: Duration = Duration::from_millis(1);

impl<'a> RunningTrial<'a> {
    /// Does a `set`: it ends when the first frame with the new outputs has been sent and the stand is done.
    pub fn set(&mut self, settings: &'a [Setting]) -> StepResult {
        self.action();
        if self.apply_settings(settings)? && self.sends_outputs() { self.driver.wait_for_outputs(self) } else { Ok(()) }
    }

    fn sends_outputs(&self) -> bool {
        self.world.stations.exchanges(0) && !self.paused && self.world.scene.follower.image.stands()
    }

    /// Applies settings at once; returns whether outputs are among them.
    pub fn apply_settings(&mut self, settings: &'a [Setting]) -> Result<bool, BoxedStepError> {
        let goes_first = |run: &RunningTrial<'_>, setting: &Setting| {
            let kind = run.kind(setting.name);
            matches!(kind, Some(NameKind::OutputOctets(_) | NameKind::Stand(StandName::ShaftAcceleration)))
        };
        let (mut outputs, mut changes) = (false, Vec::new());
        for first in [true, false] {
            for setting in settings {
                if goes_first(self, setting) == first {
                    outputs |= self.apply_setting(setting, &mut changes)?;
                }
            }
        }
        // All outputs change at once, after the actions of the stand.
        if let Some(sent) = self.world.stations.outputs_mut() {
            changes.into_iter().for_each(|change| change.apply(sent));
        }
        Ok(outputs)
    }

    fn apply_setting(
        &mut self,
        setting: &'a Setting,
        changes: &mut Vec<OutputChange<'a>>,
    ) -> Result<bool, BoxedStepError> {
        let value = match &setting.value {
            SetValue::Value(program) => program.eval(&self.world.view(), &HistoryState::default()),
            SetValue::Bytes(octets) => Value::bytes(octets.as_slice()),
            SetValue::Word(word) => Value::text(word.as_str()),
        };
        let Some(kind) = self.kind(setting.name) else { return Ok(false) };
        let unknown = || StepError::other(FailureCause::Suite, Verdict::Error, "The value to be set is unknown.");
        match (kind, &value) {
            (NameKind::Signal { .. }, Value::Text(word)) => {
                let mode = if **word == *"held" { CounterMode::Held } else { CounterMode::Counting };
                changes.push(OutputChange::Counting(kind, mode));
                Ok(true)
            }
            (NameKind::Signal { .. }, value) => {
                changes.push(OutputChange::Number(
                    kind,
                    self.number_on_the_wire(kind, value).unwrap_or_else(|| Err(unknown()))?,
                ));
                Ok(true)
            }
            (NameKind::OutputOctets(_), Value::Bytes(octets)) => {
                changes.push(OutputChange::Octets(octets.to_vec()));
                Ok(true)
            }
            (NameKind::OutputStatus(submodule), value) => {
                let good = word_is(value, words::STATUS, "good");
                let submodules = &self.world.manual.device.submodules;
                let submodule = submodule.and_then(|index| submodules.get(index)).map(|of| (of.slot, of.subslot));
                if let Some(outputs) = self.world.stations.outputs_mut() {
                    outputs.status(submodule, good);
                }
                Ok(true)
            }
            (NameKind::OutputDataStatus, value) => {
                let status = value.as_whole().and_then(|status| u8::try_from(status).ok()).ok_or_else(unknown)?;
                if let Some(outputs) = self.world.stations.outputs_mut() {
                    outputs.data_status(status);
                }
                Ok(true)
            }
            (NameKind::Cyclic, value) => {
                self.paused = word_is(value, words::CYCLIC, "paused");
                self.may_end |= self.paused;
                self.pause(self.paused);
                Ok(false)
            }
            (NameKind::AlarmAcknowledge, value) => {
                let is = |word| word_is(value, words::ALARM_ACKNOWLEDGE, word);
                let acknowledge = if is("held") {
                    AlarmAcknowledge::Held
                } else if is("received") {
                    AlarmAcknowledge::Received
                } else {
                    AlarmAcknowledge::Given
                };
                // Without acknowledgements the device may end the connection.
                self.may_end |= acknowledge != AlarmAcknowledge::Given;
                if let Some(controller) = self.world.stations.controller_mut(0) {
                    controller.acknowledge_alarms(acknowledge);
                }
                Ok(false)
            }
            (NameKind::GlobalControl, value) => {
                self.clock(Some(word_is(value, words::CLOCK, "stopped")), None);
                Ok(false)
            }
            (NameKind::ClockOffset, Value::Time(nanos)) => {
                self.clock(None, Some(Duration::from_nanos(nanos.to_f64().max(0.0) as u64)));
                Ok(false)
            }
            (NameKind::Stand(name), value) => self.stand(*name, value).map(|()| false),
            _ => Err(unknown()),
        }
    }

    /// Stops or shifts the clock of isochronous mode.
    pub fn clock(&mut self, stopped: Option<bool>, offset: Option<Duration>) {
        let Some(master) = self.world.stations.master_mut(0) else { return };
        if let Some(stopped) = stopped {
            master.stop_clock(stopped);
        }
        if let Some(offset) = offset {
            master.shift_clock(offset);
        }
    }

    /// Selects the module in use, and places the outputs in its submodules.
    pub fn use_module(&mut self, module: usize) {
        self.module = Some(module);
        if let Some(sent) = self.world.stations.outputs_mut() {
            outputs::lay_out(&self.world.manual.device, module, sent);
        }
    }

    /// Pauses or resumes the cyclic frames of the harness's station.
    pub fn pause(&mut self, paused: bool) {
        if let Some(outputs) = self.world.stations.outputs_mut() {
            outputs.pause(paused);
        }
    }

    fn stand(&mut self, name: StandName, value: &Value) -> StepResult {
        let manual = self.world.manual;
        let names = &manual.device.stand;
        let number = || {
            let number = match value {
                Value::Number(number) => Some(number.to_f64()),
                value => value.as_whole().map(|number| number as f64),
            };
            number.ok_or_else(|| {
                StepError::other(FailureCause::Suite, Verdict::Error, "The value for the stand is unknown.")
            })
        };
        let action = match name {
            StandName::Power => StandAction::Power(word_is(value, words::UP_DOWN, "up")),
            StandName::Link => StandAction::Link(word_is(value, words::UP_DOWN, "up")),
            StandName::Delivery => {
                self.renamed = true;
                self.world.line_may_break = true;
                StandAction::RestoreFactoryState
            }
            StandName::ShaftAcceleration => {
                self.acceleration = number()?.abs();
                return Ok(());
            }
            StandName::ShaftSpeed if self.acceleration > 0.0 => {
                StandAction::ShaftRamp { rpm: number()?, acceleration: self.acceleration }
            }
            StandName::ShaftSpeed => StandAction::ShaftSpeed(number()?),
            StandName::ShaftCounts => StandAction::ShaftCounts(number()? as u64),
            StandName::SupplyVoltage => StandAction::SupplyVoltage(number()?),
            StandName::Temperature => StandAction::Temperature(number()?),
            StandName::Fault(index) => {
                StandAction::Fault(&names.faults[index].0, word_is(value, words::PRESENCE, "present"))
            }
            StandName::Button(index) => {
                StandAction::Button(&names.buttons[index].0, word_is(value, words::BUTTON, "pressed"))
            }
            StandName::Switch(index) => StandAction::Switch(&names.switches[index].name, number()? as u32),
        };
        self.may_end |= matches!(name, StandName::Power | StandName::Link | StandName::Delivery);
        if !self.stand_settings.contains(&name) {
            self.stand_settings.push(name);
        }
        let acted = self.act_on_stand(&action);
        // What the stand of another model cannot do is not undone at the end.
        if self.environment.is_other_model
            && acted.as_ref().is_err_and(|trouble| trouble.verdict == Some(Verdict::NotApplicable))
        {
            self.stand_settings.retain(|known| *known != name);
        }
        acted
    }

    /// The number on the wire that a value of an output is; `None` if it is not known.
    fn number_on_the_wire(&self, kind: &NameKind, value: &Value) -> Option<Result<i128, BoxedStepError>> {
        let NameKind::Signal { signal, field: None, .. } = kind else { return value.as_whole().map(Ok) };
        let signal = self.world.manual.device.signals.get(*signal)?;
        let raw = signal.form.raw(value, signal.width)?;
        let fits = match signal.form {
            SignalForm::Scaled { .. } if signal.signed => raw >> (signal.width - 1) == raw >> 127,
            SignalForm::Scaled { .. } => raw >> signal.width == 0,
            SignalForm::Whole | SignalForm::Float | SignalForm::Text => true,
        };
        Some(if fits {
            Ok(raw)
        } else {
            let (value, name, width) = (format::plain(value), &signal.name, signal.width);
            let why = format!("{value} does not fit into the {width} bits of `{name}`.");
            Err(StepError::other(FailureCause::Suite, Verdict::Error, why))
        })
    }

    /// Runs an action of the stand and waits until it is done.
    pub fn act_on_stand(&mut self, action: &StandAction<'_>) -> StepResult {
        let now = self.world.now();
        self.world.line_may_break |= matches!(action, StandAction::Power(false) | StandAction::Link(false));
        let begun = self.world.segment.stand().act(now, action);
        match begun.and_then(|done| self.wait_for_stand(done)) {
            Ok(()) => Ok(()),
            Err(StandRefusal::CannotDo(why)) => Err(StepError::other(
                FailureCause::Environment,
                // The preflight of a live bench has shown that the stand can do it, else the trial would not run.
                if self.environment.bench.is_some() { Verdict::Inconclusive } else { Verdict::NotApplicable },
                format!("The stand cannot do this: {why}."),
            )),
            Err(StandRefusal::Broken(why)) => Err(StepError::other(
                FailureCause::Environment,
                Verdict::Inconclusive,
                format!("The stand failed: {why}."),
            )),
        }
    }

    /// Waits for an action of the stand outside of the wire, then until the effect on the device is complete.
    fn wait_for_stand(&mut self, mut done: Time) -> Result<(), StandRefusal> {
        let latest = self.world.now() + LONGEST_ACTION;
        loop {
            let now = self.world.now();
            match self.world.segment.stand().outcome(now) {
                Some(then) => {
                    done = done.max(then?);
                    break;
                }
                None if self.world.segment.is_interrupted() => {
                    return Err(StandRefusal::Broken("the run was interrupted during the action".into()));
                }
                None if now >= latest => {
                    return Err(StandRefusal::Broken("the action did not end within an hour".into()));
                }
                None => {
                    self.world.run(now + LOOK_AGAIN, |_| false);
                }
            }
        }
        self.world.run(done.min(latest), |_| false);
        Ok(())
    }

    /// Turns the shaft and waits until it has arrived.
    pub fn turn_shaft(&mut self, turn: &'a Turn) -> StepResult {
        let view = self.world.view();
        let number = |program: &expression::Program| match program.eval(&view, &HistoryState::default()) {
            Value::Number(number) => Ok(number.to_f64()),
            _ => Err(StepError::other(FailureCause::Suite, Verdict::Error, "The distance to turn is unknown.")),
        };
        let rpm = number(&turn.rpm)?;
        let action = match &turn.way {
            TurnAngle::Revolutions(way) => StandAction::TurnRevolutions { revolutions: number(way)?, rpm },
            TurnAngle::Degrees(way) => StandAction::TurnRevolutions { revolutions: number(way)? / 360.0, rpm },
            TurnAngle::Counts(way) => StandAction::Turn { steps: number(way)?, rpm },
        };
        if !self.stand_settings.contains(&StandName::ShaftSpeed) {
            self.stand_settings.push(StandName::ShaftSpeed);
        }
        self.act_on_stand(&action)
    }

    /// Restores everything that the trial has set at the stand.
    pub fn restore_stand(&mut self) -> StepResult {
        let manual = self.world.manual;
        let names = &manual.device.stand;
        for name in std::mem::take(&mut self.stand_settings) {
            let action = match name {
                StandName::Power => StandAction::Power(true),
                StandName::Link => StandAction::Link(true),
                StandName::ShaftSpeed => StandAction::ShaftSpeed(0.0),
                StandName::Fault(index) => StandAction::Fault(&names.faults[index].0, false),
                StandName::Button(index) => StandAction::Button(&names.buttons[index].0, false),
                StandName::Switch(index) => {
                    StandAction::Switch(&names.switches[index].name, names.switches[index].home)
                }
                StandName::SupplyVoltage | StandName::Temperature => {
                    let home = |home: Option<f64>, action: fn(f64) -> StandAction<'static>| home.map(action);
                    let action = match name {
                        StandName::SupplyVoltage => home(names.voltage, StandAction::SupplyVoltage),
                        _ => home(names.temperature, StandAction::Temperature),
                    };
                    let Some(action) = action else { continue };
                    action
                }
                StandName::Delivery if self.world.manual.device.bus.switches_go_back() => {
                    for switch in &names.switches {
                        self.act_on_stand(&StandAction::Switch(&switch.name, switch.home))?;
                    }
                    continue;
                }
                StandName::ShaftCounts | StandName::ShaftAcceleration | StandName::Delivery => continue,
            };
            self.act_on_stand(&action)?;
        }
        Ok(())
    }
}

/// Whether a value is this word of a table; a value may be the text of a word or its number.
fn word_is(value: &Value, table: words::WordList, word: &str) -> bool {
    match value {
        Value::Text(text) => **text == *word,
        Value::Word(number) => words::word(table, *number) == Some(word),
        _ => false,
    }
}
