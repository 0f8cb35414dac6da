//! What tests of several models need.

use crate::{Changes, Model};
use lodc_fixtures as fixtures;
use lodc_mesh::{Lod, OrientedTriangle};

/// Writes down what goes and what comes.
#[derive(Debug, Default)]
pub(crate) struct Log {
    pub(crate) gone: Vec<OrientedTriangle>,
    pub(crate) came: Vec<OrientedTriangle>,
}

impl Changes for Log {
    fn gone(&mut self, triangle: OrientedTriangle) {
        self.gone.push(triangle);
    }
    fn came(&mut self, triangle: OrientedTriangle) {
        self.came.push(triangle);
    }
}

/// Walks over every step down and up, on a small mesh, then jumps, then takes small steps from
/// where a jump leads. What is shown and told must equal the reference, and moving without a
/// listener must do the same. `also` looks at the cursor after every move.
pub(crate) fn check_moves<M: Model>(name: &str, model: &M, mut also: impl FnMut(&M::Cursor)) {
    let collapses = model.simplified().collapses();
    let every = if collapses.parts().triangles <= 2_500 { 1 } else { 37 };
    let ends = std::iter::once(0).chain(collapses.parts().step_ends.iter().copied());
    let down: Vec<u32> = ends.step_by(every).collect();
    let up = down.iter().rev();
    let mut rng = fixtures::Rng::new(7);
    let last = collapses.records();
    let mut stops: Vec<u32> = down.iter().chain(up.clone()).copied().collect();
    stops.extend((0..60).map(|_| rng.below(last as usize + 1) as u32));
    stops.extend([last, 0, last, last / 2, last / 2 + 3, last / 3, 0, last]);
    stops.extend(up);

    let (mut cursor, mut deaf) = (model.cursor(), model.cursor());
    let mut before = model.triangles(&cursor);
    before.sort_unstable();
    for lod in stops.into_iter().map(Lod) {
        let (mut log, from) = (Log::default(), model.lod(&cursor));
        let traffic = model.seek(&mut cursor, lod, &mut log);
        assert_eq!(
            model.seek(&mut deaf, lod, &mut ()),
            traffic,
            "{name}: {from:?} → {lod:?}, nobody listens"
        );
        assert_eq!(model.lod(&cursor), collapses.floor(lod), "{name}: {from:?} → {lod:?}");
        let mut shown = model.triangles(&cursor);
        assert!(shown == model.triangles(&deaf), "{name}: {from:?} → {lod:?}, nobody listens");
        let mut truth = model.simplified().triangles_at(collapses.floor(lod));
        shown.sort_unstable();
        truth.sort_unstable();
        assert!(shown == truth, "{name}: {from:?} → {lod:?}: {}", first(&shown, &truth));
        log.gone.sort_unstable();
        log.came.sort_unstable();
        let told = (without(&before, &shown), without(&shown, &before));
        assert!(told == (log.gone, log.came), "{name}: {from:?} → {lod:?}, changes");
        also(&cursor);
        before = shown;
    }
}

/// What to print of two sorted lists that differ.
pub(crate) fn first(shown: &[OrientedTriangle], truth: &[OrientedTriangle]) -> String {
    let (extra, missing) = (without(shown, truth), without(truth, shown));
    format!(
        "{} too many from {:?}, {} missing from {:?}",
        extra.len(),
        extra.first(),
        missing.len(),
        missing.first()
    )
}

/// The multiset difference of two sorted lists.
pub(crate) fn without(
    all: &[OrientedTriangle],
    fewer: &[OrientedTriangle],
) -> Vec<OrientedTriangle> {
    let mut fewer = fewer.iter().peekable();
    let mut rest = Vec::new();
    for t in all {
        while fewer.peek().is_some_and(|f| *f < t) {
            fewer.next();
        }
        if fewer.peek() == Some(&t) {
            fewer.next();
        } else {
            rest.push(*t);
        }
    }
    rest
}
