//! From text to the postfix order of its tree, and from chumsky's errors to those of this crate.

use super::function::{ATAN2, Function, Item, Operator};
use crate::elements::Parts;
use crate::error::{Fault, Malformed, Result};
use chumsky::error::{RichPattern, RichReason};
use chumsky::pratt::{infix, left, prefix, right};
use chumsky::prelude::*;

/// Bytes in the longest model line that is read.
const LONGEST: usize = 20_000;
/// Parentheses, minus signs and powers inside each other, at most: the limit of the parser's recursion.
const DEEPEST: usize = 50;

const OPERAND: &str = "a number, a name, a function or '('";
const UNPARSED: &str = "the model line does not parse";

type Refusal<'a> = Rich<'a, char, SimpleSpan, Malformed>;

/// The items of a model line, operands before operators.
pub(super) fn postfix(text: &str) -> Result<Vec<Item>> {
    if text.len() > LONGEST {
        return Err(Malformed::new(Fault::Syntax, "the model line is too long")
            .expected(format!("at most {LONGEST} bytes"))
            .found(format!("{} bytes", text.len()))
            .at_span(0, 1));
    }
    if text.trim().is_empty() {
        return Err(Malformed::new(Fault::Syntax, "the model line is empty")
            .expected(OPERAND)
            .found("nothing")
            .at_span(0, 1));
    }
    if let Some(start) = too_deep(text) {
        return Err(Malformed::new(Fault::Syntax, "the model line is nested too deeply")
            .expected(format!("at most {DEEPEST} parentheses, minus signs and powers inside each other"))
            .found(token_at(text, start).0)
            .at_span(start, 1));
    }
    line().then_ignore(end()).parse(text).into_result().map_err(|refusals| {
        // errors of rules and of syntax: the leftmost first
        let first = refusals.into_iter().min_by_key(|refusal| refusal.span().start);
        first.map_or_else(|| Malformed::new(Fault::Syntax, UNPARSED), |refusal| malformed(text, refusal))
    })
}

/// The whole line as a grammar: operands, and what binds them, the tightest first.
fn line<'a>() -> impl Parser<'a, &'a str, Vec<Item>, extra::Err<Refusal<'a>>> {
    recursive(|line| {
        let digits = text::digits::<_, extra::Err<Refusal<'a>>>(10);
        let exponent = one_of("eE").then(one_of("+-").or_not()).then(digits);
        let mantissa = digits.then(just('.').then(digits.or_not()).or_not()).to_slice();
        let number = choice((mantissa, just('.').then(digits).to_slice())).then(exponent.or_not()).to_slice().validate(
            |text: &str, extra, emitter| {
                // the grammar lets digits alone through; what does not fit is refused below
                let number = text.parse().unwrap_or(f64::INFINITY);
                if !number.is_finite() {
                    emitter.emit(Rich::custom(extra.span(), number_too_large(text, extra.span())));
                }
                vec![Item::Number(number)]
            },
        );
        let pair = line.clone().then_ignore(just(',')).then(line.clone()).delimited_by(just('('), just(')'));
        let two = text::ascii::keyword(ATAN2).then_ignore(text::whitespace()).ignore_then(pair);
        let two = two.map(|(y, x)| binary(Operator::Atan2, y, x)).boxed();
        let group = line.delimited_by(just('('), just(')')).boxed();
        let word = text::ascii::ident();
        let call =
            word.map_with(|word, extra| (word, extra.span())).then_ignore(text::whitespace()).then(group.clone());
        let call = call.validate(|((word, span), mut argument): ((&str, SimpleSpan), Vec<Item>), _, emitter| {
            match Function::from_name(word) {
                Some(function) => argument.push(Item::Call(function)),
                None => emitter.emit(Rich::custom(span, unknown_function(word, span))),
            }
            argument
        });
        let name = word.then_ignore(text::whitespace().then(just('(')).not()).validate(|word: &str, extra, emitter| {
            if Function::from_name(word).is_some() || word == ATAN2 {
                emitter.emit(Rich::custom(extra.span(), no_argument(word, extra.span())));
            }
            vec![if word == "pi" { Item::Pi } else { Item::Name(word.to_string()) }]
        });
        let operand = choice((number, two, call, name, group)).labelled("operand").padded().boxed();

        let sign = |symbol| just(symbol).labelled("operator").padded();
        operand
            .pratt((
                infix(right(4), sign('^'), |a, _, b, _| binary(Operator::Power, a, b)),
                prefix(3, just('-').labelled("operand").padded(), |_, mut operand: Vec<Item>, _| {
                    operand.push(Item::Negate);
                    operand
                }),
                infix(left(2), sign('*'), |a, _, b, _| binary(Operator::Multiply, a, b)),
                infix(left(2), sign('/'), |a, _, b, _| binary(Operator::Divide, a, b)),
                infix(left(1), sign('+'), |a, _, b, _| binary(Operator::Add, a, b)),
                infix(left(1), sign('-'), |a, _, b, _| binary(Operator::Subtract, a, b)),
            ))
            .boxed()
    })
}

fn binary(operator: Operator, mut left: Vec<Item>, right: Vec<Item>) -> Vec<Item> {
    left.extend(right);
    left.push(Item::Binary(operator));
    left
}

/// Where parentheses, minus signs and powers are first nested too deeply.
fn too_deep(text: &str) -> Option<usize> {
    let mut outside: Vec<usize> = Vec::new();
    let mut depth = 0;
    let mut after_operand = false;
    for (start, c) in text.char_indices().filter(|(_, c)| !c.is_whitespace()) {
        match c {
            '(' => {
                outside.push(depth);
                depth += 1;
            }
            // an unmatched bracket is an error of the grammar
            ')' => depth = outside.pop().unwrap_or(0),
            '^' => depth += 1,
            '-' if !after_operand => depth += 1,
            '+' | '-' | '*' | '/' | ',' => depth = outside.last().map_or(0, |outer| outer + 1),
            _ => {}
        }
        after_operand = !matches!(c, '(' | '+' | '-' | '*' | '/' | '^' | ',');
        if depth > DEEPEST {
            return Some(start);
        }
    }
    None
}

fn malformed(text: &str, refusal: Refusal<'_>) -> Malformed {
    let start = refusal.span().start.min(text.len());
    match refusal.into_reason() {
        RichReason::Custom(malformed) => malformed,
        RichReason::ExpectedFound { expected, .. } => {
            let expects = |wanted: &RichPattern<'_, char>| expected.contains(wanted);
            let expected = if expects(&RichPattern::Label("operand".into())) {
                OPERAND
            } else if expects(&RichPattern::Token(')'.into())) {
                "an operator or ')'"
            } else {
                "an operator or the end of the line"
            };
            let (token, length) = token_at(text, start);
            Malformed::new(Fault::Syntax, UNPARSED).expected(expected).found(token).at_span(start, length)
        }
    }
}

/// The token at a byte of the text, quoted, and its length: a whole word or number, else one character.
fn token_at(text: &str, start: usize) -> (String, usize) {
    let tail = text.part(start..);
    let word = tail.find(|c: char| !c.is_ascii_alphanumeric() && c != '_' && c != '.').unwrap_or(tail.len()); // to the end
    match (word, tail.chars().next()) {
        (_, None) => ("the end of the line".to_string(), 1),
        (0, Some(c)) => (format!("'{}'", c.escape_debug()), c.len_utf8()),
        (1..=40, _) => (format!("'{}'", &tail[..word]), word),
        _ => (format!("'{}...'", &tail[..40]), word),
    }
}

fn number_too_large(text: &str, span: SimpleSpan) -> Malformed {
    Malformed::new(Fault::Syntax, "a number in the model line is too large")
        .expected("a number below 1.8e308")
        .found(token_at(text, 0).0)
        .at_span(span.start, span.end - span.start)
}

fn unknown_function(word: &str, span: SimpleSpan) -> Malformed {
    if word == ATAN2 {
        return Malformed::new(Fault::Syntax, "atan2 takes two arguments")
            .expected("atan2(y, x)")
            .at_span(span.start, span.end - span.start);
    }
    let functions: Vec<&str> = Function::ALL.iter().map(|function| function.name()).chain([ATAN2]).collect();
    Malformed::new(Fault::UnknownName, "the model line calls an unknown function")
        .expected(format!("an operator, or a function: {}", functions.join(" ")))
        .found(token_at(word, 0).0)
        .at_span(span.start, span.end - span.start)
}

fn no_argument(word: &str, span: SimpleSpan) -> Malformed {
    Malformed::new(Fault::Syntax, "a function in the model line has no argument")
        .expected(format!("{word}(...)"))
        .found(format!("'{word}'"))
        .at_span(span.start, span.end - span.start)
}
