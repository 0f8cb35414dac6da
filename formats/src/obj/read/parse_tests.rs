use super::*;
use crate::faces::NONE;

fn read(source: &str) -> Parsed {
    parse(source.as_bytes(), &Limits::DEFAULT).expect(source)
}

fn refused(source: &str) -> FormatError {
    parse(source.as_bytes(), &Limits::DEFAULT).expect_err(source)
}

const THREE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

#[test]
fn corners_take_every_form_and_negative_indices_count_back() {
    let p = read(&format!(
        "{THREE}vt 0 0\nvt 1 1\nvn 0 0 1\nf 1 2 3\nf 1/1 2/2 3/\nf 1//1 -2//-1 3//\n\
            f 1/-1/1 2/-2/1 3/1/1\n"
    ));
    assert_eq!(p.faces.corner_v, [0, 1, 2, 0, 1, 2, 0, 1, 2, 0, 1, 2]);
    assert_eq!(p.faces.corner_t, [NONE, NONE, NONE, 0, 1, NONE, NONE, NONE, NONE, 1, 0, 0]);
    assert_eq!(p.faces.corner_n, [NONE, NONE, NONE, NONE, NONE, NONE, 0, 0, NONE, 0, 0, 0]);
    assert_eq!(p.faces.face_ends, [3, 6, 9, 12]);
    // Without any, there is no list at all.
    let p = read(&format!("{THREE}f 1// 2// 3//\n"));
    assert!(p.faces.corner_t.is_empty() && p.faces.corner_n.is_empty());
}

#[test]
fn negative_indices_count_from_where_they_stand() {
    let p = read(&format!("{THREE}f -3 -2 -1\nv 5 5 5\nf -3 -2 -1\n"));
    assert_eq!(p.faces.corner_v, [0, 1, 2, 1, 2, 3]);
}

#[test]
fn faces_may_come_before_their_vertices() {
    let p = read(&format!("f 1 2 3\n{THREE}"));
    assert_eq!(p.faces.corner_v, [0, 1, 2]);
}

#[test]
fn every_refusal_names_its_line() {
    for (source, line, problem) in [
        (format!("{THREE}f 1 2 4\n"), "line 4", "position 4 does not exist (the file has 3)"),
        (format!("f 1 2 3\nf 1 2 9\nf 1 2 8\n{THREE}"), "line 2", "position 9 does not exist"),
        (format!("{THREE}vt 0 0\nf 1/1 2/2 3/1\n"), "line 5", "texture coordinate 2 does not"),
        (format!("{THREE}vn 0 0 1\nf 1//1 2//2 3//1\n"), "line 5", "normal 2 does not exist"),
        (format!("{THREE}f 0 1 2\n"), "line 4", "start at 1"),
        (format!("{THREE}f -4 1 2\n"), "line 4", "position -4 does not exist (the file has 3)"),
        (format!("{THREE}f 1 2 x\n"), "line 4", "`x`"),
        (format!("{THREE}f 1 2 3/1/1/1\n"), "line 4", "`3/1/1/1`"),
        (format!("{THREE}f 1 2 3.0\n"), "line 4", "`3.0`"),
        (format!("{THREE}f /1 2 3\n"), "line 4", "`/1`"),
        (format!("{THREE}f 1 2 99999999999999999999\n"), "line 4", "`9999"),
        (format!("{THREE}f 1 2 4294967296\n"), "line 4", "4294967296"),
        (format!("{THREE}f 1 2 4294967295\n"), "line 4", "4294967295"),
        ("# x\nv 0 0\n".to_owned(), "line 2", "three numbers"),
        ("v 0 0 zero\n".to_owned(), "line 1", "`zero`"),
        ("v 0 nan 0\n".to_owned(), "line 1", "not finite"),
        ("v 0 -inf 0\n".to_owned(), "line 1", "not finite"),
        ("v 0 1e39 0\n".to_owned(), "line 1", "not finite"),
        ("v 0 0 0\nvn 0 1\n".to_owned(), "line 2", "three numbers"),
        ("vt\n".to_owned(), "line 1", "at least one"),
        ("v 0 0 \\\n0\nv \\\n\n".to_owned(), "line 3", "three numbers"),
    ] {
        let error = refused(&source);
        assert_eq!(error.fault, Fault::Malformed, "{source}");
        assert_eq!(error.location, line, "{source}: {error}");
        assert!(error.problem.contains(problem), "{source}: {error}");
    }
}

#[test]
fn something_else_entirely_is_not_an_obj() {
    for source in ["hello world\nhow are you\n", "\0\0\0\x01\x02", "<html>"] {
        assert!(refused(source).problem.contains("not an OBJ file"), "{source}");
    }
    assert!(read("# only comments\n").faces.positions.is_empty());
    let p = read(&format!("hello\n{THREE}world\n"));
    assert_eq!(
        (p.notes.unknown.times, p.notes.unknown.line, p.notes.unknown_first.as_str()),
        (2, 1, "hello")
    );
}

#[test]
fn positions_may_have_weights_and_colours() {
    let p =
        read("v 0 0 0 1\nv 0 0 0 2\nv 0 0 0 9 9\nv 1 2 3 .1 .2 .3\nv 1 2 3 .1 .2 .3 .4\nv 1 1 1\n");
    assert_eq!(p.notes.weights.times, 1);
    assert_eq!((p.notes.extra_values.times, p.notes.extra_values.line), (1, 3));
    assert_eq!(p.faces.colors[3..], [[0.1, 0.2, 0.3, 1.0], [0.1, 0.2, 0.3, 0.4], [1.0; 4]]);
    assert_eq!(
        (p.faces.colors.len(), p.faces.color_has_alpha, p.notes.uncolored.times),
        (6, true, 4)
    );
    assert!(read("v 1 2 3\nv 1 2 3 1\n").faces.colors.is_empty());
    assert!(read("v 0 0 0 nan nan nan\n").faces.colors[0][0].is_nan());
}

#[test]
fn a_third_texture_coordinate_is_kept_if_it_says_anything() {
    assert!(read("vt 1 2 0\nvt 3 4\nvt 5\n").faces.texcoords_w.is_empty());
    let p = read("vt 1\nvt 3 4 7\nvt 5 6\n");
    assert_eq!(
        (p.faces.texcoords, p.faces.texcoords_w),
        (vec![[1.0, 0.0], [3.0, 4.0], [5.0, 6.0]], vec![0.0, 7.0, 0.0])
    );
}

#[test]
fn materials_groups_and_objects_make_runs() {
    let p = read(&format!(
        "{THREE}f 1 2 3\nusemtl a b \ng one\nf 1 2 3\nf 3 2 1\no box\nf 1 2 3\ng\nusemtl a b\n\
            f 1 2 3\nusemtl c\nf 1 2 3\n"
    ));
    let runs: Vec<_> = p.faces.runs.iter().map(|r| (r.first_face, r.material, r.label)).collect();
    assert_eq!(runs, [(0, NONE, NONE), (1, 0, 0), (3, 0, 1), (5, 1, 1)]);
    assert_eq!(
        (p.faces.materials, p.faces.labels),
        (vec!["a b".to_owned(), "c".to_owned()], vec!["one".to_owned(), "box".to_owned()])
    );
    assert_eq!(p.faces.objects, ["box"]);
}

#[test]
fn faces_that_are_none_are_counted_and_leave_nothing() {
    let p = read(&format!("{THREE}vt 0 0\nf 1/1 2/1\nf\nf 1\nl 1 2\np 1\nf 1 2 3\n"));
    assert_eq!((p.notes.small_faces.times, p.notes.lines.times, p.notes.points.times), (3, 1, 1));
    assert_eq!((p.faces.corner_v.len(), p.faces.face_ends), (3, vec![3]));
}

#[test]
fn limits_hold() {
    let few = Limits { vertices: 2, triangles: 2, line_bytes: 40, ..Limits::DEFAULT };
    for source in [THREE, "vt 0 0\nvt 0 0\nvt 0 0\n", "v 0 0 0\nf 1 1 1\nf 1 1 1\nf 1 1 1\n"] {
        assert_eq!(parse(source.as_bytes(), &few).expect_err(source).fault, Fault::Limit);
    }
    let long = format!("{THREE}f{}\n", " 1".repeat(50));
    let limits = Limits { line_bytes: 40, ..Limits::DEFAULT };
    assert_eq!(parse(long.as_bytes(), &limits).expect_err("long").fault, Fault::Limit);
    let libraries: String = (0..1001).map(|i| format!("mtllib {i}.mtl\n")).collect();
    assert_eq!(refused(&libraries).fault, Fault::Limit);
}

/// Reads a text in chunks of a size; the answer as text.
fn in_chunks(source: &str, size: usize) -> String {
    format!("{:?}", parse_chunks(source.as_bytes(), size, &Limits::DEFAULT, [false; 3]))
}

#[test]
fn chunks_of_any_size_read_the_same() {
    let good = "# all\nmtllib a.mtl\r\no box\rv 0 0 0\nv 1 0 \\\n 0\nv 1 1 0 .5 .5 .5\r\n\
                v 0 1 0 1 0 0 .5\nvt 0 0\nvt 1 0 .5\nvt 1\nvn 0 0 1\nusemtl red\ng one two\n\
                f 1 2 3\nf 1/1 2/2 3/3 4/1\nf -4//-1 -3//-1 -2//-1\nf 1/1/1 2/2/1 \\\r\n 3/3/1\n\
                hello\nusemtl blue\nl 1 2\nf 1 2\nv 2 2 2 2\nf -1 -2 -3\n# end \\\nf 5 4 3";
    assert!(parse(good.as_bytes(), &Limits::DEFAULT).is_ok());
    let bad = ["f 1 2 9", "f 1 2 -9\nv 0 0\nf 0", "v 1 2\nf 9 9 9", "vt", "f 1//4 2 3\nvn 0 0 0"];
    let sources = bad.map(|bad| format!("{good}\n{bad}\n{good}"));
    for source in sources.iter().map(String::as_str).chain([good]) {
        let whole = in_chunks(source, source.len());
        for size in 1..source.len() {
            assert_eq!(in_chunks(source, size), whole, "{size} bytes");
        }
    }
    assert_eq!(
        format!("{:?}", parse(format!("\u{feff}{good}").as_bytes(), &Limits::DEFAULT)),
        in_chunks(good, good.len())
    );
}
