//! MTL, the materials of OBJ (Wavefront; its extension for physically based shading is that of exocortex.com, 2014).
//!
//! `docs/inputs.md` says how each statement becomes a material of metallic-roughness.

use super::image_files::{ImageFiles, texture};
use super::parts::{Parts, plain_material};
use super::text;
use crate::material::{HeightMap, HeightMethod};
use crate::tally::Tally;
use crate::{AlphaMode, Image, Material, Sampler, TextureRef, TextureTransform, Wrap};
use glam::{Vec2, Vec3};

/// How high white lies over black by `-bm 1`, and by a gain of 1, of the diagonal of the model's box: MTL gives the
/// numbers no unit.
const BUMP_OF_SIZE: f32 = 0.01;

/// A file as a statement names it.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct NamedFile {
    /// Its path from the model.
    pub(super) path: String,
    /// The absolute path that it is named by, of which only the last part counts here.
    absolute: Option<String>,
}

impl NamedFile {
    /// A file that is named in a folder, which is empty or ends in a slash. Backslashes are slashes, one or two of them.
    pub(super) fn new(folder: &str, name: &str) -> Self {
        let name = name.trim().trim_matches('"');
        let has_drive = matches!(name.as_bytes(), [drive, b':', ..] if drive.is_ascii_alphabetic());
        let is_url = name.get(..5).is_some_and(|start| start.eq_ignore_ascii_case("file:"));
        let is_absolute = has_drive || is_url || name.starts_with(['/', '\\']);
        let parts = |text: &str| -> Vec<String> {
            text.split(['/', '\\']).filter(|part| !["", "."].contains(part)).map(str::to_owned).collect()
        };
        let mut path: Vec<String> = parts(folder);
        if is_absolute {
            let rest = if has_drive { name.get(2..).unwrap_or_default() } else { name };
            path.extend(parts(rest).into_iter().next_back().filter(|base: &String| !base.contains(':')));
        } else {
            for part in parts(name) {
                // What leads out of the model's folder is refused where it is read.
                match path.last() {
                    Some(last) if part == ".." && last != ".." => drop(path.pop()),
                    _ => path.push(part),
                }
            }
        }
        Self { path: path.join("/"), absolute: is_absolute.then(|| name.to_owned()) }
    }

    /// The path from the model, and the absolute one if the file is named so.
    pub(super) fn all(&self) -> impl Iterator<Item = &str> {
        std::iter::once(self.path.as_str()).chain(self.absolute.as_deref())
    }

    /// Warns of an absolute path.
    pub(super) fn warn(&self, place: &str, warnings: &mut Tally) {
        if let Some(absolute) = &self.absolute {
            let absolute = text::shown(absolute.as_bytes());
            let message = format!("\"{absolute}\" is an absolute path; \"{}\" beside the model is taken", self.path);
            warnings.add_as("absolute path", place, message);
        }
    }
}

/// A texture as a statement names it.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Map {
    pub(super) name: NamedFile,
    offset: Vec2,
    scale: Vec2,
    is_clamped: bool,
    strength: f32,
    gain: f32,
}

/// A material as its statements say it.
#[derive(Clone, Debug, Default)]
pub(super) struct Definition {
    pub(super) name: String,
    color: Option<[f32; 3]>,
    specular: Option<[f32; 3]>,
    exponent: Option<f32>,
    emission: Option<[f32; 3]>,
    /// What `d` says.
    alpha: Option<f32>,
    /// What `Tr` says.
    transparency: Option<f32>,
    roughness: Option<f32>,
    metallic: Option<f32>,
    color_map: Option<Map>,
    alpha_map: Option<Map>,
    emission_map: Option<Map>,
    bump_map: Option<Map>,
    displacement_map: Option<Map>,
    normal_map: Option<Map>,
    roughness_map: Option<Map>,
    metallic_map: Option<Map>,
}

/// The names of the statements that name a texture which is read, in small letters.
const MAPS: [&str; 10] =
    ["map_kd", "map_d", "map_ke", "map_bump", "bump", "norm", "map_pr", "map_pm", "disp", "map_disp"];

/// What has no meaning in metallic-roughness: ambient light, which the environment is, its map, the models of lighting
/// of 1990, and how an image is filtered.
const MEANINGLESS: [&str; 6] = ["ka", "map_ka", "illum", "ni", "sharpness", "map_aat"];

/// The materials of the library at `path` from the model.
pub(super) fn parse(bytes: &[u8], path: &str, warnings: &mut Tally) -> Vec<Definition> {
    let folder = path.rfind('/').and_then(|end| path.get(..=end)).unwrap_or_default();
    let mut definitions = Vec::<Definition>::new();
    for (line, content) in text::lines(bytes) {
        let (keyword, rest) = text::first_word(&content);
        if keyword.is_empty() || keyword.starts_with(b"#") {
            continue;
        }
        let keyword = text::name(keyword).to_ascii_lowercase();
        if keyword == "newmtl" {
            definitions.push(Definition { name: text::name(rest), ..Definition::default() });
            continue;
        }
        let Some(definition) = definitions.last_mut() else { continue };
        let place = format!("{path}: line {line}");
        match definition.read(&keyword, rest, folder) {
            Ok(None) => {}
            Ok(Some(kind)) => warnings.add(place, &kind),
            Err(message) => {
                let message = format!("{message}; the statement is passed over");
                warnings.add_as(&format!("wrong {keyword}"), place, message);
            }
        }
    }
    for named in definitions.iter().flat_map(Definition::maps).map(|map| &map.name) {
        named.warn(path, warnings);
    }
    definitions
}

impl Definition {
    /// Reads a statement; gives what is said of one that is passed over or taken otherwise than it is written.
    fn read(&mut self, keyword: &str, rest: &[u8], folder: &str) -> Result<Option<String>, String> {
        let one = || number(text::words(rest).next().unwrap_or_default());
        let unit = || one().map(|value| Some(value.clamp(0.0, 1.0)));
        match keyword {
            "kd" => {
                let (kd, warning) = of_unit(color(rest)?);
                self.color = Some(kd);
                return Ok(warning.map(str::to_owned));
            }
            "ks" => self.specular = Some(color(rest)?),
            "ke" => self.emission = Some(color(rest)?),
            "ns" => self.exponent = Some(one()?.max(0.0)),
            // `d -halo 0.5` fades towards edges; its number is taken as it is.
            "d" => {
                let word = text::words_before_comment(rest).last().unwrap_or_default();
                self.alpha = Some(number(word)?.clamp(0.0, 1.0));
            }
            "tr" => self.transparency = unit()?,
            "pr" => self.roughness = unit()?,
            "pm" => self.metallic = unit()?,
            _ if MAPS.contains(&keyword) => {
                let map = Some(map(rest, folder)?);
                match keyword {
                    "map_kd" => self.color_map = map,
                    "map_d" => self.alpha_map = map,
                    "map_ke" => self.emission_map = map,
                    "norm" => self.normal_map = map,
                    "map_pr" => self.roughness_map = map,
                    "map_pm" => self.metallic_map = map,
                    "disp" | "map_disp" => self.displacement_map = map,
                    _ => self.bump_map = map,
                }
            }
            _ if MEANINGLESS.contains(&keyword) => {}
            _ => {
                // Exporters write all that they know, mostly zeros.
                let says_nothing = text::words(rest).all(|word| text::number(word) == Some(0.0));
                let is_filter_of_all = keyword == "tf" && text::words(rest).all(|word| text::number(word) == Some(1.0));
                let keyword = text::shown(keyword.as_bytes());
                return Ok((!says_nothing && !is_filter_of_all).then(|| format!("\"{keyword}\" is not read")));
            }
        }
        Ok(None)
    }

    /// The share of what is seen of the surface. Where `d` and `Tr` contradict each other, `d` counts; without it, `Tr`
    /// is what shines through.
    fn alpha(&self, parts: &mut Parts) -> f32 {
        match (self.alpha, self.transparency) {
            (Some(alpha), Some(transparency)) => {
                // Some exporters write into `Tr` what `d` is.
                let is_either = [alpha, 1.0 - alpha].iter().any(|said| (said - transparency).abs() < 0.01);
                if !is_either {
                    let message = format!(
                        "material \"{}\": d {alpha} and Tr {transparency} contradict each other; d counts",
                        self.name
                    );
                    parts.warnings.add_as("d and Tr", "", message);
                }
                alpha
            }
            (None, Some(1.0)) => {
                let message = format!(
                    "material \"{}\": Tr 1 without d makes it invisible; some programs mean an opaque one: write d 1",
                    self.name
                );
                parts.warnings.add_as("Tr alone", "", message);
                0.0
            }
            (alpha, transparency) => alpha.or(transparency.map(|transparency| 1.0 - transparency)).unwrap_or(1.0),
        }
    }

    /// The textures that are read, or would be if they could.
    pub(super) fn maps(&self) -> impl Iterator<Item = &Map> {
        let maps = [&self.color_map, &self.alpha_map, &self.emission_map, &self.bump_map, &self.normal_map];
        maps.into_iter().chain([&self.roughness_map, &self.metallic_map, &self.displacement_map]).flatten()
    }

    /// The material of metallic-roughness, with its textures. `has_colors` says that vertices bring colours, and
    /// `size_m` is the diagonal of the model's box.
    pub(super) fn material(
        &self,
        has_colors: bool,
        size_m: f32,
        parts: &mut Parts,
        images: &mut ImageFiles,
        resolve: &mut dyn FnMut(&str) -> Result<Vec<u8>, String>,
    ) -> Material {
        let mut material = Material { name: self.name.clone(), ..plain_material(has_colors) };
        let mut slot = |map: &Option<Map>, parts: &mut Parts| {
            let map = map.as_ref()?;
            Some(map.reference(images.image(&map.name.path, parts, resolve)?, parts))
        };
        material.base_color_texture = slot(&self.color_map, parts);
        material.emissive_texture = slot(&self.emission_map, parts);
        material.normal_texture = slot(&self.normal_map, parts);
        if let Some(bump) = &self.bump_map
            && material.normal_texture.is_none()
        {
            let reference = slot(&self.bump_map, parts);
            let image = reference.and_then(|found| parts.scene.textures.get(found.texture)).map(|found| found.image);
            match image.and_then(|image| parts.scene.images.get(image)) {
                Some(image) if holds_heights(image) => {
                    let depth_m = bump.strength * BUMP_OF_SIZE * size_m;
                    let is_deep = depth_m != 0.0 && depth_m.is_finite();
                    material.height = reference.filter(|_| is_deep).map(|texture| HeightMap {
                        texture,
                        depth_m,
                        method: HeightMethod::Bump,
                        self_shadow: false,
                    });
                }
                Some(_) => {
                    material.normal_texture = reference;
                    material.normal_scale = bump.strength;
                }
                None => {}
            }
        }
        self.set_relief(&mut material, size_m, parts, &mut slot);
        self.set_gloss(&mut material, parts, &mut slot);
        self.set_color_and_alpha(&mut material, parts);
        let glow = if material.emissive_texture.is_some() { Vec3::ONE } else { Vec3::ZERO };
        let emission = self.emission.map_or(glow, Vec3::from);
        // Exporters write no light beside the map that gives it.
        material.emissive_factor = if emission == Vec3::ZERO { glow } else { emission };
        if self.emission_map.is_some() && material.emissive_texture.is_none() {
            material.emissive_factor = Vec3::ZERO;
        }
        material
    }

    /// Heights of `disp` are relief; where black is high they bend normals alone, because relief lies below triangles.
    fn set_relief(
        &self,
        material: &mut Material,
        size_m: f32,
        parts: &mut Parts,
        slot: &mut dyn FnMut(&Option<Map>, &mut Parts) -> Option<TextureRef>,
    ) {
        let Some(displacement) = &self.displacement_map else { return };
        let depth_m = displacement.gain * BUMP_OF_SIZE * size_m;
        if depth_m == 0.0 || !depth_m.is_finite() {
            return;
        }
        let Some(texture) = slot(&self.displacement_map, parts) else { return };
        if material.height.is_some() {
            parts.warn(format!("material \"{}\": disp takes the place of the heights of map_Bump", self.name));
        }
        let is_relief = depth_m > 0.0;
        let method = if is_relief { HeightMethod::Occlusion } else { HeightMethod::Bump };
        material.height = Some(HeightMap { texture, depth_m, method, self_shadow: is_relief });
    }

    /// Roughness and metal. The exponent of Blinn and Phong is n = 2 / α² − 2, as in docs/lighting.md.
    fn set_gloss(
        &self,
        material: &mut Material,
        parts: &mut Parts,
        slot: &mut dyn FnMut(&Option<Map>, &mut Parts) -> Option<TextureRef>,
    ) {
        let is_dull = self.specular.is_some_and(|specular| specular == [0.0; 3]);
        let of_exponent = self.exponent.map(|exponent| (2.0 / (exponent + 2.0)).powf(0.25));
        let of_phong = if is_dull { Some(1.0) } else { of_exponent };
        material.roughness_factor = self.roughness.or(of_phong).unwrap_or(material.roughness_factor);
        material.metallic_factor = self.metallic.unwrap_or(0.0);
        let one_image = match (&self.roughness_map, &self.metallic_map) {
            (Some(roughness), Some(metallic)) => roughness.name == metallic.name,
            (Some(_), None) => self.metallic.unwrap_or(0.0) == 0.0,
            (None, Some(_)) => false,
            (None, None) => return,
        };
        if !one_image {
            parts.warn(format!(
                "material \"{}\": map_Pr and map_Pm are two images; name one with roughness in green and metal in blue",
                self.name
            ));
            return;
        }
        material.metallic_roughness_texture = slot(&self.roughness_map, parts);
        if material.metallic_roughness_texture.is_some() {
            material.roughness_factor = self.roughness.filter(|roughness| *roughness > 0.0).unwrap_or(1.0);
            if self.metallic_map.is_some() {
                material.metallic_factor = self.metallic.filter(|metallic| *metallic > 0.0).unwrap_or(1.0);
            }
        }
    }

    fn set_color_and_alpha(&self, material: &mut Material, parts: &mut Parts) {
        let color = self.color.map(Vec3::from);
        // Exporters write black beside the map that gives the colour.
        let color = match (color, material.base_color_texture) {
            (None | Some(Vec3::ZERO), Some(_)) => Vec3::ONE,
            (color, _) => color.unwrap_or(material.base_color_factor.truncate()),
        };
        let alpha = self.alpha(parts);
        material.base_color_factor = color.extend(alpha);
        if alpha < 1.0 {
            material.alpha_mode = AlphaMode::Blend;
        }
        let Some(alpha_map) = &self.alpha_map else { return };
        if material.base_color_texture.is_some()
            && self.color_map.as_ref().is_some_and(|map| map.name == alpha_map.name)
        {
            if alpha == 1.0 {
                material.alpha_mode = AlphaMode::Mask { cutoff: 0.5 };
            }
        } else {
            parts.warn(format!(
                "material \"{}\": map_d is another image than map_Kd, and is not drawn; give map_Kd an alpha channel",
                self.name
            ));
        }
    }
}

/// Whether a map of bumps holds one number a texel rather than normals.
fn holds_heights(image: &Image) -> bool {
    let is_grey = |texel: &[u8]| matches!(*texel, [r, g, b, _] if r.abs_diff(g) < 8 && r.abs_diff(b) < 8);
    image.decode().is_ok_and(|pixels| pixels.data.chunks_exact(4).all(is_grey))
}

impl Map {
    fn reference(&self, image: usize, parts: &mut Parts) -> TextureRef {
        let wrap = if self.is_clamped { Wrap::ClampToEdge } else { Wrap::Repeat };
        let texture = texture(parts, image, Sampler { wrap_u: wrap, wrap_v: wrap, ..Sampler::default() });
        // The file's v points up: 1 − (v · s + o), of v = 1 − v'.
        let offset = Vec2::new(self.offset.x, 1.0 - self.offset.y - self.scale.y);
        TextureRef { texture, uv_set: 0, transform: TextureTransform { offset, scale: self.scale, rotation_rad: 0.0 } }
    }
}

fn number(word: &[u8]) -> Result<f32, String> {
    text::number(word).ok_or_else(|| format!("expected a finite number, found \"{}\"", text::shown(word)))
}

/// A colour from 0 to 1, and what is said of one that is not. Whole numbers above 1 are shares of 255.
fn of_unit(color: [f32; 3]) -> ([f32; 3], Option<&'static str>) {
    let most = color.into_iter().fold(0.0, f32::max);
    let is_of_bytes = most >= 2.0 && color.iter().all(|value| value.fract() == 0.0);
    if most <= 1.0 {
        (color, None)
    } else if is_of_bytes {
        (color.map(|value| (value / 255.0).min(1.0)), Some("Kd is above 1; it is taken to be from 0 to 255"))
    } else {
        (color.map(|value| value.min(1.0)), Some("Kd is above 1, which is taken instead"))
    }
}

/// One number is a grey. Numbers below 0 are 0.
fn color(rest: &[u8]) -> Result<[f32; 3], String> {
    let mut values = Vec::new();
    for word in text::words_before_comment(rest).take(3) {
        values.push(number(word)?.max(0.0));
    }
    match values[..] {
        [grey] => Ok([grey; 3]),
        [r, g, b] => Ok([r, g, b]),
        _ => Err("expected three numbers".into()),
    }
}

/// A texture: options, then a name, which may have spaces in it.
fn map(rest: &[u8], folder: &str) -> Result<Map, String> {
    let mut map = Map {
        name: NamedFile::default(),
        offset: Vec2::ZERO,
        scale: Vec2::ONE,
        is_clamped: false,
        strength: 1.0,
        gain: 1.0,
    };
    let mut rest = rest;
    loop {
        let (option, after) = text::first_word(rest);
        let most_numbers = match option.to_ascii_lowercase().as_slice() {
            b"-o" | b"-s" | b"-t" => 3,
            b"-mm" => 2,
            b"-bm" | b"-boost" | b"-texres" => 1,
            b"-clamp" | b"-blendu" | b"-blendv" | b"-cc" | b"-imfchan" | b"-type" => 0,
            _ => break,
        };
        rest = after;
        let mut numbers = Vec::new();
        if most_numbers == 0 {
            let (word, after) = text::first_word(rest);
            map.is_clamped |= option.eq_ignore_ascii_case(b"-clamp") && word.eq_ignore_ascii_case(b"on");
            rest = after;
        }
        while numbers.len() < most_numbers {
            let (word, after) = text::first_word(rest);
            let Some(number) = text::number(word) else { break };
            numbers.push(number);
            rest = after;
        }
        let pair = |of_v: f32| match numbers[..] {
            [u, v, ..] => Vec2::new(u, v),
            [u] => Vec2::new(u, of_v),
            [] => Vec2::splat(of_v),
        };
        match option.to_ascii_lowercase().as_slice() {
            b"-o" => map.offset = pair(0.0),
            b"-s" => map.scale = pair(1.0),
            b"-bm" => map.strength = numbers.first().copied().unwrap_or(1.0),
            // What is added to texels moves all of a relief, whose white lies on the triangles here.
            b"-mm" => map.gain = numbers.get(1).copied().unwrap_or(1.0),
            _ => {}
        }
    }
    map.name = NamedFile::new(folder, &text::name(rest));
    if map.name.path.trim_end_matches('/') == folder.trim_end_matches('/') {
        return Err("expected the name of a texture".into());
    }
    Ok(map)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_come_before_names_with_spaces() {
        let read = |text: &str| map(text.as_bytes(), "in/").expect(text);
        let found = read("-s 2 3 1 -o 0.5 -clamp on -bm 0.7 -imfchan l tex\\a b.png");
        assert_eq!(
            (found.name.path.as_str(), found.scale, found.offset),
            ("in/tex/a b.png", Vec2::new(2.0, 3.0), Vec2::new(0.5, 0.0))
        );
        assert!(found.is_clamped && found.strength == 0.7);
        assert_eq!(read("-bm 2 3.png").name.path, "in/3.png");
        for name in [
            "./a.png",
            ".\\a.png",
            ".\\\\a.png",
            "x\\..\\a.png",
            "C:\\b c\\a.png",
            "/b/a.png",
            "\\\\server\\a.png",
            "\"a.png\"",
        ] {
            assert_eq!(read(name).name.path, "in/a.png", "{name}");
        }
        assert_eq!(read("../a.png").name.path, "a.png");
        assert_eq!(read("../../a.png").name.path, "../a.png");
        assert!(map(b"-s 1 1 1", "").is_err() && map(b"", "").is_err());
    }
}
