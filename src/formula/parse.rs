//! From tokens to steps on registers, by precedence climbing.
//!
//! ```text
//! choice      a if c else b          from the right
//! or  and  not
//! comparison  < <= > >= == !=        chained
//! sum         + −                    from the left
//! product     * / // %               from the left
//! sign        − +
//! power       ^ **                   from the right; its exponent may have a sign
//! ```
//!
//! An operand is computed into the first free register, its second operand into the next one, and so on: the registers
//! are a stack whose height is known when the text has been read.

use super::function::{Binary, Unary};
use super::token::{Token, Tokens};
use super::vocabulary::{CONSTANTS, FUNCTIONS, Function, vocabulary};
use super::{DEEPEST_NESTING, LONGEST_TEXT, MOST_OPERATIONS, MOST_REGISTERS};
use super::{Formula, FormulaError, Operation, Step};
use crate::suggest::closest;
use std::ops::Range;

const COMPARISONS: [(&str, Binary); 6] = [
    ("<", Binary::Less),
    ("<=", Binary::LessOrEqual),
    (">", Binary::Greater),
    (">=", Binary::GreaterOrEqual),
    ("==", Binary::Equal),
    ("!=", Binary::NotEqual),
];

pub(super) fn formula(text: &str, variables: &[&str]) -> Result<Formula, FormulaError> {
    if text.len() > LONGEST_TEXT {
        let message = format!("this formula has {} bytes, the most is {LONGEST_TEXT}", text.len());
        return Err(FormulaError::new(0..text.len(), message));
    }
    let mut tokens = Tokens::new(text);
    let next = tokens.next()?;
    let formula = Formula {
        text: text.to_owned(),
        steps: Vec::new(),
        places: Vec::new(),
        registers: 0,
        used: vec![false; variables.len()],
    };
    let mut parser = Parser { text, variables, tokens, next, last: 0..0, depth: 0, formula };
    if parser.next.0 == Token::End {
        return Err(FormulaError::new(0..text.len(), "this formula is empty"));
    }
    parser.choice(0)?;
    match parser.next.0 {
        Token::End => Ok(parser.formula),
        _ => Err(parser.unexpected("an operator")),
    }
}

struct Parser<'t> {
    text: &'t str,
    variables: &'t [&'t str],
    tokens: Tokens<'t>,
    /// Not consumed yet.
    next: (Token<'t>, Range<usize>),
    /// Where the last consumed token stands.
    last: Range<usize>,
    depth: usize,
    formula: Formula,
}

type Parsed = Result<(), FormulaError>;

impl<'t> Parser<'t> {
    fn advance(&mut self) -> Result<(Token<'t>, Range<usize>), FormulaError> {
        let next = self.tokens.next()?;
        self.last = self.next.1.clone();
        Ok(std::mem::replace(&mut self.next, next))
    }

    /// Consumes a sign if it is the next token.
    fn take(&mut self, sign: &str) -> Result<bool, FormulaError> {
        let is = matches!(self.next.0, Token::Sign(next) if next == sign);
        if is {
            self.advance()?;
        }
        Ok(is)
    }

    fn is_word(&self, word: &str) -> bool {
        matches!(self.next.0, Token::Name(name) if name == word)
    }

    fn take_word(&mut self, word: &str) -> Result<bool, FormulaError> {
        let is = self.is_word(word);
        if is {
            self.advance()?;
        }
        Ok(is)
    }

    /// What was found in place of what was expected.
    fn unexpected(&self, expected: &str) -> FormulaError {
        let (token, span) = &self.next;
        let written = &self.text[span.clone()];
        let error = |message: String| FormulaError::new(span.clone(), message);
        match token {
            Token::End => error(format!("the formula ends where {expected} should follow")),
            Token::Sign(")") if expected == "an operator" => error("this bracket was never opened".to_owned()),
            Token::Sign(",") => error("a comma stands only between the arguments of a function".to_owned()),
            Token::Number(_) | Token::Name(_) | Token::Braced(_) | Token::Sign("(") if expected == "an operator" => {
                error(format!("an operator is missing before `{written}`")).help("a product is written with `*`")
            }
            _ => error(format!("`{written}` stands where {expected} should")),
        }
    }

    /// One level deeper.
    fn nested(&mut self, inner: impl FnOnce(&mut Self) -> Parsed) -> Parsed {
        if self.depth == DEEPEST_NESTING {
            let message = format!("nested too deeply: the most is {DEEPEST_NESTING} levels");
            return Err(FormulaError::new(self.next.1.clone(), message));
        }
        self.depth += 1;
        inner(self)?;
        self.depth -= 1;
        Ok(())
    }

    fn push(&mut self, to: usize, operation: Operation) -> Parsed {
        if self.formula.steps.len() == MOST_OPERATIONS {
            let message = format!("too long: the most is {MOST_OPERATIONS} operations");
            return Err(FormulaError::new(self.next.1.clone(), message));
        }
        if to >= MOST_REGISTERS {
            let message = format!("too involved: the most is {MOST_REGISTERS} intermediate values at one time");
            return Err(FormulaError::new(self.next.1.clone(), message));
        }
        self.formula.registers = self.formula.registers.max(to + 1);
        self.formula.steps.push(Step { to, operation });
        self.formula.places.push(self.last.clone());
        Ok(())
    }

    fn binary(&mut self, function: Binary, to: usize) -> Parsed {
        self.push(to, Operation::Binary(function, to, to + 1))
    }

    /// `a if c else b`, into a register.
    fn choice(&mut self, to: usize) -> Parsed {
        self.nested(|parser| {
            parser.or(to)?;
            if !parser.take_word("if")? {
                return Ok(());
            }
            parser.or(to + 1)?;
            if !parser.take_word("else")? {
                return Err(parser.unexpected("`else`").help("a choice is written `a if c else b` or `if(c, a, b)`"));
            }
            parser.choice(to + 2)?;
            parser.push(to, Operation::Select(to + 1, to, to + 2))
        })
    }

    fn or(&mut self, to: usize) -> Parsed {
        self.and(to)?;
        while self.take_word("or")? {
            self.and(to + 1)?;
            self.binary(Binary::Or, to)?;
        }
        Ok(())
    }

    fn and(&mut self, to: usize) -> Parsed {
        self.not(to)?;
        while self.take_word("and")? {
            self.not(to + 1)?;
            self.binary(Binary::And, to)?;
        }
        Ok(())
    }

    fn not(&mut self, to: usize) -> Parsed {
        if !self.take_word("not")? {
            return self.comparison(to);
        }
        self.nested(|parser| parser.not(to))?;
        self.push(to, Operation::Unary(Unary::Not, to))
    }

    fn compares(&self) -> Option<Binary> {
        let Token::Sign(sign) = self.next.0 else { return None };
        COMPARISONS.into_iter().find(|(known, _)| *known == sign).map(|(_, function)| function)
    }

    /// `a < b`, and `a < b < c` for `a < b and b < c`.
    fn comparison(&mut self, to: usize) -> Parsed {
        self.sum(to)?;
        let Some(function) = self.compares() else { return Ok(()) };
        self.advance()?;
        self.sum(to + 1)?;
        self.binary(function, to)?;
        while let Some(function) = self.compares() {
            self.advance()?;
            self.sum(to + 2)?;
            self.push(to + 3, Operation::Binary(function, to + 1, to + 2))?;
            self.push(to, Operation::Binary(Binary::And, to, to + 3))?;
            self.push(to + 1, Operation::Copy(to + 2))?;
        }
        Ok(())
    }

    fn sum(&mut self, to: usize) -> Parsed {
        self.product(to)?;
        loop {
            let function = match self.next.0 {
                Token::Sign("+") => Binary::Add,
                Token::Sign("-") => Binary::Subtract,
                _ => return Ok(()),
            };
            self.advance()?;
            self.product(to + 1)?;
            self.binary(function, to)?;
        }
    }

    fn product(&mut self, to: usize) -> Parsed {
        self.sign(to)?;
        loop {
            let function = match self.next.0 {
                Token::Sign("*") => Binary::Multiply,
                Token::Sign("/") => Binary::Divide,
                Token::Sign("//") => Binary::FloorDivide,
                Token::Sign("%") => Binary::Remainder,
                _ => return Ok(()),
            };
            self.advance()?;
            self.sign(to + 1)?;
            self.binary(function, to)?;
        }
    }

    fn sign(&mut self, to: usize) -> Parsed {
        if self.take("-")? {
            self.nested(|parser| parser.sign(to))?;
            return self.push(to, Operation::Unary(Unary::Minus, to));
        }
        if self.take("+")? {
            return self.nested(|parser| parser.sign(to));
        }
        self.power(to)
    }

    fn power(&mut self, to: usize) -> Parsed {
        self.operand(to)?;
        if !(self.take("^")? || self.take("**")?) {
            return Ok(());
        }
        self.nested(|parser| parser.sign(to + 1))?;
        self.binary(Binary::Power, to)
    }

    fn operand(&mut self, to: usize) -> Parsed {
        match self.next.0 {
            Token::Number(value) => {
                self.advance()?;
                self.push(to, Operation::Constant(value))
            }
            Token::Sign("(") => {
                let (_, open) = self.advance()?;
                self.choice(to)?;
                self.close(&open)
            }
            Token::Braced(name) => {
                let (_, span) = self.advance()?;
                match self.variables.iter().position(|known| *known == name) {
                    Some(index) => self.variable(to, index),
                    None if CONSTANTS.iter().any(|(known, _)| *known == name) => {
                        let message = format!("`{name}` is a constant, and braces hold names that were given");
                        Err(FormulaError::new(span, message).help(format!("write `{name}` without braces")))
                    }
                    None => Err(self.unknown(name, span, self.variables.iter().copied())),
                }
            }
            Token::Name(name) => {
                if matches!(name, "else" | "and" | "or" | "not") {
                    return Err(self.unexpected("a number, a name or a bracket"));
                }
                let (_, span) = self.advance()?;
                if self.next.0 == Token::Sign("(") { self.call(to, name, span) } else { self.named(to, name, span) }
            }
            _ => Err(self.unexpected("a number, a name or a bracket")),
        }
    }

    fn close(&mut self, open: &Range<usize>) -> Parsed {
        if self.take(")")? {
            return Ok(());
        }
        if self.next.0 == Token::End {
            return Err(FormulaError::new(open.clone(), "this bracket is never closed"));
        }
        Err(self.unexpected("an operator"))
    }

    fn variable(&mut self, to: usize, index: usize) -> Parsed {
        self.formula.used[index] = true;
        self.push(to, Operation::Variable(index))
    }

    /// A variable or a constant.
    fn named(&mut self, to: usize, name: &str, span: Range<usize>) -> Parsed {
        if let Some(index) = self.variables.iter().position(|known| *known == name) {
            return self.variable(to, index);
        }
        if let Some((_, value)) = CONSTANTS.iter().find(|(known, _)| *known == name) {
            return self.push(to, Operation::Constant(*value));
        }
        if FUNCTIONS.iter().any(|(known, _)| *known == name) {
            let error = FormulaError::new(span, format!("the function `{name}` has no arguments here"));
            return Err(error.help(format!("write them in brackets: `{name}(…)`")));
        }
        let known = self.variables.iter().copied().chain(CONSTANTS.iter().map(|(name, _)| *name));
        Err(self.unknown(name, span, known))
    }

    fn unknown<'n>(&self, name: &str, span: Range<usize>, known: impl Iterator<Item = &'n str>) -> FormulaError {
        // One of several numbers goes without saying: `tip` stands for `tip[0]` …
        let is_part = |name: &str| name.split_once('[').is_some_and(|(whole, _)| self.variables.contains(&whole));
        let whole = self.variables.iter().filter(|name| !is_part(name));
        let variables: Vec<String> = whole.map(|name| format!("`{name}`")).collect();
        let knows = match variables.is_empty() {
            true => vocabulary(),
            false => format!("{}, {}", variables.join(", "), vocabulary()),
        };
        let meant = closest(name, known).map_or(String::new(), |near| format!("did you mean `{near}`? "));
        FormulaError::new(span, format!("unknown name `{name}`")).help(format!("{meant}Known here: {knows}"))
    }

    fn call(&mut self, to: usize, name: &str, span: Range<usize>) -> Parsed {
        let Some((_, function)) = FUNCTIONS.into_iter().find(|(known, _)| *known == name) else {
            if self.variables.contains(&name) || CONSTANTS.iter().any(|(known, _)| *known == name) {
                return Err(self.unexpected("an operator"));
            }
            let meant = closest(name, FUNCTIONS.iter().map(|(known, _)| *known));
            let meant = meant.map_or(String::new(), |near| format!("did you mean `{near}`? "));
            let error = FormulaError::new(span, format!("unknown function `{name}`"));
            return Err(error.help(format!("{meant}Known are {}", vocabulary())));
        };
        let (_, open) = self.advance()?;
        let count = self.arguments(to, function)?;
        self.close(&open)?;
        let (fits, wanted) = match function {
            Function::One(_) | Function::Scale(_) => (count == 1, "one argument"),
            Function::Two(_) => (count == 2, "two arguments"),
            Function::Several(_) => (count >= 2, "two or more arguments"),
            Function::Log => (count == 1 || count == 2, "a number and perhaps a base"),
            Function::If => (count == 3, "a condition and two values"),
        };
        if !fits {
            let message = format!("`{name}` takes {wanted}, here are {count}");
            return Err(FormulaError::new(span.start..self.previous_end(), message));
        }
        self.apply(to, function, count)
    }

    /// Where the last consumed token ended.
    fn previous_end(&self) -> usize {
        self.text[..self.next.1.start].trim_end().len()
    }

    /// Computes the arguments one register after the other; those of `Several` two by two at once.
    fn arguments(&mut self, to: usize, function: Function) -> Result<usize, FormulaError> {
        if matches!(self.next.0, Token::Sign(")")) {
            return Ok(0);
        }
        let mut count = 0;
        loop {
            match function {
                Function::Several(two) if count > 0 => {
                    self.choice(to + 1)?;
                    self.binary(two, to)?;
                }
                _ => self.choice(to + count)?,
            }
            count += 1;
            if !self.take(",")? {
                return Ok(count);
            }
        }
    }

    fn apply(&mut self, to: usize, function: Function, count: usize) -> Parsed {
        match function {
            Function::One(one) => self.push(to, Operation::Unary(one, to)),
            Function::Two(two) => self.binary(two, to),
            Function::Several(_) => Ok(()),
            Function::If => self.push(to, Operation::Select(to, to + 1, to + 2)),
            Function::Scale(factor) => {
                self.push(to + 1, Operation::Constant(factor))?;
                self.binary(Binary::Multiply, to)
            }
            Function::Log => {
                self.push(to, Operation::Unary(Unary::Ln, to))?;
                if count == 1 {
                    return Ok(());
                }
                self.push(to + 1, Operation::Unary(Unary::Ln, to + 1))?;
                self.binary(Binary::Divide, to)
            }
        }
    }
}
