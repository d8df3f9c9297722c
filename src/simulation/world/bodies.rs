//! The arm as rigid bodies: the one place that knows the engine, rapier2d in its f64 build.
//!
//! Links are bodies, revolute joints in reduced coordinates hold them together. The engine solves Newton's and Euler's
//! equations by itself; nothing of [`crate::arm`] is used but masses and lengths.

use nalgebra::Unit;
use rapier2d_f64::prelude::*;

use super::moment::{Moment, Planar, Rider};
use super::plan::{Freedom, Obstacle, Plan, RiderPlan, TIP_RADIUS, TipLoad};
use super::transmission::Transmission;

/// Inertia of a rider about its own centre, as a share of the least that the engine takes for more than a point.
const NEARLY_A_POINT: f64 = 1e-3;

/// The bodies and the engine that moves them.
pub(super) struct Bodies {
    engine: PhysicsWorld,
    base: RigidBodyHandle,
    links: Vec<RigidBodyHandle>,
    riders: Vec<(RigidBodyHandle, RiderPlan)>,
    tip: Option<ColliderHandle>,
    chain: MultibodyJointHandle,
    sense: f64,
    /// Mass of the last link by itself, and what is fixed to it from time to time.
    last: MassProperties,
    tip_place: Planar,
    tip_loads: Vec<TipLoad>,
    carried: Vec<bool>,
}

impl Bodies {
    /// Builds the arm of a plan at joint positions `q` \[rad\] and velocities `qd` \[rad/s\]. `None` if the engine can't hold it
    /// together, which no chain of joints brings about.
    pub(super) fn build(plan: &Plan, q: &[f64], qd: &[f64], step: f64) -> Option<Self> {
        let arm = &plan.arm;
        let sense = arm.posture.sign();
        let mut engine = PhysicsWorld::new();
        engine.gravity = Vector::new(0.0, -arm.gravity);
        engine.integration_parameters.dt = step;
        if plan.obstacles.is_empty() {
            // Iterations are for contacts; joints in reduced coordinates are exact without.
            engine.integration_parameters.num_solver_iterations = 1;
        }
        let base_angle = arm.posture.zero_angle + plan.tilt;
        let base = engine.insert_body(RigidBodyBuilder::fixed().rotation(base_angle));

        let (mut links, mut joints) = (Vec::new(), Vec::new());
        let (mut parent, mut anchor) = (base, Vector::ZERO);
        for (link, beside) in arm.links.iter().zip(&plan.beside) {
            let mass = MassProperties::new(Vector::new(link.com, *beside), link.mass, link.inertia);
            let body = insert(&mut engine, mass);
            let joint = RevoluteJointBuilder::new().local_anchor1(anchor).local_anchor2(Vector::ZERO);
            joints.push(engine.insert_multibody_joint(parent, body, joint)?);
            links.push(body);
            (parent, anchor) = (body, Vector::new(link.length, 0.0));
        }
        let mut riders = Vec::new();
        for rider in &plan.riders {
            let (body, joint) = mount(&mut engine, links[rider.link], rider)?;
            riders.push((body, *rider));
            joints.push(joint);
        }
        let tip = parent;
        let tip = (!plan.obstacles.is_empty()).then(|| add_contact(&mut engine, tip, anchor, &plan.obstacles));

        let chain = *joints.first()?;
        let (multibody, _) = engine.multibody_joints.get_mut(chain)?;
        // The engine learns here that the base is fixed.
        multibody.forward_kinematics(&engine.bodies, true);
        multibody.damping_mut().fill(0.0);
        let mut place: Vec<f64> = q.iter().map(|q| sense * q).collect();
        let last_angle = base_angle + place.iter().sum::<f64>();
        for (number, rider) in plan.riders.iter().enumerate() {
            let (damping, start) = match rider.freedom {
                Freedom::Swings { damping, .. } => (damping, -std::f64::consts::FRAC_PI_2 - last_angle),
                Freedom::Slides { damping, .. } => (damping, 0.0),
            };
            multibody.damping_mut()[q.len() + number] = damping;
            place.push(start);
        }
        for (joint, drive) in plan.joints.iter().enumerate() {
            if let Transmission::Stiff { inertia } = drive.transmission {
                multibody.armature_mut()[joint] = inertia;
            }
        }
        multibody.apply_displacements(&place);
        for (velocity, qd) in multibody.generalized_velocity_mut().iter_mut().zip(qd) {
            *velocity = sense * qd;
        }
        multibody.forward_kinematics(&engine.bodies, true);
        multibody.update_rigid_bodies(&mut engine.bodies, true);

        let end = arm.links.last()?;
        let beside = plan.beside.last().copied().unwrap_or_default();
        Some(Bodies {
            engine,
            base,
            links,
            riders,
            tip,
            chain,
            sense,
            last: MassProperties::new(Vector::new(end.com, beside), end.mass, end.inertia),
            tip_place: [end.length, 0.0],
            tip_loads: plan.tip_loads.clone(),
            carried: vec![false; plan.tip_loads.len()],
        })
    }

    /// Reads position, velocity and acceleration of the joints, and what riders and contacts do. Accelerations are the change of
    /// velocity in the last step.
    pub(super) fn read(&self, now: &mut Moment) {
        if let Some((multibody, _)) = self.engine.multibody_joints.get(self.chain) {
            let velocities = multibody.generalized_velocity();
            let angles = multibody.links().skip(1).map(|link| link.joint().coords()[2]);
            for (joint, angle) in angles.take(self.links.len()).enumerate() {
                let velocity = self.sense * velocities[joint];
                now.qdd[joint] = (velocity - now.qd[joint]) / now.step;
                now.qd[joint] = velocity;
                now.q[joint] = self.sense * angle;
            }
        }
        now.place_links();
        now.riders.resize(self.riders.len(), Rider::default());
        for (rider, (body, _)) in now.riders.iter_mut().zip(&self.riders) {
            let body = &self.engine.bodies[*body];
            let (at, velocity) = (planar(body.center_of_mass()), planar(body.linvel()));
            let rate = |axis: usize| (velocity[axis] - rider.velocity[axis]) / now.step;
            *rider = Rider { at, velocity, acceleration: [rate(0), rate(1)] };
        }
        self.read_touches(now);
    }

    fn read_touches(&self, now: &mut Moment) {
        now.touches.clear();
        let Some(tip) = self.tip else { return };
        for pair in self.engine.contact_pairs_with(tip) {
            // Normals point from the first collider to the second.
            let towards = if pair.collider2 == tip { 1.0 } else { -1.0 };
            for manifold in pair.solver_manifolds() {
                let normal = planar(manifold.data.normal);
                for point in &manifold.points {
                    let [press, rub] =
                        [point.data.impulse, point.data.tangent_impulse[0]].map(|p| towards * p / now.step);
                    let force = [normal[0] * press - normal[1] * rub, normal[1] * press + normal[0] * rub];
                    let state = &now.links[self.links.len() - 1];
                    now.touches.push((self.links.len() - 1, state.point(self.tip_place).at, force));
                }
            }
        }
    }

    /// Takes up and puts down what is at the tip only for a time.
    pub(super) fn take_up(&mut self, time: f64) {
        let carried: Vec<bool> = self.tip_loads.iter().map(|load| load.is_carried(time)).collect();
        if carried != self.carried
            && let Some(link) = self.links.last()
        {
            let tip = Vector::new(self.tip_place[0], self.tip_place[1]);
            let loads = self.tip_loads.iter().zip(&carried).filter(|(_, carried)| **carried);
            let mass = loads.fold(self.last, |mass, (load, _)| mass + MassProperties::new(tip, load.mass, 0.0));
            self.engine.bodies[*link].set_additional_mass_properties(mass, true);
            self.carried = carried;
        }
    }

    /// Moves everything for a step under torques of the joints \[N m\] and forces on links.
    pub(super) fn step<'a>(&mut self, torques: &[f64], pushes: impl Iterator<Item = &'a (usize, Planar, Planar)>) {
        for (_, body) in self.engine.bodies.iter_mut() {
            body.reset_forces(false);
            body.reset_torques(false);
        }
        let mut before = self.base;
        for (link, torque) in self.links.iter().zip(torques) {
            self.engine.bodies[*link].add_torque(self.sense * torque, true);
            self.engine.bodies[before].add_torque(-self.sense * torque, true);
            before = *link;
        }
        for (link, at, force) in pushes {
            let [at, force] = [at, force].map(|[x, z]| Vector::new(*x, *z));
            self.engine.bodies[self.links[*link]].add_force_at_point(force, at, true);
        }
        self.pull_springs();
        self.engine.step();
    }

    /// Springs of riders that slide.
    fn pull_springs(&mut self) {
        for (number, (body, rider)) in self.riders.iter().enumerate() {
            let Freedom::Slides { stiffness, .. } = rider.freedom else { continue };
            let Some((multibody, _)) = self.engine.multibody_joints.get(self.chain) else { continue };
            let slid = multibody.link(1 + self.links.len() + number).map_or(0.0, |link| link.joint().coords()[0]);
            let link = self.links[rider.link];
            let axis = self.engine.bodies[link].rotation().transform_vector(Vector::X);
            let (pull, at) = (axis * (-stiffness * slid), self.engine.bodies[*body].center_of_mass());
            self.engine.bodies[*body].add_force_at_point(pull, at, true);
            self.engine.bodies[link].add_force_at_point(-pull, at, true);
        }
    }
}

fn insert(engine: &mut PhysicsWorld, mass: MassProperties) -> RigidBodyHandle {
    let body = engine.insert_body(RigidBodyBuilder::dynamic().can_sleep(false).additional_mass_properties(mass));
    engine.bodies[body].recompute_mass_properties_from_colliders(&engine.colliders);
    body
}

fn mount(
    engine: &mut PhysicsWorld,
    link: RigidBodyHandle,
    rider: &RiderPlan,
) -> Option<(RigidBodyHandle, MultibodyJointHandle)> {
    let place = Vector::new(rider.place[0], rider.place[1]);
    let (body, joint): (_, GenericJoint) = match rider.freedom {
        Freedom::Swings { length, .. } => {
            let inertia = NEARLY_A_POINT * rider.mass * length * length;
            let mass = MassProperties::new(Vector::new(length, 0.0), rider.mass, inertia);
            (insert(engine, mass), RevoluteJointBuilder::new().local_anchor1(place).into())
        }
        Freedom::Slides { .. } => {
            let mass = MassProperties::new(Vector::ZERO, rider.mass, NEARLY_A_POINT * rider.mass);
            (insert(engine, mass), PrismaticJointBuilder::new(Vector::X).local_anchor1(place).into())
        }
    };
    Some((body, engine.insert_multibody_joint(link, body, joint)?))
}

/// A ball around the tip, and what it may touch.
fn add_contact(
    engine: &mut PhysicsWorld,
    last: RigidBodyHandle,
    tip: Vector,
    obstacles: &[Obstacle],
) -> ColliderHandle {
    for obstacle in obstacles {
        let normal = Unit::new_unchecked(Vector::new(obstacle.normal[0], obstacle.normal[1]));
        let place = Vector::new(obstacle.at[0], obstacle.at[1]);
        engine.insert_collider(ColliderBuilder::halfspace(normal).translation(place).friction(0.3), None);
    }
    let ball = ColliderBuilder::ball(TIP_RADIUS).translation(tip).density(0.0).friction(0.3);
    engine.insert_collider(ball, Some(last))
}

fn planar(vector: Vector) -> Planar {
    [vector.x, vector.y]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arm::{Arm, Posture};

    /// The same arm held together by impulses: the engine's other kind of joint. Gives the error of the first accelerations
    /// relative to the largest, and how far the joints have come apart after a fall of 0.3 s \[m\].
    fn by_impulses(arm: &Arm, [q, qd, tau]: &[Vec<f64>; 3], step: f64, expected: &[f64]) -> (f64, f64) {
        let mut engine = PhysicsWorld::new();
        engine.integration_parameters.dt = step;
        let mut before = engine.insert_body(RigidBodyBuilder::fixed());
        let (mut angle, mut spin, mut anchor, mut joint_velocity) = (0.0, 0.0, Vector::ZERO, Vector::ZERO);
        let mut place = Vector::ZERO;
        let mut bodies = vec![before];
        for (number, link) in arm.links.iter().enumerate() {
            angle += q[number];
            spin += qd[number];
            let mass = MassProperties::new(Vector::new(link.com, 0.0), link.mass, link.inertia);
            let axis = Vector::new(angle.cos(), angle.sin());
            let across = Vector::new(-axis.y, axis.x);
            let body = RigidBodyBuilder::dynamic()
                .can_sleep(false)
                .additional_mass_properties(mass)
                .translation(place)
                .rotation(angle)
                .linvel(joint_velocity + across * (spin * link.com))
                .angvel(spin);
            let body = engine.insert_body(body);
            engine.insert_impulse_joint(before, body, RevoluteJointBuilder::new().local_anchor1(anchor));
            place += axis * link.length;
            joint_velocity += across * (spin * link.length);
            anchor = Vector::new(link.length, 0.0);
            before = body;
            bodies.push(body);
        }
        let mut step_once = |tau: &[f64]| {
            for (number, tau) in tau.iter().enumerate() {
                for (body, sign) in [(bodies[number + 1], 1.0), (bodies[number], -1.0)] {
                    engine.bodies[body].add_torque(sign * tau, true);
                }
            }
            engine.step();
            for body in &bodies {
                engine.bodies[*body].reset_torques(true);
            }
            let spins: Vec<f64> = bodies.iter().map(|body| engine.bodies[*body].angvel()).collect();
            let gap = |pair: usize| {
                let [inner, outer] = [bodies[pair], bodies[pair + 1]].map(|body| *engine.bodies[body].position());
                let end = if pair == 0 { 0.0 } else { arm.links[pair - 1].length };
                (inner.transform_point(Vector::new(end, 0.0)) - outer.translation).length()
            };
            (spins, (0..arm.joint_count()).map(gap).fold(0.0, f64::max))
        };
        let (spins, _) = step_once(tau);
        let largest = expected.iter().fold(0.0, |most: f64, value| most.max(value.abs()));
        let error = |joint: usize| ((spins[joint + 1] - spins[joint] - qd[joint]) / step - expected[joint]).abs();
        let error = (0..arm.joint_count()).map(error).fold(0.0, f64::max) / largest;
        let mut gap = 0.0;
        for _ in 0..(0.3 / step) as usize {
            gap = step_once(&vec![0.0; tau.len()]).1;
        }
        (error, gap)
    }

    /// Why joints are in reduced coordinates: impulses leave a larger error in the accelerations, and let the joints come apart.
    #[test]
    fn reduced_coordinates_agree_better_than_impulses() {
        let arm = Arm { posture: Posture::RIGHT, ..Arm::uniform(3) };
        let state = [vec![0.4, -0.7, 1.1], vec![1.5, -2.0, 1.0], vec![20.0, 8.0, -3.0]];
        let expected = arm.forward_dynamics(&state[0], &state[1], &state[2]).unwrap_or_default();
        let step = 1e-4;
        let (by_impulses, gap) = by_impulses(&arm, &state, step, &expected);
        let mut bodies = Bodies::build(&Plan::bare(&arm), &state[0], &state[1], step).expect("a chain of joints");
        let mut now = Moment::new(&arm, 0.0, step);
        bodies.read(&mut now);
        bodies.step(&state[2], [].iter());
        bodies.read(&mut now);
        let largest = expected.iter().fold(0.0, |most: f64, value| most.max(value.abs()));
        let reduced = (0..3).map(|joint| (now.qdd[joint] - expected[joint]).abs()).fold(0.0, f64::max) / largest;
        // Measured: 1.2e-4 and 3.3e-2; the joints come apart by 4e-9 m.
        assert!(reduced < 0.1 * by_impulses && gap > 1e-12, "{reduced} and {by_impulses}, {gap} m");
    }
}
