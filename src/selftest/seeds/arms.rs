//! An arm, in each form in which it is read.

/// Two links, as this program writes them.
pub const ARM: &str = r#"{"links": [
  {"mass": 4.2, "length": 0.4, "com": 0.17, "inertia": 0.06},
  {"mass": 2.6, "length": 0.34, "com": 0.15, "inertia": 0.028}
], "gravity": 9.81}"#;

/// Two joints on a base, as a URDF.
pub const URDF: &str = r#"<robot name="two">
  <link name="base"/>
  <link name="upper"><inertial><origin xyz="0.2 0 0" rpy="0 0 0.1"/><mass value="4.2"/>
    <inertia ixx="0.01" iyy="0.06" izz="0.06" ixy="0" ixz="0.001" iyz="0"/></inertial></link>
  <link name="lower"><inertial><mass value="2.6"/>
    <inertia ixx="0.01" iyy="0.03" izz="0.03" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/><axis xyz="0 1 0"/>
    <limit lower="-2" upper="2" effort="80" velocity="3"/><dynamics damping="0.3" friction="0.1"/></joint>
  <joint name="elbow" type="continuous"><parent link="upper"/><child link="lower"/><origin xyz="0.4 0 0" rpy="0 0 0"/>
    <axis xyz="0 1 0"/></joint>
</robot>"#;
/// The same, as an MJCF.
pub const MJCF: &str = r#"<mujoco model="two">
  <compiler angle="radian"/>
  <default><joint damping="0.3" armature="0.02"/><default class="elbow"><joint frictionloss="0.1"/></default></default>
  <worldbody><body name="upper"><joint name="shoulder" axis="0 1 0"/>
    <inertial pos="0.2 0 0" mass="4.2" diaginertia="0.01 0.06 0.06"/>
    <body name="lower" pos="0.4 0 0"><joint name="elbow" class="elbow" axis="0 1 0"/>
      <inertial pos="0.15 0 0" mass="2.6" fullinertia="0.01 0.03 0.03 0 0.001 0"/></body></body></worldbody>
</mujoco>"#;
