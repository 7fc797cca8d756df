//! Reads a GSD: lines of `Keyword = value`, some with a number in brackets, and groups of lines for texts, fields and modules.
//!
//! Unused keywords are skipped. Sizes are limited; a file that is not a GSD gives an error with its line.

use super::model::{FieldType, Gsd, GsdField, GsdModule, GsdParameters};
use std::collections::BTreeMap;
use thiserror::Error;
use wire::profibus::fdl::{BaudRate, BitTimes};

/// Baud rates as at the begin of their keywords.
const BAUDS: [&str; 11] = ["9.6", "19.2", "31.25", "45.45", "93.75", "187.5", "500", "1.5M", "3M", "6M", "12M"];
/// Upper limit of the bytes of Set_Prm after the first seven.
const MOST_USER_OCTETS: usize = 237;

/// Why a GSD cannot be read.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("line {line}: {message}")]
pub struct GsdError {
    /// The line, from 1.
    pub line: usize,
    /// What is wrong and what is expected.
    pub message: String,
}

/// Reads a GSD from its bytes; old files are in Latin-1.
pub fn read_octets(octets: &[u8]) -> Result<Gsd, GsdError> {
    match std::str::from_utf8(octets) {
        Ok(text) => read(text.trim_start_matches('\u{FEFF}')),
        Err(_) => read(&octets.iter().map(|&octet| char::from(octet)).collect::<String>()),
    }
}

/// Reads a GSD.
pub fn read(text: &str) -> Result<Gsd, GsdError> {
    let lines = lines(text);
    if !lines.iter().any(|line| line.text.eq_ignore_ascii_case("#Profibus_DP")) {
        return Err(GsdError { line: 1, message: "not a GSD file: the line `#Profibus_DP` is missing".into() });
    }
    let mut reader =
        GsdReader { gsd: Gsd::default(), fields: BTreeMap::new(), texts: BTreeMap::new(), has_ident: false };
    let mut rest = lines.iter();
    while let Some(line) = rest.next() {
        reader.line(line, &mut rest)?;
    }
    if reader.has_ident {
        Ok(reader.gsd)
    } else {
        Err(GsdError { line: 1, message: "`Ident_Number` is missing".into() })
    }
}

/// A line without its comment; continued lines are joined.
struct GsdLine {
    number: usize,
    text: String,
}

impl GsdLine {
    fn wrong(&self, message: impl Into<String>) -> GsdError {
        GsdError { line: self.number, message: message.into() }
    }

    /// Keyword, number in brackets, value.
    fn setting(&self) -> Option<(String, Option<&str>, &str)> {
        let (head, value) = self.text.split_once('=')?;
        let head = head.trim();
        let (word, number) = match head.split_once('(') {
            Some((word, number)) => (word.trim(), Some(number.trim_end().trim_end_matches(')').trim())),
            None => (head, None),
        };
        Some((word.to_ascii_lowercase(), number, value.trim()))
    }

    fn number(&self, text: &str) -> Result<i64, GsdError> {
        number(text).ok_or_else(|| self.wrong(format!("`{}` is not a number", text.escape_debug())))
    }

    fn size(&self, text: &str) -> Result<usize, GsdError> {
        let size = usize::try_from(self.number(text)?).ok().filter(|size| *size <= MOST_USER_OCTETS + 7);
        size.ok_or_else(|| self.wrong(format!("`{}` is not a valid number of bytes", text.escape_debug())))
    }

    fn octets(&self, list: &str) -> Result<Vec<u8>, GsdError> {
        let octet = |text: &str| {
            let octet = u8::try_from(self.number(text.trim())?).ok();
            octet.ok_or_else(|| self.wrong(format!("`{}` is not a byte", text.trim().escape_debug())))
        };
        list.split(',').filter(|text| !text.trim().is_empty()).map(octet).collect()
    }
}

fn lines(text: &str) -> Vec<GsdLine> {
    let mut lines: Vec<GsdLine> = Vec::new();
    let mut goes_on = false;
    for (index, raw) in text.lines().enumerate() {
        let line = without_comment(raw).trim();
        let (line, more) = match line.strip_suffix('\\') {
            Some(line) => (line, true),
            None => (line, false),
        };
        match lines.last_mut().filter(|_| goes_on) {
            Some(last) => last.text.push_str(line.trim_start()),
            None => lines.push(GsdLine { number: index + 1, text: line.to_owned() }),
        }
        goes_on = more;
    }
    lines.retain(|line| !line.text.is_empty());
    lines
}

/// The part before the first `;` outside of quotation marks.
fn without_comment(line: &str) -> &str {
    let mut quoted = false;
    for (at, character) in line.char_indices() {
        match character {
            '"' => quoted = !quoted,
            ';' if !quoted => return &line[..at],
            _ => {}
        }
    }
    line
}

fn number(text: &str) -> Option<i64> {
    let (negative, digits) = text.strip_prefix('-').map_or((false, text), |digits| (true, digits));
    let hexadecimal = digits.strip_prefix("0x").or_else(|| digits.strip_prefix("0X"));
    let number = match hexadecimal {
        Some(digits) => i64::from_str_radix(digits, 16).ok()?,
        None => digits.parse().ok()?,
    };
    Some(if negative { -number } else { number })
}

/// The rate of a keyword's `baud`, in kbit/s or, with an `M`, in Mbit/s.
fn rate(baud: &str) -> BaudRate {
    let (number, unit) = baud.strip_suffix('M').map_or((baud, 1_000.0), |number| (number, 1_000_000.0));
    BaudRate((number.parse().unwrap_or(0.0_f64) * unit).round() as u32)
}

/// The text between the first quotation marks, and what follows them.
fn quoted(value: &str) -> Option<(&str, &str)> {
    let (_, after) = value.split_once('"')?;
    after.split_once('"').map(|(text, rest)| (text, rest.trim()))
}

struct GsdReader {
    gsd: Gsd,
    fields: BTreeMap<i64, GsdField>,
    /// The groups of texts for numbers.
    texts: BTreeMap<i64, Vec<(i64, String)>>,
    has_ident: bool,
}

type GsdLines<'r, 'l> = &'r mut std::slice::Iter<'l, GsdLine>;

impl GsdReader {
    fn line(&mut self, line: &GsdLine, rest: GsdLines<'_, '_>) -> Result<(), GsdError> {
        let Some((word, place, value)) = line.setting() else { return Ok(()) };
        let text = || quoted(value).map_or(value, |(text, _)| text).to_owned();
        let flag = || line.number(value).map(|number| number != 0);
        match word.as_str() {
            "gsd_revision" => self.gsd.gsd_revision = u32::try_from(line.number(value)?).unwrap_or_default(),
            "vendor_name" => self.gsd.vendor = text(),
            "model_name" => self.gsd.model = text(),
            "revision" => self.gsd.revision = text(),
            "ident_number" => {
                let ident = u16::try_from(line.number(value)?);
                self.gsd.ident = ident.map_err(|_| line.wrong("the ident number is not a 16-bit number"))?;
                self.has_ident = true;
            }
            "freeze_mode_supp" => self.gsd.freeze = flag()?,
            "sync_mode_supp" => self.gsd.sync = flag()?,
            "auto_baud_supp" => self.gsd.auto_baud = flag()?,
            "set_slave_add_supp" => self.gsd.set_slave_address = flag()?,
            "fail_safe" => self.gsd.fail_safe = flag()?,
            "dpv1_slave" => self.gsd.dpv1 = flag()?,
            "wd_base_1ms_supp" => self.gsd.watchdog_1ms = flag()?,
            "ident_maintenance_supp" => self.gsd.identification = flag()?,
            "isochron_mode_supp" => self.gsd.isochronous = flag()?,
            "min_slave_intervall" => {
                self.gsd.min_slave_interval = u32::try_from(line.number(value)?).unwrap_or_default();
            }
            "max_diag_data_len" => self.gsd.max_diagnosis = Some(line.size(value)?),
            "max_input_len" => self.gsd.max_inputs = Some(line.size(value)?),
            "max_output_len" => self.gsd.max_outputs = Some(line.size(value)?),
            "max_user_prm_data_len" => self.gsd.max_user_octets = Some(line.size(value)?),
            "user_prm_data_len" => {
                self.gsd.parameters.octets = line.size(value)?;
                self.gsd.max_user_octets.get_or_insert(self.gsd.parameters.octets);
            }
            "user_prm_data" => self.gsd.parameters.constants.push((0, line.octets(value)?)),
            "ext_user_prm_data_const" | "ext_user_prm_data_ref" => {
                let mut parameters = std::mem::take(&mut self.gsd.parameters);
                self.parameter(line, (&word, place, value), &mut parameters)?;
                self.gsd.parameters = parameters;
            }
            "extuserprmdata" => self.field(line, value, rest)?,
            "module" => self.module(line, value, rest)?,
            "prmtext" => self.texts(line, value, rest)?,
            "unit_diag_area" => skip(line, rest, "unit_diag_area_end")?,
            "unitdiagtype" => skip(line, rest, "endunitdiagtype")?,
            _ => {
                let known = |of: &str| BAUDS.iter().find(|baud| baud.eq_ignore_ascii_case(of)).copied();
                if let Some(baud) = word.strip_suffix("_supp").and_then(known)
                    && flag()?
                {
                    self.gsd.bauds.push(baud.to_owned());
                }
                if let Some(baud) = word.strip_prefix("maxtsdr_").and_then(known) {
                    let bits = u16::try_from(line.number(value)?);
                    let bits = bits.map_err(|_| line.wrong("max TSDR is not a 16-bit number of bit times"))?;
                    self.gsd.max_tsdr.push((rate(baud), BitTimes(bits.into())));
                }
            }
        }
        Ok(())
    }

    /// Reads a constant or a field of the user bytes.
    fn parameter(
        &self,
        line: &GsdLine,
        (word, place, value): (&str, Option<&str>, &str),
        parameters: &mut GsdParameters,
    ) -> Result<(), GsdError> {
        let at = line.size(place.ok_or_else(|| line.wrong("an offset in brackets is missing"))?)?;
        let octets = match word {
            "ext_user_prm_data_const" => {
                let octets = line.octets(value)?;
                let end = at + octets.len();
                parameters.constants.push((at, octets));
                end
            }
            _ => {
                let id = line.number(value)?;
                let field = self.fields.get(&id);
                let field = field
                    .ok_or_else(|| line.wrong(format!("`ExtUserPrmData={id}` is not defined before this line")))?;
                parameters.fields.push((at, field.clone()));
                at + field.kind.octets()
            }
        };
        parameters.octets = parameters.octets.max(octets);
        Ok(())
    }

    fn field(&mut self, line: &GsdLine, value: &str, rest: GsdLines<'_, '_>) -> Result<(), GsdError> {
        let (id, name) = value.split_once('"').ok_or_else(|| line.wrong("a field needs a number and a name"))?;
        let name = name.split('"').next().unwrap_or_default().to_owned();
        let id = line.number(id.trim())?;
        let Some(kind) = rest.next() else { return Err(line.wrong("the file ends in the middle of a field")) };
        let mut field = described(kind, name)?;
        for inside in rest.by_ref() {
            if is_keyword(inside, "endextuserprmdata") {
                self.fields.insert(id, field);
                return Ok(());
            }
            if let Some((word, _, value)) = inside.setting()
                && word == "prm_text_ref"
            {
                field.texts = self.texts.get(&inside.number(value)?).cloned().unwrap_or_default();
            }
        }
        Err(unfinished(line, "endextuserprmdata"))
    }

    fn texts(&mut self, line: &GsdLine, value: &str, rest: GsdLines<'_, '_>) -> Result<(), GsdError> {
        let id = line.number(value)?;
        let mut texts = Vec::new();
        for inside in rest.by_ref() {
            if is_keyword(inside, "endprmtext") {
                self.texts.insert(id, texts);
                return Ok(());
            }
            if let Some((word, Some(number), value)) = inside.setting()
                && word == "text"
            {
                texts.push((inside.number(number)?, quoted(value).map_or(value, |(text, _)| text).to_owned()));
            }
        }
        Err(unfinished(line, "endprmtext"))
    }

    fn module(&mut self, line: &GsdLine, value: &str, rest: GsdLines<'_, '_>) -> Result<(), GsdError> {
        let (name, cfg) = quoted(value).ok_or_else(|| line.wrong("a module needs a name and its identifiers"))?;
        let mut module =
            GsdModule { name: name.to_owned(), cfg: line.octets(cfg)?, parameters: GsdParameters::default() };
        for inside in rest.by_ref() {
            if inside.text.eq_ignore_ascii_case("endmodule") {
                self.gsd.modules.push(module);
                return Ok(());
            }
            match inside.setting() {
                Some((word, _, value)) if word == "ext_module_prm_data_len" => {
                    module.parameters.octets = inside.size(value)?;
                }
                Some((word, place, value)) if word.starts_with("ext_user_prm_data_") => {
                    self.parameter(inside, (&word, place, value), &mut module.parameters)?;
                }
                _ => {}
            }
        }
        Err(line.wrong("`EndModule` is missing"))
    }
}

/// The field described by the line with its type, default and allowed values.
fn described(line: &GsdLine, name: String) -> Result<GsdField, GsdError> {
    let (word, after) = match line.text.find(')') {
        Some(end) if line.text.to_ascii_lowercase().starts_with("bit") => line.text.split_at(end + 1),
        _ => line.text.split_once(char::is_whitespace).unwrap_or((&line.text, "")),
    };
    let kind = field_type(line, word.trim())?;
    let mut parts = after.split_whitespace();
    let default = line.number(parts.next().ok_or_else(|| line.wrong("a field needs a default"))?)?;
    let allowed: String = parts.collect();
    let range = match allowed.get(1..).and_then(|_| allowed[1..].find('-').map(|at| at + 1)) {
        _ if allowed.is_empty() => None,
        Some(at) => Some((line.number(&allowed[..at])?, line.number(&allowed[at + 1..])?)),
        None => {
            let numbers = allowed.split(',').map(|number| line.number(number)).collect::<Result<Vec<_>, _>>()?;
            numbers.iter().min().copied().zip(numbers.iter().max().copied())
        }
    };
    Ok(GsdField { name, kind, default, range, texts: Vec::new() })
}

fn field_type(line: &GsdLine, word: &str) -> Result<FieldType, GsdError> {
    let lower = word.to_ascii_lowercase();
    let octets = |octets, signed| Ok(FieldType::Octets { octets, signed });
    match lower.as_str() {
        "unsigned8" => octets(1, false),
        "unsigned16" => octets(2, false),
        "unsigned32" => octets(4, false),
        "signed8" => octets(1, true),
        "signed16" => octets(2, true),
        "signed32" => octets(4, true),
        _ => {
            let unknown = || line.wrong(format!("`{}` is not a field type", word.escape_debug()));
            let inside = lower.split_once('(').map(|(_, inside)| inside.trim_end_matches(')')).ok_or_else(unknown)?;
            let (low, high) = inside.split_once('-').unwrap_or((inside, inside));
            let bit = |text: &str| text.trim().parse::<u8>().ok().filter(|bit| *bit < 8);
            match (lower.starts_with("bit"), bit(low), bit(high)) {
                (true, Some(low), Some(high)) if low <= high => Ok(FieldType::Bits { low, high }),
                _ => Err(unknown()),
            }
        }
    }
}

/// Skips the lines up to `end`.
fn skip(line: &GsdLine, rest: GsdLines<'_, '_>, end: &str) -> Result<(), GsdError> {
    if rest.any(|inside| is_keyword(inside, end)) { Ok(()) } else { Err(unfinished(line, end)) }
}

/// Whether a line begins with a keyword, which is in lower case.
fn is_keyword(line: &GsdLine, word: &str) -> bool {
    line.text.to_ascii_lowercase().replace(' ', "").starts_with(word)
}

fn unfinished(line: &GsdLine, end: &str) -> GsdError {
    line.wrong(format!("the file ends inside the group that begins here: `{end}` is missing"))
}
