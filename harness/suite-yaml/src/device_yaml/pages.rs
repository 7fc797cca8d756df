//! Web pages: where each is, the fields of its form, and the values that it shows.

use super::super::error::Read;
use super::super::keys::{self, FORMS, Keyed};
use super::super::yaml::Node;
use super::{Reader, flag, named, origin, word};
use suite::device::{PageForm, PageValue, WebPage};

impl<'n> Reader<'n> {
    pub(super) fn pages(&mut self) -> Vec<WebPage> {
        let mut pages: Vec<WebPage> = Vec::new();
        for (name, node) in self.entries("pages") {
            self.declare("page", name, node.spot);
            let page = self.page(name, node, &pages);
            pages.extend(self.mistakes.keep(page));
        }
        pages
    }

    fn page(&mut self, name: &str, node: &Node, others: &[WebPage]) -> Read<WebPage> {
        let keyed = Keyed::new(node, &keys::PAGE)?;
        let mut shows: Vec<PageValue> = Vec::new();
        for (value, node) in keyed.get("shows").map_or(Ok(Vec::new()), |node| named(node, "shows"))? {
            if others.iter().flat_map(|page| &page.shows).any(|known| known.name == value) {
                return Err(node.wrong(format!("another page shows `{value}` already")));
            }
            self.declare("page value", value, node.spot);
            shows.push(self.page_value(value, node)?);
        }
        let fields = keyed.get("fields").map_or(Ok(Vec::new()), fields)?;
        for (field, _) in &fields {
            self.declare("page field", &format!("{name}.{field}"), node.spot);
        }
        let path = path(keyed.must("path")?)?;
        Ok(WebPage { name: name.to_owned(), path, fields, shows, origin: origin(keyed)? })
    }

    fn page_value(&self, name: &str, node: &Node) -> Read<PageValue> {
        let keyed = Keyed::new(node, &keys::PAGE_VALUE)?;
        let form = match word(keyed.must("form")?, "form", FORMS)? {
            "decimal" => PageForm::Decimal,
            "hexadecimal" => PageForm::Hexadecimal,
            _ => PageForm::Text,
        };
        let table = keyed.get("words").map(|node| self.table(node)).transpose()?;
        if let Some(words) = keyed.get("words").filter(|_| form == PageForm::Text) {
            return Err(words.wrong("a text has no table of words"));
        }
        let behind = keyed.must("behind")?.text("a text")?.to_owned();
        Ok(PageValue { name: name.to_owned(), label: behind, form, steps: flag(keyed, "steps")?, table })
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
