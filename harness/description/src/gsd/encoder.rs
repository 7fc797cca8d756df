//! What the GSD of an encoder with the encoder profile 3.062 says of it: its classes, its start parameters by their meaning, its resolution.
//!
//! The profile fixes the places of the parameters, counted from the byte with the operating parameters; the names in the GSD have to confirm
//! them. Where they do not, the slave is no such encoder, and is tested as any slave.

use super::model::{FieldType, Gsd, GsdField, GsdModule};
use crate::value_texts::{Meaning, meaning, plain_words};
use wire::profibus::cfg::{Identifier, IoLengths, io_lengths};

/// The shortest diagnosis of class 2: up to the serial number.
const LENGTH_OF_CLASS_2: usize = 57;
/// The bit of class 2 in the operating parameters.
const CLASS_2: u8 = 0x02;
/// The units per revolution with which the suite scales. A coarser encoder is not described.
pub(super) const UNITS: i64 = 2048;
/// What the suite needs of an encoder whose hardware resolution it checks.
const LARGE_RANGE: i64 = 0x2_0000;
/// The most revolutions that a number of two bytes in the diagnosis can show.
const MOST_REVOLUTIONS: i64 = 0xFFFF;
/// The fewest revolutions of an encoder whose revolutions the suite counts.
const REVOLUTIONS: i64 = 8;

/// An encoder of the profile, as its GSD describes it.
pub(super) struct GsdEncoder<'g> {
    /// The module of class 1, if there is one.
    pub(super) class_1: Option<&'g GsdModule>,
    /// The module of class 2.
    pub(super) class_2: &'g GsdModule,
    /// The module of class 2 with a velocity, if there is one.
    pub(super) velocity: Option<&'g GsdModule>,
    /// The number of bytes of a position.
    pub(super) width: usize,
    /// Where the parameters are.
    pub(super) places: Places,
    pub(super) resolution: Resolution,
    /// The length of the diagnosis suffices for class 2.
    pub(super) has_long_diagnosis: bool,
}

/// Where the parameters are in the user bytes of Set_Prm.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Places {
    /// The byte with the operating parameters; four bytes of units per revolution and four of total range follow it.
    pub(super) operating: usize,
    /// Whether bit 0 is 0 for counterclockwise.
    pub(super) is_reversed: bool,
    /// The field that chooses the diagnosis, and its number for the diagnosis of class 2.
    pub(super) diagnosis_type: Option<ChoiceInByte>,
    /// The byte with the unit of the velocity, and its numbers for rpm and steps per second.
    pub(super) speed_unit: Option<(usize, [i64; 2])>,
}

/// A choice in some bits of a byte.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct ChoiceInByte {
    pub(super) octet: usize,
    /// The lowest and the highest bit; none for the whole byte.
    pub(super) bits: Option<(u8, u8)>,
    /// The number chosen.
    pub(super) number: i64,
}

/// Units per revolution and total range of the hardware.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Resolution {
    pub(super) least_units: i64,
    pub(super) units: i64,
    pub(super) range: i64,
    /// Whether the GSD limits both, to powers of two.
    pub(super) is_sure: bool,
}

impl Resolution {
    pub(super) fn revolutions(&self) -> i64 {
        (self.range / self.units.max(1)).max(1)
    }
}

impl<'g> GsdEncoder<'g> {
    /// Finds the encoder of a GSD whose module `chosen` is tested.
    ///
    /// Of several modules of a class the chosen one is taken, and if none is chosen, none.
    pub(super) fn of(gsd: &'g Gsd, chosen: &'g GsdModule) -> Option<GsdEncoder<'g>> {
        let is_scaling = |module: &GsdModule, sums: IoLengths| {
            [2, 4].contains(&sums.inputs) && sums.outputs == sums.inputs && scaling(gsd, module).is_some()
        };
        let class_2 = one_of(gsd, chosen, is_scaling)?;
        let (operating, resolution) = scaling(gsd, class_2)?;
        let width = lengths(class_2)?.inputs;
        let class_1 = one_of(gsd, chosen, |module, sums| {
            let bits = gsd.default_octets(module).get(operating).copied();
            sums.inputs == width
                && [0, width].contains(&sums.outputs)
                && bits.is_some_and(|bits| bits & CLASS_2 == 0)
                && scaling(gsd, module).is_none()
                && code_sequence(gsd, module).is_some_and(|(at, _)| at == operating)
        });
        let velocity = one_of(gsd, chosen, |module, sums| {
            let is_named = has_word(&module.name, &["vel", "velocity", "speed", "geschwindigkeit"]);
            let is_like_class_2 = scaling(gsd, module).is_some_and(|(at, _)| at == operating);
            width == 4 && (sums.inputs, sums.outputs) == (8, 4) && is_named && is_like_class_2
        });
        let places = Places {
            operating,
            is_reversed: code_sequence(gsd, class_2).is_some_and(|(_, field)| starts_counterclockwise(field)),
            diagnosis_type: diagnosis_type(gsd, class_2),
            speed_unit: velocity.and_then(|module| speed_unit(gsd, module)).filter(|(at, _)| *at > operating + 8),
        };
        let has_long_diagnosis = gsd.max_diagnosis.is_some_and(|longest| longest >= LENGTH_OF_CLASS_2);
        Some(GsdEncoder { class_1, class_2, velocity, width, places, resolution, has_long_diagnosis })
    }

    /// The modules of the suite that this encoder has.
    pub(super) fn claimed(&self, gsd: &Gsd) -> Vec<&'static str> {
        let has_unit = self.places.speed_unit.is_some();
        let is_sure = self.resolution.is_sure && self.resolution.range > LARGE_RANGE;
        let modules = [
            ("class_1", self.class_1.is_some()),
            ("class_1_unscaled", self.class_1.is_some() && is_sure),
            ("class_2", true),
            ("multiturn", self.resolution.revolutions() >= REVOLUTIONS),
            ("unscaled", is_sure),
            ("extended_diagnosis", self.has_long_diagnosis),
            ("encoder_freeze", gsd.freeze),
            ("encoder_sync", gsd.sync),
            ("velocity", self.velocity.is_some()),
            ("velocity_rpm", has_unit),
            ("velocity_steps", has_unit),
        ];
        modules.into_iter().filter(|(_, has)| *has).map(|(name, _)| name).collect()
    }
}

/// The lengths of the data of a module.
pub(super) fn lengths(module: &GsdModule) -> Option<IoLengths> {
    Some(io_lengths(&Identifier::parse_all(&module.cfg).ok()?))
}

/// The chosen module if it fits, or the only one that does.
fn one_of<'g>(
    gsd: &'g Gsd,
    chosen: &'g GsdModule,
    fits: impl Fn(&GsdModule, IoLengths) -> bool,
) -> Option<&'g GsdModule> {
    let fits = |module: &&GsdModule| lengths(module).is_some_and(|sums| fits(module, sums));
    if fits(&chosen) {
        return Some(chosen);
    }
    let mut fitting = gsd.modules.iter().filter(fits);
    fitting.next().filter(|_| fitting.next().is_none())
}

fn has_word(name: &str, words: &[&str]) -> bool {
    plain_words(name).iter().any(|word| words.contains(&word.as_str()))
}

/// The field in one bit of a byte whose name has one of these words, with its offset.
fn bit<'g>(gsd: &'g Gsd, module: &'g GsdModule, bit: u8, words: &[&str]) -> Option<(usize, &'g GsdField)> {
    gsd.fields(module)
        .find(|(_, field)| field.kind == FieldType::Bits { low: bit, high: bit } && has_word(&field.name, words))
}

fn code_sequence<'g>(gsd: &'g Gsd, module: &'g GsdModule) -> Option<(usize, &'g GsdField)> {
    bit(gsd, module, 0, &["sequence", "direction", "drehrichtung", "drehsinn", "codeverlauf"])
}

/// Whether the text of 0 says counterclockwise.
fn starts_counterclockwise(field: &GsdField) -> bool {
    let text = field.texts.iter().find(|(number, _)| *number == 0).map(|(_, text)| text.as_str());
    text.is_some_and(|text| {
        has_word(text, &["ccw", "counterclockwise", "anticlockwise", "counter", "anti", "gegen", "links"])
    })
}

/// The byte with the operating parameters of a module with scaling, and the resolution.
fn scaling(gsd: &Gsd, module: &GsdModule) -> Option<(usize, Resolution)> {
    let (operating, _) = code_sequence(gsd, module)?;
    let (at, _) = bit(gsd, module, 3, &["scaling", "skalierung", "skalierungsfunktion"])?;
    let units = number(gsd, module, operating + 1, &["revolution", "turn", "umdrehung", "rev"])?;
    let range = number(gsd, module, operating + 5, &["total", "range", "gesamt", "gesamtauflösung", "messbereich"])?;
    let highest = |of: &DescribedNumber| of.range.map_or(of.default, |(_, highest)| highest);
    let resolution = Resolution {
        least_units: units.range.map_or(1, |(lowest, _)| lowest.max(1)),
        units: highest(&units),
        range: highest(&range),
        is_sure: false,
    };
    let is_power = |number: i64| u64::try_from(number).is_ok_and(u64::is_power_of_two);
    let is_sure = units.range.is_some()
        && range.range.is_some()
        && is_power(resolution.units)
        && is_power(resolution.range)
        && resolution.revolutions() <= MOST_REVOLUTIONS;
    let is_fine = resolution.units >= 2 * UNITS && resolution.range >= resolution.units;
    (at == operating && is_fine).then_some((operating, Resolution { is_sure, ..resolution }))
}

/// A number of four bytes.
struct DescribedNumber {
    default: i64,
    /// The lowest and the highest; none where they are not known.
    range: Option<(i64, i64)>,
}

/// The number of four bytes at an offset whose name has one of these words; a GSD may describe it as two of two bytes.
fn number(gsd: &Gsd, module: &GsdModule, at: usize, words: &[&str]) -> Option<DescribedNumber> {
    let field = |place: usize, octets: usize| {
        let kind = FieldType::Octets { octets, signed: false };
        let mut fields = gsd.fields(module);
        fields.find(|(known, field)| *known == place && field.kind == kind && has_word(&field.name, words))
    };
    if let Some((_, field)) = field(at, 4) {
        return Some(DescribedNumber { default: field.default, range: field.range });
    }
    let ((_, high), (_, low)) = field(at, 2).zip(field(at + 2, 2))?;
    Some(DescribedNumber { default: high.default << 16 | low.default, range: None })
}

/// The field that chooses how long the diagnosis is, with the number for the longer one.
fn diagnosis_type(gsd: &Gsd, module: &GsdModule) -> Option<ChoiceInByte> {
    let mut fields = gsd.fields(module);
    let (octet, field) = fields.find(|(_, field)| {
        has_word(&field.name, &["diagnosis", "diagnostic", "diagnostics", "diagnose"])
            && has_word(&field.name, &["type", "length", "extended", "typ", "länge"])
    })?;
    // A text with more bytes, or with a word for it.
    let bytes = |text: &str| plain_words(text).iter().find_map(|word| word.parse::<u32>().ok()).unwrap_or_default();
    let is_long = |text: &str| has_word(text, &["extended", "long", "full", "enable", "enabled", "on", "lang"]);
    let longer = field.texts.iter().max_by_key(|(_, text)| (is_long(text), bytes(text)))?;
    let bits = match field.kind {
        FieldType::Bits { low, high } => Some((low, high)),
        FieldType::Octets { octets: 1, .. } => None,
        FieldType::Octets { .. } => return None,
    };
    Some(ChoiceInByte { octet, bits, number: longer.0 })
}

/// The byte with the unit of the velocity, and its numbers for rpm and steps per second.
fn speed_unit(gsd: &Gsd, module: &GsdModule) -> Option<(usize, [i64; 2])> {
    let mut fields = gsd.fields(module);
    let (at, field) = fields.find(|(_, field)| {
        field.kind.octets() == 1
            && has_word(&field.name, &["velocity", "speed", "geschwindigkeit"])
            && has_word(&field.name, &["unit", "units", "einheit"])
    })?;
    let words = ["rpm", "steps_per_second"].map(|word| (word.to_owned(), 0));
    let number = |unit: &str| {
        let means = |text: &str| meaning(text, &words) == Meaning::One(unit.to_owned());
        field.texts.iter().find(|(_, text)| means(text)).map(|(number, _)| *number)
    };
    Some((at, [number("rpm")?, number("steps_per_second")?]))
}

#[cfg(test)]
mod tests {
    use super::super::read;
    use super::*;

    /// A GSD as vendors write it for the profile: no bytes of DP-V1, the total range in two words.
    const MULTITURN: &str = "#Profibus_DP\nModel_Name=\"Multiturn\"\nIdent_Number=0x1234\nFreeze_Mode_supp=1\nMax_Diag_Data_Len=57\n\
        PrmText=1\nText(0)=\"CCW\"\nText(1)=\"CW\"\nEndPrmText\n\
        ExtUserPrmData=1 \"Code sequence\"\nBit(0) 0 0-1\nPrm_Text_Ref=1\nEndExtUserPrmData\n\
        ExtUserPrmData=2 \"Scaling function control\"\nBit(3) 1 0-1\nEndExtUserPrmData\n\
        ExtUserPrmData=3 \"Measuring units per revolution\"\nUnsigned32 8192 1-8192\nEndExtUserPrmData\n\
        ExtUserPrmData=4 \"Total measuring range, high\"\nUnsigned16 512 0-512\nEndExtUserPrmData\n\
        ExtUserPrmData=5 \"Total measuring range, low\"\nUnsigned16 0 0-65535\nEndExtUserPrmData\n\
        Module=\"Class 1\" 0xD1\nExt_Module_Prm_Data_Len=2\nExt_User_Prm_Data_Const(0)=0x00,0x00\n\
        Ext_User_Prm_Data_Ref(1)=1\nEndModule\n\
        Module=\"Class 2\" 0xF1\nExt_Module_Prm_Data_Len=10\n\
        Ext_User_Prm_Data_Const(0)=0x00,0x0A,0x00,0x00,0x20,0x00,0x02,0x00,0x00,0x00\n\
        Ext_User_Prm_Data_Ref(1)=1\nExt_User_Prm_Data_Ref(1)=2\nExt_User_Prm_Data_Ref(2)=3\n\
        Ext_User_Prm_Data_Ref(6)=4\nExt_User_Prm_Data_Ref(8)=5\nEndModule\n";

    fn gsd(text: &str) -> Gsd {
        read(text).expect("a GSD")
    }

    #[test]
    fn parameters_are_found_by_place_and_name() {
        let gsd = gsd(MULTITURN);
        let encoder = GsdEncoder::of(&gsd, &gsd.modules[1]).expect("an encoder");
        assert_eq!((encoder.width, encoder.places.operating, encoder.places.is_reversed), (4, 1, true));
        assert_eq!(encoder.class_1.map(|module| module.name.as_str()), Some("Class 1"));
        let Resolution { units, range, is_sure, .. } = encoder.resolution;
        // Two words have no common limit, so the default is all that is known.
        assert_eq!((units, range, is_sure), (8192, 33_554_432, false));
        assert_eq!(encoder.claimed(&gsd), ["class_1", "class_2", "multiturn", "extended_diagnosis", "encoder_freeze"]);
    }

    #[test]
    fn a_slave_whose_names_say_something_else_is_no_encoder() {
        for (right, wrong) in [
            ("Code sequence", "Filter"),
            ("Scaling function control", "Filter"),
            ("Measuring units per revolution", "Limit"),
            ("Total measuring range, low", "Limit"),
            ("Bit(3) 1 0-1", "Bit(4) 1 0-1"),
            ("Ext_User_Prm_Data_Ref(2)=3", "Ext_User_Prm_Data_Ref(3)=3"),
            ("0xF1", "0xF0,0xF0,0xF0"),
            ("Unsigned32 8192 1-8192", "Unsigned32 1024 1-1024"),
        ] {
            assert!(MULTITURN.contains(right), "{right}");
            let gsd = gsd(&MULTITURN.replacen(right, wrong, 1));
            assert!(GsdEncoder::of(&gsd, &gsd.modules[1]).is_none(), "{wrong}");
        }
    }

    #[test]
    fn of_two_modules_of_class_1_none_is_taken() {
        let class_1 =
            MULTITURN.find("Module=\"Class 1\"").and_then(|begin| MULTITURN.get(begin..)).expect("it is there");
        let class_1 = class_1.split_inclusive("EndModule\n").next().expect("it ends").replace("Class 1", "Other");
        let gsd = gsd(&(MULTITURN.to_owned() + &class_1));
        let encoder = GsdEncoder::of(&gsd, &gsd.modules[1]).expect("an encoder");
        assert_eq!(encoder.class_1, None);
    }
}
