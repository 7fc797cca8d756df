//! What the web server shows and takes.

use core::time::Duration;

/// What the web server shows and takes.
#[derive(Clone, Copy, Debug)]
pub struct Web {
    /// Whether pages are served before there was a connection since power-up.
    pub is_ready_alone: bool,
    /// The site of the vendor, to which links lead.
    pub site: &'static str,
    /// Whether the menu says which of its pages are protected.
    pub parts_menu: bool,
    /// Whether pages that lead to a change are opened by a link that asks for confirmation.
    pub confirms: bool,
    /// The user parameters that are shown.
    pub information: Shown,
    /// The software version that is shown, from the right one.
    pub version: fn(u64) -> u64,
    /// The position that is shown, from the position and the raw place.
    pub position: fn(u64, u64) -> u64,
    /// Whether the position is looked up for each page, and not for the first one only.
    pub position_is_present: bool,
    /// Whether the position is shown to whoever asks.
    pub position_is_free: bool,
    /// How long the signals of the telegram stand still while a page is made.
    pub takes: Duration,
    /// The preset value that was entered; none if the entry is refused.
    pub entry: fn(&str) -> Option<u32>,
    /// Where an entry goes.
    pub keeps: Kept,
    /// Whether an entry carries out a preset.
    pub entry_presets: bool,
    /// Whether a value that is stored already is not stored again.
    pub knows_stored: bool,
    /// Whether this is the password of the firmware upgrade.
    pub is_password: fn(&str) -> bool,
    /// Whether the server stops once the encoder waits for its firmware.
    pub stops: bool,
}

/// Which user parameters a page shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shown {
    /// Those in force.
    InForce,
    /// Those without a record.
    Default,
    /// Those that were in force when they were first asked for.
    First,
}

/// Where a preset value that was entered goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kept {
    /// Into P65000 and into memory.
    Everywhere,
    /// Into memory only.
    Stored,
    /// Into P65000 only.
    Used,
    /// Into a value of the web server's own.
    Apart,
}

impl Default for Web {
    fn default() -> Web {
        Web {
            is_ready_alone: true,
            site: "www.lika.it",
            parts_menu: true,
            confirms: true,
            information: Shown::InForce,
            version: |version| version,
            position: |position, _| position,
            position_is_present: true,
            position_is_free: true,
            takes: Duration::ZERO,
            entry: hexadecimal,
            keeps: Kept::Everywhere,
            entry_presets: false,
            knows_stored: true,
            is_password: |password| password == "lika",
            stops: true,
        }
    }
}

/// One to eight hexadecimal digits and nothing else: manual, 17.2, step 4.
fn hexadecimal(entry: &str) -> Option<u32> {
    let is_number = (1..=8).contains(&entry.len()) && entry.bytes().all(|octet| octet.is_ascii_hexdigit());
    u32::from_str_radix(entry, 16).ok().filter(|_| is_number)
}
