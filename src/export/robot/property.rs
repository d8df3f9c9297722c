//! What a robot's file can say of a joint.

use super::Format;
use crate::arm::stated::Resistance;
use crate::effect::Dimension;
use crate::model::property::Property;

/// What is stated to resist a joint, by property; 0 is nothing.
pub(super) fn stated(resistance: &Resistance) -> [(Property, f64); 5] {
    let Resistance { rotor_inertia, damping, friction, stiffness, preload } = *resistance;
    [
        (Property::Damping, damping),
        (Property::Friction, friction),
        (Property::Armature, rotor_inertia),
        (Property::Stiffness, stiffness),
        (Property::Preload, preload),
    ]
}

impl Property {
    /// What it is called.
    pub(super) fn name(self) -> &'static str {
        match self {
            Property::Damping => "damping",
            Property::Friction => "dry friction",
            Property::Armature => "rotor inertia",
            Property::Stiffness => "spring stiffness",
            Property::Preload => "torque of the spring at q = 0",
        }
    }

    /// What it is counted in.
    pub(super) fn dimension(self) -> Dimension {
        match self {
            Property::Damping => Dimension::Damping,
            Property::Friction | Property::Preload => Dimension::Torque,
            Property::Armature => Dimension::Inertia,
            Property::Stiffness => Dimension::Stiffness,
        }
    }

    /// Whether the format has a word for it; a constant torque needs a spring.
    pub(super) fn is_held(self, format: Format, has_spring: bool) -> bool {
        self.attribute(format).is_some() && (self != Property::Preload || has_spring)
    }

    /// Its name in the file.
    pub(super) fn attribute(self, format: Format) -> Option<&'static str> {
        match (format, self) {
            (_, Property::Damping) => Some("damping"),
            (Format::Urdf, Property::Friction) => Some("friction"),
            (Format::Urdf, _) => None,
            (Format::Mjcf, Property::Friction) => Some("frictionloss"),
            (Format::Mjcf, Property::Armature) => Some("armature"),
            (Format::Mjcf, Property::Stiffness) => Some("stiffness"),
            (Format::Mjcf, Property::Preload) => Some("springref"),
        }
    }
}
