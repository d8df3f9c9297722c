//! The parameters of a model for a ROS 2 node. A node that computes the torque of each effect by its formula reads them.

use super::Sheet;
use super::language::number;
use crate::arm::regressor::parameter_names;
use crate::arm::stated::{Resistance, StatedArm};
use crate::model::{RigidBody, Term};

/// The parameter file (YAML), for a node of any name.
pub(super) fn parameters(sheet: &Sheet, remarks: &[String]) -> String {
    let mut lines: Vec<String> = remarks.iter().map(|line| format!("# {line}")).collect();
    let setting = sheet.kept.setting();
    let joints: Vec<String> = (1..=sheet.joints()).map(|joint| format!("\"joint_{joint}\"")).collect();
    lines.push("/**:".to_owned());
    lines.push("  ros__parameters:".to_owned());
    lines.push(format!("    {}:", sheet.name));
    let mut entry = |depth: usize, key: &str, value: &str| {
        let space = if value.is_empty() { "" } else { " " };
        lines.push(format!("{}{key}:{space}{value}", "  ".repeat(3 + depth)));
    };
    entry(0, "joints", &format!("[{}]", joints.join(", ")));
    entry(0, "reversal_widths", &list(&setting.reversal_widths));
    entry(0, "rigid_body", "");
    entry(1, "gravity", &number(setting.gravity()));
    entry(1, "zero_angle", &number(setting.posture.zero_angle));
    entry(1, "sense", &number(setting.posture.sign()));
    for (number_of_term, term) in sheet.kept.model.terms.iter().enumerate() {
        if let Term::RigidBody(body) = term {
            let (names, values) = body_parameters(sheet, body, number_of_term);
            entry(1, "names", &format!("[{}]", names.join(", ")));
            entry(1, "values", &list(&values));
        }
    }
    for term in &sheet.kept.model.terms {
        let Term::Resistance(joints) = term else { continue };
        let values = |of: fn(&Resistance) -> f64| list(&joints.iter().map(of).collect::<Vec<_>>());
        entry(0, "stated_resistance", "");
        entry(1, "rotor_inertia", &values(|joint| joint.rotor_inertia));
        entry(1, "damping", &values(|joint| joint.damping));
        entry(1, "friction", &values(|joint| joint.friction));
        entry(1, "stiffness", &values(|joint| joint.stiffness));
        entry(1, "preload", &values(|joint| joint.preload));
    }
    entry(0, "effects", "");
    for (number_of_term, term) in sheet.kept.model.terms.iter().enumerate() {
        let Term::Effect(placed) = term else { continue };
        let at = placed.joint.map_or("arm".to_owned(), |joint| format!("joint_{}", joint + 1));
        // A key must not stand twice: joint and effect are one.
        entry(1, &format!("{}_{at}", placed.effect.id.replace('-', "_")), "");
        entry(2, "formula", &format!("\"{}\"", placed.effect.formula));
        let values = sheet.kept.linear_of(number_of_term);
        let all = values.into_iter().chain(sheet.kept.shapes()[number_of_term].iter().copied());
        for (spec, value) in placed.effect.parameters.iter().zip(all) {
            entry(2, spec.name, &number(value));
        }
    }
    lines.join("\n") + "\n"
}

/// Names and values of the body's parameters.
fn body_parameters(sheet: &Sheet, body: &RigidBody, term: usize) -> (Vec<String>, Vec<f64>) {
    match body {
        RigidBody::Identified => {
            let own = sheet.kept.parameters_of(term);
            let names = own.map(|parameter| format!("\"{}\"", parameter.name)).collect();
            (names, sheet.kept.linear_of(term))
        }
        RigidBody::Stated(arm) => {
            let names = match arm {
                StatedArm::Planar(arm) => parameter_names(arm.joint_count()),
                StatedArm::Spatial(chain) => chain.parameter_names(),
            };
            (names.iter().map(|name| format!("\"{name}\"")).collect(), arm.parameters())
        }
    }
}

fn list(values: &[f64]) -> String {
    let values: Vec<String> = values.iter().map(|value| number(*value)).collect();
    format!("[{}]", values.join(", "))
}
