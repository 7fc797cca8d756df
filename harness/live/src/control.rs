//! The control channel of a stand: one line per command, one line per answer.
//!
//! Both sides use the same types: [`StandCommand`] for requests, [`StandAnswer`] for results. A command is done when its answer arrives,
//! except for movements of the shaft: `ok done-in` says how long they take. Words are separated by spaces; numbers are decimal; a
//! line has at most 1000 bytes, without the line feed. This module must not know sockets, nor how a device carries out a command.

use plain_text::nearest;
use station::{StandAction, StandRefusal};
use std::fmt;
use std::time::Duration;

/// Maximum length of a line in bytes, without the line feed.
pub const LONGEST_LINE: usize = 1_000;

/// Every command and its effect, as printed by `help`.
pub const FORMS: [(&str, &str); 19] = [
    ("power up|down", "connects or cuts the supply"),
    ("link up|down", "plugs or pulls the cable of the bus"),
    ("shaft speed RPM", "turns the shaft steadily, clockwise positive"),
    ("shaft speed RPM acceleration A", "the same, with an acceleration in rpm per second"),
    ("shaft counts N", "sets the shaft to a raw position, in hardware steps"),
    ("turn counts N rpm R", "turns the shaft by N hardware steps, clockwise positive"),
    ("turn revolutions X rpm R", "turns the shaft by X revolutions, clockwise positive"),
    ("fault NAME present|absent", "sets or clears a fault of the encoder"),
    ("button NAME pressed|released", "presses or releases a button"),
    ("switch NAME N", "turns a coding switch to a position"),
    ("voltage V", "sets the supply voltage, in volts"),
    ("temperature C", "sets the temperature of the device, in degrees Celsius"),
    ("renew", "replaces the device by one in factory state, with the same name and addresses"),
    ("device as_delivered", "resets the device to factory state: no addresses, nothing stored, the factory name"),
    ("clock SECONDS", "advances the time of the device at once"),
    ("led NAME", "reads an LED"),
    ("counter NAME", "reads a counter"),
    ("abilities", "lists the abilities of this stand"),
    ("help", "lists the commands"),
];

/// A command to a stand.
#[derive(Clone, Debug, PartialEq)]
pub enum StandCommand<'a> {
    /// Performs an action on the device. Answer: [`StandAnswer::Done`].
    Act(StandAction<'a>),
    /// Reads an LED. Answer: [`StandAnswer::Word`], a word of `device.yaml`.
    Led(&'a str),
    /// Reads a counter. Answer: [`StandAnswer::Word`], a number.
    Counter(&'a str),
    /// Lists the abilities of the stand. Answer: [`StandAnswer::Word`], names as in [`ability`], separated by spaces.
    Abilities,
    /// Lists the commands. Answer: [`StandAnswer::Word`], the forms, separated by semicolons.
    Help,
}

/// The result of a command.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum StandAnswer {
    /// Done once this time has elapsed: zero for a switch, more for a turning shaft.
    Done(Duration),
    /// The requested value; never empty.
    Word(String),
    /// The stand cannot do it, or the line is not a command; the sentence says why.
    Cannot(String),
    /// The stand can do it but failed; the sentence says why.
    Broken(String),
}

/// The ability that `action` needs, as suites name it: `power`, `shaft.speed`, `fault.x`.
pub fn ability(action: &StandAction<'_>) -> String {
    match action {
        StandAction::Power(_) => "power".into(),
        StandAction::Link(_) => "link".into(),
        StandAction::ShaftSpeed(_) => "shaft.speed".into(),
        StandAction::ShaftRamp { .. } => "shaft.acceleration".into(),
        StandAction::ShaftCounts(_) => "shaft.counts".into(),
        StandAction::Turn { .. } | StandAction::TurnRevolutions { .. } => "turn".into(),
        StandAction::Fault(name, _) => format!("fault.{name}"),
        StandAction::Button(name, _) => format!("button.{name}"),
        StandAction::Switch(name, _) => format!("switch.{name}"),
        StandAction::SupplyVoltage(_) => "supply.voltage".into(),
        StandAction::Temperature(_) => "supply.temperature".into(),
        StandAction::ReplaceDevice => "renew".into(),
        StandAction::RestoreFactoryState => "device".into(),
        StandAction::Skip(_) => "clock".into(),
    }
}

impl<'a> StandCommand<'a> {
    /// Parses a line, with or without its line feed; the error is the sentence for [`StandAnswer::Cannot`].
    pub fn parse(line: &'a str) -> Result<StandCommand<'a>, String> {
        if line.len() > LONGEST_LINE {
            return Err(format!("a line has at most {LONGEST_LINE} bytes, this one has {}", line.len()));
        }
        let words: Vec<&str> = line.split_whitespace().collect();
        let act = |action| Ok(StandCommand::Act(action));
        match *words {
            ["power", to] => act(StandAction::Power(either(to, "up", "down")?)),
            ["link", to] => act(StandAction::Link(either(to, "up", "down")?)),
            ["shaft", "speed", rpm] => act(StandAction::ShaftSpeed(number(rpm)?)),
            ["shaft", "speed", rpm, "acceleration", by] => {
                act(StandAction::ShaftRamp { rpm: number(rpm)?, acceleration: positive(by)? })
            }
            ["shaft", "counts", place] => act(StandAction::ShaftCounts(whole(place)?)),
            ["turn", "counts", steps, "rpm", rpm] => {
                act(StandAction::Turn { steps: number(steps)?, rpm: positive(rpm)? })
            }
            ["turn", "revolutions", revolutions, "rpm", rpm] => {
                act(StandAction::TurnRevolutions { revolutions: number(revolutions)?, rpm: positive(rpm)? })
            }
            ["fault", name, to] => act(StandAction::Fault(self::name(name)?, either(to, "present", "absent")?)),
            ["button", name, to] => act(StandAction::Button(self::name(name)?, either(to, "pressed", "released")?)),
            ["switch", name, position] => act(StandAction::Switch(self::name(name)?, whole(position)?)),
            ["voltage", volts] => act(StandAction::SupplyVoltage(number(volts)?)),
            ["temperature", degrees] => act(StandAction::Temperature(number(degrees)?)),
            ["renew"] => act(StandAction::ReplaceDevice),
            ["device", "as_delivered"] => act(StandAction::RestoreFactoryState),
            ["clock", time] => act(StandAction::Skip(seconds(time)?)),
            ["led", name] => Ok(StandCommand::Led(self::name(name)?)),
            ["counter", name] => Ok(StandCommand::Counter(self::name(name)?)),
            ["abilities"] => Ok(StandCommand::Abilities),
            ["help"] => Ok(StandCommand::Help),
            [] => Err("the line is empty; send `help` for a list of commands".into()),
            [first, ..] => Err(unknown(first)),
        }
    }
}

/// The line, without line feed.
impl fmt::Display for StandCommand<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            StandCommand::Act(action) => write_action(action, f),
            StandCommand::Led(name) => write!(f, "led {name}"),
            StandCommand::Counter(name) => write!(f, "counter {name}"),
            StandCommand::Abilities => f.write_str("abilities"),
            StandCommand::Help => f.write_str("help"),
        }
    }
}

fn write_action(action: &StandAction<'_>, f: &mut fmt::Formatter<'_>) -> fmt::Result {
    let word = |on: bool, yes: &'static str, no: &'static str| if on { yes } else { no };
    match *action {
        StandAction::Power(on) => write!(f, "power {}", word(on, "up", "down")),
        StandAction::Link(up) => write!(f, "link {}", word(up, "up", "down")),
        StandAction::ShaftSpeed(rpm) => write!(f, "shaft speed {rpm}"),
        StandAction::ShaftRamp { rpm, acceleration } => write!(f, "shaft speed {rpm} acceleration {acceleration}"),
        StandAction::ShaftCounts(place) => write!(f, "shaft counts {place}"),
        StandAction::Turn { steps, rpm } => write!(f, "turn counts {steps} rpm {rpm}"),
        StandAction::TurnRevolutions { revolutions, rpm } => write!(f, "turn revolutions {revolutions} rpm {rpm}"),
        StandAction::Fault(name, there) => write!(f, "fault {name} {}", word(there, "present", "absent")),
        StandAction::Button(name, down) => write!(f, "button {name} {}", word(down, "pressed", "released")),
        StandAction::Switch(name, position) => write!(f, "switch {name} {position}"),
        StandAction::SupplyVoltage(volts) => write!(f, "voltage {volts}"),
        StandAction::Temperature(degrees) => write!(f, "temperature {degrees}"),
        StandAction::ReplaceDevice => f.write_str("renew"),
        StandAction::RestoreFactoryState => f.write_str("device as_delivered"),
        StandAction::Skip(time) => write!(f, "clock {}.{:09}", time.as_secs(), time.subsec_nanos()),
    }
}

impl StandAnswer {
    /// Parses a line, with or without its line feed; the error names the invalid line.
    pub fn parse(line: &str) -> Result<StandAnswer, String> {
        let line = line.trim_end_matches(['\r', '\n']);
        let nonsense = || format!("the stand answered `{}`, which is not a valid answer", printable_text(line));
        if line.len() > LONGEST_LINE {
            return Err(nonsense());
        }
        let (word, rest) = line.split_once(' ').unwrap_or((line, ""));
        match (word, rest) {
            ("ok", "") => Ok(StandAnswer::Done(Duration::ZERO)),
            ("ok", rest) => match rest.strip_prefix("done-in ") {
                Some(time) => Ok(StandAnswer::Done(Duration::from_nanos(whole(time).map_err(|_| nonsense())?))),
                None => Ok(StandAnswer::Word(printable_text(rest))),
            },
            ("cannot", why) if !why.is_empty() => Ok(StandAnswer::Cannot(printable_text(why))),
            ("broken", why) if !why.is_empty() => Ok(StandAnswer::Broken(printable_text(why))),
            _ => Err(nonsense()),
        }
    }

    /// The answer to `help`: the forms of all commands.
    pub fn help() -> StandAnswer {
        let forms: Vec<&str> = FORMS.iter().map(|(form, _)| *form).collect();
        StandAnswer::Word(forms.join("; "))
    }
}

/// The line, without line feed; control characters are escaped.
impl fmt::Display for StandAnswer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            StandAnswer::Done(Duration::ZERO) => f.write_str("ok"),
            StandAnswer::Done(time) => write!(f, "ok done-in {}", time.as_nanos()),
            StandAnswer::Word(word) => write!(f, "ok {}", printable_text(word)),
            StandAnswer::Cannot(why) => write!(f, "cannot {}", printable_text(why)),
            StandAnswer::Broken(why) => write!(f, "broken {}", printable_text(why)),
        }
    }
}

impl From<StandRefusal> for StandAnswer {
    fn from(refusal: StandRefusal) -> StandAnswer {
        match refusal {
            StandRefusal::CannotDo(why) => StandAnswer::Cannot(why),
            StandRefusal::Broken(why) => StandAnswer::Broken(why),
        }
    }
}

/// The text of the other side in one line without control characters, cut so that an answer with it fits in a line.
fn printable_text(text: &str) -> String {
    let mut shown = String::new();
    for c in text.chars() {
        let before = shown.len();
        if c == ' ' || c.is_ascii_graphic() {
            shown.push(c)
        } else {
            shown.extend(c.escape_default())
        }
        if shown.len() > LONGEST_LINE - 100 {
            shown.truncate(before);
            break;
        }
    }
    shown
}

/// A name of `device.yaml`.
fn name(word: &str) -> Result<&str, String> {
    let fits = word.len() <= 64 && word.bytes().all(|octet| octet.is_ascii_alphanumeric() || b"_-.".contains(&octet));
    fits.then_some(word).ok_or_else(|| format!("`{}` is not a name", printable_text(word)))
}

fn either(word: &str, yes: &str, no: &str) -> Result<bool, String> {
    match word {
        word if word == yes => Ok(true),
        word if word == no => Ok(false),
        word => Err(format!("`{}` is neither {yes} nor {no}", printable_text(word))),
    }
}

fn number(word: &str) -> Result<f64, String> {
    let plain = word.bytes().all(|octet| octet.is_ascii_digit() || b"+-.eE".contains(&octet));
    let number = word.parse::<f64>().ok().filter(|number| plain && number.is_finite());
    number.ok_or_else(|| format!("`{}` is not a number", printable_text(word)))
}

fn positive(word: &str) -> Result<f64, String> {
    let rpm = number(word)?;
    if rpm > 0.0 { Ok(rpm) } else { Err(format!("the speed must be more than 0 rpm, not {rpm}")) }
}

fn whole<T: std::str::FromStr>(word: &str) -> Result<T, String> {
    word.parse().map_err(|_| format!("`{}` is not a whole number in range", printable_text(word)))
}

fn seconds(word: &str) -> Result<Duration, String> {
    let no_time = || format!("`{}` is not a number of seconds", printable_text(word));
    let (whole, fraction) = word.split_once('.').unwrap_or((word, "0"));
    let digits = |text: &str| !text.is_empty() && text.bytes().all(|octet| octet.is_ascii_digit());
    if !digits(whole) || !digits(fraction) || fraction.len() > 9 {
        return Err(no_time());
    }
    let nanos: u32 = format!("{fraction:0<9}").parse().map_err(|_| no_time())?;
    let seconds: u32 = whole.parse().map_err(|_| no_time())?;
    Ok(Duration::new(seconds.into(), nanos))
}

/// The error for a line that is not a command.
fn unknown(first: &str) -> String {
    let forms = || FORMS.iter().map(|(form, _)| *form);
    let head = |form: &'static str| form.split(' ').next().unwrap_or(form);
    let same: Vec<&str> = forms().filter(|form| head(form) == first).collect();
    if !same.is_empty() {
        return format!("the form is {}", same.join(" or "));
    }
    let heads: Vec<&str> = forms().map(head).collect();
    match nearest(first, heads.iter().copied()) {
        Some(meant) => format!("unknown command {}; did you mean {meant}?", printable_text(first)),
        None => format!("unknown command {}; send `help` for a list of commands", printable_text(first)),
    }
}

#[cfg(test)]
mod tests;
