//! Web pages: where each is, the fields of its form, and the values that it shows.

use super::super::error::Read;
use super::super::keys::{Keyed, WordChoices};
use super::super::yaml::Node;
use super::device;
use super::plain::{ORIGINS, PATH};
use super::{DeviceReader, flag, named, origin};
use suite::device::{PageForm, PageValue, WebPage};

/// How values are written on web pages.
static FORMS: WordChoices<PageForm> =
    WordChoices(&[("decimal", PageForm::Decimal), ("hexadecimal", PageForm::Hexadecimal), ("text", PageForm::Text)]);

key_set! {
    pub(crate) page "a web page" {
        path must Pattern(&PATH), "Where it is, from the first slash on.";
        fields may Map(&Text), "The fields of its form: a name, and the one in the page.";
        shows may Map(&Keys(&page_value::KEYS)), "The values that it shows, each under a name that is unique among all pages.";
        from_source may Word(&ORIGINS), "Where all this comes from if the manual does not print it.";
    }
}

key_set! {
    pub(crate) page_value "a value on a web page" {
        behind must Text, "The text before it in the displayed page.";
        form must Word(&FORMS), "How it is written.";
        steps may Flag, "It is a place in steps.";
        words may Name, "The table of its words.";
    }
}

impl<'n> DeviceReader<'n> {
    pub(super) fn pages(&mut self) -> Vec<WebPage> {
        let mut pages: Vec<WebPage> = Vec::new();
        for (name, node) in self.entries(&device::pages) {
            self.declare("page", name, node.spot);
            let page = self.page(name, node, &pages);
            pages.extend(self.mistakes.keep(page));
        }
        pages
    }

    fn page(&mut self, name: &str, node: &Node, others: &[WebPage]) -> Read<WebPage> {
        let keyed = Keyed::new(node, &page::KEYS)?;
        let mut shows: Vec<PageValue> = Vec::new();
        for (value, node) in keyed.get(&page::shows).map_or(Ok(Vec::new()), |node| named(node, "shows"))? {
            if others.iter().flat_map(|page| &page.shows).any(|known| known.name == value) {
                return Err(node.wrong(format!("another page shows `{value}` already")));
            }
            self.declare("page value", value, node.spot);
            shows.push(self.page_value(value, node)?);
        }
        let fields = keyed.get(&page::fields).map_or(Ok(Vec::new()), fields)?;
        for (field, _) in &fields {
            self.declare("page field", &format!("{name}.{field}"), node.spot);
        }
        let path = path(keyed.must(&page::path)?)?;
        Ok(WebPage { name: name.to_owned(), path, fields, shows, origin: origin(keyed, &page::from_source)? })
    }

    fn page_value(&self, name: &str, node: &Node) -> Read<PageValue> {
        let keyed = Keyed::new(node, &page_value::KEYS)?;
        let form = FORMS.read(keyed.must(&page_value::form)?, &page_value::form)?;
        let table = keyed.get(&page_value::words).map(|node| self.table(node)).transpose()?;
        if let Some(words) = keyed.get(&page_value::words).filter(|_| form == PageForm::Text) {
            return Err(words.wrong("a text has no table of words"));
        }
        let behind = keyed.must(&page_value::behind)?.text("a text")?.to_owned();
        Ok(PageValue { name: name.to_owned(), label: behind, form, steps: flag(keyed, &page_value::steps)?, table })
    }
}

/// The path of a page.
pub fn path(node: &Node) -> Read<String> {
    let path = node.text("a path")?;
    let is_path = path.starts_with('/') && path.bytes().all(|octet| octet.is_ascii_graphic());
    if is_path { Ok(path.to_owned()) } else { Err(node.wrong("a path begins with a slash and has no spaces")) }
}

/// The fields of a form: our name and the one in the page.
pub fn fields(node: &Node) -> Read<Vec<(String, String)>> {
    let list = named(node, "fields")?;
    list.into_iter().map(|(name, node)| Ok((name.to_owned(), node.text("the name of a field")?.to_owned()))).collect()
}
