//! How often pictures are drawn while time goes on, and how carefully.

use std::time::Duration;

use cpu_time::{ProcessTime, ThreadTime};

/// As many pictures as a film has, and not as many as a screen could show: each of them costs.
const FILM: Duration = Duration::from_millis(33);
/// So rarely only where pictures are dear.
const RARELY: Duration = Duration::from_millis(250);
/// The part of a core that pictures may take, a little less than the quarter that is the goal.
const SHARE: f64 = 0.23;
/// Pictures that are further apart than this \[s\] are sketches, with edges that are not smoothed: that halves what they cost without
/// a graphics card, where the eye would see them one by one.
const SKETCHED: f64 = 0.085;
/// Threads of a software renderer take no more than so many times what the thread that draws takes: more is other work.
const MOST_HELP: f64 = 8.0;

/// What pictures cost: the time of the thread that draws them and, where there is no graphics card, of those that render.
#[derive(Debug, Clone)]
pub struct Film {
    last: Option<[Duration; 2]>,
    /// The frame that was drawn last, and when the one after it was due.
    frame: (u64, Duration),
    /// Time of a picture, of all threads \[s\], of the last few.
    cost: f64,
    /// Time of all threads over that of the one that draws, seen while nothing else was at work.
    threads: f64,
    /// Whether nothing else was at work when the last frame was drawn.
    is_alone: bool,
    is_sketch: bool,
    /// Whether this frame is a picture of the film.
    is_moving: bool,
}

impl Default for Film {
    fn default() -> Self {
        Film {
            last: None,
            frame: (0, FILM),
            cost: 0.0,
            threads: 1.0,
            is_alone: true,
            is_sketch: false,
            is_moving: false,
        }
    }
}

impl Film {
    /// After which time the picture after this frame is due, in whichever of its passes that is asked. It counts from now, while this
    /// one is drawn, so it is the time from picture to picture.
    pub fn due(&mut self, frame: u64) -> Duration {
        self.is_moving = true;
        if self.last.is_some() && self.frame.0 == frame {
            return self.frame.1;
        }
        let now = ThreadTime::try_now().ok().zip(ProcessTime::try_now().ok());
        let now = now.map(|(own, all)| [own.as_duration(), all.as_duration()]);
        let spent =
            now.zip(self.last).map(|(now, last)| [0, 1].map(|of| now[of].saturating_sub(last[of]).as_secs_f64()));
        self.last = now;
        self.frame = (frame, self.after(spent.unwrap_or_default()));
        self.frame.1
    }

    fn after(&mut self, [own, all]: [f64; 2]) -> Duration {
        if self.is_alone && own > 0.0 {
            self.threads += 0.5 * ((all / own).clamp(1.0, MOST_HELP) - self.threads);
        }
        self.cost += 0.5 * (own * self.threads - self.cost);
        let apart = self.cost / SHARE;
        self.is_sketch |= apart > SKETCHED;
        Duration::from_secs_f64(apart).clamp(FILM, RARELY)
    }

    /// A frame was drawn. What else is at work makes pictures no dearer: their threads are counted only while the program is alone
    /// with them. Says whether it is to be a sketch; the first frame that stands still is not.
    pub fn end_frame(&mut self, is_alone: bool) -> bool {
        self.is_alone = is_alone;
        if !std::mem::take(&mut self.is_moving) {
            (self.last, self.is_sketch) = (None, false);
        }
        self.is_sketch
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn settled(film: &mut Film, spent: [f64; 2], is_alone: bool) -> f64 {
        film.is_alone = is_alone;
        (0..30).map(|_| film.after(spent)).last().unwrap().as_secs_f64()
    }

    #[test]
    fn dear_pictures_are_drawn_as_often_as_their_share_of_a_core_pays() {
        let due = |own: f64, all: f64| settled(&mut Film::default(), [own, all], true);
        assert!((due(0.001, 0.001) - 0.033).abs() < 1e-3, "thirty a second, if they cost nothing");
        assert!((0.03 / due(0.01, 0.03) - SHARE).abs() < 1e-3, "the threads of the renderer count");
        assert!((due(1.0, 1.0) - 0.25).abs() < 1e-9, "it moves all the same");
    }

    #[test]
    fn a_training_beside_it_makes_pictures_no_dearer() {
        let mut film = Film::default();
        let alone = settled(&mut film, [0.01, 0.03], true);
        let beside = settled(&mut film, [0.01, 0.2], false);
        assert!((beside - alone).abs() < 1e-3, "{beside} {alone}");
    }

    #[test]
    fn only_dear_pictures_that_move_are_sketches() {
        for (own, is_sketch) in [(0.002, false), (0.03, true)] {
            let mut film = Film::default();
            settled(&mut film, [own, own], true);
            film.is_moving = true;
            assert_eq!(film.end_frame(true), is_sketch);
            assert!(!film.end_frame(true), "it stands still");
        }
    }
}
