//! What only a `device.yaml` of PROFIBUS has: identifiers, Set_Prm, Slave_Diag.

use super::super::error::{Mistake, Read};
use super::super::keys::{self, Keyed};
use super::super::yaml::Node;
use super::cyclic::{Wired, WiredSlave, carried};
use super::{Counted, Place, Reader, flag, named, origin, place, plain, sourced, whole};
use expression::{Type, Value, WordTable};
use std::sync::Arc;
use suite::device::{
    DeviceModule, DeviceRecord, DeviceSignal, DeviceSubmodule, DiagnosisBlocks, DiagnosisField, DiagnosisLayout,
    DiagnosisName, NUMBER_OCTETS, Origin, SignalSender, UserPrmLayout,
};
use wire::profibus::cfg::{self, Identifier};
use wire::profibus::diag::SlaveDiag;

/// The code tables of a device.
type Codes = [(String, Vec<(String, u32)>)];

/// The most octets of Set_Prm behind its seven.
const USER_OCTETS: usize = 237;

impl<'n> Reader<'n> {
    /// What a slave has: signals, one synthetic submodule for each module, the record of its user octets, its diagnosis.
    pub(super) fn slave(&mut self, codes: &Codes) -> Read<Wired> {
        let before = self.mistakes.count();
        let address = self.address()?;
        let signals = self.signals();
        let (set_prm, record) = self.set_prm()?;
        let diagnosis = self.diagnosis(codes)?;
        let (mut submodules, mut modules) = (Vec::new(), Vec::new());
        for (name, node) in self.entries("modules") {
            self.declare("module", name, node.spot);
            if self.mistakes.count() > before {
                continue;
            }
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
        let keyed = Keyed::new(self.top.must("identity")?, &keys::SLAVE_IDENTITY)?;
        let (ident, origin) = sourced(keyed.must("ident")?)?;
        Ok((whole(ident, "the ident number")?, origin))
    }

    fn address(&self) -> Read<u8> {
        let node = self.top.must("address")?;
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
        let keyed = Keyed::new(node, &keys::SLAVE_MODULE)?;
        let octets = Keyed::new(keyed.must("octets")?, &keys::OCTETS)?;
        let (output_octets, input_octets) =
            (whole::<u16>(octets.must("out")?, "a length")?, whole::<u16>(octets.must("in")?, "a length")?);
        let outputs = carried(keyed, "outputs", SignalSender::Controller, signals, output_octets)?;
        let inputs = carried(keyed, "inputs", SignalSender::Device, signals, input_octets)?;
        let cfg_node = keyed.must("cfg")?;
        let cfg = known_octets(cfg_node)?;
        let sums = Identifier::parse_all(&cfg).map(|identifiers| cfg::io_lengths(&identifiers));
        match sums {
            Err(error) => return Err(cfg_node.wrong(format!("these are no identifiers: {error}"))),
            Ok(sums) if (sums.outputs, sums.inputs) != (output_octets.into(), input_octets.into()) => {
                return Err(cfg_node.wrong(format!(
                    "these identifiers have {} octets of outputs and {} of inputs, but {output_octets} and {input_octets} are written",
                    sums.outputs, sums.inputs
                )));
            }
            Ok(_) => {}
        }
        let origin = origin(keyed)?;
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
        let fixes = keyed.get("fixes").map_or(Ok(Vec::new()), |node| self.fixes(node, record))?;
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

    /// Set_Prm; a slave that has nothing to parameterise has no octets.
    fn set_prm(&mut self) -> Read<(UserPrmLayout, DeviceRecord)> {
        let mut record = DeviceRecord {
            name: UserPrmLayout::NAME.to_owned(),
            index: 0,
            at: 0,
            octets: 0,
            start: true,
            with: None,
            fields: Vec::new(),
            origin: Origin::Manual,
        };
        let Some(node) = self.top.get("set_prm") else {
            return Ok((UserPrmLayout { dpv1: None, structured: false }, record));
        };
        let keyed = Keyed::new(node, &keys::SET_PRM)?;
        let dpv1 = keyed.get("dpv1").map(|node| {
            <[u8; 3]>::try_from(known_octets(node)?).map_err(|_| node.wrong("DP-V1 has three octets in Set_Prm"))
        });
        let (dpv1, structured) = (dpv1.transpose()?, flag(keyed, "structured")?);
        if let (None, Some(key)) = (dpv1, keyed.key("structured")) {
            return Err(key
                .wrong("structured blocks stand behind the octets of DP-V1")
                .help("write `dpv1: \"80 00 00\"`"));
        }
        let octets = keyed.must("octets")?;
        record.octets = whole(octets, "a length")?;
        if record.octets > USER_OCTETS {
            return Err(octets.wrong(format!("behind its seven octets Set_Prm has at most {USER_OCTETS}")));
        }
        record.origin = origin(keyed)?;
        for (name, node) in named(keyed.must("fields")?, "fields")? {
            self.declare("field", &format!("{}.{name}", UserPrmLayout::NAME), node.spot);
            let field = self.record_field(name, node, record.octets)?;
            record.fields.push(field);
        }
        Ok((UserPrmLayout { dpv1, structured }, record))
    }

    fn diagnosis(&mut self, codes: &Codes) -> Read<DiagnosisLayout> {
        let keyed = Keyed::new(self.top.must("diagnosis")?, &keys::DIAGNOSIS)?;
        let list = keyed.must("octets")?;
        let lengths: Vec<usize> =
            list.items("octets")?.iter().map(|node| whole(node, "a length")).collect::<Read<_>>()?;
        let room = SlaveDiag::HEAD..=SlaveDiag::LONGEST;
        if lengths.is_empty()
            || !lengths.is_sorted_by(|one, next| one < next)
            || !lengths.iter().all(|of| room.contains(of))
        {
            return Err(list.wrong("the lengths of a diagnosis go up, and are 6 to 244 octets"));
        }
        let blocks = match keyed.get("blocks") {
            Some(_) if lengths.len() != 2 => {
                return Err(list.wrong("with `blocks` there are two lengths").help("write [shortest, longest]"));
            }
            Some(node) => Some(blocks(node, codes)?),
            None => None,
        };
        let longest = lengths.last().copied().unwrap_or(SlaveDiag::HEAD);
        let mut fields = Vec::new();
        if let Some(node) = keyed.get("fields") {
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
        let keyed = Keyed::new(node, &keys::DIAGNOSIS_FIELD)?;
        let Place { first, octets, bits } = place(keyed, &Counted::BYTES, longest)?;
        let signed = flag(keyed, "signed")?;
        let table = keyed.get("words").map(|node| self.table(node)).transpose()?;
        if octets > NUMBER_OCTETS && (signed || table.is_some()) {
            return Err(node.wrong("more than eight bytes are no number").help("leave out `signed` and `words`"));
        }
        Ok(DiagnosisField { name: name.to_owned(), octet: first, octets, bits, signed, table, origin: origin(keyed)? })
    }
}

fn blocks(node: &Node, codes: &Codes) -> Read<DiagnosisBlocks> {
    let keyed = Keyed::new(node, &keys::DIAGNOSIS_BLOCKS)?;
    let bytes = keyed.must("bytes")?;
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
    let code = keyed.must("code")?;
    let name = plain(code, "a table of codes")?;
    let Some((_, words)) = codes.iter().find(|(known, _)| known == name) else {
        return Err(Mistake::unknown(code.spot, "table of codes", name, codes.iter().map(|(known, _)| known.as_str())));
    };
    let words = words.iter().map(|(word, number)| (word.clone(), i64::from(*number)));
    let after = whole(keyed.must("after")?, "a number of bytes")?;
    Ok(DiagnosisBlocks { after, pattern, table: WordTable::new(name, words) })
}

fn literal(node: &Node) -> Read<Value> {
    let text = node.text("octets")?;
    if node.plain().is_some() {
        return Err(node.wrong("octets stand in quotes").help(format!("write \"{text}\"")));
    }
    expression::literal(text, &Type::Bytes).map_err(|error| Mistake::expression(node.spot, node.lead(), text, error))
}

/// Octets without an open part.
fn known_octets(node: &Node) -> Read<Vec<u8>> {
    match literal(node)? {
        Value::Bytes(bytes) => Ok(bytes.to_vec()),
        _ => Err(node.wrong("here every octet is written")),
    }
}
