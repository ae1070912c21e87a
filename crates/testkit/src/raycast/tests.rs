mod medium;
mod shadows;
mod surfaces;

use super::*;
use crate::scenes;

fn surface(base_color: f64, metallic: f64, roughness_perceptual: f64) -> Surface {
    Surface { base_color: DVec3::splat(base_color), metallic, roughness_perceptual, emission: DVec3::ZERO }
}

fn direction(cos: f64, azimuth: f64) -> DVec3 {
    let sin = (1.0 - cos * cos).sqrt();
    DVec3::new(sin * azimuth.cos(), sin * azimuth.sin(), cos)
}

#[test]
fn one_light_on_one_plane_is_the_closed_form() {
    let mut world = scenes::one_light_on_one_plane().world;
    // A rough dielectric keeps a specular lobe; a plane that reflects nothing but diffusely is what the closed form
    // says.
    let size = 65;
    let options = Options { multiple_scattering: false, ..Options::default() };
    let both = world.render(size, size, options);
    world.objects[0].surface.base_color = DVec3::ZERO;
    let specular = world.render(size, size, options);
    for i in 0..size * size {
        let position = both.position_world[i];
        let offset_m = position.x.hypot(position.z);
        // The plane is seen from straight above, so the half vector halves the angle at which the light stands.
        let cos_half = (0.5 * offset_m.atan()).cos();
        let transmitted = 0.96 * (1.0 - (1.0 - cos_half).powi(5));
        let expected = transmitted * lambert_below_point_light(1.0, 1.0, 1.0, offset_m);
        let found = f64::from(both.radiance[i][0]) - f64::from(specular.radiance[i][0]);
        assert!((found - expected).abs() < 1e-6, "{found} against {expected} at {position}");
        assert!((both.depth_view_m[i] - 3.0).abs() < 1e-6);
        assert_eq!(both.object_id[i], 1);
    }
}

#[test]
fn a_white_furnace_stays_white() {
    // An independent quadrature, uniform over the hemisphere, of a compensated lobe with f0 = 1.
    for roughness in [0.35, 0.6, 1.0] {
        let surface = surface(1.0, 1.0, roughness);
        let table = AlbedoTable::new(surface.roughness_alpha());
        for n_dot_v in [0.15, 0.5, 0.95] {
            let to_viewer = direction(n_dot_v, 0.0);
            let compensation = surface.compensation(table.get(n_dot_v));
            let cells = 500;
            let mut sum = 0.0;
            for cell in 0..cells * cells {
                let cos = (f64::from(cell % cells) + 0.5) / f64::from(cells);
                let azimuth = PI * (f64::from(cell / cells) + 0.5) / f64::from(cells);
                sum += surface.brdf(DVec3::Z, to_viewer, direction(cos, azimuth), compensation).x * cos;
            }
            let albedo = sum * 2.0 * PI / f64::from(cells * cells);
            assert!((albedo - 1.0).abs() < 0.01, "roughness {roughness}, N·V {n_dot_v}: {albedo}");
        }
    }
}

#[test]
fn light_may_go_either_way() {
    let surface = surface(0.6, 0.5, 0.4);
    for i in 0..100 {
        let a = direction(0.05 + 0.009 * f64::from(i), f64::from(i));
        let b = direction(0.95 - 0.007 * f64::from(i), 2.0 * f64::from(i));
        let forth = surface.brdf(DVec3::Z, a, b, DVec3::ONE);
        assert!((forth - surface.brdf(DVec3::Z, b, a, DVec3::ONE)).length() <= 1e-12 * forth.length());
    }
}

#[test]
fn range_and_cone_end_where_they_say() {
    let light = Light {
        emission: Emission::Spot { inner_cone_rad: 0.2, outer_cone_rad: 0.4 },
        position_world: DVec3::ZERO,
        direction_world: DVec3::NEG_Y,
        intensity: DVec3::ONE,
        range_m: Some(2.0),
        ..Light::default()
    };
    let irradiance =
        |angle: f64, distance_m: f64| light.arriving_at(distance_m * DVec3::new(angle.sin(), -angle.cos(), 0.0)).2.x;
    assert!((irradiance(0.1, 1.0) - (1.0 - 1.0 / 16.0)).abs() < 1e-12);
    assert_eq!(irradiance(0.41, 1.0), 0.0);
    assert_eq!(irradiance(0.0, 2.0), 0.0);
    assert!(irradiance(0.3, 1.0) > 0.0 && irradiance(0.3, 1.0) < 0.5);
}

#[test]
fn a_sphere_throws_a_shadow_on_the_side_away_from_the_sun() {
    let world = scenes::sun().world;
    let lit = world.render(96, 64, Options::default());
    let shadowed = world.render(96, 64, Options { shadows: true, ..Options::default() });
    // On the floor: in shadow exactly where the line to the sun passes within a radius of a centre.
    let to_light = -world.lights[0].direction_world;
    let mut count = 0;
    for i in (0..96 * 64).filter(|&i| lit.object_id[i] == 1) {
        let blocked = world.objects.iter().any(|object| match object.shape {
            Shape::Sphere { center_world, radius_m } => {
                to_light.cross(center_world - lit.position_world[i]).length() < radius_m
            }
            Shape::Quad { .. } => false,
        });
        count += usize::from(blocked);
        assert_eq!(shadowed.radiance[i] == [0.0; 3], blocked, "at {}", lit.position_world[i]);
    }
    assert!(count > 30, "{count} pixels in shadow");
}

#[test]
fn depth_is_along_the_axis_of_the_camera() {
    let mut world = scenes::one_light_on_one_plane().world;
    world.camera.lens = Lens::Perspective { fov_y_rad: 1.0 };
    let frame = world.render(9, 5, Options::default());
    assert!(frame.depth_view_m.iter().all(|depth_m| (depth_m - 3.0).abs() < 1e-6));
    // The camera looks down with −Z of the world upwards in the picture.
    assert!(frame.position_world[0].x < 0.0 && frame.position_world[0].z < 0.0);
}
