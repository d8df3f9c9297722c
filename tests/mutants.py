#!/usr/bin/env python3
"""Changes the program and looks whether a test sees it, with one compilation: tests/mutants.py [COUNT] [SEED].

All changes are compiled into a copy of the program (in target/mutants-at-once), each behind its number: a function returns a default
at once, or the condition of an `if` is turned round. Which unit tests of the changed rooms, and which tests of the suite, reach which change is
seen once; COUNT of the changes (100), drawn by SEED (0), are then made one by one, and the tests that reach them are run, the quickest first,
for three minutes at most. tests/mutants.sh makes more kinds of changes, and compiles for each.
"""

import json
import os
import random
import re
import shutil
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
COPY = ROOT / "target" / "mutants-at-once"
ROOMS = ("diagnosis", "model", "recording")
# What the tests of one change may take together [s].
PATIENCE = 180
DEFAULTS = [
    (r"bool", ["true", "false"]),
    (r"f(32|64)", ["0.0", "1.0", "-1.0"]),
    (r"[ui](8|16|32|64|128|size)", ["0", "1"]),
    (r"\(\)", ["()"]),
    (r"String", ["String::new()", '"xyzzy".to_owned()']),
    (r"&('static )?str", ['""']),
    (r"Vec<.*", ["vec![]"]),
    (r"Option<.*", ["None"]),
    (r"(BTree|Hash)(Map|Set)<.*", ["Default::default()"]),
]
SWITCH = """
static REACHED: [std::sync::atomic::AtomicBool; COUNT] = [const { std::sync::atomic::AtomicBool::new(false) }; COUNT];
static MADE: std::sync::OnceLock<(Option<usize>, Option<String>)> = std::sync::OnceLock::new();
pub(crate) fn mutated(n: usize) -> bool {
    let told = |name: &str| std::env::var(name).ok();
    let (made, file) = MADE.get_or_init(|| (told("MUTANT").and_then(|n| n.parse().ok()), told("MUTANTS_REACHED")));
    if let Some(file) = file && !REACHED[n].swap(true, std::sync::atomic::Ordering::Relaxed) {
        use std::io::Write;
        let open = std::fs::OpenOptions::new().create(true).append(true).open(file);
        let _ = open.and_then(|mut file| file.write_all(format!("{n}\\n").as_bytes()));
    }
    Some(n) == *made
}
"""


def closing(text, at):
    """Behind the bracket that closes the one at a place."""
    pairs, depth = {"(": ")", "<": ">", "[": "]"}, 0
    begin, end = text[at], pairs[text[at]]
    while True:
        is_arrow = text[at] == ">" and text[at - 1] in "-="
        depth += (text[at] == begin) - (text[at] == end and not is_arrow)
        at += 1
        if depth == 0:
            return at


def first_argument(text):
    depth = 0
    for at, letter in enumerate(text):
        depth += (letter in "<([") - (letter in ">)]")
        if letter == "," and depth == 0:
            return text[:at]
    return text


def defaults(result):
    """What a function with this result may return at once."""
    if not result:
        return ["return"]
    checked = re.fullmatch(r"Result<(.*)>", result, re.S)
    inner = first_argument(checked.group(1)).strip() if checked else result
    values = next((values for pattern, values in DEFAULTS if re.fullmatch(pattern, inner, re.S)), [])
    return [f"return Ok({value})" if checked else f"return {value}" for value in values]


def functions(code):
    """Where the bodies of functions begin, and what each returns."""
    for found in re.finditer(r"(?m)^[ \t]*(?:pub(?:\([a-z ]+\))? )?fn (\w+)", code):
        at = found.end()
        at = closing(code, at) if code[at] == "<" else at
        at = begin = closing(code, at)
        while code[at] not in "{;":
            at = closing(code, at) if code[at] in "([" else at + 1
        if code[at] == "{":
            yield found, at + 1, re.split(r"\swhere\s", code[begin:at])[0].strip().removeprefix("->").strip()


def change(path, mutants):
    """Writes all changes of a file into it, each behind its number."""
    code, separator, tests = path.read_text().partition("#[cfg(test)]")
    written = []

    def number(at, what):
        place = f"{path.relative_to(COPY)}:{code.count(chr(10), 0, at) + 1}"
        mutants.append(f"{place}: {what}")
        return len(mutants) - 1

    for found, at, result in functions(code):
        for value in defaults(result):
            written.append((at, f" if crate::mutated({number(found.end(), f'{found.group(1)}: {value}')}) {{ {value}; }}"))
    for found in re.finditer(r"(?m)^[ \t]*(?:\} else )?(?:let \w+ = )?if (?!let )([^\n{}]*?) \{", code):
        condition = found.group(1)
        is_whole = all(condition.count(a) == condition.count(b) for a, b in ("()", "[]")) and condition.count("|") % 2 == 0
        if is_whole and " let " not in condition and "?" not in condition:
            written.append((found.start(1), "("))
            written.append((found.end(1), f") != crate::mutated({number(found.start(1), f'not ({condition})')})"))
    for at, text in reversed(sorted(written, key=lambda one: one[0])):
        code = code[:at] + text + code[at:]
    path.write_text(code + separator + tests)


def programs():
    """The copy with all changes, compiled: its unit tests, its suite; and the changes."""
    shutil.rmtree(COPY, ignore_errors=True)
    shutil.copytree(ROOT, COPY, ignore=shutil.ignore_patterns("target", ".git"))
    shared = ROOT.parent / "shared"
    if shared.exists() and not (COPY.parent / "shared").exists():
        (COPY.parent / "shared").symlink_to(shared)
    mutants = []
    for room in ROOMS:
        for path in sorted((COPY / "src" / room).rglob("*.rs")):
            if path.name != "tests.rs":
                change(path, mutants)
    with open(COPY / "src" / "lib.rs", "a") as library:
        library.write(SWITCH.replace("COUNT", str(len(mutants))))
    build = ["cargo", "test", "--lib", "--test", "suite", "--no-run", "--message-format=json"]
    # Not where the program itself is compiled: cargo would take what is made here for that.
    environment = dict(os.environ, CARGO_TARGET_DIR=str(ROOT / "target" / "mutants"))
    built = subprocess.run(build, cwd=COPY, env=environment, stdout=subprocess.PIPE, text=True, check=True).stdout
    built = [json.loads(line) for line in built.splitlines()]
    tests = {one["target"]["name"]: one["executable"] for one in built if one.get("profile", {}).get("test")}
    return tests["torquescope"], tests["suite"], mutants


def tests_of(program):
    """The program with the name of each of its tests that are not left out."""
    listed = [subprocess.run([program, "--list", *only], cwd=COPY, stdout=subprocess.PIPE, text=True, check=True).stdout
              for only in ([], ["--ignored"])]
    every, left_out = ([line.removesuffix(": test") for line in lines.splitlines() if line.endswith(": test")] for lines in listed)
    return [(program, name) for name in every if name not in left_out]


def passes(test, limit, **environment):
    """Whether a test passes within a time [s], and how long it took."""
    begin = time.time()
    program, name = test
    run = [program, "--exact", name, "-q", "--test-threads", "1"]
    environment = dict(os.environ, CARGO_MANIFEST_DIR=str(COPY), **environment)
    try:
        done = subprocess.run(run, cwd=COPY, env=environment, capture_output=True, timeout=limit)
        return done.returncode == 0, time.time() - begin
    except subprocess.TimeoutExpired:
        return False, limit


def reached(test):
    """The changes that a test reaches, and how long it took; none if it doesn't pass as the program is."""
    with tempfile.NamedTemporaryFile() as file:
        passed, seconds = passes(test, 300, MUTANTS_REACHED=file.name)
        return [int(number) for number in set(file.read().split())] if passed else [], seconds


def is_caught(number, tests):
    """Whether one of these tests with their times sees the change."""
    end = time.time() + PATIENCE
    for seconds, test in sorted(tests):
        if time.time() + seconds > end:
            return False
        if not passes(test, max(20, 10 * seconds), MUTANT=str(number))[0]:
            return True
    return False


def main():
    count, seed = (int(given) for given in (sys.argv[1:] + ["100", "0"][len(sys.argv) - 1 :])[:2])
    unit, suite, mutants = programs()
    tests = [test for test in tests_of(unit) if test[1].split("::")[0] in ROOMS] + tests_of(suite)
    reached_by = {}
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        for test, (numbers, seconds) in zip(tests, pool.map(reached, tests)):
            for number in numbers:
                reached_by.setdefault(number, []).append((seconds, test))
    by_unit = sum(any(test[0] == unit for _, test in by) for by in reached_by.values())
    print(f"of {len(mutants)} changes {len(reached_by)} are reached by a test, {by_unit} by a unit test of {', '.join(ROOMS)}", flush=True)
    drawn = random.Random(seed).sample(range(len(mutants)), min(count, len(mutants)))

    def looked_at(number):
        by = reached_by.get(number, [])
        alone = is_caught(number, [one for one in by if one[1][0] == unit])
        caught = alone or is_caught(number, [one for one in by if one[1][0] != unit])
        if not caught:
            print(f"missed{'' if by else ', reached by none'}: {mutants[number]}", flush=True)
        return alone, caught

    with ThreadPoolExecutor(os.cpu_count()) as pool:
        results = list(pool.map(looked_at, drawn))
    alone, caught = (sum(one[which] for one in results) for which in (0, 1))
    print(f"caught: {caught} of {len(drawn)}, {alone} of them by unit tests")


if __name__ == "__main__":
    main()
