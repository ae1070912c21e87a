//! The Rust that pages show: doc tests, so that it compiles. A test of the program `manypass` sees that each page has
//! these lines.

/// docs/baking.md.
///
/// ```no_run
/// # use manypass_bake::{DistantLight, BakeSettings, Encoding};
/// # use manypass_scene::{Scene, gltf_file::Parts};
/// # type Done = Result<(), Box<dyn std::error::Error>>;
/// # fn example(mut scene: Scene, environment: impl DistantLight, mut parts: Parts) -> Done {
/// let baked = manypass_bake::bake(&scene, Some(&environment), &BakeSettings::default(), &())?;
/// baked.apply(&mut scene)?;
/// baked.write(&mut parts, &scene, Encoding::Exr)?;
/// # Ok(())
/// # }
/// ```
pub struct BakingPage;

/// docs/probes.md.
///
/// ```no_run
/// # use manypass_bake::{DistantLight, ProbeBaker, ProbeSettings, Surfaces};
/// # use manypass_scene::{Scene, gltf_file::Parts, probes::ProbeGrid};
/// # type Done = Result<(), Box<dyn std::error::Error>>;
/// # fn example(mut scene: Scene, environment: impl DistantLight, mut parts: Parts) -> Done {
/// let surfaces = Surfaces::new(&scene);
/// let grid = ProbeGrid::over("room", &scene.bounds_world(), Some(0.5))?;
/// let baker = ProbeBaker::new(&scene, &surfaces, Some(&environment), vec![grid], &ProbeSettings::default())?;
/// scene.probes = baker.run(&(), &())?;
/// parts.put_probes(&scene.probes);
/// # Ok(())
/// # }
/// ```
pub struct ProbesPage;
