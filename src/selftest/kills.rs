//! Commands that are killed at any moment: what they had written is whole, and what goes on ends as if nothing had been.

use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::{Bench, Measure, Score, SelftestError, seeds};
use crate::file;
use crate::recording::write::to_npz_bytes;
use crate::simulation::Scenario;
use crate::work;

/// See its promise.
pub static MEASURE: Measure = Measure {
    id: "kills",
    promise: "trainings (with and without --add) and experiments that are killed and go on end with the bytes of one that was left \
              alone; files whose saving is killed are the old one or the new one",
    take,
};

fn take(bench: &Bench) -> Result<Score, SelftestError> {
    let recording = seeds::recording(bench.effort.seed)?;
    let bytes = to_npz_bytes(&recording).map_err(|error| SelftestError::making("a recording")(&error))?;
    file::write(&bench.path("log.npz"), &bytes)?;
    let [trainings, experiments, savings] = [bench.cases(4, 200), bench.cases(1, 100), bench.cases(14, 500)];
    let mut score = Score { cases: trainings + experiments + savings, ..Score::default() };
    let mut random = bench.random(0);
    train(bench, trainings, &mut random, &mut score)?;
    experiment(bench, experiments, &mut random, &mut score)?;
    save(bench, savings, &mut random, &mut score)?;
    Ok(score)
}

fn started(bench: &Bench, arguments: &[&str]) -> std::io::Result<Child> {
    let mut command = Command::new(&bench.program);
    command.args(arguments).current_dir(bench.folder);
    command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null()).spawn()
}

/// Runs a command to its end; how long that took.
fn succeeds(bench: &Bench, arguments: &[&str]) -> Result<Duration, SelftestError> {
    let begin = Instant::now();
    match started(bench, arguments)?.wait()?.success() {
        true => Ok(begin.elapsed()),
        false => Err(SelftestError::making(&arguments.join(" "))(&"the command fails")),
    }
}

/// Kills a command after a time drawn from its usual one, as soon as something is so; whether it was still at work.
fn killed(
    child: &mut Child,
    usual: Duration,
    random: &mut ChaCha8Rng,
    is_so: impl Fn() -> bool,
) -> std::io::Result<bool> {
    while !is_so() && child.try_wait()?.is_none() {
        work::pause();
    }
    let (begin, patience) = (Instant::now(), usual.mul_f64(random.random_range(0.0..1.1)));
    while begin.elapsed() < patience && child.try_wait()?.is_none() {
        work::pause();
    }
    let was_at_work = child.try_wait()?.is_none();
    child.kill()?;
    child.wait()?;
    Ok(was_at_work)
}

fn read(bench: &Bench, name: &str) -> Option<Vec<u8>> {
    file::read(&bench.path(name), file::LARGEST).ok()
}

fn forget(bench: &Bench, name: &str) -> std::io::Result<()> {
    match std::fs::remove_file(bench.path(name)) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => Err(error),
        _ => Ok(()),
    }
}

fn train(bench: &Bench, cases: usize, random: &mut ChaCha8Rng, score: &mut Score) -> Result<(), SelftestError> {
    let effect = Scenario::embedded().effects.swap_remove(0).effect;
    let plain =
        ["train", "log.npz", "--model", "structured-delan", "--hidden", "16", "--epochs", "40", "--batch", "32"];
    let add = format!("{effect}@1");
    let trainings = [plain.to_vec(), [&plain[..], &["--add", &add]].concat()];
    let mut whole = Vec::new();
    for training in trainings.iter().take(cases) {
        let usual = succeeds(bench, &[&training[..], &["-o", "whole.model"]].concat())?;
        whole.push((usual, read(bench, "whole.model")));
    }
    for case in 0..cases {
        bench.report(case, score.cases, "killed trainings")?;
        let (training, (usual, whole)) = (&trainings[case % 2], &whole[case % 2]);
        ["run.npz", "end.model"].into_iter().try_for_each(|name| forget(bench, name))?;
        let mut child = started(bench, &[&training[..], &["--checkpoint", "run.npz", "-o", "end.model"]].concat())?;
        let is_kept = || bench.path("run.npz").exists();
        if killed(&mut child, *usual, random, is_kept)? {
            succeeds(bench, &["train", "log.npz", "--resume", "run.npz", "-o", "end.model"])?;
            score.count("trainings that went on");
        } else {
            score.count("trainings that were done before");
        }
        let is_same = read(bench, "end.model") == *whole;
        score.demand(is_same, || format!("training {case}: it ends with other bytes"));
    }
    Ok(())
}

/// One model that is solved for and one that is trained, at two seeds.
const EXPERIMENT: &str = r#"
title = "killed"
description = "two links"
seeds = 2

[data.simulation]
arm = { links = [
    { mass = 1.0, length = 1.0, com = 0.5, inertia = 0.1 },
    { mass = 1.0, length = 1.0, com = 0.5, inertia = 0.1 },
] }
motion = { kind = "paper-point-to-point", trajectories = 4, duration = 4.0, samples = 100, range = 2.0 }

[[model]]
name = "rigid-body"
preset = "rigid-body"

[[model]]
name = "network"
preset = "ff-nn"
training = { epochs = 40, batch = 32, hidden = [8] }

[[test]]
name = "iid"
"#;

fn experiment(bench: &Bench, cases: usize, random: &mut ChaCha8Rng, score: &mut Score) -> Result<(), SelftestError> {
    if cases == 0 {
        return Ok(());
    }
    file::write(&bench.path("killed.toml"), EXPERIMENT.as_bytes())?;
    let run = |out: &'static str| ["experiment", "run", "killed.toml", "--out", out];
    let usual = succeeds(bench, &run("whole"))?;
    let table = |out: &str| {
        let collect = ["experiment", "collect", "killed.toml", "--out", out, "--json"];
        let output = Command::new(&bench.program).args(collect).current_dir(bench.folder).output();
        output.map(|output| output.stdout)
    };
    let whole = table("whole")?;
    for case in 0..cases {
        bench.report(case, cases, "killed experiments")?;
        let mut both = [started(bench, &run("parts"))?, started(bench, &run("parts"))?];
        let was_at_work = killed(&mut both[0], usual, random, || true)?;
        score.count(if was_at_work { "experiments that went on" } else { "experiments that were done before" });
        both[1].wait()?;
        succeeds(bench, &run("parts"))?;
        let is_same = table("parts")? == whole;
        score.demand(is_same, || format!("experiment {case}: it ends with another table"));
        std::fs::remove_dir_all(bench.path("parts"))?;
    }
    Ok(())
}

/// Every kind of output, by the command that writes it.
const SAVED: [(&[&str], &str); 7] = [
    (&["simulate", "--joints", "2", "--trajectories", "2", "-o"], "saved.npz"),
    (&["train", "log.npz", "-o"], "saved.json"),
    (&["predict", "log.npz", "-o"], "saved-torques.npz"),
    (&["figure", "residuals", "log.npz", "-o"], "saved.csv"),
    (&["figure", "residuals", "log.npz", "-o"], "saved.svg"),
    (&["figure", "residuals", "log.npz", "-o"], "saved.pdf"),
    (&["figure", "residuals", "log.npz", "-o"], "saved.png"),
];

fn save(bench: &Bench, cases: usize, random: &mut ChaCha8Rng, score: &mut Score) -> Result<(), SelftestError> {
    let mut known = Vec::new();
    for (command, name) in SAVED.iter().take(cases) {
        let usual = succeeds(bench, &[command, &[*name][..]].concat())?;
        known.push((usual, read(bench, name).unwrap_or_default()));
    }
    for case in 0..cases {
        bench.report(case, cases, "killed savings")?;
        let ((command, name), (usual, new)) = (SAVED[case % SAVED.len()], &known[case % SAVED.len()]);
        let old = b"what was there before";
        file::write(&bench.path(name), old)?;
        let mut child = started(bench, &[command, &[name][..]].concat())?;
        killed(&mut child, *usual, random, || true)?;
        let now = read(bench, name).unwrap_or_default();
        score.count(match () {
            () if now == old => "files that are the old one",
            () if now == *new => "files that are the new one",
            () => "files that are neither",
        });
        score.demand(now == old || now == *new, || format!("{name}: neither old nor new, {} bytes", now.len()));
    }
    Ok(())
}
