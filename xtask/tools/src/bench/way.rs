//! The ways of lighting that are measured, and how much time each may take.

/// How the picture of a way is held against that of brute force.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Judgement {
    AsDeferred,
    /// Surfaces do not go through the G-buffer.
    AsForward,
    /// It is another picture on purpose.
    NotCompared,
}

/// A way of lighting: a column of a table.
#[derive(Debug)]
pub(super) struct Way {
    pub name: &'static str,
    pub arguments: &'static [&'static str],
    pub judged: Judgement,
    /// The most lights with which a turn takes seconds, and with which a single frame takes a minute at most.
    most_lights: (usize, usize),
    /// Whether every visited pair is blended into the target.
    pub blends_pairs: bool,
}

/// How much is measured of a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Effort {
    Frames,
    /// One frame, with what is made once.
    FirstFrame,
    LeftOut,
}

impl Way {
    const fn deferred(name: &'static str, arguments: &'static [&'static str]) -> Self {
        Self {
            name,
            arguments,
            judged: Judgement::AsDeferred,
            most_lights: (usize::MAX, usize::MAX),
            blends_pairs: false,
        }
    }

    /// How much is measured of it with so many lights.
    pub fn effort(&self, lights: usize) -> Effort {
        let (frames, first_frame) = self.most_lights;
        match lights {
            lights if lights <= frames => Effort::Frames,
            lights if lights <= first_frame => Effort::FirstFrame,
            _ => Effort::LeftOut,
        }
    }
}

pub(super) static CLUSTERED: Way = Way::deferred("clustered", &["--light-culling", "clustered"]);
static TILED: Way = Way::deferred("tiled", &["--light-culling", "tiled"]);
static VOLUMES: Way = Way { blends_pairs: true, ..Way::deferred("volumes", &["--light-culling", "volumes"]) };
static VOLUMES_STENCIL: Way =
    Way { blends_pairs: true, ..Way::deferred("volumes-stencil", &["--light-culling", "volumes-stencil"]) };
pub(super) static FORWARD: Way =
    Way { judged: Judgement::AsForward, ..Way::deferred("forward", &["--path", "forward"]) };
static FORWARD_BATCHED: Way = Way {
    judged: Judgement::AsForward,
    most_lights: (64, 1024),
    ..Way::deferred("forward-batched", &["--path", "forward-batched"])
};
static GOURAUD: Way = Way {
    judged: Judgement::NotCompared,
    most_lights: (1024, usize::MAX),
    ..Way::deferred("gouraud", &["--path", "gouraud"])
};
/// Every pixel visits every light. All others are held against its picture, so that it is never left out.
pub(super) static BRUTE_FORCE: Way =
    Way { most_lights: (64, usize::MAX), ..Way::deferred("none", &["--light-culling", "none"]) };

/// All of them, in the order of the columns.
pub(super) static WAYS: [&Way; 8] =
    [&CLUSTERED, &TILED, &VOLUMES, &VOLUMES_STENCIL, &FORWARD, &FORWARD_BATCHED, &GOURAUD, &BRUTE_FORCE];

const LESS: [&str; 2] = ["--set", "lod.materials=true"];
const COARSER: [&str; 2] = ["--set", "lod.simplify=true"];

/// What levels of detail leave out, all first.
pub(super) static LEVELS: [&Way; 6] = [
    &Way { judged: Judgement::NotCompared, ..Way::deferred("all", &["--set", "lod.enabled=false"]) },
    &Way {
        judged: Judgement::NotCompared,
        ..Way::deferred(
            "no normal maps and coats",
            &[LESS[0], LESS[1], "--set", "lod.plain_px=0", "--set", "lod.untextured_px=0"],
        )
    },
    &Way {
        judged: Judgement::NotCompared,
        ..Way::deferred("and no layers", &[LESS[0], LESS[1], "--set", "lod.untextured_px=0"])
    },
    &Way { judged: Judgement::NotCompared, ..Way::deferred("and no textures", &LESS) },
    &Way { judged: Judgement::NotCompared, ..Way::deferred("coarser meshes", &COARSER) },
    &Way {
        judged: Judgement::NotCompared,
        ..Way::deferred("coarser meshes, no textures", &[LESS[0], LESS[1], COARSER[0], COARSER[1]])
    },
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_takes_minutes_is_left_out_but_for_the_truth() {
        let efforts = |way: &Way| [16, 1024, 10_000].map(|lights| way.effort(lights));
        assert_eq!(efforts(&CLUSTERED), [Effort::Frames; 3]);
        assert_eq!(efforts(&FORWARD_BATCHED), [Effort::Frames, Effort::FirstFrame, Effort::LeftOut]);
        assert_eq!(efforts(&BRUTE_FORCE), [Effort::Frames, Effort::FirstFrame, Effort::FirstFrame]);
    }
}
