//! Where on the screen things stand that can be clicked, for programs that drive the window.

use egui::{Context, Id, Rect, Response, Ui};

/// The name of something, and where it stands [points of the screen].
pub type Place = (String, Rect);

fn id() -> Id {
    Id::unique("places")
}

/// Notes where something stands in this picture.
pub(crate) fn note(ui: &Ui, name: &str, response: &Response) {
    note_rect(ui.ctx(), name, response.rect);
}

/// Notes where something stands in this picture.
pub(crate) fn note_rect(context: &Context, name: &str, rect: Rect) {
    context.data_mut(|data| {
        let places: &mut Vec<Place> = data.get_temp_mut_or_default(id());
        places.push((name.to_owned(), rect));
    });
}

/// The places that were noted since the last call.
#[must_use]
pub fn take(context: &Context) -> Vec<Place> {
    context.data_mut(|data| data.remove_temp(id()).unwrap_or_default())
}
