//! Commands that are killed at any moment: what they had written is whole, and what goes on ends as if nothing had been.

use std::io::{Read, Seek};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::window::{Copies, Said, Task, clock};
use super::{Bench, Measure, Score, SelftestError, seeds};
use crate::experiment::store::Owner;
use crate::file;
use crate::recording::write::to_npz_bytes;
use crate::simulation::Scenario;
use crate::work;

/// See its promise.
pub static MEASURE: Measure = Measure {
    id: "kills",
    promise: "trainings (with and without --add) and experiments that are killed and go on end with the bytes of one that was left \
              alone; files whose saving is killed are the old one or the new one; of a window at work the next one offers a \
              copy once it is killed, and one of each session that another recording took the place of before it was saved, \
              with locks of files and without, and at most 10 s of work are lost",
    take,
};

fn take(bench: &Bench) -> Result<Score, SelftestError> {
    let recording = seeds::recording(bench.effort.seed)?;
    let bytes = to_npz_bytes(&recording).map_err(|error| SelftestError::making("a recording")(&error))?;
    file::write(&bench.path("log.npz"), &bytes)?;
    let [trainings, experiments, savings] = [bench.cases(4, 200), bench.cases(1, 100), bench.cases(14, 500)];
    let windows = bench.cases(3, 100);
    let mut score = Score { cases: trainings + experiments + savings + windows, ..Score::default() };
    let mut random = bench.random(0);
    train(bench, trainings, &mut random, &mut score)?;
    experiment(bench, experiments, &mut random, &mut score)?;
    save(bench, savings, &mut random, &mut score)?;
    window(bench, windows, &mut random, &mut score)?;
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

/// So much work may be lost with a window \[s\].
const MOST_LOST_S: f64 = 10.0;
/// The clock that files are stamped with may be so late at most \[s\].
const STAMP_LATE_S: f64 = 0.02;
/// So long a window is worked in at most \[s\].
const LONGEST_S: f64 = 25.0;

fn window(bench: &Bench, cases: usize, random: &mut ChaCha8Rng, score: &mut Score) -> Result<(), SelftestError> {
    let mut most = 0.0_f64;
    let tells_processes = Owner::this().counted.is_some();
    if !tells_processes {
        score.left_out.push("windows without locks: the system does not tell which processes live".to_owned());
    }
    for case in 0..cases {
        bench.report(case, cases, "killed windows")?;
        // On every other one's file system nothing can be locked; there the system has to tell which processes live.
        let can_lock = case % 2 == 0 || !tells_processes;
        let copies = Copies { folder: bench.path(&format!("copies-{case}")), can_lock };
        let go_on = || -> Result<Option<Said>, SelftestError> {
            let output = in_window(bench, &Task::GoOn { copies: copies.clone() })?.output()?;
            Ok(lines(&String::from_utf8_lossy(&output.stdout)).pop())
        };
        let work = Task::Work { copies: copies.clone(), seed: random.random() };
        // It is read after its writer's death: a pipe would be full by then.
        let mut said = tempfile::tempfile()?;
        let mut child = in_window(bench, &work)?.stdout(said.try_clone()?).spawn()?;
        let patience = Duration::from_secs_f64(random.random_range(1.0..LONGEST_S));
        let begin = Instant::now();
        while begin.elapsed() < patience && child.try_wait()?.is_none() {
            work::pause();
        }
        let beside = go_on()?;
        let is_left_alone = matches!(beside, Some(Said::WentOn { offers: 0, .. }));
        score.demand(is_left_alone, || format!("window {case}: another one was told of it while it lived: {beside:?}"));
        let was_at_work = child.try_wait()?.is_none();
        child.kill()?;
        let end = clock();
        child.wait()?;
        score.demand(was_at_work, || format!("window {case}: it ended before it was killed"));
        said.rewind()?;
        let mut text = String::new();
        said.read_to_string(&mut text)?;
        let worked = lines(&text);
        let went_on = go_on()?;
        std::fs::remove_dir_all(&copies.folder)?;
        match lost(&worked, went_on.as_ref(), end) {
            Ok(lost) => {
                most = most.max(lost);
                let how = if can_lock { "" } else { " where nothing can be locked" };
                score.count(format!("windows whose copy was offered{how}"));
                let others = went_on.map_or(0, |went_on| went_on.others().len());
                (0..others).for_each(|_| score.count("copies of what another recording took the place of"));
                score.demand(lost <= MOST_LOST_S, || format!("window {case}: {lost:.1} s of work are lost"));
            }
            Err(problem) => {
                score.count("windows whose work is gone");
                score.demand(false, || format!("window {case}: {problem}"));
            }
        }
    }
    score.counts.insert("most work lost with a window [ms]".to_owned(), (1000.0 * most).round() as usize);
    Ok(())
}

fn in_window(bench: &Bench, task: &Task) -> std::io::Result<Command> {
    let mut command = Command::new(&bench.program);
    command.args(["selftest", "--window", &serde_json::to_string(task)?]).current_dir(bench.folder);
    command.stdin(Stdio::null()).stderr(Stdio::null());
    Ok(command)
}

/// What a window said; its last line may have been cut off.
fn lines(text: &str) -> Vec<Said> {
    text.lines().filter_map(|line| serde_json::from_str(line).ok()).collect()
}

/// How long ago that was done which did not come back \[s\]; an error is what came back in its place.
fn lost(worked: &[Said], went_on: Option<&Said>, end: f64) -> Result<f64, String> {
    let Some(Said::WentOn { offers, state: restored, others, written, epoch: offered }) = went_on else {
        return Err("the next window did not go on".to_owned());
    };
    let states: Vec<(f64, &String, &Vec<String>)> = worked
        .iter()
        .filter_map(|said| if let Said::State { at, state, left } = said { Some((*at, state, left)) } else { None })
        .collect();
    let Some(&(first, ..)) = states.first() else { return Ok(0.0) };
    let Some(restored) = restored else {
        return if *offers == 0 { Ok(end - first) } else { Err("what was offered can't be opened".to_owned()) };
    };
    let of = |state: &String| states.iter().rposition(|(_, known, _)| *known == state);
    if let Some(strange) = others.iter().find(|state| of(state).is_none()) {
        return Err(format!("it offers beside the last a session {strange} that never was"));
    }
    let Some(known) = of(restored) else {
        // What comes to be in a frame is said before its end is: a copy that is newer than that of all frames is of one that had none.
        let frame = |said: &Said| if let Said::Frame { at } = said { Some(*at) } else { None };
        let last = worked.iter().rev().find_map(frame);
        let is_unsaid = written.zip(last).is_some_and(|(written, last)| written >= last - STAMP_LATE_S);
        return if is_unsaid { Ok(0.0) } else { Err(format!("it offers a session {restored} that never was")) };
    };
    // What was left a moment before the last copy may still lie there.
    let most = states[..=known].iter().rev().take(2).map(|(.., left)| left.len()).max().unwrap_or(0);
    if others.len() > most {
        return Err(format!("{offers} copies are offered of one window, which had left {most} sessions"));
    }
    if states[known].2.iter().any(|left| !others.contains(left)) {
        return Err("it does not offer what another recording took the place of".to_owned());
    }
    let of_states = states.get(known + 1).map_or(0.0, |(next, ..)| end - next);
    // The epochs of a training that was at work: those since the last session, and since it began anew, as one with an effect does.
    let since = states[states.len() - 1].0;
    let mut epochs: Vec<(f64, u64)> = Vec::new();
    for said in worked {
        if let Said::Epoch { at, epoch } = said
            && *at > since
        {
            epochs.retain(|(_, before)| before < epoch);
            epochs.push((*at, *epoch));
        }
    }
    let missing = epochs.iter().find(|(_, epoch)| *epoch > offered.unwrap_or(0)).map_or(0.0, |(at, _)| end - at);
    Ok(missing.max(of_states))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_lost_is_what_came_after_the_session_that_came_back() {
        let state = |at: f64, state: &str| Said::State { at, state: state.to_owned(), left: Vec::new() };
        let went_on = |offers, state: Option<&str>, epoch| {
            let others = vec!["a".to_owned(); usize::saturating_sub(offers, 1)];
            Said::WentOn { offers, state: state.map(str::to_owned), others, written: Some(8.0), epoch }
        };
        let worked = [
            state(1.0, "a"),
            state(3.0, "b"),
            Said::Epoch { at: 4.0, epoch: 1 },
            Said::Epoch { at: 9.0, epoch: 9 },
            Said::Frame { at: 9.1 },
        ];
        let lost = |after: Said| lost(&worked, Some(&after), 10.0);
        assert_eq!(lost(went_on(1, Some("b"), Some(9))), Ok(0.0));
        assert_eq!(lost(went_on(1, Some("b"), Some(3))), Ok(1.0));
        assert_eq!(lost(went_on(1, Some("b"), None)), Ok(6.0));
        assert_eq!(lost(went_on(1, Some("a"), Some(9))), Ok(7.0));
        assert_eq!(lost(went_on(0, None, None)), Ok(9.0));
        let anew = [&worked[..], &[Said::Epoch { at: 9.5, epoch: 2 }]].concat();
        assert_eq!(super::lost(&anew, Some(&went_on(1, Some("b"), Some(2))), 10.0), Ok(0.0), "it began anew");
        assert!(lost(went_on(1, Some("c"), None)).is_err() && lost(went_on(2, Some("b"), None)).is_err());
        let unsaid = |written| {
            let state = Some("c".to_owned());
            Said::WentOn { offers: 1, state, others: Vec::new(), written: Some(written), epoch: None }
        };
        assert_eq!(lost(unsaid(9.5)), Ok(0.0), "it was killed before it could say so");
        assert!(lost(unsaid(8.5)).is_err() && lost(unsaid(2.0)).is_err());
        // Another recording took the place of the second.
        let left = Said::State { at: 9.0, state: "c".to_owned(), left: vec!["b".to_owned()] };
        let with = |others: &[&str]| Said::WentOn {
            offers: 1 + others.len(),
            state: Some("c".to_owned()),
            others: others.iter().map(|state| (*state).to_owned()).collect(),
            written: None,
            epoch: None,
        };
        let replaced = [&worked[..], &[left]].concat();
        assert_eq!(super::lost(&replaced, Some(&with(&["b"])), 10.0), Ok(0.0));
        for others in [&[][..], &["a"], &["x"], &["a", "b"]] {
            assert!(super::lost(&replaced, Some(&with(others)), 10.0).is_err(), "{others:?}");
        }
    }
}
