//! Charts as SVG: curves over two axes, linear or logarithmic, as part of a page or as a file of
//! its own.

use crate::text::grouped;
use std::fmt::Write;

// Lengths are in the units of the SVG, pixels at its natural size; all are chosen by hand.

/// Width of a chart without its legend.
const WIDTH: f64 = 460.0;
/// Height of a chart.
const HEIGHT: f64 = 260.0;
/// Room for the labels: left, right, top, bottom.
const MARGINS: [f64; 4] = [58.0, 16.0, 12.0, 40.0];
/// Further room at the left for the upright label of the y axis, which only files have.
const UPRIGHT_LABEL: f64 = 16.0;
/// Width of the legend with the names of several curves.
const LEGEND_WIDTH: f64 = 168.0;
/// Height of a line of the legend.
const LEGEND_LINE: f64 = 17.0;
/// Colours of curves that most people can tell apart (Okabe and Ito 2008).
const COLOURS: [&str; 7] =
    ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#555555"];
/// The style sheet of a chart that is a file of its own: the same as in `page.css`.
const STYLE: &str = "text{font:11px sans-serif;fill:#333;text-anchor:middle}\
    .left{text-anchor:end}.name{text-anchor:start}.grid{stroke:#ddd}\
    .curve{fill:none;stroke-width:1.6}.dashed{stroke-dasharray:5 3}";

/// Structures in the order of their colours.
const COLOURED: [&str; 6] =
    ["speed", "masking", "interactive", "progressive_mesh", "lodstrips", "discrete"];

/// The number of the colour of a structure, the same in all charts; one for all unknown ones.
pub fn colour_of(structure: &str) -> usize {
    COLOURED.iter().position(|&name| name == structure).unwrap_or(COLOURED.len())
}

/// The spacing of an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// From 0 on.
    Linear,
    /// Powers of ten. Values that are not above 0 are left out.
    Log,
}

/// One curve.
#[derive(Clone, Debug)]
pub struct Curve {
    /// Its name beside the chart, where there are several.
    pub name: String,
    /// Number of its colour.
    pub colour: usize,
    /// Dashed, not solid.
    pub dashed: bool,
    /// x and y.
    pub points: Vec<[f64; 2]>,
}

/// A chart of one or more curves.
#[derive(Clone, Debug)]
pub struct Chart<'a> {
    /// Labels of x and y.
    pub labels: [&'a str; 2],
    /// Scales of x and y.
    pub scales: [Scale; 2],
    /// One or more.
    pub curves: Vec<Curve>,
}

/// The range of an axis.
struct Axis {
    scale: Scale,
    low: f64,
    high: f64,
}

impl Axis {
    /// An axis between round numbers around all values.
    fn around(scale: Scale, values: impl Iterator<Item = f64>) -> Self {
        let (low, high) = values.fold((f64::INFINITY, 0.0_f64), |(l, h), v| (l.min(v), h.max(v)));
        if scale == Scale::Linear {
            let step = step(high);
            return Self { scale, low: 0.0, high: ((high / step).ceil() * step).max(step) };
        }
        let low = 10_f64.powf(low.log10().floor());
        Self { scale, low, high: 10_f64.powf(high.log10().ceil()).max(low * 10.0) }
    }

    /// The position of a value between the ends, from 0 to 1.
    fn share(&self, value: f64) -> f64 {
        match self.scale {
            Scale::Linear => value / self.high,
            Scale::Log => (value / self.low).log10() / (self.high / self.low).log10(),
        }
    }

    /// Values with a grid line, at most about six of them, and their labels.
    fn ticks(&self) -> Vec<(f64, String)> {
        if self.scale == Scale::Linear {
            let step = step(self.high);
            let count = (self.high / step).round() as u32;
            return (0..=count)
                .map(|i| (f64::from(i) * step, linear(f64::from(i) * step)))
                .collect();
        }
        let [first, last] = [self.low, self.high].map(|v| v.log10().round() as i32);
        let every = ((last - first) / 6 + 1).max(1);
        let tick = |exponent| (10_f64.powi(exponent), power(exponent));
        (first..=last).step_by(every as usize).map(tick).collect()
    }
}

impl Chart<'_> {
    /// The chart as a part of a page, whose style sheet has the classes `curve`, `grid` and `left`.
    /// Empty if fewer than two points can be drawn.
    #[must_use]
    pub fn svg(&self) -> String {
        self.draw(MARGINS, "", "")
    }

    /// The chart as a file.
    #[must_use]
    pub fn file(&self) -> String {
        let style = format!(
            "<style>{STYLE}</style>\n<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n"
        );
        let [left, right, top, bottom] = MARGINS;
        let margins = [left + UPRIGHT_LABEL, right, top, bottom];
        self.draw(margins, " xmlns=\"http://www.w3.org/2000/svg\"", &style)
    }

    fn draw(&self, margins: [f64; 4], attributes: &str, style: &str) -> String {
        let [x_scale, y_scale] = self.scales;
        let fits = |v: f64, scale| v.is_finite() && (v > 0.0 || scale == Scale::Linear && v == 0.0);
        let usable = |p: &&[f64; 2]| fits(p[0], x_scale) && fits(p[1], y_scale);
        let all = || self.curves.iter().flat_map(|c| &c.points).filter(usable);
        if all().count() < 2 {
            return String::new();
        }
        let x = Axis::around(x_scale, all().map(|p| p[0]));
        let y = Axis::around(y_scale, all().map(|p| p[1]));
        let [left, right, top, bottom] = margins;
        let to_svg = |p: &[f64; 2]| {
            let across = left + x.share(p[0]) * (WIDTH - left - right);
            (across, HEIGHT - bottom - y.share(p[1]) * (HEIGHT - top - bottom))
        };
        let width = WIDTH + if self.curves.len() > 1 { LEGEND_WIDTH } else { 0.0 };
        let height = HEIGHT.max(top + LEGEND_LINE * (self.curves.len() + 1) as f64);
        let mut svg = format!("<svg{attributes} viewBox=\"0 0 {width} {height}\" role=\"img\">\n");
        // Writing to a string cannot fail.
        let _ = writeln!(svg, "<title>{} against {}</title>", self.labels[1], self.labels[0]);
        svg.push_str(style);
        self.grid(&mut svg, margins, [&x, &y], &to_svg);
        for (row, curve) in self.curves.iter().enumerate() {
            let mut path = String::new();
            for p in curve.points.iter().filter(usable) {
                let letter = if path.is_empty() { 'M' } else { 'L' };
                let (x, y) = to_svg(p);
                let _ = write!(path, "{letter}{x:.1} {y:.1}");
            }
            let dashed = if curve.dashed { " dashed" } else { "" };
            // The one curve of a page has the colour of the page.
            let colour = if style.is_empty() {
                String::new()
            } else {
                format!(" stroke=\"{}\"", COLOURS[curve.colour % COLOURS.len()])
            };
            let _ = writeln!(svg, "<path class=\"curve{dashed}\"{colour} d=\"{path}\"/>");
            if self.curves.len() > 1 {
                let (x, y) = (WIDTH + 6.0, top + LEGEND_LINE * (row as f64 + 0.5));
                let end = x + 22.0;
                let _ = writeln!(
                    svg,
                    "<path class=\"curve{dashed}\"{colour} d=\"M{x} {y}H{end}\"/>\n\
                     <text class=\"name\" x=\"{}\" y=\"{}\">{}</text>",
                    end + 6.0,
                    y + 4.0,
                    curve.name
                );
            }
        }
        svg.push_str("</svg>");
        svg.push('\n');
        svg
    }

    /// Lines and labels of both axes.
    fn grid(
        &self,
        svg: &mut String,
        margins: [f64; 4],
        [x, y]: [&Axis; 2],
        to_svg: &dyn Fn(&[f64; 2]) -> (f64, f64),
    ) {
        let [left, right, top, bottom] = margins;
        let (end, base) = (WIDTH - right, HEIGHT - bottom);
        // Writing to a string cannot fail.
        for (v, label) in x.ticks() {
            let (across, _) = to_svg(&[v, y.low]);
            let _ = writeln!(svg, "<path class=\"grid\" d=\"M{across:.1} {top}V{base}\"/>");
            let y = base + 16.0;
            let _ = writeln!(svg, "<text x=\"{across:.1}\" y=\"{y:.1}\">{label}</text>");
        }
        for (v, label) in y.ticks() {
            let (_, down) = to_svg(&[x.low, v]);
            let _ = writeln!(svg, "<path class=\"grid\" d=\"M{left} {down:.1}H{end}\"/>");
            let (x, y) = (left - 7.0, down + 4.0);
            let _ = writeln!(svg, "<text class=\"left\" x=\"{x}\" y=\"{y:.1}\">{label}</text>");
        }
        let ([across, up], middle) = (self.labels, f64::midpoint(left, end));
        let _ = writeln!(svg, "<text x=\"{middle}\" y=\"{}\">{across}</text>", HEIGHT - 6.0);
        if left > MARGINS[0] {
            let y = f64::midpoint(top, base);
            let _ = writeln!(svg, "<text transform=\"translate(12 {y}) rotate(-90)\">{up}</text>");
        }
    }
}

/// The distance of grid lines: 1, 2 or 5 times a power of ten, three to six of which reach `high`.
fn step(high: f64) -> f64 {
    if high <= 0.0 {
        return 1.0;
    }
    let power = 10_f64.powf((high / 6.0).log10().floor());
    [1.0, 2.0, 5.0, 10.0].map(|s| s * power).into_iter().find(|s| high / s <= 6.0).unwrap_or(power)
}

/// `0`, `0.05`, `1.5`, `20,000`.
fn linear(v: f64) -> String {
    if v >= 10.0 || v == 0.0 {
        return grouped(v.round() as u64);
    }
    let text = format!("{v:.4}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// `0.001`, `1`, `1,000`, `10⁻⁶`.
fn power(exponent: i32) -> String {
    match exponent {
        0..=6 => grouped(10_u64.pow(exponent as u32)),
        -3..0 => format!("{:.*}", -exponent as usize, 10_f64.powi(exponent)),
        _ => format!("10<tspan baseline-shift=\"super\" font-size=\"8\">{exponent}</tspan>"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chart(scales: [Scale; 2], points: &[[f64; 2]]) -> Chart<'static> {
        let curve =
            Curve { name: "a".to_owned(), colour: 0, dashed: false, points: points.to_vec() };
        Chart { labels: ["error", "triangles"], scales, curves: vec![curve] }
    }

    fn path(svg: &str) -> Option<&str> {
        svg.split("class=\"curve\"").nth(1)?.split("d=\"").nth(1)?.split('"').next()
    }

    #[test]
    fn a_chart_has_a_curve_within_its_frame() {
        let points = [[0.001, 1000.0], [1.0, 10.0], [0.0, 5.0]];
        let svg = chart([Scale::Log; 2], &points).svg();
        assert_eq!(path(&svg), Some("M58.0 12.0L444.0 220.0"));
        assert!(svg.contains("<title>triangles against error</title>"));
        let svg = chart([Scale::Linear; 2], &[[0.0, 0.0], [5.0, 60.0]]).file();
        assert_eq!(path(&svg), Some("M74.0 220.0L444.0 12.0"));
        assert!(svg.starts_with("<svg xmlns=") && svg.contains(">60</text>"));
    }

    #[test]
    fn what_has_no_two_points_has_no_chart() {
        let points = [[1.0, 1.0], [0.0, 2.0], [f64::NAN, 1.0]];
        assert_eq!(chart([Scale::Log; 2], &points).svg(), "");
    }

    #[test]
    fn several_curves_have_names() {
        let mut two = chart([Scale::Linear; 2], &[[1.0, 1.0], [2.0, 2.0]]);
        two.curves.push(Curve { name: "b".to_owned(), dashed: true, ..two.curves[0].clone() });
        let svg = two.file();
        assert!(svg.contains(">a</text>") && svg.contains(">b</text>") && svg.contains("dashed"));
    }
}
