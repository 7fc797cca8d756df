//! What only a `device.yaml` of PROFIBUS has: identifiers, Set_Prm, Slave_Diag.

use super::super::error::{Mistake, Read, both};
use super::super::keys::{Keyed, Pattern};
use super::super::yaml::Node;
use super::changes::changed;
use super::cyclic::{Wired, WiredSlave};
use super::cyclic::{octets, signal};
use super::plain::{FieldKeys, FieldPosition, ORIGINS, position};
use super::rest::{codes, parameter, record_field, slave_parameter_access, stand};
use super::times::{ours, printed};
use super::variants::variant_identification;
use super::{DeviceReader, flag, named, origin, plain, sourced, whole};
use expression::{Type, Value, WordTable};
use std::sync::Arc;
use suite::device::{
    DeviceModule, DeviceRecord, DeviceSignal, DeviceSubmodule, DiagnosisBlocks, DiagnosisField, DiagnosisLayout,
    DiagnosisName, NUMBER_OCTETS, Origin, SignalSender, UserPrmLayout,
};
use wire::profibus::cfg::{self, Identifier};
use wire::profibus::diag::SlaveDiag;

/// Bytes with exactly one `..`.
static ONE_OPEN: Pattern = Pattern { regex: r"^([0-9A-F]{2} )*\.\.( [0-9A-F]{2})*$" };

key_set! {
    pub(crate) slave "device.yaml of a device on PROFIBUS" {
        encspec may Pattern(&crate::needed_version::VERSIONS), "The versions of encspec that can read this file, for instance `>=0.2`.";
        device must Text, "The name of the folder.";
        bus must Only("profibus"), "The bus.";
        title must Text, "The title for people.";
        identity must Keys(&slave_identity::KEYS), "Who it is.";
        address must Whole(0, 126), "The station address that a trial finds it at, as its switches are then.";
        variants must NonEmpty(&Label), "The variants.";
        timing may Map(&QuantityOr(&ours::KEYS)), "Times of ours, since the manual prints none: those that every manual has, with other values, and others.";
        tolerance may Map(&QuantityOr(&ours::KEYS)), "Tolerances of ours, numbers.";
        printed may Map(&Keys(&printed::KEYS)), "Times and tolerances that the manual prints.";
        constants may Map(&PerVariant(&Number)), "One number, or one for each variant.";
        words may Map(&WordTable), "Tables of words and their numbers.";
        derived may Map(&Condition), "Expressions over start parameters and constants.";
        signals must Map(&Keys(&signal::KEYS)), "What goes over the cyclic exchange.";
        modules must Map(&Keys(&slave_module::KEYS)), "What one connection consists of.";
        set_prm may Keys(&set_prm::KEYS), "The bytes of Set_Prm after the seven that every slave has.";
        diagnosis must Keys(&diagnosis::KEYS), "What Slave_Diag contains beyond what every slave has.";
        parameters may Map(&Keys(&parameter::KEYS)), "Parameters of the base mode parameter access.";
        parameter_access may Keys(&slave_parameter_access::KEYS), "How the parameters are reached, where it is not data set 47 of slot 0.";
        codes may Keys(&codes::KEYS), "Code tables of the manual.";
        stand may Keys(&stand::KEYS), "What a stand can do with it.";
        roles may Map(&List(&Name)), "Device-independent names.";
        changes may Keys(&changed::KEYS), "What changes the device for good.";
        variant_identification may Keys(&variant_identification::KEYS), "How a device shows which variant it is.";
    }
}

key_set! {
    pub(crate) slave_identity "identity on PROFIBUS" {
        ident must Sourced(&Whole(0, 0xFFFF)), "The ident number that PI gave to the type of device.";
    }
}

key_set! {
    pub(crate) slave_module "a module on PROFIBUS" {
        cfg must Octets, "The identifiers that Chk_Cfg sends for it.";
        octets must Keys(&octets::KEYS), "Lengths of its cyclic data.";
        outputs may List(&Name), "Signals of its output data in order.";
        inputs may List(&Name), "Signals of its input data in order.";
        fixes may Map(&PerVariant(&Scalar)), "Start parameters that go with it where a case does not say them.";
        from_source may Word(&ORIGINS), "Where its identifiers come from if the manual does not print them.";
    }
}

key_set! {
    pub(crate) set_prm "set_prm" {
        octets must Whole(0, 237), "The number of user bytes after those of DP-V1.";
        dpv1 may OctetsOf(3), "The three bytes of DP-V1 that a connection sends; left out where the slave has none.";
        structured may Flag, "The slave takes structured blocks, which isochronous mode needs.";
        fields must Map(&Keys(&record_field::KEYS)), "The fields of the user bytes: the start parameters.";
        from_source may Word(&ORIGINS), "Where the layout comes from if the manual does not print it.";
    }
}

key_set! {
    pub(crate) diagnosis "diagnosis" {
        octets must NonEmpty(&Whole(6, 244)), "The lengths that it can have; with `blocks` the shortest and the longest.";
        fields may Map(&Keys(&diagnosis_field::KEYS)), "Fields at fixed places.";
        blocks may Keys(&diagnosis_blocks::KEYS), "Blocks that are all alike, one for each error.";
    }
}

key_set! {
    pub(crate) diagnosis_field "a field of the diagnosis" {
        byte may Whole(0, 243), "The byte it lies in, counted from 0 at the first of the six that every slave has.";
        bytes may Pair(0, 243), "Its first and its last byte.";
        bit may Whole(0, 7), "Its bit in the byte.";
        bits may Pair(0, 7), "Its lowest and its highest bit in the byte.";
        signed may Flag, "It is a two's complement.";
        words may Name, "The table of its words.";
        from_source may Word(&ORIGINS), "Where its place comes from if the manual does not print it.";
    } [OneOf(&[&byte, &bytes]), NotBoth(&bit, &bits)]
}

key_set! {
    pub(crate) diagnosis_blocks "blocks of the diagnosis" {
        after must Whole(0, 0xFFFF), "How many bytes stand before the first one.";
        bytes must Pattern(&ONE_OPEN), "The bytes of one; `..` where the code stands.";
        code must Name, "The table of `codes` with the words for the codes.";
    }
}

/// The code tables of a device.
type Codes = [(String, Vec<(String, u32)>)];

/// The most bytes of Set_Prm after its first seven.
const USER_OCTETS: usize = 237;

impl<'n> DeviceReader<'n> {
    /// What a slave has: signals, one synthetic submodule for each module, the record of its user bytes, its diagnosis.
    pub(super) fn slave(&mut self, codes: &Codes) -> Read<Wired> {
        let signals = self.signals();
        let facts = both(both(self.address(), self.set_prm()), self.diagnosis(codes));
        let ((address, (set_prm, record)), diagnosis) = facts?;
        let (mut submodules, mut modules) = (Vec::new(), Vec::new());
        for (name, node) in self.entries(&slave::modules) {
            self.declare("module", name, node.spot);
            if let Some((submodule, module)) =
                self.mistakes.keep(self.slave_module(name, node, &signals, &record, modules.len()))
            {
                submodules.push(submodule);
                modules.push(module);
            }
        }
        let slave = Some(WiredSlave { address, set_prm, diagnosis });
        Ok(Wired { signals, submodules, modules, records: vec![record], slave })
    }

    /// Ident number and its origin.
    pub(super) fn ident(&self) -> Read<(u16, Origin)> {
        let keyed = Keyed::new(self.top.must(&slave::identity)?, &slave_identity::KEYS)?;
        let (ident, origin) = sourced(keyed.must(&slave_identity::ident)?)?;
        Ok((whole(ident, "the ident number")?, origin))
    }

    fn address(&self) -> Read<u8> {
        let node = self.top.must(&slave::address)?;
        match whole::<u8>(node, "a station address")? {
            address @ 0..=126 => Ok(address),
            other => Err(node.wrong(format!("{other} is no station address")).help("write 0 to 126")),
        }
    }

    fn slave_module(
        &self,
        name: &str,
        node: &Node,
        signals: &[DeviceSignal],
        record: &DeviceRecord,
        index: usize,
    ) -> Read<(DeviceSubmodule, DeviceModule)> {
        let keyed = Keyed::new(node, &slave_module::KEYS)?;
        let octets = Keyed::new(keyed.must(&slave_module::octets)?, &octets::KEYS)?;
        let (output_octets, input_octets) = (
            whole::<u16>(octets.must(&octets::out)?, "a length")?,
            whole::<u16>(octets.must(&octets::r#in)?, "a length")?,
        );
        let outputs = self.carried(
            keyed,
            &slave_module::outputs,
            &slave_module::octets,
            SignalSender::Controller,
            signals,
            output_octets,
        );
        let inputs = self.carried(
            keyed,
            &slave_module::inputs,
            &slave_module::octets,
            SignalSender::Device,
            signals,
            input_octets,
        );
        let (outputs, inputs) = both(outputs, inputs)?;
        let cfg_node = keyed.must(&slave_module::cfg)?;
        let cfg = known_octets(cfg_node)?;
        let sums = Identifier::parse_all(&cfg).map(|identifiers| cfg::io_lengths(&identifiers));
        match sums {
            Err(error) => return Err(cfg_node.wrong(format!("these are no identifiers: {error}"))),
            Ok(sums) if (sums.outputs, sums.inputs) != (output_octets.into(), input_octets.into()) => {
                return Err(cfg_node.wrong(format!(
                    "these identifiers have {} bytes of outputs and {} of inputs, but {output_octets} and {input_octets} are written",
                    sums.outputs, sums.inputs
                )));
            }
            Ok(_) => {}
        }
        let origin = origin(keyed, &slave_module::from_source)?;
        let submodule = DeviceSubmodule {
            name: name.to_owned(),
            slot: 1,
            subslot: 1,
            api: 0,
            ident: index as u32,
            module_idents: None,
            ident_origin: origin,
            output_octets,
            input_octets,
            outputs,
            inputs,
        };
        let fixes = keyed.get(&slave_module::fixes).map_or(Ok(Vec::new()), |node| self.fixes(node, record))?;
        let module = DeviceModule::on_profibus(name, (cfg, fixes), origin, vec![index]);
        Ok((submodule, module))
    }

    fn fixes(&self, node: &Node, record: &DeviceRecord) -> Read<Vec<(usize, i128)>> {
        let fix = |(name, value): (&str, &Node)| {
            let Some(index) = record.fields.iter().position(|field| field.name == name) else {
                let known = record.fields.iter().map(|field| field.name.as_str());
                return Err(Mistake::unknown(node.key(name).spot, "start parameter", name, known));
            };
            self.mentioned.borrow_mut().push(format!("field `{}.{name}`", UserPrmLayout::NAME));
            let field = &record.fields[index];
            let width = field.bits.map_or(field.octets as u32 * 8, |(_, width)| width);
            let ty = match &field.table {
                Some(table) => Type::Word(Arc::clone(table)),
                None => Type::whole(width, false),
            };
            let number = self.default(value, &ty)?;
            number.first().map(|number| (index, *number)).ok_or_else(|| value.wrong("this is no value"))
        };
        named(node, "fixes")?.into_iter().map(fix).collect()
    }

    /// Set_Prm; a slave that has nothing to parameterise has no bytes.
    fn set_prm(&mut self) -> Read<(UserPrmLayout, DeviceRecord)> {
        let mut record = DeviceRecord {
            name: UserPrmLayout::NAME.to_owned(),
            index: 0,
            at: 0,
            octets: 0,
            start: true,
            with: None,
            fields: Vec::new(),
            template: Vec::new(),
            origin: Origin::Manual,
        };
        let Some(node) = self.top.get(&slave::set_prm) else {
            return Ok((UserPrmLayout { dpv1: None, structured: false }, record));
        };
        let keyed = Keyed::new(node, &set_prm::KEYS)?;
        let dpv1 = keyed.get(&set_prm::dpv1).map(|node| {
            <[u8; 3]>::try_from(known_octets(node)?).map_err(|_| node.wrong("DP-V1 has three bytes in Set_Prm"))
        });
        let (dpv1, structured) = (dpv1.transpose()?, flag(keyed, &set_prm::structured)?);
        if let (None, Some(key)) = (dpv1, keyed.key(&set_prm::structured)) {
            return Err(key.wrong("structured blocks follow the bytes of DP-V1").help("write `dpv1: \"80 00 00\"`"));
        }
        let octets = keyed.must(&set_prm::octets)?;
        record.octets = whole(octets, "a length")?;
        if record.octets > USER_OCTETS {
            return Err(octets.wrong(format!("Set_Prm has at most {USER_OCTETS} bytes after its first seven")));
        }
        record.origin = origin(keyed, &set_prm::from_source)?;
        for (name, node) in named(keyed.must(&set_prm::fields)?, "fields")? {
            self.declare("field", &format!("{}.{name}", UserPrmLayout::NAME), node.spot);
            let field = self.record_field(name, node, record.octets)?;
            record.fields.push(field);
        }
        Ok((UserPrmLayout { dpv1, structured }, record))
    }

    fn diagnosis(&mut self, codes: &Codes) -> Read<DiagnosisLayout> {
        let keyed = Keyed::new(self.top.must(&slave::diagnosis)?, &diagnosis::KEYS)?;
        let list = keyed.must(&diagnosis::octets)?;
        let lengths: Vec<usize> =
            list.items("octets")?.iter().map(|node| whole(node, "a length")).collect::<Read<_>>()?;
        let room = SlaveDiag::HEAD..=SlaveDiag::LONGEST;
        if lengths.is_empty()
            || !lengths.is_sorted_by(|one, next| one < next)
            || !lengths.iter().all(|of| room.contains(of))
        {
            return Err(list.wrong("the lengths of a diagnosis go up, and are 6 to 244 bytes"));
        }
        let blocks = match keyed.get(&diagnosis::blocks) {
            Some(_) if lengths.len() != 2 => {
                return Err(list.wrong("with `blocks` there are two lengths").help("write [shortest, longest]"));
            }
            Some(node) => Some(blocks(node, codes)?),
            None => None,
        };
        let longest = lengths.last().copied().unwrap_or(SlaveDiag::HEAD);
        let mut fields = Vec::new();
        if let Some(node) = keyed.get(&diagnosis::fields) {
            for (name, node) in named(node, "fields")? {
                if DiagnosisName::by_word(name).is_some() {
                    return Err(node
                        .wrong(format!("every slave has `diag.{name}`"))
                        .help("give the field another name"));
                }
                self.declare("field", &format!("diag.{name}"), node.spot);
                fields.push(self.diagnosis_field(name, node, longest)?);
            }
        }
        Ok(DiagnosisLayout { lengths, fields, blocks })
    }

    fn diagnosis_field(&self, name: &str, node: &Node, longest: usize) -> Read<DiagnosisField> {
        let keyed = Keyed::new(node, &diagnosis_field::KEYS)?;
        let FieldPosition { first, octets, bits } = position(keyed, &BYTES, longest)?;
        let signed = flag(keyed, &diagnosis_field::signed)?;
        let table = keyed.get(&diagnosis_field::words).map(|node| self.table(node)).transpose()?;
        if octets > NUMBER_OCTETS && (signed || table.is_some()) {
            return Err(node.wrong("more than eight bytes are no number").help("leave out `signed` and `words`"));
        }
        Ok(DiagnosisField {
            name: name.to_owned(),
            octet: first,
            octets,
            bits,
            signed,
            table,
            origin: origin(keyed, &diagnosis_field::from_source)?,
        })
    }
}

/// The keys of a position in a diagnosis.
const BYTES: FieldKeys = FieldKeys {
    one: &diagnosis_field::byte,
    many: &diagnosis_field::bytes,
    bit: &diagnosis_field::bit,
    bits: &diagnosis_field::bits,
    whole: "diagnosis",
};

fn blocks(node: &Node, codes: &Codes) -> Read<DiagnosisBlocks> {
    let keyed = Keyed::new(node, &diagnosis_blocks::KEYS)?;
    let bytes = keyed.must(&diagnosis_blocks::bytes)?;
    let pattern = match literal(bytes)? {
        Value::Pattern(pattern) => pattern.places(),
        _ => None,
    };
    let pattern = pattern.filter(|octets| octets.iter().filter(|octet| octet.is_none()).count() == 1);
    let Some(pattern) = pattern else {
        return Err(bytes
            .wrong("the bytes of a block have one `..`, where the code stands")
            .help("write \"81 40 ..\""));
    };
    let code = keyed.must(&diagnosis_blocks::code)?;
    let name = plain(code, "a table of codes")?;
    let Some((_, words)) = codes.iter().find(|(known, _)| known == name) else {
        return Err(Mistake::unknown(code.spot, "table of codes", name, codes.iter().map(|(known, _)| known.as_str())));
    };
    let words = words.iter().map(|(word, number)| (word.clone(), i64::from(*number)));
    let after = whole(keyed.must(&diagnosis_blocks::after)?, "a number of bytes")?;
    Ok(DiagnosisBlocks { after, pattern, table: WordTable::new(name, words) })
}

fn literal(node: &Node) -> Read<Value> {
    let text = node.text("octets")?;
    if node.plain().is_some() {
        return Err(node.wrong("bytes stand in quotes").help(format!("write \"{text}\"")));
    }
    expression::literal(text, &Type::Bytes).map_err(|error| Mistake::expression(node.spot, node.lead(), text, error))
}

/// Bytes without an open part.
fn known_octets(node: &Node) -> Read<Vec<u8>> {
    match literal(node)? {
        Value::Bytes(bytes) => Ok(bytes.to_vec()),
        _ => Err(node.wrong("here every byte is written")),
    }
}
