//! Charts as SVG: one curve over two logarithmic axes.

use std::fmt::Write;

const WIDTH: f64 = 460.0;
const HEIGHT: f64 = 260.0;
/// Room for the labels: left, right, top, bottom.
const MARGINS: [f64; 4] = [58.0, 16.0, 12.0, 40.0];

/// An axis: its label and the range of its values, both above 0.
struct Axis<'a> {
    label: &'a str,
    low: f64,
    high: f64,
}

impl<'a> Axis<'a> {
    /// Whole powers of ten around all values.
    fn around(label: &'a str, values: impl Iterator<Item = f64>) -> Self {
        let (low, high) = values.fold((f64::INFINITY, 0.0_f64), |(l, h), v| (l.min(v), h.max(v)));
        let low = 10_f64.powf(low.log10().floor());
        Self { label, low, high: 10_f64.powf(high.log10().ceil()).max(low * 10.0) }
    }

    /// The share of a value between the ends.
    fn share(&self, value: f64) -> f64 {
        (value / self.low).log10() / (self.high / self.low).log10()
    }

    /// Powers of ten, at most about six of them.
    fn ticks(&self) -> Vec<f64> {
        let [first, last] = [self.low, self.high].map(|v| v.log10().round() as i32);
        let every = ((last - first) / 6 + 1).max(1);
        (first..=last).step_by(every as usize).map(|power| 10_f64.powi(power)).collect()
    }
}

/// A chart of points (x, y); those that are not above 0 have no place on it. Empty if fewer than
/// two are left.
pub(super) fn chart(points: &[[f64; 2]], labels: [&str; 2]) -> String {
    let usable = |p: &&[f64; 2]| p.iter().all(|v| v.is_finite() && *v > 0.0);
    let points: Vec<[f64; 2]> = points.iter().filter(usable).copied().collect();
    if points.len() < 2 {
        return String::new();
    }
    let x = Axis::around(labels[0], points.iter().map(|p| p[0]));
    let y = Axis::around(labels[1], points.iter().map(|p| p[1]));
    let [left, right, top, bottom] = MARGINS;
    let at_x = |v: f64| left + x.share(v) * (WIDTH - left - right);
    let at_y = |v: f64| HEIGHT - bottom - y.share(v) * (HEIGHT - top - bottom);
    let mut svg = format!("<svg viewBox=\"0 0 {WIDTH} {HEIGHT}\" role=\"img\">\n");
    // Writing to a string cannot fail.
    let _ = writeln!(svg, "<title>{} against {}</title>", y.label, x.label);
    let (end, base) = (WIDTH - right, HEIGHT - bottom);
    for v in x.ticks() {
        let at = at_x(v);
        let _ = writeln!(svg, "<path class=\"grid\" d=\"M{at:.1} {top}V{base}\"/>");
        let _ = writeln!(svg, "<text x=\"{at:.1}\" y=\"{:.1}\">{}</text>", base + 16.0, power(v));
    }
    for v in y.ticks() {
        let at = at_y(v);
        let _ = writeln!(svg, "<path class=\"grid\" d=\"M{left} {at:.1}H{end}\"/>");
        let (label, down) = (power(v), at + 4.0);
        let _ = writeln!(
            svg,
            "<text class=\"left\" x=\"{}\" y=\"{down:.1}\">{label}</text>",
            left - 7.0
        );
    }
    let middle = (left + end) / 2.0;
    let _ = writeln!(svg, "<text x=\"{middle}\" y=\"{}\">{}</text>", HEIGHT - 6.0, x.label);
    let mut path = String::new();
    for p in &points {
        let letter = if path.is_empty() { 'M' } else { 'L' };
        let _ = write!(path, "{letter}{:.1} {:.1}", at_x(p[0]), at_y(p[1]));
    }
    let _ = writeln!(svg, "<path class=\"curve\" d=\"{path}\"/>\n</svg>");
    svg
}

/// `0.001`, `1`, `1,000`, `10⁻⁶`.
fn power(v: f64) -> String {
    let exponent = v.log10().round() as i32;
    match exponent {
        0..=6 => crate::text::grouped(10_u64.pow(exponent as u32)),
        -3..0 => format!("{:.*}", -exponent as usize, v),
        _ => format!("10<tspan baseline-shift=\"super\" font-size=\"8\">{exponent}</tspan>"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_chart_has_a_curve_within_its_frame() {
        let svg = chart(&[[0.001, 1000.0], [1.0, 10.0], [0.0, 5.0]], ["error", "triangles"]);
        let path = svg.split("class=\"curve\" d=\"").nth(1).and_then(|s| s.split('"').next());
        assert_eq!(path, Some("M58.0 12.0L444.0 220.0"));
        assert!(svg.contains("<title>triangles against error</title>"));
    }

    #[test]
    fn what_has_no_two_points_has_no_chart() {
        assert_eq!(chart(&[[1.0, 1.0], [0.0, 2.0], [f64::NAN, 1.0]], ["a", "b"]), "");
    }
}
