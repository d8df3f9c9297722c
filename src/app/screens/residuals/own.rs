//! Lines of one's own beside the residual: over time as they are, over a state their mean, as that of the residual is drawn.

use std::sync::Arc;

use super::table::{Quantity, Table};
use crate::app::desk::Desk;
use crate::app::formula::{self, Channels};
use crate::app::memo::{Answer, Memo, Question};
use crate::app::plot::OwnSeries;
use crate::figure::mark::Line;
use crate::figure::{Ink, Shared};
use crate::session::Session;

/// A formula of the samples of a table.
#[derive(Clone, PartialEq)]
pub struct OnTable {
    series: OwnSeries,
    table: Arc<Table>,
    over: Quantity,
}

/// A curve through points.
pub struct Curve {
    x: Vec<f64>,
    y: Vec<f64>,
}

impl Question for OnTable {
    type Answer = Curve;

    fn answer(&self, session: &Session) -> Result<Curve, String> {
        let recording = session.recording.as_deref().ok_or("there is no recording")?;
        let step = session.model_of(self.table.model()).ok_or("there is no such model")?;
        let mut values = Vec::with_capacity(self.table.len());
        for rows in self.table.places().chunk_by(|one, other| one.trajectory == other.trajectory) {
            let trajectory = rows[0].trajectory;
            let (run, predicted) =
                (&recording.trajectories[trajectory], &step.evaluation.predictions[trajectory].total);
            let channels = Channels { run, predicted: Some(predicted), is_measured: true };
            let own = formula::along(&self.series, &channels)?;
            values.extend(rows.iter().map(|place| own[place.sample]));
        }
        if self.over == Quantity::Time {
            return Ok(Curve { x: self.table.column(Quantity::Time).to_vec(), y: values });
        }
        let (x, y) = self.table.means(self.over, &values).into_iter().map(|[x, mean, _]| (x, mean)).unzip();
        Ok(Curve { x, y })
    }
}

/// All charts over time and over states can have lines of one's own.
pub fn prepare(desk: &mut Desk, table: &Arc<Table>, ask: impl Fn(&mut Memo, OnTable) -> Option<Answer<OnTable>>) {
    let Desk { focus, memo, .. } = desk;
    for over in Quantity::STATES {
        focus.views.own.draw(over.along(focus.joint), |series| {
            let curve = ask(memo, OnTable { series: series.clone(), table: Arc::clone(table), over })?;
            let line = |curve: Arc<Curve>| {
                let of = |part: fn(&Curve) -> &[f64]| Shared::of(&curve, part);
                let line = Line::new("", of(|curve| &curve.x), of(|curve| &curve.y), Ink::Text);
                if over == Quantity::Time { line.sampled() } else { line }
            };
            Some(curve.map(line))
        });
    }
}
