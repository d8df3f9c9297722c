//! A chain of axes that is a planar arm: all parallel, gravity across them, the joints in one line at q = 0 and the centres of mass on
//! it. The closed form then says the same with fewer parameters, and what is known of planar arms (its drawing, a payload at the tip,
//! a link that leans) holds.

use std::f64::consts::FRAC_PI_2;

use nalgebra::{Matrix3, Rotation3, Vector3};

use super::chain::Chain;
use super::stated::Stated;
use super::{Arm, Link, Posture};

/// Directions within this angle \[rad\] of each other are the same: files have π/2 with five digits.
const SAME: f64 = 1e-5;
/// Points within this share of the length of a link are the same.
const SAME_PLACE: f64 = 1e-6;
/// What is left of an inertia about the centre of mass of a point.
const ROUNDING: f64 = 1e-12;

/// Why a chain of axes that turn is no planar arm. Joints are counted from 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum NotPlanar {
    /// The axes are not parallel.
    #[error("the axis of joint {} is not parallel to those before", .0 + 1)]
    Axis(usize),
    /// The arm has no weight in the plane in which it moves.
    #[error("gravity does not lie in the plane in which it moves")]
    Gravity,
    /// The joints are not in one line at q = 0.
    #[error("at q = 0 the link of joint {} does not go on in the line of those before", .0 + 1)]
    Bent(usize),
    /// A link's mass is beside the line of the joints.
    #[error("the centre of mass of what joint {} moves is beside the line of the joints", .0 + 1)]
    Beside(usize),
    /// The file does not say what a link weighs.
    #[error("it does not say what the link of joint {} weighs", .0 + 1)]
    Massless(usize),
    /// Its numbers can't be those of an arm.
    #[error("its masses or lengths are none that an arm can have")]
    Impossible,
}

impl NotPlanar {
    /// Whether its axes are those of a planar arm.
    pub fn is_nearly(self) -> bool {
        !matches!(self, NotPlanar::Axis(_) | NotPlanar::Gravity)
    }
}

impl Chain {
    /// The planar arm that it is, if it is one and states what every link weighs. All joints have to turn.
    ///
    /// Nothing but a frame that is fixed to the last link says where that ends; without one it ends as far behind its centre of mass
    /// as its joint is before, as a rod would.
    ///
    /// # Errors
    /// [`NotPlanar`] says why it is none.
    pub fn planar(&self) -> Result<Arm, NotPlanar> {
        let frames = self.frames();
        let first = Matrix3::from_fn(|row, column| frames[0].rotation[row][column]);
        let gravity = first.transpose() * Vector3::from(self.gravity);
        let size = gravity.norm();
        // The angle of each frame about the first axis at q = 0, and where the next joint stands in it.
        let mut turned = vec![0.0];
        let mut behind = Vec::new();
        for (number, frame) in frames.iter().enumerate().skip(1) {
            let rotation = Matrix3::from_fn(|row, column| frame.rotation[row][column]);
            if (rotation * Vector3::z() - Vector3::z()).norm() > SAME {
                return Err(NotPlanar::Axis(number));
            }
            let own = turned.last().copied().unwrap_or_default() + rotation[(1, 0)].atan2(rotation[(0, 0)]);
            turned.push(own);
            behind.push(Vector3::new(frame.offset[0], frame.offset[1], 0.0));
        }
        if !size.is_finite() || size == 0.0 || gravity.z.abs() > SAME * size {
            return Err(NotPlanar::Gravity);
        }
        let stated: Vec<Stated> = self.axes.iter().map(|axis| axis.stated.unwrap_or_default()).collect();
        let last = stated.last().copied().unwrap_or_default();
        let moment = |stated: &Stated| stated.link.map(|link| Vector3::new(link[1], link[2], 0.0));
        let along = behind.first().copied().or_else(|| moment(&last)).or_else(|| last.tip.map(Vector3::from));
        let along = along.ok_or(NotPlanar::Massless(0))?;
        let direction = along.y.atan2(along.x);
        let mut links = Vec::new();
        for (number, stated) in stated.iter().enumerate() {
            // Along the arm and across it.
            let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), turned[number] - direction);
            let aligned = |point: Vector3<f64>| {
                let point = turn * point;
                (point.x > 0.0 && point.y.abs() <= SAME * point.x).then_some(point.x)
            };
            let next = behind.get(number).map(|next| aligned(*next).ok_or(NotPlanar::Bent(number))).transpose()?;
            let link = stated.link.filter(|link| link[0] > 0.0).ok_or(NotPlanar::Massless(number))?;
            let (mass, about_joint) = (link[0], link[9]);
            let com = turn * Vector3::new(link[1], link[2], 0.0) / mass;
            let tip = stated.tip.map(|[x, y, _]| aligned(Vector3::new(x, y, 0.0)));
            let length = next.or(tip.flatten()).unwrap_or(2.0 * com.x.abs());
            if com.y.abs() > SAME_PLACE * length.max(com.x.abs()) {
                let is_bent = tip == Some(None);
                return Err(if is_bent { NotPlanar::Bent(number) } else { NotPlanar::Beside(number) });
            }
            let inertia = about_joint - mass * com.x * com.x;
            let inertia = if inertia.abs() < ROUNDING * about_joint { 0.0 } else { inertia };
            links.push(Link { mass, length, com: com.x, inertia });
        }
        let up = (-gravity.y).atan2(-gravity.x);
        let (sin, cos) = (direction - up + FRAC_PI_2).sin_cos();
        let zero_angle = sin.atan2(cos);
        let arm = Arm { links, gravity: size, posture: Posture { zero_angle, ..Posture::RIGHT } };
        if arm.check().is_ok() { Ok(arm) } else { Err(NotPlanar::Impossible) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arm::GRAVITY;
    use crate::arm::robot::SerialArm;
    use crate::arm::testing::{arm_and_state, close};
    use proptest::prelude::*;

    /// A planar arm as a URDF, in a plane that is turned about the vertical by `about`; a frame marks where it ends.
    fn urdf(arm: &Arm, about: f64, said: &str) -> String {
        let mut text = String::from("<robot name=\"planar\">");
        let (mut place, mut turn) = (0.0, format!("0 {} {about}", -arm.posture.zero_angle));
        let axis = if arm.posture.sign() > 0.0 { "0 -1 0" } else { "0 1 0" };
        for (number, link) in arm.links.iter().enumerate() {
            let Link { mass, com, inertia, length } = link;
            let before = number.checked_sub(1).map_or("base".to_owned(), |before| format!("l{before}"));
            text += &format!(
                "<joint name=\"j{number}\" type=\"revolute\"><origin xyz=\"{place} 0.1 0\" rpy=\"{turn}\"/><axis xyz=\"{axis}\"/>\
                 <parent link=\"{before}\"/><child link=\"l{number}\"/></joint><link name=\"l{number}\"><inertial><mass \
                 value=\"{mass}\"/><origin xyz=\"{com} 0 {said}\"/><inertia ixx=\"0.1\" iyy=\"{inertia}\" izz=\"0.1\"/></inertial></link>"
            );
            (place, turn) = (*length, "0 0 0".to_owned());
        }
        let last = arm.joint_count() - 1;
        text + &format!(
            "<joint name=\"end\" type=\"fixed\"><origin xyz=\"{place} 0 0\"/><parent link=\"l{last}\"/><child link=\"tool\"/></joint>\
             <link name=\"tool\"/></robot>"
        )
    }

    proptest! {
        /// Whatever plane it stands in, the file of a planar arm is that arm: links, posture and torque.
        #[test]
        fn the_file_of_a_planar_arm_is_that_arm((arm, state) in arm_and_state(), about in -3.0..3.0) {
            let arm = Arm { gravity: GRAVITY, ..arm };
            let file = SerialArm::parse(&urdf(&arm, about, "0")).unwrap();
            let found = file.chain().planar().unwrap();
            for (own, link) in found.links.iter().zip(&arm.links) {
                close(&[own.mass, own.length, own.com, own.inertia], &[link.mass, link.length, link.com, link.inertia], 1e-9)?;
            }
            let [q, qd, qdd] = &state;
            close(&found.inverse_dynamics(q, qd, qdd), &arm.inverse_dynamics(q, qd, qdd), 1e-9)?;
        }
    }

    #[test]
    fn what_is_not_planar_stays_in_space() {
        let two = Arm::uniform(2);
        let planar = |text: &str| SerialArm::parse(text).unwrap().chain().planar();
        let text = urdf(&two, 0.0, "0");
        assert!(planar(&text).is_ok());
        let changed = |from: &str, to: &str| {
            assert!(text.contains(from), "{from}");
            planar(&text.replacen(from, to, 1))
        };
        let of_another_direction = changed("<axis xyz=\"0 -1 0\"/>", "<axis xyz=\"0 0 1\"/>");
        assert_eq!(of_another_direction, Err(NotPlanar::Axis(1)));
        assert_eq!(changed("rpy=\"0 0 0\"", "rpy=\"0 0.2 0\""), Err(NotPlanar::Bent(1)));
        let turning_back = changed("rpy=\"0 0 0\"", "rpy=\"3.14159265358979 0 0\"");
        assert_eq!(turning_back, Err(NotPlanar::Axis(1)));
        assert_eq!(planar(&urdf(&two, 0.0, "0.01")), Err(NotPlanar::Beside(0)));
        assert_eq!(changed("<mass value=\"1\"/>", "<mass value=\"0\"/>"), Err(NotPlanar::Massless(0)));
        // A table that turns flat on the ground has no weight in its plane.
        let flat = planar(&text.replace("rpy=\"0 -0 0\"", "rpy=\"1.5707963267948966 0 0\""));
        assert_eq!(flat, Err(NotPlanar::Gravity));
        // Whoever gives such a file is told.
        let told = |text: &str| SerialArm::parse(text).unwrap().plane_told();
        let beside = told(&urdf(&two, 0.0, "0.01")).unwrap();
        assert!(
            beside.contains("what joint 1 moves is beside the line") && beside.contains("and stays one in space"),
            "{beside}"
        );
        assert_eq!(told(&text.replacen("<axis xyz=\"0 -1 0\"/>", "<axis xyz=\"0 0 1\"/>", 1)), None);
    }

    /// Without a frame at its end the last link is a rod.
    #[test]
    fn a_last_link_without_an_end_is_a_rod() {
        let mut arm = Arm::uniform(2);
        arm.links[1].com = 0.3;
        let text = urdf(&arm, 0.0, "0");
        let whole = SerialArm::parse(&text).unwrap().chain().planar().unwrap();
        assert!((whole.links[1].length - 1.0).abs() < 1e-12);
        let (before, _) = text.split_once("<joint name=\"end\"").unwrap();
        let cut = SerialArm::parse(&(before.to_owned() + "</robot>")).unwrap().chain().planar().unwrap();
        assert!((cut.links[1].length - 0.6).abs() < 1e-12);
    }
}
