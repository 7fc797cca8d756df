//! The `device.yaml` of a slave on PROFIBUS, from its GSD.

use super::Suite;
use super::fields::{NamedField, NewStartField, named};
use super::names::{FreshNames, comment, quoted, slug};
use super::signals::{CyclicItem, ItemForm, Signals};
use super::topics;
use description::gsd::{FieldType, Gsd, GsdModule};
use plain_text::hex;
use std::fmt::Write as _;
use wire::profibus::cfg::{Identifier, io_lengths};

/// The bytes of DP-V1 that come before the others.
const DPV1: usize = 3;
/// The rates that GSD files name, with the bits per second.
const RATES: [(&str, u32); 10] = [
    ("9.6", 9_600),
    ("19.2", 19_200),
    ("45.45", 45_450),
    ("93.75", 93_750),
    ("187.5", 187_500),
    ("500", 500_000),
    ("1.5M", 1_500_000),
    ("3M", 3_000_000),
    ("6M", 6_000_000),
    ("12M", 12_000_000),
];

/// A module of the suite.
struct NewSlaveModule<'g> {
    name: String,
    of: &'g GsdModule,
    octets: (u16, u16),
    outputs: Vec<String>,
    inputs: Vec<String>,
}

/// The suite of the slave that a GSD describes.
pub(super) fn suite(gsd: &Gsd, folder: &str) -> Result<Suite, String> {
    let (mut names, mut signals, mut decisions) = (FreshNames::default(), Signals::default(), Vec::new());
    let size = gsd.modules.iter().map(|module| gsd.default_octets(module).len()).max().unwrap_or_default();
    let mut modules: Vec<NewSlaveModule<'_>> = Vec::new();
    for of in &gsd.modules {
        let called = comment(&of.name);
        if gsd.default_octets(of).len() != size {
            decisions.push(format!(
                "the module `{called}` has another number of user bytes; describe it in a suite of its own"
            ));
            continue;
        }
        let Ok(identifiers) = Identifier::parse_all(&of.cfg) else {
            decisions.push(format!("the identifiers of the module `{called}` cannot be read, and it is left out"));
            continue;
        };
        let sums = io_lengths(&identifiers);
        let (Ok(out), Ok(input)) = (u16::try_from(sums.outputs), u16::try_from(sums.inputs)) else { continue };
        let name = names.new_name(&of.name, "module");
        let outputs = signals.of(&numbers(out, "output"), true, &mut names);
        let inputs = signals.of(&numbers(input, "input"), false, &mut names);
        modules.push(NewSlaveModule { name, of, octets: (out, input), outputs, inputs });
    }
    let Some(main) = modules.iter().find(|of| of.octets.1 > 0).or(modules.first()) else {
        return Err("the GSD has no module that can be connected".to_owned());
    };
    let rates: Vec<u32> =
        RATES.iter().filter(|(word, _)| gsd.bauds.iter().any(|known| known == word)).map(|(_, rate)| *rate).collect();
    let device = text(gsd, folder, &modules, &signals, &mut names);
    let mut files = vec![("device.yaml".to_owned(), device)];
    files.extend(topics::profibus(&main.name, &rates, gsd.ident));
    Ok(Suite { files, decisions })
}

/// Data of unknown meaning as numbers of 4, 2 and 1 bytes.
fn numbers(octets: u16, called: &str) -> Vec<CyclicItem> {
    let mut left = octets;
    let mut list = Vec::new();
    while left > 0 {
        let octets = [4, 2, 1].into_iter().find(|octets| *octets <= left).unwrap_or(1);
        let called = format!("{called} {}", list.len() + 1);
        list.push(CyclicItem { called, octets, signed: false, form: ItemForm::Number, bits: Vec::new(), remark: None });
        left -= octets;
    }
    list
}

/// The fields of the user bytes of all modules, after those of DP-V1.
fn fields(gsd: &Gsd, modules: &[NewSlaveModule<'_>], before: usize) -> Vec<NewStartField> {
    let mut list: Vec<NewStartField> = Vec::new();
    for module in modules {
        for (at, of) in gsd.fields(module.of).filter(|(at, _)| *at >= before) {
            let bits = match of.kind {
                FieldType::Bits { low, high } => Some((u32::from(low), u32::from(high - low) + 1)),
                FieldType::Octets { .. } => None,
            };
            let field = NewStartField {
                called: of.name.clone(),
                octet: at - before,
                octets: of.kind.octets(),
                bits,
                range: of.range.map(|(low, high)| (low.into(), high.into())),
                words: of.texts.iter().map(|(number, text)| (i128::from(*number), text.clone())).collect(),
            };
            let is_same = |known: &NewStartField| {
                (known.octet, known.octets, known.bits) == (field.octet, field.octets, field.bits)
            };
            if !list.iter().any(is_same) {
                list.push(field);
            }
        }
    }
    list
}

fn text(gsd: &Gsd, folder: &str, modules: &[NewSlaveModule<'_>], signals: &Signals, names: &mut FreshNames) -> String {
    let before = if gsd.dpv1 { DPV1 } else { 0 };
    let whole: Vec<Vec<u8>> = modules.iter().map(|module| gsd.default_octets(module.of)).collect();
    let octets: Vec<Vec<u8>> = whole.iter().map(|octets| octets.get(before..).unwrap_or_default().to_vec()).collect();
    let usual = octets.first().cloned().unwrap_or_default();
    let mut fields = named(&fields(gsd, modules, before), &octets, names);
    if fields.is_empty() && !usual.is_empty() {
        fields = named(&[NewStartField::unused()], &octets, names);
    }
    let mut out = String::new();
    // Writing into a String cannot fail.
    let _ = writeln!(
        out,
        "# {0} {1}, as its GSD describes it (written by `encspec suite init`). `Decide` marks what a person has to decide.\n\
         device: {folder}\nbus: profibus\ntitle: {2}\nidentity: {{ ident: {{ value: 0x{3:04X}, from_source: description }} }}\n\
         address: 8                                   # Decide: its station address; `line: {{ address: .. }}` of a bench file says another\n\
         variants: [{4}]",
        comment(&gsd.vendor),
        comment(&gsd.model),
        quoted(&format!("{} {}", gsd.vendor, gsd.model)),
        gsd.ident,
        slug(&gsd.model, "variant"),
    );
    out.push_str(TIMES);
    let tables: String = fields.iter().filter_map(NamedField::table).map(|table| format!("  {table}\n")).collect();
    if !tables.is_empty() {
        let _ = write!(out, "words:\n{tables}");
    }
    let _ = write!(out, "\n{SIGNALS}{}", signals.text());
    out.push_str("\nmodules:\n");
    for (module, octets) in modules.iter().zip(&octets) {
        let NewSlaveModule { name, of, octets: (output, input), outputs, inputs } = module;
        let _ = writeln!(out, "  {name}:                          # {}", comment(&of.name));
        let _ = writeln!(out, "    cfg: \"{}\"\n    octets: {{ out: {output}, in: {input} }}", hex(&of.cfg));
        for (key, list) in [("outputs", outputs), ("inputs", inputs)] {
            if !list.is_empty() {
                let _ = writeln!(out, "    {key}: [{}]", list.join(", "));
            }
        }
        let differs = fields.iter().filter(|field| field.value(octets) != field.value(&usual));
        let fixes: Vec<String> = differs.map(|field| format!("{}: {}", field.name, field.value(octets))).collect();
        if !fixes.is_empty() {
            let _ = writeln!(out, "    fixes:\n      {}", fixes.join("\n      "));
        }
        out.push_str("    from_source: description\n");
    }
    if !usual.is_empty() || gsd.dpv1 {
        let _ = writeln!(
            out,
            "\nset_prm:                                     # the bytes after the seven that every slave has"
        );
        let _ = writeln!(out, "  octets: {}", usual.len());
        if let Some(dpv1) = whole.first().and_then(|octets| octets.get(..DPV1)).filter(|_| gsd.dpv1) {
            let _ = writeln!(out, "  dpv1: \"{}\"", hex(dpv1));
        }
        out.push_str(if fields.is_empty() { "  fields: {}\n" } else { "  fields:\n" });
        for field in &fields {
            let _ = writeln!(out, "    {}", field.line(&usual));
        }
        out.push_str("  from_source: description\n");
    }
    let most = gsd.max_diagnosis.unwrap_or(6).clamp(6, 244);
    let lengths = if most == 6 { "[6]".to_owned() } else { format!("[6, {most}]") };
    let _ = writeln!(
        out,
        "\n# Decide: which lengths the diagnosis has, and what its bytes mean (`fields`).\ndiagnosis: {{ octets: {lengths} }}\n{CHANGES}"
    );
    out.trim_end().to_owned() + "\n"
}

const TIMES: &str = "\
# Decide: how soon the device has to react, to be ready after power-on, and to have stored what it keeps. Without a manual these are ours.
timing: { reaction: 100ms, start: 5s, power_up: 5s, save: 2s }
";

const SIGNALS: &str = "\
# Decide: a GSD does not name the cyclic data. Name them, say which are positions (`position_in: RANGE`) and have a sign, and what their
# bits mean. Then `roles: { position: [..] }` opens the common suites about positions.
";

const CHANGES: &str = "
# Decide: what changes the device for good, so that a run on a live device needs a consent for it.
# changes: { position_reference: [SIGNAL.FIELD], nvm_write: [SIGNAL.FIELD] }
";
