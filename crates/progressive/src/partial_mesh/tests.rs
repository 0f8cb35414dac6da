use crate::partial_mesh::mesh::PartialMesh;
use crate::partial_mesh::new_triangle::{NewTriangle, Side};
use crate::partial_mesh::split::{Arcs, ParentStar, SplitBuffers, SplitEdge};
use crate::partial_mesh::star::{LinkVertex, StarFace, collect_link};
use lodc_mesh::NONE;

/// Vertex 0 amid vertices 1 to 6.
fn hexagon() -> PartialMesh {
    let mut mesh = PartialMesh::default();
    for _ in 0..8 {
        mesh.add_vertex(0);
    }
    let triangles: Vec<NewTriangle> =
        (1..7).map(|i| NewTriangle::unconnected(i, i % 6 + 1, Side::Detached)).collect();
    let empty = ParentStar { faces: &[], transfer: &[], is_part: false };
    let edge = SplitEdge { parent: 7, new: 0 };
    mesh.split(edge, empty, &triangles, &mut SplitBuffers::default(), &mut Vec::new());
    mesh
}

fn star_and_link(mesh: &PartialMesh, vertex: u32) -> (Vec<StarFace>, Vec<LinkVertex>, bool) {
    let (mut star, mut link) = (Vec::new(), Vec::new());
    let closed = mesh.collect_star(vertex, &mut star);
    collect_link(&star, &mut link);
    (star, link, closed)
}

fn vertices(link: &[LinkVertex]) -> Vec<u32> {
    link.iter().map(|l| l.vertex).collect()
}

/// Which function splits the mesh.
#[derive(Clone, Copy, PartialEq)]
enum SplitBy {
    General,
    Arcs,
}

/// The hexagon split at vertices 3 (left) and 6 (right).
fn split(by: SplitBy) -> PartialMesh {
    let mut mesh = hexagon();
    let (star, link, closed) = star_and_link(&mesh, 0);
    assert!(closed);
    assert_eq!(vertices(&link), [1, 2, 3, 4, 5, 6]);
    assert_eq!((link[0].outgoing, link[0].incoming), (0, 5));
    let edge = SplitEdge { parent: 0, new: 7 };
    if by == SplitBy::Arcs {
        let arcs = Arcs { first_kept: 2, first_transferred: 5 };
        let mut new_link = Vec::new();
        assert!(mesh.split_arcs(edge, &star, arcs, &mut new_link));
        assert_eq!(new_link, [6, 1, 2, 3, 0]);
        return mesh;
    }
    let connected = |l: LinkVertex, mut t: NewTriangle| {
        (t.outgoing, t.incoming) = (l.outgoing, l.incoming);
        t
    };
    let left = connected(link[2], NewTriangle::unconnected(3, 0, Side::Left));
    let right = connected(link[5], NewTriangle::unconnected(0, 6, Side::Right));
    let transfer = [true, true, false, false, false, true];
    let parent = ParentStar { faces: &star, transfer: &transfer, is_part: false };
    let mut new_star = Vec::new();
    mesh.split(edge, parent, &[left, right], &mut SplitBuffers::default(), &mut new_star);
    let edges: Vec<_> = new_star.iter().map(|f| (f.a, f.b)).collect();
    assert_eq!(edges, [(6, 1), (1, 2), (2, 3), (3, 0), (0, 6)]);
    mesh
}

#[test]
fn corner_lists_stay_in_the_order_of_fans() {
    for mesh in [split(SplitBy::General), split(SplitBy::Arcs)] {
        // The lists of vertices 3 and 6 were in no order before; a new corner is inserted beside
        // its neighbour.
        let closed = [(0, &[7, 3, 4, 5, 6][..], true), (7, &[6, 1, 2, 3, 0], true)];
        let open = [(3, &[7, 2, 4, 0, 7][..], false), (6, &[0, 5, 1, 7, 0], false)];
        for (vertex, expected, closes) in closed.into_iter().chain(open) {
            let (_, link, closed) = star_and_link(&mesh, vertex);
            assert_eq!((vertices(&link), closed), (expected.to_vec(), closes), "vertex {vertex}");
        }
    }
}

#[test]
fn open_fans_follow_one_another() {
    let face = |a, b| StarFace { corner: 0, a, b };
    let mut link = Vec::new();
    collect_link(&[face(3, 2), face(2, 1), face(5, 6)], &mut link);
    assert_eq!(vertices(&link), [3, 2, 1, 5, 6]);
    assert_eq!((link[1].outgoing, link[1].incoming), (1, 0));
    assert_eq!((link[4].outgoing, link[4].incoming), (NONE, 2));
    collect_link(&[], &mut link);
    assert!(link.is_empty());
}
