//! Personas: how a controller addresses a device, from `suites/personas/<name>.yaml`.
//!
//! Everything that a persona does not say is as our controller does it anyway, and what a case says wins over both. This
//! module must not know how a Connect is built, nor who plays the controller.

use super::device_yaml::{duration, label, plain, whole};
use super::error::{LoadErrors, Mistakes, Read};
use super::keys::{Key, Keyed, Pattern, Shape, WordChoices};
use super::source::{Files, PERSONAS, Sources};
use super::yaml::{self, Node};
use plain_text::nearest;
use suite::persona::{BusCycle, ExpectedSubmodules, FrameClass, Persona, PersonaBlock, ReconnectBehavior};

/// Start-ups; whether it is the advanced one.
static START_UPS: WordChoices<bool> = WordChoices(&[("legacy", false), ("advanced", true)]);
/// Byte orders of RPC; whether the low byte comes first.
static BYTE_ORDERS: WordChoices<bool> = WordChoices(&[("big", false), ("little", true)]);
/// How start-up records are written; whether all go in one request.
static WRITES: WordChoices<bool> = WordChoices(&[("single", false), ("multiple", true)]);
/// The order of start-up records; whether it is reversed.
static RECORD_ORDERS: WordChoices<bool> = WordChoices(&[("listed", false), ("reversed", true)]);
/// The submodules that the Connect expects.
static EXPECTED: WordChoices<ExpectedSubmodules> = WordChoices(&[
    ("module", ExpectedSubmodules::Module),
    ("access_point", ExpectedSubmodules::AccessPoint),
    ("interface_and_ports", ExpectedSubmodules::InterfaceAndPorts),
]);
/// The blocks of a Connect after its ARBlockReq.
static BLOCKS: WordChoices<PersonaBlock> = WordChoices(&[
    ("inputs", PersonaBlock::Inputs),
    ("outputs", PersonaBlock::Outputs),
    ("submodules", PersonaBlock::Submodules),
    ("alarms", PersonaBlock::Alarms),
    ("extra", PersonaBlock::Extra),
]);
/// Whether frames carry tags.
static TAGGED: WordChoices<bool> = WordChoices(&[("tagged", true), ("untagged", false)]);
/// The UUID of a connection that is made again; whether it is the same.
static UUIDS: WordChoices<bool> = WordChoices(&[("same", true), ("new", false)]);

/// A station name by the rules of PROFINET; addresses and port names are refused beyond this form.
pub static STATION_NAME: Pattern =
    Pattern { regex: r"^(?=.{1,240}$)[a-z0-9]([a-z0-9-]{0,61}[a-z0-9])?(\.[a-z0-9]([a-z0-9-]{0,61}[a-z0-9])?)*$" };
/// Bytes in hexadecimal, with or without spaces between them.
static BLOCK: Pattern = Pattern { regex: r"^\s*([0-9A-Fa-f]\s*[0-9A-Fa-f]\s*)+$" };

key_set! {
    pub(crate) persona "a persona" {
        encspec may Pattern(&crate::needed_version::VERSIONS), "The versions of encspec that can read this file, for instance `>=0.2`.";
        persona must Label, "The name of the file, which `--persona` takes; it says a trait, not a product.";
        why must Text, "One sentence: what is special about it.";
        source must Text, "Where it was observed: a capture and its frames, an address, or `invented`.";
        station_name may Pattern(&STATION_NAME), "The name of the controller's station in the Connect.";
        start_up may Word(&START_UPS), "Which start-up it requests; `legacy` by default.";
        byte_order may Word(&BYTE_ORDERS), "The byte order of its RPC; `big` by default.";
        blocks may Keys(&persona_blocks::KEYS), "The blocks of the Connect after the ARBlockReq.";
        write may Word(&WRITES), "Whether start-up records go one by one or in one; `single` by default.";
        records may Word(&RECORD_ORDERS), "The order of the start-up records; `listed` by default.";
        expects may Word(&EXPECTED), "Which submodules it expects in addition to those of the module; `access_point` by default.";
        cycle may Keys(&persona_cycle::KEYS), "The cycle of connections that say none.";
        factors may Keys(&persona_factors::KEYS), "How many cycles without a frame it takes; what a case says of its watchdog wins.";
        class may Keys(&persona_class::KEYS), "The class of the cyclic frames.";
        tags may Keys(&persona_tags::KEYS), "The tags of its frames.";
        references may Keys(&persona_references::KEYS), "The numbers that it gives its connections.";
        rta may Keys(&persona_rta::KEYS), "How it takes alarms.";
        activity_timeout may Whole(1, 1000), "How long the device waits for its next step, in units of 100 ms; 1 to 1000, 600 by default.";
        args_max may Whole(0, 0xFFFF_FFFF), "How many bytes of an answer to Connect it says it can take, 4096 by default.";
        reconnect may Keys(&persona_reconnect::KEYS), "What it does after a connection was lost.";
    }
}

key_set! {
    pub(crate) persona_blocks "blocks" {
        order may Between(4, 5, &Word(&BLOCKS)), "The order of the blocks; `inputs, outputs, submodules, alarms, extra` by default.";
        extra may List(&Pattern(&BLOCK)), "Whole blocks with their headers that are passed along as they are, in hexadecimal bytes.";
    }
}

key_set! {
    pub(crate) persona_cycle "cycle" {
        send_clock may Whole(1, 128), "The send clock in units of 31.25 us, 1 to 128; 32 by default.";
        reduction may Numbers(&[1, 2, 4, 8, 16, 32, 64, 128, 256, 512]), "A frame in each n-th send clock, a power of two up to 512; 2 by default.";
        phase_in may Whole(1, 512), "The phase of the inputs, 1 to the reduction; 1 by default.";
        phase_out may Whole(1, 512), "The phase of the outputs, 1 to the reduction; 1 by default.";
    }
}

key_set! {
    pub(crate) persona_factors "factors" {
        watchdog must Whole(1, 7680), "Cycles without a frame until a consumer objects.";
        data_hold may Whole(1, 7680), "Cycles without a frame until the connection ends; the watchdog by default.";
    }
}

key_set! {
    pub(crate) persona_class "class" {
        rt must Whole(1, 2), "The class: 1 or 2.";
        frame_id_in may Whole(0x8000, 0xF7FF), "The frame id that is proposed for the inputs.";
        frame_id_out may Whole(0x8000, 0xFFFF), "The frame id that is proposed for the outputs; 0xFFFF, the default, leaves it to the device.";
    }
}

key_set! {
    pub(crate) persona_tags "tags" {
        frames may Word(&TAGGED), "Whether its cyclic frames and alarms carry tags; `tagged` by default.";
        cyclic may Whole(0xC000, 0xCFFF), "The tag of cyclic frames, 0xC000 by default.";
        alarm_high may Whole(0xC000, 0xCFFF), "The tag of alarms of high priority, 0xC000 by default.";
        alarm_low may Whole(0xA000, 0xAFFF), "The tag of alarms of low priority, 0xA000 by default.";
    }
}

key_set! {
    pub(crate) persona_references "references" {
        inputs may Whole(0, 0xFFFF), "IOCRReference of the inputs, 1 by default.";
        outputs may Whole(0, 0xFFFF), "IOCRReference of the outputs, 2 by default.";
        alarm may Whole(0, 0xFFFF), "LocalAlarmReference; by default a new one for each connection.";
    }
}

key_set! {
    pub(crate) persona_rta "rta" {
        timeout may Whole(1, 100), "How long it waits for an acknowledgement, in units of 100 ms; 1 to 100, 1 by default.";
        retries may Whole(3, 15), "How often it repeats; 3 to 15, 3 by default.";
        max_alarm may Whole(200, 1432), "The most bytes of an alarm that it takes; 200 to 1432, 200 by default.";
    }
}

key_set! {
    pub(crate) persona_reconnect "reconnect" {
        after must Time, "How long after the loss it connects again.";
        uuid must Word(&UUIDS), "Whether the connection has the same name again or a new one.";
    }
}

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
    let keyed = Keyed::new(node, &persona::KEYS)?;
    let name = keyed.must(&persona::persona)?;
    if name.text("persona")? != file {
        return Err(name.wrong(format!("this is the file `{file}.yaml`")).help(format!("write `persona: {file}`")));
    }
    label(name, file)?;
    let text = |key: &Key| keyed.must(key)?.text(key.name).map(str::to_owned);
    let (order, extra) = keyed.get(&persona::blocks).map_or(Ok((None, Vec::new())), blocks)?;
    let cycle = keyed.get(&persona::cycle).map(cycle).transpose()?;
    let factors = keyed.get(&persona::factors).map(|node| factors(node, cycle)).transpose()?;
    let (tagged, tags) = keyed.get(&persona::tags).map_or(Ok((None, [None; 3])), self::tags)?;
    let (iocr_references, alarm_reference) = keyed.get(&persona::references).map_or(Ok((None, None)), references)?;
    let [rta_timeout, rta_retries, max_alarm] = keyed.get(&persona::rta).map_or(Ok([None; 3]), rta)?;
    Ok(Persona {
        name: file.to_owned(),
        why: text(&persona::why)?,
        source: text(&persona::source)?,
        station_name: keyed.get(&persona::station_name).map(station_name).transpose()?,
        advanced: keyed.word(&persona::start_up, &START_UPS)?,
        little_endian: keyed.word(&persona::byte_order, &BYTE_ORDERS)?,
        order,
        extra,
        write_multiple: keyed.word(&persona::write, &WRITES)?,
        records_reversed: keyed.word(&persona::records, &RECORD_ORDERS)? == Some(true),
        expects: keyed.word(&persona::expects, &EXPECTED)?.unwrap_or(ExpectedSubmodules::AccessPoint),
        cycle,
        factors,
        class: keyed.get(&persona::class).map(class).transpose()?,
        tagged,
        tags,
        iocr_references,
        alarm_reference,
        rta_timeout,
        rta_retries,
        max_alarm,
        activity_timeout: within(keyed, &persona::activity_timeout)?,
        args_max: keyed.get(&persona::args_max).map(|node| whole(node, "a number of bytes")).transpose()?,
        reconnect: keyed.get(&persona::reconnect).map(again).transpose()?,
    })
}

fn station_name(node: &Node) -> Read<String> {
    let name = node.text("station_name")?;
    match wire::profinet::dcp::station_name::check(name.as_bytes()) {
        Ok(()) => Ok(name.to_owned()),
        Err(why) => Err(node.wrong(format!("`{name}` is no name of a station: {why}"))),
    }
}

/// The number of a key, in the range that the key allows.
fn within(keyed: Keyed<'_>, key: &Key) -> Read<Option<u16>> {
    match key.shape {
        Shape::Whole(least, most) => between(keyed, key, least, most),
        _ => keyed.get(key).map(|node| whole(node, key.name)).transpose(),
    }
}

/// The number of a key if it lies in this range, both ends included.
fn between(keyed: Keyed<'_>, key: &Key, least: i128, most: i128) -> Read<Option<u16>> {
    let Some(node) = keyed.get(key) else { return Ok(None) };
    match whole::<i128>(node, key.name)? {
        number if (least..=most).contains(&number) => Ok(u16::try_from(number).ok()),
        number => Err(node
            .wrong(format!("`{}` is {number}", key.name))
            .help(format!("write a number from {least} to {most}"))),
    }
}

fn blocks(node: &Node) -> Read<(Option<Vec<PersonaBlock>>, Vec<u8>)> {
    let keyed = Keyed::new(node, &persona_blocks::KEYS)?;
    let order = keyed.get(&persona_blocks::order).map(order).transpose()?;
    let mut extra = Vec::new();
    for block in keyed.get(&persona_blocks::extra).map_or(Ok(&[][..]), |node| node.items("extra"))? {
        let octets = octets(block)?;
        let length = octets.get(2..4).map(|length| usize::from(u16::from_be_bytes([length[0], length[1]])) + 4);
        if length != Some(octets.len()) {
            let said = length.map_or_else(|| "no length".to_owned(), |length| format!("{length} bytes"));
            return Err(block.wrong(format!("the block has {} bytes, its header says {said}", octets.len())));
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
        let block = BLOCKS.read(item, &persona_blocks::order)?;
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

/// Bytes in hexadecimal, with or without spaces between them.
fn octets(node: &Node) -> Read<Vec<u8>> {
    let text: String = node.text("a block")?.chars().filter(|letter| !letter.is_whitespace()).collect();
    let wrong = || node.wrong("a block is written in hexadecimal bytes, for instance '010B0020 0100'");
    if !text.len().is_multiple_of(2) || !text.is_ascii() {
        return Err(wrong());
    }
    let pairs = (0..text.len()).step_by(2).filter_map(|at| text.get(at..at + 2));
    pairs.map(|pair| u8::from_str_radix(pair, 16).map_err(|_| wrong())).collect()
}

fn cycle(node: &Node) -> Read<BusCycle> {
    let keyed = Keyed::new(node, &persona_cycle::KEYS)?;
    let send_clock = within(keyed, &persona_cycle::send_clock)?.unwrap_or(32);
    let reduction = within(keyed, &persona_cycle::reduction)?.unwrap_or(2);
    if !reduction.is_power_of_two() {
        let place = keyed.get(&persona_cycle::reduction).unwrap_or(node);
        return Err(place
            .wrong(format!("a reduction of {reduction} is no power of two"))
            .help("write 1, 2, 4, 8 ... 512"));
    }
    if u64::from(send_clock) * u64::from(reduction) > LONGEST.0 {
        return Err(node.wrong("the cycle is longer than 512ms"));
    }
    let phase = |key: &Key| -> Read<u16> { Ok(between(keyed, key, 1, reduction.into())?.unwrap_or(1)) };
    Ok(BusCycle {
        send_clock,
        reduction,
        phase_in: phase(&persona_cycle::phase_in)?,
        phase_out: phase(&persona_cycle::phase_out)?,
    })
}

fn factors(node: &Node, cycle: Option<BusCycle>) -> Read<(u16, u16)> {
    let keyed = Keyed::new(node, &persona_factors::KEYS)?;
    let watchdog = within(keyed, &persona_factors::watchdog)?.unwrap_or(3);
    let data_hold = between(keyed, &persona_factors::data_hold, watchdog.into(), 7680)?.unwrap_or(watchdog);
    let units = cycle.map_or(64, |cycle| u64::from(cycle.send_clock) * u64::from(cycle.reduction));
    match units * u64::from(data_hold) <= LONGEST.1 {
        true => Ok((watchdog, data_hold)),
        false => Err(node.wrong("the time without frames is longer than 1.92s")),
    }
}

fn class(node: &Node) -> Read<FrameClass> {
    let keyed = Keyed::new(node, &persona_class::KEYS)?;
    let rt = within(keyed, &persona_class::rt)?.unwrap_or(1);
    let rt = u8::try_from(rt).unwrap_or(1);
    let ids = if rt == 1 { 0xC000..=0xF7FF } else { 0x8000..=0xBBFF };
    let id = |key: &Key, default: u16, open: bool| -> Read<u16> {
        let Some(node) = keyed.get(key) else { return Ok(default) };
        match whole::<u16>(node, key.name)? {
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
        frame_id_in: id(&persona_class::frame_id_in, first, false)?,
        frame_id_out: id(&persona_class::frame_id_out, 0xFFFF, true)?,
    })
}

fn tags(node: &Node) -> Read<(Option<bool>, [Option<u16>; 3])> {
    let keyed = Keyed::new(node, &persona_tags::KEYS)?;
    let frames = keyed.word(&persona_tags::frames, &TAGGED)?;
    // The priority is given by the standard, the VLAN by the plant.
    let tag = |key: &Key, priority: u16| -> Read<Option<u16>> {
        let Some(node) = keyed.get(key) else { return Ok(None) };
        match whole::<u16>(node, key.name)? {
            tag if tag >> 12 == priority => Ok(Some(tag)),
            tag => Err(node
                .wrong(format!("{tag:#06X} has not the priority of such frames"))
                .help(format!("write a number from {priority:#X}000 to {priority:#X}FFF"))),
        }
    };
    Ok((
        frames,
        [tag(&persona_tags::cyclic, 0xC)?, tag(&persona_tags::alarm_high, 0xC)?, tag(&persona_tags::alarm_low, 0xA)?],
    ))
}

type References = (Option<(u16, u16)>, Option<u16>);

fn references(node: &Node) -> Read<References> {
    let keyed = Keyed::new(node, &persona_references::KEYS)?;
    let (inputs, outputs) = (within(keyed, &persona_references::inputs)?, within(keyed, &persona_references::outputs)?);
    let iocr = (inputs.unwrap_or(1), outputs.unwrap_or(2));
    if iocr.0 == iocr.1 {
        return Err(node.wrong(format!("inputs and outputs have both the reference {}", iocr.0)));
    }
    Ok(((inputs.is_some() || outputs.is_some()).then_some(iocr), within(keyed, &persona_references::alarm)?))
}

fn rta(node: &Node) -> Read<[Option<u16>; 3]> {
    let keyed = Keyed::new(node, &persona_rta::KEYS)?;
    Ok([
        within(keyed, &persona_rta::timeout)?,
        within(keyed, &persona_rta::retries)?,
        within(keyed, &persona_rta::max_alarm)?,
    ])
}

fn again(node: &Node) -> Read<ReconnectBehavior> {
    let keyed = Keyed::new(node, &persona_reconnect::KEYS)?;
    let after = duration(keyed.must(&persona_reconnect::after)?, "a pause")?;
    let same_uuid = UUIDS.read(keyed.must(&persona_reconnect::uuid)?, &persona_reconnect::uuid)?;
    Ok(ReconnectBehavior { after, same_uuid })
}

/// The persona that a bench file names; whether there is one is found with the suites.
pub fn persona_name(node: &Node) -> Read<String> {
    plain(node, "a persona").map(str::to_owned)
}
