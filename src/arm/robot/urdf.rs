//! The frames of a URDF: each joint places the link behind it.
//!
//! Source: ROS, URDF XML `joint` (`limit`, `dynamics`) and `link/inertial` (angles roll, pitch, yaw about fixed axes; the inertia is about the centre of
//! mass, in a frame that `origin` turns).

use std::collections::HashMap;

use nalgebra::{Isometry3, Matrix3, Translation3, UnitQuaternion, Vector3};
use roxmltree::{Document, Node as Element};

use super::{Motion, Node, Part, RobotError, numbers};
use crate::arm::GRAVITY;
use crate::arm::body::Body;
use crate::arm::stated::{Limits, Resistance};

/// The frames, and gravity along −z.
pub(super) fn nodes(document: &Document) -> Result<(Vec<Node>, Vector3<f64>), RobotError> {
    let root = document.root_element();
    let joints: Vec<Element> = root.children().filter(|one| one.has_tag_name("joint")).collect();
    let links = root.children().filter(|one| one.has_tag_name("link"));
    let links: HashMap<&str, Element> = links.filter_map(|one| Some((one.attribute("name")?, one))).collect();
    let by_child: HashMap<&str, usize> =
        joints.iter().enumerate().filter_map(|(place, joint)| Some((link(*joint, "child")?, place))).collect();
    let node = |joint: &Element| {
        let name = joint.attribute("name").unwrap_or("(unnamed)");
        let kind = joint.attribute("type").unwrap_or_default();
        let moves = ["revolute", "continuous", "prismatic"].contains(&kind) && child(*joint, "mimic").is_none();
        let axis = child(*joint, "axis").map_or(Ok([1.0, 0.0, 0.0]), |axis| numbers(axis, "xyz", name, None))?;
        let motion = Motion {
            name: name.to_owned(),
            axis: axis.into(),
            slides: kind == "prismatic",
            resistance: resistance(*joint, name)?,
            limits: limits(*joint, name, kind == "continuous")?,
        };
        let part = link(*joint, "child").map(|own| part(own, links.get(own).copied())).transpose()?;
        let parent = link(*joint, "parent").and_then(|parent| by_child.get(parent).copied());
        Ok(Node { parent, frame: origin(*joint, name)?, motion: moves.then_some(motion), part })
    };
    let nodes = joints.iter().map(node).collect::<Result<_, RobotError>>()?;
    Ok((nodes, Vector3::new(0.0, 0.0, -GRAVITY)))
}

fn child<'a, 'input>(of: Element<'a, 'input>, tag: &str) -> Option<Element<'a, 'input>> {
    of.children().find(|one| one.has_tag_name(tag))
}

/// The link before or behind a joint.
fn link<'a>(joint: Element<'a, '_>, tag: &str) -> Option<&'a str> {
    child(joint, tag)?.attribute("link")
}

/// Where the `origin` of an element is.
fn origin(of: Element, name: &str) -> Result<Isometry3<f64>, RobotError> {
    let Some(origin) = child(of, "origin") else { return Ok(Isometry3::identity()) };
    let place = Vector3::from(numbers(origin, "xyz", name, Some([0.0; 3]))?);
    let [roll, pitch, yaw] = numbers(origin, "rpy", name, Some([0.0; 3]))?;
    Ok(Isometry3::from_parts(Translation3::from(place), UnitQuaternion::from_euler_angles(roll, pitch, yaw)))
}

/// A number of an element that may be absent.
fn optional(of: Option<Element>, key: &str, name: &str) -> Result<Option<f64>, RobotError> {
    let Some(element) = of.filter(|element| element.has_attribute(key)) else { return Ok(None) };
    numbers(element, key, name, None).map(|[value]| Some(value))
}

/// What `dynamics` says.
fn resistance(joint: Element, name: &str) -> Result<Resistance, RobotError> {
    let said = |key: &str| optional(child(joint, "dynamics"), key, name).map(Option::unwrap_or_default);
    Ok(Resistance { damping: said("damping")?, friction: said("friction")?, ..Resistance::default() })
}

/// What `limit` says; a speed or an effort of 0 stands for none that is known. Ends that are absent are 0 there.
fn limits(joint: Element, name: &str, is_endless: bool) -> Result<Limits, RobotError> {
    let limit = child(joint, "limit");
    let said = |key: &str| optional(limit, key, name);
    let position = match [said("lower")?, said("upper")?] {
        [None, None] => None,
        [lower, upper] => Some([lower.unwrap_or(0.0), upper.unwrap_or(0.0)]),
    };
    let above_zero = |value: Option<f64>| value.filter(|value| *value > 0.0);
    Ok(Limits {
        position: position.filter(|[lower, upper]| !is_endless && lower < upper),
        velocity: above_zero(said("velocity")?),
        effort: above_zero(said("effort")?),
    })
}

fn part(name: &str, link: Option<Element>) -> Result<Part, RobotError> {
    let body = |inertial: Element| -> Result<Option<Body>, RobotError> {
        let (Some(mass), Some(inertia)) = (child(inertial, "mass"), child(inertial, "inertia")) else {
            return Ok(None);
        };
        let [mass] = numbers(mass, "value", name, None)?;
        let moment = |key: &str| numbers(inertia, key, name, Some([0.0])).map(|[value]| value);
        let [xx, xy, xz] = [moment("ixx")?, moment("ixy")?, moment("ixz")?];
        let [yy, yz, zz] = [moment("iyy")?, moment("iyz")?, moment("izz")?];
        let turned = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
        let frame = origin(inertial, name)?;
        let own = Body { mass, com: Vector3::zeros(), inertia: turned };
        Ok(Some(own.seen_from(&frame.inverse())))
    };
    let inertial = link.and_then(|link| child(link, "inertial"));
    let body = inertial.map(body).transpose()?.flatten();
    Ok(Part { name: name.to_owned(), frame: Isometry3::identity(), body })
}
