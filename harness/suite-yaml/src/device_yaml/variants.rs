//! How the variants of a manual are distinguished: the names after `variant_identification`.

use super::super::error::{Mistake, Read};
use super::super::keys::{Key, Keyed};
use super::super::yaml::Node;
use super::{DeviceReader, device, named, whole};
use expression::Type;
use std::sync::Arc;
use suite::device::{
    DeviceParameter, DeviceRecord, DeviceSignal, DiagnosisLayout, ExpectedNumber, SignalSender, VariantIdentification,
    VariantValue, VariantValueSource,
};

key_set! {
    pub(crate) variant_identification "variant_identification" {
        question must Text, "The question to a person who has the device, where its variant stays open.";
        called may PerVariant(&NonEmpty(&Text)), "Words of each variant in order numbers (I&M0) and in the names of access points, modules and models of descriptions.";
        starts may NonEmpty(&Map(&Scalar)), "The start-ups after which the values are read, one after the other until one decides: start parameters, all others have their defaults.";
        values may Names(&PerVariant(&NonEmpty(&Whole(i64::MIN as i128, i64::MAX as i128)))), "Elements of parameters and fields of the diagnosis (`diag.NAME`), with the numbers that each variant can report.";
        below may NonEmptyMap(&PerVariant(&Scalar)), "Inputs that are always below this number after these start-ups: a larger position excludes the variant.";
    }
}

/// What the names after `values` and `below` refer to.
pub(super) struct IdentifyingNames<'d> {
    pub signals: &'d [DeviceSignal],
    pub records: &'d [DeviceRecord],
    pub parameters: &'d [DeviceParameter],
    pub diagnosis: Option<&'d DiagnosisLayout>,
}

impl DeviceReader<'_> {
    pub(super) fn variant_identification(&self, of: &IdentifyingNames<'_>) -> Read<VariantIdentification> {
        let Some(node) = self.top.get(&device::variant_identification) else {
            return Ok(VariantIdentification::default());
        };
        let keyed = Keyed::new(node, &variant_identification::KEYS)?;
        let question = keyed.must(&variant_identification::question)?.text("a question")?.to_owned();
        let words = |node: &Node, _| -> Read<Vec<String>> {
            node.items("called")?.iter().map(|item| Ok(item.text("a word")?.to_owned())).collect()
        };
        let called =
            keyed.get(&variant_identification::called).map_or(Ok(Vec::new()), |node| self.per_variant(node, words))?;
        let entries = |key: &Key| keyed.get(key).map_or(Ok(Vec::new()), |node| named(node, key.name));
        let starts = keyed.get(&variant_identification::starts).map(|node| node.items("starts")).transpose()?;
        let start = |node: &Node| -> Read<Vec<(String, i128)>> {
            let number =
                |(name, value): (&str, &Node)| Ok((name.to_owned(), self.identifying_start(name, value, of.records)?));
            named(node, "a start-up")?.into_iter().map(number).collect()
        };
        let starts = starts.unwrap_or_default().iter().map(start).collect::<Read<_>>()?;
        let mut values = Vec::new();
        let reads = keyed.get(&variant_identification::values).map(|node| node.entries("values")).transpose()?;
        for (key, node) in reads.unwrap_or_default() {
            let name = key.text("a name")?;
            let source = reported(name, key, of)?;
            let numbers = |node: &Node, _| -> Read<ExpectedNumber> {
                let numbers = node.items("numbers")?.iter().map(|item| whole::<i128>(item, "a number"));
                Ok(ExpectedNumber::OneOf(numbers.collect::<Read<_>>()?))
            };
            values.push(VariantValue { name: name.to_owned(), source, expected: self.per_variant(node, numbers)? });
        }
        for (name, node) in entries(&variant_identification::below)? {
            let source = input(name, node, of.signals)?;
            let limits = self.default(node, &Type::whole(64, false))?;
            let expected = limits.into_iter().map(ExpectedNumber::Below).collect();
            values.push(VariantValue { name: name.to_owned(), source, expected });
        }
        Ok(VariantIdentification { question, called, starts, values })
    }

    /// The number of a start parameter.
    fn identifying_start(&self, name: &str, value: &Node, records: &[DeviceRecord]) -> Read<i128> {
        let starts = || records.iter().filter(|record| record.start);
        let found = starts().find_map(|record| Some((record, record.fields.iter().find(|field| field.name == name)?)));
        let Some((record, field)) = found else {
            let known = starts().flat_map(|record| &record.fields).map(|field| field.name.as_str());
            return Err(Mistake::unknown(value.spot, "start parameter", name, known));
        };
        self.mentioned.borrow_mut().push(format!("field `{}.{name}`", record.name));
        let width = field.bits.map_or(field.octets as u32 * 8, |(_, width)| width);
        let ty = match &field.table {
            Some(table) => Type::Word(Arc::clone(table)),
            None => Type::whole(width, false),
        };
        let number = self.default(value, &ty)?;
        number.first().copied().ok_or_else(|| value.wrong("this is no value"))
    }
}

/// The source of a value that a device reports on request.
fn reported(name: &str, key: &Node, of: &IdentifyingNames<'_>) -> Read<VariantValueSource> {
    let elements = of.parameters.iter().flat_map(|parameter| {
        let named = |(element, subindex): &(String, u16)| (format!("P{}.{element}", parameter.number), *subindex);
        let whole = parameter.elements.is_empty().then(|| (format!("P{}", parameter.number), 0));
        parameter
            .elements
            .iter()
            .map(named)
            .chain(whole)
            .map(|(name, subindex)| (name, VariantValueSource::Parameter { number: parameter.number, subindex }))
    });
    let fields = of.diagnosis.into_iter().flat_map(|layout| layout.fields.iter().enumerate());
    let fields = fields.map(|(index, field)| (format!("diag.{}", field.name), VariantValueSource::Diagnosis(index)));
    let known: Vec<(String, VariantValueSource)> = elements.chain(fields).collect();
    match known.iter().find(|(known, _)| known == name) {
        Some((_, source)) => Ok(*source),
        None => {
            let names = known.iter().map(|(known, _)| known.as_str());
            Err(Mistake::unknown(key.spot, "element of a parameter or field of the diagnosis", name, names))
        }
    }
}

/// The input with this name.
fn input(name: &str, node: &Node, signals: &[DeviceSignal]) -> Read<VariantValueSource> {
    let inputs = || signals.iter().enumerate().filter(|(_, signal)| signal.from == SignalSender::Device);
    match inputs().find(|(_, signal)| signal.name == name) {
        Some((index, _)) => Ok(VariantValueSource::Input(index)),
        None => Err(Mistake::unknown(node.spot, "input", name, inputs().map(|(_, signal)| signal.name.as_str()))),
    }
}
