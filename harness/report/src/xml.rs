//! A writer of XML 1.0, indented by four, for the JUnit report.
//!
//! Every text becomes well-formed: markup characters are escaped, and characters that XML 1.0 forbids (section 2.2) are written as
//! `\u{7}`, so that none is dropped. This module must not know what a report contains.

use std::fmt::Write as _;

/// Names and values of the attributes of an element, in order.
pub(super) type Attributes<'a> = &'a [(&'a str, &'a str)];

/// Writes elements one after the other; the caller ends each element that it starts.
#[derive(Debug)]
pub(super) struct XmlWriter {
    text: String,
    open: Vec<&'static str>,
}

impl XmlWriter {
    /// An empty document.
    pub fn new() -> XmlWriter {
        XmlWriter { text: r#"<?xml version="1.0" encoding="UTF-8"?>"#.to_owned(), open: Vec::new() }
    }

    /// Starts an element that contains others; [`end`](Self::end) closes it.
    pub fn start(&mut self, name: &'static str, attributes: Attributes<'_>) {
        self.tag(name, attributes);
        self.text.push('>');
        self.open.push(name);
    }

    /// Writes an empty element.
    pub fn empty(&mut self, name: &'static str, attributes: Attributes<'_>) {
        self.tag(name, attributes);
        self.text.push_str("/>");
    }

    /// Writes an element with text.
    pub fn text(&mut self, name: &'static str, attributes: Attributes<'_>, text: &str) {
        self.tag(name, attributes);
        self.text.push('>');
        self.escape(text, false);
        // Writing into a String cannot fail.
        let _ = write!(self.text, "</{name}>");
    }

    /// Ends the last element that was started.
    pub fn end(&mut self) {
        if let Some(name) = self.open.pop() {
            self.line();
            let _ = write!(self.text, "</{name}>");
        }
    }

    /// The document, ending in a line feed.
    pub fn finish(mut self) -> String {
        while !self.open.is_empty() {
            self.end();
        }
        self.text.push('\n');
        self.text
    }

    fn tag(&mut self, name: &str, attributes: Attributes<'_>) {
        self.line();
        let _ = write!(self.text, "<{name}");
        for (name, value) in attributes {
            let _ = write!(self.text, " {name}=\"");
            self.escape(value, true);
            self.text.push('"');
        }
    }

    fn line(&mut self) {
        self.text.push('\n');
        self.text.extend(std::iter::repeat_n("    ", self.open.len()));
    }

    fn escape(&mut self, text: &str, in_attribute: bool) {
        for c in text.chars() {
            match c {
                '<' => self.text.push_str("&lt;"),
                '>' => self.text.push_str("&gt;"),
                '&' => self.text.push_str("&amp;"),
                '\'' => self.text.push_str("&apos;"),
                '"' => self.text.push_str("&quot;"),
                // XML parsers normalise them: the first two to spaces in attributes (3.3.3), the last one to a line feed everywhere (2.11).
                '\t' | '\n' if in_attribute => _ = write!(self.text, "&#{};", u32::from(c)),
                '\r' => self.text.push_str("&#13;"),
                '\0'..='\u{8}' | '\u{B}' | '\u{C}' | '\u{E}'..='\u{1F}' | '\u{FFFE}' | '\u{FFFF}' => {
                    self.text.extend(c.escape_unicode());
                }
                _ => self.text.push(c),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rstest::rstest;

    #[test]
    fn nested_elements_are_indented_by_four() {
        let mut xml = XmlWriter::new();
        xml.start("a", &[("x", "1"), ("y", "<\"2\">")]);
        xml.start("b", &[]);
        xml.empty("c", &[("z", "'&'")]);
        xml.text("d", &[], "two\nlines");
        xml.end();
        xml.empty("e", &[]);
        let expected = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<a x=\"1\" y=\"&lt;&quot;2&quot;&gt;\">\n    <b>\n        \
                      <c z=\"&apos;&amp;&apos;\"/>\n        <d>two\nlines</d>\n    </b>\n    <e/>\n</a>\n";
        assert_eq!(xml.finish(), expected);
    }

    /// XML 1.0 allows tab, line feed, carriage return, and all characters from the space on except two.
    #[rstest]
    #[case::of_a_terminal("\u{1b}[2J\u{7}", "\\u{1b}[2J\\u{7}")]
    #[case::zero("\0", "\\u{0}")]
    #[case::no_characters("\u{FFFE}\u{FFFF}", "\\u{fffe}\\u{ffff}")]
    #[case::allowed("\t\n\u{7F}\u{85}\u{FFFD}\u{10FFFF}", "\t\n\u{7F}\u{85}\u{FFFD}\u{10FFFF}")]
    #[case::end_of_line("a\r\nb", "a\r\nb")]
    #[case::markup("]]> &amp; <![CDATA[", "]]> &amp; <![CDATA[")]
    fn a_parser_reads_any_text_back(#[case] text: &str, #[case] read: &str) {
        let mut xml = XmlWriter::new();
        xml.start("a", &[("x", text)]);
        xml.text("b", &[], text);
        let document = xml.finish();
        let parsed = roxmltree::Document::parse(&document).expect("XML 1.0");
        let root = parsed.root_element();
        assert_eq!(root.attribute("x"), Some(read));
        assert_eq!(root.first_element_child().and_then(|b| b.text()), Some(read));
    }
}
