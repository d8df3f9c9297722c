use clap::Args;
use serde::Serialize;

use super::data::OwnEffects;
use super::failure::OrUsage;
use super::table::{number, table};
use crate::effect::{Axis, Effect, ParameterSpec, Remedy, Role, Scope, Stage, Starts, registry};
use crate::recording::JointKind;

/// List the physical effects that the program knows, or tell all about one.
#[derive(Args)]
#[command(after_help = "Examples:
  torquescope effects
  torquescope effects stribeck-friction
  torquescope effects --json
  torquescope effects own-stribeck --effect-file examples/own_stribeck.toml")]
pub struct Effects {
    /// Id of one effect.
    #[arg(value_name = "EFFECT")]
    id: Option<String>,
    /// Print the result as JSON.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    own: OwnEffects,
}

/// An effect, as JSON.
#[derive(Serialize)]
struct Answer {
    id: &'static str,
    name: &'static str,
    formula: &'static str,
    tex: &'static str,
    description: &'static str,
    fingerprint: &'static str,
    absorbed: &'static str,
    look_alikes: Vec<LookAlike>,
    /// Ids of effects that it contains.
    includes: &'static [&'static str],
    source: &'static str,
    /// Where it acts: body, drive, reading; a faulty reading is left out of every fit.
    stage: &'static str,
    /// What it acts on: a joint, a pair of joints, the arm.
    scope: &'static str,
    /// The state over which its residual shows best.
    axis: Axis,
    parameters: Vec<Parameter>,
}

#[derive(Serialize)]
struct LookAlike {
    effects: &'static [&'static str],
    told_by: &'static str,
}

#[derive(Serialize)]
struct Parameter {
    name: &'static str,
    symbol: &'static str,
    /// SI unit on a revolute joint.
    unit: &'static str,
    /// SI unit on a sliding joint.
    unit_prismatic: &'static str,
    /// `None` where there is no bound.
    min: Option<f64>,
    max: Option<f64>,
    /// How it enters the torque: linear, shape, or read off faulty readings.
    role: &'static str,
    /// Where the search of a shape begins.
    start_values: &'static [f64],
}

impl Effects {
    /// Prints the catalogue, or one effect of it.
    pub fn run(&self) -> anyhow::Result<()> {
        let own = self.own.session()?.own_effects;
        let Some(id) = &self.id else { return self.print_all(&own) };
        let effect = registry::find(id).or_usage()?;
        if self.json {
            println!("{}", serde_json::to_string_pretty(&Answer::of(effect))?);
        } else {
            println!("{}", text(effect));
        }
        Ok(())
    }

    fn print_all(&self, own: &[&'static Effect]) -> anyhow::Result<()> {
        let effects = registry::ALL.iter().chain(own).copied();
        if self.json {
            println!("{}", serde_json::to_string_pretty(&effects.map(Answer::of).collect::<Vec<_>>())?);
            return Ok(());
        }
        let row = |effect: &'static Effect| {
            [effect.id, stage(effect), scope(effect), effect.formula].map(str::to_owned).to_vec()
        };
        let rows: Vec<Vec<String>> = effects.map(row).collect();
        println!("{}", table(&["effect", " stage", " acts on", " torque"], &rows));
        println!("\nMore about one of them: torquescope effects EFFECT");
        Ok(())
    }
}

impl Answer {
    fn of(effect: &'static Effect) -> Self {
        let look_alike =
            |others: &crate::effect::LookAlike| LookAlike { effects: others.effects, told_by: others.told_by };
        Answer {
            id: effect.id,
            name: effect.name,
            formula: effect.formula,
            tex: effect.typeset,
            description: effect.description,
            fingerprint: effect.fingerprint,
            absorbed: effect.absorbed,
            look_alikes: effect.facts.look_alikes.iter().map(look_alike).collect(),
            includes: effect.facts.includes,
            source: effect.source,
            stage: stage(effect),
            scope: scope(effect),
            axis: effect.axis,
            parameters: effect.parameters.iter().map(Parameter::of).collect(),
        }
    }
}

impl Parameter {
    fn of(spec: &'static ParameterSpec) -> Self {
        let (role, start_values): (_, &[f64]) = match spec.role {
            Role::Linear => ("linear", &[]),
            Role::Shape { starts: Starts::Values(values), .. } => ("shape", values),
            Role::Shape { starts: Starts::Places(shares), .. } => (PLACE, shares),
            Role::Shape { starts: Starts::Waves, .. } => {
                ("wave number, sought from one and a half periods over the joint's way on", &[])
            }
            Role::Reading => ("reading", &[]),
        };
        let bound = |value: f64| value.is_finite().then_some(value);
        Parameter {
            name: spec.name,
            symbol: spec.symbol,
            unit: spec.dimension.unit(JointKind::Revolute),
            unit_prismatic: spec.dimension.unit(JointKind::Prismatic),
            min: bound(spec.min),
            max: bound(spec.max),
            role,
            start_values,
        }
    }
}

fn scope(effect: &Effect) -> &'static str {
    match effect.scope {
        Scope::Joint => "joint",
        Scope::Pair => "pair of joints",
        Scope::Arm => "arm",
    }
}

/// Where in the chain it acts: see [`Stage`].
fn stage(effect: &Effect) -> &'static str {
    match effect.stage {
        Stage::Body(_) => "body",
        Stage::Drive(_) => "drive",
        Stage::Reading(_, Remedy::SetRight(_)) => "reading",
        Stage::Reading(_, Remedy::LeaveOut(_)) => "faulty reading",
    }
}

/// All about an effect, for people.
fn text(effect: &'static Effect) -> String {
    let mut lines = vec![
        format!("{} ({}): {}, {}", effect.name, effect.id, stage(effect), scope(effect)),
        String::new(),
        format!("   {}", effect.formula),
        String::new(),
        effect.description.to_owned(),
        String::new(),
        format!("What its residual looks like. {}", effect.fingerprint),
        format!("What a rigid body or a learned Lagrangian takes of it. {}", effect.absorbed),
    ];
    for others in effect.facts.look_alikes {
        lines.push(format!("Hardly told from {}. What tells them: {}", others.effects.join(" with "), others.told_by));
    }
    if !effect.facts.includes.is_empty() {
        lines.push(format!("Contains {}.", effect.facts.includes.join(", ")));
    }
    lines.push(format!("Source: {}", effect.source));
    lines.push(String::new());
    let rows: Vec<Vec<String>> = effect.parameters.iter().map(row).collect();
    lines.push(table(&["parameter", " symbol", " unit", " of a sliding joint", " bounds", " role"], &rows));
    lines.join("\n")
}

/// The role of a shape parameter that is a place on the joint's way: its start values are shares of that.
const PLACE: &str = "place";

fn row(spec: &'static ParameterSpec) -> Vec<String> {
    let Parameter { name, symbol, unit, unit_prismatic, min, max, role, start_values } = Parameter::of(spec);
    let end = |value: Option<f64>, open: &str| value.map_or_else(|| open.to_owned(), number);
    let role = match start_values {
        [first, .., last] if role == PLACE => {
            format!("{role}, sought from {:.0} to {:.0} % of the way", 100.0 * first, 100.0 * last)
        }
        [first, .., last] => format!("{role}, sought from {} to {}", number(*first), number(*last)),
        _ => role.to_owned(),
    };
    let bounds = format!("{} … {}", end(min, "-∞"), end(max, "∞"));
    vec![name.to_owned(), symbol.to_owned(), unit.to_owned(), unit_prismatic.to_owned(), bounds, role]
}
