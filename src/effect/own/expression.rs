//! Formulas as people write them, such as `exp(-(qd / v_s)^2) * sign(qd)`: read once, computed over all samples.
//!
//! They bind as in mathematics: −x² is −(x²), and powers stack from the right. (Of the crates for this, exmex and
//! mathexpr take −x² for (−x)², which turns Stribeck's law upside down, and do not say in which column a mistake stands;
//! fasteval is unmaintained.)

use std::borrow::Cow;

use crate::effect::sign;

/// So many samples are computed at a time, so that what lies between stays in the cache.
const STRETCH: usize = 256;
/// Brackets, powers and signs may lie in each other this deep.
const DEEPEST: usize = 60;

type OfOne = fn(f64) -> f64;
type OfTwo = fn(f64, f64) -> f64;

/// Functions of one value.
const OF_ONE: [(&str, OfOne); 15] = [
    ("sin", f64::sin),
    ("cos", f64::cos),
    ("tan", f64::tan),
    ("asin", f64::asin),
    ("acos", f64::acos),
    ("atan", f64::atan),
    ("sinh", f64::sinh),
    ("cosh", f64::cosh),
    ("tanh", f64::tanh),
    ("exp", f64::exp),
    ("ln", f64::ln),
    ("sqrt", f64::sqrt),
    ("abs", f64::abs),
    ("sign", sign),
    ("floor", f64::floor),
];

/// Functions of two values.
const OF_TWO: [(&str, OfTwo); 4] = [("min", f64::min), ("max", f64::max), ("pow", power), ("atan2", f64::atan2)];

/// A formula in named inputs.
#[derive(Debug, Clone)]
pub struct Expression {
    /// What is done with a stack of values, one after the other.
    steps: Vec<Step>,
    /// The names of the inputs, and where each stands first (in bytes).
    names: Vec<(String, usize)>,
}

/// What is put in for a name.
#[derive(Debug, Clone)]
pub enum Input<'a> {
    /// A value for each sample.
    Series(Cow<'a, [f64]>),
    /// The same value everywhere.
    Constant(f64),
}

/// What is wrong with a formula.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Mistake {
    /// Where it stands, in bytes from the beginning.
    pub at: usize,
    /// What is wrong, and how to mend it.
    pub what: String,
}

#[derive(Debug, Clone, Copy)]
enum Step {
    Number(f64),
    Input(usize),
    OfOne(&'static str, OfOne),
    OfTwo(&'static str, OfTwo),
}

/// Takes down what a formula does, step by step, in whatever way it is to be written.
pub trait Writer {
    /// What stands for a value.
    type Value: Clone;
    /// A number.
    fn number(&mut self, number: f64) -> Self::Value;
    /// A function of one value, by its name in formulas; `-` turns the sign.
    fn of_one(&mut self, function: &'static str, value: Self::Value) -> Self::Value;
    /// A function of two values, by its name in formulas, or `+`, `-`, `*`, `/`.
    fn of_two(&mut self, function: &'static str, left: Self::Value, right: Self::Value) -> Self::Value;
}

/// The names of all functions.
pub fn functions() -> impl Iterator<Item = &'static str> {
    OF_ONE.iter().map(|(name, _)| *name).chain(OF_TWO.iter().map(|(name, _)| *name))
}

fn power(base: f64, exponent: f64) -> f64 {
    if exponent == 2.0 { base * base } else { base.powf(exponent) }
}

impl Expression {
    /// Reads a formula. Every name that is no function is an input.
    ///
    /// # Errors
    /// [`Mistake`] says where it stands and how to mend it.
    pub fn parse(text: &str) -> Result<Self, Mistake> {
        let mut parser = Parser { text, at: 0, depth: 0, steps: Vec::new(), names: Vec::new() };
        parser.sum(0)?;
        match parser.peek() {
            None => Ok(Expression { steps: parser.steps, names: parser.names }),
            Some(')') => parser.wrong("this bracket was never opened"),
            Some(other) => parser.wrong(&format!("`{other}` stands where + - * / ^ or the end should")),
        }
    }

    /// The names of its inputs, and where each stands first (in bytes).
    pub fn names(&self) -> &[(String, usize)] {
        &self.names
    }

    /// Its value at each of `count` samples; `inputs` in the order of [`Expression::names`].
    pub fn values(&self, inputs: &[Input], count: usize) -> Vec<f64> {
        let mut values = Vec::with_capacity(count);
        let mut stack: Vec<[f64; STRETCH]> = Vec::new();
        for start in (0..count).step_by(STRETCH) {
            let length = STRETCH.min(count - start);
            stack.clear();
            for step in &self.steps {
                match *step {
                    Step::Number(number) => stack.push([number; STRETCH]),
                    Step::Input(place) => {
                        let mut level = [0.0; STRETCH];
                        match &inputs[place] {
                            Input::Series(series) => level[..length].copy_from_slice(&series[start..start + length]),
                            Input::Constant(value) => level = [*value; STRETCH],
                        }
                        stack.push(level);
                    }
                    Step::OfOne(_, function) => {
                        let Some(top) = stack.last_mut() else { continue };
                        top[..length].iter_mut().for_each(|value| *value = function(*value));
                    }
                    Step::OfTwo(_, function) => {
                        let (Some(right), Some(left)) = (stack.pop(), stack.last_mut()) else { continue };
                        left[..length].iter_mut().zip(right).for_each(|(left, right)| *left = function(*left, right));
                    }
                }
            }
            values.extend(stack.iter().take(1).flat_map(|level| &level[..length]));
        }
        values
    }
}

impl Expression {
    /// Hands what it does to a writer; `inputs` in the order of [`Expression::names`].
    pub fn write<W: Writer>(&self, inputs: &[W::Value], writer: &mut W) -> Option<W::Value> {
        let mut stack: Vec<W::Value> = Vec::new();
        for step in &self.steps {
            let value = match *step {
                Step::Number(number) => writer.number(number),
                Step::Input(place) => inputs.get(place)?.clone(),
                Step::OfOne(name, _) => {
                    let value = stack.pop()?;
                    writer.of_one(name, value)
                }
                Step::OfTwo(name, _) => {
                    let (right, left) = (stack.pop()?, stack.pop()?);
                    writer.of_two(name, left, right)
                }
            };
            stack.push(value);
        }
        stack.pop()
    }
}

/// How tightly operators bind to what stands on their left.
const SUM: u8 = 1;
const PRODUCT: u8 = 2;
const SIGN: u8 = 3;
const POWER: u8 = 4;

struct Parser<'a> {
    text: &'a str,
    at: usize,
    depth: usize,
    steps: Vec<Step>,
    names: Vec<(String, usize)>,
}

impl Parser<'_> {
    fn wrong<T>(&self, what: &str) -> Result<T, Mistake> {
        Err(Mistake { at: self.at, what: what.to_owned() })
    }

    /// The next letter that is no blank.
    fn peek(&mut self) -> Option<char> {
        let rest = &self.text[self.at..];
        self.at += rest.len() - rest.trim_start().len();
        self.text[self.at..].chars().next()
    }

    /// What binds at least as tightly as `least`.
    fn sum(&mut self, least: u8) -> Result<(), Mistake> {
        self.depth += 1;
        if self.depth > DEEPEST {
            return self.wrong("this is nested too deeply: make it simpler");
        }
        self.value()?;
        while let Some(operator) = self.peek() {
            let (tightness, name, operation): (u8, &str, OfTwo) = match operator {
                '+' => (SUM, "+", |left, right| left + right),
                '-' => (SUM, "-", |left, right| left - right),
                '*' => (PRODUCT, "*", |left, right| left * right),
                '/' => (PRODUCT, "/", |left, right| left / right),
                '^' => (POWER, "pow", power),
                _ => break,
            };
            if tightness < least {
                break;
            }
            self.at += 1;
            if operator == '*' && self.text[self.at..].starts_with('*') {
                return self.wrong("`**` is not known: write ^ for a power");
            }
            // Powers stack from the right, all others from the left.
            self.sum(if tightness == POWER { POWER } else { tightness + 1 })?;
            self.steps.push(Step::OfTwo(name, operation));
        }
        self.depth -= 1;
        Ok(())
    }

    fn value(&mut self) -> Result<(), Mistake> {
        match self.peek() {
            None => self.wrong("the formula ends where a number, a channel or a function should stand"),
            Some('-') => {
                self.at += 1;
                self.sum(SIGN)?;
                self.steps.push(Step::OfOne("-", |value| -value));
                Ok(())
            }
            Some('+') => {
                self.at += 1;
                self.sum(SIGN)
            }
            Some('(') => self.bracket().map(|_| ()),
            Some(letter) if letter.is_ascii_digit() || letter == '.' => self.number(),
            Some(letter) if letter.is_ascii_alphabetic() || letter == '_' => self.name(),
            Some(other) => {
                let hint = if "²³".contains(other) { ": write ^2 for a square" } else { "" };
                self.wrong(&format!("`{other}` stands where a number, a channel or a function should{hint}"))
            }
        }
    }

    /// What stands in brackets: so many values, with commas between.
    fn bracket(&mut self) -> Result<usize, Mistake> {
        let open = self.at;
        self.at += 1;
        let mut count = 0;
        loop {
            self.sum(0)?;
            count += 1;
            match self.peek() {
                Some(')') => break,
                Some(',') => self.at += 1,
                Some(other) => return self.wrong(&format!("`{other}` stands where + - * / ^ or ) should")),
                None => return Err(Mistake { at: open, what: "this bracket is never closed".to_owned() }),
            }
        }
        self.at += 1;
        Ok(count)
    }

    fn number(&mut self) -> Result<(), Mistake> {
        let rest = &self.text[self.at..];
        let digits = |text: &str| text.len() - text.trim_start_matches(|c: char| c.is_ascii_digit() || c == '.').len();
        let mut length = digits(rest);
        let after = rest[length..].strip_prefix(['e', 'E']);
        if let Some(exponent) = after {
            let signed = exponent.strip_prefix(['+', '-']).unwrap_or(exponent);
            let count = signed.len() - signed.trim_start_matches(|c: char| c.is_ascii_digit()).len();
            if count > 0 {
                length += 1 + (exponent.len() - signed.len()) + count;
            }
        }
        let Ok(number) = rest[..length].parse() else {
            return self.wrong(&format!("`{}` is no number", &rest[..length]));
        };
        self.at += length;
        self.steps.push(Step::Number(number));
        Ok(())
    }

    fn name(&mut self) -> Result<(), Mistake> {
        let rest = &self.text[self.at..];
        let length = rest.len() - rest.trim_start_matches(|c: char| c.is_ascii_alphanumeric() || c == '_').len();
        let (name, at) = (&rest[..length], self.at);
        self.at += length;
        let is_called = self.peek() == Some('(');
        let of_one = OF_ONE.iter().find(|(known, _)| *known == name);
        let of_two = OF_TWO.iter().find(|(known, _)| *known == name);
        let wrong = |what: String| Err(Mistake { at, what });
        let (needed, step) = match (of_one, of_two) {
            (Some(&(name, function)), _) => (1, Step::OfOne(name, function)),
            (_, Some(&(name, function))) => (2, Step::OfTwo(name, function)),
            (None, None) if is_called => {
                let known: Vec<&str> = functions().collect();
                return wrong(format!("there is no function `{name}`; there are {}", known.join(", ")));
            }
            (None, None) if name == "pi" => {
                self.steps.push(Step::Number(std::f64::consts::PI));
                return Ok(());
            }
            (None, None) => {
                let place = self.names.iter().position(|(known, _)| known == name).unwrap_or_else(|| {
                    self.names.push((name.to_owned(), at));
                    self.names.len() - 1
                });
                self.steps.push(Step::Input(place));
                return Ok(());
            }
        };
        if !is_called {
            return wrong(format!("`{name}` is a function: write {name}(…)"));
        }
        let given = self.bracket()?;
        if given != needed {
            return wrong(format!(
                "`{name}` takes {needed} value{}, {given} given",
                if needed == 1 { "" } else { "s" }
            ));
        }
        self.steps.push(step);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(text: &str) -> f64 {
        let expression = Expression::parse(text).unwrap();
        assert_eq!(expression.names(), [], "{text}");
        expression.values(&[], 1)[0]
    }

    #[test]
    fn binds_as_in_mathematics() {
        for (text, expected) in [
            ("1 + 2 * 3", 7.0),
            ("8 - 4 - 2", 2.0),
            ("8 / 4 / 2", 1.0),
            ("-3^2", -9.0),
            ("2^-1", 0.5),
            ("2^3^2", 512.0),
            ("-2 * -3", 6.0),
            ("- - 2", 2.0),
            ("(1 + 2) * 3", 9.0),
            ("1.5e-2 + .5", 0.515),
            ("2E3", 2000.0),
            ("max(1, min(5, 3)) * 2", 6.0),
            ("pow(2, 0.5)^2", 2.0),
            ("sign(-0.1) + sign(0)", -1.0),
            ("exp(-(1 / 2)^2)", (-0.25f64).exp()),
            ("cos(pi)", -1.0),
            ("atan2(1, -1)", 0.75 * std::f64::consts::PI),
        ] {
            assert!((value(text) - expected).abs() < 1e-12, "{text}: {} is not {expected}", value(text));
        }
    }

    /// Longer than one stretch, and not a whole number of them.
    #[test]
    fn every_sample_has_its_own_value() {
        let expression = Expression::parse("a * x^2 - x").unwrap();
        assert_eq!(expression.names(), [("a".to_owned(), 0), ("x".to_owned(), 4)]);
        let x: Vec<f64> = (0..700).map(|t| f64::from(t) * 0.1).collect();
        let values = expression.values(&[Input::Constant(3.0), Input::Series(Cow::Borrowed(&x))], x.len());
        assert_eq!(values.len(), x.len());
        assert!(values.iter().zip(&x).all(|(value, x)| *value == 3.0 * (x * x) - x));
        assert!(Expression::parse("2").unwrap().values(&[], 0).is_empty());
    }

    #[test]
    fn mistakes_are_told_with_their_place() {
        for (text, at, what) in [
            ("", 0, "ends where"),
            ("1 +", 3, "ends where"),
            ("2 * (q + 1", 4, "never closed"),
            ("q) + 1", 1, "never opened"),
            ("sin q", 0, "write sin(…)"),
            ("2 * sine(q)", 4, "there is no function `sine`; there are sin, cos"),
            ("max(q)", 0, "takes 2 values, 1 given"),
            ("1 + abs(q, 2)", 4, "takes 1 value, 2 given"),
            ("q qd", 2, "stands where + - * / ^"),
            ("q ** 2", 3, "write ^ for a power"),
            ("q²", 1, "stands where"),
            ("3 * ²", 4, "write ^2"),
            ("1.2.3", 0, "is no number"),
            ("q $ 2", 2, "`$` stands where"),
            ("sin()", 4, "`)` stands where a number"),
        ] {
            let mistake = Expression::parse(text).unwrap_err();
            assert!(mistake.at == at && mistake.what.contains(what), "{text}: {mistake:?}");
        }
        let deep = "(".repeat(100_000);
        assert!(Expression::parse(&deep).unwrap_err().what.contains("too deeply"));
        assert!(Expression::parse(&"-".repeat(100_000)).unwrap_err().what.contains("too deeply"));
    }
}
