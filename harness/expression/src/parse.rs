//! The parser: builds the syntax tree from tokens. It does not resolve names or types.

use super::ast::{Ast, AstNode, Binary, Comparison, ToleranceNode};
use super::lexer::{Symbol, Token, TokenKind, tokens};
use super::{Allow, ExprError};
use std::ops::Range;

/// Maximum nesting depth of an expression, and maximum length of a chain of operators.
pub(super) const MAX_DEPTH: u32 = 64;

/// Maximum length of the text of an expression, in bytes.
const MAX_TEXT: usize = 4096;

type Parsed<'t> = Result<Ast<'t>, ExprError>;

/// Parses the whole text as a condition.
pub(super) fn condition(text: &str, allow: Allow) -> Parsed<'_> {
    let mut parser = Parser::new(text, allow)?;
    let tree = parser.condition()?;
    parser.end()?;
    Ok(tree)
}

/// Parses the whole text as a right side: `sum [ +/- sum [%] ]`.
pub(super) fn right_side(text: &str, allow: Allow) -> Result<(Ast<'_>, Option<ToleranceNode<'_>>), ExprError> {
    let mut parser = Parser::new(text, allow)?;
    let tree = if parser.allow.choice && parser.is_word("if") { parser.choice()? } else { parser.sum()? };
    let deviation = parser.deviation()?;
    parser.end()?;
    Ok((tree, deviation))
}

struct Parser<'t> {
    tokens: Vec<Token<'t>>,
    at: usize,
    depth: u32,
    allow: Allow,
}

impl<'t> Parser<'t> {
    fn new(text: &'t str, allow: Allow) -> Result<Parser<'t>, ExprError> {
        if text.len() > MAX_TEXT {
            return Err(ExprError::new(0..0, "this expression is too long").help("`save` a part of it under a name"));
        }
        Ok(Parser { tokens: tokens(text)?, at: 0, depth: 0, allow })
    }

    fn kind(&self) -> TokenKind<'t> {
        self.tokens.get(self.at).map_or(TokenKind::End, |token| token.kind)
    }

    fn span(&self) -> Range<usize> {
        self.tokens.get(self.at).map_or(0..0, |token| token.span.clone())
    }

    fn is_word(&self, word: &str) -> bool {
        self.kind() == TokenKind::Name(word)
    }

    fn take_word(&mut self, word: &str) -> bool {
        let taken = self.is_word(word);
        self.at += usize::from(taken);
        taken
    }

    fn take(&mut self, symbol: Symbol) -> bool {
        let taken = self.kind() == TokenKind::Symbol(symbol);
        self.at += usize::from(taken);
        taken
    }

    fn expect_symbol(&mut self, symbol: Symbol, written: &str, help: &str) -> Result<Range<usize>, ExprError> {
        let span = self.span();
        if self.take(symbol) { Ok(span) } else { Err(ExprError::new(span, format!("expected `{written}`")).help(help)) }
    }

    fn node(&self, kind: AstNode<'t>, span: Range<usize>, children: u32) -> Parsed<'t> {
        if children < MAX_DEPTH { Ok(Ast { kind, span, depth: children + 1 }) } else { Err(too_deep(span)) }
    }

    fn condition(&mut self) -> Parsed<'t> {
        let first = self.conjunction()?;
        self.chain(first, "or", Parser::conjunction, AstNode::Or)
    }

    fn conjunction(&mut self) -> Parsed<'t> {
        let first = self.negation()?;
        self.chain(first, "and", Parser::negation, AstNode::And)
    }

    fn chain(
        &mut self,
        first: Ast<'t>,
        word: &str,
        part: fn(&mut Parser<'t>) -> Parsed<'t>,
        node: fn(Vec<Ast<'t>>) -> AstNode<'t>,
    ) -> Parsed<'t> {
        if !self.is_word(word) {
            return Ok(first);
        }
        let (start, mut depth, mut end) = (first.span.start, first.depth, first.span.end);
        let mut parts = vec![first];
        while self.take_word(word) {
            let next = part(self)?;
            (depth, end) = (depth.max(next.depth), next.span.end);
            parts.push(next);
        }
        self.node(node(parts), start..end, depth)
    }

    fn negation(&mut self) -> Parsed<'t> {
        let start = self.span().start;
        if !self.take_word("not") {
            return self.comparison();
        }
        if self.is_word("not") {
            return Err(ExprError::new(self.span(), "a second `not` cancels the first").help("remove both"));
        }
        let inner = self.comparison()?;
        let (span, depth) = (start..inner.span.end, inner.depth);
        self.node(AstNode::Not(Box::new(inner)), span, depth)
    }

    fn comparison(&mut self) -> Parsed<'t> {
        let left = self.sum()?;
        let start = left.span.start;
        if self.take_word("in") {
            let help = "write the values in brackets: `x in [1, 2]`";
            self.expect_symbol(Symbol::OpenList, "[", help)?;
            let (list, depth, end) = self.list(Symbol::CloseList, "]", help)?;
            let depth = depth.max(left.depth);
            return self.node(AstNode::In(Box::new(left), list), start..end, depth);
        }
        let Some(sign) = self.comparison_sign() else { return Ok(left) };
        self.at += 1;
        let right = self.sum()?;
        let (mut end, mut depth) = (right.span.end, left.depth.max(right.depth));
        let sign_span = self.span();
        let deviation = self.deviation()?;
        if let Some(deviation) = &deviation {
            if !matches!(sign, Comparison::Equal | Comparison::NotEqual) {
                return Err(ExprError::new(sign_span, "a tolerance is allowed after `==` and `!=` only")
                    .help("add it to the limit, or compare with `==`"));
            }
            (end, depth) = (deviation.amount.span.end, depth.max(deviation.amount.depth));
        }
        if self.comparison_sign().is_some() {
            return Err(
                ExprError::new(self.span(), "comparisons cannot be chained").help("join two comparisons with `and`")
            );
        }
        let node = AstNode::Compare(sign, Box::new(left), Box::new(right), deviation.map(Box::new));
        self.node(node, start..end, depth)
    }

    fn comparison_sign(&self) -> Option<Comparison> {
        Some(match self.kind() {
            TokenKind::Symbol(Symbol::Equal) => Comparison::Equal,
            TokenKind::Symbol(Symbol::NotEqual) => Comparison::NotEqual,
            TokenKind::Symbol(Symbol::Less) => Comparison::Less,
            TokenKind::Symbol(Symbol::LessEqual) => Comparison::LessEqual,
            TokenKind::Symbol(Symbol::Greater) => Comparison::Greater,
            TokenKind::Symbol(Symbol::GreaterEqual) => Comparison::GreaterEqual,
            _ => return None,
        })
    }

    fn deviation(&mut self) -> Result<Option<ToleranceNode<'t>>, ExprError> {
        if !self.take(Symbol::PlusMinus) {
            return Ok(None);
        }
        let amount = self.sum()?;
        Ok(Some(ToleranceNode { amount, percent: self.take(Symbol::Percent) }))
    }

    fn choice(&mut self) -> Parsed<'t> {
        let start = self.span().start;
        self.at += 1;
        let condition = self.condition()?;
        let missing = |parser: &Parser<'t>, word: &str| {
            ExprError::new(parser.span(), format!("expected `{word}`"))
                .help("write `if condition then value else value`")
        };
        if !self.take_word("then") {
            return Err(missing(self, "then"));
        }
        let then = self.sum()?;
        if !self.take_word("else") {
            return Err(missing(self, "else"));
        }
        let other = self.sum()?;
        let (end, depth) = (other.span.end, condition.depth.max(then.depth).max(other.depth));
        self.node(AstNode::If(Box::new(condition), Box::new(then), Box::new(other)), start..end, depth)
    }

    fn sum(&mut self) -> Parsed<'t> {
        self.row(Parser::shift, |kind| match kind {
            TokenKind::Symbol(Symbol::Plus) => Some(Binary::Add),
            TokenKind::Symbol(Symbol::Minus) => Some(Binary::Sub),
            _ => None,
        })
    }

    fn shift(&mut self) -> Parsed<'t> {
        self.row(Parser::product, |kind| match kind {
            TokenKind::Symbol(Symbol::Left) => Some(Binary::Shl),
            TokenKind::Symbol(Symbol::Right) => Some(Binary::Shr),
            _ => None,
        })
    }

    fn product(&mut self) -> Parsed<'t> {
        self.row(Parser::unary, |kind| match kind {
            TokenKind::Symbol(Symbol::Times) => Some(Binary::Mul),
            TokenKind::Symbol(Symbol::Divide) => Some(Binary::Div),
            TokenKind::Name("mod") => Some(Binary::Mod),
            _ => None,
        })
    }

    fn row(
        &mut self,
        part: fn(&mut Parser<'t>) -> Parsed<'t>,
        sign: fn(TokenKind<'t>) -> Option<Binary>,
    ) -> Parsed<'t> {
        let mut left = part(self)?;
        while let Some(sign) = sign(self.kind()) {
            self.at += 1;
            let right = part(self)?;
            let (span, depth) = (left.span.start..right.span.end, left.depth.max(right.depth));
            left = self.node(AstNode::Binary(sign, Box::new(left), Box::new(right)), span, depth)?;
        }
        Ok(left)
    }

    fn unary(&mut self) -> Parsed<'t> {
        let start = self.span().start;
        if !self.take(Symbol::Minus) {
            return self.primary();
        }
        let inner = self.primary()?;
        let (span, depth) = (start..inner.span.end, inner.depth);
        self.node(AstNode::Negate(Box::new(inner)), span, depth)
    }

    fn primary(&mut self) -> Parsed<'t> {
        let span = self.span();
        let kind = match self.kind() {
            TokenKind::Number(number) => AstNode::Number(number),
            TokenKind::Time(nanos) => AstNode::Time(nanos),
            TokenKind::Cycles(cycles) => AstNode::Cycles(cycles),
            TokenKind::Text(text) => AstNode::Text(text),
            TokenKind::Name(word) => match self.reserved(word) {
                Some(error) => return Err(error),
                None => return self.name_or_call(word),
            },
            TokenKind::Symbol(Symbol::Open) => return self.parenthesis(),
            TokenKind::Symbol(_) | TokenKind::End => return Err(self.no_value()),
        };
        self.at += 1;
        self.node(kind, span, 0)
    }

    fn name_or_call(&mut self, word: &'t str) -> Parsed<'t> {
        let span = self.span();
        self.at += 1;
        if !self.take(Symbol::Open) {
            return self.node(AstNode::Name(word), span, 0);
        }
        self.nested(span.clone(), |parser| {
            let (arguments, depth, end) = parser.list(Symbol::Close, ")", "close the arguments of the function")?;
            parser.node(AstNode::Call(word, span.clone(), arguments), span.start..end, depth)
        })
    }

    fn parenthesis(&mut self) -> Parsed<'t> {
        let open = self.span();
        self.at += 1;
        self.nested(open.clone(), |parser| {
            let inner = parser.condition()?;
            let close = parser.expect_symbol(
                Symbol::Close,
                ")",
                "close the parenthesis, or write an operator before what follows",
            )?;
            Ok(Ast { span: open.start..close.end, ..inner })
        })
    }

    /// Parses arguments or list entries up to and including the closing symbol; returns them with the largest depth and the end.
    fn list(&mut self, close: Symbol, written: &str, help: &str) -> Result<(Vec<Ast<'t>>, u32, usize), ExprError> {
        let (mut list, mut depth) = (Vec::new(), 0);
        loop {
            let entry = if close == Symbol::Close { self.condition()? } else { self.sum()? };
            depth = depth.max(entry.depth);
            list.push(entry);
            if !self.take(Symbol::Comma) {
                let end = self.expect_symbol(close, written, help)?.end;
                return Ok((list, depth, end));
            }
        }
    }

    fn nested(&mut self, span: Range<usize>, inside: impl FnOnce(&mut Parser<'t>) -> Parsed<'t>) -> Parsed<'t> {
        if self.depth >= MAX_DEPTH {
            return Err(too_deep(span));
        }
        self.depth += 1;
        let tree = inside(self);
        self.depth -= 1;
        tree
    }

    fn end(&self) -> Result<(), ExprError> {
        let help = match self.kind() {
            TokenKind::End => return Ok(()),
            TokenKind::Symbol(Symbol::Percent) => {
                "write `mod` for the remainder of a division; `%` is allowed after a tolerance only"
            }
            TokenKind::Symbol(Symbol::PlusMinus) => "write one tolerance, at the end of a comparison with `==`",
            TokenKind::Symbol(Symbol::Close | Symbol::CloseList) => "remove it, or add the opening bracket",
            TokenKind::Symbol(_) if self.at > 0 => {
                "a comparison is not a value: put it in parentheses, or join it with `and` or `or`"
            }
            TokenKind::Name("then" | "else" | "if") => {
                "`if` is allowed in `device.yaml` only, at the start of an expression"
            }
            _ => "write an operator, `and` or `or` before it",
        };
        Err(ExprError::new(self.span(), "unexpected text after the expression").help(help))
    }

    fn reserved(&self, word: &str) -> Option<ExprError> {
        let help = match word {
            "and" | "or" | "mod" | "in" => format!("write a value on both sides of `{word}`"),
            "not" => "put the negated condition in parentheses: `(not x)`".to_owned(),
            "if" if self.allow.choice => "`if` is allowed at the start of an expression only".to_owned(),
            _ => return None,
        };
        Some(ExprError::new(self.span(), format!("unexpected `{word}`")).help(help))
    }

    fn no_value(&self) -> ExprError {
        let help = match self.kind() {
            TokenKind::End if self.at == 0 => "write an expression",
            TokenKind::Symbol(Symbol::Minus) => "one `-` is enough; put the rest in parentheses",
            TokenKind::Symbol(Symbol::OpenList) => "a list is allowed after `in` only",
            _ => "write a number, a duration, a text in quotes, a name or a function",
        };
        ExprError::new(self.span(), "expected a value").help(help)
    }
}

fn too_deep(span: Range<usize>) -> ExprError {
    ExprError::new(span, format!("this expression is nested deeper than {MAX_DEPTH}"))
        .help("`save` a part of it under a name")
}
