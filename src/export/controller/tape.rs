//! What a function computes, step after step: constants with names, channels, sums, products, functions. Nothing is computed twice,
//! and what is nothing (a product with 0) is not there.

use std::collections::HashMap;

use crate::effect::own::{Quantity, Writer};

/// A number, or the outcome of a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Value {
    /// Known now.
    Number(f64),
    /// Known when the function is called.
    Step(usize),
}

/// One step.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Step {
    /// The constant with this number.
    Constant(usize),
    /// What is measured of a joint (from 0).
    Channel(Quantity, usize),
    /// A function of one value; `-` turns the sign.
    OfOne(&'static str, Value),
    /// A function of two values, or `+`, `-`, `*`, `/`.
    OfTwo(&'static str, Value, Value),
}

/// A parameter of the model.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Constant {
    pub(super) name: String,
    pub(super) value: f64,
    /// Its unit, or what it is.
    pub(super) about: String,
}

/// All steps.
#[derive(Debug, Clone, Default)]
pub(super) struct Tape {
    pub(super) constants: Vec<Constant>,
    pub(super) steps: Vec<Step>,
    /// What begins at a step.
    pub(super) headings: Vec<(usize, String)>,
    /// The torque of each joint.
    pub(super) outcome: Vec<Value>,
    known: HashMap<Key, usize>,
}

/// By which a step is found that was done before.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
enum Key {
    Constant(usize),
    Channel(Quantity, usize),
    Of(&'static str, Vec<Result<usize, u64>>),
}

impl Tape {
    /// What is done from here on.
    pub(super) fn heading(&mut self, text: &str) {
        self.headings.push((self.steps.len(), text.to_owned()));
    }

    /// A constant with a name; 0 needs none.
    pub(super) fn constant(&mut self, name: &str, value: f64, about: &str) -> Value {
        if value == 0.0 {
            return Value::Number(0.0);
        }
        let place = self.constants.iter().position(|constant| constant.name == name).unwrap_or_else(|| {
            self.constants.push(Constant { name: name.to_owned(), value, about: about.to_owned() });
            self.constants.len() - 1
        });
        self.step(Key::Constant(place), Step::Constant(place))
    }

    /// What is measured of a joint (from 0).
    pub(super) fn channel(&mut self, quantity: Quantity, joint: usize) -> Value {
        self.step(Key::Channel(quantity, joint), Step::Channel(quantity, joint))
    }

    pub(super) fn add(&mut self, left: Value, right: Value) -> Value {
        self.of_two("+", left, right)
    }

    pub(super) fn sub(&mut self, left: Value, right: Value) -> Value {
        self.of_two("-", left, right)
    }

    pub(super) fn mul(&mut self, left: Value, right: Value) -> Value {
        self.of_two("*", left, right)
    }

    pub(super) fn div(&mut self, left: Value, right: Value) -> Value {
        self.of_two("/", left, right)
    }

    /// Says what the torque of each joint is.
    pub(super) fn end(&mut self, outcome: Vec<Value>) {
        self.outcome = outcome;
    }

    fn step(&mut self, key: Key, step: Step) -> Value {
        let steps = &mut self.steps;
        let place = *self.known.entry(key).or_insert_with(|| {
            steps.push(step);
            steps.len() - 1
        });
        Value::Step(place)
    }
}

/// By which two values are told apart.
fn key(value: Value) -> Result<usize, u64> {
    match value {
        Value::Step(place) => Ok(place),
        Value::Number(number) => Err(number.to_bits()),
    }
}

impl Writer for Tape {
    type Value = Value;

    fn number(&mut self, number: f64) -> Value {
        Value::Number(number)
    }

    fn of_one(&mut self, function: &'static str, value: Value) -> Value {
        match (function, value) {
            ("-", Value::Number(number)) => Value::Number(-number),
            _ => self.step(Key::Of(function, vec![key(value)]), Step::OfOne(function, value)),
        }
    }

    fn of_two(&mut self, function: &'static str, left: Value, right: Value) -> Value {
        use Value::Number;
        match (function, left, right) {
            ("+", Number(0.0), other) | ("+" | "-", other, Number(0.0)) => other,
            ("-", Number(0.0), other) => self.of_one("-", other),
            ("*", Number(0.0), _) | ("*", _, Number(0.0)) | ("/", Number(0.0), _) => Number(0.0),
            ("*", Number(1.0), other) | ("*" | "/", other, Number(1.0)) => other,
            ("*", Number(-1.0), other) | ("*", other, Number(-1.0)) => self.of_one("-", other),
            ("+", Number(a), Number(b)) => Number(a + b),
            ("-", Number(a), Number(b)) => Number(a - b),
            ("*", Number(a), Number(b)) => Number(a * b),
            ("/", Number(a), Number(b)) => Number(a / b),
            ("pow", base, Number(2.0)) => self.of_two("*", base, base),
            _ => self.step(Key::Of(function, vec![key(left), key(right)]), Step::OfTwo(function, left, right)),
        }
    }
}
