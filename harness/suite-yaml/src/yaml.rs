//! YAML text to a tree whose every node knows its line and column; the only file that names a YAML library.
//!
//! Every file goes through [`parse`], because any word may have to be pointed at. Duplicate keys, anchors, aliases and tags are
//! errors.

use super::error::{LoadError, Mistake, Read, Spot};
use saphyr_parser::{Event, Parser, ScalarStyle, ScanError, Span};
use std::fmt;
use std::path::Path;
use std::sync::Arc;
use suite::Location;

/// A node of the tree and where it stands.
#[derive(Clone, Debug)]
pub struct Node {
    /// Where it begins.
    pub spot: Spot,
    /// What it is.
    pub kind: NodeKind,
}

/// What a node is.
#[derive(Clone, Debug)]
pub enum NodeKind {
    /// A scalar.
    Scalar {
        /// The text without quotes.
        text: String,
        /// Whether it stands in quotes.
        quoted: bool,
    },
    /// Keys and values in the order of the file.
    Mapping(Vec<(Node, Node)>),
    /// A list.
    Sequence(Vec<Node>),
}

impl Node {
    /// The text of a scalar, in quotes or not.
    pub fn scalar(&self) -> Option<&str> {
        match &self.kind {
            NodeKind::Scalar { text, .. } => Some(text),
            _ => None,
        }
    }

    /// The text of a scalar without quotes.
    pub fn plain(&self) -> Option<&str> {
        match &self.kind {
            NodeKind::Scalar { text, quoted: false } => Some(text),
            _ => None,
        }
    }

    /// The expression of a scalar that starts with `=`.
    pub fn expression(&self) -> Option<&str> {
        self.scalar()?.strip_prefix('=')
    }

    /// Characters from the begin of the node to its text: a quote is not counted in an expression's columns.
    pub fn lead(&self) -> usize {
        usize::from(matches!(self.kind, NodeKind::Scalar { quoted: true, .. }))
    }

    /// The entries of a mapping.
    pub fn mapping(&self) -> Option<&[(Node, Node)]> {
        match &self.kind {
            NodeKind::Mapping(entries) => Some(entries),
            _ => None,
        }
    }

    /// The items of a list.
    pub fn sequence(&self) -> Option<&[Node]> {
        match &self.kind {
            NodeKind::Sequence(items) => Some(items),
            _ => None,
        }
    }

    /// The value of a key of a mapping.
    pub fn get(&self, key: &str) -> Option<&Node> {
        self.mapping()?.iter().find(|(known, _)| known.scalar() == Some(key)).map(|(_, value)| value)
    }

    /// The node of a key of a mapping, to point at; this node if there is none.
    pub fn key(&self, key: &str) -> &Node {
        let entry = self.mapping().unwrap_or_default().iter().find(|(known, _)| known.scalar() == Some(key));
        entry.map_or(self, |(key, _)| key)
    }

    /// What kind of node it is, for messages.
    pub fn what(&self) -> &'static str {
        match &self.kind {
            NodeKind::Scalar { text, quoted: false } if text.is_empty() => "nothing",
            NodeKind::Scalar { .. } => "a single value",
            NodeKind::Mapping(_) => "a mapping",
            NodeKind::Sequence(_) => "a list",
        }
    }

    /// The entries, or the mistake that this is no mapping.
    pub fn entries(&self, what: &str) -> Read<&[(Node, Node)]> {
        self.mapping().ok_or_else(|| self.should_be(what, "a mapping `{ ... }`"))
    }

    /// The items, or the mistake that this is no list.
    pub fn items(&self, what: &str) -> Read<&[Node]> {
        self.sequence().ok_or_else(|| self.should_be(what, "a list `[...]`"))
    }

    /// The text, or the mistake that this is no scalar or an empty one.
    pub fn text(&self, what: &str) -> Read<&str> {
        match &self.kind {
            NodeKind::Scalar { text, quoted } if *quoted || !text.is_empty() => Ok(text),
            _ => Err(self.should_be(what, "a single value")),
        }
    }

    /// The mistake that this is something else than it should be.
    pub fn should_be(&self, what: &str, wanted: &str) -> Box<Mistake> {
        Mistake::new(self.spot, format!("{what} is {wanted}, not {}", self.what()))
    }

    /// The mistake `message` at this node.
    pub fn wrong(&self, message: impl Into<String>) -> Box<Mistake> {
        Mistake::new(self.spot, message)
    }
}

/// As one line of flow style, as the reports show a step.
impl fmt::Display for Node {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.kind {
            NodeKind::Scalar { text, quoted: true } => write!(f, "'{text}'"),
            NodeKind::Scalar { text, quoted: false } => f.write_str(text),
            NodeKind::Mapping(entries) if entries.is_empty() => f.write_str("{}"),
            NodeKind::Mapping(entries) => {
                for (index, (key, value)) in entries.iter().enumerate() {
                    write!(f, "{}{key}: {value}", if index == 0 { "{ " } else { ", " })?;
                }
                f.write_str(" }")
            }
            NodeKind::Sequence(items) => {
                for (index, item) in items.iter().enumerate() {
                    write!(f, "{}{item}", if index == 0 { "[" } else { ", " })?;
                }
                f.write_str(if items.is_empty() { "[]" } else { "]" })
            }
        }
    }
}

/// Reads the one document of a file.
pub fn parse(file: u16, text: &str) -> Read<Node> {
    let mut reader = YamlReader { parser: Parser::new_from_str(text), file };
    match reader.next()? {
        (Event::StreamStart, _) => {}
        (_, span) => return Err(Mistake::new(reader.spot(span), "this is no YAML")),
    }
    let root = match reader.next()? {
        (Event::DocumentStart(_), _) => {
            let (event, span) = reader.next()?;
            reader.node(event, span)?
        }
        (_, span) => return Err(Mistake::new(reader.spot(span), "the file is empty")),
    };
    reader.next()?;
    match reader.next()? {
        (Event::StreamEnd, _) => Ok(root),
        (_, span) => {
            Err(Mistake::new(reader.spot(span), "a file holds one YAML document, and here a second one begins"))
        }
    }
}

struct YamlReader<'t> {
    parser: Parser<'t, saphyr_parser::StrInput<'t>>,
    file: u16,
}

impl<'t> YamlReader<'t> {
    fn next(&mut self) -> Read<(Event<'t>, Span)> {
        match self.parser.next_event() {
            Some(Ok(event)) => Ok(event),
            Some(Err(error)) => Err(self.broken(&error)),
            None => Ok((Event::StreamEnd, Span::default())),
        }
    }

    fn broken(&self, error: &ScanError) -> Box<Mistake> {
        let (line, column) = (error.marker().line() as u32, error.marker().col() as u32 + 1);
        Mistake::new(Spot { file: self.file, line, column, width: 1 }, format!("this is no YAML: {}", error.info()))
    }

    fn spot(&self, span: Span) -> Spot {
        let width =
            if span.start.line() == span.end.line() { span.end.col().saturating_sub(span.start.col()) } else { 0 };
        Spot {
            file: self.file,
            line: span.start.line() as u32,
            column: span.start.col() as u32 + 1,
            width: width as u32,
        }
    }

    fn node(&mut self, event: Event<'t>, span: Span) -> Read<Node> {
        let spot = self.spot(span);
        let (anchor, tag) = match &event {
            Event::Scalar(_, _, anchor, tag) => (*anchor, tag.is_some()),
            Event::SequenceStart(anchor, tag) | Event::MappingStart(anchor, tag) => (*anchor, tag.is_some()),
            Event::Alias(_) => {
                return Err(
                    Mistake::new(spot, "suites have no aliases").help("write the value out, or use a procedure")
                );
            }
            _ => return Err(Mistake::new(spot, "here a value is missing")),
        };
        if anchor != 0 {
            return Err(Mistake::new(spot, "suites have no anchors").help("write the value out, or use a procedure"));
        }
        if tag {
            return Err(Mistake::new(spot, "suites have no tags").help("quote the value if it begins with `!`"));
        }
        let kind = match event {
            Event::Scalar(text, style, _, _) => {
                NodeKind::Scalar { text: text.into_owned(), quoted: style != ScalarStyle::Plain }
            }
            Event::SequenceStart(..) => NodeKind::Sequence(self.sequence()?),
            _ => NodeKind::Mapping(self.mapping()?),
        };
        Ok(Node { spot, kind })
    }

    fn sequence(&mut self) -> Read<Vec<Node>> {
        let mut items = Vec::new();
        loop {
            match self.next()? {
                (Event::SequenceEnd, _) => return Ok(items),
                (event, span) => items.push(self.node(event, span)?),
            }
        }
    }

    fn mapping(&mut self) -> Read<Vec<(Node, Node)>> {
        let mut entries: Vec<(Node, Node)> = Vec::new();
        loop {
            let key = match self.next()? {
                (Event::MappingEnd, _) => return Ok(entries),
                (event, span) => self.node(event, span)?,
            };
            let Some(name) = key.scalar() else {
                return Err(key.wrong("a key is a single word"));
            };
            if let Some((first, _)) = entries.iter().find(|(known, _)| known.scalar() == Some(name)) {
                let first = first.spot.line;
                return Err(key.wrong(format!("duplicate key `{name}`, it stands already in line {first}")));
            }
            let (event, span) = self.next()?;
            entries.push((key, self.node(event, span)?));
        }
    }
}

/// Reads a file that is no part of a suite by `read`; `path` is how the file is shown.
pub fn read_file<T>(path: &Path, text: &str, read: impl FnOnce(&Node) -> Read<T>) -> Result<T, LoadError> {
    parse(0, text).and_then(|node| read(&node)).map_err(|mistake| {
        let line = text.lines().nth((mistake.spot.line as usize).saturating_sub(1)).unwrap_or_default().to_owned();
        let at = Location { file: Arc::new(path.to_owned()), line: mistake.spot.line, column: mistake.spot.column };
        LoadError { at, width: mistake.spot.width.max(1) as usize, line, message: mistake.message, help: mistake.help }
    })
}

/// Whether a name stands somewhere as a word of its own, outside `why`.
pub(crate) fn mentions(node: &Node, name: &str) -> bool {
    let said = |text: &str| {
        text.split(|c: char| !(c.is_ascii_alphanumeric() || c == '_' || c == '-')).any(|word| word == name)
    };
    match &node.kind {
        NodeKind::Scalar { text, .. } => said(text),
        NodeKind::Sequence(items) => items.iter().any(|item| mentions(item, name)),
        NodeKind::Mapping(entries) => entries.iter().any(|(key, value)| {
            key.scalar() != Some("why") && (key.expression().is_some_and(said) || mentions(value, name))
        }),
    }
}
