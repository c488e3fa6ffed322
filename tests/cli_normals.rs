//! The commands `bake` and `light`: files in, files out, the signs of what they show, and one clear line for
//! every bad input.
#![cfg(feature = "cli")]

mod common;

use common::{Folder, complaint, printed};
use std::fs;

/// The one line of a command that is refused.
fn refused(args: &[&str]) -> String {
    complaint(args, 2)
}

/// A raw file of floats in the folder: its path.
fn raw_file(folder: &Folder, name: &str, texels: impl IntoIterator<Item = f32>) -> String {
    let bytes: Vec<u8> = texels.into_iter().flat_map(f32::to_le_bytes).collect();
    folder.file(name, &bytes)
}

/// A picture of three channels: its width and its pixels.
fn picture(path: &str) -> (usize, Vec<[u8; 3]>) {
    let file = std::io::BufReader::new(fs::File::open(path).unwrap());
    let mut reader = png::Decoder::new(file).read_info().unwrap();
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut bytes).unwrap();
    assert_eq!((info.color_type, info.bit_depth), (png::ColorType::Rgb, png::BitDepth::Eight));
    (info.width as usize, bytes.as_chunks().0.to_vec())
}

fn floats(path: &str, head: usize) -> Vec<f32> {
    let bytes = fs::read(path).unwrap();
    bytes[head..].as_chunks().0.iter().map(|four| f32::from_le_bytes(*four)).collect()
}

/// A ramp that rises to the right by 3/4 of a texel a texel, and to the top by 1/2: its normal is known.
fn ramp(size: usize) -> impl Iterator<Item = f32> {
    (0..size * size).map(move |i| 0.75 * (i % size) as f32 - 0.5 * (i / size) as f32)
}

#[test]
fn bake_writes_every_format() {
    let folder = Folder::new("formats");
    let height = raw_file(&folder, "ramp.f32", ramp(16));
    let bake = |out: &str, more: &[&str]| {
        let out = folder.path(out);
        let line =
            printed(&[&["bake", &height, &out, "--size", "16x16", "--border", "one-sided"], more].concat());
        assert!(
            line.starts_with(&out) && line.contains("16 x 16") && line.contains("float heights"),
            "{line}"
        );
        assert!(line.contains("files took") && line.lines().count() == 1, "{line}");
        out
    };
    // In the middle of the map, where no border reaches: (-3/4, -1/2, 1) over its length.
    let length = (0.5625 + 0.25 + 1f32).sqrt();
    let normal = [-0.75, -0.5, 1.0].map(|x| x / length);
    let near = |found: &[f32]| found.iter().zip(normal).all(|(a, b)| (a - b).abs() < 1e-6);
    let middle = 16 * 8 + 8;
    // Behind `PF\n16 16\n-1.0\n`.
    assert!(near(&floats(&bake("n.pfm", &[]), 14)[3 * middle..][..3]));
    assert!(near(&floats(&bake("n.raw", &[]), 0)[3 * middle..][..3]));
    // (x + 1)/2 of 255, rounded.
    let [r, g, b] = normal.map(|x| (f64::from(x + 1.0) / 2.0 * 255.0 + 0.5).floor() as u8);
    assert_eq!(picture(&bake("n.png", &[])), (16, vec![[r, g, b]; 256]));
    assert_eq!(picture(&bake("d.png", &["--green", "down"])).1[middle], [r, 255 - g, b]);
    assert_eq!(picture(&bake("rg.png", &["--format", "rg8"])).1[middle], [r, g, 0]);
    let depth = picture(&bake("depth.png", &["--height-scale", "-1"])).1[middle];
    assert_eq!(depth, [255 - r, 255 - g, b]);
    // Half the texel, half the height: the same slopes.
    let half = bake("half.png", &["--texel-size", "0.5", "--height-scale", "0.5"]);
    assert_eq!(picture(&half).1[middle], [r, g, b]);
    // Texels twice as wide as high: the slope along s halves.
    let wide = floats(&bake("wide.raw", &["--texel-size", "2,1"]), 0);
    let length = (0.375f32 * 0.375 + 0.25 + 1.0).sqrt();
    assert!((wide[3 * middle] + 0.375 / length).abs() < 1e-6);
    let words: Vec<_> = fs::read(bake("w.raw", &["--format", "rg16"])).unwrap();
    assert_eq!(words.len(), 16 * 16 * 4);
    let word = |i: usize| u16::from_le_bytes([words[2 * i], words[2 * i + 1]]);
    let level = (f64::from(normal[0] + 1.0) / 2.0 * 65535.0 + 0.5).floor() as u16;
    assert!(word(2 * middle).abs_diff(level) <= 1, "{} for {level}: f32 is near a half", word(2 * middle));
}

#[test]
fn bake_writes_mips_and_the_error_map() {
    let folder = Folder::new("mips");
    let (out, errors) = (folder.path("n.png"), folder.path("e.pfm"));
    let line =
        printed(&["bake", "docs/dome.png", &out, "--height-scale", "24", "--mips", "--error-map", &errors]);
    assert!(line.contains("128 x 128 rgb8 and 7 mip levels from 16-bit heights"), "{line}");
    let names = ["e.pfm", "n.mip1.png", "n.mip2.png", "n.mip3.png", "n.mip4.png", "n.mip5.png", "n.mip6.png"];
    assert_eq!(folder.names(), [&names[..], &["n.mip7.png", "n.png"]].concat());
    assert_eq!(picture(&out).0, 128);
    assert_eq!(picture(&folder.path("n.mip3.png")).0, 16);
    // A map that wraps has no slope on the whole.
    assert_eq!(picture(&folder.path("n.mip7.png")), (1, vec![[128, 128, 255]]));
    // Behind `Pf\n128 128\n-1.0\n`: no difference on the ground, a large one at the rim, rows from the bottom.
    let angles = floats(&errors, 16);
    assert_eq!(angles.len(), 128 * 128);
    assert_eq!(angles[0], 0.0);
    let rim = angles[64 * 128 + 15..64 * 128 + 18].iter().copied().fold(0.0, f32::max);
    assert!(rim > 1.0, "the slope jumps by 53 degrees there: {rim}");
    // In the middle of the cap h^2 f''' / 6 of the smaller stencil counts alone: next to nothing.
    assert!(angles[64 * 128 + 64] < 0.05, "{}", angles[64 * 128 + 64]);
}

/// Of 8-bit heights a high order sees the steps; of finer ones nothing is said.
#[test]
fn bake_says_what_8_bit_heights_are_good_for() {
    let folder = Folder::new("advice");
    // A wave 64 texels long, 20 high: its steps of 20/255 are 0.08 texels, so central8, of gain 1.17, errs by
    // 1.17 x 0.08 / sqrt(12) = 0.027 radians or 1.5 degrees. Of itself it errs by next to nothing.
    let wave = |i: usize| 0.5 + 0.5 * ((i % 64) as f32 * std::f32::consts::TAU / 64.0).sin();
    let eight = folder.path("wave.u8");
    fs::write(&eight, (0..64 * 64).map(|i| (wave(i) * 255.0).round() as u8).collect::<Vec<_>>()).unwrap();
    let float = raw_file(&folder, "wave.f32", (0..64 * 64).map(wave));
    let out = folder.path("out.png");
    let bake = |height: &str| {
        printed(&["bake", height, &out, "--size", "64x64", "--stencil", "central8", "--height-scale", "20"])
    };
    let lines = bake(&eight);
    let advice = lines.lines().nth(1).expect("a second line");
    assert!(
        advice.starts_with("8-bit heights: ") && advice.contains("a higher order is pointless"),
        "{advice}"
    );
    assert!(advice.contains("would serve better"), "{advice}");
    let degrees: f64 = advice.split(" degrees").next().unwrap().rsplit(' ').next().unwrap().parse().unwrap();
    assert!((degrees - 1.5).abs() < 0.05, "{advice}");
    assert_eq!(bake(&float).lines().count(), 1);
}

/// A stencil file of one's own, and one that is wrong.
#[test]
fn bake_takes_a_stencil_file() {
    let folder = Folder::new("stencil");
    let shipped = concat!(env!("CARGO_MANIFEST_DIR"), "/tableaus/stencils/central2.toml");
    let mine = folder.path("mine.toml");
    fs::copy(shipped, &mine).unwrap();
    let [a, b] = [("a.png", "central2"), ("b.png", &mine)].map(|(out, stencil)| {
        printed(&["bake", "docs/dome.png", &folder.path(out), "--height-scale", "24", "--stencil", stencil]);
        fs::read(folder.path(out)).unwrap()
    });
    assert!(a == b);
    fs::write(&mine, fs::read_to_string(shipped).unwrap().replace("1/2", "1/3")).unwrap();
    let line = refused(&["bake", "docs/dome.png", &folder.path("c.png"), "--stencil", &mine]);
    assert!(line.starts_with(&mine), "{line}");
    assert_eq!(folder.names(), ["a.png", "b.png", "mine.toml"]);
}

/// The dome of `docs/`: a cap of a sphere of radius 60, whose base has a radius of 48, in 128 x 128 texels.
const DOME: [&str; 4] = ["docs/dome.png", "--height-scale", "24", "--pixels"];

/// Panels of the quad seen from above, a pixel a texel, as brightness from 0 to 255.
fn panels(folder: &Folder, args: &[&str], size: usize, count: usize) -> Vec<Vec<u8>> {
    let out = folder.path("lit.png");
    printed(&[&["light", args[0], &out], &args[1..]].concat());
    let (width, pixels) = picture(&out);
    // Between and around the panels: 8 pixels.
    assert_eq!(width, 8 + count * (size + 8));
    let pixels = &pixels;
    let panel = |k: usize| {
        let at = move |i: usize| pixels[(8 + i / size) * width + 8 + k * (size + 8) + i % size];
        (0..size * size).map(at).map(|[r, g, b]| {
            assert!(r == g && g == b);
            r
        })
    };
    (0..count).map(|k| panel(k).collect()).collect()
}

/// Ambient 0.1, and 0.9 by Lambert.
fn brightness(n: [f64; 3], azimuth: f64, elevation: f64) -> f64 {
    let ((sin, cos), (up, level)) = (azimuth.to_radians().sin_cos(), elevation.to_radians().sin_cos());
    255.0 * (0.1 + 0.9 * (n[0] * cos * level + n[1] * sin * level + n[2] * up).max(0.0))
}

#[test]
fn a_dome_is_bright_where_the_light_is() {
    let folder = Folder::new("dome");
    for (azimuth, [left, top, right, bottom]) in
        [(180, [1, 0, -1, 0]), (90, [0, 1, 0, -1]), (0, [-1, 0, 1, 0]), (-90, [0, -1, 0, 1])]
    {
        let light = format!("{azimuth},30");
        let more = [
            "128",
            "--view",
            "90",
            "--light",
            &light,
            "--modes",
            "flat,bump,normal-map,parallax,offset-limited",
        ];
        let all = panels(&folder, &[&DOME[..], &more].concat(), 128, 5);
        let (flat, bump) = (&all[0], &all[1]);
        let ground = brightness([0.0, 0.0, 1.0], f64::from(azimuth), 30.0);
        assert!(flat.iter().all(|x| (f64::from(*x) - ground).abs() <= 0.5), "flat stays flat");
        // 30 texels from the top of the dome each way, its normal leans by asin 1/2 = 30 degrees.
        for ((x, y), side) in [((34, 64), left), ((64, 34), top), ((94, 64), right), ((64, 94), bottom)] {
            let there = f64::from(bump[y * 128 + x]);
            match side {
                1 => assert!(there > ground + 60.0, "{azimuth}: bright at {x}, {y}: {there}"),
                -1 => assert!(there < ground - 60.0, "{azimuth}: dark at {x}, {y}: {there}"),
                _ => assert!((there - ground).abs() < 20.0, "{azimuth}: neither at {x}, {y}: {there}"),
            }
        }
        // Texture space and view space agree, and seen from straight above nothing shifts: to one level
        // where a sum of f32 normals rounds to the other side.
        for (mode, panel) in all[2..].iter().enumerate() {
            let most = bump.iter().zip(panel).map(|(a, b)| a.abs_diff(*b)).max().unwrap();
            assert!(most <= 1, "panel {}: {most}", mode + 2);
        }
    }
}

/// Inside the rim every pixel has the shade of the sphere.
#[test]
fn a_dome_is_shaded_as_a_sphere() {
    let folder = Folder::new("sphere");
    let more = ["128", "--view", "90", "--light", "160,40", "--modes", "bump", "--stencil", "central4"];
    let dome = &panels(&folder, &[&DOME[..], &more].concat(), 128, 1)[0];
    let mut inside = 0;
    for (i, shade) in dome.iter().enumerate() {
        let (x, y) = ((i % 128) as f64 + 0.5 - 64.0, 64.0 - ((i / 128) as f64 + 0.5));
        // Three texels within: the stencil does not reach over the rim.
        if x.hypot(y) < 45.0 {
            inside += 1;
            let n = [x / 60.0, y / 60.0, (3600.0 - x * x - y * y).sqrt() / 60.0];
            let exact = brightness(n, 160.0, 40.0);
            // Half a level of rounding, and what heights of 1/65535 and the stencil's error make of it.
            assert!((f64::from(*shade) - exact).abs() < 0.9, "at {x}, {y}: {shade} for {exact}");
        }
    }
    assert!(inside > 6000);
}

/// Seen from 30 degrees, a raised step in the middle: parallax moves its picture up by b / tan of
/// the texture, offset limiting by b cos.
#[test]
fn parallax_raises_what_is_high() {
    let folder = Folder::new("parallax");
    let size = 64;
    // A step of four texels' height between the rows 16 and 48, counted from the top.
    let rows = |i: usize| if (16..48).contains(&(i / size)) { 4.0 } else { 0.0 };
    let height = raw_file(&folder, "step.f32", (0..size * size).map(rows));
    let out = folder.path("lit.png");
    let common =
        ["--size", "64x64", "--pixels", "256", "--view", "30", "--light", "90,45", "--stencil", "forward2"];
    let modes = ["--modes", "normal-map,parallax,offset-limited"];
    printed(&[&["light", &height, &out][..], &common, &modes].concat());
    let (width, pixels) = picture(&out);
    // 4 pixels a texel along s, 4 sin 30 = 2 along t: 128 lines.
    assert_eq!(pixels.len() / width, 128 + 16);
    let first_dark = |panel: usize| {
        let column = 8 + panel * (256 + 8) + 128;
        let line = |y: usize| pixels[(8 + y) * width + column][0];
        let least = (0..128).map(line).min().unwrap();
        (0..128).find(|y| line(*y) == least).unwrap()
    };
    // The forward difference, t upwards, has the lower edge of the step in row 48, which falls away from the
    // light: lines 96 and 97.
    assert_eq!(first_dark(0), 96);
    // Above it all is high: T = T_0 - 4 cos 30 / sin 30, so row 48 shows 6.93 texels, 13.86 lines, higher up.
    assert!(first_dark(1).abs_diff(96 - 14) <= 1, "{}", first_dark(1));
    // T = T_0 - 4 cos 30: 3.46 texels, 6.93 lines.
    assert!(first_dark(2).abs_diff(96 - 7) <= 1, "{}", first_dark(2));
}

/// On a cylinder the frames turn: bump in view space and the normal map in texture space still agree.
#[test]
fn a_cylinder_is_lit_alike_in_both_spaces() {
    let folder = Folder::new("cylinder");
    let out = folder.path("lit.png");
    let args =
        ["light", "docs/brick.png", &out, "--height-scale", "8", "--shape", "cylinder", "--view", "60"];
    printed(
        &[&args[..], &["--light", "170,20", "--pixels", "128", "--modes", "bump,normal-map,flat"]].concat(),
    );
    let (width, pixels) = picture(&out);
    let lines = pixels.len() / width - 16;
    let at = |panel: usize, x: usize, y: usize| pixels[(8 + y) * width + 8 + panel * 136 + x][0];
    let mut bumps = 0;
    for (x, y) in (0..lines).flat_map(|y| (0..128).map(move |x| (x, y))) {
        assert!(at(0, x, y).abs_diff(at(1, x, y)) <= 1, "at {x}, {y}");
        bumps += usize::from(at(0, x, y).abs_diff(at(2, x, y)) > 8);
    }
    assert!(bumps > 128 * lines / 10, "a wall has bumps: {bumps}");
    // Lit from the left.
    assert!(at(2, 20, lines / 2) > at(2, 107, lines / 2) + 100);
}

#[test]
fn bad_input_is_refused_in_one_line_and_leaves_nothing() {
    let folder = Folder::new("refused");
    let (png, raw) = (folder.path("out.png"), folder.path("out.raw"));
    let brick = "docs/brick.png";
    let whole = fs::read(concat!(env!("CARGO_MANIFEST_DIR"), "/docs/brick.png")).unwrap();
    let cut = folder.path("cut.png");
    fs::write(&cut, &whole[..whole.len() / 2]).unwrap();
    let holes = raw_file(&folder, "holes.f32", [0.0, f32::NAN, 1.0, f32::INFINITY]);
    let names = folder.names();
    let before = names.clone();
    for command in ["bake", "light"] {
        let refuse = |height: &str, more: &[&str]| refused(&[&[command, height, &png], more].concat());
        for (line, says) in [
            (refused(&[command]), "<HEIGHT> <OUT>"),
            (refused(&[command, brick]), "<OUT>"),
            (refused(&[command, brick, "out.jpg"]), "out.jpg"),
            (refused(&[command, brick, "no-such-folder/out.png"]), "no-such-folder/out.png"),
            (refuse("no-such-file.png", &[]), "no-such-file.png: No such file"),
            (refuse("docs", &[]), "docs: it is a folder"),
            (refuse("Cargo.toml", &[]), "Cargo.toml: neither PNG"),
            (refuse(&cut, &[]), "cut.png: "),
            (refuse(brick, &["--channel", "r"]), "is grey"),
            (refuse(brick, &["--channel", "x"]), "a channel is r, g, b or a"),
            (refuse(brick, &["--size", "7x7"]), "raw texels are 49, 98 or 196"),
            (refuse(brick, &["--size", "7"]), "640x480"),
            (refuse(brick, &["--size", "99999x99999"]), "more than"),
            (refuse(brick, &["--stencil", "centrl4"]), "did you mean central4"),
            (refuse(brick, &["--stencil", "no-such-folder/my.toml"]), "no-such-folder/my.toml"),
            (refuse(brick, &["--height-scale", "inf"]), "not a finite number"),
            (refuse(brick, &["--texel-size", "0"]), "higher than 0"),
            (refuse(brick, &["--texel-size", "1,-1"]), "higher than 0"),
            (refuse(brick, &["--texel-size", "1,2,3"]), "not a finite number"),
            (refuse(brick, &["--border", "torus"]), "wrap, clamp, mirror or one-sided"),
            (refuse(brick, &["--border", "wrap,"]), "wrap, clamp, mirror or one-sided"),
            (refuse(brick, &["--missing", "zero"]), "border"),
            (refuse(&holes, &["--size", "2x2"]), "2 heights are not finite, the first at column 1, row 0"),
        ] {
            assert!(line.contains(says), "{command}: {line:?} does not say {says:?}");
        }
        assert!(
            refuse(&holes, &["--size", "2x2"]).ends_with("--missing border takes such heights for a border")
        );
    }
    let bake = |more: &[&str]| refused(&[&["bake", brick, &png], more].concat());
    let light = |more: &[&str]| refused(&[&["light", brick, &png], more].concat());
    for (line, says) in [
        (bake(&["--format", "f32"]), "a PNG holds no floats"),
        (bake(&["--format", "rgb10"]), "rgb16"),
        (bake(&["--format", "rg8", "--best-fit"]), "--best-fit"),
        (bake(&["--green", "left"]), "down"),
        (bake(&["--error-map", "e.png"]), ".pfm or .raw"),
        (refused(&["bake", brick, &raw, "--error-map", &raw]), "named for the error map too"),
        (refused(&["bake", brick, "out.pfm", "--format", "rgb8"]), "floats only"),
        (light(&["--light", "90"]), "azimuth and elevation"),
        (light(&["--light", "90,91"]), "from -90 to 90"),
        (light(&["--view", "0"]), "from 1 to 90"),
        (light(&["--view", "steep"]), "not a finite number"),
        (light(&["--modes", "flat,shiny"]), "offset-limited"),
        (light(&["--shape", "torus"]), "cylinder"),
        (light(&["--pixels", "0"]), "from 1 to 4096"),
        (light(&["--pixels", "4096", "--texel-size", "1,1e6"]), "--pixels"),
        (refused(&["light", brick, &raw]), "PNG"),
    ] {
        assert!(line.contains(says), "{line:?} does not say {says:?}");
    }
    assert_eq!(folder.names(), before, "nothing is left half-written");
}

/// What stood under the name of the target stays until the new file is whole.
#[test]
fn a_failed_bake_keeps_the_old_file() {
    let folder = Folder::new("old");
    let out = folder.path("out.png");
    fs::write(&out, "old").unwrap();
    refused(&["bake", "Cargo.toml", &out]);
    assert_eq!((fs::read(&out).unwrap(), folder.names()), (b"old".to_vec(), vec!["out.png".to_string()]));
    printed(&["bake", "docs/dome.png", &out]);
    assert_eq!((picture(&out).0, folder.names().len()), (128, 1));
}
