//! Signals, their bits, and the submodules and modules that carry them.

use super::super::error::{Mistake, Read, both, every};
use super::super::keys::{Key, Keyed, WordChoices};
use super::super::yaml::Node;
use super::plain::{ORIGINS, numeral};
use super::{DeviceReader, device, flag, named, origin, pair, plain, whole};
use expression::{Number, WordTable};
use suite::device::{
    DeviceModule, DeviceRecord, DeviceSignal, DeviceSubmodule, DiagnosisLayout, SignalField, SignalForm, SignalSender,
    UserPrmLayout,
};

/// Who sends a signal.
static DIRECTIONS: WordChoices<SignalSender> =
    WordChoices(&[("controller", SignalSender::Controller), ("device", SignalSender::Device)]);

key_set! {
    pub(crate) signal "a signal" {
        from must Word(&DIRECTIONS), "Who sends it.";
        width may Numbers(&[8, 16, 32, 64]), "In bits: 8, 16, 32 or 64.";
        text may Whole(1, 255), "It is a text of so many ASCII characters, filled up with NUL or blanks; it has no `width`.";
        signed may Flag, "It is a two's complement.";
        float may Flag, "It is a number of IEEE 754, of 32 or 64 bits.";
        scale may Number, "Its value is the number on the wire times this one.";
        zero may Number, "The value of 0 on the wire, beside `scale`; 0 by default.";
        little_endian may Flag, "Its least significant byte comes first.";
        position_in may Name, "The size of the circle on which it is a place.";
        code_when may Name, "The bit that is set while the device shows a code in place of the position: codes are compared without `position_noise`.";
        shift may PerVariant(&Whole(0, 63)), "By how many bits it stands further left than its lowest step, one number or one for each variant; its name speaks in steps.";
        fields may NonEmptyMap(&Bits), "Its bits and groups of bits, counted as they are on the wire.";
        from_source may Word(&ORIGINS), "Where it comes from if the manual does not print it.";
    } [OneOf(&[&width, &text]), With(&[&code_when], &position_in), With(&[&zero], &scale)]
}

key_set! {
    pub(crate) field "a field of a signal or element" {
        bit may Whole(0, 63), "Its bit; 0 is the lowest.";
        bits may Pair(0, 63), "Its lowest and its highest bit.";
        signed may Flag, "It is a two's complement.";
        words may Name, "The table of its words.";
        counts may Pair(0, 0xFFFF_FFFF), "The first and the last number that it counts through by itself.";
    } [OneOf(&[&bit, &bits])]
}

key_set! {
    pub(crate) submodule "a submodule" {
        slot must Whole(0, 0xFFFF), "Slot number.";
        subslot must Whole(0, 0xFFFF), "Subslot number.";
        api may Whole(0, 0xFFFF_FFFF), "API, 0 by default.";
        ident must Whole(0, 0xFFFF_FFFF), "Ident number.";
        module_ident may PerVariant(&Whole(0, 0xFFFF_FFFF)), "Ident number of the module it is part of, one or one for each variant, where it is not that of the module in use; in slot 0: where it is not its own.";
        octets may Keys(&octets::KEYS), "Lengths of its cyclic data.";
        outputs may List(&Name), "Signals of its output data in order.";
        inputs may List(&Name), "Signals of its input data in order.";
        from_source may Word(&ORIGINS), "Where its ident comes from if the manual does not print it.";
    }
}

key_set! {
    pub(crate) octets "octets" {
        out must Whole(0, 0xFFFF), "Bytes of output data.";
        r#in must Whole(0, 0xFFFF), "Bytes of input data.";
    }
}

key_set! {
    pub(crate) module "a module" {
        ident must Whole(0, 0xFFFF_FFFF), "Ident number.";
        submodules must NonEmpty(&Name), "Its submodules.";
        from_source may Word(&ORIGINS), "Where its ident comes from if the manual does not print it.";
        absent may Text, "Why the device does not have it, by a GSDML; a trial that connects it is not applicable.";
    }
}

/// The bits of a signal: its width, or eight for each character of a text.
fn signal_width(keyed: Keyed<'_>) -> Read<u32> {
    if let Some(text) = keyed.get(&signal::text) {
        let octets: u32 = whole(text, "a number of characters")?;
        return if (1..=255).contains(&octets) {
            Ok(octets * 8)
        } else {
            Err(text.wrong("a text has 1 to 255 characters"))
        };
    }
    let width = keyed.must(&signal::width)?;
    let bits: u32 = whole(width, "a width")?;
    if [8, 16, 32, 64].contains(&bits) { Ok(bits) } else { Err(width.wrong("a width is 8, 16, 32 or 64 bits")) }
}

/// How the bits of a signal are a value. What is no whole number has no bits, no sign of its own and no place on a circle.
fn signal_form(keyed: Keyed<'_>, from: SignalSender, width: u32) -> Read<SignalForm> {
    let is_float = flag(keyed, &signal::float)?;
    let kinds = [
        (keyed.get(&signal::text), "a text"),
        (keyed.get(&signal::float).filter(|_| is_float), "a floating-point number"),
        (keyed.get(&signal::scale), "a scaled number"),
    ];
    let mut kinds = kinds.into_iter().filter_map(|(node, what)| Some((node?, what)));
    let Some((node, what)) = kinds.next() else { return Ok(SignalForm::Whole) };
    if let Some((other, _)) = kinds.next() {
        return Err(other
            .wrong(format!("this signal is {what} already"))
            .help("write one of `text`, `float` and `scale`"));
    }
    let is_scaled = keyed.get(&signal::scale).is_some();
    let lacks = [&signal::position_in, &signal::fields, &signal::shift];
    let only_scaled = [&signal::signed].into_iter().filter(|_| !is_scaled);
    if let Some((node, key)) = lacks.into_iter().chain(only_scaled).find_map(|key| Some((keyed.get(key)?, key))) {
        return Err(node.wrong(format!("{what} has no `{}`", key.name)).help(format!("leave out `{}`", key.name)));
    }
    if let Some(text) = keyed.get(&signal::text) {
        return match (from, keyed.get(&signal::little_endian)) {
            (SignalSender::Controller, _) => {
                Err(text.wrong("only the device sends texts").help("declare numbers, and set their bytes"))
            }
            (SignalSender::Device, Some(node)) => {
                Err(node.wrong("a text begins with its first character").help("leave out `little_endian`"))
            }
            (SignalSender::Device, None) => Ok(SignalForm::Text),
        };
    }
    if is_float {
        return if [32, 64].contains(&width) {
            Ok(SignalForm::Float)
        } else {
            Err(node.wrong("a floating-point number has 32 or 64 bits").help("write `width: 32` or `width: 64`"))
        };
    }
    let scale = numeral(node, "a scale")?;
    if scale == Number::ZERO {
        return Err(node.wrong("times 0 nothing is left").help("write what one step is in the unit of the manual"));
    }
    let zero = keyed.get(&signal::zero).map_or(Ok(Number::ZERO), |node| numeral(node, "a zero"))?;
    Ok(SignalForm::Scaled { scale, zero })
}

/// Whether the value of `code_when` is a bit that the device sends.
fn code_bit(node: &Node, signals: &[DeviceSignal]) -> Read<()> {
    let text = node.text("a bit")?;
    let named = text.split_once('.').is_some_and(|(name, field)| {
        let sent = signals.iter().filter(|signal| signal.from == SignalSender::Device && signal.name == name);
        sent.flat_map(|signal| &signal.fields).any(|of| of.name == field && of.width == 1)
    });
    if named {
        return Ok(());
    }
    Err(node
        .wrong(format!("`{text}` is no bit that the device sends"))
        .help("write SIGNAL.FIELD of a field with one bit"))
}

/// What goes over the wire of a device in a connection and at its start.
#[derive(Default)]
pub(super) struct Wired {
    pub signals: Vec<DeviceSignal>,
    pub submodules: Vec<DeviceSubmodule>,
    pub modules: Vec<DeviceModule>,
    pub records: Vec<DeviceRecord>,
    /// What only a device on PROFIBUS has.
    pub slave: Option<WiredSlave>,
}

/// What stands beside the cyclic data of a device on PROFIBUS.
pub(super) struct WiredSlave {
    pub address: u8,
    pub set_prm: UserPrmLayout,
    pub diagnosis: DiagnosisLayout,
}

impl<'n> DeviceReader<'n> {
    /// Signals, submodules, modules and records of a device on PROFINET.
    pub(super) fn cyclic(&mut self) -> Wired {
        let signals = self.signals();
        let (mut submodules, mut modules): (Vec<DeviceSubmodule>, Vec<DeviceModule>) = Default::default();
        for (name, node) in self.entries(&device::submodules) {
            self.declare("submodule", name, node.spot);
            let read = self.submodule(name, node, &signals);
            submodules.extend(self.mistakes.keep(read));
        }
        for (name, node) in self.entries(&device::modules) {
            self.declare("module", name, node.spot);
            let read = self.module(name, node, &submodules);
            modules.extend(self.mistakes.keep(read));
        }
        let records = self.records(&submodules, &modules);
        Wired { signals, submodules, modules, records, slave: None }
    }

    /// The signals of either bus.
    pub(super) fn signals(&mut self) -> Vec<DeviceSignal> {
        let mut signals = Vec::new();
        for (name, node) in self.entries(&device::signals) {
            let signal = self.signal(name, node);
            signals.extend(self.mistakes.keep(signal));
        }
        for (_, node) in self.entries(&device::signals) {
            let bit = Keyed::new(node, &signal::KEYS).ok().and_then(|keyed| keyed.get(&signal::code_when));
            let of = bit.and_then(Node::scalar).and_then(|text| text.split('.').next()).unwrap_or_default();
            let is_broken = self.is_declared(&device::signals, of) && signals.iter().all(|signal| signal.name != of);
            self.mistakes.keep(bit.filter(|_| !is_broken).map_or(Ok(()), |bit| code_bit(bit, &signals)));
        }
        signals
    }

    fn signal(&mut self, name: &str, node: &Node) -> Read<DeviceSignal> {
        let keyed = Keyed::new(node, &signal::KEYS)?;
        let from = DIRECTIONS.read(keyed.must(&signal::from)?, &signal::from)?;
        let bits = signal_width(keyed)?;
        let form = signal_form(keyed, from, bits)?;
        let signed = flag(keyed, &signal::signed)?;
        let position_in = keyed
            .get(&signal::position_in)
            .map(|node| Ok::<_, Box<Mistake>>((node, plain(node, "a circle")?)))
            .transpose()?;
        if let Some((node, text)) = position_in {
            if signed {
                return Err(node.wrong("a place on a circle has no sign").help("leave out `signed`"));
            }
            if !self.circles.iter().any(|known| known.scalar() == Some(text)) {
                self.circles.push(node.clone());
            }
        }
        self.declare("signal", name, node.spot);
        let fields = match keyed.get(&signal::fields) {
            None => Vec::new(),
            Some(node) => self.fields(node, bits, name)?,
        };
        let position_in = position_in.map(|(_, text)| text.to_owned());
        let code_when = keyed.get(&signal::code_when).map(|node| plain(node, "a bit")).transpose()?.map(str::to_owned);
        let shift = self.shift(keyed, from, bits, signed)?;
        let (name, origin) = (name.to_owned(), origin(keyed, &signal::from_source)?);
        let little_endian = flag(keyed, &signal::little_endian)?;
        Ok(DeviceSignal {
            name,
            from,
            width: bits,
            signed,
            form,
            little_endian,
            origin,
            position_in,
            code_when,
            shift,
            fields,
        })
    }

    /// By how many bits the number of a signal stands further left than its lowest step, for each variant.
    fn shift(&self, keyed: Keyed<'_>, from: SignalSender, width: u32, signed: bool) -> Read<Vec<u32>> {
        let Some(node) = keyed.get(&signal::shift) else { return Ok(vec![0; self.variants.len()]) };
        if from == SignalSender::Controller {
            return Err(node.wrong("only what the device sends can stand further left"));
        }
        if signed {
            return Err(node.wrong("a number with a sign does not stand further left").help("leave out `signed`"));
        }
        self.per_variant(node, |node, _| {
            let shift: u32 = whole(node, "a number of bits")?;
            if shift < width { Ok(shift) } else { Err(node.wrong(format!("there are {width} bits only"))) }
        })
    }

    /// Bits and groups of bits of something `width` bits wide.
    pub(super) fn fields(&mut self, node: &Node, width: u32, of: &str) -> Read<Vec<SignalField>> {
        let mut fields = Vec::new();
        for (name, node) in named(node, "fields")? {
            fields.push(self.field(name, node, width)?);
            self.declare("field", &format!("{of}.{name}"), node.spot);
        }
        if fields.is_empty() { Err(node.wrong("here no field is declared")) } else { Ok(fields) }
    }

    fn field(&self, name: &str, node: &Node, width: u32) -> Read<SignalField> {
        let one = |node: &Node| whole::<u32>(node, "a bit").map(|bit| (bit, bit));
        let keyed = match node.mapping() {
            Some(_) => Some(Keyed::new(node, &field::KEYS)?),
            None => None,
        };
        let (low, high) = match keyed {
            None if node.sequence().is_some() => pair(node, "a group of bits")?,
            None => one(node)?,
            Some(keyed) => match (keyed.get(&field::bit), keyed.get(&field::bits)) {
                (Some(bit), None) => one(bit)?,
                (None, Some(bits)) => pair(bits, "bits")?,
                _ => return Err(node.wrong("a field has either `bit` or `bits`")),
            },
        };
        if high >= width {
            return Err(node.wrong(format!("bit {high} is beyond the {width} bits there are")));
        }
        let (table, counts, signed) = match keyed {
            None => (None, None, false),
            Some(keyed) => (
                keyed.get(&field::words).map(|node| self.table(node)).transpose()?,
                keyed.get(&field::counts).map(|node| pair(node, "counts")).transpose()?,
                flag(keyed, &field::signed)?,
            ),
        };
        let width = high - low + 1;
        if let Some((_, last)) = counts.filter(|(_, last)| u64::from(*last) >= 1u64 << width.min(63)) {
            return Err(node.wrong(format!("{last} does not fit into {width} bits")));
        }
        if let Some((word, _)) =
            table.iter().flat_map(|table| &table.words).find(|(_, number)| i128::from(*number) >= 1i128 << width)
        {
            return Err(node.wrong(format!("the number of `{word}` does not fit into {width} bits")));
        }
        Ok(SignalField { name: name.to_owned(), low, width, signed, words: words_of(table.as_deref()), table, counts })
    }

    fn submodule(&self, name: &str, node: &Node, signals: &[DeviceSignal]) -> Read<DeviceSubmodule> {
        let keyed = Keyed::new(node, &submodule::KEYS)?;
        let (mut output_octets, mut input_octets) = (0, 0);
        if let Some(octets) = keyed.get(&submodule::octets) {
            let octets = Keyed::new(octets, &octets::KEYS)?;
            output_octets = whole::<u16>(octets.must(&octets::out)?, "a length")?;
            input_octets = whole::<u16>(octets.must(&octets::r#in)?, "a length")?;
        }
        let outputs = self.carried(
            keyed,
            &submodule::outputs,
            &submodule::octets,
            SignalSender::Controller,
            signals,
            output_octets,
        );
        let inputs =
            self.carried(keyed, &submodule::inputs, &submodule::octets, SignalSender::Device, signals, input_octets);
        let (outputs, inputs) = both(outputs, inputs)?;
        let ident = whole(keyed.must(&submodule::ident)?, "an ident")?;
        let slot = whole(keyed.must(&submodule::slot)?, "a slot")?;
        let module_idents = match keyed.get(&submodule::module_ident) {
            Some(node) => Some(self.per_variant(node, |node, _| whole(node, "an ident"))?),
            None => (slot == 0).then(|| vec![ident; self.variants.len()]),
        };
        Ok(DeviceSubmodule {
            name: name.to_owned(),
            slot,
            subslot: whole(keyed.must(&submodule::subslot)?, "a subslot")?,
            api: keyed.get(&submodule::api).map_or(Ok(0), |node| whole(node, "an API"))?,
            ident,
            module_idents,
            ident_origin: origin(keyed, &submodule::from_source)?,
            output_octets,
            input_octets,
            outputs,
            inputs,
        })
    }
}

/// The words of a table with their numbers as the wire has them.
pub(super) fn words_of(table: Option<&WordTable>) -> Vec<(String, i128)> {
    table
        .map_or(&[][..], |table| &table.words)
        .iter()
        .map(|(word, number)| (word.clone(), i128::from(*number)))
        .collect()
}

impl DeviceReader<'_> {
    /// The signals after `key`, whose widths together have to be the `octets` of one direction.
    pub(super) fn carried(
        &self,
        keyed: Keyed<'_>,
        key: &Key,
        lengths: &Key,
        from: SignalSender,
        signals: &[DeviceSignal],
        octets: u16,
    ) -> Read<Vec<usize>> {
        let list = keyed.get(key).map_or(Ok(&[][..]), |node| node.items(key.name))?;
        let mut found = Vec::new();
        let mut is_whole = true;
        let mut signal = |node: &Node| {
            let name = plain(node, "a signal")?;
            let Some(index) = signals.iter().position(|signal| signal.name == name) else {
                if self.is_declared(&device::signals, name) {
                    is_whole = false;
                    return Ok(());
                }
                return Err(Mistake::unknown(node.spot, "signal", name, self.declared_names(&device::signals)));
            };
            if signals[index].from != from {
                return Err(node.wrong(format!("`{name}` goes the other way")));
            }
            found.push(index);
            Ok(())
        };
        every(list.iter().map(&mut signal))?;
        let bits: u32 = found.iter().filter_map(|index| signals.get(*index)).map(|signal| signal.width).sum();
        if is_whole && bits != u32::from(octets) * 8 {
            let at = keyed.get(lengths).unwrap_or(keyed.node);
            return Err(at.wrong(format!(
                "the {} have {} bytes by the widths of their signals, but {octets} are written",
                key.name,
                bits / 8
            )));
        }
        Ok(found)
    }

    /// The names in the mapping at the top after `key`, with or without a mistake.
    fn declared_names(&self, key: &Key) -> Vec<&str> {
        let entries = self.top.get(key).and_then(Node::mapping).unwrap_or_default();
        entries.iter().filter_map(|(name, _)| name.scalar()).collect()
    }

    /// Whether the mapping at the top after `key` has this name. If it has and the definition is not known, it has a mistake of its own, and what
    /// refers to it is not called wrong.
    pub(super) fn is_declared(&self, key: &Key, name: &str) -> bool {
        self.top.get(key).is_some_and(|definitions| definitions.get(name).is_some())
    }

    fn module(&self, name: &str, node: &Node, submodules: &[DeviceSubmodule]) -> Read<DeviceModule> {
        let keyed = Keyed::new(node, &module::KEYS)?;
        let list = keyed.must(&module::submodules)?;
        let mut found = Vec::new();
        let mut is_whole = true;
        let mut submodule = |node: &Node| {
            let name = plain(node, "a submodule")?;
            match submodules.iter().position(|submodule| submodule.name == name) {
                Some(index) if found.contains(&index) => return Err(node.wrong(format!("`{name}` stands twice"))),
                Some(index) => found.push(index),
                None if self.is_declared(&device::submodules, name) => is_whole = false,
                None => {
                    return Err(Mistake::unknown(
                        node.spot,
                        "submodule",
                        name,
                        self.declared_names(&device::submodules),
                    ));
                }
            }
            Ok(())
        };
        every(list.items("submodules")?.iter().map(&mut submodule))?;
        if found.is_empty() && is_whole {
            return Err(list.wrong("a module without submodules"));
        }
        let ident = whole(keyed.must(&module::ident)?, "an ident")?;
        let absent = keyed.get(&module::absent).map(|node| node.text("a reason").map(str::to_owned)).transpose()?;
        let module = DeviceModule::on_profinet(name, ident, origin(keyed, &module::from_source)?, found);
        Ok(DeviceModule { absent, ..module })
    }
}
