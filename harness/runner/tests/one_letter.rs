//! One letter of every word of the shipped suites is changed in turn: each change is a mistake that the loader finds.
//!
//! Free text and labels are left out, and so is what stands in quotes. A definition that nothing uses may be called
//! anything; it is in the list of those that nothing uses. Ids of requirements are such definitions until a case names them.

use encspec::suite::model::{Manual, Step, Verb};
use encspec::suite::{Checker, Sources, load};
use std::collections::BTreeSet;
use std::ops::Range;
use std::thread;

/// Keys whose values are free text or labels.
const FREE: [&str; 10] =
    ["why", "title", "id", "row", "reason", "reading", "statement", "cites", "ambiguity", "station_type"];
/// Keys of mappings whose values are free text.
const FREE_VALUES: [&str; 5] = ["faults", "buttons", "counters", "omit", "finding"];

/// A text that is loaded with one word changed, and the words in it that are changed.
struct Piece {
    path: String,
    text: String,
    words: Vec<Range<usize>>,
}

/// The words of a line that mean something: not in quotes, not in a comment, not after a key of free text.
fn words(line: &str, start: usize, words_out: &mut Vec<Range<usize>>) {
    let bytes = line.as_bytes();
    let (mut at, mut free) = (0, false);
    let free_values = FREE_VALUES.iter().any(|key| line.trim_start().starts_with(&format!("{key}: {{")));
    while at < bytes.len() {
        let octet = bytes[at];
        match octet {
            b'#' if at == 0 || bytes[at - 1] == b' ' => return,
            b'"' | b'\'' => {
                at = bytes[at + 1..].iter().position(|&other| other == octet).map_or(bytes.len(), |end| at + end + 2);
            }
            b',' | b'}' | b']' => {
                free = false;
                at += 1;
            }
            _ if octet.is_ascii_alphanumeric() || octet == b'_' => {
                let end =
                    bytes[at..].iter().position(|&other| !(other.is_ascii_alphanumeric() || b"_-".contains(&other)));
                let end = end.map_or(bytes.len(), |end| at + end);
                let word = line[at..end].trim_end_matches('-');
                let is_key = line[end..].starts_with(':');
                if !free && octet.is_ascii_alphabetic() {
                    words_out.push(start + at..start + at + word.len());
                }
                if is_key && (FREE.contains(&word) || free_values && !FREE_VALUES.contains(&word)) {
                    // Outside of braces the text goes on to the end of the line, commas and all.
                    if !line.contains('{') {
                        return;
                    }
                    free = true;
                }
                at = end;
            }
            _ => at += 1,
        }
    }
}

fn piece(path: &str, text: String, part: Range<usize>) -> Piece {
    let (mut list, mut start) = (Vec::new(), 0);
    // How far a mapping of free texts is indented that has a line for each of them.
    let mut free: Option<usize> = None;
    for line in text.split_inclusive('\n') {
        let indent = line.len() - line.trim_start().len();
        free = free.filter(|outer| indent > *outer || line.trim().is_empty());
        if part.contains(&start) {
            let is_text = free.is_some();
            let end = if is_text { line.find(':').unwrap_or(line.len()) } else { line.len() };
            words(&line[..end], start, &mut list);
        }
        if FREE_VALUES.iter().any(|key| line.trim_end().trim_start() == format!("{key}:")) {
            free = Some(indent);
        }
        start += line.len();
    }
    Piece { path: path.to_owned(), text, words: list }
}

/// A list is taken apart into its entries, so that little is loaded for each change.
fn pieces(path: &str, text: &str) -> Vec<Piece> {
    let list = |line: &str| ["cases:\n", "rules:\n", "requirements:\n"].contains(&line);
    if !text.split_inclusive('\n').any(list) || path.starts_with("common/") {
        return vec![piece(path, text.to_owned(), 0..text.len())];
    }
    let (mut head, mut key, mut entries) = (String::new(), "", Vec::<(&str, String)>::new());
    for line in text.split_inclusive('\n') {
        match entries.last_mut() {
            _ if list(line) => key = line,
            // What stands behind a list belongs to all of the file.
            _ if line.starts_with(|c: char| c.is_ascii_alphabetic()) => {
                key = "";
                head.push_str(line);
            }
            _ if line.starts_with("  - ") && !key.is_empty() => entries.push((key, line.to_owned())),
            _ if key.is_empty() => head.push_str(line),
            Some((_, entry)) => entry.push_str(line),
            None => head.push_str(line),
        }
    }
    let head_words = piece(path, text.to_owned(), 0..head.len());
    let rest = entries.iter().map(|(key, entry)| {
        let text = format!("{head}{key}{entry}");
        let part = head.len()..text.len();
        piece(path, text, part)
    });
    [head_words].into_iter().chain(rest).collect()
}

/// The word with its middle letter changed.
fn misspelt(word: &str) -> String {
    let letters: Vec<usize> = word.char_indices().filter(|(_, c)| c.is_ascii_alphabetic()).map(|(at, _)| at).collect();
    let at = letters[letters.len() / 2];
    let new = if word[at..].starts_with(['q', 'Q']) { "w" } else { "q" };
    format!("{}{new}{}", &word[..at], &word[at + 1..])
}

/// The changes of a piece that nobody notices.
fn unnoticed(checker: &Checker, piece: &Piece, labels: &Labels) -> Vec<String> {
    if let Err(errors) = checker.check(&piece.path, &piece.text) {
        return vec![format!("{} by itself: {errors}", piece.path)];
    }
    let unseen = piece.words.iter().filter(|word| {
        let old = &piece.text[(*word).clone()];
        let text = format!("{}{}{}", &piece.text[..word.start], misspelt(old), &piece.text[word.end..]);
        !labels.has(&piece.path, old) && checker.check(&piece.path, &text).is_ok()
    });
    let named = |word: &Range<usize>| {
        let line = piece.text[..word.start].lines().count();
        let text = piece.text.lines().nth(line.saturating_sub(1)).unwrap_or_default();
        format!("{}: `{}` in: {}", piece.path, &piece.text[word.clone()], text.trim())
    };
    unseen.map(named).collect()
}

/// Words that may be changed, because they name something that nobody refers to.
#[derive(Default)]
struct Labels {
    device: BTreeSet<String>,
    requirements: BTreeSet<String>,
    topics: BTreeSet<String>,
}

impl Labels {
    fn of(manual: &Manual) -> Labels {
        let mut labels = Labels::default();
        let last = |name: &str| name.trim_end_matches('`').rsplit(['`', '.']).next().unwrap_or_default().to_owned();
        labels.device.extend(manual.unused.iter().map(|(name, _)| last(name)));
        let access_point = manual.device.submodules.iter().filter(|submodule| submodule.slot == 0);
        labels.device.extend(access_point.map(|submodule| submodule.name.clone()));
        // A page is looked at by the names of what it shows.
        labels.device.extend(manual.device.pages.iter().map(|page| page.name.clone()));
        // The only variant need not be told apart from any other.
        labels.device.extend(manual.device.variants.iter().filter(|_| manual.device.variants.len() == 1).cloned());
        labels.requirements.extend(manual.requirements.iter().map(|requirement| requirement.id.clone()));
        manual
            .variants
            .iter()
            .flat_map(|variant| &variant.trials)
            .for_each(|trial| readings(&trial.steps, &mut labels.topics));
        labels
    }

    fn has(&self, path: &str, word: &str) -> bool {
        match path.rsplit('/').next() {
            Some("device.yaml") => self.device.contains(word),
            Some(name) if name.starts_with("requirements") => self.requirements.contains(word),
            _ => self.topics.contains(word),
        }
    }
}

/// The names of the readings in `either`, which are labels.
fn readings(steps: &[Step], labels: &mut BTreeSet<String>) {
    for step in steps {
        match &step.verb {
            Verb::Block { steps, .. } => readings(steps, labels),
            Verb::Either(list) => labels.extend(list.iter().map(|reading| reading.name.clone())),
            _ => {}
        }
    }
}

#[test]
fn every_changed_word_is_noticed() {
    let sources = Sources::embedded();
    let mut looked_at = BTreeSet::new();
    for manual in load(&sources, None).expect("the shipped suites load") {
        let folder = manual.device.name.clone();
        let labels = Labels::of(&manual);
        let own = || sources.files().filter(|(path, _)| path.starts_with(&format!("{folder}/")));
        // A common suite is noticed by those who use it.
        let uses = |name: &str| own().any(|(_, text)| text.lines().any(|line| line == format!("use: {name}")));
        let mine = |path: &str| match path.split_once('/') {
            Some(("common", file)) => file == "procedures.yaml" || uses(file.trim_end_matches(".yaml")),
            Some((of, _)) => of == folder,
            None => false,
        };
        looked_at.extend(sources.files().map(|(path, _)| path).filter(|path| mine(path)).map(str::to_owned));
        let all: Vec<Piece> =
            sources.files().filter(|(path, _)| mine(path)).flat_map(|(path, text)| pieces(path, text)).collect();
        let count: usize = all.iter().map(|piece| piece.words.len()).sum();
        assert!(count > 1000, "only {count} words were found");
        let halves: Vec<Vec<&Piece>> = (0..2).map(|half| all.iter().skip(half).step_by(2).collect()).collect();
        let work = |half: &[&Piece]| -> Vec<String> {
            let checker = Checker::new(&sources, &folder).expect("it loads");
            half.iter().flat_map(|piece| unnoticed(&checker, piece, &labels)).collect()
        };
        let unseen: Vec<String> = thread::scope(|scope| {
            let tasks: Vec<_> = halves.iter().map(|half| scope.spawn(|| work(half))).collect();
            tasks.into_iter().flat_map(|task| task.join().expect("no panic")).collect()
        });
        assert!(unseen.is_empty(), "{} of {count} changes went unnoticed:\n{}", unseen.len(), unseen.join("\n"));
    }
    // Personas belong to no manual; what is wrong in them is looked for in a test of their own.
    let of_manuals = sources.files().filter(|(path, _)| !path.starts_with("personas/"));
    assert_eq!(looked_at.len(), of_manuals.count(), "only these files belong to a manual: {looked_at:?}");
}
