//! What the parts of a world see of it at one moment, and the forces with which they answer.
//!
//! Points and forces are \[x, z\] in the plane of the arm, base at \[0, 0\], z up.

use crate::arm::Arm;

/// A point, a velocity, an acceleration or a force in the plane: \[x, z\].
pub(super) type Planar = [f64; 2];

/// The world at the beginning of a step.
#[derive(Debug, Clone)]
pub(super) struct Moment {
    /// Since the run began \[s\]; below 0 while the arm is held still before it.
    pub(super) time: f64,
    /// Until the next moment \[s\].
    pub(super) step: f64,
    /// Joint position \[rad\].
    pub(super) q: Vec<f64>,
    /// Joint velocity \[rad/s\].
    pub(super) qd: Vec<f64>,
    /// Joint acceleration during the last step \[rad/s²\].
    pub(super) qdd: Vec<f64>,
    /// What the drives sent through the joints in the last step \[N m\].
    pub(super) sent: Vec<f64>,
    /// Where the links are.
    pub(super) links: Vec<LinkState>,
    /// Bodies that hang from the arm or slide on it, in the order of the plan.
    pub(super) riders: Vec<Rider>,
    /// Forces with which something outside touched the links in the last step: link, place, force.
    pub(super) touches: Vec<(usize, Planar, Planar)>,
    gravity: f64,
    sense: f64,
    base_angle: f64,
    lengths: Vec<f64>,
}

/// A link as a moving frame whose x axis points along the link.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct LinkState {
    joint: Planar,
    velocity: Planar,
    acceleration: Planar,
    axis: Planar,
    spin: f64,
    spin_rate: f64,
}

/// A body that the arm carries: where it is and how it moves.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Rider {
    /// Its centre of mass \[m\].
    pub(super) at: Planar,
    /// \[m/s\]
    pub(super) velocity: Planar,
    /// \[m/s²\]
    pub(super) acceleration: Planar,
}

/// A point of a link.
pub(super) struct Point {
    /// \[m\]
    pub(super) at: Planar,
    /// \[m/s\]
    pub(super) velocity: Planar,
    /// \[m/s²\]
    pub(super) acceleration: Planar,
}

impl Moment {
    /// An arm at rest at q = 0 whose base leans by `tilt` \[rad\].
    pub(super) fn new(arm: &Arm, tilt: f64, step: f64) -> Self {
        let joints = arm.joint_count();
        let zero = || vec![0.0; joints];
        let mut moment = Moment {
            time: 0.0,
            step,
            q: zero(),
            qd: zero(),
            qdd: zero(),
            sent: zero(),
            links: vec![LinkState::default(); joints],
            riders: Vec::new(),
            touches: Vec::new(),
            gravity: arm.gravity,
            sense: arm.posture.sign(),
            base_angle: arm.posture.zero_angle + tilt,
            lengths: arm.links.iter().map(|link| link.length).collect(),
        };
        moment.place_links();
        moment
    }

    /// Places the links where position, velocity and acceleration of the joints put them.
    pub(super) fn place_links(&mut self) {
        let mut frame = LinkState { axis: [1.0, 0.0], ..LinkState::default() };
        let mut angle = self.base_angle;
        for joint in 0..self.q.len() {
            angle += self.sense * self.q[joint];
            frame.spin += self.sense * self.qd[joint];
            frame.spin_rate += self.sense * self.qdd[joint];
            frame.axis = [angle.cos(), angle.sin()];
            self.links[joint] = frame;
            let end = frame.point([self.lengths[joint], 0.0]);
            (frame.joint, frame.velocity, frame.acceleration) = (end.at, end.velocity, end.acceleration);
        }
    }

    /// The end of the last link.
    pub(super) fn tip(&self) -> Planar {
        [self.lengths.last().copied().unwrap_or_default(), 0.0]
    }

    /// The force that a mass \[kg\] needs where gravity pulls it and it is accelerated so \[N\].
    pub(super) fn need(&self, mass: f64, acceleration: Planar) -> Planar {
        [mass * acceleration[0], mass * (acceleration[1] + self.gravity)]
    }

    /// The weight's counterforce \[N\] of a mass \[kg\] that rests.
    pub(super) fn weight(&self, mass: f64) -> Planar {
        self.need(mass, [0.0, 0.0])
    }

    /// The torque of a force at a place about a joint, in the joint's sense \[N m\].
    pub(super) fn lever(&self, joint: usize, at: Planar, force: Planar) -> f64 {
        let pivot = self.links[joint].joint;
        self.sense * cross([at[0] - pivot[0], at[1] - pivot[1]], force)
    }
}

impl LinkState {
    /// A point that is fixed in the link, given along and beside its line \[m\].
    pub(super) fn point(&self, local: Planar) -> Point {
        let arm = turn(self.axis, local);
        let across = [-arm[1], arm[0]];
        let (spin, rate) = (self.spin, self.spin_rate);
        Point {
            at: [self.joint[0] + arm[0], self.joint[1] + arm[1]],
            velocity: [self.velocity[0] + spin * across[0], self.velocity[1] + spin * across[1]],
            acceleration: [
                self.acceleration[0] + rate * across[0] - spin * spin * arm[0],
                self.acceleration[1] + rate * across[1] - spin * spin * arm[1],
            ],
        }
    }

    /// Unit vector along the link.
    pub(super) fn axis(&self) -> Planar {
        self.axis
    }
}

/// What one part does in one step, and what all do together.
#[derive(Debug, Clone, Default)]
pub(super) struct Forces {
    /// Torque that acts against the drive, by joint \[N m\].
    pub(super) resisting: Vec<f64>,
    /// Forces on links: link, place, force.
    pub(super) pushes: Vec<(usize, Planar, Planar)>,
    /// Torque that the drives need for something that moves by itself already, by joint \[N m\].
    noted: Vec<f64>,
}

impl Forces {
    pub(super) fn none(joints: usize) -> Self {
        Forces { resisting: vec![0.0; joints], pushes: Vec::new(), noted: vec![0.0; joints] }
    }

    pub(super) fn clear(&mut self) {
        self.resisting.fill(0.0);
        self.noted.fill(0.0);
        self.pushes.clear();
    }

    /// Acts against the drive of a joint, and back on the link before it.
    pub(super) fn resist(&mut self, joint: usize, torque: f64) {
        self.resisting[joint] += torque;
    }

    /// Pushes a link from outside.
    pub(super) fn push(&mut self, link: usize, at: Planar, force: Planar) {
        self.pushes.push((link, at, force));
    }

    /// Counts the force that a link passes on to something that it carries, whose motion has it already.
    pub(super) fn carry(&mut self, now: &Moment, link: usize, at: Planar, force: Planar) {
        for joint in 0..=link {
            self.noted[joint] += now.lever(joint, at, force);
        }
    }

    /// Counts a torque that a drive needs for something whose motion has it already.
    pub(super) fn note(&mut self, joint: usize, torque: f64) {
        self.noted[joint] += torque;
    }

    /// What the drive of each joint needs because of all this \[N m\].
    pub(super) fn needed(&self, now: &Moment, joint: usize) -> f64 {
        let pushed = self.pushes.iter().filter(|(link, ..)| *link >= joint);
        let helping: f64 = pushed.map(|(_, at, force)| now.lever(joint, *at, *force)).sum();
        self.resisting[joint] + self.noted[joint] - helping
    }
}

/// A vector given along and across an axis.
pub(super) fn turn(axis: Planar, local: Planar) -> Planar {
    [axis[0] * local[0] - axis[1] * local[1], axis[1] * local[0] + axis[0] * local[1]]
}

/// The moment of `force` at `arm`, counter-clockwise.
fn cross(arm: Planar, force: Planar) -> f64 {
    arm[0] * force[1] - arm[1] * force[0]
}
