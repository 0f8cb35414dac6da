//! Masks of small strips, worked out by hand in the manner of the thesis's figure 4.5; overflow;
//! cutting; storage.

use super::*;
use crate::cut;

/// One band of five triangles, and one triangle beside it:
///
/// ```text
///   1---3---5      record  collapse    1st strip      2nd strip
///  / \ / \ / \     0       0 → 2       2123 54…       –
/// 0---2---4---6
///      \ /
///       7
/// ```
#[test]
fn masks_worked_out_by_hand() {
    // Strip 0 is 0 1 2 3 4 5 6, turned as the picture has it; strip 1 is 2 7 4.
    let model = model(8, &[2, 3, 4, 5, 6, 6, 7], &[&[0, 1, 2, 3, 4, 5, 6], &[2, 7, 4]]);
    let masks = |record| {
        let of = |info: InfoStrip| {
            let len = model.strips().strip(info.strip as usize).len();
            (info.strip, bits(info.position_mask, len), bits(info.filter_mask, len))
        };
        model.info_strips(record).map(of).collect::<Vec<_>>()
    };
    let mask =
        |strip: u32, position: &str, filter: &str| (strip, position.to_owned(), filter.to_owned());
    // 2 1 2 3 4 5 6: the first triangle is gone, what is left starts at an odd place and needs one
    // index to turn.
    let [(0, position, filter)] = &masks(0)[..] else { panic!("{:?}", masks(0)) };
    assert_eq!((position.as_str(), filter.matches('1').count()), ("1000000", 7));
    // 2 3 2 3 4 5 6: an edge repeated, two indices less.
    let [(0, position, filter)] = &masks(1)[..] else { panic!("{:?}", masks(1)) };
    assert_eq!((position.as_str(), filter.matches('1').count()), ("0100000", 5));
    // 4 3 4 3 4 5 6, and 4 7 4: the second strip is not drawn any more and has no further masks.
    let both = masks(2);
    assert_eq!(both[0].1, "1010000");
    assert_eq!(both[0].2.matches('1').count(), 5);
    assert_eq!(both[1..], [mask(1, "000", "000")]);
    // 4 5 4 5 4 5 6: one triangle, three indices. Then nothing.
    assert_eq!(masks(3)[0].1, "0100000");
    assert_eq!(masks(3)[0].2.matches('1').count(), 3);
    assert_eq!(masks(4), [mask(0, "0000000", "0000000")]);
    assert_eq!((masks(5), masks(6)), (vec![], vec![]));
}

/// Masks alone, as a program without the rest would use them, draw what the model draws.
#[test]
fn the_tables_of_the_thesis_are_enough_to_go_both_ways() {
    for seed in 0..20 {
        let simplified = Arc::new(fixtures::random_collapse(&fixtures::random(seed), seed));
        let strips = Arc::new(Strips::generate(
            &simplified,
            lodc_strip::StripKind::Cache,
            lodc_strip::Effort::Fast,
        ));
        let model = Masking::build(&simplified, strips).expect("few entries");
        let updates: Vec<_> = model.info_updates().collect();
        assert_eq!(
            updates.len(),
            simplified.collapses().records() as usize,
            "no record of these is continued"
        );
        let mut full: Vec<Vec<u32>> = model.strips().iter().map(<[u32]>::to_vec).collect();
        let mut cursor = model.cursor();
        for (record, update) in updates.iter().enumerate() {
            for info in model.info_strips(record as u32) {
                for (at, v) in full[info.strip as usize].iter_mut().enumerate() {
                    if info.position_mask >> at & 1 == 1 {
                        assert_eq!(*v, record as u32);
                        *v = update.vertex;
                    }
                }
            }
            if update.next_update {
                continue;
            }
            model.seek(&mut cursor, Lod(record as u32 + 1), &mut ());
            for info in model.info_strips(record as u32) {
                let full = &full[info.strip as usize];
                let chosen =
                    (0..full.len()).filter(|at| info.filter_mask >> at & 1 == 1).map(|at| full[at]);
                assert_eq!(chosen.collect::<Vec<_>>(), cursor.strip(info.strip as usize));
            }
        }
    }
}

#[test]
fn a_record_that_changes_more_than_255_strips_is_continued() {
    // 1,000 separate triangles around vertex 0.
    let strips: Vec<[u32; 3]> = (0..1000).map(|k| [0, 2 * k + 1, 2 * k + 2]).collect();
    let strips: Vec<&[u32]> = strips.iter().map(|s| &s[..]).collect();
    let model = model(2001, &[2000; 2000], &strips);
    let updates: Vec<_> =
        model.info_updates().take(5).map(|u| (u.vertex, u.strips_affected)).collect();
    assert_eq!(updates, [(2000, 255), (2000, 255), (2000, 255), (2000, 235), (2000, 1)]);
    assert_eq!(model.info_strips(0).len(), 1000);
    let all: usize = model.info_updates().map(|u| usize::from(u.strips_affected)).sum();
    assert_eq!(all, (0..2000).map(|record| model.info_strips(record).len()).sum::<usize>());
    // Three more entries of five bytes each. A thousand strips end, which takes no masks.
    let cost = model.storage();
    assert_eq!(cost.structures, 5 * (2000 + 3) + 6 * all as u64 - 2 * 1000);
    // The first record ends the strip that has its target.
    assert_eq!(model.storage_to(Lod(1)).structures, 5 * 4 + 6 * 1000 - 2);
    assert_eq!(model.storage_to(Lod(0)).structures, 0);
}

#[test]
fn long_strips_are_cut_and_draw_the_same() {
    for len in [3, 15, 16, 17, 18, 30, 31, 32, 5000] {
        let strip: Vec<u32> = (0..len).collect();
        let other = [len, len + 1, len + 2, len + 3];
        let set = strip_set(&[&strip, &other]);
        let short = cut::cut(&set, 16).unwrap_or_else(|| set.set.clone());
        assert!(short.iter().all(|s| (3..=16).contains(&s.len())), "{len}");
        assert!(short.triangles().eq(set.triangles()), "{len}");
        assert_eq!(short.len() - 1, (len as usize - 2).div_ceil(14), "{len}");
    }
}

#[test]
fn strips_are_cut_where_they_turn() {
    let mut rng = fixtures::Rng::new(3);
    for len in 17..200 {
        let mut strip: Vec<u32> = (0..len).collect();
        for at in 2..len as usize {
            if rng.one_in(3) {
                strip[at] = strip[at - 2];
            }
        }
        let set = strip_set(&[&strip]);
        let short = cut::cut(&set, 16).expect("a long strip");
        assert!(short.iter().all(|s| (3..=16).contains(&s.len())), "{strip:?}");
        assert!(short.triangles().eq(set.triangles()), "{strip:?}");
        assert_eq!(short.len(), (len as usize - 2).div_ceil(14), "{strip:?}");
    }
    // Triangles 10 and 13 are degenerate. After an even number of them only the first of the two
    // can be the last.
    let strip = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 9, 12, 13, 14, 13, 16, 17];
    let short = cut::cut(&strip_set(&[&strip]), 16).expect("a long strip");
    assert_eq!(short.iter().collect::<Vec<_>>(), [&strip[..11], &strip[10..]]);
}

#[test]
fn nothing_is_drawn_without_triangles_and_never_more_than_strips() {
    let model = model(8, &[2, 3, 4, 5, 6, 6, 7], &[&[0, 1, 2, 3, 4, 5, 6], &[2, 7, 4]]);
    let mut cursor = model.cursor();
    let drawn = (0..=7).map(|lod| {
        model.seek(&mut cursor, Lod(lod), &mut ());
        (lod, model.drawn(&cursor), 3 * model.triangles(&cursor).len())
    });
    let drawn: Vec<_> = drawn.collect();
    assert_eq!(
        drawn,
        [
            (0, 10, 18),
            (1, 10, 15),
            (2, 8, 12),
            (3, 5, 6),
            (4, 3, 3),
            (5, 0, 0),
            (6, 0, 0),
            (7, 0, 0)
        ]
    );
}
