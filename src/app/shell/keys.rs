//! Every shortcut, in one table: the keys, the tool tips and the list of shortcuts are made from it.

use egui::{Grid, Key, KeyboardShortcut, Modifiers, RichText, Ui};

use crate::app::desk::Order;
use crate::app::screen::NextStep;
use crate::app::screens;
use crate::app::theme::{GAP, Palette};

const CTRL_SHIFT: Modifiers = Modifiers::COMMAND.plus(Modifiers::SHIFT);

pub const OPEN: KeyboardShortcut = KeyboardShortcut::new(Modifiers::COMMAND, Key::O);
pub const SAVE: KeyboardShortcut = KeyboardShortcut::new(Modifiers::COMMAND, Key::S);
pub const EXPORT: KeyboardShortcut = KeyboardShortcut::new(Modifiers::COMMAND, Key::E);
pub const UNDO: KeyboardShortcut = KeyboardShortcut::new(Modifiers::COMMAND, Key::Z);
pub const REDO: KeyboardShortcut = KeyboardShortcut::new(Modifiers::COMMAND, Key::Y);
pub const NEXT: KeyboardShortcut = KeyboardShortcut::new(Modifiers::COMMAND, Key::Enter);
pub const PALETTE: KeyboardShortcut = KeyboardShortcut::new(Modifiers::COMMAND, Key::P);
pub const MODELS: KeyboardShortcut = KeyboardShortcut::new(Modifiers::COMMAND, Key::M);
pub const LIST: KeyboardShortcut = KeyboardShortcut::new(Modifiers::NONE, Key::F1);
const REDO_TOO: KeyboardShortcut = KeyboardShortcut::new(CTRL_SHIFT, Key::Z);
const PALETTE_TOO: KeyboardShortcut = KeyboardShortcut::new(CTRL_SHIFT, Key::P);
const LIST_TOO: KeyboardShortcut = KeyboardShortcut::new(Modifiers::SHIFT, Key::Questionmark);
const LIST_PLAIN: KeyboardShortcut = KeyboardShortcut::new(Modifiers::NONE, Key::Questionmark);
const STOP: KeyboardShortcut = KeyboardShortcut::new(Modifiers::NONE, Key::Escape);
pub const FIT: KeyboardShortcut = KeyboardShortcut::new(Modifiers::NONE, Key::Home);
const NEXT_PANEL: KeyboardShortcut = KeyboardShortcut::new(Modifiers::NONE, Key::F6);
const THEME: KeyboardShortcut = KeyboardShortcut::new(Modifiers::COMMAND, Key::T);
const NUMBERS: [Key; 9] =
    [Key::Num1, Key::Num2, Key::Num3, Key::Num4, Key::Num5, Key::Num6, Key::Num7, Key::Num8, Key::Num9];

/// What lies over the screens.
pub struct Open {
    pub palette: bool,
    pub key_list: bool,
    pub models: bool,
    pub exporting: bool,
    /// A question that waits for its answer: no key does anything else.
    pub asking: bool,
}

/// The orders that were given by keys.
pub fn shortcuts(ctx: &egui::Context, open: Open, next: impl FnOnce() -> Option<NextStep>) -> Vec<Order> {
    let mut orders = Vec::new();
    if open.asking {
        return orders;
    }
    // While text is typed, undo is the text's own, and a question mark is one.
    let typing = ctx.text_edit_focused();
    // What lies on top takes Escape for itself.
    let covered = typing || egui::Popup::is_any_open(ctx);
    ctx.input_mut(|input| {
        // Those with Shift have to be asked for first: Ctrl+Z would match Ctrl+Shift+Z too.
        for key in [PALETTE_TOO, PALETTE] {
            if !open.exporting && input.consume_shortcut(&key) {
                orders.push(Order::Palette(!open.palette));
            }
        }
        let overlay = open.palette || open.key_list;
        if overlay && input.consume_shortcut(&STOP) {
            orders.extend([Order::Palette(false), Order::KeyList(false)]);
        }
        if !open.exporting
            && (input.consume_shortcut(&LIST)
                || (!typing && (input.consume_shortcut(&LIST_TOO) || input.consume_shortcut(&LIST_PLAIN))))
        {
            orders.push(Order::KeyList(!open.key_list));
        }
        // What a dialog covers is out of reach, of keys too.
        if overlay || open.exporting {
            return;
        }
        let general = [
            (REDO_TOO, Order::Redo),
            (REDO, Order::Redo),
            (UNDO, Order::Undo),
            (OPEN, Order::OpenDialog),
            (SAVE, Order::SaveAgain),
            (EXPORT, Order::Export(None)),
            (THEME, Order::ToggleTheme),
            (FIT, Order::FitAll),
            (NEXT_PANEL, Order::NextPanel),
            (MODELS, Order::Models(!open.models)),
        ];
        for (shortcut, order) in general {
            if !typing && input.consume_shortcut(&shortcut) {
                orders.push(order);
            }
        }
        if !covered && input.consume_shortcut(&STOP) {
            orders.push(Order::Stop);
        }
        if input.consume_shortcut(&NEXT) {
            orders.extend(next().map(|next| next.order));
        }
        for (key, screen) in NUMBERS.into_iter().zip(screens::all()) {
            if input.consume_shortcut(&KeyboardShortcut::new(Modifiers::COMMAND, key)) {
                orders.push(Order::Show(screen));
            }
        }
    });
    orders
}

/// `Ctrl+Z`, or what it is called on this system.
pub fn text(ui: &Ui, shortcut: &KeyboardShortcut) -> String {
    ui.ctx().format_shortcut(shortcut)
}

/// The list of all shortcuts, while it is asked for.
pub fn list(ui: &mut Ui, is_open: &mut bool) {
    if !*is_open {
        return;
    }
    let palette = Palette::in_ui(ui);
    let text = |shortcut: &KeyboardShortcut| text(ui, shortcut);
    let rows = [
        (text(&NEXT), "the next step"),
        ("Ctrl+1 … Ctrl+9".to_owned(), "the screens, left to right"),
        (format!("{} or {}", text(&PALETTE), text(&PALETTE_TOO)), "find any command"),
        (text(&OPEN), "open recordings or a session"),
        (text(&SAVE), "save the session"),
        (text(&MODELS), "the models of the session"),
        (text(&EXPORT), "export plots, a report, a model or data"),
        (text(&UNDO), "undo"),
        (format!("{} or {}", text(&REDO), text(&REDO_TOO)), "redo"),
        (text(&STOP), "stop what is at work; close a list"),
        (text(&THEME), "light or dark"),
        ("Ctrl+Plus, Ctrl+Minus, Ctrl+0".to_owned(), "larger text, smaller text, as it was"),
        (format!("{} or ?", text(&LIST)), "this list"),
        ("in a chart: drag, ← →".to_owned(), "move the time cursor"),
        ("in a chart: M+drag, Alt+drag".to_owned(), "measure between two cursors"),
        ("in a chart: Ctrl+wheel".to_owned(), "zoom about the pointer"),
        ("in a chart: Ctrl+Shift+wheel".to_owned(), "zoom the heights about the pointer"),
        ("in a chart: Ctrl+drag".to_owned(), "zoom to a box"),
        ("in a chart: right click, L".to_owned(), "limits of its axes, and lines of your own"),
        ("in a chart: right drag, Shift+drag".to_owned(), "move the view"),
        ("in a chart: double click, F".to_owned(), "show everything of that quantity"),
        ("above a chart: click, double click".to_owned(), "hide a line, show it alone"),
        (text(&FIT), "show everything in all charts"),
        ("in a chart: right click, E".to_owned(), "export this plot"),
        ("in a chart: C".to_owned(), "copy the values at the cursor"),
        (text(&NEXT_PANEL), "the tab of the next panel"),
        ("on a tab: Shift+← → ↑ ↓".to_owned(), "move its panel to that side"),
        ("on a tab: Delete".to_owned(), "hide its panel"),
    ];
    let modal = egui::Modal::new(egui::Id::unique("key list")).show(ui.ctx(), |ui| {
        ui.heading("Keyboard and mouse");
        ui.add_space(GAP);
        let height = ui.ctx().content_rect().height() - 150.0;
        egui::ScrollArea::vertical().max_height(height).min_scrolled_height(height).show(ui, |ui| {
            Grid::new("keys").striped(true).spacing([24.0, 6.0]).show(ui, |ui| {
                for (keys, what) in rows {
                    ui.label(RichText::new(keys).color(palette.accent));
                    ui.label(what);
                    ui.end_row();
                }
            });
        });
        ui.add_space(GAP);
        ui.button("Close").clicked()
    });
    if modal.inner || modal.should_close() {
        *is_open = false;
    }
}
