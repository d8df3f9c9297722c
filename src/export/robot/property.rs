//! What a robot's file can say of a joint.

use super::Format;
use crate::model::property::Property;

impl Property {
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
