//! The report of a verification: one page without anything beside it, and the same as JSON.

use super::cases::{Case, When, Word};
use super::{Outcome, results, unit};
use crate::bench::machine::Description;
use crate::failure::Failure;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use estar_deck::format::{digits, duration, hex};
use estar_io::write_atomically;
use estar_post::plot::shaded::{Style, View, Window};
use estar_post::plot::surface::{Part, Surface};
use estar_post::plot::{Axis, Curve, Figure, Panel, shaded};
use estar_post::series;
use estar_post::table::Table;
use estar_solver::LaneLevel;
use serde::Serialize;
use sha2::{Digest, Sha256};
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

/// All that came of a verification.
#[derive(Serialize)]
pub struct Report<'a> {
    version: &'static str,
    /// Seconds since 1970 began.
    time: u64,
    machine: Description,
    lanes: &'static str,
    /// SHA-256 of the table of cases.
    table_hash: String,
    seconds: f64,
    passed: bool,
    cases: &'a [Outcome],
    #[serde(skip)]
    table: &'a [&'a Case],
}

impl<'a> Report<'a> {
    /// The report of cases, of which `table` is the text.
    pub fn new(cases: &'a [&'a Case], outcomes: &'a [Outcome], table: &str, seconds: f64) -> Self {
        Self {
            version: env!("CARGO_PKG_VERSION"),
            time: SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs()),
            machine: Description::of_this_machine(),
            lanes: LaneLevel::best().name(),
            table_hash: hex(&Sha256::digest(table.as_bytes())),
            seconds,
            passed: outcomes.iter().all(|outcome| outcome.met),
            cases: outcomes,
            table: cases,
        }
    }

    /// Writes `report.html` and `verification.json`; the path of the page.
    ///
    /// # Errors
    /// They cannot be written.
    pub fn write(&self, directory: &Path) -> Result<PathBuf, Failure> {
        let json = directory.join("verification.json");
        let mut text = serde_json::to_string_pretty(self).map_err(|error| Failure::File(format!("error: {error}")))?;
        text.push('\n');
        write_atomically(&json, text.as_bytes()).map_err(Failure::writing(&json))?;
        let page = directory.join("report.html");
        write_atomically(&page, self.page(directory).as_bytes()).map_err(Failure::writing(&page))?;
        Ok(page)
    }

    fn page(&self, directory: &Path) -> String {
        let failed = self.cases.iter().filter(|outcome| !outcome.met).count();
        let verdict = match failed {
            0 => format!("<span class=\"met\">all {} cases passed</span>", self.cases.len()),
            failed => format!("<span class=\"missed\">{failed} of {} cases failed</span>", self.cases.len()),
        };
        let Description { processor, architecture, system, cores, .. } = &self.machine;
        let mut page = format!(
            "<!doctype html>\n<html lang=\"en\">\n<head><meta charset=\"utf-8\"><title>Estar: verification</title>\n\
             <style>{STYLE}</style></head>\n<body>\n<h1>Estar {}: {verdict}</h1>\n\
             <p>{} UTC, in {}. {}, {architecture} {system}, {cores} threads, {} lanes.<br>Table of cases: SHA-256 <code>{}</code>.</p>\n\
             <table><tr><th>case</th><th>what it shows</th><th></th><th>time</th></tr>\n",
            self.version,
            utc(self.time),
            duration(self.seconds),
            escaped(processor),
            self.lanes,
            self.table_hash
        );
        for outcome in self.cases {
            let _ = writeln!(
                page,
                "<tr><td><a href=\"#{0}\">{0}</a></td><td>{1}</td><td>{2}</td><td>{3}</td></tr>",
                escaped(&outcome.name),
                escaped(&outcome.about),
                verdict_of(outcome.met),
                duration(outcome.seconds)
            );
        }
        page.push_str("</table>\n");
        for (case, outcome) in self.table.iter().zip(self.cases) {
            page.push_str(&section(case, outcome, &results(&directory.join("runs").join(&case.name))));
        }
        page + "</body>\n</html>\n"
    }
}

const STYLE: &str = "body{font:15px/1.5 system-ui,sans-serif;max-width:1000px;margin:2em auto;padding:0 1em;color:#202020}\
    h1{font-size:1.6em}h2{font-size:1.2em;margin-top:2.5em;border-top:1px solid #ddd;padding-top:1em}\
    table{border-collapse:collapse;width:100%}td,th{text-align:left;padding:.3em .8em .3em 0;border-bottom:1px solid #eee;\
    vertical-align:top}.met{color:#1a7f37}.missed{color:#c62828;font-weight:bold}code{font-size:.9em;overflow-wrap:anywhere}\
    td code{overflow-wrap:normal}svg,img{max-width:100%;height:auto}pre{background:#f6f6f6;padding:1em;overflow:auto}";

fn verdict_of(met: bool) -> &'static str {
    if met { "<span class=\"met\">passed</span>" } else { "<span class=\"missed\">FAILED</span>" }
}

/// A case: what was asked, got and expected, the curves against the references, and the body.
fn section(case: &Case, outcome: &Outcome, results: &Path) -> String {
    let name = escaped(&outcome.name);
    let mut text = format!(
        "<h2 id=\"{name}\">{name}: {}</h2>\n<p>{}. Deck {}.</p>\n",
        verdict_of(outcome.met),
        escaped(&outcome.about),
        with_code(&outcome.deck)
    );
    if let Some(trouble) = &outcome.trouble {
        let _ = writeln!(text, "<pre>{}</pre>", escaped(trouble));
    }
    if !outcome.findings.is_empty() {
        text.push_str(
            "<table><tr><th>quantity</th><th>at</th><th>found</th><th>expected</th><th>deviation / tolerance</th><th>source</th><th></th></tr>\n",
        );
        for finding in &outcome.findings {
            let _ = writeln!(
                text,
                "<tr><td><code>{}</code></td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>",
                escaped(&finding.quantity),
                escaped(&finding.at),
                escaped(&finding.shown),
                escaped(&finding.wanted),
                finding.share_of_tolerance().map_or_else(String::new, |share| format!("{:.0} %", 100.0 * share)),
                escaped(&finding.source),
                verdict_of(finding.met)
            );
        }
        text.push_str("</table>\n");
    }
    if !outcome.state_hash.is_empty() {
        let _ = writeln!(text, "<p>State <code>{}</code></p>", outcome.state_hash);
    }
    if let Ok(table) = Table::read(&results.join(case.command.table())) {
        text.push_str(&curves(case, outcome, &table).drawing().svg());
        for curve in &case.curve {
            let over = curve.over(case.command);
            let _ = writeln!(
                text,
                "<p>Reference of <code>{}</code> over <code>{}</code>: {}</p>",
                escaped(&curve.quantity),
                escaped(over),
                escaped(&curve.source)
            );
        }
    }
    if let Some(Picture { png, caption }) = picture(case, results) {
        let _ = writeln!(
            text,
            "<p><img alt=\"the body at the end\" src=\"data:image/png;base64,{png}\"><br>{}</p>",
            escaped(&caption)
        );
    }
    text
}

/// Each quantity over what it is asked for at, with what was expected of it and the reference curves.
fn curves(case: &Case, outcome: &Outcome, table: &Table) -> Figure {
    let mut charts = Charts { outcome, table, charts: Vec::new() };
    let abscissa = case.command.abscissa();
    for (curve, points) in case.curve.iter().zip(&outcome.references) {
        let Some(chart) = charts.of(curve.over(case.command), &curve.quantity) else { continue };
        let apart = |point: &[f64; 2]| [*point, [f64::NAN; 2]];
        chart.references.push(Curve {
            label: if chart.references.is_empty() { "reference".to_owned() } else { String::new() },
            colour: 2,
            dash: 1,
            is_dotted: !curve.straight,
            points: if curve.straight { points.clone() } else { points.iter().flat_map(apart).collect() },
            ..Curve::default()
        });
    }
    let [first, last] = table.column(abscissa).map_or([0.0; 2], |column| [column[0], column[column.len() - 1]]);
    for check in &case.check {
        let quantity = check.quantity.as_str();
        let [expected, allowed] = [check.value.si(), check.allowance()].map(|value| value / check.times);
        match &check.at {
            When::Word(word) => {
                let Some(chart) = charts.of(abscissa, quantity) else { continue };
                match word {
                    Word::Start => chart.expect([first, expected], [0.0, allowed]),
                    Word::End => chart.expect([last, expected], [0.0, allowed]),
                    Word::Largest | Word::Always => {
                        chart.expected.extend([[first, expected], [last, expected], [f64::NAN; 2]]);
                    }
                }
            }
            When::Where(places) => {
                for (column, place) in places {
                    // when something is reached shows over time, as all else does
                    if quantity == abscissa {
                        let Some(chart) = charts.of(abscissa, column) else { continue };
                        chart.expect([expected, place.si()], [allowed, 0.0]);
                    } else {
                        let Some(chart) = charts.of(column, quantity) else { continue };
                        chart.expect([place.si(), expected], [0.0, allowed]);
                    }
                }
            }
        }
    }
    Figure { title: String::new(), panels: charts.charts.into_iter().map(Chart::panel).collect() }
}

/// The charts of a case, each under the names of its columns.
struct Charts<'a> {
    outcome: &'a Outcome,
    table: &'a Table,
    charts: Vec<Chart>,
}

/// A column of the run over another, and what it should be.
struct Chart {
    columns: [String; 2],
    axes: [Axis; 2],
    run: Vec<[f64; 2]>,
    references: Vec<Curve>,
    expected: Vec<[f64; 2]>,
    tolerances: Vec<[f64; 2]>,
}

impl Charts<'_> {
    /// The chart of one column over another; none where the run has no such column.
    fn of(&mut self, over: &str, quantity: &str) -> Option<&mut Chart> {
        let columns = [over, quantity];
        let place = self.charts.iter().position(|chart| chart.columns == columns);
        let place = match place {
            Some(place) => place,
            None => {
                let dimension = |column: &str| self.outcome.dimensions.as_ref().and_then(|known| known.column(column));
                let axis = |column: &str| Axis {
                    label: column.replace('_', " "),
                    unit: dimension(column).map_or_else(String::new, unit),
                    ..Axis::default()
                };
                self.charts.push(Chart {
                    columns: columns.map(str::to_owned),
                    axes: columns.map(axis),
                    run: self.table.pairs(over, quantity)?,
                    references: Vec::new(),
                    expected: Vec::new(),
                    tolerances: Vec::new(),
                });
                self.charts.len() - 1
            }
        };
        self.charts.get_mut(place)
    }
}

impl Chart {
    /// Marks what is expected at a point, and how far from it is allowed along each axis.
    fn expect(&mut self, [x, y]: [f64; 2], [dx, dy]: [f64; 2]) {
        self.expected.extend([[x, y], [f64::NAN; 2]]);
        self.tolerances.extend([[x - dx, y - dy], [x + dx, y + dy], [f64::NAN; 2]]);
    }

    fn panel(self) -> Panel {
        let [x, y] = self.axes;
        let run = Curve { label: "this run".to_owned(), points: self.run, ..Curve::default() };
        let expected = Curve {
            label: "expected".to_owned(),
            colour: 1,
            dash: 1,
            is_dotted: true,
            points: self.expected,
            ..Curve::default()
        };
        let tolerances = Curve { colour: 1, points: self.tolerances, ..Curve::default() };
        let is_drawn = |curve: &Curve| !curve.points.is_empty();
        let curves = [run].into_iter().chain(self.references).chain([tolerances, expected]).filter(is_drawn).collect();
        Panel { x, y, curves, ..Panel::default() }
    }
}

/// The body at the end.
struct Picture {
    /// PNG in base 64.
    png: String,
    /// What its colours are.
    caption: String,
}

/// Fields that a body shows, in words and with their units: the first that is not the same everywhere.
const SHOWN: [(&str, &str, &str); 2] =
    [("equivalent_plastic_strain", "equivalent plastic strain", ""), ("von_mises_stress", "von Mises stress", " Pa")];
/// Values that differ by less than this part of them are the same but for rounding.
const SAME: f64 = 1e-6;

/// The body at the end; none where there is nothing to show.
fn picture(case: &Case, results: &Path) -> Option<Picture> {
    let mut frames: Vec<PathBuf> =
        std::fs::read_dir(results.join("fields")).ok()?.filter_map(|entry| Some(entry.ok()?.path())).collect();
    frames.sort();
    let frame = series::read(frames.last()?).ok()?;
    let surfaces = || {
        SHOWN.iter().filter_map(|(field, words, unit)| {
            let surface = Surface::of(&frame, field, Part::Magnitude)?;
            let range = surface.range()?;
            Some((surface, range, words, unit))
        })
    };
    let varies = |[low, high]: [f64; 2]| high - low > SAME * low.abs().max(high.abs());
    let shown = surfaces().find(|(_, range, ..)| varies(*range)).or_else(|| surfaces().next());
    let (mut surface, [low, high], words, unit) = shown?;
    for axis in case.mirror.iter().filter_map(|name| ["x", "y", "z"].iter().position(|axis| axis == name)) {
        surface = surface.mirrored(axis);
    }
    let view = View { azimuth: 35.0, elevation: 25.0 };
    let style = Style { view, range: [low, high], has_edges: true };
    let window = Window::around(&surface, view);
    let raster = shaded::draw(&surface, &style, &window, [560, 420]);
    let caption = if varies([low, high]) {
        format!("The body at the end, {words} from {} to {}{unit}.", digits(low, 4), digits(high, 4))
    } else {
        format!("The body at the end, {words} {}{unit} everywhere.", digits(low, 4))
    };
    Some(Picture { png: STANDARD.encode(raster.png().ok()?), caption })
}

/// Text between backticks as code.
fn with_code(text: &str) -> String {
    let pieces = text.split('`').enumerate();
    pieces
        .map(|(index, piece)| if index % 2 == 1 { format!("<code>{}</code>", escaped(piece)) } else { escaped(piece) })
        .collect()
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// Date and time of seconds since 1970 began.
fn utc(seconds: u64) -> String {
    let (days, rest) = (seconds / 86_400, seconds % 86_400);
    // the calendar from the first of March of the year 0, in eras of 400 years (H. Hinnant, chrono-compatible date algorithms)
    let shifted = days + 719_468;
    let (era, day_of_era) = (shifted / 146_097, shifted % 146_097);
    let year_of_era = (day_of_era - day_of_era / 1460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
    let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let month_from_march = (5 * day_of_year + 2) / 153;
    let day = day_of_year - (153 * month_from_march + 2) / 5 + 1;
    let month = if month_from_march < 10 { month_from_march + 3 } else { month_from_march - 9 };
    let year = era * 400 + year_of_era + u64::from(month <= 2);
    format!("{year}-{month:02}-{day:02} {:02}:{:02}", rest / 3600, rest % 3600 / 60)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seconds_become_dates() {
        assert_eq!(utc(0), "1970-01-01 00:00");
        assert_eq!(utc(951_827_696), "2000-02-29 12:34");
        assert_eq!(utc(1_798_675_199), "2026-12-30 23:59");
    }

    #[test]
    fn what_is_written_in_a_table_of_cases_is_text_and_no_page() {
        assert_eq!(with_code("`<a>` & b"), "<code>&lt;a&gt;</code> &amp; b");
    }
}
