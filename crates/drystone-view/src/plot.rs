//! A small plot of the last steps.

use egui::{Color32, Pos2, Rect, Sense, Stroke, Ui, vec2};

/// Draws values from left to right over their range; `text` says what they are and the last one.
pub(crate) fn plot(ui: &mut Ui, text: &str, values: impl Iterator<Item = f32> + Clone) {
    let size = vec2(ui.available_width(), 44.0);
    let (rect, _) = ui.allocate_exact_size(size, Sense::hover());
    let painter = ui.painter_at(rect);
    painter.rect_filled(rect, 3.0, Color32::from_black_alpha(40));
    let points = places(rect.shrink2(vec2(2.0, 4.0)), values);
    painter.line(points, Stroke::new(1.3, Color32::from_rgb(226, 164, 92)));
    let font = egui::FontId::proportional(11.0);
    let at = rect.left_top() + vec2(4.0, 2.0);
    painter.text(at, egui::Align2::LEFT_TOP, text, font, Color32::from_gray(225));
}

fn places(rect: Rect, values: impl Iterator<Item = f32> + Clone) -> Vec<Pos2> {
    let finite = values.filter(|v| v.is_finite());
    let (low, high) =
        finite.clone().fold((f32::INFINITY, f32::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
    // What only wavers in its last digits is a level line.
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
