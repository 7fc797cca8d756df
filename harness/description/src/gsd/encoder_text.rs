//! The description of an encoder with the encoder profile 3.062: what the suite for any DP encoder adds to that for any slave.

use super::encoder::{GsdEncoder, UNITS, lengths};
use super::model::{Gsd, GsdModule};
use plain_text::hex;
use std::fmt::Write;

/// The most revolutions of a total range that the cases use.
const TURNS: i64 = 16;
/// The units per revolution of cases without a power of two.
const ODD_UNITS: i64 = 1000;

/// Parts of a `device.yaml`.
pub(super) struct EncoderText {
    /// Entries of `constants`.
    pub(super) constants: String,
    /// Lines of `signals`.
    pub(super) signals: String,
    /// Lines of `modules`.
    pub(super) modules: String,
    /// The key `set_prm`.
    pub(super) set_prm: String,
    /// Fields of the diagnosis.
    pub(super) diagnosis: &'static str,
    /// The keys that only an encoder has.
    pub(super) keys: &'static str,
    layout: EncoderUserBytes,
}

impl EncoderText {
    /// Writes the parts; `dpv1` is the number of bytes of DP-V1 at the begin of the user bytes.
    pub(super) fn of(encoder: &GsdEncoder<'_>, gsd: &Gsd, dpv1: usize) -> EncoderText {
        let layout = EncoderUserBytes::of(encoder, &gsd.default_octets(encoder.class_2), dpv1);
        EncoderText {
            constants: constants(encoder),
            signals: signals(encoder.width),
            modules: modules(encoder, gsd, &layout),
            set_prm: layout.text(),
            diagnosis: DIAGNOSIS,
            keys: KEYS,
            layout,
        }
    }

    /// The start parameters that go with a module.
    pub(super) fn fixes(&self, gsd: &Gsd, module: &GsdModule) -> String {
        self.layout.fixes(&gsd.default_octets(module), &[])
    }

    /// The signals in the outputs and in the inputs of a module; none if it is no module of the encoder.
    ///
    /// Modules with the same identifiers need the same signals.
    pub(super) fn signals_of(encoder: &GsdEncoder<'_>, module: &GsdModule) -> Option<(&'static str, &'static str)> {
        let own = [encoder.class_1, Some(encoder.class_2), encoder.velocity];
        own.iter().flatten().any(|known| known.cfg == module.cfg).then(|| signals_in(encoder, module))
    }
}

fn constants(encoder: &GsdEncoder<'_>) -> String {
    let resolution = &encoder.resolution;
    let turns = resolution.revolutions().min(TURNS);
    let velocity = encoder.velocity.and_then(lengths).map_or(encoder.width + 4, |sums| sums.inputs);
    format!(
        "hardware_steps: {}, hardware_revolutions: {}, hardware_range: {}, least_units: {}, units: {UNITS}, range: {}, \
         odd_units: {ODD_UNITS}, odd_range: {}, uneven_range: {}, position_octets: {}, velocity_octets: {velocity}",
        resolution.units,
        resolution.revolutions(),
        resolution.range,
        resolution.least_units,
        UNITS * turns,
        ODD_UNITS * turns,
        ODD_UNITS * 6,
        encoder.width
    )
}

fn signals(width: usize) -> String {
    let (bits, highest) = (width * 8, width * 8 - 1);
    format!(
        "  preset: {{ from: controller, width: {bits}, fields: {{ value: {{ bits: [0, {}] }}, trigger: {highest} }} }}\n\
         \x20 position: {{ from: device, width: {bits}, position_in: position_range }}\n\
         \x20 velocity: {{ from: device, width: 32, signed: true }}\n",
        highest - 1
    )
}

/// The signals in the outputs and in the inputs of a module of the encoder.
fn signals_in(encoder: &GsdEncoder<'_>, module: &GsdModule) -> (&'static str, &'static str) {
    let sums = lengths(module).unwrap_or_default();
    let outputs = if sums.outputs == encoder.width { "preset" } else { "" };
    (outputs, if sums.inputs > encoder.width { "position, velocity" } else { "position" })
}

fn modules(encoder: &GsdEncoder<'_>, gsd: &Gsd, layout: &EncoderUserBytes) -> String {
    let class_1 = encoder.class_1.unwrap_or(encoder.class_2);
    let on = [("class_2", 1)];
    let with = |name: &'static str, number: Option<i64>| -> Vec<(&'static str, i64)> {
        on.into_iter().chain(number.map(|number| (name, number))).collect()
    };
    let unit = |index: usize| with("speed_unit", encoder.places.speed_unit.map(|(_, numbers)| numbers[index]));
    let long = with("diagnosis_type", encoder.places.diagnosis_type.map(|of| of.number));
    let mut text = String::new();
    let mut add = |name: &str, module: &GsdModule, fixed: &[(&str, i64)]| {
        let sums = lengths(module).unwrap_or_default();
        let (outputs, inputs) = signals_in(encoder, module);
        // Writing into a String cannot fail.
        let _ = writeln!(
            text,
            "  {name}: {{ cfg: \"{}\", octets: {{ out: {}, in: {} }}, outputs: [{outputs}], inputs: [{inputs}], fixes: {{ {} }} }}",
            hex(&module.cfg),
            sums.outputs,
            sums.inputs,
            layout.fixes(&gsd.default_octets(module), fixed)
        );
    };
    add("class_1", class_1, &[]);
    add("class_1_unscaled", class_1, &[]);
    for name in ["class_2", "multiturn", "unscaled", "encoder_freeze", "encoder_sync"] {
        add(name, encoder.class_2, &on);
    }
    add("extended_diagnosis", encoder.class_2, &long);
    match encoder.velocity {
        Some(module) => {
            add("velocity", module, &on);
            add("velocity_rpm", module, &unit(0));
            add("velocity_steps", module, &unit(1));
        }
        None => {
            let (cfg, out) = if encoder.width == 4 { ("D3 E1", 4) } else { ("D2 E0", 2) };
            for name in ["velocity", "velocity_rpm", "velocity_steps"] {
                let _ = writeln!(
                    text,
                    "  {name}: {{ cfg: \"{cfg}\", octets: {{ out: {out}, in: {} }}, outputs: [preset], \
                     inputs: [position, velocity], from_source: invented }}",
                    out + 4
                );
            }
        }
    }
    text
}

/// The fields of the user bytes after those of DP-V1: the parameters of the encoder, and a field for each bit or byte between them.
struct EncoderUserBytes {
    dpv1: Vec<u8>,
    octets: usize,
    is_reversed: bool,
    fields: Vec<UserField>,
}

/// A field of the user bytes.
struct UserField {
    name: String,
    /// Its first byte, counted from the first user byte.
    octet: usize,
    octets: usize,
    /// Its lowest and its highest bit; none for whole bytes.
    bits: Option<(u8, u8)>,
    words: &'static str,
    default: u64,
}

impl UserField {
    /// Whether a bit of the user bytes belongs to it.
    fn covers(&self, octet: usize, bit: u8) -> bool {
        (self.octet..self.octet + self.octets).contains(&octet)
            && self.bits.is_none_or(|(low, high)| (low..=high).contains(&bit))
    }
}

impl EncoderUserBytes {
    fn of(encoder: &GsdEncoder<'_>, default: &[u8], dpv1: usize) -> EncoderUserBytes {
        let places = &encoder.places;
        let operating = places.operating;
        let field = |name: &str, octet, octets, bits, words| {
            let default = number(default, octet, octets, bits);
            UserField { name: name.to_owned(), octet, octets, bits, words, default }
        };
        let bit = |name, bit: u8, words| field(name, operating, 1, Some((bit, bit)), words);
        let mut fields = vec![
            bit("code_sequence", 0, "direction"),
            bit("class_2", 1, "switch"),
            bit("commissioning_diagnostics", 2, "switch"),
            bit("scaling", 3, "switch"),
            field("units_per_revolution", operating + 1, 4, None, ""),
            field("total_range", operating + 5, 4, None, ""),
        ];
        fields.extend(places.diagnosis_type.map(|of| field("diagnosis_type", of.octet, 1, of.bits, "")));
        fields.extend(places.speed_unit.map(|(octet, _)| field("speed_unit", octet, 1, None, "")));
        for octet in dpv1..default.len() {
            let free: Vec<u8> = (0..8).filter(|bit| !fields.iter().any(|of| of.covers(octet, *bit))).collect();
            if free.len() == 8 {
                fields.push(field(&format!("byte_{}", octet - dpv1), octet, 1, None, ""));
                continue;
            }
            let named = |bit: u8| field(&format!("byte_{}_bit_{bit}", octet - dpv1), octet, 1, Some((bit, bit)), "");
            fields.extend(free.into_iter().map(named));
        }
        EncoderUserBytes {
            dpv1: default.get(..dpv1).unwrap_or_default().to_vec(),
            octets: default.len() - dpv1,
            is_reversed: places.is_reversed,
            fields,
        }
    }

    /// The key `set_prm`, with the words of its fields.
    fn text(&self) -> String {
        let direction =
            if self.is_reversed { "clockwise: 1, counterclockwise: 0" } else { "clockwise: 0, counterclockwise: 1" };
        let mut text = format!(
            "words: {{ switch: {{ disabled: 0, enabled: 1 }}, direction: {{ {direction} }} }}\n\
             set_prm:\n  octets: {}\n",
            self.octets
        );
        if !self.dpv1.is_empty() {
            let _ = writeln!(text, "  dpv1: \"{}\"", hex(&self.dpv1));
        }
        text.push_str("  fields:\n");
        for field in &self.fields {
            let first = field.octet - self.dpv1.len();
            let _ = match (field.bits, field.octets) {
                (Some((low, high)), _) if low == high => {
                    write!(text, "    {}: {{ octet: {first}, bit: {low}", field.name)
                }
                (Some((low, high)), _) => write!(text, "    {}: {{ octet: {first}, bits: [{low}, {high}]", field.name),
                (None, 1) => write!(text, "    {}: {{ octet: {first}", field.name),
                (None, octets) => write!(text, "    {}: {{ octets: [{first}, {}]", field.name, first + octets - 1),
            };
            if !field.words.is_empty() {
                let _ = write!(text, ", words: {}", field.words);
            }
            let _ = writeln!(text, ", default: {} }}", self.value(field, field.default));
        }
        text
    }

    /// The start parameters with other values than the defaults: those of these user bytes, and those that are `fixed`.
    fn fixes(&self, octets: &[u8], fixed: &[(&str, i64)]) -> String {
        let fixes = self.fields.iter().filter_map(|field| {
            let sent = number(octets, field.octet, field.octets, field.bits);
            let fixed = fixed.iter().find(|(name, _)| *name == field.name);
            let value = fixed.and_then(|(_, number)| u64::try_from(*number).ok()).unwrap_or(sent);
            (value != field.default).then(|| format!("{}: {}", field.name, self.value(field, value)))
        });
        fixes.collect::<Vec<_>>().join(", ")
    }

    /// A value as the description writes it.
    fn value(&self, field: &UserField, number: u64) -> String {
        match (field.words, number) {
            ("switch", 0) => "disabled".into(),
            ("switch", _) => "enabled".into(),
            ("direction", of) if (of != 0) == self.is_reversed => "clockwise".into(),
            ("direction", _) => "counterclockwise".into(),
            _ => number.to_string(),
        }
    }
}

/// Reads a field of user bytes; bytes that are missing are 0.
fn number(octets: &[u8], at: usize, count: usize, bits: Option<(u8, u8)>) -> u64 {
    let octet = |at: usize| u64::from(octets.get(at).copied().unwrap_or_default());
    let whole = (at..at + count).fold(0, |number, at| number << 8 | octet(at));
    bits.map_or(whole, |(low, high)| whole >> low & ((2 << (high - low)) - 1))
}

/// The fields of the diagnosis: encoder profile 3.062, counted from byte 0.
const DIAGNOSIS: &str = "  fields:
    header: { byte: 6 }
    alarms: { byte: 7 }
    status_reversed: { byte: 8, bit: 0 }
    status_class_2: { byte: 8, bit: 1 }
    status_scaling: { byte: 8, bit: 3 }
    encoder_type: { byte: 9 }
    hardware_steps: { bytes: [10, 13] }
    hardware_revolutions: { bytes: [14, 15] }
    additional_alarms: { byte: 16 }
    supported_alarms: { bytes: [17, 18] }
    warnings: { bytes: [19, 20] }
    supported_warnings: { bytes: [21, 22] }
    profile_version: { bytes: [23, 24] }
    software_version: { bytes: [25, 26] }
    operating_time: { bytes: [27, 30] }
    offset: { bytes: [31, 34], signed: true }
    manufacturer_offset: { bytes: [35, 38], signed: true }
    programmed_steps: { bytes: [39, 42] }
    programmed_range: { bytes: [43, 46] }
    serial_number: { bytes: [47, 56] }
";

/// The keys of a description that only an encoder has.
const KEYS: &str = "tolerance:
  speed: { is: 2, why: \"Per cent of a velocity. The profile prints no accuracy.\" }
  turning: { is: 4, why: \"Steps by which a position may differ after a turn.\" }
  jump: { is: 1000, why: \"Steps between two samples of a slowly turning shaft.\" }
derived:
  position_range: if class_2 == enabled and scaling == enabled then total_range else hardware_range
roles: { position: [position] }
changes: { position_reference: [preset.trigger], nvm_write: [preset.trigger] }
";
