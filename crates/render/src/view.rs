//! A camera's view of the scene, and the uniform that holds it (`view.wgsl`).

use bytemuck::{Pod, Zeroable};
use glam::{Mat4, Vec2, Vec4};
use manypass_scene::{Aabb, Framing, Projection, Scene};

/// A camera: where it stands, and its projection.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// The camera's transform: it looks along its −Z, with its +Y up.
    pub world_from_view: Mat4,
    /// How space is mapped to the picture. The picture's width follows from the target's shape.
    pub projection: Projection,
}

/// The uniform of `view.wgsl`; a test compares the two layouts.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct ViewUniform {
    /// Clip from world space.
    pub clip_from_world: Mat4,
    /// View from world space.
    pub view_from_world: Mat4,
    /// World from view space.
    pub world_from_view: Mat4,
    /// Half the extent of the picture in view space, at a distance of 1 m if the projection is perspective.
    pub view_from_ndc_scale: Vec2,
    /// The offset of this sample within the pixel.
    pub jitter_ndc: Vec2,
    /// Coefficients of the distance as a function of depth.
    pub distance_from_depth: Vec4,
    /// The target's size.
    pub size_px: Vec2,
    /// Its inverse.
    pub inverse_size_px: Vec2,
    /// 1 if the rays are parallel, else 0.
    pub orthographic: f32,
    /// Radiance in the frame is multiplied by this.
    pub pre_exposure: f32,
    /// Which of the accumulated frames this is.
    pub sample_index: u32,
    /// By how many levels mips of textures are finer than for a single sample.
    pub mip_gain: f32,
    /// The anisotropy of their samplers.
    pub anisotropy: f32,
    /// From pre-exposed radiance to the display, for the marks of what glows; 0 where there are none.
    pub glow_exposure: f32,
    /// By how much depth rises along x and y of view space, at a distance of 1 m if the projection is perspective: 0
    /// unless a plane cuts the view.
    pub depth_slope: Vec2,
}

/// The distances of the near and far planes along the view axis, in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DepthRange {
    /// The nearest distance.
    pub near_m: f32,
    /// The farthest distance.
    pub far_m: f32,
}

/// A camera now and in the previous frame, for what moved in between.
#[derive(Clone, Copy, Debug)]
pub struct CameraStep {
    /// Now.
    pub current: View,
    /// In the previous frame.
    pub previous: View,
    /// The range of distances of both.
    pub range: DepthRange,
    /// Width and height of the picture in pixels; both have its shape.
    pub output_size: (u32, u32),
}

impl ViewUniform {
    /// The same view without what lies on the negative side of a plane (`plane_world · (x, y, z, 1) < 0`): the plane
    /// takes the place of the near plane. A plane through the eye leaves depth nothing to tell distances by. Depth is
    /// then no function of the distance alone, and `depth_slope` says how it differs.
    ///
    /// Source: Lengyel 2005, "Oblique View Frustum Depth Projection and Clipping", for reversed depth: z = w − s ·
    /// plane, with s so large that depth spans all of its range and reaches 0 nowhere in the frustum.
    pub(crate) fn cut_by(mut self, plane_world: Vec4, range: DepthRange) -> Self {
        let plane = self.world_from_view.transpose() * plane_world;
        let is_orthographic = self.orthographic > 0.5;
        // The greatest value of plane · p / w in the frustum, which has no far end if the projection is perspective. Where
        // the picture is moved, as for a point of a lens, so is the frustum.
        let slope = plane.truncate().truncate() * self.view_from_ndc_scale;
        let across = slope.abs().element_sum() - slope.dot(self.jitter_ndc);
        let [near, far] = if is_orthographic {
            [range.near_m, range.far_m].map(|distance_m| across - plane.z * distance_m + plane.w)
        } else {
            [across - plane.z + plane.w / range.near_m, across - plane.z]
        };
        let greatest = near.max(far);
        // A little less than that, so that the farthest surface is no background; jitter moves corners by less.
        let scale = if greatest > 0.0 { 0.99 / greatest } else { 1.0 };
        let cut = self.clip_from_world.row(3) - scale * plane_world;
        for (column, z) in [cut.x, cut.y, cut.z, cut.w].into_iter().enumerate() {
            self.clip_from_world.col_mut(column).z = z;
        }
        let w_row = if is_orthographic { Vec4::W } else { -Vec4::Z };
        let z_row = w_row - scale * plane;
        self.distance_from_depth = Vec4::new(z_row.w, w_row.w, z_row.z, w_row.z);
        self.depth_slope = Vec2::new(z_row.x, z_row.y);
        self
    }
}

impl ViewUniform {
    /// The same view of a part of its picture alone: x and y of the corner, width and height in pixels. For culling.
    pub(crate) fn cropped(mut self, [x, y, width, height]: [u32; 4]) -> Self {
        let size = Vec2::new(width as f32, height as f32);
        let scale = self.size_px / size;
        // The middle of the part, in the whole picture's coordinates.
        let middle = (Vec2::new(x as f32, y as f32) + 0.5 * size) * self.inverse_size_px;
        let middle = (2.0 * middle - 1.0) * Vec2::new(1.0, -1.0);
        let crop = Mat4::from_cols(
            Vec4::new(scale.x, 0.0, 0.0, 0.0),
            Vec4::new(0.0, scale.y, 0.0, 0.0),
            Vec4::Z,
            Vec4::new(-middle.x * scale.x, -middle.y * scale.y, 0.0, 1.0),
        );
        self.clip_from_world = crop * self.clip_from_world;
        self
    }
}

impl View {
    /// The scene's first camera; without one, what [`Framing::automatic`] gives: all of the scene from 30° to the right
    /// and 28° above, or a room from inside. `aspect` is the picture's width / height. As of the last
    /// [`Scene::update_transforms`].
    pub fn of_scene(scene: &Scene, aspect: f32) -> Self {
        if let Some((world_from_view, projection)) = scene.first_camera(aspect) {
            return Self { world_from_view, projection };
        }
        Self::framing(&Framing::of_scene(scene), aspect)
    }

    /// The camera that frames all of `framing`, as [`Framing::automatic`] does. `aspect` is the picture's width / height.
    pub fn framing(framing: &Framing, aspect: f32) -> Self {
        let (world_from_view, projection) = framing.automatic(aspect);
        Self { world_from_view, projection }
    }

    /// The range of distances fitted to `bounds`, inside the camera's own planes if it has them.
    pub fn depth_range(&self, bounds_world: &Aabb) -> DepthRange {
        let view_from_world = self.world_from_view.inverse();
        let (mut near, mut far) = (f32::INFINITY, 0.0f32);
        if !bounds_world.is_empty() {
            for corner in bounds_world.corners() {
                let distance = -view_from_world.transform_point3(corner).z;
                near = near.min(distance);
                far = far.max(distance);
            }
        }
        let (near_limit, far_limit) = match self.projection {
            Projection::Perspective { near_m, far_m, .. } => (near_m, far_m.unwrap_or(f32::INFINITY)),
            Projection::Orthographic { near_m, far_m, .. } => (near_m, far_m),
        };
        // A little room, because bounds touch the surfaces they enclose.
        let far_m = (far * 1.001 + 1e-4).min(far_limit).max(near_limit * 1.001 + 1e-6);
        let near_m = (near * 0.999).max(near_limit).min(far_m * 0.999);
        DepthRange { near_m, far_m }
    }

    /// Half the extent of the picture in view space: at 1 m for perspective, in metres for parallel rays.
    pub fn half_extent(&self, aspect: f32) -> Vec2 {
        self.projection.half_extent(aspect)
    }

    /// How many pixels wide a metre is at a distance from the eye, in a picture of `size_px`, near its middle.
    pub(crate) fn pixels_per_m(&self, (width, height): (u32, u32), distance_m: f32) -> f32 {
        let (width, height) = (width as f32, height as f32);
        let half_extent = self.half_extent(width / height.max(1.0));
        0.5 * height / (half_extent.y * if self.is_orthographic() { 1.0 } else { distance_m })
    }

    /// Whether the projection is orthographic.
    pub fn is_orthographic(&self) -> bool {
        matches!(self.projection, Projection::Orthographic { .. })
    }

    /// Whether the camera's own far plane lies before the end of `range`'s scene, so that it cuts something off.
    fn cuts_at_far(&self, range: DepthRange) -> bool {
        matches!(self.projection, Projection::Perspective { far_m: Some(limit_m), .. } if range.far_m >= limit_m)
    }

    /// The projection with reversed depth: 1 at the near plane, 0 infinitely far away, where nothing is; at the far
    /// plane where the camera's own one cuts something off, and with parallel rays, whose range ends behind the scene.
    /// Surfaces near a plane of depth 0 would be background where depth has 24 bits or is remapped (WebGL 2).
    pub fn clip_from_view(&self, range: DepthRange, aspect: f32, jitter_ndc: Vec2) -> Mat4 {
        let scale = self.half_extent(aspect).recip();
        let DepthRange { near_m: n, far_m: f } = range;
        if self.is_orthographic() {
            Mat4::from_cols(
                Vec4::new(scale.x, 0.0, 0.0, 0.0),
                Vec4::new(0.0, scale.y, 0.0, 0.0),
                Vec4::new(0.0, 0.0, 1.0 / (f - n), 0.0),
                Vec4::new(jitter_ndc.x, jitter_ndc.y, f / (f - n), 1.0),
            )
        } else {
            let (z, w) = if self.cuts_at_far(range) { (n / (f - n), n * f / (f - n)) } else { (0.0, n) };
            Mat4::from_cols(
                Vec4::new(scale.x, 0.0, 0.0, 0.0),
                Vec4::new(0.0, scale.y, 0.0, 0.0),
                Vec4::new(-jitter_ndc.x, -jitter_ndc.y, z, -1.0),
                Vec4::new(0.0, 0.0, w, 0.0),
            )
        }
    }

    /// The uniform for a target of `width` × `height` pixels.
    pub fn uniform(
        &self,
        range: DepthRange,
        width: u32,
        height: u32,
        jitter_px: Vec2,
        pre_exposure: f32,
        sample_index: u32,
    ) -> ViewUniform {
        let size_px = Vec2::new(width as f32, height as f32);
        let jitter_ndc = jitter_px * 2.0 / size_px * Vec2::new(1.0, -1.0);
        let aspect = size_px.x / size_px.y;
        let clip_from_view = self.clip_from_view(range, aspect, jitter_ndc);
        let view_from_world = self.world_from_view.inverse();
        let (z, w) = (clip_from_view.z_axis, clip_from_view.w_axis);
        ViewUniform {
            clip_from_world: clip_from_view * view_from_world,
            view_from_world,
            world_from_view: self.world_from_view,
            view_from_ndc_scale: self.half_extent(aspect),
            jitter_ndc,
            // depth · (z.w · z_view + w.w) = z.z · z_view + w.z, solved for −z_view.
            distance_from_depth: Vec4::new(w.z, w.w, z.z, z.w),
            size_px,
            inverse_size_px: size_px.recip(),
            orthographic: if self.is_orthographic() { 1.0 } else { 0.0 },
            pre_exposure,
            sample_index,
            mip_gain: 0.0,
            anisotropy: 1.0,
            glow_exposure: 0.0,
            depth_slope: Vec2::ZERO,
        }
    }

    /// The uniform for a picture of `output_size` that is shaded at `shaded_size`, both in pixels. Sides are rounded to
    /// whole pixels, so the two may differ in shape; what is seen is the picture's shape. The jitter is in shaded
    /// pixels.
    pub(crate) fn uniform_shaded(
        &self,
        range: DepthRange,
        output_size: (u32, u32),
        shaded_size: (u32, u32),
        jitter_px: Vec2,
        pre_exposure: f32,
        sample_index: u32,
    ) -> ViewUniform {
        let shaded_px = Vec2::new(shaded_size.0 as f32, shaded_size.1 as f32);
        let output_per_shaded = Vec2::new(output_size.0 as f32, output_size.1 as f32) / shaded_px;
        let jitter_output_px = jitter_px * output_per_shaded;
        let uniform = self.uniform(range, output_size.0, output_size.1, jitter_output_px, pre_exposure, sample_index);
        ViewUniform { size_px: shaded_px, inverse_size_px: shaded_px.recip(), ..uniform }
    }
}

/// Where four samples lie: a rotated grid, moved so that the first is in the middle, as variables need it. Every quarter
/// of a pixel has one sample, across and down, so that what is thinner than a pixel and lies along its sides is covered
/// within a quarter of it. The first four points of the R2 sequence, of which these are the nearest, leave out 0.43 of a
/// pixel down.
const FOUR_PX: [[f32; 2]; 4] = [[0.0, 0.0], [-0.25, -0.5], [-0.5, 0.25], [0.25, -0.25]];

/// The offset of a sample from the pixel's middle, in pixels: the R2 sequence (Roberts 2018), which fills the square
/// evenly for any number of samples; of four, a rotated grid. A single sample lies in the middle. A sample stays within
/// its pixel: lists of lights are those of all samples.
pub fn jitter_px(sample_index: u32, sample_count: u32) -> Vec2 {
    if sample_count <= 1 {
        return Vec2::ZERO;
    }
    if let (4, Some(place_px)) = (sample_count, FOUR_PX.get(sample_index as usize)) {
        return Vec2::from_array(*place_px);
    }
    // The inverses of the plastic number and of its square.
    let n = f64::from(sample_index);
    let fraction = |step: f64| ((0.5 + n * step).fract() - 0.5) as f32;
    Vec2::new(fraction(0.754_877_666_246_692_8), fraction(0.569_840_290_998_053_2))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shader::layout::assert_same_layout;
    use glam::Vec3;

    #[test]
    fn samples_stay_within_their_pixels() {
        let farthest = (0..10_000).map(|sample| jitter_px(sample, 10_000).abs().max_element()).fold(0.0, f32::max);
        assert!((0.49..=0.5).contains(&farthest), "{farthest}");
    }

    #[test]
    fn of_four_samples_every_quarter_of_a_pixel_has_one() {
        let places = [0, 1, 2, 3].map(|sample| jitter_px(sample, 4));
        assert_eq!(places[0], Vec2::ZERO);
        for axis in 0..2 {
            let mut along = places.map(|place| place[axis]);
            along.sort_by(f32::total_cmp);
            assert_eq!(along, [-0.5, -0.25, 0.0, 0.25]);
        }
    }

    #[test]
    fn shading_at_another_size_keeps_the_shape_of_what_is_seen() {
        let projection = Projection::Perspective { fov_y_rad: 0.8, near_m: 0.1, far_m: None };
        let view = View { world_from_view: Mat4::IDENTITY, projection };
        let range = DepthRange { near_m: 0.5, far_m: 60.0 };
        // A quarter of 97 × 73, rounded: a little wider.
        let whole = view.uniform(range, 97, 73, Vec2::ZERO, 1.0, 0);
        let shaded = view.uniform_shaded(range, (97, 73), (24, 18), Vec2::ZERO, 1.0, 0);
        assert_eq!(whole.clip_from_world, shaded.clip_from_world);
        assert_eq!(shaded.size_px, Vec2::new(24.0, 18.0));
        // Half a shaded pixel to the right is 1/24 of the picture's width in the units of ndc.
        let jittered = view.uniform_shaded(range, (97, 73), (24, 18), Vec2::new(0.5, 0.0), 1.0, 0);
        assert!((jittered.jitter_ndc.x - 1.0 / 24.0).abs() < 1e-6, "{}", jittered.jitter_ndc);
    }

    /// The depth that WebGL 2 stores in 24 bits for a point at a distance: z goes from 0 … w to −w … w and back.
    fn depth_on_webgl2(clip_from_view: &Mat4, distance_m: f32) -> f32 {
        let clip = *clip_from_view * Vec4::new(0.0, 0.0, -distance_m, 1.0);
        let depth = ((2.0 * clip.z - clip.w) / clip.w) * 0.5 + 0.5;
        const STEPS: f32 = 16_777_215.0;
        (depth * STEPS).round() / STEPS
    }

    #[test]
    fn the_farthest_surface_is_no_background() {
        for near_m in [0.01, 0.1] {
            let projection = Projection::Perspective { fov_y_rad: 0.8, near_m, far_m: None };
            let view = View { world_from_view: Mat4::IDENTITY, projection };
            for far_m in [20.0f32, 1e3, 1e4] {
                let bounds = Aabb { min: Vec3::new(-far_m, -1.0, -far_m), max: Vec3::new(far_m, 1.0, 2.0) };
                let clip_from_view = view.clip_from_view(view.depth_range(&bounds), 1.5, Vec2::ZERO);
                let depth = depth_on_webgl2(&clip_from_view, far_m);
                assert!(depth > 0.0, "near {near_m}, at {far_m}: the depth of the background");
            }
        }
    }

    #[test]
    fn a_far_plane_that_cuts_the_scene_clips() {
        let bounds = Aabb { min: Vec3::splat(-100.0), max: Vec3::splat(100.0) };
        for projection in [
            Projection::Perspective { fov_y_rad: 0.8, near_m: 0.1, far_m: Some(50.0) },
            Projection::Orthographic { height_m: 4.0, near_m: 0.1, far_m: 50.0 },
        ] {
            let view = View { world_from_view: Mat4::IDENTITY, projection };
            let clip_from_view = view.clip_from_view(view.depth_range(&bounds), 1.5, Vec2::ZERO);
            let depth = |distance_m: f32| (clip_from_view * Vec4::new(0.0, 0.0, -distance_m, 1.0)).z;
            assert!(depth(49.9) > 0.0 && depth(50.1) < 0.0, "{projection:?}");
        }
    }

    #[test]
    fn distance_comes_back_from_depth() {
        for projection in [
            Projection::Perspective { fov_y_rad: 0.8, near_m: 0.1, far_m: None },
            Projection::Orthographic { height_m: 4.0, near_m: 0.1, far_m: 100.0 },
        ] {
            let view = View { world_from_view: Mat4::IDENTITY, projection };
            let range = DepthRange { near_m: 0.5, far_m: 60.0 };
            let uniform = view.uniform(range, 200, 100, Vec2::new(0.3, -0.2), 1.0, 0);
            for distance in [0.5f32, 1.0, 7.5, 59.0] {
                let point = Vec3::new(0.1, -0.2, -distance);
                let clip = uniform.clip_from_world * point.extend(1.0);
                let depth = clip.z / clip.w;
                let k = uniform.distance_from_depth;
                let formula = (k.x - depth * k.y) / (k.z - depth * k.w);
                assert!((formula - distance).abs() < 2e-3 * distance, "{formula} {distance}");
                let ndc = Vec2::new(clip.x, clip.y) / clip.w;
                let plane = (ndc - uniform.jitter_ndc)
                    * uniform.view_from_ndc_scale
                    * if uniform.orthographic > 0.5 { 1.0 } else { distance };
                assert!((plane - Vec2::new(0.1, -0.2)).length() < 1e-4, "{plane}");
            }
        }
    }

    #[test]
    fn the_uniform_has_one_layout() {
        assert_same_layout!(
            "forward",
            "View",
            ViewUniform,
            [
                clip_from_world,
                view_from_world,
                world_from_view,
                view_from_ndc_scale,
                jitter_ndc,
                distance_from_depth,
                size_px,
                inverse_size_px,
                orthographic,
                pre_exposure,
                sample_index,
                mip_gain,
                anisotropy,
                glow_exposure,
                depth_slope,
            ]
        );
    }
}
