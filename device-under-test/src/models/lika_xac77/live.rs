//! The firmware of the XAC77 at work: presets, errors, diagnoses and the cyclic exchange.

use super::parameters::{COMMISSIONING, MEMORY};
use super::{ACCESS_POINT_SUBSLOT, ENCODER_API, ENCODER_SLOT};
use crate::application::{ArKey, Diagnosis, DiagnosisChange, Severity, StationData};
use crate::bugs::Behaviour;
use crate::encoder::memory::Outcome;
use crate::encoder::{Cell, Direction, Hardware, Measuring, PresetMode, Shaft, Unit, Velocity};
use crate::profidrive::life_sign::Watch;
use crate::profidrive::sensor::{Request, Sensor, Xist2};
use crate::profidrive::telegram::{self, Emitter, Image, Telegram};
use crate::profidrive::user_parameters::UserParameters;
use alloc::collections::VecDeque;
use alloc::vec::Vec;
use core::time::Duration;
use station::Time;

/// How long it takes until an offset is safe in memory; a preset is acknowledged afterwards.
pub const OFFSET_WRITE: Duration = Duration::from_millis(40);
/// How long a save by P971 takes.
pub const SAVE: Duration = Duration::from_millis(200);
/// The velocity is calculated every 100 ms: manual, 10.1.
const VELOCITY_WINDOW: Duration = Duration::from_millis(100);
/// Error code of the sign of life.
const LIFE_SIGN: u16 = 0x0F02;
/// Channel of a diagnosis that concerns the submodule as a whole.
const WHOLE_SUBMODULE: u16 = 0x8000;

/// What keeps its contents without power.
pub struct Store {
    /// The offset of all presets, stored with each preset.
    pub offset: Cell<u64>,
    /// P65000, stored by P971.
    pub preset_value: Cell<u32>,
    /// Name and addresses, stored by DCP.
    pub station: Cell<StationData>,
}

/// The conditions that the stand can bring about.
#[derive(Clone, Copy, Default)]
pub struct Faults {
    /// The memory can neither be read nor written.
    pub memory: bool,
    /// The user parameters cannot be taken over.
    pub commissioning: bool,
}

/// Where the start-up of the connection with cyclic data stands.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Phase {
    /// There is no such connection.
    Alone,
    /// It sends its parameters.
    Parameters(ArKey),
    /// Data are exchanged.
    Data(ArKey),
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Save {
    Done,
    Running,
    Failed,
}

/// What is lost without power.
pub struct Ram {
    pub phase: Phase,
    pub telegram: &'static Telegram,
    pub user: UserParameters,
    /// The parameters that take effect at the end of the start-up.
    pub staged: UserParameters,
    /// Whether a record of user parameters was taken since power-up.
    pub was_parametrized: bool,
    /// Whether the memory could not be read at power-up.
    pub was_unreadable: bool,
    /// Whether the parameters in force ask for something impossible.
    pub wrong_parameters: bool,
    pub preset_value: u32,
    pub address: [u8; 4],
    pub measuring: Measuring,
    pub velocity: Velocity,
    pub sensor: Sensor,
    pub emitter: Emitter,
    pub outputs: Option<[u16; 2]>,
    pub watch: Watch,
    sign_of_life: u8,
    save: Save,
    /// The offset that takes effect when it is stored.
    next_offset: Option<u64>,
    diagnoses: Vec<u16>,
    pub changes: VecDeque<DiagnosisChange>,
}

impl Ram {
    /// Memory after power-up: what is stored is read, unless the memory is faulty.
    pub fn new(
        now: Time,
        hardware: Hardware,
        behaviour: &Behaviour,
        shaft: &Shaft,
        store: &Store,
        faults: Faults,
    ) -> Ram {
        let user = (behaviour.user_parameters.default)(&hardware);
        let mut measuring = Measuring::new(hardware, hardware.sense(shaft.place(now)), behaviour.measuring);
        measuring.settings = user.settings(&hardware, &behaviour.user_parameters);
        measuring.offset = if faults.memory { 0 } else { *store.offset.stored() };
        Ram {
            phase: Phase::Alone,
            telegram: &telegram::STANDARD[0],
            user,
            staged: user,
            was_parametrized: false,
            was_unreadable: faults.memory,
            wrong_parameters: false,
            preset_value: if faults.memory { 0 } else { *store.preset_value.stored() },
            address: store.station.stored().ip,
            measuring,
            velocity: Velocity::new(VELOCITY_WINDOW, now, shaft),
            sensor: Sensor::new(behaviour.sensor),
            emitter: Emitter::new(behaviour.telegram),
            outputs: None,
            watch: Watch::default(),
            sign_of_life: 0,
            save: Save::Done,
            next_offset: None,
            diagnoses: Vec::new(),
            changes: VecDeque::new(),
        }
    }

    /// Whether no save by P971 is running or has failed.
    pub fn saved(&self) -> bool {
        self.save == Save::Done
    }
}

/// The encoder at one instant, with power.
pub struct Live<'a> {
    pub now: Time,
    pub hardware: Hardware,
    pub behaviour: &'a Behaviour,
    pub shaft: &'a Shaft,
    pub faults: Faults,
    pub store: &'a mut Store,
    pub ram: &'a mut Ram,
}

impl Live<'_> {
    /// Looks at the sensor, ends what is done and raises errors.
    pub fn advance(&mut self) {
        self.ram.velocity.advance(self.now, self.shaft);
        self.ram.measuring.sample(self.hardware.sense(self.shaft.place(self.now)));
        if let Some(outcome) = self.store.offset.settle(self.now, self.faults.memory) {
            let carried_out = outcome == Outcome::Written || !self.behaviour.memory.heeds_failure;
            if let Some(offset) = self.ram.next_offset.take() {
                if carried_out {
                    self.ram.measuring.offset = offset;
                }
                self.ram.sensor.preset_done(carried_out);
            }
        }
        match self.store.preset_value.settle(self.now, self.faults.memory) {
            Some(Outcome::Written) if self.behaviour.memory.ends_save => self.ram.save = Save::Done,
            Some(Outcome::Written) => self.ram.save = Save::Running,
            Some(Outcome::Failed) => self.ram.save = Save::Failed,
            None => {}
        }
        self.look_for_errors();
    }

    /// Raises the errors whose cause is there, and brings the diagnoses in line with them.
    pub fn look_for_errors(&mut self) {
        self.ram.sensor.watch(&self.causes());
        self.diagnose();
    }

    /// The error codes whose cause is there now.
    pub fn causes(&self) -> Vec<u16> {
        let is_noticed = self.behaviour.memory.reports_unreadable || !self.ram.was_unreadable;
        let causes = [
            (self.ram.watch.has_failed(), LIFE_SIGN),
            (self.faults.memory && is_noticed, MEMORY.0),
            (self.faults.commissioning || self.ram.wrong_parameters, COMMISSIONING.0),
        ];
        causes.iter().filter(|(is_there, _)| *is_there).map(|(_, code)| *code).collect()
    }

    /// Brings the diagnoses in line with the errors. Error types: manual, 12.2.1.
    fn diagnose(&mut self) {
        let rules = &self.behaviour.diagnosis;
        let error_type = |code: &u16| match *code {
            code if code == MEMORY.0 => Some(0x9000),
            code if code == COMMISSIONING.0 => Some(0x9011),
            _ => None,
        };
        let mut wanted: Vec<u16> = self.ram.sensor.errors().iter().filter_map(error_type).collect();
        if !(rules.are_sent)(self.ram.user.compatible, self.ram.user.alarm_channel) {
            wanted.clear();
        }
        if !rules.side_by_side {
            wanted.drain(..wanted.len().saturating_sub(1));
        }
        let gone = |error_type: &u16| rules.disappear && !wanted.contains(error_type);
        let change = |error_type, appears| change(error_type, appears, rules.severity);
        let changes = &mut self.ram.changes;
        self.ram
            .diagnoses
            .iter()
            .filter(|known| gone(known))
            .for_each(|known| changes.push_back(change(*known, false)));
        self.ram.diagnoses.retain(|known| !gone(known));
        for new in wanted {
            if !self.ram.diagnoses.contains(&new) {
                self.ram.diagnoses.push(new);
                self.ram.changes.push_back(change(new, true));
            }
        }
    }

    /// Takes the user parameters that were staged into force.
    pub fn parametrize(&mut self) {
        let rules = &self.behaviour.user_parameters;
        let user = (rules.understand)(self.ram.staged);
        self.ram.user = user;
        self.ram.wrong_parameters = user.are_wrong(&self.hardware, rules);
        self.ram.measuring.settings = user.settings(&self.hardware, rules);
    }

    /// Gives P65000 a value.
    pub fn set_preset_value(&mut self, value: u32) {
        self.ram.preset_value = value;
        if self.behaviour.memory.stores_every_write {
            self.store.preset_value.replace(value);
        }
        if self.behaviour.values.preset_value_presets {
            self.ram.measuring.offset = self.ram.measuring.preset(PresetMode::Absolute, value.into());
        }
    }

    /// Begins to save P65000.
    pub fn save(&mut self) {
        self.store.preset_value.write(self.now, self.ram.preset_value, SAVE);
        self.ram.save = Save::Running;
    }

    /// Begins a preset: the offset is computed now and takes effect when it is stored.
    fn preset(&mut self, mode: PresetMode) {
        if !(self.behaviour.user_parameters.presets)(&self.ram.user) {
            self.ram.sensor.preset_done(true);
            return;
        }
        let rules = &self.behaviour.memory;
        let value = match rules.presets_stored_value {
            true => *self.store.preset_value.stored(),
            false => self.ram.preset_value,
        };
        let offset = self.ram.measuring.preset(mode, value.into());
        if rules.stores_offset {
            self.store.offset.write(self.now, offset, OFFSET_WRITE);
        }
        if rules.stores_offset && rules.waits_for_store {
            self.ram.next_offset = Some(offset);
        } else {
            self.ram.measuring.offset = offset;
            self.ram.sensor.preset_done(true);
        }
    }

    /// Takes the outputs of one frame.
    pub fn take(&mut self, outputs: Option<&[u8]>) {
        self.ram.outputs = outputs.and_then(|octets| self.ram.emitter.control_words(octets));
        let Some([stw2_enc, _]) = self.ram.outputs else { return };
        let (rules, user) = (&self.behaviour.life_sign, &self.ram.user);
        let watched = rules.watches_without_control || stw2_enc & CONTROL_BY_PLC != 0;
        if watched && !self.ram.sensor.is_parked() {
            let tolerated = match user.compatible {
                true => user.life_sign_failures,
                false => (rules.tolerated_without_compatibility)(user.life_sign_failures),
            };
            self.ram.watch.take((stw2_enc >> 12) as u8, (rules.tolerated)(tolerated), rules);
        } else {
            self.ram.watch = Watch::default();
        }
        self.look_for_errors();
    }

    /// Carries out one cycle and fills in the inputs of its frame.
    pub fn cycle(&mut self, inputs: &mut [u8]) -> bool {
        let [stw2_enc, g1_stw] = self.ram.outputs.unwrap_or_default();
        let by_plc = stw2_enc & CONTROL_BY_PLC != 0;
        let (control, compatible) = (&self.behaviour.control, self.ram.user.compatible);
        let valid = self.ram.outputs.is_some() && (control.is_valid)(compatible, by_plc);
        let request = if valid { Request::of(g1_stw) } else { Request::default() };
        if let Some(mode) = self.ram.sensor.cycle(request, self.shaft.is_moving(self.now)) {
            self.preset(mode);
        }
        self.look_for_errors();
        let (rules, sensor) = (&self.behaviour.life_sign, &self.ram.sensor);
        let counts = (rules.counts_while_parked || !sensor.is_parked())
            && (rules.counts_with_error || sensor.errors().is_empty());
        if counts {
            self.ram.sign_of_life = (rules.next)(self.ram.sign_of_life);
        }
        let zsw2_enc =
            u16::from(self.ram.sign_of_life) << 12 | u16::from((control.is_requested)(compatible, by_plc)) << 9;
        let image = Image { zsw2_enc, ..self.image() };
        self.ram.emitter.emit(self.ram.telegram, image, inputs)
    }

    /// The signals as they are, apart from ZSW2_ENC.
    fn image(&self) -> Image {
        let (ram, rules) = (&*self.ram, &self.behaviour.user_parameters);
        let shown = |with_offset| if with_offset { ram.measuring.shifted() } else { ram.measuring.position() };
        let position = shown((rules.presets_xist2)(&ram.user));
        let unit = (rules.unit)(ram.user.speed_unit).unwrap_or(Unit::PerSecond);
        let scaling = (rules.scales_velocity)(ram.measuring.settings.scaling, &self.hardware);
        let velocity = ram.velocity.value(unit, &self.hardware, &scaling);
        let is_measured = !ram.sensor.is_parked() || !self.behaviour.sensor.parking_stops_velocity;
        let status = Image {
            g1_zsw: ram.sensor.g1_zsw(),
            velocity: match ram.measuring.settings.direction {
                _ if !is_measured => 0,
                Direction::Clockwise => velocity,
                Direction::Counterclockwise => -velocity,
            },
            good: true,
            position,
            request: ram.sensor.request(),
            ..Image::default()
        };
        if ram.sensor.is_parked() {
            return status;
        }
        Image {
            g1_xist1: shown(ram.user.preset_acts_on_xist1) as u32,
            g1_xist2: match ram.sensor.xist2() {
                Xist2::Nothing => 0,
                Xist2::Position => position as u32,
                Xist2::Error(code) => code.into(),
            },
            g1_xist3: position,
            ..status
        }
    }
}

/// Bit 10 of STW2_ENC.
const CONTROL_BY_PLC: u16 = 0x0400;

fn change(error_type: u16, appears: bool, severity: Severity) -> DiagnosisChange {
    let diagnosis = Diagnosis {
        api: ENCODER_API,
        slot: ENCODER_SLOT,
        subslot: ACCESS_POINT_SUBSLOT,
        channel: WHOLE_SUBMODULE,
        error_type,
        extended: None,
        severity,
    };
    DiagnosisChange { appears, diagnosis }
}
