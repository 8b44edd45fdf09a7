//! Small line charts as SVG text.

use plotters::coord::Shift;
use plotters::prelude::*;

/// Blue, orange, green, black: told apart by the colour-blind too (Okabe and Ito, 2008).
pub(super) const COLORS: [RGBColor; 4] =
    [RGBColor(0, 114, 178), RGBColor(213, 94, 0), RGBColor(0, 158, 115), RGBColor(40, 40, 40)];

/// One axis.
#[derive(Debug, Clone)]
pub(super) struct Axis {
    /// What it measures.
    pub label: &'static str,
    /// Least and greatest value shown.
    pub range: [f64; 2],
    /// Decades instead of steps.
    pub log: bool,
}

impl Axis {
    fn place(&self, x: f64) -> f64 {
        if self.log { x.log10() } else { x }
    }

    fn name(&self, place: f64) -> String {
        if !self.log {
            format!("{place}")
        } else if (place - place.round()).abs() > 1e-6 {
            String::new()
        } else if (-2.5..3.5).contains(&place) {
            format!("{}", 10f64.powf(place.round()))
        } else {
            format!("1e{place:.0}")
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
pub(super) enum Look {
    /// Points marked.
    Marked,
    /// The same, thick: seen when another line covers it.
    Thick,
    /// No marks: a level or a prediction.
    Plain,
}

/// One line.
#[derive(Debug, Clone)]
pub(super) struct Series {
    /// For the legend.
    pub name: String,
    /// Of [`COLORS`].
    pub color: usize,
    /// Points to mark; what cannot be shown on a decade axis is left out.
    pub points: Vec<(f64, f64)>,
    /// How it is drawn.
    pub look: Look,
}

/// Axes, lines, and a place marked on the x axis.
#[derive(Debug, Clone)]
pub(super) struct Chart {
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
    /// The legend lies at the bottom, not at the top.
    pub legend_low: bool,
}

/// Charts side by side.
///
/// # Errors
/// If plotters says so.
pub(super) fn svg(charts: &[Chart], size: (u32, u32)) -> Result<String, String> {
    let mut text = String::new();
    {
        let root = SVGBackend::with_string(&mut text, size).into_drawing_area();
        root.fill(&WHITE).map_err(|e| e.to_string())?;
        for (chart, area) in charts.iter().zip(root.split_evenly((1, charts.len().max(1)))) {
            draw(chart, &area)?;
        }
        root.present().map_err(|e| e.to_string())?;
    }
    Ok(text)
}

fn draw(chart: &Chart, area: &DrawingArea<SVGBackend<'_>, Shift>) -> Result<(), String> {
    let range = |axis: &Axis| {
        let [low, high] = axis.range.map(|x| axis.place(x));
        low..high
    };
    let mut context = ChartBuilder::on(area)
        .caption(chart.title, ("sans-serif", 16))
        .margin(12)
        .x_label_area_size(38)
        .y_label_area_size(54)
        .build_cartesian_2d(range(&chart.x), range(&chart.y))
        .map_err(|e| e.to_string())?;
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
        .label_style(("sans-serif", 13))
        .axis_desc_style(("sans-serif", 14))
        .draw()
        .map_err(|e| e.to_string())?;
    if let Some((at, name)) = chart.mark {
        let (x, [low, high]) = (chart.x.place(at), chart.y.range.map(|y| chart.y.place(y)));
        let line = PathElement::new(vec![(x, low), (x, high)], RGBColor(150, 150, 150).stroke_width(2));
        context.draw_series([line]).map_err(|e| e.to_string())?;
        let style = ("sans-serif", 13).into_font().color(&RGBColor(90, 90, 90));
        let end = style.pos(plotters::style::text_anchor::Pos::new(
            plotters::style::text_anchor::HPos::Right,
            plotters::style::text_anchor::VPos::Bottom,
        ));
        let spot = (x - 0.01 * (chart.x.place(chart.x.range[1]) - chart.x.place(chart.x.range[0])), low);
        context.draw_series([Text::new(name, spot, end)]).map_err(|e| e.to_string())?;
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
        };
        context
            .draw_series(LineSeries::new(points.clone(), color.stroke_width(width)))
            .map_err(|e| e.to_string())?
            .label(series.name.clone())
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 18, y)], color.stroke_width(width)));
        if radius > 0 {
            context
                .draw_series(points.into_iter().map(|p| Circle::new(p, radius, color.filled())))
                .map_err(|e| e.to_string())?;
        }
    }
    let place =
        if chart.legend_low { SeriesLabelPosition::LowerLeft } else { SeriesLabelPosition::UpperLeft };
    context
        .configure_series_labels()
        .position(place)
        .background_style(WHITE.mix(0.85))
        .border_style(RGBColor(200, 200, 200))
        .label_font(("sans-serif", 13))
        .draw()
        .map_err(|e| e.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn axis(log: bool) -> Axis {
        Axis { label: "x", range: [1e-3, 1.0], log }
    }

    #[test]
    fn decades_are_named_and_places_between_are_not() {
        let names = [-3.0, -2.5, -1.0, 0.0, 3.0].map(|place| axis(true).name(place));
        assert_eq!(names, ["1e-3", "", "0.1", "1", "1000"]);
        assert_eq!((axis(true).labels(), axis(true).place(1e-3)), (4, -3.0));
    }

    #[test]
    fn a_zero_on_a_decade_axis_is_left_out_not_drawn_wrong() {
        let series = |points| Series { name: "measured".into(), color: 0, points, look: Look::Marked };
        let chart = |points| Chart {
            title: "t",
            x: axis(true),
            y: axis(true),
            series: vec![series(points)],
            mark: Some((0.1, "here")),
            legend_low: false,
        };
        let with = svg(&[chart(vec![(0.01, 0.1), (0.1, 0.0)])], (400, 300)).unwrap();
        let without = svg(&[chart(vec![(0.01, 0.1)])], (400, 300)).unwrap();
        assert_eq!(with, without);
        assert!(with.starts_with("<svg") && with.contains("measured") && with.contains("here"));
        assert!(!with.contains("NaN") && !with.contains("inf\""));
    }
}
