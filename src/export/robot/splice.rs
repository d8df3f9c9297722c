//! Changes of attributes in the text of an XML file; all other letters stay as they are.

use std::ops::Range;

use roxmltree::{Document, Node, ParsingOptions};

use super::Format;
use crate::arm::robot::{MOST_NODES, nameless};

/// The text is no such file.
#[derive(Debug, thiserror::Error)]
pub enum SpliceError {
    /// No XML.
    #[error("it is no XML: {0}; mend it there, or export it again")]
    Xml(#[from] roxmltree::Error),
    /// Another kind of XML.
    #[error("it begins with <{found}>, but {wanted} begins with <{needed}>: name the robot's file itself")]
    Root {
        /// What it begins with.
        found: String,
        /// What was wanted.
        wanted: &'static str,
        /// With what that begins.
        needed: &'static str,
    },
    /// Nothing moves.
    #[error("it has no joint that moves by itself; if it includes other files, name the one in which the joints are")]
    NoJoints,
    /// A link is only named by joints.
    #[error("it has no link or body `{0}` into which its mass could be written; add it")]
    NoLink(String),
}

/// The text as XML.
pub(super) fn parsed(text: &str) -> Result<Document<'_>, SpliceError> {
    let options = ParsingOptions { allow_dtd: false, nodes_limit: MOST_NODES, ..ParsingOptions::default() };
    Ok(Document::parse_with_options(text, options)?)
}

/// Where something new is put in, and what must stand before and behind it.
pub(super) struct Place {
    at: Range<usize>,
    frame: [String; 2],
}

/// Where a joint and its attributes stand.
struct Joint {
    name: String,
    /// The element with the attributes, and where they stand: name, range of the value.
    attributes: Vec<(String, Range<usize>)>,
    /// Where other attributes are put in, and what must stand before and behind all of them.
    place: Range<usize>,
    frame: Option<[String; 2]>,
}

/// A file on its way to other values.
pub(super) struct Splice<'a> {
    text: &'a str,
    joints: Vec<Joint>,
    in_degrees: bool,
    /// What is put where, for one element in the order of the calls.
    changes: Vec<(Range<usize>, String)>,
    /// For each joint without the element that holds the attributes: those that it gets.
    new: Vec<Vec<String>>,
}

impl<'a> Splice<'a> {
    pub(super) fn of(format: Format, text: &'a str) -> Result<Splice<'a>, SpliceError> {
        let document = parsed(text)?;
        let root = document.root_element();
        let (wanted, needed) = match format {
            Format::Urdf => ("a URDF", "robot"),
            Format::Mjcf => ("an MJCF", "mujoco"),
        };
        if root.tag_name().name() != needed {
            let found = root.tag_name().name().to_owned();
            return Err(SpliceError::Root { found, wanted, needed });
        }
        let joints: Vec<Joint> = match format {
            Format::Urdf => urdf_joints(root, text),
            Format::Mjcf => mjcf_joints(root, text),
        };
        if joints.is_empty() {
            return Err(SpliceError::NoJoints);
        }
        let compiler = root.children().filter(|node| node.has_tag_name("compiler"));
        let in_degrees = !compiler.into_iter().any(|node| node.attribute("angle") == Some("radian"));
        let new = joints.iter().map(|_| Vec::new()).collect();
        Ok(Splice { text, joints, in_degrees, changes: Vec::new(), new })
    }

    /// Names of the joints that move, base first.
    pub(super) fn joints(&self) -> Vec<String> {
        self.joints.iter().map(|joint| joint.name.clone()).collect()
    }

    /// A position of a joint in the units of the file.
    pub(super) fn angle(&self, value: f64, turns: bool) -> f64 {
        if turns && self.in_degrees { value.to_degrees() } else { value }
    }

    /// Makes these changes besides.
    pub(super) fn change(&mut self, changes: Vec<(Range<usize>, String)>) {
        self.changes.extend(changes);
    }

    /// The number that an attribute of a joint has; `None` if it has none.
    pub(super) fn number(&self, joint: usize, attribute: &str) -> Option<f64> {
        let (_, range) = self.joints[joint].attributes.iter().find(|(name, _)| name == attribute)?;
        self.text[range.clone()].trim().parse().ok()
    }

    /// Gives an attribute of a joint this value; what stood there.
    pub(super) fn set(&mut self, joint: usize, attribute: &str, value: f64) -> Option<String> {
        let place = &self.joints[joint];
        match place.attributes.iter().find(|(name, _)| name == attribute) {
            Some((_, range)) => {
                let before = self.text[range.clone()].to_owned();
                self.changes.push((range.clone(), value.to_string()));
                Some(before)
            }
            None => {
                self.new[joint].push(format!("{attribute}=\"{value}\""));
                None
            }
        }
    }

    /// The text with all changes.
    pub(super) fn text(&self) -> String {
        let mut changes = self.changes.clone();
        for (joint, new) in self.joints.iter().zip(&self.new).filter(|(_, new)| !new.is_empty()) {
            let all = new.join(" ");
            let put = match &joint.frame {
                Some([before, behind]) => format!("{before}{all}{behind}"),
                None => format!(" {all}"),
            };
            changes.push((joint.place.clone(), put));
        }
        changes.sort_by_key(|(range, _)| range.start);
        let (mut text, mut at) = (String::with_capacity(self.text.len() + 256), 0);
        for (range, put) in changes {
            text.push_str(&self.text[at..range.start]);
            text.push_str(&put);
            at = range.end;
        }
        text.push_str(&self.text[at..]);
        text
    }
}

fn attributes(node: Node) -> Vec<(String, Range<usize>)> {
    node.attributes().map(|attribute| (attribute.name().to_owned(), attribute.range_value())).collect()
}

/// Right behind the name of an element's tag, where an attribute may stand.
pub(super) fn behind_name(node: Node, text: &str) -> usize {
    let start = node.range().start;
    let rest = &text[start..];
    start + rest.find(|c: char| c.is_whitespace() || c == '/' || c == '>').unwrap_or(rest.len())
}

/// Joints that move by themselves, base first: in the order of the tree, whatever that of the file.
fn urdf_joints(root: Node, text: &str) -> Vec<Joint> {
    let moves = |node: &Node| {
        let kind = node.attribute("type").unwrap_or_default();
        ["revolute", "continuous", "prismatic"].contains(&kind) && !node.children().any(|one| one.has_tag_name("mimic"))
    };
    let all: Vec<Node> = root.children().filter(|node| node.has_tag_name("joint")).collect();
    let depth = |node: &Node| {
        let link = |node: &Node, tag: &str| {
            let child = node.children().find(|one| one.has_tag_name(tag));
            child.and_then(|child| child.attribute("link")).map(str::to_owned)
        };
        let (mut depth, mut parent) = (0, link(node, "parent"));
        // A file that goes round in circles has no deeper place than it has joints.
        while let Some(name) = parent.filter(|_| depth < all.len()) {
            depth += 1;
            let before = all.iter().find(|other| link(other, "child").as_deref() == Some(&name));
            parent = before.and_then(|before| link(before, "parent"));
        }
        depth
    };
    let mut moving: Vec<Node> = all.iter().copied().filter(|node| moves(node)).collect();
    moving.sort_by_key(depth);
    moving.into_iter().map(|node| urdf_joint(node, text)).collect()
}

fn urdf_joint(node: Node, text: &str) -> Joint {
    let name = node.attribute("name").unwrap_or("(unnamed)").to_owned();
    if let Some(dynamics) = node.children().find(|one| one.has_tag_name("dynamics")) {
        let place = behind_name(dynamics, text);
        return Joint { name, attributes: attributes(dynamics), place: place..place, frame: None };
    }
    let Place { at, frame: [before, behind] } = Place::behind_children(node, text);
    let frame = Some([format!("{before}<dynamics "), format!("/>{behind}")]);
    Joint { name, attributes: Vec::new(), place: at, frame }
}

impl Place {
    /// In an element, on a line of its own behind the last child, as far to the right as that.
    pub(super) fn behind_children(node: Node, text: &str) -> Place {
        let range = node.range();
        let (at, frame) = match node.children().rfind(Node::is_element) {
            Some(last) => {
                let start = last.range().start;
                let line = text[..start].rfind('\n').map_or(0, |end| end + 1);
                let blanks = &text[line..start];
                let indent = if blanks.trim().is_empty() { format!("\n{blanks}") } else { String::new() };
                (last.range().end..last.range().end, [indent, String::new()])
            }
            None if text[range.clone()].ends_with("/>") => {
                (range.end - 2..range.end, [">".to_owned(), format!("</{}>", node.tag_name().name())])
            }
            None => {
                let end = text[range.clone()].rfind("</").map_or(range.end, |end| range.start + end);
                (end..end, [String::new(), String::new()])
            }
        };
        Place { at, frame }
    }

    /// The change that puts it there.
    pub(super) fn put(self, new: &str) -> (Range<usize>, String) {
        let [before, behind] = self.frame;
        (self.at, format!("{before}{new}{behind}"))
    }
}

/// Joints of the bodies, in the order of the file, which is that of the tree.
fn mjcf_joints(root: Node, text: &str) -> Vec<Joint> {
    let world = root.children().filter(|node| node.has_tag_name("worldbody"));
    let all = world.flat_map(|world| world.descendants()).filter(|node| node.has_tag_name("joint"));
    let moves = |node: &Node| matches!(node.attribute("type"), None | Some("hinge" | "slide"));
    let joint = |node: Node| {
        let name = node.attribute("name").map_or_else(|| nameless(node), str::to_owned);
        let place = behind_name(node, text);
        Joint { name, attributes: attributes(node), place: place..place, frame: None }
    };
    all.filter(moves).map(joint).collect()
}
