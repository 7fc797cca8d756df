//! The serial line of a bench: what a PROFIBUS at it is like.

use station::Parity;
use suite_yaml::device_yaml::{flag, whole};
use suite_yaml::error::{Mistake, Read};
use suite_yaml::keys::{self, Keyed};
use suite_yaml::yaml::Node;
use wire::profibus::fdl::{BROADCAST, BaudRate, BitTimes};

/// The most bit times of a slot time; at the lowest rate that is more than a minute.
const LONGEST_SLOT: u64 = 1_000_000;
/// The highest address of a master.
const HIGHEST_MASTER: u8 = 125;

/// What a PROFIBUS at a serial line is like; what is none is as usual.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LineSpec {
    /// Bits in a second.
    pub baud: Option<BaudRate>,
    /// The parity bit.
    pub parity: Parity,
    /// How long an answer is waited for (TSL).
    pub slot_time: Option<BitTimes>,
    /// The longest that a slave takes to answer (max TSDR).
    pub max_tsdr: Option<BitTimes>,
    /// Who switches the driver of the RS-485 adapter; none: nobody said.
    pub driver: Option<Driver>,
    /// Whether the adapter lets what we send come back.
    pub echo: bool,
    /// The station address of the device.
    pub address: Option<u8>,
    /// Those of our masters.
    pub masters: Option<[u8; 2]>,
}

/// Who switches the driver of an RS-485 adapter on and off, which has to be hardware.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Driver {
    /// The adapter by itself.
    Adapter,
    /// The port, which the kernel tells to.
    Port,
}

/// Reads the section `line`.
pub(super) fn line(node: &Node) -> Read<LineSpec> {
    let keyed = Keyed::new(node, &keys::BENCH_LINE)?;
    let get = |key: &str| keyed.get(key);
    let bits = |node: &Node| match whole::<u64>(node, "a number of bit times")? {
        bits @ 1..=LONGEST_SLOT => Ok(BitTimes(bits)),
        _ => Err(node.wrong(format!("a time on the bus has 1 to {LONGEST_SLOT} bits"))),
    };
    let address = get("address").map(|node| station(node, BROADCAST - 1)).transpose()?;
    let masters = get("masters").map(masters).transpose()?;
    if let (Some(node), Some(address), Some(masters)) = (get("address"), address, masters)
        && masters.contains(&address)
    {
        return Err(node.wrong("the device cannot have the address of one of our masters"));
    }
    Ok(LineSpec {
        baud: get("baud").map(baud).transpose()?,
        parity: get("parity").map_or(Ok(Parity::Even), parity)?,
        slot_time: get("slot_time").map(bits).transpose()?,
        max_tsdr: get("max_tsdr").map(bits).transpose()?,
        driver: get("driver").map(driver).transpose()?,
        echo: flag(keyed, "echo")?,
        address,
        masters,
    })
}

fn baud(node: &Node) -> Read<BaudRate> {
    let rate = BaudRate(whole(node, "a rate")?);
    if BaudRate::STANDARD.contains(&rate) {
        return Ok(rate);
    }
    let all: Vec<String> = BaudRate::STANDARD.iter().map(|rate| rate.0.to_string()).collect();
    Err(node.wrong(format!("PROFIBUS has no rate of {} bit/s", rate.0)).help(format!("there are {}", all.join(", "))))
}

/// One of the words that stand for values.
fn word<T: Copy>(node: &Node, what: &str, words: &[&'static str], values: &[T]) -> Read<T> {
    let text = node.text(what)?;
    let found = words.iter().zip(values).find(|(word, _)| **word == text);
    found.map(|(_, value)| *value).ok_or_else(|| Mistake::unknown(node.spot, what, text, words.iter().copied()))
}

fn parity(node: &Node) -> Read<Parity> {
    word(node, "parity", keys::PARITIES, &[Parity::Even, Parity::Odd, Parity::None])
}

fn driver(node: &Node) -> Read<Driver> {
    word(node, "driver", keys::DRIVERS, &[Driver::Adapter, Driver::Port])
}

fn station(node: &Node, highest: u8) -> Read<u8> {
    let address: u8 = whole(node, "a station address")?;
    if address <= highest { Ok(address) } else { Err(node.wrong(format!("a station address is 0 to {highest} here"))) }
}

fn masters(node: &Node) -> Read<[u8; 2]> {
    match node.items("masters")? {
        [first, second] => match (station(first, HIGHEST_MASTER)?, station(second, HIGHEST_MASTER)?) {
            (one, other) if one == other => Err(second.wrong("two masters cannot have the same address")),
            (one, other) => Ok([one, other]),
        },
        _ => Err(node.wrong("our masters have two addresses").help("as [1, 2]")),
    }
}
