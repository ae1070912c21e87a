//! Where surfaces lie in light maps: a UV set in which no two places of the scene share a texel.

use crate::BakeError;
use crate::progress::{Progress, Stage};
use crate::surfaces::{Place, Surfaces};
use glam::{Vec2, Vec3};
use uvunwrap::{Density, Error, MeshInput, Options, Packing};

/// The most texels of all pages together: more would take many hours, and memory that few machines have.
pub const TEXELS_MAX: u64 = 1 << 28;

/// The largest side of a page in texels that devices of the floor sample.
pub const SIDE_MAX: u32 = 8192;

/// From so many triangles on, charts are packed by a faster way that leaves more room between them.
const PACKED_WELL_MAX: usize = 20_000;

/// By how much the density is lowered where a surface does not fit into a page.
const DENSITY_STEP: f32 = 0.75;

/// How surfaces are laid out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LayoutSettings {
    /// Texels a metre of surface.
    pub texels_per_m: f32,
    /// The largest side of a page in texels.
    pub side_max: u32,
    /// Texels around every chart that belong to nothing else.
    pub padding: u32,
}

impl Default for LayoutSettings {
    fn default() -> Self {
        Self { texels_per_m: 16.0, side_max: 4096, padding: 2 }
    }
}

/// A primitive of a node with its place in the maps.
#[derive(Clone, Debug, PartialEq)]
pub struct UnwrappedPrimitive {
    /// Whose it is.
    pub place: Place,
    /// Which map.
    pub page: u32,
    /// Which vertex of the primitive each vertex is, and where it lies in the map: 0 to 1, v down. Where charts meet,
    /// vertices are there several times.
    pub vertices: Vec<(u32, Vec2)>,
    /// The same triangles in the same order, of these vertices.
    pub indices: Vec<u32>,
    /// The chart of every triangle.
    pub(crate) charts: Vec<u32>,
}

/// Light maps without light.
#[derive(Clone, Debug, PartialEq)]
pub struct Layout {
    /// The width of every page in texels.
    pub width: u32,
    /// The height.
    pub height: u32,
    /// How many there are.
    pub page_count: u32,
    /// What became of the density that was asked for, in texels a metre.
    pub texels_per_m: f32,
    /// Pieces into which surfaces were cut.
    pub chart_count: u32,
    /// The primitives that have a place.
    pub unwrapped: Vec<UnwrappedPrimitive>,
    /// Of all primitives of the surfaces, which of `unwrapped` each is.
    pub(crate) of_placed: Vec<Option<u32>>,
    /// What differs from what was asked for, one line each.
    pub notes: Vec<String>,
}

impl LayoutSettings {
    fn check(&self) -> Result<(), BakeError> {
        let Self { texels_per_m, side_max, padding } = *self;
        if !(texels_per_m.is_finite() && texels_per_m > 0.0) {
            return Err(BakeError::Setting(format!("a density of {texels_per_m} texels a metre; write one above 0")));
        }
        if !(16..=SIDE_MAX).contains(&side_max) {
            return Err(BakeError::Setting(format!("light maps of {side_max} texels a side; write 16 to {SIDE_MAX}")));
        }
        if padding == 0 || padding > side_max / 8 {
            let most = side_max / 8;
            return Err(BakeError::Setting(format!("{padding} texels around charts; write 1 to {most}")));
        }
        Ok(())
    }

    fn options(&self, texels_per_m: f32, page_size: Option<u32>, triangles: usize) -> Options {
        Options {
            density: Density::Fixed { texels_per_unit: texels_per_m, page_size },
            padding: self.padding,
            max_chart_size: self.side_max - 2 * self.padding,
            packing: if triangles > PACKED_WELL_MAX { Packing::Fast } else { Packing::Shape },
            ..Options::default()
        }
    }
}

/// The area of a primitive in square metres.
fn area(positions: &[Vec3], indices: &[u32]) -> f64 {
    let of_triangle = |corners: &[u32]| {
        let [a, b, c] = [0, 1, 2].map(|corner| positions[corners[corner] as usize]);
        f64::from(0.5 * (b - a).cross(c - a).length())
    };
    indices.chunks_exact(3).map(of_triangle).filter(|area| area.is_finite()).sum()
}

impl Layout {
    /// Lays out the surfaces that receive light.
    ///
    /// # Errors
    /// There are none, settings are out of range, or the maps would be too large.
    pub fn new(surfaces: &Surfaces, settings: &LayoutSettings, progress: &dyn Progress) -> Result<Self, BakeError> {
        settings.check()?;
        let receiving: Vec<usize> = (0..surfaces.placed.len())
            .filter(|index| surfaces.placed[*index].receives && !surfaces.placed[*index].indices.is_empty())
            .collect();
        let areas =
            receiving.iter().map(|index| area(&surfaces.placed[*index].positions, &surfaces.placed[*index].indices));
        let area: f64 = areas.sum();
        if area <= 0.0 {
            return Err(BakeError::Nothing);
        }
        let texels = area * f64::from(settings.texels_per_m).powi(2);
        if texels > TEXELS_MAX as f64 {
            let possible = (TEXELS_MAX as f64 / area).sqrt();
            return Err(BakeError::TooLarge { texels: texels as u64, texels_per_m: settings.texels_per_m, possible });
        }
        let positions: Vec<Vec<[f32; 3]>> = receiving
            .iter()
            .map(|index| surfaces.placed[*index].positions.iter().map(|position| position.to_array()).collect())
            .collect();
        let given: Vec<Option<Vec<[f32; 2]>>> = receiving.iter().map(|index| given_uv(surfaces, *index)).collect();
        let input = |(index, scales): (usize, &'static [f32])| {
            let placed = &surfaces.placed[receiving[index]];
            let mut input = MeshInput::new(&positions[index], &placed.indices);
            input.existing_uvs = given[index].as_deref();
            input.instance_scales = scales;
            input
        };
        let of_all = |scales| (0..receiving.len()).map(|index| input((index, scales))).collect::<Vec<_>>();
        let (atlas, mut notes) = pack(&of_all(&[]), &of_all(&[1.0]), settings, progress)?;
        let packed = u64::from(atlas.width) * u64::from(atlas.height) * u64::from(atlas.page_count);
        if packed > TEXELS_MAX {
            let possible = f64::from(settings.texels_per_m) * 0.5;
            return Err(BakeError::TooLarge { texels: packed, texels_per_m: settings.texels_per_m, possible });
        }
        if atlas.texels_per_unit < settings.texels_per_m {
            notes.push(format!(
                "a surface does not fit into {side} x {side} texels; the density is {:.3} in place of {} texels a metre",
                atlas.texels_per_unit,
                settings.texels_per_m,
                side = settings.side_max,
            ));
        }
        let mut of_placed = vec![None; surfaces.placed.len()];
        let mut unwrapped = Vec::new();
        for (mesh, index) in atlas.meshes.iter().zip(&receiving) {
            let rect = mesh.instances.first();
            let (page, min, extent) = rect.map_or((None, Vec2::ZERO, Vec2::ONE), |rect| {
                let (min, max) = (Vec2::from(rect.min), Vec2::from(rect.max));
                (Some(rect.page), min, max - min)
            });
            let page = page.or_else(|| mesh.vertices.iter().find_map(|vertex| vertex.page));
            let Some(page) = page else { continue };
            let vertex = |vertex: &uvunwrap::OutputVertex| (vertex.xref, min + Vec2::from(vertex.uv) * extent);
            let chart = |corners: &[u32]| mesh.vertices[corners[0] as usize].chart.unwrap_or(u32::MAX);
            of_placed[*index] = Some(unwrapped.len() as u32);
            unwrapped.push(UnwrappedPrimitive {
                place: surfaces.placed[*index].place,
                page,
                vertices: mesh.vertices.iter().map(vertex).collect(),
                indices: mesh.indices.clone(),
                charts: mesh.indices.chunks_exact(3).map(chart).collect(),
            });
        }
        Ok(Self {
            width: atlas.width,
            height: atlas.height,
            page_count: atlas.page_count,
            texels_per_m: atlas.texels_per_unit,
            chart_count: atlas.chart_count,
            unwrapped,
            of_placed,
            notes,
        })
    }

    /// Texels of all pages.
    pub fn texel_count(&self) -> usize {
        self.width as usize * self.height as usize * self.page_count as usize
    }
}

/// The second UV set of a primitive, if it has one of numbers.
fn given_uv(surfaces: &Surfaces, index: usize) -> Option<Vec<[f32; 2]>> {
    let placed = &surfaces.placed[index];
    let uv = &placed.uv[1];
    let is_whole = uv.len() == placed.positions.len() && uv.iter().all(|uv| uv.is_finite());
    is_whole.then(|| uv.iter().map(|uv| uv.to_array()).collect())
}

/// One page where all fits into it; else several, each mesh on one of them, at a density at which all fit.
fn pack(
    loose: &[MeshInput],
    whole: &[MeshInput],
    settings: &LayoutSettings,
    progress: &dyn Progress,
) -> Result<(uvunwrap::Atlas, Vec<String>), BakeError> {
    let triangles = loose.iter().map(|mesh| mesh.indices.len() / 3).sum();
    let generate = |meshes: &[MeshInput], options: &Options| {
        let tell = |of: uvunwrap::Progress| {
            progress.step(Stage::Layout, of.done as u64, of.total.map_or(0, |total| total as u64))
        };
        uvunwrap::generate_with_progress(meshes, options, tell)
    };
    let failed = |error: Error| match error {
        Error::Cancelled => BakeError::Interrupted,
        error => BakeError::Layout(error.to_string()),
    };
    let one = generate(loose, &settings.options(settings.texels_per_m, None, triangles));
    match one {
        Ok(atlas) if atlas.page_count == 1 && atlas.width.max(atlas.height) <= settings.side_max => {
            return Ok((atlas, Vec::new()));
        }
        Err(Error::Cancelled) => return Err(BakeError::Interrupted),
        Ok(_) | Err(_) => {}
    }
    let mut texels_per_m = settings.texels_per_m;
    loop {
        let options = settings.options(texels_per_m, Some(settings.side_max), triangles);
        match generate(whole, &options) {
            Ok(atlas) => return Ok((atlas, Vec::new())),
            Err(Error::ChartTooLarge { .. }) if texels_per_m > 1e-6 => texels_per_m *= DENSITY_STEP,
            Err(error) => return Err(failed(error)),
        }
    }
}
