//! What a model can be written as: the one list of it, for the command and the window.

use super::controller::Language;
use super::robot::Format;
use crate::model::Model;

/// What a model is written as.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// The code of a controller.
    Code(Language),
    /// Values in the robot's own file.
    Robot(Format),
    /// The weights of its network, with what computes the torque from them.
    Network,
}

/// All of them: the name in commands, what it is, and the kind.
pub const KINDS: [(&str, &str, Kind); 8] = [
    ("c", "C99: a header, a source and a test", Kind::Code(Language::C)),
    ("cpp", "C++11: a header with everything in it, and a test", Kind::Code(Language::Cpp)),
    ("python", "Python with NumPy, for one state or many", Kind::Code(Language::Python)),
    ("matlab", "MATLAB or Octave", Kind::Code(Language::Matlab)),
    ("ros2", "the parameters of a ROS 2 node (YAML)", Kind::Code(Language::Ros2)),
    ("urdf", "damping and friction, into the robot's URDF", Kind::Robot(Format::Urdf)),
    ("mjcf", "the same, armature and springs, into the robot's MJCF", Kind::Robot(Format::Mjcf)),
    (
        "network",
        "a trained network: weights (safetensors, NPZ), ONNX, and what computes its torque in NumPy",
        Kind::Network,
    ),
];

impl Kind {
    /// What it is called where there is little room.
    pub fn title(self) -> &'static str {
        match self {
            Kind::Code(Language::C) => "C",
            Kind::Code(Language::Cpp) => "C++",
            Kind::Code(Language::Python) => "Python",
            Kind::Code(Language::Matlab) => "MATLAB",
            Kind::Code(Language::Ros2) => "ROS 2",
            Kind::Robot(Format::Urdf) => "URDF",
            Kind::Robot(Format::Mjcf) => "MJCF",
            Kind::Network => "network weights",
        }
    }

    /// What it is, in a sentence without its end.
    pub fn about(self) -> &'static str {
        KINDS.iter().find(|(.., kind)| *kind == self).map_or("", |(_, about, _)| about)
    }

    /// How the file ends that is named for it, without the dot; empty for a folder.
    pub fn ending(self) -> &'static str {
        match self {
            Kind::Code(language) => language.ending(),
            Kind::Robot(Format::Urdf) => "urdf",
            Kind::Robot(Format::Mjcf) => "xml",
            Kind::Network => "",
        }
    }

    /// Whether a model can be written so: a network is no code, and only it has weights.
    pub fn suits(self, model: &Model) -> bool {
        match self {
            Kind::Code(_) => !model.is_learned(),
            Kind::Robot(_) => true,
            Kind::Network => model.is_learned(),
        }
    }
}
