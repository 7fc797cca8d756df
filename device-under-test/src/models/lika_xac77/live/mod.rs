//! The firmware of the XAC77 at work: presets, errors, diagnoses and the cyclic exchange.

mod cyclic;
mod diagnosis;
mod memory;

use crate::application::{ArKey, DiagnosisChange, StationData};
use crate::behaviour::Behaviour;
use crate::encoder::{Cell, Hardware, Measuring, Shaft, Velocity};
use crate::models::lika_xac77::web;
use crate::profidrive::life_sign::Watch;
use crate::profidrive::sensor::Sensor;
use crate::profidrive::telegram::{self, Emitter, Telegram};
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

/// What keeps its contents without power.
pub struct Store {
    /// The offset of all presets, stored with each preset.
    pub offset: Cell<u64>,
    /// P65000, stored by P971.
    pub preset_value: Cell<u32>,
    /// Name and addresses, stored by DCP.
    pub station: Cell<StationData>,
}

impl Store {
    /// Whether neither an offset nor a preset value was ever written.
    pub fn is_empty(&self) -> bool {
        self.offset.writes() + self.preset_value.writes() == 0
    }
}

/// The conditions that the stand can bring about.
#[derive(Clone, Copy, Default)]
pub struct Faults {
    /// The memory can neither be read nor written.
    pub memory: bool,
    /// The user parameters cannot be taken over.
    pub commissioning: bool,
    /// The scanning unit gives no reading: the position stands still.
    pub sensor: bool,
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
    /// The address before the last assignment.
    pub address_before: [u8; 4],
    pub measuring: Measuring,
    pub velocity: Velocity,
    pub sensor: Sensor,
    pub emitter: Emitter,
    pub outputs: Option<[u16; 2]>,
    /// Until when a parameter request holds up the signals of the telegram.
    pub held_up_until: Time,
    pub watch: Watch,
    /// What the web server remembers.
    pub web: web::State,
    sign_of_life: u8,
    /// Whether a save by P971 is running or has failed.
    pub is_saving: bool,
    /// Saves since power-up.
    saves: u32,
    /// The offset that was in memory at power-up.
    pub offset_at_power_up: u64,
    /// Whether parking outlasts its request until there is another one.
    pub stays_parked: bool,
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
        let unit = user.velocity_unit(&behaviour.user_parameters);
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
            address_before: [0; 4],
            measuring,
            velocity: Velocity::new(VELOCITY_WINDOW, unit, hardware, now, shaft, behaviour.velocity),
            sensor: Sensor::new(behaviour.sensor),
            emitter: Emitter::new(behaviour.telegram),
            outputs: None,
            held_up_until: now,
            watch: Watch::default(),
            web: web::State::default(),
            sign_of_life: 0,
            is_saving: false,
            saves: 0,
            offset_at_power_up: *store.offset.stored(),
            stays_parked: false,
            next_offset: None,
            diagnoses: Vec::new(),
            changes: VecDeque::new(),
        }
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
        if !self.faults.sensor {
            self.ram.measuring.sample(self.hardware.sense(self.shaft.place(self.now)));
        }
        self.settle();
        self.look_for_errors();
    }

    /// Raises the errors whose cause is there, and brings the diagnoses in line with them.
    pub fn look_for_errors(&mut self) {
        self.ram.sensor.watch(&self.causes());
        self.diagnose();
    }

    /// Takes the user parameters that were staged into force.
    pub fn parametrize(&mut self) {
        let rules = &self.behaviour.user_parameters;
        let user = (rules.understand)(self.ram.staged);
        let before = core::mem::replace(&mut self.ram.user, user);
        self.ram.wrong_parameters = user.are_wrong(&self.hardware, self.ram.telegram, rules);
        self.ram.measuring.settings = (rules.measures_by)(before, user).settings(&self.hardware, rules);
        self.ram.velocity.unit = user.velocity_unit(rules);
    }
}
