//! Small charts as SVG text and as pixels.

mod raster;

use crate::image::text::FONT_FILE;
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::register_font;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use raster::Raster;

/// The font's name in SVG text, where the viewer chooses one.
const FONT: &str = "sans-serif";

/// Blue, vermillion, green, black, purple, sky, orange: distinguishable with colour blindness
/// (Okabe and Ito, 2008).
pub(crate) const COLORS: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(40, 40, 40),
    RGBColor(204, 121, 167),
    RGBColor(86, 180, 233),
    RGBColor(230, 159, 0),
];

/// How an axis is divided.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Scale {
    /// Equal steps.
    Linear,
    /// Powers of ten.
    Decades,
    /// Powers of two.
    Octaves,
}

/// One axis.
#[derive(Debug, Clone)]
pub(crate) struct Axis {
    /// What it measures.
    pub label: &'static str,
    /// Least and greatest value shown.
    pub range: [f64; 2],
    /// How it is divided.
    pub scale: Scale,
}

impl Axis {
    /// An axis that shows all of `values` that it can show, from one whole step to another.
    pub(crate) fn around(label: &'static str, scale: Scale, values: impl IntoIterator<Item = f64>) -> Axis {
        let empty = Axis { label, range: [f64::NAN; 2], scale };
        let places = values.into_iter().map(|x| empty.place(x)).filter(|p| p.is_finite());
        let (low, high) =
            places.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)));
        let (low, high) = if low <= high { (low.floor(), high.ceil()) } else { (0.0, 1.0) };
        let back = |place: f64| match scale {
            Scale::Linear => place,
            Scale::Decades => 10f64.powf(place),
            Scale::Octaves => place.exp2(),
        };
        Axis { range: [back(low), back(high.max(low + 1.0))], ..empty }
    }

    fn place(&self, x: f64) -> f64 {
        match self.scale {
            Scale::Linear => x,
            Scale::Decades => x.log10(),
            Scale::Octaves => x.log2(),
        }
    }

    fn name(&self, place: f64) -> String {
        let whole = (place - place.round()).abs() < 1e-6;
        match self.scale {
            Scale::Linear => format!("{place}"),
            _ if !whole => String::new(),
            Scale::Octaves if place >= 0.0 => format!("{}", place.round().exp2()),
            Scale::Octaves => format!("1/{}", (-place.round()).exp2()),
            Scale::Decades if (-2.5..3.5).contains(&place) => format!("{}", 10f64.powf(place.round())),
            Scale::Decades => format!("1e{place:.0}"),
        }
    }

    /// Labels on whole decades or steps.
    fn labels(&self) -> usize {
        let [low, high] = self.range.map(|x| self.place(x));
        (high - low).round() as usize + 1
    }
}

/// How a line is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Look {
    /// Points marked.
    Marked,
    /// The same, thick: seen when another line covers it.
    Thick,
    /// No marks: a level or a prediction.
    Plain,
    /// Marks without a line: points in no order.
    Dots,
}

/// One line.
#[derive(Debug, Clone)]
pub(crate) struct Series {
    /// For the legend.
    pub name: String,
    /// Of [`COLORS`].
    pub color: usize,
    /// Points to mark; what cannot be shown on a decade axis is left out.
    pub points: Vec<(f64, f64)>,
    /// How it is drawn.
    pub look: Look,
}

/// Where the legend lies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Legend {
    /// At the top left.
    UpperLeft,
    /// At the top right.
    UpperRight,
    /// At the bottom left.
    LowerLeft,
}

/// Axes, lines, and a place marked on the x axis.
#[derive(Debug, Clone)]
pub(crate) struct Chart {
    /// Over the chart.
    pub title: &'static str,
    /// Across.
    pub x: Axis,
    /// Up.
    pub y: Axis,
    /// In the order of the legend.
    pub series: Vec<Series>,
    /// A vertical line and its name.
    pub mark: Option<(f64, &'static str)>,
    /// Where the names of the lines stand.
    pub legend: Legend,
}

/// Charts side by side.
///
/// # Errors
/// If plotters says so.
pub(crate) fn svg(charts: &[Chart], size: (u32, u32)) -> Result<String, String> {
    let mut text = String::new();
    all(charts, SVGBackend::with_string(&mut text, size), 1)?;
    Ok(text)
}

/// The same as 8-bit RGB rows, of twice the size each way.
///
/// # Errors
/// If plotters says so.
pub(crate) fn pixels(charts: &[Chart], size: (u32, u32)) -> Result<(u32, u32, Vec<u8>), String> {
    const ZOOM: u32 = 2;
    let (width, height) = (size.0 * ZOOM, size.1 * ZOOM);
    let mut rgb = vec![255; 3 * width as usize * height as usize];
    all(charts, Raster::new(&mut rgb, width, height), ZOOM)?;
    Ok((width, height, rgb))
}

/// Draws charts side by side, every length times `zoom`.
fn all<B: DrawingBackend<ErrorType: 'static>>(charts: &[Chart], backend: B, zoom: u32) -> Result<(), String> {
    // plotters lays legends and labels out by the widths of this font, in SVG text too.
    register_font(FONT, FontStyle::Normal, FONT_FILE)
        .map_err(|_| "plotters cannot read the embedded font")?;
    let root = backend.into_drawing_area();
    root.fill(&WHITE).map_err(|e| e.to_string())?;
    for (chart, area) in charts.iter().zip(root.split_evenly((1, charts.len().max(1)))) {
        draw(chart, &area, zoom).map_err(|e| e.to_string())?;
    }
    root.present().map_err(|e| e.to_string())
}

type Drawn<B> = Result<(), DrawingAreaErrorKind<<B as DrawingBackend>::ErrorType>>;

fn draw<B: DrawingBackend<ErrorType: 'static>>(
    chart: &Chart,
    area: &DrawingArea<B, Shift>,
    zoom: u32,
) -> Drawn<B> {
    let range = |axis: &Axis| {
        let [low, high] = axis.range.map(|x| axis.place(x));
        low..high
    };
    let font = |size: u32| (FONT, size * zoom);
    let mut context = ChartBuilder::on(area)
        .caption(chart.title, font(16))
        .margin(12 * zoom)
        .x_label_area_size(38 * zoom)
        .y_label_area_size(54 * zoom)
        .build_cartesian_2d(range(&chart.x), range(&chart.y))?;
    context
        .configure_mesh()
        .x_desc(chart.x.label)
        .y_desc(chart.y.label)
        .x_labels(chart.x.labels())
        .y_labels(chart.y.labels())
        .x_max_light_lines(1)
        .y_max_light_lines(1)
        .x_label_formatter(&|x| chart.x.name(*x))
        .y_label_formatter(&|y| chart.y.name(*y))
        .label_style(font(13))
        .axis_desc_style(font(14))
        .draw()?;
    if let Some((at, name)) = chart.mark {
        let (x, [low, high]) = (chart.x.place(at), chart.y.range.map(|y| chart.y.place(y)));
        let line =
            PathElement::new(vec![(x, low), (x, high)], RGBColor(150, 150, 150).stroke_width(2 * zoom));
        context.draw_series([line])?;
        let style = font(13).into_font().color(&RGBColor(90, 90, 90));
        let end = style.pos(Pos::new(HPos::Right, VPos::Bottom));
        let spot = (x - 0.01 * (chart.x.place(chart.x.range[1]) - chart.x.place(chart.x.range[0])), low);
        context.draw_series([Text::new(name, spot, end)])?;
    }
    for series in &chart.series {
        let color = COLORS[series.color % COLORS.len()];
        let points: Vec<(f64, f64)> = series
            .points
            .iter()
            .map(|p| (chart.x.place(p.0), chart.y.place(p.1)))
            .filter(|p| p.0.is_finite() && p.1.is_finite())
            .collect();
        let (width, radius) = match series.look {
            Look::Marked => (2, 3),
            Look::Thick => (6, 6),
            Look::Plain => (1, 0),
            Look::Dots => (0, 3),
        };
        let (stroke, reach) = (color.stroke_width(width * zoom), 18 * zoom as i32);
        let dots = |points: Vec<(f64, f64)>| {
            points.into_iter().map(move |p| Circle::new(p, radius * zoom, color.filled()))
        };
        if series.look == Look::Dots {
            let middle = reach / 2;
            context
                .draw_series(dots(points))?
                .label(series.name.clone())
                .legend(move |(x, y)| Circle::new((x + middle, y), radius * zoom, color.filled()));
            continue;
        }
        context
            .draw_series(LineSeries::new(points.clone(), stroke))?
            .label(series.name.clone())
            .legend(move |(x, y)| PathElement::new([(x, y), (x + reach, y)], stroke));
        if radius > 0 {
            context.draw_series(dots(points))?;
        }
    }
    let place = match chart.legend {
        Legend::UpperLeft => SeriesLabelPosition::UpperLeft,
        Legend::UpperRight => SeriesLabelPosition::UpperRight,
        Legend::LowerLeft => SeriesLabelPosition::LowerLeft,
    };
    context
        .configure_series_labels()
        .position(place)
        .legend_area_size(30 * zoom)
        .background_style(WHITE.mix(0.85))
        .border_style(RGBColor(200, 200, 200))
        .label_font(font(13))
        .draw()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn axis(scale: Scale) -> Axis {
        Axis { label: "x", range: [1e-3, 1.0], scale }
    }

    fn chart(points: Vec<(f64, f64)>) -> Chart {
        let (x, y) = (axis(Scale::Decades), axis(Scale::Decades));
        let series = vec![Series { name: "measured".into(), color: 0, points, look: Look::Marked }];
        Chart { title: "t", x, y, series, mark: Some((0.1, "here")), legend: Legend::UpperLeft }
    }

    #[test]
    fn decades_are_named_and_places_between_are_not() {
        let names = [-3.0, -2.5, -1.0, 0.0, 3.0].map(|place| axis(Scale::Decades).name(place));
        assert_eq!(names, ["1e-3", "", "0.1", "1", "1000"]);
        assert_eq!((axis(Scale::Decades).labels(), axis(Scale::Decades).place(1e-3)), (4, -3.0));
        assert_eq!([-1.0, 0.5, 0.0, 8.0].map(|p| axis(Scale::Octaves).name(p)), ["1/2", "", "1", "256"]);
    }

    #[test]
    fn an_axis_around_values_shows_them_all_and_has_a_length() {
        let around = |scale, values: &[f64]| Axis::around("x", scale, values.iter().copied()).range;
        assert_eq!(around(Scale::Decades, &[0.02, 0.5, 0.0]), [0.01, 1.0]);
        assert_eq!(around(Scale::Octaves, &[1.0, 3.0]), [1.0, 4.0]);
        assert_eq!(around(Scale::Linear, &[2.0]), [2.0, 3.0]);
        assert_eq!(around(Scale::Decades, &[]), [1.0, 10.0]);
    }

    #[test]
    fn a_zero_on_a_decade_axis_is_left_out_not_drawn_wrong() {
        let with = svg(&[chart(vec![(0.01, 0.1), (0.1, 0.0)])], (400, 300)).unwrap();
        let without = svg(&[chart(vec![(0.01, 0.1)])], (400, 300)).unwrap();
        assert_eq!(with, without);
        assert!(with.starts_with("<svg") && with.contains("measured") && with.contains("here"));
        assert!(!with.contains("NaN") && !with.contains("inf\""));
    }

    #[test]
    fn pixels_show_the_points_where_the_svg_does() {
        let (width, height, rgb) = pixels(&[chart(vec![(0.01, 0.1)])], (400, 300)).unwrap();
        assert_eq!((width, height, rgb.len()), (800, 600, 800 * 600 * 3));
        let svg = svg(&[chart(vec![(0.01, 0.1)])], (400, 300)).unwrap();
        let circle = svg.split("<circle ").nth(1).unwrap();
        let value = |name: &str| {
            let text = circle.split(&format!("{name}=\"")).nth(1).unwrap().split('"').next().unwrap();
            2 * text.parse::<usize>().unwrap()
        };
        // Labels of another font move the axes by a few pixels.
        let near = |at: usize| (at - 12)..(at + 12);
        let blue = |x: usize, y: usize| rgb[3 * (y * 800 + x)..][..3] == [0, 114, 178];
        let found = near(value("cy")).flat_map(|y| near(value("cx")).map(move |x| (x, y)));
        assert!(found.filter(|(x, y)| blue(*x, *y)).count() > 60);
        let dark = rgb.as_chunks::<3>().0.iter().filter(|p| p.iter().all(|c| *c < 60)).count();
        assert!(dark > 500, "text is drawn: {dark}");
    }
}
