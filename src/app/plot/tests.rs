//! Panels in a window: what hands do with them, and what a frame costs.

use egui::{Event, Key, Modifiers, Pos2, Vec2, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable as _;

use super::{Along, Decimator, PanelView, Region, Shown, Views};
use crate::figure::mark::{Line, Shade};
use crate::figure::{Axis, Ink, Panel, Shared};

/// Two panels below each other over the same time, the lower one logarithmic.
struct Desk {
    panels: [Panel; 2],
    views: Views,
    decimator: Decimator,
    cursor: Option<f64>,
    brush: Option<Region>,
    brushes: bool,
    shown: Vec<Shown>,
}

impl Desk {
    fn new(samples: usize) -> Self {
        let time: Shared<f64> = (0..samples).map(|n| n as f64 / samples as f64 * 10.0).collect::<Vec<_>>().into();
        let signal = |factor: f64| -> Vec<f64> { time.iter().map(|t| (factor * t).sin()).collect() };
        let x = || Axis::new("time t", "s").linked(Along::Time);
        let mut broken = signal(3.0);
        broken[samples / 2] = f64::NAN;
        let torque = Panel::new("torque", [x(), Axis::new("", "N m")])
            .with(Shade([2.0, 3.0]))
            .with(Line::new("measured", time.clone(), signal(1.0), Ink::Measured).sampled())
            .with(Line::new("predicted", time.clone(), broken, Ink::Predicted).sampled());
        let power: Vec<f64> = time.iter().map(|t| if *t == 0.0 { 0.0 } else { 10f64.powf(t - 5.0) }).collect();
        let error = Panel::new("error", [x(), Axis::new("", "").logarithmic()])
            .with(Line::new("measured", time, power, Ink::Series(1)).sampled());
        let (views, decimator) = (Views::default(), Decimator::default());
        Desk { panels: [torque, error], views, decimator, cursor: None, brush: None, brushes: false, shown: Vec::new() }
    }

    fn frame(&mut self, ui: &mut egui::Ui) {
        let [torque, error] = self.panels.clone();
        let upper = PanelView::new(torque).height(200.0).without_ticks();
        let upper = if self.brushes { upper.brush(&mut self.brush) } else { upper.cursor(&mut self.cursor) };
        let upper = upper.show(ui, &mut self.views, &mut self.decimator);
        let lower = PanelView::new(error).height(220.0).show(ui, &mut self.views, &mut self.decimator);
        self.shown = vec![upper, lower];
    }
}

type Window = Harness<'static, Desk>;

fn window(samples: usize) -> Window {
    let build = |ui: &mut egui::Ui, desk: &mut Desk| desk.frame(ui);
    let builder = Harness::builder().with_size(vec2(800.0, 500.0)).with_step_dt(1.0 / 60.0);
    let mut window = builder.build_ui_state(build, Desk::new(samples));
    window.run_steps(3);
    window
}

/// A place of the upper plot, given by shares of its width and height.
fn at(window: &Window, x: f32, y: f32) -> Pos2 {
    let plot = window.get_by_label("plot of torque [N m]").rect();
    plot.min + vec2(x, y) * plot.size()
}

fn drag(window: &mut Window, from: Pos2, to: Pos2) {
    window.drag_at(from);
    window.run_steps(2);
    // A drag is one from a few points on.
    window.hover_at(from + 8.0 * (to - from).normalized());
    window.run_steps(2);
    window.hover_at(from + 0.5 * (to - from));
    window.run_steps(2);
    window.hover_at(to);
    window.run_steps(2);
    window.drop_at(to);
    window.run_steps(3);
}

fn with(window: &mut Window, modifiers: Modifiers, act: impl FnOnce(&mut Window)) {
    window.event(Event::ModifiersChanged(modifiers));
    act(window);
    window.event(Event::ModifiersChanged(Modifiers::NONE));
    window.run_steps(2);
}

fn is_near(range: [f64; 2], [from, to]: [f64; 2]) -> bool {
    (range[0] - from).abs() < 0.2 && (range[1] - to).abs() < 0.2
}

fn ranges(window: &Window, panel: usize) -> [[f64; 2]; 2] {
    window.state().shown[panel].ranges
}

#[test]
fn stacked_plots_are_aligned_and_a_logarithm_has_its_own_measure() {
    let window = window(1000);
    let [upper, lower] = [0, 1].map(|panel| window.state().shown[panel].plot);
    assert_eq!((upper.left(), upper.right()), (lower.left(), lower.right()));
    assert_eq!(ranges(&window, 0)[0], [0.0, 9.99]);
    let [low, high] = ranges(&window, 1)[1];
    let inside = (-5.7..-5.0).contains(&low) && (4.9..5.7).contains(&high);
    assert!(inside, "0 is a hole, not the range: {low} {high}");
}

#[test]
fn ctrl_and_drag_zoom_to_a_box_in_all_linked_plots() {
    let mut window = window(1000);
    let (from, to) = (at(&window, 0.2, 0.25), at(&window, 0.6, 0.75));
    let before = ranges(&window, 0);
    with(&mut window, Modifiers::COMMAND, |window| drag(window, from, to));
    assert!(is_near(ranges(&window, 0)[0], [2.0, 6.0]), "{:?}", ranges(&window, 0));
    assert!(is_near(ranges(&window, 1)[0], [2.0, 6.0]), "the linked one follows");
    let height = |[low, high]: [f64; 2]| high - low;
    assert!((height(ranges(&window, 0)[1]) / height(before[1]) - 0.5).abs() < 0.05);
    assert!(window.state().cursor.is_none(), "a box is not a cursor");
    window.get_by_label("plot of torque [N m]").focus();
    window.run_steps(2);
    window.key_press(Key::F);
    window.run_steps(3);
    assert_eq!(ranges(&window, 0), before);
    assert_eq!(ranges(&window, 1)[0], before[0]);
}

#[test]
fn wheel_drag_keys_and_double_click_move_the_view() {
    let mut window = window(1000);
    let middle = at(&window, 0.25, 0.5);
    window.hover_at(middle);
    window.run_steps(2);
    window.event(Event::Zoom(2.0));
    window.run_steps(3);
    let [from, to] = ranges(&window, 0)[0];
    assert!((to - from - 5.0).abs() < 0.1, "half of it: {from} {to}");
    assert!((from + 0.25 * (to - from) - 2.5).abs() < 0.1, "what is under the pointer stays there");
    let (begin, end) = (at(&window, 0.5, 0.5), at(&window, 0.4, 0.5));
    with(&mut window, Modifiers::SHIFT, |window| drag(window, begin, end));
    assert!((ranges(&window, 0)[0][0] - from - 0.5).abs() < 0.1, "dragged to the left: later");
    assert!(window.state().cursor.is_none());

    drag(&mut window, begin, end);
    let dragged = window.state().cursor.unwrap();
    window.get_by_label("plot of torque [N m]").focus();
    window.run_steps(2);
    window.key_press(Key::ArrowLeft);
    window.run_steps(2);
    let stepped = window.state().cursor.unwrap();
    assert!(stepped < dragged && dragged - stepped < 0.1, "{dragged} -> {stepped}");

    for _ in 0..2 {
        window.drag_at(middle);
        window.drop_at(middle);
    }
    window.run_steps(3);
    assert_eq!(ranges(&window, 0)[0], [0.0, 9.99]);
}

/// With Shift the wheel zooms the heights alone, a drag moves them then, and a double click shows everything again.
#[test]
fn the_heights_are_zoomed_and_come_back() {
    let mut window = window(1000);
    let before = ranges(&window, 0);
    let place = at(&window, 0.5, 0.25);
    window.hover_at(place);
    window.run_steps(2);
    with(&mut window, Modifiers::SHIFT, |window| {
        window.event(Event::Zoom(2.0));
        window.run_steps(3);
    });
    let [x, [low, high]] = ranges(&window, 0);
    assert_eq!(x, before[0]);
    let height = before[1][1] - before[1][0];
    assert!((high - low - 0.5 * height).abs() < 1e-3 * height, "half of it: {low} {high}");
    let above = |[low, high]: [f64; 2]| high - 0.25 * (high - low);
    assert!((above([low, high]) - above(before[1])).abs() < 0.01 * height, "what is under the pointer stays there");
    let (begin, end) = (at(&window, 0.5, 0.3), at(&window, 0.5, 0.6));
    with(&mut window, Modifiers::SHIFT, |window| drag(window, begin, end));
    assert!(ranges(&window, 0)[1][1] > high + 0.1 * height, "dragged down: what lies above is seen");
    for _ in 0..2 {
        window.drag_at(place);
        window.drop_at(place);
    }
    window.run_steps(3);
    assert_eq!(ranges(&window, 0), before);
}

#[test]
fn alt_and_drag_measure_and_a_brush_marks() {
    let mut window = window(1000);
    let (from, to) = (at(&window, 0.2, 0.3), at(&window, 0.6, 0.6));
    with(&mut window, Modifiers::ALT, |window| drag(window, from, to));
    let measured = |window: &mut Window| window.state_mut().views.of(Along::Time).measured.take().unwrap();
    assert!(is_near(measured(&mut window), [2.0, 6.0]));
    // Where the window manager takes Alt for itself, M does the same.
    window.key_down(Key::M);
    drag(&mut window, from, to);
    window.key_up(Key::M);
    assert!(is_near(measured(&mut window), [2.0, 6.0]));
    window.state_mut().brushes = true;
    drag(&mut window, from, to);
    let [x, y] = window.state().brush.unwrap();
    assert!(is_near(x, [2.0, 6.0]) && y[0] < y[1], "{x:?} {y:?}");
}

/// Also where neither a cursor nor a brush is asked for.
#[test]
fn every_plot_measures() {
    let mut window = window(1000);
    let plot = window.get_by_label("plot of error").rect();
    let [from, to] = [0.2, 0.6].map(|share| plot.min + vec2(share, 0.5) * plot.size());
    window.key_down(Key::M);
    drag(&mut window, from, to);
    window.key_up(Key::M);
    let measured = window.state_mut().views.of(Along::Time).measured.unwrap();
    assert!(is_near(measured, [2.0, 6.0]), "{measured:?}");
    window.state_mut().brushes = true;
    let (from, to) = (at(&window, 0.3, 0.3), at(&window, 0.7, 0.6));
    window.key_down(Key::M);
    drag(&mut window, from, to);
    window.key_up(Key::M);
    assert!(window.state().brush.is_none(), "a drag does one thing");
    assert!(is_near(window.state_mut().views.of(Along::Time).measured.unwrap(), [3.0, 7.0]));
}

/// A click on a name of the legend hides what it names in all linked plots, a double click shows it alone.
#[test]
fn names_of_the_legend_hide_lines() {
    let mut window = window(1000);
    let names = |window: &Window| -> Vec<String> {
        let marks = window.state().shown[0].panel.marks.iter();
        marks.filter_map(|mark| mark.entry()).map(|entry| entry.name.to_owned()).collect()
    };
    let press = |window: &mut Window, name: &str, times: usize| {
        let at = window.get_by_label(&format!("{name} in torque")).rect().center();
        // Far enough from the last click not to belong to it.
        window.hover_at(at + Vec2::splat(200.0));
        window.run_steps(60);
        for _ in 0..times {
            window.drag_at(at);
            window.drop_at(at);
        }
        window.run_steps(3);
    };
    assert_eq!(names(&window), ["measured", "predicted"]);
    press(&mut window, "measured", 1);
    assert_eq!(names(&window), ["predicted"]);
    assert!(window.state().shown[1].panel.marks.is_empty(), "also in the linked plot");
    press(&mut window, "measured", 1);
    assert_eq!(names(&window), ["measured", "predicted"]);
    press(&mut window, "predicted", 2);
    assert_eq!(names(&window), ["predicted"]);
    press(&mut window, "predicted", 2);
    assert_eq!(names(&window), ["measured", "predicted"]);
}

/// Half a million samples are thinned once for a view, not in every frame.
#[test]
fn what_was_thinned_is_kept_for_the_next_frames() {
    let mut window = window(532_000);
    let kept = window.state().decimator.kept();
    window.run_steps(10);
    assert_eq!(window.state().decimator.kept(), kept);
    window.hover_at(at(&window, 0.5, 0.5));
    window.event(Event::Zoom(2.0));
    window.run_steps(3);
    let zoomed = window.state().decimator.kept();
    assert!(zoomed > kept);
    window.run_steps(10);
    assert_eq!(window.state().decimator.kept(), zoomed);
}
