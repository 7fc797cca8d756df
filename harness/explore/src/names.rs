//! The names of a manual that a sequence sets, writes and reads, with the values that each can have.

use crate::draw::Draw;
use compare::action::{ConnectAction, span};
use compare::conversation::SuiteValue;
use std::collections::BTreeSet;
use suite::device::{DeviceDescription, DeviceSignal, NameKind, RecordField, SignalField, SignalForm};
use suite::model::{ConnectionStart, Manual, SetValue, Setting, SuiteVariant, TrialStep, Verb};
use suite::scan;

/// Everything that is drawn from.
pub(crate) struct SequenceNames {
    pub on_profinet: bool,
    pub modules: Vec<ModuleNames>,
    /// Connections of the cases.
    pub starts: Vec<ConnectAction>,
    /// Parameters and their elements that can be read.
    pub readable: Vec<String>,
    /// Parameters that can be written, with their width.
    pub writable: Vec<(String, u32)>,
    /// Fields of records outside of the start-up.
    pub record_fields: Vec<String>,
    /// Records outside of the start-up, each with its fields.
    pub records: Vec<(String, Vec<String>)>,
    /// Slot and subslot of each submodule (PROFINET).
    pub places: Vec<(u16, u16)>,
    /// How many of a hundred activities are requests, where everything is drawn.
    pub share_of_requests: u64,
    /// The ident number (PROFIBUS).
    pub ident: u16,
    /// Web pages, without those that start a firmware update, each with the fields of its form.
    pub pages: Vec<(String, Vec<String>)>,
    pub stand: crate::stand::StandChoices,
}

/// A module with its start parameters and output signals.
pub(crate) struct ModuleNames {
    pub name: String,
    pub parameters: Vec<StartField>,
    /// Its start records.
    pub start_records: Vec<String>,
    pub outputs: Vec<OutputName>,
}

/// A start parameter.
pub(crate) struct StartField {
    pub name: String,
    pub values: FieldValues,
}

/// Slot and subslot of the interface and its ports.
const NETWORK: [(u16, u16); 4] = [(0, 1), (0, 0x8000), (0, 0x8001), (0, 0x8002)];

fn fields_of(record: &suite::device::DeviceRecord) -> Vec<String> {
    record.fields.iter().map(|field| format!("{}.{}", record.name, field.name)).collect()
}

/// Bits of the whole numbers that are drawn for a floating-point number.
const FLOAT_BITS: u32 = 16;

/// The values of a start parameter.
pub(crate) enum FieldValues {
    Words(Vec<String>),
    Number { width: u32, limits: [Option<i128>; 2], defaults: Vec<i128> },
}

/// An output signal, or a bit or field of one.
pub(crate) struct OutputName {
    pub name: String,
    pub values: OutputChoices,
    /// How often a connection has it set from its begin, in percent.
    pub held_percent: u64,
    /// How often it is drawn, against others of the module.
    pub weight: u64,
}

pub(crate) enum OutputChoices {
    Bit,
    Words(Vec<String>),
    Number(u32),
    /// The values of so many bits that are a scaled number.
    Scaled(SignalForm, u32),
    /// A sign of life.
    Counter,
}

/// How often the most usual precondition of the cases is set from the begin of a connection, in percent; others in proportion, and
/// never less than [`LEAST_HELD`].
const MOST_HELD: u64 = 85;
const LEAST_HELD: u64 = 5;
/// How often the output that most cases set is drawn, against one that no case sets.
const MOST_DRAWN: u64 = 20;

impl SequenceNames {
    pub fn of(manual: &Manual) -> SequenceNames {
        let device = &manual.device;
        let (before, all) = (settings(manual, &[0]), settings(manual, &[0, 1]));
        let module = |(index, of): (usize, &suite::device::DeviceModule)| {
            let submodules = of.submodules.iter().filter_map(|index| device.submodules.get(*index));
            let signals = submodules.flat_map(|of| &of.outputs).filter_map(|index| device.signals.get(*index));
            let outputs: Vec<(String, OutputChoices)> = signals.flat_map(outputs).collect();
            let highest = |counts| outputs.iter().map(|(name, _)| count_of(counts, name)).max().unwrap_or(0).max(1);
            let (most_before, most) = (highest(&before), highest(&all));
            let named = outputs.into_iter().map(|(name, values)| {
                let held_percent = LEAST_HELD + (MOST_HELD - LEAST_HELD) * count_of(&before, &name) / most_before;
                let weight = 1 + MOST_DRAWN * count_of(&all, &name) / most;
                OutputName { name, values, held_percent, weight }
            });
            let records = device.records.iter().filter(|record| record.starts(index));
            let fields = records.clone().flat_map(|record| &record.fields).filter(|field| !field.text);
            let free = fields.filter(|field| !is_fixed(device, index, &field.name));
            let start_records = records.clone().map(|record| record.name.clone()).collect();
            ModuleNames {
                start_records,
                name: of.name.clone(),
                parameters: free.map(start_field).collect(),
                outputs: named.collect(),
            }
        };
        let parameters = device.parameters.iter();
        let elements = parameters.clone().flat_map(|of| {
            let names = of.elements.iter().map(|(name, _)| format!("P{}.{name}", of.number));
            let whole = of.elements.is_empty().then(|| format!("P{}", of.number));
            names.chain(whole).map(move |name| (name, of))
        });
        let numbers = elements.clone().filter(|(_, of)| of.writable && of.kind.octets.is_none() && !of.kind.text);
        let others = device.records.iter().filter(|record| !record.start);
        let firmware: Vec<&str> = device.pages_for_firmware().map(|page| page.name.as_str()).collect();
        let pages = device.pages.iter().filter(|page| !firmware.contains(&page.name.as_str()));
        SequenceNames {
            on_profinet: device.profinet().is_some(),
            modules: device.modules.iter().enumerate().map(module).collect(),
            starts: starts(manual),
            readable: elements.map(|(name, _)| name).collect(),
            writable: numbers.map(|(name, of)| (name, of.kind.width - u32::from(of.kind.signed))).collect(),
            records: others
                .clone()
                .map(|record| (record.name.clone(), fields_of(record)))
                .filter(|(_, fields)| !fields.is_empty())
                .collect(),
            places: device.submodules.iter().map(|of| (of.slot, of.subslot)).chain(NETWORK).collect(),
            share_of_requests: 35,
            ident: device.ident().unwrap_or_default(),
            record_fields: others
                .flat_map(|record| record.fields.iter().map(|field| format!("{}.{}", record.name, field.name)))
                .collect(),
            pages: pages
                .map(|page| (page.name.clone(), page.fields.iter().map(|(name, _)| name.clone()).collect()))
                .collect(),
            stand: crate::stand::StandChoices::of(device),
        }
    }

    pub fn module(&self, name: &str) -> Option<&ModuleNames> {
        self.modules.iter().find(|module| module.name == name)
    }
}

impl FieldValues {
    pub fn draw(&self, draw: &mut Draw) -> String {
        let (width, [from, to], defaults) = match self {
            FieldValues::Words(words) => return draw.one(words).cloned().unwrap_or_default(),
            FieldValues::Number { width, limits, defaults } => (*width, *limits, defaults),
        };
        let default = draw.one(defaults).copied();
        let number = match (draw.between(0, 9), default) {
            // A scaling has to fit the encoder: mostly what the device has, divided by a power of two.
            (0..=5, Some(default)) if default > 0 => (default >> draw.between(0, 20)).max(1),
            (6, _) => from.unwrap_or(0),
            (7, _) => to.unwrap_or_else(|| i128::from(draw.number(width))),
            _ => i128::from(draw.number(width)),
        };
        let most = if width >= 64 { i128::from(u64::MAX) } else { (1 << width) - 1 };
        number.clamp(0, most).to_string()
    }
}

impl OutputChoices {
    /// A value other than rest.
    pub fn draw(&self, draw: &mut Draw) -> String {
        match self {
            OutputChoices::Bit => "1".to_owned(),
            OutputChoices::Words(words) => draw.one(words).cloned().unwrap_or_default(),
            OutputChoices::Number(width) => draw.number(*width).to_string(),
            OutputChoices::Scaled(form, width) => scaled(*form, draw.number(*width), *width),
            OutputChoices::Counter if draw.chance(60) => "held".to_owned(),
            OutputChoices::Counter => draw.between(0, 15).to_string(),
        }
    }

    /// The value that each sequence begins with.
    pub fn rest(&self) -> String {
        match self {
            OutputChoices::Bit | OutputChoices::Number(_) => "0".to_owned(),
            OutputChoices::Scaled(form, width) => scaled(*form, 0, *width),
            OutputChoices::Words(words) => words.first().cloned().unwrap_or_default(),
            OutputChoices::Counter => "counting".to_owned(),
        }
    }
}

/// Whether a module itself says this start parameter.
fn is_fixed(device: &DeviceDescription, module: usize, name: &str) -> bool {
    let fixes = device.modules.get(module).map_or(&[][..], |module| module.fixes());
    let record = device.records.first();
    fixes.iter().any(|(field, _)| record.is_some_and(|of| of.fields.get(*field).is_some_and(|of| of.name == name)))
}

fn start_field(field: &RecordField) -> StartField {
    let words = field.words.iter().map(|(word, _)| word.clone());
    let width = field.bits.map_or(8 * field.octets as u32, |(_, width)| width).min(64);
    let values = if field.words.is_empty() {
        FieldValues::Number { width, limits: [field.range.0, field.range.1], defaults: field.default.clone() }
    } else {
        FieldValues::Words(words.collect())
    };
    StartField { name: field.name.clone(), values }
}

fn scaled(form: SignalForm, raw: u64, width: u32) -> String {
    SuiteValue::fraction(&form.value(raw.into(), width)).text
}

fn outputs(signal: &DeviceSignal) -> Vec<(String, OutputChoices)> {
    let field = |field: &SignalField| {
        let words = || field.words.iter().map(|(word, _)| word.clone()).collect();
        let values = match (field.counts, field.words.is_empty(), field.width) {
            (Some(_), ..) => OutputChoices::Counter,
            (None, false, _) => OutputChoices::Words(words()),
            (None, true, 1) => OutputChoices::Bit,
            (None, true, width) => OutputChoices::Number(width),
        };
        (format!("{}.{}", signal.name, field.name), values)
    };
    if signal.fields.is_empty() {
        let width = if signal.signed { signal.width - 1 } else { signal.width };
        let choices = match signal.form {
            SignalForm::Whole => OutputChoices::Number(width),
            // What a computer takes for a small number and a person can read.
            SignalForm::Float => OutputChoices::Number(FLOAT_BITS),
            SignalForm::Scaled { .. } => OutputChoices::Scaled(signal.form, width),
            SignalForm::Text => return Vec::new(),
        };
        return vec![(signal.name.clone(), choices)];
    }
    signal.fields.iter().map(field).collect()
}

fn count_of(counts: &[(String, u64)], name: &str) -> u64 {
    counts.iter().find(|(known, _)| known == name).map_or(0, |(_, count)| *count)
}

/// The outputs that the manual's own cases set in these parts, `given` (0) and the test (1), each with how often.
fn settings(manual: &Manual, parts: &[usize]) -> Vec<(String, u64)> {
    let mut counts: Vec<(String, u64)> = Vec::new();
    for variant in &manual.variants {
        for trial in variant.trials.iter().filter(|trial| manual.is_own(trial)) {
            let steps = parts.iter().filter_map(|part| trial.parts().get(*part).copied());
            steps.for_each(|steps| scan::each_step(steps, &mut |step| count_outputs(variant, step, &mut counts)));
        }
    }
    counts
}

fn count_outputs(variant: &SuiteVariant, step: &TrialStep, counts: &mut Vec<(String, u64)>) {
    let mut count = |settings: &[Setting]| {
        for setting in settings {
            let name = setting.name.0 as usize;
            let is_output = matches!(variant.names.get(name), Some(NameKind::Signal { .. }));
            let is_rest = matches!(&setting.value, SetValue::Value(value) if value.text() == "0");
            let Some(path) = variant.paths.get(name).filter(|_| is_output && !is_rest) else { continue };
            match counts.iter_mut().find(|(known, _)| known == path) {
                Some((_, count)) => *count += 1,
                None => counts.push((path.clone(), 1)),
            }
        }
    };
    match &step.verb {
        Verb::Set(settings) => count(settings),
        Verb::Exchange(entries) => entries.iter().for_each(|entry| count(&entry.set)),
        _ => {}
    }
}

/// The connections of the manual's own cases, each once.
fn starts(manual: &Manual) -> Vec<ConnectAction> {
    let (mut list, mut known) = (Vec::new(), BTreeSet::new());
    for (index, variant) in manual.variants.iter().enumerate() {
        let mut add = |start: &ConnectionStart| {
            let Some(action) = connect_action(&manual.device, index, start) else { return };
            if known.insert(action.yaml()) {
                list.push(action);
            }
        };
        for trial in variant.trials.iter().filter(|trial| manual.is_own(trial)) {
            trial.start().into_iter().for_each(&mut add);
            scan::each_step_of(trial, &mut |step| {
                if let Verb::Connect { start, .. } = &step.verb {
                    add(start);
                }
            });
        }
    }
    list
}

/// A connection of a case without what is wrong in it; `None` if words cannot say it.
fn connect_action(device: &DeviceDescription, variant: usize, start: &ConnectionStart) -> Option<ConnectAction> {
    let module = device.modules.get(start.module)?;
    let mut settings = Vec::new();
    match start.isochronous {
        Some(clock) => settings.push(("isochronous".to_owned(), span(clock))),
        None => settings.extend(start.cycle.map(|cycle| ("cycle".to_owned(), span(cycle)))),
    }
    settings.extend(start.watchdog.map(|watchdog| ("watchdog".to_owned(), span(watchdog))));
    if start.unwatched {
        settings.push(("watchdog".to_owned(), "none".to_owned()));
    }
    for of in &start.parameters {
        let field = device.records.get(of.record)?.fields.get(of.field)?;
        let fixed = module.fixes().iter().find(|(fixed, _)| *fixed == of.field).map(|(_, value)| *value);
        let usual = fixed.or_else(|| field.default.get(variant).copied());
        if usual == Some(of.value) || field.text {
            continue;
        }
        let word = field.words.iter().find(|(_, number)| *number == of.value).map(|(word, _)| word.clone());
        let value = if field.words.is_empty() { Some(of.value.to_string()) } else { word };
        settings.push((field.name.clone(), value?));
    }
    Some(ConnectAction { module: module.name.clone(), settings, instead: Vec::new() })
}
