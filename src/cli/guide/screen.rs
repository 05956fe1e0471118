//! The view of a terminal (`--view`): the position to set, what is held, the goals, the residuals and what may be missing, on one screen.
//!
//! The terminal stays as it is otherwise: commands are typed below the view, and nothing needs to be undone where the program is interrupted.

use super::view;
use crate::bench::Bench;
use crate::campaign::{JointState, Reading};
use crate::cli::session;
use crate::document::plot;
use crate::error::{Fault, Malformed, Result};
use crate::guide::{Advice, Agreement, Ending, Held, Progress, Residual};
use crate::language::{Language, say};
use crate::report::{GuideReport, scene};
use nalgebra::Vector3;
use ratatui::backend::{Backend, ClearType, CrosstermBackend, TestBackend};
use ratatui::layout::{Constraint, Layout, Position};
use ratatui::style::{Color, Modifier, Style};
use ratatui::symbols::Marker;
use ratatui::text::{Line, Span};
use ratatui::widgets::canvas::{Canvas, Context, Line as Stroke, Points};
use ratatui::widgets::{Block, Borders, Paragraph, Wrap};
use ratatui::{Frame, Terminal};
use std::io::{IsTerminal, Stdout};

/// Points of a ring: at a terminal's usual size they stand a dot or two apart.
const PIECES: u32 = 48;
/// Half of the drawing's width and height, in radii of the outermost ring: labels stand beyond it.
const EDGE: [f64; 2] = [1.9, 1.35];
/// Cells of a bar, beside which a goal's numbers have room in half of 80 columns.
const BAR: usize = 12;
/// Most rows of what may be missing: the residuals keep theirs in 24 rows.
const ROWS: usize = 6;

pub(super) struct Screen {
    terminal: Terminal<CrosstermBackend<Stdout>>,
    bench: Bench,
    /// What is on it, and how the joints stand in the position to set.
    shown: Option<(GuideReport, Vec<JointState>)>,
}

impl Screen {
    /// Errors: standard output is no terminal.
    pub fn open(bench: &Bench) -> Result<Self> {
        if !std::io::stdout().is_terminal() {
            return Err(Malformed::new(Fault::Value, "--view needs a terminal, but standard output is not one")
                .expected("a terminal, or the command without --view"));
        }
        Ok(Screen { terminal: fresh().map_err(fault)?, bench: bench.clone(), shown: None })
    }

    /// After a step or a line that was refused: `asked` is the position of the advice.
    pub fn step(&mut self, report: GuideReport, asked: Option<&Reading>) -> Result<()> {
        self.shown = Some((report, asked.map_or_else(Vec::new, |reading| reading.joints.to_vec())));
        // what was typed stands on the screen too; clearing by the terminal itself would ask it where its cursor is, which is answered on standard input
        self.terminal = fresh().map_err(fault)?;
        self.draw()
    }

    /// While a position is held.
    pub fn held(&mut self, held: &Held) -> Result<()> {
        self.shown.iter_mut().for_each(|(report, _)| report.held = Some(held.clone()));
        self.draw()
    }

    fn draw(&mut self) -> Result<()> {
        let Some((report, joints)) = &self.shown else { return Ok(()) };
        let drawn = self.terminal.draw(|frame| draw(frame, &self.bench, report, joints, session::language()));
        drawn.map(|_| ()).map_err(fault)
    }
}

impl Drop for Screen {
    /// What is said next stands below the view.
    fn drop(&mut self) {
        let below = self.terminal.size().map_or(0, |size| size.height.saturating_sub(1));
        // a terminal that is gone needs no more
        let _ = self.terminal.set_cursor_position(Position { x: 0, y: below });
        let _ = self.terminal.show_cursor();
    }
}

fn fresh() -> std::io::Result<Terminal<CrosstermBackend<Stdout>>> {
    let mut terminal = Terminal::new(CrosstermBackend::new(std::io::stdout()))?;
    terminal.backend_mut().clear_region(ClearType::All)?;
    Ok(terminal)
}

fn fault(error: impl std::fmt::Display) -> Malformed {
    Malformed::new(Fault::File, format!("the view cannot be drawn: {error}")).expected("a terminal that stays open")
}

/// The view as text, so many columns wide and rows high; `joints` are those of the position to set.
///
/// Errors: no size.
pub fn guide_screen(bench: &Bench, report: &GuideReport, joints: &[JointState], size: [u16; 2]) -> Result<String> {
    let [width, height] = size;
    let mut terminal = Terminal::new(TestBackend::new(width, height)).map_err(fault)?;
    terminal.draw(|frame| draw(frame, bench, report, joints, Language::English)).map_err(fault)?;
    let cells = terminal.backend().buffer().content();
    let lines = cells.chunks(usize::from(width).max(1));
    Ok(lines
        .map(|row| row.iter().map(|cell| cell.symbol()).collect::<String>().trim_end().to_string() + "\n")
        .collect())
}

/// Rows of a list; more than a screen has are not shown.
fn rows(count: usize) -> u16 {
    u16::try_from(count).unwrap_or(u16::MAX / 2)
}

fn titled(title: &str) -> Block<'static> {
    Block::new().borders(Borders::TOP).title(format!(" {title} "))
}

fn draw(frame: &mut Frame<'_>, bench: &Bench, report: &GuideReport, joints: &[JointState], lang: Language) {
    let [said, body, typed] =
        Layout::vertical([Constraint::Length(4), Constraint::Min(12), Constraint::Length(2)]).areas(frame.area());
    let advice = &report.advice;
    frame.render_widget(
        Paragraph::new(sentences(advice, report.error.as_deref(), lang)).wrap(Wrap { trim: true }),
        said,
    );
    let [left, right] =
        Layout::horizontal([Constraint::Percentage(46), Constraint::Percentage(54)]).spacing(2).areas(body);
    let held = report.held.as_ref().map_or(0, |held| 3 + rows(held.means.len()));
    let [next, picture, holding] =
        Layout::vertical([Constraint::Length(4), Constraint::Min(6), Constraint::Length(held)]).areas(left);
    let text = advice.next.as_ref().map_or_else(String::new, |next| view::next(next, lang));
    let set = Paragraph::new(text).style(Modifier::BOLD).wrap(Wrap { trim: true });
    frame.render_widget(set.block(titled(say!(lang, "guide-view-set"))), next);
    if advice.next.is_some() && !bench.chain.is_empty() {
        frame.render_widget(drawing(bench, joints), picture);
    }
    if let Some(held) = &report.held {
        let text = Paragraph::new(view::held(held, lang)).wrap(Wrap { trim: true });
        frame.render_widget(text.block(titled(say!(lang, "guide-view-held"))), holding);
    }
    let missing = missing(advice, lang);
    let [goals, residuals, effects] = Layout::vertical([
        Constraint::Length(1 + rows(advice.goals.len())),
        Constraint::Min(6),
        Constraint::Length(1 + rows(missing.len())),
    ])
    .areas(right);
    let each: Vec<Line<'_>> = advice.goals.iter().map(|progress| goal(progress, lang)).collect();
    frame.render_widget(Paragraph::new(each).block(titled(say!(lang, "guide-view-goals"))), goals);
    frame.render_widget(chart(&advice.residuals, lang), residuals);
    frame.render_widget(Paragraph::new(missing).block(titled(say!(lang, "guide-view-missing"))), effects);
    if advice.ended.is_none() {
        frame.render_widget(Paragraph::new("> ").block(Block::new().borders(Borders::TOP)), typed);
        frame.set_cursor_position(Position { x: typed.x + 2, y: typed.y + 1 });
    }
}

/// The last reading, a likely mistake, or why a line was refused; at the end how it ended.
fn sentences(advice: &Advice, refused: Option<&str>, lang: Language) -> Vec<Line<'static>> {
    let bad = Style::new().fg(Color::Red).add_modifier(Modifier::BOLD);
    let mut lines: Vec<Line<'static>> = Vec::new();
    // the first line of an error says what is wrong
    lines.extend(refused.and_then(|text| text.lines().next()).map(|text| Line::styled(text.to_string(), bad)));
    if let Some(newest) = &advice.newest {
        let style = if newest.agreement == Agreement::Disagrees { bad } else { Style::new() };
        lines.extend(view::newest(newest, lang).into_iter().map(|text| Line::styled(text, style)));
    }
    lines
        .extend(advice.mistake.iter().flat_map(|m| view::mistake(m, lang)).take(2).map(|text| Line::styled(text, bad)));
    if let Some(ended) = advice.ended {
        let style = if ended == Ending::Reached { Style::new().fg(Color::Green) } else { bad };
        lines.push(Line::styled(view::ending(ended, advice, lang), style.add_modifier(Modifier::BOLD)));
    }
    lines
}

fn bar(share: f64, colour: Color) -> [Span<'static>; 2] {
    let full = crate::number::count((share.clamp(0.0, 1.0) * BAR as f64).round());
    [Span::styled("█".repeat(full), colour), Span::styled("░".repeat(BAR.saturating_sub(full)), Color::DarkGray)]
}

/// A goal: its bar is full where `u` is what is wanted.
fn goal(progress: &Progress, lang: Language) -> Line<'static> {
    let share = progress.u.filter(|u| *u > 0.0).map_or(0.0, |u| progress.goal / u);
    let colour = if progress.met { Color::Green } else { Color::Yellow };
    let text = Span::raw(format!(" {}", view::goal(progress, lang).trim_start()));
    Line::from_iter(bar(share, colour).into_iter().chain([text]))
}

/// Effects named and suspected with their probabilities, and that nothing more is missing.
fn missing(advice: &Advice, lang: Language) -> Vec<Line<'static>> {
    let row = |probability: f64, text: String, colour: Color| {
        let text = Span::raw(format!(" {probability:.3} {text}"));
        Line::from_iter(bar(probability, colour).into_iter().chain([text]))
    };
    let named = advice.diagnosis.iter().flat_map(|diagnosis| &diagnosis.effects);
    let named = named
        .map(|effect| row(effect.probability, format!("{} {}", effect.regressor, lang.name(&effect.name)), Color::Red));
    let suspected = advice.suspected.iter();
    let suspected =
        suspected.map(|e| row(e.probability, format!("{} {}", e.regressor, lang.name(&e.name)), Color::Yellow));
    let nothing = row(advice.nothing_missing_or_named, lang.term("nothing-missing"), Color::Green);
    [nothing].into_iter().chain(named).chain(suspected).take(ROWS).collect()
}

/// Residuals in standard deviations by reading, with a line at two of them on either side.
fn chart(residuals: &[Residual], lang: Language) -> Canvas<'static, impl Fn(&mut Context<'_>) + use<>> {
    let points: Vec<(f64, f64)> = residuals.iter().map(|residual| (residual.reading as f64, residual.in_sd)).collect();
    let most = points.iter().fold(3.0_f64, |most, (_, y)| most.max(y.abs()));
    let last = points.iter().fold(2.0_f64, |last, (x, _)| last.max(*x));
    Canvas::default()
        .block(titled(say!(lang, "guide-view-residuals")))
        .marker(Marker::Braille)
        .x_bounds([0.0, last + 1.0])
        .y_bounds([-1.15 * most, 1.15 * most])
        .paint(move |canvas| {
            for (y, colour) in [(0.0, Color::Gray), (2.0, Color::DarkGray), (-2.0, Color::DarkGray)] {
                canvas.draw(&Stroke::new(0.0, y, last + 1.0, y, colour));
            }
            canvas.layer();
            canvas.print(0.0, 2.0, "+2");
            canvas.print(0.0, -2.0, "-2");
            for (x, y) in &points {
                let colour = if y.abs() > 2.0 { Color::Red } else { Color::Cyan };
                canvas.print(*x, *y, Span::styled("●", colour));
            }
        })
}

/// The bench as the position has it: a ring for each joint with a mark at its angle, the unit's axes, gravity and the Earth rate.
fn drawing(bench: &Bench, joints: &[JointState]) -> Canvas<'static, impl Fn(&mut Context<'_>) + use<>> {
    let scene = scene(bench, joints);
    Canvas::default().marker(Marker::Braille).x_bounds([-EDGE[0], EDGE[0]]).y_bounds([-EDGE[1], EDGE[1]]).paint(
        move |canvas| {
            let at = |point: &Vector3<f64>| {
                let seen = plot::seen(point);
                (seen.x, seen.y)
            };
            let stroke = |canvas: &mut Context<'_>, from: &Vector3<f64>, to: &Vector3<f64>, colour: Color| {
                let ((x1, y1), (x2, y2)) = (at(from), at(to));
                canvas.draw(&Stroke::new(x1, y1, x2, y2, colour));
            };
            let middle = Vector3::zeros();
            let mut labels: Vec<(Vector3<f64>, String, Color)> = Vec::new();
            for (k, ring) in scene.rings.iter().enumerate() {
                let radius = plot::radius(k, scene.rings.len());
                let second = ring.axis.cross(&ring.zero);
                let on = |angle: f64| (ring.zero * angle.cos() + second * angle.sin()) * radius;
                let step = std::f64::consts::TAU / f64::from(PIECES);
                let round: Vec<(f64, f64)> = (0..PIECES).map(|k| at(&on(f64::from(k) * step))).collect();
                canvas.draw(&Points { coords: &round, color: Color::DarkGray });
                let angle = ring.angle_deg.to_radians();
                // where it turns, a third of a turn in its sense
                let sweep = if ring.rate_deg_s == 0.0 { 0.0 } else { ring.rate_deg_s.signum() * 8.0 * step };
                let arc: Vec<(f64, f64)> = (0..=32).map(|k| at(&on(angle + sweep * f64::from(k) / 16.0))).collect();
                let colour = if sweep == 0.0 { Color::Blue } else { Color::Red };
                canvas.draw(&Points { coords: &arc, color: colour });
                stroke(canvas, &(on(angle) * 0.8), &on(angle), colour);
                labels.push((ring.axis * (radius + 0.12), ring.label.clone(), Color::Reset));
            }
            for (name, direction) in &scene.inputs {
                let end = scene.unit * direction * 0.62;
                stroke(canvas, &middle, &end, Color::Magenta);
                labels.push((end, name.clone(), Color::Magenta));
            }
            let side = Vector3::new(-1.2, 0.7, 0.0);
            let side = plot::unseen(&side);
            stroke(canvas, &side, &(side - Vector3::z() * 0.42), Color::Green);
            labels.push((side - Vector3::z() * 0.42, "g".into(), Color::Green));
            if let Some(direction) = scene.earth_rate {
                stroke(canvas, &side, &(side + direction * 0.42), Color::Blue);
                labels.push((side + direction * 0.42, "\u{3a9}".into(), Color::Blue));
            }
            canvas.layer();
            for (end, text, colour) in labels {
                let (x, y) = at(&end);
                canvas.print(x, y, Span::styled(text, colour));
            }
        },
    )
}
