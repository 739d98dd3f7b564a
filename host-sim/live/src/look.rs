//! Fonts, background and colour scale, for every picture of a window or a page.

use eframe::egui::{
    Align2, Color32, Context, FontData, FontDefinitions, FontFamily, FontId, Mesh, Painter, Rect, Shape, pos2, vec2,
};

use crate::shown::{Colour, LEAST_J, Shown, scale, screen};

/// Width below which a picture has no room for hints beside its legend [points].
const LEAST_FOR_HINTS: f32 = 660.0;

/// Sets the font and the light theme.
pub fn dress(ctx: &Context) {
    let mut fonts = FontDefinitions::empty();
    let bytes = include_bytes!("../font/NotoSans-subset.ttf");
    fonts.font_data.insert("noto".into(), std::sync::Arc::new(FontData::from_static(bytes)));
    for family in [FontFamily::Proportional, FontFamily::Monospace] {
        fonts.families.insert(family, vec!["noto".into()]);
    }
    ctx.set_fonts(fonts);
    // less important text must still be readable, especially on a dark background
    ctx.all_styles_mut(|style| style.visuals.weak_text_alpha = 0.85);
    ctx.set_theme(eframe::egui::Theme::Light);
}

/// Paints the background behind the tissue, which is lighter at the top.
pub fn ground(painter: &Painter, rect: Rect, dark: bool) {
    let (low, high) = if dark { ((30, 34, 40), (44, 50, 58)) } else { ((236, 239, 243), (252, 253, 254)) };
    let ground = |c: (u8, u8, u8)| Color32::from_rgb(c.0, c.1, c.2);
    let mut mesh = Mesh::default();
    for (at, colour) in [(rect.left_top(), high), (rect.right_top(), high), (rect.right_bottom(), low), (rect.left_bottom(), low)]
    {
        mesh.colored_vertex(at, ground(colour));
    }
    mesh.add_triangle(0, 1, 2);
    mesh.add_triangle(0, 2, 3);
    painter.add(Shape::mesh(mesh));
}

/// Draws the colour scale, and a hint for the mouse if there is room.
pub fn legend(painter: &Painter, rect: Rect, shown: &Shown, how: &str) {
    let ink = if shown.dark { Color32::from_gray(225) } else { Color32::from_gray(50) };
    let (title, ends) = match shown.colour {
        Colour::Displacement => ("moved by, mm", ["0".into(), format!("{:.1}", shown.most_m * 1e3)]),
        Colour::Pressure => ("pressure, kPa", ["0".into(), format!("{:.1}", shown.most_pa * 1e-3)]),
        Colour::J => ("J, volume / rest volume", ["1".into(), format!("{LEAST_J}")]),
    };
    let bar = Rect::from_min_size(rect.left_top() + vec2(14.0, 30.0), vec2(150.0, 10.0));
    painter.text(bar.left_top() - vec2(0.0, 4.0), Align2::LEFT_BOTTOM, title, FontId::proportional(13.0), ink);
    for k in 0..50_u8 {
        let x = bar.left() + f32::from(k) * 3.0;
        let piece = Rect::from_min_size(pos2(x, bar.top()), vec2(3.0, 10.0));
        painter.rect_filled(piece, 0.0, screen(scale(f32::from(k) / 49.0)));
    }
    let [low, high] = ends;
    painter.text(bar.left_bottom() + vec2(0.0, 2.0), Align2::LEFT_TOP, low, FontId::proportional(12.0), ink);
    painter.text(bar.right_bottom() + vec2(0.0, 2.0), Align2::RIGHT_TOP, high, FontId::proportional(12.0), ink);
    if shown.cut {
        let below = bar.left_bottom() + vec2(0.0, 20.0);
        let lines = "cut through the tip; white: the surface at rest";
        painter.text(below, Align2::LEFT_TOP, lines, FontId::proportional(12.0), ink);
    }
    if rect.width() < LEAST_FOR_HINTS {
        return;
    }
    let corner = rect.right_top() + vec2(-12.0, 8.0);
    painter.text(corner, Align2::RIGHT_TOP, how, FontId::proportional(12.0), ink.gamma_multiply(0.7));
}
