//! Personas: the manner in which a controller addresses a device, as `suites/personas/<name>.yaml` tells it.
//!
//! Everything that a persona does not say is as our controller does it anyway, and what a case says wins over both. This
//! module must not know how a Connect is built, nor who plays the controller.

use super::device_yaml::{duration, label, plain, whole, word};
use super::error::{LoadErrors, Mistakes, Read};
use super::keys::{self, Keyed};
use super::source::{Files, PERSONAS, Sources};
use super::yaml::{self, Node};
use plain_text::nearest;
use suite::persona::{BusCycle, ExpectedSubmodules, FrameClass, Persona, PersonaBlock, ReconnectBehavior};

/// The longest cycle and the longest watchdog in units of the send clock: 512 ms and 1.92 s (IEC 61158-6-10).
const LONGEST: (u64, u64) = (16_384, 61_440);

/// Loads every persona of `sources`, in the order of their names; everything that is wrong comes back at once.
pub fn load_personas(sources: &Sources) -> Result<Vec<Persona>, LoadErrors> {
    let (mut files, mistakes) = (Files::default(), Mistakes::default());
    let mut personas = Vec::new();
    for name in sources.names_in(PERSONAS) {
        let Some((file, text)) = files.open(sources, PERSONAS, &name) else { continue };
        let read = yaml::parse(file, &text).and_then(|node| persona(&node, &name));
        personas.extend(mistakes.keep(read));
    }
    if mistakes.count() == 0 { Ok(personas) } else { Err(files.errors(&mistakes)) }
}

/// The persona of this name; the error says which is probably meant.
pub fn named_persona(personas: Vec<Persona>, name: &str) -> Result<Persona, String> {
    let names: Vec<String> = personas.iter().map(|persona| persona.name.clone()).collect();
    let found = personas.into_iter().find(|persona| persona.name == name);
    found.ok_or_else(|| {
        let meant = nearest(name, names.iter().map(String::as_str))
            .map_or_else(|| "`encspec personas` lists them".to_owned(), |meant| format!("did you mean `{meant}`?"));
        format!("unknown persona `{name}`; {meant}")
    })
}

fn persona(node: &Node, file: &str) -> Read<Persona> {
    let keyed = Keyed::new(node, &keys::PERSONA)?;
    let name = keyed.must("persona")?;
    if name.text("persona")? != file {
        return Err(name.wrong(format!("this is the file `{file}.yaml`")).help(format!("write `persona: {file}`")));
    }
    label(name, file)?;
    let text = |key: &str| keyed.must(key)?.text(key).map(str::to_owned);
    let is = |key: &str, words: &'static [&'static str], yes: &str| -> Read<Option<bool>> {
        keyed.get(key).map(|node| Ok(word(node, key, words)? == yes)).transpose()
    };
    let (order, extra) = keyed.get("blocks").map_or(Ok((None, Vec::new())), blocks)?;
    let cycle = keyed.get("cycle").map(cycle).transpose()?;
    let factors = keyed.get("factors").map(|node| factors(node, cycle)).transpose()?;
    let (tagged, tags) = keyed.get("tags").map_or(Ok((None, [None; 3])), self::tags)?;
    let (iocr_references, alarm_reference) = keyed.get("references").map_or(Ok((None, None)), references)?;
    let [rta_timeout, rta_retries, max_alarm] = keyed.get("rta").map_or(Ok([None; 3]), rta)?;
    Ok(Persona {
        name: file.to_owned(),
        why: text("why")?,
        source: text("source")?,
        station_name: keyed.get("station_name").map(station_name).transpose()?,
        advanced: is("start_up", keys::START_UPS, "advanced")?,
        little_endian: is("byte_order", keys::BYTE_ORDERS, "little")?,
        order,
        extra,
        write_multiple: is("write", keys::WRITES, "multiple")?,
        records_reversed: is("records", keys::RECORD_ORDERS, "reversed")? == Some(true),
        expects: match keyed.get("expects").map(|node| word(node, "expects", keys::EXPECTED)).transpose()? {
            Some("module") => ExpectedSubmodules::Module,
            Some("interface_and_ports") => ExpectedSubmodules::InterfaceAndPorts,
            _ => ExpectedSubmodules::AccessPoint,
        },
        cycle,
        factors,
        class: keyed.get("class").map(class).transpose()?,
        tagged,
        tags,
        iocr_references,
        alarm_reference,
        rta_timeout,
        rta_retries,
        max_alarm,
        activity_timeout: within(keyed, "activity_timeout", 1, 1000)?,
        args_max: keyed.get("args_max").map(|node| whole(node, "a number of octets")).transpose()?,
        reconnect: keyed.get("reconnect").map(again).transpose()?,
    })
}

fn station_name(node: &Node) -> Read<String> {
    let name = node.text("station_name")?;
    match wire::profinet::dcp::station_name::check(name.as_bytes()) {
        Ok(()) => Ok(name.to_owned()),
        Err(why) => Err(node.wrong(format!("`{name}` is no name of a station: {why}"))),
    }
}

/// A number between two others, or the mistake that it is not.
fn within(keyed: Keyed<'_>, key: &str, least: u16, most: u16) -> Read<Option<u16>> {
    let Some(node) = keyed.get(key) else { return Ok(None) };
    match whole::<i128>(node, key)? {
        number if (i128::from(least)..=i128::from(most)).contains(&number) => Ok(u16::try_from(number).ok()),
        number => {
            Err(node.wrong(format!("`{key}` is {number}")).help(format!("write a number from {least} to {most}")))
        }
    }
}

fn blocks(node: &Node) -> Read<(Option<Vec<PersonaBlock>>, Vec<u8>)> {
    let keyed = Keyed::new(node, &keys::PERSONA_BLOCKS)?;
    let order = keyed.get("order").map(order).transpose()?;
    let mut extra = Vec::new();
    for block in keyed.get("extra").map_or(Ok(&[][..]), |node| node.items("extra"))? {
        let octets = octets(block)?;
        let length = octets.get(2..4).map(|length| usize::from(u16::from_be_bytes([length[0], length[1]])) + 4);
        if length != Some(octets.len()) {
            let said = length.map_or_else(|| "no length".to_owned(), |length| format!("{length} octets"));
            return Err(block.wrong(format!("the block has {} octets, its header says {said}", octets.len())));
        }
        extra.extend(octets);
    }
    let left_out = order.as_ref().is_some_and(|order| !order.contains(&PersonaBlock::Extra));
    if left_out && !extra.is_empty() {
        return Err(node.key("order").wrong("`extra` has no place in the order").help("name it in `order`"));
    }
    Ok((order, extra))
}

fn order(node: &Node) -> Read<Vec<PersonaBlock>> {
    let mut order = Vec::new();
    for item in node.items("order")? {
        let block = match word(item, "a block", keys::CONNECT_PARTS)? {
            "inputs" => PersonaBlock::Inputs,
            "outputs" => PersonaBlock::Outputs,
            "submodules" => PersonaBlock::Submodules,
            "alarms" => PersonaBlock::Alarms,
            _ => PersonaBlock::Extra,
        };
        if order.contains(&block) {
            return Err(item.wrong("the block stands in the order already"));
        }
        order.push(block);
    }
    let needed = [PersonaBlock::Inputs, PersonaBlock::Outputs, PersonaBlock::Submodules, PersonaBlock::Alarms];
    match needed.iter().all(|block| order.contains(block)) {
        true => Ok(order),
        false => Err(node.wrong("the order needs `inputs`, `outputs`, `submodules` and `alarms`")),
    }
}

/// Octets in hexadecimal, with or without spaces between them.
fn octets(node: &Node) -> Read<Vec<u8>> {
    let text: String = node.text("a block")?.chars().filter(|letter| !letter.is_whitespace()).collect();
    let wrong = || node.wrong("a block is written in hexadecimal octets, for instance '010B0020 0100'");
    if !text.len().is_multiple_of(2) || !text.is_ascii() {
        return Err(wrong());
    }
    let pairs = (0..text.len()).step_by(2).filter_map(|at| text.get(at..at + 2));
    pairs.map(|pair| u8::from_str_radix(pair, 16).map_err(|_| wrong())).collect()
}

fn cycle(node: &Node) -> Read<BusCycle> {
    let keyed = Keyed::new(node, &keys::PERSONA_CYCLE)?;
    let send_clock = within(keyed, "send_clock", 1, 128)?.unwrap_or(32);
    let reduction = within(keyed, "reduction", 1, 512)?.unwrap_or(2);
    if !reduction.is_power_of_two() {
        let place = keyed.get("reduction").unwrap_or(node);
        return Err(place
            .wrong(format!("a reduction of {reduction} is no power of two"))
            .help("write 1, 2, 4, 8 ... 512"));
    }
    if u64::from(send_clock) * u64::from(reduction) > LONGEST.0 {
        return Err(node.wrong("the cycle is longer than 512ms"));
    }
    let phase = |key| -> Read<u16> { Ok(within(keyed, key, 1, reduction)?.unwrap_or(1)) };
    Ok(BusCycle { send_clock, reduction, phase_in: phase("phase_in")?, phase_out: phase("phase_out")? })
}

fn factors(node: &Node, cycle: Option<BusCycle>) -> Read<(u16, u16)> {
    let keyed = Keyed::new(node, &keys::PERSONA_FACTORS)?;
    let watchdog = within(keyed, "watchdog", 1, 7680)?.unwrap_or(3);
    let data_hold = within(keyed, "data_hold", watchdog, 7680)?.unwrap_or(watchdog);
    let units = cycle.map_or(64, |cycle| u64::from(cycle.send_clock) * u64::from(cycle.reduction));
    match units * u64::from(data_hold) <= LONGEST.1 {
        true => Ok((watchdog, data_hold)),
        false => Err(node.wrong("the time without frames is longer than 1.92s")),
    }
}

fn class(node: &Node) -> Read<FrameClass> {
    let keyed = Keyed::new(node, &keys::PERSONA_CLASS)?;
    let rt = within(keyed, "rt", 1, 2)?.unwrap_or(1);
    let rt = u8::try_from(rt).unwrap_or(1);
    let ids = if rt == 1 { 0xC000..=0xF7FF } else { 0x8000..=0xBBFF };
    let id = |key: &str, default: u16, open: bool| -> Read<u16> {
        let Some(node) = keyed.get(key) else { return Ok(default) };
        match whole::<u16>(node, key)? {
            id if ids.contains(&id) || (open && id == 0xFFFF) => Ok(id),
            id => Err(node.wrong(format!("{id:#06X} is no frame id of class {rt}")).help(format!(
                "write a number from {:#06X} to {:#06X}",
                ids.start(),
                ids.end()
            ))),
        }
    };
    let first = if rt == 1 { 0xC001 } else { 0x8001 };
    Ok(FrameClass {
        rt,
        frame_id_in: id("frame_id_in", first, false)?,
        frame_id_out: id("frame_id_out", 0xFFFF, true)?,
    })
}

fn tags(node: &Node) -> Read<(Option<bool>, [Option<u16>; 3])> {
    let keyed = Keyed::new(node, &keys::PERSONA_TAGS)?;
    let frames = keyed.get("frames").map(|node| word(node, "frames", keys::TAGGED)).transpose()?;
    // The priority is given by the standard, the VLAN by the plant.
    let tag = |key: &str, priority: u16| -> Read<Option<u16>> {
        let Some(node) = keyed.get(key) else { return Ok(None) };
        match whole::<u16>(node, key)? {
            tag if tag >> 12 == priority => Ok(Some(tag)),
            tag => Err(node
                .wrong(format!("{tag:#06X} has not the priority of such frames"))
                .help(format!("write a number from {priority:#X}000 to {priority:#X}FFF"))),
        }
    };
    Ok((frames.map(|word| word == "tagged"), [tag("cyclic", 0xC)?, tag("alarm_high", 0xC)?, tag("alarm_low", 0xA)?]))
}

type References = (Option<(u16, u16)>, Option<u16>);

fn references(node: &Node) -> Read<References> {
    let keyed = Keyed::new(node, &keys::PERSONA_REFERENCES)?;
    let (inputs, outputs) = (within(keyed, "inputs", 0, u16::MAX)?, within(keyed, "outputs", 0, u16::MAX)?);
    let iocr = (inputs.unwrap_or(1), outputs.unwrap_or(2));
    if iocr.0 == iocr.1 {
        return Err(node.wrong(format!("inputs and outputs have both the reference {}", iocr.0)));
    }
    Ok(((inputs.is_some() || outputs.is_some()).then_some(iocr), within(keyed, "alarm", 0, u16::MAX)?))
}

fn rta(node: &Node) -> Read<[Option<u16>; 3]> {
    let keyed = Keyed::new(node, &keys::PERSONA_RTA)?;
    Ok([within(keyed, "timeout", 1, 100)?, within(keyed, "retries", 3, 15)?, within(keyed, "max_alarm", 200, 1432)?])
}

fn again(node: &Node) -> Read<ReconnectBehavior> {
    let keyed = Keyed::new(node, &keys::PERSONA_RECONNECT)?;
    let after = duration(keyed.must("after")?, "a pause")?;
    let same_uuid = word(keyed.must("uuid")?, "uuid", keys::UUIDS)? == "same";
    Ok(ReconnectBehavior { after, same_uuid })
}

/// The persona that a bench file names; whether there is one is found with the suites.
pub fn persona_name(node: &Node) -> Read<String> {
    plain(node, "a persona").map(str::to_owned)
}
