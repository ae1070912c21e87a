//! Mirrors: what is seen behind them is kept for the view that shows them.

use super::ask::ViewRequest;
use super::prepare_view::ViewSetup;
use super::record_inputs::EarlierResults;
use super::view_kind::{MirrorLink, MirrorView, Reflector};
use crate::frame;
use crate::gbuffer::ViewOutputs;
use crate::mirror_picture::MirrorPicture;
use crate::outline::rectangle_of;
use crate::passes::mirrors::MirrorDraw;
use crate::record::Recorder;
use crate::request::RenderError;
use std::collections::BTreeMap;

/// The mirrors that a view shows; `behind` has what views behind them left, by the views' names.
pub(super) fn shown(
    (asked, setup): (&ViewRequest, &ViewSetup),
    behind: &mut BTreeMap<String, MirrorPicture>,
) -> Vec<MirrorDraw> {
    let shown = |link: &MirrorLink| {
        let Reflector::Node(node) = link.of else { return None };
        Some(MirrorDraw {
            object: node.0 + 1,
            normal_world: link.normal_world,
            is_smooth: link.is_smooth,
            rectangle: rectangle_of(&setup.view.uniform, link.corners_world, setup.view.size),
            picture: behind.remove(&link.view)?,
        })
    };
    asked.mirrors.iter().filter_map(shown).collect()
}

/// Keeps what is seen behind a mirror or water, or through a portal, for the view that shows it.
pub(super) fn record_behind(
    r: &mut Recorder<'_, '_>,
    view: &MirrorView,
    asked: &ViewRequest,
    outputs: ViewOutputs,
    before: &mut EarlierResults<'_>,
) -> Result<(), RenderError> {
    let ViewOutputs { radiance, gbuffer, .. } = outputs;
    if let Reflector::Portal(..) = view.of {
        before.through.insert(asked.name.clone(), radiance);
    } else if let Some(gbuffer) = gbuffer {
        let picture = frame::mirror_picture_passes(r, view.is_smooth, radiance, gbuffer.linear_depth)?;
        before.behind.insert(asked.name.clone(), picture);
    }
    Ok(())
}
