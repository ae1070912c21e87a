//! The life of a frame: resolve, ask, prepare, record, submit, read.

use super::Renderer;
use super::ask::FrameViews;
use super::next::NextState;
use super::purpose::Purpose;
use super::read::FrameReadings;
use super::resolve::ResolvedFrame;
use super::submit::{SubmittedFrame, limits_of};
use crate::record::Legends;
use crate::request::{FrameRequest, RenderError};
use manypass_scene::Scene;

impl Renderer {
    /// Runs a frame of `views`, innermost first, for a purpose; those that are no picture have one view.
    pub(super) async fn run(
        &mut self,
        scene: &Scene,
        views: &[(&str, &FrameRequest)],
        purpose: &Purpose<'_>,
    ) -> Result<FrameReadings, RenderError> {
        let resolved = self.resolve(scene, views, purpose).await?;
        self.run_views(scene, resolved, purpose).await
    }

    /// Runs a frame whose views are known.
    pub(super) async fn run_views(
        &mut self,
        scene: &Scene,
        resolved: ResolvedFrame,
        purpose: &Purpose<'_>,
    ) -> Result<FrameReadings, RenderError> {
        let ResolvedFrame { captures, next } = resolved;
        let mut views = self.ask(scene, captures, purpose)?;
        let submitted = self.draw(scene, &mut views, next, purpose);
        let requests = self.keep_views(views, submitted.as_ref().err(), purpose);
        self.read(scene, &requests, submitted?, purpose).await
    }

    /// Prepares, records and submits a frame, as far as its purpose wants that.
    fn draw(
        &mut self,
        scene: &Scene,
        views: &mut FrameViews,
        mut next: NextState,
        purpose: &Purpose<'_>,
    ) -> Result<SubmittedFrame, RenderError> {
        let start = self.begin_frame(scene, views, purpose)?;
        let prepared = self.prepare_scene(scene, views, &mut next, purpose);
        if purpose.ends_at_shadows {
            self.world_draws = prepared.scene.draws;
            let plan = self.executor.graph(limits_of(&self.gpu)).plan()?;
            return Ok(SubmittedFrame::planned(plan, Vec::new(), Legends::default(), &next));
        }
        let prepared = self.prepare_views(prepared, views, start, &mut next, purpose)?;
        self.record_and_submit(prepared, views, next, purpose)
    }
}
