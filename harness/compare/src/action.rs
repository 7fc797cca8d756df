//! The actions of a controller, in the words of the suite language.
//!
//! A script is a list of them; this module must not know where they come from, nor what they result in.

use std::time::Duration;

/// An action of a controller.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum ControllerAction {
    /// Establishes a connection.
    Connect(ConnectAction),
    /// Ends the connection.
    Disconnect,
    /// Sets outputs and other names to these values.
    Set(Vec<(String, String)>),
    /// A request that reads values.
    Read(Vec<String>),
    /// A request that writes values.
    Write(Vec<(String, String)>),
    /// A service of `send` with its fields, as in the suite language: `record_read`, `{ slot: 1, .. }`.
    Send {
        /// The name of the service.
        service: String,
        /// Its fields in braces.
        fields: String,
        /// Whether the service has an answer.
        answered: bool,
    },
    /// Turns the shaft by a number of hardware steps.
    Turn {
        /// Steps, clockwise positive.
        counts: i128,
        /// The speed in revolutions per minute.
        rpm: u32,
    },
    /// Waits.
    Wait(Duration),
}

/// A connection to be established.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub struct ConnectAction {
    /// The name of the module.
    pub module: String,
    /// `cycle` and `watchdog` if they differ from the usual ones, and start parameters that differ from their defaults.
    pub settings: Vec<(String, String)>,
    /// Deviations from the correct start-up.
    pub instead: Vec<(String, String)>,
}

impl ConnectAction {
    /// The mapping of the suite language, in braces.
    pub fn yaml(&self) -> String {
        let mut entries = vec![format!("module: {}", self.module)];
        entries.extend(self.settings.iter().map(|(name, value)| format!("{name}: {value}")));
        if !self.instead.is_empty() {
            entries.push(format!("instead: {}", mapping(&self.instead)));
        }
        format!("{{ {} }}", entries.join(", "))
    }
}

/// Names and values in braces.
pub fn mapping(entries: &[(String, String)]) -> String {
    let entries: Vec<String> = entries.iter().map(|(name, value)| format!("{name}: {value}")).collect();
    format!("{{ {} }}", entries.join(", "))
}

/// A duration in the suite language.
pub fn span(duration: Duration) -> String {
    let nanos = duration.as_nanos();
    match nanos {
        0 => "0".to_owned(),
        _ if nanos.is_multiple_of(1_000_000_000) => format!("{}s", nanos / 1_000_000_000),
        _ if nanos.is_multiple_of(1_000_000) => format!("{}ms", nanos / 1_000_000),
        _ if nanos.is_multiple_of(1_000) => format!("{}us", nanos / 1_000),
        _ => format!("{nanos}ns"),
    }
}

impl ControllerAction {
    /// The verb with its argument, without modifiers; reads accept any value.
    pub fn yaml(&self) -> String {
        match self {
            ControllerAction::Connect(connection) => format!("connect: {}", connection.yaml()),
            ControllerAction::Disconnect => "connect: none".to_owned(),
            ControllerAction::Set(entries) => format!("set: {}", mapping(entries)),
            ControllerAction::Read(names) => {
                let any: Vec<(String, String)> = names.iter().map(|name| (name.clone(), "any".to_owned())).collect();
                format!("read: {}", mapping(&any))
            }
            ControllerAction::Write(entries) => format!("write: {}", mapping(entries)),
            ControllerAction::Send { service, fields, .. } => format!("send: {{ {service}: {fields} }}"),
            ControllerAction::Turn { counts, rpm } => format!("turn: {{ counts: {counts}, rpm: {rpm} }}"),
            ControllerAction::Wait(duration) => format!("wait: {}", span(*duration)),
        }
    }

    /// Whether the device answers it, so that it can fail.
    pub fn is_answered(&self) -> bool {
        match self {
            ControllerAction::Connect(_) | ControllerAction::Read(_) | ControllerAction::Write(_) => true,
            ControllerAction::Send { answered, .. } => *answered,
            ControllerAction::Disconnect
            | ControllerAction::Set(_)
            | ControllerAction::Turn { .. }
            | ControllerAction::Wait(_) => false,
        }
    }
}
