//! The start parameters of a manual in a vendor's description, as lines of a bench file that a person confirms, and a table of doubts.

use super::super::vendor_file::DescriptionFile;
use description::gsdml::Overlay;
use description::record_match::FoundParameter;
use std::fmt::Write as _;
use suite::device::DeviceDescription;

/// The start parameters of a manual, and what was found for each in a description.
pub(super) struct ParameterMapping {
    /// The title of the description: `GSDML` or `GSD`.
    title: &'static str,
    lines: Vec<MappedParameter>,
    /// Values of the description that cannot be used, as sentences.
    missing: Vec<String>,
}

/// A start parameter of the manual.
struct MappedParameter {
    found: FoundParameter,
    /// Its other names in the manual.
    called: Vec<String>,
}

/// The mapping of the start parameters of a device with a description.
pub(super) fn of(device: &DeviceDescription, variant: usize, file: &DescriptionFile) -> ParameterMapping {
    let Overlay { parameters, missing, .. } = file.overlay(&mut device.clone(), variant);
    let called = |name: &str| {
        let fields = device.records.iter().filter(|record| record.start).flat_map(|record| &record.fields);
        fields.into_iter().find(|field| field.name == name).map(|field| field.called.clone()).unwrap_or_default()
    };
    let lines = parameters.into_iter().map(|found| MappedParameter { called: called(&found.field), found }).collect();
    let missing = missing.into_iter().filter(|text| text.starts_with("the layout of")).collect();
    ParameterMapping { title: file.kind.title(), lines, missing }
}

impl ParameterMapping {
    /// The lines of `start_parameters`, each with a comment; those in doubt are commented out. Empty if there is none.
    pub(super) fn lines(&self) -> String {
        let mut out = String::new();
        if self.lines.is_empty() {
            return out;
        }
        // Writing into a String cannot fail.
        let _ = writeln!(
            out,
            "# Start parameters: name in device.yaml, name in the {}. Confirm or correct each line.",
            self.title
        );
        if self.lines.iter().all(|line| line.found.doubt.is_some()) {
            let _ = writeln!(out, "# start_parameters:");
        } else {
            let _ = writeln!(out, "start_parameters:");
        }
        for MappedParameter { found, called } in &self.lines {
            let manual = std::iter::once(found.field.replace('_', " ")).chain(called.iter().cloned());
            let manual = manual.map(|name| quoted(&name)).collect::<Vec<_>>().join(" or ");
            let (name, place) = match &found.described {
                Some((name, place)) => (scalar(name), format!("{} {}, {place}", self.title, quoted(name))),
                None => ("...".to_owned(), format!("{} nothing", self.title)),
            };
            let line = match &found.doubt {
                None => format!("  {}: {name}   # manual {manual}; {place}; found by its meaning", found.field),
                Some(doubt) => format!("#  {}: {name}   # manual {manual}; {place}; decide: {doubt}", found.field),
            };
            let _ = writeln!(out, "{line}");
        }
        out
    }

    /// The parameters that a person has to decide on, as a table of manual, description and decision; `None` if there is none.
    pub(super) fn table(&self) -> Option<String> {
        let doubtful = self.lines.iter().filter_map(|line| Some((&line.found, line.found.doubt.as_ref()?)));
        let rows: Vec<[String; 3]> = doubtful
            .map(|(found, doubt)| {
                let described = found.described.as_ref().map_or("-".to_owned(), |(name, _)| quoted(name));
                [found.field.clone(), described, doubt.clone()]
            })
            .collect();
        // What is in the rows already is not repeated.
        let others: Vec<&String> =
            self.missing.iter().filter(|text| rows.iter().all(|row| !text.contains(&row[2]))).collect();
        if rows.is_empty() && others.is_empty() {
            return None;
        }
        let mut out =
            format!("start parameters of the {} in doubt; nothing is sent until the bench file decides\n", self.title);
        if !rows.is_empty() {
            let head = ["manual".to_owned(), self.title.to_owned(), "decision".to_owned()];
            let all = || std::iter::once(&head).chain(&rows);
            let width = |column: usize| all().map(|row| row[column].chars().count()).max().unwrap_or_default();
            let (first, second) = (width(0), width(1));
            for [manual, described, decision] in all() {
                // Writing into a String cannot fail.
                let _ = writeln!(out, "  {manual:<first$}  {described:<second$}  {decision}");
            }
        }
        for text in others {
            let _ = writeln!(out, "  {text}");
        }
        Some(out)
    }
}

/// A text of a file in quotes.
fn quoted(text: &str) -> String {
    format!("`{}`", text.escape_debug())
}

/// A text as a scalar of YAML.
fn scalar(text: &str) -> String {
    let is_plain = text.chars().all(|letter| letter.is_alphanumeric() || " _/().-".contains(letter));
    let begins = text.chars().next().is_some_and(char::is_alphabetic);
    let is_word = ["true", "false", "null", "yes", "no", "on", "off"].contains(&text.to_lowercase().as_str());
    if is_plain && begins && !is_word && text.trim() == text {
        text.to_owned()
    } else {
        let escaped: String = text
            .chars()
            .map(|letter| match letter {
                '"' => "\\\"".to_owned(),
                '\\' => "\\\\".to_owned(),
                letter if letter.is_control() => format!("\\u{:04X}", u32::from(letter)),
                letter => letter.to_string(),
            })
            .collect();
        format!("\"{escaped}\"")
    }
}
