//! The languages in which a tape is printed: C99, C++, Python with NumPy, MATLAB; and ROS 2 parameters, which hold no code.

use super::tape::{Step, Tape, Value};
use super::{LeftOut, Sheet, Written, ros2};
use crate::effect::own::Quantity;

/// A value that is used once stands where it is used, unless the line gets longer than this.
const LONGEST: usize = 90;
/// The generated code must give our torque to this share of the largest.
pub(super) const TOLERANCE: f64 = 1e-9;

/// What code is written in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Language {
    /// C99.
    C,
    /// C++11, header only.
    Cpp,
    /// Python with NumPy; any number of states at once.
    Python,
    /// MATLAB and Octave.
    Matlab,
    /// Parameters for a ROS 2 node, in YAML.
    Ros2,
}

impl Language {
    /// The ending of the file that holds the function.
    pub fn ending(self) -> &'static str {
        match self {
            Language::C => "c",
            Language::Cpp => "hpp",
            Language::Python => "py",
            Language::Matlab => "m",
            Language::Ros2 => "yaml",
        }
    }

    /// The files of a sheet: what holds the function, then its test.
    pub(super) fn files(self, sheet: &Sheet, left_out: &[LeftOut]) -> Vec<Written> {
        let remarks = sheet.remarks(left_out);
        let named = |ending: &str, text: String| Written { name: format!("{}{ending}", sheet.name), text };
        match self {
            Language::C => vec![
                named(".h", c_header(sheet, &remarks)),
                named(".c", c_source(sheet)),
                named("_test.c", c_test(sheet, "h", "stdio.h", "math.h")),
            ],
            Language::Cpp => vec![
                named(".hpp", cpp_header(sheet, &remarks)),
                named("_test.cpp", c_test(sheet, "hpp", "cstdio", "cmath")),
            ],
            Language::Python => {
                vec![named(".py", python(sheet, &remarks)), named("_test.py", python_test(sheet))]
            }
            Language::Matlab => {
                vec![named(".m", matlab(sheet, &remarks)), named("_test.m", matlab_test(sheet))]
            }
            Language::Ros2 => vec![named(".yaml", ros2::parameters(sheet, &remarks))],
        }
    }

    /// What a channel is called; joints are counted from 0 here.
    fn channel(self, quantity: Quantity, joint: usize) -> String {
        let name = match quantity {
            Quantity::Position => "q",
            Quantity::Velocity => "qd",
            _ => "qdd",
        };
        match self {
            Language::C | Language::Cpp | Language::Ros2 => format!("{name}[{joint}]"),
            Language::Python => format!("{name}[..., {joint}]"),
            Language::Matlab => format!("{name}({})", joint + 1),
        }
    }

    /// What a function of formulas is called.
    fn function(self, name: &'static str) -> String {
        let c = match name {
            "abs" => "fabs",
            "ln" => "log",
            "min" => "fmin",
            "max" => "fmax",
            "sign" => "sign_of",
            other => other,
        };
        match (self, name) {
            (Language::C, _) | (Language::Ros2, _) => c.to_owned(),
            (Language::Cpp, "sign") => c.to_owned(),
            (Language::Cpp, _) => format!("std::{c}"),
            (Language::Python, "asin" | "acos" | "atan") => format!("np.arc{}", &name[1..]),
            (Language::Python, "atan2") => "np.arctan2".to_owned(),
            (Language::Python, "ln") => "np.log".to_owned(),
            (Language::Python, "min") => "np.minimum".to_owned(),
            (Language::Python, "max") => "np.maximum".to_owned(),
            (Language::Python, "pow") => "np.power".to_owned(),
            (Language::Python, _) => format!("np.{name}"),
            (Language::Matlab, "ln") => "log".to_owned(),
            (Language::Matlab, "pow") => "power".to_owned(),
            (Language::Matlab, _) => name.to_owned(),
        }
    }

    fn comment(self, text: &str) -> String {
        match self {
            Language::C => format!("/* {text} */"),
            Language::Cpp => format!("// {text}"),
            Language::Python | Language::Ros2 => format!("# {text}"),
            Language::Matlab => format!("% {text}"),
        }
    }

    /// The line that gives a value its name.
    fn declared(self, name: &str, expression: &str) -> String {
        match self {
            Language::C | Language::Cpp => format!("const double {name} = {expression};"),
            Language::Python | Language::Ros2 => format!("{name} = {expression}"),
            Language::Matlab => format!("{name} = {expression};"),
        }
    }
}

/// A number so that it comes back bit by bit, and is read as one that need not be whole.
pub(super) fn number(value: f64) -> String {
    let text = format!("{value:?}");
    match text.split_once('e') {
        Some((mantissa, exponent)) if !mantissa.contains('.') => format!("{mantissa}.0e{exponent}"),
        _ => text,
    }
}

/// Prints the steps of a tape as lines of code.
struct Printer<'a> {
    tape: &'a Tape,
    language: Language,
    /// What stands for a step that was reached, and whether it binds like one word.
    words: Vec<(String, bool)>,
}

impl<'a> Printer<'a> {
    fn new(tape: &'a Tape, language: Language) -> Self {
        Printer { tape, language, words: Vec::new() }
    }

    /// The constants that the outcome needs, a line each with its unit.
    fn constants(&self) -> Vec<String> {
        let uses = self.uses();
        let is_used = |number: usize| {
            self.tape.steps.iter().zip(&uses).any(|(step, uses)| *step == Step::Constant(number) && *uses > 0)
        };
        let line = |constant: &super::tape::Constant| {
            let declared = self.language.declared(&constant.name, &number(constant.value));
            format!("{declared} {}", self.language.comment(&ascii(&constant.about)))
        };
        let used = self.tape.constants.iter().enumerate().filter(|(number, _)| is_used(*number));
        used.map(|(_, constant)| line(constant)).collect()
    }

    /// All steps as lines, and what the torque of each joint is then.
    fn lines(mut self) -> (Vec<String>, Vec<String>) {
        let uses = self.uses();
        let mut lines = Vec::new();
        for place in 0..self.tape.steps.len() {
            for (_, heading) in self.tape.headings.iter().filter(|(at, _)| *at == place) {
                lines.push(self.language.comment(&ascii(heading)));
            }
            let (text, is_word) = self.expression(place);
            // What nobody uses is never asked for.
            if is_word || uses[place] == 0 || (uses[place] == 1 && text.len() <= LONGEST) {
                self.words.push((text, is_word));
            } else {
                let name = format!("v{}", place + 1);
                lines.push(self.language.declared(&name, &text));
                self.words.push((name, true));
            }
        }
        let outcome = self.tape.outcome.iter().map(|value| self.word(*value).0).collect();
        (lines, outcome)
    }

    /// How often each step is used for the outcome; those that are not, are not printed.
    fn uses(&self) -> Vec<usize> {
        let mut uses = vec![0; self.tape.steps.len()];
        let count = |uses: &mut Vec<usize>, value: &Value| {
            if let Value::Step(place) = value {
                uses[*place] += 1;
            }
        };
        self.tape.outcome.iter().for_each(|value| count(&mut uses, value));
        // Whoever uses a step comes after it.
        for (place, step) in self.tape.steps.iter().enumerate().rev() {
            match step {
                _ if uses[place] == 0 => {}
                Step::OfOne(_, value) => count(&mut uses, value),
                Step::OfTwo(_, left, right) => [left, right].into_iter().for_each(|value| count(&mut uses, value)),
                Step::Constant(_) | Step::Channel(..) => {}
            }
        }
        uses
    }

    fn expression(&self, place: usize) -> (String, bool) {
        match &self.tape.steps[place] {
            Step::Constant(constant) => (self.tape.constants[*constant].name.clone(), true),
            Step::Channel(quantity, joint) => (self.language.channel(*quantity, *joint), true),
            Step::OfOne("-", value) => (format!("-{}", self.bracketed(*value)), false),
            Step::OfOne(name, value) => (format!("{}({})", self.language.function(name), self.word(*value).0), false),
            Step::OfTwo(operator @ ("+" | "-" | "*" | "/"), left, right) => {
                let left =
                    if *operator == "+" || *operator == "-" { self.word(*left).0 } else { self.bracketed(*left) };
                let right = if *operator == "+" { self.word(*right).0 } else { self.bracketed(*right) };
                let right = if right.starts_with('-') { format!("({right})") } else { right };
                (format!("{left} {operator} {right}"), false)
            }
            Step::OfTwo(name, left, right) => {
                (format!("{}({}, {})", self.language.function(name), self.word(*left).0, self.word(*right).0), false)
            }
        }
    }

    fn word(&self, value: Value) -> (String, bool) {
        match value {
            Value::Number(value) => (number(value), value >= 0.0),
            Value::Step(place) => self.words[place].clone(),
        }
    }

    fn bracketed(&self, value: Value) -> String {
        let (text, is_word) = self.word(value);
        let is_call = matches!(value, Value::Step(place) if matches!(&self.tape.steps[place],
            Step::OfOne(name, _) | Step::OfTwo(name, ..) if name.len() > 1));
        if is_word || is_call { text } else { format!("({text})") }
    }
}

/// Units and names in letters that every compiler reads.
fn ascii(text: &str) -> String {
    text.replace('²', "^2").replace('³', "^3").replace('°', "deg").replace('·', "*")
}

fn indented(lines: &[String], by: &str) -> String {
    lines.iter().map(|line| format!("{by}{line}\n")).collect()
}

/// The function's body in C and C++.
fn c_body(sheet: &Sheet, language: Language) -> String {
    let (lines, outcome) = Printer::new(sheet.tape, language).lines();
    let mut body = indented(&lines, "    ");
    for (joint, value) in outcome.iter().enumerate() {
        body.push_str(&format!("    tau[{joint}] = {value};\n"));
    }
    // A model need not look at all of its arguments.
    body.push_str("    (void)q;\n    (void)qd;\n    (void)qdd;\n");
    body
}

const SIGN_OF: &str = "double sign_of(double x) {\n    return (double)((x > 0.0) - (x < 0.0));\n}\n";

/// The helper that dry friction without a width needs, where it does.
fn c_helper(sheet: &Sheet) -> String {
    let is_used = sheet.tape.steps.iter().any(|step| matches!(step, Step::OfOne("sign", _)));
    if is_used { format!("static inline {SIGN_OF}\n") } else { String::new() }
}

fn c_signature(sheet: &Sheet) -> String {
    let n = sheet.joints();
    format!("void {}(const double q[{n}], const double qd[{n}], const double qdd[{n}], double tau[{n}])", sheet.name)
}

fn c_header(sheet: &Sheet, remarks: &[String]) -> String {
    let (guard, joints) = (sheet.name.to_uppercase(), sheet.joints());
    let remarks: Vec<String> = remarks.iter().map(|line| format!(" * {}", ascii(line))).collect();
    format!(
        "/*\n{}\n */\n#ifndef {guard}_H\n#define {guard}_H\n\n#define {guard}_JOINTS {joints}\n\n{};\n\n#endif\n",
        remarks.join("\n"),
        c_signature(sheet)
    )
}

fn c_source(sheet: &Sheet) -> String {
    let name = sheet.name;
    let constants: Vec<String> =
        Printer::new(sheet.tape, Language::C).constants().iter().map(|line| format!("static {line}")).collect();
    format!(
        "#include \"{name}.h\"\n\n#include <math.h>\n\n{}\n{}{} {{\n{}}}\n",
        indented(&constants, ""),
        c_helper(sheet),
        c_signature(sheet),
        c_body(sheet, Language::C)
    )
}

fn cpp_header(sheet: &Sheet, remarks: &[String]) -> String {
    let guard = sheet.name.to_uppercase();
    let remarks: Vec<String> = remarks.iter().map(|line| format!("// {}", ascii(line))).collect();
    let constants: Vec<String> =
        Printer::new(sheet.tape, Language::Cpp).constants().iter().map(|line| format!("static {line}")).collect();
    format!(
        "{}\n#ifndef {guard}_HPP\n#define {guard}_HPP\n\n#include <cmath>\n\n{}inline {} {{\n{}{}}}\n\n#endif\n",
        remarks.join("\n"),
        c_helper(sheet),
        c_signature(sheet),
        indented(&constants, "    "),
        c_body(sheet, Language::Cpp)
    )
}

/// The rows of the test, one for each state: q, q̇, q̈, τ.
fn rows(sheet: &Sheet) -> Vec<Vec<String>> {
    let states = &sheet.vectors.states;
    let signals = [&states.q, &states.qd, &states.qdd, &sheet.vectors.torque];
    (0..states.len()).map(|t| signals.iter().flat_map(|signal| signal.at(t)).map(number).collect()).collect()
}

/// What counts as equal: a share of the largest torque.
fn tolerance(sheet: &Sheet) -> String {
    let largest = sheet.vectors.torque.values().iter().fold(1.0_f64, |largest, value| largest.max(value.abs()));
    number(TOLERANCE * largest)
}

fn c_test(sheet: &Sheet, ending: &str, print: &str, math: &str) -> String {
    let (name, n, rows) = (sheet.name, sheet.joints(), rows(sheet));
    let lines: Vec<String> = rows.iter().map(|row| format!("{{{}}},", row.join(", "))).collect();
    format!(
        "/* States and the torque of the model there; the program ends with 0 if the code gives it. */\n\
         #include <{math}>\n#include <{print}>\n\n#include \"{name}.{ending}\"\n\n\
         static const double rows[{count}][{width}] = {{\n{table}}};\n\n\
         int main(void) {{\n    double worst = 0.0;\n    for (int t = 0; t < {count}; t++) {{\n        double tau[{n}];\n        \
         {name}(rows[t], rows[t] + {n}, rows[t] + {twice}, tau);\n        for (int joint = 0; joint < {n}; joint++) {{\n            \
         const double error = fabs(tau[joint] - rows[t][{thrice} + joint]);\n            \
         if (!(error <= worst)) worst = error;\n        }}\n    }}\n    \
         printf(\"largest error: %g\\n\", worst);\n    return worst <= {tolerance} ? 0 : 1;\n}}\n",
        count = rows.len(),
        width = 4 * n,
        twice = 2 * n,
        thrice = 3 * n,
        table = indented(&lines, "    "),
        tolerance = tolerance(sheet),
    )
}

fn python(sheet: &Sheet, remarks: &[String]) -> String {
    let printer = Printer::new(sheet.tape, Language::Python);
    let constants = printer.constants();
    let (lines, outcome) = printer.lines();
    let n = sheet.joints();
    format!(
        "\"\"\"{}\n\nEach of q, qd, qdd: {n} values, or an array of shape (..., {n}).\n\"\"\"\n\nimport numpy as np\n\nJOINTS = {n}\n\n{}\n\n\
         def {}(q, qd, qdd):\n    \"\"\"The torque, in the shape of q.\"\"\"\n    \
         q, qd, qdd = (np.asarray(signal, dtype=float) for signal in (q, qd, qdd))\n{}    \
         tau = [{}]\n    return np.stack(np.broadcast_arrays(*tau, q[..., 0])[:-1], axis=-1)\n",
        remarks.join("\n"),
        indented(&constants, ""),
        sheet.name,
        indented(&lines, "    "),
        outcome.join(", ")
    )
}

fn python_test(sheet: &Sheet) -> String {
    let (name, n) = (sheet.name, sheet.joints());
    let lines: Vec<String> = rows(sheet).iter().map(|row| format!("[{}],", row.join(", "))).collect();
    format!(
        "\"\"\"States and the torque of the model there; it ends with 0 if the code gives it.\"\"\"\n\nimport sys\n\nimport numpy as np\n\n\
         from {name} import {name}\n\nrows = np.array([\n{}])\nq, qd, qdd, tau = (rows[:, {n} * part:{n} * (part + 1)] for part in \
         range(4))\nworst = np.max(np.abs({name}(q, qd, qdd) - tau))\n\
         one = np.max(np.abs({name}(q[0], qd[0], qdd[0]) - tau[0]))\nprint(\"largest error:\", worst)\n\
         sys.exit(0 if max(worst, one) <= {} else 1)\n",
        indented(&lines, "    "),
        tolerance(sheet)
    )
}

fn matlab(sheet: &Sheet, remarks: &[String]) -> String {
    let printer = Printer::new(sheet.tape, Language::Matlab);
    let constants = printer.constants();
    let (lines, outcome) = printer.lines();
    let remarks: Vec<String> = remarks.iter().map(|line| format!("% {line}")).collect();
    format!(
        "function tau = {}(q, qd, qdd)\n{}\n{}{}    tau = [{}];\nend\n",
        sheet.name,
        remarks.join("\n"),
        indented(&constants, "    "),
        indented(&lines, "    "),
        outcome.join("; ")
    )
}

fn matlab_test(sheet: &Sheet) -> String {
    let (name, n) = (sheet.name, sheet.joints());
    let lines: Vec<String> = rows(sheet).iter().map(|row| row.join(", ")).collect();
    format!(
        "% States and the torque of the model there; an error if the code does not give it.\nrows = [\n{}];\nworst = 0;\n\
         for t = 1:size(rows, 1)\n    tau = {name}(rows(t, 1:{n}), rows(t, {n} + (1:{n})), rows(t, {} + (1:{n})));\n    \
         worst = max(worst, max(abs(tau' - rows(t, {} + (1:{n})))));\nend\n\
         fprintf('largest error: %g\\n', worst);\nassert(worst <= {});\n",
        indented(&lines, "    "),
        2 * n,
        3 * n,
        tolerance(sheet)
    )
}
