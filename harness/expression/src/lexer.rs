//! Splits the text of an expression into tokens.

use super::literal::{quantity, unit_of_time};
use super::{ExprError, Number};
use std::ops::Range;

/// A token and its span.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Token<'t> {
    pub(super) kind: TokenKind<'t>,
    pub(super) span: Range<usize>,
}

/// The kind of a token.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum TokenKind<'t> {
    Number(Number),
    /// A duration in nanoseconds.
    Time(Number),
    Cycles(Number),
    /// The text between the quotes.
    Text(&'t str),
    /// A name with its dots, or a keyword.
    Name(&'t str),
    Symbol(Symbol),
    End,
}

macro_rules! symbols {
    ($($text:literal $name:ident)*) => {
        /// An operator or bracket.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub(super) enum Symbol { $($name),* }

        /// Every symbol as it is written; a longer symbol comes before its prefixes.
        const SYMBOLS: &[(&str, Symbol)] = &[$(($text, Symbol::$name)),*];
    };
}

symbols! {
    "+/-" PlusMinus  "==" Equal  "!=" NotEqual  "<=" LessEqual  ">=" GreaterEqual  "<<" Left  ">>" Right
    "<" Less  ">" Greater  "+" Plus  "-" Minus  "*" Times  "/" Divide  "%" Percent
    "(" Open  ")" Close  "[" OpenList  "]" CloseList  "," Comma
}

/// Operators of other languages, and what to write instead.
const FOREIGN: &[(&str, &str)] = &[
    ("&&", "write `and`"),
    ("||", "write `or`"),
    ("=", "write `==` to compare"),
    ("!", "write `not`"),
    ("\u{b1}", "write `+/-`"),
    ("\u{2264}", "write `<=`"),
    ("\u{2265}", "write `>=`"),
    ("\u{2260}", "write `!=`"),
    ("'", "write a text in double quotes"),
    ("&", "name the bit in `device.yaml` and use its name"),
    ("|", "write `or` between conditions"),
    ("^", "write `<<` for a power of two"),
    ("{", "write conditions with `and`, or as a mapping without `=`"),
];

/// Splits `text` into tokens; the last one is always [`TokenKind::End`].
pub(super) fn tokens(text: &str) -> Result<Vec<Token<'_>>, ExprError> {
    let mut tokens: Vec<Token<'_>> = Vec::new();
    let mut at = 0;
    while let Some(rest) = text.get(at..) {
        let Some(first) = rest.chars().next() else { break };
        let length = match first {
            ' ' | '\t' | '\n' | '\r' => {
                at += 1;
                continue;
            }
            '"' => rest.get(1..).and_then(|inside| inside.find('"')).map(|end| end + 2),
            _ if first.is_ascii_alphanumeric() || first == '_' => Some(word_length(rest)),
            _ => SYMBOLS.iter().find(|(sign, _)| rest.starts_with(sign)).map(|(sign, _)| sign.len()),
        };
        let Some(length) = length else { return Err(no_token(text, at, first)) };
        let span = at..at + length;
        at = span.end;
        let word = text.get(span.clone()).unwrap_or_default();
        let kind = match first {
            '"' => TokenKind::Text(word.trim_matches('"')),
            '0'..='9' => amount(word, &span)?,
            _ if first.is_ascii_alphabetic() || first == '_' => TokenKind::Name(name(word, &span)?),
            _ => symbol(word).ok_or_else(|| no_token(text, span.start, first))?,
        };
        match (kind, tokens.last_mut()) {
            (TokenKind::Name("cycles"), Some(Token { kind: kind @ TokenKind::Number(_), span: before })) => {
                if let TokenKind::Number(count) = *kind {
                    *kind = TokenKind::Cycles(count);
                }
                before.end = span.end;
            }
            _ => tokens.push(Token { kind, span }),
        }
    }
    tokens.push(Token { kind: TokenKind::End, span: text.len()..text.len() });
    Ok(tokens)
}

fn word_length(rest: &str) -> usize {
    let part = |octet: u8| octet.is_ascii_alphanumeric() || octet == b'_' || octet == b'.';
    rest.bytes().position(|octet| !part(octet)).unwrap_or(rest.len())
}

fn symbol(word: &str) -> Option<TokenKind<'_>> {
    SYMBOLS.iter().find(|(sign, _)| *sign == word).map(|&(_, symbol)| TokenKind::Symbol(symbol))
}

fn amount<'t>(word: &'t str, span: &Range<usize>) -> Result<TokenKind<'t>, ExprError> {
    let (number, unit) = quantity(word).map_err(|error| ExprError { span: span.clone(), ..error })?;
    if unit.is_empty() {
        return Ok(TokenKind::Number(number));
    }
    if unit == "cycles" {
        return Err(
            ExprError::new(span.clone(), format!("`{word}` needs a space")).help(format!("write `{number} cycles`"))
        );
    }
    let nanos = number.times(Number::whole(unit_of_time(unit, span.clone())?));
    let too_long = || ExprError::new(span.clone(), format!("`{word}` is too long")).help("write a shorter duration");
    nanos.map(TokenKind::Time).ok_or_else(too_long)
}

fn name<'t>(word: &'t str, span: &Range<usize>) -> Result<&'t str, ExprError> {
    let is_part = |part: &str| part.starts_with(|first: char| first.is_ascii_alphabetic() || first == '_');
    if word.split('.').all(is_part) {
        return Ok(word);
    }
    Err(ExprError::new(span.clone(), format!("`{word}` is not a name"))
        .help("each part of a name begins with a letter, and dots separate the parts"))
}

fn no_token(text: &str, at: usize, first: char) -> ExprError {
    let rest = text.get(at..).unwrap_or_default();
    if first == '"' {
        return ExprError::new(at..text.len(), "this text is not closed").help("close it with a `\"`");
    }
    match FOREIGN.iter().find(|(sign, _)| rest.starts_with(sign)) {
        Some((sign, help)) => {
            ExprError::new(at..at + sign.len(), format!("`{sign}` is not an operator of this language")).help(*help)
        }
        None => ExprError::new(at..at + first.len_utf8(), format!("unexpected character `{first}`"))
            .help("remove it, or write a text in double quotes"),
    }
}
