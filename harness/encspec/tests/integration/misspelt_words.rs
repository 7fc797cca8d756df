//! Changes one letter of every word of the built-in suites in turn: the loader must report each change as an error. A twelfth of
//! the words is changed each day.
//!
//! The same word under the same keys is changed once in each file. The last word of each entry is always changed, to prove that the
//! entry is read. Free text, labels and quoted text are left out. An unused definition may have any name, since it is listed as unused;
//! ids of requirements are such definitions until a case names them.

use encspec::suite::device::STANDARD_TIMES;
use encspec::suite::model::{Manual, OtherReadings, TrialStep, Verb};
use encspec::suite_yaml::{Checker, Sources, load};
use std::collections::BTreeSet;
use std::ops::Range;
use std::thread;
use testing::DailySample;

/// Keys whose values are free text or labels.
const FREE: [&str; 13] = [
    "why",
    "otherwise",
    "title",
    "id",
    "row",
    "reason",
    "reading",
    "statement",
    "cites",
    "ambiguity",
    "station_type",
    "called",
    "question",
];
/// Keys of mappings whose values are free text.
const FREE_VALUES: [&str; 8] = ["faults", "buttons", "counters", "omit", "except", "finding", "masks", "called"];

/// The pseudo key of a list in brackets.
const LIST: &str = "-";

/// A text that is loaded with one word changed, and the words to change.
struct SuitePiece {
    path: String,
    text: String,
    words: Vec<MeaningfulWord>,
}

/// A meaningful word, and the path of keys above it.
struct MeaningfulWord {
    at: Range<usize>,
    under: String,
}

/// Collects the meaningful words of a line: not in quotes, not in a comment, not after a key of free text.
///
/// The line is below the keys `above` and begins at offset `start`. Returns the first key of the line.
fn words(line: &str, start: usize, above: &str, words_out: &mut Vec<MeaningfulWord>) -> Option<String> {
    let bytes = line.as_bytes();
    let (mut at, mut free) = (0, false);
    // The key of the line, and the current key of each open mapping in braces.
    let mut keys: Vec<&str> = vec![""];
    let free_values = FREE_VALUES.iter().any(|key| line.trim_start().starts_with(&format!("{key}: {{")));
    while at < bytes.len() {
        let octet = bytes[at];
        match octet {
            b'#' if at == 0 || bytes[at - 1] == b' ' => break,
            b'"' | b'\'' => {
                at = bytes[at + 1..].iter().position(|&other| other == octet).map_or(bytes.len(), |end| at + end + 2);
            }
            b',' | b'}' | b']' => {
                free = false;
                at += 1;
                match keys.as_mut_slice() {
                    [_, .., _] if octet != b',' => drop(keys.pop()),
                    [_, .., last] if *last != LIST => *last = "",
                    _ => {}
                }
            }
            b'{' | b'[' => {
                keys.push(if octet == b'[' { LIST } else { "" });
                at += 1;
            }
            _ if octet.is_ascii_alphanumeric() || octet == b'_' => {
                let end =
                    bytes[at..].iter().position(|&other| !(other.is_ascii_alphanumeric() || b"_-".contains(&other)));
                let end = end.map_or(bytes.len(), |end| at + end);
                let word = line[at..end].trim_end_matches('-');
                let is_key = line[end..].starts_with(':');
                if !free && octet.is_ascii_alphabetic() {
                    let under = format!("{above}/{}", keys.join("/"));
                    words_out.push(MeaningfulWord { at: start + at..start + at + word.len(), under });
                }
                if let Some(last) = keys.last_mut().filter(|_| is_key) {
                    *last = word;
                }
                if is_key && (FREE.contains(&word) || free_values && !FREE_VALUES.contains(&word)) {
                    // Outside of braces free text extends to the end of the line, including commas.
                    if !line.contains('{') {
                        break;
                    }
                    free = true;
                }
                at = end;
            }
            _ => at += 1,
        }
    }
    keys.first().filter(|key| !key.is_empty()).map(|key| (*key).to_owned())
}

fn piece(path: &str, text: String, part: Range<usize>) -> SuitePiece {
    let (mut list, mut start) = (Vec::new(), 0);
    // The indentation of a mapping of free texts with one line for each.
    let mut free: Option<usize> = None;
    // The keys above the next line, each with its indentation.
    let mut above: Vec<(usize, String)> = Vec::new();
    for line in text.split_inclusive('\n') {
        let indent = line.len() - line.trim_start().len();
        free = free.filter(|outer| indent > *outer || line.trim().is_empty());
        let is_text = free.is_some();
        let end = if is_text { line.find(':').unwrap_or(line.len()) } else { line.len() };
        if !line.trim().is_empty() {
            above.retain(|(outer, _)| *outer < indent);
        }
        let path: Vec<&str> = above.iter().map(|(_, key)| key.as_str()).collect();
        let before = list.len();
        if let Some(key) = words(&line[..end], start, &path.join("/"), &mut list) {
            above.push((indent, key));
        }
        if !part.contains(&start) {
            list.truncate(before);
        }
        if FREE_VALUES.iter().any(|key| line.trim_end().trim_start() == format!("{key}:")) {
            free = Some(indent);
        }
        start += line.len();
    }
    SuitePiece { path: path.to_owned(), text, words: list }
}

/// The text with each scalar joined to one line, so that its words are next to the key and the quotes.
fn unfolded(text: &str) -> String {
    let mut lines: Vec<String> = Vec::new();
    let (mut quote, mut depth) = (None, 0_u32);
    for line in text.lines() {
        // In a flow only what is no comment goes on.
        let line = if depth > 0 && quote.is_none() { without_comment(line) } else { line };
        let continues = quote.is_some() || depth > 0 || lines.last().is_some_and(|last| continues(last, line));
        match lines.last_mut().filter(|_| continues) {
            Some(last) => last.extend([" ", line.trim_start()]),
            None => lines.push(line.to_owned()),
        }
        let mut before = ' ';
        for letter in line.chars() {
            match (quote, letter) {
                (Some(open), _) if open == letter => quote = None,
                (Some(_), _) => {}
                (None, '"' | '\'') if " [{".contains(before) => quote = Some(letter),
                (None, '#') if before == ' ' => break,
                (None, '[' | '{') => depth += 1,
                (None, ']' | '}') => depth = depth.saturating_sub(1),
                _ => {}
            }
            before = letter;
        }
    }
    lines.join("\n") + "\n"
}

/// The line of a flow without its comment.
fn without_comment(line: &str) -> &str {
    match line.trim_start().starts_with('#') {
        true => "",
        false => line.find(" #").map_or(line, |at| &line[..at]).trim_end(),
    }
}

/// Whether `line` continues the unquoted text after the key of the line `last`.
fn continues(last: &str, line: &str) -> bool {
    let entry = last.trim_start().trim_start_matches("- ");
    let is_text = entry
        .split_once(": ")
        .is_some_and(|(_, value)| !value.trim_start().starts_with(['"', '\'', '{', '[', '|', '>', '#']));
    let inner = line.trim_start();
    is_text
        && !inner.is_empty()
        && !inner.starts_with(['#', '-'])
        && line.len() - inner.len() > last.len() - entry.len()
}

/// Splits a list into its entries, so that little is loaded for each change.
fn pieces(path: &str, text: &str) -> Vec<SuitePiece> {
    let list = |line: &str| ["cases:\n", "rules:\n", "requirements:\n"].contains(&line);
    if !text.split_inclusive('\n').any(list) || path.starts_with("common/") {
        // Two halves, one for each thread.
        let half =
            text.match_indices('\n').map(|(at, _)| at + 1).find(|at| *at >= text.len() / 2).unwrap_or(text.len());
        return [0..half, half..text.len()].map(|part| piece(path, text.to_owned(), part)).into();
    }
    let (mut head, mut key, mut entries) = (String::new(), "", Vec::<(&str, String)>::new());
    for line in text.split_inclusive('\n') {
        match entries.last_mut() {
            _ if list(line) => key = line,
            // Keys after a list belong to the whole file.
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
    let mut pieces: Vec<SuitePiece> = [head_words].into_iter().chain(rest).collect();
    let mut known = BTreeSet::new();
    for SuitePiece { text, words, .. } in &mut pieces {
        let last = words.last().map(|word| word.at.start);
        words.retain(|MeaningfulWord { at, under }| {
            known.insert((under.clone(), text[at.clone()].to_owned())) || Some(at.start) == last
        });
    }
    pieces
}

/// The word with its middle letter changed.
fn misspelt(word: &str) -> String {
    let letters: Vec<usize> = word.char_indices().filter(|(_, c)| c.is_ascii_alphabetic()).map(|(at, _)| at).collect();
    let at = letters[letters.len() / 2];
    let new = if word[at..].starts_with(['q', 'Q']) { "w" } else { "q" };
    format!("{}{new}{}", &word[..at], &word[at + 1..])
}

/// The checker of a manual, and the words of the manual that may have any name.
type ManualChecker<'a> = (Checker, &'a FreeNames);

/// The changes of a piece, within the sample, that none of `readers` reports.
fn unnoticed(readers: &[ManualChecker<'_>], piece: &SuitePiece, sample: DailySample) -> Vec<String> {
    for (checker, _) in readers {
        if let Err(errors) = checker.check(&piece.path, &piece.text) {
            return vec![format!("{} by itself: {errors}", piece.path)];
        }
    }
    let is_named = |word: &&MeaningfulWord| {
        readers.iter().any(|(_, labels)| labels.is_named(&piece.path, &word.under, &piece.text[word.at.clone()]))
    };
    let words = piece.words.iter().filter(|word| !is_named(word)).map(|word| &word.at);
    let words = words.filter(|word| sample.has(word.start));
    let unreported = words.filter(|word| {
        let old = &piece.text[(*word).clone()];
        let text = format!("{}{}{}", &piece.text[..word.start], misspelt(old), &piece.text[word.end..]);
        readers
            .iter()
            .all(|(checker, labels)| !labels.has(&piece.path, old) && checker.check(&piece.path, &text).is_ok())
    });
    let named = |word: &Range<usize>| {
        let line = piece.text[..word.start].lines().count();
        let text = piece.text.lines().nth(line.saturating_sub(1)).unwrap_or_default();
        format!("{}: `{}` in: {}", piece.path, &piece.text[word.clone()], text.trim())
    };
    unreported.map(named).collect()
}

/// Words that may be changed, because they name something that nothing refers to.
#[derive(Default)]
struct FreeNames {
    device: BTreeSet<String>,
    requirements: BTreeSet<String>,
    bugs: BTreeSet<String>,
    topics: BTreeSet<String>,
    times: BTreeSet<String>,
    variations: BTreeSet<String>,
}

impl FreeNames {
    fn of(manual: &Manual) -> FreeNames {
        let mut labels = FreeNames::default();
        let last = |name: &str| name.trim_end_matches('`').rsplit(['`', '.']).next().unwrap_or_default().to_owned();
        labels.device.extend(manual.unused.iter().map(|(name, _)| last(name)));
        let access_point = manual.device.submodules.iter().filter(|submodule| submodule.slot == 0);
        labels.device.extend(access_point.map(|submodule| submodule.name.clone()));
        // A page is referred to by the names of its values.
        labels.device.extend(manual.device.pages.iter().map(|page| page.name.clone()));
        // Nothing refers to the name of the only variant.
        labels.device.extend(manual.device.variants.iter().filter(|_| manual.device.variants.len() == 1).cloned());
        // An LED may have states that no case waits for.
        labels.device.extend(manual.device.stand.leds.iter().flat_map(|(_, words)| words.iter().cloned()));
        // Another test compares the names of bugs with those of the reference device.
        labels.bugs.extend(manual.bugs.iter().map(|bug| bug.name.clone()));
        labels.requirements.extend(manual.requirements.iter().map(|requirement| requirement.id.clone()));
        // So are those of variations.
        labels.variations.extend(manual.requirements.iter().flat_map(|one| match &one.other_readings {
            OtherReadings::Varied(names) => names.clone(),
            _ => Vec::new(),
        }));
        // A time that every manual has keeps its value, and the other name is listed as unused.
        labels.times.extend(STANDARD_TIMES.iter().map(|(name, ..)| (*name).to_owned()));
        manual
            .variants
            .iter()
            .flat_map(|variant| &variant.trials)
            .for_each(|trial| readings(&trial.how().steps, &mut labels.topics));
        labels
    }

    /// Whether the word stands below a key whose names another check compares.
    fn is_named(&self, path: &str, under: &str, word: &str) -> bool {
        let key = under.trim_end_matches(['/', '-']).rsplit('/').next();
        match path.rsplit('/').next() {
            Some("device.yaml") => key == Some("timing") && self.times.contains(word),
            Some(name) if name.starts_with("requirements") => {
                key == Some("variations") && self.variations.contains(word)
            }
            _ => false,
        }
    }

    fn has(&self, path: &str, word: &str) -> bool {
        match path.rsplit('/').next() {
            Some("device.yaml") => self.device.contains(word),
            Some(name) if name.starts_with("requirements") => self.requirements.contains(word),
            Some(name) if name.starts_with("bugs") => self.bugs.contains(word),
            _ => self.topics.contains(word),
        }
    }
}

/// The names of the readings in `either`, which are labels.
fn readings(steps: &[TrialStep], labels: &mut BTreeSet<String>) {
    for step in steps {
        match &step.verb {
            Verb::Block { steps, .. } => readings(steps, labels),
            Verb::Either(list) => labels.extend(list.iter().map(|reading| reading.name.clone())),
            _ => {}
        }
    }
}

/// The changes of these files that no manual of `readers` reports, and the number of words.
fn changed(
    sources: &Sources,
    readers: &[&(Manual, FreeNames)],
    sample: DailySample,
    is_selected: impl Fn(&str) -> bool,
) -> (usize, Vec<String>) {
    let all: Vec<SuitePiece> = sources
        .files()
        .filter(|(path, _)| is_selected(path))
        .flat_map(|(path, text)| pieces(path, &unfolded(text)))
        .collect();
    let halves: Vec<Vec<&SuitePiece>> = (0..2).map(|half| all.iter().skip(half).step_by(2).collect()).collect();
    let work = |half: &[&SuitePiece]| -> Vec<String> {
        let reader = |of: &&'_ (Manual, FreeNames)| Checker::new(sources, &of.0.device.name).expect("it loads");
        let readers: Vec<ManualChecker<'_>> = readers.iter().map(|of| (reader(of), &of.1)).collect();
        half.iter().flat_map(|piece| unnoticed(&readers, piece, sample)).collect()
    };
    let unnoticed = thread::scope(|scope| {
        let tasks: Vec<_> = halves.iter().map(|half| scope.spawn(|| work(half))).collect();
        tasks.into_iter().flat_map(|task| task.join().expect("no panic")).collect()
    });
    (all.iter().map(|piece| piece.words.len()).sum(), unnoticed)
}

/// Changes in a manual are reported for that manual, changes in a common suite for at least one manual that uses it.
#[test]
fn every_changed_word_is_noticed() {
    let sample = DailySample::one_of(24);
    let sources = suites::sources();
    let manuals = load(&sources, None).expect("the shipped suites load");
    let manuals: Vec<(Manual, FreeNames)> =
        manuals.into_iter().map(|of| (FreeNames::of(&of), of)).map(|(a, b)| (b, a)).collect();
    let mut unnoticed = Vec::new();
    for of in &manuals {
        let folder = format!("{}/", of.0.device.name);
        let (count, found) = changed(&sources, &[of], sample, |path| path.starts_with(&folder));
        assert!(count > 100, "only {count} words were found");
        unnoticed.extend(found);
    }
    for (common, _) in sources.files().filter(|(path, _)| path.starts_with("common/")) {
        let name = common.trim_start_matches("common/").trim_end_matches(".yaml");
        let uses = |(path, text): (&str, &str), folder: &str| {
            path.starts_with(folder) && text.lines().any(|line| line == format!("use: {name}"))
        };
        let is_used = |of: &&(Manual, FreeNames)| {
            let folder = format!("{}/", of.0.device.name);
            name == "procedures" || sources.files().any(|file| uses(file, &folder))
        };
        let readers: Vec<_> = manuals.iter().filter(is_used).collect();
        assert!(!readers.is_empty(), "no manual uses {common}");
        unnoticed.extend(changed(&sources, &readers, sample, |path| path == common).1);
    }
    assert!(unnoticed.is_empty(), "{sample}: {} changes went unnoticed:\n{}", unnoticed.len(), unnoticed.join("\n"));
    // Personas belong to no manual and have their own test.
    let of_no_manual = |path: &&str| {
        let folder = path.split('/').next().unwrap_or_default();
        folder != "common" && folder != "personas" && manuals.iter().all(|of| of.0.device.name != folder)
    };
    assert_eq!(sources.files().map(|(path, _)| path).find(of_no_manual), None, "a file that belongs to no manual");
}
