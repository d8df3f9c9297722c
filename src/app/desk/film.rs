//! How often pictures are drawn while time goes on.

use std::time::Duration;

use cpu_time::ThreadTime;

/// As many pictures as a film has, and not as many as a screen could show: each of them costs.
const FILM: Duration = Duration::from_millis(33);
/// So rarely only where pictures are dear.
const RARELY: Duration = Duration::from_millis(125);
/// The part of a core that pictures may take of the thread that draws. Where there is no graphics card, the threads of the software
/// renderer take two thirds as much again.
const SHARE: f64 = 0.13;

/// What pictures cost, in time of the thread that draws them: a training beside it makes them no dearer.
#[derive(Debug, Default)]
pub struct Film {
    last: Option<ThreadTime>,
    /// Time of a picture \[s\], of the last few.
    cost: f64,
}

impl Film {
    /// After which time the next picture is due; asked once a picture.
    pub fn due(&mut self) -> Duration {
        let now = ThreadTime::try_now().ok();
        let spent = now.zip(self.last).map(|(now, last)| now.duration_since(last).as_secs_f64());
        self.last = now;
        self.after(spent.unwrap_or(0.0))
    }

    fn after(&mut self, spent: f64) -> Duration {
        self.cost += 0.5 * (spent - self.cost);
        Duration::from_secs_f64(self.cost / SHARE).clamp(FILM, RARELY)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dear_pictures_are_drawn_as_often_as_their_share_of_a_core_pays() {
        let settled = |cost: f64| {
            let mut film = Film::default();
            (0..20).map(|_| film.after(cost)).last().unwrap().as_secs_f64()
        };
        assert!((settled(0.001) - 0.033).abs() < 1e-3, "thirty a second, if they cost nothing");
        assert!((0.015 / settled(0.015) - SHARE).abs() < 1e-3);
        assert!((settled(1.0) - 0.125).abs() < 1e-9, "it moves all the same");
    }
}
