//! The frames of an MJCF: bodies stand in each other, and each may have joints, which are passed one after the other.
//!
//! Classes of defaults are followed for joints, angles are those of the compiler. What would change the arm and is not understood (other files, frames that are repeated or attached, joints that are no hinge and no slide) is refused with its place.
//! Source: MuJoCo, XML reference (`compiler`, `default`, `body`, `joint`, `inertial`, `equality`, `option`).

use nalgebra::{Isometry3, Matrix3, Quaternion, Rotation3, Translation3, Unit, UnitQuaternion, Vector3};
use roxmltree::{Document, Node as Element};

use super::{Motion, Node, Part, RobotError, line_of, nameless, numbers};
use crate::arm::GRAVITY;
use crate::arm::body::Body;
use crate::arm::stated::{Limits, Resistance};

/// What may stand in a body without changing how it moves or where it is.
const HARMLESS: [&str; 5] = ["geom", "site", "camera", "light", "plugin"];
const FLATTEN: &str = "write the whole model into one file (`mujoco.mj_saveLastXML`), and name that";
const ARM_ALONE: &str = "take it out, or name a file with the arm alone";

/// What holds for the whole file.
struct Setting<'a, 'input> {
    root: Element<'a, 'input>,
    in_degrees: bool,
    /// The order of `euler`; a small letter turns about the axis that was turned already.
    order: String,
    /// Joints that follow others.
    following: Vec<String>,
    /// Whether masses come from shapes, whatever `inertial` says.
    by_shape: bool,
    /// Whether a range limits where nothing says that it does.
    limits_by_range: bool,
}

/// The frames, and gravity.
pub(super) fn nodes(document: &Document) -> Result<(Vec<Node>, Vector3<f64>), RobotError> {
    let root = document.root_element();
    if let Some(include) = root.descendants().find(|one| one.has_tag_name("include")) {
        return Err(not_understood(include, FLATTEN));
    }
    let setting = Setting::of(root)?;
    let mut nodes = Vec::new();
    for world in sections(root, "worldbody") {
        setting.bodies(world, &mut nodes)?;
    }
    let gravity = sections(root, "option").filter(|one| one.has_attribute("gravity")).last();
    let standard = [0.0, 0.0, -GRAVITY];
    let gravity = gravity.map_or(Ok(standard), |option| numbers(option, "gravity", "option", None))?;
    Ok((nodes, gravity.into()))
}

fn sections<'a, 'input>(root: Element<'a, 'input>, name: &'static str) -> impl Iterator<Item = Element<'a, 'input>> {
    root.children().filter(move |one| one.has_tag_name(name))
}

fn not_understood(element: Element, remedy: &'static str) -> RobotError {
    RobotError::NotUnderstood { line: line_of(element), what: format!("<{}>", element.tag_name().name()), remedy }
}

fn wrong(element: Element, key: &str, of: &str, must: &str) -> RobotError {
    RobotError::Numbers {
        line: line_of(element),
        of: of.to_owned(),
        what: format!("`{key}` of <{}>", element.tag_name().name()),
        text: element.attribute(key).unwrap_or_default().to_owned(),
        must: must.to_owned(),
    }
}

/// A body that is not looked at yet.
#[derive(Clone, Copy)]
struct Waiting<'a, 'input> {
    body: Element<'a, 'input>,
    /// The frame before it.
    parent: Option<usize>,
    /// How the frame of what it stands in stands there.
    frame: Isometry3<f64>,
    /// The class of defaults.
    class: &'a str,
}

/// The bodies in this one, each to wait.
fn enter<'a, 'input>(within: Waiting<'a, 'input>, waiting: &mut Vec<Waiting<'a, 'input>>) -> Result<(), RobotError> {
    for one in within.body.children().filter(Element::is_element) {
        match one.tag_name().name() {
            "body" => waiting.push(Waiting { body: one, ..within }),
            "joint" | "inertial" if within.body.has_tag_name("body") => {}
            name if HARMLESS.contains(&name) => {}
            "freejoint" => return Err(not_understood(one, "fix the base of the arm in the world")),
            _ => return Err(not_understood(one, FLATTEN)),
        }
    }
    Ok(())
}

impl<'a, 'input> Setting<'a, 'input> {
    fn of(root: Element<'a, 'input>) -> Result<Self, RobotError> {
        let said = |key: &str| sections(root, "compiler").filter_map(|one| one.attribute(key)).last();
        if let Some(compiler) = sections(root, "compiler").find(|one| one.attribute("coordinate") == Some("global")) {
            return Err(wrong(
                compiler,
                "coordinate",
                "compiler",
                "`local`; save the model anew by MuJoCo, which turns it",
            ));
        }
        let mut following = Vec::new();
        for equality in sections(root, "equality").flat_map(|one| one.children()).filter(Element::is_element) {
            match (equality.tag_name().name(), equality.attribute("joint1")) {
                ("joint", Some(joint)) => following.push(joint.to_owned()),
                _ => return Err(not_understood(equality, ARM_ALONE)),
            }
        }
        let order = said("eulerseq").unwrap_or("xyz").to_owned();
        let is_order = order.len() == 3 && order.chars().all(|letter| "xyzXYZ".contains(letter));
        match sections(root, "compiler").find(|one| one.has_attribute("eulerseq")).filter(|_| !is_order) {
            Some(compiler) => Err(wrong(compiler, "eulerseq", "compiler", "three of x, y, z, X, Y, Z")),
            None => Ok(Setting {
                root,
                in_degrees: said("angle") != Some("radian"),
                order,
                following,
                by_shape: said("inertiafromgeom") == Some("true"),
                limits_by_range: said("autolimits") != Some("false"),
            }),
        }
    }

    /// The bodies of the world, and all that stand in them.
    fn bodies(&self, world: Element<'a, 'input>, nodes: &mut Vec<Node>) -> Result<(), RobotError> {
        // Bodies wait here, so that no depth of them is too much.
        let mut waiting = Vec::new();
        enter(Waiting { body: world, parent: None, frame: Isometry3::identity(), class: "main" }, &mut waiting)?;
        while let Some(next) = waiting.pop() {
            let class = next.body.attribute("childclass").unwrap_or(next.class);
            let (last, frame) = self.body(&Waiting { class, ..next }, nodes)?;
            enter(Waiting { body: next.body, parent: Some(last), frame, class }, &mut waiting)?;
        }
        Ok(())
    }

    /// One body: a frame for each of its joints, or one that is fixed. Back comes the last, and how the body's own frame stands in it.
    fn body(
        &self,
        waiting: &Waiting<'a, 'input>,
        nodes: &mut Vec<Node>,
    ) -> Result<(usize, Isometry3<f64>), RobotError> {
        let Waiting { body, parent, frame, class } = *waiting;
        let name = body.attribute("name").map_or_else(|| nameless(body), str::to_owned);
        let mut place = frame * self.pose(body, &name)?;
        let (mut before, mut back) = (parent, Isometry3::identity());
        for joint in body.children().filter(|one| one.has_tag_name("joint")) {
            let (motion, origin) = self.joint(joint, class)?;
            let origin = Isometry3::from(Translation3::from(origin));
            nodes.push(Node { parent: before, frame: place * origin, motion, part: None });
            (place, before, back) = (origin.inverse(), Some(nodes.len() - 1), origin.inverse());
        }
        if before == parent {
            nodes.push(Node { parent, frame: place, motion: None, part: None });
        }
        let last = nodes.len() - 1;
        let inertial = body.children().find(|one| one.has_tag_name("inertial")).filter(|_| !self.by_shape);
        let own = inertial.map(|inertial| self.inertial(inertial, &name)).transpose()?;
        nodes[last].part = Some(Part { name, frame: back, body: own });
        Ok((last, back))
    }

    /// How a joint moves, and where its axis is in the body; nothing moves if it follows another.
    fn joint(&self, joint: Element<'a, 'input>, class: &str) -> Result<(Option<Motion>, Vector3<f64>), RobotError> {
        let name = joint.attribute("name").map_or_else(|| nameless(joint), str::to_owned);
        let class = joint.attribute("class").unwrap_or(class);
        let own = |key: &str| self.holder(joint, class, key);
        let kind = own("type").attribute("type").unwrap_or("hinge");
        if !["hinge", "slide"].contains(&kind) {
            return Err(wrong(own("type"), "type", &name, "`hinge` or `slide`"));
        }
        if numbers(own("ref"), "ref", &name, Some([0.0]))? != [0.0] {
            return Err(wrong(
                own("ref"),
                "ref",
                &name,
                "0; turn the body instead, so that the joint is at 0 as it is drawn",
            ));
        }
        let axis = Vector3::from(numbers(own("axis"), "axis", &name, Some([0.0, 0.0, 1.0]))?);
        let origin = Vector3::from(numbers(own("pos"), "pos", &name, Some([0.0; 3]))?);
        let slides = kind == "slide";
        let stated = |key: &str| numbers(own(key), key, &name, Some([0.0])).map(|[value]| value);
        let stiffness = stated("stiffness")?;
        let angle = |value: f64| if self.in_degrees && !slides { value.to_radians() } else { value };
        // Where the spring is at rest.
        let rest = stated("springref").map(angle)?;
        let resistance = Resistance {
            stiffness,
            preload: if rest == 0.0 { 0.0 } else { -stiffness * rest },
            rotor_inertia: stated("armature")?,
            damping: stated("damping")?,
            friction: stated("frictionloss")?,
        };
        let limits = self.limits(own, &name, slides)?;
        let motion = Motion { slides, axis, name, resistance, limits };
        Ok((Some(motion).filter(|motion| !self.following.contains(&motion.name)), origin))
    }

    /// How far a joint moves, and how strongly its actuators may act; `own` is the element that says an attribute of it.
    fn limits(
        &self,
        own: impl Fn(&str) -> Element<'a, 'input>,
        name: &str,
        slides: bool,
    ) -> Result<Limits, RobotError> {
        // What nobody says is limited, is where its range is said.
        let within = |range: &'static str, switch: &str| {
            let element = own(range);
            let is_said = match own(switch).attribute(switch) {
                Some("true") => true,
                Some("false") => false,
                _ => self.limits_by_range,
            };
            let is_there = element.has_attribute(range) && is_said;
            is_there.then(|| numbers::<2>(element, range, name, None)).transpose()
        };
        let angle = |value: f64| if self.in_degrees && !slides { value.to_radians() } else { value };
        let position = within("range", "limited")?.map(|range| range.map(angle));
        let effort = within("actuatorfrcrange", "actuatorfrclimited")?;
        Ok(Limits { position, velocity: None, effort: effort.map(|[least, most]| least.abs().max(most.abs())) })
    }

    /// The element that says an attribute of a joint: itself, or the nearest default of its class that does.
    fn holder(&self, joint: Element<'a, 'input>, class: &str, key: &str) -> Element<'a, 'input> {
        if joint.has_attribute(key) {
            return joint;
        }
        let defaults = || sections(self.root, "default").flat_map(|one| one.descendants());
        let named = |one: &Element| {
            let is_outermost = one.parent() == Some(self.root);
            one.has_tag_name("default")
                && (one.attribute("class").unwrap_or("main") == class || is_outermost && class == "main")
        };
        let mut next = defaults().find(named);
        while let Some(default) = next.filter(|one| one.has_tag_name("default")) {
            let own = default.children().find(|one| one.has_tag_name("joint") && one.has_attribute(key));
            match own {
                Some(own) => return own,
                None => next = default.parent(),
            }
        }
        joint
    }

    /// What a body weighs, in its own frame.
    fn inertial(&self, inertial: Element, name: &str) -> Result<Body, RobotError> {
        let [mass] = numbers(inertial, "mass", name, None)?;
        let moments = match inertial.has_attribute("fullinertia") {
            true => {
                let [xx, yy, zz, xy, xz, yz] = numbers(inertial, "fullinertia", name, None)?;
                Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz)
            }
            false => Matrix3::from_diagonal(&numbers(inertial, "diaginertia", name, None)?.into()),
        };
        let own = Body { mass, com: Vector3::zeros(), inertia: moments };
        Ok(own.seen_from(&self.pose(inertial, name)?.inverse()))
    }

    /// Where an element stands: `pos`, and whichever of the ways to say a rotation it uses.
    fn pose(&self, element: Element, name: &str) -> Result<Isometry3<f64>, RobotError> {
        let place = Vector3::from(numbers(element, "pos", name, Some([0.0; 3]))?);
        let angle = |value: f64| if self.in_degrees { value.to_radians() } else { value };
        let direction = |vector: Vector3<f64>, key: &str| {
            Unit::try_new(vector, 1e-12).ok_or_else(|| wrong(element, key, name, "no vector of length 0"))
        };
        let has = |key: &str| element.has_attribute(key);
        let turn = if has("quat") {
            let [w, x, y, z] = numbers(element, "quat", name, None)?;
            let quaternion = Unit::try_new(Quaternion::new(w, x, y, z), 1e-12);
            quaternion.ok_or_else(|| wrong(element, "quat", name, "no quaternion of length 0"))?
        } else if has("axisangle") {
            let [x, y, z, turned] = numbers(element, "axisangle", name, None)?;
            UnitQuaternion::from_axis_angle(&direction(Vector3::new(x, y, z), "axisangle")?, angle(turned))
        } else if has("euler") {
            self.euler(numbers::<3>(element, "euler", name, None)?.map(angle))
        } else if has("xyaxes") {
            let [a, b, c, d, e, f] = numbers(element, "xyaxes", name, None)?;
            let x = direction(Vector3::new(a, b, c), "xyaxes")?.into_inner();
            let across = Vector3::new(d, e, f);
            let y = direction(across - x * x.dot(&across), "xyaxes")?.into_inner();
            let turn = Rotation3::from_basis_unchecked(&[x, y, x.cross(&y)]);
            UnitQuaternion::from_rotation_matrix(&turn)
        } else if has("zaxis") {
            let z = direction(Vector3::from(numbers(element, "zaxis", name, None)?), "zaxis")?;
            super::along_z(&z).rotation
        } else {
            UnitQuaternion::identity()
        };
        Ok(Isometry3::from_parts(Translation3::from(place), turn))
    }

    fn euler(&self, angles: [f64; 3]) -> UnitQuaternion<f64> {
        self.order.chars().zip(angles).fold(UnitQuaternion::identity(), |turn, (letter, angle)| {
            let axis = match letter.to_ascii_lowercase() {
                'x' => Vector3::x_axis(),
                'y' => Vector3::y_axis(),
                _ => Vector3::z_axis(),
            };
            let next = UnitQuaternion::from_axis_angle(&axis, angle);
            if letter.is_ascii_lowercase() { turn * next } else { next * turn }
        })
    }
}
