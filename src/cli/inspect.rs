use clap::Args;
use serde::Serialize;

use super::data::Files;
use super::table::{number, table, titled};
use crate::arm::stated::Stated;
use crate::recording::encoders::Side;
use crate::recording::finding::Finding;
use crate::recording::mapping::Mapping;
use crate::recording::torque::TorqueFacts;
use crate::recording::{Joint, Provenance, Recording};
use crate::signals::Signals;
use crate::statistics::ends;

/// Show what a recording holds, and what is odd about it.
#[derive(Args)]
#[command(after_help = "Examples:
  torquescope inspect arm.npz
  torquescope inspect log.csv --map q=pos_filt*,qd=vel_filt*,tau=tau_meas*,time=time --zero down
  torquescope inspect DATA_EMPS.mat --map emps")]
pub struct Inspect {
    #[command(flatten)]
    files: Files,
    /// Print the result as JSON.
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Answer<'a> {
    name: &'a str,
    joints: &'a [Joint],
    samples: usize,
    trajectories: Vec<TrajectoryAnswer<'a>>,
    provenance: &'a Provenance,
    posture: &'a Option<crate::arm::Posture>,
    stated_arm: &'a Option<crate::arm::Arm>,
    axes: &'a Option<crate::arm::chain::Chain>,
    torque: &'a TorqueFacts,
    encoders: Option<Side>,
    sealed: bool,
    mapping: Option<&'a Mapping>,
    findings: &'a [Finding],
}

#[derive(Serialize)]
struct TrajectoryAnswer<'a> {
    name: &'a str,
    samples: usize,
    duration_s: f64,
    time_step_s: f64,
    held_out: bool,
}

impl Inspect {
    /// Reads and prints.
    pub fn run(&self) -> anyhow::Result<()> {
        let session = self.files.opened()?;
        let Some(recording) = session.recording.as_deref() else { return Ok(()) };
        let held_out = |index: usize| session.split.held_out.iter().any(|segment| segment.trajectory == index);
        let trajectories: Vec<TrajectoryAnswer> = recording
            .trajectories
            .iter()
            .enumerate()
            .map(|(index, trajectory)| TrajectoryAnswer {
                name: &trajectory.name,
                samples: trajectory.len(),
                duration_s: trajectory.time.last().unwrap_or(&0.0) - trajectory.time.first().unwrap_or(&0.0),
                time_step_s: trajectory.time_step(),
                held_out: held_out(index),
            })
            .collect();
        if self.json {
            let answer = Answer {
                name: &recording.name,
                joints: &recording.joints,
                samples: recording.sample_count(),
                trajectories,
                provenance: &recording.provenance,
                posture: &recording.posture,
                stated_arm: &recording.stated_arm,
                axes: &recording.chain,
                torque: &recording.torque,
                encoders: recording.encoders,
                sealed: recording.seal.is_some(),
                mapping: session.mapping.as_deref(),
                findings: &session.findings,
            };
            println!("{}", serde_json::to_string_pretty(&answer)?);
            return Ok(());
        }
        println!(
            "{}: {} joints, {} samples, {} trajectories\n",
            recording.name,
            recording.joint_count(),
            recording.sample_count(),
            trajectories.len()
        );
        let rows: Vec<Vec<String>> = trajectories
            .iter()
            .map(|trajectory| {
                vec![
                    trajectory.name.to_owned(),
                    trajectory.samples.to_string(),
                    number(trajectory.duration_s),
                    number(1.0 / trajectory.time_step_s),
                    if trajectory.held_out { "held out (whole or in part)" } else { "training" }.to_owned(),
                ]
            })
            .collect();
        println!("{}\n", table(&["trajectory", "samples", "duration [s]", "rate [Hz]", " part"], &rows));
        println!("{}\n", ranges(recording));
        if let Some(stated) = stated_table(recording) {
            println!("{stated}\n");
        }
        println!("q = 0: {}", posture_text(recording));
        println!("stated arm: {}", stated_text(recording));
        println!("{}: {}", recording.effort(), recording.torque.text());
        println!("encoders: {}", recording.encoders.map_or("not stated on which side of the gears", Side::about));
        println!("sealed truth: {}", if recording.seal.is_some() { "yes" } else { "no" });
        println!("velocity: {}", recording.provenance.velocity);
        println!("acceleration: {}", recording.provenance.acceleration);
        if let Some(mapping) = &session.mapping {
            println!("mapping: {}", mapping.to_spec());
        }
        println!();
        if session.findings.is_empty() {
            println!("No findings: nothing odd was seen.");
        }
        for finding in session.findings.iter() {
            println!("{}: {finding}", finding.severity.word());
        }
        Ok(())
    }
}

fn posture_text(recording: &Recording) -> String {
    match recording.posture {
        None if recording.chain.is_some() => "where the axes of the arm are stated".to_owned(),
        None if recording.stated_arm.is_some() => "as the stated arm has it".to_owned(),
        None => "not said by the file, taken as pointing right (give --zero)".to_owned(),
        Some(posture) => {
            let sense = if posture.sign() > 0.0 { "counter-clockwise" } else { "clockwise" };
            format!("{:.1}° from +x towards +z, q grows {sense}", posture.zero_angle.to_degrees())
        }
    }
}

/// What is stated of each joint beside its axis; a column for each thing of which something is.
fn stated_table(recording: &Recording) -> Option<String> {
    let chain = recording.chain.as_ref()?;
    let [q, qd, _, tau] = recording.units();
    type Told = fn(&Stated) -> Option<String>;
    let of: [(String, Told); 9] = [
        (format!("q [{q}]"), |stated| {
            stated.limits.position.map(|[low, high]| format!("{} … {}", number(low), number(high)))
        }),
        (format!("|qd| [{qd}]"), |stated| stated.limits.velocity.map(number)),
        (format!("|tau| [{tau}]"), |stated| stated.limits.effort.map(number)),
        ("mass [kg]".to_owned(), |stated| stated.link.map(|link| number(link[0]))),
        ("rotor inertia".to_owned(), |stated| nonzero(stated.resistance.rotor_inertia)),
        ("damping".to_owned(), |stated| nonzero(stated.resistance.damping)),
        ("friction".to_owned(), |stated| nonzero(stated.resistance.friction)),
        ("stiffness".to_owned(), |stated| nonzero(stated.resistance.stiffness)),
        ("preload".to_owned(), |stated| nonzero(stated.resistance.preload)),
    ];
    let stated: Vec<Stated> = chain.axes.iter().map(|axis| axis.stated.unwrap_or_default()).collect();
    let shown: Vec<&(String, Told)> =
        of.iter().filter(|(_, told)| stated.iter().any(|one| told(one).is_some())).collect();
    if shown.is_empty() {
        return None;
    }
    let heads: Vec<&str> = ["joint"].into_iter().chain(shown.iter().map(|(head, _)| head.as_str())).collect();
    let row = |(joint, stated): (&Joint, &Stated)| {
        let cells = shown.iter().map(|(_, told)| told(stated).unwrap_or_else(|| "–".to_owned()));
        [joint.name.clone()].into_iter().chain(cells).collect()
    };
    Some(titled(
        "as the robot's file states",
        &heads,
        &recording.joints.iter().zip(&stated).map(row).collect::<Vec<_>>(),
    ))
}

fn nonzero(value: f64) -> Option<String> {
    Some(value).filter(|value| *value != 0.0).map(number)
}

fn stated_text(recording: &Recording) -> &'static str {
    match (&recording.chain, &recording.stated_arm) {
        (Some(_), Some(_)) => {
            "masses and lengths of a planar arm, since its axes are parallel and gravity lies in their plane (the model `stated-arm` \
             has its torque)"
        }
        (Some(chain), _) if chain.states_links() => "masses and axes (the model `stated-arm` has its torque)",
        (Some(_), _) => "its axes, without masses",
        (None, Some(_)) => "masses and lengths",
        (None, None) => "none",
    }
}

/// The range of each channel.
fn ranges(recording: &Recording) -> String {
    let range = |joint: usize, signal: &dyn Fn(&crate::recording::Trajectory) -> &Signals| {
        let values = recording.trajectories.iter().flat_map(|trajectory| signal(trajectory)[joint].iter().copied());
        let [low, high] = ends(values);
        format!("{} … {}", number(low), number(high))
    };
    let [q, qd, qdd, tau] = recording.units();
    let heads = [format!("q [{q}]"), format!("qd [{qd}]"), format!("qdd [{qdd}]"), format!("tau [{tau}]")];
    let heads: Vec<&str> = ["joint"].into_iter().chain(heads.iter().map(String::as_str)).collect();
    let rows: Vec<Vec<String>> = (0..recording.joint_count())
        .map(|joint| {
            vec![
                recording.joints[joint].name.clone(),
                range(joint, &|trajectory| &trajectory.q),
                range(joint, &|trajectory| &trajectory.qd),
                range(joint, &|trajectory| &trajectory.qdd),
                range(joint, &|trajectory| &trajectory.tau),
            ]
        })
        .collect();
    table(&heads, &rows)
}
