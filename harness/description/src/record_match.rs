//! A start record of a manual in a record of a description: which parameters were found, and the layout that follows.

use crate::start_parameters::{DescribedParameter, ParameterDoubt, ParameterMatch, find};
use suite::device::{DeviceRecord, Origin, RecordField};

/// A start parameter of the manual, and what was found for it in a description.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FoundParameter {
    /// Its name in `device.yaml`.
    pub field: String,
    /// The name of the parameter of the description, and its place in words.
    pub described: Option<(String, String)>,
    /// Why it is not used.
    pub doubt: Option<String>,
}

/// The parameters of a record of the manual in those of a description.
pub(crate) struct RecordMatch {
    described: Vec<DescribedParameter>,
    matches: Vec<ParameterMatch>,
}

impl RecordMatch {
    /// Finds the parameters of `record`; `confirmed` is that of [`find`].
    pub(crate) fn find(
        record: &DeviceRecord,
        described: Vec<DescribedParameter>,
        confirmed: &[(String, String)],
    ) -> RecordMatch {
        let matches = find(&record.fields, &described, confirmed);
        RecordMatch { described, matches }
    }

    /// How many parameters were found without a doubt.
    pub(crate) fn found(&self) -> usize {
        self.matches.iter().filter(|of| of.doubt.is_none()).count()
    }

    /// A line for each parameter of the manual.
    pub(crate) fn lines(&self, record: &DeviceRecord) -> Vec<FoundParameter> {
        let line = |of: &ParameterMatch| FoundParameter {
            field: record.fields[of.field].name.clone(),
            described: self.described(of).map(|known| (known.name().to_owned(), known.place())),
            doubt: of.doubt.as_ref().map(ToString::to_string),
        };
        self.matches.iter().map(line).collect()
    }

    /// The parameters that were not found, each with the reason, and what to do; `None` if all were found.
    pub(crate) fn doubts(&self, record: &DeviceRecord) -> Option<String> {
        let doubts = self.matches.iter().filter_map(|of| {
            let (name, doubt) = (&record.fields[of.field].name, of.doubt.as_ref()?);
            Some(match self.described(of) {
                Some(known) => format!("{name} (`{}`): {doubt}", known.name().escape_debug()),
                None => format!("{name}: {doubt}"),
            })
        });
        let doubts = joined(doubts)?;
        let has_other = |of: &ParameterMatch| matches!(of.doubt, Some(ParameterDoubt::OtherMeaning { .. }));
        let how = match self.matches.iter().all(|of| of.doubt.is_none() || has_other(of)) {
            true => {
                "no line of `start_parameters` can decide that: ask the vendor, and correct the description if it is wrong"
            }
            false => "decide by `start_parameters` in the bench file",
        };
        Some(format!("{doubts}; {how}"))
    }

    /// Where a printed layout and the description contradict each other; `None` if they do not.
    pub(crate) fn contradictions(&self, record: &DeviceRecord) -> Option<String> {
        joined(self.matches.iter().filter_map(|of| {
            let field = record.fields.get(of.field).filter(|field| field.origin == Origin::Manual)?;
            self.contradiction(of, field)
        }))
    }

    /// The parameter is elsewhere in the description, or its values have another meaning.
    fn contradiction(&self, of: &ParameterMatch, field: &RecordField) -> Option<String> {
        let known = self.described(of)?;
        if let Some(doubt @ ParameterDoubt::OtherMeaning { .. }) = &of.doubt {
            return Some(format!("{}: in the description {doubt}", field.name));
        }
        let own = DescribedParameter::at(field);
        let bits = |of: &DescribedParameter| (of.octet, of.bits.unwrap_or((0, of.width())));
        let (name, other) = (&field.name, known.place());
        (bits(&own) != bits(known))
            .then(|| format!("{name} is at {} in the manual, and at {other} in the description", own.place()))
    }

    /// Gives the record of the manual the layout of the description, with the bytes `default` before any parameter is set: what only
    /// the description has keeps its default.
    pub(crate) fn take_over(&self, record: &mut DeviceRecord, default: &[u8]) {
        record.octets = default.len();
        record.template = default.to_vec();
        record.origin = Origin::Description;
        for of in &self.matches {
            let (Some(field), Some(known)) = (record.fields.get_mut(of.field), self.described(of)) else { continue };
            (field.octet, field.octets, field.bits) = (known.octet, known.octets, known.bits);
            field.origin = Origin::Description;
        }
    }

    fn described(&self, of: &ParameterMatch) -> Option<&DescribedParameter> {
        self.described.get(of.described?)
    }
}

fn joined(texts: impl Iterator<Item = String>) -> Option<String> {
    let texts: Vec<String> = texts.collect();
    (!texts.is_empty()).then(|| texts.join("; "))
}
