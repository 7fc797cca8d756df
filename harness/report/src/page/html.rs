//! A page as one HTML file.

use super::{Chapter, HtmlPage, PageEntry, PagePacket, PageTable, Tone};
use base64::prelude::{BASE64_STANDARD, Engine as _};
use flate2::Compression;
use flate2::write::DeflateEncoder;
use plain_text::steers;
use std::borrow::Cow;
use std::fmt::Write as _;
use std::io::Write as _;

const STYLE: &str = include_str!("page.css");
const SCRIPT: &str = include_str!("page.js");
// The page loads nothing; everything is in the file.
const POLICY: &str = "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'";

/// Chapters longer than this, in bytes, are packed: a page of a hundred failures has to stay below 500 KB.
const PACKED_FROM: usize = 300_000;

/// The page as one HTML file; equal pages give equal files.
pub fn html(page: &HtmlPage) -> String {
    let mut out = String::new();
    let title = escape(&page.title);
    let (tone, sentence) = &page.verdict;
    let _ = write!(
        out,
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta http-equiv=\"Content-Security-Policy\" content=\"{POLICY}\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <title>{title}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n<header>\n<h1>{title}</h1>\n\
         <p class=\"verdict {}\">{}</p>\n</header>\n<main>\n",
        class(*tone),
        escape(sentence)
    );
    let mut chapters = String::new();
    for chapter in &page.chapters {
        chapter.write(&mut chapters);
    }
    if chapters.len() > PACKED_FROM {
        let _ = writeln!(
            out,
            "<noscript>This page is long and therefore packed; it needs scripts. The same is in the reports json, markdown and \
             text.</noscript>\n<script type=\"text/plain\" id=\"packed\">{}</script>",
            packed(&chapters)
        );
    } else {
        out.push_str(&chapters);
    }
    out.push_str("</main>\n");
    for (id, data) in &page.data {
        // No text in it can end the element.
        let data = crate::words::printable_json(&data.to_string()).replace('<', "\\u003c");
        let _ = writeln!(out, "<script type=\"application/json\" id=\"{id}\">{data}</script>");
    }
    let _ = write!(out, "<script>\n{SCRIPT}</script>\n</body>\n</html>\n");
    out
}

/// A text as base64 of raw deflate.
fn packed(text: &str) -> String {
    let mut encoder = DeflateEncoder::new(Vec::new(), Compression::best());
    // A vector takes everything.
    let octets = encoder.write_all(text.as_bytes()).and_then(|()| encoder.finish()).unwrap_or_default();
    BASE64_STANDARD.encode(octets)
}

/// Text for HTML, including attributes; characters that could control a terminal are escaped as well.
pub(super) fn escape(text: &str) -> Cow<'_, str> {
    let is_special = |c: char| matches!(c, '&' | '<' | '>' | '"' | '\'') || steers(c) && c != '\n';
    if !text.contains(is_special) {
        return Cow::Borrowed(text);
    }
    let mut out = String::with_capacity(text.len() + 16);
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            c if is_special(c) => out.extend(c.escape_unicode()),
            c => out.push(c),
        }
    }
    Cow::Owned(out)
}

fn class(tone: Tone) -> &'static str {
    match tone {
        Tone::Good => "good",
        Tone::Bad => "bad",
        Tone::Open => "open",
        Tone::Plain => "plain",
    }
}

fn facts(facts: &[(String, String)], out: &mut String) {
    if facts.is_empty() {
        return;
    }
    out.push_str("<dl>\n");
    for (name, value) in facts {
        let _ = writeln!(out, "<dt>{}</dt><dd>{}</dd>", escape(name), escape(value));
    }
    out.push_str("</dl>\n");
}

impl Chapter {
    fn write(&self, out: &mut String) {
        let _ = write!(out, "<section>\n<h2>{}</h2>\n", escape(&self.heading));
        facts(&self.facts, out);
        for entry in &self.entries {
            entry.write(out);
        }
        for timeline in &self.timelines {
            timeline.write(out);
        }
        for table in &self.tables {
            table.write(out);
        }
        out.push_str("</section>\n");
    }
}

impl PageEntry {
    fn write(&self, out: &mut String) {
        let _ = writeln!(
            out,
            "<details class=\"entry {}\" id=\"{}\"><summary><b>{}</b> {}</summary>",
            class(self.tone),
            escape(&self.anchor),
            escape(&self.word),
            escape(&self.head)
        );
        facts(&self.facts, out);
        if let Some(packet) = &self.packet {
            packet.write(out);
        }
        for timeline in &self.timelines {
            timeline.write(out);
        }
        out.push_str("</details>\n");
    }
}

impl PagePacket {
    fn write(&self, out: &mut String) {
        let _ = write!(
            out,
            "<table class=\"packet\"><caption>{}</caption>\n<tr><th>byte</th><th>bytes</th><th>field</th><th>value</th></tr>\n",
            escape(&self.head)
        );
        for part in &self.parts {
            let mark = self.mark.filter(|(octet, _)| part.octets.contains(octet));
            let _ = write!(
                out,
                "<tr{}><td>{}</td><td class=\"octets\">",
                if mark.is_some() { " class=\"mark\"" } else { "" },
                part.octets.start
            );
            for (at, octet) in self.octets.get(part.octets.clone()).unwrap_or_default().iter().enumerate() {
                let is_marked = mark.is_some_and(|(octet, _)| octet == part.octets.start + at);
                let _ = if is_marked { write!(out, "<mark>{octet:02x}</mark> ") } else { write!(out, "{octet:02x} ") };
            }
            let _ = write!(out, "</td><td>{}</td><td>{}", escape(&part.name), escape(&part.value));
            if let Some((octet, Some(bit))) = mark {
                let value = self.octets.get(octet).map_or(0, |octet| octet >> bit & 1);
                let _ = write!(out, " <mark>byte {octet} bit {bit} is {value}</mark>");
            }
            out.push_str("</td></tr>\n");
        }
        out.push_str("</table>\n");
    }
}

impl PageTable {
    fn write(&self, out: &mut String) {
        if self.rows.is_empty() {
            return;
        }
        let _ = write!(
            out,
            "<details class=\"list\"><summary>{} ({})</summary>\n<table><tr>",
            escape(&self.heading),
            self.rows.len()
        );
        for column in &self.columns {
            let _ = write!(out, "<th>{}</th>", escape(column));
        }
        out.push_str("</tr>\n");
        for (tone, cells) in &self.rows {
            let _ = write!(out, "<tr class=\"{}\">", class(*tone));
            for cell in cells {
                let _ = write!(out, "<td>{}</td>", escape(cell));
            }
            out.push_str("</tr>\n");
        }
        out.push_str("</table></details>\n");
    }
}
