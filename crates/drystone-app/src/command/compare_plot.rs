//! The plot of a comparison: overlap and kinetic energy over time, as SVG or PNG, on scales of
//! powers of ten.

use std::fmt::Write as _;

use resvg::{tiny_skia, usvg};

use crate::output::{Failure, one_line};

/// Points of a curve, about.
pub(crate) const POINTS: u64 = 400;

/// The curve of a run.
#[derive(Debug)]
pub(crate) struct Curve {
    name: String,
    /// Time [s], deepest overlap [m], kinetic energy [J].
    points: Vec<[f64; 3]>,
}

impl Curve {
    /// Nothing yet.
    pub(crate) fn new(name: &str) -> Self {
        Self { name: name.to_owned(), points: Vec::new() }
    }

    /// A moment of the run.
    pub(crate) fn push(&mut self, seconds: f64, penetration: f64, kinetic: f64) {
        self.points.push([seconds, penetration, kinetic]);
    }
}

const WIDTH: f64 = 760.0;
const HEIGHT: f64 = 240.0;
const LEFT: f64 = 90.0;
const COLORS: [&str; 10] = [
    "#1f77b4", "#d62728", "#2ca02c", "#9467bd", "#ff7f0e", "#17becf", "#8c564b", "#7f7f7f",
    "#e377c2", "#bcbd22",
];

/// The page: two panels and a legend.
pub(crate) fn svg(scene: &str, curves: &[Curve]) -> String {
    let row = 18.0;
    let legend = row * rows_as_f64(curves.len());
    let (width, height) = (LEFT + WIDTH + 20.0, 2.0 * (HEIGHT + 60.0) + legend + 40.0);
    let mut text = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} {height}\" \
         font-family=\"sans-serif\" font-size=\"12\">\n<rect width=\"{width}\" height=\"{height}\" \
         fill=\"white\"/>\n<text x=\"{LEFT}\" y=\"20\" font-size=\"15\">{}</text>\n",
        escaped(scene)
    );
    panel(&mut text, 40.0, "deepest overlap [m]", curves, 1);
    panel(&mut text, 40.0 + HEIGHT + 60.0, "kinetic energy [J]", curves, 2);
    for (i, curve) in curves.iter().enumerate() {
        let y = 2.0 * (HEIGHT + 60.0) + 45.0 + row * rows_as_f64(i);
        let _ = writeln!(
            text,
            "<rect x=\"{LEFT}\" y=\"{}\" width=\"14\" height=\"4\" fill=\"{}\"/>\
             <text x=\"{}\" y=\"{y}\">{}</text>",
            y - 6.0,
            COLORS[i % COLORS.len()],
            LEFT + 20.0,
            escaped(&curve.name)
        );
    }
    text.push_str("</svg>\n");
    text
}

/// The same page as PNG, with letters that come with the program: the same picture on every
/// machine.
pub(crate) fn png(svg: &str) -> Result<Vec<u8>, Failure> {
    let failed = |e: &dyn std::fmt::Display| Failure::failed(format_args!("plot: {e}"));
    let mut fonts = usvg::fontdb::Database::new();
    fonts.load_font_data(epaint_default_fonts::UBUNTU_LIGHT.to_vec());
    let family = fonts.faces().next().and_then(|face| face.families.first());
    let family = family.map(|(name, _)| name.clone()).unwrap_or_default();
    fonts.set_sans_serif_family(family.clone());
    let options =
        usvg::Options { font_family: family, fontdb: fonts.into(), ..usvg::Options::default() };
    let tree = usvg::Tree::from_str(svg, &options).map_err(|e| failed(&e))?;
    let size = tree.size().to_int_size();
    let (width, height) = (2 * size.width(), 2 * size.height());
    let mut picture = tiny_skia::Pixmap::new(width, height).ok_or_else(|| failed(&"no size"))?;
    resvg::render(&tree, tiny_skia::Transform::from_scale(2.0, 2.0), &mut picture.as_mut());
    picture.encode_png().map_err(|e| failed(&e))
}

/// One quantity of all curves; values below the lowest power of ten shown lie on the axis.
fn panel(text: &mut String, top: f64, title: &str, curves: &[Curve], column: usize) {
    let values = || {
        curves
            .iter()
            .flat_map(|c| &c.points)
            .map(|p| p[column])
            .filter(|v| v.is_finite() && *v > 0.0)
    };
    let end = curves.iter().filter_map(|c| c.points.last()).map(|p| p[0]).fold(0.0, f64::max);
    let most = values().fold(1.0e-9, f64::max).log10().ceil();
    let least = values().fold(f64::INFINITY, f64::min).log10().floor().max(most - 8.0);
    let least = if least < most { least } else { most - 1.0 };
    let y = |v: f64| {
        let part = ((v.max(1.0e-300).log10() - least) / (most - least)).clamp(0.0, 1.0);
        top + HEIGHT * (1.0 - part)
    };
    let x = |t: f64| LEFT + WIDTH * if end > 0.0 { t / end } else { 0.0 };
    let _ = writeln!(
        text,
        "<rect x=\"{LEFT}\" y=\"{top}\" width=\"{WIDTH}\" height=\"{HEIGHT}\" fill=\"none\" \
         stroke=\"#888\"/>\n<text x=\"{LEFT}\" y=\"{}\">{title}</text>",
        top - 6.0
    );
    let mut power = least;
    while power <= most {
        let at = y(10.0_f64.powf(power));
        let _ = writeln!(
            text,
            "<line x1=\"{LEFT}\" x2=\"{}\" y1=\"{at:.1}\" y2=\"{at:.1}\" stroke=\"#ddd\"/>\
             <text x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">1e{power}</text>",
            LEFT + WIDTH,
            LEFT - 6.0,
            at + 4.0
        );
        power += 1.0;
    }
    let _ = writeln!(
        text,
        "<text x=\"{LEFT}\" y=\"{0}\">0 s</text><text x=\"{1}\" y=\"{0}\" \
         text-anchor=\"end\">{end:.2} s</text>",
        top + HEIGHT + 16.0,
        LEFT + WIDTH
    );
    for (i, curve) in curves.iter().enumerate() {
        let points = curve.points.iter().filter(|p| p[column].is_finite());
        let line: Vec<String> =
            points.map(|p| format!("{:.1},{:.1}", x(p[0]), y(p[column]))).collect();
        let _ = writeln!(
            text,
            "<polyline fill=\"none\" stroke=\"{}\" stroke-width=\"1.5\" points=\"{}\"/>",
            COLORS[i % COLORS.len()],
            line.join(" ")
        );
    }
}

fn rows_as_f64(n: usize) -> f64 {
    drystone_bench::count_as_f64(n)
}

fn escaped(text: &str) -> String {
    one_line(text).replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

#[cfg(test)]
mod tests {
    use super::{Curve, png, svg};

    #[test]
    fn curves_stay_in_their_panels_and_names_are_escaped() {
        let mut curve = Curve::new("a<b>&c");
        for i in 0..5 {
            curve.push(f64::from(i), 1.0e-3, if i == 2 { f64::NAN } else { 0.0 });
        }
        let page = svg("stack", &[curve, Curve::new("empty")]);
        assert!(page.contains("a&lt;b&gt;&amp;c") && !page.contains("NaN"));
        assert_eq!(page.matches("<polyline").count(), 4);
        let picture = png(&page).unwrap();
        assert!(picture.starts_with(b"\x89PNG") && picture.len() > 5_000, "{}", picture.len());
    }
}
