//! A drawing of a scene's vehicle from its right side, forward to the right: as SVG what the FMU's page shows, as PNG its `model.png`.
//!
//! Wheels have their radius. Of other bodies a scene knows mass and inertia alone: each is drawn as the box of even density that has them.

use crate::scene::vehicle::outline::half_edges;
use crate::scene::vehicle::{Element, VehicleSpec};
use std::fmt::Write;

/// Around the vehicle, m.
const MARGIN: f64 = 1.0;
/// Least height of a vehicle, m.
const LEAST: f64 = 0.1;

/// Width and height of the PNG.
#[cfg(feature = "plot")]
const PIXELS: u32 = 400;

/// A rectangle with its middle at x, z [m].
struct Shape {
    x: f64,
    z: f64,
    half_length: f64,
    half_height: f64,
}

/// Text as XML.
fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// What is drawn, m: x forward, z up from the rails.
pub(super) struct Drawing<'v> {
    boxes: Vec<(&'v str, Shape)>,
    /// Name, x and radius.
    wheels: Vec<(&'v str, f64, f64)>,
    /// Name and both ends of what joins two bodies.
    links: Vec<(&'v str, [(f64, f64); 2])>,
    /// Left edge, width, and height above the rails, with margins at the sides.
    left: f64,
    width: f64,
    top: f64,
}

impl Drawing<'_> {
    pub fn new(vehicle: &VehicleSpec) -> Drawing<'_> {
        let wheels: Vec<(&str, f64, f64)> =
            vehicle.wheelsets.iter().map(|placed| (placed.spec.name.as_str(), placed.x, placed.design_position().z)).collect();
        let boxes: Vec<(&str, Shape)> = vehicle
            .bodies
            .iter()
            .map(|placed| {
                let [half_length, _, half_height] = half_edges(&placed.body);
                (placed.body.name.as_str(), Shape { x: placed.position.x, z: placed.position.z, half_length, half_height })
            })
            .collect();
        let middles: Vec<(f64, f64)> =
            wheels.iter().map(|(_, x, radius)| (*x, *radius)).chain(boxes.iter().map(|(_, shape)| (shape.x, shape.z))).collect();
        let ends = wheels.iter().map(|(_, x, radius)| (x - radius, x + radius, 2.0 * radius));
        let ends = ends.chain(boxes.iter().map(|(_, s)| (s.x - s.half_length, s.x + s.half_length, s.z + s.half_height)));
        let (rear, front, top) =
            ends.fold((f64::INFINITY, f64::NEG_INFINITY, 0.0_f64), |(a, b, c), (x, y, z)| (a.min(x), b.max(y), c.max(z)));
        let joined = |element: &'_ Element| {
            let [a, b, third] = element.0.reach().map(|end| end.and_then(|body| middles.get(body).copied()));
            let third = third.filter(|third| ![a, b].contains(&Some(*third)));
            [a.zip(b), a.zip(third)].into_iter().flatten().map(|(a, b)| [a, b])
        };
        let links = vehicle.forces.iter().flat_map(|element| joined(element).map(|ends| (element.0.name(), ends))).collect();
        Drawing { boxes, wheels, links, left: rear - MARGIN, width: front - rear + 2.0 * MARGIN, top }
    }

    /// Width of lines, m.
    fn stroke(&self) -> f64 {
        (self.top + 2.0 * MARGIN).max(self.width / 4.0) / 200.0
    }

    /// As SVG, 100 % wide.
    pub fn svg(&self) -> String {
        let (left, width, height) = (self.left, self.width, self.top + 2.0 * MARGIN);
        let mut svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"{left:.3} {:.3} {width:.3} {height:.3}\" style=\"width: 100%; max-height: 24em\" fill=\"none\" stroke=\"#222\" stroke-width=\"{:.3}\">\n",
            -self.top - MARGIN,
            self.stroke(),
        );
        // Writing to a string cannot fail; z points up, and SVG's y down.
        let _ = writeln!(svg, "<path d=\"M {left:.3} 0 h {width:.3}\" stroke=\"#888\"/>");
        for (name, s) in &self.boxes {
            let (x, y, w, h) = (s.x - s.half_length, -s.z - s.half_height, 2.0 * s.half_length, 2.0 * s.half_height);
            let _ = writeln!(
                svg,
                "<rect x=\"{x:.3}\" y=\"{y:.3}\" width=\"{w:.3}\" height=\"{h:.3}\" fill=\"#cde\" fill-opacity=\"0.6\"><title>{}</title></rect>",
                escape(name)
            );
        }
        for (name, x, radius) in &self.wheels {
            let name = escape(name);
            let _ =
                writeln!(svg, "<circle cx=\"{x:.3}\" cy=\"{:.3}\" r=\"{radius:.3}\" fill=\"#fff\"><title>{name}</title></circle>", -radius);
        }
        for (name, [a, b]) in &self.links {
            let name = escape(name);
            let _ =
                writeln!(svg, "<path d=\"M {:.3} {:.3} L {:.3} {:.3}\" stroke=\"#a40\"><title>{name}</title></path>", a.0, -a.1, b.0, -b.1);
        }
        svg + "</svg>\n"
    }

    /// As PNG of 400 by 400, on nothing: an FMU's `model.png`. `None` where no picture can be made of it: the vehicle is kilometres long.
    #[cfg(feature = "plot")]
    pub fn png(&self) -> Option<Vec<u8>> {
        use tiny_skia::{FillRule, Paint, PathBuilder, Pixmap, Rect, Stroke, Transform};
        let mut picture = Pixmap::new(PIXELS, PIXELS)?;
        let size = f64::from(PIXELS);
        // A lone wheelset fills half of it.
        let scale = (size / self.width).min(0.5 * size / self.top.max(LEAST));
        let side = 0.5 * (size - scale * self.width);
        let ground = 0.5 * (size + scale * self.top);
        let at = |x: f64, z: f64| ((side + scale * (x - self.left)) as f32, (ground - scale * z) as f32);
        let paint = |[r, g, b, a]: [u8; 4]| {
            let mut paint = Paint::default();
            paint.set_color_rgba8(r, g, b, a);
            paint
        };
        let (own, dark) = (Transform::identity(), paint([0x22, 0x22, 0x22, 0xff]));
        let line = |width: f32| Stroke { width, ..Stroke::default() };
        let between = |a: (f32, f32), b: (f32, f32)| {
            let mut path = PathBuilder::new();
            path.move_to(a.0, a.1);
            path.line_to(b.0, b.1);
            path.finish()
        };
        let (from, to) = (at(self.left, 0.0), at(self.left + self.width, 0.0));
        picture.stroke_path(&between(from, to)?, &paint([0x88, 0x88, 0x88, 0xff]), &line(2.0), own, None);
        for (_, s) in &self.boxes {
            let ((left, top), (right, bottom)) =
                (at(s.x - s.half_length, s.z + s.half_height), at(s.x + s.half_length, s.z - s.half_height));
            let path = PathBuilder::from_rect(Rect::from_ltrb(left, top, right, bottom)?);
            picture.fill_path(&path, &paint([0xcc, 0xdd, 0xee, 0xc0]), FillRule::Winding, own, None);
            picture.stroke_path(&path, &dark, &line(1.5), own, None);
        }
        for (_, x, radius) in &self.wheels {
            let (x, y) = at(*x, *radius);
            let path = PathBuilder::from_circle(x, y, (scale * radius) as f32)?;
            picture.fill_path(&path, &paint([0xff; 4]), FillRule::Winding, own, None);
            picture.stroke_path(&path, &dark, &line(2.0), own, None);
        }
        for (_, [a, b]) in &self.links {
            // Places one above the other in this view make no line.
            if let Some(path) = between(at(a.0, a.1), at(b.0, b.1)) {
                picture.stroke_path(&path, &paint([0xaa, 0x44, 0x00, 0xff]), &line(1.0), own, None);
            }
        }
        picture.encode_png().ok()
    }
}

/// The axes of the track frame, in a view from the right side as that of the vehicle, and one from above.
pub(super) const AXES: &str = "\
<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 420 120\" style=\"width: 26em\" fill=\"none\" stroke=\"#222\" stroke-width=\"1.5\" font-family=\"sans-serif\" font-size=\"13\">\n\
<defs><marker id=\"tip\" markerWidth=\"8\" markerHeight=\"8\" refX=\"5\" refY=\"3\" orient=\"auto\"><path d=\"M 0 0 L 6 3 L 0 6 z\" fill=\"#222\" stroke=\"none\"/></marker></defs>\n\
<path d=\"M 30 95 H 130\" marker-end=\"url(#tip)\"/><path d=\"M 30 95 V 15\" marker-end=\"url(#tip)\"/><path d=\"M 30 60 A 35 35 0 0 1 65 95\" marker-end=\"url(#tip)\"/>\n\
<path d=\"M 250 95 H 350\" marker-end=\"url(#tip)\"/><path d=\"M 250 95 V 15\" marker-end=\"url(#tip)\"/><path d=\"M 285 95 A 35 35 0 0 0 250 60\" marker-end=\"url(#tip)\"/>\n\
<g fill=\"#222\" stroke=\"none\"><text x=\"138\" y=\"99\">X</text><text x=\"14\" y=\"20\">Z</text><text x=\"58\" y=\"66\">pitch</text><text x=\"30\" y=\"116\">from the right: X forward, Z up</text>\n\
<text x=\"358\" y=\"99\">X</text><text x=\"234\" y=\"20\">Y</text><text x=\"278\" y=\"66\">yaw</text><text x=\"250\" y=\"116\">from above: X forward, Y left</text></g>\n\
</svg>\n";
