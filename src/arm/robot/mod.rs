//! A serial arm from its maker's file (URDF or MJCF): where its axes are, and which bodies move with each. No mesh is read.
//!
//! Both formats give the same: a tree of nodes, each a frame that is fixed in the one before or moves in it about one axis. Joints
//! that follow others (`mimic`, an equality of joints) are taken for fixed ones, and what they carry for a part of what moves before.

mod axes;
mod mjcf;
mod urdf;

use std::ffi::OsStr;
use std::path::Path;

use nalgebra::{Isometry3, Rotation3, UnitQuaternion, Vector3};
use roxmltree::{Document, ParsingOptions};

use super::MOST_JOINTS;
use super::body::Body;
use super::chain::{Chain, PER_LINK, Regressor};
use super::stated::{Limits, Resistance, Stated};

/// An axis that is shorter has no direction.
const SHORTEST_AXIS: f64 = 1e-9;
/// Parameters of bodies that are smaller are only rounding.
const ROUNDING: f64 = 1e-15;
/// No robot has more elements.
pub(crate) const MOST_NODES: u32 = 1_000_000;

/// An arm as its file states it.
#[derive(Debug, Clone, PartialEq)]
pub struct SerialArm {
    /// Its joints, base first.
    pub joints: Vec<SerialJoint>,
    /// Acceleration of free fall in the frame of the base \[m/s²\].
    pub gravity: Vector3<f64>,
}

/// A joint that moves, and what moves with it.
#[derive(Debug, Clone, PartialEq)]
pub struct SerialJoint {
    /// Its name in the file.
    pub name: String,
    /// Whether it slides.
    pub slides: bool,
    /// How its frame stands in that of the joint before at q = 0. Its axis is z.
    pub frame: Isometry3<f64>,
    /// What resists it, as the file states.
    pub resistance: Resistance,
    /// How far, how fast and how strongly it moves, as the file states.
    pub limits: Limits,
    /// The links (or bodies) of the file that move with it and with no joint behind it, nearest first.
    pub parts: Vec<Part>,
}

/// A link of the file.
#[derive(Debug, Clone, PartialEq)]
pub struct Part {
    /// Its name in the file.
    pub name: String,
    /// How its frame stands in that of its joint.
    pub frame: Isometry3<f64>,
    /// What it weighs, in its own frame, if the file says it.
    pub body: Option<Body>,
}

/// A joint of a file that moves.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MovingJoint {
    /// Its name in the file.
    pub name: String,
    /// Whether it slides.
    pub slides: bool,
    /// The joint that moves it, by its place in the list; `None` for one at the base.
    pub before: Option<usize>,
}

/// A frame of the file, in the one before.
struct Node {
    /// The frame before, by its place in the list; the base's is not there.
    parent: Option<usize>,
    /// How it stands there at q = 0.
    frame: Isometry3<f64>,
    /// How it moves there; `None` if it is fixed.
    motion: Option<Motion>,
    /// The link that has this frame, with its own frame in it.
    part: Option<Part>,
}

/// A joint of the file.
struct Motion {
    name: String,
    axis: Vector3<f64>,
    slides: bool,
    resistance: Resistance,
    limits: Limits,
}

/// The text gives no arm.
#[derive(Debug, thiserror::Error)]
pub enum RobotError {
    /// No XML.
    #[error(
        "it is no XML: {0}; mend it there, or export it again (a xacro file becomes a URDF by `xacro robot.xacro`)"
    )]
    Xml(#[from] roxmltree::Error),
    /// Another kind of XML.
    #[error("it begins with <{0}>, but a URDF begins with <robot>, an MJCF with <mujoco>")]
    Root(String),
    /// Numbers that are none.
    #[error("line {line}: {what} of `{of}` is `{text}`, but must be {must}")]
    Numbers {
        /// Where it stands.
        line: u32,
        /// The joint or link.
        of: String,
        /// What is wrong.
        what: String,
        /// What stands there.
        text: String,
        /// What may stand there.
        must: String,
    },
    /// A joint without an axis that could be.
    #[error("joint `{0}` has an axis of length 0; give it a direction")]
    NoAxis(String),
    /// Something that would change the arm, and is not understood.
    #[error("line {line}: {what}, which is not understood here; {remedy}")]
    NotUnderstood {
        /// Where it stands.
        line: u32,
        /// What it is.
        what: String,
        /// What to do.
        remedy: &'static str,
    },
    /// None of this name.
    #[error("it has no moving joint `{name}`; there are: {known}")]
    NoJoint {
        /// What was asked for.
        name: String,
        /// What there is.
        known: String,
    },
    /// No base.
    #[error("its links go round in circles, each behind another; one of them must be the base")]
    Circle,
    /// Too few or too many.
    #[error("it has {found} moving joints ({names}), but 1 to {MOST_JOINTS} are supported; make the others fixed")]
    Count {
        /// How many.
        found: usize,
        /// Their names.
        names: String,
    },
    /// Several arms, or a hand.
    #[error(
        "its moving joints {names} are no serial chain: `{joint}` does not follow the one before; name those of one arm (--arm-joints; \
         the window asks for them)"
    )]
    NotSerial {
        /// All of them.
        names: String,
        /// The first that does not.
        joint: String,
    },
}

impl SerialArm {
    /// Reads the text of a URDF or an MJCF.
    ///
    /// # Errors
    /// [`RobotError`] says what is wrong and how to mend it.
    pub fn parse(text: &str) -> Result<SerialArm, RobotError> {
        SerialArm::moving_only(text, &[])
    }

    /// The same with these joints only; all others are taken for fixed. Without any name, all move.
    ///
    /// # Errors
    /// As [`SerialArm::parse`].
    pub fn moving_only(text: &str, joints: &[String]) -> Result<SerialArm, RobotError> {
        let (mut nodes, gravity) = nodes(text)?;
        let unknown =
            |name: &&String| !nodes.iter().any(|node| node.moves().is_some_and(|motion| motion.name == **name));
        if let Some(name) = joints.iter().find(unknown) {
            return Err(RobotError::NoJoint { name: name.clone(), known: names_of(&nodes) });
        }
        if !joints.is_empty() {
            let is_asked = |motion: &Motion| joints.contains(&motion.name);
            nodes.iter_mut().for_each(|node| node.motion = node.motion.take().filter(is_asked));
        }
        Ok(SerialArm { joints: serial(nodes)?, gravity })
    }

    /// All joints of a URDF or an MJCF that move, also those of several arms or of a hand: nobody stands before who is before it.
    ///
    /// # Errors
    /// [`RobotError`] says what is wrong and how to mend it.
    pub fn moving_joints(text: &str) -> Result<Vec<MovingJoint>, RobotError> {
        let (nodes, _) = nodes(text)?;
        let moving = moving(&nodes)?;
        let place = |node: &usize| moving.iter().position(|(other, _)| other == node);
        let of = |(node, way): &(usize, Vec<usize>)| {
            let motion = nodes[*node].moves()?;
            let before = way.iter().rev().filter(|other| *other != node).find_map(place);
            Some(MovingJoint { name: motion.name.clone(), slides: motion.slides, before })
        };
        Ok(moving.iter().filter_map(of).collect())
    }

    /// Which joints slide.
    pub fn sliding(&self) -> Vec<bool> {
        self.joints.iter().map(|joint| joint.slides).collect()
    }

    /// Where its axes are and what it states of each, in the words of a mapping file.
    pub fn chain(&self) -> Chain {
        let mut whole = Isometry3::identity();
        let in_base = |joint: &SerialJoint| {
            whole *= joint.frame;
            whole
        };
        let frames: Vec<_> = self.joints.iter().map(in_base).collect();
        let (mut chain, placed) = axes::chain(&frames, self.gravity);
        for (number, joint) in self.joints.iter().enumerate() {
            // The frame of the row, in that of the joint of the file: both are fixed to the link.
            let row = frames[number].inverse() * placed[number];
            let link = joint.parameters_in(&row);
            let is_last = number + 1 == self.joints.len();
            let tip = joint.tip().filter(|_| is_last).map(|tip| row.inverse_transform_point(&tip.into()).coords.into());
            let SerialJoint { resistance, limits, .. } = *joint;
            chain.axes[number].stated = Stated { link, resistance, limits, tip }.if_any();
        }
        chain
    }

    /// That it is a planar arm and is taken for one, if it is, and where its last link ends; or why it is not, if its axes are those of
    /// one. As a sentence without its end.
    pub fn plane_told(&self) -> Option<String> {
        if self.sliding().contains(&true) {
            return None;
        }
        let arm = match self.chain().planar() {
            Ok(arm) => arm,
            Err(problem) => {
                return problem.is_nearly().then(|| {
                    format!(
                        "all axes are parallel and gravity lies in their plane, but {problem}: it is not taken for a planar arm and \
                         stays one in space, where its model is complete too"
                    )
                });
            }
        };
        let length = arm.links.last()?.length;
        let has_tip = self.joints.last().is_some_and(|last| last.tip().is_some());
        let end =
            if has_tip { "" } else { " (twice as far as its centre of mass, unless a frame there says otherwise)" };
        Some(format!(
            "all axes are parallel and gravity lies in their plane: it is the planar arm with these links, the last {length:.3} m long{end}"
        ))
    }

    /// Links that move of which the file does not say what they weigh.
    pub fn unweighed(&self) -> impl Iterator<Item = &str> {
        let parts = self.joints.iter().flat_map(|joint| &joint.parts);
        parts.filter(|part| part.body.is_none()).map(|part| part.name.as_str())
    }

    /// What all that moves weighs \[kg\], as far as the file says it.
    pub fn mass(&self) -> f64 {
        self.joints.iter().filter_map(SerialJoint::mass).sum()
    }

    /// What computes its torque from the parameters of its bodies, each in the frame of its joint. Gravity is that of the file, or none.
    pub fn regressor(&self, weightless: bool) -> Regressor {
        let frames: Vec<_> = self.joints.iter().map(|joint| joint.frame).collect();
        let gravity = if weightless { Vector3::zeros() } else { self.gravity };
        Regressor::of_frames(&frames, &self.sliding(), gravity)
    }

    /// The parameters of the regressor as the file states them: ten for each joint, of all that moves with it. What it says nothing of
    /// weighs nothing.
    pub fn stated_parameters(&self) -> Vec<f64> {
        let of_joint = |joint: &SerialJoint| joint.parameters_in(&Isometry3::identity()).unwrap_or_default();
        self.joints.iter().flat_map(of_joint).collect()
    }
}

impl SerialJoint {
    /// What moves with it and with no joint behind it weighs \[kg\], if the file says it of anything.
    pub fn mass(&self) -> Option<f64> {
        self.parts.iter().filter_map(|part| part.body).map(|body| body.mass).reduce(|sum, own| sum + own)
    }

    /// The farthest of the frames that are fixed to it, in its own: where a tool is; `None` where there is none but that of its link.
    fn tip(&self) -> Option<Vector3<f64>> {
        let places = self.parts.iter().map(|part| part.frame.translation.vector);
        let farthest = places.max_by(|one, other| one.norm().total_cmp(&other.norm()))?;
        (farthest.norm() > SHORTEST_AXIS).then_some(farthest)
    }

    /// The parameters of all that moves with it, in a frame that stands so in its own; `None` if nothing is said to weigh anything.
    fn parameters_in(&self, frame: &Isometry3<f64>) -> Option<[f64; PER_LINK]> {
        let of_part = |part: &Part| Some(part.body?.seen_from(&(part.frame.inverse() * frame)).parameters());
        let sum = |sum: [f64; PER_LINK], own: [f64; PER_LINK]| std::array::from_fn(|place| sum[place] + own[place]);
        let clean = |value: f64| if value.abs() < ROUNDING { 0.0 } else { value };
        self.parts.iter().filter_map(of_part).reduce(sum).map(|all| all.map(clean))
    }
}

impl Part {
    /// Its parameters in the frame of its joint.
    pub fn parameters(&self) -> Option<[f64; PER_LINK]> {
        self.body.map(|body| body.seen_from(&self.frame.inverse()).parameters())
    }
}

impl Node {
    fn moves(&self) -> Option<&Motion> {
        self.motion.as_ref()
    }
}

/// Whether a file is one of a robot by its ending.
pub fn is_named_like_one(path: &Path) -> bool {
    let is = |ending: &OsStr| ["urdf", "xml", "mjcf"].iter().any(|known| ending.eq_ignore_ascii_case(known));
    path.extension().is_some_and(is)
}

/// All frames of a file, and the acceleration of free fall \[m/s²\].
fn nodes(text: &str) -> Result<(Vec<Node>, Vector3<f64>), RobotError> {
    let options = ParsingOptions { allow_dtd: false, nodes_limit: MOST_NODES, ..ParsingOptions::default() };
    let document = Document::parse_with_options(text, options)?;
    match document.root_element().tag_name().name() {
        "robot" => urdf::nodes(&document),
        "mujoco" => mjcf::nodes(&document),
        other => Err(RobotError::Root(other.to_owned())),
    }
}

/// The frames that move, nearest to the base first, each with those from the base to it.
fn moving(nodes: &[Node]) -> Result<Vec<(usize, Vec<usize>)>, RobotError> {
    let moving = (0..nodes.len()).filter(|node| nodes[*node].motion.is_some());
    let mut moving = moving.map(|node| Ok((node, way(nodes, node)?))).collect::<Result<Vec<_>, RobotError>>()?;
    moving.sort_by_key(|(_, way)| way.len());
    Ok(moving)
}

fn names_of(nodes: &[Node]) -> String {
    nodes.iter().filter_map(Node::moves).map(|motion| motion.name.as_str()).collect::<Vec<_>>().join(", ")
}

/// The joints that move, base first, with the parts that move with each.
fn serial(nodes: Vec<Node>) -> Result<Vec<SerialJoint>, RobotError> {
    let ways = (0..nodes.len()).map(|node| way(&nodes, node)).collect::<Result<Vec<Vec<usize>>, _>>()?;
    let moving = moving(&nodes)?;
    let moving: Vec<(usize, &Motion)> =
        moving.iter().filter_map(|(node, _)| Some((*node, nodes[*node].moves()?))).collect();
    let names = names_of(&nodes);
    if !(1..=MOST_JOINTS).contains(&moving.len()) {
        return Err(RobotError::Count { found: moving.len(), names });
    }
    for pair in moving.windows(2) {
        let [(before, _), (place, motion)] = pair else { continue };
        if before == place || !ways[*place].contains(before) {
            return Err(RobotError::NotSerial { names, joint: motion.name.clone() });
        }
    }
    // The frame of each joint with its axis along z, in the base, and in what it was.
    let in_base = |node: usize| ways[node].iter().fold(Isometry3::identity(), |whole, one| whole * nodes[*one].frame);
    let mut joints: Vec<SerialJoint> = Vec::new();
    let (mut whole, mut frames) = (Isometry3::identity(), Vec::new());
    for (place, motion) in &moving {
        if motion.axis.norm() <= SHORTEST_AXIS {
            return Err(RobotError::NoAxis(motion.name.clone()));
        }
        let frame = in_base(*place) * along_z(&motion.axis);
        joints.push(SerialJoint {
            name: motion.name.clone(),
            slides: motion.slides,
            frame: whole.inverse() * frame,
            resistance: motion.resistance,
            limits: motion.limits,
            parts: Vec::new(),
        });
        (whole, _) = (frame, frames.push(frame));
    }
    let mut order: Vec<usize> = (0..nodes.len()).collect();
    order.sort_by_key(|node| ways[*node].len());
    for node in order {
        let carried = moving.iter().rposition(|(place, _)| ways[node].contains(place));
        if let (Some(joint), Some(part)) = (carried, &nodes[node].part) {
            let frame = frames[joint].inverse() * in_base(node) * part.frame;
            joints[joint].parts.push(Part { frame, ..part.clone() });
        }
    }
    Ok(joints)
}

/// The frames from the base to this one.
fn way(nodes: &[Node], node: usize) -> Result<Vec<usize>, RobotError> {
    let mut way = Vec::new();
    let mut next = Some(node);
    while let Some(one) = next {
        if way.len() == nodes.len() {
            return Err(RobotError::Circle);
        }
        way.push(one);
        next = nodes[one].parent;
    }
    way.reverse();
    Ok(way)
}

/// A frame whose z axis points along this direction.
fn along_z(axis: &Vector3<f64>) -> Isometry3<f64> {
    let z = axis.normalize();
    let turn = Rotation3::rotation_between(&Vector3::z(), &z)
        .unwrap_or_else(|| Rotation3::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI));
    Isometry3::from_parts(Vector3::zeros().into(), UnitQuaternion::from_rotation_matrix(&turn))
}

/// So many finite numbers of an attribute of an element; `otherwise` where it is absent.
fn numbers<const N: usize>(
    node: roxmltree::Node,
    key: &str,
    of: &str,
    otherwise: Option<[f64; N]>,
) -> Result<[f64; N], RobotError> {
    let text = match (node.attribute(key), otherwise) {
        (Some(text), _) => text,
        (None, Some(otherwise)) => return Ok(otherwise),
        (None, None) => "",
    };
    let words: Vec<Option<f64>> = text.split_whitespace().map(|word| word.parse().ok()).collect();
    let values: Vec<f64> = words.iter().flatten().copied().filter(|value| value.is_finite()).collect();
    <[f64; N]>::try_from(values).ok().filter(|_| words.len() == N).ok_or_else(|| RobotError::Numbers {
        line: line_of(node),
        of: of.to_owned(),
        what: format!("`{key}` of <{}>", node.tag_name().name()),
        text: text.to_owned(),
        must: if N == 1 { "a finite number".to_owned() } else { format!("{N} finite numbers") },
    })
}

/// What an element without a name is called.
pub(crate) fn nameless(node: roxmltree::Node) -> String {
    format!("{} at line {}", node.tag_name().name(), line_of(node))
}

fn line_of(node: roxmltree::Node) -> u32 {
    node.document().text_pos_at(node.range().start).row
}

#[cfg(test)]
mod tests;
