//! Small plots of the last steps.

use egui::{Color32, FontId, Mesh, Pos2, Rect, Sense, Shape, Stroke, Ui, pos2, vec2};

const HEIGHT: f32 = 44.0;

/// How many stages a step has.
const STAGES: usize = drystone::Stage::ALL.len();
const BACK: Color32 = Color32::from_black_alpha(60);

/// Colors of the engine's stages, in their order.
pub(crate) const STAGE_COLORS: [Color32; STAGES] = [
    Color32::from_rgb(111, 143, 168),
    Color32::from_rgb(222, 196, 148),
    Color32::from_rgb(143, 169, 139),
    Color32::from_rgb(120, 190, 180),
    Color32::from_rgb(226, 122, 82),
    Color32::from_rgb(107, 154, 190),
    Color32::from_rgb(201, 155, 74),
    Color32::from_rgb(160, 120, 180),
    Color32::from_rgb(190, 190, 190),
    Color32::from_rgb(205, 96, 108),
];

/// Draws values from left to right over their range; `text` is their name and the last one.
pub(crate) fn plot(ui: &mut Ui, text: &str, values: impl Iterator<Item = f32> + Clone) {
    let rect = back(ui);
    let painter = ui.painter_at(rect);
    let points = places(rect.shrink2(vec2(2.0, 4.0)), values);
    painter.line(points, Stroke::new(1.3, Color32::from_rgb(226, 164, 92)));
    label(ui, rect, text);
}

/// Draws what adds up, from zero to the greatest sum, each part in its color.
pub(crate) fn stacked(
    ui: &mut Ui,
    text: &str,
    columns: impl ExactSizeIterator<Item = [f32; STAGES]> + Clone,
) {
    let rect = back(ui);
    let most = columns.clone().map(|c| c.iter().sum::<f32>()).fold(1.0e-6, f32::max);
    #[expect(clippy::cast_precision_loss, reason = "some hundred columns")]
    let width = rect.width() / columns.len().max(1) as f32;
    let mut mesh = Mesh::default();
    let mut x = rect.left();
    for column in columns {
        let mut y = rect.bottom();
        for (part, color) in column.into_iter().zip(STAGE_COLORS) {
            let high = (part / most).clamp(0.0, 1.0) * rect.height();
            if high > 0.05 {
                let bar = Rect::from_min_max(pos2(x, y - high), pos2(x + width, y));
                mesh.add_colored_rect(bar, color);
            }
            y -= high;
        }
        x += width;
    }
    ui.painter_at(rect).add(Shape::mesh(mesh));
    label(ui, rect, text);
}

fn back(ui: &mut Ui) -> Rect {
    let size = vec2(ui.available_width(), HEIGHT);
    let (rect, _) = ui.allocate_exact_size(size, Sense::hover());
    ui.painter_at(rect).rect_filled(rect, 3.0, BACK);
    rect
}

fn label(ui: &Ui, rect: Rect, text: &str) {
    let painter = ui.painter_at(rect);
    let at = rect.left_top() + vec2(4.0, 2.0);
    let font = FontId::proportional(11.0);
    let galley = painter.layout_no_wrap(text.to_owned(), font, Color32::from_gray(232));
    let behind = Rect::from_min_size(at, galley.size()).expand(1.5);
    painter.rect_filled(behind, 2.0, Color32::from_black_alpha(130));
    painter.galley(at, galley, Color32::WHITE);
}

fn places(rect: Rect, values: impl Iterator<Item = f32> + Clone) -> Vec<Pos2> {
    let finite = values.filter(|v| v.is_finite());
    let (low, high) =
        finite.clone().fold((f32::INFINITY, f32::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
    // Numbers that differ only in their last digits are a level line.
    let range = (high - low).max(1.0e-4 * high.abs().max(low.abs())).max(1.0e-12);
    let count = finite.clone().count().max(2);
    #[expect(clippy::cast_precision_loss, reason = "some hundred values")]
    let step = rect.width() / (count - 1) as f32;
    let mut x = rect.left();
    finite
        .map(|v| {
            let at = Pos2::new(x, rect.bottom() - (v - low) / range * rect.height());
            x += step;
            at
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use egui::{Rect, pos2};

    use super::places;

    #[test]
    fn plots_span_their_rectangle_whatever_the_values() {
        let rect = Rect::from_min_max(pos2(0.0, 0.0), pos2(100.0, 50.0));
        let points = places(rect, [1.0, 3.0, f32::NAN, 2.0].into_iter());
        assert_eq!(points, [pos2(0.0, 50.0), pos2(50.0, 0.0), pos2(100.0, 25.0)]);
        assert_eq!(places(rect, [7.0; 2].into_iter())[1], pos2(100.0, 50.0));
        assert!(places(rect, [].into_iter()).is_empty());
    }
}
