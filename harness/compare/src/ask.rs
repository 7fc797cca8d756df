//! One thing that a controller does, in the words of the suite language.
//!
//! A script is a list of these; it must not know where they come from, nor what came of them.

use std::time::Duration;

/// One thing that a controller does.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Ask {
    /// Makes a connection.
    Connect(Connection),
    /// Ends the connection.
    Disconnect,
    /// Names hold these values from now on.
    Set(Vec<(String, String)>),
    /// One request for values.
    Read(Vec<String>),
    /// One request that changes values.
    Write(Vec<(String, String)>),
    /// A service of `send` with its fields, as the language has them: `record_read`, `{ slot: 1, .. }`.
    Send {
        /// Its word.
        service: String,
        /// Its fields in braces.
        fields: String,
        /// Whether anybody answers it.
        answered: bool,
    },
    /// The shaft turns so far, in hardware steps.
    Turn {
        /// Clockwise positive.
        counts: i128,
        /// How fast, in revolutions per minute.
        rpm: u32,
    },
    /// Time goes by.
    Wait(Duration),
}

/// A connection to be made.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Connection {
    /// The module by name.
    pub module: String,
    /// `cycle` and `watchdog` where they are not the usual ones, and the start parameters that are not at their default.
    pub settings: Vec<(String, String)>,
    /// What is changed against the right start-up.
    pub instead: Vec<(String, String)>,
}

impl Connection {
    /// As the language writes it, in braces.
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

/// A duration as the language writes it.
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

impl Ask {
    /// The verb with what stands behind it, without modifiers; reads take whatever comes.
    pub fn yaml(&self) -> String {
        match self {
            Ask::Connect(connection) => format!("connect: {}", connection.yaml()),
            Ask::Disconnect => "connect: none".to_owned(),
            Ask::Set(entries) => format!("set: {}", mapping(entries)),
            Ask::Read(names) => {
                let any: Vec<(String, String)> = names.iter().map(|name| (name.clone(), "any".to_owned())).collect();
                format!("read: {}", mapping(&any))
            }
            Ask::Write(entries) => format!("write: {}", mapping(entries)),
            Ask::Send { service, fields, .. } => format!("send: {{ {service}: {fields} }}"),
            Ask::Turn { counts, rpm } => format!("turn: {{ counts: {counts}, rpm: {rpm} }}"),
            Ask::Wait(duration) => format!("wait: {}", span(*duration)),
        }
    }

    /// Whether the device answers it, so that it can fail.
    pub fn is_answered(&self) -> bool {
        match self {
            Ask::Connect(_) | Ask::Read(_) | Ask::Write(_) => true,
            Ask::Send { answered, .. } => *answered,
            Ask::Disconnect | Ask::Set(_) | Ask::Turn { .. } | Ask::Wait(_) => false,
        }
    }
}
