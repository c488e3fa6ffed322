//! The picture: two points for each stencil, its name beside them.

use std::fmt::Write;

pub struct Point {
    pub name: &'static str,
    /// Root mean square.
    pub degrees: f64,
    /// Megapixels per second: to three floats and to three bytes.
    pub floats: f64,
    pub bytes: f64,
}

const SIZE: [f64; 2] = [960.0, 600.0];
/// The frame: left, top, right, bottom.
const FRAME: [f64; 4] = [78.0, 52.0, 936.0, 536.0];
const INK: &str = "#333333";
/// Of text, and about the width of a letter of it.
const HEIGHT: f64 = 14.0;
const LETTER: f64 = 8.2;

/// Left, top, right, bottom.
type Room = [f64; 4];

fn overlap(a: &Room, b: &Room) -> f64 {
    let side = |i: usize| (a[i + 2].min(b[i + 2]) - a[i].max(b[i])).max(0.0);
    side(0) * side(1)
}

/// Logarithms of the ends of an axis, a little beyond the values.
fn range(values: impl Iterator<Item = f64>, room: f64) -> [f64; 2] {
    let ends =
        values.map(f64::log10).fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], x| [a.min(x), b.max(x)]);
    [ends[0] - room, ends[1] + room]
}

/// By what the name says it is: central, smoothed, compact or one-sided.
fn colour(name: &str) -> &'static str {
    let kinds = [("central", "#1f77b4"), ("drp", "#1f77b4"), ("compact", "#7a0040"), ("onesided", "#b8860b")];
    let kind = kinds.iter().find(|kind| name.starts_with(kind.0));
    let two = ["forward", "backward"].iter().any(|two| name.starts_with(two));
    if two { "#b8860b" } else { kind.map_or("#2c8f2c", |kind| kind.1) }
}

struct Picture {
    text: String,
    x: [f64; 2],
    y: [f64; 2],
}

impl Picture {
    /// Smaller errors to the right, faster above.
    fn at(&self, degrees: f64, speed: f64) -> [f64; 2] {
        let [left, top, right, bottom] = FRAME;
        let part = |[from, to]: [f64; 2], x: f64| (x.log10() - from) / (to - from);
        [right - part(self.x, degrees) * (right - left), bottom - part(self.y, speed) * (bottom - top)]
    }

    fn line(&mut self, [a, b]: [[f64; 2]; 2], colour: &str, width: f64) {
        let [[x1, y1], [x2, y2]] = [a, b];
        self.add(format_args!(
            r#"<line x1="{x1:.1}" y1="{y1:.1}" x2="{x2:.1}" y2="{y2:.1}" stroke="{colour}" stroke-width="{width}"/>"#
        ));
    }

    /// The anchor is start, middle or end.
    fn write(&mut self, text: &str, [x, y]: [f64; 2], size: f64, colour: &str, anchor: &str) {
        self.add(format_args!(
            r#"<text x="{x:.1}" y="{y:.1}" font-size="{size}" fill="{colour}" text-anchor="{anchor}">{text}</text>"#
        ));
    }

    fn dot(&mut self, [x, y]: [f64; 2], colour: &str, full: bool) {
        let fill = if full { colour } else { "white" };
        self.add(format_args!(
            r#"<circle cx="{x:.1}" cy="{y:.1}" r="4.5" fill="{fill}" stroke="{colour}" stroke-width="1.8"/>"#
        ));
    }

    fn add(&mut self, element: std::fmt::Arguments) {
        // A string takes whatever is written to it.
        let _ = writeln!(self.text, "{element}");
    }

    fn axes(&mut self) {
        let [left, top, right, bottom] = FRAME;
        let places = |[from, to]: [f64; 2]| {
            let decades = from.floor() as i32..=to.ceil() as i32;
            let all = decades.flat_map(|k| [1, 2, 5].map(|digit| (k, digit)));
            all.filter(move |(k, digit)| (from..=to).contains(&(f64::from(*k) + f64::from(*digit).log10())))
        };
        for (k, digit) in places(self.x) {
            let value = f64::from(digit) * 10f64.powi(k);
            let [x, _] = self.at(value, 1.0);
            self.line([[x, top], [x, bottom]], if digit == 1 { "#d0d0d0" } else { "#eeeeee" }, 1.0);
            if digit == 1 {
                let shown = if value > 0.0005 { format!("{value}") } else { format!("1e{k}") };
                self.write(&format!("{shown}°"), [x, bottom + 21.0], HEIGHT, INK, "middle");
            }
        }
        for (k, digit) in places(self.y) {
            let value = f64::from(digit) * 10f64.powi(k);
            let [_, y] = self.at(1.0, value);
            self.line([[left, y], [right, y]], if digit == 1 { "#d0d0d0" } else { "#eeeeee" }, 1.0);
            self.write(&format!("{value}"), [left - 8.0, y + 5.0], HEIGHT, INK, "end");
        }
        self.add(format_args!(
            r#"<path d="M{left} {top}H{right}V{bottom}H{left}Z" fill="none" stroke="{INK}"/>"#
        ));
        let middle = 0.5 * (left + right);
        self.write("Normal maps: speed against error of each stencil", [middle, 30.0], 19.0, INK, "middle");
        let below = "angle to the exact normals, root mean square, of noise no shorter than 8 texels (smaller to the right)";
        self.write(below, [middle, bottom + 48.0], 15.0, INK, "middle");
        let y = 0.5 * (top + bottom);
        self.add(format_args!(
            r#"<text transform="translate(22 {y}) rotate(-90)" font-size="15" fill="{INK}" text-anchor="middle">megapixels per second on one thread</text>"#
        ));
    }

    /// What the two kinds of points are, in the lower left corner.
    fn key(&mut self) -> Room {
        let [left, _, _, bottom] = FRAME;
        for (i, (full, words)) in [(true, "to RGB8"), (false, "to three floats")].into_iter().enumerate() {
            let y = bottom - 44.0 + 22.0 * i as f64;
            self.dot([left + 20.0, y], INK, full);
            self.write(words, [left + 32.0, y + 5.0], HEIGHT, INK, "start");
        }
        [left, bottom - 60.0, left + 150.0, bottom]
    }

    /// Where a name covers least, near its points first.
    fn name(&mut self, point: &Point, taken: &mut Vec<Room>) {
        let (width, [left, top, right, bottom]) = (LETTER * point.name.len() as f64, FRAME);
        let mut best: Option<(f64, Room, [f64; 2])> = None;
        for speed in [point.bytes, point.floats] {
            let [x, y] = self.at(point.degrees, speed);
            for far in (0..14).map(|i| 4.0 + 8.0 * f64::from(i)) {
                for turn in (0..24).map(|i| std::f64::consts::TAU * f64::from(i) / 24.0) {
                    let [dx, dy] = [turn.cos(), turn.sin()];
                    // The nearest point of the name's room lies that far off.
                    let middle = [x + dx * (far + 6.0 + 0.5 * width), y + dy * (far + 6.0 + 0.5 * HEIGHT)];
                    let room = [
                        middle[0] - 0.5 * width,
                        middle[1] - 0.5 * HEIGHT,
                        middle[0] + 0.5 * width,
                        middle[1] + 0.5 * HEIGHT,
                    ];
                    if room[0] < left + 3.0
                        || room[2] > right - 3.0
                        || room[1] < top + 3.0
                        || room[3] > bottom - 3.0
                    {
                        continue;
                    }
                    let covered: f64 = taken.iter().map(|other| overlap(&room, other)).sum();
                    let crossed: f64 = way([x, y], &room)
                        .map(|dot| taken.iter().map(|other| overlap(&dot, other)).sum::<f64>())
                        .sum();
                    let cost = 20.0 * (covered + crossed) + far;
                    if best.as_ref().is_none_or(|best| cost < best.0) {
                        best = Some((cost, room, [x, y]));
                    }
                }
            }
        }
        let Some((_, room, [x, y])) = best else { return };
        let dots: Vec<Room> = way([x, y], &room).collect();
        if let [first, .., last] = dots[..] {
            self.line([first, last].map(|dot| [dot[0] + 2.0, dot[1] + 2.0]), "#999999", 0.8);
            taken.extend(dots);
        }
        self.write(
            point.name,
            [0.5 * (room[0] + room[2]), room[3] - 2.5],
            HEIGHT,
            colour(point.name),
            "middle",
        );
        taken.push(room);
    }
}

/// Dots on the line that joins a point to a name that is not right beside it.
fn way([x, y]: [f64; 2], name: &Room) -> impl Iterator<Item = Room> {
    let edge = [x.clamp(name[0], name[2]), y.clamp(name[1], name[3])];
    let away = [edge[0] - x, edge[1] - y];
    let far = away[0].hypot(away[1]);
    let count = if far > 16.0 { 12 } else { 0 };
    let on = move |i: i32| {
        let part = (8.0 + (far - 8.0) * f64::from(i) / 11.0) / far;
        [x + part * away[0], y + part * away[1]]
    };
    (0..count).map(on).map(|[x, y]| [x - 2.0, y - 2.0, x + 2.0, y + 2.0])
}

pub fn svg(points: &[Point]) -> String {
    let speeds = points.iter().flat_map(|point| [point.floats, point.bytes]);
    let (x, y) = (range(points.iter().map(|point| point.degrees), 0.22), range(speeds, 0.12));
    let mut picture = Picture { text: String::new(), x, y };
    let [width, height] = SIZE;
    picture.add(format_args!(
        r#"<svg width="{width}" height="{height}" viewBox="0 0 {width} {height}" xmlns="http://www.w3.org/2000/svg" font-family="sans-serif">"#
    ));
    picture.add(format_args!(r#"<rect width="{width}" height="{height}" fill="white"/>"#));
    picture.axes();
    let mut taken = vec![picture.key()];
    for point in points {
        let ends = [picture.at(point.degrees, point.floats), picture.at(point.degrees, point.bytes)];
        picture.line(ends, colour(point.name), 1.0);
        taken.extend(ends.map(|[x, y]| [x - 6.0, y - 6.0, x + 6.0, y + 6.0]));
        let (low, high) = (ends[0][1].min(ends[1][1]), ends[0][1].max(ends[1][1]));
        taken.push([ends[0][0] - 1.0, low, ends[0][0] + 1.0, high]);
    }
    for point in points {
        for (speed, full) in [(point.floats, false), (point.bytes, true)] {
            picture.dot(picture.at(point.degrees, speed), colour(point.name), full);
        }
    }
    for point in points {
        picture.name(point, &mut taken);
    }
    picture.add(format_args!("</svg>"));
    picture.text
}
