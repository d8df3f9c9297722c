use std::path::PathBuf;

use clap::Args;
use serde_json::json;

use super::choice::one_of;
use super::data::OptionalLog;
use super::failure::OrUsage;
use super::progress;
use super::saved::Of;
use super::table::{number, titled};
use crate::arm::body::Body;
use crate::export::kind::{KINDS, Kind};
use crate::export::outgoing::{Outgoing, SMOOTH, Wish, outgoing};
use crate::export::robot::{Change, NotHeld, Weighed, WeighedLink};

/// Write a model as the code of a controller, with a test, into the robot's own file, or as the weights of its network.
///
/// For code and robots' files it is one that is solved for: a rigid body with named effects. As code it is one function
/// tau(q, qd, qdd), in which dry friction turns round smoothly, within --smooth. What no function of the present motion can give (an
/// effect with a memory, a reading that comes late) is left out, and told. Beside the code stands a test with states and the torque
/// of the model there.
///
/// Into a URDF go damping and friction of the joints, into an MJCF also armature and springs; nothing else in the file changes. What
/// the format can't hold is told. With --log it is told how much of the torque all that is; with --inertials the links get masses and
/// inertias that can exist and give the identified torque, as nearly as links can.
///
/// A trained network goes into a folder: its weights as safetensors and NPZ, its torque as ONNX, and an evaluator for NumPy that tests
/// itself.
#[derive(Args)]
#[command(after_help = "Examples:
  torquescope export c model.json -o controller/arm_torque.c
  torquescope export cpp model.json --smooth 0.02 -o arm_torque.hpp
  torquescope export python model.json --log arm.npz -o arm_torque.py
  torquescope export ros2 model.json -o arm_torque.yaml
  torquescope export urdf model.json --into robot.urdf --log arm.npz
  torquescope export urdf model.json --into robot.urdf --log arm.npz --inertials -o identified.urdf
  torquescope export mjcf model.json --into robot.xml --joints shoulder,elbow -o identified.xml
  torquescope export network delan.model --log arm.npz -o network
  torquescope export c mine.torquescope --of 'rigid body + Coulomb 1, 2' -o arm_torque.c")]
pub struct Export {
    /// What to write.
    #[arg(value_parser = one_of(KINDS))]
    kind: Kind,
    /// A model that `train` saved, or a session that the window saved (.torquescope): its current model, with its recording where
    /// no --log is named.
    model: PathBuf,
    #[command(flatten)]
    of: Of,
    /// Of code: the file, whose name is that of the function; or a folder, for a function `torque_model`. The test stands beside
    /// it. Of a robot's file: where the changed one goes; without, it takes the place of --into, which is kept as .bak. Of a
    /// network: the folder.
    #[arg(short, long, value_name = "FILE|DIR")]
    output: Option<PathBuf>,
    /// The robot's own file.
    #[arg(long, value_name = "ROBOT")]
    into: Option<PathBuf>,
    /// The model's joints by their names in the robot's file, base first; without, those that move.
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    joints: Vec<String>,
    /// Of a robot's file: write the masses and inertias of its links too, those that can exist and are nearest to what was identified.
    /// They follow from the motion of --log.
    #[arg(long)]
    inertials: bool,
    /// The speed within which dry friction turns round [rad/s or m/s]; where the model found a wider reversal, that is kept.
    #[arg(long, value_name = "WIDTH", default_value_t = SMOOTH)]
    smooth: f64,
    /// Print the result as JSON.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    log: OptionalLog,
}

impl Export {
    /// Reads, writes, tells.
    pub fn run(&self) -> anyhow::Result<()> {
        let saved = self.of.read(&self.model)?;
        let recording = self.log.recording_for(&saved)?;
        let Export { kind, output, into, joints, inertials, smooth, .. } = self;
        let (output, into, joints) = (output.clone(), into.clone(), joints.clone());
        let wish = Wish { kind: *kind, output, into, joints, inertials: *inertials, smooth: *smooth };
        let outgoing = outgoing(&saved.fitted, &wish, recording.as_deref()).or_usage()?;
        outgoing.files.check(&[self.log.inputs(), vec![self.model.clone()]].concat()).or_usage()?;
        outgoing.files.write()?;
        match (self.kind, self.json) {
            (Kind::Robot(_), true) => tell_robot_json(&outgoing),
            (Kind::Robot(_), false) => {
                tell_robot(&outgoing);
                Ok(())
            }
            (Kind::Code(_) | Kind::Network, true) => tell_files_json(&outgoing),
            (Kind::Code(_) | Kind::Network, false) => {
                tell_files(&outgoing);
                Ok(())
            }
        }
    }
}

/// What was changed in the robot's file, and what it can't hold.
fn tell_robot(outgoing: &Outgoing) {
    let row = |one: &Change| {
        let before = one.before.clone().unwrap_or_else(|| "–".to_owned());
        vec![one.joint.clone(), one.attribute.to_owned(), before, number(one.value)]
    };
    let rows: Vec<Vec<String>> = outgoing.changes.iter().map(row).collect();
    println!("{}", titled("written", &["joint", "attribute", "before", "now"], &rows));
    if let Some(weighed) = &outgoing.weighed {
        tell_masses(weighed);
    }
    if outgoing.not_held.is_empty() {
        return;
    }
    let rows: Vec<Vec<String>> = outgoing.not_held.iter().map(not_held_row).collect();
    println!(
        "\n{}",
        titled("where the file differs from the model", &["what", " value", "share of the torque", " why"], &rows)
    );
}

/// The same for other programs.
fn tell_robot_json(outgoing: &Outgoing) -> anyhow::Result<()> {
    let Outgoing { changes, weighed, not_held, .. } = outgoing;
    let change = |one: &Change| json!({ "joint": one.joint, "attribute": one.attribute, "before": one.before, "value": one.value });
    let lost = |one: &NotHeld| {
        let (value, unit) = one.value.clone().unzip();
        json!({ "what": one.what, "value": value, "unit": unit, "why": one.why, "share": one.share })
    };
    let links = weighed.as_ref().map(|weighed| weighed.links.iter().map(link_json).collect::<Vec<_>>());
    let cost = |[free, links]: &[f64; 2]| json!({ "nmse_identified": free, "nmse_of_links": links });
    let cost = weighed.as_ref().map(|weighed| weighed.cost.iter().map(cost).collect::<Vec<_>>());
    let written: Vec<_> = changes.iter().map(change).collect();
    let not_held: Vec<_> = not_held.iter().map(lost).collect();
    let told = json!({ "written": written, "links": links, "cost": cost, "not_held": not_held });
    println!("{}", serde_json::to_string_pretty(&told)?);
    Ok(())
}

/// The files, and what is in none of them.
fn tell_files(outgoing: &Outgoing) {
    for out in &outgoing.not_held {
        let unknown = if out.share.is_none() { "; name --log to be told how much of the torque it is" } else { "" };
        progress::told(format_args!("left out: {out}{unknown}"));
    }
    println!("{}", paths(outgoing).join("\n"));
}

/// The same for other programs.
fn tell_files_json(outgoing: &Outgoing) -> anyhow::Result<()> {
    let lost = |out: &NotHeld| json!({ "term": out.what, "why": out.why, "share": out.share });
    let left_out: Vec<_> = outgoing.not_held.iter().map(lost).collect();
    println!("{}", serde_json::to_string_pretty(&json!({ "files": paths(outgoing), "left_out": left_out }))?);
    Ok(())
}

fn paths(outgoing: &Outgoing) -> Vec<String> {
    outgoing.files.files.iter().map(|(path, _)| path.display().to_string()).collect()
}

fn link_json(link: &WeighedLink) -> serde_json::Value {
    let body = |body: &Body| {
        let rows: Vec<Vec<f64>> = body.inertia.row_iter().map(|row| row.iter().copied().collect()).collect();
        json!({ "mass": body.mass, "com": body.com.as_slice(), "inertia": rows })
    };
    json!({ "link": link.name, "before": link.before.as_ref().map(body), "now": body(&link.now) })
}

/// What the links weigh now, and what it costs that they can exist.
fn tell_masses(weighed: &Weighed) {
    let row = |link: &WeighedLink| {
        let before = link.before.map_or_else(|| "–".to_owned(), |body| number(body.mass));
        let com = link.now.com.iter().copied().map(number).collect::<Vec<_>>().join(" ");
        let moments = link.now.inertia.diagonal().iter().copied().map(number).collect::<Vec<_>>().join(" ");
        vec![link.name.clone(), before, number(link.now.mass), com, moments]
    };
    let rows: Vec<Vec<String>> = weighed.links.iter().map(row).collect();
    let heads = ["link", "kg before", "kg now", " centre of mass [m]", " ixx iyy izz [kg m²]"];
    println!("\n{}", titled("links that can exist", &heads, &rows));
    let row = |(joint, [free, links]): (usize, &[f64; 2])| vec![(joint + 1).to_string(), number(*free), number(*links)];
    let rows: Vec<Vec<String>> = weighed.cost.iter().enumerate().map(row).collect();
    println!("\n{}", titled("nMSE of the model on the log", &["joint", "as identified", "with these links"], &rows));
}

fn not_held_row(one: &NotHeld) -> Vec<String> {
    let value = one.value.as_ref().map_or_else(|| "–".to_owned(), |(value, unit)| format!("{} {unit}", number(*value)));
    let share = one.share.map_or_else(|| "name --log".to_owned(), |share| format!("{:.1} %", 100.0 * share));
    vec![one.what.clone(), value, share, one.why.to_owned()]
}
