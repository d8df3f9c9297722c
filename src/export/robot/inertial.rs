//! Where the masses of a link stand in the text of a robot's file, and what is written there.

use std::ops::Range;

use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use roxmltree::{Document, Node};

use super::Format;
use super::splice::{Place, SpliceError, behind_name, parsed};
use crate::arm::body::Body;

/// A stretch of the text, and what comes in its place.
type Changes = Vec<(Range<usize>, String)>;

/// No link is so light or so small \[kg, m, kg m²\].
const ROUNDING: f64 = 1e-15;
/// The ways in which an MJCF says a rotation; `fullinertia` can have none beside it.
const ROTATIONS: [&str; 5] = ["quat", "axisangle", "euler", "xyaxes", "zaxis"];

/// What makes this the body of a link (by its name in the file), in the frame of the link.
pub(super) fn changes(format: Format, text: &str, link: &str, body: &Body) -> Result<Changes, SpliceError> {
    let document = parsed(text)?;
    let tag = match format {
        Format::Urdf => "link",
        Format::Mjcf => "body",
    };
    let is_it = |node: &Node| match node.attribute("name") {
        Some(name) => name == link,
        None => crate::arm::robot::nameless(*node) == link,
    };
    let found = document.descendants().filter(|node| node.has_tag_name(tag)).find(is_it);
    let node = found.ok_or_else(|| SpliceError::NoLink(link.to_owned()))?;
    Ok(match (format, child(node, "inertial")) {
        (Format::Urdf, Some(inertial)) => in_urdf(inertial, text, body),
        (Format::Urdf, None) => {
            let [mass, origin, inertia] = urdf_texts(body);
            let all = format!("<inertial><mass {mass}/><origin {origin}/><inertia {inertia}/></inertial>");
            vec![Place::behind_children(node, text).put(&all)]
        }
        (Format::Mjcf, Some(inertial)) => in_mjcf(&document, inertial, text, body),
        (Format::Mjcf, None) => {
            let [pos, mass, inertia] = mjcf_values(body);
            let all = format!("<inertial pos=\"{pos}\" mass=\"{mass}\" fullinertia=\"{inertia}\"/>");
            vec![Place::behind_children(node, text).put(&all)]
        }
    })
}

fn child<'a, 'input>(of: Node<'a, 'input>, tag: &str) -> Option<Node<'a, 'input>> {
    of.children().find(|one| one.has_tag_name(tag))
}

/// Gives an attribute a value: in its place, or behind the name of the tag.
fn set(node: Node, text: &str, key: &str, value: &str) -> (Range<usize>, String) {
    match node.attribute_node(key) {
        Some(attribute) => (attribute.range_value(), value.to_owned()),
        None => {
            let place = behind_name(node, text);
            (place..place, format!(" {key}=\"{value}\""))
        }
    }
}

/// The frame of the inertia stays turned as it was.
fn in_urdf(inertial: Node, text: &str, body: &Body) -> Changes {
    let angles = child(inertial, "origin").and_then(|origin| origin.attribute("rpy")).unwrap_or_default();
    let angles: Vec<f64> = angles.split_whitespace().filter_map(|word| word.parse().ok()).collect();
    let turn = match angles.as_slice() {
        [roll, pitch, yaw] => UnitQuaternion::from_euler_angles(*roll, *pitch, *yaw),
        _ => UnitQuaternion::identity(),
    };
    let turned = body.seen_from(&Isometry3::from_parts(Vector3::zeros().into(), turn));
    let values = [
        ("mass", vec![("value", body.mass.to_string())]),
        ("origin", vec![("xyz", spaced(body.com.iter()))]),
        ("inertia", urdf_moments(&turned).to_vec()),
    ];
    let written = |(tag, values): &(&str, Vec<(&str, String)>)| match child(inertial, tag) {
        Some(node) => values.iter().map(|(key, value)| set(node, text, key, value)).collect(),
        None => vec![Place::behind_children(inertial, text).put(&format!("<{tag} {}/>", attributes(values)))],
    };
    values.iter().flat_map(written).collect()
}

fn urdf_moments(body: &Body) -> [(&'static str, String); 6] {
    let keys = [("ixx", 0, 0), ("ixy", 0, 1), ("ixz", 0, 2), ("iyy", 1, 1), ("iyz", 1, 2), ("izz", 2, 2)];
    keys.map(|(key, row, column)| (key, written(&body.inertia[(row, column)])))
}

/// The attributes of `mass`, `origin` and `inertia`.
fn urdf_texts(body: &Body) -> [String; 3] {
    let mass = attributes(&[("value", body.mass.to_string())]);
    [mass, attributes(&[("xyz", spaced(body.com.iter()))]), attributes(&urdf_moments(body))]
}

fn in_mjcf(document: &Document, inertial: Node, text: &str, body: &Body) -> Changes {
    let [pos, mass, inertia] = mjcf_values(body);
    let mut changes = vec![set(inertial, text, "pos", &pos), set(inertial, text, "mass", &mass)];
    match inertial.attribute_node("diaginertia") {
        Some(own) => changes.push((own.range(), format!("fullinertia=\"{inertia}\""))),
        None => changes.push(set(inertial, text, "fullinertia", &inertia)),
    }
    for rotation in inertial.attributes().filter(|attribute| ROTATIONS.contains(&attribute.name())) {
        let start = document.input_text()[..rotation.range().start].trim_end().len();
        changes.push((start..rotation.range().end, String::new()));
    }
    changes
}

/// `pos`, `mass` and `fullinertia`.
fn mjcf_values(body: &Body) -> [String; 3] {
    let places = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)];
    let moments = places.map(|place| body.inertia[place]);
    [spaced(body.com.iter()), body.mass.to_string(), spaced(moments.iter())]
}

/// What is only rounding is 0.
fn written(value: &f64) -> String {
    if value.abs() < ROUNDING { "0".to_owned() } else { value.to_string() }
}

fn spaced<'a>(values: impl Iterator<Item = &'a f64>) -> String {
    values.map(written).collect::<Vec<_>>().join(" ")
}

fn attributes(values: &[(&str, String)]) -> String {
    values.iter().map(|(key, value)| format!("{key}=\"{value}\"")).collect::<Vec<_>>().join(" ")
}
