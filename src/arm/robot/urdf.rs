//! The axes of a serial arm from its URDF. Of the file only joints are read: no mesh, and no mass, since masses are identified.
//!
//! Joints that follow others (`mimic`) are taken for fixed ones. The frame of the base of the chain is that of its first axis; gravity
//! is turned into it, along −z of the URDF.
//! Sources: ROS, URDF XML `joint`; Craig, Introduction to Robotics (2005), ch. 3 (how frames are attached to axes).

use std::collections::HashMap;

use nalgebra::{Isometry3, Rotation3, Translation3, UnitQuaternion, Vector3};
use roxmltree::{Document, Node, ParsingOptions};

use super::chain::{Axis, Chain, Convention};
use super::{GRAVITY, MOST_JOINTS};

/// Axes that point along each other within this angle \[rad\] are parallel.
const PARALLEL: f64 = 1e-9;
/// No robot has more elements.
const MOST_NODES: u32 = 1_000_000;

/// The axes of an arm, and its joints.
#[derive(Debug, Clone, PartialEq)]
pub struct UrdfArm {
    /// Where the axes are.
    pub chain: Chain,
    /// Names of the joints, base first.
    pub joints: Vec<String>,
    /// Which of them slide.
    pub sliding: Vec<bool>,
}

/// The text gives no arm.
#[derive(Debug, thiserror::Error)]
pub enum UrdfError {
    /// No XML.
    #[error(
        "it is no XML: {0}; mend it there, or export it again (a xacro file becomes a URDF by `xacro robot.xacro`)"
    )]
    Xml(#[from] roxmltree::Error),
    /// Another kind of XML.
    #[error("it begins with <{0}>, but a URDF begins with <robot>")]
    Root(String),
    /// Numbers that are none.
    #[error("joint `{joint}`: {what} is `{text}`, but must be three finite numbers")]
    Numbers {
        /// Its name.
        joint: String,
        /// What is wrong.
        what: &'static str,
        /// What stands there.
        text: String,
    },
    /// A joint without an axis that could be.
    #[error("joint `{0}` has an axis of length 0; give it a direction")]
    NoAxis(String),
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
        "its moving joints {names} are no serial chain: `{joint}` does not follow the one before; make all but those of one arm fixed"
    )]
    NotSerial {
        /// All of them.
        names: String,
        /// The first that does not.
        joint: String,
    },
}

/// A joint of the file.
struct Joint {
    name: String,
    parent: String,
    child: String,
    origin: Isometry3<f64>,
    axis: Vector3<f64>,
    moves: bool,
    slides: bool,
}

/// An axis at q = 0, in the frame of the base of the URDF.
struct Line {
    point: Vector3<f64>,
    direction: Vector3<f64>,
}

impl UrdfArm {
    /// Reads the text of a URDF.
    ///
    /// # Errors
    /// [`UrdfError`] says what is wrong and how to mend it.
    pub fn parse(text: &str) -> Result<UrdfArm, UrdfError> {
        let options = ParsingOptions { allow_dtd: false, nodes_limit: MOST_NODES, ..ParsingOptions::default() };
        let document = Document::parse_with_options(text, options)?;
        let root = document.root_element();
        if root.tag_name().name() != "robot" {
            return Err(UrdfError::Root(root.tag_name().name().to_owned()));
        }
        let all = root.children().filter(|node| node.has_tag_name("joint"));
        let joints = all.map(joint).collect::<Result<Vec<Joint>, _>>()?;
        let serial = serial(&joints)?;
        let lines: Vec<Line> = serial.iter().map(|(joint, frame)| line(joint, frame)).collect();
        Ok(UrdfArm {
            chain: chain(&lines),
            joints: serial.iter().map(|(joint, _)| joint.name.clone()).collect(),
            sliding: serial.iter().map(|(joint, _)| joint.slides).collect(),
        })
    }
}

fn joint(node: Node) -> Result<Joint, UrdfError> {
    let name = node.attribute("name").unwrap_or("(unnamed)").to_owned();
    let child = |tag: &str| node.children().find(|one| one.has_tag_name(tag));
    let link = |tag: &str| child(tag).and_then(|one| one.attribute("link")).unwrap_or_default().to_owned();
    let three = |tag: &str, key: &str, what: &'static str, otherwise: [f64; 3]| {
        let Some(text) = child(tag).and_then(|one| one.attribute(key)) else { return Ok(Vector3::from(otherwise)) };
        let numbers: Vec<f64> = text.split_whitespace().filter_map(|word| word.parse().ok()).collect();
        match numbers.as_slice() {
            [x, y, z] if numbers.iter().all(|value| value.is_finite()) && text.split_whitespace().count() == 3 => {
                Ok(Vector3::new(*x, *y, *z))
            }
            _ => Err(UrdfError::Numbers { joint: name.clone(), what, text: text.to_owned() }),
        }
    };
    let place = three("origin", "xyz", "the place of its origin", [0.0; 3])?;
    let angles = three("origin", "rpy", "the rotation of its origin", [0.0; 3])?;
    let axis = three("axis", "xyz", "its axis", [1.0, 0.0, 0.0])?;
    let kind = node.attribute("type").unwrap_or_default();
    let moves = ["revolute", "continuous", "prismatic"].contains(&kind) && child("mimic").is_none();
    if moves && axis.norm() < PARALLEL {
        return Err(UrdfError::NoAxis(name));
    }
    let rotation = UnitQuaternion::from_euler_angles(angles.x, angles.y, angles.z);
    let origin = Isometry3::from_parts(Translation3::from(place), rotation);
    let (parent, child) = (link("parent"), link("child"));
    Ok(Joint { name, parent, child, origin, axis, moves, slides: kind == "prismatic" })
}

/// The joints that move, base first, each with its frame at q = 0.
fn serial(joints: &[Joint]) -> Result<Vec<(&Joint, Isometry3<f64>)>, UrdfError> {
    let by_child: HashMap<&str, &Joint> = joints.iter().map(|joint| (joint.child.as_str(), joint)).collect();
    let mut moving: Vec<(&Joint, Vec<&Joint>)> =
        joints.iter().filter(|joint| joint.moves).map(|joint| (joint, way(joint, &by_child))).collect();
    moving.sort_by_key(|(_, way)| way.len());
    let names = moving.iter().map(|(joint, _)| joint.name.as_str()).collect::<Vec<_>>().join(", ");
    if !(1..=MOST_JOINTS).contains(&moving.len()) {
        return Err(UrdfError::Count { found: moving.len(), names });
    }
    for pair in moving.windows(2) {
        let [(before, _), (joint, way)] = pair else { continue };
        if !way.iter().any(|one| one.name == before.name) || before.name == joint.name {
            return Err(UrdfError::NotSerial { names, joint: joint.name.clone() });
        }
    }
    let frame = |way: &[&Joint]| way.iter().fold(Isometry3::identity(), |frame, joint| frame * joint.origin);
    Ok(moving.into_iter().map(|(joint, way)| (joint, frame(&way))).collect())
}

/// The joints from the base to this one; in a file that goes round in circles, as many as there are.
fn way<'a>(joint: &'a Joint, by_child: &HashMap<&str, &'a Joint>) -> Vec<&'a Joint> {
    let mut way = Vec::new();
    let mut next = Some(joint);
    while let Some(one) = next.filter(|_| way.len() < by_child.len()) {
        way.push(one);
        next = by_child.get(one.parent.as_str()).copied();
    }
    way.reverse();
    way
}

fn line(joint: &Joint, frame: &Isometry3<f64>) -> Line {
    Line { point: frame.translation.vector, direction: frame.rotation * joint.axis.normalize() }
}

/// A frame on an axis: its origin and its x axis; z is the axis.
struct Frame {
    origin: Vector3<f64>,
    x: Vector3<f64>,
}

/// The axes in modified Denavit–Hartenberg rows.
fn chain(lines: &[Line]) -> Chain {
    let mut frames: Vec<Frame> = Vec::new();
    // Where the common normal of an axis and the one before meets it.
    let mut feet: Vec<Vector3<f64>> = vec![lines[0].point];
    for (index, own) in lines.iter().enumerate() {
        match lines.get(index + 1) {
            Some(next) => {
                let before = frames.last().map(|frame| frame.x);
                let (frame, foot) = common_normal(own, next, before);
                frames.push(frame);
                feet.push(foot);
            }
            None => {
                let x = frames.last().map_or_else(|| across(&own.direction), |frame| frame.x);
                frames.push(Frame { origin: feet[index], x });
            }
        }
    }
    let z = &lines[0].direction;
    let base = Rotation3::from_basis_unchecked(&[frames[0].x, z.cross(&frames[0].x), *z]);
    let gravity = base.transpose() * Vector3::new(0.0, 0.0, -GRAVITY);
    let mut axes = vec![Axis::default()];
    for index in 1..lines.len() {
        let (before, own, x) = (&lines[index - 1].direction, &lines[index].direction, &frames[index - 1].x);
        axes.push(Axis {
            a: (feet[index] - frames[index - 1].origin).dot(x),
            alpha: angle(before, own, x),
            d: (frames[index].origin - feet[index]).dot(own),
            theta: angle(x, &frames[index].x, own),
        });
    }
    Chain { convention: Convention::Modified, axes, gravity: gravity.into() }
}

/// The angle from one vector to another about an axis.
fn angle(from: &Vector3<f64>, to: &Vector3<f64>, about: &Vector3<f64>) -> f64 {
    from.cross(to).dot(about).atan2(from.dot(to))
}

/// Some direction across this one.
fn across(direction: &Vector3<f64>) -> Vector3<f64> {
    let other = if direction.x.abs() < 0.9 { Vector3::x() } else { Vector3::y() };
    (other - direction * direction.dot(&other)).normalize()
}

/// The frame on an axis whose x points along the common normal to the next, and where that meets the next. If they are one line,
/// x stays as it was before.
fn common_normal(own: &Line, next: &Line, before: Option<Vector3<f64>>) -> (Frame, Vector3<f64>) {
    let between = next.point - own.point;
    let normal = own.direction.cross(&next.direction);
    if normal.norm() > PARALLEL {
        let x = normal.normalize();
        // The point of each line that is nearest to the other.
        let along = |one: &Line, other: &Line, gap: &Vector3<f64>| {
            let side = other.direction.cross(&normal);
            one.point + one.direction * (gap.dot(&side) / one.direction.dot(&side))
        };
        let (origin, foot) = (along(own, next, &between), along(next, own, &-between));
        return (Frame { origin, x }, foot);
    }
    let apart = between - own.direction * own.direction.dot(&between);
    let kept = before.map(|x| x - own.direction * own.direction.dot(&x)).filter(|x| x.norm() > 0.1);
    let x = match apart.norm() > PARALLEL {
        true => apart.normalize(),
        false => kept.map_or_else(|| across(&own.direction), |x| x.normalize()),
    };
    (Frame { origin: own.point, x }, own.point + apart)
}

#[cfg(test)]
mod tests {
    use super::*;

    const ARM: &str = r#"<robot name="r">
      <joint name="tool" type="fixed"><origin xyz="0 0 1"/><parent link="l4"/><child link="t"/></joint>
      <joint name="j3" type="prismatic"><origin xyz="0.1 0.2 0.3" rpy="0.3 -0.4 0.5"/><axis xyz="0 1 1"/><parent link="l2"/><child link="l3"/></joint>
      <joint name="j1" type="revolute"><origin xyz="0 0 0.4" rpy="0.2 0 0"/><axis xyz="0 0 1"/><parent link="base"/><child link="l1"/></joint>
      <joint name="plate" type="fixed"><origin xyz="0.3 0 0" rpy="0 0.7 0"/><parent link="l1"/><child link="p"/></joint>
      <joint name="j2" type="continuous"><origin xyz="0 0.1 0"/><axis xyz="1 0 0"/><parent link="p"/><child link="l2"/></joint>
      <joint name="j4" type="revolute"><origin xyz="0.5 0 0"/><axis xyz="0 1 1"/><parent link="l3"/><child link="l4"/></joint>
      <joint name="finger" type="prismatic"><mimic joint="j3"/><parent link="l4"/><child link="f"/></joint>
    </robot>"#;

    /// The torque of a mass and an inertia on the last link, by the energy of the URDF itself: Lagrange's equation in differences.
    #[test]
    fn the_chain_moves_as_the_urdf_does() {
        let arm = UrdfArm::parse(ARM).unwrap();
        assert_eq!(
            (arm.joints.join(" "), arm.sliding.clone()),
            ("j1 j2 j3 j4".to_owned(), vec![false, false, true, false])
        );
        let document = Document::parse(ARM).unwrap();
        let of_file: Vec<Joint> =
            document.root_element().children().filter(Node::is_element).map(|node| joint(node).unwrap()).collect();
        let named = |name: &str| of_file.iter().find(|joint| joint.name == name).unwrap();
        // A point on each moving link, in the frame of the base.
        let place = |q: &[f64; 4], link: usize| {
            let mut frame = Isometry3::identity();
            for (index, name) in ["j1", "j2", "j3", "j4"].iter().enumerate().take(link + 1) {
                if index == 1 {
                    frame *= named("plate").origin;
                }
                let joint = named(name);
                frame *= joint.origin;
                let axis = joint.axis.normalize();
                frame *= match joint.slides {
                    true => Isometry3::translation(axis.x * q[index], axis.y * q[index], axis.z * q[index]),
                    false => Isometry3::rotation(axis * q[index]),
                };
            }
            frame * nalgebra::Point3::new(0.3, -0.2, 0.4)
        };
        // Distances between points on different links, and heights, are the same whatever frames are chosen; the gravity torque of a
        // unit mass at that point is the slope of its height.
        let q = [0.4, -0.9, 0.25, 1.3];
        let frames = arm.chain.frames();
        for link in 0..4 {
            let slope = |joint: usize| {
                let shifted = |by: f64| {
                    let mut q = q;
                    q[joint] += by;
                    place(&q, link).z
                };
                GRAVITY * (shifted(1e-6) - shifted(-1e-6)) / 2e-6
            };
            // The same point in the link's frame of the chain, by both at q = 0.
            let at_rest = place(&[0.0; 4], link);
            let first = line(of_first(&of_file), &first_frame(&of_file));
            let lines = lines_of(&of_file);
            let whole = chain(&lines);
            assert_eq!(whole, arm.chain);
            let mut frame = base_frame(&lines, &first);
            for step in &frames[..=link] {
                let rotation = nalgebra::Matrix3::from_fn(|row, column| step.rotation[row][column]);
                let rotation = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(rotation));
                frame *= Isometry3::from_parts(Translation3::from(Vector3::from(step.offset)), rotation);
            }
            let own = frame.inverse() * at_rest;
            let mut parameters = vec![0.0; 40];
            parameters[10 * link] = 1.0;
            parameters[10 * link + 1..10 * link + 4].copy_from_slice(own.coords.as_slice());
            let mut torque = [0.0; 4];
            arm.chain.regressor(&arm.sliding).torque(&q, &[0.0; 4], &[0.0; 4], &parameters, &mut torque);
            for joint in 0..4 {
                let expected = if joint <= link { slope(joint) } else { 0.0 };
                assert!(
                    (torque[joint] - expected).abs() < 1e-6,
                    "link {link}, joint {joint}: {} {expected}",
                    torque[joint]
                );
            }
        }
    }

    fn of_first(joints: &[Joint]) -> &Joint {
        joints.iter().find(|joint| joint.name == "j1").unwrap()
    }

    fn first_frame(joints: &[Joint]) -> Isometry3<f64> {
        of_first(joints).origin
    }

    fn lines_of(joints: &[Joint]) -> Vec<Line> {
        serial(joints).unwrap().iter().map(|(joint, frame)| line(joint, frame)).collect()
    }

    /// The frame of the first axis, in which the chain begins.
    fn base_frame(lines: &[Line], first: &Line) -> Isometry3<f64> {
        let (frame, _) = common_normal(&lines[0], &lines[1], None);
        let z = first.direction;
        let rotation = Rotation3::from_basis_unchecked(&[frame.x, z.cross(&frame.x), z]);
        Isometry3::from_parts(Translation3::from(frame.origin), UnitQuaternion::from_rotation_matrix(&rotation))
    }

    #[test]
    fn what_is_no_arm_is_refused_with_the_remedy() {
        let message = |text: &str| UrdfArm::parse(text).unwrap_err().to_string();
        assert!(message("<mujoco/>").contains("<mujoco>") && message("<robot>").contains("no XML"));
        assert!(message("<robot/>").contains("0 moving joints"));
        assert!(message(&ARM.replace("0.1 0.2 0.3", "0.1 0.2")).contains("`j3`: the place of its origin is `0.1 0.2`"));
        assert!(message(&ARM.replace("xyz=\"1 0 0\"", "xyz=\"0 0 0\"")).contains("`j2` has an axis of length 0"));
        let hand = ARM
            .replace("<mimic joint=\"j3\"/>", "")
            .replace("<parent link=\"l4\"/><child link=\"f\"/>", "<parent link=\"l1\"/><child link=\"f\"/>");
        assert!(message(&hand).contains("no serial chain"), "{}", message(&hand));
    }
}
